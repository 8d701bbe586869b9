"""
Only what a scene needs
=======================

Scenes with more and more effects: which of them run, and what they cost.

Before anything is computed, a *plan* finds out which effects change the colours: a dull surface needs no viewer, a sun
needs no points, ambient light needs no normals. ``print(plan.explain())`` gives the reasons.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# Six scenes
# ----------
# From ambient light alone to everything at once: three lights, highlights, two sides, and a sheared model matrix.

DULL = ph.Material(ambient=(0.8, 0.5, 0.3), diffuse=(0.8, 0.5, 0.3))
SHINY = replace(DULL, specular=0.5, shininess=40)
VIEWER = ph.Viewer(position=(0, -4, 2))
SUN = ph.DirectionalLight(direction=(1, 1, -1), intensity=0.5, name="sun")
LAMP = ph.PointLight(position=(1, -2, 3), attenuation=(1, 0.1, 0.02), diffuse=(1.0, 0.9, 0.7), name="lamp")
SPOT = ph.SpotLight(
    position=(1, -2, 3), direction=(-1, 2, -3), cone_angle=7, exponent=8, attenuation=(1, 0.1, 0.02), name="spot"
)
ONE_SIDED, TWO_SIDED = ph.LightModel(), ph.LightModel(two_sided=True)
UNMOVED, SHEARED = np.eye(4), np.array([[1, 0.3, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
SCENES = {
    "ambient only": ([], DULL, ONE_SIDED, UNMOVED),
    "sun on a dull surface": ([SUN], DULL, ONE_SIDED, UNMOVED),
    "lamp on a dull surface": ([LAMP], DULL, ONE_SIDED, UNMOVED),
    "lamp, with highlights": ([LAMP], SHINY, ONE_SIDED, UNMOVED),
    "spot, with highlights": ([SPOT], SHINY, ONE_SIDED, UNMOVED),
    "everything on": ([SUN, LAMP, SPOT], SHINY, TWO_SIDED, SHEARED),
}


def draw(plotter: pv.Plotter, title: str, lit: pv.PolyData, matrix: np.ndarray, zoom: float) -> None:
    """Draw a lit mesh into the current subplot."""
    plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False).user_matrix = matrix
    plotter.add_text(title, position=(10, 8), font_size=10, color="black")
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(zoom)


mesh = pv.Sphere(theta_resolution=300, phi_resolution=300)
plotter = pv.Plotter(shape=(2, 3), window_size=(1020, 540), border=False)
for pane, (title, (lights, material, model, matrix)) in enumerate(SCENES.items()):
    scene = ph.Scene(lights, VIEWER, model)
    plotter.subplot(*divmod(pane, 3))
    draw(plotter, title, mesh.phong.shade(scene, material, matrix=matrix), matrix, 1.6)
    print(f"{title}: {mesh.phong.plan(scene, material, matrix=matrix)}\n")
plotter.set_background("white")
plotter.enable_anti_aliasing("ssaa")
plotter.show()

# %%
# What they cost
# --------------
# Each bar is the least of several times. All scenes are measured in turns, so that changes of the machine's speed
# affect all alike. The times are those of the machine that built this page; with the extra ``fast`` the loops are
# compiled.

BACKEND = "numba" if find_spec("numba") else "numpy"


def costs_of(calls: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the least milliseconds of each call."""
    for call in calls.values():
        call()  # the first may compile
    times: dict[str, list[float]] = {title: [] for title in calls}
    for _ in range(rounds):
        for title, call in calls.items():
            start = time.perf_counter()
            call()
            times[title].append(time.perf_counter() - start)
    return {title: min(taken) * 1e3 for title, taken in times.items()}


def chart(costs: dict[str, float], title: str, scale: str) -> None:
    """Draw a bar for each cost, the first on top."""
    _, axes = plt.subplots(figsize=(9, 0.45 * len(costs) + 1.0), layout="constrained")
    colors = ["#6b4c9a" if "rays" in name else "#4c72b0" for name in costs]
    axes.bar_label(axes.barh(list(costs), list(costs.values()), color=colors), fmt="%.3g ms", padding=4)
    axes.invert_yaxis()
    axes.set(xlabel="least time, ms", title=title, xscale=scale)
    axes.margins(x=0.15)
    axes.spines[["top", "right"]].set_visible(False)
    plt.show()


points, normals = np.asarray(mesh.points), np.asarray(mesh.point_data.active_normals)
calls = {
    title: partial(
        ph.evaluate, points, normals, ph.Scene(lights, VIEWER, model), material, matrix=matrix, backend=BACKEND
    )
    for title, (lights, material, model, matrix) in SCENES.items()
}
chart(costs_of(calls, 9), f"{mesh.n_points:,} vertices", "linear")

# %%
# Size, shadows, occlusion
# ------------------------
# A light with a size costs more than a point light, and rays cost more than light without shadows. The pictures show a
# point light, a ball-shaped light, their shadows, ambient occlusion, and everything together.

table = pv.Plane(center=(0, 0, -0.6), i_size=3, j_size=3, i_resolution=90, j_resolution=90).triangulate()
scenery = pv.merge([table, pv.Sphere(theta_resolution=50, phi_resolution=50)], merge_points=False)
BULB = ph.PointLight(position=(1.6, -1.2, 1.8), attenuation=(0, 0, 1), intensity=8, name="bulb")
BALL = ph.SphereLight(position=BULB.position, radius=0.35, intensity=8, name="ball")
BRIGHT = ph.LightModel(ambient=0.4)
TOLERANCE = 0.02
MORE = {
    "a bulb": ph.Scene([BULB], VIEWER, BRIGHT),
    "the bulb as a ball": ph.Scene([BALL], VIEWER, BRIGHT),
    "shadow of the bulb": ph.Scene([BULB], VIEWER, replace(BRIGHT, shadows=True)),
    "soft shadow of the ball": ph.Scene([BALL], VIEWER, replace(BRIGHT, shadows=True)),
    "ambient occlusion": ph.Scene([BULB], VIEWER, replace(BRIGHT, ambient_occlusion=True)),
    "soft shadow and occlusion": ph.Scene([BALL], VIEWER, replace(BRIGHT, shadows=True, ambient_occlusion=True)),
}
visibilities = {
    title: scenery.phong.visibility(scene, tolerance=TOLERANCE) if scene.light_model.needs_rays else None
    for title, scene in MORE.items()
}
plotter = pv.Plotter(shape=(2, 3), window_size=(1020, 540), border=False)
for pane, (title, scene) in enumerate(MORE.items()):
    plotter.subplot(*divmod(pane, 3))
    draw(plotter, title, scenery.phong.shade(scene, DULL, visibility=visibilities[title]), UNMOVED, 1.2)
plotter.set_background("white")
plotter.enable_anti_aliasing("ssaa")
plotter.show()

# %%
# Rays are cast once and kept
# ---------------------------
# Shadows and occlusion have two bars: one for casting the rays, one for lighting with their results. The axis is
# logarithmic.


def cast(scene: ph.Scene) -> None:
    """Cast all rays that a scene calls for."""
    seen = scenery.phong.visibility(scene, tolerance=TOLERANCE)
    if scene.light_model.shadows:
        seen.per_light  # noqa: B018 its first use casts the rays
    if scene.light_model.ambient_occlusion:
        seen.sky  # noqa: B018


points, normals = np.asarray(scenery.points), np.asarray(scenery.phong.normals())
calls = {
    title: partial(ph.evaluate, points, normals, scene, DULL, backend=BACKEND, visibility=visibilities[title])
    for title, scene in MORE.items()
}
costs = costs_of(calls, 9)
rays = costs_of({title: partial(cast, scene) for title, scene in MORE.items() if scene.light_model.needs_rays}, 1)
bars = {}
for title, cost in costs.items():
    bars[title] = cost
    if title in rays:
        bars[f"rays: {title}"] = rays[title]
chart(bars, f"{scenery.n_points:,} vertices; rays to a standard error of {TOLERANCE}", "log")
