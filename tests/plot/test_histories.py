import numpy as np
import pytest

from rotor_ida import InputError
from rotor_ida.plot import plot_drawn_out, plot_history


def test_contact_and_flight_have_their_own_lines(run):
    ax = plot_history(run, "radius")
    lines = {line.get_label(): line.get_ydata() for line in ax.lines}
    assert set(lines) == {"flight", "contact"}
    # the cubic between two events strays by less than its fourth-order error
    assert np.nanmin(lines["contact"]) > 0.5 - 1e-4
    assert np.nanmax(lines["flight"]) < 0.5 + 1e-4


def test_history_is_that_of_the_run(run):
    ax = plot_history(run, "x")
    assert ax.get_ylabel() == "displacement $x$"
    assert ax.get_xlim() == (0.0, 20.0)
    drawn = np.concatenate([line.get_ydata() for line in ax.lines])
    assert np.isin(run.x.values, drawn).all()


def test_drawn_out_orbit_goes_along_time(run):
    ax = plot_drawn_out(run)
    assert ax.name == "3d"
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()) == ("time $t$", "$x$", "$y$")
    time, x, y = ax.lines[-1].get_data_3d()
    assert (time[0], time[-1]) == (0.0, 20.0)
    assert np.nanmin(np.hypot(x, y)) > 0.5 - 1e-4


def test_other_things_are_refused(run, exact):
    with pytest.raises(InputError, match="name must be one of 'x', 'y', 'radius'"):
        plot_history(run, "z")
    with pytest.raises(InputError, match="run must hold"):
        plot_drawn_out(exact)
