"""The types of the package are there for the programs that use it."""

import tomllib
from pathlib import Path

import rotor_ida

PROGRAM = Path(__file__).with_name("program_of_a_user.py")


def test_a_program_of_a_user_is_among_what_mypy_reads():
    """mypy, a check of its own, finds in it what is wrong and nothing else."""
    root = PROGRAM.parents[1]
    settings = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["tool"]["mypy"]
    assert PROGRAM.relative_to(root).as_posix() in settings["files"]
    assert settings["strict"]
    assert (Path(rotor_ida.__file__).parent / "py.typed").is_file()
