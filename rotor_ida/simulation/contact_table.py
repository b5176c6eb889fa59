"""The table of contacts: one row for each contact of the rotor with a stator."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values, filled
from rotor_ida.checks import check_instance
from rotor_ida.core.runs import Rows
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.contact import contact_force, contact_potential
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.results.checked_run import is_of_system
from rotor_ida.results.in_si import keeps_si
from rotor_ida.schema import (
    WHIRL_DIRECTION,
    Column,
    check_as_computed,
    labelled_dataset,
    origin_of,
)
from rotor_ida.schema.flags import ENTRY, EXIT
from rotor_ida.simulation.orbit import Orbit, stretches_of_rolling

Columns = dict[str, Column]
# Below this fraction of radius times speed, angular momentum is rounding: there is no whirl.
NO_WHIRL = 1e-12
# A disc that meets the stator at less than this angle from its normal, and turns by less than this
# about the bearing axis in the contact, bounces straight off, in whatever sense [rad].
STRAIGHT = 0.25


def contact_columns(orbit: Orbit) -> Columns:
    """Return the contacts of an orbit as columns on the dimension ``contact``."""
    rotor, contacts = orbit.rotor, orbit.contacts
    at_entry = _states_at(orbit, contacts["entry"], ENTRY)
    at_exit = _states_at(orbit, contacts["exit"], EXIT)
    x, y, vx, vy = at_entry.T
    speed = np.hypot(vx, vy)
    left_with = np.hypot(at_exit[:, 2], at_exit[:, 3])
    columns = {
        "peak_force": peak_forces(orbit),
        "entry_speed": speed,
        "entry_angle": np.arctan2(x * vy - y * vx, x * vx + y * vy),  # positive in forward whirl
        "energy_lost": 0.5 * (speed**2 - left_with**2),
        "whirl_direction": _whirl_direction(orbit, speed),
    }
    if rotor.contact_damping > 0.0:
        columns["contact_loss"] = contacts["lost"]
    if rotor.friction > 0.0:
        columns["heat"] = contacts["heat"]
        columns["slip_distance"] = contacts["slip_distance"]
        columns["rolling_time"] = rolling_times(orbit)
    found = _table_of(contacts, "contact", columns)
    if rotor.delta0 > 0.0:  # one that begins at the very end has no impulse yet
        found["impulse"] = ("contact", filled(contacts["impulse"], 0.0))
    return found


def episode_columns(assembly: Assembly, table: Rows, start: Values, end: Values) -> Columns:
    """Return the contacts of a rotor system along ``episode``, by time of entry.

    `start` and `end` are the displacements at both ends of the run.
    """
    begun = np.where(np.isnan(table["entry"]), -1.0, table["entry"])
    table = table[np.argsort(begun, kind="stable")]
    number = table["contact"].astype(int)
    damped = np.array([each.damping > 0.0 for each in assembly.contacts], bool)
    work = np.where(damped[number], table["work"], 0.0)  # without damping it is rounding
    begins, lasts = np.isnan(table["entry"]), np.isnan(table["exit"])
    columns = {
        "episode_contact": number.astype(np.int16), "peak_force": table["largest_force"],
        "peak_force_time": table["force_time"],
        "energy_lost": np.where(begins | lasts, np.nan, work), "heat": table["heat"],
        "slip_distance": table["slip_distance"], "rolling_time": table["rolling_time"],
    }  # fmt: skip
    if damped.any():
        before, after = ((damped * _elastic_energies(assembly, q))[number] for q in (start, end))
        columns["contact_loss"] = work + begins * before - lasts * after
    return _table_of(table, "episode", columns)


def _elastic_energies(assembly: Assembly, q: Values) -> Values:
    """Return the elastic energy of each contact at some displacement."""
    energies = [0.0] * len(assembly.contacts)
    for number, (contact, rows) in enumerate(zip(assembly.contacts, assembly.rows, strict=True)):
        radius = np.hypot(*(rows @ q - contact.centre))
        energy = contact_potential(radius, contact.clearance, contact.exponent)
        energies[number] = contact.stiffness * float(energy)
    return np.array(energies)


def _table_of(contacts: Rows, dim: str, others: Mapping[str, Values]) -> Columns:
    """Return times, depths and impulses of contacts, and other columns, along a dimension."""
    columns = {
        "entry_time": contacts["entry"], "exit_time": contacts["exit"],
        "peak_time": contacts["peak_time"], "peak_indentation": contacts["peak_root"] ** 2,
        "impulse": contacts["impulse"],
        "contact_duration": contacts["exit"] - contacts["entry"], **others,
    }  # fmt: skip
    return {name: (dim, np.ascontiguousarray(column)) for name, column in columns.items()}


def peak_forces(orbit: Orbit) -> Values:
    """Return the largest force of each contact."""
    rotor = orbit.rotor
    if rotor.contact_damping > 0.0:  # the force peaks before the indentation
        return np.ascontiguousarray(orbit.contacts["largest_force"])
    depth = orbit.contacts["peak_root"] ** 2
    return np.asarray(contact_force(depth, 0.0, rotor.contact_exponent))


@keeps_si
def contact_summary(run: xr.Dataset) -> xr.Dataset:
    """Summarise the contacts of a run: number, duration, force and impulse.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate` or `rotor_ida.run_up`.

    Returns
    -------
    Dataset
        Scalars: ``contact_count``, ``contacts_per_revolution``, ``contact_fraction`` (fraction of
        the time spent in contact), ``largest_force``, ``mean_peak_force``, ``total_impulse``,
        ``impulse_per_revolution``, ``energy_lost_per_revolution``, ``forward_fraction`` (fraction
        of the contacts with forward whirl). With contact damping also ``total_contact_loss``
        and ``contact_loss_per_revolution``, the energy that it dissipates. With friction
        ``total_heat`` and ``heat_per_revolution``, the heat of sliding; ``total_slip_distance``,
        the distance that the surfaces slide; and ``rolling_fraction``, the fraction of the time in
        contact during which the disc rolls on the stator.
        Impulse, loss and heat are those of all the time in contact, kinetic energy that of whole
        contacts: NaN where there are contacts, but no whole one. Values per revolution are NaN at
        ``omega = 0``, means are NaN without contacts, and the impulse is NaN without clearance.

    Raises
    ------
    InputError
        If the dataset is not a run.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=100.0)
    >>> summary = contact_summary(run)
    >>> summary.contact_count.item(), round(summary.contact_fraction.item(), 6)
    (22, 0.867548)
    """
    check_instance("run", run, xr.Dataset)
    if is_of_system(run):
        raise InputError(
            "run must be of one disc, got a run of a rotor system, whose contacts are in its table "
            "of episodes: episode_contact, entry_time, peak_force and so on"
        )
    if "entry_time" not in run or "duration" not in run.attrs:
        raise InputError("run must be a run of simulate, got one without a table of contacts")
    check_as_computed("run", run)
    duration = float(run.attrs["duration"])
    omega = float(run["omega"])
    revolutions = duration * omega / (2.0 * math.pi) if omega > 0.0 else math.nan
    if "revolutions" in run:  # the speed changed
        revolutions = float(run["revolutions"]) or math.nan
    entry = run["entry_time"].fillna(0.0).values
    leaving = run["exit_time"].fillna(duration).values
    force = run["peak_force"].values
    impulse = float(run["impulse"].sum(skipna=False))
    energy = float(run["energy_lost"].sum(min_count=min(force.size, 1)))
    forward = run["whirl_direction"].values == WHIRL_DIRECTION["forward"]
    values = {
        "contact_count": force.size,
        "contacts_per_revolution": force.size / revolutions,
        "contact_fraction": float((leaving - entry).sum()) / duration,
        "largest_force": float(force.max()) if force.size else math.nan,
        "mean_peak_force": float(force.mean()) if force.size else math.nan,
        "total_impulse": impulse,
        "impulse_per_revolution": impulse / revolutions,
        "energy_lost_per_revolution": energy / revolutions,
        "forward_fraction": float(forward.mean()) if force.size else math.nan,
    }
    if "contact_loss" in run:
        loss = float(run["contact_loss"].sum())
        values |= {"total_contact_loss": loss, "contact_loss_per_revolution": loss / revolutions}
    if "heat" in run:
        heat, contact = float(run["heat"].sum()), float((leaving - entry).sum())
        rolled = float(run["rolling_time"].sum())
        values |= {
            "total_heat": heat,
            "heat_per_revolution": heat / revolutions,
            "total_slip_distance": float(run["slip_distance"].sum(skipna=False)),
            "rolling_fraction": rolled / contact if contact > 0.0 else math.nan,
        }
    columns: Columns = {name: ((), value) for name, value in values.items()}
    coordinates = {name: run[name].variable for name in ALL_PARAMETERS if name in run.variables}
    title = "Contacts of one simulated run, summarised"
    return labelled_dataset(title, columns, coordinates, origin_of(run), kind="contact_summary")


def _states_at(orbit: Orbit, times: Values, kind: int) -> Values:
    """Return the state at the event that began or ended each contact, NaN where there is none."""
    states = np.full((times.size, 4), np.nan)
    states[np.isfinite(times)] = orbit.event_states[orbit.event_kinds == kind]
    return states


def _whirl_direction(orbit: Orbit, entry_speed: Values) -> npt.NDArray[np.int8]:
    """Return the sense of the whirl about the bearing axis at the peaks; 0 for straight bounces."""
    contacts, moment = orbit.contacts, orbit.contacts["momentum"]
    if not moment.size:
        return np.empty(0, dtype=np.int8)
    fastest = np.abs(orbit.states[:, 2:]).max(initial=1.0)
    radius = orbit.rotor.delta0 + contacts["peak_root"] ** 2
    around = np.abs(moment) / np.where(radius > 0.0, radius, 1.0)
    began = filled(contacts["entry"], 0.0)
    swept = around * (filled(contacts["exit"], orbit.duration) - began)
    straight = (around < STRAIGHT * entry_speed) & (swept < STRAIGHT * radius)
    whirls = (np.abs(moment) > NO_WHIRL * radius * fastest) & ~straight
    turning = np.where(whirls, np.sign(moment), 0.0)
    return turning.astype(np.int8)


def rolling_times(orbit: Orbit) -> Values:
    """Return for how long the disc rolls in each contact [dimensionless]."""
    began = filled(orbit.contacts["entry"], 0.0)
    ended = filled(orbit.contacts["exit"], orbit.duration)
    rolled = np.zeros(began.size)
    for start, end in stretches_of_rolling(orbit).tolist():
        rolled += np.maximum(np.minimum(end, ended) - np.maximum(start, began), 0.0)
    return rolled
