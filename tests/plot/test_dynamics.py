"""Pictures of what no response curve shows."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, bifurcation_diagram, lyapunov_exponent, poincare_section
from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import plot_exponents, plot_extrema, plot_section
from tests.plot.pictures import lines_of

REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.mark.parametrize("revolutions", [10, 20])
def test_entries_are_drawn_as_radial_velocity_over_the_angle(revolutions):
    """Also on both sides of half a turn, where the angle alone would part them."""
    section = poincare_section(BOUNCING, start=REST, revolutions=revolutions, at="entry")
    angle, velocity = plot_section(section).lines[0].get_data()
    assert (velocity > 0.0).all()
    z = section.rotating_x.values + 1j * section.rotating_y.values
    np.testing.assert_allclose(2.0 * np.exp(1j * angle), z, atol=1e-12)
    assert revolutions == 10 or np.ptp(angle) < np.ptp(np.angle(z))


def test_a_section_shows_the_ring_and_says_what_it_is():
    ax = plot_section(poincare_section(BOUNCING, start=REST, revolutions=5))
    np.testing.assert_allclose(np.hypot(*lines_of(ax)["clearance"].get_data()), 2.0)
    title = "$\\omega = 2$,  $\\zeta = 0.07$,  $\\delta_0 = 2$\nonce a revolution"
    assert ax.get_title() == title
    loaded = Rotor(omega=1.7, zeta=0.07, delta0=0.5, load=0.1)
    section = poincare_section(loaded, start=REST, revolutions=9, phase=0.5 * np.pi)
    assert plot_section(section).get_title().endswith("\nunbalance at 90°")
    free = poincare_section(
        Rotor(omega=1.0, zeta=0.5, delta0=9.0), start=REST, revolutions=5, at="exit"
    )
    assert [text.get_text() for text in plot_section(free).texts] == ["no crossing"]


def test_points_that_fall_together_are_counted_and_not_blown_up():
    section = poincare_section(BOUNCING, start=REST, revolutions=20, skip=150, at="entry")
    ax = plot_section(section)
    assert ax.get_title().endswith(" crossings, 1 point")
    low, high = ax.get_xlim()
    assert high - low > 0.1


def test_extrema_of_unresolved_motion_are_not_told_as_lasting():
    found = bifurcation_diagram(omega=[1.2, 2.0], zeta=0.07, delta0=2.0, starts=[REST])
    unresolved = found.assign(response=found.response * 0)
    unresolved.response.attrs = found.response.attrs
    words = plot_extrema(unresolved).get_legend_handles_labels()[1]
    assert words == ["extremum, free or unresolved", "clearance"]


def test_exponents_are_named_with_value_and_error():
    found = lyapunov_exponent(BOUNCING, start=REST)
    ax = plot_exponents(found)
    words = ax.get_legend_handles_labels()[1]
    assert words[0] == r"$\lambda_1 = 0.00000$"
    assert words[1].startswith(r"$\lambda_2 = -0.0700")


def test_extrema_lie_over_the_exact_curve_of_their_clearance():
    found = bifurcation_diagram(omega=[1.2, 2.0], zeta=0.07, delta0=[0.5, 2.0], starts=[REST])
    exact = response_curve(zeta=0.07, delta0=2.0, limits=(0.5, 2.5))
    ax = plot_extrema(found, exact=exact)
    words = ax.get_legend_handles_labels()[1]
    assert "local maximum of $|z|$" in words
    assert "stable whirl" in words
    heights = np.concatenate([line.get_ydata() for line in ax.lines if line.get_rasterized()])
    shown = found.extremum_radius.values[int(found.extremum_count[0, 0, 0, 0]) :]
    assert set(heights) <= set(shown)
    with pytest.raises(InputError, match="found must contain the delta0 of exact"):
        plot_extrema(found.sel(delta0=[0.5]), exact=exact)
    with pytest.raises(InputError, match="found must contain one delta0, got 2"):
        plot_extrema(found)


def test_extrema_are_drawn_over_whatever_varies():
    machine = {"omega": 2.0, "zeta": 0.2, "delta0": 1.0, "starts": [(0, 0, 0, 0)]}
    for name, label in (("load", r"load $\gamma$"), ("contact_damping", "contact damping $c$")):
        found = bifurcation_diagram(**machine, **{name: [0.1, 0.3]}, method="taylor")
        ax = plot_extrema(found)
        assert ax.get_xlabel() == label
        assert ax.get_title() == r"$\omega = 2$,  $\zeta = 0.2$,  $\delta_0 = 1$"
        across = np.concatenate([each.get_xdata() for each in ax.lines])
        assert set(across) == {0.1, 0.3}
    both = {**machine, "delta0": [0.5, 1.0], "load": [0.1, 0.3]}
    found = bifurcation_diagram(**both, method="taylor")
    with pytest.raises(InputError, match="found must contain one load, got 2"):
        plot_extrema(found)


def test_extrema_of_another_machine_than_the_curve_are_refused():
    found = bifurcation_diagram(
        omega=[1.0, 1.2], zeta=0.2, delta0=1.0, shaft_stiffness=0.25, starts=[(0, 0, 0, 0)]
    )
    exact = response_curve(zeta=0.2, delta0=1.0, limits=(0.5, 2.0))
    message = "found must have the shaft_stiffness of exact, 0.0, got 0.25"
    with pytest.raises(InputError, match=message):
        plot_extrema(found, exact=exact)


def test_exponents_of_several_points_are_drawn_over_the_parameter_that_varies():
    given = {"transient": 50.0, "duration": 200.0, "batches": 4}
    found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.1, delta0=0.5), zeta=[0.1, 0.2], **given)
    ax = plot_exponents(found)
    assert ax.get_xlabel() == r"damping ratio $\zeta$"
    lines = [each.lines[0] for each in ax.containers]
    for number, line in enumerate(lines):
        exponents = found.lyapunov_exponent.isel(exponent=number).values
        np.testing.assert_array_equal(line.get_xydata(), np.stack([[0.1, 0.2], exponents], axis=1))
    assert len(lines) == 4
    two = lyapunov_exponent(
        Rotor(omega=1.7, zeta=0.1, delta0=0.5), zeta=[0.1, 0.2], delta0=[0.5, 1.0], **given
    )
    with pytest.raises(InputError, match="found must contain one zeta, got 2"):
        plot_exponents(two.transpose("delta0", "zeta", ...))
