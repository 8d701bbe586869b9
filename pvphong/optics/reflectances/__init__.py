"""The reflectances, one file each.

`highlight.py` is shared by all highlights that are a power of a cosine, `microfacets.py` by GGX and PBR.
`likeness.py` maps reflectances to similar ones. `vtk.py` has no entry in `REFLECTANCES`, because only VTK's convention
selects it.

A new reflectance needs:

- a file in this folder, and an entry in `REFLECTANCES`;
- its name and module in `pvphong/__init__.py`, and a line in the README;
- a strategy in `tests/strategies.py`, which includes it in all property-based tests;
- its formula in `tests/reflectance_oracle.py`, with which the tests compare it.
"""

from __future__ import annotations

from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances.blinn_phong import BlinnPhong
from pvphong.optics.reflectances.ggx import GGX
from pvphong.optics.reflectances.metal import Metal
from pvphong.optics.reflectances.modified_phong import ModifiedPhong
from pvphong.optics.reflectances.oren_nayar import OrenNayar
from pvphong.optics.reflectances.pbr import PBR
from pvphong.optics.reflectances.phong import Phong
from pvphong.optics.reflectances.retro import Retro
from pvphong.optics.reflectances.ward import Ward

REFLECTANCES: dict[str, type[Reflectance]] = {
    "phong": Phong,
    "blinn-phong": BlinnPhong,
    "modified-phong": ModifiedPhong,
    "metal": Metal,
    "oren-nayar": OrenNayar,
    "retro": Retro,
    "ward": Ward,
    "ggx": GGX,
    "pbr": PBR,
}
"""Mapping from name to class. Scene files use all names, and `LightModel.reflection` one of the first two."""


__all__ = [
    "GGX",
    "PBR",
    "REFLECTANCES",
    "BlinnPhong",
    "Metal",
    "ModifiedPhong",
    "OrenNayar",
    "Phong",
    "Reflectance",
    "Retro",
    "Ward",
]
