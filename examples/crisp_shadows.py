"""The edge of a shadow at vertices: a saw, the same points spent where it is, and triangles that are cut along it.

All three floors have about the same number of points. A lamp over a ball throws a shadow whose edge is a conic, so that
the area of the wrong colour is known. The figure shows how it falls with the points: with their root where the floor is
shaded at its vertices or split, and nearly with their number where `refine` cuts.
"""

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

LAMP = ph.PointLight(position=(-1.2, 0.8, 3.2), name="lamp")
VIEWER = ph.Viewer(position=(1.0, -4.2, 3.4), focal_point=(0.45, -0.2, 0.1), up=(0, 0, 1))
SCENE = ph.Scene([LAMP], VIEWER, ph.LightModel(ambient=0.15, shadows=True))
PAPER, CLAY = ph.Material(ambient=0.8, diffuse=0.8), ph.Material(ambient=(0.9, 0.6, 0.4), diffuse=(0.9, 0.6, 0.4))
CENTER, RADIUS = np.array([0.0, 0.1, 0.8]), 0.55
ball = pv.Icosphere(radius=RADIUS, center=CENTER, nsub=7)


def floor(cells: int) -> pv.PolyData:
    """Of four by four, with so many cells along a side."""
    return pv.Plane(i_size=4, j_size=4, i_resolution=cells, j_resolution=cells).triangulate()


def wrong_area(lit: pv.PolyData) -> float:
    """The part of a floor whose interpolated colour is not that of its side of the edge, by random places."""
    weights = np.random.default_rng(5).dirichlet(np.ones(3), size=(lit.n_cells, 60))
    corners = lit.regular_faces
    places, colors = (weights @ np.asarray(each, float)[corners] for each in (lit.points, lit["phong"]))
    ray = np.array(LAMP.position) - places
    along = ((CENTER - places) * ray).sum(axis=2) / (ray**2).sum(axis=2)
    is_dark = np.linalg.norm(CENTER - places - along[..., None] * ray, axis=2) < RADIUS
    lamp = 0.8 * ray[..., 2] / np.linalg.norm(ray, axis=2)  # what it adds where nothing blocks it
    off = np.abs(colors[..., 0] - 0.12 - np.where(is_dark, 0.0, lamp)) > 0.02
    p = lit.points.astype(float)[corners]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    return float((off.mean(axis=1) * area).sum() / area.sum())


refined = {"occluders": [ball], "tolerance": 1 / 255}
cut = floor(24).phong.refine(SCENE, PAPER, **refined)
points = cut.n_points
lit = {
    "saw": floor(round(points**0.5) - 1).phong.shade(SCENE, PAPER, occluders=[ball]),
    "split": floor(24).phong.refine(SCENE, PAPER, cut=False, max_points=points, **refined),
    "cut": cut,
}
errors: dict[str, list[tuple[int, float]]] = {"saw": [], "split": [], "cut": []}
for cells in (32, 64, 128):
    whole = floor(cells).phong.refine(SCENE, PAPER, **refined)
    side = round(whole.n_points**0.5) - 1
    split = floor(cells).phong.refine(SCENE, PAPER, cut=False, max_points=whole.n_points, **refined)
    saw = floor(side).phong.shade(SCENE, PAPER, occluders=[ball])
    for name, mesh in (("saw", saw), ("split", split), ("cut", whole)):
        errors[name].append((mesh.n_points, wrong_area(mesh)))

clay = ball.phong.shade([LAMP, ph.DirectionalLight(direction=(-1, 2, -1), intensity=0.4)], CLAY)
figure, axes = plt.subplots(1, 4, figsize=(16, 4.2), facecolor="#20242c", layout="constrained")
for axis, (name, mesh) in zip(axes, lit.items(), strict=False):
    plotter = pv.Plotter(off_screen=True, window_size=(800, 800), lighting="none")
    plotter.set_background("#20242c")
    plotter.add_mesh(mesh.copy(), scalars="phong", rgb=True, lighting=False)
    plotter.add_mesh(mesh.extract_all_edges(), color="#7090b0", line_width=1, opacity=0.25)
    plotter.add_mesh(clay.copy(), scalars="phong", rgb=True, lighting=False)
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(1.15)
    plotter.enable_anti_aliasing("ssaa")
    axis.imshow(plotter.screenshot(return_img=True))
    axis.set_title(f"{name}: {mesh.n_points:,} points, {wrong_area(mesh):.2%} wrong", color="white")
    axis.axis("off")
    print(f"{name}: {mesh.n_points} points, {wrong_area(mesh):.3%} of the floor has the wrong colour")
    plotter.close()

chart = axes[3]
for (name, rows), color in zip(errors.items(), ("#e07050", "#e0c060", "#60c0a0"), strict=True):
    counts, areas = np.transpose(rows)
    chart.loglog(counts, areas, "o-", color=color, label=name)
    slope = np.polyfit(np.log(counts), np.log(areas), 1)[0]
    print(f"{name}: the wrong area falls as the points to the power {slope:.2f}")
chart.set_facecolor("#20242c")
chart.set_xlabel("points", color="white")
chart.set_title("part of the floor with the wrong colour", color="white")
chart.tick_params(which="both", colors="white")
chart.xaxis.set_minor_formatter("")
chart.legend(labelcolor="white", facecolor="#30343c")
picture = FOLDER / "crisp_shadows.png"
figure.savefig(picture, dpi=100)
print(f"wrote {picture}")
if not OFF_SCREEN:
    plt.show()
