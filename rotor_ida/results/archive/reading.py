"""Read an archive; refuse untrusted files before reading their data."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from xarray.backends import BackendArray
from xarray.core.indexing import ExplicitIndexer, LazilyIndexedArray

from rotor_ida.checks import check_flag, shown
from rotor_ida.errors import ArchiveError, InputError, MissingFileError
from rotor_ida.formats.hdf5 import what_is_not_own
from rotor_ida.results.archive.checksum import content_sha256, seal_of
from rotor_ida.results.archive.content import (
    CHECKSUM,
    FORMAT,
    FORMAT_NUMBER,
    LABEL_OF,
    LOCK,
    NUMERIC,
)
from rotor_ida.results.files import check_path

if TYPE_CHECKING:
    import netCDF4

    Stored = netCDF4.Variable[Any]

LARGEST_CONTENT = 64 * 2**30  # bytes in memory
LARGEST_COMPRESSION = 1100  # deflate reaches 1032
SMALLEST_ALLOWANCE = 2**20  # bytes

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def load(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read an archive written by `save` into memory.

    Parameters
    ----------
    path : path-like
        The file. It is closed when the function returns.

    Returns
    -------
    xr.Dataset
        The dataset that was saved, with the six global attributes that `save` adds.

    Raises
    ------
    InputError
        If `path` is a folder; if there is no such file, the error is a `FileNotFoundError` too.
    ArchiveError
        If the file is not an archive of this package, has another format, is damaged or altered,
        refers to other files, declares more data than it can contain, or does not match its
        checksum.

    See Also
    --------
    open_archive : For archives larger than memory.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.results.archive import save
    >>> folder = tempfile.TemporaryDirectory()
    >>> run = xr.Dataset({"x": ("t", [0.0, np.nan])}, attrs={"omega": 1.7})
    >>> again = load(save(run, folder.name + "/run.nc"))
    >>> again["x"].identical(run["x"])
    True
    >>> str(again.attrs["Conventions"]), int(again.attrs["rotor_ida_format"])
    ('CF-1.11', 3)
    >>> load(folder.name + "/walk.nc")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.MissingFileError: path must be a file that exists, got '.../walk.nc'
    >>> folder.cleanup()
    """
    source = _check_source(path)
    with _reported(source):
        return _load(source)


def open_archive(path: str | os.PathLike[str], *, check: bool = True) -> xr.Dataset:
    """Open an archive written by `save`; numbers are read when they are used.

    Parameters
    ----------
    path : path-like
        The file. It stays open until the dataset is closed; do not change it until then.
    check : bool
        Whether to read it once, block by block, and verify the seal and the checksum of the
        content. If not, the file must still have a seal.

    Returns
    -------
    xr.Dataset
        As from `load`, with texts and coordinates of dimensions in memory. Use it in a ``with``
        statement or call its ``close``.

    Raises
    ------
    InputError, ArchiveError
        As by `load`.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.results.archive import save
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = save(xr.Dataset({"x": ("t", np.arange(1e5))}), folder.name + "/run.nc")
    >>> with open_archive(path) as run:
    ...     run.x[-2:].values
    array([99998., 99999.])
    >>> folder.cleanup()
    """
    check_flag("check", check)
    source = _check_source(path)
    with _reported(source):
        return _open(source, check=check)


def _check_source(path: object) -> Path:
    source = check_path("path", path)
    if os.path.isdir(source):
        raise InputError(f"path must be a file, got the folder {shown(source)}")
    if not os.path.isfile(source):
        raise MissingFileError(f"path must be a file that exists, got {shown(source)}")
    return source


@contextmanager
def _reported(source: Path) -> Iterator[None]:
    try:
        yield
    except ArchiveError:
        raise
    except Exception as error:  # a damaged file can make the libraries raise anything
        told = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        reason = " ".join(told.split()) or type(error).__name__
        raise ArchiveError(f"cannot read {source}, which may be damaged: {reason}") from error


def _load(source: Path) -> xr.Dataset:
    _refuse_unsound(source, check=True)
    with LOCK:
        dataset = _read(source, lambda _, stored: _values(stored, source), in_memory=True)
    _check_content(dataset, source)
    return dataset


def _open(source: Path, *, check: bool) -> xr.Dataset:
    _refuse_unsound(source, check=check)
    stored = xr.open_dataset(source, engine="netcdf4", decode_cf=False, cache=False)
    try:
        with LOCK:
            dataset = _read(source, lambda name, _: _unread(stored.variables[name], source))
        if check:
            _check_content(dataset, source)
    except BaseException:
        stored.close()
        raise
    dataset.set_close(stored.close)
    return dataset


class _Unread(BackendArray):
    """Numbers in a file, whose damage is reported when they are read."""

    def __init__(self, inner: Any, source: Path) -> None:
        self.inner, self.source = inner, source
        self.shape, self.dtype = inner.shape, inner.dtype

    def __getitem__(self, key: ExplicitIndexer) -> object:
        with _reported(self.source):
            return self.inner[key]


def _unread(stored: xr.Variable, source: Path) -> object:
    """Return the numbers of a variable, which are in memory for a coordinate of a dimension."""
    inner: Any = stored._data
    while not isinstance(inner, BackendArray):  # xarray's wrappers of what reads the file
        if not hasattr(inner, "array"):
            return stored._data
        inner = inner.array
    return LazilyIndexedArray(_Unread(inner, source))


def _refuse_unsound(source: Path, *, check: bool) -> None:
    """Refuse files that could make the HDF5 library crash or loop forever."""
    with source.open("rb") as file:
        if file.read(len(_HDF5_SIGNATURE)) != _HDF5_SIGNATURE:
            raise ArchiveError(f"{source} is not an archive of rotor_ida: it is not netCDF-4")
    seal = seal_of(source, check=check)
    if seal != "good":
        what = "it has no seal" if seal == "none" else "its bytes are not those that were sealed"
        raise ArchiveError(
            f"{source} is damaged, was altered or is not an archive of rotor_ida: {what}; "
            "xarray.open_dataset and ncdump may still open it"
        )
    with LOCK:
        other = what_is_not_own(source, groups=False)
    if other:
        raise ArchiveError(f"{source} is not a sound archive: it contains {other}")


def _check_content(dataset: xr.Dataset, source: Path) -> None:
    if content_sha256(dataset) != dataset.attrs.get(CHECKSUM):
        raise ArchiveError(
            f"{source} is damaged or was altered: its content does not have the checksum "
            f"{CHECKSUM} that it was saved with"
        )


def _read(
    source: Path, take: Callable[[str, Stored], Any], *, in_memory: bool = False
) -> xr.Dataset:
    """Return the dataset in a file, with numbers from `take(name, variable)`."""
    import netCDF4  # noqa: PLC0415 - not needed to import the package

    with netCDF4.Dataset(source) as file:
        file.set_auto_maskandscale(False)
        _refuse_other_formats(file, source)
        _refuse_absurd_sizes(file, source, in_memory=in_memory)
        attributes = _attributes(file)
        coordinates = {*file.dimensions, *str(attributes.pop("coordinates", "")).split()}
        variables: dict[str, xr.Variable] = {}
        for name, stored in file.variables.items():
            its_own = _attributes(stored)
            coordinates.update(str(its_own.pop("coordinates", "")).split())
            values = _values(stored, source) if _holds_texts(stored) else take(name, stored)
            known_as = str(its_own.pop(LABEL_OF, name))
            variables[known_as] = xr.Variable(stored.dimensions, values, its_own)
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in coordinates},
        {name: variable for name, variable in variables.items() if name in coordinates},
        attributes,
    )


def _refuse_other_formats(file: netCDF4.Dataset, source: Path) -> None:
    """Refuse formats that this version cannot read, and files with groups or types."""
    number = file.getncattr(FORMAT) if FORMAT in file.ncattrs() else "none"
    if not isinstance(number, np.integer) or number != FORMAT_NUMBER:
        raise ArchiveError(
            f"{source} has format {number}, but this version of rotor_ida reads format "
            f"{FORMAT_NUMBER} only; xarray.open_dataset and ncdump still open it"
        )
    if file.groups or file.cmptypes or file.vltypes or file.enumtypes:
        raise ArchiveError(f"{source} is not a sound archive: it has groups or user-defined types")
    for name, stored in file.variables.items():
        if not _holds_texts(stored) and np.dtype(stored.dtype).newbyteorder("=") not in NUMERIC:
            raise ArchiveError(f"{source} is not a sound archive: see variable {name!r}")


def _refuse_absurd_sizes(file: netCDF4.Dataset, source: Path, *, in_memory: bool) -> None:
    """Refuse more data than the file can contain, or than `load` allows in memory."""
    length = source.stat().st_size
    declared = sum(
        math.prod(stored.shape) * (16 if _holds_texts(stored) else stored.dtype.itemsize)
        for stored in file.variables.values()
    )
    possible = LARGEST_COMPRESSION * length + SMALLEST_ALLOWANCE
    if declared > possible:
        raise ArchiveError(
            f"{source} declares {declared:.3g} bytes of data, but has {length} bytes, from which "
            f"at most {possible:.3g} are read"
        )
    if in_memory and declared > LARGEST_CONTENT:
        raise ArchiveError(
            f"{source} contains {declared:.3g} bytes of data, and load reads at most "
            f"{LARGEST_CONTENT:.3g} into memory: open_archive reads larger ones"
        )


def _attributes(owner: netCDF4.Dataset | Stored) -> dict[str, Any]:
    return {name: owner.getncattr(name) for name in owner.ncattrs()}


def _holds_texts(stored: Stored) -> bool:
    return bool(stored.dtype == str)


def _values(stored: Stored, source: Path) -> npt.NDArray[np.generic]:
    values: npt.NDArray[np.generic] = np.asarray(stored[...])
    if not _holds_texts(stored):
        return values
    longest = max(map(len, values.ravel().tolist()), default=0)
    if values.size * longest * 4 > LARGEST_CONTENT:
        raise ArchiveError(f"{source} declares unreasonably long strings in {stored.name!r}")
    return values.astype(str)
