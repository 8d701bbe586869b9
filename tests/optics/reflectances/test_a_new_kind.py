"""A custom reflectance works by its formula alone, without an entry in any table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base.formulas import ZERO, formula, maximum
from pvphong.optics.reflectance import LAMBERT, Geometry, Lobe, Reflectance
from pvphong.shading import kernel

BACKENDS = ["numpy", "numba"] if kernel.is_available() else ["numpy"]
SUN = ph.DirectionalLight((-1.0, -1.0, -1.0), specular=0.5)


@formula
def _velvet(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001
    n_l, n_v = maximum(at.n_l, ZERO), maximum(at.n_v, ZERO)
    return n_l, n_l * own[0] * (1 - n_v) * (1 - n_v)


@dataclass(frozen=True)
class Velvet(Reflectance):
    """Velvet, bright at its rim: max(n·l, 0), and k (1 − n·v)² max(n·l, 0)."""

    lobes = (LAMBERT, Lobe("specular", takes_albedo=False, needs_viewer=True))
    factors = staticmethod(_velvet)

    def parameters(self, maps: Any) -> tuple[float, ...]:  # noqa: ARG002
        return (3.0,)


@pytest.mark.parametrize("tolerance", [0.0, 0.01])
@pytest.mark.parametrize("backend", BACKENDS)
def test_it_is_lit_and_never_left_out(backend, tolerance):
    mesh, material = pv.Sphere(), ph.Material(ambient=0.0, diffuse=0.2, specular=1e-3, reflectance=Velvet())
    scene = ph.Scene([SUN], viewer=ph.Viewer(position=(3.0, 1.0, 2.0)))
    n, p = np.array(mesh.point_data["Normals"], float), np.array(mesh.points, float)
    v = np.array(scene.viewer.position) - p
    n_l = np.maximum(-n @ np.array(SUN.direction) / np.sqrt(3.0), 0.0)
    n_v = np.maximum((n * v).sum(axis=1) / np.linalg.norm(v, axis=1), 0.0)
    expected = 0.2 * n_l + 0.5e-3 * 3.0 * n_l * (1.0 - n_v) ** 2
    how = {"precision": "float64", "backend": backend, "tolerance": tolerance}
    lit = mesh.phong.shade(scene, material, **how)["phong"]
    assert np.abs(lit - expected[:, None]).max() < 1e-6
    assert mesh.phong.plan(scene, material, tolerance=tolerance).effects["specular"].on
