"""Whether any computed number has moved: scenes over the whole space of arguments, their colours to the bit.

    python tests/bits.py             compares with tests/bits.json and lists what moved; exit status 1 if anything did
    python tests/bits.py --record    writes tests/bits.json

Bits are those of one processor and of some versions of libraries: NumPy chooses its exp and log by the processor, LLVM
whether products and sums are fused. So hashes are recorded under the name of a machine, as far as it matters. For all
other machines there are two weighted sums of each case's colours, which agree within the rounding that `evaluate`
documents. Plans are the same everywhere.

Only the public interface is used, so that the package's insides can be moved. A scene is drawn from its index alone:
more scenes do not change those that are there, but a change in how any is drawn asks for a new record.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import math
import platform
import sys
import warnings
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv

import pvphong as ph

RECORD = Path(__file__).with_name("bits.json")
SCENES = 220
BACKENDS, PRECISIONS = ("numpy", "numba"), ("float32", "float64")

# The kernel takes vertices in blocks of 128 and groups of 4096, the reference in blocks of 32768.
_COUNTS = 2 * [0, 1, 1, 9, 128, 5000, 5000, 5000] + 20 * [300] + [4097, 33000]
_MATRICES = 5 * ["none"] + ["rigid", "mirror", "shear", "scaled", "w", "flat", "far"]
# 1e-310 is subnormal in float64, 1e-40 in float32.
_UNITS = 24 * [1.0] + [1e-40, 1e-310, 1e8, 1e30]
_ALONG_Z = (0.0, 0.0, -1.0)


class Dice:
    """Throws of numbers, vectors and colours by one generator; only `random` is drawn of it."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed).random

    def likely(self, percent: float) -> bool:
        return self._random() * 100 < percent

    def below(self, count: int) -> int:
        return int(self._random() * count)

    def pick(self, options: Any) -> Any:
        return options[self.below(len(options))]

    def between(self, low: float, high: float) -> float:
        return low + (high - low) * self._random()

    def log_between(self, low: float, high: float) -> float:
        return math.exp(self.between(math.log(low), math.log(high)))

    def vectors(self, count: int) -> np.ndarray:
        return 2.0 * self._random((count, 3)) - 1.0

    def vector(self) -> np.ndarray:
        return self.vectors(1)[0]

    def direction(self) -> np.ndarray:
        return unit(self.vector())

    def color(self) -> Any:
        return self._random() if self.likely(40) else triple(self._random(3))


def unit(a: np.ndarray) -> np.ndarray:
    """Of length 1, or NaN; by operations that round the same everywhere."""
    with np.errstate(invalid="ignore"):
        a = a / np.abs(a).max(axis=-1, keepdims=True)
        return a / np.sqrt((a * a).sum(axis=-1, keepdims=True))


def triple(a: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in a)
    return x, y, z


# --- scenes ---


@dataclass(frozen=True)
class Case:
    """The arguments of one scene's evaluations and plans."""

    points: np.ndarray
    normals: np.ndarray
    scene: ph.Scene
    material: ph.Material
    matrix: np.ndarray | None
    albedo: np.ndarray | None
    tolerance: float
    components: bool


@dataclass(frozen=True)
class Place:
    """Where the matrix puts the mesh in the world, how large it is there, and one vertex to stand on."""

    centre: np.ndarray
    size: float
    vertex: np.ndarray

    def near(self, dice: Dice) -> np.ndarray:
        return self.centre + self.size * dice.between(1.0, 5.0) * dice.direction()


def draw(index: int) -> Case:
    """The scene of an index."""
    dice = Dice(index)
    scale = dice.pick(_UNITS)
    stored = np.float64 if scale < 1e-300 or dice.likely(40) else np.float32
    points = (dice.vectors(dice.pick(_COUNTS)) * scale).astype(stored)
    points[:1] *= dice.likely(50)
    matrix = _matrix(dice, scale)
    place = _place(matrix, points, scale)
    model = _light_model(dice)
    viewer = _viewer(dice, place)
    lights = _lights(dice, place, viewer, model)
    material = _material(dice)
    scene = ph.Scene(lights=lights, viewer=viewer, light_model=model)
    normals = _normals(dice, points, scene, matrix, material).astype(stored)
    if dice.likely(35):
        _spoil(dice, points, normals)
    if dice.likely(10):
        points, normals = np.asfortranarray(points), np.asfortranarray(normals)
    return Case(
        points=points,
        normals=normals,
        scene=scene,
        material=material,
        matrix=matrix,
        albedo=_albedo(dice, len(points)),
        tolerance=dice.pick((0.0, 0.0, 0.0, 1 / 255, 0.05)),
        components=dice.likely(15),
    )


def _matrix(dice: Dice, scale: float) -> np.ndarray | None:
    kind = dice.pick(_MATRICES)
    if kind == "none":
        return None
    x = dice.direction()
    y = unit(np.cross(dice.direction(), x))
    linear = np.column_stack([x, y, np.cross(x, y)])
    if kind == "mirror":
        linear *= (1.0, dice.between(0.3, 3.0), -1.0)
    elif kind == "shear":
        linear[:, 1] += dice.between(-3.0, 3.0) * linear[:, 0]
    elif kind == "scaled":
        linear *= [dice.log_between(1e-3, 1e3), dice.between(0.3, 3.0), 1.0] if dice.likely(50) else 1e3
    elif kind == "flat":
        linear[:, 2] = 0.0
    matrix = np.eye(4)
    is_far = kind == "far" and scale == 1.0
    matrix[:3, :3], matrix[:3, 3] = linear, dice.vector() * (1e9 if is_far else 3.0 * scale)
    matrix[3, 3] = dice.pick((-2.0, 0.3)) if kind == "w" else 1.0
    return matrix


def _place(matrix: np.ndarray | None, points: np.ndarray, scale: float) -> Place:
    if matrix is None:
        return Place(np.zeros(3), scale, np.array(points[:1].sum(axis=0), np.float64))
    size = scale * float(np.abs(matrix[:3, :3] / matrix[3, 3]).max())
    vertex = ph.transform_points(points[:1], matrix).sum(axis=0)
    if not matrix[:3, 2].any():  # rounding would decide on which side of a flat mesh something in its plane is
        vertex += size
    return Place(matrix[:3, 3] / matrix[3, 3], size, vertex)


def _light_model(dice: Dice) -> ph.LightModel:
    two_sided, clamp, ambient = dice.likely(50), dice.likely(70), dice.color()
    if dice.likely(35):
        return replace(ph.LightModel.vtk(two_sided=two_sided), clamp=clamp, ambient=ambient)
    return ph.LightModel(
        ambient=ambient,
        local_viewer=dice.likely(65),
        two_sided=two_sided,
        reflection=dice.pick(("phong", "blinn-phong")),
        clamp=clamp,
    )


def _viewer(dice: Dice, place: Place) -> ph.Viewer:
    eye = place.vertex if dice.likely(12) else place.near(dice)
    ahead = unit((place.centre - eye) / place.size + 0.5 * dice.vector())
    ahead = np.array(_ALONG_Z) if dice.likely(20) else ahead
    return ph.Viewer(
        position=triple(eye),
        focal_point=triple(eye + max(place.size, float(np.abs(eye).max()) * 1e-9) * ahead),
        up=triple(dice.direction()),
        parallel=dice.likely(20),
    )


def _lights(dice: Dice, place: Place, viewer: ph.Viewer, model: ph.LightModel) -> list[ph.Light]:
    """Of VTK's convention each tier: a headlight alone, directional lights, any lights."""
    tier = dice.pick((1, 2, 3, 3)) if model.convention == "vtk" else 3
    if tier == 1:
        return [ph.DirectionalLight(**_light_colors(dice) | {"frame": "headlight", "on": True})]
    kinds = (ph.DirectionalLight,) if tier == 2 else (ph.DirectionalLight, *2 * [ph.PointLight], *2 * [ph.SpotLight])
    return [
        _light(dice, place, viewer, dice.pick(kinds))
        for _ in range(dice.pick((0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 5)))
    ]


def _light_colors(dice: Dice) -> dict[str, Any]:
    return {
        "diffuse": dice.pick((0.0, *4 * [1.0], *8 * [dice.color()])),
        "specular": None if dice.likely(50) else dice.color(),
        "ambient": 0.0 if dice.likely(50) else dice.color(),
        "intensity": dice.pick((*11 * [1.0], *5 * [dice.between(0.0, 2.0)], 0.0, 1e30)),
        "on": dice.likely(92),
        "frame": dice.pick(("world", "world", "camera", "headlight")),
    }


def _light(dice: Dice, place: Place, viewer: ph.Viewer, kind: type[ph.Light]) -> ph.Light:
    common = _light_colors(dice)
    in_camera = common["frame"] == "camera"
    position = place.size * 2.0 * dice.vector() if in_camera else place.near(dice)
    if not in_camera and dice.likely(12):
        position, common["ambient"] = place.vertex, 0.5  # on a vertex only ambient light is left
    elif not in_camera and dice.likely(12):  # so far that it may count as directional, or at the origin
        position = dice.pick((place.centre + 1e6 * (position - place.centre), np.zeros(3)))
    towards = np.array(_ALONG_Z) if in_camera else unit(place.centre - position)
    towards = np.where(np.isfinite(towards), towards, 1.0) + 0.4 * dice.vector()
    if in_camera and viewer.view_direction == _ALONG_Z:  # against the view, exactly: there is no half-way direction
        towards = -np.array(_ALONG_Z)
    common["direction"] = triple(towards * dice.pick((1.0, 1e-3, 1e200)))
    if kind is ph.DirectionalLight:
        return kind(**common)
    common |= {"position": triple(position), "attenuation": _attenuation(dice, place.size)}
    if kind is ph.PointLight:
        del common["direction"]
        return kind(**common)
    cone_angle = 90.0 if dice.likely(30) else dice.between(5.0, 90.0)
    exponent = dice.pick((0.0, 0.0, dice.between(0.0, 1.0), dice.between(1.0, 128.0), dice.log_between(1.0, 1e4)))
    return kind(**common, cone_angle=cone_angle, exponent=exponent)


def _attenuation(dice: Dice, size: float) -> tuple[float, float, float]:
    constant, linear, quadratic = dice.pick(
        ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.5, 0.3, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    )
    if not 1e-20 < size < 1e20:  # where a vertex on the light is still another case without the constant
        return constant, min(linear / size, 1e300), 0.0 if constant or linear else 1.0
    return constant, linear * dice.between(0.1, 1.0) / size, quadratic * dice.between(0.1, 1.0) / size / size


def _material(dice: Dice) -> ph.Material:
    shininess = (0.0, dice.between(0.01, 1.0), *4 * [dice.log_between(1.0, 1000.0)], 1e6)
    return ph.Material(
        ambient=dice.color(),
        diffuse=0.0 if dice.likely(8) else dice.color(),
        specular=0.0 if dice.likely(15) else dice.color(),
        shininess=dice.pick(shininess),
        emission=0.0 if dice.likely(60) else dice.color(),
    )


def _normals(
    dice: Dice, points: np.ndarray, scene: ph.Scene, matrix: np.ndarray | None, material: ph.Material
) -> np.ndarray:
    """Any normals, but every other one within the first light's highlight."""
    normals = unit(dice.vectors(len(points)))
    if scene.lights:
        world = points.astype(np.float64) if matrix is None else ph.transform_points(points, matrix)
        light = scene.world_lights[0]
        is_far = isinstance(light, ph.DirectionalLight)
        to_light = -np.array(light.direction) if is_far else np.array(light.position) - world
        half_way = unit(to_light) + unit(np.array(scene.viewer.position) - world)
        width = 1.0 / math.sqrt(1.0 + material.shininess)
        normals[1::2] = (half_way + 2.0 * width * dice.vectors(len(points)))[1::2]
        if matrix is not None:  # a matrix takes normals by its inverse-transpose: these are taken to what is aimed at
            x, y, z = math.copysign(1.0, matrix[3, 3]) * matrix[:3, :3]
            normals[1::2] = (normals[:, :1] * x + normals[:, 1:2] * y + normals[:, 2:] * z)[1::2]
    normals[::3] *= dice.pick((1.0, -1.0))
    return normals * (1.0 if dice.likely(60) else 10.0 ** (3.0 * dice.vectors(len(points))[:, :1]))


def _spoil(dice: Dice, points: np.ndarray, normals: np.ndarray) -> None:
    """Zero, subnormal, huge and non-finite rows, any number of each; the first vertex may have a light on it."""
    if not len(points):
        return
    subnormal, largest = np.finfo(points.dtype).tiny / 1000, np.finfo(points.dtype).max / 2
    for rows, first in ((points, 1), (normals, 0)):
        for value in (0.0, subnormal, 1e30, largest, np.nan, np.inf):
            for _ in range(dice.below(3)):
                row = rows[min(first + dice.below(len(rows)), len(rows) - 1)]
                is_whole = math.isfinite(value) or dice.likely(30)
                chosen = slice(None) if is_whole else dice.below(3)
                row[chosen] = dice.direction()[chosen] * value


def _albedo(dice: Dice, count: int) -> np.ndarray | None:
    kind = dice.pick((None, None, None, np.uint8, np.float32, np.float64))
    if kind is None:
        return None
    if kind is np.uint8:
        return (127.5 * (dice.vectors(count) + 1.0)).astype(np.uint8)
    albedo = (0.55 * (dice.vectors(count) + 1.0)).astype(kind)
    albedo[:1, 0] = dice.pick((0.5, -1.0, 1.0, np.nan))
    return np.minimum(albedo, 1.0)


# --- what is computed of them ---


@dataclass(frozen=True)
class Outcome:
    """What one scene gives: for each backend and precision the bits and the sums, and its plans."""

    bits: list[str]
    sums: list[tuple[float, float]]
    slacks: list[float]
    """How far sums may differ between machines."""
    plan: str


def backends() -> tuple[str, ...]:
    """Those that this installation has."""
    try:
        ph.evaluate(np.zeros((1, 3)), np.ones((1, 3)), ph.Scene(), ph.Material(), backend="numba")
    except ValueError:
        return BACKENDS[:1]
    return BACKENDS


def compute(index: int) -> Outcome:
    """Evaluate and plan the scene of an index."""
    outcome, case = Outcome([], [], [], ""), draw(index)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ph.SingularMatrixWarning)  # of the flat matrices
        for backend, precision in itertools.product(backends(), PRECISIONS):
            shading = shade(case, backend, precision)
            outcome.bits.append(hashed(shading))
            outcome.sums.append(summed(shading))
            outcome.slacks.append(slack(case, shading))
        return replace(outcome, plan=" | ".join(map(described, _plans(case))))


def shade(case: Case, backend: Any, precision: Any) -> ph.Shading:
    return ph.evaluate(
        case.points,
        case.normals,
        case.scene,
        case.material,
        matrix=case.matrix,
        albedo=case.albedo,
        precision=precision,
        backend=backend,
        tolerance=case.tolerance,
        components=case.components,
    )


def hashed(shading: ph.Shading) -> str:
    """Of every array's name, type, shape and bytes."""
    digest = hashlib.blake2b(digest_size=6)
    for field in fields(shading):
        array = getattr(shading, field.name)
        if array is not None:
            digest.update(f"{field.name} {array.dtype.str} {array.shape} ".encode())
            digest.update(array.tobytes())
    return digest.hexdigest()


def summed(shading: ph.Shading) -> tuple[float, float]:
    """The sum of all channels, and one with weights in [−1, 1]; a colour that is not finite agrees with nothing."""
    colors = shading.rgb.astype(np.float64)
    return float(colors.sum()), float((colors * Dice(0).vectors(len(colors))).sum())


def slack(case: Case, shading: ph.Shading) -> float:
    """Twice the rounding error that `evaluate` documents, in every channel; colours larger than 1 err by more."""
    spots = [light.exponent for light in case.scene.lights if isinstance(light, ph.SpotLight)]
    steepest = max(case.material.shininess, *spots, 1.0) if spots else max(case.material.shininess, 1.0)
    bound = (4.0 * math.sqrt(steepest) + 16.0) * float(np.finfo(shading.rgb.dtype).eps) / 2.0
    size = max(float(np.abs(shading.rgb).max(initial=1.0)), *(light.intensity for light in case.scene.lights), 1.0)
    return 2.0 * bound * (1 + len(case.scene.lights)) * size * shading.rgb.size


def _plans(case: Case) -> list[ph.Plan]:
    """Of the bare points, and of a mesh, whose normals are known."""
    arguments: Any = (case.scene, case.material)
    options: Any = {"matrix": case.matrix, "tolerance": case.tolerance}
    plans = [ph.plan(case.points, *arguments, **options)]
    if len(case.points):
        mesh = pv.PolyData(np.ascontiguousarray(case.points))
        mesh.point_data.active_normals = np.ascontiguousarray(case.normals)
        plans.append(ph.plan(mesh, *arguments, **options))
    return plans


def described(plan: ph.Plan) -> str:
    """Each effect with a sign for on or off, what is read, whether the view counts, and the bound."""
    effects = " ".join(f"{'+' if decision.on else '-'}{name}" for name, decision in plan.effects.items())
    reads = " ".join(sorted(plan.needs)) or "nothing"
    return f"{effects}; {reads}; {'moves' if plan.view_dependent else 'stays'}; {plan.error_bound:.9g}"


# --- the record ---


def machine() -> str:
    """What bits depend on beside the package: processor, its instructions in use, versions of what computes."""
    config: Any = np.show_config(mode="dicts")
    instructions, blas = config["SIMD Extensions"], config["Build Dependencies"]["blas"]
    parts = [platform.machine(), *platform.libc_ver(), "NumPy", np.__version__]
    parts += [*instructions.get("baseline", ()), *instructions.get("found", ()), blas.get("name"), blas.get("version")]
    if backends() == BACKENDS:
        import numba
        from llvmlite import __version__ as llvmlite_version
        from llvmlite import binding

        name = numba.config.CPU_NAME or binding.get_host_cpu_name()
        features = numba.config.CPU_FEATURES
        features = binding.get_host_cpu_features().flatten() if features is None else features
        shortened = hashlib.blake2b(features.encode(), digest_size=6).hexdigest()
        parts += ["Numba", numba.__version__, "llvmlite", llvmlite_version, name, shortened]
    return " ".join(map(str, parts))


def moved(recorded: dict[str, Any], outcomes: list[Outcome], here: str) -> list[str]:
    """What differs from the record: by bits on a machine that it knows, else by sums; plans on all."""
    found, known = [], recorded["bits"].get(here)
    for index, outcome in enumerate(outcomes):
        key = str(index)
        if key not in recorded["plans"] or (known is not None and key not in known):
            found.append(f"scene {index}: not in the record")
            continue
        if outcome.plan != recorded["plans"][key]:
            found.append(f"scene {index}: the plan was {recorded['plans'][key]!r}, is {outcome.plan!r}")
        before = _pairs(recorded["sums"][key])
        same = (
            [agree(*pair) for pair in zip(before, outcome.sums, outcome.slacks, strict=False)]
            if known is None
            else [a == b for a, b in zip(known[key].split(), outcome.bits, strict=True)]
        )
        cases = itertools.product(BACKENDS, PRECISIONS)
        for (backend, precision), is_same, was, now in zip(cases, same, before, outcome.sums, strict=False):
            if not is_same:
                found.append(f"scene {index}, {backend}, {precision}: the sums were {was}, are {now}")
    return found


def _pairs(line: str) -> list[tuple[float, float]]:
    numbers = list(map(float, line.split()))
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def agree(before: tuple[float, float], now: tuple[float, float], within: float) -> bool:
    return all(abs(a - b) <= within for a, b in zip(before, now, strict=True))


def record(outcomes: list[Outcome], here: str) -> dict[str, Any]:
    """The record of one machine."""
    each = [(str(index), outcome) for index, outcome in enumerate(outcomes)]
    return {
        "bits": {here: {key: " ".join(outcome.bits) for key, outcome in each}},
        "sums": {key: " ".join(f"{a!r} {b!r}" for a, b in outcome.sums) for key, outcome in each},
        "plans": {key: outcome.plan for key, outcome in each},
    }


def load() -> dict[str, Any]:
    return json.loads(RECORD.read_text(encoding="utf-8"))


def main() -> int:
    """Record or compare. Where nothing has moved here, this machine's bits are put beside those of others."""
    parser = argparse.ArgumentParser(description="Whether any computed number has moved.")
    parser.add_argument("--record", action="store_true", help=f"write {RECORD.name} instead of comparing with it")
    is_recording = parser.parse_args().record
    outcomes, here = [compute(index) for index in range(SCENES)], machine()
    if is_recording:
        new, before = record(outcomes, here), load() if RECORD.exists() else None
        if before and not moved(before, outcomes, here):
            new = before | {"bits": before["bits"] | new["bits"]}
        RECORD.write_text(json.dumps(new, indent=0) + "\n", encoding="utf-8")
        return 0
    recorded = load()
    by = "bits" if here in recorded["bits"] else "sums (bits are not recorded for this machine)"
    found = moved(recorded, outcomes, here)
    print(*found, f"{len(outcomes)} scenes compared by {by}: {len(found)} differences in {ph.__file__}", sep="\n")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
