"""Place lights by hand: start from a preset, drag the gizmos, keep the rig as a file.

Here the window is offscreen and the hand is a script. With `--window` it is yours at the end of the script.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

airplane = pv.examples.load_airplane()
x, y, z = airplane.center
floor = pv.Plane(center=(x, y, -80), i_size=4500, j_size=4500, i_resolution=300, j_resolution=300)

plotter = pv.Plotter(off_screen=OFF_SCREEN, window_size=(1100, 640), lighting="none")
plotter.set_background("#1c1f26")
plotter.phong.add_mesh(airplane, ph.Material(ambient=0.1, diffuse=(0.75, 0.75, 0.78), specular=0.35, shininess=50))
plotter.phong.add_mesh(floor, ph.Material(ambient=0.1, diffuse=(0.5, 0.5, 0.52)))
plotter.camera_position = [(x + 2300, y - 3000, 2300), (x + 50, y, z + 250), (0, 0, 1)]

spot = ph.SpotLight(
    position=(x + 400, y - 900, 1000),
    direction=(-300, 800, -900),
    cone_angle=14,
    exponent=60,
    diffuse=(0.45, 0.75, 1.0),
    name="spot",
)
bulb = ph.PointLight(position=(x - 900, y - 700, 350), attenuation=(1, 0, 4e-6), diffuse=(1.0, 0.6, 0.3), name="bulb")
for light in (*ph.three_point(airplane, plotter.phong.scene.viewer), bulb, spot):
    plotter.phong.add_light(light)
for light in plotter.phong.lights[:3]:
    plotter.phong.set_light(light.name, replace(light, intensity=0.6 * light.intensity))

gizmos = plotter.phong.add_gizmos(in_screenshots=True)
plotter.show(auto_close=False)
for gizmo in gizmos:
    names = ", ".join(gizmo.handles)
    print(f"{gizmo.light.name:5} can be dragged at its {names}")

# What a hand does with the mouse, code does with values; either is one step of undo.
plotter.phong.set_light("spot", replace(spot, cone_angle=18, direction=(-500, 900, -900)))
plotter.phong.undo()
assert plotter.phong.lights[-1] == spot
plotter.phong.redo()

plotter.iren.interactor.SetKeySym("n")  # select the last light: its whole cone is shown
for _ in gizmos:
    for event in ("KeyPressEvent", "CharEvent"):
        plotter.iren.interactor.InvokeEvent(event)

with tempfile.TemporaryDirectory() as kept:
    rig = Path(kept) / "rig.json"
    plotter.phong.scene.save(rig)
    assert ph.Scene.load(rig) == plotter.phong.scene  # to the last bit
    print(f"the rig is {rig.stat().st_size} bytes of JSON")

picture = FOLDER / "place_lights.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
