"""What is said of lights on the screen: which one keys act on, and what state it is in."""

from __future__ import annotations

from collections.abc import Sequence

from pvphong.base.types import rgb
from pvphong.optics.light import Light
from pvphong.scene.viewer import Viewer
from pvphong.studio.gizmos.colors import luminance
from pvphong.studio.rig import LightHandle

HINT = "h: keys"


def soloed(handles: Sequence[LightHandle], viewer: Viewer) -> LightHandle | None:
    """The light that is on while all others of several are off, if there is such a one."""
    shining = [handle for handle in handles if handle.light(viewer).on]
    return shining[0] if len(shining) == 1 < len(handles) else None


def described(light: Light, *, is_alone: bool) -> str:
    """Name and kind of a light, how bright it is, and its marks."""
    kind = type(light).__name__
    bright = light.intensity * luminance(rgb(light.diffuse))
    parts = [f"{light.name}: {kind}" if light.name else kind, f"intensity {light.intensity:.3g}"]
    parts.append(f"luminance {bright:.3g}")
    return ", ".join([*parts, *marks(light, is_alone=is_alone)])


def marks(light: Light, *, is_alone: bool) -> list[str]:
    """What stands beside its icon."""
    return ["solo"] if is_alone else [] if light.on else ["off"]
