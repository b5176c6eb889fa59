"""All synchronous whirls of an axisymmetric rotor system, with their stability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, ComplexValues, Flags, Values
from rotor_ida.closed_forms.receptances import Receptances, checked_speeds, receptances
from rotor_ida.closed_forms.whirls.at_speeds import MOST_TOUCHING, sliding, whirls_of
from rotor_ida.closed_forms.whirls.turning_axes import (
    NEUTRAL,
    Whirls,
    eigenvalues_in_contact,
    eigenvalues_without_contact,
    normal_forces,
)
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.axisymmetric import (
    ForwardMotions,
    check_axisymmetric_parts,
    check_masses,
    check_no_races,
    forward_motions,
)
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, check_clearances
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import STABILITY, labelled_dataset

_REFERENCES = (
    "The forces of a whirl are constant on axes that rotate with it: exact for any number of "
    "degrees of freedom"
)


def whirls_of_system(system: RotorSystem, speed: npt.ArrayLike | None) -> xr.Dataset:
    """Return all synchronous whirls of a rotor system: see `rotor_ida.synchronous_response`."""
    speeds = checked_speeds(speed)
    assembly = assemble(system, speeds=speeds)
    check_axisymmetric_parts(assembly)
    check_no_races(assembly)
    check_clearances(assembly.contacts)
    check_masses(assembly)
    motions = forward_motions(assembly)
    response = receptances(assembly, speeds)
    whirls = whirls_of(assembly, response, speeds)
    growth, neutral = growth_rates(motions, assembly.contacts, speeds, whirls)
    dataset = _dataset(assembly, response, speeds, whirls, growth, neutral)
    return with_system_units(dataset, system)


def growth_rates(
    motions: ForwardMotions, contacts: Sequence[Contact], speeds: Values, whirls: Whirls
) -> tuple[Values, Flags]:
    """Return the growth rates of whirls, and which are 0 but for rounding."""
    touches: Flags = np.asarray(whirls.touches.any(axis=1))
    growth, size = np.zeros(touches.size), np.ones(touches.size)
    for chosen in (touches, ~touches):
        part = whirls[chosen]
        at = speeds[part.row]
        if chosen is touches:
            found = eigenvalues_in_contact(motions, contacts, at, part)
        else:
            found = eigenvalues_without_contact(motions, at)
        growth[chosen] = found.real.max(axis=1, initial=-np.inf)
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
