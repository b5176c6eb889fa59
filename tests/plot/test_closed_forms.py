import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from rotor_ida import InputError
from rotor_ida.closed_forms import free_periods, restoring_field
from rotor_ida.plot import (
    mixed_panels,
    plot_cuts,
    plot_deviation,
    plot_periods,
    plot_portrait,
    plot_solutions,
    plot_surface,
)
from rotor_ida.plot.labels import LABELS

PERIODS = ["on a circle, exact", "on a circle, simulated", "on a line, exact",
           "on a line, simulated"]  # fmt: skip


@pytest.fixture(scope="module")
def field():
    line = np.linspace(-2.0, 2.0, 9)
    return restoring_field(x=line, y=line, delta0=[0.0, 0.5])


def test_surface_spans_the_force_and_names_its_axes(field):
    ax = plot_surface(field.sel(delta0=0.5), "restoring_x")
    assert (ax.get_xlabel(), ax.get_ylabel()) == (LABELS["x_alone"], LABELS["y_alone"])
    assert ax.get_title().startswith(LABELS["restoring_x"])
    assert ax.get_title().endswith("= 0.5$")
    low, high = ax.get_zlim()
    assert low < float(field.restoring_x.sel(delta0=0.5).min()) < 0.0
    assert high > float(field.restoring_x.sel(delta0=0.5).max()) > 0.0


def test_sections_are_those_of_the_field(field):
    ax = plot_cuts(field.sel(delta0=0.5), "restoring_x", at=[0.0, 2.0])
    for line, y in zip(ax.lines, (0.0, 2.0), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), field.restoring_x.sel(delta0=0.5, y=y))
    assert [line.get_label() for line in ax.lines] == ["$y = 0$", "$y = 2$"]
    assert ax.lines[0].get_linestyle() != ax.lines[1].get_linestyle()


def test_other_fields_are_refused(field):
    with pytest.raises(InputError, match="ax must be three-dimensional"):
        plot_surface(field.sel(delta0=0.0), "restoring_x", ax=Figure().subplots())
    with pytest.raises(InputError, match="field must contain one delta0, got 2"):
        plot_surface(field, "restoring_x")
    with pytest.raises(InputError, match="it lacks force"):
        plot_cuts(field, "force", at=[0.0])
    with pytest.raises(InputError, match="solid must contain numbers of panels below 2, got 2"):
        mixed_panels(1, 2, solid=[2])


@pytest.fixture(scope="module")
def periods():
    return free_periods(amplitude=np.linspace(0.6, 8.0, 20), delta0=0.5)


@pytest.fixture
def portraits():
    """A circle of radius 2 and a rotor at rest."""
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    table = {"x": 2.0 * np.cos(angle), "vx": -2.0 * np.sin(angle)}
    runs = {name: (("start", "t"), np.stack([0.0 * row, row])) for name, row in table.items()}
    return xr.Dataset(runs).assign(amplitude=("start", [0.0, 2.0]), period=("start", [0.0, 6.28]))


def test_amplitude_is_over_the_period_or_the_frequency(periods):
    by_period, by_frequency = (
        plot_periods(periods, over=over).lines[0] for over in ("period", "natural")
    )
    np.testing.assert_array_equal(by_period.get_ydata(), periods.amplitude)
    np.testing.assert_allclose(by_period.get_xdata() * by_frequency.get_xdata(), 2.0 * np.pi)


def test_simulated_periods_are_marks_beside_the_lines(periods):
    ax = plot_periods(periods, simulated=periods.isel(amplitude=[3, 7]))
    assert sorted(line.get_label() for line in ax.lines) == PERIODS
    marks = {line.get_label(): line for line in ax.lines}
    assert marks["on a line, simulated"].get_linestyle() == "None"
    assert (
        marks["on a line, simulated"].get_marker() != marks["on a circle, simulated"].get_marker()
    )


def test_portrait_says_the_period_of_each_orbit(portraits):
    ax = plot_portrait(portraits)
    assert [text.get_text() for text in ax.texts] == ["$T = 6.28$"]
    assert ax.lines[0].get_marker() == "o"
    assert (ax.get_xlabel(), ax.get_ylabel()) == (LABELS["x"], LABELS["vx"])


def test_other_free_motions_are_refused(periods, portraits):
    with pytest.raises(InputError, match="exact must contain"):
        plot_periods(portraits)
    with pytest.raises(InputError, match="it lacks x, vx, period"):
        plot_portrait(periods)
    with pytest.raises(InputError, match="over must be one of"):
        plot_periods(periods, over="time")


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


def test_another_dataset_is_no_claimed_solution(run):
    for plot in (plot_solutions, plot_deviation):
        with pytest.raises(InputError, match="it lacks solution"):
            plot(run)
