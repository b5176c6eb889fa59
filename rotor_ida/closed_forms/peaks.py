"""The response curve at given amplitude: the backbone, the two flanks, and the peak."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    LARGEST_NUMBER,
    check_axis,
    check_nonnegative,
    check_points,
    check_positive,
)
from rotor_ida.closed_forms.contact_laws import stiffnesses
from rotor_ida.closed_forms.fold_locus_further import Ring, positive_roots
from rotor_ida.closed_forms.further_parameters import check_law, further_axes, law_of
from rotor_ida.closed_forms.rubs import Rub, flanks, rub_tips
from rotor_ida.model.contact import HERTZ_EXPONENT, contact_force, secant_stiffness
from rotor_ida.schema import labelled_dataset

# With less damping the tip lies beyond the range of doubles.
SMALLEST_DAMPING = 1e-20


def backbone(
    amplitude: object,
    delta0: float = 0.0,
    *,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> Values:
    """Return the speed on the backbone: that of a free circular whirl.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [1].
    delta0 : float
        Clearance [1].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [1].

    Returns
    -------
    ndarray, shape (n,)
        ``omega = sqrt(kappa + f(A)/A)`` [1]; inside the clearance ``sqrt(kappa)``, zero without a
        shaft.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive; if the exponent is
        neither 1.5 nor 1.

    References
    ----------
    Eq. (17) of the paper, Mechanika 25(6), 2019, as a speed.

    Examples
    --------
    >>> backbone([1.0, 16.0])
    array([1., 2.])
    >>> backbone([1.0, 16.0], shaft_stiffness=8.0, contact_exponent=1.0)
    array([3., 3.])
    """
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    kappa, exponent, _ = law_of(shaft_stiffness, contact_exponent)
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    _, secant = stiffnesses(A, 0.0 * A + clearance, 0.0 * A + exponent)
    return np.sqrt(secant + kappa)


def speeds_at_amplitude(
    amplitude: object,
    *,
    zeta: float,
    delta0: float,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
    friction: float = 0.0,
) -> Values:
    """Return the two speeds at which a contacting whirl has a given amplitude.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [1].
    zeta, delta0 : float
        Damping ratio and clearance [1].
    shaft_stiffness, contact_exponent, friction : float
        As of `Rotor` [1]; contact damping does not change whirls.

    Returns
    -------
    ndarray, shape (n, 2)
        The slower and the faster speed [1]: the flank below resonance and the one above; NaN
        where the curve has no such point, and inside the clearance.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive; if the exponent is
        neither 1.5 nor 1; if there is friction without clearance, or above zero and below 1e-20.

    Notes
    -----
    With ``q = omega**2`` and ``s = kappa + f(A)/A`` the curve is the quadratic
    ``(A**2 - 1) q**2 + A**2 (4 zeta**2 - 2 s) q + A**2 s**2 = 0``. Unlike the curve at given
    speeds it needs no search, and it has full resolution near the tip, whose amplitude is
    `peak_amplitude`. Below A = 1 only the flank below resonance is left. With friction mu it is a
    quartic in omega, with ``4 mu zeta A f(A) omega + (mu f(A))**2`` added: see `rubs`.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> speeds_at_amplitude([0.5, 2.0], zeta=0.0, delta0=0.0)
    array([[0.48549177,        nan],
           [0.97098354, 1.68179283]])
    """
    m = 4.0 * check_nonnegative("zeta", zeta, LARGEST_NUMBER) ** 2
    A = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    kappa, exponent, _ = law_of(shaft_stiffness, contact_exponent)
    mu = _checked_friction(friction, clearance)
    if mu > 0.0:
        rub = Rub(check_nonnegative("zeta", zeta), clearance, kappa, mu, exponent == HERTZ_EXPONENT)
        return _speeds_of_rub(A, rub)
    touching = secant_stiffness(A, clearance, exponent)
    s = touching + kappa
    inside = _discriminant(A, s, m)
    exists = (touching > 0.0) & (inside >= 0.0) & ((A < 1.0) | (2.0 * s > m))
    slower, faster = speeds_of_stiffness(A, m, s)
    faster = np.where(A > 1.0, faster, np.nan)
    return np.where(exists[:, None], np.stack([slower, faster], axis=1), np.nan)


def _checked_friction(friction: object, delta0: float) -> float:
    """Return the friction, which needs a clearance."""
    mu = _friction_axis(check_nonnegative("friction", friction))
    none = np.zeros(1)
    check_law(none + HERTZ_EXPONENT, none, mu, none + delta0)
    return float(mu[0])


def _friction_axis(friction: object) -> Values:
    return check_axis("friction", friction, smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER)


def _speeds_of_rub(A: Values, rub: Rub) -> Values:
    """Return both speeds with friction; NaN where the curve has none."""
    found = np.full((A.size, 2), np.nan)
    touching = np.nonzero(rub.delta0 < A)[0]
    slower, faster, exists = flanks(A[touching], rub)
    faster[A[touching] <= 1.0] = np.nan
    found[touching] = np.where(exists[:, None], np.stack([slower, faster], axis=1), np.nan)
    return found


def _discriminant(A: Values, s: Values, m: float) -> Values:
    """Return the discriminant of the quadratic in q over ``4 A**4``."""
    # as a product: near the tip the sum would cancel
    rest = np.sqrt(np.maximum((A - 1.0) * (A + 1.0), 0.0))
    lean = np.divide(2.0 * s, A, out=np.zeros_like(A), where=A > 0.0) - m * A
    product = (lean - m * rest) * (lean + m * rest)
    return np.where(A >= 1.0, product, lean**2 + m**2 * (1.0 - A) * (1.0 + A))


def flank_speeds(A: Values, m: float, delta0: float) -> tuple[Values, Values]:
    """Return the slower and the faster speed at amplitudes that the curve has."""
    return speeds_of_stiffness(A, m, secant_stiffness(A, delta0))


def speeds_of_stiffness(A: Values, m: float, s: Values) -> tuple[Values, Values]:
    """Return the same where force over radius is `s`, of ring and shaft together."""
    middle = 2.0 * s - m
    root = np.sqrt(np.maximum(_discriminant(A, s, m), 0.0))
    # the slower speed is 2 s**2/(middle + root); written so that nothing cancels
    total = middle + root
    below_one = 2.0 * (1.0 - A) * (1.0 + A)
    conjugate = np.divide(A * A * (root - middle), below_one, out=np.zeros_like(A), where=A < 1.0)
    direct = np.divide(2.0 * s * s, total, out=np.zeros_like(A), where=total > 0.0)
    slower = np.where(middle > 0.0, direct, conjugate)
    faster = np.divide(A * A * total, -below_one, out=np.full_like(A, np.inf), where=A > 1.0)
    return np.sqrt(slower), np.sqrt(np.maximum(faster, 0.0))


def peak_amplitude(
    *,
    zeta: float,
    delta0: float,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
    friction: float = 0.0,
) -> float:
    """Return the largest amplitude on the response curve of contacting whirls.

    Parameters
    ----------
    zeta, delta0 : float
        Damping ratio, above zero, since without damping and friction the curve has no tip, and
        clearance [1].
    shaft_stiffness, contact_exponent, friction : float
        As of `Rotor` [1].

    Returns
    -------
    float
        Amplitude of the tip [1]; NaN where the damping is so strong that the amplitude stays
        below 1 and only approaches it at high speed.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or `zeta` is zero and
        there is no friction, or there is friction without clearance, or below 1e-20.

    Notes
    -----
    At the tip the two speeds of `speeds_at_amplitude` are one, which is where
    ``h(A) = (A - delta0)**1.5 / (A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``. Beyond the last
    maximum of h, a root of ``3 A**4 - (12 delta0**2 - 1) A**2 - 8 delta0 A + 16 delta0**2``,
    h falls for ever. With friction the discriminant of a quartic vanishes: see `rubs`. Friction
    bounds the amplitude without damping too, by ``sqrt(1 + 1/mu**2)`` without a shaft.

    References
    ----------
    Eqs (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> tip = peak_amplitude(zeta=0.07, delta0=0.0)
    >>> round(tip, 6), speeds_at_amplitude(tip - 1e-9, zeta=0.07, delta0=0.0).round(3).tolist()
    (13.7..., [[1.9..., 1.9...]])
    """
    clearance = check_nonnegative("delta0", delta0, LARGEST_NUMBER)
    kappa, exponent, beyond = law_of(shaft_stiffness, contact_exponent)
    mu = _checked_friction(friction, clearance)
    given = check_nonnegative("zeta", zeta) if mu > 0.0 else check_positive("zeta", zeta)
    damping = check_axis("zeta", given, smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER)
    if mu > 0.0:
        rub = Rub(float(damping[0]), clearance, kappa, mu, exponent == HERTZ_EXPONENT)
        return max((A for A, _ in rub_tips(rub)), default=math.nan)
    if beyond:
        ring = Ring(clearance, kappa, exponent == HERTZ_EXPONENT)
        found = tips_of_ring(float(damping[0]), ring)
    else:
        found = tips(float(damping[0]), clearance)
    return found[-1] if found else math.nan


def tips(zeta: float, delta0: float) -> list[float]:
    """Return the amplitudes above 1 at which the flanks meet, ascending; none without damping."""
    if zeta == 0.0:
        return []

    def excess(A: float) -> float:
        decay = float(A * A * (A + np.sqrt((A - 1.0) * (A + 1.0))))
        return float((A - delta0) ** 1.5) / decay - 2.0 * zeta * zeta

    lowest = max(1.0, delta0)
    highest = max(lowest, (2.0 * zeta * zeta) ** (-2.0 / 3.0)) * 1.000001 + 1e-6
    turns = np.roots([3.0, 0.0, 1.0 - 12.0 * delta0**2, -8.0 * delta0, 16.0 * delta0**2])
    turns = np.sort(turns.real[np.abs(turns.imag) < 1e-9 * (1.0 + delta0)])
    turns = turns[(turns > lowest) & (turns < highest)]
    edges = [lowest, *(float(turn) for turn in turns), highest]
    return [
        float(brentq(excess, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps))
        for low, high in pairwise(edges)
        if (excess(low) >= 0.0) != (excess(high) >= 0.0)
    ]


def tip_speed(A: float, zeta: float, delta0: float) -> float:
    """Return the one speed at a tip, ``omega**2 = A**2 (s - 2 zeta**2)/(A**2 - 1)``."""
    s = float(secant_stiffness(A, delta0))
    return math.sqrt(A * A * (s - 2.0 * zeta * zeta) / ((A - 1.0) * (A + 1.0)))


def tips_of_ring(zeta: float, ring: Ring) -> list[float]:
    """Return the amplitudes above 1 at which the flanks meet, ascending; none without damping.

    There ``g/(A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``, where g is the force of ring and shaft.
    Between two neighbouring extrema of the left-hand side, ``(A g' - 2 g) sqrt(A**2 - 1) = A g``,
    is at most one tip.
    """
    if zeta == 0.0:
        return []

    def excess(u: float) -> float:
        A, force, _ = ring.forces(np.array(u))
        decay = A * A * (A + np.sqrt(np.maximum((A - 1.0) * (A + 1.0), 0.0)))
        return float(force / decay) - 2.0 * zeta * zeta

    u = np.poly1d([1.0, 0.0])
    A, d, kappa = u * u + ring.delta0, ring.delta0, ring.shaft_stiffness
    force = (u * u * u if ring.hertz else u * u) + kappa * A
    slope = (1.5 * u if ring.hertz else np.poly1d([1.0])) + kappa
    lead = A * slope - 2.0 * force
    turns = positive_roots(lead * lead * (A * A - 1.0) - A * A * force * force)
    lowest = math.sqrt(max(1.0 - d, 0.0))
    least = 2.0 * zeta * zeta
    highest = 10.0 * (1.0 + math.sqrt(d) + math.cbrt(1.0 / least) + ((1.0 + kappa) / least) ** 0.25)
    edges = [lowest, *np.sort(turns[(turns > lowest) & (turns < highest)]).tolist(), highest]
    found = [
        d + float(brentq(excess, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps)) ** 2
        for low, high in pairwise(edges)
        if (excess(low) >= 0.0) != (excess(high) >= 0.0)
    ]
    return [A for A in found if A > 1.0]  # at 1 itself they meet at no speed


def tip_speed_of_ring(A: float, zeta: float, ring: Ring) -> float:
    """Return the one speed at a tip, as `tip_speed` does, of any ring."""
    stiffness = float(ring.stiffness(np.array(A)))
    return math.sqrt(A * A * (stiffness - 2.0 * zeta * zeta) / (A * A - 1.0))


def peaks(
    *,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: npt.ArrayLike = 0.0,
    contact_exponent: npt.ArrayLike = HERTZ_EXPONENT,
    friction: npt.ArrayLike = 0.0,
) -> xr.Dataset:
    """Return the largest contacting whirl for each damping and clearance.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios, above zero without friction, and clearances [1].
    shaft_stiffness, contact_exponent, friction : float or sequence of float
        As for `Rotor`, numbers or axes [1].

    Returns
    -------
    Dataset
        On (zeta, delta0) and those of the others that are a sequence: ``peak_amplitude``,
        ``peak_omega`` and ``peak_contact_force`` [1]; NaN where the damping leaves no peak.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or a damping is zero
        without friction; if an exponent is neither 1.5 nor 1; if there is friction without
        clearance, or above zero and below 1e-20.

    Notes
    -----
    At the tip the quadratic of `speeds_at_amplitude` has one root,
    ``omega**2 = A**2 (s - 2 zeta**2)/(A**2 - 1)`` with ``s = kappa + f(A)/A``. Contact damping
    does not change it; of friction, see `peak_amplitude`.

    References
    ----------
    Section 4.2.1 and Fig. 10 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> found = peaks(zeta=0.07, delta0=[0.0, 2.0])
    >>> found.peak_amplitude.values.round(3), found.peak_contact_force.values.round(2)
    (array([[13.768, 11.346]]), array([[51.09, 28.57]]))
    """
    dampings = check_axis("zeta", zeta, smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER)
    clearances = check_axis("delta0", delta0, largest=LARGEST_NUMBER)
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=0.0,
        friction=friction,
        delta0=clearances,
    )
    _friction_axis(further.axes["friction"])
    laws = [further.axes[name] for name in ("shaft_stiffness", "contact_exponent", "friction")]
    check_points(dampings, clearances, *laws)
    grid = np.meshgrid(dampings, clearances, *laws, indexing="ij")
    rows = zip(*(axis.ravel().tolist() for axis in grid), strict=True)
    shape = (dampings.size, clearances.size, *further.sizes)
    table = np.array([_peak(*row) for row in rows]).reshape(*shape, 3)
    names = ("peak_amplitude", "peak_omega", "peak_contact_force")
    contact = "Hertz contact" if further.default else "contact"
    return labelled_dataset(
        f"Largest contacting whirls of a rotor with {contact} and clearance",
        {
            name: (("zeta", "delta0", *further.dims), table[..., k].copy())
            for k, name in enumerate(names)
        },
        {
            "zeta": ("zeta", dampings),
            "delta0": ("delta0", clearances),
            **further.coordinates,
        },
        kind="peaks",
    )


def _peak(
    zeta: float, delta0: float, kappa: float, exponent: float, friction: float
) -> tuple[float, float, float]:
    if friction > 0.0:
        rub = Rub(zeta, delta0, kappa, friction, exponent == HERTZ_EXPONENT)
        A, omega = max(rub_tips(rub), default=(math.nan, math.nan))
        return A, omega, float(contact_force(A, delta0, exponent))
    A = peak_amplitude(zeta=zeta, delta0=delta0, shaft_stiffness=kappa, contact_exponent=exponent)
    if math.isnan(A):
        return math.nan, math.nan, math.nan
    force = float(contact_force(A, delta0, exponent))
    if kappa == 0.0 and exponent == HERTZ_EXPONENT:
        return A, tip_speed(A, zeta, delta0), force
    return A, tip_speed_of_ring(A, zeta, Ring(delta0, kappa, exponent == HERTZ_EXPONENT)), force
