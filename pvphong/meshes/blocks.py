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
"""Name of the material for blocks without a material of their own name."""


def map_blocks(blocks: pv.MultiBlock, operation: Callable[[Any], Any], place: str = "") -> pv.MultiBlock:
    """Return a new MultiBlock of the same structure and names, with `operation` applied to each dataset.

    None stays None; tables and empty datasets are copied unchanged. Errors name the block.
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
    """Return the results of an operation on each dataset of `datasets`; errors name the block."""
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
    """An error that is raised meanwhile names the block."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"block {place}[{blocks.get_block_name(index)!r}]: {error}") from error


def datasets(blocks: pv.MultiBlock) -> Iterator[tuple[str, pv.DataSet]]:
    """Yield the path of names and the dataset of each nonempty block.

    Indices are appended to a path that several blocks share: "wheel [2]" is blocks[2], "car/wheel [0][2]" is
    blocks[0][2]. The name of an unnamed block is its index.
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


def materials_of(paths: Sequence[str], materials: Mapping[str, Surface]) -> list[Surface]:
    """Return the materials of all blocks, in their order.

    Parameters
    ----------
    paths : sequence of str
        The blocks' paths of names, from `datasets`.
    materials : mapping
        Path → material; "default" is for blocks that are not named.

    Raises
    ------
    ValueError
        If a block has no material, or a name is not a block's.
    """
    allowed = "a mapping with the names of all blocks, or with 'default' for those not named"
    for name in materials:
        if name not in (*paths, DEFAULT):
            check.refuse("material", f"a mapping with {name!r}", allowed, f"The blocks are {', '.join(paths)}.")
    for path in paths:
        if path not in materials and DEFAULT not in materials:
            check.refuse("material", f"a mapping without {path!r}", allowed)
    return [materials[path if path in materials else DEFAULT] for path in paths]


def common_or_named(materials: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the materials of all blocks by name, or only "default" if all are equal."""
    found = list(materials.values())
    return {DEFAULT: found[0]} if found and all(each == found[0] for each in found) else dict(materials)


def single_material(materials: Mapping[str, Surface]) -> Surface:
    """Return the material of a mesh without blocks: the one named "default", or the only one.

    Raises
    ------
    ValueError
        If there are several, and none is named "default".
    """
    if DEFAULT not in materials and len(materials) != 1:
        check.refuse("material", f"those of {', '.join(materials)}", "one, or one of them named 'default'")
    return materials[DEFAULT] if DEFAULT in materials else next(iter(materials.values()))


def leaves(mesh: Any) -> list[Any]:
    """Return the datasets in all nonempty blocks, without tables; for a mesh without blocks, the mesh itself."""
    return of_each(mesh, lambda block: block) if isinstance(mesh, pv.MultiBlock) else [mesh]
