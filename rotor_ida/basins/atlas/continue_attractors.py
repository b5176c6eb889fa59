"""Attractors and their basin fractions over speed, damping, clearance and other parameters."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import closing
from operator import attrgetter
from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins.atlas.cells import FORM, MOST_STARTS, Cell, CellJob, fill_cell
from rotor_ida.basins.atlas.dataset import atlas_dataset, how_computed
from rotor_ida.basins.atlas.identities import identify
from rotor_ida.basins.basin import LOOSEST, TIGHTEST, check_rotor
from rotor_ida.basins.following import RTOL
from rotor_ida.checks import (
    COMPONENTS,
    MOST_SHOCKS,
    Names,
    check_array,
    check_between,
    check_count,
    check_increasing,
    check_progress,
    check_seed,
    is_scalar,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.varied import Varied, varied_of
from rotor_ida.parallel import FailedJob, Progress, choose, interruptible, run_all, shows_progress
from rotor_ida.results.in_si import varies_in_si
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Results, open_results
from rotor_ida.simulation.options import LARGEST
from rotor_ida.simulation.starts import box_of, drawn_from, range_of

# The atlas is drawn over a line or a plane.
MOST_AXES = 2
# At the end all rotors and their attractors are in memory.
MOST_ROTORS = 100_000


@varies_in_si
@shows_progress
def continue_attractors(
    rotor: Rotor | DimensionalRotor | None = None,
    *,
    x: npt.ArrayLike = 0.0,
    y: npt.ArrayLike = 0.0,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    starts: int | npt.ArrayLike = 1000,
    seed: int = 0,
    rtol: float | None = None,
    shocks: int = 0,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the attractors over speed, damping or clearance, and their basin fractions.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given.
    x, y, vx, vy : float or array_like, shape (2,)
        Components of the start [1]: numbers, or ranges ``(low, high)`` from which they are drawn
        independently and uniformly.
    starts : int or array_like, shape (n, 4)
        Number of starts, the same for all rotors; or the starts themselves, ``(x, y, vx, vy)`` [1],
        drawn from any distribution; the ranges must then be left out.
    seed : int
        Seed of the random numbers: the same seed gives the same starts.
    shocks : int
        Number of shocks of velocity and of displacement tried to each attractor of each rotor, as
        for `rotor_ida.touchdown_report`; with 0 none.
    rtol : float, optional
        Error allowed per step, relative to the size of the state and of the eccentricity [1].
    workers, executor, study, progress
        As for `rotor_ida.basin`, but rotors are counted and stored instead of batches.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], in place of those of `rotor`. In total one or two
        are increasing arrays, the others numbers. An array becomes a dimension; a number other
        than the default becomes a coordinate. ``zeta`` must be above 0, and ``load`` must be 0:
        under a load there is no synchronous whirl.

    Returns
    -------
    Dataset
        On the parameters and ``attractor``, NaN where an attractor does not exist:
        ``fraction``, ``fraction_error`` and ``count``; ``amplitude``, ``phase_lag``,
        ``radius_min``, ``radius_max``, ``period``, ``lifetime``, ``lifetime_low``,
        ``settling_median`` and ``settling_95`` [1]; ``kind`` and ``trapping`` as flags. On the
        parameters ``undecided_fraction``, ``not_computed_count``, ``agreement``,
        ``agreement_count``, ``basin_entropy`` and ``boundary_entropy``, as in `rotor_ida.basin`.
        With `shocks`, as in `rotor_ida.touchdown_report`: ``velocity_shock`` and
        ``displacement_shock`` on ``attractor`` and ``target``, their bounds and the extents of the
        attractor on ``attractor``. The scalar ``missed_fraction``: the sample misses an attractor
        with this fraction of all starts with a probability of 5 %.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If a worker process or the scheduler died.

    Notes
    -----
    Starts are labelled as by `rotor_ida.basin_fractions`, the same starts for every rotor, but
    `rtol` is not chosen from them, and CVODE does not confirm attractors. With `shocks`, CVODE
    follows the smallest ones, with the options in the attributes ``witness_method``,
    ``witness_rtol`` and so on. An attractor has one number throughout: a limit cycle is followed
    from rotor to rotor along its branch, a whirl along the exact response curve. If no start of a
    rotor ends on a followed attractor, it is listed there with the fraction 0: its basin is too
    small for the sample. Where a period doubles, the cycle of twice the period is a new attractor.

    References
    ----------
    G. Datseris, K. Luiz Rossi, A. Wagemakers, "Framework for global stability analysis of dynamical
    systems", Chaos 33, 2023: basin fractions continued over a parameter.

    Examples
    --------
    >>> found = continue_attractors(omega=[1.7, 1.75], zeta=0.07, delta0=0.0, x=(-15, 15),
    ...                             y=(-15, 15), starts=200)
    >>> found.fraction.squeeze().values.sum(axis=1)
    array([1., 1.])
    >>> found.amplitude.squeeze().sel(omega=1.7).values.round(4)
    array([1.8796, 9.4872])
    """
    grid = _check_grid(varied_of(continue_attractors, rotor, varied))
    rotors = list(grid.rotors())
    for each in rotors:
        check_rotor(each, "an atlas")
    progress = check_progress(progress)
    states, drawn = _states({"x": x, "y": y, "vx": vx, "vy": vy}, starts, seed)
    tolerance = RTOL if rtol is None else check_between("rtol", rtol, TIGHTEST, LOOSEST)
    tried = check_count("shocks", shocks, minimum=0, maximum=MOST_SHOCKS)
    place, several = choose(executor, workers, compiled=True)
    asked = {**grid.design, **drawn, "rtol": tolerance, "shocks": tried}
    question = Question("continue_attractors", asked)
    with open_results(study, question.design(), len(rotors), FORM) as kept:
        jobs = [CellJob(each, states, tolerance, tried) for each in rotors]
        reason = _fill(jobs, kept, place, several, progress)
        cells = [Cell(each, not_computed=states.shape[1]) for each in rotors]
        for number, cell in kept.results():
            cells[number] = cell
    interruptible(lambda stop: identify(cells, _lines(grid), stop))
    description = {f"range_{each}" if each in COMPONENTS else each: drawn[each] for each in drawn}
    rubs_most = max(rotors, key=attrgetter("friction"))
    attributes = {**how_computed(tolerance, tried, rubs_most), **description}
    attributes |= question.attribute()
    if reason:
        attributes["not_computed_reason"] = reason
    return atlas_dataset(grid, cells, states.shape[1], attributes)


def _fill(
    jobs: list[CellJob], kept: Results[Cell], executor: str, workers: int | None,
    progress: Progress | None,
) -> str:  # fmt: skip
    """Follow the starts of each rotor that is not stored; return why one failed, or nothing."""
    due = [number for number in range(len(jobs)) if number not in kept.done]
    reason = ""
    if progress is not None and kept.points_done:
        progress(kept.points_done, len(jobs))
    if not due:
        return reason
    chosen = (jobs[number] for number in due)
    with closing(run_all(fill_cell, chosen, workers=workers, executor=executor)) as ended:
        for turn, cell in ended:
            if isinstance(cell, FailedJob):
                reason = cell.reason
            else:
                kept.keep(due[turn], cell, 1)
            if progress is not None:
                progress(kept.points_done, len(jobs))
    return reason


def _check_grid(grid: Varied) -> Varied:
    """Return a grid if at most two parameters vary, each along a rising axis."""
    for name, axis in grid.axes.items():
        check_increasing(name, axis)
    if len(grid.varying) > MOST_AXES:
        raise InputError(
            "two of the parameters at most may be arrays, got {names}",
            names=Names(grid.varying, "and"),
        )
    return grid.check_size(MOST_ROTORS)


def _states(
    ranges: Mapping[str, npt.ArrayLike], starts: object, seed: object
) -> tuple[Values, dict[str, object]]:
    """Return the starts, shape (4, n), and their description."""
    if is_scalar("starts", starts):
        count = check_count("starts", starts, maximum=MOST_STARTS)
        chosen = check_seed(seed)
        box = box_of(ranges, count)
        description: dict[str, object] = {"starts": count, "seed": chosen}
        description |= {name: limits.tolist() for name, limits in zip(COMPONENTS, box, strict=True)}
        return drawn_from(box, chosen, 0, count), description
    given = check_array("starts", starts, largest=LARGEST)
    if given.ndim != 2 or given.shape[1] != len(COMPONENTS) or not 1 <= len(given) <= MOST_STARTS:
        raise InputError(
            f"starts must be a number, or an array of shape (n, 4) with n from 1 to {MOST_STARTS}, "
            f"got one of shape {shown(given.shape)}"
        )
    if any(range_of(name, value) != (0.0, 0.0) for name, value in ranges.items()):
        raise InputError("x, y, vx and vy must be left out where starts are given")
    return np.ascontiguousarray(given.T), {"starts": given.tolist()}


def _lines(grid: Varied) -> list[list[int]]:
    """Return the numbers of the cells along each line of the grid.

    Attractors cannot be followed from one contact law to the other.
    """
    numbers = np.arange(grid.points).reshape(grid.shape)
    lines = []
    for axis, (name, size) in enumerate(zip(grid.dims, grid.shape, strict=True)):
        if size > 1 and name != "contact_exponent":
            lines += np.moveaxis(numbers, axis, -1).reshape(-1, size).tolist()
    return lines
