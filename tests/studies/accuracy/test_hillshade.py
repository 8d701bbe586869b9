"""Matplotlib's `LightSource` as a peer: which meshes and scenes it can stand for, and what comes of it."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.shading.equation import assemble
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


def without_a_corner(points, normals):
    return points[1:], normals[1:]


def one_aside(points, normals):
    moved = points.copy()
    moved[20, 0] += 0.01
    return moved, normals


def stretched(points, normals):
    moved = points.copy()
    moved[:, 1] = moved[:, 1] ** 2
    return moved, normals


def one_over_another(points, normals):
    above = points[0] + np.array([0, 0, 1])
    return np.vstack([points, above]), np.vstack([normals, normals[0]])


def diagonal(points, normals):
    return np.repeat(np.arange(len(points)), 3).reshape(-1, 3), normals


def a_single_line(points, normals):
    line = points[:, 1] == points[0, 1]
    return points[line], normals[line]


def not_finite(points, normals):
    lost = points.copy()
    lost[3, 2] = np.nan
    return lost, normals


def below(points, normals):
    return points, -normals


@pytest.mark.parametrize(
    ("spoilt", "reason"),
    [
        (without_a_corner, "regular grid"),
        (one_aside, "regular grid"),
        (stretched, "regular grid"),
        (one_over_another, "regular grid"),
        (diagonal, "regular grid"),
        (a_single_line, "regular grid"),
        (not_finite, "not finite"),
        (below, "point up"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_other_vertices_are_refused(spoilt, reason):
    with pytest.raises(ValueError, match=reason):
        height_field(*spoilt(*grid(dome())))


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


def test_the_report_says_why_it_is_left_out(monkeypatch):
    shiny = replace(MATT, specular=0.5, shininess=9)
    hills, ball = pv.StructuredGrid(X, Y, dome()), pv.Sphere(theta_resolution=8, phi_resolution=8)
    reasons = [ph.tradeoff(mesh, SCENE, look, seconds=1).left_out for mesh, look in ((hills, shiny), (ball, MATT))]
    assert [why["Matplotlib LightSource"] for why in reasons] == [
        "it knows no highlights",
        "it lights height fields: one point at each place of a regular grid in x and y",
    ]
    monkeypatch.setitem(sys.modules, "matplotlib.colors", None)
    why = ph.tradeoff(hills, SCENE, MATT, seconds=1).left_out["Matplotlib LightSource"]
    assert why == 'Matplotlib is not installed: pip install "pvphong[plot]"'
