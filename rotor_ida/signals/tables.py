"""Columns of numbers in CSV, WAV and MATLAB files, by name."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError

# Lines before the numbers in which instruments tell about themselves.
MOST_HEAD = 200
_UNIT = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
Columns = dict[str, tuple[Values, str]]


def read_table(path: Path) -> Columns:
    """Return the columns of a file by their names, each with its unit, empty where not told."""
    if not path.is_file():
        raise InputError(f"path must be a file that exists, got {shown(path)}")
    readers = {".wav": _read_wav, ".mat": _read_mat}
    try:
        return readers.get(path.suffix.lower(), _read_csv)(path)
    except OSError as error:
        raise InputError(f"{shown(path)} cannot be read: {error.strerror or error}") from error


def _read_csv(path: Path) -> Columns:
    """Return the columns of text with commas, semicolons, tabs or blanks between numbers."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{shown(path)} must be text in UTF-8, a .wav or a .mat file") from None
    kept = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    separator, first = _first_numbers(kept, path)
    width = len(_cells(kept[first], separator))
    head = [_cells(line, separator) for line in kept[:first]]
    names, units = _names(head, width)
    decimal = separator == ";" and any("," in cell for cell in _cells(kept[first], separator))
    body = [line.replace(",", ".") for line in kept[first:]] if decimal else kept[first:]
    try:
        numbers = np.loadtxt(body, delimiter=separator, ndmin=2, comments=None)
    except ValueError:
        raise _bad_line(body, separator, width, path) from None
    return {
        name: (np.ascontiguousarray(column), unit)
        for name, column, unit in zip(names, numbers.T, units, strict=True)
    }


def _first_numbers(lines: Sequence[str], path: Path) -> tuple[str | None, int]:
    """Return what separates the columns, None for blanks, and which line has the first numbers."""
    for number, line in enumerate(lines[:MOST_HEAD]):
        for separator in (";", "\t", ",", None):
            cells = _cells(line, separator)
            plain = [cell.replace(",", ".") if separator == ";" else cell for cell in cells]
            if len(cells) > 1 and all(_is_number(cell) for cell in plain):
                return separator, number
    raise InputError(f"{shown(path)} must hold lines of two numbers or more, got none")


def _names(head: Sequence[Sequence[str]], width: int) -> tuple[list[str], list[str]]:
    """Return names and units of the columns; without a line of names they are numbered from 1."""
    fitting = [cells for cells in head if len(cells) == width]
    units = [""] * width
    if len(fitting) > 1 and fitting[-1] and head[-2:] == fitting[-2:] and all(
        cell.strip("[]() ") in UNITS for cell in fitting[-1]
    ):  # fmt: skip
        units = [cell.strip("[]() ") for cell in fitting.pop()]
    names = list(fitting[-1]) if fitting else [str(number + 1) for number in range(width)]
    for place, name in enumerate(names):
        if found := _UNIT.match(name):
            names[place], units[place] = found[1], found[2]
    if len(set(names)) < width:
        raise InputError(f"the columns must have names that differ, got {', '.join(names)}")
    return names, units


def _bad_line(lines: Sequence[str], separator: str | None, width: int, path: Path) -> InputError:
    """Return the error for the first line that is not so many numbers."""
    for number, line in enumerate(lines, 1):
        cells = _cells(line, separator)
        if len(cells) != width or not all(_is_number(cell) for cell in cells):
            return InputError(
                f"line {number} of the numbers in {shown(path)} must be {width} numbers, got "
                f"{shown(line)}"
            )
    return InputError(f"{shown(path)} must hold lines of numbers")


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip().strip('"') for cell in line.strip().split(separator)]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _read_wav(path: Path) -> Columns:
    """Return the channels of a sound file, numbered from 1, and ``t``; whole numbers as of 1."""
    from scipy.io import wavfile  # noqa: PLC0415 - takes long to import

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(path)
    except (ValueError, EOFError) as error:
        raise InputError(f"{shown(path)} must be a WAV file: {error}") from error
    table = np.asarray(samples, dtype=np.float64).reshape(len(samples), -1)
    if samples.dtype == np.uint8:
        table = (table - 128.0) / 128.0
    elif samples.dtype.kind == "i":
        table = table / 2.0 ** (8 * samples.dtype.itemsize - 1)
    columns: Columns = {"t": (np.arange(len(table)) / rate, "s")}
    for number, channel in enumerate(table.T, 1):
        columns[str(number)] = (np.ascontiguousarray(channel), "")
    return columns


def _read_mat(path: Path) -> Columns:
    """Return the vectors of numbers in a MATLAB file."""
    from scipy.io import loadmat  # noqa: PLC0415 - takes long to import

    try:
        held = loadmat(path, squeeze_me=True)
    except NotImplementedError as error:
        raise InputError(
            f"{shown(path)} must be a MATLAB file up to version 7: save it with -v7"
        ) from error
    except (ValueError, TypeError, EOFError) as error:
        raise InputError(f"{shown(path)} must be a MATLAB file: {error}") from error
    return {
        name: (np.asarray(values, dtype=np.float64), "")
        for name, values in held.items()
        if isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "iuf"
    }


# Units that are known: what they are of, as UDUNITS writes them, and how many of these one is.
UNITS = {
    **{name: ("time", "s", each) for name, each in (
        ("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("min", 60.0))},
    **{name: ("angle", "radian", each) for name, each in (
        ("rad", 1.0), ("radian", 1.0), ("deg", np.pi / 180.0), ("°", np.pi / 180.0),
        ("degree", np.pi / 180.0), ("rev", 2.0 * np.pi))},
    **{name: ("length", unit, each) for name, unit, each in (
        ("m", "m", 1.0), ("mm", "mm", 1.0), ("um", "um", 1.0), ("µm", "um", 1.0), ("μm", "um", 1.0),
        ("nm", "nm", 1.0), ("in", "mm", 25.4), ("mil", "um", 25.4), ("mils", "um", 25.4),
        ("V", "V", 1.0), ("mV", "mV", 1.0))},
    "1": ("any", "1", 1.0), "": ("any", "1", 1.0),
}  # fmt: skip
