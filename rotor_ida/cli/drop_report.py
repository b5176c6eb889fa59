"""The report on a drop: one page of HTML and a PDF, with figures, tables, and how to repeat it."""

from __future__ import annotations

import base64
import io
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rotor_ida.cli.report import shown
from rotor_ida.cli.variables import with_unit
from rotor_ida.schema import OF_BEARING

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
)
VERSIONS = ("rotor_ida", "python", "numpy", "scipy", "xarray", "core_compiler", "core_level",
            "method", "rtol", "date_created")  # fmt: skip
# Lines and columns of a page of text, and size of an A4 page [inch].
PAGE, LINES = (8.27, 11.69), 70


@dataclass(frozen=True, slots=True)
class Listed:
    """A table of the report."""

    title: str
    heads: list[str]
    rows: list[list[str]]
    note: str = ""


def report_files(folder: Path, *, many: bool) -> list[Path]:
    """Return the files of a report."""
    names = ["drop.nc", *(["drops.nc"] if many else []), "report.html", "report.pdf"]
    return [folder / name for name in names]


def write_report(
    folder: Path, system: Path, run: xr.Dataset, drops: xr.Dataset | None
) -> list[Path]:
    """Write the pages of a report into a folder that exists, and return them."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - heavy

    tables = [_of_run(run), *([] if drops is None else _of_drops(drops))]
    figures = _figures(run, drops)
    commands = [f"rotor-ida drop {shlex.quote(str(system))} --out {shlex.quote(str(folder))}",
                f"rotor-ida verify {shlex.quote(str(folder / 'drop.nc'))}"]  # fmt: skip
    versions = [(name.replace("_", " "), shown(_plain(run.attrs[name])))
                for name in VERSIONS if name in run.attrs]  # fmt: skip
    summary = sentence_of(run, drops)
    environment = Environment(
        loader=PackageLoader("rotor_ida", "cli"), undefined=StrictUndefined, autoescape=True
    )
    page = environment.get_template("drop_report.html.jinja").render(
        title=TITLE, summary=summary, tables=tables, assumptions=ASSUMPTIONS, commands=commands,
        versions=versions,
        figures=[{"title": title, "png": _png(figure)} for title, figure in figures],
    )  # fmt: skip
    html, pdf = folder / "report.html", folder / "report.pdf"
    html.write_text(page, encoding="utf-8")
    text = [TITLE, "", summary, ""]
    for table in tables:
        text += _lines(table)
    text += ["What is assumed", *(f"- {each}" for each in ASSUMPTIONS), "", "Compute it again",
             *commands, "", *(f"{name}: {value}" for name, value in versions)]  # fmt: skip
    _write_pdf(pdf, text, [figure for _, figure in figures])
    return [html, pdf]


def sentence_of(run: xr.Dataset, drops: xr.Dataset | None) -> str:
    """Return in words whether the drop is survived, as far as figures say."""
    forces, nodes = run["largest_force"].values, run["contact_node"].values
    worst = int(forces.argmax())
    unit = str(run["largest_force"].attrs.get("units", "")).removeprefix("1")
    force = f"{forces[worst]:.4g} {unit}".strip()
    said = [
        f"The largest force of this drop is {force}, in the bearing at {str(nodes[worst])!r}; the "
        f"rotor goes as far as {float(run['excursion'].max()):.3g} clearances.",
    ]
    senses = run["whirl_sense"].values
    if (senses < 0).any():
        said.append("It whirls backwards for three turns or more.")
    if np.isfinite(run["rest_time"].values).all():
        said.append(f"It stays in contact from {float(run['rest_time'].max()):.3g} s on.")
    horizon, end = float(run["horizon"]), float(run["t"][-1])
    if horizon < end:
        said.append(
            f"After {horizon:.3g} s of {end:.3g} s this one motion depends on rounding: what "
            "follows is one of many possible ones."
        )
    if drops is not None and "backward_whirl_fraction" in drops.variables:
        low, middle, high = (
            100.0 * float(drops[f"backward_whirl_fraction{each}"].max())
            for each in ("_low", "", "_high")
        )
        said.append(
            f"Of {drops.sizes['drop']} drops {middle:.1f} % whirl backwards (95 % interval "
            f"{low:.1f} to {high:.1f} %)."
        )
    return " ".join(said)


def _of_run(run: xr.Dataset) -> Listed:
    """Return what one drop delivers by bearing."""
    heads = ["", *(str(each) for each in run["contact_node"].values)]
    rows = [[with_unit(run, name), *(shown(each, 5) for each in run[name].values.tolist())]
            for name in OF_BEARING]  # fmt: skip
    note = ""
    if "node_excursion" in run.variables:
        gaps = [
            f"{node!s} {value:.3g}"
            for node, value in zip(run["node"].values, run["node_excursion"].values, strict=True)
            if np.isfinite(value)
        ]
        note = f"Largest radius over other close clearances: {', '.join(gaps)}."
    return Listed("One drop", heads, rows, note)


def _of_drops(drops: xr.Dataset) -> list[Listed]:
    """Return the distributions over many drops, a table for each bearing."""
    if "quantile" not in drops.sizes:
        return []
    tables = []
    levels = [f"{100.0 * each:g} %" for each in drops["quantile"].values]
    for number, node in enumerate(drops["contact_node"].values):
        own = drops.isel(contact=number)
        rows = []
        for name in OF_BEARING:
            quantiles = [own[f"{name}_quantile{end}"].values for end in ("", "_low", "_high")]
            cells = [f"{shown(float(q), 4)} ({shown(float(low), 4)} to {shown(float(high), 4)})"
                     for q, low, high in zip(*quantiles, strict=True)]  # fmt: skip
            mean, error = float(own[f"{name}_mean"]), float(own[f"{name}_mean_error"])
            rows.append([with_unit(own, name), f"{shown(mean, 4)} ± {shown(error, 2)}", *cells])
        note = "; ".join(
            f"{words}: {float(own[f'{name}_fraction']):.3f} "
            f"({float(own[f'{name}_fraction_low']):.3f} to "
            f"{float(own[f'{name}_fraction_high']):.3f})"
            for name, words in (
                ("backward_whirl", "Fraction with a backward whirl"),
                ("rest", "in contact at the end"),
                ("decided", "whose largest force comes before the horizon"),
            )
        )
        tables.append(Listed(f"{drops.sizes['drop']} drops: bearing at {node!s}",
                             ["", "mean ± standard error", *levels], rows,
                             f"{note}. In brackets 95 % intervals."))  # fmt: skip
    return tables


def _figures(run: xr.Dataset, drops: xr.Dataset | None) -> list[tuple[str, Figure]]:
    """Return the figures with their titles."""
    from rotor_ida.plot import drop_figure, drops_figure, system_figure  # noqa: PLC0415 - heavy
    from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415

    with without_pyplot():
        found = [("Radius, force and speeds", drop_figure(run)),
                 ("Orbits and forces", system_figure(run))]  # fmt: skip
        if drops is not None:
            found.append(("Distributions over many drops", drops_figure(drops)))
    return found


def _png(figure: Figure) -> str:
    """Return a figure as text for HTML."""
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=150)
    return base64.b64encode(written.getvalue()).decode()


def _lines(table: Listed) -> list[str]:
    """Return a table as lines of text."""
    rows = [table.heads, *table.rows]
    widths = [max(len(row[column]) for row in rows) for column in range(len(table.heads))]
    drawn = [
        "  ".join(
            cell.rjust(width) if column else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
    return [table.title, *([table.note] if table.note else []), *drawn, ""]


def _write_pdf(path: Path, text: Sequence[str], figures: Sequence[Figure]) -> None:
    """Write pages of text, then a page for each figure."""
    from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415 - heavy
    from matplotlib.figure import Figure as Page  # noqa: PLC0415

    lines = [part for line in text for part in _wrapped(line)]
    with PdfPages(path) as pages:
        for first in range(0, len(lines), LINES):
            page = Page(figsize=PAGE)
            part = lines[first : first + LINES]
            page.text(0.07, 0.96, "\n".join(part), va="top", family="monospace", fontsize=7.0,
                      parse_math=False)  # fmt: skip
            pages.savefig(page)
        for figure in figures:
            pages.savefig(figure)


def _wrapped(line: str, width: int = 110) -> list[str]:
    """Return a line of a page in parts that fit; a table is not wrapped at its columns."""
    import textwrap  # noqa: PLC0415 - only here

    if len(line) <= width:
        return [line]
    return textwrap.wrap(line, width, drop_whitespace=True, subsequent_indent="  ")


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
