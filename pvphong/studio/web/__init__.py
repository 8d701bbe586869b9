"""The studio: lights, materials and light model of a plotter edited in a web page. Needs the extra `trame`.

Read in this order:

1. `fields`: what a form asks of a dataclass: kind, unit, range and help of each field; and a value from the page.
2. `coloring`: an array through a colormap, as it is chosen and shown; `mix`: faders, which sum the lights' shares.
3. `document`: what is edited, by keys, with one history for panels and gizmos.
4. `inputs` and `page`: Vuetify's components around the view.
5. `access`: who gets in, by HTTP and WebSocket; which messages are taken; uploads.
6. `downloads`: the files that leave, and the Python that makes them again.
7. `report`: the accuracy report, measured in a process of its own.
8. `thumbnails`: balls of materials and reflectances.
9. `studio`: all of these put together, and the server.
10. `serving`: in a loop of its own, or in a notebook's.

An edit goes from `inputs` by `access` and `studio` to `document`, which asks `fields` for the value and sets it in
`window_lights`, in `lit_mesh`, or in `plotter.phong`; then the lit meshes are brought up to date as after any change.

All but `inputs`, `page`, `access`, `studio` and `serving` know nothing of a server.
"""

from __future__ import annotations

import importlib.util

from pvphong.base import check


def refuse_missing_extra(called: str) -> None:
    """Raise ``ValueError`` if the extra is not installed; what is called is named."""
    if importlib.util.find_spec("trame_pyvista") is None:
        check.refuse(called, "none of its packages", "installed", "pip install trame-pyvista trame-vuetify.")
