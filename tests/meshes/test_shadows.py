"""Shadows of meshes, in scenes with known shadows and in difficult ones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from ray_backends import BACKENDS, FASTEST

import pvphong as ph
from pvphong.base import threads
from pvphong.base.text import listening
from pvphong.meshes.visibility import triangles_of
from pvphong.rays import casting, sampling, visibility

SUN = ph.DirectionalLight(direction=(0, 0, -1), name="sun")
LAMP = ph.PointLight(position=(0, 0, 4), name="lamp")
BALL = ph.SphereLight(position=(0, 0, 4), radius=0.5, intensity=16, name="ball")
WHITE = ph.Material(ambient=1.0, diffuse=1.0)
MODEL = ph.LightModel(shadows=True, ambient_occlusion=True)


def floor(size=4.0, cells=40, **options):
    return pv.Plane(i_size=size, j_size=size, i_resolution=cells, j_resolution=cells, **options)


def disk(height, radius=1.0, sides=200):
    around = 2 * np.pi * np.arange(sides) / sides
    points = np.column_stack([radius * np.cos(around), radius * np.sin(around), np.full(sides, height)])
    return pv.PolyData(points, [sides, *range(sides)])


NOWHERE = pv.PolyData(np.full((3, 3), np.nan), [3, 0, 1, 2])


def patch(*points, normal=(0.0, 0.0, 1.0)):
    """Return points with a common normal and no faces."""
    cloud = pv.PolyData(np.array(points, float))
    cloud.point_data.active_normals = np.tile(normal, (len(points), 1))
    return cloud


def scene(*lights, **model):
    return ph.Scene(lights, ph.Viewer(position=(0, -5, 5)), replace(MODEL, **model))


@pytest.fixture(params=BACKENDS)
def backend(request, monkeypatch):
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[request.param], ""))
    return request.param


# --- known shadows


@pytest.mark.usefixtures("backend")
@pytest.mark.parametrize(("light", "edge"), [(SUN, 1.0), (LAMP, 2.0), (replace(LAMP, position=(0, 0, 3)), 3.0)])
def test_a_disk_casts_a_round_shadow(light, edge):
    """The disk is at height 2; a lamp at height h casts its edge to h / (h − 2)."""
    ground = floor(size=8.0)
    seen = ground.phong.visibility([light], occluders=[disk(2.0)])
    distance = np.hypot(*ground.points[:, :2].T)
    clear = np.abs(distance - edge) > 0.01
    np.testing.assert_array_equal(seen.per_light[0][clear], distance[clear] > edge)
    assert seen.per_light.dtype == np.float32
    assert seen.rays == ground.n_points
    assert not seen.standard_error.per_light.any()


def test_a_corner_sees_what_is_seen_from_there():
    """Rays of a corner start only slightly inside its face."""
    hat = disk(2.0, radius=0.02).translate((2, 2, 0))
    seen = floor(cells=1).phong.visibility([SUN], occluders=[hat]).per_light[0]
    np.testing.assert_array_equal(seen, [1, 1, 1, 0])


def test_lights_at_one_place_cast_one_shadow():
    """The lights are a point, a spot, a light that moves with the viewer, and a very small one."""
    ground = floor()
    spot = ph.SpotLight(position=LAMP.position, cone_angle=60)
    head = ph.PointLight(frame="headlight")
    rig = ph.Scene([LAMP, spot, head, replace(BALL, radius=1e-9)], ph.Viewer(position=LAMP.position), MODEL)
    lamp, *others = ground.phong.visibility(rig, occluders=[disk(2.0)]).per_light
    for other in others:
        np.testing.assert_array_equal(other, lamp)


@pytest.mark.parametrize("height", [0.5, 1.0, 3.0])
def test_a_wall_hides_the_part_of_the_sky_that_is_known(height):
    """The wall hides ½ (1 − 1/√(1 + k²)) of the sky, with k the wall's height over the distance."""
    distances = np.array([0.25, 0.5, 1.0, 2.0, 4.0])
    wall = pv.Box((0, 0, -100, 100, 0, height))
    seen = patch(*[(x, 0, 0) for x in distances]).phong.visibility([], occluders=[wall], samples=4096)
    exact = 1 - (1 - 1 / np.sqrt(1 + (height / distances) ** 2)) / 2
    assert (np.abs(seen.sky - exact) < 3 * seen.standard_error.sky + 1e-3).all()


def test_a_ball_hides_the_part_of_the_sky_that_is_known():
    """A ball above the point hides sin² of its angular radius."""
    for distance, normal in ((3.0, (0.48, 0.6, 0.64)), (1.5, (-0.36, 0.8, -0.48))):
        center = distance * np.array(normal)
        ball = pv.Sphere(radius=1.0, center=center, theta_resolution=200, phi_resolution=200)
        seen = patch((0, 0, 0), normal=normal).phong.visibility([], occluders=[ball], samples=4096)
        assert abs(seen.sky[0] - (1 - 1 / distance**2)) < 3 * seen.standard_error.sky[0] + 1e-3


def test_what_is_further_away_than_the_length_hides_no_sky():
    ground, near = floor(), scene(ambient_occlusion=1.9)
    assert (ground.phong.visibility(near, occluders=[disk(2.0)]).sky == 1.0).all()
    assert ground.phong.visibility(scene(ambient_occlusion=2.5), occluders=[disk(2.0)]).sky.min() < 0.9
    assert ground.phong.plan(near, WHITE, occluders=[disk(2.0)]).effects["occlusion"].on  # the floor may occlude itself


@pytest.mark.parametrize("offset", [-0.4, -0.2, 0.0, 0.1, 0.3])
def test_a_half_plane_hides_a_part_of_a_ball_by_its_area(offset):
    """The half-plane is half way up, so its edge cuts the visible disk at twice the offset, in units of its radius."""
    ball, x = replace(BALL, radius=0.05), offset
    edge = x * ball.radius / 2
    screen = pv.PolyData(np.array([[edge, -9, 2], [9, -9, 2], [9, 9, 2], [edge, 9, 2.0]]), [4, 0, 1, 2, 3])
    exact = (x * math.sqrt(1 - x * x) + math.asin(x)) / math.pi + 0.5
    seen = patch((0, 0, 0)).phong.visibility([ball], occluders=[screen])
    assert abs(seen.per_light[0, 0] - exact) < max(3 * seen.standard_error.per_light[0, 0], 1 / 255)


def test_umbra_and_penumbra_of_a_ball_before_a_ball():
    """A ball of radius ¾ is half way to one of radius 1 at distance 8: the umbra ends near ½, the penumbra near 2½."""
    light = ph.SphereLight(position=(0, 0, 8), radius=1.0, intensity=64)
    blocker = pv.Sphere(radius=0.75, center=(0, 0, 4), theta_resolution=120, phi_resolution=120)
    ground = floor(size=8.0, cells=64)
    visibility = ground.phong.visibility([light], occluders=[blocker])
    (seen,), (error,) = visibility.per_light, visibility.standard_error.per_light
    distance = np.hypot(*ground.points[:, :2].T)
    assert (seen[distance < 0.4] == 0.0).all()
    assert (seen[distance > 2.9] == 1.0).all()
    assert not error[(distance < 0.4) | (distance > 2.9)].any()
    between = seen[(distance > 0.8) & (distance < 2.2)]
    assert ((between > 0.0) & (between < 1.0)).all()
    rings = [seen[np.abs(distance - r) < 0.1].mean() for r in np.arange(0.6, 2.5, 0.2)]
    assert (np.diff(rings) > 0).all()


# --- sampling


def soft():
    return floor(cells=24), scene(BALL, ambient=0.0), {"occluders": [disk(2.0)]}


def test_equal_calls_give_equal_bits_whatever_the_chunks_and_threads(monkeypatch):
    ground, rig, blockers = soft()
    usual = ground.phong.visibility(rig, **blockers)
    with threads.limited(1):
        monkeypatch.setattr(casting.Occluders, "rays_at_once", 1000)
        other = ground.phong.visibility(rig, **blockers)
        np.testing.assert_array_equal(other.channels([0], sky=True), usual.channels([0], sky=True))
    np.testing.assert_array_equal(other.standard_error.per_light, usual.standard_error.per_light)


def test_its_standard_error_is_honest():
    """It equals the average error over many vertices with the same visibility, where a screen hides a third."""
    screen = pv.PolyData(np.array([[0.02, -99, 2], [99, -99, 2], [99, 99, 2], [0.02, 99, 2.0]]), [4, 0, 1, 2, 3])
    screen = screen.rotate_z(28)  # an edge along an axis has smaller errors than stated
    same = patch(*[(0, 0, 0)] * 400)
    whole = same.phong.visibility([BALL], occluders=[screen], samples=4096)
    for count in (16, 64, 256):
        seen = same.phong.visibility([BALL], occluders=[screen], samples=count)
        for what in ("per_light", "sky"):
            off = np.ravel(getattr(seen, what)) - np.ravel(getattr(whole, what)).mean()
            stated = np.ravel(getattr(seen.standard_error, what))
            assert abs(off.mean()) < 4 * stated.mean() / np.sqrt(len(off))
            assert 0.4 < np.sqrt((off**2).mean() / (stated**2).mean()) < 1.1
            assert np.mean(np.abs(off) < 3 * stated) > 0.9
            scores = np.abs(off) / np.sqrt((stated**2).mean())
            assert (np.quantile(scores, [0.68, 0.95]) < [1.2, 2.2]).all()  # normal distribution, or narrower


@pytest.mark.skipif(FASTEST == "vtk", reason="too many rays for VTK")
@pytest.mark.parametrize("load", [examples.load_ant, examples.load_airplane])
def test_the_tolerance_is_kept_on_meshes_of_others(load):
    """The colours of a white surface are compared with those of all 4096 rays, at some of the vertices."""
    mesh = load()
    ball = ph.SphereLight(mesh.center + 0.7 * mesh.length * np.array([1, -1, 2.0]), radius=mesh.length / 8)
    rig = scene(replace(ball, intensity=2.0 * mesh.length**2), ambient=0.3, clamp=False)
    seen = mesh.phong.visibility(rig)
    rows = np.random.default_rng(2).choice(mesh.n_points, 120, replace=False)
    truth = seen.afresh(samples=4096, rows=rows)
    points, normals = mesh.points[rows], mesh.phong.normals()[rows]
    off = mesh.phong.shade(rig, WHITE, visibility=seen)["phong"][rows]
    off = off - ph.evaluate(points, normals, rig, WHITE, visibility=truth).rgb
    assert np.sqrt(np.mean(off**2)) < 1 / 255
    assert np.abs(off).max() < 5 / 255


def test_long_work_is_told_and_interrupted_work_leaves_nothing(monkeypatch):
    ground, rig, blockers = soft()
    seen, heard = ground.phong.visibility(rig, **blockers), []

    def interrupt(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(sampling, "_estimate", interrupt)
        with pytest.raises(KeyboardInterrupt):
            seen.sky  # noqa: B018
    assert (seen.rays, seen.seconds) == (0, 0.0)
    with listening(lambda *told: heard.append(told)):
        again = seen.sky
    np.testing.assert_array_equal(again, ground.phong.visibility(rig, **blockers).sky)
    assert heard[-1] == ("rays to the sky", 1.0)


# --- shading with it


def test_shade_multiplies_and_keeps_the_arrays():
    ground, rig = floor(), scene(SUN, LAMP)
    lit = ground.phong.shade(rig, WHITE, occluders=[disk(2.0)], components=True)
    free = ground.phong.shade(scene(SUN, LAMP, shadows=False, ambient_occlusion=False), WHITE, components=True)
    for name in ("sun", "lamp"):
        expected = free[f"phong_light_{name}"] * lit[f"phong_visibility_{name}"][:, None]
        np.testing.assert_allclose(lit[f"phong_light_{name}"], expected, atol=1e-6)
    np.testing.assert_allclose(lit["phong_base"], free["phong_base"] * lit["phong_sky"][:, None], atol=1e-6)
    assert not [name for name in free.array_names if "visib" in name or "sky" in name]
    assert 0 < np.count_nonzero(lit["phong_visibility_sun"] == 0) < ground.n_points


def test_what_was_seen_is_used_again():
    ground, rig, blockers = soft()
    seen = ground.phong.visibility(rig, **blockers)
    expected = ground.phong.shade(rig, WHITE, **blockers)["phong"]
    rays = seen.rays
    np.testing.assert_array_equal(ground.phong.shade(rig, WHITE, visibility=seen)["phong"], expected)
    again = seen.rays
    red = replace(rig, lights=[replace(BALL, diffuse=(1, 0, 0), intensity=3)])
    assert not ground.phong.shade(red, WHITE, visibility=seen)["phong"][:, 1].any() or rig.light_model.ambient
    assert seen.rays == again > rays
    points = ph.evaluate(ground.points, ground.phong.normals(), rig, WHITE, visibility=seen).rgb
    np.testing.assert_array_equal(points, expected)


def test_of_another_mesh_or_other_lights_it_is_refused():
    ground, rig = floor(cells=10), scene(SUN, LAMP)
    seen = ground.phong.visibility(rig)
    moved = ground.translate((1, 0, 0))
    rest = [SUN, replace(LAMP, position=(0, 1, 4))]
    twice = {"matrix": np.diag([2.0, 1, 1, 1])}
    for mesh, other, options, says in (
        (floor(cells=9), rig, {}, "computed for the mesh's 100 points"),
        (moved, rig, {}, "computed for the mesh's current points"),
        (ground, rig, twice, "computed for the mesh's current points"),
        (ground, scene(SUN), {}, "computed for the lights .*sun"),
        (ground, scene(SUN, replace(LAMP, name="bulb")), {}, "computed for the lights .*bulb"),
        (ground, scene(*rest), {}, "computed for the current lights; got one from before lamp moved"),
        (ground, scene(*rig.lights, two_sided=True), {}, "computed for a two-sided light model"),
        (ground, scene(*rig.lights, ambient_occlusion=1.0), {}, "computed .* up to 1; got one with .* up to inf"),
        (ground, rig, {"visibility": np.ones((2, 121))}, r"the result of mesh\.phong\.visibility"),
    ):
        with pytest.raises(ValueError, match=f"visibility must be {says}"):
            mesh.phong.shade(other, WHITE, **{"visibility": seen} | options)


@pytest.mark.parametrize(
    "given", ["mesh", 3, floor(), [3], ["a"], [(floor(), 3)], [(floor(), np.zeros((4, 4)) * np.nan)], iter([floor()])]
)
def test_occluders_of_wrong_types_are_refused(given):
    with pytest.raises(ValueError, match=r"^occluders"):
        floor().phong.shade(scene(SUN), WHITE, occluders=given)


@pytest.mark.parametrize("strips", [False, True])
def test_hidden_cells_block_nothing(strips):
    """VTK's ghost array marks hidden cells, like blanked cells of a grid; other ghost cells block light."""
    roof = floor(size=2.0, cells=4).translate((0, 0, 1)).triangulate()
    roof.clear_data()
    roof = roof.strip() if strips else roof
    assert bool(roof.n_strips) is strips
    roof.cell_data["vtkGhostType"] = kinds = np.resize(np.array([0, 32, 1], np.uint8), roof.n_cells)
    lengths = [roof.get_cell(k).n_points - 2 for k in range(roof.n_cells)]
    faces = np.repeat(kinds, lengths)
    shown = pv.PolyData.from_regular_faces(roof.points, triangles_of(without_marks(roof))[faces != 32])
    ground = floor(size=1.9, cells=17)
    expected = ground.phong.visibility([SUN], occluders=[shown]).per_light
    assert 0 < expected.mean() < 1
    np.testing.assert_array_equal(ground.phong.visibility([SUN], occluders=[roof]).per_light, expected)


def without_marks(mesh):
    result = mesh.copy()
    result.clear_cell_data()
    return result


def test_memory_is_said_before_any_ray(monkeypatch):
    monkeypatch.setattr(visibility, "_MANY", 100)
    seen = floor(cells=8).phong.visibility(scene(SUN))
    assert "128 occluding triangles take about 1.7e-05 GB" in repr(seen)
    assert seen.rays == 0


def test_matrices_move_meshes_and_occluders():
    ground, rig = floor(), scene(SUN, LAMP)
    expected = ground.phong.visibility(rig, occluders=[disk(2.0)])
    lower, mirrored = np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0])
    lower[2, 3] = -1.0
    same = (
        ground.translate((0, 0, 1)).phong.visibility(rig, matrix=lower, occluders=[(disk(3.0), lower)]),
        ground.phong.visibility(rig, occluders=[(disk(-2.0), mirrored)]),
        ground.phong.visibility(rig, occluders=[pv.MultiBlock([None, pv.PolyData(), disk(2.0)])]),
    )
    for other in same:
        np.testing.assert_array_equal(other.per_light, expected.per_light)
        np.testing.assert_array_equal(other.sky, expected.sky)


# --- plans


def plan_of(mesh, *lights, occluders=(), **model):
    return mesh.phong.plan(scene(*lights, **model), WHITE, occluders=occluders)


def test_plans_leave_out_what_nothing_can_block_without_a_ray():
    ball = pv.Sphere()
    assert plan_of(ball, SUN, LAMP).effects["shadow"].why == "sun, lamp: the mesh is convex, and alone"
    assert plan_of(ball, SUN).effects["occlusion"].why == "the mesh is convex, and alone"
    seen = floor().phong.visibility(scene(SUN))
    assert floor().phong.plan(scene(SUN), WHITE, visibility=seen).effects["shadow"].on
    assert seen.rays == 0  # a plan casts no rays
    above, below = disk(4.0), disk(-4.0)
    behind = plan_of(ball, SUN, LAMP, occluders=[below])
    assert behind.effects["shadow"].why == "sun, lamp: nothing stands between, and the mesh is convex"
    assert behind.effects["occlusion"].on
    some = plan_of(ball, SUN, replace(LAMP, position=(9, 0, 0)), occluders=[above]).effects["shadow"]
    assert some.on
    assert some.why == "sun (left out: lamp: nothing stands between, and the mesh is convex)"
    assert plan_of(patch((0, 0, 0)), SUN, occluders=[below]).effects["shadow"].why == "sun: nothing stands between"
    for mesh, model in ((pv.ParametricTorus(), {}), (ball, {"two_sided": True}), (floor(), {})):
        assert plan_of(mesh, SUN, **model).effects["shadow"].on


def test_what_nothing_can_block_is_seen_by_all():
    random, clear = np.random.default_rng(3), 0
    for _ in range(150):
        position = random.normal(size=3) + np.array([0, 0, 3])
        lights = [
            ph.DirectionalLight(direction=-position),
            ph.PointLight(position),
            ph.SphereLight(position, radius=random.uniform(0.1, 0.9)),
        ]
        hat = disk(0.0, radius=random.uniform(0.1, 0.7), sides=12).translate(
            random.normal(size=3) + np.array([0, 0, 1.5])
        )
        seen = patch((0, 0, 0), (0.3, 0, 0)).phong.visibility(lights, occluders=[hat], samples=16)
        for index, parts in enumerate(seen.per_light):
            if seen.why_clear(index):
                clear += 1
                assert (parts == 1.0).all(), lights[index]
    assert 350 < clear < 430


# --- difficult scenes


def spoiled(mesh):
    mesh = mesh.triangulate()
    points, faces = mesh.points.copy(), mesh.faces.copy()
    points[3], points[50] = np.nan, (np.inf, 0, 0)
    faces[1:4] = faces[1]
    return pv.PolyData(points, faces)


@pytest.mark.usefixtures("backend")
def test_spoiled_faces_and_points_harm_no_other_vertex():
    ground, rig, hat = floor(cells=12), scene(SUN, BALL), disk(2.0, radius=0.9)
    broken, faces = spoiled(ground), ground.triangulate().regular_faces
    lost = np.concatenate([faces[0], faces[np.isin(faces, [3, 50]).any(axis=1)].ravel()])
    seen = broken.phong.visibility(rig, occluders=[hat, spoiled(floor(center=(0, 0, -3)))])
    for part in (*seen.per_light, seen.sky):
        assert ((part >= 0) & (part <= 1)).all()
    sound = np.setdiff1d(np.arange(ground.n_points), lost)
    expected = ground.triangulate().phong.visibility(rig, occluders=[hat])
    np.testing.assert_array_equal(seen.per_light[0][sound], expected.per_light[0][sound])
    assert np.isfinite(broken.phong.shade(rig, WHITE, occluders=[hat])["phong"]).all()


@pytest.mark.parametrize(
    "nothing", [pv.PolyData(), pv.PolyData([(0, 0, 2.0)]), pv.Line(), pv.MultiBlock(), pv.UnstructuredGrid(), NOWHERE]
)
def test_what_has_no_faces_blocks_nothing(nothing):
    ground = floor(cells=4)
    assert ground.phong.visibility([SUN], occluders=[nothing]).per_light.all()


@pytest.mark.usefixtures("backend")
def test_touching_coplanar_and_thin_meshes():
    """A cube stands on the floor, which is dark below it and lit next to it; all its sides towards the sun are lit."""
    assert not floor().phong.visibility([SUN, LAMP], occluders=[floor(center=(0, 0, 1e-3))]).per_light.any()
    ground, cube = floor(cells=36), pv.Cube(center=(0, 0, 0.5), clean=False)
    seen = ground.phong.visibility([SUN], occluders=[cube]).per_light[0]
    inside = (np.abs(ground.points[:, :2]) < 0.49).all(axis=1)
    outside = (np.abs(ground.points[:, :2]) > 0.51).any(axis=1)
    assert not seen[inside].any()
    assert seen[outside].all()
    slanted = ph.DirectionalLight(direction=(-1, -2, -3))
    lit = cube.phong.visibility([slanted], occluders=[ground]).per_light[0]
    np.testing.assert_array_equal(lit, cube.phong.normals() @ (1, 2, 3) > 0)


@pytest.mark.usefixtures("backend")
def test_a_closed_room_has_no_leaks():
    """This includes its edges, where vertices of the floor are in the plane of the walls."""
    room = pv.Box(bounds=(-1, 1, -1, 1, 0, 2), level=6).flip_faces()
    for angle in (None, 30):
        seen = room.phong.visibility([SUN, ph.DirectionalLight(direction=(1, 2, -3)), LAMP], feature_angle=angle)
        assert not seen.per_light.any()
        assert not seen.sky.any()
        inside = room.phong.visibility([ph.PointLight(position=(0.1, 0.2, 1.1))], feature_angle=angle)
        assert inside.per_light.all()


def test_lights_at_awkward_places():
    ball = pv.Sphere(radius=1.0)
    on, inside = ph.PointLight(tuple(map(float, ball.points[10]))), ph.PointLight((0, 0, 0))
    within = ph.SphereLight((0, 0, 0), radius=3.0)
    ceiling = floor(center=(0, 0, 2))
    assert floor().phong.visibility([replace(LAMP, position=(0.1, 0.2, 2))], occluders=[ceiling]).per_light.all()
    seen = pv.merge([ball, floor(center=(0, 0, -2))]).phong.visibility([on, inside, within])
    assert ((seen.per_light >= 0) & (seen.per_light <= 1)).all()
    assert not seen.per_light[1].any()


def test_two_sided_models_look_from_the_side_of_the_light():
    sheet = floor(cells=8)
    below = ph.DirectionalLight(direction=(0, 0, 1))
    assert not sheet.phong.visibility([below]).per_light.any()
    blocked = sheet.phong.visibility(scene(below, SUN, two_sided=True), occluders=[disk(-2.0, radius=9.0)])
    np.testing.assert_array_equal(blocked.per_light.all(axis=1), [False, True])


def test_a_small_mesh_on_a_wide_plain():
    """The plain is a million times as wide; occlusion is resolved as finely as on the small mesh alone."""
    bumpy, sun = pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.4), replace(SUN, direction=(1, 0, -1))
    plain = floor(size=3_000_000.0, cells=1, center=(0, 0, -0.5))
    alone, beside = (bumpy.phong.visibility([sun], occluders=given, samples=16) for given in ([], [plain]))
    np.testing.assert_array_equal(beside.per_light, alone.per_light)
    assert (beside.sky <= alone.sky).all()
    assert (beside.sky < alone.sky).any()


# --- blocks


def blocks():
    return pv.MultiBlock(
        {"ground": floor(), "more": pv.MultiBlock({"hat": disk(2.0)}), "none": None, "empty": pv.PolyData()}
    )


def test_blocks_shadow_each_other():
    rig, colors = scene(SUN, LAMP, BALL), {"ground": WHITE, "default": ph.Material(diffuse=(1, 0, 0))}
    lit = blocks().phong.shade(rig, colors)
    alone = floor().phong.shade(rig, WHITE, occluders=[disk(2.0)])
    np.testing.assert_array_equal(lit["ground"]["phong"], alone["phong"])
    hat = disk(2.0).phong.shade(rig, colors["default"], occluders=[floor()])
    np.testing.assert_array_equal(lit["more"]["hat"]["phong"], hat["phong"])
    assert lit["none"] is None
    more = blocks().phong.shade(rig, colors, occluders=[disk(3.0, radius=2.0)])
    assert more["ground"]["phong"].mean() < lit["ground"]["phong"].mean()


def test_what_blocks_see_is_kept_by_their_names():
    rig = scene(SUN, LAMP)
    seen = blocks().phong.visibility(rig)
    assert list(seen) == ["ground", "more/hat"]
    lit, again = blocks().phong.shade(rig, WHITE), blocks().phong.shade(rig, WHITE, visibility=seen)
    np.testing.assert_array_equal(again["ground"]["phong"], lit["ground"]["phong"])
    plans = blocks().phong.plan(rig, WHITE)
    assert plans["ground"].effects["shadow"].on
    assert blocks().phong.plan(rig, WHITE, visibility=seen)["ground"].effects["shadow"].on
    balls = pv.MultiBlock({"one": pv.Sphere(), "other": pv.Sphere(center=(3, 0, 0))})
    for plan in balls.phong.plan(scene(SUN), WHITE).values():  # each knows its own index
        assert plan.effects["shadow"].why == "sun: nothing stands between, and the mesh is convex"
    with pytest.raises(ValueError, match="visibility must be a mapping with the keys ground, more/hat"):
        blocks().phong.shade(rig, WHITE, visibility=seen["ground"])
