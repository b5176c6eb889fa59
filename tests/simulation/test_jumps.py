"""Small differences jump where friction does: the saltation matrices of rolling and reversing.

Witnesses: neighbours that are followed themselves; the volume that sliding leaves; and multipliers
of limit cycles, of which the logarithms are exponents.
"""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor, backward_whirl, limit_cycle, lyapunov_exponent, simulate
from rotor_ida.core.interface import DONE
from rotor_ida.core.runs import COLUMNS, DIFFERENCES, RunRequest, follow_run
from rotor_ida.schema.flags import ENTRY, EXIT, PRESS, RELEASE, REVERSE, ROLL, SLIP
from tests.rotors import WHIP

MACHINE = Rotor(
    omega=0.4, zeta=0.08, delta0=0.6, shaft_stiffness=0.3, contact_damping=0.6, friction=0.4,
    disc_radius=1.4, load=0.2,
)  # fmt: skip
REVERSING = Rotor(
    omega=0.7, zeta=0.08, delta0=0.8, shaft_stiffness=0.3, friction=0.2, disc_radius=2.7, load=0.2
)
LINEAR = Rotor(
    omega=0.4, zeta=0.08, delta0=0.5, shaft_stiffness=0.3, contact_exponent=1.0, friction=0.8,
    disc_radius=0.7,
)  # fmt: skip
# Rotor, start, and what happens on the way, in time 8.
RUNS = [
    (MACHINE, (-1.6, -1.7, 0.9, 1.1), [RELEASE, PRESS, EXIT, ENTRY, ROLL, SLIP, EXIT, ENTRY,
                                       REVERSE, ROLL]),
    (REVERSING, (0.2, 1.8, 1.1, -1.4), [*4 * [REVERSE], EXIT, ENTRY]),
    (LINEAR, (0.5, 0.5, -0.3, 1.2), [ROLL, SLIP, EXIT, ENTRY, ROLL, SLIP, EXIT, ENTRY, REVERSE]),
]  # fmt: skip
DURATION = 8.0
STEP = 1e-5


def followed(rotor, start, duration, bundle=None, method="taylor", rtol=1e-15):
    seen = follow_run(
        RunRequest(
            rotor=rotor, start=tuple(start), duration=duration, rtol=rtol, atol=1e-2 * rtol,
            events=True, bundle=bundle, method=method, whole=True,
        )
    )  # fmt: skip
    assert seen.status == DONE
    return seen


def slope(function, step=STEP):
    """Derivative at 0 by differences, to the fourth power of the step."""
    near = np.asarray(function(step)) - np.asarray(function(-step))
    far = np.asarray(function(2.0 * step)) - np.asarray(function(-2.0 * step))
    return (8.0 * near - far) / (12.0 * step)


@pytest.mark.parametrize(("rotor", "start", "expected"), RUNS)
def test_differences_are_those_of_neighbours(rotor, start, expected):
    """By start and by every parameter, across roll, slip, reverse, entry, exit and release."""
    bundle = np.eye(DIFFERENCES + len(COLUMNS), 4)
    seen = followed(rotor, start, DURATION, bundle)
    assert seen.event_kinds.tolist() == expected
    for row, direction in zip(bundle, np.eye(4), strict=False):
        apart = slope(
            lambda by, direction=direction: (
                followed(rotor, np.array(start) + by * direction, DURATION).state
            )
        )
        np.testing.assert_allclose(row, apart, rtol=0.0, atol=1e-7 * np.abs(bundle).max())
    for row, name in zip(bundle[DIFFERENCES:], COLUMNS, strict=True):
        value = getattr(rotor, name)
        if value == 0.0:
            continue
        apart = slope(
            lambda by, name=name, value=value: (
                followed(replace(rotor, **{name: value + by}), start, DURATION).state
            )
        )
        np.testing.assert_allclose(
            row, apart, rtol=0.0, atol=1e-7 * np.abs(row).max(), err_msg=name
        )


@pytest.mark.parametrize("method", ["adams", "bdf"])
@pytest.mark.parametrize(("rotor", "start", "expected"), RUNS)
def test_cvode_is_a_second_witness_of_the_jumps(method, rotor, start, expected):
    by_taylor, by_cvode = np.eye(4), np.eye(4)
    followed(rotor, start, DURATION, by_taylor)
    seen = followed(rotor, start, DURATION, by_cvode, method, rtol=1e-11)
    assert seen.event_kinds.tolist() == expected
    size = np.abs(by_taylor).max()
    np.testing.assert_allclose(by_cvode, by_taylor, rtol=0.0, atol=1e-6 * size)


def test_a_reversal_leaves_its_part_of_the_volume():
    """Sliding friction hangs on no velocity: volumes shrink like ``exp(-4 zeta t)``, and at each
    reversal to the part ``(|F| - mu N)/(|F| + mu N)``, F and N as the run itself has them."""
    rotor, start, _ = RUNS[1]
    bundle = np.eye(4)
    seen = followed(rotor, start, DURATION, bundle)
    times = seen.event_times[seen.event_kinds == REVERSE]
    left = 1.0
    for time, (x, y, vx, vy) in zip(
        times, seen.event_states[seen.event_kinds == REVERSE], strict=True
    ):
        radius = np.hypot(x, y)
        normal = (radius - rotor.delta0) ** 1.5
        rise = (x * vx + y * vy) / radius
        turned = rotor.omega * time  # on the rotating axes the load points there
        hold = -(rotor.omega**2) * y / radius
        hold -= rotor.load * (x * np.cos(turned) - y * np.sin(turned)) / radius
        hold += rotor.disc_radius * rotor.omega * (2.0 * rotor.zeta + rise / radius)
        grip = rotor.friction * normal
        left *= (abs(hold) - grip) / (abs(hold) + grip)
    expected = left * np.exp(-4.0 * rotor.zeta * DURATION)
    assert np.linalg.det(bundle) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_exponents_of_a_whip_are_the_logarithms_of_its_multipliers(method):
    """It rolls and slips for ever: a multiplier is 0, and an exponent minus infinity."""
    amplitude = float(backward_whirl(WHIP).amplitude[-1])
    start = (amplitude, 0.0, 0.0, -WHIP.disc_radius * WHIP.omega)
    cycle = limit_cycle(WHIP, start=start)
    sizes = np.hypot(cycle.multiplier_real.values, cycle.multiplier_imag.values)
    assert sizes[3] == 0.0
    found = lyapunov_exponent(
        WHIP, start=start, transient=200.0, duration=400.0, method=method, rtol=1e-10
    )
    expected = np.log(sizes[:3]) / cycle.period.item()
    np.testing.assert_allclose(found.lyapunov_exponent[:3], expected, rtol=0.0, atol=2e-4)
    assert found.lyapunov_exponent[3] == -np.inf
    assert found.lyapunov_error[3] == 0.0
    assert found.exponent_sum == found.divergence == -np.inf


def test_exponents_add_up_with_the_reversals():
    """Without rolling their sum is what damping and reversals leave of a volume, by the run."""
    rotor = Rotor(
        omega=1.3, zeta=0.06, delta0=0.6, shaft_stiffness=0.2, friction=0.05, disc_radius=0.4
    )
    found = lyapunov_exponent(rotor, start=(1.5, 0.2, 0.0, -2.0), transient=50.0, duration=400.0)
    assert found.exponent_sum == pytest.approx(found.divergence.item(), abs=1e-9)
    run = simulate(rotor, start=(1.5, 0.2, 0.0, -2.0), duration=450.0, samples=2, method="taylor")
    late = run.event_time > 50.0
    reverses = bool(((run.event_kind == REVERSE) & late).any())
    assert (found.divergence < -4.0 * rotor.zeta) == reverses
