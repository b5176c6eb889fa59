"""Ramps: every point of a sweep in exactly one, in the order in which one parameter is swept."""

import numpy as np
import pytest

from rotor_ida import sweep
from rotor_ida.model.varied import varied_of
from rotor_ida.simulation.options import Options
from rotor_ida.steady.disc_sweep import VariedDisc

VARIED = varied_of(
    sweep,
    None,
    {"omega": [1.0, 2.0, 3.0], "zeta": [0.1, 0.2], "delta0": [0.0, 0.5, 1.0, 2.0], "load": 0.1},
)
STARTS = [(0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)]


def ramps_of(*directions, along="omega"):
    varied = VARIED.over(start=np.arange(2), direction=np.array(directions, np.int8))
    return VariedDisc(VARIED, STARTS, Options()).ramps(varied, along)


@pytest.mark.parametrize("along", ["omega", "zeta", "delta0"])
@pytest.mark.parametrize("directions", [(0,), (1,), (-1,), (1, -1)])
def test_a_job_is_what_stands_at_its_places_and_each_point_is_in_one(directions, along):
    ramps, axes, places = ramps_of(*directions, along=along), VARIED.axes, []
    for number in range(len(ramps)):
        job = ramps.job(number)
        places.append(ramps.places(number))
        omega, zeta, delta0, start, direction = at = np.unravel_index(
            places[-1], ramps.varied.shape
        )
        assert [rotor.omega for rotor in job.points] == axes["omega"][omega].tolist()
        assert [rotor.zeta for rotor in job.points] == axes["zeta"][zeta].tolist()
        assert [rotor.delta0 for rotor in job.points] == axes["delta0"][delta0].tolist()
        assert {rotor.load for rotor in job.points} == {0.1}
        assert {job.start} == {STARTS[each] for each in start.tolist()}
        way = directions[direction[0]]
        assert len(job.points) == (axes[along].size if way else 1)
        assert (way * np.diff(at[ramps.axis]) == 1).all()
        others = np.delete(np.array(at), ramps.axis, axis=0)
        assert (others == others[:, :1]).all()
    assert ramps.points == 3 * 2 * 4 * 2 * len(directions)
    assert sorted(np.concatenate(places).tolist()) == list(range(ramps.points))


@pytest.mark.parametrize("along", ["omega", "zeta"])
def test_ramps_with_much_clearance_come_first(along):
    ramps = ramps_of(1, along=along)
    numbers = ramps.slowest_first().tolist()
    assert sorted(numbers) == list(range(len(ramps)))
    clearances = [ramps.job(number).points[0].delta0 for number in numbers]
    assert clearances == sorted(clearances, reverse=True)
