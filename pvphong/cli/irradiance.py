"""`pvphong irradiance`: light that arrives at a mesh, in the unit of the lights, as a file and as a picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyvista as pv
from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.processes import reading
from pvphong.base.types import Float64Array
from pvphong.base.vectors import unit
from pvphong.cli.options import SIZE, Flag, busy, parsed, seeing
from pvphong.meshes.blocks import leaves, map_blocks
from pvphong.meshes.colormaps import scale_of_light
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.files import Compression, read_mesh, refuse_suffix, save_lit
from pvphong.meshes.irradiance import ALBEDO, Per
from pvphong.meshes.pictures import aim, drawing_window, preferring, refuse_size, save_picture
from pvphong.meshes.surfaces import FeatureAngle, has_faces, surface
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer

_FORMATS = ".vtp", ".vtk", ".vtkhdf", ".vtm", ".vtmb"
_COMPRESSED = ".vtp", ".vtm", ".vtmb"

# Distance of isolines from the surface towards the eye, as a fraction of the mesh's size; and their largest number.
_RAISED, _MOST_LINES = 2e-3, 20
# Part of the picture's width to the right of the mesh, where the scalar bar is.
_FOR_BAR = 0.15
# Size of the largest font as a fraction of the picture's height.
_FONT = 0.024


def irradiance(
    mesh: str,
    /,
    *,
    scene: Path,
    output: Annotated[str | None, Parameter(name=["--output", "-o"])] = None,
    plot: Path | None = None,
    per: Per = "vertex",
    shadows: Flag = False,
    bounces: int | None = None,
    albedo: str | None = None,
    occluder: Annotated[tuple[str, ...], Parameter(negative="", show_default=False)] = (),
    feature_angle: Annotated[FeatureAngle, Parameter(show_choices=False)] = "auto",
    array: str = "irradiance",
    unit: str = "lux",
    isolines: str | None = None,
    most: float | None = None,
    size: Annotated[tuple[int, int] | None, Parameter(negative="")] = None,
    compress: Compression | None = None,
) -> int:
    """Compute the light that arrives at a mesh, in the unit of the lights, whatever the mesh is made of.

    With candela and metres, the result is in lux. Surfaces seen from behind are left out of the picture, so that one
    looks into a room whose walls face inwards.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    scene
        Rig file (JSON) with lights, viewer and light model, as Scene.save writes it.
    output
        File to write: .vtp, .vtk or .vtkhdf for a mesh; .vtm, .vtmb or .vtkhdf for several blocks. It has an array of
        the whole irradiance, one for each light and, with bounces, one for light from other surfaces.
    plot
        Picture to write, a .png with a scalar bar.
    per
        vertex: arrays of points. face: arrays of cells, the means over the faces.
    shadows
        Add shadows, if the rig has none. Blocks shadow each other.
    bounces
        Number of diffuse reflections between surfaces. Default: that of the rig.
    albedo
        Fraction of light that surfaces reflect, for bounces: a number, three numbers as in 0.5,0.4,0.3, the name of a
        colour or of a point array, or an image file. Default: 0.5.
    occluder
        File with another mesh that casts shadows; may be repeated.
    feature_angle
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. "auto": 30 if the
        mesh has no point normals, otherwise no sharp edges. "none": no sharp edges.
    array
        Name of the array.
    unit
        Unit of the lights, for the scalar bar.
    isolines
        Values at which the picture has lines, as in 300,500.
    most
        Largest value of the scalar bar. Default: a round number above the largest value.
    size
        Width and height of the picture in pixels. Default: 1024 768.
    compress
        Compression of arrays in .vtp, .vtm and .vtmb files. Default: lz4.
    """
    if output is None and plot is None:
        check.refuse("--output", "no output", "given, or --plot", "For example, -o lux.vtp or --plot lux.png.")
    target = None if output is None else Path(output)
    if target is not None:
        refuse_suffix(target, "a mesh with irradiance", _FORMATS)
    if compress is not None and (target is None or target.suffix.lower() not in _COMPRESSED):
        check.refuse("--compress", compress, f"used with {', '.join(_COMPRESSED)} only")
    for option, given in {"--isolines": isolines, "--most": most, "--size": size}.items():
        if given is not None and plot is None:
            check.refuse(option, given, "used with --plot")
    levels, size = _levels(isolines), size or SIZE
    if plot is not None:
        refuse_suffix(plot, "a picture", (".png",))
        refuse_size(size)
    if most is not None:
        most = check.number("--most", most, above=0.0)
    rig = Scene.load(scene)
    with reading(mesh):
        read = read_mesh(mesh)
        outside = map_blocks(read, surface) if isinstance(read, pv.MultiBlock) else surface(read)
    framed = scene_for(outside, rig)
    model = replace(framed.light_model, shadows=framed.light_model.shadows or shadows)
    if occluder and not (model.shadows or bounces or model.bounces):
        check.refuse("--occluder", occluder[0], "used with shadows or bounces", "Add --shadows.")
    how: dict[str, Any] = {"per": per, "bounces": bounces, "name": array, "feature_angle": feature_angle}
    how["albedo"] = ALBEDO if albedo is None else parsed(albedo)
    with busy(f"Irradiance of {mesh}"):
        others = [read_mesh(path) for path in occluder]
        lit = outside.phong.irradiance(replace(framed, light_model=model), occluders=others, **how)
        if target is not None:
            save_lit(lit, target, array, compress or "lz4")
        if plot is not None:
            save_picture(_picture(lit, seeing(framed, outside, size), array, unit, levels, most, size), plot)
    for path in filter(None, (target, plot)):
        print(path)
    return 0


def _levels(text: str | None) -> list[float]:
    """Parse the option --isolines, numbers separated by commas, and return the numbers; none if `text` is None."""
    if text is None:
        return []
    try:
        levels = sorted({float(part) for part in text.split(",")})
    except ValueError:
        levels = []
    if not levels or not 0.0 < levels[0] <= levels[-1] < np.inf or len(levels) > _MOST_LINES:
        allowed = f"one to {_MOST_LINES} numbers > 0 separated by commas"
        check.refuse("--isolines", text, allowed, "For example, --isolines 300,500.")
    return levels


def _picture(
    lit: Any, scene: Scene, name: str, unit: str, levels: list[float], most: float | None, size: tuple[int, int]
) -> Any:
    """Draw the luminance of the irradiance in colours, with a scalar bar and isolines; return the pixels.

    Parameters
    ----------
    lit : pyvista.PolyData or pyvista.MultiBlock
        Mesh with the array of irradiances.
    scene : Scene
        Scene with a viewer, from which the mesh is drawn.
    name, unit : str
        Name of the array, and unit of its values.
    levels : list of float
        Values of the isolines.
    most : float or None
        Largest value of the scalar bar; None for a round number.
    size : (int, int)
        Width and height of the picture in pixels.
    """
    assert scene.viewer is not None
    quantity = "Illuminance" if unit in ("lux", "lx") else "Irradiance"
    font = max(round(_FONT * size[1]), 9)
    bar: dict[str, Any] = {"title": f"{quantity}\n({unit})\n", "fmt": "%.4g"}
    bar |= {"n_labels": 6, "color": "black", "vertical": True, "position_x": 0.87, "position_y": 0.1}
    bar |= {"width": 0.06, "height": 0.75, "title_font_size": font, "label_font_size": font - 2}
    meshes = leaves(lit)
    values: list[Float64Array] = [np.asarray(mesh[name], np.float64) @ XYZ_OF_RGB[1] for mesh in meshes]
    look = scale_of_light(max(float(each.max(initial=0.0)) for each in values), most)
    look |= {"lighting": False, "scalar_bar_args": bar, "culling": "back", "copy_mesh": False}
    with preferring(drawing_window()), pv.vtk_verbosity("off"):
        plotter = pv.Plotter(off_screen=True, window_size=list(size))
        try:
            plotter.set_background("white")
            aim(plotter, scene.viewer)
            plotter.camera.SetWindowCenter(_FOR_BAR, 0.0)
            plotter.camera.zoom(1.0 - _FOR_BAR)
            for mesh, row in zip(meshes, values, strict=True):
                bare = pv.PolyData()
                bare.copy_structure(mesh)
                data = bare.cell_data if name in mesh.cell_data else bare.point_data
                data["pvphong_shown"] = row
                plotter.add_mesh(bare, scalars="pvphong_shown", **look)
                _add_lines(plotter, bare, levels, scene.viewer, unit, font - 2)
            plotter.enable_anti_aliasing("ssaa")
            plotter.renderer.ResetCameraClippingRange()
            return np.asarray(plotter.screenshot(return_img=True))
        finally:
            plotter.close()


def _add_lines(
    plotter: pv.Plotter, mesh: pv.PolyData, levels: list[float], viewer: Viewer, unit_name: str, font: int
) -> None:
    """Add isolines of the shown values to a picture, on faces that the viewer sees.

    Each line is labelled once, on its longest part. `levels` are the values of the lines, `unit_name` their unit, and
    `font` is the size of the labels.
    """
    of_points = mesh if "pvphong_shown" in mesh.point_data else mesh.cell_data_to_point_data()
    if not levels or not has_faces(of_points):
        return
    as_they_are = dict.fromkeys(("point_normals", "auto_orient_normals", "consistent_normals"), False)
    faces = of_points.compute_normals(**as_they_are)
    facing = _towards(viewer, faces.cell_centers().points) * faces.cell_data["Normals"]
    seen = faces.extract_cells(np.flatnonzero(facing.sum(axis=1) > 0.0))
    for level in levels if seen.n_cells else ():
        lines = seen.contour([level], scalars="pvphong_shown")
        if not lines.n_points:
            continue
        lines.points += _RAISED * mesh.length * _towards(viewer, lines.points)
        plotter.add_mesh(lines, color="black", line_width=2.5, lighting=False)
        longest = lines.connectivity("largest")
        middle = longest.points[len(longest.points) // 2]
        label = {"font_size": font, "text_color": "black", "shape_color": "white", "shape_opacity": 0.8, "margin": 2}
        plotter.add_point_labels([middle], [f"{level:g} {unit_name}"], show_points=False, always_visible=True, **label)


def _towards(viewer: Viewer, points: Any) -> Float64Array:
    """Return unit vectors from points to the viewer, shape (n, 3)."""
    if viewer.parallel:
        return np.broadcast_to(-np.array(viewer.view_direction), points.shape)
    return unit((np.array(viewer.position) - points).T)[0].T
