"""The core is compiled without a warning, and what goes wrong there is said in a sentence."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from itertools import product
from pathlib import Path
from runpy import run_path
from typing import Any

import pytest

from rotor_ida.core.identity import MODELS, model_sources
from rotor_ida.model import writing

ROOT = Path(__file__).parents[2]
CORE = ROOT / "rotor_ida" / "core"
ANY = next(filter(shutil.which, ("cc", "gcc", "clang")), "")
needs_compiler = pytest.mark.skipif(not ANY, reason="no C compiler is installed")


@pytest.fixture(scope="module")
def hatch_build() -> dict[str, Any]:
    return run_path(str(ROOT / "hatch_build.py"))


def test_no_source_gives_rise_to_a_warning(hatch_build: dict[str, Any], tmp_path: Path) -> None:
    """By gcc, optimised, as some warnings need it; by clang and in other models where the
    sanitizers are."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    sources = [str(path) for path in model_sources(CORE, "whole") if path.stem != "build"]
    flags = hatch_build["flags"](["gcc"], "baseline", model="whole", warnings=True)
    words = ["gcc", *flags, hatch_build["NO_INLINING"], "-O1", "-c", *sources]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, check=False, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")


@needs_compiler
def test_only_what_is_not_up_to_date_is_compiled(
    hatch_build: dict[str, Any], tmp_path: Path
) -> None:
    def built(*words: str) -> subprocess.CompletedProcess[str]:
        # a process of its own each time, as the system keeps what is loaded
        command = [sys.executable, ROOT / "hatch_build.py", "--out", tmp_path, "--compiler", *words]
        return subprocess.run(command, capture_output=True, check=False, text=True)

    tmp_path, beside = tmp_path / "out", tmp_path
    tmp_path.mkdir()
    for path in CORE.glob("*.so"):  # what this compiler made of these sources stays
        shutil.copy(path, tmp_path)
    built(ANY)
    here = sorted(tmp_path.iterdir())
    assert built(ANY).stdout.startswith("nothing to compile:")
    # the same compiler, told at the end of each line not to optimise
    (beside / "fast").write_text(f'#!/bin/sh\nexec {ANY} "$@" -O0\n')
    (beside / "fast").chmod(0o755)
    fast = str(beside / "fast")
    # of the paper's rotor, as these take least time
    absent, damaged = [path for path in here if path.name.count("_") == 1][:2]
    absent.unlink()
    damaged.write_bytes(b"of another platform")
    assert sorted(built(fast).stdout.split()) == [str(absent), str(damaged)]
    assert sorted(tmp_path.iterdir()) == here
    assert len(here) == len(MODELS) * len(hatch_build["levels"]())
    # with warnings, what is up to date is compiled as well
    assert f"compiled by {sys.executable}" in built(sys.executable, "--warnings").stderr


@pytest.mark.parametrize(
    ("compiler", "message"),
    [
        ("no-such-compiler --fast", "CC must name a C compiler, and 'no-such-compiler' cannot be"),
        (sys.executable, f"cannot be compiled by {re.escape(sys.executable)}"),
    ],
)
def test_a_compiler_that_is_none_is_refused(
    hatch_build: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    compiler: str,
    message: str,
) -> None:
    monkeypatch.setenv("CC", compiler)
    with pytest.raises(hatch_build["BuildError"], match=message):
        hatch_build["build"](hatch_build["find_compiler"](), out=tmp_path)


@needs_compiler
def test_what_the_compiler_complains_of_is_shown(
    hatch_build: dict[str, Any], tmp_path: Path
) -> None:
    with pytest.raises(
        hatch_build["BuildError"], match=r"(?s)compiled by .* -no-such-flag:.*no-such-flag"
    ):
        hatch_build["build"]([ANY, "-no-such-flag"], out=tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("asked", "least"), [(b"", 17), (b"GLIBC_2.2.5 GLIBC_2.14", 17), (b"GLIBC_2.29", 31)]
)
def test_the_wheel_is_for_all_systems_whose_libc_is_new_enough(
    hatch_build: dict[str, Any], tmp_path: Path, asked: bytes, least: int
) -> None:
    if hatch_build["platform"].libc_ver()[0] != "glibc":
        pytest.skip("there is no glibc")
    (tmp_path / "library").write_bytes(asked + b" GLIBC_2.4")
    tag = hatch_build["platform_tag"]([tmp_path / "library"])
    assert tag.startswith(f"manylinux_2_{least}_")


def test_a_wheel_made_on_a_mac_is_for_its_processor_alone(
    hatch_build: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hatch_build["platform"], "mac_ver", lambda: ("14.6.1", ("", "", ""), ""))
    monkeypatch.setattr(hatch_build["platform"], "machine", lambda: "arm64")
    assert hatch_build["platform_tag"]([]) == "macosx_14_0_arm64"


def test_windows_takes_a_compiler_that_is_named_or_zig(
    hatch_build: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A path there has backslashes; gcc there is another compiler."""
    monkeypatch.setattr(hatch_build["os"], "name", "nt")
    monkeypatch.setattr(hatch_build["shutil"], "which", lambda name: name)
    monkeypatch.setenv("CC", r'"C:\my tools\zig.exe" cc')
    assert hatch_build["find_compiler"]() == [r"C:\my tools\zig.exe", "cc"]
    monkeypatch.delenv("CC")
    assert hatch_build["find_compiler"]() == hatch_build["find_zig"]()


def test_each_target_has_levels_and_flags_of_its_own(hatch_build: dict[str, Any]) -> None:
    zig = [sys.executable, "-m", "ziglang", "cc"]
    for name, target in hatch_build["TARGETS"].items():
        levels = hatch_build["levels"](target)
        assert (len(levels) > 1) == name.startswith("x86_64")
        for level in levels:
            flags = hatch_build["flags"](zig, level, target=target)
            assert flags[flags.index("-target") + 1] == target.triple
            assert any(flag.startswith("-mcpu=") for flag in flags)
            assert "-ffp-contract=off" in flags


def test_an_unknown_target_is_refused_in_one_line() -> None:
    command = [sys.executable, str(ROOT / "hatch_build.py"), "--target", "vax-vms"]
    ended = subprocess.run(command, capture_output=True, check=False, text=True)
    assert ended.returncode == 1
    assert re.fullmatch(
        r"hatch_build.py: the target must be one of x86_64-linux, .*, got 'vax-vms'\n",
        ended.stderr,
    )


def test_a_package_without_a_core_asks_for_no_compiler(
    hatch_build: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROTOR_IDA_TARGET", "none")
    monkeypatch.setenv("PATH", "")
    hook, told = object.__new__(hatch_build["CustomBuildHook"]), {}
    hook.initialize("standard", told)
    assert (hook.dependencies(), told) == ([], {})


def test_no_compiler_may_regroup_or_contract(hatch_build: dict[str, Any]) -> None:
    for compiler in (["gcc"], ["python", "-m", "ziglang", "cc"]):
        for level, model in product(hatch_build["levels"](), MODELS):
            flags = hatch_build["flags"](compiler, level, model=model)
            assert "-ffp-contract=off" in flags
            assert not {"-ffast-math", "-fassociative-math", "-march=native"} & {*flags}
            assert ("-DWHOLE_MODEL" in flags) == (model != "paper")
            assert ("-DRUN_UP" in flags) == (model == "run_up")


def test_the_libraries_are_those_of_the_models_that_are_derived() -> None:
    assert {model.name for model in writing.MODELS} == {*MODELS}


def test_a_compiler_that_cannot_be_read_is_said_in_one_line(
    hatch_build: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", 'gcc "')
    with pytest.raises(
        hatch_build["BuildError"], match=r"^CC must name a C compiler, got 'gcc \"'$"
    ):
        hatch_build["find_compiler"]()
