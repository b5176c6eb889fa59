"""Every synchronous whirl of a rotor, over whole grids of parameters."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.closed_forms.contacting_whirls import ContactingWhirls, contacting_whirls
from rotor_ida.closed_forms.further_parameters import Further, further_axes
from rotor_ida.closed_forms.linear_whirls import linear_whirls
from rotor_ida.closed_forms.stability import growth_rate
from rotor_ida.schema import STABILITY, labelled_dataset

_POINTS_AT_A_TIME = 16384  # keeps the working arrays inside the processor's cache
SMALLEST_SPEED = 1e-50
_SOURCE = "rotor_ida closed forms: real roots of the amplitude equation, with 32-digit residuals"
_REFERENCES = (
    "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance, "
    "Mechanika 25(6), 2019, eqs (10) and (21)-(23), with the force in its corrected form"
)


def synchronous_response(
    *,
    omega: object,
    zeta: object,
    delta0: object,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return all synchronous whirls, contact-free and contacting, with their stability.

    Parameters
    ----------
    omega, zeta, delta0 : float or sequence of float, shapes (n,), (m,) and (k,)
        Spin speeds, damping ratios and clearances [1].
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `Rotor`, numbers or axes [1].

    Returns
    -------
    Dataset
        On the dimensions (omega, zeta, delta0, branch): ``amplitude`` [1], ``phase_lag``
        [rad], ``stability`` and ``in_contact`` (flags) and ``growth_rate`` [1]. The branches
        are in order of amplitude; where there are fewer than the dimension is long, NaN, the
        flag ``absent``, and 0 for ``in_contact``. Each of the last four parameters that is
        given as a sequence is a dimension before ``branch``, in the order of the arguments; as a
        number that is not the default it is a coordinate.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, is above 1e15, or is
        a speed above zero and below 1e-50; if an exponent is neither 1.5 nor 1; if there is
        contact damping or friction without clearance.

    Notes
    -----
    A whirl ``z = A exp(i (omega t - theta))`` is an exact solution when
    ``A**2 ((kappa + s - omega**2)**2 + 4 zeta**2 omega**2) = omega**4`` with ``s = f(A)/A`` and
    the stiffness kappa of the shaft; ``theta = atan2(2 zeta omega, kappa + s - omega**2)``.
    The contact-free whirl without a shaft, of amplitude
    ``omega/sqrt(omega**2 + 4 zeta**2)``, is neutral, because its centre stays wherever the
    motion left it; at rest (omega = 0) it has amplitude and phase lag 0. A shaft holds the
    centre, and with damping this whirl is then stable. A contacting whirl is stable exactly where
    the determinant of `stability_determinant` is positive; without damping it is neutral there,
    since nothing then decays. Contact damping leaves amplitudes and lags as they are, since the
    indentation of a whirl is constant, but it may take its stability where the whirl lags by more
    than a quarter turn: see `eigenvalues`.

    With friction mu the disc slips forwards on the ring, whatever its radius, and
    ``(kappa A + f - omega**2 A)**2 + (2 zeta omega A + mu f)**2 = omega**4``, where theta is the
    angle whose cosine and sine go with what is squared. Friction too may take a whirl its
    stability where D is positive: at a Hopf point, see `hopf_points`. Without damping it takes it
    from all.

    References
    ----------
    Eqs (10) and (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=[0.0, 1.0])
    >>> whirls.amplitude.sel(omega=1.7, zeta=0.07, delta0=0.0).values.round(4)
    array([1.8796, 6.1932, 9.4872])
    >>> whirls.stability.sel(omega=1.7, zeta=0.07, delta0=1.0).values
    array([2, 1, 0], dtype=int8)
    """
    axes = {
        "omega": check_axis("omega", omega, smallest=SMALLEST_SPEED, largest=LARGEST_NUMBER),
        "zeta": check_axis("zeta", zeta, largest=LARGEST_NUMBER),
        "delta0": check_axis("delta0", delta0, largest=LARGEST_NUMBER),
    }
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
        delta0=axes["delta0"],
    )
    all_axes = list(axes.values()) + ([] if further.default else list(further.axes.values()))
    check_points(*all_axes)
    shape = (*(values.size for values in axes.values()), *further.sizes)
    grid = [part.ravel() for part in np.meshgrid(*all_axes, indexing="ij")]
    parts = [
        _branches(*(values[first : first + _POINTS_AT_A_TIME] for values in grid))
        for first in range(0, grid[0].size, _POINTS_AT_A_TIME)
    ]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    present = max(1, np.isfinite(columns["amplitude"]).sum(axis=1).max())

    dims = ("omega", "zeta", "delta0", *further.dims, "branch")
    return labelled_dataset(
        "Synchronous whirls of a rotor with Hertz contact and clearance"
        if further.default
        else "Synchronous whirls of a rotor with contact and clearance",
        {
            name: (dims, values[:, :present].reshape(*shape, present))
            for name, values in columns.items()
        },
        {name: (name, values) for name, values in axes.items()}
        | further.coordinates
        | {"branch": ("branch", np.arange(present))},
        {"source": _SOURCE, "references": _REFERENCES},
        kind="whirls",
    )


def _branches(
    omega: Values, zeta: Values, delta0: Values, *beyond: Values
) -> dict[str, npt.NDArray[np.generic]]:
    """Return every variable of a flat list of rotors, shape (n, 6), in order of amplitude."""
    turning = omega > 0.0
    further = Further(*beyond) if beyond else None
    contacting = whirls_in_contact(np.where(turning, omega, 1.0), zeta, delta0, further)
    contact_free = contacting.contact_free | ~turning
    free = complex_amplitude(omega, zeta, *beyond[:1])

    touching = np.where(turning[:, None], contacting.amplitude, np.nan)
    amplitude = _side_by_side(np.minimum(np.abs(free), delta0), touching, contact_free)
    lag = _side_by_side(np.abs(np.angle(free)), contacting.phase_lag, contact_free)
    in_contact = _side_by_side(np.zeros_like(omega), np.ones_like(touching), contact_free)
    determinant = _side_by_side(np.ones_like(omega), contacting.determinant, contact_free)

    present = np.isfinite(amplitude)
    touches = in_contact == 1.0
    undamped = zeta == 0.0
    if further is not None:
        undamped = undamped & (further.contact_damping == 0.0)
        driven = undamped & (further.friction > 0.0)
        undamped = undamped & ~driven
    free_growth = _contact_free_growth(turning, zeta, delta0, further)
    resting = np.where(touches, undamped[:, None], (free_growth == 0.0)[:, None])
    neutral = present & (determinant > 0.0) & resting
    growth = np.where(touches | ~present, np.nan, free_growth[:, None])
    growth[neutral] = 0.0
    moving = present & touches & ~neutral
    rows = np.nonzero(moving)[0]
    growth[moving] = growth_rate(
        amplitude[moving],
        determinant[moving],
        omega[rows],
        zeta[rows],
        delta0[rows],
        Further(*(each[rows] for each in beyond)) if beyond else None,
    )

    lasts = determinant > 0.0
    if further is not None:  # contact damping or friction may drive a whirl
        lasts &= ~(growth > 0.0) & ~(touches & driven[:, None])
    stability = np.where(lasts, STABILITY["stable"], STABILITY["unstable"])
    stability[neutral], stability[~present] = STABILITY["neutral"], STABILITY["absent"]
    return {
        "amplitude": amplitude,
        "phase_lag": np.where(present, lag, np.nan),
        "stability": stability.astype(np.int8),
        "in_contact": np.where(present, in_contact, 0.0).astype(np.int8),
        "growth_rate": growth,
    }


def whirls_in_contact(
    omega: Values, zeta: Values, delta0: Values, further: Further | None
) -> ContactingWhirls:
    """Return the contacting whirls under either contact law, with friction or without."""
    if further is None:
        return contacting_whirls(omega, zeta, delta0)
    given = (omega, zeta, delta0, further.shaft_stiffness)
    linear, rubs = further.contact_exponent == 1.0, further.friction > 0.0
    if linear.all() and not rubs.any():
        return linear_whirls(*given)
    found = contacting_whirls(*given)
    for chosen in (linear & ~rubs, ~linear & rubs, linear & rubs):
        if not chosen.any():
            continue
        rows = np.nonzero(chosen)[0]
        here = omega[rows], zeta[rows], delta0[rows], further.shaft_stiffness[rows]
        mu = further.friction[rows] if rubs[rows[0]] else None
        others = linear_whirls(*here, mu) if linear[rows[0]] else contacting_whirls(*here, mu)
        found.amplitude[rows], found.phase_lag[rows] = others.amplitude, others.phase_lag
        found.determinant[rows] = others.determinant
    return found


def _contact_free_growth(
    turning: npt.NDArray[np.bool_], zeta: Values, delta0: Values, further: Further | None
) -> Values:
    """Return the largest real part of ``L**2 + 2 zeta L + kappa = 0``, in the fixed frame."""
    if further is None:
        return np.zeros_like(zeta)
    kappa = further.shaft_stiffness
    # at rest without clearance a linear contact holds the rotor too
    kappa = kappa + (~turning & (delta0 == 0.0) & (further.contact_exponent == 1.0))
    frequency = np.sqrt(kappa)
    creeps = zeta > frequency
    root = np.sqrt(np.maximum((zeta - frequency) * (zeta + frequency), 0.0))
    slow = np.divide(kappa, zeta + root, out=np.zeros_like(zeta), where=creeps)
    return np.where(creeps, -slow, np.where(kappa > 0.0, -zeta, 0.0)) + 0.0


def _side_by_side(free: Values, touching: Values, contact_free: npt.NDArray[np.bool_]) -> Values:
    """Return the contact-free value, where that whirl exists, before the contacting ones."""
    nothing = np.full((len(free), 1), np.nan)
    with_free = np.concatenate([free[:, None], touching], axis=1)
    without = np.concatenate([touching, nothing], axis=1)
    return np.where(contact_free[:, None], with_free, without)
