"""Every result of the package is labelled: names, units, parameters, method and versions."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    InputError,
    Rotor,
    basin_fractions,
    decode_flags,
    poincare_section,
    synchronous_response,
)
from rotor_ida.schema import QUANTITIES, flags_of, labelled, words_of
from tests.example_datasets import KINDS, REST

RESULTS = {
    name: KINDS[name]
    for name in (
        *("run", "contact_summary", "sweep", "comparison", "whirls", "folds", "basin"),
        *("basin_fractions", "rotating", "contact_forces", "poincare_section"),
        *("lyapunov_exponent", "bifurcation_diagram"),
    )
} | {
    "empty_section": lambda: poincare_section(
        Rotor(omega=1.0, zeta=0.5, delta0=9.0), start=REST, revolutions=5, at="exit"
    )
}
ANALYSED = ("rotating", "contact_forces", "poincare_section", "empty_section",
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


def test_flags_of_a_whole_result_become_words_on_axes_too():
    found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-9, 9), y=(-9, 9), starts=9)
    told = decode_flags(found)
    assert told.kind.values.tolist() == ["synchronous", "synchronous"]
    assert float(told.response_fraction.sel(response="synchronous")) == 1.0
    assert told.amplitude.identical(found.amplitude)
    assert not {"flag_values", "flag_meanings", "units"} & set(told.kind.attrs)
    assert found.kind.dtype == np.int8


def test_a_flag_without_a_value_has_no_word():
    kinds = xr.DataArray(labelled("event_kind", "event", [1.0, np.nan, -1.0]))
    assert decode_flags(kinds).values.tolist() == ["entry", "", "exit"]


def test_a_number_that_is_no_flag_is_refused_by_name():
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    odd = whirls.assign(stability=whirls["stability"] + np.int8(90))
    odd["stability"].attrs = whirls["stability"].attrs
    with pytest.raises(InputError, match=r"stability must be one of .*, got 9\d"):
        words_of(odd["stability"])
    del odd["stability"].attrs["flag_values"]
    with pytest.raises(InputError, match="must have a number for each of"):
        words_of(odd["stability"])


def test_numbers_without_words_are_refused():
    with pytest.raises(InputError, match="flags must be one of -1, 1, got 7"):
        decode_flags(xr.DataArray(labelled("event_kind", "event", [1, 7])))
    with pytest.raises(InputError, match="must have flag_meanings"):
        decode_flags(xr.DataArray([1.0]))
    with pytest.raises(InputError, match="data must be a Dataset or DataArray, got list"):
        decode_flags([1])
