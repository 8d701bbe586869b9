"""What rounding does to light: five hard cases, the usual formulas above and pvphong below.

Each column is one mesh, lit twice by one light, from the same stored numbers.

1. Flattened: every leaf is a dome under its own singular matrix, which has no inverse to transpose.
   Most turn to the pseudo-inverse; it lays the normals into the leaf. `ph.pipeline.normal_matrix` follows the limit.
2. Sheared: a knot is stored in slanted coordinates, and a matrix, a shear of 6,000 between two rotations, sets it
   upright. Nearly everything cancels where normals meet its inverse-transpose, and float32, which shaders
   compute in, has no digits left. pvphong turns normals in float64, by exact cofactors.
3. A map's coordinates, millions of metres from the origin: float32 has no digits left for what lies between
   surface, light and eye. pvphong subtracts in float64, and only then rounds.
4. A highlight of shininess 100,000 in float32, drawn as contours of its brightness: close to 1 a cosine steps by
   6e-8, and its power by 0.6 %. pvphong takes the power of the chord, which is small and has all its digits.
5. Slivers: every other row of triangles is a twenty-thousandth as high as its neighbours, which is two steps of
   float32. Points that are rounded to it first have noise for normals, in whatever precision their cross products
   are then taken; pvphong takes float64 points as they are.
"""

import warnings

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

rng = np.random.default_rng(4)


def unit(vectors):
    """Vectors over their lengths."""
    with np.errstate(all="ignore"):
        return vectors / np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))


def textbook(points, normals, scene, material):
    """Normalise, multiply, take the cosine's power: float32 from end to end."""
    light, eye = scene.lights[0].position, scene.viewer.position
    p, n, light, eye = (np.asarray(a, np.float32) for a in (points, normals, light, eye))
    n, to_light, to_eye = unit(n), unit(light - p), unit(eye - p)
    n_dot_l = (n * to_light).sum(axis=1, keepdims=True)
    r_dot_v = ((2 * n_dot_l * n - to_light) * to_eye).sum(axis=1, keepdims=True)
    highlight = (n_dot_l > 0) * np.maximum(r_dot_v, 0) ** np.float32(material.shininess)
    ambient = np.multiply(material.ambient, scene.light_model.ambient)
    lit = ambient + np.maximum(n_dot_l, 0) * material.diffuse + highlight * material.specular
    return np.clip(np.nan_to_num(lit), 0, 1)


def scene_of(light, eye, focal=(0, 0, 0)):
    """One point light, a viewer, a little ambient light."""
    return ph.Scene([ph.PointLight(position=light)], ph.Viewer(eye, focal), ph.LightModel(ambient=0.12))


def leaves():
    """Mesh, the textbook's colours and pvphong's, as from all that follow."""
    dome = pv.Sphere(radius=1, end_phi=90, theta_resolution=48, phi_resolution=25)
    green = ph.Material(ambient=0.5, diffuse=(0.4, 0.7, 0.22), specular=0.3, shininess=20)
    scene, grown, naive, ours = scene_of((3, 4, 9), (0, 0, 10.5)), [], [], []
    for turn in np.arange(90) * 2.4:
        outward, around = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
        matrix = np.eye(4)
        matrix[:3, 0] = 0.5 * outward + rng.normal(size=3) * (0, 0, 0.15)
        matrix[:3, 1] = 0.2 * around + rng.normal(size=3) * (0.05, 0.05, 0.1)
        matrix[:3, 2] = 0  # flat
        matrix[:3, 3] = 0.3 * np.sqrt(turn) * outward + (0, 0, 0.1 * np.sqrt(turn))
        grown.append(dome.transform(matrix, inplace=False))
        ours.append(ph.evaluate(dome.points, dome.point_normals, scene, green, matrix=matrix).rgb)
        normals = dome.point_normals @ np.linalg.pinv(matrix[:3, :3])
        naive.append(textbook(grown[-1].points, normals, scene, green))
    return pv.merge(grown, merge_points=False), np.concatenate(naive), np.concatenate(ours)


def knot():
    """A trefoil, slanted as it is stored and upright as its matrix sets it."""
    t = np.linspace(0, 2 * np.pi, 500)
    curve = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    mesh = pv.Spline(curve, 500).tube(radius=0.5, n_sides=60)
    first, last = np.linalg.qr(rng.normal(size=(2, 3, 3)))[0]
    shear, back, matrix = np.eye(3), np.eye(3), np.eye(4)
    shear[0, 1], back[0, 1] = 6000, -6000
    matrix[:3, :3] = last @ shear @ first
    stored = mesh.points.astype(float) @ (first.T @ back @ last.T).T
    normals = mesh.point_normals.astype(float) @ matrix[:3, :3]  # the inverse-transpose undoes it
    mesh.points = ph.pipeline.transform_points(stored, matrix)
    violet = ph.Material(ambient=0.7, diffuse=(0.62, 0.45, 0.85), specular=0.4, shininess=25)
    scene = scene_of((4, 6, 9), (0, 0, 14))
    turned = normals.astype(np.float32) @ np.linalg.inv(matrix[:3, :3].astype(np.float32))
    naive = textbook(mesh.points, turned, scene, violet)
    return mesh, naive, ph.evaluate(stored, normals, scene, violet, matrix=matrix).rgb


def far_out():
    """A torus in a map's coordinates; drawn at home, where the graphics card can see it."""
    mesh = pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.45, u_res=200, v_res=100).rotate_x(35)
    clay = ph.Material(ambient=0.8, diffuse=(0.85, 0.55, 0.35), specular=0.4, shininess=30)
    offset = np.array([5.1e6, -2.3e6, 1.7e6])  # metres
    scene = scene_of(np.add(offset, (1.5, 1.5, 2.5)), np.add(offset, (0, 0, 6)), offset)
    points = mesh.points + offset
    ours = ph.evaluate(points, mesh.point_normals, scene, clay).rgb
    return mesh, textbook(points, mesh.point_normals, scene, clay), ours


def needle():
    """A patch of a sphere, where it mirrors the light to the eye."""
    patch = pv.Plane(i_size=0.006, j_size=0.006, i_resolution=400, j_resolution=400)
    peak, eye = unit(np.array([0.3, 0.2, 1.0])), np.array([-1.2, 0.7, 5.0])
    points = unit(patch.points.astype(float) + peak)
    to_eye = unit(eye - peak)
    scene = scene_of(peak + 4 * (2 * (to_eye @ peak) * peak - to_eye), eye)
    steel = ph.Material(ambient=0, diffuse=0, specular=(1.0, 0.9, 0.75), shininess=1e5)
    return patch, textbook(points, points, scene, steel), ph.evaluate(points, points, scene, steel).rgb


def contours(rgb):
    """Every other one of 24 steps of brightness darker."""
    return rgb * (0.65 + 0.35 * (np.floor(np.minimum(rgb[:, :1], 0.999) * 24) % 2))


def slivers():
    """A wavy sheet with rows of triangles 2e-6 high between the ordinary ones."""
    x, y = np.meshgrid(np.linspace(-1.3, 1.3, 160), np.repeat(np.linspace(-1.3, 1.3, 50), 2))
    y[1::2] += 2e-6
    z = 0.25 * np.cos(2.5 * x + 1) * np.cos(2.5 * y)
    index = np.arange(x.size).reshape(x.shape)
    here, right, up, across = (index[i, j].ravel() for i in (np.s_[:-1], np.s_[1:]) for j in (np.s_[:-1], np.s_[1:]))
    corners = np.concatenate([np.stack([here, right, across], axis=1), np.stack([here, across, up], axis=1)])
    mesh = pv.PolyData.from_regular_faces(np.stack([x, y, z], axis=-1).reshape(-1, 3) + 8, corners)
    blue = ph.Material(ambient=0.8, diffuse=(0.3, 0.5, 0.8), specular=0.5, shininess=12)
    scene = scene_of((9, 11, 11), (8, 6, 13))
    a, b, c = (mesh.points[corners[:, i]].astype(np.float32) for i in range(3))
    normals = np.zeros(mesh.points.shape, np.float32)
    for corner in range(3):
        np.add.at(normals, corners[:, corner], np.nan_to_num(unit(np.cross(b - a, c - a))))
    return mesh, textbook(mesh.points, normals, scene, blue), mesh.phong.shade(scene, blue)["phong"]


cases = {
    "flattened": (leaves, "pseudo-inverse"),
    "sheared by 6,000": (knot, "inverse-transpose in float32"),
    "6,000 km from the origin": (far_out, "float32 throughout"),
    "shininess 100,000, contours": (needle, "power of a cosine"),
    "slivers": (slivers, "points rounded to float32"),
}
warnings.simplefilter("ignore", ph.SingularMatrixWarning)  # the leaves are meant to be flat
plotter = pv.Plotter(shape=(2, len(cases)), off_screen=OFF_SCREEN, window_size=(320 * len(cases), 680), border=False)
for column, (title, (case, mistake)) in enumerate(cases.items()):
    mesh, naive, ours = case()
    print(f"{title}: {mistake}, off by up to {np.abs(naive - ours).max():.2f} of full brightness")
    for row, (colors, caption) in enumerate(((naive, mistake), (ours, "pvphong"))):
        plotter.subplot(row, column)
        plotter.set_background("white")
        drawn = contours(colors) if case is needle else colors
        plotter.add_mesh(mesh.copy(), scalars=drawn, rgb=True, lighting=False)
        plotter.add_text(f"{title}: {caption}" if row == 0 else caption, position=(10, 6), font_size=7, color="black")
        plotter.view_xy()
        plotter.camera.zoom(1.2)
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "hard_cases.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
