"""Panels of a rotor system from a file: its run or drop, exact whirls, Campbell, and run-up."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays
from rotor_ida.checks import shown
from rotor_ida.closed_forms.campbell import campbell
from rotor_ida.closed_forms.whirls.special_speeds import special_speeds
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.explorer.measured import cascade_rows, full_lines, order_rows, unless_impossible
from rotor_ida.explorer.messages import Answer
from rotor_ida.explorer.system_questions import (
    OF_CONTACT,
    SYSTEM_RUNS,
    SystemQuestion,
    SystemUpload,
)
from rotor_ida.explorer.system_touches import bands_in_words, clear_whirl, why_without_whirls
from rotor_ida.explorer.system_verdicts import touched_on_the_way, verdict
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.data_sheet import GRAVITY
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Support
from rotor_ida.results.archive import load
from rotor_ida.results.archived_system import problem_of
from rotor_ida.results.kinds import kind_of
from rotor_ida.results.question import Question
from rotor_ida.results.system_file import Course, read_system_file
from rotor_ida.schema import SPECIAL, STABILITY
from rotor_ida.signals.nodes import at_node
from rotor_ida.signals.record import record_of
from rotor_ida.simulation.run_up import run_up
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.drop import drop
from rotor_ida.texts import brief, in_python
from rotor_ida.units import written

# Samples that are sent of a run, and speeds of the exact response and of the Campbell diagram.
MOST_SAMPLES, SPEEDS, FEW_SPEEDS = 6000, 160, 60
# Eigenvalues of a Campbell diagram.
MOST_EIGENVALUES = 16
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
    found = _case_in(question.path)
    contacts = list(found.system.contacts)
    changes: dict[str, Any] = dict(question.changes)
    factor = changes.pop("unbalance_factor", 1.0)
    if changes:
        if question.contact >= len(contacts):
            raise InputError(f"contact must be below {len(contacts)}, got {question.contact}")
        contacts[question.contact] = replace(contacts[question.contact], **changes)
    unbalance = [replace(each, moment=factor * each.moment) for each in found.system.unbalance]
    speed = found.speed if question.speed is None else question.speed
    system = replace(found.system, contacts=contacts, unbalance=unbalance)
    return replace(found, system=system, speed=speed)


def _case_in(path: Path) -> Case:
    """Return the case of a file, whose folder is of no interest, or a temporary one."""
    try:
        return _read(path, path.stat().st_mtime_ns)
    except InputError as error:
        raise InputError(str(error).replace(f"{path.parent}{os.sep}", "")) from error


def show_opened_file(upload: SystemUpload) -> Iterator[Answer]:
    """Yield the name of a file that can be shown."""
    assert upload.path is not None
    _case_in(upload.path)
    yield Answer("system_file", {"name": upload.name})


@lru_cache(maxsize=2)
def _read(path: Path, _changed: int) -> Case:
    """Return the case of a file; a newer version of the file is read again."""
    if path.suffix.lower() == ".toml":
        system, course = read_system_file(path)
        speed = course.speed if course.speed is not None else course.run_up.get("to")
        if speed is None:
            raise InputError(f"{path.name}: speed must be given")
        return Case(system=system, speed=speed, course=course)
    try:
        run = load(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path.name}: {error}") from error
    if kind_of(run) not in SYSTEM_RUNS:
        raise InputError(
            f"{path.name}: a run or a drop of a rotor system must be given, got {kind_of(run)!r}"
        )
    fastest = float(run["speed"].max()) if "speed" in run else float(run.attrs["speed"])
    return Case(system=problem_of(run)[0], speed=fastest, run=run)


@lru_cache(maxsize=2)
def _computed(question: SystemQuestion, _changed: int) -> xr.Dataset:
    """Return the run of a question; the last ones are kept, since another node needs the same."""
    case = case_of(question)
    if case.run is not None:
        return case.run
    assert case.course is not None
    if case.drops:
        return drop(case.system, **case.course.drop | {"speed": case.speed})
    return simulate(case.system, **case.course.motion, speed=case.speed,
                    duration=_duration(case, question.revolutions))  # fmt: skip


def _duration(case: Case, revolutions: int) -> float:
    if not case.speed > 0.0:
        raise InputError(f"speed must be positive, got {case.speed!r}")
    return 2.0 * math.pi * revolutions / case.speed


def run_of_system(question: SystemQuestion) -> xr.Dataset:
    """Return the run that a question is about: of its archive, or computed."""
    case_of(question)  # without a file there is none
    assert question.path is not None
    return _computed(*_of_any_node(question))


def _of_any_node(question: SystemQuestion) -> tuple[SystemQuestion, int]:
    """Return the question whose answer holds for all nodes, and when its file was changed."""
    same = replace(question, about="system_run", number=0, node="")
    return same, 0 if question.path is None else question.path.stat().st_mtime_ns


def show_system_run(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the sketch of the rotor, then its run."""
    case = case_of(question)
    yield Answer("sketch", _sketch(case, question))
    run = run_of_system(question)
    node = node_of(case, question)
    every = slice(None, None, math.ceil(run.sizes["t"] / MOST_SAMPLES))
    names = ("x", "y", "contact_x", "contact_y", "normal_force", "tangential_force")
    arrays: Arrays = {"t": run["t"].values[every]}
    arrays |= {name: np.ascontiguousarray(run[name].values[every].T).ravel() for name in names}
    if "speed" in run:
        arrays["speed"] = run["speed"].values[every]
    arrays["peak_time"], arrays["peak_force"] = run["peak_time"].values, run["peak_force"].values
    arrays["peak_contact"] = run["episode_contact"].values.astype(float)
    notes = _notes_of(case)
    signals = at_node(run, node)
    arrays |= unless_impossible(full_lines, signals, record_of(signals), notes)
    facts = {
        "node": node, "speed": case.speed, "notes": notes, "verdict": verdict(run),
        "bands": _bands(*_of_any_node(question)),
        "drop": kind_of(run) == "drop", "python": lines_of(question),
        "command": command_of(question),
    }  # fmt: skip
    yield Answer("run", facts, arrays)


def _assembly(case: Case) -> Assembly:
    """Return the system with its stators and constant forces, in the modes of its file."""
    modes = None if case.course is None else case.course.modes
    return assemble(in_modes(case.system, modes, None)[0])


@lru_cache(maxsize=2)
def _bands(question: SystemQuestion, _changed: int) -> str:
    """Return at which speeds the rotor would touch, in a sentence; empty where that is not known.

    Before a drop the rotor levitates: what holds it then is not in the system.
    """
    case = case_of(question)
    if (
        case.drops
        or (case.run is not None and kind_of(case.run) == "drop")
        or (not case.system.contacts)
    ):
        return ""
    try:
        return bands_in_words(_assembly(case), np.linspace(0.0, HIGH * case.speed, SPEEDS)[1:])
    except InputError:  # nothing holds it, or a resonance is not damped
        return ""


def node_of(case: Case, question: SystemQuestion) -> str:
    """Return the node of a question: its own, or else that of the first contact."""
    nodes = list(case.system.nodes)
    if question.node and question.node not in nodes:
        raise InputError(f"node must be one of {', '.join(nodes)}, got {shown(question.node)}")
    contacts = case.system.contacts
    return question.node or (contacts[0].node if contacts else nodes[0])


def _sketch(case: Case, question: SystemQuestion) -> dict[str, object]:
    """Return what a sketch of the rotor shows, and where sliders start."""
    places = case.system.positions or {n: float(i) for i, n in enumerate(case.system.nodes)}
    contacts = [
        {"node": each.node, "centre": each.centre, "on_stator": each.stator is not None}
        | {name: getattr(each, name) for name in OF_CONTACT}
        for each in case.system.contacts
    ]
    file = _read(question.path, question.path.stat().st_mtime_ns) if question.path else case
    return {
        "nodes": list(places), "positions": list(places.values()),
        "has_positions": case.system.positions is not None, "units": case.system.units,
        "contacts": contacts, "supports": [each.node for each in case.system.supports],
        "masses": [_mass(case.system, node) for node in case.system.nodes],
        "unbalance": [each.node for each in case.system.unbalance], "node": node_of(case, question),
        "speed": case.speed, "file_speed": file.speed, "is_archive": case.run is not None,
        "is_drop": case.drops,
        "from_file": [
            {name: getattr(each, name) for name in OF_CONTACT} | {"rubs": each.radius is not None}
            for each in file.system.contacts
        ],
    }  # fmt: skip


def _mass(system: RotorSystem, node: str) -> float:
    """Return the mass that moves with a node where all others rest."""
    row = system.rows(node)[0]
    return float(row @ system.mass @ row)


def show_system_map(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the exact whirls over the speed, then the Campbell diagram."""
    case = case_of(question)
    node = node_of(case, question)
    place = list(case.system.nodes).index(node)
    facts: dict[str, object] = {"node": node, "notes": _left_out(case)}
    arrays: Arrays = {}
    try:
        whirls, points = _whirls(*_of_any_node(question))
        arrays |= _branches(whirls, place)
        if points is not None:
            kinds = {number: word for word, number in SPECIAL.items()}
            facts["kinds"] = [kinds[int(each)] for each in points["special_kind"].values]
            arrays["special_speed"] = points["special_speed"].values
    except InputError as error:
        facts["notes"], arrays = _without_contact(case, place, error)
        facts["free"] = bool(arrays)
    yield Answer("map", facts, arrays)
    yield _campbell(case)


def _without_contact(case: Case, place: int, error: InputError) -> tuple[list[str], Arrays]:
    """Return the whirl without contact at a node, and why the exact whirls are not drawn."""
    assembly, speeds = _assembly(case), np.linspace(LOW * case.speed, HIGH * case.speed, SPEEDS)
    why = why_without_whirls(assembly, error)
    try:
        amplitude = clear_whirl(assembly, place, speeds)
    except InputError:
        return [f"not drawn, as {why}"], {}
    stability = np.where(np.isnan(amplitude), STABILITY["absent"], STABILITY["stable"])
    return [f"without whirls in contact, as {why}"], {
        "speed": speeds, "amplitude": amplitude, "stability": stability.astype(float)
    }  # fmt: skip


def _campbell(case: Case) -> Answer:
    """Return the Campbell diagram."""
    speeds = np.linspace(LOW * case.speed, HIGH * case.speed, FEW_SPEEDS)
    try:
        found = campbell(
            case.levitated, speed=speeds, modes=min(MOST_EIGENVALUES, case.system.size)
        ).isel(contact_stiffness=0)  # fmt: skip
    except InputError as error:
        return Answer("campbell", {"notes": [str(error)]})
    rates = found["whirl_speed"].transpose("eigenvalue", "speed").values
    damping = found["damping_ratio"].transpose("eigenvalue", "speed").values
    return Answer("campbell", {"notes": _levitation(case) + _notes_of(case)}, {
        "speed": found["speed"].values, "whirl_speed": rates.ravel(), "damping": damping.ravel(),
    })  # fmt: skip


@lru_cache(maxsize=2)
def _whirls(question: SystemQuestion, _changed: int) -> tuple[xr.Dataset, xr.Dataset | None]:
    """Return the exact whirls at all nodes over the speed, and their special speeds."""
    case = case_of(question)
    system = case.levitated
    low, high = LOW * case.speed, HIGH * case.speed
    whirls = whirls_of_system(system, np.linspace(low, high, SPEEDS))
    points = None
    if system.contacts:
        points = special_speeds(system, limits=(low, high))
    return whirls, points


def _left_out(case: Case) -> list[str]:
    """Return notes on what acts in the run but not on the exact whirls, and the reverse."""
    forces: list[Any] = [case.system.static_force, case.system.gravity]
    if case.drops and case.system.gravity is None and case.system.units == "SI":
        forces.append(GRAVITY)  # a drop's default
    acts = any(each is not None and np.any(each) for each in forces)
    told = ["without gravity and static forces"] if acts else []
    return told + _levitation(case) + _notes_of(case)


def _levitation(case: Case) -> list[str]:
    """Return a note on the magnetic bearings of a drop, which its run lacks."""
    if case.drops or (case.run is not None and kind_of(case.run) == "drop"):
        return ["with the magnetic bearings, as before the drop"]
    return []


def _notes_of(case: Case) -> list[str]:
    return [case.system.note] if case.system.note else []


def _branches(whirls: xr.Dataset, place: int) -> Arrays:
    """Return amplitude and stability of the whirls at a node, by branch."""
    amplitude = whirls["node_amplitude"].isel(node=place).transpose("branch", "speed").values
    stability = whirls["stability"].transpose("branch", "speed").values.astype(float)
    return {
        "speed": whirls["speed"].values,
        "amplitude": np.ascontiguousarray(amplitude).ravel(),
        "stability": np.ascontiguousarray(stability).ravel(),
    }


def show_system_run_up(question: SystemQuestion) -> Iterator[Answer]:
    """Yield order 1 and the cascade of a run-up at the chosen node."""
    case = case_of(question)
    if case.run is not None or case.drops:  # the page has no panel of a run-up then
        yield Answer("run_up", {"notes": []})
        return
    run = _run_up(*_of_any_node(question))
    signals = at_node(run, node_of(case, question))
    notes = _notes_of(case)
    record = record_of(signals)
    arrays = unless_impossible(order_rows, signals, record, notes)
    arrays |= unless_impossible(cascade_rows, signals, record, notes)
    facts: dict[str, object] = {
        "notes": notes, "node": node_of(case, question),
        "touches": touched_on_the_way(run) if case.system.contacts else "",
    }  # fmt: skip
    yield Answer("run_up", facts, arrays)


@lru_cache(maxsize=2)
def _run_up(question: SystemQuestion, _changed: int) -> xr.Dataset:
    """Return the run-up of the file, or else one over the speeds shown."""
    case = case_of(question)
    assert case.course is not None
    change = case.course.run_up
    if not change.keys() - {"speed"}:  # the file has no run-up
        time = 2.0 * math.pi * TURNS / (0.5 * (LOW + HIGH) * case.speed)
        change = {"speed": LOW * case.speed, "to": HIGH * case.speed, "ramp_time": time}
    return run_up(case.system, **case.course.motion, **change)


def lines_of(question: SystemQuestion) -> str:
    """Return the Python lines that compute the run shown."""
    case, path = case_of(question), question.path
    assert path is not None
    if case.run is not None:
        return f"from rotor_ida import load\n\nrun = load({in_python(path.name)})\n"
    verb, path_said = "drop" if case.drops else "simulate", in_python(path.name)
    lines = [
        f"from rotor_ida import {verb}, load_course, load_system", "",
        f"system, course = load_system({path_said}), load_course({path_said})",
    ]  # fmt: skip
    changes = dict(question.changes)
    factor = changes.pop("unbalance_factor", 1.0)
    changed = []
    if changes:
        words = ", ".join(f"{name}={value!r}" for name, value in changes.items())
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
        told |= {"speed": case.speed, "duration": _duration(case, question.revolutions)}
    call = Question(verb, told).python("system", others)
    return "\n".join([*lines, f"run = {call}"]) + "\n"


def command_of(question: SystemQuestion) -> str:
    """Return the command for the run shown, after what must be changed in the file first.

    Numbers of a system in SI units have the units of the page.
    """
    case, path = case_of(question), question.path
    assert path is not None
    if case.run is not None:
        return Question("show", {"rotor": Path(path.name)}).command()

    def told(value: float, unit: str) -> str:
        return written(value, unit) if case.system.units == "SI" and unit else repr(value)

    changes = dict(question.changes)
    factor = changes.pop("unbalance_factor", 1.0)
    first = []
    for name, value in changes.items():
        number = told(value, _unit(name, case.system.contacts[question.contact]))
        quoted = number if number == repr(value) else f'"{number}"'
        first.append(f"set {name} = {quoted} in contact {question.contact}")
    first += [f"multiply each moment of the unbalance by {factor!r}"] if factor != 1.0 else []
    said = f"# first, in {brief(path.name)}: {'; '.join(first)}\n" if first else ""
    asked: dict[str, object] = {"rotor": Path(path.name), "speed": told(case.speed, "rpm")}
    if case.drops:
        return said + Question("drop", {**asked, "out": "report"}).command()
    asked["duration"] = told(_duration(case, question.revolutions), "s")
    return said + Question("simulate", {**asked, "out": "run.nc", "figure": "run"}).command()


def _unit(name: str, contact: Contact) -> str:
    """Return the unit in which a system file gives a number of a contact; empty if it has none."""
    stiffness = "N/m" if contact.exponent == 1.0 else "N/m^1.5"
    return {"clearance": "um", "stiffness": stiffness, "damping": "s/m"}.get(name, "")
