"""Basins of attraction of a rotor system, over the states of one of its nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.basins.dataset import Labelled, basin_dataset, fractions_dataset
from rotor_ida.basins.starts import Box, Plane, check_number_of_starts
from rotor_ida.basins.system_labels import (
    FORM,
    FollowedSystem,
    follow_starts_of_system,
    how_labelled,
)
from rotor_ida.basins.system_starts import knocked_systems, one_speed
from rotor_ida.checks import check_progress
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, choose
from rotor_ida.results.question import Question
from rotor_ida.results.si_units import with_system_units
from rotor_ida.results.studies.results import Folder, open_results
from rotor_ida.schema import RESPONSE, by_number
from rotor_ida.simulation.starts import Start
from rotor_ida.steady.system_sweep import OF_CONTACT, OF_NODE


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
    asked_of = Varied({SPEED: one_speed(speed)}, system)
    varied, (knocked,) = knocked_systems(asked_of, node, start, modes, rtol)
    progress, chosen = check_progress(progress), choose(executor, workers, compiled=True)
    check_number_of_starts(asked.count, study)
    question = Question(verb, {
        "rotor": system, "speed": knocked.speed, "node": node, **asked.given,
        "start": varied.kept[0], "modes": modes, "rtol": varied.rtol,
    })  # fmt: skip
    with open_results(study, question.design(), asked.count, FORM) as kept:
        found = follow_starts_of_system(
            knocked, asked.starts, asked.count, kept,
            workers=chosen.number, executor=chosen.executor, progress=progress,
        )  # fmt: skip
        return _with_attractors(found, varied.varied.base, node, question, kept.folder)


def _with_attractors(
    found: FollowedSystem, system: RotorSystem, node: str, question: Question, folder: Path | None
) -> Labelled:
    """Return followed starts with what is known of their attractors."""
    impossible, words = {"failed", "not_found"}, by_number(RESPONSE)
    if not any(each.friction > 0.0 for each in system.contacts):
        impossible.add("rolling")
    along = {**dict.fromkeys((*OF_CONTACT, "touched"), ("attractor", "contact")),
             **dict.fromkeys(OF_NODE, ("attractor", "node")), "period": ("attractor",),
             "final_state": ("attractor", "component")}  # fmt: skip
    return Labelled(
        subject="Rotor system", labels=found.labels, times=found.times,
        kinds=[words[number] for number in found.rows["response"].tolist()],
        columns={name: (dims, found.rows[name]) for name, dims in along.items()},
        rechecked=found.rechecked, ended=found.ended, impossible=impossible,
        how=how_labelled(float(question.arguments["rtol"])), given={"knocked_node": node},
        coordinates=coordinates_of(system, float(question.arguments["speed"])),
        folder=folder, question=question,
    )  # fmt: skip


def coordinates_of(system: RotorSystem, speed: float) -> dict[str, Column]:
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
