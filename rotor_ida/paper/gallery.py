"""Gallery page of all figures in a folder of results, with captions and sources."""

from __future__ import annotations

import ast
import json
import re
import struct
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rotor_ida.checks import shown
from rotor_ida.errors import InputError

RECORD = "figures.json"
PAGE = "index.html"
TEMPLATE = "gallery.html.jinja"


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """Texts of one figure of a scenario.

    Parameters
    ----------
    figure : str
        Name of its files, without the ending.
    archives : tuple of str
        The archives that it was drawn from.
    shows : str
        Caption, in a sentence.
    paper : str
        Statement of the paper; empty if it makes none.
    found : str
        Result found here.
    verdict : str
        Verdict on the statement of the paper, in a few words; empty if it makes none.
    """

    figure: str
    archives: tuple[str, ...]
    shows: str
    paper: str
    found: str
    verdict: str = ""


def add_entry(folder: Path, entry: Entry) -> None:
    """Write an entry to the record of a scenario's folder, replacing that of its figure."""
    others = [each for each in read_entries(folder) if each.figure != entry.figure]
    text = json.dumps([asdict(each) for each in [*others, entry]], indent=1, ensure_ascii=False)
    (folder / RECORD).write_text(text + "\n", encoding="utf-8")


def read_entries(folder: Path) -> list[Entry]:
    """Return the record of a scenario's folder; empty if there is none.

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
        raise InputError(f"the record of figures must be one, got {shown(path)}") from None


def write_gallery(root: Path, scripts: Mapping[str, Path], *, failed: Iterable[str] = ()) -> Path:
    """Write ``index.html`` over the results of all scenarios in a folder.

    Parameters
    ----------
    root : Path
        The folder with one folder for each scenario.
    scripts : mapping of str to Path
        The scenario scripts by name, in the order wanted.
    failed : iterable of str
        Names of those that failed in this run, which the page reports.

    Returns
    -------
    Path
        The page.

    Notes
    -----
    The page is plain HTML without scripts or external content. Figures, archives and scripts are
    linked relative to the page, so the folder can be moved.
    """
    down = set(failed)
    scenarios: list[dict[str, Any]] = [
        {
            "name": name, "title": _first_sentence(script), "failed": name in down,
            "figures": _figures(root / name),
            "has_script": (root / name / f"{name}.py").is_file(),
        }
        for name, script in scripts.items()
        if (root / name).is_dir() or name in down
    ]  # fmt: skip
    figures = [shown for each in scenarios for shown in each["figures"]]
    verdicts = [shown for shown in figures if shown["entry"].verdict]
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    text = templates.get_template(TEMPLATE).render(scenarios=scenarios, verdicts=verdicts)
    root.mkdir(parents=True, exist_ok=True)
    page = root / PAGE
    page.write_text(text + "\n", encoding="utf-8")
    return page


def _figures(folder: Path) -> list[dict[str, Any]]:
    """Return the figures in the folder of a scenario, those without texts last.

    Each has its entry, place, caption, description, files, and size in pixels.
    """
    entries = read_entries(folder)
    told = {entry.figure for entry in entries}
    archives = tuple(path.name for path in sorted(folder.glob("*.nc")))
    entries += [
        Entry(figure=path.stem, archives=archives, shows="", paper="", found="")
        for path in sorted(folder.glob("*.png"))
        if path.stem not in told
    ]
    return [
        {
            "entry": entry, "anchor": f"{folder.name}-{entry.figure}",
            "caption": caption_of(folder.name, entry.figure), "words": entry.shows or entry.figure,
            "files": (f"{entry.figure}.png", f"{entry.figure}.svg", *entry.archives),
            "size": _size(picture),
        }
        for entry in entries
        if (picture := folder / f"{entry.figure}.png").is_file()
    ]  # fmt: skip


def caption_of(name: str, figure: str) -> str:
    """Return the caption of a figure, from its number in the paper or its scenario.

    Examples
    --------
    >>> caption_of("fig02_03_force_potential", "eq13_energy"), caption_of("fig07_basins", "fig07")
    ('Eq. (13), energy', 'Fig. 7')
    >>> caption_of("fig08_09_whirls", "bouncing"), caption_of("random_starts", "basin_fractions")
    ('Figs 8 and 9, bouncing', 'Random starts, basin fractions')
    """
    numbered = re.fullmatch(r"(fig|eq)(\d+)_?(.*)", figure)
    several = re.match(r"fig(\d+(?:_\d+)*)_", name)
    if numbered is not None:
        kind, number, rest = numbered.groups()
        title = f"Fig. {int(number)}" if kind == "fig" else f"Eq. ({int(number)})"
    elif several is not None:
        numbers = [str(int(number)) for number in several[1].split("_")]
        title = f"Fig{'s' if len(numbers) > 1 else '.'} {' and '.join(numbers)}"
        rest = figure
    else:
        title = name.replace("_", " ").capitalize()
        rest = "" if name.endswith(figure) else figure
    return f"{title}, {rest}".replace("_", " ") if rest else title


def _size(picture: Path) -> tuple[int, int] | None:
    """Return width and height of a PNG, so that the page reserves its space."""
    with picture.open("rb") as file:
        head = file.read(24)
    if len(head) < 24:
        return None
    width, height = struct.unpack(">II", head[16:])
    return width, height


def _first_sentence(script: Path) -> str:
    """Return the first line of a script's docstring, or its name."""
    try:
        words = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8")))
    except (OSError, SyntaxError):
        words = None
    return words.splitlines()[0].rstrip(".") if words else script.stem
