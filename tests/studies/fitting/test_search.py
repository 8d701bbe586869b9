"""Directions, positions, cones and sizes, found from other starts."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from planted_lights import MATERIAL, VIEWER, apart, bumpy, is_found, moving, planted

import pvphong as ph
from pvphong.base import text, threads
from pvphong.studies.fitting import search

MESH = bumpy(4)  # 2562 points
SMALL = bumpy(3)  # 642 points


def colors(mesh, scene):
    return mesh.phong.shade(scene, MATERIAL, precision="float64")["phong"]


@pytest.mark.parametrize(("seed", "count"), [(0, 1), (1, 2), (2, 3), (19, 4)])
def test_planted_lights_are_found(seed, count):
    true, begin = planted(seed, count)
    fit = MESH.phong.fit(begin, MATERIAL, colors(MESH, true), moving(begin))
    assert is_found(fit, true)
    assert fit.error.rms < 1e-9


def test_highlights_that_end_at_the_edge_of_the_light_do_not_hold_a_descent():
    """In this scene, the highlights of a few points appear and vanish as the lights move."""
    mesh = bumpy(5)
    true, begin = planted(13, 2)
    fit = mesh.phong.fit(begin, MATERIAL, colors(mesh, true), moving(begin))
    assert is_found(fit, true)


@pytest.mark.long
def test_planted_lights_of_a_hundred_scenes_are_found():
    mesh = bumpy(5)
    found = 0
    for seed in range(100):
        true, begin = planted(seed, 1 + seed % 4)
        found += is_found(mesh.phong.fit(begin, MATERIAL, colors(mesh, true), moving(begin)), true)
    assert found >= 95


@pytest.mark.parametrize(
    ("true", "varies", "begin"),
    [
        (
            ph.SpotLight((1, -2, 3), (-0.3, 0.7, -1), 80, 6, intensity=0.8),
            "position direction",
            ph.SpotLight((0, 0, 4)),
        ),
        (ph.SpotLight.at((0, -3, 1), target=(0, 0, 0), exponent=9), "exponent", ph.SpotLight((0, -3, 1), (0, 3, -1))),
        (ph.SphereLight(position=(2, -2, 2), radius=1.1, intensity=5), "position radius", ph.SphereLight((0, 0, 3))),
        (ph.DirectionalLight((0.2, 0.3, -1), frame="camera"), "direction", ph.DirectionalLight(frame="camera")),
        (ph.PointLight((0.5, 1.5, 1), frame="camera"), "position", ph.PointLight((0, 0, 1), frame="camera")),
    ],
    ids=["spot", "exponent", "sphere", "camera direction", "camera position"],
)
def test_other_shapes_are_found(true, varies, begin):
    given = {} if "exponent" in varies or not isinstance(begin, ph.SpotLight) else {"cone_angle": 80, "exponent": 6}
    begin, viewer = replace(begin, **given), VIEWER
    target = colors(SMALL, ph.Scene([true], viewer))
    fit = SMALL.phong.fit(ph.Scene([begin], viewer), MATERIAL, target, f"intensity {varies}")
    (found,) = fit.scene.lights
    assert found.frame == begin.frame
    assert found.intensity == pytest.approx(true.intensity, rel=1e-3)
    for field in varies.split():
        got, expected = np.array(getattr(found, field)), np.array(getattr(true, field))
        if field == "direction":
            got, expected = got / np.linalg.norm(got), expected / np.linalg.norm(expected)
        np.testing.assert_allclose(got, expected, rtol=2e-3, atol=2e-3)


def test_a_cone_is_found_as_well_as_the_points_tell():
    true = ph.SpotLight.at((0, -3, 1), target=(0, 0, 0), cone_angle=11, exponent=0)
    target = colors(MESH, ph.Scene([true], VIEWER))
    begin = replace(true, cone_angle=40, intensity=0.2)
    fit = MESH.phong.fit(ph.Scene([begin], VIEWER), MATERIAL, target, "intensity cone_angle")
    assert fit.scene.lights[0].cone_angle == pytest.approx(11, abs=0.5)  # points are 0.9° apart
    assert fit.scene.lights[0].intensity == pytest.approx(1.0, rel=1e-6)


def test_directions_are_found_through_their_shadows():
    ground = pv.Plane(center=(0, 0, -1.2), i_size=6, j_size=6, i_resolution=40, j_resolution=40)
    blocks = pv.MultiBlock({"ground": ground, "ball": SMALL})
    true = ph.DirectionalLight(direction=(1, 0.4, -1.1), intensity=0.7, name="sun")
    scene = ph.Scene([true], VIEWER, ph.LightModel(shadows=True))
    lit = blocks.phong.shade(scene, MATERIAL, precision="float64")
    begin = replace(scene, lights=[replace(true, direction=(0, 0, -1), intensity=1.0)])
    target = {name: lit[name]["phong"] for name in ("ground", "ball")}
    fit = blocks.phong.fit(begin, MATERIAL, target, {"sun": "intensity direction"})
    brightness, angle, _ = apart(fit.scene.lights[0], true)
    assert brightness < 1e-3
    assert angle < 0.1
    assert fit.error.rms < 0.01


def test_a_direction_alone_moves_and_all_else_stays():
    true = ph.DirectionalLight(direction=(1, 0.4, -1.1), intensity=0.7, diffuse=(0.9, 0.8, 0.7), name="sun")
    other = ph.PointLight(position=(0, 0, 3), intensity=0.2)
    target = colors(SMALL, ph.Scene([true, other], VIEWER))
    begin = replace(true, direction=(0, 1, 0))
    fit = SMALL.phong.fit(ph.Scene([begin, other], VIEWER), MATERIAL, target, {"sun": "direction"})
    assert fit.scene.lights == (replace(true, direction=fit.scene.lights[0].direction), other)
    assert apart(fit.scene.lights[0], true)[1] < 0.01


def test_deviations_of_directions_and_positions_cover_the_truth():
    """Found with noise of 0.01, differences from the truth are within three standard deviations in 99 %."""
    sun = ph.DirectionalLight(direction=(1, -1, -1), intensity=0.5, name="sun")
    bulb = ph.PointLight(position=(-1.5, -1, 2), intensity=0.4, name="bulb")
    scene = ph.Scene([sun, bulb], VIEWER, ph.LightModel(clamp=False))
    clean, random, inside = colors(SMALL, scene), np.random.default_rng(4), []
    for _ in range(5):
        noisy = np.maximum(clean + 0.01 * random.normal(size=clean.shape), 0.0)
        fit = SMALL.phong.fit(scene, MATERIAL, noisy, moving(scene), tries=1, tolerance=0.011)
        own, found = fit.deviations, dict(zip(("sun", "bulb"), fit.scene.lights, strict=True))
        inside.append(apart(found["sun"], sun)[1] < 3.0 * own["sun"]["direction"])
        inside.append(abs(found["sun"].intensity - 0.5) < 3.0 * own["sun"]["intensity"])
        inside.append(abs(found["bulb"].intensity - 0.4) < 3.0 * own["bulb"]["intensity"])
        off = np.abs(np.subtract(found["bulb"].position, bulb.position))
        inside += (off < 3.0 * np.array(own["bulb"]["position"])).tolist()
        assert own["sun"]["direction"] < 0.5
    assert np.mean(inside) >= 0.97


def test_a_light_that_is_far_away_cannot_be_told_from_its_intensity():
    flat = pv.Plane(i_resolution=20, j_resolution=20)
    lights = [ph.DirectionalLight(direction=(1, 0, -1), name="a"), ph.DirectionalLight(direction=(-1, 0, -1), name="b")]
    fit = flat.phong.fit(ph.Scene(lights, VIEWER), ph.Material(), 0.5, "intensity direction", tries=2)
    assert ("a", "b") in fit.alike
    assert fit.error.rms < 1e-9


def test_the_bits_do_not_depend_on_threads():
    true, begin = planted(1, 2)
    target = colors(SMALL, true)
    found = []
    for count in (1, 8):
        with threads.limited(count):
            found.append(SMALL.phong.fit(begin, MATERIAL, target, moving(begin), seed=3))
    assert found[0].scene == found[1].scene
    assert found[0].error == found[1].error


def test_progress_rises_and_an_interrupted_search_returns_the_best_so_far(monkeypatch):
    true, begin = planted(1, 2)
    target, heard = colors(SMALL, true), []
    with text.listening(lambda what, part: heard.append((what, part))):
        SMALL.phong.fit(begin, MATERIAL, target, moving(begin))
    parts = [part for _, part in heard]
    assert parts == sorted(parts)
    assert (heard[0][0], parts[-1]) == ("candidates", 1.0)
    count, descend = 0, search.Search.descend

    def interrupted(*given):
        nonlocal count
        count += 1
        if count == 2:
            raise KeyboardInterrupt
        return descend(*given)

    monkeypatch.setattr(search.Search, "descend", interrupted)
    fit = SMALL.phong.fit(begin, MATERIAL, target, moving(begin))
    assert fit.interrupted
    assert fit.error.rms < fit.before.rms
    assert "interrupted" in str(fit)


def test_a_tolerance_ends_the_search_early(monkeypatch):
    true, begin = planted(1, 2)
    target, descents, descend = colors(SMALL, true) * 0.9 + 0.02, [], search.Search.descend
    monkeypatch.setattr(search.Search, "descend", lambda *given: descents.append(1) or descend(*given))
    counts = []
    for tolerance in (0.0, 0.05):
        fit = SMALL.phong.fit(begin, MATERIAL, target, moving(begin), tolerance=tolerance)
        assert fit.is_within == (tolerance > 0.0)
        counts.append(len(descents))
    assert counts[1] - counts[0] == 2  # on the sample and on all vertices
    assert counts[0] > 5


def test_samples_of_blocks_ask_each_block_for_its_own_colours(monkeypatch):
    sun = ph.DirectionalLight(direction=(1, -1, -2), intensity=0.7, name="sun")
    blocks = pv.MultiBlock({"a": SMALL, "b": SMALL.translate((3, 0, 0))})
    lit = blocks.phong.shade(ph.Scene([sun], VIEWER), MATERIAL, precision="float64")
    samples, sampled = [], search._sampled

    def spy(few, some, *rest):
        samples.extend([few, some])
        return sampled(few, some, *rest)

    monkeypatch.setattr(search, "_sampled", spy)
    target = {path: lit[path]["phong"] for path in ("a", "b")}
    blocks.phong.fit(ph.Scene([sun], VIEWER), MATERIAL, target, {"sun": "intensity direction"}, tries=1)
    for each in samples:
        assert each.at([one.light for one in each.varied]).solution.squares < 1e-12
    assert len(samples) == 2


def test_a_light_of_the_camera_is_found_wherever_the_mesh_is():
    true, begin = ph.PointLight((0.5, 1.5, 1), frame="camera"), ph.PointLight((0, 0, 1), frame="camera")
    far = SMALL.translate((100, 0, 0))
    viewer = replace(VIEWER, position=np.add(VIEWER.position, (100, 0, 0)), focal_point=(100, 0, 0))
    fit = far.phong.fit(ph.Scene([begin], viewer), MATERIAL, colors(far, ph.Scene([true], viewer)), "position")
    np.testing.assert_allclose(fit.scene.lights[0].position, true.position, rtol=2e-3, atol=2e-3)


def test_deviations_are_those_of_the_value_that_was_found():
    true = ph.SpotLight.at((0, -3, 1), target=(0, 0, 0), exponent=8, name="spot")
    target = colors(SMALL, ph.Scene([true], VIEWER))
    target = target + np.random.default_rng(1).normal(0.0, 0.003, target.shape)
    scenes = [ph.Scene([replace(true, exponent=begin)], VIEWER) for begin in (2.0, 20.0)]
    fits = [SMALL.phong.fit(each, MATERIAL, target, "exponent") for each in scenes]
    one, other = (fit.deviations["spot"]["exponent"] for fit in fits)
    assert one == pytest.approx(other, rel=0.02)
