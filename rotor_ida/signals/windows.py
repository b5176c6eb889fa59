"""Windows of whole revolutions, and the orders in each by least squares."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.signals.record import Record

# Of a window: a sample at its edge belongs to it, whatever rounding did to its angle.
EDGE = 1e-9
Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Windows:
    """Samples of a record by windows of whole revolutions, one after the other.

    Parameters
    ----------
    edges : ndarray of int, shape (windows + 1,)
        Which sample is the first of each window, and of what follows the last.
    revolutions : int
        Revolutions in a window.
    times, speeds : ndarray, shape (windows,)
        Mean time of the samples of each, and the speed there [rad over the unit of time].
    """

    edges: npt.NDArray[np.intp]
    revolutions: int
    times: Values
    speeds: Values

    def sums(self, values: npt.NDArray[np.inexact]) -> npt.NDArray[np.inexact]:
        """Return the sum of the values over each window."""
        return np.add.reduceat(values[: self.edges[-1]], self.edges[:-1])

    def spread(self, values: npt.NDArray[np.inexact]) -> npt.NDArray[np.inexact]:
        """Return for each sample in a window what belongs to the window."""
        return np.repeat(values, np.diff(self.edges))


def windows_of(record: Record, revolutions: int) -> Windows:
    """Return the windows of so many revolutions that a record holds whole."""
    angles = record.known_angles()
    turns = (angles - angles[0]) / (2.0 * math.pi * revolutions)
    # samples of whole revolutions end one step before the first repeats
    count = math.floor(turns[-1] + (turns[-1] - turns[-2]) + EDGE)
    if count < 1:
        raise InputError(
            f"signals must hold at least {revolutions} whole revolutions, got "
            f"{turns[-1] * revolutions:.3g}"
        )
    edges = np.searchsorted(turns, np.arange(count + 1) - EDGE)
    counts = np.diff(edges)
    if counts.min() < 2:
        at = record.times[min(edges[counts.argmin()], record.times.size - 1)]
        raise InputError(
            f"signals must hold more than two samples a revolution, got {counts.min()} in "
            f"{revolutions} at t {at:.6g}"
        )
    span = slice(edges[0], edges[-1])
    starts = edges[:-1]
    times, angles = record.times[span], angles[span]
    mean_time = np.add.reduceat(times, starts) / counts
    mean_angle = np.add.reduceat(angles, starts) / counts
    since = times - np.repeat(mean_time, counts)
    turned = angles - np.repeat(mean_angle, counts)
    speeds = np.add.reduceat(since * turned, starts) / np.add.reduceat(since**2, starts)
    return Windows(edges, revolutions, mean_time, speeds)


def fit_orders(record: Record, windows: Windows, orders: Values) -> tuple[Complex, Values]:
    """Return the complex amplitude of each signed order in each window, and what they leave.

    Parameters
    ----------
    record : Record
        The signals.
    windows : Windows
        Their windows.
    orders : ndarray, shape (k,)
        Orders, negative for backward whirl; 0 is the mean position.

    Returns
    -------
    amplitudes : ndarray of complex, shape (windows, k)
        ``c`` of ``z = sum(c_n exp(i n angle))``.
    residual : ndarray, shape (windows,)
        Root of the mean square of what is left.

    Notes
    -----
    The normal equations hold sums of ``exp(i (n - m) angle)`` alone. Over whole revolutions the
    orders are nearly orthogonal, so that they are solved to rounding.
    """
    angles, z = record.known_angles(), record.z
    differences, where = np.unique(
        np.round(orders[None, :] - orders[:, None], 12), return_inverse=True
    )
    moments = np.stack([windows.sums(np.exp(1j * each * angles)) for each in differences], axis=-1)
    gram = moments[:, where.reshape(orders.size, orders.size)]
    right = np.stack([windows.sums(np.exp(-1j * each * angles) * z) for each in orders], axis=-1)
    amplitudes = np.linalg.solve(gram, right[..., None])[..., 0]
    inside = slice(0, int(windows.edges[-1]))
    left = z[inside].copy()
    for each, amplitude in zip(orders, amplitudes.T, strict=True):
        left -= windows.spread(amplitude) * np.exp(1j * each * angles[inside])
    counts = np.diff(windows.edges)
    residual = np.sqrt(windows.sums(np.abs(left) ** 2) / counts)
    return np.asarray(amplitudes, np.complex128), np.asarray(residual, np.float64)
