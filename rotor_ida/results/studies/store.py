"""The store of a study: a folder with its design and a file for each piece.

Each file is written beside its place, synchronised and renamed, so that a kill, a power failure or
a full disk leaves what was there before. One process writes at a time.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from rotor_ida.errors import ArchiveError, InputError, MissingFileError
from rotor_ida.formats.replacing import put
from rotor_ida.results.files import check_path
from rotor_ida.results.studies.design import Design, as_text, program_of, refuse_another

# The design, the folder of pieces, and in it the file that is being written.
FILE, PIECES, UNFINISHED = "study.json", "pieces", "unfinished"
FORMAT = 4
LOCK = "study.lock"
# The machine of a study whose results are in SI units.
MACHINE_FILE = "machine.toml"
# A process that only checks the lock holds it for an instant.
_PATIENCE = 1.0  # seconds
_READ_ONLY = {errno.EROFS, errno.EACCES, errno.EPERM}
# What the line of a piece has.
_OF_PIECE = {"number", "points", "failed", "reason", "began", "seen"}
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

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.done: set[int] = set()
        self.points_done = 0
        for number in _numbers(folder):  # find damage before more is computed
            self.done.add(number)
            self.points_done += _read(folder, f"{PIECES}/{number}")[0]["points"]
        self._began, self._clock = time.time(), time.monotonic()

    def keep(self, piece: Piece) -> None:
        """Write a piece to the disk.

        Raises
        ------
        ArchiveError
            If it cannot be written: a full disk, a missing permission.
        """
        told = {
            "number": piece.number, "points": piece.points, "failed": piece.failed,
            "reason": piece.reason, "began": self._began,
            "seen": self._began + time.monotonic() - self._clock,
        }  # fmt: skip
        _write(self.folder, f"{PIECES}/{piece.number}", told, piece.content)
        self.done.add(piece.number)
        self.points_done += piece.points

    def contents(self) -> Iterator[tuple[int, bytes]]:
        """Yield number and content of every piece, in the order of the numbers."""
        for number in _numbers(self.folder):
            yield number, _read(self.folder, f"{PIECES}/{number}")[1]


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
        If another process is working on it, or a file is damaged or cannot be written.

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
    with _locked(place, _PATIENCE):
        wanted: Design = json.loads(as_text(design))
        if not (place / FILE).exists():
            _write(place, FILE, {"format": FORMAT, "points": points, "design": wanted})
        with suppress(OSError):  # of a writer that was killed
            (place / PIECES / UNFINISHED).unlink(missing_ok=True)
        begun, _ = _begun_with(place)
        study = Study(place.absolute())
        if study.points_done == points:  # nothing remains to compute, so the program may differ
            unsaid = dict.fromkeys(program_of(begun) | program_of(wanted))
            begun, wanted = begun | unsaid, wanted | unsaid
        refuse_another(str(place), begun, wanted)
        yield study


def design_of(folder: str | os.PathLike[str]) -> Design:
    """Return the design with which the study in a folder was begun.

    Raises
    ------
    InputError
        If there is no study.
    ArchiveError
        If its file is damaged.
    """
    return _begun_with(check_path("study", folder, kind="folder"))[0]


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
        If a file is damaged.
    """
    place = check_path("study", folder, kind="folder")
    design, points = _begun_with(place)
    pieces = [_read(place, f"{PIECES}/{each}", whole=False)[0] for each in _numbers(place)]
    done, failed = (sum(piece[name] for piece in pieces) for name in ("points", "failed"))
    reasons = dict.fromkeys(piece["reason"] for piece in pieces if piece["failed"])
    rate = _rate(pieces)
    return {
        "kind": design.get("verb", ""),
        "points": points,
        "done": done,
        "failed": failed,
        "left": points - done,
        "running": _is_locked(place),
        "points_per_second": rate,
        "seconds_left": (points - done) / rate if rate > 0.0 else math.nan,
        "reasons": list(reasons)[:_MOST_REASONS],
    }


def _check_new(place: Path) -> None:
    """Refuse a place that cannot be a study's folder, and leave it unchanged."""
    nearest = next(path for path in (place, *place.parents) if path.exists())
    if not nearest.is_dir():
        raise InputError(f"study must be a folder, got the file {str(nearest)!r}")
    if (place / FILE).exists():  # a finished study can be read without write permission
        return
    ours = {LOCK, MACHINE_FILE, PIECES}
    if place.is_dir() and any(each.name not in ours for each in place.iterdir()):
        raise InputError(f"study must be a new, an empty or a study's folder, got {str(place)!r}")
    if not os.access(nearest, os.W_OK):
        raise InputError(f"study must be in a folder that can be written to, got {str(place)!r}")


def _begun_with(place: Path) -> tuple[Design, int]:
    """Return the design with which a study was begun, and its number of points."""
    if not os.path.isfile(place / FILE):
        raise MissingFileError(f"folder must be that of a study, got {str(place)!r}")
    told, _ = _read(place, FILE)
    if told["format"] != FORMAT:
        raise InputError(
            f"study {str(place)!r} has format {told['format']}, but this version of rotor_ida "
            f"resumes format {FORMAT} only"
        )
    return told["design"], told["points"]


def _numbers(folder: Path) -> list[int]:
    """Return the numbers of the pieces in a folder, in order."""
    try:
        return sorted(int(name) for name in os.listdir(folder / PIECES) if name != UNFINISHED)
    except FileNotFoundError:
        return []
    except (OSError, ValueError) as error:
        raise ArchiveError(f"cannot use {str(folder / PIECES)!r}: {error}") from error


def _write(folder: Path, name: str, told: Mapping[str, Any], content: bytes = b"") -> None:
    """Write a file as a whole: the checksum of what follows, a line of JSON, and a content."""
    body = as_text(told).encode() + b"\n" + content
    part = folder / PIECES / UNFINISHED
    try:
        part.parent.mkdir(exist_ok=True)
        with part.open("wb") as file:
            file.write(hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
            file.flush()
            os.fsync(file.fileno())
        put(part, folder / name)
    except OSError as error:
        raise ArchiveError(
            f"cannot write {str(folder / name)!r}: {error.strerror}; what was kept before is intact"
        ) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _read(folder: Path, name: str, *, whole: bool = True) -> tuple[dict[str, Any], bytes]:
    """Return the line of JSON and the content of a file; raise `ArchiveError` if it is damaged.

    Unless the `whole` is wanted, the content is neither read nor checked.
    """
    try:
        with (folder / name).open("rb") as file:
            digest, line = file.readline(), file.readline()
            content = file.read() if whole else b""
        is_sound = (
            not whole or hashlib.sha256(line + content).hexdigest() == digest.decode().strip()
        )
        told = json.loads(line) if is_sound else None
    except OSError as error:
        raise ArchiveError(f"cannot read {str(folder / name)!r}: {error.strerror}") from error
    except (ValueError, RecursionError):
        told = None
    is_known = isinstance(told, dict) and (
        (name == FILE and "format" in told)
        or (told.keys() >= _OF_PIECE and name == f"{PIECES}/{told['number']}")
    )
    if told is not None and is_known:
        return told, content
    way = "begin another study" if name == FILE else "remove it and resume the study"
    raise ArchiveError(
        f"study {str(folder)!r} is damaged: {name} is not what was written; restore it from a "
        f"copy, or {way}"
    )


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


def _rate(pieces: Sequence[Mapping[str, Any]]) -> float:
    """Return the points done a second in the last session."""
    began = max((piece["began"] for piece in pieces), default=math.nan)
    last = [piece for piece in pieces if piece["began"] == began]
    took = max((piece["seen"] for piece in last), default=began) - began
    return float(sum(piece["points"] for piece in last) / took) if took > 0.0 else math.nan
