"""Whether tests pass, or are skipped by name, on a machine that has almost nothing.

All tests are collected, and the test command of the README runs, with a PATH that holds Python, a
shell and one C compiler only, a home in which nothing can be written (it would lie below a file),
and in the C locale. The tests that are skipped are counted by their reasons.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# What pytest says of tests with one reason: "SKIPPED [3] tests/core/test_libm.py:37: no gcc".
SKIPPED = re.compile(r"SKIPPED \[(\d+)\] \S+?: (.+)")


def programs():
    """Return the only programs that there are; a compiler calls its assembler and its linker."""
    compiler = next(filter(shutil.which, ("gcc", "clang", "cc")), None)
    names = {"sh": "sh", "as": "as", "ld": "ld"}
    names |= {"cc": compiler, compiler: compiler} if compiler else {}
    found = {name: shutil.which(program) for name, program in names.items()}
    return {"python3": sys.executable} | {name: path for name, path in found.items() if path}


def collect_with_nothing():
    """Collect all tests where there is not even a compiler, and return whether that works."""
    words = ["-m", "pytest", "--collect-only", "-qq", "-n", "0"]
    nothing = {"PATH": "", "LANG": "C"}
    ended = subprocess.run(
        [sys.executable, *words], cwd=ROOT, env=nothing, check=False, text=True, capture_output=True
    )
    if ended.returncode:
        print(ended.stdout, ended.stderr, flush=True)
    return ended.returncode == 0


def run(environment):
    """Run the test command, say why how many tests were skipped, and return whether it passed."""
    reasons = Counter()
    command = [sys.executable, "tests/check.py"]
    with subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True
    ) as ended:
        for line in ended.stdout:
            print(line, end="", flush=True)
            if said := SKIPPED.match(line):
                reasons[said[2]] += int(said[1])
    print(f"Skipped on a bare machine, {reasons.total()} in all:")
    for reason, count in reasons.most_common():
        print(f"{count:5}  {reason}")
    return ended.returncode == 0


def main():
    """Collect all tests, then run them; exit 1 if one fails."""
    collected = collect_with_nothing()
    with tempfile.TemporaryDirectory() as folder:
        for name, path in programs().items():
            (Path(folder) / name).symlink_to(path)
        environment = {"PATH": folder, "HOME": f"{folder}/python3/home", "LANG": "C"}
        environment |= {"OPENBLAS_NUM_THREADS": "1", "PYTEST_ADDOPTS": "-rs"}
        passed = run(environment)
    return 0 if collected and passed else 1


if __name__ == "__main__":
    sys.exit(main())
