"""A page that shows all figures in a folder of results: what each shows, and where it is from."""

from __future__ import annotations

import ast
import json
import re
import struct
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path

from rotor_ida.errors import InputError
from rotor_ida.paper.typesetting import typeset

RECORD = "figures.json"
PAGE = "index.html"

_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>rotor_ida: figures</title>
<style>
body { font: 17px/1.5 Georgia, "Times New Roman", serif; color: #1a1a1a; background: #fff;
  margin: 0 auto; max-width: 52rem; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; }
h2 { font-size: 1.25rem; line-height: 1.3; margin: 0 0 0.5rem; }
h3 { font-size: 1rem; margin: 2rem 0 0; }
section { border-top: 1px solid #c8c8c8; margin-top: 3rem; padding-top: 1.5rem; }
figure { margin: 0; }
img { max-width: 100%; height: auto; display: block; margin: 0.5rem auto; }
dl { display: grid; grid-template-columns: 4.5rem 1fr; gap: 0.3rem 0.8rem; margin: 0.8rem 0; }
dt { font-weight: bold; } dd { margin: 0; }
table { border-collapse: collapse; font-size: 0.95rem; line-height: 1.4; }
th, td { text-align: left; vertical-align: top; padding: 0.4rem 1rem 0.4rem 0;
  border-bottom: 1px solid #e4e4e4; }
td:first-child { white-space: nowrap; }
nav li { margin: 0.15rem 0; } .links, .failed { font-size: 0.9rem; }
.links a { margin-right: 1rem; } .failed { color: #bd1f01; } a { color: #1f5fa8; }
sup, sub { line-height: 0; font-size: 0.75em; }
@media (max-width: 40rem) {
  dl { display: block; } dd { margin-bottom: 0.4rem; }
  tr, td, th { display: block; border: 0; padding: 0; } thead { display: none; }
  tr { border-bottom: 1px solid #e4e4e4; padding: 0.5rem 0; }
  td:nth-child(2)::before { content: "Paper: "; font-weight: bold; }
  td:nth-child(3)::before { content: "Here: "; font-weight: bold; }
}
</style>
</head>
<body>
<h1>A rotor with Hertz contact in a clearance</h1>
<p>Every figure was computed by the script that is linked under it, from the archive beside it.
"Paper" is <cite>Analytical Nonlinear Response for a Rotor with the Hertz Contact and
Clearance</cite>, Mechanika 25(6), 2019.</p>
<p>Lengths are divided by the eccentricity <i>D</i> and times by 1/ω<sub>0</sub>, with
ω<sub>0</sub><sup>2</sup> = <i>k</i>√<i>D</i>/<i>m</i>: ω is the spin speed, ζ the damping ratio,
δ<sub>0</sub> the clearance, <i>A</i> the amplitude of a whirl at the spin speed. All formulas of
the paper that are wrong, with numbers: <code>python -m rotor_ida.paper.errata FILE</code>.</p>
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One figure of a scenario, in words.

    Parameters
    ----------
    figure : str
        Name of its files, without the ending.
    archives : tuple of str
        The archives that it was drawn from.
    shows : str
        What it shows, in a sentence.
    paper : str
        What the paper says; empty where it says nothing.
    found : str
        What is found here.
    verdict : str
        In a few words, what becomes of what the paper says; empty where it says nothing.
    """

    figure: str
    archives: tuple[str, ...]
    shows: str
    paper: str
    found: str
    verdict: str = ""


def add_entry(folder: Path, entry: Entry) -> None:
    """Put an entry into the record of a scenario's folder, in place of the one of its figure."""
    others = [each for each in read_entries(folder) if each.figure != entry.figure]
    text = json.dumps([asdict(each) for each in [*others, entry]], indent=1, ensure_ascii=False)
    (folder / RECORD).write_text(text + "\n", encoding="utf-8")


def read_entries(folder: Path) -> list[Entry]:
    """Return the record of a scenario's folder; empty where there is none.

    Raises
    ------
    InputError
        If the record is not one.
    """
    path = folder / RECORD
    if not path.is_file():
        return []
    try:
        listed = json.loads(path.read_text(encoding="utf-8"))
        return [Entry(**{**each, "archives": tuple(each["archives"])}) for each in listed]
    except (ValueError, TypeError, KeyError):
        raise InputError(f"the record of figures must be one, got {str(path)!r}") from None


def write_gallery(root: Path, scripts: Mapping[str, Path], *, failed: Iterable[str] = ()) -> Path:
    """Write ``index.html`` over the results of all scenarios in a folder.

    Parameters
    ----------
    root : Path
        The folder with one folder for each scenario.
    scripts : mapping of str to Path
        The scenario scripts by name, in the order wanted.
    failed : iterable of str
        Names of those that failed in this run: the page says so.

    Returns
    -------
    Path
        The page.

    Notes
    -----
    Plain HTML without scripts and with nothing from elsewhere; figures, archives and scripts
    are linked relative to the page, so that the folder can be moved.
    """
    down = set(failed)
    shown = [name for name in scripts if (root / name).is_dir() or name in down]
    links = "".join(
        f'<li><a href="#{escape(name)}">{typeset(_first_sentence(scripts[name]))}</a></li>\n'
        for name in shown
    )
    parts = [_HEAD, f"<nav><ul>\n{links}</ul></nav>\n", _summary(root, shown)]
    parts += [_section(root, name, scripts[name], name in down) for name in shown]
    root.mkdir(parents=True, exist_ok=True)
    page = root / PAGE
    page.write_text("".join([*parts, "</body>\n</html>\n"]), encoding="utf-8")
    return page


def _summary(root: Path, names: Iterable[str]) -> str:
    """Return the table of what the paper says and what becomes of it."""
    rows = [
        f'<tr><td><a href="#{_anchor(name, entry)}">{_caption(name, entry)}</a></td>'
        f"<td>{typeset(entry.paper)}</td><td>{typeset(entry.verdict)}</td></tr>\n"
        for name in names
        for entry in read_entries(root / name)
        if entry.verdict and _is_there(root / name, entry)
    ]
    if not rows:
        return ""
    head = "<thead><tr><th>Figure</th><th>Paper</th><th>Here</th></tr></thead>\n"
    return (
        '<section id="summary">\n<h2>What the paper says, and what is found</h2>\n'
        f"<table>\n{head}<tbody>\n{''.join(rows)}</tbody>\n</table>\n</section>\n"
    )


def _anchor(name: str, entry: Entry) -> str:
    return escape(f"{name}-{entry.figure}")


def _caption(name: str, entry: Entry) -> str:
    """Return what a figure is called: by its number in the paper, or by its scenario.

    Examples
    --------
    >>> def called(name, figure):
    ...     return _caption(name, Entry(figure=figure, archives=(), shows="", paper="", found=""))
    >>> called("fig02_03_force_potential", "eq13_energy"), called("fig07_basins", "fig07")
    ('Eq. (13), energy', 'Fig. 7')
    >>> called("fig08_09_whirls", "bouncing"), called("random_starts", "basin_fractions")
    ('Figs 8 and 9, bouncing', 'Random starts, shares')
    """
    numbered = re.fullmatch(r"(fig|eq)(\d+)_?(.*)", entry.figure)
    several = re.match(r"fig(\d+(?:_\d+)*)_", name)
    if numbered is not None:
        kind, number, rest = numbered.groups()
        title = f"Fig. {int(number)}" if kind == "fig" else f"Eq. ({int(number)})"
    elif several is not None:
        numbers = [str(int(number)) for number in several[1].split("_")]
        title = f"Fig{'s' if len(numbers) > 1 else '.'} {' and '.join(numbers)}"
        rest = entry.figure
    else:
        title = name.replace("_", " ").capitalize()
        rest = "" if name.endswith(entry.figure) else entry.figure
    return escape(f"{title}, {rest}".replace("_", " ") if rest else title)


def _section(root: Path, name: str, script: Path, failed: bool) -> str:
    """Return the part of the page that belongs to one scenario."""
    folder = root / name
    title = _first_sentence(script)
    parts = [f'<section id="{escape(name)}">\n<h2>{typeset(title)}</h2>\n']
    if failed:
        parts.append('<p class="failed">The script failed; what it left is shown.</p>\n')
    entries = read_entries(folder)
    told = {entry.figure for entry in entries}
    untold = [path.stem for path in sorted(folder.glob("*.png")) if path.stem not in told]
    archives = tuple(path.name for path in sorted(folder.glob("*.nc")))
    entries += [Entry(figure=stem, archives=archives, shows="", paper="", found="")
                for stem in untold]  # fmt: skip
    parts += [_figure(root, name, entry) for entry in entries if _is_there(folder, entry)]
    copied = f"{name}/{name}.py"
    if (root / copied).is_file():
        parts.append(f'<p class="links">Script: <a href="{escape(copied)}">{escape(name)}.py</a>')
        parts.append(' <a href="#summary">Back to the table</a></p>\n')
    return "".join([*parts, "</section>\n"])


def _is_there(folder: Path, entry: Entry) -> bool:
    return (folder / f"{entry.figure}.png").is_file()


def _size(picture: Path) -> str:
    """Return width and height of a PNG as attributes, so that the page keeps its place free."""
    with picture.open("rb") as file:
        head = file.read(24)
    if len(head) < 24:
        return ""
    width, height = struct.unpack(">II", head[16:])
    return f' width="{width}" height="{height}"'


def _figure(root: Path, name: str, entry: Entry) -> str:
    size = _size(root / name / f"{entry.figure}.png")
    stem = escape(f"{name}/{entry.figure}")
    words = entry.shows or entry.figure
    parts = [
        f'<h3 id="{_anchor(name, entry)}">{_caption(name, entry)}</h3>\n<figure>\n'
        f'<a href="{stem}.svg"><img src="{stem}.png" alt="{escape(words)}"{size} loading="lazy">'
        "</a>\n<dl>"
    ]
    for term, text in (("Shows", words), ("Paper", entry.paper), ("Found", entry.found)):
        if text:
            parts.append(f"<dt>{term}</dt><dd>{typeset(text)}</dd>")
    files = [f"{entry.figure}.png", f"{entry.figure}.svg", *entry.archives]
    links = "".join(f'<a href="{escape(f"{name}/{file}")}">{escape(file)}</a> ' for file in files)
    return "".join([*parts, f'</dl>\n<p class="links">{links}</p>\n</figure>\n'])


def _first_sentence(script: Path) -> str:
    """Return the first line of a script's docstring, or its name."""
    try:
        words = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8")))
    except (OSError, SyntaxError):
        words = None
    return words.splitlines()[0].rstrip(".") if words else script.stem
