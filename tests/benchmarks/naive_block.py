"""The reference evaluator with its highlight as a plain power of a cosine: what the stable form costs.

Everything else, the blocks, the memory layout and the order of the work, is the evaluator's own.
"""

from contextlib import contextmanager
from unittest import mock

import numpy as np

from pvphong.base.vectors import dot
from pvphong.optics.reflectances import phong


def cosine(surface, to_light, _raw_cosine):
    """r·v by the mirror direction."""
    normals = surface.raw * surface.inverse_length
    mirror = normals * (2.0 * dot(normals, to_light)) - to_light
    return dot(mirror, surface.to_viewer)


def power(cosine, shininess, floor):
    """max(cosine, floor) to the power of the shininess."""
    return np.maximum(cosine, cosine.dtype.type(floor)) ** cosine.dtype.type(shininess)


@contextmanager
def naive_highlights():
    """While it lasts, `pvphong.evaluate` computes highlights of Phong reflection the naive way."""
    with (
        mock.patch.object(phong, "mirror_distance", cosine),
        mock.patch.object(phong, "power", power),
    ):
        yield
