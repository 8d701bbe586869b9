"""Specular reflectance, shininess and roughness of each vertex: as if each had a material of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from strategies import REFLECTANCE_SHAPES, Dice

import pvphong as ph
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

COUNT = 60
SHARES = {"specular": (0.0, 0.9), "shininess": (0.0, 90.0), "roughness": (0.05, 1.0)}
MAPPED = [(name, field) for name, kind in REFLECTANCES.items() for field in sorted(kind.maps)]
LIGHTS = [ph.PointLight(position=(1, -2, 4), ambient=0.1), ph.DirectionalLight(direction=(1, 1, -2), diffuse=0.3)]
SCENE = ph.Scene(LIGHTS, ph.Viewer((-1, -2, 5)), ph.LightModel(clamp=False))


def with_field(material, field, value):
    """The material with another number, in its reflectance if that has it."""
    if field in vars(material.reflectance):
        return replace(material, reflectance=replace(material.reflectance, **{field: value}))
    return replace(material, **{field: value})


@pytest.fixture
def given():
    random = np.random.default_rng(3)
    points = random.uniform(-1, 1, (COUNT, 3))
    return points, points + 0.2 * random.normal(size=(COUNT, 3))


def numbers_of(field):
    low, high = SHARES[field]
    found = np.random.default_rng(5).uniform(low, high, COUNT)
    found[:6] = (low, high, 1.0, 0.5, high, 0.1)
    return found


def material_of(name):
    shape = {"alpha_x": 0.5, "alpha_y": 0.9} if name == "ward" else REFLECTANCE_SHAPES[name](Dice(4))
    reflectance = REFLECTANCES[name](**shape)
    return ph.Material(diffuse=(0.2, 0.3, 0.4), specular=0.5, shininess=12, reflectance=reflectance)


@pytest.mark.parametrize(("precision", "most"), [("float32", 1e-4), ("float64", 1e-13)])
@pytest.mark.parametrize(("name", "field"), MAPPED)
def test_each_vertex_has_a_material_of_its_own(given, name, field, precision, most):
    points, normals = given
    material, numbers = material_of(name), numbers_of(field)
    how = {"precision": precision, "components": True}
    vertices = {"points": points, "normals": normals, "tangents": points, "albedo": np.abs(points)}
    lit = ph.evaluate(**vertices, scene=SCENE, material=material, **{field: numbers}, **how)
    for k, number in enumerate(numbers):
        part = slice(k, k + 1)
        own = {name: array[part] for name, array in vertices.items()} | {"scene": SCENE} | how
        one = ph.evaluate(**own, material=with_field(material, field, number))
        alone = ph.evaluate(**own, material=material, **{field: numbers[part]})
        assert np.array_equal(alone.rgb, lit.rgb[part]), "no vertex's bits depend on the others'"
        for component in ("rgb", "specular", "diffuse"):
            found, expected = getattr(lit, component)[part], getattr(one, component)
            np.testing.assert_allclose(found, expected, atol=most, rtol=most)
    assert np.ptp(lit.specular) > 1e-3


@pytest.mark.parametrize("name", sorted({name for name, _ in MAPPED}))
def test_bounds_are_those_of_the_extremes(name):
    """Colours within the tolerance, and the plan's own bound, for materials that vary from dull to sharp."""
    left_out = 0
    for seed in range(60):
        random = np.random.default_rng(seed)
        away = 10.0 ** random.uniform(0, 3)
        points = random.uniform(-1, 1, (40, 3))
        normals = np.array((0, 0, 1)) + random.uniform(0, 2) * random.normal(size=(40, 3))
        place = tuple(away * np.array((1, 0, 1)) + random.normal(size=3))
        lamp = ph.PointLight(position=place, diffuse=0.5, specular=10.0 ** random.uniform(-5, 0))
        eye = ph.Viewer(tuple(10.0 ** random.uniform(0.5, 3) * np.array((random.normal(), 0, 2))))
        scene, material = ph.Scene([lamp], eye), material_of(name)
        maps = {}
        for field in REFLECTANCES[name].maps:
            low, high = SHARES[field]
            middle, width = random.uniform(0.1, 0.9), random.choice((0.0, 0.1))
            maps[field] = np.clip(random.uniform(middle - width, middle + width, 40), 0.0, 1.0) * (high - low) + low
        tolerance = 10.0 ** random.uniform(-3, -0.5)
        vertices = Vertices(points, normals, tangents=points, maps=maps)
        plan = Plan.of(scene, material, vertices, tolerance=tolerance)
        exact = Plan.of(scene, material, vertices).run(vertices, precision="float64").rgb
        error = np.abs(plan.run(vertices, precision="float64").rgb - exact).max()
        assert error <= plan.error_bound + 1e-12
        assert plan.error_bound <= tolerance
        left_out += plan.error_bound > 0
    assert left_out > 3


def test_where_some_are_infinitely_steep_none_is_taken_for_flat():
    """A shininess between 0 and 1 has no bound on its slope, though the least is 0 and the greatest moderate."""
    points = np.array([(x, 0.0, 0.0) for x in np.linspace(-1, 1, 50)])
    maps = {"shininess": np.tile((0.0, 0.01, 3.0), 17)[:50]}
    scene = ph.Scene([ph.PointLight(position=(1e4, 0, 1e-3))], ph.Viewer((-1e3, 0, 1)))
    vertices = Vertices(points, np.tile((0.0, 0.0, 1.0), (50, 1)), maps={**maps, "specular": np.ones(50)})
    plans = [Plan.of(scene, ph.Material(), vertices, tolerance=tolerance) for tolerance in (0.0, 0.05)]
    exact, found = (plan.run(vertices, precision="float64").rgb for plan in plans)
    assert np.abs(exact - found).max() <= plans[1].error_bound + 1e-12


def test_a_mesh_takes_arrays_and_their_names():
    sphere = pv.Sphere()
    sphere["gloss"] = np.linspace(1, 80, sphere.n_points)
    material, how = ph.Material(specular=0.5), {"precision": "float64"}
    named = sphere.phong.shade(SCENE, material, shininess="gloss", **how)
    given = sphere.phong.shade(SCENE, material, shininess=sphere["gloss"], **how)
    assert np.array_equal(named["phong"], given["phong"])
    block = pv.MultiBlock({"a": sphere}).phong.shade(SCENE, material, shininess="gloss", **how)["a"]
    assert np.array_equal(named["phong"], block["phong"])
    split = sphere.phong.shade(SCENE, material, shininess=sphere["gloss"], feature_angle=0, **how)
    assert split.n_points > sphere.n_points
    plan = sphere.phong.plan(SCENE, material, shininess="gloss", tolerance=0.1)
    assert plan.equation.maps == {"shininess": (1.0, 80.0)}


@pytest.mark.parametrize(
    ("maps", "message"),
    [
        (
            {"shininess": -np.ones(COUNT)},
            r"^shininess must be finite numbers >= 0, shape \(n,\); got \[-1.0\] at vertex 0",
        ),
        ({"shininess": np.where(np.arange(COUNT) == 7, np.nan, 1)}, r"^shininess must be .* at vertex 7"),
        ({"shininess": np.ones((COUNT, 3))}, r"^shininess must be .*; got an array of shape \(60, 3\)"),
        ({"shininess": np.ones(3)}, "^shininess must be one per point, 60; got 3 numbers"),
        ({"specular": np.ones((COUNT, 4))}, r"^specular must be .*\(n,\) or \(n, 3\); got an array of shape \(60, 4\)"),
        ({"specular": 200 * np.ones(COUNT)}, "^specular must be reflectances from 0, of which 1 is all, to 16"),
        ({"roughness": np.zeros(COUNT)}, "^roughness must be numbers > 0 and <= 1"),
        ({"roughness": np.ones(COUNT)}, "^roughness must be None for Phong; .* It reads shininess, specular of each"),
    ],
)
def test_what_cannot_be_is_refused(given, maps, message):
    with pytest.raises(ValueError, match=message):
        ph.evaluate(*given, SCENE, ph.Material(), **maps)


def test_what_nobody_would_read_is_refused(given):
    clay = ph.Material(reflectance=ph.OrenNayar(20))
    with pytest.raises(
        ValueError, match=r"^shininess must be None for OrenNayar; .* nothing of each vertex but albedo"
    ):
        ph.evaluate(*given, SCENE, clay, shininess=np.ones(COUNT))
    vtk = ph.Scene(LIGHTS, light_model=ph.LightModel.vtk())
    with pytest.raises(ValueError, match=r"^shininess must be None in VTK's convention"):
        ph.evaluate(*given, vtk, ph.Material(), shininess=np.ones(COUNT))
    with pytest.raises(
        ValueError, match=r"^shininess must be one for all vertices; .* shade and evaluate take shininess="
    ):
        ph.Material(shininess=np.ones(COUNT))
