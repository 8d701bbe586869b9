"""Downloads: the script reproduces the lit mesh exactly, and rigs and pictures match the view."""

import json
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from strategies import hunt, moderate_case

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.studio.web.downloads import EXAMPLES, FILES, Downloads, HasArrays, Picture, python_of, reading_file
from pvphong.studio.web.kinds import new_reflectance


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(
        ph.SpotLight.at((2, 1, 3), target=(0, 0, 0.1), cone_angle=40, diffuse="orange", name="lamp")
    )
    plotter.phong.add_light(ph.DirectionalLight((0.1, -1, -0.3), intensity=1 / 3, frame="camera"))
    plotter.camera_position = [(3, 2, 1), (0, 0, 0), (0, 0, 1)]
    return plotter


def taken(plotter, reading='ph.read("part.vtp")', **options):
    lit = plotter.phong._subplot.lit
    meshes = {f"part {k}" if k else "part": mesh for k, mesh in enumerate(lit.subjects)}
    tolerance, stem = options.get("tolerance", 0.0), options.get("stem", "part")
    picture = picture_of(plotter, options.get("size", (64, 48)))
    return Downloads(meshes, plotter.phong.scene, tolerance, reading, stem, {}, stage=lit.stage, picture=picture)


def picture_of(plotter, size=(64, 48)):
    return Picture(size, plotter.background_color.hex_rgb, plotter.phong.display)


def run(script, folder, monkeypatch):
    """Run a script and return its `lit`."""
    monkeypatch.chdir(folder)
    names = {}
    exec(compile(script, "script", "exec"), names)
    return names["lit"]


WRITTEN = [kind(name="it's", diffuse=(0.1, 1 / 3, 2.0), frame="camera") for kind in LIGHT_TYPES.values()]
WRITTEN += [ph.Material(diffuse="red", reflectance=new_reflectance(name)) for name in REFLECTANCES]
WRITTEN += [replace(ph.Material.named("chalk"), albedo="scan")]


@pytest.mark.parametrize("value", WRITTEN)
def test_every_light_and_reflectance_and_a_named_array_can_be_written_as_python(value):
    assert eval(python_of(value), {"ph": ph}) == value


def test_python_gives_scene_and_material_again_to_the_bit():
    written = []

    def check(case):
        for value in (case.scene, case.material):
            try:
                code = python_of(value)
            except HasArrays:
                continue
            assert eval(code, {"ph": ph}) == value
            written.append(code)

    hunt(lambda dice: moderate_case(dice, "standard"), check, 60)
    assert len(written) > 60


@pytest.mark.parametrize("tolerance", [0.0, 1 / 255])
@pytest.mark.parametrize("is_moved", [False, True])
def test_the_script_gives_the_same_bits_as_the_lit_mesh(plotter, tmp_path, monkeypatch, tolerance, is_moved):
    mesh = pv.examples.load_nut()
    mesh.save(tmp_path / "part.vtp")
    actor = plotter.phong.add_mesh(mesh, ph.Material(specular=0.4, shininess=30, reflectance=ph.GGX(roughness=0.4)))
    if is_moved:
        actor.rotate_x(30)
        actor.scale = (0.01, 0.02, 0.01)
    downloads = taken(plotter, tolerance=tolerance)
    lit = downloads.lit
    assert lit.n_points > mesh.n_points  # its edges are sharp
    np.testing.assert_array_equal(run(downloads.script(), tmp_path, monkeypatch)["phong"], lit["phong"])
    assert len(downloads.script().splitlines()) <= 18
    np.testing.assert_array_equal(pv.read(tmp_path / "part-lit.vtp")["phong"], lit["phong"])


TURNED = pv.Transform().rotate_z(40).scale(1.0, 0.5, -2.0).translate((0.3, 0.1, 0.7)).matrix


@pytest.mark.parametrize("bounces", [0, 2])
def test_what_is_moved_is_lit_where_the_view_has_it(plotter, tmp_path, monkeypatch, bounces):
    """The actor has a matrix and a position, mirrored; two blocks move together, with different materials."""
    bowl = pv.Sphere(end_phi=100, theta_resolution=16, phi_resolution=12).compute_normals(auto_orient_normals=False)
    blocks = pv.MultiBlock({"bowl": bowl, "floor": pv.Plane(center=(0, 0, -0.6), i_size=3, j_size=3)})
    plotter.phong.light_model = ph.LightModel(shadows=True, bounces=bounces)
    for mesh in (bowl, blocks):
        name = "part.vtm" if mesh is blocks else "part.vtp"
        mesh.save(tmp_path / name)
        materials = {"bowl": ph.Material.named("gold"), "floor": ph.Material()} if mesh is blocks else "gold"
        actors = plotter.phong.add_mesh(mesh, materials, name="part")
        for actor in actors if mesh is blocks else [actors]:
            actor.user_matrix = TURNED
            actor.position = (0.2, -0.4, 0.1)
            actor.rotate_x(25)
        plotter.show(auto_close=False)
        plotter.render()
        lits = plotter.phong._subplot.lit.meshes
        names = blocks.keys() if mesh is blocks else ["part"]
        downloads = Downloads(
            dict(zip(names, lits, strict=True)), plotter.phong.scene, 0.0, reading_file(name), "part", {}
        )
        downloads.picture = picture_of(plotter)
        lit, again = downloads.lit, run(downloads.script(), tmp_path, monkeypatch)
        for which, shown in zip(names, lits, strict=True):
            own, other = (lit[which], again[which]) if mesh is blocks else (lit, again)
            np.testing.assert_array_equal(other["phong"], own["phong"])
            assert np.abs(np.asarray(shown.drawn["phong"]) - 255.0 * own["phong"]).max() <= 1.01
        image = np.asarray(pv.read(tmp_path / downloads.write("png", tmp_path)).active_scalars)
        view = plotter.screenshot(return_img=True)[::-1].reshape(-1, 3)
        assert np.abs(image.astype(int) - view).mean() < 6.0
        plotter.phong.display = ph.Display(-2.0)
        downloads.picture = picture_of(plotter)
        image = np.asarray(pv.read(tmp_path / downloads.write("png", tmp_path)).active_scalars)
        plotter.render()
        exposed = plotter.screenshot(return_img=True)[::-1].reshape(-1, 3)
        assert np.abs(exposed.astype(int) - view).mean() > 1.5 or mesh is blocks  # few of their vertices are lit
        assert np.abs(image.astype(int) - exposed).mean() < 6.0
        plotter.phong.display = ph.Display()
        plotter.remove_actor(actors)
    assert json.loads(downloads.read("rig")[1])["materials"].keys() == {"bowl", "floor"}


LOOKS = {
    "plain": (None, ph.Display()),
    "exposed": (None, ph.Display(-1.5, "filmic")),
    "on a backdrop": ("backdrop", ph.Display(0.5)),
    "on a plinth": ("plinth", ph.Display()),
}


@pytest.mark.parametrize("look", LOOKS)
def test_the_script_draws_the_picture_that_is_downloaded(plotter, tmp_path, monkeypatch, look):
    kind, plotter.phong.display = LOOKS[look]
    mesh = pv.examples.load_nut()
    mesh.save(tmp_path / "part.vtp")
    plotter.camera_position = [(60, 40, 30), (0, 0, 0), (0, 0, 1)]
    actor = plotter.phong.add_mesh(mesh, "gold", name="part")
    plotter.phong.light_model = ph.LightModel(shadows=True)
    if kind is None:
        actor.position = (1.0, 2.0, 3.0)
    else:
        plotter.phong.add_stage(kind, "chalk")
    plotter.set_background("#336699")
    downloads = taken(plotter)
    drawn = pv.read(downloads.write("png", tmp_path)).active_scalars.astype(int)
    downloads.write("vtp", tmp_path).rename(tmp_path / "own.vtp")
    (tmp_path / "part.png").unlink()
    run(downloads.script(), tmp_path, monkeypatch)
    again = pv.read(tmp_path / "part.png").active_scalars.astype(int)
    assert np.abs(again - drawn).max() <= 1
    assert drawn.std() > 20
    own, saved = pv.read(tmp_path / "own.vtp"), pv.read(tmp_path / "part-lit.vtp")
    assert saved.n_points == plotter.phong._subplot.lit.subjects[0].drawn.n_points  # without the stage
    np.testing.assert_array_equal(saved["phong"], own["phong"])


def test_meshes_are_downloaded_with_the_shadow_of_their_stage_but_without_it(plotter):
    ball, lamp = pv.Sphere(), ph.PointLight((0, 0, -3), name="below")
    plotter.phong.add_light(lamp)
    plotter.phong.add_mesh(ball)
    plotter.phong.light_model = ph.LightModel(shadows=True)
    alone = taken(plotter).lit
    below = alone.points[:, 2] < -0.3
    plotter.phong.add_stage("ground")
    on_ground = taken(plotter).lit
    np.testing.assert_array_equal(on_ground.points, alone.points)
    assert alone["phong"][below].mean() > on_ground["phong"][below].mean() + 0.1


def test_a_transparent_picture_is_covered_where_the_mesh_is(plotter, tmp_path):
    plotter.phong.add_mesh(pv.Sphere(), ph.Material(ambient="white", diffuse=0))
    downloads = taken(plotter)
    downloads.picture = replace(downloads.picture, background="transparent")
    image = pv.read(downloads.write("png", tmp_path)).active_scalars.reshape(48, 64, 4)
    assert image[24, 32, 3] == 255
    assert image[0, 0, 3] == 0


def test_what_no_code_can_hold_is_read_from_the_rig(plotter, tmp_path, monkeypatch):
    mesh = pv.Sphere()
    mesh.save(tmp_path / "part.vtp")
    sky = ph.EnvironmentLight(image=np.random.default_rng(7).random((8, 16, 3)), name="sky")
    plotter.phong.add_light(sky)
    plotter.phong.add_mesh(mesh)
    downloads = taken(plotter)
    name, rig = downloads.read("rig")
    assert f'ph.Scene.load("{name}")' in downloads.script()
    (tmp_path / name).write_bytes(rig)
    np.testing.assert_array_equal(run(downloads.script(), tmp_path, monkeypatch)["phong"], downloads.lit["phong"])


def test_every_file_is_what_it_says(plotter, tmp_path):
    plotter.phong.add_mesh(pv.Sphere(), "gold")
    plotter.phong.add_gizmos()
    downloads = taken(plotter, stem="../a b/ü")
    for what in FILES:
        if what == "vtkhdf":
            continue
        name, content = downloads.read(what)
        assert "/" not in name
        (tmp_path / name).write_bytes(content)
    found = sorted(path.name for path in tmp_path.iterdir())
    assert found == sorted(
        ["a-b-ü-lit.ply", "a-b-ü-lit.py", "a-b-ü-lit.vtp", "a-b-ü-rig.json", "a-b-ü-lit.glb", "a-b-ü.png"]
    )
    picture = pv.read(tmp_path / "a-b-ü.png")
    assert picture.dimensions == (64, 48, 1)
    assert np.ptp(picture.active_scalars) > 50
    assert b"KHR_materials_unlit" in (tmp_path / "a-b-ü-lit.glb").read_bytes()
    assert "RGB" in pv.read(tmp_path / "a-b-ü-lit.ply").point_data
    assert ph.load_materials(tmp_path / "a-b-ü-rig.json") == {"default": ph.Material.named("gold")}
    assert ph.Scene.load(tmp_path / "a-b-ü-rig.json") == plotter.phong.scene


def test_what_cannot_be_made_is_refused_in_one_line(plotter):
    with pytest.raises(ValueError, match="mesh must be open; got none"):
        _ = taken(plotter).lit
    plotter.phong.add_mesh(pv.Sphere())
    with pytest.raises(ValueError, match="file must be one of"):
        taken(plotter).read("exe")
    with pytest.raises(ValueError, match="width must be"):
        taken(plotter, size=(0, 10)).read("png")
    with pytest.raises(ValueError, match="height must be"):
        taken(plotter, size=(10, 10**9)).read("png")
    plotter.phong.add_mesh(pv.Cube()).position = (1, 0, 0)
    with pytest.raises(ValueError, match="transform and feature angle must be the same for all meshes"):
        _ = taken(plotter).lit


def test_where_a_mesh_casts_no_shadows_the_lit_mesh_is_refused(plotter):
    plotter.phong.add_mesh(pv.Sphere(), casts_shadows=False)
    assert taken(plotter).lit["phong"].any()  # no shadows in the light model
    plotter.phong.light_model = ph.LightModel(shadows=True)
    with pytest.raises(ValueError, match="casts_shadows must be True for all meshes"):
        _ = taken(plotter).lit


def test_the_examples_come_with_pyvista():
    for function in EXAMPLES.values():
        assert getattr(pv.examples, function)().n_points


def test_files_are_read_by_their_names_alone():
    assert reading_file("/home/somebody/part.stl") == "ph.read('part.stl')"
    assert eval(reading_file('a"b.stl').replace("ph.read", "")) == 'a"b.stl'
