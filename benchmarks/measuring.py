"""How the benchmarks measure: in turn, in one process, and what they ran on.

The ways to be compared run one after the other, round by round, so that whatever else the
machine does meets all of them alike. In each round every way repeats until it has lasted long
enough to be timed; what counts is the median over the rounds. The time that the process itself
spent on the processor is measured beside the time on the clock: others' work is not in it.
"""

import os
import platform
import statistics
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import sksundae

from rotor_ida.core.library import build_info

PACKAGES = ("numpy", "scipy", "xarray", "scikit-sundae", "heyoka")
LEAST = 0.05
ROUNDS = 7


@dataclass(frozen=True)
class Times:
    """Seconds a run in each round: on the clock, and of the process on the processor."""

    wall: list[float]
    cpu: list[float]

    @property
    def median(self):
        """Median processor time of a run [s]."""
        return statistics.median(self.cpu)


def clocked(function):
    """Return a clock for a function without arguments: ``clock(count)`` gives seconds a run."""

    def clock(count):
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(count):
            function()
        return (time.perf_counter() - wall) / count, (time.process_time() - cpu) / count

    return clock


def in_turn(clocks, rounds=ROUNDS):
    """Return `Times` by name for clocks by name, measured round by round."""
    first = {name: clock(1)[0] for name, clock in clocks.items()}
    counts = {name: max(1, min(200, int(LEAST / first[name]))) for name in clocks}
    found = {name: ([], []) for name in clocks}
    for _ in range(rounds):
        for name, clock in clocks.items():
            wall, cpu = clock(counts[name])
            found[name][0].append(wall)
            found[name][1].append(cpu)
    return {name: Times(*both) for name, both in found.items()}


def ratio(slower, faster):
    """Return the median over the rounds of the ratio of two `Times`: processor, clock."""
    return tuple(
        statistics.median(
            a / b for a, b in zip(getattr(slower, of), getattr(faster, of), strict=True)
        )
        for of in ("cpu", "wall")
    )


def machine():
    """Return what this runs on: processor, cores, versions, and who compiled the core."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    found = [f"Python {platform.python_version()}", f"SUNDIALS {sksundae.SUNDIALS_VERSION}"]
    for name in PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"no {name}")
    core = build_info()
    found.append(f"core {core['level']} by {core['compiler']}")
    return f"{model}, {os.cpu_count()} cores; {', '.join(found)}"
