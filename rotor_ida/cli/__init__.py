"""The command line: results on standard output, everything else on standard error."""

from __future__ import annotations

import sys
from collections.abc import Sequence

__all__ = ["main"]


def main(words: Sequence[str] | None = None) -> int:
    """Run one command, as `rotor_ida.cli.program.main` does; also catch an early interrupt."""
    try:
        from rotor_ida.cli import program  # noqa: PLC0415 - takes a moment

        return program.main(words)
    except KeyboardInterrupt:
        print("rotor-ida: interrupted", file=sys.stderr)
        return 130
