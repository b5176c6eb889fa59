"""Files to save from the page of a rotor system: files of the run, and a page without a server."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from rotor_ida.explorer import systems
from rotor_ida.explorer.files import NAME, as_text, in_single, page_with
from rotor_ida.explorer.messages import Answer
from rotor_ida.explorer.system_questions import SystemQuestion
from rotor_ida.plot import plot_drop, plot_run, save_figure
from rotor_ida.plot.appearance import without_pyplot
from rotor_ida.results.archive import save
from rotor_ida.results.kinds import kind_of

SHOWN = (systems.show_system_run, systems.show_system_map, systems.show_system_run_up)


def show_system_file(question: SystemQuestion) -> Iterator[Answer]:
    """Yield a file of the run shown, with its name."""
    ending = question.about.removeprefix("system_")
    if ending == "py":
        contents = systems.lines_of(question).encode()
    elif ending == "html":
        contents = recorded_page(question).encode()
    else:
        run = systems.run_of_system(question)
        with TemporaryDirectory() as folder:
            place = Path(folder) / NAME
            if ending == "nc":
                save(run, place.with_suffix(".nc"))
            else:
                with without_pyplot():
                    draw = plot_drop if kind_of(run) == "drop" else plot_run
                    save_figure(draw(run), place)
            contents = place.with_suffix(f".{ending}").read_bytes()
    yield Answer("file", {"name": f"{NAME}.{ending}"},
                 {"contents": np.frombuffer(contents, dtype=np.int8)})  # fmt: skip


def recorded_page(question: SystemQuestion) -> str:
    """Return the page with the run shown, to be seen at each node without the program."""
    case = systems.case_of(question)
    nodes = list(case.system.nodes)
    common: list[Answer] = []
    frames: list[list[str]] = []
    for node in nodes:
        asked = replace(question, node=node)
        answers = [each for show in SHOWN for each in show(asked)]
        answers, shared = _without_shared(answers)
        common = common or shared
        frames.append([as_text(in_single(each)) for each in answers])
    return page_with(
        {
            "nodes": nodes, "node": systems.node_of(case, question), "courses": {"nodes": frames},
            "common": [as_text(in_single(each)) for each in common],
        },
        page="system.html", script="system.js",
    )  # fmt: skip


def _without_shared(answers: Sequence[Answer]) -> tuple[list[Answer], list[Answer]]:
    """Return the answers of a node, and what is the same at all nodes: diagram and motion."""
    by_part = {each.part: each for each in answers}
    shared, run = [by_part.pop("campbell")], by_part["run"]
    lines = {name: each for name, each in run.arrays.items() if name.startswith("full_")}
    motion = {name: each for name, each in run.arrays.items() if name not in lines}
    shared.append(Answer("motion", {}, motion))
    by_part["run"] = replace(run, arrays=lines)
    return list(by_part.values()), shared
