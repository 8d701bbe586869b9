"""Lights as data: evaluate once, then switch, dim and tint the lights with plain NumPy.

The lit colour is a sum with one term per light, so `components=True` gives each light's share as an array:
    colour = clip(base + Σ tint_i · share_i, 0, 1)
Any other mix of the same lights is that sum again. Nothing is evaluated a second time.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph


def trefoil_knot() -> pv.PolyData:
    """A tube along a closed curve, a few ten thousand points."""
    t = np.pi / 6 + np.linspace(0, 2 * np.pi, 600)  # the seam lies under a crossing
    curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    return pv.Spline(curve, 600).tube(radius=0.55, n_sides=60, capping=False)


scene = ph.Scene(
    lights=[
        ph.DirectionalLight(direction=(1, -1, -1), intensity=0.6, name="sun"),
        ph.PointLight(position=(6, -1, 2), attenuation=(1, 0, 0.02), name="bulb"),
        ph.SpotLight(position=(-3, -7, 5), direction=(3, 6, -5), cone_angle=30, exponent=40, name="spot"),
    ],
    viewer=ph.Viewer(position=(0, 0, 14), focal_point=(0, 0, 0), up=(0, 1, 0)),
    light_model=ph.LightModel(ambient=0.15),
)
ivory = ph.Material(ambient=0.9, diffuse=(0.9, 0.87, 0.8), specular=0.4, shininess=30)

lit = trefoil_knot().phong.shade(scene, ivory, components=True)  # the only evaluation
share = {name: lit[f"phong_light_{name}"] for name in ("sun", "bulb", "spot")}


def mix(**tints: float | tuple[float, float, float]) -> np.ndarray:
    """The lit colours with these lights on, each multiplied by a factor or an RGB tint."""
    total = lit["phong_base"] + sum(np.asarray(tint, np.float32) * share[name] for name, tint in tints.items())
    return np.clip(total, 0, 1)


difference = abs(mix(sun=1, bulb=1, spot=1) - lit["phong"]).max()
print(f"the lights' shares add up to the lit colour within {difference:.1e}")

mixes = {
    "sun": mix(sun=1),
    "bulb": mix(bulb=1),
    "spot": mix(spot=1),
    "all three": mix(sun=1, bulb=1, spot=1),
    "sun at 20 %": mix(sun=0.2, bulb=1, spot=1),
    "tinted": mix(sun=(1.0, 0.55, 0.25), bulb=(0.1, 0.5, 0.9), spot=(0.9, 0.2, 0.7)),
}
plotter = pv.Plotter(shape=(2, 3), off_screen=OFF_SCREEN, window_size=(1200, 800), border=False)
for pane, (title, colors) in enumerate(mixes.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#20242c")
    plotter.add_mesh(lit.copy(), scalars=colors, rgb=True, lighting=False)
    plotter.add_text(title, position=(12, 12), font_size=12, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "lights_as_data.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
