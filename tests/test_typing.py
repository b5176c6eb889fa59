"""The types of the package are there for the programs that use it."""

import subprocess
import sys

PROGRAM = """
import xarray as xr

from rotor_ida import Rotor, load, simulate
from rotor_ida.closed_forms import cusp_zeta
from rotor_ida.testing import assert_events_close

rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
run: xr.Dataset = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
assert_events_close(run, load("run.nc"), atol=cusp_zeta(0.0))
"""
WRONG = """
simulate(rotor, start=(0, 0, 0, 0), duration="long")
simulate(rotor, start=(0, 0, 0, 0), duration=1.0, method="euler")
"""


def test_strict_types_of_a_program_of_a_user(tmp_path):
    script = tmp_path / "program.py"
    script.write_text(PROGRAM + WRONG, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), script.name]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    first = 1 + len(PROGRAM.splitlines()) + 1
    faults = [line for line in told.stdout.splitlines() if ": error: " in line]
    assert [line.split(":")[1] for line in faults] == [str(first), str(first + 1)]
    # the messages list the variants for a rotor and for a rotor system
    assert all("No overload variant" in fault for fault in faults)
    assert "duration: float" in told.stdout
