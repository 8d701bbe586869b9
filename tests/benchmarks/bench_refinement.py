"""Points of refinement and of uniform subdivision for the same error: `python bench_refinement.py`.

Separate code measures both errors at random points in every triangle. Uniform subdivision cuts every triangle into
four and interpolates normals. It is measured with fewer samples, so its measured error is too small.
"""

import sys
import time
from dataclasses import replace

import numpy as np
import pyvista as pv
from common import CONSOLE, show, torus
from pyvista import examples

import pvphong as ph
from pvphong.studies.refine import refine

TOLERANCE = 1 / 255
ALLOWED_SHARE = 0.1
ALLOWED_SECONDS = 10.0
MOST_UNIFORM = 400_000

SHARP = ph.Material(diffuse=0.5, specular=0.4, shininess=200)
NEEDLE = replace(SHARP, shininess=5000)
SUN = ph.DirectionalLight(direction=(-1, -1, -2))


def seen_from(*position) -> ph.Scene:
    """Return a scene of the sun and a viewer."""
    return ph.Scene(lights=[SUN], viewer=ph.Viewer(position=position))


CASES = {
    "sphere, 42 points": (pv.Icosphere(nsub=1), seen_from(3, -1, 4), SHARP),
    "sphere, 842 points": (pv.Sphere(), seen_from(3, -1, 4), SHARP),
    "torus, 529 points, needle": (torus(24), seen_from(3, -1, 4), NEEDLE),
    "airplane": (examples.load_airplane(), seen_from(2500, -900, 1200), SHARP),
}


def largest_error(points, normals, corners, scene, material, count) -> float:
    """Return the largest error of interpolated colours, at different random points in every triangle."""
    rng = np.random.default_rng(1)
    colors = ph.evaluate(points, normals, scene, material, precision="float64").rgb
    worst = 0.0
    for _ in range(count):
        weights = rng.dirichlet(np.ones(3), size=len(corners))
        place, normal, color = (np.einsum("ki,kij->kj", weights, a[corners]) for a in (points, normals, colors))
        truth = ph.evaluate(place, normal, scene, material, precision="float64").rgb
        worst = max(worst, float(np.abs(truth - color).max()))
    return worst


def uniform(mesh, scene, material) -> tuple[int, float]:
    """Return points and error of the first level that reaches the tolerance, or of the last level."""
    points, normals, corners = mesh.points.astype(float), mesh.phong.normals().astype(float), mesh.regular_faces
    while True:
        error = largest_error(points, normals, corners, scene, material, count=8)
        if error <= TOLERANCE or len(points) > MOST_UNIFORM:
            return len(points), error
        ends = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        edges, middles = np.unique(ends, axis=0, return_inverse=True)
        (a, b, c), (ab, bc, ca) = corners.T, middles.reshape(-1, 3).T + len(points)
        corners = np.column_stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]).reshape(-1, 3)
        points, normals = (np.concatenate([each, each[edges].mean(axis=1)]) for each in (points, normals))


def row(name, mesh, scene, material) -> tuple[list[str], float]:
    """Return the table row of a case, and its number of points relative to uniform subdivision."""
    start = time.perf_counter()
    fine = refine(mesh, scene, material, tolerance=TOLERANCE)
    seconds = time.perf_counter() - start
    normals = fine.point_data.active_normals.astype(float)
    error = largest_error(fine.points.astype(float), normals, fine.regular_faces, scene, material, count=100)
    reported = fine.field_data["phong_refinement_error"][0]
    spent, uniform_error = uniform(mesh, scene, material)
    share = fine.n_points / spent
    more, less = ("", "") if uniform_error <= TOLERANCE else ("> ", "< ")
    points, errors = (f"{mesh.n_points}", f"{fine.n_points}"), (f"{255 * reported:.3f}", f"{255 * error:.3f}")
    others = f"{more}{spent}", f"{255 * uniform_error:.2f}", f"{less}{share:.2%}"
    return [name, *points, f"{seconds:.2f} s", *errors, *others], share


def main() -> int:
    """Run the benchmark; return 0 if points and time are within the limits."""
    rows, shares = zip(*(row(name, *case) for name, case in CASES.items()), strict=True)
    headings = "mesh", "points", "ours", "time", "reported", "sampled", "uniform", "sampled", "share"
    show("Points for an error of 1/255 (errors in units of 1/255)", headings, rows)
    large, needle = pv.Sphere(theta_resolution=225, phi_resolution=225), replace(SHARP, shininess=20_000)
    start = time.perf_counter()
    fine = refine(large, seen_from(3, -1, 4), needle, tolerance=1e-3)
    seconds = time.perf_counter() - start
    CONSOLE.print(f"{large.n_cells} triangles to {fine.n_cells}: {seconds:.2f} s (allowed {ALLOWED_SECONDS:.0f} s)")
    return 0 if max(shares) <= ALLOWED_SHARE and seconds <= ALLOWED_SECONDS else 1


if __name__ == "__main__":
    sys.exit(main())
