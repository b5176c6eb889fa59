"""What is left out of a picture cannot be seen in it: a spike of one sample stays."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from rotor_ida.plot import plot_orbit, plot_trace
from rotor_ida.plot.decimation import COLUMNS, DOTS, inked, kept_in_columns, thinned
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


def test_a_thinned_path_stays_within_a_cell_of_the_whole_one():
    turn = np.linspace(0.0, 400.0 * np.pi, 300_001)
    z = (1.0 + 0.3 * np.cos(0.31 * turn)) * np.exp(1j * turn)
    x, y = thinned(z.real, z.imag)
    grid = inked(z.real, z.imag, (-1.3, -1.3), 2.6)
    thin = inked(x, y, (-1.3, -1.3), 2.6)
    spread = np.zeros_like(thin)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            spread |= np.roll(thin, (down, right), axis=(0, 1))
    assert (grid <= spread).all()
    assert thin.sum() > 0.8 * grid.sum()


def test_gaps_stay_gaps():
    turn = np.linspace(0.0, 200.0 * np.pi, 100_001)
    x = np.where(turn % (2.0 * np.pi) > 6.0, np.nan, np.cos(turn))
    thin_x, thin_y = thinned(x, np.where(np.isnan(x), np.nan, np.sin(turn)))
    steps = np.hypot(np.diff(thin_x), np.diff(thin_y))
    assert np.nanmax(steps) < 0.1


def test_dots_are_those_that_the_segments_cross():
    square = inked(np.array([0.0, 1.0, 1.0]), np.array([0.0, 0.0, 1.0]), (0.0, 0.0), 1.0)
    assert square[0].all()
    assert square[:, -1].all()
    assert square.sum() == 2 * DOTS - 1
    parted = inked(np.array([0.0, np.nan, 1.0]), np.array([0.0, np.nan, 1.0]), (0.0, 0.0), 1.0)
    assert not parted.any()


def test_a_spike_survives_in_an_orbit_that_fills_the_plane(noisy):
    rng = np.random.default_rng(1)
    z = noisy + 1j * rng.normal(size=MILLION)
    z[77_777] = 20.0 + 0.0j
    ax = plot_orbit(signals(z))
    (image,) = ax.get_images()
    alpha = np.asarray(image.get_array())[..., 3]
    left, right = image.get_extent()[:2]
    assert right == pytest.approx(20.0, abs=0.1)
    assert left < z.real.min() + 0.1
    assert alpha[:, -1].any()
    # and in print, at every size
    for dots_per_inch in (60, 110, 200):
        ax.figure.set_dpi(dots_per_inch)
        canvas = FigureCanvasAgg(ax.figure)
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3].astype(float)
        place = ax.transData.transform([(12.0, z.real.min()), (18.0, 0.0)])
        column = slice(*place[:, 0].astype(int))
        rows = pixels.shape[0] - np.arange(
            *(np.sort(place[:, 1].astype(int)) + np.array([-12, 12]))
        )
        blue = pixels[rows][:, column, 2] - pixels[rows][:, column, 0]
        assert (blue.max(axis=0) > 30.0).mean() > 0.9
