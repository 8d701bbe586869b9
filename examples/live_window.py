"""Lit meshes in a window follow camera, lights and edits, and are computed again only when they have to be.

Here the window is offscreen and its mouse events are sent by hand. With `--window` it is yours: drag the lights, press
h for the keys.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN, WINDOW
from PIL import Image

import pvphong as ph

plotter = pv.Plotter(off_screen=OFF_SCREEN, window_size=(640, 400), lighting="none")
plotter.set_background("#242830")
lamp = ph.PointLight(
    position=(0.2, -1.5, 1.4), attenuation=(1, 0, 0.25), diffuse=(1.0, 0.75, 0.45), intensity=1.4, name="lamp"
)
plotter.phong.add_light(ph.DirectionalLight(direction=(1, 1, -0.6), diffuse=(0.35, 0.4, 0.55), name="sky"))
plotter.phong.add_light(lamp)

glossy = ph.Material(ambient=0.1, diffuse=(0.75, 0.25, 0.2), specular=0.6, shininess=60)
dull = ph.Material(ambient=0.1, diffuse=(0.3, 0.55, 0.4))
ball = plotter.phong.add_mesh(pv.Sphere(center=(-0.8, 0, 0), theta_resolution=90, phi_resolution=90), glossy)
cone = plotter.phong.add_mesh(
    pv.Cone(center=(0.5, 0, 0), direction=(0, 0, 1), resolution=80).triangulate().subdivide(3), dull
)
lit = [plotter.phong.mesh(actor) for actor in (ball, cone)]
plotter.add_mesh(pv.Cube(center=(1.6, 0, 0), x_length=0.7, y_length=0.7, z_length=0.7), color="tan")  # lit by VTK
plotter.camera_position = [(0.4, -4.6, 2.0), (0.4, 0, 0.3), (0, 0, 1)]
plotter.phong.add_gizmos(in_screenshots=True)
picture = FOLDER / "live_window.png"
if WINDOW:
    plotter.show(screenshot=picture)
    raise SystemExit
plotter.show(auto_close=False)


def report(what: str) -> None:
    """Draw a frame, and say how many meshes had to be lit again for it."""
    before = [mesh.evaluations for mesh in lit]
    plotter.render()
    evaluated = sum(mesh.evaluations for mesh in lit) - sum(before)
    print(f"{what:42}{evaluated} evaluated")


def drag(start: np.ndarray, by: tuple[int, int]) -> None:
    """Press, move and release the left button, as a window would report it."""
    steps = [start, start, start + np.array(by) / 2, start + np.array(by), start + np.array(by)]
    events = ["MouseMove", "LeftButtonPress", "MouseMove", "MouseMove", "LeftButtonRelease"]
    for (x, y), event in zip(steps, events, strict=True):
        plotter.iren.interactor.SetEventInformation(round(float(x)), round(float(y)))
        plotter.iren.interactor.InvokeEvent(event + "Event")


def pixel(point: tuple[float, float, float]) -> np.ndarray:
    """Where a point of the world is in the window."""
    plotter.renderer.SetWorldPoint(*point, 1.0)
    plotter.renderer.WorldToDisplay()
    return np.array(plotter.renderer.GetDisplayPoint()[:2])


def panel(caption: str) -> np.ndarray:
    """What is seen now, with a caption."""
    text = plotter.add_text(caption, position=(12, 370), font_size=11, color="white")
    image = plotter.screenshot(return_img=True)
    plotter.remove_actor(text)
    return image


report("nothing has changed:")
plotter.camera.azimuth = 8
report("the camera moved, the ball has a highlight:")
cone.rotate_z(20)
report("the cone turned:")
plotter.phong.mesh(cone).material = ph.Material(ambient=0.1, diffuse=(0.3, 0.4, 0.75))
report("the cone has another material:")
plotter.phong.set_light("sky", ph.DirectionalLight(direction=(1, 1, -0.6), diffuse=(0.25, 0.35, 0.7), name="sky"))
report("the sky has another colour:")

gizmo = next(gizmo for gizmo in plotter.phong.gizmos if gizmo.light.name == "lamp")
colors = ball.mapper.dataset["phong"].copy()
pictures = [panel("as the script set it up")]
drag(pixel(gizmo.handles["position"]), (-170, -25))
print("the lamp was dragged to", np.round(gizmo.light.position, 2))
pictures.append(panel("the lamp dragged to the left"))
highlight = gizmo.highlight
drag(pixel(highlight), (25, -20))
print("for the highlight to move, the lamp moved to", np.round(gizmo.light.position, 2))
pictures.append(panel("its highlight dragged: the lamp moved for it"))
plotter.phong.undo()
plotter.phong.undo()
assert gizmo.light == lamp
assert (ball.mapper.dataset["phong"] == colors).all()
pictures.append(panel("undone twice: as at first, to the bit"))
plotter.close()

Image.fromarray(np.vstack([np.hstack(pictures[:2]), np.hstack(pictures[2:])])).save(picture)
print(f"wrote {picture}")
