"""How a result of each kind is compared with one computed again: `VERIFIED`.

A row says what of a result another processor does not repeat. How much numbers may differ is in
`rotor_ida.schema.tolerances` (`TOLERANCE_OF_KIND`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch_course import VARIED, course_of, stable_ranges
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.schema import RESPONSE
from rotor_ida.schema.tolerances import TOLERANCE, TOLERANCE_OF_KIND
from rotor_ida.verification.variables import OF_ONE_STRETCH, PERIODIC

Reasons = Mapping[str, str]
# How much more numbers of a contact may differ than its times do over its duration.
LATE = 100.0
# Ends of a branch that do not depend on its steps.
SHARP = ("limits", "closed", "halved", "hopf", "start")
TRANSIENT = "depends on the way to the steady state"
STEPS = "the steps along it depend on rounding; its special points and ends are compared"
MARGINAL = "at a bifurcation a multiplier lies on the unit circle, on which side is rounding"
BEHIND_HORIZON = "some drops end behind their horizon, where another processor drops otherwise"


def tolerance_of(dataset: xr.Dataset) -> float:
    """Return the difference allowed for the numbers of a kind of result."""
    return TOLERANCE_OF_KIND.get(kind_of(dataset), TOLERANCE)


@dataclass(frozen=True, slots=True)
class Verification:
    """How results of one kind are compared with those computed again."""

    # Why variables are not compared, by name or dimension.
    left_out: Callable[[xr.Dataset, xr.Dataset], Reasons] = lambda _, __: {}
    tolerance: Callable[[xr.Dataset], float] = tolerance_of
    # Where numbers belong to the motion, on any processor.
    told: Callable[[xr.Dataset], xr.Variable | None] = lambda _: None
    # What is compared besides, as variables.
    also: Callable[[xr.Dataset], Mapping[str, Any]] = lambda _: {}


def _transient(*names: str) -> Verification:
    """Return the rule by which numbers of the way to a steady state are not compared."""
    return Verification(lambda _, __: dict.fromkeys(names, TRANSIENT))


def _stretches(_again: xr.Dataset, archived: xr.Dataset) -> Reasons:
    """Return why extrema are not compared where some are those of a motion without a period."""
    periodic = archived["response"].isin([RESPONSE[word] for word in PERIODIC]).all()
    names = ("extremum", "extremum_count", "extremum_row")
    return {} if periodic else dict.fromkeys(names, OF_ONE_STRETCH)


def _decided(drops: xr.Dataset) -> xr.Variable:
    """Return which drops do not depend on rounding up to their end."""
    return drops.variables["horizon"] >= float(drops.attrs["duration"])


def _undecided(_again: xr.Dataset, archived: xr.Dataset) -> Reasons:
    """Return why statistics are not compared where drops end behind their horizon."""
    if _decided(archived).all():
        return {}
    own = [str(name) for name, each in archived.data_vars.items() if "drop" not in each.dims]
    return dict.fromkeys(own, BEHIND_HORIZON)


def _along(dataset: xr.Dataset) -> str:
    """Return what varies first along a branch or curve."""
    given = dataset.attrs
    return str(given.get("parameter", given.get("parameters", "speed"))).split()[0]


def _steps(again: xr.Dataset, archived: xr.Dataset) -> Reasons:
    """Return why the points of a branch are not compared, unless all its steps are equal."""
    here, there = (each[_along(archived)].values for each in (again, archived))
    same = here.shape == there.shape and np.median(np.abs(here / there - 1.0)) <= 1e-8
    return {} if same else dict.fromkeys(("point", "special_point"), STEPS)


def _steps_of_curve(again: xr.Dataset, archived: xr.Dataset) -> Reasons:
    """Return the same of a curve, where rounding decides on which side a multiplier lies too."""
    names = ("stability", "trace", "multiplier_real", "multiplier_imag")
    return {**_steps(again, archived), **dict.fromkeys(names, MARGINAL)}


def _ends(dataset: xr.Dataset) -> dict[str, Any]:
    """Return what of a branch or curve does not depend on its steps, besides special points."""
    found: dict[str, Any] = {}
    ends = {"first_end": 0, "last_end": -1}
    words = {end: str(dataset.attrs.get(end, "")) for end in ends}
    for end, place in ends.items():
        found[end] = words[end]
        if words[end] in SHARP:
            at_end = dataset.isel(point=place)
            names = dict.fromkeys(name for name in VARIED if name in dataset.coords)
            for name in (*names, "period", "radius_min", "radius_max"):
                found[f"{name} at the {end}"] = (at_end[name].dims, at_end[name].values)
    if "parameter" in dataset.attrs and set(words.values()) <= set(SHARP):
        values = course_of(dataset).value
        found["extremes of the parameter"] = ("extreme", [values.min(), values.max()])
        found["stable ranges"] = (
            ("range", "limit"),
            np.array(stable_ranges(dataset)).reshape(-1, 2),
        )
    return found


def tolerance_of_run(run: xr.Dataset) -> float:
    """Return the difference allowed for numbers of a run: its events are as late as is stated."""
    stated = float(run["event_time_error"].max()) if run["event_time_error"].size else 0.0
    lasting = run["contact_duration"].values if "contact_duration" in run else np.zeros(0)
    shortest = float(lasting[lasting > 0.0].min(initial=math.inf))
    return max(TOLERANCE, float(run.attrs["rtol"]) * 1e4, LATE * stated / shortest)


VERIFIED = {
    **dict.fromkeys(
        ("run_ups", "stroboscopic_diagram", "section", "whirls", "folds", "hopf_points", "cycle",
         "system_stroboscopic_diagram", "system_section", "system_run_ups", "system_whirls",
         "unbalance_response", "system_special_points", "system_cycle", "campbell",
         "clearance_report"),
        Verification(),
    ),
    **dict.fromkeys(("run", "system_run", "drop"), Verification(tolerance=tolerance_of_run)),
    "sweep": _transient(
        "event", "event_count", "event_row", *(f"end_{each}" for each in COMPONENTS)
    ),
    "cycles": _transient("final_state", *COMPONENTS),
    **dict.fromkeys(("bifurcation_diagram", "system_diagram"), Verification(_stretches)),
    **dict.fromkeys(
        ("basin", "basin_fractions", "system_atlas", "touchdown", "system_touchdown",
         "system_sweep"), _transient("final_state"),
    ),
    "atlas": Verification(lambda _, __: {"target": "shocks are not computed again"}),
    **dict.fromkeys(("branch", "system_branch"), Verification(_steps, also=_ends)),
    **dict.fromkeys(("curve", "system_curve"), Verification(_steps_of_curve, also=_ends)),
    "drop_ensemble": Verification(_undecided, told=_decided),
}  # fmt: skip
