"""The seal at the end of an archive: a digest of all bytes before it.

A damaged file can make the HDF5 library loop for ever or crash. So the bytes are checked before
the library sees them. HDF5 and netCDF do not read what follows the end of their data.
"""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path
from typing import BinaryIO, Literal

_SEAL = re.compile(rb"\nrotor_ida seal 1: sha256 of the bytes before is ([0-9a-f]{64})\n")
_LENGTH = len("\nrotor_ida seal 1: sha256 of the bytes before is \n") + 64
_BLOCK = 2**20


def append_seal(path: Path) -> None:
    """Put a seal at the end of a finished file and bring both to the disk."""
    with path.open("rb+") as file:
        digest = _digest(file, os.fstat(file.fileno()).st_size)
        file.seek(0, os.SEEK_END)
        file.write(f"\nrotor_ida seal 1: sha256 of the bytes before is {digest}\n".encode())
        file.flush()
        os.fsync(file.fileno())


def seal_of(path: Path, *, check: bool = True) -> Literal["good", "broken", "none"]:
    """Say whether the bytes of a file are those that were sealed.

    Parameters
    ----------
    path : Path
        The file.
    check : bool
        Whether to read it all; if not, a seal that is there is taken to be good.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "any"
    >>> _ = file.write_bytes(b"content")
    >>> append_seal(file)
    >>> seal_of(file)
    'good'
    >>> _ = file.write_bytes(b"k" + file.read_bytes()[1:])
    >>> seal_of(file)
    'broken'
    """
    with path.open("rb") as file:
        length = os.fstat(file.fileno()).st_size - _LENGTH
        if length < 0:
            return "none"
        file.seek(length)
        found = _SEAL.fullmatch(file.read(_LENGTH))
        if found is None:
            return "none"
        if not check:
            return "good"
        file.seek(0)
        return "good" if _digest(file, length) == found[1].decode() else "broken"


def _digest(file: BinaryIO, length: int) -> str:
    digest = hashlib.sha256()
    while length > 0:
        block = file.read(min(_BLOCK, length))
        if not block:
            break
        digest.update(block)
        length -= len(block)
    return digest.hexdigest()
