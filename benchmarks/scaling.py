"""How the cost of a run grows, and with what: tables in Markdown.

Tolerance, duration, number of samples and number of contacts for one run; number of runs and
number of threads for many (a run in compiled code releases Python's lock); and whether a long
row of runs leaves memory behind. Each table by its own name, or all of them:

    python benchmarks/scaling.py
    python benchmarks/scaling.py --method taylor
    python benchmarks/scaling.py threads --runs 200
    python benchmarks/scaling.py memory --runs 100000
"""

import argparse
import gc
import resource
import statistics
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from hashlib import sha256
from pathlib import Path

import numpy as np
import ways
from measuring import ROUNDS, clocked, in_turn, machine

from rotor_ida import Rotor, simulate
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

RTOL = 1e-9
THREADS = (1, 2, 4)
GROUP = 1000


def table(title, clocks, rounds, facts=None):
    """Measure clocks in turn and print a line for each: its time, and that over the first."""
    times = in_turn(clocks, rounds)
    first = times[next(iter(clocks))].median
    print(f"\n| {title} | {'events | evaluations | ' if facts else ''}ms | times the first |")
    print("|---|---|---|" + ("---|---|" if facts else ""))
    for name, spent in times.items():
        extra = f"{facts[name]} | " if facts else ""
        print(f"| {name} | {extra}{1e3 * spent.median:.2f} | {spent.median / first:.2f} |")


def facts_of(case, method, rtol=RTOL):
    """Return events and evaluations of a run, as cells."""
    options = Options(rtol=rtol, atol=ways.ATOL * rtol, method=method)
    orbit = run(case.rotor, case.start, case.duration, case.times, options)
    return f"{orbit.event_times.size} | {orbit.evaluations:,}"


def tolerance(arguments):
    """Measure the bare run at eight tolerances."""
    for case in (ways.FULL_CONTACT, ways.BOUNCING):
        grid = {f"{case.name}, rtol {10.0**-p:.0e}": 10.0**-p for p in range(5, 13)}
        method = arguments.method
        clocks = {
            name: clocked(ways.ours(case, rtol, method=method)) for name, rtol in grid.items()
        }
        facts = {name: facts_of(case, method, rtol) for name, rtol in grid.items()}
        table("tolerance", clocks, arguments.rounds, facts)


def several(title, cases, arguments):
    """Measure the bare run of several cases."""
    method = arguments.method
    clocks = {name: clocked(ways.ours(case, RTOL, method=method)) for name, case in cases.items()}
    facts = {name: facts_of(case, method) for name, case in cases.items()}
    table(title, clocks, arguments.rounds, facts)


def duration(arguments):
    """Measure runs of more and more revolutions, 20 samples each."""
    for base in (ways.FULL_CONTACT, ways.BOUNCING):
        cases = {
            f"{base.name}, {turns} revolutions": replace(
                base, revolutions=float(turns), samples=20 * turns + 1
            )
            for turns in (25, 50, 100, 200, 400)
        }
        several("duration", cases, arguments)


def samples(arguments):
    """Measure runs that report more and more samples."""
    for base in (ways.FULL_CONTACT, ways.BOUNCING):
        cases = {
            f"{base.name}, {number:,} samples": replace(base, samples=number)
            for number in (2, 201, 2001, 20001, 200001)
        }
        several("samples", cases, arguments)


def contacts(arguments):
    """Measure 100 revolutions with more and more contacts: the clearance sets how many."""
    grid = (0.5, 1.0, 1.5, 2.0, 3.0)
    start = (0.0, 0.0, 3.0, 0.0)
    cases = {
        f"delta0 = {delta0:g}": replace(ways.BOUNCING, delta0=delta0, start=start)
        for delta0 in grid
    }
    several("contacts", cases, arguments)


def starts(count):
    """Return so many starts for the bouncing run."""
    rng = np.random.default_rng(1)
    return [tuple(row) for row in rng.uniform(-1.4, 1.4, (count, 4)).tolist()]


def bare(start, method):
    """Do one bare run of the bouncing case."""
    case = ways.BOUNCING
    options = Options(rtol=RTOL, atol=ways.ATOL * RTOL, method=method)
    return run(case.rotor, start, case.duration, np.array([0.0, case.duration]), options)


def runs(arguments):
    """Measure the same run over and over, one after the other."""
    start = ways.BOUNCING.start
    clocks = {
        f"{count} runs": clocked(
            lambda count=count: [bare(start, arguments.method) for _ in range(count)]
        )
        for count in (1, 10, 100)
    }
    table("number of runs", clocks, arguments.rounds)


def threads(arguments):
    """Measure the same runs on one thread and on more: by the clock, as cores are the matter.

    Beside them stands work that is known to share nothing, a checksum: it shows how much of the
    cores there was to be had. Whatever else runs takes away from both, so the least time counts.
    """
    given = starts(arguments.runs or 200)
    block = bytes(len(given) * 100_000)
    work = {
        "runs": (partial(bare, method=arguments.method), given),
        "checksums": (lambda _: sha256(block).digest(), range(40)),
    }
    found = {(name, count): [] for name in work for count in THREADS}
    for turn in range(arguments.rounds + 1):
        for (name, count), spent in found.items():
            began = time.perf_counter()
            with ThreadPoolExecutor(count) as pool:
                list(pool.map(*work[name]))
            if turn:
                spent.append(time.perf_counter() - began)
    print("\n| work | threads | s, median | s, least | times as fast as one: median | least |")
    print("|---|---|---|---|---|---|")
    for (name, count), spent in found.items():
        one = found[name, 1]
        gain = statistics.median(a / b for a, b in zip(one, spent, strict=True))
        print(
            f"| {len(given) if name == 'runs' else 40} {name} | {count} "
            f"| {statistics.median(spent):.2f} | {min(spent):.2f} "
            f"| {gain:.2f} | {min(one) / min(spent):.2f} |"
        )


def memory(arguments):
    """Do many short runs in a row and print the resident size on the way."""
    total = arguments.runs or 100_000
    rotor, rng = Rotor(omega=2.0, zeta=0.07, delta0=2.0), np.random.default_rng(2)
    how = {"rtol": RTOL, "atol": ways.ATOL * RTOL, "method": arguments.method}
    options = Options(**how)
    times = np.linspace(0.0, 4.0, 5)
    events, marks = 0, {}
    began = time.perf_counter()
    for number in range(total + 1):
        if number in {total // 100, total // 10, total // 2, total}:
            gc.collect()
            marks[number] = resident()
        start = tuple(rng.uniform(-3.0, 3.0, 4).tolist())
        if number % GROUP:
            events += run(rotor, start, 4.0, times, options).event_times.size
        else:
            events += simulate(rotor, start=start, duration=4.0, samples=5, **how).sizes["event"]
    spent = time.perf_counter() - began
    print(f"\n{total:,} runs, {events:,} events, {spent:.0f} s\n")
    print("| after runs | resident, MiB |\n|---|---|")
    for number, size in marks.items():
        print(f"| {number:,} | {size:.1f} |")


def resident():
    """Return the resident size of this process [MiB]; its peak where no more is known."""
    status = Path("/proc/self/statm")
    if status.exists():
        pages = int(status.read_text(encoding="ascii").split()[1])
        return pages * resource.getpagesize() / 2**20
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20


TABLES = {
    way.__name__: way for way in (tolerance, contacts, duration, samples, runs, threads, memory)
}


def main():
    """Print the tables asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(TABLES))
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--method", choices=("adams", "bdf", "taylor"), default="adams")
    parser.add_argument("--runs", type=int, help="of the tables of threads and memory")
    arguments = parser.parse_args()
    unknown = set(arguments.tables) - set(TABLES)
    if unknown:
        parser.error(f"no table {', '.join(sorted(unknown))}: choose from {', '.join(TABLES)}")
    print(
        f"{machine()}\n\nMedians of {arguments.rounds} rounds, in turn; {arguments.method}, rtol "
        f"{RTOL:g}."
    )
    for name in arguments.tables or TABLES:
        TABLES[name](arguments)


if __name__ == "__main__":
    main()
