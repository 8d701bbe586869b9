"""Screenshots and exports of a plotter contain no gizmos unless an option includes them."""

import base64
import json
import re
from hashlib import sha256
from zipfile import ZipFile

import numpy as np
import pytest
import pyvista as pv
from served import Server

from pvphong import PointLight


@pytest.fixture
def plotter(new_plotter):
    """A plotter before its first frame."""
    made = new_plotter((200, 150))
    made.phong.add_light(PointLight(position=(0.4, -0.4, 0.4), attenuation=(1, 0, 1)))
    made.phong.add_mesh(pv.Sphere())
    return made


def test_a_screenshot_is_without_gizmos_unless_an_option_shows_them(plotter, tmp_path):
    plotter.phong.add_gizmos()
    clean = plotter.screenshot(return_img=True)
    assert (plotter.image != clean).any()  # the window shows them again
    np.testing.assert_array_equal(plotter.screenshot(tmp_path / "a.png", return_img=True), clean)
    np.testing.assert_array_equal(pv.read(tmp_path / "a.png").active_scalars.reshape(150, 200, 3)[::-1], clean)
    plotter.phong.add_gizmos(in_screenshots=True)
    assert (plotter.screenshot(return_img=True) != clean).any()
    plotter.phong.remove_gizmos()
    np.testing.assert_array_equal(plotter.screenshot(return_img=True), clean)


def test_exports_are_without_gizmos(plotter, tmp_path):
    plotter.show(auto_close=False)
    for name in ("clean", "with"):
        plotter.export_obj(tmp_path / f"{name}.obj")
        plotter.export_gltf(tmp_path / f"{name}.gltf")
        plotter.phong.add_gizmos()
        plotter.render()
    assert (tmp_path / "with.obj").read_text().replace("with", "clean") == (tmp_path / "clean.obj").read_text()
    assert (tmp_path / "with.gltf").read_text() == (tmp_path / "clean.gltf").read_text()


def test_what_trame_exports_is_without_gizmos_and_lit(tmp_path):
    pytest.importorskip("trame_pyvista", reason="PyVista exports web pages only with the package trame-pyvista")
    server = Server("remote")
    colors = server.ask(f"export {tmp_path}")["colors"]
    assert server.close() == 0
    assert b"</html>" in (tmp_path / "ball.html").read_bytes()
    with ZipFile(tmp_path / "ball.vtksz") as archive:
        exported = json.loads(archive.read("index.json"))
    kinds = set(re.findall(r'"type": "(vtk\w+)"', json.dumps(exported["scene"])))
    assert "vtkOpenGLActor" in kinds
    assert not [kind for kind in kinds if "2D" in kind or "Text" in kind]
    arrays = [base64.b64decode(array["content"]) for array in exported["hashes"].values()]
    assert colors in [sha256(array).hexdigest() for array in arrays]


def test_the_plotters_own_methods_come_back_at_the_end(plotter):
    ours = {"screenshot", "save_graphic", "export_obj", "export_gltf", "export_vrml"}
    assert vars(plotter).keys() > ours
    assert plotter.screenshot.__doc__ == pv.Plotter.screenshot.__doc__
    plotter.close()
    assert not vars(plotter).keys() & ours
