"""Colormaps as records: checks of fields, repr, equality, and dictionaries for files."""

from __future__ import annotations

import json
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest
import pyvista as pv
from matplotlib import colormaps

import pvphong as ph
from pvphong.optics.material import Material

ROWS = np.linspace(0.0, 1.0, 5)
OPTIONS = {
    "cmap": ("terrain", ["red", "#00ff00", (0.0, 0.0, 0.5)]),
    "clim": ((0, 8), 3.0, np.array([-1.0, 1.0])),
    "n_colors": (5, np.int64(7)),
    "log_scale": (True,),
    "nan_color": ("red", (0.1, 0.2, 0.3), 0.5),
    "below_color": ("blue",),
    "above_color": ("#112233",),
    "flip_scalars": (True,),
    "categories": (True, 4),
    "annotations": ({1: "low", 2.5: "high"},),
    "component": (0, 2),
    "preference": ("cell",),
}


def test_every_option_is_tried():
    assert [field.name for field in fields(ph.Colormap)] == ["scalars", *OPTIONS]


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in OPTIONS.items() for value in values])
def test_files_and_pickles_keep_a_colormap(name, value):
    colormap = ph.Colormap("Elevation", **{name: value})
    assert colormap != ph.Colormap("Elevation")
    assert f"{name}=" in repr(colormap) or name == "cmap"
    for field in ("albedo", "diffuse", "specular", "emission"):
        material = Material(**{field: colormap})
        kept = json.loads(json.dumps(material.to_dict()))
        assert Material.from_dict(kept) == material
        assert hash(Material.from_dict(kept)) == hash(material)
    assert pickle.loads(pickle.dumps(colormap)) == colormap
    assert replace(colormap, clim=None) == replace(replace(colormap, clim=(1, 2)), clim=None)


def test_arrays_and_tables_are_the_same_objects_or_not_equal():
    for given in (ROWS, pv.LookupTable("viridis"), colormaps["terrain"]):
        one = ph.Colormap(given) if given is ROWS else ph.Colormap("a", given)
        assert one == (ph.Colormap(given) if given is ROWS else ph.Colormap("a", given))
        assert "\n" not in repr(one)
        with pytest.raises(ValueError, match=r"^albedo\.(scalars|cmap) must be .*to be saved in a file"):
            Material(albedo=one).to_dict()
    assert ph.Colormap(ROWS) != ph.Colormap(ROWS.copy())
    assert "of shape (5,)" in repr(Material(albedo=ph.Colormap(ROWS)))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scalars": ""}, "^scalars must be the name"),
        ({"scalars": 3.0}, "^scalars must be the name"),
        ({"scalars": None}, "^scalars must be the name"),
        ({"scalars": np.array(["a", "b"])}, r"^scalars must be .*an array of strings.*np\.unique"),
        ({"scalars": np.array([{}, 1], object)}, "^scalars must be .*an array of objects"),
        ({"scalars": np.zeros((2, 2, 2))}, r"^scalars must be .*\(2, 2, 2\)"),
        ({"scalars": [[1], [2, 3]]}, "^scalars must be .*ragged"),
        ({"scalars": np.ma.masked_less(ROWS, 0.5)}, "^scalars must be .*masked"),
        ({"cmap": "terain"}, "^cmap must be .* Did you mean 'terrain'"),
        ({"cmap": "VIRIDIS"}, "^cmap must be .* Did you mean 'viridis'"),
        ({"cmap": "no such thing at all"}, "^cmap must be a colormap's name"),
        ({"cmap": []}, "^cmap must be a colormap's name"),
        ({"cmap": 3}, "^cmap must be a colormap's name"),
        ({"cmap": ["red", "rad"]}, r"^cmap\[1\] must be .*colour name"),
        ({"cmap": [(0, 0, 0), (255, 0, 0)]}, r"^cmap\[1\] must be .* Divide by 255"),
        ({"clim": (8, 0)}, "^clim must be two finite numbers, the smaller first.*flip_scalars"),
        ({"clim": (1, 1)}, "^clim must be two finite numbers, the smaller first"),
        ({"clim": (0, np.nan)}, "^clim must be two finite numbers"),
        ({"clim": -3}, "^clim must be a finite number > 0"),
        ({"clim": "0,8"}, "^clim must be two finite numbers"),
        ({"n_colors": 0}, "^n_colors must be a whole number >= 1"),
        ({"n_colors": 2.5}, "^n_colors must be a whole number >= 1"),
        ({"log_scale": 1}, "^log_scale must be True or False"),
        ({"nan_color": "rad"}, "^nan_color must be .*colour name"),
        ({"categories": 0}, "^categories must be a whole number >= 1"),
        ({"annotations": "low"}, "^annotations must be a mapping"),
        ({"component": -1}, "^component must be a whole number >= 0"),
        ({"preference": "points"}, "^preference must be one of 'point', 'cell'"),
        ({"cmap": pv.LookupTable("viridis"), "clim": (0, 1)}, "^clim must be omitted with a lookup table"),
    ],
)
def test_what_is_not_allowed_is_refused_in_one_line(options, message):
    with pytest.raises(ValueError, match=message) as refused:
        ph.Colormap(**{"scalars": "a"} | options)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("field", ["ambient", "shininess"])
def test_fields_that_are_no_map_of_colours_refuse_it(field):
    with pytest.raises(ValueError, match=rf"^{field} must be a.*got Colormap\('a'\)"):
        Material(**{field: ph.Colormap("a")})


def test_a_file_with_an_unknown_option_is_refused_where_it_is():
    for entry, message in (
        ({"cmap": "terrain"}, r"^material\.albedo\.scalars must be"),
        ({"scalars": "a", "color": 1}, r"^field of material\.albedo must be"),
        ({"scalars": "a", "cmap": "terain"}, r"^material\.albedo\.cmap must be"),
    ):
        with pytest.raises(ValueError, match=message):
            Material.from_dict({"albedo": entry})
