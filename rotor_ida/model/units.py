"""Quantities with their units in words, such as ``150um``, ``12 kg``, ``3600rpm`` or ``3%``."""

from __future__ import annotations

import re
from fractions import Fraction

from rotor_ida.checks import check_real, shown
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import SPEED_UNITS

_WORD = re.compile(r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?P<unit>\S.*)?")
_LENGTHS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "mil": 2.54e-5,
}  # fmt: skip
LINEAR_STIFFNESSES = {
    "N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "kN/mm": 1e6, "N/um": 1e6,
}  # fmt: skip
# By SI unit, as the table of parameters writes it: how many of it each unit that may be given is.
UNITS: dict[str, dict[str, float]] = {
    "kg": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237},
    "m": _LENGTHS,
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "m s-1": {f"{unit}/s": factor for unit, factor in _LENGTHS.items()},
    "rad s-1": {str(unit): factor for unit, factor in SPEED_UNITS.items()},
    "N": {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605},
    "N m-1": LINEAR_STIFFNESSES,
    "N m-1.5": {"N/m^1.5": 1.0, "N/mm^1.5": 1e3**1.5, "N/um^1.5": 1e9, **LINEAR_STIFFNESSES},
    "N s m-1": {"N s/m": 1.0, "kN s/m": 1e3, "N s/mm": 1e3},
    "s m-1": {"s/m": 1.0, "s/mm": 1e3},
    "kg m": {
        "kg m": 1.0, "kg mm": 1e-3, "g m": 1e-3, "g mm": 1e-6, "g cm": 1e-5,
        "oz in": 0.000720077887375,
    },
    "1": {"%": 1e-2},
}  # fmt: skip


def in_si(name: str, value: object, unit: str) -> float:
    """Return a quantity in its SI unit: a number that is in it, or words with a unit.

    Parameters
    ----------
    name : str
        What a message calls the quantity.
    value : float or str
        The number, or a number and a unit: ``"150um"``, ``"150 um"``.
    unit : str
        The SI unit, as `UNITS` has it.

    Returns
    -------
    float
        The quantity [unit].

    Raises
    ------
    InputError
        If the value is not a finite number, or its unit is none of the quantity.

    Examples
    --------
    >>> in_si("mass", "12 kg", "kg"), in_si("clearance", "150µm", "m"), in_si("mass", 4, "kg")
    (12.0, 0.00015, 4.0)
    >>> in_si("mass", "12 um", "kg")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: the unit of mass must be kg, g, t or lb, got '12 um'
    """
    if not isinstance(value, str):
        return check_real(name, value)
    found = _WORD.fullmatch(value) if _plain(value).isascii() else None
    if found is None:
        raise InputError(f"{name} must be a finite real number, got {shown(value)}")
    number = check_real(name, float(found["number"]))
    if found["unit"] is None:
        return number
    written = _plain(found["unit"])
    for each, factor in UNITS[unit].items():
        if written == _plain(each):  # of decimals, rounded once: 150 um are 0.00015 m
            return float(Fraction(found["number"]) * Fraction(repr(factor)))
    *units, last = UNITS[unit]
    allowed = f"{', '.join(units)} or {last}" if units else last
    raise InputError(f"the unit of {name} must be {allowed}, got {shown(value)}")


def has_unit(word: str) -> bool:
    """Return whether a word is a number with something behind it.

    Examples
    --------
    >>> has_unit("150um"), has_unit("1e-3"), has_unit("um")
    (True, False, False)
    """
    found = _WORD.fullmatch(word)
    return found is not None and found["unit"] is not None


def split_unit(word: str) -> tuple[str, str]:
    """Return the number and the unit of a word, the unit empty where there is none.

    Examples
    --------
    >>> split_unit("-150 um"), split_unit("3"), split_unit("three")
    (('-150', 'um'), ('3', ''), ('three', ''))
    """
    found = _WORD.fullmatch(word)
    return (found["number"], found["unit"] or "") if found else (word, "")


def _plain(unit: str) -> str:
    """Return a unit without blanks and points, the micro sign and its Greek twin as u."""
    plain = unit.replace("\u00b5", "u").replace("\u03bc", "u").replace("\u00b7", " ")
    return re.sub(r"[\s*]+", "", plain)
