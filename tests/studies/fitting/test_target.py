"""`ph.target`: levels for arrays, blocks, boxes and picked points."""

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph

PLANE = pv.Plane(i_resolution=4, j_resolution=4)  # from -0.5 to 0.5 in steps of 0.25
PLANE["painted"] = np.where(PLANE.points[:, 0] > 0.3, 2, 0)
PLANE["noted"] = np.where(PLANE.points[:, 0] > 0.3, np.nan, 0.0)


def test_levels_of_arrays_boxes_and_picked_points():
    box, pick = (-0.6, -0.4, -1, 1, -1, 1), ((0, 0, 0), 0.3)
    levels = ph.target(PLANE, {"painted": 0.8, box: 0.1, pick: 0.4})
    x, y, _ = PLANE.points.T
    np.testing.assert_array_equal(levels == 0.8, x == 0.5)
    np.testing.assert_array_equal(levels == 0.1, x == -0.5)
    np.testing.assert_array_equal(levels == 0.4, np.hypot(x, y) < 0.3)
    assert np.isnan(levels).sum() == PLANE.n_points - 5 - 5 - 5


def test_pairs_take_picked_points_and_masks_as_arrays():
    ball = pv.Sphere()
    top, picked = ball.points[:, 2] > 0.3, ball.points[1]
    found = ph.target(ball, [(top, 0.8), ((picked, 0.1), 0.2)])
    near = np.linalg.norm(ball.points - picked, axis=1) <= 0.1
    np.testing.assert_array_equal(found, np.where(near, 0.2, np.where(top, 0.8, np.nan)))


def test_later_levels_replace_earlier_ones_and_none_takes_them_back():
    everywhere, corner = (-1, 1, -1, 1, -1, 1), ((0.5, 0.5, 0), 0.1)
    levels = ph.target(PLANE, {everywhere: 0.5, "painted": "red", corner: None})
    assert levels.shape == (25, 3)
    at = {tuple(point): level for point, level in zip(PLANE.points[:, :2].tolist(), levels.tolist(), strict=True)}
    assert at[(0.0, 0.0)] == [0.5, 0.5, 0.5]
    assert at[(0.5, 0.0)] == [1.0, 0.0, 0.0]
    assert np.isnan(at[(0.5, 0.5)]).all()


def test_blocks_by_path_and_everything_in_a_nested_block():
    inner = pv.MultiBlock({"wheel": PLANE, "door": PLANE})
    blocks = pv.MultiBlock({"car": inner, "ground": PLANE, "gap": None})
    levels = ph.target(blocks, {"car": 0.2, "car/door": 0.6, "painted": 0.9})
    assert set(levels) == {"car/wheel", "car/door", "ground"}
    assert sorted(set(levels["car/wheel"].tolist())) == [0.2, 0.9]
    assert sorted(set(levels["car/door"].tolist())) == [0.6, 0.9]
    assert np.isnan(levels["ground"]).sum() == 20


@pytest.mark.parametrize(
    ("levels", "message"),
    [
        ({}, r"levels must be a mapping of selections to levels"),
        (
            {"paintd": 1.0},
            r"levels must be selections and levels; .*; got a selection 'paintd'. Did you mean 'painted'",
        ),
        ({(1, 2, 3): 1.0}, r"levels must be selections and levels; .* The names are"),
        ({"noted": 1.0}, r"levels\['noted'\] must be a level for at least one point.*It is 0 everywhere"),
        ({(1, 0, 0, 1, 0, 1): 1.0}, r"a selection without points. The order of a box is x_min, x_max"),
        ([(((9, 9, 9), 1), 1.0)], r"levels\[0\] must be a level .* The points are in the box -0.5"),
        ([np.arange(3)], r"levels must be a mapping of selections to levels.* or a list of such pairs"),
        ([(np.ones(3, bool), 1.0)], r"got a selection an array of shape \(3,\)"),
        ({((9, 9, 9), 1): 1.0}, r"must be a level for at least one point; got a selection without points"),
        ({((0, 0, 0), 0): 1.0}, r"levels must be a finite number > 0"),
        ({"Normals": 1.0}, r"must be the name of an array of numbers; got an array of shape \(25, 3\)"),
        ({"painted": -1}, r"levels\['painted'\] must be a number >= 0, .*|.*finite number >= 0; got -1"),
        ({"painted": float("nan")}, r"levels\['painted'\] must be a finite number"),
        ({"painted": "rad"}, r"levels\['painted'\] must be a number >= 0.*Did you mean 'red'"),
    ],
)
def test_bad_levels_are_refused(levels, message):
    with pytest.raises(ValueError, match=message):
        ph.target(PLANE, levels)


def test_only_a_mesh_has_a_target():
    with pytest.raises(ValueError, match=r"mesh must be a pyvista\.DataSet"):
        ph.target([1, 2], {"a": 1})
