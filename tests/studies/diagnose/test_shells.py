"""Closed parts that are inside out are found by the sign of their volume; cavities and open parts are left alone."""

import numpy as np
import pytest
import pyvista as pv

from pvphong.studies.diagnose.diagnosis import diagnose


def ball(radius=1.0, center=(0.0, 0.0, 0.0), *, turned=False, coarse=8):
    mesh = pv.Sphere(radius=radius, center=center, theta_resolution=coarse, phi_resolution=coarse)
    mesh.clear_data()
    return mesh.flip_faces() if turned else mesh


def found(*parts):
    """The numbers of the parts whose faces are found."""
    mesh = pv.merge(parts, merge_points=False)
    owner = np.repeat(np.arange(len(parts)), [part.n_cells for part in parts])
    faces = diagnose(mesh).inside_out_faces
    wrong = np.unique(owner[faces])
    assert len(faces) == sum(parts[part].n_cells for part in wrong)  # all faces of a part, or none
    return wrong.tolist()


def bare(mesh):
    mesh = mesh.copy()
    mesh.clear_data()
    return mesh


CLOSED = {
    "ball": ball(),
    "cube of six faces that share no points": bare(pv.Cube()),
    "torus": bare(pv.ParametricTorus(u_res=12, v_res=12).clean()),
    "wedge": bare(pv.Cylinder(resolution=5)),
}


@pytest.mark.parametrize("where", [0.0, 1e6])
@pytest.mark.parametrize("size", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("mesh", CLOSED.values(), ids=CLOSED)
def test_a_closed_surface_is_found_when_it_is_turned_and_only_then(mesh, size, where):
    mesh = mesh.copy()
    mesh.points = (mesh.points.astype(float) + where) * size
    right, wrong = mesh, mesh.flip_faces()
    if diagnose(right).inside_out_faces.size:  # which way round PyVista makes it is not what is asked here
        right, wrong = wrong, right
    assert not len(diagnose(right).inside_out_faces)
    assert len(diagnose(wrong).inside_out_faces) == mesh.n_cells
    assert not diagnose(wrong).ok


def test_a_surface_with_a_hole_has_no_inside():
    assert found(ball(turned=True).remove_cells([3])) == []
    assert found(bare(pv.Plane())) == []


def test_each_part_is_judged_by_itself():
    assert found(ball(), ball(center=(5, 0, 0), turned=True), ball(center=(9, 0, 0))) == [1]


def test_the_wall_of_a_cavity_is_right_and_a_hollow_body_that_is_turned_as_a_whole_is_not():
    assert found(ball(2.0), ball(1.0, turned=True)) == []
    assert found(ball(2.0, turned=True), ball(1.0)) == [0]
    assert found(ball(2.0), ball(1.0)) == []  # one ball in another


def test_a_turned_part_in_the_box_but_not_in_the_inside_of_another_is_found():
    ring = bare(pv.ParametricTorus(ringradius=3, crosssectionradius=0.5, u_res=24, v_res=12).clean())
    if diagnose(ring).inside_out_faces.size:
        ring = ring.flip_faces()
    assert found(ring, ball(0.2, turned=True)) == [1]  # in its hole
    assert found(ring, ball(0.2, center=(3, 0, 0), turned=True)) == []  # in the ring itself
