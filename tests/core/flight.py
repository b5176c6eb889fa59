"""Flight in closed form by the core, its first touch, and whether a state begins in contact."""

from __future__ import annotations

from ctypes import byref

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.core.interface import RotorStruct, library, library_of, pointer
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.rotor import Rotor


def starts_in_contact(rotor: Rotor, state: npt.ArrayLike) -> bool:
    """Return whether a rotor at a state on the rotating axes begins in contact.

    On the stator the first nonzero one of radial velocity, acceleration and jerk decides.
    """
    given, held = _four_numbers(state), RotorStruct.of(rotor)
    return bool(library_of(rotor).core_starts_in_contact(byref(held), pointer(given, np.float64)))


def _four_numbers(state: npt.ArrayLike) -> Values:
    given = np.ascontiguousarray(state, dtype=np.float64)
    if given.shape != (4,):
        raise ValueError(f"a state must be four numbers, got {state!r}")
    return given


def fly(rotor: Rotor, states: npt.ArrayLike, spans: npt.ArrayLike) -> Values:
    """Return the states after flights without contact from given states, shape (n, 4) [1].

    They are given on the rotating axes at their times.
    """
    times = np.atleast_1d(np.asarray(spans, dtype=np.float64))
    begun = np.empty((times.size, 4))
    begun[:] = states
    times, reached = np.ascontiguousarray(times), np.empty((times.size, 4))
    held = RotorStruct.of(rotor)
    library_of(rotor).core_fly(
        byref(held),
        pointer(begun, np.float64),
        pointer(times, np.float64),
        pointer(reached, np.float64, writeable=True),
        times.size,
    )
    return reached


def first_touch(
    rotor: Rotor, state: npt.ArrayLike, limit: float, stop: Stop | None = None
) -> float:
    """Return the time to the first touch of the stator from a state in flight, or infinity [1].

    It is NaN if the search fails.
    """
    begun, given = pointer(_four_numbers(state), np.float64), RotorStruct.of(rotor)
    flag = pointer(NO_STOP if stop is None else stop, np.uint8)
    return float(library_of(rotor).core_first_touch(byref(given), begun, limit, flag))


def rotate(states: Values, times: Values, omega: float) -> None:
    """Rotate each row of ``(x, y, vx, vy)`` by the angle omega t, in place."""
    if states.shape != (times.size, 4):
        raise ValueError(f"a time must come with each state, got {states.shape} and {times.shape}")
    given = np.ascontiguousarray(times)
    into = pointer(states, np.float64, writeable=True)
    library().core_rotate(into, pointer(given, np.float64), omega, given.size)
