"""The quick check of some faces: warnings for wrong normals, and none for PyVista's own meshes."""

import inspect
import os
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from pyvista.core.utilities import geometric_objects, parametric_objects

import pvphong as ph
from pvphong.meshes import glance
from pvphong.studies.diagnose.diagnosis import diagnose

SUN = ph.DirectionalLight(direction=(-1, -2, -3))
NINE = np.random.default_rng(0).normal(size=(9, 3))
ARGUMENTS = {
    "CircularArc": {"pointa": (1, 0, 0), "pointb": (0, 1, 0), "center": (0, 0, 0)},
    "CircularArcFromNormal": {"center": (0, 0, 0)},
    "Spline": {"points": NINE},
    "KochanekSpline": {"points": NINE},
    "Text3D": {"string": "x"},
}


def sources():
    """Yield the meshes of PyVista's functions with a capital letter."""
    for module in (geometric_objects, parametric_objects):
        for name, make in vars(module).items():
            if name[0].isupper() and inspect.isfunction(make) and make.__module__ == module.__name__:
                yield name, lambda make=make, name=name: make(**ARGUMENTS.get(name, {}))


def bundled():
    """Yield the meshes bundled with PyVista, except the largest volumes and those that need more packages."""
    for name in dir(examples):
        if name.startswith("load_") and name not in ("load_frog_tissues", "load_logo", "load_hydrogen_orbital"):
            yield name, getattr(examples, name)
    for name in ("antfile", "planefile", "globefile", "hexbeamfile", "spherefile", "nutfile"):
        if os.path.exists(path := getattr(examples, name, "")):
            yield name, lambda path=path: pv.read(path)


ALL = dict([*sources(), *bundled()])


def test_there_are_as_many_as_pyvista_makes():
    assert len(ALL) > 70


@pytest.mark.parametrize("name", ALL)
def test_no_mesh_that_pyvista_makes_or_bundles_is_warned_of(name):
    mesh = ALL[name]()
    for part in mesh.recursive_iterator() if isinstance(mesh, pv.MultiBlock) else [mesh]:
        if isinstance(part, pv.DataSet) and part.n_points:
            for scene in (None, SUN):  # any warning would be an error
                with suppress(ValueError):  # lines cannot be lit
                    part.phong.shade(scene)


def changed(mesh, change):
    mesh = mesh.copy()
    change(mesh.points)
    return mesh


def stretched(points):
    points[:, 2] *= 10


def sheared(points):
    points[:, 0] += 3 * points[:, 2]


def bare(mesh):
    mesh = mesh.copy()
    mesh.clear_data()
    return mesh


def distance(points):
    return np.linalg.norm(points, axis=1)


def blobs(points):
    centres = np.random.default_rng(3).uniform(-0.6, 0.6, (8, 3))
    return -sum(np.exp(-30 * np.square(points - centre).sum(axis=1)) for centre in centres)


def isosurface(field=distance, value=0.5, method="contour"):
    volume = pv.ImageData(dimensions=(24, 24, 24), origin=(-1, -1, -1), spacing=(2 / 23,) * 3)
    volume["field"] = field(volume.points)
    return volume.contour([value], scalars="field", method=method)


HILLS, SPHERE = examples.load_random_hills(), pv.Sphere()
MISFITS = {
    "stretched": changed(HILLS, stretched),
    "sheared": changed(SPHERE, sheared),
    "turned": HILLS.flip_faces(),
    "mirrored": SPHERE.reflect((1, 0, 0)),
    "of few faces": pv.Cube().flip_faces(),
    "in a grid": pv.StructuredGrid(*np.meshgrid([0.0, 1, 2], [0.0, 1, 2], [0.0])),
    "of faces of several sizes": pv.merge([pv.Plane(), pv.Disc()]).extract_surface(algorithm="dataset_surface"),
}
MISFITS["in a grid"].point_data.active_normals = np.tile([1.0, 0, 0], (9, 1))
MIXED = MISFITS["of faces of several sizes"]
MIXED.point_data.active_normals = np.tile([0.0, 1, 0], (MIXED.n_points, 1))
BACKS = {
    "an isosurface": isosurface(),
    "of flying edges": isosurface(method="flying_edges"),
    "of many parts": isosurface(blobs, -0.4),
    "turned": bare(SPHERE.flip_faces()),
    "of cells of one size": pv.PolyData.from_regular_faces(SPHERE.points, SPHERE.regular_faces[:, ::-1]),
    "rough": examples.load_nut().flip_faces(),
}


@pytest.mark.parametrize("mesh", MISFITS.values(), ids=MISFITS)
def test_normals_that_do_not_fit_are_warned_of_and_the_remedy_cures_that(mesh):
    mesh = mesh.copy()
    with pytest.warns(ph.NormalsWarning, match="stored normals do not fit") as caught:
        mesh.phong.shade(SUN)
    assert [each.filename for each in caught] == [__file__]
    assert 'mesh.point_data.active_normals = mesh.phong.normals("angle")' in str(caught[0].message)
    assert not diagnose(mesh).ok
    mesh.point_data.active_normals = mesh.phong.normals("angle")
    mesh.phong.shade(SUN)


@pytest.mark.parametrize("mesh", BACKS.values(), ids=BACKS)
def test_a_body_that_shows_its_backs_is_warned_of_and_the_remedies_cure_that(mesh):
    mesh = mesh.copy()
    with pytest.warns(ph.NormalsWarning, match="look inwards") as caught:
        dark = mesh.phong.shade()["phong"]
    assert [each.filename for each in caught] == [__file__]
    assert not diagnose(mesh).ok
    scene = ph.default_scene(mesh)
    bright = mesh.flip_faces().phong.shade()["phong"]
    both = mesh.copy().phong.shade(replace(scene, light_model=ph.LightModel(two_sided=True)))["phong"]
    faces_viewer = np.einsum("ij,ij->i", mesh.points - scene.viewer.position, mesh.phong.normals()) > 0
    assert bright[faces_viewer].mean() > 2 * dark[faces_viewer].mean()
    np.testing.assert_allclose(both[faces_viewer], bright[faces_viewer], atol=1e-5)


def test_once_for_each_state_of_a_mesh():
    mesh = changed(HILLS, stretched)
    with pytest.warns(ph.NormalsWarning):
        mesh.phong.shade(SUN)
    for _ in range(3):
        mesh.phong.shade(SUN)
    mesh.points[:, 2] *= 2
    with pytest.warns(ph.NormalsWarning):
        mesh.phong.shade(SUN)
    mesh.point_data.active_normals = mesh.phong.normals("angle")
    mesh.phong.shade(SUN)


LAMP = ph.PointLight(position=(0.1, 0, 0))
INSIDE = ph.Viewer(position=(0, 0, 0.1), focal_point=(1, 0, 0))
X, Y = np.meshgrid(np.linspace(-1, 1, 30), np.linspace(-1, 1, 30), indexing="ij")
TURNED = bare(SPHERE.flip_faces())
WELL = {
    "both sides are lit": (TURNED, ph.Scene([SUN], light_model=ph.LightModel(two_sided=True))),
    "it is seen from within": (TURNED, ph.Scene([SUN], INSIDE)),
    "a lamp is inside": (TURNED, ph.Scene([LAMP])),
    "normals are smooth over edges": (pv.Cube().triangulate().subdivide(1), ph.Scene([SUN])),
    "stored normals fit": (isosurface().compute_normals(), ph.Scene([SUN])),
    "it is half a body": (bare(isosurface().clip("x")), ph.Scene([SUN])),
    "it is a deep bowl": (pv.StructuredGrid(X, Y, 9 * (X**2 + Y**2)).extract_surface(algorithm="dataset_surface"), SUN),
    "it is a box without a lid": (pv.Box().remove_cells([5]).flip_faces(), SUN),
    "it is out of the lamp's way": (bare(SPHERE), ph.Scene([LAMP])),
    "it is empty but for lines": (pv.PolyData(NINE, lines=[2, 0, 1], faces=[3, 0, 1, 2]), SUN),
    "its faces have no area": (pv.PolyData(np.zeros((3, 3)), faces=[3, 0, 1, 2]), SUN),
    "its points are not finite": (pv.PolyData(np.full((3, 3), np.nan), faces=[3, 0, 1, 2]), SUN),
    "its points are far apart": (pv.PolyData(1e300 * NINE[:3], faces=[3, 0, 1, 2]), ph.Scene([SUN], INSIDE)),
    "its normals are zero": (changed(SPHERE, np.asarray), SUN),
}
WELL["its normals are zero"][0].point_data.active_normals = np.zeros((SPHERE.n_points, 3))


@pytest.mark.parametrize(("mesh", "scene"), WELL.values(), ids=WELL)
def test_nothing_is_said_where(mesh, scene):
    mesh.copy().phong.shade(scene)


def test_a_room_is_warned_of_when_its_lamp_and_viewer_have_left():
    mesh = TURNED.copy()
    mesh.phong.shade(ph.Scene([LAMP]))
    matrix = np.eye(4)
    matrix[:3, 3] = 9
    with pytest.warns(ph.NormalsWarning, match="look inwards"):
        mesh.phong.shade(ph.Scene([LAMP]), matrix=matrix)


def test_blocks_and_windows_are_looked_at():
    for bounces in (0, 1):
        blocks = pv.MultiBlock({"good": SPHERE.copy(), "bad": changed(HILLS, stretched)})
        scene = ph.Scene([SUN], light_model=ph.LightModel(bounces=bounces))
        with pytest.warns(ph.NormalsWarning, match="do not fit") as caught:
            blocks.phong.shade(scene)
        assert [each.filename for each in caught] == [__file__]
    plotter = pv.Plotter(off_screen=True)
    with pytest.warns(ph.NormalsWarning, match="look inwards") as caught:
        plotter.phong.add_mesh(isosurface())
    assert [each.filename for each in caught] == [__file__]
    plotter.phong.add_mesh(SPHERE)
    plotter.phong.add_mesh(bare(SPHERE))
    plotter.close()


def test_what_is_remembered_has_an_end(monkeypatch):
    monkeypatch.setattr(glance, "_REMEMBERED", 3)
    for _ in range(10):
        SPHERE.copy().phong.shade(SUN)
        assert len(glance._seen) <= 3


def test_it_looks_at_some_faces_only(monkeypatch):
    """The cost does not depend on the size of the mesh."""
    looked = []
    places = glance._places_and_areas
    monkeypatch.setattr(glance, "_places_and_areas", lambda *args: looked.append(args[1].shape) or places(*args))
    for resolution in (10, 40, 200):
        bare(pv.Sphere(theta_resolution=resolution, phi_resolution=resolution)).phong.shade(SUN)
    assert [count for _, count in looked] == [160, 256, 256]


UP = ph.DirectionalLight(direction=(0.2, 0.1, -1))
SKY = ph.EnvironmentLight(np.ones((2, 4, 3)))
WARPED = pv.StructuredGrid(*np.meshgrid(np.linspace(-10, 10, 40), np.linspace(-10, 10, 40)), np.zeros((40, 40)))
WARPED.points[:, 2] = np.sin(np.hypot(*WARPED.points[:, :2].T))
CLOUD = pv.PolyData(NINE)
CLOUD.point_data.active_normals = np.tile([0.0, 0, -1], (9, 1))
AWAY = "Every vertex faces away from every light"


@pytest.mark.parametrize(
    ("mesh", "lights", "options", "expected"),
    [
        (WARPED, [UP], {}, True),  # PyVista's own terrain
        (WARPED, [UP, ph.PointLight(position=(0, 0, 30))], {}, True),
        (WARPED, [UP, ph.PointLight(position=(0, 0, -30))], {}, False),
        (WARPED, [ph.SphereLight(position=(0, 0, 30), radius=1)], {}, True),
        (WARPED, [UP], {"matrix": np.diag([1.0, -1, -1, 1])}, False),
        (WARPED.extract_surface(algorithm="dataset_surface").flip_faces(), [UP], {}, False),
        (WARPED, [], {}, False),
        (WARPED, [replace(UP, on=False)], {}, False),
        (WARPED, [SKY], {}, False),
        (pv.Plane(), [UP], {}, False),
        (pv.Plane(), [replace(UP, direction=(0, 0, 1))], {}, True),
        (pv.Plane(), [replace(UP, direction=(0, 0, 1))], {"feature_angle": 0}, True),
        (pv.Plane(), [ph.SpotLight(position=(9, 0, 9), direction=(1, 0, 0))], {}, False),  # its cone points elsewhere
        (SPHERE, [UP], {}, False),
        (CLOUD, [UP], {}, False),
    ],
)
def test_a_plan_says_where_every_vertex_faces_away(mesh, lights, options, expected):
    plan = mesh.phong.plan(ph.Scene(lights), **options)
    assert plan.faces_away is expected
    for text in (str(plan), plan.explain(), plan._repr_html_()):
        assert (AWAY in " ".join(text.split())) is expected
    lit = mesh.phong.shade(ph.Scene(lights, light_model=ph.LightModel(ambient=0)), **options)["phong"]
    assert not (expected and lit.any())
    both = ph.Scene(lights, light_model=ph.LightModel(two_sided=True))
    assert not mesh.phong.plan(both, **options).faces_away
