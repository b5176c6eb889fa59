"""Order tracking: amplitude and phase of chosen orders over time and speed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_array,
    check_choice,
    check_count,
    check_nonnegative,
    check_positive,
    check_vector,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.whirl import forward_and_backward, steps_of_turning, whirl_over_spin
from rotor_ida.schema import Column
from rotor_ida.signals.record import Record, record_of
from rotor_ida.signals.windows import (
    MOST_OVERLAP,
    STEADY,
    Orders,
    Windows,
    fit_orders,
    scatter_between,
    windows_of,
)

# Integer orders up to this, and up to the highest requested one, are fitted too, so that they do
# not affect the others.
BESIDE = 3
LARGEST_ORDER = 1000.0
# Orders closer than this would need windows of too many revolutions.
CLOSEST = 1e-3
# Tolerance for rounding when windows must separate orders.
SLACK = 1e-9
# Displacements must turn by less than this between samples on average: a third of a turn. The
# phase of noise alone turns by a quarter.
MOST_TURNING = 2.0 * math.pi / 3.0
# Angles of the probes of a run [degree].
AXES = (0.0, 90.0)
# What one order of signals may be of: a whirl, or the reading of a probe.
SENSES = ("forward", "backward", "x", "y")
# Revolutions by which windows tell orders apart, from the most, and the degrees of polynomials by
# which the amplitudes of the orders asked for, and of others, change in a window then.
CHANGES = ((4.0, 3, 1), (2.0, 1, 0), (0.0, 0, 0))
# Scatter between windows up to this times the error by the residual may be due to chance.
CHANCE = 1.3
# The lag of a measured amplitude below this number of its standard errors is that of noise, and not
# drawn.
SEEN = 2.0


def orders(
    signals: xr.Dataset,
    orders: npt.ArrayLike = (1,),
    *,
    revolutions: int | None = None,
    overlap: float = 0.0,
) -> xr.Dataset:
    """Track orders of the speed: amplitudes and phases of forward and backward whirl.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run.
    orders : array_like, shape (k,)
        Multiples of the speed [dimensionless], above zero.
    revolutions : int, optional
        Length of the windows [dimensionless]. By default the shortest that separate the orders: one
        revolution for integer orders, two for halves.
    overlap : float
        Fraction by which windows overlap [dimensionless], from 0 to 0.95: more points in a short
        run-up.

    Returns
    -------
    Dataset
        On (``window``, ``order``): ``forward_whirl_amplitude``, ``backward_whirl_amplitude``,
        ``forward_phase_lag`` and ``backward_phase_lag`` [rad], from -pi to pi;
        ``forward_amplitude_error`` and ``backward_amplitude_error``, standard errors. On
        ``window``: ``offset_x`` and ``offset_y``, the mean position; ``window_residual``, the
        root mean square of the residual; coordinates ``t`` and ``speed``. What each probe reads, on
        ``probe_angle``, its angle from the x axis [degree]: ``probe_peak_to_peak`` and
        ``probe_phase_lag`` [rad], from 0 to 2 pi, of each order, ``direct_peak_to_peak`` of the
        whole reading in each window; ``probe_error``, the standard error of the first.

    Raises
    ------
    InputError
        If the angle is not known, there is no complete window, the windows do not separate the
        orders, or the sampling is too slow for them.

    Notes
    -----
    In each window of whole revolutions ``sum(c_n exp(i n theta))`` is fitted to ``z = x + i y`` by
    least squares: over the requested orders, forward and backward, the mean, and integer orders up
    to 3 and up to the highest requested one. ``forward_phase_lag`` is that of
    `synchronous_response`: ``c_1 = A exp(-i lag)`` with theta the angle of the unbalance. Both lags
    are delays of a whirl at the x axis: ``exp(i (n theta - lag))`` forward and
    ``exp(-i (n theta - lag))`` backward. Measured angles count from the keyphasor mark instead. If
    the speed changes, amplitudes are means over the window, and their change within it is fitted
    too: a cubic in windows of four or more revolutions, a straight line in two or three, and in one
    the line between its neighbours. A probe at the angle a reads half its peak to peak times
    ``cos(n theta - lag)``: its lag is the angle from the mark to the next positive peak, that is
    displacement towards the probe, as for balancing and in API 670.

    Standard errors are those by the residual as white noise, equal in all directions, or the
    scatter of the amplitude between windows where that is larger by more than chance: so they
    contain what leaks from a line that is no order, such as oil whirl. The scatter is taken about
    the mean of up to 128 windows (255 at the end of a record) of equal speed, to 0.2 %, so a true
    change of the amplitude, as in a transient, counts as an error too. Where the speed changes, it
    is taken about a curve with up to two resonances, the quotient of two parabolas, over ten
    windows or more, within which the speed changes by at most 4 % (a curve of fewer terms with
    fewer windows). One window has no scatter. A line closer to the order than about ``0.5/N``
    orders for N revolutions of equal speed, or ``2.5/N`` where the speed changes, cannot be seen.
    The error of a lag is the error of the amplitude over the amplitude. The residual is by degrees
    of freedom: for noise of variance s**2 in x and in y it is ``sqrt(2) s``. The speed is that of
    the straight line through the angles of a window, at the mean of its times.

    References
    ----------
    C. W. Lee, "Vibration Analysis of Rotors", Kluwer, 1993: forward and backward components.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate, synchronous_response
    >>> rotor = Rotor(omega=1.2, zeta=0.5, delta0=0.5)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=400.0, samples=8001)
    >>> found = orders(run).isel(window=-1, order=0)
    >>> exact = synchronous_response(omega=1.2, zeta=0.5, delta0=0.5).isel(branch=0).squeeze()
    >>> abs(found.forward_whirl_amplitude - exact.amplitude).item() < 1e-6
    True
    >>> abs(found.forward_phase_lag - exact.phase_lag).item() < 1e-6
    True
    """
    asked = check_orders(orders)
    part = check_nonnegative("overlap", overlap, MOST_OVERLAP)
    record = record_of(signals)
    length = revolutions_for(asked, revolutions)
    windows = windows_of(record, length, part)
    fitted = fit(record, windows, asked, part)
    k, offset = asked.size, fitted.amplitudes[:, -1] + record.mean
    ahead, back = fitted.amplitudes[:, :k], fitted.amplitudes[:, k : 2 * k]
    variables: dict[str, Column] = {
        "forward_whirl_amplitude": (("window", "order"), np.abs(ahead)),
        "forward_phase_lag": (("window", "order"), np.angle(ahead.conj())),
        "backward_whirl_amplitude": (("window", "order"), np.abs(back)),
        "backward_phase_lag": (("window", "order"), np.angle(back)),
        "forward_amplitude_error": (("window", "order"), fitted.errors[:, :k]),
        "backward_amplitude_error": (("window", "order"), fitted.errors[:, k : 2 * k]),
        "offset_x": ("window", offset.real),
        "offset_y": ("window", offset.imag),
        "window_residual": ("window", fitted.residual),
    }
    angles = check_array("probe_angles", record.attributes.get("probe_angles", AXES))
    towards = np.exp(-1j * np.radians(angles))
    seen = ahead[..., np.newaxis] * towards + (back[..., np.newaxis] * towards).conj()
    lags = np.angle(seen.conj()) % (2.0 * math.pi)
    error = np.hypot(fitted.errors[:, :k], fitted.errors[:, k : 2 * k])
    readings = (record.z[windows.samples, np.newaxis] * towards).real
    starts = windows.edges[:-1]
    highest, lowest = (each.reduceat(readings, starts) for each in (np.maximum, np.minimum))
    variables |= {
        "probe_peak_to_peak": (("window", "order", "probe_angle"), 2.0 * np.abs(seen)),
        "probe_phase_lag": (("window", "order", "probe_angle"), lags),
        "probe_error": (("window", "order"), 2.0 * error),
        "direct_peak_to_peak": (("window", "probe_angle"), highest - lowest),
    }
    return record.dataset(
        "Orders of the speed",
        variables,
        {
            **window_coordinates(windows),
            "order": ("order", asked),
            "probe_angle": ("probe_angle", angles),
        },
        {"window_revolutions": length, "window_overlap": part},
        kind="orders",
    )


class OneOrder(NamedTuple):
    """One order of a whirl, zero to peak, or of a probe, peak to peak, over the windows.

    The amplitude and its standard error are in the unit of the signals, the lag in radians.
    """

    amplitude: Values
    lag: Values
    error: Values


def one_order(tracks: xr.Dataset, order: float, sense: str) -> OneOrder:
    """Return one order of the result of `orders`: of a whirl or of the reading of a probe."""
    check_choice("sense", sense, SENSES)
    wanted, known = check_positive("order", order), tracks["order"].values
    place = int(np.abs(known - wanted).argmin())
    if abs(known[place] - wanted) > SLACK * wanted:
        raise InputError(f"signals must have the order {wanted:g}, got {known.tolist()}")
    one = tracks.isel(order=place)
    names = f"{sense}_whirl_amplitude", f"{sense}_phase_lag", f"{sense}_amplitude_error"
    if sense in ("x", "y"):
        if "probe_angle" not in one.dims:
            raise InputError("sense must be forward or backward for orders without probes")
        one = one.isel(probe_angle=("x", "y").index(sense))
        names = "probe_peak_to_peak", "probe_phase_lag", "probe_error"
    return OneOrder(*(one[name].values for name in names))


def centre_line(signals: xr.Dataset, *, revolutions: int = 1, overlap: float = 0.0) -> xr.Dataset:
    """Compute the mean position of the shaft (the DC gap of the probes) over the speed.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run.
    revolutions : int
        Length of the windows over which the mean is taken [dimensionless].
    overlap : float
        Fraction by which windows overlap [dimensionless], from 0 to 0.95.

    Returns
    -------
    Dataset
        On ``window``: ``offset_x`` and ``offset_y``, coordinates ``t`` and ``speed``.

    Raises
    ------
    InputError
        If the angle is not known, or there is no complete window.

    Notes
    -----
    As in `orders`, the mean is fitted together with the first orders, so it does not depend on the
    number of samples in a window. A steady component at a fraction of the speed does move it: for
    a half, choose an even number of ``revolutions``, or take ``offset_x`` and ``offset_y`` of
    ``orders(signals, [0.5, 1])``.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.2, zeta=0.5, delta0=0.5, load=0.1)
    >>> run = simulate(rotor, start=(0, -0.7, 0, 0), duration=200.0, samples=2001)
    >>> centre_line(run).offset_y[-1].item() < 0.0
    True
    """
    length = check_count("revolutions", revolutions)
    found = orders(signals, 1.0, revolutions=length, overlap=overlap)
    held = found[["offset_x", "offset_y"]]
    return held.assign_attrs(title="Mean position of the shaft", result_kind="centre_line")


def whirl_ratio(signals: xr.Dataset, *, revolutions: int = 1, overlap: float = 0.0) -> xr.Dataset:
    """Compute the whirl speed over the spin speed, and the whirl direction, over time.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with more than two samples in each
        turn of the whirl.
    revolutions : int
        Length of the windows over which the whirl is counted [dimensionless].
    overlap : float
        Fraction by which windows overlap [dimensionless], from 0 to 0.95.

    Returns
    -------
    Dataset
        On ``window``: ``whirl_over_spin``, negative for backward whirl, ``whirl_speed`` and
        ``whirl_sense``; coordinates ``t`` and ``speed``.

    Raises
    ------
    InputError
        If the angle is not known, there is no complete window, or the whirl is too fast for the
        sampling.

    Notes
    -----
    The ratio is the angle by which z turns about its mean in a window over that of the rotor: 1
    for a synchronous whirl, a half for oil whirl, negative for dry whip. The largest of several
    whirls counts. In a vibration along a line the direction is ``none`` and the ratio 0: there the
    total amplitudes of all forward and of all backward lines, each a root sum of squares, differ
    by less than a twentieth of their sum. Limit cycles and touchdown reports have the same
    ``whirl_over_spin`` and ``whirl_sense``.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0),
    ...                duration=200.0, samples=2001)
    >>> whirl_ratio(run).whirl_over_spin[-1].round(6).item()
    1.0
    """
    length = check_count("revolutions", revolutions)
    part = check_nonnegative("overlap", overlap, MOST_OVERLAP)
    record = record_of(signals)
    windows = windows_of(record, length, part)
    turned, angle = _turning(record, windows)
    ahead, back = (_sizes(part, windows) for part in forward_and_backward(record.z))
    ratio, sense = whirl_over_spin(turned, angle, ahead, back)
    columns: dict[str, Column] = {
        "whirl_over_spin": ("window", ratio),
        "whirl_speed": ("window", ratio * windows.speeds),
        "whirl_sense": ("window", sense),
    }
    told = {"window_revolutions": length, "window_overlap": part}
    return record.dataset(
        "Whirl against spin", columns, window_coordinates(windows), told, kind="whirl_over_spin"
    )


def _turning(record: Record, windows: Windows) -> tuple[Values, Values]:
    """Return the angles by which displacements and the rotor turn in each window.

    Displacements turn about their mean, up to the first sample after the window if there is one.
    """
    offset = fit(record, windows, np.array([1.0])).amplitudes[:, -1]
    steps = np.append(steps_of_turning(record.z[windows.samples] - windows.spread(offset)), 0.0)
    places = np.arange(record.z.size)[windows.samples]
    first, last = places[windows.edges[:-1]], places[windows.edges[1:] - 1]
    behind = np.minimum(last + 1, record.z.size - 1)
    steps[windows.edges[1:] - 1] = np.angle(
        (record.z[behind] - offset) * (record.z[last] - offset).conj()
    )
    _check_turning(steps, windows)
    angles = record.known_angles()
    return np.add.reduceat(steps, windows.edges[:-1]), angles[behind] - angles[first]


def _check_turning(steps: Values, windows: Windows) -> None:
    """Refuse displacements that turn too far from sample to sample to know the direction."""
    counts = np.diff(windows.edges)
    means = np.add.reduceat(np.abs(steps), windows.edges[:-1]) / counts
    worst = int(np.argmax(means))
    if means[worst] > MOST_TURNING:
        held = counts[worst] / windows.revolutions
        raise InputError(
            "signals must have more than 3 samples in each turn of the whirl, got "
            f"{2.0 * math.pi / means[worst]:.3g} at t {windows.times[worst]:.6g}: "
            f"{math.ceil(4.0 * held)} samples per revolution are enough"
        )


def _sizes(part: npt.NDArray[np.complex128], windows: Windows) -> Values:
    """Return the root mean square, about its mean, of a part of the displacements by window."""
    within, starts = part[windows.samples], windows.edges[:-1]
    counts = np.diff(windows.edges)
    mean = np.add.reduceat(within, starts) / counts
    squares = np.add.reduceat(np.abs(within - windows.spread(mean)) ** 2, starts)
    return np.asarray(np.sqrt(squares / counts), dtype=np.float64)


def fit(record: Record, windows: Windows, asked: Values, overlap: float = 0.0) -> Orders:
    """Return the amplitudes in windows of orders forward, then backward, then of order 0."""
    counts = np.diff(windows.edges)
    fewest, length = int(counts.argmin()), windows.revolutions
    rate = (counts[fewest] - 1) / length  # an edge may have taken one sample from its neighbour
    if rate <= 2.0 * asked.max() or counts[fewest] < 2 * asked.size + 1:
        raise InputError(
            f"signals must have more than {2.0 * asked.max() + 1.0 / length:g} samples a "
            f"revolution for order {asked.max():g}, got {counts[fewest] / length:.3g} at t "
            f"{windows.times[fewest]:.6g}"
        )
    beside = np.arange(1.0, min(max(BESIDE, asked.max()), (rate - 1.0) / 2.0) + SLACK)
    beside = beside[[not np.isclose(asked, each, atol=SLACK).any() for each in beside]]
    every = _changing(record, windows, np.concatenate([asked, -asked, beside, -beside, [0.0]]),
                      2 * asked.size, overlap)  # fmt: skip
    kept = [*range(2 * asked.size), -1]
    amplitudes, errors = every.amplitudes[:, kept], every.errors[:, kept]
    scatter = scatter_between(amplitudes, windows, overlap)
    # the scatter counts where it exceeds the residual's estimate by more than chance
    usual = np.sqrt(np.mean(errors**2, axis=0))
    errors = np.where(scatter > CHANCE * usual, np.maximum(scatter, errors), errors)
    return Orders(amplitudes, errors, every.residual)


def _changing(
    record: Record, windows: Windows, signed: Values, asked: int, overlap: float
) -> Orders:
    """Return the mean amplitudes of orders in windows in which they change with the speed.

    In windows of several revolutions the change is fitted too: cubic or linear for the orders asked
    for. In one revolution that would amplify the noise, so the change is that between neighbouring
    windows, if it lowers the residual.
    """
    constant = fit_orders(record, windows, signed)
    speeds = windows.speeds
    if np.ptp(speeds) <= STEADY * abs(speeds[0]):
        return constant
    # revolutions by which a window can tell neighbouring orders apart
    apart = windows.revolutions * float(np.diff(np.sort(signed)).min()) + SLACK
    ahead, beside = next(each for least, *each in CHANGES if apart >= least)
    degrees = np.full(signed.size, beside, dtype=np.intp)
    degrees[:asked] = ahead
    fewest = int(np.diff(windows.edges).min())
    if ahead and fewest > 2 * int((degrees + 1).sum()):
        return fit_orders(record, windows, signed, degrees)
    found = constant
    for _ in range(2):  # the change of one order distorts all others, and so their changes
        slopes = np.gradient(found.amplitudes, 2.0 * (1.0 - overlap), axis=0)
        found = fit_orders(record, windows, signed, slopes=slopes)
    better = found.residual < constant.residual
    return Orders(*(
        np.where(better if new.ndim == 1 else better[:, np.newaxis], new, old)
        for new, old in zip(
            (found.amplitudes, found.errors, found.residual),
            (constant.amplitudes, constant.errors, constant.residual), strict=True,
        )
    ))  # fmt: skip


def window_coordinates(windows: Windows) -> dict[str, Column]:
    """Return the numbers, times and speeds of windows."""
    return {
        "window": ("window", np.arange(windows.times.size)),
        "t": ("window", windows.times),
        "speed": ("window", windows.speeds),
    }


def check_orders(orders: npt.ArrayLike) -> Values:
    """Return the orders to track, checked."""
    asked = check_vector("orders", orders, largest=LARGEST_ORDER)
    if (asked <= 0.0).any():
        raise InputError(f"orders must be positive, got {float(asked[asked <= 0.0][0])!r}")
    if np.unique(asked).size < asked.size:
        raise InputError(f"orders must differ from each other, got {shown(asked.tolist())}")
    return asked


def revolutions_for(asked: Values, revolutions: int | None) -> int:
    """Return the number of revolutions in a window, which must separate the orders."""
    whole = np.arange(0.0, max(BESIDE, math.floor(asked.max())) + 1.0)
    near = np.diff(np.sort(np.concatenate([asked, whole])))
    # a requested integer order occurs twice there
    apart = near[near > SLACK].min()
    if (
        apart < CLOSEST
        or np.diff(np.sort(asked)).min(initial=1.0) < CLOSEST
        or asked.min() < CLOSEST
    ):
        raise InputError(
            f"orders must be at least {CLOSEST:g} from each other, from 0 and from other integer "
            f"orders, got {shown(asked.tolist())}"
        )
    # those forward and backward are 2 n apart, at least as far as n from 0
    needed = max(1, math.ceil(1.0 / float(apart) - SLACK / float(apart)))
    if revolutions is None:
        return needed
    length = check_count("revolutions", revolutions)
    if length < needed:
        raise InputError(
            f"revolutions must be at least {needed} to separate the orders from each other and "
            f"from integer ones, got {length}"
        )
    return length
