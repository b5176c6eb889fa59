"""Write an archive: check it, write it with netCDF4 block by block, seal it and publish it."""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from rotor_ida.results.archive.checksum import (
    CHUNK,
    Array,
    Index,
    append_seal,
    content_sha256,
    largest_block,
)
from rotor_ida.results.archive.content import (
    CHECKSUM,
    CREATED,
    HISTORY,
    LABEL_OF,
    LOCK,
    NUMERIC,
    archived_form,
    coordinates_of,
    stored_names,
)
from rotor_ida.results.files import check_target, file_to_write
from rotor_ida.results.provenance import command

if TYPE_CHECKING:
    import netCDF4


def save(dataset: xr.Dataset, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
    """Write `dataset` to a netCDF file at `path` atomically.

    Parameters
    ----------
    dataset : xr.Dataset
        Variables of integers, float32, float64 or strings; attributes that are strings, numbers
        or one-dimensional numeric arrays. It is not changed.
    path : path-like
        The file. Its folder must exist.
    overwrite : bool
        Whether an existing file may be replaced.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to; if `path` is a folder; if a file
        exists and `overwrite` is false, even one that appeared during writing; or for a name,
        dtype or attribute that an archive cannot store.
    ArchiveError
        If the file cannot be written: a full disk, for example.

    Notes
    -----
    The file gets six global attributes: ``Conventions``, ``rotor_ida_format``,
    ``rotor_ida_version`` (kept if `dataset` has one, as that version computed the data),
    ``date_created`` (unchanged if the content is the same), ``history`` (with one line added) and
    ``content_sha256``, the checksum by `content_sha256`, which `load` verifies. They describe the
    file: a loaded dataset that was changed has the old ones until it is saved again.

    A selection of runs, such as a part of a sweep, is saved with its own events alone.

    Numbers that are not in memory, but in another file or to be computed by dask, are written
    block by block.

    netCDF does not distinguish an attribute that is an array of one number from the number: both
    are read back as the number. It has no fixed dimension of length zero, so such a dimension is
    unlimited in the file. String widths and encodings are lost. Compressed variables also have
    HDF5's checksum.

    A process killed while writing leaves `path` unchanged, and perhaps a folder
    ``.*.rotor_ida-part`` beside it, which the next `save` there removes. On a file system without
    hard links, a process killed while it publishes without `overwrite` can leave an empty file.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> run = xr.Dataset({"x": ("t", [0.0, 1.0])}, attrs={"omega": 1.7})
    >>> save(run, folder.name + "/run.nc").name
    'run.nc'
    >>> save(run, folder.name + "/run.nc")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: '.../run.nc' already exists; pass overwrite=True to replace it
    >>> folder.cleanup()
    """
    shown = check_target("path", path, overwrite=overwrite)
    stored = archived_form(dataset)
    with file_to_write(shown, overwrite=overwrite) as part:
        _write_netcdf(stored, part, dataset.attrs)
        append_seal(part)
    return shown


def now() -> str:
    """Return the time, in UTC, as ISO 8601."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _write_netcdf(stored: xr.Dataset, path: Path, earlier: Mapping[str, Any]) -> None:
    """Write a dataset in its archived form to a new file; `earlier` are the original attributes."""
    import netCDF4  # noqa: PLC0415 - not needed to import the package

    names = stored_names(stored)

    def write(name: str, index: Index, values: Array) -> None:
        numeric = values.dtype in NUMERIC
        with LOCK:
            file[names[name]][index] = (
                np.ascontiguousarray(values) if numeric else values.astype(object)
            )

    with LOCK:
        file = netCDF4.Dataset(path, "w", format="NETCDF4")
    try:
        try:
            with LOCK:
                _define(file, stored, names)
            # computing a block may itself read a file under the lock
            checksum = content_sha256(stored, write)
            with LOCK:
                file.setncatts(_of_the_file(checksum, earlier))
        finally:
            with LOCK:
                file.close()
    except RuntimeError:
        with suppress(OSError):  # Windows truncates no file that is open
            os.truncate(path, 0)  # HDF5 keeps a file that it cannot finish open, and so its space
        raise


def _define(file: netCDF4.Dataset, stored: xr.Dataset, names: Mapping[str, str]) -> None:
    file.set_auto_maskandscale(False)
    for dim, size in stored.sizes.items():
        file.createDimension(str(dim), size)
    coordinates, others = coordinates_of(stored)
    for name, name_in_file in names.items():
        variable = stored.variables[name]
        attributes = {**variable.attrs, **({LABEL_OF: name} if name_in_file != name else {})}
        if name in coordinates:
            attributes["coordinates"] = coordinates[name]
        _create(file, name_in_file, variable).setncatts(attributes)
    file.setncatts({**stored.attrs, **({"coordinates": others} if others else {})})


def _create(file: netCDF4.Dataset, name: str, variable: xr.Variable) -> netCDF4.Variable[Any]:
    dims = tuple(str(dim) for dim in variable.dims)
    if variable.dtype not in NUMERIC:
        # HDF5's filters skip variable-length strings; the checksum of the content covers them.
        return file.createVariable(name, str, dims)
    if variable.ndim == 0 or variable.size == 0:
        return file.createVariable(name, variable.dtype, dims)
    return file.createVariable(
        name,
        variable.dtype,
        dims,
        compression="zlib",
        complevel=4,
        shuffle=True,
        fletcher32=True,
        chunksizes=largest_block(variable.shape, variable.dtype.itemsize, CHUNK),
    )


def _of_the_file(checksum: str, earlier: Mapping[str, Any]) -> dict[str, object]:
    """Return the attributes of the file; content that is saved again keeps its date."""
    import netCDF4  # noqa: PLC0415 - not needed to import the package

    moment = now()
    line = (
        f"{moment} rotor_ida {importlib.metadata.version('rotor-ida')}: saved by {command()} with "
        f"netCDF4 {netCDF4.__version__}, netCDF-C {netCDF4.__netcdf4libversion__}, "
        f"HDF5 {netCDF4.__hdf5libversion__}"
    )
    history = earlier.get(HISTORY, "").rstrip()
    again = earlier.get(CHECKSUM) == checksum
    return {
        CREATED: earlier.get(CREATED, moment) if again else moment,
        HISTORY: f"{history}\n{line}" if history else line,
        CHECKSUM: checksum,
    }
