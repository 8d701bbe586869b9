"""How much a colour may change when everything it is computed from is rounded anew.

For two evaluations of a scene, the second after a motion that rounds every coordinate again. Let η be the largest
angle by which the directions to light, viewer or along the normal change by that rounding: a difference of positions
of sizes S at distance d is off by 4u·S/d, and a rotation in floats is orthogonal to 8u, so η = u·(8 + 4·S/d).
Per light of strength and colour at most s, with m the largest power of a cosine:

- diffuse: n·l changes by at most 2η; attenuation, as a product of powers of d up to the second, by 2η of itself;
- highlight: cosᵐ is never steeper than √m/√e, and r turns by 2η + η, v by η: at most 2.5√m·η. Blinn-Phong's h turns
  by 2η/|l + v|;
- spot: its cosine's power changes by at most √m·η·2/√e.

Together no more than (4√m + 16)·η·s, and the same with the step of the precision for each evaluation's own rounding:

    (4√m + 16) · (1 + number of lights) · s · (2·step + η) · max(1, 2/|l + v| for Blinn-Phong)

Left out: n·l, n·v of a two-sided model, or a cone's edge within 8·(2·step + η) of 0, where either answer is right.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from stability import naive
from strategies import Case

from pvphong import SpotLight
from pvphong.lights import Light

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
    sizes = np.linalg.norm(p, axis=1)
    ill = (sizes + np.linalg.norm(eye)) / np.linalg.norm(eye - p, axis=1) if local else np.ones(len(p))
    focal = np.linalg.norm(scene.viewer.focal_point)
    ill = np.maximum(ill, (np.linalg.norm(eye) + focal) / scene.viewer.distance)
    rows: dict[str, list[Any]] = {"n_dot_l": [], "to_edge": [], "largest": [], "opening": []}
    for light in scene.world_lights:
        to_light = -np.broadcast_to(light.direction, p.shape) if not _positional(light) else light.position - p
        distance = np.linalg.norm(to_light, axis=1)
        strength = np.full(len(p), float(light.intensity))
        if _positional(light):
            constant, linear, quadratic = light.attenuation
            strength = strength / (constant + linear * distance + quadratic * distance**2)
            # A light that rides along is placed relative to the eye.
            size = sizes + np.linalg.norm(light.position) + np.linalg.norm(eye)
            ill = np.maximum(ill, size / distance)
        l = to_light / distance[:, None]
        edge = np.ones(len(p))
        if isinstance(light, SpotLight):
            axis = naive.unit(np.array(light.direction))
            edge = -(l @ axis) - math.cos(math.radians(light.cone_angle))
        rows["n_dot_l"].append((n * l).sum(axis=1))
        rows["to_edge"].append(edge)
        rows["largest"].append(strength * _product(case, light))
        rows["opening"].append(np.linalg.norm(l + v, axis=1))
    stacked = {name: np.array(values).reshape(-1, len(p)) for name, values in rows.items()}
    return _Geometry(n_dot_v=(n * v).sum(axis=1), ill=ill, **stacked)


def _product(case: Case, light: Light) -> float:
    """The largest of a light's colours times the material's."""
    material = case.material
    pairs = ((material.ambient, light.ambient), (material.diffuse, light.diffuse))
    return max(float(np.max(np.multiply(k, c))) for k, c in (*pairs, (material.specular, light.specular_color)))


def _eta(here: _Geometry, there: _Geometry) -> Any:
    return _U * (8.0 + 4.0 * np.maximum(here.ill, there.ill))


def change_bound(case: Case, moved: Case, step: float) -> Any:
    """The bound of every vertex, shape (n,)."""
    here, there = _geometry(case), _geometry(moved)
    powers = [case.material.shininess, *(s.exponent for s in case.scene.lights if isinstance(s, SpotLight))]
    largest = here.largest.max(axis=0, initial=1.0)
    if case.scene.light_model.reflection == "blinn-phong":
        with np.errstate(divide="ignore"):
            largest = largest * (2.0 / here.opening).max(axis=0, initial=1.0)
    eta = 2.0 * step + _eta(here, there)
    return (4.0 * math.sqrt(max(powers)) + 16.0) * (1 + len(case.scene.lights)) * largest * eta


def decidable(case: Case, moved: Case, step: float) -> Any:
    """Which vertices lie in no band where either answer is right, shape (n,)."""
    here, there = _geometry(case), _geometry(moved)
    band = 8.0 * (2.0 * step + _eta(here, there))
    near = (np.abs(here.n_dot_l) <= band).any(axis=0) | (np.abs(here.to_edge) <= band).any(axis=0)
    if case.scene.light_model.two_sided:
        near |= np.abs(here.n_dot_v) <= band
    return ~near
