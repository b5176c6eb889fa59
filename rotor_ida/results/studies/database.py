"""The SQLite file of a study: open it, begin it, and compare its design."""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from rotor_ida.checks import shown
from rotor_ida.errors import ArchiveError, InputError, MissingFileError
from rotor_ida.results.files import check_path

Design = dict[str, Any]

FILE = "study.sqlite"
FORMAT = 3
# A reader of the status locks the file for an instant only.
_PATIENCE = 30.0  # seconds

_TABLES = (
    "CREATE TABLE design (text TEXT NOT NULL, points INTEGER NOT NULL, digest BLOB NOT NULL)",
    "CREATE TABLE pieces (number INTEGER PRIMARY KEY, points INTEGER NOT NULL, "
    "failed INTEGER NOT NULL, reason TEXT NOT NULL, digest BLOB NOT NULL, content BLOB NOT NULL)",
    "CREATE TABLE sessions (began REAL NOT NULL, seen REAL NOT NULL, points INTEGER NOT NULL)",
    f"PRAGMA user_version = {FORMAT}",
)
# Errors caused by the disk or by permissions, not by the file.
_OF_THE_SYSTEM = frozenset(
    [
        *(sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM),
        *(sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_BUSY, sqlite3.SQLITE_NOMEM),
    ]
)


@contextmanager
def connected(place: Path) -> Iterator[sqlite3.Connection]:
    """Open the file in a folder, and turn SQLite's errors into errors of the study."""
    try:
        connection = sqlite3.connect(place / FILE, timeout=_PATIENCE, isolation_level=None)
        with closing(connection):
            connection.execute("PRAGMA trusted_schema = OFF")
            connection.execute("PRAGMA synchronous = FULL")
            yield connection
    except sqlite3.DatabaseError as error:
        # SQLite's extended codes use the bits above the last eight
        code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT) & 0xFF
        intact = code in _OF_THE_SYSTEM
        hint = "what was kept before is intact" if intact else "it may be damaged"
        raise ArchiveError(f"cannot use {str(place / FILE)!r}: {error}; {hint}") from error


@contextmanager
def transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """Commit everything written in the block, or nothing."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        with suppress(sqlite3.Error):  # SQLite may have rolled back by itself
            connection.execute("ROLLBACK")
        raise


def begin(
    connection: sqlite3.Connection, place: Path, design: Mapping[str, Any], points: int
) -> None:
    """Write the design of a new study, or compare it with that of an existing one."""
    text = _as_text(design)
    if not _is_begun(connection, place):
        # a study has all its tables, or none yet
        if connection.execute("SELECT 1 FROM sqlite_master").fetchone() is not None:
            raise InputError(
                f"study must be a new, an empty or a study's folder, got {str(place)!r}, whose "
                f"{FILE} is not a study"
            )
        with transaction(connection):
            for line in _TABLES:
                connection.execute(line)
            connection.execute(
                "INSERT INTO design VALUES (?, ?, ?)", (text, points, _digest(text, points))
            )
    begun, _ = begun_with(connection, place)
    wanted = json.loads(text)
    (done,) = connection.execute("SELECT coalesce(sum(points), 0) FROM pieces").fetchone()
    if done == points:  # nothing remains to compute, so the program may differ
        unsaid = dict.fromkeys(program_of(begun) | program_of(wanted))
        begun, wanted = begun | unsaid, wanted | unsaid
    refuse_another(str(place), begun, wanted)


def program_of(design: Mapping[str, Any]) -> Design:
    """Return the program in a design: versions, and a digest of sources.

    Examples
    --------
    >>> program_of({"rtol": 1e-10, "numpy_version": "2.4", "sources": "ab"})
    {'numpy_version': '2.4', 'sources': 'ab'}
    """
    return {
        name: said
        for name, said in design.items()
        if name == "sources" or name.endswith("_version")
    }


def begun_with(connection: sqlite3.Connection, place: Path) -> tuple[Design, int]:
    """Return the design with which a study was begun, and its number of points."""
    rows = connection.execute("SELECT text, points, digest FROM design").fetchall()
    try:
        ((text, points, digest),) = rows
        design = json.loads(text) if digest == _digest(text, points) else None
    except (ValueError, TypeError, RecursionError):
        design = None
    if not isinstance(design, dict) or not isinstance(points, int):
        raise damaged(place, "its design")
    return design, points


def refuse_another(folder: str, begun: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Raise `InputError` if a design differs from that of the existing study in `folder`.

    Examples
    --------
    >>> refuse_another("study", {"rtol": 1e-10}, {"rtol": 1e-09})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: study 'study' was begun with rtol 1e-10, got 1e-09: resume it with
    the same arguments, or begin another in a separate folder
    """
    for name in sorted({*begun, *wanted}):
        before, now = begun.get(name, "nothing"), wanted.get(name, "nothing")
        if _differ(before, now):
            where, before, now = _part_apart(name, before, now)
            raise InputError(
                f"study {folder!r} was begun with {where} {_shown(before)}, got {_shown(now)}: "
                "resume it with the same arguments, or begin another in a separate folder"
            )


def _differ(one: object, other: object) -> bool:
    """Return whether values differ as text: 0.0 and -0.0 are equal but give other bits."""
    return _as_text({"": one}) != _as_text({"": other})


def _part_apart(name: str, before: Any, now: Any) -> tuple[str, Any, Any]:
    """Return the name and the values of the first part that differs, small enough to be shown."""
    parts: list[tuple[str, Any, Any]] = []
    if isinstance(before, dict) and isinstance(now, dict):
        keys = sorted({*before, *now})
        parts = [(key, before.get(key, "nothing"), now.get(key, "nothing")) for key in keys]
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        pairs = list(zip(before, now, strict=True))
        is_long = _shown(before) == _shown(now)
        if is_long or any(isinstance(each, list | dict) for pair in pairs for each in pair):
            parts = [(str(place), *pair) for place, pair in enumerate(pairs)]
    for part, one, other in parts:
        if _differ(one, other):
            return _part_apart(f"{name} {part}", one, other)
    return name, before, now


@contextmanager
def reading(folder: str | os.PathLike[str]) -> Iterator[sqlite3.Connection]:
    """Open the store of the study in a folder for reading, even while it is running."""
    place = check_path("study", folder, kind="folder")
    refusal = f"folder must be that of a study, got {str(place)!r}"
    try:
        found = (place / FILE).is_file()
    except OSError as error:
        raise InputError(f"{refusal}: {error.strerror}") from error
    if not found:
        raise MissingFileError(refusal)
    with connected(place) as connection:
        if not _is_begun(connection, place):
            raise InputError(f"folder must be that of a study that was begun, got {str(place)!r}")
        yield connection


def design_of(folder: str | os.PathLike[str]) -> Design:
    """Return the design with which the study in a folder was begun.

    Raises
    ------
    InputError
        If there is no study.
    ArchiveError
        If its file is damaged.
    """
    with reading(folder) as connection:
        return begun_with(connection, Path(folder))[0]


def damaged(place: Path, what: str) -> ArchiveError:
    """Return the error for damaged content."""
    return ArchiveError(
        f"study {str(place)!r} is damaged: {what} in {FILE} is not what was written; restore the "
        "file from a copy, or begin another study"
    )


def _is_begun(connection: sqlite3.Connection, place: Path) -> bool:
    """Return whether there is a study; one killed before its first write does not count."""
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if version not in {0, FORMAT}:
        raise InputError(
            f"study {str(place)!r} has format {version}, but this version of rotor_ida resumes "
            f"format {FORMAT} only"
        )
    return bool(version == FORMAT)


def _digest(text: str, points: int) -> bytes:
    return hashlib.sha256(f"{points}\n{text}".encode()).digest()


def _as_text(design: Mapping[str, Any]) -> str:
    """Return a design as JSON in which every number has all its digits."""
    return json.dumps(design, sort_keys=True, allow_nan=False)


def _shown(value: object) -> str:
    counted = f" ({len(value)} values)" if isinstance(value, list) and len(value) > 6 else ""
    return f"{shown(value)}{counted}"
