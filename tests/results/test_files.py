"""Files are written whole or not at all, and where they cannot go is said before."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from filelock import FileLock

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.formats import replacing
from rotor_ida.results import files
from rotor_ida.results.files import check_path, check_target, file_to_write


class PathOfBytes(os.PathLike[bytes]):
    """A path that is no text."""

    def __fspath__(self) -> bytes:
        return b"file"


@pytest.mark.parametrize("path", ["", None, 3, "a\0b", b"file", PathOfBytes()])
def test_what_is_no_path_is_refused(path: object) -> None:
    with pytest.raises(InputError, match="out must be the path of a file, got"):
        check_target("out", path, overwrite=False)
    with pytest.raises(InputError, match="study must be the path of a folder, got"):
        check_path("study", path, kind="folder")


@pytest.mark.skipif(os.name == "nt", reason="errors of POSIX")
def test_a_path_that_no_system_takes_is_refused_in_a_short_line() -> None:
    with pytest.raises(InputError, match="study must be a shorter path, got 'aaa") as caught:
        check_path("study", "a" * 100_000, kind="folder")
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize("path", ["a\udcff.nc", "b\ud800/c.nc"])
def test_a_path_that_is_no_unicode_is_refused_in_one_line(path: str) -> None:
    """A name of bytes that are no UTF-8, which netCDF cannot write; and half a pair."""
    with pytest.raises(InputError, match=r"path must be a path in valid Unicode, got '[ab]"):
        check_path("path", path)


def test_target_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    there = tmp_path / "there.txt"
    there.write_text("before")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "astray").symlink_to(tmp_path / "nowhere" / "file")
    for path, overwrite, message in [
        (there, False, "'.*there.txt' already exists; pass --force to replace it"),
        (tmp_path, True, "out must be a file, got the folder"),
        (tmp_path / "nowhere" / "file", False, "out must be in a folder that exists, got"),
        (tmp_path / "astray", True, "out must be in a folder that exists, got '.*astray'"),
        (there / "file", False, "out must be in a folder that exists, got"),
        (tmp_path / "pipe", True, "out must be a file, got the device or pipe"),
        (there, 1, "overwrite must be true or false, got 1"),
    ]:
        with pytest.raises(InputError, match=message):
            check_target("out", path, overwrite=overwrite, permission="--force")
    assert check_target("out", there, overwrite=True) == there
    assert check_target("out", str(tmp_path / "new"), overwrite=False) == tmp_path / "new"


def test_folder_without_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
    with pytest.raises(InputError, match="out must be in a folder that can be written to, got"):
        check_target("out", tmp_path / "file", overwrite=False)


def test_what_a_killed_writer_left_is_removed(tmp_path: Path) -> None:
    with file_to_write(tmp_path / "living", overwrite=False) as part:
        part.write_text("half")
        name = part.parent.name
        left = tmp_path / f"{name[: name.index('.', 1)]}.{'0' * 8}.rotor_ida-part"
        left.mkdir()
        (left / "lock").touch()
        (left / "dead").write_text("half")
        elsewhere = tmp_path / f".elsewhere.{'0' * 8}.rotor_ida-part"
        elsewhere.mkdir()
        with file_to_write(tmp_path / "next", overwrite=False) as other:
            other.write_text("whole")
        assert not left.exists()
    assert sorted(os.listdir(tmp_path)) == [elsewhere.name, "living", "next"]


@pytest.mark.parametrize("error", [FileNotFoundError, FileExistsError])
def test_a_folder_that_another_writer_removes_is_made_anew(
    error: type[OSError], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between its being made and being locked; filelock then raises the one or the other."""
    target, lock_of, seen = tmp_path / "file", files._lock_of, []

    def lock_of_removed(folder: Path) -> FileLock:
        seen.append(folder)
        if len(seen) > 1:
            return lock_of(folder)
        folder.rmdir()
        lock = lock_of(folder)
        monkeypatch.setattr(type(lock), "_acquire", removed)
        return lock

    def removed(lock: FileLock) -> None:
        monkeypatch.undo()
        monkeypatch.setattr(files, "_lock_of", lock_of_removed)
        raise error(lock.lock_file)

    monkeypatch.setattr(files, "_lock_of", lock_of_removed)
    target.write_text("before")
    with file_to_write(target, overwrite=True) as part:
        part.write_text("after")
    assert target.read_text() == "after"
    assert len(seen) == 2


def test_a_disk_without_room_is_named_with_the_file_which_stays_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "file"
    target.write_text("before")

    def write(*, overwrite: bool) -> None:
        with file_to_write(target, overwrite=overwrite) as part:
            part.write_text("half of it")
            if overwrite:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(ArchiveError, match=r"^cannot write .*file: No space left on device$"):
        write(overwrite=True)
    with pytest.raises(InputError, match="already exists; pass overwrite=True to replace it"):
        write(overwrite=False)
    assert target.read_text() == "before"


@pytest.mark.parametrize(("readers", "tries"), [(0, 1), (2, 3), (9, 3)])
def test_windows_replaces_a_file_once_its_reader_has_closed_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, readers: int, tries: int
) -> None:
    """As Windows has it, which refuses by PermissionError while another process reads."""
    target, part, replace, asked = tmp_path / "file", tmp_path / "part", Path.replace, []

    def replace_later(self: Path, to: Path) -> Path:
        asked.append(to)
        if len(asked) <= readers:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return replace(self, to)

    monkeypatch.setattr(Path, "replace", replace_later)
    monkeypatch.setattr(replacing, "_READERS_HOLD", True)
    monkeypatch.setattr(replacing, "_PAUSES", (0.0, 0.0))
    target.write_text("before")
    part.write_text("after")
    if readers < tries:
        replacing.put(part, target)
    else:
        with pytest.raises(PermissionError):
            replacing.put(part, target)
    assert (len(asked), target.read_text()) == (tries, "after" if readers < tries else "before")
