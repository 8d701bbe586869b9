"""PhongFilter: a step of a VTK pipeline that executes when it has to, and only then."""

import numpy as np
import pytest
import pyvista as pv
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.filter import PhongFilter
from pvphong.optics.lights import DirectionalLight, PointLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer

SCENE = Scene(lights=[DirectionalLight(direction=(-1, -2, -3))], viewer=Viewer(position=(0, 0, 5)))
SHINY = Material(specular=0.5, shininess=20)


class Counted(PhongFilter):
    """Counts its executions."""

    def __init__(self):
        super().__init__()
        self.executions = 0

    def RequestData(self, request, inputs, outputs):
        self.executions += 1
        return super().RequestData(request, inputs, outputs)


@pytest.fixture
def source():
    sphere = vtk.vtkSphereSource()
    sphere.SetThetaResolution(20)
    return sphere


@pytest.fixture
def phong(source):
    step = Counted()
    step.SetInputConnection(source.GetOutputPort())
    step.SetScene(SCENE)
    step.SetMaterial(SHINY)
    return step


def colors(step):
    step.Update()
    return vtk_to_numpy(step.GetOutput().GetPointData().GetArray("phong"))


def executions_after(step, change=None):
    before = step.executions
    if change is not None:
        change()
    step.Update()
    return step.executions - before


def test_output_is_the_lit_mesh(source, phong):
    source.Update()
    expected = pv.wrap(source.GetOutput()).phong.shade(SCENE, SHINY)
    assert colors(phong).tobytes() == expected["phong"].tobytes()
    assert colors(phong).dtype == np.float32
    lit = pv.wrap(phong.GetOutput())
    assert lit.n_cells == expected.n_cells
    assert lit.active_scalars_name == "phong"
    np.testing.assert_array_equal(lit.points, expected.points)


def test_defaults_are_a_scene_without_lights_and_opengls_material():
    step = PhongFilter()
    assert step.GetScene() == Scene()
    assert step.GetMaterial() == Material()


def test_what_was_set_is_got(phong):
    assert phong.GetScene() is SCENE
    assert phong.GetMaterial() is SHINY


def test_executes_once_for_one_state(phong):
    assert executions_after(phong) == 1
    for _ in range(3):
        assert executions_after(phong) == 0


def test_executes_again_when_its_input_changes(source, phong):
    phong.Update()
    count = phong.GetOutput().GetNumberOfPoints()
    assert executions_after(phong, lambda: source.SetThetaResolution(30)) == 1
    assert phong.GetOutput().GetNumberOfPoints() > count
    assert executions_after(phong, lambda: source.SetThetaResolution(30)) == 0  # the same value again


def test_executes_again_when_the_scene_changes(phong):
    before = colors(phong).copy()
    other = Scene(lights=[PointLight(position=(0, 0, 3))], viewer=SCENE.viewer)
    assert executions_after(phong, lambda: phong.SetScene(other)) == 1
    assert np.abs(colors(phong) - before).max() > 0.1


def test_executes_again_when_the_material_changes(phong):
    before = colors(phong).copy()
    assert executions_after(phong, lambda: phong.SetMaterial(Material.named("gold"))) == 1
    assert np.abs(colors(phong) - before).max() > 0.1


def test_an_equal_scene_or_material_changes_nothing(phong):
    phong.Update()
    same = Scene(lights=[DirectionalLight(direction=(-1, -2, -3))], viewer=Viewer(position=(0, 0, 5)))
    assert same is not SCENE
    assert executions_after(phong, lambda: phong.SetScene(same)) == 0
    assert executions_after(phong, lambda: phong.SetMaterial(Material(specular=0.5, shininess=20))) == 0


def test_works_with_a_connection_downstream(phong):
    clip = vtk.vtkClipPolyData()
    plane = vtk.vtkPlane()
    clip.SetClipFunction(plane)
    clip.SetInputConnection(phong.GetOutputPort())
    clip.Update()
    assert clip.GetOutput().GetPointData().GetArray("phong").GetNumberOfComponents() == 3
    assert phong.executions == 1
    plane.SetOrigin(0.1, 0, 0)
    clip.Update()
    assert phong.executions == 1
    phong.SetMaterial(Material())
    clip.Update()
    assert phong.executions == 2


def test_works_with_input_data():
    mesh = pv.Sphere()
    step = PhongFilter()
    step.SetInputDataObject(0, mesh)
    step.SetScene(SCENE)
    assert colors(step).tobytes() == mesh.phong.shade(SCENE)["phong"].tobytes()


def test_the_input_is_not_modified(source, phong):
    source.Update()
    data = source.GetOutput()
    mtime, points = data.GetMTime(), vtk_to_numpy(data.GetPoints().GetData()).tobytes()
    phong.Update()
    assert not data.GetPointData().HasArray("phong")
    assert (data.GetMTime(), vtk_to_numpy(data.GetPoints().GetData()).tobytes()) == (mtime, points)


def test_without_normals_they_are_computed(source):
    source.GenerateNormalsOff()
    step = PhongFilter()
    step.SetInputConnection(source.GetOutputPort())
    step.SetScene(SCENE)
    source.Update()
    assert colors(step).tobytes() == pv.wrap(source.GetOutput()).phong.shade(SCENE)["phong"].tobytes()


def test_bad_arguments_are_refused_and_change_nothing(phong):
    phong.Update()
    with pytest.raises(ValueError, match=r"^scene must be a Scene; got .*Scene\(lights"):
        phong.SetScene([DirectionalLight()])
    with pytest.raises(ValueError, match=r"^material must be a Material; got gold"):
        phong.SetMaterial("gold")
    assert executions_after(phong) == 0
    assert (phong.GetScene(), phong.GetMaterial()) == (SCENE, SHINY)


def test_an_input_that_cannot_be_lit_says_why(capfd):
    """A pipeline swallows exceptions; the reason must be seen all the same."""
    line = vtk.vtkLineSource()  # kept: VTK's connections do not hold what they come from
    step = PhongFilter()
    step.SetInputConnection(line.GetOutputPort())
    said = ""
    try:
        step.Update()
    except ValueError as error:
        said = str(error)
    captured = capfd.readouterr()
    assert "mesh must be a mesh with faces, or points with normals" in said + captured.out + captured.err


def test_an_empty_input_gives_an_empty_output(source, capfd):
    """As with every VTK filter: a clip upstream may leave nothing."""
    plane = vtk.vtkPlane()
    plane.SetOrigin(0, 0, 100)
    nothing = vtk.vtkClipPolyData()
    nothing.SetInputConnection(source.GetOutputPort())
    nothing.SetClipFunction(plane)
    step = PhongFilter()
    step.SetInputConnection(nothing.GetOutputPort())
    step.Update()
    assert step.GetOutput().GetNumberOfPoints() == 0
    assert "ERR" not in capfd.readouterr().err
