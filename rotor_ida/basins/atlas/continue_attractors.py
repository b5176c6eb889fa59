"""Attractors and their basin fractions over speed, damping, clearance and other parameters."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins.atlas.cells import MOST_STARTS, Cell, CellJob, fill_cell, form_of
from rotor_ida.basins.atlas.dataset import atlas_dataset, how_computed
from rotor_ida.basins.atlas.identities import identify
from rotor_ida.basins.disc import RTOL
from rotor_ida.basins.starts import Box
from rotor_ida.basins.subjects import OF_SYSTEM, subjects_of
from rotor_ida.checks import (
    COMPONENTS,
    MOST_SHOCKS,
    Names,
    check_array,
    check_count,
    check_increasing,
    check_progress,
    is_scalar,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, Workers, choose, interruptible, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import open_results
from rotor_ida.simulation.options import LARGEST
from rotor_ida.simulation.starts import Start, range_of
from rotor_ida.steady.grid import keep_whole, run_due
from rotor_ida.steady.points import turning_speeds

# The atlas is drawn over a line or a plane.
MOST_AXES = 2
# At the end all rotors and their attractors are in memory.
MOST_ROTORS = 100_000


@takes_rotors(
    system=("node", "start", "modes"), needed=("speed", "node"),
    defaults={"starts": (1000, 100)}, varies=True,
)  # fmt: skip
@shows_progress
def continue_attractors(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    node: str | None = None,
    x: npt.ArrayLike = 0.0,
    y: npt.ArrayLike = 0.0,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    starts: int | npt.ArrayLike | None = None,
    seed: int = 0,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    rtol: float | None = None,
    shocks: int = 0,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Compute the attractors over speed, damping or clearance, and their basin fractions.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem, optional
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given.
    speed, node
        Spin speeds of a `RotorSystem`, not 0, and the node whose starts these are, as for
        `rotor_ida.basin`. The speeds of a `DimensionalRotor` are a parameter of it.
    x, y, vx, vy, seed, start, modes
        The starts, as for `rotor_ida.basin_fractions`: the same for all rotors.
    starts : int or array_like, shape (n, 4)
        Number of starts, by default 1000 and of a `RotorSystem` 100; or the starts themselves,
        ``(x, y, vx, vy)`` [dimensionless], drawn from any distribution; the ranges must then be
        left out.
    shocks : int
        Number of shocks of velocity and of displacement tried to each attractor of each rotor, as
        for `rotor_ida.touchdown_report`; with 0 none.
    rtol : float, optional
        Error allowed per step, relative to the size of the state and of the eccentricity
        [dimensionless].
    workers, executor, study, progress
        As for `rotor_ida.basin`, but rotors are counted and stored instead of batches.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`. In total one or
        two are increasing arrays, the others numbers. An array becomes a dimension; a number other
        than the default becomes a coordinate. ``zeta`` must be above 0, and ``load`` must be 0:
        under a load there is no synchronous whirl. Of a `RotorSystem` the speed or one of
        ``damping``, ``stiffness``, ``clearance``, ``friction`` and ``unbalance``, as for
        `rotor_ida.sweep`, besides its fields.

    Returns
    -------
    Dataset
        On the parameters and ``attractor``, NaN where an attractor does not exist:
        ``fraction``, ``fraction_error`` and ``count``; ``amplitude``, ``phase_lag``,
        ``radius_min``, ``radius_max``, ``period``, ``lifetime``, ``lifetime_low``,
        ``settling_median`` and ``settling_95`` [dimensionless]; ``kind`` and ``trapping`` as flags.
        On the parameters ``undecided_fraction``, ``not_computed_count``, ``agreement``,
        ``agreement_count``, ``basin_entropy`` and ``boundary_entropy``, as in `rotor_ida.basin`.
        With `shocks`, as in `rotor_ida.touchdown_report`: ``velocity_shock`` and
        ``displacement_shock`` on ``attractor`` and ``target``, their bounds and the extents of the
        attractor on ``attractor``. The scalar ``missed_fraction``: the sample misses an attractor
        with this fraction of all starts with a probability of 5 %. Of a `RotorSystem` the numbers
        of an attractor are those of `rotor_ida.basin`, on contacts and nodes, and there are no
        bounds of shocks and no extents.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If a worker process or the scheduler died.

    Notes
    -----
    Starts are labelled as by `rotor_ida.basin_fractions`, the same starts for every rotor, but
    `rtol` is not chosen from them, and no separate run confirms attractors. With `shocks`, separate
    runs follow the smallest ones, with the options in the attributes ``witness_method``,
    ``witness_rtol`` and so on. An attractor has one number throughout: a limit cycle is followed
    from rotor to rotor along its branch, a whirl along the exact response curve. If no start of a
    rotor ends on a followed attractor, it is listed there with the fraction 0: its basin is too
    small for the sample. Where a period doubles, the cycle of twice the period is a new attractor.

    Attractors of a `RotorSystem` at neighbouring points have one number if each leads to the other
    where the system is followed from it at the other point, so that a step must not be so large
    that an attractor leaves its basin. All contact-free motions count as one attractor.

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

    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=1.5, shaft_stiffness=0.1).system()
    >>> found = continue_attractors(system, speed=[0.7, 0.72], node="disc", x=(-1.5, 0), y=(-2, -1),
    ...                             starts=8)
    >>> found["count"].values.tolist()
    [[2, 6], [5, 3]]
    """
    states, drawn, told = _states({"x": x, "y": y, "vx": vx, "vy": vy}, starts, seed)
    tried = check_count("shocks", shocks, minimum=0, maximum=MOST_SHOCKS)
    how = choose(executor, workers, compiled=True), check_progress(progress), study
    if isinstance(rotor, RotorSystem):
        asked = varied_system_of(
            continue_attractors, rotor, varied, turning_speeds(speed, OF_SYSTEM)
        )
    else:
        asked = varied_of(continue_attractors, rotor, varied)
    subjects = subjects_of(
        _check_grid(asked), "an atlas", node=node, start=start, modes=modes, rtol=rtol
    )
    tolerance = subjects.rtol or RTOL
    asked_of = {**asked.design, **subjects.given, **drawn, "rtol": tolerance, "shocks": tried}
    question = Question("continue_attractors", asked_of)
    jobs = [CellJob(each, states, tried, tolerance) for each in subjects.points]
    cells, reason = _filled(jobs, question, *how)
    interruptible(lambda stop: identify(cells, _lines(asked), stop))
    attributes = {
        **how_computed(tolerance, tried, subjects), **subjects.told, **told,
        **({"not_computed_reason": reason} if reason else {}), **question.attribute(),
    }  # fmt: skip
    return atlas_dataset(subjects, cells, states.shape[1], attributes)


def _filled(
    jobs: Sequence[CellJob], question: Question, workers: Workers, progress: Progress | None,
    study: str | os.PathLike[str] | None,
) -> tuple[list[Cell], str]:  # fmt: skip
    """Return the cell of each rotor, and why one failed, or nothing."""
    count, cells = len(jobs), [Cell(each.rotor, not_computed=each.states.shape[1]) for each in jobs]
    with open_results(study, question.design, count, form_of(jobs[0].rotor)) as kept:
        run_due(
            fill_cell, jobs.__getitem__, range(count), kept, partial(keep_whole, kept, lambda _: 1),
            workers=workers, progress=progress, total=count,
        )  # fmt: skip
        for number, cell in kept.results():
            cells[number] = replace(cell, rotor=jobs[number].rotor)
    return cells, kept.lost


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
) -> tuple[Values, dict[str, Any], dict[str, object]]:
    """Return the starts, shape (4, n), and what they are as arguments and as attributes."""
    if is_scalar("starts", starts):
        box = Box.of(starts, seed, MOST_STARTS, **ranges)
        return box.starts(0, box.count), box.given, box.attributes
    given = check_array("starts", starts, largest=LARGEST)
    if given.ndim != 2 or given.shape[1] != len(COMPONENTS) or not 1 <= len(given) <= MOST_STARTS:
        raise InputError(
            f"starts must be a number, or an array of shape (n, 4) with n from 1 to {MOST_STARTS}, "
            f"got one of shape {shown(given.shape)}"
        )
    if any(range_of(name, value) != (0.0, 0.0) for name, value in ranges.items()):
        raise InputError("x, y, vx and vy must be left out where starts are given")
    told = {"starts": given.tolist()}
    return np.ascontiguousarray(given.T), told, told


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
