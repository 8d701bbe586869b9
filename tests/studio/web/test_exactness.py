"""The sentence on how exact the picture is, and its button."""

import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studio.web.exactness import exactness
from pvphong.studio.web.settings import Accuracy

KEY, WEAK = ph.PointLight((1, 1, 3), name="key"), ph.PointLight((0, 0, 9), intensity=1e-3, name="weak")
OFF = ph.PointLight((0, 0, 9), on=False, name="lamp")
SHADOWS = ph.LightModel(shadows=True)
BLENDED = "Every colour is exact at the points of the mesh and blended between them"


@pytest.mark.parametrize(
    ("lights", "model", "accuracy", "is_refined", "text", "button"),
    [
        ([KEY], ph.LightModel(), Accuracy(), False, f"{BLENDED}. Nothing is left out.", "Refine between the points"),
        (
            [KEY, OFF],
            SHADOWS,
            Accuracy(),
            False,
            f"{BLENDED}, so edges of shadows may look ragged. Left out: lamp (switched off).",
            "Refine between the points",
        ),
        (
            [KEY],
            SHADOWS,
            Accuracy(refine=0.01),
            None,
            f"{BLENDED}, as refining is not complete. Nothing is left out.",
            "Go on refining",
        ),
        (
            [KEY],
            SHADOWS,
            Accuracy(refine=0.01),
            False,
            f"{BLENDED}, as refining is not complete. Nothing is left out.",
            "Check it by a measurement",
        ),
        (
            [KEY, WEAK],
            SHADOWS,
            Accuracy(0.05, 0.01),
            True,
            "Every colour is off by at most half a step of a screen at the points of the mesh, and off by at most"
            " 2.6 steps of a screen between them. Left out: weak (too weak to be seen, at most 0.0008).",
            "Leave nothing out",
        ),
        (
            [KEY],
            SHADOWS,
            Accuracy(refine=1 / 255),
            True,
            "Every colour is exact at the points of the mesh, and off by at most one step of a screen between them. "
            "Nothing is left out.",
            "Check it by a measurement",
        ),
    ],
)
def test_a_sentence_says_how_exact_the_picture_is(lights, model, accuracy, is_refined, text, button):
    """`is_refined` is None for refining that is paused."""
    plan = pv.ParametricTorus(u_res=20, v_res=20).phong.plan(
        ph.Scene(lights, light_model=model), tolerance=accuracy.tolerance
    )
    found = exactness([plan], accuracy, is_refined=bool(is_refined), is_paused=is_refined is None)
    assert (found.text, found.improve.label) == (text, button)
