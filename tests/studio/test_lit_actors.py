"""Lit meshes in windows: their colour buffers, sharing with the user's mesh, and meshes that cannot be lit."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, Viewer
from pvphong.studio.lit_actors import LightingWarning
from pvphong.studio.lit_mesh import ARRAY, LitMesh

SCENE = Scene(lights=[PointLight(position=(2, 2, 2))], viewer=Viewer(position=(0, 0, 5)))
SHINY = Material(specular=0.5, shininess=20)


def ball():
    return pv.Sphere(theta_resolution=16, phi_resolution=12)


def other_light(step):
    return replace(SCENE, lights=[PointLight(position=(2, 2, 2 + 0.01 * step))])


def assert_lit(live, scene):
    lit = live.mesh.phong.shade(scene, live.material, precision="float64")[ARRAY]
    assert np.abs(np.asarray(live.drawn[ARRAY]) - 255.0 * lit).max() <= 0.51


@pytest.mark.parametrize("points", ["moved", "more"])
def test_the_buffer_stays_while_the_number_of_points_does(points):
    def address():
        return live.drawn.GetPointData().GetArray(ARRAY).GetVoidPointer(0)

    grid = pv.ImageData(dimensions=(6, 6, 2)).cast_to_structured_grid()
    live = LitMesh(grid, SHINY)
    assert live.refresh(SCENE)
    assert not live.refresh(SCENE)
    at = address()
    if points == "moved":
        grid.points[:, 2] += 0.1 * grid.points[:, 0] ** 2
    else:
        grid.copy_from(pv.ImageData(dimensions=(30, 30, 2)).cast_to_structured_grid())
    assert live.refresh(SCENE)
    assert (address() == at) == (points == "moved")
    assert_lit(live, SCENE)


def test_the_renderer_is_told_of_new_colours_alone_which_are_not_those_of_a_mesh_that_is_lit_already():
    lit = ball().phong.shade(SCENE, SHINY)
    given = lit[ARRAY].copy()
    live = LitMesh(lit, SHINY)
    live.refresh(SCENE)
    array, points = live.drawn.GetPointData().GetArray(ARRAY), live.drawn.GetPoints()
    before, shape = array.GetMTime(), points.GetMTime()
    live.refresh(SCENE)
    assert array.GetMTime() == before
    live.refresh(other_light(50))
    assert array.GetMTime() > before
    assert points.GetMTime() == shape
    np.testing.assert_array_equal(lit[ARRAY], given)
    assert live.drawn[ARRAY].dtype == np.uint8


@pytest.mark.parametrize("given", [np.array, lambda tint: tint], ids=["NumPy's", "PyVista's"])
def test_given_albedo_of_the_same_object_is_no_change_and_another_is(given):
    """Arrays are compared by identity, also PyVista's, which have a modification time."""
    mesh = ball()
    mesh["tint"] = np.full((mesh.n_points, 3), 0.5)
    live = LitMesh(mesh, replace(SHINY, albedo=given(mesh["tint"])))
    assert live.refresh(SCENE)
    assert not live.refresh(SCENE)
    live.material = replace(SHINY, albedo=given(mesh["tint"]))
    assert live.refresh(SCENE)


def resize(array, rows):
    """Resize in place without telling VTK, which frees the old memory."""
    components = array.GetNumberOfComponents()
    array.Initialize()
    array.SetNumberOfComponents(components)
    array.SetNumberOfTuples(rows)


def edit_corners(mesh, edit):
    edit(mesh.GetPolys().GetConnectivityArray())
    mesh.GetPolys().Modified()


BREAKING = {
    "points replaced by none": (lambda mesh: setattr(mesh, "points", np.zeros((0, 3))), "refer to its 0 points"),
    "points resized": (lambda mesh: resize(mesh.GetPoints().GetData(), 5), "refer to its 5 points"),
    "normals resized": (lambda mesh: resize(mesh.GetPointData().GetNormals(), 3), "normals must be .* got 3 rows"),
    "normals made more": (lambda mesh: resize(mesh.GetPointData().GetNormals(), 9999), "normals must .* got 9999 rows"),
    "albedo resized": (lambda mesh: resize(mesh.GetPointData().GetArray("tint"), 3), "albedo must be .* got 3 rows"),
    "arrays removed": (lambda mesh: mesh.clear_data(), r"albedo must be the name of a point array .*; got 'tint'"),
    "faces removed": (lambda mesh: (mesh.clear_data(), mesh.GetPolys().Initialize()), "mesh must be a mesh with faces"),
    "faces cut": (lambda mesh: edit_corners(mesh, lambda corners: resize(corners, 9)), "offsets rise"),
    "index beyond": (lambda mesh: edit_corners(mesh, lambda corners: corners.Fill(9999)), "point"),
    "all gone": (lambda mesh: mesh.copy_from(pv.PolyData()), "mesh must be a mesh with faces"),
}


@pytest.mark.parametrize(("edit", "said"), BREAKING.values(), ids=BREAKING)
def test_an_edit_after_which_a_mesh_cannot_be_lit_is_an_error_until_it_is_put_right(edit, said):
    mesh = ball()
    mesh["tint"] = np.full((mesh.n_points, 3), 0.5)
    live, whole = LitMesh(mesh, replace(SHINY, albedo="tint")), mesh.copy()
    live.refresh(SCENE)
    edit(mesh)
    for step in (1, 2):
        with pytest.raises(ValueError, match=said):
            live.refresh(other_light(step))
    mesh.copy_from(whole)
    assert live.refresh(SCENE)
    live.material = SHINY
    live.refresh(SCENE)
    assert_lit(live, SCENE)


def test_colours_that_somebody_resized_or_took_away_are_there_again():
    for edit in (
        lambda data: resize(data.GetArray(ARRAY), 3),
        lambda data: resize(data.GetArray(ARRAY), 99999),
        lambda data: data.RemoveArray(ARRAY),
        lambda data: data.Initialize(),
    ):
        live = LitMesh(ball(), SHINY)
        live.refresh(SCENE)
        edit(live.drawn.GetPointData())
        live.refresh(SCENE)
        assert_lit(live, SCENE)
        assert live.drawn.active_scalars_name == ARRAY


# --- in a window

LEFT, RIGHT = (120, 200), (280, 200)  # pixels on the balls


UNDRAWABLE = ["points replaced by none", "points resized", "arrays removed", "index beyond", "all gone"]


@pytest.mark.parametrize("edit", UNDRAWABLE)
def test_in_a_window_a_broken_mesh_is_not_drawn_which_is_said_once_and_the_others_stay_current(new_plotter, edit):
    def sun(color):
        return DirectionalLight(direction=(0, 0, -1), diffuse=color, name="sun")

    def seen(pixel):
        return plotter.screenshot(return_img=True)[pixel[1], pixel[0]].tolist()

    def texts():
        return [prop.GetInput() for prop in plotter.renderer.GetViewProps() if prop.IsA("vtkTextActor")]

    plotter = new_plotter((400, 400))
    plotter.background_color = "blue"
    plotter.phong.add_light(sun("white"))
    meshes = [pv.Sphere(center=(x, 0, 0)) for x in (-0.7, 0.7)]
    for name, mesh in zip(("left", "right"), meshes, strict=True):
        mesh["tint"] = np.ones((mesh.n_points, 3))
        plotter.phong.add_mesh(mesh, Material(diffuse=0.8, ambient=0.0, albedo="tint"), name=name)
    plotter.camera_position = [(0, 0, 6), (0, 0, 0), (0, 1, 0)]
    plotter.show(auto_close=False)
    whole = meshes[0].copy()
    BREAKING[edit][0](meshes[0])
    plotter.phong.set_light("sun", sun("lime"))
    with pytest.warns(LightingWarning, match="^The mesh 'left' cannot be lit and is not drawn: ") as warned:
        plotter.render()
    assert len(warned) == 1
    red, green, _ = seen(RIGHT)
    assert red < 5 < green
    assert seen(LEFT) == [0, 0, 255]
    assert [text.replace("\n", " ")[:24] for text in texts()] == ["The mesh 'left' cannot b"]
    plotter.render()  # warns only once
    meshes[0].copy_from(whole)
    plotter.render()
    assert texts() == []
    red, green, _ = seen(LEFT)
    assert red < 5 < green


@pytest.fixture
def window(new_plotter):
    """A plotter with a PyVista light and a ball, drawn once."""
    plotter = new_plotter()
    plotter.add_light(pv.Light(position=(0, 0, 3)))
    plotter.phong.add_mesh(ball(), SHINY, name="ball")
    plotter.show(auto_close=False)
    return plotter


def said(plotter):
    return " ".join(prop.GetInput() for prop in plotter.renderer.GetViewProps() if prop.IsA("vtkTextActor"))


def test_where_light_bounces_it_is_said_that_the_only_mesh_cannot_be_lit(window):
    window.phong.light_model = LightModel(bounces=1)
    window.phong.mesh(window.actors["ball"]).material = Material(albedo="gone")
    with pytest.warns(LightingWarning, match="^The mesh 'ball' cannot be lit and is not drawn: albedo must be"):
        window.render()
    assert "cannot be lit" in said(window)


def test_a_light_without_a_direction_lights_no_mesh_until_it_has_one(window):
    (light,) = window.renderer.lights
    light.position = light.focal_point
    with pytest.warns(LightingWarning, match="^The mesh 'ball' cannot be lit and is not drawn: "):
        window.render()
    assert window.actors["ball"].mapper.dataset.n_points == 0
    light.position = (0, 0, 3)
    window.render()
    assert said(window) == ""
    assert np.ptp(window.actors["ball"].mapper.dataset[ARRAY]) > 50
