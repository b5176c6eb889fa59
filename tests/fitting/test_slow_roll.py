"""Fits to signals from which a slow roll was subtracted, with its runout and the whirl in it."""

import numpy as np
import pytest
from scipy.stats import chi2

from rotor_ida import DimensionalRotor, dimensional, fit, run_up, signals_of, subtract_runout

NAMES = ("damping", "shaft_stiffness", "eccentricity", "unbalance_angle")
TRUTH = np.array([60.0, 4e4, 2e-5, 0.0])
TRIALS = 6


def machine(damping=60.0, shaft_stiffness=4e4, eccentricity=2e-5):
    return DimensionalRotor(
        mass=4.0, contact_stiffness=3.2e7, damping=damping, eccentricity=eccentricity,
        clearance=2e-3, speed=6.0, shaft_stiffness=shaft_stiffness,
    )  # fmt: skip


@pytest.fixture(scope="module")
def seen():
    run = run_up(machine(), start="settled", to=160.0, rate=8.0, samples=12_001)
    return signals_of(dimensional(run, units={"length": "um"}))


def signals(seen, seed, slow=None):
    """Return signals with a runout of 30 um and noise, less its slow roll."""
    noise = np.random.default_rng(seed).normal(size=(2, seen.sizes["t"]))
    bent = 30.0 * np.exp(1j * (seen.angle.values + 1.0)) + noise[0] + 1j * noise[1]
    made = seen.assign(
        x=seen.x.copy(data=seen.x.values + bent.real), y=seen.y.copy(data=seen.y.values + bent.imag)
    )
    kept = subtract_runout(made, made.sel(t=slice(0.0, 2.0)))
    if slow is not None:
        kept = {
            "unknown": kept.assign_attrs(slow_roll_speeds=[0.0], slow_roll_error=0.0),
            "left out": kept.sel(t=slice(2.0, None)),
        }[slow]
    return kept


def fitted(seen, seed, slow=None):
    """Return a fit to these signals."""
    return fit(signals(seen, seed, slow), machine(70.0, 4.2e4, 1.8e-5), NAMES, start="settled")


def scores_of(seen, seed, slow=None):
    """Return the errors of the estimates over their standard errors."""
    found = fitted(seen, seed, slow)
    return (found.estimate.values - TRUTH) / found.standard_error.values


@pytest.mark.parametrize("slow", [None, "left out"])
def test_the_whirl_in_a_slow_roll_is_not_taken_from_the_fit(seen, slow):
    """At 6 to 22 rad/s the whirl is 0.07 to 1 um of the slow roll; the errors contain its noise."""
    scores = np.array([scores_of(seen, seed, slow) for seed in range(TRIALS)])
    # the mean of independent scores, and the sum of their squares, with a chance of 1e-4 a side
    assert np.abs(scores.mean(axis=0)).max() < 3.7 / np.sqrt(TRIALS)
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], TRIALS)
    assert low < (scores**2).sum(axis=0).min()
    assert (scores**2).sum(axis=0).max() < high


def test_without_the_speeds_of_the_slow_roll_the_same_fit_is_far_off(seen):
    assert np.abs(scores_of(seen, 0, "unknown")).max() > 10.0


def test_residuals_of_order_1_are_white_where_errors_are_shared(seen):
    """The slow roll has one error for all windows, which is in none of the residuals judged."""
    found = fitted(seen, 0).sel(order=1)
    left = np.concatenate([found.forward_residual_real, found.forward_residual_imag])
    assert left.size > 200
    # neighbours are uncorrelated, and squares have a mean of 1, with a chance of 1e-4
    bound = 4.0 / np.sqrt(left.size)
    assert abs(np.mean(left[1:] * left[:-1])) < bound
    assert abs(np.mean(left**2) - 1.0) < np.sqrt(2.0) * bound
    raw = [
        found[f"{words}forward_whirl_amplitude"] * np.exp(-1j * found[f"{words}forward_phase_lag"])
        for words in ("", "fitted_")
    ]
    together = ((raw[0] - raw[1]) / found.forward_amplitude_error).mean()
    assert abs(together) > 2.0 * bound
    assert abs(left.mean()) < bound
    both = np.concatenate([found.backward_residual_real, found.backward_residual_imag, left])
    # while the speed rises, orders in a window of whole revolutions are almost uncorrelated
    np.testing.assert_allclose((both**2).sum(), found.chi_square, rtol=1e-3)


def test_the_unbalance_angle_lies_within_half_a_turn(seen):
    """A mark 3.14 rad ahead turns the unbalance back by as much; the search ends at 3.144."""
    kept = signals(seen, 0)
    kept = kept.assign(angle=kept.angle + 3.14)
    found = fit(kept, machine(70.0, 4.2e4, 1.8e-5), NAMES, start="settled")
    angle = found.sel(unknown="unbalance_angle")
    assert abs(angle.estimate + 3.14) < 4.0 * angle.standard_error
    assert angle.lower < angle.estimate < angle.upper
