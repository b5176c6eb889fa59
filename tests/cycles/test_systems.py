"""Limit cycles of rotor systems: beside those of one disc, their sweeps and their exact rubs."""

from dataclasses import replace

import numpy as np
import pytest

import rotor_ida
from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    SimulationError,
    Stator,
    Unbalance,
    decode_flags,
    special_speeds,
    sweep,
)
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


def test_a_cycle_is_the_same_with_more_tolerance_but_for_its_stated_errors():
    system = BOUNCING.system()
    found = rotor_ida.limit_cycle(system, speed=2.0)
    guess = guess_of_system(system, found, None)
    other = close_orbit(guess.flow.but(rtol=1e-12), guess.state, guess.period)
    assert abs(other.duration - found.period.item()) < 1e-11
    assert np.abs(multipliers_of(other) - multipliers(found)).max() < 1e-9


def test_the_bifurcations_of_a_branch_are_those_of_one_disc(bouncing, disc):
    system = BOUNCING.system()
    limits = (1.7, 2.1)
    branch = rotor_ida.continue_cycle(system, start=bouncing, limits=limits)
    exact = rotor_ida.continue_cycle(BOUNCING, start=disc, limits=limits)
    np.testing.assert_array_equal(branch.special_kind, exact.special_kind)
    np.testing.assert_allclose(branch.special_value, exact.special_value, rtol=1e-9)
    np.testing.assert_allclose(branch.special_period, exact.special_period, rtol=1e-9)
    for end in (0, -1):
        np.testing.assert_allclose(branch.period[end], exact.period[end], rtol=1e-10)
        assert branch.stability[end] == exact.stability[end]
    assert float(branch.residual.max()) < 1e-11
    doubled = rotor_ida.continue_cycle(
        system, start=branch.isel(special=0), limits=limits, points=4
    )
    np.testing.assert_allclose(doubled.period[0], 2.0 * branch.special_period[0], rtol=1e-2)


@pytest.mark.parametrize(("name", "of_disc", "limits"), [
    ("friction", "friction", (0.08, 0.12)), ("clearance", "delta0", (0.45, 0.55)),
])  # fmt: skip
def test_a_branch_over_a_parameter_is_that_of_one_disc(name, of_disc, limits):
    """Derivatives by the parameter are differences of runs here, and integrals there.

    Over the friction it passes folds, a graze, and the corner where the disc begins to roll.
    """
    start = (3.0, 1.0, 0.0, 0.0)
    exact = rotor_ida.continue_cycle(RUBBING, start=start, parameter=of_disc, limits=limits)
    branch = rotor_ida.continue_cycle(
        RUBBING.system(), speed=1.2, start=(start[:2], start[2:]), parameter=name, limits=limits
    )
    assert branch[name].dims == ("point",)
    assert branch.speed.item() == 1.2
    np.testing.assert_array_equal(branch.special_kind, exact.special_kind)
    np.testing.assert_allclose(branch.special_value, exact.special_value, rtol=1e-10)
    np.testing.assert_allclose(branch.special_period, exact.special_period, rtol=1e-10)
    for end, point in {"first_end": 0, "last_end": -1}.items():
        assert branch.attrs[end] == exact.attrs[end]
        if branch.attrs[end] != "limits":  # at a Hopf point the phase of the oscillation is free
            continue
        assert branch[name][point] == pytest.approx(exact[of_disc].values[point], rel=1e-10)
        for number in ("period", "radius_max", "largest_force"):
            np.testing.assert_allclose(branch[number][point], exact[number][point], rtol=1e-9)


@pytest.mark.parametrize(("rotor", "start", "kind", "limits"), [
    (BOUNCING, (0.0, 0.0, 0.0, 0.0), "period_doubling", [(1.7, 2.1), (1.9, 2.1)]),
    (FULL, (3.0, 1.0, 0.0, 0.0), "fold", [(2.4, 3.2), (0.4, 0.6)]),
])  # fmt: skip
def test_a_curve_of_bifurcations_is_that_of_one_disc(rotor, start, kind, limits):
    exact = rotor_ida.bifurcation_curve(rotor, start=start, kind=kind, limits=limits)
    curve = rotor_ida.bifurcation_curve(
        rotor.system(), speed=rotor.omega, start=(start[:2], start[2:]), kind=kind, limits=limits
    )
    ends = [0, -1]
    np.testing.assert_allclose(curve.speed[ends], exact.omega[ends], rtol=1e-9)
    np.testing.assert_allclose(curve.clearance[ends], exact.delta0[ends], rtol=1e-9)
    np.testing.assert_allclose(curve.period[ends], exact.period[ends], rtol=1e-9)
    np.testing.assert_array_equal(curve.contact_clearance.isel(contact=0), curve.clearance)
    turned = -1.0 if kind == "period_doubling" else 1.0
    assert np.sort(np.abs(multipliers(curve) - turned), axis=1)[:, 1 - (turned < 0)].max() < 1e-6


def two_discs(clearance=(3.0, 0.8), friction=0.02):
    """Return a system whose second disc rubs."""
    chain = np.kron([[2.0, -1.0], [-1.0, 2.0]], np.eye(2))
    law = {"stiffness": 3.0, "exponent": 1.0, "radius": 2.0}
    contacts = [
        Contact(node=node, clearance=gap, friction=part * friction, **law)
        for node, gap, part in zip(("one", "two"), clearance, (0.5, 1.0), strict=True)
    ]
    return RotorSystem(
        mass=np.eye(4), stiffness=chain, damping=0.1 * chain, contacts=contacts, units="1",
        nodes={"one": (0, 1), "two": (2, 3)}, unbalance=[Unbalance(node="one", moment=0.4)],
    )  # fmt: skip


@pytest.mark.parametrize(("name", "limits", "changed"), [
    ("clearance", (2.9, 3.05), lambda value: two_discs((value, 0.8 / 3.0 * value))),
    ("friction", (0.0, 0.04), lambda value: two_discs(friction=value)),
])  # fmt: skip
def test_points_of_a_branch_are_cycles_of_the_system_with_that_parameter(name, limits, changed):
    """The contacts keep their ratios: the system is built anew with the numbers of each."""
    branch = rotor_ida.continue_cycle(two_discs(), speed=1.5, parameter=name, limits=limits)
    for place in (0, -1):
        point = branch.isel(point=place)
        assert point[name] in limits
        again = rotor_ida.limit_cycle(changed(point[name].item()), speed=1.5, start=point)
        for number in ("period", "radius_min", "radius_max", "largest_force"):
            np.testing.assert_allclose(again[number], point[number], rtol=1e-9)
        apart = np.abs(multipliers(again)[:, None] - multipliers(point))
        assert apart.min(axis=0).max() < 1e-7
    onwards = rotor_ida.continue_cycle(
        two_discs(), start=branch.isel(point=-1), limits=(1.49, 1.51), points=2
    )
    middle = onwards.sel(point=onwards.speed == 1.5)  # with the parameter of its start
    np.testing.assert_allclose(middle.period.values, branch.period.values[-1], rtol=1e-12)


@pytest.mark.parametrize(("given", "message"), [
    ({"parameters": ("omega", "delta0")}, "parameters must be two of 'speed', 'damping'"),
    ({"limits": {"speed": (1.9, 2.1), "clearance": (0.0, 3.0)}}, "limits of clearance must be abo"),
    ({"parameters": ("speed", "friction"), "limits": [(1.9, 2.1), (0.0, 0.2)]},
     "radius of the contact at 'disc' must be given with friction"),
    ({"kind": "torus"}, "limits must contain a torus of the branch"),
])  # fmt: skip
def test_bad_arguments_of_a_curve_are_refused_in_one_line(bouncing, given, message):
    whole = {"start": bouncing, "kind": "fold", "limits": [(1.98, 2.02), (1.9, 2.1)]} | given
    with pytest.raises(InputError, match=message):
        rotor_ida.bifurcation_curve(BOUNCING.system(), **whole)


def test_curves_of_stators_without_mass_are_refused():
    """Their multipliers are differences of runs, too inexact to be differentiated."""
    stator = Stator(mass=0.0, stiffness=1.0, damping=1.0)
    contacts = [replace(each, stator=stator) for each in two_discs().contacts[:1]]
    system = replace(two_discs(), contacts=contacts)
    with pytest.raises(InputError, match="stators must have a mass for their bifurcations"):
        rotor_ida.bifurcation_curve(system, speed=1.5, kind="fold", limits=[(1.4, 1.6), (2.0, 4.0)])


def test_the_part_at_the_spin_speed_is_the_mean_over_a_period():
    """Of a cycle on turning axes; over whole revolutions its other parts do not vanish."""
    cycle = rotor_ida.limit_cycle(BOUNCING)
    mean = complex(cycle.x[:-1].mean(), cycle.y[:-1].mean())
    disc = sweep(BOUNCING).squeeze()
    system = sweep(BOUNCING.system(), speed=[2.0]).squeeze()
    for found in (disc, system):
        np.testing.assert_allclose(found.amplitude, abs(mean), rtol=1e-8)
        np.testing.assert_allclose(found.phase_lag, -np.angle(mean), rtol=1e-8)


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
    ({"limits": (2.5, 3.0)}, "limits of speed must contain that of the start, 2.0"),
    ({"limits": (-1.0, 3.0)}, "limits of speed must be two increasing speeds of the same sign"),
    ({"direction": "up"}, "direction must be"),
    ({"start": "bouncing"}, "start must be"),
])  # fmt: skip
def test_bad_arguments_of_a_branch_are_refused_in_one_line(bouncing, given, message):
    system = BOUNCING.system()
    whole = {"start": bouncing, "limits": (1.9, 2.1), "speed": 2.0} | given
    with pytest.raises(InputError, match=message):
        rotor_ida.continue_cycle(system, **whole)
