"""Many drops: the same with every executor and after a break, and honest about their sample."""

from itertools import product

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    RotorSystem,
    Support,
    Unbalance,
    drop,
    drop_ensemble,
)
from rotor_ida.steady.drop_statistics import (
    grid_statistics_of,
    mean_of,
    quantiles_of,
    statistics_of,
    wilson,
)

DISC = RotorSystem(mass=20.0 * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
GIVEN = {
    "contacts": [Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0, friction=0.1,
                         radius=0.03)],
    "supports": [Support(node="disc", stiffness=2e6, damping=2e3)],
    "unbalance": [Unbalance(node="disc", moment=8e-5)], "speed": 500.0, "duration": 0.05,
    "inertia": 0.08,
}  # fmt: skip


def test_a_grid_holds_the_drops_themselves():
    many = drop_ensemble(DISC, **GIVEN, phase=[0.0, 2.0], friction=[0.05, 0.3], workers=1)
    assert many.sizes["drop"] == 4
    assert many.drop_phase.values.tolist() == [0.0, 0.0, 2.0, 2.0]
    bearing = Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0, friction=0.3,
                      radius=0.03)  # fmt: skip
    one = drop(DISC, **GIVEN | {"contacts": [bearing]}, phase=2.0)
    for name in ("largest_force", "total_heat", "excursion"):
        assert many[name][3].values.tolist() == one[name].values.tolist()
    assert many.horizon[3] == one.horizon
    assert "largest_force_quantile" not in many


def test_a_grid_has_the_range_of_each_figure_with_the_drop_where_it_occurs():
    angles, frictions = np.arange(4) * np.pi / 2, [0.05, 0.2, 0.1]
    many = drop_ensemble(DISC, **GIVEN, phase=angles, friction=frictions,
                         clearances={"disc": 3e-4}, workers=1)  # fmt: skip
    for name in ("largest_force", "total_heat", "node_excursion"):
        values = many[name].values[:, 0]
        for end, pick in (("min", np.argmin), ("max", np.argmax)):
            assert many[f"{name}_{end}_drop"].values[0] == pick(values)
            assert many[f"{name}_{end}"].values[0] == values[pick(values)]
    np.testing.assert_allclose(many.node_excursion, many.excursion * 2.0 / 3.0, rtol=1e-3)
    forces = many.largest_force.values.reshape(4, 3)
    np.testing.assert_array_equal(many.cell_friction, frictions)
    np.testing.assert_array_equal(many.cell_largest_force[:, 0], forces.max(axis=0))
    mean = forces.mean(axis=0) @ [1 / 6, 1 / 3, 1 / 2]  # the trapezoidal rule from 0.05 to 0.2
    np.testing.assert_allclose(many.largest_force_mean[0], mean)
    halves = [forces[::2].mean(axis=0) @ [1 / 6, 1 / 3, 1 / 2], forces.mean(axis=0) @ [0.5, 0.5, 0]]
    np.testing.assert_allclose(many.largest_force_mean_change[0], np.abs(halves - mean).sum())
    whirls = (many.whirl_sense.values.reshape(4, 3) < 0).mean(axis=0)
    np.testing.assert_allclose(many.cell_backward_whirl_fraction[:, 0], whirls)


def test_means_over_a_grid_converge_at_the_order_of_the_rule():
    """Over a linear axis the error falls as the square of the step, round the circle at once."""

    def mean_of_grid(count, function):
        axes = {"friction": np.linspace(0.0, 1.0, count), "phase": np.arange(8) * np.pi / 4}
        places = np.array(list(product(*axes.values())))
        found = grid_statistics_of({"f": function(*places.T)[:, None]}, {}, axes, {})
        return found["f_mean"][1][0], found["f_mean_change"][1][0]

    def function(friction, phase):
        return np.exp(friction) * (1.0 + np.cos(phase) + np.cos(2.0 * phase))

    errors = []
    for count in (5, 9, 17):
        mean, change = mean_of_grid(count, function)
        errors.append(abs(mean - (np.e - 1.0)))
        assert errors[-1] < change < 4.0 * errors[-1]
    assert np.all(np.diff(np.log2(errors)) < -1.9)
    assert np.isnan(mean_of_grid(2, function)[1])


def test_a_drop_that_touches_at_once_is_lost_alone_wherever_it_stands():
    for factors in ([0.001, 0.5], [0.5, 0.001]):
        many = drop_ensemble(DISC, **GIVEN, clearance_factor=factors, workers=1)
        lost = np.array(factors) == 0.001
        assert many.status.values.tolist() == lost.astype(int).tolist()
        assert ["must be clear" in str(each) for each in many.message.values] == lost.tolist()
        assert many.clearance.values.tolist() == [2e-4]  # as given, whatever the factors
    with pytest.raises(InputError, match="must be clear of the levitated rotor"):
        drop_ensemble(DISC, **GIVEN, clearance_factor=[0.001, 0.002], workers=1)


def test_statistics_are_of_the_drops():
    many = drop_ensemble(DISC, **GIVEN, drops=9, workers=1, capacities={"disc": 1600.0})
    over = float((many.largest_force > 1600.0).mean())
    assert 0.0 < over < 1.0
    np.testing.assert_allclose(many.overload_fraction[0], over)
    forces = many.largest_force.values[:, 0]
    np.testing.assert_allclose(many.largest_force_mean[0], forces.mean())
    np.testing.assert_allclose(many.largest_force_mean_error[0], forces.std(ddof=1) / 3.0)
    np.testing.assert_allclose(many.largest_force_quantile.sel(quantile=0.5)[0], np.median(forces))
    rests = float((~np.isnan(many.rest_time)).mean())
    np.testing.assert_allclose(many.rest_fraction[0], rests)
    decided = (many.largest_force_time <= many.horizon).mean()
    np.testing.assert_allclose(many.decided_fraction[0], decided)


@pytest.mark.parametrize("draw", ["normal", "exponential", "lognormal", "two kinds"])
def test_intervals_of_means_hold_the_truth_as_often_as_they_say(draw):
    """1,000 samples of 40. Within 1.96 standard errors lie 88 per cent of the lognormal means."""
    numbers = np.random.default_rng(11)
    shape = (1000, 40)
    values, truth = {
        "normal": lambda: (numbers.normal(size=shape), 0.0),
        "exponential": lambda: (-numbers.exponential(size=shape), -1.0),
        "lognormal": lambda: (numbers.lognormal(size=shape), np.exp(0.5)),
        "two kinds": lambda: (1.0 + 4.0 * (numbers.random(shape) < 0.2), 1.8),
    }[draw]()
    found = np.array([mean_of(each) for each in values])
    held = ((found[:, 2] <= truth) & (truth <= found[:, 3])).mean()
    assert 0.93 < held < 0.995
    plain = np.abs(found[:, 0] - truth) <= 1.96 * found[:, 1]
    assert plain.mean() < held
    assert mean_of(np.full(5, 2.0)) == (2.0, 0.0, 2.0, 2.0)
    assert mean_of(values[0, :1])[2:] == (-np.inf, np.inf)


def test_intervals_hold_the_truth_as_often_as_they_say():
    """2,000 samples of 30 from a skew distribution: 95 per cent."""
    draw = np.random.default_rng(5)
    levels = np.array([0.5, 0.75])
    truth = -np.log1p(-levels)
    held = np.zeros(2)
    for _ in range(2000):
        _, low, high = quantiles_of(draw.exponential(size=30), levels)
        held += (low <= truth) & (truth <= high)
    assert (held / 2000 >= 0.945).all()
    for total in range(1, 60):
        _, low, high = wilson(np.array([0, total]), total)
        assert low[0] == 0.0
        assert high[1] == 1.0
    counts = draw.binomial(30, 0.1, size=2000)
    _, low, high = wilson(counts, 30)
    assert 0.93 < np.mean((low <= 0.1) & (high >= 0.1)) < 0.99


def test_intervals_end_where_a_figure_must_and_few_drops_have_none():
    """One large value of ten: the plain interval of the mean reaches below 0 and beyond 5."""
    values = np.full((10, 2), 0.1)
    values[0] = 4.9
    values[5:, 1] = np.nan
    inside = statistics_of({"f": values}, {}, {}, {"f": (0.0, 2.0)})
    free = statistics_of({"f": values}, {}, {}, {"f": (-np.inf, np.inf)})
    assert free["f_mean_low"][1][0] < 0.0
    assert free["f_mean_high"][1][0] > 2.0
    assert (inside["f_mean_low"][1][0], inside["f_mean_high"][1][0]) == (0.0, 2.0)
    np.testing.assert_array_equal(inside["f_mean"][1], free["f_mean"][1])
    for name in ("f_mean_low", "f_mean_high", "f_quantile", "f_quantile_low", "f_quantile_high"):
        assert np.isnan(inside[name][1][..., 1]).all()
        assert not np.isnan(inside[name][1][..., 0]).any()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"drops": 1}, "drops must be"),
        ({"drops": 3, "friction": [0.1, 0.2, 0.3]}, "friction must be a range of two numbers"),
        ({"friction": [-0.1]}, "friction must be zero or positive"),
        ({"phase": np.zeros(400), "friction": np.full(400, 0.1)}, "drops must be at most 100000"),
    ],
)
def test_what_cannot_be_varied_is_refused_in_one_line(change, words):
    with pytest.raises(InputError, match=words):
        drop_ensemble(DISC, **GIVEN, **change)
