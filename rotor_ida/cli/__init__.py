"""The command line: results on standard output, everything else on standard error."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence

__all__ = ["main"]


def main(words: Sequence[str] | None = None) -> int:
    """Run one command, as `rotor_ida.cli.program.main` does, with early and late interrupts."""
    try:
        from rotor_ida.cli import program  # noqa: PLC0415 - takes a moment

        status = program.main(words)
        if words is None:  # of a process: its work is done, so an interrupt comes too late
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        return status
    except KeyboardInterrupt:
        print("rotor-ida: interrupted", file=sys.stderr)
        return 130
