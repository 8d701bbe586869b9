"""The studio: a web page to edit the lights, materials and light model of a plotter. Needs the extra `trame`.

Read in this order:

1. `fields`: kind, unit, range and help of a dataclass's fields, for forms, and the parsing of values from the page.
2. `coloring`: the choice of an array and its colormap; `mix`: faders, which scale each light's contribution.
3. `document`: the editable values, named by keys, with one undo history for panels and gizmos.
4. `inputs` and `page`: Vuetify's components around the view.
5. `access`: access control for HTTP and WebSocket, validation of messages, and uploads.
6. `downloads`: the files to download, and the Python script that reproduces them.
7. `report`: the accuracy report, measured in a separate process.
8. `thumbnails`: spheres that show materials and reflectances.
9. `studio`: the combination of all of these, and the server.
10. `serving`: runs the studio in its own event loop, or in a notebook's.

An edit goes from `inputs` through `access` and `studio` to `document`. It parses the value with `fields` and sets it in
`window_lights`, in `lit_mesh`, or in `plotter.phong`; the lit meshes are then updated as after any change.

Only `inputs`, `page`, `access`, `studio` and `serving` depend on a server.
"""

from __future__ import annotations

import importlib.util

from pvphong.base import check


def refuse_missing_extra(called: str) -> None:
    """Raise ``ValueError``, naming the caller, if the extra is not installed."""
    if importlib.util.find_spec("trame_pyvista") is None:
        check.refuse(called, "none of its packages", "installed", "Run: pip install trame-pyvista trame-vuetify")
