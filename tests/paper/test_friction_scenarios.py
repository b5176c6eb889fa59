"""The physics that the scenarios of friction show, each beside an independent witness."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, backward_whirl, simulate, synchronous_response
from rotor_ida.paper.whip import ENDS, end_of, is_whip
from tests.scenarios import scenario


@pytest.fixture(scope="module")
def rub():
    return scenario("rub")


@pytest.fixture(scope="module")
def whip_map():
    return scenario("whip_map")


def whirl_of(rub, omega, friction):
    found = synchronous_response(omega=omega, zeta=rub.ZETA, delta0=rub.DELTA0, friction=[friction])
    return found.squeeze(["omega", "zeta", "delta0", "friction"]).isel(branch=0)


def test_whirl_beyond_its_hopf_point_swings_in_full_contact(rub):
    """The range was computed for the design of this project by a solver that shares no code."""
    run = rub.beside(whirl_of(rub, 1.2, 0.1))
    assert rub.kind_of_end(run) == rub.ENDS["full_contact"]
    _, smallest, largest = rub.late_radii(run)
    # of samples, which come within a thousandth of an extremum
    assert smallest == pytest.approx(0.94953900, abs=1e-3)
    assert largest == pytest.approx(5.64648121, abs=1e-3)
    assert rub.kind_of_end(rub.beside(whirl_of(rub, 1.05, 0.1))) == rub.ENDS["synchronous"]


def test_whirl_speed_is_that_at_which_the_angle_turns(rub):
    run = rub.with_forces(rub.knocked(rub.rotor_at(rub.OMEGA), 5.5, 60.0, 24_001))
    turned = np.unwrap(np.arctan2(run.y.values, run.x.values))
    total = np.trapezoid(run.whirl_speed.values, run.t.values)
    assert total == pytest.approx(turned[-1] - turned[0], abs=1e-3)


def test_knock_goes_into_whip_only_beyond_the_smallest_by_another_method_too(rub):
    rotor = rub.rotor_at(0.8)
    least = rub.smallest_speed(0.8)
    for factor, whips in ((0.99, False), (1.01, True)):
        start = (1.0, 0.0, 0.0, -factor * least)
        run = simulate(rotor, start=start, duration=250.0, samples=301, method="adams")
        assert is_whip(run) == whips


def test_smallest_whirl_that_goes_into_whip_is_the_saddle_without_unbalance(rub):
    """The wider the clearance in eccentricities, the less the unbalance matters."""
    off = [
        abs(rub.smallest_radius(2.0 * 0.314789904, delta0, 0.5, near=1e-5) - 1.0)
        for delta0 in (10.0, 100.0)
    ]
    assert 0.0 < off[1] < 0.2 * off[0]
    assert off[1] < 2e-3


def test_knock_that_dies_does_not_come_back_to_whip(rub):
    rotor = rub.rotor_at(rub.OMEGA)
    assert not is_whip(rub.knocked(rotor, rub.KNOCKS["dies"], 1000.0, 1001))
    assert is_whip(rub.knocked(rotor, rub.KNOCKS["whips"], 1000.0, 1001))


@pytest.mark.parametrize("name", ["shaft", "hertz"])
def test_whip_is_there_from_the_birth_on_and_not_below(whip_map, name):
    """With unbalance the birth is moved, but by less than the factors here."""
    for friction in (0.15, 0.4):
        born = whip_map.birth(name, friction)
        for factor, lasts in ((0.7, False), (1.5, True)):
            rotor = Rotor(omega=factor * born, friction=friction, **whip_map.ROTORS[name])
            # thrown round the ring as fast as its surface
            radius = 1.2 if math.isnan(backward_whirl(rotor).amplitude[1]) else float(
                backward_whirl(rotor).amplitude[1]
            )  # fmt: skip
            start = (radius, 0.0, 0.0, -rotor.disc_radius * rotor.omega)
            run = simulate(rotor, start=start, duration=600.0, samples=601, method="taylor")
            assert is_whip(run) == lasts


def test_linear_ring_has_no_whip_below_the_weakest_friction(whip_map):
    weakest = whip_map.weakest_friction("shaft")
    assert math.isnan(whip_map.birth("shaft", weakest * (1.0 - 1e-9)))
    assert math.isfinite(whip_map.birth("shaft", weakest * (1.0 + 1e-9)))
    assert whip_map.weakest_friction("hertz") == 0.0


def test_forward_rub_bouncing_and_flight_are_no_whip():
    given = {"zeta": 0.07, "delta0": 0.5, "friction": 0.1, "disc_radius": 10.0}
    for omega in (0.03, 0.8, 1.2):
        run = simulate(Rotor(omega=omega, **given), start=(0.0, 0.0, 0.0, 0.0), duration=300.0)
        assert end_of(run) == ENDS["no_whip"]
