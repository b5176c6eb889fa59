"""What functions refuse: the call, what is wrong in it, and how the line begins that says so."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Support,
    Unbalance,
    basin_fractions,
    bifurcation_diagram,
    campbell,
    continue_attractors,
    drop,
    hopf_points,
    impact,
    limit_cycle,
    run_up,
    run_ups,
    simulate,
    sweep,
    synchronous_response,
    touchdown_report,
)
from rotor_ida.closed_forms import (
    clearance_curve,
    peaks,
    ramp_flight,
    response_curve,
    restoring_field,
    sommerfeld_curve,
)
from tests.basins.atlas.reports import BOX
from tests.cycles.known import BOUNCING, REST

TOUCH = {"node": "disc", "clearance": 0.1, "stiffness": 10.0}
SYSTEM = {"mass": np.eye(4), "stiffness": 2.0 * np.eye(4), "nodes": {"disc": (0, 1), "end": (2, 3)}}
TURNED = DimensionalRotor(mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5,
                          clearance=8e-6, speed=60.0, shaft_stiffness=2e3)  # fmt: skip
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=1000.0
)

# fmt: off
REFUSED = [
    (lambda given: hopf_points(**{"zeta": 0.07, "delta0": 0.5, "contact_damping": 0.5} | given), [
        ({"zeta": -0.1}, "zeta must be zero or positive, got -0.1"),
        ({"delta0": 0.0}, "contact_damping must be 0 without clearance"),
        ({"contact_exponent": 2.0}, "contact_exponent must be 1.5 or 1, got 2.0"),
        ({"contact_damping": 1e9}, "contact_damping must be 0 or between 1e-20 and 1e"),
        ({"friction": 1e9}, "friction must be 0 or between 1e-20 and 1e"),
    ]),
    (lambda given: impact(**{"entry_speed": 1.0, "contact_damping": 0.5, **given}), [
        ({"entry_speed": -1.0}, "entry_speed must be zero or positive, got -1.0"),
        ({"contact_damping": np.nan}, "contact_damping must be a finite real number, got nan"),
        ({"contact_exponent": [1.5, 2.0]}, "contact_exponent must be 1.5 or 1, got 2.0"),
        ({"entry_speed": 1e-200}, "entry_speed must be 0 or between 1e-100 and 1e\\+15"),
    ]),
    (lambda given: peaks(**{"zeta": 0.1, "delta0": 0.5, **given}), [
        ({"zeta": 0.0}, "zeta must be positive"),
        ({"delta0": 0.0, "friction": 0.1}, "friction must be 0 without clearance"),
        ({"friction": 1e-30}, "friction must be 0 or between"),
    ]),
    (lambda given: ramp_flight(**{"time": 1.0, "rotor": Rotor(omega=1.0, zeta=0.1, delta0=1.0),
        "start": (0.3, 0.1, 0.2, -0.1)} | {"rate": 0.1} | given), [
        ({"rate": 0.0}, "the size of rate must be positive, got 0.0"),
        ({"time": [1.0, -1.0]}, "time must not be negative, got -1.0"),
        ({"rotor": Rotor(omega=1.0, zeta=1.0, delta0=1.0, shaft_stiffness=1.0)}, "zeta"),
        ({"rotor": Rotor(omega=1.0, zeta=0.1, delta0=1.0, load=1.0)}, "load must be 0"),
        ({"time": 1e9}, "the angle must be at most"),
    ]),
    (lambda given: response_curve(zeta=0.07, delta0=0.0, limits=given), [
        ((1.0, 1.0), "limits must be two numbers, the lower first"),
        ((1.0), "limits must be two numbers, the lower first"),
        ((-1.0, 1.0), "limits must be zero or positive"),
        ((0.0, 1e16), "limits must be .* 1e\\+15"),
    ]),
    (lambda given: response_curve(**{"zeta": 0.1, "delta0": 0.5, "limits": (0.05, 4.0), **given}), [
        ({"zeta": [0.0, 0.1], "contact_exponent": 1.0}, "zeta must be positive for the curve"),
    ]),
    (lambda given: clearance_curve(**{"omega": 1.0, "zeta": 0.1, "limits": (0.0, 1.0), **given}), [
        ({"omega": 0.0}, r"omega must be positive, got 0\.0"),
        ({"zeta": 0.0, "contact_exponent": 1.0}, "zeta must be positive for the curve of a linear"),
        ({"contact_damping": 1.0}, "contact_damping must be 0 without clearance"),
        ({"friction": 0.1}, "friction must be 0 without clearance"),
    ]),
    (lambda given: restoring_field(**{"x": 0.0, "y": 0.0, "delta0": 0.0, **given}), [
        ({"x": np.nan}, "x must be a finite real number, got nan"),
        ({"y": []}, "y must contain at least one number"),
        ({"delta0": -1.0}, "delta0 must be zero or positive"),
    ]),
    (lambda given: sommerfeld_curve(**{"zeta": 0.1, "delta0": 1.0, "limits": (0.1, 2.0), "inertia":
        1.0} | given), [
        ({"inertia": 0.0}, "inertia"),
        ({"inertia": -1.0}, "inertia"),
        ({"slope": -0.1}, "slope"),
        ({"friction": 0.1}, "disc_radius must be given with friction 0.1, got None"),
    ]),
    (lambda given: synchronous_response(**{"omega": 1.0, "zeta": 0.1, "delta0": 0.0, **given}), [
        ({"omega": 1e-60}, "omega must be 0 or between 1e-50 and 1e\\+15, got 1e-60"),
        ({"delta0": 1e16}, "delta0 must be at most 1e\\+15, got 1e\\+16"),
    ]),
    (lambda given: synchronous_response(**{**{"omega": 1.0, "zeta": 0.1, "delta0": 0.5}, **given}),
        [
        ({"shaft_stiffness": [0.1, np.nan]}, "shaft_stiffness must be a finite real number"),
        ({"contact_exponent": 2.0}, "contact_exponent must be 1.5 or 1, got 2.0"),
        ({"contact_damping": 1e16}, "contact_damping must .* 1e\\+15.*, got 1e\\+16"),
        ({"contact_damping": 0.1, "delta0": [0.0, 1.0]},
         "contact_damping must be 0 without clearance, .* got 0.1 with delta0 0.0"),
        ({"friction": 0.1, "delta0": 0.0},
         "friction must be 0 without clearance.*got 0.1 with delta0 0.0"),
    ]),
    (lambda given: simulate(Rotor(omega=0.6, zeta=0.07, delta0=2.0), **{"start": (0.0, 0.0, 0.0,
        0.0), "duration": 10.0, **given}), [
        ({"start": (0, 0, 0)}, r"start must be four numbers \(x, y, vx, vy\), got \(0, 0, 0\)$"),
        ({"start": (0, 0, 0, math.nan)}, "start vy must be a finite real number, got nan$"),
        ({"duration": -1.0}, "duration must be positive, got -1.0$"),
        ({"duration": math.inf}, "duration must be a finite real number, got inf$"),
        ({"samples": 1}, "samples must be at least 2, got 1$"),
        ({"samples": [0.0, 2.0, 1.0]}, "samples must increase, got 1.0 after 2.0$"),
        ({"samples": [0.0, 11.0]}, "samples must lie from 0 to the duration 10.0, got 11.0$"),
        ({"rtol": 1.0}, "rtol must lie from 1e-13 to 0.001, got 1.0$"),
        ({"atol": 0.0}, "atol must be positive, got 0.0$"),
        ({"atol": 1e-99}, "atol must lie from 1e-30 to 0.01, got 1e-99$"),
        ({"method": "rk4"}, "method must be one of 'adams', 'bdf', 'ida', 'taylor', got 'rk4'$"),
        ({"flight": "none"}, "flight must be one of 'exact', 'cvode', got 'none'$"),
        ({"backend": "gpu"}, "backend must be one of 'auto', 'python', 'compiled', got 'gpu'$"),
    ]),
    (lambda given: simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0),
        duration=1.0, method="taylor", **given), [
        ({"flight": "cvode"}, "flight must be 'exact' with taylor, got 'cvode'"),
        ({"rtol": 1e-16}, "rtol must lie from 1e-15 to 0.0001"),
        ({"backend": "python"}, "backend must be 'auto' or 'compiled' with taylor, got 'python'"),
    ]),
    (lambda given: bifurcation_diagram(**{"omega": 1.0, "zeta": 0.5, "delta0": 0.0, **given}), [
        ({"starts": 0}, "starts must be at least 1, got 0"),
        ({"x": (1.0, 0.0)}, r"x must be a range \(low, high\) with low <= high"),
        ({"extrema_time": -1.0}, "extrema_time must be positive, got -1.0"),
        ({"omega": -1.0}, "omega must be zero or positive"),
        ({"zeta": [0.5, 0.0]}, "zeta must be above 0, where nothing settles, got 0.0"),
        ({"vy": 1e308}, r"vy must lie within 1e\+06 of zero, got 1e\+308"),
        ({"extrema_time": 1e9}, "extrema_time must be at most 625000, got 1000000000.0"),
        ({"starts": 10**9}, "starts must be at most 10000000, got 1000000000"),
    ]),
    (lambda given: bifurcation_diagram(**{"omega": [1.0, 2.0], "zeta": 0.5, "delta0": 0.0,
        "direction": "up", "rate": 0.1} | given, starts=[(0.0, 0.0, 0.0, 0.0)]), [
        ({"direction": None}, "direction must be given with rate, got None"),
        ({"direction": "round"}, "direction must be"),
        ({"rate": -0.1}, "rate must"),
        ({"rate": 1e-10}, "rate must be at least"),
        ({"omega": 1.0}, "omega must be two values or more in a sweep up or down, got 1.0"),
        ({"omega": [1.0, 2.0, 2.0]}, "omega must have each value once, got 2.0 twice"),
    ]),
    (lambda given: run_ups(**{"omega": 0.3, "to": 1.6, "rate": 0.1, "zeta": 0.1, "delta0": 2.0} |
        given), [
        ({"rate": -0.1}, "rate must be positive to change the speed from 0.3 to 1.6, got -0.1"),
        ({"rate": [0.1, -0.1]}, "rate must be positive to change the speed from 0.3"),
        ({"rate": 0.0}, "rate must be positive"),
        ({"rate": []}, "rate must contain at least one number, got none"),
        ({"to": 0.3}, "to must differ from the rotor's omega 0.3, got 0.3"),
        ({"omega": [0.3, 2.0]}, "rate must be negative to change the speed from 2.0 to 1.6"),
        ({"to": -1.0}, "to must be zero or positive"),
        ({"to": [1.0, 2.0]}, "to must be a finite real number"),
        ({"to": 1e5, "rate": 1e6}, "omega must be 0 or from 0.001 to 1000 to settle"),
        ({"phase": 7.0}, "phase must lie within 6.28319 of zero, got 7.0"),
        ({"starts": []}, "starts must contain at least one start, got none"),
        ({"starts": [(1e9, 0, 0, 0)]}, "start x must lie within 1e.06 of zero"),
        ({"friction": 0.1}, "disc_radius must be given with friction"),
        ({"workers": 0}, "workers must be at least 1, got 0"),
        ({"method": "rk4"}, "method must be one of"),
    ]),
    (lambda given: sweep(**{"omega": 1.0, "zeta": 0.1, "delta0": 0.5, **given}), [
        ({"omega": []}, "omega must contain at least one number, got none$"),
        ({"starts": []}, "starts must contain at least one start, got none$"),
        ({"starts": [(0, 0)]}, r"start must be four numbers \(x, y, vx, vy\), got \(0, 0\)$"),
        ({"direction": "left"}, "direction must be one of 'up', 'down', 'both', got 'left'$"),
        ({"omega": [2.0, 1.0], "direction": "up"},
         "omega must increase in a sweep up or down, got 1.0 after 2.0$"),
        ({"delta0": [0.0, 1e-13, 2.0]},
         "delta0 must be 0 or at least 1e-12 to be simulated, got 1e-13$"),
        ({"workers": 0}, "workers must be at least 1, got 0$"),
        ({"executor": "gpu"}, "executor must be one of 'auto', 'serial', .*, got 'gpu'$"),
        ({"load": [0.0, 1e-13]}, r"load must be 0, or from 1e-12 to 1e\+06, to be simulated, .*$"),
        ({"load": 0.1, "omega": 1e-4}, "omega must be 0 or from 0.001 to 1000 to settle, .*$"),
        ({"friction": 0.2}, "disc_radius must be given with friction, .*$"),
        ({"delta0": [0.0, 1.0], "friction": [0.0, 0.2], "disc_radius": 1.0},
         "friction must be 0 without clearance, .*$"),
    ]),
    (lambda given: RotorSystem(**SYSTEM | given), [
        ({"mass": np.diag([1.0, 1.0, 1.0, 0.0])}, "mass must be positive definite"),
        ({"mass": np.arange(16.0).reshape(4, 4)}, "mass must be symmetric"),
        ({"mass": np.ones((3, 4))}, "mass must be a square matrix"),
        ({"mass": np.full((4, 4), np.nan)}, "mass must"),
        ({"stiffness": np.eye(3)}, "stiffness must have the shape of mass"),
        ({"gyroscopic": np.eye(4)}, "gyroscopic must be skew-symmetric"),
        ({"positions": {"disc": 0.1}}, "positions must map each name .* to a number, got no 'end'"),
        ({"positions": {"disc": 0.1, "endd": 0.2}}, ".*got 'endd'; did you mean 'end'"),
        ({"positions": [0.1]}, "positions must map each name of a node to a number"),
        ({"positions": {"disc": 0.1, "end": "b"}},
         "position of node 'end' must be a finite real number"),
        ({"nodes": {"disc": (0, 9)}}, "node 'disc' must be two indices from 0 to 3"),
        ({"nodes": {"disc": np.ones((2, 3))}}, "node 'disc' must be two indices or an array"),
        ({"nodes": {"disc": (1, 1)}}, "node 'disc' must have different indices along x and y"),
        ({"nodes": {3: (0, 1)}}, "names of nodes must be text"),
        ({"nodes": [(0, 1)]}, "nodes must map names"),
        ({"translations": np.ones((4, 3))}, "translations must have the shape"),
        ({"units": "inch"}, "units must be"),
        ({"contacts": [3]}, "contacts must be a Contact, got 3"),
        ({"unbalance": [Unbalance(node="seal", moment=1.0)]}, "node must be one of .*got 'seal'"),
        ({"supports": [Support(node="end", stiffness=1.0)] * 2},
         "supports must be at different nodes, got 'end'"),
        ({"gravity": (0.0, np.nan)}, "gravity"),
    ]),
    (lambda given: Contact(**TOUCH | given), [
        ({"clearance": -1.0}, "clearance of the contact at 'disc' must"),
        ({"stiffness": -1.0}, "stiffness of the contact at 'disc' must"),
        ({"exponent": 2.0}, "exponent of the contact at 'disc' must be 1.5 or 1.0"),
        ({"friction": 0.1}, "radius of the contact at 'disc' must be given with friction"),
        ({"centre": (1.0, 2.0, 3.0)}, "centre of the contact at 'disc' must be two numbers"),
        ({"stator": 3}, "stator of the contact at 'disc' must be"),
    ]),
    (lambda given: simulate(RotorSystem(**SYSTEM), **{"contacts": [Contact(**TOUCH)], "speed": 1.0,
                                                      "duration": 1.0} | given), [
        ({"contacts": [Contact(**TOUCH | {"node": "dics"})]}, "node must be one of .*did you mean"),
        ({"contacts": [Contact(**TOUCH)] * 2}, "contacts must not overlap"),
        ({"contacts": Contact(**TOUCH)}, "contacts must be a list"),
        ({"contacts": [Contact(**TOUCH | {"stator": "disc"})]},
         "stator of the contact at 'disc' must be another node, got 'disc'"),
        ({"unbalance": [3]}, "unbalance must be"),
        ({"start": "resting"}, "start must be"),
        ({"start": ([1.0], [0.0])}, "displacement of the start must have the shape"),
        ({"static_force": [1.0]}, "static_force must have the shape"),
        ({"gravity": 9.81}, "gravity must be two numbers"),
        ({"rtol": 0.1}, "rtol must"),
        ({"samples": [0.0, 99.0]}, "samples must lie from 0 to the duration 1 s, got 99 s$"),
        ({"modes": 99}, "modes must"),
        ({"modes": 4, "more_modes": 3}, "more_modes must be more than modes, 4, got 3"),
        ({"more_modes": 3}, "modes must be given with more_modes, got None"),
        ({"duration": 1e12}, "duration must be at most 4.14214e.08 s, as the system moves at up to "
         "1.41421 rad/s, got 1e.12 s; fewer modes"),
        ({"speed": 1e12}, "duration must be at most .* s, as .* rad/s, got 1 s"),
        ({"duration": -1.0}, "duration must be positive, got -1 s"),
        ({"contacts": [Contact(**TOUCH | {"damping": 1e9})]},
         "damping of the contact at 'disc' must be at most .* s/m to be simulated, got 10+ s/m"),
        ({"contacts": [Contact(**TOUCH), Contact(**TOUCH | {"centre": (0.0, 0.3)})]},
         "contacts 0 and 1 at node 'disc' must leave it room, got centres 0.3 m apart with "
         "clearances 0.1 m and 0.1 m"),
        ({"gravity": (0.0, -1e40)}, "gravity must lie within 1e.30 m/s2 of zero, got -1e.40 m/s2"),
    ]),
    # without units the numbers are as they were given
    (lambda given: simulate(RotorSystem(**SYSTEM, units="1"), speed=1.0, duration=given), [
        (-1.0, "duration must be positive, got -1.0$"),
        (1e12, "duration must be at most 4.142e.08, as the system moves at up to 1.414, got"),
    ]),
    (lambda given: campbell(RotorSystem(**SYSTEM), **{"speed": [0.0, 1.0]} | given), [
        ({"contact_stiffness": 5.0}, "contact_stiffness must be 0 without contacts, got 5 N/m"),
    ]),
    (lambda given: synchronous_response(RotorSystem(**SYSTEM), speed=given), [
        (1e30, "speed must be at most 1e.15 rad/s, got 1e.30 rad/s"),
    ]),
    (lambda given: drop(RotorSystem(**SYSTEM, contacts=[Contact(**TOUCH)]), **{"speed": 1.0,
        "duration": 1.0} | given), [
        ({"speed": 1e12}, "speed must be at most 1e.09 rad/s in a duration of 1 s, got 1e.12 rad"),
        ({"drag": 2.0, "gravity": (0.0, 0.0)},
         "inertia must be given with drag, got drag 2 N m s alone"),
    ]),
    (lambda given: run_up(RotorSystem(**SYSTEM), speed=1.0, **given), [
        ({}, "the speed must change in one way, by to and rate or ramp_time, .*, got none of them"),
        ({"to": 2.0, "rate": -1.0},
         "rate must be positive to change the speed from 1 rad/s to 2 rad/s, got -1 rad/s2"),
        ({"to": 1.0, "rate": 1.0}, "to must differ from the rotor's speed 1 rad/s, got 1 rad/s"),
        ({"to": 2.0, "rate": 1.0, "torque": (1.0, 0.0)},
         "the speed must change in one way, .*, got to, rate, torque"),
        ({"torque": (1.0, 0.0), "inertia": 1.0}, "duration must be given with torque"),
        ({"to": 2.0, "rate": 0.1, "inertia": 1.0},
         "the speed must change in one way, .*, got to, rate, inertia"),
        ({"torque": (1.0, 0.0), "duration": 1.0}, "inertia must be given with torque, got None"),
        ({"torque": 1.0, "inertia": 1.0}, "torque must be two numbers"),
        ({"torque": (1.0, 0.0), "duration": 1.0, "inertia": 0.0}, "inertia must"),
        ({"torque": (1, -1), "inertia": 1.0, "duration": 90.0},
         ".* turns below 1e.09 radians, got "
         "torque .1 N m, -1 N m s., inertia 1 kg m2 and duration 90 s, which lead to a speed of"),
        ({"speeds": [(0, 1), (1e-300, 1e300)]}, "the rate of speeds must"),
        ({"speeds": [(0, 1), (5, 2)], "duration": 2.0}, "duration must be at least 5 s"),
        ({"speeds": [(1, 1), (5, 2)]}, "the first time of speeds must be 0, got 1 s"),
        ({"to": 2.0, "rate": 0.1, "duration": 2.0}, "duration must be at least 10 s"),
        ({"rate": 0.1}, "to or duration must be given with rate"),
        ({"to": 2.0, "rate": 0.1, "ramp_time": 3.0}, "rate must be left out with ramp_time"),
        ({"ramp_time": 3.0}, "to must be given with ramp_time"),
        ({"to": 2.0, "ramp_time": -3.0}, "ramp_time must be positive"),
    ]),
    (lambda given: basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), **{"x": (-1, 1), "y":
        (-1, 1), **given}), [
        ({"x": (1, 2, 3)}, r"x must be a number or a range \(low, high\), got \[1.0, 2.0, 3.0\]$"),
        ({"x": (2, 1)}, r"x must be a range \(low, high\) with low <= high, got \(2.0, 1.0\)$"),
        ({"y": "wide"}, "y must be a finite real number, got 'wide'$"),
        ({"seed": -1}, "seed must be at least 0, got -1$"),
    ]),
    (lambda given: continue_attractors(**{"omega": [1.0, 2.0], "zeta": 0.1, "delta0": 0.5, **BOX,
        **given}), [
        ({"omega": [2.0, 1.0]}, "omega must increase, got 1.0 after 2.0"),
        ({"omega": [1.0, 2.0], "zeta": [0.1, 0.2], "delta0": [0.0, 1.0]},
         "two of the parameters at most may be arrays, got omega, zeta and delta0"),
        ({"zeta": 0.0}, "zeta must be above 0 and at most .* got 0.0"),
        ({"x": 1.0, "y": 0.0}, "x, y, vx or vy must be a range, got numbers for 1000 starts"),
        ({"starts": np.zeros((3, 2))}, r"starts must be a number, or .* got one of shape \(3, 2\)"),
        ({"starts": np.zeros((3, 4))}, "x, y, vx and vy must be left out where starts are given"),
        ({"rtol": 0.1}, "rtol must lie from 1e-12 to 0.0001, got 0.1"),
    ]),
    (lambda given: touchdown_report(**{"rotor": Rotor(omega=2.0, zeta=0.07, delta0=2.0), **BOX,
        **given}), [
        ({"rotor": "mine"},
         "touchdown_report takes a Rotor, DimensionalRotor or RotorSystem first, as in "),
        ({"rotor": Rotor(omega=0.0, zeta=0.1, delta0=1.0)}, "omega must be above 0 .* got 0.0"),
        ({"rotor": Rotor(omega=1.0, zeta=0.0, delta0=1.0)}, "zeta must be above 0"),
        ({"rotor": MACHINE, "x": (-1000.0, 1000.0)},
         "x must lie within 1 m of zero, got -1000 m"),
    ]),
    (lambda given: limit_cycle(BOUNCING.rotor, start=REST, period=given), [
        (1e300, "period must lie from 1e-06 to 10000.0, got 1e.300"),
    ]),
    (lambda given: run_up(TURNED, **given), [
        ({"to": 10.0, "rate": 3.0}, "rate must be negative .* from 60 rad/s to 10 rad/s, got 3 "),
        ({"to": 60.0, "rate": 3.0}, "to must differ from the rotor's speed 60 rad/s, got 60 rad/s"),
        ({"to": -1.0, "rate": -3.0}, "to must be zero or positive: .*, got -1 rad/s"),
        ({"speeds": [(0.0, 10.0), (1.0, -1.0)]}, "a speed of speeds must be zero or positive"),
        ({"speeds": [1.0, 2.0]}, "speeds must be two or more pairs of time and speed, got"),
        ({"torque": (1.0, 0.0), "inertia": 0.0, "duration": 1.0},
         "inertia must be positive, got 0 kg m2"),
    ]),
]
# fmt: on


@pytest.mark.parametrize(
    ("call", "given", "line"), [(call, *row) for call, rows in REFUSED for row in rows]
)
def test_what_cannot_be_is_refused_in_one_line(call, given, line):
    with pytest.raises(InputError, match=f"^{line}") as refusal:
        call(given)
    assert "\n" not in str(refusal.value)
