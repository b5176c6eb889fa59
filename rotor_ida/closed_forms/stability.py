"""Stability of a synchronous whirl, in closed form.

Seen in the frame that turns with the unbalance, a whirl is an equilibrium, and its four
eigenvalues follow from two quadratic equations, one inside the other.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_array
from rotor_ida.equations.contact import contact_stiffness, secant_stiffness
from rotor_ida.errors import InputError

ComplexValues = npt.NDArray[np.complex128]


def stability_determinant(
    amplitude: npt.ArrayLike, *, omega: npt.ArrayLike, zeta: npt.ArrayLike, delta0: npt.ArrayLike
) -> Values:
    """Return the determinant that decides whether a contacting whirl is stable.

    Parameters
    ----------
    amplitude : array_like
        Amplitude A of the whirl [1].
    omega, zeta, delta0 : array_like
        Spin speed, damping ratio and clearance [1]; all four broadcast.

    Returns
    -------
    ndarray
        D [1]: positive for a stable whirl, negative for an unstable one, zero at a fold.

    Raises
    ------
    InputError
        If a value is not a finite real number within 1e15 of zero, or shapes do not broadcast.

    Notes
    -----
    ``D = (f'(A) - q)(s(A) - q) + 4 zeta**2 q`` with ``q = omega**2`` and ``s(A) = f(A)/A``. It
    is the determinant of the stiffness matrix in the rotating frame.

    References
    ----------
    Linearisation of eq. (10) of the paper, Mechanika 25(6), 2019, in the rotating frame.

    Examples
    --------
    >>> round(float(stability_determinant(4.0, omega=1.0, zeta=0.5, delta0=0.0)), 12)
    3.0
    """
    A, speed, damping, clearance = _checked(amplitude, omega, zeta, delta0)
    q = np.square(speed)
    tangent, secant = contact_stiffness(A, clearance), secant_stiffness(A, clearance)
    return np.asarray((tangent - q) * (secant - q) + 4.0 * np.square(damping) * q)


def eigenvalues(
    amplitude: npt.ArrayLike, *, omega: npt.ArrayLike, zeta: npt.ArrayLike, delta0: npt.ArrayLike
) -> ComplexValues:
    """Return the four eigenvalues of a synchronous whirl in the rotating frame.

    Parameters
    ----------
    amplitude, omega, zeta, delta0 : array_like
        As for `stability_determinant`.

    Returns
    -------
    ndarray of complex, shape (..., 4)
        Growth rates (real parts) and frequencies (imaginary parts) [1].

    Raises
    ------
    InputError
        As `stability_determinant`.

    Notes
    -----
    ``lambda = -zeta +- sqrt(zeta**2 + sigma)`` with
    ``sigma**2 + (f' + s + 2 q) sigma + D = 0``.

    References
    ----------
    Linearisation of eq. (10) of the paper, Mechanika 25(6), 2019, in the rotating frame.

    Examples
    --------
    >>> rates = eigenvalues(6.1932109611, omega=1.7, zeta=0.07, delta0=0.0).real
    >>> round(float(rates.max()), 5)
    0.0983
    """
    determinant = stability_determinant(amplitude, omega=omega, zeta=zeta, delta0=delta0)
    return _eigenvalues(determinant, *_checked(amplitude, omega, zeta, delta0))


def growth_rate(
    amplitude: Values, determinant: Values, omega: Values, zeta: Values, delta0: Values
) -> Values:
    """Return the largest real part of the eigenvalues of whirls whose D is known already."""
    rates = _eigenvalues(determinant, amplitude, omega, zeta, delta0).real
    return np.asarray(rates.max(axis=-1))


def _checked(
    amplitude: npt.ArrayLike, omega: npt.ArrayLike, zeta: npt.ArrayLike, delta0: npt.ArrayLike
) -> tuple[Values, ...]:
    """Return amplitudes, speeds, dampings and clearances that broadcast."""
    given = {"amplitude": amplitude, "omega": omega, "zeta": zeta, "delta0": delta0}
    arrays = [check_array(name, each, largest=LARGEST_NUMBER) for name, each in given.items()]
    try:
        return np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise InputError(
            f"{', '.join(given)} must broadcast, got arrays of shapes {shapes}"
        ) from None


def _eigenvalues(
    determinant: Values, amplitude: Values, omega: Values, zeta: Values, delta0: Values
) -> ComplexValues:
    """Return the eigenvalues in forms that keep the small ones accurate."""
    q, damping = np.square(omega), zeta
    tangent, secant = contact_stiffness(amplitude, delta0), secant_stiffness(amplitude, delta0)
    # (f' + s + 2 q)**2 - 4 D, with the large terms cancelled by hand
    discriminant = (tangent - secant) ** 2 + 8.0 * q * (tangent + secant)
    discriminant = discriminant - 16.0 * damping**2 * q
    total = tangent + secant + 2.0 * q + np.sqrt(discriminant.astype(np.complex128))
    zero = np.zeros_like(total)
    sigmas = (
        np.divide(-2.0 * determinant, total, out=zero.copy(), where=total != 0.0),
        -0.5 * total,
    )
    found = []
    for sigma in sigmas:
        root = np.sqrt(damping**2 + sigma)
        sum_ = damping + root
        found += [np.divide(sigma, sum_, out=zero.copy(), where=sum_ != 0.0), -damping - root]
    return np.stack(found, axis=-1)
