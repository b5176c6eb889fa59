"""Every verb of one disc takes a machine: in SI units, as the same rotor without dimensions.

The scales are those of the paper's Eq. (9), computed here: ``omega_0**2 = k sqrt(D)/m``.
"""

import math

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import DimensionalRotor, Rotor

D, M, K = 1e-6, 4.0, 1e9
W = math.sqrt(K * math.sqrt(D) / M)
F = K * D**1.5
SCALES = {
    "1": 1.0,
    "m": D,
    "s": 1.0 / W,
    "m s-1": D * W,
    "s-1": W,
    "N": F,
    "J": F * D,
    "N s": F / W,
}
STATE = np.array([D, D, D * W, D * W])
ROTOR = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
RUBBING = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
LOADED = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.5, load=0.3)
START = np.array([0.5, -0.3, 0.2, 0.4])


def machine_of(rotor):
    return DimensionalRotor(
        mass=M, contact_stiffness=K, eccentricity=D, speed=rotor.omega * W,
        damping=2.0 * M * W * rotor.zeta, clearance=rotor.delta0 * D,
        shaft_stiffness=rotor.shaft_stiffness * M * W**2, load=rotor.load * F,
        friction=rotor.friction,
        disc_radius=None if rotor.disc_radius is None else rotor.disc_radius * D,
    )  # fmt: skip


# Each verb: its rotor, then each argument without dimensions, and its scale where it has one.
VERBS = {
    "simulate": (ROTOR, {"start": (START, STATE), "duration": (20.0, 1 / W)}),
    "simulate at times": (
        ROTOR, {"duration": (9.0, 1 / W), "samples": (np.array([0.0, 4.0, 9.0]), 1 / W)},
    ),
    "run_up by rate": (
        ROTOR, {"to": (3.0, W), "rate": (0.1, W**2), "samples": (50, None), "rtol": (1e-9, None)},
    ),
    "run_up in time": (
        ROTOR, {"to": (1.0, W), "ramp_time": (10.0, 1 / W), "duration": (12.0, 1 / W)},
    ),
    "run_up by speeds": (ROTOR, {"speeds": (np.array([[0.0, 2.0], [9.0, 2.5]]), [1 / W, W])}),
    "run_up by torque": (ROTOR, {
        "torque": (np.array([3.0, 0.5]), [F * D, F * D / W]), "inertia": (10.0, M * D**2),
        "duration": (10.0, 1 / W),
    }),
    "poincare_section": (ROTOR, {"start": (START, STATE), "revolutions": (5, None)}),
    "lyapunov_exponent": (
        ROTOR, {"start": (START, STATE), "transient": (20.0, 1 / W), "duration": (80.0, 1 / W),
                "batches": (4, None)},
    ),
    "limit_cycle": (
        ROTOR, {"start": (np.array([2.6, 0.75, 0.66, -1.65]), STATE), "period": (4.5, 1 / W)},
    ),
    "continue_cycle": (ROTOR, {"limits": ((1.98, 2.02), W), "points": (5, None)}),
    "continue_cycle over the clearance": (
        ROTOR, {"limits": ((1.98, 2.02), D), "parameter": ("delta0", "clearance"),
                "points": (5, None)},
    ),
    "basin": (ROTOR, {
        "x": (np.linspace(-5.0, 5.0, 4), D), "y": (np.linspace(-5.0, 5.0, 3), D),
        "vx": (0.5, D * W),
    }),
    "basin_fractions": (
        ROTOR, {"x": ((-5.0, 5.0), D), "y": (1.0, D), "vy": ((-2.0, 2.0), D * W),
                "starts": (40, None)},
    ),
    "touchdown_report": (
        ROTOR, {"x": ((-5.0, 5.0), D), "y": ((-5.0, 5.0), D), "starts": (40, None),
                "shocks": (0, None)},
    ),
    "rest": (LOADED, {}),
    "backward_whirl": (RUBBING, {}),
}  # fmt: skip


def scaled(value, scale):
    """The value as a user of the machine gives it; a word of a scale is the machine's own name."""
    if scale is None or isinstance(scale, str):
        return scale or value
    if isinstance(value, tuple):
        return tuple(np.multiply(value, scale).tolist())
    return np.multiply(value, scale) if np.ndim(value) else value * scale


@pytest.mark.parametrize("name", VERBS)
def test_a_machine_is_its_rotor_in_si_units(name):
    rotor, asked = VERBS[name]
    verb = getattr(rotor_ida, name.split()[0])
    plain = verb(rotor, **{each: value for each, (value, _) in asked.items()})
    in_si = verb(machine_of(rotor), **{each: scaled(*both) for each, both in asked.items()})
    assert set(in_si.variables) == set(plain.variables)
    for each, variable in in_si.variables.items():
        if variable.dtype.kind != "f":
            xr.testing.assert_equal(variable, plain.variables[each])
            continue
        here = variable.values / SCALES.get(variable.attrs["units"], 1.0)
        there = plain.variables[each].values
        size = np.max(np.abs(there), initial=1e-9, where=np.isfinite(there))
        if each.endswith(("error", "residual", "defect")):  # of rounding
            continue
        np.testing.assert_allclose(here, there, rtol=0, atol=1e-7 * size, err_msg=each)
    for each, (value, scale) in asked.items():
        if each in in_si.attrs and scale is not None and not isinstance(scale, str):
            expected = np.ravel(np.multiply(value, scale))
            np.testing.assert_allclose(in_si.attrs[each], expected, rtol=1e-12)
            assert in_si.attrs[f"{each}_units"]


def test_a_curve_of_folds_of_a_machine_has_limits_in_its_units():
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    asked = {"start": (3.0, 1.0, 0.0, 0.0), "kind": "fold", "points": 4}
    limits = {"omega": (2.4, 3.2), "delta0": (0.45, 0.55)}
    plain = rotor_ida.bifurcation_curve(rotor, **asked, limits=limits)
    asked["start"] = tuple(asked["start"] * STATE)
    in_si = rotor_ida.bifurcation_curve(
        machine_of(rotor), **asked, parameters=("speed", "clearance"),
        limits=((2.4 * W, 3.2 * W), (0.45 * D, 0.55 * D)),
    )  # fmt: skip
    np.testing.assert_allclose(in_si.omega, plain.omega, rtol=1e-9)
    np.testing.assert_allclose(in_si.period * W, plain.period, rtol=1e-9)
    assert in_si.attrs["limits"] == pytest.approx([2.4 * W, 3.2 * W, 0.45 * D, 0.55 * D], rel=1e-12)


def test_a_machine_touches_when_its_flight_reaches_the_clearance():
    """From rest the flight is linear, ``Z = c + d exp(-n T/m) + a exp(i W T)``: by hand in SI."""
    mass, damping, eccentricity, speed, clearance = 4.0, 280.0, 1e-6, 600.0, 5e-7
    machine = DimensionalRotor(mass=mass, contact_stiffness=1e9, damping=damping,
                               eccentricity=eccentricity, clearance=clearance,
                               speed=speed)  # fmt: skip
    run = rotor_ida.simulate(machine, duration=0.04)
    decay = damping / mass
    whirl = -eccentricity * speed / (speed - 1j * decay)
    fades = 1j * speed * whirl / decay
    time = run.event_time.values[0]
    place = -whirl - fades + fades * np.exp(-decay * time) + whirl * np.exp(1j * speed * time)
    assert abs(place) == pytest.approx(clearance, rel=1e-12)
    assert (run.event_time.attrs["units"], run.attrs["duration"]) == ("s", 0.04)


def test_a_cycle_of_a_machine_starts_its_branch():
    machine = machine_of(ROTOR)
    cycle = rotor_ida.limit_cycle(machine)
    branch = rotor_ida.continue_cycle(machine, start=cycle, limits=(1.98 * W, 2.02 * W), points=5)
    assert branch.attrs["start_period"] == pytest.approx(cycle.period.item(), rel=1e-12)
    plain = rotor_ida.continue_cycle(ROTOR, start=cycle, limits=(1.98, 2.02), points=5)
    np.testing.assert_allclose(branch.period * W, plain.period, rtol=1e-12)


def test_a_start_of_a_machine_with_other_scales_keeps_its_metres():
    one = machine_of(ROTOR)
    run = rotor_ida.simulate(one, start=START * STATE, duration=0.02)
    other = DimensionalRotor(**{**one.given, "eccentricity": 2.0 * D})
    plain = rotor_ida.results.si_units.rescaled(run, other)
    np.testing.assert_allclose(plain.x * other.length_scale, run.x, rtol=1e-12)
    np.testing.assert_allclose(plain.t * other.time_scale, run.t, rtol=1e-12)
