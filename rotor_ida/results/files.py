"""Write files atomically, after checking their paths.

A file is written in a separate folder beside its target, synchronised to the disk, and renamed in
one step. The folder is locked while its writer lives. A killed writer leaves it unlocked, and the
next writer removes it.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from rotor_ida.checks import check_flag, shown
from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.formats.replacing import put

_UNFINISHED = "rotor_ida-part"
_NO_LINKS_HERE = {errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK}
_NO_SYNC_HERE = {errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EACCES}


def check_path(name: str, path: object, *, kind: str = "file") -> Path:
    """Return the path, given as the argument `name`, of a file or folder that may not exist yet.

    Examples
    --------
    >>> check_path("study", "", kind="folder")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: study must be the path of a folder, got ''
    """
    text = os.fspath(path) if isinstance(path, (str, os.PathLike)) else None
    if not isinstance(text, str) or "\0" in text or not text:
        raise InputError(f"{name} must be the path of a {kind}, got {shown(path)}")
    try:
        # netCDF takes no other names; the folder need not have been named
        os.path.realpath(text).encode()
        os.lstat(text)
    except UnicodeEncodeError as error:
        raise InputError(f"{name} must be a path in valid Unicode, got {shown(text)}") from error
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise InputError(f"{name} must be a shorter path, got {shown(text)}") from error
    return Path(text)


def check_target(
    name: str, path: object, *, overwrite: object, permission: str = "overwrite=True"
) -> Path:
    """Return the path, given as the argument `name`, of a file that can be written.

    Its folder must exist. Without `overwrite` an existing file is refused; `permission` states in
    the message how to allow its replacement.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check_target("out", folder, overwrite=True)
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: out must be a file, got the folder '...'
    """
    given = check_path(name, path)
    check_flag("overwrite", overwrite)
    target = Path(os.path.realpath(given))
    if os.path.isdir(target):
        raise InputError(f"{name} must be a file, got the folder {shown(given)}")
    if not os.path.isdir(target.parent):
        raise InputError(f"{name} must be in a folder that exists, got {shown(given)}")
    if os.path.exists(target) and not os.path.isfile(target):
        raise InputError(f"{name} must be a file, got the device or pipe {shown(given)}")
    if os.path.exists(target) and not overwrite:
        raise already_there(given, permission)
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"{name} must be in a folder that can be written to, got {shown(given)}")
    return given


def already_there(path: Path, permission: str = "overwrite=True") -> InputError:
    """Return the error for a file that may not be replaced."""
    return InputError(f"{shown(path)} already exists; pass {permission} to replace it")


@contextmanager
def file_to_write(path: Path, *, overwrite: bool) -> Iterator[Path]:
    """Yield the path of a file to write, which then becomes the file at `path` in one step.

    Parameters
    ----------
    path : Path
        From `check_target`. If it is a symbolic link, its target is replaced, not the link.
    overwrite : bool
        Whether a file that exists, or has appeared meanwhile, may be replaced.

    Yields
    ------
    Path
        The file to write, alone in a folder on the same disk, which is removed afterwards.

    Raises
    ------
    InputError
        If `overwrite` is false and the name is taken by then.
    ArchiveError
        If the system refuses to write it, for example on a full disk, or a library cannot.

    Notes
    -----
    If the body raises, `path` is unchanged. On a file system without hard links, a process killed
    while it publishes without `overwrite` can leave an empty file.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name, "word.txt")
    >>> with file_to_write(path, overwrite=False) as part:
    ...     _ = part.write_text("whole")
    >>> path.read_text(), len(os.listdir(folder.name))
    ('whole', 1)
    >>> folder.cleanup()
    """
    target = Path(os.path.realpath(path))
    try:
        with _folder_beside(target) as folder:
            part = folder / target.name
            yield part
            with part.open("rb+") as file:
                os.fsync(file.fileno())
            _publish(part, target, overwrite)
        _sync_folder(target.parent)
    except FileExistsError:
        raise already_there(path) from None
    except (OSError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) else None
        if reason is None:  # netCDF hides a full disk
            free = shutil.disk_usage(path.parent).free / 2**20
            reason = f"{' '.join(str(error).split())} ({free:.0f} MiB are free on the disk)"
        raise ArchiveError(f"cannot write {path}: {reason}") from error


@contextmanager
def _folder_beside(target: Path) -> Iterator[Path]:
    _remove_abandoned(target.parent)
    folder, lock = _locked_folder(target.parent)
    try:
        yield folder
    finally:
        lock.release()  # first, since Windows does not remove a file that is open
        shutil.rmtree(folder, ignore_errors=True)


def _locked_folder(parent: Path) -> tuple[Path, FileLock]:
    while True:
        folder = parent / f".{_machine()}.{secrets.token_hex(4)}.{_UNFINISHED}"
        folder.mkdir(mode=0o700)
        lock = _lock_of(folder)
        # another writer may remove it before it is locked, even while filelock checks that it
        # exists
        with suppress(Timeout, FileNotFoundError, FileExistsError):
            lock.acquire()
            if folder.exists():
                return folder, lock
            lock.release()


def _remove_abandoned(folder: Path) -> None:
    """Remove folders of writers on this machine that have certainly ended."""
    pattern = re.compile(rf"\.{_machine()}\.[0-9a-f]{{8}}\.{_UNFINISHED}")
    with suppress(OSError), os.scandir(folder) as entries:
        left = [each for each in entries if pattern.fullmatch(each.name)]
        for entry in left:
            if entry.is_dir(follow_symlinks=False):
                with suppress(OSError):
                    with _lock_of(Path(entry.path)):  # refused while the writer lives
                        shutil.rmtree(entry.path, ignore_errors=True)
                    os.rmdir(entry.path)  # on Windows, where the lock was still open


def _lock_of(folder: Path) -> FileLock:
    return FileLock(folder / "lock", blocking=False)


def _machine() -> str:
    """Return what tells this machine from others, in few characters."""
    return hashlib.sha256(socket.gethostname().encode()).hexdigest()[:8]


def _publish(part: Path, target: Path, overwrite: bool) -> None:
    """Give the finished file its name; without `overwrite`, only if the name is free."""
    if overwrite:
        put(part, target)
        return
    try:
        os.link(part, target)
    except OSError as error:
        if error.errno not in _NO_LINKS_HERE:
            raise
        os.close(os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        put(part, target)


def _sync_folder(folder: Path) -> None:
    """Make the new name survive a power failure, where folders can be synchronised."""
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
