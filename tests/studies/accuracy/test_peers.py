"""Others' ways to light a mesh, as peers: which meshes and scenes they can stand for, and their colours."""

from contextlib import ExitStack
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.shading.equation import assemble
from pvphong.studies.accuracy import peers
from pvphong.studies.accuracy.peers import height_field, hillshading, textbook_colors
from pvphong.studies.accuracy.result import Errors
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
        ([ph.SphereLight(position=(0, 0, 3), radius=0.5)], ph.LightModel(), None, r"lights\[0\] must be one that the"),
        ([], ph.LightModel(shadows=True), None, "for the textbook formula"),
        ([], ph.LightModel(), ph.OrenNayar(20), "reflectance must be None for the textbook formula"),
    ],
)
def test_the_textbook_knows_one_model(lights, model, reflectance, message):
    with pytest.raises(ValueError, match=message):
        textbook_colors(np.eye(3), np.eye(3), ph.Scene(lights, light_model=model), ph.Material(reflectance=reflectance))


# --- Matplotlib's `LightSource`

SUN = ph.DirectionalLight(direction=(1, -2, -2), diffuse=(0.8, 0.6, 0.4), ambient=0.1)
SCENE = ph.Scene([SUN], ph.Viewer(position=(0, 0, 9)))
MATT = ph.Material(ambient=0.1, diffuse=(0.5, 0.9, 0.7), emission=0.05)
X, Y = np.meshgrid(np.arange(-8, 9) / 8, np.arange(4, 21) / 4, indexing="ij")
"""Steps of 1/8 and 1/4, which floats hold exactly."""


def grid(z):
    """A structured grid, and its points and normals."""
    mesh = pv.StructuredGrid(X, Y, z).extract_surface(algorithm="dataset_surface")
    return mesh.points, mesh.phong.normals()


def dome():
    return (4.0 - X**2 - (Y / 4) ** 2) / 4


def colors(points, normals, scene=SCENE, material=MATT, matrix=None):
    field = height_field(points, normals, matrix)
    shown = hillshading(field, assemble(scene, material, matrix))()
    result = np.empty((len(points), 3))
    result[field.vertices.ravel()] = shown.reshape(-1, 3)
    return result


@pytest.mark.parametrize("slopes", [(0.25, -0.5), (-1.0, 0.75), (0.0, 0.0)])
def test_on_a_plane_it_gives_the_lit_colours(slopes):
    points, normals = grid(slopes[0] * X + slopes[1] * Y + 3)
    lit = ph.evaluate(points, normals, SCENE, MATT, precision="float64").rgb
    np.testing.assert_allclose(colors(points, normals), lit, atol=1e-6)


def test_on_a_dome_brightness_is_stretched():
    points, _ = grid(dome())
    x, y = points[:, 0].astype(float), points[:, 1].astype(float)
    inner = (abs(x) < 0.99) & (y > 1.01) & (y < 4.99)  # at the border differences are one-sided
    normals = np.stack([x / 2, y / 32, np.ones_like(x)], axis=1)  # of the dome: minus its slopes, and 1
    cosine = normals @ np.array([-1, 2, 2]) / 3 / np.linalg.norm(normals, axis=1)
    shown = colors(points, normals)
    brightness = (shown - shown.min(axis=0)) / np.ptp(shown, axis=0)
    slope, offset = np.polyfit(cosine[inner], brightness[inner, 0], 1)
    np.testing.assert_allclose(slope * cosine[inner] + offset, brightness[inner, 0], atol=1e-6)
    constant = 0.05 + 0.1 * 0.2 + 0.1 * 0.1  # emission, ambient light, the sun's ambient light
    np.testing.assert_allclose(shown.min(axis=0), constant, atol=1e-9)
    np.testing.assert_allclose(shown.max(axis=0), constant + np.multiply(MATT.diffuse, SUN.diffuse), atol=1e-9)


def test_a_matrix_can_make_it_a_height_field():
    points, normals = grid(dome())
    turned = np.array([[0, 0, 1.0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    back = np.linalg.inv(turned)
    with pytest.raises(ValueError, match="regular grid"):
        height_field(points @ turned[:3, :3].T, normals @ turned[:3, :3].T)
    found = colors(points @ turned[:3, :3].T, normals @ turned[:3, :3].T, matrix=back)
    np.testing.assert_allclose(found, colors(points, normals), atol=1e-9)


def put(array, place, value):
    changed = array.copy()
    changed[place] = value
    return changed


SPOILT = {
    "without a corner": lambda p, n: (p[1:], n[1:]),
    "one aside": lambda p, n: (put(p, (20, 0), p[20, 0] + 0.01), n),
    "stretched": lambda p, n: (put(p, np.s_[:, 1], p[:, 1] ** 2), n),
    "one over another": lambda p, n: (np.vstack([p, p[0] + (0, 0, 1)]), np.vstack([n, n[0]])),
    "diagonal": lambda p, n: (np.repeat(np.arange(len(p)), 3).reshape(-1, 3), n),
    "a single line": lambda p, n: (p[p[:, 1] == p[0, 1]], n[p[:, 1] == p[0, 1]]),
    "not finite": lambda p, n: (put(p, (3, 2), np.nan), n),
    "below": lambda p, n: (p, -n),
}


@pytest.mark.parametrize("spoilt", SPOILT)
def test_other_vertices_are_refused(spoilt):
    reason = {"not finite": "not finite", "below": "point up"}.get(spoilt, "regular grid")
    with pytest.raises(ValueError, match=reason):
        height_field(*SPOILT[spoilt](*grid(dome())))


@pytest.mark.parametrize(
    ("scene", "material", "reason"),
    [
        (replace(SCENE, lights=[]), MATT, "one directional light"),
        (replace(SCENE, lights=[SUN, SUN]), MATT, "one directional light"),
        (replace(SCENE, lights=[ph.PointLight(position=(0, 0, 9))]), MATT, "one directional light"),
        (SCENE, replace(MATT, specular=0.1), "no highlights"),
        (replace(SCENE, light_model=ph.LightModel(two_sided=True)), MATT, "one side"),
    ],
)
def test_other_scenes_are_refused(scene, material, reason):
    with pytest.raises(ValueError, match=reason):
        colors(*grid(dome()), scene=scene, material=material)


def test_the_report_has_it_as_a_peer_with_its_error():
    mesh = pv.StructuredGrid(X, Y, dome())
    report = ph.tradeoff(mesh, SCENE, MATT, seconds=2)
    (row,) = [row for row in report.rows if row.name == "Matplotlib LightSource"]
    assert row.is_peer
    assert (row.kind, row.points) == ("light model", X.size)
    points, normals = grid(dome())
    error = np.abs(colors(points, normals) - ph.evaluate(points, normals, SCENE, MATT, precision="float64").rgb).max()
    assert row.light_model.largest == pytest.approx(error, rel=1e-6) != 0.0
    assert report.best(10.0) is not row


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
        assert len(peers.vtk_frames(square, subject, stack)) == 2
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
