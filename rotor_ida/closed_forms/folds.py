"""Folds, at which a synchronous whirl vanishes, the whirls to jump to there, and the cusp.

A list of folds is complete: they are the roots of a polynomial, isolated in exact arithmetic
(`exact_folds` and `_crossings` in `curve_polynomials`). However near two of them are, neither is
missed, and two that coincide are listed once. The cusp is the largest damping that a dense search
along a locus finds: see `cusps`. Folds of rotor systems are those met as the branches of
`rotor_ida.closed_forms.whirls.special_speeds` are followed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import listed
from rotor_ida.closed_forms.curve_polynomials import equations_of, exact_folds
from rotor_ida.closed_forms.cusps import Cusp, cusp_of
from rotor_ida.closed_forms.restoring_law import RestoringLaw, checked_law
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.varied import Varied
from rotor_ida.results.in_si import takes_si
from rotor_ida.schema import STABILITY, labelled, labelled_dataset, spread

# Beyond these values the locus of the cusps leaves the range of doubles.
_RANGE = (1e-20, 1e6)
RANGES = dict.fromkeys(("zeta", "delta0", "shaft_stiffness", "friction"), _RANGE)
# Why points that occur at any speed take none.
ALL_SPEEDS = {"omega": "all speeds are searched"}
# How far beside a fold, relative to its speed, its rounding leaves no doubt about the side.
_BESIDE = 2.0**-50
# Between these clearances the damping of the cusp has its only maximum.
_HUMP = (0.5, 0.8)


@takes_si
def folds(
    rotor: Rotor | DimensionalRotor | None = None, **varied: Unpack[Parameters]
) -> xr.Dataset:
    """Compute the folds of the contacting whirls.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor, at any speed. Without it, ``zeta`` and ``delta0`` must be given.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`, all but
        ``omega``, and combined. Contact damping does not move folds, and the radius of the disc has
        no effect. The load must be 0.

    Returns
    -------
    Dataset
        ``fold_omega`` and ``fold_amplitude`` [dimensionless] on the dimensions (zeta, delta0,
        fold), in order of speed, padded with NaN. Of the optional parameters, an array becomes a
        dimension before ``fold``, and a number other than the default becomes a coordinate.

    Raises
    ------
    InputError
        If a value is not a finite real number that is 0 or from 1e-20 to 1e6; if an exponent is
        neither 1.5 nor 1; if there is contact damping or friction without clearance, or a load.

    Notes
    -----
    At a fold two whirls merge: the determinant D of `stability_determinant` is zero on the
    curve. The phase lag there exceeds a quarter turn. There are up to four folds for
    ``0 < delta0 < 1``, two of them near first touch. For ``delta0 >= 1`` the contacting branch
    is an isola between two folds. With large damping there are none. Without damping the branches
    never close at large amplitude, and there is only one fold, at ``A = 3 - 2 delta0`` if
    ``delta0 < 1``.

    The first touch of a branch, at A = delta0, is not a fold. A linear contact has folds only with
    clearance and damping, or with friction. The list is complete: the folds are roots of a
    polynomial in ``u = sqrt(A - delta0)``, isolated in exact arithmetic (see `curve_polynomials`).

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
    return folds_of(whirls_asked(folds, rotor, varied, RANGES, ALL_SPEEDS))


def folds_of(asked: Varied) -> xr.Dataset:
    """Return the folds of all rotors, as `folds` does."""
    table = fold_table(asked)
    dims, most = (*asked.dims, "fold"), table.shape[-2]
    contact = "contact" if asked.optional else "Hertz contact"
    return labelled_dataset(
        f"Folds of the synchronous whirls of a rotor with {contact} and clearance",
        {"fold_omega": (dims, table[..., 0]), "fold_amplitude": (dims, table[..., 1])},
        asked.coordinates | {"fold": ("fold", np.arange(most))},
        {
            "source": "rotor_ida closed forms: folds of the synchronous whirls",
            "references": "Mechanika 25(6), 2019, Fig. 6",
        },
        kind="folds",
    )


def jumps(rotor: Rotor | None = None, **varied: Unpack[Parameters]) -> xr.Dataset:
    """Compute all folds, each with the amplitude of the whirl to jump to.

    Parameters
    ----------
    rotor, **varied
        As for `folds`.

    Returns
    -------
    Dataset
        On (zeta, delta0, fold), or the dimensions of `folds`: ``fold_omega`` and
        ``fold_amplitude`` [dimensionless] of `folds`, and ``landing_amplitude`` [dimensionless],
        the amplitude of the only other whirl at that speed that is not unstable; NaN if there is
        none or more than one.

    Raises
    ------
    InputError
        As `folds`.

    Notes
    -----
    A rotor that jumps need not land on a synchronous whirl: with clearance it may keep bouncing.
    The result considers only the whirls on the curve.

    References
    ----------
    Fig. 6 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> jumps(zeta=0.07, delta0=0.0).landing_amplitude.values.ravel().round(4)
    array([7.7963, 1.4727])
    """
    found = folds_of(whirls_asked(jumps, rotor, varied, RANGES, ALL_SPEEDS))
    dims, speeds = found["fold_omega"].dims, found["fold_omega"].values
    given = spread(found, ALL_PARAMETERS, found["fold_omega"])
    landing = np.full(speeds.shape, np.nan)
    for place in zip(*np.nonzero(np.isfinite(speeds)), strict=True):
        parameters = {name: each[place] for name, each in given.items()}
        landing[place] = _landing(speeds[place], parameters)
    return found.assign(landing_amplitude=labelled("landing_amplitude", dims, landing))


def _landing(speed: float, parameters: Mapping[str, Any]) -> float:
    """Return the only whirl to last beyond a fold; NaN if there is none or more than one."""
    beside = speed * np.array([1.0 - _BESIDE, 1.0, 1.0 + _BESIDE])
    here = synchronous_response(omega=beside, **parameters)
    amplitude = here["amplitude"].values.reshape(3, -1)
    lasting = np.isin(here["stability"], (STABILITY["stable"], STABILITY["neutral"]))
    # The two whirls that merge in the fold are on one side of it, and the others on both.
    beyond = min(0, 2, key=lambda side: np.isfinite(amplitude[side]).sum())
    others = amplitude[beyond][lasting.reshape(3, -1)[beyond]]
    if others.size != 1:
        return math.nan
    return float(amplitude[1][np.nanargmin(np.abs(amplitude[1] - others[0]))])


def cusp_zeta(
    delta0: float,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = 1.5,
    friction: float = 0.0,
) -> float:
    """Return the damping ratio of the cusp: above it the response curve has no fold.

    Parameters
    ----------
    delta0 : float
        Clearance [dimensionless].
    shaft_stiffness, contact_exponent, friction : float
        As for `Rotor` [dimensionless].

    Returns
    -------
    float
        Largest damping ratio with a fold [dimensionless]; NaN if there are no folds: in a linear
        contact with too little or no clearance, or with strong friction.

    Raises
    ------
    InputError
        If `delta0` or the stiffness is not a finite real number that is 0 or from 1e-20 to 1e6; if
        the exponent is neither 1.5 nor 1; if there is friction without clearance.

    Notes
    -----
    It is the maximum of the damping along the locus of folds, where two of them merge: see
    `rotor_ida.closed_forms.cusps`.

    References
    ----------
    The condition D = 0 of `stability_determinant` on the response curve.

    Examples
    --------
    >>> round(cusp_zeta(0.0), 8)
    0.15604517
    """
    law = checked_law(delta0, shaft_stiffness, contact_exponent, friction, RANGES)
    return cusp_of(law).zeta


def cusp(rotor: Rotor | None = None, **varied: Unpack[Parameters]) -> xr.Dataset:
    """Compute the cusp of each clearance: damping above which the response curve has no fold.

    Parameters
    ----------
    rotor, **varied
        As for `folds`, all but ``zeta``. Without a rotor the default of ``delta0`` is the clearance
        whose cusp has the largest damping: above that no rotor jumps at any clearance. It applies
        to the paper's rotor only.

    Returns
    -------
    Dataset
        On delta0, and other dimensions as for `folds`: ``cusp_zeta``, the supremum of the
        damping ratios at which the response curve has any fold, and ``cusp_omega`` and
        ``cusp_amplitude``, where the last two folds merge [dimensionless]; NaN if there is no fold.

    Raises
    ------
    InputError
        If `folds` does not accept a value, or `delta0` is left out with a shaft, another contact
        law, contact damping or friction.

    Notes
    -----
    See `cusp_zeta` for the method. The number of folds need not fall monotonically as the damping
    grows: at ``delta0 = 0.7237`` it is 4, 2, 4, 2, 0. The cusp is where it finally becomes 0.

    References
    ----------
    Fig. 6 of the paper, Mechanika 25(6), 2019, which shows jumps but not where they cease.

    Examples
    --------
    >>> limit = cusp(delta0=[0.0, 1.0])
    >>> limit.cusp_zeta.values.round(6)
    array([0.156045, 0.183409])
    >>> anywhere = cusp()
    >>> round(anywhere.cusp_zeta.item(), 8), round(anywhere.delta0.item(), 4)
    (0.25100303, 0.7009)
    """
    worst = rotor is None and varied.get("delta0") is None
    if worst:
        varied["delta0"] = _worst_clearance()
    asked = whirls_asked(cusp, rotor, varied, RANGES, {**ALL_SPEEDS, "zeta": "it is sought"})
    if worst and asked.optional:
        raise InputError(f"delta0 must be given with {listed(asked.optional)}, got None")
    laws = RotorColumns.of(asked.columns).laws
    table = np.reshape([cusp_of(law) for law in laws], (*asked.shape, 3))
    return labelled_dataset(
        "Cusps: damping above which the response curve has no fold",
        {f"cusp_{name}": (asked.dims, table[..., k]) for k, name in enumerate(Cusp._fields)},
        asked.coordinates,
        kind="cusps",
    )


def _worst_clearance() -> float:
    """Return the clearance whose cusp has the largest damping, its only maximum."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 - takes long to import

    def falling(delta0: float) -> float:
        return -cusp_of(RestoringLaw(float(delta0))).zeta

    found = minimize_scalar(falling, bounds=_HUMP, method="bounded", options={"xatol": 1e-9})
    return float(found.x)


def fold_table(asked: Varied) -> Values:
    """Return speed and amplitude of every fold, shape as of `folds`: dimensions, fold, 2."""
    found = [exact_folds(each) for each in equations_of(RotorColumns.of(asked.columns))]
    most = max(1, *map(len, found))
    table = np.full((len(found), most, 2), np.nan)
    for row, points in zip(table, found, strict=True):
        row[: len(points)] = np.reshape(points, (-1, 2))
    return table.reshape(*asked.shape, most, 2)
