"""Laws of every registered light; an entry in `strategies.LIGHT_SHAPES` adds a new kind."""

from __future__ import annotations

import dataclasses
import itertools
import math
import pickle

import numpy as np
import pytest
from strategies import LIGHT_SHAPES, Dice, triple, unit

from pvphong import DirectionalLight, LightModel, Material, Scene, SphereLight, Viewer, as_light, evaluate, plan
from pvphong.geometry.extent import MeshBounds
from pvphong.optics.light import NODES
from pvphong.optics.lights import LIGHT_TYPES, is_in_vtk, nearest_in_vtk, vtk_values
from pvphong.optics.roles import Aim, Corners, Place, Role, Turn, Up
from pvphong.shading.plan import lights as plans
from pvphong.shading.plan.effects import EFFECTS
from pvphong.vtk.scenes import refuse_inexpressible

FRAMES = ("world", "camera", "headlight")
SEEDS = range(8)
COUNT = 64
KINDS = LIGHT_TYPES | {"sun": DirectionalLight}
"""All kinds of light; a sun is a directional light with an angle."""
SHAPES = LIGHT_SHAPES | {
    "sun": lambda dice, _place, aim, _: {"direction": aim, "angle": dice.choice((0.533, 5.0, 90.0))}
}
every_light = pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind in KINDS for seed in SEEDS])


def thrown(kind, seed, **fields):
    """Return a random light of a kind, near or far from the origin, vertices around the origin, and the dice."""
    dice = Dice(f"{kind} {seed}")
    away = dice.unit_vector() * dice.choice((0.7, 2.0, 8.0, 300.0))
    aim = triple(-away + 0.2 * dice.vector())
    light = KINDS[kind](**SHAPES[kind](dice, triple(away), aim, dice.uniform(5.0, 90.0)), **fields)
    points = np.array([dice.vector() * 0.5 for _ in range(COUNT)])
    return light, points, dice


def extent_of(points):
    return MeshBounds(points, None, None)


def arriving(light, points):
    """Yield directions (3, n) and strengths (n,) of each of a light's nodes."""
    for node in light.nodes(16):
        arrival = node.arrival(points.T)
        yield (
            np.broadcast_to(arrival.direction, points.T.shape),
            node.intensity * np.broadcast_to(arrival.strength, len(points)),
        )


def all_and_single(points):
    """Return all vertices, and some single ones, whose bounding sphere has no slack."""
    return points, *points[:6, None]


def of_its_middle(light, points):
    """Return directions (3, n) and strengths (n,) of the light from a light's centre."""
    arrival = light.arrival(points.T)
    return np.broadcast_to(arrival.direction, points.T.shape), np.broadcast_to(arrival.strength, len(points))


def eye_axes(viewer):
    """Return the axes x, y and z of eye space in the world, as rows."""
    back = unit(np.subtract(viewer.position, viewer.focal_point))
    right = unit(np.cross(viewer.up, back))
    return np.array([right, np.cross(back, right), back])


def angle(a, b):
    return 2.0 * math.asin(min(0.5 * float(np.linalg.norm(np.subtract(a, b))), 1.0))


@every_light
def test_a_file_gives_it_back_to_the_bit(kind, seed, tmp_path):
    light, _, dice = thrown(kind, seed, frame=FRAMES[seed % 3], name="lamp", diffuse=(0.1, 1 / 3, 0.7), intensity=1e-7)
    scene = Scene([light, dataclasses.replace(light, on=False, name="off")], Viewer(position=triple(dice.vector() + 3)))
    scene.save(tmp_path / "rig.json")
    assert Scene.load(tmp_path / "rig.json") == scene
    assert pickle.loads(pickle.dumps(light)) == light
    assert hash(light) == hash(dataclasses.replace(light))


@every_light
def test_the_way_into_the_world_and_back_changes_nothing(kind, seed):
    light, points, dice = thrown(kind, seed, frame="camera", name="lamp", intensity=0.3, specular="red", on=False)
    viewer = Viewer(triple(4 * dice.vector()), triple(dice.vector()), triple(dice.unit_vector()))
    world = light.in_world(viewer)
    assert world.frame == "world"
    assert world.in_world(viewer) is world
    axes, eye = eye_axes(viewer), np.array(viewer.position)
    for field, role in light.roles.items():
        if isinstance(role, Turn):  # it changes with `up`; the arrivals below check it
            continue
        if type(role) is Role:
            assert getattr(world, field) == getattr(light, field)
            continue
        value, start = getattr(light, field), eye if isinstance(role, Place | Corners) else 0.0
        expected = start + np.array(value) @ axes if isinstance(role, Place | Aim | Corners | Up) else value
        size = np.linalg.norm(value) + np.linalg.norm(start)
        np.testing.assert_allclose(getattr(world, field), expected, rtol=0, atol=1e-14 * size)
    back = world.in_frame("camera", viewer)
    for field in light.roles:
        if getattr(back, field) != getattr(light, field):
            np.testing.assert_allclose(getattr(back, field), getattr(light, field), rtol=1e-12, atol=1e-12)
    assert dataclasses.replace(back, **{field: getattr(light, field) for field in light.roles}) == light
    eye = np.array([viewer.point_to_eye(p) for p in points])
    there, here = world.arrival(points.T), light.arrival(eye.T)
    np.testing.assert_allclose(*np.broadcast_arrays(viewer.axes @ there.direction, here.direction), atol=1e-9)
    np.testing.assert_allclose(there.strength, here.strength, rtol=1e-7, atol=1e-12)


@every_light
def test_a_headlight_stands_and_looks_as_the_viewer_does(kind, seed):
    light, _, dice = thrown(kind, seed, frame="headlight")
    viewer = Viewer(triple(4 * dice.vector()), triple(dice.vector()))
    world = light.in_world(viewer)
    assert world.frame == "world"
    assert world.values(Place) in ([], [viewer.position])
    assert [getattr(world, field) for field, role in world.roles.items() if role.handle == "target"] in (
        [],
        [viewer.view_direction],
    )


@every_light
def test_moved_it_sends_the_same_to_vertices_that_are_moved_with_it(kind, seed):
    light, points, _ = thrown(kind, seed)
    way = np.array([64.0, -32.0, 16.0])
    moved = light.moved(lambda place: triple(np.add(place, way)))
    for (there, strength), (here, same) in zip(arriving(moved, points + way), arriving(light, points), strict=True):
        np.testing.assert_allclose(there, here, atol=1e-12)
        np.testing.assert_allclose(strength, same, rtol=1e-9, atol=1e-12)


@every_light
def test_what_arrives_is_finite_everywhere(kind, seed):
    light, _, dice = thrown(kind, seed)
    hostile = [math.nan, math.inf, -math.inf, 1e308, -1e308, 1e-320, 0.0]
    points = np.array([[dice.choice(hostile) for _ in range(3)] for _ in range(40)] + light.places * 2)
    for direction, strength in arriving(light, points):
        assert np.isfinite(direction).all()
        assert np.isfinite(strength).all()
        assert (strength >= 0).all()
        lost = ~np.isfinite(points).all(axis=1)
        assert light.is_uniform or not (strength[lost].any() or direction[:, lost].any())
        lengths = np.linalg.norm(direction, axis=0)
        assert ((np.abs(lengths - 1) < 1e-12) | (lengths == 0)).all()


@every_light
def test_its_nodes_are_parts_of_it_without_a_size(kind, seed):
    light, _, _ = thrown(kind, seed)
    for count in (1, 2, 7, 64):
        nodes = light.nodes(count)
        sides = 2 if getattr(light, "two_sided", False) else 1
        assert len(nodes) in {1, sides * max(count // sides, 1)}
        whole = float(light.panorama.total.mean()) if light.bands else sides
        if kind == "sun" and count > 1:  # its parts are at an angle to its middle
            whole = 1.0 / np.mean([np.dot(unit(node.direction), unit(light.direction)) for node in nodes])
        assert nodes == (light,) or math.fsum(node.intensity for node in nodes) == pytest.approx(whole, rel=1e-14)
        assert all(node.nodes(count) == (node,) for node in nodes)


@pytest.mark.parametrize(("distance", "off"), [(1.5, 0.03), (2.0, 0.015), (5.0, 0.0025), (30.0, 1e-4)])
@pytest.mark.parametrize("tilt", [0.0, 0.8, 1.5])
def test_a_spheres_nodes_light_a_patch_as_it_does(distance, off, tilt):
    light = SphereLight((0, 0, distance), intensity=distance**2)
    nodes = [dataclasses.replace(node, intensity=light.intensity * node.intensity) for node in light.nodes(64)]
    patch, white = ([[0, 0, 0]], [[math.sin(tilt), 0, math.cos(tilt)]]), Material(ambient=0.0, diffuse=0.5)
    whole, parts = (evaluate(*patch, Scene(lights), white, precision="float64").rgb for lights in ([light], nodes))
    np.testing.assert_allclose(parts, whole, rtol=0, atol=0.5 * off)


SIZED = [*(kind for kind, of in LIGHT_TYPES.items() if len(of().nodes(9)) > 1 and not of().bands), "sun"]
MATT, SHINY = Material(ambient=0.0, diffuse=1.0), Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=20)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", SIZED)
def test_many_nodes_light_a_patch_as_the_whole_does(kind, seed):
    """The front or the back, by diffuse light and by a highlight. tests/optics/test_area.py tests the integrals."""
    dice, model = Dice(f"{kind} {seed}"), LightModel(ambient=0.0, clamp=False)
    away = 4.0 * dice.unit_vector()
    aim, normal = triple((1 if seed % 2 else -1) * away + 0.3 * dice.vector()), unit(away + 1.5 * dice.vector())
    light = KINDS[kind](**SHAPES[kind](dice, triple(away), aim, 60.0))
    viewer = Viewer(triple(2.0 * (normal @ away) * normal - away))
    for material in (MATT, SHINY):
        whole, parts = (
            evaluate(np.zeros((1, 3)), [normal], Scene(lights, viewer, model), material, precision="float64").rgb
            for lights in ([light], light.nodes(1024))
        )
        np.testing.assert_allclose(parts, whole, rtol=1e-3)


@every_light
def test_no_vertex_gets_more_or_from_elsewhere_than_its_reach_says(kind, seed):
    light, every, _ = thrown(kind, seed)
    for points in all_and_single(every):
        reach = plans.reach(light, extent_of(points))
        total = sum(strength for _, strength in arriving(light, points))
        assert (total <= reach.strongest).all()
        if reach.direction is None:
            assert light.bands  # light from all directions
            continue
        for direction, strength in arriving(light, points):
            for l, s in zip(direction.T, strength, strict=True):
                assert s == 0.0 or angle(l, reach.direction) <= reach.turn
    nothing = plans.reach(light, extent_of(every[:0]))
    assert light.is_uniform or (nothing.strongest == math.inf and nothing.direction is None)


@every_light
@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-5])
def test_what_may_stand_in_is_no_further_off_than_it_says(kind, seed, size):
    light, points, _ = thrown(kind, seed)
    points = points * size
    direction, strength = of_its_middle(light, points)
    for effect, exactly in itertools.product(plans.effects(light), (True, False)):
        choice = plans.simpler(light, effect, extent_of(points), exactly=exactly)
        if choice is None:
            continue
        if choice.make is None:
            assert not any(strength.any() for _, strength in arriving(light, points))
            continue
        there, even = of_its_middle(choice.make()[0], points)
        off = np.abs(choice.factor * even - strength)
        assert (off <= choice.spread * (1 + 1e-9) + 4e-16 * (1 + strength)).all()
        assert choice.turn is None or (strength <= choice.strongest).all()
        turned = [angle(a, b) for a, b in zip(direction.T, there.T, strict=True)]
        assert max(turned) <= (choice.turn or 0.0) + 1e-12
        assert not exactly or (choice.spread, choice.turn) == (0.0, None)


with_a_place_and_a_size = pytest.mark.parametrize(
    ("kind", "seed"),
    [(kind, seed) for kind in KINDS for seed in SEEDS if "size" in plans.effects(thrown(kind, seed)[0])],
)


def from_nodes(nodes, points):
    """Return strengths (k, n), including intensities, and directions (k, 3, n) of nodes."""
    arrivals = [(node.intensity, node.arrival(points.T)) for node in nodes]
    strengths = np.array([np.broadcast_to(intensity * came.strength, len(points)) for intensity, came in arrivals])
    return strengths, np.array([np.broadcast_to(came.direction, points.T.shape) for _, came in arrivals])


def angles(a, b):
    return 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(a - b, axis=-2), 1.0))


def with_many_nodes(light, every, count):
    """Yield vertices as in `all_and_single`, with strengths and directions from `count` nodes."""
    strengths, directions = from_nodes(light.nodes(count), every)
    for rows in (slice(None), *np.arange(6)[:, None]):
        yield every[rows], strengths[:, rows], directions[..., rows]


@with_a_place_and_a_size
@pytest.mark.parametrize("farther", [1.0, 3.0, 30.0])
def test_a_light_without_a_size_is_no_further_off_all_its_parts_than_is_said(kind, seed, farther):
    light, every, _ = thrown(kind, seed)
    light, count = light.moved(lambda place: triple(farther * np.array(place))), 512
    for points, strengths, directions in with_many_nodes(light, every, count):
        choice = plans.simpler(light, "size", extent_of(points), exactly=False)
        if choice is None or choice.make is None:
            continue
        total, (there, even) = strengths.sum(axis=0), of_its_middle(choice.make()[0], points)
        astray = 4.0 * choice.turn / count * choice.strongest  # nodes are not centred exactly
        assert (np.abs(choice.factor * even - total) <= choice.spread + astray).all()
        assert (total <= choice.strongest + astray).all()
        assert (angles(directions, there)[strengths > 0.0] <= choice.turn + 1e-12).all()


@with_a_place_and_a_size
@pytest.mark.parametrize("farther", [1.0, 3.0, 30.0])
def test_fewer_nodes_are_no_further_off_than_is_said(kind, seed, farther):
    light, every, _ = thrown(kind, seed)
    light = light.moved(lambda place: triple(farther * np.array(place)))
    for (points, strengths, directions), count in itertools.product(with_many_nodes(light, every, NODES), (1, 4, 16)):
        choice = plans.merged_nodes(light, count, extent_of(points))
        if choice is None:
            continue
        fewer, ways = from_nodes(choice.make(), points)
        assert len(choice.make()) <= count
        assert (np.abs(fewer.sum(axis=0) - strengths.sum(axis=0)) <= choice.spread).all()
        assert (strengths.sum(axis=0) <= choice.strongest).all()
        nearest = np.min([angles(directions, way) for way in ways], axis=0)
        assert (nearest[strengths > 0.0] <= choice.turn + 1e-12).all()


@every_light
def test_its_effects_are_some_of_the_plans_and_its_position_is_one_unless_it_is_even(kind, seed):
    light, _, _ = thrown(kind, seed)
    assert plans.effects(light) <= {effect.name for effect in EFFECTS}
    assert ("position" in plans.effects(light)) != light.is_uniform


@every_light
def test_left_out_an_effect_is_as_it_was_at_the_point(kind, seed):
    light, points, _ = thrown(kind, seed)
    point = triple(points[0])
    direction, strength = of_its_middle(light, points[:1])
    for effect in plans.effects(light) - {"cone"}:  # without its cone, a light has the strength of its axis everywhere
        simpler, factor = plans.without(light, effect, point)
        there, even = of_its_middle(simpler, points[:1])
        np.testing.assert_allclose(factor * even, strength, rtol=1e-12)
        np.testing.assert_allclose(there, direction, atol=1e-12)
        assert effect not in plans.effects(simpler) or simpler is light


@every_light
@pytest.mark.parametrize("tolerance", [1 / 255, 0.05])
def test_a_plan_keeps_its_promise(kind, seed, tolerance):
    light, points, dice = thrown(kind, seed)
    points = points * dice.choice((1.0, 0.1, 1e-3))
    scene = Scene([light], Viewer(triple(dice.vector() * 20)), LightModel(clamp=False))
    material = Material(diffuse=0.6, specular=0.4, shininess=dice.choice((1.0, 10.0)))
    arguments = points, points + triple(dice.vector()), scene, material
    exact = evaluate(*arguments, precision="float64").rgb
    got = evaluate(*arguments, precision="float64", tolerance=tolerance).rgb
    assert np.abs(got - exact).max() <= min(plan(points, scene, material, tolerance=tolerance).error_bound, tolerance)


@every_light
def test_vtk_has_it_or_is_said_not_to(kind, seed):
    light, _, _ = thrown(kind, seed, intensity=0.5)
    back = as_light(light.to_pyvista())
    if is_in_vtk(light):
        values, kept = vtk_values(light), vtk_values(back)
        np.testing.assert_allclose(kept.position, values.position, rtol=1e-12)
        assert kept.attenuation == values.attenuation
        return
    nearest = dataclasses.replace(nearest_in_vtk(light), intensity=0.5)
    for field in nearest.roles:  # VTK stores a direction as a focal point
        np.testing.assert_allclose(getattr(back, field), getattr(nearest, field), rtol=1e-12, atol=1e-12)
    assert dataclasses.replace(back, **{field: getattr(nearest, field) for field in nearest.roles}) == nearest
    for judged in (
        lambda: refuse_inexpressible(Scene([light]), Material(), None),
        lambda: evaluate([[0, 0, 0]], [[0, 0, 1]], Scene([light], Viewer(), LightModel.vtk()), Material()),
    ):
        with pytest.raises(
            ValueError, match=rf"^lights\[0\] must be .* VTK supports.*; got an? {type(light).__name__}\."
        ) as told:
            judged()
        shape = ", ".join(f"{field}={getattr(nearest, field)}" for field in nearest.roles)
        assert str(told.value).endswith(f" The nearest light in VTK is {type(nearest).__name__}({shape}).")
