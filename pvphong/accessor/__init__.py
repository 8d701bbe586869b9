"""`mesh.phong`: PyVista finds this package by its entry point, and importing pvphong registers it as well.

What draws or measures is imported when it is used: it would load PyVista's plotting.
"""

from pvphong.accessor.blocks import BlocksPhong
from pvphong.accessor.mesh import MeshPhong

__all__ = ["BlocksPhong", "MeshPhong"]
