"""Studies on the command line: begun, broken off, looked at, gone on with."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import rotor_ida
import rotor_ida.cli
from rotor_ida.cli.output import working
from rotor_ida.results.studies.store import FILE, PIECES
from rotor_ida.steady import grid
from tests.cli.conftest import Program

SWEEP = [
    *("sweep", "--omega", "1.2:2:3", "--zeta", "0.5", "--delta0", "0", "0.5"),
    *("--executor", "serial", "--study", "study"),
]


def test_a_study_holds_its_result(program: Program):
    answer = program(*SWEEP)
    assert (answer.status, answer.err) == (0, "")
    assert "wrote study/result.nc" in answer.out
    assert sorted(os.listdir("study")) == [PIECES, "result.nc", FILE]
    found = json.loads(program("status", "study", "--json").out)
    assert (found["points"], found["done"], found["left"], found["failed"]) == (6, 6, 0, 0)
    assert "time left" in program("status", "study").out
    again = program("resume", "study", "--out", "again.nc")
    assert (again.status, again.err) == (0, "")
    result, copy = rotor_ida.load("study/result.nc"), rotor_ida.load("again.nc")
    assert copy.drop_attrs(deep=False).identical(result.drop_attrs(deep=False))


def test_an_interrupt_says_how_to_go_on(program: Program, monkeypatch: pytest.MonkeyPatch):
    real = rotor_ida.sweep

    def interrupted(*given: Any, **more: Any) -> Any:
        def told(done: int, _points: int) -> None:
            if done == 2:
                signal.raise_signal(signal.SIGINT)

        return real(*given, **{**more, "progress": told})

    monkeypatch.setattr(rotor_ida, "sweep", interrupted)
    answer = program(*SWEEP)
    done = rotor_ida.status("study")["done"]
    assert (answer.status, answer.out, done in {2, 3}) == (130, "", True)
    assert answer.err == (
        f"rotor-ida: interrupted; {done} of 6 points are saved in study; continue with rotor-ida "
        "resume study\n"
    )
    assert sorted(os.listdir("study")) == [PIECES, FILE]


def test_an_interrupt_before_it_begins_is_one_line(monkeypatch: Any, capsys: Any):
    from rotor_ida.cli import program as module

    def interrupts(words: Any) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "main", interrupts)
    assert rotor_ida.cli.main(["doctor"]) == 130
    assert capsys.readouterr().err == "rotor-ida: interrupted\n"


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupt_after_the_result_comes_too_late():
    code = (
        "import atexit, os, signal, sys\n"
        "from rotor_ida.cli import main\n"
        "atexit.register(os.kill, os.getpid(), signal.SIGINT)\n"
        "sys.exit(main())"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, "simulate", "--help"], capture_output=True, check=False
    )
    assert (ended.returncode, ended.stderr) == (0, b"")


def test_an_interrupt_while_the_result_is_written_says_how_to_go_on(
    program: Program, monkeypatch: Any
):
    def interrupts(*given: Any, **more: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(rotor_ida, "save", interrupts)
        answer = program(*SWEEP)
    assert answer.status == 130
    assert answer.err == (
        "rotor-ida: interrupted; 6 of 6 points are saved in study; continue with rotor-ida resume "
        "study\n"
    )
    assert program("resume", "study").status == 0


@pytest.mark.parametrize(("folder", "word"), [("a  b", "'a  b'"), ("-x", "./-x")])
def test_how_to_go_on_can_be_typed(program: Program, folder: str, word: str):
    program(*SWEEP[:-2], f"--study={folder}")
    with pytest.raises(KeyboardInterrupt) as interrupted, working("study", Path(folder)):
        raise KeyboardInterrupt
    hint = str(interrupted.value).rpartition("rotor-ida ")[2]
    assert hint == f"resume {word}"
    assert program(*shlex.split(hint)).status == 0
    assert program(*SWEEP[:-2], f"--study={folder}", "--rtol", "1e-9").err.startswith(
        f"rotor-ida: study {folder!r} was begun"
    )


def test_a_study_that_cannot_be_drawn_has_its_result(program: Program):
    program("sweep", "--omega", 1, 1.7, "--zeta", "0.5:0.9:13", "--delta0", 0.5,
            "--study", "many")  # fmt: skip
    Path("many/result.nc").unlink()
    answer = program("resume", "many", "--figure", "figure.png")
    assert answer.status == 2
    assert answer.err.startswith("rotor-ida: figure can show at most 12 combinations")
    assert Path("many/result.nc").exists()


def test_an_atlas_goes_on_and_is_drawn(program: Program):
    atlas = ["atlas", "--omega", "1.5", "--zeta", "0.3:0.6:14", "--delta0", "0", "--x=-5:5"]
    atlas += ["--starts", "5", "--executor", "serial"]
    answer = program("atlas", "--omega", "1.5", "--zeta", "0.3", "--delta0", "0", "--x=-5:5",
                     "--figure", "one")  # fmt: skip
    assert (answer.status, answer.err) == (
        2, "rotor-ida: figure needs an atlas of several speeds, dampings or clearances, got one\n",
    )  # fmt: skip
    assert program(*atlas, "--study", "study").status == 0
    assert program("resume", "study", "--out", "atlas.nc", "--figure", "atlas").status == 0
    assert Path("atlas.png").exists()
    told = json.loads(program("show", "atlas.nc", "--json").out)
    assert (told["agreement"], told["agreement_count"]) == (1.0, 14)
    shown = program("show", "atlas.nc")
    assert shown.status == 0
    assert "synchronous" in shown.out


def test_an_atlas_of_given_starts_tells_how_many(program: Program):
    found = rotor_ida.continue_attractors(
        omega=[1.7, 1.75], zeta=0.07, delta0=0.0, starts=[(0, 0, 0, 0), (12, 0, 0, 0)]
    )
    rotor_ida.save(found, "given.nc")
    record = json.loads(program("show", "given.nc", "--json").out)
    assert record["starts"] == 2
    assert " to " in record["attractors"][0]["radius_max"]


def test_an_interrupted_sample_has_no_result_yet(program: Program, monkeypatch: Any):

    real = grid.run_all

    def breaks_off(*given: Any, **more: Any) -> Any:
        for turn, found in real(*given, **more):
            if turn == 1:
                raise KeyboardInterrupt
            yield turn, found

    sample = ["fractions", "--omega", "1.7", "--zeta", "0.5", "--delta0", "0.5"]
    sample += ["--x=-5:5", "--y=-5:5", "--starts", "2000", "--study", "study"]
    sample += ["--executor", "serial", "--out", "out.nc"]
    with monkeypatch.context() as patch:
        patch.setattr(grid, "run_all", breaks_off)
        answer = program(*sample)
    assert answer.status == 130
    assert answer.err == (
        "rotor-ida: interrupted; 512 of 2000 points are saved in study; continue with rotor-ida "
        "resume study\n"
    )
    assert sorted(os.listdir("study")) == [PIECES, FILE]
    assert not Path("out.nc").exists()
    assert program("resume", "study", "--out", "out.nc").status == 0
    result = rotor_ida.load("out.nc")
    assert int(result["not_computed_count"]) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["status", "absent"], "folder must be that of a study, got 'absent'"),
        (["resume", "absent"], "folder must be that of a study, got 'absent'"),
        (["status", "."], "folder must be that of a study, got '.'"),
        ([*SWEEP, "--rtol", "1e-9"], "study 'study' was begun with rtol 1e-10, got 1e-09"),
        ([*SWEEP[:-1], ""], "study must be a path, got ''"),
        ([*SWEEP[:-1], "file"], "study must be a folder, got the file 'file'"),
        ([*SWEEP[:-1], "full"], "study must be a new, an empty or a study's folder, got 'full'"),
        ([*SWEEP[:-1], "file/study"], "study must be a folder, got the file 'file'"),
        (["fractions", "--omega", "1", "--zeta", "1", "--delta0", "1", "--x", "1:2:3", "--y", "0"],
         "x must be a number or LOW:HIGH, got '1:2:3'"),
    ],
)  # fmt: skip
def test_bad_input_gets_one_line_and_loses_nothing(
    program: Program, words: list[str], message: str
):
    Path("file").write_text("")
    Path("full").mkdir()
    Path("full", "thesis.tex").write_text("")
    program(*SWEEP)
    before = Path("study", FILE).read_bytes()
    answer = program(*words)
    assert answer.status == 2
    assert answer.err.startswith(f"rotor-ida: {message}")
    assert answer.err.count("\n") == 1
    assert Path("study", FILE).read_bytes() == before
