"""What parameters add over a step, against differences of whole steps."""

import math

import numpy as np
import pytest

from rotor_ida.simulation.contact_phase import T, cartesian, regularised
from rotor_ida.simulation.motion import GOES_ON
from rotor_ida.simulation.taylor.motion import open_taylor
from rotor_ida.stability.by_parameters import added_by_parameters

START = (1.2, 0.3, -0.2, 0.9)
CONTACT, FREE = (1.2, 0.07, 0.5), (1.2, 0.07, 0.0)


def stepped(rotor, start=START):
    """A motion after its first step, and the point of it that ends what is looked at."""
    whole = start
    if rotor[2] > 0.0:
        z, w = complex(*start[:2]), complex(*start[2:])
        whole = regularised(z, w, math.sqrt(abs(z) - rotor[2]))
    motion = open_taylor(*rotor, rotor[2] > 0.0, 1e-15, True)
    whole = np.append(whole, np.eye(4).ravel())
    motion.restart(whole, np.full(whole.size, 1e-17))
    assert motion.advance() == GOES_ON
    return motion


def point_at(motion, time):
    """The point of the step at a time: bisection."""
    if not motion.regularised:
        return time
    low, high = motion.low, motion.point
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if motion.at(middle)[T] < time else (low, middle)
    return high


def state_at(motion, time):
    read = motion.at(point_at(motion, time))
    if not motion.regularised:
        return read[:4].copy()
    z, w = cartesian(read, motion.delta0)
    return np.array([z.real, z.imag, w.real, w.imag])


@pytest.mark.parametrize(("rotor", "parameters"), [(CONTACT, 3), (FREE, 2)])
def test_parameters_add_the_differences_of_neighbouring_rotors(rotor, parameters):
    """Central differences of the state at one time, in contact and without clearance."""
    time, h, added = 0.05, 1e-5, np.full((3, 4), np.nan)
    motion = stepped(rotor)
    end = point_at(motion, time)
    matrix = motion.at(end)[motion.size :].reshape(4, 4).copy()
    added_by_parameters(motion, end, matrix, added)
    for n in range(parameters):
        ahead, behind = (
            state_at(stepped(tuple(rotor + s * h * np.eye(3)[n])), time) for s in (1, -1)
        )
        np.testing.assert_allclose(added[n], (ahead - behind) / (2.0 * h), rtol=0, atol=1e-9)
    assert (added[parameters:] == 0.0).all()
