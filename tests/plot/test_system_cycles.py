"""Figures of limit cycles of rotor systems: orbits, branches and curves of bifurcations."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, limit_cycle, plot
from rotor_ida.plot.appearance import STABLE_CYCLE, UNSTABLE_CYCLE
from tests.kinds import a_cycle, a_system_branch, a_system_curve, a_system_cycle
from tests.plot.pictures import lines_of, words_of


@pytest.fixture(scope="module")
def cycle():
    return a_system_cycle()


@pytest.fixture(scope="module")
def branch():
    return a_system_branch()


def lines(ax, label):
    return [line for line in ax.lines if line.get_label() == label]


def test_the_orbit_of_a_disc_is_the_same_as_that_of_a_system(cycle):
    system, disc = (lines_of(plot.plot_cycle(each)) for each in (cycle, a_cycle()))
    assert set(system) == set(disc) == {"clearance", "flight", "contact", "entry", "exit"}
    for name in system:  # the cycle begins elsewhere, on axes that turn from elsewhere
        radii = [np.hypot(*each[name].get_data()) for each in (system, disc)]
        ends = [(np.nanmin(each), np.nanmax(each)) for each in radii]
        np.testing.assert_allclose(*ends, rtol=1e-3)
    system, disc = (plot.cycle_figure(each).axes for each in (cycle, a_cycle()))
    assert [ax.get_xlabel() for ax in system[1:]] == [disc[1].get_xlabel()]
    known, others = (lines_of(system[1])[word] for word in ("1, of a shift", "others"))
    assert known.get_xdata() == pytest.approx(1.0, abs=1e-6)
    both = [np.concatenate([line.get_xdata() for line in ax.lines if line.get_ls() == "None"])
            for ax in (system[1], disc[1])]  # fmt: skip
    np.testing.assert_allclose(*map(np.sort, both), atol=1e-6)
    assert others.get_xdata().size == 3


def test_slip_and_rolling_of_a_system_are_those_of_the_disc():
    disc = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    x, y, vx, vy = 6.928, 0.0, 0.0, -10.0
    of_disc = limit_cycle(disc, start=(x, y, vx, vy))
    of_system = limit_cycle(disc.system(), speed=1.0, start=([x, y], [vx, vy]))
    parts = [lines_of(plot.plot_cycle(each)) for each in (of_disc, of_system)]
    assert {"rolls", "slips forwards"} < set(parts[0]) == set(parts[1])


def test_a_cycle_in_a_stator_that_moves_is_an_orbit_without_contact(cycle):
    moving = cycle.assign(contact_stator=("contact", ["0"]))
    assert set(lines_of(plot.plot_cycle(moving))) == {"orbit"}


def test_the_branch_changes_its_line_at_the_bifurcation(branch):
    """Stable above the period doubling, unstable below it, and joined there."""
    ax = plot.plot_branch(branch)
    (stable,), (unstable,) = lines(ax, STABLE_CYCLE), lines(ax, UNSTABLE_CYCLE)
    bifurcation = branch.special_value.item()
    assert np.nanmin(stable.get_xdata()) == np.nanmax(unstable.get_xdata()) == bifurcation
    radii = {branch.special_radius_min.item(), branch.special_radius_max.item()}
    assert {*stable.get_ydata()[stable.get_xdata() == bifurcation]} == radii
    assert ax.get_title() == "contact 0 at disc"
    assert len(lines(ax, "clearance")) == 1


def test_a_curve_is_drawn_over_its_two_parameters():
    curve = a_system_curve()
    ax = plot.plot_curves(curve)
    (line,) = lines(ax, "period doubling")
    np.testing.assert_array_equal(line.get_xdata(), curve.speed)
    np.testing.assert_array_equal(line.get_ydata(), curve.clearance)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"spin speed $\omega$", "largest clearance")
    curve.clearance.attrs["units"] = curve.special_second_value.attrs["units"] = "m"
    (line,) = lines(plot.plot_curves(curve), "period doubling")
    np.testing.assert_allclose(line.get_ydata(), 1e6 * curve.clearance)


def test_two_branches_share_axes_and_one_entry_of_the_legend(branch):
    ax = plot.plot_branch(branch)
    plot.plot_branch(branch, ax=ax)
    words = words_of(ax)
    assert len(words) == len(set(words))


def test_figures_of_results_of_another_kind_are_refused(cycle, branch):
    with pytest.raises(InputError, match="branch must"):
        plot.plot_branch(cycle)
    with pytest.raises(InputError, match="node must be one of 'disc', got 'tip'"):
        plot.plot_cycle(cycle, node="tip")
    with pytest.raises(InputError, match="contact must be one of 0 to 0, got 1"):
        plot.plot_branch(branch, contact=1)
