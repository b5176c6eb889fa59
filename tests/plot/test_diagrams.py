"""Pictures of sections and bifurcation diagrams of rotor systems, at one node or at all."""

import math
from functools import cache

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    bifurcation_diagram,
    dimensional,
    lyapunov_exponent,
    plot,
    poincare_section,
)
from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import plot_exponents, plot_extrema, plot_section
from rotor_ida.plot.figures import figure_of
from rotor_ida.plot.labels import KIND_WORDS
from rotor_ida.schema import words_of
from rotor_ida.units import SPEED_UNITS
from tests.plot.pictures import lines_of
from tests.plot.test_responses import two_discs

SPEEDS = [0.9, 1.1, 1.5]
DISC = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@cache
def found(at, **more):
    system, around = two_discs()
    return bifurcation_diagram(system, **around, speed=SPEEDS, at=at, revolutions=6, **more)


def drawn(ax):
    """Return the points that are drawn, of all lines without a label of a ring."""
    return np.concatenate([line.get_xydata() for line in ax.lines if line.get_rasterized()])


def test_extrema_at_a_node_are_those_of_the_node():
    diagram = found("extrema")
    for number, name in enumerate(("one", "two")):
        ax = plot.plot_extrema(diagram, node=name)
        counts = diagram.extremum_count.isel(node=number, start=0)
        first = diagram.extremum_row.isel(node=number, start=0)
        expected = [[speed, radius] for speed, row, count in
                    zip(SPEEDS, first.values, counts.values, strict=True)
                    for radius in diagram.extremum_radius.values[row : row + count]]  # fmt: skip
        assert sorted(drawn(ax).tolist()) == sorted(expected)
        assert ax.get_title() == f"node {name}"
        assert ax.get_xlabel() == r"spin speed $\omega$"
    assert plot.plot_extrema(diagram).get_title() == "node one"  # of the first contact
    with pytest.raises(InputError, match="node must be one of 'one', 'two', got 'three'"):
        plot.plot_extrema(diagram, node="three")
    with pytest.raises(InputError, match="exact must be left out for a rotor system"):
        plot.plot_extrema(diagram, exact=diagram)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_strobes_at_a_node_are_its_states_by_direction(axis):
    diagram = found("revolution", direction="both")
    ax = plot.plot_strobes(diagram, axis=axis, node="two")
    values = diagram[f"rotating_{axis}"].sel(node="two")
    across = np.broadcast_to(np.reshape(SPEEDS, (-1, 1, 1, 1)), values.shape)
    expected = np.stack([across, values.values], axis=-1).reshape(-1, 2)
    assert sorted(drawn(ax).tolist()) == sorted(expected.tolist())
    assert set(ax.get_legend_handles_labels()[1]) == {"going up", "going down"}
    assert ax.get_title() == "node two\nonce a revolution"
    alone = plot.plot_strobes(diagram.isel(direction=[0]))
    kinds = {KIND_WORDS[word] for word in words_of(diagram.response.isel(direction=0))}
    assert set(alone.get_legend_handles_labels()[1]) == kinds
    with pytest.raises(InputError, match="axis must be one of 'x', 'y', got 'z'"):
        plot.plot_strobes(diagram, axis="z")


def test_strobes_do_not_magnify_rounding_but_what_is_resolved():
    disc = bifurcation_diagram(Rotor(omega=0.3, zeta=0.5, delta0=9.0), omega=[0.3], starts=[REST],
                               at="revolution", revolutions=5)  # fmt: skip
    value = disc.rotating_x.values.mean()
    low, high = plot.plot_strobes(disc).get_ylim()
    assert low < 0.9 * value < value < 1.1 * value < high
    disc.rotating_x[...] = value * np.linspace(1.0, 1.001, 6)
    low, high = plot.plot_strobes(disc).get_ylim()
    assert high - low < 2e-3 * value


def test_strobes_of_a_disc_and_over_another_parameter():
    disc = bifurcation_diagram(DISC, zeta=[0.07, 0.1], starts=[REST], at="revolution",
                               revolutions=5, phase=math.pi / 2)  # fmt: skip
    ax = plot.plot_strobes(disc)
    assert ax.get_xlabel() == r"damping ratio $\zeta$"
    assert ax.get_title().endswith("\nunbalance at 90°")
    assert set(drawn(ax)[:, 0]) == {0.07, 0.1}
    assert len(figure_of(disc).axes) == 1
    system, around = two_discs()
    given = {"speed": 1.1, "at": "revolution", "revolutions": 3}
    over = bifurcation_diagram(system, **around, **given, clearance=[2.0, 3.0])
    ax = plot.plot_strobes(over, node="two")
    assert ax.get_xlabel() == "largest clearance"
    assert ax.get_title() == "node two,  speed 1.1\nonce a revolution"
    both = bifurcation_diagram(system, **around, **{**given, "speed": [1.0, 1.1]},
                               clearance=[2.0, 3.0])  # fmt: skip
    with pytest.raises(InputError, match="found must contain one clearance, got 2"):
        plot.plot_strobes(both)


@pytest.mark.parametrize("at", ["extrema", "revolution"])
def test_the_figure_has_a_panel_for_each_node_with_a_contact(at):
    figure = figure_of(found(at))
    assert [ax.get_title().splitlines()[0] for ax in figure.axes] == ["node one", "node two"]


def test_a_section_shows_the_ring_of_the_node_and_says_what_it_is():
    system, around = two_discs()
    given = {"speed": 1.5, "revolutions": 20, "skip": 50}
    section = poincare_section(system, **around, **given)
    ax = plot.plot_section(section, node="two")
    ring = lines_of(ax)["clearance"]
    np.testing.assert_allclose(np.hypot(*ring.get_data()), 0.8)
    assert ax.get_title().startswith("node two,  speed 1.5\nonce a revolution")
    points = section.sel(node="two")
    np.testing.assert_array_equal(ax.lines[-1].get_xdata(), points.rotating_x)
    assert len(figure_of(section).axes) == 2
    entries = poincare_section(system, **around, **given, at="entry", contact="two")
    own, other = (plot.plot_section(entries, node=name) for name in ("two", "one"))
    assert own.get_xlabel().startswith("angle from the mark")
    assert other.get_xlabel().startswith("along the mark")
    assert plot.plot_section(entries).get_title().startswith("node two")  # of that contact
    angle = own.lines[-1].get_xdata()
    at_two = entries.sel(node="two")
    np.testing.assert_allclose(np.exp(1j * angle), (at_two.rotating_x + 1j * at_two.rotating_y)
                               / 0.8, atol=1e-12)  # fmt: skip
    with pytest.raises(InputError, match="node must be left out for a result without nodes"):
        plot.plot_section(poincare_section(DISC, revolutions=3), node="disc")


def test_a_stator_aside_has_no_ring_on_turning_axes():
    system, _ = two_discs()
    aside = [Contact(node="two", clearance=0.8, stiffness=3.0, centre=(0.1, 0.0))]
    entries = poincare_section(
        system, contacts=aside, speed=1.5, revolutions=20, at="entry", start="settled"
    )
    ax = plot.plot_section(entries)
    assert ax.get_xlabel().startswith("along the mark")
    assert "clearance" not in [line.get_label() for line in ax.lines]


def test_in_si_units_speeds_are_in_rpm():
    system = Rotor(omega=1.0, zeta=0.3, delta0=0.5).system()
    si = type(system)(**{
        name: getattr(system, name) for name in ("mass", "stiffness", "damping", "nodes",
                                                 "contacts", "unbalance")
    })  # fmt: skip
    diagram = bifurcation_diagram(si, speed=[300.0, 400.0], at="revolution", revolutions=3)
    ax = plot.plot_strobes(diagram)
    assert ax.get_xlabel() == "spin speed [rpm]"
    turns = np.unique(drawn(ax)[:, 0])
    np.testing.assert_allclose(turns, np.array([300.0, 400.0]) / SPEED_UNITS["rpm"])
    assert "[" in ax.get_ylabel()
    few = {"transient": 5, "revolutions": 80, "batches": 4, "exponents": 1}
    ax = plot_exponents(lyapunov_exponent(si, speed=[300.0, 400.0], **few))
    np.testing.assert_allclose(ax.containers[0].lines[0].get_xdata(), turns)
    ax = plot_exponents(lyapunov_exponent(si, speed=300.0, damping=[0.1, 0.2], **few))
    assert ax.containers[0].lines[0].get_xdata().tolist() == [0.1, 0.2]


def test_the_clearance_is_drawn_once_over_an_exact_curve():
    """A second dashed line of the colour of whirls would look like an unstable one."""
    found = bifurcation_diagram(omega=[0.8, 1.2], zeta=0.07, delta0=0.5, starts=[REST])
    exact = response_curve(zeta=0.07, delta0=0.5, limits=(0.8, 1.2))
    ax = plot.plot_extrema(found, exact=exact)
    heights = [np.asarray(line.get_ydata()) for line in ax.lines]
    assert sum(each.size > 0 and bool((each == 0.5).all()) for each in heights) == 1


def test_extrema_beyond_the_model_do_not_set_the_scale_and_are_told():
    """In SI units no contact is known beyond an indentation by the clearance."""
    plain = bifurcation_diagram(DISC, omega=[1.8, 2.0], starts=[REST])
    gap = 2.0
    assert float(plain.extremum_radius.max()) > 2.0 * gap
    (ax,) = plot.plot_extrema(plain).figure.axes
    assert drawn(ax)[:, 1].max() == plain.extremum_radius.max()
    assert ax.get_ylim()[1] > float(plain.extremum_radius.max())
    machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=418.0, eccentricity=5e-6,
                               clearance=1e-5, speed=1495.0)  # fmt: skip
    ax = plot.plot_extrema(dimensional(plain, machine))
    lines = lines_of(ax)
    np.testing.assert_allclose(lines["clearance"].get_ydata(), 10.0)
    assert drawn(ax)[:, 1].max() <= 20.0
    assert 20.0 * 0.9 < ax.get_ylim()[1] < 20.0 * 1.2
    largest = 5.0 * plain.extremum_radius.max().item()
    (words,) = [label for label in lines if "beyond the model" in label]
    assert words.startswith("beyond the model: off the axis, ")
    assert words.endswith(f"{largest:.3g} µm")


def test_the_clearance_is_a_line_over_whatever_varies():
    over = bifurcation_diagram(omega=1.2, zeta=0.2, delta0=[0.5, 1.0], starts=[REST])
    lines = lines_of(plot.plot_extrema(over))
    assert lines["clearance"].get_xydata().tolist() == [[0.5, 0.5], [1.0, 1.0]]
    at_nodes = {name: plot.plot_extrema(found("extrema"), node=name) for name in ("one", "two")}
    for name, gap in (("one", 3.0), ("two", 0.8)):
        lines = {line.get_label(): line for line in at_nodes[name].lines}
        assert set(lines["clearance"].get_ydata()) == {gap}


@pytest.mark.parametrize("revolutions", [10, 20])
def test_entries_are_drawn_as_radial_velocity_over_the_angle(revolutions):
    """Also on both sides of half a turn, where the angle alone would part them."""
    section = poincare_section(BOUNCING, start=REST, revolutions=revolutions, at="entry")
    angle, velocity = plot_section(section).lines[0].get_data()
    assert (velocity > 0.0).all()
    z = section.rotating_x.values + 1j * section.rotating_y.values
    np.testing.assert_allclose(2.0 * np.exp(1j * angle), z, atol=1e-12)
    assert revolutions == 10 or np.ptp(angle) < np.ptp(np.angle(z))


def test_a_section_shows_the_ring_and_says_what_it_is():
    ax = plot_section(poincare_section(BOUNCING, start=REST, revolutions=5))
    np.testing.assert_allclose(np.hypot(*lines_of(ax)["clearance"].get_data()), 2.0)
    title = "$\\omega = 2$,  $\\zeta = 0.07$,  $\\delta_0 = 2$\nonce a revolution"
    assert ax.get_title() == title
    loaded = Rotor(omega=1.7, zeta=0.07, delta0=0.5, load=0.1)
    section = poincare_section(loaded, start=REST, revolutions=9, phase=0.5 * np.pi)
    assert plot_section(section).get_title().endswith("\nunbalance at 90°")
    free = poincare_section(
        Rotor(omega=1.0, zeta=0.5, delta0=9.0), start=REST, revolutions=5, at="exit"
    )
    assert [text.get_text() for text in plot_section(free).texts] == ["no crossing"]


def test_points_that_fall_together_are_counted_and_not_blown_up():
    section = poincare_section(BOUNCING, start=REST, revolutions=20, skip=150, at="entry")
    ax = plot_section(section)
    assert ax.get_title().endswith(" crossings, 1 point")
    low, high = ax.get_xlim()
    assert high - low > 0.1


def test_extrema_of_unresolved_motion_are_not_told_as_lasting():
    found = bifurcation_diagram(omega=[1.2, 2.0], zeta=0.07, delta0=2.0, starts=[REST])
    unresolved = found.assign(response=found.response * 0)
    unresolved.response.attrs = found.response.attrs
    words = plot_extrema(unresolved).get_legend_handles_labels()[1]
    assert words == ["extremum, free or unresolved", "clearance"]


def test_extrema_lie_over_the_exact_curve_of_their_clearance():
    found = bifurcation_diagram(omega=[1.2, 2.0], zeta=0.07, delta0=[0.5, 2.0], starts=[REST])
    exact = response_curve(zeta=0.07, delta0=2.0, limits=(0.5, 2.5))
    ax = plot_extrema(found, exact=exact)
    words = ax.get_legend_handles_labels()[1]
    assert "local maximum of $|z|$: bouncing" in words
    assert "stable whirl" in words
    heights = np.concatenate([line.get_ydata() for line in ax.lines if line.get_rasterized()])
    shown = found.extremum_radius.values[int(found.extremum_count[0, 0, 0, 0]) :]
    assert set(heights) <= set(shown)
    with pytest.raises(InputError, match="found must contain the delta0 of exact"):
        plot_extrema(found.sel(delta0=[0.5]), exact=exact)
    with pytest.raises(InputError, match="found must have the shaft_stiffness of exact"):
        plot_extrema(found.assign_coords(shaft_stiffness=[0.25]), exact=exact)
    with pytest.raises(InputError, match="found must contain one delta0, got 2"):
        plot_extrema(found)


def test_extrema_are_drawn_over_whatever_varies():
    machine = {"omega": 2.0, "zeta": 0.2, "delta0": 1.0, "starts": [(0, 0, 0, 0)]}
    for name, label in (("load", r"load $\gamma$"), ("contact_damping", "contact damping $c$")):
        found = bifurcation_diagram(**machine, **{name: [0.1, 0.3]}, method="taylor")
        ax = plot_extrema(found)
        assert ax.get_xlabel() == label
        assert ax.get_title() == r"$\omega = 2$,  $\zeta = 0.2$,  $\delta_0 = 1$"
        across = np.concatenate([each.get_xdata() for each in ax.lines])
        assert set(across) == {0.1, 0.3}
    both = {**machine, "delta0": [0.5, 1.0], "load": [0.1, 0.3]}
    found = bifurcation_diagram(**both, method="taylor")
    with pytest.raises(InputError, match="found must contain one load, got 2"):
        plot_extrema(found)


def test_exponents_of_several_points_are_drawn_over_the_parameter_that_varies():
    given = {"transient": 50.0, "duration": 200.0, "batches": 4}
    found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.1, delta0=0.5), zeta=[0.1, 0.2], **given)
    ax = plot_exponents(found)
    assert ax.get_xlabel() == r"damping ratio $\zeta$"
    lines = [each.lines[0] for each in ax.containers]
    for number, line in enumerate(lines):
        exponents = found.lyapunov_exponent.isel(exponent=number).values
        np.testing.assert_array_equal(line.get_xydata(), np.stack([[0.1, 0.2], exponents], axis=1))
    assert len(lines) == 4
    two = lyapunov_exponent(
        Rotor(omega=1.7, zeta=0.1, delta0=0.5), zeta=[0.1, 0.2], delta0=[0.5, 1.0], **given
    )
    with pytest.raises(InputError, match="found must contain one delta0, got 2"):
        plot_exponents(two)
