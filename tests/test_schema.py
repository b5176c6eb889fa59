"""Every result of the package is labelled: names, units, parameters, method and versions."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Rotor,
    basin,
    basin_fractions,
    compare,
    contact_summary,
    folds,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.schema import QUANTITIES, flags_of, labelled_dataset


@pytest.fixture(scope="module")
def results():
    run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    swept = sweep(omega=[1.0, 2.0], zeta=0.5, delta0=0.5)
    return {
        "run": run,
        "summary": contact_summary(run),
        "sweep": swept,
        "comparison": compare(swept),
        "whirls": synchronous_response(omega=1.7, zeta=0.07, delta0=[0.0, 0.5]),
        "folds": folds(zeta=0.07, delta0=0.5),
        "basin": basin(Rotor(omega=1.7, zeta=0.3, delta0=0.0), x=[0.0, 5.0], y=[0.0, 5.0]),
        "basin_fractions": basin_fractions(
            Rotor(omega=1.7, zeta=0.3, delta0=0.0), x=(0, 5), y=0.0, starts=10
        ),
    }


def test_every_variable_says_what_it_is(results):
    for result, dataset in results.items():
        for name, variable in dataset.variables.items():
            assert variable.attrs["long_name"] == QUANTITIES[name].long_name, (result, name)
            assert name == "message" or variable.attrs["units"], (result, name)
            assert variable.dtype != bool
            assert variable.dtype.kind != "c"


def test_flags_hold_only_what_their_meanings_list(results):
    for dataset in results.values():
        for name, variable in dataset.data_vars.items():
            if "flag_values" in variable.attrs:
                assert set(np.unique(variable)) <= set(flags_of(variable).values()), name


def test_attributes_tell_how_it_was_made(results):
    for name in ("run", "sweep", "comparison", "basin", "basin_fractions"):
        attributes = results[name].attrs
        # starts are labelled by another method than the one that confirms where they end
        purpose = "confirmation_" if name.startswith("basin") else ""
        for key in ("method", "flight", "backend", "rtol", "atol"):
            assert purpose + key in attributes, (name, key)
        for key in ("Conventions", "title"):
            assert key in attributes, (name, key)
        for package in ("rotor_ida", "scikit_sundae", "sundials", "numpy", "python"):
            assert attributes[f"{package}_version"]
    run = results["run"].attrs
    assert (run["omega"], run["zeta"], run["delta0"]) == (2.0, 0.07, 2.0)
    assert run["start"].tolist() == [0.0] * 4
    assert run["duration"] == 20.0


def test_all_results_are_labelled_by_the_three_parameters(results):
    for dataset in results.values():
        parameters = {"omega", "zeta", "delta0"} & set(dataset.coords)
        assert parameters >= ({"zeta", "delta0"} if "fold" in dataset.dims else {"omega", "zeta"})


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
