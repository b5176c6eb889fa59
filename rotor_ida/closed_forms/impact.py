"""Exact restitution and indentation of a radial impact with contact damping."""

from __future__ import annotations

from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_distinct, check_points
from rotor_ida.model.parameters import ALL_PARAMETERS, Parameters
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.varied import varied_of
from rotor_ida.schema import labelled_dataset

# What an impact does not take, and why.
LEFT_OUT = {
    name: "the contact alone acts"
    for name in ALL_PARAMETERS
    if name not in {"contact_damping", "contact_exponent"}
}
# Powers of smaller values leave the range of doubles.
SMALLEST = 1e-100
# Above this the bound of `restitution` is the root, to rounding.
_FAST = 30.0
_TERMS = 20


def impact(
    rotor: Rotor | None = None, *, entry_speed: object, **varied: Unpack[Parameters]
) -> xr.Dataset:
    """Compute the restitution and the peak indentation of a radial impact on the stator.

    Parameters
    ----------
    rotor : Rotor, optional
        The rotor, of which the contact alone counts.
    entry_speed : float or sequence of float, shape (n,)
        Speeds v at which the rotor reaches the stator, radially outwards [dimensionless].
    **varied : float or array_like, shape (n,)
        ``contact_damping`` and ``contact_exponent`` [dimensionless], in place of those of `rotor`.

    Returns
    -------
    Dataset
        On (entry_speed, contact_damping): ``restitution``, the speed at exit over that at entry,
        and ``peak_indentation`` [dimensionless]. An array of exponents becomes a dimension after
        these; a number other than the default becomes a coordinate.

    Raises
    ------
    InputError
        If a value is not a finite real number that is 0 or from 1e-100 to 1e15; if an exponent is
        neither 1.5 nor 1.

    Notes
    -----
    In the contact alone, without shaft, unbalance or damping, the indentation d obeys
    ``d'' = -d**n (1 + c d')``. With the speed as a function of the depth,
    ``d' dd'/(1 + c d') = -d**n dd`` integrates to ``phi(c d')/c**2 + d**(n + 1)/(n + 1)``, a
    constant, where ``phi(x) = x - ln(1 + x)``. Hence with x = c v and the exit speed e v

        ``phi(x) = phi(-e x)``, that is ``x (1 + e) = ln((1 + x)/(1 - e x))``,

    for any exponent, and the largest indentation is
    ``((n + 1) phi(x)/c**2)**(1/(n + 1))``: for c = 0 ``((n + 1) v**2/2)**(1/(n + 1))``.
    For small x, ``e = 1 - 2 x/3``. The force stays positive to the end, as ``e x < 1``.

    References
    ----------
    K. H. Hunt and F. R. E. Crossley, "Coefficient of restitution interpreted as damping in
    vibroimpact", Journal of Applied Mechanics 42, 1975.

    Examples
    --------
    >>> hit = impact(entry_speed=[1.0, 3.0], contact_damping=1.0)
    >>> hit.restitution.values.ravel().round(9)
    array([0.59362426, 0.3068968 ])
    >>> round(impact(entry_speed=2.0, contact_damping=0.0).peak_indentation.item(), 6)
    1.903654
    """
    ranges = {"contact_damping": (SMALLEST, LARGEST_NUMBER)}
    asked = varied_of(impact, rotor, varied, left_out=LEFT_OUT, ranges=ranges)
    speeds = check_axis("entry_speed", entry_speed, smallest=SMALLEST, largest=LARGEST_NUMBER)
    check_distinct("entry_speed", speeds)
    dampings, exponents = asked.values("contact_damping"), asked.values("contact_exponent")
    contacts = asked.without("contact_damping")
    check_points(speeds, dampings, exponents)
    v, c, n = np.meshgrid(speeds, dampings, exponents, indexing="ij")
    x = c * v
    lasting = n + 1.0
    indentation = (v * np.sqrt(lasting * _loss(x))) ** (2.0 / lasting)
    dims = ("entry_speed", "contact_damping", *contacts.dims)
    shape = (speeds.size, dampings.size, *contacts.shape)
    return labelled_dataset(
        "Radial impacts on a stator with contact damping",
        {
            "restitution": (dims, restitution(x).reshape(shape)),
            "peak_indentation": (dims, indentation.reshape(shape)),
        },
        {
            "entry_speed": ("entry_speed", speeds),
            "contact_damping": ("contact_damping", dampings),
            **contacts.coordinates,
        },
        kind="impact",
    )


def restitution(x: Values) -> Values:
    """Return the coefficient of restitution e at contact damping times speed: see `impact`.

    Newton's method solves ``e**2 g(-e x) = g(x)`` with ``g(x) = phi(x)/x**2``, which is convex in
    e. It begins at a bound above the root, from ``phi(-y) > y**2/2`` and
    ``phi(-y) > -1 - ln(1 - y)``.

    Examples
    --------
    >>> restitution(np.array([0.0, 1.0, 1e6]))
    array([1.0000000e+00, 5.9362426e-01, 1.0000000e-06])
    """
    lost = _loss(x)
    remains = np.exp(-1.0 - lost * x * x)
    e = np.divide(1.0 - remains, x, out=np.ones_like(x), where=x > 1.0)
    slow = x < _FAST
    product, lost = x[slow], lost[slow]
    found = np.minimum(np.sqrt(2.0 * lost), e[slow])
    for _ in range(12):
        y = found * product
        found = found - (found * found * _loss(-y) - lost) * (1.0 - y) / found
    e[slow] = found
    return e


def _loss(x: Values) -> Values:
    """Return ``(x - ln(1 + x))/x**2`` for x > -1, without cancellation; 1/2 at 0.

    With ``t = x/(2 + x)``, ``ln(1 + x) = 2 (t + t**3/3 + ...)`` and ``x - 2 t = x t``.
    """
    t = x / (2.0 + x)
    square = t * t
    series = np.zeros_like(x)
    for order in range(_TERMS, 0, -1):
        series = series * square + 1.0 / (2 * order + 1)
    near = (1.0 - 2.0 * t * series / (2.0 + x)) / (2.0 + x)
    far = np.abs(t) > 1.0 / 3.0
    safe = np.where(far, x, 1.0)
    return np.where(far, (1.0 - np.log1p(safe) / safe) / safe, near)
