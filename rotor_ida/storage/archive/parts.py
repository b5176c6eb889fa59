"""Unfinished archives: each in a folder of its own beside the archive, removed when it is done.

The folder is locked while its writer lives. A writer that was killed leaves it unlocked, and the
next one that comes by removes it.
"""

from __future__ import annotations

import importlib
import os
import re
import secrets
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_NAME = "rotor_ida-part"


@contextmanager
def part_beside(target: Path) -> Iterator[Path]:
    """Give the path of a file to write, on the disk of `target`; what is left of it is removed."""
    remove_abandoned(target.parent)
    folder, lock = _locked_folder(target.parent)
    try:
        yield folder / "archive.nc"
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def remove_abandoned(folder: Path) -> None:
    """Remove the parts in `folder` whose writers, on this machine, are certainly dead."""
    if os.name == "nt":
        return
    pattern = re.compile(rf"\.{re.escape(_machine())}\.[0-9a-f]{{16}}\.{_NAME}")
    with suppress(OSError), os.scandir(folder) as entries:
        for name in [entry.name for entry in entries if pattern.fullmatch(entry.name)]:
            _remove_if_abandoned(folder / name)


def _remove_if_abandoned(part: Path) -> None:
    with suppress(OSError):
        descriptor = os.open(part, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        try:
            # Refused while the writer lives.
            if _lock(descriptor, wait=False):
                shutil.rmtree(part, ignore_errors=True)
        finally:
            os.close(descriptor)


def _locked_folder(parent: Path) -> tuple[Path, int | None]:
    while True:
        folder = parent / f".{_machine()}.{secrets.token_hex(8)}.{_NAME}"
        folder.mkdir(mode=0o700)
        if os.name == "nt":
            return folder, None
        with suppress(FileNotFoundError):
            descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            _lock(descriptor, wait=True)
            if os.path.lexists(folder):
                return folder, descriptor
            # Removed by another writer between being made and being locked.
            os.close(descriptor)


def _lock(descriptor: int, *, wait: bool) -> bool:
    """Lock a folder until the descriptor is closed; say whether that could be done."""
    try:
        fcntl = importlib.import_module("fcntl")
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except (ImportError, OSError):  # Windows, held by another, or a file system without locks
        return False
    return True


def _machine() -> str:
    return re.sub(r"[^A-Za-z0-9-]+", "-", socket.gethostname())[:64] or "unnamed"
