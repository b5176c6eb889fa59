"""Fits of simulated measurements, whose truth is known."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom, chi2

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    dimensional,
    fit,
    run_up,
    signals_of,
    simulate,
)
from rotor_ida.errors import BudgetError
from rotor_ida.fitting.arguments import problem_of
from rotor_ida.fitting.fit import _least, _with_stiffness
from rotor_ida.fitting.trials import MOST_TRIALS, Unknown
from rotor_ida.plot.fits import _estimates_in_words
from rotor_ida.signals.teeth import teeth_in

TRUE = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
GUESS = Rotor(omega=0.3, zeta=0.08, delta0=1.8, shaft_stiffness=0.9)
SOUGHT = ("zeta", "delta0", "shaft_stiffness")
TRUTH = np.array([0.1, 1.5, 1.0])
NOISE, TIME_ERROR = 0.02, 0.01
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5, clearance=2e-5, speed=20.0,
    shaft_stiffness=4e4,
)  # fmt: skip


@pytest.fixture(scope="module")
def up():
    return run_up(TRUE, start=(0, 0, 0, 0), to=2.0, rate=0.02, samples=2501)


def noisy(signals, rng, noise=NOISE):
    size = signals.sizes["t"]
    return signals.assign(
        {
            name: signals[name].copy(data=signals[name].values + rng.normal(0.0, noise, size))
            for name in "xy"
        }
    )


def in_si(machine, to=250.0, rate=15.0, samples=12_001):
    return dimensional(run_up(machine, to=to, rate=rate, samples=samples), units={"length": "µm"})


def test_a_contact_time_without_a_partner_is_said_and_left_out(up):
    """The rotor stays on the ring after its first contact: no other comes near."""
    entry = up.event_time.values[up.event_kind.values == 1][0]
    seen = noisy(signals_of(up), np.random.default_rng(2))
    found = fit(seen, GUESS, SOUGHT, entries=[entry, entry + 20.0], time_error=TIME_ERROR)
    np.testing.assert_array_equal(np.isnan(found.fitted_time), [False, True])
    without = fit(seen, GUESS, SOUGHT, entries=[entry], time_error=TIME_ERROR)
    np.testing.assert_allclose(found.estimate, without.estimate, rtol=1e-6)
    assert int(found.degrees_of_freedom) == int(without.degrees_of_freedom)


def test_times_beside_a_graze_are_left_out():
    """A time at a graze answers to changes without bound: it would tell more than was measured."""
    rotor = Rotor(omega=2.2, zeta=0.05, delta0=1.5, shaft_stiffness=0.25, load=0.2,
                  contact_damping=0.1)  # fmt: skip
    run = simulate(rotor, start=(0.5, -1, 0, 0), duration=120.0, samples=3001)
    times, kinds = run.event_time.values, run.event_kind.values
    error = 0.03
    seen = noisy(signals_of(run), np.random.default_rng(5))
    late = np.random.default_rng(6).normal(0.0, error, times.size)
    given = {name: np.sort((times + late)[kinds == kind])
             for name, kind in (("entries", 1), ("exits", -1))}  # fmt: skip
    sought = ["zeta", "delta0", "shaft_stiffness", "contact_damping"]
    found = fit(seen, rotor, sought, time_error=error, **given)
    close = np.diff(times) < 5.0 * error
    beside = np.append(close, False) | np.append(False, close)
    assert beside.any()
    for kind in (1, -1):
        compared = found.compared.values[found.event_kind.values == kind] == 1
        assert not compared[beside[kinds == kind]].any()
        assert compared.sum() > 25
    assert "at a graze or in chatter" in found.attrs["contact_times"]
    truth = np.array([rotor.zeta, rotor.delta0, rotor.shaft_stiffness, rotor.contact_damping])
    # within four errors all, which chance misses once in four thousand trials
    assert (np.abs(found.estimate.values - truth) < 4.0 * found.standard_error.values).all()


def test_a_machine_in_si_units_and_its_mark(up):
    """Of a measured rotor nobody knows where on the shaft the unbalance is."""
    rng = np.random.default_rng(3)
    run = in_si(MACHINE, to=180.0, samples=4501)
    seen = noisy(signals_of(run), rng, 1.0)
    ahead = 0.7
    seen["angle"] = seen.angle - ahead  # the mark comes later
    given = {**MACHINE.given, "damping": 110.0, "clearance": 2.5e-5, "eccentricity": 1.2e-5}
    sought = ["damping", "clearance", "eccentricity", "unbalance_angle"]
    found = fit(seen, DimensionalRotor(**given), sought)
    off = (found.estimate - [89.1, 2e-5, 1e-5, ahead]) / found.standard_error
    assert (np.abs(off) < 5.0).all()
    assert found.unit.values.tolist() == ["N s m-1", "m", "m", "radian"]
    assert found.forward_whirl_amplitude.attrs["units"] == "um"
    # in words as in the table and the figure: in degrees
    error = np.degrees(found.standard_error.values[3])
    assert f"unbalance_angle is known to {error:.2g} deg" in found.attrs["identifiability"]
    degrees = np.degrees(found.estimate.values[3])
    assert f"unbalance angle ${degrees:.2f}(" in _estimates_in_words(found)


@pytest.mark.parametrize("ahead", [-2.8, 0.0, 1.5])
def test_the_whirl_before_contact_gives_a_guess_of_the_unbalance_angle(up, ahead):
    """To 0.3 rad: the run-up is fast, and the guesses of the machine are a fifth off."""
    seen = noisy(signals_of(up), np.random.default_rng(2))
    seen["angle"] = seen.angle - ahead
    found = fit(seen, GUESS, [*SOUGHT, "unbalance_angle"], limit=1e-9)
    assert abs(float(found.first_guess[-1]) - ahead) < 0.3


def test_without_a_whirl_before_contact_the_guess_of_the_unbalance_angle_is_0(up):
    rubbing = signals_of(up).sel(t=slice(60.0, None))
    found = fit(rubbing, replace(TRUE, delta0=0.5), ["unbalance_angle"], limit=1e-9)
    assert float(found.first_guess[0]) == 0.0


def test_errors_contain_those_of_pulses_that_are_rounded_to_samples():
    """Of a lightly damped fan, run up into contact, 8 times at 600 samples a second.

    Its unknown angle, up to 3 rad, does not mislead the other unknowns. The bounds leave chances of
    about 1e-4.
    """
    rng, trials = np.random.default_rng(4), 8
    fan = replace(MACHINE, damping=16.0, clearance=8e-5)
    run = signals_of(in_si(fan, to=120.0, rate=15.0, samples=4001))
    sought = ["damping", "eccentricity", "clearance", "shaft_stiffness", "unbalance_angle"]
    off = []
    for _ in range(trials):
        ahead = rng.uniform(-3.0, 3.0)
        pulse = (run.angle.values - ahead) % (2.0 * math.pi) < 0.5
        seen = noisy(run, rng, 1.0).drop_vars("angle")
        pulses = teeth_in(run.t.values, pulse.astype(float), 1, fill=False).times
        seen["keyphasor"] = "pulse", pulses
        found = fit(seen, fan, sought)
        assert found.attrs["search"] == "converged"
        assert found.attrs["remainder"].startswith("the residuals are noise")
        apart = found.estimate.values - [16.0, 1e-5, 8e-5, 4e4, ahead]
        apart[-1] = math.remainder(apart[-1], 2.0 * math.pi)
        off.append(apart / found.standard_error.values)
    assert (np.abs(off) < 2.0).sum() >= binom.ppf(1e-5, 5 * trials, 0.95)
    assert ((np.array(off) ** 2).sum(axis=0) < chi2.isf(1e-4, trials)).all()


def test_a_part_between_a_few_of_many_pulses_is_fitted():
    """Exact pulses, at a constant speed; the motion has its period."""
    rotor = Rotor(omega=1.2, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    run = signals_of(simulate(rotor, start=(0, 0, 0, 0), duration=100.0, samples=8001))
    run["keyphasor"] = "pulse", 2.0 * math.pi / 1.2 * np.arange(20)
    seen = run.drop_vars(["angle", "omega"])
    for first, last in ((15.0, 26.5), (15.71, 70.0), (0.0, 100.0)):
        found = fit(seen.sel(t=slice(first, last)), rotor, ["zeta"], noise=1e-6)
        np.testing.assert_allclose(found.estimate, 0.1, rtol=1e-5)


def test_a_clearance_that_is_never_touched_is_not_identifiable():
    wide = Rotor(omega=0.3, zeta=0.15, delta0=50.0, shaft_stiffness=1.0)
    run = run_up(wide, start=(0, 0, 0, 0), to=2.0, rate=0.02, samples=2001)
    seen = noisy(signals_of(run), np.random.default_rng(1))
    found = fit(seen, wide, SOUGHT)
    np.testing.assert_array_equal(found.told, [1, 0, 1])
    assert (
        "delta0 is not identifiable: it changes nothing in these signals"
        in (found.attrs["identifiability"])
    )
    assert np.isinf(found.standard_error.sel(unknown="delta0"))


@pytest.mark.parametrize("seed", [0, 3])
def test_touches_that_only_follow_the_noise_do_not_tell_the_clearance(seed):
    """A guess near the largest radius found 3.40 +- 0.02 here, of a clearance of 50."""
    wide = Rotor(omega=0.3, zeta=0.15, delta0=50.0, shaft_stiffness=1.0)
    run = run_up(wide, start=(0, 0, 0, 0), to=2.0, rate=0.02, samples=2001)
    near = 0.98 * float(np.hypot(run.x, run.y).max())
    seen = noisy(signals_of(run), np.random.default_rng(seed))
    found = fit(seen, replace(wide, delta0=near), SOUGHT)
    np.testing.assert_array_equal(found.told, [1, 0, 1])
    assert float(found.estimate[1]) > near
    assert "delta0 is not identifiable" in found.attrs["identifiability"]


def test_what_is_known_only_together_is_said():
    """Without contact mass, damping and stiffness move a rotor by their ratios alone."""
    wide = DimensionalRotor(**{**MACHINE.given, "clearance": 1e-3})
    seen = noisy(signals_of(in_si(wide)), np.random.default_rng(1), 0.1)
    found = fit(seen, wide, ["mass", "damping", "shaft_stiffness"])
    assert found.told.values.tolist() == [0, 0, 0]
    assert (
        "mass, damping and shaft_stiffness are identifiable only together"
        in (found.attrs["identifiability"])
    )
    assert "(mass +1, damping +1, shaft_stiffness +1)" in found.attrs["identifiability"]


def test_a_model_that_lacks_something_leaves_more_than_noise(up):
    """A machine with half the shaft's stiffness cannot move like this one."""
    seen = noisy(signals_of(up), np.random.default_rng(6))
    stiff = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=0.95)
    found = fit(seen, stiff, ["zeta"], noise=NOISE)
    wider = math.sqrt(float(found.chi_square) / float(found.degrees_of_freedom))
    assert found.attrs["remainder"].startswith(
        f"the residuals exceed the noise, so errors are widened {wider:.3g} times: "
    )
    # as one would state them who takes what is left for the noise
    as_noise = fit(seen, stiff, ["zeta"], noise=wider * NOISE)
    assert as_noise.attrs["remainder"].startswith("the residuals are noise")
    assert found.standard_error.item() == pytest.approx(as_noise.standard_error.item(), rel=1e-3)
    part = 100.0 * (found.standard_error / found.estimate).item()
    assert found.attrs["identifiability"] == f"zeta is known to {part:.2g} %"


def test_a_known_start_is_not_sought(up):
    found = fit(signals_of(up), GUESS, SOUGHT, start=(0, 0, 0, 0))
    np.testing.assert_allclose(found.estimate, TRUTH, rtol=1e-6)
    sought = fit(signals_of(up), GUESS, SOUGHT)
    assert int(found.degrees_of_freedom) > int(sought.degrees_of_freedom)


def test_chaos_is_refused():
    """Of the rotor of the page on signatures, whose largest exponent is 0.075."""
    rotor = Rotor(omega=0.925, zeta=0.04, delta0=2.0, shaft_stiffness=0.04, contact_exponent=1.0,
                  load=0.06, friction=0.1, disc_radius=20.0)  # fmt: skip
    run = simulate(rotor, start=(0.4, 0, 0, 0.1), duration=600.0, samples=6001)
    with pytest.raises(InputError, match=r"that its start determines, but by .* fit a part"):
        fit(run, rotor, ["zeta"])


SIX = ("mass", "damping", "eccentricity", "clearance", "shaft_stiffness", "contact_stiffness")
COSTLY = {"mass": 1e-9, "contact_stiffness": 1e9, "damping": 1e3}


@pytest.fixture(scope="module")
def six():
    """Six unknowns of a run-up in SI units, whose first guess has been simulated."""
    problem = problem_of(
        signals_of(in_si(MACHINE)), MACHINE, SIX, orders=(1,), revolutions=None, start=None,
        entries=None, exits=None, time_error=None, noise=1.0,
    )  # fmt: skip
    problem.begin()
    return problem


@pytest.mark.parametrize("name", COSTLY)
def test_a_costly_trial_is_a_poor_one(six, name):
    """Such trials of a search took minutes, in the simulation or in the derivatives."""
    good = six.left(six.trials.first())
    sought = six.trials.first()
    sought[SIX.index(name)] *= COSTLY[name]
    with pytest.raises(BudgetError, match=r"radians of its fastest motion are more"):
        six.at(sought)
    assert (six.left(sought) ** 2).sum() > 100.0 * (good**2).sum()


def test_what_cannot_be_simulated_is_a_poor_trial(six):
    sought = six.trials.first()
    sought[SIX.index("contact_stiffness")] = 1e31
    with pytest.raises(InputError, match="stiffness of the contact at 'disc' must lie"):
        six.at(sought)
    assert np.ptp(six.left(sought)) == 0.0


def test_a_search_that_must_end_returns_its_best_trial(up, monkeypatch):
    """By the clock, by the number of trials, or by itself: and says which."""
    seen, counts = noisy(signals_of(up), np.random.default_rng(1)), []
    whole = fit(seen, GUESS, SOUGHT, progress=lambda *told: counts.append(told))
    assert whole.attrs["search"] == "converged"
    assert all(done <= total == MOST_TRIALS for done, total in counts)
    late = fit(seen, GUESS, SOUGHT, limit=1e-9)
    assert late.attrs["search"].startswith(
        "stopped by its limit: no trial is better than the first guess"
    )
    assert late.attrs["evaluations"] == 1
    np.testing.assert_array_equal(late.estimate, late.first_guess)
    monkeypatch.setattr("rotor_ida.fitting.trials.MOST_TRIALS", 12)
    short = fit(seen, GUESS, SOUGHT, noise=NOISE)
    assert short.attrs["search"].startswith("stopped after 12 trials: this is the best trial")
    assert "is known to" not in short.attrs["identifiability"]
    assert "the search did not converge" in short.attrs["identifiability"]
    assert not short.told.values.any()
    # far from a minimum the linear errors can be many times too small: none is stated
    for name in ("standard_error", "lower", "upper", "covariance"):
        assert short[name].isnull().all()
        assert whole[name].notnull().all()
    assert "widened" not in late.attrs["remainder"]
    assert _estimates_in_words(short).endswith("no errors: the search has not converged")
    assert float(whole.chi_square) < float(short.chi_square)
    first = fit(seen, GUESS, SOUGHT, noise=NOISE, limit=1e-9)
    assert float(short.chi_square) < float(first.chi_square)


@pytest.mark.parametrize("seed", [6, 15, 29])
def test_guesses_a_fifth_off_end_right(seed):
    """Three of the 200 fits of benchmarks/fit_guesses.py."""
    script = Path(__file__).parents[2] / "benchmarks" / "fit_guesses.py"
    assert run_path(str(script))["trial"](seed)[0] == "right"


REFUSED = {
    "names": ({"unknown": ["omega"]}, r"unknown must be of 'zeta', 'delta0', .* got 'omega'"),
    "none": ({"unknown": []}, r"unknown must be of .*, got \[\]"),
    "text": ({"unknown": "zeta"}, r"unknown must be a list of names.* got 'zeta'"),
    "twice": ({"unknown": ["zeta", "zeta"]}, r"unknown must name each once"),
    "friction": ({"unknown": ["friction"]}, r"machine must have a disc_radius .* got none"),
    "orders": (
        {"orders": [0]},
        r"orders must be 0 or positive, at least one positive, got \[0.0\]",
    ),
    "below": ({"orders": [-1, 1]}, r"orders must be 0 or positive, at least one positive"),
    "twenty": ({"orders": range(21)}, r"orders must be at most 20 different ones, got \[0.0, 1.0"),
    "no error": ({"entries": [1.0]}, r"time_error must be given with entries or exits, got None"),
    "no times": ({"time_error": 1.0}, r"entries or exits must be given with time_error"),
    "outside": ({"entries": [-5.0], "time_error": 1.0}, r"entries must lie within the signals"),
    "start": ({"start": [1, 2]}, r"start must be four numbers"),
    "noise": ({"noise": -1}, r"noise must be positive, got -1.0"),
    "limit": ({"limit": 0}, r"limit must be positive, got 0.0"),
    "progress": ({"progress": 3}, r"progress must be a function, True or None, got 3"),
    "confidence": ({"confidence": 2}, r"confidence must lie from 0.5"),
    "too long": ({"revolutions": 500}, r"signals must have at least 500 whole revolutions"),
    "no machine": (
        {"machine": 3},
        r"machine must be a Rotor, a DimensionalRotor or a RotorSystem, got 3",
    ),
    "units": (
        {"machine": MACHINE, "unknown": ["load"]},
        r"machine must be a Rotor, or .* for signals",
    ),
    "always in contact": (
        {"machine": Rotor(omega=1, zeta=0.1, delta0=0)},
        r"machine must have a clearance above 0",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_fitted_is_told_in_one_line(name, up):
    given, said = REFUSED[name]
    with pytest.raises(InputError, match=said) as caught:
        fit(**{"signals": signals_of(up), "machine": GUESS, "unknown": ["zeta"], **given})
    assert "\n" not in str(caught.value)


def test_few_windows_and_no_angle_are_refused(up):
    seen = signals_of(up)
    with pytest.raises(InputError, match="at least as many numbers to compare as unknowns"):
        fit(seen.isel(t=slice(0, 420)), GUESS, SOUGHT)
    with pytest.raises(InputError, match="signals must contain angle, keyphasor or omega"):
        fit(seen.drop_vars(["angle", "omega"]), GUESS, SOUGHT)
    with pytest.raises(InputError, match="signals must be a dataset, or a list of them, got"):
        fit([], GUESS, SOUGHT)


def test_a_guess_far_off_is_said_to_be(up):
    """Or it comes to the truth all the same: it never ends elsewhere without a word."""
    far = Rotor(omega=0.3, zeta=0.6, delta0=4.0, shaft_stiffness=0.2)
    found = fit(noisy(signals_of(up), np.random.default_rng(7)), far, SOUGHT)
    near = bool((np.abs(found.estimate - TRUTH) < 6.0 * found.standard_error).all())
    assert near or found.attrs["remainder"].startswith("the residuals exceed the noise")


def test_an_unknown_may_begin_at_zero(up):
    """Least squares take steps beside 0 that are smaller than what can be simulated."""
    found = fit(signals_of(up), replace(TRUE, shaft_stiffness=0.0), ["shaft_stiffness", "zeta"])
    np.testing.assert_allclose(found.estimate, [1.0, 0.1], rtol=1e-5)


def test_a_clearance_is_chosen_again_where_others_misled(up):
    """With six times the damping the rotor would hardly reach the ring, wherever that is."""
    far = replace(TRUE, zeta=0.6, delta0=5.0)
    found = fit(signals_of(up), far, ["zeta", "delta0"])
    np.testing.assert_allclose(found.estimate, [0.1, 1.5], rtol=1e-5)


class TwoMinima:
    """Residuals of a contact stiffness k: 0 at k = 1.6, and a minimum above 0 near k = 1."""

    def __init__(self):
        self.trials = SimpleNamespace(
            unknown=(Unknown("contact_stiffness", "contact_stiffness", "1", 1.0, 0.0, 1.0),),
            left_work=1e6, bounds=lambda: (np.array([0.0]), np.array([np.inf])),
        )  # fmt: skip

    def left(self, sought):
        (k,) = sought
        return np.array([(k - 1.0) * (k - 1.6), 0.1 * (k - 1.6)])

    def slopes(self, sought):
        (k,) = sought
        return np.array([[2.0 * k - 2.6], [0.1]])

    def at(self, sought):
        return self.left(sought), self.slopes(sought), []


def test_a_deeper_minimum_near_another_contact_stiffness_is_found():
    problem = TwoMinima()
    near, converged = _least(problem, np.array([1.0]), 1e-10)
    assert converged
    assert near[0] == pytest.approx(1.0, abs=0.05)
    least = float((problem.left(near) ** 2).sum())
    assert _with_stiffness(problem, least, near)[0] == pytest.approx(1.6, abs=1e-6)
