"""The derivatives of the residuals, against those that the kernel of one disc carries along."""

from __future__ import annotations

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    DimensionalRotor,
    RotorSystem,
    Stator,
    Unbalance,
    run_up,
    signals_of,
)
from rotor_ida.fitting.arguments import problem_of
from rotor_ida.schema.flags import ENTRY, EXIT

# Steps of differences move a residual by this much of its error.
MOVED = 0.01
SHAFT = np.kron([[9e5, -6e5], [-6e5, 8e5]], np.eye(2))
OVERHUNG = RotorSystem(
    mass=np.diag([8.0, 8.0, 3.0, 3.0]), stiffness=SHAFT, damping=np.diag([120, 120, 60, 60]),
    gyroscopic=0.05 * np.kron(np.eye(2), [[0.0, 1.0], [-1.0, 0.0]]),
    stiffness_rate=np.kron(np.eye(2), [[0.0, 6.0], [-6.0, 0.0]]), gravity=(0.0, -9.81),
    nodes={"disc": (0, 1), "end": (2, 3)}, unbalance=[Unbalance(node="disc", moment=4e-4)],
    contacts=[Contact(node="disc", clearance=1.2e-4, stiffness=5e6, exponent=1.0, friction=0.2,
                      radius=0.05, damping=0.5,
                      stator=Stator(mass=2.0, stiffness=4e6, damping=400.0))],
)  # fmt: skip
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5, clearance=2e-5,
    speed=20.0, shaft_stiffness=4e4, friction=0.1, disc_radius=0.05, contact_damping=500.0,
    load=0.2,
)  # fmt: skip
ALL = {
    "system": (
        OVERHUNG, {"speed": 60.0, "to": 300.0, "rate": 240.0, "samples": 2001},
        ("damping", "stiffness", "clearance", "friction", "unbalance", "contact_stiffness",
         "contact_damping", "unbalance_angle"),
    ),
    "machine": (
        MACHINE, {"to": 200.0, "rate": 60.0, "samples": 4001},
        ("mass", "contact_stiffness", "damping", "eccentricity", "clearance", "shaft_stiffness",
         "friction", "load", "contact_damping", "unbalance_angle"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("start", [None, "rest"])
@pytest.mark.parametrize("case", ALL)
def test_derivatives_are_differences_of_residuals_along_a_ramp(case, start):
    """Of all unknowns, with friction, entries and exits; extrapolated from two steps."""
    machine, asked, unknown = ALL[case]
    run = run_up(machine, start="rest", **asked)
    times, kinds = run.event_time.values, run.event_kind.values
    signals = signals_of(run) if case == "machine" else {"end": signals_of(run, node="end")}
    sought = problem_of(
        signals, machine, unknown, orders=(0, 1), revolutions=None, start=start, noise=1e-6,
        entries=times[kinds == ENTRY], exits=times[kinds == EXIT], time_error=1e-4,
    )  # fmt: skip
    first = sought.trials.first()
    slopes = sought.slopes(first)
    for place, name in enumerate([*unknown, *["start"] * (first.size - len(unknown))]):
        own = slopes[:, place]
        step = MOVED / np.abs(own).max()

        def left(by, place=place):
            there = first.copy()
            there[place] += by
            return sought.apart(sought.trials.trial(there), matched_only=True)

        wide, near = ((left(each) - left(-each)) / (2.0 * each) for each in (step, 0.5 * step))
        found = (4.0 * near - wide) / 3.0
        assert np.abs(own - found).max() < 1e-7 * np.abs(own).max(), name
