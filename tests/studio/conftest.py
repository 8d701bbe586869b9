import pytest
import pyvista as pv


@pytest.fixture(autouse=True)
def _one_sample_for_each_pixel(monkeypatch):
    """Use one sample per pixel: PyVista's eight take four times as long, and images are compared with each other."""
    monkeypatch.setattr(pv.global_theme, "multi_samples", 1)
