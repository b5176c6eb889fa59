"""Simulate random machines by every method: all must find the same events.

Shaft, contact damping, load and friction are there or not; the contact is Hertz or linear; damping
is 0 or not. Each start is followed by Taylor series, and by Adams, BDF with integrated flight, and
as far as asked the reference. Counted are runs that raise, runs with other events (up to the first
that either run calls undecided), and event times further apart than the two runs state.

    python benchmarks/random_machines.py --count 1500
    python benchmarks/random_machines.py --count 1500 --reference 100 --seed 2
"""

import argparse
import sys

import numpy as np

from rotor_ida import Rotor, RotorError, simulate

WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-12},
    "adams": {"method": "adams", "rtol": 1e-12},
    "bdf": {"method": "bdf", "rtol": 1e-11, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-10},
}
WITNESS = "taylor"


def random_machine(rng):
    """Return a random machine, which has any of what it may have or not."""
    friction = rng.choice([0.0, rng.uniform(0.0, 0.1), rng.uniform(0.0, 1.0)])
    return Rotor(
        omega=rng.uniform(0.0, 3.0),
        zeta=rng.choice([0.0, 0.01, 0.07, 0.3]),
        delta0=rng.uniform(0.3, 3.0),
        shaft_stiffness=rng.choice([0.0, rng.uniform(0.0, 3.0)]),
        contact_exponent=rng.choice([1.0, 1.5]),
        load=rng.choice([0.0, rng.uniform(0.0, 1.0)]),
        contact_damping=rng.choice([0.0, rng.uniform(0.0, 0.5), rng.uniform(0.0, 5.0)]),
        friction=friction,
        disc_radius=rng.choice([0.0, 1.0, 3.0, 10.0]) if friction else None,
    )


def compared(one, other):
    """Return whether two runs have other events, and how many times are too far apart."""
    errors = [run.event_time_error.values for run in (one, other)]
    decided = [int(np.argmin(np.isfinite([*each, np.inf]))) for each in errors]
    count = min(decided)
    kinds = [run.event_kind.values[:count] for run in (one, other)]
    if not np.array_equal(*kinds):
        return True, 0
    apart = np.abs(one.event_time.values[:count] - other.event_time.values[:count])
    return False, int((apart > errors[0][:count] + errors[1][:count]).sum())


def main():
    """Run the study and print what came of it; exit 1 if a run failed or found other events."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1500)
    parser.add_argument("--reference", type=int, default=0, help="machines for the reference, too")
    parser.add_argument("--duration", type=float, default=15.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    names = [name for name in WAYS if name != "reference" or arguments.reference > 0]
    counts = {
        name: dict.fromkeys(("runs", "failed", "other", "events", "far"), 0) for name in names
    }
    for number in range(arguments.count):
        machine = random_machine(rng)
        start = tuple((rng.uniform(-1.5, 1.5, 4) * machine.delta0).tolist())
        found = {}
        for name in names:
            if name == "reference" and number >= arguments.reference:
                continue
            try:
                found[name] = simulate(
                    machine, start=start, duration=arguments.duration, samples=101, **WAYS[name]
                )
            except RotorError as error:
                counts[name]["failed"] += 1
                print(f"failed by {name}: {machine} {start}\n{error}")
        for name, run in found.items():
            counts[name]["runs"] += 1
            counts[name]["events"] += run.sizes["event"]
            if name != WITNESS and WITNESS in found:
                differs, far = compared(found[WITNESS], run)
                counts[name]["other"] += differs
                counts[name]["far"] += far
                if differs:
                    print(f"other events by {name}: {machine} {start}")
    print(
        "| method | runs | failed | events | runs with other events | times beyond their errors |"
    )
    print("|---|---|---|---|---|---|")
    for name, each in counts.items():
        print(f"| {name} | {each['runs']} | {each['failed']} | {each['events']} "
              f"| {each['other']} | {each['far']} |")  # fmt: skip
    return int(any(each["failed"] or each["other"] for each in counts.values()))


if __name__ == "__main__":
    sys.exit(main())
