"""Hold labels against those that the same starts get with a tighter tolerance, on a dozen rotors.

For each rotor the starts, random ones at rest on [-15, 15]^2, are labelled three times: with a
tolerance of 1e-6, as for an atlas; with the tolerance that `basin` chooses; and with 1e-12. Told is
how many of the labels the tightest run does not give, of those that both runs decide, and by how
many standard errors of a random sample the fraction of an attractor differs at most with 1e-6.

    python benchmarks/label_tolerance.py --starts 2000
"""

import argparse
import math

import numpy as np

from rotor_ida import Rotor
from rotor_ida.basins.attractors import kind_of
from rotor_ida.basins.disc import RTOL, Disc
from rotor_ida.basins.following import follow_starts
from rotor_ida.basins.subjects import TIGHTEST
from rotor_ida.core.runs import NO_STOP
from rotor_ida.parallel import choose
from rotor_ida.results.studies.results import Results
from rotor_ida.schema import FATE

ROTORS = (
    (1.7, 0.07, 0.0), (1.7, 0.07, 0.5), (1.7, 0.07, 1.0), (1.7, 0.07, 2.0), (2.0, 0.07, 2.0),
    (3.0, 0.07, 0.5), (2.5, 0.07, 1.0), (0.8, 0.07, 1.0), (1.2, 0.07, 0.5), (1.5, 0.03, 1.0),
    (1.7, 0.02, 0.0), (3.0, 0.2, 2.0),
)  # fmt: skip
HALF_WIDTH = 15.0
# Two runs have found one attractor whose extreme radii agree to this part.
SAME = 1e-5


def labelled(rotor, states, rtol, workers):
    """Return starts, shape (4, n), as they were labelled."""
    return follow_starts(
        Disc.of(rotor, rtol, NO_STOP), lambda first, last: states[:, first:last], states.shape[1],
        Results(), workers=choose("auto", workers, compiled=True), progress=None,
    )  # fmt: skip


def same(one, other):
    """Return whether two attractors of a rotor are one."""
    pairs = [(one[name], other[name]) for name in ("radius_min", "radius_max")]
    known = [pair for pair in pairs if not (math.isnan(pair[0]) or math.isnan(pair[1]))]
    return kind_of(one) == kind_of(other) and (
        kind_of(one) == "chaotic" or all(abs(a - b) <= SAME * one["radius_max"] for a, b in known)
    )


def agreeing(found, closely):
    """Return how many labels both runs have decided, and how many of these agree."""
    alike = np.array([[same(a, b) for b in closely.rows] for a in found.rows])
    both = (found.labels != FATE["undecided"]) & (closely.labels != FATE["undecided"])
    return int(both.sum()), int(alike[found.labels[both], closely.labels[both]].sum())


def apart(found, closely):
    """Return the largest difference of a fraction in standard errors of a sample."""
    largest, count = 0.0, found.labels.size
    for number, attractor in enumerate(closely.rows):
        own = [place for place, each in enumerate(found.rows) if same(each, attractor)]
        fraction = float((closely.labels == number).mean())
        error = math.sqrt(fraction * (1.0 - fraction) / count)
        if error > 0.0:
            difference = float(np.isin(found.labels, own).mean()) - fraction
            largest = max(largest, abs(difference) / error)
    return largest


def main():
    """Print a line for each rotor, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--starts", type=int, default=2000)
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    states = np.zeros((4, given.starts))
    states[:2] = np.random.default_rng(1).uniform(-HALF_WIDTH, HALF_WIDTH, (2, given.starts))
    sums = np.zeros(4, dtype=np.int64)
    print(f"omega  zeta  delta0 | differ at {RTOL:g} | fractions apart | chosen, differ")
    for omega, zeta, delta0 in ROTORS:
        rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
        plain, chosen, closely = (
            labelled(rotor, states, rtol, given.workers) for rtol in (RTOL, None, TIGHTEST)
        )
        counts = np.array([*agreeing(plain, closely), *agreeing(chosen, closely)])
        sums += counts
        print(
            f"{omega:5g} {zeta:5g} {delta0:5g}   | {counts[0] - counts[1]:4} of {counts[0]} | "
            f"{apart(plain, closely):15.2f} | {chosen.followed.tolerance:g}, "
            f"{counts[2] - counts[3]} of {counts[2]}",
            flush=True,
        )
    for name, (both, alike) in zip(("at 1e-6", "as chosen"), sums.reshape(2, 2), strict=True):
        print(f"{name}: {alike} of {both} labels agree, {100.0 * alike / both:.3f} %")


if __name__ == "__main__":
    main()
