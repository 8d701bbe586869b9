"""The studio: a web page to edit the lights, materials and light model of a plotter. Needs the extra `trame`.

Read in this order:

1. `settings`: values that only the studio has. `fields`: kind, unit, range and help of a dataclass's fields, for forms;
   it also parses values from the page.
2. `kinds`: lights and reflectances by name. `coloring`: the choice of an array and its colormap. `mix`: faders, which
   scale each light's contribution.
3. `opening`: the files that are shown, and lights that fit another one. `staging`: the stage under them.
   `set_ups`: set-ups of lights, and the sun by date and place.
   `new_light`: the place and the intensity of a new light. `placing`: a light's angles and distance about its target.
   `skies`: images of environment lights. `document`: the editable values, named by keys, with one undo history for
   panels and gizmos.
4. `words`: the names of fields on the page. `messages`: errors in these words. `inputs`, `panels` and `page`: Vuetify's
   components around the view.
5. `access`: access control for HTTP and WebSocket, validation of messages, and uploads. `uploads`: the kinds of files
   that can be uploaded. `sharing`: one view for browsers of different sizes.
6. `downloads`: the files to download, and the Python script that reproduces them. `turntable`: a GIF.
7. `exactness`: how exact the picture is, in words. `report`: the accuracy report, measured in a separate process.
8. `cameras`: views from the front, the top and so on. `framing`: the camera's angle in a narrow view.
   `thumbnails`: spheres that show materials and reflectances. `live_histogram`: counts of the picture's luminance.
   `live_probe`: lit values under the cursor, and pins. `live_ask`: a spot dragged brighter or darker. `hurry`: coarse
   pictures of large meshes while something moves. `snapshots`: kept states with their pictures. `instruments`: these
   five together.
9. `studio`: combines all of these, and has the server.
10. `serving`: runs the studio in its own event loop, or in a notebook's.

An edit goes from `inputs` through `access` and `studio` to `document`. `document` parses the value with `fields`.
`document` then sets the value in `window_lights`, in `lit_mesh`, in `plotter.phong`, in `mix`, or in itself. Finally,
`studio` requests a frame, before which `lit_actors` updates the lit meshes.

Only `inputs`, `panels`, `page`, `access`, `thumbnails`, `turntable`, `studio` and `serving` depend on a server.
"""

from __future__ import annotations

import importlib.util

from pvphong.base import check


def refuse_missing_extra(called: str) -> None:
    """Raise ``ValueError`` if the extra is not installed. The message names the function or command, `called`."""
    if importlib.util.find_spec("trame_pyvista") is None:
        check.refuse(
            called,
            "a missing package",
            "used with its packages installed",
            "Run: pip install trame-pyvista trame-vuetify",
        )
