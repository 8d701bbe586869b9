"""Pictures of lit meshes, drawn with VTK's lighting off, and conversion of colours to other colour spaces."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from numbers import Real
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check, threads
from pvphong.base.color import xyz_from_rgb
from pvphong.base.display import Display, Tone
from pvphong.base.files import written_aside
from pvphong.meshes.blocks import leaves
from pvphong.meshes.colormaps import scale_of
from pvphong.meshes.point_data import opacity_at
from pvphong.meshes.surfaces import drawable, shallow_copy, surface
from pvphong.scene.viewer import Viewer

HEADLESS_PACKAGES = "libegl1 libgl1-mesa-dri libx11-6"
"""Packages that VTK needs on Debian or Ubuntu without a display."""

WITHOUT_DISPLAY = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")
"""VTK's classes of windows that need no display."""

TRANSPARENT = "transparent"
"""Background of a picture whose fourth channel tells how much of each pixel is covered."""

_AT_ONCE = 2**14  # number of colours that are converted at once: few enough to stay in the caches
_LARGEST = 8192  # pixels; the limit of drivers is 8192 or 16384
_CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"

_PLAIN = Display()

_TRIAL = """
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
import vtkmodules.vtkRenderingOpenGL2
window, renderer, pixels = vtkRenderWindow(), vtkRenderer(), vtkUnsignedCharArray()
window.SetOffScreenRendering(True)
window.SetSize(8, 8)
renderer.SetBackground(1, 1, 1)
window.AddRenderer(renderer)
window.Render()
window.GetPixelData(0, 0, 7, 7, 0, pixels, 0)
print(window.GetClassName(), pixels.GetRange(0)[0])
"""


def draw(
    lit: pv.PolyData | pv.MultiBlock,
    viewer: Viewer,
    *,
    name: str = "phong",
    size: tuple[int, int] = (1024, 768),
    background: str = "white",
    display: Display = _PLAIN,
) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Draw a lit mesh as the viewer sees it.

    Parameters
    ----------
    lit : pyvista.PolyData or pyvista.MultiBlock
        A mesh with lit colours as a point array.
    viewer : Viewer
        The viewer. Its clipping range is ignored; all geometry in front of the eye is drawn.
    name : str, default "phong"
        Name of the array with the colours.
    size : tuple of int, default (1024, 768)
        Width and height in pixels.
    background : str, default "white"
        A colour name or hex string, or "transparent".
    display : Display, optional
        Transform that shows the colours.

    Returns
    -------
    ndarray
        Shape (height, width, 3), uint8; (height, width, 4) with a transparent background. If the mesh is out of view,
        only the background is drawn.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine (the message names the missing packages), or for an invalid size or
        background.
    """
    window = drawing_window()
    refuse_size(size)
    is_transparent = background == TRANSPARENT
    if not is_transparent:
        check.color("background", background)
    with preferring(window), pv.vtk_verbosity("off"):
        plotter = pv.Plotter(off_screen=True, window_size=list(size))
        try:
            plotter.set_background("black" if is_transparent else background)
            aim(plotter, viewer)
            for mesh in leaves(lit):
                plotter.add_mesh(
                    displayed(mesh, name, display), scalars=name, rgb=True, lighting=False, copy_mesh=False
                )
            plotter.enable_anti_aliasing("ssaa")
            plotter.renderer.ResetCameraClippingRange()
            return np.asarray(plotter.screenshot(return_img=True, transparent_background=is_transparent))
        finally:
            plotter.close()


def plot(
    mesh: pv.DataSet, /, *, name: str = "phong", exposure: float = 0.0, tone: Tone = "none", **options: Any
) -> Any:
    """Show a lit mesh with PyVista's `plot` and its options; colours are clipped to [0, 1].

    Parameters
    ----------
    mesh : pyvista.DataSet
        A mesh with lit colours.
    name : str, default "phong"
        Name of the array with the colours.
    exposure : float, default 0
        Brightness of the picture in stops; see `Display`. Colours that the light model has clamped stay clamped.
    tone : {"none", "filmic"}
        Curve for bright colours; see `Display`.
    **options
        As for `pyvista.plot`, such as `screenshot`, `cpos`, `show_edges` or `opacity`. Options that colour a mesh are
        refused. If the unlit colours come from a `Colormap`, its scalar bar is shown; `show_scalar_bar` and
        `scalar_bar_args` control it.

    Raises
    ------
    ValueError
        If the mesh has no point array of that name, or an option would colour the mesh.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight())
    >>> lit.phong.plot(off_screen=True)
    """
    refuse_colouring(options)
    refuse_unlit(mesh, name)
    display, scale = Display(exposure, tone), scale_of(mesh, name)
    drawn = with_opacity(mesh, name, vertex_opacity(options), display)
    shows_bar, bar = options.pop("show_scalar_bar", pv.global_theme.show_scalar_bar), options.pop("scalar_bar_args", {})
    colors = {"rgb": True, "lighting": False, "scalars": name}
    if scale is None or not shows_bar:
        return drawn.plot(**colors, **options)
    title, table = scale
    plotter, shown = _plotter(options)
    plotter.add_mesh(drawn, **colors, **options)
    plotter.add_scalar_bar(**{"title": title, "lookup_table": table, "n_labels": 0 if table.annotations else 5} | bar)
    return shown(plotter)


def _plotter(options: dict[str, Any]) -> tuple[pv.Plotter, Callable[[pv.Plotter], Any]]:
    """Return a plotter with the options of `pyvista.plot`, and a function that shows it and returns the result.

    Options of the plotter and of its method `show` are removed from `options`; options of `add_mesh` stay there.
    `pyvista.plot` itself cannot add a scalar bar to a mesh with RGB colours.
    """

    def taken(*names: str) -> dict[str, Any]:
        return {name: options.pop(name) for name in names if options.get(name) is not None}

    plotter = pv.Plotter(**taken(*_OF_PLOTTER))
    view, showing = taken(*_OF_VIEW), taken(*_OF_SHOWING)
    axes = plotter.theme.axes
    if view.get("show_axes", axes.show):
        plotter.add_box_axes() if axes.box else plotter.add_axes()
    if "background" in view:
        plotter.set_background(view["background"])
    if "anti_aliasing" in view:
        kind = view["anti_aliasing"]
        plotter.enable_anti_aliasing("msaa" if kind is True else kind) if kind else plotter.disable_anti_aliasing()
    for option, enable in (
        ("edl", plotter.enable_eye_dome_lighting),
        ("eye_dome_lighting", plotter.enable_eye_dome_lighting),
        ("parallel_projection", plotter.enable_parallel_projection),
        ("ssao", plotter.enable_ssao),
    ):
        if view.get(option):
            enable()

    def show(plotter: pv.Plotter) -> Any:
        if view.get("text"):
            plotter.add_text(view["text"])
        if view.get("show_grid"):
            plotter.show_grid()
        elif view.get("show_bounds"):
            plotter.show_bounds()
        plotter.camera_position = view.get("cpos", plotter.get_default_cam_pos())
        plotter.camera_set = "cpos" in view
        if "zoom" in view:
            plotter.camera.zoom(view["zoom"])
        return plotter.show(**showing)

    return plotter, show


_OF_PLOTTER = ("window_size", "off_screen", "notebook", "theme", "border", "border_color", "border_width")
_OF_VIEW = (
    *("cpos", "zoom", "background", "show_axes", "text", "show_grid", "show_bounds", "anti_aliasing"),
    *("edl", "eye_dome_lighting", "parallel_projection", "ssao"),
)
_OF_SHOWING = (
    *("auto_close", "interactive", "full_screen", "screenshot", "return_img", "return_viewer", "return_cpos"),
    *("before_close_callback", "jupyter_backend", "jupyter_kwargs"),
)
"""These three tuples are the options of `pyvista.plot` that `add_mesh` does not have."""

_COLOURING = (
    *("scalars", "rgb", "rgba", "lighting", "color", "smooth_shading", "texture", "pbr", "cmap", "copy_mesh"),
    *("ambient", "diffuse", "specular", "specular_power", "metallic", "roughness", "clim", "log_scale", "multi_colors"),
    *("split_sharp_edges", "interpolation", "backface_params"),
)
"""PyVista's options that colour a mesh."""


def refuse_colouring(options: Mapping[str, Any], remedy: str = "The colours come from the array `name`.") -> None:
    """Raise ``ValueError`` for options of `pyvista.Plotter.add_mesh` that would colour a mesh.

    `remedy` is the sentence that ends the message. Other options are not checked here, but by PyVista.
    """
    for option in options:
        if option in _COLOURING:
            if option == "smooth_shading":
                remedy = "Colours are interpolated between vertices; for flat faces, use shade(feature_angle=0)."
            check.refuse("option", option, f"an option of add_mesh other than {', '.join(_COLOURING)}", remedy)


def vertex_opacity(options: dict[str, Any]) -> Any:
    """Remove opacities per vertex from the options of `add_mesh`, and return them: an array, or an array's name.

    If the option is a single number or missing, return None and leave the options unchanged. PyVista has no opacities
    per vertex for meshes with RGB colours; `with_opacity` adds them.
    """
    if isinstance(options.get("opacity"), Real | np.number | None):
        return None
    if options.pop("use_transparency", False):
        check.refuse("use_transparency", True, "False if opacity is an array", "Pass opacity=1 - transparency instead.")
    return options.pop("opacity")


def displayed(mesh: pv.DataSet, name: str, display: Display) -> pv.DataSet:
    """Return a copy of a mesh to draw. The display transform is applied to its colours, the point array `name`."""
    if display == _PLAIN:
        return drawable(mesh, name)
    result, colors = mesh.copy(deep=False), np.asarray(mesh.point_data[name])
    result.point_data[name] = display(colors / 255.0 if colors.dtype == np.uint8 else colors)
    return result


def with_opacity(mesh: pv.DataSet, name: str, opacity: Any, display: Display = _PLAIN) -> pv.DataSet:
    """Return a copy of a mesh to draw. The display transform is applied to its colours, the point array `name`.

    `opacity` is the result of `vertex_opacity`. If it is not None, it becomes the colours' fourth channel.
    """
    if opacity is None:
        return displayed(mesh, name, display)
    source = surface(mesh)
    result = displayed(source, name, display)
    colors = np.asarray(result.point_data[name])
    colors = colors / 255.0 if colors.dtype == np.uint8 else colors
    result.point_data[name] = np.column_stack([colors, opacity_at(opacity, mesh, source, source, None)])
    return result


def refuse_unlit(mesh: pv.DataSet, name: str) -> None:
    """Raise ``ValueError`` if a mesh has no point array `name`, the array of its lit colours."""
    if name == "phong" and name not in mesh.point_data:
        allowed = "lit, with colours in its point array 'phong' or in the array given as `name`"
        remedy = "Light it first: mesh.phong.shade(...).phong.plot()."
        check.refuse("mesh", "a mesh without colours", allowed, remedy)
    check.choice("name", name, mesh.point_data.keys())


def refuse_size(size: tuple[int, int]) -> None:
    """Raise ``ValueError`` if a picture cannot have this width and height, in pixels."""
    for label, pixels in zip(("width", "height"), size, strict=True):
        check.number(label, pixels, at_least=1, at_most=_LARGEST)


def save_picture(image: np.ndarray[Any, np.dtype[np.uint8]], path: Path) -> None:
    """Write an image as a .png file, atomically."""
    from PIL import Image

    with written_aside(path) as aside:
        Image.fromarray(image).save(aside, format="PNG", optimize=True)


@cache
def drawing_window() -> str:
    """Return the name of the class of windows with which VTK can draw on this machine.

    Drawing is tried once, in a child process, because VTK crashes the process if a library is missing.

    Raises
    ------
    ValueError
        If VTK cannot draw; the message names the required packages.
    """
    trial = subprocess.run([sys.executable, "-c", _TRIAL], capture_output=True, text=True, check=False)
    name, _, brightness = trial.stdout.strip().partition(" ")
    if trial.returncode != 0 or brightness != "255.0":
        raise ValueError(
            "VTK cannot draw on this machine. Without a display it needs EGL or OSMesa, a software driver and "
            f"libX11: on Debian and Ubuntu, apt-get install {HEADLESS_PACKAGES}."
        )
    return name


@contextmanager
def preferring(window: str) -> Iterator[None]:
    """Return a context in which VTK opens windows of the class with the name `window`.

    Without this context, VTK searches for a display first, and prints errors if it finds none.
    """
    if window not in WITHOUT_DISPLAY or _CHOICE in os.environ:
        yield
        return
    os.environ[_CHOICE] = window
    try:
        yield
    finally:
        del os.environ[_CHOICE]


def aim(plotter: pv.Plotter | pv.Renderer, viewer: Viewer) -> None:
    """Set the camera of a plotter or renderer to a viewer. The camera stays there when meshes are added."""
    camera = plotter.camera
    camera.SetPosition(viewer.position)
    camera.SetFocalPoint(viewer.focal_point)
    camera.SetViewUp(viewer.up)
    camera.SetParallelProjection(viewer.parallel)
    camera.SetViewAngle(viewer.view_angle)
    camera.SetParallelScale(viewer.parallel_scale)
    plotter.camera_set = True


ColorSpace = Literal["hsv", "xyz"]


def color_view(mesh: pv.DataSet, space: ColorSpace, *, name: str = "phong") -> pv.PolyData:
    """Convert lit colours to another colour space, as the point array ``NAME_SPACE`` of a new mesh.

    The colours are linear red, green and blue with sRGB's primaries, as from `mesh.phong.shade`.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A lit mesh, as from `mesh.phong.shade`; it is not modified. If it is not a PolyData, its surface is used.
    space : {"hsv", "xyz"}
        "hsv": hue, saturation and value. Hue is 0 for red, 1/3 for green, 2/3 for blue, and 0 for greys. Saturation is
        0 for greys and at most 1. Value is the largest channel, and exceeds 1 for bright colours. Hue and saturation do
        not depend on brightness. Source: Matplotlib's `rgb_to_hsv`, applied after colours above 1 are scaled down.
        "xyz": CIE X, Y and Z, where white, D65, has luminance 1; Y is the relative luminance. Source: IEC 61966-2-1.
    name : str, default "phong"
        Name of the point array of colours, shape (n_points, 3), floats >= 0.

    Returns
    -------
    pyvista.PolyData
        A mesh whose active scalars are the new array, of the same type as the colours. It shares all other data with
        `mesh`, like results of `shade`.

    Raises
    ------
    ValueError
        If the array or the space does not exist, or the array does not hold such colours.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight())
    >>> luminance = lit.phong.color_view("xyz")["phong_xyz"][:, 1]
    >>> round(float(luminance.min()), 2)
    0.04
    """
    check.choice("space", space, get_args(ColorSpace))
    source = mesh if isinstance(mesh, pv.PolyData) else surface(mesh)
    colors: Any = np.asarray(source.point_data[check.choice("name", name, source.point_data.keys())])
    allowed = "an array of lit colours: three floats >= 0 per point"
    if colors.shape != (source.n_points, 3) or colors.dtype.kind != "f":
        check.refuse("name", f"{name}, a {colors.dtype} array of shape {colors.shape}", allowed)
    if not (colors.min(initial=0.0) >= 0.0 and colors.max(initial=0.0) < np.inf):  # false for NaN
        check.refuse("name", f"{name}, an array with a negative number, NaN or infinity", allowed)
    if space == "xyz":
        converted = xyz_from_rgb(colors)
    else:  # Matplotlib needs colours up to 1; scaling down a brighter one changes neither hue nor saturation
        from matplotlib.colors import rgb_to_hsv

        converted = np.empty_like(colors)

        def convert(first: int, last: int) -> None:
            some, into = colors[first:last], converted[first:last]
            red, green, blue = some.T
            above = np.maximum(np.maximum(np.maximum(red, green), blue), some.dtype.type(1.0))[:, None]
            into[:] = rgb_to_hsv(some / above)
            into[:, 2:] *= above

        threads.run(convert, len(colors), _AT_ONCE)
    result = shallow_copy(source)
    result.point_data[f"{name}_{space}"] = converted
    result.set_active_scalars(f"{name}_{space}", preference="point")
    return result
