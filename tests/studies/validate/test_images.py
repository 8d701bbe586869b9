"""Pictures of lit colours against pictures lit by VTK."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import pyvista as pv

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer
from pvphong.meshes.lit import shade_mesh
from pvphong.studies.refine import interpolation_error
from pvphong.studies.validate import images as vtk_images
from pvphong.studies.validate.images import ImageComparison, compare_images

EYE = Viewer(position=(1.6, -1.2, 1.0), up=(0.0, 0.0, 1.0), view_angle=34.0)
PARALLEL = replace(EYE, parallel=True, parallel_scale=0.7)
SPHERE = pv.Sphere(theta_resolution=180, phi_resolution=120)
TORUS = pv.ParametricTorus(ringradius=0.35, crosssectionradius=0.15, u_res=240, v_res=180, w_res=10)
MATTE = Material(ambient=0.2, diffuse=(0.8, 0.5, 0.3))
SHINY = Material(ambient=0.1, diffuse=(0.2, 0.3, 0.6), specular=0.4, shininess=25.0)
SUN = DirectionalLight(direction=(-1.0, 0.5, -0.8), intensity=0.9)
LAMP = PointLight(position=(1.0, -1.2, 1.4), attenuation=(0.4, 0.2, 0.1), diffuse=(1.0, 0.9, 0.7))
WIDE = SpotLight(position=(1.2, -1.0, 1.5), direction=(-1.2, 1.0, -1.5), cone_angle=60.0, exponent=2.0)
HEADLIGHT = DirectionalLight(frame="headlight", intensity=0.8)
VTK = LightModel.vtk()

DRAWN = {
    "lamp": (Scene([LAMP], EYE), MATTE),
    "headlight": (Scene([HEADLIGHT], EYE, VTK), MATTE),
    "parallel": (Scene([LAMP, replace(HEADLIGHT, intensity=0.1)], PARALLEL, VTK), MATTE),
    "camera light": (Scene([replace(SUN, frame="camera")], EYE, LightModel(two_sided=True)), MATTE),
    "no light": (Scene([], EYE, VTK), MATTE),
    "sun, shiny": (Scene([SUN], EYE), SHINY),
    "spot and headlight, shiny": (Scene([WIDE, HEADLIGHT], EYE), SHINY),
    "headlight alone, shiny": (Scene([HEADLIGHT], EYE, LightModel.vtk(two_sided=False)), SHINY),
}


def steps_of_interpolation(mesh, scene, material):
    """Return the largest interpolation error in steps of a display."""
    return 255.0 * float(interpolation_error(mesh, scene, material).cell_data["phong_interpolation_error"].max())


@pytest.mark.parametrize("mesh", [SPHERE, TORUS], ids=["sphere", "torus"])
@pytest.mark.parametrize(("scene", "material"), DRAWN.values(), ids=DRAWN.keys())
def test_scenes_are_drawn_as_vtk_draws_them_within_the_interpolation_error(mesh, scene, material):
    compared = compare_images(mesh, scene, material)
    error = steps_of_interpolation(mesh, scene, material) if material is SHINY else 0.0
    assert compared.max_difference <= 2.0 + error < 22.0, compared
    assert compared.p99 <= 2.0
    assert np.count_nonzero(compared.inside) > 5_000  # there is something to see


def test_where_vtks_window_cannot_be_made_the_other_is_closed(monkeypatch):
    def fails(*_):
        raise ValueError("no window")

    made, window_of_colors = [], vtk_images.window_of_colors
    monkeypatch.setattr(vtk_images, "window_lit_by_vtk", fails)
    monkeypatch.setattr(vtk_images, "window_of_colors", lambda *given: made.append(window_of_colors(*given)) or made[0])
    with pytest.raises(ValueError, match="no window"):
        compare_images(SPHERE, Scene([LAMP], EYE), MATTE)
    assert made[0].render_window is None


def test_coarse_meshes_differ_by_their_interpolation_error():
    coarse, scene = pv.Sphere(theta_resolution=24, phi_resolution=24), Scene([SUN], EYE)
    compared = compare_images(coarse, scene, SHINY)
    assert 10.0 < compared.max_difference <= 2.0 + steps_of_interpolation(coarse, scene, SHINY)


FAULTS = {
    "light dimmed": (SUN, {"lights": [replace(SUN, intensity=0.85)]}),
    "camera's light left behind": (replace(SUN, frame="camera"), {"lights": [SUN]}),
    "ambient twice": (SUN, {"light_model": LightModel(ambient=0.4)}),
}


@pytest.mark.parametrize(("light", "fault"), FAULTS.values(), ids=FAULTS.keys())
def test_a_wrong_picture_is_seen(monkeypatch, light, fault):
    def faulty(mesh, scene, *arguments, **options):
        return shade_mesh(mesh, replace(scene, **fault), *arguments, **options)

    scene = Scene([light], EYE)
    assert compare_images(SPHERE, scene, MATTE).max_difference <= 2
    monkeypatch.setattr(vtk_images, "shade_mesh", faulty)
    assert compare_images(SPHERE, scene, MATTE).max_difference > 5


def test_the_numbers_are_those_of_the_pixels_inside():
    ours = np.full((4, 5, 3), 100, np.uint8)
    vtks, inside = ours.copy(), np.zeros((4, 5), bool)
    inside[1:3, 1:4] = True
    vtks[0, 0] = 255  # outside
    vtks[1, 1] = (100, 93, 104)
    compared = ImageComparison(ours, vtks, ours.astype(np.int16) - vtks, inside)
    assert compared.max_difference == 7
    assert compared.p99 == pytest.approx(np.percentile([0, 0, 0, 0, 0, 7], 99))
    assert "7/255" in repr(compared)
    picture = compared.side_by_side()
    assert picture.shape == (4, 15, 3)
    np.testing.assert_array_equal(picture[1, 11], (128, 128 + 7 * 16, 128 - 4 * 16))
    np.testing.assert_array_equal(picture[1, 12], (128, 128, 128))
    np.testing.assert_array_equal(picture[0, 10], (255, 255, 255))


def test_contours_inside_the_outline_are_not_inside():
    """The far side of a torus is visible above the near one, whose contour is a silhouette too."""
    compared = compare_images(TORUS, Scene([SUN], EYE), MATTE)
    column, height = compared.inside[:, 200], len(compared.inside)
    parts = np.flatnonzero(np.diff(column.astype(int)) == 1)
    assert len(parts) == 2
    assert column.sum() < height


def test_only_pixels_with_all_their_neighbours_are_inside():
    mesh = pv.Sphere()
    mesh.clear_data()
    before = mesh.copy()
    compared = compare_images(mesh, Scene([SUN], EYE), MATTE, size=(80, 60))
    assert mesh == before
    covered = (compared.vtks != 255).any(axis=2)
    for shift in product((-1, 0, 1), repeat=2):
        assert np.roll(covered, shift, axis=(0, 1))[compared.inside].all()
    assert compared.ours.shape == (60, 80, 3)
    assert 0 < np.count_nonzero(compared.inside) < np.count_nonzero(covered)


def test_a_picture_is_saved(tmp_path):
    compared = compare_images(SPHERE, Scene([SUN], EYE), MATTE, size=(80, 60))
    compared.save(tmp_path / "both.png")
    saved = pv.read(tmp_path / "both.png").active_scalars.reshape(60, 240, 3)[::-1]
    np.testing.assert_array_equal(saved, compared.side_by_side())
    with pytest.raises(ValueError, match=r"\.png"):
        compared.save(tmp_path / "both.gif")
    assert [path.name for path in tmp_path.iterdir()] == ["both.png"]


CLOUD = pv.PolyData(SPHERE.points)
CLOUD.point_data.active_normals = SPHERE.point_normals
REFUSED = {
    "viewer must be a viewer that sees the mesh": {"scene": Scene([SUN], replace(EYE, focal_point=(9.0, 9.0, 9.0)))},
    "scene must be a scene that VTK can draw from the viewer's position": {"scene": Scene([SUN], PARALLEL)},
    "Blinn-Phong": {"scene": Scene([SUN], EYE, LightModel(reflection="blinn-phong"))},
    "mesh must be a mesh with faces": {"mesh": CLOUD},
    "width must be": {"size": (0, 10)},
}


@pytest.mark.parametrize(("message", "arguments"), REFUSED.items(), ids=REFUSED.keys())
def test_what_cannot_be_compared_is_refused(message, arguments):
    given = {"mesh": SPHERE, "scene": Scene([SUN], EYE), "material": SHINY} | arguments
    with pytest.raises(ValueError, match=message):
        compare_images(**given)
