"""Targets: the colours or luminances that points should have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.meshes.blocks import datasets

_SELECTIONS = (
    "the name of a point array or a block, a box (x_min, x_max, y_min, y_max, z_min, z_max), a point and a radius "
    "((x, y, z), radius), or in pairs a mask of a dataset's points"
)
LUMINANCE = XYZ_OF_RGB[1]
"""Luminance of red, green and blue."""


def target(mesh: Any, levels: Mapping[Any, Any] | Sequence[tuple[Any, Any]]) -> Any:
    """Make a target for `mesh.phong.fit` from selections of points and the level that each should have.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        The mesh; it is not modified.
    levels : mapping or sequence of pairs
        Selection → level, or pairs (selection, level); later entries replace earlier ones where they overlap. A
        selection is the name of a point array, which selects the points where it is not 0; the name of a block of a
        MultiBlock, or the path of a nested block, as in "car/wheel"; a box, the tuple (x_min, x_max, y_min, y_max,
        z_min, z_max); or a picked point with a radius, ((x, y, z), radius), in the mesh's unit. In pairs, the point may
        be an array, and a selection may also be a mask of the points of a dataset. A level is a luminance (1 for
        white), a colour, or None for "any colour".

    Returns
    -------
    ndarray or dict
        Shape (n_points,), float64, if all levels are luminances; shape (n_points, 3) if any level is a colour. NaN
        where no level is asked for. For a MultiBlock, a dictionary with such an array for each block, by path.

    Raises
    ------
    ValueError
        If a selection is none of these kinds or selects no point, or a level is neither a luminance nor a colour.

    Examples
    --------
    >>> import numpy as np, pyvista as pv, pvphong as ph
    >>> ball = pv.Sphere()
    >>> ball["top"] = ball.points[:, 2] > 0.4
    >>> wanted = ph.target(ball, {"top": 0.9, ((0.0, 0.0, -0.5), 0.1): 0.1})
    >>> wanted.shape, float(wanted[0]), float(wanted[1]), int(np.isnan(wanted).sum())
    ((842,), 0.9, 0.1, 660)
    >>> picked = ball.points[1]  # as plotter.picked_point
    >>> int(np.isfinite(ph.target(ball, [((picked, 0.1), 0.5), (ball.points[:, 0] > 0.4, 0.8)])).sum())
    91
    """
    if not isinstance(mesh, pv.DataSet | pv.MultiBlock):
        check.refuse("mesh", type(mesh).__name__, "a pyvista.DataSet or a pyvista.MultiBlock")
    is_mapping = isinstance(levels, Mapping)
    pairs: Any = list(levels.items()) if isinstance(levels, Mapping) else levels
    if not isinstance(pairs, list | tuple) or not pairs or not all(isinstance(p, tuple) and len(p) == 2 for p in pairs):
        allowed = 'a mapping of selections to levels, as in {"name": 0.8}, or a list of such pairs'
        check.refuse("levels", levels, allowed)
    parts = dict(datasets(mesh)) if isinstance(mesh, pv.MultiBlock) else {"": mesh}
    names = [f"levels[{key!r}]" if is_mapping else f"levels[{number}]" for number, (key, _) in enumerate(pairs)]
    colors = [
        None if level is None else check.color(name, level) for name, (_, level) in zip(names, pairs, strict=True)
    ]
    has_colors = any(isinstance(color, tuple) for color in colors)
    found = {path: np.full((part.n_points, 3) if has_colors else part.n_points, np.nan) for path, part in parts.items()}
    for name, (key, _), color in zip(names, pairs, colors, strict=True):
        selected = {path: _selected(path, part, key) for path, part in parts.items()}
        masks = {path: mask for path, mask in selected.items() if mask is not None}
        if not masks:
            known = sorted({*filter(None, parts), *(each for part in parts.values() for each in part.point_data)})
            remedy = check.meant(key, known) or f"The names are {', '.join(known) or 'none'}."
            got = repr(key)
            if isinstance(key, np.ndarray):
                got = f"an array of shape {key.shape}"
                remedy = "A mask is an array of True and False with one entry per point of a dataset, not of blocks."
            check.refuse("levels", f"a selection {got}", f"selections and levels; a selection is {_SELECTIONS}", remedy)
        if not any(mask.any() for mask in masks.values()):
            check.refuse(name, "a selection without points", "a level for at least one point", _enlarged(mesh, key))
        for path, mask in masks.items():
            found[path][mask] = np.nan if color is None else color
    return found if isinstance(mesh, pv.MultiBlock) else found[""]


def _enlarged(mesh: Any, key: Any) -> str:
    """Return the remedy for a selection that contains no point."""
    if isinstance(key, str | np.ndarray):
        return "It is 0 everywhere."
    if len(key) == 6 and any(low > high for low, high in zip(key[::2], key[1::2], strict=True)):
        return "The order of a box is x_min, x_max, y_min, y_max, z_min, z_max."
    return f"Enlarge or move it. The points are in the box {', '.join(f'{bound:.6g}' for bound in mesh.bounds)}."


def _selected(path: str, mesh: pv.DataSet, key: Any) -> BoolArray | None:
    """Return a mask of the mesh's points that `key` selects; None if `key` names neither this mesh nor an array of it.

    `key` is a key of `levels`: a name, a box, or a point with a radius. `path` is the mesh's path in the blocks.
    """
    if isinstance(key, str):
        if path and f"{path}/".startswith(f"{key}/"):
            return np.ones(mesh.n_points, bool)
        if key not in mesh.point_data:
            return None
        values = np.asarray(mesh.point_data[key])
        if values.ndim != 1 or values.dtype.kind not in "fiub":
            check.refuse(f"levels[{key!r}]", f"an array of shape {values.shape}", "the name of an array of numbers")
        return np.asarray((values != 0) & (values == values), bool)  # NaN differs from itself
    if isinstance(key, np.ndarray) and key.dtype.kind == "b":
        return key if not path and key.shape == (mesh.n_points,) else None
    points = np.asarray(mesh.points, np.float64)
    if isinstance(key, Sequence) and len(key) == 6:
        box = np.array(check.numbers_in("levels", key, 6))
        return np.asarray(((points >= box[::2]) & (points <= box[1::2])).all(axis=1))
    if isinstance(key, Sequence) and len(key) == 2:
        center = np.array(check.vector("levels", key[0]))
        radius = check.number("levels", key[1], above=0.0)
        return np.asarray(np.square(points - center).sum(axis=1) <= radius * radius)
    return None


@dataclass(frozen=True)
class Wanted:
    """A checked target of n points, with a row per point.

    In a target of colours, a row has three numbers. In a target of luminances, a row has one number.
    """

    values: Float64Array
    """The target, shape (n, 3) or (n, 1); 0 where any colour is allowed."""
    roots: Float64Array
    """Square roots of the weights, in the shape of `values`; 0 where any colour is allowed. The weights sum to 1."""
    clamps: bool
    """True if the light model clamps colours at 1."""

    @property
    def is_luminance(self) -> bool:
        """True if the target has luminances, False if it has colours."""
        return self.values.shape[1] == 1

    @cached_property
    def reachable(self) -> Float64Array:
        """The values, at most 1 if the light model clamps."""
        return np.minimum(self.values, 1.0) if self.clamps else self.values

    @property
    def counts(self) -> BoolArray:
        """Mask of the points that have a target, shape (n,)."""
        return np.asarray((self.roots > 0.0).any(axis=1))

    def at(self, rows: Any) -> Wanted:
        """Return the target for the points `rows`: indices or a mask."""
        roots = self.roots[rows]
        return Wanted(self.values[rows], roots / np.sqrt(np.square(roots).sum()), self.clamps)

    def seen(self, colors: Float64Array) -> Float64Array:
        """Return what is compared with the target: `colors` itself, shape (n, 3), or its luminances, shape (n, 1)."""
        return np.einsum("nc,c->n", colors, LUMINANCE)[:, None] if self.is_luminance else colors


_TO_POINTS = "Values of cells become values of points by mesh.cell_data_to_point_data()."
_TARGET = "an array with a luminance or a colour for each point, the name of such a point array, or a number"


def checked_target(given: Any, mesh: pv.DataSet) -> Float64Array:
    """Return the target `given` as an array, shape (n_points, 1) or (n_points, 3), NaN where any colour is allowed.

    `given` is an array, the name of a point array, or one luminance.

    Raises
    ------
    ValueError
        If the target has another shape, or a value is infinite or negative.
    """
    if isinstance(given, str):
        names = list(mesh.point_data.keys())
        if given not in names:
            remedy = check.meant(given, names) or f"The point arrays are {', '.join(names) or 'none'}."
            check.refuse("target", repr(given), _TARGET, _TO_POINTS if given in mesh.cell_data else remedy)
        given = mesh.point_data[given]
    if isinstance(given, np.ndarray) and given.dtype.kind == "b":
        remedy = "np.where(mask, 0.8, np.nan) asks for 0.8 at the points of the mask."
        check.refuse("target", "an array of True and False", _TARGET, remedy)
    rows = check.real_array("target", given, _TARGET)
    if not rows.ndim:
        rows = np.full(mesh.n_points, rows)
    if rows.dtype == np.uint8:
        check.refuse("target", "an array of uint8", "an array of floats, where 1 is white", "Divide it by 255.")
    if rows.shape not in ((mesh.n_points,), (mesh.n_points, 1), (mesh.n_points, 3)):
        allowed = f"an array of shape ({mesh.n_points},) or ({mesh.n_points}, 3)"
        remedy = _TO_POINTS if len(rows) == mesh.n_cells else "ph.target(mesh, {...}) makes one."
        check.refuse("target", f"an array of shape {rows.shape}", allowed, remedy)
    values = rows.astype(np.float64).reshape(mesh.n_points, -1)
    is_bad = np.isinf(values) | (values < 0.0)
    if is_bad.any():
        point = int(np.argmax(is_bad.any(axis=1)))
        remedy = "Use NaN where any colour is allowed."
        check.refuse("target", f"{values[point].tolist()} at point {point}", "numbers >= 0 that are finite", remedy)
    return values


def checked_weights(given: Any, values: Float64Array, mesh: pv.DataSet) -> Float64Array:
    """Return the weights of the points, shape (n_points,).

    `given` has the weights, or is the name of a point array, or is None for equal weights. `values` is the target.

    Raises
    ------
    ValueError
        If a weight is negative or not finite, or a point with a weight has the target NaN.
    """
    if given is None:
        return np.ones(len(values))
    allowed = f"an array with a number >= 0 for each point, shape ({len(values)},)"
    rows = check.real_array("weights", mesh.point_data.get(given, given) if isinstance(given, str) else given, allowed)
    if rows.shape != (len(values),):
        check.refuse("weights", f"an array of shape {rows.shape}", allowed)
    weights = rows.astype(np.float64)
    if not (np.isfinite(weights) & (weights >= 0.0)).all():
        check.refuse("weights", "an array with negative numbers, NaN or infinity", allowed)
    is_unknown = (weights > 0.0) & np.isnan(values).any(axis=1)
    if is_unknown.any():
        point = int(np.argmax(is_unknown))
        remedy = "Set the weight to 0 there, or leave weights out: points whose target is NaN then do not count."
        check.refuse("target", f"NaN at point {point}", "finite where weights are above 0", remedy)
    return weights


def wanted_of(values: FloatArray, weights: FloatArray, clamps: bool) -> Wanted:
    """Return the checked target of all points.

    `values` are the target, `weights` the given weights times the points' areas. `clamps` is true if colours are
    clamped.

    Raises
    ------
    ValueError
        If no point has both a target and a weight.
    """
    is_asked = np.isfinite(values)
    shares = weights[:, None] * is_asked
    total = shares.sum()
    if not is_asked.any():
        check.refuse("target", "NaN everywhere", "a number or a colour at some points")
    if not total > 0.0:
        check.refuse("weights", "0 wherever the target is finite", "above 0 at some points that have an area")
    return Wanted(np.where(is_asked, values, 0.0), np.sqrt(shares / total), clamps)
