"""
Hard cases
==========

Five meshes on which the usual formulas lose their digits. Each picture shows the usual formula on the left and pvphong
on the right, for the same stored numbers and the same light.
"""

# sphinx_gallery_thumbnail_number = 2

import warnings

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# The usual formula
# -----------------
# Normalise, multiply, take the power of the cosine, all in float32. Shaders compute this way.


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors of unit length."""
    with np.errstate(all="ignore"):
        return vectors / np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))


def textbook(points: np.ndarray, normals: np.ndarray, scene: ph.Scene, material: ph.Material) -> np.ndarray:
    """Return Phong's colours by the usual formula."""
    light, eye = scene.lights[0].position, scene.viewer.position
    p, n, light, eye = (np.asarray(a, np.float32) for a in (points, normals, light, eye))
    n, to_light, to_eye = unit(n), unit(light - p), unit(eye - p)
    n_dot_l = (n * to_light).sum(axis=1, keepdims=True)
    r_dot_v = ((2 * n_dot_l * n - to_light) * to_eye).sum(axis=1, keepdims=True)
    highlight = (n_dot_l > 0) * np.maximum(r_dot_v, 0) ** np.float32(material.shininess)
    ambient = np.multiply(material.ambient, scene.light_model.ambient)
    lit = ambient + np.maximum(n_dot_l, 0) * material.diffuse + highlight * material.specular
    return np.clip(np.nan_to_num(lit), 0, 1)


def scene_of(light: object, eye: object, focal_point: object = (0, 0, 0)) -> ph.Scene:
    """Return a scene of one point light, a viewer and a little ambient light."""
    return ph.Scene([ph.PointLight(position=light)], ph.Viewer(eye, focal_point), ph.LightModel(ambient=0.12))


def show(mesh: pv.PolyData, usual: np.ndarray, ours: np.ndarray, mistake: str) -> None:
    """Draw the mesh with both sets of colours next to each other."""
    print(f"wrong by up to {np.abs(usual - ours).max():.2f} of full brightness")
    plotter = pv.Plotter(shape=(1, 2), window_size=(900, 480), border=False)
    for pane, (colors, caption) in enumerate(((usual, mistake), (ours, "pvphong"))):
        plotter.subplot(0, pane)
        plotter.set_background("white")
        plotter.add_mesh(mesh.copy(), scalars=colors, rgb=True, lighting=False)
        plotter.add_text(caption, position=(12, 8), font_size=10, color="black")
        plotter.view_xy()
        plotter.camera.zoom(1.15)
    plotter.enable_anti_aliasing("ssaa")
    plotter.show()


rng = np.random.default_rng(4)

# %%
# 1. A matrix without an inverse
# ------------------------------
# Each leaf is a dome, flattened by its own singular matrix. Normals need the inverse-transpose, which does not exist.
# With the pseudo-inverse, normals lie in the plane of the leaf. :func:`pvphong.pipeline.normal_matrix` returns the
# limit for matrices that are flatter and flatter: the normals are perpendicular to the leaf.

warnings.simplefilter("ignore", ph.SingularMatrixWarning)  # the leaves are flat on purpose
dome = pv.Sphere(radius=1, end_phi=90, theta_resolution=48, phi_resolution=25)
green = ph.Material(ambient=0.5, diffuse=(0.4, 0.7, 0.22), specular=0.3, shininess=20)
scene = scene_of((3, 4, 9), (0, 0, 10.5))
leaves, usual, ours = [], [], []
for turn in np.arange(90) * 2.4:
    outward, around = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
    matrix = np.eye(4)
    matrix[:3, 0] = 0.5 * outward + rng.normal(size=3) * (0, 0, 0.15)
    matrix[:3, 1] = 0.2 * around + rng.normal(size=3) * (0.05, 0.05, 0.1)
    matrix[:3, 2] = 0  # flat
    matrix[:3, 3] = 0.3 * np.sqrt(turn) * outward + (0, 0, 0.1 * np.sqrt(turn))
    leaves.append(dome.transform(matrix, inplace=False))
    ours.append(ph.evaluate(dome.points, dome.point_normals, scene, green, matrix=matrix).rgb)
    normals = dome.point_normals @ np.linalg.pinv(matrix[:3, :3])
    usual.append(textbook(leaves[-1].points, normals, scene, green))
show(pv.merge(leaves, merge_points=False), np.concatenate(usual), np.concatenate(ours), "pseudo-inverse")

# %%
# 2. A shear of 6,000
# -------------------
# A knot is stored in slanted coordinates. Its matrix, a shear between two rotations, straightens it. When its normals
# are multiplied by the inverse-transpose, nearly everything cancels, and float32 has no digits left. pvphong transforms
# normals in float64, with exact cofactors.

t = np.linspace(0, 2 * np.pi, 500)
curve = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
knot = pv.Spline(curve, 500).tube(radius=0.5, n_sides=60)
first, last = np.linalg.qr(rng.normal(size=(2, 3, 3)))[0]
shear, back, matrix = np.eye(3), np.eye(3), np.eye(4)
shear[0, 1], back[0, 1] = 6000, -6000
matrix[:3, :3] = last @ shear @ first
stored = knot.points.astype(float) @ (first.T @ back @ last.T).T
normals = knot.point_normals.astype(float) @ matrix[:3, :3]  # the inverse-transpose undoes it
knot.points = ph.pipeline.transform_points(stored, matrix)
violet = ph.Material(ambient=0.7, diffuse=(0.62, 0.45, 0.85), specular=0.4, shininess=25)
scene = scene_of((4, 6, 9), (0, 0, 14))
turned = normals.astype(np.float32) @ np.linalg.inv(matrix[:3, :3].astype(np.float32))
usual = textbook(knot.points, turned, scene, violet)
show(knot, usual, ph.evaluate(stored, normals, scene, violet, matrix=matrix).rgb, "inverse-transpose in float32")

# %%
# 3. Six thousand kilometres from the origin
# ------------------------------------------
# In the coordinates of a map, float32 has no digits left for the distances between surface, light and eye. pvphong
# subtracts in float64 and rounds afterwards. The picture shows the torus near the origin, because graphics cards also
# compute in float32.

torus = pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.45, u_res=200, v_res=100).rotate_x(35)
clay = ph.Material(ambient=0.8, diffuse=(0.85, 0.55, 0.35), specular=0.4, shininess=30)
offset = np.array([5.1e6, -2.3e6, 1.7e6])  # metres
scene = scene_of(np.add(offset, (1.5, 1.5, 2.5)), np.add(offset, (0, 0, 6)), offset)
points = torus.points + offset
usual = textbook(points, torus.point_normals, scene, clay)
show(torus, usual, ph.evaluate(points, torus.point_normals, scene, clay).rgb, "float32 throughout")

# %%
# 4. A shininess of 100,000
# -------------------------
# Close to 1, float32 cosines have steps of 6e-8, and their powers steps of 0.6 %. pvphong computes the power from the
# chord between the two vectors, which is small and has all its digits. The picture shows contours of the brightness in
# the highlight, on a patch that is 0.006 units wide.

patch = pv.Plane(i_size=0.006, j_size=0.006, i_resolution=400, j_resolution=400)
peak, eye = unit(np.array([0.3, 0.2, 1.0])), np.array([-1.2, 0.7, 5.0])
points = unit(patch.points.astype(float) + peak)
to_eye = unit(eye - peak)
scene = scene_of(peak + 4 * (2 * (to_eye @ peak) * peak - to_eye), eye)
steel = ph.Material(ambient=0, diffuse=0, specular=(1.0, 0.9, 0.75), shininess=1e5)


def contours(rgb: np.ndarray) -> np.ndarray:
    """Darken every other one of 24 steps of brightness."""
    return rgb * (0.65 + 0.35 * (np.floor(np.minimum(rgb[:, :1], 0.999) * 24) % 2))


usual, ours = textbook(points, points, scene, steel), ph.evaluate(points, points, scene, steel).rgb
show(patch, contours(usual), contours(ours), "power of a cosine")

# %%
# 5. Slivers
# ----------
# Every other row of triangles is 2e-6 high, which is two steps of float32. If the points are rounded to float32, their
# normals are noise, in whatever precision the cross products are computed. pvphong does not round float64 points.

x, y = np.meshgrid(np.linspace(-1.3, 1.3, 160), np.repeat(np.linspace(-1.3, 1.3, 50), 2))
y[1::2] += 2e-6
z = 0.25 * np.cos(2.5 * x + 1) * np.cos(2.5 * y)
index = np.arange(x.size).reshape(x.shape)
here, right, up, across = (index[i, j].ravel() for i in (np.s_[:-1], np.s_[1:]) for j in (np.s_[:-1], np.s_[1:]))
corners = np.concatenate([np.stack([here, right, across], axis=1), np.stack([here, across, up], axis=1)])
sheet = pv.PolyData.from_regular_faces(np.stack([x, y, z], axis=-1).reshape(-1, 3) + 8, corners)
blue = ph.Material(ambient=0.8, diffuse=(0.3, 0.5, 0.8), specular=0.5, shininess=12)
scene = scene_of((9, 11, 11), (8, 6, 13))
a, b, c = (sheet.points[corners[:, i]].astype(np.float32) for i in range(3))
normals = np.zeros(sheet.points.shape, np.float32)
for corner in range(3):
    np.add.at(normals, corners[:, corner], np.nan_to_num(unit(np.cross(b - a, c - a))))
usual = textbook(sheet.points, normals, scene, blue)
show(sheet, usual, sheet.phong.shade(scene, blue)["phong"], "points rounded to float32")
