"""The smallest and largest distance of nodes and contacts over a window of a run."""

from __future__ import annotations

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.core.systems import SystemResult
from rotor_ida.simulation.systems.flow import SystemFlow


def extreme_radii(
    flow: SystemFlow, start: Values, times: Values, run: SystemResult, rows: Values,
    centres: ComplexValues,
) -> tuple[Values, Values]:  # fmt: skip
    """Return the smallest and the largest distance of each place, shape (place,).

    Parameters
    ----------
    flow : SystemFlow
        The motion.
    start : ndarray, shape (n,)
        The state at the start of the window.
    times : ndarray, shape (sample,)
        Times of samples, equally spaced.
    run : SystemResult
        The run over the window.
    rows : ndarray, shape (place, 2, n)
        Displacements of the places.
    centres : ndarray of complex, shape (place,)
        From where distances count.

    Notes
    -----
    Between samples the square of the distance is a cubic by its values and rates at both ends. The
    window is simulated again with samples where these are extreme. There the distance is
    stationary, so that the small errors of these times matter by their squares.
    """
    squares, rates = _squares(run, rows, centres)
    at = np.concatenate(
        [_extreme_times(times, sign * squares, sign * rates) for sign in (1.0, -1.0)]
    )
    again = np.unique(np.append(at, times[-1]))
    refined = _squares(flow.sampled(start, again), rows, centres)[0]
    both = np.sqrt(np.concatenate([squares, refined]))
    return both.min(axis=0), both.max(axis=0)


def _squares(run: SystemResult, rows: Values, centres: ComplexValues) -> tuple[Values, Values]:
    """Return squares of distances, and their rates, shape (sample, place)."""
    whole = rows[:, 0] + 1j * rows[:, 1]
    place, velocity = run.samples[:, 0] @ whole.T - centres, run.samples[:, 1] @ whole.T
    return np.abs(place) ** 2, 2.0 * (place.conj() * velocity).real


def _extreme_times(times: Values, values: Values, rates: Values) -> Values:
    """Return when the cubics through values and rates are largest, shape (place,)."""
    step = float(times[1] - times[0])
    first, last = values[:-1], values[1:]
    m, n = step * rates[:-1], step * rates[1:]
    cubic, square = 2.0 * (first - last) + m + n, 3.0 * (last - first) - 2.0 * m - n
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(square**2 - 3.0 * cubic * m)
        # the form without cancellation; the maximum of the two
        point = np.where(square > 0.0, -(square + root) / (3.0 * cubic), m / (root - square))
    point = np.where((point > 0.0) & (point < 1.0), point, 0.0)
    largest = first + point * (m + point * (square + point * cubic))
    place = np.argmax(largest, axis=0)
    columns = np.arange(values.shape[1])
    return np.asarray(times[place] + step * point[place, columns])
