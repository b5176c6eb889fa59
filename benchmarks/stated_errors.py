"""How well the stated errors of event times cover the true ones: the reference events, by method.

Given are the share of the events whose error is no larger than the one stated, by how much that
exceeds the true one in the median, and the runs that found other events. Of random rotor systems
the true times are those of runs by Taylor series at the tightest tolerance, and the last column
counts runs that were refused too.

    python benchmarks/stated_errors.py [--systems 0]
"""

import argparse

import numpy as np
from event_table import DATA, load, simulated

from rotor_ida import SimulationError
from tests.random_systems import followed, stated_and_true

TOLERANCES = {
    "adams": [10.0**-power for power in range(6, 14)],
    "taylor": [10.0**-power for power in range(6, 16)],
}
# Of systems only the first of these tolerances are asked: the rest are too near to the tightest.
MOST_OF_SYSTEMS = 6


def stated(case, method, rtol):
    """Return stated and true errors of the events of a run; None where it found others."""
    run = simulated(case, method, rtol)
    if run.event_kind.values.tolist() != [kind for kind, _, _ in case["events"]]:
        return None
    right = np.array([float(time) for _, time, _ in case["events"]])
    return run.event_time_error.values, np.abs(run.event_time.values - right)


def stated_of_systems(seeds, method, rtol):
    """Return stated and true errors for each random rotor system; None where a run fails."""
    found = []
    for seed in seeds:
        try:
            best = followed(seed, 10.0, rtol=1e-14)
            run = followed(seed, 10.0, rtol=rtol, method=method)
            found.append(stated_and_true(run, best))
        except (SimulationError, AssertionError):
            found.append(None)
    return found


def main():
    """Print a line for each method and tolerance."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--systems", type=int, default=0, help="random rotor systems instead")
    count = parser.parse_args().systems
    cases = [case for path in sorted(DATA.glob("contact_events.json")) for case in load(path)]
    print("| method | rtol | events | covered | over the true error | runs with other events |")
    print("|---|---|---|---|---|---|")
    for method, tolerances in TOLERANCES.items():
        for rtol in tolerances[: MOST_OF_SYSTEMS if count else None]:
            found = (
                stated_of_systems(range(400, 400 + count), method, rtol)
                if count
                else [stated(case, method, rtol) for case in cases]
            )
            right = [pair for pair in found if pair is not None]
            said, true = (np.concatenate(each) for each in zip(*right, strict=True))
            over = np.median(said[true > 0.0] / true[true > 0.0])
            print(
                f"| {method} | {rtol:.0e} | {true.size} | {np.mean(said >= true):.4f} "
                f"| {over:.1f} | {len(found) - len(right)} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
