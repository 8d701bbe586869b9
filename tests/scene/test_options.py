"""Errors for unknown options: where the option belongs, or the nearest option."""

import re

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph

GIVEN, SCENE = pv.Sphere(), ph.Scene([ph.PointLight()])
CALLS = {
    "evaluate": lambda **more: ph.evaluate(GIVEN.points, GIVEN.points, SCENE, ph.Material(), **more),
    "shade": GIVEN.phong.shade,
    "plan": GIVEN.phong.plan,
    "visibility": GIVEN.phong.visibility,
    "truth": GIVEN.phong.truth,
    "refine": GIVEN.phong.refine,
    "interpolation_error": GIVEN.phong.interpolation_error,
    "shade_files": lambda **more: ph.shade_files("x.vtp", "y", **more),
    "shade of blocks": pv.MultiBlock([GIVEN]).phong.shade,
    "plan of blocks": pv.MultiBlock([GIVEN]).phong.plan,
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("specular", "Use Material(specular=...)."),
        ("ambient", "Use Material(ambient=...)."),
        ("color", "Use Material(albedo=...)."),
        ("cmap", "Use Material(albedo=Colormap(...))."),
        ("roughness", "Use Material(reflectance=GGX(roughness=...))."),
        ("two_sided", "Use Scene(..., light_model=LightModel(two_sided=...))."),
        ("viewer", "Use Scene(..., viewer=...)."),
    ],
)
def test_it_is_said_where_an_option_belongs(call, name, remedy):
    with pytest.raises(TypeError, match=f"^{call.split()[0]} takes no '{name}'. {re.escape(remedy)}$"):
        CALLS[call](**{name: np.ones(3)})


@pytest.mark.parametrize("call", [name for name in CALLS if name != "evaluate"])
def test_a_misspelt_option_has_its_close_match(call):
    with pytest.raises(TypeError, match=f"^{call.split()[0]} takes no 'feature_angel'. Did you mean 'feature_angle'"):
        CALLS[call](feature_angel=30)


def test_an_option_without_a_close_match_names_what_there_is():
    with pytest.raises(TypeError, match=r"^plan takes no 'xyz'. It takes feature_angle, material, .*tolerance"):
        GIVEN.phong.plan(xyz=1)
