"""`ph.Report`, and the types visible to editors."""

import json
import subprocess
import sys

import pytest

import pvphong as ph
from pvphong.shading import kernel

TYPED = """
import pyvista as pv
import pvphong as ph
phong: ph.MeshPhong = pv.Sphere().phong
blocks: ph.BlocksPhong = pv.MultiBlock().phong
window: ph.PlotterPhong = pv.Plotter().phong
reveal_type(phong.shade(ph.PointLight()))
reveal_type(blocks.shade(ph.PointLight()))
reveal_type(window.add_light(ph.PointLight()))
phong.shad
"""


def test_it_names_versions_evaluator_and_ray_tracer(monkeypatch):
    text = str(ph.Report(gpu=False))
    assert all(name in text for name in ("pvphong", "pyvista", "vtk", "numpy", "Evaluator", "Rays"))
    monkeypatch.setattr(kernel, "obstacle", lambda: ("where Numba is not installed", ""))
    assert "NumPy, where Numba is not installed" in str(ph.Report(gpu=False))


def test_it_names_the_renderer():
    assert "GPU Renderer" in str(ph.Report())


def test_an_annotation_gives_editors_the_methods_and_what_they_return(tmp_path):
    pytest.importorskip("pyright")
    tmp_path.joinpath("user.py").write_text(TYPED)
    tmp_path.joinpath("pyrightconfig.json").write_text(json.dumps({"extraPaths": sys.path}))
    words = [sys.executable, "-m", "pyright", "--outputjson", "--pythonpath", sys.executable, "user.py"]
    told = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False).stdout
    if not told.startswith("{"):
        pytest.skip("pyright needs Node.js, which it could not get")
    messages = [(each["severity"], each["message"]) for each in json.loads(told)["generalDiagnostics"]]
    revealed = [message.rsplit(" is ")[-1] for severity, message in messages if severity == "information"]
    assert revealed == ['"PolyData"', '"MultiBlock"', '"LightHandle"']
    assert [message.splitlines()[0] for severity, message in messages if severity == "error"] == [
        'Cannot access attribute "shad" for class "MeshPhong"'
    ]
