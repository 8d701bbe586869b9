"""Background work of the page: refining shows pictures on the way and pauses, and downloads do not wait for it."""

import time

import numpy as np
import pytest
import pyvista as pv
from browsers import needs_a_browser
from pages import bring, switch

pytestmark = needs_a_browser


@pytest.fixture
def slow(page, folder):
    """A mesh of many points in the soft shadows of a rectangle, refined."""
    if not (folder / "ring.vtp").exists():
        pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.45, u_res=154, v_res=153).save(folder / "ring.vtp")
    bring(page, "mesh", folder / "ring.vtp")
    page.until(lambda: page.state("title").startswith("ring"))
    page.trigger("add", "rectangle")
    page.until(lambda: page.light("rectangle"))
    page.trigger("edit", "model.shadows", True)
    page.until(lambda: next(each for each in page.state("model") if each["name"] == "shadows")["value"])
    switch(page, "refine")
    page.until(lambda: page.state("accuracy")["refine"]["set"])
    page.trigger("edit", "accuracy.refine", 0.0005)
    page.until(lambda: page.state("accuracy")["refine"]["value"] == 0.0005)
    page.until(lambda: page.state("refining") is not None)
    yield page
    if page.state("refining") is not None:
        page.click("cancel-refining")


def test_a_slow_refinement_gets_better_pauses_and_goes_on(slow, folder):
    page, parts = slow, []
    page.until(lambda: parts.append(page.state("refining")) or page.state("refining_paused"))
    assert "points added" in page.all("refined")[0].text
    parts = parts[parts.index(min(parts)) :]  # before it, the refinement to the tolerance set first
    assert parts == sorted(parts)
    assert len(set(parts)) > 5
    assert page.all("refining-percent")[0].text == f"{parts[-1]} %"
    time.sleep(1.0)
    assert page.state("refining") == parts[-1]
    page.driver.save_screenshot(str(folder / "paused.png"))
    page.click("go-on-refining")
    page.until(lambda: not page.state("refining_paused"))
    page.until(lambda: (page.state("refining") or 0) > parts[-1])
    page.click("cancel-refining")
    page.until(lambda: page.state("refining") is None)
    assert page.all("refined")[0].text.endswith("; cancelled")
    assert "points added" in page.all("refined")[0].text


def test_a_download_takes_the_mesh_as_shown_while_the_view_is_refined(slow, folder):
    page, home = slow, folder / "as shown"
    home.mkdir()
    page.until(lambda: "points added" in page.all("refined")[0].text)
    for suffix in ("glb", "vtp"):
        page.download(suffix, home / f"ring-lit.{suffix}")
        page.until(lambda suffix=suffix: f"ring-lit.{suffix} is as the view shows it" in page.all("notice")[0].text)
        assert page.state("refining") is not None
    colors = pv.read(home / "ring-lit.vtp")["phong"]
    assert len(colors) > 23_568
    np.testing.assert_allclose(255.0 * colors, np.rint(255.0 * colors), atol=1e-4)
