"""Vectors of float32 for compiled loops: one value a lane, one instruction for all.

A loop that sums up rows of a small window keeps its sums in vector registers from the
first row to the last only where the vectors are spelled out; left to itself, the
compiler sums up every row on its own. Vectors know ``+``, ``-`` and ``*`` with each
other, and the functions below. They exist in compiled code only.
"""

import operator
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import (
    intrinsic,
    lower_builtin,
    models,
    register_model,
    type_callable,
)

LANES = 16 if llvm.get_host_cpu_features().get("avx512f", False) else 8
_FAST = ("reassoc", "contract", "nsz", "arcp")  # NaN and infinity keep their meaning
_FLOAT = ir.FloatType()
_VECTOR = ir.VectorType(_FLOAT, LANES)
_INT = ir.IntType(32)


class VectorType(types.Type):  # type: ignore[misc]
    """The numba type of a vector."""

    def __init__(self) -> None:
        super().__init__(name=f"Vector{LANES}f")


vector = VectorType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _define_operator(symbol: Callable[[Any, Any], Any], instruction: str) -> None:
    @type_callable(symbol)
    def _type(_context):  # type: ignore[no-untyped-def]
        def typer(left, right):  # type: ignore[no-untyped-def]
            return vector if left is vector and right is vector else None

        return typer

    @lower_builtin(symbol, VectorType, VectorType)
    def _lower(_context, builder, _signature, arguments):  # type: ignore[no-untyped-def]
        return getattr(builder, instruction)(*arguments, flags=_FAST)


_OPERATORS = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul"}
for _symbol, _instruction in _OPERATORS.items():
    _define_operator(_symbol, _instruction)


def _spread(builder: Any, value: Any) -> Any:
    nothing = ir.Constant(ir.VectorType(value.type, LANES), ir.Undefined)
    first = builder.insert_element(nothing, value, ir.Constant(_INT, 0))
    order = ir.Constant(ir.VectorType(_INT, LANES), [0] * LANES)
    return builder.shuffle_vector(first, nothing, order)


@intrinsic
def spread(_context, value):  # type: ignore[no-untyped-def]
    """Vector of which all lanes are one number."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        number = context.cast(builder, arguments[0], signature.args[0], types.float32)
        return _spread(builder, number)

    return vector(value), generate


def _call(builder: Any, name: str, result: Any, arguments: Any) -> Any:
    """Call an intrinsic function of LLVM that works on vectors."""
    kind = ir.FunctionType(result, [value.type for value in arguments])
    name = f"llvm.{name}.v{LANES}f32"
    function = get_or_insert_function(builder.module, kind, name)
    return builder.call(function, arguments, fastmath=_FAST)


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.gep(data, [index])


@intrinsic
def load(_context, array, index):  # type: ignore[no-untyped-def]
    """Vector of the elements index, index + 1 ... of a float32 array in C order, flat."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        index = context.cast(builder, arguments[1], signature.args[1], types.int64)
        address = _address(context, builder, signature.args[0], arguments[0], index)
        return builder.load(builder.bitcast(address, _VECTOR.as_pointer()), align=4)

    if not isinstance(array, types.Array) or array.dtype != types.float32 or array.layout != "C":
        return None
    return vector(array, index), generate


@intrinsic
def store(_context, array, index, value):  # type: ignore[no-untyped-def]
    """Write a vector to the elements index, index + 1 ... of such an array."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        index = context.cast(builder, arguments[1], signature.args[1], types.int64)
        address = _address(context, builder, signature.args[0], arguments[0], index)
        builder.store(arguments[2], builder.bitcast(address, _VECTOR.as_pointer()), align=4)
        return context.get_dummy_value()

    if not isinstance(array, types.Array) or array.dtype != types.float32 or array.layout != "C":
        return None
    return types.none(array, index, vector), generate


@intrinsic
def fused(_context, left, right, added):  # type: ignore[no-untyped-def]
    """Compute left * right + added."""

    def generate(_context, builder, _signature, arguments):  # type: ignore[no-untyped-def]
        return _call(builder, "fmuladd", _VECTOR, arguments)

    return vector(vector, vector, vector), generate


@intrinsic
def choose(_context, number, least, if_so, if_not):  # type: ignore[no-untyped-def]
    """Take `if_so` in lanes where number >= least, else `if_not`."""

    def generate(_context, builder, _signature, arguments):  # type: ignore[no-untyped-def]
        number, least, if_so, if_not = arguments
        return builder.select(builder.fcmp_ordered(">=", number, least), if_so, if_not)

    return vector(vector, vector, vector, vector), generate


@intrinsic
def total(_context, summed):  # type: ignore[no-untyped-def]
    """Sum of all lanes, as a float64."""

    def generate(context, builder, _signature, arguments):  # type: ignore[no-untyped-def]
        zero = ir.Constant(_FLOAT, 0.0)
        found = _call(builder, "vector.reduce.fadd", _FLOAT, [zero, *arguments])
        return context.cast(builder, found, types.float32, types.float64)

    return types.float64(vector), generate


@intrinsic
def whole(_context, number):  # type: ignore[no-untyped-def]
    """Largest whole number that is not above, in each lane."""

    def generate(_context, builder, _signature, arguments):  # type: ignore[no-untyped-def]
        return _call(builder, "floor", _VECTOR, arguments)

    return vector(vector), generate


@intrinsic
def gather(_context, array, index, stride, row, col, used):  # type: ignore[no-untyped-def]
    """Elements ``index + row * stride + col`` of a flat float32 array in C order.

    `row` and `col` are vectors of whole numbers. Lanes where `used` is zero read nothing
    and give zero.
    """

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        array, index, stride, row, col, used = arguments
        wide = ir.VectorType(ir.IntType(64), LANES)
        index = context.cast(builder, index, signature.args[1], types.int64)
        stride = context.cast(builder, stride, signature.args[2], types.int64)
        base = builder.ptrtoint(
            _address(context, builder, signature.args[0], array, index), ir.IntType(64)
        )
        rows, cols = builder.fptosi(row, wide), builder.fptosi(col, wide)
        offset = builder.add(builder.mul(rows, _spread(builder, stride)), cols)
        place = builder.add(
            builder.mul(offset, _spread(builder, ir.Constant(ir.IntType(64), 4))),
            _spread(builder, base),
        )
        pointers = builder.inttoptr(place, ir.VectorType(_FLOAT.as_pointer(), LANES))
        zero = ir.Constant(_VECTOR, [0.0] * LANES)
        mask = builder.fcmp_ordered("!=", used, zero)
        kinds = [pointers.type, _INT, mask.type, _VECTOR]
        function = get_or_insert_function(
            builder.module,
            ir.FunctionType(_VECTOR, kinds),
            f"llvm.masked.gather.v{LANES}f32.v{LANES}p0",
        )
        return builder.call(function, [pointers, ir.Constant(_INT, 4), mask, zero])

    return vector(array, index, stride, vector, vector, vector), generate
