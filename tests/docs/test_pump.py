"""The tutorial on a pump: its commands run one after the other, and give what its Python gives."""

import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from rotor_ida import full_spectrum, load, orders
from tests.docs.pages import commands, names_of, said_by, text_of

README, PAPER = (
    (Path(__file__).parents[2] / name).read_text("utf-8") for name in ("README.md", "paper.md")
)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pump")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield names_of("pump") | {"folder": folder}


# The speed of the pump in service [rad/s].
RUNNING = 3600.0 * np.pi / 30.0


def test_four_commands_give_the_same_answers(told, monkeypatch, capsys):
    monkeypatch.chdir(told["folder"])
    said = said_by(commands(text_of("pump")), monkeypatch, capsys)
    assert len(said) == 4
    assert "critical speed 5513.29 rpm" in said[0]
    assert told["summary"](told["run"], running_speed=RUNNING).sentence in said[1]
    assert told["summary"](told["quiet"], running_speed=RUNNING).sentence in said[3]
    # the two round the rate of the ramp otherwise
    np.testing.assert_allclose(load("pump.nc").event_time, told["run"].event_time, atol=1e-6)


def test_the_pump_rubs_with_g_6_3_and_not_with_g_2_5(told):
    assert told["summary"](told["run"]).sentence.startswith("Rub: it first touches the stator at")
    assert told["summary"](told["quiet"]).sentence.startswith("No rub")


def test_the_readme_has_the_same_machine_and_its_answer(told):
    described, run_up = commands(README)[:2]
    assert [described, run_up] == commands(text_of("pump"))[:2]
    said = told["summary"](told["run"], running_speed=RUNNING).sentence
    assert said in " ".join(README.split())
    for number in ("at 5,211 rpm", "up to 820 N", "keeps rubbing"):
        assert number in said
        assert number in PAPER


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
    run, pump, rpm = told["run"], told["pump"], np.pi / 30.0
    sag = pump.load / pump.shaft_stiffness
    assert 0.19 < sag / pump.clearance < 0.21
    first = np.searchsorted(run.t, run.entry_time[0])
    assert run.y.values[first] < -0.98 * 1e6 * pump.clearance
    assert run.peak_force.units == "N"
    assert 6.5 < float(run.peak_force.max()) / pump.load < 7.5
    rubbing = orders(run, revolutions=4).isel(order=0)
    rubbing = rubbing.isel(window=rubbing.speed.values > 5250.0 * rpm)
    lag = np.degrees(rubbing.forward_phase_lag.values)
    assert 28.0 < lag.min() < lag.max() < 35.0
    assert rubbing.forward_whirl_amplitude[-1] < rubbing.forward_whirl_amplitude[0]
    before, late = (
        full_spectrum(run.isel(t=(run.t.values > begin) & (run.t.values < begin + 0.5)))
        for begin in (18.0, 19.5)
    )
    backward = [float(each.whirl_amplitude[each.frequency.values < 0.0].max())
                for each in (before, late)]  # fmt: skip
    assert backward[1] > 100.0 * backward[0]
