"""Parameters of closed forms: arrays are dimensions, numbers coordinates, defaults neither."""

import itertools

import numpy as np
import pytest

from rotor_ida import folds, hopf_points, impact, synchronous_response
from rotor_ida.closed_forms import clearance_curve, cusp, peaks, response_curve

LAW = {"shaft_stiffness": [0.0, 0.3], "contact_exponent": [1.0, 1.5]}
DAMPED = {"zeta": [0.0, 0.07], "delta0": [0.5, 2.0], "shaft_stiffness": [0.0, 0.25]}
# Axes in the order of dimensions, and what else each function takes.
ASKED = {
    synchronous_response: (
        {"omega": [0.0, 0.6, 1.7], "zeta": [0.0, 0.07], "delta0": [0.5, 1.0], **LAW,
         "contact_damping": [0.0, 2.0], "friction": [0.0, 0.1]}, {},
    ),
    folds: (DAMPED | {"contact_damping": [0.0, 0.1], "friction": [0.0, 0.1]}, {}),
    hopf_points: (DAMPED | {"contact_damping": [0.5], "friction": [0.0, 0.1]}, {}),
    peaks: ({"zeta": [0.1, 0.2], "delta0": [0.0, 0.5], **LAW}, {}),
    cusp: ({"delta0": [0.5, 2.0], **LAW, "friction": [0.0, 0.1]}, {}),
    impact: ({"entry_speed": [1.0, 2.0], "contact_damping": [0.0, 0.5],
              "contact_exponent": [1.0, 1.5]}, {}),
    response_curve: (
        {"zeta": [0.07, 0.3], "delta0": [0.5, 1.0], **LAW, "friction": [0.0, 0.1]},
        {"limits": (0.1, 3.0), "points": 20, "contact_damping": 0.2},
    ),
    clearance_curve: (
        {"omega": [0.8, 1.7], "zeta": [0.07, 0.3], **LAW}, {"limits": (0.1, 3.0), "points": 20},
    ),
}  # fmt: skip
DEFAULTS = {"shaft_stiffness": 0.0, "contact_exponent": np.array(1.5), "contact_damping": 0.0,
            "friction": 0.0}  # fmt: skip
# What stands where a point has fewer rows than another; elsewhere it is NaN.
ABSENT = {"stability": -1, "in_contact": 0, "piece": -1}
of_each = pytest.mark.parametrize("function", ASKED, ids=lambda each: each.__name__)


@of_each
def test_a_grid_holds_what_single_calls_hold(function):
    axes, more = ASKED[function]
    grid = function(**axes, **more)
    table = grid[next(iter(grid.data_vars))]
    assert table.dims[: len(axes)] == tuple(axes)
    assert table.shape[: len(axes)] == tuple(map(len, axes.values()))
    assert all(grid[name].ndim == 0 for name in DEFAULTS.keys() & more.keys())
    places = [*itertools.product(*axes.values())]
    for values in places[:: len(places) // 12 | 1]:
        place = dict(zip(axes, values, strict=True))
        point, alone = grid.sel(place), function(**place, **more)
        for name in grid.data_vars:
            found, expected = point[name].values.ravel(), alone[name].values.ravel()
            np.testing.assert_array_equal(found[: expected.size], expected)
            rest = found[expected.size :]
            assert (rest == ABSENT[name] if name in ABSENT else np.isnan(rest)).all(), name


@of_each
def test_a_default_is_no_coordinate_and_a_number_no_dimension(function):
    axes, more = ASKED[function]
    place = more | {name: values for name, values in axes.items() if name not in DEFAULTS}
    if function in (hopf_points, impact):
        place["contact_damping"] = 0.5
    plain = function(**place)
    others = {name: DEFAULTS[name] for name in axes if name in DEFAULTS and name not in place}
    same = function(**place, **others)
    for each in (plain, same):
        each.attrs.pop("question", None)  # as each was asked
    assert same.identical(plain)
    for name in others:
        value = axes[name][0] or axes[name][1]
        number = function(**place | {name: value})
        assert (
            number[next(iter(plain.data_vars))].dims[:-1]
            == (plain[next(iter(plain.data_vars))].dims[:-1])
        )
        assert number[name].item() == value
        assert set(number.coords) - set(plain.coords) == {name}
