"""The dataset of one run of a rotor system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Flags, Values
from rotor_ida.core.runs import Rows
from rotor_ida.model.assembly import Assembly, Canonical
from rotor_ida.results.provenance import provenance
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import (
    DAMPED_EVENT_KIND,
    OF_FRICTION_EVENT_KIND,
    QUANTITIES,
    Quantity,
    labelled_dataset,
)
from rotor_ida.simulation.contact_table import table_of
from rotor_ida.simulation.systems.following import Followed

# Part of the clearance beyond which a rotor goes round a stator.
AROUND = 0.5


def system_dataset(
    assembly: Assembly,
    found: Canonical,
    followed: Followed,
    times: Values,
    problem: Mapping[str, Column],
    told: Mapping[str, object],
) -> xr.Dataset:
    """Return a run of a rotor system as a labelled dataset."""
    system, result = assembly.system, followed.result
    rows = assembly.node_rows()
    q, v = found.to_q(result.samples[:, 0]), found.to_q(result.samples[:, 1])
    places, velocities = (np.einsum("njk,tk->jtn", rows, each) for each in (q, v))
    event_q = found.to_q(result.event_states)
    kinds = result.event_kinds.astype(np.int8)
    with_race = [race is not None for race in assembly.races]
    races = result.touches["race"][with_race]
    variables: dict[str, Column] = {
        "x": (("t", "node"), places[0]), "y": (("t", "node"), places[1]),
        "vx": (("t", "node"), velocities[0]), "vy": (("t", "node"), velocities[1]),
        "event_time": ("event", result.event_times),
        "event_kind": ("event", kinds),
        "event_contact": ("event", result.event_contacts.astype(np.int16)),
        "event_time_error": ("event", followed.errors.event_time_errors),
        "event_state": (("event", "coordinate"), event_q.reshape(len(kinds), 2 * assembly.size)),
        "horizon": ((), followed.errors.horizon),
        "final_state": ("component", np.concatenate([found.to_q(result.state).ravel(), races])),
        **_standstill(followed),
        **_relative(assembly, q, event_q[:, 0], result.event_contacts),
        **_forces(followed),
        **_episodes(assembly, followed),
        "excursion": ("contact", _excursions(assembly, q, followed)),
        **problem,
    }  # fmt: skip
    if any(with_race):
        variables["event_race_speed"] = (("event", "contact"), result.event_races)
        variables |= _extremes_of_races(result.races, np.array(with_race))
    if "speed" not in told:  # it changes
        variables["angle"] = ("t", result.turns[:, 0])
        variables["speed"] = ("t", result.turns[:, 1])
        variables["event_speed"] = ("event", result.event_turns[:, 1])
        variables["event_angle"] = ("event", result.event_turns[:, 0])
    coordinates: dict[str, Column] = {
        "t": ("t", times),
        "node": ("node", np.array(list(system.nodes), str)),
    }
    if system.positions is not None:
        coordinates["axial_position"] = ("node", np.array(list(system.positions.values())))
    attributes = provenance(told) | {f"energy_{n}": e for n, e in result.ledger.items()}
    dataset = labelled_dataset(
        "Rotor system: one simulated run", variables, coordinates, attributes, kind="system_run"
    )
    flags = {**DAMPED_EVENT_KIND, **OF_FRICTION_EVENT_KIND}
    kind = Quantity(QUANTITIES["event_kind"].long_name, flags=flags)
    dataset["event_kind"].attrs = kind.attributes()
    return with_system_units(dataset, system)


def _standstill(followed: Followed) -> dict[str, Column]:
    """Return since when a rotor that a torque drives has stood, if it turned at first."""
    if followed.result.standstill.limit == 0.0:
        return {}
    return {"standstill_time": ((), followed.standstill),
            "standstill_time_error": ((), followed.standstill_error)}  # fmt: skip


def _extremes_of_races(races: Rows, with_race: Flags) -> dict[str, Column]:
    """Return the extreme speeds of races, and their times."""
    columns = {
        "race_speed_max": races["largest"], "race_speed_max_time": races["largest_time"],
        "race_speed_min": races["smallest"], "race_speed_min_time": races["smallest_time"],
    }  # fmt: skip
    return {name: ("contact", np.where(with_race, each, np.nan)) for name, each in columns.items()}


def _relative(
    assembly: Assembly, q: Values, event_q: Values, contacts: npt.NDArray[np.integer[Any]]
) -> dict[str, Column]:
    """Return displacements from the centre of the stator: of each contact, and at its events."""
    centres = np.array([each.centre for each in assembly.contacts]).reshape(-1, 2)
    places = np.einsum("cjk,tk->jtc", assembly.rows, q) - centres.T[:, np.newaxis]
    at_events = np.einsum("ejk,ek->je", assembly.rows[contacts], event_q) - centres[contacts].T
    along = ("t", "contact")
    return {
        "contact_x": (along, places[0]), "contact_y": (along, places[1]),
        "event_contact_x": ("event", at_events[0]), "event_contact_y": ("event", at_events[1]),
    }  # fmt: skip


def fastest_whirl(assembly: Assembly, q: Values, v: Values) -> float:
    """Return the largest angular speed about a stator, at samples beyond half of the clearance."""
    rates = [0.0]
    for contact, rows in zip(assembly.contacts, assembly.rows, strict=True):
        (x, y), (vx, vy) = (q @ rows.T - contact.centre).T, (v @ rows.T).T
        far = np.hypot(x, y) > AROUND * contact.clearance
        turning = np.abs(x * vy - y * vx)[far] / (x * x + y * y)[far]
        rates.append(float(turning.max(initial=0.0)))
    return max(rates)


def _forces(followed: Followed) -> dict[str, Column]:
    """Return the forces of each contact at samples."""
    forces = followed.result.forces
    along = ("t", "contact")
    return {
        "normal_force": (along, forces[:, :, 0]), "tangential_force": (along, forces[:, :, 1]),
        "slip_speed": (along, forces[:, :, 2]), "mode": (along, forces[:, :, 3].astype(np.int8)),
    }  # fmt: skip


def _excursions(assembly: Assembly, q: Values, followed: Followed) -> Values:
    """Return the largest displacement of each contact over its clearance, at samples and peaks."""
    found = np.empty(len(assembly.contacts))
    table = followed.result.episodes
    for number, contact in enumerate(assembly.contacts):
        places = np.einsum("jk,tk->tj", assembly.rows[number], q) - contact.centre
        peaks = table["peak_root"][table["contact"] == number] ** 2  # CVODE finds none
        radius = np.hypot(*places.T).max()
        found[number] = np.fmax.reduce([radius, *(contact.clearance + peaks)]) / contact.clearance
    return found


def _episodes(assembly: Assembly, followed: Followed) -> dict[str, Column]:
    """Return the table of contacts: one row from each entry to its exit, by time of entry."""
    table = followed.result.episodes
    begun = np.where(np.isnan(table["entry"]), -1.0, table["entry"])
    table = table[np.argsort(begun, kind="stable")]
    number = table["contact"].astype(int)
    lasts = np.isnan(table["entry"]) | np.isnan(table["exit"])
    damped = np.array([each.damping > 0.0 for each in assembly.contacts], bool)[number]
    columns = {
        "episode_contact": number.astype(np.int16), "peak_indentation": table["peak_root"] ** 2,
        "peak_force": table["largest_force"], "peak_force_time": table["force_time"],
        # without damping it is nothing but the rounding of the balance
        "energy_lost": np.where(lasts, np.nan, np.where(damped, table["work"], 0.0)),
        "heat": table["heat"], "slip_distance": table["slip_distance"],
        "rolling_time": table["rolling_time"],
    }  # fmt: skip
    return table_of(table, "episode", columns)
