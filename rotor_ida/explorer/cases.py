"""The rotor of a question, of one disc or in a file, and a node of it as the panels see it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS, shown
from rotor_ida.errors import InputError
from rotor_ida.explorer.archives import (
    OF_RUN_UP,
    archived_in,
    scales_where,
)
from rotor_ida.explorer.endings import (
    MOST_SAMPLES,
    Values,
    ending,
    ending_of,
    forced,
    samples_per_revolution,
    states_of,
    values_of,
    whirls_per_revolution,
)
from rotor_ida.explorer.messages import OF_CONTACT, Answer, Question, named
from rotor_ida.explorer.system_verdicts import level_of, touched_on_the_way, verdict
from rotor_ida.model.data_sheet import GRAVITY
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Support
from rotor_ida.results.archived_system import system_of
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.question import Question as Asked
from rotor_ida.results.question import written as written_in_python
from rotor_ida.results.si_units import dimensional, scales_of
from rotor_ida.results.system_file import Course, read_system_file
from rotor_ida.signals.nodes import at_node
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.run_up import run_up
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.drop import drop
from rotor_ida.texts import brief
from rotor_ida.units import quantity, written

# Panels of a run, those of its run-up, and those that need a speed which is held.
PANELS = ("response", "sketch", "shape", "orbit", "turning", "history", "campbell")
OF_ONE_SPEED = ("section", "full")
# Range of speeds over that of the file, and revolutions of a run-up that the file does not give.
LOW, HIGH, TURNS = 0.1, 1.5, 300
METHOD: Method = "taylor"
# A disc that rolls on the stator may whirl many times in a revolution: samples per whirl for a
# smooth curve, and the largest number of samples in all.
PER_WHIRL, MOST_SAMPLES_OF_WHIRLS = 32, 65_536
LINES = '''\
"""The run that the explorer showed: its archive and its figure."""

from rotor_ida import {rotor}, save, simulate
from rotor_ida.plot import save_figure
from rotor_ida.plot.figures import figure_of

machine = {machine}
run = {call}
save(run, "run.nc", overwrite=True)
save_figure(figure_of(run), "run", overwrite=True)
'''


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
    shown : tuple of float, optional
        The range of speeds of the panels over the speed.
    """

    system: RotorSystem
    speed: float
    course: Course | None = None
    run: xr.Dataset | None = None
    shown: tuple[float, float] | None = None

    @property
    def speeds(self) -> tuple[float, float]:
        """The range of speeds of the panels over the speed."""
        return self.shown or (LOW * self.speed, HIGH * self.speed)

    @property
    def drops(self) -> bool:
        """Whether the file describes a drop, or the run is one."""
        if self.run is not None:
            return kind_of(self.run) == "drop"
        return self.course is not None and "duration" in self.course.fall

    @property
    def changes_speed(self) -> bool:
        """Whether it is an archived run at a speed that changes, and no drop."""
        return self.run is not None and "speed" in self.run and not self.drops

    @property
    def panels(self) -> tuple[str, ...]:
        """The panels that say something of it."""
        if self.drops:
            return PANELS
        if self.changes_speed:
            return (*PANELS, *OF_RUN_UP)
        return (*PANELS, *OF_ONE_SPEED, *(() if self.run is not None else OF_RUN_UP))

    @property
    def about(self) -> str:
        """In words what is shown."""
        what = "A drop, from its system file" if self.drops else "A system file"
        if self.run is not None:
            what = "Archive: what is played is in the file"
        counts = [f"{count} {word}{'' if count == 1 else 's'}" for count, word in (
            (len(self.system.nodes), "node"), (len(self.system.contacts), "contact"))]  # fmt: skip
        return f"{what}; {', '.join(counts)}."

    @property
    def notes(self) -> list[str]:
        """Notes on the linear motion: the magnetic bearings of a drop, which its run lacks."""
        told = ["with the magnetic bearings, as before the drop"] if self.drops else []
        return told + ([self.system.note] if self.system.note else [])

    @property
    def left_out(self) -> list[str]:
        """Notes on what acts in the run but not on the exact whirls, and the reverse."""
        forces: list[Any] = [self.system.static_force, self.system.gravity]
        if self.drops and self.run is None and forces[1] is None and self.system.units == "SI":
            forces.append(GRAVITY)  # a drop's default
        acts = any(each is not None and np.any(each) for each in forces)
        return [*(["without gravity and static forces"] if acts else []), *self.notes]

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


def case_of(question: Question) -> Case:
    """Return the case of a question: one disc, or what is in its file, with its changes."""
    if question.machine is not None:
        rotor = question.rotor
        return Case(system=rotor.system(), speed=rotor.omega, shown=question.speeds)
    if question.path is None:
        raise InputError("a system file or an archive of one must be given: drop it on the page")
    found = case_in(question.path)
    contacts = list(found.system.contacts)
    changes: dict[str, Any] = question.of_contact
    if changes:
        if question.contact >= len(contacts):
            raise InputError(f"contact must be below {len(contacts)}, got {question.contact}")
        contacts[question.contact] = replace(contacts[question.contact], **changes)
    factor, given = question.unbalance_factor, found.system.unbalance
    unbalance = [replace(each, moment=factor * each.moment) for each in given]
    speed = found.speed if question.speed is None else question.speed
    system = replace(found.system, contacts=contacts, unbalance=unbalance)
    return replace(found, system=system, speed=speed)


def case_in(path: Path) -> Case:
    """Return the case of a file, whose folder is of no interest, or a temporary one."""
    with named(path):
        return _read(path, path.stat().st_mtime_ns)


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
    return Case(system=system_of(run), speed=fastest, run=run)


@lru_cache(maxsize=2)
def _computed(question: Question, _changed: int) -> xr.Dataset:
    """Return the run of a question; the last ones are kept, since another node needs the same."""
    case = case_of(question)
    if question.machine is not None:
        return _of_disc(question, case)
    if case.run is not None:
        return case.run.isel(t=slice(None, None, math.ceil(case.run.sizes["t"] / MOST_SAMPLES)))
    assert case.course is not None
    if case.drops:
        return drop(case.system, **case.course.drop | {"speed": case.speed})
    if not case.speed > 0.0:
        raise InputError(f"speed must be positive, got {case.speed!r}")
    return simulate(case.system, **case.course.motion, **_length(case, question.revolutions))


def _of_disc(question: Question, case: Case) -> xr.Dataset:
    """Return the run of one disc, with more samples where it rolls."""
    each, rotor = samples_per_revolution(question.revolutions), question.rotor
    given: dict[str, Any] = {
        "start": question.start, "method": METHOD,
        "duration": _length(case, question.revolutions)["duration"],
    }  # fmt: skip
    run = simulate(rotor, samples=each * question.revolutions + 1, **given)
    whirls = math.ceil(PER_WHIRL * whirls_per_revolution(values_of(run), rotor.omega))
    finer = min(whirls, MOST_SAMPLES_OF_WHIRLS // question.revolutions)
    if finer <= each:
        return run
    return simulate(rotor, samples=finer * question.revolutions + 1, **given)


def _length(case: Case, revolutions: int) -> dict[str, Any]:
    """Return speed, duration and samples of a run of some revolutions."""
    samples = samples_per_revolution(revolutions) * revolutions + 1
    return {
        "speed": case.speed, "duration": 2.0 * math.pi * revolutions / (case.speed or 1.0),
        "samples": samples,
    }  # fmt: skip


def of_any_node(question: Question) -> tuple[Question, int]:
    """Return the question whose answer holds for all nodes, and when its file was changed.

    Without changes of a contact it is the same for all contacts.
    """
    contact = question.contact if question.of_contact else 0
    same = replace(question, about="motion", number=0, side=0, node="", contact=contact)
    return same, 0 if question.path is None else question.path.stat().st_mtime_ns


@lru_cache(maxsize=2)
def run_up_of(question: Question, _changed: int) -> xr.Dataset:
    """Return the run-up of the file, or else one over the speeds shown."""
    case = case_of(question)
    assert case.course is not None
    change = case.course.run_up
    if not change.keys() - {"speed"}:  # the file has no run-up
        time = 2.0 * math.pi * TURNS / (0.5 * (LOW + HIGH) * case.speed)
        change = {"speed": LOW * case.speed, "to": HIGH * case.speed, "ramp_time": time}
    return run_up(case.system, **case.course.motion, **change)


class Node:
    """A node of the rotor of a question as the panels see it; one disc has one node.

    The motion is relative to the stator of a contact, if the node has one.

    Parameters
    ----------
    question : Question
        The node, or else that of the chosen contact.
    """

    def __init__(self, question: Question) -> None:
        self.question, self.case = question, case_of(question)
        self.machine = question.machine
        name, number = question.node, question.contact
        nodes, contacts = list(self.case.system.nodes), self.case.system.contacts
        if name and name not in nodes:
            raise InputError(f"node must be one of {', '.join(nodes)}, got {shown(name)}")
        chosen = contacts[number] if number < len(contacts) else None
        self.name = name or (chosen.node if chosen else nodes[0])
        here = [i for i, each in enumerate(contacts) if each.node == self.name]
        self.contact = number if number in here else next(iter(here), None)

    @property
    def speed(self) -> float:
        """Spin speed."""
        return self.case.speed

    @property
    def scales(self) -> dict[str, float]:
        """The scales of the machine of a disc, or of the system, which are 1 in SI units."""
        if self.machine is not None:
            return {} if isinstance(self.machine, Rotor) else scales_of(self.machine)
        return scales_where(self.case.system.units == "SI")

    @property
    def facts(self) -> dict[str, Any]:
        """The facts about the rotor in an answer, by the names of those of one disc."""
        if self.machine is not None:
            return {"rotor": self.question.rotor.given, "scales": self.scales,
                    "start": self.question.start}  # fmt: skip
        at = "" if self.contact is None else f", contact {self.contact}"
        rotor: dict[str, object] = {"omega": self.speed, "delta0": 0.0}
        if self.contact is not None:
            contact = self.case.system.contacts[self.contact]
            rotor |= {"delta0": contact.clearance, "friction": contact.friction,
                      "contact_damping": contact.damping}  # fmt: skip
        speed = quantity(self.speed, "rad/s" if self.scales else "1")
        return {
            "rotor": rotor, "scales": self.scales, "start": None,
            "told": f"node {self.name}{at}, speed {speed}",
        }  # fmt: skip

    def begin(self) -> Iterator[Answer]:
        """Yield the sketch of the rotor in a file, and where sliders start."""
        if self.question.path is None:
            return
        file, case, contact = case_in(self.question.path), self.case, self.question.contact
        yield Answer("sketch", sketch_of(case.system) | {
            "node": self.name, "contact": contact, "about": case.about,
            "is_archive": case.run is not None, "is_drop": case.drops,
            "panels": case.panels, "given": {"speed": file.speed, "unbalance_factor": 1.0},
            "given_contacts": [
                {name: getattr(each, of_file) for name, of_file in OF_CONTACT.items()
                 if name != "friction" or each.radius is not None}
                | {"contact_exponent": each.exponent}
                for each in file.system.contacts
            ],
        })  # fmt: skip

    def beside(self, run: xr.Dataset, motion: Answer) -> Iterator[Answer]:
        """Yield the panels of the run, of a rotor in a file with its shape and the verdict.

        On what a disc settles takes longer.
        """
        if self.machine is not None:
            yield motion
            return
        yield Answer("shape", {}, {
            f"shape_{axis}": np.ascontiguousarray(run[axis].values.T).ravel() for axis in "xy"
        })  # fmt: skip
        yield motion
        words = (
            f"{touched_on_the_way(run)} {verdict(run)}" if self.case.changes_speed else verdict(run)
        )
        notes = [self.case.system.note] if self.case.system.note else []
        told = {"verdict": words, "level": level_of(run), "words": notes}
        yield Answer("settled", self.facts | told)

    def run(self) -> xr.Dataset:
        """Return the run that is drawn: of the archive, or computed."""
        return _computed(*of_any_node(self.question))

    def seen(self, run: xr.Dataset) -> Values:
        """Return the motion at the node, or in its contact, by the names of a run of one disc."""
        if self.machine is not None:
            return forced(run, self.question.rotor)
        here = run.sel(node=self.name)
        found = {name: here[name].values for name in ("t", *COMPONENTS)}
        number = -1 if self.contact is None else self.contact
        is_mine = run["event_contact"].values == number
        names = {f"event_{name}": f"event_{name}" for name in ("time", "time_error", "kind")}
        names |= {f"event_{axis}": f"event_contact_{axis}" for axis in "xy"}
        found |= {short: run[name].values[is_mine] for short, name in names.items()}
        is_here = run["episode_contact"].values == number
        names = {name: name for name in ("entry_time", "exit_time", "peak_force")}
        names["peak_time"] = "peak_force_time"
        found |= {short: run[name].values[is_here] for short, name in names.items()}
        found |= {"force": np.zeros(run.sizes["t"]), "horizon": run["horizon"].values}
        if self.contact is None:
            return found
        part = run.isel(contact=self.contact)
        names = {"x": "contact_x", "y": "contact_y", "force": "normal_force"}
        if float(part["law_friction"]) > 0.0:
            names |= {"mode": "mode", "slip_speed": "slip_speed"}
        return found | {short: part[name].values for short, name in names.items()}

    def probed(self, run: xr.Dataset) -> xr.Dataset:
        """Return the motion at the node as probes record it."""
        return run if self.machine is not None else at_node(run, self.name)

    def told(self, values: Values) -> dict[str, object]:
        """Return the numbers of the last half of a run; of a disc also where it goes on."""
        if self.machine is None:
            return {"ending": ending_of(values, self.speed)}
        end = rotated(states_of(values)[-1], -self.speed * values["t"][-1])
        return {"ending": ending(values, self.question.rotor), "end": end.tolist()}

    @property
    def duration(self) -> float:
        """The length of a run of one disc [dimensionless]."""
        return float(_length(self.case, self.question.revolutions)["duration"])

    def saved(self) -> xr.Dataset:
        """Return the run as it is written to a file; of a machine in SI units."""
        run, machine = self.run(), self.machine
        return dimensional(run, machine) if isinstance(machine, DimensionalRotor) else run

    @property
    def asked(self) -> Asked:
        """The question whose answer is the run of one disc, of a machine in SI units."""
        machine, start = self.machine, np.array(self.question.start)
        duration = self.duration
        if isinstance(machine, DimensionalRotor):
            length, velocity = machine.length_scale, machine.velocity_scale
            start = start * (length, length, velocity, velocity)
            duration *= machine.time_scale
        return Asked("simulate", {
            "rotor": machine, "start": start, "duration": duration,
            "samples": self.run().sizes["t"], "method": METHOD,
        })  # fmt: skip

    def run_up(self) -> xr.Dataset:
        """Return the run-up of the archive, of the file, or over the speeds shown."""
        if "cascade" not in self.case.panels:
            raise InputError("a run-up must be left out of a run at one speed and a drop")
        return self.run() if self.case.changes_speed else run_up_of(*of_any_node(self.question))

    def lines(self) -> str:
        """Return the Python lines that compute the run shown, or load a result.

        Examples
        --------
        >>> from rotor_ida.explorer.workers import example
        >>> print(Node(example("py", omega=1.7)).lines().splitlines()[6])
        machine = Rotor(omega=1.7, zeta=0.07, delta0=2.0)
        """
        question, case, path = self.question, self.case, self.question.path
        if path is None:
            machine = self.machine
            return LINES.format(rotor=type(machine).__name__, machine=written_in_python(machine),
                                call=self.asked.python("machine"))  # fmt: skip
        verb, path_said = "drop" if case.drops else "simulate", repr(path.name)
        lines = [
            f"from rotor_ida import {verb}, load_course, load_system", "",
            f"system, course = load_system({path_said}), load_course({path_said})",
        ]  # fmt: skip
        factor, changed = question.unbalance_factor, list[str]()
        if question.of_contact:
            words = ", ".join(f"{name}={value!r}" for name, value in question.of_contact.items())
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

    def command(self) -> str:
        """Return the command for the run shown, after what must be changed in the file first.

        Numbers of a system in SI units have the units of the page.

        Examples
        --------
        >>> from rotor_ida.explorer.workers import example
        >>> Node(example("sh", omega=1.7)).command().partition(" --start")[0]
        'rotor-ida simulate --omega 1.7 --zeta 0.07 --delta0 2.0'
        """
        question, case, path = self.question, self.case, self.question.path
        if path is None:
            return f"{self.asked.command()} --out run.nc --figure run"

        def told(value: float, unit: str) -> str:
            return written(value, unit) if case.system.units == "SI" and unit else repr(value)

        factor, first = question.unbalance_factor, list[str]()
        for name, value in question.of_contact.items():
            number = told(value, _unit(name, case.system.contacts[question.contact]))
            quoted = number if number == repr(value) else f'"{number}"'
            first.append(f"set {name} = {quoted} in contact {question.contact}")
        first += [f"multiply each moment of the unbalance by {factor!r}"] if factor != 1.0 else []
        said = f"# first, in {brief(path.name)}: {'; '.join(first)}\n" if first else ""
        asked: dict[str, object] = {"rotor": Path(path.name), "speed": told(case.speed, "rpm")}
        if case.drops:
            return said + Asked("drop", {**asked, "report": "report"}).command()
        length = _length(case, question.revolutions)
        asked |= {"duration": told(length["duration"], "s"), "samples": length["samples"]}
        return said + Asked("simulate", {**asked, "out": "run.nc", "figure": "run"}).command()


def _unit(name: str, contact: Contact) -> str:
    """Return the unit in which a system file gives a number of a contact; empty if it has none."""
    stiffness = "N/m" if contact.exponent == 1.0 else "N/m^1.5"
    return {"clearance": "um", "stiffness": stiffness, "damping": "s/m"}.get(name, "")


def sketch_of(system: RotorSystem) -> dict[str, object]:
    """Return nodes with their positions and masses, contacts, supports and unbalance."""
    places = system.positions or {n: float(i) for i, n in enumerate(system.nodes)}
    return {
        "nodes": list(places), "positions": list(places.values()),
        "has_positions": system.positions is not None, "units": system.units,
        "contacts": [{"node": each.node, "centre": each.centre, "clearance": each.clearance}
                     for each in system.contacts],
        "supports": [each.node for each in system.supports],
        "masses": [_mass(system, node) for node in system.nodes],
        "unbalance": [each.node for each in system.unbalance],
    }  # fmt: skip


def _mass(system: RotorSystem, node: str) -> float:
    """Return the mass that moves with a node where all others rest."""
    row = system.rows(node)[0]
    return float(row @ system.mass @ row)
