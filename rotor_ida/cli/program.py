"""The program: read the words, run the command, answer, and say with a number how it went."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TextIO

from cyclopts import CycloptsError

from rotor_ida.cli.application import application
from rotor_ida.cli.report import FAILED, INTERRUPTED, Report, console_on, text_of
from rotor_ida.cli.streams import results_only
from rotor_ida.errors import InputError, RotorError

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
        except (CycloptsError, RotorError, OSError, MemoryError, KeyboardInterrupt) as error:
            return _complain(_words_for(error), _status_of(error))


def _run(words: list[str], results: TextIO) -> int:
    console = console_on(results)
    command, bound = application(console).parse_args(words, print_error=False, exit_on_error=False)[
        :2
    ]
    with console.capture() as help_text:
        answer = command(*bound.args, **bound.kwargs)
    if not isinstance(answer, Report):
        _write(help_text.get(), results)
        return answer if isinstance(answer, int) else DONE
    _write(text_of(answer, console), results)
    return _complain(answer.trouble, answer.status) if answer.trouble else DONE


def _write(text: str, results: TextIO) -> None:
    """Write all of it, so that an error of the stream is met here."""
    results.write(text)
    results.flush()


def _status_of(error: BaseException) -> int:
    if isinstance(error, (CycloptsError, InputError)):
        return BAD_INPUT
    return INTERRUPTED if isinstance(error, KeyboardInterrupt) else FAILED


def _words_for(error: BaseException) -> str:
    if isinstance(error, CycloptsError):
        return _misread(error)
    if isinstance(error, KeyboardInterrupt):
        return str(error) or "interrupted"
    if isinstance(error, MemoryError):
        return "not enough memory for this much data"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename or 'standard output'}: {error.strerror}"
    return str(error)


def _misread(error: CycloptsError) -> str:
    """Return in one line what could not be read; the classes differ between versions."""
    error.verbose = False
    kind, unused = type(error).__name__, error.unused_tokens or []
    token, argument = getattr(error, "token", None), error.argument
    if kind == "UnknownOptionError" and token is not None:
        return f"unknown option {token.keyword or token.value!r}"
    if kind == "UnusedCliTokensError" and unused:
        return f"unexpected argument {unused[0]!r}"
    if kind in {"UnknownCommandError", "InvalidCommandError"} and error.root_input_tokens:
        return f"unknown command {error.root_input_tokens[0]!r}: see rotor-ida --help"
    if kind == "MissingArgumentError" and argument is not None:
        # An option that is misspelt is the likelier cause.
        misspelt = [word for word in unused if word.startswith("--")]
        if misspelt and argument.name not in unused:
            return f"unknown option {misspelt[0]!r}"
        return f"{argument.name} must be given a value"
    message = str(error)
    return message[:1].lower() + message[1:].rstrip(".")


def _complain(message: str, status: int) -> int:
    if sys.stderr is not None:
        # one line, in which the name of a file keeps its blanks
        print("rotor-ida:", " ".join(map(str.strip, message.splitlines())), file=sys.stderr)
    return status
