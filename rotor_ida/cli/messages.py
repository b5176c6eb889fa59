"""Messages in the units of the user: rpm where rpm was given, and no number without dimensions.

The functions of the package raise errors about the numbers that they get. Those of a machine have
no dimensions, or are in SI units; the user gave a word such as ``3000rpm``. Here the numbers of a
message return to the units of the command line and its file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rotor_ida import units
from rotor_ida.cli.machines import BECOMES, IS_OF_MACHINE, of_sheet, plain, sheet_of
from rotor_ida.cli.parsing import WITH_UNIT, Quantity
from rotor_ida.errors import RotorError
from rotor_ida.model.data_sheet import IN_OTHER_WORDS, check_keys
from rotor_ida.model.parameters import OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor

# SI units of the quantities that messages name, one for each number that follows the name.
NAMED: dict[str, tuple[str, ...]] = {
    **{name: (IN_OTHER_WORDS[name],) for name in ("critical_speed", "balance_speed", "unbalance")},
    # but of contact_stiffness, whose unit depends on its law
    **{name: (each.unit,) for name, each in OF_MACHINE.items() if "m-1.5" not in each.unit},
    **{new: (OF_MACHINE[old].unit,) for old, new in BECOMES.items()},
    **dict.fromkeys(("x", "y", "vibration_limit"), ("m",)),
    **dict.fromkeys(("vx", "vy"), ("m s-1",)),
    **dict.fromkeys(("t", "time", "times", "duration", "ramp_time", "extrema_time", "period"),
                    ("s",)),
    **dict.fromkeys(("to", "from", "limits"), ("rad s-1",)),
    "rate": ("rad s-2",), "torque": ("N m", "N m s"), "tau0": ("N m",), "inertia": ("kg m2",),
    "speeds": ("s", "rad s-1"), "state": ("m", "m", "m s-1", "m s-1"),
}  # fmt: skip
SPEED = "speed"
# In the middle of a message these are other words.
SUBJECTS = ("to", "from", "limits", "speeds")
# Units of a machine's speeds where none was given; others are in SI units.
USUAL = {"rad s-1": "rpm", "rad s-2": "rpm/s"}
# The name in messages of a keyword that is a word of Python there.
OPTION = {"begin": "from"}
# Quoted words stay, and numbers of radians; a number in rad/s is a speed.
TOKEN = re.compile(
    r"'[^']*'|(?P<name>[A-Za-z_]\w*)"
    r"|(?<![\w.^])(?P<number>[-+]?\d+\.?\d*(?:e[-+]?\d+)?)(?![\w.]*\w)"
    r"(?P<in_si> rad/s\b)?(?P<other> rad(?:ians)?\b)?"
)
# Sizes and indices are no quantities.
COUNTED = re.compile(r"\bshape\b|\bindices\b")
STATE = ("state (x, y, vx, vy) =", "state")
# Messages have some numbers in six digits.
SIX_DIGITS, EXACT = 5e-6, 1e-12


class Given(NamedTuple):
    """A number as given: the name of its option or entry, its value in SI units, its unit."""

    name: str
    value: float
    unit: str = ""
    in_file: bool = False

    def in_unit_of(self, si: str) -> bool:
        """Return whether its unit is one of the same dimension."""
        return bool(self.unit) and units.dimension_of(self.unit) == units.dimension_of(si)


def in_given_units(arguments: Mapping[str, Any], message: str) -> str:
    """Return a message about the arguments of a command in the units in which they were given.

    Parameters
    ----------
    arguments : mapping of str to object
        The arguments of the function of the command.
    message : str
        What an error says about them.
    """
    groups = [each for each in arguments.values() if is_dataclass(each)]
    of_machine = any(getattr(each, "in_si", hasattr(each, "mass")) for each in groups)
    of_archive = any(getattr(each, "from_", None) is not None for each in groups)
    if not (of_machine or of_archive) and arguments.get("system") is None:
        return message  # nothing was converted, or into the units of a measured file
    given, machine = list(_on_the_line(arguments)), None
    try:
        given += _in_files(arguments)
        machine = _machine(arguments)
    except RotorError:
        pass  # the message says what is wrong with the file or the machine
    return rewritten(message, given, machine)


def rewritten(message: str, given: Sequence[Given], machine: DimensionalRotor | None = None) -> str:
    """Return a message with its numbers in given units.

    Parameters
    ----------
    message : str
        One line, such as "rate must be positive, got -1.0".
    given : sequence of Given
        The numbers of the command line, then those of its file.
    machine : DimensionalRotor, optional
        The machine whose dimensionless numbers the message may contain.

    Examples
    --------
    >>> given = [Given("rate", -10.471975511965976, "rpm/s"), Given("to", 628.3185307179587, "rpm")]
    >>> rewritten("rate must be positive to change the speed from 0 to 628.319 rad/s, got "
    ...           "-10.471975511965976", given)
    'rate must be positive to change the speed from 0 to 6000 rpm, got -100 rpm/s'
    """
    if COUNTED.search(message):
        return message
    if machine is not None:
        message = message.replace(*STATE)
    head, must, body = message.rpartition(" must ")
    where, colon, head = head.rpartition(": ")
    named = {each.name: (each.unit,) for each in given if each.unit} | NAMED
    known = [name for name in re.findall(r"\w+", head) if name in named]
    # a start has an x, and limits are of another quantity
    known.sort(key=lambda name: name not in NAMED or name == "limits")
    subject = "" if head.startswith("exactly") or not known else known[0]
    numbers = [float(each["number"]) for each in TOKEN.finditer(body.rpartition("got ")[2])
               if each["number"]]  # fmt: skip
    si = named.get(subject, ("1",))
    in_si = machine is None or " rad/s" in body or _includes(given, numbers, si)
    writing = _Writing(given, named, machine, in_si)
    new = {} if machine is None else IS_OF_MACHINE
    head = re.sub(r"\w+", lambda name: new.get(name[0], name[0]), head)
    line = f"{where}{colon}{head}{must}{''.join(writing.words(subject, body))}"
    if machine is not None and head in {"clearance", "disc_radius"} and "to be simulated" in body:
        # a nearly balanced machine has large ratios of its lengths to the eccentricity
        micrometres = 1e6 * machine.eccentricity
        line += f"; the limits are proportional to the eccentricity, {micrometres:.3g} um"
    return line


@dataclass(frozen=True, slots=True)
class _Writing:
    """What one message is written with: its numbers are in SI units or have no dimensions."""

    given: Sequence[Given]
    named: Mapping[str, tuple[str, ...]]
    machine: DimensionalRotor | None
    in_si: bool

    def words(self, subject: str, body: str) -> Iterator[str]:
        """Yield the parts of a message: a number is of the quantity that was named before it."""
        name, place, end, after_got = subject, 0, 0, False
        for token in TOKEN.finditer(body):
            yield body[end : token.start()]
            end = token.end()
            word, number = token["name"], token["number"]
            if word == "got":
                name, place, after_got = subject, 0, True
            elif word in self.named and word not in SUBJECTS:
                name, place = word, 0
                yield IS_OF_MACHINE.get(word, word) if self.machine is not None else word
                continue
            is_count = after_got and number is not None and not set(number) & set(".e")
            if number is None or token["other"] or is_count:
                yield token[0]
                continue
            several = ("rad s-1",) if token["in_si"] else self.named.get(name, ("1",))
            written = self.number(name, float(number), several[place % len(several)])
            place += 1
            if written and float(number) == 0.0 and not after_got:
                written = "0"  # a limit, which needs no unit
            yield written or token[0]
        yield body[end:]

    def number(self, name: str, number: float, si: str) -> str:
        """Return a number of a quantity in the unit in which it was given; empty if it has none."""
        if si == "1":
            return ""
        value = number if self.in_si else number * _scale(self.machine, si)
        unit = self.unit(IS_OF_MACHINE.get(name, name), si)
        for each in self.given:
            same = each.in_unit_of(si) if each.unit else si in self.named.get(each.name, ())
            if same and math.isclose(value, each.value, rel_tol=SIX_DIGITS):
                value = each.value
                if each.unit or (unit and not each.in_file):
                    unit = each.unit or _shown(si)
                break
        known = units.unit_of(unit)
        return f"{value / known.in_si('1'):.6g} {unit}" if known is not None else ""

    def unit(self, name: str, si: str) -> str:
        """Return the unit for numbers of a quantity; empty if they stay as they are."""
        names = (name, f"{name}s")  # a speed of speeds
        own = [each for each in self.given if each.name in names and not each.in_file]
        alike = [each.unit for each in (*own, *self.given) if each.in_unit_of(si)]
        anything = self.machine is not None or any(each.unit for each in self.given)
        if own and not own[0].unit:
            return _shown(si) if self.machine is not None else ""
        return alike[0] if alike else USUAL.get(si, _shown(si)) if anything else ""


def _includes(given: Sequence[Given], numbers: Sequence[float], si: Sequence[str]) -> bool:
    """Return whether one of the numbers is a given one, in SI units."""
    alike = [each for each in given
             if (any(map(each.in_unit_of, si)) if each.unit else not each.in_file)]  # fmt: skip
    return any(
        number and math.isclose(number, each.value, rel_tol=EXACT)
        for number in numbers
        for each in alike
    )


def _shown(si: str) -> str:
    """Return an SI unit as a reader writes it."""
    return re.sub(r" (\w+)-1\b", r"/\1", si).replace(" s-2", "/s2")


def _scale(machine: DimensionalRotor | None, si: str) -> float:
    """Return the value of a dimensionless 1 of a machine in an SI unit; 1 where it has none."""
    if machine is None:
        return 1.0
    rate, velocity = machine.reference_frequency, machine.velocity_scale
    return {
        "m": machine.length_scale, "s": machine.time_scale, "m s-1": velocity,
        "rad s-1": rate, "rad s-2": rate**2, "N": machine.force_scale,
        "N m-1": machine.mass * rate**2, "N s m-1": 2.0 * machine.mass * rate,
        "s m-1": 1.0 / velocity, "N m": machine.torque_scale,
        "N m s": machine.torque_scale / rate, "kg m2": machine.inertia_scale,
    }.get(si, 1.0)  # fmt: skip


def _on_the_line(arguments: Mapping[str, Any]) -> Iterator[Given]:
    """Yield the numbers of the command line."""
    for name, value in arguments.items():
        if is_dataclass(value) and not isinstance(value, type):
            yield from _on_the_line(asdict(value))
        else:
            yield from _in_entry(OPTION.get(name, name), value)


def _in_files(arguments: Mapping[str, Any]) -> Iterator[Given]:
    """Yield the numbers in the files of a machine and of a system."""
    from rotor_ida.results.toml_files import read_toml  # noqa: PLC0415 - only after an error

    files = [getattr(group, "machine", None) for group in arguments.values()]
    for file in [*files, arguments.get("system")]:
        if isinstance(file, Path):
            yield from (each._replace(in_file=True) for each in _in_entry("", read_toml("", file)))


def _in_entry(name: str, entry: object) -> Iterator[Given]:
    """Yield the numbers of an option, or of an entry of a file and its parts."""
    if isinstance(entry, Mapping):
        for key, each in entry.items():
            yield from _in_entry(key, each)
    elif isinstance(entry, (list, tuple)):
        for each in entry:
            yield from _in_entry(name, each)
    elif isinstance(entry, Quantity) and entry.word:
        word = WITH_UNIT.fullmatch(entry.word.partition(":")[0])
        yield Given(name, entry, word["unit"] if word else "")
    elif isinstance(entry, float):
        yield Given(name, entry)
    elif isinstance(entry, str) and (word := WITH_UNIT.fullmatch(entry.strip())):
        unit = units.unit_of(word["unit"])
        if unit is not None:
            yield Given(name, unit.in_si(word["number"]), word["unit"])


def _machine(arguments: Mapping[str, Any]) -> DimensionalRotor | None:
    """Return the machine of a command, at any speed; None without one."""
    if arguments.get("system") is not None:
        return None
    for group in arguments.values():
        if getattr(group, "from_", None) is not None:
            from rotor_ida.cli.output import read  # noqa: PLC0415 - only after an error

            return plain(read(group.from_))[1].machine
        if getattr(group, "in_si", False):
            several = group.values if hasattr(group, "values") else group.given
            values = {name: each[0] if isinstance(each, list) else each
                      for name, each in several.items()}  # fmt: skip
            sheet = sheet_of({SPEED: 0.0} | values, group.machine)
            check_keys(sheet, "a machine")
            return of_sheet(sheet, group.machine)
    return None
