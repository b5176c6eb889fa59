"""Whether fits end, and how, from guesses that are up to a fifth off.

Random machines run up through their critical speed, or turn at one speed, and touch the ring; some
have a load, friction or contact damping. Two to six parameters are unknown, in SI units or without
dimensions. Each fit must end in time, and be right, or say in words that it is not.

    python benchmarks/fit_guesses.py [--trials 200] [--first 0] [--jobs 2]
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from rotor_ida import (
    DimensionalRotor,
    InputError,
    RotorError,
    dimensional,
    fit,
    run_up,
    signals_of,
    simulate,
)

FARTHEST, LONGEST = 0.2, 30.0
# Where a machine cannot be measured, that of another seed is.
FURTHER = 1_000_000
# Noise over the largest displacement; and how many standard errors off an estimate may be.
NOISE, SURE = 0.01, 6.0
SI = ("damping", "clearance", "eccentricity", "shaft_stiffness", "contact_stiffness", "mass")
PLAIN = {"damping": "zeta", "clearance": "delta0", "shaft_stiffness": "shaft_stiffness"}
MORE = ("contact_damping", "load", "friction")


def machine_of(rng):
    """Return a machine that touches its ring near its critical speed."""
    mass, critical = 10.0 ** rng.uniform(0.0, 2.0), 10.0 ** rng.uniform(1.5, 2.7)
    damping_ratio, eccentricity = 10.0 ** rng.uniform(-1.6, -0.7), 10.0 ** rng.uniform(-5.5, -4.3)
    stiffness, reached = mass * critical**2, 0.5 * eccentricity / damping_ratio
    clearance = reached * rng.uniform(0.3, 0.9)
    exponent = float(rng.choice([1.5, 1.5, 1.0]))
    ratio = 10.0 ** rng.uniform(0.0, 2.5)
    more = {}
    if rng.random() < 0.3:
        more["contact_damping"] = rng.uniform(0.05, 0.5) / (critical * clearance)
    if rng.random() < 0.3:
        more["load"] = rng.uniform(0.05, 0.5) * stiffness * clearance
    if rng.random() < 0.2:
        more |= {"friction": rng.uniform(0.02, 0.15), "disc_radius": rng.uniform(0.05, 0.2)}
    return DimensionalRotor(
        mass=mass, damping=2.0 * damping_ratio * mass * critical, eccentricity=eccentricity,
        clearance=clearance, shaft_stiffness=stiffness, contact_exponent=exponent,
        contact_stiffness=ratio * stiffness * clearance ** (1.0 - exponent),
        speed=0.3 * critical, **more,
    ), critical  # fmt: skip


def measured(machine, critical, rng):
    """Return a run of the machine from rest, up through the critical speed or at one speed."""
    revolutions = rng.uniform(60.0, 200.0)
    if rng.random() < 0.6:
        low, high = 0.4 * critical, rng.uniform(1.3, 2.2) * critical
        duration = 2.0 * np.pi * revolutions / (0.5 * (low + high))
        machine = DimensionalRotor(**{**machine.given, "speed": low})
        samples = 1 + int(revolutions * 40)
        return machine, run_up(machine, to=high, rate=(high - low) / duration, samples=samples)
    machine = DimensionalRotor(**{**machine.given, "speed": rng.uniform(0.7, 1.6) * critical})
    rotor = machine.rotor()
    return machine, simulate(
        rotor, start=(0, 0, 0, 0), duration=2.0 * np.pi * revolutions / rotor.omega,
        samples=1 + int(revolutions * 30),
    )  # fmt: skip


def trial(seed):
    """Return how one fit ended, its seconds, and what it was of."""
    rng = np.random.default_rng(seed)
    machine, run = measured(*machine_of(rng), rng)
    in_si, rotor = rng.random() < 0.5, machine.rotor()
    try:
        seen = signals_of(dimensional(run, machine) if in_si else run)
    except InputError:  # a whirl too fast for its samples
        return trial(seed + FURTHER)
    size = NOISE * float(np.hypot(seen.x, seen.y).max())
    seen = seen.assign(
        {
            n: seen[n].copy(data=seen[n].values + rng.normal(0.0, size, seen.sizes["t"]))
            for n in "xy"
        }
    )
    true = machine if in_si else rotor
    known = [*(SI if in_si else PLAIN.values()), *(name for name in MORE if true.given.get(name))]
    count = int(rng.integers(2, min(6, len(known)), endpoint=True))
    names = sorted(rng.choice(known, count, replace=False).tolist())
    off = {name: getattr(true, name) * (1.0 + rng.uniform(-FARTHEST, FARTHEST)) for name in names}
    guess = type(true)(**{**true.given, **off})
    what = f"{'SI' if in_si else 'dimensionless'} {'run-up' if 'speed' in run else 'one speed'}"
    begun = time.perf_counter()
    try:
        found = fit(seen, guess, names)
    except RotorError as error:
        return f"refused: {str(error)[:60]}", time.perf_counter() - begun, what, names, 0
    took = time.perf_counter() - begun
    return _ended(found, true, names), took, what, names, found.attrs["evaluations"]


def _ended(found, true, names):
    """Return how a fit ended: right, told to be doubtful, or wrong without a word."""
    away = (found.estimate.values - [getattr(true, name) for name in names]) / np.where(
        np.isfinite(found.standard_error), found.standard_error, np.inf
    )
    search = found.attrs["search"]
    if search != "converged":
        return f"told: {search.split(':')[0]}"
    if found.attrs["remainder"].startswith("the residuals exceed"):
        return "told: the residuals exceed the noise"
    return "right" if (np.abs(away) < SURE).all() else "WRONG without a word"


def main() -> int:
    """Fit each machine, and tell how the fits ended and how long they took."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.trials)
    ends, times = Counter(), []
    with ProcessPoolExecutor(asked.jobs) as pool:
        for seed, (end, took, what, names, trials) in zip(
            seeds, pool.map(trial, seeds), strict=True
        ):
            ends[end.split(":")[0]] += 1
            times.append(took)
            if end != "right" or took > LONGEST / 3.0:
                print(f"{seed}: {end}; {took:.1f} s, {trials} trials, {what}, {', '.join(names)}")
    late = sum(each > LONGEST for each in times)
    print(", ".join(f"{count} {end}" for end, count in ends.most_common()))
    print(
        f"seconds: median {np.median(times):.2f}, longest {max(times):.1f}; {late} over {LONGEST:g}"
    )
    return 1 if late or ends["WRONG without a word"] else 0


if __name__ == "__main__":
    raise SystemExit(main())
