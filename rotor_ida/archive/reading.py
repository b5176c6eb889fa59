"""Reading an archive: what cannot be trusted is refused before its data are read."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida import schema
from rotor_ida.archive.content import CHECKSUM, FORMAT, NUMERIC, content_sha256
from rotor_ida.archive.library import LOCK, what_is_no_variable
from rotor_ida.errors import ArchiveError, InputError

if TYPE_CHECKING:
    import netCDF4

LARGEST_CONTENT = 64 * 2**30  # bytes
LARGEST_COMPRESSION = 1100  # deflate reaches 1032
SMALLEST_ALLOWANCE = 2**20  # bytes

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_NETCDF3_SIGNATURE = b"CDF"
# In superblocks of versions 2 and 3 the length of the file stands here.
_LENGTH_FIELD = slice(28, 36)


def load(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read an archive that `save` wrote, fully into memory.

    Parameters
    ----------
    path : path-like
        The file. It is closed again when the function returns.

    Returns
    -------
    xr.Dataset
        The dataset that was saved, with the four global attributes that `save` adds.

    Raises
    ------
    InputError
        If there is no such file, or `path` is a folder.
    ArchiveError
        If the file is not an archive of this package, is of a newer format, is truncated or
        damaged, refers to other files, declares more data than it can hold, or if its content
        does not have the checksum that it was saved with.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.archive import save
    >>> folder = tempfile.TemporaryDirectory()
    >>> run = xr.Dataset({"x": ("time", [0.0, np.nan])}, attrs={"omega": 1.7})
    >>> again = load(save(run, folder.name + "/run.nc"))
    >>> again["x"].identical(run["x"])
    True
    >>> str(again.attrs["Conventions"]), int(again.attrs["rotor_ida_format"])
    ('CF-1.11', 1)
    >>> load(folder.name + "/walk.nc")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: path must be a file that exists, got '.../walk.nc'
    >>> folder.cleanup()
    """
    while True:
        source = _check_source(path)
        before = _identity(source)
        try:
            return _load_as_it_stands(source)
        except ArchiveError:
            # Replaced in the midst of reading by another process: read the new one.
            if _identity(source) == before:
                raise


def _identity(source: Path) -> tuple[int, int, int, int] | None:
    try:
        found = source.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def _load_as_it_stands(source: Path) -> xr.Dataset:
    try:
        with LOCK:
            _refuse_other_kinds(source)
            if other := what_is_no_variable(source):
                raise ArchiveError(f"{source} is not a sound archive: it holds {other}")
            dataset = _read(source)
        computed = content_sha256(dataset)
    except ArchiveError:
        raise
    except Exception as error:  # a damaged file can make the libraries raise anything
        told = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        reason = " ".join(told.split()) or type(error).__name__
        raise ArchiveError(f"cannot read {source}, which may be damaged: {reason}") from error
    if computed != dataset.attrs.get(CHECKSUM):
        raise ArchiveError(
            f"{source} is damaged or was altered: its content does not have the checksum "
            f"{CHECKSUM} that it was saved with"
        )
    return dataset


def _check_source(path: object) -> Path:
    if not isinstance(path, (str, os.PathLike)) or not str(path):
        raise InputError(f"path must be the path of a file, got {path!r}")
    source = Path(path)
    if os.path.isdir(source):
        raise InputError(f"path must be a file, got the folder {str(source)!r}")
    if not os.path.isfile(source):
        raise InputError(f"path must be a file that exists, got {str(source)!r}")
    return source


def _refuse_other_kinds(source: Path) -> None:
    """Refuse what the first bytes show not to be a whole HDF5 file."""
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
    if len(head) < 64 or (head[8] in {2, 3} and expected > length):
        raise ArchiveError(f"{source} is truncated or damaged: only {length} bytes are left")


def _read(source: Path) -> xr.Dataset:
    import netCDF4  # noqa: PLC0415 - not needed to import the package

    with netCDF4.Dataset(source) as file:
        file.set_auto_maskandscale(False)
        _refuse_other_formats(file, source)
        _refuse_other_content(file, source)
        _refuse_absurd_sizes(file, source)
        attributes = _attributes(file)
        coordinates = set(str(attributes.pop("coordinates", "")).split())
        variables: dict[str, xr.Variable] = {}
        for name, stored in file.variables.items():
            its_own = _attributes(stored)
            coordinates.update(str(its_own.pop("coordinates", "")).split())
            variables[name] = xr.Variable(stored.dimensions, _values(stored, source), its_own)
        coordinates.update(file.dimensions)
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in coordinates},
        {name: variable for name, variable in variables.items() if name in coordinates},
        attributes,
    )


def _attributes(owner: netCDF4.Dataset | netCDF4.Variable[Any]) -> dict[str, Any]:
    return {name: owner.getncattr(name) for name in owner.ncattrs()}


def _values(stored: netCDF4.Variable[Any], source: Path) -> npt.NDArray[np.generic]:
    values = np.asarray(stored[...])
    if stored.dtype is not str:
        return values
    longest = max(map(len, values.ravel().tolist()), default=0)
    if values.size * longest * 4 > LARGEST_CONTENT:
        raise ArchiveError(f"{source} declares absurdly long strings in {stored.name!r}")
    return values.astype(str)


def _refuse_other_formats(file: netCDF4.Dataset, source: Path) -> None:
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


def _refuse_other_content(file: netCDF4.Dataset, source: Path) -> None:
    if file.groups or file.cmptypes or file.vltypes or file.enumtypes:
        raise ArchiveError(f"{source} is not an archive of rotor_ida: it has groups or own types")
    for name, stored in file.variables.items():
        if stored.dtype is not str and np.dtype(stored.dtype).newbyteorder("=") not in NUMERIC:
            raise ArchiveError(f"{source} is not an archive of rotor_ida: see variable {name!r}")


def _refuse_absurd_sizes(file: netCDF4.Dataset, source: Path) -> None:
    length = source.stat().st_size
    declared = sum(
        math.prod(stored.shape) * (16 if stored.dtype is str else stored.dtype.itemsize)
        for stored in file.variables.values()
    )
    possible = min(LARGEST_CONTENT, LARGEST_COMPRESSION * length + SMALLEST_ALLOWANCE)
    if declared > possible:
        raise ArchiveError(
            f"{source} declares {declared:.3g} bytes of data: it has {length} bytes, and "
            f"{possible:.3g} is the most that is read from it"
        )
