"""Reports of commands: a record for programs, lines and tables for people."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TextIO

from rich.console import Console

from rotor_ida.results.sheets import Sheet
from rotor_ida.texts import plain, printable
from rotor_ida.units import UnitSystem

FAILED, INTERRUPTED = 1, 130
# Wide enough to avoid line breaks when the output is a file or a pipe, unless COLUMNS is set.
NO_TERMINAL_WIDTH = 10_000
# Rows of a table of a whole run or archive; all are printed with --json.
FIRST_ROWS = 10

Record = Mapping[str, object]


@dataclass(frozen=True, kw_only=True)
class Report:
    """The answer of a command.

    The record is for programs (what JSON can hold, and NaN), the parts are for people, in a system
    of units. Trouble, if the run or the check failed, is one line for standard error, with its
    exit status.
    """

    record: Record
    parts: Sequence[str | Sheet]
    as_json: bool = False
    trouble: str = ""
    system: UnitSystem = "metric"
    status: int = FAILED


def console_on(stream: TextIO) -> Console:
    """Return a console without markup or highlighting."""
    return Console(file=stream, highlight=False, markup=False, emoji=False)


def text_of(report: Report, console: Console) -> str:
    """Return the text of a report.

    rich does not write it: it would end the program when the reader of a pipe closes.
    """
    if report.as_json:
        return json.dumps(plain(report.record), allow_nan=False, indent=2) + "\n"
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = NO_TERMINAL_WIDTH
    with console.capture() as shown:
        for part in report.parts:
            console.print(
                printable(part)
                if isinstance(part, str)
                else part.text(console.width, report.system)
            )
    return shown.get()
