"""Writers of small IES and EULUMDAT files, for tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def ies(
    path: Path,
    vertical,
    horizontal,
    candela,
    *,
    kind=1,
    lamps=1,
    lumens=1000,
    multiplier=1,
    ballast=1,
    with_lamp=1,
    tilt="TILT=NONE",
    head="IESNA:LM-63-2002\n[TEST] 1\n[MANUFAC] none",
) -> Path:
    """Write an IES file; `candela` has a row for each horizontal angle."""
    rows = [vertical, horizontal, *candela]
    lines = [head, tilt] if head else ["a lamp", tilt]
    lines += [f"{lamps} {lumens} {multiplier} {len(vertical)} {len(horizontal)} {kind} 2 0.01 0.01 0"]
    lines += [f"{ballast} {with_lamp} 50", *(" ".join(f"{float(x):.10g}" for x in row) for row in rows)]
    path.write_text("\r\n".join("\n".join(lines).split("\n")) + "\r\n", newline="")
    return path


def eulumdat(path: Path, symmetry, around, gammas, values, *, fluxes=(1000.0,), conversion=1.0, lamps=1) -> Path:
    """Write a EULUMDAT file; `values`, in cd per 1000 lm, has a row for each C-plane that the symmetry leaves."""
    lines = ["a company", "1", symmetry, len(around), 0, len(gammas), 0, "report", "a lamp", "1", "a.ldt", "today"]
    lines += [100, 0, 50, 80, 0, 0, 0, 0, 0, 100, 80, conversion, 0, len(fluxes)]
    for flux in fluxes:
        lines += [lamps, "LED", flux, "3000", "80", 10]
    lines += [0.5] * 10
    lines += [*around, *gammas, *np.ravel(values)]
    path.write_text("\r\n".join(f"{x:.10g}" if isinstance(x, float) else str(x) for x in lines) + "\r\n", newline="")
    return path
