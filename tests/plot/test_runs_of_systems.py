"""Plots of runs of rotor systems show what the dataset holds, in its units."""

import numpy as np
import pytest
from matplotlib.colors import same_color

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    run_up,
    signals_of,
    simulate,
)
from rotor_ida.plot import plot_forces, plot_node_orbits, plot_orbit, plot_run, plot_shape
from rotor_ida.plot.figures import figure_of
from rotor_ida.plot.palette import BLUE, ORANGE, RED
from tests.plot.pictures import check_nothing_cut_off

NODES = ["left", "disc", "seal", "right"]
PLACES = [0.0, 0.3, 0.5, 0.9]
FUNCTIONS = (
    plot_run,
    plot_node_orbits,
    lambda run: plot_forces(run, contact="seal").figure,
    plot_shape,
    lambda run: plot_run(run, node="disc"),
)
every_plot = pytest.mark.parametrize(
    "draw", FUNCTIONS, ids=["figure", "orbits", "forces", "shape", "history"]
)


def chain(count, **options):
    """Return discs on a shaft, a node at each."""
    bent = 2.2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    return RotorSystem(
        mass=8.0 * np.eye(2 * count), stiffness=np.kron(4e6 * bent, np.eye(2)),
        damping=np.kron(800.0 * bent, np.eye(2)), **options,
    )  # fmt: skip


@pytest.fixture(scope="module")
def run():
    """Return a run with a contact aside, one in a stator that moves, and one never reached."""
    system = chain(
        4, nodes={name: (2 * k, 2 * k + 1) for k, name in enumerate(NODES)},
        positions=dict(zip(NODES, PLACES, strict=True)),
    )  # fmt: skip
    usual = {"stiffness": 5e7, "exponent": 1.0, "friction": 0.1, "radius": 0.05}
    housing = Stator(mass=5.0, stiffness=4e6, damping=2000.0)
    return simulate(
        system, speed=500.0, duration=0.2, unbalance=[Unbalance(node="disc", moment=1e-3)],
        contacts=[
            Contact(node="disc", clearance=1e-4, centre=(2e-5, -1e-5), **usual),
            Contact(node="seal", clearance=9e-5, stator=housing, **usual),
            Contact(node="right", clearance=1e-3, **usual),
        ],
    )  # fmt: skip


def panels_of(figure):
    return {ax.get_title(): ax for ax in figure.axes}


def lines_of(ax, colour):
    return [line for line in ax.lines if same_color(line.get_color(), colour)]


def points_of(lines):
    """Return all points of some lines, as rows."""
    points = np.concatenate([line.get_xydata() for line in lines])
    return points[np.isfinite(points).all(axis=1)]


def all_in(rows, table):
    """Return whether each row is one of a table."""
    apart = np.abs(rows[:, None, :] - table[None, :, :]).max(axis=2).min(axis=1)
    return bool((apart < 1e-9 * np.abs(table).max()).all())


def test_the_default_figure_has_all_orbits_and_all_forces(run):
    figure = figure_of(run)
    titles = [
        *("left", "disc", "seal in stator 0", "right", "contact 0 at disc"),
        *("contact 1 at seal in stator 0", "contact 2 at right"),
    ]
    assert [ax.get_title() for ax in figure.axes] == titles
    assert "4,775 rpm" in [text.get_text() for part in figure.subfigs for text in part.texts]
    left, forces = figure.axes[0], figure.axes[-1]
    assert (left.get_xlabel(), left.get_ylabel()) == ("$X$ [µm]", "$Y$ [µm]")
    assert (forces.get_xlabel(), forces.get_ylabel()) == ("time $T$ [s]", "normal force $N$ [N]")
    assert [text.get_text() for text in forces.texts] == ["no contact"]


def test_an_orbit_is_that_of_the_dataset_in_flight_and_in_contact(run):
    panels = panels_of(plot_node_orbits(run))
    (line,) = lines_of(panels["left"], BLUE)
    expected = 1e6 * np.stack([run.x.sel(node="left"), run.y.sel(node="left")], axis=1)
    np.testing.assert_allclose(line.get_xydata(), expected, rtol=1e-12)
    # at the events the orbit is on the circle, so that contact is drawn from edge to edge
    here = run.event_contact.values == 0
    table = np.concatenate([
        np.stack([run.x.sel(node="disc"), run.y.sel(node="disc")], axis=1),
        np.stack([run.event_contact_x + 2e-5, run.event_contact_y - 1e-5], axis=1)[here],
    ])  # fmt: skip
    touching = points_of(lines_of(panels["disc"], RED))
    assert all_in(touching, 1e6 * table)
    inside = points_of(lines_of(panels["disc"], BLUE))
    assert all_in(inside, 1e6 * table)
    radius = np.hypot(*(touching - [20.0, -10.0]).T)
    assert radius.min() == pytest.approx(100.0)
    assert np.hypot(*(inside - [20.0, -10.0]).T).max() == pytest.approx(100.0)


def test_in_a_stator_that_moves_the_orbit_is_that_relative_to_it(run):
    ax = panels_of(plot_node_orbits(run, nodes=["seal"]))["seal in stator 0"]
    touching = points_of(lines_of(ax, RED))
    assert np.hypot(*touching.T).min() == pytest.approx(90.0)
    samples = 1e6 * np.stack([run.contact_x[:, 1], run.contact_y[:, 1]], axis=1)
    events = 1e6 * np.stack([run.event_contact_x, run.event_contact_y], axis=1)
    assert all_in(touching, np.concatenate([samples, events]))
    moved = np.hypot(
        run.x.sel(node="seal") - run.contact_x[:, 1], run.y[:, 2] - run.contact_y[:, 1]
    )
    assert float(moved.max()) > 1e-6  # the stator itself


@pytest.mark.parametrize(
    ("title", "radius", "centre"),
    [("disc", 100.0, (20.0, -10.0)), ("seal in stator 0", 90.0, (0, 0)), ("right", 1e3, (0, 0))],
)
def test_each_clearance_is_a_circle_about_the_centre_of_its_stator(run, title, radius, centre):
    ax = panels_of(plot_node_orbits(run))[title]
    (ring,) = [line for line in ax.lines if line.get_label() == "clearance"]
    np.testing.assert_allclose(np.hypot(*(ring.get_xydata() - centre).T), radius, rtol=1e-12)


def test_forces_are_those_of_the_dataset_with_their_peaks_and_contacts_shaded(run):
    for number, node in enumerate(("disc", "seal")):
        ax = plot_forces(run, contact=node)
        assert ax.get_title().startswith(f"contact {number} at {node}")
        normal, tangential = (lines_of(ax, colour)[0] for colour in (BLUE, ORANGE))
        at = np.searchsorted(normal.get_xdata(), run.t)
        np.testing.assert_allclose(normal.get_ydata()[at], run.normal_force[:, number])
        np.testing.assert_array_equal(tangential.get_xdata(), run.t)
        np.testing.assert_allclose(tangential.get_ydata(), run.tangential_force[:, number])
        assert ax.get_ylabel() == "normal force $N$ [N]"
        part = run.isel(episode=run.episode_contact.values == number)
        (marks,) = [line for line in ax.lines if line.get_label() == "peak of a contact"]
        assert set(marks.get_ydata()) <= set(part.peak_force.values)
        assert set(marks.get_ydata()) <= set(normal.get_ydata())
        assert marks.get_ydata().size >= part.sizes["episode"] - 1
        shades = {each.get_label(): each.get_paths() for each in ax.collections}
        edges = [path.vertices[:, 0] for paths in shades.values() for path in paths]
        assert min(map(min, edges)) == part.entry_time.min()
        # only long contacts have the full shade among short ones
        long = (part.exit_time.fillna(0.2) - part.entry_time).values
        drawn = [np.ptp(path.vertices[:, 0]) for path in shades["in contact"]]
        assert set(np.round(long[long > 0.2 / 400], 12)) <= set(np.round(drawn, 12))


def test_with_contact_damping_peaks_are_where_the_force_is_largest():
    system = chain(1, nodes={"disc": (0, 1)})
    stop = Contact(node="disc", clearance=1e-4, stiffness=5e7, exponent=1.0, damping=20.0)
    run = simulate(system, contacts=[stop], start=([0.0, 0.0], [0.5, 0.2]), speed=500.0,
                   duration=0.01)  # fmt: skip
    ax = plot_forces(run)
    (marks,) = [line for line in ax.lines if line.get_label() == "peak of a contact"]
    assert marks.get_xdata().size > 1
    for time, force in marks.get_xydata():
        here = (run.t > time - 1e-4) & (run.t < time + 1e-4)
        assert force >= 1e-3 * float(run.normal_force[here, 0].max()) * (1.0 - 1e-9)  # kN
    assert (run.peak_time.values[: marks.get_xdata().size] - marks.get_xdata() > 1e-5).any()


def test_the_motion_of_a_node_and_its_distance_from_a_stator_are_drawn_over_time(run):
    moves, radius, force, slip, orbit = figure_of(run, node="disc").axes
    (y,) = lines_of(moves, ORANGE)
    at = np.searchsorted(y.get_xdata(), run.t)
    np.testing.assert_allclose(y.get_ydata()[at], 1e6 * run.y.sel(node="disc"), rtol=1e-12)
    assert [ax.get_ylabel() for ax in (moves, radius, force, slip, orbit)] == [
        "displacement $Z$ [µm]", "radius $|Z|$ [µm]", "normal force $N$ [N]",
        "slip speed $V_s$ [m/s]", "displacement $Y$ [µm]",
    ]  # fmt: skip
    assert slip.get_xlabel() == "time $T$ [s]"
    ways = [line for line in radius.lines if line.get_label() in ("flight", "slips forwards")]
    assert len(ways) == 2
    drawn = points_of(ways)
    at = np.isin(drawn[:, 0], run.t.values)
    expected = 1e6 * np.hypot(run.contact_x[:, 0], run.contact_y[:, 0])
    np.testing.assert_allclose(drawn[at, 1], expected.sel(t=drawn[at, 0]), rtol=1e-9)
    for label, kind in (("entry", 1), ("exit", -1)):
        (marks,) = [line for line in radius.lines if line.get_label() == label]
        here = (run.event_contact == 0) & (run.event_kind == kind)
        np.testing.assert_array_equal(marks.get_xdata(), run.event_time[here.values])
        np.testing.assert_allclose(marks.get_ydata(), 100.0, rtol=1e-9)


def test_a_node_has_a_radius_a_force_and_an_orbit_in_each_of_its_contacts():
    system = chain(1, nodes={"disc": (0, 1)})
    stops = [Contact(node="disc", clearance=gap, stiffness=5e7, centre=(aside, 0.0))
             for gap, aside in ((1e-4, 0.0), (2e-4, 5e-5))]  # fmt: skip
    run = simulate(system, contacts=stops, start=([0.0, 0.0], [0.5, 0.2]), speed=500.0,
                   duration=0.01)  # fmt: skip
    titles = [ax.get_title() for ax in plot_run(run).axes]
    both = ["contact 0 at disc", "contact 1 at disc"]
    assert titles == ["", *both, *both, "", ""]
    with pytest.raises(InputError, match="contact must be a number, or the only one at its node"):
        plot_forces(run, contact="disc")


def test_the_deflected_shape_is_that_of_the_nearest_sample_at_the_positions(run):
    figure = plot_shape(run, t=0.1)
    x, y = figure.axes
    now = run.sel(t=0.1, method="nearest")
    assert figure.get_suptitle() == f"4,775 rpm,  $t$ {float(now.t):.6g} s"
    for ax, name in ((x, "x"), (y, "y")):
        shaft = lines_of(ax, BLUE)[0]
        np.testing.assert_array_equal(shaft.get_xdata(), PLACES)
        np.testing.assert_allclose(shaft.get_ydata(), 1e6 * now[name], rtol=1e-12)
        (bars,) = [each for each in ax.collections if each.get_label() != "in contact"]
        middle = [each.vertices[:, 1].mean() for each in bars.get_paths()]
        of_node = now[name].sel(node=["disc", "seal", "right"]).values
        expected = 1e6 * (of_node - now[f"contact_{name}"].values)
        np.testing.assert_allclose(middle, expected, atol=1e-9)
    assert y.get_xlabel() == "axial position $s$ [m]"
    touching = [line for line in x.lines if line.get_label() == "in contact"]
    held = now["normal_force"].values > 0.0
    assert held.any()
    expected = [place for place, is_held in zip(PLACES[1:], held, strict=True) if is_held]
    assert [line.get_xdata().tolist() for line in touching] == [expected]


def test_a_shape_does_not_magnify_the_rounding_of_one_of_its_displacements(run):
    now = run.assign(x=1e-9 * run.y)
    x, y = plot_shape(now.isel(contact=[], event=[], episode=[]), t=0.1).axes
    size = 1e6 * float(abs(now.y.sel(t=0.1, method="nearest")).max())
    assert np.ptp(x.get_ylim()) >= 0.2 * size
    assert np.ptp(x.get_xlim()) == np.ptp(y.get_xlim())


def test_without_positions_nodes_are_in_the_order_given():
    system = chain(30, nodes={f"n{k}": (2 * k, 2 * k + 1) for k in range(30)}, units="1")
    run = simulate(
        system, contacts=[Contact(node="n7", clearance=1.0, stiffness=1e6)],
        unbalance=[Unbalance(node="n7", moment=1.0)], speed=300.0, duration=0.1,
    )  # fmt: skip
    x, y = plot_shape(run).axes
    assert [text.get_text() for text in y.get_xticklabels()] == [f"n{k}" for k in range(30)]
    assert y.get_xlabel() == "node"
    largest = int(np.argmax(np.hypot(run.x, run.y).max("node").values))
    np.testing.assert_array_equal(lines_of(x, BLUE)[0].get_ydata(), run.x[largest])
    # of many nodes the figure of a run shows those with contacts
    assert [ax.get_title() for ax in plot_run(run).axes] == ["n7", "contact 0 at n7"]
    assert len(plot_node_orbits(run).axes) == 30


@every_plot
def test_a_part_of_a_run_has_its_own_samples_and_events_only(run, draw):
    part = run.sel(t=slice(0.1, 0.12))
    figure = draw(part)
    check_nothing_cut_off(figure)
    for ax in figure.axes:
        if ax.get_xlabel() == "time $T$ [s]":
            assert ax.get_xlim() == (part.t.values[0], part.t.values[-1])
            for line in ax.lines:
                times = np.ma.filled(np.ma.asarray(line.get_xdata(), float), np.nan)
                if line.get_transform() == ax.transData:
                    assert np.nanmin(times) >= 0.1 - 1e-9


def test_what_is_no_run_of_a_system_is_refused(run):
    for given, words in (
        (run.isel(t=slice(0)), "run must contain samples, got none"),
        (run.sel(node="disc"), "node of run must be along node, got it on no dimension"),
        (run.drop_vars("contact_x"), "it lacks contact_x"),
    ):
        with pytest.raises(InputError, match=words):
            plot_shape(given)


@pytest.mark.parametrize("draw", [plot_node_orbits, plot_shape])
def test_a_figure_of_nodes_needs_a_system(run, draw):
    with pytest.raises(InputError, match="run must be of a rotor system, got 'Signals of two pro"):
        draw(signals_of(run, node="disc"))


@pytest.mark.parametrize(
    ("name", "column", "words"),
    [
        ("normal_force", ("q", [0.0]), "normal_force of run must be along t and contact"),
        ("event_contact", 1.5, "event_contact of run must be whole numbers, got float64"),
        ("event_contact", 7, "must be below its number of contacts, 3, got 7"),
        ("peak_force", "a", "peak_force of run must be real numbers, got <U1"),
        ("contact_x", np.nan, "contact_x of run must be finite"),
        ("contact_node", 3, "contact_node of run must be text, got int64"),
    ],
)
def test_a_damaged_run_is_refused(run, name, column, words):
    if not isinstance(column, tuple):
        column = (run[name].dims, np.full(run[name].shape, column))
    with pytest.raises(InputError, match=words):
        plot_run(run.drop_vars(name).assign({name: column}))


def test_a_part_with_some_nodes_is_drawn(run):
    part = run.sel(node=["left", "seal"]).transpose()
    assert [ax.get_title() for ax in plot_node_orbits(part).axes] == ["left", "seal in stator 0"]
    x, _ = plot_shape(part, t=0.1).axes
    now = run.sel(node=["left", "seal"]).sel(t=0.1, method="nearest")
    np.testing.assert_allclose(lines_of(x, BLUE)[0].get_ydata(), 1e6 * now.x, rtol=1e-12)


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda run: plot_node_orbits(run, nodes="disc"), "nodes must be a list of names of nodes"),
        (lambda run: plot_node_orbits(run, nodes=[]), "nodes must have 1 to 100 orbits, got 0"),
        (lambda run: plot_node_orbits(run, nodes=["disk"]), "did you mean 'disc'?"),
        (lambda run: plot_forces(run, contact=3), "contact must be one of 0 to 2, got 3"),
        (lambda run: plot_forces(run, contact=1.5), "contact must be a whole number"),
        (lambda run: plot_run(run, node="disk"), "node must be 'left', 'disc', 'seal' or"),
        (lambda run: plot_shape(run, t=3.0), "t must lie from 0 to 0.2, got 3.0"),
        (lambda run: plot_shape(run, t="now"), "t must be a finite real number, got 'now'"),
    ],
)
def test_what_is_not_in_the_run_is_refused(run, draw, words):
    with pytest.raises(InputError) as caught:
        draw(run)
    assert words in str(caught.value)


def test_without_contacts_the_figure_says_so():
    system = Rotor(omega=0.8, zeta=0.3, delta0=1.0, shaft_stiffness=1.0).system()
    run = run_up(system, contacts=[], speed=0.2, to=1.5, rate=0.05)
    figure = plot_run(run)
    assert [text.get_text() for text in figure.axes[2].texts] == ["no contacts"]
    assert figure.get_suptitle() == "node disc,  speed 0.2 to 1.5"
    with pytest.raises(InputError, match="contact must be one of none: there is no contact, got 0"):
        plot_forces(run, contact=0)
    two = chain(
        2, nodes={"one": (0, 1), "two": (2, 3)}, unbalance=[Unbalance(node="one", moment=1e-3)]
    )
    figure = plot_run(simulate(two, speed=100.0, duration=0.2))
    assert [text.get_text() for text in figure.axes[-1].texts] == ["no contacts"]


def test_the_orbit_of_signals_at_a_node_has_the_clearance_there(run):
    ax = plot_orbit(signals_of(run, node="right"))
    assert ax.get_title() == "node right,  4,775 rpm"
    (ring,) = [line for line in ax.lines if line.get_label() == "clearance"]
    np.testing.assert_allclose(np.hypot(*ring.get_xydata().T), 1e3, rtol=1e-12)
    aside = plot_orbit(signals_of(run, node="disc"))
    assert not [line for line in aside.lines if line.get_label() == "clearance"]
