"""How limit cycles of one disc, their branches and bifurcation curves are verified.

The steps along a branch may differ on another machine, so its points are not compared. Results
that do not depend on the steps are: the special points, the ends and the stable ranges.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.bifurcation_curve import bifurcation_curve
from rotor_ida.cycles.branch_course import course_of, parameters_of, stable_ranges
from rotor_ida.cycles.continue_cycle import branch_from
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.limit_cycle import limit_cycle
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, PARAMETERS
from rotor_ida.parallel import Progress
from rotor_ida.schema import SPECIAL, words_of
from rotor_ida.verification.verify import (
    Verdict,
    Verification,
    counts_of,
    relative_differences,
    rotor_in,
)

# Ends of a branch that do not depend on its steps.
SHARP = ("limits", "closed", "halved", "hopf", "start")
# Relative difference allowed between machines. Lengths, forces and multipliers are of order 1.
CLOSE = 1e-8
OF_SIZE_ONE = ("radius", "largest_force", "multiplier")
STEPS = "the steps along it depend on rounding; its special points and ends are compared"
# Facts of cycles that are compared, by name.
Facts = dict[str, object]


def _cycle(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    return limit_cycle(rotor_in(dataset), start=given["start"], period=given.get("start_period"))


def _branch(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    given, (parameter,) = dataset.attrs, parameters_of("branch", dataset, "parameter", 1)
    guess = Guess(
        rotor_in(dataset, "start_"), np.array(given["start"]), float(given["start_period"]),
        str(given["start_special"]), float(given["start_slope"]),
    )  # fmt: skip
    low, high = np.asarray(given["limits"]).tolist()
    direction, points = str(given["direction"]), int(given["points"])
    return branch_from(guess, parameter, (low, high), direction, points, progress=progress)


def _curve(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    given, (first, second) = dataset.attrs, parameters_of("curve", dataset, "parameters", 2)
    rotor, kind = rotor_in(dataset, "start_"), given["kind"]
    place = {name: getattr(rotor, name) for name in (*PARAMETERS, *FRICTIONLESS)}
    state = zip(COMPONENTS, np.asarray(given["start"]).tolist(), strict=True)
    special = {f"special_{name}": value for name, value in state}
    special |= {"special_period": given["start_period"], "special_kind": SPECIAL[kind]}
    special["special_value"] = place[first]
    low, high, second_low, second_high = given["limits"]
    return bifurcation_curve(
        rotor,
        start=xr.Dataset(special, place, {"parameter": first}),
        kind=kind,
        parameters=(first, second),
        limits=((low, high), (second_low, second_high)),
        points=int(given["points"]),
        progress=progress,
    )


def _facts(
    facts_of: Callable[[xr.Dataset], Facts], again: xr.Dataset, archived: xr.Dataset
) -> Verdict:
    """Compare single facts of cycles: numbers within a tolerance, anything else exactly."""
    facts, found = facts_of(archived), facts_of(again)
    trouble, differing, largest = "", 0, 0.0
    for name, value in facts.items():
        here = found.get(name)
        agrees = here == value
        if isinstance(value, float) and isinstance(here, float):
            apart = float(
                relative_differences(here, value, 1.0 if name.startswith(OF_SIZE_ONE) else 0.0)
            )
            largest, agrees = max(largest, apart), apart <= CLOSE
        differing += not agrees
        if not agrees and not trouble:
            trouble = f"{name} differs: computed again {here}, archived {value}"
    return counts_of(len(facts), differing, largest), trouble


def _of_cycle(dataset: xr.Dataset) -> Facts:
    facts: Facts = {"response": words_of(dataset["response"])[0]}
    if dataset["period"].isnull():
        return facts
    facts["stability"] = words_of(dataset["stability"])[0]
    facts["contact_count"] = int(dataset["contact_count"])
    names = ("period", "radius_min", "radius_max", "largest_force")
    facts |= {name: float(dataset[name]) for name in names}
    for name in ("multiplier_real", "multiplier_imag"):
        values = dataset[name].values.tolist()
        facts |= {f"{name} {number}": value for number, value in enumerate(values)}
    return facts


def _of_curve(dataset: xr.Dataset) -> Facts:
    facts: Facts = {}
    for place, end in ((0, "first_end"), (-1, "last_end")):
        facts[end] = dataset.attrs.get(end, "")
        if facts[end] in SHARP:
            point, where = dataset.isel(point=place), end.replace("_", " ")
            names = [name for name in ALL_PARAMETERS if name in dataset.variables]
            names += ["period", "radius_min", "radius_max"]
            facts |= {f"{name} at the {where}": float(point[name]) for name in names}
    facts["the number of special points"] = dataset.sizes["special"]
    for number, word in enumerate(words_of(dataset["special_kind"])):
        facts[f"the kind of special point {number}"] = word
        for name in ("value", "second_value", "period", "radius_min", "radius_max"):
            if f"special_{name}" in dataset:
                value = float(dataset[f"special_{name}"].values[number])
                facts[f"{name} of special point {number}"] = value
    return facts


def _of_branch(dataset: xr.Dataset) -> Facts:
    facts = _of_curve(dataset)
    if facts["first_end"] in SHARP and facts["last_end"] in SHARP:
        values, ranges = course_of(dataset).value, stable_ranges(dataset)
        facts["the smallest value of the parameter"] = float(values.min())
        facts["the largest value of the parameter"] = float(values.max())
        facts["the number of stable ranges"] = len(ranges)
        for number, (low, high) in enumerate(ranges):
            facts[f"the beginning of stable range {number}"] = low
            facts[f"the end of stable range {number}"] = high
    return facts


def of_steps(parameter: str, again: xr.Dataset, archived: xr.Dataset) -> dict[str, str]:
    """Return why the points of a branch are not compared, unless all its steps are equal."""
    here, there = again[parameter].values, archived[parameter].values
    same = here.shape == there.shape and np.median(relative_differences(here, there)) <= CLOSE
    return {} if same else dict.fromkeys(("point", "special_point"), STEPS)


def _of_branch_steps(again: xr.Dataset, archived: xr.Dataset) -> dict[str, str]:
    return of_steps(str(archived.attrs["parameter"]), again, archived)


def _of_curve_steps(again: xr.Dataset, archived: xr.Dataset) -> dict[str, str]:
    return of_steps(parameters_of("curve", archived, "parameters", 2)[0], again, archived)


_BEGUN = ("start", "start_period", *(f"start_{name}" for name in PARAMETERS))
CYCLE = Verification(
    ("period_error", "multiplier_real", "multiplier_imag"),
    (*PARAMETERS, "start"),
    _cycle,
    partial(_facts, _of_cycle),
    ALL_PARAMETERS,
)
CURVE = Verification(
    ("special_second_value", "special_value", "special_period"),
    ("kind", "parameters", "limits", "points", *_BEGUN),
    _curve,
    partial(_facts, _of_curve),
    left_out=_of_curve_steps,
)
BRANCH = Verification(
    ("special_value", "special_period", "slope", "stability"),
    ("parameter", "limits", "direction", "points", "start_special", *_BEGUN),
    _branch,
    partial(_facts, _of_branch),
    left_out=_of_branch_steps,
)
