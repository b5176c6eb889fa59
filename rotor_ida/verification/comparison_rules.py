"""How a result of each kind is compared with one computed again: `VERIFIED`.

A row says what a result must have, and what of it another processor does not repeat. How much
numbers may differ is in `rotor_ida.schema.tolerances` (`TOLERANCE_OF_KIND`).
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
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.results.archived_system import NEEDED, PROBLEM
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.schema import RESPONSE
from rotor_ida.schema.tolerances import TOLERANCE, TOLERANCE_OF_KIND
from rotor_ida.verification.variables import OF_ONE_STRETCH, PERIODIC
from rotor_ida.verification.without_question import SOLVER, STARTS

Reasons = Mapping[str, str]
HOW = (*SOLVER, "flight")
# How much more numbers of a contact may differ than its times do over its duration.
LATE = 100.0
# Ends of a branch that do not depend on its steps.
SHARP = ("limits", "closed", "halved", "hopf", "start")
TRANSIENT = "depends on the way to the steady state"
NOTHING_LOST = "without damping it is 0, or in older archives rounding"
STEPS = "the steps along it depend on rounding; its special points and ends are compared"
MARGINAL = "at a bifurcation a multiplier lies on the unit circle, on which side is rounding"
BEHIND_HORIZON = "some drops end behind their horizon, where another processor drops otherwise"
STATES = tuple(f"rotating_{name}" for name in COMPONENTS)


def tolerance_of(dataset: xr.Dataset) -> float:
    """Return the difference allowed for the numbers of a kind of result."""
    return TOLERANCE_OF_KIND.get(kind_of(dataset), TOLERANCE)


@dataclass(frozen=True, slots=True)
class Verification:
    """How results of one kind are compared with those computed again."""

    variables: tuple[str, ...]  # numbers that are needed
    attributes: tuple[str, ...] = ()
    # Why variables are not compared, by name or dimension.
    left_out: Callable[[xr.Dataset, xr.Dataset], Reasons] = lambda _, __: {}
    tolerance: Callable[[xr.Dataset], float] = tolerance_of
    # Where numbers belong to the motion, on any processor.
    told: Callable[[xr.Dataset], xr.Variable | None] = lambda _: None
    # What is compared besides, as variables.
    also: Callable[[xr.Dataset], Mapping[str, Any]] = lambda _: {}


def _without_damping(_again: xr.Dataset, archived: xr.Dataset) -> Reasons:
    """Return why the energy that contacts take is not compared where they have no damping."""
    damped = bool((archived["law_damping"] > 0.0).any())
    return {} if damped else {"energy_lost": NOTHING_LOST}


def _ends_of_attractors(_again: xr.Dataset, _archived: xr.Dataset) -> Reasons:
    """Return why the state at which a start of a rotor system ended is not compared."""
    return {"final_state": TRANSIENT}


def _transients(_again: xr.Dataset, archived: xr.Dataset) -> Reasons:
    """Return why numbers of the way to a steady state are not compared."""
    names = ("event", "event_count", "event_row", *(f"end_{name}" for name in COMPONENTS))
    return {name: TRANSIENT for name in names if name in (*archived.dims, *archived.variables)}


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


NUMBERS = ("amplitude", "phase_lag", "radius_min", "radius_max")
_RANGES = tuple(f"range_{name}" for name in COMPONENTS)
_BEGUN_OF_SYSTEM = ("start", "start_speed", "start_period", "start_special", "limits", "points")
_BEGUN = ("start", "start_period", *(f"start_{name}" for name in PARAMETERS))
_SYSTEM_RUN = Verification(
    ("event_time", "event_time_error", "event_contact", "t", *NEEDED),
    ("duration", "rtol", "method"), _without_damping, tolerance=tolerance_of_run,
)  # fmt: skip
VERIFIED = {
    "run": Verification(("event_time", "event_time_error", "t"),
        (*PARAMETERS, "start", "duration", *HOW), tolerance=tolerance_of_run),
    "sweep": Verification(("event_count", "response", "direction", *STARTS, *PARAMETERS, *NUMBERS),
        HOW, _transients),
    "run_ups": Verification(
        ("ending", "response", "rate", "phase", "to", *STARTS, *PARAMETERS, *NUMBERS), SOLVER),
    "bifurcation_diagram": Verification(
        ("extremum_radius", "extremum_count", "response", *STARTS, *PARAMETERS),
        (*SOLVER, "extrema_time"), _stretches),
    "stroboscopic_diagram": Verification(("response", *STATES, *STARTS, *PARAMETERS),
        (*SOLVER, "revolutions", "phase")),
    "section": Verification(("crossing_time", *STATES, *PARAMETERS),
        (*SOLVER, "revolutions", "skip")),
    "basin": Verification(("label", "settling_time", "kind", *COMPONENTS, *NUMBERS),
        (*PARAMETERS, "labelling_rtol"), _ends_of_attractors),
    "basin_fractions": Verification(("response_fraction", "count", "kind", *NUMBERS),
        (*PARAMETERS, "labelling_rtol", "starts", "seed", *_RANGES), _ends_of_attractors),
    "atlas": Verification(("missed_fraction", "count", "kind", *PARAMETERS, *NUMBERS),
        ("labelling_rtol", "starts"), lambda _, __: {"target": "shocks are not computed again"}),
    "system_atlas": Verification(("missed_fraction", "count", "kind", "speed", *NUMBERS),
        ("labelling_rtol", "starts"), _ends_of_attractors),
    **dict.fromkeys(("touchdown", "system_touchdown"), Verification(
        ("missed_fraction", "fraction", "kind", *NUMBERS[2:]), ("labelling_rtol", "starts"),
        _ends_of_attractors,
    )),
    "whirls": Verification(("amplitude", *PARAMETERS)),
    "folds": Verification(("fold_omega", "zeta", "delta0")),
    "hopf_points": Verification(("hopf_omega", "zeta", "delta0")),
    "cycle": Verification(("period_error", "multiplier_real", "multiplier_imag"),
        (*PARAMETERS, "start")),
    "cycles": Verification(("response", "stability", "period", "multiplier_real", "radius_max"),
        ("rtol",), lambda _, __: dict.fromkeys((*COMPONENTS, "final_state"), TRANSIENT)),
    "branch": Verification(("special_value", "special_period", "slope", "stability"),
        ("parameter", "limits", "direction", "points", "start_special", *_BEGUN), _steps,
        also=_ends),
    "curve": Verification(("special_second_value", "special_value", "special_period"),
        ("kind", "parameters", "limits", "points", *_BEGUN), _steps_of_curve, also=_ends),
    "system_run": _SYSTEM_RUN,
    "drop": _SYSTEM_RUN,
    "drop_ensemble": Verification(("horizon", "status", "largest_force", "contact_count"),
        ("duration",), _undecided, told=_decided),
    "system_sweep": Verification(("response", "direction", "touched", "period", *NUMBERS),
        ("rtol",), lambda _, __: {"final_state": TRANSIENT}),
    "system_diagram": Verification(("extremum_radius", "extremum_count", "response", "touched"),
        ("rtol", "revolutions"), _stretches),
    "system_stroboscopic_diagram": Verification(("response", "touched", *STATES),
        ("rtol", "revolutions", "phase")),
    "system_section": Verification(
        ("crossing_time", "crossing_state", "final_state", *STATES, *PROBLEM),
        ("rtol", "speed", "revolutions", "skip")),
    "system_run_ups": Verification(("ending", "response", "rate", "phase", "to", *NUMBERS),
        ("rtol",)),
    "system_whirls": Verification(("amplitude", "normal_force", "growth_rate", "speed", *PROBLEM)),
    "unbalance_response": Verification(
        ("node_major_axis", "unbalance_radius", "critical_speed", "peak_major_axis", "speed",
         *PROBLEM)),
    "system_special_points": Verification(("special_speed", "special_kind", "amplitude", *PROBLEM),
        ("limits", "points")),
    "system_cycle": Verification(("period", "multiplier_real", "speed", "final_state", *PROBLEM)),
    "system_branch": Verification(("special_kind", "special_value", "special_period", *PROBLEM),
        ("parameter", "direction", *_BEGUN_OF_SYSTEM), _steps, also=_ends),
    "system_curve": Verification(
        ("special_second_value", "special_value", "special_period", *PROBLEM),
        ("kind", "parameters", *_BEGUN_OF_SYSTEM), _steps_of_curve, also=_ends),
    "campbell": Verification(
        ("whirl_speed", "damping_ratio", "speed", "contact_stiffness", *PROBLEM)),
    "clearance_report": Verification(("scale_factor", "running_share", "vibration_limit", *PROBLEM),
        ("multiple", "points", "running_speeds")),
}  # fmt: skip
