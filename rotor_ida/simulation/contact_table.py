"""The table of contacts: one row for each time that the rotor is on the ring."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import State, check_instance
from rotor_ida.core.interface import LARGEST_FORCE, PEAK_ROOT
from rotor_ida.errors import InputError
from rotor_ida.model.contact import contact_force
from rotor_ida.model.table import ALL_PARAMETERS
from rotor_ida.schema import (
    WHIRL_DIRECTION,
    Column,
    check_dimensionless,
    labelled_dataset,
    origin_of,
)
from rotor_ida.simulation.orbit import ENTRY, EXIT, Orbit
from rotor_ida.simulation.rubbing import rolling_times, slip_distances

# In an orbit the indentation stands where the core keeps its root.
PEAK_INDENTATION = PEAK_ROOT
# Below this part of radius times speed, angular momentum is rounding: there is no whirl.
NO_WHIRL = 1e-12


def contact_columns(orbit: Orbit, start: State) -> dict[str, Column]:
    """Return the contacts of an orbit from `start` as columns on the dimension ``contact``."""
    contacts = np.ascontiguousarray(orbit.contacts.T)
    entry, leaving, peak_time, indentation, impulse, moment, lost, _, heat = contacts
    rotor = orbit.rotor
    at_entry = _states_at(orbit, entry, ENTRY)
    at_exit = _states_at(orbit, leaving, EXIT)
    speed = np.hypot(at_entry[:, 2], at_entry[:, 3])
    left_with = np.hypot(at_exit[:, 2], at_exit[:, 3])
    columns = {
        "entry_time": entry,
        "exit_time": leaving,
        "peak_time": peak_time,
        "peak_indentation": indentation,
        "peak_force": peak_forces(orbit),
        "contact_duration": leaving - entry,
        "impulse": impulse,
        "entry_speed": speed,
        "entry_angle": _angle_of_incidence(at_entry),
        "energy_lost": 0.5 * (speed**2 - left_with**2),
        "whirl_direction": _whirl_direction(orbit, moment, indentation),
    }
    if rotor.contact_damping > 0.0:
        columns["contact_loss"] = lost
    if rotor.friction > 0.0:
        columns["heat"] = heat
        columns["slip_distance"] = slip_distances(orbit, start)
        columns["rolling_time"] = rolling_times(orbit)
    return {name: ("contact", column) for name, column in columns.items()}


def peak_forces(orbit: Orbit) -> Values:
    """Return the largest force of each contact."""
    rotor = orbit.rotor
    if rotor.contact_damping > 0.0:  # it comes before the largest indentation
        return np.ascontiguousarray(orbit.contacts[:, LARGEST_FORCE])
    indentation = orbit.contacts[:, PEAK_INDENTATION]
    return np.asarray(contact_force(indentation, 0.0, rotor.contact_exponent))


def contact_summary(run: xr.Dataset) -> xr.Dataset:
    """Summarise the contacts of a run: how often, how long and how hard the rotor hits.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate` or `rotor_ida.run_up`.

    Returns
    -------
    Dataset
        Scalars: ``contact_count``, ``contacts_per_revolution``, ``contact_fraction`` (part of the
        time spent in contact), ``largest_force``, ``mean_peak_force``, ``total_impulse``,
        ``impulse_per_revolution``, ``energy_lost_per_revolution``, ``forward_fraction`` (part of
        the contacts whirled through forwards). With contact damping also ``total_contact_loss``
        and ``contact_loss_per_revolution``, the energy that this takes. With friction
        ``total_heat`` and ``heat_per_revolution``, the heat of sliding, ``total_slip_distance``,
        how far the surfaces slide over each other, from the samples and NaN where these are too
        far apart, and ``rolling_fraction``, the part of the time in contact in which the disc rolls
        on the ring. Impulse and kinetic energy
        are those of whole contacts, the loss that of all the time in contact; what counts per
        revolution is NaN at ``omega = 0``, and means are NaN without contacts.

    Raises
    ------
    InputError
        If the dataset is not a run, or in SI units: the summary can be converted.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=100.0)
    >>> summary = contact_summary(run)
    >>> summary.contact_count.item(), round(summary.contact_fraction.item(), 6)
    (22, 0.867548)
    """
    check_instance("run", run, xr.Dataset)
    if "entry_time" not in run or "duration" not in run.attrs:
        raise InputError("contact_summary needs a run of simulate: it has no table of contacts")
    check_dimensionless("run", run)
    duration = float(run.attrs["duration"])
    omega = float(run["omega"])
    revolutions = duration * omega / (2.0 * math.pi) if omega > 0.0 else math.nan
    if "revolutions" in run:  # the speed changed
        revolutions = float(run["revolutions"]) or math.nan
    entry = run["entry_time"].fillna(0.0).values
    leaving = run["exit_time"].fillna(duration).values
    force = run["peak_force"].values
    impulse = float(run["impulse"].sum(skipna=True))
    energy = float(run["energy_lost"].sum(skipna=True))
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
    columns: dict[str, Column] = {name: ((), value) for name, value in values.items()}
    coordinates = {name: run[name].variable for name in ALL_PARAMETERS if name in run.variables}
    title = "Contacts of one simulated run, summarised"
    return labelled_dataset(title, columns, coordinates, origin_of(run), kind="contact_summary")


def _states_at(orbit: Orbit, times: Values, kind: int) -> Values:
    """Return the state at the event that began or ended each contact, NaN where there is none."""
    states = np.full((times.size, 4), np.nan)
    states[np.isfinite(times)] = orbit.event_states[orbit.event_kinds == kind]
    return states


def _angle_of_incidence(states: Values) -> Values:
    """Return the angle between velocity and the ring's normal, positive when turning forwards."""
    x, y, vx, vy = states.T
    return np.asarray(np.arctan2(x * vy - y * vx, x * vx + y * vy))


def _whirl_direction(orbit: Orbit, moment: Values, indentation: Values) -> npt.NDArray[np.int8]:
    """Return the sense in which the rotor goes round the bearing axis at the peaks."""
    if not moment.size:
        return np.empty(0, dtype=np.int8)
    fastest = np.abs(orbit.states[:, 2:]).max(initial=1.0)
    scale = (orbit.rotor.delta0 + indentation) * fastest
    turning = np.where(np.abs(moment) > NO_WHIRL * scale, np.sign(moment), 0.0)
    return turning.astype(np.int8)
