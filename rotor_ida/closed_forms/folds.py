"""Folds: where a synchronous whirl vanishes, what is left to jump to, and the cusp beyond them."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.optimize import minimize_scalar

from rotor_ida.arrays import Values
from rotor_ida.checks import check_axis, check_points, check_real
from rotor_ida.closed_forms.fold_locus import LocusSide, fold_locus, folds_on_side, locus_points
from rotor_ida.closed_forms.fold_locus_further import (
    FurtherSide,
    Ring,
    further_folds,
    further_locus,
    points_on_side,
    undamped_folds,
)
from rotor_ida.closed_forms.fold_locus_rubbing import rub_cusp
from rotor_ida.closed_forms.further_parameters import FurtherAxes, check_law, further_axes
from rotor_ida.closed_forms.rubs import Rub, rub_folds
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.table import check_exponent
from rotor_ida.schema import STABILITY, labelled, labelled_dataset

# At a fold two whirls are one, up to the root of rounding.
_SAME = 1e-5
# More than there are: up to four without a shaft.
_MOST_FOLDS = 12
# Between these clearances the damping of the cusp rises to its one maximum and falls again.
_HUMP = (0.5, 0.8)


def folds(
    *,
    zeta: object,
    delta0: object,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return every fold of the contacting whirls.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios and clearances [1].
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `Rotor`, numbers or axes [1]. Contact damping moves no fold.

    Returns
    -------
    Dataset
        ``fold_omega`` and ``fold_amplitude`` [1] on the dimensions (zeta, delta0, fold), in
        order of speed; NaN where there are fewer folds than the dimension is long. Each of the last
        four parameters that is given as a sequence is a dimension before ``fold``, as a number
        that is not the default a coordinate.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or is above 1e6, or is
        above zero and below 1e-20; if an exponent is neither 1.5 nor 1; if there is contact damping
        or friction without clearance.

    Notes
    -----
    At a fold two whirls merge: the determinant D of `stability_determinant` is zero on the
    curve. The phase lag there exceeds a quarter turn, and speed and damping can be eliminated
    (see `fold_locus`), which leaves crossings of one function. There are up to four folds for
    ``0 < delta0 < 1``, two of them near first touch; for ``delta0 >= 1`` the contacting branch
    is an isola between two folds; large damping leaves none. Without damping the branches
    never close at large amplitude, and only one fold is left, at ``A = 3 - 2 delta0`` if
    ``delta0 < 1``.

    The point where a branch first touches the ring, at A = delta0, is not a fold. With a shaft or a
    linear contact the locus is that of `fold_locus_further`; a linear contact has folds only with
    clearance and damping, or friction. With friction the folds are roots of a polynomial in
    ``u = sqrt(A - delta0)``, isolated in exact arithmetic: see `rubs`.

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
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
        delta0=clearances,
    )
    for name in ("shaft_stiffness", "friction"):
        _checked(name, further.axes[name])
    check_points(dampings, clearances, *further.axes.values())
    if further.default:
        table = fold_table(dampings, clearances)
    else:
        table = _further_table(dampings, clearances, further)
    dims = ("zeta", "delta0", *further.dims, "fold")
    return labelled_dataset(
        "Folds of the synchronous whirls of a rotor with Hertz contact and clearance"
        if further.default
        else "Folds of the synchronous whirls of a rotor with contact and clearance",
        {"fold_omega": (dims, table[..., 0]), "fold_amplitude": (dims, table[..., 1])},
        {
            "zeta": ("zeta", dampings),
            "delta0": ("delta0", clearances),
            **further.coordinates,
            "fold": ("fold", np.arange(table.shape[-2])),
        },
        {
            "source": "rotor_ida closed forms: crossings of the damping along the locus of folds",
            "references": "Mechanika 25(6), 2019, Fig. 6",
        },
        kind="folds",
    )


def jumps(
    *,
    zeta: object,
    delta0: object,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return every fold with the whirl that is left there to jump to.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios and clearances [1].
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `folds`.

    Returns
    -------
    Dataset
        On (zeta, delta0, fold), or the dimensions of `folds`: ``fold_omega`` and
        ``fold_amplitude`` [1] of `folds`, and ``landing_amplitude`` [1], the amplitude of the one
        other whirl at that speed that is not unstable; NaN where there is none, or a choice.

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
    found = folds(
        zeta=zeta,
        delta0=delta0,
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
    )
    dims, speeds = found["fold_omega"].dims, found["fold_omega"].values
    names = [str(name) for name in found.coords if name != "fold"]
    landing = np.full(speeds.shape, np.nan)
    for place in zip(*np.nonzero(np.isfinite(speeds)), strict=True):
        at = dict(zip(dims, place, strict=True))
        parameters = {
            name: found[name].values[at[name]] if name in at else found[name].item()
            for name in names
        }
        here = synchronous_response(omega=speeds[place], **parameters)
        amplitude = here["amplitude"].values.ravel()
        fold = found["fold_amplitude"].values[place]
        lasting = np.isin(here["stability"], (STABILITY["stable"], STABILITY["neutral"]))
        others = amplitude[lasting.ravel() & (np.abs(amplitude - fold) > _SAME * fold)]
        if others.size == 1:
            landing[place] = others[0]
    return found.assign(landing_amplitude=labelled("landing_amplitude", dims, landing))


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
        Clearance [1].
    shaft_stiffness, contact_exponent, friction : float
        As for `Rotor` [1].

    Returns
    -------
    float
        Largest damping ratio with a fold [1]; NaN where none has: in a linear contact without
        clearance, or with too little, or with much friction.

    Raises
    ------
    InputError
        If `delta0` or the stiffness is not a finite real number, is negative or above 1e6, or lies
        between 0 and 1e-20; if the exponent is neither 1.5 nor 1; if there is friction without
        clearance.

    Notes
    -----
    The maximum of the damping along the locus of `fold_locus`, where two folds merge. With friction
    the locus is that of `fold_locus_rubbing`.

    References
    ----------
    The condition D = 0 of `stability_determinant` on the response curve.

    Examples
    --------
    >>> round(cusp_zeta(0.0), 8)
    0.15604517
    """
    clearance = _checked("delta0", check_real("delta0", delta0)).item()
    stiffness = _checked("shaft_stiffness", check_real("shaft_stiffness", shaft_stiffness)).item()
    exponent = check_real("contact_exponent", contact_exponent)
    check_exponent(exponent)
    mu = _checked("friction", check_real("friction", friction))
    check_law(np.array([exponent]), 0.0 * mu, mu, np.array([clearance]))
    if stiffness == 0.0 and exponent == HERTZ_EXPONENT and mu.item() == 0.0:
        return _cusp(clearance)[0]
    return _further_cusp(Ring(clearance, stiffness, exponent == HERTZ_EXPONENT, mu.item()))[0]


def cusp(
    *,
    delta0: object = None,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return the cusp of each clearance: damping above which the response curve has no fold.

    Parameters
    ----------
    delta0 : float or sequence of float, shape (k,), optional
        Clearances [1]. By default the one whose cusp has the largest damping: above that no
        rotor jumps, whatever its clearance; this is known of the paper's rotor alone.
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `folds`.

    Returns
    -------
    Dataset
        On delta0, and further dimensions as `folds` has them: ``cusp_zeta``, the supremum of the
        damping ratios at which the response curve has any fold, and ``cusp_omega`` and
        ``cusp_amplitude``, where the last two folds merge [1]; NaN where there is no fold.

    Raises
    ------
    InputError
        If a value is none that `folds` takes, or `delta0` is left out with a shaft, another contact
        law, contact damping or friction.

    Notes
    -----
    `cusp_zeta` says how it is found. The number of folds need not fall as the damping
    grows: at ``delta0 = 0.7237`` it goes 4, 2, 4, 2, 0. The cusp is where it becomes 0 for good.

    References
    ----------
    Fig. 6 of the paper, Mechanika 25(6), 2019, which shows jumps and does not say where they end.

    Examples
    --------
    >>> limit = cusp(delta0=[0.0, 1.0])
    >>> limit.cusp_zeta.values.round(6)
    array([0.156045, 0.183409])
    >>> anywhere = cusp()
    >>> round(anywhere.cusp_zeta.item(), 8), round(anywhere.delta0.item(), 4)
    (0.25100303, 0.7009)
    """
    clearances = _checked("delta0", _worst_clearance() if delta0 is None else delta0)
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
        delta0=clearances,
    )
    for name in ("shaft_stiffness", "friction"):
        _checked(name, further.axes[name])
    if further.default:
        table = np.array([_cusp(float(clearance)) for clearance in clearances])
    elif delta0 is None:
        raise InputError(f"delta0 must be given with {', '.join(further.coordinates)}, got None")
    else:
        check_points(clearances, *further.axes.values())
        table = _over_rings(_further_cusp, clearances, further)
    names = ("cusp_zeta", "cusp_omega", "cusp_amplitude")
    dims = ("delta0", *further.dims)
    return labelled_dataset(
        "Cusps: damping above which the response curve has no fold",
        {name: (dims, table[..., k]) for k, name in enumerate(names)},
        {"delta0": ("delta0", clearances), **further.coordinates},
        kind="cusps",
    )


def _worst_clearance() -> float:
    """Return the clearance whose cusp has the largest damping, which has one hump over it."""
    found = minimize_scalar(
        lambda delta0: -_cusp(delta0)[0], bounds=_HUMP, method="bounded", options={"xatol": 1e-9}
    )
    return float(found.x)


def _cusp(delta0: float) -> tuple[float, float, float]:
    """Return damping ratio, speed and amplitude where the last two folds merge."""
    best, place, where = -1.0, 0.0, 0
    for locus in fold_locus(delta0, 1e-3):
        damping = np.where(np.isfinite(locus.damping), locus.damping, -1.0)
        largest = int(damping.argmax())
        if damping[largest] > best:
            best, place, where = float(damping[largest]), float(locus.u[largest]), locus.side
    b = float(locus_points(place, delta0, where).b)
    return 0.5 * math.sqrt(best), math.sqrt(place**3 / b), delta0 + place**2


def _further_cusp(ring: Ring) -> tuple[float, float, float]:
    """Return the cusp with a shaft, a linear contact or friction."""
    if ring.friction > 0.0:
        return rub_cusp(ring)
    best, place, where = 0.0, math.nan, 0
    for locus in further_locus(ring, 1e-3):
        damping = np.where(np.isfinite(locus.damping), locus.damping, -1.0)
        largest = int(damping.argmax())
        if damping[largest] > best:
            best, place, where = float(damping[largest]), float(locus.u[largest]), locus.side
    if best == 0.0:
        return math.nan, math.nan, math.nan
    u = np.array([place])
    amplitude, force, _ = ring.forces(u)
    b = points_on_side(u, ring, where).b
    return 0.5 * math.sqrt(best), math.sqrt((force / b).item()), amplitude.item()


def _over_rings(
    of_ring: Callable[[Ring], npt.ArrayLike], delta0: Values, further: FurtherAxes
) -> Values:
    """Return what depends on the ring alone, on (delta0, the dimensions of `further`, ...)."""
    axes = further.axes
    rings = [
        of_ring(Ring(clearance, stiffness, exponent == HERTZ_EXPONENT, friction))
        for clearance in delta0.tolist()
        for stiffness in axes["shaft_stiffness"].tolist()
        for exponent in axes["contact_exponent"].tolist()
        for friction in axes["friction"].tolist()
    ]
    found = np.array(rings)
    found = found.reshape(-1, 1, axes["friction"].size, *found.shape[1:])
    found = np.repeat(found, axes["contact_damping"].size, axis=1)
    return found.reshape(delta0.size, *further.sizes, *found.shape[3:])


def _further_table(zeta: Values, delta0: Values, further: FurtherAxes) -> Values:
    """Return speed and amplitude of every fold, shape (m, k, ..., most, 2)."""
    dampings = tuple(zeta.tolist())

    def of_ring(ring: Ring) -> Values:
        table = np.full((zeta.size, _MOST_FOLDS, 2), np.nan)
        found = _folds_of_ring(dampings, ring)
        table[:, : found.shape[1]] = found
        return table

    table = np.moveaxis(_over_rings(of_ring, delta0, further), -3, 0)
    most = max(1, int(np.isfinite(table[..., 0]).sum(axis=-1).max()))
    return table[..., :most, :]


@lru_cache(maxsize=16)
def _further_locus(ring: Ring, power: int) -> tuple[FurtherSide, ...]:
    return tuple(further_locus(ring, 10.0**power))


@lru_cache(maxsize=16)
def _folds_of_ring(dampings: tuple[float, ...], ring: Ring) -> Values:
    """Return speed and amplitude of the folds with one shaft and contact, shape (m, most, 2)."""
    zeta = np.array(dampings)
    found: list[list[tuple[float, float]]] = [[] for _ in zeta]
    rest = ring.delta0, ring.shaft_stiffness, ring.friction, ring.hertz
    if ring.friction > 0.0:
        return _tabled([list(rub_folds(Rub(each, *rest))) for each in dampings])
    damped = np.nonzero(zeta > 0.0)[0]
    if rest == (1.0, 0.0, 0.0, False):  # there the sides of the locus meet all along
        for one in damped.tolist():
            found[one] += rub_folds(Rub(dampings[one], *rest))
    elif damped.size:
        smallest = math.floor(math.log10(4.0 * float(zeta[damped].min()) ** 2))
        for side in _further_locus(ring, smallest):
            rows, omega, amplitude = further_folds(side, zeta[damped])
            for number, *fold in zip(damped[rows], omega, amplitude, strict=True):
                found[number].append((float(fold[0]), float(fold[1])))
    for number in np.nonzero(zeta == 0.0)[0]:
        found[number] += undamped_folds(ring)
    return _tabled(found)


def _tabled(found: list[list[tuple[float, float]]]) -> Values:
    """Return the folds of each damping in order of speed, NaN behind them, shape (m, most, 2)."""
    table = np.full((len(found), max(len(each) for each in found), 2), np.nan)
    for number, each in enumerate(found):
        table[number, : len(each)] = np.reshape(sorted(each), (-1, 2))
    return table


def _checked(name: str, values: object) -> Values:
    """Return the axis, refusing magnitudes for which the locus leaves the range of doubles."""
    return check_axis(name, values, smallest=1e-20, largest=1e6)


def fold_table(zeta: Values, delta0: Values) -> Values:
    """Return speed and amplitude of every fold, shape (m, k, most, 2), as `folds` labels them."""
    zeta, delta0 = _checked("zeta", zeta), _checked("delta0", delta0)
    dampings = tuple(zeta.tolist())
    columns = [_folds_of(dampings, clearance) for clearance in delta0.tolist()]
    most = max(1, *(column.shape[1] for column in columns))
    table = np.full((zeta.size, delta0.size, most, 2), np.nan)
    for number, column in enumerate(columns):
        table[:, number, : column.shape[1]] = column
    return table


@lru_cache(maxsize=16)
def _locus(delta0: float, power: int) -> tuple[LocusSide, ...]:
    """Return the locus of folds down to a power of ten of the damping: kept for many dampings."""
    return tuple(fold_locus(delta0, 10.0**power))


# The response curve needs them, and so does whoever marks them on it.
@lru_cache(maxsize=16)
def _folds_of(dampings: tuple[float, ...], delta0: float) -> Values:
    """Return speed and amplitude of the folds of one clearance, shape (m, most, 2)."""
    zeta = np.array(dampings)
    found: list[list[tuple[float, float]]] = [[] for _ in zeta]
    damped = np.nonzero(zeta > 0.0)[0]
    if damped.size:
        smallest = math.floor(math.log10(4.0 * float(zeta[damped].min()) ** 2))
        for side in _locus(delta0, smallest):
            rows, omega, amplitude = folds_on_side(side, zeta[damped])
            for number, *fold in zip(damped[rows], omega, amplitude, strict=True):
                found[number].append((float(fold[0]), float(fold[1])))
    if delta0 < 1.0:
        # the one fold at zeta = 0, where u**3 = q (A - 1) has a double root
        u = np.sqrt(3.0 * (1.0 - delta0))
        undamped = (float(np.sqrt(u**3 / (2.0 * (1.0 - delta0)))), 3.0 - 2.0 * delta0)
        for number in np.nonzero(zeta == 0.0)[0]:
            found[number].append(undamped)
    return _tabled(found)
