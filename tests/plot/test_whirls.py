"""Plots of the synchronous whirls of rotor systems, and of their eigenvalues."""

import numpy as np
import pytest

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    backward_whirl,
    campbell,
    clearance_report,
    plot,
    special_speeds,
    synchronous_response,
)
from rotor_ida.plot import plot_backward_whirl
from rotor_ida.plot.figures import figure_of
from rotor_ida.schema import SPECIAL
from tests.axisymmetric_systems import beam
from tests.plot.pictures import check_nothing_cut_off, lines_of, words_of

SPEEDS = np.linspace(300.0, 600.0, 31)
TOUCH = {"clearance": 1e-4, "stiffness": 5e6, "exponent": 1.0}
MACHINE = {"zeta": 0.02, "delta0": 1.0, "shaft_stiffness": 0.04, "contact_exponent": 1.0,
           "friction": 0.2, "disc_radius": 10.0}  # fmt: skip


@pytest.fixture(scope="module")
def whirls():
    return synchronous_response(
        beam(), contacts=[Contact(node="3", **TOUCH), Contact(node="6", **TOUCH)], speed=SPEEDS,
        unbalance=[Unbalance(node="3", moment=2e-4), Unbalance(node="7", moment=2e-4)],
    )  # fmt: skip


def test_every_whirl_is_a_mark_at_its_amplitude_in_rpm_and_micrometres(whirls):
    ax = plot.plot_amplitude(whirls, contact=1)
    assert ax.get_xlabel() == "spin speed [rpm]"
    assert ax.get_ylabel() == "amplitude $A$ [µm]"
    clearance, *marks = ax.lines
    assert clearance.get_ydata()[0] == pytest.approx(100.0)
    shown = np.sort(np.concatenate([line.get_ydata() for line in marks]))
    amplitude = whirls.amplitude.isel(contact=1).values
    np.testing.assert_allclose(shown, 1e6 * np.sort(amplitude[np.isfinite(amplitude)]))
    assert [line.get_label() for line in marks] == ["stable whirl"]
    with pytest.raises(InputError, match="contact must be one of 0 to 1, got 2"):
        plot.plot_amplitude(whirls, contact=2)


def test_folds_and_hopf_points_are_marked_on_the_whirls():
    system = Rotor(omega=1.0, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=5.0).system()
    special = special_speeds(system, limits=(0.9, 1.6))
    found = synchronous_response(system, speed=np.linspace(0.9, 1.6, 36))
    ax = plot.plot_amplitude(found, special=special)
    assert ax.get_xlabel() == r"spin speed $\omega$"
    marks = lines_of(ax)
    for label, kind in (("fold", SPECIAL["fold"]), ("Hopf point", SPECIAL["hopf"])):
        chosen = special.isel(special=(special.special_kind == kind).values)
        assert chosen.sizes["special"] == 2
        np.testing.assert_array_equal(marks[label].get_xdata(), chosen.special_speed)
        np.testing.assert_array_equal(marks[label].get_ydata(), chosen.amplitude[:, 0])


def test_each_contact_has_a_panel_and_without_any_the_nodes_are_drawn(whirls):
    assert [ax.get_title()[:9] for ax in figure_of(whirls).axes] == ["contact 0", "contact 1"]
    free = synchronous_response(beam(), unbalance=[Unbalance(node="3", moment=2e-4)], speed=SPEEDS)
    (ax,) = figure_of(free).axes
    assert len(ax.lines) == 5
    drawn = next(line for line in ax.lines if line.get_label() == "3")
    np.testing.assert_allclose(drawn.get_ydata(), 1e6 * free.node_major_axis.sel(node="3"))
    with pytest.raises(InputError, match="there is no contact"):
        plot.plot_amplitude(free)


def test_a_campbell_diagram_has_forward_and_backward_whirls():
    found = campbell(
        beam(), speed=SPEEDS, contacts=[Contact(node="3", **TOUCH)], modes=6,
        contact_stiffness=[0.0, 5e6],
    )  # fmt: skip
    (ax,) = figure_of(found).axes
    assert ax.get_ylabel() == "size of the whirl speed [rpm]"
    spin, *marks = (line for line in ax.lines if line.get_xdata().size)
    critical = marks.pop()
    np.testing.assert_allclose(spin.get_ydata(), SPEEDS * 30 / np.pi)
    assert sum(len(line.get_ydata()) for line in marks) == 2 * 6 * SPEEDS.size
    np.testing.assert_allclose(critical.get_xdata(), found.critical_speed * 30 / np.pi)
    np.testing.assert_array_equal(critical.get_xdata(), critical.get_ydata())
    words = words_of(ax)
    assert words == ["spin speed", "forward", "backward", "contacts 0 N/m", "contacts 5 MN/m",
                     "critical speed"]  # fmt: skip
    values = np.concatenate([line.get_ydata() for line in marks])
    drawn = values[values <= 3.0 * SPEEDS[-1] * 30 / np.pi].max()
    assert ax.get_ylim() == (0.0, pytest.approx(1.08 * drawn))
    check_nothing_cut_off(ax.figure)


def test_a_campbell_diagram_keeps_its_room_beside_a_wide_legend():
    found = campbell(
        beam(), speed=SPEEDS[::10], contacts=[Contact(node="3", **TOUCH)], modes=4,
        contact_stiffness=[0.0, 1e5, 1e6],
    )  # fmt: skip
    figure = figure_of(found)
    figure.draw_without_rendering()
    assert figure.axes[0].get_position().width > 0.6


def test_a_campbell_diagram_tells_growing_whirls_and_damped_criticals():
    """Damping 2.6 of the disc's translation crosses the spin speed with a ratio of 0.65."""
    cross = np.diag([0.0, 0, 0.5], 1) - np.diag([0.0, 0, 0.5], -1)
    system = RotorSystem(
        mass=np.eye(4), stiffness=np.diag([4.0, 4.0, 9.0, 9.0]) + cross,
        damping=np.diag([2.6, 2.6, 0.0, 0.0]), units="1",
        nodes={"disc": [[1, 0, 0.2, 0], [0, 1, 0, 0.2]]},
    )  # fmt: skip
    ax = plot.plot_campbell(campbell(system, speed=[1.0, 4.0]))
    drawn = {line.get_label(): line.get_xydata() for line in ax.lines}
    # a cross-coupling q of 0.5 lets one of the two whirls at 3 grow
    np.testing.assert_allclose(drawn["unstable"][:, 0], [1.0, 4.0])
    np.testing.assert_allclose(drawn["unstable"][:, 1], 3.0, atol=0.01)
    damped = np.sqrt(4.0 - 1.3**2)
    np.testing.assert_allclose(np.unique(drawn["amplification below 2.5"][:, 0]), damped)
    assert (drawn["critical speed"][:, 0] > 2.9).all()


def test_special_speeds_are_drawn_on_their_whirls_at_each_contact():
    special = special_speeds(
        beam(), contacts=[Contact(node="3", **TOUCH), Contact(node="6", **TOUCH)], points=31,
        unbalance=[Unbalance(node="3", moment=2e-5), Unbalance(node="7", moment=2e-5)],
        limits=(300.0, 700.0),
    )  # fmt: skip
    axes = figure_of(special).axes
    assert [ax.get_title() for ax in axes] == ["contact 0 at node 3", "contact 1 at node 6"]
    assert (special.special_kind == SPECIAL["graze"]).sum() == 4
    for number, ax in enumerate(axes):
        grazes = (special.grazed_contact == number).values
        assert grazes.sum() == 2
        marks = lines_of(ax)
        drawn = marks["graze"]
        np.testing.assert_allclose(drawn.get_xdata(), special.special_speed[grazes] * 30 / np.pi)
        np.testing.assert_allclose(
            drawn.get_ydata(), 1e6 * special.amplitude.values[grazes, number]
        )
        np.testing.assert_allclose(drawn.get_ydata(), 100.0)  # the clearance
        shown = np.concatenate(
            [marks[f"{each} whirl"].get_ydata() for each in ("stable", "unstable")]
        )
        branches = special.branch_amplitude.isel(contact=number).values
        np.testing.assert_allclose(np.sort(shown), 1e6 * np.sort(branches[np.isfinite(branches)]))
    with pytest.raises(InputError, match="it lacks branch_amplitude"):
        plot.plot_amplitude(special.drop_vars("branch_amplitude"))


def test_thresholds_are_drawn_where_no_whirl_is_exact():
    # unit mass on unequal springs with damping c: (s**2 + c s + k)**2 - d**2 + q**2 = 0, with the
    # mean k and half the difference d, has s = i sqrt(k) at q**2 = c**2 k + d**2
    q = [[0.0, 0.1], [-0.1, 0.0]]
    growing = Bearing(node="0", speed=(0.1, 10.1), damping=np.stack([0.2 * np.eye(2)] * 2),
                      stiffness=np.array([np.zeros((2, 2)), 100.0 * np.array(q)]))  # fmt: skip
    system = RotorSystem(mass=np.eye(2), stiffness=np.diag([1.0, 1.001]), bearings=[growing],
                         nodes={"0": (0, 1)},
                         contacts=[Contact(node="0", clearance=2.0, stiffness=1.0)],
                         unbalance=[Unbalance(node="0", moment=0.1)])  # fmt: skip
    special = special_speeds(system, limits=(0.2, 1.0))
    assert "not_exact" in special.attrs
    (line,) = [each for each in figure_of(special).axes[0].lines
               if each.get_label() == "threshold of instability"]  # fmt: skip
    assert "0" in [each.get_label() for each in figure_of(special).axes[0].lines]  # its response
    threshold = 0.1 + np.hypot(0.2 * np.sqrt(1.0005), 0.0005)  # q grows by 1 per unit of speed
    assert line.get_xdata()[0] == pytest.approx(threshold * 30 / np.pi, rel=1e-6)


def test_a_clearance_report_is_drawn_with_its_limits_and_critical_speeds():
    report = clearance_report(
        beam(), contacts=[Contact(node="3", **TOUCH), Contact(node="6", **TOUCH)],
        probes=["1", "9"], speed=(800.0, 1100.0, 1200.0), points=50,
    )  # fmt: skip
    axes = figure_of(report).axes
    assert [ax.get_title() for ax in axes] == [
        "contact 0 at node 3: passes", "contact 1 at node 6: passes"
    ]  # fmt: skip
    for number, ax in enumerate(axes):
        assert ax.get_xlabel() == "spin speed [rpm]"
        assert ax.get_ylabel() == "scaled orbit, peak to peak [µm]"
        lines = lines_of(ax)
        assert lines["diametral clearance"].get_ydata()[0] == pytest.approx(200.0)
        assert lines["75 % of it"].get_ydata()[0] == pytest.approx(150.0)
        assert lines["critical speed"].get_xdata()[0] == pytest.approx(
            report.critical_speed.values[0] * 30 / np.pi
        )
        for case in range(report.sizes["case"]):
            scaled = report.scale_factor[case] * report.major_axis.isel(case=case, contact=number)
            np.testing.assert_allclose(lines[f"case {case}"].get_ydata(), 1e6 * scaled)
        assert ax.get_ylim()[1] > 200.0
    check_nothing_cut_off(axes[0].figure)
    with pytest.raises(InputError, match="contact must be one of 0 to 1, got 2"):
        plot.plot_clearance(report, contact=2)


def test_the_shapes_of_whirls_are_those_of_their_nodes(whirls):
    """Along the direction of the node that moves most; the speed is the nearest."""
    ax = plot.plot_whirl_shapes(whirls, speed=451.0)
    row = int(np.argmin(np.abs(SPEEDS - 451.0)))
    assert ax.get_title() == f"{SPEEDS[row] * 30 / np.pi:,.0f} rpm"
    here = whirls.isel(speed=row)
    lines = [line for line in ax.lines if len(line.get_ydata()) == 11]
    assert len(lines) == int((here.stability >= 0).sum())
    place = np.exp(-1j * here.node_phase_lag) * here.node_amplitude
    for branch, line in enumerate(lines):
        moved = place.isel(branch=branch).values
        largest = moved[np.abs(moved).argmax()]
        shown = 1e6 * (moved * np.conj(largest)).real / abs(largest)
        np.testing.assert_allclose(np.sort(line.get_ydata()), np.sort(shown))
    with pytest.raises(InputError, match=r"speed must lie from 300 to 600, got 700\.0"):
        plot.plot_whirl_shapes(whirls, speed=700.0)
    assert plot.plot_whirl_shapes(whirls).get_title() != ax.get_title()


def test_both_whirls_are_circles_of_their_radii_told_by_line_and_words():
    whirls = backward_whirl(Rotor(omega=0.5, **MACHINE))
    ax = plot_backward_whirl(whirls)
    ring, slipping, rolling = ax.lines
    radii = [np.hypot(*line.get_data()) for line in (ring, slipping, rolling)]
    np.testing.assert_allclose([each.max() for each in radii], [1.0, *whirls.amplitude.values])
    np.testing.assert_allclose([each.min() for each in radii], [1.0, *whirls.amplitude.values])
    assert slipping.get_label().startswith("slipping whirl: unstable")
    assert rolling.get_label().startswith("dry whip: stable")
    assert slipping.get_linestyle() != rolling.get_linestyle()
    assert ax.get_xlim()[1] > whirls.amplitude.values.max()
    assert r"$\rho = 10$" in ax.get_title()
    # both go backwards: with y up, clockwise
    for arrow in ax.texts:
        (x, y), (to_x, to_y) = arrow.xyann, arrow.xy
        assert x * to_y - y * to_x < 0.0


@pytest.mark.parametrize(
    ("changes", "told"),
    [({"omega": 0.01}, r"no dry whip below $\omega = 0.0346$"),
     ({"omega": 0.5, "friction": 0.01, "zeta": 0.2}, "no dry whip at any speed")],
)  # fmt: skip
def test_where_there_is_no_whirl_it_is_said_why(changes, told):
    ax = plot_backward_whirl(backward_whirl(Rotor(**MACHINE | changes)))
    assert [text.get_text() for text in ax.texts] == [told]
    assert len(ax.lines) == 1


def test_circles_too_small_to_be_seen_are_drawn_once_more_enlarged():
    wide = Rotor(omega=0.24, zeta=0.006, delta0=9.0, shaft_stiffness=0.04, contact_exponent=1.0,
                 friction=0.12, disc_radius=3590.0)  # fmt: skip
    whirls = backward_whirl(wide)
    ax = plot_backward_whirl(whirls)
    (inset,) = ax.child_axes
    (_, slipping, _) = (line.get_xdata().max() for line in inset.lines)
    assert slipping == pytest.approx(whirls.amplitude[0].item())
    assert inset.get_xlim()[1] == pytest.approx(1.1 * slipping)
    assert not plot_backward_whirl(backward_whirl(Rotor(omega=0.5, **MACHINE))).child_axes


def test_without_damping_there_is_whip_alone():
    (_, whip) = plot_backward_whirl(
        backward_whirl(Rotor(omega=0.5, **MACHINE | {"zeta": 0.0}))
    ).lines
    assert whip.get_label().startswith("dry whip: neutral")
