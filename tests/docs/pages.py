"""The scripts of the tutorials, and the commands on a page."""

import re
import runpy
import shlex
from pathlib import Path

import matplotlib as mpl

from rotor_ida.cli.program import main
from rotor_ida.plot.appearance import SettledLayout

SCRIPTS = Path(__file__).parents[2] / "docs" / "tutorial_scripts"


def text_of(script):
    return (SCRIPTS / f"{script}.py").read_text("utf-8")


def names_of(script):
    """Return the names that a tutorial has at its end, run in the current folder."""
    with mpl.rc_context():
        return runpy.run_path(str(SCRIPTS / f"{script}.py"))


def commands(page):
    """Return the words of each command on a page."""
    lines = [line.removeprefix("#").strip() for line in page.splitlines()]
    text = re.sub(r"\\\n", " ", "\n".join(lines))
    return [shlex.split(line)[1:] for line in text.splitlines() if line.startswith("rotor-ida ")]


def said_by(words_of_commands, monkeypatch, capsys):
    """Return what commands print, run one after the other in one process.

    Figures are drawn without their layout, which takes most of the time and is tested with them.
    """
    monkeypatch.setattr(SettledLayout, "execute", lambda *_: None)
    said = []
    for words in words_of_commands:
        assert main(words) == 0
        said.append(" ".join(capsys.readouterr().out.split()))
    return said
