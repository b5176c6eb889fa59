"""A progress bar for many jobs, or lines without a terminal, with the remaining time."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

# Interval between lines where there is no terminal [s].
TOLD_EVERY = 30.0


class _RateColumn(ProgressColumn):
    """Points per second."""

    def render(self, task: Task) -> Text:
        rate = task.finished_speed or task.speed
        return Text("" if rate is None else f"{rate:.3g}/s")


@contextmanager
def progress_bar(description: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar on standard error.

    Yields
    ------
    callable
        Takes the number of points done and their total, as called by `rotor_ida.sweep`.
    """
    columns = (
        *(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), _RateColumn()),
        *(TimeElapsedColumn(), TextColumn("elapsed,"), TimeRemainingColumn(), TextColumn("left")),
    )
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(description, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def progress_lines(description: str) -> Iterator[Callable[[int, int], None]]:
    """Write a line to standard error every half a minute, where there is no terminal.

    Yields
    ------
    callable
        Takes the number of points done and their total, as `progress_bar` yields.
    """
    begun, reached, ended = time.monotonic(), [0, 0], threading.Event()

    def report(done: int, total: int) -> None:
        reached[:] = done, total

    def write() -> None:
        while not ended.wait(TOLD_EVERY):
            done, total = reached
            left = (time.monotonic() - begun) * (total - done) / done if done else math.nan
            also = "" if math.isnan(left) else f", about {left:.0f} s left"
            said = f"{done} of {total}{also}" if total else "nothing done so far"
            if sys.stderr is not None:
                print(f"{description}: {said}", file=sys.stderr, flush=True)

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    try:
        yield report
    finally:
        ended.set()
        writer.join()
