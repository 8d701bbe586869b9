"""Names of lights: no two of a scene may share one."""

from __future__ import annotations

import re
from collections.abc import Iterable

from pvphong.optics.light import Light


def free_name(wanted: str, taken: Iterable[str]) -> str:
    """The name itself where it is free, else with the lowest number from 2 that makes it so."""
    names = set(taken)
    stem = re.sub(r" \d+$", "", wanted)
    number, name = 1, wanted
    while name in names:
        number += 1
        name = f"{stem} {number}"
    return name


def called(light: Light) -> str:
    """What a light is called on the screen: its name, or its kind where it has none."""
    return light.name or type(light).__name__
