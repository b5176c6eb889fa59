"""The report on a drop: one page of HTML and a PDF, with figures, tables, and how to repeat it."""

from __future__ import annotations

import base64
import io
import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rotor_ida.cli.report import shown
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
VERSIONS = ("rotor_ida_version", "python_version", "numpy_version", "scipy_version",
            "xarray_version", "core_compiler", "core_level", "method", "rtol",
            "date_created")  # fmt: skip
# Size of an A4 page [inch], its lines and columns of text.
PAGE, LINES, COLUMNS = (8.27, 11.69), 84, 132
# Units in which an engineer reads a figure, with its parts and the size from which it is used.
READ_IN = {
    "s": [("ms", 1e3, 0.0), ("s", 1.0, 10.0)],
    "s-1": [("rpm", 60.0 / math.tau, 0.0)],
    "m": [("µm", 1e6, 0.0), ("mm", 1e3, 1e-2)],
    "N": [("N", 1.0, 0.0), ("kN", 1e-3, 1e3)],
    "J": [("J", 1.0, 0.0), ("kJ", 1e-3, 1e4)],
}
WORDS = {
    "excursion": "largest radius over clearance", "contact_count": "number of contacts",
    "node_clearance": "clearance", "node_excursion": "largest radius over clearance",
    "total_contact_loss": "loss by contact damping", "total_heat": "heat of friction",
    "rest_time": "in contact to the end from", "first_roll_time": "first rolling at",
    "largest_force_time": "largest force at", "race_speed_time": "largest race speed at",
}  # fmt: skip
# Parameters of the bearings and their mounts, and what may vary between drops.
OF_CONTACTS = {
    "law_stiffness": "contact stiffness [N/m^exponent]", "law_exponent": "exponent",
    "law_damping": "contact damping [s/m]", "law_friction": "friction", "law_radius": "radius [m]",
    "race_radius": "radius of the race [m]", "race_inertia": "inertia of the race [kg m2]",
    "race_drag": "drag of the race [N m s]",
}  # fmt: skip
OF_STATORS = {
    "stator_mass": "mass of the mount [kg]", "stator_stiffness": "stiffness of the mount [N/m]",
    "stator_damping": "damping of the mount [N s/m]",
}  # fmt: skip
VARIED = {
    "drop_phase": "angle of the rotor [rad]", "drop_friction": "friction",
    "drop_contact_damping": "contact damping [s/m]",
    "drop_unbalance_factor": "factor of the unbalance",
    "drop_clearance_factor": "factor of the clearances",
}  # fmt: skip
# Longest system file that is printed [characters].
LONGEST_FILE = 20_000


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
    folder: Path,
    system: Path,
    run: xr.Dataset,
    drops: xr.Dataset | None,
    options: Sequence[str] = (),
) -> list[Path]:
    """Write the pages of a report, computed with options, into a folder; return them."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - heavy

    tables = [*given_tables(run, drops), _of_run(run), *_of_clearances(run),
              *([] if drops is None else _of_drops(drops))]  # fmt: skip
    figures = _figures(run, drops)
    commands = [shlex.join(["rotor-ida", "drop", str(system), "--out", str(folder), *options]),
                f"rotor-ida verify {shlex.quote(str(folder / 'drop.nc'))}"]  # fmt: skip
    versions = [(name.removesuffix("_version").replace("_", " "), shown(_plain(run.attrs[name])))
                for name in VERSIONS if name in run.attrs]  # fmt: skip
    summary, source = sentence_of(run, drops), _source(system)
    environment = Environment(
        loader=PackageLoader("rotor_ida", "cli"), undefined=StrictUndefined, autoescape=True
    )
    page = environment.get_template("drop_report.html.jinja").render(
        title=TITLE, summary=summary, tables=tables, assumptions=ASSUMPTIONS, commands=commands,
        versions=versions, system=str(system), source=source,
        figures=[{"title": title, "png": _png(figure)} for title, figure in figures],
    )  # fmt: skip
    html, pdf = folder / "report.html", folder / "report.pdf"
    html.write_text(page, encoding="utf-8")
    text = [TITLE, "", summary, ""]
    for table in tables:
        text += _lines(table)
    text += ["What is assumed", *(f"- {each}" for each in ASSUMPTIONS), "", "Compute it again",
             *commands, "", *(f"{name}: {value}" for name, value in versions),
             "", f"System file {system}", *source.splitlines()]  # fmt: skip
    _write_pdf(pdf, text, [figure for _, figure in figures])
    return [html, pdf]


def _source(system: Path) -> str:
    """Return the text of a system file, without which a reader cannot compute it again."""
    text = system.read_text(encoding="utf-8") if system.is_file() else ""
    return text if len(text) <= LONGEST_FILE else f"{text[:LONGEST_FILE]}\n..."


def read_in(unit: str, values: npt.ArrayLike) -> tuple[str, float]:
    """Return the unit in which an engineer reads values, and its parts.

    Examples
    --------
    >>> read_in("N", [20.0, 1500.0]), read_in("s-1", [np.nan])[0], read_in("N m", [1.0])
    (('kN', 0.001), 'rpm', ('N m', 1.0))
    """
    base, *rest = unit.split(" ")
    if base not in READ_IN or rest not in ([], ["s"]) or (rest and base != "N"):
        return unit.removeprefix("1"), 1.0
    sizes = np.abs(np.asarray(values, float))
    largest = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
    name, parts = next((word, parts) for word, parts, least in reversed(READ_IN[base])
                       if largest >= least)  # fmt: skip
    return " ".join([name, *rest]), parts


def _row(dataset: xr.Dataset, name: str, digits: int = 4) -> list[str]:
    """Return a figure of the bearings as a row, with its name and unit."""
    values = dataset[name].values
    unit, parts = read_in(str(dataset[name].attrs.get("units", "")), values)
    return [_head(name, unit), *(shown(_plain(each * parts if parts != 1.0 else each), digits)
                                 for each in values)]  # fmt: skip


def _head(name: str, unit: str) -> str:
    words = WORDS.get(name, name.replace("_", " "))
    return f"{words} [{unit}]" if unit else words


def sentence_of(run: xr.Dataset, drops: xr.Dataset | None) -> str:
    """Return in words whether the drop is survived, as far as figures say."""
    forces, nodes = run["largest_force"].values, run["contact_node"].values
    worst = int(forces.argmax())
    unit, parts = read_in(str(run["largest_force"].attrs.get("units", "")), forces)
    force = f"{parts * forces[worst]:.4g} {unit}".strip()
    said = [
        f"The largest force of this drop is {force}, in the bearing at {str(nodes[worst])!r}; the "
        f"rotor goes as far as {float(run['excursion'].max()):.3g} clearances.",
    ]
    senses = run["whirl_sense"].values
    if (senses < 0).any():
        said.append("It whirls backwards for three turns or more.")
    if np.isfinite(run["rest_time"].values).all():
        said.append(f"It stays in contact from {1e3 * float(run['rest_time'].max()):.3g} ms on.")
    horizon, end = float(run["horizon"]), float(run["t"][-1])
    if horizon < end:
        said.append(
            f"After {1e3 * horizon:.3g} of {1e3 * end:.3g} ms this one motion depends on rounding: "
            "what follows is one of many possible ones."
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


def given_tables(run: xr.Dataset, drops: xr.Dataset | None) -> list[Listed]:
    """Return what the drops were computed from: conditions, supports, bearings and what varies."""
    found = [_conditions(run), _bearings(run)]
    if run.sizes["support"]:
        heads = ["", *(str(each) for each in run["support_node"].values)]
        rows = [[f"{words} {axis} [{unit}]", *(shown(float(each), 4) for each in values)]
                for name, words, unit in (("support_stiffness", "stiffness", "N/m"),
                                          ("support_damping", "damping", "N s/m"),
                                          ("support_load", "static load", "N"))
                for axis, values in zip("xy", run[name].values.T, strict=True)]  # fmt: skip
        rows.append(["fails", *("yes" if each else "no" for each in run["support_fails"].values)])
        found.insert(1, Listed("Magnetic bearings", heads, rows))
    if drops is not None:
        rows = [[words, shown(float(values.min()), 4), shown(float(values.max()), 4)]
                for name, words in VARIED.items() if name in drops.variables
                for values in [drops[name].values]]  # fmt: skip
        drawn = f"drawn at random with seed {drops.attrs['seed']}" if "seed" in drops.attrs else ""
        title = f"What varies in {drops.sizes['drop']} drops"
        found.append(Listed(title, ["", "smallest", "largest"], rows, drawn.capitalize()))
    return found


def _conditions(run: xr.Dataset) -> Listed:
    """Return the conditions of one drop."""
    speed = float(run.attrs.get("start_speed", run.attrs.get("speed", math.nan)))
    rows = [["speed at the drop [rpm]", shown(speed * 60.0 / math.tau, 5)],
            ["duration [ms]", shown(1e3 * float(run.attrs["duration"]), 5)],
            ["determined by the parameters up to [ms]", shown(1e3 * float(run["horizon"]), 5)],
            ["angle of the rotor at the drop [deg]",
             shown(math.degrees(float(run.attrs["phase"])), 4)]]  # fmt: skip
    if "inertia" in run.attrs:
        drag = float(np.ravel(run.attrs["torque"])[1])
        rows += [["inertia about the axis [kg m2]", shown(float(run.attrs["inertia"]), 4)],
                 ["drag over speed [N m s]", shown(drag, 4)]]  # fmt: skip
    angles = np.degrees(run["unbalance_phase"].values) - math.degrees(float(run.attrs["phase"]))
    for node, moment, angle in zip(run["unbalance_node"].values, run["unbalance_moment"].values,
                                   angles, strict=True):  # fmt: skip
        rows.append([f"unbalance at {node!s} [g mm, deg]",
                     f"{shown(1e6 * float(moment), 4)}, {shown(float(angle), 4)}"])  # fmt: skip
    return Listed("Conditions", ["", "value"], rows)


def _bearings(run: xr.Dataset) -> Listed:
    """Return the touchdown bearings."""
    heads = ["", *(str(each) for each in run["contact_node"].values)]
    rows = [["clearance [µm]", *(shown(1e6 * float(each), 4) for each in run["clearance"].values)]]
    for name, words in OF_CONTACTS.items():
        values = run[name].values if name in run.variables else np.array([math.nan])
        if np.isfinite(values).any():
            rows.append([words, *(shown(float(each), 4) for each in values)])
    places = run["stator_number"].values
    for name, words in OF_STATORS.items() if (places >= 0).any() else ():
        values = run[name].values.reshape(run.sizes["stator"], -1)[:, 0]
        rows.append([words, *(shown(float(values[each]), 4) if each >= 0 else "-"
                              for each in places)])  # fmt: skip
    return Listed("Touchdown bearings", heads, rows)


def _of_run(run: xr.Dataset) -> Listed:
    """Return what one drop delivers by bearing."""
    heads = ["", *(str(each) for each in run["contact_node"].values)]
    rows = [_row(run, name) for name in OF_BEARING]
    standstill = 1e3 * float(run["standstill_time"])
    note = f"Standstill after {standstill:.4g} ms." if np.isfinite(standstill) else ""
    return Listed("One drop: figures by bearing", heads, rows, note)


def _of_clearances(run: xr.Dataset) -> list[Listed]:
    """Return the motion over other close clearances."""
    if "node_excursion" not in run.variables:
        return []
    own = run.isel(node=np.isfinite(run["node_excursion"].values))
    heads = ["", *(str(each) for each in own["node"].values)]
    rows = [_row(own, name) for name in ("node_clearance", "largest_radius", "node_excursion")]
    return [Listed("Other close clearances", heads, rows, "A ratio above 1 is a touch there.")]


def _of_drops(drops: xr.Dataset) -> list[Listed]:
    """Return the distributions over many drops, a table for each bearing."""
    if "quantile" not in drops.sizes:
        return []
    tables = []
    levels = [f"{100.0 * each:g} %" for each in drops["quantile"].values]
    failed = int((drops["status"].values != 0).sum())
    lost = f"{failed} drops failed and are left out. " if failed else ""
    for number, node in enumerate(drops["contact_node"].values):
        own = drops.isel(contact=number)
        rows = []
        for name in OF_BEARING:
            unit, parts = read_in(str(own[name].attrs.get("units", "")), own[name].values)
            ends = [parts * own[f"{name}_quantile{end}"].values for end in ("", "_low", "_high")]
            mean = [parts * float(own[f"{name}_mean{end}"]) for end in ("", "_low", "_high")]
            cells = [_with_interval(*each) for each in [mean, *zip(*ends, strict=True)]]
            rows.append([_head(name, unit), *cells])
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
                             ["", "mean", *levels], rows,
                             f"{lost}{note}. In brackets 95 % intervals."))  # fmt: skip
    return tables


def _with_interval(value: float, low: float, high: float) -> str:
    """Return a value with its interval, of which an end may be unknown.

    Examples
    --------
    >>> _with_interval(2.0, 1.0, 3.5), _with_interval(2.0, -np.inf, 3.0)
    ('2 (1 to 3.5)', '2 (below 3)')
    >>> _with_interval(2.0, 1.0, np.inf), _with_interval(2.0, -np.inf, np.inf)
    ('2 (above 1)', '2 (unknown)')
    """
    if math.isnan(value):
        return "-"
    first, last = shown(float(low), 4), shown(float(high), 4)
    known = math.isfinite(low), math.isfinite(high)
    words = {(True, True): f"{first} to {last}", (False, True): f"below {last}",
             (True, False): f"above {first}", (False, False): "unknown"}  # fmt: skip
    return f"{shown(float(value), 4)} ({words[known]})"


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
    """Return a table as lines of text, in blocks of as many columns as fit on a page."""
    rows = [table.heads, *table.rows]
    widths = [max(len(row[column]) for row in rows) for column in range(len(table.heads))]
    found = [table.title, *([table.note] if table.note else [])]
    columns = list(range(1, len(widths)))
    while columns:
        ends = np.cumsum([widths[0], *(2 + widths[each] for each in columns)])
        fitting = max(1, int((ends <= COLUMNS).sum()) - 1)
        for row in rows:
            cells = (row[each].rjust(widths[each]) for each in columns[:fitting])
            found.append("  ".join([row[0].ljust(widths[0]), *cells]))
        found.append("")
        columns = columns[fitting:]
    return found


def _write_pdf(path: Path, text: Sequence[str], figures: Sequence[Figure]) -> None:
    """Write pages of text, then a page for each figure."""
    from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415 - heavy

    lines = [part for line in text for part in _wrapped(line)]
    firsts = range(0, len(lines), LINES)
    with PdfPages(path) as pages:
        for number, first in enumerate(firsts, 1):
            foot = f"{TITLE}, page {number} of {len(firsts)}"
            pages.savefig(text_page(lines[first : first + LINES], foot))
        for figure in figures:
            pages.savefig(figure)


def text_page(lines: Sequence[str], foot: str) -> Figure:
    """Return a page of text."""
    from matplotlib.figure import Figure as Page  # noqa: PLC0415 - heavy

    page = Page(figsize=PAGE)
    for height, words in ((0.96, "\n".join(lines)), (0.03, foot)):
        page.text(0.06, height, words, va="top", family="monospace", fontsize=6.2,
                  parse_math=False)  # fmt: skip
    return page


def _wrapped(line: str, width: int = COLUMNS) -> list[str]:
    """Return a line of a page in parts that fit; a table is not wrapped at its columns."""
    import textwrap  # noqa: PLC0415 - only here

    if len(line) <= width:
        return [line]
    return textwrap.wrap(line, width, drop_whitespace=True, subsequent_indent="  ")


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
