"""The command drop: a report with archives beside it, and bad input in one line."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rotor_ida
from rotor_ida import Contact, RotorSystem
from rotor_ida.cli import main
from rotor_ida.cli.commands.drop import NOT_OF_MANY
from rotor_ida.cli.describe import describe
from rotor_ida.cli.drop_tables import acceptance
from rotor_ida.cli.pdf import page_of, write_pdf
from rotor_ida.explorer.system_verdicts import verdict
from rotor_ida.results.sheets import Line, Sheet, facts
from rotor_ida.results.studies.store import Study
from rotor_ida.steady.drop_words import sentence_of

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
capacities = { disc = "4 kN" }
[drop.vary]
friction = [0.05, 0.2]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rotor.toml").write_text(FILE)


@pytest.mark.usefixtures("here")
def test_a_report_holds_pages_and_archives_that_the_file_alone_gives(capfd, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr("rotor_ida.cli.pages.write_pdf", write_pdf)
    words = ["drop", "rotor.toml", "--report", "report", "--drops", "3", "--executor", "serial"]
    assert main([*words, "--duration", "30ms"]) == 0
    told = capfd.readouterr().out
    assert "One drop: each bearing" in told
    assert "Of 3 drops the largest force is" in told
    files = {each.name for each in Path("report").iterdir()}
    assert files == {"drop.nc", "result.nc", "report.html", "report.pdf"}
    page = Path("report/report.html").read_text("utf-8")
    assert page.count("data:image/png;base64,") == 3
    assert "http" not in page
    assert "rotor-ida drop rotor.toml --report report --drops 3" in page
    assert "# drawn in the report" in page
    for head in ("largest force [kN]", "largest race speed [rpm]", "clearance [µm]", "rest_time"):
        assert (head in page) == (head != "rest_time")
    assert "largest force [kN]</td><td>1.616" in page
    assert "force in the bearing at disc</td><td>4 kN</td><td>1.616 kN (40.4 %)" in page
    assert "gap left" in page
    assert "no statement of conformity" in page
    assert "speed at the drop</td><td>4800</td><td>rpm" in page
    assert "<td>python</td>" in page
    assert Path("report/report.pdf").read_bytes().startswith(b"%PDF")
    run = dropped("rotor.toml", {"duration": 0.03})
    assert rotor_ida.load("report/drop.nc").equals(run)
    version = run.attrs["rotor_ida_version"]
    assert f"rotor.toml, computed with rotor_ida {version}, report of 20" in page
    many = rotor_ida.load("report/result.nc")
    assert many.sizes["drop"] == 3
    assert ((many.drop_friction >= 0.05) & (many.drop_friction <= 0.2)).all()
    assert main(["verify", "report/drop.nc"]) == 0
    assert main(["verify", "report/result.nc"]) == 0
    assert main(["show", "report/result.nc"]) == 0
    shown = capfd.readouterr().out
    assert "95 % interval" in shown
    assert "3 drops: bearing at disc" in shown
    for each in (page, shown):  # the same words in both
        assert "in contact to the end from, in 0 of 3 drops [ms]" in each
        assert "whose largest force comes before the horizon" in each
    assert "below 1 % of the speed at the drop (48 rpm) from" in page
    assert main(words) == 2
    assert "--force" in capfd.readouterr().err


# Interrupted as the third drop is about to be saved, or once the archive of all has been written.
@pytest.mark.parametrize(("moment", "done"), [("computing", 2), ("writing", 4)])
@pytest.mark.usefixtures("here")
def test_an_interrupted_drop_continues_by_the_same_command(moment, done, capfd, monkeypatch):
    words = ["drop", "rotor.toml", "--report", "report", "--drops", "4", "--executor", "serial",
             "--duration", "10ms"]  # fmt: skip
    kept, keep, save = [], Study.keep, rotor_ida.save

    def counted(study, piece):
        kept.append(piece)
        if len(kept) == 3:
            raise KeyboardInterrupt
        keep(study, piece)

    def ended(*given, **named):
        save(*given, **named)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        if moment == "computing":
            patch.setattr(Study, "keep", counted)
        else:
            patch.setattr(rotor_ida, "save", ended)
        assert main(words) == 130
    assert rotor_ida.status("report/unfinished")["done"] == done
    capfd.readouterr()
    assert main(words) == 0
    assert f"continued: {done} of 4 drops were saved in report/unfinished" in capfd.readouterr().out
    files = {each.name for each in Path("report").iterdir()}
    assert files == {"drop.nc", "result.nc", "report.html", "report.pdf"}
    course = rotor_ida.load_course("rotor.toml").drop | {"duration": 0.01}
    given = {"system": rotor_ida.load_system("rotor.toml"), **course}
    assert rotor_ida.load("report/result.nc").equals(many_drops(given, (0.05, 0.2), 4))


@pytest.mark.usefixtures("here")
def test_a_drop_that_ends_before_a_touch_has_a_report_too(capfd):
    text = FILE.replace("[drop.vary]\nfriction", "[drop.grid]\nphase")
    Path("rotor.toml").write_text(text.replace('"40 ms"', '"2 ms"'))
    assert main(["drop", "rotor.toml", "--report", "report", "--executor", "serial"]) == 0
    assert "In this drop the rotor touches no bearing." in capfd.readouterr().out
    page = Path("report/report.html").read_text("utf-8")
    assert "first touch</td><td>none" in page


def dropped(file, change):
    """Return the drop of a file from Python, with some of its arguments changed."""
    system, course = rotor_ida.load_system(file), rotor_ida.load_course(file)
    return rotor_ida.drop(system, **{**course.drop, **change})


def many_drops(given, friction, drops=2):
    """Return drops with the arguments of one, at random."""
    of_many = {name: each for name, each in given.items() if name not in NOT_OF_MANY}
    return rotor_ida.drop_ensemble(**of_many, drops=drops, friction=friction, executor="serial")


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(("labyrinth", "touched"), [(0.1e-3, True), (0.9e-3, False)])
def test_the_answer_tells_which_other_clearances_are_touched(labyrinth, touched):
    """The bearing leaves 0.2 mm; the table names the same nodes."""
    nodes = {"disc": (0, 1), "seal": (0, 1), "end": (0, 1)}
    system = replace(rotor_ida.load_system("rotor.toml"), nodes=nodes)
    given = {**rotor_ida.load_course("rotor.toml").drop, "system": system, "duration": 0.02,
             "clearances": {"seal": labyrinth, "end": 0.11e-3, "disc": 5e-3}}  # fmt: skip
    run = rotor_ida.drop(**given)
    many = many_drops(given, (0.05, 0.2))
    where = "clearances at 'seal' and 'end'" if touched else "clearance at 'end'"
    said = sentence_of(run, many)
    # the worst finding comes first
    assert said.startswith(f"The rotor touches the close {where}; a touch there does not act on")
    assert f"Some drops touch the close {where}. Of 2 drops the largest force" in said
    assert "Beyond the model" not in said
    assert verdict(run) == sentence_of(run, None)
    rows = {row[0]: row[2] for row in acceptance(run, many)[0].cells()}
    assert ("touches" in rows["radius at seal"]) == touched
    assert "gap left" in rows["radius at disc"]


@pytest.mark.usefixtures("here")
def test_a_drop_into_a_soft_bearing_is_beyond_the_model():
    """It is pressed in by more than its clearance of 0.2 mm."""
    system, course = (read("rotor.toml") for read in (rotor_ida.load_system, rotor_ida.load_course))
    soft = [replace(each, stiffness=4e6, friction=0.0) for each in system.contacts]
    given = {
        **course.drop,
        "system": replace(system, contacts=soft),
        "clearances": None,
        "duration": 0.03,
    }
    run = rotor_ida.drop(**given)
    deep = 1e3 * float(run.peak_indentation.max())
    assert deep > 0.2
    words = f"Beyond the model: contact 0 at 'disc' is indented by up to {deep:.3g} mm, more than "
    for said in (sentence_of(run, None), verdict(run), describe(run)[1][-1]):
        assert f"{words}the clearance;" in said
    many = many_drops(given, (0.0, 0.1))
    assert describe(many)[1][-1].startswith("Beyond the model: contact 0")
    assert sentence_of(run, many).count("Beyond the model") == 1


@pytest.mark.usefixtures("here")
def test_the_system_file_of_the_tutorial_is_the_machine_of_the_tutorial():
    page = Path(__file__).parents[2] / "docs" / "drop_tutorial.md"
    text = page.read_text("utf-8")
    Path("machine.toml").write_text(text.split("```toml\n")[1].split("```")[0])
    run = dropped("machine.toml", {"duration": 0.02})
    stated = re.search(r"\(array\(\[(\d+)\., (\d+)\.\]\), array\(\[1\.064", text)
    expected = [float(each) for each in stated.groups()]
    np.testing.assert_allclose(run.largest_force, expected, rtol=1.5e-3)  # rounded stiffness


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (("duration = ", "# "), [], "duration must be given"),
        (("[drop.vary]", "[drop.varied]"), [], "did you mean"),
        (("supports = [", "supports = [ {}, "), [], "supports[0].node"),
        (("0.2 mm", "0.1 um"), [], "contacts must be clear of the levitated rotor"),
        (("inertia = 0.08", "drag = 1"), [], "--inertia must be given with --drag"),
        (('"4 kN"', '"4 mm"'), [], "drop.capacities.disc"),
        (('{ disc = "4 kN" }', "{ hub = 1 }"), [], "node in capacities must be one of 'disc'"),
        (("[drop.vary]", "[drop.grid]\nfriction = 1\n[drop.vary]"), [], "must be left out with"),
        (("[drop.vary]\nfriction = [", "[drop.grid]\nfriction = [-1, "), [], "friction must be"),
        (
            ("[drop.vary]\nfriction = [0.05, 0.2]", "[drop.grid]\nfriction = 1"),
            [],
            "drop.grid.friction must be numbers or a table of from, to, count, got 1",
        ),
        (
            ("[drop.vary]\nfriction = [0.05, 0.2]", "[drop.grid]\nfriction = {from=0}"),
            [],
            "drop.grid.friction.to and drop.grid.friction.count must be given",
        ),
        (('{ disc = "0.5 mm"', "{ dics = 1"), [], "got 'dics'; did you mean 'disc'"),
        (("[0.05, 0.2]", "[0.2, 0.05]"), ["--drops", "3"], "friction must be a range of two num"),
        (
            ("# drawn in the report", "start = { q = [0.0, 0.0], velocity = [0.0, 0.0] }"),
            ["--drops", "2"],
            "start must be left out of rotor.toml for many drops",
        ),
        (("", ""), ["--study", "many"], "study must be left out without drops"),
        (("", ""), ["--film", "drop.avi"], "must end in .gif or .mp4"),
    ],
)
def test_bad_input_is_one_line_and_status_2(change, options, words, capfd):
    Path("rotor.toml").write_text(FILE.replace(*change) if change[0] else FILE)
    assert main(["drop", "rotor.toml", "--report", "report", *options]) == 2
    said = capfd.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not Path("report").exists()


@pytest.mark.usefixtures("here")
def test_a_grid_is_told_by_cell_in_the_report_and_on_the_command_line(capfd):
    grid = """[drop.grid]
friction = [0.05, 0.2]
unbalance_factor = { from = 1, to = 2, count = 3 }"""
    text = FILE.replace("[drop.vary]\nfriction = [0.05, 0.2]", grid)
    Path("rotor.toml").write_text(text)
    words = ["drop", "rotor.toml", "--report", "report", "--executor", "serial"]
    assert main(words) == 0
    assert "Over a grid of 6 drops the largest force is" in capfd.readouterr().out
    many = rotor_ida.load("report/result.nc")
    assert (many.drop_phase == np.pi / 2).all()  # that of the file
    assert many.cell_unbalance_factor.values.tolist() == [1.0, 1.5, 2.0] * 2
    page = Path("report/report.html").read_text("utf-8")
    assert "Backward whirl by cell" in page
    assert "<td>0.2</td><td>1.5</td><td>0</td>" in page.replace("<td>0.20", "<td>0.2")
    assert "no sampling error applies" in page
    at = int(many.largest_force_max_drop[0])
    place = f"{float(many.drop_friction[at]):g}, {float(many.drop_unbalance_factor[at]):g}"
    assert f"= {place}. Of the grid" in page
    assert main(["show", "report/result.nc"]) == 0
    told = " ".join(capfd.readouterr().out.split())
    assert "Backward whirl by cell" in told
    assert "Extremes with where they lie: friction coefficient, factor of the unbalance." in told
    assert main([*words, "--force", "--drops", "3"]) == 2
    assert "drops must be left out with the drop.grid" in capfd.readouterr().err


def test_pages_of_the_pdf_hold_all_that_is_written_on_them(tmp_path, monkeypatch):
    pages = []
    monkeypatch.setattr(
        "rotor_ida.cli.pdf.page_of", lambda *given: pages.append(page_of(*given)) or pages[-1]
    )
    cell = "1234.5 (12 to 13)"
    write_pdf(tmp_path / "all.pdf", "foot", [
        "Title", "some words " * 200, "x" * 300,
        Sheet("Wide", [Line("force", [cell] * 30)], [f"bearing {each}" for each in range(30)]),
        facts("Long", {str(number): cell for number in range(150)}),
    ], [])  # fmt: skip
    texts = [each for page in pages for each in page.texts]
    assert sum(each.get_text().count(cell) for each in texts) == 180
    assert sum(each.get_text().startswith("foot, page") for each in texts) == len(pages) > 2
    for each in texts:
        if each.get_text():
            box, page = each.get_window_extent(), each.figure.bbox
            assert page.x0 < box.x0 < box.x1 < page.x1
            assert page.y0 < box.y0 < box.y1 < page.y1


@pytest.mark.usefixtures("here")
def test_bad_input_is_refused_before_a_file_is_written(capfd):
    Path("mine.gif").write_text("mine")
    assert main(["drop", "rotor.toml", "--report", "report", "--film", "mine.gif"]) == 2
    assert "already exists; pass --force to replace it" in capfd.readouterr().err
    assert not Path("report").exists()
    Path("report/unfinished").mkdir(parents=True)  # as an interrupted command leaves it
    Path("other.nc").write_text("mine")
    words = ["drop", "rotor.toml", "--report", "report", "--drops", "2", "--out", "other.nc"]
    assert main(words) == 2
    assert "already exists; pass --force to replace it" in capfd.readouterr().err
    assert Path("other.nc").read_text() == "mine"


def test_a_rotor_that_no_support_lets_fall_is_told_of():
    touch = Contact(node="disc", clearance=1e-4, stiffness=1e8)
    system = RotorSystem(mass=20.0 * np.eye(2), stiffness=1e6 * np.eye(2), nodes={"disc": (0, 1)},
                         contacts=[touch])  # fmt: skip
    run = rotor_ida.drop(system, speed=100.0, duration=1e-3, gravity=(0.0, 0.0), samples=3)
    assert sentence_of(run, None).startswith(
        "The system has no supports that could fail: it does not drop on a bearing."
    )
