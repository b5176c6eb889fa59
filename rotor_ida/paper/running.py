"""Run scripts in parallel, each in a separate process with the imports done."""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_all_start_methods, get_context, resource_tracker
from multiprocessing.connection import wait
from multiprocessing.context import ForkServerContext, SpawnContext
from multiprocessing.process import BaseProcess
from pathlib import Path

from rotor_ida.paper import freshness
from rotor_ida.parallel.pools import deaf_to_interrupts

# Imports take longer than many scripts compute: a server imports once, and each script starts in
# a copy of it.
IMPORTED = (
    "mpl_toolkits.mplot3d",
    "rotor_ida.steady.bifurcation_diagram",
    "rotor_ida.signals.spectra",
    "rotor_ida.basins",
    "rotor_ida.cycles.continue_cycle",
    "rotor_ida.cycles.branches",
    "rotor_ida.paper.errata",
    "rotor_ida.paper.scenario",
    "rotor_ida.steady.lyapunov",
)


@dataclass(frozen=True, slots=True)
class Ended:
    """End of a script: its exit status, captured output, and the time [s]."""

    name: str
    status: int
    printed: str
    seconds: float


@dataclass(frozen=True, slots=True)
class _Running:
    name: str
    process: BaseProcess
    printed: Path | None
    begin: float


def run_scripts(
    scripts: Mapping[str, Path], options: Sequence[str], *, root: Path, at_once: int
) -> Generator[Ended, None, None]:
    """Run scripts, some at a time, and yield the end of each.

    Parameters
    ----------
    scripts : mapping of str to Path
        The scripts by name, in the order in which they begin.
    options : sequence of str
        Their command line.
    root : Path
        Folder that contains one for each script, which is marked as incomplete.
    at_once : int
        How many to run at a time; if several, their output is captured.

    Yields
    ------
    Ended
        One for each script, as they end.

    Notes
    -----
    A crash of one script does not affect the others. If the caller stops iterating, or the user
    interrupts, running scripts are ended.
    """
    context = _context()
    resource_tracker.ensure_running()  # as it starts, it lets interrupts in that are kept out
    waiting = iter(scripts.items())
    running: list[_Running] = []
    with tempfile.TemporaryDirectory() as aside:
        try:
            while True:
                for name, script in islice(waiting, at_once - len(running)):
                    printed = Path(aside, name) if at_once > 1 else None
                    if printed is not None:
                        printed.touch()
                    freshness.begin(root / name)
                    given = (script, options, Path.cwd(), printed)
                    process = context.Process(target=_run, args=given)
                    with deaf_to_interrupts():  # else one is left that nobody ends
                        process.start()
                        running.append(_Running(name, process, printed, time.monotonic()))
                if not running:
                    return
                wait([each.process.sentinel for each in running])
                for each in [each for each in running if not each.process.is_alive()]:
                    running.remove(each)
                    yield _ended(each)
        finally:
            for each in running:
                each.process.terminate()
            for each in running:
                each.process.join()


def _context() -> ForkServerContext | SpawnContext:
    """Return the start method of processes: from a server with the imports done, if possible."""
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload(list(IMPORTED))
    return context


def _run(script: Path, options: Sequence[str], place: Path, printed: Path | None) -> None:
    """Run a script from a folder, as by hand, in this process."""
    os.chdir(place)
    if printed is not None:
        with printed.open("wb") as file:
            for stream in (1, 2):
                os.dup2(file.fileno(), stream)
    sys.argv = [str(script), *options]
    runpy.run_path(str(script), run_name="__main__")


def _ended(job: _Running) -> Ended:
    job.process.join()
    seconds = time.monotonic() - job.begin
    printed = job.printed.read_text(encoding="utf-8", errors="replace") if job.printed else ""
    return Ended(job.name, job.process.exitcode or 0, printed, seconds)
