"""Sums over rows of coefficients: products of series, and series at a point.

Here is nearly all of the arithmetic. In compiled code each row is one vector of the processor's, or
a few of them; what LLVM makes of plain loops takes three times as long.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

Values = npt.NDArray[np.float64]

# Columns: of products that are summed together, and of a state, with room to spare.
LANES, WIDTH = 16, 8
_FUSED = ("contract",)
# Stands for a number that is known when code is compiled: its length.
Count = tuple[int, ...]


def sum_known(left: Values, right: Values, known: Values, n: int) -> None:
    """Sum what is known of coefficient n of each product: all but the end terms.

    Parameters
    ----------
    left, right : ndarray, shape (orders, 16)
        Coefficients of the factors below n.
    known : ndarray, shape (16,)
        Overwritten with the sums over k from 1 to n - 1 of ``left[k] right[n - k]``.
    n : int
        The order.
    """
    known[:] = 0.0
    for k in range(1, n):
        known += left[k] * right[n - k]


def sum_products(
    factors: Values, first: int, parts: Values, count: Count, n: int, total: Values
) -> None:
    """Sum coefficient n of the products of some series, each with a row of series of its own.

    Parameters
    ----------
    factors : ndarray, shape (m, orders)
        Coefficients of series, of which those from `first` on are factors here.
    first : int
        The first of them.
    parts : ndarray, shape (count, orders, 16)
        Coefficients of the other factors.
    count : tuple
        As long as there are products to be summed.
    n : int
        The order.
    total : ndarray, shape (16,)
        Overwritten.
    """
    total[:] = 0.0
    for part in range(len(count)):
        for k in range(n + 1):
            total += factors[first + part, k] * parts[part, n - k]


def evaluate(terms: Values, order: int, point: float, values: Values) -> None:
    """Write the values of series at a point into `values`: Horner's rule.

    Parameters
    ----------
    terms : ndarray, shape (orders, 8)
        Coefficients.
    order : int
        The highest.
    point : float
        Where.
    values : ndarray, shape (8,) or the first part of one
        Overwritten.
    """
    total = terms[order].copy()
    for n in range(order - 1, -1, -1):
        total = total * point + terms[n]
    values[:] = total[: values.size]


def evaluate_row(terms: Values, order: int, point: float, values: Values) -> None:
    """Do as `evaluate` does for rows of 16 series."""
    evaluate(terms, order, point, values)


def evaluate_sizes(terms: Values, order: int, point: float, sizes: Values) -> None:
    """Do as `evaluate` does with every coefficient without its sign."""
    evaluate(np.abs(terms), order, point, sizes)


def _row_type(width: int) -> ir.VectorType:
    return ir.VectorType(ir.DoubleType(), width)


def _data(context: Any, builder: Any, kinds: Sequence[Any], arrays: Sequence[Any]) -> list[Any]:
    """Return where the numbers of some arrays begin."""
    return [
        context.make_array(kind)(context, builder, array).data
        for kind, array in zip(kinds, arrays, strict=True)
    ]


def _load(builder: Any, data: Any, number: Any, width: int) -> Any:
    """Return a row."""
    place = builder.gep(data, [builder.mul(number, ir.Constant(number.type, width))])
    return builder.load(builder.bitcast(place, _row_type(width).as_pointer()), align=8)


def _store(builder: Any, row: Any, data: Any) -> None:
    builder.store(row, builder.bitcast(data, row.type.as_pointer()), align=8)


def _add_product(builder: Any, total: Any, a: Any, b: Any) -> Any:
    return builder.fadd(total, builder.fmul(a, b, flags=_FUSED), flags=_FUSED)


def _sum_rows(_typing: Any, left: Any, right: Any, known: Any, n: Any) -> tuple[Any, Any]:
    """Do as `sum_known` does."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, second, out = _data(context, builder, signature.args[:3], arguments[:3])
        order = arguments[3]
        nought, one, two = (ir.Constant(order.type, number) for number in range(3))

        def product(k: Any) -> tuple[Any, Any]:
            return _load(builder, first, k, LANES), _load(
                builder, second, builder.sub(order, k), LANES
            )

        # outwards from the middle: the rows written last, at the ends, are waited for last
        half = builder.sdiv(order, two)
        even = builder.icmp_signed("==", builder.and_(order, one), nought)
        has_middle = builder.and_(even, builder.icmp_signed(">", half, nought))
        zero = ir.Constant(_row_type(LANES), [0.0] * LANES)
        a, b = product(half)
        middle = builder.select(has_middle, builder.fmul(a, b), zero)
        lower, upper = (
            cgutils.alloca_once_value(builder, middle),
            cgutils.alloca_once_value(builder, zero),
        )
        pairs = builder.sdiv(builder.sub(order, one), two)
        with cgutils.for_range(builder, pairs) as loop:
            k = builder.sub(pairs, loop.index)
            a, b = product(k)
            builder.store(_add_product(builder, builder.load(lower), a, b), lower)
            a, b = product(builder.sub(order, k))
            builder.store(_add_product(builder, builder.load(upper), a, b), upper)
        _store(builder, builder.fadd(builder.load(lower), builder.load(upper)), out)
        return context.get_dummy_value()

    return types.void(left, right, known, n), code


def _sum_parts(
    _typing: Any, factors: Any, first: Any, parts: Any, count: Any, n: Any, total: Any
) -> tuple[Any, Any]:
    """Do as `sum_products` does, with a sum for each product, as one would wait for itself."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        table = context.make_array(signature.args[0])(context, builder, arguments[0])
        (data,) = _data(context, builder, signature.args[2:3], arguments[2:3])
        (out,) = _data(context, builder, signature.args[5:], arguments[5:])
        order, orders = arguments[4], builder.extract_value(table.shape, 1)
        zero = ir.Constant(_row_type(LANES), [0.0] * LANES)
        sums = [cgutils.alloca_once_value(builder, zero) for _ in range(len(count))]
        after = builder.add(order, ir.Constant(order.type, 1))
        # the row written last comes last, as it is waited for
        with cgutils.for_range(builder, after) as loop:
            back = builder.sub(order, loop.index)
            for part, sum_of_part in enumerate(sums):
                number = ir.Constant(order.type, part)
                place = builder.mul(builder.add(arguments[1], number), orders)
                factor = builder.gep(table.data, [builder.add(place, back)])
                a = _spread(builder, builder.load(factor), LANES)
                row = builder.add(builder.mul(number, orders), loop.index)
                product = _add_product(
                    builder, builder.load(sum_of_part), a, _load(builder, data, row, LANES)
                )
                builder.store(product, sum_of_part)
        whole = builder.load(sums[0])
        for sum_of_part in sums[1:]:
            whole = builder.fadd(whole, builder.load(sum_of_part))
        _store(builder, whole, out)
        return context.get_dummy_value()

    return types.void(factors, first, parts, count, n, total), code


def _spread(builder: Any, number: Any, width: int) -> Any:
    """Return a row that holds one number everywhere."""
    empty, first = ir.Constant(_row_type(width), [0.0] * width), ir.Constant(ir.IntType(32), 0)
    row = builder.insert_element(empty, number, first)
    same = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    return builder.shuffle_vector(row, row, same)


def _horner(width: int, *, absolute: bool) -> Callable[..., tuple[Any, Any]]:
    """Return an intrinsic that does as `evaluate` does, or as `evaluate_sizes`, from order 1 on."""

    def rows(_typing: Any, terms: Any, order: Any, point: Any, values: Any) -> tuple[Any, Any]:
        """Do as `evaluate` does."""

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            (data,) = _data(context, builder, signature.args[:1], arguments[:1])
            (out,) = _data(context, builder, signature.args[3:], arguments[3:])
            order, row = arguments[1], _row_type(width)
            size = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(row, [row]), f"llvm.fabs.v{width}f64"
            )

            def terms_of(number: Any) -> Any:
                loaded = _load(builder, data, number, width)
                return builder.call(size, [loaded]) if absolute else loaded

            # every other term apart, as one sum would wait for itself
            one, two = ir.Constant(order.type, 1), ir.Constant(order.type, 2)
            point = _spread(builder, arguments[2], width)
            square = builder.fmul(point, point)
            before = builder.sub(order, one)
            first = cgutils.alloca_once_value(builder, terms_of(order))
            second = cgutils.alloca_once_value(builder, terms_of(before))
            with cgutils.for_range(builder, builder.sdiv(before, two)) as loop:
                down = builder.mul(two, builder.add(loop.index, one))
                for total, number in ((first, order), (second, before)):
                    row = terms_of(builder.sub(number, down))
                    builder.store(_add_product(builder, row, builder.load(total), square), total)
            high, low = builder.load(first), builder.load(second)
            even = builder.icmp_signed("==", builder.and_(order, one), ir.Constant(order.type, 0))
            last = _add_product(builder, terms_of(ir.Constant(order.type, 0)), high, square)
            high, low = builder.select(even, low, high), builder.select(even, last, low)
            _store(builder, _add_product(builder, low, high, point), out)
            return context.get_dummy_value()

        return types.void(terms, order, point, values), code

    return rows


_sum_in_code: Any = intrinsic(_sum_rows)
_sums_in_code: Any = intrinsic(_sum_parts)
_evaluate_in_code: Any = intrinsic(_horner(WIDTH, absolute=False))
_row_in_code: Any = intrinsic(_horner(LANES, absolute=False))
_sizes_in_code: Any = intrinsic(_horner(WIDTH, absolute=True))


# numba calls such a function with the types of the arguments, and compiles what it returns.
# ruff: noqa: ARG001
@overload(sum_known)
def _sum_known(left: Any, right: Any, known: Any, n: Any) -> Any:
    def by_rows(left: Any, right: Any, known: Any, n: Any) -> None:
        _sum_in_code(left, right, known, n)

    return by_rows


@overload(sum_products)
def _sum_products(factors: Any, first: Any, parts: Any, count: Any, n: Any, total: Any) -> Any:
    def by_rows(factors: Any, first: Any, parts: Any, count: Any, n: Any, total: Any) -> None:
        _sums_in_code(factors, first, parts, count, n, total)

    return by_rows


@overload(evaluate)
def _evaluate(terms: Any, order: Any, point: Any, values: Any) -> Any:
    def by_rows(terms: Any, order: Any, point: Any, values: Any) -> None:
        _evaluate_in_code(terms, order, point, values)

    return by_rows


@overload(evaluate_row)
def _evaluate_row(terms: Any, order: Any, point: Any, values: Any) -> Any:
    def by_rows(terms: Any, order: Any, point: Any, values: Any) -> None:
        _row_in_code(terms, order, point, values)

    return by_rows


@overload(evaluate_sizes)
def _evaluate_sizes(terms: Any, order: Any, point: Any, sizes: Any) -> Any:
    def by_rows(terms: Any, order: Any, point: Any, sizes: Any) -> None:
        _sizes_in_code(terms, order, point, sizes)

    return by_rows
