"""How far long runs drift: the largest radius of a limit cycle, long after a run has come to it.

The cycle attracts, so what is wrong with its radius is no error that adds up along the orbit: it is
what the steps themselves leave of it. It must not grow with time. A window of the run is looked at,
one run to each of a few times, and its extrema, which are events of the core, are held against
the cycle of `limit_cycle`.

    python benchmarks/drift.py [--quick]
"""

from __future__ import annotations

import argparse

import numpy as np

from rotor_ida import Rotor, limit_cycle
from rotor_ida.simulation.options import Method, Options
from rotor_ida.simulation.run import run

# A limit cycle in full contact, at which the rotor stays in one contact for ever.
ROTOR, START = Rotor(omega=3.0, zeta=0.07, delta0=0.5), (3.0, 1.0, 0.0, 0.0)
# So many periods that the largest of their errors is no matter of chance.
WINDOW = 1000.0
CASES: list[tuple[Method, float]] = [
    ("taylor", 1e-6),
    ("taylor", 1e-9),
    ("adams", 1e-6),
    ("adams", 1e-9),
    ("bdf", 1e-6),
    ("bdf", 1e-9),
    ("ida", 1e-6),
]


def error_of_radius(method: Method, rtol: float, time: float, radius: float) -> float:
    """Return by how much the largest radius after `time` is wrong."""
    options = Options(method=method, rtol=rtol)
    orbit = run(ROTOR, START, time + WINDOW, np.empty(0), options, extrema=True)
    assert orbit.extrema is not None
    late = orbit.extrema[orbit.extrema["time"] >= time]
    return float(late["radius"].max()) - radius


def main() -> None:
    """Print the errors, a line for each method and tolerance."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="times up to 1e4")
    times = (1e3, 1e4) if parser.parse_args().quick else (1e3, 1e4, 3e4, 1e5)
    radius = float(limit_cycle(ROTOR, start=START).radius_max)
    print(f"radius_max of the cycle {radius!r}")
    print("method   rtol   " + "  ".join(f"t = {time:<8.0e}" for time in times))
    for method, rtol in CASES:
        errors = [error_of_radius(method, rtol, time, radius) for time in times]
        print(f"{method:8} {rtol:.0e}  " + "  ".join(f"{error:+12.2e}" for error in errors))


if __name__ == "__main__":
    main()
