"""How gizmos behave."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Keys = Mapping[str, tuple[str, Callable[[], str | None]]]
"""Key → what the help says, and what is done; what that gives is shown in the window."""


@dataclass(frozen=True)
class Options:
    """See `plotter.phong.add_gizmos`."""

    in_screenshots: bool = False
    angle_step: float = 5.0
    length_step: float | None = None
    keys: Keys = field(default_factory=dict)
