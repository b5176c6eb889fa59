"""Jumps: where the rotor lands when its whirl vanishes, and the damping that leaves no jump."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.optimize import minimize_scalar

from rotor_ida.checks import check_axis
from rotor_ida.closed_forms.fold_locus import fold_locus, locus_points
from rotor_ida.closed_forms.folds import cusp_zeta, folds
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.schema import CONVENTIONS, STABILITY, labelled

Values = npt.NDArray[np.float64]

# At a fold two whirls are one, up to the root of rounding.
_SAME = 1e-5
# Between these clearances the limit rises to its one maximum and falls again.
_HUMP = (0.5, 0.8)


def jumps(*, zeta: object, delta0: object) -> xr.Dataset:
    """Return every fold with the whirl that is left there to jump to.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios and clearances [1].

    Returns
    -------
    Dataset
        On (zeta, delta0, fold): ``fold_omega`` and ``fold_amplitude`` [1] of `folds`, and
        ``landing_amplitude`` [1], the amplitude of the one other whirl at that speed that is not
        unstable; NaN where there is none, or a choice.

    Raises
    ------
    InputError
        As `folds`.

    Notes
    -----
    A rotor that jumps need not land on a synchronous whirl: with clearance it may go on
    bouncing. What is given is where the curve lets it land.

    References
    ----------
    Fig. 6 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> jumps(zeta=0.07, delta0=0.0).landing_amplitude.values.ravel().round(4)
    array([7.7963, 1.4727])
    """
    found = folds(zeta=zeta, delta0=delta0)
    landing = np.full(found["fold_omega"].shape, np.nan)
    for index in np.ndindex(landing.shape):
        omega = float(found["fold_omega"].values[index])
        if not math.isnan(omega):
            here = synchronous_response(
                omega=omega,
                zeta=float(found["zeta"].values[index[0]]),
                delta0=float(found["delta0"].values[index[1]]),
            )
            amplitude = here["amplitude"].values.ravel()
            fold = float(found["fold_amplitude"].values[index])
            lasting = np.isin(here["stability"], (STABILITY["stable"], STABILITY["neutral"]))
            others = amplitude[lasting.ravel() & (np.abs(amplitude - fold) > _SAME * fold)]
            landing[index] = others[0] if others.size == 1 else math.nan
    dims = found["fold_omega"].dims
    return found.assign(landing_amplitude=labelled("landing_amplitude", dims, landing))


def cusp(*, delta0: object = None) -> xr.Dataset:
    """Return, for each clearance, the damping above which no jump is left.

    Parameters
    ----------
    delta0 : float or sequence of float, shape (k,), optional
        Clearances [1]. By default the one at which the limit is highest: above that limit no
        rotor jumps, whatever its clearance.

    Returns
    -------
    Dataset
        On delta0: ``cusp_zeta``, the supremum of the damping ratios at which the response
        curve has any fold, and ``cusp_omega`` and ``cusp_amplitude``, where the last
        two folds merge [1].

    Raises
    ------
    InputError
        If a clearance is not a finite real number that is zero or positive, is above 1e6, or
        lies between 0 and 1e-20.

    Notes
    -----
    `cusp_zeta` says how it is found. The number of folds need not fall as the damping
    grows: at ``delta0 = 0.7237`` it goes 4, 2, 4, 2, 0. The limit is where it becomes 0 for good.

    References
    ----------
    Fig. 6 of the paper, Mechanika 25(6), 2019, which draws jumps without such a limit.

    Examples
    --------
    >>> limit = cusp(delta0=[0.0, 1.0])
    >>> limit.cusp_zeta.values.round(6)
    array([0.156045, 0.183409])
    >>> anywhere = cusp()
    >>> round(anywhere.cusp_zeta.item(), 8), round(anywhere.delta0.item(), 4)
    (0.25100303, 0.7009)
    """
    clearances = check_axis("delta0", _worst_clearance() if delta0 is None else delta0)
    rows = np.array([_last_fold(float(clearance)) for clearance in clearances])
    names = ("cusp_zeta", "cusp_omega", "cusp_amplitude")
    variables = {
        name: labelled(name, "delta0", column) for name, column in zip(names, rows.T, strict=True)
    }
    coordinates = {"delta0": labelled("delta0", "delta0", clearances)}
    title = "Damping above which the response curve has no jump"
    return xr.Dataset(variables, coordinates, {"Conventions": CONVENTIONS, "title": title})


def _worst_clearance() -> float:
    """Return the clearance at which folds bear the most damping; the limit has one hump."""
    found = minimize_scalar(
        lambda delta0: -cusp_zeta(delta0),
        bounds=_HUMP,
        method="bounded",
        options={"xatol": 1e-9},
    )
    return float(found.x)


def _last_fold(delta0: float) -> tuple[float, float, float]:
    """Return damping ratio, speed and amplitude where the last two folds merge."""
    limit = cusp_zeta(delta0)
    best: tuple[float, float, float] = (-1.0, math.nan, math.nan)
    for side in fold_locus(delta0, 1e-3):
        damping = np.where(np.isfinite(side.damping), side.damping, -1.0)
        place = int(damping.argmax())
        u = float(side.u[place])
        if damping[place] > best[0]:
            b = float(locus_points(u, delta0, side.side).b)
            best = (float(damping[place]), math.sqrt(u**3 / b), delta0 + u * u)
    return limit, best[1], best[2]
