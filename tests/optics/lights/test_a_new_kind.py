"""A custom kind of light: evaluation and planning need only its class."""

from __future__ import annotations

import pydoc
import re
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base.vectors import towards
from pvphong.optics.light import Arrival
from pvphong.optics.lights import LIGHT_TYPES, Light
from pvphong.shading import kernel
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

EYE = ph.Viewer(position=(0, -4, 3))
SHINY = ph.Material(diffuse=0.6, specular=0.5, shininess=20)


@dataclass(frozen=True)
class Lantern(Light):
    """Lantern at (0, 0, 2) that shines downwards, with a strength equal to the cosine off the vertical."""

    def arrival(self, points: Any, real: Any = np.float64) -> Arrival:
        direction, _ = towards((0.0, 0.0, 2.0), points, real)
        return Arrival(direction, np.maximum(direction[2], 0.0).astype(np.float64))


@pytest.fixture
def mesh():
    return pv.Sphere()


@pytest.mark.parametrize(
    "backend",
    ["auto", "numpy", pytest.param("numba", marks=pytest.mark.skipif(not kernel.is_available(), reason="no Numba"))],
)
@pytest.mark.parametrize("tolerance", [0.0, 1 / 255, 0.1])
def test_it_is_evaluated_and_nothing_is_assumed_of_it(mesh, backend, tolerance):
    scene = ph.Scene([Lantern(name="lantern")], EYE)
    points, normals = np.array(mesh.points), np.array(mesh.point_normals)
    got = ph.evaluate(points, normals, scene, SHINY, precision="float64", backend=backend, tolerance=tolerance).rgb
    spot = ph.SpotLight(position=(0, 0, 2), direction=(0, 0, -1), cone_angle=90, exponent=1)
    expected = ph.evaluate(points, normals, ph.Scene([spot], EYE), SHINY, precision="float64", backend="numpy").rgb
    np.testing.assert_allclose(got, expected, atol=max(tolerance, 1e-14))
    assert got.max() > 0.3


def test_a_highlight_that_anything_known_of_a_light_would_rule_out_stays():
    grazing = np.array([[x, y, 0.0] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
    up = np.broadcast_to((0.0, 0.0, 1.0), grazing.shape)
    scene = ph.Scene([Lantern()], ph.Viewer(position=(0, 0, 50)))
    exact = ph.evaluate(grazing, up, scene, SHINY).rgb
    np.testing.assert_allclose(ph.evaluate(grazing, up, scene, SHINY, tolerance=0.1).rgb, exact, atol=1e-6)
    plan = Plan.of(scene, SHINY, Vertices(grazing, up), tolerance=0.1)
    assert plan.effects["specular"].on
    assert plan.effects["local viewer"].on


@pytest.mark.parametrize("base", [ph.DirectionalLight, ph.PointLight, ph.SpotLight])
def test_a_kind_of_a_kind_is_refused_because_its_own_arrival_would_be_overlooked(base):
    with pytest.raises(TypeError, match=r"^Flood must derive directly from Light; got (Directional|Point|Spot)Light\."):
        type("Flood", (base,), {})


def test_a_kind_that_says_nothing_of_what_arrives_is_refused():
    with pytest.raises(TypeError, match=r"^Dark must override `placement`, `arrival` or `nodes`\."):
        type("Dark", (Light,), {})


def test_what_is_judged_by_vtk_says_that_vtk_does_not_have_it(mesh):
    scene = ph.Scene([Lantern()], EYE)
    with pytest.raises(ValueError, match=r"^lights\[0\] must be a light that VTK supports; got a Lantern"):
        ph.validate(mesh, scene, SHINY)
    left_out = ph.tradeoff(mesh, scene, SHINY, seconds=2).left_out
    assert "a Lantern" in left_out["textbook NumPy"]


def test_a_scene_with_it_is_not_saved_halfway(tmp_path):
    with pytest.raises(
        ValueError,
        match=r"^lights\[1\] must be of a built-in type \(directional, .*, spot\) to be saved in a file; got Lantern",
    ):
        ph.Scene([ph.PointLight(), Lantern()]).save(tmp_path / "rig.json")
    assert not list(tmp_path.iterdir())


def test_a_window_says_that_vtk_has_nothing_like_it():
    assert Lantern not in LIGHT_TYPES.values()
    plotter = pv.Plotter(off_screen=True)
    plotter.add_mesh(pv.Sphere())
    try:
        handle = plotter.phong.add_light(ph.PointLight())
        before = plotter.phong.lights
        for put in (plotter.phong.add_light, lambda light: plotter.phong.set_light(handle, light)):
            with pytest.raises(ValueError, match=r"^light must be a light that VTK supports; got Lantern"):
                put(Lantern())
        assert plotter.phong.lights == before
    finally:
        plotter.close()


@pytest.mark.parametrize("kind", LIGHT_TYPES.values())
def test_help_and_tab_show_what_users_need_and_not_how_it_is_evaluated(kind):
    shown = pydoc.render_doc(kind, renderer=pydoc.plaintext)
    methods = set(re.findall(r"^ \|  (\w+)(?:\(| =|$)", shown, re.MULTILINE))
    assert {"in_world", "to_pyvista", *(each.name for each in fields(kind))} <= methods
    internal = {"effects", "nodes", "tints", "simpler", "closed", "reach", "arrival", "placement", "without"}
    internal |= {
        "area",
        "bands",
        "error_without_bands",
        "part",
        "reach_radius",
        "sampled",
        "sides",
        "spots",
        "triangles",
    }
    assert not internal & methods
    assert not internal & set(dir(kind()))
    assert "placement" in dir(Light)
