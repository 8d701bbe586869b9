"""Serving a studio: `plotter.phong.studio()` in a running event loop, as in a notebook, and its errors."""

import asyncio
import gc
import re
import socket

import pytest
import pyvista as pv

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.cli.app import main
from pvphong.studio.web.serving import StudioFrame, free_port


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter((200, 150))
    plotter.phong.add_light(ph.DirectionalLight(name="sun"))
    plotter.phong.add_mesh(pv.Sphere(), ph.Material())
    return plotter


async def until(is_so):
    for _ in range(100):
        await asyncio.sleep(0.05)
        if is_so():
            return


def test_in_a_notebook_the_page_stands_below_the_cell(plotter):
    async def cell():
        from aiohttp import ClientSession

        shown = plotter.phong.studio(file="ball.ply")
        address = re.search(r'src="(http://127\.0\.0\.1:\d+/)"', shown._repr_html_())[1]
        assert repr(shown) == f"<Studio at {address}>"
        await until(lambda: shown.studio.server.port)
        async with ClientSession() as session, session.get(address) as page:
            text = await page.text()
        shown.studio.document.edit("light.1.intensity", 0.5)
        await shown.close()
        return text

    text = asyncio.run(cell())
    assert '<div id="app">' in text
    assert plotter.phong.lights == (ph.DirectionalLight(intensity=0.5, name="sun"),)


def test_what_the_page_changes_of_the_window_is_put_back(plotter):
    async def cell():
        plotter.render_window.SetMultiSamples(4)
        shown = plotter.phong.studio(file="ball.ply")
        during = plotter.render_window.GetMultiSamples()
        await shown.close()
        return during, plotter.render_window.GetMultiSamples()

    assert asyncio.run(cell()) == (0, 4)


def test_a_studio_whose_port_is_taken_meanwhile_lets_go_of_the_window(plotter, monkeypatch, caplog):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        monkeypatch.setattr("pvphong.studio.web.serving.free_port", lambda _host, _port: taken.getsockname()[1])
        plotter.render_window.SetMultiSamples(4)
        with pytest.raises(OSError, match="bind on address"):
            plotter.phong.studio(browser=False)
        assert plotter.render_window.GetMultiSamples() == 4
        assert not plotter.phong._subplot.lit.is_in_a_page

        async def cell():
            await plotter.phong.studio(browser=False).close()

        asyncio.run(cell())
        assert plotter.render_window.GetMultiSamples() == 4
    gc.collect()
    assert not [record for record in caplog.records if "never retrieved" in record.message]


def test_the_rig_is_kept_when_it_changes_where_that_is_asked_for(plotter, tmp_path):
    path = tmp_path / "ball-rig.json"

    async def cell():
        shown = plotter.phong.studio(file="ball.ply", keep=path)
        studio = shown.studio
        assert not path.exists()
        studio._triggers["edit"]("light.1.intensity", 0.5)
        await until(path.exists)
        assert ph.Scene.load(path) == plotter.phong.scene
        assert ph.load_materials(path) == {"default": ph.Material()}
        studio._triggers["edit"]("light.1.intensity", 0.25)
        await shown.close()  # saves the last change too

    asyncio.run(cell())
    assert ph.Scene.load(path).lights[0].intensity == 0.25
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_a_rig_that_cannot_be_kept_is_said_without_folders_and_another_mesh_is_not_kept_there(plotter, tmp_path):
    async def cell():
        shown = plotter.phong.studio(keep=tmp_path / "gone" / "a-rig.json")
        shown.studio._save()
        said = shown.studio.server.state.notice
        shown.studio.open_example("nut")
        shown.studio.say("")
        shown.studio._save()
        again = shown.studio.server.state.notice
        await shown.close()
        return said, again

    said = "The rig is not saved: a-rig.json cannot be written, or a map is an array without a name."
    assert asyncio.run(cell()) == (said, "")


def test_the_command_begins_with_the_rig_that_was_kept(tmp_path, monkeypatch):
    mesh, rig = tmp_path / "ball.vtp", tmp_path / "ball-rig.json"
    pv.Sphere().save(mesh)
    given = []
    monkeypatch.setattr("pvphong.plotter.PlotterPhong.studio", lambda phong, **how: given.append((phong.lights, how)))
    assert main(["studio", str(mesh), "--keep", "--no-browser"]) == 0
    lamp = ph.PointLight((1, 2, 3), name="mine")
    ph.Scene([lamp], ph.Viewer((0, 0, 5))).save(rig)
    assert main(["studio", str(mesh), "--no-browser"]) == 0
    assert main(["studio", str(mesh), "--keep", "--no-browser"]) == 0
    (first, how), (second, _), (third, _) = given
    assert (first, third) == (second, (lamp,))
    assert how["keep"] == rig


def test_a_port_that_is_taken_is_refused():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ValueError, match="port must be available on this machine"):
            free_port("127.0.0.1", taken.getsockname()[1])
    assert 0 < free_port("127.0.0.1", 0) < 65536


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"port": -1}, "port must be a whole number"),
        ({"port": 80.5}, "port must be a whole number"),
        ({"port": 2**16}, "port must be a whole number"),
        ({"host": 5}, "host must be a string"),
        ({"host": "nowhere.invalid"}, "port must be available on this machine at nowhere.invalid"),
        ({"file": 3}, "file must be a string"),
        ({"browser": 3}, "browser must be True or False"),
        ({"keep": 3}, "keep must be a path, or None; got 3. Changed lights"),
    ],
)
def test_what_is_not_allowed_is_refused_before_anything_is_served(plotter, options, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.studio(**options)


def test_without_the_extra_both_ways_to_the_page_say_how_to_install_it(plotter, monkeypatch, capsys):
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    said = (
        "must be used with its packages installed; got a missing package. Run: pip install trame-pyvista trame-vuetify"
    )
    with pytest.raises(ValueError, match="^plotter.phong.studio " + re.escape(said)):
        plotter.phong.studio()
    assert main(["studio", "--no-browser"]) == 2
    assert capsys.readouterr().err == f"error: pvphong studio {said}\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere.stl"], "error: mesh must be a file that exists; got nowhere.stl."),
        (["--port", "99999"], "error: --port must be a whole number from 0 to 65535; got 99999."),
        (["--scene", "rig.json"], "error: --scene must be used with a mesh file; got rig.json."),
        (["--keep"], "error: --keep must be used with a mesh file; got True."),
        (["--host", "nowhere.invalid"], "error: port must be available on this machine at nowhere.invalid"),
    ],
)
def test_the_command_line_says_what_is_wrong_in_one_line(words, message, capsys):
    assert main(["studio", *words, "--no-browser"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(message)
    assert said.count("\n") == 1


def test_a_frame_takes_no_attribute_that_it_has_not():
    frame = StudioFrame(None, "http://localhost")
    with pytest.raises(AttributeError, match=r"^StudioFrame has no attribute 'adress'\. Did you mean 'address'"):
        frame.adress = ""
