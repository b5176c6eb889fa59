"""Compute limit cycles, branches and bifurcation curves again, and say in what they differ.

On another machine the steps along a branch may fall elsewhere, so its points are not compared. What
does not hang on the steps is: the special points, the ends, and where it is stable.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from rotor_ida.analysis.branch_course import course_of, parameters_of, stable_ranges
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.bifurcation_curve import bifurcation_curve
from rotor_ida.cycles.continue_cycle import branch_from
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.limit_cycle import limit_cycle
from rotor_ida.parallel import Progress
from rotor_ida.parameters import PARAMETERS, Rotor
from rotor_ida.schema import SPECIAL, words_of

START = ("start", "start_period", *(f"start_{name}" for name in PARAMETERS))
# Variables by which each kind is known, and attributes that it takes to compute it again.
NEEDED_OF_CYCLES = {
    "cycle": (("period_error", "multiplier_real", "multiplier_imag"), (*PARAMETERS, "start")),
    "curve": (
        ("special_second_value", "special_value", "special_period"),
        ("kind", "parameters", "limits", "points", *START),
    ),
    "branch": (
        ("special_value", "special_period", "slope", "stability"),
        ("parameter", "limits", "direction", "points", "start_special", *START),
    ),
}
# How far numbers may be off on another machine, relative to their size; lengths and multipliers are
# of the size of 1.
CLOSE = 1e-8
# Ends of a branch that do not hang on its steps.
SHARP = ("limits", "closed", "halved", "start")

Fact = tuple[str, object, float]


def cycles_again(dataset: xr.Dataset, kind: str, progress: Progress | None) -> xr.Dataset:
    """Compute a limit cycle, a branch or a bifurcation curve again from its attributes."""
    if kind == "cycle":
        rotor = Rotor(**{name: dataset.attrs[name] for name in PARAMETERS})
        given = dataset.attrs
        return limit_cycle(rotor, start=given["start"], period=given.get("start_period"))
    return _branch(dataset, progress) if kind == "branch" else _curve(dataset, progress)


def differences_of_cycles(again: xr.Dataset, archived: xr.Dataset, kind: str) -> dict[str, object]:
    """Hold a limit cycle, a branch or a curve made again against that of the archive.

    Returns
    -------
    dict
        As of `rotor_ida.analysis.verification.differences`.
    """
    facts, others = list(_facts(archived, kind)), list(_facts(again, kind))
    found = {name: value for name, value, _ in others}
    trouble, differing, largest = "", 0, 0.0
    for name, value, least in facts:
        here = found.get(name)
        if isinstance(value, float) and isinstance(here, float):
            apart = _apart(here, value, least)
            largest, agrees = max(largest, apart), apart <= CLOSE
        else:
            agrees = here == value
        differing += not agrees
        if not agrees and not trouble:
            trouble = f"{name} differs: made again {here}, archived {value}"
    return {
        "agrees": not trouble,
        "compared": len(facts),
        "differing": differing,
        "largest_difference": largest,
        "trouble": trouble,
    }


def _branch(dataset: xr.Dataset, progress: Progress | None) -> xr.Dataset:
    given, (parameter,) = dataset.attrs, parameters_of("branch", dataset, "parameter", 1)
    guess = Guess(
        _rotor_at_start(dataset), np.array(given["start"]), float(given["start_period"]),
        str(given["start_special"]), float(given["start_slope"]),
    )  # fmt: skip
    low, high = np.asarray(given["limits"]).tolist()
    direction, points = str(given["direction"]), int(given["points"])
    return branch_from(guess, parameter, (low, high), direction, points, progress=progress)


def _curve(dataset: xr.Dataset, progress: Progress | None) -> xr.Dataset:
    given, (first, second) = dataset.attrs, parameters_of("curve", dataset, "parameters", 2)
    rotor, kind = _rotor_at_start(dataset), given["kind"]
    state = zip(COMPONENTS, np.asarray(given["start"]).tolist(), strict=True)
    numbers = {f"special_{name}": value for name, value in state}
    numbers |= {"special_period": given["start_period"], "special_kind": SPECIAL[kind]}
    numbers["special_value"] = getattr(rotor, first)
    place = {name: getattr(rotor, name) for name in PARAMETERS}
    start = xr.Dataset(numbers, place, {"parameter": first})
    low, high, second_low, second_high = given["limits"]
    return bifurcation_curve(
        rotor,
        start=start,
        kind=kind,
        parameters=(first, second),
        limits=((low, high), (second_low, second_high)),
        points=int(given["points"]),
        progress=progress,
    )


def _rotor_at_start(dataset: xr.Dataset) -> Rotor:
    return Rotor(**{name: dataset.attrs[f"start_{name}"] for name in PARAMETERS})


def _facts(dataset: xr.Dataset, kind: str) -> Iterator[Fact]:
    """Yield name and value of all that is compared, and the size below which a number is small."""
    if kind == "cycle":
        yield from _of_cycle(dataset)
        return
    yield from _ends(dataset)
    yield "the number of special points", dataset.sizes["special"], 0.0
    words = words_of(dataset["special_kind"])
    for number, word in enumerate(words):
        yield f"the kind of special point {number}", word, 0.0
        for name, least in (
            ("value", 0.0), ("second_value", 0.0), ("period", 0.0), ("radius_min", 1.0),
            ("radius_max", 1.0),
        ):  # fmt: skip
            if f"special_{name}" in dataset:
                value = float(dataset[f"special_{name}"].values[number])
                yield f"{name} of special point {number}", value, least
    if kind == "branch" and _has_sharp_ends(dataset):
        yield from _ranges(dataset)


def _of_cycle(dataset: xr.Dataset) -> Iterator[Fact]:
    yield "response", words_of(dataset["response"])[0], 0.0
    if dataset["period"].isnull():
        return
    yield "stability", words_of(dataset["stability"])[0], 0.0
    yield "contact_count", int(dataset["contact_count"]), 0.0
    yield "period", float(dataset["period"]), 0.0
    for name in ("radius_min", "radius_max", "largest_force"):
        yield name, float(dataset[name]), 1.0
    for name in ("multiplier_real", "multiplier_imag"):
        for number, value in enumerate(dataset[name].values.tolist()):
            yield f"{name} {number}", value, 1.0


def _ends(dataset: xr.Dataset) -> Iterator[Fact]:
    for place, end in ((0, "first_end"), (-1, "last_end")):
        yield end, dataset.attrs.get(end, ""), 0.0
        if dataset.attrs.get(end) in SHARP:
            point = dataset.isel(point=place)
            for name in (*PARAMETERS, "period"):
                yield f"{name} at the {end.replace('_', ' ')}", float(point[name]), 0.0
            for name in ("radius_min", "radius_max"):
                yield f"{name} at the {end.replace('_', ' ')}", float(point[name]), 1.0


def _has_sharp_ends(dataset: xr.Dataset) -> bool:
    return all(dataset.attrs.get(end) in SHARP for end in ("first_end", "last_end"))


def _ranges(dataset: xr.Dataset) -> Iterator[Fact]:
    values = course_of(dataset).value
    yield "the least value of the parameter", float(values.min()), 0.0
    yield "the largest value of the parameter", float(values.max()), 0.0
    ranges = stable_ranges(dataset)
    yield "the number of stable ranges", len(ranges), 0.0
    for number, (low, high) in enumerate(ranges):
        yield f"the beginning of stable range {number}", low, 0.0
        yield f"the end of stable range {number}", high, 0.0


def _apart(one: float, other: float, least: float) -> float:
    """Return the difference of two numbers, relative to the larger one."""
    if one == other or (np.isnan(one) and np.isnan(other)):
        return 0.0
    apart = abs(one - other) / max(abs(one), abs(other), least)
    return apart if np.isfinite(apart) else float("inf")
