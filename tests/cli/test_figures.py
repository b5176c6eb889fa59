"""The figures that the command line draws."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    InputError,
    Rotor,
    backward_whirl,
    basin,
    basin_fractions,
    bifurcation_diagram,
    folds,
    hopf_points,
    run_ups,
    sweep,
    synchronous_response,
)
from rotor_ida.cli.describe import describe
from rotor_ida.plot.figures import figure_of


@pytest.mark.parametrize("omega", [1.7, [1.2, 1.7]])
def test_whirls_at_few_speeds_are_marked_on_the_whole_curve(omega):
    whirls = synchronous_response(omega=omega, zeta=0.07, delta0=0.5)
    (ax,) = figure_of(whirls).axes
    lines = {line.get_label(): line for line in ax.lines}
    marked = lines["whirl at a given speed"].get_ydata()
    np.testing.assert_array_equal(
        np.sort(marked[np.isfinite(marked)]),
        np.sort(whirls.amplitude.values[whirls.amplitude.notnull()]),
    )
    assert np.isfinite(lines["stable whirl"].get_ydata()).sum() > 100


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


def test_basin_is_drawn_in_the_style_of_the_others():
    axis = np.linspace(-5.0, 5.0, 4)
    (ax,) = figure_of(basin(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=axis, y=axis)).axes
    assert ax.get_xticklabels()[0].get_fontfamily() == ["STIXGeneral", "DejaVu Sans"]


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


def test_whirls_of_a_machine_are_drawn_on_its_curve():
    whirls = synchronous_response(omega=[1.0, 2.0], zeta=0.2, delta0=1.0, shaft_stiffness=0.25)
    (ax,) = figure_of(whirls).axes
    assert r"$\kappa = 0.25$" in ax.get_title()


def test_a_sweep_with_friction_has_hopf_points_on_its_curve():
    found = sweep(omega=[1.0, 2.0], zeta=0.07, delta0=0.5, friction=[0.0, 0.1], disc_radius=10.0,
                  method="taylor")  # fmt: skip
    smooth, rubbing = figure_of(found).axes
    exact = hopf_points(zeta=0.07, delta0=0.5, friction=0.1).hopf_omega.values.ravel()
    lines = {line.get_label(): line for line in rubbing.lines}
    np.testing.assert_array_equal(lines["Hopf point"].get_xdata(), exact)
    assert "Hopf point" not in [line.get_label() for line in smooth.lines]
    assert r"$\mu = 0.1$" in rubbing.get_title()


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


def test_a_diagram_over_the_speed_shows_every_extremum_above_the_curve_too():
    found = bifurcation_diagram(
        omega=[1.9, 2.0], zeta=0.07, delta0=2.0, starts=[(2.6, 0.75, 0.66, -1.65)], workers=1,
        extrema_time=20.0, method="taylor",
    )  # fmt: skip
    (ax,) = figure_of(found).axes
    assert "contact-free whirl" in [line.get_label() for line in ax.lines]
    assert ax.get_ylim()[0] == 0.0
    assert ax.get_ylim()[1] > found.extremum_radius.max() > 3.0  # the whirl's is about 1
    assert ax.get_xlim() == pytest.approx((1.897, 2.003))


def test_a_diagram_has_a_figure_over_one_parameter():
    given = {"omega": 1.2, "zeta": 0.5, "starts": [(0, 0, 0, 0)], "workers": 1}
    found = bifurcation_diagram(**given, delta0=[0.25, 0.5], shaft_stiffness=[0.0, 0.1])
    with pytest.raises(InputError, match="one parameter that varies, got delta0 and shaft_stiff"):
        figure_of(found)
    (ax,) = figure_of(bifurcation_diagram(**given, delta0=[0.25, 0.5])).axes
    assert ax.get_xlabel().startswith("clearance")


def test_fractions_have_a_figure_over_the_speed_or_of_one_rotor():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    found = basin_fractions(rotor, x=(-15, 15), y=(-15, 15), starts=20)
    (ax,) = figure_of(found).axes
    assert ax.get_xlabel() == "fraction of starts"
    other = found.assign_coords(omega=1.9)
    both = xr.concat([found[["response_fraction"]], other[["response_fraction"]]], dim="omega")
    (ax,) = figure_of(both).axes
    assert ax.get_ylabel() == "fraction of starts"


def test_backward_whirls_are_described_and_drawn():
    rotor = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    whirls = backward_whirl(rotor)
    record, _ = describe(whirls)
    assert record["kind"] == "backward_whirl"
    assert [row["kind"] for row in record["whirls"]] == ["slipping", "rolling"]
    assert record["parameters"] == rotor.given
    (ax,) = figure_of(whirls).axes
    assert len(ax.lines) == 3
    record, _ = describe(hopf_points(zeta=0.07, delta0=0.5, friction=[0.0, 0.1]))
    assert [row["friction"] for row in record["hopf_points"]] == [0.1, 0.1]


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
