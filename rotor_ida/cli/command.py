"""Commands that ask a function of the package: its rotor, options, call and answer, made once.

A command is a function with its help and what is peculiar to it, decorated by `command`. Its
options are the keywords of the function of the package by the same name (`rotor_ida.cli.verbs`),
and those of the rotor: of one disc, of the file of a machine, or of the file of a rotor system.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import rotor_ida
from rotor_ida.checks import check_choice, listed, shown
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer, answer_whole, working
from rotor_ida.cli.parsing import SYSTEM_ENDING, Quantity, refuse_units
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.rotor_options import (
    AllSpeedsOptions,
    MachineFile,
    RotorOptions,
    RotorsOptions,
    of_sheet,
    sheet_of,
)
from rotor_ida.cli.verb_options import Option, options_of, system_axes
from rotor_ida.cli.verbs import NEEDED, Argument, arguments_of
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED

if TYPE_CHECKING:
    import xarray as xr

    from rotor_ida.model.rotor_system import RotorSystem
    from rotor_ida.results.system_file import Course

# The rotors of a command: one, several, those at all speeds, a machine or a system of a file
# alone, whose speeds are an argument of the function, or none.
Rotors = Literal["one", "several", "all speeds", "of a file", "a system", "none"]
GROUPS: dict[Rotors, Any] = {
    "one": RotorOptions, "several": RotorsOptions, "all speeds": AllSpeedsOptions,
}  # fmt: skip
# Keywords of functions that are no options: the file of a system has some.
NO_OPTIONS = {"progress", "modes", "more_modes", "**changed", "**varied"}
THAT_OF_FILE = "Default: that of the file."
# The function whose keywords are the options of measured files.
READS = "read_signals"
# What a function takes before the rotor.
FIRST = ("signals",)
# Functions that take each of these from the file of a system, where no option gives it.
OF_FILE = ("start", "modes", "more_modes", SPEED)


@dataclass(kw_only=True)
class Case:
    """What a command asks: the function, the rotor, the arguments that were given, the output.

    Parameters
    ----------
    of : Command
        The command.
    file : Path, optional
        The file of a rotor system.
    rotors : RotorOptions or RotorsOptions
        The options of one disc or several.
    given : dict
        The arguments on the command line, but for those of the rotor.
    known : dict
        Parameters of the rotor that the command knows besides.
    panels : int
        Panels of the figure.
    without_gravity : bool
        Whether to leave out the gravity of the file, or the load of its machine.
    rotor : Rotor, DimensionalRotor or RotorSystem, optional
        The rotor that was asked; None for several without dimensions. A command may know it.
    adapted : callable, optional
        Checks the arguments with the rotor, and returns those of the function.
    measured : list of Path
        The files besides that of a rotor system.
    reading : dict
        The options of measured files that were given.
    """

    of: Command
    file: Path | None
    rotors: Any
    output: Output
    given: dict[str, Any]
    known: dict[str, Any] = field(default_factory=dict)
    panels: int = 1
    without_gravity: bool = False
    rotor: Any = None
    adapted: Callable[[Any, dict[str, Any]], dict[str, Any]] | None = None
    measured: list[Path] = field(default_factory=list)
    reading: dict[str, Any] = field(default_factory=dict)

    @property
    def is_system(self) -> bool:
        """Whether the rotor is that of a system file."""
        return self.file is not None

    @cached_property
    def from_file(self) -> tuple[RotorSystem, Course]:
        """The system of the file and its course; values with units are refused without units."""
        from rotor_ida.results.system_file import read_system_file  # noqa: PLC0415 - heavy

        assert self.file is not None
        system, course = read_system_file(self.file)
        if system.units != "SI":
            refuse_units({**self.rotor_values, **self.given})
            return system, course
        from rotor_ida.results.plausible import questions_on_system  # noqa: PLC0415 - heavy
        from rotor_ida.results.toml_files import read_toml  # noqa: PLC0415

        for each in questions_on_system(system, course.speed, read_toml("system", self.file)):
            _ask(f"{self.file}: {each}")
        return system, course

    @property
    def rotor_values(self) -> dict[str, Any]:
        """The given parameters of one disc, or of several."""
        return dict(self.rotors.given)

    @property
    def running_speed(self) -> float | None:
        """The speed in service that a file gives, which a run-up passes or leaves."""
        if self.is_system:
            return self.from_file[1].speed
        return self.rotor.speed if self.rotors.machine is not None else None

    def varied(self) -> list[str]:
        """Return the parameters that have several values."""
        axes = self.rotors.given | {
            name: self.given[name] for name in PARAMETERS_OF_SYSTEM if name in self.given
        }
        return [name for name, each in axes.items() if len(each) > 1]

    def draw_at(self, node: str | None) -> None:
        """Draw the figure at a node of a system, if one is given."""
        if node is None:
            return
        if not self.is_system:
            raise InputError(f"node must be left out with one disc, got {shown(node)}")
        nodes = self.from_file[0].nodes
        check_choice("node", node, tuple(nodes))
        self.output = replace(self.output, node=node)

    def answer(self) -> Report:
        """Call the function and return the report on its result."""
        study = self.given.get("study")
        rotor, given = self._asked()
        with working(self.of.label, study) as progress:
            return self.report(self._called(rotor, given, progress))

    def ask(self) -> xr.Dataset:
        """Call the function and return its result."""
        rotor, given = self._asked()
        with working(self.of.label) as progress:
            return self._called(rotor, given, progress)

    def report(self, dataset: xr.Dataset, **more: Any) -> Report:
        """Return the answer with a result; more is as for `rotor_ida.cli.output.answer`."""
        files = [each for each in (self.file, self.rotors.machine) if each is not None]
        more = {"rotor": self.rotor, "files": files, **more}
        if "study" in self.of.arguments:
            return answer_whole(dataset, self.output, self.given.get("study"), **more)
        return answer(dataset, self.output, most=self.of.most, **more)

    def refuse_with(self, kind: str, names: Mapping[str, object]) -> None:
        """Refuse options that do not go with a kind of rotor."""
        for name, value in names.items():
            if value is not None:
                raise InputError(f"{name} must be left out with {kind}, got {shown(value)}")

    def _called(self, rotor: Any, given: dict[str, Any], progress: Any) -> xr.Dataset:
        quiet = self.is_system and self.of.quiet
        if "progress" in arguments_of(self.of.verb):
            given = {**given, "progress": progress}
        with warnings.catch_warnings() if quiet else nullcontext():
            if quiet:  # the answer says the same
                warnings.simplefilter("ignore", UserWarning)
            first = [given.pop(name) for name in FIRST if name in given]
            found: xr.Dataset = getattr(rotor_ida, self.of.verb)(*first, *rotor, **given)
        return found

    def _asked(self) -> tuple[list[Any], dict[str, Any]]:
        """Return the rotor, if it is apart, and the arguments; check all that can be checked."""
        given = dict(self.given)
        if "executor" in self.of.arguments:
            jobs = options.JobOptions(**{name: given.pop(name) for name in ("workers", "executor")
                                         if name in given})  # fmt: skip
            given |= jobs.on_every_core()
        rotor, given = self._of_system(given) if self.is_system else self._of_disc(given)
        self.rotor = self._given_machine() or rotor[0]
        self._ask_about_speeds(given)
        if self.of.starts and "start" in given:
            given["starts"] = given.pop("start")
        return rotor, given if self.adapted is None else self.adapted(rotor[0], given)

    def _ask_about_speeds(self, given: Mapping[str, Any]) -> None:
        """Ask whether a speed without a unit, far beyond those of the rotor, was meant in rpm."""
        from rotor_ida.results.plausible import first_critical, speed_in_doubt  # noqa: PLC0415

        speeds = {name: given.get(name, self.rotor_values.get(name)) for name in ("to", SPEED)}
        plain = {name: each for name, value in speeds.items()
                 for each in (value if isinstance(value, list) else [value])
                 if isinstance(each, Quantity) and not each.word}  # fmt: skip
        if self.is_system and self.from_file[0].units == "SI" and plain:
            known = first_critical(self.from_file[0]), self.from_file[1].speed
        elif isinstance(self.rotor, DimensionalRotor):
            known = self.rotor.critical_speed, None if SPEED in plain else self.rotor.speed
        else:
            return
        for name, value in plain.items():
            if said := speed_in_doubt(f"--{name}", value, min(filter(None, known), default=0.0)):
                _ask(said)

    # ---- One disc ----

    def _of_disc(self, given: dict[str, Any]) -> tuple[list[Any], dict[str, Any]]:
        of_a_file = self.of.rotors == "of a file"
        if self.without_gravity and not (of_a_file and self.rotors.machine is not None):
            raise InputError("without_gravity must be left out without a rotor system")
        if of_a_file:
            self.output.check()
            if self.rotors.machine is None:
                raise InputError(
                    "a rotor must be given: a system file, or a machine with --machine"
                )
            machine = self._given_machine()
            if self.without_gravity and machine is not None:
                machine = replace(machine, load=0.0)
            return [machine], given
        if self.of.rotors == "one":
            rotor = self.rotor or self.rotors.chosen(self.known)
            self.output.check(panels=self.panels)
            return [rotor], given
        self.output.check(panels=self.panels)
        rotors, varied = self.rotors.asked(self.known)
        return [rotors], {**varied, **given}

    def _given_machine(self) -> DimensionalRotor | None:
        """Return the machine of a file at its running speed, which a run-up or sweep leaves."""
        if self.rotors.machine is None or self.is_system:
            return None
        values = {name: each if isinstance(each, list) else [each]
                  for name, each in self.rotor_values.items()}  # fmt: skip
        fixed = {name: each[0] for name, each in values.items() if len(each) == 1}
        return of_sheet(sheet_of(fixed, self.rotors.machine), self.rotors.machine)

    # ---- A rotor system ----

    def _of_system(self, given: dict[str, Any]) -> tuple[list[Any], dict[str, Any]]:
        given |= self._values_of_system()
        self.output.check()
        system, course = self.from_file
        if self.without_gravity:
            system = replace(system, gravity=None)
        known = {name for name in OF_FILE if name in arguments_of(self.of.verb)}
        known -= {*self.of.without, *({*self.of.arguments} - {"start"})}
        if not {"modes"} & (known | given.keys()) and course.modes is not None:
            from rotor_ida.model.reduction import in_modes  # noqa: PLC0415 - heavy

            system = in_modes(system, course.modes, None)[0]
        told = {name: getattr(course, name) for name in known}
        has_speed = "speeds" in given or _is_result(given.get("start"))
        if has_speed:
            told.pop(SPEED, None)
        if self.of.starts:
            told["start"] = [course.start]
        given = {**{name: each for name, each in told.items() if each is not None}, **given}
        self._check_words(given.get("start"))
        if SPEED in known and SPEED not in given and not has_speed:
            raise InputError(f"speed must be given with --speed or in {self.file}")
        if "node" in self.of.arguments and "node" not in given:
            nodes = listed([repr(each) for each in system.nodes], "or")
            raise InputError(f"node must be given with --node for a rotor system: {nodes}")
        return [system], given

    def _values_of_system(self) -> dict[str, Any]:
        """Return speed and parameters of the system; what is of one disc is refused."""
        values = self.rotor_values
        # signals have their own speed
        shared = {*self.known} if self.of.file else {SPEED, *self.known}
        found = {name: values.pop(name) for name in [*values] if name in shared}
        if self.of.rotors == "several":
            own = {name: values.pop(name) for name in PARAMETERS_OF_SYSTEM if name in values}
            own |= {name: self.given[name] for name in PARAMETERS_OF_SYSTEM if name in self.given}
            _refuse_units_of_factors(own)
            found |= {name: each[0] if len(each) == 1 else each for name, each in own.items()}
        self.refuse_with("a rotor system", {**values, "machine": self.rotors.machine})
        return found | self.known

    def _check_words(self, start: Any) -> None:
        """Refuse the four numbers of a start, which are of one disc, if an option gives them."""
        if self.given.get("start") is None:
            return
        for each in start if self.of.starts else [start]:
            if not (isinstance(each, str) or _is_result(each)):
                raise InputError(
                    f"start must be settled or rest with a rotor system, got {shown(each)}"
                )


def _ask(question: str) -> None:
    """Say in a line what is likely a slip of the user."""
    warnings.warn(question, UserWarning, stacklevel=2)


def _is_result(start: object) -> bool:
    """Return whether a start is a result, which has its own speed."""
    return hasattr(start, "data_vars")


def _refuse_units_of_factors(varied: Mapping[str, list[float]]) -> None:
    """Refuse a damping or stiffness with a unit, which is that of one disc."""
    for name, values in varied.items():
        unit = next((each.word for each in values if isinstance(each, Quantity)), "")
        if unit and PARAMETERS_OF_SYSTEM[name].unit == "1":
            raise InputError(
                f"{name} must be a factor without a unit for a rotor system, got {shown(unit)}"
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class Command:
    """A command that asks the function of the package by the same name.

    Parameters
    ----------
    body : callable
        What it does, with its help as docstring: by default it asks and answers.
    rotors : str
        What rotors it takes besides that of a system file, which the function itself may take.
    most : int, optional
        Rows of its tables.
    quiet : bool
        Whether the answer on a rotor system says what the function warns of.
    label : str
        Title of the progress bar.
    without : tuple of str
        Keywords of the function that are no options.
    of_file : tuple of str
        Those that the file of a system may give instead.
    asks : tuple of str
        The functions whose keywords are options: by default that by the same name.
    only : tuple of str
        The keywords of these that are options; by default all.
    file : str
        The word for its file, or with dots for several; by default it is that of a rotor system.
    reads : bool
        Whether it has the options of measured files.
    writes : bool
        Whether it writes its result as others do.
    """

    body: Callable[..., Report | int]
    rotors: Rotors
    most: int | None = FIRST_ROWS
    quiet: bool = False
    label: str = ""
    without: tuple[str, ...] = ()
    of_file: tuple[str, ...] = ()
    asks: tuple[str, ...] | None = None
    only: tuple[str, ...] = ()
    file: str = ""
    reads: bool = False
    writes: bool = True

    @property
    def verb(self) -> str:
        """The name of the function."""
        return self.body.__name__

    @cached_property
    def keywords(self) -> dict[str, Argument]:
        """The keywords of the functions."""
        found: dict[str, Argument] = {}
        for name in (self.verb,) if self.asks is None else self.asks:
            found |= {key: each for key, each in arguments_of(name).items() if key not in found}
        return found

    @cached_property
    def arguments(self) -> dict[str, Argument]:
        """The keywords of the functions that are options."""
        if self.only:  # each function has a default
            return {name: each._replace(default=None) for name, each in self.keywords.items()
                    if name in self.only}  # fmt: skip
        no = {*NO_OPTIONS, *self.without}
        no = no - ({"modes"} - {*self.without}) if self.of_one_file else no | {SPEED}
        found = {name: each for name, each in self.keywords.items() if name not in no}
        return found | {
            name: found[name]._replace(default=None, text=f"{found[name].text} {THAT_OF_FILE}")
            for name in self.of_file
        }

    @property
    def of_one_file(self) -> bool:
        """Whether no option describes the rotor."""
        return self.rotors in {"of a file", "a system"}

    @property
    def starts(self) -> bool:
        """Whether the option for a start is for several."""
        return "Starts" in getattr(self.arguments.get("starts"), "kind", "")

    @property
    def takes_systems(self) -> bool:
        """Whether the function takes a rotor system."""
        return not self.only and bool({SPEED, "**changed"} & self.keywords.keys())

    def function(self) -> Callable[..., Report | int]:
        """Return the command with its options, for cyclopts."""

        def run(
            *files: Path | None, rotors: Any = None, machine: Path | None = None,
            output: Output = Output(), **given: Any,
        ) -> Report | int:  # fmt: skip
            own = {name: given.pop(name) for name in list(given) if name in self.own}
            of_reading = {name for name, *_ in self.of_reading}
            reading = {name: given.pop(name) for name in list(given) if name in of_reading}
            group = rotors or GROUPS.get(self.rotors, RotorOptions)()
            if machine is not None:
                group = RotorOptions(machine=machine)
            of_any = self.file and "..." not in self.file
            systems = [each for each in files if each and not of_any
                       and each.name.endswith(SYSTEM_ENDING)]  # fmt: skip
            if len(systems) > 1:
                raise InputError("FILE must be given with one rotor system at most, got two")
            case = Case(
                of=self, file=next(iter(systems), None), rotors=group, output=output, given=given,
                measured=[each for each in files if each and each not in systems],
                reading=reading,
            )  # fmt: skip
            return self.body(case, **own)

        run.__name__, run.__doc__ = self.verb, self.body.__doc__
        run.__annotations__ = {}
        run.__signature__ = inspect.Signature(self._options())  # type: ignore[attr-defined]
        return run

    @cached_property
    def own(self) -> dict[str, inspect.Parameter]:
        """The options of the command that the function of the package does not have."""
        return options.options_of_body(self.body)

    @cached_property
    def of_reading(self) -> list[Option]:
        """The options of measured files, if it has them."""
        if not self.reads:
            return []
        other = options.option(Path | None, "slow_roll_file")
        return [*options_of(READS, arguments_of(READS)), ("slow_roll_file", other, None)]

    def _options(self) -> list[inspect.Parameter]:
        """Return all options in the order of the help."""
        apart = partial(inspect.Parameter, kind=inspect.Parameter.KEYWORD_ONLY)
        group = GROUPS.get(self.rotors)
        found = [] if group is None else [apart("rotors", default=group(), annotation=group)]
        if self.rotors == "of a file":
            found = [apart("machine", default=None, annotation=MachineFile)]
        kind: Any = inspect.Parameter.POSITIONAL_ONLY
        default: object = None
        if "..." in self.file:
            several = inspect.Parameter.VAR_POSITIONAL
            found = [inspect.Parameter("files", several, annotation=options.FILES), *found]
        elif self.file:
            of = options.option(Path | None, f"{self.verb} file", "file")
            default = None if self.file.startswith("[") else NEEDED
            kind = inspect.Parameter.POSITIONAL_OR_KEYWORD if default is None else kind
            found = [inspect.Parameter("file", kind, default=default, annotation=of), *found]
        elif self.takes_systems:
            of = options.System if group else Annotated[options.System, options.OR_MACHINE]
            if self.rotors == "a system":
                of, default = Annotated[options.System, options.SYSTEM_ALONE], NEEDED
            found = [inspect.Parameter("system", kind, default=default, annotation=of), *found]
        for name, annotation, default in options_of(self.verb, self.arguments):
            found.append(apart(name, default=default, annotation=annotation))
        axes = system_axes() if self.rotors == "several" and self.takes_systems else ()
        for name, annotation, default in (*self.of_reading, *axes):
            found.append(apart(name, default=default, annotation=annotation))
        output = [apart("output", default=Output(), annotation=Output)] * self.writes
        return [*found, *self.own.values(), *output]


def command(
    rotors: Rotors, label: str = "", **how: Any
) -> Callable[[Callable[..., Report | int]], Command]:
    """Return a decorator that makes a command of its body."""

    def decorated(body: Callable[..., Report | int]) -> Command:
        name = body.__name__.replace("_", " ")
        return Command(body=body, rotors=rotors, label=label or name, **how)

    return decorated
