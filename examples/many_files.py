"""
Many files
==========

A wave in forty files, ten tiles at each of four times, lit by a Dask cluster without a seam.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyvista as pv
from distributed import Client

import pvphong as ph

# %%
# Forty files and an index
# ------------------------
# Each tile is a tenth of the water at one time. A ``.pvd`` file, as simulations write it, names the tiles and their
# times.

TIMES, TILES, SIDE = (0.1, 0.3, 0.5, 0.8), 10, 40


def tile(number: int, time: float) -> pv.PolyData:
    """Return a tenth of the water: two rows of five tiles."""
    row, column = divmod(number, TILES // 2)
    x = np.linspace(-5, 5, (TILES // 2) * SIDE + 1)[column * SIDE : (column + 1) * SIDE + 1]
    y = np.linspace(-5, 5, 4 * SIDE + 1)[row * 2 * SIDE : (row + 1) * 2 * SIDE + 1]
    x, y = np.meshgrid(x, y, indexing="ij")
    far = np.hypot(x + 1, y - 1)
    z = 0.55 * np.exp(-0.25 * (far - 5 * time) ** 2) * np.cos(4 * (far - 5 * time)) + 0.06 * np.sin(5 * x + 9 * time)
    return pv.StructuredGrid(x, y, z).extract_surface(algorithm=None)


temporary = TemporaryDirectory()
folder = Path(temporary.name)
lines = []
for time in TIMES:
    for number in range(TILES):
        name = f"tile_{time}_{number}.vtp"
        tile(number, time).save(folder / name)
        lines.append(f'<DataSet timestep="{time}" part="{number}" file="{name}"/>')
wave = folder / "wave.pvd"
wave.write_text(f'<VTKFile type="Collection">\n<Collection>{"".join(lines)}</Collection>\n</VTKFile>\n')

# %%
# Light them on a cluster
# -----------------------
# Any Dask client works. This one runs two workers in this process; ``Client("tcp://head:8786")`` uses the machines of a
# cluster, and ``workers=4`` in place of ``client=`` starts four processes. Along their borders, the tiles of one time
# get the normals of the whole surface. The second call finds that everything is done.

scene = ph.Scene(
    [
        ph.DirectionalLight(direction=(-1.0, 0.6, -0.7), diffuse=(1.0, 0.85, 0.65), name="low sun"),
        ph.DirectionalLight(direction=(0.5, -0.5, -1.0), diffuse=(0.15, 0.25, 0.45), name="sky"),
    ],
    ph.Viewer(position=(6.0, -8.5, 7.5), focal_point=(0, 0, 0), up=(0, 0, 1)),
    ph.LightModel(ambient=0.1, reflection="blinn-phong"),
)
water = ph.Material(ambient=(0.1, 0.3, 0.4), diffuse=(0.1, 0.45, 0.6), specular=0.7, shininess=60)

with Client(processes=False, n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
    for _ in range(2):
        print(ph.shade_files(wave, folder / "lit", scene, water, client=client))

# %%
# The four times
# --------------
# The index is written too, so PyVista and ParaView read the lit series as they read the original.

reader = pv.get_reader(folder / "lit" / "wave.pvd")
plotter = pv.Plotter(shape=(2, 2), window_size=(1200, 800), border=False)
for subplot, time in enumerate(TIMES):
    plotter.subplot(*divmod(subplot, 2))
    plotter.set_background("#101820")
    reader.set_active_time_point(subplot)
    for piece in reader.read():
        plotter.add_mesh(piece, scalars="phong", rgb=True, lighting=False)
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
    plotter.camera.zoom(1.1)
    plotter.add_text(f"time {time}", position=(12, 12), font_size=12, color="white")
plotter.enable_anti_aliasing("ssaa")
plotter.show()
temporary.cleanup()
