"""The compiled evaluator computes what the readable one does, and declines what it cannot do."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import pvphong as ph
from pvphong.shading import kernel
from pvphong.shading.equation import assemble
from pvphong.shading.evaluation import display_colors
from pvphong.shading.kernel.rows import GROUP
from pvphong.shading.plan.plan import make_plan
from pvphong.shading.result import Shading

pytest.importorskip("numba", reason="the extra `fast` is not installed")
pytestmark = pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")

COUNT = 1500  # more than two of the kernel's blocks, and not a multiple of their size
SUN = ph.DirectionalLight(direction=(-1, -1, -2), diffuse=(1, 0.9, 0.7), ambient=0.1)
LAMP = ph.PointLight(position=(2, -1, 3), attenuation=(1, 0.1, 0.02), diffuse=(0.5, 0.7, 1))
SPOT = ph.SpotLight(position=(1, 1, 4), direction=(-1, -1, -4), cone_angle=20, exponent=9, ambient=0.2)
BULB = ph.PointLight(position=(-2, 1, 2), diffuse=(0.8, 0.7, 0.4))
EVEN = ph.SpotLight(position=(1, 1, 4), direction=(-1, -1, -4), cone_angle=20, exponent=0, attenuation=(0, 1, 0))
HEAD = ph.DirectionalLight(frame="headlight")
SHINY = ph.Material(ambient=0.3, diffuse=(0.4, 0.5, 0.6), specular=(0.5, 0.4, 0.3), shininess=25, emission=0.05)
DULL = replace(SHINY, specular=0.0)
WHITE = ph.Material(ambient=0.0, diffuse=1.0, specular=1.0, shininess=9.0)
SHEAR = np.array([[1, 0.4, 0, 2], [0, 1.5, 0.3, 0], [0, 0, -0.7, 1], [0, 0, 0, 1.0]])

SHAPES = {
    "nothing": ([], SHINY, {}),
    "sun, dull": ([SUN], DULL, {}),
    "sun": ([SUN], SHINY, {}),
    "lamp, dull": ([LAMP], DULL, {}),
    "lamp": ([LAMP], SHINY, {}),
    "bulbs, dull": ([BULB, replace(BULB, position=(1, 2, -1))], DULL, {}),
    "bulb": ([BULB], SHINY, {}),
    "spot": ([SPOT], SHINY, {}),
    "even spot": ([EVEN], SHINY, {}),
    "all": ([SUN, LAMP, SPOT, EVEN, HEAD], SHINY, {}),
    "blinn-phong": ([SUN, LAMP, SPOT], SHINY, {"reflection": "blinn-phong"}),
    "infinite viewer": ([SUN, LAMP], SHINY, {"local_viewer": False}),
    "two-sided": ([SUN, LAMP], SHINY, {"two_sided": True}),
    "unclamped": ([SUN, LAMP, replace(LAMP, intensity=9.0)], SHINY, {"clamp": False}),
    "no shininess": ([SUN, LAMP], replace(SHINY, shininess=0.0), {}),
    "needle": ([SUN, LAMP], replace(SHINY, shininess=1e5), {}),
}
VTK = {
    "vtk, headlight": ([HEAD], SHINY),
    "vtk, sun": ([SUN, HEAD], SHINY),
    "vtk, lamp": ([LAMP, SPOT], SHINY),
    "vtk, blunt": ([LAMP], replace(SHINY, shininess=0.1)),
    "vtk, unlit": ([], SHINY),
}


def scene_of(name):
    if name in VTK:
        lights, material = VTK[name]
        return ph.Scene(lights, ph.Viewer(position=(0, -3, 4)), ph.LightModel.vtk()), material
    lights, material, model = SHAPES[name]
    return ph.Scene(lights, ph.Viewer(position=(0, -3, 4)), ph.LightModel(**model)), material


@pytest.fixture(scope="module")
def vertices():
    random = np.random.default_rng(7)
    points = random.normal(size=(COUNT, 3))
    return points, points + 0.3 * random.normal(size=(COUNT, 3))


def shade(vertices, name, backend, precision, **options):
    scene, material = scene_of(name)
    return ph.evaluate(*vertices, scene, material, backend=backend, precision=precision, **options).rgb


def undecided(vertices, name, matrix=None):
    """Vertices within rounding of n·l = 0, n·v = 0 or the edge of a cone: there either answer is right."""
    scene, _ = scene_of(name)
    points, normals = vertices
    if matrix is not None:
        points, normals = ph.transform_points(points, matrix), ph.transform_normals(normals, matrix)
    near = np.zeros(len(points), bool)
    for light in scene.world_lights:
        arrival = light.arrival(np.ascontiguousarray(points.T))
        near |= np.abs((normals.T * arrival.direction).sum(axis=0)) < 1e-5
        if isinstance(light, ph.SpotLight):
            axis = np.array(light.direction) / np.linalg.norm(light.direction)
            near |= np.abs(-axis @ arrival.direction - np.cos(np.radians(light.cone_angle))) < 1e-6
    toward = np.array(scene.viewer.position) - points
    return near | (np.abs((normals * toward).sum(axis=1)) < 1e-5)


@pytest.mark.parametrize("options", [{}, {"matrix": SHEAR}, {"albedo": "random"}], ids=["plain", "matrix", "albedo"])
@pytest.mark.parametrize(("precision", "unit"), [("float32", 2.0**-24), ("float64", 2.0**-53)])
@pytest.mark.parametrize("name", [*SHAPES, *VTK])
def test_it_agrees_with_the_reference(vertices, name, precision, unit, options):
    """Each is within (4√n + 16)·u of the exact colour for each light, so they are within twice that of each other."""
    if options.get("albedo"):
        options = {"albedo": np.random.default_rng(3).random((COUNT, 3))}
    stored = tuple(array.astype(precision) for array in vertices)
    ours, theirs = (shade(stored, name, backend, precision, **options) for backend in ("numba", "numpy"))
    scene, material = scene_of(name)
    power = max([material.shininess, *(light.exponent for light in scene.lights if isinstance(light, ph.SpotLight))])
    bound = 2 * (4 * np.sqrt(power) + 16) * unit * (1 + len(scene.lights)) * max(1.0, float(theirs.max()))
    judged = ~undecided(stored, name, options.get("matrix"))
    assert judged.mean() > 0.99
    assert np.abs(ours.astype(float) - theirs)[judged].max() <= bound
    assert ours.dtype == precision


@pytest.mark.parametrize("name", ["all", "blinn-phong", "two-sided", "sun, dull", "bulbs, dull", "bulb"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_vertex_keeps_its_bits_among_others_and_in_any_layout(vertices, name, precision):
    points, normals = (array.astype(precision) for array in vertices)
    whole = shade((points, normals), name, "numba", precision)
    order = np.random.default_rng(1).permutation(COUNT)
    np.testing.assert_array_equal(shade((points[order], normals[order]), name, "numba", precision), whole[order])
    np.testing.assert_array_equal(shade((points[700:], normals[700:]), name, "numba", precision), whole[700:])
    fortran = np.asfortranarray(points), np.repeat(normals, 2, axis=0)[::2]
    np.testing.assert_array_equal(shade(fortran, name, "numba", precision), whole)
    for spoil in (np.nan, np.inf, 0.0):
        spoiled_points, spoiled_normals = points.copy(), normals.copy()
        spoiled_points[3], spoiled_normals[801] = spoil, spoil
        lit = shade((spoiled_points, spoiled_normals), name, "numba", precision)
        others = np.delete(np.arange(COUNT), [3, 801])
        np.testing.assert_array_equal(lit[others], whole[others])
        assert np.isfinite(lit).all()
        reference = shade((spoiled_points, spoiled_normals), name, "numpy", precision)
        np.testing.assert_allclose(lit[[3, 801]], reference[[3, 801]], atol=1e-5)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize(("name", "has_albedo"), [("all", True), ("lamp, dull", False), ("sun, dull", False)])
def test_a_large_mesh_has_the_bits_of_its_pieces(vertices, precision, name, has_albedo):
    """Several threads' shares, of which the last block is not whole; and nothing is written beside them."""
    count = 5 * GROUP + 77
    points, normals = (np.resize(array.astype(precision), (count, 3)) for array in vertices)
    albedo = np.random.default_rng(5).random((count, 3)).astype(precision) if has_albedo else None
    scene, material = scene_of(name)
    equation = assemble(scene, material, None)
    pieces, memory = np.empty((count, 3), precision), np.full((count + 2, 3), np.nan, precision)
    for start in range(0, count, COUNT):
        part = slice(start, start + COUNT)
        shades = None if albedo is None else albedo[part]
        assert kernel.shade(points[part], normals[part], equation, shades, Shading(pieces[part]))
    assert kernel.shade(points, normals, equation, albedo, Shading(memory[1:-1]))
    np.testing.assert_array_equal(memory[1:-1], pieces)
    assert np.isnan(memory[[0, -1]]).all()


def test_the_number_of_threads_changes_no_bit(vertices):
    import numba

    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("there is a single thread")

    many = tuple(np.tile(array, (20, 1)) for array in vertices)
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        alone = shade(many, "all", "numba", "float32")
    finally:
        numba.set_num_threads(threads)
    np.testing.assert_array_equal(shade(many, "all", "numba", "float32"), alone)


def test_colours_for_a_display_are_the_rounded_floats(vertices):
    points, normals = (np.tile(array.astype(np.float32), (200, 1)) for array in vertices)
    scene, material = scene_of("all")
    left = ph.plan(points, scene, material).equation
    shown = np.zeros((len(points), 3), np.uint8)
    display_colors(points, normals, assemble(scene, material, None), left, None, shown)
    exact = ph.evaluate(points, normals, scene, material, backend="numba").rgb * np.float32(255.0)
    np.testing.assert_array_equal(shown, np.rint(exact))
    assert len(np.unique(shown)) > 100


def test_moving_or_tinting_a_light_compiles_nothing(vertices):
    shade(vertices, "all", "numba", "float32")
    compiled = kernel._compiled(kernel._Process.keeps_code)
    before = len(compiled.signatures)
    scene, material = scene_of("all")
    for light in (replace(LAMP, position=(5, 5, 5)), replace(SPOT, diffuse="red", cone_angle=31.0), SUN):
        ph.evaluate(*vertices, replace(scene, lights=[light]), replace(material, shininess=3.0), backend="numba")
    assert len(compiled.signatures) == before


def result_of(rows, **arrays):
    return Shading(np.full((rows, 3), 7.0, np.float32), **arrays)


@pytest.mark.parametrize("count", [2**15, 2**15 + 1, 2**15 + 130, 50_000])
@pytest.mark.parametrize(("stored", "precision"), [("f4", "float32"), ("f8", "float32"), ("f8", "float64")])
def test_the_bounds_that_it_finds_are_numpys(stored, precision, count):
    random = np.random.default_rng(count)
    rows = (random.normal(size=(count, 3)) * (1.0, 1e3, 1e-20) + (5.0, 0.0, 1e-19)).astype(stored)
    rows[-1] = -7.0, 1e4, 1.0
    ph.evaluate(rows[:9], rows[:9], *scene_of("lamp"), backend="numba", precision=precision)
    low, high = kernel.find_bounds(rows)
    np.testing.assert_array_equal(low, rows.min(axis=0))
    np.testing.assert_array_equal(high, rows.max(axis=0))
    rows[count // 2, 1] = random.choice((np.nan, np.inf, -np.inf))
    assert np.isnan(kernel.find_bounds(rows)).all()


def test_bounds_are_left_to_numpy_where_they_would_take_longer():
    rows = np.ones((2**15, 3), np.float32)
    ph.evaluate(rows[:9], rows[:9], *scene_of("lamp"), backend="numba")
    assert kernel.find_bounds(rows) is not None
    assert kernel.find_bounds(rows[1:]) is None
    assert kernel.find_bounds(np.ones((2**15, 6), np.float32)[:, ::2]) is None
    assert kernel.find_bounds(rows.astype(np.float16)) is None


@pytest.mark.parametrize("distance", [6.0, 60.0])
def test_a_plan_is_the_same_by_the_bounds_of_either(distance):
    random = np.random.default_rng(3)
    points = (random.uniform(-1, 1, size=(2**15, 3)) * (1.0, 0.3, 0.05) + (4.0, -2.0, 1.0)).astype(np.float32)
    normals = (np.abs(points) * (0.01, 0.02, 1.0)).astype(np.float32)
    lights = [
        ph.PointLight(position=(4, -2, distance), attenuation=(1, 0, 0.01)),
        ph.PointLight(position=(4 - 9 * distance, -2, distance)),
        ph.SpotLight(position=(4, -2, distance), direction=(0.1, 0, -1), cone_angle=25, exponent=1),
    ]
    scene = ph.Scene(lights, ph.Viewer(position=(4, -2 - 30 * distance, 3)), ph.LightModel(two_sided=True))
    ph.evaluate(points[:9], points[:9], scene, SHINY, backend="numba")
    asked = []

    def search(rows):
        asked.append(kernel.find_bounds(rows))
        return asked[-1]

    plans = [make_plan(points, normals, scene, SHINY, None, 0.2, by) for by in (None, search)]
    assert len(asked) == 2
    assert all(found is not None for found in asked)
    assert plans[0].explain() == plans[1].explain()
    assert plans[0].error_bound == plans[1].error_bound > 0.0
    wrong = make_plan(points, normals, scene, SHINY, None, 0.2, lambda rows: tuple(2 * x for x in search(rows)))
    assert wrong.error_bound != plans[0].error_bound


def test_looking_for_bounds_compiles_nothing():
    rows = np.ones((2**15, 3), np.float32)
    ph.evaluate(rows[:9], rows[:9], *scene_of("lamp"), backend="numba")
    compiled = kernel._compiled(kernel._Process.keeps_code)
    before = list(compiled.signatures)
    assert kernel.find_bounds(rows) is not None
    assert compiled.signatures == before


@pytest.mark.parametrize("lights", [[], [replace(SUN, ambient=0.3)], [replace(LAMP, ambient=0.3)]])
def test_the_type_of_what_is_not_read_compiles_nothing(lights):
    scene, matt = ph.Scene(lights), ph.Material(ambient=0.5, diffuse=0.0)
    rows = np.ones((9, 3), np.float32)
    ph.evaluate(rows, rows, *scene_of("lamp"), backend="numba")
    compiled = kernel._compiled(kernel._Process.keeps_code)
    before = list(compiled.signatures)
    unread = np.zeros((9, 3))
    ph.evaluate(rows, unread, scene, matt, backend="numba")
    assert compiled.signatures == before


def test_it_declines_what_it_cannot_do_and_writes_nothing(vertices):
    points, normals = vertices
    far = ph.Scene([replace(LAMP, position=(1e200, 0, 0))])
    result = result_of(COUNT)
    assert not kernel.shade(points, normals, assemble(far, SHINY, None), None, result)
    assert (result.rgb == 7.0).all()
    with_parts = result_of(COUNT, base=np.zeros((COUNT, 3), np.float32))
    assert not kernel.shade(points, normals, assemble(*scene_of("lamp"), None), None, with_parts)


@pytest.mark.parametrize("intensity", [1e30, 1e40, 1e300])
def test_lights_as_bright_as_they_are_far_away(vertices, intensity):
    far = ph.PointLight(position=(0, 0, 1e20), attenuation=(0, 0, 1), intensity=intensity)
    lit = [ph.evaluate(*vertices, ph.Scene([far]), DULL, backend=backend).rgb for backend in ("numba", "numpy")]
    np.testing.assert_allclose(*lit, atol=1e-5)


def run_apart(code, **environment):
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=os.environ | environment,
    )


EVALUATE = """
import numpy as np, pvphong as ph
def lit(backend, n=3):
    return ph.evaluate(np.zeros((n, 3)), np.tile([0, 0, 1.0], (n, 1)), ph.Scene([ph.DirectionalLight()]), ph.Material(),
                       backend=backend).rgb[0]
"""


def test_without_numba_all_works_but_asking_for_it():
    code = f"""
import sys
sys.modules["numba"] = None
{EVALUATE}
assert abs(lit("auto", 300000) - 0.84).max() < 1e-6
try:
    lit("numba")
except ValueError as error:
    print(error)
"""
    process = run_apart(code)
    assert process.returncode == 0, process.stderr
    assert "backend must be 'auto' or 'numpy' where Numba is not installed" in process.stdout


def test_without_a_folder_for_compiled_code_it_is_no_failure_but_not_worth_compiling():
    code = f"""
from unittest import mock
from numba.core import caching
from pvphong.shading import kernel
{EVALUATE}
# The tests may run as root, for whom no folder is closed.
with mock.patch.object(caching._CacheLocator, "ensure_cache_path", side_effect=PermissionError):
    assert kernel.is_available()
    assert not kernel.keeps_code()
    with mock.patch.object(kernel, "shade", side_effect=AssertionError("it compiles")):
        print(lit("auto", 300000))
"""
    process = run_apart(code)
    assert process.returncode == 0, process.stderr
    assert process.stdout.count("0.84") == 3, process.stdout


class KeptCode:
    """Compiled code with a cache on disk that is damaged: whatever reading it raises."""

    def __init__(self, can_be_mended):
        self.can_be_mended, self.is_damaged, self._cache, self.calls = can_be_mended, True, self, []

    def flush(self):
        if not self.can_be_mended:
            raise OSError("no space left on the device")
        self.is_damaged = False

    def __call__(self, argument):
        if self.is_damaged:
            raise ValueError("invalid literal for int()")  # as for a text in place of Numba's index
        self.calls.append(argument)


@pytest.mark.parametrize("can_be_mended", [True, False])
def test_kept_code_that_is_damaged_is_replaced_or_done_without(monkeypatch, can_be_mended):
    kept, anew = KeptCode(can_be_mended), []
    monkeypatch.setattr(kernel, "_compiled", lambda keeps_code: kept if keeps_code else anew.append)
    monkeypatch.setattr(kernel._Process, "keeps_code", True)
    monkeypatch.setattr(kernel._Process, "has_mended", False)
    kernel._run("arguments")
    assert (kept.calls, anew) == ((["arguments"], []) if can_be_mended else ([], ["arguments"]))
    assert kernel._Process.keeps_code is can_be_mended


def test_what_goes_wrong_without_kept_code_too_is_an_error(monkeypatch):
    monkeypatch.setattr(kernel, "_compiled", lambda _: KeptCode(can_be_mended=False))
    monkeypatch.setattr(kernel._Process, "keeps_code", True)
    monkeypatch.setattr(kernel._Process, "has_mended", False)
    with pytest.raises(ValueError, match="invalid literal"):
        kernel._run("arguments")


def test_what_reaches_the_vertices_does_not_choose_the_evaluator():
    """By the lights that a plan leaves, one spoiled vertex would send all the others to the other evaluator."""
    away = ph.SpotLight(position=(0, 0, 50), direction=(0, 0, 1), cone_angle=30)
    scene = ph.Scene([away, LAMP])
    points, normals = np.random.default_rng(8).normal(size=(2, 150_000, 3)).astype(np.float32)
    before = ph.evaluate(points, normals, scene, SHINY).rgb
    points[-1] = np.nan
    after = ph.evaluate(points, normals, scene, SHINY).rgb
    np.testing.assert_array_equal(after[:-1], before[:-1])


def test_what_reaches_the_vertices_does_not_choose_the_evaluator_of_a_window(monkeypatch):
    """The points are too few for the kernel by the lights that a plan leaves, and enough by those of the scene."""
    asked = []
    monkeypatch.setattr(kernel, "shade", lambda *arguments: asked.append(arguments) or True)
    away = ph.SpotLight(position=(0, 0, 50), direction=(0, 0, 1), cone_angle=30)
    scene, points = ph.Scene([away, LAMP]), np.random.default_rng(8).normal(size=(150_000, 3)).astype(np.float32)
    whole, left = assemble(scene, SHINY, None), ph.plan(points, scene, SHINY).equation
    assert (len(whole.terms), len(left.terms)) == (2, 1)
    display_colors(points, points, whole, left, None, np.empty(points.shape, np.uint8))
    assert asked[0][2] is left
    assert asked[0][-1] is whole


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("count", [100, 200])
def test_what_light_grazes_exactly_stays_dark(precision, count):
    """n·l is 0 in the stored numbers, for their products cancel; with them fused half the vertices had a highlight."""
    a, b = np.random.default_rng(41).normal(size=(2, count)).astype(precision)
    normals = np.stack([a, b, np.zeros_like(a)], axis=1)
    for i in range(count):
        lamp, viewer = ph.PointLight(position=(b[i], -a[i], 0.0)), ph.Viewer(position=(-b[i], a[i], 1e-9))
        scene = ph.Scene([lamp], viewer, ph.LightModel(ambient=0.0))
        for material in (WHITE, replace(WHITE, specular=0.0)):
            lit = ph.evaluate(np.zeros_like(normals), normals, scene, material, precision=precision, backend="numba")
            assert not lit.rgb[i].any()


def test_numba_told_not_to_compile_is_as_if_it_were_not_there():
    code = f"""
{EVALUATE}
print(lit("auto", 300000))
try:
    lit("numba")
except ValueError as error:
    print(error)
"""
    process = run_apart(code, NUMBA_DISABLE_JIT="1")
    assert process.returncode == 0, process.stderr
    assert "0.84" in process.stdout
    assert "where Numba does not compile" in process.stdout


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_child_says_why_it_cannot_use_numba():
    code = f"""
{EVALUATE}
import os
lit("numba")
if not os.fork():
    assert abs(lit("auto", 300000) - 0.84).max() < 1e-6
    try:
        lit("numba")
    except ValueError as error:
        print(error, flush=True)
    os._exit(0)
os.wait()
"""
    process = run_apart(code)
    assert process.returncode == 0, process.stderr
    assert "forked from one that has used Numba" in process.stdout


def test_several_python_threads_may_evaluate_at_once():
    # Numba's own threads, where neither OpenMP nor TBB is there, abort the process when two callers meet.
    code = f"""
{EVALUATE}
from concurrent.futures import ThreadPoolExecutor
with ThreadPoolExecutor(4) as pool:
    for colour in pool.map(lambda _: lit("numba", 200000), range(12)):
        assert abs(colour - 0.84).max() < 1e-6
"""
    process = run_apart(code, NUMBA_THREADING_LAYER="workqueue", NUMBA_NUM_THREADS="2")
    assert process.returncode == 0, process.stderr


def test_importing_pvphong_does_not_import_numba():
    process = run_apart("import sys, pvphong; assert 'numba' not in sys.modules")
    assert process.returncode == 0, process.stderr
