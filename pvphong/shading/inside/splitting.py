"""Conforming bisection of triangles, on index arrays alone: who is whose neighbour, not where anything lies.

A triangle is always cut through the middle of its longest side, and a side that is cut is cut for all triangles
that share it, so that no vertex ever lies inside another triangle's side. This is longest-edge bisection
(M.-C. Rivara: Algorithms for refining triangular grids suitable for adaptive and multigrid techniques.
International Journal for Numerical Methods in Engineering 20 (1984), 745-756).

"Longest" is measured as if every triangle had come with equal sides. Its descendants are then, up to that affine
map, of three shapes only, with no angle below 30°: cutting keeps the shape that a triangle came with. A long thin
triangle is cut along both of its directions, as uniform subdivision would, and never into ever thinner ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, IntArray

# How much of a side's true length counts, so that of sides that are equally long to the algorithm the truly
# longest is cut.
_TIE = 2.0**-10


class Cut(NamedTuple):
    """What one round of bisection did."""

    parents: IntArray
    """(k, 2): the ends of the sides whose middles are the k new vertices, in the order of their numbers."""

    rows: IntArray
    """The triangles that are new or changed."""


class Triangles:
    """Triangles as corners and numbered sides, which can be cut.

    Parameters
    ----------
    corners : ndarray of int
        Shape (m, 3), vertices in their orientation.
    n_vertices : int
        How many vertices there are.
    lengths : ndarray
        Shape (m, 3): true length of the side from each corner to the next; what is not finite counts as 0.

    Attributes
    ----------
    corners : ndarray
        Shape (m, 3).
    sides : ndarray
        Shape (m, 3): the number of the side from each corner to the next. Sides with the same ends are one.
    source : ndarray
        Shape (m,): which of the first triangles each is a part of.
    n_vertices : int
        How many vertices there are now.
    """

    def __init__(self, corners: IntArray, n_vertices: int, lengths: Float64Array) -> None:
        self.corners = corners.copy()
        self.n_vertices = n_vertices
        self.source: IntArray = np.arange(len(corners))
        following = np.roll(corners, -1, axis=1)
        keys = np.minimum(corners, following) * n_vertices + np.maximum(corners, following)
        unique, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        self.sides: IntArray = inverse.reshape(corners.shape)
        self._ends: IntArray = np.stack(np.divmod(unique, max(n_vertices, 1)), axis=1)
        length = lengths.ravel()[first]
        length[~np.isfinite(length)] = 0.0
        # Squares of the lengths: medians are linear in them.
        self._squares: Float64Array = 1.0 + _TIE * length / (length.max(initial=0.0) or 1.0)

    def __len__(self) -> int:
        return len(self.corners)

    def marks(self, rows: IntArray, shaped: BoolArray) -> BoolArray:
        """Which sides must be cut so that some triangles are cut, and all that have a shape through their longest side.

        Parameters
        ----------
        rows : ndarray of int
            The triangles to cut.
        shaped : ndarray of bool
            Shape (m,): False for triangles that are cut only where their neighbours are.
        """
        longest = np.take_along_axis(self.sides, self._squares[self.sides].argmax(axis=1)[:, None], axis=1)[:, 0]
        marks = np.zeros(len(self._ends), dtype=bool)
        marks[longest[rows]] = True
        while True:  # ends, for each turn but the last marks a side more
            more = longest[marks[self.sides].any(axis=1) & shaped]
            more = more[~marks[more]]
            if not len(more):
                return marks
            marks[more] = True

    def have_two_triangles(self, marks: BoolArray) -> BoolArray:
        """Whether each marked side lies between two triangles, and not on a boundary or where several sheets meet."""
        result: BoolArray = np.bincount(self.sides.ravel(), minlength=len(marks))[marks] == 2
        return result

    def cut(self, marks: BoolArray) -> Cut:
        """Cut the sides that `marks` gave, and all triangles that have them."""
        cut_sides = np.flatnonzero(marks)
        rows = np.flatnonzero(marks[self.sides].any(axis=1))
        numbers = len(marks) + 2 * len(cut_sides) + 3 * len(rows)  # at most 3 cuts in a triangle, a new side for each
        middle, half = np.full((2, numbers), -1)
        middle[cut_sides] = self.n_vertices + np.arange(len(cut_sides))
        half[cut_sides] = len(marks) + 2 * np.arange(len(cut_sides))
        parents = self._ends[cut_sides]
        ends = np.stack([parents.ravel(), np.repeat(middle[cut_sides], 2)], axis=1)
        self._add_sides(ends, np.repeat(self._squares[cut_sides] / 4.0, 2))
        self.n_vertices += len(cut_sides)
        changed = [rows[:0]]
        while len(rows):
            children = self._bisect(rows, middle, half)
            changed.append(children)
            rows = children[(middle[self.sides[children]] >= 0).any(axis=1)]
        return Cut(parents, np.unique(np.concatenate(changed)))

    def _bisect(self, rows: IntArray, middle: IntArray, half: IntArray) -> IntArray:
        """Cut each triangle from the middle m of its longest cut side pq to the opposite corner r."""
        squares = np.where(middle[self.sides[rows]] >= 0, self._squares[self.sides[rows]], -1.0)
        turn = (squares.argmax(axis=1)[:, None] + np.arange(3)) % 3
        p, q, r = np.take_along_axis(self.corners[rows], turn, axis=1).T
        pq, qr, rp = np.take_along_axis(self.sides[rows], turn, axis=1).T
        m = middle[pq]
        pm = half[pq] + (self._ends[pq, 0] != p)
        mq = half[pq] + (self._ends[pq, 0] == p)
        mr = len(self._ends) + np.arange(len(rows))
        squares = self._squares
        self._add_sides(np.stack([m, r], axis=1), (2.0 * (squares[rp] + squares[qr]) - squares[pq]) / 4.0)
        self.corners[rows] = np.stack([p, m, r], axis=1)
        self.sides[rows] = np.stack([pm, mr, rp], axis=1)
        added = len(self) + np.arange(len(rows))
        self.corners = np.concatenate([self.corners, np.stack([m, q, r], axis=1)])
        self.sides = np.concatenate([self.sides, np.stack([mq, qr, mr], axis=1)])
        self.source = np.concatenate([self.source, self.source[rows]])
        return np.concatenate([rows, added])

    def _add_sides(self, ends: IntArray, squares: Float64Array) -> None:
        self._ends = np.concatenate([self._ends, ends])
        self._squares = np.concatenate([self._squares, squares])
