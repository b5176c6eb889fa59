"""A page that shows all figures in a folder of results: what each shows, and where it is from."""

from __future__ import annotations

import ast
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path

from rotor_ida.errors import InputError

RECORD = "figures.json"
PAGE = "index.html"

_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>rotor_ida: figures</title>
<style>
body { font: 17px/1.5 Georgia, serif; color: #1a1a1a; background: #fff; margin: 0 auto;
  max-width: 52rem; padding: 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin: 2.5rem 0 0.3rem; }
img { width: 100%; height: auto; display: block; margin: 1rem 0 0.5rem; }
dl { margin: 0.5rem 0; } dt { font-weight: bold; } dd { margin: 0 0 0.4rem; }
nav a { margin-right: 1rem; white-space: nowrap; } .links, .failed { font-size: 0.9rem; }
.links a { margin-right: 1rem; } .failed { color: #bd1f01; } a { color: #1f5fa8; }
</style>
</head>
<body>
<h1>A rotor with Hertz contact in a clearance</h1>
<p>Every figure was computed by the script that is linked under it, from the archive beside it.
"Paper" is <cite>Analytical Nonlinear Response for a Rotor with the Hertz Contact and
Clearance</cite>, Mechanika 25(6), 2019.</p>
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
    """

    figure: str
    archives: tuple[str, ...]
    shows: str
    paper: str
    found: str


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
    links = "".join(f'<a href="#{escape(name)}">{escape(name)}</a> ' for name in shown)
    parts = [_HEAD, f"<nav>{links}</nav>\n"]
    parts += [_section(root, name, scripts[name], name in down) for name in shown]
    root.mkdir(parents=True, exist_ok=True)
    page = root / PAGE
    page.write_text("".join([*parts, "</body>\n</html>\n"]), encoding="utf-8")
    return page


def _section(root: Path, name: str, script: Path, failed: bool) -> str:
    """Return the part of the page that belongs to one scenario."""
    folder = root / name
    title = _first_sentence(script)
    parts = [f'<section id="{escape(name)}">\n<h2>{escape(title)}</h2>\n']
    if failed:
        parts.append('<p class="failed">The script failed; what it left is shown.</p>\n')
    entries = read_entries(folder)
    told = {entry.figure for entry in entries}
    untold = [path.stem for path in sorted(folder.glob("*.png")) if path.stem not in told]
    archives = tuple(path.name for path in sorted(folder.glob("*.nc")))
    entries += [Entry(figure=stem, archives=archives, shows="", paper="", found="")
                for stem in untold]  # fmt: skip
    parts += [_figure(name, entry) for entry in entries if _is_there(folder, entry)]
    copied = f"{name}/{name}.py"
    if (root / copied).is_file():
        parts.append(f'<p class="links">Script: <a href="{escape(copied)}">{escape(name)}.py</a>')
        parts.append("</p>\n")
    return "".join([*parts, "</section>\n"])


def _is_there(folder: Path, entry: Entry) -> bool:
    return (folder / f"{entry.figure}.png").is_file()


def _figure(name: str, entry: Entry) -> str:
    stem = escape(f"{name}/{entry.figure}")
    words = entry.shows or entry.figure
    parts = [
        f'<figure style="margin:0">\n<a href="{stem}.svg">'
        f'<img src="{stem}.png" alt="{escape(words)}" loading="lazy"></a>\n<dl>'
    ]
    for term, text in (("Shows", words), ("Paper", entry.paper), ("Found", entry.found)):
        if text:
            parts.append(f"<dt>{term}</dt><dd>{escape(text)}</dd>")
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
