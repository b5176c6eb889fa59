"""Figures refuse datasets and arguments that they cannot draw, in one line."""

from __future__ import annotations

import pytest
import xarray as xr

from rotor_ida import InputError
from rotor_ida.closed_forms import restoring_field
from rotor_ida.plot import plot_basin_fractions, plot_curves, plot_cuts, plot_surface

FIELD = restoring_field(x=[0, 1], y=[0, 1], delta0=0.5)
FRACTIONS = xr.Dataset(
    {"response_fraction": (("omega", "response"), [[1.0, 0.0], [0.25, 0.75]])},
    {"omega": [1.0, 2.0], "response": [2, 3], "zeta": 0.07, "delta0": 0.5},
)


@pytest.mark.parametrize(
    ("field", "name", "words"),
    [
        (FIELD, "x", "x along y and x, got x: 2"),
        (FIELD, 3, "named by text, got 3"),
        (FIELD, ["potential"], "named by text"),
        (FIELD, "delta0", "delta0 along y and x, got one number"),
        (FIELD.isel(x=0), "potential", "potential along y and x, got y: 2"),
    ],
)
def test_a_surface_and_cuts_need_numbers_over_the_plane(field, name, words):
    with pytest.raises(InputError, match=words):
        plot_surface(field, name)
    with pytest.raises(InputError, match=words):
        plot_cuts(field, name, at=[0.0])


@pytest.mark.parametrize("at", ["a", ["a"], [float("nan")], [], [[0.0]]])
def test_cuts_are_at_numbers(at):
    with pytest.raises(InputError, match="at must"):
        plot_cuts(FIELD, "potential", at=at)


def test_a_cut_is_at_the_nearest_y():
    drawn = plot_cuts(FIELD, "potential", at=0.8).lines[0].get_ydata()
    assert drawn.tolist() == FIELD["potential"].sel(y=1.0).values.ravel().tolist()


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
