"""The sweeps of Fig. 11 on one core and on two: 4 clearances, 301 speeds, from rest, up and down.

python benchmarks/sweeps.py [--speeds 301] [--workers 1 2]
"""

import argparse
import time

import numpy as np

from rotor_ida import Rotor, simulate, sweep

PARAMETERS = {"zeta": 0.07, "delta0": [0.0, 0.5, 1.0, 2.0]}


def timed(speeds, direction, workers):
    """Return the seconds that one sweep takes, and its number of points."""
    omega = np.linspace(0.05, 3.0, speeds)
    begin = time.perf_counter()
    found = sweep(omega=omega, **PARAMETERS, direction=direction, workers=workers)
    return time.perf_counter() - begin, found.response.size


def main():
    """Print seconds for each number of workers, and how many times faster than the first."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speeds", type=int, default=301)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    given = parser.parse_args()
    simulate(Rotor(omega=1.0, zeta=0.1, delta0=0.5), start=(0, 0, 0, 0), duration=1.0)
    print("| workers | from rest [s] | up and down [s] | together [s] | faster |")
    print("|---|---|---|---|---|")
    first = None
    for workers in given.workers:
        rest, points = timed(given.speeds, None, workers)
        both, more = timed(given.speeds, "both", workers)
        first = first or rest + both
        ratio = first / (rest + both)
        print(f"| {workers} | {rest:.1f} | {both:.1f} | {rest + both:.1f} | {ratio:.2f} |")
    print(f"{points + more} points")


if __name__ == "__main__":
    main()
