"""Run scripts in parallel, each in a separate process."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from rotor_ida.paper import freshness
from rotor_ida.parallel.pools import deaf_to_interrupts

# Seconds between two looks at the scripts.
PAUSE = 0.05


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
    waiting = iter(scripts.items())
    running: dict[str, tuple[subprocess.Popen[bytes], float]] = {}
    with tempfile.TemporaryDirectory() as aside:
        try:
            while True:
                for name, script in islice(waiting, at_once - len(running)):
                    freshness.begin(root / name)
                    # without the second, an interrupt could leave one that nobody ends
                    with Path(aside, name).open("wb") as printed, deaf_to_interrupts():
                        process = subprocess.Popen(
                            [sys.executable, script, *options],
                            stdout=printed if at_once > 1 else None,
                            stderr=subprocess.STDOUT if at_once > 1 else None,
                        )
                        running[name] = process, time.monotonic()
                if not running:
                    return
                time.sleep(PAUSE)
                for name in [name for name in running if running[name][0].poll() is not None]:
                    process, begin = running.pop(name)
                    said = Path(aside, name).read_text("utf-8", errors="replace")
                    yield Ended(name, process.returncode, said, time.monotonic() - begin)
        finally:
            for process, _ in running.values():
                process.terminate()
            for process, _ in running.values():
                process.wait()
