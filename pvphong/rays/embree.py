"""Intel's Embree through its own C interface, in the library that embreex brings (the extra `rays`).

embreex's own calls take arrays of rays from Python and copy a mesh triangle by triangle. Here arrays are shared with
Embree, and compiled code calls it by address (`pvphong.shading.kernel.rays`).

Source: the headers `rtcore_*.h` of Embree 4, from which names, numbers and layouts are.
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

# What is called: its result, and the types of its arguments.
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

# Bytes that Embree may read after the last point.
_AFTER_POINTS = 16


class Unavailable(Exception):
    """Why Embree cannot be called."""


@functools.cache
def library() -> ctypes.CDLL:
    """Embree's library, with the types of what is called.

    Raises
    ------
    Unavailable
        If there is none, or another version.
    """
    try:
        module = importlib.import_module("embreex.rtcore_scene")
    except ImportError as error:
        raise Unavailable(f"embreex cannot be imported: {error}") from None
    for path in (str(module.__file__), *_libraries_in_wheel()):
        try:
            loaded = ctypes.CDLL(path)
            for name, (result, *arguments) in _FUNCTIONS.items():
                function = getattr(loaded, name)  # of the module too: it is looked for in what that has loaded
                function.restype, function.argtypes = result, arguments
        except (OSError, AttributeError):
            continue
        return loaded
    raise Unavailable("embreex's wheel has no library of Embree 4 with its C interface")


def _libraries_in_wheel() -> list[str]:
    """Where symbols are not looked for in what a module has loaded, as on Windows."""
    try:
        files = importlib.metadata.files("embreex") or []
    except importlib.metadata.PackageNotFoundError:
        return []
    return [str(file.locate()) for file in files if "embree4" in file.name and not file.name.endswith(".py")]


@functools.lru_cache(maxsize=1)
def _device(_process: int) -> int:
    """A process has its own; it lives as long as that, and scenes hold it too."""
    embree = library()
    device = embree.rtcNewDevice(None)
    if not device:
        raise Unavailable(f"Embree makes no device (error {embree.rtcGetDeviceError(None)})")
    version = int(embree.rtcGetDeviceProperty(device, _VERSION))
    reason = ""
    if version // 10000 != _MAJOR:
        reason = f"Embree {version} is not version {_MAJOR}"
    elif not embree.rtcGetDeviceProperty(device, _NATIVE_RAYS_OF_8):
        reason = "this processor has no AVX, with which many rays are tested at once"
    if reason:
        embree.rtcReleaseDevice(device)
        raise Unavailable(reason)
    return int(device)


def obstacle() -> str:
    """Why Embree's C interface cannot be used; "" where it can."""
    try:
        _device(os.getpid())
    except Unavailable as reason:
        return str(reason)
    return ""


class Embree:
    """Triangles in Embree's memory; any thread may test rays with `handle`, the number of an `RTCScene`.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), moderate and finite.
    corners : ndarray
        Shape (m, 3): which of the points are a triangle's.

    Raises
    ------
    MemoryError
        If Embree has no memory left, or fails otherwise.
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
        embree.rtcReleaseGeometry(geometry)  # the scene holds it
        embree.rtcSetSceneFlags(scene, _ROBUST)
        self.handle = int(scene)
        weakref.finalize(self, _release, embree, scene, (shared, indices)).atexit = False  # the process frees all
        embree.rtcCommitScene(scene)
        error = embree.rtcGetDeviceError(device)
        if error:
            raise MemoryError(f"Embree cannot take {len(corners):,} triangles (error {error}).")

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met: origins and unit vectors (n, 3), lengths (n,), all of moderate size."""
        return kernel.rays_blocked(origins, directions, lengths, casters_of([self], [(0.0, 0.0, 0.0, 1.0)]))


def casters_of(scenes: Sequence[Embree], places: Sequence[Sequence[float]]) -> Casters:
    """Scenes, and what brings rays to their coordinates, as compiled code takes them.

    Embree's option for rays that begin side by side makes hard shadows 1.1 times as fast, but lets some through where
    triangles meet.
    """
    functions = library().rtcOccluded16, library().rtcIntersect16
    test, find = (ctypes.cast(function, _POINTER).value or 0 for function in functions)
    handles, numbers = np.array([scene.handle for scene in scenes], np.int64), np.array(places, np.float64)
    return Casters(test, find, handles, numbers, scenes)


def _release(embree: Any, scene: int, _arrays: tuple[Any, ...]) -> None:
    """Arrays that are shared with it outlive a scene."""
    embree.rtcReleaseScene(scene)
