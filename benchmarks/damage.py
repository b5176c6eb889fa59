"""Damaged and forged archives: each must be reported, none read as something else.

For one small archive of every kind:

- cut off at each of its first 4,096 bytes and at every block of 512 bytes after them;
- one bit turned over, at 1,000 random places;
- a share of 500 mutants: bytes overwritten, blocks cut out, doubled, moved or emptied;
- the forgeries of `tests/results/forgeries.py`: links, bombs, vast sizes, cycles, unknown filters;
  and those that are refused even if the forger seals them again.

Each file is loaded in another process. It must end within 5 s of the processor and 1 GiB, either
with an ArchiveError or with the very dataset that was saved.

Then a process that saves over and over to one path is killed 100 times at random moments.

    pip install -e '.[test]' && python -m benchmarks.damage [--quick]
"""

import argparse
import math
import os
import random
import resource
import shutil
import signal
import tempfile
import time
from collections import Counter
from multiprocessing import Pool
from pathlib import Path

import netCDF4  # noqa: F401 - so that the processes need not
import numpy as np
import xarray as xr

from rotor_ida import ArchiveError, InputError, load, save
from rotor_ida.results.archive.checksum import append_seal
from tests.example_datasets import KINDS
from tests.results.forgeries import FORGERIES, SEALED_AGAIN

SECONDS, MEBIBYTES = 5, 1024


def cuts(whole, every):
    """Yield an archive cut off: at every byte of its head and at every block."""
    for length in [*range(0, min(4096, len(whole)), every), *range(4096, len(whole), 512)]:
        yield whole[:length]


def flips(whole, count):
    """Yield an archive with one bit turned over."""
    places = random.Random(1)
    for _ in range(count):
        place = places.randrange(8 * len(whole))
        turned = bytearray(whole)
        turned[place // 8] ^= 1 << place % 8
        yield bytes(turned)


def mutants(whole, count):
    """Yield an archive with many bytes changed."""
    chance = random.Random(2)
    for number in range(count):
        first, second = (chance.randrange(len(whole)) for _ in range(2))
        length = chance.choice([2, 8, 64, 512, 4096])
        block, noise = whole[first : first + length], chance.randbytes(length)
        rest = whole[first + length :]
        moved = whole[:second] + block + whole[second + len(block) :]
        changed = [noise + rest, rest, block + block + rest, bytes(len(block)) + rest]
        yield [*(whole[:first] + end for end in changed), moved, whole + noise][number % 6]


def what_load_makes_of(files, good, path):
    """Return how loading each of these files ends: words, seconds and the most MiB so far.

    One process loads them one after the other; where it crashes or does not end, another goes on.
    """
    endings, files = [], list(files)
    while len(endings) < len(files):
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            _load_all(files[len(endings) :], good, path, writing)
        os.close(writing)
        with open(reading) as told:
            endings += [
                (word, float(took), float(most)) for word, took, most in map(str.split, told)
            ]
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status:
            word = "ENDLESS" if status == -signal.SIGALRM else f"CRASH{status}"
            endings.append((word, math.nan, math.nan))
    return endings


def _load_all(files, good, path, writing):
    for data in files:
        if isinstance(data, bytes):
            path.write_bytes(data)
        signal.alarm(12 * SECONDS)  # by the clock, which says little on a busy machine
        began = _processor()
        try:
            word = "harmless" if load(path).identical(good) else "SILENT"
        except (ArchiveError, InputError):
            word = "reported"
        except BaseException as error:
            word = type(error).__name__
        took = _processor() - began
        word = "ENDLESS" if took > SECONDS else word
        users = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        most = max(resource.getrusage(user).ru_maxrss for user in users) / 1024
        os.write(writing, f"{word} {took} {most}\n".encode())
    os._exit(0)


def _processor():
    """Return the processor time of this process and of those that it started [s]."""
    users = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in users)


def judge(task):
    """Return a row of the table: one kind of damage to one archive."""
    archive, damage, count = task
    good = load(archive)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.nc"
        forgery, _, sealed = damage.partition(", ")
        if forgery in FORGERIES:
            shutil.copy(archive, path)
            FORGERIES[forgery](path)
            if sealed:
                append_seal(path)
            files = [None]
        else:
            made = {"cut": cuts, "bit": flips, "mutant": mutants}[damage]
            files = made(archive.read_bytes(), count)
        endings = what_load_makes_of(files, good, path)
    words, seconds, mebibytes = zip(*endings, strict=True)
    return archive.stem, damage, Counter(words), max(seconds), max(mebibytes)


def kill(times):
    """Kill a process that saves, again and again; return what is wrong afterwards."""
    chance, wrong = random.Random(3), []
    data = xr.Dataset({"x": ("t", np.random.default_rng(0).normal(size=200_000))})
    with tempfile.TemporaryDirectory() as folder:
        path = save(data, Path(folder) / "run.nc")
        for number in range(times):
            child = os.fork()
            if child == 0:
                while True:
                    save(data, path, overwrite=True)
            time.sleep(chance.uniform(0.0, 0.2))
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            if not load(path).x.identical(data.x):
                wrong.append(f"kill {number}: another content")
        left = len(os.listdir(folder)) - 1
        save(data, path, overwrite=True)
        wrong += [f"left behind: {name}" for name in os.listdir(folder) if name != path.name]
    print(f"{times} kills: {left} parts left before the last save; wrong: {wrong or 'nothing'}")
    return wrong


def show(name, damage, counts, slowest, largest):
    """Print a row of the table."""
    ended = ", ".join(f"{count} {words}" for words, count in sorted(counts.items()))
    print(f"{name:20}{damage:28}{slowest:7.2f} s{largest:6.0f} MiB  {ended}", flush=True)


def main():
    """Print the tables; the exit status is 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of it")
    part = 10 if parser.parse_args().quick else 1
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    rows = []
    with tempfile.TemporaryDirectory() as folder, Pool(os.cpu_count()) as pool:
        archives = [save(made(), Path(folder) / f"{name}.nc") for name, made in KINDS.items()]
        tasks = [(archives[0], name, 1) for name in FORGERIES]
        tasks += [(archives[0], f"{name}, sealed", 1) for name in SEALED_AGAIN]
        for archive in archives:
            tasks += [(archive, "cut", part), (archive, "bit", 1000 // part)]
            tasks += [(archive, "mutant", 30 // part)]
        print(f"{'archive':20}{'damage':28}{'longest':>9}{'memory':>10}  how loading ended")
        for row in pool.imap(judge, tasks):
            rows.append(row)
            show(*row)
    total = sum((row[2] for row in rows), Counter())
    print(f"all: {dict(total)}")
    too_large = any(row[4] > MEBIBYTES for row in rows)
    wrong = set(total) - {"harmless", "reported"}
    return 1 if kill(100 // part) or wrong or too_large else 0


if __name__ == "__main__":
    raise SystemExit(main())
