"""Checks of the arguments of a fit, and the problem that they define."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    STARTS,
    check_between,
    check_choice,
    check_state,
    check_vector,
    did_you_mean,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.fitting.motion import Body, Word
from rotor_ida.fitting.problem import FitProblem
from rotor_ida.fitting.records import Measured, measured, noise_of
from rotor_ida.fitting.trials import Beginning, Trials, Unknown, body_of
from rotor_ida.model.parameters import OF_MACHINE, OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.scales import unit_scale
from rotor_ida.model.system_parameters import FITTED_OF_SYSTEM, parameter_of
from rotor_ida.schema.flags import ENTRY, EXIT
from rotor_ida.signals.record import lacks_mark
from rotor_ida.signals.windows import fit_orders
from rotor_ida.simulation.starts import settled, start_of_system

AnyRotor: TypeAlias = Rotor | DimensionalRotor | RotorSystem
# Signals of one record: of one node, or of several by name.
Signals: TypeAlias = xr.Dataset | Mapping[str, xr.Dataset]
# Parameters of one disc that are measured, or are no numbers to fit; and their names in SI units.
FIXED = ("omega", "speed", "contact_exponent", "disc_radius")
ROLES = {"zeta": "damping", "delta0": "clearance"}
# Parameters that must be positive stay above this part of their first guess.
POSITIVE = (
    *(name for name, each in OF_MACHINE.items() if each.positive), "clearance", "unbalance",
    "stiffness",
)  # fmt: skip
LEAST = 1e-3
MOST_ORDERS, LARGEST_ORDER = 20, 20.0
# Whirls up to this part of the clearance are without contact; and at speeds where the phase of the
# guessed whirl changes by more than this [rad] within this part of the speed, it depends on the
# guess.
FREE, NEARBY, TURNED = 0.5, 0.25, 1.0
# Orders that are fitted together to find them.
WHIRL = np.array([1.0, -1.0, 0.0])
# A first state that no probe sees is unknown by this many of the largest displacements.
UNSEEN = 10.0
# Smallest errors allowed, relative to the length or size of the signals: rounding.
SHARPEST = 1e-12


def problem_of(
    signals: Signals | Sequence[Signals],
    machine: AnyRotor,
    unknown: Sequence[str],
    *,
    orders: npt.ArrayLike,
    revolutions: int | None,
    start: Any,
    entries: Any,
    exits: Any,
    time_error: float | None,
    noise: float | None,
) -> FitProblem:
    """Check all arguments and return the problem."""
    if not isinstance(machine, AnyRotor):
        raise InputError(
            f"machine must be a Rotor, a DimensionalRotor or a RotorSystem, got {shown(machine)}"
        )
    given = [signals] if isinstance(signals, xr.Dataset | Mapping) else _several(signals)
    if not given:
        raise InputError(f"signals must be a dataset, or a list of them, got {shown(signals)}")
    if not isinstance(machine, RotorSystem) and not _clearance_of(machine):
        raise InputError("machine must have a clearance above 0 for a fit, got 0.0")
    sought = _unknowns(unknown, machine)
    planes = [_by_node(each, machine) for each in given]
    if ANGLE not in [each.name for each in sought] and any(
        isinstance(each, xr.Dataset) and lacks_mark(each.attrs)
        for plane in planes for each in plane.values()
    ):  # fmt: skip
        raise InputError(
            f"unknown must include {ANGLE} when the angle is integrated from a speed or has no "
            f"mark among several pulses, as its origin is not known, got {shown(list(unknown))}"
        )
    tracked, body = _checked_orders(orders), body_of(machine, {})
    touches = {
        ENTRY: _by_record("entries", entries, len(given)),
        EXIT: _by_record("exits", exits, len(given)),
    }
    # without a load the mean position says nothing, and may be the gap of a DC-coupled probe
    loaded = bool(body.assembly.force.any()) or "load" in [each.name for each in sought]
    records = [
        measured(
            each, tracked, revolutions, {kind: times[n] for kind, times in touches.items()},
            in_si=_is_in_si(machine), with_mean=0.0 in tracked or loaded,
        )
        for n, each in enumerate(planes)
    ]  # fmt: skip
    sought = [_with_size(each, machine, records) for each in sought]
    trials = Trials(machine, sought, records, _starts(start, records, body, machine))
    noise = noise_of(records) if noise is None else _checked_noise(noise, records)
    _check_enough(trials)
    return FitProblem(trials, noise, _checked_time_error(time_error, records))


def _clearance_of(machine: Rotor | DimensionalRotor) -> float:
    return machine.clearance if isinstance(machine, DimensionalRotor) else machine.delta0


def _is_in_si(machine: AnyRotor) -> bool:
    return machine.units == "SI" if isinstance(machine, RotorSystem) else (
        isinstance(machine, DimensionalRotor)
    )  # fmt: skip


def _by_node(signals: Any, machine: AnyRotor) -> dict[str, xr.Dataset]:
    """Return the signals of a record by the nodes of the system that they are of."""
    if not isinstance(machine, RotorSystem):
        if isinstance(signals, Mapping) and not isinstance(signals, xr.Dataset):
            raise InputError(
                f"signals must be a dataset, or a list of them, with one disc, got {shown(signals)}"
            )
        return {"disc": signals}
    if isinstance(signals, Mapping) and not isinstance(signals, xr.Dataset):
        found = dict(signals)
    elif isinstance(signals, xr.Dataset) and "node" in signals.coords and not signals["node"].ndim:
        found = {str(signals["node"].values): signals}
    else:
        found = dict.fromkeys(machine.nodes, signals) if len(machine.nodes) == 1 else {}
    if not found:
        nodes = ", ".join(map(repr, machine.nodes))
        raise InputError(
            f"signals must be given by the node at which probes look, {{node: signals}}, of {nodes}"
            ", got none"
        )
    for node in found:
        machine.rows(node)  # raises if it is unknown
    return found


def _unknowns(unknown: object, machine: AnyRotor) -> list[Unknown]:
    """Return the unknowns, checked."""
    units = _units_of(machine)
    names, known = _several(unknown), ", ".join(map(shown, units))
    if names is None:
        raise InputError(f"unknown must be a list of names from {known}, got {shown(unknown)}")
    wrong = [each for each in names if not isinstance(each, str) or each not in units]
    if wrong or not names:
        meant = did_you_mean(wrong[0], units) if wrong else ""
        raise InputError(
            f"unknown must be of {known}, got {shown(wrong[0] if wrong else names)}{meant}"
        )
    if len(set(names)) < len(names):
        raise InputError(f"unknown must name each once, got {shown(names)}")
    if "friction" in names and not isinstance(machine, RotorSystem) and not machine.disc_radius:
        raise InputError("machine must have a disc_radius to fit friction, got none")
    found = []
    for name in names:
        role = ROLES.get(name, name)
        guess = _guess_of(machine, name)
        least = -math.inf if name == ANGLE else LEAST * guess if role in POSITIVE else 0.0
        found.append(Unknown(name, role, units[name], guess, least, 1.0))
    return found


def _units_of(machine: AnyRotor) -> dict[str, str]:
    """Return the parameters of a rotor that can be fitted, with their units."""
    if isinstance(machine, RotorSystem):
        known = {name: each.unit for name, each in FITTED_OF_SYSTEM.items()}
        exponents = {each.exponent for each in machine.contacts}
    else:
        table = OF_MACHINE if isinstance(machine, DimensionalRotor) else OF_ROTOR
        known = {name: each.unit for name, each in table.items() if name not in FIXED}
        exponents = {machine.contact_exponent}
    if not _is_in_si(machine):
        known = dict.fromkeys(known, "1")
    linear = exponents == {1.0}
    units = {name: unit.replace("m-1.5", "m-1") if linear else unit for name, unit in known.items()}
    return units | {ANGLE: "radian"}


def _guess_of(machine: AnyRotor, name: str) -> float:
    """Return the first guess of a parameter."""
    if name == ANGLE:
        return 0.0
    if isinstance(machine, RotorSystem):
        return parameter_of(machine, name)
    return float(getattr(machine, name))


def _with_size(unknown: Unknown, machine: AnyRotor, records: list[Measured]) -> Unknown:
    """Return an unknown with its size, and the angle with its guess."""
    if unknown.name == ANGLE:
        return replace(unknown, guess=_unbalance_angle(machine, records))
    if unknown.role in POSITIVE and unknown.guess > 0.0:
        return replace(unknown, size=unknown.guess)
    if isinstance(machine, DimensionalRotor):
        return replace(unknown, size=unit_scale(machine, unknown.unit))
    if isinstance(machine, Rotor):
        return unknown
    size = max(each.largest for each in records)
    speed = max(float(each.turning.speeds.max()) for each in records)
    sizes = {"unbalance": float(machine.mass.max()) * size, "contact_damping": 1.0 / (size * speed)}
    return replace(unknown, size=sizes.get(unknown.name, 1.0))


def _unbalance_angle(machine: AnyRotor, records: list[Measured]) -> float:
    """Return a guess of the angle of the unbalance ahead of the mark; 0 if there is none.

    It is the angle by which the first measured whirls lead those of the guessed machine without
    contact, away from its critical speeds.
    """
    body, lead = body_of(machine, {}), 0.0j
    clearance = min((each.clearance for each in body.assembly.contacts), default=math.inf)
    for each in records:
        windows, speeds = each.tracks.windows, each.tracks.windows.speeds
        whirls = np.stack(
            [fit_orders(replace(each.record, z=z), windows, WHIRL).amplitudes[:, 0]
             for z in each.z.T], axis=1,
        )  # fmt: skip
        sizes = np.abs(whirls).max(axis=1)
        wide = np.append(sizes > FREE * min(clearance, float(sizes.max())), True)
        free = (np.arange(speeds.size) < wide.argmax())[:, None]
        slower, expected, faster = (
            body.free_whirls(each.nodes, part * speeds)[0] for part in (1 - NEARBY, 1, 1 + NEARBY)
        )
        free = free & (np.abs(np.angle(faster / slower)) < TURNED)
        lead += complex((whirls * np.exp(-1j * np.angle(expected)))[free].sum())
    return float(np.angle(lead))


def _checked_orders(orders: npt.ArrayLike) -> Values:
    """Return the orders to compare, checked."""
    asked = check_vector("orders", orders, largest=LARGEST_ORDER)
    if (asked < 0.0).any() or not asked.any():
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


def _starts(
    start: Any, records: list[Measured], body: Body, machine: AnyRotor
) -> list[Beginning | Values | Word]:
    """Return what is known of the first state of each record; see `Trials`."""
    if start is None:
        return [_beginning(each, body) for each in records]
    if isinstance(start, str):
        return [cast("Word", check_choice("start", start, STARTS))] * len(records)
    rows = _by_record("start", start, len(records))
    if isinstance(machine, RotorSystem):
        return [start_of_system(body.assembly, row, 0.0) for row in rows]
    scale = np.repeat([records[0].metre, records[0].metre / records[0].second], 2)
    return [(np.array(check_state("start", row)) * scale).reshape(2, 2) for row in rows]


def _beginning(record: Measured, body: Body) -> Beginning:
    """Return the first state by the first samples of a record, in q.

    What no probe sees is the static deflection, with an error of many times the largest
    displacement, the same in all coordinates with a unit mass matrix.
    """
    found, size = body.found, body.assembly.size
    rows = found.rows_in_y(body.rows(record.nodes)).reshape(-1, size)
    seen = np.kron(np.eye(2), rows)
    values = np.moveaxis(record.start.reshape(2, 2, -1), 2, 1).ravel()
    spread = np.moveaxis(record.spread.reshape(2, 2, -1), 2, 1).ravel()
    speed = float(record.turning.speeds[0])
    unseen = UNSEEN * record.largest / float(np.linalg.norm(rows, axis=1).max())
    known = np.repeat([1.0 / unseen, 1.0 / (unseen * speed)], size)
    design = np.concatenate([np.diag(known), seen / spread[:, None]])
    try:
        still = found.to_y(settled(body.assembly, 0.0)[0])
    except InputError:  # it lies on a stator
        still = np.zeros(size)
    told = np.concatenate([known * np.append(still, np.zeros(size)), values / spread])
    basis, root = np.linalg.qr(design)
    mean, errors = np.linalg.solve(root, basis.T @ told), np.linalg.inv(root)

    def in_q(values: Values) -> Values:
        return found.to_q(values.reshape(-1, 2, size)).reshape(-1, 2 * size)

    return Beginning(in_q(mean)[0], in_q(np.ascontiguousarray(errors.T)).T)


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
    size = max(record.largest for record in records) / records[0].metre
    return check_between("noise", noise, SHARPEST * size, size / SHARPEST) * records[0].metre


def _check_enough(trials: Trials) -> None:
    """Raise `InputError` if there are more unknowns than numbers to compare."""
    compared = sum(each.tracked for each in trials.records)
    sought = len(trials.unknown) + sum(
        4 * len(each.nodes) for each, start in zip(trials.records, trials.starts, strict=True)
        if isinstance(start, Beginning)
    )  # fmt: skip
    if compared < sought:
        raise InputError(
            f"signals must give at least as many numbers to compare as unknowns, {sought}, got "
            f"{compared} in {sum(each.tracks.windows.times.size for each in trials.records)} "
            "windows"
        )
