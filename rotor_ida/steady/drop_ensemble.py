"""Many drops of one rotor: distributions of the results of a drop over uncertain parameters.

draw each drop: phase, friction, damping, unbalance and clearance, at random or on a grid;
follow each drop twice, to its horizon;
keep the loads of each bearing;
summarise random drops: means, quantiles and fractions, each with its sampling error, and how many
of the drops reached each figure before their horizon;
summarise a grid: ranges and where their ends lie, means by quadrature, and what the grid resolves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import (
    check_axis,
    check_count,
    check_distinct,
    check_nonnegative,
    check_positive,
    check_progress,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.in_si import takes_system
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.si_units import with_system_units
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import STATUS, WHIRL_DIRECTION, labelled_dataset
from rotor_ida.steady.drop import drop
from rotor_ida.steady.drop_figures import NUMBERS
from rotor_ida.steady.drop_statistics import QUANTILES, cells_of, grid_statistics_of, statistics_of
from rotor_ida.steady.grid import EXPECTED, Answer, Answers, Ramps, run_study

# What varies, with the ranges that are allowed. Factors multiply what is given.
VARIED = {
    "phase": (-math.tau, math.tau),
    "friction": (0.0, 10.0),
    "contact_damping": (0.0, 1e6),
    "unbalance_factor": (0.0, 1e3),
    "clearance_factor": (1e-3, 1e3),
}
MOST_DROPS = 100_000
# Drops of which one must be possible.
MOST_TRIED = 20
FIGURES = {**NUMBERS, "excursion": np.float64}
SIGNED = ("whirl_turns", "whirl_speed")
OF_NODES = "node_excursion"
# Attributes of each drop that are those of all.
TOLD = ("duration", "rtol", "speed", "start_speed", "inertia", "torque")
OF_DROP = ("first_touch_time", "standstill_time", "horizon")


@shows_progress
@takes_system
def drop_ensemble(
    system: RotorSystem,
    *,
    speed: float,
    duration: float,
    phase: npt.ArrayLike | None = None,
    friction: npt.ArrayLike | None = None,
    contact_damping: npt.ArrayLike | None = None,
    unbalance_factor: npt.ArrayLike | None = None,
    clearance_factor: npt.ArrayLike | None = None,
    drops: int | None = None,
    seed: int = 0,
    failing: Sequence[str] | None = None,
    inertia: float | None = None,
    drag: float = 0.0,
    clearances: Mapping[str, float] | None = None,
    capacities: Mapping[str, float] | None = None,
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Drop a rotor many times, and compute distributions of the bearing loads.

    Parameters
    ----------
    system, speed, duration, failing, inertia, drag, clearances, capacities, modes, rtol :
        As for `drop`.
    phase : array_like, optional
        Angle of the rotor at the drop [rad]. Default: all angles at random; 0 on a grid.
    friction, contact_damping : array_like, optional
        Of all contacts, in place of their own.
    unbalance_factor, clearance_factor : array_like, optional
        By which every unbalance, or every clearance, is multiplied.
    drops : int, optional
        Number of drops at random: what varies is drawn uniformly from its range, two numbers.
        Default: a grid of all combinations of the given values.
    seed : int
        Of the random numbers.
    workers, executor, study, progress
        As for `sweep`, with drops instead of points. The result is the same, bit for bit.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        On ``drop`` what was varied, ``first_touch_time``, ``standstill_time``, ``horizon``,
        ``status`` and ``message``; on ``(drop, contact)`` what `drop` delivers by bearing, and on
        ``(drop, node)`` the ``node_excursion`` over each other clearance. For each figure on
        ``contact`` or ``node``, of the drops in which it is known, of a random sample:
        ``largest_force_mean``, ``largest_force_mean_error`` (standard error), and the ends of its
        95 % interval, ``largest_force_mean_low`` and ``_high``;
        on ``(quantile, contact)`` ``largest_force_quantile`` and the ends of its 95 % interval,
        ``largest_force_quantile_low`` and ``_high``; and so on. ``backward_whirl_fraction``,
        ``rest_fraction``, ``decided_fraction`` and, with capacities, ``overload_fraction``, each
        with the ends ``_low`` and ``_high`` of its 95 % interval.

        Of a grid instead: ``largest_force_min`` and ``_max``, with the drops in which they occur,
        ``largest_force_min_drop`` and ``_max_drop``; ``largest_force_mean`` over the grid, and
        ``largest_force_mean_change``, by how much it changes on coarser grids; and the fractions,
        each with ``_change``. On ``cell``, the combinations of all but the phase:
        ``cell_friction`` and so on, and over the phases ``cell_largest_force`` and
        ``cell_excursion``, the largest, and ``cell_backward_whirl_fraction``.

    Raises
    ------
    InputError
        If an argument cannot be used. A drop that fails does not raise: its ``status`` and
        ``message`` give the reason.
    SimulationError
        If one of the ``"processes"``, or the scheduler, died.

    Notes
    -----
    Intervals of fractions are Wilson's; those of quantiles are the order statistics between which
    the quantile lies with 95 % by the binomial distribution, whatever the distribution of the
    figure, and infinite where the sample is too small. Those of means are Hall's, which allow for
    skewness, joined with Student's, and end where the figure must: a force at 0, a time at the
    duration. A figure known in fewer than six drops has neither quantiles nor intervals. A sample
    cannot account for rare events that it does not contain: for an event of one drop in 20 take
    about 100 drops.
    ``backward_whirl_fraction`` counts drops with a backward whirl of three turns or more,
    ``rest_fraction`` those that stay in contact at the end.

    A mean over a grid is the integral over its ranges by the trapezoidal rule, over their size;
    angles that go round count by the arcs around them. It is no estimate from a sample, so no
    sampling error applies. Its change is the sum of those as every other value of each axis is left
    out: NaN where an axis has too few values. Where motions are chaotic, figures jump between
    neighbours, and means converge slowly.

    Up to its horizon a drop is determined by its parameters. ``decided_fraction`` is the fraction
    of the drops whose largest force comes before. Where it is 1, the largest forces depend only
    on the parameters that were varied; where it is small, each one is one of many that are
    possible, and only their distribution has a meaning.

    Examples
    --------
    >>> from rotor_ida import Contact, Support, Unbalance
    >>> bearing = Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0, friction=0.1,
    ...                   radius=0.03)
    >>> system = RotorSystem(
    ...     mass=np.diag([20.0, 20.0]), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)},
    ...     contacts=[bearing], supports=[Support(node="disc", stiffness=2e6, damping=2e3)],
    ...     unbalance=[Unbalance(node="disc", moment=8e-5)])
    >>> many = drop_ensemble(system, speed=500.0, duration=0.1, inertia=0.08,
    ...                      friction=(0.05, 0.2), drops=8, workers=1)
    >>> many.sizes["drop"], bool((many.largest_force > 500.0).all())
    (8, True)
    >>> many.backward_whirl_fraction.values, many.backward_whirl_fraction_high.values.round(3)
    (array([0.]), array([0.324]))
    """
    system = changed_system(drop_ensemble, system, changed)
    progress = check_progress(progress)
    given = {
        "phase": phase, "friction": friction, "contact_damping": contact_damping,
        "unbalance_factor": unbalance_factor, "clearance_factor": clearance_factor,
    }  # fmt: skip
    axes, varied = design_of(given, drops, seed)
    case: dict[str, Any] = {
        "system": system, "speed": check_real("speed", speed),
        "duration": check_positive("duration", duration), "failing": failing,
        "drag": check_nonnegative("drag", drag),
        "inertia": None if inertia is None else check_positive("inertia", inertia), "modes": modes,
        "rtol": rtol, "clearances": clearances, "capacities": capacities,
    }  # fmt: skip
    example = _example(case, varied)
    ways = {name: check_axis(name, each).tolist() for name, each in given.items()
            if each is not None}  # fmt: skip
    asked = {"rotor" if name == "system" else name: each for name, each in case.items()}
    question = Question("drop_ensemble", {**asked, **ways, "drops": drops, "seed": seed})
    columns = run_study(
        _every_drop(case, varied), question, word="drop", study=study,
        workers=choose(executor, workers, compiled=True), progress=progress,
    ).points  # fmt: skip
    told = {name: example.attrs[name] for name in TOLD if name in example.attrs}
    told |= {} if drops is None else {"seed": seed}
    gaps = np.array([each.clearance for each in system.contacts])
    over = axes if drops is None else None
    return with_system_units(_dataset(example, varied, gaps, columns, told, over), system)


def _every_drop(
    case: dict[str, Any], varied: Mapping[str, Values]
) -> Ramps[dict[str, float], None]:
    """Return the jobs, one for each drop."""
    point = _point(len(case["system"].contacts), len(case["clearances"] or ()))
    return Ramps(
        Varied({"drop": np.arange(varied["phase"].size)}), (None,),
        Answers(partial(follow_drop, case), point),
        lambda place: {name: float(each[place[0]]) for name, each in varied.items()},
    )  # fmt: skip


def _example(case: Mapping[str, Any], varied: Mapping[str, Values]) -> xr.Dataset:
    """Return the first drop that can be computed: one that touches at once is lost, not all."""
    refused: Exception | None = None
    for values in list(zip(*varied.values(), strict=True))[:MOST_TRIED]:
        try:
            at = dict(zip(varied, map(float, values), strict=True))
            return drop(**_arguments(case, at), samples=2, progress=None)
        except (InputError, *EXPECTED) as error:
            refused = refused or error
    assert refused is not None
    raise refused


def design_of(
    given: Mapping[str, object], drops: int | None = None, seed: object = 0
) -> tuple[dict[str, Values], dict[str, Values]]:
    """Return the values or ranges of what varies, and its value in each drop."""
    axes = _axes(given)
    return axes, _grid(axes) if drops is None else _random(axes, given, drops, seed)


def _axes(given: Mapping[str, object]) -> dict[str, Values]:
    """Return the values of what varies."""
    found: dict[str, Values] = {}
    for name, values in given.items():
        if values is None:
            continue
        axis = check_axis(name, values)
        low, high = VARIED[name]
        if not (axis.min() >= low and axis.max() <= high):
            value = float(axis.min() if axis.min() < low else axis.max())
            raise InputError(
                "{name} must lie from {low:.4g} to {high:.4g}, got {value}",
                name=name, low=low, high=high, value=value,
            )  # fmt: skip
        found[name] = axis
    return found


def _grid(axes: dict[str, Values]) -> dict[str, Values]:
    """Return the value of what varies in each drop of a grid."""
    axes.setdefault("phase", np.zeros(1))
    grid = Varied(axes)
    if grid.points > MOST_DROPS:
        raise InputError(f"drops must be at most {MOST_DROPS} on the grid, got {grid.points}")
    for name, axis in axes.items():
        check_distinct(name, axis)
    return grid.columns


def _random(
    axes: dict[str, Values], given: Mapping[str, object], drops: int, seed: object
) -> dict[str, Values]:
    """Return the value of what varies in each drop at random."""
    count = check_count("drops", drops, minimum=2, maximum=MOST_DROPS)
    draw = np.random.default_rng(check_count("seed", seed, minimum=0))
    axes.setdefault("phase", np.array([0.0, math.tau]))
    found: dict[str, Values] = {}
    for name, axis in axes.items():
        if axis.size != 2 or not axis[0] <= axis[1]:
            raise InputError(
                f"{name} must be a range of two numbers, the lower first, got {shown(given[name])}"
            )
        found[name] = draw.uniform(float(axis[0]), float(axis[1]), count)
    return found


def _arguments(case: Mapping[str, Any], varied: Mapping[str, float]) -> dict[str, Any]:
    """Return the arguments of `drop` for one drop."""
    system = case["system"]
    contacts = list(system.contacts)
    changes = {"friction": "friction", "contact_damping": "damping"}
    for name, field in changes.items():
        if name in varied:
            contacts = [replace(each, **{field: varied[name]}) for each in contacts]
    factor = varied.get("clearance_factor", 1.0)
    contacts = [replace(each, clearance=factor * each.clearance) for each in contacts]
    factor = varied.get("unbalance_factor", 1.0)
    unbalance = [replace(each, moment=factor * each.moment) for each in system.unbalance]
    changed = replace(system, contacts=contacts, unbalance=unbalance)
    return {**case, "system": changed, "phase": varied["phase"]}


def follow_drop(
    case: dict[str, Any], varied: dict[str, float], _start: None, _stop: Stop
) -> Answer:
    """Follow one drop."""
    try:
        run = drop(**_arguments(case, varied))
    except InputError as error:  # what was drawn cannot be dropped, as it touches at once
        return Answer({}, str(error), failed=True)
    touches = run["event_time"].values
    figures: dict[str, Any] = {name: run[name].values for name in FIGURES}
    figures |= {"horizon": float(run["horizon"]), "standstill_time": float(run["standstill_time"]),
                "first_touch_time": float(touches[0]) if touches.size else math.nan}  # fmt: skip
    if case["clearances"]:
        figures[OF_NODES] = run[OF_NODES].values[np.isfinite(run["node_clearance"].values)]
    return Answer(figures)


def _point(contacts: int, clearances: int) -> np.dtype[np.void]:
    """Return the columns of a drop."""
    of_nodes = [(OF_NODES, np.float64, (clearances,))] if clearances else []
    return np.dtype([
        *((name, kind, (contacts,)) for name, kind in FIGURES.items()), *of_nodes,
        *((name, np.float64) for name in OF_DROP),
        ("status", np.int8),
    ])  # fmt: skip


def _dataset(
    example: xr.Dataset, varied: Mapping[str, Values], clearances: Values,
    columns: Mapping[str, npt.NDArray[Any]], told: Mapping[str, object],
    axes: Mapping[str, Values] | None,
) -> xr.Dataset:  # fmt: skip
    """Return drops as a labelled dataset, with statistics of a sample, or of a grid by its axes."""
    both = ("drop", "contact")
    variables: dict[str, Column] = {name: (both, columns[name]) for name in FIGURES}
    variables |= {name: ("drop", columns[name]) for name in (*OF_DROP, "status", "message")}
    variables |= {f"drop_{name}": ("drop", values) for name, values in varied.items()}
    variables |= {"contact_node": ("contact", example["contact_node"].values),
                  "clearance": ("contact", clearances)}  # fmt: skip
    coordinates: dict[str, Column] = {"drop": ("drop", np.arange(len(columns["status"])))}
    if axes is None:
        coordinates["quantile"] = ("quantile", np.array(QUANTILES))
    if OF_NODES in columns:
        own = example.isel(node=np.isfinite(example["node_clearance"].values))
        variables |= {OF_NODES: (("drop", "node"), columns[OF_NODES]),
                      "node_clearance": ("node", own["node_clearance"].values)}  # fmt: skip
        coordinates["node"] = ("node", own["node"].values)
    capacities = example["load_capacity"].values if "load_capacity" in example else None
    if capacities is not None:
        variables["load_capacity"] = ("contact", capacities)
    duration = float(example.attrs["duration"])
    variables |= _statistics(columns, capacities, axes, duration)
    title = "Rotor system: many drops on touchdown bearings"
    return labelled_dataset(title, variables, coordinates, provenance(told), kind="drop_ensemble")


def _statistics(
    columns: Mapping[str, npt.NDArray[Any]],
    capacities: Values | None,
    axes: Mapping[str, Values] | None,
    duration: float,
) -> dict[str, Column]:
    """Return statistics of a sample, or of a grid by its axes."""
    done = columns["status"] == STATUS["done"]
    names = [name for name in FIGURES if name != "whirl_sense"]
    numbers = {name: np.where(done[:, np.newaxis], columns[name], math.nan)
               for name in (*names, OF_NODES) if name in columns}  # fmt: skip
    facts = {
        "backward_whirl": columns["whirl_sense"] == WHIRL_DIRECTION["backward"],
        "rest": ~np.isnan(columns["rest_time"]),
        "decided": columns["largest_force_time"] <= columns["horizon"][:, np.newaxis],
    }
    if capacities is not None:
        facts["overload"] = columns["largest_force"] > capacities
    known = {name: np.where(done[:, np.newaxis], each, math.nan) for name, each in facts.items()}
    along = {OF_NODES: "node"}
    if axes is None:
        of_done = {name: each[done] for name, each in facts.items()}
        possible = {name: _possible(name, duration) for name in numbers}
        return statistics_of(numbers, of_done, along, possible)
    largest = {name: numbers[name] for name in ("largest_force", "excursion")}
    whirls = {"backward_whirl": known["backward_whirl"]}
    return grid_statistics_of(numbers, known, axes, along) | cells_of(largest, whirls, axes)


def _possible(name: str, duration: float) -> tuple[float, float]:
    """Return the least and the largest value that a figure can have."""
    if name in SIGNED:
        return -math.inf, math.inf
    return 0.0, duration if name.endswith("_time") else math.inf
