"""The comparisons of the benchmark of rays compute the same visibility, so that their times are comparable."""

import os

import numpy as np
import pytest
import pyvista as pv
import ray_peers as peers
from common import equal_error_seconds, grid, slope

import pvphong as ph

RAYS = 64


def job(light):
    """Return a job of a plane below a ball."""
    return peers.Job(grid(8, 4.0), (pv.Sphere(radius=0.5, center=(0.1, 0, 1)),), light)


@pytest.mark.parametrize("light", [None, ph.SphereLight((0.3, -0.2, 4), radius=1.0)], ids=["sky", "light"])
@pytest.mark.parametrize(
    ("peer", "needs"),
    [
        (peers.plain_rays, "embreex"),
        (peers.mitsuba, "mitsuba"),
        (peers.mitsuba_as_it_comes, "mitsuba"),
        (peers.blender, None),
    ],
    ids=["plain", "mitsuba", "mitsuba as it comes", "blender"],
)
def test_a_peer_sees_what_we_see(peer, needs, light):
    options = {}
    if needs is None:
        options["python"] = os.environ.get("BLENDER_PYTHON") or pytest.skip("BLENDER_PYTHON names no Python with bpy")
    else:
        pytest.importorskip(needs)
    scene = job(light)
    if light is None and peer is peers.mitsuba_as_it_comes:
        with pytest.raises(NotImplementedError, match="knot"):
            peer(scene)
        return
    seen = scene.mesh.phong.visibility(scene.scene, occluders=scene.occluders, samples=1024)
    truth = seen.sky if light is None else seen.per_light[0]
    part = peer(scene, **options)(RAYS).found
    plain_error = np.sqrt(truth * (1 - truth) / RAYS)
    assert 0.2 < truth.min() < 0.9 if light is None else truth.min() == 0.0
    assert np.abs(part - truth).max() < 5 * plain_error.max()
    assert abs(np.mean(part - truth)) < 5 * plain_error.max() / np.sqrt(len(part))


def test_libigl_sees_an_even_sky():
    pytest.importorskip("igl")
    scene = job(None)
    height, distance = 1.0, np.hypot(scene.points[:, 0] - 0.1, scene.points[:, 1])
    hidden = 1.0 - np.sqrt(1.0 - 0.25 / (height**2 + distance**2))  # a cone's part of the hemisphere
    part = peers.libigl(scene)(1024).found
    np.testing.assert_allclose(part, 1.0 - hidden, atol=0.05)


def test_times_at_equal_error_are_on_lines_of_logarithmic_axes():
    numbers = np.array([16, 64, 256])
    curve = [(2e-3 * n, 3.0 * n**-0.75) for n in numbers.tolist()]
    assert slope(numbers, [error for _, error in curve]) == pytest.approx(-0.75)
    for rays in (4, 16, 30, 100, 256, 2000):  # before, on, between and beyond the measured numbers
        assert equal_error_seconds(curve, 3.0 * rays**-0.75) == pytest.approx(2e-3 * rays)
