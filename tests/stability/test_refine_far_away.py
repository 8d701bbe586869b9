"""Refining is independent of a mesh's position: the same points at the origin and at map coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.shading.inside.lighting import LitVertices

TOLERANCE, MOST = 4 / 255, 4000
UTM = (500_000.0, 5_400_000.0, 0.0)


def refined(offset, kind="float64"):
    """Refine a ball over a plane, lit by a spot and a sphere light, both with shadows."""
    plane = pv.Plane(i_size=4, j_size=4, i_resolution=8, j_resolution=8)
    mesh = pv.merge([plane, pv.Sphere(radius=0.6, center=(0, 0, 1))])
    mesh.clear_data()
    mesh.points = (mesh.points.astype(float) + np.array(offset)).astype(kind)
    spot = ph.SpotLight(position=np.add(offset, (1, 1, 4)), direction=(-0.25, -0.25, -1), cone_angle=25)
    ball = ph.SphereLight(position=np.add(offset, (-2, 0, 3)), radius=0.3)
    viewer = ph.Viewer(position=np.add(offset, (0, -6, 5)), focal_point=offset)
    scene = ph.Scene([spot, ball], viewer, ph.LightModel(shadows=True))
    return mesh.phong.refine(scene, tolerance=TOLERANCE, max_points=MOST)


def is_within(result):
    return bool(result.field_data["phong_refinement_reached"][0])


@pytest.mark.parametrize(("offset", "kind"), [((300, 300, 0), "float32"), (UTM, "float64")], ids=["300", "a map's"])
def test_as_many_points_do_far_from_the_origin(offset, kind):
    here, there = refined((0, 0, 0)), refined(offset, kind)
    assert is_within(here)
    assert is_within(there)
    assert there.n_points == pytest.approx(here.n_points, rel=0.02)


def test_with_planes_that_do_not_go_with_the_lengths_of_normals_they_do_not(monkeypatch):
    """A plane's offset is the product of point and normal, so an error of the normal's length grows with distance."""
    monkeypatch.setattr(LitVertices, "as_stored", property(lambda self: replace(self, normals=self.stored)))
    assert is_within(refined((0, 0, 0)))
    assert not is_within(refined(UTM))
