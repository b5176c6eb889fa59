"""Hold the labels of a few random starts against those that they get among many, on four rotors.

Where limit cycles attract slowly, chaos is weak or is left again, what becomes of a start must not
hang on what else is followed. The starts are random ones at rest on [-15, 15]^2, the first of both
samples the same. With `--no-sections` no limit cycle holds an orbit by a section: each is followed
to its end by itself, so take few.

    python benchmarks/sample_size.py --few 512 --many 20000
    python benchmarks/sample_size.py --few 16 --many 128 --no-sections
"""

import argparse
import time
from dataclasses import replace

import numpy as np
from label_tolerance import HALF_WIDTH, same

from rotor_ida import Rotor
from rotor_ida.basins import known
from rotor_ida.basins.disc import Disc
from rotor_ida.basins.following import follow_starts
from rotor_ida.core.runs import NO_STOP
from rotor_ida.parallel import choose
from rotor_ida.results.studies.results import Results
from rotor_ida.schema import FATE
from rotor_ida.simulation.starts import drawn_from

# Beside a doubling; beside chaos in a narrow window; weak chaos; chaos that is left.
ROTORS = ((1.8034, 0.07, 2.0), (1.38, 0.07, 1.0), (1.69, 0.07, 2.0), (1.5, 0.01, 2.0))
BOX = np.array([[-HALF_WIDTH, HALF_WIDTH], [-HALF_WIDTH, HALF_WIDTH], [0.0, 0.0], [0.0, 0.0]])


def labelled(rotor, count, workers):
    """Return so many starts as they were labelled, and how long that took."""
    start = time.perf_counter()

    def starts(first, last):
        return drawn_from(BOX, 0, first, last)

    disc = Disc.of(rotor, None, NO_STOP).scouted(starts, count, drawn=True, stop=NO_STOP)
    found = follow_starts(
        disc, starts, count, Results(), workers=choose("threads", workers, compiled=True),
        progress=None,
    )  # fmt: skip
    return found, time.perf_counter() - start


def alike(few, many):
    """Return for each start of the few whether its label means the same among many."""
    pairs = zip(few.labels.tolist(), many.labels[: few.labels.size].tolist(), strict=True)
    fates = set(FATE.values())
    return [
        one == other if one in fates or other in fates else same(few.rows[one], many.rows[other])
        for one, other in pairs
    ]


def main():
    """Print a line for each rotor."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--few", type=int, default=512)
    parser.add_argument("--many", type=int, default=20000)
    parser.add_argument("--no-sections", action="store_true")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    if given.no_sections:
        with_set = known.cycle_section
        known.cycle_section = lambda cycle, stop: replace(
            with_set(cycle, stop), form=np.full((3, 4), np.inf)
        )
    print("omega   zeta  delta0 | labels that differ | undecided | time of few, many")
    for omega, zeta, delta0 in ROTORS:
        rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
        few, soon = labelled(rotor, given.few, given.workers)
        many, late = labelled(rotor, given.many, given.workers)
        differ = alike(few, many).count(False)
        undecided = int((many.labels == FATE["undecided"]).sum())
        print(
            f"{omega:6g} {zeta:5g} {delta0:6g} | {differ:6} of {given.few:<8} | {undecided:9} | "
            f"{soon:.1f} s, {late:.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
