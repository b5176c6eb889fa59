"""Position of rest of a rotor at zero speed under its load, and vibration about it."""

from __future__ import annotations

import math

import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_instance, check_nonnegative
from rotor_ida.closed_forms.stability import slowest_rate
from rotor_ida.model.contact import force_at_depth
from rotor_ida.model.disc_starts import depth_at_rest, radius_at_rest
from rotor_ida.model.rotor import DimensionalRotor, Rotor, check_no_friction
from rotor_ida.results.in_si import takes_si
from rotor_ida.schema import STABILITY, labelled, labelled_dataset


@takes_si
def rest(rotor: Rotor | DimensionalRotor) -> xr.Dataset:
    """Compute the position of rest of a rotor at zero speed under its load, and its stability.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        Parameters of the rotor; the speed is not used. For a `DimensionalRotor` results are in SI
        units.

    Returns
    -------
    Dataset
        ``x`` and ``y`` of the position of rest and the ``indentation`` there [dimensionless], its
        ``stability`` (flags), the undamped circular frequencies ``radial_frequency`` and
        ``tangential_frequency`` of small vibration [dimensionless], and the ``growth_rate``, the
        largest real part of the eigenvalues [dimensionless].

    Raises
    ------
    InputError
        If `rotor` is not a `Rotor`, or a parameter is above 1e15.

    Notes
    -----
    With a shaft the rotor hangs at ``z = -i gamma/kappa`` if that is inside the clearance, else
    at ``z = -i r`` with ``kappa r + (r - delta0)**n = gamma``. Without a shaft it lies on the
    stator at the depth ``gamma**(1/n)``. Along the radius the stiffness is ``kappa + f'(r)`` and
    the damping ``2 zeta + c f(r)``, across it ``kappa + f(r)/r`` and ``2 zeta``. Without load and
    shaft every position inside the clearance is neutral; the centre is reported. Without damping
    every position of rest is neutral.

    References
    ----------
    The equation of `Rotor`, with omega = 0.

    Examples
    --------
    >>> lying = rest(Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=8.0))
    >>> lying.y.item(), round(lying.radial_frequency.item() ** 2, 12)
    (-5.0, 3.0)
    >>> rest(Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.5, shaft_stiffness=2.0)).y.item()
    -0.25
    """
    rotor = check_instance("rotor", rotor, Rotor)
    check_no_friction(rotor, "rest")
    for name in ("zeta", "delta0", "shaft_stiffness", "contact_damping", "load"):
        check_nonnegative(name, getattr(rotor, name), LARGEST_NUMBER)
    kappa, depth = rotor.shaft_stiffness, depth_at_rest(rotor)
    force, slope = force_at_depth(depth, rotor.contact_exponent)
    if depth == 0.0 and rotor.delta0 > 0.0:  # a linear contact has not begun
        slope = 0.0
    radius = radius_at_rest(rotor)
    secant = force / radius if depth > 0.0 else slope
    growth = max(
        float(slowest_rate(rotor.zeta + 0.5 * rotor.contact_damping * force, kappa + slope)),
        float(slowest_rate(rotor.zeta, kappa + secant)),
    )
    word = "stable" if growth < 0.0 else "neutral"
    values = {
        "x": 0.0,
        "y": 0.0 - radius,
        "indentation": depth,
        "radial_frequency": math.sqrt(kappa + slope),
        "tangential_frequency": math.sqrt(kappa + secant),
    }
    return labelled_dataset(
        "Rest of a rotor under its load",
        {name: ((), value) for name, value in values.items()}
        | {
            "stability": labelled("rest_stability", (), STABILITY[word]),
            "growth_rate": labelled("rest_growth_rate", (), growth),
        },
        {},
        kind="rest",
    )
