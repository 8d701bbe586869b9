"""`plotter.phong.add_mesh` takes PyVista's keywords and draws the same as `plotter.add_mesh` in the same lights."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples

import pvphong as ph

SIZE = (180, 180)


def ball():
    """Return a mesh with arrays of all kinds, fine enough to ignore interpolation."""
    mesh = pv.Icosphere(nsub=5)
    x, y, z = mesh.points.T
    mesh["z"], mesh["v"], mesh["positive"] = z.copy(), mesh.points.copy(), z + 0.51
    mesh["holes"] = np.where(z > 0.2, np.nan, z)
    mesh["flags"], mesh["steps"] = x > 0, np.round(4 * y)
    mesh["paint"] = np.rint(255 * (mesh.points + 0.5)).astype(np.uint8)
    mesh["paint_rgb"] = mesh["paint"] / 255.0
    mesh["glass"] = np.column_stack([mesh["paint"], np.full(mesh.n_points, 90, np.uint8)])
    mesh.cell_data["x of faces"] = mesh.cell_centers().points[:, 0]
    mesh.texture_map_to_sphere(inplace=True)
    mesh.set_active_scalars(None)
    return mesh


BALL = ball()
SMOOTH_IMAGE = np.rint(127.5 + 127.5 * np.sin(np.add.outer(np.arange(64) / 20, np.arange(64) / 20)))[..., None]
CHECKS = pv.numpy_to_texture(np.repeat(SMOOTH_IMAGE, 3, axis=2).astype(np.uint8))

KEYWORDS = {
    "none": {},
    "color": {"color": "tan"},
    "a colour with an opacity": {"color": "#d2b48c80"},
    "ambient, diffuse": {"color": "w", "ambient": 0.3, "diffuse": 0.5},
    "specular": {"color": "navy", "specular": 0.8, "specular_power": 15},
    "specular alone": {"color": "navy", "specular": 0.4},
    "pbr": {"color": "gold", "pbr": True, "metallic": 0.6, "roughness": 0.4},
    "pbr alone": {"pbr": True},
    "scalars": {"scalars": "z"},
    "scalars, no bar": {"scalars": "z", "show_scalar_bar": False},
    "an array": {"scalars": np.array(BALL["z"])},
    "cmap": {"scalars": "z", "cmap": "terrain", "clim": (-0.3, 0.4)},
    "colormap, rng": {"scalars": "z", "colormap": "plasma", "rng": (-1, 1)},
    "clim": {"scalars": "z", "clim": 0.5},
    "flip_scalars": {"scalars": "z", "flip_scalars": True, "show_scalar_bar": False},
    "log_scale": {"scalars": "positive", "log_scale": True, "clim": (0.1, 1)},
    "nan_color": {"scalars": "holes", "nan_color": "red"},
    "vectors": {"scalars": "v", "component": 1},
    "annotations": {"scalars": "z", "annotations": {0.0: "zero"}},
    "scalar_bar_args": {"scalars": "z", "scalar_bar_args": {"title": "height", "vertical": True}},
    "rgb": {"scalars": "paint", "rgb": True},
    "by its name": {"scalars": "paint_rgb"},
    "rgba": {"scalars": "glass", "rgba": True},
    "texture": {"texture": CHECKS},
    "faces": {"scalars": "x of faces"},
    "faces first": {"scalars": "x of faces", "preference": "cell", "cmap": "bwr"},
    "smooth_shading": {"color": "w", "smooth_shading": True},
    "flat": {"color": "w", "smooth_shading": False},
    "split_sharp_edges": {"color": "w", "smooth_shading": True, "split_sharp_edges": True, "feature_angle": 20},
    "opacity": {"color": "w", "opacity": 0.4},
    "use_transparency": {"color": "w", "opacity": 0.4, "use_transparency": True},
    "opacity by scalars": {"scalars": "z", "opacity": "linear"},
    "opacity by numbers": {"scalars": "z", "opacity": [0.1, 0.9, 0.4]},
    "nan_opacity": {"scalars": "holes", "nan_opacity": 0.2},
    "lighting": {"color": "tan", "lighting": False},
    "style": {"color": "tan", "style": "wireframe", "lighting": False},
    "show_edges": {"color": "tan", "show_edges": True, "edge_color": "blue"},
    "culling": {"color": "tan", "culling": "front"},
    "show_vertices": {"color": "tan", "show_vertices": True},
    "user_matrix": {"color": "tan", "user_matrix": np.diag([1.0, 0.5, 1.5, 1.0])},
    "label": {"color": "tan", "label": "a ball"},
    "silhouette": {"color": "tan", "silhouette": {"color": "red", "line_width": 3}},
    "copy_mesh": {"scalars": "z", "copy_mesh": True},
    "all of a plot": {"scalars": "z", "cmap": "coolwarm", "clim": (-0.4, 0.4), "specular": 0.5, "specular_power": 9},
    "all of a part": {"color": "orange", "show_edges": True, "ambient": 0.2, "smooth_shading": True, "opacity": 0.8},
    "all of a field": {"scalars": "holes", "cmap": "jet", "nan_color": "w", "show_edges": True, "n_colors": 200},
}


def drawn(mesh, keywords, *, is_lit):
    plotter = pv.Plotter(off_screen=True, window_size=SIZE)
    try:
        plotter.phong.light_model = ph.LightModel.vtk()
        if is_lit:
            plotter.phong.add_mesh(mesh, **keywords)
        else:
            plotter.add_mesh(mesh.copy(), **keywords)  # PyVista may add arrays to the mesh
        return plotter.screenshot(return_img=True).astype(int)
    finally:
        plotter.close()


def difference(mesh, keywords):
    found, expected = (drawn(mesh, keywords, is_lit=is_lit) for is_lit in (True, False))
    assert len(np.unique(expected.reshape(-1, 3), axis=0)) > 1
    return np.abs(found - expected).max(axis=2)


@pytest.mark.parametrize("keyword", KEYWORDS)
def test_it_draws_what_pyvista_draws(keyword):
    """Pixels of the outline may differ, because of rasterisation."""
    before = BALL.copy()
    off = difference(BALL, KEYWORDS[keyword])
    assert np.percentile(off, 99.0) <= 3
    assert (off > 8).mean() < (0.02 if "nan" in keyword else 0.007)  # colours blend at the edges of holes
    assert before == BALL


BLOCKS = pv.MultiBlock({"a": pv.Sphere(), "b": pv.Cube(center=(1.5, 0, 0)), "c": pv.Cone(center=(3, 0, 0))})
HIGH = pv.MultiBlock(
    [pv.Sphere(center=(2 * k, 0, k)).elevation(low_point=(0, 0, -1), high_point=(0, 0, 3)) for k in range(3)]
)
OTHERS = {
    "blocks": (BLOCKS, {}),
    "blocks in one colour": (BLOCKS, {"color": "orange", "specular": 0.5, "specular_power": 20}),
    "blocks in many colours": (BLOCKS, {"multi_colors": True}),
    "blocks by scalars": (HIGH, {"cmap": "terrain"}),
    "hexahedra by faces": (examples.load_hexbeam(), {"scalars": "sample_cell_scalars", "show_edges": True}),
    "active scalars": (examples.load_random_hills(), {}),
    "contours": (pv.Wavelet().contour([100, 150]), {}),
    "airplane": (examples.load_airplane(), {"color": "tan", "show_edges": True}),
    "a grid": (pv.Wavelet(), {"opacity": 0.3}),
    "points that are lit": (pv.Sphere().glyph(geom=pv.Cube(), orient=False, scale=False, factor=0.05), {"color": "r"}),
}


@pytest.mark.parametrize("mesh", OTHERS)
def test_so_it_does_with_blocks_and_grids(mesh):
    off = difference(*OTHERS[mesh])
    assert np.percentile(off, 99.0) <= 6
    assert (off > 16).mean() < 0.004


def test_every_keyword_of_pyvista_is_tried_or_refused_or_passed_on():
    passed = {
        "line_width",
        "name",
        "render",
        "reset_camera",
        "pickable",
        "static",
        "force_opaque",
        "edge_opacity",
        "point_size",
    }
    passed |= {"remove_existing_actor", "render_points_as_spheres", "render_lines_as_tubes", "point_shape"}
    tried = {name for keywords in KEYWORDS.values() for name in keywords} | {"below_color", "above_color"}
    tried |= {"interpolate_before_map", "multi_colors", "categories"}
    refused = {"backface_params", "emissive"}
    known = set(inspect.signature(pv.Plotter.add_mesh).parameters) - {"self", "mesh", "kwargs"}
    assert known <= tried | refused | passed


def test_what_is_beyond_the_limits_has_its_colour_in_picture_and_bar():
    keywords = {"scalars": "z", "clim": (-0.2, 0.2), "below_color": "k", "above_color": "w", "smooth_shading": True}
    off = difference(BALL, keywords)
    assert np.percentile(off, 97.0) <= 3  # unlike PyVista's, colours blend at the limits


def test_edits_of_the_scalars_show_and_the_limits_stay():
    mesh = BALL.copy()
    plotter = pv.Plotter(off_screen=True, window_size=SIZE)
    plotter.phong.add_mesh(mesh, scalars="z", lighting=None)
    before = plotter.screenshot(return_img=True)
    mesh["z"] = 0.5 * mesh["z"]
    plotter.render()
    after = plotter.screenshot(return_img=True)
    assert list(plotter.scalar_bars.keys()) == ["z"]
    assert (before != after).any()
    assert plotter.phong.mesh(next(iter(plotter.actors.values()))).albedo.clim == pytest.approx((-1, 1))
    plotter.close()


BAD = {
    "no colour": ({"color": "redd"}, ValueError, r"^color must be .*; got redd. Did you mean 'red'"),
    "no edge's": ({"edge_color": "blu"}, ValueError, r"^edge_color must be .*; got blu. Did you mean 'blue'"),
    "no style": ({"style": "surfac"}, ValueError, r"^style must be .*Did you mean 'surface'"),
    "a path": (
        {"texture": "earth.jpg"},
        ValueError,
        r"^texture must be a .*read_texture\('earth.jpg'\)",
    ),
    "misspelt": ({"colour": "red"}, TypeError, r"^add_mesh has no keyword 'colour'. Did you mean 'color'"),
    "a material's": (
        {"albedo": "z"},
        TypeError,
        r"^add_mesh has no keyword 'albedo'. Pass material=Material\(albedo=...\)",
    ),
    "not a number": ({"specular": "red"}, ValueError, r"^specular must be a finite number; got red"),
    "two say it": (
        {"material": ph.Material(), "color": "red"},
        ValueError,
        r"^color must be omitted when material= is given",
    ),
    "no array": ({"scalars": "zz"}, ValueError, r"^add_mesh's scalars must be the name of .*Did you mean 'z'"),
    "cmap": ({"scalars": "z", "cmap": "terain"}, ValueError, r"^cmap must be .*Did you mean 'terrain'"),
    "clim": ({"scalars": "z", "clim": (1, 0)}, ValueError, r"^clim must be two finite numbers"),
    "rows": ({"scalars": np.arange(7)}, ValueError, r"must be an array with one row per point .* got 7 rows"),
    "back faces": (
        {"backface_params": {"color": "r"}},
        ValueError,
        r"^backface_params must be omitted for a lit .*two_sided",
    ),
    "texture and scalars": ({"texture": CHECKS, "scalars": "z"}, ValueError, r"^texture must be omitted when scalars="),
    "rgb of numbers": (
        {"scalars": "z", "rgb": True},
        ValueError,
        r"^scalars must be an array of shape \(n, 3\) or \(n, 4\)",
    ),
    "opacity": (
        {"color": "r", "opacity": np.ones(7)},
        ValueError,
        r"^opacity must be a number, or an array with one for each",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_keywords_are_refused_in_one_line_and_nothing_is_drawn(what):
    keywords, kind, message = BAD[what]
    plotter = pv.Plotter(off_screen=True)
    with pytest.raises(kind, match=message) as caught:
        plotter.phong.add_mesh(BALL, **keywords)
    assert "\n" not in str(caught.value)
    assert not plotter.actors
    assert not plotter.scalar_bars
    plotter.close()


@pytest.mark.parametrize("keyword", ["diffuse", "ambient", "specular", "color", "cmap"])
def test_colours_that_are_lit_already_are_not_lit_twice(keyword):
    lit = BALL.phong.shade(ph.DirectionalLight())
    plotter = pv.Plotter(off_screen=True)
    for draw in (plotter.phong.add_lit, lambda mesh, **how: mesh.phong.plot(off_screen=True, **how)):
        with pytest.raises(ValueError, match=f"^option must be .*; got {keyword}"):
            draw(lit, **{keyword: 0.1})
    plotter.close()
