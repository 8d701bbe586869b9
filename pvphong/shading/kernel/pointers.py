"""What compiled code does with memory that it is given as a plain pointer: numbers of its type, offsets, and calls.

Stages and the driver take pointers rather than Numba's arrays: they compile in half the time, and no references are
counted. A stage is called through its address, so that no driver is compiled anew for a new light.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic


@intrinsic
def like(_typing: Any, rows: Any, value: Any) -> Any:
    """A number in the type of rows."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.cast(builder, arguments[1], signature.args[1], signature.return_type)

    return rows.dtype(rows, value), generate


@intrinsic
def shifted(_typing: Any, pointer: Any, count: Any) -> Any:  # noqa: ARG001 Numba wants it by name
    """The pointer to what stands so many entries further on."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.gep(*arguments[:1], [arguments[1]])

    return pointer(pointer, types.intp), generate


@intrinsic
def nowhere(_typing: Any, pointer: Any) -> Any:
    """A pointer of the same type to nothing."""

    def generate(_context: Any, _builder: Any, _signature: Any, arguments: Any) -> Any:
        return arguments[0].type(None)

    return pointer(pointer), generate


@intrinsic
def is_nowhere(_typing: Any, pointer: Any) -> Any:
    """Whether a pointer is to nothing."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.icmp_unsigned("==", arguments[0], arguments[0].type(None))

    return types.boolean(pointer), generate


@intrinsic
def taken(_typing: Any, counter: Any, count: Any) -> Any:  # noqa: ARG001 Numba wants it by name
    """A counter's value before so much was added to it, at once, whatever other threads do."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.atomic_rmw("add", *arguments, "seq_cst")

    return types.intp(counter, types.intp), generate


def _call(result: Any) -> Any:
    """Compiled code that calls a function at an address with three pointers."""

    @intrinsic
    def call(_typing: Any, address: Any, numbers: Any, rows: Any, points: Any) -> Any:  # noqa: ARG001 Numba's names
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            target, *pointers = arguments
            kind = ir.FunctionType(context.get_data_type(result), [pointer.type for pointer in pointers])
            given = builder.call(builder.inttoptr(target, kind.as_pointer()), pointers)
            return context.data_model_manager[signature.return_type].from_data(builder, given)

        return result(types.intp, numbers, rows, points), generate

    return call


call_light, call_reflectance = _call(types.boolean), _call(types.intp)
