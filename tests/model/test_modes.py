"""The modes are DESIGN section 2, in other variables: held against its one line, z'' = ...

Of the paper's rotor, and of the whole model with shaft, contact damping, both exponents, a load,
and friction that slides and rolls.
"""

import cmath
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida.model.modes import PAPER, ROLLING, WHOLE
from rotor_ida.model.rates import grip_and_hold
from rotor_ida.model.symbols import variables

STEP = 1e-5


def rotor_of(model, **given):
    """Return whatever has the parameters of a rotor, and of a mode, as attributes."""
    return SimpleNamespace(**model.constants | {"felt": 1.0} | given)


def changed(rotor, **given):
    return SimpleNamespace(**vars(rotor) | given)


def random_rotor(model, draw, **given):
    numbers = {"omega": 4.0, "zeta": 2.0, "delta0": 3.0}
    if model is WHOLE:
        numbers |= {"shaft_stiffness": 4.0, "contact_damping": 2.0, "load": 3.0}
    drawn = {name: draw.uniform(0.0, most) for name, most in numbers.items()}
    if model is WHOLE:
        hertz = float(draw.integers(2))
        drawn |= {"hertz": hertz, "linear": 1.0 - hertz, "loose": float(draw.integers(2))}
        drawn |= {"friction": 0.3, "disc_radius": 1.5}
    return rotor_of(model, **drawn | given)


def normal_force(z, w, rotor):
    """N = d**n (1 + c d') where d = |z| - delta0 > 0 unless loose, or else 0; and d**n and d'."""
    depth, approach = abs(z) - rotor.delta0, (z.conjugate() * w).real / abs(z)
    if depth <= 0.0:
        return 0.0, 0.0, approach
    spring = depth ** (1.5 if rotor.hertz else 1.0)
    force = spring * (1.0 + rotor.contact_damping * approach)
    return rotor.felt * (1.0 - rotor.loose) * force, spring, approach


def acceleration(z, w, down, rotor):
    """z'' = omega**2 e - 2 zeta z' - kappa z - (N + i T) z/|z| + gamma g, e where the unbalance
    points."""
    push = (normal_force(z, w, rotor)[0] + 1j * tangential_force(z, w, down, rotor)) * z / abs(z)
    slowed = -2.0 * rotor.zeta * w - rotor.shaft_stiffness * z
    return rotor.omega**2 + slowed - push + rotor.load * down


def tangential_force(z, w, down, rotor):
    """T = mu sigma N, or what keeps the moment of the slip, h + V r, as it is; or 0."""
    way = getattr(rotor, "way", "")
    if way == "rub":
        return rotor.friction * rotor.sigma * normal_force(z, w, rotor)[0]
    if way == "rolling":
        e = z / abs(z)
        free = rotor.omega**2 - 2.0 * rotor.zeta * w + rotor.load * down
        return (free / e).imag + rotor.disc_radius * rotor.omega * (w / e).real / abs(z)
    return 0.0


def rotating_rates(z, w, down, rotor):
    """Of displacement, velocity and the load's direction, read on axes that turn."""
    turning = -1j * rotor.omega
    return w + turning * z, acceleration(z, w, down, rotor) + turning * w, turning * down


def unit(draw):
    return cmath.rect(1.0, draw.uniform(0.0, 2.0 * np.pi))


def contact_states(model, count=50, seed=0, **given):
    """Return states in contact, and a rotor each."""
    draw = np.random.default_rng(seed)
    for _ in range(count):
        rotor = random_rotor(model, draw, **given)
        q, p, h, t, j, work = draw.normal(size=6)
        e, down = unit(draw), unit(draw)
        state = [abs(q) + 0.1, p, h, e.real, e.imag]
        state += [down.real, down.imag, t, j, work, 0.3] if model is WHOLE else [t, j]
        yield state, rotor


def cartesian_states(model, count=50, seed=1, **given):
    draw = np.random.default_rng(seed)
    for _ in range(count):
        # a tensile force needs clearance, and is not stated here
        rotor = random_rotor(model, draw, **{"delta0": 0.0, "contact_damping": 0.0} | given)
        rotor = changed(rotor, loose=0.0)
        down = unit(draw)
        more = [down.real, down.imag] if model is WHOLE else []
        yield [*draw.normal(size=4).tolist(), *more], rotor


def rub_states(model, count=50, seed=3, way="rub", **given):
    """Return states with friction, which hold the moment of the slip, and the heat."""
    draw = np.random.default_rng(seed)
    for state, rotor in contact_states(model, count, seed, **given):
        slides = way == "rub"
        sigma = draw.choice([-1.0, 1.0]) if slides else 0.0
        friction, disc_radius = draw.uniform(0.0, 2.0), draw.uniform(0.0, 5.0)
        rim = disc_radius * rotor.omega
        slip = sigma * abs(draw.normal())
        yield (
            [*state[:2], slip, *state[3:], draw.normal()],
            changed(
                rotor, friction=friction, disc_radius=disc_radius, rim=rim, sigma=sigma, way=way
            ),
        )


def rolling_states(model, count=50, seed=4, **given):
    return rub_states(model, count, seed, "rolling", **given)


def is_contact(mode):
    return mode.name != "cartesian"


def centre(mode, state, rotor):
    """Displacement, velocity, the load's direction, and the basis in which differences are read."""
    named = dict(zip(mode.state, state, strict=True))
    if not is_contact(mode):
        down = complex(named.get("down_x", 0.0), named.get("down_y", 0.0))
        return complex(*state[:2]), complex(*state[2:4]), down, 1.0 + 0j
    q, p, h, c, s = state[:5]
    r, outwards = rotor.delta0 + q * q, complex(c, s)
    h = named["slip"] - rotor.rim * r if "slip" in named else h
    down = complex(named.get("down_r", 0.0), named.get("down_t", 0.0)) * outwards
    return r * outwards, complex(p, h / r) * outwards, down, outwards


# Those of one speed; the others are tested by run-ups, against a rigid body.
STEADY = (PAPER, WHOLE)
CASES = [
    pytest.param(model, mode, states, id=f"{model.name}-{mode.name}")
    for model in STEADY
    for mode, states in zip(
        model.modes, (contact_states, cartesian_states, rub_states, rolling_states), strict=False
    )
]
of_models = pytest.mark.parametrize("model", STEADY, ids=lambda model: model.name)
of_cases = pytest.mark.parametrize(("model", "mode", "states"), CASES)


IN_CONTACT = [each for each in CASES if is_contact(each.values[1])]


@pytest.mark.parametrize(("model", "mode", "states"), IN_CONTACT)
def test_a_contact_moves_by_the_equation(model, mode, states):
    """By the chain rule, of z = r e and w = (p + i h/r) e with r = delta0 + q**2, dt = q du; with
    friction, which acts along the ring, h = slip - V r, and where the disc rolls its slip stays 0.
    """
    for state, rotor in states(model):
        rates = dict(zip(mode.state, mode.rates(state, rotor), strict=True))
        q, p = state[:2]
        z, w, down, e = centre(mode, state, rotor)
        r, h = abs(z), (z.conjugate() * w).imag
        r_, e_ = 2.0 * q * rates["q"], complex(rates["c"], rates["s"])
        h_ = rates["slip"] - rotor.rim * r_ if "slip" in rates else rates["h"]
        turning = complex(rates["p"], h_ / r - h * r_ / r**2)
        moved = [r_ * e + r * e_, turning * e + complex(p, h / r) * e_]
        expected = [q * rate for rate in rotating_rates(z, w, down, rotor)]
        if model is WHOLE:
            moved.append(complex(rates["down_r"], rates["down_t"]) * e + down / e * e_)
        np.testing.assert_allclose(moved, expected[: len(moved)], rtol=1e-11, atol=1e-11)
        assert (e.conjugate() * e_).real == pytest.approx(0.0, abs=1e-15 * (1.0 + abs(e_)))
        force, _, approach = normal_force(z, w, rotor)
        assert (rates["t"], rates["j"]) == (q, pytest.approx(q * force, rel=1e-11, abs=1e-12))
        if model is WHOLE:
            work = q * force * approach
            assert rates["work"] == pytest.approx(work, rel=1e-10, abs=1e-10)
        assert mode.pace(state) == q
        assert mode is not ROLLING or rates["slip"] == 0.0


@of_models
def test_directions_off_the_unit_circle_are_drawn_back_and_no_others(model):
    """With n = c**2 + s**2, dn/dt = omega n (1 - n)/5; all else moves as without."""
    mode = model.modes[0]
    directions = [("c", "s")] + [("down_r", "down_t")] * (model is WHOLE)
    with_series = mode.state.index("work") + 1 if model is WHOLE else None
    for state, rotor in contact_states(model):
        plain, drawn = (
            np.array(way(state, rotor)[:with_series]) for way in (mode.rates, mode.drawn_rates)
        )
        np.testing.assert_allclose(drawn, plain, rtol=1e-12, atol=1e-12)
        for names in directions:
            first, last = map(mode.state.index, names)
            longer = list(state)
            longer[first], longer[last] = 1.2 * state[first], 1.2 * state[last]
            plain, drawn = (
                np.array(way(longer, rotor)[:with_series]) for way in (mode.rates, mode.drawn_rates)
            )
            moved = (np.abs(drawn - plain) > 1e-12 * (1.0 + np.abs(plain))).nonzero()[0]
            assert {*moved.tolist()} <= {first, last}
            rate = 2.0 * (longer[first] * drawn[first] + longer[last] * drawn[last]) / state[0]
            assert rate == pytest.approx(0.2 * rotor.omega * 1.44 * (1.0 - 1.44), abs=1e-11)


@of_models
@pytest.mark.parametrize("felt", [0.0, 1.0])
def test_displacement_and_velocity_move_by_the_equation(model, felt):
    mode = model.modes[1]
    for state, rotor in cartesian_states(model, felt=felt):
        z, w, down, _ = centre(mode, state, rotor)
        found = centre(mode, mode.rates(state, rotor), rotor)[:3]
        expected = rotating_rates(z, w, down, rotor)
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-13)


@of_cases
def test_a_neighbour_is_there_and_accelerated_so_to_first_order(model, mode, states):
    """Compare with central differences, in the basis of the neighbouring motion."""
    for state, rotor in states(model, 10):
        z, w, down, e = centre(mode, state, rotor)
        apart = np.random.default_rng(2).normal(size=4)
        turning = mode.neighbour(state, [0.0] * 4, 0.0, rotor).turning
        around = (z.conjugate() * w).imag / abs(z) ** 2
        expected = around if is_contact(mode) else rotor.omega
        assert turning == pytest.approx(expected, rel=1e-12)
        for place in ("position", "velocity", "acceleration"):
            found, true = [], []
            for sign in (STEP, -STEP):
                aside = (sign * apart).tolist()
                near = mode.neighbour(state, aside, aside[0], rotor)
                found.append(complex(*getattr(near, place)))
                there = z + complex(*aside[:2]) * e, w + complex(*aside[2:]) * e
                places = {"position": there[0], "velocity": there[1]}
                places["acceleration"] = acceleration(*there, down, rotor)
                true.append(places[place] / e)
            assert sum(found) / 2.0 == pytest.approx(sum(true) / 2.0, rel=1e-7, abs=1e-7)
            slopes = [(high - low) / (2.0 * STEP) for high, low in (found, true)]
            assert slopes[0] == pytest.approx(slopes[1], rel=1e-6, abs=1e-6), place


@pytest.mark.parametrize(("model", "mode", "states"), IN_CONTACT[1:])
def test_energy_on_the_rotating_axes_is_spent_on_all_losses(model, mode, states):
    """There the unbalance pulls with a constant force, so that no work of it is left:

    d(|z'|**2/2 + kappa |z|**2/2 + gamma y - omega h - omega**2 |z| c + work + heat + spent)/du = 0,
    and the heat is that of ``mu N |v_s|``.
    """
    for state, rotor in states(model):
        named = dict(zip(mode.state, variables(state), strict=True))
        q, p, omega = named["q"], named["p"], rotor.omega
        r = rotor.delta0 + q * q
        h = named["slip"] - rotor.rim * r if "slip" in named else named["h"]
        energy = 0.5 * (p * p + h * h / (r * r)) + 0.5 * rotor.shaft_stiffness * r * r
        energy = energy - rotor.load * named["down_r"] * r - omega * h - omega**2 * r * named["c"]
        total = energy + named["work"] + named["spent"]
        total = total + named["heat"] if "heat" in named else total
        without_series = mode.state.index("spent")
        rates = mode.rates(state, rotor)[:without_series]
        rates = [*rates, *mode.drawn_rates(state, rotor)[without_series:]]
        parts = np.abs(np.array(total.parts) * rates)
        assert np.dot(total.parts, rates) == pytest.approx(0.0, abs=1e-12 * (1.0 + parts.max()))
        if "heat" in named:
            z, w, _, _ = centre(mode, state, rotor)
            slip_speed = (z.conjugate() * w).imag / abs(z) + rotor.rim
            # the damped force of a random state may be tensile
            heat = rotor.friction * abs(rotor.sigma * slip_speed) * normal_force(z, w, rotor)[0]
            assert rates[-1] == pytest.approx(state[0] * heat, rel=1e-9, abs=1e-11)


def test_grip_and_hold_are_mu_n_and_the_force_of_rolling():
    for state, rotor in rolling_states(WHOLE):
        z, w, down, _ = centre(ROLLING, state, rotor)
        grip, hold = grip_and_hold(state, rotor)
        assert grip == pytest.approx(rotor.friction * normal_force(z, w, rotor)[0], rel=1e-11)
        assert hold == pytest.approx(tangential_force(z, w, down, rotor), rel=1e-10, abs=1e-10)
