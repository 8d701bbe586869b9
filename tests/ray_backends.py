"""What casts rays here: each backend that there is, for tests to run with; compiled code is compiled first."""

from pvphong.rays import casting, embree
from pvphong.shading import kernel

BACKENDS = {"vtk": casting.Locator}
if not embree.obstacle():
    BACKENDS["embreex"] = casting.Embreex
if kernel.is_available() and not embree.obstacle():
    from pvphong.shading.kernel import ahead

    for piece in ahead.pieces(kernel._library()):
        if "rays" in piece.name:
            piece.compile()
    BACKENDS["compiled"] = casting.Embree

FASTEST = list(BACKENDS)[-1]
