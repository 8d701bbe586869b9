"""Irradiance against closed forms and quadrature: lamps, areas, skies, faces, bounces, blocks."""

import math

import numpy as np
import pytest
import pyvista as pv
from rays.rooms import hollow, room, wall
from scipy.integrate import dblquad

import pvphong as ph

BY_SQUARE = {"attenuation": (0, 0, 1)}
FLOOR = wall((0, 0, 0), (0, 0, 1), size=2.0, cells=4)
POINTS = FLOOR.points.astype(np.float64)


def of(mesh, lights, per="vertex", name="irradiance", **options):
    model = {key: options.pop(key) for key in ("shadows", "two_sided") if key in options}
    scene = ph.Scene(lights, ph.Viewer(position=(0, 0, 9)), ph.LightModel(**model))
    found = mesh.phong.irradiance(scene, per=per, name=name, **options)
    return found.point_data if per == "vertex" else found.cell_data


def level(found, name="irradiance"):
    """Return the red channel, which must equal the others."""
    rows = np.asarray(found[name])
    np.testing.assert_array_equal(rows[:, 1:], rows[:, :2])
    return rows[:, 0]


# --- closed forms: J. R. Howell, "A catalog of radiation heat transfer configuration factors"


def test_the_sun_gives_its_irradiance_times_the_cosine():
    for angle in (0.0, 30.0, 60.0, 89.0, 91.0):
        tilt = math.radians(angle)
        sun = ph.DirectionalLight(direction=(math.sin(tilt), 0, -math.cos(tilt)), intensity=700.0)
        np.testing.assert_allclose(level(of(FLOOR, [sun])), 700.0 * max(math.cos(tilt), 0.0), rtol=1e-6)


def to_corner(a, b, h):
    """Form factor to a parallel rectangle with a corner straight above (B-3)."""
    x, y = a / h, b / h
    p, q = np.hypot(1, x), np.hypot(1, y)
    return (x / p * np.arctan(y / p) + y / q * np.arctan(x / q)) / (2 * math.pi)


def under_rectangle(points):
    corners = [
        (a, b) for a in (0.6 - points[:, 0], 0.6 + points[:, 0]) for b in (0.3 - points[:, 1], 0.3 + points[:, 1])
    ]
    return sum(to_corner(a, b, 1.5) for a, b in corners)


def under_disk(points):
    """Form factor to a parallel disk (B-12)."""
    square = 1.5**2 + points[:, 0] ** 2 + points[:, 1] ** 2
    root = np.sqrt((square + 0.4**2) ** 2 - 4 * (square - 1.5**2) * 0.4**2)
    return 0.5 * (1 - (square - 0.4**2) / root)


def over_squares(points):
    distance = np.linalg.norm(points - (0, 0, 1.5), axis=1)
    return 1.5 / distance**3


AT = {"position": (0, 0, 1.5), "intensity": 1000.0}
LAMPS = {
    "point": (ph.PointLight(**AT, **BY_SQUARE), lambda points: 1000.0 * over_squares(points)),
    "sphere": (ph.SphereLight(**AT, radius=0.2), lambda points: 1000.0 * over_squares(points)),
    "disk": (ph.DiskLight(**AT, radius=0.4), lambda points: 1000.0 / 0.4**2 * under_disk(points)),
    "rectangle": (
        ph.RectangleLight(**AT, up=(0, 1, 0), width=1.2, height=0.6),
        lambda points: 1000.0 * math.pi / 0.72 * under_rectangle(points),
    ),
}
"""A lamp of 1000 candela, and its illuminance in lux: I/d² times the cosine, or π times radiance times form factor."""


@pytest.mark.parametrize("lamp", LAMPS)
def test_lamps_give_lux(lamp):
    light, exact = LAMPS[lamp]
    np.testing.assert_allclose(level(of(FLOOR, [light])), exact(POINTS), rtol=3e-6)


@pytest.mark.parametrize("lamp", LAMPS)
def test_a_face_has_the_mean_over_its_area(lamp):
    light, exact = LAMPS[lamp]
    found = level(of(FLOOR, [light], per="face"))
    assert len(found) == FLOOR.n_cells
    for face in range(0, FLOOR.n_cells, 7):
        a, b, c = FLOOR.get_cell(face).points.astype(np.float64)
        inner = lambda v, u: 2.0 * exact((a + u * (b - a) + v * (c - a))[None])[0]  # noqa: B023, E731
        mean, _ = dblquad(inner, 0, 1, 0, lambda u: 1 - u, epsabs=0, epsrel=1e-7)
        assert found[face] == pytest.approx(mean, rel=1e-4)


def test_a_sky_gives_pi_times_its_radiance():
    radiance = 40.0
    sky = ph.EnvironmentLight(image=np.full((16, 32, 3), radiance), intensity=math.pi)
    np.testing.assert_allclose(level(of(FLOOR, [sky])), math.pi * radiance, rtol=1e-3)
    beside = pv.MultiBlock({"floor": FLOOR, "wall": wall((-1.0, 0, 500.0), (1, 0, 0), size=1000.0, cells=1)})
    scene = ph.Scene([sky], light_model=ph.LightModel(shadows=True))
    shaded = level(beside.phong.irradiance(scene)["floor"])
    half = shaded[POINTS[:, 0] > -0.9]  # an endless wall hides half of the sky
    np.testing.assert_allclose(half, 0.5 * math.pi * radiance, rtol=0.01)


def test_the_back_of_a_two_sided_surface_is_lit_for_a_viewer_who_sees_it():
    below = ph.PointLight(position=(0, 0, -1.5), intensity=1000.0, **BY_SQUARE)
    under = ph.Viewer(position=(0, 0, -9))
    for two_sided in (False, True):
        scene = ph.Scene([below], under, ph.LightModel(two_sided=two_sided))
        for per, points in (("vertex", POINTS), ("face", FLOOR.cell_centers().points)):
            found = level(FLOOR.phong.irradiance(scene, per=per))
            np.testing.assert_allclose(found, two_sided * 1000.0 * over_squares(points), rtol=0.02)


# --- what is included


def test_shares_sum_to_the_whole_and_none_is_negative():
    lights = [light for light, _ in LAMPS.values()]
    lights += [ph.DirectionalLight(direction=(1, 0, -1), name="sun"), ph.DirectionalLight(on=False, name="off")]
    for per in ("vertex", "face"):
        found = of(room(4).scale(4.0, inplace=False), lights, per, bounces=2, shadows=True)
        labels = ["light_0", "light_1", "light_2", "light_3", "light_sun", "light_off", "bounced"]
        parts = [np.asarray(found[f"irradiance_{label}"], np.float64) for label in labels]
        np.testing.assert_allclose(np.sum(parts, axis=0), found["irradiance"], rtol=1e-5)
        assert min(part.min() for part in parts) >= 0.0
        assert not parts[5].any()
        assert parts[6].min() > 0.0


def test_only_light_that_arrives_counts():
    """Ambient light, clamping, highlights and the surface's colours are left out."""
    sun = ph.DirectionalLight(diffuse=(1.0, 0.5, 0.25), specular="white", ambient=0.5, intensity=2.0)
    for model in (ph.LightModel(ambient=1.0, ambient_occlusion=True), ph.LightModel.vtk()):
        tinted = FLOOR.copy()
        tinted["albedo"] = np.full((FLOOR.n_points, 3), 0.1)
        found = tinted.phong.irradiance(ph.Scene([sun], light_model=model), albedo="albedo")
        assert found["irradiance"].tolist() == [[2.0, 1.0, 0.5]] * FLOOR.n_points
        assert found.active_scalars_name == "irradiance"
    assert "irradiance" not in tinted.array_names


def test_units_do_not_change_what_is_computed():
    """Soft shadows are sampled as well for lux as for klux."""
    ball = pv.Sphere(radius=0.3, center=(0, 0, 0.6))
    scenes = [
        ph.Scene(
            [ph.SphereLight(position=(0, 0, 2), radius=0.4, intensity=power)], light_model=ph.LightModel(shadows=True)
        )
        for power in (1.0, 1e5)
    ]
    small, large = (FLOOR.phong.irradiance(scene, occluders=[ball])["irradiance"] for scene in scenes)
    assert len(np.unique(small)) > 8  # there is a penumbra
    np.testing.assert_allclose(large, 1e5 * small, rtol=1e-5)


# --- cells


def test_cells_of_every_kind_have_the_mean_over_their_area():
    """A square as one quad, as a strip, as two triangles, and an L that is not convex; vertices and lines have 0."""
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    corner = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)], float)
    lamp = ph.PointLight(position=(0.3, 0.4, 1.0), **BY_SQUARE)
    triangles = pv.PolyData(square, faces=[3, 0, 1, 2, 3, 0, 2, 3])
    whole = level(of(triangles, [lamp], "face")).mean()
    mixed = pv.PolyData(square, faces=[4, 0, 1, 2, 3], lines=[2, 0, 1], verts=[1, 0], strips=[4, 0, 1, 3, 2])
    found = level(of(mixed, [lamp], "face"))
    assert found[:2].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(found[2:], whole, rtol=2e-3)  # the diagonals differ
    others = [of(pv.PolyData(square + shift, faces=[4, 0, 1, 2, 3]), [lamp], "face") for shift in np.eye(3)[:2]]
    three = (level(found)[0] for found in others)
    bent = level(of(pv.PolyData(corner, faces=[6, 0, 1, 2, 3, 4, 5]), [lamp], "face"))
    np.testing.assert_allclose(bent, (whole + sum(three)) / 3.0, rtol=5e-3)
    flat = pv.PolyData(
        np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (np.nan, 0, 0)], float), faces=[3, 0, 1, 2, 3, 0, 1, 3]
    )
    assert level(of(flat, [lamp], "face")).tolist() == [0.0, 0.0]


def test_a_face_looks_where_its_normals_point():
    down = FLOOR.flip_faces()
    np.testing.assert_array_equal(level(of(down, [LAMPS["point"][0]], "face")).min() > 0.0, True)
    del down.point_data["Normals"]
    assert level(of(down, [LAMPS["point"][0]], "face")).max() == 0.0


def test_a_matrix_moves_the_faces():
    matrix = np.diag([2.0, 2.0, 1.0, 1.0])
    matrix[2, 3] = -1.0
    moved = FLOOR.transform(matrix, inplace=False)
    for per in ("vertex", "face"):
        found = [
            level(of(mesh, [LAMPS["disk"][0]], per, **how)) for mesh, how in ((FLOOR, {"matrix": matrix}), (moved, {}))
        ]
        np.testing.assert_allclose(*found, rtol=1e-5)


# --- bounces


@pytest.mark.parametrize("per", ["vertex", "face"])
def test_an_integrating_sphere_spreads_light_evenly(per):
    """Every point of a sphere sees the mean over it: after n bounces, I/R² (ρ + … + ρⁿ), wherever the lamp is."""
    ball = hollow(3)
    lamp = ph.PointLight(position=(0.3, 0, 0.2), intensity=50.0, **BY_SQUARE)
    for bounces in (1, 3):
        found = of(ball, [lamp], per, bounces=bounces, albedo=0.6)
        bounced = level(found, "irradiance_bounced")
        exact = 50.0 * sum(0.6**k for k in range(1, bounces + 1))
        assert bounced.mean() == pytest.approx(exact, rel=0.02)  # a sphere of triangles is smaller than a sphere
        assert bounced.std() < 0.05 * exact


def test_light_goes_from_a_lit_square_to_one_at_right_angles():
    """A uniform irradiance E on a square reflects ρ E F to each point of another one, F its form factor (B-4)."""
    lit, dark = wall((0.5, 0, 0), (0, 0, 1), cells=4), wall((0, 0, 0.5), (1, 0, 0), cells=4)
    sun = ph.DirectionalLight(direction=(0, 0, -1), intensity=1000.0)
    blocks = pv.MultiBlock({"lit": lit, "dark": dark})
    found = blocks.phong.irradiance(sun, bounces=1, albedo={"lit": (0.8, 0.4, 0.0), "default": 0.0})
    points = dark.points[dark.points[:, 2] > 0.2].astype(np.float64)
    y, z = points[:, 1], points[:, 2]
    factor = sum(
        (np.arctan(w / z) - z / np.hypot(1, z) * np.arctan(w / np.hypot(1, z))) / (2 * math.pi)
        for w in (np.maximum(0.5 - y, 1e-9), np.maximum(0.5 + y, 1e-9))
    )
    bounced = found["dark"]["irradiance_bounced"][dark.points[:, 2] > 0.2]
    assert not bounced[:, 2].any()
    np.testing.assert_allclose(bounced[:, 0], 2.0 * bounced[:, 1], rtol=1e-5)
    errors = bounced[:, 0] / 800.0 - factor
    assert np.abs(errors).max() < 3.0 * np.sqrt(factor * (1 - factor) / 256).max()
    assert found["dark"]["irradiance_light_0"].max() < 1e-3


def test_a_known_transport_and_visibility_are_used():
    ball, lamp = hollow(1), ph.PointLight(position=(0.3, 0, 0.2), **BY_SQUARE)
    scene = ph.Scene([lamp], light_model=ph.LightModel(shadows=True, bounces=2))
    exchange, seen = ball.phong.transport(samples=16), ball.phong.visibility(scene)
    found = ball.phong.irradiance(scene, transport=exchange, visibility=seen)
    again = ball.phong.irradiance(scene, transport=exchange)
    np.testing.assert_array_equal(found["irradiance"], again["irradiance"])
    assert exchange.rays == 16 * ball.n_points
    darkened = ball.phong.irradiance(scene, transport=exchange, visibility=np.zeros((2, ball.n_points)))
    assert not darkened["irradiance"].any()


# --- blocks


@pytest.mark.parametrize("per", ["vertex", "face"])
def test_blocks_have_the_irradiance_of_one_mesh(per):
    floor, lid = wall((0, 0, 0), (0, 0, 1), size=2.0, cells=6), wall((0.3, 0, 1), (0, 0, -1), cells=2)
    scene = ph.Scene([LAMPS["rectangle"][0]], light_model=ph.LightModel(shadows=True, bounces=1))
    blocks = pv.MultiBlock({"floor": floor, "gap": None, "lid": lid}).phong.irradiance(scene, per=per)
    assert blocks.keys() == ["floor", "gap", "lid"]
    assert blocks["gap"] is None
    joined = floor.append_polydata(lid).phong.irradiance(scene, per=per)
    for name in ("irradiance_light_0", "irradiance_bounced"):
        parts = np.concatenate([blocks["floor"][name], blocks["lid"][name]])
        assert np.abs(parts - joined[name]).max() < 0.02 * joined["irradiance"].max()


# --- refusals

WRONG = [
    ({"per": "cell"}, "per must be one of 'vertex', 'face'; got cell"),
    ({"bounces": -1}, "bounces must be a finite number >= 0"),
    ({"albedo": 1.5}, "albedo must be "),
    ({"albedo": "no array"}, "albedo must be the name of a point array"),
    ({"name": "Normals"}, "name must be different from the names of the mesh's normals"),
    ({"per": "face", "visibility": np.ones((2, FLOOR.n_points))}, "visibility must be omitted for per='face'"),
    ({"per": "face", "transport": FLOOR.phong.transport()}, "transport must be omitted for per='face'"),
    ({"transport": room().phong.transport(), "bounces": 1}, "transport must be computed for the meshes that are lit"),
]


@pytest.mark.parametrize(("options", "message"), WRONG, ids=lambda value: str(value)[:30])
def test_what_is_wrong_is_refused(options, message):
    for what in (FLOOR, pv.MultiBlock({"a": FLOOR})):
        if what is not FLOOR and "visibility" in options:
            options = {**options, "visibility": {"a": options["visibility"]}}
        with pytest.raises(ValueError, match=rf"^(block \['a'\]: )?{message}"):
            what.phong.irradiance(LAMPS["point"][0], **options)


def test_a_cloud_has_no_faces():
    cloud = pv.PolyData(np.eye(3))
    cloud.point_data.active_normals = np.eye(3)
    assert cloud.phong.irradiance(LAMPS["point"][0]).n_points == 3
    with pytest.raises(ValueError, match=r"^mesh must be a mesh with faces for per='face'; got 3 points and no faces"):
        cloud.phong.irradiance(LAMPS["point"][0], per="face")
    blocks = pv.MultiBlock({"a": FLOOR})
    with pytest.raises(ValueError, match=r"^albedo must be a mapping with the names of all blocks"):
        blocks.phong.irradiance(LAMPS["point"][0], albedo={"b": 0.5})
