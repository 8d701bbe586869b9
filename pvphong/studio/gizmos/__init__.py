"""Gizmos: handles to place lights by hand in the window. `plotter.phong.add_gizmos` adds them.

Read in this order:

1. `view`: maps the cursor to the world, and holds the state at the start of a drag.
2. `drawing`: lines, areas and texts over the picture.
3. `handles`: a handle for each role of a light's field, with its drag, typed values, drawing and readout.
4. `highlight`: dragging a highlight on the surface.
5. `history`: undo and redo.
6. `gizmo`: the gizmos of a subplot.
7. `commands`: the table of keys.
8. `asking`: a spot that is dragged brighter or darker.
9. `interaction`: mouse and keyboard, from the event to the light.
"""

from pvphong.studio.gizmos.commands import check_keys
from pvphong.studio.gizmos.gizmo import Gizmo, Gizmos, Keys, Options
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.interaction import Interaction

__all__ = ["Gizmo", "Gizmos", "History", "Interaction", "Keys", "Options", "check_keys"]
