"""Textures as albedo: compared with tent filters over a repeated image, and with VTK's rendering."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.meshes import point_data
from pvphong.meshes.point_data import texture_colors

WRAPS = {"CLAMP_TO_EDGE": "edge", "REPEAT": "wrap", "MIRRORED_REPEAT": "symmetric", "CLAMP_TO_BORDER": "constant"}
BORDER = (0.2, 0.4, 0.6)
WHITE = ph.Material(ambient=1.0, diffuse=0.0)
SCENE = ph.Scene([], ph.Viewer(), ph.LightModel(ambient=1.0))


def picture(channels=3, kind=np.uint8, height=5, width=7):
    values = np.random.default_rng(channels).random((height, width, channels))
    return (values * 255).astype(np.uint8) if kind == np.uint8 else values.astype(kind)


def texture_of(image, wrap="REPEAT", srgb=False):
    texture = pv.Texture(image)
    texture.wrap = pv.Texture.WrapType[wrap]
    texture.SetBorderColor(*BORDER, 1.0)
    texture.SetUseSRGBColorSpace(srgb)
    return texture


def decoded(x):
    return x / 12.92 if x <= 0.04045 else math.pow((x + 0.055) / 1.055, 2.4)


def by_tents(image, uv, wrap, srgb):
    """Sum the texels within one of the place with tent weights; the image is extended by three sizes on all sides."""
    texels = image[::-1].astype(float) / (255.0 if image.dtype == np.uint8 else 1.0)  # v goes up, rows go down
    texels = texels[..., :3] if texels.shape[2] > 2 else np.repeat(texels[..., :1], 3, axis=2)
    texels = np.vectorize(decoded)(texels) if srgb else texels
    height, width, _ = texels.shape
    around = ((3 * height,) * 2, (3 * width,) * 2)
    more = {"constant_values": np.nan} if wrap == "constant" else {}
    laid = np.stack([np.pad(texels[..., k], around, mode=wrap, **more) for k in range(3)], axis=-1)
    laid = np.where(np.isnan(laid), BORDER, laid)
    found = []
    for u, v in uv:
        across = np.maximum(1 - np.abs(np.arange(7 * width) - 3 * width + 0.5 - u * width), 0)
        up = np.maximum(1 - np.abs(np.arange(7 * height) - 3 * height + 0.5 - v * height), 0)
        found.append(np.einsum("i,j,ijk", up, across, laid))
    return np.array(found)


def with_coordinates(uv):
    mesh = pv.PolyData(np.zeros((len(uv), 3)))
    mesh.active_texture_coordinates = np.asarray(uv)
    return mesh


@pytest.mark.parametrize("srgb", [False, True])
@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize(("channels", "kind"), [(3, np.uint8), (1, np.uint8), (4, np.uint8), (3, np.float32)])
def test_it_is_a_sum_of_tents(channels, kind, wrap, srgb):
    image = picture(channels, kind)
    uv = np.random.default_rng(1).uniform(-2.4, 3.4, (300, 2))
    uv[:6] = [(0, 0), (1, 1), (-1, 2), (0.5 / 7, 0.5 / 5), (-1e-20, 1.0), (2.0, -1e-20)]
    none = [(np.nan, 0.5), (0.5, np.inf), (1e300, -1e300), (-(2.0**52), 0.1)]
    found = texture_colors(texture_of(image, wrap, srgb), with_coordinates([*uv, *none]))
    assert np.isnan(found[-4:-2]).all()  # NaN counts as 0, as in any albedo
    assert np.isfinite(found[-2:]).all()
    found = found[:-4]
    np.testing.assert_allclose(found, by_tents(image, uv, WRAPS[wrap], srgb), atol=1e-13)


@pytest.mark.parametrize("srgb", [False, True])
@pytest.mark.parametrize("wrap", WRAPS)
def test_vtk_draws_the_same(wrap, srgb):
    """Compare the pixels of a rectangle seen from the front; GPUs interpolate with about 8 bits between texels."""
    texture = texture_of(picture(), wrap, srgb)
    texture.interpolate = True
    plane = pv.Plane(i_resolution=1, j_resolution=1)
    low, high = -0.7, 1.8
    plane.active_texture_coordinates = low + (high - low) * plane.active_texture_coordinates
    plotter = pv.Plotter(off_screen=True, window_size=(100, 100))
    plotter.add_mesh(plane, texture=texture, lighting=False)
    plotter.enable_parallel_projection()
    plotter.view_xy()
    plotter.camera.parallel_scale = 0.5
    drawn = plotter.screenshot(return_img=True)[::-1] / 255.0
    plotter.close()
    steps = low + (high - low) * (np.arange(100) + 0.5) / 100
    uv = np.stack([*np.meshgrid(steps, steps)], axis=-1).reshape(-1, 2)
    found = texture_colors(texture, with_coordinates(uv)).reshape(100, 100, 3)
    assert np.abs(found - drawn).max() < 4 / 255
    other = texture_colors(texture_of(picture(), wrap, not srgb), with_coordinates(uv)).reshape(100, 100, 3)
    assert np.abs(other - drawn).max() > 0.1


@pytest.fixture
def sheet():
    return pv.Plane(i_resolution=20, j_resolution=10)


def test_a_window_follows_texture_image_and_coordinates(sheet):
    plotter = pv.Plotter(off_screen=True, lighting="none")
    plotter.phong.light_model = SCENE.light_model
    texture, image = texture_of(picture()), picture(3, np.uint8, 4, 4)
    live = plotter.phong.mesh(plotter.phong.add_mesh(sheet, replace(WHITE, albedo=texture)))

    def assert_current():
        plotter.render()
        expected = texture_colors(live.material.albedo.source, sheet)
        assert np.abs(live.drawn["phong"] / 255.0 - expected).max() < 0.003
        return live.drawn["phong"].copy()

    def changes(change):
        before, count = assert_current(), live.evaluations
        change()
        assert not np.array_equal(before, assert_current())
        assert live.evaluations == count + 1

    plotter.show(auto_close=False)
    changes(lambda: setattr(texture, "wrap", pv.Texture.WrapType.CLAMP_TO_EDGE) or texture.SetUseSRGBColorSpace(True))
    changes(lambda: texture.SetInputData(pv.Texture(image).to_image()))
    changes(lambda: setattr(sheet, "active_texture_coordinates", 2.0 * sheet.active_texture_coordinates))
    pixels = texture.GetInput().GetPointData().GetScalars()
    changes(lambda: pixels.Fill(9) or pixels.Modified() or texture.Modified())
    changes(lambda: setattr(live, "material", replace(WHITE, albedo=texture_of(picture(4)))))
    count = live.evaluations
    assert_current()
    assert live.evaluations == count
    plotter.close()


def test_what_is_no_texture_of_colours_and_a_mesh_without_coordinates_are_refused(sheet):
    mapped, lines = texture_of(picture(1)), sheet.copy()
    mapped.color_mode = "map"
    lines.GetPointData().SetTCoords(pv.convert_array(np.zeros(sheet.n_points), "u"))
    for mesh, texture, message in (
        (sheet, pv.Texture(), "a texture with a flat image; got a texture without a flat image"),
        (sheet, texture_of(picture(3, np.uint16)), "a texture of uint8 or floats; got a texture of uint16. Convert"),
        (sheet, texture_of(255.0 * picture(3, np.float64)), "floats from 0 to 1; .* Divide 0-255 values by 255"),
        (sheet, mapped, 'a texture of colours; got a texture with a lookup table.*, set texture.color_mode = "direct"'),
        (pv.Sphere(), texture_of(picture()), r"an array, .*; .* mesh.texture_map_to_plane\(\)"),
        (lines, texture_of(picture()), r"an array, .*; .* mesh.texture_map_to_plane\(\)"),
    ):
        with pytest.raises(ValueError, match=f"^albedo must be {message}"):
            mesh.phong.shade(SCENE, replace(WHITE, albedo=texture))


def test_many_points_are_looked_up_part_by_part(monkeypatch):
    uv = np.random.default_rng(3).uniform(-1.0, 2.0, (500, 2))
    texture, mesh = texture_of(picture(), "MIRRORED_REPEAT"), with_coordinates(uv)
    whole = texture_colors(texture, mesh)
    monkeypatch.setattr(point_data, "_AT_ONCE", 64)
    assert np.array_equal(texture_colors(texture, mesh), whole)
