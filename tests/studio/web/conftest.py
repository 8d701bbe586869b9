"""A studio in a real Chromium."""

import time

import pytest
import pyvista as pv
from pages import Page, Served


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="session")
def ball(tmp_path_factory):
    """The file of the mesh that the studio shows."""
    path = tmp_path_factory.mktemp("meshes") / "ball.ply"
    pv.Sphere(theta_resolution=24, phi_resolution=24).save(path)
    return path


@pytest.fixture(scope="module")
def served(ball):
    """A server for each file, because the camera is not undone."""
    served = Served(ball)
    yield served
    served.close()


@pytest.fixture(scope="module")
def opened(driver, served):
    return Page(driver, served.address)


@pytest.fixture
def page(opened):
    """The page with all edits undone."""
    while opened.state("can_undo"):
        opened.trigger("undo")
        time.sleep(0.1)
    opened.until(lambda: not opened.state("can_undo"))
    opened.unfold()  # a test may have loaded the page again
    return opened
