"""Command that finds lights from the colours that a mesh should have: `fit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import pyvista as pv
from cyclopts import Parameter

from pvphong.base import check
from pvphong.cli.options import DEFAULT_LIGHTING, LightingOptions, Number, busy
from pvphong.meshes.blocks import datasets
from pvphong.meshes.files import refuse_suffix


def fit(
    mesh: str,
    /,
    *,
    target: str,
    vary: Annotated[tuple[str, ...], Parameter(negative="", show_default=False)],
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    lighting: LightingOptions = DEFAULT_LIGHTING,
    weights: str | None = None,
    max_lights: int | None = None,
    tolerance: Number = 0.0,
    tries: int | None = None,
    seed: int = 0,
    plot: Path | None = None,
) -> int:
    """Find the lights with which a mesh gets the colours that it should have, and write them to a rig file.

    Without --scene, the lights are key, fill and rim. The rig is for --scene of all commands.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    target
        Name of the point array of colours or luminances that the mesh should have, from 0 to 1; NaN where any colour
        will do. Blocks without this array do not count. A number is the luminance of all points.
    vary
        Light and its fields that vary, as in key:intensity,direction; may be repeated. Fields without a light, as in
        intensity,diffuse, vary in all lights.
    output
        Rig file (.json) for the lights that are found.
    weights
        Name of a point array with the importance of each point.
    max_lights
        Choose at most this number of lights, and switch the others off.
    tolerance
        Root mean square of the differences that is good enough. If it is given and not reached, the exit status is 1.
    tries
        Number of starts of the search for directions and positions. Default: 12.
    seed
        Seed of the search.
    plot
        File for a picture (.png) of target, result and difference.
    """
    refuse_suffix(output, "the lights", (".json",))
    if plot is not None:
        refuse_suffix(plot, "a picture of the fit", (".png",))
    outside, scene, material = lighting.read(mesh)
    options: dict[str, Any] = {"max_lights": max_lights, "tolerance": tolerance, "seed": seed}
    if tries is not None:
        options["tries"] = tries
    if weights is not None:
        options["weights"] = _of_blocks("weights", weights, outside)
    options |= {"feature_angle": lighting.feature_angle, "occluders": lighting.occluders()}
    with busy(f"Fitting lights to {mesh}"):
        found = outside.phong.fit(scene, material, _target(target, outside), _fields(vary), **options)
        if plot is not None:
            found.plot(off_screen=True, screenshot=plot)
    found.scene.save(output, materials=lighting.materials())
    print(found)
    for path in (output, plot):
        if path is not None:
            print(path)
    return 1 if tolerance and not found.is_within else 0


def _fields(given: tuple[str, ...]) -> Any:
    """Convert the option --vary to the argument `vary` of `fit`.

    The result is a text with the fields that vary in all lights, or a mapping from lights to such texts.
    """
    pairs = [word.rpartition(":") for word in given]
    if len(pairs) == 1 and not pairs[0][1]:
        return given[0]
    for word, (_, colon, _) in zip(given, pairs, strict=True):
        if not colon:
            remedy = "Give fields without a light once and alone, to vary them in all lights."
            check.refuse("--vary", word, "a light and its fields, as in key:intensity,direction", remedy)
    found: dict[str, str] = {}
    for light, _, fields in pairs:
        found[light] = f"{found[light]},{fields}" if light in found else fields
    return found


def _target(text: str, mesh: Any) -> Any:
    """Convert the option --target to the argument `target` of `fit`.

    The result is a number, or the name of an array. For blocks, it is a mapping as by `_of_blocks`.
    """
    try:
        return float(text)
    except ValueError:
        return _of_blocks("target", text, mesh)


def _of_blocks(argument: str, name: str, mesh: Any) -> Any:
    """Return the name of an array as an argument of `fit`; for blocks, a mapping from paths of blocks to the name.

    The mapping has the blocks that have the array. `argument` is the name of the argument in messages.
    """
    if not isinstance(mesh, pv.MultiBlock):
        return name
    blocks = dict(datasets(mesh))
    found = {path: name for path, block in blocks.items() if name in block.point_data}
    if not found:
        names = sorted({array for block in blocks.values() for array in block.point_data})
        remedy = check.meant(name, names) or f"The arrays are {', '.join(names) or 'none'}."
        check.refuse(argument, name, "the name of a point array of a block", remedy)
    return found
