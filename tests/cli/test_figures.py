"""The figures that the command line draws."""

import numpy as np
import pytest

from rotor_ida import (
    folds,
    hopf_points,
    run_ups,
    sweep,
)
from rotor_ida.cli.describe import describe
from rotor_ida.plot.figures import figure_of


def test_unused_panels_are_left_out_and_those_above_have_their_speeds():
    found = sweep(omega=[1.0, 1.2], zeta=0.5, delta0=[0.0, 0.5, 1.0])
    figure = figure_of(found)
    assert len(figure.axes) == 3
    assert [ax.get_xlabel() != "" for ax in figure.axes] == [False, True, True]


@pytest.mark.parametrize("delta0", [[0.0], [0.0, 0.5, 1.0]])
def test_legend_is_no_wider_than_the_figure(delta0):
    found = sweep(omega=[0.5, 1.9], zeta=0.07, delta0=delta0, direction="both")
    figure = figure_of(found)
    figure.draw_without_rendering()
    (legend,) = figure.legends or [figure.axes[0].get_legend()]
    assert legend.get_window_extent().width <= figure.bbox.width


def test_a_sweep_of_machines_has_a_panel_each_with_the_curve_where_one_is_known():
    machines = {"shaft_stiffness": 0.25, "contact_damping": [0.0, 0.3], "load": [0.0, 0.3]}
    found = sweep(omega=[1.0, 2.0], zeta=0.2, delta0=1.0, method="taylor", **machines)
    axes = figure_of(found).axes
    assert len(axes) == 4
    for ax, (damping, load) in zip(axes, [(0.0, 0.0), (0.0, 0.3), (0.3, 0.0), (0.3, 0.3)],
                                   strict=True):  # fmt: skip
        title, labels = ax.get_title(), [line.get_label() for line in ax.lines]
        assert (r"$c = 0.3$" in title) == (damping > 0.0)
        at_rest = "no linear response: at rest on the stator" in title  # 0.3/0.25 is more than 1
        assert at_rest == (load > 0.0)
        assert ("stable whirl" in labels) == (load == 0.0)


@pytest.mark.parametrize("found", [hopf_points, folds])
def test_folds_and_hopf_points_are_shown_on_their_curves(found):
    dataset = found(zeta=0.07, delta0=[0.5, 1.0], friction=0.1)
    axes = figure_of(dataset).axes
    assert len(axes) == 2
    for ax, delta0 in zip(axes, (0.5, 1.0), strict=True):
        lines = {line.get_label(): line for line in ax.lines}
        for word, of in (("Hopf point", hopf_points), ("fold", folds)):
            name = "hopf_omega" if of is hopf_points else "fold_omega"
            exact = of(zeta=0.07, delta0=delta0, friction=0.1)[name].values.ravel()
            np.testing.assert_array_equal(
                lines[word].get_xdata(), exact[np.isfinite(exact)], err_msg=word
            )


def test_run_ups_are_told_by_rate_and_drawn():
    found = run_ups(
        omega=0.3, to=1.6, rate=[0.01, 0.2], zeta=0.1, delta0=2.0, shaft_stiffness=1.0,
        phase=[0.0, 1.0], method="taylor",
    )  # fmt: skip
    record, parts = describe(found, most=10)
    assert record["kind"] == "run_ups"
    assert [row["rate"] for row in record["fractions"]] == [0.01, 0.2]
    assert [row["rub_fraction"] for row in record["fractions"]] == [1.0, 0.0]
    assert record["fractions"][0]["largest_force"] == found.largest_force.values.max()
    assert [row["ending"] for row in record["run_ups"]] == ["rub"] * 2 + ["contact_free"] * 2
    assert len(parts) == 2
    assert len(figure_of(found).axes) == 2
