"""What is left out of a picture cannot be seen in it: a spike of one sample stays."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from rotor_ida.plot import plot_orbit, plot_trace
from rotor_ida.plot.decimation import CELLS, COLUMNS, kept_in_columns, thinned
from rotor_ida.schema import labelled_dataset

MILLION = 1_000_000


def signals(z):
    times = 0.01 * np.arange(z.size)
    columns = {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", times)}
    return labelled_dataset("Signals", columns, {"t": ("t", times)})


@pytest.fixture(scope="module")
def noisy():
    rng = np.random.default_rng(28)
    return rng.normal(size=MILLION)


@pytest.mark.parametrize("place", [0, 1, 123_456, MILLION - 1])
def test_a_spike_of_one_sample_is_kept_in_its_column(noisy, place):
    times = 0.01 * np.arange(MILLION)
    spiked = noisy.copy()
    spiked[place] = -40.0
    kept = kept_in_columns(times, spiked)
    assert kept.size <= 4 * COLUMNS
    assert place in kept
    assert (np.diff(kept) > 0).all()


def test_each_column_has_the_extrema_and_ends_of_its_samples(noisy):
    times = np.cumsum(1.0 + 0.5 * np.sin(np.arange(MILLION)))
    kept = kept_in_columns(times, noisy)
    edges = np.linspace(times[0], times[-1], COLUMNS + 1)
    columns = np.clip(np.searchsorted(edges, times, side="right") - 1, 0, COLUMNS - 1)
    for column in (0, 1, 777, COLUMNS - 1):
        whole = np.flatnonzero(columns == column)
        left = kept[np.isin(kept, whole)]
        assert noisy[left].min() == noisy[whole].min()
        assert noisy[left].max() == noisy[whole].max()
        # rounding may give a sample on an edge to either column
        assert abs(left[0] - whole[0]) <= 1
        assert abs(left[-1] - whole[-1]) <= 1


def test_few_samples_are_all_drawn():
    times = np.arange(500.0)
    assert kept_in_columns(times, np.sin(times)).size == 500
    x, y = thinned(np.cos(times), np.sin(times))
    assert x.size == y.size == 500


def test_a_spike_survives_in_the_trace(noisy):
    z = noisy + 1j * noisy
    z[654_321] += 50.0
    ax = plot_trace(signals(z))
    drawn = {line.get_label(): line.get_ydata() for line in ax.get_lines()}
    assert drawn["$x$"].max() == z.real.max()
    assert drawn["$x$"].size <= 4 * COLUMNS


def test_a_spike_survives_in_an_orbit_that_repeats_itself():
    z = np.exp(2j * np.pi * np.arange(MILLION) / 1000.0)
    z[654_321] = 3.0 + 2.0j
    x, y = thinned(z.real, z.imag)
    assert np.nanmax(x) == 3.0
    assert x.size < 5000
    # to the spike and back from it
    spike = int(np.nanargmax(x))
    assert np.isfinite(x[spike - 1 : spike + 2] + y[spike - 1 : spike + 2]).all()


def test_a_thinned_path_passes_within_a_cell_of_each_of_its_points():
    turn = np.linspace(0.0, 400.0 * np.pi, 300_001)
    z = (1.0 + 0.3 * np.cos(0.31 * turn)) * np.exp(1j * turn)
    kept = np.column_stack(thinned(z.real, z.imag))
    kept = kept[np.isfinite(kept).all(axis=1)]
    apart, _ = cKDTree(kept).query(np.column_stack([z.real, z.imag]))
    assert apart.max() < 2.0 * 2.6 / CELLS
    assert len(kept) < 0.7 * z.size


def test_an_orbit_that_fills_the_plane_is_written_as_dots():
    z = np.cumsum(np.random.default_rng(1).normal(size=(200_000, 2)), axis=0) @ [1.0, 1.0j]
    z[77_777] += 2000.0
    ax = plot_orbit(signals(z))
    (orbit,) = (line for line in ax.lines if line.get_label() == "orbit")
    assert orbit.get_rasterized()
    assert np.nanmax(orbit.get_xdata()) == z.real.max()


def test_gaps_stay_gaps():
    turn = np.linspace(0.0, 200.0 * np.pi, 100_001)
    x = np.where(turn % (2.0 * np.pi) > 6.0, np.nan, np.cos(turn))
    thin_x, thin_y = thinned(x, np.where(np.isnan(x), np.nan, np.sin(turn)))
    steps = np.hypot(np.diff(thin_x), np.diff(thin_y))
    assert np.nanmax(steps) < 0.1
