"""The state of a rotor system that begins a motion: as given, or where another result ends."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, canonical
from rotor_ida.model.axisymmetric import check_axisymmetric_parts, forward_motions
from rotor_ida.results.kinds import KINDS, kind_of
from rotor_ida.simulation.starts import IN_STEP
from rotor_ida.simulation.systems.starts import Start

# Kinds of results that end at any angle of the unbalance; other states have it at angle 0.
RUNS = ("system_run", "drop")


def state_at_end(assembly: Assembly, start: Start | xr.Dataset) -> Start:
    """Return a start as given, or displacement and velocity at the end of a result.

    A result ends at some angle of the unbalance. In an axisymmetric system the state is turned back
    by this angle; any other must end after whole revolutions, unless nothing is unbalanced.
    """
    if not isinstance(start, xr.Dataset):
        return start
    if "final_state" not in start or start["final_state"].ndim != 1:
        raise InputError(
            'start must be (q, velocity), "settled", "rest", or end as a run, a limit cycle or one '
            f"point of a sweep of a rotor system does, got: {KINDS[kind_of(start)].meaning}"
        )
    in_si = "t" in start and start["t"].attrs.get("units") == "s"
    if "t" in start and in_si != (assembly.system.units == "SI"):
        units = "SI units" if assembly.system.units == "SI" else "no units"
        raise InputError(f"start must have {units}, as the system has, got one in others")
    speeds = [each.speed for each in dict.fromkeys(assembly.races) if each is not None]
    values, size = np.asarray(start["final_state"].values, float), assembly.size
    if values.size != 2 * size + len(speeds) or not np.isfinite(values).all():
        raise InputError(
            f"start must end in {2 * size + len(speeds)} finite numbers, as this system has, got "
            f"{values.size}"
        )
    if not np.array_equal(values[2 * size :], speeds):
        raise InputError(
            "start must end with the races at their speeds at time 0, {speed}, got {value}: give "
            "these to each Race",
            name="speed", speed=speeds, value=values[2 * size :].tolist(),
        )  # fmt: skip
    motion = values[: 2 * size].reshape(2, size)
    moved = _turned_back(assembly, motion, _angle_at_end(start))
    return moved[0], moved[1]


def _angle_at_end(start: xr.Dataset) -> float:
    """Return the angle of the unbalance at the end of a result, less whole revolutions."""
    if "end_angle" in start:  # a run-up of many
        return math.remainder(float(start["end_angle"]), math.tau)
    if kind_of(start) not in RUNS:
        return 0.0
    phase = start.attrs.get("phase", 0.0)
    if "angle" not in start:
        return math.remainder(start.attrs["speed"] * start.attrs["duration"] + phase, math.tau)
    if float(start["t"][-1]) != start.attrs["duration"]:
        raise InputError(
            "start must have a sample at its end, {duration}, got the last at {time}",
            duration=float(start.attrs["duration"]), time=float(start["t"][-1]),
        )  # fmt: skip
    return math.remainder(float(start["angle"][-1]) + phase, math.tau)


def _turned_back(assembly: Assembly, motion: Values, angle: float) -> Values:
    """Return displacement and velocity turned back by an angle, shape (2, n)."""
    if abs(angle) <= IN_STEP or not assembly.unbalance.any():
        return motion
    try:
        check_axisymmetric_parts(assembly)
        shapes, found = forward_motions(assembly).basis, canonical(assembly)
    except InputError as error:
        raise InputError(
            "start must end after whole revolutions, as the system is not the same in all "
            f"directions, got the unbalance at {angle:.6g} rad"
        ) from error
    moved = np.array([found.to_y(each) for each in motion])
    turn = np.exp(-1j * angle) - 1.0
    return found.to_q(moved + 2.0 * ((turn * (moved @ shapes.conj())) @ shapes.T).real)
