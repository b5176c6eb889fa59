"""The modes are DESIGN section 2, in other variables: held against its one line, z'' = ..."""

import cmath
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida.equations.modes import CARTESIAN, CONTACT
from rotor_ida.equations.symbols import variables

STEP = 1e-5


def acceleration(z, w, omega, zeta, delta0):
    """z'' + 2 zeta z' + f(|z|) z/|z| = omega**2, on axes that stand where the unbalance points."""
    force = max(abs(z) - delta0, 0.0) ** 1.5
    return omega**2 - 2.0 * zeta * w - (force * z / abs(z) if z else 0.0)


def rotating_rates(z, w, omega, zeta, delta0):
    """Of displacement and velocity, read on axes that turn."""
    turning = -1j * omega
    return w + turning * z, acceleration(z, w, omega, zeta, delta0) + turning * w


def rotors(count, seed):
    draw = np.random.default_rng(seed)
    return draw, zip(*draw.uniform(0.0, (4.0, 2.0, 3.0), (count, 3)).T, strict=True)


def contact_states(count=50, seed=0):
    draw, given = rotors(count, seed)
    for omega, zeta, delta0 in given:
        q, p, h, angle, t, j = draw.normal(size=6)
        c, s = np.cos(angle), np.sin(angle)
        yield [abs(q) + 0.1, p, h, c, s, t, j], (omega, zeta, delta0)


def cartesian_states(count=50, seed=1):
    draw, given = rotors(count, seed)
    for omega, zeta, _ in given:
        yield draw.normal(size=4).tolist(), (omega, zeta, 0.0)


def rotor_of(omega, zeta, delta0, felt=1.0):
    return SimpleNamespace(omega=omega, zeta=zeta, delta0=delta0, felt=felt)


def centre(state, delta0):
    """Displacement and velocity, and the direction of the basis in which differences are read."""
    if len(state) == 4:
        return complex(*state[:2]), complex(*state[2:]), 1.0 + 0j
    q, p, h, c, s = state[:5]
    r, outwards = delta0 + q * q, complex(c, s)
    return r * outwards, complex(p, h / r) * outwards, outwards


def test_contact_moves_by_the_equation():
    """By the chain rule, of z = r e and w = (p + i h/r) e with r = delta0 + q**2, dt = q du."""
    for state, parameters in contact_states():
        q, p, h, c, s, _, _ = state
        rates = CONTACT.rates(state, rotor_of(*parameters))
        q_, p_, h_, c_, s_, t_, j_ = rates
        z, w, e = centre(state, parameters[2])
        r, r_, e_ = abs(z), 2.0 * q * q_, complex(c_, s_)
        moved = r_ * e + r * e_, complex(p_, h_ / r - h * r_ / r**2) * e + complex(p, h / r) * e_
        expected = [q * rate for rate in rotating_rates(z, w, *parameters)]
        np.testing.assert_allclose(moved, expected, rtol=1e-12, atol=1e-12)
        assert (t_, j_) == (q, pytest.approx(q**4))
        assert c * c_ + s * s_ == pytest.approx(0.0, abs=1e-15 * (1.0 + abs(e_)))
        assert CONTACT.pace(state) == q


def test_a_direction_off_the_unit_circle_is_drawn_back_and_no_other():
    """With n = c**2 + s**2, dn/dt = omega n (1 - n)/5; all else moves as without."""
    for state, parameters in contact_states():
        rotor, q = rotor_of(*parameters), state[0]
        plain, drawn = (np.array(way(state, rotor)) for way in (CONTACT.rates, CONTACT.drawn_rates))
        np.testing.assert_allclose(drawn, plain, rtol=1e-13, atol=1e-13)
        longer = [*state[:3], 1.2 * state[3], 1.2 * state[4], *state[5:]]
        plain, drawn = (
            np.array(way(longer, rotor)) for way in (CONTACT.rates, CONTACT.drawn_rates)
        )
        assert (drawn != plain).nonzero()[0].tolist() in ([3, 4], [])
        c, s, length = longer[3], longer[4], 1.44
        rate = 2.0 * (c * drawn[3] + s * drawn[4]) / q
        assert rate == pytest.approx(0.2 * parameters[0] * length * (1.0 - length), abs=1e-12)


@pytest.mark.parametrize("felt", [0.0, 1.0])
def test_displacement_and_velocity_move_by_the_equation(felt):
    for state, (omega, zeta, _) in cartesian_states():
        z, w, _ = centre(state, 0.0)
        rates = CARTESIAN.rates(state, rotor_of(omega, zeta, 0.0, felt))
        delta0 = 0.0 if felt else 1e9
        expected = rotating_rates(z, w, omega, zeta, delta0)
        np.testing.assert_allclose(centre(rates, 0.0)[:2], expected, rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize(
    ("mode", "states"), [(CONTACT, contact_states), (CARTESIAN, cartesian_states)]
)
def test_a_neighbour_is_there_and_accelerated_so_to_first_order(mode, states):
    """Central differences, in the basis of the one beside it."""
    for state, parameters in states():
        z, w, e = centre(state, parameters[2])
        apart = np.random.default_rng(2).normal(size=4)
        turning = mode.neighbour(state, [0.0] * 4, 0.0, rotor_of(*parameters)).turning
        around = (z.conjugate() * w).imag / abs(z) ** 2
        assert turning == pytest.approx(around if mode is CONTACT else parameters[0], rel=1e-12)
        for place in ("position", "velocity", "acceleration"):
            found, true = [], []
            for sign in (STEP, -STEP):
                aside = (sign * apart).tolist()
                near = mode.neighbour(state, aside, aside[0], rotor_of(*parameters))
                found.append(complex(*getattr(near, place)))
                there = z + complex(*aside[:2]) * e, w + complex(*aside[2:]) * e
                places = {"position": there[0], "velocity": there[1]}
                places["acceleration"] = acceleration(*there, *parameters)
                true.append(places[place] / e)
            assert sum(found) / 2.0 == pytest.approx(sum(true) / 2.0, rel=1e-8, abs=1e-8)
            slopes = [(high - low) / (2.0 * STEP) for high, low in (found, true)]
            assert slopes[0] == pytest.approx(slopes[1], rel=1e-6, abs=1e-6), place


@pytest.mark.parametrize(
    ("mode", "states"), [(CONTACT, contact_states), (CARTESIAN, cartesian_states)]
)
def test_duals_are_the_derivatives_of_the_rates(mode, states):
    for state, parameters in states(10):
        found = [rate.parts for rate in mode.rates(variables(state), rotor_of(*parameters))]
        for place in range(len(state)):
            aside = STEP * np.eye(len(state))[place]
            high, low = (
                np.array(mode.rates((state + sign * aside).tolist(), rotor_of(*parameters)))
                for sign in (1, -1)
            )
            column = [row[place] for row in found]
            np.testing.assert_allclose(column, (high - low) / (2.0 * STEP), rtol=1e-6, atol=1e-6)


def test_guards_are_what_the_core_watches():
    """The exit where q falls through 0, and the extremum where p vanishes."""
    assert [(guard.event, guard.of) for guard in CONTACT.guards] == [
        ("exit", "q"),
        ("extremum", "p"),
    ]
    assert {guard.of for mode in (CONTACT, CARTESIAN) for guard in mode.guards} <= {*CONTACT.state}


def test_without_unbalance_and_damping_a_radial_contact_keeps_its_energy():
    """dE/du = p p' + q**3 2 q q' = 0 along the stated rates."""
    for state, (_, _, delta0) in contact_states():
        q, p, _, c, s, t, j = state
        rates = CONTACT.rates([q, p, 0.0, c, s, t, j], rotor_of(0.0, 0.0, delta0))
        assert p * rates[1] + 2.0 * q**4 * rates[0] == pytest.approx(0.0, abs=1e-12)
        assert cmath.isfinite(sum(rates))
