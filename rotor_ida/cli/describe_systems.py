"""Describe runs of a rotor system, what each contact does first, and sweeps, point by point."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.cli.describe import EVENTS, count_of_kinds, facts_of_run, touched
from rotor_ida.cli.drop_tables import drops_tables, of_bearings
from rotor_ida.cli.variables import (
    Description,
    Record,
    Rows,
    line_of,
    names_on,
    rows_of,
    tabled,
)
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.results.question import STATE
from rotor_ida.results.sheets import Sheet, facts
from rotor_ida.schema import EVENT_KIND, OF_BEARING, QUANTITIES, words_of
from rotor_ida.units import quantity

EPISODES = Rows(
    title="Episodes of contact", key="episodes", lead="entry_time",
    names=("episode_contact", "entry_time", "exit_time", "peak_indentation", "peak_force", "heat",
           "rolling_time"),
)  # fmt: skip
RESPONSES = Rows(
    title="Responses", key="responses", lead="response", digits=6, on_request=True,
    names=("response", "speed", *PARAMETERS_OF_SYSTEM, "start", "direction", "excursion",
           "largest_force", "period", "lyapunov_exponent", "lyapunov_error", "revolutions",
           "cycle_distance", "status", "message"),
)  # fmt: skip
# Dimensions of a settled response by which it is too long for a row.
OF_MOTION = ("contact", "node", "component")
OF_KINDS = ("speed", *PARAMETERS_OF_SYSTEM, "excursion", "largest_force")
# Statistics of each figure of a bearing: of a random sample, and of a grid.
OF_SAMPLE = ("mean", "mean_low", "mean_high", "quantile", "quantile_low", "quantile_high")
OF_GRID = ("min", "min_drop", "max", "max_drop", "mean", "mean_change")
DROPS = Rows(
    title="Drops", key="drops", lead="drop",
    names=("drop_phase", "first_touch_time", "horizon", "standstill_time", "message"),
)  # fmt: skip
# The columns of the table of contacts, with the variables whose units they have.
COLUMNS = {
    "contact": "", "node": "", "stator": "", "clearance": "clearance", "entries": "",
    "first_touch": "entry_time", "largest_r_over_clearance": "", "largest_force": "peak_force",
    "rolling_time": "rolling_time", "ends": "",
}  # fmt: skip


def show_system_run(dataset: xr.Dataset, most: int | None) -> Description:
    """Return contacts, scalars, events and episodes of a run of a rotor system."""
    contacts = [_of_contact(dataset, number) for number in range(dataset.sizes["contact"])]
    touching = [each for each in contacts if not math.isnan(each["first_touch"])]
    first = min(touching, key=lambda each: each["first_touch"], default=None)
    record, parts = tabled(dataset, most, EVENTS, EPISODES)
    record |= {"first_touch": first, "contacts": contacts}
    lines = [
        replace(
            line_of(dataset, variable, [each[name] for each in contacts], 6),
            name=name.replace("_over_", "/").replace("_", " "),
        )
        for name, variable in COLUMNS.items()
    ]
    return record, [
        _sentence(dataset, contacts, first),
        *_start_in_words(dataset),
        Sheet(f"Contacts: {len(contacts)}", lines) if contacts else "Contacts: none",
        facts("Run", facts_of_run(dataset)),
        *parts,
    ]


def show_system_sweep(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the responses of a sweep, with their number by kind, and the worst of all contacts."""
    told, contacts = worst_of_contacts(dataset)
    record, parts = tabled(told, most, RESPONSES)
    return record | contacts, [count_of_kinds(told, OF_KINDS), *parts]


def worst_of_contacts(dataset: xr.Dataset) -> tuple[xr.Dataset, Record]:
    """Return settled responses with the worst of all contacts, and the contacts as a record."""
    gaps = clearance_of_contacts(dataset)
    worst = {"excursion": dataset["radius_max"] / gaps, "largest_force": dataset["largest_force"]}
    told = dataset.drop_dims([dim for dim in OF_MOTION if dim in dataset.dims])
    if dataset.sizes["contact"]:
        told = told.assign({name: each.max("contact") for name, each in worst.items()})
        told["excursion"].attrs = QUANTITIES["excursion"].attributes()
        told["largest_force"].attrs = dataset["largest_force"].attrs
    return told, {"contacts": rows_of(dataset, (str(gaps.name), "contact_node"))}


def show_drop(dataset: xr.Dataset, most: int | None) -> Description:
    """Return what is delivered of a drop by bearing, then what is shown of any run."""
    record, parts = show_system_run(dataset, most)
    names = [name for name in (*OF_BEARING, "load_ratio") if name in dataset]
    bearings = rows_of(dataset, ["contact_node", *names])
    bearings = [{"node": each.pop("contact_node"), **each} for each in bearings]
    sentence, *others = parts
    return {**record, "bearings": bearings}, [sentence, of_bearings(dataset), *others]


def show_drops(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the statistics of many drops by bearing, the cells of a grid, and the drops."""
    is_grid = "cell" in dataset.sizes
    ends = OF_GRID if is_grid else OF_SAMPLE
    record, parts = tabled(dataset, most, DROPS)
    for number in range(dataset.sizes["contact"]):
        own = dataset.isel(contact=number)
        record[f"contact_{number}"] = [
            {"quantity": name} | {end: own[f"{name}_{end}"].values.tolist() for end in ends}
            for name in OF_BEARING
        ]
    if is_grid:
        record["cells"] = rows_of(dataset, names_on(dataset, "cell"))
    failed = int((dataset["status"].values != 0).sum())
    sentence = f"{dataset.sizes['drop']} drops{' on a grid' if is_grid else ''}"
    said = sentence + (f", of which {failed} failed." if failed else ".")
    return record, [said, *drops_tables(dataset), *parts]


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


def _start_in_words(run: xr.Dataset) -> list[str]:
    """Return a sentence on how far below the axis a rotor begins at rest; none if it does not."""
    if not {"constant_force", STATE} <= {*run.variables} or float(run["t"][0]) != 0.0:
        return []
    _, velocity = run[STATE].values.reshape(2, -1)
    below = -run["y"].isel(t=0).values
    if velocity.any() or not run["constant_force"].values.any() or not (below > 0.0).any():
        return []
    node = int(below.argmax())
    unit = "m" if run["t"].attrs.get("units") == "s" else ""
    sag, name = quantity(float(below[node]), unit, 3), str(run["node"].values[node])
    return [f"It starts at rest, {sag} below the axis at node {name!r}."]


def _sentence(run: xr.Dataset, contacts: list[Record], first: Record | None) -> str:
    """Return where and when a run touches first, how often and how hard."""
    if not contacts:
        return "The system has no contacts."
    hardest = float(np.fmax.reduce(np.array([each["largest_force"] for each in contacts], float)))
    where = f" of contact {first['contact']} at {first['node']!r}" if first else ""
    return touched(run, hardest, where)
