"""The whole test command: style, types, layout, doctests and tests, one after the other."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CHECKS = {
    "style": ["ruff", "check", "."],
    "format": ["ruff", "format", "--check", "."],
    "types": ["mypy"],
    "layout": ["importlinter.cli", "lint"],
    "tests": ["pytest", "-n", "auto", "--dist", "worksteal"],
}


def run(name, command):
    """Run one check with this Python and return whether it passed."""
    print(f"== {name}", flush=True)
    module, *rest = command
    if module == "importlinter.cli":
        start = "from importlinter.cli import lint_imports_command; lint_imports_command()"
        line = [sys.executable, "-c", start]
    else:
        line = [sys.executable, "-m", module, *rest]
    return subprocess.run(line, cwd=ROOT, check=False).returncode == 0


def main():
    """Run every check, even after one has failed; exit 1 if one has."""
    failed = [name for name, command in CHECKS.items() if not run(name, command)]
    print(f"== failed: {', '.join(failed)}" if failed else "== all passed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
