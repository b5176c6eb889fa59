"""Limit cycles and branches under a load, which stands still where the axes turn."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    bifurcation_curve,
    continue_cycle,
    limit_cycle,
    lyapunov_exponent,
    poincare_section,
)
from rotor_ida.errors import InputError
from rotor_ida.schema import LINE_KIND, RESPONSE, SPECIAL
from tests.witness import machine_flown

# A heavy rotor that stays in contact, one revolution a period; one that bounces, two of them.
LYING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=1.0)
BOUNCING = Rotor(
    omega=1.6, zeta=0.07, delta0=2.0, load=0.5, contact_damping=0.3, shaft_stiffness=0.2
)


def state_of(cycle, prefix=""):
    return np.array([cycle[f"{prefix}{name}"].values.flat[0] for name in ("x", "y", "vx", "vy")])


def multipliers(cycle):
    return cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values


def revolutions(rotor, period):
    return period * rotor.omega / (2.0 * math.pi)


@pytest.fixture(scope="module")
def cycles():
    return {rotor: limit_cycle(rotor, start=(0, 0, 0, 0)) for rotor in (LYING, BOUNCING)}


@pytest.mark.parametrize(
    ("rotor", "times", "kind"), [(LYING, 1, "full_contact"), (BOUNCING, 2, "bouncing")]
)
def test_a_motion_repeats_itself_after_whole_revolutions(cycles, rotor, times, kind):
    """Held against DOP853 on fixed axes, with events and the variational equation."""
    cycle = cycles[rotor]
    assert cycle.response.item() == RESPONSE[kind]
    assert revolutions(rotor, cycle.period.item()) == pytest.approx(times, abs=1e-14)
    state = state_of(cycle)
    flown = machine_flown(rotor, state, cycle.period.item())
    np.testing.assert_allclose(flown.end, state, rtol=0.0, atol=1e-9)
    assert flown.crossings.size == 2 * cycle.contact_count.item()
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(flown.monodromy)),
        np.sort_complex(multipliers(cycle)), rtol=0.0, atol=1e-7,
    )  # fmt: skip
    assert np.isnan(cycle.trivial_defect)
    assert cycle.multiplier_error.values.max() < 1e-11


def test_without_contact_damping_phase_space_shrinks_at_the_rate_of_damping(cycles):
    """All four multipliers count: their product is det M = exp(-4 zeta T), in two pairs."""
    cycle = cycles[LYING]
    found, q = multipliers(cycle), math.exp(-2.0 * LYING.zeta * cycle.period.item())
    assert np.prod(found).real == pytest.approx(q * q, rel=1e-13)
    for each in found:
        assert np.abs(found - q / each).min() < 1e-12
    assert cycle.symplectic_defect.item() < 1e-14
    # with it they shrink more
    damped = np.prod(multipliers(cycles[BOUNCING])).real
    assert damped < 0.9 * math.exp(-4.0 * BOUNCING.zeta * cycles[BOUNCING].period.item())


def test_the_static_deflection_is_a_line_that_stands_still(cycles):
    """Its height is the mean on fixed axes; balance of forces of one period gives it, too."""
    cycle = cycles[BOUNCING]
    static = cycle.line_kind.values == LINE_KIND["static"]
    assert cycle.frequency.values[static].tolist() == [0.0]
    angle = BOUNCING.omega * cycle.t.values
    z = (cycle.x.values + 1j * cycle.y.values) * np.exp(1j * angle)
    assert cycle.whirl_amplitude.values[static][0] == pytest.approx(abs(z[:-1].mean()), rel=1e-12)


def test_a_given_period_is_of_whole_revolutions(cycles):
    cycle = cycles[BOUNCING]
    again = limit_cycle(BOUNCING, start=state_of(cycle), period=2.0 * cycle.period.item())
    assert again.period.item() == pytest.approx(cycle.period.item(), rel=1e-14)
    revolution = 2.0 * math.pi / BOUNCING.omega
    with pytest.raises(InputError, match="period must be a whole number of revolutions"):
        limit_cycle(BOUNCING, start=state_of(cycle), period=1.4 * revolution)


def test_chaos_under_a_load_is_told():
    """Bouncing on a soft ring: neighbours part, and the motion never comes again."""
    machine = Rotor(
        omega=1.1, zeta=0.1, delta0=4.0, contact_exponent=1.0, contact_damping=0.1, load=0.04
    )
    found = limit_cycle(machine, start=(0.0, -0.5, 0.0, 0.0))
    assert found.response.item() == RESPONSE["chaotic"]
    exponent = lyapunov_exponent(machine, start=(0.0, -0.5, 0.0, 0.0), duration=3000.0)
    assert exponent.lyapunov_exponent[0] > 5.0 * exponent.lyapunov_error[0]


def test_a_motion_may_repeat_itself_after_forty_revolutions_only():
    """No window of a sweep shows so many; a section of its own tells that it takes no fewer."""
    machine = Rotor(
        omega=1.67, zeta=0.041, delta0=1.0, shaft_stiffness=1.0, contact_exponent=1.0,
        contact_damping=1.0, load=1.09,
    )  # fmt: skip
    cycle = limit_cycle(machine, start=(0.0, -0.5, 0.0, 0.0))
    assert revolutions(machine, cycle.period.item()) == pytest.approx(40.0, abs=1e-10)
    section = poincare_section(machine, start=state_of(cycle), revolutions=40)
    seen = np.stack([section[f"rotating_{name}"] for name in ("x", "y", "vx", "vy")], axis=1)
    misses = np.abs(seen[1:] - seen[0]).max(axis=1)
    assert misses[-1] < 1e-7
    assert misses[:-1].min() > 1e-3


def test_a_whirl_inside_the_clearance_is_none():
    machine = Rotor(omega=0.5, zeta=0.1, delta0=5.0, load=0.3, shaft_stiffness=1.0)
    found = limit_cycle(machine, start=(0, 0, 0, 0))
    assert found.response.item() == RESPONSE["contact_free"]
    assert np.isnan(found.period)


@pytest.mark.parametrize(
    ("parameter", "limits"),
    [("omega", (1.1, 1.3)), ("zeta", (0.06, 0.09)), ("delta0", (0.4, 0.6)),
     ("shaft_stiffness", (0.0, 0.2)), ("contact_damping", (0.0, 0.3)), ("load", (0.8, 1.2))],
)  # fmt: skip
def test_a_branch_runs_over_any_parameter(cycles, parameter, limits):
    """At both ends it is the cycle that DOP853 closes there."""
    branch = continue_cycle(LYING, start=cycles[LYING], parameter=parameter, limits=limits)
    assert branch.attrs["first_end"] == branch.attrs["last_end"] == "limits"
    assert branch.residual.values.max() < 1e-12
    for place in (0, -1):
        point = branch.isel(point=place)
        machine = replace(LYING, **{parameter: float(point[parameter])})
        period = float(point.period)
        assert revolutions(machine, period) == pytest.approx(1.0, abs=1e-12)
        flown = machine_flown(machine, state_of(point), period)
        np.testing.assert_allclose(flown.end, state_of(point), rtol=0.0, atol=1e-9)


def test_folds_and_doublings_of_a_branch_over_the_speed(cycles):
    """There DOP853 gives a multiplier of 1, or -1; doubled cycles take twice the revolutions."""
    branch = continue_cycle(LYING, start=cycles[LYING], limits=(1.1, 1.9), points=400)
    kinds = branch.special_kind.values.tolist()
    assert SPECIAL["fold"] in kinds
    assert SPECIAL["period_doubling"] in kinds
    for kind, value in (("fold", 1.0), ("period_doubling", -1.0)):
        special = branch.isel(special=kinds.index(SPECIAL[kind]))
        machine = replace(LYING, omega=float(special.special_value))
        flown = machine_flown(machine, state_of(special, "special_"), float(special.special_period))
        assert np.abs(np.linalg.eigvals(flown.monodromy) - value).min() < 1e-6
    doubled = continue_cycle(LYING, start=special, limits=(1.1, 1.9), points=12)
    machine = replace(LYING, omega=float(doubled.omega[-1]))
    assert revolutions(machine, float(doubled.period[-1])) == pytest.approx(2.0, abs=1e-12)
    flown = machine_flown(machine, state_of(doubled.isel(point=-1)), float(doubled.period[-1]))
    np.testing.assert_allclose(flown.end, state_of(doubled.isel(point=-1)), rtol=0.0, atol=1e-8)
    half = machine_flown(machine, state_of(doubled.isel(point=-1)), float(doubled.period[-1]) / 2)
    assert np.abs(half.end - flown.end).max() > 1e-3


@pytest.mark.parametrize(("kind", "value"), [("fold", 1.0), ("period_doubling", -1.0)])
def test_a_bifurcation_is_followed_over_speed_and_load(cycles, kind, value):
    branch = continue_cycle(LYING, start=cycles[LYING], limits=(1.1, 1.9), points=400)
    place = branch.special_kind.values.tolist().index(SPECIAL[kind])
    curve = bifurcation_curve(
        LYING, start=branch.isel(special=place), kind=kind,
        parameters=("omega", "load"), limits=((1.1, 1.9), (0.8, 1.2)),
    )  # fmt: skip
    assert curve["load"].values.min() == 0.8
    assert curve["load"].values.max() == 1.2
    found = curve.multiplier_real.values + 1j * curve.multiplier_imag.values
    assert np.abs(found - value).min(axis=1).max() < 1e-9


def test_a_closed_branch_under_a_load_is_known_as_closed():
    """Over contact damping its period stands still."""
    machine = Rotor(omega=1.5, zeta=0.08, delta0=1.0, load=0.1, contact_damping=0.8)
    branch = continue_cycle(
        machine, start=(0, -1, 0, 0), parameter="contact_damping", limits=(0.0, 3.0)
    )
    assert branch.attrs["closed"] == 1
    assert (branch.special_kind.values == SPECIAL["fold"]).sum() == 2


@pytest.mark.parametrize(
    ("rotor", "limits", "says"),
    [
        (LYING, (0.0, 2.0), "limits of load must be above 0"),
        (replace(LYING, load=0.0), (0.0, 2.0), "limits of load must be above 0"),
        (replace(LYING, load=0.0), (0.5, 2.0), "load must be above 0 to be continued, got 0.0"),
    ],
)
def test_a_load_is_not_continued_to_nothing(rotor, limits, says):
    with pytest.raises(InputError, match=says):
        continue_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0), parameter="load", limits=limits)
