"""Ramps: every point of a sweep in exactly one, in the order in which the speed is swept."""

import numpy as np
import pytest

from rotor_ida.simulation.options import Options
from rotor_ida.steady.ramps import Ramps

AXES = {
    "omega": np.array([1.0, 2.0, 3.0]),
    "zeta": np.array([0.1, 0.2]),
    "delta0": np.array([0.0, 0.5, 1.0, 2.0]),
}
STARTS = [(0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)]


@pytest.mark.parametrize("directions", [(0,), (1,), (-1,), (1, -1)])
def test_chains_cover_every_point_once(directions):
    ramps = Ramps(AXES, STARTS, directions, Options())
    places = np.concatenate([ramps.places(number) for number in range(len(ramps))])
    assert ramps.points == 3 * 2 * 4 * 2 * len(directions)
    assert sorted(places.tolist()) == list(range(ramps.points))


@pytest.mark.parametrize("directions", [(0,), (1,), (-1,), (1, -1)])
def test_a_job_is_what_stands_at_its_places(directions):
    ramps = Ramps(AXES, STARTS, directions, Options())
    for number in range(len(ramps)):
        job, places = ramps.job(number), ramps.places(number)
        omega, zeta, delta0, start, direction = np.unravel_index(places, ramps.shape)
        assert [rotor.omega for rotor in job.rotors] == AXES["omega"][omega].tolist()
        assert [rotor.zeta for rotor in job.rotors] == AXES["zeta"][zeta].tolist()
        assert [rotor.delta0 for rotor in job.rotors] == AXES["delta0"][delta0].tolist()
        assert {job.start} == {STARTS[each] for each in start.tolist()}
        turn = directions[direction[0]]
        assert not turn or (turn * np.diff(omega) > 0).all()


def test_chains_with_much_clearance_come_first():
    ramps = Ramps(AXES, STARTS, (1,), Options())
    numbers = ramps.slowest_first().tolist()
    assert sorted(numbers) == list(range(len(ramps)))
    clearances = [ramps.job(number).rotors[0].delta0 for number in numbers]
    assert clearances == sorted(clearances, reverse=True)
