"""Describe runs, sweeps and limit cycles: a record for programs and tables for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from rotor_ida.cli.variables import (
    OF_ERROR,
    Description,
    Layout,
    Record,
    Rows,
    attributes_of,
    counted,
    is_in_si,
    line_of,
    lines_of,
    names_on,
    parameters_in,
    rows_of,
    scalars_of,
    span,
    tabled,
)
from rotor_ida.cycles.branch_course import parameters_of, stable_ranges
from rotor_ida.model.parameters import ALL_PARAMETERS, OF_MACHINE
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.results.checked_run import course_of
from rotor_ida.results.dataset_kinds import KINDS, OTHER, kind_of, loaded
from rotor_ida.results.depths import beyond_model
from rotor_ida.results.growth_words import stability_words
from rotor_ida.results.sheets import Line, Range, Sheet, facts
from rotor_ida.results.si_units import MACHINE
from rotor_ida.schema import ENDS_IN_WORDS, RESPONSE, words_of
from rotor_ida.schema.quantities import SPECIAL_VALUES, UNITS
from rotor_ida.units import quantity

EVENTS = Rows(
    title="Events", key="events", lead="event_time", prefix="event_",
    names=("event_time", "event_kind", "event_contact", "event_speed", "event_x", "event_y",
           "event_time_error", "event_time_shift"),
)  # fmt: skip
CONTACTS = Rows(
    title="Contacts", key="contacts", lead="entry_time",
    names=("entry_time", "exit_time", "peak_time", "peak_indentation", "peak_force", "heat",
           "slip_distance", "rolling_time"),
)  # fmt: skip
POINTS = Rows(
    title="Responses", key="responses", lead="response", digits=6, on_request=True,
    names=("response", *ALL_PARAMETERS, "start", "direction", "amplitude", "radius_min",
           "radius_max", "period", "lyapunov_exponent", "lyapunov_error", "extremum_count",
           "status", "message"),
)  # fmt: skip
CYCLES = Rows(
    title="Limit cycles", key="cycles", lead="response", digits=8, on_request=True,
    names=("response", "stability", "speed",
           *dict.fromkeys((*ALL_PARAMETERS, *PARAMETERS_OF_SYSTEM)), "period",
           "radius_max", "largest_force", "status", "message"),
)  # fmt: skip
RUN_UPS = Rows(
    title="Run-ups", key="run_ups", lead="ending", digits=6, on_request=True,
    names=("ending", "response", "rate", "phase", "start", "speed", *ALL_PARAMETERS,
           "largest_force", "largest_force_speed", "largest_radius", "excursion",
           "first_touch_speed", "last_exit_speed", "first_roll_speed", "message"),
)  # fmt: skip
COMPARED = Rows(
    title="Points", key="points", lead="lies_on", digits=6, on_request=True,
    names=("lies_on", *ALL_PARAMETERS, "start", "direction", "response", "digits", "period"),
)  # fmt: skip
MULTIPLIERS = Rows(
    title="Multipliers", key="multipliers", lead="multiplier_real",
    names=("multiplier_real", "multiplier_imag", "multiplier_error"),
)  # fmt: skip
STRONGEST_LINES = Rows(
    title="Strongest lines", key="lines", lead="whirl_amplitude", falling=True,
    names=("frequency", "whirl_amplitude", "line_kind"),
)  # fmt: skip
SPECIAL_POINTS = Rows(
    title="Special points", key="special_points", lead="special_kind", prefix="special_",
    names=("special", "special_kind", "special_value", "special_second_value", "special_period",
           "special_radius_min", "special_radius_max", "special_point"),
)  # fmt: skip
_SECTION = Layout("Section", (Rows(
    title="Crossings", key="crossings", lead="rotating_x",
    names=("crossing", "crossing_time", "node", "rotating_x", "rotating_y", "rotating_vx",
           "rotating_vy"),
),))  # fmt: skip
FITTED = Rows(
    title="Unknown", key="unknown", lead="estimate",
    names=("unknown", "estimate", "standard_error", "lower", "upper", "first_guess", "unit"),
)  # fmt: skip
CONTACTS_OF_BRANCH = Rows(
    title="Contacts", key="contacts", lead="radius_max",
    names=("contact", "contact_node", "radius_min", "radius_max", "largest_force"),
)  # fmt: skip
_OF_CONTACT = ("contact_count", "radius_min", "radius_max", "largest_force", "touched")
CONTACTS_OF_CYCLE = Rows(
    title="Contacts", key="contacts", lead="radius_max",
    names=("contact", "contact_node", "clearance", *_OF_CONTACT),
)  # fmt: skip
NODES_OF_CYCLE = Rows(
    title="Nodes", key="nodes", lead="node_radius_max",
    names=("node", "node_radius_min", "node_radius_max"),
)  # fmt: skip
# The points of a section: one of them and several, and how near to each other they are one.
CROSSINGS = {"entry": ("entry", "entries")}
WITHIN = 1e-3
OF_RUN = ("start", "duration")
OF_SOLVER = ("method", "rtol", "modes", "more_modes")
STARTS = ("start_x", "start_y", "start_vx", "start_vy")
# Dimensions over which the endings of run-ups are counted.
COUNTED = ("phase", "start")
MOST_FRACTIONS = 40
# Reasons of unresolved motions below a table.
MOST_REASONS = 3
OF_CYCLES = ("period", "radius_max", "largest_force")
RANGES = ("omega", "amplitude", "radius_max")
# Digits of estimates of a fit.
OF_FITTED = 6
# What a fitted angle of the unbalance counts from.
OF_ANGLE = (
    "unbalance_angle counts from the phase mark of these signals, in the direction of rotation: "
    "another record may have another mark."
)
OF_FIT = ("chi_square", "degrees_of_freedom", "noise")
ENDS_OF_BRANCH = ("first_end", "first_reason", "last_end", "last_reason")
# Attributes of a branch whose names a record uses otherwise.
RENAMED = {"kind": "of", "points": "most_points", "parameters": "varied"}


def describe(dataset: xr.Dataset, *, most: int | None = None) -> Description:
    """Return the record of a dataset and its tables, with a largest number of rows each."""
    kind = kind_of(dataset)
    record, parts = loaded(KINDS[kind].shown)(dataset, most)
    note, told = dataset.attrs.get("note"), str(dataset.attrs.get("sentence", ""))
    first = next((place for place, each in enumerate(parts) if isinstance(each, Sheet)), len(parts))
    said = stability_words(dataset.attrs, "SI" if is_in_si(dataset) else "1")
    if (why := str(dataset.attrs.get("not_exact", ""))) and why not in told:
        said.append(f"Whirls in contact have no closed form: {why}.")
    before = [*filter(None, [told]), *parts[:first], *(each for each in said if each not in told)]
    more = ["" if kind == OTHER else beyond_model(dataset), f"Note: {note}." if note else ""]
    after = [each for each in more if each not in told]
    return {"kind": kind, **record}, [*before, *parts[first:], *after]


def origin(dataset: xr.Dataset) -> Sheet:
    """Return a sheet of the kind and origin of an archive."""
    attributes = attributes_of(dataset)
    versions = attributes.pop("versions", {})
    method = attributes.pop("method", {})
    told = [
        Line(name.replace("_", " "), [value], _unit_of(attributes, name))
        for name, value in attributes.items()
        if not (name.endswith("_units") and name.removesuffix("_units") in attributes)
    ]
    sizes = "  ".join(f"{dim} {size}" for dim, size in dataset.sizes.items())
    last = {"dimensions": sizes}
    for entries in (method, versions):
        last |= entries if isinstance(entries, dict) else {}
    return facts("Archive", [Line("kind", [kind_of(dataset)]), *told, *facts("", last).lines])


def _unit_of(attributes: Record, name: str) -> str:
    """Return the unit of an attribute, empty if it has none."""
    if name.endswith("_scale"):
        return UNITS.get(name.removesuffix("_scale"), "")
    parameter = OF_MACHINE.get(name.removeprefix(MACHINE)) if name.startswith(MACHINE) else None
    if parameter is None:
        unit = str(attributes.get(f"{name}_units", ""))
        return {"s-1": "rad/s", "s-2": "rad/s2"}.get(unit, unit)
    is_linear = attributes.get(f"{MACHINE}contact_exponent") == 1.0
    unit = parameter.shown_unit.replace("m^1.5", "m" if is_linear else "m^1.5")
    return "" if unit == "1" else unit


def show_run(dataset: xr.Dataset, most: int | None) -> Description:
    """Return scalars, events and contacts of a run."""
    record, parts = tabled(dataset, most, EVENTS, CONTACTS)
    given = parameters_in(dataset) | _begun(dataset)
    record = {name: each for name, each in record.items() if name not in given}
    record["parameters"] = given
    summary = {name: _largest(dataset, name) for name in ("peak_indentation", "peak_force")}
    summary |= {name: float(dataset[name].sum()) for name in ("heat", "rolling_time")
                if name in dataset}  # fmt: skip
    from rotor_ida.steady.run_up_summary import start_in_words  # noqa: PLC0415 - heavy

    start = start_in_words(dataset) if "load" in dataset.coords else ""
    told = [f"{start[0].upper()}{start[1:]}."] if start else []
    if "speed" not in dataset:  # a run-up has a summary
        told.insert(0, touched(dataset, summary["peak_force"]))
    sheet = facts("Run", [*facts_of_run(dataset), *lines_of(dataset, summary)])
    return record, [*told, sheet, *parts]


def touched(run: xr.Dataset, force: float, where: str = "") -> str:
    """Return when, and in a system where, a run touches first, how often and how hard."""
    entries, unit = run["entry_time"].values, str(run["t"].attrs.get("units", "1"))
    if not entries.size:
        return "The stator is not touched."
    first = float(entries.min())  # NaN if one has no entry
    when = "from the beginning" if np.isnan(first) else f"at {quantity(first, unit, 3)}"
    number = f"{entries.size:,} contact{'s' * (entries.size > 1)}"
    if math.isnan(force):
        return f"First touch {when}{where}; {number}."
    pressed = quantity(force, str(run["peak_force"].attrs.get("units", "1")), 3)
    return f"First touch {when}{where}; {number}, with up to {pressed}."


def facts_of_run(run: xr.Dataset) -> list[Line]:
    """Return what a run was computed from, with its sizes and scalars."""
    attributes = attributes_of(run)
    given = parameters_in(run)
    if "speed" in run:  # the parameter is only the first
        given.pop("omega", None)
    lines = [*lines_of(run, given), *_speed_of(run, attributes)]
    told = {name: attributes[name] for name in OF_RUN if name in attributes}
    told |= {name: run.attrs[name] for name in OF_SOLVER if name in run.attrs}
    contacts = "episode" if "episode" in run.sizes else "contact"
    told |= {"events": run.sizes["event"], "contacts": run.sizes.get(contacts, 0)}
    return [*lines, *lines_of(run, told | scalars_of(run))]


def show_run_up_summary(dataset: xr.Dataset, _most: int | None) -> Description:
    """Return the summary of a run-up."""
    record, _ = tabled(dataset, None)
    if "contact" not in dataset.dims:
        return record, [facts("Summary", lines_of(dataset, scalars_of(dataset)))]
    names = [name for name in names_on(dataset, "contact") if name != "contact_node"]
    lines = [line_of(dataset, name, dataset[name].values.tolist(), 6) for name in names]
    return record, [Sheet("Summary", lines, dataset["contact_node"].values.tolist())]


def _speed_of(run: xr.Dataset, attributes: Record) -> list[Line]:
    """Return the speed of a run, and how it changes."""
    if "speed" not in run:
        unit = "rad/s" if run["t"].attrs.get("units") == "s" else "1"
        return [Line("speed", [attributes["speed"]], unit)] if "speed" in attributes else []
    lines = [line_of(run, "speed", [Range(map(float, course_of(run["speed"].values)))])]
    return lines + [
        Line(name, [attributes[name]], _unit_of(attributes, name))
        for name in ("rate", "torque", "inertia")
        if name in attributes
    ]


def _begun(dataset: xr.Dataset) -> Record:
    """Return from the attributes of a run its start and duration, in the units of the run."""
    attributes = attributes_of(dataset)
    return {each: attributes[each] for each in OF_RUN if each in attributes}


def _largest(dataset: xr.Dataset, name: str) -> float:
    values = dataset[name].values if name in dataset else np.empty(0)
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else math.nan


def show_sweep(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the responses of a sweep or diagram, with their number by kind."""
    record, parts = tabled(dataset, most, POINTS)
    return record | {"starts": _starts(dataset)}, [
        count_of_kinds(dataset), *_legend(dataset), *parts
    ]  # fmt: skip


def _starts(dataset: xr.Dataset) -> list[Record]:
    """Return the starts of many motions: states, or words that stand for one of each rotor."""
    words, rows = _words_of_starts(dataset), rows_of(dataset, STARTS)
    return [row if word == "state" else {"start": word}
            for word, row in zip(words or ["state"] * len(rows), rows, strict=True)]  # fmt: skip


def _words_of_starts(dataset: xr.Dataset) -> list[str]:
    """Return the words of the starts in a result, "state" for a state; none if all are states."""
    words = str(dataset.attrs.get("start_words", "")).split()
    return [words[number] for number in np.ravel(dataset["start"]).tolist()] if words else []


def _legend(dataset: xr.Dataset) -> list[str]:
    """Return a line with the number of each start that was given by a word."""
    pairs = zip(np.ravel(dataset["start"]), _words_of_starts(dataset), strict=False)
    told = [f"{number} {word}" for number, word in pairs if word != "state"]
    return [f"Starts: {', '.join(told)}"] if told else []


def show_run_ups(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the endings of run-ups at each rate of each rotor, and every run-up."""
    given = (
        {"starts": _starts(dataset)}
        if "start_x" in dataset.variables
        else {"contacts": rows_of(
            dataset, (str(clearance_of_contacts(dataset).name), "contact_node")
        )}
    )  # fmt: skip
    dataset = _worst_of_contacts(dataset) if "contact" in dataset.dims else dataset
    record, tables = tabled(dataset, most, RUN_UPS)
    names = dict.fromkeys(("speed", *ALL_PARAMETERS, *PARAMETERS_OF_SYSTEM))
    told = [name for name in names if name in dataset.variables]
    varied = [name for name in told if dataset[name].size > 1]
    parts = [f"{word}_fraction" for word in ENDS_IN_WORDS]
    errors = [f"{name}_error" for name in parts]
    fractions = rows_of(dataset, (*parts, *errors, "failed_count", "rate", *told))
    over = [name for name in COUNTED if name in dataset["largest_force"].dims]
    worst = dataset["largest_force"].max(over).values.ravel().tolist()
    for row, force in zip(fractions, worst, strict=True):
        row["largest_force"] = force
    said = [name for name in parts if any(row[name] != 0.0 for row in fractions)]
    columns = ["rate", *varied, *said, *(f"{name}_error" for name in said), "largest_force"]
    to = line_of(dataset, "to", [float(dataset["to"])])
    last = quantity(float(str(to.values[0])), to.unit, 6)
    lines = [line_of(dataset, name, [row[name] for row in fractions[:MOST_FRACTIONS]], 6)
             for name in columns]  # fmt: skip
    title = counted(f"How run-ups to {last} end", len(fractions), MOST_FRACTIONS)
    record |= {"to": float(dataset["to"]), **given, "fractions": fractions}
    sheet = Sheet(title, lines, note=why_unresolved(dataset))
    return record, [sheet, *_legend(dataset), *tables]


def _worst_of_contacts(dataset: xr.Dataset) -> xr.Dataset:
    """Return run-ups of a rotor system with the worst of all contacts of each."""
    told = dataset.drop_dims([dim for dim in dataset.dims if dim not in dataset["ending"].dims])
    if not dataset.sizes["contact"]:
        return told.assign(largest_force=xr.zeros_like(told["end_angle"]))
    worst = {name: dataset[name].max("contact") for name in ("excursion", "largest_force")}
    way = 2.0 * (dataset["rate"] > 0.0) - 1.0
    worst["first_touch_speed"] = way * (way * dataset["first_touch_speed"]).min("contact")
    for name, each in worst.items():
        each.attrs = dataset[name].attrs
    return told.assign(worst)


def count_of_kinds(dataset: xr.Dataset, ranges: Sequence[str] = RANGES) -> Sheet:
    """Return a table of the number of points of each kind, and their ranges."""
    response = dataset["response"]
    words = response.copy(data=np.reshape(words_of(response), response.shape))
    found, first = np.unique(words, return_index=True)
    kinds = found[np.argsort(first)].tolist()
    dims = set(response.dims)
    # a diagram has no amplitudes
    names = [name for name in ranges if name in dataset and set(dataset[name].dims) <= dims]
    lines = [
        Line("response", kinds),
        Line("points", [int((words == each).sum()) for each in kinds]),
    ]
    places = [(dataset, words == each) for each in kinds]
    lines += [range_of(name, places) for name in names]
    return Sheet("Responses by kind", lines, note=why_unresolved(dataset))


def why_unresolved(dataset: xr.Dataset) -> str:
    """Return for how long unresolved motions were followed, and what still moved; empty if none."""
    if not {"response", "message"} <= dataset.variables.keys():
        return ""
    unresolved = dataset["response"].values == RESPONSE["unresolved"]
    said = dict.fromkeys(filter(None, np.ravel(dataset["message"].values[unresolved]).tolist()))
    first, more = [*said][:MOST_REASONS], len(said) - MOST_REASONS
    others = [f"{more} other reasons (all with --json)"] if more > 0 else []
    return f"Unresolved: {'; '.join([*first, *others])}." if said else ""


def range_of(name: str, places: Sequence[tuple[xr.Dataset, xr.DataArray]]) -> Line:
    """Return the range of a variable over the points of each dataset that a mask leaves."""
    found = []
    for dataset, here in places:
        values = dataset[name].broadcast_like(here)
        mask = here.broadcast_like(values).transpose(*values.dims)
        found.append(span(values.values[mask.values]))
    return line_of(places[0][0], name, found, 6)


def show_section(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the points of a section, first whether they repeat."""
    record, parts = _SECTION(dataset, most)
    count, places = dataset.sizes["crossing"], places_of_section(dataset)
    at = str(dataset.attrs.get("section", "revolution"))
    one, many = CROSSINGS.get(at, (at, f"{at}s"))
    same = f"to {100.0 * WITHIN:g} %: the motion repeats"
    if count < 2:
        first = "One point" if count else "No points"
        said = f"{first}: too few to tell whether the motion repeats."
    elif places == 1:
        said = f"{count} points in one place, {same} at every {one}."
    elif places:
        said = f"{count} points in {places} places, {same} after {places} {many}."
    else:
        said = (
            f"{count} points that do not repeat after up to {count // 2} {many}: the motion has "
            "not settled, or is quasi-periodic or chaotic."
        )
    return {**record, "places": places}, [said, *parts]


def places_of_section(dataset: xr.Dataset) -> int:
    """Return after how many points those of a section repeat; 0 if they do not.

    Displacements and velocities are compared with their largest value at any point and node.
    """
    states = []
    if dataset.sizes["crossing"] < 2:
        return 0
    for pair in (("rotating_x", "rotating_y"), ("rotating_vx", "rotating_vy")):
        both = np.stack([dataset[name].transpose("crossing", ...).values for name in pair], axis=-1)
        largest = np.linalg.norm(both, axis=-1).max(initial=0.0)
        states.append(both.reshape(len(both), -1) / (largest or 1.0))
    points = np.concatenate(states, axis=1)
    for lag in range(1, len(points) // 2 + 1):
        if np.abs(points[lag:] - points[:-lag]).max() <= WITHIN:
            return lag
    return 0


def show_comparison(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the number of responses that lie on an exact one, and each point."""
    from rotor_ida.verification.compare import summarise  # noqa: PLC0415 - only this kind needs it

    record, parts = tabled(dataset, most, COMPARED)
    record["summary"] = summary = summarise(dataset)
    # only the kinds of response that occur
    none = {name for name in RESPONSE if all(row.get(name) == 0 for row in summary)}
    title = "On an exact whirl or limit cycle, by clearance"
    columns = [line_of(dataset, name, [row[name] for row in summary])
               for name in summary[0] if name not in none]  # fmt: skip
    return record, [Sheet(title, columns), *parts]


def show_cycle(dataset: xr.Dataset, most: int | None) -> Description:
    """Return a limit cycle with its multipliers, and its strongest lines or its contacts."""
    is_system = "contact" in dataset.dims
    rows = (CONTACTS_OF_CYCLE, NODES_OF_CYCLE) if is_system else (STRONGEST_LINES,)
    record, parts = tabled(dataset, most, MULTIPLIERS, *rows)
    parameters = parameters_in(dataset) | {"start": record.pop("start", None)}
    if is_system:
        parameters = {SPEED: float(dataset[SPEED])}
    else:
        record["lines"] = rows_of(dataset, STRONGEST_LINES.names)  # to programs by frequency
    record["parameters"] = parameters
    if dataset["period"].isnull():
        said = f"No limit cycle: the response is {record['response']}."
        return record, [said, *filter(None, [why_unresolved(dataset)])]
    told = lines_of(dataset, parameters | scalars_of(dataset))
    error = float(dataset["period_error"] / dataset["period"])
    told = [replace(each, values=[error], unit="1", digits=1, note="of the period")
            if each.name == "period error" else each for each in told]  # fmt: skip
    # multipliers of a contact with friction are not paired, so that there is no defect
    told = [
        each
        for each in told
        if not (each.name.endswith("defect") and math.isnan(float(str(each.values[0]))))
    ]
    return record, [facts("Limit cycle", told), *parts]


def show_cycles(dataset: xr.Dataset, most: int | None) -> Description:
    """Return limit cycles at points, with their number by kind and the ranges of their numbers."""
    told = dataset.drop_dims([dim for dim in dataset.dims if dim not in dataset["response"].dims])
    worst = [name for name in ("radius_max", "largest_force") if name not in told]
    told = told.assign({name: dataset[name].max("contact", keep_attrs=True) for name in worst})
    record, parts = tabled(told, most, CYCLES)
    return record, [count_of_kinds(told, OF_CYCLES), *parts]


def show_branch(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the ends, special points and stable ranges of a branch."""
    varied = parameters_of("branch", dataset, "parameter", 1)
    record, parts = _followed("Branch of limit cycles", dataset, varied, most)
    ranges = stable_ranges(dataset)
    record["stable_ranges"] = [{"from": low, "to": high} for low, high in ranges]
    stable = [line_of(dataset, varied[0], [Range(each)]) for each in ranges]
    title = counted("Stable ranges", len(ranges), most)
    return record, [*parts, facts(title, stable[:most]) if ranges else title]


def show_curve(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the ends and special points of a bifurcation curve."""
    varied = parameters_of("curve", dataset, "parameters", 2)
    kind = str(dataset.attrs.get("kind", "")).replace("_", " ")
    return _followed(f"{kind.capitalize()} curve", dataset, varied, most)


def _followed(title: str, dataset: xr.Dataset, varied: list[str], most: int | None) -> Description:
    """Return the common description of a branch and a bifurcation curve."""
    plain = dataset.copy()
    plain.attrs = {RENAMED.get(str(name), str(name)): each for name, each in dataset.attrs.items()}
    for name, value in zip(varied, SPECIAL_VALUES, strict=False):
        if name == SPEED and plain[value].attrs.get("units") == UNITS["speed"]:
            plain[value] = plain[value].assign_attrs(units="rad/s")  # read in rpm
    points = Rows(title="Points", key="points", lead=varied[0], names=tuple(varied))
    record, (_, specials) = tabled(plain, most, points, SPECIAL_POINTS)
    own: tuple[str, ...] = ("period", "radius_min", "radius_max")
    contacts: list[Sheet | str] = []
    if is_system := "contact" in dataset.dims:
        own = ("period",)
        more, contacts = tabled(_over_points(dataset), most, CONTACTS_OF_BRANCH)
        record["contacts"] = more["contacts"]
    held = parameters_in(dataset.drop_vars(varied))
    if is_system and SPEED not in varied:
        held[SPEED] = float(dataset[SPEED])
    record["parameters"] = held
    record |= {name: record.get(name, "") for name in ENDS_OF_BRANCH}
    record["closed"] = bool(record.get("closed", False))
    ranges: Record = {name: span(dataset[name].values)
                      for name in (*varied, *own)}  # fmt: skip
    told = {name: record[name] for name in (*ENDS_OF_BRANCH, "closed") if record[name] != ""}
    summary = held | ranges | {"points": dataset.sizes["point"]} | told
    return record, [facts(title, lines_of(dataset, summary)), specials, *contacts]


def _over_points(dataset: xr.Dataset) -> xr.Dataset:
    """Return the contacts of a branch or curve with the extremes of their numbers along it."""
    largest = dataset[["radius_max", "largest_force"]].max("point", keep_attrs=True)
    lowest = dataset["radius_min"].min("point", keep_attrs=True)
    return largest.assign(radius_min=lowest, contact_node=dataset["contact_node"])


def show_fit(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the estimates of a fit, their constraint by the signals, and the residuals."""
    record, _ = tabled(dataset, most, FITTED)
    numbers = [name for name in FITTED.names if name not in {"unknown", "unit"}]
    rounded = [float(f"{each:.{OF_ERROR}g}") for each in dataset["standard_error"].values]
    rows = rows_of(dataset.assign(standard_error=("unknown", rounded)), FITTED.names)
    lines = [Line(str(row["unknown"]), [row[name] for name in numbers],
                  str(row["unit"]), OF_FITTED)
             for row in rows]  # fmt: skip
    heads = [name.replace("_", " ") for name in numbers]
    told = [f"{each}." for each in str(dataset.attrs.get("identifiability", "")).split("; ")]
    if "unbalance_angle" in dataset["unknown"].values:
        told.append(OF_ANGLE)
    summary: Record = {
        "machine": dataset.attrs.get("machine", ""),
        "windows": dataset.sizes["window"],
    }
    last = ("search", "remainder", "contact_times", "columns", "notes")
    summary |= {name: record[name] for name in (*OF_FIT, *last) if name in record}
    record |= summary | {"identifiability": told}
    title = counted(FITTED.title, len(lines), None)
    return record, [facts("Fit", lines_of(dataset, summary)), Sheet(title, lines, heads), *told]
