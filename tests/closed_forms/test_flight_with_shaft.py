"""Flight with a shaft and a load against its textbook form in 250 digits, and an integrator."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.closed_forms import flight
from tests.textbook_flight import CASES, DIGITS, Exact

START = (0.3, -0.2, -0.4, 0.7)
SPANS = np.array([0.0, 1e-6, 0.013, 0.7, 2.3, 19.0, 300.0])


def machine(omega, zeta, kappa, load=0.8, delta0=1.0):
    return Rotor(omega=omega, zeta=zeta, delta0=delta0, shaft_stiffness=kappa, load=load)


def worst(rotor, start, spans, start_time=0.0):
    """Return the largest error, of what displacement and velocity come to about then."""
    times = start_time + spans
    x, y, vx, vy = flight(times, rotor=rotor, start=start, start_time=start_time)
    exact = Exact(rotor, complex(*start[:2]), complex(*start[2:]), since=start_time)
    with mpmath.workdps(DIGITS):
        elapsed = [mpmath.mpf(float(time)) - mpmath.mpf(start_time) for time in times]
    found = zip(x + 1j * y, vx + 1j * vy, elapsed, strict=True)
    return max(error for *pair, tau in found for error in exact.missed_by(pair, tau))


@pytest.mark.parametrize("kind", CASES)
@pytest.mark.parametrize("given", ["all", "unbalance", "load"])
def test_flight_holds_to_rounding(kind, given):
    """Also what unbalance or load alone begin, from rest: no part hides in a larger one."""
    start = START if given == "all" else (0.0,) * 4
    seen = 0
    for omega, zeta, kappa in CASES[kind]:
        load = 0.0 if given == "unbalance" else 0.8
        if kappa == load == 0.0 or (omega == 0.0 and given == "unbalance"):
            continue  # as of the paper's rotor, or nothing happens
        rotor = machine(0.0 if given == "load" else omega, zeta, kappa, load)
        assert worst(rotor, start, SPANS) < 3e-15, rotor
        seen += 1
    assert seen > 8


@pytest.mark.parametrize(
    ("omega", "zeta", "kappa"),
    [(1.7, 0.0, 0.3), (1.7, 1e-9, 1.7**2), (0.0, 0.0, 2.0), (3.0, 0.0, 0.0), (2.5, 0.5, 6.3)],
)
def test_late_times_lose_nothing(omega, zeta, kappa):
    """Angles have 32 digits, also of a vibration that never dies."""
    rotor, spans = machine(omega, zeta, kappa), np.array([1e3, 1e6, 1e9])
    assert worst(rotor, START, spans, start_time=123.456) < 3e-15


def test_a_rotor_that_does_not_touch_is_simulated_as_it_flies():
    rotor = machine(1.7, 0.1, 0.6, delta0=50.0)
    run = simulate(rotor, start=START, duration=60.0, samples=31, method="taylor")
    assert not run.event_time.size
    found = flight(run.t.values, rotor=rotor, start=START)
    for name, values in zip(("x", "y", "vx", "vy"), found, strict=True):
        np.testing.assert_allclose(run[name].values, values, rtol=0, atol=2e-13)


def test_what_concerns_the_contact_alone_does_not_change_a_flight():
    plain = Rotor(omega=1.7, zeta=0.1, delta0=1.0)
    damped = Rotor(omega=1.7, zeta=0.1, delta0=1.0, contact_exponent=1.0, contact_damping=3.0)
    np.testing.assert_array_equal(
        flight(SPANS, rotor=damped, start=START), flight(SPANS, rotor=plain, start=START)
    )


def test_times_may_have_any_shape():
    rotor = machine(1.7, 0.1, 0.6)
    table = flight(SPANS[1:].reshape(2, 3), rotor=rotor, start=START)
    assert table.shape == (4, 2, 3)
    single = flight(0.7, rotor=rotor, start=START)
    assert single.shape == (4,)
    np.testing.assert_array_equal(single, table.reshape(4, 6)[:, 2])
    assert flight([], rotor=rotor, start=START).shape == (4, 0)


@pytest.mark.parametrize(
    ("rotor", "time", "message"),
    [
        (machine(0.0, 0.1, 4.0), 1e15, r"sqrt\(shaft_stiffness\) \* time must be at most 1e\+15"),
        (machine(0.0, 0.1, 1e300), 1.0, r"shaft_stiffness must be at most 1e\+15"),
        (machine(0.0, 0.1, 1.0, load=1e300), 1.0, r"load must be at most 1e\+15"),
    ],
)
def test_impossible_flights_are_refused(rotor, time, message):
    with pytest.raises(InputError, match=message):
        flight(time, rotor=rotor, start=START)
