"""Starts that are words on the command line, of one disc."""

from __future__ import annotations

import json

import numpy as np
import pytest

import rotor_ida
from rotor_ida.cli.commands.explore import _beginning
from rotor_ida.cli.rotor_options import RotorOptions
from rotor_ida.plot.responses import _start_words
from tests.cli.conftest import Program

SHAFT = ("--zeta", 0.1, "--delta0", 2, "--shaft-stiffness", 1, "--load", 0.2)
SAG = 0.2


def whirl(omega: float) -> complex:
    """Return the steady whirl without contact, ``z'' + 2 zeta z' + kappa z = omega**2 e**...``."""
    return omega**2 / (1.0 - omega**2 + 0.2j * omega)


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "--omega", 0.7, "--duration", 1, "--start", "settled"),
        ("simulate", "--omega", 0.7, "--start=settled", "--duration", 1),
        ("run-up", "--omega", 0.5, "--start", "settled", "--speeds", "0:0.7", "2:0.8"),
    ],
)
def test_settled_is_the_whirl_about_the_sag(program: Program, words: tuple[object, ...]):
    """The first speed of a profile counts, not that of the rotor."""
    answer = program(*words, *SHAFT, "--out", "run.nc")
    assert (answer.status, answer.err) == (0, "")
    z = whirl(0.7)
    expected = (z.real, z.imag - SAG, -0.7 * z.imag, 0.7 * z.real)
    assert rotor_ida.load("run.nc").attrs["start"] == pytest.approx(expected, rel=1e-12)


def test_a_machine_starts_settled_in_si_units(program: Program):
    sheet = ("--mass", "4kg", "--contact-stiffness", 3.2e7, "--damping", "89.1Ns/m",
             "--eccentricity", "10um", "--clearance", "200um", "--speed", "3000rpm",
             "--shaft-stiffness", 1e6)  # fmt: skip
    run = ("--duration", "1ms", "--out", "run.nc")
    assert program("simulate", *sheet, *run, "--start", "settled").status == 0
    speed = 100.0 * np.pi
    z = 4.0 * 1e-5 * speed**2 / (1e6 - 4.0 * speed**2 + 89.1j * speed)
    assert rotor_ida.load("run.nc").x[0].item() == pytest.approx(z.real, rel=1e-9)


def test_several_starts_may_be_words_and_are_shown_as_words(program: Program):
    starts = ("--start", "settled", "rest", 0, "-0.1", 0, 0, "--start", "rest")
    sweep = ("sweep", "--omega", 0.5, 0.7, *SHAFT, "--workers", 1, "--out", "map.nc")
    answer = program(*sweep, *starts)
    assert (answer.status, answer.err) == (0, "")
    words = [{"start": "settled"}, {"start": "rest"}, None, {"start": "rest"}]
    shown = json.loads(program("show", "map.nc", "--json").out)["starts"]
    assert shown[:2] + shown[3:] == words[:2] + words[3:]
    assert shown[2] == {"start_x": 0.0, "start_y": -0.1, "start_vx": 0.0, "start_vy": 0.0}
    assert "Starts: 0 settled, 1 rest, 3 rest" in program("show", "map.nc").out
    rotor_ida.save(rotor_ida.load("map.nc").isel(start=[1, 2]), "part.nc")
    assert "Starts: 1 rest\n" in program("show", "part.nc").out


@pytest.mark.parametrize(
    ("word", "said"), [("rest", "rest"), ("settled", "its contact-free whirl")]
)
def test_run_ups_and_diagrams_take_words(program: Program, word: str, said: str):
    how = ("--start", word, "--workers", 1, "--force")
    ramps = ("run-ups", "--omega", 0.3, "--to", 0.4, "--rate", 0.05, *SHAFT, "--out", "a.nc")
    assert program(*ramps, *how).status == 0
    assert f"Starts: 0 {word}\n" in program("show", "a.nc").out
    diagram = ("--omega", 0.5, 0.6, *SHAFT, "--extrema-time", 10, "--out", "b.nc")
    assert program("bifurcation-diagram", *diagram, *how).status == 0
    assert _start_words(rotor_ida.load("b.nc")) == f"each speed from {said}"


def test_the_page_of_the_explorer_begins_from_a_word():
    given = {"omega": 0.7, "zeta": 0.1, "delta0": 2.0, "shaft_stiffness": 1.0, "load": 0.2}
    z = whirl(0.7)
    state, _ = _beginning(RotorOptions(**given), "settled", None)
    start = tuple(state[name] for name in ("x", "y", "vx", "vy"))
    assert start == pytest.approx((z.real, z.imag - SAG, -0.7 * z.imag, 0.7 * z.real), rel=1e-12)


def test_the_load_of_a_machine_may_be_its_weight(program: Program):
    """It starts hanging by its weight over the stiffness of the shaft, and says so."""
    sheet = ("--mass", "4kg", "--contact-stiffness", 3.2e7, "--damping", "89.1Ns/m",
             "--eccentricity", "10um", "--clearance", "200um", "--speed", "300rpm",
             "--shaft-stiffness", 1e6)  # fmt: skip
    sag = 4.0 * 9.80665 / 1e6
    ramp = ("--to", "1000rpm", "--rate", "1000rpm/s", "--out", "run.nc")
    answer = program("run-up", *sheet, "--load", "weight", *ramp)
    assert (answer.status, answer.err) == (0, "")
    assert f"It starts hanging {1e6 * sag:.3g} um below the axis." in " ".join(answer.out.split())
    assert rotor_ida.load("run.nc").y[0].item() == pytest.approx(-sag, rel=1e-12)
    sweep = ("sweep", *sheet, "--load", "0", "weight", "--workers", 1, "--out", "map.nc")
    assert program(*sweep).status == 0
    weight = f"{4.0 * 9.80665!r}N"
    assert program(*sweep[:-7], "--load", "0", weight, "--workers", 1, "--out", "n.nc").status == 0
    assert rotor_ida.load("map.nc").equals(rotor_ida.load("n.nc"))
