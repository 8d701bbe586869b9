"""Arithmetic of the kernel that libraries do not offer in a vectorisable form, such as max(1 − d, floor)ⁿ.

A call of libm's `log` or `exp` inside a loop prevents LLVM from vectorising it; polynomials and shifts of exponent bits
do not. In both precisions, the power is 2^(n·log2(1 − d)).

Coefficients, highest power first, come from `mpmath.chebyfit` with 50 digits. It interpolates at Chebyshev nodes, and
its largest error is within a few per cent of the best approximation's. The exponential's constant term is exactly 1, so
that a power is exactly 1 if d = 0 or n = 0.

=======  =====================================  ==========================  ===========================
type     logarithm                              exponential                 measured error of the power
=======  =====================================  ==========================  ===========================
float32  log2(1 + t) = t·P(t), P of degree 9,   2^r = 1 + r·Q(r), Q of
         t in [√½ − 1, √2 − 1]: 8e-9            degree 5, |r| <= ½: 4e-9    1.5 · 2⁻²⁴ + n·δd
float64  log2(1 + t) = z·P(z²), P of degree 7,  2^r = 1 + r·Q(r), Q of
         z = t / (2 + t): 4e-18                 degree 10, |r| <= ½: 7e-18  1.5 · 2⁻⁵³ + n·δd
=======  =====================================  ==========================  ===========================

Here δd is the error of the given d. The power multiplies this error by n.

LLVM may contract a product and a sum into one rounding in these polynomials only, where no result depends on it. The
rest of the kernel is plain IEEE arithmetic, with `multiply_add` for a single rounding, so that a vertex's bits depend
neither on its index in a block nor on its neighbours.

At the end: access to memory through plain pointers, which compiles in half the time of Numba's arrays and counts no
references; calls through addresses, so that a new light does not require another driver; and the operations of
`pvphong.base.formulas` for one vertex. (Area lights run on `lanes`, which has the same operations for eight vertices,
because their formulas have loops and `if any_of(...)`.)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, overload, register_jitable

from pvphong.base import formulas
from pvphong.base.formulas import Function

# Counting references of arrays takes 5 to 15 % of the time on blocks this small. Without Numba's runtime there is none,
# and no memory can be allocated.
# Entry points for Python are a sixth of all code, and nothing calls them.
_OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def compiled(function: Function) -> Function:
    """Compile a function when compiled code first calls it. Arithmetic is IEEE's; a division by zero gives infinity.

    Only compiled code may call the result: calling it from Python ends the process.
    """
    return cast(Function, numba.njit(**_OPTIONS)(function))


def inlined(function: Function) -> Function:
    """Compile a function as `compiled` does, and always inline it, so that a loop around a call can be vectorised.

    Use it for large functions too. In the process that compiles, a call that is not inlined runs code that was
    optimised without its caller, up to three times slower.
    """
    return cast(Function, numba.njit(**_OPTIONS, forceinline=True)(function))


def inlined_early(function: Function) -> Function:
    """Compile a function as `inlined` does, but inline it before type inference.

    This is for functions with one caller: LLVM then sees the function and its caller as one.
    """
    return cast(Function, numba.njit(**_OPTIONS, inline="always")(function))


def contracted(function: Function) -> Function:
    """Compile a function as `inlined` does, and contract products and sums to fused multiply-adds."""
    return cast(Function, numba.njit(**_OPTIONS, forceinline=True, fastmath={"contract"})(function))


@intrinsic
def multiply_add(_typing: Any, a: Any, b: Any, c: Any) -> Any:  # noqa: ARG001 Numba reads their names
    """Return a·b + c for three numbers of one type.

    The result is rounded once on processors with fast fused multiply-add.
    LLVM would contract some products and sums by itself, depending on the loop around them. `multiply_add` is
    contracted in every loop.
    """

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = arguments[0].type
        function = builder.module.declare_intrinsic("llvm.fmuladd", [kind], ir.FunctionType(kind, [kind] * 3))
        return builder.call(function, arguments)

    return a(a, a, a), generate


_LOG32 = tuple(
    np.float32(c)
    for c in (
        -0.10749789327383041, 0.18476033210754395, -0.19138838350772858, 0.20485764741897583,
        -0.23960812389850616, 0.28855255246162415, -0.36069655418395996, 0.48089852929115295,
        -0.7213473320007324, 1.4426950216293335,
    )
)  # fmt: skip
_EXP32 = tuple(
    np.float32(c)
    for c in (
        0.00015453163359779865, 0.0013390863314270973, 0.009618083015084267, 0.055503569543361664,
        0.24022650718688965, 0.6931471824645996, 1.0,
    )
)  # fmt: skip
LOG64 = (
    0.2136589569431927, 0.2209130842311768, 0.262334352504183, 0.32059853491395984,
    0.4121985858409005, 0.5770780163455203, 0.9617966939259898, 2.8853900817779268,
)  # fmt: skip
EXP64 = (
    4.4549605981865186e-10, 7.072585949269223e-09, 1.0178062445845774e-07, 1.321544258792169e-06,
    1.525273382983612e-05, 0.0001540353044173605, 0.0013333558146416936, 0.009618129107606888,
    0.0555041086648216, 0.24022650695910097, 0.6931471805599453, 1.0,
)  # fmt: skip

# Bits of √½: numbers from √½ to √2 have the exponent 0.
_ROOT32, _ROOT64 = np.float32(0.5**0.5).view(np.int32), np.float64(0.5**0.5).view(np.int64)
_MANTISSA32, _MANTISSA64 = np.int32(23), np.int64(52)

# Adding this rounds to an integer, whose bits are then the last bits of the mantissa.
WHOLE32, _WHOLE64 = np.float32(1.5 * 2**23), 1.5 * 2**52

# Least exponent of a normal number.
_LEAST32, _LEAST64 = np.float32(-126.0), -1022.0


def log2_power(square: Any, exponent: Any, least: Any) -> Any:
    """Return `exponent` · max(log2(1 − d), `least`), where d is half of `square`.

    This is the logarithm of a power of a cosine: the angle's chord C has the squared length |C|² = `square`, and the
    cosine is 1 − d. All arguments have the same precision. (The floor is on the logarithm because 1 − floor would be
    rounded by far more than the floor's own last bit.) If d >= 1 and `least` is −∞, the result is meaningless, except
    for the exponent 0. The result is never less than the exponent of the least normal number.
    """
    raise NotImplementedError  # overloaded for each precision in compiled code


def exp2(y: Any) -> Any:
    """Return 2^y for `y`, a result of `log2_power`. Results below twice the least normal number are inexact."""
    raise NotImplementedError  # overloaded for each precision in compiled code


horner = contracted(formulas.horner)


@contracted
def _log2_power32(square: Any, exponent: Any, least: Any) -> Any:
    # Numba widens sums and shifts of int32 to int64, which would halve the length of vectors. So each is cast back.
    d = min(np.float32(0.5) * square, np.float32(1.0))
    bits = np.float32(np.float32(1.0) - d).view(np.int32)
    k = np.int32(np.int32(bits - _ROOT32) >> _MANTISSA32)
    m = np.int32(bits - np.int32(k << _MANTISSA32)).view(np.float32)
    t = -d if k == np.int32(0) else m - np.float32(1.0)  # the rounding of 1 − d matters only near the peak
    p = horner(t * t, _LOG32[1::2]) + t * horner(t * t, _LOG32[0::2])  # two short chains instead of a long one
    return max(exponent * max(t * p + np.float32(k), least), _LEAST32)


@contracted
def _exp2_32(y: Any) -> Any:
    whole = y + WHOLE32
    significand = np.float32(horner(y - (whole - WHOLE32), _EXP32)).view(np.int32)
    return np.int32(significand + np.int32(np.float32(whole).view(np.int32) << _MANTISSA32)).view(np.float32)


@contracted
def _log2_power64(square: Any, exponent: Any, least: Any) -> Any:
    d = min(0.5 * square, 1.0)
    bits = np.float64(1.0 - d).view(np.int64)
    k = (bits - _ROOT64) >> _MANTISSA64
    m = np.int64(bits - (k << _MANTISSA64)).view(np.float64)
    t = -d if k == 0 else m - 1.0
    z = t / (2.0 + t)
    return max(exponent * max(z * horner(z * z, LOG64) + np.float64(k), least), _LEAST64)


@contracted
def _exp2_64(y: Any) -> Any:
    whole = y + _WHOLE64
    significand = np.float64(horner(y - (whole - _WHOLE64), EXP64)).view(np.int64)
    return np.int64(significand + (np.float64(whole).view(np.int64) << _MANTISSA64)).view(np.float64)


@overload(log2_power, jit_options={"forceinline": True})
def _log2_power(square: Any, exponent: Any, least: Any) -> Any:  # noqa: ARG001 Numba matches the names
    chosen = _log2_power32 if square == numba.float32 else _log2_power64

    def implementation(square: Any, exponent: Any, least: Any) -> Any:
        return chosen(square, exponent, least)

    return implementation


@overload(exp2, jit_options={"forceinline": True})
def _exp2(y: Any) -> Any:
    chosen = _exp2_32 if y == numba.float32 else _exp2_64

    def implementation(y: Any) -> Any:
        return chosen(y)

    return implementation


# By `mpmath.chebyfit`, to 2e-19.
_ARCTAN = (
    0.016285756855221028, -0.034570561981427744, 0.04551593220626549, -0.05230454270650244, 0.05878928997834775,
    -0.06666424885738255, 0.07692296375032143, -0.09090908753500877, 0.11111111105155447, -0.14285714285659828,
    0.19999999999999804, -0.3333333333333333,
)  # fmt: skip

_TAN_22_5, _TINIEST = math.sqrt(2.0) - 1.0, 2.0**-1000


def arctan2(y: Any, x: Any) -> Any:
    """Return the angle θ of a point, as `math.atan2` does.

    The arguments are float64 numbers, or eight of them (see `lanes`). For angles up to 22.5°, θ = t + t³ P(t²) with t =
    tan θ. Other angles are reduced to these by symmetry and a turn by 45°. A call of libm's function would prevent
    vectorisation.
    """
    height, width = abs(y), abs(x)
    low, high = formulas.minimum(height, width), formulas.maximum(formulas.maximum(height, width), _TINIEST)
    is_steep = low > _TAN_22_5 * high
    t = formulas.select(is_steep, low - high, low) / formulas.select(is_steep, low + high, high)
    square = t * t
    turned = formulas.multiply_add(t * square, horner(square, _ARCTAN), t)
    turned = formulas.select(is_steep, turned + 0.25 * math.pi, turned)
    turned = formulas.select(height > width, 0.5 * math.pi - turned, turned)
    turned = formulas.select(x < 0.0, math.pi - turned, turned)
    return formulas.select(y < 0.0, -turned, turned)


# --- memory behind plain pointers, and calls through addresses


@intrinsic
def as_type_of(_typing: Any, rows: Any, value: Any) -> Any:
    """Convert `value` to the type of the numbers in `rows`, which is a number or a pointer to numbers."""
    kind = getattr(rows, "dtype", rows)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.cast(builder, arguments[1], signature.args[1], signature.return_type)

    return kind(rows, value), generate


@intrinsic
def shifted(_typing: Any, pointer: Any, count: Any) -> Any:  # noqa: ARG001 Numba reads its name
    """Return `pointer` moved by `count` entries."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.gep(*arguments[:1], [arguments[1]])

    return pointer(pointer, types.intp), generate


@intrinsic
def nowhere(_typing: Any, pointer: Any) -> Any:
    """Return a null pointer of the same type as `pointer`."""
    return pointer(pointer), lambda _context, _builder, _signature, arguments: ir.Constant(arguments[0].type, None)


@intrinsic
def is_nowhere(_typing: Any, pointer: Any) -> Any:
    """Return True if a pointer is null."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.icmp_unsigned("==", arguments[0], ir.Constant(arguments[0].type, None))

    return types.boolean(pointer), generate


@intrinsic
def call_stage(_typing: Any, address: Any, numbers: Any, rows: Any, points: Any) -> Any:  # noqa: ARG001 Numba's names
    """Call the stage (a compiled loop over a block) at the address `address`. Return its integer result.

    `numbers`, `rows` and `points` are the stage's arguments.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target, *pointers = arguments
        kind = ir.FunctionType(context.get_data_type(signature.return_type), [pointer.type for pointer in pointers])
        return builder.call(builder.inttoptr(target, kind.as_pointer()), pointers)

    return types.intp(types.intp, numbers, rows, points), generate


# --- the operations of `pvphong.base.formulas`, on one vertex's numbers

INLINED = {"error_model": "numpy", "_nrt": False, "forceinline": True}


_TO_BASE_2 = math.log2(math.e)

_OPERATIONS: dict[Callable[..., Any], Callable[..., Any]] = {
    formulas.sqrt: lambda x: np.sqrt(x),
    formulas.minimum: lambda a, b: min(a, b),
    formulas.maximum: lambda a, b: max(a, b),
    formulas.select: lambda condition, a, b: a if condition else b,
    formulas.multiply_add: lambda a, b, c: multiply_add(a, b, c),
    formulas.as_type_of: lambda x, value: as_type_of(x, value),
    formulas.arctan2: arctan2,
    formulas.exponential: lambda x: exp2(x * as_type_of(x, _TO_BASE_2)),
    formulas.single: lambda x: np.float32(x),
    formulas.wrapped: lambda x: np.uint32(x),
    formulas.index: lambda x: np.int64(x),
    formulas.floor: lambda x: np.floor(x),
    formulas.sine: lambda x: np.sin(x),
    formulas.cosine: lambda x: np.cos(x),
}

_BOUND: list[Callable[..., Any]] = []


def bind_formulas() -> None:
    """Let compiled code call every function that the decorator `formulas.formula` has marked since the last call."""
    for function in formulas.FORMULAS[len(_BOUND) :]:
        register_jitable(**INLINED)(function)
        _BOUND.append(function)


def _bind(operation: Callable[..., Any], compiled: Callable[..., Any]) -> None:
    def chosen(*kinds: Any) -> Callable[..., Any] | None:
        return compiled if all(isinstance(kind, types.Number | types.Boolean) for kind in kinds) else None

    overload(operation, jit_options=INLINED, strict=False)(chosen)


for _operation, _compiled in _OPERATIONS.items():
    _bind(_operation, _compiled)
bind_formulas()
