"""A study that is killed with signal 9 loses nothing that was done."""

import os
import signal
import subprocess
import sys

import pytest
import xarray as xr

from rotor_ida import Rotor, bifurcation_curve, resume, status, sweep
from rotor_ida.results.studies.store import FILE, PIECES

SWEEP = {
    "omega": [0.2 * number for number in range(3, 15)], "zeta": 0.07, "delta0": [0.5, 2.0],
    "method": "taylor",
}  # fmt: skip


@pytest.mark.skipif(os.name != "posix", reason="kills with a signal")
@pytest.mark.parametrize("executor", ["processes", "threads"])
def test_killed_and_resumed_it_ends_with_the_same_bits(tmp_path, executor):
    points = 24
    script = tmp_path / "script.py"
    # it kills itself and its workers, while these are at the points that follow
    script.write_text(
        "import os, signal\n"
        "from rotor_ida import sweep\n"
        "def kill(done, total):\n"
        "    if done >= 3:\n"
        "        os.killpg(0, signal.SIGKILL)\n"
        "if __name__ == '__main__':\n"
        f"    sweep(**{SWEEP!r}, study={str(tmp_path / 'study')!r}, executor={executor!r},\n"
        "           workers=2, progress=kill)\n"
    )
    ended = subprocess.run([sys.executable, str(script)], start_new_session=True, check=False)
    assert ended.returncode == -signal.SIGKILL
    assert 0 < status(tmp_path / "study")["done"] < points
    told = []
    again = sweep(
        **SWEEP, study=tmp_path / "study", progress=lambda done, total: told.append((done, total))
    )
    assert told[0][0] > 0
    assert told[-1] == (points, points)
    xr.testing.assert_identical(again, sweep(**SWEEP))
    assert sorted(os.listdir(tmp_path / "study")) == [PIECES, FILE]
    assert "unfinished" not in os.listdir(tmp_path / "study" / PIECES)


@pytest.mark.skipif(os.name != "posix", reason="kills with a signal")
def test_killed_on_a_curve_of_folds_it_resumes_with_the_same_bits(tmp_path):
    """In pieces of two points; the call by name, or ``resume``, goes on behind the last one."""
    script, study = tmp_path / "script.py", tmp_path / "study"
    given = {"start": (3, 1, 0, 0), "kind": "fold",
             "limits": {"omega": (2.4, 3.2), "delta0": (0.4, 0.6)}}  # fmt: skip
    script.write_text(
        "import os, signal\n"
        "from rotor_ida import Rotor, bifurcation_curve\n"
        "from rotor_ida.cycles import continue_cycle\n"
        "continue_cycle.PIECE = 2\n"
        "def kill(done, total):\n"
        "    if done >= 4:\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
        f"bifurcation_curve(Rotor(omega=3.0, zeta=0.07, delta0=0.5), **{given!r},\n"
        f"                  study={str(study)!r}, progress=kill)\n"
    )
    ended = subprocess.run([sys.executable, str(script)], check=False)
    assert ended.returncode == -signal.SIGKILL
    assert status(study)["done"] == 4
    told = []
    again = resume(study, progress=lambda done, total: told.append((done, total)))
    assert told[0][0] > 4
    assert told[-1] == (3998, 3998)
    rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    xr.testing.assert_identical(again, bifurcation_curve(rotor, **given))
    xr.testing.assert_identical(again, bifurcation_curve(rotor, **given, study=study))
