"""Every result of the package is labelled: names, units, parameters, method and versions."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from rotor_ida import Rotor, load, poincare_section, save
from rotor_ida.schema import QUANTITIES, flags_of, labelled_dataset
from tests.kinds import KINDS, REST

RESULTS = {
    name: KINDS[name]
    for name in (
        *("run", "contact_summary", "sweep", "comparison", "whirls", "folds", "basin"),
        *("basin_fractions", "rotating", "spectrum", "contact_forces", "poincare_section"),
        *("lyapunov_exponent", "bifurcation_diagram"),
    )
} | {
    "empty_section": lambda: poincare_section(
        Rotor(omega=1.0, zeta=0.5, delta0=9.0), start=REST, revolutions=5, at="exit"
    )
}
ANALYSED = ("rotating", "spectrum", "contact_forces", "poincare_section", "empty_section",
            "lyapunov_exponent", "bifurcation_diagram")  # fmt: skip


@cache
def made(name: str) -> xr.Dataset:
    return RESULTS[name]()


@pytest.mark.parametrize("name", RESULTS)
def test_every_variable_says_what_it_is(name: str):
    dataset = made(name)
    for each, variable in dataset.variables.items():
        assert variable.attrs["long_name"] == QUANTITIES[each].long_name, each
        assert each == "message" or variable.attrs["units"], each
        assert variable.dtype.kind not in "bc"
        if "flag_values" in variable.attrs:
            assert set(np.unique(variable)) <= set(flags_of(variable).values()), each
    parameters = {"omega", "zeta", "delta0"} & set(dataset.coords)
    assert parameters >= ({"zeta", "delta0"} if "fold" in dataset.dims else {"omega", "zeta"})


@pytest.mark.parametrize(
    "name", ["run", "sweep", "comparison", "basin", "basin_fractions", *ANALYSED]
)
def test_attributes_tell_how_it_was_made(name: str):
    attributes = made(name).attrs
    # starts are labelled by another method than the one that confirms where they end
    purpose = "confirmation_" if name.startswith("basin") else ""
    backend = () if name in ANALYSED else ("backend", "atol")
    for key in ("method", "flight", "rtol", *backend):
        assert purpose + key in attributes, key
    assert {"Conventions", "title", "source", "result_kind"} <= attributes.keys()
    packages = ("rotor_ida", "numpy") + (
        () if name in ANALYSED else ("scikit_sundae", "sundials", "python")
    )
    assert all(attributes[f"{package}_version"] for package in packages)


def test_the_attributes_of_a_run_are_what_was_given():
    run = made("run").attrs
    assert (run["omega"], run["zeta"], run["delta0"]) == (2.0, 0.07, 2.0)
    assert run["start"].tolist() == [0.0] * 4
    assert run["duration"] == 20.0
    assert len({made(name).attrs["title"] for name in ANALYSED if "section" not in name}) == 5


@pytest.mark.parametrize("name", ANALYSED)
def test_an_archive_gives_it_back(name: str, tmp_path: Path):
    back = load(save(made(name), tmp_path / "result.nc"))
    assert back.attrs["result_kind"] == made(name).attrs["result_kind"]
    for each, variable in made(name).variables.items():
        np.testing.assert_array_equal(back[each].values, variable.values)


def test_a_dataset_is_the_same_without_what_xarray_keeps_to_itself(monkeypatch):
    columns = {"amplitude": ("omega", [2.0, 3.0]), "period": ((), 4.0)}
    coordinates = {"omega": ("omega", [1.7, 1.8]), "zeta": ((), 0.07)}
    direct = labelled_dataset("whirls", columns, coordinates, {"start": "rest"})
    construct = xr.Dataset._construct_direct

    def by_keywords_alone(**given):
        return construct(**given)

    monkeypatch.setattr(xr.Dataset, "_construct_direct", by_keywords_alone)
    plain = labelled_dataset("whirls", columns, coordinates, {"start": "rest"})
    monkeypatch.undo()
    assert plain.identical(direct)
    assert list(plain.indexes) == list(direct.indexes)


def test_columns_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^omega must be of size 2 along omega, got 1$"):
        labelled_dataset(
            "whirls", {"amplitude": ("omega", [2.0, 3.0])}, {"omega": ("omega", [1.7])}
        )
