"""Touches that fade: what is taken for such a motion is one, and what leaves the ring is not."""

import cmath
import math

import numpy as np
import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.basins.fates import Batch, decide
from rotor_ida.basins.kernel import CONTACT_FREE
from rotor_ida.basins.known import MOST_DRIFT, contact_free_whirls, known_from_closed_forms
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc
from tests.basins.lanes import GO_ON, followed

ROTORS = [
    Rotor(omega=2.0, zeta=0.07, delta0=2.0),
    Rotor(omega=0.5, zeta=0.07, delta0=2.0),
    Rotor(omega=1.0, zeta=1.0, delta0=3.0),
    Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_exponent=1.0),
]


@pytest.mark.parametrize("rotor", ROTORS)
def test_motions_from_the_rim_touch_for_ever(rotor):
    """By CVODE, from other states than those by which the excess was found."""
    found = contact_free_whirls(rotor, GO_ON, fading=True)
    whirl, room, excess = found.whirl, found.room, found.excess
    assert excess > 0.0
    for angle in (0.3, 2.0, 4.4):
        end = cmath.rect(room + excess, angle)
        drift = cmath.rect(0.99 * MOST_DRIFT * excess, angle + 0.5 * math.pi)
        position = end - drift + whirl
        velocity = 1j * rotor.omega * whirl + 2.0 * rotor.zeta * drift
        start = (position.real, position.imag, velocity.real, velocity.imag)
        settled = settle_disc(rotor, start, Options(rtol=1e-10))
        assert settled.kind == "touching"
        assert settled.features.radius_max == pytest.approx(rotor.delta0, abs=excess)


def test_there_is_none_where_nothing_turns_or_fits_or_a_drift_takes_too_long():
    assert contact_free_whirls(Rotor(omega=1.7, zeta=0.07, delta0=0.5), GO_ON, fading=True) is None
    for omega, zeta in ((0.0, 0.1), (1.0, 1e-8)):
        rotor = Rotor(omega=omega, zeta=zeta, delta0=2.0)
        found = contact_free_whirls(rotor, GO_ON, fading=True)
        assert found.excess == 0.0
        assert found.row["room"] > 0.0 > found.row["fading"]


@pytest.mark.parametrize(
    ("omega", "zeta", "kappa"),
    [(3.0, 0.1, 1.0), (0.5, 0.1, 0.005), (0.8, 0.6, 0.04), (0.8, 0.2, 0.04), (0.0, 0.1, 1.0)],
)
def test_what_a_shaft_holds_inside_never_touches_again(omega, zeta, kappa):
    """Beside little and much damping, at the critical one, and at rest; by CVODE."""
    rotor = Rotor(omega=omega, zeta=zeta, delta0=1.5, shaft_stiffness=kappa)
    free = contact_free_whirls(rotor, GO_ON, fading=True)
    random = np.random.default_rng(3)
    off, moving = (random.normal(size=400) + 1j * random.normal(size=400) for _ in range(2))
    position = free.whirl + 0.5 * free.room * off
    velocity = 1j * omega * free.whirl + 0.5 * free.room * max(zeta, math.sqrt(kappa)) * moving
    states = np.stack([position.real, position.imag, velocity.real, velocity.imag])
    _, labels, _ = followed(rotor, states, 1e-9, 1e-6, free.row)
    held = np.flatnonzero(labels == 0)
    assert held.size > 20
    for number in held[:40].tolist():
        found = simulate(rotor, start=states[:, number], duration=30.0 / zeta, samples=2)
        assert found.sizes["event"] == 0


def test_the_rule_for_a_soft_shaft_goes_over_into_that_of_none():
    """In the time that is looked at, a shaft of 1e-9 draws nothing back."""
    random, states = np.random.default_rng(4), np.empty((4, 2000))
    states[:2] = random.uniform(-2.0, 2.0, (2, 2000))
    states[2:] = random.normal(0.0, 0.5, (2, 2000))
    labels_of = []
    for beyond in ({}, {"shaft_stiffness": 1e-9}):
        rotor = Rotor(omega=0.5, zeta=0.2, delta0=2.0, **beyond)
        free = contact_free_whirls(rotor, GO_ON, fading=False)
        whirl = np.array(((free.whirl.real, free.whirl.imag), free.room**2, -1.0), CONTACT_FREE)
        labels_of.append(followed(rotor, states, 1e-9, 1e-6, whirl)[1])
    assert (labels_of[0] == 0).sum() > 100
    # where the whirl itself moves by 1e-8 a state on the border may change sides
    assert (labels_of[0] != labels_of[1]).sum() <= 1


def test_touches_that_fade_are_held_on_the_rim_with_friction_too():
    """Elsewhere errors of many steps would carry them inside, to whirls that never touch."""
    rotor = Rotor(
        omega=2.972, zeta=0.28, delta0=1.0, contact_exponent=1.0, friction=0.026, disc_radius=20.0
    )
    starts = np.random.default_rng(0).uniform(-6.0, 6.0, (4, 40))
    known = known_from_closed_forms(rotor, GO_ON)
    labels = decide(Batch(known, starts, 1e-6, GO_ON)).labels
    alone = [
        settle_disc(rotor, tuple(each), Options(method="taylor", rtol=1e-11)).kind
        for each in starts.T.tolist()
    ]
    fades = np.array([each == "touching" for each in alone])
    assert fades.sum() > 4
    assert (labels[fades] == known.fading_label).all()
    assert (labels[~fades] == known.free_label).all()
