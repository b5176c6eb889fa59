"""The two-sided spectrum of a run: forward whirl at positive, backward at negative frequencies."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice
from rotor_ida.errors import InputError
from rotor_ida.results.run import check_one_speed, check_run, parameter_coordinates, rotor_of
from rotor_ida.schema import Column, labelled_dataset, origin_of

Window = Literal["flattop", "hann", "boxcar"]

WINDOWS = ("flattop", "hann", "boxcar")
FEWEST_SAMPLES = 16
# Steps of equally spaced times differ by rounding only.
UNEQUAL = 1e-6


def spectrum(run: xr.Dataset, *, window: Window = "flattop") -> xr.Dataset:
    """Return how much forward and backward whirl a run holds at each frequency.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate` with equally spaced samples, or a part of one:
        ``run.sel(t=slice(100, None))`` leaves the transient out.
    window : {"flattop", "hann", "boxcar"}
        Weights of the samples. Flat-top shows the amplitude of a line to 0.1 %, wherever it
        lies between the frequencies of the grid, but makes it 9 steps wide; Hann makes it 4
        steps wide and up to 15 % too low; boxcar, no weights, is exact for lines on the grid
        and smears all others.

    Returns
    -------
    Dataset
        ``whirl_amplitude`` on ``frequency`` [1], from minus to plus half the sampling rate;
        ``frequency_over_omega`` beside it if the rotor turns.

    Raises
    ------
    InputError
        If the dataset is no run, its samples are not equally spaced, too few, or two or fewer
        a revolution.

    Notes
    -----
    With N samples of ``z = x + i y`` and weights w,
    ``c(Omega) = sum(w z exp(-i Omega t)) / sum(w)``. A whirl ``A exp(i Omega t)`` is a line of
    height A at +Omega; a planar vibration ``x = A cos(Omega t)`` is two lines of height A/2, a
    forward and a backward one. Steps of the grid are 2 pi over the length of the record; a
    record of whole revolutions has the spin speed on its grid.

    References
    ----------
    G. Heinzel, A. Rüdiger, R. Schilling, "Spectrum and spectral density estimation by the
    discrete Fourier transform", Max-Planck-Institut für Gravitationsphysik, 2002, section 9.
    C. W. Lee, "Vibration Analysis of Rotors", Kluwer, 1993: directional spectra.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0),
    ...                duration=200.0, samples=2001)
    >>> lines = spectrum(run.sel(t=slice(100, None)))
    >>> lines.whirl_amplitude.max().round(3).item()
    0.85
    >>> lines.frequency[lines.whirl_amplitude.argmax("frequency")].round(1).item()
    1.2
    """
    run = check_run(run, ("t", "x", "y"))
    check_one_speed(run, "a spectrum")
    check_choice("window", window, WINDOWS)
    rotor = rotor_of(run)
    times = run["t"].values
    step = _equal_step(times)
    if rotor.omega * step >= math.pi:
        raise InputError(
            "run must hold more than two samples a revolution, got "
            f"{2.0 * math.pi / (rotor.omega * step):.3g}"
        )
    frequency, height = lines_of(run["x"].values + 1j * run["y"].values, step, window)
    coordinates = parameter_coordinates(rotor) | {"frequency": ("frequency", frequency)}
    if rotor.omega > 0.0:
        coordinates["frequency_over_omega"] = ("frequency", frequency / rotor.omega)
    attributes = {**origin_of(run), "window": window, "record_length": times.size * step}
    columns: dict[str, Column] = {"whirl_amplitude": ("frequency", height)}
    return labelled_dataset(
        "Two-sided spectrum of one run", columns, coordinates, attributes, kind="spectrum"
    )


def lines_of(z: npt.NDArray[np.complex128], step: float, window: Window) -> tuple[Values, Values]:
    """Return frequencies [1] and amplitudes [1] of the whirls that displacements hold.

    Parameters
    ----------
    z : ndarray, shape (n,)
        ``x + i y`` at equally spaced times [1].
    step : float
        Time from one to the next [1].
    window : {"flattop", "hann", "boxcar"}
        Weights, as for `spectrum`.
    """
    from scipy.signal import get_window  # noqa: PLC0415 - takes 0.3 s, and few who import this ask

    weights = get_window(window, z.size, fftbins=True)
    height = np.abs(np.fft.fftshift(np.fft.fft(weights * z))) / weights.sum()
    return 2.0 * math.pi * np.fft.fftshift(np.fft.fftfreq(z.size, step)), height


def _equal_step(times: Values) -> float:
    """Return the step of equally spaced times."""
    if times.size < FEWEST_SAMPLES:
        raise InputError(f"run must hold at least {FEWEST_SAMPLES} samples, got {times.size}")
    steps = np.diff(times)
    mean = float(times[-1] - times[0]) / (times.size - 1)
    if np.abs(steps - mean).max() > UNEQUAL * mean:
        raise InputError(
            "run must have equally spaced samples, got steps from "
            f"{steps.min():.6g} to {steps.max():.6g}"
        )
    return mean
