"""Refined meshes in hard shadows and cones: cuts against known edges, topology, and documented guarantees."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base import threads
from pvphong.base.text import listening
from pvphong.rays import visibility

STEP = 1 / 255
SUN = ph.DirectionalLight(direction=(-0.3, -0.2, -1.0), name="sun")
LAMP = ph.PointLight(position=(0.7, 0.5, 3.0), name="lamp")
SPOT = ph.SpotLight(position=(0.2, 0.1, 2.0), direction=(0.1, 0.05, -1.0), cone_angle=25, exponent=1, name="spot")
MATT = ph.Material(ambient=0.1, diffuse=0.8)
SHADOWS = ph.LightModel(ambient=1.0, shadows=True)
CENTER, RADIUS = np.array([0.1, 0.2, 1.0]), 0.5
BALL = pv.Icosphere(radius=RADIUS, center=CENTER, nsub=6)


def scene(*lights, **model):
    return ph.Scene(lights, ph.Viewer(position=(0, -5, 5)), replace(SHADOWS, **model))


def floor(cells, size=4.0):
    ground = pv.Plane(i_size=size, j_size=size, i_resolution=cells, j_resolution=cells).triangulate()
    ground.points = ground.points.astype(float)
    return ground


def box(low, high):
    return pv.Box([*np.ravel(np.column_stack([low, high]))])


def areas(mesh):
    """Return the triangles' areas, signed by the z component of their normals."""
    p = mesh.points.astype(float)[mesh.regular_faces]
    return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2] / 2


def slanted_sheet():
    """Return a sheet that intersects the floor, where the edges of its shadows meet."""
    return pv.Plane(i_size=0.6, j_size=1.1).rotate_x(3).rotate_y(75).translate((-0.01, -0.22, 0.25))


def behind_ball(light):
    """Return a function that is True for places on the floor in the ball's shadow."""

    def dark(places):
        offset = CENTER - places
        if isinstance(light, ph.DirectionalLight):
            ray = np.broadcast_to(-np.array(light.direction), places.shape)
        else:
            ray = np.array(light.position) - places
        along = np.einsum("ki,ki->k", offset, ray) / np.einsum("ki,ki->k", ray, ray)
        return np.linalg.norm(offset - along[:, None] * ray, axis=1) < RADIUS

    return dark


def samples(mesh, count=40, seed=3):
    """Return random places in triangles, and the interpolated colours there."""
    weights = np.random.default_rng(seed).dirichlet(np.ones(3), size=(mesh.n_cells, count))
    corners = mesh.regular_faces
    places, colors = (weights @ each.astype(float)[corners] for each in (mesh.points, mesh["phong"]))
    return places, colors


def wrong_area(mesh, dark):
    """Return the area whose colour is not that of its side of the edge within a display step, in nearly even light."""
    places, colors = samples(mesh)
    is_dark = dark(places.reshape(-1, 3)).reshape(places.shape[:2])
    shade = colors[..., 0] - 0.1
    wrong = np.where(is_dark, shade > STEP, shade < 0.4)
    return float((wrong.mean(axis=1) * areas(mesh)).sum())


def reported(mesh, what, name="phong"):
    return np.asarray(mesh.field_data[f"{name}_refinement_{what}"])[0]


# --- known edges


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
def test_the_wrongly_coloured_area_falls_with_the_points_and_not_with_their_root(light):
    rig, dark = scene(light), behind_ball(light)
    cut, split, saw = [], [], []
    for cells in (16, 64):
        ground = floor(cells)
        refined = ground.phong.refine(rig, MATT, tolerance=2 * STEP, occluders=[BALL])
        options = {"occluders": [BALL], "cut": False, "max_points": refined.n_points}
        split.append(wrong_area(ground.phong.refine(rig, MATT, tolerance=2 * STEP, **options), dark))
        saw.append(wrong_area(ground.phong.shade(rig, MATT, occluders=[BALL]), dark))
        cut.append(wrong_area(refined, dark))
        assert cut[-1] <= reported(refined, "strip") < 5e-3
        assert refined.field_data["phong_refinement_reached"][0]
    assert saw[0] / saw[1] == pytest.approx(4.0, rel=0.35)  # 16 times the points, to the power −½
    assert cut[1] < 1e-4 * 16 < split[1] / 10
    assert cut[1] < saw[1] / 100


def test_three_times_the_points_of_a_grid_are_more_than_enough():
    ground = floor(99)
    refined = ground.phong.refine(scene(LAMP), MATT, tolerance=STEP, occluders=[BALL], max_points=3 * ground.n_points)
    assert wrong_area(refined, behind_ball(LAMP)) < 1e-4 * 15


def test_the_corners_of_a_square_are_found():
    square = pv.Plane(center=(0.13, 0.07, 1.0), i_size=0.9, j_size=0.7)
    refined = floor(7).phong.refine(scene(replace(SUN, direction=(0, 0, -1))), MATT, tolerance=STEP, occluders=[square])

    def dark(places):
        return (np.abs(places[:, :2] - (0.13, 0.07)) < (0.45, 0.35)).all(axis=1)

    assert wrong_area(refined, dark) < 2e-4 * 0.63
    on_cut = refined.points[refined["phong_refinement_pair"] >= 0][:, :2]
    for corner in ((0.58, 0.42), (-0.32, 0.42), (0.58, -0.28), (-0.32, -0.28)):
        assert np.linalg.norm(on_cut - corner, axis=1).min() < math.sqrt(32) / 512


def test_no_bar_of_a_fence_is_lost():
    bars = [box((-0.8, y, 0.5), (0.8, y + 0.01, 0.51)) for y in np.linspace(-0.6, 0.55, 5)]
    rig = scene(replace(SUN, direction=(0, 0, -1)))
    refined = floor(6, size=2.0).phong.refine(rig, MATT, tolerance=STEP, occluders=bars)

    def dark(places):
        within = [(places[:, 1] > y) & (places[:, 1] < y + 0.01) for y in np.linspace(-0.6, 0.55, 5)]
        return (np.abs(places[:, 0]) < 0.8) & np.any(within, axis=0)

    assert wrong_area(refined, dark) < 0.03 * 5 * 1.6 * 0.01


def test_a_cone_is_cut_where_it_ends():
    axis = np.array(SPOT.direction) / np.linalg.norm(SPOT.direction)
    refined = floor(12).phong.refine(scene(SPOT, shadows=False), MATT, tolerance=STEP)

    def dark(places):
        ray = places - SPOT.position
        return ray @ axis < np.linalg.norm(ray, axis=1) * math.cos(math.radians(25))

    assert refined.field_data["phong_refinement_reached"][0]
    assert reported(refined, "cut") > 50
    assert wrong_area(refined, dark) <= reported(refined, "strip") < 5e-3
    paired = refined["phong_refinement_pair"] >= 0
    ray = refined.points[paired] - SPOT.position
    off = np.degrees(np.arccos(ray @ axis / np.linalg.norm(ray, axis=1))) - 25
    assert np.abs(off).max() < math.degrees(math.sqrt(32) / 4096 / 2)


def test_vertices_exactly_on_an_edge_are_on_both_sides():
    roof = box((-1, -1, 0.5), (1, 1, 0.6))
    refined = floor(8).phong.refine(scene(replace(SUN, direction=(0, 0, -1))), MATT, tolerance=STEP, occluders=[roof])
    assert wrong_area(refined, lambda p: (np.abs(p[:, :2]) < 1).all(axis=1)) < 1e-5
    assert refined.n_points < 81 + 40  # only the doubled points are added


# --- sheets


HARD = {
    "floor": lambda: (floor(9), [BALL], scene(SUN, LAMP)),
    "cones and shadows cross": lambda: (floor(9), [BALL], scene(SPOT, LAMP)),
    "closed": lambda: (pv.Sphere(), [box((0, -1, 0.6), (0.2, 1, 0.8))], scene(LAMP)),
    "through": lambda: (floor(9), [pv.Sphere(radius=0.7, center=(0.1, 0.3, 0.2))], scene(LAMP, SUN)),
    "standing": lambda: (floor(9), [box((-0.33, -0.4, 0), (0.4, 0.52, 0.9))], scene(SUN)),
    "sheet through": lambda: (floor(9), [slanted_sheet()], scene(LAMP, replace(SUN, direction=(0.35, -0.04, -1.0)))),
    "coplanar": lambda: (floor(9), [pv.Plane(center=(0.1, 0.1, 0)), BALL], scene(SUN)),
}


@pytest.mark.parametrize("case", HARD)
def test_areas_stay_sheets_meet_in_pairs_and_colours_hold_but_for_a_strip_that_is_reported(case):
    """Colours are compared at 64 places of each triangle of meshes with constant normals."""
    mesh, occluders, rig = HARD[case]()
    before = mesh.copy()
    refined = mesh.phong.refine(rig, MATT, tolerance=2 * STEP, occluders=occluders, precision="float64")
    assert mesh == before
    assert reported(refined, "cut") > 0
    points, faces = refined.points.astype(float), refined.regular_faces
    if case == "closed":
        assert refined.volume == pytest.approx(mesh.volume, rel=1e-6)
    else:
        assert areas(refined).sum() == pytest.approx(16.0, rel=1e-12)
        assert areas(refined).min() > 0.0
        assert looked_at(refined, mesh, occluders, rig).sum() <= reported(refined, "strip") < 0.01
        # some triangles are not cut where edges of several lights meet
        assert refined.field_data["phong_refinement_stopped"] == ("jump" if case == "sheet through" else "tolerance")
    pair = refined["phong_refinement_pair"]
    paired = np.flatnonzero(pair >= 0)
    np.testing.assert_array_equal(points[pair[paired]], points[paired])
    assert (pair[paired] != paired).all()
    new = np.arange(mesh.n_points, refined.n_points)
    assert (refined["pvphong_original_point"][new] == -1).all()
    np.testing.assert_array_equal(refined["pvphong_original_point"][: mesh.n_points], np.arange(mesh.n_points))
    place = np.arange(refined.n_points)
    for _ in range(8):  # the lowest index of coincident points
        place[paired] = np.minimum(place[paired], place[pair[paired]])
    whole = place[faces]
    sides = np.sort(np.stack([whole, np.roll(whole, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    sides, counts = np.unique(sides, axis=0, return_counts=True)
    assert set(counts) <= {1, 2}
    a, b = points[sides[counts == 1].T]
    lengths = np.linalg.norm(a - b, axis=1).sum()
    assert lengths == pytest.approx(0.0 if case == "closed" else 16.0, abs=1e-9)
    euler = len(np.unique(whole)) - len(sides) + len(whole)
    assert euler == (2 if case == "closed" else 1)


def looked_at(refined, mesh, occluders, rig):
    """Return the wrongly coloured area of each triangle, from rays at random places; the floor has constant normals."""
    places, colors = samples(refined, count=64)
    cloud = pv.PolyData(places.reshape(-1, 3))
    cloud.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (cloud.n_points, 1))
    truth = cloud.phong.shade(rig, MATT, occluders=[mesh, *occluders], precision="float64")["phong"]
    off = np.abs(truth.reshape(colors.shape) - colors).max(axis=2)
    return (off > 2 * STEP).mean(axis=1) * areas(refined)


def thrown(seed):
    """Return a floor, random occluders that may intersect it, and a scene of lights without a size."""
    random = np.random.default_rng(seed)

    def thing():
        center = random.uniform((-1, -1, 0.15), (1, 1, 1.4))
        kinds = [
            lambda: pv.Icosphere(radius=random.uniform(0.2, 0.6), nsub=int(random.integers(1, 5))),
            lambda: box((0, 0, 0), random.uniform(0.1, 0.8, 3)),
            lambda: pv.Disc(inner=random.uniform(0.1, 0.4), outer=random.uniform(0.5, 0.8), c_res=40).triangulate(),
            lambda: pv.ParametricTorus(crosssectionradius=random.uniform(0.05, 0.2), u_res=40, v_res=20).scale(0.5),
            lambda: pv.Cone(radius=random.uniform(0.2, 0.5), resolution=int(random.integers(3, 40))),
            lambda: pv.Plane(i_size=random.uniform(0.2, 1), j_size=random.uniform(0.2, 1)),
        ]
        made = kinds[random.integers(len(kinds))]()
        return made.rotate_vector(random.normal(size=3), random.uniform(0, 360)).translate(center)

    def light():
        diffuse, place = random.uniform(0.3, 1.0), tuple(random.uniform((-1, -1, 2.2), (1, 1, 4)).tolist())
        down = (*random.uniform(-0.6, 0.6, 2).tolist(), -1.0)
        kinds = [
            ph.DirectionalLight(down, diffuse=diffuse),
            ph.PointLight(place, diffuse=diffuse),
            ph.SpotLight(place, direction=down, cone_angle=random.uniform(10, 35), diffuse=diffuse),
        ]
        return kinds[random.integers(len(kinds))]

    occluders = [thing() for _ in range(random.integers(1, 4))]
    return floor(int(random.integers(5, 31))), occluders, scene(*[light() for _ in range(random.integers(1, 4))])


@pytest.mark.parametrize("count", [pytest.param(4, id="few"), pytest.param(200, id="many", marks=pytest.mark.long)])
def test_in_any_scene_points_are_paired_no_triangle_is_turned_over_and_colours_hold_but_for_the_strip(count):
    for seed in range(count):
        mesh, occluders, rig = thrown(seed)
        options = {"tolerance": 2 * STEP, "precision": "float64", "max_points": 60_000}
        refined = mesh.phong.refine(rig, MATT, occluders=occluders, **options)
        assert areas(refined).min() > 0.0, seed
        if "phong_refinement_pair" in refined.point_data:
            pair, points = refined["phong_refinement_pair"], refined.points
            np.testing.assert_array_equal(points[pair[pair >= 0]], points[pair >= 0], f"seed {seed}")
        some = np.random.default_rng(1).choice(refined.n_cells, min(2000, refined.n_cells), replace=False)
        part = pv.PolyData.from_regular_faces(refined.points, refined.regular_faces[some])
        part["phong"] = refined["phong"]
        wrong = looked_at(part, mesh, occluders, rig).sum() * refined.n_cells / len(some)
        assert wrong <= reported(refined, "strip"), seed


def test_without_cuts_it_stops_at_the_jump():
    refined = floor(6).phong.refine(scene(SUN), MATT, tolerance=STEP, occluders=[BALL], cut=False, max_points=30_000)
    assert refined.field_data["phong_refinement_stopped"] == "jump"
    assert reported(refined, "cut") == 0
    assert "phong_refinement_pair" not in refined.point_data
    assert wrong_area(refined, behind_ball(SUN)) < 0.02


def test_the_saw_is_an_error_inside_of_triangles():
    ground, rig = floor(9), scene(SUN)
    errors = ground.phong.interpolation_error(rig, MATT, occluders=[BALL])["phong_interpolation_error"]
    centers = ground.cell_centers().points
    middle = CENTER - CENTER[2] * -np.array(SUN.direction)
    far = np.abs(np.linalg.norm(centers[:, :2] - middle[:2], axis=1) - 0.5) > 0.5
    assert errors.max() > 0.7
    assert errors[far].max() < 1e-6
    assert (errors > 0.1).sum() > 8


def test_what_is_seen_is_kept_for_other_colours_of_the_lights():
    """Both sides of a cut keep their colours when lit again, although they coincide."""
    rig, given = scene(SUN, LAMP), {"tolerance": STEP, "occluders": [BALL]}
    refined = floor(9).phong.refine(rig, MATT, **given)
    rows = [refined[f"phong_visibility_{name}"] for name in ("sun", "lamp")]
    seen = np.stack([*rows, np.ones(refined.n_points)])
    again = refined.phong.shade(rig, MATT, visibility=seen)
    np.testing.assert_allclose(again["phong"], refined["phong"], atol=1e-6)
    both = refined["phong_refinement_pair"] >= 0
    assert both.sum() > 50
    other = refined["phong_refinement_pair"][both]
    assert all(((row[both] != row[other]).sum() > 20) & np.isin(row, (0, 1)).all() for row in rows)
    evening = replace(rig, lights=[replace(SUN, diffuse="red"), LAMP])
    again = refined.phong.shade(evening, MATT, visibility=seen)["phong"]
    np.testing.assert_allclose(again[:, 0], refined["phong"][:, 0], atol=1e-6)
    is_dark = rows[0] == 0
    np.testing.assert_allclose(again[is_dark], refined["phong"][is_dark], atol=1e-6)
    assert (again[~is_dark, 1] < refined["phong"][~is_dark, 1] - 0.05).all()


# --- sampled shadows

SCREEN = pv.PolyData(np.array([(0.05, -9, 1), (9, -9, 1), (9, 9, 1), (0.05, 9, 1.0)]), [4, 0, 1, 2, 3])
GLOW = ph.SphereLight(position=(0, 0, 2), radius=0.3, intensity=4, name="glow")


def test_penumbrae_are_split_until_they_are_smooth():
    ground = floor(3, size=3.0)
    refined = ground.phong.refine(scene(GLOW), MATT, tolerance=0.06, occluders=[SCREEN])
    assert refined.field_data["phong_refinement_reached"][0]
    assert reported(refined, "cut") == 0
    assert refined.n_points > 30
    places, colors = samples(refined, count=4)
    cloud = pv.PolyData(places.reshape(-1, 3))
    cloud.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (cloud.n_points, 1))
    truth = cloud.phong.shade(scene(GLOW), MATT, occluders=[SCREEN], tolerance=STEP)["phong"]
    assert np.quantile(np.abs(truth - colors.reshape(-1, 3)).max(axis=1), 0.99) < 0.06 * 1.75  # includes noise
    before = ground.phong.interpolation_error(scene(GLOW), MATT, occluders=[SCREEN])["phong_interpolation_error"]
    assert before.max() > 0.1


def part_beside_screen(places, count=96):
    """Return the fraction of the sphere light's irradiance at places on the floor that passes the screen."""
    to_ball = np.array(GLOW.position) - places
    distance = np.linalg.norm(to_ball, axis=1, keepdims=True)
    axis = to_ball / distance
    across = np.cross(axis, (0.0, 1.0, 0.0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other, least = np.cross(axis, across), np.sqrt(1.0 - (GLOW.radius / distance) ** 2)
    sent = passed = 0.0
    for u in (np.arange(count) + 0.5) / count:
        cosine = 1.0 - u * (1.0 - least)
        sine = np.sqrt(1.0 - cosine**2)
        for turn in (np.arange(count) + u) * (2.0 * math.pi / count):
            ray = cosine * axis + sine * (math.cos(turn) * across + math.sin(turn) * other)
            weight = np.maximum(ray[:, 2], 0.0)
            at_screen = places[:, 0] + ray[:, 0] / ray[:, 2]
            sent, passed = sent + weight, passed + weight * (at_screen < 0.05)
    return passed / sent


@pytest.mark.parametrize("steps", [4, 1])
def test_the_edge_of_a_penumbra_is_not_split_for_rays_that_missed_its_last_part(steps):
    """64 rays may agree where one in a hundred would differ; this once caused endless splitting."""
    ground, tolerance = floor(24, size=3.0), steps * STEP
    refined = ground.phong.refine(scene(GLOW), MATT, tolerance=tolerance, occluders=[SCREEN])
    assert refined.field_data["phong_refinement_reached"][0]
    assert refined.n_points < 1.5 * ground.n_points
    places, colors = (rows.reshape(-1, 3) for rows in samples(refined, count=3))
    free, dark = (
        ph.evaluate(places, np.tile((0.0, 0.0, 1.0), (len(places), 1)), rig, MATT, precision="float64").rgb
        for rig in (scene(GLOW, shadows=False, clamp=False), scene())
    )
    truth = np.clip(dark + part_beside_screen(places)[:, None] * (free - dark), 0.0, 1.0)
    off = np.abs(truth - colors).max(axis=1)
    # in addition to the tolerance, noise may hide three standard errors at a place and at the corners
    assert np.quantile(off, 0.99) < 2.5 * tolerance
    assert off.max() < 3.5 * tolerance


def test_places_are_looked_at_once_and_corners_not_again(monkeypatch):
    ground, asked, look = floor(12, size=3.0), [], visibility.look
    monkeypatch.setattr(
        visibility, "look", lambda count, *how, **more: asked.append(count) or look(count, *how, **more)
    )
    refined = ground.phong.refine(scene(GLOW), MATT, tolerance=0.06, occluders=[SCREEN])
    assert refined.n_points == ground.n_points
    sides = ground.extract_all_edges().n_cells
    least = ground.n_points + 4 * ground.n_cells + 3 * sides  # places inside triangles and on their sides
    assert least <= sum(asked) < least + ground.n_cells  # with peaks


def test_where_light_jumps_at_a_side_each_triangle_beside_it_has_its_own_error():
    """The box stands on sides of the floor's triangles: under it nothing is lit, beside it the glow is half visible."""
    ground, tower = floor(12, size=3.0), box((-0.5, -0.5, 0.0), (0.25, 0.5, 0.6))
    how = {"occluders": [tower]}
    refined = ground.phong.refine(scene(GLOW), MATT, tolerance=STEP, max_points=ground.n_points, **how)
    expected = ground.phong.interpolation_error(scene(GLOW), MATT, **how)["phong_interpolation_error"]
    found = refined.cell_data["phong_interpolation_error"]
    is_large = expected > 2 * STEP
    assert 20 < is_large.sum() < ground.n_cells - 20
    np.testing.assert_allclose(found[is_large], expected[is_large], atol=2 * STEP)  # noise
    assert (found[~is_large] < 4 * STEP).all()


@pytest.mark.parametrize("model", [{}, {"ambient_occlusion": True}])
def test_noise_is_not_split(model):
    """The small floor lies in the middle of a penumbra, or sees half of the sky."""
    ground = floor(4, size=0.01)
    refined = ground.phong.refine(scene(GLOW, **model), MATT, tolerance=4 * STEP, occluders=[SCREEN])
    assert refined.n_points == ground.n_points
    assert reported(refined, "error") < 4 * STEP


# --- invariants


def test_scenes_without_jumps_get_the_same_bits():
    ball = pv.Sphere()
    wide = ph.SpotLight(position=(0, 0, 2), direction=(0, 0, -1), cone_angle=60)
    for rig in (scene(LAMP), scene(wide, shadows=False), scene(LAMP, wide)):
        plain = replace(rig, light_model=rig.light_model.without_rays())
        refined, expected = (ball.phong.refine(each, MATT, tolerance=STEP, cut=each is rig) for each in (rig, plain))
        assert refined["phong"].tobytes() == expected["phong"].tobytes()
        assert refined.points.tobytes() == expected.points.tobytes()
        assert reported(refined, "cut") == 0


def test_no_more_points_than_allowed_and_no_cut_that_is_no_flag():
    ground, rig = floor(20), scene(SUN, LAMP)
    with pytest.raises(ValueError, match="cut must be True or False; got 5"):
        ground.phong.refine(rig, MATT, tolerance=STEP, cut=5)
    for limit in (441, 500, 800):
        refined = ground.phong.refine(rig, MATT, tolerance=STEP, occluders=[BALL], max_points=limit)
        assert refined.n_points <= limit
        assert areas(refined).min() > 0
        assert refined.field_data["phong_refinement_stopped"] == "max_points"
        assert reported(refined, "cut") >= (0 if limit < 500 else 5)


def test_blocks_shadow_each_other():
    ball = pv.Icosphere(radius=RADIUS, center=CENTER, nsub=2)
    blocks = pv.MultiBlock({"floor": floor(9), "ball": ball})
    refined = blocks.phong.refine(scene(SUN), MATT, tolerance=STEP)["floor"]
    alone = blocks["floor"].phong.refine(scene(SUN), MATT, tolerance=STEP, occluders=[ball])
    np.testing.assert_array_equal(refined["phong"], alone["phong"])
    errors = blocks.phong.interpolation_error(scene(SUN), MATT)["floor"]["phong_interpolation_error"]
    assert errors.max() > 0.5


def test_light_that_bounces_is_interpolated_between_the_vertices_and_changes_no_triangle():
    """The floor has coloured emission and receives light from a ball."""
    ball = pv.Icosphere(radius=RADIUS, center=CENTER, nsub=2)
    ground, several = floor(9), {"shadows": True, "clamp": False, "ambient": 0.5}
    ground["glow"] = np.random.default_rng(1).random((ground.n_points, 3))
    colored = replace(MATT, diffuse=(0.9, 0.5, 0.2), emission="glow", ambient=0.4)
    blocks, materials = pv.MultiBlock({"floor": ground, "ball": ball}), {"floor": colored, "ball": MATT}
    rig, options = scene(SUN, LAMP, bounces=3, **several), {"tolerance": STEP, "precision": "float64"}
    lit = blocks.phong.shade(rig, materials, components=True, precision="float64")["floor"]
    found = blocks.phong.refine(rig, materials, **options)["floor"]
    np.testing.assert_allclose(found["phong"][: ground.n_points], lit["phong"], atol=1e-7)
    ground["bounced"] = lit["phong_bounced"]
    dark = scene(SUN, LAMP, **several | {"ambient": 0.0})
    direct = ground.phong.refine(dark, colored, occluders=[ball], **options)
    assert direct["bounced"].max() > 0.02
    np.testing.assert_array_equal(found.points, direct.points)
    np.testing.assert_allclose(found["phong"], direct["phong"] + direct["bounced"], atol=1e-7)
    meshes = [blocks.phong.interpolation_error(given, materials)["floor"] for given in (rig, dark)]
    errors = [mesh["phong_interpolation_error"] for mesh in meshes]  # the sampled places differ in some triangles
    assert np.quantile(np.abs(errors[0] - errors[1]), 0.9) < 1e-7


@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")  # the normals still point outwards
def test_a_bowl_lights_itself_by_a_transport_that_is_given_or_is_not():
    bowl = pv.Sphere(end_phi=90, theta_resolution=12, phi_resolution=6).flip_faces()
    bowl = bowl.compute_normals(auto_orient_normals=False, consistent_normals=False)
    rig, transport = scene(LAMP, bounces=2, shadows=False), bowl.phong.transport()
    refined = bowl.phong.refine(rig, MATT, tolerance=STEP, transport=transport)
    np.testing.assert_array_equal(refined["phong"], bowl.phong.refine(rig, MATT, tolerance=STEP)["phong"])
    lit = bowl.phong.shade(rig, MATT, transport=transport)["phong"]
    np.testing.assert_allclose(refined["phong"][: bowl.n_points], lit, atol=1e-6)
    assert np.abs(lit - bowl.phong.shade(scene(LAMP, shadows=False), MATT)["phong"]).max() > 5 * STEP
    with pytest.raises(ValueError, match="transport must be"):
        BALL.phong.refine(rig, MATT, tolerance=STEP, transport=transport)


def test_a_block_that_sees_nothing_reflects_no_light_that_bounces():
    ball = pv.Icosphere(nsub=2)
    ball["phong_bounced"] = np.ones((ball.n_points, 3))  # left from an earlier shading
    rig = scene(LAMP, bounces=2, shadows=False)
    (refined,) = pv.MultiBlock([ball]).phong.refine(rig, MATT, tolerance=0.05)
    np.testing.assert_array_equal(refined["phong"], ball.phong.refine(rig, MATT, tolerance=0.05)["phong"])
    np.testing.assert_allclose(refined["phong"][: ball.n_points], ball.phong.shade(rig, MATT)["phong"], atol=1e-6)


def test_its_progress_is_told_and_it_is_the_same_whatever_the_threads():
    ground, heard = floor(12, size=3.0), []

    def refined():
        return ground.phong.refine(scene(GLOW), MATT, tolerance=2 * STEP, occluders=[SCREEN])

    with listening(lambda *told: heard.append(told)):
        found = refined()
    with threads.limited(1):
        assert refined() == found
    parts = [part for _, part in heard]
    assert {what for what, _ in heard} == {"refining"}
    assert (min(parts), max(parts)) == (0.0, 1.0)
    assert len(set(parts)) > 10
