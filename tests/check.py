"""The whole test command: style, types, layout, doctests and tests, with the time left."""

import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINT_IMPORTS = "from importlinter.cli import lint_imports_command; lint_imports_command()"
CLANG_FORMAT = "from clang_format import clang_format; clang_format()"
# Derived files are formatted as they are written; they tell clang-format to leave them alone.
C_SOURCES = sorted(str(path) for path in (ROOT / "rotor_ida" / "core").glob("*.[ch]"))
SPELLED = [
    *("rotor_ida", "tests", "docs", "scenarios", "benchmarks"),
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md"),
]
# A few seconds each.
FIRST = {
    "style": ["-m", "ruff", "check", "."],
    "format": ["-m", "ruff", "format", "--check", "."],
    "spelling": ["-m", "codespell_lib", *SPELLED],
    "C": ["-c", CLANG_FORMAT, "--dry-run", "--Werror", *C_SOURCES],
}
# Without the garbage collector, which mypy starts again: a third of the time, for 2 GB of memory.
MYPY = "import gc; gc.disable(); gc.enable = gc.disable; from mypy.main import main; main()"
# mypy reads the package as each of these platforms has it.
PLATFORMS = {"types": "linux", "types on Windows": "win32", "types on macOS": "darwin"}
# These run beside the tests, one after the other, and their output follows that of the tests.
BESIDE = {"layout": ["-c", LINT_IMPORTS]} | {
    name: ["-c", MYPY, "--platform", each, "--cache-dir", f".mypy_cache/{each}"]
    for name, each in PLATFORMS.items()
}
# One more process than processors, as many tests wait for what they have started.
WORKERS = str((os.cpu_count() or 1) + 1)
TESTS = ["-m", "pytest", "-n", WORKERS, "--dist", "worksteal"]
# One thread for matrices, as all processors have a process each: threads that wait for the next
# product take a third of the time. And Python keeps what it has compiled, even if told not to.
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": ""}
# pytest ends each line of dots with the part of the tests that is done.
PART_DONE = re.compile(r"\[ *(\d+)%\]$")


def started(arguments, **how):
    """Start a check with this Python."""
    return subprocess.Popen(
        [sys.executable, *arguments], cwd=ROOT, env=ENVIRONMENT, text=True, **how
    )


def finished(arguments):
    """Return whether a check has passed, and what it says."""
    with started(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as check:
        said = check.communicate()[0]
    return check.returncode == 0, said


def begun(checks, at_once):
    """Start checks, of which at most `at_once` run at the same time."""
    pool = ThreadPoolExecutor(at_once)
    return {name: pool.submit(finished, arguments) for name, arguments in checks.items()}


def ended(checks):
    """Print what the checks say, one after the other, and return which have passed."""
    passed = {}
    for name, check in checks.items():
        print(f"== {name}", flush=True)
        passed[name], said = check.result()
        print(said, end="", flush=True)
    return passed


def run_tests():
    """Run the tests, with the time left beside each line, and return whether they passed."""
    print("== tests", flush=True)
    began = time.monotonic()
    with started(TESTS, stdout=subprocess.PIPE) as tests:
        for line in tests.stdout:
            shown = line.rstrip("\n")
            if (part := PART_DONE.search(shown)) and 0 < int(part[1]) < 100:
                left = (time.monotonic() - began) * (100 / int(part[1]) - 1)
                shown += f" {left / 60:.0f} min left" if left >= 90 else f" {left:.0f} s left"
            print(shown, flush=True)
    return tests.returncode == 0


def main():
    """Run every check, even after one has failed; exit 1 if one has."""
    passed = ended(begun(FIRST, len(FIRST)))
    beside = begun(BESIDE, 1)
    passed["tests"] = run_tests()
    passed |= ended(beside)
    failed = [name for name, right in passed.items() if not right]
    print(f"== failed: {', '.join(failed)}" if failed else "== all passed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
