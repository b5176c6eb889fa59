"""What an archive holds: it comes back as it was, and plain readers see it too."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from rotor_ida.errors import InputError
from rotor_ida.results.archive import load, open_archive, save
from rotor_ida.results.archive.checksum import content_sha256
from rotor_ida.results.archive.content import FORMAT_NUMBER, archived_form
from rotor_ida.schema import CONVENTIONS
from tests.example_datasets import a_dataset

ADDED = (
    *("Conventions", "rotor_ida_format", "rotor_ida_version"),
    *("date_created", "history", "content_sha256"),
)


def with_added(dataset: xr.Dataset, loaded: xr.Dataset) -> xr.Dataset:
    return dataset.assign_attrs({name: loaded.attrs[name] for name in ADDED})


def test_version_that_computed_the_data_is_kept(tmp_path: Path) -> None:
    dataset = a_dataset().assign_attrs(rotor_ida_version="0.0.1", Conventions="CF-1.6")
    loaded = load(save(dataset, tmp_path / "run.nc"))
    assert loaded.attrs["rotor_ida_version"] == "0.0.1"
    assert loaded.attrs["Conventions"] == CONVENTIONS
    assert loaded.attrs["rotor_ida_format"] == FORMAT_NUMBER


def test_checksum_is_the_same_for_the_same_content(archive: Path, tmp_path: Path) -> None:
    first = load(archive)
    again = load(save(first, tmp_path / "again.nc"))
    xr.testing.assert_identical(again, first.assign_attrs(history=again.attrs["history"]))
    turned = a_dataset()[sorted(a_dataset().data_vars, reverse=True)]
    turned.attrs = dict(reversed(a_dataset().attrs.items()))
    assert load(save(turned, tmp_path / "t.nc")).attrs["content_sha256"] == content_sha256(first)


def test_checksum_differs_for_any_difference() -> None:
    base = archived_form(a_dataset())
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
    sums = {content_sha256(dataset) for dataset in (base, *others)}
    assert len(sums) == len(others) + 1


def test_dataset_of_the_caller_is_left_alone(tmp_path: Path) -> None:
    dataset, before = a_dataset(), a_dataset()
    dataset.x.encoding.update(dtype="float32", scale_factor=0.1, _FillValue=-1.0)
    dataset.encoding["unlimited_dims"] = {"t"}
    loaded = load(save(dataset, tmp_path / "run.nc"))
    xr.testing.assert_identical(dataset, before)
    assert dataset.x.encoding == {"dtype": "float32", "scale_factor": 0.1, "_FillValue": -1.0}
    xr.testing.assert_identical(loaded, with_added(before, loaded))


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
        assert set(seen.coords) == {"t", "omega", "label"}


def test_history_grows_by_a_line_and_the_date_stays(archive: Path, tmp_path: Path) -> None:
    first = load(archive)
    assert re.fullmatch(
        r"[-0-9]{10}T[0-9:]{8}Z rotor_ida \S+: saved by .* with netCDF4 .*", first.history
    )
    earlier = first.assign_attrs(date_created="2020-01-01T00:00:00Z")
    again = load(save(earlier, tmp_path / "again.nc"))
    assert again.content_sha256 == first.content_sha256
    assert again.history.splitlines()[0] == first.history
    assert len(again.history.splitlines()) == 2
    assert again.date_created == "2020-01-01T00:00:00Z"
    changed = load(save(earlier.assign(x=2 * earlier.x), tmp_path / "changed.nc"))
    assert changed.date_created != "2020-01-01T00:00:00Z"


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


def test_archive_needs_no_solver() -> None:
    program = (
        "import sys, rotor_ida.results.archive;"
        "print([m for m in ('netCDF4', 'sksundae') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert shown.stdout.split() == [b"[]"]


@pytest.mark.parametrize(
    ("dataset", "message"),
    [
        ({"x": 1}, "dataset must be an xarray Dataset, got dict"),
        (xr.DataArray([1.0]), "dataset must be an xarray Dataset, got DataArray"),
        (
            xr.Dataset({"z": ("t", [1j])}),
            "'z' must contain integers.*got complex128; keep its real",
        ),
        (xr.Dataset({"z": ("t", [True])}), "'z' must contain integers.*got bool; keep it as int8"),
        (xr.Dataset({"z": ("t", np.zeros(1, "f2"))}), "got float16"),
        (xr.Dataset({"z": ("t", np.zeros(1, "M8[ns]"))}), "got datetime64"),
        (xr.Dataset({"z": ("t", np.array([b"a"]))}), "got bytes8"),
        (xr.Dataset({"z": ("t", np.array(["a", None]))}), "got objects that are not strings"),
        (
            xr.Dataset({"z": ("t", ["a\0b"])}),
            r"'z' must not contain the character NUL, got 'a\\x00b'",
        ),
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
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "value",
    [None, True, np.True_, {"a": 1}, ["a", "b"], (1.0, 2.0), 1j, 2**70, np.array([True]),
     np.array(["a", "b"]), np.zeros((2, 2)), np.float16(1), np.longdouble(1), b"bytes", "nul\0",
     "\udc80"],
)  # fmt: skip
@pytest.mark.parametrize("owner", ["the dataset", "variable 'x'"])
def test_attribute_that_netcdf_cannot_hold_is_refused(
    value: object, owner: str, tmp_path: Path
) -> None:
    dataset = xr.Dataset({"x": ("t", [1.0])})
    (dataset if owner == "the dataset" else dataset.x).attrs["setting"] = value
    with pytest.raises(InputError, match=f"attribute 'setting' of {owner} must") as caught:
        save(dataset, tmp_path / "run.nc")
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["_FillValue", "coordinates", "scale_factor", "a b", 3, "NAME"])
def test_attribute_name_that_netcdf_uses_is_refused(name: str, tmp_path: Path) -> None:
    dataset = xr.Dataset({"x": ("t", [1.0], {name: 1.0})})
    with pytest.raises(InputError, match=f"attribute {name!r} of variable 'x'"):
        save(dataset, tmp_path / "run.nc")


def test_history_must_be_text(tmp_path: Path) -> None:
    dataset = xr.Dataset({"x": ("t", [1.0])}, attrs={"history": 3})
    with pytest.raises(InputError, match=r"'history' .* must be text"):
        save(dataset, tmp_path / "run.nc")


def test_highly_compressed_archive_is_read(tmp_path: Path) -> None:
    dataset = xr.Dataset({"x": ("t", np.zeros(20_000_000, dtype=np.int8))})
    path = save(dataset, tmp_path / "run.nc")
    assert path.stat().st_size < 20_000_000 / 500
    assert load(path).x.sum() == 0
