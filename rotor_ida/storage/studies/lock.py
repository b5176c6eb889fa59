"""One process at a time: a lock that goes away with the process that holds it."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rotor_ida.errors import ArchiveError

# Who only asks whether the lock is held holds it for an instant.
_TRIES, _PAUSE = 20, 0.05  # seconds


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for this process alone, without a file that could be left behind.

    Raises
    ------
    ArchiveError
        If another process holds it.
    """
    try:
        descriptor = _open(folder)
    except OSError as error:
        raise ArchiveError(f"cannot use the folder {str(folder)!r}: {error.strerror}") from error
    try:
        if descriptor is not None and not _held(descriptor):
            raise ArchiveError(f"another process is at work in {str(folder)!r}")
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)


def is_locked(folder: Path) -> bool:
    """Return whether a process is at work in a folder, as far as can be told."""
    try:
        descriptor = _open(folder)
    except OSError:
        return False
    if descriptor is None:
        return False
    try:
        return not _held(descriptor, tries=1)
    finally:
        os.close(descriptor)


def _open(folder: Path) -> int | None:
    """Return a descriptor that can be locked; None where folders cannot, as on Windows."""
    return os.open(folder, os.O_RDONLY) if os.name == "posix" else None


def _held(descriptor: int, tries: int = _TRIES) -> bool:
    """Try to lock; file systems that know no locks count as locked for us."""
    import fcntl  # noqa: PLC0415 - not on Windows

    for attempt in range(tries):
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if attempt + 1 < tries:
                time.sleep(_PAUSE)
        except OSError:
            return True
        else:
            return True
    return False
