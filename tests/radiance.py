"""Radiance's programs, of the wheel pyradiance, as judges of irradiance. A test is skipped where it is missing."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

WATTS_TO_LUMENS = 179.0
"""Radiance's luminous efficacy, by which it divides candela."""


def run(folder: Path | None, *command: Any, given: str | None = None) -> bytes:
    """Run a program of Radiance, in a folder if it has files, and return what it prints."""
    home = Path(
        pytest.importorskip("pyradiance", reason="Radiance is missing (pip install pyradiance)").__file__
    ).parent
    path = {"RAYPATH": f"{home / 'lib'}{os.pathsep}.", "PATH": f"{home / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    data = None if given is None else given.encode()
    words = list(map(str, command))
    return subprocess.run(words, cwd=folder, env=os.environ | path, input=data, capture_output=True, check=True).stdout


def irradiance(folder: Path, scene: str, points, normals, *options: str) -> np.ndarray:
    """Return the irradiance at points of a scene in Radiance's format, red, green and blue, shape (n, 3)."""
    (folder / "scene.rad").write_text(scene)
    (folder / "scene.oct").write_bytes(run(folder, "oconv", "scene.rad"))
    rays = np.hstack([points, normals]).astype(np.float64)
    given = "\n".join(" ".join(f"{x:.9g}" for x in row) for row in rays)
    return np.array(run(folder, "rtrace", "-h", "-I", *options, "scene.oct", given=given).split(), float).reshape(-1, 3)


def polygon(material: str, name: str, corners) -> str:
    """Return a polygon in Radiance's format; its front is where its corners run counter-clockwise."""
    numbers = np.asarray(corners, float)
    rows = "\n".join(" ".join(f"{x:.9g}" for x in row) for row in numbers)
    return f"{material} polygon {name}\n0\n0\n{numbers.size}\n{rows}\n\n"


def rows(printed: bytes) -> np.ndarray:
    """Return lines of numbers as an array."""
    return np.array([[float(word) for word in line.split()] for line in printed.decode().splitlines() if line.strip()])


def perez(altitude: float, azimuth: float, direct: float, diffuse: float) -> np.ndarray:
    """Return the numbers that gendaylit computes for a sky: scale, ground, a to e, and the direction to the sun.

    `azimuth` is clockwise from north. gendaylit takes the distance of the sun on the eve of the new year.
    """
    angles = altitude, azimuth - 180.0  # Radiance counts from the south, west positive
    text = run(None, "gendaylit", "-ang", *angles, "-W", direct, diffuse, "-O", 1).decode()
    return np.array([float(word) for word in text.split()[-10:]])
