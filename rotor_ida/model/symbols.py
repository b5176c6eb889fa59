"""Symbols: running the model over them records its sums, products and quotients.

A `Graph` stores each operation once. Constants are folded, and constant factors move out of
products and quotients. The remaining products and quotients are of quantities that change: each
costs a convolution in a Taylor series.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any, ClassVar


@dataclass(eq=False, slots=True)
class Symbol:
    """The result of one operation.

    Parameters
    ----------
    graph : Graph
        The graph that stores it.
    kind : str
        ``number``, ``parameter``, ``state``, ``+``, ``-``, ``*``, ``/`` or ``**``.
    arguments : tuple
        Its operands; the value of a number; the name of a parameter or a state.
    changes : bool
        Whether it depends on the state.
    depth : int
        Length of the longest chain of operations up to it.
    number : int
        How many symbols were created before it.
    name : str
        Its name in derived code.
    """

    graph: Graph
    kind: str
    arguments: tuple[Any, ...]
    changes: bool
    depth: int
    number: int
    name: str = ""

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return NotImplemented
        return self.graph.add(self, self.graph.of(other))

    def __radd__(self, other: Any) -> Symbol:
        return self.graph.add(self.graph.of(other), self)

    def __sub__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return NotImplemented
        return self.graph.subtract(self, self.graph.of(other))

    def __rsub__(self, other: Any) -> Symbol:
        return self.graph.subtract(self.graph.of(other), self)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return NotImplemented
        return self.graph.multiply(self, self.graph.of(other))

    def __rmul__(self, other: Any) -> Symbol:
        return self.graph.multiply(self.graph.of(other), self)

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return NotImplemented
        return self.graph.divide(self, self.graph.of(other))

    def __rtruediv__(self, other: Any) -> Symbol:
        return self.graph.divide(self.graph.of(other), self)

    def __neg__(self) -> Symbol:
        return self.graph.multiply(self.graph.of(-1.0), self)

    def __pow__(self, exponent: float) -> Symbol:
        return self.graph.make("**", self, float(exponent))

    def is_number(self, value: float) -> bool:
        """Return whether it is the number `value`."""
        return self.kind == "number" and self.arguments[0] == value


@dataclass(slots=True)
class Graph:
    """All operations of one run of the model, in order of creation."""

    nodes: dict[tuple[Any, ...], Symbol] = field(default_factory=dict)

    def of(self, value: Any) -> Symbol:
        """Return a number as a symbol, or a symbol unchanged."""
        return value if isinstance(value, Symbol) else self.make("number", float(value))

    def parameter(self, name: str) -> Symbol:
        """Return a parameter, which does not change."""
        return self.make("parameter", name)

    def state(self, name: str) -> Symbol:
        """Return a component of the state."""
        return self.make("state", name)

    def make(self, kind: str, *arguments: Any) -> Symbol:
        """Return the result of an operation; equal operations give the same symbol."""
        key = (kind, *(id(each) if isinstance(each, Symbol) else each for each in arguments))
        if key not in self.nodes:
            operands = [each for each in arguments if isinstance(each, Symbol)]
            changes = kind == "state" or any(each.changes for each in operands)
            depth = 1 + max((each.depth for each in operands), default=0)
            name = str(arguments[0]) if kind in {"parameter", "state"} else ""
            self.nodes[key] = Symbol(self, kind, arguments, changes, depth, len(self.nodes), name)
        return self.nodes[key]

    def add(self, a: Symbol, b: Symbol) -> Symbol:
        """Return a sum."""
        if a.kind == b.kind == "number":
            return self.of(a.arguments[0] + b.arguments[0])
        if a.is_number(0.0):
            return b
        if b.is_number(0.0):
            return a
        if a is b:
            return self.multiply(self.of(2.0), a)
        if is_negative(b):
            return self.make("-", a, -b)
        return self.make("+", a, b)

    def subtract(self, a: Symbol, b: Symbol) -> Symbol:
        """Return a difference."""
        if a.kind == b.kind == "number":
            return self.of(a.arguments[0] - b.arguments[0])
        if b.is_number(0.0):
            return a
        if a.is_number(0.0):
            return -b
        return self.add(a, -b) if is_negative(b) else self.make("-", a, b)

    def multiply(self, a: Symbol, b: Symbol) -> Symbol:
        """Return a product, with constants first and then the later of two changing factors.

        A coefficient of a product must wait for that of its later factor.
        """
        if a.kind == b.kind == "number":
            return self.of(a.arguments[0] * b.arguments[0])
        for one, other in ((a, b), (b, a)):
            if one.is_number(0.0):
                return one
            if one.is_number(1.0):
                return other
        if not a.changes and not b.changes:
            return self._constant_product(a, b)
        (c, first), (d, second) = split(a), split(b)
        if first is None or second is None:
            return self._scaled(self.multiply(c, d), first or second)
        changing = sorted((first, second), key=lambda each: (-each.depth, each.number))
        return self._scaled(self.multiply(c, d), self.make("*", *changing))

    def divide(self, a: Symbol, b: Symbol) -> Symbol:
        """Return a quotient."""
        if a.is_number(0.0) or b.is_number(1.0):
            return a
        if not b.changes:
            return self.multiply(self.make("/", self.of(1.0), b), a)
        c, rest = split(a)
        return self._scaled(c, self.make("/", rest or self.of(1.0), b))

    def _constant_product(self, a: Symbol, b: Symbol) -> Symbol:
        """Return a product of constants; only the first factor may be a number."""
        first, second = sorted((a, b), key=lambda each: each.kind != "number")
        if first.kind == "number" and second.kind == "*" and second.arguments[0].kind == "number":
            factor = first.arguments[0] * second.arguments[0].arguments[0]
            return self.multiply(self.of(factor), second.arguments[1])
        return self.make("*", first, second)

    def _scaled(self, factor: Symbol, rest: Symbol | None) -> Symbol:
        if rest is None or factor.is_number(0.0):
            return factor
        return rest if factor.is_number(1.0) else self.make("*", factor, rest)


def split(symbol: Symbol) -> tuple[Symbol, Symbol | None]:
    """Return the constant factor of a symbol, and the rest, or None if the symbol is constant."""
    if not symbol.changes:
        return symbol, None
    if symbol.kind == "*" and not symbol.arguments[0].changes:
        return symbol.arguments[0], symbol.arguments[1]
    return symbol.graph.of(1.0), symbol


def is_negative(symbol: Symbol) -> bool:
    """Return whether a symbol has a negative number as a factor."""
    if symbol.kind == "number":
        return bool(symbol.arguments[0] < 0.0)
    return symbol.kind == "*" and is_negative(symbol.arguments[0])


@contextmanager
def named_as_in(*sources: str) -> Iterator[None]:
    """Name symbols by the variables of functions in some sources, while these run."""

    def look(frame: FrameType, event: str, _argument: Any) -> None:
        if event == "return" and any(each in frame.f_code.co_filename for each in sources):
            for name, value in frame.f_locals.items():
                if isinstance(value, Symbol) and not value.name and value.kind != "number":
                    value.name = name

    before: Callable[..., Any] | None = sys.getprofile()
    sys.setprofile(look)
    try:
        yield
    finally:
        sys.setprofile(before)


@dataclass(frozen=True, slots=True)
class Dual:
    """A value with its derivatives by some quantities: forward differentiation.

    Parameters
    ----------
    value : Symbol, float or ndarray
        The value.
    parts : tuple
        Its derivatives by these quantities; the number 0 where it does not depend on one.
    """

    value: Any
    parts: tuple[Any, ...]
    # NumPy arrays must defer to its operators
    __array_ufunc__: ClassVar[None] = None

    def __add__(self, other: Any) -> Dual:
        value, parts = _both(other, len(self.parts))
        return Dual(self.value + value, _each(lambda a, b: a + b, self.parts, parts))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Dual:
        value, parts = _both(other, len(self.parts))
        return Dual(self.value - value, _each(lambda a, b: a - b, self.parts, parts))

    def __rsub__(self, other: Any) -> Dual:
        return (-self).__add__(other)

    def __neg__(self) -> Dual:
        return self * -1.0

    def __mul__(self, other: Any) -> Dual:
        value, parts = _both(other, len(self.parts))
        return Dual(
            self.value * value,
            _each(lambda a, b: _product(a, value) + _product(self.value, b), self.parts, parts),
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        value, parts = _both(other, len(self.parts))
        whole = self.value / value
        left = _each(lambda a, b: a - _product(whole, b), self.parts, parts)
        return Dual(whole, tuple(0.0 if _is_none(part) else part / value for part in left))

    def __rtruediv__(self, other: Any) -> Dual:
        return Dual(other, (0.0,) * len(self.parts)) / self

    def __pow__(self, exponent: float) -> Dual:
        # reuses the value in a quotient; a separate power would cost one more convolution
        slope = exponent * (self.value**exponent / self.value)
        return Dual(self.value**exponent, tuple(_product(slope, part) for part in self.parts))


def _is_none(part: Any) -> bool:
    return isinstance(part, float) and part == 0.0


def _product(a: Any, b: Any) -> Any:
    """Return a product; a factor 0 gives 0 without any operation."""
    return 0.0 if _is_none(a) or _is_none(b) else a * b


def _both(value: Any, count: int) -> tuple[Any, tuple[Any, ...]]:
    return (value.value, value.parts) if isinstance(value, Dual) else (value, (0.0,) * count)


def _each(
    function: Callable[[Any, Any], Any], first: tuple[Any, ...], second: tuple[Any, ...]
) -> tuple[Any, ...]:
    return tuple(function(a, b) for a, b in zip(first, second, strict=True))


def variables(values: list[Any], others: int = 0) -> list[Dual]:
    """Return values as the variables of differentiation, one after the other."""
    count = len(values) + others
    return [
        Dual(value, tuple(1.0 if place == number else 0.0 for place in range(count)))
        for number, value in enumerate(values)
    ]
