"""Materials: the table of named ones, conversions from VTK, roughness and Blinn-Phong."""

import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
import vtk
from strategies import REFLECTANCE_SHAPES, Dice

from pvphong import DirectionalLight, Scene, Viewer
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectances import PBR, REFLECTANCES, Metal, OrenNayar, Phong, Retro
from pvphong.shading.evaluation import evaluate

# --- named ---


def test_there_are_29_named_materials():
    assert len(Material.names()) == len(set(Material.names()))
    materials = [material for material in map(Material.named, Material.names()) if material.reflectance is None]
    assert len(set(materials)) == 29
    for material in materials:
        for color in (material.ambient, material.diffuse, material.specular):
            assert len(color) == 3
            assert all(0 <= channel <= 1 for channel in color)
        assert 1 <= material.shininess <= 128
        assert material.emission == 0.0


@pytest.mark.parametrize("name", [name for name in Material.names() if Material.named(name).reflectance])
def test_named_materials_with_reflectances_reflect_a_part_of_the_light(name):
    material = Material.named(name)
    random = np.random.default_rng(1)
    normals = random.normal(size=(300, 3))
    lit = evaluate(
        normals, normals, Scene([DirectionalLight()], Viewer((0, 0, 9))), replace(material, tangents=normals[:, ::-1])
    )
    assert lit.rgb.max() > 0.3
    assert np.ptp(lit.rgb) > 0.2


@pytest.mark.parametrize(
    ("name", "ambient", "diffuse", "specular", "shininess"),
    [  # teapots.c, OpenGL Programming Guide
        ("emerald", (0.0215, 0.1745, 0.0215), (0.07568, 0.61424, 0.07568), (0.633, 0.727811, 0.633), 0.6 * 128),
        ("gold", (0.24725, 0.1995, 0.0745), (0.75164, 0.60648, 0.22648), (0.628281, 0.555802, 0.366065), 0.4 * 128),
        ("cyan plastic", (0.0, 0.1, 0.06), (0.0, 0.50980392, 0.50980392), (0.50196078,) * 3, 32.0),
        ("yellow rubber", (0.05, 0.05, 0.0), (0.5, 0.5, 0.4), (0.7, 0.7, 0.04), 10.0),
    ],
)
def test_named_values_are_the_tables(name, ambient, diffuse, specular, shininess):
    assert Material.named(name.title()) == Material(
        ambient=ambient, diffuse=diffuse, specular=specular, shininess=shininess
    )


@pytest.mark.parametrize(
    ("name", "suggested"), [("golden", "gold"), ("red plastik", "red plastic"), ("emrald", "emerald")]
)
def test_unknown_names_suggest_close_ones(name, suggested):
    message = rf"^name must be one of .*; got {name}. Did you mean '{suggested}'"
    with pytest.raises(ValueError, match=message) as refused:
        Material.named(name)
    assert all(repr(each) in str(refused.value) for each in Material.names())


# --- from a property ---


def test_from_property_with_physically_based_shading():
    prop = pv.Property(interpolation="pbr", metallic=0.25, roughness=0.75, color=(0.2, 0.4, 0.6))
    material = Material.from_property(prop)
    assert material.reflectance == PBR(0.25, 0.75)
    assert material.diffuse == pytest.approx((0.2, 0.4, 0.6))
    assert Material.from_property(pv.Property()).reflectance is None


@pytest.mark.parametrize(
    ("setter", "value", "named"),
    [
        ("SetAnisotropy", 0.5, "anisotropy must be 0.0"),
        ("SetCoatStrength", 0.1, "coat_strength must be 0.0"),
        ("SetEdgeTint", (1.0, 0.5, 1.0), "edge_tint must be "),
        ("SetBaseIOR", 2.0, "base_ior must be 1.5"),
        ("SetNormalTexture", pv.Texture(np.zeros((2, 2, 3), np.uint8)), "textures must be 0"),
        ("SetRoughness", 0.0, "roughness must be above 0"),
    ],
)
def test_what_vtks_physically_based_shading_has_beyond_is_refused_by_name(setter, value, named):
    prop = pv.Property(interpolation="pbr")
    getattr(prop, setter)(value)
    with pytest.raises(ValueError, match=rf"^prop\.{named}.*; got "):
        Material.from_property(prop)


def test_image_based_light_on_physically_based_shading_is_refused():
    plotter = pv.Plotter(off_screen=True)
    actor = plotter.add_mesh(pv.Plane(), pbr=True)
    plotter.renderer.UseImageBasedLightingOn()
    with pytest.raises(ValueError, match=r"^plotter must be lit by its lights alone; .*remove_environment_texture"):
        Scene.from_plotter(plotter)
    actor.prop.interpolation = "phong"
    assert Scene.from_plotter(plotter).lights
    plotter.close()


def test_from_property_multiplies_coefficient_and_colour_unrounded_and_modifies_nothing():
    prop = pv.Property()
    prop.SetAmbient(1 / 3)
    prop.SetAmbientColor(0.1, 0.2, 1 / 7)
    prop.SetDiffuse(0.9)
    prop.SetDiffuseColor(1 / 9, 0.123456789012345, 1)
    prop.SetSpecular(0.7)
    prop.SetSpecularColor(0.3, 0.6, 0.9)
    prop.SetSpecularPower(100 / 3)
    before = prop.GetMTime()
    assert Material.from_property(prop) == Material(
        ambient=(1 / 3 * 0.1, 1 / 3 * 0.2, 1 / 3 * (1 / 7)),
        diffuse=(0.9 * (1 / 9), 0.9 * 0.123456789012345, 0.9),
        specular=(0.7 * 0.3, 0.7 * 0.6, 0.7 * 0.9),
        shininess=100 / 3,
    )
    assert prop.GetMTime() == before


@pytest.mark.parametrize("bad", [None, "gold", vtk.vtkLight(), vtk.vtkActor(), Material()])
def test_from_property_refuses_others(bad):
    with pytest.raises(ValueError, match=r"^prop must be a pyvista\.Property or a vtkProperty; got "):
        Material.from_property(bad)


# --- roughness ---


@pytest.mark.parametrize("bad", [0, -0.1, 1.0000001, math.nan, "smooth", None, 5e-324, 1e-310])
def test_roughness_is_at_most_1_and_large_enough_to_invert(bad):
    with pytest.raises(ValueError, match=r"^roughness must be a finite number >.* and <= 1; got "):
        Material.from_roughness(bad)


def test_the_shininess_of_a_roughness_and_for_blinn_phong():
    """The similarity of the two is tested as a law of reflectances: `counterpart_of`."""
    material = Material(diffuse=0.5, specular=(1.0, 1.0, 1.0), shininess=10)
    assert Material.from_roughness(0.1, diffuse=0.5, specular="white") == material
    assert material.for_blinn_phong().shininess == 40
    with pytest.raises(ValueError, match=r"^shininess must be one number; got .*Multiply the map by 4"):
        Material(shininess="gloss").for_blinn_phong()
    with pytest.raises(ValueError, match=r"^shininess must be one number"):
        Material(shininess="gloss", reflectance=Phong(5.0)).for_blinn_phong()


# --- as dictionaries ---


@pytest.mark.parametrize("name", REFLECTANCES)
@pytest.mark.parametrize("seed", range(5))
def test_dictionaries_give_back_every_bit(name, seed):
    dice = Dice(seed)
    reflectance = REFLECTANCES[name](**REFLECTANCE_SHAPES[name](dice))
    material = Material(ambient=dice.color(), diffuse=0.1 + 0.2, shininess=dice.shininess(), reflectance=reflectance)
    kept = json.loads(json.dumps(material.to_dict()))
    assert kept["reflectance"]["type"] == name
    assert repr(Material.from_dict(kept)) == repr(material)


def test_a_dictionary_holds_what_is_set_and_defaults_may_be_left_out():
    assert Material().to_dict() == {
        "ambient": 0.2, "diffuse": 0.8, "specular": 0.0, "shininess": 30.0, "emission": 0.0
    }  # fmt: skip
    assert Material.from_dict({}) == Material()
    assert Material.from_dict({"diffuse": "red", "reflectance": None}) == Material(diffuse="red")


@pytest.mark.parametrize(
    ("reflectance", "said"),
    [  # Oren-Nayar with sigma 25 reflects 0.8824 of Lambert's total
        (OrenNayar(25), "reflectance=None, diffuse=(0.706, 0.706, 0.706), specular=(0, 0, 0), shininess=30."),
        (
            Metal((0.5, 0.25, 0.125), 9),
            "reflectance=None, diffuse=(0.8, 0.8, 0.8), specular=(0.5, 0.25, 0.125), shininess=9.",
        ),
        (Retro(5), "Leave it out; VTK's reflectance is Phong's."),
    ],
)
def test_what_is_nearest_in_vtk_is_said_in_numbers(reflectance, said):
    assert nearest_in_vtk(Material(reflectance=reflectance)).endswith(said)


def test_a_specular_alone_is_a_highlight_and_not_everywhere():
    normals = np.random.default_rng(0).normal(size=(1000, 3))
    scene = Scene(lights=[DirectionalLight()], viewer=Viewer())
    colors = [evaluate(np.zeros((1000, 3)), normals, scene, Material(specular=part)).rgb for part in (0.0, 0.5)]
    changed = (np.abs(colors[1] - colors[0]) > 1 / 255).any(axis=1)
    assert 0.005 < changed.mean() < 0.2


def test_a_reflectance_that_files_do_not_know_is_refused():
    class Own(Phong):
        pass

    with pytest.raises(
        ValueError, match=r"^reflectance must be of a built-in type \(phong, .*\) to be saved in a file; got"
    ):
        Material(reflectance=Own()).to_dict()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (3, "material must be a JSON object; got 3"),
        ({"colour": "red"}, "field of material must be one of .*ambient, .*; got colour"),
        ({"diffuse": -1}, r"material\.diffuse must be "),
        ({"reflectance": "phong"}, r"material\.reflectance must be a JSON object"),
        ({"reflectance": {"type": "fong"}}, r"material\.reflectance\.type must be one of .* Did you mean .*'phong'"),
        ({"reflectance": {"type": "oren-nayar", "sigma": 91}}, r"material\.reflectance\.sigma must be "),
    ],
)
def test_what_is_no_material_is_refused(given, message):
    with pytest.raises(ValueError, match=rf"^{message}"):
        Material.from_dict(given)


COLORED = pv.Sphere()
COLORED["rgb"] = (50 * COLORED.point_normals + 100).astype(np.uint8)


@pytest.mark.parametrize(
    ("options", "albedo"),
    [
        ({"scalars": "rgb", "rgb": True}, COLORED["rgb"]),
        ({"scalars": COLORED.points[:, 2].copy(), "cmap": "terrain", "clim": (-0.2, 0.2)}, "a colormap's"),
        ({"color": "red"}, 1.0),
    ],
)
def test_an_actors_material_has_the_colours_of_its_mesh_in_place_of_the_propertys(options, albedo):
    plotter = pv.Plotter(off_screen=True)  # a reference keeps its actors alive
    actor = plotter.add_mesh(COLORED, diffuse=0.7, ambient=0.1, specular=0.5, **options)
    material, prop = Material.from_actor(actor), Material.from_property(actor.prop)
    if isinstance(albedo, float):
        assert material == prop == replace(prop, diffuse=(0.7, 0, 0))
        return
    assert (material.ambient, material.diffuse, material.specular) == (0.1, 0.7, prop.specular)
    colors = np.asarray(material.albedo)
    if isinstance(albedo, str):
        table = pv.LookupTable("terrain", scalar_range=(-0.2, 0.2))
        albedo = np.array([table.map_value(z, opacity=False) for z in options["scalars"]]) * 255
    assert np.abs(colors - albedo.astype(float)).max() <= 1
    with pytest.raises(ValueError, match=r"^actor must be a pyvista\.Actor"):
        Material.from_actor(actor.prop)


@pytest.mark.parametrize("kind", [pv.Texture, vtk.vtkTexture])
def test_a_material_with_a_texture_pickles(kind):
    picture = pv.Texture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3))
    texture = kind()
    texture.SetInputData(picture.GetInput())
    texture.SetWrap(2)
    texture.UseSRGBColorSpaceOn()
    mesh = pv.Plane()
    copied = pickle.loads(pickle.dumps(Material(albedo=texture)))
    assert isinstance(copied.albedo.source, kind)
    expected, colors = (mesh.phong.shade(None, each)["phong"] for each in (Material(albedo=texture), copied))
    assert np.array_equal(colors, expected)
    assert len(np.unique(colors, axis=0)) > 9


def test_an_array_like_a_grid_is_answered_with_its_order():
    x, y = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 5), indexing="ij")
    colors = np.stack([x, y, 0 * x], axis=-1)
    grid = pv.StructuredGrid(x, y, 0 * x)
    with pytest.raises(
        ValueError, match=r"got an array of shape \(4, 5, 3\)\. Reorder .* array\.reshape\(-1, 3, order='F'\)"
    ):
        grid.phong.shade(None, Material(albedo=colors))
    assert colors.reshape(-1, 3, order="F")[:, :2] == pytest.approx(grid.points[:, :2])
