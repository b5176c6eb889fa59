"""Every verb of one disc takes a machine: in SI units, as the same rotor without dimensions.

The scales are those of the paper's Eq. (9), computed here: ``omega_0**2 = k sqrt(D)/m``.
"""

import dataclasses
import math
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    bifurcation_curve,
    continue_cycle,
    resume,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.results.si_units import rescaled

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


# Each verb: its rotor, then each argument without dimensions, and its scale where it has one, after
# its name for a machine where that is another.
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
    "limit_cycle over the speed": (ROTOR, {
        "omega": (np.array([1.9, 2.0]), ("speed", W)), "start": ("rest", None),
    }),
    "lyapunov_exponent over the damping": (
        ROTOR, {"zeta": (np.array([0.07, 0.1]), ("damping", 2 * M * W)),
                "transient": (20.0, 1 / W), "duration": (80.0, 1 / W), "batches": (4, None)},
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
        dataclasses.replace(ROTOR, friction=0.1, disc_radius=10.0),
        {"x": ((-5.0, 5.0), D), "y": ((-5.0, 5.0), D), "starts": (20, None), "shocks": (0, None)},
    ),
    "sweep": (ROTOR, {
        "omega": (np.array([1.6, 2.0]), ("speed", W)), "zeta": (0.1, ("damping", 2 * M * W)),
        "starts": (np.array([START, 2 * START]), STATE),
    }),
    "sweep up": (ROTOR, {
        "delta0": (np.array([1.9, 2.0]), ("clearance", D)), "direction": ("up", None),
        "along": ("delta0", "clearance"),
    }),
    "run_ups": (LOADED, {
        "omega": (0.3, ("speed", W)), "to": (0.6, W), "rate": (np.array([0.05, 0.1]), W**2),
        "load": (np.array([0.0, 0.1]), F), "zeta": (0.2, ("damping", 2 * M * W)),
    }),
    "bifurcation_diagram": (ROTOR, {
        "omega": (np.array([1.6, 2.0]), ("speed", W)), "zeta": (0.2, ("damping", 2 * M * W)),
        "extrema_time": (20.0, 1 / W), "starts": (2, None),
    }),
    "bifurcation_diagram at revolutions": (
        ROTOR, {"starts": (1, None), "at": ("revolution", None), "revolutions": (3, None)}
    ),
    "continue_attractors": (ROTOR, {
        "omega": (np.array([1.6, 2.0]), ("speed", W)), "x": ((-5.0, 5.0), D), "y": (1.0, D),
        "starts": (20, None),
    }),
    "synchronous_response": (ROTOR, {
        "omega": (np.array([1.7, 2.0]), ("speed", W)),
        "contact_damping": (np.array([0.0, 0.2]), 1 / (D * W)),
        "shaft_stiffness": (0.1, M * W**2),
    }),
    "folds": (ROTOR, {"delta0": (np.array([0.5, 1.0]), ("clearance", D))}),
    "hopf_points": (RUBBING, {"friction": (np.array([0.1, 0.2]), 1.0)}),
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
    named = {
        each: (scale[0], value, scale[1]) if isinstance(scale, tuple) else (each, value, scale)
        for each, (value, scale) in asked.items()
    }
    in_si = verb(machine_of(rotor), **{each: scaled(*both) for each, *both in named.values()})
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
    for each, value, scale in named.values():
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
    plain = rescaled(run, other)
    np.testing.assert_allclose(plain.x * other.length_scale, run.x, rtol=1e-12)
    np.testing.assert_allclose(plain.t * other.time_scale, run.t, rtol=1e-12)


@pytest.mark.parametrize(
    ("verb", "asked", "message"),
    [
        ("simulate", {"duration": -0.5}, "duration must be positive, got -0.5 s"),
        ("simulate", {"duration": 1.0, "start": (30.0, 0, 0, 0)},
         "start x must lie within 1 m of zero, got 30 m"),
        ("simulate", {"duration": 1e30},
         "duration must be below 8.58993e+06 s at speed 1000 rad/s, so that doubles resolve a "
         "revolution, got 1e+30 s"),
        ("simulate", {"duration": 0.1, "samples": [0.0, 0.2]},
         "samples must lie from 0 to the duration 0.1 s, got 0.2 s"),
        ("run_up", {"to": 900.0, "rate": 3.0},
         "rate must be negative to change the speed from 1000 rad/s to 900 rad/s, got 3 rad/s2"),
        ("run_up", {"torque": (1.0, 0.1), "inertia": 1e-16, "duration": 1.0},
         "inertia must be at least 1e-09 kg m2 with torque (1 N m, 0.1 N m s) and duration 1 s, or "
         "the run would take an hour or more, got 1e-16 kg m2"),
        ("limit_cycle", {"period": 100.0}, "period must lie from 2e-09 s to 20 s, got 100 s"),
        ("continue_cycle", {"parameter": "clearance", "limits": (3e-6, 4e-6)},
         "limits of clearance must contain that of the start, 2e-06 m, got (3e-06 m, 4e-06 m)"),
        ("basin", {"x": [0.0, -1e-6], "y": [0.0, 1e-6]}, "x must increase, got -1e-06 m after 0"),
        ("simulate", {"duration": 1.0, "mass": 3.0}, "mass must be left out, as it sets the scales "
         "of all results: give a machine with another one"),
    ],
)  # fmt: skip
def test_an_error_about_a_machine_is_in_si_units(verb, asked, message):
    with pytest.raises(rotor_ida.InputError) as refused:
        getattr(rotor_ida, verb)(machine_of(ROTOR), **asked)
    assert str(refused.value) == message


def test_an_error_carries_name_value_and_unit_across_processes():
    with pytest.raises(rotor_ida.InputError) as refused:
        rotor_ida.simulate(machine_of(ROTOR), duration=-0.5)
    error = pickle.loads(pickle.dumps(refused.value))
    assert (error.name, error.value, error.value.unit) == ("duration", -0.5, "s")
    assert str(error) == str(refused.value)


MACHINE = machine_of(Rotor(omega=1.2, zeta=0.07, delta0=2.0))


def test_a_start_from_another_machine_is_turned_back_by_its_own_angle():
    run = simulate(MACHINE, duration=0.1)
    stiffer = dataclasses.replace(MACHINE, contact_stiffness=2e9, eccentricity=2e-6)
    end = complex(run.x[-1].item(), run.y[-1].item()) * np.exp(-0.1j * MACHINE.speed)
    begun = simulate(stiffer, start=run, duration=0.01).attrs["start"]
    np.testing.assert_allclose(begun[:2], [end.real, end.imag], rtol=1e-9)


def test_a_study_keeps_its_units(tmp_path: Path):
    plain = sweep(MACHINE.rotor(), study=tmp_path / "plain")
    with pytest.raises(InputError, match=r"study must be of a machine, got .* without dimensions"):
        sweep(MACHINE, study=tmp_path / "plain")
    assert resume(tmp_path / "plain").identical(plain)
    with pytest.raises(InputError, match="speed must be zero or positive, got -1 rad/s"):
        sweep(MACHINE, speed=[-1.0], study=tmp_path / "refused")
    assert not [*(tmp_path / "refused").iterdir()]
    sweep(MACHINE, study=tmp_path / "refused")


@pytest.mark.parametrize(
    ("call", "error", "line"),
    [
        (lambda: sweep(MACHINE, rotor=MACHINE), TypeError, "multiple values"),
        (lambda: simulate(MACHINE, speed=1.0, duration=0.1), InputError,
         "speed must be left out with one disc, got 1.0"),
        (lambda: continue_cycle(MACHINE, parameter="mass", limits=(3.0, 5.0)), InputError,
         "parameter must be one of"),
        (lambda: simulate(MACHINE.system(), duration=0.1), TypeError, "needs speed"),
        (lambda: sweep(MACHINE, clearance=[[1e-6]]), InputError,
         "clearance must be a number or a vector of numbers, got an array of shape"),
        (lambda: sweep(MACHINE, speed=[600.0, 700.0], direction="up", along="sped"), InputError,
         "along must be one of 'speed', 'damping', 'clearance', got 'sped'; did you mean 'speed'"),
        (lambda: sweep(MACHINE, clearance=[1e-6, 2e-6], damping=[2.0, 3.0], direction="up"),
         InputError, "as damping and clearance vary"),
        (lambda: sweep(MACHINE, clearence=1e-6), InputError, "did you mean 'clearance'"),
        (lambda: simulate(MACHINE, durtion=0.1), TypeError, "did you mean 'duration'"),
        (lambda: continue_cycle(MACHINE, parameter="clearence", limits=(1e-6, 2e-6)), InputError,
         "parameter must be one of 'speed', 'damping', 'clearance', .*did you mean 'clearance'"),
        (lambda: bifurcation_curve(MACHINE, kind="fold", parameters=("speed", "clearence"),
                                   limits=((1.0, 2.0), (1.0, 2.0))), InputError,
         "parameters must be two of 'speed', .* got 'speed', 'clearence'"),
        (lambda: bifurcation_curve(MACHINE, kind="fold", parameters=("speed", "clearance"),
                                   limits={"speed": (1.0, 2.0)}), InputError,
         "limits must be of speed and clearance, got those of speed"),
        (lambda: simulate(MACHINE, start=synchronous_response(MACHINE), duration=0.1), InputError,
         "as a run, a limit cycle or one point of a sweep of one disc does, got: exact whirls"),
    ],
)  # fmt: skip
def test_wrong_calls_get_one_line(call: Callable[[], object], error: type[Exception], line: str):
    with pytest.raises(error, match=line):
        call()
