"""Run the scenarios: one script for each figure of the paper and each study of ours."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rotor_ida.ensemble import count_workers
from rotor_ida.errors import InputError
from rotor_ida.scenario import check_folder, output_folder


def scenario_scripts() -> dict[str, Path]:
    """Return the scenario scripts by name: those installed, or those of the clone.

    Examples
    --------
    >>> "fig10_11_amplitude" in scenario_scripts()
    True
    """
    package = Path(__file__).parent
    for folder in (package / "scenarios", package.parent / "scenarios"):
        scripts = sorted(folder.glob("[!_]*.py"))
        if scripts:
            return {script.stem: script for script in scripts}
    return {}


def reproduce(
    folder: str | os.PathLike[str],
    *,
    quick: bool = False,
    only: Sequence[str] | None = None,
    workers: int | None = None,
    force: bool = False,
) -> int:
    """Run the scenarios, each into a folder of its own name, and go on when one fails.

    Parameters
    ----------
    folder : path-like
        Where the scenarios' folders go; made if it is not there.
    quick : bool
        Whether coarse versions will do.
    only : sequence of str, optional
        Names of the scenarios to run; by default all.
    workers : int, optional
        Number of processes of each; by default one for each core.
    force : bool
        Whether results that are there may be replaced.

    Returns
    -------
    int
        Exit status: 0 if all were done, 1 if one failed.

    Raises
    ------
    InputError
        If a name is unknown, or results are there and `force` is false; then nothing was run.

    Notes
    -----
    Each script runs in a Python of its own: one that crashes takes no other with it, and its
    sweeps can start processes as when it is run by hand.
    """
    chosen = _chosen(only)
    root = Path(folder)
    for name in chosen:
        check_folder(output_folder(root, name), force=force)
    options = ["--out", str(root), "--workers", str(count_workers(workers))]
    options += ["--quick"] if quick else []
    options += ["--force"] if force else []
    failed = []
    for number, (name, script) in enumerate(chosen.items(), start=1):
        print(f"[{number}/{len(chosen)}] {name}", flush=True)
        begin = time.monotonic()
        status = subprocess.run([sys.executable, str(script), *options], check=False).returncode
        took = f"{time.monotonic() - begin:.0f} s"
        if status:
            failed.append(name)
            print(f"{name} failed after {took} with exit status {status}", file=sys.stderr)
        else:
            print(f"{name} done in {took}", flush=True)
    if failed:
        print(f"{len(failed)} of {len(chosen)} failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _chosen(only: Sequence[str] | None) -> dict[str, Path]:
    scripts = scenario_scripts()
    if not scripts:
        raise InputError("no scenario scripts were found beside the package")
    if only is None:
        return scripts
    names = [only] if isinstance(only, str) else list(only)
    for name in names:
        if name not in scripts:
            raise InputError(f"scenario must be one of {', '.join(scripts)}, got {name!r}")
    return {name: scripts[name] for name in scripts if name in names}
