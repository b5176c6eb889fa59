"""Times of day and dates in text tables, as seconds since the first."""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Sequence

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError

_DATE = re.compile(r"\d{1,4}[-./]\d{1,2}[-./]\d{1,4}", re.ASCII)
# 12:03:04.5, perhaps with a date before it, and PM, Z or +01:00 after it.
_CLOCK = re.compile(
    rf"(?:(?P<date>{_DATE.pattern})[T ] *)?"
    r"(?P<hour>\d{1,3}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d)(?:[.,](?P<part>\d{1,9})\d*)?"
    r"(?: ?(?P<half>[AP])M)?(?P<zone>Z|[+-]\d\d:?\d\d)?",
    re.ASCII | re.IGNORECASE,
)
_SECOND = 10**9  # in nanoseconds
_DAY = 86_400 * _SECOND


def is_clock(cell: str) -> bool:
    """Return whether a cell is a time of day, perhaps with its date."""
    return ":" in cell and _CLOCK.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Return whether a cell is a date without a time."""
    return _DATE.fullmatch(cell) is not None


def seconds_of(cells: Sequence[str]) -> Values:
    """Return times of day in seconds since the first; NaN where a cell is none.

    Without a date, a time that falls by more than half a day belongs to the next day. Of a date
    such as 01/02/2024 it is not known which number is the month, so it may not change.

    Examples
    --------
    >>> seconds_of(["23:59:59.5", "0:00:00.25"])
    array([0.  , 0.75])
    >>> seconds_of(["2024-02-28T12:00:00Z", "2024-02-29 12:00:00.5", "noon"])
    array([    0. , 86400.5,     nan])
    """
    found = [_CLOCK.fullmatch(cell) for cell in cells]
    _check_dates(found)
    times: list[float] = []
    first: int | None = None
    before, midnights = 0, 0
    for each in found:
        day = _day(each["date"]) if each else None
        if each is None or day is None:
            times.append(math.nan)
            continue
        now = _of_day(each)
        if each["date"] is None:
            midnights += now < before - _DAY // 2
            before = now
        now += (day + midnights) * _DAY
        first = now if first is None else first
        times.append((now - first) / _SECOND)
    return np.array(times)


def _of_day(clock: re.Match[str]) -> int:
    """Return a time of day in whole nanoseconds, so that differences are exact."""
    hour, zone = int(clock["hour"]), clock["zone"] or "Z"
    if clock["half"]:
        hour = hour % 12 + 12 * (clock["half"] in "Pp")
    minutes = 60 * hour + int(clock["minute"])
    if zone not in "Zz":
        offset = 60 * int(zone[1:3]) + int(zone[-2:])
        minutes -= offset if zone[0] == "+" else -offset
    part = int((clock["part"] or "").ljust(9, "0"))
    return (60 * minutes + int(clock["second"])) * _SECOND + part


def _check_dates(clocks: Sequence[re.Match[str] | None]) -> None:
    """Raise `InputError` for dates that change and have no known month."""
    dates = list(dict.fromkeys(each["date"] for each in clocks if each and each["date"]))
    unknown = [each for each in dates if not _is_known(each)]
    if unknown and len(dates) > 1:
        raise InputError(
            f"dates that change must be such as 2024-02-28 or 28.02.2024, got {shown(unknown[0])}"
        )


def _is_known(date: str) -> bool:
    """Return whether it is known which number of a date is the month."""
    return "." in date or date[:4].isdecimal()


def _day(text: str | None) -> int | None:
    """Return the number of a date, 0 where it does not matter; None if there is no such date."""
    if text is None or not _is_known(text):
        return 0
    one, two, three = (int(each) for each in re.split("[-./]", text))
    year_first = text[:4].isdecimal()
    try:
        return datetime.date(*((one, two, three) if year_first else (three, two, one))).toordinal()
    except ValueError:
        return None
