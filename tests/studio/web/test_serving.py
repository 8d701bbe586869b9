"""Where a studio runs: `plotter.phong.studio()` in a loop that runs already, as a notebook's, and what it refuses."""

import asyncio
import re
import socket

import pytest
import pyvista as pv

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.cli.app import main
from pvphong.studio.web.serving import free_port


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter((200, 150))
    plotter.phong.add_light(ph.DirectionalLight(name="sun"))
    plotter.phong.add_mesh(pv.Sphere())
    return plotter


def test_in_a_notebook_the_page_stands_below_the_cell(plotter):
    async def cell():
        from aiohttp import ClientSession

        shown = plotter.phong.studio(file="ball.ply")
        address = re.search(r'src="(http://127\.0\.0\.1:\d+/)"', shown._repr_html_())[1]
        assert repr(shown) == f"<Studio at {address}>"
        for _ in range(100):
            await asyncio.sleep(0.05)
            if shown.studio.server.port:
                break
        async with ClientSession() as session, session.get(address) as page:
            text = await page.text()
        shown.studio.document.edit("light.1.intensity", 0.5)
        await shown.close()
        return text

    text = asyncio.run(cell())
    assert '<div id="app">' in text
    assert plotter.phong.lights == (ph.DirectionalLight(intensity=0.5, name="sun"),)


def test_a_port_that_is_taken_is_refused():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ValueError, match="port must be one that this machine can listen on"):
            free_port("127.0.0.1", taken.getsockname()[1])
    assert 0 < free_port("127.0.0.1", 0) < 65536


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"port": -1}, "port must be a whole number"),
        ({"port": 80.5}, "port must be a whole number"),
        ({"port": 2**16}, "port must be a whole number"),
        ({"host": 5}, "host must be a string"),
        ({"host": "nowhere.invalid"}, "port must be one that this machine can listen on at nowhere.invalid"),
        ({"file": 3}, "file must be a string"),
        ({"browser": 3}, "browser must be True or False"),
    ],
)
def test_what_is_not_allowed_is_refused_before_anything_is_served(plotter, options, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.studio(**options)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere.stl"], "error: mesh must be a file that exists; got nowhere.stl."),
        (["--port", "99999"], "error: port must be a whole number from 0 to 65535; got 99999."),
        (["--scene", "rig.json"], "error: --scene must be left out without a mesh; got rig.json."),
        (["--host", "nowhere.invalid"], "error: port must be one that this machine can listen on at nowhere.invalid"),
    ],
)
def test_the_command_line_says_what_is_wrong_in_one_line(words, message, capsys):
    assert main(["studio", *words, "--no-browser"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(message)
    assert said.count("\n") == 1


def test_a_plotter_that_is_closed_has_no_studio(plotter):
    plotter.close()
    with pytest.raises(ValueError, match="plotter must be open"):
        plotter.phong.studio()
