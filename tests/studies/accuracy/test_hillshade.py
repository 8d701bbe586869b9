"""Matplotlib's `LightSource` as a peer: which meshes and scenes it can stand for, and what comes of it."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.shading.assembly import assemble
from pvphong.studies.accuracy.hillshade import height_field, hillshading

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


def test_the_order_of_the_vertices_does_not_matter():
    points, normals = grid(dome())
    order = np.random.default_rng(0).permutation(len(points))
    np.testing.assert_array_equal(colors(points[order], normals[order]), colors(points, normals)[order])


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


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.colors", None)
    with pytest.raises(ValueError, match=r'Matplotlib is not installed: pip install "pvphong\[plot\]"'):
        colors(*grid(dome()))


def test_the_report_says_why_it_is_left_out():
    report = ph.tradeoff(pv.Sphere(theta_resolution=8, phi_resolution=8), SCENE, MATT, seconds=1)
    why = "it lights height fields: one point at each place of a regular grid in x and y"
    assert report.left_out["Matplotlib LightSource"] == why
