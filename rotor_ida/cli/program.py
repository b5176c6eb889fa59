"""The program: parse the arguments, run the command, print the report, return the exit status."""

from __future__ import annotations

import errno
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import is_dataclass, replace
from functools import cache
from importlib.metadata import version
from inspect import BoundArguments
from typing import Literal, TextIO, get_args, get_origin

from cyclopts import (
    App,
    Argument,
    CoercionError,
    CycloptsError,
    Group,
    MissingArgumentError,
    Token,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
    ValidationError,
)

from rotor_ida.checks import did_you_mean, listed, shown
from rotor_ida.cli.command import Command
from rotor_ida.cli.commands import basins, compute, cycles, stored, whirls
from rotor_ida.cli.commands.doctor import doctor
from rotor_ida.cli.commands.drop import drop
from rotor_ida.cli.commands.explore import explore
from rotor_ida.cli.commands.fit import fit
from rotor_ida.cli.commands.machine import machine
from rotor_ida.cli.commands.plot import plot
from rotor_ida.cli.commands.ross import from_ross
from rotor_ida.cli.option_types import OPTIONS, STUDY
from rotor_ida.cli.output import Output
from rotor_ida.cli.parsing import SYSTEM_ENDING, as_given, readable, refuse_units
from rotor_ida.cli.report import FAILED, INTERRUPTED, Report, console_on, text_of
from rotor_ida.cli.rotor_options import missing
from rotor_ida.cli.streams import results_only
from rotor_ida.errors import InputError, InstallationError, RotorError, SimulationError
from rotor_ida.texts import in_shell, printable
from rotor_ida.units import sentences_in

HELP = """Simulate rotors that touch their stators, and compare with exact results.

Commands have the names of the Python functions; short names are in brackets.
Values of a machine may have units: --mass 12kg --speed 3600rpm.

Results go to standard output, everything else to standard error.
Exit status: 0 done, 1 the run or the check failed, 2 bad input or a part that is missing.
"""
# The commands in the groups of the help, in order.
COMMANDS: dict[str, tuple[Command, ...]] = {
    "Simulate": (
        machine, from_ross, compute.simulate, compute.run_up, compute.run_ups, compute.sweep,
        compute.bifurcation_diagram, compute.poincare_section, drop,
    ),
    "Exact whirls": (
        whirls.synchronous_response, whirls.folds, whirls.hopf_points, whirls.backward_whirl,
        whirls.special_speeds, whirls.campbell, whirls.clearance_report,
    ),
    "Limit cycles": (cycles.limit_cycle, cycles.continue_cycle, cycles.bifurcation_curve),
    "Explore": (
        basins.basin, basins.basin_fractions, basins.continue_attractors, basins.touchdown_report,
        explore,
    ),
    "Signals": (plot, fit),
    "Archives and studies": (
        stored.show, stored.compare, stored.verify, stored.status, stored.resume,
    ),
    "Program": (compute.reproduce, doctor),
}  # fmt: skip
# Short names of some.
SHORT = {
    "bifurcation-diagram": "diagram", "poincare-section": "section", "backward-whirl": "whirl",
    "synchronous-response": "response", "limit-cycle": "cycle", "continue-cycle": "continue",
    "bifurcation-curve": "curve", "basin-fractions": "fractions", "touchdown-report": "touchdown",
    "continue-attractors": "atlas",
}  # fmt: skip
# A name in a message, neither quoted nor of an entry of a table.
NAME = re.compile(r"(?<![\w.'\"-])[a-z]\w*(?![\w.'\"(=])")
PYTHON_NAME = re.compile(r"(?<![\w.'\"-])[a-z]\w*_\w+(?![\w.'\"(=])")
# The beginning of a message about options that are missing.
OF_LOAD = re.compile(r"^(load|shocks)(?= must be 0)")
LACKING = re.compile(
    r"^[\w ,]+ must be given(?: with (?:\w+, )*\w+(?: and \w+)?)?(?! with --)"
    r"|(?<=^machine must also give )[\w ,]+"
)
# Groups whose commands compute studies.
COMPUTING = ("Simulate", "Exact whirls", "Limit cycles", "Explore")
DONE, BAD_INPUT, PIPE_CLOSED = 0, 2, 141
STANDARD_OUTPUT = "standard output"
# The option whose answer has the options of all commands.
COMPLETION = "--install-completion"


def main(words: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    words : sequence of str, optional
        The words after the program's name; default: those of the process.

    Returns
    -------
    int
        0 done, 1 the run or the check failed, 2 bad input, 130 interrupted, 141 if the reader
        of the results closed the pipe.

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
                where = f"{error.filename}: " if error.filename else ""
                closed = error.errno == errno.EBADF and error.filename == STANDARD_OUTPUT
                said = f"{where}{'closed' if closed else error.strerror}"
            return _complain(
                said, BAD_INPUT if isinstance(error, (InputError, InstallationError)) else FAILED
            )


@cache
def application(word: str = "") -> App:
    """Return the commands; without a word all have their options, else only the one it names."""
    groups = {name: Group(name, sort_key=place) for place, name in enumerate(COMMANDS)}
    app = App(
        name="rotor-ida",
        help=HELP,
        help_format="plaintext",
        version=version("rotor-ida"),
        group_commands=groups["Program"],
    )
    for name, commands in COMMANDS.items():
        for place, command in enumerate(commands):
            name_of_it = name_of(command)
            short = SHORT.get(name_of_it)
            is_asked = word in {"", name_of_it, short}
            app.command(
                command.function() if is_asked else _listed(command),
                name=name_of_it,
                group=groups[name],
                sort_key=place,
                alias=short,
                group_parameters=STUDY if name in COMPUTING else OPTIONS,
            )
    app.register_install_completion_command(
        help="Install completion of commands and options for bash, zsh or fish."
    )
    return app


def name_of(command: Command) -> str:
    """Return the name of a command."""
    return command.verb.replace("_", "-")


def _listed(command: Command) -> Callable[..., object]:
    """Return a function without options that stands for a command where only its help is listed.

    The options of one command take as long to make as all the rest.
    """

    def listed(*_words: str) -> None: ...

    listed.__doc__ = command.body.__doc__
    return listed


def _run(words: list[str], results: TextIO) -> int:
    console = console_on(results)
    first = next(iter(words), "--help")
    command, bound = application("" if first == COMPLETION else first).parse_args(
        readable(words), console=console, print_error=False, exit_on_error=False
    )[:2]
    _refuse_units(bound.arguments)
    line = " ".join(map(in_shell, ["rotor-ida", *words]))
    for name, value in bound.arguments.items():
        if isinstance(value, Output):
            bound.arguments[name] = replace(value, line=line)
    with console.capture() as help_text:
        answer = _answer(command, bound)
    if not isinstance(answer, Report):
        _write(help_text.get(), results)
        return answer if isinstance(answer, int) else DONE
    _write(text_of(answer, console), results)
    return _complain(answer.trouble, answer.status) if answer.trouble else DONE


def _answer(command: Callable[..., object], bound: BoundArguments) -> object:
    """Run a command; the message of an error is in the units in which its arguments were given."""
    try:
        outputs = [each for each in bound.arguments.values() if isinstance(each, Output)]
        system = outputs[0].system if outputs else "metric"
        with warnings.catch_warnings(), sentences_in(system):
            warnings.showwarning = _note  # type: ignore[assignment]
            return command(*bound.args, **bound.kwargs)
    except (InputError, SimulationError) as error:
        from rotor_ida.cli.message_units import in_given_units  # noqa: PLC0415 - only after an error

        said = with_options_named(str(in_given_units(bound.arguments, error)), command.__name__)
        raise (InputError if isinstance(error, InputError) else RotorError)(said) from error


def with_options_named(message: str, command: str) -> str:
    """Return a message with options and commands as they are typed, not as in Python.

    Keys of a file and quoted words stay as they are.

    Examples
    --------
    >>> with_options_named("disc_radius must be given with friction, got None", "simulate")
    '--disc-radius must be given with --friction'
    >>> with_options_named("a.toml: run_up.ramp_time must be positive, got 0", "run_up")
    'a.toml: run_up.ramp_time must be positive, got 0'
    """
    name = command.replace("_", "-")
    known = {each for argument in application(name)[name].assemble_argument_collection()
             if argument.parse for each in argument.names}  # fmt: skip
    commands = {name_of(each) for group in COMMANDS.values() for each in group}

    def typed(found: re.Match[str]) -> str:
        word = found[0].replace("_", "-")
        return f"--{word}" if f"--{word}" in known else word if word in commands else found[0]

    if re.match(rf"\S+{SYSTEM_ENDING}\b", message):
        return message
    said = LACKING.sub(lambda found: NAME.sub(typed, found[0]), message)
    said = OF_LOAD.sub(typed, said)
    return re.sub(r", got None( with [\w .]+)?$", "", PYTHON_NAME.sub(typed, said))


def _note(message: Warning | str, *_where: object) -> None:
    """Show a warning in one line, as it comes."""
    _complain(f"note: {message}", DONE)


def _refuse_units(arguments: Mapping[str, object]) -> None:
    """Refuse units of numbers anywhere if the rotor is dimensionless."""
    if any(arguments.get(name) is not None for name in ("system", "file")) or any(
        getattr(value, "units_unknown", False) for value in arguments.values()
    ):
        return  # a file says whether it has units
    values: dict[str, object] = {}
    for name, value in arguments.items():
        values |= vars(value) if is_dataclass(value) else {name: value}
    if any(getattr(value, "in_si", None) is False for value in arguments.values()):
        refuse_units(values)


def _write(text: str, results: TextIO) -> None:
    """Write and flush, so that an error of the stream is raised here and names it."""
    try:
        results.write(text)
        results.flush()
    except OSError as error:
        error.filename = STANDARD_OUTPUT
        raise


def misread(error: CycloptsError) -> str:
    """Return a parsing error in one line, in the form of this package's messages."""
    option = "" if error.argument is None else error.argument.name
    name = option.removeprefix("--")
    match error:
        case CycloptsError(__cause__=InputError() as cause):  # from a converter of ours
            said = str(cause)
        case CoercionError(token=Token() as token, target_type=kind) if get_origin(kind) is Literal:
            choices = ", ".join(map(repr, get_args(kind)))
            said = f"{name} must be one of {choices}, got {shown(token.value)}"
            said += did_you_mean(token.value, get_args(kind))
        case ValidationError(argument=Argument(tokens=[Token() as token, *_])):
            bound = error.exception_message.replace(">=", "at least").replace("<=", "at most")
            said = f"{name} {bound[:1].lower()}{bound[1:].rstrip('.')}, got {token.value}"
        case UnknownOptionError(token=token, argument_collection=known):
            said = _unknown_option(token.keyword or token.value, known or ())
        case UnusedCliTokensError(unused_tokens=[first, *_]):
            said = f"unexpected argument {shown(first)}"
        case UnknownCommandError(root_input_tokens=[first, *_]):
            names = [] if error.app is None else list(error.app)
            said = f"unknown command {shown(first)}{did_you_mean(first, names)}"
            said += "" if said.endswith("?") else "; see rotor-ida --help"
        case MissingArgumentError() if option:
            said = _missing(error, option)
        case _:
            error.verbose = False
            said = f"{error}".rstrip(".")
            said = said[:1].lower() + said[1:]
    return as_given(said)


def _unknown_option(word: str, known: Iterable[Argument]) -> str:
    """Return a message about an unknown option in one line, with a suggestion."""
    names = [name.lstrip("-") for each in known if each.parse for name in each.names]
    meant = did_you_mean(word.lstrip("-"), names).replace("'", "'--", 1)  # dashes are all alike
    return f"unknown option {shown(word)}{meant}"


def _missing(error: MissingArgumentError, option: str) -> str:
    """Return a message about missing options in one line; a misspelt one is reported first."""
    known = [] if error.app is None else error.app.assemble_argument_collection()
    words = {word.partition("=")[0] for word in error.root_input_tokens or () if word[:2] == "--"}
    misspelt = words.intersection(word.partition("=")[0] for word in error.unused_tokens or ())
    if misspelt and option not in words:
        return _unknown_option(misspelt.pop(), known)
    given = error.tokens_so_far
    if given and error.argument is not None:  # it has several values
        metavar = error.argument.parameter.metavar or ""
        number = {2: "two", 4: "four"}[len(metavar.split())]
        kind = "names" if "NAME" in metavar else "numbers"
        values, *instead = metavar.split("|")
        may_be = listed([f"{number} {kind} {values}", *instead], "or")
        return f"{option.removeprefix('--')} must be {may_be}, got {len(given)}"
    if option in words:
        return f"{option} must be given a value"
    lacking = [
        each.name
        for each in known
        if each.required and each.name.startswith("--") and words.isdisjoint(each.names)
    ]
    of_file = any(word.endswith(SYSTEM_ENDING) for word in error.root_input_tokens or ())
    if not of_file and "--machine" not in words and any("--zeta" in each.names for each in known):
        of_rotor = [word[2:].replace("-", "_") for word in words]
        lacking = [f"--{name.replace('_', '-')}" for name in missing(of_rotor)] + lacking
    return f"{listed(lacking if option in lacking else [option, *lacking])} must be given"


def _complain(message: str, status: int) -> int:
    if sys.stderr is not None:
        # one line, in which a file name keeps its blanks
        line = " ".join(map(str.strip, message.splitlines()))
        print("rotor-ida:", printable(line), file=sys.stderr)
    return status
