import os
import signal
import subprocess
import sys
import time
from contextlib import closing

import pytest

from rotor_ida.paper.reproduction import run_scripts

PRINTING = "import sys; print(sys.argv[1:], flush=True); print('beside', file=sys.stderr)"
CRASHING = "import os; print('so far', flush=True); os.abort()"
RAISING = "raise ValueError('no such whirl')"
WAITING = """
import os, sys, time
from pathlib import Path
Path(sys.argv[1]).write_text(str(os.getpid()))
time.sleep(100.0)
"""


@pytest.fixture
def written(tmp_path):
    """Write scripts, and return where they are by name."""

    def write(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(text)
        return {name: tmp_path / f"{name}.py" for name in texts}

    return write


def test_script_that_crashes_takes_no_other_with_it(written, tmp_path):
    scripts = written(crashes=CRASHING, prints=PRINTING, raises=RAISING)
    ends = run_scripts(scripts, ["--quick"], root=tmp_path / "out", at_once=2)
    found = {ended.name: ended for ended in ends}
    assert found["crashes"].status == -signal.SIGABRT
    assert found["crashes"].printed.startswith("so far\n")
    assert found["prints"].status == 0
    assert found["prints"].printed == "['--quick']\nbeside\n"
    assert found["raises"].status == 1
    assert "ValueError: no such whirl" in found["raises"].printed


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def when_written(path):
    deadline = time.monotonic() + 60.0
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return int(path.read_text())


def test_scripts_end_when_nobody_asks_on(written, tmp_path):
    noted = tmp_path / "pid"
    scripts = written(waits=WAITING, prints=PRINTING)
    with closing(run_scripts(scripts, [str(noted)], root=tmp_path / "out", at_once=2)) as ends:
        assert next(ends).name == "prints"
        pid = when_written(noted)
    assert not is_alive(pid)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_interrupt_ends_the_scripts(written, tmp_path):
    noted = tmp_path / "pid"
    scripts = written(waits=WAITING)
    program = tmp_path / "program.py"
    program.write_text(
        "from pathlib import Path\n"
        "from rotor_ida.paper.reproduction import run_scripts\n"
        "if __name__ == '__main__':\n"
        f"    scripts = {{'waits': Path({str(scripts['waits'])!r})}}\n"
        f"    root = Path({str(tmp_path / 'out')!r})\n"
        f"    list(run_scripts(scripts, [{str(noted)!r}], root=root, at_once=1))\n"
    )
    with subprocess.Popen([sys.executable, program], stderr=subprocess.DEVNULL) as started:
        pid = when_written(noted)
        started.send_signal(signal.SIGINT)
        assert started.wait(timeout=60.0) == -signal.SIGINT
    assert not is_alive(pid)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interrupt_while_the_first_script_starts_is_one_line(tmp_path):
    """It reaches the whole group of processes, as from a terminal, before imports are done."""
    code = "import sys; from rotor_ida.cli import main; sys.exit(main())"
    words = ["reproduce", "--only", "fig07", "fig06", "--quick", "--out", str(tmp_path / "out")]
    with subprocess.Popen(
        [sys.executable, "-c", code, *words], start_new_session=True, text=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    ) as started:  # fmt: skip
        while started.poll() is None and not list(tmp_path.glob("out/*")):
            time.sleep(0.01)
        os.killpg(started.pid, signal.SIGINT)
        said = started.stderr.read()
        assert started.wait(timeout=60.0) == 130
    assert said == "rotor-ida: interrupted\n"
