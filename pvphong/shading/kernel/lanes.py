"""Lanes: vectors of eight vertices, on which formulas with loops run as on single numbers.

LLVM does not vectorise a loop over vertices if the formula inside loops too (over a polygon's sides, over quadrature
nodes). So each number of such a formula is an LLVM vector of eight float64 here, and a condition is eight bits. Each
operation of `pvphong.base.formulas` becomes an instruction on these vectors, or a polynomial. If a formula calls
`any_of`, one test covers eight vertices. A product and a sum may be rounded together, once, but in all lanes alike. So
a vertex's bits do not depend on its neighbours.

Coefficients, highest power first, are from `mpmath.chebyfit` with 40 digits, as in `arithmetic`; the sine's error is
3e-21. The largest measured error of all operations is 3.2 units in the last place.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.cgutils import get_or_insert_function
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    overload,
    register_jitable,
    register_model,
)

from pvphong.base import formulas
from pvphong.shading.kernel.arithmetic import EXP64, INLINED, LOG64, arctan2, horner

WIDTH = 8
"""Number of lanes."""

_F64, _I64, _BITS = (ir.VectorType(kind, WIDTH) for kind in (ir.DoubleType(), ir.IntType(64), ir.IntType(1)))


class Lanes(types.Type):
    """Numba's type of eight numbers (lanes). If the other operand is a single number, it is used for all eight."""

    def __init__(self) -> None:
        super().__init__("lanes")

    def unify(self, _context: Any, other: Any) -> Any:
        """Return this type for a variable that is sometimes a number and sometimes eight numbers.

        Return None for other types.
        """
        return self if isinstance(other, (types.Float, types.Integer)) else None


class Conditions(types.Type):
    """Type of eight truth values."""

    def __init__(self) -> None:
        super().__init__("conditions")


LANES, CONDITIONS = Lanes(), Conditions()
_NUMBERS: tuple[Any, ...] = Lanes, types.Float, types.Integer


@register_model(Lanes)
class _ModelOfLanes(models.PrimitiveModel):  # type: ignore[misc]  # Numba has no types
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _F64)


@register_model(Conditions)
class _ModelOfConditions(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _BITS)


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _spread(context: Any, builder: Any, given: Any, _wanted: Any, value: Any) -> Any:
    """Return an LLVM vector whose eight numbers are all `value`, a number of the type `given`."""
    number, undefined = context.cast(builder, value, given, types.float64), ir.Constant(_F64, ir.Undefined)
    first = builder.insert_element(undefined, number, ir.IntType(32)(0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))


def _all(kind: Any, value: Any) -> Any:
    return ir.Constant(kind, [value] * WIDTH)


# --- operations of one or a few instructions


def _operation(
    function: Callable[..., Any], kinds: Sequence[Sequence[Any]], result: Any, generate: Callable[..., Any]
) -> None:
    """Define what a function does in compiled code if an argument is eight numbers or eight conditions.

    Parameters
    ----------
    function : callable
        The function or operator, such as `operator.add`.
    kinds
        Allowed types of each argument, one sequence per argument.
    result
        Type of the result.
    generate : callable
        Takes LLVM's builder and the arguments, and returns the LLVM instruction for the result.
    """

    class Template(AbstractTemplate):  # type: ignore[misc]  # Numba has no types
        key = function

        def generic(self, args: Any, _names: Any) -> Any:
            if len(args) == len(kinds) and any(isinstance(each, (Lanes, Conditions)) for each in args):
                return signature(result, *args)
            return None

    infer_global(function)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        given = zip(sig.args, args, strict=True)
        is_one = types.Float, types.Integer
        return generate(
            builder, *(_spread(context, builder, t, LANES, x) if isinstance(t, is_one) else x for t, x in given)
        )

    for chosen in product(*kinds):
        if Lanes in chosen or Conditions in chosen:
            lower_builtin(function, *chosen)(lower)


def _call(name: str) -> Callable[..., Any]:
    """Return a function that emits a call of LLVM's intrinsic `name` with vectors of eight float64."""

    def generate(builder: Any, *arguments: Any) -> Any:
        kind = ir.FunctionType(_F64, [_F64] * len(arguments))
        return builder.call(get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), arguments)

    return generate


def _compared(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


_ONE, _TWO = (_NUMBERS,), (_NUMBERS,) * 2
for _function, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operation(
        _function, _TWO, LANES, lambda builder, a, b, name=_name: getattr(builder, name)(a, b, flags=["contract"])
    )
for _function, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _operation(_function, _TWO, CONDITIONS, _compared(_sign))
for _function, _name in ((operator.and_, "and_"), (operator.or_, "or_")):
    _operation(
        _function, ((Conditions,),) * 2, CONDITIONS, lambda builder, a, b, name=_name: getattr(builder, name)(a, b)
    )
_operation(operator.invert, ((Conditions,),), CONDITIONS, lambda builder, a: builder.not_(a))
_operation(operator.neg, _ONE, LANES, lambda builder, a: builder.fneg(a))
_operation(abs, _ONE, LANES, _call("fabs"))
_operation(formulas.sqrt, _ONE, LANES, _call("sqrt"))
_operation(formulas.nearest, _ONE, LANES, _call("rint"))
_operation(formulas.multiply_add, (_NUMBERS,) * 3, LANES, _call("fma"))
_operation(formulas.minimum, _TWO, LANES, lambda builder, a, b: builder.select(builder.fcmp_ordered("<", a, b), a, b))
_operation(formulas.maximum, _TWO, LANES, lambda builder, a, b: builder.select(builder.fcmp_ordered(">", a, b), a, b))
_OF_THREE = (Conditions,), _NUMBERS, _NUMBERS
_operation(formulas.select, _OF_THREE, LANES, lambda builder, c, a, b: builder.select(c, a, b))


def _any(builder: Any, conditions: Any) -> Any:
    bits = builder.bitcast(conditions, ir.IntType(WIDTH))
    return builder.icmp_unsigned("!=", bits, bits.type(0))


_operation(formulas.any_of, ((Conditions,),), types.boolean, _any)


def _largest(builder: Any, numbers: Any) -> Any:
    found = builder.extract_element(numbers, ir.IntType(32)(0))
    for lane in range(1, WIDTH):
        other = builder.extract_element(numbers, ir.IntType(32)(lane))
        found = builder.select(builder.fcmp_ordered(">", other, found), other, found)
    return builder.fptosi(found, ir.IntType(64))


_operation(formulas.largest, _ONE, types.int64, _largest)

_EXPONENT, _BIAS, _MANTISSA, _ROOT = 0x7FF << 52, 1023, 52, 0x3FE6A09E667F3BCD  # the last: bits of √½
_WHOLE = 1.5 * 2.0**52
# Adding this rounds to a whole number, whose bits are then the last bits.


def _power_below(builder: Any, x: Any) -> Any:
    """Return 1/2ᵏ for a normal number x in [2ᵏ, 2ᵏ⁺¹), where k is an integer.

    The result's bits are twice the exponent's bias minus the bits of x's exponent. `builder` is LLVM's builder.
    """
    exponent = builder.and_(builder.bitcast(x, _I64), _all(_I64, _EXPONENT))
    return builder.bitcast(builder.sub(_all(_I64, 2 * _BIAS << _MANTISSA), exponent), _F64)


_operation(formulas.over_its_size, _ONE, LANES, _power_below)


@intrinsic
def _parted(_typing: Any, x: Any) -> Any:
    """Return k and m with x = 2ᵏ · m, where k is an integer and m is in [√½, √2). x must be greater than 0."""

    def generate(context: Any, builder: Any, given: Any, values: Any) -> Any:
        bits = builder.bitcast(values[0], _I64)
        k = builder.ashr(builder.sub(bits, _all(_I64, _ROOT)), _all(_I64, _MANTISSA))
        m = builder.bitcast(builder.sub(bits, builder.shl(k, _all(_I64, _MANTISSA))), _F64)
        whole = builder.bitcast(builder.add(k, builder.bitcast(_all(_F64, _WHOLE), _I64)), _F64)
        return context.make_tuple(builder, given.return_type, (builder.fsub(whole, _all(_F64, _WHOLE)), m))

    return types.UniTuple(LANES, 2)(x), generate  # type: ignore[attr-defined]


@intrinsic
def _two_to(_typing: Any, shifted: Any) -> Any:
    """Return 2ᵏ. The argument `shifted` is k, an integer, plus the constant `_WHOLE`."""

    def generate(_context: Any, builder: Any, _given: Any, values: Any) -> Any:
        bits = builder.shl(builder.bitcast(values[0], _I64), _all(_I64, _MANTISSA))
        return builder.bitcast(builder.add(bits, builder.bitcast(_all(_F64, 1.0), _I64)), _F64)

    return LANES(shifted), generate


def _listed(builder: Any, row: Any, start: Any, rows: Any, place: Any) -> list[Any]:
    """Return pointers to eight numbers of a row.

    The row begins `start` entries after the pointer `row`. The indices of the numbers in this row are eight consecutive
    entries of `rows`, from `place` on. `builder` is LLVM's builder.
    """
    places = [builder.load(builder.gep(rows, [builder.add(place, place.type(lane))])) for lane in range(WIDTH)]
    return [builder.gep(row, [builder.add(start, builder.fptosi(each, start.type))]) for each in places]


@intrinsic
def load_listed(_typing: Any, row: Any, start: Any, rows: Any, place: Any) -> Any:  # noqa: ARG001 Numba's names
    """Return eight numbers of a row, as float64.

    The row begins `start` entries after the pointer `row`. The indices of the numbers in this row are eight consecutive
    entries of `rows`, from `place` on. If the last index is the first plus seven, the numbers are consecutive, and one
    load suffices.
    """

    def generate(_context: Any, builder: Any, _given: Any, values: Any) -> Any:
        pointers = _listed(builder, *values)
        kind = ir.VectorType(pointers[0].type.pointee, WIDTH)
        first, last = (builder.ptrtoint(pointers[lane], _I64.element) for lane in (0, -1))
        apart = (WIDTH - 1) * row.dtype.bitwidth // 8
        side_by_side = builder.icmp_unsigned("==", builder.sub(last, first), _I64.element(apart))
        with builder.if_else(side_by_side) as (then, otherwise):
            with then:
                together = builder.load(builder.bitcast(pointers[0], kind.as_pointer()), align=row.dtype.bitwidth // 8)
                after_then = builder.block
            with otherwise:
                collected: Any = ir.Constant(kind, ir.Undefined)
                for lane, pointer in enumerate(pointers):
                    collected = builder.insert_element(collected, builder.load(pointer), ir.IntType(32)(lane))
                after_otherwise = builder.block
        found = builder.phi(kind)
        found.add_incoming(together, after_then)
        found.add_incoming(collected, after_otherwise)
        return found if kind == _F64 else builder.fpext(found, _F64)

    return LANES(row, types.intp, rows, types.intp), generate


@intrinsic
def store(_typing: Any, rows: Any, place: Any, numbers: Any) -> Any:  # noqa: ARG001 Numba reads their names
    """Store eight numbers into consecutive entries of `rows`, from `place` on, rounded to the type of the rows."""

    def generate(_context: Any, builder: Any, _given: Any, values: Any) -> Any:
        start = builder.gep(values[0], [values[1]])
        kind = ir.VectorType(start.type.pointee, WIDTH)
        rounded = values[2] if kind == _F64 else builder.fptrunc(values[2], kind)
        builder.store(rounded, builder.bitcast(start, kind.as_pointer()), align=rows.dtype.bitwidth // 8)

    return types.void(rows, types.intp, LANES), generate


@intrinsic
def store_listed(_typing: Any, rows: Any, start: Any, place: Any, numbers: Any) -> Any:  # noqa: ARG001 as above
    """Store eight numbers into a row, rounded to the type of the row.

    The row begins at offset `start` in `rows`. The indices of the numbers in this row are eight consecutive entries of
    `rows`, from `place` on.
    """

    def generate(_context: Any, builder: Any, _given: Any, values: Any) -> Any:
        to, start, place, numbers = values
        for lane, pointer in enumerate(_listed(builder, to, start, to, place)):
            number = builder.extract_element(numbers, ir.IntType(32)(lane))
            kind = pointer.type.pointee
            builder.store(number if kind == _F64.element else builder.fptrunc(number, kind), pointer)

    return types.void(rows, types.intp, types.intp, LANES), generate


# --- operations that are polynomials


def _polynomial(operation: Callable[..., Any]) -> Callable[..., Any]:
    """Return a decorator. The decorated function replaces `operation` in compiled code if an argument is eight numbers.

    `operation` is a function of `pvphong.base.formulas`, such as `sine`.
    """

    def bind(function: Callable[..., Any]) -> Callable[..., Any]:
        def chosen(*kinds: Any) -> Any:
            return function if any(kind == LANES for kind in kinds) else None

        overload(operation, jit_options=INLINED, strict=False)(chosen)
        return function

    return bind


_SINE = (
    -8.00395186685969e-18, 2.8104490805984874e-15, -7.647138381112494e-13, 1.6059043464982344e-10,
    -2.5052108382236485e-08, 2.7557319223970366e-06, -0.00019841269841269803, 0.008333333333333333,
    -0.16666666666666666,
)  # fmt: skip

_PI, _LESS_THAN_PI = math.pi, 1.2246467991473532e-16

_polynomial(formulas.arctan2)(arctan2)


@_polynomial(formulas.sine)
def _sine(x: Any) -> Any:
    """Return the sine of x as sin r · (−1)ᵏ, where r = x − kπ."""
    k = formulas.nearest(x * (1.0 / _PI))
    r = formulas.multiply_add(k, -_LESS_THAN_PI, formulas.multiply_add(k, -_PI, x))
    odd = abs(k - 2.0 * formulas.nearest(0.5 * k))
    square = r * r
    found = formulas.multiply_add(r * square, horner(square, _SINE), r)
    return found * (1.0 - 2.0 * odd)


@_polynomial(formulas.cosine)
def _cosine(x: Any) -> Any:
    return formulas.sine((0.5 * _PI - abs(x)) + 0.5 * _LESS_THAN_PI)


@register_jitable(**INLINED)
def _log2_above_one(x: Any) -> Any:
    """Return log₂(1 + x) for x >= −1, to full precision near x = 0; −1023 at −1."""
    k, m = _parted(1.0 + x)
    t = formulas.select(abs(k) > 0.0, m - 1.0, x)
    z = t / (2.0 + t)
    return formulas.multiply_add(z, horner(z * z, LOG64), k)


@_polynomial(formulas.log1p)
def _log1p(x: Any) -> Any:
    return math.log(2.0) * _log2_above_one(x)


@_polynomial(formulas.power_less_one)
def _power_less_one(less: Any, exponent: Any) -> Any:
    """Return (1 − `less`) to the power `exponent`, minus 1.

    This is 2ʸ − 1, where y = `exponent` · log₂(1 − `less`). 2ʸ is the product of two powers of two. One has an integer
    exponent, and one a fractional exponent.
    """
    y = formulas.maximum(exponent * _log2_above_one(-formulas.minimum(less, 1.0)), -1022.0)
    shifted = y + _WHOLE
    r = y - (shifted - _WHOLE)
    scale = _two_to(shifted)
    return formulas.multiply_add(r * horner(r, EXP64[:-1]), scale, scale - 1.0)
