"""A data sheet gives the machine that an engineer means by it."""

import math

import pytest

from rotor_ida import DimensionalRotor, InputError, machine_from_data_sheet
from rotor_ida.model.data_sheet import GRAVITY, implausible, overridden

RPM = math.pi / 30.0
PUMP = {"mass": 12.0, "shaft_stiffness": 4e6, "damping_ratio": 0.03, "clearance": 1.5e-4,
        "eccentricity": 1.7e-5, "speed": 3600 * RPM, "contact_stiffness": 1e8}  # fmt: skip


def changed(**other: object) -> DimensionalRotor:
    return machine_from_data_sheet(**overridden(PUMP, other))


def test_a_critical_speed_is_that_of_disc_and_shaft():
    machine = changed(critical_speed="5513 rpm")
    assert machine.shaft_stiffness == pytest.approx(12.0 * (5513 * RPM) ** 2, rel=1e-14)
    assert machine.critical_speed == pytest.approx(5513 * RPM, rel=1e-14)


def test_the_damping_ratio_is_of_the_critical_speed():
    """Half the width of the resonance over the critical speed, not over the contact's frequency."""
    machine = changed(damping_ratio="3%")
    assert machine.damping == pytest.approx(2 * 0.03 * 12.0 * math.sqrt(4e6 / 12.0), rel=1e-14)
    assert machine.damping_ratio == pytest.approx(0.03, rel=1e-14)
    rotor = machine.rotor()
    assert rotor.zeta / math.sqrt(rotor.shaft_stiffness) == pytest.approx(0.03, rel=1e-13)


@pytest.mark.parametrize(
    ("given", "eccentricity"),
    [({"eccentricity": "17um"}, 1.7e-5),
     ({"unbalance": "204 g mm"}, 1.7e-5),
     ({"unbalance": 2.04e-4}, 1.7e-5),
     ({"balance_grade": "G6.3", "balance_speed": "3000rpm"}, 6.3e-3 / (3000 * RPM)),
     ({"balance_grade": 2.5, "balance_speed": "50Hz"}, 2.5e-3 / (100 * math.pi)),
     ({"balance_grade": "6.3mm/s", "balance_speed": 300.0}, 2.1e-5)],
)  # fmt: skip
def test_an_unbalance_may_be_given_in_the_ways_of_engineers(given, eccentricity):
    """ISO 21940: G is eccentricity times speed in mm/s."""
    assert changed(**given).eccentricity == pytest.approx(eccentricity, rel=1e-14)


@pytest.mark.parametrize(
    ("stiffness", "exponent"),
    [("1e8 N/m", 1.0), ("100 N/µm", 1.0), ("1e8N/m^1.5", 1.5), (1e8, 1.5)],
)
def test_the_unit_of_its_stiffness_tells_the_law_of_contact(stiffness, exponent):
    machine = changed(contact_stiffness=stiffness)
    assert (machine.contact_stiffness, machine.contact_exponent) == (1e8, exponent)


def test_a_load_may_be_the_weight():
    assert changed(load="weight").load == 12.0 * GRAVITY
    assert changed(load="0.1 kN").load == 100.0


@pytest.mark.parametrize(
    ("given", "message"),
    [({"damping_ratio": 0.1, "damping": 3.0}, "damping must be left out with damping_ratio"),
     ({"damping_ratio": -0.1}, "damping_ratio must be zero or positive, got -0.1"),
     ({"shaft_stiffness": 0.0}, "damping_ratio is of the critical speed, and needs shaft_stiff"),
     ({"balance_grade": 6.3}, "balance_speed must be given with balance_grade, got None"),
     ({"balance_speed": 300.0}, "balance_grade must be given with balance_speed, got None"),
     ({"balance_grade": "G6.3", "balance_speed": 0.0}, "balance_speed must be positive, got 0.0"),
     ({"balance_grade": "6.3um", "balance_speed": 1.0}, "the unit of balance_grade must be m/s or"),
     ({"contact_stiffness": "1e8N/m", "contact_exponent": 1.5},
      r"the unit of contact_stiffness must be N/m\^1.5 with contact_exponent 1.5, got '1e8N/m'"),
     ({"friction": "12 N"}, "the unit of friction must be left out, got '12 N'"),
     ({"friction": 0.1}, "disc_radius must be given with friction"),
     ({"mass": True}, "mass must be a finite real number, got True"),
     ({"mass": "-12kg"}, "mass must be positive, got -12.0"),
     ({"clearance": "0,4mm"}, "clearance must have no comma, got '0,4mm': write '0.4mm' with a"),
     ({"clearance": "0,175mm"}, "clearance .*, got '0,175mm': write '0.175mm' with a"),
     ({"speed": "1,450rpm"}, "speed .*, got '1,450rpm': write '1450rpm' if it")],
)  # fmt: skip
def test_what_cannot_be_is_refused(given, message):
    with pytest.raises(InputError, match=f"^{message}"):
        machine_from_data_sheet(**(PUMP | given if len(given) > 1 and "damping" in given else
                                   overridden(PUMP, given)))  # fmt: skip


def test_what_is_unlikely_is_told_and_a_pump_is_not():
    assert implausible(changed(contact_stiffness="1e8N/m", load="weight")) == []
    told = " ".join(implausible(changed(
        damping_ratio=0.5, friction=2.0, disc_radius=1e-4, contact_stiffness="1e6N/m",
        eccentricity=2e-4, load="1kN",
    )))  # fmt: skip
    for word in ("damping_ratio", "clearance 150 um is below", "load bends the shaft by 250 um",
                 "stiffness of the shaft", "G75.4", "friction is 2", "a tenth"):  # fmt: skip
        assert word in told
    for speed, times in (("1.45rpm", 0.000263), ("200000rpm", 36.3)):
        (told,) = implausible(changed(speed=speed, contact_stiffness="1e8N/m", eccentricity=1e-6))
        assert told.startswith(f"speed is {times:g} times the critical speed")
    assert "only the contact supports" in implausible(changed(shaft_stiffness=0.0, damping=1.0))[0]
