"""The physics that the scenarios of real machines show, each beside an independent witness."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    compare,
    limit_cycle,
    lyapunov_exponent,
    run_ups,
    simulate,
    sweep,
)
from rotor_ida.closed_forms import peaks, response_curve
from rotor_ida.paper.whip import ENDS, end_of, is_whip
from rotor_ida.schema import RESPONSE
from tests.scenarios import scenario


@pytest.fixture(scope="module")
def shaft():
    return scenario("shaft")


@pytest.fixture(scope="module")
def restitution():
    return scenario("restitution")


@pytest.fixture(scope="module")
def drop():
    return scenario("drop")


@pytest.fixture
def finite_elements():
    return scenario("finite_elements")


def curve_of(shaft, stiffness, exponent):
    return response_curve(
        zeta=shaft.ZETA, delta0=shaft.DELTA0, limits=shaft.LIMITS, shaft_stiffness=stiffness,
        contact_exponent=exponent,
    )  # fmt: skip


@pytest.mark.parametrize(("exponent", "joined"), [(1.0, 1.001), (1.5, 1.01)])
def test_whirls_in_contact_are_an_isola_until_the_critical_speed_reaches_the_ring(
    shaft, exponent, joined
):
    """The contact-free whirl is largest where 1/A**2 = 4 u (1 - u), u = zeta**2/kappa.

    By Hertz the ring is soft at first, and a small arc of slight contact comes before the isola
    joins the resonance.
    """
    u = 0.5 * (1.0 - math.sqrt(1.0 - shaft.DELTA0**-2.0))
    reaching = shaft.ZETA**2 / u
    assert shaft.is_isola(curve_of(shaft, 0.999 * reaching, exponent))
    assert not shaft.is_isola(curve_of(shaft, joined * reaching, exponent))


def test_rotor_from_rest_is_led_to_the_whirls_in_contact_by_the_stiff_shaft_alone(shaft):
    swept = sweep(
        omega=np.linspace(0.2, 1.2, 21), zeta=shaft.ZETA, delta0=shaft.DELTA0, direction="up",
        shaft_stiffness=list(shaft.SHAFTS), contact_exponent=1.0, method="taylor",
    )  # fmt: skip
    reached = (swept.response == RESPONSE["synchronous"]).any("omega").values.ravel()
    assert reached.tolist() == [False, False, True]
    met, exactly, missed = shaft.agreement([compare(swept)], shaft.WHIRLS)
    assert met == exactly > 0
    assert missed < 1e-9


def test_contact_damping_turns_bouncing_into_full_contact(restitution):
    for damping, touches in ((0.04, True), (0.05, False)):
        rotor = Rotor(**restitution.BOUNCING, contact_damping=damping)
        cycle = limit_cycle(rotor, start=(0.0, 0.0, 0.0, 0.0))
        assert (cycle.radius_min.item() < rotor.delta0) == touches


def test_hardly_any_contact_damping_ends_the_chaos(restitution):
    for damping, chaotic in ((0.0, True), (0.002, True), (0.006, False)):
        rotor = Rotor(**restitution.CHAOTIC, contact_damping=damping)
        found = lyapunov_exponent(
            rotor, start=restitution.START, transient=2000.0, duration=3000.0
        ).isel(exponent=0)
        exponent, error = found.lyapunov_exponent.item(), found.lyapunov_error.item()
        assert (exponent > 5.0 * error and exponent > 0.01) == chaotic


def test_rotor_at_rest_does_not_leave_the_ring_again_and_carries_its_weight(drop):
    machine = drop.machine_with(10.0, 0.2e-3)
    rest = drop.time_to_rest(drop.drop(machine, drop.LASTS), machine)
    assert 0.02 < rest < 0.1
    long = drop.with_force(drop.drop(machine, 3.0 * drop.LASTS, samples=60_001))
    last = long.event_time.values[-1] * machine.time_scale
    assert last == pytest.approx(rest, rel=1e-9)
    late = long.isel(t=long.t.values * machine.time_scale > 2.0 * drop.LASTS)
    upwards = -late.force * late.y / np.hypot(late.x, late.y)
    # over 250 revolutions the ring carries the weight; the ends of the mean are cut
    carried = float(upwards.mean()) * machine.force_scale
    assert carried == pytest.approx(machine.load, rel=2e-3)


def test_unbalance_keeps_the_rotor_bouncing_that_would_rest_without_spin(drop):
    machine = drop.machine_with(3.0, 0.2e-3)
    assert math.isnan(drop.time_to_rest(drop.drop(machine, drop.LASTS), machine))
    still = Rotor(**(machine.rotor().given | {"omega": 0.0}))
    duration = drop.LASTS / machine.time_scale
    run = simulate(still, start=(0.0, 0.0, 0.0, 0.0), duration=duration, method="taylor")
    assert drop.time_to_rest(run, machine) < 0.3


@pytest.mark.parametrize("friction", [0.1, 0.2, 0.3])
def test_rotor_that_rests_lies_on_the_side_by_the_angle_of_friction(drop, friction):
    """Forces on a body at rest: its weight, and a contact tilted by the angle of friction."""
    machine = drop.machine_with(10.0, friction=friction)
    run = drop.drop(machine, 1.0, samples=20_001)
    assert end_of(run) == ENDS["no_whip"]
    late = run.isel(t=slice(10_000, None))
    assert (late.normal_force > 0.0).all()
    x, y = float(late.x.mean()), float(late.y.mean())
    # the rim slides on towards positive x, so friction pulls the other way; it rocks about there
    assert x / y == pytest.approx(friction, rel=0.03)
    assert x < 0.0


def test_drop_that_ends_in_whip_does_so_by_another_method_and_for_good(drop):
    for friction, whips in ((0.2, False), (0.4, True)):
        machine = drop.machine_with(10.0, friction=friction)
        rotor = machine.rotor()
        run = simulate(
            rotor, start=(-1.0, 0.0, 0.0, -rotor.omega),
            duration=5.0 * drop.DECIDED / machine.time_scale, samples=401, method="adams",
        )  # fmt: skip
        assert is_whip(run) == whips
        assert is_whip(drop.drop(machine, drop.DECIDED, samples=201)) == whips


@pytest.fixture(scope="module")
def how_slow():
    return scenario("how_slow")


def run_up_of(how_slow, machine, rates):
    rotor, frequency = machine.rotor(), machine.reference_frequency
    given = {name: value for name, value in rotor.given.items() if name != "omega"}
    return run_ups(
        omega=rotor.omega, to=how_slow.RUN[1] * how_slow.RADIANS / frequency,
        rate=np.array(rates) * how_slow.RADIANS / frequency**2, method="taylor", rtol=1e-8, **given,
    ).squeeze()  # fmt: skip


@pytest.mark.parametrize("zeta", [0.02, 0.1])
def test_a_slow_run_up_meets_92_percent_of_the_force_on_the_exact_response(how_slow, zeta):
    machine = {"zeta": zeta, "delta0": 2.0, "shaft_stiffness": 1.0}
    rates = how_slow.SLOW * zeta * np.array([1.0, 4.0, 10.0])
    found = run_ups(omega=0.2, to=3.5, rate=rates, method="taylor", rtol=1e-8, **machine)
    part = found.largest_force.values.ravel() / peaks(**machine).peak_contact_force.item()
    assert 0.92 < part[0] < 1.0
    assert 0.7 < part[1] < 0.76
    assert 0.35 < part[2] < 0.46


def test_the_largest_radius_is_that_of_lewis_and_less_than_one_eccentricity_more(how_slow):
    rates = np.geomspace(1e-3, 1.0, 7)
    given = {"zeta": 0.0, "delta0": 1e4, "shaft_stiffness": 1.0, "method": "taylor", "rtol": 1e-8}
    found = run_ups(omega=[0.0, 0.2, 0.4], to=12.0, rate=rates, **given).squeeze()
    more = found.largest_radius - how_slow.LEWIS / np.sqrt(found.rate)
    assert float(more.min()) > 0.5
    assert float(more.max()) < how_slow.MORE


def test_machine_does_not_touch_at_the_rate_that_lewis_gives(how_slow):
    """His rotor is undamped; damping keeps this one off the ring at a third of it still."""
    for clearance in how_slow.RING:
        machine = how_slow.machine_with(clearance, how_slow.SMOOTH)
        limit = how_slow.never_touches_in_rpm(machine)
        found = run_up_of(how_slow, machine, [0.1 * limit, limit])
        assert (found.contact_count.values > 0).tolist() == [True, False]


def test_elastic_fall_without_unbalance_bears_the_force_of_its_energy(drop):
    machine = drop.machine_with(0.0, 0.3e-3)
    rotor = Rotor(**(machine.rotor().given | {"omega": 0.0, "zeta": 0.0}))
    run = simulate(rotor, start=(0.0, 0.0, 0.0, 0.0), duration=0.02 / machine.time_scale)
    force = run.peak_force.values[0] * machine.force_scale
    assert force == pytest.approx(drop.elastic_force(0.3e-3), rel=1e-9)


def test_beam_elements_have_the_frequencies_of_a_beam_on_knife_edges(finite_elements, monkeypatch):
    """They are ``(n pi/L)**2 sqrt(EI/(rho A))``."""
    monkeypatch.setattr(finite_elements, "DISCS", {})
    monkeypatch.setattr(finite_elements, "BEARING", (1e13, 0.0))
    system = finite_elements.rotor()
    found = np.sqrt(np.linalg.eigvals(np.linalg.solve(system.mass, system.stiffness)).real)
    length = finite_elements.LENGTH * finite_elements.ELEMENTS
    # of a round rod sqrt(I/A) is a quarter of the diameter
    wave = math.sqrt(finite_elements.YOUNG / finite_elements.DENSITY) * finite_elements.DIAMETER / 4
    exact = [(n * math.pi / length) ** 2 * wave for n in (1, 1, 2, 2, 3, 3)]
    np.testing.assert_allclose(np.sort(found)[:6], exact, rtol=1e-3)


def test_a_forward_whirl_resonates_at_the_critical_speed(finite_elements):
    system = finite_elements.rotor()
    speed = finite_elements.critical_speed(system)
    undamped = system.stiffness - speed**2 * system.mass + 1j * speed**2 * system.gyroscopic
    _, sizes, shapes = np.linalg.svd(undamped)
    assert sizes[-1] < 1e-9 * sizes[0]
    x, y = np.split(shapes[-1].conj(), 2)
    np.testing.assert_allclose(y, -1j * x, atol=1e-6)
