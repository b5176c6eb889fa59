"""The program: read the words, run the command, answer, and say with a number how it went."""

from __future__ import annotations

import errno
import sys
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from importlib.metadata import version
from typing import Literal, TextIO, get_args, get_origin

from cyclopts import (
    App,
    Argument,
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    Token,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
    ValidationError,
)
from rich.console import Console

from rotor_ida.checks import shown
from rotor_ida.cli.commands.compute import (
    atlas,
    basin,
    fractions,
    reproduce,
    response,
    run_up,
    run_ups,
    simulate,
    sweep,
    touchdown,
)
from rotor_ida.cli.commands.cycles import continue_, curve, cycle
from rotor_ida.cli.commands.doctor import doctor
from rotor_ida.cli.commands.explore import explore
from rotor_ida.cli.commands.fit import fit
from rotor_ida.cli.commands.machine import machine
from rotor_ida.cli.commands.plot import plot
from rotor_ida.cli.commands.stored import compare, resume, show, status, verify
from rotor_ida.cli.parsing import as_given, readable, refuse_units
from rotor_ida.cli.report import FAILED, INTERRUPTED, Report, console_on, text_of
from rotor_ida.cli.streams import results_only
from rotor_ida.errors import InputError, RotorError

HELP = """Rotors in clearances: Hertz contact, event by event, held against closed forms.

Results go to standard output, everything else to standard error.
Exit status: 0 done, 1 the run or the check failed, 2 bad input.
"""
DONE, BAD_INPUT, PIPE_CLOSED = 0, 2, 141


def main(words: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    words : sequence of str, optional
        The words after the program's name; those of the process by default.

    Returns
    -------
    int
        0 done, 1 the run or the check failed, 2 bad input, 130 interrupted, 141 if the reader
        of the results went away.

    Examples
    --------
    >>> main(["simulate", "--omega", "nan"])
    2
    """
    with results_only() as results:
        try:
            return _run(list(sys.argv[1:] if words is None else words), results)
        except BrokenPipeError:
            return PIPE_CLOSED
        except CycloptsError as error:
            return _complain(misread(error), BAD_INPUT)
        except KeyboardInterrupt as error:
            return _complain(str(error) or "interrupted", INTERRUPTED)
        except MemoryError:
            return _complain("not enough memory for this much data", FAILED)
        except (RotorError, OSError) as error:
            said = str(error)
            if isinstance(error, OSError) and error.strerror:
                where = error.filename or "standard output"
                closed = error.errno == errno.EBADF and not error.filename
                said = f"{where}: {'closed' if closed else error.strerror}"
            return _complain(said, BAD_INPUT if isinstance(error, InputError) else FAILED)


def application(console: Console) -> App:
    """Return the commands, with their help going to `console`."""
    app = App(
        name="rotor-ida",
        help=HELP,
        help_format="plaintext",
        version=version("rotor-ida"),
        console=console,
    )
    computing = (
        *(simulate, run_up, run_ups, response, sweep, basin, fractions, atlas, touchdown),
        *(cycle, continue_, curve),
    )
    archived = (status, resume, compare, verify, show)
    for command in (reproduce, machine, *computing, explore, *archived, plot, fit, doctor):
        app.command(command)
    app.register_install_completion_command(
        help="Complete commands and options with the tab key, in bash, zsh or fish."
    )
    return app


def _run(words: list[str], results: TextIO) -> int:
    console = console_on(results)
    command, bound = application(console).parse_args(
        readable(words), print_error=False, exit_on_error=False
    )[:2]
    _refuse_units(bound.arguments)
    with console.capture() as help_text:
        answer = command(*bound.args, **bound.kwargs)
    if not isinstance(answer, Report):
        _write(help_text.get(), results)
        return answer if isinstance(answer, int) else DONE
    _write(text_of(answer, console), results)
    return _complain(answer.trouble, answer.status) if answer.trouble else DONE


def _refuse_units(arguments: Mapping[str, object]) -> None:
    """Refuse units of numbers, wherever they stand, if the rotor has no dimensions."""
    values: dict[str, object] = {}
    for name, value in arguments.items():
        values |= vars(value) if is_dataclass(value) else {name: value}
    if any(getattr(value, "in_si", None) is False for value in arguments.values()):
        refuse_units(values)


def _write(text: str, results: TextIO) -> None:
    """Write all of it, so that an error of the stream is met here."""
    results.write(text)
    results.flush()


def misread(error: CycloptsError) -> str:
    """Return in one line what could not be read, in the form of this package's own messages."""
    option = "" if error.argument is None else error.argument.name
    name = option.removeprefix("--")
    match error:
        case CycloptsError(__cause__=InputError() as cause):  # from a converter of ours
            said = str(cause)
        case CoercionError(token=Token() as token, target_type=kind) if get_origin(kind) is Literal:
            choices = ", ".join(map(repr, get_args(kind)))
            said = f"{name} must be one of {choices}, got {shown(token.value)}"
        case ValidationError(argument=Argument(tokens=[Token() as token, *_])):
            bound = error.exception_message.replace(">=", "at least").replace("<=", "at most")
            said = f"{name} {bound[:1].lower()}{bound[1:].rstrip('.')}, got {token.value}"
        case UnknownOptionError(token=token):
            said = f"unknown option {shown(token.keyword or token.value)}"
        case UnusedCliTokensError(unused_tokens=[first, *_]):
            said = f"unexpected argument {shown(first)}"
        case UnknownCommandError(root_input_tokens=[first, *_]):
            said = f"unknown command {shown(first)}: see rotor-ida --help"
        case MissingArgumentError() if option:
            words = "" if error.argument is None else error.argument.parameter.metavar or ""
            said = _missing(option, words, error.unused_tokens or [], error.tokens_so_far)
        case _:
            error.verbose = False
            said = f"{error}".rstrip(".")
            said = said[:1].lower() + said[1:]
    return as_given(said)


def _missing(option: str, words: str, unused: Sequence[str], given: Sequence[str]) -> str:
    """Return in one line what an option lacks; one that is misspelt is the likelier cause."""
    misspelt = [word for word in unused if word.startswith("--")]
    if misspelt and option not in unused:
        return f"unknown option {shown(misspelt[0])}"
    if given:  # it has several values
        number = {2: "two", 4: "four"}[len(words.split())]
        kind = "names" if "NAME" in words else "numbers"
        return f"{option.removeprefix('--')} must be {number} {kind} {words}, got {len(given)}"
    return f"{option} must be given a value"


def _complain(message: str, status: int) -> int:
    if sys.stderr is not None:
        # one line, in which the name of a file keeps its blanks
        print("rotor-ida:", " ".join(map(str.strip, message.splitlines())), file=sys.stderr)
    return status
