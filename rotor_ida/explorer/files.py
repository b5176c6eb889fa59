"""Files to save from the page: files of the run, and a page that needs no server."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Arrays
from rotor_ida.checks import State, check_axis, check_increasing, shown
from rotor_ida.errors import InputError
from rotor_ida.explorer.archives import PLAYED, archive_of
from rotor_ida.explorer.cases import Node
from rotor_ida.explorer.messages import (
    Answer,
    Question,
    packed,
    speeds_shown,
    state_of,
)
from rotor_ida.explorer.motion import show_lines, show_motion
from rotor_ida.explorer.page import page_files
from rotor_ida.explorer.responses import show_responses
from rotor_ida.explorer.run_ups import show_track
from rotor_ida.explorer.whirls import show_campbell
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.parallel import Progress
from rotor_ida.plot import save_figure
from rotor_ida.plot.appearance import without_pyplot
from rotor_ida.plot.figures import figure_of
from rotor_ida.results.archive import save
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.question import Question as Asked
from rotor_ida.texts import in_page

# The steps of a recording: runs done and their total, and at last the page.
Recording = Iterator[tuple[int, int] | str]
# Order of the speeds: each from the start, or each from the end of the previous one.
COURSES = ("start", "up", "down")
MOVING = COURSES[1:]
MOST_SPEEDS = 500
# Default speeds of the recording, as fractions of the largest one shown.
SPEEDS: npt.NDArray[np.float64] = np.linspace(0.075, 0.825, 61)
# Number of last revolutions kept of each run.
KEPT = 10
# Parts that are the same at all speeds of a disc, and at all nodes of a system.
OF_ALL_SPEEDS, OF_ALL_NODES = ("curve", "branch"), ("shape", "campbell")
TIMES = ("t", "event_time", "exit_time")
# What fills further panels of a system, by the panel.
OF_PANELS = {"full": show_lines, "cascade": show_track}
PAGE, MAIN = "index.html", "main.js"
SCRIPT = '<script type="module" src="{}"></script>'
RECORDED = '<script type="application/json" id="recorded">{}</script>'
LINKS = re.compile(r'<link rel="(?:icon|stylesheet)"[^>]*>\n')
# A page on disk cannot load its scripts: they are modules in the page.
IMPORTS = re.compile(r'from "\./([\w./]+)"')
MODULES = "rotor-ida/"
# Only what has the nonce runs, and what it imports. A hash in its place would exclude the modules,
# and "data:" for them would admit scripts of others.
POLICY = (
    '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
    "script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'\">"
)


def show_file(question: Question) -> Iterator[Answer]:
    """Yield a complete file with its name; for a page, yield its progress first."""
    if question.about == "html":
        contents = b""
        for step in recording(question):
            if isinstance(step, str):
                contents = step.encode()
            else:
                yield Answer("progress", {"done": step[0], "total": step[1]})
    else:
        contents = _contents(question)
    name = f"run.{question.about}"
    yield Answer("file", {"name": name}, {"contents": np.frombuffer(contents, dtype=np.int8)})


def _contents(question: Question) -> bytes:
    archived, kind = archive_of(question), question.about
    if kind in {"py", "sh"}:
        return again_of(question).encode()
    if archived is None or kind_of(archived) in PLAYED:
        archived = Node(question).saved()
    return archive_with(archived) if kind == "nc" else figure_in(archived, kind)


def again_of(question: Question) -> str:
    """Return the Python lines, or the command, of what is shown."""
    kind, path = question.about, question.path
    if path is None or archive_of(question) is None:
        shown = Node(question)
        return shown.lines() if kind == "py" else f"{shown.command()}\n"
    if kind == "sh":
        return f"{Asked('show', {'rotor': Path(path.name)}).command()}\n"
    return f"from rotor_ida import load\n\nresult = load({path.name!r})\n"


def archive_with(run: xr.Dataset) -> bytes:
    """Return a run as an archive."""
    with TemporaryDirectory() as folder:
        save(run, place := Path(folder, "run.nc"))
        return place.read_bytes()


def figure_in(result: xr.Dataset, ending: str) -> bytes:
    """Return the figure of a result in a format."""
    with TemporaryDirectory() as folder, without_pyplot():
        save_figure(figure_of(result), place := Path(folder, "figure"))
        return place.with_suffix(f".{ending}").read_bytes()


def finished(recording: Recording, progress: Progress | None = None) -> str:
    """Return a page once it is recorded; `progress` is called with runs done and their total."""
    page = ""
    for step in recording:
        if isinstance(step, str):
            page = step
        elif progress is not None:
            progress(*step)
    return page


def recording(question: Question, speeds: Sequence[float] | None = None) -> Recording:
    """Yield the number of completed runs and their total after each run, and at last the page.

    Parameters
    ----------
    question : Question
        One disc, which is recorded at some speeds, or the rotor in a file, seen at each node. Its
        own speed or node is shown first.
    speeds : sequence of float, optional
        Speeds in the unit of the machine, from `check_speeds`; default: those and its own.
    """
    if question.machine is None:
        if (archived := archive_of(question)) is not None and kind_of(archived) not in PLAYED:
            raise InputError(
                f"html must be of a rotor or its run, got a result of {kind_of(archived)}"
            )
        node = Node(question)
        places: list[Any] = list(node.case.system.nodes)
        courses: Sequence[str] = ("nodes",)
        own: Any = node.name
        shared = OF_ALL_NODES
        state: dict[str, object] = {"node": own, "contact": question.contact}
        state |= dict(question.changes)
        shows = [show_motion, show_responses, show_campbell]
        shows += [show for panel, show in OF_PANELS.items() if panel in node.case.panels]
    else:
        question = replace(question, speeds=speeds_shown(question.disc))
        places, own = _speeds_of(question.disc, speeds), _speed(question.disc)
        courses, shared = COURSES, OF_ALL_SPEEDS
        state = state_of(question.disc, question.start, question.revolutions)
        shows = [_motion, show_lines, show_responses]
    common, recorded = dict[str, str](), dict[str, list[list[str]]]()
    for course in courses:
        frames: list[list[str]] = [[] for _ in places]
        at = question
        for place in range(len(places))[:: -1 if course == "down" else 1]:
            at = _at(at, places[place])
            answers = [answer for show in shows for answer in show(at)]
            frames[place] = _frame(answers, shared, common)
            if course in MOVING:
                at = replace(at, start=_end(answers))
            done = sum(map(bool, frames)) + len(recorded) * len(places)
            yield done, len(courses) * len(places)
        recorded[course] = frames
    yield page_with({
        "places": places, "place": own, "courses": recorded,
        "common": list(common.values()), "state": state,
    })  # fmt: skip


def _frame(answers: Sequence[Answer], shared: Sequence[str], common: dict[str, str]) -> list[str]:
    """Return answers as texts; of those of shared parts `common` gets one of each."""
    own = []
    for answer in answers:
        text = as_text(in_single(answer))
        if answer.part in shared:
            common[_name(answer)] = text
        else:
            own.append(text)
    return own


def _speeds_of(machine: Rotor | DimensionalRotor, speeds: Sequence[float] | None) -> list[float]:
    """Return the given speeds, or the default ones and that of a machine."""
    if speeds is not None:
        return list(speeds)
    low, high = _limits(machine)
    own = {_speed(machine)} if low <= _speed(machine) <= high else set()
    return sorted({*check_speeds(machine, None), *own})


def check_speeds(machine: Rotor | DimensionalRotor, speeds: Sequence[float] | None) -> list[float]:
    """Return the speeds to record, in the unit of the machine: those given or the default ones.

    Examples
    --------
    >>> check_speeds(Rotor(omega=2.0, zeta=0.07, delta0=2.0), [1.9, 2.0])
    [1.9, 2.0]
    """
    low, high = _limits(machine)
    given: list[float] = (SPEEDS * high).tolist()
    if speeds is not None:
        given = check_increasing("speeds", check_axis("speeds", speeds)).tolist()
    if len(given) > MOST_SPEEDS:
        raise InputError(f"speeds must be at most {MOST_SPEEDS}, got {len(given)}")
    if given[0] < low or given[-1] > high:
        raise InputError(f"speeds must lie from {low:g} to {high:g}, got {shown(given)}")
    return given


def _limits(machine: Rotor | DimensionalRotor) -> tuple[float, float]:
    """Return the lowest and the highest speed shown, in the unit of the machine."""
    rate = machine.reference_frequency if isinstance(machine, DimensionalRotor) else 1.0
    low, high = speeds_shown(machine)
    return low * rate, high * rate


def _motion(question: Question) -> Iterator[Answer]:
    """Yield the run with its last revolutions only."""
    for answer in show_motion(question):
        each = int(str(answer.facts["samples_per_revolution"]))
        kept = min(KEPT, question.revolutions) * each + 1
        samples = answer.arrays["t"].size
        times: Arrays = {name: answer.arrays[name].astype(np.float64) for name in TIMES}
        first = times["t"][-kept]
        arrays = {}
        for name, values in answer.arrays.items():
            part = values
            if values.size == samples:
                part = values[-kept:]
            elif name.startswith("event_"):
                part = values[times["event_time"] >= first]
            elif name in {"entry_time", "exit_time", "peak_time", "peak_force"}:
                part = values[~(times["exit_time"] < first)]
            arrays[name] = part
        yield replace(answer, arrays=arrays)


def in_single(answer: Answer) -> Answer:
    """Return an answer in single precision, which is enough for drawing."""
    arrays = {
        name: values if values.dtype == np.int8 else values.astype(np.float32)
        for name, values in answer.arrays.items()
    }
    return replace(answer, arrays=arrays)


def _at(question: Question, place: Any) -> Question:
    """Return the question at another speed of a disc, or another node."""
    machine = question.machine
    if machine is None:
        return replace(question, node=place)
    name = "omega" if isinstance(machine, Rotor) else "speed"
    return replace(question, machine=replace(machine, **{name: place}))


def _speed(machine: Rotor | DimensionalRotor) -> float:
    return machine.speed if isinstance(machine, DimensionalRotor) else machine.omega


def _end(answers: Sequence[Answer]) -> State:
    """Return the start of the next run: the settled state, or else the end of this run."""
    ends = {each.part: each.facts["end"] for each in answers if "end" in each.facts}
    x, y, vx, vy = np.asarray(ends.get("settled", ends["motion"])).tolist()
    return x, y, vx, vy


def _name(answer: Answer) -> str:
    """Return a key that distinguishes the curve and the branches."""
    first = answer.arrays["omega"][:1].tolist() if answer.part == "branch" else []
    return f"{answer.part} {first}"


def as_text(answer: Answer) -> str:
    """Return an answer as text for a page."""
    return base64.b64encode(packed(answer)).decode()


def page_with(recorded: object) -> str:
    """Return a page with all its files and the recorded results."""
    results = RECORDED.format(in_page(recorded))
    files = {name: contents.decode() for name, contents in page_files().items()}
    styles = "".join(files[name] for name in ("uplot/uPlot.min.css", "style.css"))
    modules = {
        MODULES + name: _data("text/javascript", IMPORTS.sub(rf'from "{MODULES}\1"', script))
        for name, script in files.items()
        if name.endswith(".js")
    }
    # a digest of the page: nothing in the results can contain it
    nonce = hashlib.sha256("".join([results, files[PAGE], styles, *modules.values()]).encode())
    own = f'nonce="{nonce.hexdigest()}"'
    head = "\n".join([
        POLICY.format(nonce=nonce.hexdigest()),
        f'<link rel="icon" href="{_data("image/svg+xml", files["icon.svg"])}">',
        f"<style {own}>{styles}</style>",
        f'<script type="importmap" {own}>{in_page({"imports": modules})}</script>',
        results,
        f'<script type="module" {own}>import "{MODULES}{MAIN}";</script>',
    ])  # fmt: skip
    return LINKS.sub("", files[PAGE]).replace(SCRIPT.format(MAIN), head)


def _data(kind: str, text: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode()}"
