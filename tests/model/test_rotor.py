"""Rotor and DimensionalRotor: what they accept, and that the scales are the right ones."""

import dataclasses
import math

import numpy as np
import pytest

from rotor_ida import (
    Bearing,
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    dimensional,
    simulate,
)
from rotor_ida.model.parameters import FRICTIONLESS, MACHINE_PARAMETERS, PARAMETERS

MACHINE = DimensionalRotor(
    mass=3.0, contact_stiffness=2.5e9, damping=40.0, eccentricity=4e-6, clearance=3e-6, speed=1500.0
)


@pytest.mark.parametrize("name", ["omega", "zeta", "delta0", "friction", *FRICTIONLESS])
@pytest.mark.parametrize(
    "value", [math.nan, math.inf, -math.inf, True, np.True_, "1", None, 1j, [1.0], 10**400]
)
def test_a_rotor_refuses_what_is_not_a_finite_real_number(name, value):
    parameters = {"omega": 1.0, "zeta": 0.1, "delta0": 0.5, name: value}
    with pytest.raises(InputError, match=rf"^{name} must be a finite real number, got .+$"):
        Rotor(**parameters)
    if name not in PARAMETERS:
        with pytest.raises(InputError, match=rf"^{name} must be a finite real number, got .+$"):
            DimensionalRotor(**MACHINE.given | {name: value})


def test_a_rotor_is_frozen_and_keyword_only():
    rotor = Rotor(omega=np.float64(1), zeta=np.int64(0), delta0=-0.0)
    assert rotor == Rotor(omega=1.0, zeta=0.0, delta0=0.0)
    assert math.copysign(1.0, rotor.delta0) == 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        rotor.omega = 2.0
    with pytest.raises(TypeError):
        Rotor(1.0, 0.1, 0.5)


def test_a_misspelt_argument_of_a_rotor_or_a_part_of_it_is_told_the_one_that_was_meant():
    given = {"omega": 1.0, "zeta": 0.1, "delta0": 1.0}
    words = r"^Rotor\(\) got an unexpected keyword argument 'shaft_stifness'; did you mean 'shaft_s"
    with pytest.raises(TypeError, match=words):
        Rotor(**given, shaft_stifness=1.0)
    kinds = {
        DimensionalRotor: ("mas", "mass"), RotorSystem: ("stiffnss", "stiffness"),
        Contact: ("clearence", "clearance"), Unbalance: ("momnt", "moment"),
        Bearing: ("dampng", "damping"),
    }  # fmt: skip
    for kind, (misspelt, meant) in kinds.items():
        words = rf"^{kind.__name__}\(\) .*; did you mean '{meant}'\?$"
        with pytest.raises(TypeError, match=words):
            kind(**{misspelt: 1.0})


def test_values_of_a_result_make_a_rotor():
    run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=1.0)
    rotor = Rotor(omega=run.omega, zeta=run.zeta, delta0=np.array(0.5))
    assert rotor == Rotor(omega=1.2, zeta=0.5, delta0=0.5)
    assert {type(getattr(rotor, name)) for name in ("omega", "zeta", "delta0")} == {float}


def test_a_machine_whose_scales_leave_the_range_of_doubles_is_refused():
    values = {**dataclasses.asdict(MACHINE), "mass": 1e300, "contact_stiffness": 1e-300}
    with pytest.raises(InputError, match="must give scales of frequency, velocity and force"):
        DimensionalRotor(**values)


@pytest.mark.parametrize("name", ["mass", "contact_stiffness", "eccentricity"])
def test_a_machine_needs_mass_stiffness_and_eccentricity(name):
    values = {**dataclasses.asdict(MACHINE), name: 0.0}
    with pytest.raises(InputError, match=rf"^{name} must be positive, got 0 (kg|m|N/m\^1.5)$"):
        DimensionalRotor(**values)


def whole_machine(exponent):
    """Return a machine with a shaft, a load and a damped contact, whose speeds are of size 1."""
    return DimensionalRotor(
        mass=3.0,
        contact_stiffness=5e6 * 4e-6 ** (1.0 - exponent),
        damping=40.0,
        eccentricity=4e-6,
        clearance=3e-6,
        speed=1500.0,
        shaft_stiffness=2e6,
        contact_exponent=exponent,
        contact_damping=150.0,
        load=3.0 * 9.80665,
    )


@pytest.mark.parametrize("exponent", [1.5, 1.0])
def test_the_whole_equation_is_the_same_in_both_units(exponent):
    """At one state in contact, newtons over m D omega_0**2 are the dimensionless forces."""
    machine = whole_machine(exponent)
    rotor, frequency = machine.rotor(), machine.reference_frequency
    place, velocity, time = 1.1 + 0.4j, -0.3 + 0.8j, 0.7

    def pull(stiffness, exponent, damping, clearance, place, velocity):
        radius = abs(place)
        depth, rate = radius - clearance, (velocity * place.conjugate()).real / radius
        return stiffness * depth**exponent * (1.0 + damping * rate) * place / radius

    there, moving = place * machine.eccentricity, velocity * machine.velocity_scale
    newtons = (
        machine.mass * machine.eccentricity * machine.speed**2
        * np.exp(1j * machine.speed * time / frequency)
        - 1j * machine.load - machine.damping * moving - machine.shaft_stiffness * there
        - pull(machine.contact_stiffness, exponent, machine.contact_damping, machine.clearance,
               there, moving)
    )  # fmt: skip
    without = (
        rotor.omega**2 * np.exp(1j * rotor.omega * time) - 1j * rotor.load
        - 2.0 * rotor.zeta * velocity - rotor.shaft_stiffness * place
        - pull(1.0, exponent, rotor.contact_damping, rotor.delta0, place, velocity)
    )  # fmt: skip
    scale = machine.mass * machine.eccentricity * frequency**2
    assert machine.force_scale == pytest.approx(scale, rel=1e-14)
    assert newtons / scale == pytest.approx(without, rel=1e-12)


def test_what_is_given_makes_the_same_rotor_and_machine():
    plain = Rotor(omega=1.2, zeta=0.07, delta0=0.5)
    assert plain.given == {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}
    for machine in (MACHINE, whole_machine(1.0)):
        assert DimensionalRotor(**machine.given) == machine
        assert Rotor(**machine.rotor().given) == machine.rotor()
    assert list(MACHINE.given) == list(MACHINE_PARAMETERS)


PLAIN = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}


def test_friction_needs_a_clearance_and_the_radius_of_a_disc():
    words = r"^disc_radius must be given with friction, got None with friction 0.1$"
    for make, others in ((Rotor, PLAIN), (DimensionalRotor, MACHINE.given)):
        with pytest.raises(InputError, match=words):
            make(**others, friction=0.1)
        with pytest.raises(InputError, match="disc_radius must be a finite real number, got inf"):
            make(**others, disc_radius=math.inf)
    with pytest.raises(InputError, match=r"^friction must be 0 without clearance, .*, got 0.1"):
        Rotor(omega=1.0, zeta=0.1, delta0=0.0, friction=0.1, disc_radius=2.0)
    assert Rotor(omega=1.0, zeta=0.1, delta0=0.0, disc_radius=2.0).disc_radius == 2.0


def test_friction_is_told_where_there_is_any_and_a_disc_wherever_it_is_given():
    rubbing = Rotor(**PLAIN, friction=0.1, disc_radius=2)
    assert rubbing.beyond == {"friction": 0.1, "disc_radius": 2.0}
    assert repr(rubbing).endswith("delta0=0.5, friction=0.1, disc_radius=2.0)")
    smooth = Rotor(**PLAIN, disc_radius=2.0)
    assert smooth.given == PLAIN | {"disc_radius": 2.0}
    assert smooth.beyond == {}
    for rotor in (rubbing, smooth):
        assert Rotor(**rotor.given) == rotor
    assert Rotor(**PLAIN, friction=0.0).given == PLAIN


def test_a_disc_without_friction_changes_no_bit_of_a_run():
    start = {"start": (0.0, 0.0, 0.0, 0.0), "duration": 30.0}
    disc = {"disc_radius": 2.0}
    plain, smooth = (simulate(Rotor(**PLAIN, **more), **start) for more in ({}, disc))
    assert smooth.disc_radius == 2.0
    assert smooth.drop_vars("disc_radius").equals(plain)


def test_friction_and_disc_in_si_units():
    machine = DimensionalRotor(**MACHINE.given, friction=0.2, disc_radius=0.03)
    assert DimensionalRotor(**machine.given) == machine
    rotor = machine.rotor()
    assert (rotor.friction, rotor.disc_radius) == (0.2, pytest.approx(0.03 / 4e-6, rel=1e-15))
    run = simulate(rotor, start=(0.9, 0.0, 0.0, 0.0), duration=5.0)
    found = dimensional(run, machine)
    assert found.slip_speed.attrs["units"] == "m s-1"
    rim = 0.03 * 1500.0
    across = (found.x * found.vy - found.y * found.vx) / np.hypot(found.x, found.y)
    np.testing.assert_allclose(found.slip_speed, across + rim, rtol=1e-12)
    assert found.heat.attrs["units"] == "J"
    assert found.normal_force.attrs["units"] == "N"
