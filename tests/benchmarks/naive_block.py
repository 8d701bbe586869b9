"""The reference evaluator with its highlight as a plain power of a cosine: what the stable form costs.

Everything else, the blocks, the memory layout and the order of the work, is the evaluator's own.
"""

from contextlib import contextmanager
from unittest import mock

import numpy as np

from pvphong.base.formulas import dot, times
from pvphong.optics import reflectance
from pvphong.optics.reflectances import BlinnPhong, Phong


def mirror_cosine(at):
    """r·v by the mirror direction."""
    normals = times(at.n, at.scale)
    twice = 2 * dot(normals, at.l)
    return dot([twice * n - l for n, l in zip(normals, at.l, strict=True)], at.v)


def halfway_cosine(at):
    """n·h."""
    h = at.l + at.v
    return dot(times(at.n, at.scale), h / np.sqrt(dot(h, h)))


def power(cosine, exponent, floor=0.0):
    """max(cosine, floor) to the power of the exponent."""
    return np.maximum(cosine, cosine.dtype.type(floor)) ** cosine.dtype.type(exponent)


@contextmanager
def naive_highlights():
    """While it lasts, highlights of Phong's and Blinn-Phong's reflection are computed the naive way in NumPy."""
    with (
        mock.patch.object(Phong, "peak", Phong.peak._replace(square=mirror_cosine)),
        mock.patch.object(BlinnPhong, "peak", BlinnPhong.peak._replace(square=halfway_cosine)),
        mock.patch.object(reflectance, "chord_power", power),
    ):
        yield
