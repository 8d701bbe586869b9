"""What it costs to keep a window's colours up to date, against VTK's own frame: `python bench_live.py`.

Bringing colours up to date is everything that happens before VTK draws: noticing what has changed, the plan, the
evaluation and the hand-over of the array. VTK's own frame draws the same mesh with VTK's lighting. The two are
measured in turns.
"""

import sys
import time
from statistics import median

import numpy as np
import pyvista as pv

import pvphong as ph

COUNT = 1_000_000
FRAMES = 7
ALLOWED = 0.05
SIZE = (1280, 800)

LIGHTS = [
    ph.DirectionalLight(direction=(-1, 1, -2), diffuse=(0.9, 0.9, 0.8), name="sun"),
    ph.PointLight(position=(2, -2, 1.5), attenuation=(1, 0.1, 0.02), diffuse=(1.0, 0.7, 0.5), name="bulb"),
    ph.SpotLight(position=(-2, -2, 2), direction=(2, 2, -2), cone_angle=30, exponent=8, name="spot"),
]
GLOSSY = ph.Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4), specular=0.5, shininess=40)
DULL = ph.Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4))


def wavy_sphere(count: int) -> pv.PolyData:
    """About this many vertices, with normals."""
    side = round(count**0.5)
    mesh = pv.Sphere(theta_resolution=side, phi_resolution=side)
    mesh.points *= 1 + 0.03 * np.sin(20 * mesh.points[:, :1]) * np.cos(17 * mesh.points[:, 1:2])
    return mesh.compute_normals(cell_normals=False, split_vertices=False)


def new_plotter() -> pv.Plotter:
    """An offscreen window with the lights."""
    plotter = pv.Plotter(off_screen=True, window_size=SIZE, lighting="none")
    for light in LIGHTS:
        plotter.phong.add_light(light)
    plotter.camera_position = [(0, -2.2, 1.0), (0, 0, 0), (0, 0, 1)]
    return plotter


def seconds_of(action) -> float:
    """Wall time of one call."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def main() -> int:
    """Measure; 0 if the costs are within what is allowed."""
    mesh = wavy_sphere(COUNT)
    ours, vtks, dull = (new_plotter() for _ in range(3))
    glossy = ours.phong.mesh(ours.phong.add_mesh(mesh, GLOSSY))
    actor = vtks.add_mesh(mesh, color="tan", specular=0.5, specular_power=40)
    actor.prop.interpolation = "Phong"
    orbited = dull.phong.mesh(dull.phong.add_mesh(mesh, DULL))
    for plotter in (ours, vtks, dull):
        plotter.show(auto_close=False)
    update, drawing, frame, orbit = [], [], [], []
    at_first = orbited.evaluations
    for _ in range(FRAMES):
        for plotter in (ours, vtks, dull):
            plotter.camera.azimuth += 3
        before = glossy.evaluations
        update.append(seconds_of(ours.phong._subplot.lit.refresh))
        assert glossy.evaluations == before + 1
        drawing.append(seconds_of(ours.render))
        assert glossy.evaluations == before + 1
        frame.append(seconds_of(vtks.render))
        orbit.append(seconds_of(dull.phong._subplot.lit.refresh))
        dull.render()
    evaluated = orbited.evaluations - at_first
    for plotter in (ours, vtks, dull):
        plotter.close()
    share = median(update) / median(frame)
    print(f"{mesh.n_points:,} vertices, {len(LIGHTS)} lights with highlights, {SIZE[0]} x {SIZE[1]} pixels, medians:")
    for what, times in {
        "colours brought up to date": update,
        "then drawn by VTK, unlit": drawing,
        "VTK's own frame, lit by VTK": frame,
        "noticing that nothing has changed": orbit,
    }.items():
        print(f"  {what:36}{median(times) * 1e3:10.2f} ms   ({min(times) * 1e3:.2f} to {max(times) * 1e3:.2f})")
    print(f"  share of VTK's own frame            {share:10.1%}     allowed {ALLOWED:.0%}")
    print(f"  evaluations while orbiting a dull mesh {evaluated:7}     allowed 0")
    return int(share > ALLOWED or evaluated > 0)


if __name__ == "__main__":
    sys.exit(main())
