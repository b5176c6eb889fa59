"""Reports: a page of HTML and a PDF, with figures, and the commands that repeat them."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.cli.given import sheets_of_rotor
from rotor_ida.cli.output import RESULT
from rotor_ida.cli.pdf import write_pdf
from rotor_ida.cli.rotor_options import ANY_SPEED
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.results.dataset_kinds import KINDS, kind_of
from rotor_ida.results.files import check_target, file_to_write
from rotor_ida.results.provenance import versions
from rotor_ida.results.question import Question
from rotor_ida.results.sheets import Parts, Sheet, facts
from rotor_ida.steady.drop_words import NOT_ACTING
from rotor_ida.texts import printable
from rotor_ida.units import UnitSystem

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

LINEAR = "The rotor is linear. All that is not linear happens in the contacts."
CONTACTS = (
    "Each contact is a ring with a clearance: a normal force by its stiffness and contact damping, "
    "and Coulomb friction of constant coefficient, the same at rest and sliding. Nothing wears or "
    "warms up."
)
PLANE = (
    "The motion is plane at each contact; axial and torsional motion act only as far as they are "
    "in the matrices."
)
# What is assumed of one disc, of a rotor system, and by what is asked of either.
OF_DISC = (
    "The rotor is one disc in the middle of a shaft without mass. It moves across its axis; there "
    "are no gyroscopic moments.",
    "The stator is rigid and centred on the axis of the shaft.",
    CONTACTS,
)
OF_SYSTEM = (LINEAR, CONTACTS, PLANE)
OF_VERB = {
    "simulate": ("The speed is constant, whatever torque that needs.",),
    "sweep": ("Responses are those reached from the given starts. There may be others.",),
    "clearance_report": (
        "Clearances are compared with the linear response to unbalance; a static deflection and an "
        "offset of the centres are not counted.",
        "The formulas are those of public statements of API 617 and API RP 684. This is no "
        "statement of conformity with any standard.",
    ),
    "drop": (
        "Before the drop each magnetic bearing is a linear spring and damper about the centre of "
        "its node and carries the static load; at the drop the failing ones are gone at once.",
        "Of a touchdown bearing the ring and an inner race with inertia and drag are modelled, not "
        "balls, cage and lubricant.",
        "After the drop no drive acts: where an inertia is given, drag and friction decelerate the "
        "rotor; otherwise its speed is held.",
        f"Other close clearances are compared with the motion; {NOT_ACTING}.",
    ),
    "signals": (
        "The probes look at the shaft at the angles and with the factors that are given; what "
        "their runout adds is taken off only where a slow roll is given.",
    ),
    "fit": (
        "What the model lacks goes into the residuals.",
        "The noise of the probes is independent from sample to sample.",
    ),
}
# What the report on an answer states, and what it does not.
SCOPE = {"drop": (
    "The published scope of ISO 14839-5:2022 on touch-down bearings names contact events, load "
    "requirements, sizing, simulation for the validation of a design, and acceptance tests. Of "
    "these this report states contact events (number, duration), loads (largest and mean force, "
    "impulse, energy), whirl, race speed, coast-down and the gap left at each clearance that was "
    "given, of simulated drops.",
    "It does not state: life, wear and temperature of the bearings, loads along the axis, the "
    "number of drops that a bearing survives, or measurements. It is no statement of conformity "
    "with any standard.",
)}  # fmt: skip
VERSIONS = ("rotor_ida_version", "python_version", "numpy_version",
            "scipy_version", "xarray_version", "sundials_version", "core_compiler", "core_level",
            "method", "rtol")  # fmt: skip
# Longest file that is printed [characters], and resolution of pictures [1/inch].
LONGEST_FILE, RESOLUTION = 20_000, 180
# Endings of files, which no folder of a report should have.
OF_FILES = (".html", ".pdf", ".nc", ".csv", ".toml")
HTML, PDF = "report.html", "report.pdf"


def check_folder(name: str, folder: Path, *, overwrite: bool, permission: str) -> None:
    """Refuse a folder for a report that is a file, or has one already."""
    if folder.suffix in OF_FILES or (folder.exists() and not folder.is_dir()):
        raise InputError(f"{name} must be a folder, got {shown(folder)}")
    if not folder.parent.is_dir():
        raise InputError(f"{name} must be in a folder that exists, got {shown(folder)}")
    for each in (RESULT, HTML, PDF) if folder.is_dir() else ():
        check_target(name, folder / each, overwrite=overwrite, permission=permission)


def write_pages(
    folder: Path,
    dataset: xr.Dataset,
    parts: Parts,
    *,
    rotor: Any,
    files: Sequence[Path],
    commands: Sequence[str],
    figures: Sequence[tuple[str, Figure]],
    system: UnitSystem,
    overwrite: bool,
) -> list[Path]:
    """Write the report on a result, from the parts of its answer, as HTML and PDF; return both."""
    from rotor_ida.plot.appearance import boxes_for_letters  # noqa: PLC0415 - heavy

    question = Question.of_result(dataset)
    kind = kind_of(dataset)
    verb = question.verb.removesuffix("_ensemble") if question else kind
    found = rotor if rotor is not None else _rotor_of(dataset, question)
    first = next((place for place, each in enumerate(parts) if isinstance(each, Sheet)), len(parts))
    given = [] if found is None else sheets_of_rotor(found, _speed_of(dataset, found))
    of_rotor = OF_SYSTEM if isinstance(found, RotorSystem) else OF_DISC
    page: dict[str, Any] = {
        "title": _passage(dataset) if verb == "run_up" else KINDS[kind].meaning.capitalize(),
        "head": head_of(dataset, files),
        "summary": parts[:first],
        "answers": parts[first : first + 1],
        "tables": [*given, *parts[first + 1 :]],
        "assumptions": [*(of_rotor if kind != "signals" else ()), *OF_VERB.get(verb, ())],
        "scope": SCOPE.get(verb, ()),
        "commands": commands,
        "versions": facts("Versions", versions_of(dataset)),
        "sources": sources_of(files),
    }
    html, pdf = folder / HTML, folder / PDF
    with file_to_write(html, overwrite=overwrite) as part:
        drawn = [{"title": title, "png": _png(figure)} for title, figure in figures]
        part.write_text(_html({**page, "system": system, "figures": drawn}), encoding="utf-8")
    with file_to_write(pdf, overwrite=overwrite) as part, boxes_for_letters():
        write_pdf(part, page["title"], _in_order(page), [figure for _, figure in figures], system)
    return [html, pdf]


def _html(page: Mapping[str, Any]) -> str:
    """Return the report as HTML that needs no other file."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - heavy

    environment = Environment(
        loader=PackageLoader("rotor_ida", "cli"), undefined=StrictUndefined, autoescape=True,
        finalize=lambda value: printable(value) if isinstance(value, str) else value,
    )  # fmt: skip
    return environment.get_template("report.html.jinja").render(page)


def _in_order(page: Mapping[str, Any]) -> Parts:
    """Return the parts of the report in the order of its pages on paper."""
    scope = ["What is reported", *page["scope"]] if page["scope"] else []
    files = [part for file, text in page["sources"].items() for part in (f"File {file}", text)]
    return [
        page["title"], page["head"], *page["summary"], *page["answers"], *page["tables"],
        "What is assumed", *(f"- {each}" for each in page["assumptions"]), *scope,
        "Compute it again", *page["commands"], page["versions"], *files,
    ]  # fmt: skip


def _passage(run: xr.Dataset) -> str:
    """Return what a run with a changing speed is called."""
    first, *_, last = run["speed"].values
    return "Run-down" if abs(last) < abs(first) else "Run-up"


def _speed_of(dataset: xr.Dataset, rotor: Any) -> float | tuple[float, float] | None:
    """Return the speed of a result, or the slowest and the fastest one of a record without one."""
    given = getattr(rotor, "speed", getattr(rotor, "omega", None))
    if kind_of(dataset) == "fit" and given == ANY_SPEED:
        return float(dataset["speed"].min()), float(dataset["speed"].max())
    return dataset.attrs.get("speed", dataset.attrs.get("start_speed"))


def _rotor_of(dataset: xr.Dataset, question: Question | None) -> Any:
    """Return the rotor of a result, if the result has it."""
    from rotor_ida.results.si_units import machine_of  # noqa: PLC0415 - heavy

    machine = machine_of(dataset)
    if machine is not None:
        return machine
    asked = question.arguments.get("rotor") if question else None
    return asked if isinstance(asked, Rotor | DimensionalRotor | RotorSystem) else None


def head_of(dataset: xr.Dataset, files: Sequence[Path]) -> str:
    """Return from which files and measurement, when and with what a result was computed."""
    measured = [str(dataset.attrs[name]) for name in ("file", "caption") if name in dataset.attrs]
    told = [
        *map(str, files),
        *measured,
        f"computed with rotor_ida {versions_of(dataset)['rotor_ida']}",
    ]
    return f"{', '.join(told)}, report of {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"


def versions_of(dataset: xr.Dataset) -> dict[str, object]:
    """Return what computed a result: a closed form keeps no versions, and is of this program."""
    known = {**versions(), **dataset.attrs}
    return {name.removesuffix("_version"): np.asarray(known[name]).item()
            for name in VERSIONS if name in known}  # fmt: skip


def sources_of(files: Sequence[Path]) -> dict[str, str]:
    """Return the texts of files, without which a reader cannot compute a result again."""
    found = {}
    for file in files:
        text = file.read_text(encoding="utf-8") if file.is_file() else ""
        if text:
            is_short = len(text) <= LONGEST_FILE
            found[str(file)] = text if is_short else f"{text[:LONGEST_FILE]}\n..."
    return found


def _png(figure: Figure) -> str:
    """Return a figure as a picture in a page."""
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=RESOLUTION)
    return base64.b64encode(written.getvalue()).decode()
