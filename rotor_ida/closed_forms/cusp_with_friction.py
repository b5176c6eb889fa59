"""The cusp with friction: the largest damping on the locus of folds, as in `fold_locus`.

With g, W, a and b as for `fold_locus`, ``s = sqrt(1 - a**2) = sin(theta)`` and friction mu
a whirl that slips forwards obeys ``g = q b`` and ``2 zeta A omega = q s - mu f``. The condition of
a fold, D = 0, loses speed and damping again and becomes

    (a - mu s) b = g/W,    a + b = A.                                                (locus)

With ``t = tan((pi - theta)/2)`` it is a quartic in t for each ``u = sqrt(A - delta0)``. The damping
along it is ``zeta = (q s - mu f)/(2 A sqrt(q))`` with ``q = g/b``, where this is not negative. With
strong friction it is negative everywhere, and there is no fold. The folds themselves are roots of
`rotor_ida.closed_forms.curve_polynomials`.

The largest damping is sought at 8000 values of u in a constant ratio of 1.002 to 1.01, and refined
by Newton's method. It is not proven that no higher summit lies between two of them:
``tests/closed_forms/test_folds.py`` checks that there are folds just below the cusp, and none just
above.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.fold_locus import NO_CUSP, Cusp
from rotor_ida.closed_forms.restoring_law import RestoringLaw

_NODES = 8000
# Smallest value, as 4 zeta**2, of the largest damping that is sought.
_LEAST = 1e-8
_STEP = 1e-7
# The damping at an undamped end of the locus is 0 to the root of rounding.
_ROUNDING = 1e-7


def friction_locus(u: Values, law: RestoringLaw) -> tuple[Values, Values]:
    """Return phase lags and damping ratios of the folds at given u, shape (n, 4); NaN if fewer.

    Examples
    --------
    >>> lag, zeta = friction_locus(np.array([1.228255]), RestoringLaw(0.5, friction=0.02))
    >>> round(float(np.nanmax(zeta)), 4)
    0.07
    """
    A, g, W = law.forces(u)
    mu, level = law.friction, g / W
    quartic = (
        A - 1.0 - level,
        -2.0 * mu * (A - 1.0),
        2.0 - 2.0 * level,
        -2.0 * mu * (A + 1.0),
        -(A + 1.0) - level,
    )
    companion = np.zeros((u.size, 4, 4))
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[:, :, 3] = -np.stack(quartic[:4], axis=-1) / quartic[4][:, None]
    roots = np.linalg.eigvals(companion)
    real = (np.abs(roots.imag) < 1e-7) & (roots.real > 0.0) & (roots.real < 1.0)
    lag = math.pi - 2.0 * np.arctan(np.where(real, roots.real, np.nan))
    zeta, _ = _on_locus(u[:, None], lag, law)
    return lag, np.where(zeta >= 0.0, zeta, np.nan)


def friction_cusp(law: RestoringLaw) -> Cusp:
    """Return damping ratio, speed and amplitude where the last two folds merge; NaN if none."""
    highest = 1.0 + math.sqrt(law.delta0) + math.cbrt(1.0 / _LEAST) + math.cbrt(law.shaft_stiffness)
    highest = highest + ((1.0 + law.shaft_stiffness) / _LEAST) ** 0.25
    nodes = np.geomspace(1e-6 * min(1.0, law.delta0), highest, _NODES)
    if not law.hertz:  # the locus of a linear contact may begin at the stator itself
        nodes = np.concatenate([[0.0], nodes])
    lag, zeta = friction_locus(nodes, law)
    if not (zeta > _ROUNDING).any():
        return NO_CUSP
    row, column = np.unravel_index(int(np.nanargmax(zeta)), zeta.shape)
    place = np.array([nodes[row], lag[row, column]])
    best = float(zeta[row, column])
    if row > 0:
        refined = _summit(place, law)
        damping, misses = _on_locus(refined[0], refined[1], law)
        if abs(misses) < 1e-12 and best * (1.0 - 1e-9) <= damping <= best * 1.05:
            place, best = refined, float(damping)
    speed = math.sqrt(float(_speed_squared(place[0], place[1], law)))
    return Cusp(best, speed, float(law.delta0 + place[0] ** 2))


def _on_locus(
    u: npt.ArrayLike, lag: npt.ArrayLike, law: RestoringLaw
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return the damping, and the deviation of a place from the locus."""
    root, theta = np.asarray(u), np.asarray(lag)
    A, g, W = law.forces(root)
    sine, b = np.sin(theta), A + np.cos(theta)
    friction = law.friction * (g - law.shaft_stiffness * A)
    with np.errstate(invalid="ignore", divide="ignore"):
        q = _speed_squared(root, theta, law)
        zeta = (q * sine - friction) / (2.0 * A * np.sqrt(q))
        return zeta, (-np.cos(theta) - law.friction * sine) * b - g / W


def _speed_squared(u: npt.ArrayLike, lag: npt.ArrayLike, law: RestoringLaw) -> npt.NDArray[Any]:
    """Return ``q = g/b = W (a - mu s)`` on the locus, in the form without cancellation."""
    root, theta = np.asarray(u), np.asarray(lag)
    A, g, W = law.forces(root)
    b, beside = A + np.cos(theta), -np.cos(theta) - law.friction * np.sin(theta)
    safe = np.where(b.real > beside.real, b, 1.0)
    return np.where(b.real > beside.real, g / safe, W * beside)


def _summit(place: Values, law: RestoringLaw) -> Values:
    """Return the place on the locus where the damping is stationary, by Newton's method."""

    def conditions(at: Values) -> Values:
        # derivatives by complex steps
        by_u = _on_locus(at[0] + 1e-30j, at[1], law)
        by_lag = _on_locus(at[0], at[1] + 1e-30j, law)
        cross = by_u[0].imag * by_lag[1].imag - by_lag[0].imag * by_u[1].imag
        return np.array([by_u[1].real, cross * 1e60])

    for _ in range(30):
        columns = []
        for k in range(2):
            step = np.zeros(2)
            step[k] = _STEP * max(abs(place[k]), 1e-3)
            columns.append((conditions(place + step) - conditions(place - step)) / (2.0 * step[k]))
        try:
            change = np.linalg.solve(np.stack(columns, axis=1), conditions(place))
        except np.linalg.LinAlgError:
            break
        place = place - change * min(1.0, 0.05 * place[0] / max(abs(change[0]), 1e-300))
        if (np.abs(change) <= 1e-15 * np.abs(place)).all():
            break
    return place
