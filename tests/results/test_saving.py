"""An archive is written wholly or not at all, whoever else writes, kills or fills the disk."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.results.archive import load, save, writing
from tests.example_datasets import a_dataset


def leftovers(folder: Path, *expected: str) -> list[str]:
    return sorted(set(os.listdir(folder)) - set(expected))


def test_overwrite_through_a_link_keeps_the_link(archive: Path, tmp_path: Path) -> None:
    (tmp_path / "latest.nc").symlink_to("run.nc")
    save(a_dataset(7), tmp_path / "latest.nc", overwrite=True)
    assert (tmp_path / "latest.nc").is_symlink()
    assert load(archive).sizes["t"] == 7


def test_permissions_follow_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        path = save(a_dataset(), tmp_path / "run.nc")
    finally:
        os.umask(before)
    assert path.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("links", ["links", "no links"])
def test_file_that_appears_meanwhile_is_not_lost(
    links: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.nc"
    seal = writing.append_seal

    def write_slowly(part: Path) -> None:
        seal(part)
        path.write_text("another process was faster")

    monkeypatch.setattr(writing, "append_seal", write_slowly)
    if links == "no links":
        monkeypatch.setattr(os, "link", no_links)
    with pytest.raises(InputError, match="already exists; pass overwrite=True to replace it"):
        save(a_dataset(), path)
    assert path.read_text() == "another process was faster"
    assert not leftovers(tmp_path, "run.nc")


def no_links(source: object, target: object) -> None:
    raise OSError(errno.EPERM, "no hard links here")


def test_file_system_without_links_will_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", no_links)
    path = save(a_dataset(), tmp_path / "run.nc")
    assert load(path).sizes["t"] == 50
    assert not leftovers(tmp_path, "run.nc")


@pytest.mark.parametrize("place", ["append_seal", "fsync", "link"])
@pytest.mark.parametrize("failure", [KeyboardInterrupt(), OSError(errno.EACCES, "No permission")])
def test_failure_leaves_nothing_behind(
    place: str, failure: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*args: object, **kwargs: object) -> None:
        raise failure

    with monkeypatch.context() as patch:
        patch.setattr(writing if place == "append_seal" else os, place, fail)
        expected = ArchiveError if isinstance(failure, OSError) else KeyboardInterrupt
        with pytest.raises(expected) as caught:
            save(a_dataset(), tmp_path / "run.nc")
    assert not leftovers(tmp_path)
    if expected is ArchiveError:
        assert str(caught.value) == f"cannot write {tmp_path / 'run.nc'}: No permission"
    load(save(a_dataset(), tmp_path / "run.nc"))


def test_file_that_may_not_grow_is_reported_and_takes_no_space(
    archive: Path, tmp_path: Path
) -> None:
    before = archive.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, limits[1]))
    try:
        with pytest.raises(ArchiveError, match=r"cannot write .*run.nc: .* \(\d+ MiB are free on"):
            save(a_dataset(100_000), archive, overwrite=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    # HDF5 has it open until the process ends
    assert [each.stat().st_size for each in Path("/proc/self/fd").iterdir()
            if "rotor_ida-part/run.nc" in os.path.realpath(each)] == [0]  # fmt: skip
    assert archive.read_bytes() == before
    assert not leftovers(tmp_path, "run.nc")


@pytest.mark.parametrize("moment", ["half written", "published"])
def test_process_killed_leaves_the_old_or_the_new(moment: str, tmp_path: Path) -> None:
    path = save(a_dataset(), tmp_path / "run.nc")
    program = f"""
import os, sys
import xarray as xr
from rotor_ida.results import files
from rotor_ida.results.archive import save, writing
def die(part):
    if {moment!r} == "half written":
        os.truncate(part, os.path.getsize(part) // 2)
    os._exit(9)
if {moment!r} == "published":
    files._sync_folder = lambda folder: os._exit(9)
else:
    writing.append_seal = die
save(xr.Dataset({{"x": ("t", [1.0] * 1000)}}), sys.argv[1], overwrite=True)
"""
    ended = subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    assert ended.returncode == 9
    assert load(path).sizes["t"] == (1000 if moment == "published" else 50)
    save(a_dataset(7), path, overwrite=True)
    assert not leftovers(tmp_path, "run.nc")


def test_two_processes_may_save_to_one_path(tmp_path: Path) -> None:
    program = """
import sys
import numpy as np, xarray as xr
from rotor_ida import InputError, save
data = xr.Dataset({"x": ("t", np.full(50_000, float(sys.argv[2])))})
try:
    save(data, sys.argv[1] + "/first.nc")
    print("first")
except InputError as error:
    assert "already exists; pass overwrite=True to replace it" in str(error)
for _ in range(8):
    save(data, sys.argv[1] + "/last.nc", overwrite=True)
"""
    save(a_dataset(), tmp_path / "last.nc")
    writers = [
        subprocess.Popen([sys.executable, "-c", program, tmp_path, number], stdout=-1)
        for number in ("1", "2")
    ]
    while any(writer.poll() is None for writer in writers):
        seen = load(tmp_path / "last.nc").x
        assert seen.size == 50 or (seen.size == 50_000 and len(np.unique(seen)) == 1)
    said = [writer.communicate()[0] for writer in writers]
    assert [writer.returncode for writer in writers] == [0, 0]
    assert sorted(said) == [b"", b"first\n"]
    assert len(np.unique(load(tmp_path / "first.nc").x)) == 1
    assert not leftovers(tmp_path, "first.nc", "last.nc")


def test_threads_may_save_and_load(tmp_path: Path) -> None:
    shared = save(a_dataset(), tmp_path / "shared.nc")
    ready = threading.Barrier(8)

    def work(number: int) -> None:
        ready.wait()
        for turn in range(5):
            dataset = a_dataset(20 + number, seed=turn)
            path = save(dataset, tmp_path / f"{number}.nc", overwrite=True)
            loaded = load(path)
            assert loaded.x.identical(dataset.x)
            save(dataset, shared, overwrite=True)
            assert load(shared).sizes["start"] == 2

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(work, range(8)))
    assert len(leftovers(tmp_path)) == 9


def test_failure_of_the_folder_to_synchronise_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sync = os.fsync

    def fail_on_folders(descriptor: int) -> None:
        if os.path.isdir(f"/proc/self/fd/{descriptor}"):
            raise OSError(number, os.strerror(number))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", fail_on_folders)
    number = errno.EINVAL
    load(save(a_dataset(), tmp_path / "run.nc"))
    number = errno.EIO
    with pytest.raises(ArchiveError, match="Input/output error"):
        save(a_dataset(), tmp_path / "run.nc", overwrite=True)
