"""200 points of a sweep wherever they can run: what they take, and what a dead worker costs.

python benchmarks/cluster.py [--rounds 3] [--kill]

Every round runs each way once, one after the other, so that other load on the machine meets all of
them; given are medians. Processor time is that of all processes together: others' load is not in
it. A cluster that is there already is timed from its second sweep on.
"""

import argparse
import logging
import multiprocessing
import os
import resource
import time

import numpy as np
import psutil
from distributed import LocalCluster

from rotor_ida import sweep

POINTS = {"omega": np.linspace(0.5, 3.0, 50), "zeta": 0.07, "delta0": [0.0, 0.5, 1.0, 2.0]}
COUNT = 200


def spent():
    """Return seconds on the clock, and on the processor by this process and all its children."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    times = [each.cpu_times() for each in psutil.Process().children(recursive=True)]
    children = ended.ru_utime + ended.ru_stime + sum(each.user + each.system for each in times)
    return np.array([time.perf_counter(), time.process_time() + children])


def timed(**where):
    """Return what the sweep takes there, on the clock and on the processor [s], and its result."""
    begin = spent()
    found = sweep(**POINTS, **where)
    return spent() - begin, found


def cluster(workers):
    """Return a cluster that is there before the sweep, as one on other machines would be."""
    return LocalCluster(
        n_workers=workers, threads_per_worker=1, memory_limit=0, silence_logs=logging.CRITICAL,
        dashboard_address=None, scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
    )  # fmt: skip


def compare(rounds):
    """Print points a second for each way, and how many times those of the serial sweep."""
    with cluster(1) as one, cluster(2) as two:
        ways = {
            "`serial`": {"executor": "serial"},
            "`threads`, 2": {"executor": "threads", "workers": 2},
            "`processes`, 2, with their start": {"executor": "processes", "workers": 2},
            "`dask`, 1, with its start": {"executor": "dask", "workers": 1},
            "`dask`, 2, with its start": {"executor": "dask", "workers": 2},
            "an address, 1 worker": {"executor": one.scheduler_address},
            "an address, 2 workers": {"executor": two.scheduler_address},
        }
        expected = sweep(**POINTS, executor="serial")
        for name in list(ways)[-2:]:
            sweep(**POINTS, **ways[name])  # the workers load their code
        taken = {name: [] for name in ways}
        for _ in range(rounds):
            for name, where in ways.items():
                seconds, found = timed(**where)
                assert found.identical(expected), name
                taken[name].append(seconds)
    serial = np.array(taken["`serial`"])
    print("| where | points a second | over serial | processor time a point [ms] |")
    print("|---|---|---|---|")
    for name, both in taken.items():
        rate = COUNT / np.median(both, axis=0)
        ratio = np.median(serial / np.array(both), axis=0)
        print(f"| {name} | {rate[0]:.0f} | {ratio[0]:.2f} | {1e3 / rate[1]:.1f} |")
    halves = np.array(taken["an address, 1 worker"]) / np.array(taken["an address, 2 workers"])
    print(f"2 workers over 1: {np.median(halves, axis=0)[0]:.2f}")
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")


def kill():
    """Kill a worker of two in the middle, and say whether all points came out as they should."""
    killed = []

    def in_the_middle(done, _total):
        if done >= COUNT // 2 and not killed:
            killed.append(multiprocessing.active_children()[0])
            killed[0].kill()

    whole, expected = timed(executor="dask", workers=2)
    seconds, found = timed(executor="dask", workers=2, progress=in_the_middle)
    done = int((found.status == 0).sum())
    same = "equal" if found.identical(expected) else "NOT EQUAL"
    print(f"worker {killed[0].pid} killed: {done} of {COUNT} points done, {same} to those without")
    print(f"{seconds[0]:.1f} s, {whole[0]:.1f} s without")
    serial = sweep(**POINTS, executor="serial")
    print("equal to serial" if found.identical(serial) else "NOT EQUAL to serial")


def main():
    """Compare the ways, or kill a worker."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--kill", action="store_true")
    given = parser.parse_args()
    if given.kill:
        kill()
    else:
        compare(given.rounds)


if __name__ == "__main__":
    main()
