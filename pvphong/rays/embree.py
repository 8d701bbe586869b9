"""Intel's Embree through its C interface, in the library that embreex contains (the extra `rays`).

embreex's own calls take arrays of rays from Python and copy a mesh triangle by triangle. This module shares arrays with
Embree, and compiled code calls it by address (`pvphong.shading.kernel.rays`).

Source of names, numbers and layouts: the headers `rtcore_*.h` of Embree 4.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import importlib.metadata
import os
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.shading import kernel
from pvphong.shading.kernel import Casters

_POINTER, _SIZE, _NUMBER = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint

# Signatures of the functions: result type, then argument types.
_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "rtcNewDevice": (_POINTER, ctypes.c_char_p),
    "rtcReleaseDevice": (None, _POINTER),
    "rtcGetDeviceError": (_NUMBER, _POINTER),
    "rtcGetDeviceProperty": (ctypes.c_ssize_t, _POINTER, _NUMBER),
    "rtcNewScene": (_POINTER, _POINTER),
    "rtcReleaseScene": (None, _POINTER),
    "rtcSetSceneFlags": (None, _POINTER, _NUMBER),
    "rtcNewGeometry": (_POINTER, _POINTER, _NUMBER),
    "rtcReleaseGeometry": (None, _POINTER),
    "rtcSetSharedGeometryBuffer": (None, _POINTER, _NUMBER, _NUMBER, _NUMBER, _POINTER, _SIZE, _SIZE, _SIZE),
    "rtcCommitGeometry": (None, _POINTER),
    "rtcAttachGeometry": (_NUMBER, _POINTER, _POINTER),
    "rtcCommitScene": (None, _POINTER),
    "rtcOccluded16": (None, _POINTER, _POINTER, _POINTER, _POINTER),
    "rtcIntersect16": (None, _POINTER, _POINTER, _POINTER, _POINTER),
}
_VERSION, _NATIVE_RAYS_OF_8, _TRIANGLES = 0, 33, 0
_INDICES, _POINTS, _UINT3, _FLOAT3 = 0, 1, 0x5003, 0x9003
_ROBUST = 1 << 2
_MAJOR = 4

# Number of bytes that Embree may read after the last point.
_AFTER_POINTS = 16


class Unavailable(Exception):
    """Raised if Embree cannot be called; the message is the reason."""


@functools.cache
def library() -> ctypes.CDLL:
    """Return Embree's library, with the signatures of its functions set.

    Raises
    ------
    Unavailable
        If the library is missing or has another version.
    """
    try:
        module = importlib.import_module("embreex.rtcore_scene")
    except ImportError as error:
        raise Unavailable(f"embreex cannot be imported: {error}") from None
    for path in (str(module.__file__), *_libraries_in_wheel()):
        try:
            loaded = ctypes.CDLL(path)
            for name, (result, *arguments) in _FUNCTIONS.items():
                function = getattr(loaded, name)  # a module also finds symbols of its own libraries
                function.restype, function.argtypes = result, arguments
        except (OSError, AttributeError):
            continue
        return loaded
    raise Unavailable("embreex contains no Embree 4 library with a C interface")


def _libraries_in_wheel() -> list[str]:
    """Return the paths of Embree's libraries in the installed package embreex.

    They are needed on platforms such as Windows, where a module does not find the symbols of the libraries that it has
    loaded.
    """
    try:
        files = importlib.metadata.files("embreex") or []
    except importlib.metadata.PackageNotFoundError:
        return []
    return [str(file.locate()) for file in files if "embree4" in file.name and not file.name.endswith(".py")]


@functools.lru_cache(maxsize=1)
def _device(_process: int) -> int:
    """Return the Embree device of this process.

    The result is cached by `_process`, the id of the process, so that a forked process creates a device of its own. The
    device lives as long as the process, because scenes refer to it. Raise Unavailable if Embree cannot be used.
    """
    embree = library()
    device = embree.rtcNewDevice(None)
    if not device:
        raise Unavailable(f"Embree cannot create a device (error {embree.rtcGetDeviceError(None)})")
    version = int(embree.rtcGetDeviceProperty(device, _VERSION))
    reason = ""
    if version // 10000 != _MAJOR:
        reason = f"Embree {version} is not version {_MAJOR}"
    elif not embree.rtcGetDeviceProperty(device, _NATIVE_RAYS_OF_8):
        reason = "this processor lacks AVX, which packets of rays need"
    if reason:
        embree.rtcReleaseDevice(device)
        raise Unavailable(reason)
    return int(device)


def obstacle() -> str:
    """Return the reason why Embree's C interface cannot be used; "" if it can."""
    try:
        _device(os.getpid())
    except Unavailable as reason:
        return str(reason)
    return ""


class Embree:
    """Triangles in an Embree scene. Any thread may test rays with `handle`, the address of the `RTCScene`.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), finite and of moderate size.
    corners : ndarray
        Shape (m, 3): point indices of each triangle.

    Raises
    ------
    MemoryError
        If Embree runs out of memory or fails.
    """

    title = "compiled code and Embree"

    def __init__(self, points: FloatArray, corners: NDArray[np.int64]) -> None:
        embree, device = library(), _device(os.getpid())
        shared = np.empty((len(points) + _AFTER_POINTS // 12 + 1, 3), np.float32)
        shared[: len(points)], shared[len(points) :] = points, 0.0
        indices = corners.astype(np.uint32)
        scene = embree.rtcNewScene(device)
        geometry = embree.rtcNewGeometry(device, _TRIANGLES)
        share = embree.rtcSetSharedGeometryBuffer
        share(geometry, _POINTS, 0, _FLOAT3, shared.ctypes.data, 0, 12, len(points))
        share(geometry, _INDICES, 0, _UINT3, indices.ctypes.data, 0, 12, len(indices))
        embree.rtcCommitGeometry(geometry)
        embree.rtcAttachGeometry(scene, geometry)
        embree.rtcReleaseGeometry(geometry)  # the scene keeps a reference
        embree.rtcSetSceneFlags(scene, _ROBUST)
        self.handle = int(scene)
        weakref.finalize(self, _release, embree, scene, (shared, indices)).atexit = False  # process exit frees it
        embree.rtcCommitScene(scene)
        error = embree.rtcGetDeviceError(device)
        if error:
            raise MemoryError(f"Embree cannot build a scene of {len(corners):,} triangles (error {error}).")

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Return True for each ray that hits a triangle within its length, shape (n,).

        `origins` and `directions` have the shape (n, 3), and `lengths` has (n,). The directions are unit vectors. All
        numbers are of moderate size.
        """
        return kernel.rays_blocked(origins, directions, lengths, casters_of([self], [(0.0, 0.0, 0.0, 1.0)]))


def casters_of(scenes: Sequence[Embree], places: Sequence[Sequence[float]]) -> Casters:
    """Return Embree scenes, and the transforms of rays to their coordinates, in the form that compiled code reads.

    `places` has four numbers for each scene: its centre, and the power of two that scales it to [−1, 1].

    Compiled code sets Embree's flag for coherent rays only for rays from one vertex within a narrow cone, which are
    rays to random points. It is not set for hard shadows, whose rays may meet edges and corners exactly.
    """
    functions = library().rtcOccluded16, library().rtcIntersect16
    test, find = (ctypes.cast(function, _POINTER).value or 0 for function in functions)
    handles, numbers = np.array([scene.handle for scene in scenes], np.int64), np.array(places, np.float64)
    return Casters(test, find, handles, numbers, scenes)


def _release(embree: Any, scene: int, _arrays: tuple[Any, ...]) -> None:
    """Release the scene with the handle `scene`. The argument `_arrays` keeps the scene's shared arrays alive until
    then.
    """
    embree.rtcReleaseScene(scene)
