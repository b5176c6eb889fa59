"""A progress bar, if someone is there to see it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext


def progress(name: str) -> AbstractContextManager[Callable[[int, int], None] | None]:
    """Show a bar on standard error while the context lasts; nothing if that is no terminal."""
    from rotor_ida.paper.scenario import progress_bar  # noqa: PLC0415 - heavy, and not for --help

    if sys.stderr is None or not sys.stderr.isatty():
        return nullcontext()
    return progress_bar(name)
