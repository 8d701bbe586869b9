"""Many files: a wave in forty pieces, four moments of ten tiles, lit by the processes of a local Dask cluster.

A .pvd file names the tiles by their times. Each is lit by whoever is free; along their borders the tiles of one moment
get the normals of the surface in one piece, so no seam is seen. Run again, a finished file is not lit again. The
dashboard at the address that is printed shows the work as it goes on. Any other cluster does as well: give its client.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN
from distributed import Client, LocalCluster

import pvphong as ph

TIMES, TILES, SIDE = (0.1, 0.3, 0.5, 0.8), 10, 40
SCENE = ph.Scene(
    [
        ph.DirectionalLight(direction=(-1.0, 0.6, -0.7), diffuse=(1.0, 0.85, 0.65), name="low sun"),
        ph.DirectionalLight(direction=(0.5, -0.5, -1.0), diffuse=(0.15, 0.25, 0.45), name="sky"),
    ],
    ph.Viewer(position=(6.0, -8.5, 7.5), focal_point=(0, 0, 0), up=(0, 0, 1)),
    ph.LightModel(ambient=0.1, reflection="blinn-phong"),
)
WATER = ph.Material(ambient=(0.1, 0.3, 0.4), diffuse=(0.1, 0.45, 0.6), specular=0.7, shininess=60)


def tile(number: int, time: float) -> pv.PolyData:
    """A tenth of the water at one moment: two rows of five."""
    row, column = divmod(number, TILES // 2)
    x = np.linspace(-5, 5, (TILES // 2) * SIDE + 1)[column * SIDE : (column + 1) * SIDE + 1]
    y = np.linspace(-5, 5, 4 * SIDE + 1)[row * 2 * SIDE : (row + 1) * 2 * SIDE + 1]
    x, y = np.meshgrid(x, y, indexing="ij")
    far = np.hypot(x + 1, y - 1)
    z = 0.55 * np.exp(-0.25 * (far - 5 * time) ** 2) * np.cos(4 * (far - 5 * time)) + 0.06 * np.sin(5 * x + 9 * time)
    return pv.StructuredGrid(x, y, z).extract_surface(algorithm=None)


def write_series(folder: Path) -> Path:
    """Forty files, and the one that names them."""
    lines = []
    for time in TIMES:
        for number in range(TILES):
            name = f"tile_{time}_{number}.vtp"
            tile(number, time).save(folder / name)
            lines.append(f'<DataSet timestep="{time}" part="{number}" file="{name}"/>')
    index = folder / "wave.pvd"
    index.write_text(f'<VTKFile type="Collection">\n<Collection>{"".join(lines)}</Collection>\n</VTKFile>\n')
    return index


def draw(lit: Path, picture: Path) -> None:
    """The four moments."""
    reader = pv.get_reader(lit)
    plotter = pv.Plotter(shape=(2, 2), off_screen=OFF_SCREEN, window_size=(1200, 800), border=False)
    for subplot, time in enumerate(TIMES):
        plotter.subplot(*divmod(subplot, 2))
        plotter.set_background("#101820")
        reader.set_active_time_point(subplot)
        for piece in reader.read():
            plotter.add_mesh(piece, scalars="phong", rgb=True, lighting=False)
        plotter.camera_position = [SCENE.viewer.position, SCENE.viewer.focal_point, SCENE.viewer.up]
        plotter.camera.zoom(1.1)
        plotter.add_text(f"time {time}", position=(12, 12), font_size=12, color="white")
    plotter.enable_anti_aliasing("ssaa")
    plotter.show(screenshot=picture)


if __name__ == "__main__":  # the workers' processes read this file, too
    with (
        TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster,
    ):
        print(f"dashboard: {cluster.dashboard_link}")
        wave, out = write_series(Path(folder)), Path(folder, "lit")
        with Client(cluster) as client:
            for _ in range(2):
                print(ph.shade_files(wave, out, SCENE, WATER, client=client))
        draw(out / "wave.pvd", FOLDER / "many_files.png")
    print(f"wrote {FOLDER / 'many_files.png'}")
