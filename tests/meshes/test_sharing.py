"""Results share memory with their inputs, and pvphong does not write into shared memory."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from soups import state
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong import DirectionalLight, Material, PhongFilter, PointLight, Scene, Viewer
from pvphong.meshes.surfaces import shallow_copy, surface
from pvphong.studio.lit_mesh import LitMesh

SCENE = Scene([DirectionalLight(direction=(-1, 0.5, -1)), PointLight(position=(2, -1, 3))], Viewer(position=(1, 2, 6)))
MATERIAL = Material(ambient=0.1, specular=0.4, shininess=12)


def ball(*, stored=True):
    """A sphere with arrays of every kind, including arrays with the names of results."""
    return with_arrays(pv.Sphere(theta_resolution=10, phi_resolution=8), stored=stored)


def quads():
    """A sheet of polygons, which some operations triangulate, and lines."""
    sheet = pv.Plane(i_resolution=4, j_resolution=3).compute_normals(cell_normals=False)
    sheet.lines = [2, 0, 7]
    return with_arrays(sheet, stored=True)


def with_arrays(mesh, *, stored):
    normals = mesh.point_data.active_normals.copy()
    mesh.clear_data()
    mesh.cell_data["odd"] = np.arange(mesh.n_cells) % 2 == 1
    rows = np.random.default_rng(3).uniform(size=(mesh.n_points, 3))
    mesh.point_data["tint"], mesh.point_data["phong"] = rows, rows[:, 0] > 0.5
    mesh.point_data["marked"], mesh.cell_data["patch"] = rows[:, 1] > 0.5, np.arange(mesh.n_cells)
    mesh.active_texture_coordinates = rows[:, :2].copy()
    mesh.field_data["release"], mesh.user_dict["author"] = [1.5], "me"
    if stored:
        mesh.point_data.active_normals = normals
    mesh.set_active_scalars("tint")
    return mesh


def filtered(mesh):
    step = PhongFilter()
    step.SetInputData(surface(mesh))
    step.SetScene(SCENE)
    step.Update()
    return step.GetOutput()


def drawn_live(mesh):
    live = LitMesh(mesh, replace(MATERIAL, albedo="tint"))
    for scene in (SCENE, Scene(SCENE.lights[:1], SCENE.viewer)):
        live.refresh(scene)
    return live.drawn


def grid():
    image = pv.ImageData(dimensions=(4, 3, 3))
    image.point_data.active_normals = np.ones((36, 3))
    return with_arrays(image.cast_to_unstructured_grid(), stored=False)


MESHES = {"normals": ball, "no normals": lambda: ball(stored=False), "quads": quads, "grid": grid}
OPERATIONS = {
    "shade": lambda mesh: mesh.phong.shade(SCENE, MATERIAL),
    "shade by the reference": lambda mesh: mesh.phong.shade(SCENE, replace(MATERIAL, albedo="tint"), backend="numpy"),
    "shade in parts": lambda mesh: mesh.phong.shade(SCENE, MATERIAL, components=True, matrix=np.diag([1, 2, 3, 1])),
    "plan": lambda mesh: mesh.phong.plan(SCENE, MATERIAL, tolerance=0.01),
    "normals": lambda mesh: [mesh.phong.normals(weighting) for weighting in (None, "angle", "area", "max")],
    "diagnose": lambda mesh: mesh.phong.diagnose().to_mesh(),
    "interpolation_error": lambda mesh: mesh.phong.interpolation_error(SCENE, MATERIAL),
    "refine": lambda mesh: mesh.phong.refine(SCENE, MATERIAL, tolerance=0.05),
    "filter": filtered,
    "live": drawn_live,
    "blocks": lambda mesh: pv.MultiBlock([mesh, None, mesh]).phong.shade(SCENE, MATERIAL),
    "normals of blocks": lambda mesh: pv.MultiBlock([mesh]).phong.normals("area"),
}


@pytest.mark.parametrize("operation", OPERATIONS)
@pytest.mark.parametrize("kind", MESHES)
def test_no_operation_writes_into_its_input(operation, kind):
    mesh = MESHES[kind]()
    lit = mesh.phong.shade(SCENE, MATERIAL, name="before")  # shares memory with the mesh, and is lit again below
    states = state(mesh), state(lit)
    first, second = OPERATIONS[operation](mesh), OPERATIONS[operation](lit)
    assert states == (state(mesh), state(lit))
    del first, second
    assert mesh["phong"].dtype == bool  # also for the array with the result's name


def test_points_cells_and_arrays_are_shared_and_written_into_for_both():
    mesh = ball()
    lit = pv.MultiBlock([mesh]).phong.shade(SCENE, MATERIAL)[0]  # as mesh.phong.shade does
    assert dict(lit.user_dict) == {"author": "me"}
    lit.user_dict["author"] = "you"
    assert dict(mesh.user_dict) == {"author": "me"}  # a result has its own user_dict
    stand_alone = lit.copy()
    for here, there in ((mesh.points, lit.points), (mesh["tint"], lit["tint"]), (mesh["patch"], lit["patch"])):
        assert np.shares_memory(here, there)
    connectivity = [vtk_to_numpy(one.GetPolys().GetConnectivityArray()) for one in (mesh, lit)]
    assert np.shares_memory(*connectivity)
    mesh.points[3] = 7.0
    lit["tint"][4] = 8.0
    assert (lit.points[3] == 7.0).all()
    assert (mesh["tint"][4] == 8.0).all()
    assert not (stand_alone.points[3] == 7.0).any()
    assert not (stand_alone["tint"][4] == 8.0).any()


CHANGES = {
    "points": lambda mesh: setattr(mesh, "points", np.asarray(mesh.points) * 2.0),
    "moved": lambda mesh: mesh.translate((1, 2, 3), inplace=True),
    "faces": lambda mesh: setattr(mesh, "faces", mesh.faces[:8]),
    "normals": lambda mesh: setattr(mesh.point_data, "active_normals", np.ones((mesh.n_points, 3))),
    "array": lambda mesh: mesh.point_data.update({"tint": np.zeros((mesh.n_points, 3))}),
    "bools": lambda mesh: mesh.point_data.update({"marked": np.zeros(mesh.n_points)}),
    "active": lambda mesh: mesh.set_active_scalars("marked"),
    "removed": lambda mesh: mesh.clear_data(),
    "field": lambda mesh: mesh.field_data.update({"release": [2.5], "more": [1]}),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("of", ["input", "result"])
def test_what_is_replaced_on_one_side_is_not_on_the_other(change, of):
    mesh = ball()
    lit = shallow_copy(mesh)
    assert state(mesh)[1:] == state(lit)[1:]
    changed, kept = (mesh, lit) if of == "input" else (lit, mesh)
    before = state(kept)
    CHANGES[change](changed)
    assert state(kept)[1:] == before[1:]
    assert state(changed)[1:] != before[1:]
