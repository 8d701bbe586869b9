"""Report that compares pvphong with VTK."""

import re
from importlib.metadata import version
from itertools import product

import numpy as np
import pytest
import pyvista as pv

from pvphong import DirectionalLight, PointLight, SpotLight
from pvphong.studies.validate.cases import CASES, MATERIALS, MESHES
from pvphong.studies.validate.report import vtk_report
from pvphong.vtk.oracle import driver


@pytest.fixture(scope="module")
def report():
    return vtk_report()


def test_every_scene_is_within_its_bound(report):
    assert report.passed, report.summary()
    for row in report.rows:
        assert row.comparison.n >= 0.95 * len(row.comparison.pvphong), row.case.title
        assert row.ratio < 0.5, row.case.title  # far from the bound
        if row.case.lights:
            assert np.nanstd(row.comparison.vtk) > 0.005, row.case.title  # there is something to see
    assert [images.max_difference <= 2 for images in report.pictures.values()] == [True, True]


def test_the_list_has_everything(report):
    lights = [(row, light) for row in report.rows for light in row.case.scene(pv.Sphere()).lights]
    kinds = {(type(light), row.comparison.tier) for row, light in lights}
    assert kinds >= {
        (DirectionalLight, 1), (DirectionalLight, 2), (DirectionalLight, 3), (PointLight, 3), (SpotLight, 3)
    }  # fmt: skip
    assert {row.comparison.tier for row in report.rows} == {0, 1, 2, 3}
    frames = {(type(light), light.frame) for _, light in lights}
    assert frames >= set(product((DirectionalLight, PointLight, SpotLight), ("world", "camera"))) | {
        (DirectionalLight, "headlight"), (PointLight, "headlight")
    }  # fmt: skip
    assert {case.matrix for case in CASES} == {"identity", "rigid", "scaled", "sheared", "mirrored"}
    assert {case.parallel for case in CASES} == {False, True}
    assert {case.material for case in CASES} == set(MATERIALS)
    assert {case.mesh for case in CASES} == set(MESHES)
    assert len({case.title for case in CASES}) >= 20


def test_the_report_says_what_was_compared_with_what(report, tmp_path):
    report.save(tmp_path / "told.md")
    text = (tmp_path / "told.md").read_text(encoding="utf-8")
    for fact in (f"pvphong {version('pvphong')}", f"PyVista {pv.__version__}", driver(), report.summary()):
        assert fact in text
    assert f"VTK {pv.vtk_version_info.major}.{pv.vtk_version_info.minor}." in text
    table = [line for line in text.splitlines() if line.startswith("|")]
    assert len(table) == len(CASES) + 2
    assert len({line.count("|") for line in table}) == 1
    for row, line in zip(report.rows, table[2:], strict=True):
        assert row.case.mesh in line
        assert f"{row.comparison.max_error:.2e}" in line
        assert line.endswith("| yes |")
    linked = re.findall(r"!\[.*\]\(<(.*)>\)", text)
    assert len(linked) == 2
    for name in linked:
        assert pv.read(tmp_path / name).dimensions == (1200, 300, 1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["told-pictures", "told.md"]


def test_it_fits_80_columns_and_breaks_no_word(report, monkeypatch):
    shown = report.explain()
    assert max(map(len, (*shown.splitlines(), *str(report).splitlines()))) <= 80
    assert len(str(report).splitlines()) <= 5
    assert str(report).startswith(f"All {len(CASES)} scenes passed")
    monkeypatch.setattr("pvphong.base.text.WIDTH", 1000)
    assert sorted(shown.replace("─", "").split()) == sorted(report.explain().replace("─", "").split())


def test_scenes_that_failed_are_named(report, monkeypatch):
    monkeypatch.setattr(type(report.rows[0].comparison), "passed", False)
    assert not report.passed
    assert report.rows[0].cells()[-1] == "NO"
    lines = str(report).splitlines()
    assert lines[0].startswith(f"{len(CASES)} of {len(CASES)} scenes failed")
    assert lines[-1].startswith(f"Failed: {CASES[0].title}; ")
    assert len(lines) <= 5
    assert max(map(len, lines)) <= 80


def test_a_report_is_written_again_and_leaves_nothing_where_it_cannot_be(report, tmp_path):
    report.save(tmp_path / "told.md")
    report.save(tmp_path / "told.md")
    with pytest.raises(ValueError, match=r"\.md"):
        report.save(tmp_path / "told.html")
    with pytest.raises(ValueError, match="path must be in a folder that exists"):
        report.save(tmp_path / "no" / "told.md")
    (tmp_path / "taken-pictures").touch()
    with pytest.raises(ValueError, match="path must be in a folder that can be written to"):
        report.save(tmp_path / "taken.md")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["taken-pictures", "told-pictures", "told.md"]
