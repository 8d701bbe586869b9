"""What casts rays: Embree by its C interface where it is there and can be called, and else why not."""

import ctypes
import gc
import multiprocessing
import sys
import threading

import numpy as np
import pytest
import pyvista as pv
from ray_backends import BACKENDS

import pvphong as ph
from pvphong.base import sobol
from pvphong.rays import casting, embree
from pvphong.rays.casting import BlockingFaces, Caster, Occluders
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
    """What is known of the library is found out again, before and after."""
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
    assert "no library" in casting.ray_backend()[1]
    embree.library.cache_clear()
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)  # importing it fails then
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
    """The same points, and what is seen of them but for rays within rounding of an edge."""
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


def seen():
    return FLOOR.phong.visibility(ph.Scene(LIGHTS[:2]), occluders=[BALL]).per_light.copy()


def _in_child(queue, expected):
    queue.put(bool((seen() == expected).all()))


def test_threads_and_forked_processes_get_the_same_bits():
    expected, same = seen(), []
    threads = [threading.Thread(target=lambda: same.append((seen() == expected).all())) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(same) == 8
    assert all(same)
    if "fork" not in multiprocessing.get_all_start_methods():
        return
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_in_child, args=(queue, expected))
    child.start()
    assert queue.get(timeout=60)
    child.join()


def test_scenes_go_with_what_they_share_and_not_before():
    triangle = BlockingFaces(np.eye(3), np.array([[0, 1, 2]]))
    released = []
    for _ in range(50):
        caster = Caster(triangle)
        gc.collect()
        towards = np.full((1, 3), 3**-0.5)
        assert caster.blocked(np.zeros((1, 3)), towards, np.array([2.0])).all()
        scene = caster.backend.scene
        embree.weakref.finalize(scene, released.append, scene.handle)
        del scene, caster
    gc.collect()
    assert len(released) == 50


def test_what_rays_will_take_is_known_before():
    lamps = ph.Scene([LIGHTS[0]], light_model=ph.LightModel(ambient=1.0))
    visibility = FLOOR.phong.visibility(lamps, occluders=[BALL], tolerance=1e-3)
    expected = visibility.expected_cost()
    assert visibility.rays == 0
    visibility.standard_error  # noqa: B018  casts them
    assert 0.5 < expected.rays / visibility.rays < 2.0
    assert expected.seconds > 0.0
