"""A result as CSV: every number comes back to the last bit, flags are words, no file is lost."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Contact,
    Rotor,
    RotorSystem,
    Unbalance,
    bifurcation_diagram,
    decode_flags,
    folds,
    lyapunov_exponent,
    read_signals,
    simulate,
    sweep,
    synchronous_response,
    to_dataframe,
)
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


RUB = RotorSystem(
    mass=np.eye(4), stiffness=np.kron([[2.0, -1.0], [-1.0, 2.0]], np.eye(2)),
    damping=0.1 * np.eye(4), nodes={"disc": (0, 1), "seal": (2, 3)}, units="1",
    unbalance=[Unbalance(node="disc", moment=0.4)],
    contacts=[Contact(node=node, clearance=0.5, stiffness=3.0) for node in ("disc", "seal")],
)  # fmt: skip


@pytest.fixture(scope="module")
def swept() -> xr.Dataset:
    return sweep(RUB, speed=[0.7, 0.9, 1.1], friction=[0.0], unbalance=[0.2, 0.4])


def test_a_sweep_of_a_system_has_a_row_for_each_point(swept: xr.Dataset, tmp_path: Path):
    """Contacts and nodes are columns; each cell is the number of the dataset."""
    table = to_dataframe(swept)
    assert len(table) == swept.response.size == 6
    assert list(table.index.names) == ["speed", "friction", "unbalance", "start", "direction"]
    for name, part in (("radius_max", "contact"), ("node_phase_lag", "node")):
        for number, word in enumerate(("disc", "seal")):
            own = swept[name].isel({part: number}).values.ravel()
            np.testing.assert_array_equal(table[f"{name}[{word}]"], own)
    assert table.response.tolist() == words_of(swept.response)
    assert table.loc[(0.9, 0.0, 0.4), "message"].tolist() == [""]
    found = {path.name: rows_in(path) for path in save_tables(swept, tmp_path / "s.csv")}
    points = found["s.speed-friction-unbalance-start-direction.csv"]
    assert [float(row["largest_force[seal]"]) for row in points] \
        == swept.largest_force.isel(contact=1).values.ravel().tolist()  # fmt: skip
    assert [row["contact_node"] for row in found["s.contact.csv"]] == ["disc", "seal"]
    assert not any("component" in name for name in found)  # states stay in the archive


def test_one_point_and_a_part_of_a_sweep_have_tables_too(swept: xr.Dataset):
    point = swept.isel(speed=1, friction=0, unbalance=1, start=0, direction=0)
    (row,) = to_dataframe(point).to_dict("records")
    assert row["amplitude[seal]"] == float(point.amplitude[1])
    squeezed = to_dataframe(swept.squeeze().sel(unbalance=0.4))
    assert squeezed.index.tolist() == [0.7, 0.9, 1.1]
    assert row["amplitude[seal]"] == squeezed["amplitude[seal]"].iloc[1]


def test_two_contacts_at_a_node_are_told_by_their_numbers():
    apart = [Contact(node="disc", clearance=0.5, stiffness=3.0),
             Contact(node="disc", clearance=0.5, stiffness=3.0, centre=(0.1, 0.0))]  # fmt: skip
    run = simulate(RUB, contacts=apart, speed=0.9, duration=2.0, samples=5)
    table = to_dataframe(run)
    assert len(table) == 5
    np.testing.assert_array_equal(table["normal_force[1]"], run.normal_force[:, 1])
    np.testing.assert_array_equal(table["vy[seal]"], run.vy[:, 1])


def test_tables_of_other_results_are_those_of_their_first_dimensions(run: xr.Dataset):
    whirls = synchronous_response(RUB, speed=[0.7, 1.1])
    assert len(to_dataframe(whirls)) == whirls.stability.size
    disc = sweep(omega=[1.0, 1.2], zeta=0.3, delta0=0.5, events=True)
    assert to_dataframe(disc).amplitude.tolist() == disc.amplitude.values.ravel().tolist()
    assert to_dataframe(run).index.tolist() == run.t.values.tolist()
    short = {"transient": 10.0, "duration": 40.0, "batches": 4}
    found = lyapunov_exponent(omega=1.2, zeta=[0.3, 0.5], delta0=0.5, **short)
    np.testing.assert_array_equal(
        to_dataframe(found)["lyapunov_exponent[3]"], found.lyapunov_exponent[:, 3]
    )
    plain = decode_flags(folds(zeta=0.07, delta0=0.5))
    assert to_dataframe(plain).equals(plain.to_dataframe())
    with pytest.raises(InputError, match="dataset must be a Dataset, got 3"):
        to_dataframe(3)
    with pytest.raises(InputError, match="dataset must contain a variable for a table, got none"):
        to_dataframe(xr.Dataset())


def test_the_samples_of_a_run_are_read_as_signals(run: xr.Dataset, tmp_path: Path):
    samples = save_tables(run, tmp_path / "run.csv")[1]
    read = read_signals(samples, units={"t": "1", "x": "1", "y": "1"}, gap="0")
    assert read["x"].values.tolist() == run["x"].values.tolist()


def test_nothing_is_replaced_without_leave(tmp_path: Path):
    found = folds(zeta=0.07, delta0=0.5)
    (file,) = save_tables(found, tmp_path / "folds.csv")
    assert file.name == "folds.csv"
    with pytest.raises(InputError, match="already exists; pass overwrite=True to replace it"):
        save_tables(found, file)
    assert save_tables(found, file, overwrite=True) == [file]
    other = tmp_path / "run.event.csv"
    other.write_text("mine")
    with pytest.raises(InputError, match=r"run\.event\.csv' already exists"):
        save_tables(found, tmp_path / "run.csv")
    assert other.read_text() == "mine"


@pytest.mark.parametrize("name", ["run.txt", "run", "nowhere/run.csv"])
def test_a_path_that_cannot_be_is_refused(run: xr.Dataset, tmp_path: Path, name: str):
    with pytest.raises(InputError, match="path must"):
        save_tables(run, tmp_path / name)
    assert not any(tmp_path.iterdir())


def test_a_stroboscopic_diagram_has_a_row_for_each_state():
    system = Rotor(omega=1.0, zeta=0.3, delta0=0.5, shaft_stiffness=0.25).system()
    found = bifurcation_diagram(system, speed=[0.3, 1.2], at="revolution", revolutions=4, workers=1)
    table = to_dataframe(found)
    assert len(table) == 2 * found.sizes["crossing"]
    last = found.isel(crossing=-1).squeeze()
    ends = table.reset_index().groupby("speed").last()
    assert ends["rotating_x[disc]"].tolist() == last.rotating_x.values.ravel().tolist()
    assert ends["radius_max[disc]"].tolist() == last.radius_max.values.ravel().tolist()
