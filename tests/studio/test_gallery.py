"""Scripts like those of PyVista's gallery look alike with `plotter.add_mesh` and with `plotter.phong.add_mesh`."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples

import pvphong as ph

SIZE = (240, 180)


def ant_with_edges(plotter, add):
    add(examples.load_ant(), color="lightblue", show_edges=True, line_width=1, label="ant")
    plotter.add_legend()
    plotter.camera_position = "xz"


def airplane_that_turns(plotter, add):
    plane = examples.load_airplane()
    add(plane, color="tan", smooth_shading=True, split_sharp_edges=True)
    turned = pv.Transform().rotate_z(60).translate(0, 1200, 300).matrix
    add(plane, color="lightblue", user_matrix=turned)
    plotter.add_axes()


def actor_that_moves(_plotter, add):
    actor = add(pv.Cone(resolution=40), color="orange", specular=0.6, specular_power=20)
    add(pv.Plane(center=(0, 0, -1), i_size=4, j_size=4), color="w")
    actor.RotateZ(40)
    actor.position = (0.2, 0.3, 0.1)
    actor.scale = (1.0, 1.5, 0.7)


def hills_by_elevation(plotter, add):
    hills = examples.load_random_hills()
    add(hills, scalars="Elevation", cmap="gist_earth", smooth_shading=True, scalar_bar_args={"title": "Height [m]"})
    add(hills.contour(6), color="white", line_width=2)
    plotter.show_grid()


def hexbeam_that_is_warped(_plotter, add):
    beam = examples.load_hexbeam()
    beam["stress"] = beam.points[:, 2] ** 2
    beam["displacement"] = np.column_stack([np.zeros((beam.n_points, 2)), 0.02 * beam["stress"]])
    add(beam.warp_by_vector("displacement"), scalars="stress", clim=(0, 20), show_edges=True, n_colors=8)
    add(beam, style="wireframe", color="k", lighting=False)


def globe_with_texture(plotter, add):
    add(examples.load_globe(), texture=examples.load_globe_texture(), smooth_shading=True)
    plotter.add_text("Earth", font_size=8)


def uniform_clipped(_plotter, add):
    grid = examples.load_uniform()
    add(grid.clip("x"), scalars="Spatial Point Data", cmap="viridis")
    add(grid.outline(), color="k", line_width=2)


def uniform_see_through(_plotter, add):
    grid = examples.load_uniform()
    add(grid.threshold([120, 400]), scalars="Spatial Cell Data", clim=(100, 500), show_edges=True)
    add(grid, color="w", opacity=0.2)


def glyphs_by_size(plotter, add):
    ball = pv.Sphere(radius=3, theta_resolution=12, phi_resolution=12)
    ball["size"] = np.linspace(0.3, 1, ball.n_points)
    arrows = ball.glyph(orient="Normals", scale="size", geom=pv.Arrow(shaft_resolution=30, tip_resolution=30))
    add(arrows, cmap="plasma", lighting=True)
    add(ball, color="w")
    plotter.add_point_labels(ball.points[:2], ["top", "bottom"], font_size=8, shape=None)


def contours_with_two_bars(_plotter, add):
    field = pv.Wavelet().resample(2.0)  # fine enough to ignore interpolation
    add(field.contour(5), scalars="RTData", opacity=0.6, smooth_shading=True, cmap="coolwarm")
    floor = field.slice("z", origin=(0, 0, -9))
    floor["other"] = floor.points[:, 0]
    add(floor, scalars="other", cmap="bone", scalar_bar_args={"vertical": True})


def pbr_spheres(plotter, add):
    for i in range(3):
        for j in range(2):
            ball = pv.Sphere(radius=0.5, center=(0, 1.2 * i, 1.2 * j), theta_resolution=90, phi_resolution=90)
            add(ball, color="w", pbr=True, metallic=0.5 * j, roughness=0.3 + 0.3 * i, smooth_shading=True)
    plotter.view_vector((-1, 0, 0), (0, 0, 1))


def blocks_in_many_colors(_plotter, add):
    parts = [pv.Cylinder(center=(2 * k, 0, 0), direction=(0, 0, 1)) for k in range(4)] + [pv.Cube(center=(3, 0, -1))]
    add(pv.MultiBlock(parts), multi_colors=True, smooth_shading=True, split_sharp_edges=True, show_edges=False)


def paths_as_tubes(_plotter, add):
    spiral = pv.Spline(np.column_stack([np.cos(t := np.linspace(0, 12, 60)), np.sin(t), 0.2 * t]), 200)
    spiral["along"] = np.arange(spiral.n_points)
    add(spiral.tube(radius=0.1, scalars="along", n_sides=24), smooth_shading=True, show_scalar_bar=False)
    add(pv.PolyData(spiral.points[::20]), color="red", point_size=8, render_points_as_spheres=True)


def quadrics_by_name(plotter, add):
    add(pv.ParametricSuperToroid(), color="w", name="shape")
    add(pv.ParametricKlein(), color="gold", name="shape", specular=1.0, smooth_shading=True)
    plotter.add_bounding_box()


SCRIPTS = [value for value in dict(globals()).values() if getattr(value, "__module__", "") == __name__]


def drawn(script, *, is_lit):
    plotter = pv.Plotter(off_screen=True, window_size=SIZE)
    plotter.phong.light_model = ph.LightModel.vtk()
    try:
        script(plotter, plotter.phong.add_mesh if is_lit else plotter.add_mesh)
        return plotter.screenshot(return_img=True).astype(int)
    finally:
        plotter.close()


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.__name__)
def test_a_script_looks_as_it_did(script):
    """Outlines may differ, and faces in which PyVista interpolates other quantities."""
    off = np.abs(drawn(script, is_lit=True) - drawn(script, is_lit=False)).max(axis=2)
    assert np.percentile(off, 97.0) <= 8
    assert (off > 40).mean() < 0.005
