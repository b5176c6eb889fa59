"""Compute an archived result again, from its attributes, and compare it with the archive.

The steps along a branch may differ on another machine, so its points are not compared. Results
that do not depend on the steps are: the special points, the ends and the stable ranges.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins import basin, basin_fractions
from rotor_ida.basins.atlas import continue_attractors
from rotor_ida.checks import COMPONENTS, shown
from rotor_ida.cycles.bifurcation_curve import bifurcation_curve
from rotor_ida.cycles.branch_course import course_of, parameters_of, stable_ranges
from rotor_ida.cycles.continue_cycle import branch_from
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.limit_cycle import limit_cycle
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress
from rotor_ida.results.kinds import KINDS, kind_of, loaded
from rotor_ida.results.si_units import dimensionless
from rotor_ida.schema import RESPONSE, SPECIAL, words_of
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.run_up import run_up
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.response import BOUNCING, CONTACT_FREE, FULL_CONTACT, SYNCHRONOUS
from rotor_ida.steady.run_ups import run_ups
from rotor_ida.steady.sweep import DIRECTIONS, sweep
from rotor_ida.steady.system_sweep import sweep_system
from rotor_ida.systems.archived import NEEDED, problem_of
from rotor_ida.systems.simulate import run_up_system, simulate_system
from rotor_ida.testing import assert_events_close

HOW = ("rtol", "atol", "method", "flight")
# Attributes of the speed of a run-up.
CHANGES = ("to", "rate", "speeds", "torque", "inertia")
# Responses whose numbers belong to the motion, not to one stretch of it.
OF_MOTION = {
    **dict.fromkeys(("amplitude", "phase_lag"), (CONTACT_FREE, SYNCHRONOUS)),
    **dict.fromkeys(
        ("radius_min", "radius_max", "period"),
        (CONTACT_FREE, SYNCHRONOUS, BOUNCING, FULL_CONTACT),
    ),
}
# Ends of a branch that do not depend on its steps.
SHARP = ("limits", "closed", "halved", "hopf", "start")
# Relative differences allowed between machines, for responses and for cycles. Lengths, forces and
# multipliers of cycles are of order 1.
CLOSE, CLOSE_OF_CYCLES = 1e-6, 1e-8
OF_SIZE_ONE = ("radius", "largest_force", "multiplier")

# Numbers compared and differences; and the first difference in words.
Verdict = tuple[dict[str, object], str]
# Facts of cycles that are compared, by name.
Facts = dict[str, object]


@dataclass(frozen=True, slots=True)
class Verification:
    """How results of one kind are computed again and compared."""

    variables: tuple[str, ...]  # numbers that are needed
    attributes: tuple[str, ...]
    again: Callable[[xr.Dataset, int | None, Progress | None], xr.Dataset]
    compared: Callable[[xr.Dataset, xr.Dataset], Verdict]


def rerun(
    dataset: xr.Dataset,
    *,
    method: Method | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute a result again from its attributes, or by another method.

    Parameters
    ----------
    dataset : Dataset
        A result of `simulate` or `run_up`, also of a rotor system, of `sweep`, `run_ups`, `basin`,
        `basin_fractions`, `continue_attractors`, `limit_cycle`, `continue_cycle` or
        `bifurcation_curve`, or of a rotor system from `synchronous_response`, `special_speeds`,
        `campbell` or `clearance_report`; for example one loaded from an archive.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Another solver for the contacts of a run, sweep or run-up: an independent check that shares
        no step with the first.
    workers, progress
        As for the function that computed it; not used for a single run or cycle.

    Returns
    -------
    Dataset
        The same result, computed again and dimensionless; an atlas without its shocks.

    Raises
    ------
    InputError
        If the dataset is not such a result, or its attributes are invalid.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> from rotor_ida.testing import assert_events_close
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    >>> assert_events_close(rerun(run, method="taylor"), run)
    """
    verification = _verification_of(dataset)
    if method is not None:
        if "method" not in verification.attributes:
            kind = kind_of(dataset)
            raise InputError(f"method must be left out for the kind {kind}, got {method!r}")
        exact = {"flight": "exact"} if method == "taylor" else {}
        dataset = dataset.assign_attrs({"method": method, **exact})
    return verification.again(dimensionless(dataset), workers, progress)


def differences(again: xr.Dataset, archived: xr.Dataset) -> dict[str, object]:
    """Compare a result computed again with that of the archive.

    Parameters
    ----------
    again, archived : Dataset
        Two results of the same kind; those in SI units are compared as dimensionless.

    Returns
    -------
    dict
        ``agrees``, and ``trouble``, the first difference in words. For runs: the numbers of events,
        the largest difference between event times and the largest error stated for one [1]. For
        other results: the number of points, starts or values of limit cycles compared, the number
        of those that differ, and the largest difference between amplitudes, radii, periods or
        other numbers, relative to the larger one. ``core``: whether the compiled core is the same;
        another one gives different last bits.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    >>> differences(rerun(run), run)["agrees"]
    True
    """
    verification = _verification_of(archived)
    counts, trouble = verification.compared(dimensionless(again), dimensionless(archived))
    # the last bits depend on the core
    same = again.attrs.get("core_sources") == archived.attrs.get("core_sources")
    core = "the same" if same else "different from that of the archive"
    return {"agrees": not trouble, **counts, "trouble": trouble, "core": core}


def _verification_of(dataset: xr.Dataset) -> Verification:
    """Return how a result is verified; refuse one that cannot be, or that lacks variables."""
    kind = kind_of(dataset)
    place = KINDS[kind].verified
    verification: Verification | None = loaded(place) if place else None
    if verification is None or not set(verification.variables) <= set(dataset.variables):
        raise InputError(
            "only results of simulate, run_up, sweep, run_ups, basin, basin_fractions, "
            "continue_attractors, limit_cycle, continue_cycle, bifurcation_curve and those of "
            "rotor systems over speed can be verified, "
            f"got a dataset of {shown(list(map(str, dataset.data_vars)))}"
        )
    missing = [name for name in verification.attributes if name not in dataset.attrs]
    if missing:
        raise InputError(f"this {kind} cannot be verified: it lacks {', '.join(missing)}")
    words = [name for name in verification.variables if dataset[name].dtype.kind not in "iuf"]
    if words:
        raise InputError(f"{words[0]} must be numbers, got {dataset[words[0]].dtype}")
    return verification


def _run(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    how = {name: given[name] for name in ("start", "duration", *HOW)}
    if "event_speed" in dataset:
        del how["flight"]
        changes = {name: given[name] for name in CHANGES if name in given}
        if "speeds" in changes:
            changes["speeds"] = np.reshape(changes["speeds"], (-1, 2))
        return run_up(_rotor(dataset), samples=dataset["t"].values, **how, **changes)
    return simulate(_rotor(dataset), samples=dataset["t"].values, **how)


def _system_run(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    try:
        system, around = problem_of(dataset)
    except (IndexError, ValueError) as error:
        raise InputError(f"this run of a system cannot be verified: {error}") from error
    given = dataset.attrs
    how: dict[str, Any] = {name: given[name] for name in ("duration", "rtol", "method")}
    how |= around | {"samples": dataset["t"].values, "progress": progress}
    if "event_speed" not in dataset:
        return simulate_system(system, **how, speed=given.get("speed"))  # type: ignore[arg-type]
    changes = {name: given[name] for name in CHANGES if name in given}
    if "speeds" in changes:
        changes["speeds"] = np.reshape(changes["speeds"], (-1, 2))
    else:
        changes["speed"] = given.get("start_speed")
    return run_up_system(system, **how, **changes)


def _system_sweep(
    dataset: xr.Dataset, workers: int | None, progress: Progress | None
) -> xr.Dataset:
    try:
        system, around = problem_of(dataset)
    except (IndexError, ValueError) as error:
        raise InputError(f"this sweep of a system cannot be verified: {error}") from error
    return sweep_system(
        system, **around, speed=dataset["speed"].values, direction=_direction(dataset),
        rtol=dataset.attrs["rtol"], workers=workers, progress=progress,
    )  # fmt: skip


def _direction(dataset: xr.Dataset) -> Any:
    """Return the direction of a sweep, in the word by which it was asked for."""
    turns = tuple(dataset["direction"].values.tolist())
    return next((word for word, each in DIRECTIONS.items() if each == turns), "unknown")


def _sweep(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts = zip(*(dataset[f"start_{name}"].values.tolist() for name in COMPONENTS), strict=True)
    given: dict[str, Any] = _axes(dataset)
    given |= {name: dataset.attrs[name] for name in HOW}
    given |= {"starts": list(starts), "direction": _direction(dataset)}
    return sweep(**given, workers=workers, progress=progress)


def _run_ups(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts = zip(*(dataset[f"start_{name}"].values.tolist() for name in COMPONENTS), strict=True)
    given: dict[str, Any] = _axes(dataset)
    given |= {name: dataset[name].values[()] for name in ("to", "rate", "phase")}
    given |= {name: dataset.attrs[name] for name in ("rtol", "atol", "method")}
    return run_ups(**given, starts=list(starts), workers=workers, progress=progress)


def _basin(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts: dict[str, Any] = {name: dataset[name].values[()] for name in COMPONENTS}
    starts["rtol"] = dataset.attrs["labelling_rtol"]
    return basin(_rotor(dataset), **starts, workers=workers, progress=progress)


def _fractions(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    return basin_fractions(_rotor(dataset), **_drawn(dataset), workers=workers, progress=progress)


def _atlas(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    asked: dict[str, Any] = _axes(dataset)
    if "seed" in given:
        asked |= _drawn(dataset)
    else:
        asked |= {"starts": np.reshape(given["starts"], (-1, 4)), "rtol": given["labelling_rtol"]}
    return continue_attractors(**asked, workers=workers, progress=progress)


def _cycle(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    return limit_cycle(_rotor(dataset), start=given["start"], period=given.get("start_period"))


def _branch(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    given, (parameter,) = dataset.attrs, parameters_of("branch", dataset, "parameter", 1)
    guess = Guess(
        _rotor(dataset, "start_"), np.array(given["start"]), float(given["start_period"]),
        str(given["start_special"]), float(given["start_slope"]),
    )  # fmt: skip
    low, high = np.asarray(given["limits"]).tolist()
    direction, points = str(given["direction"]), int(given["points"])
    return branch_from(guess, parameter, (low, high), direction, points, progress=progress)


def _curve(dataset: xr.Dataset, _workers: int | None, progress: Progress | None) -> xr.Dataset:
    given, (first, second) = dataset.attrs, parameters_of("curve", dataset, "parameters", 2)
    rotor, kind = _rotor(dataset, "start_"), given["kind"]
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


def _axes(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the parameters of many rotors, each a number or an axis, as given."""
    return {name: dataset[name].values[()] for name in ALL_PARAMETERS if name in dataset.variables}


def _drawn(dataset: xr.Dataset) -> dict[str, Any]:
    """Return how random starts were drawn and simulated."""
    given = dataset.attrs
    ranges = {name: tuple(np.atleast_1d(given[f"range_{name}"]).tolist()) for name in COMPONENTS}
    how = {"starts": given["starts"], "seed": given["seed"], "rtol": given["labelling_rtol"]}
    return ranges | how


def _rotor(dataset: xr.Dataset, prefix: str = "") -> Rotor:
    """Return the rotor in the attributes; missing parameters have their defaults."""
    attributes = {name: f"{prefix}{name}" for name in ALL_PARAMETERS}
    given = dataset.attrs
    return Rotor(**{name: given[each] for name, each in attributes.items() if each in given})


def _events(again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare the events of two runs."""
    trouble = ""
    try:
        assert_events_close(again, archived)
    except AssertionError as difference:
        trouble = "; ".join(str(difference).splitlines()[1:])
    common = min(again.sizes["event"], archived.sizes["event"])
    apart = again["event_time"].values[:common] - archived["event_time"].values[:common]
    stated = archived["event_time_error"].values[:common]
    return {
        "events": int(again.sizes["event"]),
        "archived_events": int(archived.sizes["event"]),
        "largest_difference": float(np.abs(apart).max(initial=0.0)),
        "largest_stated_error": float(stated.max(initial=0.0)),
    }, trouble


def _events_of_contacts(again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare the events of two runs of a rotor system, those of each contact apart.

    Events of several contacts at one instant have no order.
    """
    counts: dict[str, object] = dict(_events(again, archived)[0])
    troubles, largest = [], 0.0
    for number in range(archived.sizes["contact"]):
        own = [run.isel(event=run["event_contact"].values == number) for run in (again, archived)]
        found, trouble = _events(*own)
        largest = max(largest, float(str(found["largest_difference"])))
        troubles += [f"contact {number}: {trouble}"] if trouble else []
    return counts | {"largest_difference": largest}, "; ".join(troubles)


def _points(name: str, again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare points, starts or attractors by one variable, and by their numbers."""
    trouble, differing, apart = "", 0, 0.0
    archived = archived.drop_dims("target", errors="ignore")  # shocks are not computed again
    if dict(again.sizes) != dict(archived.sizes):
        sizes = {dim: size for dim, size in again.sizes.items() if archived.sizes.get(dim) != size}
        trouble = f"computed again, it has {sizes}, archived {dict(archived.sizes)}"
    else:
        # earlier versions wrote labels the other way round
        archived = archived.transpose(*again[name].dims, ...)
        differs = again[name].values != archived[name].values
        differing = int(differs.sum())
        numbers = [each for each in OF_MOTION if each in archived]
        apart = max(_apart_in_motion(again, archived, each) for each in numbers)
        if differing:
            place = dict(zip(again[name].dims, np.argwhere(differs)[0].tolist(), strict=True))
            one, other = again[name].isel(place).item(), archived[name].isel(place).item()
            trouble = f"{differing} of {differs.size} differ in {name}; the first: "
            trouble += f"{place}, computed again {one}, archived {other}"
        elif not apart <= CLOSE:
            trouble = f"amplitudes, radii or periods differ by {apart:.3g} of their size"
    return _counts(archived[name].size, differing, apart), trouble


def _apart_in_motion(again: xr.Dataset, archived: xr.Dataset, name: str) -> float:
    """Return the largest difference of a number of the motions, relative to the larger value.

    Numbers of one stretch of a motion are skipped: another machine may give another stretch.
    """
    kinds = archived["kind" if "kind" in archived else "response"].values
    told = np.isin(kinds, [RESPONSE[kind] for kind in OF_MOTION[name]])
    apart = _apart(again[name].values, archived[name].values)
    # numbers of each contact of a system have one dimension more
    told = told.reshape(*told.shape, *(1,) * (apart.ndim - told.ndim))
    return float(np.where(told, apart, 0.0).max(initial=0.0))


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
            apart = float(_apart(here, value, 1.0 if name.startswith(OF_SIZE_ONE) else 0.0))
            largest, agrees = max(largest, apart), apart <= CLOSE_OF_CYCLES
        differing += not agrees
        if not agrees and not trouble:
            trouble = f"{name} differs: computed again {here}, archived {value}"
    return _counts(len(facts), differing, largest), trouble


def _counts(compared: int, differing: int, largest: float) -> dict[str, object]:
    return {"compared": compared, "differing": differing, "largest_difference": largest}


def _apart(one: Values | float, other: Values | float, least: float = 0.0) -> Values:
    """Return the differences of numbers, relative to the larger one or to `least`.

    Numbers missing in both count as equal.
    """
    one, other = np.asarray(one), np.asarray(other)
    same = (one == other) | (np.isnan(one) & np.isnan(other))
    with np.errstate(invalid="ignore"):
        part = np.abs(one - other) / np.maximum(np.maximum(np.abs(one), np.abs(other)), least)
    return np.where(same, 0.0, np.where(np.isfinite(part), part, np.inf))


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


_NUMBERS = ("amplitude", "phase_lag", "radius_min", "radius_max")
_STARTS = tuple(f"start_{name}" for name in COMPONENTS)
_RANGES = tuple(f"range_{name}" for name in COMPONENTS)
_BEGUN = ("start", "start_period", *(f"start_{name}" for name in PARAMETERS))
RUN = Verification(
    ("event_time", "event_time_error", "t"),
    (*PARAMETERS, "start", "duration", *HOW),
    _run,
    _events,
)
SYSTEM_RUN = Verification(
    ("event_time", "event_time_error", "event_contact", "t", *NEEDED),
    ("duration", "rtol", "method"),
    _system_run,
    _events_of_contacts,
)
SYSTEM_SWEEP = Verification(
    ("response", "direction", "touched", "period", *_NUMBERS, *NEEDED),
    ("rtol",),
    _system_sweep,
    partial(_points, "response"),
)
SWEEP = Verification(
    ("event_count", "response", "direction", *_STARTS, *PARAMETERS, *_NUMBERS),
    HOW,
    _sweep,
    partial(_points, "response"),
)
RUN_UPS = Verification(
    ("ending", "response", "rate", "phase", "to", *_STARTS, *PARAMETERS, *_NUMBERS),
    ("rtol", "atol", "method"),
    _run_ups,
    partial(_points, "response"),
)
BASIN = Verification(
    ("label", "settling_time", "kind", *COMPONENTS, *_NUMBERS),
    (*PARAMETERS, "labelling_rtol"),
    _basin,
    partial(_points, "label"),
)
FRACTIONS = Verification(
    ("response_fraction", "count", "kind", *_NUMBERS),
    (*PARAMETERS, "labelling_rtol", "starts", "seed", *_RANGES),
    _fractions,
    partial(_points, "count"),
)
ATLAS = Verification(
    ("missed_fraction", "count", "kind", *PARAMETERS, *_NUMBERS),
    ("labelling_rtol", "starts"),
    _atlas,
    partial(_points, "count"),
)
CYCLE = Verification(
    ("period_error", "multiplier_real", "multiplier_imag"),
    (*PARAMETERS, "start"),
    _cycle,
    partial(_facts, _of_cycle),
)
CURVE = Verification(
    ("special_second_value", "special_value", "special_period"),
    ("kind", "parameters", "limits", "points", *_BEGUN),
    _curve,
    partial(_facts, _of_curve),
)
BRANCH = Verification(
    ("special_value", "special_period", "slope", "stability"),
    ("parameter", "limits", "direction", "points", "start_special", *_BEGUN),
    _branch,
    partial(_facts, _of_branch),
)
