"""Visibility in files and in other processes: results are unchanged, and missing ones can be computed."""

import copy
import pickle
import re

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.optics.light import Light

LIGHTS = [
    ph.PointLight(position=(1, 1, 3), name="lamp"),
    ph.RectangleLight(position=(0, 0, 3), direction=(0, 0, -1), intensity=9.0, name="panel"),
    ph.EnvironmentLight(np.random.default_rng(0).random((4, 8, 3)), name="sky"),
]
RING = pv.ParametricTorus(0.5, 0.2, u_res=14, v_res=9).clean().triangulate()
FLOOR = pv.Plane(center=(0, 0, -0.5), i_size=3, j_size=3, i_resolution=5, j_resolution=5)
CLOUD = pv.PolyData(np.random.default_rng(1).normal(size=(20, 3)))
CLOUD.point_data.active_normals = np.tile([0.0, 0.6, 0.8], (20, 1))


def scene(**model):
    options = {"shadows": True, "ambient_occlusion": 2.0, "ambient": 0.3} | model
    return ph.Scene(LIGHTS, ph.Viewer(position=(3, 0, 1)), ph.LightModel(**options))


def by_file(seen, folder):
    seen.save(folder / "seen.npz")
    return ph.Visibility.load(folder / "seen.npz")


WAYS = {
    "pickle": lambda seen, _: pickle.loads(pickle.dumps(seen)),
    "copy": lambda seen, _: copy.deepcopy(seen),
    "file": by_file,
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize(("mesh", "other"), [(RING, FLOOR), (FLOOR, RING), (CLOUD, RING)])
def test_it_is_as_it_was_and_casts_what_is_not_known_yet(tmp_path, way, two_sided, mesh, other):
    rig = scene(two_sided=two_sided)
    seen = mesh.phong.visibility(rig, occluders=[other])
    half = seen.channels([1], sky=False).copy(), seen.rays
    again = WAYS[way](seen, tmp_path)
    assert (again.rays, again.seconds, again.lights) == (half[1], seen.seconds, seen.lights)
    np.testing.assert_array_equal(again.channels([1], sky=False), half[0])
    assert again.rays == half[1]
    everything = {"lights": range(len(LIGHTS)), "sky": True, "behind": two_sided}
    np.testing.assert_array_equal(again.channels(**everything), seen.channels(**everything))
    np.testing.assert_array_equal(again.standard_error.sky, seen.standard_error.sky)
    assert again.rays == seen.rays > half[1]
    lit = mesh.phong.shade(rig, visibility=again)["phong"]
    np.testing.assert_array_equal(lit, mesh.phong.shade(rig, visibility=seen)["phong"])
    with pytest.raises(ValueError, match="visibility must be computed for the mesh's current points"):
        mesh.translate((0, 0, 1)).phong.shade(rig, visibility=again)
    assert (again.behind is None) is not two_sided
    if two_sided:
        np.testing.assert_array_equal(WAYS[way](seen.behind, tmp_path).per_light, seen.behind.per_light)


def test_blocks_and_transports_go_to_other_processes():
    blocks, rig = pv.MultiBlock({"ring": RING, "floor": FLOOR}), scene()
    seen = pickle.loads(pickle.dumps(blocks.phong.visibility(rig)))
    lit = blocks.phong.shade(rig, visibility=seen)
    for one, same in zip(lit, blocks.phong.shade(rig), strict=True):
        np.testing.assert_array_equal(one["phong"], same["phong"])
    among = blocks.phong.transport(samples=32)
    colors = np.random.default_rng(2).random((len(among), 3))
    before = pickle.loads(pickle.dumps(among))
    gathered = among.gather(colors)
    assert gathered.max() > 0.0
    for other in (before, pickle.loads(pickle.dumps(among))):
        np.testing.assert_array_equal(other.gather(colors), gathered)
    assert before.rays == among.rays


def test_what_is_no_such_file_is_refused(tmp_path):
    path, seen = tmp_path / "seen.npz", FLOOR.phong.visibility(scene())
    seen.save(path)
    whole = path.read_bytes()
    with np.load(path) as file:
        good = dict(file)
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"^path must be a file written by Visibility\.save"):
        ph.Visibility.load(path)
    for name, wrong in (
        ("format", np.array(["pvphong transport", "3", ""])),
        ("format", np.array(["pvphong visibility", "7", good["format"][2]])),
        ("format", np.array([*good["format"][:2], "{}"])),
        ("seen", good["seen"][:, :-1]),
        ("errors", good["errors"][:-1]),
        ("corners_0", good["corners_0"] + len(good["points_0"])),
        ("normals", good["normals"].astype(np.int64)),
    ):
        np.savez(path, **{**good, name: wrong})
        with pytest.raises(ValueError, match=r"^path must be a file written by Visibility\.save; got .*seen"):
            ph.Visibility.load(path)
    for missing in ("none.npz", "."):
        with pytest.raises(ValueError, match=re.escape(str(tmp_path))):
            ph.Visibility.load(tmp_path / missing)
    with pytest.raises(ValueError, match=r"^path must be in a folder that exists"):
        seen.save(tmp_path / "nowhere" / "seen.npz")


def test_a_light_that_files_do_not_know_is_refused_by_name(tmp_path):
    class Bulb(Light):
        """Custom kind of light."""

        is_uniform = True

        def arrival(self, points, real=np.float64):
            return ph.DirectionalLight(direction=(0, 0, -1)).arrival(points, real)

    seen = FLOOR.phong.visibility([Bulb()])
    with pytest.raises(ValueError, match=r"^lights\[0\] must be of a built-in type"):
        seen.save(tmp_path / "seen.npz")
    assert not list(tmp_path.iterdir())
