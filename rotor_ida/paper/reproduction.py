"""Run the scenarios: one script for each figure of the paper and each further study."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from rotor_ida.checks import did_you_mean, shown
from rotor_ida.errors import InputError
from rotor_ida.paper import freshness
from rotor_ida.paper.gallery import write_gallery
from rotor_ida.paper.scenario import check_folder
from rotor_ida.parallel import count_workers
from rotor_ida.parallel.pools import deaf_to_interrupts
from rotor_ida.results.files import check_path

# One scenario draws while the other computes.
AT_ONCE = 2
# Seconds between two looks at them.
PAUSE = 0.05
# Prefixes of the scenarios that reproduce the paper; the others are studies.
OF_PAPER = ("fig", "dimensional_example", "general_solution")
# Relative durations of the longest scenarios, which start first so that none runs alone at the
# end; any other counts as 1.
DURATIONS = {
    "fitted_machine": 40.0,
    "atlas": 30.0,
    "how_slow": 20.0,
    "drop": 10.0,
    "fig07_basins": 8.0,
    "fig10_11_amplitude": 6.0,
    "bifurcation_diagram": 5.0,
    "beyond_the_curve": 3.0,
    "doubling_cascade": 3.0,
    "event_time_convergence": 3.0,
    "isolas": 3.0,
}


def is_of_paper(name: str) -> bool:
    """Return whether a scenario reproduces the paper, rather than a further study."""
    return name.startswith(OF_PAPER)


def scenario_scripts() -> dict[str, Path]:
    """Return the scenario scripts by name, those of the paper first.

    Examples
    --------
    >>> "fig10_11_amplitude" in scenario_scripts()
    True
    """
    package = Path(__file__).parents[1]
    for folder in (package / "scenarios", package.parent / "scenarios"):
        scripts = {script.stem: script for script in folder.glob("[!_]*.py")}
        if scripts:
            names = sorted(scripts, key=lambda name: (not is_of_paper(name), name))
            return {name: scripts[name] for name in names}
    return {}


def reproduce(
    folder: str | os.PathLike[str],
    *,
    quick: bool = False,
    studies: bool = False,
    only: Sequence[str] | None = None,
    workers: int | None = None,
    force: bool = False,
) -> int:
    """Run the scenarios, each into a folder of its name, and write a page of their figures.

    Parameters
    ----------
    folder : path-like
        Folder for the scenarios' folders and ``index.html``; created if missing.
    quick : bool
        Whether to compute coarse versions.
    studies : bool
        Whether to run the studies too, not only the paper's figures.
    only : sequence of str, optional
        Names or prefixes of the scenarios or studies to run, such as ``fig06``.
    workers : int, optional
        Number of processes of each; default: one per core.
    force : bool
        Whether to rerun results that are up to date, and to replace results that this function
        did not write.

    Returns
    -------
    int
        Exit status: 0 if all succeeded, 1 if one failed; the others run even then.

    Raises
    ------
    InputError
        If a name is unknown, the folder cannot be used, or it contains results of another origin
        and `force` is false; then nothing is run.

    Notes
    -----
    Each script runs in a separate process: a crash does not affect the others, and its sweeps can
    start processes. Results that are up to date are not recomputed: a digest in each folder
    identifies script, sources, versions and options.
    """
    scripts = scenario_scripts()
    chosen = _chosen(scripts, only, studies=studies)
    root = _root(folder)
    processes = count_workers(workers)
    given = ["--quick"] if quick else []
    origins = {name: freshness.origin_of(script, given) for name, script in chosen.items()}
    folders = {name: root / name for name in chosen}
    current = [
        name for name in chosen if not force and freshness.is_fresh(folders[name], origins[name])
    ]
    due = [name for name in chosen if name not in current]
    for name in due:
        check_folder(folders[name], force=force or freshness.is_ours(folders[name]))
    if current:
        print(f"up to date: {', '.join(current)}", flush=True)
    at_once = min(AT_ONCE, processes, max(1, len(due)))
    # a quick sweep is over before further processes have started
    each = max(1, processes // at_once) if quick else processes
    command = ["--out", str(root), "--workers", str(each), "--force", *given]
    order = sorted(due, key=lambda name: -DURATIONS.get(name, 1.0))
    ends = run_scripts({name: chosen[name] for name in order}, command, root=root, at_once=at_once)
    failed = []
    with closing(ends):
        for number, ended in enumerate(ends, start=1):
            name = ended.name
            _report(ended, f"{number}/{len(due)}")
            shutil.copyfile(chosen[name], folders[name] / chosen[name].name)
            freshness.record(folders[name], "" if ended.status else origins[name])
            if ended.status:
                failed.append(name)
    failed.sort()
    page = write_gallery(root, scripts, failed=failed)
    print(f"figures: {page}", flush=True)
    if failed:
        print(f"{len(failed)} of {len(chosen)} failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


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


def _root(folder: str | os.PathLike[str]) -> Path:
    """Return the folder for results, existing or not; refuse one that is not writable."""
    root = check_path("out", folder, kind="folder")
    nearest = next(path for path in (root, *root.absolute().parents) if os.path.lexists(path))
    if not nearest.is_dir():
        raise InputError(f"out must be a folder, got {shown(root)}: {shown(nearest)} is none")
    if not os.access(nearest, os.W_OK):
        raise InputError(f"out must be in a folder that can be written to, got {shown(root)}")
    return root


def _report(ended: Ended, count: str) -> None:
    """Print the output and the end of a script."""
    print(ended.printed, end="", flush=True)
    took = f"{ended.seconds:.0f} s"
    if ended.status:
        words = f"{ended.name} failed after {took} with exit status {ended.status}"
        print(words, file=sys.stderr)
    else:
        print(f"[{count}] {ended.name} done in {took}", flush=True)


def _chosen(
    scripts: Mapping[str, Path], only: Sequence[str] | None, *, studies: bool
) -> dict[str, Path]:
    if not scripts:
        raise InputError("no scenario scripts were found beside the package")
    if only is None:
        return {name: path for name, path in scripts.items() if studies or is_of_paper(name)}
    chosen: set[str] = set()
    for word in [only] if isinstance(only, str) else list(only):
        matching = {name for name in scripts if _names(word, name)}
        if not matching:
            raise InputError(
                f"scenario must be one of {', '.join(scripts)}, or the beginning of one, got "
                f"{shown(word)}{did_you_mean(word, scripts)}"
            )
        chosen |= matching
    return {name: script for name, script in scripts.items() if name in chosen}


def _names(word: str, name: str) -> bool:
    """Return whether a word matches a scenario: its name, a prefix, or one of its figures.

    Examples
    --------
    >>> [_names(word, "fig10_11_amplitude") for word in ("fig10", "fig11", "fig1", "fig12")]
    [True, True, False, False]
    """
    if word == name:
        return True
    numbers = re.match(r"fig((?:\d+_)+)", name)
    if re.fullmatch(r"fig\d+", word) and numbers:
        return word[3:] in numbers.group(1).split("_")
    return bool(word) and name.startswith(word)
