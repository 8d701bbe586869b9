"""Hypothesis strategies for lit vertices: ordinary scenes for tight bounds, hard ones for what must not break.

Ordinary scenes are built around one vertex, the anchor: the viewer is placed first, then lights near the mirror
direction, within the width of the highlight, so that specular terms are really met.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from pvphong.lights import DirectionalLight, PointLight, SpotLight
from pvphong.material import Material
from pvphong.scene import LightModel, Scene, Viewer

Draw = Callable[[st.SearchStrategy[Any]], Any]


@dataclass(frozen=True)
class Case:
    """The arguments of one evaluation."""

    points: np.ndarray
    normals: np.ndarray
    scene: Scene
    material: Material
    matrix: np.ndarray | None = None
    albedo: np.ndarray | None = None

    @property
    def arguments(self) -> tuple[np.ndarray, np.ndarray, Scene, Material]:
        return self.points, self.normals, self.scene, self.material

    @property
    def options(self) -> dict[str, np.ndarray | None]:
        return {"matrix": self.matrix, "albedo": self.albedo}

    def stored_in(self, dtype: type[np.floating[Any]]) -> Case:
        """The same case with points and normals rounded to a precision."""
        return replace(self, points=self.points.astype(dtype), normals=self.normals.astype(dtype))


# --- numbers and vectors of ordinary size ---

STEPS = 9973  # a prime, so that the fractions are not round


def between(low: float, high: float) -> st.SearchStrategy[float]:
    """An evenly spread float, both ends included; rarely a round one. Simplest: `low`."""
    return st.integers(0, STEPS).map(lambda k: low + (high - low) * k / STEPS)


def log_between(low: float, high: float) -> st.SearchStrategy[float]:
    return between(math.log10(low), math.log10(high)).map(lambda e: 10.0**e)


signed = st.integers(-STEPS, STEPS).map(lambda k: k / STEPS)  # simplest: 0
chance = st.integers(0, 99)


def likely(draw: Draw, percent: int) -> bool:
    return bool(draw(chance) < percent)


balls = st.tuples(signed, signed, signed).map(np.array)  # a cube, in fact: any vector up to about 1


def unit(a: np.ndarray) -> np.ndarray:
    return a / np.linalg.norm(a)


unit_vectors = balls.map(lambda a: unit(a) if np.linalg.norm(a) > 0.1 else unit(a + (0.0, 0.0, 1.0)))


def triple(a: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in a)
    return x, y, z


reflectances = st.one_of(between(0.0, 1.0), st.tuples(*[between(0.0, 1.0)] * 3))
light_colors = st.one_of(st.just((1.0, 1.0, 1.0)), reflectances)
shininesses = st.one_of(st.just(0.0), log_between(1e-2, 1.0), log_between(1.0, 1e6), log_between(1.0, 1e6))
spot_exponents = st.one_of(st.just(0.0), between(0.0, 1.0), between(1.0, 128.0), log_between(1.0, 1e4))
attenuations = st.one_of(
    st.just((1.0, 0.0, 0.0)),
    st.just((0.0, 0.0, 1.0)),
    st.tuples(*[between(0.0, 2.0)] * 3).filter(lambda a: sum(a) > 0.2),
)


# --- matrices ---


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew


rotations = st.builds(rotation, unit_vectors, between(-math.pi, math.pi))
MATRIX_CLASSES = ("none", "identity", "rigid", "uniform", "non-uniform", "shear", "mirror", "w")


@st.composite
def matrices(draw: Draw, kind: str) -> np.ndarray | None:
    """A 4x4 matrix of a class; condition numbers stay below about 100."""
    if kind == "none":
        return None
    matrix = np.eye(4)
    if kind == "identity":
        return matrix
    linear = draw(rotations)
    if kind == "uniform":
        linear = linear * draw(log_between(0.1, 10.0))
    elif kind in {"non-uniform", "mirror"}:
        scales = np.array([draw(log_between(0.3, 3.0)) for _ in range(3)])
        if kind == "mirror":
            scales[draw(st.integers(0, 2))] *= -1
        linear = linear @ np.diag(scales) @ draw(rotations)
    elif kind == "shear":
        shear = np.eye(3)
        shear[draw(st.sampled_from([(0, 1), (0, 2), (1, 2), (2, 0)]))] = draw(between(-3.0, 3.0))
        linear = linear @ shear
    matrix[:3, :3] = linear
    matrix[:3, 3] = draw(balls) * 3
    if kind == "w":
        matrix[3, 3] = draw(st.sampled_from([-2.0, -0.7, 0.3, 3.0]))
    return matrix


def to_world(matrix: np.ndarray | None, p: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roughly (this only aims): a point and a unit normal in the world."""
    if matrix is None:
        return p, unit(n)
    linear, w = matrix[:3, :3], matrix[3, 3]
    return (linear @ p + matrix[:3, 3]) / w, unit(w * np.linalg.inv(linear).T @ n)


# --- ordinary scenes ---


@dataclass(frozen=True)
class _Anchor:
    """The vertex around which a scene is built, in the world: place, normal, and unit vector to the viewer."""

    p: np.ndarray
    n: np.ndarray
    v: np.ndarray
    width: float  # of the highlight, in radians


@st.composite
def _viewers(draw: Draw, p: np.ndarray, v: np.ndarray, *, constant: bool, width: float) -> Viewer:
    """A viewer seen from p along v; `constant` if only its view axis counts."""
    eye = p + v * draw(between(0.5, 8.0))
    focal = p + draw(balls) * 0.3
    if constant:
        focal = eye - unit(v + draw(balls) * 0.3 * width) * draw(between(0.5, 5.0))
    looking = unit(focal - eye)
    up = np.cross(looking, unit(np.roll(looking, 1) + 0.37)) + 0.3 * looking
    up_size = float(np.linalg.norm(np.cross(up, looking)))
    assume(up_size > 0.05)
    return Viewer(
        position=triple(eye), focal_point=triple(focal), up=triple(up), parallel=constant and likely(draw, 50)
    )


def _to_eye_space(viewer: Viewer, vector: np.ndarray) -> np.ndarray:
    back = unit(np.subtract(viewer.position, viewer.focal_point))
    right = unit(np.cross(np.array(viewer.up), back))
    return np.array([right, np.cross(back, right), back]) @ vector


def _aim(draw: Draw, anchor: _Anchor) -> np.ndarray:
    """A unit vector to a light: mostly near the mirror direction, else anywhere."""
    if not likely(draw, 80):
        return np.asarray(draw(unit_vectors))
    mirrored = 2 * float(anchor.n @ anchor.v) * anchor.n - anchor.v
    return unit(mirrored + draw(balls) * anchor.width * draw(between(0.0, 1.5)))


@st.composite
def _lights(draw: Draw, anchor: _Anchor, viewer: Viewer, kinds: tuple[str, ...], frames: tuple[str, ...]) -> Any:
    kind, frame = draw(st.sampled_from(kinds)), draw(st.sampled_from(frames))
    to_light = _aim(draw, anchor)
    position = anchor.p + to_light * draw(between(0.5, 4.0))
    cone_angle = draw(st.one_of(st.just(90.0), between(2.0, 90.0)))
    tilt = math.tan(math.radians(min(cone_angle, 45.0))) * 0.5
    axis = unit(-to_light + draw(balls) * tilt * draw(between(0.0, 1.5)))
    if frame == "camera":
        position = _to_eye_space(viewer, position - np.array(viewer.position))
        axis, to_light = _to_eye_space(viewer, axis), _to_eye_space(viewer, to_light)
    common = {
        "diffuse": draw(light_colors),
        "specular": draw(st.one_of(st.none(), light_colors)),
        "ambient": draw(st.one_of(st.just((0.0, 0.0, 0.0)), reflectances)),
        "intensity": draw(st.one_of(st.just(1.0), between(0.0, 1.5))),
        "on": likely(draw, 92),
        "frame": frame,
    }
    length = draw(st.one_of(st.just(1.0), log_between(1e-2, 1e2)))
    if kind == "directional":
        return DirectionalLight(direction=triple(-to_light * length), **common)
    common |= {"position": triple(position), "attenuation": draw(attenuations)}
    if kind == "point":
        return PointLight(**common)
    return SpotLight(direction=triple(axis * length), cone_angle=cone_angle, exponent=draw(spot_exponents), **common)


@st.composite
def _materials(draw: Draw) -> Material:
    return Material(
        ambient=draw(reflectances),
        diffuse=draw(reflectances),
        specular=draw(st.one_of(between(0.3, 1.0), between(0.3, 1.0), reflectances)),
        shininess=draw(shininesses),
        emission=draw(st.one_of(st.just(0.0), reflectances)),
    )


@st.composite
def _light_models(draw: Draw, convention: str) -> LightModel:
    fields = {"two_sided": draw(st.booleans()), "clamp": draw(chance) < 70, "ambient": draw(reflectances)}
    if convention == "vtk":
        return replace(LightModel.vtk(two_sided=fields["two_sided"]), clamp=fields["clamp"], ambient=fields["ambient"])
    return LightModel(
        local_viewer=draw(chance) < 65, reflection=draw(st.sampled_from(["phong", "blinn-phong"])), **fields
    )


@st.composite
def _neighbours(draw: Draw, p: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The anchor first, then up to seven vertices near and far; normals unit or of any ordinary length."""
    count = draw(st.integers(1, 8))
    spread = np.array([0.0] + [draw(log_between(1e-4, 1.0)) for _ in range(count - 1)])[:, None]
    points = p + spread * np.array([draw(balls) for _ in range(count)])
    normals = n + spread * np.array([draw(balls) for _ in range(count)])
    lengths = np.linalg.norm(normals, axis=1)
    assume((lengths > 0.05).all())
    normals = normals / lengths[:, None]
    if likely(draw, 40):
        normals = normals * np.array([draw(log_between(1e-3, 1e3)) for _ in range(count)])[:, None]
    return points, normals


@st.composite
def moderate_cases(draw: Draw, convention: str = "standard") -> Case:
    """Coordinates and colours of ordinary size, every kind of light, viewer, matrix and material."""
    matrix = draw(matrices(draw(st.sampled_from(MATRIX_CLASSES))))
    material = draw(_materials())
    model = draw(_light_models(convention))
    p, n = draw(balls), draw(unit_vectors)
    points, normals = draw(_neighbours(p, n))
    p, n = to_world(matrix, p, n)
    shininess = min(material.shininess, 128.0) if convention == "vtk" else material.shininess
    width = 1.0 / math.sqrt(1.0 + shininess)
    head_on = likely(draw, 25)  # only then do headlights make highlights
    frames = ("world", "headlight", "camera") if head_on else ("world", "camera")
    v = unit(n + draw(balls) * (0.3 * width if head_on else 0.55))
    if model.two_sided and likely(draw, 30):
        v, n = -v, -n  # seen from behind: the evaluator turns the normal back to n
    constant = convention == "standard" and (not model.local_viewer or likely(draw, 15))
    constant = constant or (convention == "vtk" and likely(draw, 15))
    viewer = draw(_viewers(p, v, constant=constant, width=width))
    kinds = ("directional",) if likely(draw, 25) else ("directional", "point", "spot")
    anchor = _Anchor(p, n, v, width)
    count = draw(st.sampled_from([1, 2, 3, 4] if draw(chance) else [0]))
    lights = [draw(_lights(anchor, viewer, kinds, frames)) for _ in range(count)]
    albedo = None
    if likely(draw, 30):
        albedo = np.array([[draw(between(0.0, 1.1)) for _ in range(3)] for _ in points])
        if likely(draw, 20):
            albedo[0, draw(st.integers(0, 2))] = draw(st.sampled_from([np.nan, -1.0, 300.0]))
    return Case(points, normals, Scene(lights=lights, viewer=viewer, light_model=model), material, matrix, albedo)


# --- hard scenes ---


@st.composite
def wide_floats(draw: Draw, lowest: int = -1074, highest: int = 1023, *, signs: bool = True) -> float:
    """A float whose exponent is drawn evenly over a range."""
    size = math.ldexp(1.0 + draw(between(0.0, 1.0)) / 2, draw(st.integers(lowest, highest)))
    return -size if signs and draw(st.booleans()) else size


@st.composite
def wide_vectors(draw: Draw, lowest: int = -1074, highest: int = 1022) -> np.ndarray:
    """One exponent for all three components, or one each."""
    if draw(st.booleans()):
        scale = draw(st.integers(max(lowest, -1000), highest))
        return np.ldexp(draw(unit_vectors), scale)
    return np.array([draw(st.one_of(st.just(0.0), wide_floats(lowest, highest))) for _ in range(3)])


def nonzero(vectors: st.SearchStrategy[np.ndarray]) -> st.SearchStrategy[np.ndarray]:
    return vectors.filter(lambda a: bool(np.any(a)))


def nudged(draw: Draw, a: np.ndarray) -> np.ndarray:
    """Every component moved by at most two float64 steps."""
    return np.array([x + k * math.ulp(x) for x, k in zip(a, [draw(st.integers(-2, 2)) for _ in a], strict=True)])


@st.composite
def _hard_matrices(draw: Draw) -> np.ndarray | None:
    """Extreme scales, flattened and nearly flattened, strongly sheared; rank 1 and less are left to their own test."""
    kind = draw(st.sampled_from(["none", "none", "uniform", "diagonal", "thin", "flat", "shear"]))
    if kind == "none":
        return None
    turn, other = draw(rotations), draw(rotations)
    matrix = np.eye(4)
    if kind == "uniform":
        matrix[:3, :3] = turn * draw(wide_floats(-600, 600))
    elif kind == "diagonal":
        matrix[:3, :3] = np.diag([draw(wide_floats(-490, 490)) for _ in range(3)])
    elif kind == "thin":
        small = draw(log_between(1e-16, 1e-2))
        matrix[:3, :3] = turn @ np.diag([1.0, draw(st.sampled_from([1.0, math.sqrt(small), small])), small]) @ other
    elif kind == "flat":
        matrix[:3, :3] = np.diag(np.roll([2.0, 3.0, 0.0], draw(st.integers(0, 2))))
    else:
        shear = np.eye(3)
        shear[0, 1] = draw(log_between(1.0, 1e12))
        matrix[:3, :3] = turn @ shear @ other
    matrix[:3, 3] = draw(balls) * draw(st.sampled_from([0.0, 1.0, 1e9]))
    if likely(draw, 15):
        matrix[3, 3] = draw(st.sampled_from([-1.0, -2.0, 1e-3]))
    return matrix


@st.composite
def _hard_attenuations(draw: Draw) -> tuple[float, float, float]:
    c, linear, quadratic = (draw(st.one_of(st.just(0.0), wide_floats(-1000, 1000, signs=False))) for _ in range(3))
    assume(c or linear or quadratic)
    return c, linear, quadratic


@st.composite
def _hard_lights(draw: Draw, points: np.ndarray, normals: np.ndarray, reach: int) -> Any:
    """Lights on a vertex, in its tangent plane, far and near, with the vertex on the edge of the cone."""
    row = draw(st.integers(0, len(points) - 1))
    p, n = points[row], normals[row]
    where = draw(st.sampled_from(["on", "tangent", "wide", "ordinary"]))
    if where == "tangent" and np.isfinite(n).all() and n.any():
        to_light = np.cross(n / np.abs(n).max(), draw(unit_vectors))
        to_light = nudged(draw, to_light) if to_light.any() else np.array([1.0, 0.0, 0.0])
    else:
        to_light = np.asarray(draw(nonzero(wide_vectors(-reach, reach)) if where == "wide" else unit_vectors))
    position = np.nan_to_num(p, nan=0.0, posinf=1.0, neginf=-1.0)
    position = position if where == "on" else position + to_light
    assume(np.isfinite(position).all())
    common: dict[str, Any] = {
        "diffuse": draw(light_colors),
        "ambient": draw(reflectances),
        "intensity": draw(st.one_of(st.just(1.0), wide_floats(-1000, 900, signs=False))),
        "frame": draw(st.sampled_from(["world", "world", "world", "headlight", "camera"])),
    }
    kind = draw(st.sampled_from(["directional", "point", "spot"]))
    if kind == "directional":
        return DirectionalLight(direction=triple(-to_light), **common)
    common |= {"position": triple(position), "attenuation": draw(st.one_of(attenuations, _hard_attenuations()))}
    if kind == "point":
        return PointLight(**common)
    cone_angle = draw(st.one_of(st.sampled_from([90.0, 60.0, 45.0, 30.0]), log_between(1e-6, 90.0)))
    axis = unit(np.nan_to_num(-to_light / np.abs(to_light).max()))
    if draw(st.booleans()):  # the vertex on the edge of the cone
        side = np.cross(axis, draw(unit_vectors))
        assume(np.linalg.norm(side) > 1e-3)
        axis = nudged(draw, rotation(unit(side), math.radians(cone_angle)) @ axis)
    exponent = draw(st.one_of(spot_exponents, wide_floats(-1000, 1000, signs=False)))
    return SpotLight(direction=triple(axis), cone_angle=cone_angle, exponent=exponent, **common)


@st.composite
def _hard_viewers(draw: Draw, points: np.ndarray, reach: int) -> Viewer:
    row = np.nan_to_num(points[draw(st.integers(0, len(points) - 1))], nan=0.0, posinf=1.0, neginf=-1.0)
    eye = row if likely(draw, 30) else np.asarray(draw(st.one_of(balls, wide_vectors(-reach, reach)))) + row
    distance = max(1.0, float(np.abs(eye).max()))
    looking = draw(unit_vectors)
    focal = eye + looking * distance
    assume(np.isfinite(eye).all() and np.isfinite(focal).all())
    up = np.eye(3)[int(np.argmin(np.abs(looking)))]
    return Viewer(position=triple(eye), focal_point=triple(focal), up=triple(up), parallel=likely(draw, 20))


@st.composite
def _hard_rows(draw: Draw, vectors: st.SearchStrategy[np.ndarray], count: int, odd_percent: int) -> np.ndarray:
    """Rows of vectors, some zero, some with a NaN or infinity."""
    rows = np.array([draw(vectors) for _ in range(count)], dtype=np.float64)
    for row in rows:
        if likely(draw, odd_percent):
            row[:] = 0.0
        elif likely(draw, odd_percent):
            row[draw(st.integers(0, 2))] = draw(st.sampled_from([np.nan, np.inf, -np.inf]))
    return rows


@st.composite
def hard_cases(draw: Draw, convention: str = "standard", reach: int = 900, *, odd_percent: int = 10) -> Case:
    """Inputs of the catalogue of hard cases, mixed: what comes out must be finite, or a documented exception.

    Parameters
    ----------
    convention : {"standard", "vtk"}
    reach : int
        Coordinates have exponents from −reach to reach.
    odd_percent : int
        Percentage of rows that are zero, and as many again that hold a NaN or infinity.
    """
    count = draw(st.integers(1, 5))
    normals = draw(_hard_rows(st.one_of(unit_vectors, nonzero(wide_vectors())), count, odd_percent))
    points = draw(_hard_rows(st.one_of(balls, wide_vectors(-reach, reach)), count, odd_percent))
    shininess = draw(st.one_of(shininesses, wide_floats(-1000, 1000, signs=False)))
    material = replace(draw(_materials()), shininess=shininess)
    scene = Scene(
        lights=draw(st.lists(_hard_lights(points, normals, reach), min_size=1, max_size=3)),
        viewer=draw(_hard_viewers(points, reach)),
        light_model=draw(_light_models(convention)),
    )
    return Case(points, normals, scene, material, draw(_hard_matrices()))
