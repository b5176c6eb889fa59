"""Whether tests pass, or are skipped by name, on a machine that has almost nothing.

    python tests/bare.py

All tests are collected, and those of the explorer, the core and the archives run, with a PATH that
holds Python, a shell and one C compiler only, a home in which nothing can be written (it would lie
below a file), and in the C locale.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("tests/explorer", "tests/core", "tests/results")
WORKERS = str((os.cpu_count() or 1) + 1)


def programs():
    """Return the only programs that there are; a compiler calls its assembler and its linker."""
    compiler = next(filter(shutil.which, ("gcc", "clang", "cc")), None)
    names = {"sh": "sh", "as": "as", "ld": "ld"}
    names |= {"cc": compiler, compiler: compiler} if compiler else {}
    found = {name: shutil.which(program) for name, program in names.items()}
    return {"python3": sys.executable} | {name: path for name, path in found.items() if path}


def run(environment, *words, **how):
    """Run pytest there, and return what came of it."""
    command = [sys.executable, "-m", "pytest", *words]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False, text=True, **how)


def main():
    """Collect all tests, then run some; exit 1 if one fails."""
    with tempfile.TemporaryDirectory() as folder:
        for name, path in programs().items():
            (Path(folder) / name).symlink_to(path)
        environment = {"PATH": folder, "HOME": f"{folder}/python3/home", "LANG": "C"}
        environment |= {"OPENBLAS_NUM_THREADS": "1"}
        nothing = {"PATH": "", "LANG": "C"}  # not even a compiler
        collected = run(nothing, "--collect-only", "-qq", "-n", "0", capture_output=True)
        if collected.returncode:
            print(collected.stdout, collected.stderr, flush=True)
        ended = run(environment, "-n", WORKERS, "--dist", "worksteal", "-rs", *FOLDERS)
    return 1 if collected.returncode or ended.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
