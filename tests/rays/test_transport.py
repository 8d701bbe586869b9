"""Light transport between vertices: closed-form form factors, reciprocity, energy, files, in all backends."""

import math
import re

import numpy as np
import pytest
import pyvista as pv
from ray_backends import BACKENDS
from rays.rooms import room, wall

import pvphong as ph
from pvphong.base import text, threads
from pvphong.rays import casting
from pvphong.rays import transport as transports


@pytest.fixture
def backend(request, monkeypatch):
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[request.param], ""))
    return request.param


def shares_of(receiver, target, samples=1024):
    """Return the part of each vertex's hemisphere that another mesh fills."""
    blocks = pv.MultiBlock([receiver, target])
    among = blocks.phong.transport(samples=samples)
    colors = np.zeros((len(among), 1))
    colors[receiver.n_points :] = 1.0
    return among.gather(colors)[: receiver.n_points, 0]


# --- form factors from a surface element to a shape: J. R. Howell, "A catalog of radiation heat transfer configuration
# factors"


def parallel(a, b, h):
    """Form factor to a rectangle (0, 0) to (a, b) in a parallel plane, with a corner along the normal (B-3)."""
    x, y = a / h, b / h
    p, q = np.sqrt(1 + x * x), np.sqrt(1 + y * y)
    return (x / p * np.arctan(y / p) + y / q * np.arctan(x / q)) / (2 * math.pi)


def perpendicular(width, height, h):
    """Form factor to a rectangle in a perpendicular plane, with a lower corner straight ahead (B-4)."""
    x, y = height / width, h / width
    root = np.sqrt(x * x + y * y)
    return (np.arctan(1 / y) - y / root * np.arctan(1 / root)) / (2 * math.pi)


def to_parallel_square(points):
    x, y, z = points.T
    corners = [(a, b) for a in (0.5 - x, 0.5 + x) for b in (0.5 - y, 0.5 + y)]
    return sum(parallel(a, b, 0.75 - z) for a, b in corners)  # odd in either


def to_square_at_right_angles(points):
    x, y, _ = points.T
    return sum(perpendicular(width, 1.0, 0.6 + y) for width in np.maximum((0.5 - x, 0.5 + x), 1e-9))


def to_disk(points):
    """Form factor to a disk of radius 0.6 in a parallel plane at the height 0.5, centred on the axis (B-12)."""
    radius, square = 0.6, 0.5**2 + points[:, 0] ** 2 + points[:, 1] ** 2
    root = np.sqrt((square + radius**2) ** 2 - 4 * (square - 0.5**2) * radius**2)
    return 0.5 * (1 - (square - radius**2) / root)


def to_sphere(points):
    """Form factor to a sphere entirely above the plane: (r/d)² times the cosine."""
    towards = np.array([0.0, 0.0, 0.7]) - points
    distance = np.linalg.norm(towards, axis=1)
    return (0.3 / distance) ** 2 * towards[:, 2] / distance


DISK = pv.Disc(center=(0, 0, 0.5), inner=0, outer=0.6, normal=(0, 0, -1), r_res=1, c_res=400).triangulate()
DISK.point_data.active_normals = np.tile(np.array([0, 0, -1], np.float32), (DISK.n_points, 1))
SHAPES = {
    "parallel square": (wall((0, 0, 0.75), (0, 0, -1), cells=8), to_parallel_square),
    "square at right angles": (wall((0, -0.6, 0.5), (0, 1, 0), cells=8), to_square_at_right_angles),
    "coaxial disk": (DISK, to_disk),
    "sphere": (pv.Sphere(radius=0.3, center=(0, 0, 0.7), theta_resolution=80, phi_resolution=80), to_sphere),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_form_factors_are_those_of_the_catalog(shape):
    """Errors are within three standard errors of the same number of random rays, without bias."""
    target, exact = SHAPES[shape]
    floor = wall((0, 0, 0), (0, 0, 1), cells=8)
    found, expected = shares_of(floor, target), exact(floor.points.astype(np.float64))
    error = np.sqrt(expected * (1 - expected) / 1024)
    z = (found - expected) / error
    assert np.abs(z).max() < 3.0
    assert abs(z.mean()) < 3.0 / math.sqrt(len(z))
    assert np.sqrt((z * z).mean()) < 0.5  # Sobol points are better than random ones


def test_light_goes_both_ways_alike_and_none_is_made():
    """Two walls exchange equal amounts of light in both directions; rows of a closed room sum to 1."""
    mesh = room(6)
    walls = np.repeat(np.arange(6), mesh.n_points // 6)
    area = np.zeros(mesh.n_points)
    triangles = mesh.faces.reshape(-1, 4)[:, 1:]
    np.add.at(area, triangles, np.repeat(mesh.compute_cell_sizes()["Area"][:, None] / 3, 3, axis=1))
    matrix = mesh.phong.transport(samples=1024).matrix
    assert np.abs(np.asarray(matrix.sum(axis=1)) - 1.0).max() < 1e-6
    of_walls = np.eye(6)[walls]
    exchanged = of_walls.T @ (area[:, None] * (matrix @ of_walls))
    np.testing.assert_allclose(exchanged, exchanged.T, atol=0.005)
    np.testing.assert_allclose(exchanged[0, 1], 0.1998, atol=0.003)  # opposite squares of a cube (C-11)
    np.testing.assert_allclose(exchanged[0, 2], 0.2000, atol=0.003)  # perpendicular squares (C-14)
    assert (matrix.diagonal() == 0.0).mean() > 0.9


@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(8, 208))])
def test_no_row_adds_up_to_more_than_one_or_than_is_known_beforehand(seed):
    random = np.random.default_rng(seed)
    shapes = [pv.Cube(), pv.Sphere(theta_resolution=12, phi_resolution=12), pv.Cone(), pv.ParametricTorus()]
    blocks = pv.MultiBlock()
    for shape in random.choice(4, size=3):
        mesh = shapes[shape].triangulate().scale(random.uniform(0.3, 1.5), inplace=False)
        blocks.append(mesh.translate(random.uniform(-2, 2, 3), inplace=False))
    among = blocks.phong.transport(samples=64)
    beforehand = [part.most() for part in among.parts]
    reasons = [part.why_nothing() for part in among.parts]
    sums = np.asarray(among.matrix.sum(axis=1)).ravel()
    for rows, most, why, part in zip(among.slices, beforehand, reasons, among.parts, strict=True):
        assert sums[rows].max() <= most + 1e-6
        assert part.most() == pytest.approx(sums[rows].max())
        assert not why
    assert sums.max() <= 1.0 + 1e-6


def test_what_is_alone_and_convex_casts_no_ray():
    for mesh in (pv.Sphere(), pv.Icosahedron(), pv.PolyData(np.eye(3, dtype=np.float32))):
        mesh.point_data.active_normals = mesh.points - mesh.points.mean(axis=0)
        among = mesh.phong.transport()
        (part,) = among.parts
        assert part.why_nothing()
        assert part.most() == 0.0
        assert not among.gather(np.ones((mesh.n_points, 3))).any()
        assert among.rays == 0


def test_only_vertices_with_something_above_them_cast_rays():
    """A ball over a floor: only the floor's upper side and the lower half of the ball cast rays."""
    ball = pv.Sphere(radius=0.2, center=(0, 0, 0.5))
    floor = wall((0, 0, 0), (0, 0, 1), cells=8)
    among = pv.MultiBlock([ball, floor]).phong.transport(samples=16)
    among.gather(np.ones((len(among), 1)))
    looking = int((ball.point_normals[:, 2] < 0.7).sum()) + floor.n_points
    assert 0 < among.rays <= 16 * looking
    assert among.rays < 16 * (len(among) - 100)


@pytest.mark.parametrize("backend", BACKENDS, indirect=True)
@pytest.mark.usefixtures("backend")
def test_backs_and_occluders_block_light_and_are_black():
    """A wall between two floors that face each other, seen from behind or as an occluder, hides the other floor."""
    floor, ceiling = wall((0, 0, 0), (0, 0, 1), cells=3), wall((0, 0, 1), (0, 0, -1), 40.0, cells=3)
    between = wall((0, 0, 0.5), (0, 0, 1), 40.0, cells=3)
    open_share = shares_of(floor, ceiling, 64)
    assert (open_share > 0.95).all()
    seen_from_behind = pv.MultiBlock([floor, ceiling, between]).phong.transport(samples=64)
    ones = np.ones((len(seen_from_behind), 1))
    assert (seen_from_behind.gather(ones)[: floor.n_points] == 0.0).all()
    hidden = pv.MultiBlock([floor, ceiling]).phong.transport(samples=64, occluders=[between])
    assert (hidden.gather(np.ones((len(hidden), 1)))[: floor.n_points] == 0.0).all()


@pytest.mark.skipif(len(BACKENDS) < 2, reason="needs embreex")
def test_backends_meet_the_same_vertices(monkeypatch):
    mesh, matrices = room(4), []
    for backend in BACKENDS.values():
        monkeypatch.setattr(casting, "ray_backend", lambda backend=backend: (backend, ""))
        matrices.append(mesh.phong.transport(samples=32).matrix)
    for other in matrices[1:]:
        assert abs(other - matrices[0]).sum() < 0.02 * matrices[0].sum()


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("exponent", [-200, 0, 200])
def test_neither_units_nor_places_change_what_is_seen(offset, exponent):
    mesh = room(3)
    mesh.points = np.ldexp(mesh.points.astype(np.float64), exponent) + offset * 2.0**exponent
    sums = mesh.phong.transport(samples=64).gather(np.ones((mesh.n_points, 1)))
    np.testing.assert_allclose(sums, 1.0, atol=1e-6)


def test_broken_faces_corners_and_coincident_sheets_harm_nothing():
    mesh = room(4)
    points = np.concatenate([mesh.points, [[np.nan] * 3]]).astype(np.float32)
    triangles = mesh.faces.reshape(-1, 4)[:, 1:]
    broken = np.array([[0, 1, len(points) - 1], [5, 5, 9], [2, 2, 2]])
    twice = np.concatenate([triangles, triangles[:20], broken])
    spoiled = pv.PolyData.from_regular_faces(points, twice)
    spoiled.point_data.active_normals = np.concatenate([mesh.point_normals, [[0, 0, 0]]]).astype(np.float32)
    found = spoiled.phong.transport(samples=64).gather(np.ones((len(points), 1)))
    assert found[-1] == 0.0
    np.testing.assert_allclose(found[:-1], 1.0, atol=0.05)


def test_equal_calls_give_equal_bits_whatever_the_threads_and_memory(monkeypatch):
    mesh = room(5)
    colors = np.random.default_rng(0).random((mesh.n_points, 4))
    among = mesh.phong.transport(samples=64)
    expected = among.gather(colors)
    np.testing.assert_allclose(among.matrix @ colors, expected, rtol=3e-6)
    with threads.limited(1):
        np.testing.assert_array_equal(mesh.phong.transport(samples=64).gather(colors), expected)
    bare = mesh.phong.transport(samples=64, memory=1000)
    np.testing.assert_array_equal(bare.gather(colors), expected)
    assert not bare.is_kept
    assert bare.expected_cost().memory == 0
    monkeypatch.setattr(transports.kernel, "gatherer", lambda: None)
    np.testing.assert_allclose(mesh.phong.transport(samples=64).gather(colors), expected, rtol=3e-6)
    with pytest.raises(ValueError, match=r"^memory must be at least.*gather works"):
        bare.matrix  # noqa: B018


def test_it_says_what_it_costs_and_keeps_nothing_of_what_is_interrupted(monkeypatch):
    mesh = room(10)
    among = mesh.phong.transport(samples=64)
    cost = among.expected_cost()
    assert cost.rays == 64 * mesh.n_points
    assert cost.seconds > 0.0
    colors, real = np.ones((mesh.n_points, 1)), transports.HemisphereTracer.cast

    def interrupted(tracer, found):
        real(tracer, found)
        raise KeyboardInterrupt

    monkeypatch.setattr(transports.HemisphereTracer, "cast", interrupted)
    with pytest.raises(KeyboardInterrupt):
        among.gather(colors)
    monkeypatch.setattr(transports.HemisphereTracer, "cast", real)
    np.testing.assert_allclose(among.gather(colors), 1.0, atol=1e-6)
    assert among.rays == 64 * mesh.n_points
    assert cost.memory == among._kept.nbytes
    assert among.expected_cost() == (0, 0.0, 0)


def test_shadows_are_of_the_same_triangles_which_are_built_once(monkeypatch, tmp_path):
    built, backend = list[int](), casting.ray_backend()[0]

    def counted(points, corners):
        built.append(len(corners))
        return backend(points, corners)

    monkeypatch.setattr(casting, "ray_backend", lambda: (counted, ""))
    mesh, panel = room(3), wall((0.1, 0, 0), (0, 0, 1), size=0.3, cells=2)
    scene = ph.Scene([ph.PointLight((0.1, 0, 0.3))], light_model=ph.LightModel(bounces=1, shadows=True))
    lit = mesh.phong.shade(scene, occluders=[panel])["phong"]
    once = len(built)
    among = mesh.phong.transport(occluders=[panel])
    for _ in range(2):
        np.testing.assert_array_equal(mesh.phong.shade(scene, occluders=[panel], transport=among)["phong"], lit)
    assert len(built) == 2 * once
    among.save(tmp_path / "room.npz")
    read = ph.Transport.load(tmp_path / "room.npz")
    np.testing.assert_array_equal(mesh.phong.shade(scene, occluders=[panel], transport=read)["phong"], lit)
    built.clear()
    blocks = pv.MultiBlock([mesh, panel])
    blocks.phong.shade(scene)
    assert built == [mesh.n_cells + panel.n_cells]


# --- files


def test_what_is_saved_is_read_again_and_refused_for_another_mesh(tmp_path):
    mesh, path = room(3), tmp_path / "room.npz"
    among = mesh.phong.transport(samples=32)
    among.save(path)
    again = ph.Transport.load(path)
    colors = np.random.default_rng(1).random((mesh.n_points, 3))
    np.testing.assert_array_equal(again.gather(colors), among.gather(colors))
    assert (again.samples, len(again)) == (32, mesh.n_points)
    scene = ph.Scene([ph.PointLight((0, 0, 0))], light_model=ph.LightModel(bounces=2))
    lit = mesh.phong.shade(scene, transport=again)
    np.testing.assert_allclose(lit["phong"], mesh.phong.shade(scene, transport=among)["phong"], atol=1e-6)
    moved = mesh.translate((0, 0, 1e-3), inplace=False)
    for other, how in (
        (moved, {}),
        (room(4), {}),
        (mesh, {"matrix": np.diag([2, 1, 1, 1])}),
        (mesh, {"occluders": [moved]}),
    ):
        with pytest.raises(ValueError, match=r"^transport must be computed for the meshes that are lit"):
            other.phong.shade(scene, transport=again, **how)
    with pytest.raises(ValueError, match=r"^transport must be a Transport from mesh\.phong\.transport\(\)"):
        mesh.phong.shade(scene, transport=np.eye(3))


def test_what_is_no_such_file_is_refused(tmp_path):
    mesh, path = room(2), tmp_path / "room.npz"
    among = mesh.phong.transport(samples=16)
    among.save(path)
    whole = path.read_bytes()
    with np.load(path) as file:
        good = dict(file)
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"^path must be a file written by Transport\.save"):
        ph.Transport.load(path)
    for name, wrong in [
        ("format", np.array(["pvphong transport", "1", ""])),
        ("met", good["met"] + mesh.n_points),
        ("met", good["met"][:, :0]),
        ("counts", good["counts"] + 1),
    ]:
        np.savez(path, **{**good, name: wrong})
        with pytest.raises(ValueError, match="version 3" if name == "format" else "damaged"):
            ph.Transport.load(path)
    for missing in ("none.npz", "."):
        with pytest.raises(ValueError, match=re.escape(str(tmp_path))):
            ph.Transport.load(tmp_path / missing)
    with pytest.raises(ValueError, match=r"^path must be in a folder that exists"):
        among.save(tmp_path / "nowhere" / "room.npz")


def test_without_scipy_and_without_memory_it_says_so(monkeypatch):
    mesh = room(2)
    with pytest.raises(ValueError, match=r"^samples must be"):
        mesh.phong.transport(samples=0)
    with pytest.raises(ValueError, match=r"^colors must be an array of shape"):
        mesh.phong.transport().gather(np.ones((3, 3)))
    monkeypatch.setattr(transports, "available_memory", lambda: 1000)
    with pytest.raises(ValueError, match=r"^memory must be at most 1e\+03"):
        mesh.phong.transport()
    monkeypatch.undo()
    monkeypatch.setattr(transports.importlib.util, "find_spec", lambda _name: None)
    among = mesh.phong.transport(samples=16)
    among.gather(np.ones((mesh.n_points, 1)))
    with pytest.raises(ValueError, match=r"^matrix must be computed with SciPy; .*pip install scipy"):
        among.matrix  # noqa: B018


def test_the_rays_of_several_meshes_are_counted_as_one_work():
    blocks = pv.MultiBlock([wall((0, 0, 0), (0, 0, 1.0), cells=40), wall((0, 0, 1), (0, 0, -1.0), cells=40)])
    among, heard = blocks.phong.transport(), []
    with text.listening(lambda what, part: heard.append((what, part))):
        among.gather(np.ones((len(among), 1)))
    assert {what for what, _ in heard} == {"rays between vertices"}
    parts = [part for _, part in heard]
    assert parts == sorted(parts)
    assert len(parts) > 3
    assert parts[-1] == 1.0


def test_who_would_wait_is_told():
    few, many = (wall((0, 0, 0), (0, 0, 1.0), cells=cells).phong.transport() for cells in (5, 70))
    assert (few.takes_long, many.takes_long) == (False, True)
    many.gather(np.ones((len(many), 1)))
    assert not many.takes_long  # its hits are stored
