"""A dataset as a netCDF file: dimensions, variables and attributes written through netCDF4."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from rotor_ida.storage.archive.content import ContentDigest
from rotor_ida.storage.archive.conventions import (
    DOMAIN,
    LABEL_OF,
    coordinates_of,
    stored_names,
    time_domain,
)
from rotor_ida.storage.archive.holdable import NUMERIC
from rotor_ida.storage.archive.library import LOCK
from rotor_ida.storage.archive.slabs import CHUNK, SLAB, block_shape, slabs

if TYPE_CHECKING:
    import netCDF4

OVERHEAD = 2**15  # bytes, more than what HDF5 adds to the values of a variable

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


OfThisFile = Callable[[str], Mapping[str, object]]


def write_netcdf(kept: xr.Dataset, path: Path, of_this_file: OfThisFile) -> None:
    """Write a dataset to a new file.

    Parameters
    ----------
    kept : xr.Dataset
        In the form of `rotor_ida.storage.archive.content.archived_form`.
    path : Path
        The file.
    of_this_file : callable
        Makes the last attributes of the file from the checksum of its content.
    """
    import netCDF4  # noqa: PLC0415 - not needed to import the package

    _make_sure_of_room(path.parent, min(kept.nbytes, SLAB) + OVERHEAD * (8 + len(kept.variables)))
    with LOCK:
        file = netCDF4.Dataset(path, "w", format="NETCDF4")
    try:
        with LOCK:
            _define(file, kept)
        checksum = _write_values(file, kept, path.parent)
        with LOCK:
            file.setncatts(of_this_file(checksum))
    finally:
        with LOCK:
            file.close()


def _make_sure_of_room(folder: Path, size: int) -> None:
    """Raise what the system says where so many bytes may not be written.

    Where a disk is full, HDF5 fails without saying so, and keeps the file and its space until the
    process ends.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    room = folder / "room"
    descriptor = os.open(room, os.O_RDWR | os.O_CREAT)
    try:
        os.posix_fallocate(descriptor, 0, size)
    except OSError as error:
        if error.errno in _NO_ROOM:
            raise OSError(error.errno, os.strerror(error.errno)) from None
    finally:
        os.close(descriptor)
        room.unlink()


def _define(file: netCDF4.Dataset, kept: xr.Dataset) -> None:
    file.set_auto_maskandscale(False)
    for dim, size in kept.sizes.items():
        file.createDimension(str(dim), size)
    coordinates, others = coordinates_of(kept)
    for name, stored_name in stored_names(kept).items():
        variable = kept.variables[name]
        attributes = {**variable.attrs, **({LABEL_OF: name} if stored_name != name else {})}
        if name in coordinates:
            attributes["coordinates"] = coordinates[name]
        _create(file, stored_name, variable).setncatts(attributes)
    domain = time_domain(kept)
    if domain is not None:
        stored = _create(file, DOMAIN, domain)
        stored.setncatts(domain.attrs)
        stored[...] = domain.values
    file.setncatts({**kept.attrs, **({"coordinates": others} if others else {})})


def _create(file: netCDF4.Dataset, name: str, variable: xr.Variable) -> netCDF4.Variable[Any]:
    dims = tuple(str(dim) for dim in variable.dims)
    if variable.dtype not in NUMERIC:
        # Strings of any length go past HDF5's filters; the checksum of the content covers them.
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
        chunksizes=block_shape(variable.shape, variable.dtype.itemsize, CHUNK),
    )


def _write_values(file: netCDF4.Dataset, kept: xr.Dataset, folder: Path) -> str:
    """Write the values slab by slab, each computed or read once, and return their checksum."""
    digest, names = ContentDigest(kept), stored_names(kept)
    for name in digest.names:
        variable = kept.variables[name]
        digest.begin(name)
        if variable.dtype not in NUMERIC:
            digest.add_texts(variable.values)
            with LOCK:
                file[names[name]][...] = variable.values.astype(object)
        else:
            # Computing a slab may itself read a file under the lock.
            for index, values in slabs(variable):
                digest.add_numbers(values)
                if values.nbytes > CHUNK:
                    _make_sure_of_room(folder, values.nbytes + OVERHEAD)
                with LOCK:
                    file[name][index] = np.ascontiguousarray(values)
                del values  # before the next are computed
        digest.end(name)
    return digest.hexdigest()
