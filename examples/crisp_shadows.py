"""
Crisp shadows
=============

With colours at vertices, the edge of a shadow is a saw. ``refine`` cuts the triangles along the edge, so that it is
crisp with the same number of points.

The shadow of a ball under a point light has a known edge, a conic. So the area with the wrong colour can be measured.
"""

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A lamp, a ball, a floor
# -----------------------

LAMP = ph.PointLight(position=(-1.2, 0.8, 3.2), name="lamp")
VIEWER = ph.Viewer(position=(1.0, -4.2, 3.4), focal_point=(0.45, -0.2, 0.1), up=(0, 0, 1))
SCENE = ph.Scene([LAMP], VIEWER, ph.LightModel(ambient=0.15, shadows=True))
PAPER, CLAY = ph.Material(ambient=0.8, diffuse=0.8), ph.Material(ambient=(0.9, 0.6, 0.4), diffuse=(0.9, 0.6, 0.4))
CENTER, RADIUS = np.array([0.0, 0.1, 0.8]), 0.55
ball = pv.Icosphere(radius=RADIUS, center=CENTER, nsub=6)


def floor(cells: int) -> pv.PolyData:
    """Return a floor of four by four with this number of cells along a side."""
    return pv.Plane(i_size=4, j_size=4, i_resolution=cells, j_resolution=cells).triangulate()


# %%
# Three meshes with the same number of points
# -------------------------------------------
# *saw* shades a regular grid at its vertices. *split* halves the edges that the shadow crosses, again and again.
# *cut* puts pairs of vertices on the shadow's edge, one lit and one in shadow.

refined = {"occluders": [ball], "tolerance": 1 / 255}


def three_floors(cells: int) -> dict[str, pv.PolyData]:
    """Return the floor in three ways, each with about as many points."""
    cut = floor(cells).phong.refine(SCENE, PAPER, **refined)
    return {
        "saw": floor(round(cut.n_points**0.5) - 1).phong.shade(SCENE, PAPER, occluders=[ball]),
        "split": floor(cells).phong.refine(SCENE, PAPER, cut=False, max_points=cut.n_points, **refined),
        "cut": cut,
    }


floors = three_floors(24)
clay = ball.phong.shade([LAMP, ph.DirectionalLight(direction=(-1, 2, -1), intensity=0.4)], CLAY)

plotter = pv.Plotter(shape=(1, 3), window_size=(1350, 450), border=False)
for pane, (name, mesh) in enumerate(floors.items()):
    plotter.subplot(0, pane)
    plotter.set_background("#20242c")
    plotter.add_mesh(mesh.copy(), scalars="phong", rgb=True, lighting=False)
    plotter.add_mesh(mesh.extract_all_edges(), color="#7090b0", line_width=1, opacity=0.25)
    plotter.add_mesh(clay.copy(), scalars="phong", rgb=True, lighting=False)
    plotter.add_text(f"{name}: {mesh.n_points:,} points", position=(14, 12), font_size=12, color="black")
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(1.15)
plotter.enable_anti_aliasing("ssaa")
plotter.show()

# %%
# Measure the wrong area
# ----------------------
# A place on the floor is in shadow if its ray to the lamp passes the ball's center at less than the radius. Random
# places inside each triangle give the part of the floor that has the colour of the wrong side.


def wrong_area(lit: pv.PolyData) -> float:
    """Return the part of a floor whose interpolated colour is that of the wrong side of the edge."""
    weights = np.random.default_rng(5).dirichlet(np.ones(3), size=(lit.n_cells, 100))
    corners = lit.regular_faces
    places, colors = (weights @ np.asarray(each, float)[corners] for each in (lit.points, lit["phong"]))
    ray = np.array(LAMP.position) - places
    along = ((CENTER - places) * ray).sum(axis=2) / (ray**2).sum(axis=2)
    is_dark = np.linalg.norm(CENTER - places - along[..., None] * ray, axis=2) < RADIUS
    lamp = 0.8 * ray[..., 2] / np.linalg.norm(ray, axis=2)  # the lamp's light where nothing blocks it
    off = np.abs(colors[..., 0] - 0.12 - np.where(is_dark, 0.0, lamp)) > 0.02
    p = lit.points.astype(float)[corners]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    return float((off.mean(axis=1) * area).sum() / area.sum())


# %%
# The wrong area against the number of points
# -------------------------------------------
# With n points, the wrong area of *saw* is proportional to n to the power −½: four times the points halve it. That of
# *cut* is more than a hundred times smaller, and falls a little faster, with a power of about −0.6.

rows = [floors, three_floors(48), three_floors(96)]
figure, chart = plt.subplots(figsize=(7, 4.2), layout="constrained")
for name, color in zip(floors, ("#c8502c", "#b08a1c", "#1c8a68"), strict=True):
    counts = [each[name].n_points for each in rows]
    areas = [wrong_area(each[name]) for each in rows]
    chart.loglog(counts, areas, "o-", color=color, label=name)
    slope = np.polyfit(np.log(counts), np.log(areas), 1)[0]
    print(f"{name}: {areas[0]:.3%} wrong with n = {counts[0]:,} points; proportional to n to the power {slope:.2f}")
chart.set(xlabel="points", ylabel="part of the floor with the wrong colour")
chart.grid(alpha=0.3)
chart.legend()
plt.show()
