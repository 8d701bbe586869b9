"""Environment images: equirectangular, linear, row 0 at the top, stored in scene files.

Two angles give a direction: θ is the angle from the top, and φ the angle around the top. φ is 0 in the image's middle,
and grows to the right, as seen from inside. The texel of the direction is at the fraction θ/π of the rows and
1/2 + φ/2π of the columns. Texels are constant: there is no interpolation.
"""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import PurePath
from typing import Any, Self

import numpy as np

from pvphong.base import check, documents
from pvphong.base.color import linear_from_srgb
from pvphong.base.types import Float64Array, FloatArray
from pvphong.optics.area.harmonics import BANDS, projected
from pvphong.optics.maps import is_texture

_ALLOWED = "a colour, a pv.Texture, or an (h, w, 3) array of linear floats >= 0"
_IMAGE_FILES = ".hdr", ".exr", ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"
_TYPES = "float32", "float64"
_IN_8_BITS = "Convert 8-bit values to linear floats with (image / 255.0) ** 2.2."
_TEXTURE_IN_8_BITS = "Call texture.SetUseSRGBColorSpace(True) to mark 8-bit values as sRGB."


@dataclass(frozen=True)
class Panorama:
    """Texels of an environment image.

    Parameters
    ----------
    height, width : int
        Size of the image in texels.
    type : {"float32", "float64"}
        Type of the texels' numbers.
    texels : str
        Red, green, blue of each texel, row by row: little-endian, compressed with zlib, encoded in base64.

    Raises
    ------
    ValueError
        If the fields are inconsistent, or a number is negative or not finite.
    """

    height: int
    width: int
    type: str
    texels: str

    def __repr__(self) -> str:
        return f"<image of {self.height} x {self.width} texels, {self.type}>"

    @classmethod
    def of(cls, name: str, image: FloatArray) -> Self:
        """Make a panorama from an array of finite numbers >= 0, shape (h, w, 3).

        Other numbers raise ValueError; `name` is the argument's name in the message.
        """
        if not np.isfinite(image).all() or (image < 0.0).any():
            bad = image[~(np.isfinite(image) & (image >= 0.0))][0]
            remedy = "Repair it with np.nan_to_num(image, posinf=...).clip(0.0). Use a DirectionalLight for the sun."
            check.refuse(name, f"an image with {bad}", _ALLOWED, remedy)
        height, width, _ = image.shape
        data = np.ascontiguousarray(image, image.dtype.newbyteorder("<")).tobytes()
        return cls(height, width, image.dtype.name, base64.b64encode(zlib.compress(data, 1)).decode("ascii"))

    @cached_property
    def image(self) -> FloatArray:
        """Array of the texels, shape (h, w, 3), read-only."""
        data = zlib.decompress(base64.b64decode(self.texels, validate=True))
        return np.frombuffer(data, np.dtype(self.type).newbyteorder("<")).reshape(self.height, self.width, 3)

    @cached_property
    def largest(self) -> float:
        """Largest number of all channels and texels."""
        return float(self.image.max())

    @cached_property
    def total(self) -> Float64Array:
        """Light from all directions, shape (3,): the integral ∫ colour du / π over the unit directions u."""
        return np.asarray(self._mean(self.image.astype(np.float64)) * 4.0)

    @cached_property
    def energy(self) -> Float64Array:
        """Energy of each channel, shape (3,): the integral ∫ (colour / largest)² du over the unit directions u.

        `largest` is the image's largest number.
        """
        return np.asarray(self._mean((self.image / (self.largest or 1.0)).astype(np.float64) ** 2) * (4.0 * math.pi))

    def _mean(self, values: Float64Array) -> Float64Array:
        areas = row_areas(self.height, self.width)
        return np.asarray(np.tensordot(areas, values.mean(axis=1), 1) * (self.width / (4.0 * math.pi)))

    @cached_property
    def is_uniform(self) -> bool:
        """True if all texels have the same colour."""
        return bool((self.image == self.image[0, 0]).all())

    @cached_property
    def harmonics(self) -> Float64Array:
        """Coefficients of the image's spherical harmonics, divided by `largest`: shape (3, bands, bands, 2).

        The function `projected` describes the coefficients' order.
        """
        scaled = self.image.astype(np.float64) / (self.largest or 1.0)
        return projected(scaled[:1, :1] if self.is_uniform else scaled, 1 if self.is_uniform else BANDS)


def row_areas(height: int, width: int) -> Float64Array:
    """Return, for each row of an equirectangular image of this size, the solid angle of one texel, shape (height,)."""
    middles, half = _angles(height), 0.5 * math.pi / height
    return np.asarray(2.0 * np.sin(middles) * math.sin(half) * (2.0 * math.pi / width))


def directions(height: int, width: int) -> Float64Array:
    """Return unit vectors to the centres of the texels of an equirectangular image, shape (height, width, 3).

    The components of a vector are along three axes: to the image's middle, to the right, and up.
    """
    down, around = _angles(height)[:, None], 2.0 * (_angles(width) - 0.5 * math.pi)
    level, height_above = np.sin(down), np.cos(down)
    return np.stack(np.broadcast_arrays(level * np.cos(around), level * np.sin(around), height_above), axis=-1)


def _angles(count: int) -> Float64Array:
    """Return the midpoints of `count` equal parts of the interval from 0 to π."""
    return np.asarray((np.arange(count) + 0.5) * (math.pi / count))


def image_or_color(name: str, value: Any) -> Any:
    """Check the value of the field `name`, and return it as a colour or as a `Panorama`.

    A panorama is made from an array, a texture, or a mapping from a scene file. The 8-bit values of a texture that is
    marked as sRGB are decoded from sRGB. Without this mark, 8-bit values are refused.
    """
    if isinstance(value, Panorama):
        return value
    if isinstance(value, Mapping):
        return _from_file(name, value)
    if is_texture(value):
        texels = np.asarray(value.to_array())
        texels = texels[..., :3] if texels.ndim == 3 else texels
        if texels.dtype == np.uint8 and value.GetUseSRGBColorSpace():
            texels = linear_from_srgb(texels / 255.0)
        return Panorama.of(name, _linear(name, texels, _TEXTURE_IN_8_BITS))
    if isinstance(value, np.ndarray) and value.ndim > 1:
        return Panorama.of(name, _linear(name, value, _IN_8_BITS))
    if isinstance(value, list) and value and isinstance(value[0], (list, tuple, np.ndarray)):
        return Panorama.of(name, _linear(name, check.real_array(name, value, _ALLOWED), _IN_8_BITS))
    if isinstance(value, str | PurePath) and str(value).lower().endswith(_IMAGE_FILES):
        check.refuse(name, value, _ALLOWED, f"Read the file with EnvironmentLight(pv.read_texture({str(value)!r})).")
    return check.color(name, value)


def _linear(name: str, values: Any, remedy: str) -> FloatArray:
    """Check the shape and type of an image's texels, and return them as float32 or float64.

    Parameters
    ----------
    name : str
        Name of the argument in messages.
    values : array_like
        The texels, shape (h, w, 3).
    remedy : str
        Sentence that ends the message for integers.
    """
    values = check.real_array(name, values, _ALLOWED)
    if values.dtype.kind != "f":
        check.refuse(name, f"an array of {values.dtype}", _ALLOWED, remedy)
    if values.ndim != 3 or values.shape[2] != 3 or not values.size:
        more = values.ndim == 3 and values.shape[2] == 4
        remedy = "Remove the opacity with image[..., :3]." if more else ""
        check.refuse(name, f"an array of shape {values.shape}", _ALLOWED, remedy)
    return np.asarray(values.astype(np.float32 if values.dtype.itemsize <= 4 else np.float64, copy=False))


def _from_file(name: str, entries: Mapping[str, Any]) -> Panorama:
    """Make a panorama from `entries`, the mapping of a panorama's fields in a scene file.

    `name` is the argument's name in messages.
    """
    documents.check_keys(name, entries, {field.name for field in fields(Panorama)})
    missing = [field.name for field in fields(Panorama) if field.name not in entries]
    if missing:
        check.refuse(name, f"an image without {', '.join(missing)}", _ALLOWED)
    height, width = (int(check.number(f"{name}.{size}", entries[size], at_least=1)) for size in ("height", "width"))
    kept = Panorama(height, width, check.choice(f"{name}.type", entries["type"], _TYPES), entries["texels"])
    try:
        image = kept.image
    except (ValueError, TypeError, zlib.error, binascii.Error):
        check.refuse(f"{name}.texels", entries["texels"], f"{height} x {width} texels as stored in a scene file")
    return Panorama.of(name, image.astype(image.dtype.newbyteorder("=")))
