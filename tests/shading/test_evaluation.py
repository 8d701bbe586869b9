"""`evaluate` from the outside: its options, the form of its results, and changes that must not alter any bit.

`stability` tests the accuracy of the colours, and `stability/test_inputs` the arrays that it accepts.
"""

import dataclasses
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from pvphong import DirectionalLight, Material, PointLight, Scene, Shading, SpotLight, Viewer
from pvphong.shading import kernel
from pvphong.shading.evaluation import evaluate
from pvphong.shading.reference import BLOCK

RNG = np.random.default_rng(42)
COUNT = 60
POINTS = RNG.normal(size=(COUNT, 3))
NORMALS = RNG.normal(size=(COUNT, 3))
ALBEDO = RNG.uniform(size=(COUNT, 3))
BACKENDS = ["numpy", "numba"] if kernel.is_available() else ["numpy"]
SCENE = Scene(
    lights=[
        DirectionalLight(direction=(-1, 0.5, -1), diffuse=(0.9, 0.8, 0.7), ambient=0.05),
        PointLight(position=(2, 1, 3), attenuation=(0.5, 0.1, 0.02), specular="blue", on=False),
        PointLight(position=(2, -1, 3), attenuation=(0.5, 0.1, 0.02), specular="orange"),
        SpotLight(position=(0, 4, 1), direction=(0, -1, 0), cone_angle=40, exponent=3, diffuse=(0, 1, 1)),
    ],
    viewer=Viewer(position=(1, 2, 6)),
)
MATERIAL = Material(ambient=(0.1, 0.2, 0.3), diffuse=(0.7, 0.6, 0.5), specular=0.4, shininess=12, emission=(0, 0.02, 0))
MATRIX = np.array([[1, 0.5, 0, 3], [0, -2, 0.1, 1], [0.2, 0, 1, -1], [0, 0, 0, 1]], float)


def rgb(points=POINTS, normals=NORMALS, scene=SCENE, material=MATERIAL, **options):
    return evaluate(points, normals, scene, material, **options).rgb


def bits(array):
    return np.ascontiguousarray(array).tobytes()


# --- arguments ---


def test_scene_and_material_are_checked():
    with pytest.raises(ValueError, match=r"^scene must be a Scene, a light, or a sequence of lights; got sun"):
        rgb(scene="sun")
    with pytest.raises(ValueError, match=r"^material must be a Material or .*Material\.from_property"):
        rgb(material=None)
    assert bits(rgb(material="gold")) == bits(rgb(material=Material.named("gold")))


@pytest.mark.parametrize(
    ("option", "bad", "message"),
    [
        ("precision", "float16", "^precision must be one of 'float32', 'float64'; got float16"),
        ("precision", np.float32, "^precision must be one of"),
        ("backend", "numpi", "^backend must be one of 'auto', 'numpy'.*; got numpi. Did you mean 'numpy'"),
        ("tolerance", -1e-9, "^tolerance must be a finite number >= 0"),
        ("components", 1, "^components must be True or False; got 1"),
        ("matrix", np.eye(3), "^matrix must be a 4x4 matrix of real numbers"),
        ("matrix", np.zeros((4, 4)), "^matrix must be an affine 4x4 matrix"),
        ("matrix", np.diag([1.0, 0, 0, 1]), "^matrix must be a 4x4 matrix that keeps at least two dimensions"),
    ],
)
@pytest.mark.parametrize("scene", [SCENE, Scene(), Scene([DirectionalLight()])], ids=["lit", "unlit", "sun"])
def test_options_are_refused_by_name_whatever_the_scene_needs(scene, option, bad, message):
    with pytest.raises(ValueError, match=message):
        rgb(scene=scene, **{option: bad})


# --- the form of the result ---


@pytest.mark.parametrize("count", [0, COUNT])
@pytest.mark.parametrize("asked", [{}, {"precision": "float32"}, {"precision": "float64"}])
@pytest.mark.parametrize("stored", [np.float32, np.float64])
def test_results_are_new_arrays_of_the_precision_asked_for_whatever_came(asked, stored, count):
    vertices = POINTS[:count].astype(stored), NORMALS[:count].astype(stored)
    shading, again = (evaluate(*vertices, SCENE, MATERIAL, components=True, matrix=MATRIX, **asked) for _ in range(2))
    for field in dataclasses.fields(Shading):
        array = getattr(shading, field.name)
        if field.name == "bounced":  # no light bounces in this scene
            assert array is None
            continue
        assert array.dtype == asked.get("precision", "float32")
        assert array.shape == ((4, count, 3) if field.name == "per_light" else (count, 3))
        assert array.flags.c_contiguous
        assert array.flags.writeable
        assert not np.shares_memory(array, getattr(again, field.name))
    with pytest.raises(dataclasses.FrozenInstanceError):
        shading.rgb = None


# --- no bit may change ---


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_an_identity_matrix_and_a_white_albedo_change_nothing(precision):
    plain, turned = rgb(precision=precision), rgb(precision=precision, matrix=MATRIX)
    assert bits(rgb(precision=precision, matrix=np.eye(4))) == bits(plain)
    for albedo in (np.ones((COUNT, 3)), np.full((COUNT, 3), 255, "u1")):
        white = replace(MATERIAL, albedo=albedo)
        assert bits(rgb(material=white, precision=precision)) == bits(plain)
        assert bits(rgb(material=white, precision=precision, matrix=MATRIX)) == bits(turned)


@pytest.mark.parametrize("backend", BACKENDS)
def test_where_all_vertices_are_alike_but_for_a_map_they_are_so_in_every_block(backend):
    points, dark = np.zeros((2 * BLOCK + 1, 3)), Scene([replace(SCENE.lights[0], diffuse="black")])
    lit = rgb(points, points, dark, backend=backend)
    assert bits(lit) == bits(np.broadcast_to(lit[0], lit.shape))
    assert lit.min() > 0.0
    albedo = RNG.uniform(size=points.shape)
    every, others = (
        rgb(points[some], points[some], dark, replace(MATERIAL, albedo=albedo[some]), backend=backend)
        for some in (slice(None), slice(1, None))
    )
    assert bits(every[1:]) == bits(others)


@pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_auto_takes_the_kernel_where_the_work_is_worth_its_start(precision, monkeypatch):
    work = len(POINTS) * sum(light.on for light in SCENE.lights)
    own = {backend: bits(rgb(backend=backend, precision=precision)) for backend in ("numpy", "numba")}
    assert own["numpy"] != own["numba"]
    for least, backend in ((work, "numba"), (work + 1, "numpy")):
        monkeypatch.setattr("pvphong.shading.plan.plan._WORTH_LOADING", least)
        assert bits(rgb(backend="auto", precision=precision)) == own[backend]


@pytest.mark.parametrize("stored", [np.uint8, np.float32, np.float64])
def test_albedo_needs_no_memory_of_its_size(stored):
    count = 1_000_000
    points, albedo = np.zeros((count, 3), np.float32), np.ones((count, 3), stored)
    tracemalloc.start()
    lit = evaluate(points, points + 1, SCENE, Material(albedo=albedo), backend="numpy").rgb
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2 * lit.nbytes + 20e6  # the result, the normals made here, and scratch for a block
