"""Orbits of one order, or of a band of frequencies."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_array, check_count, check_positive, shown
from rotor_ida.errors import InputError
from rotor_ida.schema import Column
from rotor_ida.signals.orders import LARGEST_ORDER, fit, revolutions_for
from rotor_ida.signals.record import Record, record_of
from rotor_ida.signals.windows import Complex, windows_of

POLES = 4


def filtered_orbit(
    signals: xr.Dataset,
    *,
    order: float | None = None,
    band: tuple[float, float] | None = None,
    revolutions: int | None = None,
) -> xr.Dataset:
    """Filter the orbit to one order of the speed, or to a band of frequencies.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run.
    order : float, optional
        Multiple of the speed [dimensionless], which gives the ellipse of its forward and backward
        whirl.
    band : tuple of float, optional
        Lowest and highest circular frequency, radians over the unit of time; 0 as the lowest keeps
        the mean position.
    revolutions : int, optional
        Length of the windows in which an order is tracked, as in `orders`.

    Returns
    -------
    Dataset
        Signals with ``x y`` filtered, and ``angle`` if it is known; for an order also
        ``filter_error``, the standard error of x and of y.

    Raises
    ------
    InputError
        If not exactly one of order and band is given, if the angle for an order is not known, or
        if the samples for a band are not equally spaced.

    Notes
    -----
    An order is fitted in each window as in `orders`, whose errors give those of x and y. Between
    the middles of windows the complex amplitudes change linearly; before the first and after the
    last they are constant. A band is
    filtered by a Butterworth filter of order 4, forwards and backwards in time, without phase
    shift. Its gain
    is ``1/(1 + s**8)`` with, up to the frequency W, ``s = T(f)/T(W)`` and, between V and W, ``s =
    (T(f)**2 - T(V) T(W))/(T(f) (T(W) - T(V)))``, where ``T(f) = tan(f h/2)`` for samples a step h
    apart. So a line at an end of the band has half its amplitude. Near the ends of the record it
    rings.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0),
    ...                duration=200.0, samples=2001)
    >>> once = filtered_orbit(run, order=1)
    >>> abs(once.x - run.x)[1000:].max().item() < 1e-6
    True
    """
    if (order is None) == (band is None):
        raise InputError("either order or band must be given, got " + ("none" if band is None
                         else "both"))  # fmt: skip
    record = record_of(signals)
    told: dict[str, object] = {}
    if band is None:
        asked = check_positive("order", order, LARGEST_ORDER)
        z, error = _of_order(record, asked, revolutions)
        columns: dict[str, Column] = {"filter_error": ("t", error)}
        told["filter_order"] = asked
    else:
        z, told["filter_band"] = _of_band(record, band)
        columns = {}
    columns |= {"x": ("t", z.real), "y": ("t", z.imag)}
    if record.angles is not None:
        columns["angle"] = ("t", record.angles)
    return record.dataset(
        "Filtered signals", columns, {"t": ("t", record.times)}, told, kind="signals"
    )


def _of_order(record: Record, order: float, revolutions: int | None) -> tuple[Complex, Values]:
    """Return the displacement by one order, forward and backward, and its error along an axis."""
    asked = np.array([order])
    windows = windows_of(record, revolutions_for(asked, revolutions))
    fitted = fit(record, windows, asked)
    ahead, back = (np.interp(record.times, windows.times, each) for each in fitted.amplitudes.T[:2])
    error = np.interp(record.times, windows.times, np.hypot(*fitted.errors.T[:2]))
    turn = np.exp(1j * order * record.known_angles())
    return np.asarray(ahead * turn + back * turn.conj(), dtype=np.complex128), error


def _of_band(record: Record, band: object) -> tuple[Complex, Values]:
    """Return the displacement in a band of frequencies, and the band."""
    from scipy.signal import butter, sosfiltfilt  # noqa: PLC0415 - takes long to import

    ends = check_array("band", band)
    half = math.pi / record.equal_step()
    if ends.shape != (2,) or not 0.0 <= ends[0] < ends[1] < half:
        raise InputError(
            "band must be two frequencies that increase, from 0 to below half the sampling rate, "
            f"{half:.6g}, got {shown(ends.tolist())}"
        )
    kind, edges = ("lowpass", ends[1] / half) if ends[0] == 0.0 else ("bandpass", ends / half)
    sections = butter(POLES, edges, kind, output="sos")
    check_count("the number of samples", record.z.size, 3 * (2 * len(sections) + 1) + 1)
    x, y = (sosfiltfilt(sections, part) for part in (record.z.real, record.z.imag))
    return x + 1j * y, ends
