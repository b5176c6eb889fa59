"""A result as CSV: every number comes back to the last bit, flags are words, no file is lost."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from rotor_ida import Rotor, folds, read_signals, simulate, sweep
from rotor_ida.errors import InputError
from rotor_ida.results.tables import save_tables, tables_of
from rotor_ida.schema import words_of


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=0.1)
    return simulate(rotor, start=(0, 0, 0, 0), duration=20.0, samples=101)


def rows_in(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_dataset_of_several_tables_has_a_file_for_each(run: xr.Dataset, tmp_path: Path):
    found = save_tables(run, tmp_path / "run.csv")
    names = ["run.numbers.csv", "run.t.csv", "run.event.csv", "run.contact.csv"]
    assert [path.name for path in found] == names
    assert {path.name for path in tmp_path.iterdir()} == set(names)


def test_every_number_comes_back_to_the_last_bit(run: xr.Dataset, tmp_path: Path):
    files = {path.name: rows_in(path) for path in save_tables(run, tmp_path / "run.csv")}
    for name in ("t", "x", "vy"):
        assert [float(row[name]) for row in files["run.t.csv"]] == run[name].values.tolist()
    ends = [row["exit_time"] for row in files["run.contact.csv"]]
    expected = run["exit_time"].values.tolist()
    assert [float(end or "nan") for end in ends] == pytest.approx(expected, rel=0.0, nan_ok=True)
    numbers = {row["name"]: row["value"] for row in files["run.numbers.csv"]}
    assert float(numbers["load"]) == 0.1
    assert numbers["starts_in_contact"] == "no"


def test_flags_are_words_and_units_are_in_the_head(run: xr.Dataset):
    tables = tables_of(run)
    assert tables["event"]["event_kind"].tolist() == words_of(run["event_kind"])
    assert "entry_angle [radian]" in tables["contact"].columns


def test_the_rows_of_a_grid_are_in_the_order_of_its_dimensions():
    found = sweep(omega=[1.0, 1.2], zeta=[0.3, 0.5], delta0=0.5)
    table = tables_of(found)["-".join(map(str, found["amplitude"].dims))]
    assert table[["omega", "zeta"]].values.tolist() == [[1, 0.3], [1, 0.5], [1.2, 0.3], [1.2, 0.5]]
    assert np.array_equal(table["amplitude"], found["amplitude"].values.ravel(), equal_nan=True)


def test_the_samples_of_a_run_are_read_as_signals(run: xr.Dataset, tmp_path: Path):
    samples = save_tables(run, tmp_path / "run.csv")[1]
    read = read_signals(samples, units={"t": "1", "x": "1", "y": "1"}, keep_offset=True)
    assert read["x"].values.tolist() == run["x"].values.tolist()


def test_nothing_is_replaced_without_leave(tmp_path: Path):
    found = folds(zeta=0.07, delta0=0.5)
    (file,) = save_tables(found, tmp_path / "folds.csv")
    assert file.name == "folds.csv"
    with pytest.raises(InputError, match="path must not exist unless overwrite is true"):
        save_tables(found, file)
    assert save_tables(found, file, overwrite=True) == [file]
    other = tmp_path / "run.event.csv"
    other.write_text("mine")
    with pytest.raises(InputError, match=r"got .*run\.event\.csv"):
        save_tables(found, tmp_path / "run.csv")
    assert other.read_text() == "mine"


@pytest.mark.parametrize("name", ["run.txt", "run", "nowhere/run.csv"])
def test_a_path_that_cannot_be_is_refused(run: xr.Dataset, tmp_path: Path, name: str):
    with pytest.raises(InputError, match="path must"):
        save_tables(run, tmp_path / name)
    assert not any(tmp_path.iterdir())
