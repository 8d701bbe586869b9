"""Views and lights for the tests of gizmos: every kind of light, in every projection, at every scale."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvphong import Light, Viewer
from pvphong.optics.lights import LIGHT_TYPES, DirectionalLight, PointLight, vtk_values
from pvphong.optics.roles import Aim, Angle, Corners, Falloff, Length, Place, Power, Up, length, place
from pvphong.studio.gizmos.handles import ORIGIN, LightInScene, comes_from_somewhere, is_movable
from pvphong.studio.gizmos.view import Scenery, View

SCALES = (1e-6, 1.0, 1e6)
PROJECTIONS = ("perspective", "parallel")
EVERYWHERE = list(itertools.product(PROJECTIONS, SCALES))


@dataclass(frozen=True)
class Globe(Light):
    """A light class unknown to pvphong, with two fields with roles. Larger lights are brighter."""

    position: Any = place()
    radius: float = length(1.0, "radius", share=0.5)

    def nodes(self, count):  # noqa: ARG002 its centre does for all
        return (PointLight(position=self.position, attenuation=(1.0, 0.0, self.radius**-2)),)


@dataclass(frozen=True)
class Glow(Light):
    """A light class without a field for its position."""

    size: float = length(1.0, "size")

    def nodes(self, count):  # noqa: ARG002 it has no size in truth
        return (DirectionalLight(),)


vtk_values.register(Glow, lambda _: vtk_values(DirectionalLight()))


KINDS = LIGHT_TYPES | {"globe": Globe}


def example(kind, scale=1.0, **values):
    """Return a light of a class next to a scene of some scale; `values` sets fields by role."""
    chosen = {
        Place: values.pop("place", (1.0, -0.5, 1.0)),
        Aim: values.pop("aim", (-1.0, 0.4, -1.0)),
        Length: values.pop("length", 0.4),
        Angle: values.pop("angle", 22.0),
        Power: values.pop("power", 9.0),
        Falloff: values.pop("falloff", (1.0, 0.3, 0.5)),
    }
    chosen[Up] = (0.2, 1.0, 0.3)
    chosen[Corners] = triangle(chosen[Place], chosen[Aim])
    units = {Place: scale, Corners: scale, Aim: scale, Length: scale, Falloff: scale ** -np.arange(3.0)}
    for field, role in KINDS[kind]().roles.items():
        for of in chosen:
            if isinstance(role, of):
                values.setdefault(field, np.multiply(chosen[of], units.get(of, 1.0)).tolist())
    return KINDS[kind](**values)


def triangle(middle, normal):
    """Return corners around a point, with the front towards a direction."""
    across = np.cross(normal, (0.3, -0.2, 1.0))
    other = np.cross(normal, across)
    return middle + 0.3 * np.array([a * across + b * other for a, b in ((1.0, 0.0), (-0.5, 0.4), (-0.5, -0.4))])


MOVABLE = [kind for kind in KINDS if is_movable(example(kind))]
"""Lights that can be dragged; the others have no icon and no handle."""

FROM_SOMEWHERE = [kind for kind in MOVABLE if comes_from_somewhere(example(kind))]
"""Lights with a position or a direction; the others have no highlight to drag, and no double."""


def view(projection="perspective", scale=1.0, *, position=(4.0, -7.0, 5.0), focal_point=(0.1, 0.2, 0.3), up=(0, 0, 1)):
    """Return a viewer of a scene of some scale, in the middle of a larger window."""
    viewer = Viewer(
        position=scale * np.array(position),
        focal_point=scale * np.array(focal_point),
        up=up,
        parallel=projection == "parallel",
        parallel_scale=2.5 * scale,
        view_angle=35.0,
    )
    return View(viewer, size=(640.0, 480.0), origin=(100.0, 30.0))


def scenery(scale=1.0):
    return Scenery(center=(0.0, 0.0, 0.0), size=2.0 * scale, anchor=(0.0, 0.0, 1.9 * scale))


def handles(light, around=None, seen_from=None):
    """Return handle name → position, for the visible handles of a light in world space."""
    return LightInScene(light, around or scenery()).points(seen_from or view())


EACH = [(kind, handle) for kind in KINDS for handle in handles(example(kind))]
"""Every handle of every kind of light."""


def role_of(kind, handle):
    """Return the role and the field that a handle edits."""
    found = {role.handle: (type(role), field) for field, role in KINDS[kind]().roles.items() if role.handle}
    if handle == ORIGIN:  # the other handle of the only aim
        return found["target"]
    return found[handle]
