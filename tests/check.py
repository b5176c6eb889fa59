"""The whole test command: style, types, layout, doctests and tests, one after the other."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINT_IMPORTS = "from importlinter.cli import lint_imports_command; lint_imports_command()"
TESTS = ["-m", "pytest", "-n", "auto", "--dist", "worksteal"]
SPELLED = [
    *("rotor_ida", "tests", "docs", "scenarios", "benchmarks"),
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md"),
]
CHECKS = {
    "style": ["-m", "ruff", "check", "."],
    "format": ["-m", "ruff", "format", "--check", "."],
    "spelling": ["-m", "codespell_lib", *SPELLED],
    "types": ["-m", "mypy"],
    "layout": ["-c", LINT_IMPORTS],
    "tests": TESTS,
}
# Closed forms, drawing, files, types, pages, and what only hands on what others compute: nothing
# there asks what numba compiles for.
WITHOUT_COMPILED_ARITHMETIC = [
    "docs/*.md",
    "tests/cli",
    "tests/closed_forms",
    "tests/docs",
    "tests/explorer",
    "tests/paper/test_*.py",
    "tests/parallel",
    "tests/plot",
    "tests/storage",
    "tests/test_typing.py",
    "rotor_ida/cli",
    "rotor_ida/closed_forms",
    "rotor_ida/explorer",
    "rotor_ida/plot",
]


def run(name, arguments):
    """Run one check with this Python and return whether it passed."""
    print(f"== {name}", flush=True)
    return subprocess.run([sys.executable, *arguments], cwd=ROOT, check=False).returncode == 0


def main():
    """Run every check, even after one has failed; exit 1 if one has."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--generic",
        action="store_true",
        help="only the tests that depend on compiled arithmetic, compiled for a processor with "
        "nothing but what all of its kind have",
    )
    checks = CHECKS
    if parser.parse_args().generic:
        os.environ["NUMBA_CPU_NAME"] = "generic"
        ignored = [f"--ignore-glob={path}" for path in WITHOUT_COMPILED_ARITHMETIC]
        checks = {"tests for the generic processor": [*TESTS, *ignored]}
    failed = [name for name, arguments in checks.items() if not run(name, arguments)]
    print(f"== failed: {', '.join(failed)}" if failed else "== all passed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
