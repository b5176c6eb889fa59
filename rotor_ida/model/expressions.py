"""Write symbols as lines of C: as values, or as recurrences of Taylor series, a line a product."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from rotor_ida.model.derivation import lanes_of, needed, needs_convolution, operands
from rotor_ida.model.modes import Mode
from rotor_ida.model.symbols import Symbol

# Lanes in a vector, or differences of which a vector contains the same component.
LANES_A_VECTOR = 4
# Columns of a line inside two levels of braces.
WIDEST = 100 - 9
# How strongly a piece of C binds.
SUM, PRODUCT, ATOM = range(3)


@dataclass(slots=True)
class Writer:
    """Writes expressions.

    Parameters
    ----------
    state : callable
        Returns the C expression of a component of the state, given by name.
    names : dict
        Names already given, by number of the symbol.
    one : str
        Coefficient n of the constant 1 where a series is written; empty for values.
    kind : str
        Type of the results: numbers, ``double``, or vectors of four, ``vec4``.
    fused : bool
        Whether a product that is added to something is not rounded.
    """

    state: Callable[[str], str]
    names: dict[int, str] = field(default_factory=dict)
    one: str = ""
    kind: str = "double"
    fused: bool = False

    def __call__(self, node: Symbol, binding: int = SUM) -> str:
        """Return a symbol, in parentheses where it binds less than its context."""
        text, own = self._operand(node)
        return text if own >= binding else f"({text})"

    def _operand(self, node: Symbol) -> tuple[str, int]:
        if self.one and not node.changes:
            return f"{self.one} * {Writer(self.state)(node, ATOM)}", PRODUCT
        if node.number in self.names:
            return self.names[node.number], ATOM
        if node.kind == "number":
            return repr(node.arguments[0]), ATOM if node.arguments[0] >= 0.0 else PRODUCT
        if node.kind == "parameter":
            return f"m->{node.name}", ATOM
        return (self.state(node.name), ATOM) if node.kind == "state" else self.operation(node)

    def operation(self, node: Symbol) -> tuple[str, int]:
        """Return the operation of a symbol, and how strongly it binds."""
        a, b = node.arguments
        if node.kind == "**":
            return _power(self(a), b, self.kind if a.changes else "double"), ATOM
        if node.kind == "*":
            factor = self(a, PRODUCT) if a.changes else Writer(self.state)(a, PRODUCT)
            minus = factor == "-1.0"
            return f"-{self(b, ATOM)}" if minus else f"{factor} * {self(b, ATOM)}", PRODUCT
        if node.kind == "/":
            form = "ratio({}, {})" if self.kind == "double" else "({}) / ({})"
            return form.format(self(a), self(b)), ATOM
        sign = "-" if node.kind == "-" else ""
        if self.fused and self._is_product(b):
            return f"fma({sign}{self._factors(b)}, {self(a)})", ATOM
        if self.fused and self._is_product(a):
            return f"fma({self._factors(a)}, {sign}{self(b, ATOM)})", ATOM
        return f"{self(a)} {node.kind} {self(b, PRODUCT)}", SUM

    def _is_product(self, node: Symbol) -> bool:
        """Return whether a symbol is a product that has no name of its own."""
        named = node.number in self.names
        return node.kind == "*" and not named and not node.arguments[0].is_number(-1.0)

    def _factors(self, node: Symbol) -> str:
        a, b = node.arguments
        return f"{self(a, ATOM)}, {self(b)}"


def _power(base: str, exponent: float, kind: str) -> str:
    """Return a power, by roots where possible; that of a named vector lane by lane."""
    if kind != "double":
        lanes = [_power(f"{base}[{i}]", exponent, "double") for i in range(LANES_A_VECTOR)]
        return f"({kind}){{{', '.join(lanes)}}}"
    if exponent == 0.25:
        return f"sqrt(sqrt({base}))"
    return f"sqrt({base})" if exponent == 0.5 else f"pow({base}, {exponent!r})"


def names_of(
    nodes: Sequence[Symbol], outputs: Sequence[Symbol], *, products: bool = True
) -> dict[int, str]:
    """Return names for symbols that the model names or uses more than once, and for products."""
    used = Counter(operand.number for node in nodes for operand in operands(node))
    used.update(output.number for output in outputs)
    # the first coefficient of a base is needed separately
    bases = {node.arguments[0].number for node in nodes if node.kind == "**"}
    of_state = {node.name for node in nodes if node.kind == "state"}
    names: dict[int, str] = {}
    for node in nodes:
        if node.kind in {"number", "parameter", "state"} or not node.changes:
            continue
        name = node.name
        is_asked = used[node.number] > 1 or node.number in bases
        is_asked |= products and needs_convolution(node)
        if not name and is_asked:
            name = f"w{len(names)}"
        while name in of_state or name in names.values():
            name += "_"
        if name:
            names[node.number] = name
    return names


def values_of(
    outputs: Sequence[tuple[str, Symbol]], mode: Mode, kind: str = "double", *, fused: bool = False
) -> list[str]:
    """Return the lines that compute outputs, given as pairs of target and value.

    They are numbers, or vectors of numbers.
    """
    symbols = [symbol for _, symbol in outputs]
    nodes = needed(symbols)
    names = names_of(nodes, [], products=not fused)
    lines = given_in(nodes, mode, "state", kind)
    writer = Writer(lambda name: name, kind=kind, fused=fused)
    for node in nodes:
        if node.number in names:
            lines.append(f"const {kind} {names[node.number]} = {writer(node)};")
            writer.names[node.number] = names[node.number]
    for place, symbol in outputs:
        scalar = kind != "double" and not symbol.changes
        said = writer(symbol)
        lines.append(f"{place} = spread({said});" if scalar else f"{place} = {said};")
    return lines


def given_in(nodes: Sequence[Symbol], mode: Mode, row: str, kind: str = "double") -> list[str]:
    """Return the lines that name the required components of a state."""
    return [
        f"const {kind} {name} = {row}[{place_of(mode, name)}];" for name in used_in(nodes, mode)
    ]


def used_in(nodes: Sequence[Symbol], mode: Mode) -> list[str]:
    """Return the required components of a state."""
    used = {node.name for node in nodes if node.kind == "state"}
    return [name for name in mode.state if name in used]


def place_of(mode: Mode, name: str) -> str:
    """Return the C name of the place of a component in the state of a mode."""
    return f"{mode.name}_{name}".upper()


def function_of(name: str, given: str, comment: str, lines: Sequence[str]) -> list[str]:
    """Return a function."""
    head = f"void {name}(const struct parameters *m,\n    {given})"
    unused = [] if any("m->" in line for line in lines) else ["(void)m;"]
    return [f"/* {comment} */", head, "{", *(f"    {line}" for line in [*unused, *lines]), "}", ""]


def is_idle(line: str, body: Sequence[str]) -> bool:
    """Return whether a line names a first value that no other line needs."""
    name = line.removeprefix("const double ").split(" = ")[0]
    if not name.endswith("_first"):
        return False
    return not any(re.search(rf"\b{name}\b", other) for other in body if other != line)


def recurrences(
    mode: Mode, nodes: Sequence[Symbol], names: dict[int, str]
) -> tuple[list[str], list[str]]:
    """Return the lines computed once, and those of coefficient n of each named symbol."""
    first = Writer("{}_first".format)
    writer, shown = Writer(lambda name: name, names, one="one"), Writer(lambda name: name, names)
    before = [
        line.replace(" = ", "_first = ") for line in given_in(nodes, mode, "series->terms[0]")
    ]
    lines: list[str] = []
    lane = 0

    def at_first(node: Symbol, what: str) -> str:
        name = f"{what}_{names[node.number]}"
        said = first(node) if what == "first" else f"inverse({first(node)})"
        line = f"const double {name} = {said};"
        before.extend([line] if line not in before else [])
        return name

    for node in nodes:
        if node.number not in names:
            continue
        a, b = node.arguments
        end = ""
        if not needs_convolution(node):
            said, _ = writer.operation(node)
        elif node.kind == "*":
            said, end = (
                f"times(series, {lane}, n, {writer(a)}, {writer(b)})",
                shown.operation(node)[0],
            )
        elif node.kind == "/":
            said = f"over(series, {lane}, n, {writer(a)}, {writer(b)}, {at_first(b, 'inverse')})"
            end = f"{shown(a, PRODUCT)} / {shown(b, ATOM)}"
        else:
            known = f"one * {at_first(node, 'first')}, {at_first(a, 'inverse')}"
            said = f"raised(series, {lane}, n, {writer(a)}, {b!r}, {known})"
            end = f"{shown(a, ATOM)}**{b!r}"
        line = f"const double {names[node.number]} = {said};"
        comment = f"/* {end} */".replace("m->", "") if end else ""
        fits = len(line) + len(comment) < WIDEST
        lines += [f"{line} {comment}".rstrip()] if fits else [*filter(None, [comment]), line]
        lane += lanes_of(node) if needs_convolution(node) else 0
    return before, lines
