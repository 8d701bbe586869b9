"""What rounding does to light: four hard cases, the usual formulas above, pvphong below.

Each column is one mesh, lit twice from the same stored numbers by the same light.

1. Flattened and sheared: every leaf is a sphere under its own singular matrix. There is no inverse to transpose.
2. Far from the origin, as map coordinates are: float32 has no digits left for the distances that count.
3. A highlight of shininess 100,000 in float32: its cosine differs from 1 in the last digits alone. Drawn as contours.
4. Slivers: every other row of triangles is a millionth as high as the others.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
import pyvista as pv

import pvphong as ph

folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()
rng = np.random.default_rng(4)
clay = ph.Material(ambient=1, diffuse=(0.8, 0.55, 0.35), specular=0.4, shininess=30)
leaf = ph.Material(ambient=1, diffuse=(0.35, 0.65, 0.2), specular=0.3, shininess=20)


def unit(vectors):
    with np.errstate(all="ignore"):
        return vectors / np.sqrt((vectors * vectors).sum(axis=1, keepdims=True))


def textbook(points, normals, scene, material):
    """The lit colour by normalised vectors and a power of r·v, in float32 from end to end."""
    p, n, light, eye = (
        np.asarray(a, np.float32) for a in (points, normals, scene.lights[0].position, scene.viewer.position)
    )
    n, l, v = unit(n), unit(light - p), unit(eye - p)
    n_l = (n * l).sum(axis=1, keepdims=True)
    r_v = ((2 * n_l * n - l) * v).sum(axis=1, keepdims=True)
    specular = (n_l > 0) * np.maximum(r_v, 0) ** np.float32(material.shininess)
    lit = scene.light_model.ambient + np.maximum(n_l, 0) * material.diffuse + specular * material.specular
    return np.clip(np.nan_to_num(lit, nan=0.0), 0, 1)


def scene_of(light, eye, focal=(0, 0, 0)):
    return ph.Scene([ph.PointLight(position=light)], ph.Viewer(eye, focal), ph.LightModel(ambient=0.1))


def leaves():
    """Normals by the pseudo-inverse, which most turn to when the inverse is refused, or by `normal_matrix`."""
    dome, scene = pv.Sphere(radius=1, end_phi=90, theta_resolution=48, phi_resolution=25), scene_of((3, 4, 9), (0, 0, 11))
    grown, naive, ours = [], [], []
    for turn in np.arange(75) * 2.4:
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        across = np.array([-np.sin(turn), np.cos(turn), 0.0]) + rng.normal(size=3) * (0.3, 0.3, 0.9)
        matrix = np.eye(4)
        matrix[:3, :3] = np.column_stack([0.55 * along + rng.normal(size=3) * (0, 0, 0.2), 0.22 * across, np.zeros(3)])
        matrix[:3, 3] = 0.32 * np.sqrt(turn) * along + (0, 0, rng.uniform(-0.5, 0.5))
        flat = dome.transform(matrix, inplace=False)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ph.transform.SingularMatrixWarning)
            shade = ph.evaluate(dome.points, dome.point_normals, scene, leaf, matrix=matrix)
        naive.append(textbook(flat.points, dome.point_normals @ np.linalg.pinv(matrix[:3, :3]), scene, leaf))
        ours.append(shade.rgb)
        grown.append(flat)
    return pv.merge(grown, merge_points=False), scene, np.concatenate(naive), np.concatenate(ours)


def far_out():
    offset = np.array([5.1e6, -2.3e6, 1.7e6])
    mesh = pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.45, u_res=200, v_res=100)
    mesh.rotate_x(35, inplace=True)
    home, scene = scene_of((1.5, 1.5, 2.5), (0, 0, 6)), scene_of(offset + (1.5, 1.5, 2.5), offset + (0, 0, 6), offset)
    points = mesh.points + offset
    ours = ph.evaluate(points, mesh.point_normals, scene, clay).rgb
    return mesh, home, textbook(points, mesh.point_normals, scene, clay), ours


def needle():
    """A patch of a sphere, a hundredth of its radius wide, where it mirrors the light to the eye."""
    patch = pv.Plane(i_size=0.012, j_size=0.012, i_resolution=300, j_resolution=300)
    peak = unit(np.array([[0.3, 0.2, 1.0]]))[0]
    points = unit(patch.points.astype(float) + peak)
    eye = np.array([-1.2, 0.7, 5.0])
    v = (eye - peak) / np.linalg.norm(eye - peak)
    scene = scene_of(peak + 4 * (2 * (v @ peak) * peak - v), eye)
    chrome = ph.Material(diffuse=0, specular=(0.95, 0.95, 1.0), shininess=1e5, ambient=0)
    normals = points.astype(np.float32)
    pair = textbook(points, normals, scene, chrome), ph.evaluate(points, normals, scene, chrome).rgb
    return patch, np.array([0, 0, 1.0]), *(np.where(np.floor(rgb * 14) % 2, rgb, 0.75 * rgb) for rgb in pair)


def slivers():
    """A bumpy sheet whose every other row of triangles is a millionth as high as the rest."""
    x, y = np.meshgrid(np.linspace(-1, 1, 160), np.linspace(-1, 1, 60))
    y[1::2] = y[::2] + 1e-6
    points = np.stack([x, y, 0.25 * np.cos(5 * x) * np.cos(4 * y)], axis=-1).reshape(-1, 3)
    sheet = pv.StructuredGrid(x, y, points[:, 2].reshape(x.shape)).extract_surface(algorithm=None).triangulate()
    return sheet
