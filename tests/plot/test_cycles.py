"""Pictures of limit cycles, their branches and their bifurcation curves."""

import math

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, bifurcation_curve, continue_cycle, folds, limit_cycle, plot
from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import (
    cycle_figure,
    cycles_figure,
    plot_amplitude,
    plot_branch,
    plot_curves,
    plot_cycle,
    plot_lines,
    plot_multipliers,
    plot_orbit,
    plot_trace,
)
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.legends import STABLE_CYCLE, UNSTABLE_CYCLE
from rotor_ida.schema import labelled
from tests.example_datasets import a_cycle, a_system_branch, a_system_curve, a_system_cycle
from tests.plot.pictures import BOUNCING, line_of, lines_of, made, words_of
from tests.plot.test_every_picture import in_units


@pytest.fixture(scope="module")
def cycle():
    return made("cycle")


@pytest.fixture(scope="module")
def branch():
    """Stable and unstable cycles, with a fold, period doublings and grazes: it folds back."""
    return made("branch")


@pytest.fixture(scope="module")
def curve(branch):
    start = branch.isel(special=int(np.argmax(branch.special_kind.values == 2)))
    limits = {"omega": (0.3, 2.0), "delta0": (1.5, 2.5)}
    return bifurcation_curve(BOUNCING, start=start, kind="period_doubling", limits=limits)


def bands_of(ax):
    """Return what is filled, as the parameter and the edges of each piece."""
    pieces = [each.get_paths()[0].vertices for each in ax.collections if each.get_paths()]
    return [piece for piece in pieces if len(piece)]


def test_orbit_goes_once_round_outside_and_inside_the_ring(cycle):
    ax = plot_cycle(cycle)
    lines = lines_of(ax)
    flight, contact = (np.hypot(*lines[name].get_data()) for name in ("flight", "contact"))
    assert np.nanmax(flight) <= 2.0 + 1e-12
    assert np.nanmin(contact) >= 2.0 - 1e-5  # its ends lie on the chord of two samples
    np.testing.assert_allclose(np.nanmax(contact), cycle.radius_max, rtol=1e-4)
    for name in ("entry", "exit"):
        assert lines[name].get_xdata().size == cycle.contact_count
        np.testing.assert_allclose(np.hypot(*lines[name].get_data()), 2.0, rtol=1e-5)
    np.testing.assert_allclose(np.hypot(*lines["clearance"].get_data()), 2.0)
    assert ax.get_aspect() == 1.0
    assert (ax.get_xlabel(), ax.get_ylabel()) == (LABELS["rotating_x"], LABELS["rotating_y"])


def test_full_contact_has_no_events_and_no_ring_without_clearance():
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    found = limit_cycle(rotor, start=(1.2279, -0.1301, 0.7419, -2.9153), period=3.1152)
    assert set(lines_of(plot_cycle(found))) == {"clearance", "contact"}
    # no cycle without clearance is needed to see that no ring is drawn
    assert set(lines_of(plot_cycle(found.assign_coords(delta0=0.0)))) == {"contact"}


def test_multipliers_lie_on_their_circles(cycle):
    lines = lines_of(plot_multipliers(cycle))
    q = math.exp(-2.0 * 0.07 * cycle.period)
    along, others = (
        np.array(lines[name].get_data()) for name in ("1 and $q$", r"$\mu$ and $q/\mu$")
    )
    np.testing.assert_allclose(np.sort(along[0]), [q, 1.0], rtol=1e-12)
    np.testing.assert_allclose(np.hypot(*others), math.sqrt(q), rtol=1e-12)
    circles = [line for line in lines.values() if len(line.get_xdata()) > 100]
    radii = [np.hypot(*circle.get_data())[0] for circle in circles]
    np.testing.assert_allclose(radii, [1.0, math.sqrt(q)])


def test_lines_are_those_of_the_spectrum(cycle):
    lines = lines_of(plot_lines(cycle))
    ratio, height = lines["spin speed"].get_data()
    np.testing.assert_allclose(ratio, [1.0])
    assert height[0] == cycle.whirl_amplitude.values[cycle.line_kind.values == 0]
    assert (lines["backward whirl"].get_xdata() < 0.0).all()
    assert (lines["forward whirl"].get_xdata() > 0.0).all()
    strongest = np.argmax(lines["forward whirl"].get_ydata())
    np.testing.assert_allclose(
        lines["forward whirl"].get_xdata()[strongest], cycle.side_line_over_spin
    )


@pytest.mark.parametrize("convert", [lambda each: each, in_units])
def test_slip_and_rolling_along_a_cycle_are_distinguished(convert):
    """This whip rolls while it is near the stator, and slips on the rest of its way."""
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    cycle = limit_cycle(rotor, start=(6.928, 0.0, 0.0, -10.0))
    slip = 10.0 + (cycle.x * cycle.vy - cycle.y * cycle.vx) / np.hypot(cycle.x, cycle.y)
    lines = lines_of(plot_cycle(convert(cycle)))
    assert {"rolls", "slips forwards"} < set(lines)
    assert not {"slips backwards", "flight", "contact"} & set(lines)
    drawn = np.isfinite(lines["rolls"].get_xdata()).sum()
    assert drawn == (abs(slip) < 1e-9).sum() > 400


def test_bands_do_not_turn_back(branch):
    """Each piece of a band has one height over every value of the parameter."""
    pieces = bands_of(plot_branch(branch))
    assert len(pieces) > 3
    for piece in pieces:
        x = piece[:, 0]
        turns = np.flatnonzero(np.diff(np.sign(np.diff(x)[np.diff(x) != 0.0])))
        assert turns.size <= 2  # there and back, as an outline goes


def test_bands_cover_the_whole_branch(branch):
    drawn = np.concatenate(bands_of(plot_branch(branch)))
    for name in ("radius_min", "radius_max"):
        for omega, radius in zip(branch.omega.values, branch[name].values, strict=True):
            assert (drawn == [omega, radius]).all(axis=1).any()


def test_stable_edges_are_solid_and_unstable_ones_dashed(branch):
    lines = lines_of(plot_branch(branch))
    for word, flag in (("stable cycle", 1), ("unstable cycle", 0)):
        points = lines[word].get_xydata()
        here = branch.isel(point=branch.stability.values == flag)
        for omega, radius in zip(here.omega.values, here.radius_max.values, strict=True):
            assert (points == [omega, radius]).all(axis=1).any()
    assert lines["stable cycle"].get_linestyle() == "-"
    assert lines["unstable cycle"].get_linestyle() == "--"


def test_special_points_are_marked_and_named(branch):
    ax = plot_branch(branch)
    lines = lines_of(ax)
    for word, flag in (("fold of cycles", 1), ("period doubling", 2), ("graze", 3)):
        here = branch.special_kind.values == flag
        assert here.any()
        np.testing.assert_array_equal(lines[word].get_xdata(), branch.special_value.values[here])
        np.testing.assert_array_equal(
            lines[word].get_ydata(), branch.special_radius_max.values[here]
        )
    assert words_of(ax) == [
        "bouncing cycle: range of $|z|$",
        "full-contact cycle: range of $|z|$",
        "stable cycle",
        "unstable cycle",
        "fold of cycles",
        "period doubling",
        "graze",
        "clearance",
    ]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (LABELS["omega"], LABELS["radius"])
    assert ax.get_title() == r"$\zeta = 0.07$,  $\delta_0 = 2$"
    assert ax.get_ylim()[1] > branch.radius_max.max()


def test_the_axis_of_a_flat_branch_is_about_its_radii_but_never_about_their_rounding(branch):
    flat = branch.isel(special=slice(0, 0)).copy(deep=True)
    across = np.linspace(0.0, 1.0, flat.sizes["point"])
    flat.radius_min[:], flat.radius_max[:] = 3.0 + 0.01 * across, 3.1 + 0.01 * across
    assert plot_branch(flat).get_ylim() == pytest.approx((3.0 - 0.0066, 3.11 + 0.0066))
    flat.radius_min[:], flat.radius_max[:] = 3.0, 3.0 + 1e-9 * across
    assert plot_branch(flat).get_ylim() == pytest.approx((2.7, 3.3))
    assert plot_branch(branch).get_ylim()[0] == 0.0


def test_branches_lie_over_the_exact_curve_and_under_the_marks(branch, simulated):
    exact = response_curve(zeta=0.07, delta0=2.0, limits=(0.05, 3.0))
    sweep = simulated.assign_coords(delta0=[2.0])
    ax = plot_amplitude(exact, simulated=sweep, fold_points=folds(zeta=0.07, delta0=2.0))
    before, top, right = ax.get_title(), ax.get_ylim()[1], ax.get_xlim()[1]
    marks = [line.get_zorder() for line in ax.lines if line.get_zorder() >= 3.0]
    plot_branch(branch, ax=ax)
    plot_branch(branch.isel(point=slice(0, 5)), ax=ax)
    assert (ax.get_title(), ax.get_ylim()[1], ax.get_xlim()[1]) == (before, top, right)
    assert ax.get_ylabel() == LABELS["amplitude"]
    words = words_of(ax)
    assert len(words) == len(set(words))
    assert words[:4] == ["stable whirl", "unstable whirl", "contact-free whirl", "fold"]
    assert {"bouncing: range of $|z|$", "bouncing cycle: range of $|z|$"} <= set(words)
    lines = lines_of(ax)
    assert lines["period doubling"].get_zorder() < min(marks)
    colours = {lines[name].get_color() for name in ("stable whirl", "stable cycle")}
    assert len(colours) == 2


def test_curves_are_drawn_beside_the_folds_of_the_whirl(curve):
    closed = folds(zeta=0.07, delta0=np.linspace(0.0, 3.0, 31))
    ax = plot_curves(curve, fold_points=closed)
    lines = lines_of(ax)
    np.testing.assert_array_equal(lines["period doubling"].get_xdata(), curve.omega)
    np.testing.assert_array_equal(lines["period doubling"].get_ydata(), curve.delta0)
    shown = lines["fold of the whirl"].get_xdata()
    np.testing.assert_array_equal(
        np.sort(shown[np.isfinite(shown)]),
        np.sort(closed.fold_omega.values[closed.fold_omega.notnull()]),
    )
    assert (ax.get_xlabel(), ax.get_ylabel()) == (LABELS["omega"], LABELS["delta0"])
    assert ax.get_title() == r"$\zeta = 0.07$"


def test_curves_of_several_dampings_are_told_apart(curve):
    other = curve.assign_coords(zeta=0.08)
    ax = plot_curves([curve, other])
    assert words_of(ax) == [r"period doubling, $\zeta = 0.07$", r"period doubling, $\zeta = 0.08$"]
    assert len({line.get_color() for line in ax.lines}) == 2
    again = plot_curves([curve, curve])
    assert words_of(again) == ["period doubling"]


def test_curves_turned_over_come_to_the_same_place(curve):
    turned = curve.assign_attrs(parameters="delta0 omega")
    ax = plot_curves([curve, turned])
    for line in ax.lines:
        np.testing.assert_array_equal(line.get_xdata(), curve.omega)


def test_cusps_are_marked(curve):
    columns = {
        "special_kind": np.array([4], np.int8), "special_value": [1.2],
        "special_second_value": [0.4], "special_point": [3],
    }  # fmt: skip
    cusps = curve.drop_dims("special").assign(
        {name: labelled(name, "special", values) for name, values in columns.items()}
    )
    marks = lines_of(plot_curves(cusps))["cusp"]
    np.testing.assert_array_equal(marks.get_xydata(), [[1.2, 0.4]])


def test_what_cannot_be_drawn_is_refused(cycle, branch, curve):
    none = cycle.assign(period=cycle.period * math.nan)
    for draw in (plot_cycle, plot_multipliers, plot_lines, cycle_figure):
        with pytest.raises(InputError, match="cycle must contain a limit cycle"):
            draw(none)
    missed = limit_cycle(Rotor(omega=1.7, zeta=0.07, delta0=0.0))
    for draw in (plot_orbit, plot_trace, plot_multipliers, cycle_figure):
        with pytest.raises(InputError, match="must contain a limit cycle, but the search found no"):
            draw(missed)
    with pytest.raises(InputError, match="branch must name what was varied in its attribute"):
        plot_branch(branch.drop_attrs(deep=False))
    with pytest.raises(InputError, match="it lacks"):
        plot_branch(cycle)
    with pytest.raises(InputError, match="curves must contain at least one"):
        plot_curves([])
    with pytest.raises(InputError, match="it lacks special_second_value"):
        plot_curves(branch)
    over_zeta = curve.assign_attrs(parameters="zeta omega")
    with pytest.raises(InputError, match=r"curves must all be over omega and delta0, got zeta and"):
        plot_curves([curve, over_zeta])
    with pytest.raises(InputError, match=r"fold_points must have the zeta of the curves, 0\.07"):
        plot_curves(curve, fold_points=folds(zeta=0.1, delta0=[0.0, 1.0]))


def test_torus_points_and_what_stands_still_are_drawn():
    """Of a rotor under a load, beside its curve of torus points."""
    machine = Rotor(omega=1.6, zeta=0.05, delta0=0.75, load=1.6, shaft_stiffness=1.0,
                    contact_exponent=1.0, contact_damping=0.5)  # fmt: skip
    loaded = limit_cycle(machine, start=(0, -1, 0, 0))
    words = plot_lines(loaded).get_legend_handles_labels()[1]
    assert "static" in words
    ax = plot_multipliers(loaded)
    assert ax.get_legend_handles_labels()[1] == ["others"]
    assert sum(line.get_xdata().size for line in ax.lines if line.get_ls() == "None") == 4
    found = continue_cycle(machine, start=loaded, parameter="contact_damping", limits=(0.4, 0.7))
    ax = plot_branch(found)
    mark = line_of(ax, "torus")
    assert mark.get_xdata().tolist() == found.special_value.values.tolist()
    curve = bifurcation_curve(
        machine, start=found.isel(special=0), kind="torus",
        parameters=("contact_damping", "omega"), limits=((0.4, 0.7), (1.58, 1.62)),
    )  # fmt: skip
    line = line_of(plot_curves(curve), "torus")
    assert line.get_xdata().tolist() == curve.contact_damping.values.tolist()


def test_cycles_at_points_are_drawn_over_the_parameter_that_varies():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    found = limit_cycle(rotor, omega=[2.0, 1.9, 2.5])
    period, radius = cycles_figure(found).axes
    assert radius.get_xlabel() == r"spin speed $\omega$"
    rising = found.sortby("omega")
    for line, name in ((period.lines[0], "period"), (radius.lines[0], "radius_min")):
        np.testing.assert_array_equal(line.get_xdata(), rising["omega"])
        np.testing.assert_array_equal(line.get_ydata(), rising[name])
    low, high = radius.get_xlim()
    assert low < 1.9
    assert high > 2.5  # where there is no cycle
    same = found.assign(period=found.period.copy(data=4.5 + np.array([0.0, 1e-9, np.nan])))
    low, high = cycles_figure(same).axes[0].get_ylim()
    assert low < 4.1
    assert high > 4.9
    system = limit_cycle(rotor.system(), speed=[1.9, 2.0])
    system.speed.attrs["units"] = "s-1"
    np.testing.assert_allclose(
        cycles_figure(system).axes[0].lines[0].get_xdata(), [1.9 * 30 / np.pi, 2.0 * 30 / np.pi]
    )
    both = limit_cycle(rotor, omega=[1.9, 2.0], zeta=[0.07, 0.08])
    with pytest.raises(InputError, match="cycles must contain one zeta, got 2"):
        cycles_figure(both)
    none = cycles_figure(limit_cycle(rotor, omega=[2.5, 2.6]))
    assert [text.get_text() for text in none.axes[0].texts] == ["no limit cycle"]


def test_the_orbit_of_a_disc_is_the_same_as_that_of_a_system():
    system_cycle = a_system_cycle()
    system, disc = (lines_of(plot.plot_cycle(each)) for each in (system_cycle, a_cycle()))
    assert set(system) == set(disc) == {"clearance", "flight", "contact", "entry", "exit"}
    for name in system:  # the system_cycle begins elsewhere, on axes that turn from elsewhere
        radii = [np.hypot(*each[name].get_data()) for each in (system, disc)]
        ends = [(np.nanmin(each), np.nanmax(each)) for each in radii]
        np.testing.assert_allclose(*ends, rtol=1e-3)
    system, disc = (plot.cycle_figure(each).axes for each in (system_cycle, a_cycle()))
    assert [ax.get_xlabel() for ax in system[1:]] == [disc[1].get_xlabel()]
    known, others = (lines_of(system[1])[word] for word in ("1, of a shift", "others"))
    assert known.get_xdata() == pytest.approx(1.0, abs=1e-6)
    both = [np.concatenate([line.get_xdata() for line in ax.lines if line.get_ls() == "None"])
            for ax in (system[1], disc[1])]  # fmt: skip
    np.testing.assert_allclose(*map(np.sort, both), atol=1e-6)
    assert others.get_xdata().size == 3


def test_a_cycle_in_a_stator_that_moves_is_an_orbit_without_contact():
    moving = a_system_cycle().assign(contact_stator=("contact", ["0"]))
    assert set(lines_of(plot.plot_cycle(moving))) == {"orbit"}


def test_the_branch_changes_its_line_at_the_bifurcation():
    """Stable above the period doubling, unstable below it, and joined there."""
    system_branch = a_system_branch()
    ax = plot.plot_branch(system_branch)
    stable, unstable = line_of(ax, STABLE_CYCLE), line_of(ax, UNSTABLE_CYCLE)
    bifurcation = system_branch.special_value.item()
    assert np.nanmin(stable.get_xdata()) == np.nanmax(unstable.get_xdata()) == bifurcation
    radii = {system_branch.special_radius_min.item(), system_branch.special_radius_max.item()}
    assert {*stable.get_ydata()[stable.get_xdata() == bifurcation]} == radii
    assert ax.get_title() == "contact 0 at disc"
    assert line_of(ax, "clearance")


def test_a_curve_is_drawn_over_its_two_parameters():
    curve = a_system_curve()
    ax = plot.plot_curves(curve)
    line = line_of(ax, "period doubling")
    np.testing.assert_array_equal(line.get_xdata(), curve.speed)
    np.testing.assert_array_equal(line.get_ydata(), curve.clearance)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"spin speed $\omega$", "largest clearance")
    curve.clearance.attrs["units"] = curve.special_second_value.attrs["units"] = "m"
    line = line_of(plot.plot_curves(curve), "period doubling")
    np.testing.assert_allclose(line.get_ydata(), 1e6 * curve.clearance)
