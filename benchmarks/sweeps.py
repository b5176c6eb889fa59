"""The sweeps of Fig. 11 on one core and on two: 4 clearances, 301 speeds, from rest, up and down.

By CVODE and by Taylor series, and where the responses differ.

python benchmarks/sweeps.py [--speeds 301] [--workers 1 2]
"""

import argparse
import time

import numpy as np

from rotor_ida import Rotor, simulate, sweep

PARAMETERS = {"zeta": 0.07, "delta0": [0.0, 0.5, 1.0, 2.0]}


METHODS = ("adams", "taylor")


def swept(speeds, direction, workers, method):
    """Return the seconds that one sweep takes, and its responses."""
    omega = np.linspace(0.05, 3.0, speeds)
    begin = time.perf_counter()
    found = sweep(omega=omega, **PARAMETERS, direction=direction, workers=workers, method=method)
    return time.perf_counter() - begin, found.response


def differences(found):
    """Print the points at which the two methods come to another response."""
    for label, (first, second) in found.items():
        apart = (first != second).values
        print(f"{label}: {apart.size} points, another response at {int(apart.sum())}")
        names = first.attrs["flag_meanings"].split()
        for place in np.argwhere(apart):
            here = first[tuple(place)].squeeze()
            kinds = [names[int(each.values[tuple(place)])] for each in (first, second)]
            where = ", ".join(f"{name} {float(here[name]):.4g}" for name in ("omega", "delta0"))
            print(f"    {where}, direction {here.direction.item()}: {kinds[0]}, {kinds[1]}")


def main():
    """Print seconds for each number of workers and method."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speeds", type=int, default=301)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    given = parser.parse_args()
    for method in METHODS:
        simulate(
            Rotor(omega=1.0, zeta=0.1, delta0=0.5), start=(0, 0, 0, 0), duration=1.0, method=method
        )
    print("| workers | method | from rest [s] | up and down [s] | together [s] | over adams |")
    print("|---|---|---|---|---|---|")
    for workers in given.workers:
        first = None
        for method in METHODS:
            rest, one = swept(given.speeds, None, workers, method)
            both, other = swept(given.speeds, "both", workers, method)
            if first is None:
                first, responses = rest + both, {"from rest": [one], "up and down": [other]}
            else:
                responses["from rest"].append(one)
                responses["up and down"].append(other)
            print(
                f"| {workers} | {method} | {rest:.2f} | {both:.2f} | {rest + both:.2f} "
                f"| {first / (rest + both):.2f} |",
                flush=True,
            )
    differences(responses)


if __name__ == "__main__":
    main()
