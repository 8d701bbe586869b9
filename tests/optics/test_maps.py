"""Maps in materials: distinction from numbers and colours, equality, hashing and files."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.optics.maps import Map
from pvphong.optics.material import as_material

ROWS = np.ones((5, 3))


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("albedo", "red", (1.0, 0.0, 0.0)),
        ("diffuse", "#00ff00", (0.0, 1.0, 0.0)),
        ("specular", [0.1, 0.2, 0.3], (0.1, 0.2, 0.3)),
        ("emission", np.array([0.1, 0.2, 0.3]), (0.1, 0.2, 0.3)),
        ("albedo", 0.5, 0.5),
        ("shininess", np.float32(3), 3.0),
        ("albedo", "scan", "scan"),
        ("shininess", "red", "red"),
        ("albedo", "scan.png", "scan.png"),
        ("diffuse", ROWS, ROWS),
        ("specular", np.ones(5), np.ones(5)),
        ("shininess", np.ones(3), np.ones(3)),
        ("albedo", [[1, 0, 0], [0, 1, 0]], [[1, 0, 0], [0, 1, 0]]),
        ("shininess", [1.0, 2.0], [1.0, 2.0]),
    ],
)
def test_a_field_is_a_number_or_colour_or_a_map(field, value, expected):
    found = getattr(ph.Material(**{field: value}), field)
    is_map = isinstance(found, Map)
    assert is_map == isinstance(expected, np.ndarray | list)
    assert np.array_equal(found, expected)
    assert (field in ph.Material(**{field: value}).maps) == (is_map or isinstance(found, str))


def test_materials_with_maps_are_values():
    texture = pv.Texture(np.zeros((2, 2, 3), np.uint8))
    for given in (ROWS, texture, "scan"):
        material, same = ph.Material(albedo=given), ph.Material(albedo=given)
        assert material == same
        assert hash(material) == hash(same)
        assert material == material.with_values({"albedo": material.albedo})
    assert ph.Material(albedo=ROWS) != ph.Material(albedo=ROWS.copy())
    assert "of shape (5, 3)" in repr(ph.Material(albedo=ROWS))
    assert np.array_equal(pickle.loads(pickle.dumps(ph.Material(albedo=ROWS))).albedo, ROWS)


def test_a_reflectance_has_maps_too_and_its_number_comes_first():
    assert ph.Material(reflectance=ph.GGX(roughness="worn")).maps == {"roughness": "worn"}
    assert set(ph.Material(reflectance=ph.PBR(metallic="m", roughness="r")).maps) == {"metallic", "roughness"}
    assert ph.Material(shininess="gloss", reflectance=ph.Phong()).maps == {"shininess": "gloss"}
    assert ph.Material(shininess="gloss", reflectance=ph.Phong(20)).maps == {}
    changed = ph.Material(reflectance=ph.GGX(0.5)).with_values({"roughness": "worn", "diffuse": 0.1})
    assert changed == ph.Material(diffuse=0.1, reflectance=ph.GGX("worn"))


def test_names_and_paths_go_into_files_and_nothing_else_does():
    material = ph.Material(albedo="scan.png", shininess="gloss", tangents="grain", reflectance=ph.PBR("m", "r"))
    assert ph.Material.from_dict(material.to_dict()) == material
    assert "albedo" not in ph.Material().to_dict(), "files of materials without it stay as they were"
    for kept in ({"albedo": ROWS}, {"reflectance": ph.GGX(np.ones(5))}, {"tangents": ROWS}):
        with pytest.raises(ValueError, match=r"to be saved in a file; got <ndarray of shape .* point array"):
            ph.Material(**kept).to_dict()


def test_a_rig_names_images_as_they_are_seen_from_its_folder(tmp_path, monkeypatch):
    material = ph.Material(albedo="maps/scan.png", shininess="gloss", tangents="grain")
    for folder in ("maps", "rigs"):
        (tmp_path / folder).mkdir()
    monkeypatch.chdir(tmp_path)
    ph.Scene(viewer=ph.Viewer()).save("rigs/rig.json", materials={"default": material})
    assert '"../maps/scan.png"' in Path("rigs/rig.json").read_text()
    monkeypatch.chdir(tmp_path / "maps")
    found = ph.load_materials("../rigs/rig.json")["default"]
    assert Path(found.albedo).resolve() == tmp_path / "maps" / "scan.png"
    assert found.with_values({"albedo": material.albedo}) == material


@pytest.mark.parametrize(
    ("given", "remedy"),
    [
        ("gld", "Did you mean 'gold'"),
        ("unobtainium", r"Material\.names\(\)"),
        ("red", r"For a colour, use Material\(diffuse='red'\)"),
        ((1, 0, 0), r"For a colour, use Material\(diffuse=\(1, 0, 0\)\)"),
        (pv.Color("red"), "For a colour, use"),
        (pv.Texture(np.zeros((2, 2, 3), np.uint8)), r"Material\(albedo=texture\)"),
        (pv.Property(), "Material.from_property"),
        (None, "Material.from_property"),
    ],
)
def test_what_is_no_material_is_refused(given, remedy):
    with pytest.raises(ValueError, match=f"^material must be a Material or the name of a material; .*{remedy}"):
        as_material(given)


@pytest.mark.parametrize(("given", "remedy"), [(0.2, ""), (pv.Property(), ""), ("gold", r"Material\.named\('gold'\)")])
def test_a_material_is_given_by_its_fields(given, remedy):
    with pytest.raises(ValueError, match=rf"^Material must be made with keywords.*{remedy}"):
        ph.Material(given)
