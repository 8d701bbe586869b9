"""Bisection of triangles and cuts along a line, on index arrays: connectivity without positions.

A triangle is always bisected through the middle of its longest side. A split side is split for all triangles that share
it, so that no vertex lies inside another triangle's side. This is longest-edge bisection (M.-C. Rivara: Algorithms for
refining triangular grids suitable for adaptive and multigrid techniques. International Journal for Numerical Methods in
Engineering 20 (1984), 745-756).

Lengths are measured as if every given triangle were equilateral. With these lengths, the parts of a triangle have only
three shapes, with no angle below 30°. The true shapes follow from these three by one affine map, so that bisection
preserves the shape of the given triangle. A long thin triangle is bisected along both of its directions, as by uniform
subdivision, and its parts do not get thinner.

A cut parts the surface into two sheets along a line. The sheets have separate vertices at the same places. Their
coinciding sides are split together, so that the sheets continue to meet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, IntArray

# Weight of a side's true length: among sides that are equally long to the algorithm, the truly longest is split.
_TIE = 2.0**-10


def marked(count: int, numbers: IntArray) -> BoolArray:
    """Return an array of `count` flags: True at the given indices, else False."""
    marks = np.zeros(count, dtype=bool)
    marks[numbers] = True
    return marks


class Cut(NamedTuple):
    """Vertices that a cut adds, in the order of their numbers."""

    parents: IntArray
    """Shape (k, 2): the ends of the side on which each new vertex lies. If the new vertex is a copy of a vertex on the
    line, both entries are that vertex."""
    along: Float64Array
    """Position as a fraction of the side, shape (k,)."""
    sheets: IntArray
    """Sheet of every vertex, old and new, shape (n + k,): 1 or -1; 0 for a vertex on the line that belongs to no sheet.
    """


class Triangles:
    """Triangles as corners and numbered sides, which can be bisected and cut.

    Parameters
    ----------
    corners : ndarray of int
        Shape (m, 3), vertices in the order of the orientation.
    n_vertices : int
        Number of vertices.
    lengths : ndarray
        Shape (m, 3): true length of the side from each corner to the next; values that are not finite count as 0.

    Attributes
    ----------
    corners : ndarray
        Shape (m, 3).
    sides : ndarray
        Shape (m, 3): number of the side from each corner to the next. Sides with the same ends have the same number.
    ends : ndarray
        Shape (s, 2): ends of each side.
    ties : ndarray
        Shape (s,): a number for each side, its tie. If cuts make copies of a side, the side and its copies have the
        same tie, and their ends are in the same order.
    source : ndarray
        Shape (m,): index of the given triangle of which each triangle is a part.
    places : ndarray
        Shape (n_vertices,): a number for the position of each vertex. If cuts make copies of a vertex, the vertex and
        its copies have the same number.
    n_vertices : int
        Current number of vertices.
    """

    def __init__(self, corners: IntArray, n_vertices: int, lengths: Float64Array) -> None:
        self.corners = corners.copy()
        self.n_vertices = n_vertices
        self.source: IntArray = np.arange(len(corners))
        self.places: IntArray = np.arange(n_vertices)
        following = np.roll(corners, -1, axis=1)
        keys = np.minimum(corners, following) * n_vertices + np.maximum(corners, following)
        unique, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        self.sides: IntArray = inverse.reshape(corners.shape)
        self.ends: IntArray = np.stack(np.divmod(unique, max(n_vertices, 1)), axis=1)
        self.ties: IntArray = np.arange(len(unique))
        self._n_ties = len(unique)
        length = lengths.ravel()[first]
        length[~np.isfinite(length)] = 0.0
        # Squares of the lengths: medians are linear in them.
        self._squares: Float64Array = 1.0 + _TIE * length / (length.max(initial=0.0) or 1.0)

    def __len__(self) -> int:
        return len(self.corners)

    def _add_sides(self, ends: IntArray, squares: Float64Array, ties: IntArray | None = None) -> IntArray:
        """Add sides and return their numbers.

        `ends`, shape (k, 2), has the two vertices of each side. `squares`, shape (k,), has the squared lengths. `ties`,
        shape (k,), has the ties; by default, each side gets a new tie.
        """
        added = len(self.ends) + np.arange(len(ends))
        ties = self._n_ties + np.arange(len(ends)) if ties is None else ties
        self._n_ties = max(self._n_ties, int(ties.max(initial=-1)) + 1)
        self.ends, self.ties = np.concatenate([self.ends, ends]), np.concatenate([self.ties, ties])
        self._squares = np.concatenate([self._squares, squares])
        return added

    def with_tied(self, marks: BoolArray) -> BoolArray:
        """Return flags of sides: True for each side that has the same tie as a side where `marks` is True."""
        if self._n_ties == len(self.ends):  # no sides are tied together
            return marks
        return marked(self._n_ties, self.ties[marks])[self.ties]

    # -- bisection

    def marks(self, rows: IntArray, shaped: BoolArray) -> BoolArray:
        """Return True for the sides to split, shape (s,), so that each triangle is split through its longest side.

        Parameters
        ----------
        rows : ndarray of int
            The triangles to split.
        shaped : ndarray of bool
            Shape (m,): True for triangles with an area. Triangles without an area are split only at sides that
            neighbours split.
        """
        longest = np.take_along_axis(self.sides, self._squares[self.sides].argmax(axis=1)[:, None], axis=1)[:, 0]
        marks = marked(len(self.ends), longest[rows])
        while True:  # terminates, because each pass except the last marks another side
            marks = self.with_tied(marks)
            more = longest[marks[self.sides].any(axis=1) & shaped]
            more = more[~marks[more]]
            if not len(more):
                return marks
            marks[more] = True

    def split(self, marks: BoolArray) -> tuple[IntArray, IntArray]:
        """Split the sides where `marks`, a result of the method `marks`, is True.

        Split all triangles that have such a side.

        Returns
        -------
        parents : ndarray of int
            Shape (k, 2): ends of the sides whose middles are the k new vertices, in the order of their numbers.
        rows : ndarray of int
            Triangles that are new or changed.
        """
        split_sides = np.flatnonzero(marks)
        rows = np.flatnonzero(marks[self.sides].any(axis=1))
        numbers = len(marks) + 2 * len(split_sides) + 3 * len(rows)  # at most 3 in a triangle, a new side for each
        middle, half = np.full((2, numbers), -1)
        middle[split_sides] = self.n_vertices + np.arange(len(split_sides))
        parents = self.ends[split_sides]
        ends = np.stack([parents.ravel(), np.repeat(middle[split_sides], 2)], axis=1)
        _, first, tie = np.unique(self.ties[split_sides], return_index=True, return_inverse=True)
        ties = self._n_ties + (2 * tie[:, None] + np.arange(2)).ravel()
        half[split_sides] = self._add_sides(ends, np.repeat(self._squares[split_sides] / 4.0, 2), ties)[::2]
        self.places = np.concatenate([self.places, self.n_vertices + first[tie]])
        self.n_vertices += len(split_sides)
        changed = [rows[:0]]
        while len(rows):
            children = self._bisect(rows, middle, half)
            changed.append(children)
            rows = children[(middle[self.sides[children]] >= 0).any(axis=1)]
        return parents, np.unique(np.concatenate(changed))

    def _bisect(self, rows: IntArray, middle: IntArray, half: IntArray) -> IntArray:
        """Split each triangle of `rows` from the middle m of its longest split side pq to the opposite corner r.

        Return the indices of the parts. `middle` and `half` have an entry for each side: the vertex at the side's
        middle, and the first of its two halves, which are sides with consecutive numbers. Both entries are −1 if the
        side is not split.
        """
        squares = np.where(middle[self.sides[rows]] >= 0, self._squares[self.sides[rows]], -1.0)
        p, q, r, pq, qr, rp = self._turned(rows, squares.argmax(axis=1))
        m = middle[pq]
        pm = half[pq] + (self.ends[pq, 0] != p)
        mq = half[pq] + (self.ends[pq, 0] == p)
        squares = self._squares
        mr = self._add_sides(np.stack([m, r], axis=1), (2.0 * (squares[rp] + squares[qr]) - squares[pq]) / 4.0)
        return self._replace(rows, [(p, m, r, pm, mr, rp), (m, q, r, mq, qr, mr)])

    def _replace(self, rows: IntArray, parts: list[tuple[IntArray, ...]]) -> IntArray:
        """Replace the triangles `rows` by parts, and return the indices of the parts.

        Each entry of `parts` is one part of every triangle, as six arrays with an element per triangle: three corners,
        then three sides. The first part keeps the index of its triangle; the others get new indices.
        """
        (first, *others), count = (np.stack(part, axis=1) for part in parts), len(self)
        self.corners[rows], self.sides[rows] = first[:, :3], first[:, 3:]
        self.corners = np.concatenate([self.corners, *(part[:, :3] for part in others)])
        self.sides = np.concatenate([self.sides, *(part[:, 3:] for part in others)])
        self.source = np.concatenate([self.source, np.tile(self.source[rows], len(others))])
        return np.concatenate([rows, np.arange(count, len(self))])

    # -- cuts

    def from_end(self, sides: IntArray, vertices: IntArray, along: Float64Array) -> Float64Array:
        """Return the position of the crossing on each of k sides, as a fraction of the side, measured from a given end.

        `sides` and `vertices`, shape (k,), are the sides and the ends to measure from. `along`, shape (s,), has the
        fractions for all sides, measured from each side's first end.
        """
        return np.where(self.ends[sides, 0] == vertices, along[sides], 1.0 - along[sides])

    def cut(self, signs: IntArray, crossed: BoolArray, along: Float64Array, inner: IntArray) -> Cut:
        """Cut along a line that crosses the given sides, and separate the surface into two sheets along the line.

        A triangle with two crossed sides is cut between the crossings, as in marching triangles. A triangle with a
        single crossed side is cut from this crossing to the opposite corner. The squared lengths of the parts' sides
        follow from the affine map that gives the triangle's sides their squared lengths.

        Parameters
        ----------
        signs : ndarray of int
            Shape (n_vertices,): 1 or -1 for the two sides of the line, 0 for vertices on it.
        crossed : ndarray of bool
            Shape (s,): sides to cut, between vertices of opposite signs. Sides with the same tie have the same flag.
        along : ndarray
            Shape (s,): position of the crossing, from the side's first end to its second.
        inner : ndarray of int
            Shape (m,): side of the line, 1 or -1, on which a triangle lies if all its corners are on the line.
        """
        sides = np.flatnonzero(crossed)
        ends, t, squares = self.ends[sides], along[sides], self._squares[sides]
        new, piece = np.full((2, len(self.ends)), -1)
        # the vertex on the sheet of 1; the copy on the sheet of -1 follows it
        new[sides] = self.n_vertices + 2 * np.arange(len(sides))
        _, first, tie = np.unique(self.ties[sides], return_index=True, return_inverse=True)
        own = new[sides, None] + (signs[ends] < 0)
        pieces = np.stack([np.stack([ends[:, 0], own[:, 0]], 1), np.stack([own[:, 1], ends[:, 1]], 1)], axis=1)
        ties = self._n_ties + (2 * tie[:, None] + np.arange(2)).ravel()
        squares = np.stack([squares * t**2, squares * (1.0 - t) ** 2], axis=1).ravel()
        piece[sides] = self._add_sides(pieces.reshape(-1, 2), squares, ties)[::2]
        self.places = np.concatenate([self.places, np.repeat(new[sides][first[tie]], 2)])
        parents, at = np.repeat(ends, 2, axis=0), np.repeat(t, 2)
        signs = np.concatenate([signs, np.tile([1, -1], len(sides))]).astype(np.int64)
        self.n_vertices += 2 * len(sides)
        count = crossed[self.sides].sum(axis=1)
        pairs, singles = np.flatnonzero(count == 2), np.flatnonzero(count == 1)
        self._cut_between(pairs, crossed, along, signs, new, piece)
        self._cut_to_corner(singles, crossed, along, signs, new, piece)
        doubled, sheets = self._part_sheets(signs, inner)
        parents = np.concatenate([parents, np.stack([doubled, doubled], axis=1)])
        return Cut(parents, np.concatenate([at, np.zeros(len(doubled))]), sheets)

    def _turned(self, rows: IntArray, first: IntArray) -> tuple[IntArray, ...]:
        """Return the triangles `rows` with rotated corners and sides: three arrays of corners, then three of sides.

        Each array has the shape (k,). The first corner is the one with the index `first`, 0 to 2, and the first side
        leads from it to the second corner.
        """
        turn = (first[:, None] + np.arange(3)) % 3
        corners, sides = (np.take_along_axis(each[rows], turn, axis=1) for each in (self.corners, self.sides))
        return *corners.T, *sides.T

    def _cut_between(
        self, rows: IntArray, crossed: BoolArray, along: Float64Array, signs: IntArray, new: IntArray, piece: IntArray
    ) -> None:
        """Cut the triangles `rows` with the corners a, b, c from x on ab to y on ca, and split the quadrangle x b c y.

        The quadrangle is split at its shorter diagonal.

        `crossed` and `along` are as for `cut`. `signs` is as for `cut` too, with entries for the new vertices at the
        end. `new` and `piece` have an entry for each side, or −1 if the side is not cut. An entry of `new` is the
        number of the side's new vertex on sheet 1; the copy of this vertex on sheet -1 has the next number. An entry of
        `piece` is the number of the first of the side's two pieces.
        """
        a, b, c, ab, bc, ca = self._turned(rows, ((~crossed[self.sides[rows]]).argmax(axis=1) + 2) % 3)
        is_lower = signs[a] < 0
        xa, xo, ya, yo = new[ab] + is_lower, new[ab] + ~is_lower, new[ca] + is_lower, new[ca] + ~is_lower
        ax, xb = (piece[ab] + (self.ends[ab, 0] != v) for v in (a, b))
        ya_side, cy = (piece[ca] + (self.ends[ca, 0] != v) for v in (a, c))
        x = self.from_end(ab, a, along)
        y = self.from_end(ca, a, along)
        p, q = self._squares[ab], self._squares[ca]
        across = (p + q - self._squares[bc]) / 2.0  # (b − a)·(c − a)
        between = x * x * p + y * y * q - 2.0 * x * y * across
        ties = self._n_ties + np.tile(np.arange(len(rows)), 2)
        ends = np.concatenate([np.stack([xa, ya], axis=1), np.stack([xo, yo], axis=1)])
        of_a, of_others = self._add_sides(ends, np.tile(between, 2), ties).reshape(2, -1)
        xc, yb = x * x * p + q - 2.0 * x * across, p + y * y * q - 2.0 * y * across
        to_c = xc <= yb
        tail, head = np.where(to_c, xo, yo), np.where(to_c, c, b)
        diagonal = self._add_sides(np.stack([tail, head], axis=1), np.minimum(xc, yb))
        near = (xo, b, np.where(to_c, c, yo), xb, np.where(to_c, bc, diagonal), np.where(to_c, diagonal, of_others))
        far_sides = np.where(to_c, diagonal, bc), cy, np.where(to_c, of_others, diagonal)
        far = (np.where(to_c, xo, b), c, yo, *far_sides)
        self._replace(rows, [(a, xa, ya, ax, of_a, ya_side), near, far])

    def _cut_to_corner(
        self, rows: IntArray, crossed: BoolArray, along: Float64Array, signs: IntArray, new: IntArray, piece: IntArray
    ) -> None:
        """Cut the triangles `rows` with the corners p, q, r from x on the side pq to the corner r.

        The other arguments are as for `_cut_between`. Both sheets share the vertex r until `_part_sheets` doubles it.
        """
        p, q, r, pq, qr, rp = self._turned(rows, crossed[self.sides[rows]].argmax(axis=1))
        is_lower = signs[p] < 0
        xp, xq = new[pq] + is_lower, new[pq] + ~is_lower
        px, xq_side = (piece[pq] + (self.ends[pq, 0] != v) for v in (p, q))
        x = self.from_end(pq, p, along)
        square, other = self._squares[pq], self._squares[rp]
        xr = x * x * square + other - x * (square + other - self._squares[qr])
        ties = self._n_ties + np.tile(np.arange(len(rows)), 2)
        ends = np.concatenate([np.stack([xp, r], axis=1), np.stack([xq, r], axis=1)])
        of_p, of_q = self._add_sides(ends, np.tile(xr, 2), ties).reshape(2, -1)
        self._replace(rows, [(p, xp, r, px, of_p, rp), (xq, q, r, xq_side, qr, of_q)])

    def _part_sheets(self, signs: IntArray, inner: IntArray) -> tuple[IntArray, IntArray]:
        """Double the vertices on the line that both sheets share, and the sides between such vertices.

        The existing vertex stays on sheet 1. Its copy is on sheet -1.

        Parameters
        ----------
        signs : ndarray of int
            Shape (n_vertices,): 1 or -1 for vertices on either side of the line, 0 for vertices on it.
        inner : ndarray of int
            Shape (m,): side of the line, 1 or -1, on which a triangle lies if all its corners are on the line.

        Returns
        -------
        doubled : ndarray of int
            Vertices that were doubled, shape (k,).
        sheets : ndarray of int
            Sheet of every vertex, 1 or -1; the k copies come last. 0 for a vertex on the line that belongs to no sheet.
        """
        at_corners = signs[self.corners]
        sheet = np.sign(at_corners.max(axis=1) + at_corners.min(axis=1))  # 0 if an uncut line runs inside
        on_line = np.flatnonzero(~at_corners[: len(inner)].any(axis=1))
        sheet[on_line] = inner[on_line]
        rows, turns = np.nonzero(at_corners == 0)
        vertices, is_used = self.corners[rows, turns], np.zeros((3, self.n_vertices), dtype=bool)
        is_used[sheet[rows], vertices] = True  # 0, 1 and -1 are its three rows
        is_doubled = is_used[-1] & (is_used[1] | is_used[0])
        doubled = np.flatnonzero(is_doubled)
        sheets = np.where(signs == 0, is_used[1].astype(np.int64) - (is_used[-1] & ~is_used[1] & ~is_used[0]), signs)
        copies = np.arange(self.n_vertices)
        copies[doubled] = self.n_vertices + np.arange(len(doubled))
        lower = np.flatnonzero((sheet < 0) & (at_corners == 0).any(axis=1))
        others = np.setdiff1d(np.arange(len(self)), lower)
        is_moved = is_doubled[self.ends].any(axis=1)
        moved = np.unique(self.sides[lower][is_moved[self.sides[lower]]])
        stays = marked(len(self.ends), self.sides[others])
        numbers = np.arange(len(self.ends))
        both = moved[stays[moved]]
        numbers[both] = self._add_sides(self.ends[both], self._squares[both], self.ties[both])
        self.ends[numbers[moved]] = copies[self.ends[moved]]
        self.sides[lower], self.corners[lower] = numbers[self.sides[lower]], copies[self.corners[lower]]
        self.places = np.concatenate([self.places, self.places[doubled]])
        self.n_vertices += len(doubled)
        return doubled, np.concatenate([sheets, np.full(len(doubled), -1)])
