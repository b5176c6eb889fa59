"""All synchronous whirls of an axisymmetric rotor system, with their stability."""

from __future__ import annotations

from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, ComplexValues, Flags, Values
from rotor_ida.closed_forms.receptances import Receptances, checked_speeds, receptances
from rotor_ida.closed_forms.whirls.at_speeds import MOST_TOUCHING, sliding, whirls_of
from rotor_ida.closed_forms.whirls.refined import refined_growth
from rotor_ida.closed_forms.whirls.turning_axes import (
    NEUTRAL,
    Whirls,
    eigenvalues_in_contact,
    eigenvalues_without_contact,
    normal_forces,
    springs_of,
)
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.axisymmetric import (
    ForwardMotions,
    check_axisymmetric_parts,
    check_masses,
    check_no_races,
    forward_motions,
)
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import STABILITY, labelled_dataset

_REFERENCES = (
    "The forces of a whirl are constant on axes that turn with it: exact for any number of degrees "
    "of freedom"
)


def synchronous_response_system(
    system: RotorSystem,
    *,
    speed: npt.ArrayLike,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute all synchronous whirls of an axisymmetric rotor system, with their stability.

    Parameters
    ----------
    system : RotorSystem
        The rotor, the same in all directions, as are its stators, with contacts without offset
        centres. Without any contact, the result is the unbalance response.
    speed : float or sequence of float, shape (n,)
        Spin speeds.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(speed, branch, contact)``: ``amplitude`` of the displacement at each contact, relative
        to a stator that moves, its ``phase_lag`` in the sense of the spin [rad],
        ``normal_force`` and ``in_contact``; on ``(speed, branch, node)``: ``node_amplitude`` and
        ``node_phase_lag``; on ``(speed, branch)``: ``stability`` and ``growth_rate``. The branches
        are in order of the largest amplitude over its clearance, the contact-free whirl first
        where it exists, padded with NaN.

    Raises
    ------
    InputError
        If an argument cannot be used; if the system is not axisymmetric; if a speed is a resonance
        without damping.

    Notes
    -----
    In complex coordinates ``z = x + i y``, with ``D = K - Omega**2 M + i Omega (C + Omega G)``, the
    rows b of the contacts and the unbalance's force f, let ``U = b D**-1 f`` and
    ``H = b D**-1 b'``. A whirl with the normal forces N, the amplitudes ``A = delta + d`` and the
    directions ``E``, ``|E| = 1``, of the contacts that touch obeys
    ``A E = U - H N (1 + i mu sigma) E``, where sigma is the sign of the speed: the surfaces slide
    forwards. It is exact: forces are constant on axes that turn with the rotor. See `single_rubs`
    and `double_rubs` for how all solutions are isolated. Whirls that touch more than two contacts
    at a time are not sought; ``most_touching`` says so.

    Phases lag the direction that points along x at time 0, as an unbalance of phase 0 does. A
    growth rate is the largest real part of the eigenvalues on turning axes (`turning_axes`).
    Two whirls that nearly coincide at a fold may both be missing.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> whirls = synchronous_response_system(system, speed=[0.5, 0.9, 1.5])
    >>> whirls.amplitude.isel(contact=0).values.round(6)[:, 0]
    array([0.332595, 1.622132, 2.983651])
    """
    system = changed_system(synchronous_response_system, system, changed)
    speeds = checked_speeds(speed)
    assembly = assemble(system)
    check_axisymmetric_parts(assembly)
    check_no_races(assembly)
    check_masses(assembly)
    motions = forward_motions(assembly)
    response = receptances(assembly, speeds)
    whirls = whirls_of(assembly, response, speeds)
    growth, neutral = growth_rates(motions, assembly, speeds, whirls)
    dataset = _dataset(assembly, response, speeds, whirls, growth, neutral)
    return with_system_units(dataset, system)


def growth_rates(
    motions: ForwardMotions, assembly: Assembly, speeds: Values, whirls: Whirls
) -> tuple[Values, Flags]:
    """Return the growth rates of whirls, and which are 0 but for rounding."""
    touches: Flags = np.asarray(whirls.touches.any(axis=1))
    growth, size = np.zeros(touches.size), np.ones(touches.size)
    for chosen in (touches, ~touches):
        part = whirls[chosen]
        at = speeds[part.row]
        if chosen is touches:
            found = eigenvalues_in_contact(motions, assembly.contacts, at, part)
            springs = springs_of(assembly.contacts, at, part)
        else:
            found, springs = eigenvalues_without_contact(motions, at), None
        growth[chosen] = refined_growth(motions, assembly, at, found, springs)
        size[chosen] = np.abs(found).max(axis=1, initial=0.0)
    return growth, np.abs(growth) <= NEUTRAL * size


def _dataset(
    assembly: Assembly,
    response: Receptances,
    speeds: Values,
    whirls: Whirls,
    growth: Values,
    neutral: Flags,
) -> xr.Dataset:
    """Return whirls as a labelled dataset, one column a branch."""
    column = np.arange(whirls.row.size) - np.searchsorted(whirls.row, whirls.row)
    shape = (speeds.size, int(column.max(initial=0)) + 1)

    def spread(values: npt.NDArray[np.generic], missing: float) -> npt.NDArray[np.generic]:
        table = np.full(shape + values.shape[1:], missing, values.dtype)
        table[whirls.row, column] = values
        return table

    stable = np.where(growth > 0.0, STABILITY["unstable"], STABILITY["stable"])
    stable[neutral] = STABILITY["neutral"]
    forces = normal_forces(assembly.contacts, whirls.depth)
    pushed = _contact_forces(assembly, speeds, whirls, forces)
    moved = response.node_free[whirls.row] - np.einsum(
        "wnk,wk->wn", response.node_flexibility[whirls.row], pushed
    )
    spin = np.sign(speeds[whirls.row])[:, np.newaxis]  # the whirl lags in the sense of the spin
    along = ("speed", "branch")
    at_contact, at_node = (*along, "contact"), (*along, "node")
    variables: dict[str, Column] = {
        "amplitude": (at_contact, spread(np.abs(whirls.displacement), np.nan)),
        "phase_lag": (at_contact, spread(-spin * np.angle(whirls.displacement), np.nan)),
        "normal_force": (at_contact, spread(forces, np.nan)),
        "in_contact": (at_contact, spread(whirls.touches.astype(np.int8), 0)),
        "node_amplitude": (at_node, spread(np.abs(moved), np.nan)),
        "node_phase_lag": (at_node, spread(-spin * np.angle(moved), np.nan)),
        "stability": (along, spread(stable.astype(np.int8), STABILITY["absent"])),
        "growth_rate": (along, spread(growth, np.nan)),
        **described_problem(assembly),
    }
    coordinates: dict[str, Column] = {
        "speed": ("speed", speeds), "branch": ("branch", np.arange(shape[1])),
        "node": ("node", np.array(list(assembly.system.nodes), str)),
    }  # fmt: skip
    return labelled_dataset(
        "Synchronous whirls of a rotor system", variables, coordinates,
        {"source": "rotor_ida closed forms", "references": _REFERENCES,
         "most_touching": MOST_TOUCHING},
        kind="system_whirls",
    )  # fmt: skip


def _contact_forces(
    assembly: Assembly, speeds: Values, whirls: Whirls, forces: Values
) -> ComplexValues:
    """Return the complex forces of the contacts against the rotor, shape (whirl, contact)."""
    turned = forces * sliding(assembly.contacts, speeds[whirls.row])
    size = np.abs(whirls.displacement)
    directions = np.divide(
        whirls.displacement, size, out=np.zeros_like(whirls.displacement), where=size > 0.0
    )
    return np.asarray(turned * directions)
