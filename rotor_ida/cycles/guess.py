"""Guesses of a limit cycle: a state, a known cycle, or a point of a branch or a sweep."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, LARGEST_NUMBER, check_between, check_real, shown
from rotor_ida.core.runs import NO_STOP
from rotor_ida.cycles.birth import RubNear
from rotor_ida.cycles.orbit import disc_of
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.reduction import in_modes
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.schema import RESULT_KIND, SPECIAL, by_number, check_as_computed
from rotor_ida.schema.quantities import SPECIAL_VALUES
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.starts import RUNS, start_of
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady.points import check_slowest, state_of_start

DOUBLING, HOPF = "period_doubling", "hopf"
NO_CYCLE = "start must be a limit cycle, got a result without one"
# No cycle of one disc has a shorter period, and orbits over a longer time take too long to close;
# those of a system in revolutions.
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-6, 1e4
SHORTEST, LONGEST = 1e-3, 1e3
# Tolerance of the runs that close a cycle of a system.
CLOSING_RTOL = 1e-14


@dataclass(frozen=True, slots=True)
class Guess:
    """A guess of a limit cycle.

    Parameters
    ----------
    flow : Flow
        How its rotor moves.
    state : ndarray, shape (n,)
        A state of the flow.
    period : float or None
        Its approximate period; None if not known.
    special : str
        Kind of special point of a branch; empty if it is none.
    slope : float
        Rate of the continued parameter along its branch; 1 if it is not a point of one.
    """

    flow: Flow
    state: Values
    period: float | None = None
    special: str = ""
    slope: float = 1.0

    @property
    def rotor(self) -> Rotor:
        """The rotor of one disc."""
        return disc_of(self.flow)


# ---- Of one disc ----


def guess_of(rotor: Rotor, start: object, period: object = None) -> Guess:
    """Return the guess given by a start: a state, a cycle, or one point of a branch.

    A point of a branch, special or not, sets the continued parameter and the period; a state has
    only the given period. InputError if it is none of these, or of another rotor.
    """
    if not has_period(start, period):
        return Guess(DiscFlow(rotor), np.array(start_of(rotor, start)), checked(period))
    return guess_in(start, rotor)


def has_period(start: object, period: object) -> TypeGuard[xr.Dataset]:
    """Return whether a start is a cycle with its period, or a point of a branch."""
    if not isinstance(start, xr.Dataset):
        return False
    if "end_x" in start or ("x" in start and "period" not in start):  # the end of a run
        return False
    if period is not None:
        raise InputError("period must be left out with a start that has one")
    return True


def checked(period: object) -> float | None:
    """Return a period of one disc, if one is given."""
    if period is None:
        return None
    return check_between("period", period, SHORTEST_PERIOD, LONGEST_PERIOD)


def guess_in(start: xr.Dataset, rotor: Rotor | None = None) -> Guess:
    """Return the guess given by a cycle or one point of a branch, of this rotor if one is given."""
    check_as_computed("start", start)
    place, prefix = _place_in(start, ALL_PARAMETERS)
    numbers = [f"{prefix}{name}" for name in ("period", *COMPONENTS)]
    missing = [name for name in (*numbers, *PARAMETERS) if name not in start.variables]
    if missing:
        raise InputError(
            "start must be a state, a limit cycle or a point of a branch; as a dataset it lacks "
            f"{', '.join(missing)}"
        )
    if start[numbers[0]].ndim or not place.keys() >= {*PARAMETERS}:
        raise InputError("start must be one point of a branch: choose it with isel(point=...)")
    state = np.array([each for name in numbers[1:] for each in start[name].values.flat[:1]])
    return _guess_at(DiscFlow(_rotor_at(rotor, place, start)), state, start, prefix)


def as_start(guess: Guess, parameters: Sequence[str]) -> xr.Dataset:
    """Return a guess with its period as one point of a branch or curve over some parameters."""
    flow, prefix = guess.flow, "special_" if guess.special else ""
    held: dict[str, object] = {f"{prefix}period": guess.period}
    if isinstance(flow, SystemFlow):
        place = {SPEED: flow.speed, **flow.given}
        state = "special_state" if prefix else "final_state"
        held[state] = ("component", flow.in_q(guess.state))
    else:
        place = dict(guess.rotor.given)
        numbers = zip(COMPONENTS, guess.state.tolist(), strict=True)
        held |= {f"{prefix}{name}": each for name, each in numbers}
    if guess.special:
        held["special_kind"] = SPECIAL[guess.special]
        varied = zip(SPECIAL_VALUES, parameters, strict=False)
        held |= {value: flow.value_of(name) for value, name in varied}
    else:
        held["slope"] = guess.slope
    return xr.Dataset(held, place, {"parameters": " ".join(parameters)})


def _place_in(start: xr.Dataset, names: Sequence[str]) -> tuple[dict[str, Any], str]:
    """Return the parameters at a point, and the beginning of the names of its state and period."""
    place = {name: float(start[name]) for name in names if _is_number(start, name)}
    if not _is_number(start, SPECIAL_VALUES[0]):
        return place, ""
    values = zip(_continued(start), SPECIAL_VALUES, strict=False)
    return place | {name: float(start[value]) for name, value in values}, "special_"


def _guess_at(flow: Flow, state: Values, start: xr.Dataset, prefix: str) -> Guess:
    """Return the guess at a point that is a cycle, special or not."""
    period = float(start[f"{prefix}period"])
    if not period > 0.0 or not state.size or not np.isfinite(state).all():
        raise InputError(NO_CYCLE)
    if prefix:
        return Guess(flow, state, period, by_number(SPECIAL)[int(start["special_kind"])])
    return Guess(flow, state, period, slope=float(start["slope"]) if "slope" in start else 1.0)


def _continued(start: xr.Dataset) -> list[str]:
    """Return the parameters that vary along a branch or a curve; none of a single cycle."""
    return str(start.attrs.get("parameter", start.attrs.get("parameters", ""))).split()


def _rotor_at(rotor: Rotor | None, place: dict[str, Any], start: xr.Dataset) -> Rotor:
    """Return the rotor at a point, which may differ from `rotor` in what was continued."""
    own = Rotor(**place)
    for name in ALL_PARAMETERS if rotor is not None else ():
        here, given = getattr(own, name), getattr(rotor, name)
        if name not in _continued(start) and here != given:
            raise InputError(
                "start must be of the same rotor: its {name} is {value}, that of the rotor {given}",
                name=name, value=here, given=given,
            )  # fmt: skip
    return own


# ---- Of a rotor system ----


def guess_of_system(
    system: RotorSystem, start: object, speed: object, period: object = None,
    modes: int | None = None, *, follows: bool = False,
) -> Guess:  # fmt: skip
    """Return the guess given by a start: a state, a cycle, or a point of something else.

    A speed that is given replaces that of the start. A dataset is already in the modes. Where a
    branch or curve is followed from a point, the other parameters of the system are those there.
    """
    taken, start = in_modes(system, modes, start)
    problem = SettlingProblem.of(assemble(taken), CLOSING_RTOL)
    if not problem.assembly.contacts:
        raise InputError("contacts must be given for a limit cycle of a system, got none")
    if not problem.has_damping:
        raise InputError("damping must be above 0 for a limit cycle: nothing settles")
    if isinstance(start, xr.Dataset) and start.attrs.get(RESULT_KIND) not in RUNS:
        if period is not None:
            raise InputError("period must be left out with a start that has one")
        return _of_dataset(problem, start, speed, follows)
    if speed is None:
        raise InputError("speed must be given for a limit cycle of a system, got None")
    flow = flow_at(problem, speed)
    begun = state_of_start(problem, start, flow.speed) / flow.scales  # type: ignore[arg-type]
    if period is not None:
        shortest, longest = SHORTEST * flow.revolution, LONGEST * flow.revolution
        period = check_between("period", period, shortest, longest)
    return Guess(flow, begun, period)


def flow_at(problem: SettlingProblem, speed: object) -> SystemFlow:
    """Return the motion of a system at a speed that is not 0."""
    value = check_real("speed", speed)
    if value == 0.0 or abs(value) > LARGEST_NUMBER:
        raise InputError(
            "{name} must not be 0, and at most {most:g}, for a limit cycle, got {value}",
            name="speed", most=LARGEST_NUMBER, value=value,
        )  # fmt: skip
    check_slowest(problem, np.array([value]))
    return SystemFlow.at(problem, value, NO_STOP)


def _of_dataset(problem: SettlingProblem, start: xr.Dataset, speed: object, follows: bool) -> Guess:
    """Return the guess of a cycle, or of one point of a branch, a sweep or special speeds."""
    place, prefix = _place_in(start, (SPEED, *PARAMETERS_OF_SYSTEM))
    if (prefix or _is_number(start, "special_speed")) and speed is not None:
        raise InputError(f"speed must be left out with a special point, got {shown(speed)}")
    if _is_number(start, "hopf_frequency"):
        return _of_hopf_point(problem, start)
    state = "special_state" if prefix else "final_state"
    if SPEED not in place or not _is_number(start, f"{prefix}period") or state not in start:
        raise InputError(
            "start must be a state, a limit cycle, or one point of a branch, of a sweep or of "
            "special speeds of a rotor system, got a dataset of "
            f"{shown(list(map(str, start.data_vars)))}"
        )
    here = place.pop(SPEED)
    if not float(start[f"{prefix}period"]) > 0.0 or start[state].ndim != 1:
        raise InputError(NO_CYCLE)
    flow = flow_at(problem, here if speed is None else speed)
    if follows and place:
        try:
            flow = flow.but(**place)
        except SimulationError as error:
            raise InputError(f"start must be of a rotor such as this: {error}") from error
    given = flow.given_state(np.asarray(start[state].values, float))
    return _guess_at(flow, given, start, prefix)


def _of_hopf_point(problem: SettlingProblem, start: xr.Dataset) -> Guess:
    """Return the rub at a Hopf point of `special_speeds`, with the period of its oscillation."""
    frequency = float(start["hopf_frequency"])
    touching = tuple(np.flatnonzero(start["in_contact"].values == 1).tolist())
    if not frequency > 0.0 or not touching or problem.forward is None:
        raise InputError("start must be a Hopf point of a rub, got a special speed of another kind")
    flow = flow_at(problem, float(start["special_speed"]))
    try:
        rub = RubNear(flow, "speed", touching, start["amplitude"].values, frequency)
        state, rate = rub.at(flow.speed)
    except ValueError as error:
        raise InputError(f"start must be a Hopf point of this system: {error}") from error
    return Guess(flow, state, 2.0 * math.pi / abs(rate.imag), HOPF)


def _is_number(start: xr.Dataset, name: str) -> bool:
    return name in start.variables and start[name].ndim == 0
