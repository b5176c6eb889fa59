"""The program called inside this process, and archives for it to read."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

import rotor_ida
from rotor_ida.cli import main
from rotor_ida.plot.appearance import SettledLayout
from rotor_ida.plot.saving import _draw


@dataclass(frozen=True)
class Answer:
    status: int
    out: str
    err: str


Program = Callable[..., Answer]


@pytest.fixture
def program(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Program:
    """Return the program; it runs in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Answer:
        capfd.readouterr()
        status = main([str(word) for word in words])
        shown = capfd.readouterr()
        return Answer(status, shown.out, shown.err)

    return run


def is_refused(program: Program, line: str, message: str) -> None:
    """Check that a line gets one line on standard error that has the message, and status 2."""
    answer = program(*line.split())
    assert (answer.status, answer.out) == (2, "")
    assert re.fullmatch(rf"rotor-ida: [^\n]*{re.escape(message)}[^\n]*\n", answer.err)


@pytest.fixture(autouse=True)
def _quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write empty figures, draw those on pages of few dots, and start no processes.

    `tests/plot` looks at figures, and `tests/cli/test_drop.py` at a PDF.
    """
    monkeypatch.setattr("rotor_ida.plot.saving._draw", lambda _, path: path.touch())
    monkeypatch.setattr("rotor_ida.cli.pages.RESOLUTION", 30)
    monkeypatch.setattr("rotor_ida.cli.pages.write_pdf", lambda path, *_: path.touch())
    monkeypatch.setattr("rotor_ida.parallel.count_workers", lambda _given: 1)
    monkeypatch.setattr(SettledLayout, "execute", lambda *_: None)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw the figures that are written, of few dots and with their axes where they are."""
    monkeypatch.setattr("rotor_ida.plot.saving._draw", _draw)
    monkeypatch.setattr("rotor_ida.plot.saving._DOTS_PER_INCH", 50)


@pytest.fixture(scope="session")
def archives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with archives of several kinds, and files that are no archives."""
    folder = tmp_path_factory.mktemp("archives")
    rotor = rotor_ida.Rotor(omega=1.2, zeta=0.07, delta0=2.0)
    run = rotor_ida.simulate(rotor, start=(0, 0, 0, 0), duration=60.0)
    rotor_ida.save(run, folder / "run.nc")
    sweep = rotor_ida.sweep(omega=[1.2, 2.0], zeta=0.5, delta0=[0.0, 0.5])
    rotor_ida.save(sweep, folder / "sweep.nc")
    report = rotor_ida.touchdown_report(
        rotor_ida.Rotor(omega=1.7, zeta=0.5, delta0=0.5), x=(-1, 1), y=(-1, 1), starts=16, shocks=0
    )
    rotor_ida.save(report, folder / "report.nc")
    rotor_ida.save(rotor_ida.compare(sweep), folder / "compared.nc")
    still = rotor_ida.Rotor(omega=1.7, zeta=0.3, delta0=0.0)
    basin = rotor_ida.basin(still, x=[-5.0, 0.0, 5.0], y=[-5.0, 5.0])
    rotor_ida.save(basin, folder / "basin.nc")
    bouncing = rotor_ida.Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    cycle = rotor_ida.limit_cycle(bouncing, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    rotor_ida.save(cycle, folder / "cycle.nc")
    branch = rotor_ida.continue_cycle(bouncing, start=cycle, limits=(1.5, 2.5))
    rotor_ida.save(branch, folder / "branch.nc")
    curve = rotor_ida.bifurcation_curve(
        bouncing,
        start=branch.isel(special=1),
        kind="period_doubling",
        limits=[(1.7, 1.9), (1.9, 2.1)],
    )
    rotor_ida.save(curve, folder / "curve.nc")
    (folder / "text.nc").write_text("no archive")
    (folder / "empty.nc").write_bytes(b"")
    (folder / "cut.nc").write_bytes((folder / "run.nc").read_bytes()[:2000])
    return folder
