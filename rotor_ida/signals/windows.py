"""Windows of whole revolutions, and the orders in each by least squares."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.signals.record import Record

# Tolerance relative to a window: a sample at its edge belongs to it in spite of rounding.
EDGE = 1e-9
# Numbers to process at once: blocks that fit into the processor's cache are faster.
AT_ONCE = 200_000
# Limits on the overlap of windows, and of segments of a spectrogram.
MOST_OVERLAP = 0.95
MOST_SAMPLES = 200_000_000
# Windows in a stretch, and the change of speed within it. The amplitude counts as constant where
# the speed changes less than `STEADY`, else as a parabola, or less with few windows for each term.
MOST_WINDOWS = 128
SPEED_SPAN, STEADY = 0.04, 0.002
WINDOWS_A_TERM = 2
Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Windows:
    """Samples of a record by windows of whole revolutions.

    Parameters
    ----------
    samples : ndarray of int, or slice
        Samples of the windows, one window after another; repeated if they are in several.
    edges : ndarray of int, shape (windows + 1,)
        Index among them at which each window begins, and at which the last ends.
    revolutions : int
        Revolutions in a window.
    times, speeds : ndarray, shape (windows,)
        Mean time of the samples in each, and the speed there [rad over the unit of time].
    """

    samples: npt.NDArray[np.intp] | slice
    edges: npt.NDArray[np.intp]
    revolutions: int
    times: Values
    speeds: Values

    def spread(self, values: npt.NDArray[np.inexact]) -> npt.NDArray[np.inexact]:
        """Return the value of its window for each sample."""
        return np.repeat(values, np.diff(self.edges))

    def parts(self, width: int) -> Iterator[slice]:
        """Yield slices of windows to process at once, with `width` numbers per sample."""
        first, last = 0, self.edges.size - 1
        while first < last:
            until = int(np.searchsorted(self.edges, self.edges[first] + AT_ONCE // width))
            until = min(max(until - 1, first + 1), last)
            yield slice(first, until)
            first = until


@dataclass(frozen=True)
class Orders:
    """Amplitudes of the orders in each window.

    Parameters
    ----------
    amplitudes : ndarray of complex, shape (windows, k)
        ``c`` of ``z = sum(c_n exp(i n angle))``.
    errors : ndarray, shape (windows, k)
        Standard errors of their real and imaginary parts, and so of ``abs(c)``.
    residual : ndarray, shape (windows,)
        Root mean square of the residual, by degrees of freedom.
    """

    amplitudes: Complex
    errors: Values
    residual: Values


def windows_of(
    record: Record, revolutions: int, overlap: float = 0.0, begin: float | None = None
) -> Windows:
    """Return the complete windows of a number of revolutions in a record.

    The first begins with the record, or at the angle `begin`, at most one sample before it. So a
    record that is continued gets the same windows as an uninterrupted one.
    """
    angles = record.known_angles()
    turns = (angles - (angles[0] if begin is None else begin)) / (2.0 * math.pi * revolutions)
    # samples of whole revolutions end one step before the first repeats
    end = turns[-1] + (turns[-1] - turns[-2]) + EDGE
    if end < 1.0:
        raise InputError(
            f"signals must have at least {revolutions} whole revolutions, got "
            f"{turns[-1] * revolutions:.3g}"
        )
    starts = (1.0 - overlap) * np.arange(math.floor((end - 1.0) / (1.0 - overlap)) + 1)
    first, last = (np.searchsorted(turns, starts + each - EDGE) for each in (0.0, 1.0))
    counts = last - first
    if counts.min() < 2:
        at = record.times[min(first[counts.argmin()], record.times.size - 1)]
        raise InputError(
            f"signals must have more than two samples a revolution, got {counts.min()} in "
            f"{revolutions} at t {at:.6g}"
        )
    if (held := int(counts.sum())) > MOST_SAMPLES:
        raise InputError(f"overlap must be smaller, got {overlap!r}: windows of {held} samples")
    edges = np.concatenate([[0], np.cumsum(counts)])
    samples: npt.NDArray[np.intp] | slice = slice(0, int(edges[-1]))
    if overlap > 0.0:
        samples = np.arange(edges[-1]) + np.repeat(first - edges[:-1], counts)
    times, speeds = _times_and_speeds(record.times[samples], angles[samples], edges)
    return Windows(samples, edges, revolutions, times, speeds)


def _times_and_speeds(
    times: Values, angles: Values, edges: npt.NDArray[np.intp]
) -> tuple[Values, Values]:
    """Return the mean time of each window, and its speed by least squares."""
    starts, counts = edges[:-1], np.diff(edges)
    mean_time = np.add.reduceat(times, starts) / counts
    mean_angle = np.add.reduceat(angles, starts) / counts
    since = times - np.repeat(mean_time, counts)
    turned = angles - np.repeat(mean_angle, counts)
    return mean_time, np.add.reduceat(since * turned, starts) / np.add.reduceat(since**2, starts)


def fit_orders(record: Record, windows: Windows, orders: Values) -> Orders:
    """Return the complex amplitude of each signed order in each window, and the residual.

    Parameters
    ----------
    record : Record
        The signals.
    windows : Windows
        Their windows.
    orders : ndarray, shape (k,)
        Orders, negative for backward whirl; 0 is the mean position.

    Notes
    -----
    The normal equations contain only sums of ``exp(i (n - m) angle)``. Over whole revolutions the
    orders are nearly orthogonal, so the equations are solved to rounding. For noise of variance
    s**2 in z the covariance of the amplitudes is s**2 times the inverse of their matrix.
    """
    angles, z = record.known_angles()[windows.samples], record.z[windows.samples]
    apart = orders - orders[:, None]
    needed = {_key(abs(each)): abs(each) for each in [*apart.ravel().tolist(), *orders.tolist()]}
    fits = []
    for part in windows.parts(len(needed)):
        edges = windows.edges[part.start : part.stop + 1]
        inside = slice(edges[0], edges[-1])
        turned = _exponentials(angles[inside], needed)
        fits.append(_fit(turned, z[inside], edges - edges[0], orders))
    amplitudes, errors, residual = (np.concatenate(each) for each in zip(*fits, strict=True))
    return Orders(amplitudes, errors, residual)


def scatter_between(amplitudes: Complex, windows: Windows, overlap: float) -> Values:
    """Return standard errors by the scatter between windows, 0 where there are too few.

    What leaks from a line that is not fitted turns from window to window, so it is seen in the
    deviations from the mean over a stretch of windows of equal speed, or from a parabola where
    the speed changes. Few windows that deviate far, as in a transient, are given less weight.
    """
    errors = np.zeros(amplitudes.shape)
    for part in _stretches(windows.speeds):
        within, speeds = amplitudes[part], windows.speeds[part]
        count = within.shape[0] * (1.0 - overlap)
        terms = 1 if np.ptp(speeds) <= STEADY * abs(speeds[0]) else 3
        terms = min(terms, int(count / WINDOWS_A_TERM))
        if terms == 0:
            continue
        basis = np.vander(np.linspace(-1.0, 1.0, within.shape[0]), terms)
        for k, values in enumerate(within.T):
            errors[part, k] = _deviation(basis, values, count)
    return errors


def _stretches(speeds: Values) -> Iterator[slice]:
    """Yield slices of neighbouring windows in which the speed changes little."""
    first = 0
    while first < speeds.size:
        ahead = speeds[first : first + MOST_WINDOWS]
        if speeds.size - first < 2 * MOST_WINDOWS:
            ahead = speeds[first:]
        span = np.maximum.accumulate(ahead) - np.minimum.accumulate(ahead)
        length = max(int(np.searchsorted(span, SPEED_SPAN * abs(ahead[0]), side="right")), 1)
        yield slice(first, first + length)
        first += length


def _deviation(basis: Values, values: Complex, count: float) -> float:
    """Return the root mean square per component of deviations from a robust mean or parabola."""
    weights = np.ones(values.size)
    for _ in range(8):
        roots = np.sqrt(weights)[:, None]
        curve = np.linalg.lstsq(roots * basis, roots[:, 0] * values, rcond=None)[0]
        squares = np.abs(values - basis @ curve) ** 2
        limit = 6.0 * float(np.median(squares))
        weights = np.minimum(1.0, (limit / np.maximum(squares, 1e-300)))
    mean = float(np.minimum(squares, limit).mean())
    return math.sqrt(mean * count / (count - basis.shape[1]) / 2.0)


def _key(order: float) -> float:
    """Return a key that is equal for orders that differ by rounding."""
    return round(order, 12)


def _exponentials(angles: Values, orders: dict[float, float]) -> dict[float, Complex]:
    """Return ``exp(i n angle)`` for orders from 0 up: most are products of those before."""
    known = {0.0: np.ones(angles.size, dtype=np.complex128)}
    for key, order in sorted(orders.items()):
        if key in known:
            continue
        pairs = ((each, _key(key - each)) for each in known if each > 0.0)
        pair = next(((a, b) for a, b in pairs if b in known), None)
        known[key] = np.exp(1j * order * angles) if pair is None else (
            known[pair[0]] * known[pair[1]])  # fmt: skip
    return known


def _fit(
    turned: dict[float, Complex], z: Complex, edges: npt.NDArray[np.intp], orders: Values
) -> tuple[Complex, Values, Values]:
    """Return amplitudes, their errors and the residual in windows with these edges."""
    starts, counts = edges[:-1], np.diff(edges)
    sums = {key: np.add.reduceat(each, starts) for key, each in turned.items()}
    apart = (orders - orders[:, None]).ravel().tolist()
    moments = [_signed(sums, each) for each in apart]
    gram = np.stack(moments, axis=-1).reshape(counts.size, orders.size, orders.size)
    inverse = np.linalg.inv(gram)
    basis = [_signed(turned, each) for each in orders.tolist()]
    right = np.stack([np.add.reduceat(each.conj() * z, starts) for each in basis], axis=-1)
    amplitudes = np.einsum("wjk,wk->wj", inverse, right)
    left = z.copy()
    for each, amplitude in zip(basis, amplitudes.T, strict=True):
        left -= np.repeat(amplitude, counts) * each
    squares = np.add.reduceat(np.abs(left) ** 2, starts)
    residual = np.sqrt(squares / np.maximum(counts - orders.size, 1))
    variances = np.einsum("wkk->wk", inverse).real
    errors = residual[:, None] * np.sqrt(np.maximum(variances, 0.0) / 2.0)
    return amplitudes, errors, residual


def _signed(of: dict[float, Complex], order: float) -> Complex:
    """Return the values of an order, given those of its modulus."""
    each = of[_key(abs(order))]
    return each if order >= 0.0 else each.conj()
