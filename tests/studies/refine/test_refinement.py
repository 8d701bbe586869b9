"""Refined meshes: their errors against dense sampling, their topology, their arrays, and why they stop."""

from __future__ import annotations

import math

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given, settings
from hypothesis import strategies as st

import pvphong as ph
from pvphong.studies.refine.refinement import interpolation_error, refine

STEP = 1 / 255
TO_LIGHT = np.array([1.0, 1.0, 2.0]) / math.sqrt(6.0)
EYE = (3.0, -1.0, 4.0)
SUN = ph.DirectionalLight(direction=tuple(-TO_LIGHT))
SUNNY = ph.Scene(lights=[SUN], viewer=ph.Viewer(position=EYE), light_model=ph.LightModel(ambient=0.2))
SHARP = ph.Material(ambient=0.1, diffuse=0.5, specular=0.4, shininess=200)
MATT = ph.Material(diffuse=0.8)


def textbook(points, normals):
    """SUNNY on SHARP, written from the model's page: Phong reflection, one directional light, a local viewer."""
    n = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    v = np.array(EYE) - points
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    n_l = n @ TO_LIGHT
    r_v = ((2 * n_l[..., None] * n - TO_LIGHT) * v).sum(axis=-1)
    grey = 0.1 * 0.2 + 0.5 * np.maximum(n_l, 0) + 0.4 * (n_l > 0) * np.maximum(r_v, 0) ** 200
    return np.repeat(np.clip(grey, 0, 1)[..., None], 3, axis=-1)


def evaluated(scene, material, **options):
    """The same through `evaluate`, for scenes that are not SUNNY."""

    def colors(points, normals):
        rows = points.reshape(-1, 3), normals.reshape(-1, 3)
        return ph.evaluate(*rows, scene, material, precision="float64", **options).rgb.reshape(points.shape)

    return colors


def dense_errors(mesh, truth, count=60, name="phong"):
    """Each triangle's largest error at random places, other ones in every triangle."""
    rng = np.random.default_rng(7)
    corners = mesh.regular_faces
    points, normals = mesh.points.astype(float), mesh.point_data.active_normals.astype(float)
    worst = np.zeros(len(corners))
    for _ in range(count):
        weights = rng.dirichlet(np.full(3, rng.choice([0.3, 1, 3])), size=len(corners))[..., None]
        blend = ((weights * array[corners]).sum(axis=1) for array in (points, normals, mesh[name].astype(float)))
        place, normal, color = blend
        worst = np.maximum(worst, np.abs(truth(place, normal) - color).max(axis=1))
    return worst


def left(mesh, name="phong"):
    return float(mesh.field_data[f"{name}_refinement_error"][0])


def stopped(mesh, name="phong"):
    return mesh.field_data[f"{name}_refinement_stopped"]


def coarse_sphere():
    sphere = pv.Icosphere(nsub=1, radius=0.5)  # 42 points
    sphere.clear_data()
    return sphere


def torus():
    mesh = pv.ParametricTorus(u_res=16, v_res=12, w_res=8).clean().triangulate()
    mesh.clear_data()
    return mesh


def square(count=1, **options):
    mesh = pv.Plane(i_size=2, j_size=2, i_resolution=count, j_resolution=count, **options).triangulate()
    mesh.clear_data()
    return mesh


def smallest_angle(mesh):
    points, corners = mesh.points.astype(float), mesh.regular_faces
    a = points[np.roll(corners, -1, axis=1)] - points[corners]
    b = points[np.roll(corners, 1, axis=1)] - points[corners]
    sine, cosine = np.linalg.norm(np.cross(a, b), axis=2), (a * b).sum(axis=2)
    return float(np.degrees(np.arctan2(sine, cosine)).min())


def areas(mesh):
    corners = mesh.points.astype(float)[mesh.regular_faces]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


# The error


@pytest.mark.parametrize("placement", ["linear", "smooth"])
@pytest.mark.parametrize("make", [coarse_sphere, torus])
def test_dense_samples_of_an_independent_formula_are_within_the_tolerance(make, placement):
    fine = refine(make(), SUNNY, SHARP, tolerance=STEP, placement=placement)
    assert stopped(fine) == "tolerance"
    errors = dense_errors(fine, textbook)
    assert errors.max() <= STEP
    assert errors.max() <= left(fine) * 1.07  # what it reports is what is left, but for places between its samples
    assert left(fine) <= STEP


def test_the_coarse_mesh_misses_the_highlight_that_the_fine_one_has():
    coarse = coarse_sphere()
    shaded = coarse.phong.shade(SUNNY, SHARP)
    shaded.point_data.active_normals = coarse.phong.normals()
    assert dense_errors(shaded, textbook).max() > 60 * STEP


def test_a_tenth_of_the_points_of_uniform_subdivision():
    coarse = coarse_sphere()
    fine = refine(coarse, SUNNY, SHARP, tolerance=STEP)
    uniform = coarse.copy()
    uniform.point_data.active_normals = coarse.phong.normals()
    uniform = uniform.subdivide(5, "linear")  # its normals are interpolated and not made unit length
    uniform["phong"] = textbook(uniform.points.astype(float), uniform.point_data.active_normals.astype(float))
    assert dense_errors(fine, textbook).max() <= STEP
    assert dense_errors(uniform, textbook, count=10).max() > 3 * STEP  # so uniform needs more points than these
    assert fine.n_points <= uniform.n_points / 10


def test_errors_do_not_depend_on_how_normals_are_blended():
    # In the original mesh normals are blended over its large triangles, in the result over the parts.
    coarse = coarse_sphere()
    normals = coarse.phong.normals()
    coarse["original"] = normals  # interpolated linearly, and never made unit length
    fine = refine(coarse, SUNNY, SHARP, tolerance=STEP)
    assert np.linalg.norm(fine["original"], axis=1).min() < 0.99
    assert dense_errors(fine, textbook).max() <= STEP
    fine.point_data.active_normals_name = "original"
    assert dense_errors(fine, textbook).max() <= STEP


LAMPS = [
    ph.PointLight(position=(0.4, 0.5, 1.2), diffuse=(0.9, 0.3, 0.2)),
    ph.SpotLight(position=(1.5, 0, 1.5), direction=(-1, 0, -1), cone_angle=60, exponent=40),
]
MODELS = {
    "blinn-phong": ph.LightModel(reflection="blinn-phong"),
    "far viewer": ph.LightModel(local_viewer=False),
    "unclamped": ph.LightModel(clamp=False),
    "VTK's": ph.LightModel.vtk(two_sided=False),
}


@pytest.mark.parametrize("model", MODELS)
def test_every_light_model_is_held_to_the_tolerance(model):
    scene = ph.Scene(lights=[SUN, *LAMPS], viewer=ph.Viewer(position=EYE), light_model=MODELS[model])
    material = ph.Material(diffuse=0.9, specular=0.6, shininess=30)
    fine = refine(torus(), scene, material, tolerance=0.01, precision="float64")
    assert stopped(fine) == "tolerance"
    assert dense_errors(fine, evaluated(scene, material), count=40).max() <= 0.01


def test_saturated_colours_bend_where_they_reach_white():
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(0, 0, -1), intensity=3)])
    fine = refine(coarse_sphere(), scene, MATT, tolerance=STEP)
    assert dense_errors(fine, evaluated(scene, MATT), count=200).max() <= STEP


def test_the_rim_of_the_dark_side_is_followed():
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(0, 0, -1))])
    fine = refine(coarse_sphere(), scene, MATT, tolerance=STEP)
    assert dense_errors(fine, evaluated(scene, MATT), count=200).max() <= STEP


def test_a_model_matrix_lights_the_mesh_where_it_puts_it():
    matrix = np.array([[2.0, 0.5, 0, 1], [0, 1, 0, -2], [0, 0.3, 0.5, 0.5], [0, 0, 0, 1]])
    fine = refine(coarse_sphere(), SUNNY, SHARP, tolerance=STEP, matrix=matrix)
    assert dense_errors(fine, evaluated(SUNNY, SHARP, matrix=matrix)).max() <= STEP
    report = interpolation_error(fine, SUNNY, SHARP, matrix=matrix)
    assert report["phong_interpolation_error"].max() <= STEP
    assert interpolation_error(fine, SUNNY, SHARP)["phong_interpolation_error"].max() > STEP  # lit elsewhere


def test_what_is_already_fine_is_not_split():
    mesh = pv.Sphere(theta_resolution=60, phi_resolution=60)
    lit = refine(mesh, SUNNY, MATT, tolerance=0.05)
    assert np.array_equal(lit.regular_faces, mesh.regular_faces)
    assert np.array_equal(lit.field_data["phong_refinement_points"], [mesh.n_points, mesh.n_points])


def test_colours_are_those_of_shade():
    mesh = torus()
    fine = refine(mesh, SUNNY, SHARP, tolerance=0.02)
    shaded = mesh.phong.shade(SUNNY, SHARP)
    assert np.abs(fine["phong"][: mesh.n_points] - shaded["phong"]).max() <= (4 * math.sqrt(200) + 16) * 2**-24 * 2


# Needles: what falls between all corners


CORNERS = np.array([(0.0, 0, 0), (1, 0, 0), (0.2, 1, 0)])


def triangle():
    return pv.PolyData(CORNERS, faces=[3, 0, 1, 2])


def needle(weights, shininess, model="phong"):
    """A flat triangle's mirror image of the sun, seen at one place of it only."""
    place = np.array(weights) @ CORNERS
    eye = place + np.array([0.9, -1.2, 3.0])
    v = (eye - place) / np.linalg.norm(eye - place)
    sun = ph.DirectionalLight(direction=(v[0], v[1], -v[2]))
    light_model = ph.LightModel(reflection=model)
    scene = ph.Scene(lights=[sun], viewer=ph.Viewer(position=tuple(eye)), light_model=light_model)
    return scene, ph.Material(diffuse=0.2, specular=0.7, shininess=shininess)


@pytest.mark.parametrize("model", ["phong", "blinn-phong"])
@pytest.mark.parametrize("weights", [(0.6, 0.15, 0.25), (0.13, 0.07, 0.8), (0.28, 0.61, 0.11)])
def test_a_needle_that_all_middles_and_the_centroid_miss_is_found(weights, model):
    scene, material = needle(weights, 1e5, model)
    middles = [(0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5), (1 / 3, 1 / 3, 1 / 3)]
    places = np.array([*np.eye(3), *middles]) @ CORNERS
    up = np.broadcast_to((0.0, 0, 1), places.shape)
    colors = ph.evaluate(places, up, scene, material, precision="float64").rgb
    assert np.ptp(colors) < 1e-3  # a pattern of samples finds nothing
    assert interpolation_error(triangle(), scene, material)["phong_interpolation_error"][0] > 0.69
    fine = refine(triangle(), scene, material, tolerance=STEP)
    assert fine["phong"].max() > 0.85
    assert fine.n_points < 2000
    assert dense_errors(fine, evaluated(scene, material), count=200).max() <= STEP


def test_a_needle_is_found_where_normals_turn_too():
    mesh = triangle()
    normals = np.array([(-0.5, -0.4, 1), (0.6, -0.3, 1), (0, 0.7, 1)])
    mesh.point_data.active_normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    sun = ph.DirectionalLight(direction=(-0.1, -0.2, -1))
    scene, material = ph.Scene(lights=[sun], viewer=ph.Viewer(position=(0.5, 0.6, 4))), needle((1, 0, 0), 1e6)[1]
    assert interpolation_error(mesh, scene, material)["phong_interpolation_error"][0] > 0.69


@pytest.mark.parametrize("cone_angle", [5.0, 0.5])
def test_a_spot_inside_a_triangle_is_found(cone_angle):
    spot = ph.SpotLight(position=(0.3, 0.2, 1), direction=(0.05, 0.02, -1), cone_angle=cone_angle)
    assert interpolation_error(triangle(), ph.Scene(lights=[spot]), MATT)["phong_interpolation_error"][0] > 0.75


def test_a_lamp_close_to_a_triangle_is_found():
    lamp = ph.PointLight(position=(0.47, 0.23, 0.01))
    assert interpolation_error(triangle(), ph.Scene(lights=[lamp]), MATT)["phong_interpolation_error"][0] > 0.75


def test_interpolation_error_is_that_of_dense_samples():
    mesh = torus()
    mesh.point_data.active_normals = mesh.phong.normals()
    shaded = mesh.phong.shade(SUNNY, SHARP, precision="float64")
    dense = dense_errors(shaded, textbook, count=300)
    errors = interpolation_error(mesh, SUNNY, SHARP)["phong_interpolation_error"]
    large = dense > 0.05
    assert large.sum() > 20
    assert (errors[large] >= 0.8 * dense[large]).all()
    assert errors.max() >= dense.max()
    assert (errors <= 1.25 * dense + 0.01)[dense > 0.01].mean() > 0.95  # nor does it invent any


def test_interpolation_error_leaves_mesh_and_colours_as_they_are():
    mesh = pv.Sphere().compute_cell_sizes()
    before = mesh.copy()
    result = interpolation_error(mesh, SUNNY, SHARP)
    assert mesh == before
    assert result.active_scalars_name == "phong_interpolation_error"
    assert np.array_equal(result.points, mesh.points)
    assert np.array_equal(result["Area"], mesh["Area"])


# Topology


@pytest.mark.parametrize("placement", ["linear", "smooth"])
@pytest.mark.parametrize("make", [coarse_sphere, torus, pv.Sphere])
def test_closed_stays_closed_and_passes_pyvistas_validation(make, placement):
    mesh = make()
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP, placement=placement)
    assert fine.n_points > mesh.n_points
    assert fine.is_manifold
    assert fine.n_open_edges == 0
    assert fine.validate_mesh().is_valid
    # V − E + F, with 3 F = 2 E on a closed surface
    assert fine.n_points - fine.n_cells // 2 == mesh.n_points - mesh.n_cells // 2


def test_orientation_stays():
    fine = refine(coarse_sphere(), SUNNY, SHARP, tolerance=STEP)
    corners = fine.points[fine.regular_faces]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((outwards * corners.mean(axis=1)).sum(axis=1) > 0).all()


@pytest.mark.parametrize("placement", ["linear", "smooth"])
def test_boundary_stays_boundary(placement):
    mesh = square(3)
    lamp = ph.Scene(lights=[ph.PointLight(position=(0.8, 0.9, 0.2))])
    fine = refine(mesh, lamp, MATT, tolerance=STEP, placement=placement)
    border = fine.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    assert border.n_cells > 12
    assert np.abs(border.points[:, :2]).max(axis=1) == pytest.approx(1.0)  # nothing is open inside
    assert border.compute_cell_sizes()["Length"].sum() == pytest.approx(8.0)
    assert areas(fine).sum() == pytest.approx(4.0)
    assert np.abs(fine.points[:, 2]).max() == 0.0


def test_no_vertex_lies_inside_a_side_of_another_triangle():
    fine = refine(square(), ph.Scene(lights=[ph.PointLight(position=(0.3, 0.4, 0.3))]), MATT, tolerance=0.02)
    points, corners = fine.points[:, :2].astype(float), fine.regular_faces
    assert fine.n_points > 50
    for a, b in zip(points[corners].reshape(-1, 2), points[np.roll(corners, -1, axis=1)].reshape(-1, 2), strict=True):
        along = (points - a) @ (b - a) / ((b - a) @ (b - a))
        beside = np.abs(np.cross(np.column_stack([points - a, np.zeros(len(points))]), (*(b - a), 0))[:, 2])
        assert not ((along > 0.01) & (along < 0.99) & (beside < 1e-7)).any()


def test_sheets_that_meet_in_one_side_keep_meeting():
    points = [(0, 0, 0), (0, 0, 1), (1, 0, 0.5), (-0.5, 0.8, 0.5), (-0.5, -0.8, 0.5)]
    book = pv.PolyData(np.array(points, dtype=float), faces=[3, 0, 1, 2, 3, 0, 1, 3, 3, 0, 1, 4])
    scene = ph.Scene(lights=[ph.PointLight(position=(0.1, 0.02, 0.5))])
    fine = refine(book, scene, MATT, tolerance=STEP, placement="smooth", max_points=3000)
    spine = np.flatnonzero(np.abs(fine.points[:, :2]).max(axis=1) < 1e-12)
    assert len(spine) > 3
    corners = fine.regular_faces
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    inside = sides[np.isin(sides, spine).all(axis=1)]
    unique, counts = np.unique(inside, axis=0, return_counts=True)
    assert len(unique) == len(spine) - 1
    assert (counts == 3).all()


def test_angles_stay_above_half_of_the_smallest():
    for mesh in (coarse_sphere(), torus(), pv.Sphere(theta_resolution=9, phi_resolution=30), square()):
        fine = refine(mesh, SUNNY, SHARP, tolerance=STEP / 4)
        assert smallest_angle(fine) >= 0.499 * smallest_angle(mesh)


def test_long_triangles_are_split_across_too():
    tube = pv.Cylinder(radius=0.5, height=20, resolution=16, capping=False).triangulate()
    tube = tube.compute_normals(split_vertices=False)
    fine = refine(tube, SUNNY, MATT, tolerance=STEP)
    assert stopped(fine) == "tolerance"
    assert fine.n_points < 40 * tube.n_points


# Arrays


def test_original_points_come_first_and_nothing_of_the_input_changes():
    for real in (np.float32, np.float64):
        mesh = torus()
        mesh.points = mesh.points.astype(real) * real(1.1)
        before = mesh.copy()
        fine = refine(mesh, SUNNY, SHARP, tolerance=STEP, placement="smooth")
        assert mesh == before
        assert fine.points.dtype == real
        assert fine.points[: mesh.n_points].tobytes() == mesh.points.tobytes()


def test_point_arrays_are_interpolated():
    mesh = square(2)
    mesh["linear"] = mesh.points @ (2.0, -1.0, 0.0) + 3.0
    mesh["vector"] = mesh.points * (1, 2, 3)
    mesh["label"] = np.arange(mesh.n_points) * 10
    mesh["flag"] = mesh.points[:, 0] > 0.5
    mesh["word"] = [f"p{index}" for index in range(mesh.n_points)]
    mesh["color"] = np.column_stack([np.arange(mesh.n_points) * 20] * 3).astype(np.uint8)
    fine = refine(mesh, ph.Scene(lights=[ph.PointLight(position=(0.3, 0.4, 0.3))]), MATT, tolerance=0.02)
    n = mesh.n_points
    for key in mesh.point_data:
        assert fine[key].dtype == mesh[key].dtype
        assert np.array_equal(fine[key][:n], mesh[key])
    assert fine["linear"] == pytest.approx(fine.points @ (2.0, -1.0, 0.0) + 3.0, abs=1e-6)
    assert fine["vector"] == pytest.approx(fine.points * (1, 2, 3), abs=1e-6)
    assert set(fine["label"]) == set(mesh["label"])  # labels are not averaged
    assert set(fine["word"]) == set(mesh["word"])
    assert np.array_equal(np.char.add("p", (fine["label"] // 10).astype(str)), fine["word"])
    assert fine["flag"].dtype == bool
    assert len(set(fine["color"][:, 0])) > n  # colours are


def test_a_label_comes_from_the_end_with_the_lower_number():
    mesh = triangle()
    mesh["label"] = [7, 8, 9]
    fine = refine(mesh, ph.Scene(lights=[ph.PointLight(position=(0.4, 0.3, 0.1))]), MATT, tolerance=0.01)
    for low, high in ((0, 1), (1, 2), (0, 2)):
        at_middle = np.flatnonzero(np.abs(fine.points - CORNERS[[low, high]].mean(axis=0)).max(axis=1) < 1e-12)
        assert fine["label"][at_middle].tolist() == [7 + low]


def test_cell_arrays_are_copied_to_the_parts():
    mesh = square(2)
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    mesh.cell_data["word"] = [f"c{index}" for index in range(mesh.n_cells)]
    fine = refine(mesh, ph.Scene(lights=[ph.PointLight(position=(0.3, 0.4, 0.3))]), MATT, tolerance=0.02)
    assert np.array_equal(np.char.add("c", fine["number"].astype(str)), fine["word"])
    assert np.bincount(fine["number"], weights=areas(fine)) == pytest.approx(areas(mesh))
    found = mesh.find_containing_cell(fine.cell_centers().points)
    assert np.array_equal(found, fine["number"])


def test_field_data_are_carried():
    mesh = coarse_sphere()
    mesh.field_data["note"] = "kept"
    fine = refine(mesh, SUNNY, SHARP, tolerance=0.1)
    assert fine.field_data["note"] == "kept"


def test_active_normals_are_interpolated_and_made_unit_length():
    mesh = pv.Sphere(theta_resolution=8, phi_resolution=8)
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert fine.point_data.active_normals_name == "Normals"
    assert np.array_equal(fine["Normals"][: mesh.n_points], mesh["Normals"])
    assert np.linalg.norm(fine["Normals"], axis=1) == pytest.approx(1.0, abs=1e-6)


def test_a_mesh_without_normals_gets_those_it_had_before_it_was_split():
    mesh = coarse_sphere()
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert np.array_equal(fine.point_data.active_normals[: mesh.n_points], mesh.phong.normals())
    assert mesh.point_data.active_normals is None
    mesh["Normals"] = np.ones(mesh.n_points)  # a name that is taken
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert fine["Normals"] == pytest.approx(1.0)
    assert fine.point_data.active_normals.shape == (fine.n_points, 3)


def test_normals_of_other_lengths_keep_them():
    mesh = pv.ParametricTorus(u_res=16, v_res=12, w_res=8).clean().triangulate()
    lengths = np.linalg.norm(mesh.point_data.active_normals, axis=1)
    assert lengths.max() > 2 * lengths.min()  # so VTK makes them
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert np.array_equal(fine.point_data.active_normals[: mesh.n_points], mesh.point_data.active_normals)
    assert dense_errors(fine, textbook).max() <= STEP


def test_texture_coordinates_stay_active():
    mesh = pv.Plane(i_resolution=1, j_resolution=1)
    fine = refine(mesh, ph.Scene(lights=[ph.PointLight(position=(0.1, 0.1, 0.1))]), MATT, tolerance=0.05)
    assert fine.active_texture_coordinates == pytest.approx(fine.points[:, :2] + 0.5, abs=1e-6)


def test_names_and_precision():
    fine = refine(coarse_sphere(), SUNNY, SHARP, tolerance=0.05, name="lit", precision="float64")
    assert fine["lit"].dtype == np.float64
    assert fine.active_scalars_name == "lit"
    assert stopped(fine, "lit") == "tolerance"
    assert fine.cell_data["lit_interpolation_error"].max() == left(fine, "lit") <= 0.05
    assert refine(coarse_sphere(), SUNNY, SHARP, tolerance=0.05)["phong"].dtype == np.float32


def test_albedo_is_interpolated():
    mesh = coarse_sphere()
    colors = np.random.default_rng(3).integers(0, 256, (mesh.n_points, 3), dtype=np.uint8)
    mesh["paint"] = colors / 255.0
    by_name = refine(mesh, SUNNY, MATT, tolerance=0.02, albedo="paint")
    by_array = refine(mesh, SUNNY, MATT, tolerance=0.02, albedo=colors)
    assert np.array_equal(by_name["phong"], by_array["phong"])
    expected = evaluated(SUNNY, MATT, albedo=by_name["paint"])(by_name.points, by_name.point_data.active_normals)
    assert by_name["phong"] == pytest.approx(expected, abs=1e-6)
    assert interpolation_error(mesh, SUNNY, MATT, albedo="paint")["phong_interpolation_error"].max() > 0.02


# Kinds of meshes


def test_polygons_and_strips_are_cut_into_triangles():
    quads = pv.Sphere(theta_resolution=8, phi_resolution=8).strip()
    assert quads.n_strips
    plane = pv.Plane(i_resolution=2, j_resolution=2)
    plane.cell_data["number"] = np.arange(4)
    for mesh in (quads, plane):
        fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
        assert fine.is_all_triangles
        assert np.array_equal(fine.points[: mesh.n_points], mesh.points)
    assert np.bincount(fine["number"], weights=areas(fine)) == pytest.approx(0.25)


def test_other_datasets_give_their_surface():
    grid = pv.ImageData(dimensions=(3, 3, 3))
    fine = refine(grid, SUNNY, SHARP, tolerance=STEP)
    assert fine.n_open_edges == 0
    assert areas(fine).sum() == pytest.approx(24.0)


def test_lines_and_vertices_are_left_out():
    mesh = pv.PolyData(np.eye(4, 3), faces=[3, 0, 1, 2], lines=[2, 0, 3], verts=[1, 3])
    mesh.cell_data["number"] = [7, 8, 9]
    before = mesh.copy()
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert mesh == before
    assert fine.n_cells == fine.n_faces
    assert set(fine["number"]) == {9}


def test_smooth_placement_comes_near_the_sphere():
    mesh = coarse_sphere()
    flat, smooth = (
        refine(mesh, SUNNY, SHARP, tolerance=STEP, placement=placement) for placement in ("linear", "smooth")
    )
    off = [np.abs(np.linalg.norm(fine.points, axis=1) - 0.5).max() for fine in (flat, smooth)]
    angle = math.radians(36.0)  # of an icosphere's sides after one subdivision
    assert off[0] == pytest.approx(0.5 * (1 - math.cos(angle / 2) * math.cos(angle / 3)), rel=0.35)
    # On an arc of angle a, the cubic's middle is low by (1 - cos(a/2)) - sin²(a/2) cos(a/2) / 2 = 3 a⁴/128 + O(a⁶).
    assert off[1] < 1.25 * 0.5 * 3 * angle**4 / 128
    assert abs(smooth.volume - math.pi / 6) < abs(flat.volume - math.pi / 6) / 2  # what is not split stays flat


def test_smooth_placement_opens_no_crack_at_a_crease():
    cube = pv.Cube().triangulate().compute_normals(split_vertices=True)
    assert cube.n_open_edges > 0
    scene = ph.Scene(lights=[ph.PointLight(position=(0.9, 0.8, 0.7))])
    fine = refine(cube, scene, MATT, tolerance=STEP, placement="smooth")
    assert fine.n_points > 2 * cube.n_points
    assert np.abs(fine.points).max(axis=1) == pytest.approx(0.5)


# Why it stops


def test_no_more_points_than_allowed_and_the_worst_places_first():
    mesh = pv.Sphere()
    before = interpolation_error(mesh, SUNNY, SHARP)["phong_interpolation_error"].max()
    errors = []
    for limit in (mesh.n_points, 900, 1100, 1500):
        fine = refine(mesh, SUNNY, SHARP, tolerance=STEP / 4, max_points=limit)
        assert limit - 10 <= fine.n_points <= limit
        assert stopped(fine) == "max_points"
        errors.append(left(fine))
        assert dense_errors(fine, textbook).max() <= left(fine) * 1.07
    assert errors[0] == pytest.approx(before)
    assert errors[-1] < before / 10
    assert errors == sorted(errors, reverse=True)


def test_a_jump_of_the_colour_ends_it():
    spot = ph.SpotLight(position=(0.2, 0.1, 1), direction=(0, 0, -1), cone_angle=20, exponent=0)
    scene = ph.Scene(lights=[spot], light_model=ph.LightModel(ambient=0))
    fine = refine(square(), scene, MATT, tolerance=STEP)
    assert stopped(fine) == "jump"
    assert left(fine) > 0.3
    bad = fine["phong_interpolation_error"] > STEP
    assert np.sqrt(areas(fine)[bad].max()) < math.sqrt(8) / 1024  # thinner than a pixel of the diagonal
    away = fine.cell_centers().points[bad][:, :2] - (0.2, 0.1)
    assert np.linalg.norm(away, axis=1) == pytest.approx(math.tan(math.radians(20)), abs=math.sqrt(8) / 1024)
    assert dense_errors(fine, evaluated(scene, MATT))[~bad].max() <= STEP
    assert fine.n_points < 20_000


def test_the_points_precision_ends_it():
    mesh = square()
    mesh.points = (mesh.points.astype(float) + np.array([1e6, 0, 0])).astype(np.float32)
    scene, material = ph.Scene(lights=[ph.PointLight(position=(1e6 + 0.3, 0.2, 0.05))]), MATT
    fine = refine(mesh, scene, material, tolerance=1e-4)
    assert stopped(fine) == "resolution"
    assert left(fine) > 1e-4
    assert areas(fine).min() > 0


def test_zero_normals_are_a_jump_and_not_an_endless_task():
    mesh = coarse_sphere()
    normals = mesh.phong.normals()
    normals[5] = 0
    mesh.point_data.active_normals = normals
    fine = refine(mesh, SUNNY, MATT, tolerance=STEP)
    assert stopped(fine) == "jump"
    assert fine.n_points < 3000


def test_triangles_without_area_end_and_keep_their_neighbours_whole():
    points = np.array([(0, 0, 0), (1, 0, 0), (0.5, 0, 0), (0, 1, 0), (1, 1, 0)], dtype=float)
    faces = [3, 0, 1, 2, 3, 0, 2, 3, 3, 2, 1, 4, 3, 2, 4, 3, 3, 3, 3, 4, 3, 1, 1, 1]
    mesh = pv.PolyData(points, faces=faces)
    scene = ph.Scene(lights=[ph.PointLight(position=(0.5, 0.1, 0.1))])
    fine = refine(mesh, scene, MATT, tolerance=STEP)
    assert stopped(fine) == "tolerance"
    assert areas(fine).sum() == pytest.approx(1.0)
    errors = interpolation_error(mesh, scene, MATT)["phong_interpolation_error"]
    assert (errors[[0, 4, 5]] == 0).all()
    assert (errors[1:4] > 0.1).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_points_that_are_not_finite_are_left_alone(bad):
    mesh = square(4)
    mesh.points[7] = bad
    scene = ph.Scene(lights=[ph.PointLight(position=(0.5, 0.1, 0.1))])
    fine = refine(mesh, scene, MATT, tolerance=STEP, placement="smooth")
    assert stopped(fine) == "tolerance"
    assert np.isfinite(fine.points).all(axis=1).sum() == fine.n_points - 1
    assert np.isfinite(fine["phong"]).all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(3, 20),
    faces=st.integers(1, 25),
    scale=st.sampled_from([1e-30, 1e-3, 1.0, 1e4, 1e20]),
    placement=st.sampled_from(["linear", "smooth"]),
    model=st.builds(
        ph.LightModel,
        two_sided=st.booleans(),
        clamp=st.booleans(),
        reflection=st.sampled_from(["phong", "blinn-phong"]),
    ),
)
def test_any_soup_of_triangles_ends_within_its_points(seed, count, faces, scale, placement, model):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3)) * scale
    points[rng.integers(count)] = rng.choice([0.0, np.nan, np.inf, points[0, 0]])
    mesh = pv.PolyData.from_regular_faces(points, rng.integers(0, count, (faces, 3)))
    normals = rng.normal(size=(count, 3))
    normals[rng.integers(count)] = rng.choice([0.0, np.nan, 1e300])
    mesh.point_data.active_normals = normals
    lights = [
        ph.DirectionalLight(direction=tuple(rng.normal(size=3)), diffuse=0.5),
        ph.SpotLight(
            position=tuple(3 * scale * rng.normal(size=3)), direction=tuple(rng.normal(size=3)), cone_angle=70
        ),
    ]
    viewer = ph.Viewer(position=tuple(3 * scale * rng.normal(size=3)), focal_point=(9 * scale, 0, 0))
    scene = ph.Scene(lights=lights, viewer=viewer, light_model=model)
    material = ph.Material(diffuse=0.6, specular=0.5, shininess=float(10 ** rng.uniform(-1, 5)))
    fine = refine(mesh, scene, material, tolerance=0.01, max_points=count + 500, placement=placement)
    assert fine.n_points <= count + 500
    assert fine.points[:count].tobytes() == mesh.points.tobytes()
    assert np.isfinite(fine.points[count:]).all()
    assert np.isfinite(fine["phong"]).all()
    assert stopped(fine) in {"tolerance", "max_points", "jump", "resolution"}
    assert (left(fine) <= 0.01) == (stopped(fine) == "tolerance")


# Arguments


@pytest.mark.parametrize("tolerance", [0, -1, np.nan, None, "1"])
def test_tolerance_is_positive(tolerance):
    with pytest.raises(ValueError, match=r"tolerance must be a finite number > 0; got"):
        refine(coarse_sphere(), SUNNY, SHARP, tolerance=tolerance)


@pytest.mark.parametrize("max_points", [41, 0, 100.0, True, "many"])
def test_max_points_is_an_integer_not_below_the_meshs_points(max_points):
    with pytest.raises(ValueError, match=r"max_points must be an integer >= 42, the points that the mesh has"):
        refine(coarse_sphere(), SUNNY, SHARP, tolerance=0.1, max_points=max_points)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"placement": "Smooth"}, r"placement must be one of 'linear', 'smooth'; got Smooth\. Did you mean 'smooth'"),
        ({"precision": "float16"}, "precision must be one of 'float32', 'float64'"),
        ({"name": ""}, "name must be a string that is not empty"),
        ({"albedo": "paint"}, "albedo must be one of"),
        ({"albedo": np.ones((3, 3))}, r"albedo must be an array with one row per point, 42 rows; got 3 rows"),
        ({"matrix": np.eye(3)}, "matrix must be a 4x4 matrix"),
    ],
)
def test_other_arguments_are_checked(options, message):
    with pytest.raises(ValueError, match=message):
        refine(coarse_sphere(), SUNNY, SHARP, tolerance=0.1, **options)


def test_scene_material_and_mesh_are_checked():
    with pytest.raises(ValueError, match="scene must be a Scene"):
        refine(coarse_sphere(), SHARP, SHARP, tolerance=0.1)
    with pytest.raises(ValueError, match="material must be a Material"):
        interpolation_error(coarse_sphere(), SUNNY, SUNNY)
    cloud = pv.PolyData(np.eye(3))
    cloud.point_data.active_normals = np.eye(3)
    for call in (interpolation_error, lambda *args: refine(*args, tolerance=0.1)):
        with pytest.raises(ValueError, match=r"mesh must be a mesh with faces; got 3 points without faces"):
            call(cloud, SUNNY, SHARP)
