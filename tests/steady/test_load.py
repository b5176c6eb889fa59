"""On what rotors settle under a load: whirls about an offset, cycles of revolutions, tori, rest."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotor_ida import Rotor, lyapunov_exponent, synchronous_response
from rotor_ida.closed_forms.rest import rest
from rotor_ida.simulation.neighbours import shoot
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import follow_to_steady_state
from rotor_ida.steady.periods import recurrence_by_revolutions

REST = (0.0, 0.0, 0.0, 0.0)
GO_ON = np.zeros(1, np.uint8)
SHAFT = {"delta0": 1.0, "shaft_stiffness": 0.25}
# Machines and after how many revolutions their motion from rest comes again.
CYCLES = {
    "once": (Rotor(omega=2.4, zeta=0.05, load=0.6, **SHAFT), 1),
    "twice": (Rotor(omega=2.0, zeta=0.05, load=0.6, **SHAFT), 2),
    "three times": (Rotor(omega=2.5, zeta=0.05, load=0.6, **SHAFT), 3),
    "four times": (Rotor(omega=1.6, zeta=0.05, load=0.6, **SHAFT), 4),
    "linear contact": (Rotor(omega=1.4, zeta=0.05, load=0.6, contact_exponent=1.0, **SHAFT), 3),
    "contact damping": (Rotor(omega=1.5, zeta=0.1, load=0.3, contact_damping=0.3, **SHAFT), 2),
    "no shaft": (Rotor(omega=1.8333333333333333, zeta=0.1, delta0=1.0, load=0.3), 4),
}


def followed(rotor, start=REST, method="taylor", **settings):
    return follow_to_steady_state(rotor, start, Options(method=method), **settings)


def flown(rotor, start, times):
    """Displacements and velocities at times on the fixed axes, by DOP853."""

    def rates(time, state):
        z, v = complex(*state[:2]), complex(*state[2:])
        depth, radius = abs(z) - rotor.delta0, abs(z)
        push = rotor.omega**2 * np.exp(1j * rotor.omega * time) - 1j * rotor.load
        a = push - 2.0 * rotor.zeta * v - rotor.shaft_stiffness * z
        if depth > 0.0:
            approach = (z.conjugate() * v).real / radius
            force = depth**rotor.contact_exponent * (1.0 + rotor.contact_damping * approach)
            a -= max(force, 0.0) * z / radius
        return [v.real, v.imag, a.real, a.imag]

    found = solve_ivp(
        rates, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-12,
        max_step=0.02,
    )  # fmt: skip
    return found.y[0] + 1j * found.y[1], found.y[2] + 1j * found.y[3]


@pytest.mark.parametrize("name", CYCLES)
def test_a_cycle_comes_again_after_whole_revolutions_by_another_integrator(name):
    """And not after fewer; radii and the part at the spin speed are those of that integrator."""
    rotor, count = CYCLES[name]
    settled = followed(rotor)
    revolution = 2.0 * math.pi / rotor.omega
    assert settled.features.period == pytest.approx(count * revolution, rel=1e-14)
    times = np.linspace(0.0, count * revolution, 1024 * count + 1)
    z, v = flown(rotor, settled.end, times)
    at_start = np.array([z[:1], v[:1]])
    apart = np.abs(np.array([z[::1024], v[::1024]]) - at_start).max(axis=0)
    assert apart[-1] < 1e-8
    assert (apart[1:-1] > 1e-2).all()
    radius, features = np.abs(z), settled.features
    assert settled.response == ("bouncing" if radius.min() < rotor.delta0 else "full_contact")
    # between samples the radius turns
    assert features.radius_max == pytest.approx(radius.max(), rel=1e-4)
    assert features.radius_min == pytest.approx(radius.min(), abs=2e-3)
    spin = complex((z[:-1] * np.exp(-1j * rotor.omega * times[:-1])).mean())
    assert features.amplitude == pytest.approx(abs(spin), rel=1e-6)
    assert features.phase_lag == pytest.approx(-np.angle(spin), rel=1e-6)


@pytest.mark.parametrize("name", ["twice", "contact damping"])
def test_methods_and_backends_agree_on_a_cycle(name):
    rotor, _ = CYCLES[name]
    taylor, adams = followed(rotor), followed(rotor, method="adams")
    assert adams.response == taylor.response
    for each in ("period", "amplitude", "radius_min", "radius_max"):
        one, other = getattr(taylor.features, each), getattr(adams.features, each)
        assert one == pytest.approx(other, rel=1e-8)


def test_the_reference_in_plain_python_settles_alike():
    rotor = Rotor(omega=2.0, zeta=1.0, load=0.6, **SHAFT)
    core = followed(rotor)
    plain = follow_to_steady_state(rotor, REST, Options(backend="python", rtol=1e-9))
    assert plain.response == core.response == "bouncing"
    assert plain.features.period == core.features.period
    assert plain.features.radius_max == pytest.approx(core.features.radius_max, rel=1e-7)


@pytest.mark.parametrize("load", [0.4, 1.2])
def test_clear_of_the_ring_it_whirls_about_where_the_shaft_holds_the_load(load):
    """z = -i load/kappa + A exp(i omega t), exactly."""
    rotor = Rotor(omega=1.7, zeta=0.1, delta0=4.0, shaft_stiffness=0.5, load=load)
    settled = followed(rotor, (1.0, 0.0, 0.0, 1.0))
    whirl = 1.7**2 / complex(0.5 - 1.7**2, 2.0 * 0.1 * 1.7)
    assert settled.response == "contact_free"
    assert math.isnan(settled.features.period)
    assert settled.features.amplitude == pytest.approx(abs(whirl), rel=1e-9)
    assert settled.features.radius_max == pytest.approx(abs(whirl) + load / 0.5, rel=1e-9)
    assert settled.features.radius_min == pytest.approx(abs(abs(whirl) - load / 0.5), abs=1e-9)
    x, y, vx, vy = settled.end
    assert complex(x, y) == pytest.approx(whirl - 1j * load / 0.5, abs=1e-8)
    assert complex(vx, vy) == pytest.approx(1.7j * whirl, abs=1e-8)


def test_where_that_whirl_would_reach_the_ring_it_does_not_stay_free():
    """Its largest radius, 1.21 + 0.8, decides, not that of the whirl alone."""
    whirl = 1.7**2 / abs(complex(0.5 - 1.7**2, 2.0 * 0.1 * 1.7))
    machine = {"omega": 1.7, "zeta": 0.1, "shaft_stiffness": 0.5, "load": 0.4}
    for clearance, kinds in ((0.999, {"bouncing", "full_contact"}), (1.001, {"contact_free"})):
        rotor = Rotor(delta0=clearance * (whirl + 0.8), **machine)
        assert followed(rotor).response in kinds


def swing_by_a_small_load(omega, zeta, delta0):
    """How far a unit of a rotating load swings the radius of a synchronous whirl, if small."""
    whirls = synchronous_response(omega=omega, zeta=zeta, delta0=delta0)
    amplitude = whirls.amplitude.values.ravel()[0]
    secant = (amplitude - delta0) ** 1.5 / amplitude
    slope, q = 1.5 * math.sqrt(amplitude - delta0), omega**2
    stiffness = np.array([[slope - q, -2.0 * zeta * omega], [2.0 * zeta * omega, secant - q]])
    damping = np.array([[2.0 * zeta, -2.0 * omega], [2.0 * omega, 2.0 * zeta]])
    resistance = stiffness + 1j * omega * damping - q * np.eye(2)
    return amplitude, abs(np.linalg.solve(resistance, [1.0, 1j])[0])


def test_a_slight_load_swings_a_synchronous_whirl_as_linear_theory_says():
    """So a sweep comes to that without load, to first order, as the load goes to 0."""
    amplitude, swing = swing_by_a_small_load(1.2, 0.07, 0.5)
    missed = []
    for load in (1e-2, 1e-3, 1e-4):
        settled = followed(Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=load))
        assert settled.response == "full_contact"
        assert settled.features.period == pytest.approx(2.0 * math.pi / 1.2, rel=1e-14)
        low, high = settled.features.radius_min, settled.features.radius_max
        assert (high - low) / (2.0 * load) == pytest.approx(swing, rel=5.0 * load)
        missed.append(abs(settled.features.amplitude - amplitude))
    # the part at the spin speed changes by the square of the load
    assert np.polyfit([-2.0, -3.0, -4.0], np.log10(missed), 1)[0] == pytest.approx(2.0, abs=0.05)


def test_a_load_below_what_is_steady_leaves_a_synchronous_whirl():
    amplitude, _ = swing_by_a_small_load(1.2, 0.07, 0.5)
    settled = followed(Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=1e-11))
    assert settled.response == "synchronous"
    assert settled.features.amplitude == pytest.approx(amplitude, rel=1e-9)


def test_a_cycle_without_load_becomes_a_torus_under_a_slight_one():
    """Its period, 4.5639, is no whole number of revolutions; its radii are those of DESIGN."""
    beyond = []
    for load in (0.02, 0.01):
        settled = followed(Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=load))
        assert settled.response == "quasi_periodic"
        assert math.isnan(settled.features.period)
        assert abs(settled.features.lyapunov_exponent) < 1e-6
        beyond.append(settled.features.radius_max - 4.104416607)
    assert 0.0 < beyond[1] < 0.02
    assert beyond[0] / beyond[1] == pytest.approx(2.0, rel=0.1)


def test_on_a_torus_one_exponent_is_zero_and_their_sum_is_that_of_the_damping():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=0.01)
    found = lyapunov_exponent(rotor, start=REST, transient=2000.0, duration=4000.0)
    exponents = found.lyapunov_exponent.values
    assert abs(exponents[0]) < 1e-6
    assert exponents[1] < -0.01
    assert found.exponent_sum.item() == pytest.approx(-0.28, abs=1e-9)


def test_exponents_of_a_cycle_under_a_load_are_those_of_its_multipliers():
    """Spans of an exponent end anywhere in a revolution: the load must be where it then is."""
    rotor, count = CYCLES["three times"]
    state = followed(rotor).end
    period = count * 2.0 * math.pi / rotor.omega
    multipliers = np.linalg.eigvals(shoot(rotor, np.array(state), period, GO_ON).monodromy)
    expected = np.sort(np.log(np.abs(multipliers)))[::-1] / period
    found = lyapunov_exponent(rotor, start=state, transient=300.0, duration=6000.0)
    np.testing.assert_allclose(found.lyapunov_exponent, expected, atol=2e-4)
    assert expected.sum() == pytest.approx(-4.0 * rotor.zeta, rel=1e-9)
    assert expected[0] < -0.005


def test_chaos_under_a_load_is_told_with_its_exponent():
    rotor = Rotor(omega=1.5, zeta=0.05, delta0=1.0, shaft_stiffness=0.05, load=0.6)
    settled = followed(rotor)
    assert settled.response == "chaotic"
    exponent, error = settled.features.lyapunov_exponent, settled.features.lyapunov_error
    assert exponent > 5.0 * error
    found = lyapunov_exponent(rotor, start=(0.5, 0.0, 0.0, 0.3), duration=10_000.0)
    other, its_error = (float(found[f"lyapunov_{each}"][0]) for each in ("exponent", "error"))
    assert abs(exponent - other) < 4.0 * math.hypot(error, its_error)


AT_REST = {
    "hangs": Rotor(omega=0.0, zeta=0.1, delta0=1.0, shaft_stiffness=0.5, load=0.2),
    "hangs on the ring": Rotor(omega=0.0, zeta=0.1, delta0=1.0, shaft_stiffness=0.5, load=0.9),
    "lies": Rotor(omega=0.0, zeta=0.2, delta0=1.0, load=0.3),
    "lies, linear": Rotor(
        omega=0.0, zeta=0.2, delta0=1.0, load=0.3, contact_exponent=1.0, contact_damping=0.5
    ),
    "no clearance": Rotor(omega=0.0, zeta=0.2, delta0=0.0, load=0.3),
}


@pytest.mark.parametrize("name", AT_REST)
@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_what_does_not_turn_comes_to_rest_where_the_closed_form_says(name, method):
    rotor = AT_REST[name]
    settled, place = followed(rotor, (0.4, 0.1, 0.3, 0.0), method), rest(rotor)
    assert settled.response == ("synchronous" if place.indentation > 0.0 else "contact_free")
    depth = -place.y.item()
    assert settled.features.amplitude == pytest.approx(depth, rel=1e-9)
    assert settled.features.radius_min == pytest.approx(depth, rel=1e-9)
    assert settled.features.radius_max == pytest.approx(depth, rel=1e-9)
    assert settled.end == pytest.approx((0.0, -depth, 0.0, 0.0), abs=1e-9)


def test_what_has_not_come_to_rest_is_unresolved():
    creeping = Rotor(omega=0.0, zeta=1.0, delta0=1.0, load=1e-3)
    assert followed(creeping, (0.8, -0.6, 0.0, 0.0), longest=1000.0).response == "unresolved"
    undamped = Rotor(omega=0.0, zeta=0.0, delta0=1.0, load=0.3)
    assert followed(undamped, (0.4, 0.1, 0.3, 0.0)).response == "unresolved"


def strobes(multiplier, size, count=40):
    """States once a revolution of a motion that comes to a fixed point by one multiplier."""
    states = np.zeros((count, 4))
    states[:, 0] = 1.0 + size * multiplier ** np.arange(count)
    return states


def test_what_comes_to_a_fixed_point_by_turns_is_not_told_as_one_of_two_revolutions():
    """It comes nearer to itself after two than after one, until it is too near for either."""
    for size in (1e-3, 1e-6, 1e-8):
        assert recurrence_by_revolutions(strobes(-0.999, size), 1.0, 1.0, 1e-8) is None
    found = recurrence_by_revolutions(strobes(-0.999, 1e-9), 1.0, 1.0, 1e-8)
    assert found is not None
    assert found.period == 1.0


def test_a_cycle_of_revolutions_needs_three_of_its_periods():
    for count in (1, 2, 3, 5):
        states = np.zeros((3 * count + 1, 4))
        states[:, 1] = np.arange(3 * count + 1) % count
        found = recurrence_by_revolutions(states, 0.5, 5.0, 1e-8)
        assert found is not None
        assert (found.period, found.missed_by) == (0.5 * count, 0.0)
        if count > 1:
            assert recurrence_by_revolutions(states[:-1], 0.5, 5.0, 1e-8) is None
