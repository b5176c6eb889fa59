import numpy as np
import pytest
from matplotlib.figure import Figure

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.plot import plot_orbit, plot_run
from rotor_ida.plot.paths import path_of


def labels(ax):
    return ax.get_legend_handles_labels()[1]


def test_panels_are_labelled_with_name_and_symbol(run):
    x, y, radius, force, orbit = plot_run(run).axes
    assert x.get_ylabel() == "displacement $x$"
    assert y.get_ylabel() == "displacement $y$"
    assert radius.get_ylabel() == "radius $|z|$"
    assert force.get_ylabel() == "peak force $f$"
    assert force.get_xlabel() == "time $t$"
    assert (orbit.get_xlabel(), orbit.get_ylabel()) == ("displacement $x$", "displacement $y$")


def test_contacts_are_shaded_from_entry_to_exit_and_to_the_end(run):
    radius = plot_run(run).axes[2]
    (shade,) = (each for each in radius.collections if each.get_label() == "in contact")
    spans = [path.get_extents().intervalx for path in shade.get_paths()]
    np.testing.assert_allclose(spans[0], [run["entry_time"][0], run["exit_time"][0]])
    np.testing.assert_allclose(spans[-1], [run["entry_time"][-1], 20.0])


def test_entries_and_exits_are_marked_on_the_ring(run):
    radius = plot_run(run).axes[2]
    marks = {each.get_label(): each for each in radius.lines}
    entries = run["event_time"].values[run["event_kind"].values == 1]
    np.testing.assert_array_equal(marks["entry"].get_xdata(), entries)
    assert (marks["exit"].get_ydata() == 0.5).all()


def test_peak_forces_are_those_of_the_run(run):
    force = plot_run(run).axes[3]
    np.testing.assert_array_equal(force.lines[0].get_ydata(), run["peak_force"].values)


def test_orbit_shows_flight_and_contact_apart(run):
    ax = plot_orbit(run)
    assert labels(ax) == ["clearance", "flight", "contact", "entry", "exit", "start"]
    lines = {each.get_label(): each for each in ax.lines}
    flight = np.hypot(*lines["flight"].get_data())
    contact = np.hypot(*lines["contact"].get_data())
    # the cubic between two events strays by less than its fourth-order error
    assert np.nanmax(flight) < 0.5 + 1e-4
    assert np.nanmin(contact) > 0.5 - 1e-4
    assert ax.get_aspect() == 1.0


def test_points_between_outputs_lie_on_the_motion(run):
    """A cubic with the right velocities errs by less than (step)**4/384 times the snap."""
    fine = simulate(
        Rotor(omega=1.7, zeta=0.07, delta0=0.5),
        start=(0.0, 0.0, 0.0, 0.0), duration=20.0, samples=2001,
    )  # fmt: skip
    path = path_of(run)
    error = np.interp(fine["t"].values, path.time, path.x) - fine["x"].values
    assert np.abs(error).max() < 2e-3


def test_sparse_outputs_are_not_smoothed(run):
    sparse = run.isel(t=slice(None, None, 50), event=slice(0, 0))
    assert path_of(sparse).time.size == sparse.sizes["t"]


def test_run_without_contact_says_so():
    rotor = Rotor(omega=1.0, zeta=0.5, delta0=5.0)
    free = simulate(rotor, start=(0.0, 0.0, 0.0, 0.0), duration=5.0, samples=51)
    figure = plot_run(free)
    assert [text.get_text() for text in figure.axes[3].texts] == ["no contact"]
    assert "contact" not in labels(figure.axes[4])


def test_run_without_clearance_is_one_contact():
    rotor = Rotor(omega=1.0, zeta=0.5, delta0=0.0)
    run = simulate(rotor, start=(1.0, 0.0, 0.0, 0.0), duration=5.0, samples=51)
    assert labels(plot_orbit(run)) == ["contact", "start"]


def test_marks_that_would_hide_the_motion_are_left_out(run):
    many = run.isel(event=np.repeat([0, 1], 100))
    assert "entry" not in labels(plot_orbit(many))


def test_draws_on_the_axes_given(run):
    ax = Figure().subplots()
    assert plot_orbit(run, ax=ax) is ax


def test_another_dataset_is_refused(exact):
    for plot in (plot_run, plot_orbit):
        with pytest.raises(InputError, match=r"run must hold .* it lacks t, x, y"):
            plot(exact)
