"""Only what a scene calls for: five scenes on one mesh, which effects each runs, and what they cost.

The measure is a sixth one that calls for everything at once.

The plan leaves out what adds nothing: a dull surface needs no viewer, a sun needs no points, ambient light needs
no normals. Needs matplotlib for the chart (the extra `plot`); with the extra `fast` the numbers are smaller.
"""

import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec

import numpy as np
import pyvista as pv
from arguments import FOLDER, WINDOW
from matplotlib.figure import Figure

import pvphong as ph

DULL = ph.Material(ambient=(0.8, 0.5, 0.3), diffuse=(0.8, 0.5, 0.3))
SHINY = ph.Material(ambient=(0.8, 0.5, 0.3), diffuse=(0.8, 0.5, 0.3), specular=0.5, shininess=40)
VIEWER = ph.Viewer(position=(0, -4, 2))
SUN = ph.DirectionalLight(direction=(1, 1, -1), intensity=0.5, name="sun")
LAMP = ph.PointLight(position=(1, -2, 3), attenuation=(1, 0.1, 0.02), diffuse=(1.0, 0.9, 0.7), name="lamp")
SPOT = ph.SpotLight(
    position=(1, -2, 3), direction=(-1, 2, -3), cone_angle=7, exponent=8, attenuation=(1, 0.1, 0.02), name="spot"
)
ONE_SIDED, TWO_SIDED = ph.LightModel(), ph.LightModel(two_sided=True)
UNMOVED, SHEARED = np.eye(4), np.array([[1, 0.3, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
EVERYTHING = "everything on"
SCENES = {
    "ambient only": ([], DULL, ONE_SIDED, UNMOVED),
    "sun on a dull surface": ([SUN], DULL, ONE_SIDED, UNMOVED),
    "lamp on a dull surface": ([LAMP], DULL, ONE_SIDED, UNMOVED),
    "lamp, with highlights": ([LAMP], SHINY, ONE_SIDED, UNMOVED),
    "spot, with highlights": ([SPOT], SHINY, ONE_SIDED, UNMOVED),
    EVERYTHING: ([SUN, LAMP, SPOT], SHINY, TWO_SIDED, SHEARED),
}
ROUNDS = 40
BACKEND = "numba" if find_spec("numba") else "numpy"  # by name: "auto" would change over once compiled code is there


def costs_of(calls: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Milliseconds that each call takes, the least of several; in turns, so that all meet the same machine."""
    for call in calls.values():
        call()  # the first may compile
    times: dict[str, list[float]] = {title: [] for title in calls}
    for _ in range(ROUNDS):
        for title, call in calls.items():
            start = time.perf_counter()
            call()
            times[title].append(time.perf_counter() - start)
    return {title: min(taken) * 1e3 for title, taken in times.items()}


def picture(mesh: pv.PolyData, scene: ph.Scene, material: ph.Material, matrix: np.ndarray) -> np.ndarray:
    """What the viewer sees."""
    plotter = pv.Plotter(off_screen=True, window_size=(320, 240))
    lit = mesh.phong.shade(scene, material, matrix=matrix)
    plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False).user_matrix = matrix
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(1.9)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return image


mesh = pv.Sphere(theta_resolution=600, phi_resolution=600)
points, normals = np.asarray(mesh.points), np.asarray(mesh.point_data.active_normals)
calls, pictures, plans = {}, [], {}
for title, (lights, material, model, matrix) in SCENES.items():
    scene = ph.Scene(lights=lights, viewer=VIEWER, light_model=model)
    plans[title] = ph.plan(mesh, scene, material, matrix=matrix)
    calls[title] = partial(ph.evaluate, points, normals, scene, material, matrix=matrix, backend=BACKEND)
    pictures.append(picture(mesh, scene, material, matrix))
costs = costs_of(calls)
for title, plan in plans.items():
    part = f"{costs[title] / costs[EVERYTHING]:.0%} of the {costs[EVERYTHING]:.2f} ms with everything on"
    print(f"{title}: {costs[title]:.2f} ms, {part}\n{plan.explain()}")

figure = Figure(figsize=(11, 5.4), layout="constrained")
seen, chart = figure.subfigures(2, 1, height_ratios=(1, 1.6))
for axes, title, image in zip(seen.subplots(1, len(pictures)), costs, pictures, strict=True):
    axes.imshow(image)
    axes.set_axis_off()
    axes.set_title(title, fontsize=9)
axes = chart.subplots()
bars = axes.barh(list(costs), list(costs.values()), color="#4c72b0")
everything = costs[EVERYTHING]
axes.bar_label(bars, [f"{value:.2f} ms, {value / everything:.0%}" for value in costs.values()], padding=4)
axes.invert_yaxis()
axes.set(xlabel="least time, ms", title=f"{mesh.n_points:,} vertices", xlim=(0, 1.3 * everything))
axes.spines[["top", "right"]].set_visible(False)
path = FOLDER / "only_what_it_needs.png"
figure.savefig(path, dpi=120)
print(f"wrote {path}")
if WINDOW:
    pv.read(path).plot(rgb=True, cpos="xy")
