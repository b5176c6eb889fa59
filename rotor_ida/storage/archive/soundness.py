"""What is refused of a file before its data are read."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rotor_ida import schema
from rotor_ida.checks import shown
from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.storage.archive.content import FORMAT
from rotor_ida.storage.archive.conventions import DOMAIN
from rotor_ida.storage.archive.holdable import NUMERIC

if TYPE_CHECKING:
    import netCDF4

LARGEST_CONTENT = 64 * 2**30  # bytes in memory
LARGEST_COMPRESSION = 1100  # deflate reaches 1032
SMALLEST_ALLOWANCE = 2**20  # bytes

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_NETCDF3_SIGNATURE = b"CDF"
# In superblocks of versions 2 and 3 the length of the file stands here.
_LENGTH_FIELD = slice(28, 36)


def check_source(path: object) -> Path:
    """Return the path of a file that exists."""
    if not isinstance(path, (str, os.PathLike)) or not str(path):
        raise InputError(f"path must be the path of a file, got {shown(path)}")
    source = Path(path)
    if os.path.isdir(source):
        raise InputError(f"path must be a file, got the folder {str(source)!r}")
    if not os.path.isfile(source):
        raise InputError(f"path must be a file that exists, got {str(source)!r}")
    return source


def refuse_other_kinds(source: Path) -> int:
    """Refuse what the first bytes show not to be a whole HDF5 file.

    Returns
    -------
    int
        How many bytes follow the data of HDF5, 0 where the first bytes do not tell.
    """
    try:
        with source.open("rb") as file:
            head = file.read(64)
            length = os.fstat(file.fileno()).st_size
    except OSError as error:
        raise ArchiveError(f"cannot read {source}: {error.strerror}") from error
    if not head.startswith(_HDF5_SIGNATURE):
        if not head:
            found = "it is empty"
        elif head.startswith(_NETCDF3_SIGNATURE):
            found = "it is a netCDF file of the classic format"
        else:
            found = "it is not a netCDF-4 file"
        raise ArchiveError(f"{source} is not an archive of rotor_ida: {found}")
    expected = int.from_bytes(head[_LENGTH_FIELD], "little")
    tells_length = len(head) == 64 and head[8] in {2, 3}
    if len(head) < 64 or (tells_length and expected > length):
        raise ArchiveError(f"{source} is truncated or damaged: only {length} bytes are left")
    return length - expected if tells_length else 0


def refuse_other_formats(file: netCDF4.Dataset, source: Path) -> None:
    """Refuse a file that this version cannot read."""
    if FORMAT not in file.ncattrs():
        raise ArchiveError(f"{source} is not an archive of rotor_ida: it has no {FORMAT}")
    number = file.getncattr(FORMAT)
    if not isinstance(number, np.integer) or number < 1:
        raise ArchiveError(f"{source} is damaged: its {FORMAT} is {number!r}")
    if number > schema.FORMAT_VERSION:
        raise ArchiveError(
            f"{source} has format {number}, but this version of rotor_ida reads formats up to "
            f"{schema.FORMAT_VERSION}: install a newer one"
        )


def refuse_other_content(file: netCDF4.Dataset, source: Path) -> None:
    """Refuse groups and types that no archive has."""
    if file.groups or file.cmptypes or file.vltypes or file.enumtypes:
        raise ArchiveError(f"{source} is not an archive of rotor_ida: it has groups or own types")
    for name, stored in file.variables.items():
        if stored.dtype is not str and np.dtype(stored.dtype).newbyteorder("=") not in NUMERIC:
            raise ArchiveError(f"{source} is not an archive of rotor_ida: see variable {name!r}")


def refuse_absurd_sizes(file: netCDF4.Dataset, source: Path, *, in_memory: bool) -> None:
    """Refuse more data than the file can hold, or than memory should."""
    length = source.stat().st_size
    declared = sum(
        math.prod(stored.shape) * (16 if stored.dtype is str else stored.dtype.itemsize)
        for name, stored in file.variables.items()
        if name != DOMAIN
    )
    possible = LARGEST_COMPRESSION * length + SMALLEST_ALLOWANCE
    if declared > possible:
        raise ArchiveError(
            f"{source} declares {declared:.3g} bytes of data: it has {length} bytes, and "
            f"{possible:.3g} is the most that is read from it"
        )
    if in_memory and declared > LARGEST_CONTENT:
        raise ArchiveError(
            f"{source} holds {declared:.3g} bytes of data, and load reads at most "
            f"{LARGEST_CONTENT:.3g} into memory: open_archive reads larger ones"
        )
