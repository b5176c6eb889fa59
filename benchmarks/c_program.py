"""The same algorithm written in C over the same SUNDIALS libraries: ``c/rotor.c``.

It is built into a temporary folder and linked with the libraries that scikit-sundae carries.
"""

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import sksundae
from ways import ATOL

from rotor_ida.core import sundials
from rotor_ida.simulation.options import STEP_SAFETY

SOURCE = Path(__file__).resolve().parent / "c" / "rotor.c"
FLAGS = ("-O3", "-march=native", "-fcx-limited-range", "-std=c11", "-D_GNU_SOURCE")
LIBRARIES_OF = Path(sksundae.__file__).parent
NEEDED = ("cvode", "nvecserial", "sunmatrixdense", "sunlinsoldense", "core")


class NoProgramError(Exception):
    """Why there is no C program to measure against."""


def build(folder):
    """Compile and link the program; return its path."""
    reason = sundials.why_not()
    if reason:
        raise NoProgramError(reason)
    place = sundials._folder(LIBRARIES_OF)
    libraries = [str(sundials._library(place, name)) for name in NEEDED]
    given = [*FLAGS, f"-DINDEX=int{index_bits()}_t", str(SOURCE), *libraries]
    return compiled([*given, f"-Wl,-rpath,{place}"], Path(folder) / "rotor")


def compiled(arguments, program):
    """Compile a program; return its path."""
    wanted = os.environ.get("CC", "cc")
    compiler = shutil.which(wanted)
    if compiler is None:
        raise NoProgramError(f"no C compiler {wanted!r}: set CC, or install one")
    command = [compiler, *arguments, "-lm", "-o", str(program)]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    if made.returncode:
        raise NoProgramError(f"{compiler} failed: {made.stderr.strip().splitlines()[-1]}")
    return program


def index_bits():
    """Return 32 or 64: a vector's length and the flag behind it, or the length alone."""
    place = sundials._folder(LIBRARIES_OF)
    core, vectors = (ctypes.CDLL(str(sundials._library(place, n))) for n in ("core", "nvecserial"))
    length, _ = sundials._probe(core, vectors)
    return 64 if length == sundials.PROBE_SIZE else 32


def call(program, case, rtol, repetitions):
    """Run the program; return seconds (clock, processor) of each repetition, and the events."""
    given = [case.omega, case.zeta, case.delta0, *case.start, case.duration, case.samples]
    given += [STEP_SAFETY * rtol, STEP_SAFETY * ATOL * rtol, repetitions]
    ran = subprocess.run(
        [program, *(f"{value:.17g}" for value in given)], capture_output=True, text=True, check=True
    )
    rows = [line.split() for line in ran.stdout.splitlines()]
    seconds = np.array([[float(v) for v in row[1:]] for row in rows if row[0] == "seconds"])
    events = np.array([[float(v) for v in row[1:]] for row in rows if row[0] == "event"])
    return seconds, events.reshape(-1, 2)


def clock(program, case, rtol):
    """Return a clock for `measuring.in_turn`; the first repetition warms up and does not count."""

    def measured(count):
        seconds, _ = call(program, case, rtol, count + 1)
        wall, cpu = seconds[1:].mean(axis=0)
        return wall, cpu

    return measured


def difference(program, case, rtol, orbit):
    """Return the worst difference between event times, NaN where the events themselves differ."""
    _, events = call(program, case, rtol, 1)
    if list(events[:, 1]) != list(orbit.event_kinds):
        return float("nan")
    return float(np.abs(events[:, 0] - orbit.event_times).max(initial=0.0))
