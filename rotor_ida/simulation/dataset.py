"""The dataset of one simulated run, of one disc or of a rotor system."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Flags, Values
from rotor_ida.checks import COMPONENTS, State
from rotor_ida.core.runs import SPIN, Rows
from rotor_ida.model.assembly import Assembly, Canonical
from rotor_ida.model.contact import clipped_factor, contact_force
from rotor_ida.results.archived_system import problem_variables
from rotor_ida.results.checked_run import event_columns, kinds_of_events, parameter_coordinates
from rotor_ida.results.provenance import provenance
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import DAMPED_EVENT_KIND, OF_FRICTION_EVENT_KIND, labelled_dataset
from rotor_ida.schema.flags import FLIES, IS_LOOSE, ROLLS
from rotor_ida.simulation.contact_table import Columns, contact_columns, episode_columns
from rotor_ida.simulation.event_errors import EventErrors
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.system_run import Followed

# Part of the clearance beyond which a rotor goes round a stator.
AROUND = 0.5


def _events(
    times: Values, kinds: npt.NDArray[Any], errors: EventErrors, flags: Mapping[str, int]
) -> dict[str, Column | xr.Variable]:
    """Return times and kinds of events, with the errors of the times."""
    return {
        **event_columns(times, kinds, flags),
        "event_time_error": ("event", errors.event_time_errors),
        "horizon": ((), errors.horizon),
    }


def _spins(samples: Rows, events: Rows) -> Columns:
    """Return speed and angle of the unbalance at samples and at events, if the speed changes."""
    return {
        f"{prefix}{name}": (dim, np.ascontiguousarray(spins[name]))
        for prefix, dim, spins in (("", "t", samples), ("event_", "event", events))
        for name in ("speed", "angle")
    }


# ---- Of one disc ----


def run_dataset(
    orbit: Orbit,
    start: State,
    errors: EventErrors,
    changes: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """Return a simulated orbit as a labelled dataset.

    Parameters
    ----------
    orbit : Orbit
        The orbit.
    start : tuple of float
        Its start ``(x, y, vx, vy)`` [dimensionless].
    errors : EventErrors
        Errors of its events.
    changes : mapping, optional
        The requested change of speed, as attributes.
    """
    motion = motion_columns(orbit)
    variables: dict[str, Column | xr.Variable] = {
        **{name: motion[name] for name in COMPONENTS},
        "starts_in_contact": ((), np.int8(orbit.starts_in_contact)),
        **_events(orbit.event_times, orbit.event_kinds, errors, kinds_of_events(orbit.rotor)),
        **_columns("event_", "event", orbit.event_states),
        **motion,
    }
    coordinates = parameter_coordinates(orbit.rotor) | {"t": ("t", orbit.times)}
    attributes = provenance(orbit.options.attributes()) | {
        **orbit.rotor.given,
        "start": np.array(start),
        "duration": orbit.duration,
        "evaluations": orbit.evaluations,
        **(changes or {}),
    }
    title = "Rotor in a clearance: one simulated run"
    if orbit.speed_record is not None:
        title = "Rotor in a clearance: one run at a speed that changes"
    return labelled_dataset(title, variables, coordinates, attributes, kind="run")


def motion_columns(orbit: Orbit) -> Columns:
    """Return the samples of an orbit, with how fast it spins, and its contacts."""
    record = orbit.speed_record
    columns = {
        **_columns("", "t", orbit.states),
        **contact_columns(orbit),
        **_friction(orbit),
    }
    if record is not None:
        columns |= _spins(record.samples, record.events)
        columns["revolutions"] = ((), record.end["angle"] / (2.0 * math.pi))
    return columns


def arrays_of(orbit: Orbit) -> dict[str, npt.NDArray[Any]]:
    """Return samples, events and contacts of an orbit by their names in its dataset."""
    columns: dict[str, npt.NDArray[Any]] = {
        name: np.asarray(each[1]) for name, each in motion_columns(orbit).items()
    }
    columns |= {"event_time": orbit.event_times, "event_kind": orbit.event_kinds}
    return {"t": orbit.times, **columns}


def _friction(orbit: Orbit) -> Columns:
    """Return how the rotor moves at each sample, its slip speed and its normal force."""
    if orbit.modes is None:
        return {}
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.states.T
    modes = orbit.modes[np.searchsorted(orbit.event_times, orbit.times, side="right")]
    radius = np.hypot(x, y)
    along, across = (
        np.divide(part, radius, out=np.zeros_like(radius), where=radius > 0.0)
        for part in (x * vx + y * vy, x * vy - y * vx)
    )
    spring = contact_force(radius, rotor.delta0, rotor.contact_exponent)
    pushes = (modes != FLIES) & (modes != IS_LOOSE)
    force = np.where(pushes, spring * clipped_factor(along, rotor.contact_damping), 0.0)
    slip = np.where(modes == ROLLS, 0.0, across + (rotor.disc_radius or 0.0) * orbit.speeds)
    return {"mode": ("t", modes), "slip_speed": ("t", slip), "normal_force": ("t", force)}


def _columns(prefix: str, dim: str, table: Values) -> Columns:
    columns = np.ascontiguousarray(table.T)
    return {
        f"{prefix}{name}": (dim, column) for name, column in zip(COMPONENTS, columns, strict=True)
    }


# ---- Of a rotor system ----


def system_dataset(
    assembly: Assembly,
    found: Canonical,
    followed: Followed,
    start: Values,
    times: Values,
    told: Mapping[str, object],
    shifts: Values | None,
) -> xr.Dataset:
    """Return a run of a rotor system as a labelled dataset; see `run_of_cases`."""
    system, result = assembly.system, followed.result
    rows = assembly.node_rows()
    q, v = found.to_q(result.samples[:, 0]), found.to_q(result.samples[:, 1])
    (x, y), (vx, vy) = (np.einsum("njk,tk->jtn", rows, each) for each in (q, v))
    event_q, ends = found.to_q(result.event_states), found.to_q(result.state)
    with_race = np.array([race is not None for race in assembly.races], bool)
    flags = {**DAMPED_EVENT_KIND, **OF_FRICTION_EVENT_KIND}
    forces, along = result.forces, ("t", "contact")
    variables: dict[str, Column | xr.Variable] = {
        **{name: (("t", "node"), each)
           for name, each in zip(COMPONENTS, (x, y, vx, vy), strict=True)},
        **_events(result.event_times, result.event_kinds.astype(np.int8), followed.errors, flags),
        "event_contact": ("event", result.event_contacts.astype(np.int16)),
        "event_state": (("event", "coordinate"), event_q.reshape(-1, 2 * assembly.size)),
        "final_state": ("component", np.append(ends.ravel(), result.touches["race"][with_race])),
        **_relative(assembly, q, event_q[:, 0], result.event_contacts),
        "normal_force": (along, forces[:, :, 0]), "tangential_force": (along, forces[:, :, 1]),
        "slip_speed": (along, forces[:, :, 2]), "mode": (along, forces[:, :, 3].astype(np.int8)),
        **episode_columns(assembly, result.episodes, start[0], ends[0]),
        "excursion": ("contact", _excursions(assembly, q, result.extrema)),
        **problem_variables(assembly, start),
    }  # fmt: skip
    if shifts is not None:
        variables["event_time_shift"] = ("event", shifts)
    if result.standstill.limit > 0.0:  # a torque drives a rotor that turned at first
        variables["standstill_time"] = ((), followed.standstill)
        variables["standstill_time_error"] = ((), followed.standstill_error)
    if with_race.any():
        variables["event_race_speed"] = (("event", "contact"), result.event_races)
        variables |= _extremes_of_races(result.races, with_race)
    if "speed" not in told:  # it changes
        samples, events = (
            np.ascontiguousarray(each).view(SPIN)[:, 0]
            for each in (result.turns, result.event_turns)
        )
        variables |= _spins(samples, events)
    coordinates: Columns = {
        "t": ("t", times),
        "node": ("node", np.array(list(system.nodes), str)),
    }
    if system.positions is not None:
        coordinates["axial_position"] = ("node", np.array(list(system.positions.values())))
    attributes = provenance(told) | {f"energy_{n}": e for n, e in result.ledger.items()}
    dataset = labelled_dataset(
        "Rotor system: one simulated run", variables, coordinates, attributes, kind="system_run"
    )
    return with_system_units(dataset, system)


def _extremes_of_races(races: Rows, with_race: Flags) -> Columns:
    """Return the extreme speeds of races, and their times."""
    columns = {
        "race_speed_max": races["largest"], "race_speed_max_time": races["largest_time"],
        "race_speed_min": races["smallest"], "race_speed_min_time": races["smallest_time"],
    }  # fmt: skip
    return {name: ("contact", np.where(with_race, each, np.nan)) for name, each in columns.items()}


def _relative(
    assembly: Assembly, q: Values, event_q: Values, contacts: npt.NDArray[np.integer[Any]]
) -> Columns:
    """Return displacements from the centre of the stator: of each contact, and at its events."""
    centres = np.array([each.centre for each in assembly.contacts]).reshape(-1, 2)
    places = np.einsum("cjk,tk->jtc", assembly.rows, q) - centres.T[:, np.newaxis]
    at_events = np.einsum("ejk,ek->je", assembly.rows[contacts], event_q) - centres[contacts].T
    along = ("t", "contact")
    return {
        "contact_x": (along, places[0]), "contact_y": (along, places[1]),
        "event_contact_x": ("event", at_events[0]), "event_contact_y": ("event", at_events[1]),
    }  # fmt: skip


def fastest_whirl(assembly: Assembly, rows: Values, samples: Values) -> float:
    """Return the largest angular speed about a stator, at samples beyond half of the clearance."""
    rates = [0.0]
    for contact, row in zip(assembly.contacts, rows, strict=True):
        (x, y), (vx, vy) = np.einsum("jk,tdk->djt", row, samples)
        x, y = x - contact.centre[0], y - contact.centre[1]
        squares = x * x + y * y
        far = squares > (AROUND * contact.clearance) ** 2
        turning = np.abs(x * vy - y * vx)[far] / squares[far]
        rates.append(float(turning.max(initial=0.0)))
    return max(rates)


def _excursions(assembly: Assembly, q: Values, extrema: Rows) -> Values:
    """Return the largest displacement of each contact over its clearance; NaN without clearance.

    The reference simulator knows it at samples alone.
    """
    found = np.full(len(assembly.contacts), np.nan)
    for number, contact in enumerate(assembly.contacts):
        places = np.einsum("jk,tk->tj", assembly.rows[number], q) - contact.centre
        peaks = extrema["distance"][extrema["place"] == number]
        if contact.clearance > 0.0:
            found[number] = max(np.hypot(*places.T).max(), peaks.max(initial=0.0))
            found[number] /= contact.clearance
    return found
