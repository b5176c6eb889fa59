"""The restoring force and its potential over the plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points, check_vector
from rotor_ida.equations.contact import contact_potential, secant_stiffness
from rotor_ida.schema import labelled_dataset


def restoring_field(*, x: npt.ArrayLike, y: npt.ArrayLike, delta0: npt.ArrayLike) -> xr.Dataset:
    """Return restoring force and potential over a grid of places.

    Parameters
    ----------
    x, y : float or sequence of float, shapes (n,) and (m,)
        Places [1].
    delta0 : float or sequence of float, shape (k,)
        Clearances [1].

    Returns
    -------
    Dataset
        ``restoring_x``, ``restoring_y`` and ``potential`` [1] on (delta0, y, x).

    Raises
    ------
    InputError
        If a value is not a finite real number, or a clearance is negative.

    Notes
    -----
    ``f_x + i f_y = f(|z|) z/|z|``: each component depends on x and on y, and f_x never falls
    as x grows, since the force is the gradient of the convex ``V = (2/5) (|z| - delta0)_+**2.5``.

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
    radius = np.hypot(across, up[:, None])
    secant = secant_stiffness(radius, clearance[:, None, None])
    dims = ("delta0", "y", "x")
    return labelled_dataset(
        "Restoring force and potential of a ring with clearance",
        {
            "restoring_x": (dims, secant * across),
            "restoring_y": (dims, secant * up[:, None]),
            "potential": (dims, contact_potential(radius, clearance[:, None, None])),
        },
        {"delta0": ("delta0", clearance), "y": ("y", up), "x": ("x", across)},
    )
