"""The generated scenes meet what they are there to meet; a strategy that only draws dark scenes proves nothing."""

from collections import Counter

import numpy as np
import pytest
from oracle import as_array, shade
from stability.hunting import rows_of
from strategies import Dice, hard_case, moderate_case

EXAMPLES = 200


def shares(throw, facts_of):
    """Fact → share of the throws that show it; the throws are the same in every run."""
    counts = Counter()
    for seed in range(EXAMPLES):
        counts.update(facts_of(throw(Dice(seed))))
    return Counter({fact: count / EXAMPLES for fact, count in counts.items()})


def ordinary_facts(case):
    """Of the vertex that the scene is built around, and a neighbour."""
    case = rows_of(case, slice(2))
    shades, model = shade(*case.arguments, **case.options), case.scene.light_model
    is_shiny = as_array(shades, "specular").max() > 0.01
    margins = [f.cone_margin for s in shades for f in s.lights if f.cone_margin is not None]
    facts = {
        "dull": not np.any(case.material.specular),
        "highlight": is_shiny,
        "sharp highlight": is_shiny and case.material.shininess > 1e4,
        "clamped": as_array(shades, "unclamped").max() > 1,
        "flipped": model.two_sided and any(s.n_dot_v < 0 for s in shades),
        "in a cone": any(margin > 0 for margin in margins),
        "outside a cone": any(margin < 0 for margin in margins),
    }
    named = {name for light in case.scene.lights for name in (type(light).__name__, light.frame)}
    return {fact for fact, holds in facts.items() if holds} | named | {model.reflection}


@pytest.mark.parametrize("convention", ["standard", "vtk"])
def test_ordinary_scenes_are_lit(convention):
    share = shares(lambda dice: moderate_case(dice, convention), ordinary_facts)
    assert share["dull"] < 0.2
    more_than = {0.7: ["highlight"], 0.1: ["sharp highlight"], 0.2: ["DirectionalLight", "PointLight", "SpotLight"]}
    more_than[0.05] = "world", "camera", "headlight", "in a cone", "outside a cone", "clamped", "flipped", "dull"
    more_than[0.3] = ["phong", "blinn-phong"] if convention == "standard" else []
    for least, facts in more_than.items():
        for fact in facts:
            assert share[fact] > least, fact


def hard_facts(case):
    finite = {"point": np.isfinite(case.points).all(axis=1), "normal": np.isfinite(case.normals).all(axis=1)}
    good = rows_of(case, finite["point"] & finite["normal"])
    shades = shade(*good.arguments, **good.options)

    def any_light(name, within):
        found = [getattr(facts, name) for s in shades for facts in s.lights]
        return any(value is not None and abs(value) <= within for value in found)

    facts = {
        "zero normal": not case.normals.any(axis=1).all(),
        "light on a vertex": any_light("distance", 0.0),
        "grazing light": any_light("n_dot_l", 1e-15),
        "edge of a cone": any_light("cone_margin", 1e-14),
        "eye on a vertex or no normal": case.scene.light_model.local_viewer and any(s.n_dot_v is None for s in shades),
    } | {f"non-finite {name}": not rows.all() for name, rows in finite.items()}
    return {fact for fact, holds in facts.items() if holds} | {"a scene"}


def test_hard_scenes_are_hard():
    share = shares(lambda dice: hard_case(dice, "standard"), hard_facts)
    assert len(share) == 8, share
    assert min(share.values()) > 0.03, share
