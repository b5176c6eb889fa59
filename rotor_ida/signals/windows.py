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
# the speed changes less than `STEADY`, else as a curve with resonances, of fewer terms where there
# are few windows for each.
MOST_WINDOWS = 128
SPEED_SPAN, STEADY = 0.04, 0.002
WINDOWS_A_TERM, MOST_TERMS = 2, 5
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


def windows_of(record: Record, revolutions: int, overlap: float = 0.0) -> Windows:
    """Return the complete windows of a number of revolutions in a record, from its beginning."""
    angles = record.known_angles()
    turns = (angles - angles[0]) / (2.0 * math.pi * revolutions)
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


def fit_orders(
    record: Record,
    windows: Windows,
    orders: Values,
    degrees: npt.NDArray[np.intp] | None = None,
    slopes: Complex | None = None,
) -> Orders:
    """Return the complex amplitude of each signed order in each window, and the residual.

    Parameters
    ----------
    record : Record
        The signals.
    windows : Windows
        Their windows.
    orders : ndarray, shape (k,)
        Orders, negative for backward whirl; 0 is the mean position.
    degrees : ndarray of int, shape (k,), optional
        Degree of the polynomial by which the amplitude of each order changes within a window. The
        amplitude returned is the mean. Default: amplitudes that are constant in a window.
    slopes : ndarray of complex, shape (windows, k), optional
        Known change of each amplitude in half a window, which is subtracted first.

    Notes
    -----
    For noise of variance s**2 in z the covariance of the amplitudes is s**2 times the inverse of
    the matrix of the normal equations, which is well-conditioned over whole revolutions.
    """
    angles, z = record.known_angles()[windows.samples], record.z[windows.samples]
    # Legendre polynomials times the exponential of their order, those of degree 0 first
    within = np.zeros(orders.size, dtype=np.intp) if degrees is None else degrees
    highest = int(within.max())
    columns = np.concatenate([np.flatnonzero(within >= each) for each in range(highest + 1)])
    powers = np.concatenate([np.full((within >= p).sum(), p) for p in range(highest + 1)])
    fits = []
    for part in windows.parts(columns.size):
        edges = windows.edges[part.start : part.stop + 1]
        counts = np.diff(edges)[:, np.newaxis]
        inside = np.arange(counts.max()) < counts
        at = np.minimum(edges[:-1, np.newaxis] + np.arange(counts.max()), edges[-1] - 1)
        middle = (angles[at] * inside).sum(axis=1, keepdims=True) / counts
        place = (angles[at] - middle) / (math.pi * windows.revolutions)
        whirls = inside[..., np.newaxis] * np.exp(1j * angles[at][..., np.newaxis] * orders)
        polynomials = np.polynomial.legendre.legvander(place, highest)
        basis = whirls if highest == 0 else whirls[..., columns] * polynomials[..., powers]
        seen = z[at] * inside
        if slopes is not None:
            seen = seen - place * np.einsum("wnk,wk->wn", whirls, slopes[part])
        fits.append(_fit(basis, seen, counts[:, 0], orders.size))
    amplitudes, errors, residual = (np.concatenate(each) for each in zip(*fits, strict=True))
    return Orders(amplitudes, errors, residual)


def scatter_between(amplitudes: Complex, windows: Windows, overlap: float) -> Values:
    """Return standard errors by the scatter between windows, 0 where there are too few.

    What leaks from a line that is not fitted turns from window to window, so it is seen in the
    deviations from the mean over a stretch of windows of equal speed, or from a curve with up to
    two resonances where the speed changes. Few windows that deviate far, as in a transient, are
    given less weight.
    """
    errors = np.zeros(amplitudes.shape)
    for part in _stretches(windows.speeds, overlap):
        within, speeds = amplitudes[part], windows.speeds[part]
        count = within.shape[0] * (1.0 - overlap)
        terms = 1 if np.ptp(speeds) <= STEADY * abs(speeds[0]) else MOST_TERMS
        terms = min(terms, int(count / WINDOWS_A_TERM))
        for k, values in enumerate(within.T if terms else ()):
            errors[part, k] = _deviation(values, terms, count)
    return errors


def _stretches(speeds: Values, overlap: float) -> Iterator[slice]:
    """Yield slices of neighbouring windows in which the speed changes little.

    Windows that overlap are as many as make up the same number of windows side by side.
    """
    fewest, most = (round(each / (1.0 - overlap))
                    for each in (MOST_TERMS * WINDOWS_A_TERM, MOST_WINDOWS))  # fmt: skip
    first = 0
    while first < speeds.size:
        ahead = speeds[first : first + most]
        if speeds.size - first < 2 * most:
            ahead = speeds[first:]
        span = np.maximum.accumulate(ahead) - np.minimum.accumulate(ahead)
        length = int(np.searchsorted(span, SPEED_SPAN * abs(ahead[0]), side="right"))
        length = max(length, fewest)
        if speeds.size - first - length < fewest:
            length = speeds.size - first
        yield slice(first, first + length)
        first += length


def _deviation(values: Complex, terms: int, count: float) -> float:
    """Return the root mean square per component of deviations from a robust smooth curve.

    The curve ``(a + b x + e x**2)/(1 + d x + f x**2)``, or its first terms, has the form of the
    response near one or two resonances. It is fitted in the form without a quotient (Levy, 1959),
    with the denominators of the solution before as weights (Sanathanan and Koerner, 1963).
    """
    x = np.linspace(-1.0, 1.0, values.size)
    ones = np.ones_like(x)
    basis = np.stack([ones, x, values * x, x * x, values * x * x], axis=1)[:, :terms]
    weights, below = ones, ones.astype(np.complex128)
    for _ in range(8):
        roots = np.sqrt(weights) / np.abs(below)
        found = np.linalg.lstsq(roots[:, None] * basis, roots * values, rcond=None)[0]
        denominator = np.append(found, np.zeros(MOST_TERMS - terms))[[2, 4]]
        below = 1.0 - denominator[0] * x - denominator[1] * x * x
        squares = np.abs((values - basis @ found) / below) ** 2
        limit = 6.0 * float(np.median(squares))
        weights = np.minimum(1.0, (limit / np.maximum(squares, 1e-300)))
    mean = float(np.minimum(squares, limit).mean())
    return math.sqrt(mean * count / (count - terms) / 2.0)


def _fit(
    basis: Complex, seen: Complex, counts: npt.NDArray[np.intp], kept: int
) -> tuple[Complex, Values, Values]:
    """Return the first amplitudes, their errors and the residual of windows of equal length.

    Windows are filled up with zeros. The basis has the shape (window, sample, column).
    """
    # products of few columns by threads take many times as long: no matmul
    conjugate = basis.conj()
    inverse = np.linalg.inv(np.einsum("wnj,wnk->wjk", conjugate, basis))
    sums = np.einsum("wnk,wn->wk", conjugate, seen)
    amplitudes = np.einsum("wjk,wk->wj", inverse, sums)
    squares = (np.abs(seen - np.einsum("wnk,wk->wn", basis, amplitudes)) ** 2).sum(axis=1)
    residual = np.sqrt(squares / np.maximum(counts - basis.shape[2], 1))
    variances = np.einsum("wkk->wk", inverse).real[:, :kept]
    errors = residual[:, None] * np.sqrt(np.maximum(variances, 0.0) / 2.0)
    return amplitudes[:, :kept], errors, residual
