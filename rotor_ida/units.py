"""The table of units: the dimension of each, its value in SI units, and where the field uses it.

It is used to read options of the command line, parameters of machines and columns of measured
files, and to write quantities for people.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from operator import itemgetter
from typing import Literal, NamedTuple

# Each unit of speed in radians per second.
SpeedUnit = Literal["rad/s", "rpm", "Hz"]
SPEED_UNITS: dict[SpeedUnit, float] = {"rad/s": 1.0, "rpm": math.pi / 30.0, "Hz": 2.0 * math.pi}
# The power of ten of each prefix, and how many units with the prefix make one without.
POWERS = {"p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6}
PREFIXES = {prefix: 10.0**-power for prefix, power in POWERS.items()}

UnitSystem = Literal["metric", "inch"]
# The system of units in which sentences and figures are by default.
_SENTENCES: ContextVar[UnitSystem] = ContextVar("sentences", default="metric")
_INCH, _POUND, _POUND_FORCE = 25.4e-3, 0.45359237, 4.4482216152605
# The units in which the field reads quantities, by their SI units, with their values in these; the
# first is the usual one.
READ_IN: dict[UnitSystem, dict[str, tuple[tuple[str, float], ...]]] = {
    "metric": {
        "m": (("um", 1e-6), ("nm", 1e-9), ("mm", 1e-3), ("m", 1.0)),
        "s": (("ms", 1e-3), ("ns", 1e-9), ("us", 1e-6), ("s", 1.0)),
        "m/s": (("mm/s", 1e-3), ("m/s", 1.0)),
        "N": (("N", 1.0), ("uN", 1e-6), ("mN", 1e-3), ("kN", 1e3), ("MN", 1e6)),
        "N s": (("N s", 1.0), ("uN s", 1e-6), ("mN s", 1e-3), ("kN s", 1e3)),
        "J": (("J", 1.0), ("nJ", 1e-9), ("uJ", 1e-6), ("mJ", 1e-3), ("kJ", 1e3), ("MJ", 1e6)),
        "N/m": (("N/m", 1.0), ("kN/m", 1e3), ("MN/m", 1e6)),
        "rad/s": (("rpm", SPEED_UNITS["rpm"]),),
        "rad/s2": (("rpm/s", SPEED_UNITS["rpm"]),),
        "kg m": (("g mm", 1e-6),),
        "radian": (("deg", math.pi / 180.0),),
    },
    "inch": {
        "m": (("mil", 1e-3 * _INCH), ("in", _INCH)),
        "m/s": (("in/s", _INCH),),
        "m/s2": (("in/s2", _INCH),),
        "s/m": (("s/in", 1.0 / _INCH),),
        "kg": (("lb", _POUND),),
        "kg m": (("oz in", _POUND / 16.0 * _INCH),),
        "kg m2": (("lb in2", _POUND * _INCH**2),),
        "N": (("lbf", _POUND_FORCE),),
        "N s": (("lbf s", _POUND_FORCE),),
        "N/m": (("lbf/in", _POUND_FORCE / _INCH),),
        "N/m^1.5": (("lbf/in^1.5", _POUND_FORCE / _INCH**1.5),),
        "N s/m": (("lbf s/in", _POUND_FORCE / _INCH),),
        "N m": (("lbf in", _POUND_FORCE * _INCH),),
        "N m s": (("lbf in s", _POUND_FORCE * _INCH),),
        "J": (("lbf in", _POUND_FORCE * _INCH),),
    },
}

# The longest text that is read as a unit, and the largest exponent in it.
LONGEST, LARGEST_EXPONENT = 60, 20.0

# Exponents of kg, m, s and rad. Angles have a dimension here, to distinguish speeds from rates.
Dimension = tuple[float, float, float, float]


class Unit(NamedTuple):
    """A unit of ``factor * 10**power`` SI units, and its dimension.

    The power of ten is separate so that 60 um is the double nearest to 60e-6.
    """

    factor: float
    power: float
    dimension: Dimension

    def to(self, exponent: float) -> Unit:
        """Return the unit to some power."""
        kg, m, s, rad = (each * exponent for each in self.dimension)
        return Unit(math.pow(self.factor, exponent), self.power * exponent, (kg, m, s, rad))

    def times(self, other: Unit) -> Unit:
        """Return the product of two units."""
        both = zip(self.dimension, other.dimension, strict=True)
        kg, m, s, rad = (one + two for one, two in both)
        return Unit(self.factor * other.factor, self.power + other.power, (kg, m, s, rad))

    def in_si(self, number: str) -> float:
        """Return a decimal number of this unit in SI units."""
        if self.power != int(self.power) or len(number) > LONGEST:
            return float(number) * math.pow(10.0, self.power) * self.factor
        digits, _, exponent = number.lower().partition("e")
        moved = f"{digits}e{int(exponent or 0) + int(self.power)}"
        return float(moved if float(number) else 0.0) * self.factor


ONE = Unit(1.0, 0.0, (0.0, 0.0, 0.0, 0.0))
_MASS, _LENGTH, _TIME = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)
_ANGLE, _SPEED = (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, -1.0, 1.0)
_FORCE = (1.0, 1.0, -2.0, 0.0)
# Symbols that take prefixes, then those that take none.
_PREFIXED = {
    "g": Unit(1.0, -3, _MASS),
    "m": Unit(1.0, 0, _LENGTH),
    "s": Unit(1.0, 0, _TIME),
    "N": Unit(1.0, 0, _FORCE),
}
_PLAIN = {
    "cm": Unit(1.0, -2, _LENGTH),
    "in": Unit(25.4, -3, _LENGTH),
    "lb": Unit(0.45359237, 0, _MASS),
    "oz": Unit(28.349523125, -3, _MASS),
    "lbf": Unit(4.4482216152605, 0, _FORCE),
    "Nms": Unit(1.0, 0, (1.0, 2.0, -1.0, 0.0)),  # not N ms
    "mil": Unit(25.4, -6, _LENGTH),
    "min": Unit(60.0, 0, _TIME),
    "rad": Unit(1.0, 0, _ANGLE),
    "deg": Unit(math.pi / 180.0, 0, _ANGLE),
    "rev": Unit(2.0 * math.pi, 0, _ANGLE),
    "rpm": Unit(SPEED_UNITS["rpm"], 0, _SPEED),
    "Hz": Unit(SPEED_UNITS["Hz"], 0, _SPEED),
}
UNITS = {
    prefix + symbol: Unit(unit.factor, unit.power + power, unit.dimension)
    for symbol, unit in _PREFIXED.items()
    for prefix, power in POWERS.items()
    if prefix != "M" or symbol == "N"  # so that MM can be mm
} | _PLAIN
# Capitals that mean something else than the small letter before a symbol: mega, peta, newton.
_CAPITALS = ("M", "P", "N")
# Other names of these.
NAMES = {
    name: symbol
    for symbol, names in {
        "s": ("sec", "secs", "second", "seconds"),
        "ms": ("msec", "milliseconds"),
        "us": ("usec", "microseconds"),
        "min": ("minutes",),
        "rad": ("radian", "radians"),
        "deg": ("°", "degree", "degrees"),
        "rev": ("revolutions", "turns"),
        "m": ("metre", "metres", "meter", "meters"),
        "mm": ("millimetre", "millimetres", "millimeters"),
        "um": ("micron", "microns"),
        "in": ("inch", "inches"),
        "mil": ("mils",),
        "lb": ("lbs", "lbm"),
        "rpm": ("1/min", "min-1", "r/min"),
    }.items()
    for name in names
}
# Units that messages suggest.
USUAL = (
    *("kg", "g", "lb", "m", "mm", "um", "in", "mil", "s", "ms", "min", "N", "kN", "lbf", "m/s"),
    *("mm/s", "m/s2", "rad/s", "rpm", "Hz", "rad/s2", "rpm/s", "Hz/s", "N/m", "N/mm", "N/um"),
    *("lbf/in", "N/m^1.5", "N s/m", "N s/mm", "lbf s/in", "s/m", "s/mm", "kg m", "g mm", "oz in"),
    *("N m", "N m s", "kg m2", "rad", "deg"),
)
_LETTERS = r"[^\W\d_]+|°"
_FACTOR = re.compile(rf"({_LETTERS})(?:\^?(-?\d+(?:\.\d+)?))?(?:[\s.*]|-(?={_LETTERS}))*")
# Abbreviations with two meanings, here gram and gram metre, and what to write instead.
AMBIGUOUS = {"gm": "'g m' or 'g mm'"}
_LOOKALIKES = str.maketrans({"µ": "u", "μ": "u", "²": "2", "³": "3", "·": " ", "⋅": " ", "−": "-"})
_BY_LOWER_CASE = {
    name.lower(): name
    for name in (*UNITS, *NAMES)
    if sum(name.lower() == other.lower() for other in (*UNITS, *NAMES)) == 1
}


def symbol_of(name: str, *, any_case: bool = True) -> str:
    """Return the symbol that a name stands for, in any case if only one fits; else ``""``.

    Examples
    --------
    >>> symbol_of("Mils"), symbol_of("µm"), symbol_of("HZ"), symbol_of("furlong"), symbol_of("Mm")
    ('mil', 'um', 'Hz', '', '')
    """
    plain = name.strip().translate(_LOOKALIKES)
    if plain not in UNITS and plain not in NAMES:
        has_meaning = plain[:1] in _CAPITALS and plain[1:] in _PREFIXED
        plain = _BY_LOWER_CASE.get(plain.lower(), "") if any_case and not has_meaning else ""
    return NAMES.get(plain, plain)


@lru_cache(maxsize=1000)
def unit_of(text: str) -> Unit | None:
    """Return the unit that a text of up to 60 characters denotes, or None if it is not a unit.

    Factors may be joined by blanks, dots, asterisks, hyphens or nothing at all, if the reading is
    unique; their exponents may have a caret.

    Examples
    --------
    >>> unit_of("N s/m") == unit_of("Ns/m") == unit_of("N s m-1")
    True
    >>> unit_of("N/mm").in_si("4000"), unit_of("µm").in_si("60"), unit_of("RPM").in_si("0")
    (4000000.0, 6e-05, 0.0)
    >>> unit_of("Nmm"), unit_of("furlong")  # is it N mm, or N m m?
    (None, None)
    """
    if len(text) > LONGEST:
        return None
    if symbol := symbol_of(text, any_case=False):  # 1/min has a slash
        return UNITS[symbol]
    over, *under = text.translate(_LOOKALIKES).strip().split("/")
    found = ONE if over.strip() == "1" and under else _product(over)
    for part in under:
        below = _product(part)
        found = found.times(below.to(-1.0)) if found and below else None
    return found


def written(value: float, unit: str) -> str:
    """Return the shortest text with a unit that is read as exactly this value in SI units.

    Examples
    --------
    >>> written(4300.0 * SPEED_UNITS["rpm"], "rpm"), written(1.2e-4, "um"), written(0.837, "s")
    ('4300rpm', '120um', '0.837s')
    """
    known = unit_of(unit)
    assert known is not None
    quotient = value / known.in_si("1")
    for digits in range(1, 18):
        number = f"{quotient:.{digits}g}"
        plain = repr(float(number)).removesuffix(".0")
        if known.in_si(plain) == value:
            return f"{plain}{unit}"
    return f"{quotient!r}{unit}"


def spelled(unit: str) -> str:
    """Return a unit in the notation of UDUNITS as people write it.

    Examples
    --------
    >>> [spelled(unit) for unit in ("N s m-1", "N m-1.5", "rad s-2", "s-1", "kg m", "1")]
    ['N s/m', 'N/m^1.5', 'rad/s2', '1/s', 'kg m', '']
    """
    found = re.fullmatch(r"(?:(.+) )?([ms])-([\d.]+)", unit)
    if found is None:
        return "" if unit == "1" else unit
    over, under, power = found.groups()
    exponent = "" if power == "1" else f"^{power}" if "." in power else power
    return f"{over or 1}/{under}{exponent}"


def read_in(
    unit: str, sizes: Iterable[float] = (), *, system: UnitSystem | None = None
) -> tuple[str, float]:
    """Return the unit in which the field reads quantities of an SI unit, and its value in that.

    It suits the largest size; without any that is not 0 it is the usual one. The system is metric,
    unless `sentences_in` says otherwise.

    Examples
    --------
    >>> read_in("N", [20.0, 1500.0]), read_in("rad/s")[0], read_in("m", [8e-5], system="inch")[0]
    (('kN', 1000.0), 'rpm', 'mil')
    >>> read_in("m"), read_in("m", [0.02]), read_in("N s m-1"), read_in("s-1"), read_in("1")
    (('um', 1e-06), ('mm', 0.001), ('N s/m', 1.0), ('1/s', 1.0), ('', 1.0))
    """
    plain = spelled(unit)
    known = READ_IN[system or _SENTENCES.get()].get(plain) or READ_IN["metric"].get(
        plain, ((plain, 1.0),)
    )
    largest = max((abs(each) for each in sizes if math.isfinite(each)), default=0.0)
    below = [each for each in known if each[1] <= largest * (1.0 + 1e-12)]
    if not largest:
        return known[0]
    return max(below, key=itemgetter(1)) if below else min(known, key=itemgetter(1))


def number(value: float, digits: int = 4) -> str:
    """Return a number with some digits, without an exponent where it has a common size.

    Examples
    --------
    >>> number(19940.3), number(0.012345678), number(2.18e10), number(250.0), number(math.nan)
    ('19940', '0.01235', '2.18e+10', '250', '-')
    """
    size = abs(value)
    if math.isnan(value):
        return "-"
    if not 1e-4 <= size < 1e7:
        return f"{value:.{digits}g}"
    places = max(0, digits - 1 - math.floor(math.log10(size)))
    said = f"{value:.{places}f}"
    return said.rstrip("0").rstrip(".") if "." in said else said


def with_error(value: float, error: float, *, most: int | None = None) -> str:
    """Return a value with the error of its last digits in brackets.

    It has a power of ten if it is small or large, unless `most` is its number of decimals at most.

    Examples
    --------
    >>> with_error(0.17123, 0.0098), with_error(4123456.0, 2100.0), with_error(1.5e-9, 4e-11)
    ('0.171(10)', '4123456(2100)', '1.500(40)e-09')
    >>> with_error(-1e-9, 3e-8, most=5)
    '0.00000'
    """
    if not (math.isfinite(error) and error > 0.0):
        return number(value) if most is None else f"{round(value, most) + 0.0:.{most}f}"
    size = max(abs(value), error)
    power = 0 if 1e-4 <= size < 1e7 or most is not None else math.floor(math.log10(size))
    value, error = value / 10.0**power, error / 10.0**power
    places = min(max(0, -math.floor(math.log10(error / 5.0))), 12 if most is None else most)
    last = round(error * 10.0**places)
    said = f"{round(value, places) + 0.0:.{places}f}"
    return said + (f"({last})" if last else "") + (f"e{power:+03d}" if power else "")


@contextmanager
def sentences_in(system: UnitSystem) -> Iterator[None]:
    """Let sentences and figures be in a system of units by default.

    Examples
    --------
    >>> with sentences_in("inch"):
    ...     quantity(1e-4, "m")
    '3.937 mil'
    """
    before = _SENTENCES.set(system)
    try:
        yield
    finally:
        _SENTENCES.reset(before)


def quantity(
    value: float, unit: str = "1", digits: int = 4, *, error: float = 0.0,
    system: UnitSystem | None = None,
) -> str:  # fmt: skip
    """Return a value in SI units as people of the field read it, with its error if it has one.

    Speeds in rpm are whole numbers from 1000 on. The system is metric, unless `sentences_in` says
    otherwise.

    Examples
    --------
    >>> quantity(1145.8, "N", 3), quantity(8e-5, "m"), quantity(0.0203, "m"), quantity(3.0)
    ('1.15 kN', '80 um', '20.3 mm', '3')
    >>> [quantity(each * SPEED_UNITS["rpm"], "rad/s") for each in (0.0, 95.126, 10512.3, -1.5e6)]
    ['0 rpm', '95.13 rpm', '10,512 rpm', '-1,500,000 rpm']
    >>> quantity(1e-4, "m", error=2e-6), quantity(1e-4, "m", system="inch")
    ('100.0(20) um', '3.937 mil')
    """
    word, parts = read_in(unit, [value], system=system)
    value /= parts
    if error:
        said = with_error(value, error / parts)
    elif word == "rpm" and abs(value) >= 1e3:
        said = f"{value:,.0f}"
    else:
        said = number(value, digits)
    return f"{said} {word}".rstrip()


def usual(*allowed: str) -> str:
    """Return in words the usual units with the same dimensions as the given ones.

    Examples
    --------
    >>> usual("rad s-1"), usual("N m s")
    ('rad/s, rpm or Hz', 'N m s')
    """
    dimensions = {dimension_of(each) for each in allowed}
    fitting = [name for name in USUAL if dimension_of(name) in dimensions]
    *first, last = fitting
    return f"{', '.join(first)} or {last}" if first else last


def dimension_of(text: str) -> Dimension | None:
    """Return the dimension of the unit that a text denotes, or None if it is not a unit."""
    unit = unit_of(text)
    return None if unit is None else unit.dimension


def _product(text: str) -> Unit | None:
    """Return the product of units written one after the other."""
    found, place, text = ONE, 0, text.strip()
    while place < len(text):
        factor = _FACTOR.match(text, place)
        exponent = float(factor[2] or 1.0) if factor else math.inf
        known = factor is not None and abs(exponent) <= LARGEST_EXPONENT
        unit = _run_together(factor[1], exponent) if factor and known else None
        if factor is None or unit is None:
            return None
        found, place = found.times(unit), factor.end()
    return found if text else None


def _run_together(letters: str, exponent: float) -> Unit | None:
    """Return the unique unit or product that letters denote; the exponent is the last factor's."""
    if letters in AMBIGUOUS:
        return None
    symbol = symbol_of(letters, any_case=False)
    readings = _readings(letters, exponent)
    if not symbol and not readings:  # Ns is N s, not ns
        symbol = symbol_of(letters)
    if symbol:
        return UNITS[symbol].to(exponent)
    return readings.pop() if len(readings) == 1 else None


def _readings(letters: str, exponent: float) -> set[Unit]:
    """Return every product that letters denote; the exponent is that of the last factor."""
    products: list[set[Unit]] = [{ONE}]  # of the first letters, by their number
    for end in range(1, len(letters)):
        products.append(_longer(products, letters, end, 1.0))
    return _longer(products, letters, len(letters), exponent)


def _longer(products: list[set[Unit]], letters: str, end: int, exponent: float) -> set[Unit]:
    """Return the products of the letters before `end`, the last of them to some power."""
    return {
        before.times(UNITS[letters[begin:end]].to(exponent))
        for begin in range(end)
        if letters[begin:end] in UNITS
        for before in products[begin]
    }
