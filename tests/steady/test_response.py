"""The kinds of response that a single window tells, of motions made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.closed_forms import touch_fading
from rotor_ida.core.runs import CONTACT, EXTREMUM
from rotor_ida.schema.flags import ENTRY, EXIT
from rotor_ida.simulation.flow import DiscFlow, Window
from rotor_ida.steady.decision import Decision
from rotor_ida.steady.follow import features_of_disc
from rotor_ida.steady.response import (
    BOUNCING,
    phase_lag_of,
    rolls_backwards,
    touches_fade,
    touches_grow_slighter,
)

OMEGA = 2.0
TIMES = np.linspace(0.0, 8.0 * np.pi, 1601)
ROTOR = Rotor(omega=OMEGA, zeta=0.07, delta0=1.0)


def seen(rotor, times, states, contacts=None, *, touches=0, in_contact=False, rolling=()):
    """Return a window of one disc."""
    closed, events = np.array([in_contact]), np.arange(touches)
    return Window(
        DiscFlow(rotor), states[0], states[-1], times, states, closed, closed,
        events.astype(float), np.where(events % 2, EXIT, ENTRY), 0 * events,
        [np.array(rolling, dtype=float).reshape(-1, 2)],
        np.empty(0, CONTACT) if contacts is None else contacts,
    )  # fmt: skip


def window(position, rotor=ROTOR, contacts=None, *, in_contact=False):
    """Return a window on the rotating axes, from a motion on the fixed ones."""
    velocity = np.gradient(position, TIMES, edge_order=2)
    turn = np.exp(-1j * rotor.omega * TIMES)
    x, v = position * turn, velocity * turn
    states = np.stack([x.real, x.imag, v.real, v.imag], axis=-1)
    touches = 0 if contacts is None else 2 * len(contacts)
    return seen(rotor, TIMES, states, contacts, touches=touches, in_contact=in_contact)


def test_extreme_radii_of_a_cycle_are_those_of_its_last_period():
    """Those of an earlier part were larger; between samples the extrema of the run count."""
    radius = 1.5 + 0.25 * np.cos(OMEGA * TIMES) * np.where(TIMES < 10.0, 2.0, 1.0)
    extrema = np.zeros(2, EXTREMUM)
    extrema["time"], extrema["radius"] = [9.0, TIMES[-1] - 1.0], [9.0, 1.8]
    motion = replace(window(radius * np.exp(1j * OMEGA * TIMES)), extrema=extrema)
    features = features_of_disc(motion, Decision(BOUNCING, period=math.pi))
    assert features.radius_min == pytest.approx(1.25, rel=1e-12)
    assert features.radius_max == 1.8
    assert features.period == math.pi


def test_a_phase_lag_that_no_double_holds_is_none():
    assert phase_lag_of(complex(1e3, -5e-324)) == 0.0


FADING = Rotor(omega=OMEGA, zeta=0.07, delta0=2.0)
LAW = touch_fading(FADING)


def touches(growth, revolutions=1.0, first=1e-3, count=6):
    """Return contacts whose 1/h grows by so much, in parts of the law, from one to the next."""
    depth = 1.0 / (1.0 / first + growth * LAW * np.arange(count))
    peak = 1.0 + revolutions * np.pi * np.arange(count)
    contacts = np.zeros(count, CONTACT)
    contacts["entry"], contacts["peak_time"], contacts["exit"] = peak - 0.05, peak, peak + 0.05
    contacts["peak_root"] = np.sqrt(depth)
    return contacts


@pytest.mark.parametrize(
    ("growth", "revolutions", "fades"),
    [
        (1.0, 1.0, True),
        (1.08, 1.0, True),
        (1.12, 1.0, False),
        (0.88, 1.0, False),
        (0.0, 1.0, False),
        (1.0, 0.5, False),
        (1.0, 2.0, False),
    ],
)
def test_touches_fade_where_they_follow_the_law_once_a_revolution(growth, revolutions, fades):
    still = 0.9 * np.exp(1j * OMEGA * TIMES)
    assert touches_fade(window(still, FADING, touches(growth, revolutions))) is fades


@pytest.mark.parametrize(
    ("growth", "revolutions", "slighter"),
    [(1.0, 1.0, True), (0.1, 1.0, True), (0.0, 1.0, False), (-0.1, 1.0, False), (0.1, 2.0, False)],
)
def test_touches_grow_slighter_by_any_law(growth, revolutions, slighter):
    still = 0.9 * np.exp(1j * OMEGA * TIMES)
    table = touches(growth, revolutions)
    assert touches_grow_slighter(window(still, FADING, table)) is slighter


def test_two_touches_are_too_few_and_one_off_the_law_is_enough_to_deny_it():
    still = 0.9 * np.exp(1j * OMEGA * TIMES)
    assert not touches_fade(window(still, FADING, touches(1.0, count=2)))
    table = touches(1.0)
    table["peak_root"][3] *= 1.01**0.5
    assert not touches_fade(window(still, FADING, table))


def test_a_contact_cut_off_by_the_window_does_not_count():
    still = 0.9 * np.exp(1j * OMEGA * TIMES)
    table = touches(1.0)
    table["entry"][0], table["peak_root"][0] = np.nan, 1e-7**0.5
    assert touches_fade(window(still, FADING, table))


def rolling_window(rolling, *, whirl=-1.0, touches=0):
    """Three revolutions at constant radius, rolling for the stretches given."""
    times = np.linspace(0.0, 6.0 * math.pi, 193)
    z = 2.0 * np.exp(1j * (whirl - 1.0) * times)
    states = np.column_stack([z.real, z.imag, (1j * whirl * z).real, (1j * whirl * z).imag])
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=2.0)
    return seen(rotor, times, states, touches=touches, in_contact=True, rolling=rolling)


EACH = [(1.0, 1.5), (7.0, 8.0), (13.0, 18.0)]


@pytest.mark.parametrize(
    ("motion", "period", "whips"),
    [
        (rolling_window(EACH), None, True),
        (rolling_window([(0.0, 6.0 * math.pi)]), 1.3, True),
        (rolling_window(EACH, whirl=0.5), None, False),
        (rolling_window(EACH, touches=2), None, False),
        (rolling_window(EACH[:2]), None, False),
        (rolling_window(EACH), math.pi, False),
        (rolling_window([]), None, False),
    ],
)
def test_it_is_whip_only_if_it_rolls_backwards_in_every_period(motion, period, whips):
    assert rolls_backwards(motion, period) is whips
