"""Panels of a rotor system from a file: its run or drop, exact whirls, Campbell, and run-up."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.checks import COMPONENTS, shown
from rotor_ida.closed_forms.campbell import campbell
from rotor_ida.closed_forms.whirls.special_speeds import special_speeds
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.explorer.measured import track_of
from rotor_ida.explorer.messages import OF_CONTACT, Answer, Question, SystemQuestion
from rotor_ida.explorer.motion import drawn, ending_of, lines_answer, samples_per_revolution
from rotor_ida.explorer.responses import NO_WHIRLS
from rotor_ida.explorer.system_touches import bands_in_words, clear_whirl, why_without_whirls
from rotor_ida.explorer.system_verdicts import level_of, touched_on_the_way, verdict
from rotor_ida.explorer.words import InUnits, words_of_run
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.data_sheet import GRAVITY
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Support
from rotor_ida.plot import save_figure
from rotor_ida.plot.appearance import without_pyplot
from rotor_ida.plot.figures import figure_of
from rotor_ida.results.archive import load
from rotor_ida.results.archived_system import problem_of
from rotor_ida.results.kinds import KINDS, kind_of
from rotor_ida.results.kinds import loaded as described
from rotor_ida.results.question import Question as Asked
from rotor_ida.results.sheets import sheets_shown
from rotor_ida.results.si_units import is_in_si
from rotor_ida.results.system_file import Course, read_system_file
from rotor_ida.schema import SPECIAL, STABILITY
from rotor_ida.signals.nodes import at_node
from rotor_ida.simulation.run_up import run_up
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.drop import drop
from rotor_ida.texts import brief, in_python
from rotor_ida.units import quantity, written

# Kinds of results that are played.
PLAYED = ("system_run", "drop")
# Rows of a table of an archive, and what its title says of the others where it is printed.
MOST_ROWS, IN_COMMAND = 20, " (all with --json)"
# Panels of a run, those of its run-up, and those that need a speed which is held.
PANELS = ("response", "sketch", "shape", "orbit", "turning", "history", "campbell")
OF_RUN_UP = ("bode", "polar", "cascade")
OF_ONE_SPEED = ("section", "spectrum", "full")
# Samples that are sent of an archive, and speeds of the exact response and of the Campbell diagram.
MOST_SAMPLES, SPEEDS, FEW_SPEEDS = 16_384, 160, 60
# A step of a branch of whirls by this part of the height of the diagram may be to another whirl.
JUMP = 0.05
KINDS_OF_SCALES = ("length", "time", "velocity", "force", "energy", "rate")
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
    def changes_speed(self) -> bool:
        """Whether it is an archived run at a speed that changes, and no drop."""
        return self.run is not None and "speed" in self.run and not _is_drop(self)

    @property
    def panels(self) -> tuple[str, ...]:
        """The panels that say something of it."""
        if _is_drop(self) or self.drops:
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
        return _loaded(path, path.stat().st_mtime_ns)


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
    run = _loaded(path, path.stat().st_mtime_ns)
    fastest = float(run["speed"].max()) if "speed" in run else float(run.attrs["speed"])
    return Case(system=problem_of(run)[0], speed=fastest, run=run)


def loaded(path: Path) -> xr.Dataset:
    """Return the result in an archive."""
    try:
        return load(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path.name}: {error}") from error


@lru_cache(maxsize=2)
def _loaded(path: Path, _changed: int) -> xr.Dataset:
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
    return _computed(*_of_any_node(question))


def _of_any_node(question: SystemQuestion) -> tuple[SystemQuestion, int]:
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


def facts_of(case: Case, seat: Seat) -> dict[str, object]:
    """Return the facts about the rotor in an answer, by the names of those of one disc."""
    si = case.system.units == "SI"
    at = "" if seat.contact is None else f", contact {seat.contact}"
    rotor: dict[str, object] = {"omega": case.speed, "delta0": 0.0}
    if seat.contact is not None:
        contact = case.system.contacts[seat.contact]
        rotor = {
            "omega": case.speed, "delta0": contact.clearance, "friction": contact.friction,
            "contact_damping": contact.damping,
        }  # fmt: skip
    return {
        "rotor": rotor, "scales": dict.fromkeys(KINDS_OF_SCALES, 1.0) if si else {}, "start": None,
        "told": f"node {seat.node}{at}, speed {quantity(case.speed, 'rad/s' if si else '1')}",
    }  # fmt: skip


def show_motion(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the panels of a run, and what is in an archive of anything."""
    archived = archive_of(question)
    if archived is None or kind_of(archived) in PLAYED:
        yield from _show_run(question)
    if archived is not None:
        assert question.path is not None
        yield from _show_archive(question.path, question.path.stat().st_mtime_ns)


@lru_cache(maxsize=2)
def _show_archive(path: Path, changed: int) -> list[Answer]:
    """Return the tables and the figure of any result, and order 1 and the cascade of a run-up."""
    result = _loaded(path, changed)
    kind = kind_of(result)
    _, parts = described(KINDS[kind].shown)(result, MOST_ROWS)
    told: dict[str, object] = {
        "name": path.name, "kind": KINDS[kind].meaning,
        "sheets": [each | {"title": each["title"].replace(IN_COMMAND, "")}
                   for each in sheets_shown(parts)],
        "panels": [] if kind in PLAYED else ["archive"],
    }  # fmt: skip
    arrays: Arrays = {}
    if KINDS[kind].drawn:
        with TemporaryDirectory() as folder, without_pyplot():
            place = Path(folder) / "figure"
            save_figure(figure_of(result), place)
            contents = place.with_suffix(".svg").read_bytes()
        arrays["figure"] = np.frombuffer(contents, dtype=np.int8)
    if kind != "run":
        return [Answer("archive", told, arrays)]
    notes: list[str] = []
    scales = dict.fromkeys(KINDS_OF_SCALES, 1.0) if is_in_si(result) else {}
    track = track_of(result, notes)
    told["panels"] = ["archive", *(OF_RUN_UP if track else ())]
    words = " ".join(notes)
    return [Answer("archive", told, arrays),
            Answer("track", {"scales": scales, "words": words}, track)]  # fmt: skip


def _show_run(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the sketch of the rotor, the shape of its shaft, its run at a node, and the verdict."""
    case = case_of(question)
    seat = seat_of(case, question)
    yield Answer("sketch", _sketch(case, seat, question))
    run = run_of(question)
    arrays: Arrays = {
        f"shape_{axis}": np.ascontiguousarray(run[axis].values.T).ravel() for axis in "xy"
    }
    yield Answer("shape", {}, arrays)
    yield _motion(case, seat, run)
    words, bands = verdict(run), _bands(*_of_any_node(question))
    if case.changes_speed:
        words = f"{touched_on_the_way(run)} {words}"
    yield Answer("settled", facts_of(case, seat) | {
        "verdict": f"{words} {bands}".rstrip(), "level": level_of(run),
        "words": [*filter(None, [words, bands, *_notes_of(case)])],
    })  # fmt: skip


def _motion(case: Case, seat: Seat, run: xr.Dataset) -> Answer:
    """Return the panels of a run at a node."""
    values = _at(run, seat)
    angle = at_node(run, seat.node)["angle"].values
    at_events = np.interp(values["event_time"], values["t"], angle)
    count, turns = values["t"].size - 1, abs(float(angle[-1] - angle[0])) / math.tau
    each = count / turns if turns > 0.0 else float(count)
    summary = ending_of(values, case.speed)
    machine = InUnits(case.speed) if case.system.units == "SI" else None
    changes = "speed" in run
    if not changes and math.isclose(each, round(each), rel_tol=1e-9):
        each = round(each)
    facts = facts_of(case, seat) | {
        "ending": summary, "words": [] if changes else words_of_run(machine, summary),
        "horizon": float(run["horizon"]), "is_whole": changes or kind_of(run) == "drop",
    }  # fmt: skip
    answer = drawn(values, facts, (angle, at_events), case.speed, each)
    if case.changes_speed:
        answer.arrays.update(_extremes(run["speed"].values, angle, values["radius"]))
    return answer


def _extremes(speed: Values, angle: Values, radius: Values) -> Arrays:
    """Return the extremes of the radius in each revolution of a run-up, over the speed."""
    first = np.flatnonzero(np.diff(np.floor(angle / math.tau), prepend=-np.inf))
    return {
        "band_speed": speed[first], "band_low": np.minimum.reduceat(radius, first),
        "band_high": np.maximum.reduceat(radius, first),
    }  # fmt: skip


def _at(run: xr.Dataset, seat: Seat) -> dict[str, npt.NDArray[Any]]:
    """Return the motion at a node, or in its contact, by the names of a run of one disc."""
    here = run.sel(node=seat.node)
    found = {name: here[name].values for name in ("t", *COMPONENTS)}
    number = -1 if seat.contact is None else seat.contact
    is_mine = run["event_contact"].values == number
    events = {f"event_{name}": run[f"event_{name}"].values[is_mine]
              for name in ("time", "time_error", "kind")}  # fmt: skip
    events |= {f"event_{axis}": run[f"event_contact_{axis}"].values[is_mine] for axis in "xy"}
    is_here = run["episode_contact"].values == number
    names = {name: name for name in ("entry_time", "exit_time", "peak_force")}
    episodes = {short: run[name].values[is_here]
                for short, name in (names | {"peak_time": "peak_force_time"}).items()}  # fmt: skip
    found |= {"force": np.zeros(run.sizes["t"]), **events, **episodes}
    if seat.contact is None:
        return found
    part = run.isel(contact=seat.contact)
    of_contact = {"x": "contact_x", "y": "contact_y", "force": "normal_force"}
    if float(part["law_friction"]) > 0.0:
        of_contact |= {"mode": "mode", "slip_speed": "slip_speed"}
    return found | {short: part[name].values for short, name in of_contact.items()}


def show_lines(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the full spectrum of the last half of the run at a node, over the spin speed."""
    case = case_of(question)
    seat = seat_of(case, question)
    yield lines_answer(at_node(run_of(question), seat.node), case.speed, facts_of(case, seat))


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
    if case.drops or _is_drop(case) or not case.system.contacts:
        return ""
    try:
        return bands_in_words(_assembly(case), np.linspace(0.0, HIGH * case.speed, SPEEDS)[1:])
    except InputError:  # nothing holds it, or a resonance is not damped
        return ""


def _sketch(case: Case, seat: Seat, question: SystemQuestion) -> dict[str, object]:
    """Return what a sketch of the rotor shows, and where sliders start."""
    places = case.system.positions or {n: float(i) for i, n in enumerate(case.system.nodes)}
    assert question.path is not None
    file = _read(question.path, question.path.stat().st_mtime_ns)
    return {
        "nodes": list(places), "positions": list(places.values()),
        "has_positions": case.system.positions is not None, "units": case.system.units,
        "contacts": [{"node": each.node, "centre": each.centre, "clearance": each.clearance}
                     for each in case.system.contacts],
        "supports": [each.node for each in case.system.supports],
        "masses": [_mass(case.system, node) for node in case.system.nodes],
        "unbalance": [each.node for each in case.system.unbalance],
        "node": seat.node, "contact": question.contact, "about": _about(case),
        "is_archive": case.run is not None, "is_drop": case.drops or _is_drop(case),
        "panels": case.panels,
        "given": {"speed": file.speed, "unbalance_factor": 1.0},
        "given_contacts": [
            {name: getattr(each, of_file) for name, of_file in OF_CONTACT.items()
             if name != "friction" or each.radius is not None}
            | {"contact_exponent": each.exponent}
            for each in file.system.contacts
        ],
    }  # fmt: skip


def _about(case: Case) -> str:
    """Return in words what is shown."""
    what = "A drop, from its system file" if case.drops else "A system file"
    if case.run is not None:
        what = "Archive: what is played is in the file"
    counts = [f"{count} {word}{'' if count == 1 else 's'}" for count, word in (
        (len(case.system.nodes), "node"), (len(case.system.contacts), "contact"))]  # fmt: skip
    return f"{what}; {', '.join(counts)}."


def _is_drop(case: Case) -> bool:
    return case.run is not None and kind_of(case.run) == "drop"


def _mass(system: RotorSystem, node: str) -> float:
    """Return the mass that moves with a node where all others rest."""
    row = system.rows(node)[0]
    return float(row @ system.mass @ row)


def show_responses(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the exact whirls over the speed."""
    case = case_of(question)
    seat = seat_of(case, question)
    notes = _left_out(case)
    try:
        arrays = _curve(*_whirls(*_of_any_node(question)), seat)
    except InputError as error:
        notes, arrays = _without_contact(case, seat, error)
    why = "; ".join(notes)
    facts = facts_of(case, seat) | ({"why": why[:1].upper() + why[1:]} if why else {})
    yield Answer("curve", facts, NO_WHIRLS | arrays)


def _curve(whirls: xr.Dataset, points: xr.Dataset | None, seat: Seat) -> Arrays:
    """Return the whirls at a node, or in its contact, branch by branch, and their folds."""
    along = {"node": whirls.get_index("node").get_loc(seat.node)}
    prefix = "node_"
    if seat.contact is not None:
        along, prefix = {"contact": seat.contact}, ""
    amplitude, lag = (
        whirls[prefix + name].isel(along).transpose("branch", "speed").values
        for name in ("amplitude", "phase_lag")
    )
    stability = whirls["stability"].transpose("branch", "speed").values
    touches = whirls["in_contact"].any("contact").transpose("branch", "speed").values
    arrays = _in_pieces(whirls["speed"].values, amplitude, lag, stability, touches)
    if points is None or seat.contact is None:
        return arrays
    radii = points["amplitude"].isel(contact=seat.contact).values
    for word in ("fold", "hopf", "graze"):
        here = points["special_kind"].values == SPECIAL[word]
        arrays |= {f"{word}_omega": points["special_speed"].values[here],
                   f"{word}_amplitude": radii[here]}  # fmt: skip
    return arrays


def _in_pieces(
    speeds: Values, amplitude: Values, lag: Values, stability: npt.NDArray[Any],
    touches: npt.NDArray[Any],
) -> Arrays:  # fmt: skip
    """Return whirls of shape (branch, speed) as one line, with the number of its piece.

    Whirls are in the order of their amplitudes: where some end, another one may take their place.
    """
    is_there = np.isfinite(amplitude)
    count, high = is_there.sum(axis=0), float(np.nanmax(amplitude, initial=0.0))
    step = np.abs(np.diff(np.nan_to_num(amplitude), axis=1, prepend=0.0))
    begins = (np.diff(count, prepend=-1) != 0) & (step > JUMP * high)
    begins[:, 1:] |= ~is_there[:, :-1]
    begins[:, 0] = True
    piece = np.where(is_there, np.cumsum(begins).reshape(begins.shape), -1)
    return {
        "omega": np.tile(speeds, len(amplitude)), "amplitude": amplitude.ravel(),
        "phase_lag": lag.ravel(), "stability": stability.astype(np.int8).ravel(),
        "in_contact": touches.astype(np.int8).ravel(),
        "piece": piece.astype(np.float64).ravel(),
    }  # fmt: skip


def _without_contact(case: Case, seat: Seat, error: InputError) -> tuple[list[str], Arrays]:
    """Return the whirl without contact at a node, and why the exact whirls are not drawn."""
    assembly, speeds = _assembly(case), np.linspace(LOW * case.speed, HIGH * case.speed, SPEEDS)
    why = why_without_whirls(assembly, error)
    place = list(case.system.nodes).index(seat.node)
    try:
        amplitude = clear_whirl(assembly, place, speeds)[np.newaxis]
    except InputError:
        return [f"no exact curve, as {why}"], {}
    stability = np.where(np.isnan(amplitude), STABILITY["absent"], STABILITY["stable"])
    nothing = np.zeros_like(stability)
    return [f"without whirls in contact, as {why}; the largest radius about the mean place"], (
        _in_pieces(speeds, amplitude, np.full_like(amplitude, np.nan), stability, nothing)
    )


def show_campbell(question: Question | SystemQuestion) -> Iterator[Answer]:
    """Yield the Campbell diagram of any rotor."""
    notes: list[str] = []
    if isinstance(question, Question):
        system, (low, high) = question.rotor.system(), question.speeds
    else:
        case = case_of(question)
        system, low, high = case.levitated, LOW * case.speed, HIGH * case.speed
        notes = _levitation(case) + _notes_of(case)
    speeds = np.linspace(low, high, FEW_SPEEDS)
    modes = min(MOST_EIGENVALUES, system.size)
    try:
        found = campbell(system, speed=speeds, modes=modes).isel(contact_stiffness=0)
    except InputError as error:
        yield Answer("campbell", {"notes": [str(error)]})
        return
    rates = found["whirl_speed"].transpose("eigenvalue", "speed").values
    damping = found["damping_ratio"].transpose("eigenvalue", "speed").values
    yield Answer("campbell", {"notes": notes}, {
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
    if case.drops or _is_drop(case):
        return ["with the magnetic bearings, as before the drop"]
    return []


def _notes_of(case: Case) -> list[str]:
    return [case.system.note] if case.system.note else []


def show_track(question: SystemQuestion) -> Iterator[Answer]:
    """Yield order 1 and the cascade of a run-up at the chosen node."""
    case = case_of(question)
    if "cascade" not in case.panels:
        raise InputError("a run-up must be left out of a run at one speed and a drop")
    run = run_of(question) if case.changes_speed else _run_up(*_of_any_node(question))
    seat = seat_of(case, question)
    signals = at_node(run, seat.node)
    notes = _notes_of(case)
    arrays = track_of(signals, notes)
    touches = touched_on_the_way(run) if case.system.contacts else ""
    yield Answer("track", facts_of(case, seat) | {"words": " ".join([touches, *notes])}, arrays)


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


def shown_of(case: Case) -> list[Callable[[SystemQuestion], Iterator[Answer]]]:
    """Return what fills the page of a case."""
    shows = {"full": show_lines, "cascade": show_track}
    return [show_motion, show_responses, show_campbell,
            *(show for panel, show in shows.items() if panel in case.panels)]  # fmt: skip


def check_played(result: xr.Dataset) -> None:
    """Raise `InputError` unless a page without a program can show a result."""
    if kind_of(result) not in PLAYED:
        raise InputError(f"html must be of a rotor or its run, got a result of {kind_of(result)}")
