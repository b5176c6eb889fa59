"""The restoring force and its potential over the plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points, check_vector
from rotor_ida.closed_forms.restoring_law import checked_law
from rotor_ida.model.contact import HERTZ_EXPONENT, contact_potential, secant_stiffness
from rotor_ida.schema import labelled_dataset


def restoring_field(
    *,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: float = 0.0,
    contact_exponent: float = HERTZ_EXPONENT,
) -> xr.Dataset:
    """Compute restoring force and potential on a grid of positions.

    Parameters
    ----------
    x, y : float or sequence of float, shapes (n,) and (m,)
        Positions [dimensionless].
    delta0 : float or sequence of float, shape (k,)
        Clearances [dimensionless].
    shaft_stiffness, contact_exponent : float
        As of `Rotor` [dimensionless].

    Returns
    -------
    Dataset
        ``restoring_x``, ``restoring_y`` and ``potential`` [dimensionless] on (delta0, y, x).

    Raises
    ------
    InputError
        If a value is not a finite real number, or a clearance or the stiffness is negative; if
        the exponent is neither 1.5 nor 1.

    Notes
    -----
    ``f_x + i f_y = f(|z|) z/|z|``: each component depends on x and on y, and f_x never falls
    as x grows, since the force is the gradient of the convex ``V = (2/5) (|z| - delta0)_+**2.5``.
    With a shaft and the exponent n the force is ``(kappa + f(|z|)/|z|) z`` and the potential
    ``kappa |z|**2/2 + (|z| - delta0)_+**(n + 1)/(n + 1)``.

    References
    ----------
    Eqs (11) and (12), Figs 2 and 3 of the paper, Mechanika 25(6), 2019, which writes
    ``f(x) + i f(y)`` and calls V concave.

    Examples
    --------
    >>> field = restoring_field(x=1.0, y=[0.0, 2.0], delta0=0.5)
    >>> field.restoring_x.values.ravel().round(4)
    array([0.3536, 1.023 ])
    """
    across = check_vector("x", x, largest=LARGEST_NUMBER)
    up = check_vector("y", y, largest=LARGEST_NUMBER)
    clearance = check_axis("delta0", delta0, largest=LARGEST_NUMBER)
    check_points(clearance, up, across)
    law = checked_law(shaft_stiffness=shaft_stiffness, contact_exponent=contact_exponent)
    kappa, exponent = law.shaft_stiffness, law.contact_exponent
    radius = np.hypot(across, up[:, None])
    secant = secant_stiffness(radius, clearance[:, None, None], exponent) + kappa
    potential = contact_potential(radius, clearance[:, None, None], exponent)
    potential = potential + 0.5 * kappa * radius**2
    dims = ("delta0", "y", "x")
    return labelled_dataset(
        "Restoring force and potential of a stator with clearance",
        {
            "restoring_x": (dims, secant * across),
            "restoring_y": (dims, secant * up[:, None]),
            "potential": (dims, potential),
        },
        {"delta0": ("delta0", clearance), "y": ("y", up), "x": ("x", across), **law.coordinates},
        kind="restoring_force",
    )
