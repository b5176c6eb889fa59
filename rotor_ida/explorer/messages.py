"""Check the questions of a page, and pack each answer into one binary message."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import (
    COMPONENTS,
    State,
    check_between,
    check_choice,
    check_count,
    check_nonnegative,
    check_note,
    check_real,
    check_state,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import check_keys, implausible, machine_from_data_sheet
from rotor_ida.model.parameters import MACHINE_PARAMETERS, OPTIONAL, PARAMETERS
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.signals.files.columns import ENDINGS
from rotor_ida.simulation.options import LARGEST, check_can_be_followed
from rotor_ida.texts import plain
from rotor_ida.units import SPEED_UNITS

# Files of a run: the archive, two figures, the Python script and the command that reproduce them,
# and the page with its results.
FILES = ("nc", "png", "svg", "py", "sh", "html")
# The panels of a rotor system, and those of one disc.
OF_SYSTEM = ("motion", "lines", "responses", "campbell", "track")
OF_DISC = ("motion", "run_up", *OF_SYSTEM[1:], "starts")
UPLOAD, DATA_SHEET = "upload", "machine"
# Endings of the files of a rotor, and of measured files that are no text.
ROTOR_ENDINGS = (".toml", ".nc")
MEASURED_ENDINGS = tuple(each for format_ in ENDINGS.values() for each in format_)

LARGEST_FILE = 2**28
# What a page may change of a system: the chosen contact, by names of a disc, and all unbalance.
OF_CONTACT = {
    "clearance": "clearance", "contact_stiffness": "stiffness", "contact_damping": "damping",
    "friction": "friction",
}  # fmt: skip
CHANGES = (*OF_CONTACT, "unbalance_factor")

# The range of speeds of a machine, as multiples of its largest one.
ROOM, LEAST_SPEED = 1.5, 1e-3
# Those of a rotor without dimensions [1].
SPEEDS = (0.05, 4.0)
# Whole revolutions of a run that is drawn.
MOST_REVOLUTIONS = 2000
# At most two machines are shown side by side.
SIDES = 2
# Byte alignment of arrays, required by browsers.
ALIGNED = 8
KINDS = {np.dtype(kind): kind for kind in ("f8", "f4", "i1")}


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What every question has.

    Parameters
    ----------
    about : str
        The panels to fill, the file to write, or what the question is.
    number : int
        Number of the question, repeated in its answers.
    side : int
        Number of the rotor, of two side by side.
    path : Path, optional
        Path of the file that it is about, set by the server.
    """

    about: str
    number: int
    side: int = 0
    path: Path | None = None

    @property
    def ticket(self) -> dict[str, object]:
        """Data repeated in its answers, by which the page identifies the question."""
        return {"about": self.about, "number": self.number, "side": self.side}


@dataclass(frozen=True, kw_only=True)
class Question(Asked):
    """A checked question about one disc, or about the rotor in a file.

    It is about one run; a run-up, of a disc one piece of it; the full spectrum of a run; the
    response curve and the settled response; the Campbell diagram; or, of a disc, the basins. Or it
    asks for a file, one of `FILES`.

    Parameters
    ----------
    machine : Rotor or DimensionalRotor, optional
        The disc on the page; without one the question is about the rotor in the file.
    start : tuple of float
        Of a disc: ``(x, y, vx, vy)`` at time 0 [dimensionless]; the page may ask for none, where
        the rotor hangs at rest.
    revolutions : int
        Length of the run; without spin, in units of 2 pi in time.
    speeds : tuple of float
        Of a disc: lowest and highest speed of the response curve [dimensionless].
    reach : float
        Half-width of the plane of starts in x and y [dimensionless].
    to, rate : float, optional
        For a piece of a run-up: the speed at its end, and the rate of change of the speed
        [dimensionless].
    angle : float
        The angle of the unbalance at the beginning of that piece [rad]; `start` is on axes that
        point along the unbalance.
    node : str
        Node whose motion is shown; empty for that of the first contact.
    contact : int
        Number of the contact that is shown, and that `changes` are of.
    speed : float, optional
        Running speed; default: that of the machine or the file.
    changes : tuple of (str, float)
        Values in place of the file's, by the names of `CHANGES`.
    """

    machine: Rotor | DimensionalRotor | None = None
    start: State = (0.0, 0.0, 0.0, 0.0)
    revolutions: int = 60
    speeds: tuple[float, float] = SPEEDS
    reach: float = 1.0
    to: float | None = None
    rate: float | None = None
    angle: float = 0.0
    node: str = ""
    contact: int = 0
    speed: float | None = None
    changes: tuple[tuple[str, float], ...] = ()

    @property
    def disc(self) -> Rotor | DimensionalRotor:
        """The machine of a question that only one disc answers."""
        assert self.machine is not None
        return self.machine

    @property
    def rotor(self) -> Rotor:
        """The disc without dimensions."""
        return self.disc if isinstance(self.disc, Rotor) else self.disc.rotor()

    @property
    def of_contact(self) -> dict[str, float]:
        """The changes of the chosen contact, by the names of a system file."""
        return {OF_CONTACT[name]: value for name, value in self.changes if name in OF_CONTACT}

    @property
    def unbalance_factor(self) -> float:
        """The factor of all unbalance in the file."""
        return dict(self.changes).get("unbalance_factor", 1.0)


@dataclass(frozen=True, kw_only=True)
class Upload(Asked):
    """A file that the page sends: of a rotor system, an archive, or a measurement to analyse.

    Parameters
    ----------
    name : str
        Name of the file on the page.
    size : int
        Number of bytes of the file.
    probe_angles, gains : tuple of float
        Of a measurement, as in `rotor_ida.read_signals`, which checks them.
    columns, units : mapping of str to str
        Choices of the user on the page, as in `rotor_ida.read_signals`.
    reading : mapping
        Further arguments of `rotor_ida.read_signals`, of the file that was given to the server.
    """

    name: str
    size: int
    probe_angles: tuple[float, float] = (0.0, 90.0)
    gains: tuple[float, float] = (1.0, 1.0)
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    reading: Mapping[str, Any] = field(default_factory=dict)

    @property
    def ending(self) -> str:
        """The ending that decides the reader."""
        ending = Path(self.name).suffix.lower()
        return ending if ending in (*ROTOR_ENDINGS, *MEASURED_ENDINGS) else ".csv"


@dataclass(frozen=True, kw_only=True)
class DataSheet(Asked):
    """The data sheet of a machine, as entered in the form of the page.

    Parameters
    ----------
    quantities : dict of str
        Values with units by the names of `machine_from_data_sheet`; none is empty.
    """

    quantities: dict[str, str]

    def machine(self) -> DimensionalRotor:
        """Return the machine, or raise `InputError` for missing or wrong quantities."""
        check_keys(self.quantities, "a data sheet")
        return machine_from_data_sheet(**cast(dict[str, Any], self.quantities))


# Entries of a question about a rotor, and further ones about one disc.
OF_ANY = ("number", "revolutions", "side")
OF_PLANE = ("reach", "speeds")
# Questions about no rotor that is shown, and their entries.
OTHERS: dict[str, tuple[type[Asked], tuple[str, ...]]] = {
    UPLOAD: (Upload, ("number", "name", "size", "columns", "gains", "probe_angles", "units")),
    DATA_SHEET: (DataSheet, ("number", "quantities")),
}


def read_question(text: str) -> Asked:
    """Return a checked question, or raise `InputError`.

    Only the page asks: what no page sends is refused without the reason.

    Examples
    --------
    >>> asked = read_question('{"about": "motion", "number": 1, "side": 0, "start": [0, 0, 0, 0], '
    ...     '"machine": {"omega": 1.7, "zeta": 0.07, "delta0": 0.5}, "revolutions": 60, '
    ...     '"speeds": [0.05, 3], "reach": 8}')
    >>> asked.rotor
    Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> read_question('{"about": "motion", "number": 1, "side": 0, "revolutions": 60, "machine": '
    ...     '{"node": "disc", "contact": 0, "speed": 450, "changes": {"friction": 0.2}}}').changes
    (('friction', 0.2),)
    >>> read_question('{"about": "weather"}')
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: a question must be one of the page, got '{"about": "weather"}'
    """
    try:
        return _read(json.loads(text))
    except InputError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise InputError(f"a question must be one of the page, got {shown(text)}") from None


def _read(given: Mapping[str, Any]) -> Asked:
    """Return a question with the entries that its kind has."""
    about = given["about"]
    if about in OTHERS:
        kind, names = OTHERS[about]
        return kind(about=about, **_entries(given, names))
    in_file = "node" in given["machine"]
    beside = _of_file(given["machine"]) if in_file else _of_disc(given)
    shows = (*(OF_SYSTEM if in_file else OF_DISC), *FILES)
    entries = _entries(given, OF_ANY if in_file else (*OF_ANY, *OF_PLANE))
    return Question(**entries | beside, about=check_choice("about", about, shows))


def _pair(name: str, given: Sequence[Any]) -> tuple[float, float]:
    """Return two numbers; a missing one is NaN, which `read_signals` refuses."""
    one, other = (math.nan if each is None else check_real(name, each) for each in given)
    return one, other


def _speeds(given: Sequence[Any]) -> tuple[float, float]:
    """Return the lowest and the highest speed of a curve."""
    low, high = (check_nonnegative("speeds", each, LARGEST) for each in given)
    if low >= high:
        raise InputError(f"speeds must be two increasing numbers, got {(low, high)}")
    return low, high


# How each entry of a question is checked, where it is the same in all.
CHECKS: dict[str, Callable[[Any], Any]] = {
    "number": lambda given: check_count("number", given, 0),
    "side": lambda given: check_count("side", given, 0, SIDES - 1),
    "revolutions": lambda given: check_count("revolutions", given, 1, MOST_REVOLUTIONS),
    "name": str,
    "size": lambda given: check_count("size", given, 0, LARGEST_FILE),
    "quantities": lambda given: {
        name: each.strip() for name, each in given.items() if each.strip()
    },
    "speeds": _speeds,
    "reach": lambda given: check_between(
        "reach", check_real("reach", given), 1.0 / LARGEST, LARGEST
    ),
    **{each: partial(_pair, each) for each in ("probe_angles", "gains")},
    **dict.fromkeys(
        ("columns", "units"),
        lambda given: {name: check_note(name, each) for name, each in given.items()},
    ),
}


def _entries(given: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Return entries of a question, checked."""
    return {name: CHECKS[name](given[name]) for name in names}


def _of_file(machine: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a page shows and changes of the rotor in a file, checked."""
    changes, speed = machine["changes"], machine["speed"]
    return {
        "node": str(machine["node"]),
        "contact": check_count("contact", machine["contact"], 0),
        "speed": None if speed is None else check_nonnegative("speed", speed),
        "changes": tuple(
            (name, check_nonnegative(name, changes[name])) for name in CHANGES if name in changes
        ),
    }


def show_machine(sheet: DataSheet) -> Iterator[Answer]:
    """Yield the machine of a data sheet, with its warnings."""
    machine = sheet.machine()
    yield Answer("machine", {"state": state_of(machine), "notes": implausible(machine)})


def state_of(
    machine: Rotor | DimensionalRotor, start: State | None = None, revolutions: int | None = None
) -> dict[str, object]:
    """Return the state of the page, as in its address; without a start it hangs at rest.

    Examples
    --------
    >>> state_of(Rotor(omega=2.0, zeta=0.07, delta0=2.0), (0.5, 0.0, 0.0, 0.0), 60)["x"]
    0.5
    """
    told: dict[str, object] = dict(machine.given)
    if start is not None:
        told |= zip(COMPONENTS, start, strict=True)
    if revolutions is not None:
        told["revolutions"] = revolutions
    return told if isinstance(machine, Rotor) else told | {"fastest": largest_speed(machine)}


def largest_speed(machine: DimensionalRotor) -> float:
    """Return the default final speed of a run-up, past the critical speed [rad/s].

    Without a shaft, twice the reference frequency replaces the critical speed.

    Examples
    --------
    >>> machine = DimensionalRotor(
    ...     mass=12.0, contact_stiffness=1e8, damping=416.0, eccentricity=1.7e-5,
    ...     clearance=1.5e-4, speed=377.0, shaft_stiffness=4e6, contact_exponent=1.0)
    >>> largest_speed(machine) * 30 / math.pi
    6000.0
    """
    critical = math.sqrt(machine.shaft_stiffness / machine.mass)
    rpm = max(machine.speed, critical or 2.0 * machine.reference_frequency) / SPEED_UNITS["rpm"]
    step = 10.0 ** math.floor(math.log10(rpm)) / 2.0
    return math.ceil(rpm / step * (1.0 - 1e-9)) * step * SPEED_UNITS["rpm"]


def speeds_shown(machine: Rotor | DimensionalRotor) -> tuple[float, float]:
    """Return the default range of speeds of the response curve [dimensionless]."""
    if isinstance(machine, Rotor):
        return SPEEDS
    top = ROOM * largest_speed(machine) / machine.reference_frequency
    return LEAST_SPEED * top, top


def machine_of(given: object) -> Rotor | DimensionalRotor:
    """Return the machine from a mapping of names to numbers."""
    if isinstance(given, Mapping):
        needed = given.keys() - set(OPTIONAL)
        if needed == set(PARAMETERS):
            return Rotor(**given)
        if needed == set(MACHINE_PARAMETERS):
            return DimensionalRotor(**given)
    raise InputError(
        "machine must have omega, zeta and delta0, or mass, contact_stiffness, damping, "
        "eccentricity, clearance and speed, and may have "
        f"{', '.join(OPTIONAL)}, got {shown(given)}"
    )


def _of_disc(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return machine and start, and of a piece of a run-up its ramp, checked."""
    machine = machine_of(given["machine"])
    rotor = machine if isinstance(machine, Rotor) else machine.rotor()
    from rotor_ida.simulation.starts import start_of  # noqa: PLC0415 - heavy, and not for --help

    first = None if given["start"] is None else check_state("start", given["start"])
    start = start_of(rotor, first)
    check_can_be_followed(rotor, start)
    return {"machine": machine, "start": start, **_ramp(rotor, given)}


def _ramp(rotor: Rotor, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return end, rate and first angle of a piece of a run-up, if it is short enough."""
    if given["about"] != "run_up":
        return {}
    to, rate = check_nonnegative("to", given["to"], LARGEST), check_real("rate", given["rate"])
    if rate == 0.0 or to == rotor.omega or (rate > 0.0) != (to > rotor.omega):
        raise InputError(f"rate must lead from the speed {rotor.omega!r} to {to!r}, got {rate!r}")
    turns = max(0.5 * (rotor.omega + to), 1.0) * (to - rotor.omega) / (2.0 * math.pi * rate)
    if not turns <= MOST_REVOLUTIONS:
        raise InputError(
            f"a piece of a run-up must have at most {MOST_REVOLUTIONS} revolutions, got {turns:.6g}"
        )
    return {"to": to, "rate": rate, "angle": check_nonnegative("angle", given["angle"], LARGEST)}


@contextmanager
def named(path: Path, name: str | None = None) -> Iterator[None]:
    """Tell a file by its name alone in errors, or by the one that the user knows."""
    try:
        yield
    except InputError as error:
        name = name or path.name
        instead = {shown(path): shown(name), str(path): name, path.name: name}
        words = "|".join(map(re.escape, instead))
        told = re.sub(rf"(?<!\w)({words})(?!\w)", lambda seen: instead[seen[0]], str(error))
        raise InputError(told.replace(f"{path.parent}{os.sep}", "")) from error


@dataclass(frozen=True, slots=True)
class Answer:
    """One part of an answer.

    Parameters
    ----------
    part : str
        Name of the part.
    facts : dict
        Numbers, strings, and lists and mappings of them.
    arrays : dict of ndarray
        Arrays by name; the facts give their dimensions.
    """

    part: str
    facts: dict[str, object] = field(default_factory=dict)
    arrays: dict[str, npt.NDArray[np.generic]] = field(default_factory=dict)


def packed(answer: Answer, ticket: Mapping[str, object] | None = None) -> bytes:
    """Return an answer as bytes, with the ticket of its question.

    Notes
    -----
    The format is: the number of bytes of the header, little-endian in four bytes; the header as
    JSON; the arrays, little-endian. The header gives each array as kind (f8, f4 or i1), offset in
    bytes after the header and number of values. Non-finite values are null in the header and NaN
    in an array.

    Examples
    --------
    >>> packed(Answer("curve", {"zeta": 0.07}))[4:]
    b'{"part": "curve", "facts": {"zeta": 0.07}, "arrays": {}}'
    """
    places: dict[str, tuple[str, int, int]] = {}
    blocks: list[bytes] = []
    offset = 0
    for name, values in answer.arrays.items():
        kind = KINDS[values.dtype]
        block = values.astype(values.dtype.newbyteorder("<")).tobytes()
        block += bytes(-len(block) % ALIGNED)
        places[name] = (kind, offset, values.size)
        blocks.append(block)
        offset += len(block)
    header_facts = {
        "part": answer.part,
        **(ticket or {}),
        "facts": plain(answer.facts),
        "arrays": places,
    }
    header = json.dumps(header_facts, allow_nan=False).encode()
    if blocks:
        header += b" " * (-(4 + len(header)) % ALIGNED)
    return len(header).to_bytes(4, "little") + header + b"".join(blocks)


def part_of(answer: bytes) -> str:
    """Return the name of the part that a packed answer is.

    Examples
    --------
    >>> part_of(packed(Answer("curve", {"zeta": 0.07})))
    'curve'
    """
    end = 4 + int.from_bytes(answer[:4], "little")
    return str(json.loads(answer[4:end])["part"])
