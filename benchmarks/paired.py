"""How fast this tree is beside another checkout: ratios of two workers that take turns.

Each checkout has a worker process with its own Python. Turn by turn both do the same task, each as
often as fills a twentieth of a second; what counts is the time that the process spent on the
processor. Given is the median of new/old over the turns, with an interval that holds the true
median at 95 % whatever the distribution: two order statistics. All runs in one thread.

    python benchmarks/paired.py --other-python ../old/venv/bin/python --other-tree ../old/repo
    python benchmarks/paired.py ... --only "basin" "sweep" --turns 20
"""

import argparse
import json
import math
import os
import shutil
import statistics
import subprocess
import sys
import time
from functools import partial
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).resolve()
LEAST = 0.05
REST = (0.0, 0.0, 0.0, 0.0)
# omega, zeta, delta0, start
MOTIONS = {
    "full contact": (1.2, 0.07, 0.5, REST),
    "bouncing": (2.0, 0.07, 2.0, REST),
    "no clearance": (1.7, 0.07, 0.0, REST),
    "from (3, 1)": (3.0, 0.07, 0.5, (3.0, 1.0, 0.0, 0.0)),
}
BASINS = {
    "no clearance": (1.7, 0.07, 0.0),
    "delta0 0.5": (1.7, 0.07, 0.5),
    "bouncing": (2.0, 0.07, 2.0),
}
RUNS = (("taylor", 1e-9), ("taylor", 1e-12), ("adams", 1e-9), ("bdf", 1e-9))
COVERED = 0.95
FEWEST = 6  # turns: below, even the extremes hold the median less often than that


def tasks():
    """Return the functions to time by their names; both checkouts offer what they call."""
    return runs() | maps() | cycles() | basins()


def runs():
    """Single motions: bare runs, `simulate` and exponents."""
    import numpy as np  # noqa: PLC0415 - of the worker's own Python

    import rotor_ida as r  # noqa: PLC0415
    from rotor_ida.simulation.options import Options  # noqa: PLC0415
    from rotor_ida.simulation.run import run  # noqa: PLC0415

    found = {}
    for name, (*numbers, start) in MOTIONS.items():
        rotor, duration = rotor_of(*numbers), 100.0 * 2.0 * math.pi / numbers[0]
        times = np.linspace(0.0, duration, 2001)
        for method, rtol in RUNS:
            options = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
            found[f"bare run, {name}, {method} {rtol:.0e}"] = partial(
                run, rotor, start, duration, times, options
            )
        for method in ("taylor", "adams"):
            found[f"simulate, {name}, {method}"] = partial(
                r.simulate, rotor, start=start, duration=duration, samples=2001,
                rtol=1e-9, atol=1e-11, method=method,
            )  # fmt: skip
        for method, lead, length in (("taylor", 100.0, 400.0), ("adams", 20.0, 40.0)):
            found[f"lyapunov_exponent, {name}, {method}"] = partial(
                r.lyapunov_exponent, rotor, start=start, transient=lead,
                duration=length, batches=4, method=method,
            )  # fmt: skip
    for name in ("adams", "ida"):
        times, options = np.linspace(0.0, 50.0, 201), Options(method=name, backend="python")
        found[f"bare run, full contact, python {name}"] = partial(
            run, rotor_of(1.2, 0.07, 0.5), REST, 50.0, times, options
        )
    return found


def maps():
    """Sweeps, sections and bifurcation diagrams."""
    import numpy as np  # noqa: PLC0415

    import rotor_ida as r  # noqa: PLC0415

    found = {}
    grid = {"omega": [1.2, 1.7, 2.4], "zeta": 0.07, "delta0": [0.0, 0.5, 2.0], "workers": 1}
    for method in ("adams", "taylor"):
        found[f"sweep, {method}"] = partial(r.sweep, **grid, method=method)
        found[f"poincare_section, {method}"] = partial(
            r.poincare_section, bouncing(), start=REST, revolutions=100, at="peak", method=method
        )
        found[f"bifurcation_diagram, {method}"] = partial(
            r.bifurcation_diagram, omega=[2.0, 2.2], zeta=0.07, delta0=2.0, workers=1, method=method
        )
    found["sweep up and down, taylor"] = partial(
        r.sweep, **grid | {"omega": np.linspace(1.5, 2.5, 6)}, direction="both", method="taylor"
    )
    return found


def cycles():
    """Limit cycles, shooting and branches."""
    import numpy as np  # noqa: PLC0415

    import rotor_ida as r  # noqa: PLC0415

    shoot = shooting()
    cycle = r.limit_cycle(bouncing(), start=REST)
    state = np.array([float(cycle[name].values[0]) for name in ("x", "y", "vx", "vy")])
    period = float(cycle.period)
    return {
        "limit_cycle": partial(r.limit_cycle, bouncing(), start=REST),
        "shooting": partial(shoot, state, period),
        "continue_cycle": partial(r.continue_cycle, bouncing(), start=REST, limits=(1.9, 2.1)),
        "continue_cycle, the isola": partial(
            r.continue_cycle, bouncing(), start=cycle, limits=(0.05, 5.0)
        ),
    }


def shooting():
    """Return the function of a state and a period that follows an orbit with its derivatives."""
    import numpy as np  # noqa: PLC0415

    try:
        return import_module("rotor_ida.simulation.flow").DiscFlow(bouncing()).run
    except ImportError:  # an earlier checkout
        shoot = import_module("rotor_ida.simulation.neighbours").shoot
        return partial(shoot, bouncing(), stop=np.zeros(1, np.uint8))


def basins():
    """Basins on two grids, and their fractions."""
    import numpy as np  # noqa: PLC0415

    import rotor_ida as r  # noqa: PLC0415

    found = {}
    for name, numbers in BASINS.items():
        rotor = rotor_of(*numbers)
        for cells in (64, 128):
            axis = np.linspace(-15.0, 15.0, cells)
            found[f"basin, {name}, {cells} x {cells}"] = partial(
                r.basin, rotor, x=axis, y=axis, workers=1
            )
        found[f"basin_fractions, {name}"] = partial(
            r.basin_fractions, rotor, x=(-15.0, 15.0), y=(-15.0, 15.0), starts=2000, workers=1
        )
    return found


def rotor_of(omega, zeta, delta0):
    """Return a rotor of the checkout whose Python this is."""
    from rotor_ida import Rotor  # noqa: PLC0415

    return Rotor(omega=omega, zeta=zeta, delta0=delta0)


def bouncing():
    """Return the rotor that bounces."""
    return rotor_of(*MOTIONS["bouncing"][:3])


def work():
    """Do tasks as they are asked for, line by line, and say how long one took on the processor."""
    known = tasks()
    print(json.dumps(list(known)), flush=True)
    for line in sys.stdin:
        name, count = json.loads(line)
        began = time.process_time()
        for _ in range(count):
            known[name]()
        print(json.dumps((time.process_time() - began) / count), flush=True)


class Worker:
    """A process that does the tasks of one checkout."""

    def __init__(self, python, tree):
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            [python, str(HERE), "--worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            text=True, env=os.environ | threads | {"PYTHONPATH": str(tree)},
        )  # fmt: skip
        self.names = self.answer()

    def answer(self):
        """Return what the worker says next."""
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit("a worker ended: see its message above")
        return json.loads(line)

    def time(self, name, count):
        """Return seconds of the processor for a task, done so often."""
        self.process.stdin.write(json.dumps([name, count]) + "\n")
        self.process.stdin.flush()
        return self.answer()


def interval(ratios):
    """Return the order statistics that hold the true median at `COVERED`, by the binomial law."""
    ordered, count = sorted(ratios), len(ratios)
    rank, outside = 0, 2.0 / 2.0**count
    while outside <= 1.0 - COVERED and rank < count // 2:
        rank += 1
        outside += 2.0 * math.comb(count, rank) / 2.0**count
    below = max(rank - 1, 0)
    return ordered[below], ordered[count - 1 - below]


def compare(name, old, new, turns):
    """Return the medians of both, and the ratio new/old in each turn."""
    first = old.time(name, 1), new.time(name, 1)  # warms up
    count = max(1, min(200, int(LEAST / max(*first, 1e-5))))
    taken = {old: [], new: []}
    for turn in range(turns):
        for worker in (old, new) if turn % 2 else (new, old):
            taken[worker].append(worker.time(name, count))
    ratios = [b / a for a, b in zip(taken[old], taken[new], strict=True)]
    return statistics.median(taken[old]), statistics.median(taken[new]), ratios


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--other-python")
    parser.add_argument("--other-tree", type=Path)
    parser.add_argument("--turns", type=int, default=20)
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.worker:
        work()
        return
    if not arguments.other_python or not arguments.other_tree:
        parser.error("--other-python and --other-tree must be given")
    if shutil.which(arguments.other_python) is None:
        parser.error(f"--other-python must be a Python, got {arguments.other_python!r}")
    if arguments.turns < FEWEST:
        parser.error(f"--turns must be at least {FEWEST}, got {arguments.turns}")
    old = Worker(arguments.other_python, arguments.other_tree.resolve())
    new = Worker(sys.executable, HERE.parents[1])
    print(
        f"Load {os.getloadavg()[0]:.1f}; medians of {arguments.turns} turns, ms of processor time"
    )
    print("\n| task | old | new | new/old | its interval |\n|---|---|---|---|---|")
    slower = []
    for name in new.names:
        if name not in old.names or not any(text in name for text in arguments.only):
            continue
        before, after, ratios = compare(name, old, new, arguments.turns)
        low, high = interval(ratios)
        slower += [name] if low > 1.0 else []
        print(
            f"| {name} | {1e3 * before:.3f} | {1e3 * after:.3f} | {statistics.median(ratios):.3f} "
            f"| {low:.3f} to {high:.3f} |",
            flush=True,
        )
    print(f"\nSlower, as the whole interval says: {', '.join(slower) or 'none'}.")
    print(f"Load {os.getloadavg()[0]:.1f} at the end.")


if __name__ == "__main__":
    main()
