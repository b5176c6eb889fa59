"""The store of a study: one SQLite file in a folder, written by one process at a time.

What is kept outlasts a kill, a power failure and a full disk, as SQLite's transactions do.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.storage.studies.database import (
    FILE,
    begin,
    check_folder,
    connected,
    damaged,
    in_words,
    transaction,
)
from rotor_ida.storage.studies.lock import locked

# Finished pieces wait in memory no longer than this before they are kept.
KEPT_EVERY = 1.0  # seconds


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
        What `rotor_ida.storage.studies.packing` made of the result.
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
        self._lock = threading.RLock()
        self._late: threading.Timer | None = None
        self._waiting: list[Piece] = []
        self._began, self._clock = time.time(), time.monotonic()
        self._kept = self._clock
        rows = connection.execute("SELECT number, points FROM pieces").fetchall()
        if not all(isinstance(points, int) for _, points in rows):
            raise damaged(folder, "the number of points of a piece")
        self.done = {number for number, _ in rows}
        self.points_done: int = sum(points for _, points in rows)
        self._points_before = self.points_done
        for _ in self.contents():  # what is damaged is better known before more is computed
            pass
        (self._session,) = connection.execute(
            "SELECT coalesce(max(rowid), 0) + 1 FROM sessions"
        ).fetchone()

    def keep(self, piece: Piece) -> None:
        """Keep a piece; within a second it is on the disk.

        Raises
        ------
        ArchiveError
            If the system does not let it be written: a full disk, a missing permission.
        """
        with self._lock:
            self._waiting.append(piece)
            self.done.add(piece.number)
            self.points_done += piece.points
            if time.monotonic() - self._kept >= KEPT_EVERY:
                self.flush()
            elif self._late is None:  # the next piece may be long in coming
                self._late = threading.Timer(KEPT_EVERY, self._flush_late)
                self._late.daemon = True
                self._late.start()

    def flush(self) -> None:
        """Write what waits to the disk, wholly or not at all.

        An interrupt may come when all is written but not yet forgotten, so that it is written
        again: every line here can be.
        """
        with self._lock:
            if not self._waiting:
                return
            now = time.monotonic()
            seen = self._began + now - self._clock
            points = self.points_done - self._points_before
            with in_words(self.folder), transaction(self._connection):
                self._connection.executemany(
                    "INSERT OR REPLACE INTO pieces VALUES (?, ?, ?, ?, ?, ?)",
                    map(_row, self._waiting),
                )
                self._connection.execute(
                    "INSERT OR REPLACE INTO sessions (rowid, began, seen, points) "
                    "VALUES (?, ?, ?, ?)",
                    (self._session, self._began, seen, points),
                )
            self._waiting, self._kept = [], now

    def end(self) -> None:
        """Write what waits for the last time."""
        late = self._late
        if late is not None:
            late.cancel()
            late.join()
        self.flush()

    def contents(self) -> Iterator[tuple[int, bytes]]:
        """Yield number and content of every piece, in the order of the numbers.

        Raises
        ------
        ArchiveError
            If a piece is damaged.
        """
        self.flush()
        rows = self._connection.execute(
            "SELECT number, points, failed, reason, content, digest FROM pieces ORDER BY number"
        )
        for *told, digest in rows:
            piece = Piece(*told)
            if not isinstance(piece.content, bytes) or digest != _digest(piece):
                raise damaged(self.folder, f"piece {piece.number}")
            yield piece.number, piece.content

    def _flush_late(self) -> None:
        """Write what waits from a thread of its own."""
        with self._lock:
            self._late = None
            # what cannot be written waits for the one who keeps or ends, and meets the error there
            with suppress(ArchiveError):
                self.flush()


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
        If the folder cannot be made or written to, or holds something else, or a study of another
        design.
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
    place = check_folder(folder)
    try:
        _check_new(place)
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"study must be a folder that can be used, got {str(place)!r}: {error.strerror}"
        ) from error
    with locked(place), connected(place) as connection:
        begin(connection, place, design, points)
        study = Study(place.absolute(), connection)
        try:
            yield study
        finally:
            study.end()


def _check_new(place: Path) -> None:
    """Refuse a place where no study can be: what is there stays as it is."""
    nearest = next(path for path in (place, *place.parents) if path.exists())
    if not nearest.is_dir():
        raise InputError(f"study must be a folder, got the file {str(nearest)!r}")
    if (place / FILE).exists():  # what is done can be read even where nothing can be written
        return
    if place.is_dir() and any(place.iterdir()):
        raise InputError(f"study must be a new, an empty or a study's folder, got {str(place)!r}")
    if not os.access(nearest, os.W_OK):
        raise InputError(f"study must be in a folder that can be written to, got {str(place)!r}")


def _row(piece: Piece) -> tuple[int, int, int, str, bytes, bytes]:
    return piece.number, piece.points, piece.failed, piece.reason, _digest(piece), piece.content


def _digest(piece: Piece) -> bytes:
    told = f"{piece.number}\n{piece.points}\n{piece.failed}\n{piece.reason}\n"
    return hashlib.sha256(told.encode() + piece.content).digest()
