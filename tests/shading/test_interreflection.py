"""Bounced light: the furnace test, the series compared with a dense solution, contributions, and plans."""

from dataclasses import MISSING, fields, replace

import numpy as np
import pytest
import pyvista as pv
from rays.rooms import hollow, room, wall

import pvphong as ph
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading import interreflection
from pvphong.shading.interreflection import Radiosity


def model(bounces, **fields):
    return ph.LightModel(**{"ambient": 0.0, "clamp": False, "bounces": bounces, **fields})


ROOM = room()
TRANSPORT = ROOM.phong.transport(samples=64)
LAMP = (ph.PointLight((0.1, 0.2, 0.3), name="lamp"),)
GREY = ph.Material(ambient=0.5, diffuse=0.5, specular=0.3)


def lit(bounces, lights=LAMP, material=GREY, **how):
    fields = {name: how.pop(name) for name in ("ambient", "clamp") if name in how}
    scene = ph.Scene(lights, light_model=model(bounces, **fields))
    return ROOM.phong.shade(scene, material, transport=TRANSPORT, **how)


@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")  # the ball's normals point inwards, its faces outwards
@pytest.mark.parametrize("albedo", [0.2, 0.7, 0.95])
@pytest.mark.parametrize("mesh", [hollow(), room()], ids=["ball", "box"])
def test_in_a_furnace_all_is_as_bright(mesh, albedo):
    """B = e/(1 − ρ) inside a closed surface of uniform emission."""
    glowing = ph.Material(ambient=0.0, diffuse=albedo, specular=0.0, emission=0.03)
    found = mesh.phong.shade(ph.Scene(light_model=model(600)), glowing)["phong"]
    np.testing.assert_allclose(found, 0.03 / (1.0 - albedo), rtol=1e-3)


@pytest.mark.parametrize("bounces", [1, 2, 30])
def test_the_series_is_that_of_a_dense_matrix(bounces):
    """An independent series for a material with maps: direct light of two lamps, emission, and matrix products."""
    lights = (*LAMP, ph.SpotLight((0, 0, 0), direction=(1, 0, 0), diffuse="red"))
    albedo = np.random.default_rng(0).uniform(0.1, 0.9, (ROOM.n_points, 3))
    material = ph.Material(ambient=0.4, diffuse=1.0, specular=0.2, emission=(0.0, 0.1, 0.0), albedo=albedo)
    found = lit(bounces, lights, material, ambient=0.3, precision="float64")["phong"]
    direct = lit(0, lights, replace(material, ambient=0.0), precision="float64")["phong"]
    sends = lit(0, lights, replace(material, ambient=0.0, specular=0.0), precision="float64")["phong"]
    matrix, reflected = TRANSPORT.matrix.toarray().astype(np.float64), np.zeros_like(sends)
    incoming = sends + 0.4 * 0.3 * albedo
    for _ in range(bounces):
        reflected = albedo * (matrix @ incoming)
        incoming = sends + reflected
    np.testing.assert_allclose(found, direct + reflected, rtol=2e-5, atol=1e-6)


def test_shares_add_up():
    found = lit(3, components=True, shares_by_bounce=True, ambient=0.3)
    parts = [found[f"phong_{part}"] for part in ("ambient", "diffuse", "specular", "emission", "bounced")]
    np.testing.assert_allclose(sum(parts), found["phong"], rtol=1e-5, atol=1e-6)
    by_light = found["phong_base"] + found["phong_light_lamp"] + found["phong_bounced"]
    np.testing.assert_allclose(by_light, found["phong"], rtol=1e-5, atol=1e-6)
    bounces = [found[f"phong_bounce_{bounce}"] for bounce in (1, 2, 3)]
    np.testing.assert_allclose(sum(bounces), found["phong_bounced"], rtol=1e-5, atol=1e-6)
    assert bounces[0].mean() > bounces[1].mean() > 0.0
    assert not found["phong_ambient"].any()
    assert "phong_bounce_1" not in lit(3, components=True).point_data
    np.testing.assert_allclose(lit(3, ambient=0.3)["phong"], found["phong"], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("name", REFLECTANCES)
def test_every_reflectance_scatters_what_arrives_and_no_more(name):
    """In uniformly glowing surroundings, the result is the diffuse contribution of a uniform sky without walls."""
    kind = REFLECTANCES[name]
    reflectance = kind(*(0.5 for each in fields(kind) if each.default is MISSING))
    material = ph.Material(ambient=0.0, diffuse=0.6, specular=0.0, reflectance=reflectance)
    if "tangents" in material.reflectance.needs:
        material = replace(material, tangents=np.cross(ROOM.point_normals, (0.3, 0.5, 0.7)))
    glowing = replace(material, emission=1.0)
    sky = ph.Scene([ph.EnvironmentLight(1.0)], ph.Viewer((3, 2, 1)), ph.LightModel(ambient=0, clamp=False))
    expected = ROOM.phong.shade(sky, material, components=True)["phong_diffuse"]
    scene = replace(sky, lights=(), light_model=model(1))
    found = ROOM.phong.shade(scene, glowing, transport=TRANSPORT)["phong"] - 1.0
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)
    assert found.max() <= 0.75


def test_blocks_light_each_other():
    """A red floor and a white ceiling agree as blocks with separate materials and as one mesh with an albedo."""
    blocks = pv.MultiBlock({"floor": wall((0, 0, 0), (0, 0, 1)), "ceiling": wall((0, 0, 1), (0, 0, -1))})
    colors = {"floor": (0.8, 0.1, 0.1), "ceiling": (0.9, 0.9, 0.9)}
    materials = {name: ph.Material(ambient=0.0, specular=0.0, diffuse=color) for name, color in colors.items()}
    scene = ph.Scene([ph.PointLight((0, 0, 0.8))], ph.Viewer(), model(2))
    among = blocks.phong.transport(samples=64)
    found = blocks.phong.shade(scene, materials, transport=among, components=True)
    one = blocks["floor"].append_polydata(blocks["ceiling"])
    count = blocks["floor"].n_points
    albedo = np.repeat([colors["floor"], colors["ceiling"]], count, axis=0)
    material = ph.Material(ambient=0.0, specular=0.0, diffuse=1.0, albedo=albedo)
    expected = one.phong.shade(scene, material, transport=one.phong.transport(samples=64))["phong"]
    np.testing.assert_allclose(found["floor"]["phong"], expected[:count], atol=1e-5)
    np.testing.assert_allclose(found["ceiling"]["phong"], expected[count:], atol=1e-5)
    ceiling = found["ceiling"]["phong_bounced"]
    assert (ceiling[:, 0] > 3 * ceiling[:, 1]).all()
    plans = blocks.phong.plan(scene, materials, transport=among)
    assert plans["floor"].effects["bounces"].on
    with pytest.raises(ValueError, match=r"^transport must be computed for the meshes that are lit"):
        blocks.phong.shade(scene, materials, transport=TRANSPORT)


def test_arrays_take_a_transport_too():
    scene = ph.Scene([ph.PointLight((0.1, 0.2, 0.3))], ph.Viewer(), model(2))
    given = ROOM.points, ROOM.point_normals, scene, GREY
    expected = ROOM.phong.shade(scene, GREY, transport=TRANSPORT)["phong"]
    np.testing.assert_allclose(ph.evaluate(*given, transport=TRANSPORT).rgb, expected, atol=1e-6)
    with pytest.raises(ValueError, match=r"^transport must be given for a light model with bounces"):
        ph.evaluate(*given)
    with pytest.raises(ValueError, match=r"^transport must be the result of mesh\.phong\.transport\(\)"):
        ph.evaluate(*given, transport=np.eye(4))
    with pytest.raises(ValueError, match=r"for a mesh with these 4 points"):
        ph.evaluate(ROOM.points[:4], ROOM.point_normals[:4], scene, GREY, transport=TRANSPORT)


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match=r"^bounces must be a finite number >= 0"):
        ph.LightModel(bounces=-1)
    with pytest.raises(ValueError, match=r"^bounces must be a finite number >= 0 and <= 65536"):
        ph.LightModel(bounces=1e300)
    with pytest.raises(ValueError, match=r"^bounces must be a whole number"):
        ph.LightModel(bounces=1.5)
    with pytest.raises(ValueError, match=r"^bounces must be 0 in VTK's convention"):
        ph.LightModel(convention="vtk", bounces=1)
    with pytest.raises(ValueError, match=r"^bounces must be 0 if the light model is two-sided"):
        ph.LightModel(two_sided=True, bounces=1)
    with pytest.raises(
        ValueError,
        match=r"^material must be a material with a total reflectance of at most 1, .*a total reflectance of 1\.2\.",
    ):
        lit(1, material=ph.Material(diffuse=1.2))
    with pytest.raises(ValueError, match=r"^material must be a material with a total reflectance of at most 1"):
        lit(1, material=ph.Material(diffuse=1.02))
    with pytest.raises(ValueError, match=r"^shares_by_bounce must be False without components"):
        lit(1, shares_by_bounce=True)
    turned = ROOM.copy()
    turned.point_data.active_normals = -ROOM.point_normals
    with pytest.raises(ValueError, match=r"^transport must be computed for the meshes that are lit"):
        turned.phong.shade(ph.Scene(LAMP, light_model=model(1)), GREY, transport=TRANSPORT)
    assert np.isfinite(lit(50, material=ph.Material(diffuse=1.0))["phong"]).all()


def test_a_scene_keeps_its_bounces(tmp_path):
    scene = ph.Scene([ph.PointLight()], light_model=ph.LightModel(bounces=3))
    scene.save(tmp_path / "rig.json")
    assert ph.Scene.load(tmp_path / "rig.json").light_model.bounces == 3
    assert scene.light_model.without_rays().bounces == 0


# --- plans


def test_a_plan_says_what_each_bounce_holds_and_leaves_out_what_cannot_be_seen():
    scene = ph.Scene([ph.PointLight((0, 0, 0.1))], light_model=model(8, ambient=0.2))
    exact = ROOM.phong.plan(scene, GREY, transport=TRANSPORT).effects["bounces"]
    assert exact.on
    assert exact.why == "the bounces add at most 0.25, 0.13, 0.063, …"
    planned = ROOM.phong.plan(scene, GREY, transport=TRANSPORT, tolerance=0.04)
    bounces = planned.effects["bounces"]
    assert bounces.on
    assert bounces.why.startswith("5 of 8, the others add at most 0.01")
    assert 0.0 < bounces.bound <= 0.02
    assert planned.equation.bounces == 5
    assert {"points", "normals"} <= planned.needs
    nothing = ROOM.phong.plan(ph.Scene(light_model=model(8)), GREY, transport=TRANSPORT).effects["bounces"]
    assert (nothing.on, nothing.why) == (False, "nothing sends light")
    metal = ph.Material(diffuse=0.0, ambient=0.0)
    black = ROOM.phong.plan(scene, metal, transport=TRANSPORT).effects["bounces"]
    assert (black.on, black.why) == (False, "the surface reflects no light diffusely")
    alone = pv.Sphere().phong.plan(scene, GREY).effects["bounces"]
    assert (alone.on, alone.why) == (False, "the mesh is convex, and alone")
    assert not ROOM.phong.plan([ph.PointLight()]).effects["bounces"].on


def random_scene(random):
    """Return a scene with random lights of several kinds, and a random material of the room's walls."""

    def color(most=1.0):
        return tuple(random.uniform(0, most, 3))

    def place():
        return tuple(random.uniform(-0.4, 0.4, 3))

    kinds = [
        lambda: ph.PointLight(place(), diffuse=color(), ambient=color(), intensity=random.exponential()),
        lambda: ph.SpotLight(place(), direction=tuple(random.normal(size=3)), diffuse=color(), cone_angle=40),
        lambda: ph.DirectionalLight(tuple(random.normal(size=3)), diffuse=color()),
        lambda: ph.SphereLight(place(), radius=0.05, diffuse=color(), intensity=0.5),
        lambda: ph.PointLight(place(), attenuation=(1, 0, random.uniform(0, 4)), intensity=2.0),
    ]
    lights = [kinds[random.integers(len(kinds))]() for _ in range(random.integers(1, 4))]
    albedo = random.uniform(0, 1, (ROOM.n_points, 3)) if random.random() < 0.5 else 1.0
    reflectance = ph.OrenNayar(0.4) if random.random() < 0.2 else None
    reflects = {"diffuse": color(random.choice([0.3, 0.6, 1.0])), "specular": color(0.1), "ambient": color()}
    material = ph.Material(**reflects, shininess=20, albedo=albedo, reflectance=reflectance)
    glows = random.random() < 0.3
    lights_model = model(int(random.integers(1, 12)), ambient=color())
    return ph.Scene(lights, ph.Viewer((2, 3, 4)), lights_model), replace(material, emission=0.1 * glows)


def check_promises(seeds):
    taken = 0
    for seed in seeds:
        random = np.random.default_rng(seed)
        scene, material = random_scene(random)
        tolerance = random.choice([1 / 255, 0.02, 0.1])
        plan = ROOM.phong.plan(scene, material, transport=TRANSPORT, tolerance=tolerance)
        given = {"transport": TRANSPORT, "precision": "float64"}
        exact = ROOM.phong.shade(scene, material, **given)["phong"]
        found = ROOM.phong.shade(scene, material, tolerance=tolerance, **given)["phong"]
        assert np.abs(found - exact).max() <= plan.error_bound + 1e-6 * max(1.0, exact.max()), seed
        assert plan.error_bound <= tolerance
        taken += plan.error_bound > 0.0
    assert taken > len(seeds) / 4


def test_no_plan_breaks_its_promise():
    check_promises([*range(60), 153])  # 153: facets so white that their sum over nodes is above 1


@pytest.mark.long
def test_no_plan_of_many_breaks_its_promise():
    check_promises(range(100, 2100))


@pytest.mark.parametrize("tolerance", [1 / 255, 0.02])
def test_among_blocks_others_send_what_a_plan_of_one_does_not_know(tolerance):
    """Nearly all light of a dark floor under a lit white ceiling has bounced."""
    blocks = pv.MultiBlock({"floor": wall((0, 0, 0), (0, 0, 1)), "ceiling": wall((0, 0, 0.5), (0, 0, -1))})
    colors = {"floor": 0.15, "ceiling": 0.95}
    materials = {name: ph.Material(ambient=0.2, specular=0.0, diffuse=color) for name, color in colors.items()}
    beam = ph.SpotLight((0, 0, 0.1), direction=(0, 0, 1), cone_angle=40, intensity=2.0, name="beam")
    weak = ph.PointLight((0, 0, 0.3), intensity=0.004, name="weak")
    scene = ph.Scene([beam, weak], ph.Viewer((0, -3, 1)), model(6, ambient=0.1))
    given = {"transport": blocks.phong.transport(samples=64)}
    exact = blocks.phong.shade(scene, materials, **given)
    found = blocks.phong.shade(scene, materials, tolerance=tolerance, **given)
    plans = blocks.phong.plan(scene, materials, tolerance=tolerance, **given)
    for name in colors:
        error = np.abs(found[name]["phong"] - exact[name]["phong"]).max()
        assert error <= plans[name].error_bound + 1e-6, name
    assert exact["floor"]["phong"].max() > 0.05
    dark = {"floor": materials["floor"], "ceiling": ph.Material(ambient=0.0, specular=0.0, diffuse=0.0, emission=0.9)}
    glow = replace(scene, lights=())
    assert blocks.phong.shade(glow, dark, tolerance=tolerance, **given)["floor"]["phong"].max() > 0.05


def test_a_far_viewer_counts_where_diffuse_reflection_depends_on_him_and_bounces():
    """A rough wall reflects more at a grazing angle, including walls that only another wall's glow lights."""
    floor, glowing = wall((0, 0, 0), (0, 0, 1), 2.0, 6), wall((1, 0, 1), (-1, 0, 0), 2.0, 6)
    mesh = floor.append_polydata(glowing)
    glow = np.repeat([0.0, 20.0], [floor.n_points, glowing.n_points])
    rough = ph.Material(ambient=0.0, diffuse=1.0, emission=glow, reflectance=ph.OrenNayar(80))
    faint = ph.DirectionalLight((0, 0, -1), intensity=0.0023)
    scene = ph.Scene([faint], ph.Viewer((-3.6, 0, 0.25), focal_point=(0, 0, 0.5)), model(1))
    given = {"transport": mesh.phong.transport(samples=64), "precision": "float64"}
    exact, found = (mesh.phong.shade(scene, rough, tolerance=tolerance, **given)["phong"] for tolerance in (0.0, 0.01))
    assert np.abs(found - exact).max() <= 0.01


def test_points_far_out_are_read_in_their_own_type_though_only_the_white_sky_reads_them():
    offset = np.array([1e7, 0.0, 0.0])
    glowing, viewer = ph.Material(diffuse=0.9, emission=0.5, reflectance=ph.GGX(0.6)), ph.Viewer((-1.6, 0.0, 0.25))
    far = ROOM.copy()
    far.points = ROOM.points.astype(float) + offset
    there = replace(viewer, position=tuple(viewer.position + offset), focal_point=tuple(offset))
    colors = {}
    for backend in ("numpy", "numba"):
        given = {"transport": far.phong.transport(samples=64), "backend": backend}
        colors[backend] = far.phong.shade(ph.Scene([], there, model(1)), glowing, **given)["phong"]
    np.testing.assert_allclose(colors["numba"], colors["numpy"], atol=1e-5)


def test_the_whitest_rough_surface_may_bounce_light_seen_at_any_angle():
    rough = ph.Material(diffuse=1.0, reflectance=ph.OrenNayar(10))
    scene = ph.Scene(LAMP, ph.Viewer((-10.0, 0.0, 0.05)), model(1))
    assert np.isfinite(ROOM.phong.shade(scene, rough, transport=TRANSPORT)["phong"]).all()


def test_errors_of_direct_light_count_as_often_as_they_bounce():
    """In a furnace, an error of direct light is amplified by up to 1/(1 − ρ)."""
    bright = ph.Material(ambient=0.0, specular=0.0, diffuse=0.9)
    scene = ph.Scene([ph.PointLight((0, 0, 0.1), intensity=0.004)], light_model=model(100))
    plan = ROOM.phong.plan(scene, bright, transport=TRANSPORT, tolerance=0.02)
    exact = ROOM.phong.shade(scene, bright, transport=TRANSPORT)["phong"]
    found = ROOM.phong.shade(scene, bright, transport=TRANSPORT, tolerance=0.02)["phong"]
    assert exact.max() > 0.02  # as direct light it is at most 0.0036
    assert np.abs(found - exact).max() <= plan.error_bound


def test_the_sum_ends_where_nothing_changes_any_more():
    calls = []

    def gather(colors):
        calls.append(1)
        return 0.5 * colors

    sent = Radiosity(np.ones((3, 3)), np.zeros((3, 3)), np.full((3, 3), 0.5))
    found = interreflection.bounced(sent, gather, 10**6, apart=False)
    np.testing.assert_allclose(found, 1 / 3, rtol=1e-6)
    assert len(calls) < 30
