"""Flight in closed form, with shaft and load or plain: exact, and no touch or extremum is missed.

The witness is the textbook's form in 250 digits.
"""

from __future__ import annotations

import cmath
import math

import mpmath
import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core import runs
from rotor_ida.model.equations import rotated
from rotor_ida.simulation.spin import Steady
from rotor_ida.simulation.witness.bodies import Disc
from tests.core import flight
from tests.textbook_flight import CASES, Exact

NEVER = math.inf
SPANS = (1e-6, 0.013, 0.7, 2.3, 19.0, 300.0)
HOW = {"rtol": 1e-12, "atol": 1e-14}


def sprung(omega, zeta, kappa, load=0.0, delta0=1.0):
    """Return a rotor on a shaft that flies as without the damping; without one that of the paper.

    With contact damping it is no rotor of the paper, even where shaft and load vanish.
    """
    if kappa is None:
        return Rotor(omega=omega, zeta=zeta, delta0=delta0)
    return Rotor(omega=omega, zeta=zeta, shaft_stiffness=kappa, load=load, delta0=delta0,
                 contact_damping=0.1)  # fmt: skip


def row(z, w):
    return (z.real, z.imag, w.real, w.imag)


def errors(rotor, z0, w0, tau):
    """Return the errors of displacement and velocity, of what they come to about then."""
    x, y, vx, vy = flight.fly(rotor, row(z0, w0), tau)[0].tolist()
    with mpmath.workdps(60):
        turn = mpmath.expj(mpmath.mpf(rotor.omega) * mpmath.mpf(tau))
        found = complex(x, y) * turn, complex(vx, vy) * turn
    return Exact(rotor, z0, w0).missed_by(found, tau)


def plain():
    yield from (
        (omega, zeta, None)
        for omega in (0.0, 1e-9, 0.6, 8.0)
        for zeta in (0.0, 1e-300, 1e-12, 1e-8, 0.07, 2.0)
    )


def generic():
    yield from np.exp(np.random.default_rng(5).uniform(np.log(1e-3), np.log(8.0), (12, 3))).tolist()


@pytest.mark.parametrize("kind", [*CASES, "generic"])
@pytest.mark.parametrize("given", ["all", "unbalance", "load"])
def test_flight_is_exact_to_rounding(kind, given):
    """Also what unbalance or load alone begin, from rest: no part hides in a larger one."""
    check_exact(CASES.get(kind) or generic(), given)


def test_flight_without_shaft_and_load_is_exact_to_rounding():
    check_exact(plain(), "velocity")


def check_exact(cases, given):
    z0, w0 = (0.3 - 0.2j, -0.4 + 0.7j) if given in {"all", "velocity"} else (0j, 0j)
    seen = 0
    for omega, zeta, kappa in cases:
        load = 0.0 if given in {"unbalance", "velocity"} else 0.8
        rotor = sprung(0.0 if given == "load" else omega, zeta, kappa, load)
        for tau in SPANS:
            most = 4e-15 * (1.0 + max(omega, math.sqrt(kappa or 0.0)) * tau)
            for error in errors(rotor, z0, w0, tau):
                assert error < most, (rotor, tau)
                seen += 1
    assert seen > 90


@pytest.mark.parametrize("tau", [2e3, 1e5])
def test_a_long_flight_comes_to_its_whirl(tau):
    """Nothing overflows where the free vibration has died away."""
    for omega, zeta, kappa in ((2.5, 0.5, 9.0), (2.5, 0.5, 6.3), (0.3, 4.0, 2.0)):
        rotor = sprung(omega, zeta, kappa, 0.4)
        whirl = omega**2 / complex(kappa - omega**2, 2.0 * zeta * omega)
        rest = -0.4j / kappa * np.exp(-1j * omega * tau)
        x, y, vx, vy = flight.fly(rotor, (0.3, 0.1, 0.5, -2.0), tau)[0]
        assert complex(x, y) == pytest.approx(whirl + rest, abs=1e-11)
        assert complex(vx, vy) == pytest.approx(1j * omega * whirl, abs=1e-11)


SHAFTS = pytest.mark.parametrize("has_shaft", [True, False])


def random_flight(rng, place, has_shaft):
    """Return a machine of one of several kinds without its clearance, and a start."""
    omega, zeta = rng.uniform(0.1, 4.0), float(rng.choice([0.0, 1e-8, 0.07, 0.5]))
    kappa = (0.0, float(rng.uniform(0.0, 9.0)), omega**2, zeta**2, 1e-9)[place % 5]
    load = float(rng.choice([0.0, rng.uniform(0.0, 2.0)]))
    if not has_shaft:
        kappa, load = None, 0.0
    z0, w0 = (complex(*rng.normal(scale=0.5, size=2)) for _ in range(2))
    return (omega, zeta, kappa, load), z0, w0


@SHAFTS
def test_the_first_touch_is_the_first_of_a_fine_search(has_shaft):
    """Between two looks hides but a graze; these are held below."""
    rng = np.random.default_rng(3)
    times = np.linspace(0.0, 20.0, 80_001)
    touched = missed = 0
    for place in range(60):
        parameters, z0, w0 = random_flight(rng, place, has_shaft)
        rotor = sprung(*parameters, delta0=abs(z0) * rng.uniform(1.01, 6.0))
        x, y, *_ = flight.fly(rotor, row(z0, w0), times).T
        outside = np.hypot(x, y) > rotor.delta0
        found = flight.first_touch(rotor, row(z0, w0), 20.0)
        if not outside.any():
            assert found == NEVER
            missed += 1
            continue
        touched += 1
        last = int(outside.argmax())
        assert times[last - 1] <= found <= times[last]
        x, y, *_ = flight.fly(rotor, row(z0, w0), found)[0]
        assert math.hypot(x, y) == pytest.approx(rotor.delta0, rel=1e-14)
    assert touched > 30
    assert missed > (5 if has_shaft else 1)


def graze(rng, place, has_shaft, penetration):
    """Return a flight whose |z| peaks at delta0 + penetration, from an inner point, and when."""
    parameters, z0, w0 = random_flight(rng, place, has_shaft)
    times = np.linspace(0.0, 12.0, 4001)
    x, y, *_ = flight.fly(sprung(*parameters), row(z0, w0), times).T
    radius = np.hypot(x, y)
    peak = next((k for k in range(1, 4000) if radius[k - 1] < radius[k] > radius[k + 1]), None)
    if peak is None or radius[peak] <= max(radius[: peak - 1]) or radius[peak] < 0.2:
        return None
    exact = Exact(sprung(*parameters), z0, w0)
    with mpmath.workdps(30):
        ends = (mpmath.mpf(times[peak - 1]), mpmath.mpf(times[peak + 1]))
        summit = mpmath.findroot(exact.slope, ends, solver="anderson")
    return parameters, z0, w0, float(summit), float(abs(exact(summit)[0])) - penetration


@SHAFTS
@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-9, 1e-12])
def test_no_graze_is_missed_and_none_invented(size, has_shaft):
    """Each peak found in 30 digits; the ring is put just inside it, then just outside."""
    rng, seen, place = np.random.default_rng(7), 0, 0
    while seen < 8:
        case, place = graze(rng, place, has_shaft, size), place + 1
        if case is None:
            continue
        seen += 1
        parameters, z0, w0, summit, inside = case
        rotor = sprung(*parameters, delta0=inside)
        touch = flight.first_touch(rotor, row(z0, w0), 2.0 * summit)
        assert touch < summit
        x, y, *_ = flight.fly(rotor, row(z0, w0), touch)[0]
        assert math.hypot(x, y) == pytest.approx(inside, abs=4e-15)
        wider = sprung(*parameters, delta0=inside + 2.0 * size)
        assert flight.first_touch(wider, row(z0, w0), summit + 1e-3) == NEVER


@pytest.mark.parametrize("kappa", [0.0, 1.3, 6.0])
def test_a_whirl_on_the_ring_or_just_inside_it_is_decided_at_once(kappa):
    """However long it is watched; also about the place where the load rests on the shaft."""
    whirl = 1.7**2 / complex(kappa - 1.7**2, 2.0 * 0.07 * 1.7)
    for load in (0.0, 0.3 * kappa):
        rest = -1j * load / kappa if load else 0j
        for room in (0.0, 1e-15, 1e-12, 1e-6):
            delta0 = (abs(whirl) + abs(rest)) * (1.0 + room)
            rotor = sprung(1.7, 0.07, kappa, load, delta0)
            touch = flight.first_touch(rotor, row(whirl + rest, 1.7j * whirl), 1e9 if room else 1e3)
            assert touch == NEVER or (load and not room)


def radial_rates(rotor, start, times):
    """``r r'`` of a flight."""
    x, y, vx, vy = flight.fly(rotor, start, times).T
    return x * vx + y * vy


@SHAFTS
@pytest.mark.parametrize("delta0", [5.0, 1e3, 1e6])
def test_every_extremum_of_a_flight_is_found_and_none_invented(delta0, has_shaft):
    """Each is a change of sign of r r', in the right sense, however far the ring is."""
    rng, found_in_all = np.random.default_rng(0), 0
    times = np.linspace(0.0, 10.0, 20_001)
    for place in range(50):
        parameters, z0, w0 = random_flight(rng, place, has_shaft)
        rotor = sprung(*parameters, delta0=delta0)

        end = min(10.0, 0.99 * flight.first_touch(rotor, row(z0, w0), 10.0))
        asked = runs.RunRequest(
            rotor=rotor, start=row(z0, w0), duration=end, extrema=True, events=True, **HOW
        )
        found = runs.follow_run(asked).extrema
        for time, radius, kind, (x, y, *_) in found:
            before, after = radial_rates(rotor, row(z0, w0), time + 1e-6 * np.array([-1.0, 1.0]))
            assert kind * before > 0.0 > kind * after
            assert radius == pytest.approx(math.hypot(x, y), rel=1e-15)
        assert (np.diff(found["kind"]) != 0.0).all()
        seen = radial_rates(rotor, row(z0, w0), times[times <= end])
        assert (seen[:-1] * seen[1:] < 0.0).sum() <= len(found)
        found_in_all += len(found)
    assert found_in_all > 100


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6])
def test_two_extrema_that_nearly_meet_are_both_found(apart):
    """Without damping z' = v + omega**2 (t + i omega t**2/2 + ...), and again a revolution later.

    With v = -i omega**3 apart**2/4 and z = i y there, ``r r' = y (Im v + omega**3 t**2/2 + ...)``:
    a maximum and a minimum at about ``t = -+apart/sqrt(2)``.
    """
    omega, revolution = 2.0, np.pi
    start = (0.0, 1.0, 0.0, -0.25 * omega**3 * apart**2)
    rotor = Rotor(omega=omega, zeta=0.0, delta0=1e3)
    found = extrema_of(rotor, start, 1.5 * revolution)
    close = np.diff(found["time"]) < 3.0 * apart
    assert close.any(), found["time"]
    for time, _radius, kind, *_ in found:
        before, after = radial_rates(rotor, start, time + 1e-2 * apart * np.array([-1.0, 1.0]))
        assert kind * before > 0.0 > kind * after


def extrema_of(rotor, start, duration):
    asked = runs.RunRequest(rotor=rotor, start=start, duration=duration, extrema=True, **HOW)
    return runs.follow_run(asked).extrema


def test_a_whirl_about_the_axis_has_no_extrema():
    a = unbalance_whirl(1.7, 0.07)
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=1e3)
    assert not len(extrema_of(rotor, row(a, 1.7j * a), 200.0))
    near = extrema_of(rotor, row(a + 1e-9, 1.7j * a), 200.0)
    assert len(near) == pytest.approx(200.0 * 1.7 / np.pi, abs=1.0)


def unbalance_whirl(omega, zeta):
    """The complex amplitude of the contact-free whirl on the rotating axes."""
    return -omega / complex(omega, -2.0 * zeta)


def touch_floor(omega, zeta, delta0):
    """The smallest ``|z|**2 - delta0**2`` that stands clear of rounding, as docs/events.md says."""
    return 64.0 * 2.0**-52 * delta0 * (delta0 + abs(unbalance_whirl(omega, zeta)))


def test_the_floor_is_near_rounding():
    """A touch of 1e-13 of the clearance is still found, so the stated floor is honest."""
    assert touch_floor(1.7, 0.07, 2.0) / (2 * 2.0) < 1e-13
    still, outwards = Rotor(omega=0.0, zeta=0.0, delta0=2.0), (0.0, 0.0, 1.0, 0.0)
    straight = flight.first_touch(still, outwards, 10.0)
    assert straight == pytest.approx(2.0, rel=1e-15)
    assert math.isinf(flight.first_touch(still, outwards, 1.9))


@pytest.mark.parametrize("ulps", range(-4, 5))
@pytest.mark.parametrize("slowly", [1e-12, 1e-9, 1e-8, 1e-7])
def test_a_contact_left_for_no_time_is_entered_again_at_once(ulps, slowly):
    """Where the radius is least on the ring, within rounding on either side, and turns outwards.

    A search that passes over such a hollow as over a summit flies through the ring.
    """
    delta0, omega, zeta, speed = 2.0, 2.0, 0.07, 6.0
    z0 = complex(delta0 * (1.0 + ulps * 2.0**-52))
    pulled = speed**2 / delta0 + omega**2 + 2.0 * zeta * slowly
    rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
    touch = flight.first_touch(rotor, row(z0, complex(-slowly, speed)), 5.0)
    # as far off as the floor of the search lets the gap grow
    assert touch <= 2.0 * slowly / pulled + math.sqrt(
        8.0 * touch_floor(omega, zeta, delta0) / pulled
    )


@pytest.mark.parametrize("ulps", range(-6, 7))
@pytest.mark.parametrize("outwards", [0.0, 1e-17, 1e-12, 0.3])
@pytest.mark.parametrize("angle", [0.0, 1.0, 0.5 * math.pi, 3.0])
def test_core_and_reference_agree_on_starts_at_the_ring(ulps, outwards, angle):
    turn = cmath.exp(1j * angle)
    z0 = 0.7 * (1.0 + ulps * 2.0**-52) * turn
    for sign in (1.0, -1.0):
        for around in (0.0, 0.4):
            w0 = complex(sign * outwards, around) * turn
            for omega in (0.0, 1.7):
                rotor = Rotor(omega=omega, zeta=0.07, delta0=0.7)
                disc, start = Disc(rotor, Steady(omega)), row(z0, w0)
                answer = disc.begins_in_contact(0, disc.first_state(start))
                assert answer == flight.starts_in_contact(rotor, start), (sign, around, omega)


def test_rotation_is_that_of_the_model():
    states, times = np.random.default_rng(5).normal(size=(40, 4)), np.linspace(-3.0, 9.0, 40)
    turned = states.copy()
    flight.rotate(turned, times, 1.3)
    np.testing.assert_allclose(turned, rotated(states, 1.3 * times), rtol=0, atol=4e-15)
