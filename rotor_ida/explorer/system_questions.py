"""Check the questions of the page of a rotor system."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, cast, get_args

from rotor_ida.checks import check_choice, check_count, check_nonnegative, shown
from rotor_ida.errors import InputError

SystemAbout = Literal[
    "system_run", "system_map", "system_run_up",
    "system_nc", "system_png", "system_svg", "system_py", "system_html",
]  # fmt: skip
ABOUTS: tuple[SystemAbout, ...] = get_args(SystemAbout)
# Files of the run shown: the archive, two figures, the lines of Python, and the page.
SYSTEM_FILES = ABOUTS[3:]
# What a slider may change: of the chosen contact, and of all unbalance.
OF_CONTACT = ("clearance", "stiffness", "damping", "friction")
CHANGES = (*OF_CONTACT, "unbalance_factor")
ENDINGS = (".toml", ".nc")
# Kinds of results that are played.
SYSTEM_RUNS = ("system_run", "drop")
MOST_REVOLUTIONS = 2000
MOST_CONTACTS = 1000
LARGEST_SYSTEM_FILE = 2**28
LARGEST_NUMBER = 2**53
LONGEST_NAME = 255


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemQuestion:
    """A checked question about a rotor system.

    Parameters
    ----------
    about : str
        The panels to fill, or the file to write.
    number : int
        Number of the question, repeated in its answers.
    node : str
        Node whose spectrum and response are shown; empty for the first one.
    contact : int
        Number of the contact that `changes` are of.
    speed : float, optional
        Running speed; default: that of the file.
    revolutions : int
        Length of the run.
    changes : tuple of (str, float)
        Values in place of the file's, by the names of `CHANGES`.
    path : Path, optional
        Path of the file, set by the server.
    """

    about: SystemAbout
    number: int
    node: str = ""
    contact: int = 0
    speed: float | None = None
    revolutions: int = 60
    changes: tuple[tuple[str, float], ...] = ()
    path: Path | None = None
    side: ClassVar[int] = 0

    @property
    def ticket(self) -> dict[str, object]:
        """Data repeated in its answers, by which the page identifies the question."""
        return {"about": self.about, "number": self.number, "side": self.side}


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemUpload:
    """A system file or an archive that the page sends.

    Parameters
    ----------
    number : int
        Number of the question, repeated in its answer.
    name : str
        Name of the file on the page.
    size : int
        Number of bytes of the file.
    path : Path, optional
        Path of the file, set by the server.
    """

    number: int
    name: str
    size: int
    path: Path | None = None
    about: ClassVar[Literal["system_file"]] = "system_file"
    side: ClassVar[int] = 0

    @property
    def ending(self) -> str:
        """The ending that decides how it is read."""
        return Path(self.name).suffix.lower()

    @property
    def ticket(self) -> dict[str, object]:
        """Data repeated in its answer, by which the page identifies the question."""
        return {"about": self.about, "number": self.number, "side": self.side}


def system_question(given: Mapping[str, Any]) -> SystemQuestion:
    """Return a checked question about a system, or raise `InputError`.

    Examples
    --------
    >>> system_question({"about": "system_run", "number": 1, "node": "disc", "contact": 0,
    ...     "speed": 450.0, "revolutions": 60, "changes": {"friction": 0.2}}).changes
    (('friction', 0.2),)
    """
    _check_entries(given, ("about", "number", "node", "contact", "speed", "revolutions", "changes"))
    node, changes = given["node"], given["changes"]
    if not isinstance(node, str) or len(node) > LONGEST_NAME:
        raise InputError(f"node must be the name of a node, got {shown(node)}")
    if not isinstance(changes, Mapping) or not set(changes) <= set(CHANGES):
        raise InputError(f"changes must be numbers by {', '.join(CHANGES)}, got {shown(changes)}")
    speed = given["speed"]
    return SystemQuestion(
        about=cast(SystemAbout, check_choice("about", given["about"], ABOUTS)),
        number=check_count("number", given["number"], 0, LARGEST_NUMBER),
        node=node,
        contact=check_count("contact", given["contact"], 0, MOST_CONTACTS),
        speed=None if speed is None else check_nonnegative("speed", speed),
        revolutions=check_count("revolutions", given["revolutions"], 1, MOST_REVOLUTIONS),
        changes=tuple((name, check_nonnegative(name, changes[name])) for name in sorted(changes)),
    )


def system_upload(given: Mapping[str, Any]) -> SystemUpload:
    """Return a checked announcement of a file, or raise `InputError`."""
    _check_entries(given, ("about", "number", "name", "size"))
    name = given["name"]
    if not isinstance(name, str) or len(name) > LONGEST_NAME:
        raise InputError(f"name must be the name of a file, got {shown(name)}")
    found = SystemUpload(
        number=check_count("number", given["number"], 0, LARGEST_NUMBER),
        name=name,
        size=check_count("size", given["size"], 1, LARGEST_SYSTEM_FILE),
    )
    check_choice("ending of the file", found.ending, ENDINGS)
    return found


READERS: dict[str, Callable[[Mapping[str, Any]], SystemQuestion | SystemUpload]] = {
    SystemUpload.about: system_upload, **dict.fromkeys(ABOUTS, system_question),
}  # fmt: skip


def _check_entries(given: Mapping[str, Any], names: tuple[str, ...]) -> None:
    """Raise `InputError` unless a question has these entries and no others."""
    if set(given) != set(names):
        raise InputError(f"a question must have {', '.join(names)}, got {shown(sorted(given))}")
