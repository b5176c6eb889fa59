"""What a torque must not do to the speed: let it fall below 0, or run away; and what a prescribed
speed may do."""

import time
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, SimulationError, run_up
from tests.witness import FLIES, FORWARDS, HOW, Disc

BY = {
    "taylor": {"method": "taylor"},
    "adams": {},
    "bdf": {"method": "bdf"},
    "reference": {"backend": "python"},
    "ida": {"backend": "python", "method": "ida"},
}
SPRUNG = Rotor(omega=0.9, zeta=0.1, delta0=1.0, shaft_stiffness=0.3)
RUBS = Rotor(omega=0.9, zeta=0.1, delta0=1.0, shaft_stiffness=0.3, friction=0.1, disc_radius=0.8)
FREE = Rotor(
    omega=1.5661579633624854, zeta=0.06599701177549437, delta0=5.0,
    shaft_stiffness=0.6066536950752652,
)  # fmt: skip
# Rotor, start, torque, inertia, and mode. Each speed dips to about -1e-4 and comes back.
DIPS = {
    "flight": (FREE, (0.04, -0.035, 0.667, -0.344), (0.8827081632547997, 0.11), 0.66, FLIES),
    "contact": (SPRUNG, (0.62, -1.74, -0.15, 0.25), (0.1534583916017113, 0.1), 0.36, FORWARDS),
    "rub": (RUBS, (0.62, -1.74, -0.15, 0.25), (0.17764691615328615, 0.1), 0.36, FORWARDS),
}
DRIFTS = Rotor(omega=1.0, zeta=0.0, delta0=1e5)


def stall_of(rotor, start, torque, inertia, mode, duration=6.0):
    """Return when SciPy's DOP853 sees the speed fall through 0, and whether it comes back."""
    disc = Disc(rotor, torque=torque, inertia=inertia)
    state, closely = np.array([*start, 0.0, rotor.omega]), HOW | {"max_step": 0.005}
    at, stalled, *_ = disc.stretch(0.0, duration, state, mode, [lambda seen: seen[5]], closely)
    _, later, *_ = disc.stretch(0.0, 0.1, stalled, mode)
    return at, stalled, later[5] > 0.0


@pytest.mark.parametrize("by", BY)
@pytest.mark.parametrize("dip", DIPS)
def test_a_speed_that_dips_below_zero_within_a_step_stalls_at_its_own_time(dip, by):
    rotor, start, torque, inertia, _ = DIPS[dip]
    at, stalled, comes_back = stall_of(*DIPS[dip])
    assert comes_back
    with pytest.raises(SimulationError, match="the speed fell through 0") as failure:
        run_up(rotor, start=start, torque=torque, inertia=inertia, duration=6.0, rtol=1e-12,
               **BY[by])  # fmt: skip
    # the speed is nearly level there: its error is divided by a small acceleration
    assert failure.value.time == pytest.approx(at, abs=1e-8)
    assert failure.value.state == pytest.approx(stalled[:4], abs=1e-7)


@pytest.mark.parametrize("by", BY)
@pytest.mark.parametrize("dip", ["flight", "contact"])
def test_a_speed_that_stays_above_zero_does_not_stall(dip, by):
    rotor, start, (tau0, slope), inertia, _ = DIPS[dip]
    run = run_up(rotor, start=start, torque=(tau0 + 1e-3, slope), inertia=inertia, duration=0.65
                 if dip == "contact" else 6.0, samples=3001, **BY[by])  # fmt: skip
    assert 0.0 < run.speed.values.min() < 1e-2


@pytest.mark.parametrize("by", BY)
def test_a_brake_stops_a_rotor_without_reaction_when_its_momentum_is_spent(by):
    """omega j/tau, as nothing else turns a rotor without damping, shaft and contact."""
    with pytest.raises(SimulationError, match="the speed fell through 0") as failure:
        run_up(DRIFTS, torque=(-0.3, 0.0), inertia=2.0, duration=20.0, **BY[by])
    assert failure.value.time == pytest.approx(2.0 / 0.3, rel=1e-9)


RUNS_AWAY = {
    "grows as e to the t": (SPRUNG, (1.0, -1.0), 1.0, 1e3),
    "soon beyond what can be simulated": (SPRUNG, (1.0, -1.0), 1.0, 20.0),
    "a torque too large for its inertia": (DRIFTS, (1.0, 0.0), 1e-12, 10.0),
    "more than the largest number": (SPRUNG, (1e15, -1e15), 1e-12, 1e8),
    "no damping, for too long": (DRIFTS, (1.0, 0.0), 20.0, 1e6),
}


@pytest.mark.parametrize("case", RUNS_AWAY)
def test_a_torque_that_lets_the_speed_run_away_is_refused(case):
    rotor, torque, inertia, duration = RUNS_AWAY[case]
    with pytest.raises(InputError, match=r"must keep the speed below 1e\+06 and .*, got torque"):
        run_up(rotor, torque=torque, inertia=inertia, duration=duration)


@pytest.mark.parametrize("by", sorted(BY.keys() - {"ida"}))  # which ends at so high a speed
def test_a_speed_that_runs_away_in_a_run_is_stopped_there(by, monkeypatch):
    """In case something speeds the rotor up that the check before the run does not foresee."""
    monkeypatch.setattr("rotor_ida.simulation.course._check_runaway", lambda *_: None)
    with pytest.raises(SimulationError, match=r"the speed passed 1e\+06: the torque") as failure:
        run_up(replace(DRIFTS, omega=999_900.0), torque=(1.0, 0.0), inertia=1e-6, duration=1e-3,
               **BY[by])  # fmt: skip
    # 100 rad over the unit of time later, at the end of a step
    assert 1e-4 <= failure.value.time < 2e-4


def test_an_inertia_so_small_that_a_run_would_hardly_end_is_refused():
    with pytest.raises(InputError, match=r"inertia must be at least 2e-08 with torque .* 1e-12$"):
        run_up(SPRUNG, torque=(1.0, 0.0), inertia=1e-12, duration=10.0)


def test_a_torque_that_grows_with_the_speed_is_followed_as_long_as_that_is_moderate():
    """theta'' = 1 + theta' without reaction: (omega + 1) e^t - 1."""
    run = run_up(DRIFTS, torque=(1.0, -1.0), inertia=1.0, duration=5.0, samples=2)
    assert run.speed.values[-1] == pytest.approx(2.0 * np.exp(5.0) - 1.0, rel=1e-9)


def test_pieces_steeper_than_any_rate_are_refused():
    with pytest.raises(InputError, match=r"the rate of speeds must lie within 1e\+06 .* 1e-300"):
        run_up(SPRUNG, speeds=[(0.0, 1.0), (1e-300, 2.0)])


@pytest.mark.parametrize("by", BY)
def test_a_level_piece_may_be_as_short_as_doubles_allow(by):
    short = run_up(SPRUNG, speeds=[(0.0, 1.0), (5e-324, 1.0), (4.0, 1.5)], samples=3, **BY[by])
    long = run_up(SPRUNG, speeds=[(0.0, 1.0), (4.0, 1.5)], samples=3, **BY[by])
    np.testing.assert_allclose(short.x, long.x, rtol=0, atol=1e-9)


def test_the_time_that_pieces_take_grows_in_proportion_to_their_number():
    def seconds(count):
        times = np.linspace(0.0, 100.0, count + 1)
        begun = time.process_time()
        run_up(SPRUNG, speeds=np.c_[times, 1.0 + 0.5 * np.sin(0.3 * times)], method="taylor")
        return time.process_time() - begun

    seconds(100)
    few, many = min(seconds(3000) for _ in range(2)), seconds(30_000)
    assert many < 30.0 * few  # as the square of their number: a hundred times
