"""The reflectances.

A new one is its own file beside these and one entry in `REFLECTANCES`; then its name and place in
`pvphong/__init__.py`, a line in the README, a strategy in `tests/strategies.py`, with which all tests of laws take it,
and its formula in `tests/reflectance_oracle.py`, which it is compared with.

(`vtk.py` has none: VTK's convention chooses it, and nobody else can.)

`highlight.py` has what all highlights by a power of a cosine share, `microfacets.py` what GGX and PBR share;
`likeness.py` says which others look like one.
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
"""Name → class, for `LightModel.reflection`, one of the first two, and files of scenes."""


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
