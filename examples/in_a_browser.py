"""
Lights in a web page
====================

Serve a plotter in a browser with trame. The plotter draws in this process and sends pictures to the browser. The
browser sends the events of the mouse back, so that the gizmos of the lights work there too.
"""

import pyvista as pv
from trame.app import get_server
from trame.ui.vuetify3 import VAppLayout
from trame_pyvista.ui import plotter_ui

import pvphong as ph

# %%
# The page
# --------
# ``plotter_ui`` puts a plotter into a page of your own. The gizmos need ``mode="server"``, which draws in this process.

server = get_server(client_type="vue3")


def serve(plotter: pv.Plotter) -> None:
    """Open a page with the plotter in a browser, until Ctrl-C."""
    with VAppLayout(server):
        plotter_ui(plotter, mode="server", server=server)
    server.start(port=0, open_browser=True)


# %%
# A torus with gizmos
# -------------------
# The picture shows what the page shows. Drag a light's position, its target or its cone; Ctrl-Z undoes. When this
# manual is built, nothing is served: the plotter is off screen.

plotter = pv.Plotter(window_size=(900, 560), lighting="none", off_screen=True)
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
torus = pv.ParametricTorus(ringradius=0.6, crosssectionradius=0.25, u_res=300, v_res=180)
plotter.phong.add_mesh(torus, ph.Material(ambient=0.2, diffuse=(0.75, 0.45, 0.3), specular=0.4, shininess=50))
plotter.camera_position = [(0, -3.6, 2.4), (0, 0, 0.1), (0, 0, 1)]
plotter.phong.add_gizmos(in_screenshots=True)
if not pv.OFF_SCREEN:
    serve(plotter)

# %%
# In Jupyter, ``plotter.show(jupyter_backend="server")`` does all of this below the cell. A page that also edits
# lights, materials and the scene is :doc:`the studio <studio>`.
