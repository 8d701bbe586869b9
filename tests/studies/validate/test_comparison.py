"""Statistics and texts of a comparison with given errors, without VTK."""

import json
import math

import numpy as np
import pytest
import pyvista as pv
from rich.table import Table

from pvphong.studies.validate.validation import Comparison

PLANE = pv.Plane(i_resolution=1, j_resolution=9)  # 20 points


def comparison(errors, **left_out):
    """Return a comparison on a plane whose last points are left out; VTK's colours are 0.5."""
    count, n = PLANE.n_points, len(errors)
    own = np.full((count, 3), 0.5)
    own[:n] += errors
    return Comparison(
        tolerance=1e-3,
        tier=2,
        conversions=("emission as a part of VTK's ambient",),
        driver="a driver",
        vertices=np.arange(n),
        errors=np.asarray(errors, dtype=np.float64),
        left_out={reason: np.array(points) for reason, points in left_out.items()},
        pvphong=own.astype(np.float32),
        vtk=np.full((count, 3), 0.5, dtype=np.float32),
        _surface=PLANE,
        _positions=np.asarray(PLANE.points, dtype=np.float64),
        _normals=np.tile([0.0, 0.0, 1.0], (count, 1)),
    )


def ramp():
    """Errors alternate in sign; the largest, 9e-4, is in the green channel of point 9."""
    errors = np.zeros((10, 3))
    errors[:, 1] = 1e-4 * np.arange(10) * (-1.0) ** np.arange(10)
    return errors


def test_numbers_are_those_of_the_errors():
    found = comparison(ramp(), **{"edge of a cone": [11, 12], "float32": [*range(10, 20)]})
    assert (found.n, found.n_left_out, found.passed) == (10, 10, True)
    assert found.max_error == pytest.approx(9e-4)
    assert found.rms == pytest.approx(1e-4 * math.sqrt(285.0 / 30.0))  # 285 = 0² + 1² + … + 9²
    assert found.p50 == pytest.approx(4.5e-4)
    assert found.p99 == pytest.approx(1e-4 * 9 * 0.99)
    assert [vertex.index for vertex in found.worst] == [9, 8, 7, 6, 5, 4, 3, 2]
    worst = found.worst[0]
    assert (worst.error, worst.tier) == (pytest.approx(9e-4), 2)
    assert (worst.position, worst.normal) == (tuple(PLANE.points[9].tolist()), (0.0, 0.0, 1.0))
    assert (worst.pvphong, worst.vtk) == (pytest.approx((0.5, 0.4991, 0.5)), (0.5, 0.5, 0.5))


def test_it_passes_up_to_the_tolerance_and_not_beyond():
    for error, passed in ((-1e-3, True), (-1.0001e-3, False), (np.nan, False)):
        errors = ramp()
        errors[4, 2] = error
        assert comparison(errors).passed is passed


def test_nothing_compared_has_not_passed():
    found = comparison(np.zeros((0, 3)), float32=[*range(20)])
    assert not found.passed
    assert found.worst == ()
    assert all(math.isnan(number) for number in (found.max_error, found.rms, found.p50, found.p99))
    assert "Nothing to compare" in str(found)
    assert "nothing to compare" in found.explain()
    assert found.to_dict()["max_error"] is None


def test_it_says_verdict_numbers_and_reasons():
    found, failed = comparison(ramp(), **{"edge of a cone": [11, 12]}), comparison(10.0 * ramp())
    told, short = " ".join(found.explain().split()), str(found)
    for part in ("passed", "10 of 20", "0.0009, 0.90 of the bound", "2 (directional lights)", "2: edge of a cone"):
        assert part in told
    assert "emission as a part of VTK's ambient" in told
    assert (told.count("worst:"), failed.explain().count("worst:")) == (1, 8)
    for part in ("Passed: all 10 vertices", "0.0009, 0.90 of that bound", "10 vertices are left out: edge of a cone"):
        assert part in short
    assert str(failed).startswith("Failed: 2 of 10 vertices are within 0.001")
    assert "Worst is vertex 9 at (" in str(failed)
    assert repr(failed) == "<Comparison failed: largest error 0.009 of 0.001, 10 vertices>"
    assert isinstance(failed.table(), Table)


def test_json_holds_the_numbers(tmp_path):
    found = comparison(ramp(), float32=[15])
    found.to_json(tmp_path / "comparison.json")
    document = json.loads((tmp_path / "comparison.json").read_text())
    assert document == json.loads(json.dumps(found.to_dict()))
    assert document["passed"] is True
    assert (document["n"], document["tier"], document["driver"]) == (10, 2, "a driver")
    assert document["left_out"] == {"float32": 1}
    assert document["worst"][0]["index"] == 9
    with pytest.raises(ValueError, match=r"path must be in a folder that exists"):
        found.to_json(tmp_path / "nowhere" / "comparison.json")


def test_mesh_carries_signed_errors():
    before = PLANE.array_names
    mesh = comparison(ramp()).to_mesh()
    np.testing.assert_array_equal(mesh["phong_error"][:10], ramp())
    assert np.isnan(mesh["phong_error"][10:]).all()
    assert mesh.active_scalars_name == "phong_error_max"
    assert mesh["phong_error_max"][9] == pytest.approx(9e-4)
    np.testing.assert_allclose(mesh["phong"] - mesh["vtk"], np.vstack([ramp(), np.zeros((10, 3))]), atol=1e-7)
    assert PLANE.array_names == before
