import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError
from rotor_ida.plot import plot_deviation, plot_solutions


@pytest.fixture
def compared():
    time = np.linspace(0.0, 2.0, 5)
    table = np.stack([time, 3.0 * time])
    return xr.Dataset(
        {
            "x": ("t", time), "y": ("t", 0.0 * time),
            "solution_x": (("solution", "t"), table),
            "solution_y": (("solution", "t"), 0.0 * table + time),
        },
        {"t": time, "solution": ["one", "two"]},
    )  # fmt: skip


def test_simulated_motion_comes_first_and_every_solution_has_its_name(compared):
    ax = plot_solutions(compared)
    assert [line.get_label() for line in ax.lines] == ["simulated", "one", "two"]
    np.testing.assert_array_equal(ax.lines[2].get_ydata(), 3.0 * compared.t)


def test_deviation_is_the_distance_in_the_plane(compared):
    ax = plot_deviation(compared)
    np.testing.assert_allclose(ax.lines[1].get_ydata()[1:], (5.0**0.5 * compared.t)[1:])
    assert np.isnan(ax.lines[1].get_ydata()[0])
    assert ax.get_yscale() == "log"


def test_another_dataset_is_refused(run):
    for plot in (plot_solutions, plot_deviation):
        with pytest.raises(InputError, match="it lacks solution"):
            plot(run)
