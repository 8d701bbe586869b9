"""Writes colours past the caches, where waiting for memory takes longer than the arithmetic.

A store into a cache first reads the line that it changes: of a scene with one dull sun that is a third of the traffic.
A line that is stored whole and past the caches is not read. With more colours than the caches hold this takes a sixth
less time for scenes without highlights. Fewer are written faster into the caches where their memory has just been
used, and read again faster; and with highlights the arithmetic takes longer than memory does.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from pvphong.kernel.arithmetic import inlined
from pvphong.kernel.rows import BLOCK, LINE

# Bytes of colours from which streaming pays: the third-level cache of a server's processor of 2022.
FEWEST = 2**25

# What a vector that is stored past the caches is aligned to, and its length.
_VECTOR = 16


@intrinsic
def _copy_line(_typing: Any, source: Any, target: Any) -> Any:  # noqa: ARG001 Numba wants them by name
    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        vector = ir.VectorType(ir.IntType(8), _VECTOR).as_pointer()
        is_streamed = builder.module.add_metadata([ir.IntType(32)(1)])
        for offset in range(0, LINE, _VECTOR):
            here, there = (
                builder.inttoptr(builder.add(address, address.type(offset)), vector) for address in arguments
            )
            store = builder.store(builder.load(here, align=_VECTOR), there, align=_VECTOR)
            store.set_metadata("nontemporal", is_streamed)
        return context.get_dummy_value()

    return types.void(types.intp, types.intp), generate


@intrinsic
def finish(_typing: Any) -> Any:
    """Make what was streamed visible to other threads, for which the end of a parallel loop is not enough."""

    def generate(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), generate


@inlined
def pays(rgb: Any) -> bool:
    """Whether there are so many colours, and where they stand allows it."""
    return (len(rgb) * rgb.itemsize >= FEWEST) & (rgb.ctypes.data % _VECTOR == 0)


@inlined
def stream(rows: Any, rgb: Any, first: int) -> None:
    """Copy a whole block of colours, which stand one after the other, to the place of vertex `first` on."""
    source, target = rows.ctypes.data, rgb.ctypes.data + 3 * first * rgb.itemsize
    for offset in range(0, 3 * BLOCK * rgb.itemsize, LINE):
        _copy_line(source + offset, target + offset)
