"""Radiance's programs, from the wheel pyradiance: judges of skies and irradiances that share no code with pvphong."""

from __future__ import annotations

import importlib.util
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

_SPEC = importlib.util.find_spec("pyradiance")
FOLDER = Path(_SPEC.origin or "").parent if _SPEC is not None else None

WATTS_TO_LUMENS = 179.0
"""Radiance's luminous efficacy, by which it divides candela."""

needs_radiance = pytest.mark.skipif(FOLDER is None, reason="pip install pyradiance")


def radiance(*words: Any, given: str | bytes = b"", folder: Path | None = None) -> bytes:
    """Run one of Radiance's programs and return its output."""
    assert FOLDER is not None
    program = FOLDER / "bin" / str(words[0])
    paths = os.environ | {"RAYPATH": f".:{FOLDER / 'lib'}", "PATH": f"{FOLDER / 'bin'}:{os.environ.get('PATH', '')}"}
    data = given.encode() if isinstance(given, str) else given
    command = [program, *map(str, words[1:])]
    return subprocess.run(command, input=data, env=paths, cwd=folder, capture_output=True, check=True).stdout


def perez(altitude: float, azimuth: float, direct: float, diffuse: float) -> np.ndarray[Any, Any]:
    """Return the numbers that gendaylit computes for a sky: scale, ground, a to e, and the direction to the sun.

    `azimuth` is clockwise from north. gendaylit takes the distance of the sun on the eve of the new year.
    """
    angles = altitude, azimuth - 180.0  # Radiance counts from the south, west positive
    text = radiance("gendaylit", "-ang", *angles, "-W", direct, diffuse, "-O", 1).decode()
    return np.array([float(word) for word in text.split()[-10:]])


def rows(text: bytes) -> np.ndarray[Any, Any]:
    """Return the lines of numbers of an output without header."""
    return np.array([[float(word) for word in line.split()] for line in text.decode().splitlines() if line.strip()])


def irradiance(folder: Path, scene: str, points, normals, *options: str) -> np.ndarray:
    """Return the irradiance at points of a scene in Radiance's format, red, green and blue, shape (n, 3)."""
    (folder / "scene.rad").write_text(scene)
    (folder / "scene.oct").write_bytes(radiance("oconv", "scene.rad", folder=folder))
    rays = np.hstack([points, normals]).astype(np.float64)
    given = "\n".join(" ".join(f"{x:.9g}" for x in row) for row in rays)
    found = radiance("rtrace", "-h", "-I", *options, "scene.oct", given=given, folder=folder)
    return np.array(found.split(), float).reshape(-1, 3)


def polygon(material: str, name: str, corners) -> str:
    """Return a polygon in Radiance's format; its front is where its corners run counter-clockwise."""
    numbers = np.asarray(corners, float)
    rows = "\n".join(" ".join(f"{x:.9g}" for x in row) for row in numbers)
    return f"{material} polygon {name}\n0\n0\n{numbers.size}\n{rows}\n\n"
