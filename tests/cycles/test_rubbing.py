"""Limit cycles with friction: sliding, reversing and rolling, and where their branches begin."""

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    Rotor,
    backward_whirl,
    bifurcation_curve,
    continue_cycle,
    hopf_points,
    limit_cycle,
    simulate,
)
from rotor_ida.schema import RESPONSE, SPECIAL, STABILITY

RUB = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)
NEAR_RUB = (3.0, 1.0, 0.0, 0.0)
WHIP = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)


@pytest.fixture(scope="module")
def over_friction():
    return continue_cycle(RUB, start=NEAR_RUB, parameter="friction", limits=(0.0, 0.3))


def multipliers(cycle):
    return cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values


def specials(branch, kind):
    return branch.isel(special=branch.special_kind.values == SPECIAL[kind])


def one_period(branch, point, samples=2001):
    """The motion once round, at a point of a branch over friction."""
    here = branch.isel(point=point)
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=here.friction, disc_radius=10.0)
    start = [float(here[name]) for name in ("x", "y", "vx", "vy")]
    return simulate(
        rotor, start=start, duration=float(here.period), samples=samples, method="taylor"
    )


def test_a_cycle_born_at_a_hopf_point_is_the_known_one():
    """Radii, the modulus of its pair and det M as two other programs have them."""
    cycle = limit_cycle(RUB, start=NEAR_RUB)
    assert cycle.radius_min == pytest.approx(0.94953900, abs=5e-9)
    assert cycle.radius_max == pytest.approx(5.64648121, abs=5e-9)
    assert cycle.response == RESPONSE["full_contact"]
    found = multipliers(cycle)
    assert found[0] == 1.0
    assert found[1].real == pytest.approx(0.978, abs=5e-4)
    assert abs(found[2]) == pytest.approx(0.722, abs=5e-4)
    shrinks = np.exp(-4.0 * RUB.zeta * cycle.period.item())
    assert np.prod(found).real == pytest.approx(shrinks, rel=1e-11)
    assert cycle.trivial_defect < 1e-13
    assert np.isnan(cycle.symplectic_defect)


def test_a_whip_that_rolls_and_slips_for_ever_is_a_cycle():
    """Once round it is where it was, by CVODE as well, and one of its multipliers is 0."""
    amplitude = float(backward_whirl(WHIP).amplitude[-1])
    cycle = limit_cycle(WHIP, start=(amplitude, 0.0, 0.0, -10.0))
    assert cycle.response == RESPONSE["rolling"]
    assert cycle.stability == STABILITY["stable"]
    assert cycle.residual < 1e-13
    found = multipliers(cycle)
    assert found[0] == 1.0
    assert found[3] == 0.0
    assert 0.0 < abs(found[1]) < 1.0
    start = [float(cycle[name][0]) for name in ("x", "y", "vx", "vy")]
    period = cycle.period.item()
    run = simulate(WHIP, start=start, duration=period, samples=2, method="adams", rtol=1e-12)
    turn = np.exp(-1j * WHIP.omega * period)
    back = np.array([run.x[-1] + 1j * run.y[-1], run.vx[-1] + 1j * run.vy[-1]]) * turn
    expected = [complex(*start[:2]), complex(*start[2:])]
    np.testing.assert_allclose(back, expected, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("parameter", ["omega", "friction", "zeta"])
def test_a_branch_begins_at_the_hopf_point_of_a_whirl(parameter):
    """To rounding, as the closed form has it; with the amplitude and the period there."""
    limits = {"omega": (1.0, 1.3), "friction": (0.0, 0.11), "zeta": (0.06, 0.15)}[parameter]
    branch = continue_cycle(RUB, start=NEAR_RUB, parameter=parameter, limits=limits)
    assert "hopf" in {branch.attrs["first_end"], branch.attrs["last_end"]}
    place = specials(branch, "hopf").isel(special=0)
    here = {"zeta": 0.07, "friction": 0.1, "omega": 1.2} | {parameter: float(place.special_value)}
    points = hopf_points(zeta=here["zeta"], delta0=0.5, friction=here["friction"])
    points = points.isel(zeta=0, delta0=0)
    nearest = int(np.nanargmin(np.abs(points.hopf_omega.values - here["omega"])))
    known = points.isel(hopf=nearest)
    assert known.hopf_omega == pytest.approx(here["omega"], rel=1e-11)
    middle = 0.5 * (place.special_radius_min + place.special_radius_max)
    assert middle == pytest.approx(known.hopf_amplitude.item(), rel=1e-11)
    assert place.special_period == pytest.approx(
        2.0 * np.pi / known.hopf_frequency.item(), rel=1e-11
    )


def test_a_branch_goes_round_the_corner_where_the_slip_comes_to_nothing(over_friction):
    """Before it the disc slides forwards all along, behind it it rolls or slides back once.

    Multipliers jump there, so it is no fold; the cycles themselves meet.
    """
    branch = over_friction
    assert branch.attrs["first_end"] == "hopf"
    assert branch.attrs["last_end"] == "limits"
    assert float(branch.residual.max()) < 1e-12
    corner = specials(branch, "sliding").isel(special=0)
    after = int(corner.special_point) + 1
    before, behind = one_period(branch, after - 1), one_period(branch, after)
    assert before.event_kind.size == 0
    assert 0.0 <= before.slip_speed.min() < 1e-4
    assert behind.event_kind.size > 0
    near = branch.isel(point=[after - 1, after])
    for name in ("friction", "period", "radius_max"):
        one, other = near[name].values
        assert other == pytest.approx(one, abs=1e-5)
    slopes = near["slope"].values
    assert abs(slopes[1] - slopes[0]) > 1e-2


def test_a_branch_over_friction_comes_to_the_rotor_without(over_friction):
    """Where friction has died away the cycles are those of the rotor without."""
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5, friction=0.02, disc_radius=10.0)
    branch = continue_cycle(
        rotor, start=(3.0, 1.0, 0.0, 0.0), parameter="friction", limits=(0.0, 0.05)
    )
    last = branch.isel(point=int(branch.friction.values.argmin()))
    assert last.friction == 0.0
    without = limit_cycle(Rotor(omega=3.0, zeta=0.07, delta0=0.5), start=(3.0, 1.0, 0.0, 0.0))
    for name in ("period", "radius_min", "radius_max"):
        assert last[name] == pytest.approx(without[name].item(), rel=1e-11)
    again = continue_cycle(
        Rotor(omega=3.0, zeta=0.07, delta0=0.5, disc_radius=10.0), start=(3.0, 1.0, 0.0, 0.0),
        parameter="friction", limits=(0.0, 0.02),
    )  # fmt: skip
    there = again.isel(point=int(again.friction.values.argmax()))
    first = limit_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0))
    assert there.friction == 0.02
    assert there.period == pytest.approx(first.period.item(), rel=1e-11)


def test_a_curve_of_folds_over_friction():
    """At each of its points the branch over speed has that very fold."""
    curve = bifurcation_curve(
        RUB, start=NEAR_RUB, kind="fold", parameters=("omega", "friction"),
        limits=((1.2, 1.45), (0.09, 0.11)), points=8,
    )  # fmt: skip
    place = curve.isel(point=-1)
    rotor = Rotor(
        omega=float(place.omega) - 0.002, zeta=0.07, delta0=0.5, friction=float(place.friction),
        disc_radius=10.0,
    )  # fmt: skip
    start = [float(place[name]) for name in ("x", "y", "vx", "vy")]
    cycle = limit_cycle(rotor, start=start, period=float(place.period))
    folds = specials(continue_cycle(rotor, start=cycle, limits=(1.2, 1.45)), "fold")
    assert np.abs(folds.special_value.values - float(place.omega)).min() < 1e-9


@pytest.mark.parametrize(
    ("changes", "parameter", "message"),
    [
        ({"friction": 0.0, "disc_radius": None}, "friction", "disc_radius must be given"),
        ({"friction": 0.0, "disc_radius": None}, "disc_radius", "disc_radius must be given"),
        ({"friction": 0.0}, "disc_radius", "friction must be above 0 for disc_radius"),
    ],
)
def test_bad_input_is_refused(changes, parameter, message):
    given = {"omega": 3.0, "zeta": 0.07, "delta0": 0.5, "friction": 0.1, "disc_radius": 10.0}
    rotor = Rotor(**given | changes)
    with pytest.raises(InputError, match=message):
        continue_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0), parameter=parameter, limits=(0.0, 12.0))
