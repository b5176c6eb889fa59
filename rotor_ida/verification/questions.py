"""For each kind of result, the question that it answers, and what of it another processor repeats.

A result keeps its question (`rotor_ida.results.question`). Where it does not, as those of older
versions, or is a part of one, the arguments are read from its attributes and variables here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch_course import course_of, parameters_of, stable_ranges
from rotor_ida.cycles.guess import Guess, as_start, as_start_of_system
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.results.archived_system import NEEDED, PROBLEM, problem_of
from rotor_ida.results.kinds import kind_of
from rotor_ida.results.question import Question
from rotor_ida.schema import RESPONSE
from rotor_ida.schema.quantities import TOLERANCE, TOLERANCE_OF_KIND
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.steady.ramps import DIRECTIONS
from rotor_ida.verification.variables import OF_ONE_STRETCH, PERIODIC

Reasons = Mapping[str, str]
SOLVER = ("rtol", "atol", "method")
HOW = (*SOLVER, "flight")
# Attributes of the speed of a run-up.
CHANGES = ("to", "rate", "speeds", "torque", "inertia")
# How much more numbers of a contact may differ than its times do over its duration.
LATE = 100.0
# Ends of a branch that do not depend on its steps.
SHARP = ("limits", "closed", "halved", "hopf", "start")
TRANSIENT = "depends on the way to the steady state"
STEPS = "the steps along it depend on rounding; its special points and ends are compared"
MARGINAL = "at a bifurcation a multiplier lies on the unit circle, on which side is rounding"
BEHIND_HORIZON = "some drops end behind their horizon, where another processor drops otherwise"
STARTS = tuple(f"start_{name}" for name in COMPONENTS)
STATES = tuple(f"rotating_{name}" for name in COMPONENTS)


def tolerance_of(dataset: xr.Dataset) -> float:
    """Return the difference allowed for the numbers of a kind of result."""
    return TOLERANCE_OF_KIND.get(kind_of(dataset), TOLERANCE)


@dataclass(frozen=True, slots=True)
class Verification:
    """How results of one kind are computed again and compared."""

    question: Callable[[xr.Dataset], Question]
    variables: tuple[str, ...]  # numbers that are needed
    attributes: tuple[str, ...] = ()
    # Why variables are not compared, by name or dimension.
    left_out: Callable[[xr.Dataset, xr.Dataset], Reasons] = lambda _, __: {}
    tolerance: Callable[[xr.Dataset], float] = tolerance_of
    # Where numbers belong to the motion, on any processor.
    told: Callable[[xr.Dataset], xr.Variable | None] = lambda _: None
    # What is compared besides, as variables.
    also: Callable[[xr.Dataset], Mapping[str, Any]] = lambda _: {}


def rotor_in(dataset: xr.Dataset, prefix: str = "") -> Rotor:
    """Return the rotor in the attributes; missing parameters have their defaults."""
    attributes = {name: f"{prefix}{name}" for name in ALL_PARAMETERS}
    given = dataset.attrs
    return Rotor(**{name: given[each] for name, each in attributes.items() if each in given})


def axes_in(dataset: xr.Dataset, *others: str) -> dict[str, Any]:
    """Return the parameters of many rotors, and other axes: each a number or a vector, as given."""
    names = (*ALL_PARAMETERS, *others)
    return {name: dataset[name].values[()] for name in names if name in dataset.variables}


def _told_in(dataset: xr.Dataset, *names: str) -> dict[str, Any]:
    """Return arguments that are attributes."""
    return {name: dataset.attrs[name] for name in names if name in dataset.attrs}


def _starts_in(dataset: xr.Dataset) -> dict[str, Any]:
    columns = [dataset[name].values.tolist() for name in STARTS]
    starts: list[Any] = list(zip(*columns, strict=True))
    if "start_words" in dataset.attrs:
        words = str(dataset.attrs["start_words"]).split()
        pairs = zip(words, starts, strict=True)
        starts = [state if word == "state" else word for word, state in pairs]
    return {"starts": starts}


def _direction_in(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the direction of a sweep, in the word by which it was asked for."""
    turns = tuple(dataset["direction"].values.tolist())
    word = next((word for word, each in DIRECTIONS.items() if each == turns), "unknown")
    return {"direction": word, **_told_in(dataset, "along")}


def _change_in(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the change of speed of a run-up, as arguments of it."""
    changes = _told_in(dataset, *CHANGES)
    if "speeds" in changes:
        changes["speeds"] = np.reshape(changes["speeds"], (-1, 2))
    return changes


def _run(dataset: xr.Dataset) -> Question:
    given = _told_in(dataset, "start", "duration", *SOLVER) | {"samples": dataset["t"].values}
    given["rotor"] = rotor_in(dataset)
    if "event_speed" in dataset:
        return Question("run_up", given | _change_in(dataset))
    return Question("simulate", given | _told_in(dataset, "flight"))


def _sweep(dataset: xr.Dataset) -> Question:
    given = axes_in(dataset) | _starts_in(dataset) | _direction_in(dataset)
    given["events"] = "event" in dataset.dims
    return Question("sweep", given | _told_in(dataset, *HOW))


def _diagram(dataset: xr.Dataset) -> Question:
    given = axes_in(dataset) | _starts_in(dataset)
    given |= _told_in(dataset, *SOLVER, "extrema_time", "rate")
    return Question(
        "bifurcation_diagram",
        given | (_direction_in(dataset) if "direction" in dataset.dims else {}),
    )


def _run_ups(dataset: xr.Dataset) -> Question:
    given = axes_in(dataset, "to", "rate", "phase") | _starts_in(dataset)
    return Question("run_ups", given | _told_in(dataset, *SOLVER))


def _basin(dataset: xr.Dataset) -> Question:
    _refuse_system(dataset)
    starts = {name: dataset[name].values[()] for name in COMPONENTS}
    rtol = dataset.attrs["labelling_rtol"]
    return Question("basin", {"rotor": rotor_in(dataset), **starts, "rtol": rtol})


def _fractions(dataset: xr.Dataset) -> Question:
    _refuse_system(dataset)
    return Question("basin_fractions", {"rotor": rotor_in(dataset), **_drawn(dataset)})


def _atlas(dataset: xr.Dataset) -> Question:
    given = dataset.attrs
    if "seed" in given:
        return Question("continue_attractors", axes_in(dataset) | _drawn(dataset))
    starts = np.reshape(given["starts"], (-1, 4))
    more = {"starts": starts, "rtol": given["labelling_rtol"]}
    return Question("continue_attractors", axes_in(dataset) | more)


def _drawn(dataset: xr.Dataset) -> dict[str, Any]:
    """Return how random starts were drawn and simulated."""
    given = dataset.attrs
    ranges = {name: tuple(np.atleast_1d(given[f"range_{name}"]).tolist()) for name in COMPONENTS}
    how = {"starts": given["starts"], "seed": given["seed"], "rtol": given["labelling_rtol"]}
    return ranges | how


def _over(verb: str, dataset: xr.Dataset) -> Question:
    """Return the question of exact results of many rotors."""
    return Question(verb, axes_in(dataset))


def _cycle(dataset: xr.Dataset) -> Question:
    given = {"start": dataset.attrs["start"], "period": dataset.attrs.get("start_period")}
    return Question("limit_cycle", {"rotor": rotor_in(dataset), **given})


def _followed(dataset: xr.Dataset, parameters: tuple[str, ...], special: str) -> dict[str, Any]:
    """Return the rotor and the start of a branch or curve."""
    given, rotor = dataset.attrs, rotor_in(dataset, "start_")
    guess = Guess(
        DiscFlow(rotor), np.array(given["start"]), float(given["start_period"]), special,
        float(given.get("start_slope", 1.0)),
    )  # fmt: skip
    return {"rotor": rotor, "start": as_start(guess, parameters), "points": int(given["points"])}


def _branch(dataset: xr.Dataset) -> Question:
    given, (parameter,) = dataset.attrs, parameters_of("branch", dataset, "parameter", 1)
    more = {
        "parameter": parameter,
        "limits": tuple(np.asarray(given["limits"]).tolist()),
        "direction": str(given["direction"]),
    }
    special = str(given["start_special"])
    return Question("continue_cycle", _followed(dataset, (parameter,), special) | more)


def _curve(dataset: xr.Dataset) -> Question:
    given, names = dataset.attrs, tuple(parameters_of("curve", dataset, "parameters", 2))
    limits = np.reshape(given["limits"], (2, 2))
    more = {"kind": given["kind"], "parameters": names, "limits": limits}
    return Question("bifurcation_curve", _followed(dataset, names, given["kind"]) | more)


def _system_in(dataset: xr.Dataset, *names: str) -> dict[str, Any]:
    """Return the system of a result, and arguments that are attributes."""
    return {"rotor": problem_of(dataset)[0], **_told_in(dataset, *names)}


def _system_run(dataset: xr.Dataset) -> Question:
    given = _system_in(dataset, "duration", "rtol", "method") | {"samples": dataset["t"].values}
    (given["start"],) = problem_of(dataset)[1]
    if "event_speed" not in dataset:
        return Question("simulate", given | {"speed": dataset.attrs.get("speed")})
    changes = _change_in(dataset)
    if "speeds" not in changes:
        changes["speed"] = dataset.attrs.get("start_speed")
    return Question("run_up", given | changes)


def _refuse_system(dataset: xr.Dataset) -> None:
    """Refuse a result of a rotor system, which does not hold its matrices besides its question."""
    if "contact_node" in dataset.variables:
        _lost(dataset)


def _ends_of_attractors(_again: xr.Dataset, _archived: xr.Dataset) -> Reasons:
    """Return why the state at which a start of a rotor system ended is not compared."""
    return {"final_state": TRANSIENT}


def _lost(_dataset: xr.Dataset) -> Question:
    raise ValueError("it lacks its question, as those of older versions do")


def _system_sweep(dataset: xr.Dataset) -> Question:
    given = _system_in(dataset, "rtol") | {"speed": dataset["speed"].values}
    given["starts"] = problem_of(dataset)[1]
    axes = {name: dataset[name].values[()] for name in PARAMETERS_OF_SYSTEM
            if name in dataset.variables and dataset[name].dims in {(), (name,)}}  # fmt: skip
    return Question("sweep", given | axes | _direction_in(dataset))


def _system_whirls(dataset: xr.Dataset) -> Question:
    given = _system_in(dataset) | {"speed": dataset["speed"].values}
    return Question("synchronous_response", given)


def _special_speeds(dataset: xr.Dataset) -> Question:
    given = _system_in(dataset, "points")
    given["limits"] = tuple(np.asarray(dataset.attrs["limits"]).tolist())
    return Question("special_speeds", given)


def _campbell(dataset: xr.Dataset) -> Question:
    given = _system_in(dataset, "modes")
    given |= {name: dataset[name].values for name in ("speed", "contact_stiffness")}
    return Question("campbell", given)


def _clearance_report(dataset: xr.Dataset) -> Question:
    given = _system_in(dataset, "multiple", "points")
    given |= {
        "speed": np.unique(dataset.attrs["running_speeds"]).tolist(),
        "probes": list(map(str, dataset["probe"].values)),
        "vibration_limit": float(dataset["vibration_limit"]),
    }
    if "rotor_mass" in dataset.attrs:
        given["mass"] = dataset.attrs["rotor_mass"]
    return Question("clearance_report", given)


def _system_cycle(dataset: xr.Dataset) -> Question:
    if dataset["period"].isnull():
        raise ValueError("there is no limit cycle in it")
    given, start = _system_in(dataset), dataset[["speed", "period", "final_state"]]
    return Question("limit_cycle", given | {"start": start.drop_attrs()})


def _system_branch(dataset: xr.Dataset) -> Question:
    told = _told_in(dataset, "direction", "points")
    told["limits"] = tuple(np.asarray(dataset.attrs["limits"]).tolist())
    return Question(
        "continue_cycle", _system_in(dataset) | told | {"start": as_start_of_system(dataset.attrs)}
    )


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
            names = [name for name in ALL_PARAMETERS if name in dataset.variables]
            for name in (*names, "period", "radius_min", "radius_max"):
                found[f"{name} at the {end}"] = float(dataset.isel(point=place)[name])
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
_BEGUN = ("start", "start_period", *(f"start_{name}" for name in PARAMETERS))
_SYSTEM_RUN = Verification(
    _system_run, ("event_time", "event_time_error", "event_contact", "t", *NEEDED),
    ("duration", "rtol", "method"), tolerance=tolerance_of_run,
)  # fmt: skip
VERIFIED = {
    "run": Verification(
        _run, ("event_time", "event_time_error", "t"),
        (*PARAMETERS, "start", "duration", *HOW), tolerance=tolerance_of_run,
    ),
    "sweep": Verification(
        _sweep, ("event_count", "response", "direction", *STARTS, *PARAMETERS, *NUMBERS), HOW,
        _transients,
    ),
    "run_ups": Verification(
        _run_ups, ("ending", "response", "rate", "phase", "to", *STARTS, *PARAMETERS, *NUMBERS),
        SOLVER,
    ),
    "bifurcation_diagram": Verification(
        _diagram, ("extremum_radius", "extremum_count", "response", *STARTS, *PARAMETERS),
        (*SOLVER, "extrema_time"), _stretches,
    ),
    "stroboscopic_diagram": Verification(
        _lost, ("response", *STATES, *STARTS, *PARAMETERS), (*SOLVER, "revolutions", "phase"),
    ),
    "section": Verification(
        _lost, ("crossing_time", *STATES, *PARAMETERS), (*SOLVER, "revolutions", "skip"),
    ),
    "basin": Verification(
        _basin, ("label", "settling_time", "kind", *COMPONENTS, *NUMBERS),
        (*PARAMETERS, "labelling_rtol"), _ends_of_attractors,
    ),
    "basin_fractions": Verification(
        _fractions, ("response_fraction", "count", "kind", *NUMBERS),
        (*PARAMETERS, "labelling_rtol", "starts", "seed", *_RANGES), _ends_of_attractors,
    ),
    "atlas": Verification(
        _atlas, ("missed_fraction", "count", "kind", *PARAMETERS, *NUMBERS),
        ("labelling_rtol", "starts"), lambda _, __: {"target": "shocks are not computed again"},
    ),
    "system_atlas": Verification(
        _lost, ("missed_fraction", "count", "kind", "speed", *NUMBERS),
        ("labelling_rtol", "starts"), lambda _, __: {"final_state": TRANSIENT},
    ),
    **dict.fromkeys(("touchdown", "system_touchdown"), Verification(
        _lost, ("missed_fraction", "fraction", "kind", *NUMBERS[2:]), ("labelling_rtol", "starts"),
        lambda _, __: {"final_state": TRANSIENT},
    )),
    "whirls": Verification(
        partial(_over, "synchronous_response"), ("amplitude", *PARAMETERS)
    ),
    "folds": Verification(partial(_over, "folds"), ("fold_omega", "zeta", "delta0")),
    "hopf_points": Verification(partial(_over, "hopf_points"), ("hopf_omega", "zeta", "delta0")),
    "cycle": Verification(
        _cycle, ("period_error", "multiplier_real", "multiplier_imag"), (*PARAMETERS, "start")
    ),
    "cycles": Verification(
        _lost, ("response", "stability", "period", "multiplier_real", "radius_max"), ("rtol",),
        lambda _, __: dict.fromkeys((*COMPONENTS, "final_state"), TRANSIENT),
    ),
    "branch": Verification(
        _branch, ("special_value", "special_period", "slope", "stability"),
        ("parameter", "limits", "direction", "points", "start_special", *_BEGUN), _steps,
        also=_ends,
    ),
    "curve": Verification(
        _curve, ("special_second_value", "special_value", "special_period"),
        ("kind", "parameters", "limits", "points", *_BEGUN), _steps_of_curve, also=_ends,
    ),
    "system_run": _SYSTEM_RUN,
    "drop": _SYSTEM_RUN,
    "drop_ensemble": Verification(
        _lost,
        ("horizon", "status", "largest_force", "contact_count"), ("duration",), _undecided,
        told=_decided,
    ),
    "system_sweep": Verification(
        _system_sweep, ("response", "direction", "touched", "period", *NUMBERS),
        ("rtol",), lambda _, __: {"final_state": TRANSIENT},
    ),
    "system_diagram": Verification(
        _lost, ("extremum_radius", "extremum_count", "response", "touched"),
        ("rtol", "revolutions"), _stretches,
    ),
    "system_stroboscopic_diagram": Verification(
        _lost, ("response", "touched", *STATES), ("rtol", "revolutions", "phase"),
    ),
    "system_section": Verification(
        _lost, ("crossing_time", "crossing_state", "final_state", *STATES, *PROBLEM),
        ("rtol", "speed", "revolutions", "skip"),
    ),
    "system_run_ups": Verification(
        _lost, ("ending", "response", "rate", "phase", "to", *NUMBERS),
        ("rtol",),
    ),
    "system_whirls": Verification(
        _system_whirls, ("amplitude", "normal_force", "growth_rate", "speed", *PROBLEM)
    ),
    "system_special_points": Verification(
        _special_speeds, ("special_speed", "special_kind", "amplitude", *PROBLEM),
        ("limits", "points"),
    ),
    "system_cycle": Verification(
        _system_cycle, ("period", "multiplier_real", "speed", "final_state", *PROBLEM)
    ),
    "system_branch": Verification(
        _system_branch, ("special_kind", "special_speed", "special_period", *PROBLEM),
        ("start", "start_speed", "start_period", "start_special", "start_slope", "limits",
         "direction", "points"),
        _steps,
    ),
    "campbell": Verification(
        _campbell, ("whirl_speed", "damping_ratio", "speed", "contact_stiffness", *PROBLEM)
    ),
    "clearance_report": Verification(
        _clearance_report, ("scale_factor", "running_share", "vibration_limit", *PROBLEM),
        ("multiple", "points", "running_speeds"),
    ),
}  # fmt: skip
