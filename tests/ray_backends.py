"""Available ray tracing backends, as test parameters. Compiled code is compiled on import."""

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
