"""Selection of the ray backend: Embree's C interface if it can be called, else the reason why not."""

import ctypes
import gc
import os
import sys
import threading
import tracemalloc
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from apart import run_apart
from ray_backends import BACKENDS

import pvphong as ph
from pvphong.base import sobol
from pvphong.base.vectors import towards
from pvphong.optics.light import Arrival, Light
from pvphong.optics.lights import DirectionalLight
from pvphong.rays import casting, embree
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.rays.rays import part_by_arrays
from pvphong.shading import kernel

pytestmark = pytest.mark.skipif("compiled" not in BACKENDS, reason="needs embreex and Numba")
BALL = pv.Sphere(theta_resolution=30, phi_resolution=30)
FLOOR = pv.Plane(center=(0, 0, -1), i_size=4, j_size=4, i_resolution=40, j_resolution=40)
LIGHTS = [
    ph.SphereLight((0, 0, 4), radius=0.5),
    ph.RectangleLight((0, 1, 3)),
    ph.DiskLight((0, 1, 3), radius=0.6),
    ph.PolygonLight([(0, 0, 3), (0, 1, 3), (1, 0, 3)]),
    ph.EnvironmentLight(),
    ph.EnvironmentLight(np.random.default_rng(1).random((8, 16, 3))),
]


@pytest.fixture
def anew():
    """Clear the caches about the library before and after a test."""
    for each in (embree.library, embree._device):
        each.cache_clear()
    yield
    for each in (embree.library, embree._device):
        each.cache_clear()


@pytest.mark.usefixtures("anew")
def test_another_library_another_version_and_another_processor_say_so(monkeypatch):
    assert casting.ray_backend() == (casting.Embree, "")
    monkeypatch.setattr(embree, "_NATIVE_RAYS_OF_8", 32 + 4)  # a property that is 0 or unknown
    embree._device.cache_clear()
    assert "AVX" in embree.obstacle()
    monkeypatch.setattr(embree, "_MAJOR", 3)
    assert casting.ray_backend()[0] is casting.Embreex
    assert "version 3" in casting.ray_backend()[1]
    embree.library.cache_clear()
    monkeypatch.setitem(embree._FUNCTIONS, "rtcNoSuchFunction", (None,))
    assert "no Embree 4 library" in casting.ray_backend()[1]
    embree.library.cache_clear()
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)  # makes its import fail
    assert "cannot be imported" in embree.obstacle()


@pytest.mark.usefixtures("anew")
def test_the_library_is_found_in_the_wheel_where_a_module_does_not_lead_to_it(monkeypatch):
    given, real = [], ctypes.CDLL

    def loaded(path, *options):
        given.append(path)
        if len(given) == 1:
            raise OSError
        return real(path, *options)

    monkeypatch.setattr(embree.ctypes, "CDLL", loaded)
    assert embree.library()
    assert "embree4" in given[1]


@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)
def test_compiled_rays_are_those_of_arrays(light):
    """Points are equal, and visibility is equal except for rays within rounding of an edge."""
    points = np.array(FLOOR.points[::4][:400], np.float64)
    normals = np.tile([0.0, 0.0, 1.0], (400, 1))
    faces = BlockingFaces(BALL.points.astype(np.float64), BALL.faces.reshape(-1, 4)[:, 1:].astype(np.int64))
    occluders, seeds = Occluders([faces]), sobol.seeds(np.arange(400))
    given = np.asarray(light.sampling.numbers, np.float64), points, normals, seeds, 0, 64, 1e-5
    stages = kernel.stages_of(light.sampling)
    sent, seen, scale, rays = kernel.part_seen(stages, *given, occluders.compiled)
    expected = part_by_arrays(light.sampling, *given, occluders)
    np.testing.assert_allclose(sent, expected[0], rtol=2e-5, atol=2e-5 * sent.max())
    np.testing.assert_allclose(scale, expected[2], rtol=1e-12)
    assert rays == expected[3]
    assert ((seen > 0.0) != (expected[1] > 0.0)).mean() < 1e-3
    assert 0.0 < (seen[sent > 0.0] == 0.0).mean() < 1.0


@pytest.mark.parametrize("radius", [0.02, 0.2, 1.0])
def test_no_narrow_rays_pass_between_the_triangles_of_a_closed_body(radius):
    """Embree traverses the narrow cones as coherent rays, and its robust mode holds for them too."""
    body = pv.Icosphere(nsub=5)
    faces = BlockingFaces(body.points.astype(np.float64), body.regular_faces.astype(np.int64))
    random, light = np.random.default_rng(3), ph.SphereLight((0.3, 0.2, 4), radius=radius)
    points = random.uniform(-0.5, 0.5, (4000, 3))
    stages, numbers = kernel.stages_of(light.sampling), np.asarray(light.sampling.numbers, np.float64)
    given = points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), sobol.seeds(np.arange(len(points))), 0, 256, 1e-5
    sent, seen, _, rays = kernel.part_seen(stages, numbers, *given, Occluders([faces]).compiled)
    assert rays == sent.size
    assert sent.all()
    assert not seen.any()


def test_arrays_of_any_layout_and_type_are_read_alike():
    """Compiled code reads memory by address, so arrays of another layout are copied."""
    light, random = LIGHTS[0], np.random.default_rng(2)
    points, normals = random.normal(size=(40, 3)), random.normal(size=(40, 3))
    casters = Occluders([BlockingFaces(np.eye(3), np.array([[0, 1, 2]]))]).compiled
    stages, numbers = kernel.stages_of(light.sampling), np.asarray(light.sampling.numbers, np.float64)
    lamp = np.array([0.2, 0.3, 0.9, 1.0, 1.0, 1e-6, 1e-6])

    def results(change):
        point, behind = np.zeros(20), np.zeros(20)
        p, n = change(points), change(normals)
        part = kernel.part_seen(
            stages, np.repeat(numbers, 2)[::2], p, n, sobol.seeds(np.arange(40))[:, ::2], 0, 16, 0.0, casters
        )
        kernel.point_seen(p, p, p, n, np.repeat(lamp, 2)[::2], casters, point, behind)
        directions = n / np.linalg.norm(n, axis=1)[:, None]
        return (
            *part[:3],
            np.maximum(point, behind),
            kernel.rays_blocked(p, directions, np.repeat(np.full(20, 3.0), 2)[::2], casters),
        )

    expected = results(lambda a: np.ascontiguousarray(a[::2]))
    for change in (lambda a: a[::2], lambda a: np.asfortranarray(a[::2])):
        for got, right in zip(results(change), expected, strict=True):
            np.testing.assert_array_equal(got, right)
    assert 0 < expected[3].sum() < 20
    assert 0 < expected[4].sum() < 20


def seen():
    return FLOOR.phong.visibility(ph.Scene(LIGHTS[:2]), occluders=[BALL]).per_light.copy()


def test_threads_get_the_same_bits():
    expected, same = seen(), []
    threads = [threading.Thread(target=lambda: same.append((seen() == expected).all())) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(same) == 8
    assert all(same)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_gets_the_same_bits():
    """A new process forks, because a fork of this one would copy locks of other tests' threads."""
    tests = str(Path(__file__).parents[1])
    code = f"import sys; sys.path.insert(0, {tests!r}); from rays import test_embree; test_embree.fork_and_compare()"
    assert run_apart(code) == "True\n"


def fork_and_compare():
    """Compare the results of a process that has cast rays and of its child."""
    expected = seen()
    if child := os.fork():
        print(os.waitpid(child, 0)[1] == 0)
    else:
        os._exit(0 if (seen() == expected).all() else 1)


def test_scenes_go_with_what_they_share_and_not_before():
    triangle = BlockingFaces(np.eye(3), np.array([[0, 1, 2]]))
    released = []
    for number in range(50):
        occluders = Occluders([triangle])
        if number % 10 == 0:
            gc.collect()
        towards = np.full((1, 3), 3**-0.5)
        assert occluders.blocked(np.zeros((1, 3)), towards, np.array([2.0])).all()
        scene = occluders.casters[0].backend
        embree.weakref.finalize(scene, released.append, scene.handle)
        del scene, occluders
    gc.collect()
    assert len(released) == 50


@dataclass(frozen=True)
class Lantern(Light):
    """Custom light that defines only `arrival`."""

    def arrival(self, points: Any, real: Any = np.float64) -> Arrival:
        return Arrival(towards((0.0, 0.3, 2.0), points, real)[0], 1.0)


@dataclass(frozen=True)
class Tube(Light):
    """Custom light of several nodes, without `sampling`."""

    def nodes(self, count):  # noqa: ARG002 always two
        return DirectionalLight(), DirectionalLight(direction=(0, 1, -1))


@pytest.mark.parametrize("two_sided", [False, True])
def test_all_backends_see_the_same(monkeypatch, two_sided):
    """Lights of every kind and a custom one, in the scene and far away."""
    far = (
        ph.SphereLight((3e4, 1e4, 9e4), radius=2e4),
        ph.PointLight((-2e4, 1e4, 9e4)),
        ph.DiskLight((1e4, 0, 9e4), radius=3e4),
    )
    near = ph.PointLight((0.4, 0, -0.9)), ph.DiskLight((0, 0, -0.95), radius=3.0), ph.SpotLight((0, 1, 2)), Lantern()
    lights = [*LIGHTS, *far, *near, ph.DirectionalLight(direction=(1, 0, -1))]
    scene = ph.Scene(lights, light_model=ph.LightModel(two_sided=two_sided))
    found = {}
    for name, backend in BACKENDS.items():
        monkeypatch.setattr(casting, "ray_backend", lambda backend=backend: (backend, ""))
        visibility = FLOOR.phong.visibility(scene, occluders=[BALL], samples=16)
        found[name] = np.concatenate([visibility.per_light, visibility.sky[None]])
    for name in ("vtk", "embreex"):
        off = np.abs(found[name] - found["compiled"])
        assert (off > 1e-4).mean() < 2e-3, name
    lit = found["compiled"].mean(axis=1)
    assert ((lit > 0.0) & (lit < 1.0)).sum() >= len(lit) - 3


def test_a_size_without_sampling_is_refused():
    with pytest.raises(ValueError, match=r"^light must be a light with `sampling`"):
        FLOOR.phong.visibility(ph.Scene([Tube()])).per_light  # noqa: B018  casts the rays


@pytest.fixture(scope="module")
def patch():
    """Return vertices in the penumbra of a ball below a disk light, and the exact visible parts."""
    plane = pv.Plane(center=(0.7, 0, -1), i_size=0.3, j_size=0.3, i_resolution=24, j_resolution=24)
    scene = ph.Scene([ph.SphereLight((0, 0, 4), radius=1.2, intensity=30)])

    def part(**options):
        return plane.phong.visibility(scene, occluders=[BALL], **options)

    truth = part(samples=4096).per_light[0]
    assert ((truth > 0.02) & (truth < 0.98)).mean() > 0.9
    return part, truth


def test_the_error_in_a_penumbra_falls_faster_than_that_of_random_rays(patch):
    """The exponent is nearly ¾; for random rays, it is ½ by the binomial distribution."""
    part, truth = patch
    counts = np.array([16, 64, 256])
    errors = [np.sqrt(np.mean((part(samples=count).per_light[0] - truth) ** 2)) for count in counts.tolist()]
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert 0.65 < rate < 0.85
    random = np.sqrt(np.mean(truth * (1.0 - truth)) / counts)
    assert (errors < random / [1.7, 2.5, 3.5]).all()


def test_rays_are_as_many_as_the_error_of_the_colour_asks_for(patch):
    part, truth = patch
    rough, fine = part(tolerance=0.03), part(tolerance=0.003)
    off = [np.sqrt(np.mean((seen.per_light[0] - truth) ** 2)) for seen in (rough, fine)]
    assert rough.rays < fine.rays / 4
    assert off[1] < off[0] / 3
    assert fine.standard_error.per_light.max() * 1.0 < 0.02
    open_floor = FLOOR.phong.visibility(
        ph.Scene([ph.SphereLight((0, 0, 4), radius=0.5)]), occluders=[pv.Sphere(radius=0.1, center=(0, 0, 9))]
    )
    assert (open_floor.per_light == 1.0).all()
    assert open_floor.rays == 16 * FLOOR.n_points


def test_little_memory_is_held_beside_the_result():
    plane = pv.Plane(center=(0.7, 0, -1), i_size=1, j_size=1, i_resolution=300, j_resolution=300)
    seen = plane.phong.visibility(ph.Scene([ph.SphereLight((0, 0, 4), radius=1.2)]), occluders=[BALL], tolerance=1e-5)
    seen.expected_cost()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    seen.per_light  # noqa: B018  casts the rays
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most - before < 64e6


def test_what_rays_will_take_is_known_before():
    lamps = ph.Scene([LIGHTS[0]], light_model=ph.LightModel(ambient=1.0))
    visibility = FLOOR.phong.visibility(lamps, occluders=[BALL], tolerance=1e-3)
    expected = visibility.expected_cost()
    assert visibility.rays == 0
    visibility.standard_error  # noqa: B018  casts them
    assert 0.5 < expected.rays / visibility.rays < 2.0
    assert expected.seconds > 0.0
