"""Basins of attraction of a rotor system, over the states of one of its nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.basins.dataset import Labelled, basin_dataset, fractions_dataset
from rotor_ida.basins.following import tighter_than
from rotor_ida.basins.starts import Box, Plane, check_number_of_starts
from rotor_ida.basins.system_labels import FORM, FollowedSystem, follow_starts_of_system
from rotor_ida.basins.system_starts import KnockedSystem
from rotor_ida.checks import check_between, check_progress, check_real
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder, open_results
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import RESPONSE, by_number
from rotor_ida.simulation.systems.ends import state_at_end
from rotor_ida.simulation.systems.flow import SettlingProblem
from rotor_ida.simulation.systems.simulate import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.simulation.systems.starts import Start
from rotor_ida.steady.system_sweep import OF_CONTACT, OF_NODE, check_slowest

LABELLING = (
    "every start followed separately by Taylor series, as in a sweep with labelling_rtol; motions "
    "matched by kind, period, radii and state; some starts labelled again with agreement_rtol"
)


@shows_progress
def basin_system(
    system: RotorSystem,
    *,
    speed: float,
    node: str,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute basins of attraction of a rotor system on a plane of states of one node.

    Parameters
    ----------
    system : RotorSystem
        The rotor. It must have a contact, and be damped.
    speed : float
        Spin speed, not 0.
    node : str
        The node that is knocked to each place.
    x, y, vx, vy : float or array_like, shape (n,)
        Displacement and velocity of the node at time 0: exactly two are increasing arrays.
    start : (q, velocity), "settled", "rest", None or Dataset, optional
        The state that is changed so that the node starts as asked: as in `simulate`, by default at
        rest at 0. See the notes for what the other nodes do.
    modes : int, optional
        As in `simulate`.
    rtol : float
        Relative tolerance, from 1e-14 to 1e-4.
    workers, executor, study, progress
        As of one disc.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        The same as of one disc, but for ``trapping``, ``confirmed`` and ``lifetime``. On
        ``(attractor, contact)``: ``amplitude``, ``phase_lag``, ``radius_min``, ``radius_max``,
        ``largest_force`` and ``touched``; on ``(attractor, node)``: ``node_amplitude``,
        ``node_phase_lag``, ``node_radius_min`` and ``node_radius_max``; on ``component``
        ``final_state``, from which `simulate` or `limit_cycle` goes on: one attractor is a start.

    Notes
    -----
    A node that is pulled aside and let go takes the rotor with it: the displacement of the `start`
    changes by the static deflection under a force at the node, the shape with the least elastic
    energy. Where motions cost none, as those of a rotor without supports, it is the shape of these
    that moves the least mass. The velocity changes as by a blow at the node, the change with the
    least kinetic energy. Stators and races start as they do in `start`. Contacts do not change
    these shapes, so that another node may start beyond its clearance.

    Every start is followed as by `sweep`. Two motions are on one attractor if they are of one kind,
    and period, radii and, at whole revolutions, state agree to a part of 1e-5; on turning axes, of
    an axisymmetric system, period and radii decide. All contact-free motions count as one
    attractor, as do all chaotic ones, all tori, and all rolling motions without a period of the
    same contacts. Only attractors that starts end on are listed.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=1.5, shaft_stiffness=0.1).system()
    >>> found = basin_system(system, speed=0.7, node="disc", x=[-1.0, -0.5], y=[-1.5, -1.0])
    >>> found.label.values.tolist(), found.amplitude.values.ravel().round(3).tolist()
    ([[0, 1], [0, 0]], [2.735, 1.183])
    """
    plane = Plane.of(x=x, y=y, vx=vx, vy=vy)
    system = changed_system(basin_system, system, changed)
    result = _labelled(
        system, plane, "basin", speed, node, start, modes, rtol=rtol, workers=workers,
        executor=executor, study=study, progress=progress,
    )  # fmt: skip
    return with_system_units(basin_dataset(plane, result), system)


@shows_progress
def basin_fractions_system(
    system: RotorSystem,
    *,
    speed: float,
    node: str,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    starts: int = 1000,
    seed: int = 0,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute basin fractions of a rotor system: random states of one node in a box.

    Parameters
    ----------
    system : RotorSystem
        The rotor. It must have a contact, and be damped.
    x, y, vx, vy : float or array_like, shape (2,)
        Displacement and velocity of the node at time 0: numbers, or ranges ``(low, high)``.
    starts, seed : int
        As of one disc.
    speed, node, start, modes, rtol, workers, executor, study, progress
        As for `basin`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        On ``attractor`` the variables of `basin` of a rotor system; on ``response`` those of one
        disc.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=1.5, shaft_stiffness=0.1).system()
    >>> found = basin_fractions_system(
    ...     system, speed=0.7, node="disc", x=(-1.5, 0), y=(-2, -1), starts=8)
    >>> found["count"].values
    array([6, 2])
    """
    box = Box.of(starts, seed, x=x, y=y, vx=vx, vy=vy)
    system = changed_system(basin_fractions_system, system, changed)
    result = _labelled(
        system, box, "basin_fractions", speed, node, start, modes, rtol=rtol, workers=workers,
        executor=executor, study=study, progress=progress,
    )  # fmt: skip
    return with_system_units(fractions_dataset(box, result), system)


def _labelled(
    system: RotorSystem,
    asked: Plane | Box,
    verb: str,
    speed: object,
    node: str,
    start: Start | xr.Dataset,
    modes: int | None,
    *,
    rtol: object,
    workers: int | None,
    executor: str,
    study: Folder | None,
    progress: Progress | bool | None,
) -> Labelled:
    """Follow the starts of a node of a system, each to its attractor."""
    omega = check_real("speed", speed)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    progress, chosen = check_progress(progress), choose(executor, workers, compiled=True)
    check_number_of_starts(asked.count, study)
    if modes is not None and isinstance(start, xr.Dataset):
        raise InputError(f"start must be (q, velocity) with modes, got a result and {modes!r}")
    start = state_at_end(assemble(system), start)
    question = Question(verb, {
        "rotor": system, "speed": omega, "node": node, **asked.given, "start": start,
        "modes": modes, "rtol": tolerance,
    })  # fmt: skip
    reduced, begun = in_modes(system, modes, start)
    knocked = KnockedSystem.at(_problem(reduced, omega, tolerance), omega, node, begun)
    with open_results(study, question.design(), asked.count, FORM) as kept:
        found = follow_starts_of_system(
            knocked, asked.starts, asked.count, kept,
            workers=chosen.number, executor=chosen.executor, progress=progress,
        )  # fmt: skip
        return _with_attractors(found, reduced, node, question, kept.folder)


def _with_attractors(
    found: FollowedSystem, system: RotorSystem, node: str, question: Question, folder: Path | None
) -> Labelled:
    """Return followed starts with what is known of their attractors."""
    impossible, words = {"failed", "not_found", "touching"}, by_number(RESPONSE)
    if not any(each.friction > 0.0 for each in system.contacts):
        impossible.add("rolling")
    along = {**dict.fromkeys((*OF_CONTACT, "touched"), ("attractor", "contact")),
             **dict.fromkeys(OF_NODE, ("attractor", "node")), "period": ("attractor",),
             "final_state": ("attractor", "component")}  # fmt: skip
    rtol = float(question.arguments["rtol"])
    return Labelled(
        subject="Rotor system", labels=found.labels, times=found.times,
        kinds=[words[number] for number in found.rows["response"].tolist()],
        columns={name: (dims, found.rows[name]) for name, dims in along.items()},
        rechecked=found.rechecked, ended=found.ended, impossible=impossible,
        how={"labelling": LABELLING, "labelling_method": "taylor", "labelling_rtol": rtol,
             "agreement_rtol": tighter_than(rtol)},
        given={"knocked_node": node},
        coordinates=_coordinates(system, float(question.arguments["speed"])),
        folder=folder, question=question,
    )  # fmt: skip


def _problem(system: RotorSystem, speed: float, rtol: float) -> SettlingProblem:
    """Return the problem of a system that turns, touches and settles."""
    if speed == 0.0:
        raise InputError("speed must not be 0 for a basin of a rotor system, got 0.0")
    if not system.contacts:
        raise InputError("contacts must be at least one for a basin of a rotor system, got none")
    problem = SettlingProblem.of(assemble(system), rtol)
    if not problem.has_damping:
        raise InputError(
            "damping must be above 0 for a basin: without damping there are no attractors, got none"
        )
    check_slowest(problem, np.array([speed]))
    return problem


def _coordinates(system: RotorSystem, speed: float) -> dict[str, Column]:
    """Return the speed, the nodes, and the contacts with their circles."""
    contacts = system.contacts
    stators = [
        each.stator if isinstance(each.stator, str) else "" if each.stator is None else "stator"
        for each in contacts
    ]
    found: dict[str, Column] = {
        "speed": ((), speed),
        "node": ("node", np.array(list(system.nodes), str)),
        "contact_node": ("contact", np.array([each.node for each in contacts], str)),
        "contact_stator": ("contact", np.array(stators, str)),
        "clearance": ("contact", np.array([each.clearance for each in contacts])),
        "centre_x": ("contact", np.array([each.centre[0] for each in contacts])),
        "centre_y": ("contact", np.array([each.centre[1] for each in contacts])),
    }
    if system.positions is not None:
        found["axial_position"] = ("node", np.array(list(system.positions.values())))
    return found
