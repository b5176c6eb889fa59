"""Closed forms over extreme parameters: a result or one line, and right where damping is slight."""

import random

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, synchronous_response
from rotor_ida import closed_forms as exact

# Ranges from which parameters are drawn evenly in their logarithm.
RANGES = {
    "zeta": (-20, 3), "delta0": (-6, 6), "omega": (-6, 6), "shaft_stiffness": (-12, 12),
    "friction": (-3, 0), "contact_damping": (-3, 1),
}  # fmt: skip
SOMETIMES = {"shaft_stiffness": 0.5, "friction": 0.3, "contact_damping": 0.15}


def drawn(chance):
    given = {name: 10.0 ** chance.uniform(*ends) for name, ends in RANGES.items()}
    absent = [name for name, often in SOMETIMES.items() if chance.random() > often]
    return given | dict.fromkeys(absent, 0.0) | {"contact_exponent": chance.choice([1.0, 1.5])}


def calls(machine, chance):
    """Each closed form of a machine, as a function without arguments."""
    over_speed = {name: each for name, each in machine.items() if name != "omega"}
    elastic = {name: each for name, each in over_speed.items() if name != "contact_damping"}
    law = {name: machine[name] for name in ("shaft_stiffness", "contact_exponent", "delta0")}
    undamped = {name: each for name, each in over_speed.items() if name != "zeta"}
    at_speed = {name: each for name, each in machine.items() if name != "delta0"}
    disc = {"disc_radius": 10.0} if machine["friction"] > 0.0 else {}
    rotor = Rotor(**machine, **disc)
    low = 10.0 ** chance.uniform(-5, 4)
    limits, amplitude = (low, low * 10.0 ** chance.uniform(0.1, 4)), 10.0 ** chance.uniform(-6, 6)
    curve = {"limits": limits, "points": 20}
    rotor_only = exact.backward_whirl, exact.contact_free_whirl, exact.touch_fading
    of_law = (
        exact.backbone, exact.planar_period, exact.circular_period, exact.centre_speed,
        exact.amplitude_from_speed,
    )  # fmt: skip
    return [
        lambda: exact.response_curve(**over_speed, **curve),
        lambda: exact.sommerfeld_curve(**over_speed, **curve, inertia=10.0, **disc),
        lambda: exact.clearance_curve(**at_speed, **curve),
        lambda: exact.peaks(**elastic),
        lambda: exact.speeds_at_amplitude(amplitude, **elastic),
        lambda: exact.folds(**over_speed),
        lambda: exact.jumps(**over_speed),
        lambda: exact.hopf_points(**over_speed),
        lambda: exact.late_jumps(rate=1e-3, **over_speed),
        lambda: exact.cusp(**undamped),
        lambda: exact.synchronous_response(**machine),
        lambda: exact.eigenvalues(amplitude, **machine),
        lambda: exact.stability_determinant(amplitude, **machine),
        lambda: exact.flight([0.0, amplitude], rotor=rotor),
        *(lambda form=form: form(rotor) for form in rotor_only),
        *(lambda form=form: form(amplitude, **law) for form in of_law),
        lambda: exact.rest(Rotor(omega=0.0, zeta=machine["zeta"], load=amplitude, **law)),
        lambda: exact.touch_speeds(zeta=machine["zeta"], delta0=machine["delta0"]),
    ]


@pytest.mark.parametrize("seed", range(2))
def test_extreme_parameters_give_a_result_or_one_line(seed):
    """Neither another exception nor a warning, which the tests make an exception."""
    chance, answered = random.Random(seed), 0
    lines: list[str] = []
    for _ in range(8):
        machine = drawn(chance)
        for call in calls(machine, chance):
            try:
                call()
                answered += 1
            except InputError as error:
                lines.append(str(error))
    assert answered > 100
    assert "\n" not in "".join(lines)


@pytest.mark.parametrize("zeta", [1e-9, 1e-12, 1e-15, 1e-18, 1e-20])
@pytest.mark.parametrize("kappa", [0.0, 0.01, 100.0])
@pytest.mark.parametrize("delta0", [0.0, 0.5, 1.6, 10.0])
def test_the_tip_of_a_linear_ring_is_the_resonance_of_shaft_and_ring(zeta, kappa, delta0):
    """With ``w**2 = 1 + kappa``: amplitude w/(2 zeta) at speed w, less a part of order zeta.

    The clearance takes ``delta0/(2 w**2)`` from the amplitude.
    """
    machine = {"zeta": zeta, "delta0": delta0, "shaft_stiffness": kappa, "contact_exponent": 1.0}
    found, natural = exact.peaks(**machine).squeeze(), np.sqrt(1.0 + kappa)
    tip = natural / (2.0 * zeta) - delta0 / (2.0 * natural**2)
    assert float(found.peak_amplitude) == pytest.approx(tip, rel=1e-14 + (20.0 * zeta) ** 2)
    slower = 2.0 * delta0 * zeta / natural**3  # by s = 1 + kappa - delta0/A at the tip
    assert float(found.peak_omega) == pytest.approx(natural, rel=1e-14 + slower)
    curve = exact.response_curve(**machine, limits=(0.05, 11.0), points=50)
    assert float(curve.amplitude.max()) == pytest.approx(tip, rel=1e-9)


@pytest.mark.parametrize(("zeta", "omega"), [(3e-19, 5000.7), (1e-12, 2.0)])
def test_whirls_over_the_clearance_are_those_of_each_rotor_also_with_slight_damping(zeta, omega):
    limits = 1.0, 1e4
    curve = exact.clearance_curve(zeta=zeta, omega=omega, limits=limits, points=30).squeeze()
    touching = np.flatnonzero(curve.in_contact.values == 1)[::5]
    assert touching.size > 3
    for place in touching.tolist():
        delta0, amplitude = float(curve.delta0[place]), float(curve.amplitude[place])
        whirls = synchronous_response(zeta=zeta, omega=omega, delta0=delta0).amplitude.values
        assert np.nanmin(np.abs(whirls / amplitude - 1.0)) < 1e-9
