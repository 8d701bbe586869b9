"""Intensities and colours by bounded least squares, against SciPy's solver on columns from a textbook formula."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from scipy.optimize import nnls

import pvphong as ph
from pvphong.studies.fitting import linear
from pvphong.studies.fitting.target import Wanted

BALL = pv.Sphere(theta_resolution=24, phi_resolution=24)
VIEWER = ph.Viewer(position=(0, -3, 1))
MODEL = ph.LightModel(ambient=0.0, clamp=False)
MATTE = ph.Material(ambient=0.0, diffuse=(0.7, 0.5, 0.3))
SUN = ph.DirectionalLight(direction=(1, 0.5, -1), name="sun")
SKY = ph.DirectionalLight(direction=(0, 0, -1), name="sky")
BULB = ph.PointLight(position=(1.5, -1, 0.5), attenuation=(0, 0, 1), name="bulb")
BACK = ph.DirectionalLight(direction=(-1, 0.2, 0.3), name="back")


def areas(mesh):
    """A third of the area of the triangles around each point."""
    faces = mesh.regular_faces
    a, b, c = mesh.points.astype(float)[faces].transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return sum(np.bincount(faces[:, k], area, mesh.n_points) for k in range(3)) / 3.0


def lambert(light, mesh=BALL):
    """max(n·l, 0) / d² or max(n·l, 0), from the formula."""
    n = mesh.point_normals.astype(float)
    n /= np.linalg.norm(n, axis=1)[:, None]
    if isinstance(light, ph.PointLight):
        to = np.array(light.position) - mesh.points.astype(float)
        d = np.linalg.norm(to, axis=1)
        return np.maximum((n * to).sum(axis=1) / d, 0.0) / d**2
    to = -np.array(light.direction)
    return np.maximum(n @ (to / np.linalg.norm(to)), 0.0)


def scene_of(*lights, model=MODEL):
    return ph.Scene(lights, VIEWER, model)


def intensities(fit):
    return [light.intensity for light in fit.scene.lights]


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_intensities_are_scipys_on_textbook_columns(noise):
    lights = [SUN, SKY, BULB, BACK]
    columns = np.stack([np.outer(lambert(light), MATTE.diffuse) for light in lights])
    target = np.tensordot([0.5, -noise, 0.8, 0.25], columns, 1)
    target = np.maximum(target + noise * np.random.default_rng(1).normal(size=target.shape), 0.0)
    roots = np.sqrt(areas(BALL))[:, None]
    expected, _ = nnls((columns * roots).reshape(4, -1).T, (target * roots).ravel())
    assert (expected == 0.0).any()  # a bound counts
    fit = BALL.phong.fit(scene_of(*lights), MATTE, target, "intensity")
    np.testing.assert_allclose(intensities(fit), expected, rtol=1e-6, atol=1e-7)
    np.testing.assert_array_equal(np.array(intensities(fit)) == 0.0, expected < 1e-7)
    off = np.tensordot(expected, columns, 1) - target
    rms = np.sqrt((roots**2 * off**2).sum() / (3 * areas(BALL).sum()))
    assert fit.error.rms == pytest.approx(rms, rel=1e-6, abs=1e-7)
    assert fit.error.largest == pytest.approx(np.abs(off).max(), rel=1e-5, abs=1e-6)
    assert fit.violation < 1e-9
    np.testing.assert_allclose(fit.differences, off, atol=1e-6)
    np.testing.assert_allclose(fit.lit["phong"], target + fit.differences, atol=2e-6)


def test_colors_are_solved_channel_by_channel():
    lights = [SUN, BULB]
    target = np.random.default_rng(2).uniform(0.0, 0.5, (BALL.n_points, 3))
    roots = np.sqrt(areas(BALL))
    fit = BALL.phong.fit(scene_of(*lights), MATTE, target, "diffuse, intensity")
    for c in range(3):
        columns = np.stack([lambert(light) * MATTE.diffuse[c] for light in lights])
        expected, _ = nnls((columns * roots).T, target[:, c] * roots)
        found = [light.intensity * light.diffuse[c] for light in fit.scene.lights]
        np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert all(max(light.diffuse) == pytest.approx(1.0, rel=1e-12) for light in fit.scene.lights)


def test_luminances_are_of_the_lit_colors():
    lights, weights = [SUN, BULB], np.array([0.2126, 0.7152, 0.0722])
    target = np.random.default_rng(3).uniform(0.0, 0.5, BALL.n_points)
    columns = np.stack([lambert(light) * (weights @ MATTE.diffuse) for light in lights])
    roots = np.sqrt(areas(BALL))
    expected, _ = nnls((columns * roots).T, target * roots)
    fit = BALL.phong.fit(scene_of(*lights), MATTE, target, "intensity")
    np.testing.assert_allclose(intensities(fit), expected, rtol=1e-6)


def test_nan_and_weights_choose_the_points_that_count():
    target, weights = np.full(BALL.n_points, 0.3), np.zeros(BALL.n_points)
    top = BALL.points[:, 2] > 0.3
    target[~top], weights[top] = np.nan, 1.0
    by_nan = BALL.phong.fit(scene_of(SUN, BULB), MATTE, target, "intensity")
    by_weight = BALL.phong.fit(scene_of(SUN, BULB), MATTE, np.full(BALL.n_points, 0.3), "intensity", weights=weights)
    assert intensities(by_nan) == intensities(by_weight)
    assert np.isnan(by_nan.differences[~top]).all()
    assert not np.isnan(by_nan.differences[top]).any()
    doubled = np.where(BALL.points[:, 0] > 0, 2.0, 1.0)
    heavier = BALL.phong.fit(scene_of(SUN, BULB), MATTE, target, "intensity", weights=np.where(top, doubled, 0.0))
    columns = np.stack([lambert(light) for light in (SUN, BULB)]) * (np.array([0.2126, 0.7152, 0.0722]) @ MATTE.diffuse)
    roots = np.sqrt(areas(BALL) * doubled * top)
    expected, _ = nnls((columns * roots).T, np.where(top, 0.3, 0.0) * roots)
    np.testing.assert_allclose(intensities(heavier), expected, rtol=1e-6)


def planted(lights, model, material, mesh=BALL, **how):
    return mesh.phong.shade(scene_of(*lights, model=model), material, precision="float64", **how)["phong"]


GLOSSY = ph.Material(ambient=0.2, diffuse=(0.4, 0.5, 0.6), specular=0.4, shininess=12, emission=0.02)
FOUND = [replace(SUN, intensity=0.4), replace(SKY, intensity=0.3), replace(BULB, intensity=0.7)]
STEP = pv.Box((-1, 1, -1, 1, -1, -0.6)).triangulate().subdivide(3).compute_normals(split_vertices=True)
TWO_SIDED = ph.LightModel(two_sided=True)


@pytest.mark.parametrize(
    ("model", "mesh"),
    [
        (ph.LightModel(), BALL),
        (ph.LightModel(reflection="blinn-phong", two_sided=True), BALL),
        (ph.LightModel.vtk(), BALL),
        (ph.LightModel(shadows=True, ambient_occlusion=True, ambient=0.1), STEP.merge(BALL)),
        (ph.LightModel(bounces=2, ambient=0.1), STEP.merge(BALL)),
    ],
    ids=["standard", "two-sided", "vtk", "shadows", "bounces"],
)
def test_planted_intensities_come_back(model, mesh):
    mesh = mesh.extract_surface(algorithm=None) if not isinstance(mesh, pv.PolyData) else mesh
    transport = mesh.phong.transport(samples=16) if model.bounces else None
    target = planted(FOUND, model, GLOSSY, mesh, transport=transport)
    start = [replace(light, intensity=1.0) for light in FOUND]
    fit = mesh.phong.fit(scene_of(*start, model=model), GLOSSY, target, "intensity", transport=transport)
    # rays and bounces are in float32
    np.testing.assert_allclose(intensities(fit), [0.4, 0.3, 0.7], rtol=1e-6 if not model.is_global else 2e-5)
    assert fit.error.rms < (1e-7 if not model.is_global else 1e-5)
    assert np.abs(fit.lit["phong"] - target).max() < 1e-4


def test_fields_that_do_not_vary_stay_to_the_bit():
    target = planted(FOUND, ph.LightModel(), GLOSSY)
    start = [replace(FOUND[0], intensity=0.1), FOUND[1], replace(FOUND[2], specular=(0.1, 0.2, 0.3), intensity=0.3)]
    scene = scene_of(*start, model=ph.LightModel())
    fit = BALL.phong.fit(scene, GLOSSY, target, {"sun": "intensity", "bulb": ["diffuse"]})
    sun, sky, bulb = fit.scene.lights
    assert sky is start[1]
    assert sun == replace(start[0], intensity=sun.intensity)
    assert bulb == replace(start[2], diffuse=bulb.diffuse)
    assert (fit.scene.viewer, fit.scene.light_model) == (scene.viewer, scene.light_model)


def test_specular_and_ambient_colors_are_told_apart():
    true = replace(BULB, intensity=0.5, diffuse=(0.9, 0.6, 0.3), specular=(0.2, 0.8, 0.5), ambient=(0.1, 0.0, 0.2))
    target = planted([true], ph.LightModel(), GLOSSY)
    fit = BALL.phong.fit(scene_of(BULB, model=ph.LightModel()), GLOSSY, target, "intensity diffuse specular ambient")
    found = fit.scene.lights[0]
    for field in ("diffuse", "specular", "ambient"):
        got, expected = (light.intensity * np.array(getattr(light, field)) for light in (found, true))
        np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-9)


def test_clamped_colors_do_not_pull_intensities_down():
    """A target that was clamped at 1 means "at least 1"."""
    bright = [replace(SUN, intensity=2.5), replace(BULB, intensity=1.5)]
    target = planted(bright, ph.LightModel(), GLOSSY)
    assert (target == 1.0).mean() > 0.1
    fit = BALL.phong.fit(scene_of(SUN, BULB, model=ph.LightModel()), GLOSSY, target, "intensity")
    np.testing.assert_allclose(intensities(fit), [2.5, 1.5], rtol=1e-6)
    assert fit.least_error == 0.0


@pytest.mark.parametrize(
    "target",
    [
        np.where(lambert(SUN) > 0.3, 0.95, 0.0),
        np.where(BALL.points[:, 0] < -0.35, 0.95, 0.5),
        np.where(lambert(SUN) > 0.02, 0.99, 0.01),
        np.clip(0.6 * lambert(SUN), 0.0, 1.0),
    ],
    ids=["half", "side", "all", "none"],
)
def test_no_intensity_is_better_where_colors_are_clamped(target):
    """Compare with all intensities of a grid."""
    scene = scene_of(replace(SUN, intensity=3.0), model=ph.LightModel(ambient=0.0))
    fit = BALL.phong.fit(scene, ph.Material(ambient=0.0, diffuse=1.0), target, "intensity")

    def squares(intensity):
        lit = np.minimum(intensity * lambert(SUN), 1.0)
        return (areas(BALL) * (lit - target) ** 2).sum()

    (best,) = intensities(fit)
    assert squares(best) <= min(squares(each) for each in np.linspace(0.0, 12.0, 1201)) * (1.0 + 1e-3) + 1e-12
    assert all(squares(best) <= squares(best * (1.0 + step)) + 1e-15 for step in (-0.01, -1e-4, 1e-4, 0.01))
    is_over = best * lambert(SUN).max() > 1.0
    assert (fit.least_error == 0.0) == (is_over or fit.error.rms < 1e-9)  # the problem is then not convex


def test_a_target_that_cannot_be_met_has_a_certificate():
    target = np.where(BALL.points[:, 2] > 0, 0.0, 0.6)
    fit = BALL.phong.fit(scene_of(SKY), MATTE, target, "intensity")
    assert fit.error.rms == pytest.approx(fit.least_error, rel=1e-9)
    assert intensities(fit) == [0.0]
    (dark,) = fit.unmet
    assert "none of the lights that vary arrives" in dark.what
    assert dark.points == (BALL.points[:, 2] < -1e-6).sum()
    assert dark.largest == pytest.approx(0.6)
    assert f"come nearer than {fit.least_error:.3g}" in " ".join(str(fit).split())
    lit = BALL.phong.fit(scene_of(SUN, SKY, model=ph.LightModel(ambient=1.0)), GLOSSY, 0.05, {"sky": "intensity"})
    assert [each.what.split(",")[0] for each in lit.unmet] == ["darker than ambient light"]
    asked = BALL.phong.fit(scene_of(SUN, model=ph.LightModel()), GLOSSY, 1.5, "intensity")
    assert "brighter than 1" in asked.unmet[-1].what


def test_lights_that_cannot_be_told_apart_are_named():
    twin = replace(SUN, name="twin", intensity=2.0)
    fit = BALL.phong.fit(scene_of(SUN, twin, SKY), MATTE, 0.4, "intensity")
    assert fit.alike == (("sun", "twin"),)
    assert "does not tell 'sun' and 'twin' apart" in str(fit)
    assert np.isnan(fit.deviations["sun"]["intensity"]) or np.isnan(fit.deviations["twin"]["intensity"])
    assert BALL.phong.fit(scene_of(SUN, SKY), MATTE, 0.4, "intensity").alike == ()


def test_deviations_cover_the_truth():
    """Of 400 numbers found with noise, at least 98 % are within three standard deviations, not all within one."""
    random, truth = np.random.default_rng(5), [0.5, 0.3]
    lights = [replace(SUN, intensity=0.5), replace(BULB, intensity=0.3)]
    clean = planted(lights, MODEL, MATTE)
    scores = []
    for _ in range(200):
        noisy = np.maximum(clean + 0.01 * random.normal(size=clean.shape), 0.0)
        keep = clean.min(axis=1) > 0.05  # no noise is cut off
        fit = BALL.phong.fit(scene_of(SUN, BULB), MATTE, np.where(keep[:, None], noisy, np.nan), "intensity")
        found = zip(intensities(fit), truth, ("sun", "bulb"), strict=True)
        scores += [(got - true) / fit.deviations[name]["intensity"] for got, true, name in found]
    assert np.mean(np.abs(scores) < 3.0) >= 0.98
    assert 0.85 < np.std(scores) < 1.15


def test_points_of_volumes_and_split_edges_have_the_targets_of_their_own():
    grid = pv.ImageData(dimensions=(4, 4, 4), spacing=(0.3, 0.3, 0.3))
    wanted = np.random.default_rng(1).uniform(0.1, 0.5, grid.n_points)
    surface = grid.phong.shade(SUN)
    rows = surface["vtkOriginalPointIds"]
    for mesh, target in ((grid, wanted), (surface, wanted[rows])):
        mesh = mesh.copy()
        mesh.clear_data()
        fit = mesh.phong.fit(scene_of(SUN, SKY), MATTE, target, "intensity", feature_angle=30)
        assert fit.lit.n_points > surface.n_points
        shown = fit.lit["phong"] @ [0.2126, 0.7152, 0.0722]
        rows = fit.lit[
            "vtkOriginalPointIds"
            if mesh is not surface and "vtkOriginalPointIds" in fit.lit.point_data
            else "pvphong_original_point"
        ]
        np.testing.assert_allclose(shown - fit.differences, target[rows], atol=1e-6)


def test_equal_calls_give_equal_bits():
    target = np.random.default_rng(1).uniform(0.1, 0.5, (BALL.n_points, 3))
    one, two = (BALL.phong.fit(scene_of(SUN, BULB), MATTE, target, "intensity diffuse") for _ in range(2))
    assert one.scene == two.scene
    assert one.error == two.error


def test_blocks_are_fitted_together():
    moved = BALL.translate((1.5, 0, 0))
    blocks = pv.MultiBlock({"left": BALL, "gap": None, "right": moved})
    lights, start = [replace(SUN, intensity=0.4), replace(BULB, intensity=0.6)], scene_of(SUN, BULB)
    lit = blocks.phong.shade(scene_of(*lights), {"left": MATTE, "default": GLOSSY}, precision="float64")
    target = {path: lit[path]["phong"] for path in ("left", "right")}
    fit = blocks.phong.fit(start, {"left": MATTE, "default": GLOSSY}, target, "intensity")
    np.testing.assert_allclose(intensities(fit), [0.4, 0.6], rtol=1e-6)
    assert fit.lit.keys() == ["left", "gap", "right"]
    assert set(fit.differences) == {"left", "right"}
    assert len(fit.differences["left"]) == BALL.n_points
    alone = blocks.phong.fit(start, MATTE, {"left": target["left"]}, "intensity")
    np.testing.assert_allclose(intensities(alone), [0.4, 0.6], rtol=1e-6)
    everywhere = {path: np.ones(BALL.n_points) for path in ("left", "right")}
    weighted = blocks.phong.fit(start, MATTE, {"left": target["left"]}, "intensity", weights=everywhere)
    np.testing.assert_allclose(intensities(weighted), [0.4, 0.6], rtol=1e-6)
    with pytest.raises(
        ValueError, match=r"target must be a mapping whose keys are paths of blocks.*; got a mapping with 'lft'"
    ):
        blocks.phong.fit(start, MATTE, {"lft": 0.5}, "intensity")


DARK = replace(SKY, direction=(0, 0, 1), name="dark")
BAD = [
    ({"vary": {}}, r"vary must be a mapping of lights to fields, .*; got no light\. The lights are sun, bulb, dark"),
    ({"vary": {"sn": "intensity"}}, r"vary must be .*; got a light 'sn'\. Did you mean 'sun'"),
    (
        {"vary": {"sun": "position"}},
        r"vary\['sun'\] must be fields of the light that can vary; got 'position'\. This Dir",
    ),
    ({"vary": {"sun": ""}}, r"vary\['sun'\] must be names of fields"),
    (
        {"vary": {"dark": "intensity"}},
        r"vary must be lights that light points of the target; got 'dark', which lights none of these points",
    ),
    ({"vary": 3}, r"vary must be a mapping of lights to fields"),
    ({"target": np.zeros(5)}, r"target must be an array of shape \(\d+,\) or \(\d+, 3\); got an array of shape \(5,\)"),
    ({"target": "wnted"}, r"target must be an array .*; got 'wnted'\. Did you mean 'wanted'"),
    (
        {"target": {"wanted": 0.5}},
        r"target must be .*; got a mapping\. ph\.target\(mesh, \{\.\.\.\}\) makes an array\.",
    ),
    (
        {"target": np.ones(BALL.n_points, bool)},
        r"got an array of True and False\. np\.where\(mask, 0\.8, np\.nan\) asks for",
    ),
    (
        {"target": np.ones(BALL.n_cells)},
        r"got an array of shape .* Values of cells become values of points by mesh\.cell_d",
    ),
    (
        {"vary": "sun"},
        r"vary must be lights with fields, or fields; got the light 'sun' without fields.*\{\"sun\": \"intensity",
    ),
    ({"vary": {"sun": "intesity"}}, r"got 'intesity'\. Did you mean 'intensity'\? This DirectionalLight can vary"),
    ({"target": -1.0}, r"target must be numbers >= 0 that are finite; got \[-1\.0\] at point 0"),
    ({"target": np.inf}, r"target must be numbers >= 0 that are finite"),
    ({"target": np.nan}, r"target must be a number or a colour at some points; got NaN everywhere"),
    ({"weights": np.zeros(BALL.n_points)}, r"weights must be above 0 at some points that have an area"),
    ({"weights": np.full(BALL.n_points, np.nan)}, r"weights must be an array with a number >= 0 for each point"),
    ({"weights": np.ones(3)}, r"weights must be an array with a number >= 0 .*; got an array of shape \(3,\)"),
    (
        {"target": "few", "vary": {"bulb": "position"}},
        r"target must be a target with at least 3 numbers, because 3 numbers of lights vary; got a target w",
    ),
    (
        {"target": "few", "weights": np.ones(BALL.n_points)},
        r"target must be finite where weights are above 0; got NaN at",
    ),
    (
        {"vary": {"sun": "diffuse"}},
        r"target must be colours if colours of lights vary; got luminances, which determine no",
    ),
    ({"max_lights": 0}, r"max_lights must be a finite number >= 1"),
    ({"tries": 1.5}, r"tries must be a whole number >= 1"),
    (
        {"max_lights": 1, "vary": {"sun": "direction"}},
        r"vary must be intensities and colours if max_lights is given; got directions",
    ),
    (
        {"material": ph.Material(reflectance=ph.PBR()), "model": ph.LightModel.vtk()},
        r"material must be a material without a gamma",
    ),
]


@pytest.mark.parametrize(("change", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_refused_in_one_line(change, message):
    mesh = BALL.copy()
    mesh["wanted"] = np.where(mesh.points[:, 2] > 0, 0.5, np.nan)
    mesh["few"] = np.where(np.arange(mesh.n_points) == 40, 0.5, np.nan)
    before, lights = mesh.copy(), [SUN, BULB, DARK]
    given = {"material": MATTE, "target": "wanted", "vary": {"sun": "intensity"}} | change
    scene = scene_of(*lights, model=given.pop("model", MODEL))
    with pytest.raises(ValueError, match=message) as refused:
        mesh.phong.fit(scene, **given)
    assert "\n" not in str(refused.value)
    assert mesh == before


def test_without_scipy_one_line_names_the_extra(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    with pytest.raises(ValueError, match=r"^fit needs SciPy, .* pip install scipy, or install the extra fit\.$"):
        BALL.phong.fit(scene_of(SUN), MATTE, 0.5, "intensity")


def test_points_that_are_not_finite_harm_no_other():
    target = planted(FOUND, ph.LightModel(), GLOSSY)
    torn = BALL.copy()
    torn.points[40] = np.nan
    torn.point_data.active_normals[50] = 0.0
    target[50] = np.nan
    start = [replace(light, intensity=1.0) for light in FOUND]
    fit = torn.phong.fit(scene_of(*start, model=ph.LightModel()), GLOSSY, target, "intensity")
    np.testing.assert_allclose(intensities(fit), [0.4, 0.3, 0.7], rtol=1e-6)


@pytest.mark.parametrize(("scale", "offset"), [(1e-6, 0.0), (1e6, 0.0), (100.0, 5e6)])
def test_sizes_and_places_of_meshes_do_not_matter(scale, offset):
    mesh = BALL.copy()
    mesh.points = BALL.points.astype(float) * scale + offset
    lamp = ph.PointLight(position=np.array([2.0, -1.0, 0.5]) * scale + offset, intensity=0.3)
    target = mesh.phong.shade(lamp, GLOSSY, precision="float64")["phong"]
    begin = replace(lamp, position=np.array([0.0, 0.0, 2.0]) * scale + offset, intensity=1.0)
    fit = mesh.phong.fit(begin, GLOSSY, target, "intensity position", tries=3)
    assert fit.scene.lights[0].intensity == pytest.approx(0.3, rel=1e-6)
    np.testing.assert_allclose((np.array(fit.scene.lights[0].position) - offset) / scale, [2.0, -1.0, 0.5], atol=1e-6)


def test_other_lights_that_cannot_vary_are_refused():
    off, head = replace(SUN, on=False), ph.PointLight(frame="headlight", name="head")
    with pytest.raises(ValueError, match=r"vary\['sun'\] must be a light that is on"):
        BALL.phong.fit(scene_of(off, SKY), MATTE, 0.5, {"sun": "intensity"})
    with pytest.raises(
        ValueError, match=r"vary\['head'\] must be fields .*; got 'position'\. A headlight can vary int"
    ):
        BALL.phong.fit(scene_of(head), MATTE, 0.5, {"head": "position"})
    with pytest.raises(
        ValueError,
        match=r"must be the intensity with all colours, or without colours; .* Vary its specular too, or not its i",
    ):
        BALL.phong.fit(scene_of(replace(SUN, specular="red")), GLOSSY, 0.5, {"sun": "intensity diffuse"})
    with pytest.raises(ValueError, match=r"of intensity 0"):
        BALL.phong.fit(scene_of(replace(SUN, intensity=0.0)), MATTE, 0.5, {"sun": "diffuse"})
    with pytest.raises(ValueError, match=r"scene must be a scene with a light to vary"):
        BALL.phong.fit(scene_of(), MATTE, 0.5, "intensity")


def test_visibility_and_transport_made_before_are_used():
    blocks = pv.MultiBlock({"ball": BALL, "floor": STEP})
    model = ph.LightModel(shadows=True, ambient_occlusion=2.0, bounces=1, ambient=0.1)
    true, start = scene_of(*FOUND, model=model), scene_of(SUN, SKY, BULB, model=model)
    made = {"visibility": blocks.phong.visibility(true), "transport": blocks.phong.transport(samples=16)}
    lit = blocks.phong.shade(true, GLOSSY, precision="float64", **made)
    target = {name: lit[name]["phong"] for name in ("ball", "floor")}
    fit = blocks.phong.fit(start, GLOSSY, target, "intensity", **made)
    np.testing.assert_allclose(intensities(fit), [0.4, 0.3, 0.7], rtol=2e-5)
    np.testing.assert_allclose(fit.lit["floor"]["phong"], target["floor"], atol=1e-5)
    with pytest.raises(ValueError, match=r"visibility must be None if directions, positions or sizes vary; got a Visi"):
        blocks.phong.fit(start, GLOSSY, target, {"sun": "direction"}, **made)


def test_deviations_of_two_colours_are_those_of_one_scale():
    """The channel that carries the intensity has none; the others are those of a fit of the colours alone, nearly."""
    true = replace(SUN, intensity=0.8, diffuse=(0.9, 0.6, 0.3), specular=(0.2, 0.3, 0.4))
    target = BALL.phong.shade(scene_of(true), GLOSSY, precision="float64")["phong"]
    target = target + np.random.default_rng(3).normal(0.0, 0.005, target.shape)
    begin = replace(SUN, diffuse=(0.9, 0.5, 0.5), specular=(0.5, 0.5, 0.5))
    both = BALL.phong.fit(scene_of(begin), GLOSSY, target, "intensity diffuse specular")
    colors = BALL.phong.fit(scene_of(begin), GLOSSY, target, "diffuse specular")
    own, other = both.deviations["sun"], colors.deviations["sun"]
    assert own["diffuse"][0] == pytest.approx(0.0, abs=1e-9)
    assert min(own["specular"]) > 0.0
    scale = both.scene.lights[0].intensity / colors.scene.lights[0].intensity
    np.testing.assert_allclose(np.multiply(own["specular"], scale), other["specular"], rtol=0.1)
    assert own["intensity"] == pytest.approx(other["diffuse"][0] * colors.scene.lights[0].intensity / 0.9, rel=0.1)


def test_luminances_beside_colours_are_refused():
    blocks = pv.MultiBlock({"left": BALL, "right": BALL.translate((1.5, 0, 0))})
    grey, colors = np.full(BALL.n_points, 0.4), np.full((BALL.n_points, 3), 0.4)
    with pytest.raises(ValueError, match=r"^target must be all luminances, or all colours"):
        blocks.phong.fit(scene_of(SUN), MATTE, {"left": grey, "right": colors}, "intensity")
    nothing = np.full((BALL.n_points, 3), np.nan)
    fit = blocks.phong.fit(scene_of(SUN), MATTE, {"left": grey, "right": nothing}, "intensity")
    assert np.isnan(fit.differences["right"]).all()


def test_more_than_white_asks_for_white_where_colours_are_clamped():
    bright = np.where(BALL.points[:, 2] > 0.3, 1.5, np.nan)
    fit = BALL.phong.fit(scene_of(SUN, SKY, model=ph.LightModel()), MATTE, bright, "intensity")
    assert np.nanmax(np.abs(fit.differences)) == pytest.approx(fit.error.largest)


def random_problem(channels, *, level=1.6):
    """Return a problem of four unknowns, one of them green, whose colours clamp at some of 60 points."""
    random = np.random.default_rng(7)
    columns = [linear.Column(random.uniform(0.0, 1.0, (60, 3)), channel) for channel in (None, None, 1, None)]
    values, roots = random.uniform(0.2, level, (60, channels)), random.uniform(0.5, 1.0, (60, channels))
    return linear.Problem(random.uniform(0.0, 0.2, (60, 3)), columns, Wanted(values, roots, clamps=True))


@pytest.mark.parametrize("channels", [1, 3])
def test_rows_of_clamped_colours_are_derivatives_of_the_residual(channels):
    problem, x = random_problem(channels), np.array([0.5, 0.3, 0.4, 0.2])
    clamped = problem.clamped(problem.colors(x), convex=False)
    assert 10 < clamped.sum() < 120
    found = np.zeros((4, 60, channels))
    for c, (numbers, rows) in enumerate(problem.rows(clamped)):
        found[numbers, :, c] = rows
    for k in range(4):
        step = 1e-6 * (np.arange(4) == k)
        sides = [problem.residual(problem.colors(x + sign * step), clamped) for sign in (1.0, -1.0)]
        np.testing.assert_allclose(found[k], (sides[1] - sides[0]) / 2e-6, atol=1e-8)


def test_a_start_nearby_changes_no_solution_of_a_convex_problem():
    problem = random_problem(3, level=0.7)
    cold, warm = linear.solve(problem), linear.solve(problem, np.array([0.1, 0.6, 0.0, 0.2]))
    assert cold.is_convex
    assert warm.is_convex
    np.testing.assert_allclose(warm.x, cold.x, atol=1e-10)
