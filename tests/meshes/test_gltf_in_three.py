"""three.js, which trimesh includes, shows a .glb like `plot`: colours are not lit again."""

from __future__ import annotations

import base64
import importlib.util
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from browsers import needs_a_browser
from PIL import Image

import pvphong as ph

SIZE = 320

PAGE = """<html><body style="margin:0"><script>%s</script><script>
const renderer = new THREE.WebGLRenderer({preserveDrawingBuffer: true});
renderer.setSize(%d, %d);
document.body.appendChild(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xffffff);
const camera = new THREE.PerspectiveCamera(30, 1, 0.1, 100);
camera.position.set(%f, %f, %f);
camera.lookAt(0, 0, 0);
new THREE.GLTFLoader().load("data:application/octet-stream;base64,%s", (file) => {
    scene.add(file.scene);
    renderer.render(scene, camera);
    window.picture = renderer.domElement.toDataURL();
}, undefined, (error) => { window.picture = String(error); });
</script></body></html>"""


def three():
    """Return the code of three.js and of its glTF reader."""
    folder = Path(importlib.util.find_spec("trimesh").origin).parent / "resources" / "templates"
    page = zipfile.ZipFile(folder / "viewer.zip").read("viewer.html.template").decode()
    return page[page.index("<script>") + len("<script>") : page.index("var camera,controls")]


@needs_a_browser
def test_three_js_shows_a_glb_as_plot_does(tmp_path, driver):
    pytest.importorskip("trimesh")
    from selenium.webdriver.support.wait import WebDriverWait

    torus = pv.ParametricTorus(ringradius=0.6, crosssectionradius=0.3, u_res=220, v_res=150)
    light = ph.PointLight(position=(3, -2, 3), diffuse=(1.0, 0.8, 0.5))
    shaded = torus.phong.shade([light], ph.Material(diffuse=(0.8, 0.6, 0.9), specular=0.5, shininess=20))
    shaded.phong.save(tmp_path / "it.glb")
    x, y, z = 3.0, -2.0, 1.5
    how = {"cpos": [(x, y, z), (0, 0, 0), (0, 0, 1)], "window_size": [SIZE, SIZE], "off_screen": True}
    shaded.phong.plot(screenshot=tmp_path / "it.png", show_axes=False, anti_aliasing=False, **how)
    expected = np.asarray(Image.open(tmp_path / "it.png").convert("RGB")).astype(int)
    content = base64.b64encode((tmp_path / "it.glb").read_bytes()).decode()
    (tmp_path / "page.html").write_text(PAGE % (three(), SIZE, SIZE, x, z, -y, content), encoding="utf-8")
    driver.get(f"file://{tmp_path / 'page.html'}")
    picture = WebDriverWait(driver, 60).until(lambda page: page.execute_script("return window.picture"))
    assert picture.startswith("data:image/png"), picture
    found = np.asarray(Image.open(io.BytesIO(base64.b64decode(picture.split(",")[1]))).convert("RGB")).astype(int)
    inside = (expected < 250).any(axis=2)
    steps = [(axis, step) for axis in (0, 1) for step in (-2, -1, 1, 2)]
    steep = np.max([np.abs(expected - np.roll(expected, step, axis)).max(axis=2) for axis, step in steps], axis=0) > 16
    for axis, step in steps:  # not near edges, which only one of the two smooths
        steep |= np.roll(steep, step, axis)
    inside &= ~steep
    assert inside.sum() > SIZE * SIZE / 8
    assert np.ptp(found[inside], axis=0).min() > 60
    assert np.abs(found - expected)[inside].max() <= 2
