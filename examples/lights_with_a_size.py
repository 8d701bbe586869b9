"""Why the size of a light matters: the same ball and floor under five lamps of one intensity, and under a sky.

Only the first is a point. A highlight is the mirror image of its light, blurred by the surface: it takes the light's
shape. And the larger a light is, the softer it fades towards its horizon, where a part of it has set already. All of it
is computed exactly, per vertex, without a sample: what a matt surface scatters of a polygon is Lambert's formula of
1760, and the highlights are integrals along the edges of the lights. The sky is an image all around, painted here: a
low sun behind haze, blue above, and what the ground sends back up.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

PLACE = np.array([-1.5, -3.0, 2.4])
TO_BALL = -PLACE
POWER = {"intensity": 15.0, "specular": 14.0}
EYE = ph.Viewer(position=(1.2, -6.2, 2.0), focal_point=(0, 0, -0.15), up=(0, 0, 1), view_angle=26)
LACQUER = ph.Material(ambient=0.3, diffuse=(0.42, 0.05, 0.04), specular=0.9, shininess=700)
BOARDS = ph.Material(ambient=0.3, diffuse=(0.5, 0.47, 0.43), specular=0.04, shininess=60)


def window(width: float, height: float, bar: float) -> list[ph.PolygonLight]:
    """Four panes, turned to the ball, their intensities in proportion to their areas."""
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


def evening(height: int = 64) -> np.ndarray:
    """An equirectangular image, linear: rows from the zenith down, columns around, the sun where the lamps are."""
    theta = (np.arange(height)[:, None] + 0.5) / height * np.pi
    phi = (np.arange(2 * height)[None, :] + 0.5) / height * np.pi - np.pi  # to the right of the x axis
    level = np.sin(theta)
    ways = np.stack([level * np.cos(phi), -level * np.sin(phi), np.cos(theta) + 0 * phi], axis=-1)
    toward = ways @ (PLACE / np.linalg.norm(PLACE))
    above = np.clip(ways[..., 2:], 0, 1)
    image = (1 - above) ** 3 * (0.85, 0.62, 0.40) + above * (0.06, 0.20, 0.50)
    image += np.exp((toward[..., None] - 1) * 60) * (18, 12, 6)
    return np.where(ways[..., 2:] < 0, (0.12, 0.10, 0.08), image)


LIGHTS = {
    "a point": [ph.PointLight(PLACE, (0, 0, 1), **POWER)],
    "a sphere": [ph.SphereLight(PLACE, 0.8, **POWER)],
    "a disk": [ph.DiskLight(PLACE, TO_BALL, 1.2, **POWER)],
    "a softbox": [ph.RectangleLight(PLACE, TO_BALL, (0, 0, 1), 1.2, 3.0, **POWER)],
    "a window": window(2.6, 3.2, 0.35),
    "a sky": [ph.EnvironmentLight(evening(), up=(0, 0, 1), intensity=1.6, specular=60)],
}
ball = pv.Sphere(radius=1.0, theta_resolution=240, phi_resolution=180)
floor = pv.Plane(center=(0, 0, -1), i_size=9, j_size=9, i_resolution=120, j_resolution=120)

plotter = pv.Plotter(shape=(1, len(LIGHTS)), off_screen=OFF_SCREEN, window_size=(2040, 410), border=False)
for pane, (title, lights) in enumerate(LIGHTS.items()):
    scene = ph.Scene(lights, EYE, ph.LightModel(ambient=0.12))
    plotter.subplot(0, pane)
    plotter.set_background("#16181c")
    for mesh, material in ((ball, LACQUER), (floor, BOARDS)):
        lit = mesh.phong.shade(scene, material)
        plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False)
    plotter.add_text(title, position=(14, 12), font_size=13, color="white")
    plotter.camera_position = [EYE.position, EYE.focal_point, EYE.up]
    plotter.camera.view_angle = EYE.view_angle
    print(f"{title:10} brightens the floor to {lit['phong'].mean():.3f} on average")
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "lights_with_a_size.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
