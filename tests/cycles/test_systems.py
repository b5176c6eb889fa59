"""Limit cycles of rotor systems: beside those of one disc, their sweeps and their exact rubs."""

import numpy as np
import pytest

import rotor_ida
from rotor_ida import InputError, Rotor, SimulationError, decode_flags, special_speeds, sweep
from rotor_ida.cycles.guess import guess_of_system
from rotor_ida.cycles.multipliers import multipliers_of
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.schema import SPECIAL

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
FULL = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
# With friction there are no pairs of multipliers.
RUBBING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)
# Dry whip that rolls and slips by turns.
WHIPPING = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)


def start_of(cycle):
    """Return the state at the start of a cycle of one disc as the start of a system."""
    return tuple([float(cycle[name][0]) for name in pair] for pair in (("x", "y"), ("vx", "vy")))


def multipliers(cycle):
    return cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values


@pytest.fixture(scope="module")
def disc():
    return rotor_ida.limit_cycle(BOUNCING)


@pytest.fixture(scope="module")
def bouncing():
    system = BOUNCING.system()
    return rotor_ida.limit_cycle(system, speed=2.0)


@pytest.mark.parametrize(
    ("rotor", "start", "allowed"),
    [
        (BOUNCING, (3.0, 1.0, 0.0, 0.0), 1e-9),
        (FULL, (3.0, 1.0, 0.0, 0.0), 1e-9),
        (RUBBING, (3.0, 1.0, 0.0, 0.0), 1e-9),
        # differences of a sliding speed that vanishes
        (WHIPPING, (6.928, 0.0, 0.0, -10.0), 1e-9),
    ],
)
def test_a_cycle_of_one_disc_as_a_system_is_that_of_one_disc(rotor, start, allowed):
    """Two ways to integrate and to differentiate: period, radii, force and multipliers."""
    exact = rotor_ida.limit_cycle(rotor, start=start)
    system = rotor.system()
    found = rotor_ida.limit_cycle(
        system, speed=rotor.omega, start=start_of(exact), period=1.001 * exact.period
    )
    assert decode_flags(found.response).item() == decode_flags(exact.response).item()
    assert found.stability.item() == exact.stability.item()
    assert found.contact_count.values.tolist() == [exact.contact_count.item()]
    assert found.residual.item() < 1e-11
    for name in ("period", "radius_min", "radius_max", "largest_force"):
        np.testing.assert_allclose(found[name].values.ravel(), exact[name].values, rtol=1e-9)
    apart = np.abs(multipliers(found)[:, None] - multipliers(exact))
    assert apart.min(axis=0).max() < allowed
    assert found.attrs["axes"] == "turning"
    assert found.trivial_defect.item() < allowed


def test_a_disc_that_follows_its_attractor_arrives_on_the_cycle(bouncing, disc):
    np.testing.assert_allclose(bouncing.period, disc.period, rtol=1e-12)


def test_the_orbit_closes_on_the_turning_axes(bouncing):
    for name in ("x", "y", "vx", "vy"):
        np.testing.assert_allclose(bouncing[name][0], bouncing[name][-1], atol=1e-10)
    radius = np.hypot(bouncing.x, bouncing.y).max()
    assert abs(radius / bouncing.radius_max.item() - 1.0) < 1e-3


def test_a_sweep_ends_on_the_cycle_and_its_point_is_a_guess(bouncing):
    system = BOUNCING.system()
    point = sweep(system, speed=[2.0]).isel(speed=0, start=0, direction=0)
    found = rotor_ida.limit_cycle(system, start=point)
    np.testing.assert_allclose(found.period, point.period, rtol=1e-9)
    np.testing.assert_allclose(found.radius_max, point.radius_max, rtol=1e-8)
    np.testing.assert_allclose(found.period, bouncing.period, rtol=1e-12)


def test_a_cycle_is_the_same_with_more_tolerance_but_for_its_stated_errors():
    system = BOUNCING.system()
    found = rotor_ida.limit_cycle(system, speed=2.0)
    guess = guess_of_system(system, found, None)
    other = close_orbit(guess.flow.but(rtol=1e-12), guess.state, guess.period)
    assert abs(other.duration - found.period.item()) < 1e-11
    assert np.abs(multipliers_of(other) - multipliers(found)).max() < 1e-9


def test_a_cycle_of_two_periods_is_followed_once():
    system = BOUNCING.system()
    exact = rotor_ida.limit_cycle(BOUNCING)
    found = rotor_ida.limit_cycle(
        system, speed=2.0, start=start_of(exact), period=2.0 * exact.period
    )
    np.testing.assert_allclose(found.period, exact.period, rtol=1e-11)


def test_the_bifurcations_of_a_branch_are_those_of_one_disc(bouncing, disc):
    system = BOUNCING.system()
    limits = (1.7, 2.1)
    branch = rotor_ida.continue_cycle(system, start=bouncing, limits=limits)
    exact = rotor_ida.continue_cycle(BOUNCING, start=disc, limits=limits)
    np.testing.assert_array_equal(branch.special_kind, exact.special_kind)
    np.testing.assert_allclose(branch.special_speed, exact.special_value, rtol=1e-9)
    np.testing.assert_allclose(branch.special_period, exact.special_period, rtol=1e-9)
    for end in (0, -1):
        np.testing.assert_allclose(branch.period[end], exact.period[end], rtol=1e-10)
        assert branch.stability[end] == exact.stability[end]
    assert float(branch.residual.max()) < 1e-11
    doubled = rotor_ida.continue_cycle(
        system, start=branch.isel(special=0), limits=limits, points=4
    )
    np.testing.assert_allclose(doubled.period[0], 2.0 * branch.special_period[0], rtol=1e-2)


def test_at_a_hopf_point_the_cycle_shrinks_to_the_rub_with_the_frequency_of_its_eigenvalue():
    """From near the Hopf point the branch goes back to it, located by the rub's eigenvalues."""
    rotor = Rotor(omega=1.1, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=5.0)
    system = rotor.system()
    found = special_speeds(system, limits=(1.0, 1.25), points=20)
    hopf = found.isel(special=np.flatnonzero(found.special_kind == SPECIAL["hopf"])[0])
    branch = rotor_ida.continue_cycle(system, start=hopf, limits=(1.0, 1.25), points=8)
    assert branch.attrs["first_end"] == "hopf"
    np.testing.assert_allclose(branch.speed[0], hopf.special_speed, rtol=1e-10)
    np.testing.assert_allclose(branch.period[0], 2.0 * np.pi / hopf.hopf_frequency, rtol=1e-9)
    for bound in ("radius_min", "radius_max"):
        np.testing.assert_allclose(branch[bound][0], hopf.amplitude, rtol=1e-5)
    swing = (branch.radius_max - branch.radius_min)[:, 0]
    assert (swing.diff("point") > 0.0).all()
    # the speed changes with the square of the oscillation
    parts_of_square = (branch.speed - hopf.special_speed)[1:3] / swing[1:3] ** 2
    np.testing.assert_allclose(parts_of_square[0], parts_of_square[1], rtol=0.2)


def test_under_a_load_a_cycle_takes_whole_revolutions():
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=0.2, shaft_stiffness=0.1)
    exact = rotor_ida.limit_cycle(rotor, start=(0.0, -1.0, 0.0, 0.0))
    assert exact.period.notnull()
    system = rotor.system()
    found = rotor_ida.limit_cycle(system, speed=1.2, start=((0.0, -1.0), (0.0, 0.0)))
    assert found.attrs["axes"] == "fixed"
    np.testing.assert_allclose(found.period, exact.period, rtol=1e-14)
    np.testing.assert_allclose(found.radius_max.values[0], exact.radius_max, rtol=1e-8)
    apart = np.abs(multipliers(found)[:, None] - multipliers(exact))
    assert apart.min(axis=0).max() < 1e-9


def test_a_synchronous_whirl_is_no_cycle():
    system = Rotor(omega=1.0, zeta=0.3, delta0=0.5).system()
    found = rotor_ida.limit_cycle(system, speed=1.0)
    assert decode_flags(found.response).item() == "synchronous"
    assert found.period.isnull()
    assert not found.sizes["t"]
    with pytest.raises(InputError, match="start must be a limit cycle"):
        rotor_ida.limit_cycle(system, start=found)
    with pytest.raises(InputError, match="response is synchronous"):
        rotor_ida.continue_cycle(system, speed=1.0, limits=(0.5, 2.0))
    with pytest.raises(SimulationError, match=r"whirl|found no limit cycle"):
        rotor_ida.limit_cycle(system, speed=1.0, start=((0.9, 0.0), (0.0, 0.9)),
                              period=3.0)  # fmt: skip


@pytest.mark.parametrize(("given", "message"), [
    ({"speed": 0.0}, "speed must not be 0"),
    ({"start": None, "speed": None}, "speed must be given"),
    ({"contacts": []}, "contacts must be given"),
    ({"period": 2.0}, "period must be left out"),
])  # fmt: skip
def test_bad_arguments_of_a_cycle_are_refused_in_one_line(bouncing, given, message):
    system = BOUNCING.system()
    with pytest.raises(InputError, match=message) as caught:
        rotor_ida.limit_cycle(system, **{"start": bouncing, "speed": 2.0} | given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("given", "message"), [
    ({"limits": (2.5, 3.0)}, "limits must contain the speed of the start"),
    ({"limits": (-1.0, 3.0)}, "limits must be two increasing speeds of the same sign"),
    ({"direction": "up"}, "direction must be"),
    ({"start": "bouncing"}, "start must be"),
])  # fmt: skip
def test_bad_arguments_of_a_branch_are_refused_in_one_line(bouncing, given, message):
    system = BOUNCING.system()
    whole = {"start": bouncing, "limits": (1.9, 2.1), "speed": 2.0} | given
    with pytest.raises(InputError, match=message):
        rotor_ida.continue_cycle(system, **whole)
