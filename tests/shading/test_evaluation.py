"""`evaluate` from the outside: its arguments, its results' form, and what must not change a bit.

How accurate the colours are is the reference evaluator's own test.
"""

import dataclasses
import math
import tracemalloc

import numpy as np
import pytest
import pyvista as pv
import vtk

from pvphong.geometry.transform import SingularMatrixWarning
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading import kernel
from pvphong.shading.evaluation import evaluate
from pvphong.shading.reference import BLOCK
from pvphong.shading.result import Shading

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
PARTS = ["ambient", "diffuse", "specular", "emission"]


def rgb(points=POINTS, normals=NORMALS, scene=SCENE, material=MATERIAL, **options):
    return evaluate(points, normals, scene, material, **options).rgb


def bits(array):
    return np.ascontiguousarray(array).tobytes()


# --- arguments ---


@pytest.mark.parametrize(
    "bad", [None, "points", np.zeros((COUNT, 2)), np.zeros(3), POINTS + 1j, POINTS.astype(str), [[1, 2, 3], [4]]]
)
def test_points_and_normals_are_refused_by_name(bad):
    with pytest.raises(ValueError, match=r"^points must be an \(n, 3\) array of real numbers; got "):
        rgb(points=bad)
    with pytest.raises(ValueError, match=r"^normals must be an \(n, 3\) array of real numbers; got "):
        rgb(normals=bad)


def test_as_many_normals_as_points():
    with pytest.raises(ValueError, match=r"^normals must be .*60 rows; got 59 rows"):
        rgb(normals=NORMALS[1:])


def test_scene_and_material_are_checked():
    with pytest.raises(ValueError, match=r"^scene must be a Scene; .*Scene\(lights=\[\.\.\.\]\)"):
        rgb(scene=SCENE.lights)
    with pytest.raises(ValueError, match=r"^material must be a Material; .*Material\.from_property"):
        rgb(material="gold")


@pytest.mark.parametrize(
    ("option", "bad", "message"),
    [
        ("precision", "float16", "^precision must be one of 'float32', 'float64'; got float16"),
        ("precision", np.float32, "^precision must be one of"),
        ("precision", None, "^precision must be one of"),
        ("backend", "numpi", "^backend must be one of 'auto', 'numpy'.*; got numpi. Did you mean 'numpy'"),
        ("backend", None, "^backend must be one of"),
        ("tolerance", -1e-9, "^tolerance must be a finite number >= 0"),
        ("tolerance", math.nan, "^tolerance must be a finite number >= 0"),
        ("tolerance", "0", "^tolerance must be a finite number >= 0"),
        ("components", 1, "^components must be True or False; got 1"),
        ("matrix", np.eye(3), "^matrix must be a 4x4 matrix of real numbers"),
        ("matrix", "rotate", "^matrix must be a 4x4 matrix"),
        ("matrix", np.full((4, 4), np.nan), "^matrix must be a 4x4 matrix of finite numbers"),
        ("matrix", np.zeros((4, 4)), "^matrix must be an affine 4x4 matrix"),
        ("matrix", np.diag([1.0, 0, 0, 1]), "^matrix must be a 4x4 matrix that keeps at least two dimensions"),
        ("matrix", np.diag([1.0, 1, 1, 1]) + np.eye(4)[[2, 0, 1, 0]], "^matrix must be an affine 4x4 matrix"),
    ],
)
@pytest.mark.parametrize("scene", [SCENE, Scene(), Scene([DirectionalLight()])], ids=["lit", "unlit", "sun"])
def test_options_are_refused_by_name_whatever_the_scene_needs(scene, option, bad, message):
    with pytest.raises(ValueError, match=message):
        rgb(scene=scene, **{option: bad})


def test_options_are_keywords_only():
    with pytest.raises(TypeError, match="positional"):
        evaluate(POINTS, NORMALS, SCENE, MATERIAL, MATRIX)


def test_matrix_of_every_kind():
    matrix = vtk.vtkMatrix4x4()
    matrix.DeepCopy(MATRIX.ravel())
    expected = rgb(matrix=MATRIX)
    assert bits(rgb(matrix=matrix)) == bits(rgb(matrix=MATRIX.tolist())) == bits(expected)
    assert np.abs(expected - rgb()).max() > 0.1


def test_a_flattening_matrix_warns():
    with pytest.warns(SingularMatrixWarning, match="flattens space onto a plane"):
        rgb(matrix=np.diag([1.0, 1, 0, 1]))


@pytest.mark.parametrize("kind", [np.float16, np.longdouble, np.int64, np.uint8, ">f8"])
def test_other_real_types_are_widened(kind):
    points, normals = (np.abs(a * 9).astype(kind) for a in (POINTS, NORMALS))
    expected = rgb(points.astype(np.float64), normals.astype(np.float64))
    assert bits(rgb(points, normals)) == bits(expected)


def test_no_vertices():
    shading = evaluate(np.zeros((0, 3)), np.zeros((0, 3)), SCENE, MATERIAL, components=True, matrix=MATRIX)
    assert shading.rgb.shape == (0, 3)
    assert shading.per_light.shape == (4, 0, 3)


# --- the form of the result ---


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("stored", [np.float32, np.float64])
def test_precision_is_the_results_type_whatever_came(precision, stored):
    shading = evaluate(
        POINTS.astype(stored), NORMALS.astype(stored), SCENE, MATERIAL, precision=precision, components=True
    )
    for field in dataclasses.fields(Shading):
        assert getattr(shading, field.name).dtype == precision
    assert shading.rgb.shape == (COUNT, 3)
    assert shading.rgb.flags.c_contiguous
    assert shading.per_light.shape == (4, COUNT, 3)


def test_float32_is_the_default_and_close_to_float64():
    assert rgb().dtype == np.float32
    bound = (4 * math.sqrt(MATERIAL.shininess) + 16) * 2.0**-24 * (1 + len(SCENE.lights))  # as documented
    worst = np.abs(rgb() - rgb(precision="float64")).max()
    assert 0 < worst <= bound


def test_components_are_there_when_asked_for():
    shading = evaluate(POINTS, NORMALS, SCENE, MATERIAL)
    assert [getattr(shading, name) for name in (*PARTS, "base", "per_light")] == [None] * 6


@pytest.mark.parametrize("albedo", [None, ALBEDO])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_components_add_up_to_the_unclamped_colour(precision, albedo):
    bright = dataclasses.replace(SCENE, light_model=LightModel(ambient=4, clamp=False))
    options = {"precision": precision, "components": True, "albedo": albedo}
    shading = evaluate(POINTS, NORMALS, bright, MATERIAL, **options)
    assert shading.rgb.max() > 1
    atol = 16 * np.finfo(precision).eps
    np.testing.assert_allclose(sum(getattr(shading, part) for part in PARTS), shading.rgb, rtol=0, atol=atol)
    np.testing.assert_allclose(shading.base + shading.per_light.sum(axis=0), shading.rgb, rtol=0, atol=atol)
    clamped = evaluate(POINTS, NORMALS, dataclasses.replace(bright, light_model=LightModel(4)), MATERIAL, **options)
    assert bits(clamped.rgb) == bits(np.clip(shading.rgb, 0, 1))
    assert bits(clamped.diffuse) == bits(shading.diffuse)


def test_components_do_not_change_the_colour():
    assert bits(evaluate(POINTS, NORMALS, SCENE, MATERIAL, components=True).rgb) == bits(rgb())


def test_each_share_is_the_light_alone():
    shading = evaluate(POINTS, NORMALS, SCENE, MATERIAL, components=True, precision="float64")
    assert not shading.per_light[1].any()  # switched off
    dark = LightModel(ambient=0, clamp=False)
    plain = dataclasses.replace(MATERIAL, emission=0)
    for index, light in enumerate(SCENE.lights):
        alone = dataclasses.replace(SCENE, lights=[light], light_model=dark)
        np.testing.assert_allclose(
            shading.per_light[index], rgb(scene=alone, material=plain, precision="float64"), rtol=0, atol=1e-15
        )
        assert light.on == shading.per_light[index].any()


def test_base_and_emission_are_what_is_there_without_light():
    shading = evaluate(POINTS, NORMALS, SCENE, MATERIAL, components=True, precision="float64", albedo=ALBEDO)
    emission = np.tile(MATERIAL.emission, (COUNT, 1))
    np.testing.assert_array_equal(shading.emission, emission)
    np.testing.assert_allclose(shading.base, emission + 0.2 * np.array(MATERIAL.ambient) * ALBEDO, rtol=1e-15)


def test_results_are_new_arrays():
    first, second = (evaluate(POINTS, NORMALS, SCENE, MATERIAL, components=True) for _ in range(2))
    for field in dataclasses.fields(Shading):
        array = getattr(first, field.name)
        assert array.flags.writeable
        assert not np.shares_memory(array, getattr(second, field.name))


def test_shading_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        evaluate(POINTS, NORMALS, SCENE, MATERIAL).rgb = None


# --- the albedo ---


def test_albedo_multiplies_ambient_and_diffuse_alone():
    with_it, without = (
        evaluate(POINTS, NORMALS, SCENE, MATERIAL, components=True, precision="float64", albedo=albedo)
        for albedo in (ALBEDO, None)
    )
    np.testing.assert_allclose(with_it.ambient, without.ambient * ALBEDO, rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(with_it.diffuse, without.diffuse * ALBEDO, rtol=1e-14, atol=1e-16)
    assert bits(with_it.specular) == bits(without.specular)
    assert bits(with_it.emission) == bits(without.emission)


def test_albedo_of_uint8_counts_from_0_to_255():
    steps = RNG.integers(0, 256, (COUNT, 3)).astype(np.uint8)
    for precision in ("float32", "float64"):
        assert bits(rgb(albedo=steps, precision=precision)) == bits(rgb(albedo=steps / 255.0, precision=precision))


@pytest.mark.parametrize(
    ("odd", "counts_as"),
    [(math.nan, 0.0), (-1.0, 0.0), (-0.0, 0.0), (300.0, 1.0), (math.inf, 1.0), (-math.inf, 0.0), (1.0, 1.0)],
)
@pytest.mark.parametrize("stored", [np.float32, np.float64])
def test_albedo_floats_are_clipped_and_nan_is_0(odd, counts_as, stored):
    given, clean = ALBEDO.astype(stored), ALBEDO.astype(stored)
    given[7, 1], clean[7, 1] = odd, counts_as
    assert bits(rgb(albedo=given)) == bits(rgb(albedo=clean))


def test_albedo_of_ones_changes_nothing():
    assert bits(rgb(albedo=np.ones((COUNT, 3)))) == bits(rgb())
    assert bits(rgb(albedo=np.full((COUNT, 3), 255, np.uint8))) == bits(rgb())


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (ALBEDO[1:], r"^albedo must be .*one row per point, 60 rows; got 59 rows"),
        (np.ones((COUNT, 4)), r"^albedo must be .*Leave out the opacity"),
        (np.ones((COUNT, 4), np.uint8), r"^albedo must be .*Leave out the opacity"),
        (np.ones(COUNT), r"^albedo must be an \(n, 3\) array of real numbers"),
        ((1.0, 0.5, 0.5), r"^albedo must be an \(n, 3\) array of real numbers"),
        (0.5, r"^albedo must be an \(n, 3\) array of real numbers"),
        ("colors", r"^albedo must be an \(n, 3\) array of real numbers"),
        (ALBEDO.astype(complex), r"^albedo must be an \(n, 3\) array of real numbers"),
        (ALBEDO.astype(str), r"^albedo must be an \(n, 3\) array of real numbers"),
        ([[1, 2, 3], [4]], r"^albedo must be an \(n, 3\) array of real numbers"),
    ],
)
def test_albedo_is_refused_by_name(bad, message):
    with pytest.raises(ValueError, match=message):
        rgb(albedo=bad)


@pytest.mark.parametrize("kind", [np.int8, np.int32, np.int64, np.uint16])
def test_albedo_of_other_integers_is_not_taken_for_floats(kind):
    """0-255 in an int64 array would all be clipped to white."""
    with pytest.raises(ValueError, match=r"^albedo must be .*(uint8|255)"):
        rgb(albedo=np.full((COUNT, 3), 120, kind))


# --- what must not change a bit ---


def strided(a):
    wide = np.zeros((2 * len(a), 7), a.dtype)
    wide[::2, 1:7:2] = a
    return wide[::2, 1:7:2]


def read_only(a):
    a = a.copy()
    a.flags.writeable = False
    return a


LAYOUTS = {
    "fortran": np.asfortranarray,
    "strided": strided,
    "reversed": lambda a: np.ascontiguousarray(a[::-1, ::-1])[::-1, ::-1],
    "read-only": read_only,
    "pyvista": pv.pyvista_ndarray,
    "list": lambda a: a.tolist(),
    "byteswapped": lambda a: a.astype(a.dtype.newbyteorder()),
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("matrix", [None, MATRIX], ids=["plain", "matrix"])
@pytest.mark.parametrize("stored", [np.float32, np.float64])
def test_memory_layout_changes_no_bit(layout, matrix, stored):
    plain = [a.astype(stored) for a in (POINTS, NORMALS, ALBEDO)]
    points, normals, albedo = (LAYOUTS[layout](a) for a in plain)
    expected = rgb(plain[0], plain[1], albedo=plain[2], matrix=matrix)
    assert bits(rgb(points, normals, albedo=albedo, matrix=matrix)) == bits(expected)


def test_storing_in_float32_is_all_that_float32_points_lose():
    points, normals = (a.astype(np.float32).astype(np.float64) for a in (POINTS, NORMALS))
    assert bits(rgb(points.astype(np.float32), normals.astype(np.float32))) == bits(rgb(points, normals))


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("matrix", [None, MATRIX], ids=["plain", "matrix"])
def test_a_vertex_does_not_depend_on_its_neighbours(precision, matrix):
    count = 2 * BLOCK + 17
    rng = np.random.default_rng(5)
    points, normals = rng.normal(size=(count, 3)), rng.normal(size=(count, 3))
    points[::1001] *= 1e200
    normals[::997] = 0.0
    normals[5::1003] *= 1e-250
    points[9::1009, 1] = np.nan
    options = {"precision": precision, "matrix": matrix}
    whole = rgb(points, normals, **options)
    assert np.isfinite(whole).all()
    order = rng.permutation(count)
    assert bits(rgb(points[order], normals[order], **options)) == bits(whole[order])
    for part in (slice(0, 1), slice(5, 6), slice(9, 10), slice(BLOCK - 3, BLOCK + 3), slice(1001, 1002)):
        assert bits(rgb(points[part], normals[part], **options)) == bits(whole[part])


@pytest.mark.skipif(not kernel.keeps_code(), reason="Numba cannot run here, or would compile every time")
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_auto_takes_the_kernel_where_the_work_is_worth_its_start(precision, monkeypatch):
    work = len(POINTS) * sum(light.on for light in SCENE.lights)
    own = {backend: bits(rgb(backend=backend, precision=precision)) for backend in ("numpy", "numba")}
    assert own["numpy"] != own["numba"]
    for least, backend in ((work, "numba"), (work + 1, "numpy")):
        monkeypatch.setattr("pvphong.shading.plan.plan._WORTH_COMPILING", least)
        assert bits(rgb(backend="auto", precision=precision)) == own[backend]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_ambient_light_alone_is_one_colour_for_all(backend, precision):
    count, material = 3 * BLOCK + 7, Material(ambient=(0.1, 0.2, 0.3), emission=(0.5, 0.0, 2.0))
    lit = evaluate(
        np.full((count, 3), np.nan), np.zeros((count, 3)), Scene(), material, precision=precision, backend=backend
    ).rgb
    exact = np.array([0.2 * 0.1 + 0.5, 0.2 * 0.2, 1.0])
    np.testing.assert_allclose(lit, np.broadcast_to(exact, lit.shape), rtol=4 * np.finfo(precision).eps, atol=0)
    assert (lit == lit[0]).all()


def test_ambient_light_alone_with_components_adds_up():
    count, material = BLOCK + 5, Material(ambient=0.5, emission=0.25)
    lit = evaluate(np.zeros((count, 3)), np.ones((count, 3)), Scene(), material, components=True)
    assert (lit.ambient == np.float32(0.1)).all()
    assert (lit.emission == 0.25).all()
    assert (lit.base == lit.rgb).all()


@pytest.mark.parametrize("backend", BACKENDS)
def test_another_byte_order_changes_no_bit(backend):
    points, normals = POINTS.astype(np.float32), NORMALS.astype(np.float32)
    swapped = points.astype(">f4"), normals.astype(">f4")
    assert bits(rgb(*swapped, backend=backend)) == bits(rgb(points, normals, backend=backend))


@pytest.mark.parametrize("stored", [np.uint8, np.float32, np.float64])
def test_albedo_needs_no_memory_of_its_size(stored):
    count = 1_000_000
    points, albedo = np.zeros((count, 3), np.float32), np.ones((count, 3), stored)
    tracemalloc.start()
    lit = evaluate(points, points + 1, SCENE, Material(), albedo=albedo, backend="numpy").rgb
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2 * lit.nbytes + 20e6  # the result, the normals made here, and scratch for a block


def test_a_normals_length_does_not_count():
    assert bits(rgb(normals=NORMALS * 2.0**300)) == bits(rgb())
    np.testing.assert_allclose(rgb(normals=NORMALS / 3, precision="float64"), rgb(precision="float64"), atol=1e-13)


def test_inputs_are_not_modified():
    arrays = [a.copy() for a in (POINTS, NORMALS, ALBEDO, MATRIX)]
    arrays[0][3], arrays[1][4], arrays[2][5] = np.nan, 0.0, -1.0
    before = [a.copy() for a in arrays]
    rgb(arrays[0], arrays[1], albedo=arrays[2], matrix=arrays[3])
    for array, copy in zip(arrays, before, strict=True):
        assert bits(array) == bits(copy)


# --- documented exceptions ---


@pytest.mark.parametrize("odd", [(0, 0, 0), (math.nan, 0, 1), (0, math.inf, 0)])
def test_a_normal_that_is_none_is_unlit(odd):
    normals = NORMALS.copy()
    normals[3] = odd
    shading = evaluate(POINTS, normals, SCENE, MATERIAL, components=True, precision="float64")
    assert not shading.diffuse[3].any()
    assert not shading.specular[3].any()
    assert np.isfinite(shading.rgb).all()
    untouched = np.arange(COUNT) != 3
    assert bits(shading.rgb[untouched]) == bits(rgb(precision="float64")[untouched])


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_a_point_that_is_not_finite_gets_the_sun_alone(odd):
    points = POINTS.copy()
    points[3, 2] = odd
    shading = evaluate(points, NORMALS, SCENE, MATERIAL, components=True, precision="float64")
    expected = evaluate(POINTS, NORMALS, SCENE, MATERIAL, components=True, precision="float64")
    assert not shading.per_light[2:, 3].any()
    assert not shading.specular[3].any()
    sun = dataclasses.replace(SCENE, lights=SCENE.lights[:1])
    alone = evaluate(POINTS[3:4], NORMALS[3:4], sun, MATERIAL, components=True, precision="float64")
    assert bits(shading.diffuse[3]) == bits(alone.diffuse[0])
    untouched = np.arange(COUNT) != 3
    assert bits(shading.rgb[untouched]) == bits(expected.rgb[untouched])


def test_a_light_or_an_eye_on_a_vertex():
    points, normals = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    on_it = Scene(lights=[PointLight(), SpotLight()], viewer=Viewer(position=(0, 0, 5)))
    shading = evaluate(points, normals, on_it, MATERIAL, components=True)
    assert not shading.diffuse.any()
    assert not shading.specular.any()
    eye = Scene(lights=[PointLight(position=(0, 0, 2))], viewer=Viewer(position=(0, 0, 0), focal_point=(0, 0, 1)))
    shading = evaluate(points, normals, eye, MATERIAL, components=True)
    assert shading.diffuse.all()
    assert not shading.specular.any()
