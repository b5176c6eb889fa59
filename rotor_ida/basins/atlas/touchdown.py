"""The touchdown report: forces, losses and resilience of each attractor of a rotor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import closing
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values, Watch
from rotor_ida.basins.atlas.cells import (
    MOST_STARTS,
    Cell,
    CellJob,
    DiscCell,
    Member,
    counted_cell,
    fills_of,
)
from rotor_ida.basins.atlas.dataset import (
    BEHIND,
    column_of,
    how_computed,
    member_row,
    missed_fraction,
)
from rotor_ida.basins.atlas.resilience import Fill
from rotor_ida.basins.atlas.rubbing import (
    needs_run,
    numbers_of_cycle,
    numbers_of_rub,
    numbers_of_whirl,
)
from rotor_ida.basins.atlas.shocks import KINDS
from rotor_ida.basins.atlas.system_cells import (
    SystemCellJob,
    counted_system_cell,
    numbers_of_system,
    system_fills_of,
)
from rotor_ida.basins.attractors import Attractor
from rotor_ida.basins.basin import LOOSEST, TIGHTEST, check_rotor
from rotor_ida.basins.dataset import ENTROPIES, agreement_of
from rotor_ida.basins.fates import ALONE
from rotor_ida.basins.following import RTOL
from rotor_ida.basins.known import followed_alone
from rotor_ida.basins.system_basin import coordinates_of
from rotor_ida.basins.system_labels import SystemBatch, follow_starts_of_system, how_labelled
from rotor_ida.basins.system_starts import knocked_systems, one_speed
from rotor_ida.checks import (
    COMPONENTS,
    MOST_SHOCKS,
    check_between,
    check_count,
    check_name,
    check_progress,
    check_seed,
)
from rotor_ida.cycles.dataset import whirl_of_cycle
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.errors import InputError
from rotor_ida.model.contact import contact_force
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import (
    Progress,
    Stop,
    Workers,
    choose,
    interruptible,
    run_all,
    shows_progress,
)
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.run import parameter_coordinates
from rotor_ida.results.si_units import with_system_units
from rotor_ida.results.studies.results import Results
from rotor_ida.schema import WHIRL_DIRECTION, Column, labelled_dataset
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.starts import Start, box_of, drawn_from
from rotor_ida.steady import response

# Number of shocks of each kind, unless told otherwise.
SHOCKS, SHOCKS_OF_SYSTEM = 4096, 64
# Samples of one period of a limit cycle, for its mean force, its power and its whirl.
SAMPLES = 2048
# Numbers of an attractor that add nothing here.
LEFT_OUT = ("count", "phase_lag")
# Numbers of an attractor that may be absent.
NUMBERS = (
    "largest_force", "mean_force", "contacts_per_revolution", "contact_fraction",
    "dissipation_per_revolution", "whirl_over_spin", "side_line_over_spin", "excursion",
)  # fmt: skip
# Kinds of motion that finally rotate with the unbalance,
AT_THE_SPIN = (response.SYNCHRONOUS, response.CONTACT_FREE, response.TOUCHING)
# and with friction.
OF_FRICTION = ("heat_per_revolution", "slip_distance_per_revolution", "rolling_fraction")


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
    speed, node
        Of a `RotorSystem`, as for `rotor_ida.basin`: starts are those of the node, and shocks are
        given to it.
    x, y, vx, vy : float or array_like, shape (2,)
        Components of the start [m], [m/s] or [1]: numbers, or ranges ``(low, high)`` from which
        they are drawn independently and uniformly.
    starts : int
        Number of starts, by default 1000 and of a `RotorSystem` 100.
    seed : int
        Seed of the random numbers: the same seed gives the same starts.
    rtol : float, optional
        Error allowed per step, relative to the size of the state and of the eccentricity [1];
        default: 1e-6, and 1e-10 under a load.
    shocks : int, optional
        Approximate number of shocks of velocity and of displacement applied to each attractor, to
        find the smallest one that leads to each other attractor; with 0 there are no such results.
        Default: 4096, and 0 under a load, where no more are possible. Of a `RotorSystem` 64; up to
        three times as many are followed, each by itself.
    start, modes
        As for `rotor_ida.basin`.
    workers : int, optional
        Number of attractors to which shocks are applied at a time; default: one for each core.
    progress : callable or bool, optional
        Called with the number of starts and shocks followed and their total, to which shocks are
        added once the attractors are known; True shows a bar on standard error.
    contacts, unbalance, supports, gravity, static_force : optional
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
        ``displacement_shock_scatter``, the relative excess of the best shock from another draw [1];
        and the states just before and after each, ``velocity_shock_before_x`` and so on, which
        divided by the attributes ``length_scale`` and ``velocity_scale`` are starts for
        `rotor_ida.simulate`. On ``attractor``: the sizes below which no shock leaves it,
        ``velocity_shock_bound`` and ``displacement_shock_bound``, proven or estimated as given by
        ``trapping``; and ``omega_low``, ``omega_high`` and so on [1], the range of each parameter
        in which the attractor exists, with the way it ends there, ``omega_low_end`` and so on, as a
        flag.

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
    CVODE does not confirm attractors.

    Under a load each start is followed separately, as by `rotor_ida.basin_fractions`, which takes
    some milliseconds or more. Periods are whole revolutions. Motions that never repeat are
    represented by one such motion, as with friction. There are no shocks and no ranges of
    existence: on the rotating axes, which the search for shocks uses, the load rotates.

    A shock may occur at any phase and in any direction. CVODE has followed the smallest one found
    to its attractor, with the options in the attributes ``witness_method``, ``witness_rtol`` and so
    on. A smaller one may exist, down to the bound. All whirls inside the clearance, with the
    touches that fade towards them, count as one attractor. Its bound is 0, since its outermost
    whirls just reach the stator.

    With friction, motions that roll without a period or never repeat are represented by one such
    motion, followed over many revolutions. A shock that enters no region is followed separately,
    which takes some milliseconds, for example where it may cause dry whip.

    A `RotorSystem` is followed as by `rotor_ida.basin`. A shock of velocity is a blow at the node,
    a shock of displacement pulls it aside, and the rest of the rotor goes with it as with a start.
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
    count, chosen = check_count("starts", starts, maximum=MOST_STARTS), check_seed(seed)
    box = box_of({"x": x, "y": y, "vx": vx, "vy": vy}, count)
    ranges = {f"range_{name}": ends for name, ends in zip(COMPONENTS, box, strict=True)}
    drawn = {"starts": count, "seed": chosen, **ranges}
    how = choose("threads", workers, compiled=True), check_progress(progress)
    if isinstance(rotor, RotorSystem):
        return _report_of_system(
            changed_system(touchdown_report, rotor, changed), box, drawn, check_name("node", node),
            _shocks_to_try(rotor, shocks), *how, speed=speed, start=start, modes=modes, rtol=rtol,
        )  # fmt: skip
    assert isinstance(rotor, Rotor)
    check_rotor(rotor, "a touchdown report", one_by_one=True)
    if rotor.omega == 0.0:
        raise InputError(
            "{name} must be above 0 for a touchdown report, got {value}", name="omega", value=0.0
        )
    tolerance = ALONE.rtol if followed_alone(rotor) else RTOL
    if rtol is not None:
        tolerance = check_between("rtol", rtol, TIGHTEST, LOOSEST)
    tried = _shocks_to_try(rotor, shocks)
    cell = _filled(CellJob(rotor, drawn_from(box, chosen, 0, count), tolerance, tried), *how)
    rows = [member_row(rotor, each, count) | _numbers(rotor, each) for each in cell.members]
    return _dataset(
        cell, rows, parameter_coordinates(rotor),
        {**how_computed(tolerance, tried, rotor), **drawn, **rotor.given},
    )  # fmt: skip


def _report_of_system(
    system: RotorSystem, box: Values, drawn: Mapping[str, Any], node: str, shocks: int,
    chosen: Workers, progress: Progress | None, **given: Any,
) -> xr.Dataset:  # fmt: skip
    """Return the effects of each attractor of a rotor system."""
    asked = Varied({SPEED: one_speed(given.pop("speed"))}, system)
    varied, (knocked,) = knocked_systems(asked, node, **given)
    count = int(drawn["starts"])
    job = SystemCellJob(knocked, drawn_from(box, drawn["seed"], 0, count), shocks)
    kept: Results[SystemBatch] = Results()
    followed = follow_starts_of_system(
        knocked, lambda first, last: job.states[:, first:last], count, kept,
        workers=chosen.number, executor=chosen.executor, progress=progress,
    )  # fmt: skip
    cell = counted_system_cell(job, followed)
    _try_shocks(system_fills_of(cell, shocks), count, shocks, chosen, progress)
    rows = [
        member_row(knocked, each, count - cell.not_computed)
        | numbers_of_system(each.attractor.row, knocked)
        for each in cell.members
    ]
    how = {**provenance(how_labelled(varied.rtol)), "shocks": shocks, "knocked_node": node}
    found = _dataset(
        cell, rows, coordinates_of(varied.varied.base, knocked.speed), {**how, **drawn}
    )
    return with_system_units(found, system)


def _filled(job: CellJob, workers: Workers, progress: Progress | None) -> DiscCell:
    """Follow the starts, then apply shocks to several attractors at a time."""
    watch: Watch = []
    starts = job.states.shape[1]

    def tell(done: float, total: int) -> None:
        if progress is not None:
            progress(int(done), total)

    cell, search = interruptible(
        lambda stop: counted_cell(job, stop, watch),
        told=lambda: tell(sum(decided() for decided in watch), starts),
    )
    fills = [] if search is None else fills_of(cell, search)
    # half of the jobs try shocks, of two kinds
    _try_shocks(fills, starts, job.shocks, workers, progress)
    return cell


def _try_shocks(
    fills: list[Fill], starts: int, each: int, workers: Workers, progress: Progress | None
) -> None:
    """Run jobs that try the given number of shocks each; the starts are done already."""
    total = starts + each * len(fills)
    if progress is not None:
        progress(starts, total)
    ran = run_all(_fill, fills, workers=workers.number, executor=workers.executor)
    with closing(ran) as ended:
        for done, _ in enumerate(ended, start=1):
            if progress is not None:
                progress(starts + each * done, total)


def _fill(fill: Fill, stop: Stop) -> None:
    fill(stop)


def _dataset(
    cell: Cell[Any, Any], rows: list[dict[str, Any]], coordinates: Mapping[str, Column],
    attributes: Mapping[str, object],
) -> xr.Dataset:  # fmt: skip
    """Return the numbers of each attractor as a labelled dataset."""
    is_system = not isinstance(cell.rotor, Rotor)
    variables: dict[str, Column] = {}
    for name in [each for each in (rows[0] if rows else ()) if each not in LEFT_OUT]:
        column = column_of(name, (len(rows), *np.shape(rows[0][name])))
        column[:] = [row[name] for row in rows]
        variables[name] = (("attractor", *(BEHIND.get(name, ()) if is_system else ())), column)
    variables |= (tried := _shocks(cell))
    starts = int(str(attributes["starts"]))
    variables |= {name: ((), one) for name, one in zip(ENTROPIES, cell.entropies, strict=True)}
    variables |= {name: ((), one) for name, one in agreement_of(cell.rechecked).items()}
    variables["undecided_fraction"] = ((), cell.undecided / max(starts - cell.not_computed, 1))
    variables["missed_fraction"] = ((), missed_fraction(starts))
    along = {"attractor": np.arange(len(rows))} | (
        {"target": np.arange(len(rows))} if tried else {}
    )
    coordinates = {**coordinates, **{name: (name, each) for name, each in along.items()}}
    title = "Touchdown report"
    if is_system:
        return labelled_dataset(title, variables, coordinates, attributes, kind="system_touchdown")
    return labelled_dataset(title, variables, coordinates, attributes, kind="touchdown")


def _shocks_to_try(rotor: Rotor | RotorSystem, shocks: object) -> int:
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


def _shocks(cell: Cell[Any, Any]) -> dict[str, Column]:
    """Return the smallest shocks from each attractor to each, with the states before and after."""
    shocked = [each.resilience for each in cell.members if each.resilience is not None]
    variables: dict[str, Column] = {}
    over = ("attractor", "target")
    for place, kind in enumerate(KINDS if shocked else ()):
        variables[f"{kind}_shock"] = (over, np.array([each.sizes[place] for each in shocked]))
        scatter = np.array([each.scatter[place] for each in shocked])
        variables[f"{kind}_shock_scatter"] = (over, scatter)
        variables[f"{kind}_shock_largest"] = ((), cell.largest_shocks[place])
        for when in ("before", "after"):
            states = np.array([getattr(each, when)[place] for each in shocked])
            if isinstance(cell.rotor, Rotor):
                for column, name in enumerate(COMPONENTS):
                    variables[f"{kind}_shock_{when}_{name}"] = (over, states[..., column])
            else:
                variables[f"{kind}_shock_{when}"] = ((*over, "component"), states)
    return variables


def _numbers(rotor: Rotor, member: Member[Attractor]) -> dict[str, float]:
    """Return the dimensionless numbers of one attractor."""
    attractor = member.attractor
    numbers, at_the_spin = dict.fromkeys(NUMBERS, math.nan), attractor.kind in AT_THE_SPIN
    numbers["whirl_over_spin"] = 1.0 if at_the_spin else math.nan
    numbers["whirl_sense"] = WHIRL_DIRECTION["forward" if at_the_spin else "none"]
    exponent, damped = rotor.contact_exponent, rotor.contact_damping > 0.0
    if damped:
        numbers["contact_loss_per_revolution"] = math.nan
    rubs = rotor.friction > 0.0
    if rubs:
        numbers |= dict.fromkeys(OF_FRICTION, math.nan)
    if rotor.delta0 > 0.0:  # NaN where the radius depends on the start
        numbers["excursion"] = attractor.radius_max / rotor.delta0
    if attractor.kind == response.CHAOTIC:
        if not damped:  # then the force is largest where the radius is
            force = contact_force(attractor.radius_max, rotor.delta0, exponent)
            numbers["largest_force"] = float(force)
        return numbers
    if needs_run(attractor):
        return numbers | numbers_of_rub(rotor, member.state)
    if attractor.period > 0.0:
        return numbers | _of_cycle(rotor, member)
    steady = 0.0
    if attractor.kind == response.SYNCHRONOUS:
        steady = float(contact_force(attractor.amplitude, rotor.delta0, exponent))
    numbers["largest_force"] = numbers["mean_force"] = steady
    if damped:  # at a constant radius, or in touches that vanish in the limit
        numbers["contact_loss_per_revolution"] = 0.0
    numbers["contact_fraction"] = float(attractor.kind == response.SYNCHRONOUS)
    # fading touches occur once a revolution and vanish in the limit
    numbers["contacts_per_revolution"] = float(attractor.kind == response.TOUCHING)
    speed = rotor.omega * attractor.amplitude
    numbers["dissipation_per_revolution"] = 4.0 * math.pi * rotor.zeta * speed**2 / rotor.omega
    if rubs:
        whirls = attractor.kind == response.SYNCHRONOUS
        if whirls:
            numbers |= numbers_of_whirl(rotor, attractor.amplitude, steady)
        else:
            numbers["heat_per_revolution"] = numbers["slip_distance_per_revolution"] = 0.0
        numbers["dissipation_per_revolution"] += numbers["heat_per_revolution"]
    return numbers


def _of_cycle(rotor: Rotor, member: Member[Attractor]) -> dict[str, float]:
    """Return the numbers of a limit cycle, from one period of it."""
    cycle = close_orbit(DiscFlow(rotor), member.state, member.attractor.period)
    states = cycle.flow.states(cycle.start, cycle.duration / SAMPLES * np.arange(SAMPLES + 1.0))
    whirl, states = whirl_of_cycle(cycle, states), states[:-1]
    revolution = 2.0 * math.pi / rotor.omega
    impulse = cycle.impulse
    if math.isnan(impulse):  # without clearance: the integral of a smooth periodic function
        radii = np.hypot(states[:, 0], states[:, 1])
        force = contact_force(radii, rotor.delta0, rotor.contact_exponent)
        impulse = float(force.mean()) * cycle.duration
    # velocities resolved on the rotating axes are those of the fixed axes, rotated
    power = 2.0 * rotor.zeta * float((states[:, 2] ** 2 + states[:, 3] ** 2).mean())
    loss = float(np.nansum(cycle.piece.contacts["lost"])) * revolution / cycle.duration
    numbers = {"contact_loss_per_revolution": loss} if rotor.contact_damping > 0.0 else {}
    heat = 0.0
    if rotor.friction > 0.0:
        numbers |= numbers_of_cycle(cycle)
        heat = numbers["heat_per_revolution"]
    return numbers | {
        "largest_force": cycle.largest_force,
        "mean_force": impulse / cycle.duration,
        "contacts_per_revolution": cycle.contacts * revolution / cycle.duration,
        "contact_fraction": _time_in_contact(cycle) / cycle.duration if cycle.contacts else 1.0,
        "dissipation_per_revolution": power * revolution + loss + heat,
        **whirl,
    }


def _time_in_contact(cycle: Orbit) -> float:
    """Return the time in contact of a closed orbit; one contact may extend over its end."""
    entry = np.nan_to_num(cycle.piece.contacts["entry"], nan=0.0)
    leaving = np.nan_to_num(cycle.piece.contacts["exit"], nan=cycle.duration)
    return float((leaving - entry).sum())
