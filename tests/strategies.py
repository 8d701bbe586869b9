"""Lit vertices for property tests: ordinary scenes for tight bounds, hard scenes for robustness.

Hypothesis runs the tests and draws the seed of a generator of scenes. Its own draws repeat so often that a quarter of
the examples had no light on. A case prints itself in full, so that a failure can be reduced by hand.

Ordinary scenes are built around one vertex, the anchor. The viewer is placed first, then lights near the mirror
direction, within the width of the highlight, so that specular terms are not negligible.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from pvphong import LightModel, Material, Scene, Viewer
from pvphong.optics.lights import LIGHT_TYPES, DirectionalLight, PointLight, SpotLight
from pvphong.optics.photometry import Photometry

Triple = tuple[float, float, float]
T = TypeVar("T")

KEPT = 1000
"""Up to this number, the throws are the same in every run."""


@dataclass(frozen=True)
class Case:
    """Arguments of one evaluation. The albedo, with a row for each vertex, is set on the material."""

    points: np.ndarray
    normals: np.ndarray
    scene: Scene
    material: Material
    matrix: np.ndarray | None = None
    albedo: np.ndarray | None = None

    @property
    def arguments(self) -> tuple[np.ndarray, np.ndarray, Scene, Material]:
        material = self.material if self.albedo is None else replace(self.material, albedo=self.albedo)
        return self.points, self.normals, self.scene, material

    @property
    def options(self) -> dict[str, np.ndarray | None]:
        return {"matrix": self.matrix}

    def stored_in(self, dtype: type[np.floating[Any]]) -> Case:
        """Return the case with points and normals rounded to a precision."""
        return replace(self, points=self.points.astype(dtype), normals=self.normals.astype(dtype))

    def __repr__(self) -> str:
        """Exact repr; it can be evaluated with `from numpy import array, nan, inf` and pvphong's names."""
        shown = {name: _literal(getattr(self, name)) for name in ("points", "normals", "matrix", "albedo")}
        return (
            f"Case(points={shown['points']}, normals={shown['normals']}, scene={self.scene!r}, "
            f"material={self.material!r}, matrix={shown['matrix']}, albedo={shown['albedo']})"
        )


def _literal(a: np.ndarray | None) -> str:
    return "None" if a is None else f"array({a.tolist()}, dtype='{a.dtype}')"


def unit(a: np.ndarray) -> np.ndarray:
    return a / np.linalg.norm(a)


def triple(a: np.ndarray) -> Triple:
    x, y, z = (float(c) for c in a)
    return x, y, z


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew


class Dice(random.Random):
    """Random numbers, vectors and colours."""

    def likely(self, percent: float) -> bool:
        return self.random() * 100 < percent

    def log_between(self, low: float, high: float) -> float:
        return float(10.0 ** self.uniform(math.log10(low), math.log10(high)))

    def vector(self) -> np.ndarray:
        """Return any vector with components up to 1."""
        return np.array([self.uniform(-1, 1) for _ in range(3)])

    def unit_vector(self) -> np.ndarray:
        while np.linalg.norm(found := self.vector()) < 0.1:
            pass
        return unit(found)

    def rotation(self) -> np.ndarray:
        return rotation(self.unit_vector(), self.uniform(-math.pi, math.pi))

    def color(self) -> float | Triple:
        if self.likely(40):
            return self.random()
        return self.random(), self.random(), self.random()

    def shininess(self) -> float:
        if self.likely(6):
            return 0.0
        return self.log_between(1e-2, 1.0) if self.likely(15) else self.log_between(1.0, 1e6)

    def spot_exponent(self) -> float:
        exponents = (0.0, self.random(), self.uniform(1.0, 128.0), self.uniform(1.0, 128.0), self.log_between(1.0, 1e4))
        return self.choice(exponents)

    def attenuation(self) -> Triple:
        """Return OpenGL's default attenuation, a constant, an inverse square, or a mixture > 0.2 at distance 1."""
        mixed = (self.uniform(0.2, 2.0), self.uniform(0.0, 2.0), self.uniform(0.0, 2.0))
        constant = (self.log_between(0.1, 10.0), 0.0, 0.0)
        return self.choice(((1.0, 0.0, 0.0), constant, (0.0, 0.0, 1.0), mixed, mixed))

    def wide(self, lowest: int = -1074, highest: int = 1023) -> float:
        """Return a positive float with an exponent uniform over a range."""
        return math.ldexp(self.uniform(1.0, 1.999), self.randint(lowest, highest))

    def wide_vector(self, lowest: int = -1074, highest: int = 1022) -> np.ndarray:
        """Return a nonzero vector, with one exponent for all components, or one for each and some components zero."""
        if self.likely(50):
            return np.ldexp(self.unit_vector(), self.randint(max(lowest, -1000), highest))
        parts = [self.choice((0.0, 1.0, -1.0)) * self.wide(lowest, highest) for _ in range(3)]
        return np.array(parts) if any(parts) else np.array([0.0, 0.0, self.wide(lowest, highest)])

    def nudged(self, a: np.ndarray) -> np.ndarray:
        """Return a vector with each component moved by at most two float64 steps."""
        return np.array([x + self.randint(-2, 2) * math.ulp(x) for x in a])


def hunt(throw: Callable[[Dice], T], check: Callable[[T], None], examples: int) -> None:
    """Check many random cases. A failure prints the seed; `throw(Dice(seed))` makes the case again.

    The first thousand seeds are fixed. Hypothesis derives its seeds from the sources, so each new constant would
    change the cases, and the counts over them. Further seeds are new in every run.
    """

    def run(seed: int) -> None:
        check(throw(Dice(seed)))

    run = given(st.integers(0, 2**64 - 1))(run)
    is_kept = examples <= KEPT
    for seed in range(examples) if is_kept else ():
        run = example(seed)(run)
    settings(
        max_examples=examples,
        phases=[Phase.explicit] if is_kept else list(Phase),
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )(run)()


# --- matrices ---

MATRIX_CLASSES = ("none", "identity", "shift", "zoom", "rigid", "uniform", "non-uniform", "shear", "mirror", "w")


def matrix_of(dice: Dice, kind: str) -> np.ndarray | None:
    """A 4x4 matrix of a class; condition numbers stay below about 100."""
    if kind == "none":
        return None
    matrix = np.eye(4)
    if kind == "identity":
        return matrix
    linear = np.eye(3) if kind in {"shift", "zoom"} else dice.rotation()
    if kind in {"zoom", "uniform"}:
        linear *= dice.log_between(0.1, 10.0)
    elif kind in {"non-uniform", "mirror"}:
        scales = np.array([dice.log_between(0.3, 3.0) for _ in range(3)])
        scales[dice.randint(0, 2)] *= -1 if kind == "mirror" else 1
        linear = linear @ np.diag(scales) @ dice.rotation()
    elif kind == "shear":
        shear = np.eye(3)
        shear[dice.choice([(0, 1), (0, 2), (1, 2), (2, 0)])] = dice.uniform(-3.0, 3.0)
        linear = linear @ shear
    matrix[:3, :3], matrix[:3, 3] = linear, dice.vector() * 3
    if kind == "w":
        matrix[3, 3] = dice.choice([-2.0, -0.7, 0.3, 3.0])
    return matrix


def to_world(matrix: np.ndarray | None, p: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a point and a unit normal in world space, roughly; they only aim the scene."""
    if matrix is None:
        return p, unit(n)
    linear, w = matrix[:3, :3], matrix[3, 3]
    return (linear @ p + matrix[:3, 3]) / w, unit(w * np.linalg.inv(linear).T @ n)


# --- ordinary scenes ---


@dataclass(frozen=True)
class _Anchor:
    """The vertex around which a scene is built, in world space: position, normal, and unit vector to the viewer."""

    p: np.ndarray
    n: np.ndarray
    v: np.ndarray
    width: float  # of the highlight, in radians


def _viewer(dice: Dice, p: np.ndarray, v: np.ndarray, *, constant: bool, width: float) -> Viewer:
    """Return a viewer in direction v from p; `constant` if only its view axis counts."""
    eye = p + v * dice.uniform(0.5, 8.0)
    focal = p + dice.vector() * 0.2
    if constant:
        focal = eye - unit(v + dice.vector() * 0.3 * width) * dice.uniform(0.5, 5.0)
    up = np.cross(focal - eye, dice.unit_vector()) + 0.3 * (focal - eye)  # not upright, but never along the view
    while np.linalg.norm(np.cross(up, focal - eye)) < 0.01:
        up = dice.unit_vector()
    parallel = constant and dice.likely(50)
    return Viewer(position=triple(eye), focal_point=triple(focal), up=triple(up), parallel=parallel)


def _to_eye_space(viewer: Viewer, vector: np.ndarray) -> np.ndarray:
    back = unit(np.subtract(viewer.position, viewer.focal_point))
    right = unit(np.cross(np.array(viewer.up), back))
    return np.array([right, np.cross(back, right), back]) @ vector


def _aim(dice: Dice, anchor: _Anchor) -> np.ndarray:
    """Return a unit vector to a light: mostly near the mirror direction, else any."""
    if dice.likely(15):
        return dice.unit_vector()
    mirrored = 2 * float(anchor.n @ anchor.v) * anchor.n - anchor.v
    return unit(mirrored + dice.vector() * anchor.width * dice.uniform(0.0, 1.5))


def _light_colors(dice: Dice) -> dict[str, Any]:
    return {
        "diffuse": 0.0 if dice.likely(8) else (1.0, 1.0, 1.0) if dice.likely(30) else dice.color(),
        "specular": None if dice.likely(50) else dice.color(),
        "ambient": 0.0 if dice.likely(50) else dice.color(),
        "intensity": 1.0 if dice.likely(50) else dice.uniform(0.0, 1.5),
        "on": dice.likely(92),
    }


def _light(dice: Dice, anchor: _Anchor, viewer: Viewer, kind: str, frame: str) -> Any:
    to_light = _aim(dice, anchor)
    position = anchor.p + to_light * dice.uniform(0.5, 4.0)
    cone_angle = 90.0 if dice.likely(15) else dice.uniform(2.0, 90.0)
    tilt = math.tan(math.radians(min(cone_angle, 45.0))) * dice.uniform(0.0, 0.9)
    axis = unit(-to_light + dice.vector() * tilt) * (-1.0 if dice.likely(8) else 1.0)  # a few shine the other way
    if frame == "camera":
        position = _to_eye_space(viewer, position - np.array(viewer.position))
        axis, to_light = _to_eye_space(viewer, axis), _to_eye_space(viewer, to_light)
    length = 1.0 if dice.likely(50) else dice.log_between(1e-2, 1e2)
    common = _light_colors(dice) | {"frame": frame}
    aim = -to_light if kind == "directional" else axis
    shape = LIGHT_SHAPES[kind](dice, triple(position), triple(aim * length), cone_angle)
    return LIGHT_TYPES[kind](**shape, **common)


def _corners(dice: Dice, position: np.ndarray, normal: np.ndarray) -> list[Triple]:
    """Return the corners of a star-shaped polygon around a place: three to seven, convex or not."""
    across = unit(np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))]))
    other, count, size = np.cross(normal, across), dice.randint(3, 7), dice.log_between(1e-2, 1.0)
    turns = (np.arange(count) + np.array([dice.uniform(0.1, 0.9) for _ in range(count)])) * 2 * math.pi / count
    far = [size * dice.uniform(0.4, 1.0) for _ in range(count)]
    return [
        triple(position + r * (math.cos(t) * across + math.sin(t) * other)) for t, r in zip(turns, far, strict=True)
    ]


def _image(dice: Dice) -> Any:
    """Return a colour, or an image of a few texels with one bright texel, mostly dimmer than the lights' colours."""
    if dice.likely(20):
        return dice.color()
    texels = np.array([[[dice.random() for _ in range(3)] for _ in range(6)] for _ in range(3)])
    texels[dice.randint(0, 2), dice.randint(0, 5)] *= dice.log_between(1.0, 10.0)
    return 0.3 * texels


def _photometry(dice: Dice) -> float | Photometry:
    """Return one intensity, or a few by direction, for a lamp that may shine into one hemisphere only."""
    if dice.likely(20):
        return dice.log_between(0.1, 10.0)
    vertical, horizontal = dice.choice(([0, 30, 90], [0, 60, 120, 180])), dice.choice(([0], [0, 45, 90], [0, 120, 360]))
    rows = [[dice.random() + 0.01 for _ in vertical] for _ in horizontal]
    return Photometry.of("C", np.array(vertical), np.array(horizontal), np.array([*rows[:-1], rows[0]]))


LIGHT_SHAPES: dict[str, Callable[[Dice, Triple, Triple, float], dict[str, Any]]] = {
    "directional": lambda _dice, _position, direction, _angle: {"direction": direction},
    "disk": lambda dice, position, direction, _angle: {
        "position": position,
        "direction": direction,
        "radius": dice.log_between(1e-2, 1.0),
        "two_sided": dice.likely(40),
    },
    "environment": lambda dice, _position, direction, angle: {
        "image": _image(dice),
        "up": direction,
        "rotation": angle,
    },
    "photometric": lambda dice, position, direction, _angle: {
        "photometry": _photometry(dice),
        "position": position,
        "direction": direction,
        "up": triple(dice.unit_vector()),
    },
    "point": lambda dice, position, _direction, _angle: {"position": position, "attenuation": dice.attenuation()},
    "polygon": lambda dice, position, direction, _angle: {
        "corners": _corners(dice, np.array(position), unit(np.array(direction))),
        "two_sided": dice.likely(40),
    },
    "rectangle": lambda dice, position, direction, _angle: {
        "position": position,
        "direction": direction,
        "up": triple(dice.unit_vector()),
        "width": dice.log_between(1e-2, 2.0),
        "height": dice.log_between(1e-2, 2.0),
        "two_sided": dice.likely(40),
    },
    "sphere": lambda dice, position, _direction, _angle: {"position": position, "radius": dice.log_between(1e-2, 1.0)},
    "spot": lambda dice, position, direction, angle: {
        "position": position,
        "attenuation": dice.attenuation(),
        "direction": direction,
        "cone_angle": angle,
        "exponent": dice.spot_exponent(),
    },
}
"""Kind of light → what makes its own fields of a place, a direction and an angle. A new kind needs an entry here."""

REFLECTANCE_SHAPES: dict[str, Callable[[Dice], dict[str, Any]]] = {
    "phong": lambda dice: {"shininess": dice.shininess()},
    "blinn-phong": lambda dice: {"shininess": dice.shininess()},
    "modified-phong": lambda dice: {"shininess": dice.shininess()},
    "metal": lambda dice: {"color": dice.choice(((1.0, 0.8, 0.3), 0.5)), "shininess": dice.shininess()},
    "oren-nayar": lambda dice: {"sigma": dice.uniform(0.0, 90.0)},
    "ward": lambda dice: {"alpha_x": _roughness(dice), "alpha_y": dice.log_between(1e-3, 1.0)},
    "retro": lambda dice: {"shininess": dice.shininess()},
    "ggx": lambda dice: {"roughness": _roughness(dice), "f0": dice.choice((0.04, (1.0, 0.8, 0.3)))},
    "pbr": lambda dice: {"metallic": dice.choice((0.0, 1.0, dice.random())), "roughness": _roughness(dice)},
}
"""Name of a reflectance → what makes its fields. A new one needs an entry here."""


def _roughness(dice: Dice) -> float:
    return dice.log_between(1e-6, 0.05) if dice.likely(25) else dice.uniform(0.05, 1.0)


def _material(dice: Dice) -> Material:
    specular = dice.color() if dice.likely(30) else dice.uniform(0.3, 1.0)
    return Material(
        ambient=dice.color(),
        diffuse=dice.color(),
        specular=0.0 if dice.likely(10) else specular,
        shininess=dice.shininess(),
        emission=0.0 if dice.likely(50) else dice.color(),
    )


def _light_model(dice: Dice, convention: str) -> LightModel:
    fields: dict[str, Any] = {"ambient": dice.color(), "clamp": dice.likely(70)}
    two_sided = dice.likely(50)
    if convention == "vtk":
        return replace(LightModel.vtk(two_sided=two_sided), **fields)
    reflection = dice.choice(("phong", "blinn-phong"))
    return LightModel(local_viewer=dice.likely(65), two_sided=two_sided, reflection=reflection, **fields)


def _neighbours(dice: Dice, p: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the anchor and up to seven vertices near and far; normals are unit or of any ordinary length."""
    count = dice.randint(1, 8)
    spread = np.array([0.0] + [dice.log_between(1e-4, 1.0) for _ in range(count - 1)])[:, None]
    points = p + spread * np.array([dice.vector() for _ in range(count)])
    normals = np.array([unit(n + s * 0.55 * dice.vector()) for s in spread])
    if dice.likely(40):
        normals *= np.array([dice.log_between(1e-3, 1e3) for _ in range(count)])[:, None]
    return points, normals


def _albedo(dice: Dice, count: int) -> np.ndarray | None:
    if dice.likely(70):
        return None
    albedo = np.array([[min(dice.uniform(0.0, 1.1), 1.0) for _ in range(3)] for _ in range(count)])
    if dice.likely(20):
        albedo[0, dice.randint(0, 2)] = dice.choice([np.nan, -1.0, 1.0])
    return albedo


def moderate_case(dice: Dice, convention: str) -> Case:
    """Generate ordinary coordinates and colours, with every kind of light, viewer, matrix and material."""
    matrix = matrix_of(dice, dice.choice(MATRIX_CLASSES))
    material, model = _material(dice), _light_model(dice, convention)
    p, n = dice.vector(), dice.unit_vector()
    points, normals = _neighbours(dice, p, n)
    p, n = to_world(matrix, p, n)
    shininess = min(material.shininess, 128.0) if convention == "vtk" else material.shininess
    width = 1.0 / math.sqrt(1.0 + shininess)
    head_on = dice.likely(25)  # only then do headlights make highlights
    v = unit(n + dice.vector() * (0.5 * width if head_on else 0.55))
    if model.two_sided and dice.likely(40):
        v, n = -v, -n  # seen from behind: the evaluator turns the normal back to n
    elif not model.two_sided and dice.likely(5):
        v = -v
    constant = not model.local_viewer or dice.likely(15)
    viewer = _viewer(dice, p, v, constant=constant, width=width)
    kinds = ("directional",) if dice.likely(25) else ("directional", "point", "spot", "spot")
    frames = ("world", "headlight", "camera") if head_on or dice.likely(10) else ("world", "camera")
    anchor = _Anchor(p, n, v, width)
    lights = [
        _light(dice, anchor, viewer, dice.choice(kinds), dice.choice(frames))
        for _ in range(0 if dice.likely(3) else dice.choice((1, 2, 2, 3, 3, 4)))
    ]
    scene = Scene(lights=lights, viewer=viewer, light_model=model)
    return Case(points, normals, scene, material, matrix, _albedo(dice, len(points)))


# --- hard scenes ---


def _hard_matrix(dice: Dice, reach: int) -> np.ndarray | None:
    """Generate extreme, flattening, nearly flattening and strongly sheared matrices; rank <= 1 has its own test."""
    kind = dice.choice(["none", "none", "none", "uniform", "diagonal", "thin", "flat", "shear"])
    if kind == "none":
        return None
    matrix = np.eye(4)
    if kind == "uniform":
        linear = dice.rotation() * dice.wide(-min(reach, 600), min(reach, 600))
    elif kind == "diagonal":
        most = min(reach, 490)
        linear = np.diag([dice.choice((1, -1)) * dice.wide(-most, most) for _ in range(3)])
    elif kind == "thin":
        small = dice.log_between(1e-16, 1e-2)
        linear = dice.rotation() @ np.diag([1.0, dice.choice([1.0, math.sqrt(small), small]), small]) @ dice.rotation()
    elif kind == "flat":
        linear = np.diag(np.roll([2.0, 3.0, 0.0], dice.randint(0, 2)))
    else:
        shear = np.eye(3)
        shear[0, 1] = dice.log_between(1.0, 1e12)
        linear = dice.rotation() @ shear @ dice.rotation()
    matrix[:3, :3], matrix[:3, 3] = linear, dice.vector() * dice.choice([0.0, 1.0, 1e9])
    matrix[3, 3] = dice.choice([-1.0, -2.0, 1e-3]) if dice.likely(15) else 1.0
    return matrix


def _hard_attenuation(dice: Dice, reach: int) -> Triple:
    c, linear, quadratic = (dice.choice((0.0, dice.wide(-reach, reach))) for _ in range(3))
    return (c, linear, quadratic) if c or linear or quadratic else (0.0, 0.0, 1.0)


def _finite(p: np.ndarray) -> np.ndarray:
    return np.nan_to_num(p, nan=0.0, posinf=1.0, neginf=-1.0)


def _hard_light(dice: Dice, points: np.ndarray, normals: np.ndarray, reach: int) -> Any:
    """Generate lights on a vertex, in its tangent plane, far or near, or with the vertex on the cone's edge."""
    row = dice.randrange(len(points))
    p, n = _finite(points[row]), normals[row]
    where = dice.choice(["on", "tangent", "wide", "ordinary"])
    to_light = dice.wide_vector(-reach, reach) if where == "wide" else dice.unit_vector()
    if where == "tangent" and np.isfinite(n).all() and n.any():
        tangent = np.cross(n / np.abs(n).max(), to_light)
        to_light = dice.nudged(tangent) if tangent.any() else to_light
    position = p if where == "on" else p + to_light
    common: dict[str, Any] = {
        "diffuse": dice.color(),
        "ambient": dice.color(),
        "intensity": dice.wide(-1000, 900) if dice.likely(20) else 1.0,
        "frame": dice.choice(["world", "world", "world", "headlight", "camera"]),
    }
    kind = dice.choice(["directional", "point", "spot"])
    if kind == "directional":
        return DirectionalLight(direction=triple(-to_light), **common)
    attenuation = dice.attenuation() if dice.likely(50) else _hard_attenuation(dice, reach)
    common |= {"position": triple(position), "attenuation": attenuation}
    if kind == "point":
        return PointLight(**common)
    cone_angle = dice.choice([90.0, 60.0, 45.0, 30.0, dice.log_between(1e-6, 90.0), dice.log_between(1.0, 90.0)])
    axis = unit(-to_light / np.abs(to_light).max())
    if dice.likely(50):  # the vertex on the edge of the cone
        side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        axis = dice.nudged(rotation(unit(side), math.radians(cone_angle)) @ axis)
    exponent = dice.spot_exponent() if dice.likely(70) else dice.wide(-1000, 1000)
    return SpotLight(direction=triple(axis), cone_angle=cone_angle, exponent=exponent, **common)


def _hard_viewer(dice: Dice, points: np.ndarray, reach: int) -> Viewer:
    """Generate an eye on a vertex, or anywhere."""
    row = _finite(dice.choice(list(points)))
    away = dice.wide_vector(-reach, reach) if dice.likely(50) else dice.vector()
    eye = row if dice.likely(30) else row + away
    looking = dice.unit_vector()
    focal = eye + looking * max(1.0, float(np.abs(eye).max()))
    up = np.eye(3)[int(np.argmin(np.abs(looking)))]
    return Viewer(position=triple(eye), focal_point=triple(focal), up=triple(up), parallel=dice.likely(20))


def _spoil(dice: Dice, rows: np.ndarray, percent: float) -> None:
    """Set some rows to zero, and put a NaN or an infinity into as many others."""
    for row in rows:
        if dice.likely(percent):
            row[:] = 0.0
        elif dice.likely(percent):
            row[dice.randint(0, 2)] = dice.choice([np.nan, np.inf, -np.inf])


def hard_case(dice: Dice, convention: str, reach: int = 900, odd_percent: float = 10.0) -> Case:
    """Mix inputs of the catalogue of hard cases. Results must be finite, or a documented exception.

    Coordinates, attenuations and matrices have exponents from −reach to reach; where that is 900, coordinates are
    subnormal too.
    `odd_percent` of the rows are zero, and about as many again hold a NaN or infinity.
    """
    count, lowest = dice.randint(1, 5), -reach if reach < 900 else -1074
    normals = np.array([dice.choice((dice.unit_vector(), dice.wide_vector())) for _ in range(count)])
    points = np.array([dice.choice((dice.vector(), dice.wide_vector(lowest, reach))) for _ in range(count)])
    _spoil(dice, normals, odd_percent)
    _spoil(dice, points, odd_percent)
    shininess = dice.shininess() if dice.likely(70) else dice.wide(-1000, 1000)
    scene = Scene(
        lights=[_hard_light(dice, points, normals, reach) for _ in range(dice.randint(1, 3))],
        viewer=_hard_viewer(dice, points, reach),
        light_model=_light_model(dice, convention),
    )
    return Case(points, normals, scene, replace(_material(dice), shininess=shininess), _hard_matrix(dice, reach))
