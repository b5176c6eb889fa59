"""Flight in closed form: exact to rounding, and no touch or extremum is missed.

The witness is the textbook's form in 200 digits, where nothing that cancels matters: stiffness and
speed are moved by 1e-60, so that no resonance and no critical damping is a case of its own.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core import runs
from rotor_ida.core.interface import DONE
from tests.core import flight

NEVER = math.inf
SPANS = (1e-6, 0.013, 0.7, 2.3, 19.0, 300.0)
HOW = {"rtol": 1e-12, "atol": 1e-14}


def sprung(omega, zeta, kappa, load=0.0, delta0=1.0):
    # which is no rotor of the paper in any case, and flies as without the damping
    return Rotor(omega=omega, zeta=zeta, shaft_stiffness=kappa, load=load, delta0=delta0,
                 contact_damping=0.1)  # fmt: skip


def row(z, w):
    return (z.real, z.imag, w.real, w.imag)


class Exact:
    """Displacement and velocity on axes that stand still, in 200 digits."""

    def __init__(self, rotor, z0, w0):
        with mpmath.workdps(200):
            aside = mpmath.mpf(10) ** -60
            omega, zeta = mpmath.mpf(rotor.omega) + aside / 3, mpmath.mpf(rotor.zeta)
            kappa = mpmath.mpf(rotor.shaft_stiffness) + aside
            self.rest = -1j * mpmath.mpf(rotor.load) / kappa
            whirl = omega**2 / (kappa - omega**2 + 2j * zeta * omega)
            split = mpmath.sqrt(zeta**2 - kappa + aside**2)
            first, last = -zeta + split, -zeta - split
            off, moving = z0 - whirl - self.rest, w0 - 1j * omega * whirl
            self.terms = [
                (first, (moving - last * off) / (first - last)),
                (last, (first * off - moving) / (first - last)),
                (1j * omega, whirl),
            ]

    def __call__(self, tau):
        with mpmath.workdps(200):
            moved = [(rate, size * mpmath.exp(rate * tau)) for rate, size in self.terms]
            z = self.rest + mpmath.fsum(size for _, size in moved)
            return z, mpmath.fsum(rate * size for rate, size in moved)

    def slope(self, tau):
        z, v = self(tau)
        with mpmath.workdps(200):
            return (mpmath.conj(z) * v).real


def errors(rotor, z0, w0, tau):
    """Return the errors of displacement and velocity, of what they come to about then."""
    x, y, vx, vy = flight.fly(rotor, row(z0, w0), tau)[0].tolist()
    exact, found = Exact(rotor, z0, w0), (complex(x, y), complex(vx, vy))
    reached = [exact(tau * part) for part in (1.0, 0.8, 0.63)]
    with mpmath.workdps(60):
        turn = mpmath.expj(mpmath.mpf(rotor.omega) * mpmath.mpf(tau))
        for place in (0, 1):
            size = max(abs(each[place]) for each in reached)
            if size > 1e-30:  # or it has come to rest
                yield float(abs(found[place] * turn - reached[0][place]) / size)


def critical():
    for part in (1e-16, 3e-14, 1e-12, 1e-8, 1e-4, 1e-1):
        yield from ((1.3, 0.9, 0.81 * (1.0 + sign * part)) for sign in (-1.0, 1.0))


def resonant():
    for part in (0.0, 1e-16, 1e-12, 1e-8, 1e-4, 0.1):
        for zeta in (0.0, 1e-300, 1e-17, 1e-9, 1e-3):
            yield from ((omega, zeta, omega**2 * (1.0 + part)) for omega in (0.3, 2.7))


def soft():
    for kappa in (1e-20, 1e-12, 1e-5, 0.0):
        yield from (
            (omega, zeta, kappa) for omega in (0.0, 1e-4, 1.7) for zeta in (0.0, 1e-12, 0.07, 2.0)
        )


def slow():
    for omega in (0.0, 1e-9, 1e-5, 1e-2):
        yield from ((omega, 2.0, kappa) for kappa in (1e-3, 0.5, 7.0, 100.0))


def generic():
    yield from np.exp(np.random.default_rng(5).uniform(np.log(1e-3), np.log(8.0), (12, 3))).tolist()


@pytest.mark.parametrize("kind", [critical, resonant, soft, slow, generic])
@pytest.mark.parametrize("given", ["all", "unbalance", "load"])
def test_flight_is_exact_to_rounding(kind, given):
    """Also what unbalance or load alone begin, from rest: no part hides in a larger one."""
    z0, w0 = (0.3 - 0.2j, -0.4 + 0.7j) if given == "all" else (0j, 0j)
    seen = 0
    for omega, zeta, kappa in kind():
        load = 0.0 if given == "unbalance" else 0.8
        rotor = sprung(0.0 if given == "load" else omega, zeta, kappa, load)
        for tau in SPANS:
            most = 4e-15 * (1.0 + max(omega, math.sqrt(kappa)) * tau)
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


def test_differences_fly_as_what_lies_between_two_flights():
    """Flight is affine: a whole unit apart is a difference as well."""
    for omega, zeta, kappa in generic():
        rotor, start = sprung(omega, zeta, kappa, 0.8, delta0=1e6), np.array((0.3, -0.2, 0.5, 0.1))
        bundle = np.eye(4)
        asked = runs.RunRequest(rotor=rotor, start=tuple(start), duration=3.0, bundle=bundle, **HOW)
        assert runs.follow_run(asked).status == DONE
        apart = [flight.fly(rotor, start + unit, 3.0)[0] for unit in np.eye(4)]
        expected = np.array(apart) - flight.fly(rotor, start, 3.0)
        np.testing.assert_allclose(bundle, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def random_flight(rng, place):
    """Return a machine of one of several kinds without its clearance, and a start."""
    omega, zeta = rng.uniform(0.1, 4.0), float(rng.choice([0.0, 1e-8, 0.07, 0.5]))
    kappa = (0.0, float(rng.uniform(0.0, 9.0)), omega**2, zeta**2, 1e-9)[place % 5]
    load = float(rng.choice([0.0, rng.uniform(0.0, 2.0)]))
    z0, w0 = (complex(*rng.normal(scale=0.5, size=2)) for _ in range(2))
    return (omega, zeta, kappa, load), z0, w0


def test_the_first_touch_is_the_first_of_a_fine_search():
    """Between two looks hides but a graze; these are held below."""
    rng = np.random.default_rng(3)
    times = np.linspace(0.0, 20.0, 400_001)
    touched = missed = 0
    for place in range(60):
        parameters, z0, w0 = random_flight(rng, place)
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
    assert missed > 5


def graze(rng, place, penetration):
    """Return a flight whose |z| peaks at delta0 + penetration, from an inner point, and when."""
    parameters, z0, w0 = random_flight(rng, place)
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


@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-9, 1e-12])
def test_no_graze_is_missed_and_none_invented(size):
    """Each peak found in 30 digits; the ring is put just inside it, then just outside."""
    rng, seen, place = np.random.default_rng(7), 0, 0
    while seen < 15:
        case, place = graze(rng, place, size), place + 1
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


@pytest.mark.parametrize("delta0", [5.0, 1e3, 1e6])
def test_every_extremum_of_a_flight_is_found_and_none_invented(delta0):
    """Each is a change of sign of r r', in the right sense, however far the ring is."""
    rng, found_in_all = np.random.default_rng(0), 0
    times = np.linspace(0.0, 10.0, 20_001)
    for place in range(25):
        parameters, z0, w0 = random_flight(rng, place)
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


def test_two_extrema_of_a_flight_close_together_are_found():
    """Between two looks the radial rate comes to 0, passes it, and comes back."""
    rotor = Rotor(omega=3.325646323894685, zeta=0.0, delta0=50.0)
    # a whirl of radius 1 about a centre that drifts past the axis: r r' touches 0 now and then
    found = 0
    for speed in np.linspace(0.05, 1.5, 60):
        start = (-1.0 + 0.3, 0.4, 0.2 * speed, -rotor.omega + speed)
        seen = runs.follow_run(
            runs.RunRequest(rotor=rotor, start=start, duration=15.0, extrema=True, **HOW)
        )
        times = np.linspace(0.0, 15.0, 60_001)
        x, y, vx, vy = flight.fly(rotor, start, times).T
        rate = x * vx + y * vy
        turns = np.flatnonzero(rate[1:] * rate[:-1] < 0.0)
        assert len(seen.extrema) == turns.size
        assert (np.abs(seen.extrema["time"] - times[turns]) <= times[1]).all()
        found += turns.size
    assert found > 900


def test_maxima_and_minima_of_the_radius_alternate_across_contacts():
    rotor = Rotor(omega=3.325646323894685, zeta=0.0, delta0=1.0173030142969024)
    seen = runs.follow_run(
        runs.RunRequest(
            rotor=rotor, start=(0, 0, 0, 0), duration=30.0, extrema=True, events=True, **HOW
        )
    )
    kinds = seen.extrema["kind"]
    assert (kinds[1:] != kinds[:-1]).all()


def test_a_start_may_be_given_once_for_many_flights():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    start, spans = (0.3, 0.2, 0.1, -0.4), [0.5, 1.0, 2.0]
    together = flight.fly(rotor, start, spans)
    apart = [flight.fly(rotor, start, span)[0] for span in spans]
    np.testing.assert_array_equal(together, apart)
