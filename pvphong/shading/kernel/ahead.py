"""Asks memory for the next block's vertices and colours while this one's lights are computed.

A processor guesses how a stream goes on only while it is being read, and a block is read and written in bursts with
much arithmetic between them. It can wait for some two dozen cache lines at once, which is one array's share of a block
in float32; so each light goes with one array, and what is written first, because it is waited for longest.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from pvphong.shading.kernel.arithmetic import inlined
from pvphong.shading.kernel.rows import BLOCK, LINE


def _prefetch(for_writing: int) -> Any:
    """Compiled code that asks for the cache line at an address; LLVM's hint, which never fails."""

    @intrinsic
    def prefetch(_typing: Any, address: Any) -> Any:  # noqa: ARG001 Numba wants it by name
        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            byte, i32 = ir.IntType(8).as_pointer(), ir.IntType(32)
            kind = ir.FunctionType(ir.VoidType(), [byte, i32, i32, i32])
            function = builder.module.declare_intrinsic("llvm.prefetch", [byte], kind)
            pointer = builder.inttoptr(arguments[0], byte)
            builder.call(function, [pointer, i32(for_writing), i32(3), i32(1)])  # into the nearest cache, of data
            return context.get_dummy_value()

        return types.void(types.intp), generate

    return prefetch


_prefetch_to_read, _prefetch_to_write = _prefetch(0), _prefetch(1)


@inlined
def _ask_for(array: Any, first: int, for_writing: bool) -> None:
    if 3 * (first + BLOCK) <= len(array):
        start = array.ctypes.data + 3 * first * array.itemsize
        for offset in range(0, 3 * BLOCK * array.itemsize, LINE):
            if for_writing:
                _prefetch_to_write(start + offset)
            else:
                _prefetch_to_read(start + offset)


@inlined
def ask(turn: int, first: int, points: Any, normals: Any, rgb: Any, display: Any) -> None:
    """Ask for the block that begins with vertex `first`: its colours at turn 0, its normals at 1, its points at 2."""
    if turn == 0:
        _ask_for(rgb, first, True)
        _ask_for(display, first, True)
    elif turn == 1:
        _ask_for(normals, first, False)
    elif turn == 2:
        _ask_for(points, first, False)
