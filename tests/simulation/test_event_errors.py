"""The stated error of an event time covers the true one, and is not absurdly larger."""

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

from rotor_ida import Rotor, SimulationError, simulate
from rotor_ida.core.interface import STUCK
from rotor_ida.simulation import event_errors, system_run
from rotor_ida.simulation import run as simulation_run
from tests.random_systems import followed, stated_and_true

REST = (0.0, 0.0, 0.0, 0.0)


def machine_of(rng):
    given = {
        "omega": rng.uniform(0.3, 4.0), "zeta": 10.0 ** rng.uniform(-2.0, -0.5),
        "delta0": rng.uniform(0.2, 3.0), "shaft_stiffness": rng.uniform(0.0, 1.0),
        "load": rng.uniform(0.0, 0.5), "friction": rng.uniform(0.02, 0.5),
        "disc_radius": rng.uniform(0.0, 10.0), "contact_damping": rng.uniform(0.0, 0.5),
    }  # fmt: skip
    without = [name for name in ("shaft_stiffness", "load", "friction", "contact_damping")
               if rng.random() < 0.5]  # fmt: skip
    return Rotor(**{name: float(0.0 if name in without else each) for name, each in given.items()})


def test_stated_errors_of_machines_of_every_kind_cover_the_true_ones():
    """Also where the times of two runs agree by chance: then the states do not."""
    rng, covered = np.random.default_rng(5), []
    for _ in range(120):
        rotor = machine_of(rng)
        start = tuple((0.6 * rng.normal(size=4) * [rotor.delta0, rotor.delta0, 1.0, 1.0]).tolist())
        given = {"start": start, "duration": 20.0, "samples": 65, "method": "taylor"}
        best = simulate(rotor, **given, rtol=1e-14, atol=1e-17)
        for rtol in (1e-4, 1e-6, 1e-9):
            run = simulate(rotor, **given, rtol=rtol, atol=rtol / 100)
            if run.event_kind.values.tolist() != best.event_kind.values.tolist():
                continue
            true = np.abs(run.event_time.values - best.event_time.values)
            covered += (true <= run.event_time_error.values).tolist()
    assert len(covered) > 1200
    assert np.mean(covered) >= 0.9995


def test_an_event_whose_times_agree_by_chance_takes_its_error_from_the_states():
    """The true time is that of tighter runs and of another program, to the digits given."""
    rotor = Rotor(
        omega=2.5863261617193443, zeta=0.020628828643712138, delta0=1.6984806103918872,
        shaft_stiffness=0.08119155801342097, load=0.320219056471074,
        friction=0.45508197010848617, disc_radius=9.095511457441354,
    )  # fmt: skip
    start = (1.1485967285817444, -0.9087813188227201, 0.6136083169796814, -1.5687507748621725)
    run = simulate(rotor, start=start, duration=4.0, method="taylor", rtol=1e-4)
    missed = abs(run.event_time.values[1] - 1.84854114158)
    assert missed <= run.event_time_error.values[1] < 1e-5


@pytest.mark.parametrize(
    ("rotor", "duration", "witness"),
    [
        (Rotor(omega=2.0, zeta=0.07, delta0=2.0), 100.0, "taylor"),
        (Rotor(omega=2.0, zeta=0.5, delta0=0.5), 2e6, "bdf"),
        (Rotor(omega=1.0, zeta=1e5, delta0=0.5), 100.0, "bdf"),
    ],
    ids=["short", "long whirl", "heavy damping"],
)
def test_what_costs_taylor_series_too_many_steps_is_repeated_by_its_own_method(
    monkeypatch, rotor, duration, witness
):
    seen = []

    def noted(rotor, start, duration, times, options, **how):
        seen.append(options.method)
        return simulation_run.run(rotor, start, duration, times, options, **how)

    monkeypatch.setattr(event_errors, "run", noted)
    simulate(rotor, start=(0.9, 0, 0, 0), duration=duration, samples=3, method="bdf")
    assert seen == [witness]


def test_where_both_runs_round_alike_the_rotor_differs_by_the_last_bit(monkeypatch):
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    seen = []

    def noted(rotor, *given, **how):
        seen.append(rotor)
        return simulation_run.run(rotor, *given, **how)

    monkeypatch.setattr(event_errors, "run", noted)
    for rtol in (1e-12, 1e-15):
        simulate(rotor, start=REST, duration=20.0, rtol=rtol, atol=1e-17, method="taylor")
    assert seen[0] == rotor
    assert seen[1] != rotor
    assert seen[1].omega == pytest.approx(rotor.omega, rel=1e-15)


def test_stated_errors_fall_with_the_tolerance():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    worst = [
        float(simulate(rotor, start=REST, duration=60.0, rtol=rtol).event_time_error.max())
        for rtol in (1e-6, 1e-8, 1e-10)
    ]
    assert worst[0] > 10.0 * worst[1] > 100.0 * worst[2]


def test_beyond_the_horizon_no_event_time_is_claimed():
    """Undamped forced motion that grazes: a loose tolerance loses it within the run."""
    rotor = Rotor(omega=1.37, zeta=0.0, delta0=1.0)
    run = simulate(rotor, start=(0.3, 0, 0.4, 0.2), duration=800.0, rtol=1e-5, atol=1e-7)
    assert run.horizon < 800.0
    assert np.isinf(run.event_time_error.where(run.event_time > run.horizon, drop=True)).all()
    settled = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=REST, duration=100.0)
    assert settled.horizon == 100.0


def whirls(radii, apart=0.0):
    """A motion of given radius at each of its samples, that is so far from another."""
    times = np.arange(float(len(radii)))
    states = np.zeros((times.size, 4))
    states[:, 0], states[:, 1] = radii * np.cos(times), radii * np.sin(times) + apart
    return SimpleNamespace(times=times, states=states, duration=times[-1], event_times=np.empty(0))


def test_a_pair_of_events_that_one_run_alone_has_is_left_out():
    """Two touches of three, and one of three: then the runs have separated."""
    times, kinds = np.arange(6.0), np.array([1, -1] * 3)
    for kept, found, alone in (
        ([0, 1, 4, 5], [0, 1, -1, -1, 2, 3], [0, 1, -1, -1, -1, -1]),
        ([0, 5], [0, -1, -1, -1, -1, -1], [0, -1, -1, -1, -1, -1]),
    ):
        other = times[kept], kinds[kept]
        for skips, expected in ((True, found), (False, alone)):
            partners = event_errors.partners_of(times, kinds, *other, skips=skips)
            assert partners.tolist() == expected
    other = times[[0, 1, 4, 5]], kinds[:4]
    assert event_errors.partners_of(*other, times, kinds, skips=True).tolist() == [0, 1, 4, 5]


def test_the_horizon_is_told_by_the_motion_where_it_looks():
    """A start a thousand times as large hides nothing, a sample near the centre says nothing."""
    radii = np.maximum(1e3 * np.exp(-np.arange(100.0)), 1.0)
    parted = np.where(np.arange(100) >= 40, 0.05, 0.0)
    none = np.empty(0, dtype=np.intp)
    assert event_errors._horizon(whirls(radii), whirls(radii, parted), none) == 40.0
    assert event_errors._horizon(whirls(radii), whirls(radii, 1e-3), none) == 99.0
    radii[70] = 1e-4
    assert event_errors._horizon(whirls(radii), whirls(radii, 1e-3), none) == 99.0


@pytest.mark.parametrize("speed", [7e-4, 1.3e-3, 0.11])
def test_the_spacing_of_doubles_is_part_of_the_stated_error(speed):
    """Straight flight to a ring far away, whose exact time of arrival is a quotient."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=1e6)
    exact = Fraction(10**6) / Fraction(speed)
    run = simulate(rotor, start=(0, 0, speed, 0), duration=1.001 * float(exact), samples=2)
    time, stated = run.event_time.values[0], run.event_time_error.values[0]
    assert abs(Fraction(float(time)) - exact) <= Fraction(float(stated))
    assert np.spacing(time) <= stated < 100.0 * np.spacing(time)


@pytest.mark.parametrize("drift", [0.23, 0.7])
def test_the_rounding_of_the_phase_is_part_of_the_stated_error(drift):
    """An undamped whirl whose centre drifts to the ring, through millions of radians."""
    omega, delta0 = 100.0, 1e4
    rotor = Rotor(omega=omega, zeta=0.0, delta0=delta0)
    start = (-1.0, 0.0, drift, -omega)
    run = simulate(rotor, start=start, duration=1.001 * delta0 / drift, samples=2)
    time, stated = run.event_time.values[0], run.event_time_error.values[0]
    assert omega * time > 1e6
    with mpmath.workdps(40):

        def excess(t):
            return abs(mpmath.mpf(drift) * t - mpmath.expj(omega * t)) - delta0

        exact = mpmath.findroot(excess, (mpmath.mpf(time), mpmath.mpf(time) + stated))
        assert abs(exact - mpmath.mpf(time)) <= stated
    assert stated < 1e-6


def test_the_core_reports_the_rates_of_guards_that_the_formulas_of_one_disc_give(monkeypatch):
    """Of seven kinds of events, in closed form by the forces of one disc."""
    seen, rng, kinds = {}, np.random.default_rng(3), []
    second, formulas = system_run.errors_of_system, event_errors._rates_and_rounding

    def of_core(request, result, other, times):
        seen["core"] = other
        return second(request, result, other, times)

    def of_disc(orbit):
        seen["disc"] = formulas(orbit)[0]
        return formulas(orbit)

    monkeypatch.setattr(system_run, "errors_of_system", of_core)
    monkeypatch.setattr(event_errors, "_rates_and_rounding", of_disc)
    for _ in range(60):
        rotor, start = machine_of(rng), tuple(rng.normal(size=4).tolist())
        given = {"duration": 15.0, "samples": 2, "rtol": 1e-12, "method": "taylor"}
        run = simulate(rotor, start=start, **given)
        simulate(rotor.system(), speed=rotor.omega, start=(start[:2], start[2:]), **given)
        core, sure = seen["core"], run.event_time_error.values < 1e-9
        count = len(sure) if sure.all() else int(np.argmin(sure))
        np.testing.assert_array_equal(core.event_kinds[:count], run.event_kind[:count])
        np.testing.assert_allclose(
            core.event_rates[:count], seen["disc"][:count], rtol=1e-6, atol=1e-6
        )
        kinds += run.event_kind.values[:count].tolist()
    assert set(kinds) == {1, -1, 2, -2, 3, 4, -4}
    assert len(kinds) > 400


@pytest.mark.parametrize(
    ("method", "rtol"), [("adams", 1e-6), ("adams", 1e-10), ("bdf", 1e-6), ("taylor", 1e-5)]
)
def test_stated_errors_of_systems_cover_the_true_ones(method, rtol):
    """In two of them, flights by the same series in both runs once hid the error of a first event.

    The true time is that of a run by Taylor series at the tightest tolerance.
    """
    count = 0
    for seed in (*range(400, 420), 608, 678):
        best = followed(seed, 10.0, rtol=1e-14)
        said, true = stated_and_true(followed(seed, 10.0, rtol=rtol, method=method), best)
        assert (true <= said).all(), seed
        count += said.size
    assert count > 200


def test_before_the_horizon_of_a_system_a_far_tighter_run_has_the_same_events():
    """Of one that loses its motion long before an event differs."""
    run, best = (followed(447, 60.0, rtol=rtol) for rtol in (1e-4, 1e-14))
    assert run.horizon < best.horizon == 60.0
    for contact in range(run.sizes["contact"]):
        kinds = [
            each.event_kind[
                ((each.event_contact == contact) & (each.event_time < run.horizon)).values
            ].values.tolist()
            for each in (run, best)
        ]
        assert kinds[0] == kinds[1]


@pytest.mark.parametrize("is_system", [False, True])
def test_a_second_run_that_fails_leaves_the_first_without_stated_errors(monkeypatch, is_system):
    """The run has ended well; only its errors are unknown, as the horizon says."""
    rotor = Rotor(omega=0.5, zeta=0.02, delta0=0.5)
    true_follow, runs_of_system = system_run.follow_system, []

    def fails_second(*given):
        runs_of_system.append(given)
        found = true_follow(*given)
        return found if len(runs_of_system) == 1 else replace(found, status=STUCK, time=3.5)

    def fails(*_given, **_options):
        raise SimulationError("stuck", time=3.5)

    sound = followed_twice(rotor, is_system)
    monkeypatch.setattr(system_run, "follow_system", fails_second)
    monkeypatch.setattr(event_errors, "run", fails)
    found = followed_twice(rotor, is_system)
    assert found.event_time.size > 4
    assert np.array_equal(found.event_time, sound.event_time)
    assert np.isinf(found.event_time_error).all()
    assert np.isfinite(sound.event_time_error).all()
    assert found.horizon == 3.5 < sound.horizon


def followed_twice(rotor, is_system):
    """Return a run of a disc, or of the same rotor as a system."""
    how = {"duration": 20.0, "method": "taylor"}
    if is_system:
        return simulate(rotor.system(), speed=rotor.omega, start=((3.0, 0.0), (0.0, 0.0)), **how)
    return simulate(rotor, start=(3.0, 0.0, 0.0, 0.0), **how)


def test_the_error_of_a_system_has_its_time_as_a_number(monkeypatch):
    """As that of one disc; its state has too many numbers for a message."""
    rotor, true_follow = Rotor(omega=1.5, zeta=0.1, delta0=0.5), system_run.follow_system
    monkeypatch.setattr(
        system_run, "follow_system",
        lambda *given: replace(true_follow(*given), status=STUCK, time=3.5),
    )  # fmt: skip
    with pytest.raises(SimulationError, match=r"time no longer advances \(at t = 3.5\)$") as caught:
        followed_twice(rotor, is_system=True)
    assert caught.value.time == 3.5
    assert np.isnan(caught.value.state).all()
