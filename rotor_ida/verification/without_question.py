"""Read the question of a result that does not keep it from its attributes and variables.

A result keeps its question (`rotor_ida.results.question`), but for those of older versions and for
a part of one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch_course import parameters_of
from rotor_ida.cycles.guess import CLOSING_RTOL, Guess, as_start, flow_at
from rotor_ida.model.assembly import assemble
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.results.archived_system import problem_of
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.question import Question
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.systems.flow import SettlingProblem
from rotor_ida.steady.grid import DIRECTIONS

SOLVER = ("rtol", "atol", "method")
# Attributes of the speed of a run-up.
CHANGES = ("to", "rate", "speeds", "torque", "inertia")
STARTS = tuple(f"start_{name}" for name in COMPONENTS)


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
    return Question("sweep", given | _told_in(dataset, *SOLVER, "flight"))


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


def _over_grid(verb: str, dataset: xr.Dataset) -> Question:
    """Return the question of exact results of many rotors."""
    return Question(verb, axes_in(dataset))


def _cycle(dataset: xr.Dataset) -> Question:
    given = {"start": dataset.attrs["start"], "period": dataset.attrs.get("start_period")}
    return Question("limit_cycle", {"rotor": rotor_in(dataset), **given})


def _followed(dataset: xr.Dataset, parameters: tuple[str, ...]) -> dict[str, Any]:
    """Return the rotor, the start and the limits of a branch or curve."""
    given, is_system = dataset.attrs, "contact_node" in dataset.variables
    special, state = str(given.get("start_special", given.get("kind"))), np.array(given["start"])
    told = (special, float(given.get("start_slope", 1.0)))
    rotor: Rotor | RotorSystem
    if is_system and "clearance" in parameters:
        _lost(dataset)
    if is_system:
        rotor = problem_of(dataset)[0]
        flow = flow_at(SettlingProblem.of(assemble(rotor), CLOSING_RTOL), given["start_speed"])
        guess = Guess(flow, flow.given_state(state), float(given["start_period"]), *told)
    else:
        rotor = rotor_in(dataset, "start_")
        guess = Guess(DiscFlow(rotor), state, float(given["start_period"]), *told)
    limits = np.reshape(given["limits"], (-1, 2)).tolist()
    return {
        "rotor": rotor, "start": as_start(guess, parameters), "points": int(given["points"]),
        "limits": tuple(map(tuple, limits)) if len(limits) > 1 else tuple(limits[0]),
    }  # fmt: skip


def _branch(dataset: xr.Dataset) -> Question:
    (parameter,) = parameters_of("branch", dataset, "parameter", 1)
    more = {"parameter": parameter, "direction": str(dataset.attrs["direction"])}
    return Question("continue_cycle", _followed(dataset, (parameter,)) | more)


def _curve(dataset: xr.Dataset) -> Question:
    names = tuple(parameters_of("curve", dataset, "parameters", 2))
    more = {"kind": dataset.attrs["kind"], "parameters": names}
    return Question("bifurcation_curve", _followed(dataset, names) | more)


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


OF_KIND: dict[str, Callable[[xr.Dataset], Question]] = {
    "run": _run, "sweep": _sweep, "run_ups": _run_ups, "bifurcation_diagram": _diagram,
    "basin": _basin, "basin_fractions": _fractions, "atlas": _atlas,
    "whirls": partial(_over_grid, "synchronous_response"), "folds": partial(_over_grid, "folds"),
    "hopf_points": partial(_over_grid, "hopf_points"), "cycle": _cycle, "branch": _branch,
    "curve": _curve, "system_run": _system_run, "drop": _system_run, "system_sweep": _system_sweep,
    "system_whirls": _system_whirls, "system_special_points": _special_speeds,
    "system_cycle": _system_cycle, "system_branch": _branch, "system_curve": _curve,
    "campbell": _campbell,
    "clearance_report": _clearance_report,
}  # fmt: skip


def read_question(dataset: xr.Dataset) -> Question:
    """Return the question of a result from its attributes and variables.

    KeyError, IndexError, TypeError or ValueError if it cannot be read.
    """
    return OF_KIND.get(kind_of(dataset), _lost)(dataset)
