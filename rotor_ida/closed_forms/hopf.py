"""Hopf points: where a synchronous whirl in contact begins to oscillate, exactly and all of them.

Contact damping acts along the radius alone, and where the whirl is faster than what springs back
can hold, it drives the motion. With ``K = kappa + f'(A)``, ``S = kappa + f(A)/A``, ``m = 2 zeta +
c f(A)`` and ``q = omega**2`` the eigenvalues of a whirl are the roots of ``L**4 + a3 L**3 + a2 L**2
+ a1 L + a0`` with

    a3 = m + 2 zeta,                a1 = m S + 2 zeta K + (6 zeta - m) q,
    a2 = K + S + 2 zeta m + 2 q,    a0 = (K - q)(S - q) + 4 zeta**2 q.

Two of them are ``+- i Omega`` where ``H = a3 a2 a1 - a1**2 - a3**2 a0`` vanishes and ``Omega**2 =
a1/a3`` is positive (Routh and Hurwitz) [1]_. The response curve is quadratic in q at a given
amplitude, and so is H. Both have a root in common where their resultant vanishes, which is a
polynomial in ``u = sqrt(A - delta0)``, or in ``A - delta0`` in a linear contact. Its coefficients
are whole numbers up to a power of two, since parameters are doubles. So its roots are isolated by
Descartes' rule of signs in exact arithmetic: none is lost and none invented [2]_, but for two that
nearly coincide.

References
----------
.. [1] Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer, 2004, section 5.4.
.. [2] G. E. Collins, A. G. Akritas, "Polynomial real root isolation using Descartes' rule of
   signs", SYMSAC 1976.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import product

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_axis, check_points
from rotor_ida.closed_forms.exact_polynomials import (
    FINER,
    SAME,
    Polynomial,
    Root,
    constant,
    positive_roots,
)
from rotor_ida.closed_forms.further_parameters import further_axes
from rotor_ida.closed_forms.rubs import Rub, rub_hopf_points
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.schema import labelled_dataset


def hopf_points(
    *,
    zeta: object,
    delta0: object,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return every Hopf point of the contacting whirls.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios and clearances [1].
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `Rotor`, numbers or axes [1].

    Returns
    -------
    Dataset
        ``hopf_omega`` and ``hopf_amplitude``, the speed and the amplitude of the whirl, and
        ``hopf_frequency``, at which it begins to oscillate on the rotating axes [1], on the
        dimensions (zeta, delta0, hopf), in order of speed; NaN where there are fewer than the
        dimension is long. Each of the last four parameters that is given as a sequence is a
        dimension before ``hopf``, as a number that is not the default a coordinate.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or is above 1e6, or is
        above zero and below 1e-20; if an exponent is neither 1.5 nor 1; if there is contact damping
        or friction without clearance.

    Notes
    -----
    There a pair of `eigenvalues` crosses the imaginary axis, and a limit cycle in full contact is
    born with the period ``2 pi/hopf_frequency``, stable or not: `limit_cycle` and `continue_cycle`
    tell. Friction brings some as well: see `rubs`. With neither it nor contact damping there is
    none, nor without any damping. They are the roots of a polynomial, isolated in exact arithmetic:
    all are found but for pairs that nearly coincide.

    References
    ----------
    Linearisation of eq. (10) of the paper, Mechanika 25(6), 2019, with contact damping by Hunt and
    Crossley, in the rotating frame.

    Examples
    --------
    >>> found = hopf_points(zeta=0.07, delta0=0.5, contact_damping=0.5)
    >>> found.hopf_omega.values.ravel().round(6)
    array([1.75784])
    >>> rubbing = hopf_points(zeta=0.07, delta0=0.5, friction=0.1)
    >>> rubbing.hopf_omega.values.ravel().round(6)
    array([1.122971, 1.37644 ])
    """
    dampings, clearances = _checked("zeta", zeta), _checked("delta0", delta0)
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
        delta0=clearances,
    )
    for name in ("shaft_stiffness", "contact_damping", "friction"):
        _checked(name, further.axes[name])
    check_points(dampings, clearances, *further.axes.values())
    axes = (dampings, clearances, *further.axes.values())
    found = [_of_rotor(*place) for place in product(*(axis.tolist() for axis in axes))]
    most = max(1, *map(len, found))
    table = np.full((len(found), most, 3), np.nan)
    for row, points in zip(table, found, strict=True):
        row[: len(points)] = np.reshape(points, (-1, 3))
    table = table.reshape(dampings.size, clearances.size, *further.sizes, most, 3)
    dims = ("zeta", "delta0", *further.dims, "hopf")
    names = ("hopf_omega", "hopf_amplitude", "hopf_frequency")
    return labelled_dataset(
        "Hopf points of the synchronous whirls of a rotor with contact and clearance",
        {name: (dims, table[..., place]) for place, name in enumerate(names)},
        {
            "zeta": ("zeta", dampings),
            "delta0": ("delta0", clearances),
            **further.coordinates,
            "hopf": ("hopf", np.arange(most)),
        },
        {"source": "rotor_ida closed forms: roots of a polynomial in exact arithmetic"},
        kind="hopf_points",
    )


def _checked(name: str, values: object) -> Values:
    return check_axis(name, values, smallest=1e-20, largest=1e6)


# The figures of response curves ask for those of one rotor again and again.
@lru_cache(maxsize=1024)
def _of_rotor(
    zeta: float,
    delta0: float,
    kappa: float,
    exponent: float,
    contact_damping: float,
    friction: float,
) -> tuple[tuple[float, float, float], ...]:
    """Return speed, amplitude and frequency of every Hopf point of a rotor, in order of speed."""
    hertz = exponent == HERTZ_EXPONENT
    if friction > 0.0:
        return rub_hopf_points(Rub(zeta, delta0, kappa, friction, hertz, contact_damping))
    if zeta == 0.0 or contact_damping == 0.0:
        return ()
    whirl = _whirl_in(*map(Fraction, (zeta, delta0, kappa, contact_damping)), hertz=hertz)
    found = []
    for root in positive_roots(whirl.resultant()):
        point = whirl.at(root)
        if point is None:
            continue
        place, q, squared = point
        depth = place * place if hertz else place
        found.append((math.sqrt(q), float(Fraction(delta0) + depth), math.sqrt(squared)))
    return tuple(sorted(found))


@dataclass(frozen=True, slots=True)
class _Whirl:
    """Curve and condition of a Hopf point, both quadratic in q: three polynomials, lowest first.

    ``a1`` are the two coefficients of ``A a1``, and ``a3`` is ``A a3``.
    """

    curve: tuple[Polynomial, Polynomial, Polynomial]
    hopf: tuple[Polynomial, Polynomial, Polynomial]
    a1: tuple[Polynomial, Polynomial]
    a3: Polynomial

    def resultant(self) -> Polynomial:
        """Return the resultant of both by q."""
        (r0, r1, r2), (h0, h1, h2) = self.curve, self.hopf
        ends, first, last = h2 * r0 - h0 * r2, h2 * r1 - h1 * r2, h1 * r0 - h0 * r1
        return ends * ends - first * last

    def at(self, root: Root) -> tuple[Fraction, Fraction, Fraction] | None:
        """Return a root, q and the frequency squared there, or None where is no Hopf point."""
        for power in FINER:
            low, high = root.narrowed(power)
            one, other = self._common(low), self._common(high)
            pairs = list(zip(one, other, strict=True))
            if pairs and all(abs(a - b) <= SAME * abs(b) for a, b in pairs):
                break
        else:
            return None
        q, squared = one
        return (low, q, squared) if q > 0 and squared > 0 else None

    def _common(self, place: Fraction) -> tuple[Fraction, ...]:
        """Return the root q that both have at a place, and the frequency squared; or nothing."""
        (r0, r1, r2), (h0, h1, h2) = (
            [each(place) for each in equation] for equation in (self.curve, self.hopf)
        )
        below = h2 * r1 - h1 * r2
        if below == 0:
            return ()
        q = (h0 * r2 - h2 * r0) / below
        return q, (self.a1[0](place) + q * self.a1[1](place)) / self.a3(place)


def _whirl_in(
    zeta: Fraction, delta0: Fraction, kappa: Fraction, c: Fraction, *, hertz: bool
) -> _Whirl:
    """Return the equations of a Hopf point by u, or by the depth in a linear contact."""
    powers = [constant(1)]
    for _ in range(3):
        powers.append(powers[-1] * Polynomial((Fraction(0), Fraction(1))))
    A = constant(delta0) + (powers[2] if hertz else powers[1])
    f = powers[3] if hertz else powers[1]
    slope = constant(Fraction(3, 2)) * powers[1] if hertz else powers[0]
    two_zeta, damping = constant(2 * zeta), constant(4 * zeta * zeta)
    g, K = f + constant(kappa) * A, slope + constant(kappa)
    m = two_zeta + constant(c) * f
    a3 = m + two_zeta
    # A a2 = P + 2 A q and A a1 = M0 + M1 q
    P = A * K + g + two_zeta * m * A
    M0, M1 = m * g + two_zeta * A * K, A * (constant(6 * zeta) - m)
    two = constant(2)
    curve = (g * g, damping * A * A - two * A * g, A * A - constant(1))
    hopf = (
        a3 * P * M0 - M0 * M0 - a3 * a3 * A * K * g,
        a3 * (P * M1 + two * A * M0)
        - two * M0 * M1
        - a3 * a3 * (damping * A * A - A * A * K - A * g),
        two * a3 * A * M1 - M1 * M1 - a3 * a3 * A * A,
    )
    return _Whirl(curve, hopf, (M0, M1), A * a3)
