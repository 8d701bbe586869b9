"""Stages: a ground, a curved backdrop or a plinth under a mesh, with points that are close enough for shadows."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.scene.presets import Surroundings
from pvphong.scene.viewer import Viewer

Stage = Literal["ground", "backdrop", "plinth"]


class StageOptions(NamedTuple):
    """Arguments with which `stage` makes a stage again."""

    bounds: tuple[float, ...]
    """Bounds of the meshes on the stage: x_min, x_max, y_min, y_max, z_min, z_max."""
    kind: Stage
    viewer: Viewer | None

    def make(self) -> pv.PolyData:
        """Return the stage's surface."""
        return stage(self.bounds, self.kind, self.viewer)


# Lengths in diagonals of the mesh's bounds. The gap keeps the stage apart from a face that it touches.
_GAP = 1e-4
_GROUND = 2.0  # from the centre to each side
_FRONT, _BEHIND, _BEND, _WALL, _SIDE = 1.8, 0.9, 0.6, 1.2, 2.2
_DENSITY = 0.35  # spacing under the mesh, divided by the average
_RIM, _PLINTH = 0.1, 0.25  # width of the plinth's rim around the mesh, and its height


def stage(
    mesh: Any, kind: Stage = "backdrop", viewer: Viewer | None = None, *, spacing: float = 1.0 / 80.0
) -> pv.PolyData:
    """Return a surface on which a mesh stands.

    Parameters
    ----------
    mesh : pyvista.DataSet, pyvista.MultiBlock, or sequence of float
        The mesh, or its bounds (x_min, x_max, y_min, y_max, z_min, z_max).
    kind : {"backdrop", "ground", "plinth"}
        "backdrop" is a floor that bends up into a wall behind the mesh. "ground" is a flat square. "plinth" is a round
        pedestal on a round ground.
    viewer : Viewer, optional
        The viewer; by default, PyVista's default view of the mesh. The coordinate axis nearest to its `up` is the
        stage's up direction. The wall of a backdrop is opposite to the viewer.
    spacing : float, default 1/80
        Distance between points of the stage under the mesh, as a fraction of the diagonal of the mesh's bounds, from
        0.001 to 0.5. Far from the mesh, points are farther apart. Shadows are computed at points, so a smaller spacing
        makes the shadows' edges sharper.

    Returns
    -------
    pyvista.PolyData
        A surface without normals; its front is the upper side. It is lit like any other mesh.

    Raises
    ------
    ValueError
        If the mesh is empty, or an argument is invalid.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ball = pv.Sphere()
    >>> floor = ph.stage(ball, "ground")
    >>> bool(floor.bounds[4] < ball.bounds[4])
    True
    """
    check.choice("kind", kind, get_args(Stage))
    spacing = check.number("spacing", spacing, at_least=0.001, at_most=0.5)
    around = Surroundings(mesh, viewer)
    size, bounds = around.size, around.bounds
    axis = int(np.abs(around.viewer.up).argmax())
    up = np.zeros(3)
    up[axis] = np.sign(around.viewer.up[axis])
    low = bounds[2 * axis] if up[axis] > 0.0 else bounds[2 * axis + 1]
    foot = around.center.copy()
    foot[axis] = low - up[axis] * _GAP * size
    behind = -around.level(up)
    right = np.cross(behind, up)
    wide = 3.0 * spacing  # away from the mesh
    if kind == "plinth":
        half = 0.5 * float(np.linalg.norm(np.delete(bounds[1::2] - bounds[::2], axis))) / size + _RIM
        top, side = _steps(0.0, half, spacing), _steps(0.0, _PLINTH, spacing)
        around_it = half + _denser_at_0(_GROUND, spacing)
        turns = _steps(0.0, 2.0 * np.pi, spacing / half)[:, None, None]
        outwards = np.cos(turns) * behind + np.sin(turns) * right

        def ring(depths: Float64Array, heights: Float64Array) -> pv.PolyData:
            points = foot + size * (depths[:, None] * outwards + heights[:, None] * up)
            return _grid(points).clean(tolerance=1e-9)

        # the parts share no points, so that the edges between them are sharp
        parts = (
            (top, np.zeros(len(top))),
            (np.full(len(side), half), -side),
            (around_it, np.full(len(around_it), -_PLINTH)),
        )
        first, *others = (ring(*part) for part in parts)
        return first.append_polydata(*others)
    sides = _denser_at_0(_GROUND if kind == "ground" else _SIDE, spacing)
    across = np.concatenate([-sides[:0:-1], sides])
    if kind == "ground":
        depths, heights = across, np.zeros(len(across))
    else:
        front, back = _denser_at_0(_FRONT, spacing), _denser_at_0(_BEHIND, spacing)
        bend, wall = _steps(0.0, 0.5 * np.pi, wide / _BEND)[1:], _steps(_BEND, _BEND + _WALL, wide)[1:]
        depths = np.concatenate(
            [-front[:0:-1], back, _BEHIND + _BEND * np.sin(bend), np.full(len(wall), _BEHIND + _BEND)]
        )
        heights = np.concatenate([np.zeros(len(front) + len(back) - 1), _BEND * (1.0 - np.cos(bend)), wall])
    profile = depths[:, None] * behind + heights[:, None] * up
    return _grid(foot + size * (across[:, None, None] * right + profile))


def _steps(first: float, last: float, spacing: float) -> Float64Array:
    """Return evenly spaced numbers from `first` to `last`, including both. Neighbours are at most `spacing` apart."""
    return np.linspace(first, last, 1 + int(np.ceil((last - first) / spacing)))


def _denser_at_0(last: float, spacing: float) -> Float64Array:
    """Return increasing numbers from 0 to `last`.

    Neighbours are `spacing` apart at 0, and up to 6 times as far apart at the end.
    """
    t = _steps(0.0, 1.0, spacing / (_DENSITY * last))
    return np.asarray(last * (_DENSITY * t + (1.0 - _DENSITY) * t**3))


def _grid(points: Float64Array) -> pv.PolyData:
    """Return a surface of quads between a grid of points, shape (m, n, 3).

    The fronts are on the side of the cross product i × j. Here i and j are the directions in which the first and the
    second index increase.
    """
    rows, columns, _ = points.shape
    numbers = np.arange(rows * columns).reshape(rows, columns)
    corners = np.stack([numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]], axis=-1)
    return pv.PolyData.from_regular_faces(points.reshape(-1, 3), corners.reshape(-1, 4))
