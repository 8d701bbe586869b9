"""Settings that only the studio has: accuracy of the colours, shading of edges, and the background."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from pvphong.base import check
from pvphong.base.types import Color


def _number_or_none(name: str, value: Any, **limits: Any) -> float | None:
    return None if value is None else check.number(name, value, **limits)


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of the colours.

    Parameters
    ----------
    tolerance : float, default 0
        Largest colour error allowed to save time, where 1 is full intensity; 1/255 = 0.0039 is one step of a display.
        It applies to the plan and to downloads; the view is exact at vertices.
    refine : float, optional
        Largest colour error inside triangles in the view, where 1 is full intensity. While nothing moves, the meshes
        are refined, so that edges of shadows and cones are crisp. If None, the view shows the mesh's own vertices.
    """

    tolerance: float = check.field(partial(check.number, at_least=0.0, at_most=0.1), 0.0, unit="of 1")
    refine: float | None = check.field(partial(_number_or_none, above=0.0), None, unit="of 1")

    def __post_init__(self) -> None:
        check.fields(self)


@dataclass(frozen=True)
class Surfaces:
    """Shading of the meshes' edges.

    Parameters
    ----------
    feature_angle : float, optional
        An edge is sharp if the normals of its faces differ by more than this angle, in degrees. 0 is flat shading; if
        None, all edges are smooth.
    """

    feature_angle: float | None = check.field(partial(_number_or_none, at_least=0.0, at_most=180.0), None)

    def __post_init__(self) -> None:
        check.fields(self)


@dataclass(frozen=True)
class Background:
    """Background of the view and of pictures.

    Parameters
    ----------
    background : color
        The colour. Channels above 1 are shown as 1.
    transparent : bool, default False
        Leave the background of a downloaded picture out: the .png is transparent where no mesh and no stage is.
    """

    background: Color = check.field(check.color, (0.0, 0.0, 0.0))
    transparent: bool = check.field(check.flag, False)

    def __post_init__(self) -> None:
        check.fields(self)
