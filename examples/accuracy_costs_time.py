"""
What accuracy costs in time
===========================

Measure evaluators, light models, refined meshes and VTK's own shading on one mesh, and choose the fastest that is
accurate enough.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import pyvista as pv

import pvphong as ph

# %%
# The scene to measure
# --------------------
# A sun that is far away, a lamp nearby, and a star that adds next to nothing. The tolerance is one step of an 8-bit
# colour.

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

# %%
# One call
# --------
# ``tradeoff`` measures for a given number of seconds. It measures the candidates in turns, so that changes of the
# machine's speed affect all alike. The report recommends a candidate.

report = mesh.phong.tradeoff(scene, plastic, tolerance=1 / 255, seconds=4)
print(report)

# %%
# The candidates
# --------------
# A row is on the front if no other row is both faster and more accurate. The times are those of the machine that
# built this page.

for row in report.rows:
    if row.on_front or row.error_bound:
        print(f"{row.name:32} {1e3 * row.time.median:8.3g} ms, largest error {row.error.largest:.2g} ({row.kind})")

# %%
# The figure
# ----------
# ``report.plot`` writes a figure. Its first row has the candidates and their fronts, separately for errors of
# arithmetic, of the light model, and of interpolation inside triangles. The second row shows where the errors are. The
# third has their distribution, and the cost of each effect.

with tempfile.TemporaryDirectory() as folder:
    report.plot(Path(folder) / "report.png")
    image = plt.imread(Path(folder) / "report.png")
figure = plt.figure(figsize=(image.shape[1] / 100, image.shape[0] / 100), dpi=100)
figure.figimage(image)
plt.show()
