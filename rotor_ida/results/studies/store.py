"""The store of a study: one SQLite file in a folder, written by one process at a time.

Its content survives a kill, a power failure and a full disk, as SQLite's transactions do.
"""

from __future__ import annotations

import errno
import hashlib
import math
import os
import sqlite3
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.results.files import check_path
from rotor_ida.results.studies.database import (
    FILE,
    begin,
    begun_with,
    connected,
    damaged,
    reading,
    transaction,
)

LOCK = "study.lock"
# The machine of a study whose results are in SI units.
MACHINE_FILE = "machine.toml"
# A process that only checks the lock holds it for an instant.
_PATIENCE = 1.0  # seconds
_READ_ONLY = {errno.EROFS, errno.EACCES, errno.EPERM}
# Number of different reasons of failure that are reported.
_MOST_REASONS = 10


@dataclass(frozen=True, slots=True)
class Piece:
    """The result of one job."""

    number: int  # of the job
    points: int  # number of points of the study in it
    failed: int  # number of these that failed
    reason: str  # why the first of them failed; empty if none
    content: bytes  # the result, by `rotor_ida.results.studies.arrays.packed`


class Study:
    """An open study, from `opened` only: its pieces and its number of points done."""

    def __init__(self, folder: Path, connection: sqlite3.Connection) -> None:
        self.folder = folder
        self.done: set[int] = set()
        self.points_done = 0
        self._connection = connection
        # find damage before more is computed
        for *told, digest in connection.execute(
            "SELECT number, points, failed, reason, content, digest FROM pieces"
        ):
            piece = Piece(*told)
            if not isinstance(piece.content, bytes) or digest != _digest(piece):
                raise damaged(folder, f"piece {piece.number}")
            self.done.add(piece.number)
            self.points_done += piece.points
        self._points_before = self.points_done
        self._began, self._clock = time.time(), time.monotonic()
        (self._session,) = connection.execute(
            "SELECT coalesce(max(rowid), 0) + 1 FROM sessions"
        ).fetchone()

    def keep(self, piece: Piece) -> None:
        """Write a piece to the disk.

        Raises
        ------
        ArchiveError
            If it cannot be written: a full disk, a missing permission.
        """
        points = self.points_done + piece.points
        seen = self._began + time.monotonic() - self._clock
        with transaction(self._connection):
            self._connection.execute(
                "INSERT INTO pieces (number, points, failed, reason, content, digest) "
                "VALUES (?, ?, ?, ?, ?, ?)",
                (*astuple(piece), _digest(piece)),
            )
            self._connection.execute(
                "INSERT OR REPLACE INTO sessions (rowid, began, seen, points) VALUES (?, ?, ?, ?)",
                (self._session, self._began, seen, points - self._points_before),
            )
        self.done.add(piece.number)
        self.points_done = points

    def contents(self) -> Iterator[tuple[int, bytes]]:
        """Yield number and content of every piece, in the order of the numbers."""
        yield from self._connection.execute("SELECT number, content FROM pieces ORDER BY number")


@contextmanager
def opened(
    folder: str | os.PathLike[str], design: Mapping[str, Any], points: int
) -> Iterator[Study]:
    """Begin a study in a folder, or resume the existing one.

    Parameters
    ----------
    folder : path-like
        The folder; created if it does not exist.
    design : mapping
        All that determines the bits of the result: strings, finite numbers, None and lists of
        them.
    points : int
        Total number of points.

    Yields
    ------
    Study
        The study, for this process alone.

    Raises
    ------
    InputError
        If the folder cannot be created or written to, or contains something else or a study of
        another design.
    ArchiveError
        If another process is working on it, or its file is damaged or cannot be written.

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
    place = check_path("study", folder, kind="folder")
    try:
        _check_new(place)
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"study must be a folder that can be used, got {str(place)!r}: {error.strerror}"
        ) from error
    with _locked(place, _PATIENCE), connected(place) as connection:
        begin(connection, place, design, points)
        # a commit to a log waits for the disk once, not four times; a folder without write
        # permission needs none
        with _log_beside(connection):
            yield Study(place.absolute(), connection)


def status(folder: str | os.PathLike[str]) -> dict[str, object]:
    """Return the progress of the study in a folder, even while it is running.

    Parameters
    ----------
    folder : path-like
        The folder of a study that was begun.

    Returns
    -------
    dict
        ``kind``; the numbers of ``points``, and of those ``done``, ``failed`` and ``left``;
        ``running``, whether a process is working on it; ``points_per_second`` in the last session
        and ``seconds_left`` at that rate (NaN if unknown); ``reasons``, the first few different
        reasons why points failed.

    Raises
    ------
    InputError
        If there is no study.
    ArchiveError
        If its file is damaged.
    """
    place = check_path("study", folder, kind="folder")
    with reading(place) as connection:
        design, points = begun_with(connection, place)
        done, failed, wrong = connection.execute(
            "SELECT coalesce(sum(points), 0), coalesce(sum(failed), 0), "
            "count(*) FILTER (WHERE failed < 0 OR failed > points) FROM pieces"
        ).fetchone()
        reasons = connection.execute(
            "SELECT DISTINCT reason FROM pieces WHERE failed > 0 ORDER BY number LIMIT ?",
            (_MOST_REASONS,),
        ).fetchall()
        session = connection.execute(
            "SELECT began, seen, points FROM sessions ORDER BY rowid DESC LIMIT 1"
        ).fetchone()
    if not (isinstance(done, int) and isinstance(failed, int)) or wrong or done > points:
        raise damaged(place, "the number of points of a piece")
    rate = _rate(session)
    return {
        "kind": design.get("verb", ""),
        "points": points,
        "done": done,
        "failed": failed,
        "left": points - done,
        "running": _is_locked(place),
        "points_per_second": rate,
        "seconds_left": (points - done) / rate if rate > 0.0 else math.nan,
        "reasons": [str(reason) for (reason,) in reasons],
    }


def _check_new(place: Path) -> None:
    """Refuse a place that cannot be a study's folder, and leave it unchanged."""
    nearest = next(path for path in (place, *place.parents) if path.exists())
    if not nearest.is_dir():
        raise InputError(f"study must be a folder, got the file {str(nearest)!r}")
    if (place / FILE).exists():  # a finished study can be read without write permission
        return
    if place.is_dir() and any(each.name not in {LOCK, MACHINE_FILE} for each in place.iterdir()):
        raise InputError(f"study must be a new, an empty or a study's folder, got {str(place)!r}")
    if not os.access(nearest, os.W_OK):
        raise InputError(f"study must be in a folder that can be written to, got {str(place)!r}")


@contextmanager
def _locked(folder: Path, patience: float) -> Iterator[None]:
    """Lock a folder for this process.

    The lock on the file counts, which disappears with the process, not the existence of the file.
    The process with the lock removes the file in the end. A file left by a killed process does no
    harm, and the next process removes it.
    """
    lock = FileLock(folder / LOCK, timeout=patience)
    try:
        lock.acquire()
    except Timeout:
        raise ArchiveError(f"another process is working in {str(folder)!r}") from None
    except OSError as error:
        if error.errno not in _READ_ONLY:
            raise ArchiveError(
                f"cannot use the folder {str(folder)!r}: {error.strerror}"
            ) from error
    try:
        yield
    finally:
        if lock.is_locked and os.name == "posix":  # on Windows filelock does
            (folder / LOCK).unlink(missing_ok=True)
        lock.release()


def _is_locked(folder: Path) -> bool:
    """Return whether a process is working in a folder, as far as is known."""
    if not (folder / LOCK).exists():
        return False
    try:
        with _locked(folder, patience=0.0):
            return False
    except ArchiveError:
        return True


@contextmanager
def _log_beside(connection: sqlite3.Connection) -> Iterator[None]:
    """Commit to a log, which is removed afterwards, so that one file contains the whole study."""
    with suppress(sqlite3.OperationalError):
        connection.execute("PRAGMA journal_mode = WAL")
    try:
        yield
    finally:
        with suppress(sqlite3.OperationalError):
            connection.execute("PRAGMA journal_mode = DELETE")


def _rate(session: tuple[object, ...] | None) -> float:
    if session is None:
        return math.nan
    began, seen, points = (each if isinstance(each, (int, float)) else 0 for each in session)
    return points / (seen - began) if seen > began else math.nan


def _digest(piece: Piece) -> bytes:
    told = f"{piece.number}\n{piece.points}\n{piece.failed}\n{piece.reason}\n"
    return hashlib.sha256(told.encode() + piece.content).digest()
