import numpy as np
import pytest

from rotor_ida import InputError, folds
from rotor_ida.closed_forms import clearance_curve, peaks, response_curve
from rotor_ida.plot import plot_by_clearance, plot_over_clearance


@pytest.fixture(scope="module")
def whirls():
    return clearance_curve(omega=1.2, zeta=0.07, limits=(0.0, 3.0))


def test_every_whirl_is_on_a_line_of_its_stability(whirls):
    ax = plot_over_clearance(whirls)
    lines = {}
    for line in ax.lines:
        lines.setdefault(line.get_label(), []).append(line.get_ydata())
    assert set(lines) == {"stable whirl", "unstable whirl", "contact-free whirl"}
    unstable = whirls.amplitude.where(whirls.stability == 1).values
    assert np.isin(unstable[np.isfinite(unstable)], np.concatenate(lines["unstable whirl"])).all()


def test_responses_off_the_whirls_are_bars(whirls, simulated):
    here = simulated.isel(omega=slice(0, 3), direction=[0])
    moved = here.assign_coords(omega=[1.2, 1.2, 1.2])
    ax = plot_over_clearance(whirls, simulated=moved)
    (bars,) = ax.collections
    np.testing.assert_allclose(bars.get_segments()[0][:, 1], [0.2, 2.2])
    marks = [line for line in ax.lines if line.get_marker() == "o"]
    assert {line.get_label() for line in marks} == {"synchronous response", "contact-free response"}
    assert bars.get_label() == "bouncing: range of $|z|$"


def test_quantities_with_a_further_dimension_are_points():
    delta0 = [0.0, 0.5, 1.0]
    table = peaks(zeta=0.07, delta0=delta0).merge(folds(zeta=0.07, delta0=delta0))
    ax = plot_by_clearance(table, {"peak_omega": "peak", "fold_omega": "folds"}, label="speed")
    peak, points = ax.lines
    np.testing.assert_array_equal(peak.get_ydata(), table.peak_omega.values.ravel())
    assert points.get_linestyle() == "None"
    assert np.isfinite(points.get_ydata()).sum() == 2 + 4 + 2
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["peak", "folds"]


def test_what_cannot_be_drawn_is_refused(whirls):
    with pytest.raises(InputError, match="exact must hold one omega, got"):
        plot_over_clearance(response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0)))
    several = clearance_curve(omega=[1.2, 1.3], zeta=0.07, limits=(0.0, 1.0))
    with pytest.raises(InputError, match="exact must hold one omega, got 2"):
        plot_over_clearance(several)
    with pytest.raises(InputError, match="table must hold"):
        plot_by_clearance(whirls, {"peak": "peak"}, label="")
