"""One simulated motion, and its invariants: a run that breaks one raises, never returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.interface import FAULTS, FIRST_OF_SAMPLES, OF_CONTACTS, PEAK_TIME
from rotor_ida.core.runs import fault_of
from rotor_ida.errors import InvariantError
from rotor_ida.model.parameters import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.spin import Course

ENTRY = 1
EXIT = -1
PRESS, RELEASE = 4, -4
ROLL, SLIP, REVERSE = 2, -2, 3
# How a rotor with friction moves.
FLIES, SLIDES_FORWARDS, SLIDES_BACKWARDS, ROLLS, IS_LOOSE = 0, 1, -1, 2, 3
OF_FRICTION = (ROLL, SLIP, REVERSE)
# How far, in tolerances a radian, the energy of a run whose speed changes may be out of balance.
UNBALANCED_BY = 1e2
# How far, in tolerances, a sample may lie on the wrong side of the ring.
WRONG_SIDE = 1e3


@dataclass(frozen=True, slots=True)
class Turning:
    """How the speed of a rotor changed during a run.

    Parameters
    ----------
    course : Course
        What changes it.
    samples : ndarray, shape (n, 2)
        Angle and speed at the sample times [1].
    events : ndarray, shape (m, 2)
        Angle and speed at the events [1].
    end : ndarray, shape (2,)
        Angle and speed at the end [1].
    energies : tuple of float, optional
        The energy at the start and at the end, and what the drive has given less what damping and
        contacts have taken, which is their difference [1]. The compiled core does not tell: it
        balances each contact itself.
    """

    course: Course
    samples: Values
    events: Values
    end: Values
    energies: tuple[float, float, float] | None


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
    turning : Turning, optional
        How the speed changed, if it did.
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
    turning: Turning | None = None

    @property
    def event_angles(self) -> Values:
        """The angle of the unbalance at each event [1]."""
        if self.turning is None:
            return self.rotor.omega * self.event_times
        return self.turning.events[:, 0]

    @property
    def event_speeds(self) -> Values | float:
        """The speed at each event, or at all of them [1]."""
        return self.rotor.omega if self.turning is None else self.turning.events[:, 1]

    @property
    def speeds(self) -> Values | float:
        """The speed at each sample, or at all of them [1]."""
        return self.rotor.omega if self.turning is None else self.turning.samples[:, 1]


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
    kept = slice(None) if orbit.turning is None else ~np.isin(orbit.event_kinds, OF_FRICTION)
    event_times, event_states = orbit.event_times[kept], orbit.event_states[kept]
    fault, row = fault_of(
        orbit.rotor,
        orbit.starts_in_contact,
        (orbit.times, orbit.states),
        (event_times, orbit.event_kinds[kept], event_states),
        orbit.contacts,
        allowed,
        orbit.ways if orbit.turning is None else None,
    )
    if fault:
        time, state = event_times, event_states
        if fault == OF_CONTACTS:
            time, state = orbit.contacts[:, PEAK_TIME], np.tile(orbit.end, (len(orbit.contacts), 1))
        elif fault >= FIRST_OF_SAMPLES:
            time, state = orbit.times, orbit.states
        x, y, vx, vy = state[row].tolist()
        raise InvariantError(FAULTS[fault], time=float(time[row]), state=(x, y, vx, vy))
    if orbit.turning is not None:
        _check_turning(orbit, orbit.turning, allowed)


def _check_turning(orbit: Orbit, turning: Turning, allowed: float) -> None:
    """Raise `InvariantError` where energy does not balance, or surfaces slide astray."""
    if turning.energies is not None:
        _check_energies(orbit, turning, turning.energies)
    if orbit.ways is None:
        return
    speed = np.hypot(orbit.states[:, 2], orbit.states[:, 3])
    rim = (orbit.rotor.disc_radius or 0.0) * turning.samples[:, 1]
    more = allowed * (1.0 + (speed + rim) / orbit.rotor.delta0)
    radius = np.maximum(np.hypot(orbit.states[:, 0], orbit.states[:, 1]), np.finfo(float).tiny)
    across = orbit.states[:, 0] * orbit.states[:, 3] - orbit.states[:, 1] * orbit.states[:, 2]
    slip = across / radius + rim
    ways = orbit.ways[np.searchsorted(orbit.event_times, orbit.times, side="right")]
    slides = np.isin(ways, (SLIDES_FORWARDS, SLIDES_BACKWARDS))
    astray = slides & (ways * slip < -more)
    for wrong, fault in ((astray, 8), ((ways == ROLLS) & (np.abs(slip) > more), 9)):
        if wrong.any():
            row = int(np.argmax(wrong))
            x, y, vx, vy = orbit.states[row].tolist()
            raise InvariantError(FAULTS[fault], time=float(orbit.times[row]), state=(x, y, vx, vy))


def _check_energies(orbit: Orbit, turning: Turning, energies: tuple[float, float, float]) -> None:
    """Raise `InvariantError` where energy does not balance."""
    x, y, vx, vy = orbit.end.tolist()
    begun, ended, gained = energies
    size = 1.0 + max(abs(begun), abs(ended), abs(gained))
    revolved = 1.0 + float(turning.end[0])
    most = UNBALANCED_BY * (orbit.options.rtol + orbit.options.atol) * size * revolved
    if not abs(ended - begun - gained) <= most:
        raise InvariantError(
            f"the energy does not balance: it changed by {ended - begun:.9g}, and "
            f"{gained:.9g} was given",
            time=orbit.duration,
            state=(x, y, vx, vy),
        )
