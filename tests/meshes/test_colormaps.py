"""Colormaps: equality with PyVista's colours, for points and cells of any mesh."""

from __future__ import annotations

import inspect
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from matplotlib import colormaps

import pvphong as ph
from pvphong.meshes import pictures
from pvphong.meshes.colormaps import colors_by, lookup_table, mapped, scalars_of
from pvphong.studio.lit_mesh import LitMesh, lit_meshes

UNLIT = {"ambient": 1.0, "diffuse": 0.0}
SCENE = ph.Scene([], ph.Viewer((3, -4, 4)), light_model=ph.LightModel(ambient=1.0))
RANDOM = np.random.default_rng(7)


def ball():
    mesh = pv.Sphere(theta_resolution=9, phi_resolution=7)
    mesh.clear_data()
    return mesh


def unlit(mesh, colormap, **options):
    """Return the colours without light, 0-255."""
    lit = mesh.phong.shade(SCENE, ph.Material(albedo=colormap, **UNLIT), precision="float64", **options)
    return np.rint(255.0 * lit["phong"]).astype(np.uint8)


SCALARS = {
    "height": lambda n: np.linspace(-1.0, 2.0, n),
    "with NaN": lambda n: np.where(np.arange(n) % 3, np.linspace(-1.0, 2.0, n), np.nan),
    "float32": lambda n: RANDOM.random(n).astype(np.float32),
    "integers": lambda n: np.arange(n) % 7,
    "bytes": lambda n: (np.arange(n) % 200).astype(np.uint8),
    "bools": lambda n: np.arange(n) % 3 == 0,
    "constant": lambda n: np.full(n, 3.0),
    "zeros": np.zeros,
    "vectors": lambda n: RANDOM.normal(size=(n, 3)),
}
OPTIONS = {
    "plain": {},
    "a range": {"clim": (-0.25, 1.0)},
    "a range around 0": {"clim": 1.0},
    "few": {"n_colors": 4},
    "colours": {"cmap": ["red", "g", "#112233"]},
    "of matplotlib": {"cmap": colormaps["coolwarm"]},
    "a table": {"cmap": pv.LookupTable("plasma", n_values=6, scalar_range=(0.0, 1.5), nan_color="red")},
    "logarithms": {"log_scale": True, "clim": (0.1, 2.0)},
    "logarithms of all": {"log_scale": True},
    "outside": {"clim": (0.0, 1.0), "below_color": "red", "above_color": "blue", "nan_color": "green"},
    "around": {"flip_scalars": True},
    "categories": {"categories": True},
    "three categories": {"categories": 3},
}


@pytest.mark.parametrize("options", OPTIONS)
def test_colours_are_those_that_add_mesh_draws(options, new_plotter):
    """Compare a row of squares for each array, one square per number, without light."""
    plotter, count, expected = new_plotter((4 * 32, 4 * len(SCALARS))), 32, []
    for row, (scalars, values) in enumerate(SCALARS.items()):
        numbers, how = values(count), OPTIONS[options]
        squares = pv.ImageData(dimensions=(count + 1, 2, 1), origin=(0, row, 0))
        expected.append(mapped("albedo", ph.Colormap(numbers, **how)))
        if options == "logarithms of all" and scalars in ("height", "with NaN"):  # VTK prints an error and goes on
            how = how | {"clim": (numbers[numbers > 0].min(), 2.0)}
        squares.cell_data["a"] = numbers
        plotter.add_mesh(squares, scalars="a", lighting=False, show_scalar_bar=False, **how)
    plotter.view_xy()
    plotter.enable_parallel_projection()
    plotter.camera.focal_point, plotter.camera.position = (16, len(SCALARS) / 2, 0), (16, len(SCALARS) / 2, 9)
    plotter.camera.parallel_scale = len(SCALARS) / 2
    assert np.array_equal(plotter.screenshot(return_img=True)[2::4, 2::4][::-1], expected)


def test_what_is_mapped_is_the_array_that_is_meant():
    mesh = ball()
    for scalars, values in SCALARS.items():
        mesh.point_data["a"], mesh.cell_data["a"] = values(mesh.n_points), values(mesh.n_cells)[::-1]
        for preference, data in (("point", mesh.point_data), ("cell", mesh.cell_data)):
            colormap = ph.Colormap("a", preference=preference)
            numbers, of_cells = scalars_of("albedo", colormap, mesh)
            assert of_cells == (preference == "cell")
            found = colors_by(lookup_table("albedo", colormap, numbers), numbers)
            assert np.array_equal(found, mapped("albedo", ph.Colormap(data["a"]))), scalars


def test_colours_of_faces_and_points_are_lit():
    mesh = ball()
    mesh.point_data["a"], mesh.cell_data["b"] = SCALARS["height"](mesh.n_points), SCALARS["height"](mesh.n_cells)
    assert np.array_equal(unlit(mesh, ph.Colormap("a")), mapped("albedo", ph.Colormap(mesh["a"])))
    flat = mesh.phong.shade(SCENE, feature_angle=0)
    corners = flat.regular_faces
    lit = unlit(mesh, ph.Colormap("b"), feature_angle=0)[corners]
    assert np.array_equal(lit, np.repeat(mapped("albedo", ph.Colormap(mesh["b"]))[:, None], 3, axis=1))


def test_one_column_of_several():
    mesh = ball()
    mesh["v"] = RANDOM.normal(size=(mesh.n_points, 3))
    mesh["y"] = mesh["v"][:, 1]
    assert np.array_equal(unlit(mesh, ph.Colormap("v", component=1)), unlit(mesh, ph.Colormap("y")))
    mesh["c"] = mesh["y"] + 1j
    assert np.array_equal(unlit(mesh, ph.Colormap("c")), unlit(mesh, ph.Colormap("y")))


def test_names_and_arrays_are_the_same_on_every_mesh():
    """This includes a volume, whose range includes the points inside."""
    grid = pv.ImageData(dimensions=(4, 4, 4))
    grid["a"] = RANDOM.random(grid.n_points)
    inside = 21  # a point that is not on the surface
    grid["a"][inside] = 9.0
    grid.cell_data["b"] = RANDOM.random(grid.n_cells)
    for name, angle in (("a", None), ("b", 0)):
        named, given = (unlit(grid, ph.Colormap(each), feature_angle=angle) for each in (name, np.asarray(grid[name])))
        assert np.array_equal(named, given)
        own = LitMesh(grid, ph.Material(albedo=ph.Colormap(name), **UNLIT), feature_angle=angle)
        own.refresh(SCENE)
        assert np.array_equal(own.drawn["phong"], named)
    surface = grid.extract_surface(algorithm=None)
    assert not np.array_equal(unlit(surface, ph.Colormap("a")), unlit(grid, ph.Colormap("a")))
    assert np.array_equal(unlit(surface, ph.Colormap("a", clim=(0, 9))), unlit(grid, ph.Colormap("a", clim=(0, 9))))


def test_sharp_edges_keep_the_colours_of_their_points():
    cube = pv.Cube().clean()
    cube["a"] = np.arange(cube.n_points)
    lit = cube.phong.shade(SCENE, ph.Material(albedo=ph.Colormap("a"), **UNLIT), feature_angle=30)
    colors = unlit(cube, ph.Colormap("a"))
    assert lit.n_points > cube.n_points
    assert np.array_equal(np.rint(255 * lit["phong"]).astype(int), colors[lit["pvphong_original_point"]])


@pytest.mark.parametrize("options", [{}, {"categories": True}, {"log_scale": True}, {"clim": (1, 3)}], ids=str)
def test_blocks_have_the_range_of_all(options):
    """One block has a single number, one another range, one no finite number, and one no such array."""
    low, high, none = ball(), ball(), ball()
    low["a"], high["a"], none["a"] = (
        np.full(low.n_points, 2.0),
        np.linspace(0.5, 9, low.n_points),
        np.full(low.n_points, np.nan),
    )
    blocks = pv.MultiBlock({"low": low, "inner": pv.MultiBlock({"high": high, "none": none}), "bare": ball()})
    colormap = ph.Colormap("a", "terrain", **options)
    materials = {"default": ph.Material(albedo=colormap, **UNLIT), "bare": ph.Material()}
    together = mapped("albedo", replace(colormap, scalars=np.concatenate([low["a"], high["a"], none["a"]])))
    count = low.n_points
    lit = blocks.phong.shade(SCENE, materials, precision="float64")
    shown = lit_meshes(blocks, materials, None)
    for start, path, mesh in (
        (0, "low", lit["low"]),
        (count, "inner/high", lit["inner"]["high"]),
        (2 * count, "inner/none", lit["inner"]["none"]),
    ):
        assert np.array_equal(np.rint(255 * mesh["phong"]), together[start : start + count])
        shown[path].refresh(SCENE)
        assert np.array_equal(shown[path].drawn["phong"], together[start : start + count])
    plans = blocks.phong.plan(SCENE, materials)
    assert len(plans) == 4
    with pytest.raises(ValueError, match=r"^block \['bare'\]: albedo's scalars must be the name"):
        blocks.phong.shade(SCENE, materials["default"])


def test_points_alone_have_colormaps_of_arrays():
    mesh = ball()
    mesh["a"] = SCALARS["height"](mesh.n_points)
    material = ph.Material(albedo=ph.Colormap(mesh["a"], "terrain"), **UNLIT)
    found = ph.evaluate(mesh.points, mesh.phong.normals(), SCENE, material, precision="float64").rgb
    assert np.array_equal(np.rint(255 * found), unlit(mesh, ph.Colormap("a", "terrain")))
    with pytest.raises(ValueError, match=r"^albedo must be a Colormap of an array if there is no mesh"):
        ph.evaluate(mesh.points, mesh.points, SCENE, replace(material, albedo=ph.Colormap("a")))


def test_a_window_follows_the_array():
    mesh = ball()
    mesh["a"] = SCALARS["height"](mesh.n_points)
    material = ph.Material(albedo=ph.Colormap("a", "terrain"), **UNLIT)
    shown = LitMesh(mesh, material)
    for edit in (lambda: None, lambda: mesh.point_data.set_array(mesh["a"][::-1] ** 2, "a")):
        edit()
        assert shown.refresh(SCENE)
        assert np.array_equal(shown.drawn["phong"], unlit(mesh, ph.Colormap("a", "terrain")))
        assert not shown.refresh(SCENE)
    mesh["a"][:4] = 7.0
    mesh.point_data["a"].VTKObject.Modified()
    assert shown.refresh(SCENE)
    assert np.array_equal(shown.drawn["phong"], unlit(mesh, ph.Colormap("a", "terrain")))


def test_a_lit_mesh_shows_the_scalar_bar_of_its_unlit_colours(tmp_path):
    hills, how = pv.examples.load_random_hills(), {"off_screen": True, "window_size": (300, 200), "show_axes": False}
    before, colormap = hills.copy(), ph.Colormap("Elevation", ["red", "blue"], above_color="lime", clim=(0, 7))
    lit = hills.phong.shade(SCENE, ph.Material(albedo=colormap))
    assert hills == before
    lit.save(tmp_path / "lit.vtp")
    plain = lit.phong.plot(show_scalar_bar=False, screenshot=True, **how)
    assert np.array_equal(
        plain,
        hills.phong.shade(SCENE, ph.Material(albedo=colormap)).plot(
            rgb=True, lighting=False, scalars="phong", screenshot=True, **how
        ),
    )
    for mesh in (
        lit,
        pv.read(tmp_path / "lit.vtp"),
        hills.phong.refine(SCENE, ph.Material(albedo=colormap), tolerance=2),
    ):
        bar = mesh.phong.plot(screenshot=True, **how)
        is_bar = (bar != plain).any(axis=2)
        assert not is_bar[: 200 - 60].any() or mesh is not lit
        assert {(255, 0, 0), (0, 0, 255), (0, 255, 0)} <= set(map(tuple, bar[-40:].reshape(-1, 3).tolist()))
    blocks = pv.MultiBlock([hills, hills]).phong.shade(SCENE, ph.Material(albedo=colormap))
    assert not np.array_equal(
        blocks.phong.plot(screenshot=True, **how), blocks.phong.plot(show_scalar_bar=False, screenshot=True, **how)
    )
    assert "phong_colormap" not in lit.phong.shade(SCENE).field_data
    lit.field_data["phong_colormap"] = "not what it was"
    assert np.array_equal(lit.phong.plot(screenshot=True, **how), plain)


def test_options_of_plot_are_known_where_a_bar_is_shown():
    """Options are distributed by name; all others go to `add_mesh`."""
    known = {*pictures._OF_PLOTTER, *pictures._OF_VIEW, *pictures._OF_SHOWING}
    assert set(inspect.signature(pv.plot).parameters) - {"var_item", "volume", "kwargs"} <= known
    lit = ball()
    lit["a"] = lit.points[:, 2].copy()
    lit = lit.phong.shade(SCENE, ph.Material(albedo=ph.Colormap("a")))
    how = {"cpos": "xz", "zoom": 0.5, "background": "navy", "text": "text", "anti_aliasing": "ssaa", "edl": True}
    how |= {"off_screen": True, "window_size": (90, 60), "screenshot": True, "show_edges": True, "show_grid": True}
    image = lit.phong.plot(scalar_bar_args={"position_y": 5.0}, parallel_projection=True, **how)
    plain = lit.phong.plot(show_scalar_bar=False, parallel_projection=True, **how)
    assert np.array_equal(image, plain), "a bar outside of the window"


def test_validate_has_vtk_draw_the_same_colours():
    mesh = pv.Sphere()
    mesh["a"] = mesh.points[:, 2].copy()
    material = ph.Material(albedo=ph.Colormap("a", "terrain"), specular=0.3, shininess=20)
    light = ph.DirectionalLight(direction=(-1, 2, -3))
    assert mesh.phong.validate(ph.Scene([light], light_model=ph.LightModel.vtk()), material).passed


@pytest.mark.parametrize(
    ("colormap", "message"),
    [
        (ph.Colormap("Elevaton"), r"^albedo's scalars must be the name of a point or cell array \(.*'Elevation'"),
        (
            ph.Colormap("both"),
            r"^albedo's scalars must be the name of one array.*; got 'both', the name of two arrays.*preference=",
        ),
        (ph.Colormap("empty"), r"^albedo's scalars must be finite in some rows if clim is omitted"),
        (ph.Colormap("rock"), r"^albedo's scalars 'rock' must be .*an array of strings.*np\.unique"),
        (ph.Colormap("below", log_scale=True), r"^albedo's scalars must be an array with numbers > 0 for log_scale"),
        (
            ph.Colormap(np.zeros(7)),
            r"^albedo's scalars must be an array with one row per point \(\d+\) or per cell \(\d+\); got 7 rows",
        ),
        (ph.Colormap("vector", component=3), r"^albedo's scalars 'vector': component must be less than 3"),
        (
            ph.Colormap("face"),
            r"^albedo must be an array with one row per point, because faces share points.*feature_angle=0",
        ),
    ],
)
def test_what_a_mesh_has_not_is_refused_in_one_line(colormap, message):
    mesh = ball()
    mesh["Elevation"], mesh["empty"] = SCALARS["height"](mesh.n_points), np.full(mesh.n_points, np.nan)
    mesh["below"] = -1.0 - mesh["Elevation"] ** 2
    mesh["vector"] = RANDOM.random((mesh.n_points, 3))
    mesh["rock"] = np.array(["lime", "gneiss"] * mesh.n_points)[: mesh.n_points]
    mesh.point_data["both"] = SCALARS["height"](mesh.n_points)
    mesh.cell_data["both"] = mesh.cell_data["face"] = SCALARS["height"](mesh.n_cells)
    before = mesh.copy()
    with pytest.raises(ValueError, match=message) as refused:
        unlit(mesh, colormap)
    assert "\n" not in str(refused.value)
    assert before == mesh
    unlit(mesh, ph.Colormap("both", preference="point"))
    assert (unlit(mesh, ph.Colormap("empty", clim=(0, 1))) == pv.Color(pv.global_theme.nan_color).int_rgb).all()
