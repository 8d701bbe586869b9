"""Gizmos: lights placed by hand, in the window. `plotter.phong.add_gizmos` puts them up.

Read in this order:

1. `view`: what a cursor means in the world, and what is frozen when a handle is grabbed.
2. `drawing`: lines, areas and texts over the picture.
3. `handles`: what follows from the role of a light's field: its handle, its drag, what is typed, drawn and said of it.
4. `highlight`: dragging a highlight on the surface.
5. `history`: undo and redo.
6. `gizmo`: the gizmos of a subplot.
7. `commands`: the table of keys.
8. `interaction`: what mouse and keyboard do, from the event to the light.
"""

from pvphong.studio.gizmos.commands import check_keys
from pvphong.studio.gizmos.gizmo import Gizmo, Gizmos, Keys, Options
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.interaction import Interaction

__all__ = ["Gizmo", "Gizmos", "History", "Interaction", "Keys", "Options", "check_keys"]
