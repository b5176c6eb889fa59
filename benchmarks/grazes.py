"""Which grazes are found, and which misses are told from them: for each flight and tolerance.

Random free orbits are taken up to their first peak of |z|. The ring is put just inside it, so
that the orbit touches by e, then just outside, so that it misses by as much.

    python benchmarks/grazes.py --orbits 1000
"""

import argparse
import math

import numpy as np
from scipy.optimize import brentq

from rotor_ida import Rotor, simulate
from tests.core.flight import fly

SIZES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
MULTIPLES = (10.0, 1e2, 1e3, 1e4)
TOLERANCES = (1e-6, 1e-9, 1e-12)


def random_orbit(rng):
    """Return a flight that rises to a first peak: omega, zeta, start, time and height of it."""
    while True:
        omega = math.exp(rng.uniform(math.log(0.1), math.log(6.0)))
        zeta = float(rng.choice([0.0, 1e-8, 0.07, math.exp(rng.uniform(math.log(1e-3), 0.0))]))
        start = np.concatenate([rng.normal(scale=0.5, size=2), rng.normal(size=2)])
        rotor = Rotor(omega=omega, zeta=zeta, delta0=0.0)
        times = np.linspace(0.0, 12.0, 3001)
        rows = fly(rotor, start, times)
        radius = np.hypot(rows[:, 0], rows[:, 1])
        rate = rows[:, 0] * rows[:, 2] + rows[:, 1] * rows[:, 3]
        turns = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
        if not turns.size:
            continue

        def rising(time, rotor=rotor, start=start):
            x, y, vx, vy = fly(rotor, start, time)[0]
            return x * vx + y * vy

        first = turns[0]
        peak = brentq(rising, times[first], times[first + 1], xtol=1e-15)
        height = np.hypot(*fly(rotor, start, peak)[0, :2])
        if radius[0] < height - 1e-2 and radius[: first + 1].max() <= height and height > 0.2:
            return omega, zeta, tuple(start.tolist()), peak, height


def touches(orbit, offset, flight, method, rtol):
    """Return whether the simulator sees a touch of a ring at the peak's height plus `offset`."""
    omega, zeta, start, peak, height = orbit
    rotor = Rotor(omega=omega, zeta=zeta, delta0=height + offset)
    run = simulate(
        rotor,
        start=start,
        duration=peak + 1e-2,
        samples=2,
        rtol=rtol,
        atol=rtol / 100,
        method=method,
        flight=flight,
    )
    return bool(run.sizes["event"])


def main():
    """Print the table as Markdown: touches missed and touches invented, of so many orbits."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--orbits", type=int, default=100)
    count = parser.parse_args().orbits
    rng = np.random.default_rng(3)
    orbits = [random_orbit(rng) for _ in range(count)]
    print(f"Missed / invented, of {count} orbits each. Flight in closed form:\n")
    print("| contact | " + " | ".join(f"e = {size:.0e}" for size in SIZES) + " |")
    print("|---|" + "---|" * len(SIZES))
    for method in ("adams", "taylor"):
        cells = [cell(orbits, size, "exact", method, 1e-10) for size in SIZES]
        print(f"| {method} | " + " | ".join(cells) + " |", flush=True)
    print("\nFlight integrated, e in tolerances:\n")
    print("| method | rtol | " + " | ".join(f"e = {m:g} rtol" for m in MULTIPLES) + " |")
    print("|---|---|" + "---|" * len(MULTIPLES), flush=True)
    for method in ("adams", "bdf", "ida"):
        for rtol in TOLERANCES:
            cells = [cell(orbits, m * rtol, "cvode", method, rtol) for m in MULTIPLES]
            print(f"| {method} | {rtol:.0e} | " + " | ".join(cells) + " |", flush=True)


def cell(orbits, size, *way):
    """Return how many touches of depth `size` are missed, and how many misses are touches."""
    missed = sum(not touches(orbit, -size, *way) for orbit in orbits)
    invented = sum(touches(orbit, size, *way) for orbit in orbits)
    return f"{missed} / {invented}"


if __name__ == "__main__":
    main()
