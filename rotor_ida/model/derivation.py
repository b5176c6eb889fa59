"""Derive the symbols of a mode of the model, from which the compiled core is written.

A mode is run once over symbols, and over dual numbers for the derivatives: by each component of
its state, by the distance of a neighbour, and by the parameters.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Any

from rotor_ida.model.forces import turned_rates
from rotor_ida.model.modes import Mode, Model
from rotor_ida.model.symbols import Dual, Graph, Symbol, named_as_in, split, variables

Matrix = list[list[Symbol]]
# Modules whose variables give symbols their names.
SOURCES = ("contact", "forces", "rates", "neighbours", "drawn_rates", "modes", "spinning")


@dataclass(frozen=True, slots=True)
class Derived:
    """The derived symbols of one mode.

    Parameters
    ----------
    mode : Mode
        The mode.
    rates : list of Symbol
        The rate of change of each component of the state.
    drawn_rates : list of Symbol
        The same, with terms that return the state to its constraints.
    jacobian : list of list of Symbol
        The derivatives of these by each component.
    growth : list of list of Symbol
        The matrix of the linear growth of a small difference, per unit of the variable of
        integration; empty, like the next, where the mode has no neighbours.
    by_parameters : list of list of Symbol
        The derivatives by each parameter of the time rates of position and velocity.
    pace : Symbol
        Derivative of time by the variable of integration.
    watched, watched_rates : list of Symbol
        Quantities watched in addition to the state, and their rates of change.
    """

    mode: Mode
    rates: list[Symbol]
    drawn_rates: list[Symbol]
    jacobian: Matrix
    growth: Matrix
    by_parameters: Matrix
    pace: Symbol
    watched: list[Symbol]
    watched_rates: list[Symbol]


@dataclass(frozen=True, slots=True)
class Place:
    """The place of a factor in the growth of a difference: row, column, number and sign."""

    row: int
    column: int
    factor: int
    negative: bool


def derive(mode: Mode, model: Model, fixed: Mapping[str, float] = MappingProxyType({})) -> Derived:
    """Run a mode of a model over symbols; parameters and components may be fixed numbers."""
    graph = Graph()
    parameters = {name: graph.parameter(name) for name in model.parameters}
    rotor = SimpleNamespace(**{**parameters, **model.constants, **fixed})
    state = [graph.of(fixed[n]) if n in fixed else graph.state(n) for n in mode.state]
    pace = graph.of(mode.pace(state))
    with named_as_in(*(str(Path(__file__).with_name(name)) for name in SOURCES)):
        rates = [graph.of(rate) for rate in mode.rates(state, rotor)]
        drawn_rates = [graph.of(rate) for rate in mode.drawn_rates(state, rotor)]
        growth = _growth(graph, mode, state, rotor) if mode.neighbour else []
        watched = [graph.of(each) for each in mode.watched(state, rotor)] if mode.watched else []
    rates = [
        graph.of(0.0) if n in fixed else rate for n, rate in zip(mode.state, rates, strict=True)
    ]
    slopes = mode.drawn_rates(variables(state), rotor)
    more = mode.watched(variables(state), rotor) if mode.watched else []
    return Derived(
        mode,
        rates,
        drawn_rates,
        [_parts(graph, rate, len(state)) for rate in slopes],
        [[pace * entry for entry in row] for row in growth],
        _by_parameters(graph, mode, state, rotor, model.columns) if mode.neighbour else [],
        pace,
        watched,
        [_along(graph, _parts(graph, each, len(state)), rates) for each in more],
    )


def _along(graph: Graph, parts: list[Symbol], rates: list[Symbol]) -> Symbol:
    """Return the rate of change of a quantity with these derivatives by the state."""
    total = graph.of(0.0)
    for part, rate in zip(parts, rates, strict=True):
        if not part.is_number(0.0):
            total = total + part * rate
    return total


def _growth(graph: Graph, mode: Mode, state: list[Symbol], rotor: Any) -> Matrix:
    """Return the derivatives, by the distance of a neighbour, of its time rates."""
    assert mode.neighbour
    apart = variables([graph.of(0.0)] * 4)
    near = mode.neighbour(state, apart, apart[0], rotor)
    rates = turned_rates(near.position, near.velocity, near.acceleration, near.turning)
    return [_parts(graph, rate, 4) for rate in rates]


def _by_parameters(
    graph: Graph, mode: Mode, state: list[Symbol], rotor: Any, columns: tuple[str, ...]
) -> Matrix:
    """Return the derivatives of the rates on the rotating axes: a row for each parameter.

    Derivatives by parameters on which the rates do not depend are 0.
    """
    assert mode.neighbour
    names = [name for name in columns if name != "delta0" and hasattr(rotor, name)]
    varied = variables([getattr(rotor, name) for name in names], others=1)
    changed = SimpleNamespace(**vars(rotor) | dict(zip(names, varied, strict=True)))
    # at a fixed position, more clearance means less indentation
    deeper = Dual(graph.of(0.0), (*(0.0 for _ in names), -1.0))
    here = mode.neighbour(state, [graph.of(0.0)] * 4, deeper, changed)
    rates = turned_rates(here.position, here.velocity, here.acceleration, changed.omega)
    found = [_parts(graph, rate, len(names) + 1) for rate in rates]
    places = {name: place for place, name in enumerate([*names, "delta0"])}
    still = graph.of(0.0)
    return [
        [parts[places[name]] if name in places else still for parts in found] for name in columns
    ]


def _parts(graph: Graph, value: Any, count: int) -> list[Symbol]:
    """Return the derivatives of a value; 0 if it has none."""
    parts = value.parts if isinstance(value, Dual) else (0.0,) * count
    return [graph.of(part) for part in parts]


def needed(outputs: Iterable[Symbol]) -> list[Symbol]:
    """Return all symbols that outputs depend on, each after its operands."""
    found: dict[int, Symbol] = {}

    def visit(node: Symbol) -> None:
        if node.number not in found:
            for operand in operands(node):
                visit(operand)
            found[node.number] = node

    for output in outputs:
        visit(output)
    return list(found.values())


def operands(node: Symbol) -> list[Symbol]:
    """Return the symbols among the operands of an operation."""
    return [each for each in node.arguments if isinstance(each, Symbol)]


def needs_convolution(node: Symbol) -> bool:
    """Return whether its coefficients are sums over those of its operands."""
    if not node.changes or node.kind not in {"*", "/", "**"}:
        return False
    return node.kind != "*" or bool(node.arguments[0].changes)


def lanes_of(node: Symbol) -> int:
    """Return the number of convolutions that it needs."""
    return 2 if node.kind == "**" else 1


def factors_of(derived: Derived) -> tuple[list[Symbol], list[Place]]:
    """Return the series that multiply differences, and their places.

    The pace comes first, unless it is constant; it multiplies all entries that satisfy `is_steady`.
    """
    factors = [derived.pace] if derived.pace.changes else []
    places: list[Place] = []
    for row, entries in enumerate(derived.growth):
        for column, entry in enumerate(entries):
            if is_steady(entry, derived.pace):
                continue
            negative = -entry in factors
            if not negative and entry not in factors:
                factors.append(entry)
            factor = factors.index(-entry if negative else entry)
            places.append(Place(row, column, factor, negative))
    return factors, places


def is_steady(entry: Symbol, pace: Symbol) -> bool:
    """Return whether an entry of the growth is a constant times the pace."""
    if not pace.changes:
        return not entry.changes
    return entry.is_number(0.0) or split(entry)[1] is pace
