"""Short forms of arguments: no scene, a light as scene, a camera as viewer, a target instead of a direction."""

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.meshes.files import save_lit
from pvphong.optics.lights import LIGHT_TYPES

MESH = pv.examples.load_airplane()
SHINY = ph.Material(specular=0.6, shininess=20)
SUN, LAMP = ph.DirectionalLight(direction=(-1, -2, -3)), ph.PointLight(position=(900, 500, 2000))
HEAD = ph.DirectionalLight(frame="headlight")


def camera_of(mesh):
    plotter = pv.Plotter(off_screen=True)
    try:
        plotter.add_mesh(mesh)
        plotter.show(auto_close=False)
        return plotter.camera.copy()
    finally:
        plotter.close()


@pytest.mark.parametrize(
    "mesh", [MESH, pv.Plane(i_size=3), pv.PolyData([[1.0, 2.0, 3.0]]), pv.Sphere(center=(1e6, 0, 0))]
)
def test_without_a_viewer_it_is_seen_as_pyvistas_camera_frames_it(mesh):
    viewer, camera = ph.Viewer.framing(mesh.bounds), ph.Scene(viewer=camera_of(mesh)).viewer
    np.testing.assert_allclose(viewer.position, camera.position, rtol=1e-6, atol=0)
    np.testing.assert_allclose(viewer.focal_point, camera.focal_point, rtol=1e-12, atol=1e-12)
    assert (viewer.up, viewer.view_angle) == (camera.up, camera.view_angle)
    assert viewer.parallel_scale == pytest.approx(camera.parallel_scale)


def test_no_box_at_all_counts_as_the_unit_cube_and_bounds_are_six_numbers():
    for bounds in (1, -1, 1, -1, 1, -1), (0, np.nan, 0, 1, 0, 1), (0, np.inf, 0, 1, 0, 1):
        assert ph.Viewer.framing(bounds) == ph.Viewer.framing((0, 1, 0, 1, 0, 1))
    with pytest.raises(ValueError, match=r"^bounds must be six numbers"):
        ph.Viewer.framing((0, 1))


MATRIX = np.array([[0, -2, 0, 5.0], [2, 0, 0, 0], [0, 0, 2, 1], [0, 0, 0, 1]])


@pytest.mark.parametrize("matrix", [None, MATRIX])
@pytest.mark.parametrize("spoiled", [False, True])
def test_the_viewer_of_what_is_lit_is_the_one_that_frames_it(matrix, spoiled):
    mesh = MESH.copy()
    framed = mesh.copy() if matrix is None else mesh.transform(matrix, inplace=False)
    if spoiled:
        mesh.points[7] = np.nan
    scene = ph.Scene([LAMP, HEAD])
    viewer = ph.Viewer.framing(framed.bounds)
    expected = mesh.phong.shade(ph.Scene([LAMP, HEAD], viewer), SHINY, matrix=matrix)["phong"]
    np.testing.assert_allclose(mesh.phong.shade(scene, SHINY, matrix=matrix)["phong"], expected, rtol=0, atol=1e-4)
    assert np.abs(expected - mesh.phong.shade(ph.Scene([LAMP, HEAD], ph.Viewer()), SHINY)["phong"]).max() > 0.1
    normals = mesh.phong.normals()
    by_hand = ph.evaluate(mesh.points, normals, scene, SHINY, matrix=matrix).rgb
    assert np.array_equal(by_hand, mesh.phong.shade(scene, SHINY, matrix=matrix)["phong"])


def test_no_scene_is_the_default_scene():
    assert np.array_equal(MESH.phong.shade()["phong"], MESH.phong.shade(ph.default_scene(MESH))["phong"])
    blocks = pv.MultiBlock([MESH])
    assert np.array_equal(blocks.phong.shade()[0]["phong"], MESH.phong.shade(ph.default_scene(blocks))["phong"])


GUEST = pv.Light(position=(1, 2, 3), light_type="scene light")


@pytest.mark.parametrize("given", [SUN, [SUN], (SUN,), (light for light in [SUN]), GUEST])
def test_lights_are_a_scene(given):
    own = ph.as_light(GUEST) if given is GUEST else SUN
    assert np.array_equal(MESH.phong.shade(given, SHINY)["phong"], MESH.phong.shade(ph.Scene([own]), SHINY)["phong"])


def test_lights_are_a_scene_everywhere():
    plane = pv.Plane(i_resolution=4, j_resolution=4)
    for result in (
        plane.phong.plan(SUN).explain(),
        plane.phong.validate([SUN]).passed,
        plane.phong.refine(SUN, tolerance=0.1).n_points,
        plane.phong.interpolation_error(SUN).n_points,
        ph.plan(plane, SUN, SHINY).explain(),
        ph.evaluate(plane.points, plane.points + 1.0, [SUN], SHINY).rgb.shape,
    ):
        assert result


def test_what_rides_along_needs_a_viewer():
    with pytest.raises(ValueError, match=r"^viewer must be a Viewer if lights move with it; .*framed"):
        _ = ph.Scene([HEAD]).world_lights
    scene = ph.Scene([HEAD]).framed(MESH.bounds)
    assert scene.world_lights[0].direction == pytest.approx(scene.viewer.view_direction)
    assert scene.framed((0, 1, 0, 1, 0, 1)) is scene


def test_at_a_target():
    spot = ph.SpotLight.at((1, 2, 3), target=(1, 2, 0), cone_angle=12, name="desk")
    assert spot == ph.SpotLight(position=(1, 2, 3), direction=(0, 0, -3), cone_angle=12, name="desk")
    assert ph.DirectionalLight.at((0, 5, 0), target=(0, 0, 0)) == ph.DirectionalLight(direction=(0, -5, 0))
    both = [kind for kind in LIGHT_TYPES.values() if {"position", "direction"} <= kind.__dataclass_fields__.keys()]
    assert len(both) == 4
    for kind in (*both, ph.DirectionalLight):
        with pytest.raises(ValueError, match=r"^target must be different from position"):
            kind.at((1, 2, 3), target=(1, 2, 3))


def test_a_sun_stands_where_the_compass_says():
    sun = ph.DirectionalLight.from_angles
    for azimuth, towards in ((0, (0, -1, 0)), (90, (-1, 0, 0)), (180, (0, 1, 0)), (-90, (1, 0, 0)), (630, (1, 0, 0))):
        assert sun(azimuth, 0, name="sun") == ph.DirectionalLight(direction=towards, name="sun")
        assert sun(azimuth, 90).direction == (0, 0, -1)
        up = np.degrees(np.arcsin(-sun(azimuth + 17.0, 20.0).direction[2]))
        assert up == pytest.approx(20)
    x, y, z = sun(315, 45).direction
    assert (x, y, z) == pytest.approx((0.5, -0.5, -(0.5**0.5)))
    with pytest.raises(ValueError, match=r"^elevation must be a finite number >= -90"):
        sun(0, 91)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: ph.Material(color="red"),
            r"^color must be given as diffuse=; got red\. Use Material\(diffuse='red'\)\.",
        ),
        (lambda: ph.PointLight(colour=1), r"^colour must be given as diffuse=; got 1\. Use PointLight\(diffuse=1\)\."),
        (lambda: ph.Material(difuse=1), r"^Material has no 'difuse'\. Did you mean 'diffuse'"),
        (lambda: ph.LightModel(shadow=True), r"^LightModel has no 'shadow'\. Did you mean 'shadows'\?"),
        (lambda: ph.Viewer(eye=(0, 0, 1)), r"^Viewer has no 'eye'\. It has position, "),
        (lambda: MESH.phong.shade(pv.Plotter(off_screen=True)), r"Scene\.from_plotter\(plotter\)"),
        (lambda: ph.EnvironmentLight("sky.hdr"), r"Read .*EnvironmentLight\(pv\.read_texture\('sky\.hdr'\)\)"),
        (lambda: MESH.phong.shade(pv.Camera()), r"Scene\(lights, viewer=camera\)"),
        (lambda: pv.MultiBlock([MESH, MESH]).phong.shade(None, ["gold", "jade"]), r"dict\(zip\(blocks\.keys\(\), "),
    ],
)
def test_habits_are_answered_with_what_to_write(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def test_ready_made_lights_are_public():
    assert [light.name for light in ph.three_point(MESH)] == ["key", "fill", "rim"]
    assert ph.three_point(MESH) == ph.three_point(MESH, ph.Viewer.framing(MESH.bounds))
    assert ph.light_kit()[0].name == "head"
    assert MESH.phong.shade(ph.three_point(MESH))["phong"].any()


def plotted(what, **options):
    """Return the middle pixel of a plot."""
    size = {"off_screen": True, "return_img": True, "screenshot": True, "window_size": (40, 40)}
    return np.asarray(what.phong.plot(**size, **options))[20, 20]


def shot(begin):
    """Return the middle pixel of a window."""
    plotter = pv.Plotter(off_screen=True, window_size=(40, 40))
    begin(plotter.phong)
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    return picture[20, 20]


def test_lit_meshes_are_drawn_in_their_colours():
    lit = pv.Plane(direction=(1, 1, 1)).phong.shade(SUN, ph.Material(ambient=0, diffuse=(0.2, 0.5, 0.8)))
    for what in (lit, pv.MultiBlock([lit])):
        np.testing.assert_allclose(plotted(what), 255 * lit["phong"][0], atol=1.5, rtol=0)
    with pytest.raises(ValueError, match=r"^name must be one of"):
        lit.phong.plot(name="fong")
    for what in (pv.Plane(), pv.MultiBlock([lit, pv.Plane()])):
        remedy = r"mesh\.phong\.shade\(\.\.\.\)\.phong\.plot\(\)"
        with pytest.raises(ValueError, match=rf"a mesh without colours\. Light it first: {remedy}"):
            what.phong.plot()


def test_a_colours_name_is_the_colour_that_is_seen(tmp_path):
    """Colours are neither decoded from sRGB nor encoded: an emission of "orange" is drawn as PyVista's orange."""
    sheet, glow = pv.Plane(), ph.Material(ambient=0, diffuse=0, emission="orange")
    lit = sheet.phong.shade(SUN, glow)
    save_lit(lit, tmp_path / "lit.ply", "phong")
    in_file = pv.read(tmp_path / "lit.ply")["RGB"][0]
    for seen in (shot(lambda phong: phong.add_mesh(sheet, glow)), plotted(lit), in_file):
        assert tuple(seen) == pv.Color("orange").int_rgb


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_sums_above_1_are_drawn_as_full_brightness(precision):
    """VTK itself would wrap around to black."""
    lit = pv.Plane().phong.shade(SUN, ph.Material(ambient=0), precision=precision)
    lit["sum"] = np.full((lit.n_points, 3), (1.65, 0.5, -0.2), lit["phong"].dtype)
    pictures = [plotted(what, name="sum") for what in (lit, pv.MultiBlock([lit]))]
    for picture in (*pictures, shot(lambda phong: phong.add_lit(lit, "sum"))):
        np.testing.assert_allclose(picture, (255, 127.5, 0), atol=1)
    np.testing.assert_array_equal(lit["sum"][0], np.array((1.65, 0.5, -0.2), lit["phong"].dtype))
