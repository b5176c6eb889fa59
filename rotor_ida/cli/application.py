"""The table of commands."""

from __future__ import annotations

from importlib.metadata import version

from cyclopts import App
from rich.console import Console

from rotor_ida.cli.commands.archived import show
from rotor_ida.cli.commands.basins import basin
from rotor_ida.cli.commands.compared import compare
from rotor_ida.cli.commands.doctor import doctor
from rotor_ida.cli.commands.fractions import fractions
from rotor_ida.cli.commands.reproduced import reproduce
from rotor_ida.cli.commands.response import response
from rotor_ida.cli.commands.resumed import resume
from rotor_ida.cli.commands.simulated import simulate
from rotor_ida.cli.commands.status import status
from rotor_ida.cli.commands.swept import sweep
from rotor_ida.cli.commands.verified import verify

HELP = """Rotors in clearances: Hertz contact, event by event, held against closed forms.

Results go to standard output, everything else to standard error.
Exit status: 0 done, 1 the run or the check failed, 2 bad input.
"""


def application(console: Console) -> App:
    """Return the commands, with their help going to `console`."""
    app = App(
        name="rotor-ida",
        help=HELP,
        help_format="plaintext",
        version=version("rotor-ida"),
        console=console,
    )
    computing = (simulate, response, sweep, basin, fractions)
    archived = (status, resume, compare, verify, show)
    for command in (reproduce, *computing, *archived, doctor):
        app.command(command)
    return app
