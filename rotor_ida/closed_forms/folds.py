"""Folds: the speeds at which a synchronous whirl vanishes and the rotor has to jump."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import check_axis, check_points, check_real
from rotor_ida.closed_forms.fold_locus import fold_locus, folds_on_side
from rotor_ida.schema import CONVENTIONS, labelled

Values = npt.NDArray[np.float64]

_SMALLEST_DAMPING, _LARGEST = 1e-20, 1e6


def folds(*, zeta: object, delta0: object) -> xr.Dataset:
    """Return every fold of the contacting whirls.

    Parameters
    ----------
    zeta : float or sequence of float, shape (m,)
        Damping ratios [1].
    delta0 : float or sequence of float, shape (k,)
        Clearances [1].

    Returns
    -------
    Dataset
        ``fold_omega`` and ``fold_amplitude`` [1] on the dimensions (zeta, delta0, fold), in
        order of speed; NaN where there are fewer folds than the dimension is long.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or is above 1e6, or is
        a damping ratio or clearance above zero and below 1e-20.

    Notes
    -----
    At a fold two whirls merge: the determinant D of `stability_determinant` is zero on the
    curve. The phase lag there exceeds a quarter turn, and speed and damping can be eliminated
    (see `fold_locus`), which leaves crossings of one function. There are up to four folds for
    ``0 < delta0 < 1``, two of them near first touch; for ``delta0 >= 1`` the contacting branch
    is an isola between two folds; large damping leaves none. Without damping the branches
    never close at large amplitude, and only one fold is left, at ``A = 3 - 2 delta0`` if
    ``delta0 < 1``.

    The point where a branch first touches the ring, at A = delta0, is not a fold.

    References
    ----------
    Fig. 6 of the paper, Mechanika 25(6), 2019, which shows two of them.

    Examples
    --------
    >>> found = folds(zeta=[0.07, 0.2], delta0=0.0)
    >>> found.fold_omega.sel(zeta=0.07, delta0=0.0).values.round(6)
    array([1.597821, 1.932754])
    >>> int(found.fold_omega.sel(zeta=0.2, delta0=0.0).count())
    0
    """
    dampings, clearances = _checked("zeta", zeta), _checked("delta0", delta0)
    check_points(dampings, clearances)
    columns = [_folds_of(dampings, float(clearance)) for clearance in clearances]
    most = max(1, *(column.shape[1] for column in columns))
    table = np.full((dampings.size, clearances.size, most, 2), np.nan)
    for number, column in enumerate(columns):
        table[:, number, : column.shape[1]] = column

    dims = ("zeta", "delta0", "fold")
    coords = {
        "zeta": labelled("zeta", "zeta", dampings),
        "delta0": labelled("delta0", "delta0", clearances),
        "fold": labelled("fold", "fold", np.arange(most)),
    }
    variables = {
        "fold_omega": labelled("fold_omega", dims, table[..., 0]),
        "fold_amplitude": labelled("fold_amplitude", dims, table[..., 1]),
    }
    attributes = {
        "Conventions": CONVENTIONS,
        "title": "Folds of the synchronous whirls of a rotor with Hertz contact and clearance",
        "source": "rotor_ida closed forms: crossings of the damping along the locus of folds",
        "references": "Mechanika 25(6), 2019, Fig. 6",
    }
    return xr.Dataset(variables, coords, attributes)


def cusp_zeta(delta0: float) -> float:
    """Return the damping ratio above which no fold, and so no jump, is left.

    Parameters
    ----------
    delta0 : float
        Clearance [1].

    Returns
    -------
    float
        Largest damping ratio with a fold [1].

    Raises
    ------
    InputError
        If `delta0` is not a finite real number, is negative or above 1e6, or lies between 0
        and 1e-20.

    Notes
    -----
    The maximum of the damping along the locus of `fold_locus`, where two folds merge.

    References
    ----------
    The condition D = 0 of `stability_determinant` on the response curve.

    Examples
    --------
    >>> round(cusp_zeta(0.0), 8)
    0.15604517
    """
    clearance = _checked("delta0", check_real("delta0", delta0)).item()
    sides = fold_locus(clearance, 1e-3)
    largest = max(
        float(np.max(side.damping, initial=0.0, where=side.damping > 0.0)) for side in sides
    )
    return 0.5 * math.sqrt(largest)


def _checked(name: str, values: object) -> Values:
    """Return the axis, refusing magnitudes for which the locus leaves the range of doubles."""
    return check_axis(name, values, smallest=_SMALLEST_DAMPING, largest=_LARGEST)


def _folds_of(zeta: Values, delta0: float) -> Values:
    """Return speed and amplitude of the folds of one clearance, shape (m, most, 2)."""
    found: list[list[tuple[float, float]]] = [[] for _ in zeta]
    damped = np.nonzero(zeta > 0.0)[0]
    if damped.size:
        smallest = 4.0 * float(zeta[damped].min()) ** 2
        for side in fold_locus(delta0, smallest):
            rows, omega, amplitude = folds_on_side(side, zeta[damped])
            for number, *fold in zip(damped[rows], omega, amplitude, strict=True):
                found[number].append((float(fold[0]), float(fold[1])))
    if delta0 < 1.0:
        for number in np.nonzero(zeta == 0.0)[0]:
            found[number].append(_undamped(delta0))
    table = np.full((zeta.size, max(len(each) for each in found), 2), np.nan)
    for number, each in enumerate(found):
        table[number, : len(each)] = np.reshape(sorted(each), (-1, 2))
    return table


def _undamped(delta0: float) -> tuple[float, float]:
    """Return the one fold at zeta = 0, where ``u**3 = q (A - 1)`` has a double root."""
    u = np.sqrt(3.0 * (1.0 - delta0))
    return float(np.sqrt(u**3 / (2.0 * (1.0 - delta0)))), 3.0 - 2.0 * delta0
