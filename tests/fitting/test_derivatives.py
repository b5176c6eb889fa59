"""The derivatives of a motion, against differences of motions and against the compiled core."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import DimensionalRotor, InputError, Rotor
from rotor_ida.core.runs import COLUMNS
from rotor_ida.fitting.arguments import UNITS
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.fitting.motion import MotionRequest, Turning
from rotor_ida.schema.flags import ENTRY
from rotor_ida.simulation.flow import DiscFlow

# Runs up at one rate, then at another, through contacts that end and that do not.
TURNING = Turning(
    np.array([0.0, 0.5, 1.0]),
    np.array([0.0, 250.0]),
    np.array([300.0, 700.0]),
    np.array([800.0, 400.0]),
)
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=0.0,
    shaft_stiffness=5e5, contact_damping=50.0, load=0.3, friction=0.1, disc_radius=1e-3,
)  # fmt: skip
LINEAR = replace(MACHINE, contact_stiffness=2e6, contact_exponent=1.0)
START = np.array([1e-7, 0.0, 0.0, 1e-5])
TIMES = np.linspace(0.0, 1.0, 2001)
AHEAD = 0.3
# What moves the disc hardly at all is changed by more.
PARTS = {"contact_damping": 3e-3, "load": 1e-4}


def moved(machine, start, ahead):
    return MotionRequest(machine, TURNING, start, ahead).motion(TIMES, [])


def difference(machine, name, step):
    """Return the slope of the motion and of its entries by central differences."""
    both = []
    for way in (1.0, -1.0):
        start, ahead, one = START.copy(), AHEAD, machine
        if isinstance(name, int):
            start[name] += way * step
        elif name == ANGLE:
            ahead += way * step
        else:
            one = replace(machine, **{name: getattr(machine, name) + way * step})
        both.append(moved(one, start, ahead))
    entries = [each.touches(ENTRY)[0] for each in both]
    assert entries[0].size == entries[1].size > 0
    return (
        (both[0].z - both[1].z) / (2.0 * step),
        (entries[0] - entries[1]) / (2.0 * step),
    )


@pytest.mark.parametrize("machine", [MACHINE, LINEAR], ids=["hertz", "linear"])
def test_derivatives_are_those_of_the_motion(machine):
    """A difference of two motions has an error of its step squared, and of rounding over it."""
    names = list(UNITS)
    found = MotionRequest(machine, TURNING, START, AHEAD).motion(TIMES, names).derivatives
    assert found.growth < 1e3
    steps = dict(enumerate([1e-10, 1e-10, 1e-7, 1e-7])) | {
        name: 1e-6 if name == ANGLE else PARTS.get(name, 1e-6) * getattr(machine, name)
        for name in names
    }
    for column, (name, step) in enumerate(steps.items()):
        by_z, by_time = difference(machine, name, step)
        error = np.abs(found.slopes[:, column] - by_z).max() / np.abs(by_z).max()
        assert error < 1e-4, name
        scale = np.abs(by_time).max()
        assert np.abs(found.entry_slopes[:, column] - by_time).max() / scale < 1e-4, name


def test_derivatives_are_those_of_the_core_at_one_speed():
    """The core carries differences along by Taylor series, on axes that turn with the unbalance."""
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=2.5, shaft_stiffness=0.25, contact_damping=0.1,
                  load=0.2)  # fmt: skip
    start, end = np.array([0.2, -0.1, 0.3, 2.9]), 20.0
    shot = DiscFlow(rotor).run(start, end, by=COLUMNS)
    machine = DimensionalRotor(
        mass=1.0, contact_stiffness=1.0, damping=0.14, eccentricity=1.0, clearance=2.5, speed=1.7,
        shaft_stiffness=0.25, contact_damping=0.1, load=0.2,
    )  # fmt: skip
    turning = Turning(np.array([0.0, end]), np.zeros(1), np.array([1.7]), np.zeros(1))
    names = ("damping", "clearance", "shaft_stiffness", "contact_damping", "load")
    motion = MotionRequest(machine, turning, start).motion(np.array([0.0, end]), names)
    slopes = motion.derivatives.slopes
    turned = np.exp(1.7j * end)
    exact = {name: shot.by[n] for n, name in enumerate(COLUMNS)}
    exact |= {"damping": 0.5 * exact["zeta"], "clearance": exact["delta0"]}
    by_start = (shot.tangents[0] + 1j * shot.tangents[1]) * turned
    size = np.abs(by_start).max()
    np.testing.assert_allclose(slopes[-1, :4], by_start, rtol=0, atol=2e-7 * size)
    for column, name in enumerate(names, 4):
        expected = (exact[name][0] + 1j * exact[name][1]) * turned
        size = np.abs(slopes[:, column]).max()
        assert abs(slopes[-1, column] - expected) < 2e-7 * max(size, 1.0), name
    assert motion.touches(ENTRY)[0].size > 2


def test_a_disc_that_rolls_is_refused():
    """Where sliding ends derivatives jump; a small disc in firm contact comes to roll."""
    small = replace(MACHINE, friction=0.5, disc_radius=2e-6, load=0.0)
    with pytest.raises(InputError, match=r"machine must slide one way on the stator.* fit without"):
        _ = MotionRequest(small, TURNING, START).motion(TIMES, []).derivatives
