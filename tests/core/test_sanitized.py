"""The core alone, under the sanitizers of addresses and of undefined behaviour."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from runpy import run_path

import pytest

from rotor_ida.core.identity import model_sources

ROOT = Path(__file__).parents[2]
CORE = ROOT / "rotor_ida" / "core"
# What a build says of itself.
SAID = ("compiler", "flags", "level", "model", "sources", "version")
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=1:detect_stack_use_after_return=1",
    "UBSAN_OPTIONS": "print_stacktrace=1",
}

ENGLISH = os.environ | {"LC_ALL": "C"}  # what a compiler says is looked at


@pytest.mark.parametrize(
    ("compiler", "model"), [("gcc", "paper"), ("clang", "whole"), ("clang", "run_up")]
)
def test_no_entry_point_does_what_is_undefined(tmp_path, compiler, model):
    """By `exercise.c`, in each model; what is the same in all is compiled by either compiler."""
    if not (ROOT / "hatch_build.py").is_file():
        pytest.skip("an installed package has no sources to compile")
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    hatch_build = run_path(str(ROOT / "hatch_build.py"))
    flags = hatch_build["flags"]([compiler], "baseline", model=model, sanitize=True)
    words = [compiler, *flags, "-fsanitize=float-cast-overflow", "-Wno-psabi", f"-I{CORE}"]
    words += [f"-DCORE_{name.upper()}={json.dumps(name)}" for name in SAID]

    def compiled(source: Path) -> str:
        made = tmp_path / f"{source.stem}.o"
        strict = hatch_build["WARNINGS"] if source.parent == CORE else ()
        said = subprocess.run(
            [*words, *strict, "-c", str(source), "-o", str(made)], capture_output=True,
            text=True, check=False, env=ENGLISH,
        )  # fmt: skip
        if "asan" in said.stderr and said.returncode:
            pytest.skip(f"{compiler} has no sanitizers here: {said.stderr.strip()}")
        assert said.returncode == 0, said.stderr
        return str(made)

    sources = [*model_sources(CORE, model), Path(__file__).parent / "exercise.c"]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = [*pool.map(compiled, sources)]
    program = tmp_path / "exercise"
    linked = subprocess.run(
        [*words, *objects, "-lm", "-o", str(program)], capture_output=True, text=True, check=False,
        env=ENGLISH,
    )  # fmt: skip
    if linked.returncode and "cannot find" in linked.stderr:
        pytest.skip(f"{compiler} has no sanitizers here: {linked.stderr.strip()}")
    assert linked.returncode == 0, linked.stderr
    ended = subprocess.run(
        [program], env=os.environ | OPTIONS, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert (ended.returncode, ended.stdout) == (0, "done\n"), ended.stderr
