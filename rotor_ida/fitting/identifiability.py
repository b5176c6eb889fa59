"""Identifiability of each unknown, in numbers and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import listed
from rotor_ida.units import quantity

# The unknown that is an angle [rad], and may be 0.
ANGLE = "unbalance_angle"
# An unknown is identified if its error is at most this part of its value; an angle, of a radian.
TOLD = 0.5
# Singular values below this part of the largest are rounding.
ROUNDING = 1e-10
# Unknowns belong together if their part of the worst direction, or correlation, is at least this.
SHARE, TOGETHER = 0.25, 0.95
# A probability this small counts as none.
NO_CHANCE = 1e-3


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of the unknowns, from the derivatives at a solution.

    Parameters
    ----------
    covariance : ndarray, shape (k, k)
        Covariance of the unknowns; infinite on the diagonal for those that are not identifiable.
    told : ndarray of bool, shape (k,)
        Whether the standard error of each is at most half of its value.
    words : list of str
        A sentence for each unknown, or for several that are identifiable only together.
    """

    covariance: Values
    told: npt.NDArray[np.bool_]
    words: list[str]


def identify(slopes: Values, scale: Values, names: list[str]) -> Identifiability:
    """Return the identifiability of the first k unknowns from the derivatives of weighed residuals.

    The derivatives have shape (n, k + others). Errors are relative to the scale of each unknown:
    its value, or 1 where that may be 0.

    Notes
    -----
    The covariance is ``inverse(S' S)`` of the derivatives S [1]_. It is computed from those by the
    unknowns relative to their scales, after the part that the others explain is projected out.

    References
    ----------
    .. [1] G. A. F. Seber and C. J. Wild, "Nonlinear Regression", Wiley, 1989, section 2.1.
    """
    count = len(names)
    relative = slopes[:, :count] * scale
    if slopes.shape[1] > count:
        others = slopes[:, count:]
        others = others / np.maximum(np.linalg.norm(others, axis=0), np.finfo(float).tiny)
        relative = relative - others @ np.linalg.lstsq(others, relative)[0]
    sizes = np.linalg.norm(slopes[:, :count] * scale, axis=0)
    _, singular, rows = np.linalg.svd(relative, full_matrices=False)
    largest = max(float(singular[0]), np.finfo(float).tiny)
    kept = singular > ROUNDING * largest
    parts = rows / np.where(kept, singular, math.inf)[:, None]
    covariance = np.einsum("ki,kj->ij", parts, parts)
    free = rows[~kept] if (~kept).any() else np.empty((0, count))
    lost = (np.abs(free) > ROUNDING**0.5).any(axis=0) if free.size else np.zeros(count, dtype=bool)
    errors = np.where(lost, math.inf, np.sqrt(np.diag(covariance)))
    told = errors <= TOLD
    words = _words(names, sizes, errors, rows[::-1], covariance)
    full = covariance * scale * scale[:, None]
    full[np.diag_indices(count)] = np.where(lost, math.inf, np.diag(full))
    return Identifiability(full, told, words)


def _words(
    names: list[str], sizes: Values, errors: Values, directions: Values, covariance: Values
) -> list[str]:
    """Return a sentence for each unknown, or for those that are identifiable only together."""
    words, done = [], set()
    for number, name in enumerate(names):
        if sizes[number] <= ROUNDING * sizes.max(initial=1e-300):
            words.append(f"{name} is not identifiable: it changes nothing in these signals")
            done.add(number)
    for direction in directions:
        members = [
            n for n in np.flatnonzero(np.abs(direction) > SHARE).tolist()
            if n not in done and errors[n] > TOLD
        ]  # fmt: skip
        if not members:
            continue
        first = members[0]
        if len(members) == 1:
            words.append(
                f"{names[first]} is poorly constrained: {_part(names[first], errors[first])}"
            )
        else:
            ways = ", ".join(f"{names[n]} {direction[n] / direction[members[0]]:+.2g}"
                             for n in members)  # fmt: skip
            words.append(
                f"{listed([names[n] for n in members])} are identifiable only together: relative "
                f"changes in proportion ({ways}) leave these signals almost unchanged"
            )
        done.update(members)
    for number, name in enumerate(names):
        if number not in done:
            words.append(f"{name} is known to {_part(name, errors[number])}")
    deviations = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    for i in range(len(names)):
        for j in range(i):
            goes = covariance[i, j] / (deviations[i] * deviations[j])
            if abs(goes) > TOGETHER and not {i, j} & done:
                words.append(f"errors of {names[j]} and {names[i]} are correlated: {goes:+.3f}")
    return words


def _part(name: str, error: float) -> str:
    """Return an error relative to the scale, in words."""
    if not math.isfinite(error):
        return "no error can be stated"
    if name == ANGLE:
        return quantity(error, "radian", 2)
    return f"{100.0 * error:.2g} %" if error < 10.0 else f"{error:.2g} times its value"


def widening(chi_square: float, freedom: int) -> float:
    """Return the factor by which errors exceed those from noise alone.

    If the residuals exceed the noise, the model lacks something and the errors from noise are too
    small. They are scaled so that chi-square equals its degrees of freedom.

    Examples
    --------
    >>> widening(100.0, 100), widening(400.0, 100)
    (1.0, 2.0)
    """
    from scipy.stats import chi2  # noqa: PLC0415 - takes long to import

    if freedom > 0 and chi2.sf(chi_square, freedom) < NO_CHANCE:
        return math.sqrt(chi_square / freedom)
    return 1.0


def left_in_words(chi_square: float, freedom: int, *, stated: bool = True) -> str:
    """Return in words whether the residuals of a fit are noise.

    If they exceed it, that errors are widened, where any are `stated`.

    Examples
    --------
    >>> left_in_words(1.1, 1185)
    'the residuals are smaller than the noise: chi-square 1.1 with 1185 degrees of freedom'
    """
    from scipy.stats import chi2  # noqa: PLC0415 - takes long to import

    told = f"chi-square {chi_square:.4g} with {freedom} degrees of freedom"
    wider = widening(chi_square, freedom)
    if wider > 1.0:
        so = f", so errors are widened {wider:.3g} times" if stated else ""
        return f"the residuals exceed the noise{so}: {told}"
    if freedom > 0 and chi2.cdf(chi_square, freedom) < NO_CHANCE:
        return f"the residuals are smaller than the noise: {told}"
    return f"the residuals are noise: {told}"
