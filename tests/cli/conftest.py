"""A folder for each test, with mesh files and rigs that are written once."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.cli.demo import SCENE

GOLD, RED = ph.Material.named("gold"), ph.Material(diffuse="red", shininess=3)


@pytest.fixture(scope="session")
def _written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    before = Path.cwd()
    os.chdir(folder)
    sphere = pv.Sphere(theta_resolution=12, phi_resolution=12)
    sphere.clear_data()
    sphere["tint"] = np.linspace(0, 1, 3 * sphere.n_points).reshape(-1, 3)
    sphere["height"] = sphere.points[:, 2].copy()
    box = pv.ImageData(dimensions=(4, 4, 4))
    box["deep"] = np.where(np.arange(64) == 21, 99.0, np.arange(64.0))  # the maximum is an inner point
    cube = pv.Cube(clean=True)
    cube.clear_data()
    cloud = pv.PolyData(np.eye(3))
    faulty = sphere.copy()
    faulty.point_data.active_normals = np.zeros((faulty.n_points, 3))
    faulty.points[4] = np.nan
    for name, mesh in {
        "sphere.vtp": sphere,
        "cube.vtp": cube,
        "tile.vtp": pv.Plane(i_resolution=4, j_resolution=4),
        "roof.vtp": pv.Plane(center=(0, 0, 2), i_size=9, j_size=9),
        "box.vti": box,
        "cloud.vtp": cloud,
        "beyond.vtp": pv.PolyData(np.eye(3), faces=[3, 0, 1, 9]),
        "faulty.vtp": faulty,
        "half.ply": pv.Sphere(),
        "blocks.vtm": pv.MultiBlock(
            {"ball": sphere, "gap": None, "deep": pv.MultiBlock({"a box": pv.Cube(center=(2, 0, 0))})}
        ),
        "faulty.vtm": pv.MultiBlock({"good": sphere, "cloud": cloud}),
        "empty.vtm": pv.MultiBlock({"none": None, "nested": pv.MultiBlock()}),
    }.items():
        mesh.save(name)
    for name in ("oak.png", "half.png"):
        pv.Texture(np.random.default_rng(0).integers(0, 255, (40, 40, 3)).astype(np.uint8)).to_image().save(name)
    os.truncate("half.ply", 20_000)
    os.truncate("half.png", 1000)
    sun = ph.Scene([ph.DirectionalLight(name="sun")], ph.Viewer(position=(0, -3, 1)))
    names = {"name": "the lamp over the long table in the hall"}
    away = ph.SpotLight(position=(0, 0, 5), direction=(0, 0, 1), cone_angle=20, name="away")
    SCENE.save("rig.json")
    sun.save("sun.json")
    replace(sun, light_model=ph.LightModel(shadows=True, ambient_occlusion=0.5)).save("dark.json")
    replace(sun, light_model=ph.LightModel(bounces=1)).save("bounces.json")
    ph.Scene([away, ph.PointLight(position=(0, 0, 30), **names)]).save("away.json")
    ph.Scene([ph.PointLight(position=(3, 4, 5))], light_model=ph.LightModel.opengl()).save("opengl.json")
    sun.save("red.json", materials={"default": RED, "deep/a box": GOLD})
    sun.save("parts.json", materials=dict.fromkeys(("lid", "box"), ph.Material()))
    Path("garbage.json").write_text("garbage")
    Path("other.json").write_text('{"format": "other"}')
    os.chdir(before)
    return folder


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(_written, tmp_path, monkeypatch):
    shutil.copytree(_written, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
