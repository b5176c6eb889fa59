"""Run scripts in parallel, each in a separate process with the imports done."""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from itertools import islice
from multiprocessing import get_all_start_methods, get_context, resource_tracker
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import NamedTuple, cast

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
    "rotor_ida.paper.scenario",
    "rotor_ida.steady.lyapunov",
)


class Ended(NamedTuple):
    """End of a script: its exit status, captured output, and the time [s]."""

    name: str
    status: int
    printed: str
    seconds: float


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
    running: dict[str, tuple[BaseProcess, float]] = {}
    with tempfile.TemporaryDirectory() as aside:
        try:
            while True:
                for name, script in islice(waiting, at_once - len(running)):
                    printed = Path(aside, name) if at_once > 1 else None
                    if printed is not None:
                        printed.touch()
                    freshness.begin(root / name)
                    given = (script, options, Path.cwd(), printed)
                    process: BaseProcess = context.Process(target=_run, args=given)
                    with deaf_to_interrupts():  # else one is left that nobody ends
                        process.start()
                        running[name] = (process, time.monotonic())
                if not running:
                    return
                wait([process.sentinel for process, _ in running.values()])
                for name in [name for name in running if not running[name][0].is_alive()]:
                    process, begin = running.pop(name)
                    process.join()
                    path = Path(aside, name)
                    said = path.read_text("utf-8", errors="replace") if path.exists() else ""
                    yield Ended(name, process.exitcode or 0, said, time.monotonic() - begin)
        finally:
            for process, _ in running.values():
                process.terminate()
            for process, _ in running.values():
                process.join()


def _context() -> SpawnContext:
    """Return the start method of processes: from a server with the imports done, if possible."""
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload(list(IMPORTED))
    return cast("SpawnContext", context)  # of the same interface, under a name that Windows lacks


def _run(script: Path, options: Sequence[str], place: Path, printed: Path | None) -> None:
    """Run a script from a folder, as by hand, in this process."""
    os.chdir(place)
    if printed is not None:
        with printed.open("wb") as file:
            for stream in (1, 2):
                os.dup2(file.fileno(), stream)
    sys.argv = [str(script), *options]
    runpy.run_path(str(script), run_name="__main__")
