"""Laws of every registered reflectance; an entry in `REFLECTANCE_SHAPES` adds a new one."""

from __future__ import annotations

import dataclasses
import math
from copy import deepcopy
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from strategies import REFLECTANCE_SHAPES, Dice, unit

from pvphong import LightModel, Material, PointLight, Scene, Viewer, evaluate
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import AngleBounds
from pvphong.optics.reflectances import PBR, REFLECTANCES, BlinnPhong, Phong
from pvphong.optics.reflectances.likeness import counterpart_of, stand_in
from pvphong.optics.reflectances.vtk import VtkHeadlight
from pvphong.optics.surface import Surface
from pvphong.shading.limits import change, most
from pvphong.shading.reference import lobe_factors
from pvphong.vtk.scenes import refuse_inexpressible

SEEDS = range(4)
COUNT = 400
every_reflectance = pytest.mark.parametrize(("name", "seed"), [(name, seed) for name in REFLECTANCES for seed in SEEDS])


@dataclass
class Thrown:
    """A reflectance, and unit vectors (3, n), many close to each other to cover highlights and the horizon."""

    reflectance: object
    n: np.ndarray
    l: np.ndarray
    v: np.ndarray

    def factors(self, l=None, v=None, real=np.float64):
        l, v = self.l if l is None else l, self.v if v is None else v
        tangents = np.roll(self.n, 1, axis=0)
        surface = Surface(self.n.astype(real), self.n.any(axis=0).astype(real), v.astype(real), tangents.astype(real))
        lobes = self.reflectance.lobes
        with np.errstate(divide="ignore", under="ignore", over="ignore"):  # as evaluators do
            found = lobe_factors(self.reflectance, surface, Arrival(l.astype(real), 1.0), [True] * len(lobes))
        return [np.broadcast_to(factor, self.n.shape[1]) for factor in found]


def thrown(name, seed):
    """Return a random case of a reflectance, and dice that continue its sequence."""
    case, dice = first_thrown(name, seed)
    return case, deepcopy(dice)


@cache
def first_thrown(name, seed):
    dice = Dice(f"{name} {seed}")
    reflectance = REFLECTANCES[name](**REFLECTANCE_SHAPES[name](dice))
    n = np.array([dice.unit_vector() for _ in range(COUNT)])
    v = np.array([unit(a + 0.7 * dice.vector()) for a in n])
    mirrored = 2 * np.einsum("ij,ij->i", n, v)[:, None] * n - v
    near = [10.0 ** dice.uniform(-6, 0.5) for _ in range(COUNT)]
    l = np.array([unit(a + r * dice.vector()) for a, r in zip(mirrored, near, strict=True)])
    return Thrown(reflectance, n.T, l.T, v.T), dice


def turned(vectors, angle, dice):
    """Rotate each vector by an angle, in a random direction."""
    a = vectors.T
    side = np.cross(a, [dice.unit_vector() for _ in a])
    while (is_short := np.linalg.norm(side, axis=1) < 0.05).any():
        side[is_short] = np.cross(a[is_short], [dice.unit_vector() for _ in a[is_short]])
    return (math.cos(angle) * a + math.sin(angle) * side / np.linalg.norm(side, axis=1, keepdims=True)).T


def angles(a, b):
    return np.arccos(np.clip(np.einsum("ij,ij->j", a, b), -1, 1))


@every_reflectance
def test_factors_are_from_0_to_the_largest_and_0_on_the_dark_side(name, seed):
    case, _ = thrown(name, seed)
    for lobe, factor in enumerate(case.factors()):
        assert (factor >= 0).all()
        assert (factor <= most(case.reflectance, lobe) * (1 + 1e-12)).all()
        assert not factor[np.einsum("ij,ij->j", case.n, case.l) < -1e-15].any()
    assert len(case.reflectance.lobes) <= 3


@every_reflectance
@pytest.mark.parametrize("light_moves", [True, False])
@pytest.mark.parametrize("turn", [1e-4, 1e-2, 0.3])
def test_a_turn_changes_no_factor_by_more_than_is_said(name, seed, turn, light_moves):
    case, dice = thrown(name, seed)
    before = case.factors()
    after = case.factors(l=turned(case.l, turn, dice)) if light_moves else case.factors(v=turned(case.v, turn, dice))
    psi = angles(case.l, case.v)
    for k, (a, b) in enumerate(zip(before, after, strict=True)):
        bounds = [change(case.reflectance, k, turn, p, light_moves=light_moves) for p in psi]
        assert (np.abs(a - b) <= np.array(bounds) * (1 + 1e-7) + 1e-9).all()


@every_reflectance
def test_no_factor_is_more_than_what_is_known_of_the_angles_allows(name, seed):
    case, _ = thrown(name, seed)
    theta, phi, psi = angles(case.n, case.l), angles(case.n, case.v), angles(case.l, case.v)
    for k, factor in enumerate(case.factors()):
        bounds = [
            most(case.reflectance, k, AngleBounds(*line))
            for line in zip(theta - 1e-7, phi - 1e-7, psi + 1e-7, strict=True)
        ]
        assert (factor <= np.array(bounds) * (1 + 1e-6) + 1e-9).all()


@every_reflectance
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_factors_are_finite_where_vectors_meet(name, seed, real):
    case, _ = thrown(name, seed)
    x, z, nothing = np.array([[[1.0], [0], [0]], [[0], [0], [1]], [[0], [0], [0]]])
    meetings = (z, z, z), (z, z, -z), (z, -z, z), (z, x, x), (z, x, -x), (z, x, z), (nothing, z, z), (z, nothing, x)
    for n, l, v in meetings:
        for factor in Thrown(case.reflectance, n, l, v).factors(real=real):
            assert np.isfinite(factor).all()
            assert n.any() or not factor.any()


@every_reflectance
def test_its_counterpart_looks_much_the_same(name, seed):
    case, _ = thrown(name, seed)
    if counterpart_of(case.reflectance) is None or case.reflectance.sharpness < 4:
        pytest.skip("there is none")
    _, other = counterpart_of(case.reflectance)
    mine, others = case.factors(), Thrown(other, case.n, case.l, case.v).factors()
    assert np.abs(mine[1] - others[1]).mean() < 0.1
    assert counterpart_of(other)[1] == case.reflectance


@pytest.mark.parametrize(("name", "seed"), [(name, 1) for name in REFLECTANCES if name != "pbr"])
def test_vtk_is_said_not_to_have_it(name, seed):
    case, _ = thrown(name, seed)
    material = Material(reflectance=case.reflectance)
    kind = type(case.reflectance).__name__
    instead = stand_in(case.reflectance, material)
    remedy = "The nearest material in VTK has reflectance=None, diffuse=" if instead else "Leave it out"
    for judged in (
        lambda: refuse_inexpressible(Scene(), material, None),
        lambda: evaluate([[0, 0, 0]], [[0, 0, 1]], Scene((), Viewer(), LightModel.vtk()), material),
    ):
        with pytest.raises(ValueError, match=rf"^reflectance must be None or PBR .*VTK.*; got {kind}\(.*{remedy}"):
            judged()


@pytest.mark.parametrize(("reflection", "reflectance"), [("phong", Phong()), ("blinn-phong", BlinnPhong())])
def test_the_light_models_reflection_is_the_reflectance_of_that_name(reflection, reflectance):
    points = np.array([Dice(k).vector() for k in range(50)])
    scene = Scene([PointLight((2, 1, 4))], Viewer((1, 2, 5)))
    chosen = dataclasses.replace(scene, light_model=LightModel(reflection=reflection))
    chosen = evaluate(points, points, chosen, Material(specular=1, shininess=9))
    named = evaluate(points, points, scene, Material(specular=1, shininess=9, reflectance=reflectance))
    np.testing.assert_array_equal(chosen.rgb, named.rgb)


def test_vtks_headlight_tier_has_a_floor_but_not_without_a_normal():
    nothing, z = np.zeros((3, 1)), np.array([[0.0], [0], [1]])
    assert Thrown(VtkHeadlight(2.0), z, -z, z).factors() == [1e-6, pytest.approx(1e-12)]
    assert Thrown(VtkHeadlight(2.0), nothing, z, z).factors() == [0.0, 0.0]
    surface, arrival = Surface(z, np.ones(1), z, z), Arrival(-z, 1.0)
    assert lobe_factors(VtkHeadlight(2.0), surface, arrival, [True, False])[0] == 1e-6  # also if no highlight is needed


# --- bad input ---


@pytest.mark.parametrize(
    ("name", "fields", "message"),
    [
        ("ggx", {"roughness": 0.0}, "roughness must be a finite number > 0 and <= 1; got 0.0. 0.1 is polished"),
        ("ggx", {"roughness": 1.1}, "roughness must be a finite number > 0 and <= 1; got 1.1"),
        ("ggx", {"roughness": 0.5, "f0": 1.2}, "f0 must be a reflectance of at most 1 in each channel; got 1.2"),
        ("ggx", {"roughness": 0.5, "f0": "golden"}, "f0 must be a number .*; got golden. Did you mean"),
        ("pbr", {"metallic": -0.1}, "metallic must be a finite number >= 0 and <= 1; got -0.1"),
        ("pbr", {"roughness": math.nan}, "roughness must be a finite number > 0 and <= 1; got nan"),
        ("metal", {"color": (1, 1.5, 1)}, "color must be a reflectance of at most 1"),
        ("metal", {"color": 1, "shininess": -1}, "shininess must be a finite number >= 0; got -1"),
        ("modified-phong", {"shininess": -1}, "shininess must be a finite number >= 0; got -1"),
        ("retro", {"shininess": math.inf}, "shininess must be a finite number >= 0; got inf"),
        ("ward", {"alpha_x": 0, "alpha_y": 1}, "alpha_x must be a finite number > 0 and <= 1; got 0"),
    ],
)
def test_what_no_surface_has_is_refused(name, fields, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        REFLECTANCES[name](**fields)


def test_white_that_is_more_than_white_is_refused_for_a_metal_of_that_colour():
    with pytest.raises(ValueError, match=r"^diffuse must be at most 1 in each channel for PBR; got \(2"):
        evaluate([[0, 0, 0]], [[0, 0, 1]], Scene(()), Material(diffuse=2.0, reflectance=PBR(1.0)))
