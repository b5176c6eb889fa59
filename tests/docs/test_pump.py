"""The tutorial on a pump: its commands run one after the other, and give what its Python gives."""

import re
import runpy
import shlex
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from rotor_ida import full_spectrum, load, orders
from rotor_ida.cli.program import main

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "docs" / "tutorial_scripts" / "pump.py"
README = (ROOT / "README.md").read_text("utf-8")


def commands(page):
    """Return the words of each command on a page."""
    lines = [line.removeprefix("#").strip() for line in page.splitlines()]
    text = re.sub(r"\\\n", " ", "\n".join(lines))
    return [shlex.split(line)[1:] for line in text.splitlines() if line.startswith("rotor-ida ")]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pump")
    with pytest.MonkeyPatch.context() as patch, mpl.rc_context():
        patch.chdir(folder)
        yield runpy.run_path(str(SCRIPT)) | {"folder": folder}


# The speed of the pump in service [rad/s].
RUNNING = 3600.0 * np.pi / 30.0


def test_six_commands_give_the_same_answers(told, monkeypatch, capsys):
    monkeypatch.chdir(told["folder"])
    said = []
    for words in commands(SCRIPT.read_text("utf-8")):
        assert main(words) == 0
        said.append(" ".join(capsys.readouterr().out.split()))
    assert len(said) == 6
    assert "critical speed 5513.29 rpm" in said[0]
    assert told["summary"](told["run"], running_speed=RUNNING).sentence in said[1]
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


def test_the_readme_has_the_same_machine_and_its_answer(told):
    described, run_up = commands(README)[:2]
    assert [described, run_up] == commands(SCRIPT.read_text("utf-8"))[:2]
    said = told["summary"](told["run"], running_speed=RUNNING).sentence
    assert said in " ".join(README.split())


def test_the_python_of_the_readme_prints_what_stands_beside_it(capsys, monkeypatch):
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)[1]
    stated = [text for line in code.splitlines() for text in re.findall(r"^print.*  # (.*)", line)]
    exec(code, {})
    plt.close("all")
    for said, text in zip(capsys.readouterr().out.splitlines(), stated, strict=True):
        if text.startswith("about "):
            assert float(text.split()[1]) / 3.0 < float(said) < 3.0 * float(text.split()[1])
        else:
            assert said.startswith(text.removesuffix("..."))


def test_what_the_tutorial_says_of_the_rub_is_so(told):
    run, rpm = told["run"], np.pi / 30.0
    assert run.peak_force.units == "N"
    assert 9.0 < float(run.peak_force.max()) / (12.0 * 9.81) < 11.0
    rubbing = orders(run, revolutions=4).isel(order=0)
    rubbing = rubbing.isel(window=rubbing.speed.values > 5400.0 * rpm)
    lag = np.degrees(rubbing.forward_phase_lag.values)
    assert 30.0 < lag.min() < lag.max() < 40.0
    assert rubbing.forward_whirl_amplitude[-1] < rubbing.forward_whirl_amplitude[0]
    late = run.isel(t=run.t.values > 19.0)
    spectrum = full_spectrum(late)
    backward = spectrum.isel(frequency=spectrum.frequency.values < 0.0)
    strongest = float(backward.frequency[int(backward.whirl_amplitude.values.argmax())])
    assert -125.0 < strongest / (2.0 * np.pi) < -112.0
