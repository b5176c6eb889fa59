"""Stability of a synchronous whirl, in closed form.

In the frame that rotates with the unbalance a whirl is an equilibrium. Its four eigenvalues follow
from two nested quadratic equations. With contact damping, which acts only along the radius, or
friction, which acts across it, they are the roots of a quartic.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import LARGEST_NUMBER, check_array, check_axis
from rotor_ida.closed_forms.restoring_law import stiffnesses
from rotor_ida.closed_forms.rotor_columns import RotorColumns
from rotor_ida.errors import InputError
from rotor_ida.model.contact import contact_force
from rotor_ida.model.parameters import NEED_CLEARANCE, check_clearance_needed, check_exponent


def stability_determinant(
    amplitude: npt.ArrayLike,
    *,
    omega: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: npt.ArrayLike = 0.0,
    contact_exponent: npt.ArrayLike = 1.5,
    contact_damping: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 0.0,
) -> Values:
    """Compute the determinant whose sign changes at the folds of contacting whirls.

    Parameters
    ----------
    amplitude : array_like
        Amplitude A of the whirl [dimensionless].
    omega, zeta, delta0 : array_like
        Spin speed, damping ratio and clearance [dimensionless]; all broadcast.
    shaft_stiffness, contact_exponent, contact_damping, friction : array_like
        As for `Rotor` [dimensionless]. The contact damping has no effect here.

    Returns
    -------
    ndarray
        D [dimensionless]: positive for a stable whirl, negative for an unstable one, zero at a
        fold. With contact damping or friction a whirl may also be unstable where D is positive: see
        `eigenvalues`.

    Raises
    ------
    InputError
        If a value is not a finite real number from zero to 1e15, or shapes do not broadcast; if the
        exponent is neither 1.5 nor 1; if there is contact damping or friction without clearance.

    Notes
    -----
    ``D = a b + 4 zeta**2 q`` with ``a = kappa + f'(A) - q``, ``b = kappa + f(A)/A - q`` and
    ``q = omega**2``. It is the determinant of the stiffness matrix in the rotating frame. With
    friction mu it is ``a b + (2 zeta omega + mu f'(A)) (2 zeta omega + mu f(A)/A)``.

    References
    ----------
    Linearisation of eq. (10) of the paper, Mechanika 25(6), 2019, in the rotating frame.

    Examples
    --------
    >>> round(float(stability_determinant(4.0, omega=1.0, zeta=0.5, delta0=0.0)), 12)
    3.0
    """
    every, rotors = checked_whirls(
        amplitude=amplitude, omega=omega, zeta=zeta, delta0=delta0,
        shaft_stiffness=shaft_stiffness, contact_exponent=contact_exponent,
        contact_damping=contact_damping, friction=friction,
    )  # fmt: skip
    return _determinant(every["amplitude"], rotors)


def _determinant(A: Values, rotors: RotorColumns) -> Values:
    q, mu = np.square(rotors.omega), rotors.friction
    tangent, secant = stiffnesses(A, rotors.delta0, rotors.contact_exponent)
    loss = 4.0 * np.square(rotors.zeta) * q
    loss = loss + mu * (
        2.0 * rotors.zeta * rotors.omega * (tangent + secant) + mu * tangent * secant
    )
    excess = q - rotors.shaft_stiffness
    return np.asarray((tangent - excess) * (secant - excess) + loss)


def eigenvalues(
    amplitude: npt.ArrayLike,
    *,
    omega: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: npt.ArrayLike = 0.0,
    contact_exponent: npt.ArrayLike = 1.5,
    contact_damping: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 0.0,
) -> ComplexValues:
    """Compute the four eigenvalues of a synchronous whirl in the rotating frame.

    Parameters
    ----------
    amplitude, omega, zeta, delta0, shaft_stiffness, contact_exponent, contact_damping : array_like
        As for `stability_determinant`.

    Returns
    -------
    ndarray of complex, shape (..., 4)
        Growth rates (real parts) and frequencies (imaginary parts) [dimensionless].

    Raises
    ------
    InputError
        As `stability_determinant`.

    Notes
    -----
    ``lambda = -zeta +- sqrt(zeta**2 + sigma)`` with
    ``sigma**2 + (f' + s + 2 q + 2 kappa) sigma + D = 0`` and ``s = f/A``. Contact damping c acts
    only along the radius. With a and b as for `stability_determinant` the eigenvalues are then the
    roots of ``(L**2 + (2 zeta + c f) L + a)(L**2 + 2 zeta L + b) + 4 q (L + zeta)**2``. If b is
    negative, contact damping drives the whirl, which may lose its stability at a Hopf point.

    References
    ----------
    Linearisation of eq. (10) of the paper, Mechanika 25(6), 2019, in the rotating frame.

    Examples
    --------
    >>> rates = eigenvalues(6.1932109611, omega=1.7, zeta=0.07, delta0=0.0).real
    >>> round(float(rates.max()), 5)
    0.0983
    """
    every, rotors = checked_whirls(
        amplitude=amplitude, omega=omega, zeta=zeta, delta0=delta0,
        shaft_stiffness=shaft_stiffness, contact_exponent=contact_exponent,
        contact_damping=contact_damping, friction=friction,
    )  # fmt: skip
    return eigenvalues_of(every["amplitude"], rotors)


def eigenvalues_of(amplitude: Values, rotors: RotorColumns) -> ComplexValues:
    """Return the eigenvalues of whirls in contact, shape (..., 4)."""
    return _eigenvalues(_determinant(amplitude, rotors), amplitude, rotors)


def growth_rate(amplitude: Values, determinant: Values, rotors: RotorColumns) -> Values:
    """Return the largest real part of the eigenvalues of whirls with known D."""
    return np.asarray(_eigenvalues(determinant, amplitude, rotors).real.max(axis=-1))


def slowest_rate(damping: Values | float, stiffness: Values | float) -> Values:
    """Return the largest real part of the roots of ``L**2 + 2 damping L + stiffness``."""
    loss, kappa = np.broadcast_arrays(np.asarray(damping, float), np.asarray(stiffness, float))
    frequency = np.sqrt(kappa)
    creeps = loss > frequency
    root = np.sqrt(np.maximum((loss - frequency) * (loss + frequency), 0.0))
    slow = np.divide(kappa, loss + root, out=np.zeros_like(loss), where=creeps)
    return np.where(creeps, -slow, -loss) + 0.0


def checked_whirls(**given: npt.ArrayLike) -> tuple[dict[str, Values], RotorColumns]:
    """Return numbers and arrays of whirls by name, broadcast, and the rotors."""
    arrays = {name: check_array(name, each, largest=LARGEST_NUMBER) for name, each in given.items()}
    try:
        every = dict(zip(arrays, np.broadcast_arrays(*arrays.values()), strict=True))
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays.values() if array.shape)
        raise InputError(
            f"{', '.join(given)} must broadcast, got arrays of shapes {shapes}"
        ) from None
    for name, values in arrays.items():
        if values.size:
            check_axis(name, np.ravel(values))
    rotors = RotorColumns.of(every)
    for exponent in np.unique(rotors.contact_exponent).tolist():
        check_exponent(exponent)
    if (rotors.delta0 == 0.0).any():
        check_clearance_needed(
            {name: float(getattr(rotors, name).max(initial=0.0)) for name in NEED_CLEARANCE}
        )
    return every, rotors


def _eigenvalues(determinant: Values, amplitude: Values, rotors: RotorColumns) -> ComplexValues:
    """Return the eigenvalues in forms that keep the small ones accurate."""
    q, damping, kappa = np.square(rotors.omega), rotors.zeta, rotors.shaft_stiffness
    tangent, secant = stiffnesses(amplitude, rotors.delta0, rotors.contact_exponent)
    # (f' + s + 2 q)**2 - 4 D, with the large terms cancelled by hand
    discriminant = (tangent - secant) ** 2 + 8.0 * q * (tangent + secant)
    discriminant = discriminant - 16.0 * damping**2 * q
    discriminant = discriminant + 16.0 * q * kappa
    both = tangent + secant + 2.0 * q + 2.0 * kappa
    total = both + np.sqrt(discriminant.astype(np.complex128))
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
    eigenvalues = np.stack(found, axis=-1)
    drag = rotors.contact_damping * contact_force(amplitude, rotors.delta0, rotors.contact_exponent)
    mu = rotors.friction
    others = (drag > 0.0) | (mu > 0.0)
    if others.any():
        b = secant + kappa - q
        # contributions of friction to the coefficients of L and L**2
        turns = 2.0 * rotors.omega * mu
        first = turns * (tangent + secant)
        first = first + mu * drag * (2.0 * damping * rotors.omega + mu * secant)
        terms = (
            determinant,
            2.0 * damping * both + drag * b + first,
            2.0 * damping * (2.0 * damping + drag) + both + turns * drag,
            4.0 * damping + drag,
        )
        chosen = [each[others] for each in np.broadcast_arrays(*terms)]
        eigenvalues[others] = _roots_of_quartic(*chosen)
    return eigenvalues


def _roots_of_quartic(*terms: Values) -> ComplexValues:
    """Return the roots of ``L**4 + c3 L**3 + c2 L**2 + c1 L + c0``; the lowest term is first.

    They are eigenvalues of the companion matrix, refined by Newton's method.
    """
    # time units in which all roots are of order 1 or less
    sizes = [np.abs(term) ** (1.0 / (4 - order)) for order, term in enumerate(terms)]
    scale = np.max(sizes, axis=0)
    scaled = [term / scale ** (4 - order) for order, term in enumerate(terms)]
    companion = np.zeros((scale.size, 4, 4))
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[:, :, 3] = -np.stack(scaled, axis=-1)
    roots = np.linalg.eigvals(companion).astype(np.complex128)
    c0, c1, c2, c3 = (each[:, None] for each in scaled)
    for _ in range(2):
        value = c0 + roots * (c1 + roots * (c2 + roots * (c3 + roots)))
        slope = c1 + roots * (2.0 * c2 + roots * (3.0 * c3 + 4.0 * roots))
        step = np.divide(value, slope, out=np.zeros_like(roots), where=slope != 0.0)
        # a step would move two nearly coincident roots far away
        roots = roots - np.where(np.abs(step) < 1e-6, step, 0.0)
    return np.asarray(roots * scale[:, None])
