"""The kinds of light, one file each.

`aimed.py` is shared by lights with a direction, `sized.py` by flat area lights. `conversion.py` converts lights to
other notations.

A new kind of light needs:

- a file in this folder, and an entry in `LIGHT_TYPES`;
- its name and module in `pvphong/__init__.py`, and its fields in the guide;
- a strategy in `tests/strategies.py`, which includes it in all property-based tests;
- a light in `tests/rays/test_paths.py`, which has one of each kind;
- if it has no `nodes`: the light that VTK draws in its place, registered in `conversion.py`;
- if it has a cheaper replacement: this replacement, in `pvphong/shading/plan/lights.py`.

An area light overrides `nodes`. An `analytic_integral` makes it exact. With `sampling`, rays are cast to it, for soft
shadows and `truth`.
"""

from __future__ import annotations

from pvphong.optics.light import Light
from pvphong.optics.lights.conversion import (
    VtkValues,
    is_in_vtk,
    light_from_homogeneous,
    light_from_values,
    nearest_in_vtk,
    refuse_unless_in_vtk,
    vtk_values,
)
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.lights.disk import DiskLight
from pvphong.optics.lights.environment import EnvironmentLight
from pvphong.optics.lights.photometric import PhotometricLight
from pvphong.optics.lights.point import PointLight
from pvphong.optics.lights.polygon import PolygonLight
from pvphong.optics.lights.rectangle import RectangleLight
from pvphong.optics.lights.sphere import SphereLight
from pvphong.optics.lights.spot import SpotLight

LIGHT_TYPES: dict[str, type[Light]] = {
    "directional": DirectionalLight,
    "disk": DiskLight,
    "environment": EnvironmentLight,
    "photometric": PhotometricLight,
    "point": PointLight,
    "polygon": PolygonLight,
    "rectangle": RectangleLight,
    "sphere": SphereLight,
    "spot": SpotLight,
}
"""Mapping from the name in a scene file to the class."""


__all__ = [
    "LIGHT_TYPES",
    "DirectionalLight",
    "DiskLight",
    "EnvironmentLight",
    "Light",
    "PhotometricLight",
    "PointLight",
    "PolygonLight",
    "RectangleLight",
    "SphereLight",
    "SpotLight",
    "VtkValues",
    "is_in_vtk",
    "light_from_homogeneous",
    "light_from_values",
    "nearest_in_vtk",
    "refuse_unless_in_vtk",
    "vtk_values",
]
