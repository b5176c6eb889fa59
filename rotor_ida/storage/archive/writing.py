"""Writing an archive: to a temporary file beside it, then published in one step."""

from __future__ import annotations

import errno
import os
import shutil
from functools import partial
from pathlib import Path

import xarray as xr

from rotor_ida import checks
from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.provenance import command
from rotor_ida.storage.archive.content import CHECKSUM, archived_form
from rotor_ida.storage.archive.conventions import CREATED, HISTORY, history_with, libraries, now
from rotor_ida.storage.archive.netcdf import write_netcdf
from rotor_ida.storage.archive.parts import part_beside
from rotor_ida.storage.archive.seal import append_seal

_NO_LINKS_HERE = {errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK}
_NO_SYNC_HERE = {errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EACCES}


def save(dataset: xr.Dataset, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
    """Write `dataset` to a netCDF file at `path`, wholly or not at all.

    Parameters
    ----------
    dataset : xr.Dataset
        Variables of integers, float32, float64 or strings; attributes that are strings, numbers
        or one-dimensional numeric arrays. It is left as it was.
    path : path-like
        Where to write. The folder must exist.
    overwrite : bool
        Whether a file that is there may be replaced.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    InputError
        If the folder does not exist, `path` is a folder, or a file is there and `overwrite` is
        false, even one that appeared during the writing; or for a name, dtype or attribute that
        an archive cannot keep.
    ArchiveError
        If the system does not let the file be written: a full disk, a missing permission.

    Notes
    -----
    The file gets six global attributes, which `load` shows: ``Conventions``,
    ``rotor_ida_format``, ``rotor_ida_version`` (unless `dataset` has one: it says what computed
    the data), ``date_created`` (kept if the content is the same), ``history`` (one line more) and
    ``content_sha256``, the checksum of `content_sha256`, which `load` verifies. They describe the
    file: a dataset that was changed since it was loaded carries the
    old ones until it is saved again.

    Numbers that are not in memory, but in another file or to be computed by dask, are written
    slab by slab. The disk must have room for the numbers uncompressed, at most 32 MiB at a time.

    netCDF makes no difference between an attribute that is an array of one number and the number:
    both come back as the number. It has no fixed dimension of length zero: such a one is unlimited
    in the file, the others are fixed. The width of strings and encodings are not kept. Compressed
    variables carry HDF5's own checksum beside.

    A process that is killed while it writes leaves `path` as it was, and perhaps a folder
    ``.*.rotor_ida-part`` beside it, which the next `save` there removes. On a file system without
    hard links the moment of publishing without `overwrite` can leave an empty file in such a case.

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
    rotor_ida.errors.InputError: path must not exist unless overwrite is true, got '.../run.nc'
    >>> folder.cleanup()
    """
    shown = _check_path(path)
    # Through a symbolic link the file that it names is replaced, not the link.
    target = Path(os.path.realpath(shown))
    _check_target(shown, target, overwrite)
    kept = archived_form(dataset)
    try:
        with part_beside(target) as part:
            write_netcdf(kept, part, partial(_of_this_file, dataset, now()))
            append_seal(part)
            _publish(part, target, overwrite)
        _sync_folder(target.parent)
    except FileExistsError:
        raise _exists(shown) from None
    except (OSError, RuntimeError) as error:
        raise ArchiveError(f"cannot write {shown}: {_reason(error, target.parent)}") from error
    return shown


def _of_this_file(dataset: xr.Dataset, moment: str, checksum: str) -> dict[str, object]:
    """Return the attributes that tell of the file; a content saved again keeps its date."""
    again = dataset.attrs.get(CHECKSUM) == checksum
    event = f"saved by {command()} with {libraries()}"
    return {
        CREATED: dataset.attrs.get(CREATED, moment) if again else moment,
        HISTORY: history_with(dataset.attrs.get(HISTORY, ""), event, moment),
        CHECKSUM: checksum,
    }


def _check_path(path: object) -> Path:
    if not isinstance(path, (str, os.PathLike)) or "\0" in str(path) or not str(path):
        raise InputError(f"path must be the path of a file, got {checks.shown(path)}")
    return Path(path)


def _check_target(shown: Path, target: Path, overwrite: object) -> None:
    if not isinstance(overwrite, bool):
        raise InputError(f"overwrite must be true or false, got {checks.shown(overwrite)}")
    if os.path.isdir(target):
        raise InputError(f"path must be a file, got the folder {str(shown)!r}")
    if not os.path.isdir(target.parent):
        raise InputError(f"path must be in a folder that exists, got {str(shown)!r}")
    if os.path.exists(target) and not os.path.isfile(target):
        raise InputError(f"path must be a file, got the device or pipe {str(shown)!r}")
    if os.path.exists(target) and not overwrite:
        raise _exists(shown)


def _exists(shown: Path) -> InputError:
    return InputError(f"path must not exist unless overwrite is true, got {str(shown)!r}")


def _publish(part: Path, target: Path, overwrite: bool) -> None:
    """Give the finished file its name; without `overwrite`, only if nothing has that name."""
    if overwrite:
        part.replace(target)
        return
    try:
        os.link(part, target)
    except OSError as error:
        if error.errno not in _NO_LINKS_HERE:
            raise
        os.close(os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        part.replace(target)


def _sync_folder(folder: Path) -> None:
    """Make the new name outlast a power failure, where folders can be synchronised."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC_HERE:
            raise
    finally:
        os.close(descriptor)


def _reason(error: Exception, folder: Path) -> str:
    """Return one line; the netCDF library hides a full disk, so it also says how full it is."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    free = shutil.disk_usage(folder).free
    return f"{' '.join(str(error).split())} ({free / 2**20:.0f} MiB are free on the disk)"
