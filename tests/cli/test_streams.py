"""Standard output holds the result and nothing else, whatever the solver and the shell do."""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import rotor_ida
from rotor_ida.cli import main
from rotor_ida.errors import ArchiveError, SimulationError
from tests.cli.conftest import Program

needs_bash = pytest.mark.skipif(not shutil.which("bash"), reason="there is no bash")


RESPONSE = ["response", "--omega", "1.7", "--zeta", "0.07", "--delta0", "0.5", "--json"]
ROTOR = ["--omega", "1", "--zeta", "0.1", "--delta0", "0.5"]
RUN = ["simulate", *ROTOR, "--start", "0", "0", "0", "0", "--duration", "1"]


def test_what_the_solver_writes_to_descriptor_1_is_not_in_the_result(
    program: Program, monkeypatch: pytest.MonkeyPatch
):
    quiet = rotor_ida.simulate

    def noisy(*args: object, **options: object) -> object:
        os.write(1, b"[WARNING][rank 0] from C\n")
        print("from Python")
        return quiet(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("rotor_ida.simulate", noisy)
    answer = program(*RUN, "--json")
    assert json.loads(answer.out)["kind"] == "run"
    assert sorted(answer.err.splitlines()) == ["[WARNING][rank 0] from C", "from Python"]


def test_descriptor_1_is_given_back(program: Program, capfd: pytest.CaptureFixture[str]):
    program(*RUN)
    os.write(1, b"mine again")
    assert capfd.readouterr().out == "mine again"


@pytest.mark.skipif(os.name == "nt", reason="calls the C library by its POSIX name")
def test_what_c_has_buffered_does_not_follow_the_result(
    program: Program, monkeypatch: pytest.MonkeyPatch
):
    quiet = rotor_ida.simulate

    def noisy(*args: object, **options: object) -> object:
        ctypes.CDLL(None).printf(b"late words from C\n")
        return quiet(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("rotor_ida.simulate", noisy)
    answer = program(*RUN, "--json")
    assert json.loads(answer.out)["kind"] == "run"
    assert answer.err == "late words from C\n"


def test_a_solver_that_gives_up_is_status_1_and_one_line(
    program: Program, monkeypatch: pytest.MonkeyPatch
):
    def fail(*_args: object, **_options: object) -> None:
        os.write(1, b"[ERROR][rank 0] mxstep steps taken before reaching tout\n")
        raise SimulationError("too much work", time=1.5, state=(0.0, 1.0, 2.0, 3.0))

    monkeypatch.setattr("rotor_ida.simulate", fail)
    answer = program(*RUN, "--out", "run.nc")
    assert (answer.status, answer.out) == (1, "")
    assert answer.err.splitlines()[1] == (
        "rotor-ida: too much work (at t = 1.5, state (x, y, vx, vy) = (0, 1, 2, 3))"
    )
    assert not Path("run.nc").exists()


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError(), 1, "not enough memory for this much data"),
        (ArchiveError("cannot write run.nc: the disk is full"), 1, "cannot write run.nc: the disk"),
        (OSError(28, "No space left on device", "a.png"), 1, "a.png: No space left on device"),
        (OSError(24, "Too many open files"), 1, "Too many open files"),
    ],
)
def test_what_stops_a_command_gets_one_line(
    program: Program,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    status: int,
    line: str,
):
    def stop(*_args: object, **_options: object) -> None:
        raise error

    monkeypatch.setattr("rotor_ida.simulate", stop)
    answer = program(*RUN)
    assert (answer.status, answer.out) == (status, "")
    assert answer.err.startswith(f"rotor-ida: {line}")
    assert answer.err.count("\n") == 1


def test_a_stream_that_replaces_standard_output_gets_the_result(
    capsys: pytest.CaptureFixture[str],
):
    assert main(RESPONSE) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "whirls"


@pytest.mark.parametrize("width", [20, 30, 60, 100])
def test_tables_keep_to_the_columns_that_are_asked_for_and_lose_no_number(
    program: Program, monkeypatch: pytest.MonkeyPatch, width: int
):
    monkeypatch.setenv("COLUMNS", str(width))
    out = program("response", "--omega", "1.7", "--zeta", "0.070001", "--delta0", "0.50001").out
    assert max(map(len, out.splitlines())) <= width
    assert {"0.070001", "0.50001"} <= set(out.split())


@pytest.fixture
def output_to(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int], None]]:
    """Return a function that makes a descriptor the standard output of the process."""
    kept = os.dup(1)

    def change(descriptor: int) -> None:
        os.dup2(descriptor, 1)
        stream = open(1, "w", closefd=False)  # noqa: SIM115 - as long as the test
        monkeypatch.setattr(sys, "stdout", stream)

    yield change
    os.dup2(kept, 1)
    os.close(kept)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_stream_is_status_1(output_to: Any, capfd: pytest.CaptureFixture[str]):
    with open("/dev/full", "w") as full:
        output_to(full.fileno())
        assert main(RESPONSE) == 1
    assert capfd.readouterr().err == "rotor-ida: standard output: No space left on device\n"


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
def test_a_reader_that_stops_is_no_mistake(output_to: Any, capfd: pytest.CaptureFixture[str]):
    reading, writing = os.pipe()
    os.close(reading)
    output_to(writing)
    os.close(writing)
    assert main(RESPONSE) == 141
    assert capfd.readouterr().err == ""


@needs_bash
@pytest.mark.parametrize(
    ("closed", "said"),
    [(">&-", "rotor-ida: standard output: closed\n"), ("2>&- >&- <&-", "")],
)
def test_what_is_written_before_output_turns_out_closed_is_kept(
    tmp_path: Path, closed: str, said: str
):
    ended = subprocess.run(
        ["bash", "-c", f"{sys.executable} -m rotor_ida {' '.join(RUN)} --out run.nc {closed}"],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (1, said)
    assert rotor_ida.load(tmp_path / "run.nc").sizes["t"] == 1001


def test_what_was_computed_is_printed_even_if_it_cannot_be_kept(
    program: Program, monkeypatch: pytest.MonkeyPatch
):
    def full(*_args: object, **_options: object) -> None:
        raise ArchiveError("cannot write run.nc: No space left on device")

    monkeypatch.setattr("rotor_ida.save", full)
    answer = program(*RUN, "--out", "run.nc", "--json")
    assert answer.status == 1
    assert json.loads(answer.out)["kind"] == "run"
    assert answer.err == "rotor-ida: cannot write run.nc: No space left on device\n"


@pytest.mark.parametrize(("given", "expected"), [(None, "1"), ("3", "3")])
def test_linear_algebra_has_one_thread_unless_the_environment_says_otherwise(
    given: str | None, expected: str, monkeypatch: pytest.MonkeyPatch
):
    name, seen = "OPENBLAS_NUM_THREADS", []
    monkeypatch.setenv(name, given) if given else monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("rotor_ida.cli.program.main", lambda _: seen.append(os.environ[name]) or 0)
    assert main(["doctor"]) == 0
    assert (seen, os.environ.get(name)) == ([expected], given)
