"""Natural frequencies of free vibration over amplitude and clearance, as a labelled table."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points
from rotor_ida.closed_forms.free_vibration import circular_period, planar_period
from rotor_ida.schema import CONVENTIONS, labelled


def free_periods(*, amplitude: npt.ArrayLike, delta0: npt.ArrayLike) -> xr.Dataset:
    """Return the periods of free whirl on a circle and of free vibration on a line.

    Parameters
    ----------
    amplitude : float or sequence of float, shape (n,)
        Amplitudes A [1].
    delta0 : float or sequence of float, shape (k,)
        Clearances [1].

    Returns
    -------
    Dataset
        ``circular_period`` and ``planar_period`` [1] on (delta0, amplitude); NaN where the
        rotor does not reach the ring.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive.

    Notes
    -----
    Without clearance both fall like ``A**(-1/4)``: the ring hardens. With clearance the flight
    takes ever longer as the amplitude comes down to it, and the periods grow without bound.

    References
    ----------
    Eq. (17) and Fig. 4 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> periods = free_periods(amplitude=[2.0, 8.0], delta0=0.0)
    >>> periods.circular_period.values.round(5)
    array([[5.28351, 3.736  ]])
    """
    sizes = check_axis("amplitude", amplitude, largest=LARGEST_NUMBER)
    clearances = check_axis("delta0", delta0, largest=LARGEST_NUMBER)
    check_points(clearances, sizes)
    laws = {"circular_period": circular_period, "planar_period": planar_period}
    variables = {}
    for name, law in laws.items():
        table = [
            [law(size, clearance) if size > clearance else math.nan for size in sizes]
            for clearance in clearances
        ]
        variables[name] = labelled(name, ("delta0", "amplitude"), np.array(table))
    coordinates = {
        "delta0": labelled("delta0", "delta0", clearances),
        "amplitude": labelled("amplitude", "amplitude", sizes),
    }
    coordinates["amplitude"].attrs["long_name"] = "largest distance from the bearing axis"
    title = "Periods of free vibration of a rotor with Hertz contact and clearance"
    return xr.Dataset(variables, coordinates, {"Conventions": CONVENTIONS, "title": title})
