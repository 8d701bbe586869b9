"""All evaluators in both precisions, to run the same rows of the catalogue with each."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any
from unittest import mock

import numpy as np
from stability.bounds import U, V

from pvphong import LightModel, Material, Scene, Shading, evaluate
from pvphong.base import threads
from pvphong.shading import kernel, reference

STEPS = {"float32": V, "float64": U}


class Declined(Exception):
    """Raised if the compiled kernel delegates to the reference."""


@dataclass(frozen=True)
class Evaluator:
    """`evaluate` with a backend in a precision. Raises `Declined` if another backend would compute."""

    backend: str
    precision: str

    @property
    def real(self) -> Any:
        return np.dtype(self.precision).type

    @property
    def step(self) -> float:
        """Half a unit in the last place of 1.0: u or v in the catalogue."""
        return STEPS[self.precision]

    @property
    def in_full(self) -> dict[str, Any]:
        """Options for all arrays that this evaluator can return; the kernel returns only colours."""
        return {"components": self.backend == "numpy"}

    def __call__(self, points: Any, normals: Any, scene: Scene, material: Material, **options: Any) -> Shading:
        options |= {"precision": self.precision, "backend": self.backend}
        if self.backend == "numpy":
            return evaluate(points, normals, scene, material, **options)
        import_module("pvphong.shading.kernel.evaluation")  # before patching: it binds the reference
        with mock.patch.object(reference, "shade", side_effect=Declined), threads.limited(1):
            return evaluate(points, normals, scene, material, **options)

    def __str__(self) -> str:
        return f"{self.precision}-{self.backend}"


BACKENDS = ["numpy", "numba"] if kernel.is_available() else ["numpy"]
EVALUATORS = [Evaluator(backend, precision) for backend in BACKENDS for precision in STEPS]

UNLIT = LightModel(ambient=0.0, clamp=False)
"""A light model without ambient light and without clipping at 1."""
