"""Panels of a rotor system from a file: its run or drop, exact whirls, Campbell, and run-up."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.closed_forms.campbell import campbell
from rotor_ida.closed_forms.whirls.special_speeds import special_speeds
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.explorer.cases import (
    HIGH,
    KINDS_OF_SCALES,
    LOW,
    OF_RUN_UP,
    PLAYED,
    Case,
    Seat,
    archive_of,
    archived_in,
    case_in,
    case_of,
    is_drop,
    of_any_node,
    run_of,
    run_up_of,
    scales_in,
    seat_of,
)
from rotor_ida.explorer.measured import track_of
from rotor_ida.explorer.messages import OF_CONTACT, Answer, Question, SystemQuestion
from rotor_ida.explorer.motion import (
    drawn,
    ending_of,
    lines_answer,
    told_of_run,
)
from rotor_ida.explorer.responses import NO_WHIRLS
from rotor_ida.explorer.system_touches import clear_whirl
from rotor_ida.explorer.system_verdicts import level_of, touched_on_the_way, verdict
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.data_sheet import GRAVITY
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.plot import save_figure
from rotor_ida.plot.appearance import without_pyplot
from rotor_ida.plot.figures import figure_of
from rotor_ida.results.dataset_kinds import KINDS, kind_of
from rotor_ida.results.dataset_kinds import loaded as described
from rotor_ida.results.sheets import sheets_shown
from rotor_ida.results.si_units import is_in_si
from rotor_ida.schema import SPECIAL, STABILITY
from rotor_ida.signals.nodes import at_node
from rotor_ida.units import quantity

# Rows of a table of an archive, and what its title says of the others where it is printed.
MOST_ROWS, IN_COMMAND = 20, " (all with --json)"
# A step of a branch of whirls by this part of the height of the diagram may be to another whirl.
JUMP = 0.05
# Eigenvalues of a Campbell diagram.
MOST_EIGENVALUES = 16
# Speeds of the exact response and of the Campbell diagram.
SPEEDS, FEW_SPEEDS = 160, 60


def facts_of(case: Case, seat: Seat) -> dict[str, Any]:
    """Return the facts about the rotor in an answer, by the names of those of one disc."""
    scales = scales_in(case.system)
    at = "" if seat.contact is None else f", contact {seat.contact}"
    rotor: dict[str, object] = {"omega": case.speed, "delta0": 0.0}
    if seat.contact is not None:
        contact = case.system.contacts[seat.contact]
        rotor = {
            "omega": case.speed, "delta0": contact.clearance, "friction": contact.friction,
            "contact_damping": contact.damping,
        }  # fmt: skip
    return {
        "rotor": rotor, "scales": scales, "start": None,
        "told": f"node {seat.node}{at}, speed {quantity(case.speed, 'rad/s' if scales else '1')}",
    }  # fmt: skip


def show_motion(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the panels of a run, and what is in an archive of anything."""
    archived = archive_of(question)
    if archived is None or kind_of(archived) in PLAYED:
        yield from _show_run(question)
    if archived is not None:
        assert question.path is not None
        yield from _show_archive(question.path, question.path.stat().st_mtime_ns)


def _sheets_of(result: xr.Dataset) -> list[dict[str, Any]]:
    """Return the tables of a result, as the command line prints them."""
    _, parts = described(KINDS[kind_of(result)].shown)(result, MOST_ROWS)
    return [each | {"title": each["title"].replace(IN_COMMAND, "")} for each in sheets_shown(parts)]


@lru_cache(maxsize=2)
def _show_archive(path: Path, changed: int) -> list[Answer]:
    """Return the tables and the figure of any result, and order 1 and the cascade of a run-up."""
    result = archived_in(path, changed)
    kind = kind_of(result)
    told: dict[str, object] = {
        "name": path.name, "kind": KINDS[kind].meaning,
        "sheets": _sheets_of(result),
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
    words = f"{touched_on_the_way(run)} {verdict(run)}" if case.changes_speed else verdict(run)
    yield Answer("settled", facts_of(case, seat) | {
        "verdict": words, "level": level_of(run), "words": _notes_of(case),
    })  # fmt: skip


def _motion(case: Case, seat: Seat, run: xr.Dataset) -> Answer:
    """Return the panels of a run at a node."""
    values = _at(run, seat)
    angle = at_node(run, seat.node)["angle"].values
    at_events = np.interp(values["event_time"], values["t"], angle)
    count, turns = values["t"].size - 1, abs(float(angle[-1] - angle[0])) / math.tau
    each = count / turns if turns > 0.0 else float(count)
    summary = ending_of(values, case.speed)
    changes = "speed" in run
    if not changes and math.isclose(each, round(each), rel_tol=1e-9):
        each = round(each)
    facts = facts_of(case, seat)
    facts |= told_of_run(
        values | {"horizon": run["horizon"].values}, summary, scales_in(case.system)
    )
    facts["is_whole"] = changes or kind_of(run) == "drop"
    if changes:  # of several speeds
        facts |= {"words": [], "sheets": facts["sheets"][1:]}
    answer = drawn(values, facts, (angle, at_events), each)
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


def _sketch(case: Case, seat: Seat, question: SystemQuestion) -> dict[str, object]:
    """Return what a sketch of the rotor shows, and where sliders start."""
    places = case.system.positions or {n: float(i) for i, n in enumerate(case.system.nodes)}
    assert question.path is not None
    file = case_in(question.path)
    return {
        "nodes": list(places), "positions": list(places.values()),
        "has_positions": case.system.positions is not None, "units": case.system.units,
        "contacts": [{"node": each.node, "centre": each.centre, "clearance": each.clearance}
                     for each in case.system.contacts],
        "supports": [each.node for each in case.system.supports],
        "masses": [_mass(case.system, node) for node in case.system.nodes],
        "unbalance": [each.node for each in case.system.unbalance],
        "node": seat.node, "contact": question.contact, "about": _about(case),
        "is_archive": case.run is not None, "is_drop": case.drops or is_drop(case),
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


def _mass(system: RotorSystem, node: str) -> float:
    """Return the mass that moves with a node where all others rest."""
    row = system.rows(node)[0]
    return float(row @ system.mass @ row)


def show_responses(question: SystemQuestion) -> Iterator[Answer]:
    """Yield the exact whirls over the speed."""
    case = case_of(question)
    seat = seat_of(case, question)
    notes = _left_out(case)
    sheets: list[dict[str, Any]] = []
    try:
        whirls, points = _whirls(*of_any_node(question))
        arrays = _curve(whirls, points, seat)
        if points is not None and points.sizes["special"]:
            sheets = _sheets_of(points)[:1]
    except InputError as error:
        notes, arrays = _without_contact(case, seat, error)
    why = "; ".join(notes)
    facts = facts_of(case, seat) | ({"why": why[:1].upper() + why[1:]} if why else {})
    facts["sheets"] = sheets
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
    why = str(error).partition(": use ")[0]  # it names verbs, not what the page has
    place = list(case.system.nodes).index(seat.node)
    try:
        amplitude = clear_whirl(assembly, place, speeds)[np.newaxis]
    except InputError:
        return [f"no exact curve: {why}"], {}
    stability = np.where(np.isnan(amplitude), STABILITY["absent"], STABILITY["stable"])
    nothing = np.zeros_like(stability)
    return [f"without whirls in contact: {why}; the largest radius about the mean place"], (
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
    if case.drops or is_drop(case):
        return ["with the magnetic bearings, as before the drop"]
    return []


def _notes_of(case: Case) -> list[str]:
    return [case.system.note] if case.system.note else []


def show_track(question: SystemQuestion) -> Iterator[Answer]:
    """Yield order 1 and the cascade of a run-up at the chosen node."""
    case = case_of(question)
    if "cascade" not in case.panels:
        raise InputError("a run-up must be left out of a run at one speed and a drop")
    run = run_of(question) if case.changes_speed else run_up_of(*of_any_node(question))
    seat = seat_of(case, question)
    signals = at_node(run, seat.node)
    notes = _notes_of(case)
    arrays = track_of(signals, notes)
    touches = touched_on_the_way(run) if case.system.contacts else ""
    yield Answer("track", facts_of(case, seat) | {"words": " ".join([touches, *notes])}, arrays)


def shown_of(case: Case) -> list[Callable[[SystemQuestion], Iterator[Answer]]]:
    """Return what fills the page of a case."""
    shows = {"full": show_lines, "cascade": show_track}
    return [show_motion, show_responses, show_campbell,
            *(show for panel, show in shows.items() if panel in case.panels)]  # fmt: skip
