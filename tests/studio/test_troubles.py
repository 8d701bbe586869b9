"""A broken mesh in a window: the others stay current, it is said which one is broken and why, and it ends."""

import numpy as np
import pytest
import pyvista as pv

from pvphong.optics.lights import DirectionalLight
from pvphong.optics.material import Material
from pvphong.studio.lit_actors import LightingWarning

DULL = Material(diffuse=0.8, ambient=0.0)
LEFT, RIGHT = (120, 200), (280, 200)  # pixels in which the balls are seen


@pytest.fixture
def plotter():
    shown = pv.Plotter(off_screen=True, window_size=(400, 400), lighting="none")
    shown.background_color = "blue"
    shown.phong.add_light(DirectionalLight(direction=(0, 0, -1), name="sun"))
    yield shown
    shown.close()


@pytest.fixture
def balls(plotter):
    """Two balls side by side, drawn once; the left one is to be broken."""
    meshes = [pv.Sphere(center=(x, 0, 0)) for x in (-0.7, 0.7)]
    for name, mesh in zip(("left", "right"), meshes, strict=True):
        mesh["tint"] = np.ones((mesh.n_points, 3))
        plotter.phong.add_mesh(mesh, DULL, albedo="tint", name=name)
    plotter.camera_position = [(0, 0, 6), (0, 0, 0), (0, 1, 0)]
    plotter.show(auto_close=False)
    return meshes


def empty(mesh):
    mesh.copy_from(pv.PolyData())


def index_beyond(mesh):
    mesh.GetPolys().SetData(mesh.GetPolys().GetOffsetsArray(), pv.convert_array(np.full(3 * mesh.n_cells, 9999)))
    mesh.GetPolys().Modified()


def stale_albedo(mesh):
    del mesh.point_data["tint"]


def seen(plotter, pixel):
    return tuple(plotter.screenshot(return_img=True)[pixel[1], pixel[0]].tolist())


def texts(plotter):
    return [prop.GetInput() for prop in plotter.renderer.GetViewProps() if prop.IsA("vtkTextActor")]


@pytest.mark.parametrize("harm", [empty, index_beyond, stale_albedo])
def test_the_others_stay_current_the_trouble_is_said_and_ends(plotter, balls, harm):
    left, _ = balls
    whole = left.copy()
    harm(left)
    plotter.phong.set_light("sun", DirectionalLight(direction=(0, 0, -1), diffuse="lime", name="sun"))
    with pytest.warns(LightingWarning, match="^The mesh 'left' is not lit: ") as warned:
        plotter.render()
    assert len(warned) == 1
    assert seen(plotter, RIGHT)[0] < 5 < seen(plotter, RIGHT)[1]
    assert seen(plotter, LEFT) == (0, 0, 255)
    assert [text.replace("\n", " ")[:24] for text in texts(plotter)] == ["The mesh 'left' is not l"]
    plotter.render()  # said once
    left.copy_from(whole)
    plotter.render()
    assert texts(plotter) == []
    assert seen(plotter, LEFT)[0] < 5 < seen(plotter, LEFT)[1]
