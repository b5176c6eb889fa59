"""Describe basins, atlases and touchdown reports, attractor by attractor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.cli.describe import range_of
from rotor_ida.cli.describe_systems import worst_of_contacts
from rotor_ida.cli.variables import (
    Description,
    Record,
    Rows,
    counted,
    line_of,
    lines_of,
    names_on,
    parameters_in,
    rows_of,
    scalars_of,
    tabled,
    value_of,
)
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.results.sheets import Line, Parts, Range, Sheet, facts
from rotor_ida.results.si_units import si_of
from rotor_ida.schema import by_number, flags_of
from rotor_ida.units import read_in

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
    *("whirl_over_spin", "whirl_sense", "side_line_over_spin", "whirl_direction"),
    *("radius_min", "radius_max", "excursion", "period", "lifetime", "trapping"),
    *("velocity_shock_bound", "displacement_shock_bound"),
)
OF_MACHINE = (
    *(SPEED, *ALL_PARAMETERS, "undecided_fraction", "missed_fraction", "basin_entropy"),
    *("agreement", "agreement_count"),
)
# Losses of all contacts of a rotor system are added, of other numbers the largest is shown.
SUMMED = ("contact_loss_per_revolution", "heat_per_revolution", "slip_distance_per_revolution")
OF_CONTACT = (
    *("mean_force", "contacts_per_revolution", "contact_fraction", "rolling_fraction"), *SUMMED,
)  # fmt: skip
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
    return record, [*parts, facts("Starts", lines_of(dataset, scalars_of(dataset)))]


def show_atlas(dataset: xr.Dataset, most: int | None) -> Description:
    """Return each attractor with its range of existence and its basin fraction."""
    words = by_number(flags_of(dataset["kind"]))
    contacts: Record = {}
    if "contact" in dataset.dims:
        dataset, contacts = worst_of_contacts(dataset)
    known = dict.fromkeys((SPEED, *ALL_PARAMETERS, *PARAMETERS_OF_SYSTEM))
    varied = [name for name in known if name in dataset.dims and dataset.sizes[name] > 1]
    owns = [dataset.isel(attractor=number) for number in range(dataset.sizes["attractor"])]
    places = [(own, own["fraction"].notnull()) for own in owns]
    kinds = [", ".join(sorted({words[kind] for kind in own["kind"].values[here].tolist()}))
             for own, here in places]  # fmt: skip
    size = "radius_max" if "radius_max" in dataset else "excursion"
    names = [*varied, "fraction", size, *([SHOCK[0]] if SHOCK[0] in dataset else [])]
    lines = [
        Line("attractor", list(range(len(owns)))),
        Line("kind", kinds),
        Line("points", [int(here.sum()) for _, here in places]),
        *(range_of(name, places) for name in names if places),
    ]
    scalars: Record = {
        "missed_fraction": float(dataset["missed_fraction"]),
        "largest_undecided_fraction": float(dataset["undecided_fraction"].max()),
    }
    if {"agreement", "agreement_count"} <= dataset.keys():
        scalars |= _agreement(dataset)
    record = tabled(dataset, most)[0] | contacts
    if isinstance(given := record.get("starts"), list):  # the archive contains them, row by row
        record["starts"] = len(given) // len(COMPONENTS)
    rows = [
        {"attractor": number, "kind": kinds[number], "points": int(here.sum())}
        | {name: _from_to(line.values[number])
           for name, line in zip(names, lines[3:], strict=True)}
        for number, (_, here) in enumerate(places)
    ]  # fmt: skip
    record |= scalars | {"attractors": rows}
    title = counted("Attractors", len(owns), None)
    return record, [Sheet(title, lines) if owns else title, facts("Starts", scalars)]


def _from_to(found: object) -> str:
    return " to ".join(f"{each:.6g}" for each in found) if isinstance(found, Range) else ""


def _agreement(dataset: xr.Dataset) -> Record:
    """Return the number of recomputed labels of all rotors, and the fraction that agree."""
    count = int(dataset["agreement_count"].sum())
    alike = float((dataset["agreement"] * dataset["agreement_count"]).sum())
    return {"agreement": alike / count if count else math.nan, "agreement_count": count}


def show_touchdown(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the properties of each attractor, a column for each, and the smallest shocks."""
    contacts: Record = {}
    if "contact" in dataset.dims:
        dataset, contacts = _of_system(dataset)
    rows = rows_of(dataset, names_on(dataset, "attractor"))
    scalars = parameters_in(dataset) | scalars_of(dataset)
    record: Record = tabled(dataset, most)[0] | scalars | {"attractors": rows} | contacts
    heads = [f"{number} {row['kind']}" for number, row in enumerate(rows)]
    lines = [
        line_of(dataset, name, [row[name] for row in rows], 5)
        for name in DONE_TO_MACHINE
        if rows and name in rows[0]
    ]
    if rows and f"{PARAMETERS[0]}_low" in rows[0]:
        told_of = [f"{word}{end}" for word in ENDS for end in ("", "_end")]
        names = [name for name in ALL_PARAMETERS
                 if all(f"{name}_{each}" in rows[0] for each in told_of)]  # fmt: skip
        lines += [line for name in names for line in _extents(dataset, name, rows)]
    title = counted("Attractors", len(rows), None)
    parts: Parts = [Sheet(title, lines, heads) if lines else title]
    if all(name in dataset for name in SHOCK):
        shocks = _shocks(dataset)
        told = [
            (heads[one], heads[to], each)
            for (one, to), each in shocks.items()
            if "touching" not in {rows[one]["kind"], rows[to]["kind"]}  # as the contact-free
        ]
        record["smallest_shocks"] = list(shocks.values())
        columns = [
            Line("from", [one for one, _, _ in told]),
            Line("to", [to for _, to, _ in told]),
            *(line_of(dataset, name, [each[name] for _, _, each in told], 5) for name in SHOCK),
        ]
        title = counted("Smallest shocks", len(told), most)
        parts.append(Sheet(title, columns) if told else title)
    machine = {name: scalars[name] for name in OF_MACHINE if name in scalars}
    return record, [*parts, facts("Machine", lines_of(dataset, machine))]


def _of_system(dataset: xr.Dataset) -> tuple[xr.Dataset, Record]:
    """Return a report on a rotor system with the worst of its contacts, or the sum of all."""
    told, contacts = worst_of_contacts(dataset.drop_dims("component"))
    for name in [each for each in OF_CONTACT if each in dataset]:
        own = dataset[name]
        each = own.sum("contact") if name in SUMMED else own.max("contact")
        told[name] = each.assign_attrs(own.attrs)
    node = dataset["node"].values.tolist().index(dataset.attrs["knocked_node"])
    for name in ("whirl_over_spin", "whirl_sense", "side_line_over_spin"):
        told[name] = dataset[name].isel(node=node, drop=True)
    return told, contacts


def _shocks(dataset: xr.Dataset) -> dict[tuple[int, int], Record]:
    """Return the smallest shocks by their initial and final attractors."""
    found = np.isfinite(dataset[SHOCK[0]].values) | np.isfinite(dataset[SHOCK[1]].values)
    shocks: dict[tuple[int, int], Record] = {}
    for one, to in np.argwhere(found).tolist():
        here = dataset.isel(attractor=one, target=to)
        told = {name: value_of(here, name) for name in names_on(dataset, "attractor", "target")}
        shocks[one, to] = {"from": one, "to": to, **told}
    return shocks


def _extents(dataset: xr.Dataset, name: str, rows: Sequence[Record]) -> Iterator[Line]:
    """Yield a line for each end of the values of a parameter at which the attractors exist."""
    label, scale = si_of(dataset, name) or (name, 1.0)
    words, _, unit = label.removesuffix("]").partition(" [")
    places = {word: [scale * float(str(row[f"{name}_{word}"])) for row in rows] for word in ENDS}
    shown_unit, parts = read_in(unit or "1", chain(*places.values()))
    for word, values in places.items():
        kinds = [str(row[f"{name}_{word}_end"]).replace("_", " ") for row in rows]
        ends = ["?" if kind == "not found"
                else f"{value / parts:.5g}{'' if kind == 'none' else f' {kind}'}"
                for value, kind in zip(values, kinds, strict=True)]  # fmt: skip
        yield Line(f"{words} {ENDS[word]}{f' [{shown_unit}]' * bool(shown_unit)}", ends)
