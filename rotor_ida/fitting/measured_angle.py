"""The angle of the rotor as measured: a smooth curve, and its errors."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.fitting.motion import Turning

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

# Pieces of the curve: through samples, the fewest with at most twice the residual of the most. A
# piece has at least this many samples, or pulses.
MOST_PIECES = 64
ENOUGH = 2.0
SAMPLES_A_PIECE, PULSES_A_PIECE = 8, 4
# Largest residual of the angle [rad].
SMOOTH, EXACT = 0.05, 1e-9
# Part of a step by which all pulses together may be early or late: smoothed ones of a run-up are
# late by 0.02 to 0.1.
LATE = 0.1


@dataclass(frozen=True)
class Curve:
    """A quadratic spline through angles.

    Parameters
    ----------
    ends : ndarray, shape (n + 1,)
        Ends of its pieces [s].
    spline : BSpline
        The spline.
    residual : float
        Root mean square of what is left, by degrees of freedom [rad].
    """

    ends: Values
    spline: BSpline
    residual: float

    def criterion(self, error: float, count: int) -> float:
        """Return Schwarz's criterion for this many angles of a known standard error [rad]."""
        terms = self.spline.c.size
        squares = (self.residual / error) ** 2 * max(count - terms, 1)
        return float(squares + terms * math.log(count))

    def turning(self, times: Values) -> Turning:
        """Return the angle from time 0 to the last time."""
        from scipy.interpolate import PPoly  # noqa: PLC0415 - takes long to import

        parts = PPoly.from_spline(self.spline).c[:, 2:-2]
        whole = Turning(self.ends, parts[2], parts[1], 2.0 * parts[0])
        angles, speeds, _ = whole.at(np.append(0.0, self.ends[1:-1]))
        ends = np.concatenate([[0.0], self.ends[1:-1], times[-1:]])
        return Turning(ends, angles, speeds, whole.rates)


def angle_at_samples(times: Values, angles: Values) -> Turning:
    """Return the angle that is measured at each sample, as a smooth curve from time 0."""
    curves = _curves(times, angles, np.ones(times.size), SAMPLES_A_PIECE)
    least = min(each.residual for each in curves)
    curve = next(each for each in curves if each.residual <= ENOUGH * least)
    return _checked(curve, SMOOTH, times)


def angle_by_pulses(pulses: Values, angles: Values, times: Values) -> tuple[Turning, list[Turning]]:
    """Return the angle by the pulses of a keyphasor, as a smooth curve from time 0, and its errors.

    Parameters
    ----------
    pulses, angles : ndarray, shape (n,)
        Times of the pulses [s], and the angle at each [rad].
    times : ndarray, shape (m,)
        Times of the samples, between the pulses [s].

    Returns
    -------
    Turning
        The angle.
    list of Turning
        The same with each of its independent errors, of one standard deviation.

    Notes
    -----
    A sampled pulse lies anywhere in a step of the samples: its standard error is
    ``step/sqrt(12)``. `read_signals` smooths such pulses, which makes them scatter less, but not
    the errors of a curve through many of them. So a pulse has at least this error, and all
    together may be off by a tenth of a step. The number of pieces has the least of Schwarz's
    criterion.

    References
    ----------
    G. Schwarz, "Estimating the Dimension of a Model", Annals of Statistics 6, 1978, equation 2.
    """
    # signals may be a part: one pulse more on each side gives three at least
    first = max(int(np.searchsorted(pulses, times[0], side="right")) - 2, 0)
    used = slice(first, int(np.searchsorted(pulses, times[-1])) + 2)
    pulses, angles = pulses[used], angles[used]
    step = float(np.median(np.diff(times)))
    speeds = np.gradient(angles, pulses)
    mean = float(speeds.mean())
    curves = _curves(pulses, angles, mean / speeds, PULSES_A_PIECE)
    error = max(min(each.residual for each in curves) / mean, step / math.sqrt(12.0))
    curve = min(curves, key=lambda each: each.criterion(error * mean, pulses.size))
    turning = _checked(curve, SMOOTH + step * float(speeds.max()), times)
    design = curve.spline.design_matrix(pulses, curve.spline.t, curve.spline.k).toarray()
    basis, root = np.linalg.qr(design / (error * speeds)[:, None])
    inverse = np.linalg.inv(root)  # its columns are independent errors of the coefficients
    moves = np.column_stack([inverse, inverse @ basis.sum(axis=0) * LATE * step / error])
    return turning, [_moved(curve, each).turning(times) for each in moves.T]


def _curves(times: Values, angles: Values, weights: Values, fewest: int) -> list[Curve]:
    """Return curves with more and more pieces, each with at least the fewest of the times."""
    from scipy.interpolate import make_lsq_spline  # noqa: PLC0415 - takes long to import

    fits: list[Curve] = []
    number, pieces = np.arange(times.size), 1
    while pieces <= min(MOST_PIECES, max(1, times.size // fewest)):
        ends = np.interp(np.linspace(0.0, number[-1], pieces + 1), number, times)
        spline = make_lsq_spline(times, angles, np.pad(ends, 2, mode="edge"), k=2, w=weights)
        squares = float(((weights * (spline(times) - angles)) ** 2).sum())
        free = max(times.size - spline.c.size, 1)
        fits.append(Curve(ends, spline, math.sqrt(squares / free)))
        if fits[-1].residual <= EXACT * max(1.0, abs(float(angles[-1]))):
            break
        pieces *= 2
    return fits


def _checked(curve: Curve, most: float, times: Values) -> Turning:
    """Return the angle; raise `InputError` if it is not smooth, or the rotor does not turn."""
    if curve.residual > most:
        raise InputError(
            f"angle of signals must change smoothly, got a residual of {curve.residual:.3g} rad "
            f"with {curve.ends.size - 1} ramps of the speed: fit a part without sharp corners of "
            "the speed (--times on the command line)"
        )
    turning = curve.turning(times)
    slowest = float(turning.at(turning.ends, "left")[1].min())
    if slowest <= 0.0:
        raise InputError(f"signals must be of a rotor that turns, got a speed of {slowest:.3g}")
    return turning


def _moved(curve: Curve, move: Values) -> Curve:
    """Return a curve whose coefficients are moved."""
    spline = copy(curve.spline)
    spline.c = spline.c + move
    return replace(curve, spline=spline)
