"""VTK's choice of tier, read off what it draws, and scenes said in its terms."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.equation import vtk_tier
from pvphong.vtk.oracle import vtk_shade
from pvphong.vtk.scenes import InexpressibleError, refuse_inexpressible

SUN = DirectionalLight(direction=(0.0, 1.0, -1.0))
HEADLIGHT = DirectionalLight(frame="headlight")
RIDER = DirectionalLight(direction=(0.3, 0.0, -1.0), frame="camera")
BULB = PointLight(position=(3.0, 3.0, 3.0))
KINDS = (SUN, HEADLIGHT, RIDER, BULB)


def drawn_tier(lights: list) -> str:
    """Read off one vertex that faces away from all lights, under a diffuse that magnifies VTK's floors.

    Only the first tier has a floor, of 1e-6, under the diffuse factor; only without light is there full diffuse.
    """
    mesh = pv.PolyData([[0.0, 0.0, 0.0]])
    mesh.point_data.active_normals = [[0.0, 0.0, -1.0]]
    material = Material(ambient=0.0, diffuse=1e6)
    color = vtk_shade(mesh, lights, material, Viewer(position=(0.0, 0.0, 5.0)))[0, 0]
    return {0.0: "lit", 1.0: "headlight", 1e6: "unlit"}[round(float(color), 3)]


@pytest.mark.parametrize("on", list(itertools.product((True, False), repeat=2)))
@pytest.mark.parametrize("kinds", list(itertools.product(range(4), repeat=2)))
def test_the_tier_is_the_one_that_vtk_draws(kinds, on):
    lights = [replace(KINDS[kind], on=shines) for kind, shines in zip(kinds, on, strict=True)]
    assert drawn_tier(lights) == {0: "unlit", 1: "headlight"}.get(vtk_tier(lights), "lit")


# --- terms --------------------------------------------------------------------------------------------------------

PLASTIC = Material(ambient=(0.1, 0.2, 0.3), diffuse=0.5, specular=0.4, shininess=20.0, emission=(0.0, 0.1, 0.0))
EYE = Viewer(position=(2.0, 0.0, 0.0), up=(0.0, 0.0, 1.0))
MIDDLE, SIZE = np.array([0.5, 0.0, 0.0]), 4.0


def test_the_nearest_to_blinn_phong_and_to_powers_beyond_vtks_is_of_phong_with_a_power_that_it_has():
    spot = SpotLight(exponent=200.0)
    scene = Scene([spot], EYE, LightModel(reflection="blinn-phong"))
    for power, nearest in ((20.0, 5.0), (1000.0, 128.0)):
        with pytest.raises(InexpressibleError) as error:
            refuse_inexpressible(scene, replace(PLASTIC, shininess=power), None)
        assert error.value.material == replace(PLASTIC, shininess=nearest)
        assert error.value.scene == Scene([replace(spot, exponent=128.0)], EYE, LightModel())


def test_the_nearest_light_has_highlights_of_its_diffuse_colour_and_no_ambient_of_its_own():
    scene = Scene([replace(SUN, ambient=0.25, intensity=2.0), replace(BULB, ambient=0.5, specular="red")], EYE)
    with pytest.raises(InexpressibleError) as error:
        refuse_inexpressible(scene, PLASTIC, None)
    assert error.value.scene.lights == (replace(SUN, intensity=2.0, ambient=0.0), replace(BULB, ambient=0.0))
    assert error.value.scene.light_model.ambient == (0.7, 0.7, 0.7)  # 0.2, and that of a light that is even
