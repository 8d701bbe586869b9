"""What accuracy costs in time, measured on a real mesh: evaluators, light models, refined meshes, VTK's own shading.

A lit airplane. Each marker of the figure's first row is one way to light it; the front is what one should choose from.
"""

import pyvista as pv
from arguments import FOLDER, WINDOW

import pvphong as ph

mesh = pv.examples.load_airplane()
scene = ph.Scene(
    lights=[
        ph.PointLight(position=(8e5, -4e5, 2e6), diffuse=(1.0, 0.95, 0.85), name="sun"),
        ph.PointLight(position=(1800, -600, 900), attenuation=(1, 0, 1e-6), diffuse=(0.5, 0.6, 0.9), name="lamp"),
        ph.PointLight(position=(0, 4000, 3000), diffuse=(0.0004, 0.0003, 0.0002), name="star"),
    ],
    viewer=ph.Viewer(position=(2500, -900, 1200), focal_point=(900, 650, 150), up=(0, 0, 1)),
    light_model=ph.LightModel(ambient=0.1),
)
plastic = ph.Material(ambient=0.1, diffuse=(0.2, 0.3, 0.8), specular=0.5, shininess=40)

report = mesh.phong.tradeoff(scene, plastic, tolerance=1 / 255, seconds=4)
print(report)

print("| way to light it | median time | largest error |\n|---|---:|---:|")
for row in report.rows:
    if row.on_front or row.error_bound:
        print(f"| {row.name} | {1e3 * row.time.median:.3g} ms | {row.error.largest:.2g} ({row.kind}) |")

picture = FOLDER / "accuracy_costs_time.png"
report.plot(picture)
print(f"wrote {picture}")
if WINDOW:
    pv.read(picture).plot(rgb=True, cpos="xy")
