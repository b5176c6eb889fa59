"""Describe runs of a rotor system, what each contact does first, and sweeps, point by point."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.cli.describe import change_of_speed, count_of_kinds
from rotor_ida.cli.drop_grids import cells_in, count_of, place_of, places_in
from rotor_ida.cli.report import pairs, shown, table
from rotor_ida.cli.variables import (
    Description,
    Record,
    Rows,
    names_on,
    rows_of,
    rows_table,
    scalars_of,
    show_by_dimension,
    tabled,
    with_unit,
    with_units,
)
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.results.growth_words import stability_words
from rotor_ida.schema import EVENT_KIND, OF_BEARING, QUANTITIES, words_of
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
RESPONSES = Rows(
    title="Responses", key="responses", lead="response", digits=6, telling=True, on_request=True,
    names=("response", "speed", *PARAMETERS_OF_SYSTEM, "start", "direction", "excursion",
           "largest_force", "period", "lyapunov_exponent", "lyapunov_error", "revolutions",
           "cycle_distance", "status", "message"),
)  # fmt: skip
# Dimensions of a settled response by which it is too long for a row.
OF_MOTION = ("contact", "node", "component")
OF_KINDS = ("speed", *PARAMETERS_OF_SYSTEM, "excursion", "largest_force")
DROPS = Rows(
    title="Drops", key="drops", lead="drop",
    names=("drop_phase", "first_touch_time", "horizon", "standstill_time", "message"),
)  # fmt: skip
FRACTIONS = {
    "backward whirl of three turns": "backward_whirl", "in contact at the end": "rest",
    "largest force before the horizon": "decided", "largest force above the capacity": "overload",
}  # fmt: skip
# The columns of the table of contacts, with the variables whose units they have.
COLUMNS = {
    "contact": "", "node": "", "stator": "", "clearance": "clearance", "entries": "",
    "first_touch": "entry_time", "largest_r_over_clearance": "", "largest_force": "peak_force",
    "rolling_time": "rolling_time", "ends": "",
}  # fmt: skip
# Statistics of each figure of a bearing: of a random sample, and of a grid.
OF_SAMPLE = ("mean", "mean_low", "mean_high", "quantile", "quantile_low", "quantile_high")
OF_GRID = ("min", "min_drop", "max", "max_drop", "mean", "mean_change")
OF_RUN = ("method", "rtol", "modes", "more_modes")


def show_system_run(dataset: xr.Dataset, most: int | None) -> Description:
    """Return contacts, scalars, events and episodes of a run of a rotor system."""
    contacts = [_of_contact(dataset, number) for number in range(dataset.sizes["contact"])]
    touching = [each for each in contacts if not math.isnan(each["first_touch"])]
    first = min(touching, key=lambda each: each["first_touch"], default=None)
    record, parts = tabled(dataset, most, EVENTS, EPISODES)
    record |= {"first_touch": first, "contacts": contacts}
    heads = {name: _with_unit_of(dataset, name, variable) for name, variable in COLUMNS.items()}
    rows: list[Record] = [{heads[name]: each[name] for name in heads} for each in contacts]
    listed = rows_table("Contacts", rows, list(heads.values()), None, digits=6)
    told = pairs("Run", _of_run(dataset))
    units = "SI" if dataset["t"].attrs.get("units") == "s" else "1"
    return record, [
        _sentence(dataset, first),
        *stability_words(dataset.attrs, units),
        *listed,
        told,
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
    worst = {
        "excursion": dataset["radius_max"] / gaps,
        "largest_force": dataset["largest_force"],
    }
    told = dataset.drop_dims([dim for dim in OF_MOTION if dim in dataset.dims])
    if dataset.sizes["contact"]:
        told = told.assign({name: each.max("contact") for name, each in worst.items()})
        told["excursion"].attrs = QUANTITIES["excursion"].attributes()
        told["largest_force"].attrs = dataset["largest_force"].attrs
    return told, {"contacts": rows_of(dataset, (str(gaps.name), "contact_node"))}


def show_drop(dataset: xr.Dataset, most: int | None) -> Description:
    """Return what is delivered of a drop by bearing, then what is shown of any run."""
    record, parts = show_system_run(dataset, most)
    there = names_on(dataset, "contact")
    names = [name for name in (*OF_BEARING, "load_ratio") if name in there]
    if not names:
        return record, parts
    bearings = [
        {"node": str(dataset["contact_node"].values[number])}
        | {name: dataset[name].values[number].item() for name in names}
        for number in range(dataset.sizes["contact"])
    ]
    turned: list[Record] = [
        {"quantity": with_unit(dataset, name)}
        | {f"{number}: {each['node']}": each[name] for number, each in enumerate(bearings)}
        for name in names
    ]
    drawn = table("Bearings", turned, list(turned[0]), digits=5, are_words=False)
    sentence, *others = parts
    return {**record, "bearings": bearings}, [sentence, drawn, *others]


def show_drops(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the statistics of many drops by bearing, the cells of a grid, and the drops."""
    is_grid = "cell" in dataset.sizes
    if not is_grid and not dataset.sizes.get("quantile"):  # a part
        return show_by_dimension(dataset, most)
    statistics, ends = (_over_grid, OF_GRID) if is_grid else (_statistics, OF_SAMPLE)
    there = {*names_on(dataset, "contact"), *names_on(dataset, "quantile", "contact")}
    names = [name for name in OF_BEARING if name in dataset
             and {f"{name}_{end}" for end in ends} <= there]  # fmt: skip
    record, parts = tabled(dataset, most, DROPS)
    tables: list[Any] = []
    for number in range(dataset.sizes["contact"]):
        own, node = dataset.isel(contact=number), str(dataset["contact_node"].values[number])
        rows: list[Record] = [statistics(own, name) for name in names]
        record |= {f"contact_{number}": rows}
        tables.append(table(f"Bearing {number} at node {node!r}", rows, list(rows[0]), digits=4))
        facts: Record = {word: _margins(own, name) for word, name in FRACTIONS.items()
                         if f"{name}_fraction" in there}  # fmt: skip
        margin = "its change on coarser grids" if is_grid else "its 95 % interval"
        tables.append(pairs(f"Fraction of drops, with {margin}", facts))
    if is_grid:
        tables.append(f"Each extreme lies at: {places_in(dataset)}.")
        rows = _cells(dataset)
        record |= {"cells": rows}
        tables += rows_table("Cells of the grid", rows, list(rows[0]), most, digits=4)
    failed = int((dataset["status"].values != 0).sum())
    kind = " on a grid" if is_grid else ""
    sentence = f"{dataset.sizes['drop']} drops{kind}"
    return record, [sentence + (f", of which {failed} failed." if failed else "."), *tables, *parts]


def _statistics(own: xr.Dataset, name: str) -> Record:
    """Return mean and quantiles of one figure of a bearing."""
    quantiles = {
        f"{100 * float(level):g} %": float(value)
        for level, value in zip(own["quantile"], own[f"{name}_quantile"], strict=True)
    }
    of_mean = {"mean from": "mean_low", "mean to": "mean_high"}
    of_last = {f"{list(quantiles)[-1]} {word}": float(own[f"{name}_quantile_{end}"][-1])
               for word, end in (("from", "low"), ("to", "high"))}  # fmt: skip
    return {
        "quantity": with_unit(own, name), "drops": count_of(own, name),
        "mean": float(own[f"{name}_mean"]),
        **{word: float(own[f"{name}_{end}"]) for word, end in of_mean.items()},
        **quantiles, **{word: _finite(each) for word, each in of_last.items()},
    }  # fmt: skip


def _finite(value: float) -> float:
    """Return an end of an interval, NaN where there is none."""
    return value if math.isfinite(value) else math.nan


def _over_grid(own: xr.Dataset, name: str) -> Record:
    """Return range and mean of one figure of a bearing over a grid, and where its ends lie."""
    found: Record = {"quantity": with_unit(own, name), "drops": count_of(own, name)}
    for end, word in (("min", "smallest"), ("max", "largest")):
        at = int(own[f"{name}_{end}_drop"])
        found |= {word: float(own[f"{name}_{end}"]), f"{word} at": place_of(own, at)}
    return found | {"mean": float(own[f"{name}_mean"]),
                    "change": float(own[f"{name}_mean_change"])}  # fmt: skip


def _cells(dataset: xr.Dataset) -> list[Record]:
    """Return the cells of a grid: what varies besides the phase, and what happens there."""
    names, nodes = cells_in(dataset), dataset["contact_node"].values
    of_contacts = {"cell_backward_whirl_fraction": "backward whirl",
                   "cell_largest_force": "largest force"}  # fmt: skip
    found: list[Record] = []
    for cell in range(dataset.sizes["cell"]):
        row: Record = {name.removeprefix("cell_"): float(dataset[name][cell]) for name in names}
        for name, words in of_contacts.items():
            row |= {f"{words}, {node}": float(each)
                    for node, each in zip(nodes, dataset[name][cell], strict=True)}  # fmt: skip
        found.append(row)
    return found


def _margins(own: xr.Dataset, name: str) -> list[float]:
    """Return a fraction, and the ends of its interval or its change on coarser grids."""
    ends = ("", "_change") if "cell" in own.sizes else ("", "_low", "_high")
    there = names_on(own)
    return [float(own[each]) for end in ends if (each := f"{name}_fraction{end}") in there]


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
