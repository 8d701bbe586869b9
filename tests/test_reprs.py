"""Representations of public objects in consoles and notebooks: no addresses, and HTML tables."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista as pv
from strategies import REFLECTANCE_SHAPES, Dice

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading.vertices import Vertices
from pvphong.studies.validate.images import compare_images
from pvphong.studio.histogram import histogram_of

LAMP = ph.PointLight(position=(0, 0, 2), name="<i>lamp & co</i>")
SCENE = ph.Scene([LAMP], ph.Viewer(position=(0, 0, 3)))
MESH = pv.Sphere(theta_resolution=8, phi_resolution=8)
FAULTY = {"matrix": np.diag([1, 1, -1, 1])}


@pytest.fixture(scope="module")
def report():
    return MESH.phong.tradeoff(SCENE, seconds=1)


def evaluated(**options):
    return ph.evaluate(MESH.points, MESH.point_normals, SCENE, ph.Material(), **options)


BY_THEMSELVES = {
    "accessor": lambda: MESH.phong,
    "blocks": lambda: pv.MultiBlock({"a": MESH}).phong,
    "filter": ph.PhongFilter,
    "plan": lambda: MESH.phong.plan(SCENE),
    "shading": evaluated,
    "components": lambda: evaluated(components=True),
    "vertices": lambda: Vertices(MESH.points, None),
    "diagnosis": lambda: MESH.phong.diagnose(**FAULTY),
    "comparison": lambda: MESH.phong.validate(SCENE),
    "visibility": lambda: MESH.phong.visibility(SCENE),
    "transport": lambda: MESH.phong.transport(),
    "daylight": lambda: MESH.phong.daylight("2026-06-21T10:00Z", ph.Place(48.14, 11.58)),
    "truth": lambda: MESH.phong.truth(SCENE, max_bounces=0),
    "batch": lambda: ph.Batch((Path("a"),), (), {Path("b"): "<no mesh>"}),
    "fit": lambda: MESH.phong.fit(SCENE, ph.Material(), 0.5, "intensity"),
    "histogram": lambda: histogram_of(np.full((5, 3), 255, np.uint8)),
    "probe": lambda: ph.Probe("ball", 3, (0.0, 0.0, 1.0), *[(0.1, 0.2, 0.3)] * 2, {}, (0.0, 0.0, 0.0)),
    "images": lambda: compare_images(MESH, SCENE, ph.Material()),
}
"""Objects that hold arrays, or refer to others: their representations are short."""

VALUES = {
    type(value).__name__: value
    for value in (
        *(kind() for kind in LIGHT_TYPES.values()), SCENE, SCENE.viewer, SCENE.light_model,
        *(kind(**REFLECTANCE_SHAPES[name](Dice(1))) for name, kind in REFLECTANCES.items()),
        ph.Material(), ph.Colormap("Elevation", "terrain"), ph.Display(1.0),
        ph.Place(48.14, 11.58),
    )
}  # fmt: skip
"""These show their fields."""


def test_every_public_class_is_looked_at():
    classes = {name for name in ph.__all__ if isinstance(getattr(ph, name), type)}
    made = {type(make()).__name__ for make in BY_THEMSELVES.values()} | {"Tradeoff"}  # a fixture
    others = {"Light", "NormalsWarning", "SingularMatrixWarning"}  # abstract, and exceptions
    others |= {"PlotterPhong", "Report"}  # tested below; a table of several lines
    assert classes - made - VALUES.keys() == others


def line(value):
    """Return an object's repr; assert that it is one line without an address."""
    shown = repr(value)
    assert not re.search(r"0x[0-9a-f]{6}|\n", shown), shown
    return shown


@pytest.mark.parametrize("name", BY_THEMSELVES)
def test_a_representation_is_a_short_line(name):
    shown = line(BY_THEMSELVES[name]())
    assert shown.startswith("<")
    assert len(shown) <= 120


@pytest.mark.parametrize("name", VALUES)
def test_values_show_their_fields(name):
    assert line(VALUES[name]).startswith(f"{name}(")


def test_parts_of_reports_and_of_plotters_are_lines(report):
    finding, worst = MESH.phong.diagnose(**FAULTY).findings[0], MESH.phong.validate(SCENE).worst[0]
    plotter = pv.Plotter(off_screen=True, lighting="none")
    phong = plotter.phong
    light, actor = phong.add_light(LAMP), phong.add_mesh(MESH)
    shown = (light, phong.mesh(actor), *phong.add_gizmos())
    for value in (report, *report.rows, *report.ledger, *report.predicted_bounds, finding, worst, *shown):
        line(value)
    assert "1 lit meshes in 1 subplots" in line(phong)
    plotter.close()


@pytest.mark.parametrize("name", ["scene", "plan", "diagnosis", "comparison", "visibility", "tradeoff", "batch", "fit"])
def test_a_notebook_shows_a_small_table_whose_text_is_escaped(name, report):
    made = {"scene": lambda: SCENE, "tradeoff": lambda: report} | BY_THEMSELVES
    html = made[name]()._repr_html_()
    tags = {element.tag for element in ElementTree.fromstring(html).iter()}
    assert {"table", "caption", "tr", "td"} <= tags <= {"table", "caption", "tr", "th", "td"}
    assert len(html) < 20_000
    if name in ("scene", "plan", "visibility", "fit"):
        assert "&lt;i&gt;lamp &amp; co&lt;/i&gt;" in html
