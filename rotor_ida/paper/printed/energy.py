"""Eqs (9) and (13) as printed: the reference frequency and the energy."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.contact import contact_potential
from rotor_ida.parameters import DimensionalRotor

Values = npt.NDArray[np.float64]


def reference_frequency(machine: DimensionalRotor) -> float:
    """Return ``sqrt(k/m)``, the number that eqs (8) and (9) call the reference frequency.

    Parameters
    ----------
    machine : DimensionalRotor
        The machine.

    Returns
    -------
    float
        ``sqrt(k/m)`` in SI units, which are not 1/s: k is in N/m^1.5.

    Notes
    -----
    Wrong: a Hertz stiffness over a mass is no frequency squared. Right is
    ``omega_0**2 = k sqrt(D)/m``, `DimensionalRotor.reference_frequency`.

    References
    ----------
    Eqs (8) and (9) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> round(reference_frequency(machine)), round(machine.reference_frequency)
    (15811, 500)
    """
    return math.sqrt(machine.contact_stiffness / machine.mass)


def hamiltonian(states: npt.ArrayLike, delta0: float) -> Values:
    """Return eq. (13) as printed, ``|z|**2/2 + (2/5) (|z| - delta0)_+**2.5``.

    Parameters
    ----------
    states : array_like, shape (..., 4)
        States ``(x, y, vx, vy)`` [1].
    delta0 : float
        Radial clearance [1].

    Returns
    -------
    ndarray, shape (...)
        What is printed [1].

    Notes
    -----
    Wrong: it is not conserved. Right is ``|z'|**2/2`` in the first term,
    `rotor_ida.equations.model.energy`.

    References
    ----------
    Eq. (13) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> float(hamiltonian((1.5, 0.0, 0.0, 2.0), 0.5))
    1.525
    """
    x, y, _, _ = np.moveaxis(np.asarray(states, dtype=np.float64), -1, 0)
    return np.asarray(0.5 * (x**2 + y**2) + contact_potential(np.hypot(x, y), delta0))
