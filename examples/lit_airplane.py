"""
A lit airplane
==============

Light a mesh with a sun and a lamp. The colours are an array, one row for each point, and the picture shows that array.
"""

import pyvista as pv

import pvphong as ph

# %%
# The mesh
# --------
# pvphong lights any PyVista mesh. It uses the mesh's point normals, or computes them from the faces.

mesh = pv.examples.load_airplane()

# %%
# Lights, a viewer, a material
# ----------------------------
# A :class:`pvphong.Scene` has the lights, the viewer and the light model. The viewer matters for highlights, which move
# with it. All coordinates are in the mesh's coordinate system and unit.

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

# %%
# Colours as an array
# -------------------
# ``mesh.phong.shade`` returns a new mesh. Its array ``"phong"`` holds red, green and blue in [0, 1], linear, float32.

lit = mesh.phong.shade(scene, plastic)
colors = lit["phong"]
print(f"{len(colors)} colours, {colors.dtype}, from {colors.min(axis=0)} to {colors.max(axis=0)}")

# %%
# The picture
# -----------
# ``lighting=False`` switches VTK's own light off, so the picture shows the colours of the array and nothing else.

plotter = pv.Plotter(window_size=(1000, 560))
plotter.set_background("#dce6f2")
plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False)
plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.camera.zoom(1.5)
plotter.enable_anti_aliasing("ssaa")
plotter.show()

# %%
# ``lit.phong.plot()`` does the same in one call. ``lit.save("lit.vtp")`` keeps the colours in a file.
