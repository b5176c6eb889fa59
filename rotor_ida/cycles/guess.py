"""Guesses of a limit cycle: a state, a known cycle, or a point of a branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_between
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import SPECIAL, by_number, check_as_computed
from rotor_ida.simulation.starts import state_of

# What a special point says of the parameters that vary.
VALUES = ("special_value", "special_second_value")
DOUBLING = "period_doubling"
NO_CYCLE = "start must be a limit cycle, got a result without one"
# No cycle has a shorter period,
SHORTEST_PERIOD = 1e-6
# and orbits over a longer time take too long to close.
LONGEST_PERIOD = 1e4


@dataclass(frozen=True, slots=True)
class Guess:
    """A guess of a limit cycle.

    Parameters
    ----------
    rotor : Rotor
        Its rotor.
    state : ndarray, shape (4,)
        ``(x, y, vx, vy)`` on the rotating axes [1].
    period : float or None
        Its approximate period [1]; None if not known.
    special : str
        Kind of special point of a branch; empty if it is none.
    slope : float
        Rate of the continued parameter along its branch; 1 if it is not a point of one.
    """

    rotor: Rotor
    state: Values
    period: float | None = None
    special: str = ""
    slope: float = 1.0


def guess_of(rotor: Rotor, start: object, period: object = None) -> Guess:
    """Return the guess given by a start: a state, a cycle, or one point of a branch.

    A point of a branch, special or not, sets the continued parameter and the period; a state has
    only the given period. InputError if it is none of these, or of another rotor.
    """
    if not isinstance(start, xr.Dataset) or _ends_a_run(start):
        state = np.array(state_of("start", start, rotor))
        if period is None:
            return Guess(rotor, state)
        return Guess(rotor, state, check_between("period", period, SHORTEST_PERIOD, LONGEST_PERIOD))
    if period is not None:
        raise InputError("period must be left out with a start that has one")
    check_as_computed("start", start)
    if "special_value" in start and start["special_value"].ndim == 0:
        return _of_special(rotor, start)
    needed = ("period", *COMPONENTS, *PARAMETERS)
    missing = [name for name in needed if name not in start.variables]
    if missing:
        raise InputError(
            "start must be a state, a limit cycle or a point of a branch; as a dataset it lacks "
            f"{', '.join(missing)}"
        )
    if any(start[name].ndim for name in ("period", *PARAMETERS)):
        raise InputError("start must be one point of a branch: choose it with isel(point=...)")
    if any(not start[name].size for name in COMPONENTS):
        raise InputError(NO_CYCLE)
    state = np.array([float(start[name].values.flat[0]) for name in COMPONENTS])
    slope = float(start["slope"]) if "slope" in start else 1.0
    return _checked(Guess(_rotor_of(rotor, start), state, float(start["period"]), slope=slope))


def _ends_a_run(start: xr.Dataset) -> bool:
    """Return whether a result has the state at its end alone, not a cycle with its period."""
    return "end_x" in start or ("x" in start and "period" not in start)


def as_start(guess: Guess, parameters: Sequence[str]) -> xr.Dataset:
    """Return a guess with its period as one point of a branch or curve, which `guess_of` reads."""
    rotor, prefix = guess.rotor, "special_" if guess.special else ""
    place = {name: each for name in ALL_PARAMETERS if (each := getattr(rotor, name)) is not None}
    state = zip(COMPONENTS, guess.state.tolist(), strict=True)
    held: dict[str, object] = {f"{prefix}{name}": each for name, each in state}
    held[f"{prefix}period"] = guess.period
    if guess.special:
        held["special_kind"] = SPECIAL[guess.special]
        held |= {value: place[name] for value, name in zip(VALUES, parameters, strict=False)}
    else:
        held["slope"] = guess.slope
    return xr.Dataset(held, place, {"parameters": " ".join(parameters)})


def _of_special(rotor: Rotor, start: xr.Dataset) -> Guess:
    state = np.array([float(start[f"special_{name}"]) for name in COMPONENTS])
    kind = by_number(SPECIAL)[int(start["special_kind"])]
    place = start.assign_coords(
        {name: start[value] for name, value in zip(_continued(start), VALUES, strict=False)}
    )
    return _checked(Guess(_rotor_of(rotor, place), state, float(start["special_period"]), kind))


def _continued(start: xr.Dataset) -> list[str]:
    """Return the parameters that vary along a branch or a curve; none of a single cycle."""
    return str(start.attrs.get("parameter", start.attrs.get("parameters", ""))).split()


def _rotor_of(rotor: Rotor, start: xr.Dataset) -> Rotor:
    """Return the rotor of a start, which may differ from `rotor` in what was continued."""
    own = Rotor(**{name: float(start[name]) for name in ALL_PARAMETERS if name in start})
    for name in ALL_PARAMETERS:
        here, given = getattr(own, name), getattr(rotor, name)
        if name not in _continued(start) and here != given:
            raise InputError(
                "start must be of the same rotor: its {name} is {value}, that of the rotor {given}",
                name=name, value=here, given=given,
            )  # fmt: skip
    return own


def _checked(guess: Guess) -> Guess:
    """Return the guess if it has a period."""
    if guess.period is None or not guess.period > 0.0 or not np.isfinite(guess.state).all():
        raise InputError(NO_CYCLE)
    return guess
