"""The compiled evaluator agrees with the readable one, and declines what it does not support."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pvphong as ph
from pvphong import Plan, Shading
from pvphong.shading import kernel
from pvphong.shading.equation import assemble
from pvphong.shading.reference import shade as shade_by_reference
from pvphong.shading.vertices import Vertices

COUNT = 1500  # more than two of the kernel's blocks, and not a multiple of their size
SUN = ph.DirectionalLight(direction=(-1, -1, -2), diffuse=(1, 0.9, 0.7), ambient=0.1)
LAMP = ph.PointLight(position=(2, -1, 3), attenuation=(1, 0.1, 0.02), diffuse=(0.5, 0.7, 1))
SPOT = ph.SpotLight(position=(1, 1, 4), direction=(-1, -1, -4), cone_angle=20, exponent=9, ambient=0.2)
EVEN = ph.SpotLight(position=(1, 1, 4), direction=(-1, -1, -4), cone_angle=20, exponent=0, attenuation=(0, 1, 0))
HEAD = ph.DirectionalLight(frame="headlight")
SHINY = ph.Material(ambient=0.3, diffuse=(0.4, 0.5, 0.6), specular=(0.5, 0.4, 0.3), shininess=25, emission=0.05)
DULL = replace(SHINY, specular=0.0)
WHITE = ph.Material(ambient=0.0, diffuse=1.0, specular=1.0, shininess=9.0)

SCENES = {
    "sun, dull": ([SUN], DULL),
    "lamp, dull": ([LAMP], DULL),
    "lamp": ([LAMP], SHINY),
    "all": ([SUN, LAMP, SPOT, EVEN, HEAD], SHINY),
}


def scene_of(name):
    lights, material = SCENES[name]
    return ph.Scene(lights, ph.Viewer(position=(0, -3, 4))), material


@pytest.fixture(scope="module")
def vertices():
    random = np.random.default_rng(7)
    points = random.normal(size=(COUNT, 3))
    return points, points + 0.3 * random.normal(size=(COUNT, 3))


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize(("name", "has_albedo"), [("all", True), ("lamp, dull", False), ("sun, dull", False)])
def test_a_large_mesh_has_the_bits_of_its_pieces(vertices, precision, name, has_albedo):
    """The number of threads does not change any bit, the last block is partial, and nothing is written outside."""
    count = 5 * 2**14 + 77
    points, normals = (np.resize(array.astype(precision), (count, 3)) for array in vertices)
    points[[40_000, count - 1]] = 3 * [np.nan], LAMP.position  # the reference lights these
    albedo = np.random.default_rng(5).random((count, 3)).astype(precision)
    known = Vertices(points, normals, {"albedo": albedo} if has_albedo else {})
    equation = known.equation(*scene_of(name), None)
    tints = known.tints(equation)
    pieces, memory = np.empty((count, 3), precision), np.full((count + 2, 3), np.nan, precision)
    for start in range(0, count, COUNT):
        part = slice(start, start + COUNT)
        own = {field: tint.at(part) for field, tint in tints.items()}
        assert kernel.evaluator()(points[part], normals[part], equation, own, Shading(pieces[part]))
    assert kernel.evaluator()(points, normals, equation, tints, Shading(memory[1:-1]))
    np.testing.assert_array_equal(memory[1:-1], pieces)
    assert np.isnan(memory[[0, -1]]).all()


@pytest.mark.parametrize("kind", ["float32", "float64", "uint8"])
def test_vertices_that_it_declines_have_the_references_bits(vertices, kind):
    """Vertices on a light, on the eye, not finite, or too far from a light; the others keep the kernel's bits."""
    points, normals = (array.copy() for array in vertices)
    scene, material = scene_of("all")
    known = Vertices(points, normals, {"albedo": np.random.default_rng(4).random((COUNT, 3))})
    equation = known.equation(scene, material, None)
    tints = known.tints(equation)
    usual, lit, reference = (np.empty((COUNT, 3), kind) for _ in range(3))
    assert kernel.evaluator()(points, normals, equation, tints, Shading(usual))
    declined = [3, 127, 128, 900, COUNT - 1]
    points[declined] = LAMP.position, scene.viewer.position, (0, np.nan, 0), (1e300, 0, 0), SPOT.position
    assert kernel.evaluator()(points, normals, equation, tints, Shading(lit))
    others = np.delete(np.arange(COUNT), declined)
    np.testing.assert_array_equal(lit[others], usual[others])
    floats = np.empty((COUNT, 3), "float32" if kind == "uint8" else kind)
    shade_by_reference(points, normals, equation, tints, Shading(floats))
    reference[:] = np.rint(floats * 255.0) if kind == "uint8" else floats
    np.testing.assert_array_equal(lit[declined], reference[declined])


def test_colours_for_a_display_are_the_rounded_floats(vertices):
    points, normals = (np.tile(array.astype(np.float32), (200, 1)) for array in vertices)
    scene, material = scene_of("all")
    shown = np.zeros((len(points), 3), np.uint8)
    vertices = Vertices(points, normals)
    Plan.of(scene, material, vertices).run_for_display(vertices, shown)
    exact = ph.evaluate(points, normals, scene, material, backend="numba").rgb * np.float32(255.0)
    np.testing.assert_array_equal(shown, np.rint(exact))
    assert len(np.unique(shown)) > 100


@pytest.mark.parametrize("backend", ["numpy", "numba"])
@pytest.mark.parametrize("lights", [[], [replace(LAMP, on=False)], [LAMP, replace(SUN, on=False)], [SUN]])
@pytest.mark.parametrize("material", [DULL, ph.Material(diffuse=0.0, ambient=0.0), SHINY])
def test_every_component_is_written_also_where_it_is_black(vertices, monkeypatch, backend, lights, material):
    """No memory keeps what was there: here NaN."""
    points, normals = vertices
    real_empty = np.empty
    monkeypatch.setattr("pvphong.shading.reference.np.empty", lambda shape, kind: np.full(shape, np.nan, kind))
    found = ph.evaluate(points, normals, ph.Scene(lights, ph.Viewer()), material, components=True, backend=backend)
    monkeypatch.setattr("pvphong.shading.reference.np.empty", real_empty)
    total = found.base + found.per_light.sum(axis=0)
    np.testing.assert_allclose(found.ambient + found.diffuse + found.specular + found.emission, total, atol=1e-6)
    np.testing.assert_allclose(np.clip(total, 0.0, 1.0), found.rgb, atol=1e-6)


def test_it_declines_what_it_cannot_do_and_writes_nothing(vertices):
    points, normals = vertices
    far = ph.Scene([replace(LAMP, position=(1e200, 0, 0))], ph.Viewer())
    result = Shading(np.full((COUNT, 3), 7.0, np.float32))
    assert not kernel.evaluator()(points, normals, assemble(far, SHINY, None), {}, result)
    assert (result.rgb == 7.0).all()


@pytest.mark.parametrize(("has_run", "count"), [(False, 150_000), (True, 5_000)])
def test_what_reaches_the_vertices_does_not_choose_the_evaluator_of_a_window(has_run, count, monkeypatch):
    """The work is too little for the kernel with the plan's lights, but enough with the scene's lights."""
    asked = []
    monkeypatch.setattr(kernel, "evaluator", lambda: lambda *given, waits, **_: asked.append((*given, waits)) or True)
    monkeypatch.setattr(kernel, "has_run", lambda: has_run)
    away = ph.SpotLight(position=(0, 0, 50), direction=(0, 0, 1), cone_angle=30)
    scene, points = (
        ph.Scene([away, LAMP], ph.Viewer()),
        np.random.default_rng(8).normal(size=(count, 3)).astype(np.float32),
    )
    vertices = Vertices(points, points)
    plan = Plan.of(scene, SHINY, vertices)
    assert (len(plan.whole.terms), len(plan.equation.terms)) == (2, 1)
    plan.run_for_display(vertices, np.empty(points.shape, np.uint8))
    assert asked[0][2] is plan.equation
    assert asked[0][-2] is plan.whole
    assert not asked[0][-1]


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("count", [100, 200])
def test_what_light_grazes_exactly_stays_dark(precision, count):
    """n·l is 0 because the products cancel exactly. With fused products, half of the vertices had a highlight."""
    a, b = np.random.default_rng(41).normal(size=(2, count)).astype(precision)
    normals = np.stack([a, b, np.zeros_like(a)], axis=1)
    for i in range(count):
        lamp, viewer = ph.PointLight(position=(b[i], -a[i], 0.0)), ph.Viewer(position=(-b[i], a[i], 1e-9))
        scene = ph.Scene([lamp], viewer, ph.LightModel(ambient=0.0))
        for material in (WHITE, replace(WHITE, specular=0.0)):
            lit = ph.evaluate(np.zeros_like(normals), normals, scene, material, precision=precision, backend="numba")
            assert not lit.rgb[i].any()
