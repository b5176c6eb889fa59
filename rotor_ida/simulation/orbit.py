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
SOUND, NOT_FINITE, BACKWARDS, NOT_IN_TURN, OFF_THE_RING, WRONG_SIDE_OF_THE_RING, PEAKS_OUTSIDE = (
    range(7)
)
FAULTS = {
    NOT_FINITE: "the state is not finite",
    BACKWARDS: "event times do not increase",
    NOT_IN_TURN: "entry and exit do not alternate",
    OFF_THE_RING: "an event does not lie at |z| = delta0",
    WRONG_SIDE_OF_THE_RING: "a sample lies on the wrong side of the ring",
    PEAKS_OUTSIDE: "a contact peaks outside its own span",
}


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
    delta0, options = orbit.rotor.delta0, orbit.options
    allowed = WRONG_SIDE * (options.rtol * delta0 + options.atol)
    inside = orbit.starts_in_contact
    times, states = orbit.event_times, orbit.event_states
    fault, row = _fault_of_events(times, orbit.event_kinds, states, inside, delta0)
    if fault == SOUND:
        times, states = orbit.times, orbit.states
        fault, row = _fault_of_samples(times, states, orbit.event_times, inside, delta0, allowed)
    if fault == SOUND and delta0 > 0.0:
        times, states = orbit.contacts[:, 2], np.tile(orbit.end, (orbit.contacts.shape[0], 1))
        fault, row = _fault_of_contacts(orbit.contacts)
    if fault != SOUND:
        state = tuple(states[row].tolist())
        raise InvariantError(FAULTS[fault], time=float(times[row]), state=state)


def _fault_of_events(
    times: Values, kinds: npt.NDArray[np.int8], states: Values, inside: bool, delta0: float
) -> tuple[int, int]:
    """Return the first fault of an event, and its number."""
    expected = np.where(np.arange(times.size) % 2, ENTRY, -ENTRY) * (1 if inside else -1)
    radii = np.sqrt(states[:, 0] ** 2 + states[:, 1] ** 2)
    return _first_fault(
        {
            NOT_FINITE: ~np.isfinite(states.sum(axis=1)),
            BACKWARDS: np.diff(times, prepend=-np.inf) <= 0.0,
            NOT_IN_TURN: kinds != expected,
            OFF_THE_RING: np.abs(radii - delta0) > ON_THE_RING * delta0,
        }
    )


def _fault_of_samples(
    times: Values, states: Values, event_times: Values, inside: bool, delta0: float, allowed: float
) -> tuple[int, int]:
    """Return the first fault of a sample, and its number.

    Between an entry and its exit |z| is at least delta0, elsewhere at most.
    """
    faults = {} if np.isfinite(states).all() else {NOT_FINITE: ~np.isfinite(states.sum(axis=1))}
    if delta0 > 0.0:
        begun = np.searchsorted(times, event_times)
        in_turn = (np.arange(event_times.size + 1) + inside) % 2 == 1
        touching = np.repeat(in_turn, np.diff(begun, prepend=0, append=times.size))
        x, y = states[:, 0], states[:, 1]
        depth = np.sqrt(x * x + y * y) - delta0
        faults[WRONG_SIDE_OF_THE_RING] = np.where(touching, -depth, depth) > allowed
    return _first_fault(faults)


def _fault_of_contacts(contacts: Values) -> tuple[int, int]:
    """Return the first fault of a contact, and its number."""
    entry, leaving, peak = contacts[:, :3].T
    return _first_fault({PEAKS_OUTSIDE: (peak < entry) | (peak > leaving)})


def _first_fault(faults: dict[int, npt.NDArray[np.bool_]]) -> tuple[int, int]:
    """Return the kind and the place of the first fault."""
    places = {kind: int(np.argmax(there)) for kind, there in faults.items() if there.any()}
    if not places:
        return SOUND, 0
    kind = min(places, key=places.__getitem__)
    return kind, places[kind]
