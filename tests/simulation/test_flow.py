"""A piece of an orbit, its derivatives, contacts and extrema, against DOP853 and CVODE."""

import numpy as np
import pytest

from rotor_ida import Rotor, SimulationError, simulate
from rotor_ida.model.assembly import assemble
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.simulation.flow import MAXIMUM, DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from tests.cycles.known import once_round

GO_ON = np.zeros(1, np.uint8)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
START = np.array([0.3, 0.2, 0.1, -0.4])
DEEP = np.array([2.4, -1.1, 0.6, 0.9])  # in contact
DEEPER = np.array([-2.5, -3.3, 1.3, -1.0])
CASES = {
    "bouncing": (BOUNCING, START, 20.0),
    "from within a contact to within a contact": (BOUNCING, DEEPER, 18.0),
    "in contact nearly always": (Rotor(omega=3.0, zeta=0.07, delta0=0.5), DEEPER, 20.0),
    "without clearance": (Rotor(omega=1.7, zeta=0.07, delta0=0.0), DEEP, 12.0),
    "within the clearance": (Rotor(omega=1.7, zeta=0.07, delta0=9.0), START, 9.0),
    "free vibration": (Rotor(omega=0.0, zeta=0.0, delta0=0.2), START, 8.0),
    "large clearance, little damping": (Rotor(omega=1.3, zeta=0.01, delta0=5.0), DEEP, 20.0),
}


@pytest.mark.parametrize("name", CASES)
def test_end_and_monodromy_are_those_of_dop853_restarted_at_the_crossings(name):
    """Both integrate the variational equation through entries and exits unchanged."""
    rotor, start, duration = CASES[name]
    expected, shot = (
        once_round(rotor, start, duration),
        DiscFlow(rotor).run(start, duration, by=PARAMETERS),
    )
    size = np.abs(expected.monodromy).max()
    # DOP853's own error at 1e-12 a step, grown as differences grow
    np.testing.assert_allclose(shot.end, expected.end, rtol=0.0, atol=1e-10 * max(size, 1.0))
    np.testing.assert_allclose(shot.tangents, expected.monodromy, rtol=0.0, atol=1e-9 * size)
    if rotor.delta0 > 0.0:
        crossings = np.column_stack([shot.contacts["entry"], shot.contacts["exit"]]).ravel()
        crossings = crossings[np.isfinite(crossings)]
        np.testing.assert_allclose(
            crossings, expected.crossings, rtol=0.0, atol=1e-10 * max(size, 1.0)
        )


def test_without_clearance_nothing_is_said_of_the_clearance():
    rotor, start, duration = CASES["without clearance"]
    assert (DiscFlow(rotor).run(start, duration, by=PARAMETERS).by[2] == 0.0).all()


@pytest.mark.parametrize("name", CASES)
def test_extrema_are_all_turns_of_the_radius_that_cvode_shows(name):
    """Where the sampled radial velocity changes its sign, and nowhere else."""
    rotor, start, duration = CASES[name]
    times = np.linspace(0.0, duration, 20_001)
    run = simulate(rotor, start=tuple(start), duration=duration, samples=times.size)
    rising = (run["x"] * run["vx"] + run["y"] * run["vy"]).values
    turns = np.flatnonzero(rising[:-1] * rising[1:] < 0.0)
    shot = DiscFlow(rotor).run(start, duration, by=PARAMETERS)
    extrema = shot.extrema
    assert len(extrema) == turns.size >= 3
    assert (extrema["time"] >= times[turns] - 1e-8).all()
    assert (extrema["time"] <= times[turns + 1] + 1e-8).all()
    assert (extrema["kind"] == np.where(rising[turns] > 0.0, 1.0, -1.0)).all()
    for time, radius, _, turned in extrema.tolist():
        x, y, vx, vy = end = DiscFlow(rotor).run(start, time, by=PARAMETERS).end
        np.testing.assert_allclose(turned, end, rtol=0.0, atol=1e-10 * (1.0 + np.abs(end).max()))
        assert np.hypot(x, y) == pytest.approx(radius, abs=1e-11)
        assert x * vx + y * vy == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("where", ["flight", "contact", "entry", "exit", "peak"])
def test_two_stretches_make_one(where):
    """The flow is a group: ends, products of matrices, and parts of contacts fit together."""
    rotor, start, duration = CASES["bouncing"]
    whole = DiscFlow(rotor).run(start, duration, by=PARAMETERS)
    entry, leaving, peak = (whole.contacts[name][1] for name in ("entry", "exit", "peak_time"))
    places = {"flight": leaving + 0.3, "contact": 0.4 * entry + 0.6 * leaving, "entry": entry}
    cut = float({**places, "exit": leaving, "peak": peak}[where])
    one = DiscFlow(rotor).run(start, cut, by=PARAMETERS)
    two = DiscFlow(rotor).run(one.end, duration - cut, by=PARAMETERS)
    size = np.abs(whole.tangents).max()
    allowed = {"rtol": 0.0, "atol": 1e-11 * size}
    np.testing.assert_allclose(two.end, whole.end, **allowed)
    np.testing.assert_allclose(two.tangents @ one.tangents, whole.tangents, **allowed)
    columns = one.by @ two.tangents.T + two.by
    np.testing.assert_allclose(columns, whole.by, **allowed)
    exits = [*one.contacts["exit"], *(cut + two.contacts["exit"])]
    exits = [each for each in exits if np.isfinite(each) and abs(each - cut) > 1e-6]
    expected = [each for each in whole.contacts["exit"] if abs(each - cut) > 1e-6]
    np.testing.assert_allclose(exits, expected, rtol=0.0, atol=1e-10)
    impulses = np.sum(one.contacts["impulse"]) + np.sum(two.contacts["impulse"])
    assert impulses == pytest.approx(whole.contacts["impulse"].sum(), abs=1e-11)


def test_error_falls_in_proportion_to_the_tolerance():
    rotor, start, duration = CASES["bouncing"]
    exact = DiscFlow(rotor).run(start, duration, by=PARAMETERS)
    tolerances = np.array([1e-6, 1e-8, 1e-10])
    for part in ("end", "tangents", "by"):
        errors = [
            np.abs(
                np.subtract(
                    getattr(DiscFlow(rotor, rtol=rtol).run(start, duration, by=PARAMETERS), part),
                    getattr(exact, part),
                )
            ).max()
            for rtol in tolerances
        ]
        slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
        assert slope == pytest.approx(1.0, abs=0.3), part


def test_tables_hold_as_many_contacts_as_there_are():
    """On the known cycle of DESIGN 9 one contact and four extrema a period, a hundred times."""
    period = 4.563916675380
    settled = DiscFlow(BOUNCING).run(np.zeros(4), 300.0, by=PARAMETERS).end
    shot = DiscFlow(BOUNCING).run(settled, 100.0 * period, by=PARAMETERS)
    contacts = shot.contacts[np.isfinite(shot.contacts["exit"])]
    assert len(contacts) == 100
    np.testing.assert_allclose(np.diff(contacts["exit"]), period, rtol=0.0, atol=1e-7)
    assert len(shot.extrema) % 100 == 0
    highest = shot.extrema["radius"][shot.extrema["kind"] == MAXIMUM].max()
    assert highest == pytest.approx(4.104416607, abs=1e-8)


def test_what_cannot_be_followed_is_refused_with_its_start():
    with pytest.raises(SimulationError, match="could not be followed") as refused:
        DiscFlow(BOUNCING, np.ones(1, np.uint8)).run(START, 20.0, by=PARAMETERS)
    assert refused.value.state == tuple(START)


def test_rates_are_those_of_a_short_stretch():
    """The field at both ends, by differences of the motion itself."""
    shot = DiscFlow(BOUNCING).run(DEEP, 3.0, by=PARAMETERS)
    late = DiscFlow(BOUNCING).run(DEEP, 3.0 + 1e-6, by=PARAMETERS)
    early = DiscFlow(BOUNCING).run(DEEP, 1e-6, by=PARAMETERS)
    np.testing.assert_allclose(shot.end_rate, (late.end - shot.end) / 1e-6, rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(shot.start_rate, (early.end - DEEP) / 1e-6, rtol=0.0, atol=1e-5)


WINDOWS = {
    "bouncing": (BOUNCING, START),
    "full contact": (Rotor(omega=3.0, zeta=0.07, delta0=0.5), DEEPER),
    "under a load": (
        Rotor(omega=1.7, zeta=0.1, delta0=1.0, shaft_stiffness=0.4, load=0.3), START,
    ),
    "rolling": (Rotor(omega=0.7, zeta=0.02, delta0=1.0, friction=0.1, disc_radius=5.0), START),
}  # fmt: skip


@pytest.mark.parametrize("name", WINDOWS)
def test_both_kernels_observe_the_same_motion(name):
    """Also the same extrema of the radius, which each kernel finds by its own means."""
    rotor, start = WINDOWS[name]
    problem = SettlingProblem.of(assemble(rotor.system()), 1e-12)
    other = SystemFlow.at(problem, rotor.omega, GO_ON)
    flow = DiscFlow(rotor, options=Options(method="taylor", rtol=1e-12))
    times = np.linspace(0.0, 12.0 * flow.revolution, 12 * 64 + 1)
    seen, same = flow.observed(start, times), other.observed(other.given_state(start), times)
    np.testing.assert_array_equal(same.event_kinds, seen.event_kinds)
    np.testing.assert_allclose(same.event_times, seen.event_times, atol=1e-8)
    np.testing.assert_array_equal(same.closed_first, seen.closed_first)
    np.testing.assert_array_equal(same.closed_last, seen.closed_last)
    np.testing.assert_allclose(same.rolling[0], seen.rolling[0], atol=1e-8)
    np.testing.assert_allclose(np.abs(same.places), np.abs(seen.places), atol=1e-8)
    (radii,), (exact,) = other.radii(same), flow.radii(seen)
    np.testing.assert_allclose(radii, exact, rtol=0.0, atol=1e-10)
