"""Rotor and DimensionalRotor: what they accept, and that the scales are the right ones."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotor_ida import DimensionalRotor, InputError, Rotor, dimensional, simulate

MACHINE = DimensionalRotor(
    mass=3.0,
    contact_stiffness=2.5e9,
    damping=40.0,
    eccentricity=4e-6,
    clearance=3e-6,
    speed=1500.0,
)


@pytest.mark.parametrize("name", ["omega", "zeta", "delta0"])
@pytest.mark.parametrize(
    "value", [math.nan, math.inf, -math.inf, True, np.True_, "1", None, 1j, [1.0], 10**400]
)
def test_a_rotor_refuses_what_is_not_a_finite_real_number(name, value):
    parameters = {"omega": 1.0, "zeta": 0.1, "delta0": 0.5, name: value}
    with pytest.raises(InputError, match=rf"^{name} must be a finite real number, got .+$"):
        Rotor(**parameters)


@pytest.mark.parametrize("name", ["omega", "zeta", "delta0"])
def test_a_rotor_refuses_negatives(name):
    with pytest.raises(InputError, match=rf"^{name} must be zero or positive, got -0.5$"):
        Rotor(**{"omega": 1.0, "zeta": 0.1, "delta0": 0.5, name: -0.5})


def test_a_rotor_is_frozen_and_keyword_only():
    rotor = Rotor(omega=np.float64(1), zeta=np.int64(0), delta0=-0.0)
    assert rotor == Rotor(omega=1.0, zeta=0.0, delta0=0.0)
    assert math.copysign(1.0, rotor.delta0) == 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        rotor.omega = 2.0
    with pytest.raises(TypeError):
        Rotor(1.0, 0.1, 0.5)


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
    with pytest.raises(InputError, match=rf"^{name} must be positive, got 0.0$"):
        DimensionalRotor(**values)


def test_scaling_with_k_sqrt_D_over_m_reproduces_the_dimensional_equation():
    """The paper prints omega_0**2 = k/m; only k sqrt(D)/m maps one equation to the other."""

    def newton(time, state):
        x, y, vx, vy = state
        radius = math.hypot(x, y)
        depth = max(radius - MACHINE.clearance, 0.0)
        force = MACHINE.contact_stiffness * depth**1.5 / (radius or 1.0)
        push = MACHINE.mass * MACHINE.eccentricity * MACHINE.speed**2
        angle = MACHINE.speed * time
        return [
            vx,
            vy,
            (push * math.cos(angle) - MACHINE.damping * vx - force * x) / MACHINE.mass,
            (push * math.sin(angle) - MACHINE.damping * vy - force * y) / MACHINE.mass,
        ]

    run = dimensional(
        simulate(MACHINE.rotor(), start=(0, 0, 0, 0), duration=20.0, samples=41, rtol=1e-12),
        MACHINE,
    )
    times = run.t.values
    scale = MACHINE.length_scale
    reference = solve_ivp(
        newton,
        (0.0, times[-1]),
        [0.0] * 4,
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-13 * scale,
        max_step=0.01 * MACHINE.time_scale,
    )
    assert np.abs(run.x.values - reference.y[0]).max() < 1e-9 * scale
    assert np.abs(run.vy.values - reference.y[3]).max() < 1e-9 * MACHINE.velocity_scale
    deepest = MACHINE.contact_stiffness * run.peak_indentation.values**1.5
    assert run.peak_force.values == pytest.approx(deepest, rel=1e-12)
    assert run.peak_force.attrs["units"] == "N"
    with pytest.raises(InputError, match="SI units already"):
        dimensional(run, MACHINE)
