"""Every kind of response, of simulated motions, with the numbers that are known of them."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, folds
from rotor_ida.simulation.options import Options
from rotor_ida.steady import follow
from rotor_ida.steady.follow import follow_to_steady_state

REST = (0.0, 0.0, 0.0, 0.0)


def followed(omega, delta0, start=REST, zeta=0.07, options=None, **settings):
    rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
    return follow_to_steady_state(rotor, start, options or Options(), **settings)


@pytest.mark.parametrize(
    ("omega", "delta0", "kind"),
    [(1.7, 0.0, "synchronous"), (1.2, 0.5, "synchronous"), (0.9, 2.0, "contact_free")],
)
def test_whirls_from_rest(omega, delta0, kind):
    settled = followed(omega, delta0)
    assert settled.response == kind
    assert math.isnan(settled.features.period)


KNOWN = {
    (2.0, 2.0): ("bouncing", 4.563916675380, 4.104416607),
    (3.0, 0.5): ("full_contact", 3.115214254929, 3.000222126),
}


@pytest.mark.parametrize("flight", ["exact", "cvode"])
@pytest.mark.parametrize(("omega", "delta0"), KNOWN)
def test_periods_and_radii_of_known_cycles(omega, delta0, flight):
    """To nine digits and more; two programs that share nothing agree on them."""
    kind, period, radius_max = KNOWN[omega, delta0]
    settled = followed(omega, delta0, options=Options(flight=flight))
    assert settled.response == kind
    assert settled.features.period == pytest.approx(period, rel=1e-10)
    # the reference has ten digits
    assert settled.features.radius_max == pytest.approx(radius_max, rel=2e-10)


def test_the_error_of_a_period_falls_with_the_tolerance():
    tolerances = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10]
    several = [Options(rtol=rtol, atol=rtol) for rtol in tolerances]
    periods = [followed(2.0, 2.0, options=each).features.period for each in several]
    errors = np.abs(np.array(periods) - 4.563916675380)
    # single errors scatter, so the order is that of a line through six
    assert 0.5 < np.polyfit(np.log(tolerances), np.log(errors), 1)[0] < 1.5


def test_methods_agree_on_a_cycle():
    one, other = (followed(2.0, 2.0, options=Options(method=each)) for each in ("bdf", "taylor"))
    for name in ("period", "radius_min", "radius_max"):
        assert getattr(one.features, name) == pytest.approx(getattr(other.features, name), rel=1e-9)


def test_a_doubled_cycle_has_twice_the_period():
    """At omega 1.6 the transient alternates for long; the cycle that is left does not."""
    settled = followed(1.6, 1.0)
    assert settled.response == "bouncing"
    assert settled.features.period == pytest.approx(7.6498386845, rel=1e-9)
    assert settled.window_end > 1500.0


def test_a_cycle_through_many_turns_of_the_radius():
    """Six maxima of the radius in a period: more than two periods of the first window."""
    settled = followed(1.5, 1.0)
    assert settled.response == "bouncing"
    assert settled.features.period == pytest.approx(16.3517990473, rel=1e-9)


@pytest.mark.parametrize("omega", [0.5, 2.28, 2.94])
def test_ever_slighter_touches_lead_to_a_contact_free_whirl(omega):
    settled = followed(omega, 2.0)
    assert settled.response == "touching"
    assert settled.event_times.size > 50
    assert 0.0 < settled.features.radius_max - 2.0 < 2e-3
    assert math.isnan(settled.features.period)


def test_touches_that_are_slight_from_the_start_are_touching_too():
    """The indentation falls from 1.8e-4 at t = 300 only to 1.3e-4 at 1000."""
    start = (1.369616873214543, -2.302132862361297, -4.590264760638053, -4.834723644714709)
    settled = followed(1.25, 2.0, start)
    assert settled.response == "touching"
    assert 0.0 < settled.features.radius_max - 2.0 < 2e-4


@pytest.mark.parametrize(
    ("omega", "delta0", "start", "exponent"),
    [(1.38, 1.0, (1.5, -0.25, 0.0, 0.0), 0.0362), (1.69, 2.0, (3.0, 1.0, 0.0, 0.0), 0.0083)],
)
def test_known_chaos_is_chaotic_with_the_known_exponent(omega, delta0, start, exponent):
    """From DESIGN, section 9; an orbit of its own within the error that it states."""
    settled = followed(omega, delta0, start)
    assert settled.response == "chaotic"
    seen, error = settled.features.lyapunov_exponent, settled.features.lyapunov_error
    assert seen > 5.0 * error
    assert abs(seen - exponent) < 4.0 * error
    assert math.isnan(settled.features.period)


def test_exponents_are_stated_only_where_they_were_asked_for():
    assert math.isnan(followed(2.0, 2.0).features.lyapunov_exponent)


def test_touches_that_fade_slowly_are_not_asked_for_chaos(monkeypatch):
    """Of a fast rotor they follow the law only after 3,000: an exponent takes far longer."""
    monkeypatch.setattr(follow, "exponents_of", None)  # called, it would raise
    settled = followed(100.0, 1.0, (3.0, 0.0, 0.0, 0.0), zeta=1.0, options=Options(method="taylor"))
    assert settled.response == "touching"
    assert settled.window_end > follow.LATE


def test_a_rotor_that_does_not_turn_comes_to_rest_within_its_clearance():
    assert followed(0.0, 1.0, (1.5, 0, 0, 0.3), zeta=0.3).response == "contact_free"
    creeping = followed(0.0, 1.0, (1.0 + 1e-8, 0, 0, 0), zeta=1.0, longest=1000.0)
    assert creeping.response == "unresolved"


def test_the_ghost_of_a_fold_is_no_response():
    """Just above the upper fold only the small whirl exists; the rotor creeps where it was."""
    fold = folds(zeta=0.07, delta0=0.0).isel(zeta=0, delta0=0, fold=1)
    omega, amplitude = fold.fold_omega.item() + 1e-7, fold.fold_amplitude.item()
    lag = math.asin(2.0 * 0.07 * amplitude / omega)
    z = amplitude * np.exp(-1j * (math.pi - lag))
    v = 1j * omega * z
    start = (z.real, z.imag, v.real, v.imag)
    assert followed(omega, 0.0, start, longest=500.0).response == "unresolved"


@pytest.mark.parametrize(("omega", "delta0"), [(0.0, 0.0), (1.0, 0.5), (1.5, 2.0)])
def test_without_damping_nothing_settles_and_nothing_is_followed_for_long(omega, delta0):
    free = followed(omega, delta0, (1.0, 0, 0, 0.3), zeta=0.0)
    assert free.response == "unresolved"
    assert free.window_end < 2100.0


def test_the_longest_time_is_kept():
    settled = followed(1.38, 1.0, (1.5, -0.25, 0, 0), longest=1000.0)
    assert settled.response == "unresolved"
    assert settled.window_end < 1100.0


def test_a_run_that_is_asked_to_stop_has_failed():
    settled = followed(2.0, 2.0, stop=np.ones(1, np.uint8))
    assert settled.response == "failed"
    assert "interrupted" in settled.message
    assert math.isnan(settled.features.amplitude)
