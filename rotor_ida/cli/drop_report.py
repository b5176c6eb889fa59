"""The report on a drop: one page of HTML and a PDF, with figures, tables, and how to repeat it."""

from __future__ import annotations

import base64
import hashlib
import io
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rotor_ida.cli.drop_tables import acceptance, drops_tables, given_tables, run_tables
from rotor_ida.cli.pdf import write_pdf
from rotor_ida.cli.sheets import Sheet, facts
from rotor_ida.results.files import file_to_write
from rotor_ida.results.question import Question
from rotor_ida.results.toml_files import read_toml
from rotor_ida.steady.drop_words import NOT_ACTING, sentence_of
from rotor_ida.texts import printable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Drop on touchdown bearings"
ASSUMPTIONS = (
    "The rotor is linear. All that is not linear happens in the contacts.",
    "Before the drop each magnetic bearing is a linear spring and damper about the centre of its "
    "node and carries the static load; at the drop the failing ones are gone at once.",
    "A touchdown bearing is a ring with a clearance: a normal force by its stiffness and contact "
    "damping, Coulomb friction of constant coefficient, an inner race with inertia and drag. "
    "Balls, cage and lubricant are not modelled, nor does the bearing warm up or wear.",
    "After the drop no drive acts: where an inertia is given, drag and friction decelerate the "
    "rotor; otherwise its speed is held.",
    "The motion is plane in each bearing; axial and torsional motion act only as far as they are "
    "in the matrices.",
    f"Other close clearances are compared with the motion; {NOT_ACTING}.",
)
SCOPE = (
    "The published scope of ISO 14839-5:2022 on touch-down bearings names contact events, load "
    "requirements, sizing, simulation for the validation of a design, and acceptance tests. Of "
    "these this report states contact events (number, duration), loads (largest and mean force, "
    "impulse, energy), whirl, race speed, coast-down and the gap left at each clearance that was "
    "given, of simulated drops.",
    "It does not state: life, wear and temperature of the bearings, loads along the axis, the "
    "number of drops that a bearing survives, or measurements. It is no statement of conformity "
    "with any standard.",
)
VERSIONS = ("rotor_ida_version", "python_version", "numpy_version",
            "scipy_version", "xarray_version", "sundials_version", "core_compiler", "core_level",
            "method", "rtol")  # fmt: skip
# Longest system file that is printed [characters], and resolution of pictures [1/inch].
LONGEST_FILE, RESOLUTION = 20_000, 180


def report_files(folder: Path, *, many: bool) -> list[Path]:
    """Return the files of a report."""
    names = ["drop.nc", *(["drops.nc"] if many else []), "report.html", "report.pdf"]
    return [folder / name for name in names]


def write_report(
    folder: Path,
    system: Path,
    run: xr.Dataset,
    drops: xr.Dataset | None,
    options: Mapping[str, object],
    *,
    overwrite: bool,
) -> list[Path]:
    """Write the pages of a report, computed with options, into a folder; return them."""
    from rotor_ida.plot.appearance import boxes_for_letters  # noqa: PLC0415 - heavy

    allowed = acceptance(run, drops)
    tables = [*run_tables(run), *([] if drops is None else drops_tables(drops)),
              *given_tables(run, drops)]  # fmt: skip
    figures = _figures(run, drops)
    parts: dict[str, Any] = {
        "title": TITLE, "head": _head(run, system), "summary": sentence_of(run, drops),
        "answers": [allowed] if allowed else [], "tables": tables,
        "assumptions": ASSUMPTIONS, "scope": SCOPE,
        "commands": _commands(folder, system, options),
        "versions": facts("Versions", _versions(run) | _rotor_file(system)),
        "system": str(system), "source": _source(system),
    }  # fmt: skip
    html, pdf = folder / "report.html", folder / "report.pdf"
    with file_to_write("out", html, overwrite=overwrite) as part:
        part.write_text(_page(parts, figures), encoding="utf-8")
    with file_to_write("out", pdf, overwrite=overwrite) as part, boxes_for_letters():
        write_pdf(part, TITLE, _for_print(parts), [figure for _, figure in figures])
    return [html, pdf]


def _head(run: xr.Dataset, system: Path) -> str:
    """Return from which file, when and with what the drop was computed."""
    version = run.attrs.get("rotor_ida_version", "")
    date = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    return f"{system}, computed with rotor_ida {version}, report of {date}"


def _commands(folder: Path, system: Path, options: Mapping[str, object]) -> list[str]:
    """Return the commands that compute the drops again, and check them."""
    file, *_ = report_files(folder, many=False)
    asked = Question("drop", {"rotor": system, "out": folder, **options})
    return [asked.command(), Question("verify", {"rotor": file}).command()]


def _versions(run: xr.Dataset) -> dict[str, object]:
    """Return what computed the drop."""
    return {name.removesuffix("_version"): np.asarray(run.attrs[name]).item()
            for name in VERSIONS if name in run.attrs}  # fmt: skip


def _rotor_file(system: Path) -> dict[str, object]:
    """Return name and digest of the file from which a system file takes the rotor, if it does."""
    table = read_toml("system", system).get("system") if system.is_file() else None
    name = table.get("file") if isinstance(table, Mapping) else None
    path = system.parent / str(name)
    if name is None or not path.is_file():  # matrices may be files in a folder
        return {}
    return {f"SHA-256 of {name}": hashlib.sha256(path.read_bytes()).hexdigest()}


def _source(system: Path) -> str:
    """Return the text of a system file, without which a reader cannot compute it again."""
    text = system.read_text(encoding="utf-8") if system.is_file() else ""
    return text if len(text) <= LONGEST_FILE else f"{text[:LONGEST_FILE]}\n..."


def _figures(run: xr.Dataset, drops: xr.Dataset | None) -> list[tuple[str, Figure]]:
    """Return the figures with their titles."""
    from rotor_ida.plot import plot_drop, plot_drops, plot_run  # noqa: PLC0415 - heavy
    from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415

    with without_pyplot():
        found = [("One drop: radius, force and speeds", plot_drop(run)),
                 ("One drop: orbits and forces", plot_run(run))]  # fmt: skip
        if drops is not None:
            words = (
                "Grid: ranges (shaded) and means (dots)"
                if "cell" in drops.sizes
                else "Distributions over many drops"
            )
            found.append((words, plot_drops(drops)))
    return found


def _png(figure: Figure) -> str:
    """Return a figure as a picture in a page."""
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=RESOLUTION)
    return base64.b64encode(written.getvalue()).decode()


def _page(parts: dict[str, Any], figures: Sequence[tuple[str, Figure]]) -> str:
    """Return the report as HTML that needs no other file."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - heavy

    environment = Environment(
        loader=PackageLoader("rotor_ida", "cli"), undefined=StrictUndefined, autoescape=True,
        finalize=lambda value: printable(value) if isinstance(value, str) else value,
    )  # fmt: skip
    drawn = [{"title": title, "png": _png(figure)} for title, figure in figures]
    template = environment.get_template("drop_report.html.jinja")
    return template.render(**parts | {"figures": drawn})


def _for_print(parts: dict[str, Any]) -> list[str | Sheet]:
    """Return the parts of the report in the order of its pages on paper."""
    source = [f"System file {parts['system']}", parts["source"]] if parts["source"] else []
    return [
        parts["title"], parts["head"], parts["summary"], *parts["answers"], *parts["tables"],
        "What is assumed", *(f"- {each}" for each in parts["assumptions"]),
        "What is reported", *parts["scope"],
        "Compute it again", *parts["commands"], parts["versions"], *source,
    ]  # fmt: skip
