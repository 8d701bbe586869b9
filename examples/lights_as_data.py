"""
Lights as data
==============

Evaluate the lights once, then switch, dim and tint them with NumPy.

The lit colour is a sum with one term for each light. ``components=True`` returns each term, the light's *share*, as an
array. With other factors, the same sum is another mix of the lights: ``colour = clip(base + Σ tint · share, 0, 1)``.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A knot under three lights
# -------------------------
# The mesh is a tube along a closed curve, with a few ten thousand points. The names of the lights become the names of
# their arrays.

t = np.pi / 6 + np.linspace(0, 2 * np.pi, 600)  # the seam lies under a crossing
curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
knot = pv.Spline(curve, 600).tube(radius=0.55, n_sides=60, capping=False)

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

# %%
# One evaluation
# --------------
# ``phong_light_sun`` is the sun's share. ``phong_base`` is the colour when all lights are off.

lit = knot.phong.shade(scene, ivory, components=True)
share = {name: lit[f"phong_light_{name}"] for name in ("sun", "bulb", "spot")}


def mix(**tints: float | tuple[float, float, float]) -> np.ndarray:
    """Return the colours with these lights on, each multiplied by a factor or an RGB tint."""
    total = lit["phong_base"] + sum(np.asarray(tint, np.float32) * share[name] for name, tint in tints.items())
    return np.clip(total, 0, 1)


difference = abs(mix(sun=1, bulb=1, spot=1) - lit["phong"]).max()
print(f"the shares add up to the lit colour within {difference:.1e}")

# %%
# Six mixes
# ---------
# The first three pictures show one light each, the fourth their sum. The last two dim and tint the same arrays.
# Nothing is evaluated again.

mixes = {
    "sun": mix(sun=1),
    "bulb": mix(bulb=1),
    "spot": mix(spot=1),
    "all three": mix(sun=1, bulb=1, spot=1),
    "sun at 20 %": mix(sun=0.2, bulb=1, spot=1),
    "tinted": mix(sun=(1.0, 0.55, 0.25), bulb=(0.1, 0.5, 0.9), spot=(0.9, 0.2, 0.7)),
}
plotter = pv.Plotter(shape=(2, 3), window_size=(1200, 800), border=False)
for pane, (title, colors) in enumerate(mixes.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#20242c")
    plotter.add_mesh(lit.copy(), scalars=colors, rgb=True, lighting=False)
    plotter.add_text(title, position=(12, 12), font_size=12, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")
plotter.show()
