"""`mesh.phong.transport`: converts meshes to surfaces that exchange light, and to occluders."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Self

import pyvista as pv

from pvphong.base import check
from pvphong.base.types import FloatArray, MatrixLike
from pvphong.meshes.surfaces import FeatureAngle, point_normals, split_sharp_edges, surface
from pvphong.meshes.visibility import checked_occluders, receiver_of
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.rays.rays import Receiver
from pvphong.rays.sampling import MOST_RAYS
from pvphong.rays.transport import MEMORY, HemisphereTracer, Transport, checksum_of, refuse_too_large

SAMPLES = 256
"""Default number of rays per vertex."""

_MULTIPLE = 16


class Exchanging(NamedTuple):
    """A surface that exchanges light with others.

    `normals` is a function that returns its point normals, and `matrix` its model matrix.
    """

    source: pv.PolyData
    normals: Callable[[], FloatArray]
    matrix: MatrixLike | None
    inside: int | None = None
    """Index of the surface on whose faces the points lie. It is set for points without faces, which only gather light.
    """

    @classmethod
    def of(cls, mesh: pv.DataSet, matrix: MatrixLike | None, feature_angle: FeatureAngle) -> Self:
        """Return the surface of a dataset, with normals that are computed when they are first used.

        `matrix` is the model matrix. Edges are split if the normals of their faces differ by more than `feature_angle`,
        in degrees.
        """
        source, _ = split_sharp_edges(surface(mesh), feature_angle)
        return cls(source, functools.cache(lambda: point_normals(source)), matrix)


def transport(
    mesh: pv.DataSet,
    *,
    occluders: Any = (),
    samples: int = SAMPLES,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    memory: float = MEMORY,
) -> Transport:
    """Compute the transport of light between vertices, the same for all lights, materials and bounces.

    When the result is first used, cosine-distributed rays are cast from each vertex that can see a surface. The mesh
    reflects light on the side of its normals. Its other side is black and blocks light, like occluders. With the extra
    `rays`, Intel's Embree casts the rays; without it VTK does, which takes much longer.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface.
    occluders : sequence, optional
        Other meshes that block light and do not reflect it, each as a mesh or a pair of a mesh and a 4x4 matrix.
    samples : int, default 256
        Rays per vertex, rounded up to a multiple of 16; at most 4096. The error falls slightly faster than one over the
        square root of their number.
    matrix : array_like, optional
        (4, 4) model matrix of the mesh.
    feature_angle : float, "auto" or None, default None
        Edges are split if the normals of their two faces differ by more than this angle, in degrees; see `shade`.
    memory : float, default 2e9
        Memory limit in bytes for the rays' hits. The hits take 4 bytes × vertices × samples. If this exceeds the limit,
        the hits are not stored, and rays are cast again for each bounce.

    Returns
    -------
    Transport
        `.gather(colors)` returns the mean colour that each vertex sees. `.matrix` is the transport as a `scipy.sparse`
        matrix. See also `.expected_cost()`, `.save(path)` and `pvphong.Transport.load(path)`.

    Raises
    ------
    ValueError
        If an argument is invalid, or the mesh has nothing that can be lit.

    Examples
    --------
    >>> import numpy as np, pyvista as pv, pvphong as ph
    >>> bowl = pv.Sphere(end_phi=90).flip_faces().compute_normals(auto_orient_normals=False, consistent_normals=False)
    >>> seen = bowl.phong.transport().gather(np.ones((bowl.n_points, 3)))
    """
    return transport_of([Exchanging.of(mesh, matrix, feature_angle)], occluders, samples, memory)


def transport_of(
    surfaces: Sequence[Exchanging], occluders: Any = (), samples: int = SAMPLES, memory: float = MEMORY
) -> Transport:
    """Return the transport of light between the vertices of several surfaces.

    `occluders` are other meshes that block light, `samples` is the number of rays per vertex, and `memory` is the
    memory limit in bytes; see `transport`.
    """
    count = int(check.number("samples", samples, at_least=1.0, at_most=float(MOST_RAYS)))
    count = -(-count // _MULTIPLE) * _MULTIPLE
    memory = check.number("memory", memory, at_least=0.0)
    tracer = _tracer(surfaces, occluders, count)
    refuse_too_large(count, int(tracer.starts[-1]), memory)
    return Transport.of(tracer, memory)


def checked_transport(given: Any, surfaces: Sequence[Exchanging], occluders: Any = ()) -> Transport:
    """Return `given`, the transport of light between some surfaces, after a check. If it is None, return a new one.

    A new transport casts rays when it is first used.

    Parameters
    ----------
    given : Transport or None
        The argument `transport`.
    surfaces : sequence of Exchanging
        The surfaces that exchange light.
    occluders : sequence
        Other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix.

    Raises
    ------
    ValueError
        If `given` is not a Transport, or was made for other surfaces or occluders.
    """
    if given is None:
        return transport_of(surfaces, occluders)
    if not isinstance(given, Transport):
        check.refuse("transport", type(given).__name__, "a Transport from mesh.phong.transport()")
    given.refuse_other(checksum_of(_tracer(surfaces, occluders, _MULTIPLE)))
    return given


def _tracer(surfaces: Sequence[Exchanging], occluders: Any, samples: int) -> HemisphereTracer:
    receivers, parts = list[Receiver](), list[BlockingFaces]()
    for source, normals, matrix, inside in surfaces:
        receiver = receiver_of(source, normals, matrix, len(parts))
        if inside is not None:
            receivers.append(replace(receiver, part=receivers[inside].part))
            continue
        receivers.append(receiver)
        if receiver.part is not None:
            parts.append(receiver.faces)
    return HemisphereTracer(receivers, Occluders([*parts, *checked_occluders(occluders)]), samples)
