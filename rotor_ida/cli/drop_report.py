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

from rotor_ida.cli.drop_grids import place_of, places_in
from rotor_ida.cli.drop_tables import (
    Listed,
    acceptance,
    drops_tables,
    given_tables,
    number,
    read_in,
    run_tables,
)
from rotor_ida.cli.report import shown
from rotor_ida.results.depths import beyond_model
from rotor_ida.results.files import file_to_write
from rotor_ida.results.question import Question
from rotor_ida.results.toml_files import read_toml
from rotor_ida.steady.drop_figures import touched_clearances
from rotor_ida.texts import printable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Drop on touchdown bearings"
NOT_ACTING = "a touch there does not act on the rotor"
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
    parts: dict[str, Any] = {
        "title": TITLE, "head": _head(run, system), "summary": sentence_of(run, drops),
        "answers": [allowed] if allowed else [], "tables": tables,
        "assumptions": ASSUMPTIONS, "scope": SCOPE,
        "commands": _commands(folder, system, options),
        "versions": [*_versions(run), *_rotor_file(system)],
        "system": str(system), "source": _source(system),
        "figures": [(title, _png(figure)) for title, figure in _figures(run, drops)],
    }  # fmt: skip
    html, pdf = folder / "report.html", folder / "report.pdf"
    with file_to_write("out", html, overwrite=overwrite) as part:
        part.write_text(_page(parts), encoding="utf-8")
    with file_to_write("out", pdf, overwrite=overwrite) as part, boxes_for_letters():
        _write_pdf(part, parts)
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


def _versions(run: xr.Dataset) -> list[tuple[str, str]]:
    """Return what computed the drop."""
    return [(name.removesuffix("_version").replace("_", " "), shown(_plain(run.attrs[name])))
            for name in VERSIONS if name in run.attrs]  # fmt: skip


def sentence_of(run: xr.Dataset, drops: xr.Dataset | None) -> str:
    """Return in words whether the drop is survived, as far as figures say."""
    forces, nodes = run["largest_force"].values, run["contact_node"].values
    worst = int(forces.argmax())
    unit, parts = read_in(str(run["largest_force"].attrs.get("units", "")), forces)
    said = [
        f"The largest force of this drop is {number(parts * forces[worst])} {unit}".strip()
        + f", in the bearing at {str(nodes[worst])!r}; the rotor goes as far as "
        f"{float(run['excursion'].max()):.3g} clearances."
        if forces[worst] > 0.0
        else "In this drop the rotor touches no bearing.",
    ]
    if "load_ratio" in run.variables:
        percent = number(100.0 * float(run["load_ratio"].max()), 3)
        said.append(f"Loads reach {percent} % of the load capacities that were given.")
    if (run["whirl_sense"].values < 0).any():
        said.append("It whirls backwards for three turns or more.")
    if np.isfinite(run["rest_time"].values).all():
        said.append(f"It stays in contact from {number(1e3 * float(run['rest_time'].max()), 3)} "
                    "ms on.")  # fmt: skip
    horizon, end = 1e3 * float(run["horizon"]), 1e3 * float(run["t"][-1])
    if horizon < end:
        said.append(
            f"After {number(horizon, 3)} of {number(end, 3)} ms this one motion depends on "
            "rounding: what follows is one of many possible ones."
        )
    if touched := touched_clearances(run):
        said.append(f"It touches {_clearances_at(touched)}; {NOT_ACTING}.")
    said += [] if drops is None else _of_many(drops, parts, unit)
    warned = [beyond_model(each) for each in (drops, run) if each is not None]
    said += list(filter(None, warned))[:1]
    said += [f"Note: {run.attrs['note']}."] if "note" in run.attrs else []
    return " ".join(said)


def _of_many(drops: xr.Dataset, parts: float, unit: str) -> list[str]:
    """Return what many drops say in words."""
    count, forces = drops.sizes["drop"], drops["largest_force"].values
    if not np.isfinite(forces).any():
        return [f"All {count} drops failed."]
    most = f"{number(parts * float(np.nanmax(forces)))} {unit}".strip()
    touched = touched_clearances(drops)
    others = [f"Some drops touch {_clearances_at(touched)}."] if touched else []
    facts = [_share(drops, "backward_whirl", "whirl backwards")]
    if "overload_fraction" in drops.variables:
        facts.append(_share(drops, "overload", "exceed the load capacity of a bearing"))
    if "cell" in drops.sizes:
        at = place_of(drops, int(np.nanargmax(forces)) // forces.shape[1])
        where = f", at {places_in(drops)} = {at}" if at else ""
        return [f"Over a grid of {count} drops the largest force is {most}{where}. "
                f"Of the grid {' and '.join(facts)}.", *others]  # fmt: skip
    return [f"Of {count} drops the largest force is {most}; {' and '.join(facts)} "
            "(95 % intervals).", *others]  # fmt: skip


def _clearances_at(nodes: Sequence[str]) -> str:
    """Return the close clearances at nodes in words."""
    names = [repr(each) for each in nodes]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    return f"the close clearance{'s' if len(names) > 1 else ''} at {listed}"


def _share(drops: xr.Dataset, name: str, words: str) -> str:
    """Return the share of drops in the bearing where it is largest, in words."""
    values = drops[f"{name}_fraction"].values
    own = drops.isel(contact=int(np.nanargmax(values)))
    share = number(100.0 * float(own[f"{name}_fraction"]), 3)
    if "cell" in drops.sizes:
        return f"{share} % {words}"
    low, high = (100.0 * float(own[f"{name}_fraction_{end}"]) for end in ("low", "high"))
    return f"{share} % ({number(low, 3)} to {number(high, 3)} %) {words}"


def _rotor_file(system: Path) -> list[tuple[str, str]]:
    """Return name and digest of the file from which a system file takes the rotor, if it does."""
    table = read_toml("system", system).get("system") if system.is_file() else None
    name = table.get("file") if isinstance(table, Mapping) else None
    path = system.parent / str(name)
    if name is None or not path.is_file():  # matrices may be files in a folder
        return []
    return [(f"SHA-256 of {name}", hashlib.sha256(path.read_bytes()).hexdigest())]


def _source(system: Path) -> str:
    """Return the text of a system file, without which a reader cannot compute it again."""
    text = system.read_text(encoding="utf-8") if system.is_file() else ""
    return text if len(text) <= LONGEST_FILE else f"{text[:LONGEST_FILE]}\n..."


def _figures(run: xr.Dataset, drops: xr.Dataset | None) -> list[tuple[str, Figure]]:
    """Return the figures with their titles."""
    from rotor_ida.plot import drop_figure, drops_figure, system_figure  # noqa: PLC0415 - heavy
    from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415

    with without_pyplot():
        found = [("One drop: radius, force and speeds", drop_figure(run)),
                 ("One drop: orbits and forces", system_figure(run))]  # fmt: skip
        if drops is not None:
            words = (
                "Grid: ranges (shaded) and means (dots)"
                if "cell" in drops.sizes
                else "Distributions over many drops"
            )
            found.append((words, drops_figure(drops)))
    return found


def _png(figure: Figure) -> bytes:
    """Return a figure as a picture."""
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=RESOLUTION)
    return written.getvalue()


def _page(parts: dict[str, Any]) -> str:
    """Return the report as HTML that needs no other file."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - heavy

    environment = Environment(
        loader=PackageLoader("rotor_ida", "cli"), undefined=StrictUndefined, autoescape=True,
        finalize=lambda value: printable(value) if isinstance(value, str) else value,
    )  # fmt: skip
    figures = [{"title": title, "png": base64.b64encode(png).decode()}
               for title, png in parts["figures"]]  # fmt: skip
    template = environment.get_template("drop_report.html.jinja")
    return template.render(**parts | {"figures": figures})


def _write_pdf(path: Path, parts: dict[str, Any]) -> None:
    """Write the report as PDF."""
    from rotor_ida.cli.drop_pdf import TITLE as SIZE  # noqa: PLC0415 - heavy
    from rotor_ida.cli.drop_pdf import Sheets  # noqa: PLC0415

    sheets = Sheets(TITLE)
    sheets.heading(TITLE, SIZE)
    for words in (parts["head"], parts["summary"]):
        sheets.paragraph(words)
    for table in parts["answers"]:
        sheets.table(table)
    for title, png in parts["figures"]:
        sheets.picture(title, png)
    for table in parts["tables"]:
        sheets.table(table)
    for title, name in (("What is assumed", "assumptions"), ("What is reported", "scope")):
        sheets.heading(title)
        for words in parts[name]:
            sheets.paragraph(words, bullet=name == "assumptions")
    sheets.heading("Compute it again")
    sheets.file("\n".join(parts["commands"]))
    sheets.table(Listed("Versions", ["", "version"], [list(each) for each in parts["versions"]]))
    if parts["source"]:
        sheets.heading(f"System file {parts['system']}")
        sheets.file(parts["source"])
    sheets.write(path)


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
