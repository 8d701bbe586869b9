"""Environment light from all directions: a sky, a studio, or an image."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, Vector, VectorLike, rgb
from pvphong.base.vectors import unit_vector
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.area.harmonics import energies, moments, moments_left, sky, sky_numbers
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import (
    Sampling,
    image_numbers,
    image_sample,
    image_seen,
    sky_frame,
    sky_sampling,
)
from pvphong.optics.light import Integral, Light
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.panorama import Panorama, directions, image_or_color, row_areas
from pvphong.optics.roles import Role, Turn, Up, meaning
from pvphong.optics.sky import SOLAR_CONSTANT, SkyModel, ground_radiance, radiances

# Sine of the least angle between `up` and the x axis at which the middle of the image is along the x axis.
_LEAST = 1e-9
# Relative size below which harmonics are dropped.
_NOTHING = 1e-15
# Least number of rows of directions from which nodes are chosen.
_ROWS = 48
# Number of nodes divided by a lobe's sharpness; least number of nodes (with 256, the error of matt GGX under a white
# sky is 0.5 %; with 64, 2.9 %); largest number of nodes (with 1024, the error of GGX with roughness 0.4 is 1 %).
_NODES_IN_LOBES, _LEAST_NODES, _MOST_NODES = 4.0, 256, 1024
# Largest number of rows for importance sampling; larger images are averaged to it.
_MOST_ROWS = 256
# Number of rows of a sky's image: texels of 2°.
_SKY_ROWS = 90
_RED_GREEN_BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class EnvironmentLight(Light):
    """Environment light, infinitely far away in all directions: an image, or one colour.

    The image's colours are radiance, in units where a white patch under a uniform image of 1 gets the colour 1.
    `diffuse` and `intensity` multiply the radiance, and `ambient` arrives everywhere with the strength 1.

    Diffuse reflection and Phong's highlight use the image's first 32 bands of spherical harmonics. The plan's row "sky"
    bounds the error of omitting the other bands, and gives the number of bands that a tolerance needs. A highlight is
    the image blurred by the lobe, looked up in the mirror direction, times the fraction of the lobe above the horizon.
    This is exact for one colour; where the horizon cuts the lobe off, the error is at most
    (brightest − darkest) / (2 (shininess + 1)).

    For other reflectances, 256 parallel lights of equal energy approximate the image, and up to 1024 for sharp lobes.
    The error is about 1 % for `GGX` down to a roughness of 0.4, 5 % at 0.3, and 23 % at 0.2, where the lights become
    visible as spots.

    Phong's lobe is not normalised: under a uniform sky its highlight is 2/(shininess + 1), dark for a mirror.
    `ModifiedPhong` and `GGX` are normalised.

    Parameters
    ----------
    image : color, array_like or pyvista.Texture, default 1
        One colour; or an equirectangular image of linear floats >= 0, shape (h, w, 3). Row 0 is around `up`, the middle
        column is along the x axis (the z axis if `up` is along x), and columns run to the right as seen from inside. An
        8-bit texture must be marked as sRGB (`texture.SetUseSRGBColorSpace(True)`). Scene files store the texels.
    up : sequence of float, default (0, 1, 0)
        Direction to the top of the image; of any length. VTK's environments have the same default.
    rotation : float, default 0
        Rotation around `up` in degrees, counter-clockwise as seen from the top.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`. With the frame
        "headlight", `up` is in eye space.

    Raises
    ------
    ValueError
        If a field is out of range, or an image has a wrong shape, a NaN, an infinity, a negative number or 8-bit
        numbers; the message names the field.

    Examples
    --------
    >>> import numpy as np
    >>> import pyvista as pv, pvphong as ph
    >>> sky = np.linspace((0.3, 0.5, 1.0), (0.2, 0.2, 0.2), 16)[:, None] * np.ones((1, 32, 1))
    >>> lit = pv.Sphere().phong.shade(ph.EnvironmentLight(sky, up=(0, 0, 1)))
    """

    image: Any = meaning(Role(image_or_color), 1.0)
    up: VectorLike = meaning(Up(check.direction), (0.0, 1.0, 0.0))
    rotation: float = meaning(Turn(check.number, "rotation"), 0.0)

    is_uniform: ClassVar[bool] = True
    is_all_around: ClassVar[bool] = True

    @classmethod
    def sky(
        cls,
        sun: VectorLike = (0.0, 0.0, 1.0),
        *,
        diffuse_horizontal: float,
        direct_normal: float = 0.0,
        model: SkyModel = "perez",
        albedo: float = 0.2,
        up: VectorLike = (0.0, 0.0, 1.0),
        extraterrestrial: float = SOLAR_CONSTANT,
        **fields: Any,
    ) -> Self:
        """Make a sky by its irradiance, above open ground that reflects it; the sun itself is a light of its own.

        The image is the radiance in W/m²/sr, and the intensity is π: an open surface under a sky of the irradiance E
        gets the colour E, as from a directional light of intensity E.

        Parameters
        ----------
        sun : sequence of float, default (0, 0, 1)
            Direction to the sun, of any length. A sun below the horizon counts as on it.
        diffuse_horizontal : float
            Irradiance by the sky on an open surface that faces up, in W/m². The image gives exactly this irradiance.
        direct_normal : float, default 0
            Irradiance by the sun on a surface that faces it, in W/m²: for the kind of sky, and for the ground.
        model : {"perez", "overcast", "clear"}, default "perez"
            "perez": all-weather sky, from overcast to clear by the ratio of the irradiances; "overcast" and "clear":
            the skies of the CIE (S 011/E:2003 type 16, and CIE 22).
        albedo : float, default 0.2
            Fraction of the light that the ground reflects, from 0 to 1.
        up : sequence of float, default (0, 0, 1)
            Direction to the zenith.
        extraterrestrial : float, default 1367
            Irradiance of the sun above the atmosphere in W/m², for Perez' model. It varies by 3.4 % in a year.
        **fields
            The other fields of the light. `intensity` is multiplied by π.

        Raises
        ------
        ValueError
            If an argument is out of range.

        References
        ----------
        R. Perez, R. Seals, J. Michalsky, "All-weather model for sky luminance distribution", Solar Energy 50 (1993),
        235-245.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> sky = ph.EnvironmentLight.sky((1, 0, 1), direct_normal=600, diffuse_horizontal=120)
        >>> model = ph.LightModel(ambient=0, clamp=False)
        >>> lit = pv.Plane().phong.shade(ph.Scene([sky], light_model=model), ph.Material(diffuse=1))
        >>> round(float(lit["phong"][0, 0]))  # W/m²
        120
        """
        direct, diffuse = check.number("direct_normal", direct_normal, at_least=0.0), diffuse_horizontal
        diffuse = check.number("diffuse_horizontal", diffuse, at_least=0.0)
        above = check.number("extraterrestrial", extraterrestrial, above=0.0)
        albedo = check.number("albedo", albedo, at_least=0.0, at_most=1.0)
        intensity = math.pi * check.number("intensity", fields.pop("intensity", 1.0), at_least=0.0)
        frame = cls(up=check.direction("up", up)).axes
        local = frame @ unit_vector(check.direction("sun", sun))
        to_sky = directions(_SKY_ROWS, 2 * _SKY_ROWS)[: _SKY_ROWS // 2]
        level = to_sky[..., 2] * row_areas(_SKY_ROWS, 2 * _SKY_ROWS)[: _SKY_ROWS // 2, None]
        given = local[None], np.array([direct]), np.array([diffuse]), above
        found = radiances(model, to_sky.reshape(-1, 3), level.ravel(), *given).reshape(level.shape)
        ground = ground_radiance(albedo, float(local[2]), direct, diffuse)
        image = np.concatenate([found, np.full_like(found, ground)])
        return cls(np.repeat(image[..., None], 3, axis=2), up=up, intensity=intensity, **fields)

    @cached_property
    def panorama(self) -> Panorama:
        """The image as a `Panorama`. If `image` is one colour, the panorama has a single texel."""
        image = self.image
        return image if isinstance(image, Panorama) else Panorama.of("image", np.full((1, 1, 3), rgb(image)))

    @cached_property
    def axes(self) -> Float64Array:
        """Unit vectors as rows: to the middle of the image, to its right, and up."""
        up, middle = np.array(unit_vector(self.up)), np.array(_middle(self.up))
        right, angle = np.cross(middle, up), math.radians(self.rotation)
        ahead = math.cos(angle) * middle - math.sin(angle) * right
        return np.stack([ahead, np.cross(ahead, up), up])

    def _with(self, change: Callable[[Role, Any], Any], **fields: Any) -> Self:
        """Return a copy in which `change` is applied to each field that has a role, and other `fields` are set.

        `change` is a function of a field's role and value that returns the new value. `rotation` is adapted, so that
        the direction to the image's middle is changed in the same way as `up`.
        """
        moved = super()._with(change, **fields)
        x, y, z = self.axes[0].tolist()
        ahead = change(self.roles["up"], (x, y, z))
        if ahead == (x, y, z):
            return moved
        ahead, middle = np.array(unit_vector(ahead)), np.array(_middle(moved.up))
        right = np.cross(middle, unit_vector(moved.up))
        return replace(moved, rotation=math.degrees(math.atan2(-ahead @ right, ahead @ middle)))

    # -- sampling

    def nodes(self, count: int) -> tuple[DirectionalLight, ...]:
        """Return at most `count` parallel lights of about equal energy. Together they have the energy of the image.

        Each light replaces a part of the image. The part with the most energy is halved until there are `count` parts
        (after P. Debevec, "A median cut algorithm for light probe sampling", 2005).
        """
        return _nodes(self.panorama, tuple(self.axes.ravel().tolist()), count)

    def nodes_for(self, sharpness: float) -> int:
        """Return the number of parallel lights that a reflectance of this sharpness needs.

        The number is a power of two, at most `_MOST_NODES`. It is large enough that several of the lights lie within a
        highlight.
        """
        several = 2 ** math.ceil(math.log2(max(_NODES_IN_LOBES * sharpness, 1.0)))
        return min(max(several, _LEAST_NODES), _MOST_NODES)

    @cached_property
    def sampling(self) -> Sampling:
        """Importance sampling of directions.

        An image is sampled by its energy and by the cosine to the normal, one colour by the cosine alone.
        """
        radiance = self.panorama.image.mean(axis=2, dtype=np.float64)
        if self.panorama.is_uniform:
            return sky_sampling(math.inf, float(radiance[0, 0]))
        cells = _means(_means(radiance, _MOST_ROWS).T, 2 * _MOST_ROWS).T
        return Sampling(sky_frame, image_sample, image_seen, image_numbers(cells, self.axes))

    def radiance(self, directions: Float64Array) -> FloatArray:
        """Return the colours of the texels in the given directions, shape (3, n).

        `directions` are unit vectors, shape (3, n).
        """
        height, width, _ = self.panorama.image.shape
        ahead, right, up = self.axes @ directions
        row = np.arccos(np.clip(up, -1.0, 1.0)) * (height / math.pi)
        column = (np.arctan2(right, ahead) / (2.0 * math.pi) + 0.5) * width
        texels = np.minimum(row.astype(int), height - 1), np.minimum(column.astype(int), width - 1)
        return np.asarray(self.panorama.image[texels].T)

    # -- in bands

    @property
    def bands(self) -> int:
        """Number of bands of spherical harmonics by which the image is represented."""
        return self.panorama.harmonics.shape[1]

    def error_without_bands(self, form: CosinePower, bands: int) -> float:
        """Return a bound on the error of reflected light, at intensity 1, if only the first `bands` bands are used.

        `form` is the factor by which light is reflected, a power of a cosine. If `bands` is less than the number of
        bands of the image's expansion, the result is the sum of the bounds for the omitted bands. Else it is a bound
        that follows from the image's energy outside the expansion.
        """
        if bands < self.bands:
            kept, orders = self.panorama.harmonics, np.arange(self.bands)
            factors = 2.0 * np.abs(moments(form.power, self.bands)) * np.sqrt((2.0 * orders + 1.0) / (4.0 * math.pi))
            most = factors * np.sqrt(energies(kept))  # bound on each band of each channel
            return float(most[:, bands:].sum(axis=1).max()) * self.panorama.largest * ROUNDED_UP
        if self.bands == 1:
            return 0.0
        energy = np.maximum(self.panorama.energy - energies(self.panorama.harmonics).sum(axis=1), 0.0).max()
        return float(math.sqrt(energy / math.pi) * moments_left(form.power, self.bands) * self.panorama.largest)

    def tints(self, bands: int | None = None) -> tuple[tuple[Vector, Light], ...]:
        """Return pairs of a colour and a light. The sum of the lights, each multiplied by its colour, is this light.

        The lights are the image's red, green and blue channel; a grey image, or one colour, gives a single light.
        `bands` is the number of bands to keep; by default, all are kept.
        """
        image, most = self.panorama, min(bands or self.bands, self.bands)
        if (image.image == image.image[..., :1]).all():
            return (((1.0, 1.0, 1.0), SkyChannel(source=self, channel=0, most=most)),)
        if image.is_uniform:
            red, green, blue = image.image[0, 0].tolist()
            return (((red, green, blue), SkyChannel(source=replace(self, image=1.0), channel=0, most=1)),)
        return tuple((tint, SkyChannel(source=self, channel=k, most=most)) for k, tint in enumerate(_RED_GREEN_BLUE))


def _means(rows: Float64Array, count: int) -> Float64Array:
    """Average the rows of an array in groups of equal height; return `count` rows.

    An array with at most `count` rows is returned unchanged.
    """
    if len(rows) <= count:
        return rows
    ends = np.linspace(0.0, len(rows), count + 1)
    whole = ends.astype(np.int64)
    padded = np.pad(rows, ((0, 1), (0, 0)))
    sums = np.pad(rows.cumsum(axis=0), ((1, 0), (0, 0)))
    parts = np.diff(sums[whole] + (ends - whole)[:, None] * padded[whole], axis=0)
    return np.maximum(parts, 0.0) * (count / len(rows))


def _middle(up: VectorLike) -> Vector:
    """Return the direction to the image's middle at rotation 0: the x axis without its part along `up`, normalized.

    If `up` is along the x axis, the result is the z axis.
    """
    upward = np.array(unit_vector(up))
    for axis in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)):
        across = np.array(axis) - upward * upward[int(np.argmax(axis))]
        if np.linalg.norm(across) > _LEAST:
            break
    return unit_vector(across.tolist())


@dataclass(frozen=True)
class SkyChannel(Light):
    """One colour channel of an environment, in its first bands of spherical harmonics.

    For lobes with a closed form, evaluators replace the environment by such channels, each multiplied by its colour;
    see `EnvironmentLight.tints`.

    Parameters
    ----------
    source : EnvironmentLight
        The environment.
    channel : int
        Index of red, green or blue.
    most : int
        Number of bands that are used.
    """

    source: Any
    channel: int
    most: int

    is_uniform: ClassVar[bool] = True
    is_all_around: ClassVar[bool] = True

    def nodes(self, count: int) -> tuple[DirectionalLight, ...]:
        """Return `count` parallel lights that approximate the whole environment."""
        return tuple(self.source.nodes(count))

    def analytic_integral(self, form: CosinePower) -> Integral:
        """Return the integral of the channel over all directions, weighted by `form`, a power of a cosine.

        The result is the image blurred by this power, times the fraction of the power's integral that is above the
        horizon.
        """
        return Integral(sky, (0.0, 0.0, 0.0), math.inf, _sky_of(self, form))


@lru_cache(maxsize=32)
def _sky_of(channel: SkyChannel, form: CosinePower) -> tuple[float, ...]:
    """Return the numbers that the formula `sky` reads: the channel's spherical harmonics, convolved with `form`.

    Trailing bands that are negligible are dropped.
    """
    image, most = channel.source.panorama, channel.most
    weighted = 2.0 * moments(form.power, most)[:, None, None] * image.harmonics[channel.channel, :most, :most]
    sizes = np.abs(weighted).max(axis=(1, 2))
    end = 1 + np.flatnonzero(sizes > _NOTHING * sizes.max(initial=0.0)).max(initial=0)
    hiding = form.power if form.around == "mirror" else None
    return sky_numbers(channel.source.axes, np.asarray(weighted[:end, :end] * image.largest), hiding)


@lru_cache(maxsize=32)
def _nodes(image: Panorama, axes: tuple[float, ...], count: int) -> tuple[DirectionalLight, ...]:
    height, width, _ = image.image.shape
    cells = image.image.repeat(-(-_ROWS // height), axis=0).repeat(-(-2 * _ROWS // width), axis=1).astype(np.float64)
    powers = cells * row_areas(*cells.shape[:2])[:, None, None] / math.pi
    to_sky = directions(*cells.shape[:2]) @ np.reshape(axes, (3, 3))
    return tuple(_node(powers[part], to_sky[part], axes[6:]) for part in _halved(powers.mean(axis=2), count))


def _halved(powers: Float64Array, count: int) -> list[tuple[slice, slice]]:
    """Divide an image into at most `count` rectangular parts; return the rows and columns of each as slices.

    Each step halves the part with the most power, across its longer side. `powers` has the power of each texel, shape
    (h, w).
    """
    height, width = powers.shape
    parts, sums = [(slice(0, height), slice(0, width))], [float(powers.sum())]  # −1 for a part of one cell
    while len(parts) < count and max(sums) >= 0.0:
        k = sums.index(max(sums))
        part = rows, columns = parts[k]
        cells = powers[part]
        wide = 2.0 * cells.shape[1] / width * math.sin(math.pi * 0.5 * (rows.start + rows.stop) / height)
        axis = 0 if cells.shape[1] == 1 or (cells.shape[0] > 1 and cells.shape[0] / height >= wide) else 1
        along = cells.sum(axis=1 - axis).cumsum()
        cut = part[axis].start + 1 + int(np.abs(along[:-1] - 0.5 * along[-1]).argmin())
        ends = slice(part[axis].start, cut), slice(cut, part[axis].stop)
        halves = [(end, columns) if axis == 0 else (rows, end) for end in ends]
        parts[k : k + 1] = halves
        sums[k : k + 1] = [float(powers[half].sum()) if powers[half].size > 1 else -1.0 for half in halves]
    return parts


def _node(powers: Float64Array, to_sky: Float64Array, up: tuple[float, ...]) -> DirectionalLight:
    """Return the parallel light that replaces a part of the image.

    Parameters
    ----------
    powers : ndarray
        Power of the part's texels, shape (h, w, 3).
    to_sky : ndarray
        Unit vectors to these texels, shape (h, w, 3).
    up : tuple of float
        Direction from which the light comes if the mean of `to_sky` is zero.
    """
    color = powers.sum(axis=(0, 1))
    power = float(color.mean())
    middle = np.tensordot(powers.mean(axis=2) / (power or 1.0), to_sky, 2)
    if np.linalg.norm(middle) <= _LEAST:
        middle = np.array(up)
    red, green, blue = (color / power).tolist() if power else (1.0, 1.0, 1.0)
    x, y, z = (-middle).tolist()
    return DirectionalLight(unit_vector((x, y, z)), diffuse=(red, green, blue), intensity=power)
