"""The document: edits by key, one undo history with the gizmos, and refused edits that change nothing."""

import asyncio
from dataclasses import fields, replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES, nearest_in_vtk
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.studio.gizmos import commands
from pvphong.studio.gizmos.interaction import Entry
from pvphong.studio.web.document import Document
from pvphong.studio.web.new_light import placed_before


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_light(ph.DirectionalLight((0, 0, -1), name="sun"))
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=12, phi_resolution=12), ph.Material(), name="ball")
    plotter.phong.add_gizmos()
    return plotter


@pytest.fixture
def document(plotter):
    return Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)


def colors(plotter):
    plotter.phong._subplot.lit.refresh()
    return plotter.phong.mesh(plotter.actors["ball"]).drawn["phong"].copy()


def test_an_edit_is_one_step_and_undo_brings_all_back_to_the_bit(document, plotter):
    before, drawn = document.state, colors(plotter)
    edits = [
        ("light.1.intensity", "0.3", ()),
        ("light.1.direction", 0.7, (0,)),
        ("light.1.diffuse", "orange", ()),
        ("light.1.name", "moon", ()),
        ("light.1.casts_shadows", False, ()),
        ("material.0.diffuse", "#102030", ()),
        ("material.0.shininess", 20, ()),
        ("model.ambient", 0.05, (2,)),
        ("model.local_viewer", False, ()),
        ("accuracy.tolerance", 1 / 255, ()),
    ]
    for key, given, index in edits:
        document.edit(key, given, index)
    assert plotter.phong.lights[0] == ph.DirectionalLight(
        (0.7, 0, -1), intensity=0.3, diffuse="orange", name="moon", casts_shadows=False
    )
    assert plotter.phong.light_model == ph.LightModel(ambient=(0.2, 0.2, 0.05), local_viewer=False)
    after = document.state
    assert (colors(plotter) != drawn).any()
    for _ in edits:
        assert document.undo()
    assert not document.undo()
    assert document.state == before
    np.testing.assert_array_equal(colors(plotter), drawn)
    for _ in edits:
        assert document.redo()
    assert document.state == after


@pytest.mark.parametrize(
    ("key", "given", "message"),
    [
        ("light.1.intensity", "-1", "intensity must be"),
        ("light.9.intensity", 1, "light must be the number of an existing light"),
        ("light.1", 1, "key must be"),
        ("light.1.on.x", 1, "key must be"),
        ("material.7.diffuse", 1, "material must be"),
        ("material.x.diffuse", 1, "material must be"),
        ("reflectance.0.roughness", 0.5, "key must be"),
        ("model.fog", 1, "field must be one of"),
        ("accuracy.tolerance", 2, "tolerance must be"),
        *(("accuracy.refine", given, "refine must be") for given in (0, -1, "fine")),
        (None, 1, "key must be a string"),
        (["light"], 1, "key must be a string"),
    ],
)
def test_a_refused_edit_changes_nothing(document, key, given, message):
    before = document.state
    with pytest.raises(ValueError, match=message):
        document.edit(key, given)
    assert document.state == before
    assert not document.history.can_undo


def test_edges_are_as_sharp_as_asked_and_undone(document, plotter):
    (lit,) = plotter.phong._subplot.lit.meshes
    before, smooth = lit.feature_angle, lit.drawn.n_points
    document.edit("surfaces.feature_angle", "0")
    assert lit.drawn.n_points == 3 * lit.drawn.n_cells
    assert document.shown()["surfaces"][0]["value"] == 0.0
    document.edit("surfaces.feature_angle", None)
    assert lit.drawn.n_points == smooth
    with pytest.raises(ValueError, match=r"^feature_angle must be .*180"):
        document.edit("surfaces.feature_angle", 181)
    assert document.undo()
    assert document.undo()
    assert lit.feature_angle == before


@pytest.mark.parametrize("keeps", [True, False])
def test_auto_is_shown_as_what_it_does(document, plotter, keeps):
    """The edges of a mesh with its own normals are not split."""
    (lit,) = plotter.phong._subplot.lit.meshes
    if not keeps:
        lit.mesh.point_data.active_normals_name = None
    lit.feature_angle = "auto"
    plotter.render()
    assert document.shown()["surfaces"][0]["value"] == (None if keeps else 30.0)


def test_textures_are_laid_on_and_removed(document, plotter):
    texture = pv.Texture(np.full((4, 4, 3), (255, 0, 0), np.uint8))
    with pytest.raises(ValueError, match="texture coordinates"):
        document.set_texture(0, "albedo", texture, "red.png")  # the sphere has none
    (lit,) = plotter.phong._subplot.lit.meshes
    lit.mesh.active_texture_coordinates = np.zeros((lit.mesh.n_points, 2), np.float32)
    document.set_texture(0, "albedo", texture, "red.png")
    assert lit.drawn["phong"][:, 1:].max() == 0
    assert list(document.textures.values()) == ["red.png"]
    (field,) = (each for each in document.shown()["materials"][0]["fields"] if each["name"] == "albedo")
    assert field["map"]
    document.edit("material.0.albedo", field["default"])
    assert lit.material.albedo == 1.0
    assert document.undo()
    assert lit.material.albedo.source is texture
    for what in ("ambient", "tangents", "roughness", ""):
        with pytest.raises(ValueError, match=r"^field must be one of 'diffuse'"):
            document.set_texture(0, what, texture, "red.png")


def test_pictures_of_one_file_name_are_told_apart(document, plotter):
    mesh = plotter.phong.mesh(plotter.actors["ball"]).mesh
    mesh.active_texture_coordinates = np.zeros((mesh.n_points, 2), np.float32)
    for field, grey in (("albedo", 200), ("specular", 20), ("emission", 200)):
        document.set_texture(0, field, pv.Texture(np.full((4, 4, 3), grey, np.uint8)), "scan.png")
    assert list(document.textures.values()) == ["scan.png", "scan-2.png", "scan.png"]


def test_moves_of_a_slider_are_one_step(document, plotter):
    for stops in (0.1, 0.5, 1.0):
        document.slide("light.1.intensity", stops)
    assert plotter.phong.lights[0].intensity == 2.0
    document.settle()
    document.slide("light.1.diffuse", "#ff0000")
    document.slide("material.0.shininess", 3.0)  # another slider ends the first one's movement
    assert document.undo()  # also during the movement
    assert plotter.phong.lights[0].diffuse == (1.0, 0.0, 0.0)
    assert document.undo()
    assert plotter.phong.lights[0] == ph.DirectionalLight((0, 0, -1), intensity=2.0, name="sun")
    assert document.undo()
    assert not document.undo()
    for key, given in (("light.1.on", True), ("light.1.intensity", "1"), ("light.1.direction", 0.0)):
        with pytest.raises(ValueError, match=r"intensity|slider"):
            document.slide(key, given)


def test_undo_while_a_value_is_typed_in_the_view_takes_back_that_value(document, plotter):
    document.edit("material.0.shininess", 7.0)
    interaction, start = plotter.phong._subplot.interaction, plotter.phong.lights
    entry = Entry(document.gizmos, document.gizmos.all[0], "intensity")
    interaction._begin(entry)
    entry.put("5")
    assert document.undo()
    assert (plotter.phong.lights, interaction.edit) == (start, None)
    assert document.state.materials[plotter.phong.mesh(plotter.actors["ball"]).shared_material].shininess == 7.0


def test_an_edit_while_a_value_is_typed_in_the_view_is_a_step_after_it(document, plotter):
    interaction, start = plotter.phong._subplot.interaction, plotter.phong.lights
    entry = Entry(document.gizmos, document.gizmos.all[0], "intensity")
    interaction._begin(entry)
    entry.put("5")
    document.edit("light.1.diffuse", "red")
    assert document.undo()
    assert plotter.phong.lights == (replace(start[0], intensity=5.0),)
    assert document.undo()
    assert plotter.phong.lights == start


def test_a_key_while_something_is_slid_is_a_step_after_it(document, plotter):
    document.slide("light.1.intensity", 1.0)
    document.select(1)
    commands.run(document.gizmos, "m")
    document.settle()
    assert document.undo()
    (sun,) = plotter.phong.lights
    assert (sun.intensity, sun.on) == (2.0, True)


def test_panel_and_gizmos_have_one_history(document, plotter):
    document.edit("light.1.intensity", 0.5)
    document.select(1)
    commands.run(document.gizmos, "Right")  # a key of the view
    document.edit("light.1.diffuse", "red")
    commands.run(document.gizmos, "z")
    assert plotter.phong.lights[0].diffuse == (1.0, 1.0, 1.0)
    assert plotter.phong.lights[0].intensity == pytest.approx(0.5 * 2 ** (1 / 3))
    assert document.undo()
    assert plotter.phong.undo()
    assert plotter.phong.lights[0] == ph.DirectionalLight((0, 0, -1), name="sun")


@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_each_kind_of_light_can_be_added_and_lights_the_scene(document, plotter, kind):
    drawn = colors(plotter)
    document.edit("light.1.on", False)
    dark = colors(plotter)
    document.add(kind)
    added = plotter.phong.lights[1]
    assert isinstance(added, LIGHT_TYPES[kind])
    assert added.name == kind
    assert document.shown()["lights"][1]["selected"]
    assert (colors(plotter).astype(int) - dark).max() > 60
    assert document.undo()
    assert document.undo()
    np.testing.assert_array_equal(colors(plotter), drawn)


@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_a_new_light_shines_as_bright_on_any_scale(kind):
    viewer = ph.Viewer(position=(5, 4, 3), focal_point=(0, 0, 0), up=(0, 0, 1))
    for size in (1e-3, 1.0, 1e4):
        light = placed_before(LIGHT_TYPES[kind](), (0.0, 0.0, 0.0), size, viewer)
        towards = (
            np.array(light.places).mean(axis=0) if light.places else -np.array(nearest_in_vtk(light).direction)
        ).tolist()
        rgb = ph.evaluate([[0.0, 0.0, 0.0]], [towards], [light], ph.Material(ambient=0, diffuse=1), precision="float64")
        assert 0.4 < rgb.rgb[0].max() < 0.75


def test_no_new_light_stands_where_another_does(document, plotter):
    for kind in ("sphere", "rectangle", "spot", "point", "directional", "directional"):
        document.add(kind)
    view, size = document.gizmos.view, document.gizmos.scenery.size
    origins = [gizmo.in_scene(view).origin for gizmo in document.gizmos.all]
    apart = np.linalg.norm(np.array(origins)[:, None] - origins, axis=-1)
    assert apart[~np.eye(len(origins), dtype=bool)].min() > 0.1 * size
    assert len(plotter.phong.lights) == 7


def test_lights_are_duplicated_deleted_soloed_and_moved_to_the_camera(document, plotter):
    document.add("point")
    number = document.shown()["lights"][1]["number"]
    assert "added: point 2" in document.act("duplicate", number)
    document.act("solo", number)
    assert [light.on for light in plotter.phong.lights] == [False, True, False]
    document.act("to camera", number)
    np.testing.assert_allclose(plotter.phong.lights[1].position, plotter.phong.scene.viewer.position)
    assert "deleted" in document.act("delete", number)
    assert [light.name for light in plotter.phong.lights] == ["sun", "point 2"]
    with pytest.raises(ValueError, match="the number of an existing light"):
        document.act("delete", number)
    for _ in range(5):
        assert document.undo()
    assert not document.history.can_undo


def test_a_light_stays_where_it_is_when_its_frame_changes_and_has_a_name_of_its_own(document, plotter):
    document.add("spot")
    with pytest.raises(ValueError, match="name must be unique"):
        document.edit("light.2.name", "sun")
    before = plotter.phong.scene.world_lights[1]
    document.edit("light.2.frame", "camera")
    assert plotter.phong.lights[1].frame == "camera"
    np.testing.assert_allclose(plotter.phong.scene.world_lights[1].position, before.position, atol=1e-9)


def test_materials_and_reflectances_are_chosen_by_name(document):
    shared = document.materials["ball"]
    document.edit("material.0.albedo", "#808080")
    document.choose_material(0, "gold")
    assert shared.material == replace(ph.Material.named("gold"), albedo=(128 / 255,) * 3)
    assert document.shown()["materials"][0]["preset"] == "gold"
    for name in REFLECTANCES.keys() - {"ward"}:
        document.choose_reflectance(0, name)
        assert document.shown()["materials"][0]["reflectance"] == name
        assert shared.material.reflectance is not None
    document.choose_reflectance(0, "ggx")
    document.edit("reflectance.0.roughness", 0.2)
    assert shared.material.reflectance.roughness == 0.2
    document.choose_reflectance(0, "")
    assert shared.material.reflectance is None
    before = document.state
    for call in (document.choose_material, document.choose_reflectance):
        with pytest.raises(ValueError, match="must be"):
            call(0, "cheese")
    with pytest.raises(ValueError, match="tangents"):  # they need texture coordinates, which this sphere lacks
        document.choose_reflectance(0, "ward")
    assert document.state == before


def test_a_rig_is_taken_over_as_one_step(document, plotter):
    before = document.state
    rig = ph.Scene([ph.PointLight((1, 2, 3), name="lamp")], light_model=ph.LightModel(ambient=0.5))
    document.replace_all(rig, {"default": ph.Material.named("gold")}, "default")
    assert plotter.phong.lights == rig.lights
    assert plotter.phong.light_model == rig.light_model
    assert document.materials["ball"].material == ph.Material.named("gold")
    assert document.undo()
    assert document.state == before


def test_a_rig_gives_blocks_their_materials_by_name(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_mesh(pv.MultiBlock({"a": pv.Sphere(), "b": pv.Plane()}), {"a": "ruby", "b": "jade"})
    plotter.phong.add_gizmos()
    document = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    given = {"a": ph.Material.named("gold"), "b": ph.Material.named("silver")}
    document.replace_all(ph.Scene([ph.DirectionalLight()]), given, "default")
    assert {name: shared.material for name, shared in document.materials.items()} == given


def test_no_two_meshes_have_one_name(new_plotter):
    """Two separately drawn blocks have the same name, and a mesh has the name of a block."""
    plotter = new_plotter()
    for name in ("left", None, "right"):
        plotter.phong.add_mesh(pv.MultiBlock({"wheel": pv.Sphere(), f"of {name}": pv.Plane()}), name=name)
    plotter.phong.add_mesh(pv.Cube(), name="of right")
    document = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    names = [document.mesh_name(mesh) for mesh in plotter.phong._subplot.lit.meshes]
    assert names == ["left[wheel]", "of left", "mesh 3", "of None", "right[wheel]", "right[of right]", "of right"]


def test_an_image_becomes_a_sky_bytes_as_srgb_and_floats_as_they_are(document, plotter):
    document.add("environment")
    texels = np.zeros((4, 8, 3))
    texels[0] = (0.2, 0.5, 1.0)  # the top row
    image = pv.ImageData(dimensions=(8, 4, 1))
    image.point_data["texels"] = texels[::-1].reshape(-1, 3)
    asyncio.run(document.set_image(2, image))
    np.testing.assert_allclose(plotter.phong.lights[1].panorama.image, texels, atol=1e-6)
    image.point_data["texels"] = np.uint8(255 * texels[::-1]).reshape(-1, 3)
    asyncio.run(document.set_image(2, image))
    top = plotter.phong.lights[1].panorama.image[0, 0]
    np.testing.assert_allclose(top, (0.0331, 0.2122, 1.0), atol=2e-3)  # IEC 61966-2-1, of 51, 127 and 255
    assert document.undo()
    assert document.undo()
    for number, given in ((1, image), (2, pv.Sphere()), (2, pv.ImageData(dimensions=(2, 2, 1))), (9, image)):
        with pytest.raises(ValueError, match="must be"):
            asyncio.run(document.set_image(number, given))


def sky(document):
    """Add a sky; return its number, and an image for it."""
    document.add("environment")
    image = pv.ImageData(dimensions=(8, 4, 1))
    image.point_data["texels"] = np.random.default_rng(0).random((32, 3))
    return 2, image


def test_edits_while_an_image_is_divided_into_bands_stay(document, plotter):
    number, image = sky(document)

    async def edited_meanwhile():
        setting = asyncio.create_task(document.set_image(number, image))
        await asyncio.sleep(0)
        document.edit("light.2.rotation", 30.0)
        await setting

    asyncio.run(edited_meanwhile())
    light = plotter.phong.lights[1]
    assert (light.rotation, light.panorama.image.shape) == (30.0, (4, 8, 3))


def test_an_image_for_a_light_that_goes_meanwhile_is_refused(document):
    number, image = sky(document)

    async def deleted_meanwhile():
        setting = asyncio.create_task(document.set_image(number, image))
        await asyncio.sleep(0)
        document.act("delete", number)
        await setting

    with pytest.raises(ValueError, match="light must be the number of an existing light"):
        asyncio.run(deleted_meanwhile())


def test_a_light_gets_a_gizmo_where_the_page_selects_it(document, plotter):
    plotter.phong.add_light(ph.PointLight(name="lamp"))
    plotter.phong.add_gizmos(["sun"])
    document.select(2)
    assert document.gizmos.selected.light.name == "lamp"
    document.act("delete", 2)
    assert [light.name for light in plotter.phong.lights] == ["sun"]


def test_a_light_that_was_deleted_and_came_back_is_reset_to_what_it_was_at_first(document, plotter):
    (first,) = plotter.phong.lights
    document.edit("light.1.intensity", 3.0)
    document.act("delete", 1)
    assert document.gizmos.all == ()
    document.undo()
    document.act("reset", 1)
    assert plotter.phong.lights == (first,)


def test_what_changes_a_picture_most_comes_first_in_the_scene(document):
    shown = [entry["name"] for entry in document.shown()["model"]]
    assert shown[:4] == ["ambient", "shadows", "ambient_occlusion", "bounces"]
    assert sorted(shown) == sorted(each.name for each in fields(ph.LightModel))


def test_a_light_is_asked_for_shadows_where_there_are_any(document):
    assert not document.shown()["has_shadows"]
    document.edit("model.shadows", True)
    shown = document.shown()
    assert shown["has_shadows"]
    document.select(1)
    (light,) = document.shown()["lights"]
    assert (light["casts_shadows"]["label"], light["casts_shadows"]["value"]) == ("casts shadows", True)
    assert "casts_shadows" not in [entry["name"] for entry in light["fields"]]
    document.edit(light["casts_shadows"]["key"], False)
    assert not document.shown()["lights"][0]["casts_shadows"]["value"]


def test_an_array_colours_a_material_through_a_colormap(document, plotter):
    lit = plotter.phong.mesh(plotter.actors["ball"])
    mesh = lit.mesh
    shown = lambda: document.shown()["materials"][0]["colormap"]  # noqa: E731
    assert shown()["arrays"] == []
    mesh["height"], mesh.cell_data["part"] = mesh.points[:, 2].copy(), np.arange(mesh.n_cells)
    assert shown()["arrays"] == ["height", "part"]
    before, drawn = document.state, colors(plotter)
    steps = [
        ((0, "height"), ph.Colormap("height", preference="point")),
        ((0, "height", "terrain"), ph.Colormap("height", "terrain", preference="point")),
        ((0, "height", "terrain", "-0,25", ""), ph.Colormap("height", "terrain", (-0.25, 0.5), preference="point")),
        ((0, "part"), ph.Colormap("part", "terrain", preference="cell")),
        ((0, None), 1.0),
    ]
    for given, expected in steps:
        said = document.set_colormap(*given)
        assert plotter.phong.mesh(plotter.actors["ball"]).material.albedo == expected
        assert bool(said) == (given[1] == "part")
        if given[1]:
            assert (colors(plotter) != drawn).any() if given[1] == "height" else lit.feature_angle == 0.0
            entry = shown()
            assert (entry["scalars"], entry["gradient"].count("#")) == (given[1], 16)
            assert entry["low"] < entry["high"]
    assert shown()["scalars"] == ""
    for given, message in (
        ((0, "heigth"), "Did you mean 'height'"),
        ((0, "height", "terain"), "Did you mean 'terrain'"),
        ((0, "height", "terrain", 2, 1), "clim must be two finite numbers, the smaller first"),
        ((0, "height", "terrain", "low", 1), "low must be a number"),
        ((7, "height"), "material must be the number of an existing material"),
    ):
        with pytest.raises(ValueError, match=message):
            document.set_colormap(*given)
    for _ in steps:
        assert document.undo()
    assert not document.undo()
    assert document.state == before
    np.testing.assert_array_equal(colors(plotter), drawn)


@pytest.mark.parametrize("name", [name for name in ph.setups if name != "sun"])
def test_a_set_up_replaces_all_lights_and_is_undone(document, plotter, name):
    before, drawn = document.state, colors(plotter)
    document.set_up(name)
    bounds = pv.Sphere(theta_resolution=12, phi_resolution=12).bounds
    expected = ph.setups[name](bounds, plotter.phong.scene.viewer)
    assert [light.name for light in plotter.phong.lights] == [light.name for light in expected]
    assert (colors(plotter) != drawn).any()
    document.undo()
    assert document.state.lights == before.lights
    np.testing.assert_array_equal(colors(plotter), drawn)


def test_a_set_up_needs_a_mesh_and_a_name(document, plotter):
    with pytest.raises(ValueError, match=r"^name must be one of"):
        document.set_up("portrait")
    plotter.clear_actors()
    with pytest.raises(ValueError, match=r"^mesh must be open; got none"):
        document.set_up("product")


def test_a_temperature_is_a_colour_and_one_step(document, plotter):
    before = document.state
    document.set_temperature(1, "3200")
    assert plotter.phong.lights[0].diffuse == ph.kelvin(3200)
    with pytest.raises(ValueError, match=r"^temperature must be a finite number >= 1667"):
        document.set_temperature(1, 100)
    document.undo()
    assert document.state == before
