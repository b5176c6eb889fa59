"""Odd names in every kind of place: refused where they enter, or shown as they are."""

import io
import json
import os
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from unicodedata import category
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida import (
    Contact,
    Rotor,
    RotorSystem,
    drop,
    drop_ensemble,
    limit_cycle,
    load,
    load_system,
    save,
    simulate,
)
from rotor_ida.cli import main
from rotor_ida.cli.report import Report, console_on, text_of
from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.explorer.files import again_of, finished, recording
from rotor_ida.explorer.messages import Question
from rotor_ida.plot import (
    figure_of,
    plot_forces,
    plot_node_orbits,
    plot_run,
    plot_shape,
    save_figure,
    save_orbit_film,
)
from rotor_ida.plot.appearance import panels
from rotor_ida.results.sheets import facts, table
from rotor_ida.texts import (
    LONGEST_NAME,
    LONGEST_NOTE,
    brief,
    in_figure,
    in_page,
    in_shell,
    printable,
    unfit,
)

SCRIPT = "</script><script>alert(1)</script>\\"
NAMES = [
    SCRIPT, r"_$\frac{1}{$", "back\\slash", '"quo\'ted"', "%s {} {0} %(x)d", "<!-- & ]]>",
    "$(touch x); `id` | > y", "[/b]:smile:[red]", "--out", "😀 pump 👩\u200d🔧",
    "e\u0301\u0323 n\u0303", "\u05de\u05e1\u05d1", "軸受", "=1+1", "x" * LONGEST_NAME, " ", "0",
]  # fmt: skip
REFUSED = [
    "a\0b", "a\x1b[31mb", "a\nb", "a\x7f", "a\x9b31m", "a\u2028b", "a\u202eb", "a\u2066b",
    "a\ud800b", "a\udcffb", "a\uffffb", "x" * (LONGEST_NAME + 1), "x" * 100_000, "",
]  # fmt: skip
ANY = [*NAMES, *REFUSED]
# Names of contacts in whole systems, whose figures have a panel for each.
AT_CONTACTS = NAMES[:2]


class Scripts(HTMLParser):
    """The script elements of a page, as a browser separates them."""

    def __init__(self, page):
        super().__init__()
        self.found, self.policies, self._text = [], [], None
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        if tag == "script":
            self.found.append([dict(attrs), ""])
            self._text = self.found[-1]
        elif dict(attrs).get("http-equiv") == "Content-Security-Policy":
            self.policies.append(dict(attrs)["content"])

    def handle_data(self, data):
        if self._text is not None:
            self._text[1] += data

    def handle_endtag(self, tag):
        if tag == "script":
            self._text = None


def system(nodes):
    pairs_of = {name: (2 * place, 2 * place + 1) for place, name in enumerate(nodes)}
    return RotorSystem(mass=np.eye(2 * len(nodes)), stiffness=np.eye(2 * len(nodes)),
                       nodes=pairs_of)  # fmt: skip


def obeyed(text):
    """Return the characters of a text that a terminal would obey."""
    return [each for each in text if category(each) in {"Cc", "Cs"} and each not in "\n\t"]


@pytest.mark.parametrize("name", REFUSED, ids=lambda name: ascii(name[:12]))
def test_what_no_name_may_have_is_refused_in_one_line(name):
    with pytest.raises(InputError, match=r"^names of nodes must [^\n]{,400}$") as told:
        system(["disc", name])
    assert obeyed(str(told.value)) == []
    with pytest.raises(InputError, match="note must have"):
        RotorSystem(mass=np.eye(2), stiffness=np.eye(2), note=f"a\x1bb{name}" * LONGEST_NOTE)


def test_other_names_are_kept_in_system_files_and_archives(tmp_path):
    nodes = ", ".join(f"{json.dumps(name, ensure_ascii=False)} = [{2 * place}, {2 * place + 1}]"
                      for place, name in enumerate(NAMES))  # fmt: skip
    numbers = [1.0] * (2 * len(NAMES))
    path = tmp_path / "odd.toml"
    matrices = f"mass = {numbers}, stiffness = {numbers}"
    path.write_text(f"system = {{ {matrices}, nodes = {{ {nodes} }} }}")
    assert list(load_system(path).nodes) == list(system(NAMES).nodes) == NAMES


def test_a_message_of_a_file_is_one_line_without_control_characters(tmp_path):
    path = tmp_path / "e\x1b[2Jvil\n.toml"
    path.write_text('system = { mass = [1, 1], stiffness = [1, 1], nodes = { d = [0, 1] }, '
                    'positions = { "a\\u001b]0;" = "x" } }')  # fmt: skip
    with pytest.raises(InputError, match=r"system\.positions\.a\\x1b\]0;") as told:
        load_system(path)
    assert obeyed(str(told.value)) == []
    bad = tmp_path / "e\x1bvil.nc"
    bad.write_bytes(b"none")
    with pytest.raises(ArchiveError) as told:
        load(bad)
    assert obeyed(str(told.value)) == []


@given(st.one_of(st.text(), st.sampled_from(ANY)))
def test_in_a_page_a_text_is_data(text):
    (only,) = Scripts(f'<script type="application/json">{in_page({text: [text]})}</script>').found
    assert json.loads(only[1]) == {text: [text]}


@given(st.one_of(st.text(), st.sampled_from(ANY)))
def test_on_a_terminal_a_text_does_nothing(text):
    assert obeyed(printable(text)) == []
    assert unfit(brief(text)) == ""
    assert len(brief(text)) <= LONGEST_NAME + 1
    if not unfit(text, "\n\t"):
        assert printable(text) == text


@pytest.mark.skipif(not shutil.which("bash"), reason="there is no bash")
def test_in_a_shell_a_word_is_one_argument():
    words = [each for each in ANY if "\0" not in each and "\ud800" not in each]
    line = " ".join(["printf", "'%s\\0'", *map(in_shell, words)])
    assert obeyed(line) == []
    done = subprocess.run(["bash", "-c", line], capture_output=True, check=True)
    assert done.stdout.split(b"\0")[:-1] == [*map(os.fsencode, words)]
    assert in_shell(Path("-x.toml")) == os.path.join(".", "-x.toml")


def test_in_a_figure_a_text_is_no_mathematics_and_the_file_is_valid(tmp_path):
    figure, (ax,) = panels(1, 1)
    for place, name in enumerate(ANY):
        ax.plot([place], label=in_figure(name))
        ax.text(0, place, f"contact 0 at {in_figure(name)}, $t = 3$ s")
    ax.set_xticks(range(len(ANY)), map(in_figure, ANY))
    assert len(ax.get_legend_handles_labels()[1]) == len([name for name in ANY if name])
    files = save_figure(figure, tmp_path / "odd", formats=["svg", "pdf"])
    ElementTree.parse(files[0])


def test_in_tables_names_are_words_without_markup(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    console = console_on(io.StringIO())
    parts = [f"at {ANY[0]}", facts("\x1bPairs", {each: each for each in ANY}),
             table("\x1bTable", [{each: each for each in ANY}], ANY)]  # fmt: skip
    told = text_of(Report(record={}, parts=parts), console)
    assert obeyed(told) == []
    for name in NAMES:
        assert told.count(name.strip()) >= 2


FILE = """speed = "4800 rpm"
[system]
mass = {masses}
stiffness = {stiffness}
damping = {damping}
nodes = {{ {nodes} }}
"""
CONTACT = """[[contacts]]
node = {node}
clearance = "{clearance} um"
stiffness = "2e8 N/m"
damping = "1 s/m"
[[unbalance]]
node = {node}
moment = "800 g mm"
"""
SUPPORT = """[[supports]]
node = {node}
stiffness = "2e7 N/m"
damping = "2e3 N s/m"
"""
SMALL = """speed = "2000 rpm"
system = { mass = [4, 4], stiffness = [1e5, 1e5], damping = [80, 80], nodes = { disc = [0, 1] } }
contacts = [ { node = "disc", clearance = "60 um", stiffness = "1e7 N/m" } ]
unbalance = [ { node = "disc", moment = "100 g mm" } ]
"""


def file_of(path, stiffness, more="", names=NAMES):
    """Write a system file whose nodes have odd names."""
    quoted = [json.dumps(each, ensure_ascii=False) for each in names]
    nodes = ", ".join(f"{each} = [{2 * n}, {2 * n + 1}]" for n, each in enumerate(quoted))
    count = 2 * len(names)
    text = FILE.format(masses=[20.0] * count, stiffness=[stiffness] * count,
                       damping=[4e3] * count, nodes=nodes)  # fmt: skip
    for number, node in enumerate(quoted[: len(AT_CONTACTS)]):
        text += CONTACT.format(node=node, clearance=50 + 3 * number)
    path.write_text(text + "".join(more.format(node=node) for node in quoted))


@pytest.fixture(autouse=True)
def _rough_pictures(monkeypatch):
    """Figures of few dots, laid out once."""
    monkeypatch.setattr("rotor_ida.plot.saving._DOTS_PER_INCH", 30)
    monkeypatch.setattr("rotor_ida.plot.appearance.MOST_PASSES", 1)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr("rotor_ida.cli.pages.RESOLUTION", 30)
    return tmp_path


def told_by(capfd, *words):
    """Return what a command prints, which must be all right."""
    assert main(list(words)) == 0
    shown = capfd.readouterr()
    assert obeyed(shown.out + shown.err) == []
    assert "Warning" not in shown.err
    return shown.out


def test_every_command_of_a_system_shows_odd_names(folder, capfd):
    file_of(folder / "odd.toml", 1e7, names=NAMES[:4])
    end, shown = ["--figure", "fig", "--force"], {}
    for words in (
        ["simulate", "--duration", "5ms", "--out", "run.nc", "--csv", "run.csv"],
        ["sweep", "--speed", "4800rpm", "--out", "sweep.nc"],
        ["special-speeds", "--limits", "4000rpm", "4800rpm", "--points", "4", "--without-gravity"],
        ["clearance-report", "--speed", "4000rpm", "4800rpm", "5200rpm", "--without-gravity"],
        ["campbell", "--speed", "0", "4800rpm", "--modes", "2"],
    ):
        command, *options = words
        told = told_by(capfd, command, "odd.toml", *options, *end)
        ElementTree.parse("fig.svg")
        shown[command] = told
    shown["show"] = told_by(capfd, "show", "run.nc")
    for command in ("simulate", "show", "clearance-report"):
        assert all(name in shown[command] for name in AT_CONTACTS), command
    assert load("run.nc")["node"].values.tolist() == NAMES[:4]
    told_by(capfd, "verify", "run.nc")
    told_by(capfd, "plot", "run.nc", "--kind", "orbit", "--node", NAMES[1], *end)
    assert main(["plot", "run.nc", "--kind", "orbit", "--node", "\x1b[31m", *end]) == 2
    assert obeyed(capfd.readouterr().err) == []


@pytest.fixture(scope="module")
def results():
    """Return results of a small system by the functions that draw them."""
    system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    run = simulate(system, speed=2.0, duration=20.0)
    bearing = Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0)
    rotor = RotorSystem(mass=20.0 * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)},
                        contacts=[bearing])  # fmt: skip
    one = {"speed": 500.0, "duration": 0.02}
    given = one | {"workers": 1}
    drops = drop_ensemble(rotor, **given, drops=2)
    return [
        (plot_node_orbits, run), (plot_shape, run), (plot_run, run),
        (figure_of, drop(rotor, **one)),
        (lambda run: plot_forces(run).figure, run), (figure_of, drops),
        (figure_of, limit_cycle(system, speed=2.0)),
    ]  # fmt: skip


def renamed(result, name):
    """Return a result whose nodes have another name."""
    return result.assign(
        {each: (result[each].dims, np.full(result[each].shape, name, dtype=object))
         for each in ("node", "contact_node") if each in result.variables}
    )  # fmt: skip


def test_figures_of_altered_results_are_drawn(results, tmp_path):
    name = "_$\\frac{1}{$\x1b[31m\0b\udcff"
    for number, (draw, result) in enumerate(results):
        path, *_ = save_figure(
            draw(renamed(result, name)), tmp_path / f"fig{number}", formats="svg"
        )
        ElementTree.parse(path)
    save_orbit_film(renamed(results[0][1], name), tmp_path / "film.gif", frames=2)


def test_the_report_of_a_drop_shows_odd_names(folder, capfd):
    place = folder / "my $x$ <i>\x1b.toml"
    file_of(place, 0.0, SUPPORT)
    told = told_by(capfd, "drop", place.name, "--report", "report", "--duration", "4ms")
    assert all(name in told for name in AT_CONTACTS)
    page = Path("report/report.html").read_text("utf-8")
    assert Scripts(page).found == []
    assert obeyed(page) == []
    assert "&lt;/script&gt;&lt;script&gt;alert(1)" in page
    assert r"_$\frac{1}{$" in page
    assert Path("report/report.pdf").read_bytes().startswith(b"%PDF")


def test_the_page_of_a_system_holds_odd_names_and_no_script_of_others(folder):
    file_of(folder / "odd.toml", 1e7)
    asked = Question(about="html", number=0, path=folder / "odd.toml", revolutions=2)
    found = Scripts(finished(recording(asked)))
    data = {each["id"]: text for each, text in found.found if "id" in each}
    assert json.loads(data["recorded"])["places"] == NAMES
    (policy,) = found.policies
    assert "unsafe" not in policy
    run = [each for each, _ in found.found if each["type"] != "application/json"]
    (nonce,) = {each["nonce"] for each in run}
    assert f"script-src 'nonce-{nonce}';" in policy
    assert all(nonce not in text for text in data.values())


@pytest.mark.parametrize(
    "name", ['x"); import os; os.mkdir("ran"); ("', "$(mkdir ran); mkdir ran", "-my\n mkdir ran\n#"]
)
def test_lines_of_the_explorer_name_their_file_and_run_nothing_else(folder, name):
    place = folder / f"{name}.toml"
    place.write_text(SMALL)
    asked = Question(about="motion", number=0, path=place, revolutions=1,
                           changes=(("clearance", 4e-5),))  # fmt: skip
    lines: dict[str, object] = {}
    exec(again_of(replace(asked, about="py")), lines)
    assert "run" in lines
    first, command = again_of(replace(asked, about="sh")).splitlines()
    assert first.startswith("# first, in ")
    if shutil.which("bash"):
        shell = f"rotor-ida() {{ printf '%s\\0' \"$@\"; }}\n{command}"
        done = subprocess.run(["bash", "-c", shell], capture_output=True, check=True)
        assert done.stdout.split(b"\0")[1].decode().removeprefix("./") == place.name
    assert not Path("ran").exists()
    save(lines["run"], folder / f"{name}.nc")
    again = Question(about="motion", number=0, path=folder / f"{name}.nc")
    exec(again_of(replace(again, about="py")), lines)
    assert again_of(replace(again, about="sh")).startswith("rotor-ida show ")
    assert not Path("ran").exists()
