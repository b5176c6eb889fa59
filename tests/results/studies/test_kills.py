"""A study that is killed with signal 9 loses nothing that was done."""

import os
import signal
import subprocess
import sys
import time

import pytest
import xarray as xr

import rotor_ida
from rotor_ida import InputError, status
from rotor_ida.results.studies.database import FILE

SWEEP = {
    "omega": [0.02 * number for number in range(25, 145)], "zeta": 0.07, "delta0": [0.5, 2.0],
    "method": "taylor",
}  # fmt: skip
RUN_UPS = {
    "omega": 0.3, "to": 1.6, "rate": [0.1 + 0.001 * number for number in range(60)], "zeta": 0.1,
    "delta0": [1.0, 2.0], "shaft_stiffness": 1.0, "rtol": 1e-8, "method": "taylor",
}  # fmt: skip
STUDIES = {"sweep": (SWEEP, 240), "run_ups": (RUN_UPS, 120)}


@pytest.mark.skipif(os.name != "posix", reason="kills with a signal")
@pytest.mark.parametrize(
    ("kind", "executor"),
    [("sweep", "processes"), ("run_ups", "threads")],
)
def test_killed_and_resumed_it_ends_with_the_same_bits(tmp_path, kind, executor):
    given, points = STUDIES[kind]
    function = getattr(rotor_ida, kind)
    script = tmp_path / "script.py"
    script.write_text(
        f"from rotor_ida import {kind}\n"
        "if __name__ == '__main__':\n"
        f"    {kind}(**{given!r}, study={str(tmp_path / 'study')!r}, executor={executor!r},\n"
        "           workers=2)\n"
    )
    running = subprocess.Popen([sys.executable, str(script)], start_new_session=True)
    while _done(tmp_path / "study") == 0:
        assert running.poll() is None
        time.sleep(0.01)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    assert 0 < _done(tmp_path / "study") < points
    told = []
    again = function(
        **given, study=tmp_path / "study", progress=lambda done, total: told.append((done, total))
    )
    assert told[0][0] > 0
    assert told[-1] == (points, points)
    xr.testing.assert_identical(again, function(**given))
    assert os.listdir(tmp_path / "study") == [FILE]


def _done(folder):
    try:
        return status(folder)["done"]
    except InputError:
        return 0
