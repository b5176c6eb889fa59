import math

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, poincare_section, simulate, synchronous_response
from rotor_ida.equations.model import rotated

REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
FULL_CONTACT = Rotor(omega=3.0, zeta=0.07, delta0=0.5)


def states(section):
    return np.stack([section[f"rotating_{name}"] for name in ("x", "y", "vx", "vy")], axis=-1)


def test_a_synchronous_whirl_crosses_once_a_revolution_at_one_point():
    rotor = Rotor(omega=1.2, zeta=0.5, delta0=0.5)
    section = poincare_section(rotor, start=REST, revolutions=5, skip=20)
    whirl = synchronous_response(omega=1.2, zeta=0.5, delta0=0.5).isel(branch=0).squeeze()
    point = whirl.amplitude.item() * np.exp(-1j * whirl.phase_lag.item())
    np.testing.assert_allclose(section.rotating_x + 1j * section.rotating_y, point, atol=1e-8)
    period = 2.0 * math.pi / 1.2
    np.testing.assert_allclose(section.crossing_time, period * np.arange(20, 26), rtol=1e-14)


def test_skipping_changes_neither_times_nor_states():
    """Up to the error of the motion itself, which here neither grows nor dies."""
    for at in ("revolution", "entry", "peak"):
        long = poincare_section(BOUNCING, start=REST, revolutions=30, at=at)
        late = poincare_section(BOUNCING, start=REST, revolutions=20, skip=10, at=at)
        last = late.sizes["crossing"]
        np.testing.assert_allclose(late.crossing_time, long.crossing_time[-last:], atol=1e-7)
        np.testing.assert_allclose(states(late), states(long)[-last:], atol=1e-7)


def test_entries_and_exits_are_the_events_of_the_simulation():
    duration = 2.0 * math.pi / 2.0 * 20
    run = simulate(BOUNCING, start=REST, duration=duration, samples=2)
    for at, kind, sign in (("entry", 1, 1.0), ("exit", -1, -1.0)):
        section = poincare_section(BOUNCING, start=REST, revolutions=20, at=at)
        chosen = run.event_kind.values == kind
        np.testing.assert_allclose(section.crossing_time, run.event_time[chosen], atol=1e-9)
        fixed = rotated(states(section), 2.0 * section.crossing_time.values)
        np.testing.assert_allclose(fixed[:, 0], run.event_x[chosen], atol=1e-9)
        x, y, vx, vy = states(section).T
        np.testing.assert_allclose(np.hypot(x, y), 2.0, rtol=1e-14)
        assert (sign * (x * vx + y * vy) > 0.0).all()


def test_a_limit_cycle_is_a_curve_by_revolutions_and_one_point_by_entries():
    by_revolution = poincare_section(BOUNCING, start=REST, revolutions=40, skip=120)
    assert np.ptp(by_revolution.rotating_x.values) > 3.0
    by_entry = poincare_section(BOUNCING, start=REST, revolutions=40, skip=120, at="entry")
    assert by_entry.sizes["crossing"] > 20
    assert np.ptp(states(by_entry), axis=0).max() < 1e-7


def test_full_contact_has_no_entries_but_two_peaks_a_cycle():
    entries = poincare_section(FULL_CONTACT, start=REST, revolutions=40, skip=120, at="entry")
    assert entries.sizes["crossing"] == 0
    peaks = poincare_section(FULL_CONTACT, start=REST, revolutions=40, skip=200, at="peak")
    x, y, vx, vy = states(peaks).T
    assert np.abs(x * vx + y * vy).max() < 1e-6
    radius = np.hypot(x, y)
    assert np.ptp(radius[::2]) < 1e-8
    assert np.ptp(radius[1::2]) < 1e-8
    assert abs(radius[1] - radius[0]) > 0.5


@pytest.mark.parametrize(
    ("rotor", "wrong", "message"),
    [
        (Rotor(omega=0.0, zeta=0.1, delta0=1.0), {}, "omega must be positive for a section"),
        (Rotor(omega=1.0, zeta=0.1, delta0=0.0), {"at": "entry"}, "delta0 must be positive"),
        (BOUNCING, {"at": "apex"}, "at must be one of 'revolution', 'entry', 'exit', 'peak'"),
        (BOUNCING, {"revolutions": 0}, "revolutions must be at least 1, got 0"),
        (BOUNCING, {"skip": -1}, "skip must be at least 0, got -1"),
    ],
)
def test_bad_input_is_refused(rotor, wrong, message):
    with pytest.raises(InputError, match=message):
        poincare_section(rotor, **{"start": REST, "revolutions": 2, **wrong})
