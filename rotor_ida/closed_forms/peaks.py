"""The peak of the response curve: the largest whirl, its speed and its force on the ring."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points
from rotor_ida.closed_forms.curve import SMALLEST_DAMPING, peak_amplitude
from rotor_ida.equations.contact import contact_force, secant_stiffness
from rotor_ida.schema import CONVENTIONS, labelled


def peaks(*, zeta: npt.ArrayLike, delta0: npt.ArrayLike) -> xr.Dataset:
    """Return the largest contacting whirl for each damping and clearance.

    Parameters
    ----------
    zeta : float or sequence of float, shape (m,)
        Damping ratios [1], above zero.
    delta0 : float or sequence of float, shape (k,)
        Clearances [1].

    Returns
    -------
    Dataset
        On (zeta, delta0): ``peak_amplitude``, ``peak_omega`` and ``peak_contact_force`` [1];
        NaN where the damping leaves no peak.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, or a damping is zero.

    Notes
    -----
    At the tip the quadratic of `curve` has one root,
    ``omega**2 = A**2 (s - 2 zeta**2)/(A**2 - 1)`` with ``s = f(A)/A``.

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
    check_points(dampings, clearances)
    table = np.array([[_peak(float(z), float(d)) for d in clearances] for z in dampings])
    names = ("peak_amplitude", "peak_omega", "peak_contact_force")
    variables = {
        name: labelled(name, ("zeta", "delta0"), table[..., number])
        for number, name in enumerate(names)
    }
    coordinates = {
        "zeta": labelled("zeta", "zeta", dampings),
        "delta0": labelled("delta0", "delta0", clearances),
    }
    title = "Largest contacting whirls of a rotor with Hertz contact and clearance"
    return xr.Dataset(variables, coordinates, {"Conventions": CONVENTIONS, "title": title})


def _peak(zeta: float, delta0: float) -> tuple[float, float, float]:
    A = peak_amplitude(zeta=zeta, delta0=delta0)
    if math.isnan(A):
        return math.nan, math.nan, math.nan
    s = float(secant_stiffness(A, delta0))
    omega = math.sqrt(A * A * (s - 2.0 * zeta * zeta) / ((A - 1.0) * (A + 1.0)))
    return A, omega, float(contact_force(A, delta0))
