"""How results of rotor systems are verified: runs, sweeps, and those over the speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.cycles.system_branch import branch_from, guess_in
from rotor_ida.cycles.system_cycle import limit_cycle_system
from rotor_ida.cycles.system_guess import CycleProblem
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.parallel import Progress
from rotor_ida.steady.drop_ensemble import drop_ensemble
from rotor_ida.steady.system_sweep import sweep_system
from rotor_ida.systems.archived import NAMES, NEEDED, PROBLEM, problem_of
from rotor_ida.systems.campbell import campbell
from rotor_ida.systems.clearances.report import clearance_report
from rotor_ida.systems.drop import drop
from rotor_ida.systems.drop_design import DESIGN, case_from, design_in
from rotor_ida.systems.simulate import run_up_system, simulate_system
from rotor_ida.systems.whirls.special_speeds import special_speeds
from rotor_ida.systems.whirls.synchronous import synchronous_response_system
from rotor_ida.verification.verify import Verdict, Verification, counts_of
from rotor_ida.verification.verify_cycles import of_steps
from rotor_ida.verification.verify_motions import (
    NUMBERS,
    TRANSIENT,
    change_in,
    compare_events,
    compare_points,
    direction_of,
    tolerance_of_run,
)

# What a result of a system is computed from.
OF_SYSTEM = (
    *NEEDED, *NAMES, "damping_matrix", "gyroscopic_matrix", "stiffness_rate_matrix",
    "axial_position",
)  # fmt: skip
# What a drop is computed from besides.
OF_DROP = ("design", "support_node", "support_fails", "support_stiffness", "support_damping",
           "node_clearance", "load_capacity")  # fmt: skip
BEHIND_HORIZON = "some drops end behind their horizon, where another processor drops otherwise"
# Differences allowed between machines, relative to the largest number of a variable.
CLOSE = 1e-8


def _archived(dataset: xr.Dataset, what: str = "result") -> tuple[RotorSystem, list[Any]]:
    """Return the system of a result, and its starts."""
    try:
        return problem_of(dataset)
    except (IndexError, ValueError) as error:
        raise InputError(f"this {what} of a system cannot be verified: {error}") from error


def _run(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    system, starts = _archived(dataset, "run")
    given = dataset.attrs
    how: dict[str, Any] = {name: given[name] for name in ("duration", "rtol", "method")}
    how |= {"start": starts[0], "samples": dataset["t"].values, "progress": progress}
    if "event_speed" not in dataset:
        return simulate_system(system, **how, speed=given.get("speed"))  # type: ignore[arg-type]
    changes = change_in(dataset)
    if "speeds" not in changes:
        changes["speed"] = given.get("start_speed")
    return run_up_system(system, **how, **changes)


def _drop(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    if DESIGN not in dataset:  # an older archive
        return _run(dataset, workers, progress)
    case = case_of("drop", dataset)
    case |= {"method": dataset.attrs["method"], "samples": dataset["t"].values}
    return drop(**case, progress=progress)


def _drops(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    design = design_in(dataset)
    given = case_of("ensemble", dataset) | design["varied"]
    numbers = {name: design[name] for name in ("drops", "seed")}
    return drop_ensemble(**given, **numbers, workers=workers, progress=progress)


def case_of(what: str, dataset: xr.Dataset) -> dict[str, Any]:
    """Return the arguments of `drop` in a dataset."""
    try:
        return case_from(design_in(dataset))
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"this {what} cannot be verified: {error}") from error


def _sweep(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    system, starts = _archived(dataset, "sweep")
    return sweep_system(
        system, starts=starts, speed=dataset["speed"].values, direction=direction_of(dataset),
        rtol=dataset.attrs["rtol"], workers=workers, progress=progress,
    )  # fmt: skip


def _events_of_contacts(again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare the events of two runs of a rotor system, those of each contact apart.

    Events of several contacts at one instant have no order.
    """
    counts: dict[str, object] = dict(compare_events(again, archived)[0])
    troubles, largest = [], 0.0
    for number in range(archived.sizes["contact"]):
        own = [run.isel(event=run["event_contact"].values == number) for run in (again, archived)]
        found, trouble = compare_events(*own)
        largest = max(largest, float(str(found["largest_difference"])))
        troubles += [f"contact {number}: {trouble}"] if trouble else []
    return counts | {"largest_difference": largest}, "; ".join(troubles)


def _decided(drops: xr.Dataset) -> xr.Variable:
    """Return which drops do not depend on rounding up to their end."""
    return drops.variables["horizon"] >= float(drops.attrs["duration"])


def _drops_counted(_again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    counts = {"drops": archived.sizes["drop"], "decided_drops": int(_decided(archived).sum())}
    return dict[str, object](counts), ""


def _undecided(_again: xr.Dataset, archived: xr.Dataset) -> dict[str, str]:
    """Return why statistics are not compared where drops end behind their horizon."""
    if _decided(archived).all():
        return {}
    own = [str(name) for name, each in archived.data_vars.items() if "drop" not in each.dims]
    return dict.fromkeys(own, BEHIND_HORIZON)


def _whirls(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    system, _ = _archived(dataset)
    return synchronous_response_system(system, speed=dataset["speed"].values)


def _special(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    system, _ = _archived(dataset)
    low, high = np.asarray(dataset.attrs["limits"]).tolist()
    return special_speeds(system, limits=(low, high), points=dataset.attrs["points"])


def _campbell(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    system, _ = _archived(dataset)
    speed, springs = (dataset[name].values for name in ("speed", "contact_stiffness"))
    modes = dataset.attrs.get("modes")
    return campbell(system, speed=speed, contact_stiffness=springs, modes=modes)


def _report(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    system, _ = _archived(dataset)
    given = dataset.attrs
    return clearance_report(
        system, speed=np.unique(given["running_speeds"]).tolist(),
        probes=list(map(str, dataset["probe"].values)), multiple=given["multiple"],
        mass=given.get("rotor_mass"), vibration_limit=float(dataset["vibration_limit"]),
        points=given["points"],
    )  # fmt: skip


def _cycle(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    system, _ = _archived(dataset)
    if dataset["period"].isnull():
        raise InputError("this result cannot be verified: there is no limit cycle in it")
    return limit_cycle_system(system, start=dataset)


def _branch(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    problem, _ = CycleProblem.of(_archived(dataset)[0])
    given = dataset.attrs
    guess = guess_in(problem, given, np.atleast_1d(given["start"]))
    low, high = np.asarray(given["limits"]).tolist()
    direction, points = str(given["direction"]), int(given["points"])
    return branch_from(problem, guess, (low, high), direction, points, progress=progress)


def _numbers(names: Mapping[str, str], again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare variables: their shapes, and their numbers."""
    trouble, compared, differing, largest = "", 0, 0, 0.0
    for name, words in names.items():
        here, there = again[name].transpose(*archived[name].dims).values, archived[name].values
        compared += there.size
        if here.shape != there.shape:
            differing += there.size
            trouble = trouble or f"{here.size} {words} computed again, {there.size} archived"
            continue
        apart = _apart(here, there)
        largest = max(largest, float(apart.max(initial=0.0)))
        differing += int((apart > CLOSE).sum())
        if not trouble and (apart > CLOSE).any():
            trouble = f"{words} differ by up to {apart.max():.3g} of the largest"
    return counts_of(compared, differing, largest), trouble


def _apart(here: Values, there: Values) -> Values:
    """Return the differences of numbers, over the largest; those missing in both are equal."""
    same = (here == there) | (np.isnan(here) & np.isnan(there))
    size = np.abs(there).max(initial=0.0, where=np.isfinite(there))
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.abs(here - there) / size
    return np.where(same, 0.0, np.where(np.isfinite(part), part, np.inf))


def _of(
    again: Callable[[xr.Dataset, int | None, Progress | None], xr.Dataset],
    names: Mapping[str, str],
    attributes: tuple[str, ...] = (),
    *others: str,
    left_out: Callable[[xr.Dataset, xr.Dataset], Mapping[str, str]] = lambda _, __: {},
) -> Verification:
    needed = (*names, *others, *PROBLEM)
    return Verification(
        needed, attributes, again, partial(_numbers, names), (*OF_SYSTEM, *others), left_out
    )


SYSTEM_RUN = Verification(
    ("event_time", "event_time_error", "event_contact", "t", *NEEDED),
    ("duration", "rtol", "method"),
    _run,
    _events_of_contacts,
    (*OF_SYSTEM, "t"),
    tolerance=tolerance_of_run,
)
DROP = replace(SYSTEM_RUN, again=_drop, given=(*SYSTEM_RUN.given, *OF_DROP))
DROPS = Verification(
    ("horizon", "status", "largest_force", "contact_count"),
    (),
    _drops,
    _drops_counted,
    (
        "drop",
        "quantile",
        "contact_node",
        "clearance",
        "node",
        "node_clearance",
        "load_capacity",
        DESIGN,
    ),
    _undecided,
    told=_decided,
)
SYSTEM_SWEEP = Verification(
    ("response", "direction", "touched", "period", *NUMBERS, *NEEDED),
    ("rtol",),
    _sweep,
    partial(compare_points, "response"),
    (*OF_SYSTEM, "speed", "start", "direction"),
    lambda _, __: {"final_state": TRANSIENT},
)
WHIRLS = _of(
    _whirls,
    {"amplitude": "amplitudes", "normal_force": "forces", "growth_rate": "growth rates",
     "node_amplitude": "amplitudes of nodes"},
    (), "speed",
)  # fmt: skip
SPECIAL_SPEEDS = _of(
    _special,
    {"special_speed": "special speeds", "special_kind": "kinds of special speeds",
     "amplitude": "amplitudes", "branch_amplitude": "amplitudes of branches"},
    ("limits", "points"),
)  # fmt: skip
SYSTEM_CYCLE = _of(
    _cycle,
    {"period": "periods", "multiplier_real": "multipliers", "radius_max": "radii",
     "largest_force": "forces", "stability": "stabilities"},
    (), "speed", "final_state",
)  # fmt: skip
SYSTEM_BRANCH = _of(
    _branch,
    {"special_kind": "kinds of special points", "special_speed": "special speeds",
     "special_period": "special periods"},
    ("start", "start_speed", "start_period", "start_special", "start_slope", "limits",
     "direction", "points"),
    left_out=partial(of_steps, "speed"),
)  # fmt: skip
CAMPBELL = _of(
    _campbell, {"whirl_speed": "whirl speeds", "damping_ratio": "damping ratios"},
    (), "speed", "contact_stiffness",
)  # fmt: skip
CLEARANCE_REPORT = _of(
    _report,
    {"major_axis": "axes", "scale_factor": "scale factors", "running_share": "shares",
     "passage_share": "shares", "critical_speed": "critical speeds",
     "clearance_verdict": "verdicts", "rub_force": "forces", "whip_force": "forces"},
    ("multiple", "points", "running_speeds"), "vibration_limit",
)  # fmt: skip
