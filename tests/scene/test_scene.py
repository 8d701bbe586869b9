"""Scenes: fields, files, and snapshots of plotters."""

import dataclasses
import json
import os
import re
import sys

import numpy as np
import pytest
import pyvista as pv
import vtk

from pvphong import Colormap, LightModel, Material, OrenNayar, Viewer
from pvphong.optics.lights import LIGHT_TYPES, DirectionalLight, PointLight, SpotLight
from pvphong.scene.scene import Scene, light_labels, load_materials

# --- fields ---


def test_values_are_frozen_and_hashed_by_value():
    lights = [DirectionalLight(name="sun"), SpotLight(diffuse="red")]
    scene, model = Scene(lights=lights), LightModel(ambient="white")
    for one, same in ((scene, Scene(lights=iter(lights))), (model, LightModel(ambient=[1, 1, 1]))):
        assert one == same
        assert hash(one) == hash(same)
        for field in dataclasses.fields(one):
            with pytest.raises(dataclasses.FrozenInstanceError):
                setattr(one, field.name, getattr(one, field.name))
    assert scene != Scene(lights=lights[::-1])
    lights.append(PointLight())
    assert len(scene.lights) == 2


LISTED = "lights must be a sequence of lights"
IN_VTK, NAN = {"convention": "vtk"}, float("nan")


def camera_light():
    light = pv.Light(position=(1, 0, 0), light_type="camera light")
    light.positional = True
    return light


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        (LightModel, {"ambient": -0.1}, "ambient must be"),
        (LightModel, {"ambient": NAN}, "ambient must be"),
        (LightModel, {"ambient": None}, "ambient must be"),
        (LightModel, {"ambient": (51, 51, 51)}, "ambient must be .*divide them by 255"),
        (LightModel, {"local_viewer": 1}, "local_viewer must be True or False; got 1"),
        (LightModel, {"two_sided": "no"}, "two_sided must be True or False; got no"),
        (LightModel, {"clamp": None}, "clamp must be True or False; got None"),
        *((LightModel, {"shadows": bad}, "shadows must be") for bad in (1, "yes")),
        *((LightModel, {"ambient_occlusion": bad}, "ambient_occlusion must be") for bad in (0.0, -1, NAN, None)),
        (LightModel, {"reflection": "blinn"}, "reflection .* 'phong', 'blinn-phong'; got blinn. .* 'blinn-phong'"),
        (LightModel, {"reflection": "Phong"}, "reflection must be .* Did you mean 'phong'"),
        (LightModel, {"convention": "opengl"}, "convention must be one of 'standard', 'vtk'; got opengl"),
        (LightModel, IN_VTK | {"local_viewer": False}, "local_viewer must be True in VTK's .*; .*always local"),
        (LightModel, IN_VTK | {"reflection": "blinn-phong"}, "reflection must be 'phong' in VTK's .*; .*no other"),
        (Scene, {"viewer": (0, 0, 1)}, "viewer must be a Viewer, a camera, or None for a viewer that frames the mesh"),
        (Scene, {"lights": [PointLight(name="a"), SpotLight(name="a")]}, "lights must be .*differ; got 2 lights named"),
        (Scene, {"lights": [camera_light()]}, "viewer must be a Viewer if a VTK camera light has a position"),
        (Scene, {"light_model": "vtk"}, "light_model must be a LightModel"),
        (Scene, {"lights": DirectionalLight()}, LISTED + "; .*into a list"),
        *((Scene, {"lights": bad}, LISTED) for bad in ("headlight", None, {"sun": DirectionalLight()})),
        (
            Scene,
            {"lights": [PointLight(), "lamp"]},
            "light must be a pvphong light, .* or a vtkLight; got lamp",
        ),
    ],
)
def test_refused_by_name(kind, fields, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        kind(**fields)


def test_defaults_and_opengls_and_vtks_own_light_models():
    off = {"two_sided": False, "shadows": False, "ambient_occlusion": False, "bounces": 0}
    standard = {"local_viewer": True, "reflection": "phong", "clamp": True, "convention": "standard"}
    assert LightModel() == LightModel(ambient=0.2, **standard, **off)
    assert Scene() == Scene(lights=(), viewer=None, light_model=LightModel())
    assert LightModel.opengl() == LightModel(0.2, local_viewer=False, reflection="blinn-phong")
    for two_sided in (True, False):
        assert LightModel.vtk(two_sided) == LightModel(1.0, two_sided=two_sided, convention="vtk")
    assert LightModel.vtk() == LightModel.vtk(True)


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        ([], ()),
        (["", ""], ("0", "1")),
        (["sun", "", "lamp"], ("sun", "1", "lamp")),
        (["1", "", "lamp"], ("0", "1", "lamp")),
        (["", "0x", "é"], ("0", "0x", "é")),
        (["", "0"], ("0", "1")),  # no two are alike
        (["2", "1", ""], ("0", "1", "2")),
    ],
)
def test_a_lights_label_is_its_name_or_its_index(names, labels):
    scene = Scene(lights=[PointLight(name=name) for name in names])
    assert light_labels(scene) == labels
    assert set(light_labels(scene, "light ")) <= {*names, *(f"light {k}" for k in range(len(names)))}


# --- files ---


@pytest.mark.parametrize("model", [LightModel(1 / 3, False, True, "blinn-phong", False), LightModel.vtk()])
def test_files_give_back_every_bit(model, tmp_path):
    """Files of each kind of light are tested in tests/optics/lights."""
    least, most = 5e-324, sys.float_info.max
    odd = {"up": (-least, 1 / 3, most), "parallel": True, "view_angle": 0.1, "parallel_scale": most}
    for viewer in (Viewer((-0.0, least, most), (2.2250738585072014e-308, -most, 0.1), **odd), None):
        scene = Scene([SpotLight(name="\ud800é"), PointLight((-0.0, 1 / 3, most), intensity=least)], viewer, model)
        scene.save(tmp_path / "scene.json")
        loaded = Scene.load(str(tmp_path / "scene.json"))
        assert loaded == scene
        assert repr(loaded) == repr(scene)  # distinguishes −0.0 from 0.0, and integers from floats
    assert os.listdir(tmp_path) == ["scene.json"]


def test_materials_are_kept_with_a_scene(tmp_path):
    materials = {"default": Material.named("gold"), "lid": Material(diffuse=0.3, reflectance=OrenNayar(30))}
    Scene(viewer=Viewer()).save(tmp_path / "rig.json", materials=materials)
    assert load_materials(tmp_path / "rig.json") == materials
    assert Scene.load(tmp_path / "rig.json") == Scene(viewer=Viewer())


def write(folder, document):
    path = folder / "scene.json"
    path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
    return path


def head(**entries):
    return {"format": "pvphong scene", "version": 1, **entries}


def test_what_a_file_leaves_out_has_its_default(tmp_path):
    path = write(tmp_path, head(lights=[{"type": "point", "diffuse": "red"}]))
    assert Scene.load(path) == Scene(lights=[PointLight(diffuse="red")], viewer=None)


def test_a_material_may_be_written_into_a_file_by_its_name(tmp_path):
    path = write(tmp_path, head(materials={"default": "Gold", "wing": {"diffuse": "red"}}))
    assert load_materials(path) == {"default": Material.named("gold"), "wing": Material(diffuse="red")}
    path = write(tmp_path, head(materials={"wing": "golt"}))
    with pytest.raises(ValueError, match=r"^materials\.wing must be one of .* got golt\. Did you mean 'gold'"):
        load_materials(path)


def point(**fields):
    return head(lights=[{"type": "point", **fields}])


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("", r"path must be a scene file in JSON; got .*scene\.json"),
        ("{lights: []}", "path must be a scene file in JSON"),
        ([], 'path must be a scene file, a JSON object with "format": "pvphong scene"; .*Scene.save writes such files'),
        ({"format": "glTF", "version": 1}, "path must be a scene file, a JSON object"),
        ({"format": "pvphong scene"}, "version must be 1; got null"),
        (head(version=3), r"version must be 1; got 3\. A newer pvphong"),
        (head(version="1"), 'version must be 1; got "1". Give a number'),
        (head(version=True), "version must be 1; got true"),
        (head(camera={}), "field of scene must be one of .*viewer.*; got camera"),
        (head(lights={}), "lights must be a list"),
        (head(lights=["sun"]), r"lights\[0\] must be a JSON object; got sun"),
        (head(lights=[{}]), rf"lights\[0\]\.type must be one of {', '.join(map(repr, LIGHT_TYPES))}; got None"),
        (head(lights=[{"type": "spott"}]), r"lights\[0\]\.type must be .*Did you mean 'spot'"),
        (
            head(lights=[{"type": "point"}, {"type": "point", "cone_angle": 3}]),
            r"field of lights\[1\] must be one of .*position.*; got cone_angle",
        ),
        (head(lights=[{"type": "spot", "cone_angle": 91}]), r"lights\[0\]\.cone_angle must be .*<= 90; got 91"),
        (point(position=[0, "x", 0]), r"lights\[0\]\.position\[1\] must be"),
        (point(diffuse=[255, 0, 0]), r"lights\[0\]\.diffuse must be .*255"),
        (head(viewer=[]), "viewer must be a JSON object"),
        (head(viewer={"fov": 3}), "field of viewer must be one of .*view_angle.*; got fov"),
        (head(viewer={"focal_point": [0, 0, 1]}), r"viewer\.focal_point must be different from position"),
        (head(light_model={"clamp": 1}), r"light_model\.clamp must be True or False"),
        (json.dumps(head(light_model={"ambient": 7})).replace("7", "1e999"), r"light_model\.ambient must be"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(document, message, tmp_path):
    with pytest.raises(ValueError, match=f"^{message}"):
        Scene.load(write(tmp_path, document))


def test_what_cannot_be_read_or_written_is_refused_as_the_path(tmp_path):
    """Existing files are kept, which tests/base/test_files.py tests."""
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00\x80")
    for name, act, message in (
        ("nowhere.json", Scene.load, r"a scene file that can be read; got .*nowhere\.json"),
        ("", Scene.load, "a scene file that can be read"),
        ("binary.json", Scene.load, "a scene file in JSON"),
        ("nowhere/scene.json", Scene().save, "in a folder that exists; .*Create "),
    ):
        with pytest.raises(ValueError, match=f"^path must be {message}"):
            act(tmp_path / name)


# --- VTK's lights, and plotters ---


def unit(vector):
    return np.asarray(vector) / np.linalg.norm(vector)


def assert_vtks(scene, renderer):
    """Assert that lights have VTK's positions after an update; vtk/test_lights tests their other values."""
    renderer.UpdateLightsGeometryToFollowCamera()
    size = np.linalg.norm(scene.viewer.position) + scene.viewer.distance
    for ours, vtks in zip(scene.world_lights, renderer.GetLights(), strict=True):
        position, focal = vtks.GetTransformedPosition(), vtks.GetTransformedFocalPoint()
        if hasattr(ours, "position"):
            np.testing.assert_allclose(ours.position, position, atol=1e-13 * size)
        if hasattr(ours, "direction"):
            np.testing.assert_allclose(unit(ours.direction), unit(np.subtract(focal, position)), atol=1e-12)
        assert (ours.diffuse, ours.specular) == (vtks.GetDiffuseColor(), vtks.GetSpecularColor())
    return scene


@pytest.fixture
def plotter(new_plotter):
    def make(*lights, **options):
        made = new_plotter(**options)
        made.camera.position, made.camera.focal_point = (4.0, -3.0, 2.5), (0.1, 0.2, 0.3)
        made.camera.up = (0.1, 0.2, 1.0)  # not perpendicular to the view
        for light in lights:
            made.add_light(light)
        return made

    return make


FRAMES = {"scene light": "world", "headlight": "headlight", "camera light": "camera"}
CUSTOM = {
    f"{light_type}, {shape}": {"light_type": light_type, **values}
    for light_type in FRAMES
    for shape, values in {
        "directional": {},
        "spot": {"positional": True, "cone_angle": 35, "exponent": 3},
        "lamp": {"positional": True, "cone_angle": 100},
    }.items()
}
every_kind = pytest.mark.parametrize("kind", CUSTOM)


def custom(kind, *, transformed=False):
    light = pv.Light(**CUSTOM[kind], attenuation_values=(0.5, 0.1, 0.02))
    light.position, light.focal_point = (0.4, 1.1, 1.7), (-0.1, 0.2, -0.3)
    light.SetDiffuseColor(0.9, 1 / 3, 0.4)
    light.SetSpecularColor(0.2, 0.5, 1 / 7)
    if transformed:
        light.transform_matrix = [[0, -1, 0, 0.5], [2, 0, 0, -1], [0, 0, 1, 2], [0, 0, 0, 1]]
    return light


@every_kind
def test_a_scene_converts_vtks_lights_which_ride_along_with_its_viewer(plotter, kind):
    shown = plotter(custom(kind))
    scene = Scene([custom(kind), vtk.vtkLight(), PointLight()], Viewer.from_camera(shown.camera))
    assert [light.frame for light in scene.lights] == [FRAMES[CUSTOM[kind]["light_type"]], "world", "world"]
    assert_vtks(dataclasses.replace(scene, lights=scene.lights[:1]), shown.renderer)


@every_kind
@pytest.mark.parametrize("transformed", [False, True])
def test_after_the_camera_has_moved_without_rendering(plotter, kind, transformed):
    shown = plotter(custom(kind, transformed=transformed))
    shown.renderer.UpdateLightsGeometryToFollowCamera()
    before = Scene.from_plotter(shown)
    shown.camera.position, shown.camera.up = (-1.0, 6.0, -2.0), (1.0, 0.3, 0.0)
    stale = shown.renderer.lights[0].GetTransformedPosition()
    scene = assert_vtks(Scene.from_plotter(shown), shown.renderer)
    assert (scene.viewer, scene.light_model) == (Viewer.from_camera(shown.camera), LightModel())
    if not kind.startswith("scene"):  # VTK's lights were outdated before the update
        assert shown.renderer.lights[0].GetTransformedPosition() != stale
        assert scene.world_lights != before.world_lights


def test_the_plotter_is_not_modified(plotter):
    shown = plotter(custom("camera light, spot"), lighting="light kit")
    parts = [*shown.renderer.GetLights(), shown.camera]
    before = [part.GetMTime() for part in parts]
    Scene.from_plotter(shown)
    assert [part.GetMTime() for part in parts] == before


def test_the_snapshot_is_of_the_active_renderer(plotter):
    shown = plotter(shape=(1, 2))
    shown.subplot(0, 1)
    shown.add_light(custom("scene light, directional"), only_active=True)
    assert len(Scene.from_plotter(shown).lights) == 1
    shown.subplot(0, 0)
    assert len(Scene.from_plotter(shown).lights) == 0


@pytest.mark.parametrize("bad", [None, "plotter", pv.Sphere(), Scene()])
def test_from_plotter_refuses_others(bad):
    with pytest.raises(ValueError, match=r"^plotter must be a pyvista\.Plotter; got "):
        Scene.from_plotter(bad)


def test_a_notebooks_table_has_every_light_and_what_is_not_at_its_default():
    lights = [PointLight(position=(1, 2, 3), name="<b>lamp"), DirectionalLight(on=False)]
    html = Scene(lights, light_model=LightModel(ambient=0.5))._repr_html_()
    assert re.findall(r">([^<>]*)</td>", html) == [
        "&lt;b&gt;lamp", "PointLight", "position (1.0, 2.0, 3.0)",
        "light 1", "DirectionalLight", "on False",
        "light model", "LightModel", "ambient 0.5",
        "viewer", "Viewer", "frames the mesh",
    ]  # fmt: skip
    assert "position (0.0, 0.0, 5.0)" in Scene(viewer=Viewer(position=(0, 0, 5)))._repr_html_()


def test_a_rig_keeps_colormaps_by_name_and_by_colours(tmp_path):
    materials = {
        "default": Material(albedo=Colormap("Elevation", "terrain", clim=(0, 8), annotations={4: "snow"})),
        "lake": Material(emission=Colormap("depth", ["navy", (0.5, 0.75, 1.0)], preference="cell")),
    }
    Scene([]).save(tmp_path / "rig.json", materials=materials)
    assert load_materials(tmp_path / "rig.json") == materials
    assert '"cmap": "terrain"' in (tmp_path / "rig.json").read_text()
