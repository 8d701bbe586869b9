"""Types that an editor sees through annotated accessors. mypy checks this file in CI; nothing imports it."""

from typing import assert_type

import pyvista as pv

import pvphong as ph
from pvphong.shading.plan.plan import Plan
from pvphong.studio.live import LightHandle

mesh: ph.MeshPhong = pv.Sphere().phong
blocks: ph.BlocksPhong = pv.MultiBlock().phong
window: ph.PlotterPhong = pv.Plotter().phong

assert_type(mesh.plan(ph.PointLight()), Plan)
assert_type(window.add_light(ph.PointLight()), LightHandle)
mesh.shad  # type: ignore[attr-defined] # noqa: B018 mypy refuses an unused "ignore", so this must be an error
blocks.shad  # type: ignore[attr-defined] # noqa: B018
window.shad  # type: ignore[attr-defined] # noqa: B018
