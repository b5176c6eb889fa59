"""Sections of limit cycles: from the set on them starts come back nearer, and end on the cycle."""

import numpy as np
import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.basins import cycle_sections
from rotor_ida.basins.cycle_sections import cycle_section
from rotor_ida.basins.kernel import measure_returns
from rotor_ida.cycles.guess import guess_of
from rotor_ida.cycles.limit_cycle import cycle_from
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc
from tests.basins.lanes import GO_ON, RUBBING, WHIP

CASES = [
    (Rotor(omega=2.0, zeta=0.07, delta0=2.0), (0.0, 0.0, 0.0, 0.0)),
    (Rotor(omega=3.0, zeta=0.07, delta0=0.5), (3.0, 1.0, 0.0, 0.0)),
    (Rotor(omega=1.7, zeta=0.07, delta0=2.0), (3.0, 1.0, 0.0, 0.0)),  # period 21
]


@pytest.fixture(scope="module", params=CASES, ids=["bouncing", "full contact", "six contacts"])
def section(request):
    rotor, start = request.param
    return cycle_section(cycle_from(guess_of(rotor, np.array(start))), GO_ON)


def states_on(section, size, count, seed=0):
    """Return random states of the section at ``|L (s - c)| = size``, shape (count, 4)."""
    directions = np.random.default_rng(seed).normal(size=(3, count))
    directions /= np.linalg.norm(directions, axis=0)
    return section.centre + size * (np.linalg.pinv(section.form) @ directions).T


def value_of(section, state):
    return float(np.sum((section.form @ (state - section.centre)) ** 2))


def test_a_section_that_cannot_be_found_holds_nothing(monkeypatch):
    """Starts then are followed to the cycle one by one; the rest of an atlas goes on."""

    def fails(*_):
        raise np.linalg.LinAlgError

    cycle = cycle_from(guess_of(CASES[0][0], np.zeros(4)))
    monkeypatch.setattr(cycle_sections, "_forms", fails)
    none = cycle_section(cycle, GO_ON)
    assert not none.exists
    assert np.isinf(none.row["centre"]).all()


def test_states_lie_on_the_section_and_the_cycle_passes_it(section):
    assert section.exists
    offsets = states_on(section, 1.0, 20) - section.centre
    np.testing.assert_allclose(offsets @ section.normal, 0.0, atol=1e-12)
    back = DiscFlow(section.cycle.rotor).run(section.centre, section.cycle.duration)
    assert value_of(section, back.end) < 1e-16
    np.testing.assert_allclose(back.start_rate / np.linalg.norm(back.start_rate), section.normal)


def test_other_states_come_back_nearer(section):
    """Not those on which the set was chosen."""
    period = section.cycle.duration
    for size in (1.0, 0.5, 0.1):
        states = np.ascontiguousarray(states_on(section, size, 300, seed=7).T)
        values = np.empty(300)
        measure_returns(
            states, section.cycle.rotor, section.row, (0.5 * period, 1.6 * period), 1e-9,
            values, GO_ON,
        )  # fmt: skip
        assert (values < size**2).all()


def test_the_kernel_reads_the_section_as_the_taylor_series_do(section):
    """The value at the return, by steps of the kernel and by the flow to rounding."""
    rotor, period = section.cycle.rotor, section.cycle.duration
    states = states_on(section, 0.5, 8, seed=3)
    values = np.empty(8)
    measure_returns(
        np.ascontiguousarray(states.T), rotor, section.row, (0.5 * period, 1.6 * period),
        1e-10, values, GO_ON,
    )  # fmt: skip
    for state, value in zip(states, values, strict=True):
        time = period
        for _ in range(8):
            shot = DiscFlow(rotor).run(state, time)
            ahead = float((shot.end - section.centre) @ section.normal)
            time -= ahead / float(shot.end_rate @ section.normal)
        assert value == pytest.approx(value_of(section, shot.end), abs=2e-3)


def test_cvode_ends_on_the_cycle_from_its_rim(section):
    for state in states_on(section, 1.0, 4, seed=5).tolist():
        settled = settle_disc(section.cycle.rotor, tuple(state), Options(rtol=1e-10))
        assert settled.features.period == pytest.approx(section.cycle.duration, rel=1e-8)
        assert settled.features.radius_max == pytest.approx(section.cycle.radius_max, rel=1e-8)


def test_close_to_a_graze_a_small_set_is_found():
    """The least radius is 2.004: a state farther off than that touches once more."""
    rotor = Rotor(omega=1.7126050420168066, zeta=0.07, delta0=2.0)
    section = cycle_section(cycle_from(guess_of(rotor, np.zeros(4))), GO_ON)
    assert section.cycle.duration == pytest.approx(10.655137, abs=1e-5)
    assert section.exists


def test_a_cycle_that_slides_forwards_holds_what_comes_back_and_never_rolls():
    """By CVODE from all over the set: no `roll`, no `reverse`, and the radius of the cycle."""
    rotor = RUBBING["that bounces"]
    cycle = cycle_from(guess_of(rotor, np.array([3.0, 1.0, 0.0, 0.0])))
    section = cycle_section(cycle, GO_ON)
    assert section.exists
    random = np.random.default_rng(2).normal(size=(3, 6))
    random *= 0.98 / np.linalg.norm(random, axis=0)
    for state in (section.centre[:, None] + np.linalg.pinv(section.form) @ random).T:
        run = simulate(rotor, start=state, duration=200.0, samples=40_001)
        assert set(run.event_kind.values.tolist()) <= {1, -1}
        largest = np.hypot(run.x, run.y)[-4000:].max()
        assert float(largest) == pytest.approx(cycle.radius_max, rel=1e-4)


def test_what_rolls_on_its_way_is_not_said_to_come_back():
    """States that come to roll are told by CVODE; without friction they would come back."""
    rotor = RUBBING["that bounces"]
    cycle = cycle_from(guess_of(rotor, np.array([3.0, 1.0, 0.0, 0.0])))
    row = cycle_section(cycle, GO_ON).row
    speeds = np.append(np.linspace(-30.0, -21.0, 12), np.linspace(-3.0, 3.0, 12))
    states = np.stack([np.full(24, 3.0), np.zeros(24), np.zeros(24), speeds])
    values = np.empty(24)
    measure_returns(states, rotor, row, (0.0, 30.0 * cycle.duration), 1e-10, values, GO_ON)
    first = []
    for state in states.T:
        run = simulate(rotor, start=state, duration=0.5 * cycle.duration, samples=2)
        first.append(bool((np.abs(run.event_kind) > 1).any()))
    assert first == 12 * [True] + 12 * [False]
    assert np.isinf(values[np.array(first)]).all()
    assert np.isfinite(values[~np.array(first)]).any()


def test_dry_whip_has_no_section():
    assert not cycle_section(
        cycle_from(guess_of(WHIP, np.array([5.0, 0.0, 0.0, -6.3]))), GO_ON
    ).exists
