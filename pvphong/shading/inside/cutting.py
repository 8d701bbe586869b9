"""Search for the edges of hard shadows and of light cones in triangles, and cuts along these edges.

A light without a size is fully visible or hidden from each place on a surface. If one corner of a triangle sees the
light and another does not, the edge of the shadow crosses two sides of the triangle. Bisection finds both crossings,
and the edge between them is approximated by a straight line, as in marching triangles (W. E. Lorensen, H. E. Cline:
Marching cubes. Computer Graphics 21 (1987), 163-169). A triangle is split first if the edge deviates too far from the
line, if it crosses a side twice, or if the triangle contains a shadow that reaches no corner.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pvphong.base import text
from pvphong.base.types import BoolArray, Float64Array, IntArray
from pvphong.shading.inside.lighting import seen_at, steps_at
from pvphong.shading.inside.places import area, lattice, odd_corner, sizes
from pvphong.shading.inside.surface import LitSurface
from pvphong.shading.inside.triangles import marked

PIXEL = 2.0**-10
"""Smallest size of a triangle that is split at a jump, as a fraction of the mesh's diagonal: about a pixel of a
picture."""

# Largest distance between the line of a cut and the edge, in diagonals of the mesh.
_DEVIATION = 2.0**-12

# Numbers of bisections for a crossing, which is then known to 2⁻²⁰ of its side, and for the deviation of a cut.
_HALVINGS, _ROUGHLY = 20, 10

# Least length of a side that is cut, in steps of its coordinates' precision.
_LEAST_STEPS = 64.0

# Samples of a triangle: at quarters of its sides, and inside.
_QUARTERS = np.array([0.25, 0.5, 0.75])
_INSIDE = np.array([[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0], [4.0 / 3.0] * 3]) / 4.0
_CENTER = 3

# Triangles whose samples agree are sampled densely, so that no shadow wider than a pixel is missed. On a very large
# surface, _MOST_RAYS limits the number of rays and thus the density.
_MOST_RAYS = 2**19
_RAYS_AT_ONCE = 2**16
_FINEST = 2**9


class Cuts(NamedTuple):
    """Summary of the cuts along the edges of shadows and cones."""

    sides: int = 0
    """Number of triangle sides that were cut."""
    strip: float = 0.0
    """Area, in the mesh's unit squared, that may have the colours of the wrong side of an edge."""
    is_spent: bool = False
    """True if the cuts ended because the limit of vertices was reached."""


def cut_edges(
    surface: LitSurface, tolerance: float, limit: int, after_light: Callable[[], object] = lambda: None
) -> Cuts:
    """Cut triangles along the edges of shadows and cones where the colour jumps by more than the tolerance.

    Parameters
    ----------
    surface : LitSurface
        Surface to split and cut, in place.
    tolerance : float
        Smaller jumps of a colour are not cut.
    limit : int
        Largest number of vertices afterwards.
    after_light : callable
        Called after the cuts of each light.
    """
    cuts, lights = list[Cuts](), surface.lighting.sharp
    for number, light in enumerate(lights):
        with text.stage("refining", number / len(lights), (number + 1) / len(lights)):
            cuts.append(_Edge(surface, light, tolerance, limit).cut())
        after_light()
    sides, strips, spent = zip(*cuts, strict=True) if cuts else ((), (), ())
    return Cuts(sum(sides), sum(strips), any(spent))


def uncut_area(surface: LitSurface, tolerance: float) -> float:
    """Return the total area of the triangles that an edge of a shadow or cone crosses without a cut.

    Only triangles count in which the colour jumps by more than the tolerance at the edge. Such a triangle is left uncut
    if one of its parts would have no area. This happens where edges of several lights meet.
    """
    corners, vertices = surface.triangles.corners, surface.vertices
    is_crossed = np.zeros(len(corners), dtype=bool)
    for light in surface.lighting.sharp:
        is_lit = vertices.seen[corners, light] > 0.5
        rows = np.flatnonzero(is_lit.any(axis=1) & ~is_lit.all(axis=1))
        steps = steps_at(light, vertices, corners[rows], _INSIDE)
        is_crossed[rows[steps.max(axis=1, initial=0.0) > tolerance]] = True
    return area(vertices.points, corners[is_crossed])


class _Crossings(NamedTuple):
    """Crossings of one edge with the sides of triangles. The edge is that of one light's shadow or cone.

    The surface has s sides, and the edge crosses k triangles.
    """

    along: Float64Array
    """Position of the crossing on each side, as a fraction of the side, shape (s,); NaN for a side that is not
    crossed."""
    step: Float64Array
    """Jump of the colour at the crossing, shape (s,); 0 if the side is not cut there."""
    rows: IntArray
    """Triangles that the edge crosses, shape (k,)."""
    deviation: Float64Array
    """Largest distance of the edge from a straight line in each of these triangles, shape (k,)."""
    width: Float64Array
    """Length of the straight line in each of these triangles, shape (k,)."""


class _Edge:
    """The edge of one light's shadow or cone on a surface, and its crossings with the triangles."""

    def __init__(self, surface: LitSurface, light: int, tolerance: float, limit: int) -> None:
        self._surface, self._light, self._tolerance, self._limit = surface, light, tolerance, limit
        self._allowed = _DEVIATION * surface.diagonal
        self._is_lit_inside: BoolArray = np.zeros((0, len(_INSIDE)), dtype=bool)
        self._is_hidden: BoolArray = np.zeros(0, dtype=bool)
        whole = area(surface.vertices.points, surface.triangles.corners)
        self._spacing = max(PIXEL * surface.diagonal, math.sqrt(whole / _MOST_RAYS))

    @property
    def _is_lit(self) -> BoolArray:
        lit: BoolArray = self._surface.vertices.seen[:, self._light] > 0.5
        return lit

    def cut(self) -> Cuts:
        triangles = self._surface.triangles
        self._look(np.arange(len(triangles)))
        found, is_spent = self._crossings(), False
        while not is_spent and len(rows := self._poor(found)):
            _, height = self._sizes(np.arange(len(triangles)))
            room = self._limit - triangles.n_vertices - 2 * np.count_nonzero(found.step > 0.0)
            while len(rows) and np.count_nonzero(marks := triangles.marks(rows, height > 0.0)) > room:
                is_spent, rows = True, rows[: len(rows) // 2]
            if len(rows):
                self._look(self._surface.split(marks))
                found = self._crossings()
        return self._part(found, is_spent)

    # -- samples of triangles

    def _sizes(self, rows: IntArray) -> tuple[Float64Array, Float64Array]:
        return sizes(self._surface.vertices.points, self._surface.triangles.corners[rows])

    def _seen(self, rows: IntArray, weights: Float64Array) -> BoolArray:
        surface = self._surface
        corners = surface.triangles.corners[rows]
        lit: BoolArray = seen_at(self._light, surface.vertices, corners, weights)[0] > 0.5
        return lit

    def _steps(self, corners: IntArray, weights: Float64Array) -> Float64Array:
        return steps_at(self._light, self._surface.vertices, corners, weights)

    def _look(self, rows: IntArray) -> None:
        """Sample the triangles `rows`, which are new or changed.

        Mark the triangles with an edge that their corners do not show. Such an edge crosses a side twice, or encloses a
        shadow that reaches no corner.
        """
        triangles, is_lit = self._surface.triangles, self._is_lit
        rows = rows[self._sizes(rows)[1] > 0.0]
        added = len(triangles) - len(self._is_hidden)
        self._is_hidden = np.concatenate([self._is_hidden, np.zeros(added, dtype=bool)])
        self._is_lit_inside = np.concatenate([self._is_lit_inside, np.zeros((added, len(_INSIDE)), dtype=bool)])
        sides = np.flatnonzero(marked(len(triangles.ends), triangles.sides[rows]))
        ends = triangles.ends[sides]
        quarters = self._surface.seen_on_sides(self._light, sides, _QUARTERS) > 0.5
        along = np.column_stack([is_lit[ends[:, 0]], quarters, is_lit[ends[:, 1]]])
        changes = (along[:, 1:] != along[:, :-1]).sum(axis=1)
        odd = np.flatnonzero(changes > 1)
        places = np.linspace(0.0, 1.0, 5)
        is_other = along[odd] ^ along[odd, :1]
        jumps = self._can_jump(ends[odd], np.stack([1.0 - places, places], axis=1), is_other)
        is_odd = marked(len(triangles.ends), sides[odd[jumps]])
        self._is_hidden[rows] = is_odd[triangles.sides[rows]].any(axis=1)
        inside = self._is_lit_inside[rows] = self._seen(rows, _INSIDE)
        at_corners = is_lit[triangles.corners[rows]]
        is_uniform = np.ptp(at_corners.astype(np.int8), axis=1) == 0
        is_other = (inside ^ at_corners[:, :1]) & is_uniform[:, None]
        some = np.flatnonzero(is_other.any(axis=1))
        is_other = np.column_stack([np.zeros((len(some), 3), dtype=bool), is_other[some]])
        places = np.concatenate([np.eye(3), _INSIDE])
        self._is_hidden[rows[some]] |= self._can_jump(triangles.corners[rows[some]], places, is_other)
        self._look_closely(rows[is_uniform & ~self._is_hidden[rows]])

    def _look_closely(self, rows: IntArray) -> None:
        """Sample the triangles `rows` at places about a pixel apart, and mark the triangles that contain an edge.

        In the given triangles, all earlier samples agree: at corners, on sides and inside.
        """
        corners, is_lit = self._surface.triangles.corners, self._is_lit
        steps = np.maximum(self._sizes(rows)[0] / self._spacing, 1.0)
        orders = np.minimum(2 ** np.rint(np.log2(steps)).astype(np.int64), _FINEST)
        for order in np.unique(orders[orders > 4]).tolist():
            places = lattice(order)
            places = places[places.min(axis=1) > 0.0]
            those = rows[orders == order]
            together = max(_RAYS_AT_ONCE // len(places), 1)
            for some in (those[start : start + together] for start in range(0, len(those), together)):
                is_other = self._seen(some, places) ^ is_lit[corners[some, :1]]
                found = np.flatnonzero(is_other.any(axis=1))
                place = places[is_other[found].argmax(axis=1)][:, None]
                self._is_hidden[some[found]] |= self._steps(corners[some[found]], place)[:, 0] > self._tolerance

    def _can_jump(self, corners: IntArray, places: Float64Array, is_other: BoolArray) -> BoolArray:
        """Return True for triangles or sides in which the colour may jump by more than the tolerance, shape (k,).

        The edge lies between a place and the neighbouring places. The jump at the edge may exceed the jumps at the
        places by a third of the range of these jumps.

        Parameters
        ----------
        corners : ndarray of int
            Vertices of k triangles, shape (k, 3), or of k sides, shape (k, 2).
        places : ndarray
            Barycentric coordinates of s places, the same in all triangles or sides.
        is_other : ndarray of bool
            Shape (k, s): True at places whose visibility differs from the first corner's.
        """
        steps = self._steps(corners, places)
        larger = np.ptp(steps, axis=1) / 3.0 if len(steps) else np.zeros(0)
        result: BoolArray = np.where(is_other, steps, 0.0).max(axis=1, initial=0.0) + larger > self._tolerance
        return result

    def _crossings(self) -> _Crossings:
        surface, triangles, is_lit = self._surface, self._surface.triangles, self._is_lit
        along, step = np.full(len(triangles.ends), np.nan), np.zeros(len(triangles.ends))
        sides = np.flatnonzero(is_lit[triangles.ends[:, 0]] != is_lit[triangles.ends[:, 1]])
        _, first, tie = np.unique(triangles.ties[sides], return_index=True, return_inverse=True)
        one = sides[first]
        ends, (low, high) = triangles.ends[one], np.array([[0.0], [1.0]]) * np.ones(len(one))
        for _ in range(_HALVINGS if len(one) else 0):
            middle = (low + high) / 2.0
            is_same = (surface.seen_on_sides(self._light, one, middle[:, None])[:, 0] > 0.5) == is_lit[ends[:, 0]]
            low, high = np.where(is_same, middle, low), np.where(is_same, high, middle)
        middle = (low + high) / 2.0
        along[sides] = middle[tie]
        p, q = (surface.vertices.points[ends[:, end]] for end in (0, 1))
        resolved = _LEAST_STEPS * np.abs(p).max(axis=1, initial=0.0) * float(np.finfo(surface.real).eps)
        jump = self._steps(ends, np.stack([1.0 - middle, middle], axis=1)[:, None])[:, 0]
        jump[~((jump > self._tolerance / 2.0) & (np.linalg.norm(p - q, axis=1) > resolved))] = 0.0
        step[sides] = jump[tie]
        rows = np.flatnonzero((step[triangles.sides] > 0.0).any(axis=1))
        rows = rows[self._sizes(rows)[1] > 0.0]
        return _Crossings(along, step, rows, *self._deviations(along, rows))

    def _lines(self, along: Float64Array, rows: IntArray) -> tuple[IntArray, Float64Array]:
        """Return the straight line across each of the k triangles `rows`, as a corner and two ends.

        Parameters
        ----------
        along : ndarray
            Shape (s,): position of the crossing on each side of a triangle, as a fraction of the side.
        rows : ndarray of int
            Triangles that the edge crosses, shape (k,).

        Returns
        -------
        alone : ndarray of int
            Shape (k,): the corner, 0 to 2, that is alone on its side of the line.
        ends : ndarray
            Shape (k, 2, 3): barycentric coordinates of both ends of the line.
        """
        triangles, is_lit = self._surface.triangles, self._is_lit
        at_corners = is_lit[triangles.corners[rows]]
        alone = odd_corner(at_corners)
        weights, index = np.zeros((len(rows), 2, 3)), np.arange(len(rows))
        for end, (side, other) in enumerate(((alone, (alone + 1) % 3), ((alone + 2) % 3, (alone + 2) % 3))):
            number = triangles.sides[rows, side]
            t = triangles.from_end(number, triangles.corners[rows, alone], along)
            weights[index, end, alone], weights[index, end, other] = 1.0 - t, t
        return alone, weights

    def _deviations(self, along: Float64Array, rows: IntArray) -> tuple[Float64Array, Float64Array]:
        """Return the largest distance of the edge from a straight line, and the length of the line, in each triangle.

        Both have the shape (k,), for the k triangles `rows`. `along`, shape (s,), is the position of the crossing on
        each side of a triangle. The distance is measured at the line's quarters and at samples inside the triangle. Of
        the samples, those count that are lit on the line's dark side, or dark on its lit side.
        """
        triangles, index = self._surface.triangles, np.arange(len(rows))
        p = self._surface.vertices.points[triangles.corners[rows]]
        alone, ends = self._lines(along, rows)
        x, y = (np.einsum("ki,kij->kj", ends[:, end], p) for end in (0, 1))
        width = np.linalg.norm(y - x, axis=1)

        is_lit = self._is_lit[triangles.corners[rows, alone]][:, None]
        near = np.stack([1.0 - _QUARTERS, _QUARTERS], axis=1) @ ends
        is_near = (self._seen(rows, near) == is_lit) if len(rows) else np.zeros((0, len(_QUARTERS)), dtype=bool)
        corner = np.broadcast_to(np.eye(3)[alone][:, None], near.shape)
        far = np.where(is_near[..., None], (1.0 - corner) / 2.0, corner)  # expected on the other side
        for _ in range(_ROUGHLY if len(rows) else 0):
            between = (near + far) / 2.0
            is_same = ((self._seen(rows, between) == is_lit) == is_near)[..., None]
            near, far = np.where(is_same, between, near), np.where(is_same, far, between)
        off = self._distances(far, p, x, y)
        # for a place on the same side of the line as the lone corner, the sum below is less than 1
        part = 1.0 - ends[index, :, alone]
        others = np.stack([_INSIDE[:, (alone + turn) % 3].T for turn in (1, 2)], axis=2)
        with np.errstate(divide="ignore", over="ignore"):
            is_predicted = (others / part[:, None]).sum(axis=2) < 1.0
        is_wrong = (self._is_lit_inside[rows] == is_lit) != is_predicted
        wrong = np.where(is_wrong, self._distances(_INSIDE, p, x, y), 0.0)
        return np.column_stack([off, wrong]).max(axis=1, initial=0.0), width

    @staticmethod
    def _distances(weights: Float64Array, p: Float64Array, x: Float64Array, y: Float64Array) -> Float64Array:
        """Return the distances of places from a straight line in each triangle, shape (k, s).

        `weights` are the barycentric coordinates of s places, shape (k, s, 3) or (s, 3). `p` are the corners of k
        triangles, shape (k, 3, 3). The line in each triangle goes through the points `x` and `y`, shape (k, 3) each.
        """
        line = (y - x)[:, None]
        width = np.linalg.norm(line, axis=2)
        far = np.linalg.norm(np.cross(weights @ p - x[:, None], line), axis=2)
        result: Float64Array = far / np.where(width > 0.0, width, 1.0)
        return result

    def _poor(self, found: _Crossings) -> IntArray:
        """Return the triangles to split before the cuts, the most urgent first.

        In these triangles, the edge deviates too far from a straight line, ends inside, or crosses no side that can be
        cut. `found` are the crossings of the edge.
        """
        triangles = self._surface.triangles
        steps = found.step[triangles.sides[found.rows]]
        ends_inside = ((steps > 0.0).sum(axis=1) == 1) & (steps.max(axis=1) > self._tolerance)
        urgency = np.where(self._is_hidden, np.inf, 0.0)
        is_poor = (found.deviation > self._allowed) | ends_inside
        urgency[found.rows] += steps.max(axis=1) * found.deviation * found.width * is_poor + is_poor * 1e-300
        rows = np.flatnonzero(urgency > 0.0)
        rows = rows[self._sizes(rows)[0] >= PIXEL * self._surface.diagonal]
        return rows[np.argsort(-urgency[rows], kind="stable")]

    # -- cuts

    def _part(self, found: _Crossings, is_spent: bool) -> Cuts:
        surface, triangles = self._surface, self._surface.triangles
        strip = area(surface.vertices.points, triangles.corners[self._is_hidden])
        signs = self._snapped(found)
        is_cut = triangles.with_tied((found.step > 0.0) & (signs[triangles.ends] != 0).all(axis=1))
        is_crossed = signs[triangles.ends].prod(axis=1) < 0
        is_cut &= ~triangles.with_tied(is_cut & ~is_crossed)  # a side crossed on only one sheet is not cut
        along = np.nan_to_num(found.along)
        while len(bad := self._turned_over(is_cut, along)):
            is_cut &= ~triangles.with_tied(marked(len(is_cut), triangles.sides[bad]))
        room, wanted = self._limit - triangles.n_vertices, 2 * np.count_nonzero(is_cut) + np.count_nonzero(signs == 0)
        if wanted > room:
            is_spent = True
            p = surface.vertices.points[triangles.ends]
            weight = np.where(is_cut, found.step * np.linalg.norm(p[:, 0] - p[:, 1], axis=1), 0.0)
            signs[signs == 0] = np.where(self._is_lit, 1, -1)[signs == 0]
            order = np.argsort(-weight, kind="stable")
            _, first = np.unique(triangles.ties[order], return_index=True)
            tied = np.bincount(triangles.ties, weights=is_cut, minlength=int(triangles.ties.max(initial=-1)) + 1)
            order = order[np.sort(first)]
            fits = 2 * np.cumsum(tied[triangles.ties[order]]) <= room
            is_cut &= triangles.with_tied(marked(len(is_cut), order[fits]))
        strip += float((found.width * np.maximum(found.deviation, _DEVIATION * 2.0**-8 * surface.diagonal)).sum())
        inner = np.where(self._is_lit_inside[:, _CENTER], 1, -1)
        surface.cut(self._light, signs, is_cut, along, inner)
        surface.lighting.settled.add(self._light)
        return Cuts(len(np.unique(triangles.ties[: len(is_cut)][is_cut])), strip, is_spent)

    def _snapped(self, found: _Crossings) -> IntArray:
        """Return the side of the edge on which each vertex is: 1 for lit, -1 for dark, 0 for on the edge, shape (n,).

        A vertex counts as on the edge if the edge crosses its sides, and each crossing is nearer to the vertex than
        half of the allowed deviation. `found` are the crossings of the edge.
        """
        surface, triangles = self._surface, self._surface.triangles
        sides = np.flatnonzero(~np.isnan(found.along))
        ends, t = triangles.ends[sides], found.along[sides]
        length = np.linalg.norm(np.diff(surface.vertices.points[ends], axis=1)[:, 0], axis=1)
        places, count = triangles.places, triangles.n_vertices
        crossed, near, jumps = np.zeros((3, count))
        for end, away in ((0, t), (1, 1.0 - t)):
            at = places[ends[:, end]]
            np.add.at(crossed, at, 1)
            np.add.at(near, at, away * length < self._allowed / 2.0)
            np.add.at(jumps, at, found.step[sides] > 0.0)
        on_line = (jumps > 0) & (near == crossed)
        return np.where(on_line[places], 0, np.where(self._is_lit, 1, -1))

    def _turned_over(self, is_cut: BoolArray, along: Float64Array) -> IntArray:
        """Return the triangles whose cuts must be dropped, because a part would be turned over or have no area.

        The cause is the rounding of the new vertices' positions.

        Parameters
        ----------
        is_cut : ndarray of bool
            Shape (s,): True for each side to cut.
        along : ndarray
            Shape (s,): position of the cut, as a fraction of the side.
        """
        surface, triangles = self._surface, self._surface.triangles
        count = is_cut[triangles.sides].sum(axis=1)
        rows = np.flatnonzero(count)
        corners, sides = triangles.corners[rows], triangles.sides[rows]
        p = surface.vertices.points[corners]
        a, b = (surface.vertices.points[triangles.ends[sides][:, :, end]] for end in (0, 1))
        t = along[sides][..., None]
        on_sides = ((1.0 - t) * a + t * b).astype(surface.real).astype(np.float64)
        normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        is_bad = np.zeros(len(rows), dtype=bool)
        for turn in range(3):
            first, second, third = ((turn + step) % 3 for step in range(3))
            x, y = on_sides[:, first], on_sides[:, third]  # next to the corner `first`
            one = is_cut[sides[:, first]] & (count[rows] == 1)
            two = is_cut[sides[:, first]] & is_cut[sides[:, third]]
            q = [p[:, first], p[:, second], p[:, third]]
            parts = [(one, (q[0], x, q[2])), (one, (x, q[1], q[2])), (two, (q[0], x, y)), (two, (x, q[1], q[2]))]
            parts += [(two, (x, q[2], y)), (two, (x, q[1], y)), (two, (y, q[1], q[2]))]
            for some, (u, v, w) in parts:
                is_bad |= some & ~(np.einsum("ki,ki->k", np.cross(v - u, w - u), normal) > 0.0)
        return rows[is_bad]
