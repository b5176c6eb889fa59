"""The scripts of the tutorials, and the commands on a page."""

import re
import runpy
import shlex
from pathlib import Path

import matplotlib as mpl

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
