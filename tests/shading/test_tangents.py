"""Tangents reach a reflectance in the world and orthogonal to the normal, in both evaluators; or they are refused."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base.formulas import dot, formula
from pvphong.optics.reflectance import Geometry, Lobe, Reflectance
from pvphong.shading import kernel
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

BACKENDS = ["numpy", *(["numba"] if kernel.is_available() else [])]
SUN = ph.DirectionalLight(direction=(1, -2, -4), diffuse=1.0)
SHEAR = np.array([[2.0, 0.7, 0.0, 5.0], [0.0, -1.0, 0.4, 0.0], [0.3, 0.0, 0.5, 1.0], [0.0, 0.0, 0.0, 1.0]])


@formula
def along_tangent(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001
    l_t = dot(at.l, at.t)
    return (l_t * l_t,)


@dataclass(frozen=True)
class Brushed(Reflectance):
    """Reflectance with the factor (l·t)²."""

    lobes: ClassVar[tuple[Lobe, ...]] = (Lobe("diffuse", takes_albedo=True, needs_viewer=False),)
    needs: ClassVar[frozenset[str]] = frozenset({"tangents"})

    factors = staticmethod(along_tangent)


MATERIAL = ph.Material(ambient=0, diffuse=1, reflectance=Brushed())


@pytest.fixture
def given():
    random = np.random.default_rng(8)
    return random.normal(size=(300, 3)), random.normal(size=(300, 3)), 1e3 * random.normal(size=(300, 3))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("precision", "most"), [("float32", 2e-6), ("float64", 1e-13)])
@pytest.mark.parametrize("matrix", [None, SHEAR], ids=["here", "shear"])
def test_they_go_as_differences_of_points_and_come_across_the_normal(given, backend, precision, most, matrix):
    points, normals, tangents = given
    how = {"matrix": matrix, "precision": precision, "backend": backend}
    lit = ph.evaluate(points, normals, SUN, replace(MATERIAL, tangents=tangents), **how).rgb[:, 0]
    linear = np.eye(3) if matrix is None else matrix[:3, :3]
    n, t = normals @ np.linalg.inv(linear), tangents @ linear.T
    t = t - ((t * n).sum(1) / (n * n).sum(1))[:, None] * n
    l = -np.array(SUN.direction) / np.linalg.norm(SUN.direction)
    assert np.abs(lit - (t @ l) ** 2 / (t * t).sum(1)).max() < most


@pytest.mark.parametrize("backend", BACKENDS)
def test_one_along_its_normal_gives_nothing_there(given, backend):
    points, normals, _ = given
    lit = ph.evaluate(
        points, 2.0 ** np.arange(300)[:, None] * (0, 0, 1), SUN, replace(MATERIAL, tangents=[(0, 0, 3)] * 300)
    )
    assert not lit.rgb.any()
    normals[7] = np.nan
    lit = ph.evaluate(
        points, normals, SUN, replace(MATERIAL, tangents=np.where(np.isnan(normals), 0, 1)), backend=backend
    )
    assert np.isfinite(lit.rgb).all()
    assert not lit.rgb[7].any()


def test_a_mesh_takes_them_from_texture_coordinates_or_a_named_array():
    mesh = pv.Plane(i_resolution=5, j_resolution=5)
    light = ph.DirectionalLight(direction=(1, 0, -1))
    assert mesh.phong.shade(light, MATERIAL)["phong"][:, 0] == pytest.approx(0.5)
    mesh["grain"] = np.tile((0.0, 3.0, 0.0), (mesh.n_points, 1))
    assert mesh.phong.shade(light, replace(MATERIAL, tangents="grain"))["phong"].max() < 1e-12
    solid = pv.ImageData(dimensions=(3, 3, 3))
    sharp = solid.phong.shade(light, replace(MATERIAL, tangents=np.tile((1.0, 1e-9, 0.5), (27, 1))), feature_angle=30)
    assert sharp.n_points == 6 * 9
    assert np.isfinite(sharp["phong"]).all()


def test_a_window_takes_them_from_texture_coordinates():
    plotter = pv.Plotter(off_screen=True, lighting="none")
    plotter.phong.add_light(ph.DirectionalLight(direction=(1, 0, -1)))
    actor = plotter.phong.add_mesh(mesh := pv.Plane(), MATERIAL)
    shown = actor.mapper.dataset.point_data
    before = shown.active_scalars.copy()
    mesh.active_texture_coordinates = mesh.active_texture_coordinates[:, ::-1]
    plotter.screenshot()
    assert (before.max(), shown.active_scalars.max()) == (127, 0)
    plotter.close()


MUST = "^tangents must be "


@pytest.mark.parametrize(
    ("tangents", "message"),
    [
        (None, MUST + r"known for this reflectance; got None\. Name a point array .*texture coordinates"),
        (np.zeros((300, 3)), MUST + "finite vectors other than zero; got .* at vertex 0"),
        (np.where(np.arange(300)[:, None] == 8, np.inf, np.ones(3)), MUST + "finite .* at vertex 8"),
        (np.ones((299, 3)), MUST + "an array with one row per point, 300 rows"),
        (np.ones((300, 2)), MUST + r"an \(n, 3\) array"),
    ],
)
def test_what_cannot_be_tangents_is_refused(given, tangents, message):
    points, normals, _ = given
    with pytest.raises(ValueError, match=message):
        ph.evaluate(points, normals, SUN, replace(MATERIAL, tangents=tangents))


def test_they_are_read_where_a_reflectance_asks_for_them(given):
    points, normals, _ = given

    def fail() -> Any:
        raise AssertionError

    vertices = Vertices(points, normals, tangents=fail)
    scene = ph.Scene([SUN], ph.Viewer())
    plan = Plan.of(scene, ph.Material(), vertices)
    assert "tangents" not in plan.needs
    plan.run(vertices)
    assert "tangents" in Plan.of(scene, MATERIAL, vertices).needs
    with pytest.raises(ValueError, match=r"^tangents must be .*Normals.*; got 'nonsense'"):
        pv.Sphere().phong.shade(SUN, replace(MATERIAL, tangents="nonsense"))


def test_tangents_whose_blend_inside_of_a_triangle_cancels_are_none_there():
    """A direction and its opposite mean the same brushing, so a user may have both."""
    triangle = pv.PolyData(np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)]), [3, 0, 1, 2])
    triangle.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (3, 1))
    along = np.array([(1.0, 0, 0), (-1, 0, 0), (1, 0, 0)])
    brushed = replace(MATERIAL, tangents=along, reflectance=ph.Ward(0.2, 0.5))
    fine = triangle.phong.refine(SUN, brushed, tolerance=0.05, max_points=100)
    assert np.isfinite(fine["phong"]).all()
