"""The command line: results on standard output, everything else on standard error."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Sequence

from rotor_ida.blas import one_thread

__all__ = ["main"]


def main(words: Sequence[str] | None = None) -> int:
    """Run one command, as `rotor_ida.cli.program.main` does, with early and late interrupts."""
    try:
        with one_thread():
            from rotor_ida.cli import program  # noqa: PLC0415 - takes a moment

            status = program.main(words)
        if words is None and threading.current_thread() is threading.main_thread():
            # the work of the process is done, so an interrupt comes too late
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        return status
    except KeyboardInterrupt:
        print("rotor-ida: interrupted", file=sys.stderr)
        return 130
