"""Light a mesh: a sun, a lamp, a plastic airplane. Its colours are an array, and the picture shows just that array."""

import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

mesh = pv.examples.load_airplane()
scene = ph.Scene(
    lights=[
        ph.DirectionalLight(direction=(-1, -1, -2), diffuse="white", name="sun"),
        ph.SpotLight(
            position=(900, 600, 900),
            direction=(0, 0, -1),
            cone_angle=25,
            exponent=8,
            attenuation=(1, 0, 1e-7),
            diffuse=(1.0, 0.8, 0.5),
            name="lamp",
        ),
    ],
    viewer=ph.Viewer(position=(2500, -900, 1200), focal_point=(900, 650, 150), up=(0, 0, 1)),
    light_model=ph.LightModel(ambient=0.1, reflection="blinn-phong"),
)
plastic = ph.Material(ambient=0.1, diffuse=(0.2, 0.3, 0.8), specular=0.5, shininess=40)

lit = mesh.phong.shade(scene, plastic)
colors = lit["phong"]
print(f"{len(colors)} colours, {colors.dtype}, from {colors.min(axis=0)} to {colors.max(axis=0)}")

plotter = pv.Plotter(off_screen=OFF_SCREEN, window_size=(1000, 560))
plotter.set_background("#dce6f2")
plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False)  # VTK's own light is off: these are our colours
plotter.camera.position = scene.viewer.position
plotter.camera.focal_point = scene.viewer.focal_point
plotter.camera.up = scene.viewer.up
plotter.camera.view_angle = scene.viewer.view_angle
plotter.camera.zoom(1.5)  # a narrower picture; nothing moves
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "lit_airplane.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
