"""A study that is killed with signal 9 loses nothing that was done."""

import os
import signal
import subprocess
import sys
import time

import pytest
import xarray as xr

from rotor_ida import InputError, status, sweep
from rotor_ida.storage.studies.database import FILE

SWEEP = {"omega": [0.02 * number for number in range(25, 145)], "zeta": 0.07, "delta0": [0.5, 2.0]}


@pytest.mark.skipif(os.name != "posix", reason="kills with a signal")
@pytest.mark.parametrize("executor", ["threads", "processes"])
def test_killed_and_resumed_it_ends_with_the_same_bits(tmp_path, executor):
    script = tmp_path / "script.py"
    script.write_text(
        "from rotor_ida import sweep\n"
        "if __name__ == '__main__':\n"
        f"    sweep(**{SWEEP!r}, study={str(tmp_path / 'study')!r}, executor={executor!r},\n"
        "          workers=2)\n"
    )
    running = subprocess.Popen([sys.executable, str(script)], start_new_session=True)
    while _done(tmp_path / "study") == 0:
        assert running.poll() is None
        time.sleep(0.01)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    assert 0 < _done(tmp_path / "study") < 240
    told = []
    again = sweep(
        **SWEEP, study=tmp_path / "study", progress=lambda done, total: told.append((done, total))
    )
    assert told[0][0] > 0
    assert told[-1] == (240, 240)
    xr.testing.assert_identical(again, sweep(**SWEEP))
    assert os.listdir(tmp_path / "study") == [FILE]


def _done(folder):
    try:
        return status(folder)["done"]
    except InputError:
        return 0
