"""Gizmos: lights placed by hand, in the window.

`plotter.phong.add_gizmos` puts them up. What a light shows follows from its fields' roles: `handles` and their drags,
`looks`, `readout`. None of them knows a window: `view` is the eye, `drag_start` what a drag begins with, `drawing`
what is to be drawn. `grip` and `overlay` are VTK's side, `board` joins the two, `interaction` is what mouse and keys
do.

A drag goes from `grip` to `gizmo`, `interaction`, `dragging`, `handles`, and sets the light in the renderer
(`studio.rig`). VTK's widget then draws, and before a frame `studio.pane` has the meshes lit again (`studio.live`) and
the board drawn anew.
"""

from pvphong.studio.gizmos.board import Board
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.options import Options

__all__ = ["Board", "Gizmo", "History", "Options"]
