"""How much the smallest shocks found hang on the draw: the same search from several seeds.

python benchmarks/shocks.py --seeds 20 --shocks 512
"""

import argparse

import numpy as np

from rotor_ida import Rotor, touchdown_report
from rotor_ida.basins.atlas import resilience
from rotor_ida.basins.atlas.shocks import KINDS

ROTOR = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


def shocks_found(seed, count):
    """Return the smallest shocks of both kinds from each attractor to each, by one draw."""
    true_search = resilience.try_shocks
    try:
        resilience.try_shocks = lambda *given, seed, own=seed, **how: true_search(
            *given, seed=seed + 1000 * own, **how
        )
        report = touchdown_report(ROTOR, x=(-8, 8), y=(-8, 8), starts=64, shocks=count)
    finally:
        resilience.try_shocks = true_search
    return np.array([report[f"{kind}_shock"].values for kind in KINDS])


def main():
    """Print the smallest and the largest found over the seeds, and the spread."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--shocks", type=int, default=512)
    arguments = parser.parse_args()
    found = np.array([shocks_found(seed, arguments.shocks) for seed in range(arguments.seeds)])
    print(f"{ROTOR}, {arguments.seeds} seeds, {arguments.shocks} shocks")
    for place in np.argwhere(np.isfinite(found).any(axis=0)).tolist():
        sizes = found[(slice(None), *place)]
        low, high = float(np.nanmin(sizes)), float(np.nanmax(sizes))
        kind, (one, to) = list(KINDS)[place[0]], place[1:]
        print(
            f"{kind:12} {one} -> {to}: {low:.5f} to {high:.5f}, {100.0 * (high / low - 1.0):.3f} %"
        )


if __name__ == "__main__":
    main()
