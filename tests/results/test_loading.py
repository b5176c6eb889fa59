"""What load refuses: other files, other formats, and damage."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    load_machine,
    load_system,
    open_archive,
    read_signals,
    resume,
    status,
)
from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.results.archive import load, reading, save
from rotor_ida.results.archive.checksum import append_seal
from tests.example_datasets import a_dataset


def refused(path: Path, message: str) -> None:
    with pytest.raises(ArchiveError, match=message) as caught:
        load(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_path_that_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, message in [
        (tmp_path / "run.nc", "path must be a file that exists, got .*run.nc"),
        (tmp_path, "path must be a file, got the folder"),
        (tmp_path / "pipe", "path must be a file that exists"),
        (3, "path must be the path of a file, got 3"),
    ]:
        with pytest.raises(InputError, match=message):
            load(path)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "read", [load, open_archive, load_machine, load_system, read_signals, status, resume]
)
def test_what_does_not_exist_is_a_missing_file_to_python_too(read, tmp_path: Path) -> None:
    for error in (FileNotFoundError, InputError):
        with pytest.raises(error, match=r"gone\.nc") as caught:
            read(tmp_path / "gone.nc")
    assert "\n" not in str(caught.value)
    assert not isinstance(caught.value, ArchiveError)


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    for data in (b"", b"time,x\n0,1\n"):
        path.write_bytes(data)
        refused(path, "is not an archive of rotor_ida: it is not netCDF-4")
    netCDF4.Dataset(path, "w", format="NETCDF3_CLASSIC").close()
    refused(path, "it is not netCDF-4")
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    refused(path, "is not an archive of rotor_ida: it has no seal")
    append_seal(path)
    refused(path, "cannot read .*, which may be damaged: HDF5 cannot open it")
    a_dataset().drop_attrs().to_netcdf(path, engine="netcdf4")
    refused(path, "it has no seal; xarray.open_dataset and ncdump may still open it")
    append_seal(path)
    refused(path, "has format none, but this version of rotor_ida reads format 3 only")


def without_coordinates(file: netCDF4.Dataset) -> None:
    for variable in file.variables.values():
        if "coordinates" in variable.ncattrs():
            variable.delncattr("coordinates")


def in_format(number: object) -> Callable[[netCDF4.Dataset], None]:
    return lambda file: file.setncattr("rotor_ida_format", number)


PAIR = np.dtype([("r", "f8"), ("i", "f8")])
CHANGED, UNSOUND = "is damaged or was altered", "is not a sound archive: "
READS = "but this version of rotor_ida reads format 3 only"
ALTERED: tuple[tuple[Callable[[netCDF4.Dataset], object], str], ...] = (
    (lambda file: file["x"].__setitem__(3, file["x"][3] + 1e-12), CHANGED),
    (lambda file: file["x"].setncattr("units", "mm"), CHANGED),
    (lambda file: file.createVariable("extra", "f8", ("t",)).__setitem__(..., 0.0), CHANGED),
    (lambda file: file.renameVariable("x", "y"), CHANGED),
    (without_coordinates, CHANGED),
    (lambda file: file.delncattr("content_sha256"), CHANGED),
    (lambda file: file.createGroup("hidden"), f"{UNSOUND}it contains 'hidden', which is"),
    (lambda file: file.createCompoundType(PAIR, "complex"), "contains 'complex', which is not a v"),
    (lambda file: file.createVariable("extra", "S1", ("t",)), f"{UNSOUND}see variable 'extra'"),
    (in_format(4), f"has format 4, {READS}"),
    (in_format(2), f"has format 2, {READS}"),
    (in_format("one"), f"has format one, {READS}"),
)


@pytest.mark.parametrize("case", range(len(ALTERED)))
def test_altered_archive_is_refused(case: int, archive: Path) -> None:
    alter, message = ALTERED[case]
    with netCDF4.Dataset(archive, "a") as file:
        alter(file)
    refused(archive, "is damaged, was altered .*: it has no seal")
    append_seal(archive)
    refused(archive, message)


def test_sealed_again_it_may_have_more_history(archive: Path) -> None:
    with netCDF4.Dataset(archive, "a") as file:
        file.history += "\n2026-11-22T09:00:00Z ncatted"
    append_seal(archive)
    assert load(archive).history.endswith("ncatted")


def test_truncated_archive_is_refused(archive: Path) -> None:
    whole = archive.read_bytes()
    for length in [*range(0, len(whole), len(whole) // 40), len(whole) - 1]:
        archive.write_bytes(whole[:length])
        refused(archive, "not netCDF-4|it has no seal")
    archive.write_bytes(whole)
    load(archive)


def test_flipped_bits_are_reported(archive: Path) -> None:
    whole = archive.read_bytes()
    places = np.random.default_rng(1).integers(0, 8 * len(whole), size=200).tolist()
    for place in places:
        damaged = bytearray(whole)
        damaged[place // 8] ^= 1 << place % 8
        archive.write_bytes(damaged)
        refused(archive, "not netCDF-4|has no seal|its bytes are not those that were sealed")


def test_absurd_sizes_are_refused_before_reading(archive: Path, tmp_path: Path) -> None:
    for size, message in [(2**45, "declares 2.81e\\+14 bytes"), (2**22, "declares 3.36e\\+07")]:
        path = tmp_path / f"{size}.nc"
        shutil.copy(archive, path)
        with netCDF4.Dataset(path, "a") as file:
            file.createDimension("vast", size)
            file.createVariable("extra", "f8", ("vast",), zlib=True, chunksizes=(4096,))
        append_seal(path)
        assert path.stat().st_size < 30_000
        refused(path, message)


def test_absurd_strings_are_refused(archive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "LARGEST_CONTENT", 2000)
    monkeypatch.setattr(reading, "_refuse_absurd_sizes", lambda file, source, in_memory: None)
    path = save(
        xr.Dataset({"message": ("start", [""] * 50 + ["x" * 50])}), archive.with_name("texts.nc")
    )
    refused(path, "declares unreasonably long strings in 'message'")
