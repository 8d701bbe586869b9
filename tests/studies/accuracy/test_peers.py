"""Others' ways to light a mesh, as peers: which meshes and scenes they can stand for, and their colours."""

from contextlib import ExitStack
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studies.accuracy import peers
from pvphong.studies.accuracy.peers import textbook_colors
from pvphong.studies.accuracy.result import NO_ERROR, Errors
from pvphong.studies.accuracy.variants import Subject

# --- a textbook's NumPy


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


@pytest.mark.parametrize(
    ("lights", "model", "reflectance", "message"),
    [
        ([], ph.LightModel.vtk(), None, "convention must be 'standard' for the textbook formula; got vtk"),
        (
            [ph.SphereLight(position=(0, 0, 3), radius=0.5)],
            ph.LightModel(),
            None,
            r"lights\[0\] must be a light that the",
        ),
        ([], ph.LightModel(shadows=True), None, "for the textbook formula"),
        ([], ph.LightModel(), ph.OrenNayar(20), "reflectance must be None for the textbook formula"),
    ],
)
def test_the_textbook_knows_one_model(lights, model, reflectance, message):
    with pytest.raises(ValueError, match=message):
        textbook_colors(np.eye(3), np.eye(3), ph.Scene(lights, light_model=model), ph.Material(reflectance=reflectance))


# --- VTK's frames

GREEN = ph.Material(ambient=0.1, diffuse=(0.2, 0.6, 0.3))
FACED = ph.Scene([ph.DirectionalLight(direction=(0, -1, -2))], ph.Viewer(position=(0, 0, 3), up=(0, 1, 0)))
COSINE, SINE = np.cos(np.radians(50.0)), np.sin(np.radians(50.0))
TILTED = np.array([[1.0, 0, 0, 0], [0, COSINE, -SINE, 0], [0, SINE, COSINE, 0], [0, 0, 0, 1]])


@pytest.fixture
def square():
    mesh = pv.Plane(i_resolution=4, j_resolution=4).triangulate()
    mesh.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (mesh.n_points, 1))
    return mesh


@pytest.mark.parametrize("matrix", [None, TILTED], ids=["as it is", "tilted"])
def test_both_frames_show_the_evaluated_colour(square, matrix, monkeypatch):
    subject = Subject(square.points, square.point_data.active_normals, FACED, GREEN, matrix)
    windows = []
    for name in ("window_lit_by_vtk", "window_of_colors"):
        make = getattr(peers, name)
        monkeypatch.setattr(peers, name, lambda *a, make=make, **how: windows.append(make(*a, **how)) or windows[-1])
    with ExitStack() as stack:
        assert len(peers.vtk_frames(square, subject, stack, NO_ERROR)) == 2
        for window in windows:
            image = window.screenshot(return_img=True) / 255
            middle = image[image.shape[0] // 2, image.shape[1] // 2]
            np.testing.assert_allclose(middle, subject.truth[0], atol=1.5 / 255)


def frames(square, scene, material, matrix=None, errors=None):
    subject = Subject(square.points, square.point_data.active_normals, scene, material, matrix)
    with ExitStack() as stack:
        found = peers.vtk_frames(square, subject, stack, errors)
        for variant in found:
            variant.run()
    return [variant.row for variant in found]


def test_frames_are_drawn_and_their_notes_say_by_what_and_what_was_changed(square):
    shiny, errors = replace(GREEN, specular=0.5, shininess=40), Errors(0.3, 0.2, 0.1, 9)
    changes = {"phong": "its error is 0 by definition", "blinn-phong": "drawn without Blinn-Phong"}
    for reflection, note in changes.items():
        scene = replace(FACED, light_model=ph.LightModel(reflection=reflection))
        per_pixel, lit_array = frames(square, scene, shiny, errors=errors)
        assert f"; {note}" in per_pixel.note
        assert per_pixel.error.largest == 0.0
        assert lit_array.error is errors
        assert per_pixel.is_peer
        assert lit_array.is_peer
    assert len(frames(square, FACED, shiny)) == 1
