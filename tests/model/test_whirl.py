"""The sense of a whirl and its speed over the spin speed are those of the motion, everywhere."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    InputError,
    Rotor,
    backward_whirl,
    limit_cycle,
    simulate,
    touchdown_report,
    whirl_ratio,
)
from rotor_ida.model.whirl import ALONG_A_LINE, whirl_over_spin
from rotor_ida.schema import WHIRL_DIRECTION, labelled, words_of

FORWARD, BACKWARD, NONE = (WHIRL_DIRECTION[word] for word in ("forward", "backward", "none"))
PER_REVOLUTION, REVOLUTIONS = 40, 30
ANGLE = 2.0 * math.pi * np.arange(PER_REVOLUTION * REVOLUTIONS) / PER_REVOLUTION
# A forward rub of a pump at 5400 rpm, whose strongest line beside 1X is a backward one.
PUMP = Rotor(omega=0.19589, zeta=0.006, delta0=8.976, shaft_stiffness=0.04, contact_exponent=1.0,
             friction=0.12, disc_radius=3590.4)  # fmt: skip
RUBBING = {"zeta": 0.04, "delta0": 2.0, "shaft_stiffness": 0.04, "contact_exponent": 1.0,
           "friction": 0.1, "disc_radius": 20.0}  # fmt: skip


def signals(z, angle=ANGLE):
    columns = {"x": z.real, "y": z.imag, "angle": angle}
    return xr.Dataset(
        {name: labelled(name, "t", column) for name, column in columns.items()},
        {"t": labelled("t", "t", angle / 1.5)},
    )


def ended(rotor, start, revolutions=200, kept=100):
    """Return the last revolutions of a run, as signals see it."""
    run = simulate(
        rotor, start=start, duration=revolutions * 2.0 * math.pi / rotor.omega, method="taylor"
    )
    after = (1.0 - kept / revolutions) * float(run.t[-1])
    return run.sel(t=slice(after, None))


def noise(seed, size=ANGLE.size):
    source = np.random.default_rng(seed)
    return source.standard_normal(size) + 1j * source.standard_normal(size)


# ---- A vibration along a line ----


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("direction", [1.0, 1j, np.exp(0.7j)])
def test_a_vibration_along_a_line_has_no_sense_whatever_the_noise(size, seed, direction):
    z = direction * (np.cos(ANGLE + 0.1 * seed) + 0.3 * np.cos(2.0 * ANGLE)) + size * noise(seed)
    found = whirl_ratio(signals(z))
    assert (found.whirl_sense == NONE).all()
    assert (found.whirl_over_spin == 0.0).all()


@pytest.mark.parametrize("minor", [0.2, 0.1])
@pytest.mark.parametrize("sense", [FORWARD, BACKWARD])
@pytest.mark.parametrize("seed", range(3))
def test_an_ellipse_with_a_minor_axis_above_a_twentieth_has_a_sense(minor, sense, seed):
    z = np.cos(ANGLE) + 1j * sense * minor * np.sin(ANGLE) + 5.0 + 1e-3 * noise(seed)
    found = whirl_ratio(signals(z))
    assert (found.whirl_sense == sense).all()
    np.testing.assert_allclose(found.whirl_over_spin[:-1], sense, rtol=2e-4 / minor)


def test_the_threshold_is_the_minor_axis_over_the_major_one():
    axes = np.array([0.9, 1.1]) * ALONG_A_LINE
    forward, backward = 0.5 * (1.0 + axes), 0.5 * (1.0 - axes)
    _, sense = whirl_over_spin(2.0 * math.pi, 2.0 * math.pi, forward, backward)
    assert sense.tolist() == [NONE, FORWARD]


def test_a_whirl_that_turns_against_its_larger_lines_has_no_sense():
    ratio, sense = whirl_over_spin(-3.0, 6.0, 1.0, 0.5)
    assert (ratio, sense) == (0.0, NONE)


# ---- Whirls that are known ----


@pytest.mark.parametrize("order", [1.0, 0.5, -0.5, -2.0, -3.3])
def test_the_ratio_of_one_whirl_is_its_order(order):
    found = whirl_ratio(signals(np.exp(1j * order * ANGLE) + 2.0j), revolutions=2)
    inside = found.isel(window=slice(2, -2))
    np.testing.assert_allclose(inside.whirl_over_spin, order, rtol=0.06)
    assert (inside.whirl_sense == np.sign(order)).all()


def test_a_forward_rub_with_backward_lines_is_forward():
    found = whirl_ratio(signals(np.exp(1j * ANGLE) + 0.4 * np.exp(-1.313j * ANGLE)), revolutions=3)
    assert (found.whirl_sense == FORWARD).all()
    assert float(found.whirl_over_spin.mean()) == pytest.approx(1.0, abs=0.02)


def test_a_whirl_whose_steps_are_too_long_is_refused():
    with pytest.raises(
        InputError, match=r"more than 3 samples in each turn of the whirl, got 2\.67"
    ):
        whirl_ratio(signals(np.exp(-15j * ANGLE)))


# ---- Signals, limit cycles and reports agree ----


def test_a_forward_synchronous_rub_is_forward_at_the_spin_speed():
    cycle = limit_cycle(PUMP, start=(8.0, 0.0, 0.0, 1.5))
    assert words_of(cycle.response)[0] == "bouncing"
    assert float(cycle.side_line_over_spin) == pytest.approx(-1.313, abs=0.01)
    report = touchdown_report(PUMP, x=(-9, 9), y=(-9, 9), starts=20, shocks=0)
    row = report.isel(attractor=words_of(report.kind).index("bouncing"))
    seen = whirl_ratio(ended(PUMP, (8.0, 0.0, 0.0, 1.5)), revolutions=10)
    for each in (cycle, row):
        assert float(each.whirl_over_spin) == pytest.approx(1.0, abs=1e-9)
        assert int(each.whirl_sense) == FORWARD
    assert (seen.whirl_sense == FORWARD).all()
    np.testing.assert_allclose(seen.whirl_over_spin, 1.0, atol=0.03)


def test_dry_whip_is_backward_at_the_speed_of_its_roll():
    rotor = Rotor(omega=0.5, **RUBBING)
    whip = backward_whirl(rotor).isel(whirl=-1)
    rolls = float(whip.whirl_speed) / rotor.omega
    assert rolls < -1.0
    start = (float(whip.amplitude), 0.0, 0.0, float(whip.amplitude * whip.whirl_speed))
    seen = whirl_ratio(ended(rotor, start), revolutions=10)
    assert (seen.whirl_sense == BACKWARD).all()
    np.testing.assert_allclose(seen.whirl_over_spin.mean(), rolls, rtol=0.02)
    report = touchdown_report(rotor, x=(-30, 30), y=(-30, 30), vx=(-20, 20), vy=(-20, 20),
                              starts=60, shocks=0)  # fmt: skip
    row = report.isel(attractor=words_of(report.kind).index("rolling"))
    assert int(row.whirl_sense) == BACKWARD
    assert float(row.whirl_over_spin) == pytest.approx(rolls, rel=0.02)


def test_a_slipping_backward_whirl_is_backward():
    """A saddle, held by friction alone: it is looked at before it is left."""
    rotor = Rotor(omega=0.5, **RUBBING)
    slips = backward_whirl(rotor).isel(whirl=0)
    size, speed = float(slips.amplitude), float(slips.whirl_speed)
    run = simulate(rotor, start=(size, 0.0, 0.0, size * speed), method="taylor",
                   duration=10.0 * math.pi / rotor.omega)  # fmt: skip
    seen = whirl_ratio(run)
    assert (seen.whirl_sense[:3] == BACKWARD).all()
    np.testing.assert_allclose(seen.whirl_over_spin[:3], speed / rotor.omega, rtol=0.2)


def test_a_cycle_of_half_the_order_is_forward_at_the_spin_speed():
    """Under a load the strongest line beside 1X lies at a half: the rotor whirls at 1X."""
    cycle = limit_cycle(Rotor(omega=0.8, load=0.06, **RUBBING), start=(0, -1, 0, 0))
    assert float(cycle.side_line_over_spin) == pytest.approx(0.5, abs=1e-9)
    assert float(cycle.whirl_over_spin) == pytest.approx(1.0, abs=1e-9)
    assert int(cycle.whirl_sense) == FORWARD


def test_no_cycle_has_no_whirl():
    none = limit_cycle(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0))
    assert math.isnan(float(none.whirl_over_spin))
    assert int(none.whirl_sense) == NONE
