"""The reflectances.

A new one is a file in this folder and an entry in `REFLECTANCES`; then its name and place in `pvphong/__init__.py`, a
line in the README, a strategy in `tests/strategies.py`, which includes it in all tests of laws, and its formula in
`tests/reflectance_oracle.py`, which the tests compare it with.

(`vtk.py` has no entry: only VTK's convention selects it.)

`highlight.py` is shared by all highlights that are a power of a cosine, `microfacets.py` by GGX and PBR.
`likeness.py` maps reflectances to similar ones.
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
"""Mapping from name to class, for scene files and for `LightModel.reflection`, which is one of the first two."""


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
