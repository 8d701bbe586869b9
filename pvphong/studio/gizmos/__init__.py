"""Gizmos: lights placed by hand, in the window.

`plotter.phong.add_gizmos` puts them up. The arithmetic of a drag (`view`, `press`, and one file for each kind of
light) and the looks (`drawing`) know no window; `grip` and `overlay` are VTK's side, `board` joins the two.
"""

from pvphong.studio.gizmos.board import Board, Options
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.history import History

__all__ = ["Board", "Gizmo", "History", "Options"]
