"""Checks of the arguments of a fit, and the problem that they define."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_between,
    check_state,
    check_vector,
    did_you_mean,
    shown,
)
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.errors import InputError
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.fitting.problem import FitProblem, Unknown
from rotor_ida.fitting.records import Measured, measured, noise_of
from rotor_ida.model.parameters import OF_MACHINE, OPTIONAL
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.schema.flags import ENTRY, EXIT
from rotor_ida.signals.record import lacks_mark
from rotor_ida.signals.windows import fit_orders

# Parameters that can be fitted: their units for a machine; for a dimensionless rotor, the machine's
# parameter and the factor between the two.
FIXED = ("speed", "contact_exponent", "disc_radius")
UNITS = {name: each.unit for name, each in OF_MACHINE.items() if name not in FIXED} | {ANGLE: "rad"}
OF_ROTOR = {
    "zeta": ("damping", 2.0),
    "delta0": ("clearance", 1.0),
    **{name: (name, 1.0) for name in (*OPTIONAL, ANGLE) if name not in FIXED},
}
# Parameters that must be positive stay above this part of their first guess.
POSITIVE = (*(name for name, each in OF_MACHINE.items() if each.positive), "clearance")
LEAST = 1e-3
MOST_ORDERS, LARGEST_ORDER = 20, 20.0
# Whirls up to this part of the clearance are without contact; and at speeds closer than this part
# to the guessed critical speed, their phase depends on the guess.
FREE, RESONANT = 0.5, 0.25
# Smallest errors allowed, relative to the length or size of the signals: rounding.
SHARPEST = 1e-12


def problem_of(
    signals: xr.Dataset | Sequence[xr.Dataset],
    machine: Rotor | DimensionalRotor,
    unknown: Sequence[str],
    *,
    orders: npt.ArrayLike,
    revolutions: int | None,
    start: npt.ArrayLike | None,
    entries: Any,
    exits: Any,
    time_error: float | None,
    noise: float | None,
) -> FitProblem:
    """Check all arguments and return the problem."""
    given = [signals] if isinstance(signals, xr.Dataset) else _several(signals)
    if not given:
        raise InputError(f"signals must be a dataset, or a list of them, got {shown(signals)}")
    in_si = isinstance(machine, DimensionalRotor)
    guess = _in_si(machine)
    if guess.clearance <= 0.0:
        raise InputError("machine must have a clearance above 0 for a fit, got 0.0")
    sought = _unknowns(unknown, guess, in_si=in_si)
    if ANGLE not in [each.field for each in sought] and any(
        isinstance(each, xr.Dataset) and lacks_mark(each.attrs) for each in given
    ):
        raise InputError(
            f"unknown must include {ANGLE} when the angle is integrated from a speed or has no "
            f"mark among several pulses, as its origin is not known, got {shown(list(unknown))}"
        )
    tracked = _checked_orders(orders)
    touches = {
        ENTRY: _by_record("entries", entries, len(given)),
        EXIT: _by_record("exits", exits, len(given)),
    }
    # without a load the mean position says nothing, and may be the gap of a DC-coupled probe
    with_mean = 0.0 in tracked or guess.load > 0.0 or "load" in [each.field for each in sought]
    records = [
        measured(
            each, tracked, revolutions, {kind: times[n] for kind, times in touches.items()},
            in_si=in_si, with_mean=with_mean,
        )
        for n, each in enumerate(given)
    ]  # fmt: skip
    sought = [
        replace(each, guess=_unbalance_angle(guess, records)) if each.field == ANGLE else each
        for each in sought
    ]
    problem = FitProblem(guess, sought, records, 1.0)
    problem.time_error = _checked_time_error(time_error, records)
    problem.starts = _starts(start, records)
    problem.noise = noise_of(records) if noise is None else _checked_noise(noise, records)
    _check_enough(problem)
    return problem


def _in_si(machine: object) -> DimensionalRotor:
    """Return a machine; a dimensionless one gets 1 for reference length, mass and time."""
    if isinstance(machine, DimensionalRotor):
        return machine
    if not isinstance(machine, Rotor):
        raise InputError(f"machine must be a Rotor or a DimensionalRotor, got {shown(machine)}")
    optional = {name: getattr(machine, name) for name in OPTIONAL}
    return DimensionalRotor(
        mass=1.0, contact_stiffness=1.0, damping=2.0 * machine.zeta, eccentricity=1.0,
        clearance=machine.delta0, speed=machine.omega, **optional,
    )  # fmt: skip


def _unknowns(unknown: object, machine: DimensionalRotor, *, in_si: bool) -> list[Unknown]:
    """Return the unknowns, checked."""
    known = UNITS if in_si else OF_ROTOR
    allowed = f"{', '.join(known)}"
    names = _several(unknown)
    if names is None:
        raise InputError(f"unknown must be a list of names from {allowed}, got {shown(unknown)}")
    wrong = [each for each in names if not isinstance(each, str) or each not in known]
    if wrong or not names:
        meant = did_you_mean(wrong[0], known) if wrong else ""
        raise InputError(
            f"unknown must be of {allowed}, got {shown(wrong[0] if wrong else names)}{meant}"
        )
    if len(set(names)) < len(names):
        raise InputError(f"unknown must name each once, got {shown(names)}")
    if "friction" in names and not machine.disc_radius:
        raise InputError("machine must have a disc_radius to fit friction, got none")
    found = []
    for name in names:
        field, factor = (name, 1.0) if in_si else OF_ROTOR[name]
        guess = 0.0 if field == ANGLE else getattr(machine, field) / factor
        least = -math.inf if field == ANGLE else LEAST * guess if field in POSITIVE else 0.0
        found.append(Unknown(name, field, factor, guess, least))
    return found


def _unbalance_angle(machine: DimensionalRotor, records: list[Measured]) -> float:
    """Return a guess of the angle of the unbalance ahead of the mark; 0 if there is none.

    It is the angle by which the first measured whirls lead those of the guessed machine without
    contact, away from its critical speed.
    """
    lead = 0.0j
    for each in records:
        windows = each.tracks.windows
        whirl = fit_orders(each.record, windows, np.array([1.0, -1.0, 0.0])).amplitudes[:, 0]
        narrow = min(machine.clearance, float(np.abs(whirl).max()))
        wide = np.append(np.abs(whirl) > FREE * narrow, True)
        speeds = windows.speeds
        free = np.arange(speeds.size) < wide.argmax()
        free &= np.abs(speeds - machine.critical_speed) > RESONANT * machine.critical_speed
        expected = complex_amplitude(
            speeds, 0.5 * machine.damping / machine.mass, machine.shaft_stiffness / machine.mass
        )
        lead += complex((whirl * np.exp(-1j * np.angle(expected)))[free].sum())
    return float(np.angle(lead))


def _checked_orders(orders: npt.ArrayLike) -> Values:
    """Return the orders to compare, checked."""
    asked = check_vector("orders", orders, largest=LARGEST_ORDER)
    if (asked < 0.0).any() or not (asked > 0.0).any():
        raise InputError(
            f"orders must be 0 or positive, at least one positive, got {shown(asked.tolist())}"
        )
    if asked.size > MOST_ORDERS or np.unique(asked).size < asked.size:
        raise InputError(
            f"orders must be at most {MOST_ORDERS} different ones, got {shown(asked.tolist())}"
        )
    return asked


def _by_record(name: str, values: Any, count: int) -> list[Any]:
    """Return the value for each record, None where there is none; one record needs no list."""
    if values is None:
        return [None] * count
    held = _several(values)
    if count == 1 and not (held and len(held) == 1 and _several(held[0]) is not None):
        held = [values]
    if held is None or len(held) != count:
        raise InputError(
            f"{name} must be a list, one for each of {count} records, got {shown(values)}"
        )
    return [None if _several(each) == [] else each for each in held]


def _several(values: Any) -> list[Any] | None:
    """Return the items of a list, tuple or array; None for anything else."""
    if isinstance(values, list | tuple) or (isinstance(values, np.ndarray) and values.ndim > 0):
        return list(values)
    return None


def _starts(start: Any, records: list[Measured]) -> list[Values] | None:
    """Return the given initial states in SI units; None if none are given."""
    if start is None:
        return None
    rows = _by_record("start", start, len(records))
    scale = np.array([records[0].metre] * 2 + [records[0].metre / records[0].second] * 2)
    return [np.array(check_state("start", row)) * scale for row in rows]


def _checked_time_error(time_error: float | None, records: list[Measured]) -> float:
    """Return the standard error of contact times [s]; infinite if there are none."""
    touched = any(record.touches for record in records)
    if time_error is None:
        if touched:
            raise InputError("time_error must be given with entries or exits, got None")
        return math.inf
    if not touched:
        raise InputError("entries or exits must be given with time_error, got none of them")
    longest = max(float(record.times[-1]) for record in records) / records[0].second
    error = check_between("time_error", time_error, SHARPEST * longest, longest)
    return error * records[0].second


def _checked_noise(noise: float, records: list[Measured]) -> float:
    """Return the noise [m]."""
    size = max(float(np.abs(record.record.z).max()) for record in records) / records[0].metre
    return check_between("noise", noise, SHARPEST * size, size / SHARPEST) * records[0].metre


def _check_enough(problem: FitProblem) -> None:
    """Raise `InputError` if there are more unknowns than numbers to compare."""
    compared = _compared(problem)
    sought = problem.first().size
    if compared < sought:
        raise InputError(
            f"signals must give at least as many numbers to compare as unknowns, {sought}, got "
            f"{compared} in {sum(each.tracks.windows.times.size for each in problem.records)} "
            "windows"
        )


def _compared(problem: FitProblem) -> int:
    """Return how many numbers are compared, not counting contact times."""
    return sum(
        2 * each.tracks.orders.size * each.tracks.windows.times.size for each in problem.records
    )
