"""The numbers of limit cycles as labelled columns: of one, of a branch, of a bifurcation curve."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch import CLOSED, Side, SpecialBehind
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.multipliers import defects_of, is_stable, multipliers_of
from rotor_ida.cycles.problems import PLACE
from rotor_ida.cycles.shooting import Cycle, checked_cycle
from rotor_ida.model.parameters import Rotor
from rotor_ida.schema import (
    QUANTITIES,
    RESPONSE,
    SPECIAL,
    STABILITY,
    Column,
    labelled,
    labelled_dataset,
)


def cycle_columns(cycles: Sequence[Cycle], dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return the numbers of cycles, one after the other on a dimension; names get the prefix."""
    multipliers = np.array([multipliers_of(cycle.shot) for cycle in cycles]).reshape(len(cycles), 4)
    defects = np.array([defects_of(cycle.shot) for cycle in cycles]).reshape(len(cycles), 2)
    stable = [STABILITY["stable" if is_stable(cycle.shot) else "unstable"] for cycle in cycles]
    columns: dict[str, Column] = {
        "period": (dim, _of(cycles, "period")),
        "radius_min": (dim, _of(cycles, "radius_min")),
        "radius_max": (dim, _of(cycles, "radius_max")),
        "response": (dim, np.array([RESPONSE[cycle.response] for cycle in cycles], dtype=np.int8)),
        "stability": (dim, np.array(stable, dtype=np.int8)),
        "contact_count": (dim, np.array([cycle.contacts for cycle in cycles], dtype=np.int64)),
        "largest_force": (dim, _of(cycles, "largest_force")),
        "impulse_per_period": (dim, _of(cycles, "impulse")),
        "multiplier_real": ((dim, "multiplier"), multipliers.real),
        "multiplier_imag": ((dim, "multiplier"), multipliers.imag),
        "trace": (dim, np.array([float(cycle.shot.monodromy.trace()) for cycle in cycles])),
        "residual": (dim, _of(cycles, "residual")),
        "trivial_defect": (dim, defects[:, 0]),
        "symplectic_defect": (dim, defects[:, 1]),
    }
    states = np.array([cycle.state for cycle in cycles]).reshape(len(cycles), 4)
    return {
        f"{prefix}{name}": of_cycle(name, *column) for name, column in columns.items()
    } | state_columns(states, dim, prefix)


def state_columns(states: Values, dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return states on the rotating axes, shape (n, 4), as variables ``x y vx vy``."""
    return {
        f"{prefix}{name}": xr.Variable(
            dim, np.ascontiguousarray(column), QUANTITIES[f"rotating_{name}"].attributes()
        )
        for name, column in zip(COMPONENTS, states.T, strict=True)
    }


def of_cycle(name: str, dims: Hashable | Sequence[Hashable], values: npt.ArrayLike) -> xr.Variable:
    """Return a variable of limit cycles, labelled so where its name serves other things too."""
    quantity = QUANTITIES[f"cycle_{name}" if f"cycle_{name}" in QUANTITIES else name]
    return xr.Variable(dims, np.asarray(values), quantity.attributes())


def _of(cycles: Sequence[Cycle], name: str) -> Values:
    return np.array([getattr(cycle, name) for cycle in cycles], dtype=np.float64)


def start_attributes(guess: Guess) -> dict[str, object]:
    """Return from where a curve of cycles was followed, as attributes of its dataset."""
    return {
        "start": guess.state,
        "start_period": guess.period or math.nan,
        **{f"start_{name}": value for name, value in guess.rotor.given.items()},
    }


def branch_dataset(
    sides: tuple[Side, Side], parameters: tuple[str, ...], rotor: Rotor, title: str, *, kind: str
) -> xr.Dataset:
    """Return both sides, forward and backward, of a curve of cycles, from end to end.

    `parameters` vary, in their order among the unknowns; the others are those of `rotor`.
    """
    forward, backward = sides
    before = len(backward.points) - 1
    points = [point.reversed() for point in backward.points[:0:-1]] + forward.points
    specials = [SpecialBehind(before - place - 1, each) for place, each in backward.specials[::-1]]
    specials += [SpecialBehind(before + place, each) for place, each in forward.specials]
    variables = cycle_columns([checked_cycle(point.stretch) for point in points], "point")
    slopes = np.array([point.tangent[PLACE] for point in points])
    variables["slope"] = of_cycle("slope", "point", slopes)
    variables |= _special_columns(specials, parameters)
    coordinates = {
        name: labelled(name, (), value)
        for name, value in rotor.given.items()
        if name not in parameters
    }
    for place, name in enumerate(parameters, start=PLACE):
        values = np.array([point.unknowns[place] for point in points])
        coordinates[name] = labelled(name, "point", values)
    coordinates["multiplier"] = labelled("multiplier", "multiplier", np.arange(4))
    closed = forward.end == CLOSED
    ends = {
        "closed": int(closed),
        "first_end": CLOSED if closed else backward.end or "start",
        "last_end": forward.end or "start",
        "first_reason": backward.reason,
        "last_reason": forward.reason,
    }
    return labelled_dataset(title, variables, coordinates, ends, kind=kind)


def _special_columns(
    specials: Sequence[SpecialBehind], parameters: tuple[str, ...]
) -> dict[str, xr.Variable]:
    """Return the special points, in order along the curve."""
    cycles = [checked_cycle(each.point.stretch) for _, each in specials]
    unknowns = np.array([each.point.unknowns for _, each in specials])
    unknowns = unknowns.reshape(-1, PLACE + len(parameters))
    columns: dict[str, npt.ArrayLike] = {
        "special_kind": np.array([SPECIAL[each.name] for _, each in specials], dtype=np.int8),
        "special_value": unknowns[:, PLACE],
        "special_period": unknowns[:, PLACE - 1],
        "special_radius_min": np.array([cycle.radius_min for cycle in cycles], dtype=np.float64),
        "special_radius_max": np.array([cycle.radius_max for cycle in cycles], dtype=np.float64),
        "special_point": np.array([place for place, _ in specials], dtype=np.int64),
    }
    if len(parameters) > 1:
        columns["special_second_value"] = unknowns[:, PLACE + 1]
    variables = {name: labelled(name, "special", column) for name, column in columns.items()}
    return variables | state_columns(unknowns[:, :4], "special", "special_")
