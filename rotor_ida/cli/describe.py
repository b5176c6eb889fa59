"""What a dataset says: its kind, a record of it for programs and tables for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import xarray as xr
from rich.console import RenderableType

from rotor_ida.checks import COMPONENTS
from rotor_ida.cli.report import pairs, table
from rotor_ida.cli.variables import (
    Description,
    Record,
    about,
    attributes_of,
    names_on,
    parameters_in,
    rows_of,
    rows_table,
    span,
    spread_on,
    value_of,
    with_unit,
)
from rotor_ida.cycles.branch_course import parameters_of, stable_ranges
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor import SPEED_UNITS
from rotor_ida.results.kinds import KINDS, kind_of, loaded
from rotor_ida.results.si_units import in_rpm
from rotor_ida.schema import ENDS_IN_WORDS, RESPONSE, flags_of

EVENT = ("event_time", "event_kind", "event_speed", "event_x", "event_y", "event_time_error")
CONTACT = (
    *("entry_time", "exit_time", "peak_time", "peak_indentation", "peak_force"),
    *("heat", "slip_distance", "rolling_time"),
)
ATTRACTOR = (
    *("kind", "attractor", "amplitude", "phase_lag", "radius_min", "radius_max"),
    *("trapping", "confirmed", "count", "fraction", "fraction_error"),
)
DONE_TO_MACHINE = (
    *("fraction", "fraction_error", "settling_median", "settling_95"),
    *("largest_force", "mean_force", "contacts_per_revolution", "contact_fraction"),
    *("dissipation_per_revolution", "contact_loss_per_revolution"),
    *("heat_per_revolution", "slip_distance_per_revolution", "rolling_fraction"),
    *("whirl_ratio", "whirl_direction"),
    *("radius_min", "radius_max", "excursion", "period", "lifetime", "trapping"),
    *("velocity_shock_bound", "displacement_shock_bound"),
)
SHOCK = ("velocity_shock", "displacement_shock")
ENDS = {"low": "from", "high": "to"}
OF_MACHINE = (
    *(*ALL_PARAMETERS, "undecided_fraction", "missed_fraction", "basin_entropy"),
    *("agreement", "agreement_count"),
)
SHARE = ("response", "response_count", "response_fraction", "response_fraction_error")
STARTS = ("start_x", "start_y", "start_vx", "start_vy")
POINT = (
    *("response", *ALL_PARAMETERS, "start", "direction", "amplitude", "phase_lag"),
    *("radius_min", "radius_max", "period", "lyapunov_exponent", "lyapunov_error"),
    *("event_count", "extremum_count", "status", "message"),
)
# Of points only programs are told these.
UNTOLD = {"phase_lag", "event_count"}
TOLD_OF_RUN_UP = (
    *("ending", "response", "rate", "phase", "start", *ALL_PARAMETERS),
    *("largest_force", "largest_force_speed", "largest_radius", "first_touch_speed"),
    *("last_exit_speed", "first_roll_speed", "message"),
)
RUN_UP = (
    *("ending", "response", *ALL_PARAMETERS, "rate", "phase", "start"),
    *("largest_radius", "largest_radius_speed", "largest_force", "largest_force_speed"),
    *("first_touch_speed", "last_exit_speed", "first_roll_speed", "contact_count", "contact_time"),
    *("total_heat", "total_contact_loss", "end_angle", "end_x", "end_y", "end_vx", "end_vy"),
    *("amplitude", "phase_lag", "radius_min", "radius_max", "period", "lyapunov_exponent"),
    *("lyapunov_error", "status", "message"),
)
# Over which the endings of run-ups are counted.
COUNTED = ("phase", "start")
MOST_FRACTIONS = 40
# Of larger sweeps only the kinds are told; the archive holds the points.
MOST_TOLD = 1_000_000
RANGES = ("omega", "amplitude", "radius_max")
MULTIPLIER = ("multiplier_real", "multiplier_imag", "multiplier_error")
FITTED = ("unknown", "estimate", "standard_error", "lower", "upper", "first_guess", "unit")
LINE = ("frequency", "whirl_amplitude", "line_kind")
CYCLE = (
    *("period", "radius_min", "radius_max", "stability", "response", "contact_count"),
    *("largest_force", "impulse_per_period", "trace", "residual", "x", "y", "vx", "vy"),
)
SPECIAL = (
    *("special_kind", "special_value", "special_second_value", "special_period"),
    *("special_radius_min", "special_radius_max", "special_point"),
)
# Attributes of a branch whose names a record has for something else.
RENAMED = {"kind": "of", "points": "most_points", "parameters": "varied"}
TOLD = ("lies_on", *ALL_PARAMETERS, "start", "direction", "response", "period", "digits")
MATCH = (
    *("lies_on", *ALL_PARAMETERS, "start", "direction", "response", "digits"),
    *("matched_branch", "amplitude", "amplitude_error", "phase_error"),
    *("period", "exact_period", "exact_radius_min", "exact_radius_max", "cycle_stability"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Rows of a result: variables along the dimensions of the first of them.

    Parameters
    ----------
    title : str
        What people read above the table.
    key : str
        What the rows are called in the record.
    names : tuple of str
        The variables; where the first is NaN there is nothing, and no row. Those that a dataset
        does not have are left out.
    columns : tuple of str
        What people read, in order, if not all.
    falling : bool
        Whether the rows stand in order of the first variable, the largest first.
    """

    title: str
    key: str
    names: tuple[str, ...]
    columns: tuple[str, ...] = ()
    falling: bool = False

    def of(self, dataset: xr.Dataset) -> list[Record]:
        """Return the rows of a dataset."""
        lead, *_ = self.names
        rows = rows_of(dataset, [name for name in self.names if name in dataset.variables])
        there = [row for row in rows if row[lead] == row[lead]]
        return sorted(there, key=lambda row: -_number(row[lead])) if self.falling else there

    def table(
        self, dataset: xr.Dataset, rows: list[Record], most: int | None
    ) -> list[RenderableType]:
        """Return the table of the rows of a dataset, with units where it has them."""
        told = [name for name in self.columns or self.names if rows and name in rows[0]]
        heads = {name: with_unit(dataset, name) for name in told}
        shown: list[Record] = [{heads[name]: row[name] for name in told} for row in rows]
        return rows_table(self.title, shown, list(heads.values()), most)


@dataclass(frozen=True, slots=True)
class Sheet:
    """What is said of a kind of result: its numbers, and tables along its dimensions."""

    title: str
    tables: tuple[Rows, ...]

    def __call__(self, dataset: xr.Dataset, most: int | None) -> Description:
        """Return the record of a dataset and its tables."""
        there = [each for each in self.tables if each.names[0] in dataset.variables]
        rows = {each.key: each.of(dataset) for each in there}
        scalars = {name: value_of(dataset, name) for name in names_on(dataset)}
        parameters = parameters_in(dataset)
        record: Record = {
            "kind": kind_of(dataset),
            "parameters": parameters,
            **scalars,
            **rows,
            **about(dataset),
        }
        numbers = {name: each for name, each in parameters.items() if not isinstance(each, list)}
        told = {with_unit(dataset, name): each for name, each in (numbers | scalars).items()}
        parts = [part for each in there for part in each.table(dataset, rows[each.key], most)]
        return record, [pairs(self.title, told), *parts] if told else parts


FOUND_FOLDS = Rows(
    title="Folds",
    key="folds",
    names=("fold_omega", "fold_amplitude", *ALL_PARAMETERS[1:], "rate", "jump_omega", "fold",
           "fold_drift", "fold_curvature", "fold_remainder", "fold_passage"),
    columns=(*ALL_PARAMETERS[1:], "fold_omega", "fold_amplitude", "rate", "jump_omega"),
)  # fmt: skip
FOLDS = Sheet("Rotor", (FOUND_FOLDS,))
WHIRLS = Sheet(
    "Rotor",
    (
        Rows(
            title="Synchronous whirls",
            key="whirls",
            names=("amplitude", *ALL_PARAMETERS, "branch", "phase_lag", "stability", "growth_rate",
                   "in_contact"),
            columns=(*ALL_PARAMETERS, "amplitude", "phase_lag", "stability", "growth_rate",
                     "in_contact"),
        ),
        FOUND_FOLDS,
    ),
)  # fmt: skip
HOPF_POINTS = Sheet(
    "Rotor",
    (
        Rows(
            title="Hopf points",
            key="hopf_points",
            names=("hopf_omega", "hopf_amplitude", "hopf_frequency", *ALL_PARAMETERS[1:]),
            columns=(*ALL_PARAMETERS[1:], "hopf_omega", "hopf_amplitude", "hopf_frequency"),
        ),
    ),
)
BACKWARD_WHIRL = Sheet(
    "Rotor",
    (
        Rows(
            title="Backward whirls without unbalance",
            key="whirls",
            names=("amplitude", "kind", "whirl_speed", "stability", "growth_rate", "normal_force",
                   "tangential_force"),
            columns=("kind", "amplitude", "whirl_speed", "stability", "growth_rate",
                     "normal_force", "tangential_force"),
        ),
    ),
)  # fmt: skip
SPECTRAL_LINES = Sheet(
    "Lines by least squares",
    (
        Rows(
            title="Lines",
            key="lines",
            names=("whirl_amplitude", "frequency", "frequency_over_omega", "whirl_phase"),
            columns=("frequency", "frequency_over_omega", "whirl_amplitude", "whirl_phase"),
            falling=True,
        ),
    ),
)


def show_by_dimension(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the variables of a dataset, its numbers, and tables along each of its dimensions."""
    variables: list[Record] = [
        {
            "name": str(name),
            "long_name": str(variable.attrs.get("long_name", "")),
            "units": str(variable.attrs.get("units", "")),
            "dimensions": " ".join(str(dim) for dim in variable.dims),
        }
        for name, variable in dataset.variables.items()
    ]
    sheet = Sheet("Numbers", tuple(_along(dataset, dims) for dims in _dimensions(dataset)))
    record, parts = sheet(dataset, most)
    heads = list(variables[0]) if variables else ()
    return {**record, "variables": variables}, [
        *rows_table("Variables", variables, heads, None),
        *parts,
    ]


def _dimensions(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """Return the dimensions of variables of which not too many values can be told."""
    shapes = [each.dims for each in dataset.data_vars.values() if each.size <= MOST_TOLD]
    return [tuple(map(str, dims)) for dims in dict.fromkeys(shapes) if dims]


def _along(dataset: xr.Dataset, dims: tuple[str, ...]) -> Rows:
    """Return the rows of all variables along some dimensions, behind the coordinates there."""
    known = [name for name in (*ALL_PARAMETERS, *dims) if name in dataset.coords]
    places = [name for name in dict.fromkeys(known) if set(dataset[name].dims) & set(dims)]
    names, words = names_on(dataset, *dims), ", ".join(dims)
    return Rows(
        title=f"Along {words}",
        key=f"along {words}",
        names=(*names, *places),
        columns=(*places, *names),
    )


def describe(dataset: xr.Dataset, *, most: int | None = None) -> Description:
    """Return the record of a dataset and its tables, of at most so many rows each."""
    described: Description = loaded(KINDS[kind_of(dataset)].shown)(dataset, most)
    return described


def origin(dataset: xr.Dataset) -> RenderableType:
    """Return a table of what an archive is and where it came from."""
    attributes = attributes_of(dataset)
    versions = attributes.pop("versions", {})
    method = attributes.pop("method", {})
    sizes = "  ".join(f"{dim} {size}" for dim, size in dataset.sizes.items())
    shown = {"kind": kind_of(dataset), **attributes, "dimensions": sizes}
    for entries in (method, versions):
        shown |= entries if isinstance(entries, dict) else {}
    return pairs("Archive", shown)


def show_run(dataset: xr.Dataset, most: int | None) -> Description:
    """Return scalars, events and contacts of a run."""
    attributes = about(dataset)
    parameters = parameters_in(dataset)
    parameters |= _begun(dataset, attributes)
    scalars = {name: value_of(dataset, name) for name in names_on(dataset)}
    events = rows_of(dataset, names_on(dataset, "event"))
    contacts = rows_of(dataset, names_on(dataset, "contact"))
    record: Record = {
        "kind": "run",
        "parameters": parameters,
        **scalars,
        "events": events,
        "contacts": contacts,
        **attributes,
    }
    summary = {
        **parameters,
        **scalars,
        "events": len(events),
        "contacts": len(contacts),
        "peak_indentation": _largest(row["peak_indentation"] for row in contacts),
        "peak_force": _largest(row["peak_force"] for row in contacts),
    }
    for name in ("heat", "rolling_time"):
        if name in dataset:
            summary[name] = float(dataset[name].sum())
    told = {with_unit(dataset, name): each for name, each in summary.items()}
    parts: list[RenderableType] = [pairs("Run", told | _change_of_speed(dataset))]
    named = [name for name in EVENT if name in dataset]
    parts += _rows_of_run("Events", events, named, dataset, most, prefix="event_")
    columns = [name for name in CONTACT if name in dataset]
    parts += _rows_of_run("Contacts", contacts, columns, dataset, most)
    return record, parts


def _change_of_speed(run: xr.Dataset) -> Record:
    """Return how the speed changed during a run, by names with units."""
    if "speed" not in run:
        return {}
    first, last = run["speed"].values[[0, -1]].tolist()
    told: Record = {with_unit(run, "speed"): f"{first:.8g} to {last:.8g}"}
    if (turns := in_rpm(run["speed"])) is not None:
        told["speed [rpm]"] = f"{turns[0]:.8g} to {turns[-1]:.8g}"
    attributes = attributes_of(run)
    for name in ("rate", "torque", "inertia"):
        if name in attributes:
            unit = str(attributes.get(f"{name}_units", "")).replace("s-2", "rad/s2")
            told[f"{name} [{unit}]" if unit else name] = attributes[name]
            if unit == "rad/s2":
                told["rate [rpm/s]"] = float(run.attrs[name]) / SPEED_UNITS["rpm"]
    return told


def _rows_of_run(
    title: str,
    rows: list[Record],
    columns: list[str],
    run: xr.Dataset,
    most: int | None,
    *,
    prefix: str = "",
) -> list[RenderableType]:
    """Return a table of events or contacts, with units and speeds in rpm where it has units."""
    heads = {name: with_unit(run, name) for name in columns}
    shown: list[Record] = [{heads[name]: row[name] for name in columns} for row in rows]
    turns = in_rpm(run["event_speed"]) if "event_speed" in columns else None
    if turns is not None:
        speed, other = heads["event_speed"], "event speed [rpm]"
        shown = [
            {head: each for name, value in row.items() for head, each in
             ([(name, value), (other, turn)] if name == speed else [(name, value)])}
            for row, turn in zip(shown, turns.tolist(), strict=True)
        ]  # fmt: skip
    words = list(shown[0]) if shown else []
    return rows_table(title, shown, words, most, prefix=prefix.replace("_", " "))


def _begun(dataset: xr.Dataset, about: Record) -> Record:
    """Take from the attributes of a run its start and duration, in the units of the run."""
    told: Record = {each: about.pop(each) for each in ("start", "duration") if each in about}
    if "time_scale" in dataset.attrs:
        length, velocity = dataset.attrs["length_scale"], dataset.attrs["velocity_scale"]
        if "start" in told:
            scales = [length, length, velocity, velocity]
            told["start"] = (np.asarray(dataset.attrs["start"]) * scales).tolist()
        if "duration" in told:
            told["duration"] = float(dataset.attrs["duration"] * dataset.attrs["time_scale"])
    return told


def _largest(values: Iterable[object]) -> float:
    known = [value for value in values if isinstance(value, float) and math.isfinite(value)]
    return max(known, default=math.nan)


def show_sweep(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the responses of a sweep or diagram, and how many there are of each kind."""
    names = [name for name in POINT if name in dataset.variables]
    points = rows_of(dataset, names) if dataset["response"].size <= MOST_TOLD else []
    record: Record = {
        "kind": kind_of(dataset),
        "starts": rows_of(dataset, STARTS),
        "responses": points,
        **attributes_of(dataset),
    }
    kinds = _kinds(dataset)
    parts: list[RenderableType] = [table("Responses by kind", kinds, list(kinds[0]))]
    if most is not None and points:
        columns = [name for name in _telling(points, POINT) if name not in UNTOLD]
        parts += rows_table("Responses", points, columns, most, digits=6)
    return record, parts


def show_run_ups(dataset: xr.Dataset, most: int | None) -> Description:
    """Return how run-ups end at each rate of each rotor, and every one of them."""
    told = [name for name in ALL_PARAMETERS if name in dataset.variables]
    parts = [f"{word}_fraction" for word in ENDS_IN_WORDS]
    fractions = rows_of(
        dataset, (*parts, *(f"{name}_error" for name in parts), "failed_count", "rate", *told)
    )
    over = [name for name in COUNTED if name in dataset["largest_force"].dims]
    worst = dataset[["largest_force"]].max(over)
    for row, force in zip(fractions, worst["largest_force"].values.ravel().tolist(), strict=True):
        row["largest_force"] = force
    names = [name for name in RUN_UP if name in dataset.variables]
    run_ups = rows_of(dataset, names) if dataset["ending"].size <= MOST_TOLD else []
    record: Record = {
        "kind": "run_ups",
        "to": float(dataset["to"]),
        "starts": rows_of(dataset, STARTS),
        "fractions": fractions,
        "run_ups": run_ups,
        **attributes_of(dataset),
    }
    varied = [name for name in told if dataset[name].size > 1]
    said = [name for name in parts if any(row[name] != 0.0 for row in fractions)]
    columns = ["rate", *varied, *said, *(f"{name}_error" for name in said), "largest_force"]
    title = f"How run-ups to {float(dataset['to']):.6g} end"
    tables: list[RenderableType] = rows_table(title, fractions, columns, MOST_FRACTIONS, digits=6)
    if most is not None and run_ups:
        columns = _telling(run_ups, TOLD_OF_RUN_UP)
        tables += rows_table("Run-ups", run_ups, columns, most, digits=6)
    return record, tables


def _kinds(dataset: xr.Dataset) -> list[Record]:
    """Return how many points there are of each kind, and the ranges that they cover."""
    response = dataset["response"]
    numbers = response.values
    words = {number: word for word, number in flags_of(response).items()}
    found, first = np.unique(numbers, return_index=True)
    rows: list[Record] = []
    for kind in found[np.argsort(first)].tolist():
        here = numbers == kind
        row: Record = {"response": words[kind], "points": int(here.sum())}
        for name in (name for name in RANGES if name in dataset):  # a diagram has no amplitudes
            row[name] = span(spread_on(dataset, name, response).values[here], 6)
        rows.append(row)
    return rows


def show_attractors(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the attractors of a basin or of fractions, and what became of the starts."""
    columns = [name for name in ATTRACTOR if name in dataset]
    attractors = rows_of(dataset, columns)
    counts = {name: value_of(dataset, name) for name in names_on(dataset)}
    record: Record = {
        "kind": kind_of(dataset),
        "parameters": parameters_in(dataset),
        "attractors": attractors,
        **counts,
    }
    parts = rows_table("Attractors", attractors, columns, most, digits=6)
    if "response_fraction" in dataset:
        record["responses"] = rows_of(dataset, SHARE)
        parts += rows_table("Kinds of response", rows_of(dataset, SHARE), SHARE, most, digits=6)
    else:
        record["grid"] = {name: dataset.sizes[name] for name in dataset["label"].dims}
    return record | about(dataset), [*parts, pairs("Starts", counts)]


def show_atlas(dataset: xr.Dataset, most: int | None) -> Description:
    """Return each attractor with where it exists and how likely it is there."""
    words = {number: word for word, number in flags_of(dataset["kind"]).items()}
    rows: list[Record] = []
    for number in range(dataset.sizes["attractor"]):
        own = dataset.isel(attractor=number)
        fraction = own["fraction"]
        here = np.isfinite(fraction.values)
        kinds = sorted({words[kind] for kind in own["kind"].values[here].tolist()})
        row: Record = {"attractor": number, "kind": ", ".join(kinds), "points": int(here.sum())}
        for name in parameters_in(dataset):
            if dataset[name].size > 1:
                row[name] = span(spread_on(dataset, name, fraction).values[here], 6)
        row["fraction"] = span(fraction.values[here], 3)
        row["radius_max"] = span(own["radius_max"].values[here], 6)
        if SHOCK[0] in own:
            row[SHOCK[0]] = span(own[SHOCK[0]].values, 4)
        rows.append(row)
    record: Record = {
        "kind": "atlas",
        "parameters": parameters_in(dataset),
        "attractors": rows,
        "missed_fraction": float(dataset["missed_fraction"]),
        "largest_undecided_fraction": float(dataset["undecided_fraction"].max()),
    }
    scalars = {name: record[name] for name in ("missed_fraction", "largest_undecided_fraction")}
    if "agreement" in dataset:
        scalars |= _agreement(dataset)
    told = about(dataset)
    if isinstance(given := told.get("starts"), list):  # the archive holds them, row after row
        told["starts"] = len(given) // len(COMPONENTS)
    columns = list(rows[0]) if rows else []
    parts = rows_table("Attractors", rows, columns, most, digits=6)
    return record | scalars | told, [*parts, pairs("Starts", scalars)]


def _agreement(dataset: xr.Dataset) -> Record:
    """Return how many labels of all rotors were found again, and the part that are the same."""
    count = int(dataset["agreement_count"].sum())
    alike = float((dataset["agreement"] * dataset["agreement_count"]).sum())
    return {"agreement": alike / count if count else math.nan, "agreement_count": count}


def show_touchdown(dataset: xr.Dataset, most: int | None) -> Description:
    """Return what each attractor does, a column for each, and what throws it to another."""
    rows = rows_of(dataset, names_on(dataset, "attractor"))
    scalars = _scalars(dataset)
    record: Record = {"kind": "touchdown", "attractors": rows, **scalars}
    heads = [f"{number} {row['kind']}" for number, row in enumerate(rows)]
    lines: list[Record] = [
        {"": with_unit(dataset, name)} | dict(zip(heads, [row[name] for row in rows], strict=True))
        for name in DONE_TO_MACHINE
        if rows and name in rows[0]
    ]
    if rows and f"{PARAMETERS[0]}_low" in rows[0]:
        names = [name for name in ALL_PARAMETERS if f"{name}_low" in rows[0]]
        for name, word in product(names, ENDS):
            ends = [_end(row, f"{name}_{word}") for row in rows]
            lines.append({"": f"{name} {ENDS[word]}", **dict(zip(heads, ends, strict=True))})
    counted = f"Attractors: {len(rows) or 'none'}"
    parts: list[RenderableType] = [
        table(counted, lines, list(lines[0]), digits=5) if lines else counted
    ]
    if SHOCK[0] in dataset:
        shocks = _shocks(dataset)
        told: list[Record] = [
            {"from": heads[one], "to": heads[to]}
            | {with_unit(dataset, name): each[name] for name in SHOCK}
            for (one, to), each in shocks.items()
            if "touching" not in {rows[one]["kind"], rows[to]["kind"]}  # as the contact-free
        ]
        record["smallest_shocks"] = list(shocks.values())
        parts += rows_table("Smallest shocks", told, list(told[0]) if told else [], most, digits=5)
    parts.append(pairs("Machine", {name: scalars[name] for name in OF_MACHINE if name in scalars}))
    return record | about(dataset), parts


def _shocks(dataset: xr.Dataset) -> dict[tuple[int, int], Record]:
    """Return the smallest shocks by the attractors that they lead from and to."""
    found = np.isfinite(dataset[SHOCK[0]].values) | np.isfinite(dataset[SHOCK[1]].values)
    shocks: dict[tuple[int, int], Record] = {}
    for one, to in np.argwhere(found).tolist():
        here = dataset.isel(attractor=one, target=to)
        told = {name: value_of(here, name) for name in names_on(dataset, "attractor", "target")}
        shocks[one, to] = {"from": one, "to": to, **told}
    return shocks


def _scalars(dataset: xr.Dataset) -> Record:
    names = [str(name) for name, variable in dataset.variables.items() if not variable.dims]
    return {name: value_of(dataset, name) for name in names}


def _end(row: Record, name: str) -> str:
    """Return an end of the values of a parameter at which an attractor exists, and its kind."""
    kind = str(row[f"{name}_end"]).replace("_", " ")
    if kind == "not found":
        return "?"
    return f"{row[name]:.5g}" if kind == "none" else f"{row[name]:.5g} {kind}"


def show_comparison(dataset: xr.Dataset, most: int | None) -> Description:
    """Return how many responses lie on an exact one, and each point."""
    from rotor_ida.verification.compare import summarise  # noqa: PLC0415 - only this kind needs it

    names = [name for name in MATCH if name in dataset.variables]
    summary, points = summarise(dataset), rows_of(dataset, names)
    record: Record = {
        "kind": "comparison",
        "summary": summary,
        "points": points,
        **attributes_of(dataset),
    }
    # of the kinds of response only those that there are
    columns = [
        name
        for name in summary[0]
        if name not in RESPONSE or any(row[name] != 0 for row in summary)
    ]
    title = "On an exact whirl or limit cycle, by clearance"
    parts: list[RenderableType] = [table(title, summary, columns)]
    if most is not None:
        told = [name for name in names if name in TOLD]
        parts += rows_table("Points", points, told, most, digits=6)
    return record, parts


def show_cycle(dataset: xr.Dataset, most: int | None) -> Description:
    """Return a limit cycle with its multipliers and strongest lines."""
    attributes = about(dataset)
    parameters = parameters_in(dataset)
    parameters["start"] = attributes.pop("start", None)
    scalars = {name: value_of(dataset, name) for name in names_on(dataset)}
    record: Record = {
        "kind": "cycle",
        "parameters": parameters,
        **scalars,
        "multipliers": rows_of(dataset, MULTIPLIER),
        "lines": rows_of(dataset, LINE) if dataset.sizes["line"] else [],
        **attributes,
    }
    if dataset["period"].isnull():
        told = {**parameters, "response": scalars["response"]}
        return record, [pairs("No limit cycle", told)]
    lines = dataset[list(LINE)].sortby("whirl_amplitude", ascending=False)
    parts: list[RenderableType] = [pairs("Limit cycle", {**parameters, **scalars})]
    parts += rows_table("Multipliers", rows_of(dataset, MULTIPLIER), MULTIPLIER, None)
    parts += rows_table("Strongest lines", rows_of(lines, LINE), LINE, most)
    return record, parts


def show_branch(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the ends, special points and stable ranges of a branch."""
    varied = parameters_of("branch", dataset, "parameter", 1)
    record, parts = _followed("branch", "Branch of limit cycles", dataset, varied, most)
    stable: list[Record] = [{"from": low, "to": high} for low, high in stable_ranges(dataset)]
    record["stable_ranges"] = stable
    return record, [*parts, *rows_table("Stable ranges", stable, ("from", "to"), most)]


def show_curve(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the ends and special points of a bifurcation curve."""
    varied = parameters_of("curve", dataset, "parameters", 2)
    kind = str(dataset.attrs.get("kind", "")).replace("_", " ")
    return _followed("curve", f"{kind.capitalize()} curve", dataset, varied, most)


def _followed(
    kind: str, title: str, dataset: xr.Dataset, varied: Sequence[str], most: int | None
) -> Description:
    """Return what a branch and a bifurcation curve have in common."""
    held = parameters_in(dataset.drop_vars(varied))
    attributes = attributes_of(dataset)
    told_of = ("first_end", "first_reason", "last_end", "last_reason")
    ends = {name: attributes.pop(name, "") for name in told_of}
    ends["closed"] = bool(attributes.pop("closed", False))
    specials = rows_of(dataset, [name for name in SPECIAL if name in dataset])
    specials = [{"special": number, **row} for number, row in enumerate(specials)]
    names = [*varied, *(name for name in CYCLE if name in dataset)]
    record: Record = {
        "kind": kind,
        "parameters": held,
        **ends,
        "points": rows_of(dataset, names),
        "special_points": specials,
        **{RENAMED.get(name, name): entry for name, entry in attributes.items()},
    }
    ranged = (*varied, "period", "radius_min", "radius_max")
    ranges = {name: span(dataset[name].values, 8) for name in ranged}
    told = {name: end for name, end in ends.items() if end != ""}
    summary = {**held, **ranges, "points": dataset.sizes["point"], **told}
    columns = list(specials[0]) if specials else ()
    parts: list[RenderableType] = [pairs(title, summary)]
    return record, [
        *parts,
        *rows_table("Special points", specials, columns, most, prefix="special_"),
    ]


def show_fit(dataset: xr.Dataset, most: int | None) -> Description:
    """Return what a fit found, what the signals tell of it, and whether noise is left."""
    about: Record = {
        "machine": dataset.attrs["machine"],
        "windows": dataset.sizes["window"],
        "chi_square": float(dataset["chi_square"]),
        "degrees_of_freedom": int(dataset["degrees_of_freedom"]),
        "noise": float(dataset["noise"]),
        "remainder": str(dataset.attrs["remainder"]),
    }
    if "contact_times" in dataset.attrs:
        about["contact_times"] = str(dataset.attrs["contact_times"])
    rows = rows_of(dataset, FITTED)
    told = [f"{each}." for each in str(dataset.attrs["identifiability"]).split("; ")]
    return {**about, "unknown": rows, "identifiability": told}, [
        pairs("Fit", about), *rows_table("Unknown", rows, FITTED, most), *told
    ]  # fmt: skip


def _number(value: object) -> float:
    return value if isinstance(value, float) else math.nan


def _telling(rows: Sequence[Record], names: Sequence[str]) -> list[str]:
    """Return those columns that say anything in any row."""
    said = {name for row in rows for name, value in row.items() if _says(value)}
    return [name for name in names if name in said]


def _says(value: object) -> bool:
    nothing = isinstance(value, float) and math.isnan(value)
    return not nothing and value not in {"", "done", "from_start"}
