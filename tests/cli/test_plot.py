"""The command plot draws archives and measured files, and says what it took and wrote."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from scipy.io import wavfile

import rotor_ida
from rotor_ida.cli.commands.plot import (
    DRAWN_BY,
    OF_SIGNALS,
    PLOTS_ALSO_CALLED,
    KindOfPlot,
    _kind_of_plot,
)
from rotor_ida.cli.exact import exact_beneath
from rotor_ida.plot.figures import figure_of
from rotor_ida.units import SPEED_UNITS
from tests.cli.conftest import Program, is_refused


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a run, its signals, a run-up in SI units and a measured table."""
    found = tmp_path_factory.mktemp("signals")
    rotor = rotor_ida.Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    start = (2.6, 0.75, 0.66, -1.65)
    run = rotor_ida.simulate(rotor, start=start, duration=200.0, samples=4001)
    rotor_ida.save(run, found / "run.nc")
    rotor_ida.save(rotor_ida.signals_of(run), found / "signals.nc")
    machine = rotor_ida.DimensionalRotor(
        mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=10e-6, clearance=20e-6,
        speed=31.416,
    )  # fmt: skip
    rpm = SPEED_UNITS["rpm"]
    up = rotor_ida.run_up(machine, to=1500.0 * rpm, rate=1500.0 * rpm, samples=8001)
    rotor_ida.save(up, found / "machine.nc")
    times = np.arange(4000) / 2000.0
    turn = 100.0 * np.pi * times
    columns = [times, 5.0 * np.cos(turn), 5.0 * np.sin(turn), np.cos(turn) > 0.9]
    table = np.stack(columns, axis=1)
    head = "t,x,y,keyphasor"
    np.savetxt(found / "probes.csv", table, delimiter=",", header=head, comments="", fmt="%.9g")
    wavfile.write(found / "probes.wav", 2000, table[:, 1:].astype(np.float32))
    return found


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *((kind, "machine.nc") for kind in OF_SIGNALS),
    ],
)
def test_every_kind_is_drawn(program: Program, folder: Path, kind: str, name: str):
    answer = program("plot", folder / name, "--kind", kind, "--figure", "drawn.png")
    assert (answer.status, answer.err) == (0, "")
    assert {path.name for path in Path().iterdir()} == {"drawn.png", "drawn.svg"}
    assert "wrote drawn.png" in answer.out


@pytest.mark.parametrize("kind", ["bode", "orbit"])
def test_the_exact_cycle_of_the_archived_rotor_goes_beneath(
    program: Program, folder: Path, kind: str
):
    words = ("plot", folder / "signals.nc", "--kind", kind, "--figure", "drawn", "--exact")
    assert program(*words).status == 0
    found = exact_beneath(rotor_ida.load(folder / "signals.nc"), kind)
    if kind == "bode":
        assert "piece" in found[0]
        assert "fold_omega" in found[1]
    else:
        assert float(found[0].period) == pytest.approx(4.564, abs=0.001)


def test_the_exact_cycle_of_a_run_in_si_units_is_that_of_the_dimensionless_one(folder: Path):
    run = rotor_ida.load(folder / "run.nc")
    # of the reference frequency 100/s, whose rotor is that of the run
    machine = rotor_ida.DimensionalRotor(
        mass=4.0, contact_stiffness=4e4 / 1e-5**0.5, damping=56.0, eccentricity=1e-5,
        clearance=2e-5, speed=200.0,
    )  # fmt: skip
    assert machine.rotor().omega == pytest.approx(2.0)
    cycle, *_ = exact_beneath(rotor_ida.dimensional(run, machine), "orbit")
    assert float(cycle.period) == pytest.approx(4.564, abs=0.001)


def test_columns_of_a_measured_file_are_chosen(
    program: Program, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    seen = []
    read = rotor_ida.read_signals
    monkeypatch.setattr(
        "rotor_ida.read_signals", lambda *a, **k: seen.append(read(*a, **k)) or seen[0]
    )
    words = ("plot", folder / "probes.wav", "--kind", "trace", "--figure", "a")
    columns = ("--columns", "x=1", "y=2", "keyphasor=3")
    answer = program(*words, *columns, "--units", "x=um", "y=um", "--json")
    assert (answer.status, answer.err) == (0, "")
    record = json.loads(answer.out)
    assert record["samples"] == 4000
    assert "x=" in record["columns"]
    turn = 100.0 * np.pi * seen[0].t.values
    np.testing.assert_allclose(seen[0].x, 5.0 * np.cos(turn), atol=1e-5)
    assert seen[0].x.attrs["units"] == "um"


def test_probes_at_any_angles_are_turned(program: Program, folder: Path, monkeypatch):
    seen = {}

    def remember(path: Path, **given: object) -> Any:
        seen.update(given)
        return read(path, **given)

    read = rotor_ida.read_signals
    monkeypatch.setattr("rotor_ida.read_signals", remember)
    answer = program(
        "plot", folder / "probes.csv", "--kind", "orbit", "--figure", "a", "--probe-angles", 45,
        135, "--gains", 2, 2, "--keyphasor", "signal", "--pulses-per-revolution", 1, "--times",
        0.5, 1, "--clearance", 3,
    )  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    assert re.search(r"samples +1001", answer.out)
    assert seen == {
        "probe_angles": (45.0, 135.0), "gains": (2.0, 2.0), "keyphasor": "signal",
        "pulses_per_revolution": 1,
    }  # fmt: skip


@pytest.mark.parametrize("kind", ["bode", "centreline"])
def test_orders_are_fitted_together_in_windows_of_a_length(
    program: Program, folder: Path, monkeypatch, kind: str
):
    seen = []
    track = rotor_ida.orders
    monkeypatch.setattr(
        "rotor_ida.plot.signals.orders.tracked",
        lambda signals, orders, **given: (
            seen.append((np.sort(orders).tolist(), given)) or track(signals, orders, **given)
        ),
    )
    words = ("plot", folder / "probes.csv", "--kind", kind, "--figure", "a")
    answer = program(*words, "--orders", 0.5, 1, "--revolutions", 4)
    assert (answer.status, answer.err) == (0, "")
    assert seen == [([0.5, 1.0], {"revolutions": 4})]


def test_every_kind_of_plot_has_its_function():
    known = DRAWN_BY
    assert set(get_args(KindOfPlot)) == set(known)
    assert set(PLOTS_ALSO_CALLED.values()) <= set(known)
    assert not PLOTS_ALSO_CALLED.keys() & set(known)
    assert all(hasattr(rotor_ida.plot, name) for name in known.values())
    words = ("waterfall", "Waterfall", "cascade", "CASCADE")
    assert {_kind_of_plot("kind", [word]) for word in words} == {"cascade"}


@pytest.mark.parametrize(("name", "kind"), [("run.nc", "run"), ("probes.csv", "orbit")])
def test_a_file_alone_is_drawn_as_suits_it_beside_it(
    program: Program, folder: Path, name: str, kind: str
):
    copied = Path(name)
    copied.write_bytes((folder / name).read_bytes())
    answer = program("plot", name, "--json")
    assert (answer.status, answer.err) == (0, "")
    assert json.loads(answer.out)["kind"] == kind
    drawn = {f"{copied.stem}.png", f"{copied.stem}.svg"}
    assert {path.name for path in Path().iterdir()} == {name} | drawn
    assert "already exists; pass --force to replace it" in program("plot", name).err


@pytest.mark.usefixtures("drawn")
def test_a_measured_file_is_told_for_a_rub_and_drawn_in_mils_on_request(
    program: Program, folder: Path
):
    line = ("plot", folder / "probes.csv", "--units", "x=um", "y=um", "--figure", "a.svg", "--inch")
    said = program(*line).out
    assert "Nothing stands out beside 1X" in said
    assert "displacement $X$ [mil]" in Path("a.svg").read_text()


@pytest.mark.parametrize(
    ("speeds", "label"),
    [
        ((10.0, 60.0), "phase lag $\\theta$ [°]"),
        ((10.0, 60.0, 10.0), "phase lag $\\theta$ [°]"),
        ((30.0, 30.0), "displacement $Y$ [µm]"),
        ((0.1, 1.0), "displacement $Y$ [µm]"),
    ],
)
def test_a_measured_run_up_is_a_bode_plot_and_a_steady_record_an_orbit(
    program: Program, speeds: tuple[float, ...], label: str
):
    """Speeds in Hz along four seconds; below a few revolutions there is no curve."""
    t = np.arange(8000) / 2000.0
    speed = 2.0 * np.pi * np.interp(t, np.linspace(0.0, 4.0, len(speeds)), speeds)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / 2000.0)])
    table = np.stack([t, 5.0 * np.cos(angle), 5.0 * np.sin(angle), angle], axis=1)
    head = "t [s],x [um],y [um],angle [rad]"
    np.savetxt("up.csv", table, delimiter=",", header=head, comments="", fmt="%.12g")
    drawn = figure_of(rotor_ida.read_signals("up.csv"))
    assert label in [ax.get_ylabel() for ax in drawn.axes]
    answer = program("plot", "up.csv", "--json")
    assert (answer.status, answer.err) == (0, "")
    assert json.loads(answer.out)["written"] == ["up.png", "up.svg"]


def test_a_cascade_may_be_over_the_time(program: Program, folder: Path):
    words = ("plot", folder / "probes.csv", "--kind", "cascade", "--figure", "a")
    answer = program(*words, "--over", "time")
    assert (answer.status, answer.err) == (0, "")


def test_part_of_a_run_is_drawn_without_the_events_outside(program: Program):
    """They would stand apart from the samples, which are refused where they are too far apart."""
    run = rotor_ida.simulate(rotor_ida.Rotor(omega=2.0, zeta=0.07, delta0=2.0), duration=20.0)
    rotor_ida.save(run, "run.nc")
    answer = program("plot", "run.nc", "--times", "0.5", "8")
    assert (answer.status, answer.err) == (0, "")
    answer = program("plot", "run.nc", "--times", "8", "0.5", "--figure", "none")
    assert (answer.status, answer.err) == (2, "rotor-ida: times must increase, got 0.5 after 8.0\n")


def test_a_clearance_with_its_unit_is_that_in_the_unit_of_the_probes(
    program: Program, folder: Path
):
    for name, clearance in (("a", "7"), ("b", "0.007mm")):
        words = (
            "--units",
            "x=um",
            "y=um",
            "t=s",
            "--clearance",
            clearance,
            "--times",
            "0s",
            "0.5 s",
        )
        answer = program("plot", folder / "probes.csv", "--kind", "orbit", "--figure", name, *words)
        assert (answer.status, answer.err) == (0, "")
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes()


def test_columns_are_guessed_and_what_was_assumed_is_told(program: Program):
    t = np.arange(4000) / 2000.0
    turn = 2.0 * np.pi * 10.0 * t
    probes = [40.0 * np.cos(turn - angle) for angle in (np.pi / 4.0, -np.pi / 4.0)]
    table = np.stack([t, *probes, np.full(t.size, 600.0)], axis=1)
    head = "time_s,probe_A_um,probe_B_um,speed_rpm"
    np.savetxt("pump.csv", table, delimiter=",", header=head, comments="", fmt="%.9g")
    answer = program("plot", "pump.csv", "--kind", "bode", "--figure", "a", "--json",
                     "--probe-angles", 45, -45)  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    told = json.loads(answer.out)
    assert told["columns"].startswith("t=time_s x=probe_A_um y=probe_B_um speed=speed_rpm")
    assert told["notes"].startswith("the angle is integrated from the speed")
    answer = program("plot", "pump.csv", "--kind", "trace", "--figure", "b", "--sensitivity",
                     "200mV/mil", "--units", "x=V", "y=V", "--json")  # fmt: skip
    assert (answer.status, answer.err) == (0, "")
    assert "probes are taken to be at 0 and 90 degrees" in json.loads(answer.out)["notes"]


@pytest.fixture(scope="module")
def systems(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a run and a run-up of a rotor system, in SI units."""
    found = tmp_path_factory.mktemp("systems")
    chain = np.array([[8e6, -4e6], [-4e6, 6e6]])
    system = rotor_ida.RotorSystem(
        mass=np.diag([12.0, 12.0, 8.0, 8.0]), stiffness=np.kron(chain, np.eye(2)),
        damping=np.kron(1e-3 * chain, np.eye(2)), nodes={"disc": (0, 1), "seal": (2, 3)},
    )  # fmt: skip
    parts = {
        "contacts": [rotor_ida.Contact(node="seal", clearance=5e-5, stiffness=5e7)],
        "unbalance": [rotor_ida.Unbalance(node="disc", moment=1e-3)],
    }
    run = rotor_ida.simulate(system, speed=450.0, duration=0.3, samples=3001, **parts)
    rotor_ida.save(run, found / "run.nc")
    up = rotor_ida.run_up(system, speed=100.0, to=500.0, rate=500.0, samples=8001, **parts)
    rotor_ida.save(up, found / "up.nc")
    return found


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("run.nc", []),
        ("run.nc", ["--node", "disc"]),
        ("run.nc", ["--times", "100ms", "200ms"]),
        ("run.nc", ["--kind", "orbits"]),
        ("run.nc", ["--kind", "forces", "--contact", "0", "--times", "0s", "0.1s"]),
        ("run.nc", ["--kind", "history", "--node", "seal"]),
        ("run.nc", ["--kind", "shape", "--at", "100ms"]),
        ("up.nc", ["--kind", "bode", "--node", "seal"]),
    ],
)
def test_a_run_of_a_system_is_drawn_whole_or_at_a_node(
    program: Program, systems: Path, name: str, words: list[str]
):
    answer = program("plot", systems / name, *words, "--figure", "drawn.png")
    assert (answer.status, answer.err) == (0, "")
    assert {path.name for path in Path().iterdir()} == {"drawn.png", "drawn.svg"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--kind", "bode"], "node must be 'disc' or 'seal'"),
        (["--kind", "forces", "--contact", "4"], "contact must be one of 0 to 0, got 4"),
        (["--kind", "orbit", "--node", "seal", "--contact", "0"], "contact must be left out with"),
        (["--kind", "orbits", "--node", "seal"], "node must be left out with --kind orbits"),
        (["--kind", "orbits", "--exact"], "exact must be left out with --kind orbits"),
        (["--kind", "shape", "--at", "3"], "t must lie from 0 to 0.3, got 3.0"),
        (["--at", "0.1"], "--kind must be given with --at"),
    ],
)
def test_what_a_run_of_a_system_does_not_have_is_refused_in_one_line(
    program: Program, systems: Path, words: list[str], message: str
):
    line = " ".join(["plot", str(systems / "run.nc"), *words, "--figure drawn"])
    is_refused(program, line, message)
    assert not list(Path().iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--kind", "orbits"], "run must be of a rotor system, got"),
        (["--kind", "orbit", "--node", "a"], "node must be left out but for a run of a rotor"),
    ],
)
def test_one_disc_and_measured_signals_have_no_nodes(
    program: Program, folder: Path, words: list[str], message: str
):
    for name in ("run.nc", "probes.csv"):
        answer = program("plot", folder / name, *words, "--figure", "drawn")
        assert (answer.status, answer.out) == (2, "")
        is_measured = name == "probes.csv" and words == ["--kind", "orbits"]
        assert ("for a measured file, got 'orbits'" if is_measured else message) in answer.err
