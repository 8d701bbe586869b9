"""`ph.Report`: versions and hardware that results depend on."""

from __future__ import annotations

from typing import Any

import scooby

from pvphong.rays.casting import ray_backend
from pvphong.shading import kernel

_PACKAGES = ["pvphong", "pyvista", "vtk", "numpy", "matplotlib"]
_EXTRAS = ["numba", "embreex", "scipy", "imageio", "pvlib", "dask", "distributed", "trame", "trame_vuetify"]


class Report(scooby.Report):
    """Versions of pvphong and the packages that it uses; the evaluator, ray tracer and renderer in use.

    Parameters
    ----------
    gpu : bool, default True
        True to include VTK's renderer; a hidden window is opened to find it. Pass False if rendering fails.

    Examples
    --------
    >>> import pvphong as ph
    >>> "Evaluator" in str(ph.Report(gpu=False))
    True
    """

    def __init__(self, *, gpu: bool = True) -> None:
        obstacle = kernel.obstacle()
        tracer, slower = ray_backend()
        found: list[tuple[str, Any]] = [
            ("Evaluator", "NumPy, " + obstacle[0] if obstacle else "compiled by Numba"),
            ("Rays", f"{tracer.title}: {slower}" if slower else tracer.title),
        ]
        if gpu:
            from pyvista.report import GPUInfo

            found += GPUInfo().get_info()
        super().__init__(core=list(_PACKAGES), optional=list(_EXTRAS), extra_meta=found)
