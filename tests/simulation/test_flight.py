"""Flight in closed form, and the search for the first touch that may miss none."""

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

NEVER = math.inf


def row(z, w):
    return (z.real, z.imag, w.real, w.imag)


def numbers(state):
    x, y, vx, vy = np.asarray(state, float).tolist()
    return complex(x, y), complex(vx, vy)


def fly(z0, w0, tau, omega, zeta):
    rotor = Rotor(omega=omega, zeta=zeta, delta0=1.0)
    return numbers(flight.fly(rotor, row(z0, w0), tau)[0])


def fly_by_parameters(z0, w0, tau, omega, zeta):
    """Through a run that never meets the ring."""
    bundle = np.zeros((7, 4))
    rotor = Rotor(omega=omega, zeta=zeta, delta0=1e3)
    asked = runs.RunRequest(
        rotor=rotor, start=row(z0, w0), duration=tau, rtol=1e-12, atol=1e-14, bundle=bundle
    )
    assert runs.follow_run(asked).status == 0
    assert not bundle[[0, 1, 2, 3, 6]].any()
    return (*numbers(bundle[4]), *numbers(bundle[5]))


def first_touch(z0, w0, omega, zeta, delta0, limit):
    return flight.first_touch(Rotor(omega=omega, zeta=zeta, delta0=delta0), row(z0, w0), limit)


def unbalance_whirl(omega, zeta):
    """The complex amplitude of the contact-free whirl on the rotating axes."""
    return -omega / complex(omega, -2.0 * zeta)


def touch_floor(omega, zeta, delta0):
    """The smallest ``|z|**2 - delta0**2`` that stands clear of rounding, as docs/events.md says."""
    return 64.0 * 2.0**-52 * delta0 * (delta0 + abs(unbalance_whirl(omega, zeta)))


def exact_position(z0, w0, tau, omega, zeta):
    """The motion on standing axes, in 40 digits, from the textbook form."""
    with mpmath.workdps(40):
        omega, zeta, tau = mpmath.mpf(omega), mpmath.mpf(zeta), mpmath.mpf(tau)
        z0, w0 = mpmath.mpc(z0), mpmath.mpc(w0)
        a = -omega / mpmath.mpc(omega, -2 * zeta) if omega else mpmath.mpc(0)
        w = w0 - 1j * omega * a
        phi = -mpmath.expm1(-2 * zeta * tau) / (2 * zeta) if zeta else tau
        return z0 + w * phi + a * (mpmath.expj(omega * tau) - 1)


def exact_slope(z0, w0, tau, omega, zeta):
    """``r r'`` of the same motion."""
    with mpmath.workdps(40):
        position = exact_position(z0, w0, tau, omega, zeta)
        a = -omega / mpmath.mpc(omega, -2 * zeta) if omega else mpmath.mpc(0)
        w = mpmath.mpc(w0) - 1j * omega * a
        turn = mpmath.expj(omega * mpmath.mpf(tau))
        velocity = w * mpmath.exp(-2 * zeta * tau) + 1j * omega * a * turn
        return (mpmath.conj(position) * velocity).real


@pytest.mark.parametrize("zeta", [0.0, 1e-300, 1e-12, 1e-8, 0.07, 2.0])
@pytest.mark.parametrize("omega", [0.0, 1e-9, 0.6, 8.0])
def test_flight_is_exact_to_rounding_at_every_damping_and_speed(omega, zeta):
    z0, w0 = 0.3 - 0.2j, -0.4 + 0.7j
    for tau in (1e-9, 0.5, 7.0):
        position, _ = fly(z0, w0, tau, omega, zeta)
        standing = position * cmath.exp(1j * omega * tau)
        expected = complex(exact_position(z0, w0, tau, omega, zeta))
        assert abs(standing - expected) < 2e-15 * (1 + tau + omega * tau)


@pytest.mark.parametrize("zeta", [0.0, 1e-12, 0.07, 2.0])
@pytest.mark.parametrize("omega", [1e-3, 0.6, 8.0])
def test_what_the_parameters_add_to_flight_is_the_derivative(omega, zeta):
    z0, w0 = 0.3 - 0.2j, -0.4 + 0.7j

    def slope(function, point):
        with mpmath.workdps(40):
            point, h = mpmath.mpf(point), mpmath.mpf("1e-10")
            return (function(point + h) - function(point - h)) / (2 * h)

    def position(omega, zeta, tau):
        with mpmath.workdps(40):
            return exact_position(z0, w0, tau, omega, zeta) * mpmath.expj(-omega * tau)

    def velocity(omega, zeta, tau):
        with mpmath.workdps(40):
            standing = slope(lambda time: exact_position(z0, w0, time, omega, zeta), tau)
            return standing * mpmath.expj(-omega * tau)

    for tau in (1e-6, 0.5, 7.0):
        found = fly_by_parameters(z0, w0, tau, omega, zeta)
        expected = [
            *(slope(lambda v, f=f, t=tau: f(v, zeta, t), omega) for f in (position, velocity)),
            *(slope(lambda v, f=f, t=tau: f(omega, v, t), zeta) for f in (position, velocity)),
        ]
        size = (1.0 + tau) ** 2 * (1.0 + omega)
        np.testing.assert_allclose(found, np.array(expected, complex), rtol=0, atol=1e-14 * size)


def test_velocity_is_the_derivative_of_position():
    omega, zeta, tau, h = 1.3, 0.2, 2.0, 1e-5
    _, velocity = fly(0.1j, 0.5 + 0j, tau, omega, zeta)
    ahead, behind = (exact_position(0.1j, 0.5 + 0j, tau + s, omega, zeta) for s in (h, -h))
    expected = complex((ahead - behind) / (2 * h)) * cmath.exp(-1j * omega * tau)
    assert velocity == pytest.approx(expected, rel=1e-8)


def test_the_contact_free_whirl_is_an_equilibrium_of_the_rotating_axes():
    a = unbalance_whirl(1.7, 0.07)
    for tau in (0.0, 1.0, 50.0):
        position, velocity = fly(a, 1.7j * a, tau, 1.7, 0.07)
        assert position == pytest.approx(a, abs=1e-14)
        assert velocity == pytest.approx(1.7j * a, abs=1e-14)


def radii(z0, w0, times, omega, zeta):
    """|z| of a flight, from the textbook form."""
    a = unbalance_whirl(omega, zeta)
    drift = -np.expm1(-2.0 * zeta * times) / (2.0 * zeta) if zeta else times
    return np.abs(z0 + (w0 - 1j * omega * a) * drift + a * np.expm1(1j * omega * times))


def graze(rng, penetration):
    """Return a flight whose |z| peaks at delta0 + penetration, and delta0, from an inner point."""
    omega, zeta = rng.uniform(0.3, 4.0), rng.choice([0.0, 1e-8, 0.07, 0.5])
    z0 = rng.normal(scale=0.5) + 1j * rng.normal(scale=0.5)
    w0 = rng.normal() + 1j * rng.normal()
    radius = radii(z0, w0, np.linspace(0.0, 12.0, 4001), omega, zeta)
    peak = next((k for k in range(1, 4000) if radius[k - 1] < radius[k] > radius[k + 1]), None)
    if peak is None or radius[peak] <= max(radius[: peak - 1]) or radius[peak] < 0.2:
        return None
    with mpmath.workdps(30):
        step = 12.0 / 4000
        summit = mpmath.findroot(
            lambda tau: exact_slope(z0, w0, tau, omega, zeta),
            ((peak - 1) * step, (peak + 1) * step),
            solver="anderson",
        )
        height = float(abs(exact_position(z0, w0, summit, omega, zeta)))
    return z0, w0, omega, zeta, float(summit), height - penetration


@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-9, 1e-12])
def test_no_graze_is_missed_and_none_invented(size):
    """Each peak found in 30 digits; the ring is put just inside it, then just outside."""
    rng = np.random.default_rng(7)
    seen = 0
    while seen < 15:
        case = graze(rng, size)
        if case is None:
            continue
        seen += 1
        z0, w0, omega, zeta, summit, inside = case
        touch = first_touch(z0, w0, omega, zeta, inside, 2.0 * summit)
        assert touch < summit
        assert abs(fly(z0, w0, touch, omega, zeta)[0]) == pytest.approx(inside, abs=4e-15)
        later = first_touch(z0, w0, omega, zeta, inside + 2.0 * size, summit + 1e-3)
        assert later == NEVER


def test_a_whirl_on_the_ring_or_just_inside_it_is_decided_at_once():
    """A centred whirl whose radius is delta0 never touches, however long it is watched."""
    a = unbalance_whirl(1.7, 0.07)
    for room in (0.0, 1e-15, 1e-12, 1e-6):
        assert first_touch(a, 1.7j * a, 1.7, 0.07, abs(a) + room, 1e9) == NEVER


def test_the_floor_is_near_rounding():
    """A touch of 1e-13 of the clearance is still found, so the stated floor is honest."""
    assert touch_floor(1.7, 0.07, 2.0) / (2 * 2.0) < 1e-13
    straight = first_touch(0j, 1 + 0j, 0.0, 0.0, 2.0, 10.0)
    assert straight == pytest.approx(2.0, rel=1e-15)
    assert math.isinf(first_touch(0j, 1 + 0j, 0.0, 0.0, 2.0, 1.9))


@pytest.mark.parametrize("ulps", range(-4, 5))
@pytest.mark.parametrize("slowly", [1e-12, 1e-9, 1e-8, 1e-7])
def test_a_contact_left_for_no_time_is_entered_again_at_once(ulps, slowly):
    """Where the radius is least on the ring, within rounding on either side, and turns outwards.

    A search that passes over such a hollow as over a summit flies through the ring.
    """
    delta0, omega, zeta, speed = 2.0, 2.0, 0.07, 6.0
    z0 = complex(delta0 * (1.0 + ulps * 2.0**-52))
    pulled = speed**2 / delta0 + omega**2 + 2.0 * zeta * slowly
    touch = first_touch(z0, complex(-slowly, speed), omega, zeta, delta0, 5.0)
    # as far off as the floor of the search lets the gap grow
    assert touch <= 2.0 * slowly / pulled + math.sqrt(
        8.0 * touch_floor(omega, zeta, delta0) / pulled
    )


def test_the_first_touch_is_the_first_of_a_fine_search():
    """A tenth of a thousandth of a radian apart nothing hides but a graze, held by others."""
    rng = np.random.default_rng(3)
    times = np.linspace(0.0, 20.0, 800_001)
    touched = 0
    for _ in range(60):
        omega, zeta = rng.uniform(0.1, 4.0), float(rng.choice([0.0, 1e-8, 0.07, 0.5]))
        z0, w0 = complex(*rng.normal(size=2)), complex(*rng.normal(size=2))
        delta0 = abs(z0) * rng.uniform(1.01, 3.0)
        outside = radii(z0, w0, times, omega, zeta) > delta0
        found = first_touch(z0, w0, omega, zeta, delta0, 20.0)
        if not outside.any():
            assert found == NEVER
            continue
        touched += 1
        last = int(outside.argmax())
        assert times[last - 1] <= found <= times[last]
        assert abs(fly(z0, w0, found, omega, zeta)[0]) == pytest.approx(delta0, rel=1e-14)
    assert touched > 30


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


def radial_rates(start, times, omega, zeta):
    """``r r'`` of a flight, from the textbook form, without the whirl's own constant radius."""
    a = unbalance_whirl(omega, zeta)
    z0, w = complex(*start[:2]), complex(*start[2:]) - 1j * omega * a
    drift = -np.expm1(-2.0 * zeta * times) / (2.0 * zeta) if zeta else times
    centre, whirl = z0 - a + w * drift, a * np.exp(1j * omega * times)
    moving = w * np.exp(-2.0 * zeta * times)
    return ((centre + whirl).conj() * moving + centre.conj() * 1j * omega * whirl).real


def extrema_of(start, omega, zeta, duration):
    rotor = Rotor(omega=omega, zeta=zeta, delta0=1e3)
    asked = runs.RunRequest(
        rotor=rotor, start=start, duration=duration, rtol=1e-12, atol=1e-14, extrema=True
    )
    return runs.follow_run(asked).extrema


def test_every_extremum_of_a_flight_is_found_and_none_invented():
    """Each is a change of sign of r r', in the right sense; a fine search finds no other."""
    rng = np.random.default_rng(0)
    times = np.linspace(0.0, 40.0, 40_001)
    found_in_all = 0
    for _ in range(100):
        omega = float(np.exp(rng.uniform(np.log(0.05), np.log(8.0))))
        zeta = float(rng.choice([0.0, 1e-8, 0.07, 0.5, 3.0, 100.0]))
        start = rng.normal(size=4) * 10.0 ** rng.uniform(-3.0, 0.5, 4)
        found = extrema_of(start, omega, zeta, 40.0)
        rates = radial_rates(start, times, omega, zeta)
        for time, _radius, kind, *_ in found:
            apart = 1e-6 * np.array([-1.0, 1.0])
            before, after = radial_rates(start, time + apart, omega, zeta)
            assert kind * before > 0.0 > kind * after
        assert (np.diff(found["kind"]) != 0.0).all()
        assert (rates[:-1] * rates[1:] < 0.0).sum() <= len(found)
        found_in_all += len(found)
    assert found_in_all > 1000


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6])
def test_two_extrema_that_nearly_meet_are_both_found(apart):
    """Without damping z' = v + omega**2 (t + i omega t**2/2 + ...), and again a revolution later.

    With v = -i omega**3 apart**2/4 and z = i y there, ``r r' = y (Im v + omega**3 t**2/2 + ...)``:
    a maximum and a minimum at about ``t = -+apart/sqrt(2)``.
    """
    omega, revolution = 2.0, np.pi
    start = (0.0, 1.0, 0.0, -0.25 * omega**3 * apart**2)
    found = extrema_of(start, omega, 0.0, 1.5 * revolution)
    close = np.diff(found["time"]) < 3.0 * apart
    assert close.any(), found["time"]
    for time, _radius, kind, *_ in found:
        before, after = radial_rates(start, time + 1e-2 * apart * np.array([-1.0, 1.0]), omega, 0.0)
        assert kind * before > 0.0 > kind * after


def test_a_whirl_about_the_axis_has_no_extrema():
    a = unbalance_whirl(1.7, 0.07)
    assert not len(extrema_of(row(a, 1.7j * a), 1.7, 0.07, 200.0))
    near = extrema_of(row(a + 1e-9, 1.7j * a), 1.7, 0.07, 200.0)
    assert len(near) == pytest.approx(200.0 * 1.7 / np.pi, abs=1.0)
