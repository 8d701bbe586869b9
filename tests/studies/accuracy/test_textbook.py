"""The textbook's NumPy as a peer: it gives the same colours."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.textbook import textbook_colors


def scenes():
    lights = [
        ph.DirectionalLight(direction=(1, -2, -3), diffuse=(0.5, 0.4, 0.3), ambient=0.1),
        ph.PointLight(position=(2, 1, 3), attenuation=(1, 0.1, 0.2), specular=(0.3, 0.5, 0.1), intensity=0.8),
        ph.SpotLight(position=(0, 0, 4), direction=(0.1, 0, -1), cone_angle=25, exponent=3),
        ph.DirectionalLight(frame="headlight", diffuse=0.1),
        ph.PointLight(on=False),
    ]
    viewer = ph.Viewer(position=(1, -3, 4), up=(0, 0, 1))
    for reflection, local, two_sided in product(("phong", "blinn-phong"), (True, False), (True, False)):
        model = ph.LightModel(reflection=reflection, local_viewer=local, two_sided=two_sided)
        yield ph.Scene(lights=lights, viewer=viewer, light_model=model)
    yield ph.Scene(lights=lights, viewer=replace(viewer, parallel=True), light_model=ph.LightModel(clamp=False))


@pytest.mark.parametrize("scene", list(scenes()), ids=lambda scene: str(scene.light_model))
def test_the_textbook_agrees_with_the_evaluator(scene):
    mesh = pv.ParametricTorus(u_res=40, v_res=40)
    material = ph.Material(diffuse=(0.4, 0.5, 0.6), specular=0.5, shininess=12, emission=(0.0, 0.1, 0.0))
    matrix = np.eye(4)
    matrix[:3] = [[1, 0.5, 0, 0.2], [0, 2, 0, 0], [0.1, 0, 1, -0.3]]
    for given in (None, matrix):
        subject = Subject(mesh.points, mesh.point_normals, scene, material, given)
        colors = textbook_colors(mesh.points, mesh.point_normals, scene, material, given)
        assert np.ptp(colors) > 0.3
        np.testing.assert_allclose(colors, subject.truth, atol=1e-9)


def test_the_textbook_knows_one_convention():
    with pytest.raises(ValueError, match="convention must be 'standard' for the textbook formula; got vtk"):
        textbook_colors(np.eye(3), np.eye(3), ph.Scene(light_model=ph.LightModel.vtk()), ph.Material())
