"""Visibility of lights and sky multiplies the terms of the equation, in both evaluators alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pvphong as ph
from pvphong.shading import kernel
from pvphong.shading.plan.plan import Plan
from pvphong.shading.plan.state import Decision
from pvphong.shading.vertices import Vertices

COUNT = 700
SUN = ph.DirectionalLight(direction=(-1, -1, -2), diffuse=(1, 0.9, 0.7), ambient=0.1, name="sun")
LAMP = ph.PointLight(position=(2, -1, 3), attenuation=(1, 0.1, 0.02), ambient=0.2, name="lamp")
SPOT = ph.SpotLight(position=(1, 1, 4), direction=(-1, -1, -4), cone_angle=40, exponent=9, ambient=0.1, name="spot")
BULB = ph.PointLight(position=(-2, 1, 2), ambient=0.3, name="bulb")
BALL = ph.SphereLight(position=(0, 2, 4), radius=0.5, intensity=9, ambient=0.1, name="ball")
LIGHTS = [SUN, LAMP, replace(SUN, name="off", on=False), SPOT, BULB, BALL]
SHINY = ph.Material(ambient=0.3, diffuse=(0.4, 0.5, 0.6), specular=(0.5, 0.4, 0.3), shininess=25, emission=0.05)
MATERIALS = {
    "shiny": SHINY,
    "dull": replace(SHINY, specular=0.0),
    "mirror": replace(SHINY, diffuse=0.0),
    "oren-nayar": replace(SHINY, reflectance=ph.OrenNayar(20)),
}
MODELS = [{"shadows": True}, {"ambient_occlusion": True}, {"shadows": True, "ambient_occlusion": 2.0}]
BACKENDS = ["numpy", *["numba"] * kernel.is_available()]


class KnownVisibility:
    """Visibility with known parts."""

    def __init__(self, parts, why=""):
        self.parts, self.why = parts, why
        self.asked = []

    def why_clear(self, light):
        return self.why if light == 0 else ""

    def why_open(self):
        return self.why

    def channels(self, lights, *, sky, behind=False):
        assert not behind, "no scene here is two-sided"
        self.asked.append((tuple(lights), sky))
        unknown = [index for index in range(len(self.parts) - 1) if index not in lights]
        parts = self.parts.copy()
        parts[[*unknown, *[-1] * (not sky)]] = 7.0  # must not be read
        return parts


@pytest.fixture(scope="module")
def given():
    random = np.random.default_rng(5)
    points = random.normal(size=(COUNT, 3))
    parts = random.random((len(LIGHTS) + 1, COUNT)).astype(np.float32)
    parts[:, ::7], parts[:, ::5] = 0.0, 1.0
    return points, points + 0.3 * random.normal(size=(COUNT, 3)), parts


def scene(lights=LIGHTS, **model):
    return ph.Scene(lights, ph.Viewer(position=(0, -3, 4)), ph.LightModel(clamp=False, **model))


def run(given, scene, material, backend="numpy", precision="float64", maps=(), visibility=None, **options):
    points, normals, parts = given
    vertices = Vertices(points, normals, dict(maps), KnownVisibility(parts) if visibility is None else visibility)
    return Plan.of(scene, material, vertices).run(vertices, backend=backend, precision=precision, **options)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("albedo", [False, True])
def test_each_light_and_the_ambient_light_are_multiplied_by_what_is_seen_of_them(given, model, name, albedo):
    """The expected colours are contributions of an unshadowed evaluation, combined by hand."""
    points, _, parts = given
    maps = {"albedo": np.abs(points) / np.abs(points).max()} if albedo else {}
    free = run(given, scene(), MATERIALS[name], maps=maps, components=True)
    sky = parts[-1][:, None] if "ambient_occlusion" in model else 1.0
    expected = free.emission + sky * free.ambient
    for index, light in enumerate(LIGHTS):
        alone = run(given, scene([replace(light, ambient=0.0)], ambient=0.0), MATERIALS[name], maps=maps)
        seen = parts[index][:, None] if "shadows" in model else 1.0
        expected = expected + seen * (alone.rgb - free.emission)
    for backend in BACKENDS:
        for precision, within in (("float64", 1e-12), ("float32", 3e-5)):
            got = run(given, scene(**model), MATERIALS[name], backend, precision, maps)
            np.testing.assert_allclose(got.rgb, expected, atol=within)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("lights", [[SUN], [replace(SUN, ambient=0.0)], [LAMP], []])
def test_few_lights_take_no_shortcut_past_it(given, backend, lights):
    """Without shadows, one sun on a dull surface and a scene without lights have fast paths."""
    points, normals, parts = given
    some = points, normals, parts[[0] * len(lights) + [-1]]
    whole = scene(lights, shadows=True, ambient_occlusion=True)
    got = run(some, whole, MATERIALS["dull"], backend, "float32").rgb
    np.testing.assert_allclose(got, run(some, whole, MATERIALS["dull"]).rgb, atol=1e-6)
    assert np.ptp(got[:, 0]) > 0.05


@pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")
def test_vertices_that_the_kernel_declines_are_shadowed_too(given, monkeypatch):
    from pvphong.shading.kernel import evaluation

    monkeypatch.setattr(evaluation, "SHORTEST", 256)  # several pieces with different parts
    points, normals, parts = (array.copy() for array in given)
    points[::3] *= 1e200
    points[4], points[7] = LAMP.position, np.nan
    got = run((points, normals, parts), scene(shadows=True, ambient_occlusion=True), SHINY, "numba", "float64").rgb
    exact = run((points, normals, parts), scene(shadows=True, ambient_occlusion=True), SHINY).rgb
    np.testing.assert_allclose(got, exact, atol=1e-9)


def test_pieces_are_shadowed_by_their_own_parts(given, monkeypatch):
    from pvphong.shading import reference
    from pvphong.shading.kernel import evaluation

    full = scene(shadows=True, ambient_occlusion=True)
    whole = {backend: run(given, full, SHINY, backend).rgb for backend in BACKENDS}
    monkeypatch.setattr(reference, "BLOCK", 100)
    monkeypatch.setattr(evaluation, "SHORTEST", 256)  # several pieces with different parts
    columns = np.asfortranarray(given[0]), np.asfortranarray(given[1]), given[2]
    for backend in BACKENDS:
        np.testing.assert_array_equal(run(columns, full, SHINY, backend).rgb, whole[backend])


def test_windows_are_shadowed_too(given):
    points, normals, parts = given
    vertices = Vertices(points, normals, visibility=KnownVisibility(parts))
    full = scene(shadows=True, ambient_occlusion=True)
    shown = np.empty((COUNT, 3), np.uint8)
    Plan.of(full, SHINY, vertices).run_for_display(vertices, shown)
    np.testing.assert_array_equal(shown, np.rint(255 * np.clip(run(given, full, SHINY).rgb, 0, 1)))


# --- plans


def planned(given, why="", material=SHINY, lights=LIGHTS, **model):
    points, normals, parts = given
    visibility = KnownVisibility(parts, why)
    vertices = Vertices(points, normals, visibility=visibility)
    return Plan.of(scene(lights, **model), material, vertices), vertices, visibility


def test_without_shadows_nobody_is_asked(given):
    plan, vertices, visibility = planned(given)
    assert (plan.effects["shadow"].on, plan.effects["occlusion"].on) == (False, False)
    assert plan.effects["shadow"].why == "the light model has no shadows"
    assert plan.effects["occlusion"].why == "the light model has no ambient occlusion"
    plan.run(vertices)
    assert visibility.asked == []


def test_what_nothing_can_block_is_left_out(given):
    plan, vertices, visibility = planned(given, "it is noon", shadows=True, ambient_occlusion=True)
    assert plan.effects["shadow"].on
    assert "sun: it is noon" in plan.effects["shadow"].why
    assert "lamp" in plan.effects["shadow"].why
    assert plan.effects["occlusion"] == Decision(False, "it is noon")
    plan.run(vertices)
    assert visibility.asked == [((1, 3, 4, 5), False)]
    assert plan.error_bound == 0.0


def test_only_what_is_read_is_asked_for(given):
    dark = replace(SHINY, diffuse=0.0, specular=0.0)
    plan, vertices, visibility = planned(given, material=dark, shadows=True, ambient_occlusion=True)
    assert plan.effects["shadow"].why.endswith("adds ambient light alone")
    assert plan.effects["occlusion"].on
    plan.run(vertices)
    assert visibility.asked == [((), True)]
    black = replace(SHINY, ambient=0.0)
    assert (
        planned(given, material=black, ambient_occlusion=True)[0].effects["occlusion"].why
        == "there is no ambient light"
    )
    assert planned(given, lights=[], shadows=True)[0].effects["shadow"].why == "no light reaches the mesh"


def test_bare_points_can_be_planned_and_not_lit(given):
    points, normals, _ = given
    dim = scene(shadows=True)
    assert ph.plan(points, dim, SHINY).effects["shadow"].on
    with pytest.raises(ValueError, match=r"visibility must be given for .* shadows .* visibility=mesh\.phong\.visi"):
        ph.evaluate(points, normals, dim, SHINY)


def test_plain_numbers_are_clipped_and_nan_is_0(given):
    points, normals, parts = given
    odd, clean = parts.copy(), parts.copy()
    odd[:, :4], clean[:, :4] = (-1.0, np.nan, 7.0, np.inf), (0.0, 0.0, 1.0, 1.0)
    full = scene(shadows=True, ambient_occlusion=True)
    got, expected = (ph.evaluate(points, normals, full, SHINY, visibility=each).rgb for each in (odd, clean))
    np.testing.assert_array_equal(got, expected)


# --- two sides


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("model", MODELS)
def test_each_vertex_has_the_parts_of_the_side_that_the_viewer_sees(given, backend, local, model):
    """The expected colours are one-sided, with normals turned by hand and the parts of the visible sides."""
    points, normals, parts = given
    both = np.concatenate([parts, np.random.default_rng(6).random(parts.shape).astype(np.float32)])
    two, one = (scene(**model, local_viewer=local, two_sided=sides) for sides in (True, False))
    v = np.array(two.viewer.position) - (points if local else two.viewer.focal_point)
    is_behind = (normals * v).sum(axis=1) < 0.0
    assert 0.1 < is_behind.mean() < 0.9
    turned, seen = np.where(is_behind[:, None], -normals, normals), np.where(is_behind, *np.split(both, 2)[::-1])
    for material in MATERIALS.values():
        for precision, within in (("float64", 1e-12), ("float32", 3e-5)):
            how = {"precision": precision, "backend": backend}
            got = ph.evaluate(points, normals, two, material, visibility=both, **how).rgb
            expected = ph.evaluate(points, turned, one, material, visibility=seen, **how).rgb
            np.testing.assert_allclose(got, expected, atol=within)
    with_one = ph.evaluate(points, normals, two, SHINY, visibility=parts).rgb  # both sides see the same
    np.testing.assert_allclose(with_one, ph.evaluate(points, turned, one, SHINY, visibility=parts).rgb, atol=3e-5)
    first = ph.evaluate(points, normals, one, SHINY, visibility=both).rgb  # the other sides are not read
    np.testing.assert_array_equal(first, ph.evaluate(points, normals, one, SHINY, visibility=parts).rgb)
    with pytest.raises(ValueError, match=r"visibility must be .*, or an array of shape \(7, 700\)"):
        ph.evaluate(points, normals, two, SHINY, visibility=both[:-1])
