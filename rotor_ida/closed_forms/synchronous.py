"""All synchronous whirls of one disc, over grids of parameters, or of a rotor system at speeds."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack, cast

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Flags, Values
from rotor_ida.checks import LARGEST_NUMBER
from rotor_ida.closed_forms.contact_free import complex_amplitude, static_sag
from rotor_ida.closed_forms.contacting_whirls import ContactingWhirls, contacting_whirls
from rotor_ida.closed_forms.linear_whirls import linear_whirls
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.closed_forms.stability import growth_rate, slowest_rate
from rotor_ida.closed_forms.unbalance_response import response_of_system
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.system_parameters import AnyAxes
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.schema import STABILITY, labelled_dataset

_POINTS_AT_A_TIME = 16384  # keeps the working arrays inside the processor's cache
SMALLEST_SPEED = 1e-50
UNDER_LOAD = (
    "under a load no whirl in contact is synchronous: the response is linear up to the touch, and "
    "limit_cycle computes the exact cycles beyond it"
)
_SOURCE = "rotor_ida closed forms: real roots of the amplitude equation, with 32-digit residuals"
_REFERENCES = (
    "Analytical Nonlinear Response for a Rotor with the Hertz Contact and Clearance, "
    "Mechanika 25(6), 2019, eqs (10) and (21)-(23), with the force in its corrected form"
)


@takes_rotors(varies=True)
def synchronous_response(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Compute all synchronous whirls, contact-free and contacting, with their stability.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given. The whirls of a
        `RotorSystem` in contact are found where it is the same in all directions, as are its
        stators, with contacts without offset centres and without a load.
    speed : float or array_like, shape (n,)
        Spin speeds of a `RotorSystem`. Those of a `DimensionalRotor` are a parameter of it.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`; all are
        combined. Under a load only the whirl clear of the stator is known. The radius of the disc
        has no effect.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On the dimensions (omega, zeta, delta0, branch): ``amplitude`` [dimensionless],
        ``phase_lag`` [rad], ``stability`` and ``in_contact`` (flags) and ``growth_rate``
        [dimensionless]. The branches are in order of amplitude, padded with NaN, the flag
        ``absent``, and 0 for ``in_contact``. Of the optional parameters, an array becomes a
        dimension before ``branch``, in the order of those of `Rotor`, and a number other than the
        default becomes a coordinate.

        Of any `RotorSystem` its unbalance response without contact: on ``(speed, node)``
        ``node_major_axis`` and ``node_minor_axis`` of the orbit, from peak to peak, the latter
        negative if the orbit is backward, ``node_forward_amplitude`` and
        ``node_backward_amplitude`` of its two circles, with ``node_forward_phase_lag`` and
        ``node_backward_phase_lag``; on ``(speed, contact)`` ``unbalance_radius``, the largest
        distance from the centre of the stator, with the static deflection by a load. On
        ``critical``, for each critical speed between the lowest and the highest speed that
        unbalance drives: ``critical_speed``, ``critical_damping_ratio``, and of the peak near it,
        at the node that moves most: ``peak_node``, ``peak_speed``, ``peak_major_axis`` and
        ``amplification_factor``. Where there are no exact whirls, the attribute ``not_exact`` says
        why.

        Of an axisymmetric `RotorSystem` on ``(speed, branch, contact)``: ``amplitude`` of the
        displacement at each contact, relative to a stator that moves, its ``phase_lag`` in the
        sense of the spin [rad], ``normal_force`` and ``in_contact``; on ``(speed, branch, node)``:
        ``node_amplitude`` and ``node_phase_lag``; on ``(speed, branch)``: ``stability`` and
        ``growth_rate``. The branches are in order of the largest amplitude over its clearance, the
        contact-free whirl first where it exists.

    Raises
    ------
    InputError
        If a value is not a finite real number from 0 to 1e15, or is a speed between 0 and 1e-50; if
        an exponent is neither 1.5 nor 1; if there is contact damping or friction without clearance;
        if a speed of a system is a resonance without damping, or is outside the table of a bearing.

    Notes
    -----
    A whirl ``z = A exp(i (omega t - theta))`` is an exact solution when
    ``A**2 ((kappa + s - omega**2)**2 + 4 zeta**2 omega**2) = omega**4`` with ``s = f(A)/A`` and
    the stiffness kappa of the shaft; ``theta = atan2(2 zeta omega, kappa + s - omega**2)``.
    The contact-free whirl without a shaft, of amplitude ``omega/sqrt(omega**2 + 4 zeta**2)``, is
    neutral, because its centre remains wherever the motion left it; at rest (omega = 0) it has
    amplitude and phase lag 0. A shaft fixes the centre, and with damping this whirl is then stable.
    A contacting whirl is stable exactly where the determinant of `stability_determinant` is
    positive; without damping it is neutral there, since nothing decays. Contact damping does not
    change amplitudes and lags, as the indentation of a whirl is constant. It may destabilise a
    whirl that lags by more than a quarter turn: see `eigenvalues`.

    Under a load gamma the motion clear of the stator is linear: a whirl of the same amplitude about
    the sag ``gamma/kappa`` below the axis. It exists where the two together fit into the clearance.
    Beyond that `limit_cycle` computes the exact motion; the attribute ``not_exact`` says so.

    With friction mu the disc slips forwards on the stator, for any disc radius, and
    ``(kappa A + f - omega**2 A)**2 + (2 zeta omega A + mu f)**2 = omega**4``. The squared terms are
    proportional to the cosine and the sine of theta. Friction too may destabilise a whirl where D
    is positive, at a Hopf point: see `hopf_points`. Without damping it destabilises all of them.

    Of a `RotorSystem`, in complex coordinates ``z = x + i y``, with ``D = K - Omega**2 M + i Omega
    (C + Omega G)``, the rows b of the contacts and the unbalance's force f, let ``U = b D**-1 f``
    and ``H = b D**-1 b'``. A whirl with the normal forces N, the amplitudes ``A = delta + d`` and
    the directions ``E``, ``|E| = 1``, of the contacts that touch obeys ``A E = U - H N (1 + i mu
    sigma) E``, where sigma is the sign of the speed: the surfaces slide forwards. It is exact:
    forces are constant on axes that rotate with the rotor. See `rotor_ida.closed_forms.whirls` for
    how all solutions are isolated. Whirls that touch more than two contacts at a time are not
    sought; ``most_touching`` says so.

    A critical speed is that at which an eigenvalue turns with the rotor, with the coefficients of
    bearings at that speed. The amplification factor is the speed of the peak over its width at
    ``1/sqrt(2)`` of its height, as in `clearance_report`.

    Phases lag the direction that points along x at time 0, as an unbalance of phase 0 does. A
    growth rate is the largest real part of the eigenvalues on rotating axes (`turning_axes`).
    Two whirls that nearly coincide at a fold may both be missing.

    References
    ----------
    Eqs (10) and (21)-(23) of the paper, Mechanika 25(6), 2019, with the force corrected.

    Examples
    --------
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=[0.0, 1.0])
    >>> whirls.amplitude.sel(omega=1.7, zeta=0.07, delta0=0.0).values.round(4)
    array([1.8796, 6.1932, 9.4872])
    >>> whirls.stability.sel(omega=1.7, zeta=0.07, delta0=1.0).values
    array([2, 0, 1], dtype=int8)

    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> whirls = synchronous_response(system, speed=[0.5, 0.9, 1.5])
    >>> whirls.amplitude.isel(contact=0).values.round(6)[:, 0]
    array([0.332595, 1.622132, 2.983651])
    """
    if isinstance(rotor, RotorSystem):
        changed = cast("SystemParameters", varied)
        return response_of_system(changed_system(synchronous_response, rotor, changed), speed)
    ranges = {"omega": (SMALLEST_SPEED, LARGEST_NUMBER)}
    asked = whirls_asked(synchronous_response, rotor, varied, ranges, under_load=True)
    grid = RotorColumns.of(asked.columns)
    parts = [
        _branches(grid[first : first + _POINTS_AT_A_TIME])
        for first in range(0, asked.points, _POINTS_AT_A_TIME)
    ]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    present = max(1, np.isfinite(columns["amplitude"]).sum(axis=1).max())

    dims = (*asked.dims, "branch")
    contact = "contact" if asked.optional else "Hertz contact"
    return labelled_dataset(
        f"Synchronous whirls of a rotor with {contact} and clearance",
        {
            name: (dims, values[:, :present].reshape(*asked.shape, present))
            for name, values in columns.items()
        },
        asked.coordinates | {"branch": ("branch", np.arange(present))},
        {"source": _SOURCE, "references": _REFERENCES} | why_linear_alone(grid),
        kind="whirls",
    )


def why_linear_alone(rotors: RotorColumns) -> dict[str, object]:
    """Return, as an attribute, why no whirl in contact is known under a load; none without one."""
    loaded = rotors.load > 0.0
    if not loaded.any():
        return {}
    rests = (static_sag(rotors.load, rotors.shaft_stiffness) >= rotors.delta0)[loaded]
    if not rests.any():
        return {"not_exact": UNDER_LOAD}
    where = "" if rests.all() else "in a part of the cases "
    return {"not_exact": f"{UNDER_LOAD}; {where}the sag alone lays the rotor on the stator"}


def _branches(rotors: RotorColumns) -> dict[str, npt.NDArray[np.generic]]:
    """Return every variable of a flat list of rotors, shape (n, 6), in order of amplitude."""
    omega, zeta, delta0 = rotors.omega, rotors.zeta, rotors.delta0
    turning = omega > 0.0
    contacting = whirls_in_contact(replace(rotors, omega=np.where(turning, omega, 1.0)))
    free = complex_amplitude(omega, zeta, rotors.shaft_stiffness)
    loaded, sag = rotors.load > 0.0, static_sag(rotors.load, rotors.shaft_stiffness)
    contact_free = np.where(
        loaded, sag + np.abs(free) <= delta0, contacting.contact_free | ~turning
    )

    touching = np.where((turning & ~loaded)[:, None], contacting.amplitude, np.nan)
    amplitude = _side_by_side(np.minimum(np.abs(free), delta0), touching, contact_free)
    lag = _side_by_side(np.abs(np.angle(free)), contacting.phase_lag, contact_free)
    in_contact = _side_by_side(np.zeros_like(omega), np.ones_like(touching), contact_free)
    determinant = _side_by_side(np.ones_like(omega), contacting.determinant, contact_free)

    present, touches = np.isfinite(amplitude), in_contact == 1.0
    growth, driven = _growth_rates(rotors, amplitude, determinant, touches)
    lasts = (determinant > 0.0) & ~(growth > 0.0) & ~driven
    stability = np.where(lasts, STABILITY["stable"], STABILITY["unstable"])
    stability[lasts & (growth == 0.0)] = STABILITY["neutral"]
    stability[~present] = STABILITY["absent"]
    return {
        "amplitude": amplitude,
        "phase_lag": np.where(present, lag, np.nan),
        "stability": stability.astype(np.int8),
        "in_contact": np.where(present, in_contact, 0.0).astype(np.int8),
        "growth_rate": growth,
    }


def _growth_rates(
    rotors: RotorColumns, amplitude: Values, determinant: Values, touches: Flags
) -> tuple[Values, Flags]:
    """Return the largest real parts of the eigenvalues, and where only friction drives a whirl."""
    lossless = (rotors.zeta == 0.0) & (rotors.contact_damping == 0.0)
    present = np.isfinite(amplitude)
    touches = touches & present
    driven = touches & (lossless & (rotors.friction > 0.0))[:, None]
    growth = np.where(present & ~touches, _contact_free_growth(rotors)[:, None], np.nan)
    growth[touches & lossless[:, None] & ~driven & (determinant > 0.0)] = 0.0
    moving = touches & np.isnan(growth)
    rows = np.nonzero(moving)[0]
    growth[moving] = growth_rate(amplitude[moving], determinant[moving], rotors[rows])
    return growth, driven


def whirls_in_contact(rotors: RotorColumns) -> ContactingWhirls:
    """Return the contacting whirls of rotors with ``omega > 0``, for either contact law."""
    linear = rotors.contact_exponent == 1.0
    if linear.all():
        return linear_whirls(rotors)
    if not linear.any():
        return contacting_whirls(rotors)
    found = contacting_whirls(rotors)
    others = linear_whirls(rotors[linear])
    found.amplitude[linear], found.phase_lag[linear] = others.amplitude, others.phase_lag
    found.determinant[linear] = others.determinant
    return found


def _contact_free_growth(rotors: RotorColumns) -> Values:
    """Return the largest real part of ``L**2 + 2 zeta L + kappa = 0``, in the fixed frame."""
    # at rest without clearance a linear contact centres the rotor too
    at_rest = (rotors.omega == 0.0) & (rotors.delta0 == 0.0)
    kappa = rotors.shaft_stiffness + (at_rest & (rotors.contact_exponent == 1.0))
    return slowest_rate(rotors.zeta, kappa)


def _side_by_side(free: Values, touching: Values, contact_free: Flags) -> Values:
    """Return the contact-free value, if that whirl exists, before the contacting ones."""
    nothing = np.full((len(free), 1), np.nan)
    with_free = np.concatenate([free[:, None], touching], axis=1)
    without = np.concatenate([touching, nothing], axis=1)
    return np.where(contact_free[:, None], with_free, without)
