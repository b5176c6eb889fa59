"""Results of every kind that somebody altered are shown by dimension or refused in one line."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, dimensional
from rotor_ida.cli.describe import describe
from rotor_ida.plot.figures import figure_of
from rotor_ida.results.dataset_kinds import KINDS, kind_of
from rotor_ida.schema.quantities import OTHER_UNITS
from tests.example_datasets import KINDS as DATASETS
from tests.example_datasets import MACHINE

# The other tests have each of these under another name.
SAME = {"run_without_contact", "run_without_times", "sweep_both_ways", "system_cycle"}


def with_values(dataset, name, value):
    """Return a dataset with a value in each place of a variable."""
    variable = dataset.variables[name]
    plain = dataset.drop_indexes(name) if name in dataset.indexes else dataset
    values = np.full(variable.shape, value)
    return plain.assign({name: (variable.dims, values, variable.attrs)})


def with_unit(dataset, name, unit):
    altered = dataset.copy()
    altered[name] = altered[name].assign_attrs(units=unit)
    return altered


ALTERATIONS = {
    "dropped": lambda dataset, name: dataset.drop_vars(name),
    "along another dimension": lambda dataset, name: dataset.drop_vars(name).assign(
        {name: ("somewhere_else", [1.0, 2.0])}
    ),
    "dates": lambda dataset, name: with_values(dataset, name, np.datetime64("2020-01-01", "ns")),
    "objects": lambda dataset, name: with_values(dataset, name, None),
    "another number": lambda dataset, name: with_values(dataset, name, 77),
    "units in a list": lambda dataset, name: with_unit(dataset, name, ["m", "s"]),
    "units in an array": lambda dataset, name: with_unit(dataset, name, np.arange(3)),
}


@pytest.mark.parametrize("kind", sorted(DATASETS.keys() - SAME))
def test_an_altered_result_is_shown_or_refused_in_one_line(kind):
    dataset = DATASETS[kind]()
    needed = [name.partition("(")[0] for name in KINDS[kind_of(dataset)].variables.split()]
    there = [name for name in needed if name in dataset] or list(dataset.data_vars)
    for number, (how, alter) in enumerate(ALTERATIONS.items()):
        for name in {there[number % len(there)], there[-1]}:
            altered = alter(dataset, name)
            with suppress(InputError):
                describe(altered, most=3)
            if how in {"dates", "objects"}:
                with pytest.raises(InputError, match="must "):
                    figure_of(altered)


def test_a_figure_says_what_its_dataset_lacks():
    sweep = DATASETS["sweep"]()
    with pytest.raises(InputError, match=r"got 'other' \(for 'sweep' it lacks response\)$"):
        figure_of(sweep.drop_vars("response"))
    with pytest.raises(InputError, match=r"\(for 'sweep' it lacks start_x along start\)$"):
        figure_of(sweep.assign(start_x=1.0))
    with pytest.raises(InputError, match=r"\(for 'sweep' it lacks values along omega\)$"):
        figure_of(sweep.isel(omega=[]))


def test_dates_are_not_converted_to_si_units():
    run = DATASETS["run"]()
    with pytest.raises(InputError, match="x of dataset must be real numbers, got datetime64"):
        dimensional(with_values(run, "x", np.datetime64("2020-01-01", "ns")), MACHINE)


def test_a_part_of_a_result_whose_flags_are_missing_is_counted():
    sweep = DATASETS["sweep"]()
    part = sweep.where(sweep["omega"] > 1.25)
    assert isinstance(part, xr.Dataset)
    assert "unknown" not in str(describe(part, most=1)[0])


@pytest.mark.parametrize("kind", ["run", "run_in_si_units", "sweep", "system_run", "basin"])
def test_a_unit_of_another_kind_is_refused_in_one_line(kind):
    dataset = DATASETS[kind]()
    for name, variable in dataset.variables.items():
        if "units" not in variable.attrs or name in OTHER_UNITS or name.endswith("_matrix"):
            continue
        with pytest.raises(InputError, match=f"^units of {name} of this .* got 'kg'$"):
            describe(with_unit(dataset, name, "kg"), most=3)
    name = "t" if "t" in dataset.variables else "x" if "x" in dataset.variables else "amplitude"
    other = {"t": "ms"}.get(name, "mm")
    assert describe(with_unit(dataset, name, other), most=3)[1]
