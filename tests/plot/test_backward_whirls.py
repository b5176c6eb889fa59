"""Backward whirls are circles in the clearance."""

import numpy as np
import pytest

from rotor_ida import Rotor, backward_whirl
from rotor_ida.plot import plot_backward_whirl

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
