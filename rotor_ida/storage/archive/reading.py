"""Reading an archive: what cannot be trusted is refused before its data are read."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.errors import ArchiveError
from rotor_ida.storage.archive import soundness
from rotor_ida.storage.archive.content import CHECKSUM, content_sha256
from rotor_ida.storage.archive.conventions import DOMAIN, LABEL_OF
from rotor_ida.storage.archive.library import LOCK, what_is_no_variable
from rotor_ida.storage.archive.probing import refuse_what_cannot_be_read
from rotor_ida.storage.archive.seal import seal_of

if TYPE_CHECKING:
    import netCDF4

    Stored = netCDF4.Variable[Any]


def load(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read an archive that `save` wrote, fully into memory.

    Parameters
    ----------
    path : path-like
        The file. It is closed again when the function returns.

    Returns
    -------
    xr.Dataset
        The dataset that was saved, with the six global attributes that `save` adds.

    Raises
    ------
    InputError
        If there is no such file, or `path` is a folder.
    ArchiveError
        If the file is not an archive of this package, is of a newer format, is truncated or
        damaged, refers to other files, declares more data than it can hold, or if its content
        does not have the checksum that it was saved with.

    See Also
    --------
    open_archive : For archives larger than memory.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.storage.archive import save
    >>> folder = tempfile.TemporaryDirectory()
    >>> run = xr.Dataset({"x": ("t", [0.0, np.nan])}, attrs={"omega": 1.7})
    >>> again = load(save(run, folder.name + "/run.nc"))
    >>> again["x"].identical(run["x"])
    True
    >>> str(again.attrs["Conventions"]), int(again.attrs["rotor_ida_format"])
    ('CF-1.11', 2)
    >>> load(folder.name + "/walk.nc")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: path must be a file that exists, got '.../walk.nc'
    >>> folder.cleanup()
    """
    return _as_it_stands(path, _load)


def open_archive(path: str | os.PathLike[str], *, check: bool = True) -> xr.Dataset:
    """Open an archive that `save` wrote, whose numbers are read when they are asked for.

    Parameters
    ----------
    path : path-like
        The file. It stays open until the dataset is closed, and is to be left alone until then.
    check : bool
        Whether to read all of it once, slab by slab, and verify its checksums.

    Returns
    -------
    xr.Dataset
        As from `load`; texts and the coordinates of dimensions are in memory. Use it in a ``with``
        statement or call its ``close``.

    Raises
    ------
    InputError, ArchiveError
        As by `load`.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida.storage.archive import save
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = save(xr.Dataset({"x": ("t", np.arange(1e5))}), folder.name + "/run.nc")
    >>> with open_archive(path) as run:
    ...     run.x[-2:].values
    array([99998., 99999.])
    >>> folder.cleanup()
    """
    return _as_it_stands(path, lambda source: _open(source, check=check))


def open_unguarded(source: Path, *, check: bool) -> xr.Dataset:
    """Open a file without regard to its seal: a damaged one can crash the HDF5 library."""
    with _reported(source):
        with LOCK:
            _refuse_links(source)
        stored = xr.open_dataset(source, engine="netcdf4", decode_cf=False, cache=False)
        try:
            with LOCK:
                dataset = _read(source, lambda name, _: _lazy(stored.variables[name]))
            dataset.set_close(stored.close)
            if check:
                _check_content(dataset, source)
        except BaseException:
            stored.close()
            raise
    return dataset


def _as_it_stands(path: str | os.PathLike[str], read: Callable[[Path], xr.Dataset]) -> xr.Dataset:
    while True:
        source = soundness.check_source(path)
        before = _identity(source)
        try:
            return read(source)
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


def _load(source: Path) -> xr.Dataset:
    _guard(source, check=True)
    with _reported(source):
        with LOCK:
            _refuse_links(source)
            dataset = _read(source, lambda _, stored: _values(stored, source), in_memory=True)
        _check_content(dataset, source)
    return dataset


def _open(source: Path, *, check: bool) -> xr.Dataset:
    _guard(source, check=check)
    return open_unguarded(source, check=check)


def _guard(source: Path, *, check: bool) -> None:
    """Keep from the HDF5 library what could make it crash or never end."""
    with _reported(source):
        rest = soundness.refuse_other_kinds(source)
        seal = seal_of(source, check=check)
    if seal == "broken" or (seal == "none" and rest):
        raise ArchiveError(
            f"{source} is damaged or was altered: its bytes are not those that were saved"
        )
    if seal == "none":
        refuse_what_cannot_be_read(source, check=check)


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


def _refuse_links(source: Path) -> None:
    if other := what_is_no_variable(source):
        raise ArchiveError(f"{source} is not a sound archive: it holds {other}")


def _check_content(dataset: xr.Dataset, source: Path) -> None:
    if content_sha256(dataset) != dataset.attrs.get(CHECKSUM):
        raise ArchiveError(
            f"{source} is damaged or was altered: its content does not have the checksum "
            f"{CHECKSUM} that it was saved with"
        )


def _read(
    source: Path, take: Callable[[str, Stored], Any], *, in_memory: bool = False
) -> xr.Dataset:
    import netCDF4  # noqa: PLC0415 - not needed to import the package

    with netCDF4.Dataset(source) as file:
        file.set_auto_maskandscale(False)
        soundness.refuse_other_formats(file, source)
        soundness.refuse_other_content(file, source)
        soundness.refuse_absurd_sizes(file, source, in_memory=in_memory)
        attributes = _attributes(file)
        coordinates = set(str(attributes.pop("coordinates", "")).split())
        variables: dict[str, xr.Variable] = {}
        for name, stored in file.variables.items():
            its_own = _attributes(stored)
            if name == DOMAIN and "dimensions" in its_own:
                continue
            coordinates.update(str(its_own.pop("coordinates", "")).split())
            values = _values(stored, source) if _holds_texts(stored) else take(name, stored)
            known_as = str(its_own.pop(LABEL_OF, name))
            variables[known_as] = xr.Variable(stored.dimensions, values, its_own)
        coordinates.update(file.dimensions)
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in coordinates},
        {name: variable for name, variable in variables.items() if name in coordinates},
        attributes,
    )


def _lazy(variable: xr.Variable) -> Any:
    """Return the values of a variable that xarray has opened, unread."""
    return variable._data


def _attributes(owner: netCDF4.Dataset | Stored) -> dict[str, Any]:
    return {name: owner.getncattr(name) for name in owner.ncattrs()}


def _holds_texts(stored: Stored) -> bool:
    return bool(stored.dtype == str)


def _values(stored: Stored, source: Path) -> npt.NDArray[np.generic]:
    values: npt.NDArray[np.generic] = np.asarray(stored[...])
    if not _holds_texts(stored):
        return values
    longest = max(map(len, values.ravel().tolist()), default=0)
    if values.size * longest * 4 > soundness.LARGEST_CONTENT:
        raise ArchiveError(f"{source} declares absurdly long strings in {stored.name!r}")
    return values.astype(str)
