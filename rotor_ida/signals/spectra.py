"""Full spectra: forward and backward lines of a record, with bandwidth and noise floor."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice, check_count, check_nonnegative
from rotor_ida.errors import InputError
from rotor_ida.schema import Column
from rotor_ida.signals.record import FEWEST_SAMPLES, Record, record_of
from rotor_ida.signals.windows import MOST_OVERLAP, Complex

Window = Literal["flattop", "hann", "boxcar"]
WINDOWS = ("flattop", "hann", "boxcar")
# A speed that changes by less than this in the record counts as constant.
STEADY = 1e-3
MOST_LINES = 100_000_000
# Smallest length of a segment that is chosen here.
LEAST_SEGMENT = 64


def full_spectrum(
    signals: xr.Dataset, *, window: Window = "flattop", segment: int | None = None
) -> xr.Dataset:
    """Compute the forward and backward lines of a record, with bandwidth and noise floor.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with equally spaced samples.
    window : {"flattop", "hann", "boxcar"}
        Weights of the samples. Flat-top shows the amplitude of a line to 0.1 %, wherever it
        lies between the frequencies of the grid, but makes it 9 steps wide; Hann makes it 4
        steps wide and up to 15 % too low; boxcar, no weights, is exact for lines on the grid
        and smears all others.
    segment : int, optional
        Number of samples in a segment: the squares of the amplitudes are means over segments that
        overlap by half, which steadies the noise. By default the record is one segment.

    Returns
    -------
    Dataset
        ``whirl_amplitude`` on ``frequency``, positive for forward and negative for backward whirl;
        ``frequency_over_omega`` too if there is one speed. ``bandwidth``, the equivalent noise
        bandwidth of one line as a circular frequency, and ``noise_floor``, the amplitude of noise
        in one line.

    Raises
    ------
    InputError
        If the samples are not equally spaced, too few, or too far apart.

    Notes
    -----
    The spectrum is scipy.signal.welch's of ``z = x + i y``, two-sided, scaled so that a whirl
    ``A exp(i Omega t)`` is a line of height A at +Omega; a planar vibration ``x = A cos(Omega t)``
    is two lines of height A/2, a forward and a backward one. Steps of the grid are 2 pi over the
    length of a segment; one of whole revolutions has the spin speed on its grid. With N weights w
    a step h apart the equivalent noise bandwidth is ``2 pi sum(w**2)/(h sum(w)**2)``.

    The mean position of each segment, weighted alike, is no vibration and is subtracted: there is
    no line at 0, whatever the gap. The noise floor is the root of the mean power of noise with the
    median power of all lines; a few strong lines do not change a median. Segments that overlap
    count as fewer independent ones, by Welch's formula. The floor falls with longer segments; the
    density ``noise_floor**2/bandwidth`` does not.

    References
    ----------
    P. D. Welch, IEEE Transactions on Audio and Electroacoustics 15, 1967; G. Heinzel, A. Rüdiger,
    R. Schilling, "Spectrum and spectral density estimation by the discrete Fourier transform",
    Max-Planck-Institut für Gravitationsphysik, 2002, sections 8 and 9; C. W. Lee, "Vibration
    Analysis of Rotors", Kluwer, 1993: directional spectra.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0),
    ...                duration=200.0, samples=2001)
    >>> lines = full_spectrum(run.sel(t=slice(100, None)))
    >>> lines.whirl_amplitude.max().round(3).item(), lines.bandwidth.round(3).item()
    (0.85, 0.237)
    """
    from scipy.signal import get_window, welch  # noqa: PLC0415 - takes long to import

    check_choice("window", window, WINDOWS)
    record = record_of(signals)
    step = record.equal_step()
    size = (
        record.z.size
        if segment is None
        else check_count("segment", segment, FEWEST_SAMPLES, record.z.size)
    )
    weights = get_window(window, size, fftbins=True)
    frequency, power = welch(
        record.z, 1.0 / step, weights, size, size // 2,
        detrend=lambda pieces: _about_mean(pieces, weights), return_onesided=False,
        scaling="spectrum",
    )  # fmt: skip
    frequency = 2.0 * math.pi * np.fft.fftshift(frequency)
    power = np.fft.fftshift(power)
    count = (record.z.size - size // 2) // (size - size // 2)
    variables: dict[str, Column] = {
        "whirl_amplitude": ("frequency", np.sqrt(power)),
        "bandwidth": ((), _bandwidth(weights, step)),
        "noise_floor": ((), _noise_floor(power, _independent(weights, size // 2, count))),
    }
    coordinates: dict[str, Column] = {"frequency": ("frequency", frequency)}
    speed = one_speed(record)
    if speed is not None:
        coordinates["frequency_over_omega"] = ("frequency", frequency / speed)
    told = {"window": window, "segment": size, "segment_count": count}
    return record.dataset("Full spectrum", variables, coordinates, told, kind="full_spectrum")


def spectrogram(
    signals: xr.Dataset,
    *,
    window: Window = "hann",
    segment: int = 1024,
    overlap: float = 0.5,
) -> xr.Dataset:
    """Compute the full spectra of successive segments, over time and speed.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with equally spaced samples.
    window : {"flattop", "hann", "boxcar"}
        Weights of the samples, as of `full_spectrum`.
    segment : int
        Number of samples in a segment; the whole record if that is shorter.
    overlap : float
        Fraction by which segments overlap [dimensionless], from 0 to 0.95.

    Returns
    -------
    Dataset
        ``whirl_amplitude`` on (``window``, ``frequency``), positive for forward and negative for
        backward whirl; ``bandwidth``; ``t`` on ``window``, and ``speed`` if the angle is known.

    Raises
    ------
    InputError
        If the samples are not equally spaced, too few, or too far apart.

    Notes
    -----
    Only complete segments are used, about their mean positions as in `full_spectrum`. A whirl of
    amplitude A is a line of height A. If the speed changes by ``d`` in a segment, the line of a
    synchronous whirl is about ``d`` wide and lower.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> run = run_up(Rotor(omega=0.2, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), to=2.2,
    ...              rate=0.01, samples=4001)
    >>> seen = spectrogram(run, segment=1000)
    >>> highest = seen.frequency[seen.whirl_amplitude.argmax("frequency")]
    >>> bool((abs(highest - seen.speed) < 0.3).all())
    True
    """
    from scipy.fft import fft  # noqa: PLC0415 - takes long to import
    from scipy.signal import get_window  # noqa: PLC0415 - takes long to import

    check_choice("window", window, WINDOWS)
    record = record_of(signals)
    step = record.equal_step()
    most = check_count("segment", segment, FEWEST_SAMPLES)
    size = min(most, record.z.size)
    part = check_nonnegative("overlap", overlap, MOST_OVERLAP)
    hop = max(1, round(size * (1.0 - part)))
    weights = get_window(window, size, fftbins=True)
    starts = np.arange(0, record.z.size - size + 1, hop)
    if starts.size * size > MOST_LINES:
        raise InputError(f"overlap must be smaller, got {part!r}: {starts.size} segments of {size}")
    pieces = _about_mean(np.lib.stride_tricks.sliding_window_view(record.z, size)[::hop], weights)
    lines = np.abs(np.fft.fftshift(fft(pieces * weights, axis=-1), axes=-1)) / weights.sum()
    frequency = 2.0 * math.pi * np.fft.fftshift(np.fft.fftfreq(size, step))
    times = record.times[starts] + 0.5 * (size - 1) * step
    coordinates: dict[str, Column] = {
        "window": ("window", np.arange(starts.size)),
        "t": ("window", times),
        "frequency": ("frequency", frequency),
    }
    if record.angles is not None:
        angles = record.angles
        turned = angles[starts + size - 1] - angles[starts]
        coordinates["speed"] = ("window", turned / ((size - 1) * step))
    variables: dict[str, Column] = {
        "whirl_amplitude": (("window", "frequency"), lines),
        "bandwidth": ((), _bandwidth(weights, step)),
    }
    told = {"window": window, "segment": size, "overlap": 1.0 - hop / size}
    return record.dataset("Spectrogram", variables, coordinates, told, kind="spectrogram")


def _about_mean(pieces: Complex, weights: Values) -> Complex:
    """Return displacements of segments about their weighted means: without the line at 0."""
    return np.asarray(pieces - (pieces @ weights / weights.sum())[..., np.newaxis])


def _bandwidth(weights: npt.NDArray[np.float64], step: float) -> float:
    """Return the equivalent noise bandwidth of a window as a circular frequency."""
    return 2.0 * math.pi * float((weights**2).sum() / weights.sum() ** 2) / step


def _independent(weights: Values, overlap: int, count: int) -> float:
    """Return the number of independent segments equivalent to overlapping ones (Welch, 1967)."""
    hop = weights.size - overlap
    shared = 0.0
    for apart in range(1, min(count, math.ceil(weights.size / hop))):
        common = float(weights[apart * hop :] @ weights[: weights.size - apart * hop])
        shared += 2.0 * (1.0 - apart / count) * (common / float(weights @ weights)) ** 2
    return count / (1.0 + shared)


def _noise_floor(power: Values, count: float) -> float:
    """Return the amplitude of noise in a line, from the median of all lines."""
    from scipy.stats import gamma  # noqa: PLC0415 - takes long to import

    # a mean of `count` squares of complex normal numbers
    return math.sqrt(float(np.median(power)) / float(gamma.median(count) / count))


def one_speed(record: Record) -> float | None:
    """Return the speed of a record if it is constant, else None."""
    if record.angles is None:
        return None
    half = record.angles.size // 2
    ends = ((0, half), (half, -1))
    early, late = (
        float((record.angles[end] - record.angles[begin])
              / (record.times[end] - record.times[begin]))
        for begin, end in ends
    )  # fmt: skip
    mean = (early + late) / 2.0
    whole = (record.angles[-1] - record.angles[0]) / (record.times[-1] - record.times[0])
    return float(whole) if mean > 0.0 and abs(late - early) < STEADY * mean else None


def segment_for(record: Record) -> int:
    """Return the number of samples in a segment with lines as narrow as the speed allows.

    At one speed an eighth of the record. Otherwise the speed changes in a segment by the width of
    a line of a Hann window.
    """
    size, step = record.times.size, record.equal_step()
    length = size * step / 8.0
    if record.angles is not None:
        speeds = np.gradient(record.angles, step)
        change = float(np.ptp(speeds[:: max(1, size // 1000)])) / (size * step)
        if change * size * step > STEADY * float(np.abs(speeds).max()):
            # a line of a Hann window is 1.5 over the length wide
            length = min(length, math.sqrt(3.0 * math.pi / change))
    return int(np.clip(length / step, LEAST_SEGMENT, size))
