"""The page's words for fields, their values, and kinds of light, where they differ from those of the library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

LABELS: Mapping[str, str] = {
    "cmap": "colormap",
    "day": "day of the year",
    "clim": "range",
    "feature_angle": "sharp edges from",
    "frame": "fixed to",
    "intensity": "brightness",
    "refine": "largest error",
    "scalars": "colour by",
    "seconds": "time",
    "transparent": "transparent in pictures",
}
"""Labels of fields whose words on the page differ from their names. Other labels are names without underscores."""

_UNIT_OF_BRIGHTNESS = "× white"
"""Unit of the brightness of a light without a size: at 1, a white surface that faces the light is white."""

_VALUES: Mapping[str, Mapping[str, str]] = {
    "frame": {"world": "world", "camera": "camera", "headlight": "camera, at the eye"},
}
"""Name of a field with choices → value → the page's word for it."""

SETUPS: Mapping[str, str] = {"sun": "sun by date and place"}
"""Set-ups of lights → the page's names for them, if they are different."""

LIGHTS: Mapping[str, str] = {"rectangle": "softbox", "disk": "round softbox"}
"""Kinds of light in scene files → the page's names for them, if they are different."""


def label_of(name: str) -> str:
    """Return the page's label of the field `name`."""
    return LABELS.get(name, name.replace("_", " "))


def in_words(entries: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a form's entries with labels, units and choices in the page's words."""
    found = []
    for entry in entries:
        name = entry["name"]
        words = _VALUES.get(name, {})
        items = [{"value": value, "title": words.get(value, value)} for value in entry["choices"]]
        unit = _UNIT_OF_BRIGHTNESS if name == "intensity" and not entry["unit"] else entry["unit"]
        found.append(entry | {"label": label_of(name), "unit": unit, "items": items})
    return found
