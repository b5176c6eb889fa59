"""Reports that one hands on: of any answer, with what was given and the lines that repeat it."""

from __future__ import annotations

import html
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida.cli.given import sheets_of_rotor
from rotor_ida.model.system_parts import Contact, Race, Stator, Support, Unbalance
from tests.cli.conftest import Program
from tests.cli.test_help import example_of_system

PUMP = ("--mass", "12kg", "--shaft-stiffness", "4e6N/m", "--damping-ratio", "3%", "--clearance",
        "150um", "--balance-grade", "G6.3", "--balance-speed", "3600rpm", "--speed", "3600rpm",
        "--contact-stiffness", "1e8N/m")  # fmt: skip
DISC = "--omega 2 --zeta 0.07 --delta0 2"
# What each page says of the rotor, with the numbers worked out by hand: e = 6.3 mm/s / 377 rad/s.
MACHINE = {"mass": "12 kg", "unbalance": "200.535 g mm", "critical speed": "5513.29 rpm",
           "balance grade at the running speed": "6.3 mm/s", "contact stiffness": "100 MN/m",
           "shaft stiffness": "4 MN/m", "clearance": "150 µm"}  # fmt: skip
SYSTEM = {"mass": "20 kg", "unbalance of all nodes": "1200 g mm", "clearance [µm]": "150",
          "stiffness of the linear contact [MN/m]": "50", "unbalance [g mm]": "1200"}  # fmt: skip
WANTED = {
    f"simulate {DISC} --duration 20": {"omega": "2", "zeta": "0.07", "delta0": "2"},
    "simulate --machine pump.toml --duration 20ms": MACHINE,
    "simulate rotor.toml --duration 20ms": {
        **SYSTEM, "balance grade at this speed": "27.0177 mm/s",  # 1200/20 um at 4300 rpm
    },
    "run-up --machine pump.toml --to 600rpm --in 1s": MACHINE,
    "sweep --machine pump.toml --speed 3000rpm 3600rpm": MACHINE,
    "clearance-report rotor.toml --speed 7000rpm 9000rpm --without-gravity": SYSTEM,
    "folds --zeta 0.07 --delta0 0.5": {},
    "fit run_up.nc --zeta 0.1 --delta0 2 --shaft-stiffness 1.1 --unknown zeta shaft_stiffness": {},
    "plot run_up.nc --kind cascade": {"kind": "cascade", "omega": "0.2"},
    "plot probes.csv --kind orbit --times 0.5 1": {"kind": "orbit", "t": "0 to 1 s"},
}  # fmt: skip


def rows_of(page: str) -> dict[str, str]:
    """Return the rows of all tables of a page by their first cell."""
    found = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", page)]
    return {cells[0]: " ".join(cells[1:]).strip() for cells in map(list, found) if cells}


@pytest.fixture
def files(program: Program) -> None:
    """Write a machine, a system and a run-up."""
    assert program("machine", *PUMP, "--out", "pump.toml").status == 0
    Path("rotor.toml").write_text(example_of_system())
    up = "run-up --omega 0.2 --zeta 0.07 --delta0 2 --shaft-stiffness 1 --to 2 --rate 0.05"
    assert program(*up.split(), "--out", "run_up.nc").status == 0
    times = np.linspace(0.0, 1.0, 2001)
    table = [times, 20.0 * np.cos(300.0 * times), 20.0 * np.sin(300.0 * times)]
    np.savetxt("probes.csv", np.transpose(table), delimiter=",", header="time_s,x_um,y_um",
               comments="")  # fmt: skip


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("line", WANTED)
def test_a_report_has_what_was_given_and_its_line_gives_the_same_again(program: Program, line: str):
    answer = program(*line.split(), "--report", "report")
    assert (answer.status, answer.err) == (0, "")
    assert {each.name for each in Path("report").iterdir()} == {
        "report.html", "report.pdf", "result.nc"
    }  # fmt: skip
    page = html.unescape(Path("report/report.html").read_text("utf-8"))
    rows = rows_of(page)
    for name, value in WANTED[line].items():
        assert rows[name] == value, name
    assert answer.out.splitlines()[0].strip().split("  ")[0] in page
    assert "What is assumed" in page
    assert ("The rotor is linear" in page) == ("rotor.toml" in line)
    assert ("What the model lacks goes into the residuals" in page) == line.startswith("fit")
    assert rows["rotor ida"] == rotor_ida.__version__
    assert page.count("data:image/png;base64,") == 1
    again, *check = re.findall(r"rotor-ida (?:[\w-]+ .*)", page.split("Compute it again")[1])
    assert bool(check) == (not line.startswith(("fit", "plot probes")))
    if line.startswith(("run-up", "fit", "plot")):  # though its files are there
        for each in (again, *check):
            assert program(*shlex.split(each)[1:]).status == 0
    if ".toml" in line:
        file = next(each for each in line.split() if each.endswith(".toml"))
        assert Path(file).read_text() in page


@pytest.mark.parametrize(
    ("folder", "said"),
    [
        ("taken", "already exists; pass --force to replace it"),
        ("mine", "report must be a folder, got 'mine'"),
        ("page.html", "report must be a folder, got 'page.html'"),
        ("nowhere/report", "report must be in a folder that exists"),
    ],
)
def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_computed(
    program: Program, monkeypatch: pytest.MonkeyPatch, folder: str, said: str
):
    Path("taken").mkdir()
    Path("taken/report.pdf").touch()
    Path("mine").touch()
    monkeypatch.setattr("rotor_ida.simulate", lambda *_, **__: pytest.fail("it was computed"))
    answer = program("simulate", *DISC.split(), "--duration", 1, "--report", folder)
    assert (answer.status, answer.out) == (2, "")
    assert said in answer.err


def test_all_numbers_of_the_parts_of_a_system_are_told():
    """Each has another size, so that none can stand in for another."""
    system = rotor_ida.RotorSystem(
        mass=3.0 * np.eye(4), stiffness=np.eye(4), nodes={"disc": (0, 1), "seal": (2, 3)},
        contacts=[
            Contact(node="disc", clearance=101e-6, stiffness=2e9, damping=1.02, friction=0.103,
                    radius=0.104, centre=(5e-6, 0.0), race=Race(radius=0.105, inertia=1.06e-4)),
            Contact(node="seal", clearance=107e-6, stiffness=3e7, exponent=1.0,
                    stator=Stator(mass=1.08, stiffness=(1.09e6, 1.1e6), damping=111.0)),
        ],
        supports=[Support(node="disc", stiffness=(1.12e6, 1.13e6), damping=114.0)],
        unbalance=[Unbalance(node="seal", moment=1.15e-4, phase=np.pi / 3)],
        gravity=(0.0, -9.16),
    )  # fmt: skip
    said = " ".join(" ".join(map(str, row)) for sheet in sheets_of_rotor(system, 117.0)
                    for row in sheet.cells())  # fmt: skip
    for number in ("101", "2e+09", "1.02", "0.103", "104", "5", "105", "0.000106", "107", "30",
                   "1.08", "1.09 1.1", "111", "1.12", "1.13", "115", "60", "-9.16",
                   "6 kg"):  # fmt: skip
        assert number in said, number
    assert "N/m^1.5" in said
    assert "exponent" not in said


def test_a_page_of_a_run_up_is_titled_so_and_tells_the_weight(program: Program):
    weighed = program("machine", *PUMP, "--load", "weight", "--out", "weighed.toml")
    assert weighed.status == 0
    up = "run-up --machine weighed.toml --to 600rpm --in 1s --report report"
    answer = program(*up.split())
    assert (answer.status, answer.err) == (0, "")
    page = html.unescape(Path("report/report.html").read_text("utf-8"))
    assert "<h1>Run-up</h1>" in page
    down = up.replace("--to 600rpm", "--from 600rpm --to 0rpm")
    program(*down.split(), "--force")
    assert "<h1>Run-down</h1>" in html.unescape(Path("report/report.html").read_text("utf-8"))
    told = " ".join(answer.out.split()).partition("Given: mass 12 kg, ")[2]
    assert ", load 117.7 N, " in told


def test_a_page_of_a_fit_names_the_record_and_its_speeds(program: Program):
    """Without --speed the page has the speeds of the record, from 2000 to 3000 rpm."""
    machine = ("--mass", "12kg", "--shaft-stiffness", "4e6N/m", "--damping", "416Ns/m",
               "--eccentricity", "17um", "--clearance", "400um", "--contact-stiffness", "1e8N/m",
               "--contact-exponent", 1)  # fmt: skip
    up = program("run-up", *machine, "--speed", "2000rpm", "--to", "3000rpm", "--in", "1s",
                 "--samples", 8000, "--out", "up.nc")  # fmt: skip
    assert up.status == 0
    answer = program("fit", "up.nc", *machine, "--unknown", "eccentricity", "--report", "report")
    assert (answer.status, answer.err) == (0, "")
    page = html.unescape(Path("report/report.html").read_text("utf-8"))
    assert "<p>up.nc, computed with " in page
    low, high = (
        int(each.replace(",", "")) for each in re.findall("[0-9,]+(?= rpm)",
                                                          rows_of(page)["speed of the record"])
    )  # fmt: skip
    assert 2000 <= low < 2030
    assert 2970 < high <= 3000
    assert "running speed" not in page
