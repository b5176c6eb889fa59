"""The cusp: the largest damping on the locus of folds.

Let theta be the phase lag, ``g(A) = f(A) + kappa A`` the force of contact and shaft together,
``W = A f' - f``, ``q = omega**2``, ``a = -cos(theta)``, ``b = A - a`` and ``s = sin(theta)``. A
whirl that slips forwards obeys ``g = q b`` and ``2 zeta A omega = q s - mu f``. With these the
condition of a fold, D = 0, loses speed and damping and becomes

    (a - mu s) b = g/W,    a + b = A,                                                (locus)

where the lag is beyond a quarter turn: ``theta = pi/2 + beta`` with ``a = sin(beta)``. With
``w = tan(beta/2)`` it is a quartic in w for each ``u = sqrt(A - delta0)``. The damping along it is
``zeta = (q s - mu f)/(2 A sqrt(q))`` with ``q = g/b``, where this is not negative. With strong
friction it is negative everywhere, and there is no fold.

The shaft cancels in W. For Hertz contact ``W = u (A + 2 delta0)/2``. For a linear contact
``W = delta0``: without clearance and friction such a rotor is linear and has no fold.

The largest damping is sought at 2000 values of u in a constant ratio, and refined by Newton's
method. It is not proven that no higher summit lies between two of them:
``tests/closed_forms/test_folds.py`` checks that there are folds just below the cusp, and none just
above.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.restoring_law import RestoringLaw

_NODES = 2000
# Smallest value, as 4 zeta**2, of the largest damping that is sought.
_LEAST = 1e-8
_STEP = 1e-7
_POWERS = np.array([4.0, 3.0, 2.0, 1.0])[:, None, None]
# The damping at an undamped end of the locus is 0 to the root of rounding.
_ROUNDING = 1e-7


class Cusp(NamedTuple):
    """Damping ratio, speed and amplitude at which the last two folds merge [dimensionless]."""

    zeta: float
    omega: float
    amplitude: float


NO_CUSP = Cusp(math.nan, math.nan, math.nan)


def locus_of_folds(u: Values, law: RestoringLaw) -> tuple[Values, Values]:
    """Return the angles beta and the damping of the folds at given u, shape (n, 4); NaN if fewer.

    Examples
    --------
    >>> _, zeta = locus_of_folds(np.array([1.228255]), RestoringLaw(0.5, friction=0.02))
    >>> round(float(np.nanmax(zeta)), 4)
    0.07
    """
    A, g, W = law.forces(u)
    mu, level = law.friction, g / W
    terms = mu * A - level, 2.0 * (A - mu), -4.0 - 2.0 * level, 2.0 * (A + mu), -mu * A - level
    # of 1/w, as the smallest w must be as accurate as the largest
    companion = np.zeros((u.size, 4, 4))
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[:, :, 3] = -np.stack(terms[:4], axis=-1) / terms[4][:, None]
    roots = np.linalg.eigvals(companion).astype(complex)
    quartic = np.stack(terms[::-1])[:, :, None]
    for _ in range(2):
        value, slope = np.polyval(quartic, roots), np.polyval(quartic[:-1] * _POWERS, roots)
        step = np.divide(value, slope, out=np.zeros_like(roots), where=slope != 0.0)
        roots = roots - np.where(np.abs(step) < 1e-4 * np.abs(roots), step, 0.0)
    real = (np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 1.0)
    beta = 2.0 * np.arctan(np.where(real, 1.0 / np.where(real, roots.real, 1.0), np.nan))
    zeta, _ = _on_locus(u[:, None], beta, law)
    return beta, np.where(zeta >= 0.0, zeta, np.nan)


def cusp_of(law: RestoringLaw) -> Cusp:
    """Return damping ratio, speed and amplitude where the last two folds merge; NaN if none."""
    if not law.hertz and law.delta0 == 0.0:
        return NO_CUSP
    highest = 1.0 + math.sqrt(law.delta0) + math.cbrt(1.0 / _LEAST) + math.cbrt(law.shaft_stiffness)
    highest = highest + ((1.0 + law.shaft_stiffness) / _LEAST) ** 0.25
    # the locus of a linear contact may begin at the stator itself
    lowest = 1e-6 if law.hertz else 1e-9
    nodes = np.geomspace(lowest * min(1.0, law.delta0 or 1.0), highest, _NODES)
    beta, zeta = locus_of_folds(nodes, law)
    if not (zeta > _ROUNDING).any():
        return NO_CUSP
    row, column = np.unravel_index(int(np.nanargmax(zeta)), zeta.shape)
    place = np.array([nodes[row], beta[row, column]])
    best = float(zeta[row, column])
    if row > 0:
        refined = _summit(place, law)
        damping, misses = _on_locus(refined[0], refined[1], law)
        _, g, W = law.forces(refined[0])
        if (
            abs(misses) < 1e-12 * max(1.0, float(g / W))
            and best * (1.0 - 1e-9) <= damping <= best * 1.05
        ):
            place, best = refined, float(damping)
    speed = math.sqrt(float(_speed_squared(place[0], place[1], law)))
    return Cusp(best, speed, float(law.delta0 + place[0] ** 2))


def _on_locus(
    u: npt.ArrayLike, beta: npt.ArrayLike, law: RestoringLaw
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return the damping, and the deviation of a place from the locus."""
    root, angle = np.asarray(u), np.asarray(beta)
    A, g, W = law.forces(root)
    a, s = np.sin(angle), np.cos(angle)
    friction = law.friction * (g - law.shaft_stiffness * A)
    with np.errstate(invalid="ignore", divide="ignore"):
        q = _speed_squared(root, angle, law)
        zeta = (q * s - friction) / (2.0 * A * np.sqrt(q))
        return zeta, (a - law.friction * s) * (A - a) - g / W


def _speed_squared(u: npt.ArrayLike, beta: npt.ArrayLike, law: RestoringLaw) -> npt.NDArray[Any]:
    """Return ``q = g/b = W (a - mu s)`` on the locus without cancellation; NaN where none is."""
    root, angle = np.asarray(u), np.asarray(beta)
    A, g, W = law.forces(root)
    b, beside = A - np.sin(angle), np.sin(angle) - law.friction * np.cos(angle)
    safe = np.where(b.real > beside.real, b, 1.0)
    squared = np.where(b.real > beside.real, g / safe, W * beside)
    return np.where((b.real > 0.0) & (beside.real > 0.0), squared, np.nan)


def _summit(place: Values, law: RestoringLaw) -> Values:
    """Return the place on the locus where the damping is stationary, by Newton's method."""

    def conditions(at: Values) -> Values:
        # derivatives by complex steps
        by_u = _on_locus(at[0] + 1e-30j, at[1], law)
        by_beta = _on_locus(at[0], at[1] + 1e-30j, law)
        cross = by_u[0].imag * by_beta[1].imag - by_beta[0].imag * by_u[1].imag
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
        if not np.isfinite(change).all():  # it left the locus
            break
        place = place - change * min(1.0, 0.05 * place[0] / max(abs(change[0]), 1e-300))
        if (np.abs(change) <= 1e-15 * np.abs(place)).all():
            break
    return place
