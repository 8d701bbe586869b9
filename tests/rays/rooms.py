"""Meshes of walls, and of rooms whose normals point inwards."""

import numpy as np
import pyvista as pv


def wall(center, direction, size=1.0, cells=4):
    """Return a triangulated square with normals in a direction."""
    sizes = {"i_size": size, "j_size": size, "i_resolution": cells, "j_resolution": cells}
    mesh = pv.Plane(center=center, direction=direction, **sizes).triangulate()
    mesh.point_data.active_normals = np.tile(np.asarray(direction, np.float32), (mesh.n_points, 1))
    return mesh


def room(cells=4):
    """Return six walls around the origin as one mesh."""
    sides = [np.array(sign * axis, float) for axis in np.eye(3) for sign in (1, -1)]
    walls = [wall(-0.5 * side, side, cells=cells) for side in sides]
    return walls[0].append_polydata(*walls[1:])


def hollow(nsub=2):
    """Return a sphere of radius 1 with normals that point inwards."""
    ball = pv.Icosphere(nsub=nsub)
    ball.points /= np.linalg.norm(ball.points, axis=1)[:, None]
    ball.clear_data()
    ball.point_data.active_normals = -ball.points
    return ball
