"""All Hopf points, at which a synchronous whirl in contact begins to oscillate, exactly.

Contact damping acts only along the radius. Where the whirl is faster than its stiffness allows,
contact damping drives the motion; so does friction. `curve_polynomials` contains the equations.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.closed_forms.curve_polynomials import HopfPoint, equations_of, exact_hopf_points
from rotor_ida.closed_forms.rotor_columns import RotorColumns, checked_rotors
from rotor_ida.schema import labelled_dataset

_RANGES = dict.fromkeys(
    ("zeta", "delta0", "shaft_stiffness", "contact_damping", "friction"), (1e-20, 1e6)
)


def hopf_points(
    *,
    zeta: object,
    delta0: object,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Compute all Hopf points of the contacting whirls.

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
        dimensions (zeta, delta0, hopf), in order of speed, padded with NaN. Of the last four
        parameters, a sequence becomes a dimension before ``hopf``, and a number other than the
        default becomes a coordinate.

    Raises
    ------
    InputError
        If a value is not a finite real number that is 0 or from 1e-20 to 1e6; if an exponent is
        neither 1.5 nor 1; if there is contact damping or friction without clearance.

    Notes
    -----
    At a Hopf point a pair of `eigenvalues` crosses the imaginary axis. A limit cycle in full
    contact is born with the period ``2 pi/hopf_frequency``; `limit_cycle` and `continue_cycle` show
    whether it is stable. Hopf points occur only with contact damping or friction, and never
    without any damping. They are the roots of a polynomial, isolated in exact arithmetic: all are
    found except pairs that nearly coincide.

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
    rotors = checked_rotors(
        {
            "zeta": zeta,
            "delta0": delta0,
            "shaft_stiffness": shaft_stiffness,
            "contact_exponent": contact_exponent,
            "contact_damping": contact_damping,
            "friction": friction,
        },
        _RANGES,
    )
    found = [exact_hopf_points(each) for each in equations_of(RotorColumns.grid(rotors))]
    most = max(1, *map(len, found))
    table = np.full((len(found), most, 3), np.nan)
    for row, points in zip(table, found, strict=True):
        row[: len(points)] = np.reshape(points, (-1, 3))
    table = table.reshape(*rotors.sizes, most, 3)
    dims = (*rotors.dims, "hopf")
    return labelled_dataset(
        "Hopf points of the synchronous whirls of a rotor with contact and clearance",
        {f"hopf_{name}": (dims, table[..., k]) for k, name in enumerate(HopfPoint._fields)},
        rotors.coordinates | {"hopf": ("hopf", np.arange(most))},
        {"source": "rotor_ida closed forms: roots of a polynomial in exact arithmetic"},
        kind="hopf_points",
    )
