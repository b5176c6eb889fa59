"""Hold the labels of random starts against CVODE, which follows every one of them on its own.

A label may differ only on a boundary: where CVODE itself ends elsewhere from one of eight starts
that are a billionth away.

    python benchmarks/basin_labels.py --omega 1.7 --zeta 0.07 --delta0 0 --starts 2000
"""

import argparse
import sys
import time

import numpy as np
from label_tolerance import HALF_WIDTH, labelled

from rotor_ida import Rotor
from rotor_ida.basins.attractors import kind_of
from rotor_ida.parallel import count_workers, run_all
from rotor_ida.schema import FATE
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc

ASIDE = 1e-9
# CVODE is on an attractor that agrees with its results to this part.
AGREES = 1e-6


def follow(job, _stop):
    """Return what CVODE makes of one start: kind, amplitude and extreme radii."""
    rotor, state = job
    settled = settle_disc(rotor, state, Options(rtol=1e-10))
    seen = settled.features
    return settled.kind, seen.amplitude, seen.radius_min, seen.radius_max


def label_of(outcome, attractors):
    """Return the number of the attractor that CVODE has found, UNDECIDED if it has not settled."""
    kind, amplitude, low, high = outcome
    for number, each in enumerate(attractors):
        if kind_of(each) != kind:
            continue
        if kind in ("contact_free", "touching", "chaotic"):
            return number
        if kind == "synchronous" and abs(each["amplitude"] - amplitude) < AGREES * amplitude:
            return number
        if max(abs(each["radius_min"] - low), abs(each["radius_max"] - high)) < AGREES * high:
            return number
    return FATE["undecided"]


def on_boundary(rotor, state, attractors):
    """Return whether CVODE ends on several attractors from a start and those beside it."""
    ends = set()
    for across in (-ASIDE, 0.0, ASIDE):
        for upwards in (-ASIDE, 0.0, ASIDE):
            x, y, vx, vy = state
            beside = (rotor, (x + across, y + upwards, vx, vy))
            ends.add(label_of(follow(beside, None), attractors))
    return len(ends) > 1


def main():
    """Compare and count; exit 1 if a label differs away from every boundary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--omega", type=float, default=1.7)
    parser.add_argument("--zeta", type=float, default=0.07)
    parser.add_argument("--delta0", type=float, default=0.0)
    parser.add_argument("--starts", type=int, default=2000)
    parser.add_argument("--rtol", type=float, help="by default what suits")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    rotor = Rotor(omega=given.omega, zeta=given.zeta, delta0=given.delta0)
    states = np.zeros((4, given.starts))
    states[:2] = np.random.default_rng(1).uniform(-HALF_WIDTH, HALF_WIDTH, (2, given.starts))
    found = labelled(rotor, states, given.rtol, given.workers)
    labels, attractors = found.labels, found.rows
    for number, each in enumerate(attractors):
        print(number, each, int((labels == number).sum()))
    print("undecided:", int((labels == FATE["undecided"]).sum()))
    began = time.perf_counter()
    jobs = ((rotor, tuple(state)) for state in states.T.tolist())
    workers = count_workers(given.workers)
    outcomes = dict(run_all(follow, jobs, workers=workers, executor="processes"))
    wrong, beside = 0, 0
    for number in range(given.starts):
        expected = label_of(outcomes[number], attractors)
        if expected == labels[number]:
            continue
        excused = on_boundary(rotor, states[:, number].tolist(), attractors)
        wrong, beside = wrong + (not excused), beside + excused
        where = "on a boundary" if excused else "WRONG"
        print(f"{where}: start {states[:2, number]}: {labels[number]}, CVODE {outcomes[number]}")
    took = time.perf_counter() - began
    print(
        f"{given.starts} starts, {wrong} labels wrong, {beside} on a boundary; CVODE took "
        f"{took:.0f} s"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
