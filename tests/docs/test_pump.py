"""The tutorial on a pump: its commands run one after the other, and give what its Python gives."""

import re
import runpy
import shlex
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

from rotor_ida import load, orders
from rotor_ida.cli.program import main

SCRIPT = Path(__file__).parents[2] / "docs" / "tutorial_scripts" / "pump.py"


def commands():
    """Return the words of each command on the page."""
    lines = [line.removeprefix("#").strip() for line in SCRIPT.read_text("utf-8").splitlines()]
    text = re.sub(r"\\\n", " ", "\n".join(lines))
    return [shlex.split(line)[1:] for line in text.splitlines() if line.startswith("rotor-ida ")]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pump")
    with pytest.MonkeyPatch.context() as patch, mpl.rc_context():
        patch.chdir(folder)
        yield runpy.run_path(str(SCRIPT)) | {"folder": folder}


def test_six_commands_give_the_same_answers(told, monkeypatch, capsys):
    monkeypatch.chdir(told["folder"])
    said = []
    for words in commands():
        assert main(words) == 0
        said.append(" ".join(capsys.readouterr().out.split()))
    assert len(said) == 6
    assert "critical speed [rpm] 5513" in said[0]
    assert told["summary"](told["run"]).sentence in said[1]
    assert told["summary"](told["quiet"]).sentence in said[4]
    # the two round the rate of the ramp otherwise
    np.testing.assert_allclose(load("pump.nc").event_time, told["run"].event_time, atol=1e-6)


def test_the_pump_rubs_with_g_6_3_and_not_with_g_2_5(told):
    assert told["summary"](told["run"]).sentence.startswith("Rub: it first touches the stator at")
    assert told["summary"](told["quiet"]).sentence.startswith("No rub")


def test_probes_and_run_show_the_same_whirl(told):
    """Away from the ring, where the motion has no corner between samples."""
    of_run, of_probes = (orders(told[name]) for name in ("run", "measured"))
    speeds = np.linspace(2000.0, 5000.0, 7) * np.pi / 30.0
    expected, found = (
        np.interp(speeds, each.speed, each.forward_whirl_amplitude[:, 0])
        for each in (of_run, of_probes)
    )
    np.testing.assert_allclose(found, expected, rtol=0.01)
