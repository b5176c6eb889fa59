"""An archive of any result as the page shows it: its tables, its figure, a run-up by its track."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays
from rotor_ida.errors import InputError
from rotor_ida.explorer.measured import track_of
from rotor_ida.explorer.messages import Answer, Asked, named
from rotor_ida.results.archive import load
from rotor_ida.results.dataset_kinds import KINDS, kind_of
from rotor_ida.results.dataset_kinds import loaded as described
from rotor_ida.results.sheets import sheets_shown
from rotor_ida.results.si_units import is_in_si

# Kinds of results that are played, and the panels of a run-up.
PLAYED = ("system_run", "drop")
OF_RUN_UP = ("bode", "polar", "cascade")
KINDS_OF_SCALES = ("length", "time", "velocity", "force", "energy", "rate")
# Rows of a table of an archive, and what its title says of the others where it is printed.
MOST_ROWS, IN_COMMAND = 20, " (all with --json)"


def loaded(path: Path) -> xr.Dataset:
    """Return the result in an archive."""
    try:
        return load(path)
    except (OSError, ValueError) as error:
        raise InputError(str(error)) from error


@lru_cache(maxsize=2)
def archived_in(path: Path, _changed: int) -> xr.Dataset:
    """Return the result in an archive; a newer version of the file is read again."""
    return loaded(path)


def archive_of(question: Asked) -> xr.Dataset | None:
    """Return the result in the file of a question, if it is an archive."""
    path = question.path
    if path is None or path.suffix.lower() == ".toml":
        return None
    with named(path):
        return archived_in(path, path.stat().st_mtime_ns)


def scales_where(in_si: bool) -> dict[str, float]:
    """Return the scales of answers in SI units, which are 1; none without dimensions."""
    return dict.fromkeys(KINDS_OF_SCALES, 1.0) if in_si else {}


def sheets_of(result: xr.Dataset) -> list[dict[str, Any]]:
    """Return the tables of a result, as the command line prints them."""
    _, parts = described(KINDS[kind_of(result)].shown)(result, MOST_ROWS)
    return [each | {"title": each["title"].replace(IN_COMMAND, "")} for each in sheets_shown(parts)]


@lru_cache(maxsize=2)
def archived_answers(path: Path, changed: int) -> list[Answer]:
    """Return the tables and the figure of any result, and order 1 and the cascade of a run-up."""
    result = archived_in(path, changed)
    kind = kind_of(result)
    told: dict[str, object] = {
        "name": path.name, "kind": KINDS[kind].meaning,
        "sheets": sheets_of(result),
        "panels": [] if kind in PLAYED else ["archive"],
    }  # fmt: skip
    arrays: Arrays = {}
    if KINDS[kind].drawn:
        from rotor_ida.explorer.files import figure_in  # noqa: PLC0415 - matplotlib is slow to import

        contents = figure_in(result, "svg")
        arrays["figure"] = np.frombuffer(contents, dtype=np.int8)
    if kind != "run":
        return [Answer("archive", told, arrays)]
    notes: list[str] = []
    scales = scales_where(is_in_si(result))
    track = track_of(result, notes)
    told["panels"] = ["archive", *(OF_RUN_UP if track else ())]
    words = " ".join(notes)
    return [Answer("archive", told, arrays),
            Answer("track", {"scales": scales, "words": words}, track)]  # fmt: skip
