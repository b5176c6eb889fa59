"""All Hopf points, at which a synchronous whirl in contact begins to oscillate, exactly.

Contact damping acts only along the radius. Where the whirl is faster than its stiffness allows,
contact damping drives the motion; so does friction. `curve_polynomials` contains the equations.
"""

from __future__ import annotations

from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.closed_forms.curve_polynomials import HopfPoint, equations_of, exact_hopf_points
from rotor_ida.closed_forms.folds import ALL_SPEEDS
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.results.in_si import takes_si
from rotor_ida.schema import labelled_dataset

_RANGES = dict.fromkeys(
    ("zeta", "delta0", "shaft_stiffness", "contact_damping", "friction"), (1e-20, 1e6)
)


@takes_si
def hopf_points(
    rotor: Rotor | DimensionalRotor | None = None, **varied: Unpack[Parameters]
) -> xr.Dataset:
    """Compute all Hopf points of the contacting whirls.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor. Without it, ``zeta`` and ``delta0`` must be given.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`, as for `folds`.

    Returns
    -------
    Dataset
        ``hopf_omega`` and ``hopf_amplitude``, the speed and the amplitude of the whirl, and
        ``hopf_frequency``, at which it begins to oscillate on the rotating axes [dimensionless], on
        the dimensions (zeta, delta0, hopf), in order of speed, padded with NaN; other dimensions as
        for `folds`.

    Raises
    ------
    InputError
        If a value is not a finite real number that is 0 or from 1e-20 to 1e6; if an exponent is
        neither 1.5 nor 1; if there is contact damping or friction without clearance, or a load.

    Notes
    -----
    At a Hopf point a pair of `eigenvalues` crosses the imaginary axis. A limit cycle in full
    contact is born with the period ``2 pi/hopf_frequency``; `limit_cycle` and `continue_cycle` show
    whether it is stable. Hopf points occur only with contact damping or friction, and never
    without any damping. They are the roots of a polynomial, isolated in exact arithmetic: none is
    missed, and two that coincide are listed once.

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
    asked = whirls_asked(hopf_points, rotor, varied, _RANGES, ALL_SPEEDS)
    found = [exact_hopf_points(each) for each in equations_of(RotorColumns.of(asked.columns))]
    most = max(1, *map(len, found))
    table = np.full((len(found), most, 3), np.nan)
    for row, points in zip(table, found, strict=True):
        row[: len(points)] = np.reshape(points, (-1, 3))
    table = table.reshape(*asked.shape, most, 3)
    dims = (*asked.dims, "hopf")
    return labelled_dataset(
        "Hopf points of the synchronous whirls of a rotor with contact and clearance",
        {f"hopf_{name}": (dims, table[..., k]) for k, name in enumerate(HopfPoint._fields)},
        asked.coordinates | {"hopf": ("hopf", np.arange(most))},
        {"source": "rotor_ida closed forms: roots of a polynomial in exact arithmetic"},
        kind="hopf_points",
    )
