import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError
from rotor_ida.closed_forms import free_periods
from rotor_ida.plot import plot_periods, plot_portrait

LABELS = ["on a circle, exact", "on a circle, simulated", "on a line, exact",
          "on a line, simulated"]  # fmt: skip


@pytest.fixture(scope="module")
def exact():
    return free_periods(amplitude=np.linspace(0.6, 8.0, 20), delta0=0.5)


@pytest.fixture
def portraits():
    """A circle of radius 2 and a rotor at rest."""
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    table = {"x": 2.0 * np.cos(angle), "vx": -2.0 * np.sin(angle)}
    runs = {name: (("start", "t"), np.stack([0.0 * row, row])) for name, row in table.items()}
    return xr.Dataset(runs).assign(amplitude=("start", [0.0, 2.0]), period=("start", [0.0, 6.28]))


def test_amplitude_is_over_the_period_or_the_frequency(exact):
    by_period, by_frequency = (
        plot_periods(exact, over=over).lines[0] for over in ("period", "natural")
    )
    np.testing.assert_array_equal(by_period.get_ydata(), exact.amplitude)
    np.testing.assert_allclose(by_period.get_xdata() * by_frequency.get_xdata(), 2.0 * np.pi)


def test_simulated_periods_are_marks_beside_the_lines(exact):
    ax = plot_periods(exact, simulated=exact.isel(amplitude=[3, 7]))
    assert sorted(line.get_label() for line in ax.lines) == LABELS
    marks = {line.get_label(): line for line in ax.lines}
    assert marks["on a line, simulated"].get_linestyle() == "None"
    assert (
        marks["on a line, simulated"].get_marker() != marks["on a circle, simulated"].get_marker()
    )


def test_portrait_says_the_period_of_each_orbit(portraits):
    ax = plot_portrait(portraits)
    assert [text.get_text() for text in ax.texts] == ["$T = 6.28$"]
    assert ax.lines[0].get_marker() == "o"
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("displacement $x$", "velocity $x$′")


def test_other_datasets_are_refused(exact, portraits):
    with pytest.raises(InputError, match="exact must hold"):
        plot_periods(portraits)
    with pytest.raises(InputError, match="it lacks x, vx, period"):
        plot_portrait(exact)
    with pytest.raises(InputError, match="over must be one of"):
        plot_periods(exact, over="time")
