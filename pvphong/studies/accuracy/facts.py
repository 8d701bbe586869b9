"""What a report on accuracy and time was made on: mesh, scene, machine, versions."""

from __future__ import annotations

import os
import platform
import sys
from collections import Counter
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
import pyvista as pv

from pvphong.base import threads
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene


def facts(mesh: pv.PolyData, scene: Scene, material: Material) -> dict[str, str]:
    """What it is → how it is, for people."""
    return {
        "mesh": f"{mesh.n_points} points, {mesh.n_cells} faces, {mesh.points.dtype}",
        "scene": _lights(scene) + f"; {scene.light_model}",
        "material": f"{material}",
        "machine": f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}",
        "threads": _threads(),
        "versions": f"Python {platform.python_version()}, " + ", ".join(filter(None, map(_version, _PACKAGES))),
        "date": date.today().isoformat(),
    }


_PACKAGES = ("numpy", "numba", "pyvista", "vtk", "pvphong")


def _version(package: str) -> str:
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return ""


def _lights(scene: Scene) -> str:
    kinds = Counter(type(light).__name__ for light in scene.lights if light.on)
    return ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "no light"


def _processor() -> str:
    """The processor's name; Linux tells it in a file."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"


def _threads() -> str:
    return f"1 in NumPy {np.__version__}" + (f", {threads.count()} in the kernel" if "numba" in sys.modules else "")
