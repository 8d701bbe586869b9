"""Display transform: from linear colours to the bytes that a screen shows.

Lit arrays stay linear. Windows, pages and pictures show them through a `Display`: exposure, then a tone curve, or an
overlay that replaces the colours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

import numpy as np

from pvphong.base import check, threads
from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.types import ByteArray, FloatArray

Tone = Literal["none", "filmic"]
Overlay = Literal["none", "clipping", "false color"]

_AT_ONCE = 2**14  # colours that a thread converts at once: few enough to stay in its caches

# Colours below this are shown as they are by the filmic curve.
_SHOULDER = 0.6

# Marks of clipping: a channel of 1 or more, and black.
_TOO_BRIGHT, _BLACK = (255, 0, 0), (0, 0, 255)

# The luminance of a matt grey surface that looks half as bright as white.
_MIDDLE_GREY = 0.18
_FALSE_COLORS = (
    (-math.inf, (60, 0, 90)),
    (-5.0, (20, 40, 190)),
    (-3.0, (0, 130, 170)),
    (-1.5, (70, 70, 70)),
    (-0.25, (40, 160, 40)),
    (0.25, (150, 150, 150)),
    (1.0, (240, 210, 60)),
    (2.0, (250, 130, 20)),
    (math.log2(1.0 / _MIDDLE_GREY), (255, 0, 0)),
)
"""Bands of luminance: for each band, its lower limit in stops from middle grey, and the colour that marks the band. The
last band is brighter than white."""


@dataclass(frozen=True)
class Display:
    """Transform of linear colours for a screen.

    Parameters
    ----------
    exposure : float, default 0
        Brightness of the picture in stops: colours are multiplied by 2 to this power. From -10 to 10.
    tone : {"none", "filmic"}
        Curve for bright colours. "none" clips them at 1. "filmic" keeps colours up to 0.6 and compresses brighter ones,
        so that they approach 1 and keep their differences.
    overlay : {"none", "clipping", "false color"}
        Marks in place of colours. "clipping" draws red where a channel is 1 or more after exposure, and blue where all
        channels are 0. "false color" draws bands of luminance, in stops from middle grey (0.18): violet, blue and teal
        for dark colours, green for middle grey, yellow and orange for bright ones, and red for those above white.

    Raises
    ------
    ValueError
        If a value is not allowed.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> ph.Display(exposure=1.0)(np.array([[0.25, 0.5, 0.75]]))
    array([[128, 255, 255]], dtype=uint8)
    """

    exposure: float = check.field(partial(check.number, at_least=-10.0, at_most=10.0), 0.0, unit="stops")
    tone: Tone = check.field(partial(check.choice, allowed=get_args(Tone)), "none")
    overlay: Overlay = check.field(partial(check.choice, allowed=get_args(Overlay)), "none")

    def __post_init__(self) -> None:
        check.fields(self)

    def __call__(self, rgb: FloatArray, out: ByteArray | None = None) -> ByteArray:
        """Return the bytes that a screen shows.

        Parameters
        ----------
        rgb : ndarray
            Shape (n, 3), linear colours, 1 is full intensity; it is not modified. A negative channel counts as 0, NaN
            is shown as black.
        out : ndarray, optional
            Shape (n, 3), uint8: array that gets the result.

        Returns
        -------
        ndarray
            Shape (n, 3), uint8.

        Raises
        ------
        ValueError
            If `rgb` does not hold floats, or an array has another shape or type.
        """
        given = check.array("rgb", rgb)
        if np.asarray(rgb).dtype.kind != "f":
            allowed = "an array of floats, where 1 is full intensity"
            check.refuse("rgb", f"an array of {np.asarray(rgb).dtype}", allowed, "Divide colours from 0 to 255 by 255.")
        result = np.empty(given.shape, np.uint8) if out is None else out
        if result.shape != given.shape or result.dtype != np.uint8:
            got = f"an array of {result.dtype} with shape {result.shape}"
            check.refuse("out", got, f"an array of uint8 with the shape of rgb, {given.shape}")

        def show(first: int, last: int) -> None:
            exposed = np.multiply(given[first:last], 2.0**self.exposure, dtype=np.float32)
            np.fmax(exposed, np.float32(0.0), out=exposed)  # NaN to 0 too
            if self.overlay == "false color":
                result[first:last] = _false_colors(exposed)
                return
            toned = _filmic(exposed) if self.tone == "filmic" else np.minimum(exposed, np.float32(1.0))
            toned *= np.float32(255.0)
            np.rint(toned, out=result[first:last], casting="unsafe")
            if self.overlay == "clipping":
                result[first:last][exposed.max(axis=1) >= 1.0] = _TOO_BRIGHT
                result[first:last][~exposed.any(axis=1)] = _BLACK

        threads.run(show, len(given), _AT_ONCE)
        return result


def _filmic(exposed: FloatArray) -> FloatArray:
    """Apply the filmic curve to colours after exposure.

    With s = `_SHOULDER` and x a channel of a colour, the curve is x up to s, and s + (1 − s) (1 − exp(−(x − s) / (1 −
    s))) above. Its slope is continuous at s.
    """
    rest = np.float32(1.0 - _SHOULDER)
    beyond = np.maximum(exposed - np.float32(_SHOULDER), np.float32(0.0))
    curve: FloatArray = np.minimum(exposed, np.float32(_SHOULDER)) - rest * np.expm1(-beyond / rest)
    return curve


def _false_colors(exposed: FloatArray) -> ByteArray:
    """Return the false colour of each linear colour, shape (n, 3), by its band of luminance after exposure."""
    limits, colors = zip(*_FALSE_COLORS, strict=True)
    with np.errstate(divide="ignore"):
        stops = np.log2(exposed @ XYZ_OF_RGB[1].astype(np.float32) / np.float32(_MIDDLE_GREY))
    return np.array(colors, np.uint8)[np.searchsorted(limits[1:], stops, side="right")]
