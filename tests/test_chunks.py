"""`evaluate` on Dask arrays: lazy colours, bit for bit those of NumPy arrays, and clear errors."""

import threading
from dataclasses import fields, replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base import threads
from pvphong.shading import evaluation, kernel

dask = pytest.importorskip("dask")
cloudpickle = pytest.importorskip("cloudpickle")
da = pytest.importorskip("dask.array")

COUNT = 1000
RNG = np.random.default_rng(7)
POINTS, NORMALS = RNG.normal(size=(2, COUNT, 3)).astype(np.float32)
POINTS[[3, 700]] = (np.nan, 0, 0), (2, -1, 3)
ALBEDO, SEEN = RNG.random((COUNT, 3)), RNG.random((3, COUNT))
SHADOWY = ph.LightModel(shadows=True, ambient_occlusion=True)
LIGHTS = [ph.PointLight(position=(2, -1, 3), attenuation=(1, 0.1, 0.02)), ph.DirectionalLight(direction=(-1, -1, -2))]
SCENE = ph.Scene(LIGHTS, ph.Viewer(position=(0, -3, 4)), SHADOWY)
PLAIN = ph.Scene(LIGHTS, ph.Viewer(position=(0, -3, 4)))
SHINY = ph.Material(diffuse=0.5, specular=0.4, shininess=25)
BACKENDS = ["numpy", "numba"] if kernel.is_available() else ["numpy"]
MATRIX = np.array([[1, 0.5, 0, 3], [0, -2, 0.1, 1], [0.2, 0, 1, -1], [0, 0, 0, 1]], float)


def cut(array, chunks):
    return da.from_array(array, chunks=(chunks, -1))


def same(shading, expected):
    for field in fields(expected):
        one, other = getattr(shading, field.name), getattr(expected, field.name)
        assert (one is None) == (other is None)
        if other is not None:
            assert one.dtype == other.dtype
            np.testing.assert_array_equal(np.asarray(one), other)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("chunks", [COUNT, 500, 37, (1, 7, 991, 1), (400, 0, 600)], ids=str)
def test_bits_are_those_of_arrays_in_one_piece(chunks, backend):
    how = {"backend": backend, "precision": "float64" if chunks == 500 else "float32"}
    expected = ph.evaluate(POINTS, NORMALS, SCENE, replace(SHINY, albedo=ALBEDO), visibility=SEEN, **how)
    shading = ph.evaluate(
        cut(POINTS, chunks), NORMALS, SCENE, replace(SHINY, albedo=cut(ALBEDO, 300)), visibility=cut(SEEN, 1), **how
    )
    assert shading.rgb.shape == (COUNT, 3)
    same(shading, expected)


def test_all_that_is_given_for_each_vertex_comes_in_chunks():
    given = {"specular": RNG.random(COUNT), "shininess": 1 + 50 * RNG.random(COUNT), "tangents": RNG.random((COUNT, 3))}
    lazy = given | {"specular": da.from_array(given["specular"], chunks=90), "tangents": cut(given["tangents"], 200)}
    expected, material = ph.evaluate(POINTS, NORMALS, PLAIN, ph.Material(**given)), ph.Material(**lazy)
    same(ph.evaluate(cut(POINTS, 300), NORMALS, PLAIN, material), expected)
    same(ph.evaluate(POINTS, NORMALS, PLAIN, material), expected)


def test_a_task_carries_no_map_of_all_vertices():
    material = ph.Material(albedo=RNG.random((COUNT, 3)), tangents=RNG.random((COUNT, 3)))
    shading = ph.evaluate(cut(POINTS, 100), NORMALS, PLAIN, material)
    tasks = {key: len(cloudpickle.dumps(task)) for key, task in dict(shading.rgb.__dask_graph__()).items()}
    assert len(tasks) > 10
    wholes = [key for key, size in tasks.items() if size > POINTS.nbytes / 2]
    assert len(wholes) == 3, wholes  # the arrays themselves


@pytest.mark.parametrize("options", [{}, {"clim": (0.2, 0.6)}, {"categories": True}, {"log_scale": True}], ids=str)
@pytest.mark.parametrize("columns", [1, 2])
def test_colormaps_have_the_range_of_all_chunks(options, columns):
    numbers = np.where(np.arange(COUNT) < 400, np.nan, np.round(RNG.random(COUNT), 1) + 0.1)  # an empty chunk
    numbers = np.column_stack([numbers, -numbers]) if columns == 2 else numbers
    lazy = da.from_array(numbers, chunks=(300, columns)[: numbers.ndim])
    expected = ph.evaluate(POINTS, NORMALS, PLAIN, ph.Material(albedo=ph.Colormap(numbers, "terrain", **options)))
    for points in POINTS, cut(POINTS, 500):
        for scalars in (lazy, numbers) if points is not POINTS else (lazy,):
            colormap = ph.Colormap(scalars, "terrain", **options)
            same(ph.evaluate(points, NORMALS, PLAIN, ph.Material(albedo=colormap)), expected)


@pytest.mark.parametrize("how", [{"scheduler": "threads"}, {"scheduler": "processes"}, "distributed"], ids=str)
def test_every_scheduler_does(how, request):
    expected = ph.evaluate(POINTS, NORMALS, PLAIN, SHINY, components=True, backend="numpy")
    shading = ph.evaluate(cut(POINTS, 300), cut(NORMALS, 400), PLAIN, SHINY, components=True, backend="numpy")
    if how == "distributed":
        distributed = pytest.importorskip("distributed")
        client = distributed.Client(processes=False, n_workers=1, threads_per_worker=2, dashboard_address=":0")
        request.addfinalizer(client.close)
        how = {"scheduler": client}
    same(*dask.compute(shading, **how), expected)


def test_nothing_is_computed_before_it_is_asked_for_and_then_once(monkeypatch):
    calls, whole = [], evaluation.evaluate

    def counted(points, *given, **options):
        calls.append((len(points), threads.count(), threading.get_ident()))
        return whole(points, *given, **options)

    monkeypatch.setattr(evaluation, "evaluate", counted)
    shading = ph.evaluate(cut(POINTS, 250), NORMALS, PLAIN, SHINY, components=True)
    assert [length for length, *_ in calls] == [0], "what it will be like is known from no vertex at all"
    (computed,) = dask.compute(shading)
    assert isinstance(computed, ph.Shading)
    assert sorted(length for length, *_ in calls) == [0, 250, 250, 250, 250]
    assert {count for length, count, _ in calls if length} == {1}, "Dask's threads are all there are"
    assert repr(shading) == repr(computed) == "<Shading of 1000 vertices, float32, components of 2 lights>"


@pytest.mark.parametrize("chunks", [(3, 1, 996), (900, 100)], ids=str)
@pytest.mark.parametrize("matrix", [None, MATRIX], ids=["", "matrix"])
def test_a_scene_without_a_viewer_is_framed_by_all_points(matrix, chunks):
    how = {"matrix": matrix, "backend": "numpy"}
    expected = ph.evaluate(POINTS, NORMALS, LIGHTS, SHINY, **how)
    same(ph.evaluate(cut(POINTS, chunks), NORMALS, LIGHTS, SHINY, **how), expected)


def test_each_chunk_plans_for_itself_within_the_tolerance():
    far, how = ph.Scene([ph.PointLight(position=(900, 0, 0))], PLAIN.viewer), {"precision": "float64"}
    points, normals = POINTS[10:], NORMALS[10:]  # NaN points are excluded from the plan
    exact = ph.evaluate(points, normals, far, ph.Material(), **how).rgb
    near = ph.evaluate(cut(points, 30), normals, far, ph.Material(), **how, tolerance=0.01).rgb.compute()
    assert 0 < np.abs(near - exact).max() <= 0.01


def test_chunks_of_unknown_length_are_lit_where_they_fit():
    some = da.from_array(np.arange(COUNT) % 3 == 0, chunks=250)
    points, normals = cut(POINTS, 250)[some], cut(NORMALS, 250)[some]
    rows = some.compute()
    same(
        ph.evaluate(points, normals, PLAIN, SHINY, backend="numpy"),
        ph.evaluate(POINTS[rows], NORMALS[rows], PLAIN, SHINY, backend="numpy"),
    )
    short = (
        r"^normals must be an array with one row .*; got 334 rows, but points has 4 chunks of .* Call points\.compute"
    )
    with pytest.raises(ValueError, match=short):
        ph.evaluate(points, NORMALS[rows], PLAIN, SHINY)
    fewer = cut(NORMALS, 500)[some.rechunk(500)]
    short = (
        r"^normals .* 2 chunks of unknown length, but points has 4 chunks of .* and normals\.compute_chunk_sizes\(\)"
    )
    with pytest.raises(ValueError, match=short):
        ph.evaluate(points, fewer, PLAIN, SHINY)


SHORT = r"^normals must be an array with one row per point; got 990 rows, but points has 1000 rows\.$"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": da.from_array(POINTS, chunks=(100, 2))}, r"^points must be chunked along vertices only; .*rechunk"),
        ({"points": cut(POINTS, 10)[:, :2]}, r"^points must be an \(n, 3\) array"),
        ({"points": cut(POINTS, 10)[:, 0]}, r"^points must be an \(n, 3\) array of real numbers"),
        ({"points": cut(POINTS, 10).astype(complex)}, r"^points must be .* got an array of complex"),
        ({"points": dask.delayed(POINTS)}, r"^points must be a Dask array: .* got a Delayed"),
        ({"normals": NORMALS[:990]}, SHORT),
        ({"normals": cut(NORMALS[:990], 10)}, SHORT),
        ({"normals": "up"}, r"^normals must be an array of real numbers, a row for each vertex"),
        ({"material": ph.Material(albedo=cut(ALBEDO, 10)[:1])}, r"^albedo must be .*one row per point.*; got 1 rows"),
        ({"material": ph.Material(albedo=cut(ALBEDO, 10).astype(int))}, r"^albedo must be uint8 or floats"),
        ({"visibility": cut(SEEN[:2], 10)}, r"^visibility must be the result of .* or an array of shape \(3, 0\)"),
        ({"material": "gld"}, r"^material must be a Material"),
        ({"matrix": np.eye(3)}, r"^matrix must be a 4x4 matrix"),
        ({"tolerance": -1}, r"^tolerance must be a finite number >= 0"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_what_is_wrong_is_said_at_once(change, message):
    given = {"points": cut(POINTS, 100), "normals": NORMALS, "scene": SCENE, "material": SHINY, "visibility": SEEN}
    with pytest.raises(ValueError, match=message):
        ph.evaluate(**given | change)


@pytest.mark.parametrize("points", [POINTS, cut(POINTS, 100)], ids=["numpy", "dask"])
def test_more_positional_arguments_than_there_are_raise_a_type_error(points):
    with pytest.raises(TypeError, match=r"evaluate\(\) takes 4 positional arguments but 5 were given"):
        ph.evaluate(points, NORMALS, PLAIN, SHINY, MATRIX)


@pytest.mark.parametrize("points", [POINTS, cut(POINTS, 100)], ids=["numpy", "dask"])
def test_an_argument_that_is_given_twice_raises_a_type_error(points):
    with pytest.raises(TypeError, match="multiple values for argument 'normals'"):
        ph.evaluate(points, NORMALS, PLAIN, SHINY, normals=NORMALS)


def test_plain_numbers_of_what_is_seen_do_for_numpy_too():
    ring = pv.ParametricTorus(u_res=20, v_res=20, w_res=20)
    scene = ph.Scene(LIGHTS, SCENE.viewer, SHADOWY)
    seen = ring.phong.visibility(scene)
    normals = ring.phong.normals()
    one = ph.evaluate(ring.points, normals, scene, SHINY, visibility=seen).rgb
    numbers = np.vstack([seen.per_light, seen.sky])
    np.testing.assert_allclose(ph.evaluate(ring.points, normals, scene, SHINY, visibility=numbers).rgb, one, atol=1e-6)
    with pytest.raises(ValueError, match=r"^visibility must be .* of shape \(3, \d+\); got an array of shape \(2, "):
        ph.evaluate(ring.points, normals, scene, SHINY, visibility=numbers[1:])
    with pytest.raises(ValueError, match=r"^visibility must be an array of real numbers, shape \(lights \+ 1, n\)"):
        ph.evaluate(cut(ring.points, 50), normals, scene, SHINY, visibility=seen)
