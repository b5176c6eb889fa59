"""The touchdown report: forces, losses and resilience of each attractor of a rotor."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Unpack

import numpy.typing as npt
import xarray as xr

from rotor_ida.basins.atlas.cells import (
    MOST_STARTS,
    Cell,
    CellJob,
    cell_of,
    fills_of,
    scouted_of,
)
from rotor_ida.basins.atlas.dataset import atlas_dataset, how_computed
from rotor_ida.basins.disc import RTOL
from rotor_ida.basins.fates import ALONE
from rotor_ida.basins.following import follow_starts
from rotor_ida.basins.known import followed_alone
from rotor_ida.basins.starts import Box
from rotor_ida.basins.subjects import one_rotor, subjects_of
from rotor_ida.checks import MOST_SHOCKS, check_count, check_progress
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, Stop, Workers, choose, interruptible, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.studies.results import Results
from rotor_ida.simulation.starts import Start

# Number of shocks of each kind, unless told otherwise.
SHOCKS, SHOCKS_OF_SYSTEM = 4096, 64


@takes_rotors(
    system=("node", "start", "modes"), needed=("speed", "node"), defaults={"starts": (1000, 100)}
)
@shows_progress
def touchdown_report(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    speed: float | None = None,
    node: str | None = None,
    x: npt.ArrayLike = 0.0,
    y: npt.ArrayLike = 0.0,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    starts: int | None = None,
    seed: int = 0,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    rtol: float | None = None,
    shocks: int | None = None,
    workers: int | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute the effects of each attractor on a machine, and its basin fraction.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. For a `DimensionalRotor` starts and results are in SI units.
    speed, node, x, y, vx, vy, seed, start, modes
        The starts, as for `rotor_ida.continue_attractors`, at one speed. Shocks of a `RotorSystem`
        are given to the node.
    starts : int
        Number of starts, by default 1000 and of a `RotorSystem` 100.
    rtol : float, optional
        Error allowed per step, relative to the size of the state and of the eccentricity
        [dimensionless]; default: 1e-6, and 1e-10 where each start is followed separately.
    shocks : int, optional
        Approximate number of shocks of velocity and of displacement applied to each attractor, to
        find the smallest one that leads to each other attractor; with 0 there are no such results.
        Default: 4096, and 0 under a load, where no more are possible. Of a `RotorSystem` 64; up to
        three times as many are followed, each by itself.
    workers : int, optional
        Number of batches of starts, then of attractors to which shocks are applied, at a time;
        default: one for each core.
    progress : callable or bool, optional
        Called with the number of starts and shocks followed and their total, to which shocks are
        added once the attractors are known, and where a search for smaller ones goes on; True shows
        a bar on standard error.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``attractor``: ``kind``; ``fraction`` and ``fraction_error`` of the starts that end
        there, ``settling_median`` and ``settling_95`` [s]; ``largest_force`` and its mean over
        time, ``mean_force`` (impulse per second) [N], both of the normal force;
        ``contacts_per_revolution`` and ``contact_fraction``, the fraction of time in contact;
        ``dissipation_per_revolution``, the total energy dissipated [J], and with contact damping
        its part in that, ``contact_loss_per_revolution``; with friction, whose heat is part of the
        total too, ``heat_per_revolution`` [J], the sliding distance
        ``slip_distance_per_revolution`` [m], and ``rolling_fraction``, the fraction of contact time
        in which the disc rolls; ``whirl_over_spin`` and ``whirl_sense`` of the motion, as of
        `rotor_ida.whirl_ratio`, and ``side_line_over_spin``, the frequency of the strongest line
        other than 1X, over the spin speed; ``radius_min``, ``radius_max``, ``period`` [m], [s];
        ``excursion``, the largest distance from the bearing axis over the clearance. Scalars:
        ``basin_entropy``, ``boundary_entropy``, and ``agreement``, the fraction of
        ``agreement_count`` recomputed labels that are unchanged with a smaller error per step.
        For chaos, numbers that need a period are NaN; so is its largest force with contact damping.

        With `shocks`, on ``(attractor, target)``: ``velocity_shock`` and ``displacement_shock``
        [m/s], [m], NaN if none was found up to ``velocity_shock_largest`` and
        ``displacement_shock_largest``; ``velocity_shock_scatter`` and
        ``displacement_shock_scatter``, the relative excess of the best shock from another draw
        [dimensionless]; and the states just before and after each, ``velocity_shock_before_x`` and
        so on, which divided by the attributes ``length_scale`` and ``velocity_scale`` are starts
        for `rotor_ida.simulate`. On ``attractor``: the sizes below which no shock leaves it,
        ``velocity_shock_bound`` and ``displacement_shock_bound``, proven or estimated as given by
        ``trapping``; and ``omega_low``, ``omega_high`` and so on [dimensionless], the range of each
        parameter in which the attractor exists, with the way it ends there, ``omega_low_end`` and
        so on, as a flag.

        Of a `RotorSystem` forces, contacts and losses are on ``(attractor, contact)``, the sense of
        the whirl on ``(attractor, node)``, the states before and after a shock on ``component``, as
        ``velocity_shock_before`` and so on: displacements, then velocities. It has no bounds, which
        are those of trapping regions, and no ranges of existence.

    Raises
    ------
    InputError
        If an argument cannot be used, the machine does not turn, or shocks are to be applied under
        a load.

    Notes
    -----
    Energy is supplied by the drive. It is dissipated by damping, ``2 zeta |z'|**2``, by contact
    damping and by friction; otherwise the contact is elastic. With friction the drive also supplies
    the torque that turns the disc against it.

    Starts are labelled as by `rotor_ida.basin_fractions`, with the same `rtol` for any machine.
    No separate run confirms attractors.

    Under a load periods are whole revolutions. Motions that never repeat are
    represented by one such motion, as with friction. There are no shocks and no ranges of
    existence: on the rotating axes, which the search for shocks uses, the load rotates.

    A shock may occur at any phase and in any direction. A separate run has followed the smallest
    one found to its attractor, with the options in the attributes ``witness_method``,
    ``witness_rtol`` and so on. A smaller one may exist, down to the bound. All whirls inside the
    clearance, with the touches that fade towards them, count as one attractor. Its bound is
    0, since its outermost whirls just reach the stator.

    With friction, motions that roll without a period or never repeat are represented by one such
    motion, followed over many revolutions. A shock that enters no region is followed separately,
    which takes some milliseconds, for example where it may cause dry whip.

    A `RotorSystem` is followed as by `rotor_ida.basin`. A shock changes the velocity or the
    displacement of the node, and the other nodes follow as at a start.
    If the system is axisymmetric, shocks are given at any phase of the motion, otherwise after
    whole revolutions. The smallest has been followed again with a tighter tolerance.

    References
    ----------
    L. Halekotte, U. Feudel, "Minimal fatal shocks in multistable complex networks", Scientific
    Reports 10, 2020: the smallest shock that leaves a basin. A. Daza et al., "Basin entropy: a new
    tool to analyze uncertainty in dynamical systems", Scientific Reports 6, 2016.

    Examples
    --------
    >>> from rotor_ida import DimensionalRotor
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=1000.0)
    >>> report = touchdown_report(machine, x=(-1e-5, 1e-5), y=(-1e-5, 1e-5), starts=100,
    ...                           shocks=512)
    >>> report.largest_force.dims, report.largest_force.attrs["units"]
    (('attractor',), 'N')
    >>> bool((report.velocity_shock_bound <= report.velocity_shock.min("target")).all())
    True

    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=1.5, shaft_stiffness=0.1).system()
    >>> report = touchdown_report(system, speed=0.7, node="disc", x=(-1.5, 0), y=(-2, -1), starts=8,
    ...                           shocks=0)
    >>> report.contact_fraction.values.tolist()
    [[1.0], [0.0]]
    """
    box = Box.of(starts, seed, MOST_STARTS, x=x, y=y, vx=vx, vy=vy)
    count, tried = box.count, _shocks_to_try(rotor, shocks)
    how = choose("threads", workers, compiled=True), check_progress(progress)
    if isinstance(rotor, RotorSystem):
        rotor = changed_system(touchdown_report, rotor, changed)
    elif isinstance(rotor, Rotor) and rotor.omega == 0.0:
        raise InputError(
            "{name} must be above 0 for a touchdown report, got {value}", name="omega", value=0.0
        )
    subjects = subjects_of(
        one_rotor(rotor, speed), "a touchdown report", node=node, start=start, modes=modes,
        rtol=rtol, loaded=True,
    )  # fmt: skip
    (point,) = subjects.points
    alone = isinstance(point, Rotor) and followed_alone(point)
    tolerance = subjects.rtol or (ALONE.rtol if alone else RTOL)
    cell = _filled(CellJob(point, box.starts(0, count), tried, tolerance), *how)
    for number, each in enumerate(cell.members):
        each.identity = number
    attributes = {
        **how_computed(tolerance, tried, subjects), **subjects.told, **box.attributes,
        **(point.given if isinstance(point, Rotor) else {}),
    }  # fmt: skip
    return atlas_dataset(subjects, [cell], count, attributes, is_report=True)


def _filled(job: CellJob, workers: Workers, progress: Progress | None) -> Cell:
    """Follow the starts, then apply shocks to several attractors at a time."""
    starts = job.states.shape[1]
    labeller = interruptible(lambda stop: scouted_of(job, stop))
    followed = follow_starts(
        labeller, lambda first, last: job.states[:, first:last], starts, Results(),
        workers=workers, progress=progress,
    )  # fmt: skip
    if followed.ended.interrupted:
        raise KeyboardInterrupt
    cell = cell_of(job, followed)
    fills = interruptible(lambda stop: fills_of(cell, labeller, job.shocks, stop))

    def told() -> None:
        if progress is not None:
            followed = [sum(each.followed) for each in fills]
            # a search for smaller shocks follows more than were asked for
            total = sum(max(each.shocks, done) for each, done in zip(fills, followed, strict=True))
            progress(starts + sum(followed), starts + total)

    def work(stop: Stop) -> None:
        with ThreadPoolExecutor(workers.number) as pool:
            try:
                list(pool.map(lambda each: each.work(stop), fills))
            finally:
                stop[0] = 1

    told()
    interruptible(work, told=told)
    if progress is not None:
        total = starts + sum(sum(each.followed) for each in fills)
        progress(total, total)
    return cell


def _shocks_to_try(rotor: object, shocks: object) -> int:
    """Return the number of shocks to try: none under a load, which rotates on the rotating axes."""
    is_loaded = isinstance(rotor, Rotor) and rotor.load > 0.0
    if shocks is None:
        usual = SHOCKS if isinstance(rotor, Rotor) else SHOCKS_OF_SYSTEM
        return 0 if is_loaded else usual
    tried = check_count("shocks", shocks, minimum=0, maximum=MOST_SHOCKS)
    if tried and isinstance(rotor, Rotor) and is_loaded:
        raise InputError(
            "shocks must be 0 under a load, got {tried} with {load=}", tried=tried, load=rotor.load
        )
    return tried
