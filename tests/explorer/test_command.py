"""The command: one line and status 2 for a mistake, and a clean end when it is told to."""

from __future__ import annotations

import json
import os
import queue
import signal
import socket
import stat
import sys
import threading
from collections.abc import Callable, Iterator
from html import escape
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

import rotor_ida
from rotor_ida.cli import main
from rotor_ida.cli.commands.explore import NEEDED
from rotor_ida.explorer import explore as explorer
from rotor_ida.explorer.explore import can_show_a_page
from tests.explorer.asking import BEYOND, BEYOND_IN_SI, MACHINE, ROTOR, SLOW, asked
from tests.explorer.conftest import PATIENCE, Program, wait_until

Start = Callable[..., Program]


@pytest.fixture(autouse=True)
def no_thread_is_left() -> Iterator[None]:
    """Each test ends the threads that it began; what others have left in this process is theirs."""
    before = set(threading.enumerate())
    yield
    wait_until(
        lambda: all(each.daemon or each in before for each in threading.enumerate()),
        "the threads of a test",
    )


def said_of(words: list[str], capfd: pytest.CaptureFixture[str]) -> str:
    """Return the one line that a mistake gets."""
    capfd.readouterr()
    assert main(["explore", "--no-browser", *words]) == 2
    shown = capfd.readouterr()
    assert shown.out == ""
    (line,) = shown.err.splitlines()
    assert line.startswith("rotor-ida: ")
    return line


MISTAKES = [
    ("--port 70000", "port must be at most 65535, got 70000"),
    ("--port -1", "port must be at least 0, got -1"),
    ("--port http", "port must be a whole number, got 'http'"),
    ("--omega 2e6 --zeta 0.07 --delta0 2", "omega must be at most 1e+06 to be simulated"),
    ("--omega 2 --zeta 0.07 --delta0 2 --start 1 2 3", "start must be four numbers X Y VX VY"),
    ("--omega 2 --zeta 0.07 --delta0 2 --start 1 2 3 x", "start vy must be a finite real number"),
    ("--omega 2 --zeta 0.07 --delta0 2 --start 2e6 0 0 0", "start x must lie within 1e+06 of zero"),
    ("--speeds 1 2 3", "speeds must be left out without --export"),
    ("--export page.pdf", "export must end in .html, got 'page.pdf'"),
    ("--file missing.nc", "must be a file that exists, got 'missing.nc'"),
    ("now", "must be a file that exists, got 'now'"),
    ("run.nc now", "unexpected argument 'now'"),
]  # fmt: skip


def test_a_clearance_alone_beside_a_measured_file_is_refused_by_what_draws_it(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "probes.csv").write_text("t,x,y\n0,1,2\n")
    said = said_of([str(tmp_path / "probes.csv"), "--clearance", "150um"], capfd)
    assert said.endswith("plot with kind orbit or centreline draws it")


@pytest.mark.parametrize(("words", "told"), MISTAKES, ids=lambda value: value)
def test_a_mistake_gets_one_line(words: str, told: str, capfd: pytest.CaptureFixture[str]):
    assert told in said_of(words.split(), capfd)


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("archives")
    rotor = rotor_ida.Rotor(**ROTOR)
    run = rotor_ida.simulate(rotor, start=(0.5, 0, 0, 1), duration=40.0)
    rotor_ida.save(run, folder / "run.nc")
    (folder / "text.nc").write_text("no archive")
    (folder / "empty.nc").write_bytes(b"")
    return folder


@pytest.mark.parametrize("name", ["text.nc", "empty.nc"])
def test_a_file_that_is_no_run_of_ours_gets_one_line(
    name: str, archives: Path, capfd: pytest.CaptureFixture[str]
):
    assert name in said_of(["--file", str(archives / name)], capfd)


@pytest.mark.parametrize("words", ["--start 0 0 0 0", "--omega 2 --zeta 0.07 --delta0 2"])
def test_a_file_is_given_alone(words: str, archives: Path, capfd: pytest.CaptureFixture[str]):
    told = said_of(["--file", str(archives / "run.nc"), *words.split()], capfd)
    assert "file must be given alone" in told


def test_a_port_that_is_taken_gets_one_line_at_once(capfd: pytest.CaptureFixture[str]):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        number = taken.getsockname()[1]
        told = said_of(["--port", str(number)], capfd)
    assert f"port {number} cannot be used" in told
    assert "give another with --port" in told


@pytest.mark.parametrize("hidden", NEEDED)
def test_without_the_extra_one_line_says_how_to_install_it(
    hidden: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    monkeypatch.setitem(sys.modules, hidden, None)  # type: ignore[arg-type]
    assert said_of([], capfd) == (
        f"rotor-ida: explore needs {hidden}: install it with pip install 'rotor-ida[explore]'"
    )


def first_state(words: list[str], monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """Return the state with which the page begins."""
    seen: list[dict[str, object]] = []
    monkeypatch.setattr(explorer, "explore", lambda state, **_: seen.append(dict(state)))
    assert main(["explore", "--no-browser", *words]) == 0
    (state,) = seen
    return state


@pytest.mark.parametrize("given", [ROTOR | BEYOND, MACHINE | BEYOND_IN_SI], ids=["plain", "in SI"])
def test_the_page_begins_with_a_machine(given: dict[str, float], monkeypatch: pytest.MonkeyPatch):
    words = [f"--{name.replace('_', '-')}={value!r}" for name, value in given.items()]
    assert first_state(words, monkeypatch).items() >= given.items()


STARTED = {"x": 0.5, "y": 0.0, "vx": 0.0, "vy": 1.0, "revolutions": 13}


def test_the_page_begins_with_what_is_in_a_file(archives: Path, monkeypatch: pytest.MonkeyPatch):
    assert first_state([str(archives / "run.nc")], monkeypatch) == ROTOR | STARTED


posix = pytest.mark.skipif(sys.platform != "linux", reason="sends signals, looks into /proc")


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def state_of(program: Program) -> dict[str, str]:
    return {name: each for name, (each,) in parse_qs(urlsplit(program.address).fragment).items()}


def end(program: Program, send: Callable[[int], None]) -> None:
    """Let a program be told to end, and check that it does, and leaves nothing behind."""
    children = program.children()
    send(program.process.pid)
    assert program.ended() == 0
    assert "Traceback" not in program.text
    assert "rotor-ida:" not in program.text
    wait_until(lambda: not any(map(is_alive, children)), "the end of all processes")


SIGNALS: dict[str, Callable[[int], None]] = {
    "Ctrl-C": lambda pid: os.killpg(pid, signal.SIGINT),
    "SIGTERM": lambda pid: os.kill(pid, signal.SIGTERM),
    "a terminal that closes": lambda pid: os.killpg(pid, signal.SIGHUP),
}


@posix
@pytest.mark.parametrize("name", ["SIGTERM", "a terminal that closes"])
def test_it_ends_while_it_still_starts(name: str, start: Start):
    if name == "a terminal that closes" and signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
        pytest.skip("under nohup the program is to outlive its terminal")
    program = start()
    wait_until(lambda: bool(program.children()), "a process that starts")
    end(program, SIGNALS[name])


@posix
def test_a_killed_program_takes_its_processes_along(start: Start):
    program = start()
    wait_until(lambda: len(program.children()) == 3, "processes that start")
    children = program.children()
    program.process.kill()
    program.ended()
    wait_until(lambda: not any(map(is_alive, children)), "the end of all processes")


@posix
def test_it_ends_while_a_page_is_open_and_an_answer_is_computed(start: Start):
    program = start(*[f"--{key}={value}" for key, value in MACHINE.items()])
    program.wait_until_ready()
    state = state_of(program)
    assert len(state["key"]) == 32
    assert {key: float(value) for key, value in state.items() if key in MACHINE} == MACHINE
    with program.talk() as talk:
        talk.send(json.dumps(asked("starts", machine=SLOW)))
        assert talk.recv(PATIENCE)
        end(program, SIGNALS["Ctrl-C"])


def test_only_the_user_can_read_the_key_and_only_while_the_program_lives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """All users see what a browser is started with: it is a file that leads on, without a trace."""
    opened = queue.SimpleQueue[str]()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("webbrowser.open", opened.put)
    address = "http://127.0.0.1:8765/#omega=2&key=secret"
    with explorer._open_in_a_browser(address):
        (file,) = tmp_path.glob("*.html")
        assert opened.get(timeout=PATIENCE) == file.as_uri()
        if os.name == "posix":
            assert stat.S_IMODE(file.stat().st_mode) == 0o600
        page = file.read_text()
        assert f'url={escape(address)}"' in page
        assert '<meta name="referrer" content="no-referrer">' in page
    assert not file.exists()


def test_no_browser_is_opened_where_there_are_no_windows(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert not can_show_a_page()
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert can_show_a_page()
