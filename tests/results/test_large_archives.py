"""Archives larger than memory: written, checked and read block by block."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida import ArchiveError, load, open_archive, save
from rotor_ida.results.archive import checksum, reading
from rotor_ida.results.archive.checksum import append_seal, content_sha256
from rotor_ida.results.archive.content import archived_form

LARGE = """
import resource, sys
import dask.array, netCDF4, numpy as np, xarray as xr
from rotor_ida import open_archive, save
from rotor_ida.results.archive import checksum

checksum.BLOCK = 4 * 2**20

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

before = peak()
motion = dask.array.arange(20_000_000, chunks=1_000_000, dtype="f8") // 1_000_000
save(xr.Dataset({"x": ("t", motion)}), sys.argv[1])
with open_archive(sys.argv[1]) as kept:
    assert kept.x[-1] == 19.0 and kept.sizes["t"] == 20_000_000
    save(kept, sys.argv[2])
print(peak() - before)
"""


def lazy(values: np.ndarray, chunk: int = 7) -> xr.Dataset:
    array = pytest.importorskip("dask.array").from_array(values, chunks=chunk)
    return xr.Dataset({"x": (("t", "start", "part")[: values.ndim], array, {"units": "1"})})


def test_saving_and_opening_hold_a_part_in_memory(tmp_path: Path) -> None:
    pytest.importorskip("dask")
    first, second = tmp_path / "first.nc", tmp_path / "second.nc"
    program = [sys.executable, "-c", LARGE, str(first), str(second)]
    shown = subprocess.run(program, capture_output=True, text=True, check=True)
    # of 153 MiB: what dask and netCDF bring, some 180 MiB, and a few blocks of 4 MiB
    assert float(shown.stdout) < 240
    with open_archive(first, check=False) as one, open_archive(second, check=False) as two:
        assert one.attrs["content_sha256"] == two.attrs["content_sha256"]


@given(st.lists(st.integers(0, 9), max_size=4), st.sampled_from([1, 8]), st.data())
def test_blocks_cover_an_array_once_in_order(
    shape: list[int], itemsize: int, data: st.DataObject
) -> None:
    chunk = data.draw(st.integers(1, 200))
    values = np.arange(np.prod(shape, dtype=int)).reshape(shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checksum, "CHUNK", chunk)
        patch.setattr(checksum, "BLOCK", chunk + data.draw(st.integers(0, 800)))
        indices = list(checksum.block_indices(shape, itemsize))
        assert all(
            values[index].size * itemsize <= max(checksum.BLOCK, itemsize) for index in indices
        )
    pieces = [values[index].ravel() for index in indices]
    assert np.concatenate([[], *pieces]).tolist() == values.ravel().tolist()


@pytest.mark.parametrize("shape", [(50,), (9, 5), (3, 4, 7)])
def test_lazy_data_are_kept_like_those_in_memory(
    shape: tuple[int, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checksum, "CHUNK", 48)
    monkeypatch.setattr(checksum, "BLOCK", 120)
    values = np.random.default_rng(0).normal(size=shape)
    unread = lazy(values)
    path = save(unread, tmp_path / "lazy.nc")
    assert unread.x.chunks is not None
    loaded = load(path)
    assert loaded.x.values.tobytes() == values.tobytes()
    again = load(save(unread.compute(), tmp_path / "there.nc"))
    assert again.content_sha256 == loaded.content_sha256 == content_sha256(archived_form(unread))
    swapped = load(save(lazy(values.astype(">f4")), tmp_path / "swapped.nc"))
    assert swapped.x.dtype == np.float32
    assert swapped.x.values.tobytes() == values.astype("f4").tobytes()


def test_opened_archive_is_what_load_gives(tmp_path: Path) -> None:
    run = xr.Dataset(
        {
            "x": ("t", np.arange(5.0), {"units": "1"}),
            "message": ("start", ["", "ω"]),
            "event_time": ("event", np.zeros(0)),
        },
        {"t": np.arange(5) / 4, "omega": 1.7},
        {"title": "a run"},
    )
    path = save(run, tmp_path / "run.nc")
    with open_archive(path) as opened:
        assert not opened.x.variable._in_memory
        assert not opened.x.encoding
        xr.testing.assert_identical(opened, load(path))
        xr.testing.assert_identical(opened.isel(t=[4, 1]).x, load(path).isel(t=[4, 1]).x)
        save(opened, path, overwrite=True)


def test_archive_too_large_for_load_is_for_open_archive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save(xr.Dataset({"x": ("t", np.zeros(1000))}), tmp_path / "run.nc")
    monkeypatch.setattr(reading, "LARGEST_CONTENT", 7999)
    with pytest.raises(
        ArchiveError, match=r"contains 8e\+03 bytes.*open_archive reads larger ones"
    ):
        load(path)
    with open_archive(path) as opened:
        assert opened.x.sum() == 0


def test_damage_is_found_unless_told_not_to_look(tmp_path: Path) -> None:
    path = save(xr.Dataset({"x": ("t", np.arange(1000.0))}), tmp_path / "run.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["x"][3] = 5.0
    with pytest.raises(ArchiveError, match="it has no seal"):
        open_archive(path, check=False)
    append_seal(path)
    with pytest.raises(ArchiveError, match="does not have the checksum"):
        open_archive(path)
    with open_archive(path, check=False) as opened:
        assert opened.x[3] == 5.0
        assert opened.x[[3, 9]].values.tolist() == [5.0, 9.0]
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(ArchiveError, match="it has no seal"):
        open_archive(path, check=False)


def test_unchecked_numbers_that_cannot_be_read_are_reported_when_they_are(tmp_path: Path) -> None:
    x = np.random.default_rng(3).normal(size=4000).cumsum()
    path = save(xr.Dataset({"x": ("t", x), "y": ("t", x)}), tmp_path / "run.nc")
    whole = bytearray(path.read_bytes())
    middle = len(whole) // 2
    whole[middle : middle + 64] = bytes(64)
    path.write_bytes(whole)
    said = pytest.raises(ArchiveError, match=r"cannot read .*run.nc, which may be damaged: ")
    with open_archive(path, check=False) as opened, said:
        opened.load()
