"""Classes of model matrices, as far as they concern normals."""

from __future__ import annotations

from enum import Enum

import numpy as np

from pvphong.base.types import Float64Array


class MatrixClass(Enum):
    """What a matrix does to the directions of normals; the value says it to people."""

    TRANSLATION = "a translation"
    UNIFORM_SCALE = "a uniform scale"
    SIMILAR = "rigid or similar: the inverse-transpose is the matrix itself, but for its scale"
    GENERAL = "general: normals need the inverse-transpose"

    @property
    def keeps_normals(self) -> bool:
        """Whether normals point where they did."""
        return self in {MatrixClass.TRANSLATION, MatrixClass.UNIFORM_SCALE}


def class_of(matrix: Float64Array) -> MatrixClass:
    """Of a (4, 4) affine matrix; what keeps normals is exact, what is similar is so to 1e-12."""
    linear, w = matrix[:3, :3], matrix[3, 3]
    if np.array_equal(linear, np.eye(3) * linear[0, 0]) and np.sign(linear[0, 0]) == np.sign(w):
        return MatrixClass.TRANSLATION if linear[0, 0] == w else MatrixClass.UNIFORM_SCALE
    scaled = np.ldexp(linear, -np.frexp(np.abs(linear).max())[1])  # so that no product overflows
    gram = scaled.T @ scaled
    if np.allclose(gram, np.eye(3) * gram[0, 0], rtol=0.0, atol=1e-12):
        return MatrixClass.SIMILAR
    return MatrixClass.GENERAL
