"""
Placing lights
==============

Start from a preset, drag the gizmos, keep the rig as a file.

When this manual is built, there is no window, and the script moves the lights. On your machine the window stays open
until you close it.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import pyvista as pv

import pvphong as ph

# %%
# A rig from a preset
# -------------------
# :func:`pvphong.three_point` returns a key, a fill and a rim light for a mesh, as seen by a viewer. They are
# fixed in the world. Each is an ordinary light; :func:`dataclasses.replace` returns it with other fields.

airplane = pv.examples.load_airplane()
x, y, z = airplane.center
camera = [(x + 1500, y - 2100, 1500), (x + 80, y - 60, z + 120), (0, 0, 1)]
viewer = ph.Viewer(position=camera[0], focal_point=camera[1], up=camera[2])
preset = [replace(light, intensity=0.7 * light.intensity) for light in ph.three_point(airplane, viewer)]
spot = ph.SpotLight(
    position=(x + 400, y - 900, 1000),
    direction=(-500, 900, -900),
    cone_angle=18,
    exponent=90,
    diffuse=(0.45, 0.75, 1.0),
    name="spot",
)
bulb = ph.PointLight(position=(x - 700, y - 600, 250), attenuation=(1, 0, 4e-6), diffuse=(1.0, 0.6, 0.3), name="bulb")

# %%
# Gizmos in the window
# --------------------
# Each light has handles, for its position, its target and its cone. Drag one, and the meshes are lit again. With Shift
# it moves along one axis, with Ctrl in steps; Escape cancels. ``in_screenshots=True`` draws the gizmos into pictures
# too. Code can change lights as the mouse does: each drag and each ``set_light`` is one step of undo. The spot is
# selected here, so that its whole cone is drawn.

floor = pv.Plane(center=(x, y, -80), i_size=4500, j_size=4500, i_resolution=240, j_resolution=240)
silver = ph.Material(ambient=0.1, diffuse=(0.75, 0.75, 0.78), specular=0.35, shininess=50)
plotter = pv.Plotter(window_size=(1100, 640), lighting="none")
plotter.set_background("#1c1f26")
plotter.phong.add_mesh(airplane, silver)
plotter.phong.add_mesh(floor, ph.Material(ambient=0.1, diffuse=(0.5, 0.5, 0.52)), feature_angle=None)
plotter.camera_position = camera
for light in (*preset, bulb, replace(spot, cone_angle=10)):
    plotter.phong.add_light(light)
gizmos = plotter.phong.add_gizmos(in_screenshots=True)
for gizmo in gizmos:
    print(f"{gizmo.light.name:5} can be dragged at its {', '.join(gizmo.handles)}")

plotter.phong.set_light("spot", spot)
plotter.phong.undo()
assert plotter.phong.lights[-1].cone_angle == 10
plotter.phong.redo()
for _ in gizmos:  # the key n selects the next light
    plotter.iren.interactor.SetKeySym("n")
    plotter.iren.interactor.InvokeEvent("KeyPressEvent")
    plotter.iren.interactor.InvokeEvent("CharEvent")
rig = plotter.phong.scene
plotter.show()

# %%
# The rig as a file
# -----------------
# ``plotter.phong.scene`` returns the lights, the viewer and the light model as they are now. ``save`` writes them as
# JSON, and ``ph.Scene.load`` returns an equal scene. ``pvphong shade other.stl -o other.png --scene rig.json`` lights
# another mesh with it.

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "rig.json"
    rig.save(path)
    assert ph.Scene.load(path) == rig
    print(f"the rig is {path.stat().st_size} bytes of JSON")
