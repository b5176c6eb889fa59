"""Friction: a contact in which surfaces slide, reverse, and in which the disc rolls on the ring."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotor_ida import Rotor, simulate
from rotor_ida.equations import modes
from rotor_ida.errors import InvariantError
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import check_orbit
from rotor_ida.simulation.run import run
from tests.witness import rub_hold, rub_slip, rubbed

START = (0.3, 0.1, 0.2, 0.1)
WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
ALL = Rotor(
    omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.2, contact_exponent=1.0,
    contact_damping=2.0, load=1.5, friction=0.4, disc_radius=0.5,
)  # fmt: skip
# Rotor, start, duration, and the kinds of event that each shows.
MACHINES = {
    "rub that slides forwards": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.1, disc_radius=10.0),
        START, 30.0, {1, -1},
    ),
    "dry whip": (WHIP, (5.0, 0.0, 0.0, -6.3), 40.0, {2, -2}),
    "small disc, that chatters": (
        Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6),
        START, 30.0, {1, -1, 2, -2, 3},
    ),
    "disc of no radius": (
        Rotor(omega=1.2, zeta=0.02, delta0=0.5, friction=0.2, disc_radius=0.0),
        (0.8, 0.1, 0.2, -0.5), 30.0, {1, -1, 2, -2, 3},
    ),
    "free vibration under a load": (
        Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=0.3, disc_radius=5.0),
        (-1.2, -0.4, 0.3, -0.8), 30.0, {1, -1, 2, -2},
    ),
    "slow, under a load": (
        Rotor(omega=0.2, zeta=0.02, delta0=1.0, load=0.5, friction=0.2, disc_radius=3.0),
        (-0.2, -0.4, 0.3, -0.8), 60.0, {1, -1, 2, -2},
    ),
    "shaft and linear contact": (
        Rotor(omega=0.9, zeta=0.05, delta0=1.0, shaft_stiffness=0.3, contact_exponent=1.0,
              friction=0.4, disc_radius=1.5),
        (0.3, 0.1, 1.2, -0.8), 30.0, {1, -1, 2, -2, 3},
    ),
    "contact damping": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=3.0, friction=0.3,
              disc_radius=1.0),
        START, 20.0, {1, -1, -4},
    ),
    "all of it": (ALL, START, 20.0, {1, -1, 3, 4, -4}),
    "rough ring": (
        Rotor(omega=0.5, zeta=0.1, delta0=1.0, friction=2.0, disc_radius=4.0),
        START, 20.0, {1, 2},
    ),
    "start that rolls": (
        Rotor(omega=0.5, zeta=0.05, delta0=1.0, friction=0.5, disc_radius=4.0),
        (1.8, 0.0, 0.1, -2.0), 20.0, {2, -2},
    ),
    "start that is loose": (
        Rotor(omega=0.5, zeta=0.05, delta0=1.0, contact_damping=2.0, load=0.4, friction=0.5,
              disc_radius=2.0),
        (0.0, -1.4, 0.2, 0.8), 20.0, {1, -1, 2, -2, 4, -4},
    ),
}  # fmt: skip
WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-13, "atol": 1e-15},
    "adams": {"method": "adams", "rtol": 1e-13, "atol": 1e-15},
    "bdf, flight integrated": {"method": "bdf", "rtol": 1e-12, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-12, "atol": 1e-14},
}


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    rotor, start, duration, kinds = MACHINES[request.param]
    events, end = rubbed(rotor, start, duration)
    assert {kind for _, kind in events} == kinds
    return rotor, start, duration, events, end


@pytest.mark.parametrize("way", WAYS)
def test_events_are_those_of_another_integrator(machine, way):
    """SciPy's DOP853, restarted at each event; it rolls in polar coordinates."""
    rotor, start, duration, events, end = machine
    found = simulate(rotor, start=start, duration=duration, samples=2, **WAYS[way])
    assert found.event_kind.values.tolist() == [kind for _, kind in events]
    apart = np.abs(found.event_time.values - [time for time, _ in events])
    assert apart.max() < 1e-9
    # the witness's own error is below 1e-11
    assert (apart <= found.event_time_error.values + 1e-11).all()
    assert found.event_time_error.values.max() < 1e-8
    last = [found[name].values[-1] for name in ("x", "y", "vx", "vy")]
    np.testing.assert_allclose(last, end, rtol=0, atol=2e-9)


def test_the_whip_rolls_as_often_as_was_derived():
    """DESIGN section 3: 38 rolls in 120 time units."""
    found = simulate(WHIP, start=(5.0, 0.0, 0.0, -6.3), duration=120.0, method="taylor")
    assert (found.event_kind.values == 2).sum() == 38


def steady(rim, **more):
    """A machine of DESIGN section 3 without unbalance, as `equations` can be asked for it."""
    return SimpleNamespace(
        omega=0.0, zeta=0.1, delta0=1.0, shaft_stiffness=0.0, contact_damping=0.0, load=0.0,
        hertz=1.0, linear=0.0, pressed=1.0, friction=0.2, rim=rim, **more,
    )  # fmt: skip


def test_without_unbalance_whip_and_saddle_are_where_they_were_derived():
    """zeta 0.1, mu 0.2, delta0 1, rho 10: a slipping whirl at -1 with r 3.147899036, born as
    rolling whip at omega 0.314789904; at twice that the whip has r 4.984177749."""
    slipping, born, whip = 3.147899036, 0.314789904, 4.984177749
    saddle = steady(10.0 * born + 0.5, sigma=1.0)
    slip = slipping * (saddle.rim - slipping)
    state = [np.sqrt(slipping - 1.0), 0.0, slip, 1.0, 0.0, 0.0, 0.0]
    rates = modes.rub_rates(state, saddle)
    assert np.abs(rates[1:3]).max() < 1e-7
    for radius, rim in ((slipping, 10.0 * born), (whip, 20.0 * born)):
        state = [np.sqrt(radius - 1.0), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        assert abs(modes.rolling_rates(state, steady(rim, sigma=0.0))[1]) < 1e-7
        grip, hold = modes.grip_and_hold(state, steady(rim, sigma=0.0))
        assert abs(hold) <= grip + 1e-8
        assert (abs(abs(hold) - grip) < 1e-8) == (radius == slipping)


def smoothed(rotor, start, duration, width):
    """Friction in proportion to tanh(v_s/width)."""
    rim = rotor.disc_radius * rotor.omega

    def rates(time, state):
        z, v = complex(*state[:2]), complex(*state[2:])
        radius = abs(z)
        slip = (z.conjugate() * v).imag / radius + rim
        normal = max(radius - rotor.delta0, 0.0) ** 1.5
        push = normal * (1.0 + 1j * rotor.friction * np.tanh(slip / width)) * z / radius
        a = rotor.omega**2 * np.exp(1j * rotor.omega * time) - 2.0 * rotor.zeta * v - push
        return [v.real, v.imag, a.real, a.imag]

    found = solve_ivp(rates, (0.0, duration), start, method="LSODA", rtol=1e-10, atol=1e-11)
    return found.y[:, -1]


def test_smoothed_friction_comes_nearer_in_proportion_to_its_width():
    """The third witness: with tanh(v_s/eps) for sign(v_s), eps from 1e-2 to 1e-4, the difference
    falls with an order of 0.85 to 1.05, through five rolls and as many slips."""
    start, duration = (5.0, 0.0, 0.0, -6.3), 16.0
    exact = simulate(WHIP, start=start, duration=duration, samples=2, method="taylor")
    assert (exact.event_kind.values == 2).sum() >= 5
    end = np.array([exact[name].values[-1] for name in ("x", "y", "vx", "vy")])
    widths = np.array([1e-2, 1e-3, 1e-4])
    apart = [np.linalg.norm(smoothed(WHIP, start, duration, each) - end) for each in widths]
    orders = np.diff(np.log(apart)) / np.diff(np.log(widths))
    assert (orders > 0.85).all()
    assert (orders < 1.05).all()


# ---- Grazes ----


def kinds_of(rotor, start, duration, rtol, method="taylor"):
    how = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
    return run(rotor, start, duration, np.array([0.0, duration]), how).event_kinds.tolist()


def border(family, low, high, start, duration):
    """Two parameters a rounding apart between which the events change, and those of each."""
    few = kinds_of(family(low), start, duration, 1e-14)
    more = kinds_of(family(high), start, duration, 1e-14)
    assert few != more
    while high - low > 1e-13 * high:
        middle = 0.5 * (low + high)
        found = kinds_of(family(middle), start, duration, 1e-14)
        low, high, more = (middle, high, more) if found == few else (low, middle, found)
    return low, high, few, more
