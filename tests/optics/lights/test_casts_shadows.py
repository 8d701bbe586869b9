"""Lights that cast no shadows: as bright as without shadows, without rays, next to lights that keep theirs."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from strategies import LIGHT_SHAPES, Dice

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.rays.casting import Occluders

KINDS = LIGHT_TYPES | {"sun": ph.DirectionalLight}
SHAPES = LIGHT_SHAPES | {"sun": lambda *_: {"direction": (0.1, 0.0, -1.0), "angle": 5.0}}
every_kind = pytest.mark.parametrize("kind", KINDS)

GROUND = pv.Plane(i_size=4, j_size=4, i_resolution=12, j_resolution=12)
BALL = pv.Sphere(radius=0.6, center=(0, 0, 1), theta_resolution=16, phi_resolution=16)
BLOCKS = pv.MultiBlock({"ground": GROUND, "ball": BALL})
SUN = ph.DirectionalLight((-0.3, 0.1, -1), name="sun")
GLOSSY = ph.Material(specular=0.4, shininess=8.0)


def lamp(kind, **fields):
    """Return a light of a kind above the ball."""
    return KINDS[kind](**SHAPES[kind](Dice(kind), (0.3, 0.2, 3.0), (0.0, -0.1, -1.0), 60.0), name="lamp", **fields)


def scene(*lights, **model):
    model = {"shadows": True, "clamp": False} | model
    return ph.Scene(lights, ph.Viewer(position=(2, -4, 3)), ph.LightModel(**model))


# --- light by light


@every_kind
@pytest.mark.parametrize("backend", ["numpy", "numba"])
@pytest.mark.parametrize("two_sided", [False, True])
def test_its_share_has_the_bits_of_a_scene_without_shadows_and_others_keep_theirs(kind, backend, two_sided):
    light = lamp(kind, ambient=0.1)
    free = replace(light, casts_shadows=False)

    def lit(light, **model):
        how = {"components": True, "backend": backend}
        return BLOCKS.phong.shade(scene(light, SUN, two_sided=two_sided, **model), GLOSSY, **how)

    found, shadowed, without = lit(free), lit(light), lit(light, shadows=False)
    for one, with_shadows, open_air in zip(found, shadowed, without, strict=True):
        np.testing.assert_array_equal(one["phong_light_lamp"], open_air["phong_light_lamp"])
        np.testing.assert_array_equal(one["phong_light_sun"], with_shadows["phong_light_sun"])
        assert "phong_visibility_lamp" not in one.point_data
    for label in ("lamp", "sun"):  # both are blocked somewhere
        name = f"phong_light_{label}"
        assert (shadowed["ground"][name] < without["ground"][name]).any()


@every_kind
def test_rays_go_only_to_the_others(kind):
    light, others = lamp(kind, casts_shadows=False), [SUN, replace(SUN, name="off", on=False)]
    seen = GROUND.phong.visibility(scene(light, *others, two_sided=True), occluders=[BALL])
    alone = GROUND.phong.visibility(scene(*others, two_sided=True), occluders=[BALL])
    for side, of_others in ((seen, alone), (seen.behind, alone.behind)):
        assert (side.per_light[0] == 1.0).all()
        np.testing.assert_array_equal(side.per_light[1:], of_others.per_light)
    assert seen.rays == alone.rays > 0
    assert not seen.standard_error.per_light[0].any()


@every_kind
def test_truth_and_irradiance_agree(kind):
    light = lamp(kind)
    free = replace(light, casts_shadows=False)
    how = {"samples": 16, "max_bounces": 0}
    true = GROUND.phong.truth(scene(free), occluders=[BALL], **how)
    open_air = GROUND.phong.truth(scene(light), **how)  # a plane does not shadow itself
    np.testing.assert_allclose(true.rgb, open_air.rgb, rtol=1e-5, atol=1e-7)
    assert true.rays == 0
    shadowed = GROUND.phong.truth(scene(light), occluders=[BALL], **how)
    assert shadowed.rgb.sum() < 0.95 * open_air.rgb.sum()
    for per, data in (("vertex", "point_data"), ("face", "cell_data")):
        bare = GROUND.phong.irradiance(scene(light, shadows=False), per=per)
        arriving = GROUND.phong.irradiance(scene(free), per=per, occluders=[BALL])
        np.testing.assert_array_equal(getattr(arriving, data)["irradiance"], getattr(bare, data)["irradiance"])


def test_without_any_rays_no_geometry_is_asked(monkeypatch):
    def refuse(*_args, **_options):
        raise AssertionError("a ray was cast")

    for name in ("blocked", "first", "casters", "compiled"):
        monkeypatch.setattr(Occluders, name, refuse if name in ("blocked", "first") else property(refuse))
    lights = [lamp(kind, casts_shadows=False) for kind in KINDS]
    lights = [replace(light, name=str(k)) for k, light in enumerate(lights)]
    lit = BLOCKS.phong.shade(scene(*lights), GLOSSY)
    assert np.isfinite(lit["ball"]["phong"]).all()
    ball = BLOCKS["ball"]
    assert (np.array(ball.phong.visibility(scene(lights[0]), occluders=[BLOCKS[-1]]).per_light) == 1.0).all()
    given = scene(lights[0], replace(lights[1], on=False))
    points, normals = np.eye(3), np.eye(3)  # `evaluate` knows no geometry and needs no visibility
    assert ph.evaluate(points, normals, given, GLOSSY).rgb.shape == (3, 3)
    with pytest.raises(ValueError, match=r"^visibility must be given for a light model with shadows"):
        ph.evaluate(points, normals, scene(SUN), GLOSSY)


# --- bounces, against the sum of a furnace's series


ALBEDO = 0.6
SHELL = pv.Icosphere(nsub=3).flip_faces()
SHELL.point_data.active_normals = -SHELL.points


@pytest.mark.parametrize("bounces", [0, 2])
def test_a_sky_shines_through_a_closed_shell_whose_inside_reflects_it(bounces):
    """Light of 1 from everywhere, then reflections of a closed white-grey room: ρ + ρ² + … + ρⁿ⁺¹."""
    sky = ph.EnvironmentLight(casts_shadows=False)
    matt = ph.Material(diffuse=ALBEDO)
    expected = sum(ALBEDO ** (k + 1) for k in range(bounces + 1))
    inside = {"ambient": 0.0, "bounces": bounces}
    lit = SHELL.phong.shade(scene(sky, **inside), matt, precision="float64")
    np.testing.assert_allclose(lit["phong"], expected, rtol=2e-3)
    true = SHELL.phong.truth(scene(sky), matt, samples=64, max_bounces=bounces)
    assert abs(true.rgb.mean() - expected) < 5e-3 * expected
    assert (np.abs(true.rgb - expected) < 6.0 * true.standard_error + 1e-3).all()
    dark = replace(sky, casts_shadows=True)
    assert SHELL.phong.shade(scene(dark, **inside), matt)["phong"].max() < 1e-3
    assert SHELL.phong.truth(scene(dark), matt, samples=16, max_bounces=bounces).rgb.max() < 1e-3


# --- cones, whose edges are cut like those of shadows


def test_cuts_of_a_cone_are_those_without_shadows():
    spot = ph.SpotLight((0.5, 0, 2.5), (-0.1, 0, -1), cone_angle=25.0, exponent=0.0, name="spot")
    free, how = replace(spot, casts_shadows=False), {"tolerance": 0.05, "max_points": 2000}
    cut = GROUND.phong.refine(scene(free), occluders=[BALL], **how)
    expected = GROUND.phong.refine(scene(spot, shadows=False), **how)
    np.testing.assert_array_equal(cut.points, expected.points)
    np.testing.assert_array_equal(cut["phong"], expected["phong"])
    assert cut.field_data["phong_refinement_cut"][0] > 0
    shadowed = GROUND.phong.refine(scene(spot), occluders=[BALL], **how)
    assert shadowed.n_points != cut.n_points


# --- plans


def test_a_plan_says_why_and_has_no_cost():
    free = replace(SUN, name="fill", casts_shadows=False)
    of_both = GROUND.phong.plan(scene(SUN, free), occluders=[BALL]).effects["shadow"]
    assert (of_both.on, of_both.lights) == (True, 1)
    assert of_both.why == "sun (left out: fill: casts no shadows)"
    of_one = GROUND.phong.plan(scene(free), occluders=[BALL])
    assert (of_one.effects["shadow"].on, of_one.effects["shadow"].why) == (False, "fill: casts no shadows")
    assert "fill: casts no shadows" in of_one.explain()
    without = GROUND.phong.plan(scene(free, shadows=False))
    assert without.effects["shadow"].why == "the light model has no shadows"
    assert of_one._nanoseconds == without._nanoseconds


# --- visibility that is kept


def test_rays_are_kept_for_a_light_that_casts_no_shadows_any_more_and_refused_after_the_opposite(tmp_path):
    point = ph.PointLight((0.2, 0, 3), name="point")
    free, bare = replace(point, casts_shadows=False), scene(point, shadows=False)
    ground = GROUND.phong
    seen = ground.visibility(scene(point), occluders=[BALL])
    assert (seen.per_light == 0.0).any()
    for visibility in (seen, [*seen.per_light.tolist(), seen.sky.tolist()]):
        lit = ground.shade(scene(free), visibility=visibility)["phong"]
        np.testing.assert_array_equal(lit, ground.shade(bare)["phong"])
    moved = replace(free, position=(1, 1, 4))  # its row is not read
    lit = ground.shade(scene(moved), visibility=seen)["phong"]
    np.testing.assert_array_equal(lit, ground.shade(scene(moved, shadows=False))["phong"])

    unseen = ground.visibility(scene(free), occluders=[BALL])
    assert (unseen.per_light == 1.0).all()
    unseen.save(tmp_path / "seen.npz")
    for kept in (unseen, ph.Visibility.load(tmp_path / "seen.npz")):
        assert (kept.per_light == 1.0).all()
        with pytest.raises(ValueError, match=r"^visibility must be .*; got one from before point cast shadows\. Recom"):
            ground.shade(scene(point), visibility=kept)
    with pytest.raises(ValueError, match="got one from before point moved"):
        ground.shade(scene(replace(point, position=(1, 1, 4))), visibility=seen)
    again = unseen.for_lights([point], ["point"])
    np.testing.assert_array_equal(again.per_light, seen.per_light)
    assert (seen.for_lights([free], ["point"]).per_light == 1.0).all()


# --- files


def test_scene_files_keep_it_and_older_ones_have_shadows(tmp_path):
    lights = [replace(lamp(kind), name=kind, casts_shadows=False) for kind in LIGHT_TYPES if kind != "environment"]
    path = tmp_path / "rig.json"
    scene(*lights, SUN).save(path)
    assert ph.Scene.load(path).lights == (*lights, SUN)
    document = json.loads(path.read_text())
    for entry in document["lights"]:
        del entry["casts_shadows"]
    path.write_text(json.dumps(document))
    assert all(light.casts_shadows for light in ph.Scene.load(path).lights)
    document["lights"][0]["casts_shadows"] = "no"
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"^lights\[0\]\.casts_shadows must be True or False; got no"):
        ph.Scene.load(path)


def test_lights_that_move_with_the_viewer_keep_it():
    viewer = ph.Viewer(position=(2, -4, 3))
    for frame in ("camera", "headlight"):
        light = ph.SpotLight(frame=frame, casts_shadows=False)
        assert not light.in_world(viewer).casts_shadows
        assert not light.in_world(viewer).in_frame(frame, viewer).casts_shadows
