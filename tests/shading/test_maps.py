"""Maps act as if each vertex had a separate material, for every field, call and evaluator."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import REFLECTANCE_SHAPES, Dice

import pvphong as ph
from pvphong.optics.maps import COLORS, FIELDS
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading import kernel
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

COUNT = 60
BACKENDS = ["numpy", *(["numba"] if kernel.is_available() else [])]
RANGES = {name: (max(field.least, 0.05), min(field.most, 1.0)) for name, field in FIELDS.items()} | {
    "shininess": (0.0, 90.0),
    "specular": (0.0, 0.9),
    "metallic": (0.0, 1.0),
}
EVERYWHERE = {"albedo", "diffuse", "emission"}
MAPPED = [(name, field) for name, kind in REFLECTANCES.items() for field in sorted(kind.maps | EVERYWHERE)]
LIGHTS = [ph.PointLight(position=(1, -2, 4), ambient=0.1), ph.DirectionalLight(direction=(1, 1, -2), diffuse=0.3)]
SCENE = ph.Scene(LIGHTS, ph.Viewer((-1, -2, 5)), ph.LightModel(clamp=False))


@pytest.fixture
def given():
    random = np.random.default_rng(3)
    points = random.uniform(-1, 1, (COUNT, 3))
    return points, points + 0.2 * random.normal(size=(COUNT, 3))


def numbers_of(field):
    low, high = RANGES[field]
    found = np.random.default_rng(5).uniform(low, high, (COUNT, 3) if field in COLORS else COUNT)
    found[:6] = np.reshape((low, high, 1.0, 0.5, high, 0.1), (6, *(1,) * (found.ndim - 1)))
    return np.minimum(found, high)


def material_of(name):
    shape = {"alpha_x": 0.5, "alpha_y": 0.9} if name == "ward" else REFLECTANCE_SHAPES[name](Dice(4))
    reflectance = REFLECTANCES[name](**shape)
    return ph.Material(
        diffuse=(0.2, 0.3, 0.4), specular=0.5, shininess=12, tangents=np.tile((1.0, 2.0, 3.0), (COUNT, 1)),
        reflectance=reflectance,
    )  # fmt: skip


def at_vertex(material, k, values):
    """Return the material of one vertex, without maps."""
    plain = {name: np.asarray(value)[k].tolist() for name, value in values.items()}
    return material.with_values({**plain, "tangents": np.asarray(material.tangents)[k : k + 1]})


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("precision", "most"), [("float32", 1e-4), ("float64", 1e-13)])
@pytest.mark.parametrize(("name", "field"), MAPPED)
def test_each_vertex_has_a_material_of_its_own(given, name, field, precision, most, backend):
    points, normals = given
    material, numbers = material_of(name), numbers_of(field)
    mapped = material.with_values({field: numbers})
    lit = ph.evaluate(points, normals, SCENE, mapped, precision=precision, backend=backend)
    parts = ph.evaluate(points, normals, SCENE, mapped, precision=precision, components=True)
    for k in np.linspace(0, COUNT - 1, 10, dtype=int):
        part = slice(k, k + 1)
        own = at_vertex(material, k, {field: numbers})
        one = ph.evaluate(points[part], normals[part], SCENE, own, precision=precision, components=True)
        np.testing.assert_allclose(lit.rgb[part], one.rgb, atol=most, rtol=most)
        for component in ("ambient", "diffuse", "specular", "emission"):
            np.testing.assert_allclose(getattr(parts, component)[part], getattr(one, component), atol=most, rtol=most)
        alone = mapped.with_values({field: numbers[part], "tangents": np.asarray(material.tangents)[part]})
        alone = ph.evaluate(points[part], normals[part], SCENE, alone, precision=precision, backend=backend)
        assert np.array_equal(alone.rgb, lit.rgb[part]), "no vertex's bits depend on the others'"
    assert np.ptp(lit.rgb) > 1e-3


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kind", [np.float32, np.float64, np.uint8], ids=lambda kind: kind.__name__)
def test_all_at_once(given, kind, backend):
    points, normals = given
    values = {name: numbers_of(name) for name in ("albedo", "diffuse", "specular", "emission", "shininess")}
    if kind is np.uint8:
        values |= {name: np.rint(255 * np.minimum(values[name], 1)).astype(kind) for name in COLORS}
    else:
        values = {name: value.astype(kind) for name, value in values.items()}
    values["emission"] = values["emission"][:, :1]
    lit = ph.evaluate(points, normals, SCENE, ph.Material(**values), backend=backend)
    scaled = {name: value / 255 if value.dtype == np.uint8 else value for name, value in values.items()}
    scaled["emission"] = scaled["emission"][:, 0]
    for k in range(COUNT):
        own = ph.Material(**{name: value[k].tolist() for name, value in scaled.items()})
        one = ph.evaluate(points[k : k + 1], normals[k : k + 1], SCENE, own, precision="float64")
        np.testing.assert_allclose(lit.rgb[k], one.rgb[0], atol=2e-5, rtol=2e-5)


@pytest.mark.parametrize("name", sorted({name for name, _ in MAPPED}))
def test_bounds_hold_for_every_vertex(name):
    """Colours are within the tolerance and the plan's bound, for materials that vary from dull to sharp."""
    left_out = 0
    for seed in range(120):
        random = np.random.default_rng(seed)
        away = 10.0 ** random.uniform(0, 3)
        points = random.uniform(-1, 1, (40, 3))
        normals = np.array((0, 0, 1)) + random.uniform(0, 2) * random.normal(size=(40, 3))
        place = tuple(away * np.array((1, 0, 1)) + random.normal(size=3))
        lamp = ph.PointLight(position=place, diffuse=0.5, specular=10.0 ** random.uniform(-5, 0))
        eye = ph.Viewer(tuple(10.0 ** random.uniform(0.5, 3) * np.array((random.normal(), 0, 2))))
        scene, material = ph.Scene([lamp], eye), material_of(name)
        maps = {}
        for field in REFLECTANCES[name].maps | (EVERYWHERE if seed % 2 else set()):
            low, high = RANGES[field]
            middle, width = random.uniform(0.1, 0.9), random.choice((0.0, 0.1))
            maps[field] = np.clip(random.uniform(middle - width, middle + width, 40), 0.0, 1.0) * (high - low) + low
        tolerance = 10.0 ** random.uniform(-3, -0.5)
        vertices = Vertices(points, normals, maps, tangents=points)
        plan = Plan.of(scene, material, vertices, tolerance=tolerance)
        exact = Plan.of(scene, material, vertices).run(vertices, precision="float64").rgb
        error = np.abs(plan.run(vertices, precision="float64").rgb - exact).max()
        assert error <= plan.error_bound + 1e-12
        assert plan.error_bound <= tolerance
        left_out += plan.error_bound > 0
    assert left_out > 3


def test_where_some_are_infinitely_steep_none_is_taken_for_flat():
    """A shininess between 0 and 1 has no bound on its slope, even if the least is 0 and the greatest moderate."""
    points = np.array([(x, 0.0, 0.0) for x in np.linspace(-1, 1, 50)])
    maps = {"shininess": np.tile((0.0, 0.01, 3.0), 17)[:50], "specular": np.ones(50)}
    scene = ph.Scene([ph.PointLight(position=(1e4, 0, 1e-3))], ph.Viewer((-1e3, 0, 1)))
    vertices = Vertices(points, np.tile((0.0, 0.0, 1.0), (50, 1)), maps)
    plans = [Plan.of(scene, ph.Material(), vertices, tolerance=tolerance) for tolerance in (0.0, 0.05)]
    exact, found = (plan.run(vertices, precision="float64").rgb for plan in plans)
    assert np.abs(exact - found).max() <= plans[1].error_bound + 1e-12


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"shininess": -np.ones(COUNT)}, r"^shininess must be finite .*, shape \(n,\); got \[-1.0\] at vertex 0"),
        ({"shininess": np.where(np.arange(COUNT) == 7, np.nan, 1)}, r"^shininess must be .* at vertex 7"),
        ({"shininess": np.ones((COUNT, 3))}, r"^shininess must be .*; got an array of shape \(60, 3\)"),
        ({"shininess": np.ones(3)}, "^shininess must be an array with one row per point, 60 rows; got 3 rows"),
        ({"specular": np.ones((COUNT, 4))}, r"^specular must be .*; got an array of shape \(60, 4\)\. Leave out the"),
        (
            {"diffuse": np.where(np.arange(COUNT) == 5, 200, 1.0)},
            "^diffuse must be .* at vertex 5. Divide 0-255 values by 255",
        ),
        ({"emission": np.ones(COUNT, np.int32)}, "^emission must be uint8 or floats"),
        (
            {"albedo": "scan"},
            r"^albedo must be an array of reflectances .*; got 'scan'\. The name of an array needs a mesh\.$",
        ),
        ({"tangents": "grain"}, r"^tangents must be an array of shape \(n, 3\), because array names need a mesh"),
        ({"reflectance": ph.GGX(np.zeros(COUNT))}, "^roughness must be numbers > 0 and <= 1"),
        ({"reflectance": ph.PBR(np.full(COUNT, 2.0))}, "^metallic must be numbers from 0 to 1"),
        (
            {"shininess": np.ones(COUNT), "reflectance": ph.OrenNayar(20)},
            r"^shininess must be a number or colour for OrenNayar; .*"
            r" OrenNayar can have maps of albedo, diffuse, emission\.",
        ),
    ],
)
def test_what_cannot_be_is_refused(given, fields, message):
    with pytest.raises(ValueError, match=message):
        ph.evaluate(*given, SCENE, ph.Material(**fields))


def test_vtks_convention_has_albedo_alone(given):
    vtk = ph.Scene(LIGHTS, light_model=ph.LightModel.vtk())
    with pytest.raises(ValueError, match=r"^shininess must be a number or colour in VTK's convention"):
        ph.evaluate(*given, vtk, ph.Material(shininess=np.ones(COUNT)))
    with pytest.raises(ValueError, match=r"^reflectance must be None or PBR"):
        ph.evaluate(*given, vtk, ph.Material(shininess=np.ones(COUNT), reflectance=ph.Phong(5.0)))
    assert ph.evaluate(*given, vtk, ph.Material(albedo=np.zeros((COUNT, 3)))).rgb.max() == 0
