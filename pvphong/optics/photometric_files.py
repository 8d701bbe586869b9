"""Reading of lamps as measured: IES files (LM-63) and EULUMDAT files.

Sources: ANSI/IESNA LM-63-2002, and its predecessors of 1986, 1991 and 1995; A. Stockmar, "EULUMDAT – ein
Leuchtendatenformat für den europäischen Beleuchtungsplaner" (1990). LM-63 of 1986 and 1991 has a ballast-lamp factor
that later versions reserve; Radiance's `ies2rad` reads it in the same way.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import NoReturn

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.optics.photometry import Kind, Photometry

_ALLOWED = "an IES (LM-63) or EULUMDAT file"
_KINDS: dict[float, Kind] = {1.0: "C", 2.0: "B", 3.0: "A"}
_TILT = re.compile(r"TILT\s*=\s*(.*)", re.IGNORECASE)
# Header of the versions in which the ballast-lamp factor is reserved for future use.
_RESERVED = re.compile(r"IES(NA)?:\s*LM-63-(1995|2002|2019)", re.IGNORECASE)
# Largest number of bytes that is read, and of angles.
_LARGEST, _MOST_ANGLES = 2**24, 2000


def read_photometry(path: str | os.PathLike[str], *, is_alone: bool = False) -> Photometry:
    """Read a lamp's intensities from an IES or EULUMDAT file.

    Parameters
    ----------
    path : path
        The file.
    is_alone : bool, default False
        Open no other file: refuse an IES file whose tilt is in another one, as for a file from an untrusted source.

    Raises
    ------
    ValueError
        If the file cannot be read, is cut short, or contradicts itself; the message names the file and the line or
        number.
    """
    place = Path(path)
    try:
        with place.open("rb") as file:
            content = file.read(_LARGEST + 1)
    except OSError as error:
        check.refuse("photometry", place.name, f"{_ALLOWED} that can be read", f"{type(error).__name__}: {error}.")
    text = content.removeprefix(b"\xef\xbb\xbf").decode("latin-1").split("\x1a")[0]  # an end mark of DOS
    lines = text.splitlines()
    if len(content) > _LARGEST or "\0" in text:
        check.refuse("photometry", place.name, _ALLOWED)
    start = next((k for k, line in enumerate(lines) if _TILT.match(line.strip())), None)
    try:
        if start is not None:
            return _ies(lines, start, None if is_alone else place.parent)
        if place.suffix.lower() == ".ies":
            raise ValueError("there is no line TILT=…; the file may be cut short")
        return _eulumdat(lines)
    except ValueError as error:
        check.refuse("photometry", place.name, _ALLOWED, f"{str(error).rstrip('.')}.")


# --- LM-63


class _Words:
    """Numbers of a file, one after the other."""

    def __init__(self, lines: list[str]) -> None:
        self._words = [word for line in lines for word in line.replace(",", " ").split()]
        self._next = 0

    def take(self, count: int, what: str) -> Float64Array:
        """Return the next `count` numbers. `what` names them in messages."""
        words = self._words[self._next : self._next + count]
        if len(words) < count:
            raise ValueError(f"the file is cut short: it ends after {len(words)} of {count} numbers of the {what}")
        self._next += count
        try:
            found = np.array([float(word) for word in words])
        except ValueError:
            _not_numbers(words, what)
        if not np.isfinite(found).all():
            _not_numbers(words, what)
        return found

    def count(self, what: str, most: int = _MOST_ANGLES) -> int:
        """Return the next number, which must be a whole number from 1 to `most`. `what` names it in messages."""
        return _counted(float(self.take(1, what)[0]), what, most)

    def refuse_more(self) -> None:
        """Raise ``ValueError`` if there are more numbers."""
        if left := self._words[self._next :]:
            raise ValueError(f"there are {len(left)} words after the last candela value, the first is {left[0]!r}")


def _not_numbers(words: list[str], what: str) -> NoReturn:
    for word in words:
        try:
            is_sound = np.isfinite(float(word))
        except ValueError:
            is_sound = False
        if not is_sound:
            raise ValueError(f"{word[:40]!r} among the {what} is not a number") from None
    raise AssertionError  # pragma: no cover only called if a word is not a number


def _counted(number: float, what: str, most: int) -> int:
    if not 1.0 <= number <= most or number != int(number):
        raise ValueError(f"the {what} must be a whole number from 1 to {most}; got {number:g}")
    return int(number)


def _ies(lines: list[str], start: int, folder: Path | None) -> Photometry:
    """Return the photometry of an IES file.

    `lines` are the file's lines, and `start` is the index of the line that begins with TILT=. `folder` is the folder of
    the file; if the line names a second file with tilt factors, this file is read from `folder`. If `folder` is None,
    such a line is refused.
    """
    found = _TILT.match(lines[start].strip())
    assert found is not None
    kind_of_tilt, words, tilt = found.group(1).strip(), _Words(lines[start + 1 :]), None
    if kind_of_tilt.upper() == "INCLUDE":
        tilt = _tilt(words)
    elif kind_of_tilt.upper() != "NONE" and folder is None:
        raise ValueError("its tilt is in another file, which is not opened; write it into this file as TILT=INCLUDE")
    elif kind_of_tilt.upper() != "NONE" and folder is not None:
        tilt = _tilt(_Words(_lines_of_tilt(folder / kind_of_tilt)))
    words.take(2, "number of lamps and lumens")
    factor = float(words.take(1, "multiplier")[0])
    n_vertical, n_horizontal = words.count("number of vertical angles"), words.count("number of horizontal angles")
    code, _unit = words.take(2, "photometric type and unit").tolist()
    if code not in _KINDS:
        raise ValueError(f"the photometric type must be 1, 2 or 3; got {code:g}")
    words.take(3, "luminous dimensions")
    ballast, with_lamp, _watts = words.take(3, "ballast factors and watts").tolist()
    factor *= ballast
    if not _RESERVED.match(lines[0].strip() if start else ""):
        factor *= with_lamp
    if not factor > 0.0:
        raise ValueError(f"the product of multiplier and ballast factors must be positive; got {factor:g}")
    vertical, horizontal = words.take(n_vertical, "vertical angles"), words.take(n_horizontal, "horizontal angles")
    rows = words.take(n_vertical * n_horizontal, "candela values").reshape(n_horizontal, n_vertical) * factor
    words.refuse_more()
    if code == 1.0:
        horizontal, rows = _closed(horizontal, rows)
    return Photometry.of(_KINDS[code], vertical, horizontal, rows, tilt)


def _closed(horizontal: Float64Array, rows: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Complete a circle of horizontal angles: if the last one is one step before 360 degrees, append 360 degrees.

    `rows` has the intensities, one row for each angle; the first row is repeated at 360 degrees. Angles that are not in
    equal steps from 0 degrees are returned unchanged.
    """
    step = 360.0 / len(horizontal)
    if len(horizontal) > 2 and np.allclose(horizontal, step * np.arange(len(horizontal)), atol=1e-3):
        return np.append(horizontal, 360.0), np.vstack([rows, rows[:1]])
    return horizontal, rows


def _tilt(words: _Words) -> tuple[int, Float64Array, Float64Array]:
    axis = words.count("lamp-to-luminaire geometry of the tilt", 3)
    count = words.count("number of tilt angles")
    return axis, words.take(count, "tilt angles"), words.take(count, "tilt factors")


def _lines_of_tilt(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="latin-1").splitlines()
    except OSError as error:
        raise ValueError(f"the tilt file {path.name} next to it cannot be read ({type(error).__name__})") from error


# --- EULUMDAT

# Symmetry → first and last C-plane that the file has, as fractions of the circle.
_PLANES = {0: (0.0, 1.0), 1: (0.0, 0.0), 2: (0.0, 0.5), 3: (0.75, 1.25), 4: (0.0, 0.25)}


def _eulumdat(lines: list[str]) -> Photometry:
    """Return the photometry of a EULUMDAT file with these lines: the intensities for the first set of lamps."""
    rows = [line.strip().replace(",", ".") for line in lines]
    while rows and not rows[-1]:
        rows.pop()

    def number(line: int, what: str) -> float:
        if line >= len(rows):
            raise ValueError(f"the file is cut short: line {line + 1}, the {what}, is missing")
        try:
            found = float(rows[line])
        except ValueError:
            raise ValueError(f"line {line + 1}, the {what}, must be a number; got {rows[line][:40]!r}") from None
        if not np.isfinite(found):
            raise ValueError(f"line {line + 1}, the {what}, must be finite; got {found}")
        return found

    symmetry = number(2, "symmetry")
    if symmetry not in _PLANES:
        raise ValueError(f"line 3, the symmetry, must be 0, 1, 2, 3 or 4; got {symmetry:g}")
    planes = _counted(number(3, "number of C-planes"), "number of C-planes", _MOST_ANGLES)
    gammas = _counted(number(5, "number of angles in a C-plane"), "number of angles in a C-plane", _MOST_ANGLES)
    conversion = number(23, "conversion factor")
    sets = _counted(number(25, "number of sets of lamps"), "number of sets of lamps", 20)
    flux = number(28, "luminous flux")
    scale = conversion * flux / 1000.0
    if not scale > 0.0:
        raise ValueError(f"flux times conversion factor must be positive; got {flux:g} times {conversion:g}")
    at = 26 + 6 * sets + 10  # after the sets and the direct ratios
    around = np.array([number(at + k, f"C-plane {k + 1}") for k in range(planes)])
    at += planes
    vertical = np.array([number(at + k, f"angle {k + 1} in a C-plane") for k in range(gammas)])
    at += gammas
    first, last = _PLANES[int(symmetry)]
    is_divided = all((share * planes).is_integer() for share in (first, last))
    if symmetry and (not is_divided or not np.allclose(around, 360.0 / planes * np.arange(planes), atol=0.01)):
        raise ValueError(f"{planes} C-planes at these angles do not fit the symmetry {symmetry:g}")
    stored = 1 if symmetry == 1 else planes if symmetry == 0 else round((last - first) * planes) + 1
    values = [number(at + k, f"intensity {k + 1} of {stored * gammas}") for k in range(stored * gammas)]
    if len(rows) > at + len(values):
        raise ValueError(f"there are {len(rows) - at - len(values)} lines after the last intensity")
    candela = np.reshape(values, (stored, gammas)) * scale
    horizontal = 360.0 / planes * np.arange(stored)
    if symmetry == 0:
        horizontal, candela = np.append(around, 360.0), np.vstack([candela, candela[:1]])
    if symmetry == 3:
        horizontal, candela = 360.0 / planes * np.arange(planes + 1), _mirrored(candela, planes)
    return Photometry.of("C", vertical, horizontal, candela)


def _mirrored(candela: Float64Array, planes: int) -> Float64Array:
    """Mirror the intensities of half a circle to a full circle of C-planes.

    `candela` has a row for each plane from C270 through C0 to C90, and `planes` is the number of planes in the full
    circle. The result has a row for each plane from C0 to C360.
    """
    quarter = planes // 4
    right = candela[quarter:]  # from C0 to C90
    left = candela[: quarter + 1]  # from C270 to C360
    return np.vstack([right, right[-2::-1], left[-2::-1], left[1:]])
