"""A change of speed in SI units or revolutions, converted to dimensionless form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import (
    check_array,
    check_choice,
    check_nonnegative,
    check_positive,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.units import SPEED_UNITS, SpeedUnit

if TYPE_CHECKING:
    from rotor_ida.model.rotor import DimensionalRotor


class ChangeOfSpeed(TypedDict, total=False):
    """A change of speed, dimensionless: arguments of `rotor_ida.run_up`."""

    to: float
    rate: float
    ramp_time: float
    speeds: npt.NDArray[np.float64]
    torque: npt.NDArray[np.float64]
    inertia: float
    duration: float


def dimensionless_change(
    machine: DimensionalRotor,
    *,
    to: float | None,
    rate: float | None,
    ramp_time: float | None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None,
    torque: tuple[float, float] | npt.ArrayLike | None,
    inertia: float | None,
    duration: float | None,
    unit: SpeedUnit,
) -> ChangeOfSpeed:
    """Convert a change of speed of a machine, as `DimensionalRotor.change_of_speed` states it."""
    check_choice("unit", unit, tuple(SPEED_UNITS))
    a_second = SPEED_UNITS[unit]
    speed, time = a_second / machine.reference_frequency, machine.time_scale
    found: ChangeOfSpeed = {}
    if to is not None:
        found["to"] = check_nonnegative("to", to) * speed
    if rate is not None:
        found["rate"] = check_real("rate", rate) * speed * time
    if to is not None and (rate is not None or ramp_time is not None):
        now = machine.speed / a_second
        _check_way(now, to, to - now if rate is None else rate, unit)
    if ramp_time is not None:
        found["ramp_time"] = check_positive("ramp_time", ramp_time) / time
    if speeds is not None:
        table = check_array("speeds", speeds)
        if table.ndim != 2 or table.shape[1] != 2:
            raise InputError(f"speeds must be pairs of time and speed, got {shown(speeds)}")
        for each in table[:, 1].tolist():
            check_nonnegative("a speed of speeds", each)
        found["speeds"] = table * [1.0 / time, speed]
    if torque is not None:
        pair = check_array("torque", torque)
        if pair.shape != (2,):
            raise InputError(f"torque must be two numbers (stall, slope), got {shown(torque)}")
        found["torque"] = pair / machine.torque_scale * [1.0, machine.reference_frequency]
    if inertia is not None:
        found["inertia"] = check_positive("inertia", inertia) / machine.inertia_scale
    if duration is not None:
        found["duration"] = check_nonnegative("duration", duration) / time
    return found


def _check_way(speed: float, to: float, rate: float, unit: str) -> None:
    """Raise `InputError` for a rate that does not lead from `speed` to `to`, in their unit."""
    if rate == 0.0 or to == speed or (rate > 0.0) != (to > speed):
        way = "positive" if to > speed else "negative"
        wanted = f"rate must be {way} to change the speed from {speed:g} to {to:g} {unit}"
        if to == speed:
            wanted = f"to must differ from the speed of the machine, {speed:g} {unit}"
        raise InputError(f"{wanted}, got {to if to == speed else rate!r}")
