"""One simulated motion, and its invariants: a run that breaks one raises, never returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.errors import InvariantError
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options

Values = npt.NDArray[np.float64]

ENTRY = 1
EXIT = -1
# Radius at an event against delta0: the state is put there, so only rounding may remain.
ON_THE_RING = 8.0 * 2.0**-52
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
        When contact begins (1) and ends (-1) [1].
    event_states : ndarray, shape (m, 4)
        ``(x, y, vx, vy)`` at the events, fixed frame [1].
    contacts : ndarray, shape (k, 6)
        Entry, exit and peak time, peak indentation, impulse, and angular momentum at the peak
        of each contact [1]; entry or exit, and the impulse, are NaN where the run began or
        ended inside the contact.
    end : ndarray, shape (4,)
        State at the end, fixed frame [1].
    evaluations : int
        Evaluations of the right-hand side.
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


def check_orbit(orbit: Orbit) -> None:
    """Raise `InvariantError` at the first place where an orbit contradicts the mechanics."""
    _check_finite(orbit)
    if orbit.rotor.delta0 == 0.0:
        return
    _check_events(orbit)
    _check_sides(orbit)
    _check_contacts(orbit)


def _check_finite(orbit: Orbit) -> None:
    for times, states in ((orbit.times, orbit.states), (orbit.event_times, orbit.event_states)):
        wrong = np.asarray(~np.isfinite(states).all(axis=1))
        if wrong.any():
            _fail("the state is not finite", wrong, times, states)


def _check_events(orbit: Orbit) -> None:
    times, kinds, states = orbit.event_times, orbit.event_kinds, orbit.event_states
    backwards = np.asarray(np.diff(times, prepend=-np.inf) <= 0.0)
    if backwards.any():
        _fail("event times do not increase", backwards, times, states)
    expected = np.where(np.arange(kinds.size) % 2 == orbit.starts_in_contact, ENTRY, -ENTRY)
    if (kinds != expected).any():
        _fail("entry and exit do not alternate", kinds != expected, times, states)
    radius = np.hypot(states[:, 0], states[:, 1])
    off = np.abs(radius - orbit.rotor.delta0) > ON_THE_RING * orbit.rotor.delta0
    if off.any():
        _fail("an event does not lie at |z| = delta0", off, times, states)


def _check_sides(orbit: Orbit) -> None:
    """Between an entry and its exit |z| >= delta0 at every sample; elsewhere |z| <= delta0."""
    delta0, options = orbit.rotor.delta0, orbit.options
    passed = np.searchsorted(orbit.event_times, orbit.times, side="right")
    in_contact = (passed % 2 == 1) != orbit.starts_in_contact
    depth = np.hypot(orbit.states[:, 0], orbit.states[:, 1]) - delta0
    allowed = WRONG_SIDE * (options.rtol * delta0 + options.atol)
    wrong = np.where(in_contact, depth < -allowed, depth > allowed)
    if wrong.any():
        _fail("a sample lies on the wrong side of the ring", wrong, orbit.times, orbit.states)


def _check_contacts(orbit: Orbit) -> None:
    entry, leaving, peak_time = orbit.contacts.T[:3]
    wrong = (peak_time < entry) | (peak_time > leaving)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InvariantError(
            "a contact peaks outside its own span",
            time=float(peak_time[row]),
            state=tuple(orbit.end.tolist()),
        )


def _fail(message: str, wrong: npt.NDArray[np.bool_], times: Values, states: Values) -> None:
    place = int(np.argmax(wrong))
    raise InvariantError(message, time=float(times[place]), state=tuple(states[place].tolist()))
