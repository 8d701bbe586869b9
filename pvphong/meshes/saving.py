"""`lit.phong.save`: writes lit meshes. VTK's formats hold all arrays, other formats only the colours."""

from __future__ import annotations

import os
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.color import srgb_from_linear
from pvphong.base.display import Display
from pvphong.base.files import written_aside
from pvphong.base.types import FloatArray, rgb
from pvphong.meshes import gltf
from pvphong.meshes.blocks import DEFAULT, datasets, materials_of
from pvphong.meshes.colormaps import over_all
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, Compression, save_lit
from pvphong.meshes.pictures import draw, refuse_unlit, save_picture
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import polygons, surface
from pvphong.optics.maps import fractions, map_values
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.scene.scene import SceneLike, as_scene
from pvphong.scene.viewer import Viewer

Encoding = Literal["linear", "srgb"]
"""Encoding of colours in a format that does not define it."""

SAVED_MESHES = (*MESH_FORMATS, ".glb", ".gltf", ".obj", ".png")
SAVED_BLOCKS = (*BLOCK_FORMATS, ".glb", ".gltf", ".png")

_COMPRESSED, _ENCODED, _GLTF = (".vtp", ".vtm", ".vtmb"), (".ply", ".obj"), (".glb", ".gltf")
_SIZE = 1024, 768


def save(
    lit: pv.DataSet | pv.MultiBlock,
    path: str | os.PathLike[str],
    *,
    name: str = "phong",
    encoding: Encoding = "linear",
    compress: Compression | None = None,
    lights: SceneLike | None = None,
    material: Material | str | Mapping[str, Material | str] = DEFAULT_MATERIAL,
    viewer: Viewer | None = None,
    size: tuple[int, int] | None = None,
    background: str | None = None,
    display: Display | None = None,
) -> None:
    """Write a lit mesh for other programs. The suffix of the path determines the format.

    - .vtp, .vtk and .vtkhdf hold all arrays unchanged.
    - .vtm, .vtmb and .vtkhdf hold all arrays of a MultiBlock; next to a .vtm or .vtmb is a folder with the blocks.
    - .ply holds the colours as 8-bit red, green and blue of its vertices, .obj as three numbers after each position.
    - .glb and .gltf hold positions, normals and linear 16-bit colours as `COLOR_0`, marked `KHR_materials_unlit` so
      that viewers do not light them again.
    - .png is a picture.

    Colours are clipped to [0, 1] in formats that cannot hold other values.

    Parameters
    ----------
    lit : pyvista.DataSet or pyvista.MultiBlock
        A mesh from `mesh.phong.shade` or `refine`; it is not modified. With `lights` it may be any mesh.
    path : path
        The file. An existing file is replaced when the new file is complete.
    name : str, default "phong"
        Name of the point array with the colours.
    encoding : {"linear", "srgb"}, default "linear"
        Encoding of the colours in .ply and .obj; these formats do not define one. Use "linear" for programs that show
        the numbers unchanged, such as MeshLab: colours then look as in `plot`. Use "srgb" for programs that convert
        sRGB to linear, as Blender does for 8-bit colours.
    compress : {"lz4", "zlib", "none"}, optional
        Compression of arrays in .vtp, .vtm and .vtmb; by default LZ4.
    lights : Scene, light or sequence of lights, optional
        Lights to write into .glb or .gltf, with `KHR_lights_punctual`, so that the viewer program lights the mesh. The
        colours are then the diffuse colours of `material`, and the mesh need not be lit.
    material : Material, str or mapping, optional
        Material for use with `lights`; by default OpenGL's.
    viewer : Viewer, optional
        Viewer of a .png; by default PyVista's default camera, which frames the mesh.
    size : (int, int), optional
        Width and height of a .png in pixels; by default 1024 by 768.
    background : color, optional
        Background of a .png; by default white. With "transparent", the .png has a fourth channel, which is 0 where no
        mesh is.
    display : Display, optional
        Transform that shows the colours in a .png, with exposure and tone curve; all other formats stay linear.

    Raises
    ------
    ValueError
        If the suffix is unknown, an option does not apply to the format, the colours do not exist, or the file cannot
        be written.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> pv.Sphere().phong.shade(ph.DirectionalLight()).phong.save("ball.glb")
    """
    target, suffix = Path(path), Path(path).suffix.lower()
    is_blocks = isinstance(lit, pv.MultiBlock)
    allowed = SAVED_BLOCKS if is_blocks else SAVED_MESHES
    if suffix not in allowed:
        what = "a MultiBlock" if is_blocks else "a single mesh"
        remedy = "Merge the blocks with blocks.combine()." if suffix in SAVED_MESHES and is_blocks else ""
        check.refuse("path", target, f"a file for the colours of {what} ({', '.join(allowed)})", remedy)
    check.choice("encoding", encoding, get_args(Encoding))
    for option, given, formats in (
        ("encoding", None if encoding == "linear" else encoding, _ENCODED),
        ("compress", compress, _COMPRESSED),
        ("lights", lights, _GLTF),
        ("viewer", viewer, (".png",)),
        ("size", size, (".png",)),
        ("background", background, (".png",)),
        ("display", display, (".png",)),
    ):
        if given is not None and suffix not in formats:
            check.refuse(option, given, f"left out for {suffix}", f"It applies to {' and '.join(formats)}.")
    if lights is not None:
        _save_with_lights(lit, target, lights, material)
        return
    meshes = dict(datasets(lit)) if isinstance(lit, pv.MultiBlock) else {"": lit}
    for mesh in meshes.values():
        refuse_unlit(mesh, name)
    if suffix == ".png":
        seen = viewer or Viewer.framing(lit.bounds)
        look: dict[str, Any] = {"background": background or "white", "display": display or Display()}
        save_picture(draw(lit, seen, name=name, size=size or _SIZE, **look), target)
    elif suffix in _GLTF:
        parts = [gltf.Part(block, _drawn(mesh), _colors(mesh, name)) for block, mesh in meshes.items()]
        with written_aside(target) as aside:
            gltf.write(aside, parts)
    elif suffix == ".obj":
        with written_aside(target) as aside:
            _write_obj(aside, _drawn(meshes[""]), _encoded(_colors(meshes[""], name), encoding))
    elif suffix == ".ply" and encoding == "srgb":
        encoded = meshes[""].copy(deep=False)
        encoded.point_data[name] = _encoded(_colors(encoded, name), encoding)
        save_lit(encoded, target, name)
    else:
        save_lit(lit, target, name, compress or "lz4")


def _drawn(mesh: pv.DataSet) -> pv.PolyData:
    """Return the mesh unchanged if it is a PolyData, like the results of `shade`. Raise ValueError for any other
    dataset.
    """
    if not isinstance(mesh, pv.PolyData):
        check.refuse("lit", f"a {type(mesh).__name__}", "a PolyData, as returned by mesh.phong.shade")
    return mesh


def _colors(mesh: pv.DataSet, name: str) -> FloatArray:
    colors = np.asarray(mesh.point_data[name])
    return colors / 255.0 if colors.dtype == np.uint8 else np.clip(np.nan_to_num(colors), 0.0, 1.0)


def _encoded(colors: FloatArray, encoding: Encoding) -> FloatArray:
    return srgb_from_linear(colors) if encoding == "srgb" else colors


def _write_obj(path: Path, mesh: pv.PolyData, colors: FloatArray) -> None:
    """Write a mesh as a Wavefront file with a colour after each position. MeshLab and other programs read this form."""
    connectivity, offsets = polygons(mesh)
    with path.open("w", encoding="ascii") as file:
        np.savetxt(file, np.column_stack([mesh.points, colors]), "v %.9g %.9g %.9g %.6g %.6g %.6g")
        for begin, end in pairwise(offsets):
            file.write(f"f {' '.join(map(str, (connectivity[begin:end] + 1).tolist()))}\n")


def _save_with_lights(mesh: Any, target: Path, lights: SceneLike, material: Any) -> None:
    """Write a glTF file `target` with surfaces in their unlit diffuse colours, and with lights.

    `mesh`, `lights` and `material` are the arguments `lit`, `lights` and `material` of `save`.
    """
    is_blocks = isinstance(mesh, pv.MultiBlock)
    meshes = dict(datasets(mesh)) if is_blocks else {"": mesh}
    given = material if isinstance(material, Mapping) else {DEFAULT: material}
    own = {name: over_all(as_material(each), list(meshes.values())) for name, each in given.items()}
    materials = materials_of(list(meshes), own) if is_blocks else list(own.values())
    parts = []
    for (block, each), its in zip(meshes.items(), materials, strict=True):
        source, maps, _ = surface_and_maps(surface(each), its)
        color = np.ones((source.n_points, 3))
        for field in ("albedo", "diffuse"):
            rows = fractions(field, map_values(field, maps[field], source.n_points).rows) if field in maps else None
            color = color * (rgb(getattr(its, field)) if rows is None else rows)
        parts.append(gltf.Part(block, source, color))
    scene = as_scene(lights, lambda: mesh.bounds)
    with written_aside(target) as aside:
        gltf.write(aside, parts, scene, materials)
