"""
Lights from a target
====================

Paint how bright a statue should be, and let ``mesh.phong.fit`` find the lights: their positions, and their intensities
as the solution of a bounded least-squares problem. Needs the extra ``fit``.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A statue
# --------
# A bust from a few rounded shapes that melt into each other; the points are on the surface where the smallest distance
# to them is 0.


def ellipsoid(p: np.ndarray, center: tuple, radii: tuple) -> np.ndarray:
    """Return approximate distances from an ellipsoid."""
    q = (p - np.array(center)) / np.array(radii)
    length = np.linalg.norm(q, axis=-1)
    return length * (length - 1.0) / np.maximum(np.linalg.norm(q / np.array(radii), axis=-1), 1e-9)


def rod(p: np.ndarray, start: tuple, end: tuple, radius: float) -> np.ndarray:
    """Return distances from a rod with round ends."""
    a, b = np.array(start), np.array(end)
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius


def melted(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """Return the union of two shapes with a fillet (Quilez's smooth minimum)."""
    h = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - h * h * width / 4.0


grid = pv.ImageData(dimensions=(140, 100, 150), spacing=(0.024, 0.024, 0.024), origin=(-1.67, -1.2, -1.75))
p = grid.points.reshape(-1, 3)
x, y, z = np.abs(p[:, 0]), p[:, 1], p[:, 2]
side = np.stack([x, y, z], axis=1)  # left and right are alike
shape = melted(ellipsoid(p, (0, 0.12, 0.78), (0.54, 0.66, 0.6)), ellipsoid(p, (0, -0.13, 0.4), (0.41, 0.47, 0.6)), 0.2)
shape = melted(shape, rod(side, (0.1, -0.6, 0.79), (0.3, -0.5, 0.8), 0.045), 0.14)  # brows
shape = -melted(-shape, ellipsoid(side, (0.19, -0.68, 0.66), (0.13, 0.14, 0.08)), 0.1)  # sockets
shape = melted(shape, ellipsoid(side, (0.185, -0.47, 0.65), (0.1, 0.09, 0.08)), 0.02)  # eyes
shape = melted(shape, rod(p, (0, -0.6, 0.72), (0, -0.74, 0.44), 0.05), 0.09)  # nose
shape = melted(shape, ellipsoid(side, (0.065, -0.66, 0.43), (0.06, 0.08, 0.05)), 0.05)
shape = melted(shape, rod(side, (0.0, -0.615, 0.245), (0.1, -0.565, 0.235), 0.038), 0.05)  # lips
shape = melted(shape, rod(side, (0.0, -0.6, 0.165), (0.08, -0.56, 0.17), 0.042), 0.04)
shape = melted(shape, ellipsoid(p, (0, -0.5, -0.02), (0.15, 0.12, 0.11)), 0.14)  # chin
shape = melted(shape, ellipsoid(side, (0.54, 0.1, 0.55), (0.05, 0.12, 0.18)), 0.06)  # ears
shape = melted(shape, rod(p, (0, 0.1, 0.25), (0, 0.16, -0.8), 0.3), 0.2)  # neck
shape = melted(shape, rod(side, (0.0, 0.15, -1.2), (0.8, 0.2, -1.3), 0.42), 0.35)  # shoulders
shape = np.maximum(shape, -1.6 - z)
grid["shape"] = shape
statue = grid.contour([0.0], scalars="shape").smooth_taubin(n_iter=30).compute_normals(auto_orient_normals=True)
statue.clear_cell_data()
print(f"{statue.n_points:,} points")

# %%
# Paint the light
# ---------------
# The left should be bright, most at the top, with a soft edge along the nose; the right in deep shadow, with a bright
# line that separates it from the background. Grey is luminance; elsewhere anything will do.

x, y, z = statue.points.T
nx, ny, _ = statue.point_normals.T
wanted = np.full(statue.n_points, np.nan)
front = (y < 0.1) & ((z > -0.2) | (z < -0.9))
left = 1.0 / (1.0 + np.exp((x - 0.02) / 0.05))
wanted[front] = (0.05 + (0.42 + 0.25 * z) * left)[front]
edge = (nx > 0.55) & (ny > 0.1) & (ny < 0.8) & (z > -0.9)
wanted[edge] = (0.4 + 0.4 * z)[edge].clip(0.1)
statue["wanted"] = wanted

# %%
# Find the lamps
# --------------
# Two lamps stand in front of the statue. Their positions and intensities vary; everything else stays as it is. The
# statue's own shadows count.

viewer = ph.Viewer(position=(0.5, -7.6, 0.6), focal_point=(0, 0, -0.15), up=(0, 0, 1), view_angle=26)
lamps = [
    ph.PointLight(position=(place, -4, 2), attenuation=(0, 0, 1), intensity=7, name=name)
    for place, name in ((-2.5, "key"), (2.5, "rim"))
]
scene = ph.Scene(lamps, viewer, ph.LightModel(ambient=0.05, shadows=True))
plaster = ph.Material(ambient=1.0, diffuse=0.85, specular=0.06, shininess=20)
fit = statue.phong.fit(scene, plaster, "wanted", "intensity position")
print(fit)

# %%
# Before and after
# ----------------
# The difference is red where the statue is too bright and blue where it is too dark. The last picture shows the lamps:
# dark before, bright where they were found.

before = statue.phong.shade(scene, plaster)
paint = np.where(np.isnan(wanted)[:, None], (0.10, 0.11, 0.17), wanted[:, None])
panes = {"painted": paint, "before": before["phong"], "after": fit.lit["phong"]}
plotter = pv.Plotter(shape=(2, 3), groups=[(1, [1, 2])], window_size=(1260, 980), border=False)
for pane, colors in enumerate(panes.values()):
    plotter.subplot(0, pane)
    plotter.add_mesh(statue.copy(), scalars=np.sqrt(colors), rgb=True, lighting=False)
plotter.subplot(1, 0)
bar = {"title": "", "color": "white", "fmt": "%.1f", "n_labels": 3, "position_x": 0.25, "position_y": 0.02}
colors = {
    "cmap": "coolwarm",
    "clim": (-0.4, 0.4),
    "nan_color": "#33384d",
    "scalar_bar_args": bar | {"width": 0.5, "height": 0.05},
}
plotter.add_mesh(statue.copy(), scalars=fit.differences, lighting=False, **colors)
for place, title in {
    (0, 0): "painted",
    (0, 1): "before",
    (0, 2): "after",
    (1, 0): "difference",
    (1, 1): "lamps",
}.items():
    plotter.subplot(*place)
    plotter.set_background("#14161c")
    plotter.add_text(title, position=(16, 446), font_size=13, color="white")
    plotter.camera_position = [viewer.position, viewer.focal_point, viewer.up]
    plotter.camera.view_angle = viewer.view_angle
plotter.add_mesh(statue.copy(), scalars=np.sqrt(fit.lit["phong"]), rgb=True, lighting=False)
for lights, color in ((scene.lights, "#6b6552"), (fit.scene.lights, "#ffd98a")):
    for lamp in lights:
        plotter.add_mesh(pv.Sphere(radius=0.12, center=lamp.position), color=color, lighting=False)
        plotter.add_mesh(pv.Line(lamp.position, (0, 0, 0.4)), color=color, line_width=2)
plotter.camera_position = [(3.2, -11, 5.5), (-0.3, 0.2, 0.3), (0, 0, 1)]
plotter.enable_anti_aliasing("ssaa")
plotter.show()
