"""Every variable of an archive of every kind is computed again and compared, or listed with why."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, hopf_points, load, save
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.verification.comparison_rules import VERIFIED
from rotor_ida.verification.variables import NO_MORE
from rotor_ida.verification.verify import differences, rerun
from tests import example_datasets

RUB = {"zeta": 0.05, "delta0": 0.5, "friction": 0.5, "shaft_stiffness": 0.1}
MADE = {**example_datasets.KINDS, "hopf_points": lambda: hopf_points(**RUB)}
del MADE["run_without_times"], MADE["runs_by_name"]


@cache
def made_again(name: str) -> tuple[xr.Dataset, xr.Dataset | None]:
    """Return a result from its archive, and computed again where that can be."""
    made = MADE[name]()
    if kind_of(made) not in VERIFIED:
        return made, None
    with TemporaryDirectory() as folder:
        archived = load(save(made, Path(folder) / "result.nc"))
    return archived, rerun(archived)


def changed(dataset: xr.Dataset, name: str) -> xr.Dataset | None:
    """Return a dataset in which one number is larger by 5 %, or one word longer; None without."""
    variable = dataset.variables[name]
    values = np.array(variable.values)
    if not values.size:
        return None
    if values.dtype.kind == "U":
        values = values.astype(object)
        values.flat[0] = f"{values.flat[0]} too"
        values = values.astype(str)
    elif values.dtype.kind == "f":
        sizes = np.where(np.isfinite(values), np.abs(values), -1.0)
        place = int(sizes.argmax())
        values.flat[place] = 1.05 * values.flat[place] if sizes.flat[place] > 0.0 else 1.0
    else:
        values.flat[0] += 1
    if name in dataset.indexes:
        return dataset.assign({name: (variable.dims, values, variable.attrs)})
    forged = dataset.copy()  # whose variables are its own
    forged.variables[name].values = values
    return forged


@pytest.mark.parametrize("name", MADE)
def test_a_changed_number_is_noticed_wherever_it_stands(name: str):
    archived, again = made_again(name)
    if again is None:
        pytest.skip(f"a result of the kind {kind_of(archived)} is not computed again")
    found = differences(again, archived)
    assert found["agrees"] is True, found["trouble"]
    left_out = found["not_compared"]
    assert isinstance(left_out, dict)
    assert all(left_out.values())
    assert NO_MORE not in left_out.values()
    assert found["variables"] == len(archived.variables) - len(left_out) > 0
    for each in archived.variables:
        forged = None if each in left_out else changed(archived, str(each))
        if forged is not None:
            try:
                told = differences(again, forged)
            except InputError as error:  # a flag that is none
                told = {"agrees": False, "trouble": str(error)}
            assert not told["agrees"], each
            assert each in str(told["trouble"]), each
    for each in filter(None, str(found["attributes"]).split(", ")):
        forged = archived.assign_attrs({each: other_than(archived.attrs[each])})
        try:
            told = differences(again, forged)
        except InputError:  # a word that is none
            continue
        assert not told["agrees"], each
        assert f"{each} differs" in str(told["trouble"]), each
    reasons = found["attributes_not_compared"]
    assert isinstance(reasons, dict)
    assert {"title"} <= reasons.keys()


def test_an_archive_of_which_nothing_is_compared_does_not_agree():
    archived, again = made_again("whirls")
    assert again is not None
    told = differences(again.drop_vars(set(again.data_vars)), archived.drop_vars(
        {"phase_lag", "stability", "in_contact", "growth_rate"}
    ))  # fmt: skip
    assert (told["agrees"], told["trouble"]) == (False, "no variable was compared")


def other_than(value):
    """Return another word, or numbers that are 5 % larger."""
    if isinstance(value, str):
        return f"{value} too"
    return np.where(np.asarray(value) == 0, 1, 1.05 * np.asarray(value))
