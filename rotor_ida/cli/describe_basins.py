"""Describe basins, atlases and touchdown reports, attractor by attractor."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import xarray as xr
from rich.console import RenderableType

from rotor_ida.checks import COMPONENTS
from rotor_ida.cli.describe import ranges_of
from rotor_ida.cli.describe_systems import worst_of_contacts
from rotor_ida.cli.report import pairs, table
from rotor_ida.cli.variables import (
    Description,
    Record,
    Rows,
    names_on,
    parameters_in,
    rows_of,
    rows_table,
    scalars_of,
    span,
    tabled,
    value_of,
    with_unit,
    with_units,
)
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.schema import by_number, flags_of

ATTRACTORS = Rows(
    title="Attractors", key="attractors", lead="kind", digits=6,
    names=("kind", "attractor", "amplitude", "phase_lag", "radius_min", "radius_max", "excursion",
           "largest_force", "trapping", "confirmed", "count", "fraction", "fraction_error"),
)  # fmt: skip
SHARES = Rows(
    title="Kinds of response", key="responses", lead="response_fraction", digits=6,
    names=("response", "response_count", "response_fraction", "response_fraction_error"),
)  # fmt: skip
# Loads on each attractor, a line for each.
DONE_TO_MACHINE = (
    *("fraction", "fraction_error", "settling_median", "settling_95"),
    *("largest_force", "mean_force", "contacts_per_revolution", "contact_fraction"),
    *("dissipation_per_revolution", "contact_loss_per_revolution"),
    *("heat_per_revolution", "slip_distance_per_revolution", "rolling_fraction"),
    *("whirl_over_spin", "whirl_sense", "side_line_over_spin", "whirl_ratio", "whirl_direction"),
    *("radius_min", "radius_max", "excursion", "period", "lifetime", "trapping"),
    *("velocity_shock_bound", "displacement_shock_bound"),
)
OF_MACHINE = (
    *(*ALL_PARAMETERS, "undecided_fraction", "missed_fraction", "basin_entropy"),
    *("agreement", "agreement_count"),
)
SHOCK = ("velocity_shock", "displacement_shock")
ENDS = {"low": "from", "high": "to"}


def show_attractors(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the attractors of a basin or of fractions, with the ends of the starts."""
    contacts: Record = {}
    if "contact" in dataset.dims:
        dataset, contacts = worst_of_contacts(dataset)
    record, parts = tabled(dataset, most, ATTRACTORS, SHARES)
    record |= contacts
    if "label" in dataset:
        record["grid"] = {
            name: dataset.sizes[name] for name in COMPONENTS if name in dataset["label"].dims
        }
    return record, [*parts, pairs("Starts", scalars_of(dataset))]


def show_atlas(dataset: xr.Dataset, most: int | None) -> Description:
    """Return each attractor with its range of existence and its basin fraction."""
    words = by_number(flags_of(dataset["kind"]))
    varied = [name for name in parameters_in(dataset) if dataset[name].size > 1]
    rows: list[Record] = []
    for number in range(dataset.sizes["attractor"]):
        own = dataset.isel(attractor=number)
        here = own["fraction"].notnull()
        kinds = sorted({words[kind] for kind in own["kind"].values[here].tolist()})
        row: Record = {"attractor": number, "kind": ", ".join(kinds), "points": int(here.sum())}
        row |= ranges_of(own, varied, here)
        row["fraction"] = span(own["fraction"].values, 3)
        row |= ranges_of(own, ["radius_max"], here)
        if SHOCK[0] in own:
            row[SHOCK[0]] = span(own[SHOCK[0]].values, 4)
        rows.append(row)
    scalars: Record = {
        "missed_fraction": float(dataset["missed_fraction"]),
        "largest_undecided_fraction": float(dataset["undecided_fraction"].max()),
    }
    if {"agreement", "agreement_count"} <= dataset.keys():
        scalars |= _agreement(dataset)
    record, _ = tabled(dataset, most)
    if isinstance(given := record.get("starts"), list):  # the archive contains them, row by row
        record["starts"] = len(given) // len(COMPONENTS)
    parts = rows_table("Attractors", rows, list(rows[0]) if rows else [], most, digits=6)
    return record | scalars | {"attractors": rows}, [*parts, pairs("Starts", scalars)]


def _agreement(dataset: xr.Dataset) -> Record:
    """Return the number of recomputed labels of all rotors, and the fraction that agree."""
    count = int(dataset["agreement_count"].sum())
    alike = float((dataset["agreement"] * dataset["agreement_count"]).sum())
    return {"agreement": alike / count if count else math.nan, "agreement_count": count}


def show_touchdown(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the properties of each attractor, a column for each, and the smallest shocks."""
    rows = rows_of(dataset, names_on(dataset, "attractor"))
    scalars = parameters_in(dataset) | scalars_of(dataset)
    record: Record = tabled(dataset, most)[0] | scalars | {"attractors": rows}
    heads = [f"{number} {row['kind']}" for number, row in enumerate(rows)]
    lines: list[Record] = [
        {"": with_unit(dataset, name)} | dict(zip(heads, [row[name] for row in rows], strict=True))
        for name in DONE_TO_MACHINE
        if rows and name in rows[0]
    ]
    if rows and f"{PARAMETERS[0]}_low" in rows[0]:
        told_of = [f"{word}{end}" for word in ENDS for end in ("", "_end")]
        names = [name for name in ALL_PARAMETERS
                 if all(f"{name}_{each}" in rows[0] for each in told_of)]  # fmt: skip
        for name, word in product(names, ENDS):
            ends = [_end(row, f"{name}_{word}") for row in rows]
            lines.append({"": f"{name} {ENDS[word]}", **dict(zip(heads, ends, strict=True))})
    counted = f"Attractors: {len(rows) or 'none'}"
    parts: list[RenderableType] = [
        table(counted, lines, list(lines[0]), digits=5) if lines else counted
    ]
    if all(name in dataset for name in SHOCK):
        shocks = _shocks(dataset)
        told: list[Record] = [
            {"from": heads[one], "to": heads[to]}
            | with_units(dataset, {name: each[name] for name in SHOCK})
            for (one, to), each in shocks.items()
            if "touching" not in {rows[one]["kind"], rows[to]["kind"]}  # as the contact-free
        ]
        record["smallest_shocks"] = list(shocks.values())
        parts += rows_table("Smallest shocks", told, list(told[0]) if told else [], most, digits=5)
    machine = {name: scalars[name] for name in OF_MACHINE if name in scalars}
    return record, [*parts, pairs("Machine", with_units(dataset, machine))]


def _shocks(dataset: xr.Dataset) -> dict[tuple[int, int], Record]:
    """Return the smallest shocks by their initial and final attractors."""
    found = np.isfinite(dataset[SHOCK[0]].values) | np.isfinite(dataset[SHOCK[1]].values)
    shocks: dict[tuple[int, int], Record] = {}
    for one, to in np.argwhere(found).tolist():
        here = dataset.isel(attractor=one, target=to)
        told = {name: value_of(here, name) for name in names_on(dataset, "attractor", "target")}
        shocks[one, to] = {"from": one, "to": to, **told}
    return shocks


def _end(row: Record, name: str) -> str:
    """Return an end of the values of a parameter at which an attractor exists, and its kind."""
    kind = str(row[f"{name}_end"]).replace("_", " ")
    if kind == "not found":
        return "?"
    return f"{row[name]:.5g}" if kind == "none" else f"{row[name]:.5g} {kind}"
