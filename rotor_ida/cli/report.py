"""What a command answers, and how it is put on standard output."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TextIO

from rich.console import Console, RenderableType

FAILED, INTERRUPTED = 1, 130
# Wide enough that no number is ever cut when the output is a file or a pipe.
NO_TERMINAL_WIDTH = 10_000


@dataclass(frozen=True, kw_only=True)
class Report:
    """The answer of a command.

    Parameters
    ----------
    record : mapping
        The answer for programs: what JSON can hold, and NaN.
    parts : sequence of renderable
        The answer for people: lines and tables.
    as_json : bool
        Which of the two is wanted.
    trouble : str
        One line for standard error if the run or the check failed.
    status : int
        The exit status if there is trouble.
    """

    record: Mapping[str, object]
    parts: Sequence[RenderableType]
    as_json: bool = False
    trouble: str = ""
    status: int = FAILED


def console_on(stream: TextIO) -> Console:
    """Return a console that shows words as they are."""
    return Console(file=stream, highlight=False, markup=False, emoji=False)


def text_of(report: Report, console: Console) -> str:
    """Return what is to be printed of a report.

    rich writes nothing itself: it would end the program when the reader of a pipe goes away.
    """
    if report.as_json:
        return json.dumps(plain(report.record), allow_nan=False, indent=2) + "\n"
    if not console.is_terminal:
        console.width = NO_TERMINAL_WIDTH
    with console.capture() as shown:
        for part in report.parts:
            console.print(part)
    return shown.get()


def plain(value: object) -> object:
    """Return what JSON can hold; a number that is not finite becomes null.

    Examples
    --------
    >>> plain({"exit_time": float("nan"), "start": (1, 0.5)})
    {'exit_time': None, 'start': [1, 0.5]}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
