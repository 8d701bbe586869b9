"""Only what a scene calls for: scenes on one mesh, which effects each runs, and what they cost.

The plan leaves out what adds nothing: a dull surface needs no viewer, a sun needs no points, ambient light needs
no normals. The measure of the first chart is a scene that calls for everything but rays at once.

The second chart has what else a scene may call for, on a logarithmic axis: a light with a size, and rays, which are
cast once and kept. Of shadows and of occlusion it has two bars, casting the rays and reading again what they found.

With the extras `fast` and `rays` the numbers are smaller.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec

import numpy as np
import pyvista as pv
from arguments import FOLDER, WINDOW
from matplotlib.axes import Axes
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
# What else a scene may call for, each beside the same scene without it.
TABLE = pv.Plane(center=(0, 0, -0.6), i_size=3, j_size=3, i_resolution=90, j_resolution=90).triangulate()
SET = pv.merge([TABLE, pv.Sphere(center=(0, 0, 0), theta_resolution=50, phi_resolution=50)], merge_points=False)
BULB = ph.PointLight(position=(1.6, -1.2, 1.8), attenuation=(0, 0, 1), intensity=8, name="bulb")
BALL = ph.SphereLight(position=BULB.position, radius=0.35, intensity=8, name="ball")
BRIGHT = ph.LightModel(ambient=0.4)
MORE = {
    "a bulb, and nothing else": ([BULB], BRIGHT),
    "size: the bulb as a ball": ([BALL], BRIGHT),
    "shadow of the bulb": ([BULB], replace(BRIGHT, shadows=True)),
    "soft shadow of the ball": ([BALL], replace(BRIGHT, shadows=True)),
    "ambient occlusion": ([BULB], replace(BRIGHT, ambient_occlusion=True)),
}
ROUNDS, FEW_ROUNDS = 9, 2
TOLERANCE = 0.02  # of the colours that rays are cast for
BACKEND = "numba" if find_spec("numba") else "numpy"  # by name: "auto" would change over once compiled code is there


def costs_of(calls: dict[str, Callable[[], object]], rounds: int = ROUNDS) -> dict[str, float]:
    """Milliseconds that each call takes, the least of several; in turns, so that all meet the same machine."""
    for call in calls.values():
        call()  # the first may compile
    times: dict[str, list[float]] = {title: [] for title in calls}
    for _ in range(rounds):
        for title, call in calls.items():
            start = time.perf_counter()
            call()
            times[title].append(time.perf_counter() - start)
    return {title: min(taken) * 1e3 for title, taken in times.items()}


def picture(mesh: pv.PolyData, scene: ph.Scene, material: ph.Material, zoom: float, **how: object) -> np.ndarray:
    """What the viewer sees."""
    plotter = pv.Plotter(off_screen=True, window_size=(320, 240))
    lit = mesh.phong.shade(scene, material, **how)
    plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False).user_matrix = how.get("matrix", UNMOVED)
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(zoom)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return image


def cast(mesh: pv.PolyData, scene: ph.Scene) -> None:
    """Cast all rays that the scene calls for."""
    model, seen = scene.light_model, mesh.phong.visibility(scene, tolerance=TOLERANCE)
    if model.shadows:
        seen.per_light  # noqa: B018
    if model.ambient_occlusion:
        seen.sky  # noqa: B018


def draw_bars(axes: Axes, costs: dict[str, float], labels: list[str], title: str) -> None:
    """A bar for each cost, the first on top."""
    bars = axes.barh(
        list(costs), list(costs.values()), color=["#6b4c9a" if "rays" in name else "#4c72b0" for name in costs]
    )
    axes.bar_label(bars, labels, padding=4)
    axes.invert_yaxis()
    axes.set(xlabel="least time, ms", title=title)
    axes.spines[["top", "right"]].set_visible(False)


mesh = pv.Sphere(theta_resolution=400, phi_resolution=400)
points, normals = np.asarray(mesh.points), np.asarray(mesh.point_data.active_normals)
calls, pictures, plans = {}, [], {}
for title, (lights, material, model, matrix) in SCENES.items():
    scene = ph.Scene(lights=lights, viewer=VIEWER, light_model=model)
    plans[title] = ph.plan(mesh, scene, material, matrix=matrix)
    calls[title] = partial(ph.evaluate, points, normals, scene, material, matrix=matrix, backend=BACKEND)
    pictures.append(picture(mesh, scene, material, 1.9, matrix=matrix))
costs = costs_of(calls)
for title, plan in plans.items():
    part = f"{costs[title] / costs[EVERYTHING]:.0%} of the {costs[EVERYTHING]:.2f} ms with everything on"
    print(f"{title}: {costs[title]:.2f} ms, {part}\n{plan.explain()}")

set_points, set_normals = np.asarray(SET.points), np.asarray(SET.phong.normals())
reading, casting, more_pictures = {}, {}, []
for title, (lights, model) in MORE.items():
    scene = ph.Scene(lights, VIEWER, model)
    seen = SET.phong.visibility(scene, tolerance=TOLERANCE)
    how = {"backend": BACKEND, "visibility": seen if model.needs_rays else None}
    reading[title] = partial(ph.evaluate, set_points, set_normals, scene, DULL, **how)
    more_pictures.append(picture(SET, scene, DULL, 1.2, visibility=how["visibility"]))
    if model.needs_rays:
        casting[f"its rays: {title}"] = partial(cast, SET, scene)
more = costs_of(reading) | costs_of(casting, FEW_ROUNDS)
more = {name: more[name] for title in MORE for name in (title, f"its rays: {title}") if name in more}
for title, cost in more.items():
    print(f"{title}: {cost:.2f} ms")

figure = Figure(figsize=(11, 10), layout="constrained")
parts = figure.subfigures(4, 1, height_ratios=(0.9, 1.5, 0.9, 1.6))
for part, titles, images in ((parts[0], costs, pictures), (parts[2], MORE, more_pictures)):
    for axes, title, image in zip(part.subplots(1, len(images)), titles, images, strict=True):
        axes.imshow(image)
        axes.set_axis_off()
        axes.set_title(title, fontsize=9)
everything = costs[EVERYTHING]
axes = parts[1].subplots()
draw_bars(
    axes, costs, [f"{cost:.2f} ms, {cost / everything:.0%}" for cost in costs.values()], f"{mesh.n_points:,} vertices"
)
axes.set_xlim(0, 1.3 * everything)
axes = parts[3].subplots()
draw_bars(
    axes,
    more,
    [f"{cost:.3g} ms" for cost in more.values()],
    f"{SET.n_points:,} vertices that may hide each other's light; rays to a standard error of {TOLERANCE}",
)
axes.set(xscale="log", xlim=(min(more.values()) / 2, 4 * max(more.values())))
path = FOLDER / "only_what_it_needs.png"
figure.savefig(path, dpi=120)
print(f"wrote {path}")
if WINDOW:
    pv.read(path).plot(rgb=True, cpos="xy")
