"""Guesses of a limit cycle of a rotor system: a state, a cycle, or a point of a branch or sweep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import LARGEST_NUMBER, check_between, check_real, shown
from rotor_ida.core.runs import NO_STOP
from rotor_ida.cycles.guess import DOUBLING, NO_CYCLE
from rotor_ida.cycles.system_problem import HOPF, RubNear, SystemGuess
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.schema import RESULT_KIND, SPECIAL, by_number
from rotor_ida.steady.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady.system_sweep import check_slowest, first_state
from rotor_ida.systems.archived import described_problem
from rotor_ida.systems.assembly import Assembly, assemble
from rotor_ida.systems.ends import RUNS
from rotor_ida.systems.modes import in_modes

# Tolerance of the runs that close a cycle.
CLOSING_RTOL = 1e-14
# Periods in revolutions.
SHORTEST, LONGEST = 1e-3, 1e3


@dataclass(frozen=True, slots=True)
class CycleProblem:
    """A system whose cycles are sought.

    Parameters
    ----------
    assembly : Assembly
        The system with its stators, contacts and forces.
    settling : SettlingProblem
        The same as a motion, with the tolerance that closes cycles.
    """

    assembly: Assembly
    settling: SettlingProblem

    @classmethod
    def of(
        cls, system: RotorSystem, modes: int | None = None, start: object = None
    ) -> tuple[CycleProblem, object]:
        """Return the problem of a system, and its start, in its modes.

        A dataset is already in these.
        """
        taken, begun = in_modes(system, modes, start)
        assembly = assemble(taken)
        if not assembly.contacts:
            raise InputError("contacts must be given for a limit cycle of a system, got none")
        settling = SettlingProblem.of(assembly, CLOSING_RTOL)
        if not settling.has_damping:
            raise InputError("damping must be above 0 for a limit cycle: nothing settles")
        return cls(assembly, settling), begun

    def described(self) -> dict[str, Column]:
        """Return what it is computed from, as variables, with the names of its nodes."""
        held = described_problem(self.assembly)
        return held | {"node": ("node", np.array(list(self.assembly.system.nodes), str))}

    def at(self, speed: float) -> SystemFlow:
        """Return its motion at a speed."""
        check_slowest(self.settling, np.array([speed]))
        return SystemFlow.at(self.settling, speed, NO_STOP)

    def given_state(self, flow: SystemFlow, values: Values) -> Values:
        """Return a state in scaled coordinates from q, velocity and speeds of races."""
        size = self.assembly.size
        if values.shape != flow.scales.shape or not np.isfinite(values).all():
            raise InputError(
                f"start must have {flow.scales.size} finite numbers in its state, as the system "
                f"has, got {shown(values.shape)}"
            )
        moved = [self.settling.found.to_y(each) for each in values[: 2 * size].reshape(2, size)]
        return flow.state_of(np.array(moved), values[2 * size :])

    def state_in_q(self, flow: SystemFlow, state: Values) -> Values:
        """Return q, velocity and speeds of races of a state: the inverse of `given_state`."""
        moved = self.settling.found.to_q(flow.motion_of(state))
        return np.concatenate([moved.ravel(), (state * flow.scales)[moved.size :]])


def checked_speed(speed: object) -> float:
    """Return a spin speed that is not 0."""
    value = check_real("speed", speed)
    if value == 0.0 or abs(value) > LARGEST_NUMBER:
        raise InputError(
            f"speed must not be 0, and at most {LARGEST_NUMBER:g}, for a limit cycle, got {value!r}"
        )
    return value


def guess_of_system(
    problem: CycleProblem, start: object, speed: object, period: object = None
) -> SystemGuess:
    """Return the guess given by a start: a state, a cycle, or a point of something else.

    A speed that is given replaces that of the start.
    """
    if isinstance(start, xr.Dataset) and start.attrs.get(RESULT_KIND) not in RUNS:
        if period is not None:
            raise InputError("period must be left out with a start that has one")
        return _of_dataset(problem, start, speed)
    if speed is None:
        raise InputError("speed must be given for a limit cycle of a system, got None")
    flow = problem.at(checked_speed(speed))
    begun = first_state(problem.settling, start, flow.speed)  # type: ignore[arg-type]
    guess = SystemGuess(flow, begun / flow.scales)
    if period is None:
        return guess
    longest = LONGEST * flow.revolution
    return replace(
        guess, period=check_between("period", period, SHORTEST * flow.revolution, longest)
    )


def _of_dataset(problem: CycleProblem, start: xr.Dataset, speed: object) -> SystemGuess:
    """Return the guess of a cycle, or of one point of a branch, a sweep or special speeds."""
    if _is_number(start, "special_speed") and speed is not None:
        raise InputError(f"speed must be left out with a special point, got {shown(speed)}")
    if _is_number(start, "hopf_frequency"):
        return _of_hopf_point(problem, start)
    prefix = "special_" if _is_number(start, "special_period") else ""
    state = "special_state" if prefix else "final_state"
    names = [f"{prefix}speed", f"{prefix}period"]
    if not all(_is_number(start, name) for name in names) or state not in start:
        raise InputError(
            "start must be a state, a limit cycle, or one point of a branch, of a sweep or of "
            "special speeds of a rotor system, got a dataset of "
            f"{shown(list(map(str, start.data_vars)))}"
        )
    here, period = (float(start[name]) for name in names)
    if not period > 0.0 or start[state].ndim != 1:
        raise InputError(NO_CYCLE)
    flow = problem.at(here if speed is None else checked_speed(speed))
    special = by_number(SPECIAL)[int(start["special_kind"])] if prefix else ""
    slope = float(start["slope"]) if "slope" in start and not prefix else 1.0
    values = np.asarray(start[state].values, float)
    return SystemGuess(flow, problem.given_state(flow, values), period, special, slope)


def as_start_of_system(begun: Mapping[str, Any]) -> xr.Dataset:
    """Return where a branch began, from its attributes, as a dataset that `guess_of_system` reads.

    They are ``start`` (q, velocity and speeds of races), ``start_speed``, ``start_period``,
    ``start_special`` and ``start_slope``.
    """
    special = str(begun["start_special"])
    prefix, state = ("special_", "special_state") if special else ("", "final_state")
    held: dict[str, Any] = {
        f"{prefix}{name}": float(begun[f"start_{name}"]) for name in ("speed", "period")
    }
    held[state] = ("coordinate", np.atleast_1d(begun["start"]))
    slope = {"slope": float(begun["start_slope"])}
    return xr.Dataset(held | ({"special_kind": SPECIAL[special]} if special else slope))


def _of_hopf_point(problem: CycleProblem, start: xr.Dataset) -> SystemGuess:
    """Return the rub at a Hopf point of `special_speeds`, with the period of its oscillation."""
    frequency = float(start["hopf_frequency"])
    touching = tuple(np.flatnonzero(start["in_contact"].values == 1).tolist())
    if not frequency > 0.0 or not touching or problem.settling.forward is None:
        raise InputError("start must be a Hopf point of a rub, got a special speed of another kind")
    flow = problem.at(float(start["special_speed"]))
    return hopf_guess(flow, touching, start["amplitude"].values, frequency)


def hopf_guess(
    flow: SystemFlow, touching: tuple[int, ...], radii: Values, frequency: float
) -> SystemGuess:
    """Return the rub of given contacts at its Hopf point."""
    try:
        state, rate = RubNear(flow, touching, radii, frequency).at(flow.speed)
    except ValueError as error:
        raise InputError(f"start must be a Hopf point of this system: {error}") from error
    return SystemGuess(flow, state, 2.0 * math.pi / abs(rate.imag), HOPF)


def _is_number(start: xr.Dataset, name: str) -> bool:
    return name in start.variables and start[name].ndim == 0


def check_is_cycle(guess: SystemGuess) -> None:
    """Refuse a special point where a cycle is none, or one of another period."""
    if guess.special in (HOPF, DOUBLING):
        raise InputError(
            f"start must be a limit cycle, got a point of kind {guess.special}: continue_cycle "
            "follows what begins there"
        )
