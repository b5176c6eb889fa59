"""Archives: what comes back is what was kept, and a file is whole, refused or not there."""

from __future__ import annotations

import ctypes
import errno
import importlib
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.schema import CONVENTIONS, FORMAT_VERSION, labelled
from rotor_ida.storage.archive import (
    content,
    load,
    netcdf,
    open_archive,
    parts,
    reading,
    save,
    soundness,
    writing,
)

FORMAT_1 = Path(__file__).parents[1] / "data" / "archive_format_1.nc"
ADDED = (
    *("Conventions", "rotor_ida_format", "rotor_ida_version"),
    *("date_created", "history", "content_sha256"),
)


def a_run(samples: int = 50, seed: int = 0) -> xr.Dataset:
    """Return a dataset shaped like a sweep: floats, flags, messages, and no events at all."""
    motion = np.random.default_rng(seed)
    radius = motion.normal(size=(samples, 2))
    radius[3:5, 1] = [np.nan, -0.0]
    return xr.Dataset(
        {
            "x": ("t", motion.normal(size=samples), {"long_name": "displacement", "units": "1"}),
            "radius_max": (("t", "start"), radius),
            "response": labelled("response", "start", np.array([1, -1], dtype=np.int8)),
            "message": ("start", np.array(["", "gave up at t = 3 — naïvely"])),
            "event_time": labelled("event_time", "event", np.zeros(0)),
            "event_kind": labelled("event_kind", "event", np.zeros(0, dtype=np.int8)),
            "note": ("event", np.zeros(0, dtype="U4")),
            "starts_in_contact": labelled("starts_in_contact", (), np.int8(1)),
            "title_of_run": ((), "one run"),
        },
        coords={
            "t": labelled("t", "t", np.linspace(0, 9, samples)),
            "omega": labelled("omega", (), 1.7),
            "label": ("start", np.array(["rest", "far"])),
        },
        attrs={
            "title": "a run",
            "empty": "",
            "greek": "ω₀ = √(k√D/m)\n",
            "rtol": 1e-10,
            "samples": samples,
            "nothing": np.nan,
            "small": np.int8(-3),
            "start": np.array([0.0, np.inf, -0.0, np.nan]),
            "none_of_them": np.zeros(0, dtype=np.int16),
        },
    )


def with_added(dataset: xr.Dataset, loaded: xr.Dataset) -> xr.Dataset:
    return dataset.assign_attrs({name: loaded.attrs[name] for name in ADDED})


def leftovers(folder: Path, *expected: str) -> list[str]:
    return sorted(set(os.listdir(folder)) - set(expected))


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    return save(a_run(), tmp_path / "run.nc")


# What comes back


def test_what_comes_back_is_what_was_saved(archive: Path) -> None:
    loaded = load(archive)
    xr.testing.assert_identical(loaded, with_added(a_run(), loaded))
    for name, variable in a_run().variables.items():
        same = loaded.variables[name]
        assert same.dtype.kind == variable.dtype.kind
        if variable.dtype.kind == "U":
            assert same.values.tolist() == variable.values.tolist()
        else:
            assert same.dtype == variable.dtype
            assert same.values.tobytes() == variable.values.tobytes()
        assert not same.encoding
    assert set(loaded.coords) == {"t", "omega", "label"}
    assert loaded.response.attrs["flag_values"].dtype == np.int8
    assert loaded.attrs["small"].dtype == np.int8
    assert loaded.attrs["none_of_them"].dtype == np.int16
    assert not loaded.encoding


def test_added_attributes_say_what_the_file_is(archive: Path) -> None:
    loaded = load(archive)
    assert loaded.attrs["Conventions"] == CONVENTIONS
    assert loaded.attrs["rotor_ida_format"] == FORMAT_VERSION
    assert loaded.attrs["rotor_ida_version"]
    assert loaded.attrs["content_sha256"] == content.content_sha256(loaded)


def test_version_that_computed_the_data_is_kept(tmp_path: Path) -> None:
    dataset = a_run().assign_attrs(rotor_ida_version="0.0.1", Conventions="CF-1.6")
    loaded = load(save(dataset, tmp_path / "run.nc"))
    assert loaded.attrs["rotor_ida_version"] == "0.0.1"
    assert loaded.attrs["Conventions"] == CONVENTIONS


def test_checksum_is_the_same_for_the_same_content(archive: Path, tmp_path: Path) -> None:
    first = load(archive)
    again = load(save(first, tmp_path / "again.nc"))
    xr.testing.assert_identical(again, first.assign_attrs(history=again.attrs["history"]))
    turned = a_run()[sorted(a_run().data_vars, reverse=True)]
    turned.attrs = dict(reversed(a_run().attrs.items()))
    assert load(save(turned, tmp_path / "t.nc")).attrs["content_sha256"] == content.content_sha256(
        first
    )


def test_checksum_differs_for_any_difference() -> None:
    base = content.archived_form(a_run())
    others = [
        base.assign(x=base.x.astype(np.float32)),
        base.assign(x=-base.x),
        base.rename(x="y"),
        base.reset_coords("omega"),
        base.assign_attrs(rtol=1e-9),
        base.assign_attrs(rtol="1e-10"),
        base.rename_dims(event="contact"),
        base.assign(x=base.x.assign_attrs(units="mm")),
        base.assign(message=base.message.str.upper()),
    ]
    sums = {content.content_sha256(dataset) for dataset in (base, *others)}
    assert len(sums) == len(others) + 1


def test_dataset_of_the_caller_is_left_alone(tmp_path: Path) -> None:
    dataset, before = a_run(), a_run()
    dataset.x.encoding.update(dtype="float32", scale_factor=0.1, _FillValue=-1.0)
    dataset.encoding["unlimited_dims"] = {"t"}
    loaded = load(save(dataset, tmp_path / "run.nc"))
    xr.testing.assert_identical(dataset, before)
    assert dataset.x.encoding == {"dtype": "float32", "scale_factor": 0.1, "_FillValue": -1.0}
    xr.testing.assert_identical(loaded, with_added(before, loaded))


def test_saved_result_does_not_hang_on_the_file(archive: Path) -> None:
    loaded = load(archive)
    archive.unlink()
    loaded.x.values[0] = 5.0
    assert loaded.x.values[0] == 5.0


def test_unusual_shapes_and_types_come_back(tmp_path: Path) -> None:
    dataset = xr.Dataset(
        {
            "objects": ("start", np.array(["a", "longer"], dtype=object)),
            "swapped": ("start", np.array([1.5, 2.5], dtype=">f8")),
            "strided": ("half", np.arange(10.0)[::2]),
            "turned": (("half", "start"), np.arange(10.0).reshape(2, 5).T),
            "nothing": (("event", "start"), np.zeros((0, 2))),
        },
        coords={"big": ("start", np.array([2**64 - 1, 0], dtype=np.uint64))},
        attrs={"swapped": np.array([1.5, 2.5], dtype=">f4"), "single": np.array([3.5])},
    )
    loaded = load(save(dataset, tmp_path / "run.nc"))
    expected = with_added(dataset, loaded).assign_attrs(single=3.5)
    xr.testing.assert_identical(loaded, expected)
    assert loaded.swapped.dtype == np.float64


def test_empty_dataset_comes_back(tmp_path: Path) -> None:
    loaded = load(save(xr.Dataset(), tmp_path / "run.nc"))
    assert not loaded.variables


def test_other_readers_see_plain_cf_variables(archive: Path) -> None:
    with netCDF4.Dataset(archive) as file:
        # netCDF has no other word for a length of zero: NC_UNLIMITED is 0.
        unlimited = {name for name, size in file.dimensions.items() if size.isunlimited()}
        assert unlimited == {"event"}
        for name, variable in file.variables.items():
            assert "_FillValue" not in variable.ncattrs()
            filtered = variable.ndim and variable.size and variable.dtype is not str
            assert variable.filters()["zlib"] == bool(filtered), name
            assert variable.filters()["fletcher32"] == bool(filtered), name
    with xr.open_dataset(archive) as seen:
        for name, variable in load(archive).variables.items():
            assert variable.identical(seen.variables[name].load())
        # What is known along time stands as its coordinates, or CF would take it for a calendar.
        assert set(seen.coords) == {"t", "omega", "label", "x", "radius_max"}


def test_archive_of_format_1_is_read() -> None:
    old = load(FORMAT_1)
    assert old.attrs["rotor_ida_format"] == 1
    assert old.attrs["content_sha256"].startswith("eb954be7f47a55e9")
    assert old.message.values.tolist() == ["touché", ""] * 3 + ["touché"]
    assert set(old.coords) == {"t", "omega", "delta0"}
    assert old.event_time[:3].values.tolist() == pytest.approx([1.099, 3.218, 5.566], abs=5e-4)


def test_history_grows_by_a_line_and_the_date_stays(archive: Path, tmp_path: Path) -> None:
    first = load(archive)
    assert re.fullmatch(
        r"[-0-9]{10}T[0-9:]{8}Z rotor_ida \S+: saved by .* with netCDF4 .*", first.history
    )
    earlier = first.assign_attrs(date_created="2020-01-01T00:00:00Z")
    again = load(save(earlier, tmp_path / "again.nc"))
    assert again.history.splitlines()[0] == first.history
    assert len(again.history.splitlines()) == 2
    assert again.date_created == "2020-01-01T00:00:00Z"
    changed = load(save(earlier.assign(x=2 * earlier.x), tmp_path / "changed.nc"))
    assert changed.date_created != "2020-01-01T00:00:00Z"


def test_time_of_saving_is_not_part_of_the_content(
    archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writing, "now", lambda: "2020-01-01T00:00:00Z")
    other = load(save(a_run(), tmp_path / "other.nc"))
    assert other.date_created == "2020-01-01T00:00:00Z" != load(archive).date_created
    assert other.content_sha256 == load(archive).content_sha256


def test_archive_needs_no_solver() -> None:
    program = (
        "import sys, rotor_ida.storage.archive;"
        "print([m for m in ('netCDF4', 'numba', 'sksundae') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert shown.stdout.split() == [b"[]"]


# What save refuses


@pytest.mark.parametrize(
    ("dataset", "message"),
    [
        ({"x": 1}, "dataset must be an xarray Dataset, got dict"),
        (xr.DataArray([1.0]), "dataset must be an xarray Dataset, got DataArray"),
        (xr.Dataset({"z": ("t", [1j])}), "'z' must hold integers.*got complex128; keep its real"),
        (xr.Dataset({"z": ("t", [True])}), "'z' must hold integers.*got bool; keep it as int8"),
        (xr.Dataset({"z": ("t", np.zeros(1, "f2"))}), "got float16"),
        (xr.Dataset({"z": ("t", np.zeros(1, "M8[ns]"))}), "got datetime64"),
        (xr.Dataset({"z": ("t", np.array([b"a"]))}), "got bytes8"),
        (xr.Dataset({"z": ("t", np.array(["a", None]))}), "got objects that are not strings"),
        (xr.Dataset({"z": ("t", ["a\0b"])}), r"'z' must not hold the character NUL, got 'a\\x00b'"),
        (xr.Dataset({"z": ("t", ["\ud800"])}), "'z' must be valid Unicode text"),
        (xr.Dataset({"a/b": ("t", [1.0])}), "name 'a/b' of the dataset must be a letter"),
        (xr.Dataset({3: ("t", [1.0])}), "name 3 of the dataset must be a letter"),
        (xr.Dataset({"x": ("my dim", [1.0])}), "name 'my dim' of the dataset"),
    ],
)
def test_dataset_that_netcdf_cannot_hold_is_refused(
    dataset: xr.Dataset, message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        save(dataset, tmp_path / "run.nc")
    assert "\n" not in str(caught.value)
    assert not leftovers(tmp_path)


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        np.True_,
        {"a": 1},
        ["a", "b"],
        (1.0, 2.0),
        1j,
        2**70,
        np.array([True]),
        np.array(["a", "b"]),
        np.zeros((2, 2)),
        np.float16(1),
        np.longdouble(1),
        b"bytes",
        "nul\0",
        "\udc80",
    ],
)
@pytest.mark.parametrize("owner", ["the dataset", "variable 'x'"])
def test_attribute_that_netcdf_cannot_hold_is_refused(
    value: object, owner: str, tmp_path: Path
) -> None:
    dataset = xr.Dataset({"x": ("t", [1.0])})
    (dataset if owner == "the dataset" else dataset.x).attrs["setting"] = value
    with pytest.raises(InputError, match=f"attribute 'setting' of {owner} must") as caught:
        save(dataset, tmp_path / "run.nc")
    assert "\n" not in str(caught.value)
    assert not leftovers(tmp_path)


@pytest.mark.parametrize("name", ["_FillValue", "coordinates", "scale_factor", "a b", 3, "NAME"])
def test_attribute_name_that_netcdf_uses_is_refused(name: str, tmp_path: Path) -> None:
    dataset = xr.Dataset({"x": ("t", [1.0], {name: 1.0})})
    with pytest.raises(InputError, match=f"attribute {name!r} of variable 'x'"):
        save(dataset, tmp_path / "run.nc")


def test_name_of_the_domain_variable_is_reserved(archive: Path, tmp_path: Path) -> None:
    for dataset in (
        xr.Dataset({"time_domain": ("t", [1.0])}),
        xr.Dataset({"x": ("time_domain", [1.0])}),
        xr.Dataset({"x": ("t", [1.0])}, attrs={"history": 3}),
    ):
        with pytest.raises(
            InputError, match=r"'time_domain' is reserved|'history' .* must be text"
        ):
            save(dataset, tmp_path / "other.nc")
    with xr.open_dataset(archive) as seen:
        assert "time_domain" not in load(save(seen, tmp_path / "again.nc"))


def test_text_coordinate_of_a_dimension_is_stored_as_a_label(tmp_path: Path) -> None:
    dataset = xr.Dataset(
        {"x": ("bearing", [1.0, 2.0]), "bearing_label": ("bearing", [1, 2])},
        {"bearing": ("bearing", ["left", "right"], {"long_name": "side"})},
    )
    path = save(dataset, tmp_path / "run.nc")
    xr.testing.assert_identical(load(path).drop_attrs(), dataset.drop_attrs())
    assert load(path).bearing.attrs == {"long_name": "side"}
    with xr.open_dataset(path) as seen:
        assert seen.bearing_label_.values.tolist() == ["left", "right"]
        again = load(save(seen, tmp_path / "again.nc"))
    assert again.bearing.identical(load(path).bearing)
    with open_archive(path) as opened:
        assert opened.identical(load(path))


def test_path_that_cannot_be_written_is_refused(archive: Path, tmp_path: Path) -> None:
    before = archive.read_bytes()
    os.mkfifo(tmp_path / "pipe")
    for path, overwrite, message in [
        (archive, False, "path must not exist unless overwrite is true, got .*run.nc"),
        (tmp_path, True, "path must be a file, got the folder"),
        (tmp_path / "nowhere" / "run.nc", False, "path must be in a folder that exists, got"),
        (archive / "run.nc", False, "path must be in a folder that exists, got"),
        (tmp_path / "pipe", True, "path must be a file, got the device or pipe"),
        ("", False, "path must be the path of a file, got ''"),
        (3, False, "path must be the path of a file, got 3"),
        ("a\0b", False, "path must be the path of a file"),
        (archive, 1, "overwrite must be true or false, got 1"),
    ]:
        with pytest.raises(InputError, match=message):
            save(a_run(), path, overwrite=overwrite)  # type: ignore[arg-type]
    assert archive.read_bytes() == before
    assert not leftovers(tmp_path, "run.nc", "pipe")


# Wholly or not at all


def test_overwrite_replaces_the_file(archive: Path, tmp_path: Path) -> None:
    assert save(a_run(7), archive, overwrite=True) == archive
    assert load(archive).sizes["t"] == 7
    assert not leftovers(tmp_path, "run.nc")


def test_overwrite_through_a_link_keeps_the_link(archive: Path, tmp_path: Path) -> None:
    (tmp_path / "latest.nc").symlink_to("run.nc")
    save(a_run(7), tmp_path / "latest.nc", overwrite=True)
    assert (tmp_path / "latest.nc").is_symlink()
    assert load(archive).sizes["t"] == 7


def test_permissions_follow_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        path = save(a_run(), tmp_path / "run.nc")
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
    with pytest.raises(InputError, match="path must not exist unless overwrite is true"):
        save(a_run(), path)
    assert path.read_text() == "another process was faster"
    assert not leftovers(tmp_path, "run.nc")


def no_links(source: object, target: object) -> None:
    raise OSError(errno.EPERM, "no hard links here")


def test_file_system_without_links_will_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", no_links)
    path = save(a_run(), tmp_path / "run.nc")
    assert load(path).sizes["t"] == 50
    assert not leftovers(tmp_path, "run.nc")


@pytest.mark.parametrize("place", ["write_netcdf", "fsync", "link"])
@pytest.mark.parametrize("failure", [KeyboardInterrupt(), OSError(errno.EACCES, "No permission")])
def test_failure_leaves_nothing_behind(
    place: str, failure: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*args: object, **kwargs: object) -> None:
        raise failure

    with monkeypatch.context() as patch:
        patch.setattr(writing if place == "write_netcdf" else os, place, fail)
        expected = ArchiveError if isinstance(failure, OSError) else KeyboardInterrupt
        with pytest.raises(expected) as caught:
            save(a_run(), tmp_path / "run.nc")
    assert not leftovers(tmp_path)
    if expected is ArchiveError:
        assert str(caught.value) == f"cannot write {tmp_path / 'run.nc'}: No permission"
    load(save(a_run(), tmp_path / "run.nc"))


def test_folder_that_may_not_be_written_is_reported(tmp_path: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    tmp_path.chmod(0o500)
    with pytest.raises(ArchiveError, match=r"cannot write .*run.nc: Permission denied"):
        save(a_run(), tmp_path / "run.nc")
    tmp_path.chmod(0o700)


def test_file_that_may_not_grow_is_reported(archive: Path, tmp_path: Path) -> None:
    before = archive.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, limits[1]))
    try:
        with pytest.raises(ArchiveError, match=r"cannot write .*run.nc: File too large$"):
            save(a_run(100_000), archive, overwrite=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert archive.read_bytes() == before
    assert not leftovers(tmp_path, "run.nc")


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(disk)]
    if (
        not shutil.which("mount")
        or subprocess.run(mount, check=False, capture_output=True).returncode
    ):
        pytest.skip("no disk may be mounted here")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.parametrize("first_check", [netcdf.SLAB, 0])
def test_full_disk_is_reported(
    first_check: int, small_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(netcdf, "SLAB", first_check)
    path = save(a_run(), small_disk / "run.nc")
    before = path.read_bytes()
    for _ in range(3):
        with pytest.raises(ArchiveError, match=r"cannot write .*run.nc: No space left on device$"):
            save(a_run(400_000), path, overwrite=True)
        assert path.read_bytes() == before
        assert not leftovers(small_disk, "run.nc")
    assert load(save(a_run(7), path, overwrite=True)).sizes["t"] == 7


@pytest.mark.parametrize("moment", ["half written", "written", "published"])
def test_process_killed_leaves_the_old_or_the_new(moment: str, tmp_path: Path) -> None:
    path = save(a_run(), tmp_path / "run.nc")
    program = f"""
import os, sys
import xarray as xr
from rotor_ida.storage.archive import save, writing
def die(part):
    if {moment!r} == "half written":
        os.truncate(part, os.path.getsize(part) // 2)
    os._exit(9)
if {moment!r} == "published":
    writing._sync_folder = lambda folder: os._exit(9)
else:
    writing.append_seal = die
save(xr.Dataset({{"x": ("t", [1.0] * 1000)}}), sys.argv[1], overwrite=True)
"""
    ended = subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    assert ended.returncode == 9
    assert load(path).sizes["t"] == (1000 if moment == "published" else 50)
    save(a_run(7), path, overwrite=True)
    assert not leftovers(tmp_path, "run.nc")


def test_saves_killed_at_any_moment_leave_nothing(tmp_path: Path) -> None:
    program = """
import sys
import numpy as np, xarray as xr
from rotor_ida import save
data = xr.Dataset({"x": ("t", np.random.default_rng(0).normal(size=100_000))})
save(data, sys.argv[1])
print(flush=True)
while True:
    save(data, sys.argv[1], overwrite=True)
"""
    chance = random.Random(0)
    for number in range(4):
        path = tmp_path / f"{number}.nc"
        with subprocess.Popen([sys.executable, "-c", program, path], stdout=-1) as writer:
            assert writer.stdout is not None
            writer.stdout.readline()
            time.sleep(chance.uniform(0.0, 0.1))
            writer.kill()
        assert load(path).sizes["t"] == 100_000
    save(a_run(), tmp_path / "last.nc")
    assert not leftovers(tmp_path, "last.nc", *(f"{number}.nc" for number in range(4)))


def test_part_of_a_writer_that_lives_is_left_alone(tmp_path: Path) -> None:
    with parts.part_beside(tmp_path / "run.nc") as part:
        part.write_text("half")
        save(a_run(), tmp_path / "other.nc")
        assert part.read_text() == "half"
    other_machine = tmp_path / f".elsewhere.{'0' * 16}.rotor_ida-part"
    other_machine.mkdir()
    save(a_run(), tmp_path / "run.nc")
    assert other_machine.exists()


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
    assert "path must not exist unless overwrite is true" in str(error)
for _ in range(20):
    save(data, sys.argv[1] + "/last.nc", overwrite=True)
"""
    save(a_run(), tmp_path / "last.nc")
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
    shared = save(a_run(), tmp_path / "shared.nc")
    ready = threading.Barrier(8)

    def work(number: int) -> None:
        ready.wait()
        for turn in range(5):
            dataset = a_run(20 + number, seed=turn)
            path = save(dataset, tmp_path / f"{number}.nc", overwrite=True)
            loaded = load(path)
            xr.testing.assert_identical(loaded, with_added(dataset, loaded))
            save(dataset, shared, overwrite=True)
            assert load(shared).sizes["start"] == 2

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(work, range(8)))
    assert len(leftovers(tmp_path)) == 9


def test_file_replaced_while_it_is_read_is_read_again(
    archive: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = reading.seal_of
    replacements = [a_run(7)]

    def read_late(source: Path, *, check: bool = True) -> str:
        if replacements:
            save(replacements.pop(), source, overwrite=True)
            raise RuntimeError("half of one file and half of the other")
        return read(source, check=check)

    monkeypatch.setattr(reading, "seal_of", read_late)
    assert load(archive).sizes["t"] == 7


def test_one_of_many_writers_wins(tmp_path: Path) -> None:
    def work(number: int) -> int:
        try:
            save(a_run(10 + number), tmp_path / "run.nc")
        except InputError:
            return 0
        return 10 + number

    with ThreadPoolExecutor(8) as pool:
        winners = [samples for samples in pool.map(work, range(8)) if samples]
    assert winners == [load(tmp_path / "run.nc").sizes["t"]]


# What load refuses


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


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    for data, message in [
        (b"", "is not an archive of rotor_ida: it is empty"),
        (b"time,x\n0,1\n", "is not an archive of rotor_ida: it is not a netCDF-4 file"),
        (b"\x89HDF\r\n\x1a\n", "is truncated or damaged"),
        (
            b"\x89HDF\r\n\x1a\n" + bytes(100),
            "cannot read .*, which may be damaged: HDF5 cannot list its contents",
        ),
    ]:
        path.write_bytes(data)
        refused(path, message)
    netCDF4.Dataset(path, "w", format="NETCDF3_CLASSIC").close()
    refused(path, "it is a netCDF file of the classic format")
    a_run().drop_attrs().to_netcdf(path, engine="netcdf4")
    refused(path, "it has no rotor_ida_format")


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the process in which files without a seal are tried first; it does the same checks."""
    monkeypatch.setattr(reading, "refuse_what_cannot_be_read", lambda source, check: None)


def alter(path: Path, change: str) -> None:
    with netCDF4.Dataset(path, "a") as file:
        if change == "value":
            file["x"][3] += 1e-12
        elif change == "unit":
            file["x"].units = "mm"
        elif change == "variable":
            file.createVariable("extra", "f8", ("t",))[:] = 0.0
        elif change == "name":
            file.renameVariable("x", "y")
        elif change == "coordinates":
            for name in file.variables:
                if "coordinates" in file[name].ncattrs():
                    file[name].delncattr("coordinates")
        elif change == "no checksum":
            file.delncattr("content_sha256")
        elif change == "group":
            file.createGroup("hidden")
        elif change == "complex":
            file.createCompoundType(np.dtype([("r", "f8"), ("i", "f8")]), "complex")
        elif change == "char":
            file.createVariable("extra", "S1", ("t",))
        else:
            file.rotor_ida_format = {"newer": 3, "text": "one", "zero": 0}[change]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("value", "is damaged or was altered"),
        ("unit", "is damaged or was altered"),
        ("variable", "is damaged or was altered"),
        ("name", "is damaged or was altered"),
        ("coordinates", "is damaged or was altered"),
        ("no checksum", "is damaged or was altered"),
        ("group", "is not a sound archive: it holds 'hidden', which is not a variable"),
        ("complex", "holds 'complex', which is not a variable"),
        ("char", "is not an archive of rotor_ida: see variable 'extra'"),
        ("newer", "has format 3, but this version of rotor_ida reads formats up to 2"),
        ("text", "is damaged: its rotor_ida_format is 'one'"),
        ("zero", r"is damaged: its rotor_ida_format is np.int64\(0\)"),
    ],
)
def test_altered_archive_is_refused(
    change: str, message: str, archive: Path, in_this_process: None
) -> None:
    load(archive)
    alter(archive, change)
    refused(archive, message)


def test_other_programs_may_add_to_the_history(archive: Path, in_this_process: None) -> None:
    with netCDF4.Dataset(archive, "a") as file:
        file.history += "\n2026-11-22T09:00:00Z ncatted"
    assert load(archive).history.endswith("ncatted")


def test_truncated_archive_is_refused(archive: Path) -> None:
    whole = archive.read_bytes()
    for length in [*range(0, len(whole), len(whole) // 40), len(whole) - 1]:
        archive.write_bytes(whole[:length])
        refused(archive, "empty|truncated or damaged|not a netCDF-4 file|is damaged or was altered")
    archive.write_bytes(whole)
    load(archive)


def test_flipped_bits_are_reported_or_do_no_harm(archive: Path) -> None:
    whole, good = archive.read_bytes(), load(archive)
    places = np.random.default_rng(1).integers(0, 8 * len(whole), size=200).tolist()
    reported = 0
    for place in places:
        damaged = bytearray(whole)
        damaged[place // 8] ^= 1 << place % 8
        archive.write_bytes(damaged)
        try:
            loaded = load(archive)
        except ArchiveError:
            reported += 1
        else:
            xr.testing.assert_identical(loaded, good)
            assert content.content_sha256(loaded) == good.attrs["content_sha256"]
    assert reported > 0


def test_absurd_sizes_are_refused_before_reading(archive: Path, tmp_path: Path) -> None:
    for size, message in [(2**45, "declares 2.81e\\+14 bytes"), (2**22, "declares 3.36e\\+07")]:
        path = tmp_path / f"{size}.nc"
        shutil.copy(archive, path)
        with netCDF4.Dataset(path, "a") as file:
            file.createDimension("vast", size)
            file.createVariable("extra", "f8", ("vast",), zlib=True, chunksizes=(4096,))
        assert path.stat().st_size < 30_000
        refused(path, message)


def test_highly_compressed_archive_is_read(tmp_path: Path) -> None:
    dataset = xr.Dataset({"x": ("t", np.zeros(20_000_000, dtype=np.int8))})
    path = save(dataset, tmp_path / "run.nc")
    assert path.stat().st_size < 20_000_000 / 500
    assert load(path).x.sum() == 0


def test_absurd_strings_are_refused(archive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(soundness, "LARGEST_CONTENT", 2000)
    monkeypatch.setattr(soundness, "refuse_absurd_sizes", lambda file, source, in_memory: None)
    path = save(
        xr.Dataset({"message": ("start", [""] * 50 + ["x" * 50])}),
        archive.with_name("texts.nc"),
    )
    refused(path, "declares absurdly long strings in 'message'")


def hdf5() -> ctypes.CDLL:
    library = ctypes.CDLL(importlib.import_module("netCDF4._netCDF4").__file__)
    if not hasattr(library, "H5Lcreate_external"):
        pytest.skip("netCDF4-python does not let its HDF5 library be called here")
    for name in (
        *("H5Fopen", "H5Pcreate", "H5Screate_simple", "H5Dcreate2", "H5Gopen2"),
        *("H5Lcreate_external", "H5Lcreate_soft"),
    ):
        getattr(library, name).restype = ctypes.c_int64
    return library


def add_outside_part(path: Path, kind: str, other: Path) -> None:
    """Give the archive a part that is elsewhere, as h5py would."""
    library, number = hdf5(), ctypes.c_int64
    default, name, aim = number(0), b"outside", os.fsencode(other)
    file = number(library.H5Fopen(os.fsencode(path), ctypes.c_uint(1), default))
    assert file.value >= 0
    double = number.in_dll(library, "H5T_NATIVE_DOUBLE_g")
    four = (ctypes.c_uint64 * 1)(4)
    space = number(library.H5Screate_simple(ctypes.c_int(1), four, None))
    creation = number(library.H5Pcreate(number.in_dll(library, "H5P_CLS_DATASET_CREATE_ID_g")))
    if kind == "external link":
        status = library.H5Lcreate_external(aim, b"/x", file, name, default, default)
    elif kind == "soft link":
        status = library.H5Lcreate_soft(b"/x", file, name, default, default)
    else:
        if kind == "external storage":
            assert library.H5Pset_external(creation, aim, number(0), ctypes.c_uint64(32)) >= 0
        else:
            assert library.H5Pset_virtual(creation, space, aim, b"x", space) >= 0
        status = library.H5Dcreate2(file, name, double, space, default, creation, default)
        library.H5Dclose(number(status))
    assert status >= 0
    library.H5Pclose(creation)
    library.H5Sclose(space)
    assert library.H5Fclose(file) >= 0


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("external link", "is not a sound archive: it holds 'outside', which is a link"),
        ("soft link", "holds 'outside', which is a link"),
        ("external storage", "holds 'outside', whose data are in another file"),
        ("virtual", "holds 'outside', which is put together from other variables"),
    ],
)
def test_references_to_other_files_are_refused(
    kind: str, message: str, archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret = save(a_run(), tmp_path / "secret.nc")
    add_outside_part(archive, kind, secret)
    monkeypatch.setattr(netCDF4, "Dataset", None)  # netCDF must not open it at all
    refused(archive, message)


def test_failure_of_the_folder_to_synchronise_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sync = os.fsync

    def fail_on_folders(descriptor: int) -> None:
        if os.path.isdir(f"/proc/self/fd/{descriptor}"):
            raise OSError(number, os.strerror(number))
        sync(descriptor)

    monkeypatch.setattr(writing.os, "fsync", fail_on_folders)
    number = errno.EINVAL
    load(save(a_run(), tmp_path / "run.nc"))
    number = errno.EIO
    with pytest.raises(ArchiveError, match="Input/output error"):
        save(a_run(), tmp_path / "run.nc", overwrite=True)
