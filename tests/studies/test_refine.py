"""Refined meshes: their errors against dense sampling, topology, arrays, and stopping conditions."""

import math
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from strategies import hunt, moderate_case

import pvphong as ph
from pvphong.meshes.surfaces import surface
from pvphong.studies.refine import interpolation_error, refine

STEP = 1 / 255
TO_LIGHT = np.array([1.0, 1.0, 2.0]) / math.sqrt(6.0)
EYE = (3.0, -1.0, 4.0)
SUN = ph.DirectionalLight(direction=tuple(-TO_LIGHT))
SUNNY = ph.Scene(lights=[SUN], viewer=ph.Viewer(position=EYE), light_model=ph.LightModel(ambient=0.2))
SHARP = ph.Material(ambient=0.1, diffuse=0.5, specular=0.4, shininess=200)
GLOSSY = ph.Material(diffuse=0.9, specular=0.6, shininess=30)
MATT = ph.Material(diffuse=0.8)


def lamp_at(*position):
    return ph.Scene(lights=[ph.PointLight(position=position)])


def evaluated(scene, material, **options):
    """Return per-pixel shading at any places, by `evaluate`."""

    def colors(points, normals):
        rows = points.reshape(-1, 3), normals.reshape(-1, 3)
        return ph.evaluate(*rows, scene, material, precision="float64", **options).rgb.reshape(points.shape)

    return colors


SHARP_TRUTH = evaluated(SUNNY, SHARP)


def dense_errors(mesh, truth, count=60):
    """Return each triangle's largest error at random places, which differ between triangles."""
    rng = np.random.default_rng(7)
    corners = mesh.regular_faces
    arrays = mesh.points, mesh.point_data.active_normals, mesh["phong"]
    at_corners = np.concatenate([array.astype(float)[corners] for array in arrays], axis=2)
    worst = np.zeros(len(corners))
    for _ in range(count):
        weights = rng.dirichlet(np.full(3, rng.choice([0.3, 1, 3])), size=len(corners))
        place, normal, color = np.split(np.einsum("ij,ijk->ik", weights, at_corners), 3, axis=1)
        worst = np.maximum(worst, np.abs(truth(place, normal) - color).max(axis=1))
    return worst


def largest(mesh, scene, material, **options):
    return interpolation_error(mesh, scene, material, **options)["phong_interpolation_error"].max()


def left(mesh, name="phong"):
    return float(mesh.field_data[f"{name}_refinement_error"][0])


def stopped(mesh, name="phong"):
    """Return why the refinement stopped, after checking that the flag and the summary agree."""
    why = mesh.field_data[f"{name}_refinement_stopped"]
    reached = mesh.field_data[f"{name}_refinement_reached"]
    assert (reached.shape, reached.dtype) == ((1,), bool)
    assert reached[0] == (why == "tolerance")
    said = mesh.field_data[f"{name}_refinement_summary"]
    assert said.startswith("Within" if reached[0] else "Not within")
    assert f"off by up to {left(mesh, name):.3g}" in said
    assert f" {mesh.n_points} points" in said
    return why


def coarse_sphere():
    sphere = pv.Icosphere(nsub=1, radius=0.5)  # 42 points
    sphere.clear_data()
    return sphere


def uneven_torus():
    """Return a torus with normals of different lengths, as VTK generates them."""
    mesh = pv.ParametricTorus(u_res=16, v_res=12, w_res=8).clean().triangulate()
    lengths = np.linalg.norm(mesh.point_data.active_normals, axis=1)
    assert lengths.max() > 2 * lengths.min()
    return mesh


def torus():
    mesh = uneven_torus()
    mesh.clear_data()
    return mesh


def square(count=1):
    mesh = pv.Plane(i_size=2, j_size=2, i_resolution=count, j_resolution=count).triangulate()
    mesh.clear_data()
    return mesh


def smallest_angle(mesh):
    corners = mesh.points.astype(float)[mesh.regular_faces]
    a, b = (np.roll(corners, shift, axis=1) - corners for shift in (1, -1))
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=2), (a * b).sum(axis=2)).min()


def areas(mesh):
    corners = mesh.points.astype(float)[mesh.regular_faces]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


LAMPS = [
    SUN,
    ph.PointLight(position=(0.4, 0.5, 1.2), diffuse=(0.9, 0.3, 0.2)),
    ph.SpotLight(position=(1.5, 0, 1.5), direction=(-1, 0, -1), cone_angle=60, exponent=40),
]
MODELS = {
    "Blinn-Phong": ph.LightModel(reflection="blinn-phong"),
    "a far viewer": ph.LightModel(local_viewer=False),
    "no clamping": ph.LightModel(clamp=False),
    "VTK's model": ph.LightModel.vtk(two_sided=False),
}
MATRIX = np.array([[2.0, 0.5, 0, 1], [0, 1, 0, -2], [0, 0.3, 0.5, 0.5], [0, 0, 0, 1]])
FROM_ABOVE = ph.DirectionalLight(direction=(0, 0, -1))
HELD = {
    "a highlight on a sphere": (coarse_sphere, SUNNY, SHARP, {}),
    "on a smooth sphere": (coarse_sphere, SUNNY, SHARP, {"placement": "smooth"}),
    "on a torus": (torus, SUNNY, SHARP, {}),
    "on a smooth torus": (torus, SUNNY, SHARP, {"placement": "smooth"}),
    "moved by a matrix": (coarse_sphere, SUNNY, SHARP, {"matrix": MATRIX}),
    "the rim of the dark side": (coarse_sphere, ph.Scene([FROM_ABOVE]), MATT, {}),
    "colours that reach white": (coarse_sphere, ph.Scene([replace(FROM_ABOVE, intensity=3)]), MATT, {}),
} | {
    name: (torus, ph.Scene(LAMPS, ph.Viewer(position=EYE), model), GLOSSY, {"tolerance": 0.01, "precision": "float64"})
    for name, model in MODELS.items()
}


@pytest.mark.parametrize(("make", "scene", "material", "options"), HELD.values(), ids=HELD.keys())
def test_dense_samples_are_within_the_tolerance(make, scene, material, options):
    options = {"tolerance": STEP} | options
    fine = refine(make(), scene, material, **options)
    errors = dense_errors(fine, evaluated(scene, material, matrix=options.get("matrix")), count=100)
    assert stopped(fine) == "tolerance"
    assert left(fine) <= options["tolerance"]
    assert errors.max() <= options["tolerance"]
    assert errors.max() <= left(fine) * 1.07  # the reported error, except between its samples
    reported = fine["phong_interpolation_error"]
    close = reported > 0.7 * options["tolerance"]  # samples are dense there
    assert (errors[close] <= 1.1 * reported[close]).all()
    if "matrix" in options:
        assert largest(fine, scene, material, matrix=MATRIX) <= STEP < largest(fine, scene, material)  # other lighting


def test_what_is_already_fine_is_not_split():
    mesh = pv.Sphere(theta_resolution=60, phi_resolution=60)
    lit = refine(mesh, SUNNY, MATT, tolerance=0.05)
    assert np.array_equal(lit.regular_faces, mesh.regular_faces)
    assert np.array_equal(lit.field_data["phong_refinement_points"], [mesh.n_points, mesh.n_points])


def test_sharp_edges_are_split_before_triangles_and_stay_where_they_are():
    cube, lamp = pv.Cube(clean=True).triangulate(), lamp_at(0.8, 0.6, 0.9)
    cube.clear_data()
    fine = refine(cube, lamp, MATT, tolerance=0.02, feature_angle=30)
    assert stopped(fine) == "tolerance"
    flat, first = np.abs(fine.point_data.active_normals), fine["pvphong_original_point"]
    np.testing.assert_array_equal(np.sort(flat, axis=1), np.tile((0.0, 0.0, 1.0), (len(flat), 1)))
    assert set(first[:24]) == set(range(8))
    np.testing.assert_array_equal(fine.points[:24], cube.points[first[:24]])
    assert (first[24:] == -1).all()
    assert fine.n_points > 24

    sharp = cube.phong.shade(lamp, MATT, feature_angle="auto")
    errors = interpolation_error(cube, lamp, MATT, feature_angle="auto")["phong_interpolation_error"]
    np.testing.assert_allclose(errors, interpolation_error(sharp, lamp, MATT)["phong_interpolation_error"])
    assert np.abs(errors - interpolation_error(cube, lamp, MATT)["phong_interpolation_error"]).max() > 0.01


# Needles: features between all corners


CORNERS = np.array([(0.0, 0, 0), (1, 0, 0), (0.2, 1, 0)])


def triangle():
    return pv.PolyData(CORNERS, faces=[3, 0, 1, 2])


def needle(weights, shininess, model="phong"):
    """Return a scene and a material in which the sun's reflection is visible at one place of a flat triangle only."""
    place = np.array(weights) @ CORNERS
    eye = place + np.array([0.9, -1.2, 3.0])
    v = (eye - place) / np.linalg.norm(eye - place)
    sun = ph.DirectionalLight(direction=(v[0], v[1], -v[2]))
    scene = ph.Scene([sun], ph.Viewer(position=tuple(eye)), ph.LightModel(reflection=model))
    return scene, ph.Material(diffuse=0.2, specular=0.7, shininess=shininess)


@pytest.mark.parametrize(
    ("weights", "model"),
    [((0.6, 0.15, 0.25), "phong"), ((0.13, 0.07, 0.8), "phong"), ((0.28, 0.61, 0.11), "blinn-phong")],
)
def test_a_needle_that_all_middles_and_the_centroid_miss_is_found(weights, model):
    scene, material = needle(weights, 1e5, model)
    middles = [(0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5), (1 / 3, 1 / 3, 1 / 3)]
    places = np.array([*np.eye(3), *middles]) @ CORNERS
    up = np.broadcast_to((0.0, 0, 1), places.shape)
    colors = ph.evaluate(places, up, scene, material, precision="float64").rgb
    assert np.ptp(colors) < 1e-3  # a fixed pattern of samples misses it
    assert largest(triangle(), scene, material) > 0.69
    fine = refine(triangle(), scene, material, tolerance=STEP)
    assert fine["phong"].max() > 0.85
    assert fine.n_points < 2000
    assert dense_errors(fine, evaluated(scene, material), count=200).max() <= STEP


TURNING = triangle()
TURNING.point_data.active_normals = [(-0.42, -0.34, 0.84), (0.5, -0.25, 0.83), (0, 0.57, 0.82)]
SMALL_SPOT = ph.SpotLight(position=(0.3, 0.2, 1), direction=(0.05, 0.02, -1), cone_angle=0.5)
CONE = math.radians(20)
WIDE_SPOT = ph.SpotLight(position=(0.05 - 100 * math.tan(CONE), 0, 100), cone_angle=20, exponent=0, intensity=0.004)
SKEWED = ph.Scene([ph.DirectionalLight(direction=(-0.1, -0.2, -1))], ph.Viewer(position=(0.5, 0.6, 4)))


@pytest.mark.parametrize(
    ("mesh", "scene", "material", "error"),
    [
        (TURNING, SKEWED, needle((1, 0, 0), 1e6)[1], 0.69),
        (triangle(), ph.Scene([SMALL_SPOT]), MATT, 0.75),
        (triangle(), ph.Scene([WIDE_SPOT]), MATT, 0.9 * 0.8 * 0.004 * math.cos(CONE)),
        (triangle(), lamp_at(0.47, 0.23, 0.01), MATT, 0.75),
    ],
    ids=["normals that turn", "a small spot", "the edge of a wide and faint one", "a lamp close by"],
)
def test_what_shines_inside_a_triangle_only_is_found(mesh, scene, material, error):
    assert largest(mesh, scene, material) > error


def test_interpolation_error_is_that_of_dense_samples():
    mesh = torus().compute_cell_sizes()
    mesh.point_data.active_normals = mesh.phong.normals()
    shaded = mesh.phong.shade(SUNNY, SHARP, precision="float64")
    dense = dense_errors(shaded, SHARP_TRUTH, count=300)
    result = interpolation_error(mesh, SUNNY, SHARP)
    assert result.active_scalars_name == "phong_interpolation_error"
    assert np.array_equal(result.points, mesh.points)
    assert np.array_equal(result["Area"], mesh["Area"])
    errors = result["phong_interpolation_error"]
    large = dense > 0.05
    assert large.sum() > 20
    assert (errors[large] >= 0.8 * dense[large]).all()
    assert errors.max() >= dense.max()
    assert (errors <= 1.25 * dense + 0.01)[dense > 0.01].mean() > 0.95  # no spurious errors


# Topology


def strips():
    mesh = pv.Sphere(theta_resolution=8, phi_resolution=8).strip()
    assert mesh.n_strips
    return mesh


def triangle_and_strip():
    """Return a triangle next to a strip of two triangles."""
    mesh = pv.PolyData(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 2, 0)], float), faces=[3, 0, 1, 2])
    mesh.SetStrips(pv.CellArray([4, 2, 1, 4, 3]))
    return mesh


def book():
    """Return three triangles that share one side."""
    points = [(0, 0, 0), (0, 0, 1), (1, 0, 0.5), (-0.5, 0.8, 0.5), (-0.5, -0.8, 0.5)]
    return pv.PolyData(np.array(points, dtype=float), faces=[3, 0, 1, 2, 3, 0, 1, 3, 3, 0, 1, 4])


SHAPES = {
    "closed": coarse_sphere,
    "with a hole through": torus,
    "with poles": pv.Sphere,
    "strips": strips,
    "a strip beside a triangle": triangle_and_strip,
    "open": lambda: square(3),
    "quads": lambda: pv.Plane(i_resolution=2, j_resolution=2),
    "pages that meet": book,
    "creases": lambda: pv.Cube().triangulate().compute_normals(split_vertices=True),
    "a volume": lambda: pv.ImageData(dimensions=(3, 3, 3)),
}


def sides_of(mesh):
    """Return the number of sides, and, by their count of triangles if not 2, numbers and total lengths."""
    corners = mesh.regular_faces
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    sides, counts = np.unique(sides, axis=0, return_counts=True)
    a, b = mesh.points.astype(float)[sides.T]
    lengths, others = np.linalg.norm(a - b, axis=1), set(counts.tolist()) - {2}
    return len(sides), {n: (counts == n).sum() for n in others}, {n: lengths[counts == n].sum() for n in others}


@pytest.mark.parametrize("placement", ["linear", "smooth"])
@pytest.mark.parametrize("shape", SHAPES)
def test_what_hangs_together_stays_so_and_nothing_of_the_input_changes(shape, placement):
    """T-junctions and cracks would change the total length of open sides."""
    mesh = SHAPES[shape]()
    before, whole = mesh.copy(), surface(mesh).triangulate()
    scene = ph.Scene(lights=[SUN, ph.PointLight(position=(0.9, 0.8, 0.7))], viewer=ph.Viewer(position=EYE))
    fine = refine(mesh, scene, SHARP, tolerance=STEP, placement=placement, max_points=4000)
    assert mesh == before
    assert fine.n_points > whole.n_points
    assert fine.points.dtype == whole.points.dtype
    assert fine.points[: whole.n_points].tobytes() == whole.points.tobytes()
    shaded = mesh.phong.shade(scene, SHARP)["phong"]
    assert np.abs(fine["phong"][: whole.n_points] - shaded).max() <= (4 * math.sqrt(200) + 16) * 2**-23
    (count, open_sides, lengths), (count_before, open_before, lengths_before) = map(sides_of, (fine, whole))
    assert lengths == pytest.approx(lengths_before)
    assert all(open_sides[n] > open_before[n] for n in open_before)  # they were split
    assert fine.n_points - count + fine.n_cells == whole.n_points - count_before + whole.n_cells  # Euler's number
    assert fine.validate_mesh().is_valid
    if placement == "linear" or shape in {"open", "quads", "creases"}:  # flat
        assert areas(fine).sum() == pytest.approx(areas(whole).sum())
    corners, normals = fine.points[fine.regular_faces], fine.point_data.active_normals[fine.regular_faces]
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((own * normals.sum(axis=1)).sum(axis=1) > 0).all() or shape == "pages that meet"  # same orientation


def test_angles_stay_above_half_of_the_smallest():
    for mesh in (coarse_sphere(), torus(), pv.Sphere(theta_resolution=9, phi_resolution=30), square()):
        fine = refine(mesh, SUNNY, SHARP, tolerance=STEP / 4)
        assert smallest_angle(fine) >= 0.499 * smallest_angle(mesh)


# Arrays


def test_colours_take_no_name_of_normals_and_those_that_are_made_have_another():
    with pytest.raises(ValueError, match=r"^name must be different from .* got 'Normals', the name of the mesh's"):
        refine(pv.Sphere(), SUNNY, MATT, tolerance=0.1, name="Normals")
    bare = pv.Sphere()
    bare.clear_data()
    lit = refine(bare, SUNNY, MATT, tolerance=0.1, name="Normals")
    assert (lit.active_scalars_name, lit.point_data.active_normals_name) == ("Normals", "Normals_")


def test_point_arrays_are_interpolated():
    mesh = square(2)
    mesh["vector"] = mesh.points * (1, 2, 3)
    mesh["label"] = np.arange(mesh.n_points) * 10
    mesh["word"] = [f"p{index}" for index in range(mesh.n_points)]
    mesh["color"] = np.column_stack([np.arange(mesh.n_points) * 20] * 3).astype(np.uint8)
    mesh["place"] = mesh.points[:, :2] + 1
    mesh.point_data.active_texture_coordinates_name = "place"
    fine = refine(mesh, lamp_at(0.3, 0.4, 0.3), MATT, tolerance=0.02)
    n = mesh.n_points
    for key in mesh.point_data:
        assert fine[key].dtype == mesh[key].dtype
        assert np.array_equal(fine[key][:n], mesh[key])
    assert fine["vector"] == pytest.approx(fine.points * (1, 2, 3), abs=1e-6)
    assert set(fine["label"]) == set(mesh["label"])  # labels are not averaged
    assert set(fine["word"]) == set(mesh["word"])
    assert np.array_equal(np.char.add("p", (fine["label"] // 10).astype(str)), fine["word"])
    assert len(set(fine["color"][:, 0])) > n  # colours are averaged
    assert fine.active_texture_coordinates == pytest.approx(fine.points[:, :2] + 1, abs=1e-6)
    mesh = triangle()  # a label is copied from the end with the lower number
    mesh["label"] = [7, 8, 9]
    fine = refine(mesh, lamp_at(0.4, 0.3, 0.1), MATT, tolerance=0.01)
    for low, high in ((0, 1), (1, 2), (0, 2)):
        at_middle = np.flatnonzero(np.abs(fine.points - CORNERS[[low, high]].mean(axis=0)).max(axis=1) < 1e-12)
        assert fine["label"][at_middle].tolist() == [7 + low]


@pytest.mark.parametrize("make", [lambda: square(2), lambda: pv.Plane(i_size=2, j_size=2, i_resolution=2)])
def test_cell_arrays_are_copied_to_the_parts(make):
    mesh = make()
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    mesh.cell_data["word"] = [f"c{index}" for index in range(mesh.n_cells)]
    fine = refine(mesh, lamp_at(0.3, 0.4, 0.3), MATT, tolerance=0.02)
    assert np.array_equal(np.char.add("c", fine["number"].astype(str)), fine["word"])
    assert np.bincount(fine["number"], weights=areas(fine)) == pytest.approx(mesh.compute_cell_sizes()["Area"])
    found = mesh.find_containing_cell(fine.cell_centers().points)
    assert np.array_equal(found, fine["number"])


@pytest.mark.parametrize("make", [lambda: pv.Sphere(theta_resolution=8, phi_resolution=8), uneven_torus])
def test_active_normals_are_interpolated_and_keep_their_lengths(make):
    mesh = make()
    lengths = np.linalg.norm(mesh.point_data.active_normals, axis=1)
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert fine.point_data.active_normals_name == "Normals"
    assert np.array_equal(fine["Normals"][: mesh.n_points], mesh["Normals"])
    new = np.linalg.norm(fine["Normals"], axis=1)
    assert lengths.min() * (1 - 1e-6) <= new.min() <= new.max() <= lengths.max() * (1 + 1e-6)
    assert dense_errors(fine, SHARP_TRUTH).max() <= STEP


def test_a_mesh_without_normals_gets_those_it_had_before_it_was_split():
    mesh = coarse_sphere()
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert np.array_equal(fine.point_data.active_normals[: mesh.n_points], mesh.phong.normals())
    assert mesh.point_data.active_normals is None
    mesh["Normals"] = np.ones(mesh.n_points)  # the default name is taken
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
    assert fine["Normals"] == pytest.approx(1.0)
    assert fine.point_data.active_normals.shape == (fine.n_points, 3)


def test_names_precision_and_albedo():
    mesh = coarse_sphere()
    mesh.field_data["note"] = "kept"
    mesh["paint"] = np.random.default_rng(3).uniform(size=(mesh.n_points, 3))
    painted = replace(MATT, albedo="paint")
    fine = refine(mesh, SUNNY, painted, tolerance=0.02, name="lit", precision="float64")
    assert fine.field_data["note"] == "kept"
    assert fine["lit"].dtype == np.float64
    assert fine.active_scalars_name == "lit"
    assert stopped(fine, "lit") == "tolerance"
    assert fine.cell_data["lit_interpolation_error"].max() == left(fine, "lit") <= 0.02
    expected = evaluated(SUNNY, replace(MATT, albedo=fine["paint"]))(fine.points, fine.point_data.active_normals)
    assert fine["lit"] == pytest.approx(expected, abs=1e-6)
    assert largest(mesh, SUNNY, painted) > 0.02 > largest(fine, SUNNY, painted)


def test_lines_and_vertices_are_left_out():
    mesh = pv.PolyData(np.eye(4, 3), faces=[3, 0, 1, 2], lines=[2, 0, 3], verts=[1, 3])
    mesh.cell_data["number"] = [7, 8, 9]
    fine = refine(mesh, SUNNY, SHARP, tolerance=STEP)
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
    assert abs(smooth.volume - math.pi / 6) < abs(flat.volume - math.pi / 6) / 2  # unsplit triangles stay flat


def test_no_more_points_than_allowed_and_the_worst_places_first():
    mesh = pv.Sphere()
    errors = []
    for limit in (mesh.n_points, 900, 1100, 1500):
        fine = refine(mesh, SUNNY, SHARP, tolerance=STEP / 4, max_points=limit)
        assert limit - 10 <= fine.n_points <= limit
        assert stopped(fine) == "max_points"
        errors.append(left(fine))
        assert dense_errors(fine, SHARP_TRUTH).max() <= left(fine) * 1.07
    assert errors[0] == pytest.approx(largest(mesh, SUNNY, SHARP))
    assert errors[-1] < errors[0] / 10
    assert errors == sorted(errors, reverse=True)


def test_a_jump_of_the_colour_ends_it():
    spot = ph.SpotLight(position=(0.2, 0.1, 1), direction=(0, 0, -1), cone_angle=20, exponent=0)
    scene = ph.Scene(lights=[spot], light_model=ph.LightModel(ambient=0))
    fine = refine(square(), scene, MATT, tolerance=STEP, cut=False)
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
    scene, material = lamp_at(1e6 + 0.3, 0.2, 0.05), MATT
    fine = refine(mesh, scene, material, tolerance=1e-4)
    assert stopped(fine) == "resolution"
    assert left(fine) > 1e-4
    assert areas(fine).min() > 0


def test_triangles_without_area_end_and_keep_their_neighbours_whole():
    points = np.array([(0, 0, 0), (1, 0, 0), (0.5, 0, 0), (0, 1, 0), (1, 1, 0)], dtype=float)
    faces = [3, 0, 1, 2, 3, 0, 2, 3, 3, 2, 1, 4, 3, 2, 4, 3, 3, 3, 3, 4, 3, 1, 1, 1]
    mesh = pv.PolyData(points, faces=faces)
    scene = lamp_at(0.5, 0.1, 0.1)
    fine = refine(mesh, scene, MATT, tolerance=STEP)
    assert stopped(fine) == "tolerance"
    assert areas(fine).sum() == pytest.approx(1.0)
    errors = interpolation_error(mesh, scene, MATT)["phong_interpolation_error"]
    assert (errors[[0, 4, 5]] == 0).all()
    assert (errors[1:4] > 0.1).all()


@pytest.mark.parametrize("examples", [pytest.param(8, id="few"), pytest.param(1000, id="many", marks=pytest.mark.long)])
def test_any_soup_of_triangles_ends_within_its_points(examples):
    def check(dice):
        case, count = moderate_case(dice, "standard"), dice.randint(3, 20)
        scale = dice.choice([1e-30, 1e-3, 1.0, 1e4, 1e20])
        rng = np.random.default_rng(dice.getrandbits(64))
        points, normals = rng.normal(size=(count, 3)) * scale, rng.normal(size=(count, 3))
        points[rng.integers(count)] = rng.choice([0.0, np.nan, np.inf, points[0, 0]])
        normals[rng.integers(count)] = rng.choice([0.0, np.nan, 1e300])
        mesh = pv.PolyData.from_regular_faces(points, rng.integers(0, count, (dice.randint(1, 25), 3)))
        mesh.point_data.active_normals = normals

        def scaled(thing):
            places = (name for name in ("position", "focal_point") if hasattr(thing, name))
            return replace(thing, **{name: tuple(scale * np.array(getattr(thing, name))) for name in places})

        scene = replace(case.scene, lights=map(scaled, case.scene.lights), viewer=scaled(case.scene.viewer))
        options = {"tolerance": 0.01, "max_points": count + 500, "placement": dice.choice(("linear", "smooth"))}
        fine = refine(mesh, scene, case.material, **options)
        assert fine.n_points <= count + 500
        assert fine.points[:count].tobytes() == mesh.points.tobytes()
        assert np.isfinite(fine.points[count:]).all()
        assert np.isfinite(fine["phong"]).all()
        assert stopped(fine) in {"tolerance", "max_points", "jump", "resolution"}
        assert (left(fine) <= 0.01) == (stopped(fine) == "tolerance")

    hunt(lambda dice: dice, check, examples)


CLOUD = pv.PolyData(np.eye(3))
CLOUD.point_data.active_normals = np.eye(3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        *(({"tolerance": bad}, "tolerance must be a finite number > 0; got") for bad in (0, -1, np.nan, None, "1")),
        *(
            ({"max_points": bad}, "max_points must be an integer >= 42, the mesh's number of points")
            for bad in (41, 0, 100.0, True, "many")
        ),
        ({"placement": "Smooth"}, r"placement must be one of 'linear', 'smooth'; got Smooth\. Did you mean 'smooth'"),
        ({"mesh": CLOUD}, r"mesh must be a mesh with faces; got 3 points without faces"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    given = {"mesh": coarse_sphere(), "scene": SUNNY, "material": SHARP, "tolerance": 0.1} | arguments
    with pytest.raises(ValueError, match=message):
        refine(**given)
    if "mesh" in arguments:
        del given["tolerance"]
        with pytest.raises(ValueError, match=message):
            interpolation_error(**given)
