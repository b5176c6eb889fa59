"""Basins of attraction of a rotor system, over the states of one of its nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
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
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.parallel import Progress, choose
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder, open_results
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import RESPONSE, by_number
from rotor_ida.simulation.runs import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.simulation.starts import Start, state_at_end
from rotor_ida.simulation.systems.flow import SettlingProblem
from rotor_ida.steady.system_sweep import OF_CONTACT, OF_NODE, check_slowest

# Tolerance of the runs by default.
RTOL = 1e-10
LABELLING = (
    "every start followed separately by Taylor series, as in a sweep with labelling_rtol; motions "
    "matched by kind, period, radii and state; some starts labelled again with agreement_rtol"
)


def basin_of_system(system: RotorSystem, asked: Plane | Box, verb: str, **given: Any) -> xr.Dataset:
    """Return the basins of a rotor system on a plane, or fractions in a box, of a node's states."""
    result = _labelled(system, asked, verb, **given)
    found = (
        basin_dataset(asked, result)
        if isinstance(asked, Plane)
        else fractions_dataset(asked, result)
    )
    return with_system_units(found, system)


def _labelled(
    system: RotorSystem,
    asked: Plane | Box,
    verb: str,
    *,
    speed: object,
    node: str,
    start: Start | xr.Dataset,
    modes: int | None,
    rtol: float | None,
    workers: int | None,
    executor: str,
    study: Folder | None,
    progress: Progress | bool | None,
) -> Labelled:
    """Follow the starts of a node of a system, each to its attractor."""
    omega = check_real("speed", speed)
    tolerance = check_between("rtol", RTOL if rtol is None else rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
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
