"""Guess from names which column of a file is the time, a probe, the keyphasor or the speed."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import listed, shown
from rotor_ida.errors import InputError
from rotor_ida.signals.files.columns import (
    DIFFERENT_RATE,
    Column,
    Table,
    name_and_unit,
    unit_called,
)

KIND = {
    "t": "time", "x": "length", "y": "length",
    "keyphasor": "time", "angle": "angle", "speed": "speed",
}  # fmt: skip
# Words that identify a column, the surest first. All but t serve for the angle of the rotor; the
# first of these in a file is taken.
WORDS = {
    "t": ("t", "time", "times", "zeit", "seconds", "timestamp", "x value"),
    "angle": ("angle", "theta", "winkel", "drehwinkel"),
    "keyphasor": (
        *("keyphasor", "key", "kph", "kp", "tacho", "tachometer", "tach"),
        *("trigger", "trig", "pulses", "pulse", "3", "drehzahlimpuls", "impuls", "nullimpuls"),
    ),
    "speed": ("speed", "rpm", "omega", "drehzahl"),
    "phase": ("phase",),
}
ANGLES = ("angle", "keyphasor", "speed", "phase")
# Words in which the names of the first and of the second probe differ.
PAIRS = (
    *(("x", "y"), ("a", "b"), ("1", "2"), ("0", "1"), ("h", "v")),
    *(("horizontal", "vertical"), ("horiz", "vert"), ("horz", "vert"), ("hor", "ver")),
)
AXES = {"x", "y", "z", "h", "v"}
# Words for the side of the vertical on which a probe is, beside which another word may differ.
SIDES = (("r", "l"), ("right", "left"), ("rechts", "links"))
RIGHT, LEFT = ({pair[side] for pair in SIDES} for side in (0, 1))
# Words for the quantities that probes measure.
PROBE_WORDS = {
    *("probe", "disp", "displacement", "prox", "proximity", "vib", "vibration", "sonde"),
    *("wellenschwingung", "schwingung", "weg"),
}
# Units that may also be words of a name.
NO_SUFFIX = {"in", "1", "-", ""}
# Names of the sampling rate [Hz].
RATES = {
    *("fs", "rate", "fsample", "samplerate", "samplefreq", "samplefrequency"),
    *("samplingrate", "samplingfrequency", "samplingfreq"),
}
# Columns of which each pair is looked at.
MOST_GUESSED = 1000
_SPLIT = re.compile(
    r"(?<=[a-z])(?=[A-Z])|(?<=[^\W\d_])(?=\d)|(?<=\d)(?=[^\W\d_])|[\W_]+"
)  # fmt: skip


@dataclass(frozen=True)
class Name:
    """The parsed name of a column.

    Parameters
    ----------
    column : str
        The name as the file has it.
    words : tuple of str
        Its words in lower case, less the unit.
    unit : str
        The unit given by the file, otherwise the last word if that is a unit.
    is_suffix : bool
        Whether the unit is the last word.
    """

    column: str
    words: tuple[str, ...]
    unit: str
    is_suffix: bool

    @property
    def last(self) -> tuple[str, ...]:
        """The words of the last part of the name: those of x in ``record.x``."""
        part, known = _words(self.column.rpartition(".")[2]), {*self.words}
        return tuple(word for word in part if word in known) or self.words

    @property
    def kind(self) -> str:
        """Quantity of the unit: empty if there is no unit, "?" if it is not known."""
        known = unit_called(self.unit)
        if known is None:
            return "?"
        return "" if known.kind == "any" else known.kind


def name_of(column: str, unit: str = "") -> Name:
    """Parse the name of a column.

    Examples
    --------
    >>> name_of("probe_A_um").words, name_of("probe_A_um").unit
    (('probe', 'a'), 'um')
    """
    bare, bracketed = name_and_unit(column)
    if bracketed in NO_SUFFIX:
        bare, bracketed = column, ""  # probe (1) is the first of its name
    if unit or bracketed:
        return Name(column, _words(bare), unit or bracketed, is_suffix=False)
    pieces = re.split(r"[\s_.\-]+", bare.strip())
    for count in (2, 1):  # rad_s before s
        last = "/".join(pieces[-count:])
        if len(pieces) >= count and last not in NO_SUFFIX and unit_called(last) is not None:
            return Name(column, _words(" ".join(pieces[:-count])), last, is_suffix=True)
    return Name(column, _words(bare), "", is_suffix=False)


def unit_of(signal: str, columns: Mapping[str, str], table: Table) -> str:
    """Return the unit of a signal's column: that of the file, or the last word of its name.

    The last word counts only if it is a unit of the right kind, for a probe only if both have one:
    ``probe_V`` beside ``probe_H`` is the vertical one.
    """
    name = name_of(columns[signal], table.columns[columns[signal]].unit)
    if not name.is_suffix:
        return name.unit
    both = [columns[each] for each in ("x", "y")] if signal in ("x", "y") else [columns[signal]]
    kinds = {name_of(each, table.columns[each].unit).kind for each in both}
    return name.unit if kinds == {KIND[signal]} else table.columns[columns[signal]].unit


def columns_of(table: Table, told: Mapping[str, str], *, timed: bool) -> dict[str, str]:
    """Return the column of each signal, as given or guessed.

    Parameters
    ----------
    table : Table
        The columns of a file.
    told : mapping of str to str
        Columns by signal, as given by the user.
    timed : bool
        Whether the times are known without a column.

    Raises
    ------
    InputError
        If a column is missing or ambiguous. The message lists the columns.
    """
    told = {
        signal: column if column in table.columns else name_and_unit(column)[0]
        for signal, column in told.items()
    }
    for signal, column in told.items():
        if column not in table.columns:
            raise InputError(
                f"the file must have the column {shown(column)} for {signal}, got "
                f"{shown(table.listed())}"
            )
    several = [column for column, count in Counter(told.values()).items() if count > 1]
    if several:
        signals = [signal for signal, column in told.items() if column == several[0]]
        raise InputError(
            f"columns must name another column for each signal, got {shown(several[0])} for "
            f"{listed(signals)}"
        )
    if all(is_number(name) for name in table.columns):
        return _by_place(table, told, timed=timed)
    names = [name_of(name, column.unit) for name, column in table.columns.items()]
    free = [name for name in names if name.column not in told.values()]
    found = dict(told)
    if "t" not in found:
        try:
            found |= _surest("t", free, table)
        except InputError:
            if not timed:
                raise
    found |= _angle_in(free, told, table)
    for signal in [each for each in ANGLES if each in found][1:]:
        del found[signal]  # one of them serves
    found |= _probes_in(names, found, table)
    return {signal: found[signal] for signal in KIND if signal in found}


def _by_place(table: Table, told: Mapping[str, str], *, timed: bool) -> dict[str, str]:
    """Return the columns of a file without names: t, x, y, keyphasor, after any sample count."""
    if ("x" in told) != ("y" in told):
        raise InputError(f"columns must name both x and y or neither, got {shown(dict(told))}")
    order = [name for name in table.columns if name not in told.values()]
    signals = [name for name in ("t", "x", "y") if name not in told]
    if not {"keyphasor", "angle", "speed"} & told.keys():
        signals.append("keyphasor")
    counted = bool(order) and "t" in signals and counts_samples(table.columns[order[0]].values)
    if counted:
        rises = len(order) > 1 and increases(table.columns[order[1]].values)
        if not rises and not timed:
            raise InputError(
                f"the file must have a column for t, but column {order[0]} counts samples (0, 1, 2 "
                "...); name t in columns, or give rate, got neither"
            )
        order = order[1:]
    if timed and "t" in signals and not (order and increases(table.columns[order[0]].values)):
        signals.remove("t")
        if not (counted or {"x", "y"} <= told.keys()):
            raise InputError(
                "the file must have names, or times before x and y, as nothing tells its columns "
                f"apart; name x and y in columns, got {shown(table.listed())}"
            )
    found = {**told, **dict(zip(signals, order, strict=False))}
    guessed = found.get("keyphasor") if "keyphasor" not in told else None
    if guessed and np.ptp(table.columns[guessed].values) == 0.0:
        del found["keyphasor"]  # what never changes has no pulses
    for signal in ("x", "y"):
        if signal not in found:
            raise InputError(
                f"the file must have a column for {signal}; name it in columns, got "
                f"{shown(table.listed())}{_option([signal])}"
            )
    return {signal: found[signal] for signal in KIND if signal in found}


def counts_samples(values: Values) -> bool:
    """Return whether numbers are 0, 1, 2 ... or 1, 2, 3 ...

    Examples
    --------
    >>> counts_samples(np.arange(1.0, 9.0)), counts_samples(np.arange(8) / 1000.0)
    (True, False)
    """
    return bool(
        values.size > 1 and values[0] in (0.0, 1.0) and (np.diff(values) == 1.0).all()
    )  # fmt: skip


def count_left_out(table: Table, names: Mapping[str, str]) -> str:
    """Return the unnamed column that counts samples and is not a signal; empty if none does."""
    first = next(iter(table.columns))
    is_count = is_number(first) and counts_samples(table.columns[first].values)
    return first if is_count and first not in names.values() else ""


def is_number(name: str) -> bool:
    """Return whether a name is the number of a column without a name."""
    return name.isascii() and name.isdigit()


def increases(values: Values) -> bool:
    """Return whether numbers increase."""
    return bool((np.diff(values) > 0.0).all())


def rate_in(table: Table) -> tuple[str, float] | None:
    """Return the name and the value of the sampling rate [Hz], if there is just one."""
    found = {
        name: value
        for name, value in table.scalars.items()
        if "".join(_words(name.rpartition(".")[2])) in RATES and value > 0.0
    }
    return next(iter(found.items())) if len(set(found.values())) == 1 else None


def _words(name: str) -> tuple[str, ...]:
    """Return the words of a name in lower case; numbers are words."""
    return tuple(word.lower() for word in _SPLIT.split(name) if word)


def _surest(signal: str, names: Iterable[Name], table: Table) -> dict[str, str]:
    """Return the column that is a signal by its words, if there is one."""
    ranked = sorted(
        (rank, name.column) for name in names if (rank := _rank(signal, name)) is not None
    )
    if len(ranked) > 1 and ranked[0][0] == ranked[1][0]:
        several = [column for rank, column in ranked if rank == ranked[0][0]]
        raise InputError(
            f"the column of {signal} must be unambiguous; name it in columns, got "
            f"{shown(', '.join(several))} among {shown(table.listed())}{_option([signal])}"
        )
    return {signal: ranked[0][1]} if ranked else {}


def _rank(signal: str, name: Name) -> float | None:
    """Return the rank of a column as a signal, the best first; None if it is not."""
    kind = KIND.get(signal, "angle")
    if name.kind == "speed" != kind or (
        kind in ("time", "angle", "speed") and signal != "keyphasor"
        and name.kind not in (kind, "", "?")
    ):  # fmt: skip
        return None
    if not name.words and name.is_suffix:  # a column that is called s, or rpm
        return 100.0 if name.kind == kind and signal in ("t", "speed") else None
    wholes = {" ".join(name.words), " ".join(name.last)}
    for place, word in enumerate(WORDS[signal]):
        if word in wholes:
            return float(place)
        if word in name.words and len(word) > 1:
            return place + 0.5
    return 50.0 if signal == "speed" == name.kind else None


def _angle_in(names: Sequence[Name], told: Mapping[str, str], table: Table) -> dict[str, str]:
    """Return the column for the angle of the rotor, unless one was given."""
    if {"keyphasor", "angle", "speed"} & told.keys():
        return {}
    for signal in ANGLES:
        if found := _surest(signal, names, table):
            return {"angle" if signal == "phase" else signal: found[signal]}
    return {}


def _probes_in(names: Sequence[Name], taken: Mapping[str, str], table: Table) -> dict[str, str]:
    """Return the columns of the probes: the one pair of names that differ as x and y do."""
    if {"x", "y"} <= taken.keys():
        return {}
    if len(names) > MOST_GUESSED:
        raise InputError(
            f"columns must name x and y among more than {MOST_GUESSED} columns, got {len(names)} "
            "and no names"
        )
    others = {column for signal, column in taken.items() if signal not in ("x", "y")}
    pairs = [
        (first, second)
        for first, second in permutations([each for each in names if each.column not in others], 2)
        if taken.get("x", first.column) == first.column
        and taken.get("y", second.column) == second.column
        and _are_pair(first, second)
        and _has_one_rate(table.columns[first.column], table.columns[second.column])
    ]
    if pairs:
        # of channels at several rates those that are sampled faster
        ranks = [
            (*_rank_of_pair(pair), float(f"{table.columns[pair[0].column].step:.3g}"))
            for pair in pairs
        ]
        best = [pair for pair, rank in zip(pairs, ranks, strict=True) if rank == min(ranks)]
        if len(best) == 1:
            return {"x": best[0][0].column, "y": best[0][1].column}
        several = "; ".join(f"{first.column} and {second.column}" for first, second in best)
        raise InputError(
            f"the columns of x and y must be unambiguous; name them in columns, got "
            f"{shown(several)} among {shown(table.listed())}{_option(['x', 'y'])}"
        )
    plain = {each.words: each.column for each in names if each.column not in others}
    found = {axis: plain[axis,] for axis in ("x", "y") if axis not in taken and (axis,) in plain}
    missing = [axis for axis in ("x", "y") if axis not in taken and axis not in found]
    if missing:
        each = "it" if len(missing) == 1 else "them"
        raise InputError(
            f"the file must have a column for {' and '.join(missing)}; name {each} in columns, got "
            f"{shown(table.listed())}{_option(missing)}"
        )
    return found


def _option(signals: Sequence[str]) -> str:
    """Return the option of the command line that names columns, for the end of a message."""
    return f" (--columns {' '.join(f'{each}=NAME' for each in signals)})"


def _are_pair(first: Name, second: Name) -> bool:
    """Return whether two names differ in one word, as those of a first and a second probe do."""
    if (first.is_suffix and first.unit) != (second.is_suffix and second.unit):
        first, second = _whole(first), _whole(second)
    if len(first.words) != len(second.words):
        return False
    apart = [pair for pair in zip(first.words, second.words, strict=True) if pair[0] != pair[1]]
    if None not in map(_angle_in_name, (first.words, second.words)):  # 45R and 45L
        apart = [pair for pair in apart if pair not in SIDES] or [("a", "b")]
    if len(apart) != 1 or apart[0] not in PAIRS:
        return False
    # probes x1 and x2 are in two planes
    return apart[0][0] in AXES or not AXES & {*first.words, *second.words}


def angles_in(x: str, y: str) -> tuple[float, float] | None:
    """Return the angles from the x axis [degree] of two probes by the names of their columns.

    Examples
    --------
    >>> angles_in("Probe A 45R (V)", "Probe B 45L (V)"), angles_in("probe 1", "probe 2")
    ((45.0, 135.0), None)
    """
    first, second = (_angle_in_name(name_of(each).words) for each in (x, y))
    return None if first is None or second is None else (first, second)


def _angle_in_name(words: Sequence[str]) -> float | None:
    """Return the angle of a probe in a name such as 45R: 45 degrees to the right of vertical."""
    for number, side in pairwise(words):
        if number.isdecimal() and len(number) <= 3 and side in RIGHT | LEFT:
            return 90.0 - float(number) if side in RIGHT else 90.0 + float(number)
    return None


def _has_one_rate(first: Column, second: Column) -> bool:
    """Return whether two channels have one sampling rate."""
    return abs(first.step - second.step) <= DIFFERENT_RATE * first.step


def _whole(name: Name) -> Name:
    """Return the name with its last word as a word, not a unit, such as v for vertical."""
    return Name(name.column, _words(name.column), "", is_suffix=False) if name.is_suffix else name


def _rank_of_pair(pair: tuple[Name, Name]) -> tuple[bool, bool, bool]:
    """Return the rank of a pair of columns as the probes, the best first."""
    kinds = {each.kind for each in pair}
    are_plain = (pair[0].last, pair[1].last) == (("x",), ("y",))
    about = {*pair[0].words, *pair[1].words} & PROBE_WORDS
    return (
        not kinds <= {"length", ""},
        not (are_plain or kinds == {"length"}),
        not (are_plain or about),
    )
