"""Errors for unknown options of a call. They suggest where the option belongs, or the nearest option."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any, TypeVar, cast

from pvphong.base import check
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene

Function = TypeVar("Function", bound=Callable[..., Any])

# Later entries replace earlier ones: material and light model both have `ambient`, and the material's is suggested.
_PLACES = {
    **{each.name: f"Scene(..., {each.name}=...)" for each in fields(Scene)},
    **{each.name: f"Scene(..., light_model=LightModel({each.name}=...))" for each in fields(LightModel)},
    "shadow": "Scene(..., light_model=LightModel(shadows=True))",
    **{each.name: f"Material({each.name}=...)" for each in fields(Material)},
    "color": "Material(albedo=...)",
    "scalars": "Material(albedo=Colormap(...))",
    "cmap": "Material(albedo=Colormap(...))",
    "clim": "Material(albedo=Colormap(...))",
    "roughness": "Material(reflectance=GGX(roughness=...))",
    "metallic": "Material(reflectance=PBR(metallic=...))",
}


def known_options(function: Function) -> Function:
    """Decorate a function, so that an unknown option raises a ``TypeError`` that suggests the right place or name."""
    refuse = refusal_of(function)

    @functools.wraps(function)
    def called(*given: Any, **options: Any) -> Any:
        refuse(options)
        return function(*given, **options)

    return cast("Function", called)


def refusal_of(function: Callable[..., Any]) -> Callable[[Iterable[str]], None]:
    """Return a function that raises ``TypeError`` for names of options that `function` does not accept.

    The message names the first such option, and says where it belongs or suggests the nearest option.
    """
    parameters = inspect.signature(function).parameters
    known = frozenset(parameters)
    passes_on = any(each.kind is each.VAR_KEYWORD for each in parameters.values())

    def refuse(options: Iterable[str]) -> None:
        if not passes_on and not known.issuperset(options):
            raise _unknown(function.__name__.removesuffix("_mesh"), next(iter(set(options) - known)), known)

    return refuse


def _unknown(call: str, name: str, known: Iterable[str]) -> TypeError:
    if name in _PLACES:
        return TypeError(f"{call} takes no {name!r}. Use {_PLACES[name]}.")
    options = sorted(set(known) - {"self", "mesh"})
    remedy = check.meant(name, options)
    if not remedy and (near := difflib.get_close_matches(name, _PLACES, 1)):
        remedy = f"Did you mean {near[0]!r}? Use {_PLACES[near[0]]}."
    return TypeError(f"{call} takes no {name!r}. {remedy or 'It takes ' + ', '.join(options) + '.'}")
