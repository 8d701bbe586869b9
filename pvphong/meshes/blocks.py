"""Meshes of several blocks: operations on each block, and names of blocks."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import pyvista as pv

from pvphong.base import check

Surface = TypeVar("Surface")
"""A material, or a value used in place of one."""

Result = TypeVar("Result")

DEFAULT = "default"
"""Key of the material for blocks whose path is not a key."""


def map_blocks(blocks: pv.MultiBlock, operation: Callable[[Any], Any], place: str = "") -> pv.MultiBlock:
    """Apply a function to each dataset; return the results as a MultiBlock of the same structure and names.

    Parameters
    ----------
    blocks : pyvista.MultiBlock
        The blocks. Blocks that are None stay None; tables and empty datasets are copied unchanged.
    operation : callable
        The function of a dataset. If it raises a ValueError, the block's name is added to the message.
    place : str
        Position of `blocks` in an outer MultiBlock, such as "['car']"; in the message, it precedes the block's name.
    """
    result = pv.MultiBlock()
    for key, array in blocks.field_data.items():
        result.field_data[key] = array
    result.n_blocks = blocks.n_blocks
    for index, block in enumerate(blocks):
        key = blocks.get_block_name(index)
        if isinstance(block, pv.MultiBlock):
            result[index] = map_blocks(block, operation, f"{place}[{key!r}]")
        elif not isinstance(block, pv.DataSet) or block.n_points == 0:
            result[index] = None if block is None else block.copy()
        else:
            with _named(blocks, index, place):
                result[index] = operation(block)
        result.set_block_name(index, key)
    return result


def of_each(blocks: pv.MultiBlock, operation: Callable[[pv.DataSet], Result], place: str = "") -> list[Result]:
    """Apply a function to each nonempty dataset; return the results in the order of `datasets`.

    Parameters
    ----------
    blocks : pyvista.MultiBlock
        The blocks.
    operation : callable
        The function of a dataset. If it raises a ValueError, the block's name is added to the message.
    place : str
        Position of `blocks` in an outer MultiBlock, such as "['car']"; in the message, it precedes the block's name.
    """
    found: list[Result] = []
    for index, block in enumerate(blocks):
        if isinstance(block, pv.MultiBlock):
            found += of_each(block, operation, f"{place}[{blocks.get_block_name(index)!r}]")
        elif isinstance(block, pv.DataSet) and block.n_points:
            with _named(blocks, index, place):
                found.append(operation(block))
    return found


@contextlib.contextmanager
def _named(blocks: pv.MultiBlock, index: int, place: str) -> Iterator[None]:
    """Return a context that adds a block's name to a ValueError raised inside.

    The block is `blocks[index]`; `place` is the position of `blocks` in an outer MultiBlock.
    """
    try:
        yield
    except ValueError as error:
        raise ValueError(f"block {place}[{blocks.get_block_name(index)!r}]: {error}") from error


def datasets(blocks: pv.MultiBlock) -> Iterator[tuple[str, pv.DataSet]]:
    """Yield the path and the dataset of each nonempty dataset. A path joins the names of nested blocks: "car/wheel".

    An unnamed block has its index as name. If several blocks have the same path, their indices are appended to it:
    "wheel [2]" is blocks[2], "car/wheel [0][2]" is blocks[0][2].
    """

    def paths_in(blocks: pv.MultiBlock, names: tuple[str, ...], place: str) -> Iterator[tuple[str, str, Any]]:
        for index, block in enumerate(blocks):
            path, where = (*names, blocks.get_block_name(index) or str(index)), f"{place}[{index}]"
            if isinstance(block, pv.MultiBlock):
                yield from paths_in(block, path, where)
            elif isinstance(block, pv.DataSet) and block.n_points:
                yield "/".join(path), where, block

    found = list(paths_in(blocks, (), ""))
    counts = Counter(path for path, _, _ in found)
    for path, place, block in found:
        yield (path if counts[path] == 1 else f"{path} {place}"), block


def nested(meshes: Mapping[str, Any]) -> pv.MultiBlock:
    """Return blocks from datasets by their paths: the inverse of `datasets`. Formats of files forbid "/" in names.

    A path stays one name if a block and a dataset would have the same name.
    """
    result = pv.MultiBlock()
    for path, mesh in meshes.items():
        head, _, rest = path.partition("/")
        if not rest or head in meshes:
            result[path] = mesh
        elif head not in result.keys():  # noqa: SIM118 a MultiBlock iterates over its blocks
            inner = {each.partition("/")[2]: own for each, own in meshes.items() if each.startswith(f"{head}/")}
            result[head] = nested(inner)
    return result


def materials_of(paths: Sequence[str], materials: Mapping[str, Surface], argument: str = "material") -> list[Surface]:
    """Return the material of each block, in the order of `paths`.

    Parameters
    ----------
    paths : sequence of str
        The blocks' paths, from `datasets`.
    materials : mapping
        Path → material. Blocks whose path is not a key have the material of the key "default".
    argument : str, default "material"
        Name of the argument, for error messages.

    Raises
    ------
    ValueError
        If a block has no material, or a key is not the path of a block.
    """
    allowed = "a mapping with the names of all blocks, or with the key 'default' for the others"
    for name in materials:
        if name not in (*paths, DEFAULT):
            check.refuse(argument, f"a mapping with {name!r}", allowed, f"The blocks are {', '.join(paths)}.")
    for path in paths:
        if path not in materials and DEFAULT not in materials:
            check.refuse(argument, f"a mapping without {path!r}", allowed)
    return [materials[path if path in materials else DEFAULT] for path in paths]


def common_or_named(materials: Mapping[str, Surface]) -> dict[str, Surface]:
    """Shorten a mapping from paths of blocks to materials: if all materials are equal, return {"default": material}.

    If materials differ, return the mapping unchanged.
    """
    found = list(materials.values())
    return {DEFAULT: found[0]} if found and all(each == found[0] for each in found) else dict(materials)


def single_material(materials: Mapping[str, Surface]) -> Surface:
    """Return the material of a mesh without blocks: the material of the key "default", or else the only material.

    Raises
    ------
    ValueError
        If there is no material, or there are several and none has the key "default".
    """
    if DEFAULT not in materials and len(materials) != 1:
        check.refuse(
            "material", f"a mapping with {', '.join(materials)}", "one material, or a mapping with the key 'default'"
        )
    return materials[DEFAULT] if DEFAULT in materials else next(iter(materials.values()))


def leaves(mesh: Any) -> list[Any]:
    """Return a list of the nonempty datasets of a MultiBlock, without tables; for any other mesh, return [mesh]."""
    return of_each(mesh, lambda block: block) if isinstance(mesh, pv.MultiBlock) else [mesh]
