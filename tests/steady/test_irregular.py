"""Motions that never repeat themselves: touches that fade, tori and chaos."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, lyapunov_exponent, simulate, sweep
from rotor_ida.closed_forms import touch_fading
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady import motion
from rotor_ida.steady.decision import decide
from rotor_ida.steady.follow import LATE, limits_of, settle_disc
from rotor_ida.steady.motion import Motion
from tests.steady.following import LOADED, followed, of_paper

TAYLOR = Options(method="taylor")


# ---- Touches that fade ----


@pytest.mark.parametrize("omega", [0.5, 2.28, 2.94])
def test_ever_slighter_touches_lead_to_a_contact_free_whirl(omega):
    settled = of_paper(omega, 2.0)
    assert settled.kind == "touching"
    assert sum(each.times.size for each in settled.motion.events) > 50
    assert 0.0 < settled.features.radius_max - 2.0 < 2e-3
    assert math.isnan(settled.features.period)


def test_touches_of_a_linear_contact_fade_by_their_own_law():
    """1/sqrt(h) grows by sqrt(2/kappa)/(3 zeta) from touch to touch."""
    for omega, damping in ((0.5, 0.0), (2.28, 0.5), (2.94, 0.0)):
        machine = Rotor(
            omega=omega, zeta=0.07, delta0=2.0, contact_exponent=1.0, contact_damping=damping
        )
        whirl = complex(complex_amplitude(omega, 0.07))
        start, velocity = whirl + 2.0 - abs(whirl) + 1e-6, 1j * omega * whirl
        run = simulate(
            machine, start=(start.real, start.imag, velocity.real, velocity.imag),
            duration=2500.0, samples=2, method="taylor",
        )  # fmt: skip
        growth = np.diff(run.peak_indentation.values[-40:] ** -0.5)
        assert growth.mean() == pytest.approx(touch_fading(machine), rel=0.02)


def test_touches_fade_by_the_law_that_friction_leaves_as_it_is():
    """Friction carries the centre along the ring: 1/h grows as without, ever more closely."""
    rotor = Rotor(omega=1.6, zeta=0.2, delta0=1.4, friction=0.35, disc_radius=1.0)
    settled = settle_disc(rotor, (3.4, -0.3, -0.4, -0.4), TAYLOR)
    assert settled.kind == "touching"
    run = simulate(rotor, start=(3.4, -0.3, -0.4, -0.4), duration=4000.0, method="taylor")
    growth = np.diff(1.0 / run.peak_indentation.values)
    off = np.abs(growth / touch_fading(rotor) - 1.0)
    assert off[-20:].max() < 0.01
    assert off[-20:].max() < 0.5 * off[20:40].max()


# ---- Tori and chaos ----


@pytest.mark.parametrize(
    ("omega", "delta0", "start", "exponent"),
    [(1.38, 1.0, (1.5, -0.25, 0.0, 0.0), 0.0362), (1.69, 2.0, (3.0, 1.0, 0.0, 0.0), 0.0083)],
)
def test_known_chaos_is_chaotic_with_the_known_exponent(omega, delta0, start, exponent):
    """From DESIGN, section 9; an orbit of its own within the error that it states."""
    settled = of_paper(omega, delta0, start)
    assert settled.kind == "chaotic"
    seen, error = settled.features.lyapunov_exponent, settled.features.lyapunov_error
    assert seen > 5.0 * error
    assert abs(seen - exponent) < 4.0 * error
    assert math.isnan(settled.features.period)


def test_exponents_are_stated_only_where_they_were_asked_for():
    assert math.isnan(of_paper(2.0, 2.0).features.lyapunov_exponent)


def test_touches_that_fade_slowly_are_not_asked_for_chaos(monkeypatch):
    """Of a fast rotor they follow the law only after 3,000: an exponent takes far longer."""
    monkeypatch.setattr(motion, "exponents_of", None)  # called, it would raise
    settled = of_paper(100.0, 1.0, (3.0, 0.0, 0.0, 0.0), zeta=1.0, options=Options(method="taylor"))
    assert settled.kind == "touching"
    assert settled.motion.time > LATE


def test_a_cycle_without_load_becomes_a_torus_under_a_slight_one():
    """Its period, 4.5639, is no whole number of revolutions; its radii are those of DESIGN."""
    beyond = []
    for load in (0.02, 0.01):
        settled = followed(Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=load))
        assert settled.kind == "quasi_periodic"
        assert math.isnan(settled.features.period)
        assert abs(settled.features.lyapunov_exponent) < 1e-6
        beyond.append(settled.features.radius_max - 4.104416607)
    assert 0.0 < beyond[1] < 0.02
    assert beyond[0] / beyond[1] == pytest.approx(2.0, rel=0.1)


def test_friction_makes_tori_without_a_load():
    """Where a pair of multipliers has crossed the unit circle the motion never repeats itself.

    Two exponents are zero, and the others below.
    """
    rotor = Rotor(
        omega=2.37, zeta=0.02, delta0=1.0, contact_exponent=1.0, friction=0.05, disc_radius=5.0
    )
    near = np.array([0.157, 1.116, 0.906, -4.344])
    found = sweep(
        omega=2.37, zeta=0.02, delta0=1.0, contact_exponent=1.0, friction=0.05, disc_radius=5.0,
        starts=[near], method="taylor",
    ).squeeze()  # fmt: skip
    assert found.response == RESPONSE["quasi_periodic"]
    assert np.isnan(found.period)
    exponents = lyapunov_exponent(rotor, start=near, transient=2000.0, duration=3000.0)
    first, second, third, _ = exponents.lyapunov_exponent.values
    assert abs(first) < 1e-4
    assert abs(second) < 1e-4
    assert third < -2e-3


def test_exponents_of_a_cycle_under_a_load_are_those_of_its_multipliers():
    """Spans of an exponent end anywhere in a revolution: the load must be where it then is."""
    rotor, count = LOADED["three times"]
    state = followed(rotor).motion.state
    period = count * 2.0 * math.pi / rotor.omega
    multipliers = np.linalg.eigvals(DiscFlow(rotor).run(np.array(state), period).tangents)
    expected = np.sort(np.log(np.abs(multipliers)))[::-1] / period
    found = lyapunov_exponent(rotor, start=state, transient=300.0, duration=6000.0)
    np.testing.assert_allclose(found.lyapunov_exponent, expected, atol=2e-4)
    assert expected.sum() == pytest.approx(-4.0 * rotor.zeta, rel=1e-9)
    assert expected[0] < -0.005


def test_chaos_under_a_load_is_told_with_its_exponent():
    rotor = Rotor(omega=1.5, zeta=0.05, delta0=1.0, shaft_stiffness=0.05, load=0.6)
    settled = followed(rotor)
    assert settled.kind == "chaotic"
    exponent, error = settled.features.lyapunov_exponent, settled.features.lyapunov_error
    assert exponent > 5.0 * error
    found = lyapunov_exponent(rotor, start=(0.5, 0.0, 0.0, 0.3), duration=10_000.0)
    other, its_error = (float(found[f"lyapunov_{each}"][0]) for each in ("exponent", "error"))
    assert abs(exponent - other) < 4.0 * math.hypot(error, its_error)


def test_a_torus_is_one_only_where_the_motion_lasts():
    """A free vibration that dies out is another motion later; the whirl that is left lasts."""
    rotor = Rotor(omega=1.7, zeta=0.05, delta0=50.0, shaft_stiffness=0.25)
    flow = DiscFlow(rotor)
    motion = Motion(flow, limits_of(flow), np.array([20.0, 0.0, 0.0, 0.0]))
    motion.observe(1)
    assert not motion.lasts(1000.0)
    assert motion.time > 1000.0  # it goes on from there
    motion.observe(1)
    state, time, events = motion.state, motion.time, len(motion.events)
    assert motion.lasts(1000.0)
    assert (motion.state is state, motion.time, len(motion.events)) == (True, time, events)


def test_zero_exponents_of_a_later_motion_make_no_torus(monkeypatch):
    """What is called a torus while it dies out is decided anew from where it has come."""
    flow = DiscFlow(Rotor(omega=1.7, zeta=0.05, delta0=50.0, shaft_stiffness=0.25))
    zero = motion.Exponents(np.zeros(1), np.zeros(1), duration=1000.0, zeros=1)
    monkeypatch.setattr(Motion, "exponents", lambda _: zero)
    monkeypatch.setattr(Motion, "may_be_chaotic", lambda *_: True)
    # the first window comes before the free vibration has died out
    limits = limits_of(flow)._replace(wait=1.0, longest=10.0)
    assert decide(Motion(flow, limits, np.array([20.0, 0.0, 0.0, 0.0]))).kind == "contact_free"
