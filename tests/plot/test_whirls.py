import numpy as np
import pytest

from rotor_ida import InputError, Rotor, backward_whirl, folds
from rotor_ida.closed_forms import cusp, free_periods, jumps, peaks, response_curve
from rotor_ida.plot import (
    plot_amplitude,
    plot_backbone,
    plot_backward_whirl,
    plot_by_clearance,
    plot_by_damping,
    plot_cusp,
    plot_jumps,
)
from tests.plot.pictures import words_of


def test_an_arrow_leads_from_each_fold_to_its_landing():
    found = jumps(zeta=0.07, delta0=0.0)
    ax = plot_amplitude(response_curve(zeta=0.07, delta0=0.0, limits=(0.05, 3.0)))
    plot_jumps(found, ax=ax)
    for arrow, omega, begin, end in zip(
        ax.texts, *(found[name].values.ravel() for name in
                    ("fold_omega", "fold_amplitude", "landing_amplitude")), strict=True
    ):  # fmt: skip
        assert arrow.xy == (omega, end)
        assert arrow.xyann == (omega, begin)
    assert "jump" in words_of(ax)


def test_backbone_runs_where_free_whirls_do():
    ax = plot_backbone(free_periods(amplitude=[4.0, 16.0], delta0=0.0))
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [4.0**0.25, 2.0])


def test_each_damping_has_a_line_of_its_own():
    exact = response_curve(zeta=[1.0, 2.0], delta0=0.0, limits=(0.05, 3.0))
    ax = plot_by_damping(exact, "phase_lag")
    assert len({repr(line._unscaled_dash_pattern) for line in ax.lines}) == 2
    expected = exact.phase_lag.sel(zeta=1.0).dropna("point").values.ravel()
    np.testing.assert_array_equal(ax.lines[0].get_ydata()[: expected.size], expected)


def test_cusp_is_drawn_over_the_clearance_and_its_top_marked():
    limit, highest = cusp(delta0=np.linspace(0.0, 2.0, 21)), cusp()
    ax = plot_cusp(limit, highest=highest)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), limit.cusp_zeta)
    assert ax.lines[1].get_ydata()[0] == highest.cusp_zeta.item()
    assert "no jumps" in [text.get_text() for text in ax.texts]


def test_other_datasets_are_refused():
    limit = cusp(delta0=[0.0, 1.0])
    with pytest.raises(InputError, match="jumps must contain"):
        plot_jumps(limit, ax=plot_cusp(limit))
    with pytest.raises(InputError, match="curve must contain one delta0, got 2"):
        plot_backbone(free_periods(amplitude=[4.0], delta0=[0.0, 1.0]))
    with pytest.raises(InputError, match="table must contain"):
        plot_by_clearance(limit, {"peak": "peak"}, label="")


def test_quantities_with_a_further_dimension_are_points():
    delta0 = [0.0, 0.5, 1.0]
    table = peaks(zeta=0.07, delta0=delta0).merge(folds(zeta=0.07, delta0=delta0))
    ax = plot_by_clearance(table, {"peak_omega": "peak", "fold_omega": "folds"}, label="speed")
    peak, points = ax.lines
    np.testing.assert_array_equal(peak.get_ydata(), table.peak_omega.values.ravel())
    assert points.get_linestyle() == "None"
    assert np.isfinite(points.get_ydata()).sum() == 2 + 4 + 2
    assert words_of(ax) == ["peak", "folds"]


MACHINE = {"zeta": 0.02, "delta0": 1.0, "shaft_stiffness": 0.04, "contact_exponent": 1.0,
           "friction": 0.2, "disc_radius": 10.0}  # fmt: skip


def test_both_whirls_are_circles_of_their_radii_told_by_line_and_words():
    whirls = backward_whirl(Rotor(omega=0.5, **MACHINE))
    ax = plot_backward_whirl(whirls)
    ring, slipping, rolling = ax.lines
    radii = [np.hypot(*line.get_data()) for line in (ring, slipping, rolling)]
    np.testing.assert_allclose([each.max() for each in radii], [1.0, *whirls.amplitude.values])
    np.testing.assert_allclose([each.min() for each in radii], [1.0, *whirls.amplitude.values])
    assert slipping.get_label().startswith("slipping whirl: unstable")
    assert rolling.get_label().startswith("dry whip: stable")
    assert slipping.get_linestyle() != rolling.get_linestyle()
    assert ax.get_xlim()[1] > whirls.amplitude.values.max()
    assert r"$\rho = 10$" in ax.get_title()
    # both go backwards: with y up, clockwise
    for arrow in ax.texts:
        (x, y), (to_x, to_y) = arrow.xyann, arrow.xy
        assert x * to_y - y * to_x < 0.0


@pytest.mark.parametrize(
    ("changes", "told"),
    [({"omega": 0.01}, r"no dry whip below $\omega = 0.0346$"),
     ({"omega": 0.5, "friction": 0.01, "zeta": 0.2}, "no dry whip at any speed")],
)  # fmt: skip
def test_where_there_is_no_whirl_it_is_said_why(changes, told):
    ax = plot_backward_whirl(backward_whirl(Rotor(**MACHINE | changes)))
    assert [text.get_text() for text in ax.texts] == [told]
    assert len(ax.lines) == 1


def test_circles_too_small_to_be_seen_are_drawn_once_more_enlarged():
    wide = Rotor(omega=0.24, zeta=0.006, delta0=9.0, shaft_stiffness=0.04, contact_exponent=1.0,
                 friction=0.12, disc_radius=3590.0)  # fmt: skip
    whirls = backward_whirl(wide)
    ax = plot_backward_whirl(whirls)
    (inset,) = ax.child_axes
    (_, slipping, _) = (line.get_xdata().max() for line in inset.lines)
    assert slipping == pytest.approx(whirls.amplitude[0].item())
    assert inset.get_xlim()[1] == pytest.approx(1.1 * slipping)
    assert not plot_backward_whirl(backward_whirl(Rotor(omega=0.5, **MACHINE))).child_axes


def test_without_damping_there_is_whip_alone():
    (_, whip) = plot_backward_whirl(
        backward_whirl(Rotor(omega=0.5, **MACHINE | {"zeta": 0.0}))
    ).lines
    assert whip.get_label().startswith("dry whip: neutral")
