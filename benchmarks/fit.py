"""Whether fits cover the truth as often as they say, and how fast they are.

Run-ups onto the ring, and a rotor that bounces on it under a load, are measured with noise, again
and again; their contact times with errors. Of each unknown the truth must lie within the 95 %
interval in 95 of 100 trials, and chi-square must follow its law.

    python benchmarks/fit.py [--trials 300]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.stats import binom, chi2

from rotor_ida import DimensionalRotor, Rotor, fit, run_up, signals_of, simulate

LEVEL, CHANCE = 0.95, 1e-3
# Machine, its run, what is sought, noise and error of contact times.
CASES = {
    "run-up onto the ring": (
        Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0),
        {"start": (0, 0, 0, 0), "to": 2.0, "rate": 0.02, "samples": 2501},
        {"zeta": 0.1, "delta0": 1.5, "shaft_stiffness": 1.0},
        0.02,
        0.01,
    ),
    "bouncing under a load": (
        Rotor(omega=2.2, zeta=0.05, delta0=1.5, shaft_stiffness=0.25, load=0.2,
              contact_damping=0.1),
        {"start": (0.5, -1, 0, 0), "duration": 120.0, "samples": 3001},
        {"zeta": 0.05, "delta0": 1.5, "shaft_stiffness": 0.25, "contact_damping": 0.1},
        0.02,
        0.03,
    ),
    "machine in SI units": (
        DimensionalRotor(
            mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5, clearance=2e-5,
            speed=20.0, shaft_stiffness=4e4,
        ),
        {"to": 250.0, "rate": 15.0, "samples": 12_001},
        {"damping": 89.1, "clearance": 2e-5, "eccentricity": 1e-5, "unbalance_angle": 0.0},
        1.5e-6,
        1e-3,
    ),
}  # fmt: skip


def measured(case):
    """Return the signals of a case without noise, and when contacts begin and end."""
    machine, asked, *_ = CASES[case]
    if isinstance(machine, DimensionalRotor):
        run = run_up(machine, **asked)
    else:
        run = (run_up if "to" in asked else simulate)(machine, **asked)
    times, kinds = run["event_time"].values, run["event_kind"].values
    return signals_of(run), {"entries": times[kinds == 1], "exits": times[kinds == -1]}


def trials_of(case, trials, rng):
    """Return estimates in their errors, whether covered, chi-square over its freedom, seconds."""
    machine, _, truth, noise, time_error = CASES[case]
    seen, contacts = measured(case)
    names, values = list(truth), np.array(list(truth.values()))
    size = seen.sizes["t"]
    off, covered, squares, freedom, took = [], np.zeros(values.size), 0.0, 0, 0.0
    for _ in range(trials):
        noisy = seen.assign(
            {n: seen[n].copy(data=seen[n].values + rng.normal(0.0, noise, size)) for n in "xy"}
        )
        times = {
            name: np.sort(each + rng.normal(0.0, time_error, each.size))
            for name, each in contacts.items()
        }
        begun = time.perf_counter()
        found = fit(noisy, machine, names, time_error=time_error, **times)
        took += time.perf_counter() - begun
        off.append((found["estimate"].values - values) / found["standard_error"].values)
        covered += (found["lower"].values <= values) & (found["upper"].values >= values)
        squares += float(found["chi_square"])
        freedom += int(found["degrees_of_freedom"])
    return np.array(off), covered, squares, freedom, took / trials


def main() -> None:
    """Fit each case again and again, and tell how the truth was covered."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--case", choices=CASES, action="append", help="by default all")
    asked = parser.parse_args()
    trials, cases = asked.trials, asked.case or list(CASES)
    rng = np.random.default_rng(2026)
    wrong = 0
    low, high = binom.ppf([CHANCE / 2.0, 1.0 - CHANCE / 2.0], trials, LEVEL)
    print(f"{trials} trials, {low:.0f} to {high:.0f} of them should cover the truth")
    for case in cases:
        truth = CASES[case][2]
        off, covered, squares, freedom, took = trials_of(case, trials, rng)
        print(f"\n{case}: {took:.2f} s a fit")
        for name, count, column in zip(truth, covered, off.T, strict=True):
            right = low <= count <= high
            wrong += not right
            print(
                f"  {name:16} covered {count:.0f}, errors {column.mean():+.2f} +- "
                f"{column.std():.2f} of those stated{'' if right else '  WRONG'}"
            )
        bounds = chi2.ppf([CHANCE / 2.0, 1.0 - CHANCE / 2.0], freedom) / freedom
        right = bounds[0] <= squares / freedom <= bounds[1]
        wrong += not right
        print(
            f"  chi-square over its degrees of freedom {squares / freedom:.4f}, from "
            f"{bounds[0]:.4f} to {bounds[1]:.4f}{'' if right else '  WRONG'}"
        )
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
