"""Place lights in a web page: the plotter stays here, draws, and sends pictures; the browser sends the mouse back.

Here the server ends when it is ready. Without `finish`, open the address that it prints and drag a light. In Jupyter,
`plotter.show(jupyter_backend="server")` does all of this. It needs the extra `trame`.
"""

import asyncio
import sys
from pathlib import Path

import pyvista as pv
from trame.app import get_server
from trame.ui.vuetify3 import VAppLayout
from trame_pyvista.ui import plotter_ui

import pvphong as ph

folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()

plotter = pv.Plotter(off_screen=True, window_size=(640, 400), lighting="none")
plotter.set_background("#242830")
plotter.phong.add_light(ph.DirectionalLight(direction=(1, -1, -1.2), diffuse=0.5, frame="camera", name="key"))
plotter.phong.add_light(
    ph.SpotLight(
        position=(0.5, -1.4, 1.5), direction=(-0.4, 1.1, -1.2), cone_angle=16, diffuse=(0.6, 0.8, 1), name="spot"
    )
)
torus = pv.ParametricTorus(ringradius=0.6, crosssectionradius=0.25, u_res=120, v_res=80)
plotter.phong.add_mesh(torus, ph.Material.named("copper"))
plotter.camera_position = [(0, -3.6, 2.4), (0, 0, 0.1), (0, 0, 1)]
plotter.phong.add_gizmos(in_screenshots=True)

server = get_server(client_type="vue3")
with VAppLayout(server):
    plotter_ui(plotter, mode="server", server=server)


@server.controller.add("on_server_ready")
def finish(**_: object) -> None:
    """Keep a picture, and end."""
    picture = folder / "in_a_browser.png"
    plotter.screenshot(picture)
    print(f"wrote {picture}")
    asyncio.create_task(server.stop())  # noqa: RUF006 nothing is left to collect it


server.start(port=0, open_browser=False)
plotter.close()
