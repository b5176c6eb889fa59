"""Describe a run of a rotor system: what each contact does first, then the events."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.cli.describe import change_of_speed
from rotor_ida.cli.report import pairs, shown, table
from rotor_ida.cli.variables import (
    Description,
    Record,
    Rows,
    rows_table,
    scalars_of,
    show_by_dimension,
    tabled,
    with_unit,
    with_units,
)
from rotor_ida.schema import EVENT_KIND, words_of
from rotor_ida.units import SPEED_UNITS

EVENTS = Rows(
    title="Events", key="events", lead="event_time", prefix="event_",
    names=("event_time", "event_kind", "event_contact", "event_speed", "event_time_error",
           "event_time_shift"),
)  # fmt: skip
EPISODES = Rows(
    title="Episodes of contact", key="episodes", lead="entry_time",
    names=("episode_contact", "entry_time", "exit_time", "peak_indentation", "peak_force", "heat",
           "rolling_time"),
)  # fmt: skip
# The columns of the table of contacts, with the variables whose units they have.
COLUMNS = {
    "contact": "", "node": "", "stator": "", "clearance": "clearance", "entries": "",
    "first_touch": "entry_time", "largest_r_over_clearance": "", "largest_force": "peak_force",
    "rolling_time": "rolling_time", "ends": "",
}  # fmt: skip
# The same of a drop, all of them variables by contact.
OF_DROP = (
    "contact_count", "excursion", "largest_force", "largest_force_time", "largest_impulse", "total_impulse", "total_heat",
    "total_contact_loss", "first_roll_time", "largest_race_speed", "race_speed_time",
    "whirl_turns", "whirl_speed", "rest_time",
)  # fmt: skip
OF_RUN = ("method", "rtol", "modes", "more_modes")


def show_system_run(dataset: xr.Dataset, most: int | None) -> Description:
    """Return contacts, scalars, events and episodes of a run of a rotor system."""
    if not {"contact", "event", "episode"} <= dataset.sizes.keys():  # a part of a run
        return show_by_dimension(dataset, most)
    contacts = [_of_contact(dataset, number) for number in range(dataset.sizes["contact"])]
    touching = [each for each in contacts if not math.isnan(each["first_touch"])]
    first = min(touching, key=lambda each: each["first_touch"], default=None)
    record, parts = tabled(dataset, most, EVENTS, EPISODES)
    record |= {"first_touch": first, "contacts": contacts}
    heads = {name: _with_unit_of(dataset, name, variable) for name, variable in COLUMNS.items()}
    rows: list[Record] = [{heads[name]: each[name] for name in heads} for each in contacts]
    listed = rows_table("Contacts", rows, list(heads.values()), None, digits=6)
    told = pairs("Run", _of_run(dataset))
    return record, [_sentence(dataset, first), *listed, told, *parts]


def show_drop(dataset: xr.Dataset, most: int | None) -> Description:
    """Return what is delivered of a drop by bearing, then what is shown of any run."""
    record, parts = show_system_run(dataset, most)
    if "contact" not in dataset.sizes or not set(OF_DROP) <= dataset.variables.keys():
        return record, parts
    bearings = [
        {"node": str(dataset["contact_node"].values[number])}
        | {name: dataset[name].values[number].item() for name in OF_DROP}
        for number in range(dataset.sizes["contact"])
    ]
    turned: list[Record] = [
        {"quantity": with_unit(dataset, name)}
        | {f"{number}: {each['node']}": each[name] for number, each in enumerate(bearings)}
        for name in OF_DROP
    ]
    drawn = table("Bearings", turned, list(turned[0]), digits=5)
    sentence, *others = parts
    return {**record, "bearings": bearings}, [sentence, drawn, *others]


def _of_contact(run: xr.Dataset, number: int) -> dict[str, Any]:
    """Return what one contact does in a run."""
    own = run.isel(contact=number, episode=run["episode_contact"].values == number)
    kinds = run["event_kind"].values[run["event_contact"].values == number]
    entries = own["entry_time"].values
    forces = np.append(own["peak_force"].values, own["normal_force"].values)
    return {
        "contact": number,
        "node": str(own["contact_node"].values),
        "stator": str(own["contact_stator"].values) or "ground",
        "clearance": float(own["clearance"]),
        "entries": int((kinds == EVENT_KIND["entry"]).sum()),
        # a contact that the run begins with has no time of entry
        "first_touch": float(np.nan_to_num(entries[0])) if entries.size else math.nan,
        "largest_r_over_clearance": float(own["excursion"]),
        "largest_force": float(np.fmax.reduce(forces)),
        "rolling_time": float(own["rolling_time"].sum(skipna=False)),
        "ends": words_of(own["mode"][-1])[0].replace("_", " "),
    }


def _sentence(run: xr.Dataset, first: Record | None) -> str:
    """Return where and when a run touches first."""
    if not run.sizes["contact"]:
        return "The system has no contacts."
    if first is None:
        return "No contact is touched."
    unit = str(run["t"].attrs.get("units", "1")).removeprefix("1")
    time = f"{shown(first['first_touch'])} {unit}".rstrip()
    return f"First touch: contact {first['contact']} at node {first['node']!r}, at {time}."


def _of_run(run: xr.Dataset) -> Record:
    """Return speed, duration, method and sizes of a run, by names with units."""
    si, attributes = run["t"].attrs.get("units") == "s", run.attrs
    told: Record = {}
    if "speed" in attributes:
        speed = float(attributes["speed"])
        told["speed [rad/s]" if si else "speed"] = speed
        if si:
            told["speed [rpm]"] = speed / SPEED_UNITS["rpm"]
    told |= change_of_speed(run)
    if "duration" in attributes:
        told["duration [s]" if si else "duration"] = float(attributes["duration"])
    told |= {name: attributes[name] for name in OF_RUN if name in attributes}
    sizes = {"coordinates": run.sizes["coordinate"] // 2, "events": run.sizes["event"]}
    return told | sizes | with_units(run, scalars_of(run))


def _with_unit_of(run: xr.Dataset, name: str, variable: str) -> str:
    """Return the head of a column, with the unit of a variable."""
    unit = with_unit(run, variable).removeprefix(variable.replace("_", " ")) if variable else ""
    return name.replace("_over_", "/").replace("_", " ") + unit
