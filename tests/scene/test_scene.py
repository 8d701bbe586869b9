"""Scenes: fields, files that give back every bit, and snapshots of plotters."""

import dataclasses
import json
import math
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import vtk
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene, light_labels
from pvphong.scene.viewer import Viewer
from pvphong.shading.evaluation import evaluate

MODEL_FIELDS = {
    "ambient": 0.2,
    "local_viewer": True,
    "two_sided": False,
    "reflection": "phong",
    "clamp": True,
    "convention": "standard",
}


# --- the light model ---


def test_light_model_defaults():
    assert dataclasses.asdict(LightModel()) == MODEL_FIELDS


def test_light_model_is_frozen_and_hashable_by_value():
    assert LightModel(ambient="white") == LightModel(ambient=(1, 1, 1))
    assert hash(LightModel(ambient=[1, 1, 1])) == hash(LightModel(ambient="white"))
    for field in MODEL_FIELDS:
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(LightModel(), field, MODEL_FIELDS[field])


def test_opengls_own_defaults():
    assert LightModel.opengl() == LightModel(
        ambient=0.2, local_viewer=False, two_sided=False, reflection="blinn-phong", clamp=True, convention="standard"
    )


@pytest.mark.parametrize("two_sided", [True, False])
def test_vtks_model(two_sided):
    model = LightModel.vtk(two_sided=two_sided)
    assert (model.convention, model.two_sided, model.reflection) == ("vtk", two_sided, "phong")
    assert (model.local_viewer, model.clamp) == (True, True)
    assert LightModel.vtk().two_sided is True


@pytest.mark.parametrize(
    ("field", "bad", "message"),
    [
        ("ambient", -0.1, "^ambient must be"),
        ("ambient", (51, 51, 51), "^ambient must be .*divide them by 255"),
        ("ambient", None, "^ambient must be"),
        ("local_viewer", 1, "^local_viewer must be True or False; got 1"),
        ("two_sided", "no", "^two_sided must be True or False; got no"),
        ("clamp", None, "^clamp must be True or False; got None"),
        (
            "reflection",
            "blinn",
            "^reflection must be one of 'phong', 'blinn-phong'; got blinn. Did you mean 'blinn-phong'",
        ),
        ("reflection", "Phong", "^reflection must be .* Did you mean 'phong'"),
        ("convention", "opengl", "^convention must be one of 'standard', 'vtk'; got opengl"),
    ],
)
def test_light_model_refuses_by_name(field, bad, message):
    with pytest.raises(ValueError, match=message):
        LightModel(**{field: bad})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"local_viewer": False}, "^local_viewer must be True in VTK's convention; .*always local"),
        ({"reflection": "blinn-phong"}, "^reflection must be 'phong' in VTK's convention; .*no other"),
    ],
)
def test_vtks_convention_allows_what_vtk_does(fields, message):
    with pytest.raises(ValueError, match=message):
        LightModel(convention="vtk", **fields)


# --- the scene ---


def test_scene_defaults():
    assert Scene() == Scene(lights=(), viewer=Viewer(), light_model=LightModel())
    assert [field.name for field in dataclasses.fields(Scene)] == ["lights", "viewer", "light_model"]


def test_scene_is_frozen_and_hashable_by_value():
    lights = [DirectionalLight(name="sun"), SpotLight(diffuse="red")]
    scene = Scene(lights=lights)
    assert scene == Scene(lights=tuple(lights))
    assert hash(scene) == hash(Scene(lights=iter(lights)))
    assert scene != Scene(lights=lights[::-1])
    lights.append(PointLight())
    assert len(scene.lights) == 2
    for field in dataclasses.fields(scene):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(scene, field.name, getattr(scene, field.name))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"viewer": pv.Camera()}, r"(?s)^viewer must be a Viewer; .*Viewer\.from_camera"),
        ({"viewer": None}, "^viewer must be a Viewer"),
        ({"light_model": "vtk"}, "^light_model must be a LightModel"),
        ({"lights": DirectionalLight()}, "^lights must be a sequence of lights; .*into a list"),
        ({"lights": "headlight"}, "^lights must be a sequence of lights"),
        ({"lights": None}, "^lights must be a sequence of lights"),
        ({"lights": {"sun": DirectionalLight()}}, "^lights must be a sequence of lights"),
        (
            {"lights": [DirectionalLight(), "lamp"]},
            "light must be a pvphong light, a pyvista.Light or a vtkLight; got lamp",
        ),
    ],
)
def test_scene_refuses_by_name(fields, message):
    with pytest.raises(ValueError, match=message):
        Scene(**fields)


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        ([], ()),
        (["", ""], ("0", "1")),
        (["sun", "", "lamp"], ("sun", "1", "lamp")),
        (["sun", "sun", "lamp"], ("0", "1", "lamp")),
        (["", "0x", "é"], ("0", "0x", "é")),
    ],
)
def test_a_lights_label_is_its_name_or_its_index(names, labels):
    assert light_labels(Scene(lights=[PointLight(name=name) for name in names])) == labels


@pytest.mark.parametrize("numbered", ["", "light "])
@pytest.mark.parametrize("names", [["1", ""], ["", "0"], ["2", "1", ""], ["1", "sun", "sun"], ["1", "1", "0"]])
def test_no_two_lights_have_the_same_label(names, numbered):
    for shown in (names, [f"{numbered}{name}" for name in names]):
        scene = Scene(lights=[PointLight(name=name, position=(0, 0, 2 + i)) for i, name in enumerate(shown)])
        assert len(set(light_labels(scene, numbered))) == len(names)


def test_pyvistas_and_vtks_lights_are_converted():
    lamp = pv.Light(position=(1, 2, 3), focal_point=(1, 2, 0), positional=True, cone_angle=20, color="red")
    plain = vtk.vtkLight()
    plain.SetLightTypeToHeadlight()
    scene = Scene(lights=[lamp, plain, PointLight()])
    assert [type(light) for light in scene.lights] == [SpotLight, DirectionalLight, PointLight]
    assert (scene.lights[0].position, scene.lights[0].diffuse) == ((1.0, 2.0, 3.0), (1.0, 0.0, 0.0))
    assert scene.lights[1].frame == "headlight"


@pytest.mark.parametrize("positional", [False, True])
def test_converted_camera_lights_ride_along_with_the_scenes_viewer(positional):
    viewer = Viewer(position=(4, -3, 2), focal_point=(1, 1, 1), up=(0, 0, 1))
    lamp = pv.Light(light_type="camera light", positional=positional, cone_angle=50)
    lamp.position, lamp.focal_point = (0.3, 0.2, 1.5), (0.1, -0.2, 0)
    scene = Scene(lights=[lamp], viewer=viewer)
    assert scene.lights[0].frame == "camera"
    placed = scene.world_lights[0]
    reference = renderer_of([lamp], viewer)
    reference.UpdateLightsGeometryToFollowCamera()
    along = np.subtract(lamp.GetTransformedFocalPoint(), lamp.GetTransformedPosition())
    np.testing.assert_allclose(unit(placed.direction), unit(along), atol=1e-14)
    if positional:
        np.testing.assert_allclose(placed.position, lamp.GetTransformedPosition(), atol=1e-13)


def test_world_lights_are_all_lights_in_their_order():
    viewer = Viewer(position=(0, 0, 5))
    lights = [PointLight(on=False), DirectionalLight(frame="headlight"), SpotLight(position=(0, 0, -1), frame="camera")]
    placed = Scene(lights=lights, viewer=viewer).world_lights
    assert [type(light) for light in placed] == [PointLight, DirectionalLight, SpotLight]
    assert {light.frame for light in placed} == {"world"}
    assert placed[0] is lights[0]
    assert placed[1].direction == (0.0, 0.0, -1.0)
    assert placed[2].position == (0.0, 0.0, 4.0)


def test_a_camera_light_needs_an_up_that_is_one():
    scene = Scene(lights=[PointLight(frame="camera")], viewer=Viewer(position=(0, 0, 1), up=(0, 0, 1)))
    with pytest.raises(ValueError, match=r"^up must be off the view axis"):
        _ = scene.world_lights


# --- files ---

FLOATS = st.floats(allow_nan=False, allow_infinity=False)
EXTREMES = st.sampled_from([0.0, -0.0, 5e-324, -5e-324, 2.2250738585072014e-308, sys.float_info.max, 1 / 3, 0.1])
any_float = FLOATS | EXTREMES
from_zero = any_float.map(abs)
vectors = st.tuples(any_float, any_float, any_float)
directions = vectors.filter(any)
colors = from_zero | st.tuples(from_zero, from_zero, from_zero)
texts = st.text(st.characters(), max_size=5)
commons = st.fixed_dictionaries(
    {},
    optional={
        "diffuse": colors,
        "specular": st.none() | colors,
        "ambient": colors,
        "intensity": from_zero,
        "on": st.booleans(),
        "frame": st.sampled_from(["world", "camera", "headlight"]),
        "name": texts,
    },
)
attenuations = st.tuples(from_zero, from_zero, from_zero).filter(any)
lights = st.one_of(
    st.builds(lambda d, common: DirectionalLight(d, **common), directions, commons),
    st.builds(lambda p, a, common: PointLight(p, a, **common), vectors, attenuations, commons),
    st.builds(
        lambda p, d, cone, e, a, common: SpotLight(p, d, cone, e, a, **common),
        vectors, directions, st.floats(0, 90, exclude_min=True), from_zero, attenuations, commons,
    ),
)  # fmt: skip
positive = from_zero.filter(bool)
viewers = (
    st.tuples(vectors, vectors)
    .filter(lambda pair: pair[0] != pair[1])
    .flatmap(
        lambda pair: st.builds(
            Viewer,
            position=st.just(pair[0]),
            focal_point=st.just(pair[1]),
            up=directions,
            parallel=st.booleans(),
            view_angle=st.floats(0, 179, exclude_min=True),
            parallel_scale=positive,
            clipping_range=st.tuples(positive, positive).map(sorted),
        )
    )
)
models = st.builds(
    LightModel,
    ambient=colors,
    local_viewer=st.booleans(),
    two_sided=st.booleans(),
    reflection=st.sampled_from(["phong", "blinn-phong"]),
    clamp=st.booleans(),
) | st.builds(LightModel.vtk, two_sided=st.booleans())
scenes = st.builds(Scene, lights=st.lists(lights, max_size=3), viewer=viewers, light_model=models)


@given(scene=scenes)
@settings(
    max_examples=120,
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_files_give_back_every_bit(scene, tmp_path):
    path = tmp_path / "scene.json"
    scene.save(path)
    loaded = Scene.load(path)
    assert loaded == scene
    assert repr(loaded) == repr(scene)  # tells −0.0 from 0.0, and an integer from a float
    assert os.listdir(tmp_path) == ["scene.json"]


def test_converted_lights_are_saved_as_pvphongs_own(tmp_path):
    scene = Scene(lights=[pv.Light(position=(1 / 3, 0, 1), positional=True, color="tomato"), vtk.vtkLight()])
    scene.save(tmp_path / "scene.json")
    assert Scene.load(str(tmp_path / "scene.json")) == scene


def test_the_file_is_readable_json(tmp_path):
    Scene(lights=[SpotLight(name="Lämpchen")]).save(tmp_path / "scene.json")
    document = json.loads((tmp_path / "scene.json").read_text(encoding="utf-8"))
    assert (document["format"], document["version"]) == ("pvphong scene", 1)
    assert document["lights"][0]["type"] == "spot"
    assert document["lights"][0]["cone_angle"] == 30.0
    assert document["viewer"]["position"] == [0.0, 0.0, 1.0]


def test_what_a_file_leaves_out_has_its_default(tmp_path):
    path = write(tmp_path, {"format": "pvphong scene", "version": 1, "lights": [{"type": "point", "diffuse": "red"}]})
    assert Scene.load(path) == Scene(lights=[PointLight(diffuse="red")])


def write(folder, document):
    path = folder / "scene.json"
    path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
    return path


def head(**entries):
    return {"format": "pvphong scene", "version": 1, **entries}


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("", r"^path must be a scene file in JSON; got .*scene\.json"),
        ("{lights: []}", "^path must be a scene file in JSON"),
        ([], '^format must be a JSON object with "format": "pvphong scene"; .*Scene.save writes one'),
        ({"version": 1}, "^format must be a JSON object"),
        ({"format": "glTF", "version": 1}, "^format must be a JSON object"),
        ({"format": "pvphong scene"}, "^version must be 1; got None"),
        (head(version=2), r"^version must be 1; got 2\. A newer pvphong"),
        (head(version="1"), "^version must be 1; got 1"),
        (head(camera={}), "^field of scene must be one of .*viewer.*; got camera"),
        (head(lights={}), "^lights must be a list"),
        (head(lights=["sun"]), r"^lights\[0\] must be a JSON object; got sun"),
        (head(lights=[{}]), r"^lights\[0\]\.type must be one of 'directional', 'point', 'spot'; got None"),
        (head(lights=[{"type": "spott"}]), r"^lights\[0\]\.type must be .*Did you mean 'spot'"),
        (head(lights=[{"type": ["spot"]}]), r"^lights\[0\]\.type must be one of"),
        (
            head(lights=[{"type": "point"}, {"type": "point", "cone_angle": 3}]),
            r"^field of lights\[1\] must be one of .*position.*; got cone_angle",
        ),
        (head(lights=[{"type": "spot", "cone_angle": 91}]), r"^lights\[0\]\.cone_angle must be .*<= 90; got 91"),
        (head(lights=[{"type": "point", "position": [0, "x", 0]}]), r"^lights\[0\]\.position\[1\] must be"),
        (head(lights=[{"type": "point", "diffuse": [255, 0, 0]}]), r"^lights\[0\]\.diffuse must be .*255"),
        (head(lights=[{"type": "point", "diffuse": {"r": 1}}]), r"^lights\[0\]\.diffuse must be"),
        (head(viewer=[]), "^viewer must be a JSON object"),
        (head(viewer={"fov": 3}), "^field of viewer must be one of .*view_angle.*; got fov"),
        (head(viewer={"up": [0, 0, 0]}), r"^viewer\.up must be a direction"),
        (head(viewer={"focal_point": [0, 0, 1]}), r"^viewer\.focal_point must be different from position"),
        (head(light_model={"clamp": 1}), r"^light_model\.clamp must be True or False"),
        (
            head(light_model={"convention": "vtk", "reflection": "blinn-phong"}),
            r"^light_model\.reflection must be 'phong' in VTK",
        ),
        (
            '{"format": "pvphong scene", "version": 1, "light_model": {"ambient": NaN}}',
            r"^light_model\.ambient must be",
        ),
        (
            '{"format": "pvphong scene", "version": 1, "light_model": {"ambient": 1e999}}',
            r"^light_model\.ambient must be",
        ),
    ],
)
def test_a_bad_file_is_refused_with_the_place(document, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        Scene.load(write(tmp_path, document))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ValueError, match=r"^path must be a scene file that can be read; got .*nowhere\.json"):
        Scene.load(tmp_path / "nowhere.json")
    with pytest.raises(ValueError, match=r"^path must be a scene file that can be read"):
        Scene.load(tmp_path)


def test_a_file_that_is_no_text(tmp_path):
    (tmp_path / "scene.json").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(ValueError, match=r"^path must be a scene file in JSON"):
        Scene.load(tmp_path / "scene.json")


def test_a_save_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "scene.json"
    scene = Scene(lights=[DirectionalLight(name="old")])
    scene.save(path)
    before = path.read_bytes()

    def write_half(self, text, **_):
        with open(self, "w", encoding="utf-8") as file:
            file.write(text[: len(text) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", write_half)
    with pytest.raises(ValueError, match=r"^path must be a file that can be written; .*No space left on device"):
        Scene(lights=[DirectionalLight(name="new")]).save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["scene.json"]


def test_save_into_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(ValueError, match=r"^path must be in a folder that exists; .*Create "):
        Scene().save(tmp_path / "nowhere" / "scene.json")


# --- plotters ---

POINTS = np.random.default_rng(7).normal(size=(40, 3))
NORMALS = np.random.default_rng(8).normal(size=(40, 3))
SHINY = Material(ambient=0.1, diffuse=(0.5, 0.6, 0.7), specular=0.6, shininess=9)


def unit(vector):
    return np.asarray(vector) / np.linalg.norm(vector)


def renderer_of(lights, viewer):
    renderer = vtk.vtkRenderer()
    for light in lights:
        renderer.AddLight(light)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(viewer.position)
    camera.SetFocalPoint(viewer.focal_point)
    camera.SetViewUp(viewer.up)
    return renderer


def as_vtk_has_it(light):
    """The world light that stands where VTK's own transformed coordinates say; read after VTK has updated them."""
    position, focal = light.GetTransformedPosition(), light.GetTransformedFocalPoint()
    common = {
        "diffuse": light.GetDiffuseColor(),
        "specular": light.GetSpecularColor(),
        "ambient": light.GetAmbientColor(),
        "intensity": light.GetIntensity(),
        "on": bool(light.GetSwitch()),
    }
    direction = np.subtract(focal, position)
    if not light.GetPositional():
        return DirectionalLight(direction=direction, **common)
    common |= {"position": position, "attenuation": light.GetAttenuationValues()}
    if light.GetConeAngle() >= 90:
        return PointLight(**common)
    return SpotLight(direction=direction, cone_angle=light.GetConeAngle(), exponent=light.GetExponent(), **common)


def assert_snapshot_is_vtks(plotter):
    """The scene's lights stand where VTK, brought up to date, has them; and they shade alike."""
    scene = Scene.from_plotter(plotter)
    plotter.renderer.UpdateLightsGeometryToFollowCamera()
    expected = [as_vtk_has_it(light) for light in plotter.renderer.GetLights()]
    assert len(scene.lights) == len(expected)
    size = np.linalg.norm(scene.viewer.position) + scene.viewer.distance
    for ours, vtks in zip(scene.world_lights, expected, strict=True):
        assert type(ours) is type(vtks)
        if hasattr(ours, "position"):
            np.testing.assert_allclose(ours.position, vtks.position, atol=1e-13 * size)
        if hasattr(ours, "direction"):
            np.testing.assert_allclose(unit(ours.direction), unit(vtks.direction), atol=1e-12)
    again = Scene(lights=expected, viewer=scene.viewer, light_model=scene.light_model)
    shades = [evaluate(POINTS, NORMALS, s, SHINY, precision="float64").rgb for s in (scene, again)]
    np.testing.assert_allclose(shades[0], shades[1], atol=1e-11)
    return scene


@pytest.fixture
def plotter():
    made = []

    def make(**options):
        made.append(pv.Plotter(off_screen=True, **options))
        made[-1].camera.position, made[-1].camera.focal_point = (4.0, -3.0, 2.5), (0.1, 0.2, 0.3)
        made[-1].camera.up = (0.1, 0.2, 1.0)  # not at a right angle to the view
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.mark.parametrize(("lighting", "count"), [("light kit", 5), ("three lights", 3), ("none", 0)])
def test_pyvistas_own_lighting(plotter, lighting, count):
    scene = assert_snapshot_is_vtks(plotter(lighting=lighting))
    assert len(scene.lights) == count


def test_viewer_and_light_model_of_a_plotter(plotter):
    shown = plotter()
    scene = Scene.from_plotter(shown)
    assert scene.viewer == Viewer.from_camera(shown.camera)
    assert scene.light_model == LightModel()


CUSTOM = {
    "scene light": {"light_type": "scene light"},
    "scene spot": {"light_type": "scene light", "positional": True, "cone_angle": 35, "exponent": 3},
    "scene lamp": {"light_type": "scene light", "positional": True, "cone_angle": 100},
    "headlight": {"light_type": "headlight"},
    "headlight spot": {"light_type": "headlight", "positional": True, "cone_angle": 60},
    "camera light": {"light_type": "camera light"},
    "camera spot": {"light_type": "camera light", "positional": True, "cone_angle": 60, "exponent": 2},
    "camera lamp": {"light_type": "camera light", "positional": True, "cone_angle": 180},
}


def custom(kind, *, transformed=False):
    light = pv.Light(**CUSTOM[kind], attenuation_values=(0.5, 0.1, 0.02))
    light.position, light.focal_point = (0.4, 1.1, 1.7), (-0.1, 0.2, -0.3)
    light.SetDiffuseColor(0.9, 1 / 3, 0.4)
    light.SetSpecularColor(0.2, 0.5, 1 / 7)
    if transformed:
        light.transform_matrix = [[0, -1, 0, 0.5], [2, 0, 0, -1], [0, 0, 1, 2], [0, 0, 0, 1]]
    return light


@pytest.mark.parametrize("kind", CUSTOM)
def test_a_light_of_every_kind_in_a_plotter(plotter, kind):
    shown = plotter(lighting="none")
    shown.add_light(custom(kind))
    assert_snapshot_is_vtks(shown)


@pytest.mark.parametrize("kind", CUSTOM)
def test_a_light_with_a_transform_matrix(plotter, kind):
    shown = plotter(lighting="none")
    shown.add_light(custom(kind, transformed=True))
    scene = assert_snapshot_is_vtks(shown)
    if kind.startswith("scene"):  # VTK puts its own matrix into camera lights
        assert scene != Scene.from_plotter(shown_with(plotter, custom(kind)))


def shown_with(plotter, light):
    shown = plotter(lighting="none")
    shown.add_light(light)
    return shown


@pytest.mark.parametrize("kind", CUSTOM)
def test_after_the_camera_has_moved_without_rendering(plotter, kind):
    shown = shown_with(plotter, custom(kind))
    shown.renderer.UpdateLightsGeometryToFollowCamera()
    before = Scene.from_plotter(shown)
    shown.camera.position, shown.camera.up = (-1.0, 6.0, -2.0), (1.0, 0.3, 0.0)
    stale = shown.renderer.lights[0].GetTransformedPosition()
    scene = assert_snapshot_is_vtks(shown)
    if not kind.startswith("scene"):  # the lights really had been left behind
        assert shown.renderer.lights[0].GetTransformedPosition() != stale
        assert scene.world_lights != before.world_lights


def test_after_a_render(plotter):
    shown = plotter(lighting="light kit")
    shown.add_light(custom("camera spot"))
    shown.add_mesh(pv.Sphere())
    shown.show(auto_close=False)
    shown.camera.azimuth = 40
    assert_snapshot_is_vtks(shown)


def test_off_lights_stay_off_lights(plotter):
    shown = plotter(lighting="three lights")
    shown.renderer.lights[1].on = False
    assert [light.on for light in Scene.from_plotter(shown).lights] == [True, False, True]


def test_the_plotter_is_not_modified(plotter):
    shown = plotter(lighting="light kit")
    shown.add_light(custom("camera spot"))
    before = [light.GetMTime() for light in shown.renderer.GetLights()]
    camera = shown.camera.GetMTime()
    Scene.from_plotter(shown)
    assert [light.GetMTime() for light in shown.renderer.GetLights()] == before
    assert shown.camera.GetMTime() == camera


def test_a_snapshot_before_the_first_frame_leaves_the_view_to_pyvista():
    shown = pv.Plotter(off_screen=True, window_size=(64, 64))
    Scene.from_plotter(shown)
    shown.add_mesh(pv.Sphere(radius=100))
    shown.show(auto_close=False)
    distance = np.linalg.norm(shown.camera.position)
    shown.close()
    assert distance > 100  # outside of the sphere, as PyVista puts it


def test_the_snapshot_is_of_the_active_renderer(plotter):
    shown = plotter(shape=(1, 2), lighting="none")
    shown.subplot(0, 1)
    shown.add_light(custom("scene light"), only_active=True)
    assert len(Scene.from_plotter(shown).lights) == 1
    shown.subplot(0, 0)
    assert len(Scene.from_plotter(shown).lights) == 0


def test_the_snapshot_can_be_saved(plotter, tmp_path):
    scene = Scene.from_plotter(plotter(lighting="light kit"))
    scene.save(tmp_path / "scene.json")
    assert Scene.load(tmp_path / "scene.json") == scene


@pytest.mark.parametrize("bad", [None, "plotter", pv.Sphere(), Scene()])
def test_from_plotter_refuses_others(bad):
    with pytest.raises(ValueError, match=r"^plotter must be a pyvista\.Plotter; got "):
        Scene.from_plotter(bad)


def test_lights_that_pvphong_does_not_allow_are_refused_by_name(plotter):
    shown = plotter(lighting="none")
    light = pv.Light(positional=True)
    light.SetAttenuationValues(0, 0, 0)
    shown.add_light(light)
    with pytest.raises(ValueError, match=r"^attenuation"):
        Scene.from_plotter(shown)


def test_nan_cannot_get_into_a_file():
    for make in (
        lambda: DirectionalLight(direction=(math.nan, 0, 1)),
        lambda: Viewer(parallel_scale=math.nan),
        lambda: LightModel(ambient=math.nan),
        lambda: dataclasses.replace(PointLight(), intensity=math.nan),
    ):
        with pytest.raises(ValueError, match=r"got .*nan"):
            make()
