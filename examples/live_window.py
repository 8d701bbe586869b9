"""
A live window
=============

Meshes in a plotter follow the lights, the camera and your edits. Their colours are computed again only when something
changes on which they depend.
"""

# sphinx_gallery_thumbnail_number = 2

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A window with gizmos
# --------------------
# Drag the lamp or the highlight on the ball. Press h for the keys. The cube is an ordinary PyVista actor: VTK lights
# it, with the same lights.

lamp = ph.PointLight(
    position=(0.2, -1.5, 1.4), attenuation=(1, 0, 0.25), diffuse=(1.0, 0.75, 0.45), intensity=1.4, name="lamp"
)
sky = ph.DirectionalLight(direction=(1, 1, -0.6), diffuse=(0.35, 0.4, 0.55), name="sky")
glossy = ph.Material(ambient=0.1, diffuse=(0.75, 0.25, 0.2), specular=0.6, shininess=60)
dull = ph.Material(ambient=0.1, diffuse=(0.3, 0.55, 0.4))


def window(**options: object) -> pv.Plotter:
    """Return a plotter with a ball, a cone and a cube under two lights."""
    plotter = pv.Plotter(window_size=(640, 400), lighting="none", **options)
    plotter.set_background("#242830")
    plotter.phong.add_light(sky)
    plotter.phong.add_light(lamp)
    ball = pv.Sphere(center=(-0.8, 0, 0), theta_resolution=90, phi_resolution=90)
    cone = pv.Cone(center=(0.5, 0, 0), direction=(0, 0, 1), resolution=80).triangulate().subdivide(3)
    plotter.phong.add_mesh(ball, glossy, name="ball")
    plotter.phong.add_mesh(cone, dull, name="cone")
    plotter.add_mesh(pv.Cube(center=(1.6, 0, 0), x_length=0.7, y_length=0.7, z_length=0.7), color="tan")
    plotter.camera_position = [(0.4, -4.6, 2.0), (0.4, 0, 0.3), (0, 0, 1)]
    plotter.phong.add_gizmos(in_screenshots=True)
    return plotter


window().show()

# %%
# The same window, by a script
# ----------------------------
# Here a script sends the events of the mouse. It drags the lamp to the left, then the highlight, which moves the lamp
# again, and undoes both. Undoing restores exactly the same colours.


def drag(plotter: pv.Plotter, start: np.ndarray, by: tuple[int, int], steps: int = 8) -> None:
    """Press, move and release the left button, and write a frame for each step."""
    path = [start + np.array(by) * step / steps for step in range(steps + 1)]
    events = [(path[0], "MouseMove"), (path[0], "LeftButtonPress")]
    events += [(place, "MouseMove") for place in path[1:]] + [(path[-1], "LeftButtonRelease")]
    for place, event in events:
        plotter.iren.interactor.SetEventInformation(*np.rint(place).astype(int).tolist())
        plotter.iren.interactor.InvokeEvent(f"{event}Event")
        if event == "MouseMove" and place is not path[0]:
            plotter.write_frame()


def pixel(plotter: pv.Plotter, point: tuple[float, float, float]) -> np.ndarray:
    """Return where a point of the world is in the window."""
    plotter.renderer.SetWorldPoint(*point, 1.0)
    plotter.renderer.WorldToDisplay()
    return np.array(plotter.renderer.GetDisplayPoint()[:2])


plotter = window(off_screen=True)
plotter.show(auto_close=False)
plotter.open_gif("dragged_lamp.gif", fps=8)
gizmo = next(gizmo for gizmo in plotter.phong.gizmos if gizmo.light.name == "lamp")
ball = plotter.actors["ball"]
colors = ball.mapper.dataset["phong"].copy()
drag(plotter, pixel(plotter, gizmo.handles["position"]), (-170, -25))
print("the lamp was dragged to", np.round(gizmo.light.position, 2))
drag(plotter, pixel(plotter, gizmo.highlight), (25, -20))
print("for the highlight to move, the lamp moved to", np.round(gizmo.light.position, 2))
for _ in range(2):
    plotter.phong.undo()
    plotter.write_frame()
assert gizmo.light == lamp
assert (ball.mapper.dataset["phong"] == colors).all()
plotter.close()

# %%
# Lit again only when needed
# --------------------------
# A mesh counts how often it is lit. The colours of the dull cone do not depend on the camera. Those of the glossy ball
# do, because its highlight moves with the viewer. Turning an actor, or giving it another material, lights this mesh
# again; a change of a light lights all of them.

plotter = window(off_screen=True)
lit = {name: plotter.phong.mesh(plotter.actors[name]) for name in ("ball", "cone")}
plotter.show(auto_close=False)


def report(change: str) -> None:
    """Draw a frame, and print which meshes were lit again for it."""
    before = {name: mesh.evaluations for name, mesh in lit.items()}
    plotter.render()
    again = [name for name, mesh in lit.items() if mesh.evaluations > before[name]]
    print(f"{change:35} {' and '.join(again) or 'nothing'} lit again")


report("nothing has changed:")
plotter.camera.azimuth = 12
report("the camera moved:")
plotter.actors["cone"].rotate_z(20)
report("the cone turned:")
lit["cone"].material = ph.Material(ambient=0.1, diffuse=(0.3, 0.4, 0.75))
report("the cone has another material:")
plotter.phong.set_light("sky", ph.DirectionalLight(direction=(1, 1, -0.6), diffuse=(0.25, 0.35, 0.7), name="sky"))
report("the sky has another colour:")
