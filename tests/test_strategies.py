"""The generated scenes meet what they are there to meet; a strategy that only draws dark scenes proves nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from oracle import as_array, shade
from strategies import MATRIX_CLASSES, Case, Dice, hard_case, matrix_of, moderate_case

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight

EXAMPLES = 200


def shares(throw: Callable[[Dice], Case], facts_of: Callable[[Case], set[str]]) -> Counter[str]:
    """Fact → share of the throws that show it; the throws are the same in every run."""
    counts: Counter[str] = Counter()
    for seed in range(EXAMPLES):
        counts.update(facts_of(throw(Dice(seed))))
    return Counter({fact: count / EXAMPLES for fact, count in counts.items()})


def ordinary_facts(case: Case) -> set[str]:
    """Of the vertex that the scene is built around, and a neighbour."""
    albedo = None if case.albedo is None else case.albedo[:2]
    case = replace(case, points=case.points[:2], normals=case.normals[:2], albedo=albedo)
    shades = shade(*case.arguments, **case.options)
    specular = as_array(shades, "specular")
    color = as_array(shades, "unclamped")
    facts = {type(light).__name__ for light in case.scene.lights}
    facts |= {light.frame for light in case.scene.lights}
    facts |= {case.scene.light_model.reflection}
    facts |= {"dull"} if not np.any(case.material.specular) else set()
    facts |= {"highlight"} if specular.max() > 0.01 else set()
    facts |= {"sharp highlight"} if specular.max() > 0.01 and case.material.shininess > 1e4 else set()
    facts |= {"clamped"} if color.max() > 1 else set()
    facts |= {"flipped"} if case.scene.light_model.two_sided and any(s.n_dot_v < 0 for s in shades) else set()
    lit = [facts for s in shades for facts in s.lights if facts.cone_margin is not None]
    facts |= {"in a cone"} if any(f.cone_margin > 0 for f in lit) else set()
    facts |= {"outside a cone"} if any(f.cone_margin < 0 for f in lit) else set()
    return facts


@pytest.mark.parametrize("convention", ["standard", "vtk"])
def test_ordinary_scenes_are_lit(convention: str) -> None:
    share = shares(lambda dice: moderate_case(dice, convention), ordinary_facts)
    assert 0.05 < share["dull"] < 0.2
    assert share["highlight"] > 0.7
    assert share["sharp highlight"] > 0.1
    for light in (DirectionalLight, PointLight, SpotLight):
        assert share[light.__name__] > 0.2
    for fact in ("world", "camera", "headlight", "in a cone", "outside a cone", "clamped", "flipped"):
        assert share[fact] > 0.05, fact
    if convention == "standard":
        assert share["phong"] > 0.3
        assert share["blinn-phong"] > 0.3


def hard_facts(case: Case) -> set[str]:
    facts = set()
    for rows, name in ((case.points, "point"), (case.normals, "normal")):
        if not np.isfinite(rows).all():
            facts.add(f"non-finite {name}")
    if not case.normals.any(axis=1).all():
        facts.add("zero normal")
    good = np.isfinite(case.points).all(axis=1) & np.isfinite(case.normals).all(axis=1)
    for s in shade(case.points[good], case.normals[good], case.scene, case.material, **case.options):
        if any(f.distance == 0 for f in s.lights if f.distance is not None):
            facts.add("light on a vertex")
        if any(abs(f.n_dot_l) < 1e-15 for f in s.lights if f.n_dot_l is not None):
            facts.add("grazing light")
        if any(abs(f.cone_margin) < 1e-14 for f in s.lights if f.cone_margin is not None):
            facts.add("edge of a cone")
        if s.n_dot_v is None and case.scene.light_model.local_viewer:
            facts.add("eye on a vertex or no normal")
    return facts


def test_hard_scenes_are_hard() -> None:
    share = shares(lambda dice: hard_case(dice, "standard"), hard_facts)
    for fact in (
        "non-finite point",
        "non-finite normal",
        "zero normal",
        "light on a vertex",
        "grazing light",
        "edge of a cone",
        "eye on a vertex or no normal",
    ):
        assert share[fact] > 0.03, fact


@pytest.mark.parametrize("kind", MATRIX_CLASSES)
def test_every_class_of_matrix_is_what_its_name_says(kind: str) -> None:
    made = [matrix_of(Dice(seed), kind) for seed in range(40)]
    if kind == "none":
        assert made == [None] * 40
        return
    signs = {np.sign(np.linalg.det(matrix[:3, :3])) for matrix in made if matrix is not None}
    assert signs == {-1.0 if kind == "mirror" else 1.0}
    singular = np.array([np.linalg.svd(matrix[:3, :3], compute_uv=False) for matrix in made if matrix is not None])
    rigid = {"identity": True, "rigid": True, "w": True, "uniform": False, "non-uniform": False}
    if kind in rigid:
        assert np.allclose(singular, 1.0) == rigid[kind]
    if kind == "uniform":
        assert np.allclose(singular, singular[:, :1])
    assert (singular[:, 0] / singular[:, 2]).max() < 100
    assert any(matrix[3, 3] < 0 for matrix in made if matrix is not None) == (kind == "w")
