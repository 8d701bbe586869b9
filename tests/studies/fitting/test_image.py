"""Colours read back from pictures, and the lights of VTK's own pictures."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from PIL import Image
from planted_lights import apart

import pvphong as ph
from pvphong.base.color import srgb_from_linear

BALL = pv.Sphere(theta_resolution=60, phi_resolution=60)
VIEWERS = {
    "perspective": ph.Viewer(position=(1, -3, 1.5), up=(0, 0, 1), view_angle=25, clipping_range=(1, 6)),
    "parallel": ph.Viewer(position=(1, -3, 1.5), up=(0, 0, 1), parallel=True, parallel_scale=0.7),
}


def picture_of_positions(viewer, size, shape=(1.0, 1.0)):
    """A picture of the unit sphere of radius 0.5 whose colours are its own points + 0.5, from the formula of rays."""
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, height - np.arange(height) - 0.5)
    right, up = (2 * x - width) / height, (2 * y - height) / height
    axes = viewer.axes
    eye, ahead = np.array(viewer.position), -axes[2]
    if viewer.parallel:
        s = viewer.parallel_scale
        o = eye + s * (right[..., None] * axes[0] + up[..., None] * axes[1])
        d = np.broadcast_to(ahead, o.shape)
    else:
        slope = np.tan(np.radians(viewer.view_angle / 2))
        d = slope * (right[..., None] * axes[0] + up[..., None] * axes[1]) + ahead
        d = d / np.linalg.norm(d, axis=-1, keepdims=True)
        o = np.broadcast_to(eye, d.shape)
    b = (o * d).sum(-1)
    inside = b * b - (o * o).sum(-1) + 0.25
    t = -b - np.sqrt(np.maximum(inside, 0.0))
    image = np.where(inside[..., None] > 0, o + t[..., None] * d + 0.5, 9.0)
    return image * shape[0]


@pytest.mark.parametrize("viewer", VIEWERS.values(), ids=VIEWERS)
def test_a_point_has_the_color_of_its_own_place(viewer):
    seen = ph.colors_from_image(BALL, picture_of_positions(viewer, (300, 200)), viewer)
    shown = np.isfinite(seen).all(axis=1)
    assert np.isnan(seen[~shown]).all()
    np.testing.assert_allclose(seen[shown], BALL.points[shown] + 0.5, atol=2e-3)
    to_eye = np.array(viewer.position) - BALL.points if not viewer.parallel else -np.array(viewer.view_direction)
    cosine = (BALL.point_normals * to_eye).sum(axis=1) / np.linalg.norm(np.atleast_2d(to_eye), axis=1)
    assert shown[cosine > 0.35].all()
    assert not shown[cosine < 0.1].any()


def test_hidden_points_and_points_outside_have_no_color():
    viewer, image = VIEWERS["perspective"], picture_of_positions(VIEWERS["perspective"], (300, 200))
    whole = np.isfinite(ph.colors_from_image(BALL, image, viewer)[:, 0])
    wall = pv.Plane(center=(0.4, -1.2, 0.7), direction=(0, 1, 0), i_size=0.5, j_size=9)
    part = np.isfinite(ph.colors_from_image(BALL, image, viewer, occluders=[wall])[:, 0])
    assert 0.05 < (whole & ~part).sum() / whole.sum() < 0.95
    assert not (part & ~whole).any()
    blocks = pv.MultiBlock({"ball": BALL, "wall": wall.triangulate()})
    both = ph.colors_from_image(blocks, image, viewer)
    np.testing.assert_array_equal(np.isfinite(both["ball"][:, 0]), part)
    near = replace(viewer, view_angle=8)
    cropped = np.isfinite(ph.colors_from_image(BALL, picture_of_positions(near, (300, 200)), near)[:, 0])
    assert cropped.sum() < whole.sum() / 2
    np.testing.assert_array_equal(cropped & whole, cropped)


def test_bytes_files_and_encodings(tmp_path):
    viewer = VIEWERS["perspective"]
    linear = np.clip(picture_of_positions(viewer, (300, 200)), 0, 1)
    exact = ph.colors_from_image(BALL, linear, viewer)
    octets = np.rint(linear * 255).astype(np.uint8)
    np.testing.assert_allclose(ph.colors_from_image(BALL, octets, viewer), exact, atol=0.5 / 255 + 1e-12)
    encoded = np.rint(srgb_from_linear(linear) * 255).astype(np.uint8)
    np.testing.assert_allclose(ph.colors_from_image(BALL, encoded, viewer, encoding="srgb"), exact, atol=0.005)
    Image.fromarray(octets).save(tmp_path / "view.png")
    from_file = ph.colors_from_image(BALL, tmp_path / "view.png", viewer)
    np.testing.assert_array_equal(from_file, ph.colors_from_image(BALL, octets, viewer))
    with_alpha = np.dstack([octets, np.full(octets.shape[:2], 255, np.uint8)])
    np.testing.assert_array_equal(ph.colors_from_image(BALL, with_alpha, viewer), from_file)


def test_the_lights_of_vtks_own_picture_come_back(new_plotter):
    """VTK's fragment shader, 8 bits a channel: directions within 1°, intensities within 2 %."""
    true = [
        ph.DirectionalLight(direction=(-3, 2, -2), intensity=0.5, name="key"),
        ph.DirectionalLight(direction=(3, 1, -1), intensity=0.3, diffuse=(1.0, 0.6, 0.4), name="rim"),
    ]
    plotter = new_plotter(size=(500, 400))
    for light in true:
        plotter.add_light(light.to_pyvista())
    look = {"ambient": 0.1, "diffuse": 0.8, "specular": 0.3, "specular_power": 20}
    plotter.add_mesh(BALL, color="white", smooth_shading=True, **look)
    plotter.camera_position = [(0, -3, 1), (0, 0, 0), (0, 0, 1)]
    seen = ph.colors_from_image(BALL, plotter.screenshot(return_img=True), plotter.camera)
    begin = [ph.DirectionalLight(name="key"), ph.DirectionalLight(name="rim", direction=(1, 1, 0))]
    scene = ph.Scene(begin, plotter.camera, ph.LightModel.vtk())
    material = ph.Material(ambient=0.1, diffuse=0.8, specular=0.3, shininess=20)
    fit = BALL.phong.fit(scene, material, seen, "intensity diffuse direction", tries=3)
    for one in true:
        found = min(fit.scene.lights, key=lambda light: apart(light, one)[1])
        assert apart(found, one)[1] < 1.0
        colors = found.intensity * np.array(found.diffuse)
        np.testing.assert_allclose(colors, one.intensity * np.ravel(one.diffuse), rtol=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"image": np.zeros((4, 4))}, r"image must be an array of shape \(height, width, 3\).*; got an array of shape"),
        (
            {"image": np.zeros((4, 4, 3), int)},
            r"image must be .*; got an array of int64\. Convert 0-255 values",
        ),
        ({"image": "no.txt"}, r"image must be the path of a picture, such as view\.png; got no\.txt"),
        ({"image": "no.png"}, r"image must be .* image file that exists"),
        ({"camera": 3}, r"camera must be a pyvista\.Camera or a vtkCamera; got 3"),
        (
            {"camera": ph.Viewer(position=(9, 9, 9), focal_point=(10, 9, 9))},
            r"camera must be a camera whose picture shows",
        ),
        ({"encoding": "rgb"}, r"encoding must be one of 'linear', 'srgb'; got rgb"),
        ({"mesh": pv.PolyData(np.eye(3))}, r"mesh must be a mesh with faces"),
        ({"mesh": 3}, r"mesh must be a pyvista\.DataSet or a pyvista\.MultiBlock; got int"),
    ],
)
def test_bad_input_is_refused(change, message):
    given = {"mesh": BALL, "image": np.zeros((20, 20, 3)), "camera": VIEWERS["perspective"]} | change
    with pytest.raises(ValueError, match=message):
        ph.colors_from_image(**given)


def test_colours_of_a_volume_are_a_target():
    grid = pv.ImageData(dimensions=(6, 6, 6))
    viewer = ph.Viewer(position=(12, 9, 14), focal_point=(2.5, 2.5, 2.5))
    seen = ph.colors_from_image(grid, np.full((80, 80, 3), 0.25), viewer)
    assert seen.shape == (grid.n_points, 3)
    is_inside = ((grid.points > 0.5) & (grid.points < 4.5)).all(axis=1)
    assert np.isnan(seen[is_inside]).all()
    fit = grid.phong.fit(ph.Scene([ph.DirectionalLight((-1, -1, -1))], viewer), ph.Material(), seen, "intensity")
    assert fit.error.rms < 0.05
