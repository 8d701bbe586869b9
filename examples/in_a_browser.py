"""Place lights in a web page: the plotter stays here, draws, and sends pictures; the browser sends the mouse back.

Here the server ends when it is ready. With `--window` a browser opens: drag a light there. In Jupyter,
`plotter.show(jupyter_backend="server")` does all of this. It needs the extra `trame`.
"""

import asyncio

import pyvista as pv
from arguments import FOLDER, WINDOW
from trame.app import get_server
from trame.ui.vuetify3 import VAppLayout
from trame_pyvista.ui import plotter_ui

import pvphong as ph

plotter = pv.Plotter(off_screen=True, window_size=(640, 400), lighting="none")
plotter.set_background("#242830")
plotter.phong.add_light(ph.DirectionalLight(direction=(1, -1, -1.2), diffuse=0.5, frame="camera", name="key"))
plotter.phong.add_light(
    ph.SpotLight(
        position=(0.7, -1.5, 1.6),
        direction=(-0.9, 1.2, -1.4),
        cone_angle=18,
        exponent=90,
        diffuse=(0.6, 0.8, 1),
        intensity=4,
        name="spot",
    )
)
torus = pv.ParametricTorus(ringradius=0.6, crosssectionradius=0.25, u_res=400, v_res=240)
plotter.phong.add_mesh(torus, ph.Material(ambient=0.2, diffuse=(0.75, 0.45, 0.3), specular=0.4, shininess=50))
plotter.camera_position = [(0, -3.6, 2.4), (0, 0, 0.1), (0, 0, 1)]
plotter.phong.add_gizmos(in_screenshots=True)

server = get_server(client_type="vue3")
with VAppLayout(server):
    plotter_ui(plotter, mode="server", server=server)


@server.controller.add("on_server_ready")
def finish(**_: object) -> None:
    """Keep a picture, and end unless there is a browser to look at it."""
    picture = FOLDER / "in_a_browser.png"
    plotter.screenshot(picture)
    print(f"wrote {picture}")
    if not WINDOW:
        asyncio.create_task(server.stop())  # noqa: RUF006 nothing is left to collect it


server.start(port=0, open_browser=WINDOW)
plotter.close()
