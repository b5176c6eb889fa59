"""Whether branches lose special points: random branches, and the same with ten times shorter steps.

Rotors, starts, and the parameter that is continued are drawn at random; every start that leads to a
limit cycle gives a branch over 30 % of its parameter each way. Both lists of folds, doublings and
grazes must be the same. Branches are compared as far as both have come.

    python benchmarks/special_points.py --branches 200
"""

import argparse
import math

import numpy as np

from rotor_ida import Rotor, RotorError, continue_cycle, limit_cycle
from rotor_ida.cycles import continuation
from rotor_ida.schema import SPECIAL

FINER = 10.0
MOST_POINTS = 300
# Special points of both that agree to this part of the parameter are the same.
SAME = 1e-7


def random_cycle(rng):
    """Return a rotor, a limit cycle of it, and the parameter to continue."""
    while True:
        rotor = Rotor(
            omega=float(rng.uniform(0.3, 4.0)),
            zeta=math.exp(rng.uniform(math.log(0.005), math.log(0.2))),
            delta0=math.exp(rng.uniform(math.log(0.1), math.log(4.0))),
        )
        start = rng.uniform(-1.0, 1.0, 4) * 2.0 * (1.0 + rotor.delta0)
        try:
            found = limit_cycle(rotor, start=start)
        except RotorError:
            continue
        if math.isfinite(float(found["period"])) and float(found["period"]) < 60.0:
            return rotor, found, str(rng.choice(["omega", "omega", "zeta", "delta0"]))


def specials_of(rotor, cycle, parameter, finer):
    """Return kind and value of each special point, and the ends of the branch."""
    longest = continuation.LONGEST_STEP
    try:
        continuation.LONGEST_STEP = longest / finer
        here = getattr(rotor, parameter)
        found = continue_cycle(
            rotor,
            start=cycle,
            parameter=parameter,
            limits=(0.7 * here, 1.3 * here),
            points=int(MOST_POINTS * finer),
        )
    finally:
        continuation.LONGEST_STEP = longest
    kinds, values = found["special_kind"].values.tolist(), found["special_value"].values.tolist()
    return list(zip(kinds, values, strict=True)), (
        found.attrs["first_end"],
        found.attrs["last_end"],
        found.sizes["point"],
    )


def unmatched(one, other):
    """Return the special points of one list that the other lacks."""
    left = list(other)
    missing = []
    for kind, value in one:
        near = [each for each in left if each[0] == kind and abs(each[1] - value) <= SAME * value]
        if near:
            left.remove(min(near, key=lambda each: abs(each[1] - value)))
        else:
            missing.append((kind, value))
    return missing


def main():
    """Print each branch on which the lists differ, and how many there are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--branches", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng, words = np.random.default_rng(arguments.seed), {n: word for word, n in SPECIAL.items()}
    differ = total = compared = 0
    while compared < arguments.branches:
        rotor, cycle, parameter = random_cycle(rng)
        try:
            usual, ends = specials_of(rotor, cycle, parameter, 1.0)
            finer, others = specials_of(rotor, cycle, parameter, FINER)
        except RotorError as error:
            print(f"failed: {rotor}, {parameter}: {error}")
            continue
        compared, total = compared + 1, total + len(finer)
        lost, gained = unmatched(finer, usual), unmatched(usual, finer)
        if lost or gained:
            differ += 1
            for word, points in (("lost", lost), ("only with longer steps", gained)):
                for kind, value in points:
                    print(f"{word}: {words[kind]} at {parameter} {value:.10g} of {rotor}")
            print(f"  ends {ends}, with shorter steps {others}", flush=True)
    print(f"{compared} branches, {total} special points; lists differ on {differ} branches")


if __name__ == "__main__":
    main()
