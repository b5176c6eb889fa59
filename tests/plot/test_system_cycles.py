"""Figures of limit cycles of rotor systems: orbits, branches and curves of bifurcations."""

import numpy as np
import pytest

from rotor_ida import InputError, plot
from rotor_ida.plot.appearance import STABLE_CYCLE, UNSTABLE_CYCLE
from tests.example_datasets import a_system_branch, a_system_curve, a_system_cycle
from tests.plot.pictures import words_of


@pytest.fixture(scope="module")
def cycle():
    return a_system_cycle()


@pytest.fixture(scope="module")
def branch():
    return a_system_branch()


def lines(ax, label):
    return [line for line in ax.lines if line.get_label() == label]


def test_the_orbit_closes_and_reaches_the_largest_radius(cycle):
    ax = plot.plot_system_cycle(cycle)
    (orbit,) = lines(ax, STABLE_CYCLE)
    x, y = orbit.get_data()
    assert (x[0], y[0]) == pytest.approx((x[-1], y[-1]))
    assert np.hypot(x, y).max() == pytest.approx(cycle.radius_max.item(), rel=1e-3)
    assert len(lines(ax, "clearance")) == 1


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
        plot.plot_system_cycle(cycle, node="tip")
    with pytest.raises(InputError, match="contact must be one of 0 to 0, got 1"):
        plot.plot_branch(branch, contact=1)
    with pytest.raises(InputError, match="without one"):
        plot.plot_system_cycle(cycle.isel(t=slice(0, 0)))
