"""`pvphong.evaluate` on Dask arrays: chunk by chunk, when the colours are asked for.

Dask decides how many chunks are lit at once, so each is lit by the one thread that Dask gives it: the evaluator's own
threads stay out, and there are never more at work than Dask has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import wraps
from typing import Any, ParamSpec

import numpy as np

from pvphong.base import check, threads
from pvphong.base.types import Float64Array
from pvphong.scene.scene import Scene, as_scene
from pvphong.shading import evaluation, kernel
from pvphong.shading.result import Shading
from pvphong.shading.vertices import Vertices

Given = ParamSpec("Given")

_PER_VERTEX = ("points", "normals", "albedo", "specular", "shininess", "roughness", "tangents")
_VISIBILITY = "visibility"
"""What comes as arrays; all but the last, of shape (lights + 1, n), have a row for each vertex."""

_SIZES = "Call its compute_chunk_sizes() first."


def _taking_chunks(whole: Callable[Given, Shading]) -> Callable[Given, Shading]:
    """`evaluation.evaluate` for arrays of any sort."""

    @wraps(whole)
    def evaluate(*given: Given.args, **options: Given.kwargs) -> Shading:
        arrays = (*given[:2], *(options.get(name) for name in (*_PER_VERTEX, _VISIBILITY)))
        if any(hasattr(array, "__dask_graph__") for array in arrays):
            return _evaluate_chunks(*given, **options)
        return whole(*given, **options)

    return evaluate


evaluate = _taking_chunks(evaluation.evaluate)


def _evaluate_chunks(points: Any, normals: Any, scene: Any, material: Any, **options: Any) -> Shading:
    """A `Shading` of Dask arrays; everything but the arrays' entries is checked now."""
    given = {"points": points, "normals": normals}
    given |= {name: options.pop(name) for name in (*_PER_VERTEX, _VISIBILITY) if name in options}
    arrays = _aligned({name: array for name, array in given.items() if array is not None})
    scene = as_scene(scene)
    kernel.check_backend(options.get("backend", "auto"))
    options["material"] = material
    nothing = {name: _without_rows(name, array) for name, array in arrays.items()}
    form = evaluation.evaluate(**nothing, scene=scene, **options | {"backend": "numpy"})
    if scene.viewer is None:
        scene = _framed(scene, arrays["points"], options.get("matrix"))
    return _fields(_blocks(arrays, scene, options), form)


def _without_rows(name: str, array: Any) -> Any:
    """The array as it would be for no vertex."""
    shape = tuple(0 if axis == _axis(name) else length for axis, length in enumerate(array.shape))
    return np.empty(shape, array.dtype)


def _lit(*arrays: Any, names: Sequence[str], **options: Any) -> Shading:
    """One chunk, by this thread alone."""
    with threads.limited(1):
        return evaluation.evaluate(**dict(zip(names, arrays, strict=True)), **options)


def _blocks(arrays: dict[str, Any], scene: Any, options: dict[str, Any]) -> Any:
    """An array of which every chunk is a `Shading`."""
    from dask.array import blockwise

    pairs = [part for name, array in arrays.items() for part in (array, _index(name, array))]
    how: dict[str, Any] = {"dtype": object, "meta": np.empty((0, 0), object), "align_arrays": False}
    return blockwise(_lit, "ik", *pairs, concatenate=True, names=list(arrays), scene=scene, **how, **options)


def _fields(blocks: Any, form: Shading) -> Shading:
    """What each chunk's `Shading` has, as arrays; `form` is that of no vertex."""
    from dask.array import map_blocks

    def field(name: str, like: Any) -> Any:
        if like is None:
            return None
        how: dict[str, Any] = {"chunks": (*((length,) for length in like.shape[:-2]), *blocks.chunks)}
        if like.ndim > blocks.ndim:
            how["new_axis"] = 0
        return map_blocks(getattr, blocks, name, dtype=like.dtype, meta=like, **how)

    return Shading(**{each.name: field(each.name, getattr(form, each.name)) for each in fields(form)})


def _framed(scene: Scene, points: Any, matrix: Any) -> Any:
    """The scene with a viewer that sees all points, once these are known."""
    from dask import delayed

    ends = points.map_blocks(_ends, dtype=np.float64, chunks=((2,) * points.numblocks[0], points.chunks[1]))
    return delayed(_framing)(scene, ends, matrix)


def _ends(points: Any) -> Float64Array:
    """The least and the greatest coordinates of a chunk's finite points, shape (2, 3); NaN where there is none."""
    finite = points[np.isfinite(points).all(axis=1)]
    if not len(finite):
        return np.full((2, 3), np.nan)
    return np.array([finite.min(axis=0), finite.max(axis=0)], np.float64)


def _framing(scene: Scene, ends: Float64Array, matrix: Any) -> Scene:
    return scene.framed(Vertices(ends, None).bounds(matrix))


# --- chunks that fit each other


def _aligned(given: dict[str, Any]) -> dict[str, Any]:
    """The arrays, cut along vertices into the same chunks; plain ones are cut as the others are."""
    from dask.array import from_array, unify_chunks

    lazy = {name: _checked(name, array) for name, array in given.items() if hasattr(array, "__dask_graph__")}
    first, rows = next((name, _rows(name, array)) for name, array in lazy.items())
    for name, array in given.items():
        if name not in lazy:
            lazy[name] = _checked(name, from_array(check.real_array(name, array, _form(name)), chunks=-1))
        if not _fits(_rows(name, lazy[name]), rows):
            got = f"{_told(_rows(name, lazy[name]))} beside {_told(rows)} in {first}"
            check.refuse(name, got, "one row per point", _SIZES if np.isnan(sum(rows)) else "")
    if not np.isnan(sum(rows)):
        # columns are not one length for all: their index is the array's name
        pairs = [
            part
            for name, array in lazy.items()
            for part in (array, tuple(name if axis == "k" else axis for axis in _index(name, array)))
        ]
        lazy = dict(zip(lazy, unify_chunks(*pairs)[1], strict=True))
    return lazy


def _checked(name: str, array: Any) -> Any:
    """A Dask array that is cut along vertices only."""
    from dask.array import Array

    if not isinstance(array, Array) or not _axis(name) < array.ndim <= 2:
        check.refuse(name, f"a {type(array).__name__}", f"a Dask array: {_form(name)}")
    if name == _VISIBILITY:
        return array.rechunk({0: -1})
    if array.ndim == 2 and array.numblocks[1] > 1:
        got = f"one with the columns cut into {array.chunks[1]}"
        check.refuse(name, got, "cut along vertices only", f"{name}.rechunk({{1: -1}}) puts them together.")
    return array


def _form(name: str) -> str:
    if name == _VISIBILITY:
        return "an array of real numbers, shape (lights + 1, n)"
    return "an array of real numbers, a row for each vertex"


def _axis(name: str) -> int:
    """That of the vertices."""
    return int(name == _VISIBILITY)


def _index(name: str, array: Any) -> str:
    """Of its axes: i along vertices, k across x, y, z or red, green, blue, l across lights."""
    return "li" if name == _VISIBILITY else "ik"[: array.ndim]


def _rows(name: str, array: Any) -> tuple[float, ...]:
    """How many vertices each chunk has."""
    chunks: tuple[float, ...] = array.chunks[_axis(name)]
    return chunks


def _fits(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    """Whether they have equally many vertices; where nobody knows how many, equally many chunks."""
    if np.isnan(sum(one)) or np.isnan(sum(other)):
        return bool(np.isnan(sum(one)) and np.isnan(sum(other)) and len(one) == len(other))
    return sum(one) == sum(other)


def _told(rows: tuple[float, ...]) -> str:
    return f"{len(rows)} chunks of unknown length" if np.isnan(sum(rows)) else f"{sum(rows)} rows"
