"""`ph.Report`."""

import pvphong as ph
from pvphong.shading import kernel


def test_it_names_versions_evaluator_and_ray_tracer(monkeypatch):
    text = str(ph.Report(gpu=False))
    assert all(name in text for name in ("pvphong", "pyvista", "vtk", "numpy", "Evaluator", "Rays"))
    monkeypatch.setattr(kernel, "obstacle", lambda: ("where Numba is not installed", ""))
    assert "NumPy, where Numba is not installed" in str(ph.Report(gpu=False))


def test_it_names_the_renderer():
    assert "GPU Renderer" in str(ph.Report())
