"""Panes for the tests of drags: every projection at every scale."""

import itertools

import numpy as np

from pvphong.scene.viewer import Viewer
from pvphong.studio.gizmos.press import Place
from pvphong.studio.gizmos.view import View

SCALES = (1e-6, 1.0, 1e6)
PROJECTIONS = ("perspective", "parallel")
EVERYWHERE = list(itertools.product(PROJECTIONS, SCALES))


def view(projection="perspective", scale=1.0, *, position=(4.0, -7.0, 5.0), focal_point=(0.1, 0.2, 0.3), up=(0, 0, 1)):
    """An eye that looks at a scene of this scale, in the middle of a larger window."""
    viewer = Viewer(
        position=scale * np.array(position),
        focal_point=scale * np.array(focal_point),
        up=up,
        parallel=projection == "parallel",
        parallel_scale=2.5 * scale,
        view_angle=35.0,
    )
    return View(viewer, size=(640.0, 480.0), origin=(100.0, 30.0))


def place(scale=1.0):
    return Place(center=(0.0, 0.0, 0.0), size=2.0 * scale, anchor=(0.0, 0.0, 1.9 * scale))
