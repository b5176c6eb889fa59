"""The whole test command: style, types, layout, doctests and tests, one after the other."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINT_IMPORTS = "from importlinter.cli import lint_imports_command; lint_imports_command()"
CLANG_FORMAT = "from clang_format import clang_format; clang_format()"
# Those that are derived from the model say themselves that they are to be left as they are.
C_SOURCES = sorted(str(path) for path in (ROOT / "rotor_ida" / "core").glob("*.[ch]"))
SPELLED = [
    *("rotor_ida", "tests", "docs", "scenarios", "benchmarks"),
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md"),
]
CHECKS = {
    "style": ["-m", "ruff", "check", "."],
    "format": ["-m", "ruff", "format", "--check", "."],
    "spelling": ["-m", "codespell_lib", *SPELLED],
    "C": ["-c", CLANG_FORMAT, "--dry-run", "--Werror", *C_SOURCES],
    "types": ["-m", "mypy"],
    "layout": ["-c", LINT_IMPORTS],
    "tests": ["-m", "pytest", "-n", "auto", "--dist", "worksteal"],
}


def run(name, arguments):
    """Run one check with this Python and return whether it passed."""
    print(f"== {name}", flush=True)
    return subprocess.run([sys.executable, *arguments], cwd=ROOT, check=False).returncode == 0


def main():
    """Run every check, even after one has failed; exit 1 if one has."""
    failed = [name for name, arguments in CHECKS.items() if not run(name, arguments)]
    print(f"== failed: {', '.join(failed)}" if failed else "== all passed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
