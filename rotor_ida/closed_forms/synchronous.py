"""Every synchronous whirl of a rotor, over whole grids of parameters."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points
from rotor_ida.closed_forms.contacting_whirls import contacting_whirls
from rotor_ida.closed_forms.stability import growth_rate
from rotor_ida.schema import CONVENTIONS, STABILITY, labelled

Values = npt.NDArray[np.float64]
Columns = dict[str, npt.NDArray[np.generic]]

_POINTS_AT_A_TIME = 16384  # keeps the working arrays inside the processor's cache
_SMALLEST_SPEED = 1e-50
_SOURCE = "rotor_ida closed forms: real roots of the amplitude equation, with 32-digit residuals"
_REFERENCES = (
    "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance, "
    "Mechanika 25(6), 2019, eqs (10) and (21)-(23), with the force in its corrected form"
)


def synchronous_response(*, omega: object, zeta: object, delta0: object) -> xr.Dataset:
    """Return all synchronous whirls, contact-free and contacting, with their stability.

    Parameters
    ----------
    omega : float or sequence of float, shape (n,)
        Spin speeds [1].
    zeta : float or sequence of float, shape (m,)
        Damping ratios [1].
    delta0 : float or sequence of float, shape (k,)
        Clearances [1].

    Returns
    -------
    Dataset
        On the dimensions (omega, zeta, delta0, branch): ``amplitude`` [1], ``phase_lag``
        [rad], ``stability`` and ``in_contact`` (flags) and ``growth_rate`` [1]. The branches
        are in order of amplitude; where there are fewer than the dimension is long, NaN, the
        flag ``absent``, and 0 for ``in_contact``.

    Raises
    ------
    InputError
        If a value is not a finite real number that is zero or positive, is above 1e15, or is
        a speed above zero and below 1e-50.

    Notes
    -----
    A whirl ``z = A exp(i (omega t - theta))`` is an exact solution when
    ``A**2 ((s - omega**2)**2 + 4 zeta**2 omega**2) = omega**4`` with ``s = f(A)/A``;
    ``theta = atan2(2 zeta omega, s - omega**2)``. The contact-free whirl of amplitude
    ``omega/sqrt(omega**2 + 4 zeta**2)`` is neutral, because its centre stays wherever the
    motion left it; at rest (omega = 0) it has amplitude and phase lag 0. A contacting whirl is
    stable exactly where the determinant of `stability_determinant` is positive; without
    damping it is neutral there, since nothing then decays.

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
        "omega": check_axis("omega", omega, smallest=_SMALLEST_SPEED, largest=LARGEST_NUMBER),
        "zeta": check_axis("zeta", zeta, largest=LARGEST_NUMBER),
        "delta0": check_axis("delta0", delta0, largest=LARGEST_NUMBER),
    }
    check_points(*axes.values())
    shape = tuple(values.size for values in axes.values())
    grid = [part.ravel() for part in np.meshgrid(*axes.values(), indexing="ij")]
    parts = [
        _branches(*(values[first : first + _POINTS_AT_A_TIME] for values in grid))
        for first in range(0, grid[0].size, _POINTS_AT_A_TIME)
    ]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    present = np.isfinite(columns["amplitude"]).sum(axis=1).max()

    dims = ("omega", "zeta", "delta0", "branch")
    coords = {name: labelled(name, name, values) for name, values in axes.items()}
    coords["branch"] = labelled("branch", "branch", np.arange(present))
    variables = {
        name: labelled(name, dims, values[:, :present].reshape(*shape, present))
        for name, values in columns.items()
    }
    attributes = {
        "Conventions": CONVENTIONS,
        "title": "Synchronous whirls of a rotor with Hertz contact and clearance",
        "source": _SOURCE,
        "references": _REFERENCES,
    }
    return xr.Dataset(variables, coords, attributes)


def _branches(omega: Values, zeta: Values, delta0: Values) -> Columns:
    """Return every variable of a flat list of rotors, shape (n, 6), in order of amplitude."""
    turning = omega > 0.0
    contacting = contacting_whirls(np.where(turning, omega, 1.0), zeta, delta0)
    contact_free = contacting.contact_free | ~turning
    free_amplitude, free_lag = _contact_free(omega, zeta, delta0)

    touching = np.where(turning[:, None], contacting.amplitude, np.nan)
    amplitude = _side_by_side(free_amplitude, touching, contact_free)
    lag = _side_by_side(free_lag, contacting.phase_lag, contact_free)
    in_contact = _side_by_side(np.zeros_like(omega), np.ones_like(touching), contact_free)
    determinant = _side_by_side(np.ones_like(omega), contacting.determinant, contact_free)

    present = np.isfinite(amplitude)
    undamped = (zeta == 0.0)[:, None]
    neutral = present & (determinant > 0.0) & (undamped | (in_contact == 0.0))
    stability = np.full(amplitude.shape, STABILITY["absent"], dtype=np.int8)
    stability[present] = np.where(determinant > 0.0, STABILITY["stable"], STABILITY["unstable"])[
        present
    ]
    stability[neutral] = STABILITY["neutral"]

    growth = np.where(neutral, 0.0, np.nan)
    moving = present & ~neutral
    rows = np.nonzero(moving)[0]
    growth[moving] = growth_rate(
        amplitude[moving], determinant[moving], omega[rows], zeta[rows], delta0[rows]
    )
    return {
        "amplitude": amplitude,
        "phase_lag": np.where(present, lag, np.nan),
        "stability": stability,
        "in_contact": np.where(present, in_contact, 0.0).astype(np.int8),
        "growth_rate": growth,
    }


def _contact_free(omega: Values, zeta: Values, delta0: Values) -> tuple[Values, Values]:
    """Return amplitude, never beyond the clearance by rounding, and phase lag."""
    turning = omega > 0.0
    resistance = np.hypot(omega, 2.0 * zeta)
    amplitude = np.divide(omega, resistance, out=np.zeros_like(omega), where=turning)
    lag = np.where(turning, np.arctan2(2.0 * zeta, -omega), 0.0)
    return np.minimum(amplitude, delta0), lag


def _side_by_side(free: Values, touching: Values, contact_free: npt.NDArray[np.bool_]) -> Values:
    """Return the contact-free value, where that whirl exists, before the contacting ones."""
    nothing = np.full((len(free), 1), np.nan)
    with_free = np.concatenate([free[:, None], touching], axis=1)
    without = np.concatenate([touching, nothing], axis=1)
    return np.where(contact_free[:, None], with_free, without)
