"""`mesh.phong`: PyVista imports this package, which it finds by its entry point, when `phong` is first asked for.

What draws or measures is imported when it is used: it would load PyVista's plotting.
"""

from pvphong.accessor.blocks import BlocksPhong
from pvphong.accessor.mesh import MeshPhong

__all__ = ["BlocksPhong", "MeshPhong"]
