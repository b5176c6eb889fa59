"""The command drop: a report with archives beside it, and bad input in one line."""

from pathlib import Path

import pytest

import rotor_ida
from rotor_ida.cli import main
from rotor_ida.cli.drop_report import COLUMNS, Listed, _lines

FILE = """# drawn in the report
speed = "4800 rpm"
system = { mass = [20, 20], stiffness = [0, 0], nodes = { disc = [0, 1] } }
supports = [ { node = "disc", stiffness = "2e6 N/m", damping = "2e3 N s/m" } ]
unbalance = [ { node = "disc", moment = "80 g mm" } ]
[[contacts]]
node = "disc"
clearance = "0.2 mm"
stiffness = "2e9 N/m^1.5"
damping = "1 s/m"
friction = 0.1
radius = "30 mm"
[drop]
duration = "40 ms"
inertia = 0.08
phase = "90 deg"
clearances = { disc = "0.5 mm" }
[drop.vary]
friction = [0.05, 0.2]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rotor.toml").write_text(FILE)


@pytest.mark.usefixtures("here")
def test_a_report_holds_pages_and_archives_that_the_file_alone_gives(capfd):
    words = ["drop", "rotor.toml", "--out", "report", "--drops", "3", "--executor", "serial"]
    assert main([*words, "--duration", "30ms"]) == 0
    assert "Bearings" in capfd.readouterr().out
    files = {each.name for each in Path("report").iterdir()}
    assert files == {"drop.nc", "drops.nc", "report.html", "report.pdf"}
    page = Path("report/report.html").read_text("utf-8")
    assert page.count("data:image/png;base64,") == 3
    assert "http" not in page
    assert "rotor-ida drop rotor.toml --out report --duration 0.03 --drops 3" in page
    assert "# drawn in the report" in page
    for head in ("largest force [kN]", "largest race speed [rpm]", "clearance [µm]", "rest_time"):
        assert (head in page) == (head != "rest_time")
    assert "largest force [kN]</td><td>1.616" in page
    assert "speed at the drop [rpm]</td><td>4800" in page
    assert "<td>python</td>" in page
    assert Path("report/report.pdf").read_bytes().startswith(b"%PDF")
    case = rotor_ida.load_system("rotor.toml")
    run = rotor_ida.drop(case.system, **{**case.drop, "duration": 0.03})
    assert rotor_ida.load("report/drop.nc").equals(run)
    many = rotor_ida.load("report/drops.nc")
    assert many.sizes["drop"] == 3
    assert ((many.drop_friction >= 0.05) & (many.drop_friction <= 0.2)).all()
    assert main(["verify", "report/drop.nc"]) == 0
    assert main(["show", "report/drops.nc"]) == 0
    assert "95 % interval" in capfd.readouterr().out
    assert main(words) == 2
    assert "--force" in capfd.readouterr().err


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (("duration = ", "# "), [], "duration must be given"),
        (("[drop.vary]", "[drop.varied]"), [], "did you mean"),
        (("supports = [", "supports = [ {}, "), [], "supports[0].node"),
        (("0.2 mm", "0.1 um"), [], "bearings must be clear of the levitated rotor"),
        (("inertia = 0.08", "drag = 1"), [], "inertia must be given with drag"),
        (("", ""), ["--study", "many"], "study must be left out without drops"),
        (("", ""), ["--film", "drop.avi"], "must end in .gif or .mp4"),
    ],
)
def test_bad_input_is_one_line_and_status_2(change, options, words, capfd):
    Path("rotor.toml").write_text(FILE.replace(*change) if change[0] else FILE)
    assert main(["drop", "rotor.toml", "--out", "report", *options]) == 2
    said = capfd.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_a_table_wider_than_a_page_of_the_pdf_is_split_between_columns():
    heads, cell = ["", *(f"bearing {number}" for number in range(30))], "1234.5 (12 to 13)"
    lines = _lines(Listed("Wide", heads, [["force", *[cell] * 30]]))
    assert max(map(len, lines)) <= COLUMNS
    assert sum(line.count(cell) for line in lines) == 30
    assert sum(line.startswith("force") for line in lines) > 1
