import pytest
import pyvista as pv


@pytest.fixture(autouse=True)
def _one_sample_for_each_pixel(monkeypatch):
    """PyVista's eight take a processor four times as long; what is seen is compared with what was seen before."""
    monkeypatch.setattr(pv.global_theme, "multi_samples", 1)
