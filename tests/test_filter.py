"""PhongFilter: a VTK filter that executes only if something has changed."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong import DirectionalLight, Material, PhongFilter, PointLight, Scene, Viewer

SCENE = Scene(lights=[DirectionalLight(direction=(-1, -2, -3))], viewer=Viewer(position=(0, 0, 5)))
SHINY = Material(specular=0.5, shininess=20)


class Counted(PhongFilter):
    """PhongFilter that counts its executions."""

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
    """meshes/test_sharing checks that the input is not modified."""
    assert colors(phong).dtype == np.float32
    expected, lit = pv.wrap(source.GetOutput()).phong.shade(SCENE, SHINY), pv.wrap(phong.GetOutput())
    assert colors(phong).tobytes() == expected["phong"].tobytes()
    assert lit.n_cells == expected.n_cells
    assert lit.active_scalars_name == "phong"
    np.testing.assert_array_equal(lit.points, expected.points)


def test_what_was_set_is_got_and_defaults_are_no_lights_and_opengls_material(phong):
    assert phong.GetScene() is SCENE
    assert phong.GetMaterial() is SHINY
    assert PhongFilter().GetScene() == Scene()
    assert PhongFilter().GetMaterial() == Material()


def test_executes_again_when_its_input_changes_and_not_otherwise(source, phong):
    assert [executions_after(phong) for _ in range(3)] == [1, 0, 0]
    count = phong.GetOutput().GetNumberOfPoints()
    assert executions_after(phong, lambda: source.SetThetaResolution(30)) == 1
    assert phong.GetOutput().GetNumberOfPoints() > count
    assert executions_after(phong, lambda: source.SetThetaResolution(30)) == 0  # the same value again


@pytest.mark.parametrize(
    ("setter", "other", "same"),
    [
        ("SetScene", Scene(lights=[PointLight(position=(0, 0, 3))], viewer=SCENE.viewer), replace(SCENE)),
        ("SetMaterial", Material.named("gold"), replace(SHINY)),
    ],
)
def test_executes_again_for_another_scene_or_material_and_not_for_an_equal_one(phong, setter, other, same):
    before = colors(phong).copy()
    assert same is not SCENE
    assert executions_after(phong, lambda: getattr(phong, setter)(same)) == 0
    assert executions_after(phong, lambda: getattr(phong, setter)(other)) == 1
    assert np.abs(colors(phong) - before).max() > 0.1


def test_bad_arguments_are_refused_and_change_nothing(phong):
    phong.Update()
    with pytest.raises(ValueError, match=r"^scene must be a Scene"):
        phong.SetScene("sun")
    with pytest.raises(ValueError, match=r"^material must be a Material or .* Did you mean 'gold'"):
        phong.SetMaterial("gld")
    with pytest.raises(ValueError, match=r"^option must be one of .*precision.*; got precison. Did you mean"):
        phong.SetOptions(precison="float64")
    assert executions_after(phong) == 0
    assert (phong.GetScene(), phong.GetMaterial()) == (SCENE, SHINY)


def test_an_input_that_cannot_be_lit_says_why(caplog, capfd):
    """`Update` raises errors. VTK prints them too, because the pipeline of a downstream filter swallows exceptions."""
    line = vtk.vtkLineSource()  # kept alive: VTK's connections do not hold their source
    step = PhongFilter()
    step.SetInputConnection(line.GetOutputPort())
    reason = "mesh must be a mesh with faces, or points with normals"
    for _ in range(2):  # the pipeline runs once; the error stays
        with pytest.raises(ValueError, match=f"^{reason}"):
            step.Update()
    assert f"PhongFilter: {reason}" in caplog.text + capfd.readouterr().err  # PyVista may log VTK's messages
    sphere = vtk.vtkSphereSource()
    step.SetInputConnection(sphere.GetOutputPort())
    step.Update()
    assert step.GetOutput().GetNumberOfPoints() > 0
    capfd.readouterr()
    step.SetInputData(pv.PolyData())  # a clip upstream may output an empty mesh
    step.Update()
    assert step.GetOutput().GetNumberOfPoints() == 0
    assert "ERR" not in capfd.readouterr().err
