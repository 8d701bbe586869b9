"""What keys do to materials: of the mesh under the cursor, or of all where there is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from pvphong.base.types import rgb
from pvphong.optics.material import Material
from pvphong.studio.gizmos.surroundings import Surroundings

_HIGHLIGHT_STEP = 0.1


def _suits_any_mesh(material: Material) -> bool:
    return material.reflectance is None or not material.reflectance.needs


_NAMES = [name for name in Material.names() if _suits_any_mesh(Material.named(name))]
"""Without those for which a mesh needs tangents."""


def _change(board: Surroundings, change: Callable[[Material], Material], what: Callable[[Material], str]) -> None:
    pointed = board.surfaces.mesh(board.cursor)
    finishes = board.materials.finishes if pointed is None else (pointed.finish,)
    for finish in finishes:
        finish.material = change(finish.material)
    if finishes:
        which = "all meshes" if pointed is None and len(finishes) > 1 else "material"
        board.notice = f"{which}: {what(finishes[-1].material)}"
    else:
        board.notice = "no lit mesh"


def following(board: Surroundings) -> None:
    """The next of the named materials, the first after one that has no name."""
    _change(board, lambda material: _neighbour(material, 1), _name)


def preceding(board: Surroundings) -> None:
    """The named material before, the last before one that has no name."""
    _change(board, lambda material: _neighbour(material, -1), _name)


def _neighbour(material: Material, step: int) -> Material:
    name = _name(material)
    at = _NAMES.index(name) if name in _NAMES else min(-step, 0)
    chosen = Material.named(_NAMES[(at + step) % len(_NAMES)])
    is_its_own = name in _NAMES and Material.named(name).reflectance is not None
    return chosen if chosen.reflectance or is_its_own else replace(chosen, reflectance=material.reflectance)


def _name(material: Material) -> str:
    plain = replace(material, reflectance=None)
    return next((name for name in _NAMES if Material.named(name) in (material, plain)), "no name")


def shinier(board: Surroundings) -> None:
    """A narrower highlight: √2 times the exponent, at least 1."""
    _change(board, lambda material: replace(material, shininess=_stepped(material.shininess, 1)), _shine)


def duller(board: Surroundings) -> None:
    """A wider highlight."""
    _change(board, lambda material: replace(material, shininess=_stepped(material.shininess, -1)), _shine)


def _stepped(shininess: float, step: int) -> float:
    """On the scale of powers of √2, below 1 is 0."""
    at = 2.0 * math.log2(shininess) if shininess > 0.0 else -1.0
    nearest = round(at) if abs(at - round(at)) < 1e-9 else at
    return 2.0 ** ((nearest + step) / 2.0) if nearest + step >= 0.0 else 0.0


def stronger(board: Surroundings) -> None:
    """A tenth more of specular reflectance, at most 1 in any channel."""
    _change(board, lambda material: _mirroring(material, _HIGHLIGHT_STEP), _shine)


def weaker(board: Surroundings) -> None:
    """A tenth less of specular reflectance."""
    _change(board, lambda material: _mirroring(material, -_HIGHLIGHT_STEP), _shine)


def _mirroring(material: Material, step: float) -> Material:
    colors = rgb(material.specular)
    largest = max(colors)
    level = round(min(max(largest + step, 0.0), max(1.0, largest)), 10)
    return replace(material, specular=[level * c / largest for c in colors] if largest else level)


def _shine(material: Material) -> str:
    return f"specular {max(rgb(material.specular)):.3g}, shininess {material.shininess:.4g}"
