"""`pvphong.evaluate` for Dask arrays: each chunk is a lazy task.

Dask decides how many chunks are lit at the same time. The evaluator starts no threads of its own in a task, so that no
more threads run than Dask has.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import wraps
from typing import Any, ParamSpec, cast

import numpy as np

from pvphong.base import check, threads
from pvphong.base.types import Float64Array
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import Map
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene, as_scene
from pvphong.shading import evaluation, kernel
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Vertices

Given = ParamSpec("Given")

_VISIBILITY = "visibility"
"""Name of the only array with vertices along its second axis: shape (lights + 1, n)."""

_ARGUMENTS = ("points", "normals", _VISIBILITY)
"""Arguments of `evaluate` that are arrays. All other arrays are maps of the material."""


def _taking_chunks(whole: Callable[Given, Shading]) -> Callable[Given, Shading]:
    """Return a function like `whole` that also accepts Dask arrays; `whole` is `evaluation.evaluate`."""

    @wraps(whole)
    def evaluate(points: Any, normals: Any, scene: Any, material: Any, **options: Any) -> Shading:
        named = {"points": points, "normals": normals, "scene": scene, "material": _with_colors(material)} | options
        arrays = _arrays_of(named)
        if any(hasattr(array, "__dask_graph__") for array in arrays.values()):
            return _evaluate_chunks(arrays, **{name: value for name, value in named.items() if name not in arrays})
        return whole(points, normals, scene, material, **options)

    return cast("Callable[Given, Shading]", evaluate)


evaluate = _taking_chunks(evaluation.evaluate)


def _arrays_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arrays with a row per vertex, by name: from arguments, and from the material's maps and tangents.

    `given` has all arguments of `evaluate` by name.
    """
    found = {name: given.get(name) for name in _ARGUMENTS}
    material = given.get("material")
    if isinstance(material, Material):
        maps = material.maps | {"tangents": material.tangents}
        found |= {name: each.source for name, each in maps.items() if isinstance(each, Map)}
    return {name: array for name, array in found.items() if array is not None}


def _with_colors(material: Any) -> Any:
    """Return the material with each colormap of an array replaced by a map of its colours.

    If the array is a Dask array, the map is lazy too.
    """
    maps = material.maps if isinstance(material, Material) else {}
    given = {name: each for name, each in maps.items() if isinstance(each, Colormap)}
    colors = {name: Map(_colors(name, each)) for name, each in given.items() if not isinstance(each.scalars, str)}
    return material.with_values(colors) if colors else material


def _colors(name: str, colormap: Colormap) -> Any:
    """Return the colours, shape (n, 3), to which a colormap maps its array.

    A colormap without a range gets the range of the whole array, not of each chunk.
    """
    from pvphong.meshes.colormaps import colors_by, joined, lookup_table, mapped, numbers_in, span_of

    if not hasattr(colormap.scalars, "__dask_graph__"):
        return mapped(name, colormap)
    from dask import delayed

    scalars = _checked(name, colormap.scalars)

    def span(chunk: Any) -> Any:
        return span_of(colormap, numbers_in(name, colormap, chunk))

    def colors(chunk: Any, spans: Any) -> Any:
        numbers = numbers_in(name, colormap, chunk)
        return colors_by(lookup_table(name, colormap, numbers, spans), numbers)

    spans = delayed(joined)([delayed(span)(chunk) for chunk in scalars.to_delayed().ravel()])
    axis = {"new_axis": 1} if scalars.ndim == 1 else {}
    how: dict[str, Any] = {"dtype": np.uint8, "meta": np.empty((0, 0), np.uint8), "chunks": (scalars.chunks[0], (3,))}
    return scalars.map_blocks(colors, spans=spans, **how, **axis)


def _evaluate_chunks(given: dict[str, Any], scene: Any, **options: Any) -> Shading:
    """Return a `Shading` of Dask arrays.

    `given` has the per-vertex arrays by name, and `options` the other arguments of `evaluate`. Arguments are checked at
    once; the values in arrays are checked in each task.
    """
    from dask.array import blockwise, map_blocks

    arrays = _cut_alike(given)
    scene = as_scene(scene)
    kernel.check_backend(options.get("backend", "auto"))
    # shade zero vertices, to find the arrays of the result and their types
    shapes = {name: (len(array), 0) if name == _VISIBILITY else (0, *array.shape[1:]) for name, array in arrays.items()}
    nothing: dict[str, Any] = {name: np.empty(shape, arrays[name].dtype) for name, shape in shapes.items()}
    form = _evaluated(nothing, scene=scene, **options | {"backend": "numpy"})
    maps = {name: Map(empty) for name, empty in nothing.items() if name not in _ARGUMENTS}
    if maps:  # tasks carry the material with empty maps, and the rows of their own chunk separately
        options["material"] = options["material"].with_values(maps)
    if scene.viewer is None:
        scene = _framed(scene, arrays["points"], options.get("matrix"))
    pairs = [part for name, array in arrays.items() for part in (array, _axes(name, array))]
    how: dict[str, Any] = {"dtype": object, "meta": np.empty((0, 0), object), "align_arrays": False}
    blocks = blockwise(_lit, "ik", *pairs, concatenate=True, names=list(arrays), scene=scene, **how, **options)

    def field(name: str, like: Any) -> Any:
        """Join the field `name` of the chunks' `Shading`s; an axis for lights, if there is one, comes first.

        `like` is an empty array of the field's type and number of axes. If it is None, so is the result.
        """
        if like is None:
            return None
        lights = [(length,) for length in like.shape[:-2]]
        axis = {"new_axis": 0} if lights else {}
        return map_blocks(getattr, blocks, name, dtype=like.dtype, meta=like, chunks=(*lights, *blocks.chunks), **axis)

    return Shading(**{each.name: field(each.name, getattr(form, each.name)) for each in fields(form)})


def _lit(*arrays: Any, names: Sequence[str], **options: Any) -> Shading:
    """Light one chunk without additional threads.

    `arrays` are the chunk's arrays, and `names` their names. `options` are the other arguments of `evaluate`.
    """
    with threads.limited(1):
        return _evaluated(dict(zip(names, arrays, strict=True)), **options)


def _evaluated(arrays: Mapping[str, Any], *, material: Any, **options: Any) -> Shading:
    """Call `evaluate` with arrays by name.

    An array whose name is not an argument of `evaluate` becomes a map of the material.
    """
    own = {name: array for name, array in arrays.items() if name in _ARGUMENTS}
    maps = {name: Map(array) for name, array in arrays.items() if name not in _ARGUMENTS}
    if maps:
        material = material.with_values(maps)
    return evaluation.evaluate(**own, material=material, **options)


def _framed(scene: Scene, points: Any, matrix: Any) -> Any:
    """Return the scene, as a delayed object, with a viewer that sees all points under the model matrix."""
    from dask import delayed

    def ends(chunk: Any) -> Float64Array:
        """Return the low and high corners of the finite points' box, shape (2, 3); NaN if there are no such points."""
        finite = chunk[np.isfinite(chunk).all(axis=1)]
        return np.array([finite.min(axis=0), finite.max(axis=0)], float) if len(finite) else np.full((2, 3), np.nan)

    def framing(corners: Float64Array) -> Scene:
        return scene.framed(Vertices(corners, None).bounds(matrix))

    chunks = (2,) * points.numblocks[0], points.chunks[1]
    return delayed(framing)(points.map_blocks(ends, dtype=np.float64, chunks=chunks))


# --- matching chunks ---


def _cut_alike(given: dict[str, Any]) -> dict[str, Any]:
    """Split all arrays into the same chunks along vertices; NumPy arrays become Dask arrays.

    If the lengths of the first Dask array's chunks are unknown, no array is split. All arrays must then have the same
    number of chunks, also of unknown lengths.
    """
    from dask.array import from_array, unify_chunks

    lazy = {name: _checked(name, array) for name, array in given.items() if hasattr(array, "__dask_graph__")}
    first = next(iter(lazy))
    rows = _rows(first, lazy[first])
    is_known = not np.isnan(sum(rows))
    for name, array in given.items():
        if name not in lazy:
            lazy[name] = _checked(name, from_array(check.real_array(name, array, _allowed(name)), chunks=-1))
        own = _rows(name, lazy[name])
        # with unknown chunk lengths only the number of chunks can be compared
        fits = len(own) == len(rows) if np.isnan(sum(own)) and not is_known else sum(own) == sum(rows)
        if not fits:
            got = f"{_lengths(name, own)}, but {first} has {_lengths(first, rows)}"
            unknown = [each for each in (first, name) if np.isnan(sum(_rows(each, lazy[each])))]
            calls = " and ".join(f"{each}.compute_chunk_sizes()" for each in unknown)
            check.refuse(name, got, f"an array with one {_unit(name)} per point", f"Call {calls} first." * bool(calls))
    if not is_known:
        return lazy
    pairs: list[Any] = []
    for name, array in lazy.items():  # arrays have different numbers of columns, so each gets a column index of its own
        pairs += [array, tuple(name if axis == "k" else axis for axis in _axes(name, array))]
    return dict(zip(lazy, unify_chunks(*pairs)[1], strict=True))


def _checked(name: str, array: Any) -> Any:
    """Return the array `name` if it is a Dask array that is chunked along vertices only; otherwise raise ValueError.

    The array "visibility" may be chunked along lights too.
    """
    from dask.array import Array

    if not isinstance(array, Array) or not (name == _VISIBILITY) < array.ndim <= 2:
        check.refuse(name, f"a {type(array).__name__}", f"a Dask array: {_allowed(name)}")
    if name != _VISIBILITY and array.ndim == 2 and array.numblocks[1] > 1:
        got = f"column chunks {array.chunks[1]}"
        check.refuse(name, got, "chunked along vertices only", f"{name}.rechunk({{1: -1}}) joins the columns.")
    return array


def _allowed(name: str) -> str:
    rows = "shape (lights + 1, n)" if name == _VISIBILITY else "a row for each vertex"
    return f"an array of real numbers, {rows}"


def _axes(name: str, array: Any) -> str:
    """Return the letters of the axes of the array `name`: i for vertices, k for x, y, z or r, g, b, l for lights."""
    return "li" if name == _VISIBILITY else "ik"[: array.ndim]


def _rows(name: str, array: Any) -> tuple[float, ...]:
    """Return the number of vertices in each chunk of the array `name`; NaN if unknown."""
    chunks: tuple[float, ...] = array.chunks[1 if name == _VISIBILITY else 0]
    return chunks


def _lengths(name: str, rows: tuple[float, ...]) -> str:
    return f"{len(rows)} chunks of unknown length" if np.isnan(sum(rows)) else f"{sum(rows)} {_unit(name)}s"


def _unit(name: str) -> str:
    """Return the word for the part of the array `name` that belongs to one vertex: "row" or "column"."""
    return "column" if name == _VISIBILITY else "row"
