"""What is in the file of a rotor system or a result: read, changed as the page asks, and run."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import OF_CONTACT, SystemQuestion
from rotor_ida.explorer.motion import (
    samples_per_revolution,
)
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Support
from rotor_ida.results.archive import load
from rotor_ida.results.archived_system import problem_of
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.question import Question as Asked
from rotor_ida.results.system_file import Course, read_system_file
from rotor_ida.simulation.run_up import run_up
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.drop import drop
from rotor_ida.texts import brief, in_python
from rotor_ida.units import written

# Kinds of results that are played.
PLAYED = ("system_run", "drop")
# Panels of a run, those of its run-up, and those that need a speed which is held.
PANELS = ("response", "sketch", "shape", "orbit", "turning", "history", "campbell")
OF_RUN_UP = ("bode", "polar", "cascade")
OF_ONE_SPEED = ("section", "full")
KINDS_OF_SCALES = ("length", "time", "velocity", "force", "energy", "rate")
# Samples that are sent of an archive.
MOST_SAMPLES = 16_384
# Range of speeds over that of the file, and revolutions of a run-up that the file does not give.
LOW, HIGH, TURNS = 0.1, 1.5, 300


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A system, changed as the page asks, and how it moves; of an archive, its run too.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    speed : float
        Running speed.
    course : Course, optional
        How it moves, if it is from a system file.
    run : Dataset, optional
        The run of an archive.
    """

    system: RotorSystem
    speed: float
    course: Course | None = None
    run: xr.Dataset | None = None

    @property
    def drops(self) -> bool:
        """Whether the file describes a drop."""
        return self.course is not None and "duration" in self.course.fall

    @property
    def changes_speed(self) -> bool:
        """Whether it is an archived run at a speed that changes, and no drop."""
        return self.run is not None and "speed" in self.run and not is_drop(self)

    @property
    def panels(self) -> tuple[str, ...]:
        """The panels that say something of it."""
        if is_drop(self) or self.drops:
            return PANELS
        if self.changes_speed:
            return (*PANELS, *OF_RUN_UP)
        return (*PANELS, *OF_ONE_SPEED, *(() if self.run is not None else OF_RUN_UP))

    @property
    def levitated(self) -> RotorSystem:
        """The system with its magnetic bearings, of a drop with those before it.

        It carries no constant force: linear motions and whirls have none.
        """
        supports = self.system.supports
        if self.run is not None and "support_fails" in self.run:
            failed = self.run.isel(support=self.run["support_fails"].values == 1)
            supports = [
                Support(node=str(each["support_node"].values),
                        stiffness=tuple(each["support_stiffness"].values.tolist()),
                        damping=tuple(each["support_damping"].values.tolist()))
                for each in (failed.isel(support=i) for i in range(failed.sizes["support"]))
            ]  # fmt: skip
        return replace(self.system, supports=supports, gravity=None, static_force=None)


def case_of(question: SystemQuestion) -> Case:
    """Return the case of a question, from its file and its changes."""
    if question.path is None:
        raise InputError("a system file or an archive of one must be given: drop it on the page")
    found = case_in(question.path)
    contacts = list(found.system.contacts)
    changes: dict[str, Any] = dict(question.changes)
    factor = changes.pop("unbalance_factor", 1.0)
    if changes:
        if question.contact >= len(contacts):
            raise InputError(f"contact must be below {len(contacts)}, got {question.contact}")
        of_file = {OF_CONTACT[name]: value for name, value in changes.items()}
        contacts[question.contact] = replace(contacts[question.contact], **of_file)
    unbalance = [replace(each, moment=factor * each.moment) for each in found.system.unbalance]
    speed = found.speed if question.speed is None else question.speed
    system = replace(found.system, contacts=contacts, unbalance=unbalance)
    return replace(found, system=system, speed=speed)


def case_in(path: Path) -> Case:
    """Return the case of a file, whose folder is of no interest, or a temporary one."""
    with named(path):
        return _read(path, path.stat().st_mtime_ns)


def archive_of(question: SystemQuestion) -> xr.Dataset | None:
    """Return the result in the file of a question, if it is an archive."""
    path = question.path
    if path is None or path.suffix.lower() == ".toml":
        return None
    with named(path):
        return archived_in(path, path.stat().st_mtime_ns)


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Tell a file by its name alone in errors."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error).replace(f"{path.parent}{os.sep}", "")) from error


@lru_cache(maxsize=2)
def _read(path: Path, _changed: int) -> Case:
    """Return the case of a file; a newer version of the file is read again."""
    if path.suffix.lower() == ".toml":
        system, course = read_system_file(path)
        speed = course.speed if course.speed is not None else course.run_up.get("to")
        if speed is None:
            raise InputError(f"{path.name}: speed must be given")
        return Case(system=system, speed=speed, course=course)
    run = archived_in(path, path.stat().st_mtime_ns)
    fastest = float(run["speed"].max()) if "speed" in run else float(run.attrs["speed"])
    return Case(system=problem_of(run)[0], speed=fastest, run=run)


def loaded(path: Path) -> xr.Dataset:
    """Return the result in an archive."""
    try:
        return load(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path.name}: {error}") from error


@lru_cache(maxsize=2)
def archived_in(path: Path, _changed: int) -> xr.Dataset:
    """Return the result in an archive; a newer version of the file is read again."""
    return loaded(path)


@lru_cache(maxsize=2)
def _computed(question: SystemQuestion, _changed: int) -> xr.Dataset:
    """Return the run of a question; the last ones are kept, since another node needs the same."""
    case = case_of(question)
    if case.run is not None:
        return case.run.isel(t=slice(None, None, math.ceil(case.run.sizes["t"] / MOST_SAMPLES)))
    assert case.course is not None
    if case.drops:
        return drop(case.system, **case.course.drop | {"speed": case.speed})
    return simulate(case.system, **case.course.motion, **_length(case, question.revolutions))


def _length(case: Case, revolutions: int) -> dict[str, Any]:
    """Return speed, duration and samples of a run of some revolutions."""
    if not case.speed > 0.0:
        raise InputError(f"speed must be positive, got {case.speed!r}")
    samples = samples_per_revolution(revolutions) * revolutions + 1
    return {
        "speed": case.speed, "duration": 2.0 * math.pi * revolutions / case.speed,
        "samples": samples,
    }  # fmt: skip


def run_of(question: SystemQuestion) -> xr.Dataset:
    """Return the run that a question is about: of its archive, or computed."""
    archived = archive_of(question)
    if archived is not None and kind_of(archived) not in PLAYED:
        return archived
    case_of(question)  # without a file there is none
    return _computed(*of_any_node(question))


def of_any_node(question: SystemQuestion) -> tuple[SystemQuestion, int]:
    """Return the question whose answer holds for all nodes, and when its file was changed."""
    same = replace(question, about="motion", number=0, side=0, node="", contact=_changed(question))
    return same, 0 if question.path is None else question.path.stat().st_mtime_ns


def _changed(question: SystemQuestion) -> int:
    """Return the number of the contact that is changed; without changes all are the same."""
    return question.contact if any(name in OF_CONTACT for name, _ in question.changes) else 0


class Seat(NamedTuple):
    """Where the motion is shown: at a node, relative to the stator of a contact if it has one."""

    node: str
    contact: int | None


def seat_of(case: Case, question: SystemQuestion) -> Seat:
    """Return the node of a question, or else that of its contact, and the contact there."""
    nodes, contacts = list(case.system.nodes), case.system.contacts
    if question.node and question.node not in nodes:
        raise InputError(f"node must be one of {', '.join(nodes)}, got {shown(question.node)}")
    chosen = contacts[question.contact] if question.contact < len(contacts) else None
    node = question.node or (chosen.node if chosen else nodes[0])
    if chosen and chosen.node == node:
        return Seat(node, question.contact)
    return Seat(node, next((i for i, each in enumerate(contacts) if each.node == node), None))


def scales_in(system: RotorSystem) -> dict[str, float]:
    """Return the scales of a system, which are 1 in SI units."""
    return dict.fromkeys(KINDS_OF_SCALES, 1.0) if system.units == "SI" else {}


def is_drop(case: Case) -> bool:
    """Return whether an archived drop is played."""
    return case.run is not None and kind_of(case.run) == "drop"


@lru_cache(maxsize=2)
def run_up_of(question: SystemQuestion, _changed: int) -> xr.Dataset:
    """Return the run-up of the file, or else one over the speeds shown."""
    case = case_of(question)
    assert case.course is not None
    change = case.course.run_up
    if not change.keys() - {"speed"}:  # the file has no run-up
        time = 2.0 * math.pi * TURNS / (0.5 * (LOW + HIGH) * case.speed)
        change = {"speed": LOW * case.speed, "to": HIGH * case.speed, "ramp_time": time}
    return run_up(case.system, **case.course.motion, **change)


def lines_of(question: SystemQuestion) -> str:
    """Return the Python lines that compute the run shown, or load a result."""
    path = question.path
    if path is not None and archive_of(question) is not None:
        return f"from rotor_ida import load\n\nresult = load({in_python(path.name)})\n"
    case = case_of(question)
    assert path is not None
    verb, path_said = "drop" if case.drops else "simulate", in_python(path.name)
    lines = [
        f"from rotor_ida import {verb}, load_course, load_system", "",
        f"system, course = load_system({path_said}), load_course({path_said})",
    ]  # fmt: skip
    changes = dict(question.changes)
    factor = changes.pop("unbalance_factor", 1.0)
    changed = []
    if changes:
        words = ", ".join(f"{OF_CONTACT[name]}={value!r}" for name, value in changes.items())
        number = question.contact
        lines += ["contacts = list(system.contacts)",
                  f"contacts[{number}] = replace(contacts[{number}], {words})"]  # fmt: skip
        changed.append("contacts=contacts")
    if factor != 1.0:
        lines += [
            f"unbalance = [replace(each, moment={factor!r} * each.moment)"
            " for each in system.unbalance]"
        ]
        changed.append("unbalance=unbalance")
    if changed:
        lines = ["from dataclasses import replace", "", *lines,
                 f"system = replace(system, {', '.join(changed)})"]  # fmt: skip
    told: dict[str, object] = {"rotor": path}
    others = f'**course.drop | {{"speed": {case.speed!r}}}' if case.drops else "**course.motion"
    if not case.drops:
        told |= _length(case, question.revolutions)
    call = Asked(verb, told).python("system", others)
    return "\n".join([*lines, f"run = {call}"]) + "\n"


def command_of(question: SystemQuestion) -> str:
    """Return the command for the run shown, after what must be changed in the file first.

    Numbers of a system in SI units have the units of the page.
    """
    path = question.path
    if path is not None and archive_of(question) is not None:
        return Asked("show", {"rotor": Path(path.name)}).command()
    case = case_of(question)
    assert path is not None

    def told(value: float, unit: str) -> str:
        return written(value, unit) if case.system.units == "SI" and unit else repr(value)

    changes = dict(question.changes)
    factor = changes.pop("unbalance_factor", 1.0)
    first = []
    for changed, value in changes.items():
        name = OF_CONTACT[changed]
        number = told(value, _unit(name, case.system.contacts[question.contact]))
        quoted = number if number == repr(value) else f'"{number}"'
        first.append(f"set {name} = {quoted} in contact {question.contact}")
    first += [f"multiply each moment of the unbalance by {factor!r}"] if factor != 1.0 else []
    said = f"# first, in {brief(path.name)}: {'; '.join(first)}\n" if first else ""
    asked: dict[str, object] = {"rotor": Path(path.name), "speed": told(case.speed, "rpm")}
    if case.drops:
        return said + Asked("drop", {**asked, "out": "report"}).command()
    length = _length(case, question.revolutions)
    asked |= {"duration": told(length["duration"], "s"), "samples": length["samples"]}
    return said + Asked("simulate", {**asked, "out": "run.nc", "figure": "run"}).command()


def _unit(name: str, contact: Contact) -> str:
    """Return the unit in which a system file gives a number of a contact; empty if it has none."""
    stiffness = "N/m" if contact.exponent == 1.0 else "N/m^1.5"
    return {"clearance": "um", "stiffness": stiffness, "damping": "s/m"}.get(name, "")


def check_played(result: xr.Dataset) -> None:
    """Raise `InputError` unless a page without a program can show a result."""
    if kind_of(result) not in PLAYED:
        raise InputError(f"html must be of a rotor or its run, got a result of {kind_of(result)}")
