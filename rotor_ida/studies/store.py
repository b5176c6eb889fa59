"""The store of a study: one SQLite file in a folder, written by one process at a time.

What is kept outlasts a kill, a power failure and a full disk, as SQLite's transactions do.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.studies.design import as_text, refuse_another
from rotor_ida.studies.lock import locked

FILE = "study.sqlite"
FORMAT = 1
# Finished pieces wait in memory no longer than this before they are kept.
KEPT_EVERY = 1.0  # seconds
# A reader of the status holds the file for an instant only.
_PATIENCE = 30.0  # seconds

_TABLES = (
    "CREATE TABLE design (text TEXT NOT NULL, points INTEGER NOT NULL)",
    "CREATE TABLE pieces (number INTEGER PRIMARY KEY, points INTEGER NOT NULL, "
    "failed INTEGER NOT NULL, reason TEXT NOT NULL, digest BLOB NOT NULL, content BLOB NOT NULL)",
    "CREATE TABLE sessions (began REAL NOT NULL, seen REAL NOT NULL, points INTEGER NOT NULL)",
    f"PRAGMA user_version = {FORMAT}",
)


@dataclass(frozen=True, slots=True)
class Piece:
    """What one job has returned.

    Parameters
    ----------
    number : int
        Which job.
    points : int
        How many points of the study it holds.
    failed : int
        How many of these failed.
    reason : str
        Why the first of them did; empty if none.
    content : bytes
        What `rotor_ida.studies.packing` made of the result.
    """

    number: int
    points: int
    failed: int
    reason: str
    content: bytes


class Study:
    """A study that is being worked on; from `opened` only.

    Parameters
    ----------
    folder : Path
        Its folder.
    connection : sqlite3.Connection
        Its store.

    Attributes
    ----------
    folder : Path
        Its folder.
    done : set of int
        Numbers of the pieces that it holds.
    points_done : int
        Number of points that these hold.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection) -> None:
        self.folder = folder
        self._connection = connection
        self._waiting: list[Piece] = []
        self._began = self._kept = time.time()
        self._session: int | None = None
        rows = connection.execute("SELECT number, points FROM pieces").fetchall()
        self.done = {number for number, _ in rows}
        self.points_done: int = sum(points for _, points in rows)

    def keep(self, piece: Piece) -> None:
        """Keep a piece; within a second it is on the disk.

        Raises
        ------
        ArchiveError
            If the system does not let it be written: a full disk, a missing permission.
        """
        self._waiting.append(piece)
        self.done.add(piece.number)
        self.points_done += piece.points
        if time.time() - self._kept >= KEPT_EVERY:
            self.flush()

    def flush(self) -> None:
        """Write what waits to the disk, wholly or not at all."""
        if not self._waiting:
            return
        now = time.time()
        with _in_words(self.folder), _transaction(self._connection):
            self._connection.executemany(
                "INSERT INTO pieces VALUES (?, ?, ?, ?, ?, ?)", map(_row, self._waiting)
            )
            points = sum(piece.points for piece in self._waiting)
            session = self._session
            if session is None:
                inserted = self._connection.execute(
                    "INSERT INTO sessions VALUES (?, ?, ?)", (self._began, now, points)
                )
                session = inserted.lastrowid
            else:
                self._connection.execute(
                    "UPDATE sessions SET seen = ?, points = points + ? WHERE rowid = ?",
                    (now, points, session),
                )
        self._waiting, self._session, self._kept = [], session, now

    def contents(self) -> Iterator[tuple[int, bytes]]:
        """Yield number and content of every piece, in the order of the numbers.

        Raises
        ------
        ArchiveError
            If a piece is damaged.
        """
        self.flush()
        with _in_words(self.folder):
            rows = self._connection.execute(
                "SELECT number, digest, content FROM pieces ORDER BY number"
            )
            for number, digest, content in rows:
                if digest != _digest(number, content):
                    raise ArchiveError(
                        f"study {str(self.folder)!r} is damaged: piece {number} of {FILE} is not "
                        "what was written; restore the file from a copy, or begin another study"
                    )
                yield number, content


@contextmanager
def opened(
    folder: str | os.PathLike[str], design: Mapping[str, Any], points: int
) -> Iterator[Study]:
    """Begin a study in a folder, or go on with the one that is there.

    Parameters
    ----------
    folder : path-like
        The folder; made if it is not there.
    design : mapping
        What is computed, and all that decides on the bits of the result: strings, finite numbers,
        None and lists of them.
    points : int
        How many points it has in all.

    Yields
    ------
    Study
        The study, for this process alone. What it was given to keep is on the disk afterwards,
        whatever happened meanwhile.

    Raises
    ------
    InputError
        If the folder holds something else, or a study of another design.
    ArchiveError
        If another process is at work on it, or its file is damaged or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with opened(folder + "/study", {"rtol": 1e-10}, points=2) as study:
    ...         study.keep(Piece(0, 1, 0, "", b"what was found"))
    ...     with opened(folder + "/study", {"rtol": 1e-10}, points=2) as study:
    ...         study.done, list(study.contents())
    ({0}, [(0, b'what was found')])
    """
    place = _check_new(_check_folder(folder))
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"cannot make the folder {str(place)!r}: {error.strerror}") from error
    with locked(place), _connected(place) as connection:
        _begin(connection, place, design, points)
        study = Study(place, connection)
        try:
            yield study
        finally:
            study.flush()


def design_of(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the design with which the study in a folder was begun.

    Raises
    ------
    InputError
        If there is no study.
    ArchiveError
        If its file is damaged.
    """
    with reading(folder) as connection:
        (text,) = connection.execute("SELECT text FROM design").fetchone()
    design: dict[str, Any] = json.loads(text)
    return design


@contextmanager
def reading(folder: str | os.PathLike[str]) -> Iterator[sqlite3.Connection]:
    """Open the store of the study in a folder to look at it, even while it is worked on."""
    place = _check_folder(folder)
    if not (place / FILE).is_file():
        raise InputError(f"folder must be that of a study, got {str(place)!r}")
    with _connected(place) as connection:
        if not _is_begun(connection, place):
            raise InputError(f"folder must be that of a study that was begun, got {str(place)!r}")
        yield connection


def _check_folder(folder: object) -> Path:
    if not isinstance(folder, (str, os.PathLike)) or "\0" in str(folder) or not str(folder):
        raise InputError(f"study must be the path of a folder, got {folder!r}")
    return Path(folder)


def _check_new(place: Path) -> Path:
    """Refuse a place where no study can be: what is there stays as it is."""
    nearest = next(path for path in (place, *place.parents) if path.exists())
    if not nearest.is_dir():
        raise InputError(f"study must be a folder, got the file {str(nearest)!r}")
    if place.is_dir() and not (place / FILE).exists() and any(place.iterdir()):
        raise InputError(f"study must be a new, an empty or a study's folder, got {str(place)!r}")
    return place


def _begin(
    connection: sqlite3.Connection, place: Path, design: Mapping[str, Any], points: int
) -> None:
    """Write the design of a new study; hold that of one that was begun against it."""
    text = as_text(design)
    with _in_words(place):
        if not _is_begun(connection, place):
            with _transaction(connection):
                for line in _TABLES:
                    connection.execute(line)
                connection.execute("INSERT INTO design VALUES (?, ?)", (text, points))
        (begun,) = connection.execute("SELECT text FROM design").fetchone()
    refuse_another(str(place), json.loads(begun), json.loads(text))


def _is_begun(connection: sqlite3.Connection, place: Path) -> bool:
    """Return whether there is a study; one that was killed at once is none."""
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if version > FORMAT:
        raise InputError(
            f"study {str(place)!r} has format {version}, but this version of rotor_ida goes on "
            f"with formats up to {FORMAT}: install a newer one"
        )
    return bool(version == FORMAT)


@contextmanager
def _connected(place: Path) -> Iterator[sqlite3.Connection]:
    with _in_words(place):
        connection = sqlite3.connect(place / FILE, timeout=_PATIENCE, isolation_level=None)
        try:
            connection.execute("PRAGMA trusted_schema = OFF")
            connection.execute("PRAGMA synchronous = FULL")
            yield connection
        finally:
            connection.close()


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        with suppress(sqlite3.Error):  # SQLite may have rolled back by itself
            connection.execute("ROLLBACK")
        raise


@contextmanager
def _in_words(place: Path) -> Iterator[None]:
    """Say what SQLite says as an error of the study."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        hint = "what was kept before is intact" if _may_be_intact(error) else "it may be damaged"
        raise ArchiveError(f"cannot use {str(place / FILE)!r}: {error}; {hint}") from error


def _may_be_intact(error: sqlite3.DatabaseError) -> bool:
    """Return whether the disk or the permissions are at fault, not the file."""
    return isinstance(error, sqlite3.OperationalError)


def _row(piece: Piece) -> tuple[int, int, int, str, bytes, bytes]:
    digest = _digest(piece.number, piece.content)
    return piece.number, piece.points, piece.failed, piece.reason, digest, piece.content


def _digest(number: int, content: bytes) -> bytes:
    return hashlib.sha256(number.to_bytes(8, "little") + content).digest()
