"""One simulated motion, and its invariants: a run that breaks one raises, never returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.interface import FAULTS, FIRST_OF_SAMPLES, OF_CONTACTS, PEAK_TIME
from rotor_ida.core.runs import fault_of
from rotor_ida.errors import InvariantError
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options

ENTRY = 1
EXIT = -1
PRESS, RELEASE = 4, -4
ROLL, SLIP, REVERSE = 2, -2, 3
# How a rotor with friction moves.
FLIES, SLIDES_FORWARDS, SLIDES_BACKWARDS, ROLLS, IS_LOOSE = 0, 1, -1, 2, 3
# How far, in tolerances, a sample may lie on the wrong side of the ring.
WRONG_SIDE = 1e3


@dataclass(frozen=True, slots=True)
class Orbit:
    """One simulated motion: samples, contact events and contacts.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    options : Options
        How it was simulated.
    duration : float
        Time that it covers, from 0 [1].
    times : ndarray, shape (n,)
        Sample times [1].
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` at those times, fixed frame [1].
    starts_in_contact : bool
        Whether it starts in contact.
    event_times, event_kinds : ndarray, shape (m,)
        When contact begins (1) and ends (-1), and with contact damping when the surfaces in it
        come loose (-4) and press again (4), and with friction when the disc begins to roll (2) and
        to slip (-2), or slides the other way (3) [1].
    event_states : ndarray, shape (m, 4)
        ``(x, y, vx, vy)`` at the events, fixed frame [1].
    contacts : ndarray, shape (k, 9)
        Entry, exit and peak time, peak indentation, impulse, angular momentum at the peak, energy
        lost by contact damping, with that the largest force, and the heat of sliding, of each
        contact [1]; entry or exit, and the impulse, are NaN where the run began or ended inside the
        contact.
    end : ndarray, shape (4,)
        State at the end, fixed frame [1].
    evaluations : int
        Evaluations of the right-hand side.
    ways : ndarray, shape (m + 1,), optional
        With friction how the rotor moves from its start, and from each event on: in flight (0),
        sliding forwards (1) or backwards (-1), rolling (2) or loose (3).
    extrema : ndarray, shape (n, 7), optional
        Time, radius, kind (-1 or 1) and state on the rotating axes of each extremum of the radius
        [1], where they were asked for.
    """

    rotor: Rotor
    options: Options
    duration: float
    times: Values
    states: Values
    starts_in_contact: bool
    event_times: Values
    event_kinds: npt.NDArray[np.int8]
    event_states: Values
    contacts: Values
    end: Values
    evaluations: int
    ways: npt.NDArray[np.int8] | None = None
    extrema: Values | None = None


def stretches_of_rolling(orbit: Orbit) -> Values:
    """Return when the disc begins to roll on the ring, and no longer does, shape (n, 2) [1]."""
    if orbit.ways is None:
        return np.empty((0, 2))
    rolls = orbit.ways == ROLLS
    began = np.concatenate([[0.0], orbit.event_times])
    ended = np.concatenate([orbit.event_times, [orbit.duration]])
    return np.column_stack([began[rolls], ended[rolls]])


def check_orbit(orbit: Orbit) -> None:
    """Raise `InvariantError` at the first place where an orbit contradicts the mechanics."""
    options = orbit.options
    allowed = WRONG_SIDE * (options.rtol * orbit.rotor.delta0 + options.atol)
    fault, row = fault_of(
        orbit.rotor,
        orbit.starts_in_contact,
        (orbit.times, orbit.states),
        (orbit.event_times, orbit.event_kinds, orbit.event_states),
        orbit.contacts,
        allowed,
        orbit.ways,
    )
    if not fault:
        return
    time, state = orbit.event_times, orbit.event_states
    if fault == OF_CONTACTS:
        time, state = orbit.contacts[:, PEAK_TIME], np.tile(orbit.end, (len(orbit.contacts), 1))
    elif fault >= FIRST_OF_SAMPLES:
        time, state = orbit.times, orbit.states
    x, y, vx, vy = state[row].tolist()
    raise InvariantError(FAULTS[fault], time=float(time[row]), state=(x, y, vx, vy))
