"""An orbit that contradicts the mechanics is refused, with the place; a sound one is not."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import InvariantError, Rotor
from rotor_ida.simulation.invariants import check_orbit
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run

DURATION = 30.0


@pytest.fixture(scope="module")
def sound() -> Orbit:
    rotor, times = Rotor(omega=2.0, zeta=0.07, delta0=2.0), np.linspace(0.0, DURATION, 61)
    return run(rotor, (0.0, 0.0, 0.0, 0.0), DURATION, times, Options())


def changed(orbit: Orbit, name: str, row, value) -> Orbit:
    """Return the orbit with another value in one of its tables."""
    table = getattr(orbit, name).copy()
    if name == "contacts":
        column, row = row
        table[column][row] = value(table[column][row])
    else:
        table[row] = value(table[row])
    return replace(orbit, **{name: table})


FAULTS = {
    "a sample is no number": ("states", (7, 1), lambda _: np.nan, "the state is not finite"),
    "a sample is endless": ("states", (7, 2), lambda _: np.inf, "the state is not finite"),
    "an event is no number": ("event_states", (2, 0), lambda _: np.nan, "not finite"),
    "events change places": ("event_times", [1, 2], lambda two: two[::-1], "do not increase"),
    "two entries in a row": ("event_kinds", 3, lambda kind: -kind, "do not alternate"),
    "an event off the ring": ("event_states", 2, lambda state: 1.001 * state, "not lie at |z|"),
    "a sample too far out": ("states", 0, lambda state: state + 2.1, "wrong side of the stator"),
    "a peak after its exit": (
        "contacts",
        ("peak_time", 1),
        lambda _: DURATION,
        "outside its own span",
    ),
}


def test_what_was_simulated_is_sound(sound):
    check_orbit(sound)
    assert sound.event_times.size >= 6


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found(sound, fault):
    name, row, value, message = FAULTS[fault]
    with pytest.raises(InvariantError) as refused:
        check_orbit(changed(sound, name, row, value))
    assert message in str(refused.value)


def test_a_sample_in_contact_that_lies_inside_the_clearance_is_a_fault(sound):
    entry, leaving = (sound.contacts[name][1] for name in ("entry", "exit"))
    row = int(np.searchsorted(sound.times, entry))
    assert entry < sound.times[row] < leaving
    with pytest.raises(
        InvariantError, match=f"wrong side of the stator .at t = {sound.times[row]:g},"
    ):
        check_orbit(changed(sound, "states", row, lambda state: 0.5 * state))
