"""How much a colour may change when everything it is computed from is rounded anew.

For two evaluations of a scene, with every coordinate rounded again, by at most u of itself, before the second. Then
the difference of two positions of sizes S₁ and S₂ at distance d turns, and changes its length, by at most
η = u·(1 + (S₁ + S₂)/d), d the distance; the normal turns by less. Per light of strength · colours of at most s, with m
the largest power of a cosine, and to first order:

- a highlight is never steeper than √m/√e, r turns by 2η + η and v by η: 2.5√m·η;
- n·l changes by 2η;
- a spot's factor is never steeper than √m/√e either, between axis and ray there are 2η, and it weakens up to
  three shares, ambient, diffuse and specular: 3.7√m·η;
- attenuation changes by 2η of itself and weakens as many: 6η;

together (6.2√m + 8)·η·s. Either evaluation's own rounding adds (4√m + 16)·(1 + number of lights)·s·step, which is what
`evaluate` promises. In Blinn-Phong reflection h turns by up to 2/|l + v| times as much as l and v do.

Left out: n·l, n·v of a two-sided model, or a cone's edge within 8·(step + η) of 0, where either answer is right.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from stability import naive
from strategies import Case

from pvphong import SpotLight
from pvphong.optics.lights import Light

_U = 2.0**-53


class _Geometry(NamedTuple):
    """Float64 cosines and sizes, one row per light: only their order of magnitude counts, except near 0."""

    n_dot_l: Any
    n_dot_v: Any
    to_edge: Any
    largest: Any
    opening: Any
    ill: Any


def _positional(light: Light) -> bool:
    return hasattr(light, "attenuation")


def _geometry(case: Case) -> _Geometry:
    scene, p, n = case.scene, case.points, naive.unit(case.normals)
    eye, ahead = (np.array(vector) for vector in (scene.viewer.position, scene.viewer.view_direction))
    local = scene.light_model.local_viewer and not scene.viewer.parallel
    v = naive.unit(eye - p) if local else np.broadcast_to(-ahead, p.shape)
    sizes, far = np.linalg.norm(p, axis=1), float(np.linalg.norm(eye))
    ill = (sizes + far) / np.linalg.norm(eye - p, axis=1) if local else np.zeros(len(p))
    ill = np.maximum(ill, (far + np.linalg.norm(scene.viewer.focal_point)) / scene.viewer.distance)
    rows: dict[str, list[Any]] = {"n_dot_l": [], "to_edge": [], "largest": [], "opening": []}
    for light, given in zip(scene.world_lights, scene.lights, strict=True):
        to_light = -np.broadcast_to(light.direction, p.shape) if not _positional(light) else light.position - p
        distance = np.linalg.norm(to_light, axis=1)
        strength = np.full(len(p), float(light.intensity))
        if _positional(light):
            constant, linear, quadratic = light.attenuation
            strength = strength / (constant + linear * distance + quadratic * distance**2)
            # A light that rides along is added to the eye, from products with axes that are rounded themselves.
            riding = 8.0 * (far + np.linalg.norm(light.position - eye)) if given.frame == "camera" else 0.0
            ill = np.maximum(ill, (sizes + np.linalg.norm(light.position) + riding) / distance)
        to_light = to_light / distance[:, None]
        edge = np.ones(len(p))
        if isinstance(light, SpotLight):
            axis = naive.unit(np.array(light.direction))
            edge = -(to_light @ axis) - math.cos(math.radians(light.cone_angle))
        rows["n_dot_l"].append((n * to_light).sum(axis=1))
        rows["to_edge"].append(edge)
        rows["largest"].append(strength * _product(case, light))
        rows["opening"].append(np.linalg.norm(to_light + v, axis=1))
    stacked = {name: np.array(values).reshape(-1, len(p)) for name, values in rows.items()}
    return _Geometry(n_dot_v=(n * v).sum(axis=1), ill=ill, **stacked)


def _product(case: Case, light: Light) -> float:
    """The largest of a light's colours times the material's."""
    material = case.material
    pairs = ((material.ambient, light.ambient), (material.diffuse, light.diffuse))
    return max(float(np.max(np.multiply(k, c))) for k, c in (*pairs, (material.specular, light.specular_color)))


def largest_power(case: Case) -> float:
    """m: of the shininess and the spots' exponents."""
    return max(
        [case.material.shininess, *(light.exponent for light in case.scene.lights if hasattr(light, "exponent"))]
    )


class Change:
    """Between two evaluations of a scene, the second with every number rounded again, or the same once more."""

    def __init__(self, case: Case, moved: Case) -> None:
        here = _geometry(case)
        there = here if moved is case else _geometry(moved)
        self._here = here
        self._eta = _U * (1.0 + np.maximum(here.ill, there.ill))
        self._lights = len(case.scene.lights)
        self._root = math.sqrt(largest_power(case))
        self._is_two_sided = case.scene.light_model.two_sided
        self._scale = here.largest.max(axis=0, initial=1.0)
        if case.scene.light_model.reflection == "blinn-phong":
            with np.errstate(divide="ignore"):
                self._scale = self._scale * (2.0 / here.opening).max(axis=0, initial=1.0)

    def bound(self, step: float) -> Any:
        """The bound of every vertex, shape (n,)."""
        own = 2.0 * (4.0 * self._root + 16.0) * (1 + self._lights) * step
        return self._scale * (own + (6.2 * self._root + 8.0) * self._lights * self._eta)

    def decidable(self, step: float) -> Any:
        """Which vertices lie in no band where either answer is right, shape (n,)."""
        band = 8.0 * (step + self._eta)
        near = (np.abs(self._here.n_dot_l) <= band).any(axis=0) | (np.abs(self._here.to_edge) <= band).any(axis=0)
        if self._is_two_sided:
            near |= np.abs(self._here.n_dot_v) <= band
        return ~near
