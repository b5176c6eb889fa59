"""Small changes of a motion along a changing speed: at samples, at events and by parameters."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida.core.system_requests import LAW_CHANGE, ByParameter
from rotor_ida.core.systems import follow_system
from rotor_ida.model.assembly import assemble, canonical
from rotor_ida.schema.flags import ENTRY, EXIT, RELEASE, ROLL, SLIP
from rotor_ida.simulation.spin import Driven, SpeedProfile, through
from rotor_ida.simulation.system_run import request_of
from tests.random_systems import random_system

# Between them contacts enter, leave, roll and slip; with races, stators, rates of the stiffness.
SEEDS = (2, 3, 5, 6, 9, 10, 17, 19)
DURATION = 14.0
# Of the largest derivative.
WITHIN = 1e-7
# The speed rises, stays, and falls.
POINTS = [(0.0, 0.7), (5.0, 1.5), (8.0, 1.5), (DURATION, 0.9)]


def request(seed, profile=None, **changed):
    """Return a run along a changing speed."""
    system, around = random_system(seed)
    start = around.pop("start")
    assembly = assemble(replace(system, **around))
    found = canonical(assembly)
    begun = np.zeros((2, assembly.size))
    begun[:, : system.size] = start
    own = request_of(
        assembly, found, profile or through(POINTS, DURATION), begun @ found.factor,
        np.linspace(0.0, DURATION, 29), DURATION, rtol=1e-13, speed=0.7, fastest_speed=1.5,
        inertia=4.0 if profile else 0.0,
    )  # fmt: skip
    return replace(own, **changed)


def parameters(asked, rng):
    """Return all that a parameter changes, each alone, and the same run with a bit more of it."""
    size, count = len(asked.force), len(asked.laws)
    none = np.zeros(count, LAW_CHANGE)
    square, row = rng.normal(size=(size, size)), rng.normal(size=size)
    given = {"stiffness": 0.1 * square, "damping": 0.02 * square, "force": row,
             "unbalance": np.array([row, row[::-1]])}  # fmt: skip
    found = [
        (ByParameter(laws=none, **{name: value}),
         lambda step, name=name, value=value:
         replace(asked, **{name: getattr(asked, name) + step * value}))
        for name, value in given.items()
    ]  # fmt: skip
    for name in ("clearance", "stiffness", "contact_damping", "friction"):
        own = ["hertz", "linear"] if name == "stiffness" else [name]
        law = none.copy()
        law[name] = 1.0 if name == "stiffness" else asked.laws[name]

        def changed(step, own=own):
            laws = asked.laws.copy()
            for each in own:
                laws[each] *= 1.0 + step
            return replace(asked, laws=laws)

        found.append((ByParameter(laws=law), changed))

    def faster(step):
        pieces = asked.pieces.copy()
        pieces["speed"] += step
        return replace(asked, pieces=pieces)

    mass = 0.5 * (square + square.T)
    found.append((ByParameter(laws=none, speed=1.0), faster))
    return [*found, (ByParameter(laws=none, mass=mass), lambda step: heavier(asked, step * mass))]


def heavier(asked, more):
    """Return a run with another mass, in coordinates in which that is a unit matrix again."""
    root = np.linalg.cholesky(np.eye(len(more)) + more)
    inverse = np.linalg.inv(root)
    matrices = {
        name: None if matrix is None else inverse @ matrix @ inverse.T
        for name in ("stiffness", "damping", "gyroscopic", "stiffness_rate")
        for matrix in [getattr(asked, name)]
    }
    return replace(
        asked, **matrices, rows=asked.rows @ inverse.T, unbalance=asked.unbalance @ inverse.T,
        force=inverse @ asked.force, start=asked.start @ root,
    )  # fmt: skip


def difference(observed, step):
    """Return the derivative of what is observed at steps to either side, by an extrapolation."""
    wide, near = (
        (observed(part * step) - observed(-part * step)) / (2.0 * part * step)
        for part in (1.0, 0.5)
    )  # fmt: skip
    return (4.0 * near - wide) / 3.0


@pytest.mark.parametrize("seed", SEEDS)
def test_columns_are_differences_of_runs(seed):
    """By the start and by each parameter: of displacements at samples, and of times of events."""
    rng, asked = np.random.default_rng(seed), request(seed)
    size, count = len(asked.force), len(asked.laws)
    changes = np.zeros((2, 2 * size + count))
    changes[:, : 2 * size] = rng.normal(size=(2, 2 * size))
    changes[1, 2 * size :] = 0.1 * (asked.laws["inverse_race_inertia"] > 0.0)
    given = parameters(asked, rng)

    def beside(step, change):
        return replace(
            asked, start=asked.start + step * change[: 2 * size].reshape(2, size),
            races=asked.races + step * change[2 * size :],
        )  # fmt: skip

    runs = [*[lambda step, each=each: beside(step, each) for each in changes],
            *[changed for _, changed in given]]  # fmt: skip
    result = follow_system(replace(
        asked, columns=np.vstack([changes, np.zeros((len(given), 2 * size + count))]),
        parameters=[each for each, _ in given], watched=asked.rows.reshape(-1, size),
    ))  # fmt: skip
    kinds, contacts = result.event_kinds, result.event_contacts
    edges = np.isin(kinds, (ENTRY, EXIT))
    place, rate = (
        np.einsum("erk,ek->er", asked.rows[contacts], result.event_states[:, each])
        for each in range(2)
    )  # fmt: skip
    place -= asked.laws["offset"][contacts]
    wider = np.zeros((len(runs), count))
    wider[len(changes) :] = [each.laws["clearance"] for each, _ in given]
    radius = np.linalg.norm(place, axis=1)
    for column, changed in enumerate(runs):

        def observed(step, changed=changed):
            run = changed(step)
            other = follow_system(run)
            assert np.array_equal(other.event_kinds, kinds)
            seen = other.samples[:, 0] @ run.rows.reshape(-1, size).T
            races = other.touches["race"]
            return np.concatenate([other.event_times[edges], races, seen.ravel()])

        times, races, seen = np.split(
            difference(observed, 4e-6), [edges.sum(), edges.sum() + count]
        )
        own = result.columns[column, 2 * size :]
        np.testing.assert_allclose(own, races, rtol=0.0, atol=WITHIN * max(1.0, np.abs(own).max()),
                                   err_msg=str(column))  # fmt: skip
        own = result.sample_columns[:, :, column].ravel()
        np.testing.assert_allclose(own, seen, rtol=0.0, atol=WITHIN * np.abs(own).max(),
                                   err_msg=str(column))  # fmt: skip
        rise = (place * result.event_columns[:, :, column]).sum(axis=1)
        rise -= radius * wider[column, contacts]
        own = -(rise / (place * rate).sum(axis=1))[edges]
        np.testing.assert_allclose(own, times, rtol=0.0, atol=WITHIN * np.abs(own).max(),
                                   err_msg=str(column))  # fmt: skip


def test_these_motions_have_all_events():
    kinds = np.concatenate([follow_system(request(seed)).event_kinds for seed in SEEDS])
    assert {ENTRY, EXIT, RELEASE, ROLL, SLIP} <= set(kinds.tolist())


def test_columns_are_refused_under_a_torque():
    profile = SpeedProfile((DURATION,), (Driven(1.5, 0.4, 4.0),))
    asked = request(2, profile)
    with pytest.raises(ValueError, match="columns need a prescribed speed"):
        follow_system(replace(asked, columns=np.zeros((1, 2 * len(asked.force) + 1))))
