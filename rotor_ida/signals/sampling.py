"""Check that a motion is sampled densely enough for its whirls, without aliasing."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    SAMPLES_A_REVOLUTION,
    check_increasing,
    check_nonnegative,
    check_samples,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.results.checked_run import refuse_system, samples_in
from rotor_ida.results.si_units import scale_of

# Samples per revolution, and per turn of the whirl. Measured signals have passed a filter;
# simulated ones have not, and the harmonics of a rub would be aliased.
OF_RUN, OF_MEASUREMENT = 4.0, 2.0
# Samples over which the whirl frequency is estimated.
BLOCK = 32
# A motion slower than this part of the fastest block is rest or rounding.
AT_REST = 1e-6


def check_sampling(
    name: str,
    times: Values,
    z: npt.NDArray[np.complex128],
    velocities: npt.NDArray[np.complex128] | None,
    angles: Values | None,
) -> None:
    """Refuse samples that are too far apart to resolve rotation and whirl.

    Parameters
    ----------
    name : str
        Name of the argument, for the message.
    times : ndarray, shape (n,)
        Times of the samples.
    z, velocities : ndarray of complex, shape (n,)
        Displacements and velocities. Samples without velocities count as measured.
    angles : ndarray, shape (n,), or None
        Angles of the rotor [rad], if they are known.

    Raises
    ------
    InputError
        If there are at most 2 samples per revolution; for a run at most 4 per revolution or per
        turn of the whirl. The message states how many are enough.

    Notes
    -----
    The circular frequency of a whirl is taken as ``rms(z')/rms(z - mean(z))`` over 32 samples. For
    several frequencies it is their root mean square, weighted by the squared amplitudes. It does
    not need closely spaced samples.

    Examples
    --------
    >>> times = np.linspace(0.0, 100.0, 201)
    >>> whip = np.exp(-5j * times)  # turns 0.4 times from one sample to the next
    >>> check_sampling("run", times, whip, -5j * whip, times)
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: run must have more than 4 samples in each turn of the whirl, ...
    """
    if times.size < 2:
        return
    fewest = OF_MEASUREMENT if velocities is None else OF_RUN
    steps, extent = np.diff(times), float(times[-1] - times[0])
    if angles is not None:
        speeds = np.diff(angles) / steps
        _check(name, "revolution", fewest, times, speeds, steps, extent)
    if velocities is not None:
        starts = np.arange(0, max(times.size - BLOCK, 0) + 1, BLOCK)
        counts = np.diff(starts, append=times.size)
        rates = _whirl_rates(z, velocities, starts, counts)
        mean_steps = (times[starts + counts - 1] - times[starts]) / (counts - 1)
        _check(name, "turn of the whirl", fewest, times[starts], rates, mean_steps, extent)


def check_run_sampling(run: xr.Dataset) -> None:
    """Refuse a run that is sampled too coarsely to be drawn; see `check_sampling`."""
    refuse_system("run", run)
    times = check_increasing("t", samples_in("run", run, "t"))
    z = samples_in("run", run, "x") + 1j * samples_in("run", run, "y")
    check_sampling("run", times, z, velocities_of(run), run_angles(run, times))


def velocities_of(run: xr.Dataset) -> npt.NDArray[np.complex128] | None:
    """Return complex velocities in units of length over units of time; None if there are none."""
    if not {"vx", "vy"} <= set(run.variables):
        return None
    unit = scale_of(run, "length") / (scale_of(run, "time") * scale_of(run, "velocity"))
    z = samples_in("run", run, "vx") + 1j * samples_in("run", run, "vy")
    return np.asarray(unit * z, dtype=np.complex128)


def run_angles(run: xr.Dataset, times: Values) -> Values | None:
    """Return the angles of the rotor in a run, at a constant or changing speed."""
    if "angle" in run.variables:
        return samples_in("run", run, "angle")
    if "omega" in run.variables and not run["omega"].ndim:
        omega = check_nonnegative("omega", run["omega"].values)
        with np.errstate(over="ignore"):
            angles = np.float64(omega) / scale_of(run, "time") * times
        return check_samples("the angle", angles)
    return None


def _whirl_rates(
    z: npt.NDArray[np.complex128],
    velocities: npt.NDArray[np.complex128],
    starts: npt.NDArray[np.intp],
    counts: npt.NDArray[np.intp],
) -> Values:
    """Return the circular frequency of the whirl in each block of samples; 0 where it rests."""
    centre = np.add.reduceat(z, starts) / counts
    about = np.add.reduceat(np.abs(z - np.repeat(centre, counts)) ** 2, starts)
    moving = np.add.reduceat(np.abs(velocities) ** 2, starts)
    rests = moving <= (AT_REST**2) * moving.max()
    tiny = np.finfo(float).tiny
    rates: Values = np.where(rests, 0.0, np.sqrt(moving / np.maximum(about, tiny)))
    return rates


def _check(
    name: str,
    of_what: str,
    fewest: float,
    times: Values,
    rates: Values,
    steps: Values,
    extent: float,
) -> None:
    """Refuse circular frequencies that the steps between samples do not resolve."""
    turned = rates * steps / (2.0 * math.pi)
    worst = int(np.argmax(turned))
    if turned[worst] * fewest < 1.0:
        return
    enough = math.ceil(SAMPLES_A_REVOLUTION * rates.max() * extent / (2.0 * math.pi)) + 1
    raise InputError(
        f"{name} must have more than {fewest:g} samples in each {of_what}, got "
        f"{1.0 / turned[worst]:.3g} at t {times[worst]:.6g}: {shown(enough)} samples in all are "
        "enough"
    )
