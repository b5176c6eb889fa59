"""Spectral lines off the frequency grid: frequencies and amplitudes by least squares."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_count
from rotor_ida.errors import InputError
from rotor_ida.schema import Column
from rotor_ida.signals.record import record_of
from rotor_ida.signals.spectra import one_speed
from rotor_ida.signals.windows import Complex

MOST_LINES = 50
MOST_NUMBERS = 20_000_000  # samples times lines, that the least squares take a few GB at most
MOST_STEPS = 12
# Weights of a Kaiser window whose main lobe is twice so many steps of the grid wide leave nothing
# of a line in another that is further away, to rounding.
WIDEST = 11.0
# Steps of the grid within which two lines count as one, in the search and afterwards.
NEAREST = 4.0


def spectral_lines(signals: xr.Dataset, *, count: int = 10) -> xr.Dataset:
    """Return the strongest lines of a record: frequencies and amplitudes between the grid's steps.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with equally spaced samples, of a
        motion that has settled.
    count : int
        Largest number of lines [dimensionless]. A line within four steps of the grid (``2 pi`` over
        the length of the record) of a stronger one counts as part of it.

    Returns
    -------
    Dataset
        On ``line``, in order of frequency: ``frequency``, positive for forward and negative for
        backward whirl; ``whirl_amplitude``; ``whirl_phase`` at time 0 [rad];
        ``frequency_over_omega`` if there is one speed. ``window_residual``, the root mean square
        of the residual.

    Raises
    ------
    InputError
        If the samples are not equally spaced, too few or too many, or all of them 0.

    Notes
    -----
    ``sum(c_k exp(i Omega_k t))`` is fitted to ``z = x + i y``, all frequencies and amplitudes at
    once, by weighted least squares. Each line begins at the highest peak of the residual of those
    before it. The weights are a Kaiser window whose main lobe is as wide as the lines are apart, so
    that lines that are not fitted hardly affect those that are. The lines of a record of only a
    few are exact to rounding; those of a limit cycle over sixty periods to about 1e-10.

    References
    ----------
    J. Laskar, "Frequency analysis for multi-dimensional systems", Physica D 67, 1993.

    Examples
    --------
    >>> t = np.arange(4000) / 100
    >>> z = 2 * np.exp(1.2345j * t) + 0.1 * np.exp(-3.21j * t)
    >>> found = spectral_lines(xr.Dataset({"x": ("t", z.real), "y": ("t", z.imag)}, {"t": t}),
    ...                        count=2)
    >>> found.frequency.values.round(8), found.whirl_amplitude.values.round(8)
    (array([-3.21  ,  1.2345]), array([0.1, 2. ]))
    """
    most = check_count("count", count, 1, MOST_LINES)
    record = record_of(signals)
    step = record.equal_step()
    size = record.z.size
    if size < 4 * most + 8:
        raise InputError(f"signals must have at least {4 * most + 8} samples, got {size}")
    middle = 0.5 * (record.times[0] + record.times[-1])
    if size * most > MOST_NUMBERS:
        raise InputError(
            f"samples times count must be at most {MOST_NUMBERS}, got {size * most}: take part of "
            "the signals, or fewer lines"
        )
    times = np.asarray(step * (np.arange(size) - 0.5 * (size - 1)), dtype=np.float64)
    found = np.sort(_strongest(record.z, times, most))
    if not found.size:
        raise InputError("signals must move, got x and y of 0 throughout")
    grid = 2.0 * math.pi / (size * step)
    apart = float(np.diff(found).min(initial=math.inf)) / grid
    frequencies, amplitudes = _refined(record.z, times, found, min(apart, WIDEST))
    left = record.z - _motion(times, frequencies, amplitudes)
    phases = np.angle(amplitudes * np.exp(-1j * frequencies * middle))
    variables: dict[str, Column] = {
        "frequency": ("line", frequencies),
        "whirl_amplitude": ("line", np.abs(amplitudes)),
        "whirl_phase": ("line", phases),
        "window_residual": ((), float(np.sqrt(np.mean(abs(left) ** 2)))),
    }
    speed = one_speed(record)
    if speed is not None:
        variables["frequency_over_omega"] = ("line", frequencies / speed)
    coordinates: dict[str, Column] = {"line": ("line", np.arange(frequencies.size))}
    return record.dataset("Lines of the spectrum", variables, coordinates, kind="spectral_lines")


def _strongest(z: Complex, times: Values, most: int) -> Values:
    """Return the frequencies of the strongest lines, one after the other."""
    from scipy.fft import fft, fftfreq  # noqa: PLC0415 - takes long to import

    grid = 2.0 * math.pi * fftfreq(z.size, times[1] - times[0])
    weights = np.kaiser(z.size, _shape(NEAREST))
    found, left = np.zeros(0), z
    for _ in range(most):
        height = np.abs(fft(weights * left))
        for each in found:
            height[np.abs(grid - each) < NEAREST * grid[1]] = 0.0
        if height.max() <= 1e-14 * np.abs(z).max() * weights.sum():
            break
        found = np.append(found, grid[height.argmax()])
        found, amplitudes = _refined(z, times, found, NEAREST)
        left = z - _motion(times, found, amplitudes)
    return found


def _refined(
    z: Complex, times: Values, frequencies: Values, width: float
) -> tuple[Values, Complex]:
    """Return frequencies and amplitudes by least squares, with Gauss-Newton steps."""
    weights = np.kaiser(z.size, _shape(width))
    roots = np.sqrt(weights)
    largest = 0.5 * math.pi / (times[-1] - times[0])
    amplitudes = np.zeros(frequencies.size, dtype=np.complex128)
    for _ in range(MOST_STEPS):
        whirls = roots[:, None] * np.exp(1j * times[:, None] * frequencies)
        basis = np.concatenate([whirls, times[:, None] / times[-1] * whirls], axis=1)
        adjoint = basis.conj().T
        both = np.linalg.solve(adjoint @ basis, adjoint @ (roots * z))
        amplitudes, slopes = np.split(both, 2)
        small = np.abs(amplitudes) < 1e-300
        change = np.imag(slopes / np.where(small, 1.0, amplitudes)) / times[-1]
        frequencies = frequencies + np.clip(change, -largest, largest)
        if np.abs(change).max() * times[-1] < 1e-13:
            break
    return np.asarray(frequencies, dtype=np.float64), np.asarray(amplitudes, dtype=np.complex128)


def _shape(width: float) -> float:
    """Return Kaiser's parameter for a half main lobe of this many steps of the grid."""
    return math.pi * math.sqrt(max(width**2 - 1.0, 0.0))


def _motion(times: Values, frequencies: Values, amplitudes: Complex) -> Complex:
    """Return the sum of the lines at times."""
    motion: Complex = np.zeros(times.size, dtype=np.complex128)
    for frequency, amplitude in zip(frequencies, amplitudes, strict=True):
        motion += amplitude * np.exp(1j * frequency * times)
    return motion
