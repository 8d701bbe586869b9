"""
Lights with a size
==================

The same ball and floor under five lamps of one intensity, and under a sky. Only the first lamp is a point.

A highlight is the mirror image of its light, blurred by the surface, so that it takes the light's shape. The larger a
light is, the more gradually it fades out where the surface turns away from it. Both are integrals over the light.
pvphong computes them at each vertex in closed form, without samples.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

PLACE = np.array([-1.5, -3.0, 2.4])
TO_BALL = -PLACE
POWER = {"intensity": 15.0, "specular": 14.0}

# %%
# A window with four panes
# ------------------------
# Any flat polygon can be a light. This window is four of them, each with a quarter of the intensity.


def window(width: float, height: float, bar: float) -> list[ph.PolygonLight]:
    """Return four panes that face the ball."""
    ahead = TO_BALL / np.linalg.norm(TO_BALL)
    across = np.cross(ahead, (0, 0, 1.0))
    across /= np.linalg.norm(across)
    above = np.cross(across, ahead)
    panes = []
    for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        middle = PLACE + x * (width + bar) / 4 * across + y * (height + bar) / 4 * above
        right, up = (width - bar) / 4 * across, (height - bar) / 4 * above
        corners = [middle - right - up, middle - right + up, middle + right + up, middle + right - up]
        panes.append(ph.PolygonLight(corners, intensity=POWER["intensity"] / 4, specular=POWER["specular"]))
    return panes


# %%
# A sky from an image
# -------------------
# An environment light is an image of all directions, here painted: a low sun in haze, blue above, and the ground's
# light from below. Rows go from the zenith down, columns around.


def evening(height: int = 64) -> np.ndarray:
    """Return an equirectangular image, linear, with the sun where the lamps are."""
    theta = (np.arange(height)[:, None] + 0.5) / height * np.pi
    phi = (np.arange(2 * height)[None, :] + 0.5) / height * np.pi - np.pi  # to the right of the x axis
    level = np.sin(theta)
    ways = np.stack([level * np.cos(phi), -level * np.sin(phi), np.cos(theta) + 0 * phi], axis=-1)
    toward = ways @ (PLACE / np.linalg.norm(PLACE))
    above = np.clip(ways[..., 2:], 0, 1)
    image = (1 - above) ** 3 * (0.85, 0.62, 0.40) + above * (0.06, 0.20, 0.50)
    image += np.exp((toward[..., None] - 1) * 60) * (18, 12, 6)
    return np.where(ways[..., 2:] < 0, (0.12, 0.10, 0.08), image)


# %%
# Six lights
# ----------
# The lacquer is smooth enough to show the shape of each lamp, and the sky in full.

lights = {
    "a point": [ph.PointLight(PLACE, (0, 0, 1), **POWER)],
    "a sphere": [ph.SphereLight(PLACE, 0.8, **POWER)],
    "a disk": [ph.DiskLight(PLACE, TO_BALL, 1.2, **POWER)],
    "a softbox": [ph.RectangleLight(PLACE, TO_BALL, (0, 0, 1), 1.2, 3.0, **POWER)],
    "a window": window(2.6, 3.2, 0.35),
    "a sky": [ph.EnvironmentLight(evening(), up=(0, 0, 1), intensity=1.6, specular=60)],
}
lacquer = ph.Material(ambient=0.3, diffuse=(0.42, 0.05, 0.04), specular=0.9, shininess=700)
boards = ph.Material(ambient=0.3, diffuse=(0.5, 0.47, 0.43), specular=0.04, shininess=60)
ball = pv.Sphere(radius=1.0, theta_resolution=200, phi_resolution=150)
floor = pv.Plane(center=(0, 0, -1), i_size=9, j_size=9, i_resolution=100, j_resolution=100)
eye = ph.Viewer(position=(1.2, -6.2, 2.0), focal_point=(0, 0, -0.15), up=(0, 0, 1), view_angle=26)

plotter = pv.Plotter(shape=(2, 3), window_size=(1140, 760), border=False)
for pane, (title, lamps) in enumerate(lights.items()):
    scene = ph.Scene(lamps, eye, ph.LightModel(ambient=0.12))
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#16181c")
    for mesh, material in ((ball, lacquer), (floor, boards)):
        lit = mesh.phong.shade(scene, material)
        plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False)
    plotter.add_text(title, position=(14, 12), font_size=13, color="white")
    plotter.camera_position = [eye.position, eye.focal_point, eye.up]
    plotter.camera.view_angle = eye.view_angle
    print(f"{title:10} brightens the floor to {lit['phong'].mean():.3f} on average")
plotter.enable_anti_aliasing("ssaa")
plotter.show()
