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
    """Compiled code that asks for the cache lines of a block's vectors; LLVM's hint, which never fails."""

    @intrinsic
    def prefetch(_typing: Any, array: Any, first: Any) -> Any:  # noqa: ARG001 Numba wants it by name
        size = array.dtype.bitwidth // 8

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            array, first = arguments
            byte, i32 = ir.IntType(8).as_pointer(), ir.IntType(32)
            kind = ir.FunctionType(ir.VoidType(), [byte, i32, i32, i32])
            function = builder.module.declare_intrinsic("llvm.prefetch", [byte], kind)
            start = builder.bitcast(builder.gep(array, [builder.mul(first, first.type(3))]), byte)
            for offset in range(0, 3 * BLOCK * size, LINE):
                line = builder.gep(start, [first.type(offset)])
                builder.call(function, [line, i32(for_writing), i32(3), i32(1)])  # into the nearest cache, of data
            return context.get_dummy_value()

        return types.void(array, types.intp), generate

    return prefetch


_to_read, _to_write = _prefetch(0), _prefetch(1)


@inlined
def ask(turn: int, first: int, points: Any, normals: Any, rgb: Any, display: Any, s: Any) -> None:
    """Ask for the block that begins with vertex `first`: its colours at turn 0, its normals at 1, its points at 2."""
    if turn == 0:
        if s.is_display:
            _to_write(display, first)
        else:
            _to_write(rgb, first)
    elif turn == 1:
        if s.needs_normals:
            _to_read(normals, first)
    elif turn == 2 and s.needs_points:
        _to_read(points, first)
