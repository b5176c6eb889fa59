"""The command line: results on standard output, everything else on standard error."""

from rotor_ida.cli.program import main

__all__ = ["main"]
