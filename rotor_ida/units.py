"""The table of units: the dimension of each, and its value in SI units.

It is used to read options of the command line, parameters of machines and columns of measured
files.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Literal, NamedTuple

# Each unit of speed in radians per second.
SpeedUnit = Literal["rad/s", "rpm", "Hz"]
SPEED_UNITS: dict[SpeedUnit, float] = {"rad/s": 1.0, "rpm": math.pi / 30.0, "Hz": 2.0 * math.pi}
# The power of ten of each prefix, and how many units with the prefix make one without.
POWERS = {"p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6}
PREFIXES = {prefix: 10.0**-power for prefix, power in POWERS.items()}

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
        "rpm": ("1/min", "min-1", "r/min"),
    }.items()
    for name in names
}
# Units that messages suggest.
USUAL = (
    *("kg", "g", "m", "mm", "um", "in", "mil", "s", "ms", "min", "N", "kN", "m/s", "mm/s", "m/s2"),
    *("rad/s", "rpm", "Hz", "rad/s2", "rpm/s", "Hz/s", "N/m", "N/mm", "N/um", "N/m^1.5"),
    *("N s/m", "N s/mm", "s/m", "s/mm", "kg m", "g mm", "N m", "N m s", "kg m2", "rad", "deg"),
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


def rpm(speed: float) -> str:
    """Return a speed in rad/s as a text in rpm, to four digits or a whole number, never as 1e+04.

    Examples
    --------
    >>> [rpm(each * SPEED_UNITS["rpm"]) for each in (0.0, 95.126, 10512.3, -1.5e6)]
    ['0 rpm', '95.13 rpm', '10,512 rpm', '-1,500,000 rpm']
    """
    turns = speed / SPEED_UNITS["rpm"]
    return f"{turns:,.0f} rpm" if abs(turns) >= 1e3 else f"{turns:.4g} rpm"


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
