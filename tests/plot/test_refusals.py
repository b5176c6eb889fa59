"""Figures refuse datasets and arguments that they cannot draw, in one line."""

from __future__ import annotations

import pytest
import xarray as xr

from rotor_ida import InputError
from rotor_ida.plot import plot_basin_fractions, plot_curves

FRACTIONS = xr.Dataset(
    {"response_fraction": (("omega", "response"), [[1.0, 0.0], [0.25, 0.75]])},
    {"omega": [1.0, 2.0], "response": [2, 3], "zeta": 0.07, "delta0": 0.5},
)


@pytest.mark.parametrize("curves", [3, None, "ab", [None]])
def test_curves_are_datasets(curves):
    with pytest.raises(InputError, match="curves must be "):
        plot_curves(curves)


@pytest.mark.parametrize(
    ("dataset", "words"),
    [
        (FRACTIONS.isel(omega=0), "along omega and response, got response: 2"),
        (FRACTIONS.isel(omega=[]), "along omega and response, got omega: 0"),
        (FRACTIONS.isel(omega=[0]), "at least 2 omega, got 1"),
        (FRACTIONS.expand_dims(zeta=[0.07, 0.08]), "got zeta: 2, omega: 2, response: 2"),
        (FRACTIONS.astype(str), "must be real numbers, got <U"),
    ],
)
def test_fractions_are_drawn_over_several_speeds_of_one_rotor(dataset, words):
    with pytest.raises(InputError, match=words):
        plot_basin_fractions(dataset)
