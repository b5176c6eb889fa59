"""Options shared by several commands: their types, help and groups."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_args

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from rotor_ida.checks import (
    COMPONENTS,
    LARGEST_SEED,
    MOST_NUMBERS,
    MOST_SHOCKS,
    MOST_WORKERS,
    State,
    check_axis,
    did_you_mean,
    shown,
)
from rotor_ida.cli import machines, parsing
from rotor_ida.cli.machines import Units
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import units_of
from rotor_ida.model.parameters import (
    MACHINE_PARAMETERS,
    OPTIONAL,
    TABLE,
)
from rotor_ida.model.parameters import Parameter as Quantity
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.simulation.options import Backend, Flight, Method

# Placeholder where a speed is required but not used.
ANY_SPEED = 1.0
# The speed of a rotor, without dimensions and in SI units.
SPEEDS = ("omega", "speed")
# Groups of options in the help of a command; options without one are in the command's group.
ROTOR = Group("Rotor", sort_key=1)
SPEED = Group("Change of the speed", sort_key=2)
STUDY, OPTIONS = Group("Study", sort_key=3), Group("Options", sort_key=3)
READING = Group("Measured files", sort_key=4)
SOLVER = Group("Solver", sort_key=5)
OUTPUT = Group("Output", sort_key=6)
IN_ROTOR, IN_SOLVER, IN_OUTPUT = (Parameter(group=each) for each in (ROTOR, SOLVER, OUTPUT))


def check_varies(points: int) -> None:
    """Refuse a figure of an atlas in which nothing varies."""
    if points < 2:
        raise InputError("figure needs an atlas of several speeds, dampings or clearances, got one")


def _number(text: str) -> Parameter:
    return Parameter(help=text, converter=parsing.converter(parsing.number))


def _quantity(text: str, *allowed: str, name: str | Sequence[str] | None = None) -> Parameter:
    """Return an option for a number, which may have one of the allowed units."""
    return Parameter(
        name=name,
        help=text,
        metavar="VALUE",
        converter=parsing.converter(parsing.quantity, *allowed),
    )


def _numbers(text: str, *allowed: str) -> Parameter:
    reading = parsing.converter(parsing.numbers, *allowed)
    return Parameter(help=text, converter=reading, consume_multiple=True, negative=())


def _several_numbers(text: str, words: str, *allowed: str) -> Parameter:
    reading = parsing.converter(parsing.several_numbers, *allowed)
    return Parameter(help=text, metavar=words, converter=reading, negative=())


def _limits(text: str, words: str) -> Parameter:
    """Return an option for values of a parameter, whose unit depends on the parameter."""
    every = tuple({each.unit for each in TABLE if each.unit != "1"})
    reading = parsing.converter(
        lambda name, given: tuple(parsing.quantity(name, [word], *every) for word in given)
    )
    return Parameter(help=text, metavar=words, converter=reading, negative=())


def _whole_number(text: str, lowest: int, highest: int) -> Parameter:
    reading = parsing.converter(parsing.whole_number)
    return Parameter(help=text, converter=reading, validator=Number(gte=lowest, lte=highest))


def _path(text: str, *, name: str | None = None) -> Parameter:
    return Parameter(name=name, help=text, converter=parsing.converter(parsing.path))


def _flag(text: str, *, name: str | None = None) -> Parameter:
    return Parameter(name=name, help=text, negative=(), show_default=False)


START = Parameter(
    help="Initial state: displacements and velocities. Default: at rest on the axis.",
    metavar="X Y VX VY",
    converter=parsing.converter(parsing.start),
    negative=(),
    show_default=False,
)
Start = Annotated[State, START]
StartOrNone = Annotated[State | None, START]
STARTS = Parameter(
    help="Initial states, one or more. Default: at rest on the axis.",
    metavar="X Y VX VY",
    converter=parsing.converter(parsing.starts),
    consume_multiple=True,
    negative=(),
    show_default=False,
)
Starts = Annotated[list[State], STARTS]
StartsOrNone = Annotated[
    list[State] | None,
    STARTS,
    Parameter(help="Initial states, one or more, instead of random ones."),
]
Component = Annotated[
    float | list[float],
    Parameter(
        help="Component of the initial states: a number or a range.",
        metavar="FLOAT|START:STOP:COUNT",
        converter=parsing.converter(parsing.component_or_range),
        negative=(),
    ),
]
Range = Annotated[
    float | tuple[float, float],
    Parameter(
        help="Component of the initial states, or the range from which it is drawn.",
        metavar="FLOAT|LOW:HIGH",
        converter=parsing.converter(parsing.component_or_ends),
        negative=(),
    ),
]
StartCount = Annotated[
    int, _whole_number("Number of random initial states.", 1, parsing.MOST_POINTS_OF_STUDY)
]
ShockCount = Annotated[
    int,
    _whole_number("Number of shocks of each kind to apply to each attractor.", 0, MOST_SHOCKS),
]
ShocksOrNone = Annotated[
    int | None,
    _whole_number(
        "Number of shocks of each kind to apply to each attractor. Default: 4096; under a load 0.",
        0, MOST_SHOCKS,
    ),
]  # fmt: skip
Seed = Annotated[int, _whole_number("Seed of the random numbers.", 0, LARGEST_SEED)]

Reach = Annotated[
    float | None,
    _quantity(
        "Largest |x| and |y| of random initial states (SI: m), and of their velocities, "
        "divided by the reference frequency. Default: 5 eccentricities.",
        "m",
    ),
]
ExtremaTime = Annotated[
    float | None,
    _quantity(
        "Time over which extrema are found (SI: s). Default: 100 / reference frequency.", "s"
    ),
]

Period = Annotated[
    float | None,
    _quantity(
        "Estimate of the period, for a start near a cycle on the rotating axes (SI: s).", "s"
    ),
]
From = Annotated[
    Path | None,
    _path("Archive of a cycle, branch or curve to start from.", name="--from"),
]
PointNumber = Annotated[
    int | None,
    _whole_number("Point of the branch or curve in that archive, counted from 0.", 0, MOST_NUMBERS),
]
SpecialNumber = Annotated[
    int | None,
    _whole_number("Special point of that branch or curve, counted from 0.", 0, MOST_NUMBERS),
]
PointCount = Annotated[
    int, _whole_number("Largest number of points in each direction.", 2, MOST_NUMBERS)
]
Continued = Literal[
    "omega", "zeta", "delta0", "speed", "damping", "clearance", "shaft_stiffness",
    "contact_damping", "load", "friction", "disc_radius",
]  # fmt: skip
OneParameter = Annotated[
    Continued,
    Parameter(
        help="Parameter to vary; for a machine speed, damping or clearance replace omega, "
        "zeta or delta0."
    ),
]
TwoParameters = Annotated[
    tuple[Continued, Continued],
    Parameter(
        help="The two parameters to vary, from the choices of continue-cycle.",
        metavar="NAME NAME",
        negative=(),
        show_default=" ".join,
    ),
]
Limits = Annotated[
    tuple[float, float],
    _limits(
        "Smallest and largest value of the parameter (of a machine in SI units, or as 3000rpm).",
        "LOW HIGH",
    ),
]
TwoLimits = Annotated[
    tuple[float, float, float, float],
    _limits("Smallest and largest value of each parameter.", "LOW HIGH LOW HIGH"),
]
Way = Annotated[
    Literal["both", "forward", "backward"],
    Parameter(help="Direction: forward is to larger values, or onwards along a branch."),
]
Bifurcation = Annotated[
    Literal["fold", "period_doubling", "torus"], Parameter(help="Bifurcation to follow.")
]

Duration = Annotated[float, _quantity("Time to simulate (SI: s).", "s")]
ToSpeed = Annotated[
    float, _quantity("Final speed of the ramps (SI: rad/s, or as 3000rpm).", "rad s-1")
]
Rates = Annotated[
    list[float],
    _numbers(
        "Rates of change of the speed (SI: rad/s2, or as 100rpm/s): numbers, or START:STOP:COUNT.",
        "rad s-2",
    ),
]
RateOrNone = Annotated[
    float | None,
    _quantity(
        "Rate of change of the speed (SI: rad/s2, or as 100rpm/s), with --direction. Default: "
        "the rotor settles at each speed.",
        "rad s-2",
    ),
]
Phases = Annotated[
    list[float],
    Parameter(
        help="Angles of the unbalance at time 0, in radians: numbers, or START:STOP:COUNT. "
        "Default: 0.",
        converter=parsing.converter(parsing.numbers),
        consume_multiple=True,
        negative=(),
        show_default=False,
    ),
]
Samples = Annotated[
    int | None,
    _whole_number("Number of output times. Default: at least 32 per revolution.", 2, MOST_NUMBERS),
]
Rtol = Annotated[float, _number("Relative tolerance."), IN_SOLVER]
Atol = Annotated[float, _number("Absolute tolerance."), IN_SOLVER]
ContactMethod = Annotated[Method, Parameter(help="Solver of the contact phases."), IN_SOLVER]
MethodOfAny = Annotated[
    Method | None,
    Parameter(
        help="Solver of the contact phases. Default: adams; of a rotor system, taylor.",
        show_default=False,
    ),
    IN_SOLVER,
]
SolverBackend = Annotated[Backend, Parameter(help="Code that runs the solver."), IN_SOLVER]
RtolOrNone = Annotated[
    float | None, _number("Relative tolerance. Default: chosen automatically."), IN_SOLVER
]
Workers = Annotated[
    int | None,
    _whole_number("Number of parallel jobs. Default: one per core.", 1, MOST_WORKERS),
    IN_SOLVER,
]

Witness = Annotated[
    Method | None,
    Parameter(help="Solver of the new computation. Default: that of the archive."),
    IN_SOLVER,
]

System = Annotated[
    Path | None,
    Parameter(
        name="SYSTEM",
        help="Rotor system from a TOML file, instead of the options of one disc but --speed.",
        converter=parsing.converter(parsing.system_file),
    ),
    IN_ROTOR,
]
SystemFile = Annotated[
    Path,
    Parameter(
        name="SYSTEM", help="Rotor system from a TOML file.",
        converter=parsing.converter(parsing.system_file),
    ),
    IN_ROTOR,
]  # fmt: skip
WithoutGravity = Annotated[
    bool, _flag("Leave out the gravity of the system's file: whirls have none."), IN_ROTOR
]
SpeedsOfSystem = Annotated[
    list[float],
    _numbers("Spin speeds, or START:STOP:COUNT (SI: rad/s, or as 3000rpm).", "rad s-1"),
    IN_ROTOR,
]
LimitsOfSpeed = Annotated[
    tuple[float, float],
    _several_numbers(
        "Lowest and highest speed (SI: rad/s, or as 3000rpm).", "LOW HIGH", "rad s-1", "rad s-1"
    ),
]
PointsBetween = Annotated[
    int, _whole_number("Number of speeds at which changes are noticed.", 2, MOST_NUMBERS)
]
ClosedStiffnesses = Annotated[
    list[float],
    _numbers("Stiffnesses of springs at the contacts, from open to closed (SI: N/m).", "N m-1"),
]
ModesShown = Annotated[
    int | None, _whole_number("Number of eigenvalues, the slowest first.", 1, MOST_NUMBERS)
]
RunningSpeeds = Annotated[
    list[float],
    _numbers(
        "Minimum and maximum continuous speed, and the trip speed (SI: rad/s, or as 3000rpm).",
        "rad s-1",
    ),
    IN_ROTOR,
]
Probes = Annotated[
    list[str] | None,
    Parameter(
        help="Nodes at which vibration is measured. Default: those of the contacts.",
        metavar="NAME",
        consume_multiple=True,
        negative=(),
    ),
]
OwnUnbalance = Annotated[
    bool, _flag("Take the unbalance of the file as residual, instead of that of the formula.")
]
Multiple = Annotated[float, _number("How many times the residual unbalance is applied.")]
VibrationLimit = Annotated[
    float | None,
    _quantity("Vibration limit, from peak to peak (SI: m). Default: by the speed.", "m"),
]
RotorMass = Annotated[
    float | None,
    _quantity("Mass of the rotor, for its residual unbalance. Default: by the matrices.", "kg"),
]
PointsOfResponse = Annotated[int, _whole_number("Number of speeds.", 2, MOST_NUMBERS)]
ReportFolder = Annotated[Path, _path("Folder of the report, which is made."), IN_OUTPUT]
DropSpeed = Annotated[
    float | None,
    _quantity("Speed at the drop (rad/s, or as 3000rpm). Default: that of the file.", "rad s-1"),
]
DropDuration = Annotated[
    float | None, _quantity("Time to simulate (s). Default: that of the file.", "s")
]
DropCount = Annotated[
    int | None,
    _whole_number("Number of drops at random, beside one. Default: that of the file.", 2, 100_000),
]
Film = Annotated[
    Path | None, _path("Write a film of the orbits to this file (.gif, or .mp4)."), IN_OUTPUT
]
File = Annotated[Path, _path("Archive written by rotor-ida (.nc).", name="FILE")]
FileToExplore = Annotated[
    Path | None, _path("Archived run shown first, or a rotor system as TOML or .nc.")
]
Port = Annotated[int, _whole_number("Port on this computer; 0 picks a free one.", 0, 65_535)]
NoBrowser = Annotated[bool, _flag("Print the address without opening a browser.")]
Export = Annotated[
    Path | None,
    _path("Write a page that needs no server, for the speeds of --speeds, and stop."),
    IN_OUTPUT,
]
ExportedSpeeds = Annotated[
    list[float] | None, _numbers("Speeds of the exported page: numbers, or START:STOP:COUNT.")
]
Folder = Annotated[Path, _path("Folder of a study.", name="FOLDER")]
Study = Annotated[
    Path | None,
    _path("Save results in this folder as they are computed, so that resume can continue."),
    IN_OUTPUT,
]
Out = Annotated[Path | None, _path("Write the result to this netCDF file (.nc)."), IN_OUTPUT]
Figure = Annotated[
    Path | None,
    _path("Draw the result to NAME.png and NAME.svg, or to NAME.pdf."),
    IN_OUTPUT,
]
SignalFile = Annotated[
    Path,
    _path(
        "Archive (.nc) or measured file: text, .wav, .mat, .h5, .npz, .uff, .tdms, .lvm, .cff, or "
        ".cfg with .dat.",
        name="FILE",
    ),
]
FigureOfPlot = Annotated[
    Path | None,
    _path("Draw to NAME.png and NAME.svg, or to NAME.pdf. Default: named after FILE and kind."),
    IN_OUTPUT,
]
Csv = Annotated[
    Path | None,
    _path(
        "Write the result as tables to this CSV file, or to NAME.TABLE.csv where it has several."
    ),
    IN_OUTPUT,
]
KindOfPlot = Literal[
    "bode", "polar", "orders", "orbit", "full-spectrum", "cascade", "spectrogram", "centreline",
    "trace", "orbits", "forces", "history", "shape",
]  # fmt: skip
# Other names of these.
PLOTS_ALSO_CALLED: dict[str, KindOfPlot] = {
    "waterfall": "cascade",
    "spectrum": "full-spectrum",
    "campbell": "spectrogram",
    "colormap": "spectrogram",
    "nyquist": "polar",
    "centerline": "centreline",
    "shaft-centerline": "centreline",
    "timebase": "trace",
    "waveform": "trace",
    "mode-shape": "shape",
    "deflected-shape": "shape",
}


def _kind_of_plot(name: str, words: Sequence[str]) -> str:
    """Return the kind of plot that a word names, in either case."""
    word = words[0].lower().replace("_", "-")
    kinds, others = get_args(KindOfPlot), PLOTS_ALSO_CALLED
    if word in kinds:
        return word
    if word not in others:
        listed = ", ".join(map(repr, kinds))
        meant = did_you_mean(word, (*kinds, *others))
        raise InputError(f"{name} must be one of {listed}, got {shown(words[0])}{meant}")
    return others[word]


PlotKind = Annotated[
    KindOfPlot | None,
    Parameter(
        help="Plot to draw. Default: one that suits the file. Also understood: waterfall for "
        "cascade, spectrum for full-spectrum, campbell for spectrogram.",
        converter=parsing.converter(_kind_of_plot),
    ),
]
Node = Annotated[
    str | None,
    Parameter(help="Node of a rotor system at which probes look at the shaft.", metavar="NAME"),
]
OneContact = Annotated[
    int | None, _whole_number("Contact whose forces are drawn, counted from 0.", 0, MOST_NUMBERS)
]
Instant = Annotated[
    float | None,
    _quantity("Instant of a deflected shape. Default: the largest deflection.", "s"),
]
Exact = Annotated[
    bool,
    _flag("Also draw the exact response, cycle or backward whirl of the archived rotor."),
]
OneOrder = Annotated[
    float | None, _number("Order in Bode and polar plots, as a multiple of the speed. Default: 1.")
]
Orders = Annotated[
    list[float] | None,
    _numbers("Orders to track, or to mark in a cascade or spectrogram."),
]
Sense = Annotated[
    Literal["forward", "backward"] | None,
    Parameter(help="Sense of the whirl in Bode and polar plots."),
]
Over = Annotated[
    Literal["speed", "t"] | None,
    Parameter(help="Axis of a cascade or spectrogram: speed or time."),
]
Span = Annotated[float | None, _number("Largest frequency to show, as a multiple of the speed.")]
Segment = Annotated[
    int | None, _whole_number("Number of samples in each segment of a spectrum.", 16, MOST_NUMBERS)
]
ShownClearance = Annotated[
    float | None,
    _quantity("Clearance of a measured machine, in the unit of the probes or as 150um.", "m"),
]
Times = Annotated[
    tuple[float, float] | None,
    _several_numbers("Use only the signals between these times.", "START END", "s", "s"),
]
Unknowns = Annotated[
    list[str],
    Parameter(
        help="Parameters to fit: names of rotor options, or unbalance_angle.",
        metavar="NAME",
        consume_multiple=True,
        negative=(),
    ),
]
EntryTimes = Annotated[
    list[float] | None,
    _numbers("Measured times at which contacts begin, in the unit of the signals or as 20ms.", "s"),
]
ExitTimes = Annotated[list[float] | None, _numbers("The same, at which contacts end.", "s")]
TimeError = Annotated[float | None, _quantity("Standard error of these times.", "s")]
NoiseLevel = Annotated[
    float | None,
    _quantity(
        "Standard deviation of the noise, in the unit of the probes or as 2um. Default: that of "
        "the residuals.",
        "m",
    ),
]
SearchLimit = Annotated[
    float | None, _number("Longest time to search, in s. The best trial is reported then.")
]
Results = Annotated[Path, _path("Folder for archives and figures."), IN_OUTPUT]
Direction = Annotated[
    Literal["up", "down", "both"] | None,
    Parameter(help="Quasi-static sweep: start each speed where the one before ended."),
]
WithFolds = Annotated[bool, _flag("List the folds too.")]
Quick = Annotated[bool, _flag("Compute coarser results, faster.")]
Studies = Annotated[
    bool, _flag("Compute the studies as well as the figures of the paper.", name="--all")
]
Names = Annotated[
    list[str] | None,
    Parameter(
        help="Scenarios to run: names, or beginnings of names.", consume_multiple=True, negative=()
    ),
]
MachineFile = Annotated[
    Path | None,
    _path("Machine in SI units, as written by rotor-ida machine; other options override it."),
    IN_ROTOR,
]
MachineOut = Annotated[Path | None, _path("Write the machine to this TOML file."), IN_OUTPUT]
AsJson = Annotated[bool, _flag("Print JSON instead of tables.", name="--json"), IN_OUTPUT]
Force = Annotated[bool, _flag("Overwrite existing files."), IN_OUTPUT]


def _units_of(parameter: Quantity) -> tuple[str, ...]:
    """Return the allowed units of an option for a parameter of a machine."""
    if parameter.unit == "1":
        return ()
    return units_of(parameter.name)


# For one rotor or several, dimensionless or in SI units, or in an archive.
ONE = {
    each.name: Annotated[
        float | None,
        _quantity(each.either_help, *_units_of(each))
        if _units_of(each)
        else _number(each.either_help),
    ]
    for each in TABLE
}
SEVERAL = {
    each.name: Annotated[list[float] | None, _numbers(each.either_axis_help, *_units_of(each))]
    for each in TABLE
}

Fields = TypeVar("Fields", bound=type)


def with_parameters(
    options: Mapping[str, Any], defaults: Mapping[str, float | None]
) -> Callable[[Fields], Fields]:
    """Return a decorator that puts parameters before the fields of a dataclass.

    Parameters
    ----------
    options : mapping of str to type
        The type of each parameter, with its option.
    defaults : mapping of str to float or None
        Default values of optional parameters.
    """

    def add(group: Fields) -> Fields:
        group.__annotations__ = {**options, **group.__annotations__}
        for name, value in defaults.items():
            setattr(group, name, value)
        return group

    return add


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters({**ONE, "machine": MachineFile}, dict.fromkeys([*ONE, "machine"]))
class RotorOptions:
    """One rotor, without dimensions or in SI units."""

    if TYPE_CHECKING:
        machine: Path | None = None

    @property
    def in_si(self) -> bool:
        """Whether it is in SI units."""
        return self.machine is not None or bool(self.given.keys() & set(MACHINE_PARAMETERS))

    @property
    def given(self) -> dict[str, float]:
        """The given quantities."""
        return {name: getattr(self, name) for name in ONE if getattr(self, name) is not None}

    def chosen(self, known: Mapping[str, float] = {}) -> Rotor | DimensionalRotor:
        """Return the rotor, dimensionless or in SI units, from the given and `known` quantities."""
        return machines.chosen({**self.given, **known}, self.machine, OPTIONAL)

    def rotor_and_units(self) -> tuple[Rotor, Units]:
        """Return the dimensionless rotor, and the units of the command."""
        chosen = self.chosen()
        return chosen if isinstance(chosen, Rotor) else chosen.rotor(), Units.of(chosen)


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters({**SEVERAL, "machine": MachineFile}, dict.fromkeys([*SEVERAL, "machine"]))
class RotorsOptions:
    """The rotors of a study; without an optional parameter, all have its default."""

    if TYPE_CHECKING:
        machine: Path | None = None

    @property
    def in_si(self) -> bool:
        """Whether they are in SI units."""
        return self.machine is not None or bool(self.values.keys() & set(MACHINE_PARAMETERS))

    @property
    def values(self) -> dict[str, list[float]]:
        """The values of each quantity that is given."""
        return {name: getattr(self, name) for name in SEVERAL if getattr(self, name) is not None}

    def given_and_units(
        self, known: Mapping[str, list[float]] = {}
    ) -> tuple[dict[str, Any], Units]:
        """Return the given parameters without dimensions, and the units of the command.

        One value of an optional parameter does not make an axis.
        """
        values, units = {**self.values, **known}, Units()
        if self.machine is None:
            machines.check_complete(values, OPTIONAL)
        if self.in_si:
            values, machine = machines.axes_of(values, self.machine)
            units = Units(machine)
        return {
            name: each[0] if name in OPTIONAL and len(each) == 1 else each
            for name, each in values.items()
        }, units

    def axes(self) -> list[list[float]]:
        """Return the values of each given parameter."""
        return list(self.values.values())

    def panels(self, over: str = "") -> int:
        """Return the number of panels of a figure over one of the parameters."""
        return math.prod(
            len(each)
            for name, each in self.values.items()
            if machines.BECOMES.get(name, name) != over
        )


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
class WhirlsOptions(RotorsOptions):
    """Rotors for lists of whirls."""

    def without_load(self, known: Mapping[str, list[float]] = {}) -> tuple[dict[str, Any], Units]:
        """Return the given parameters that affect exact whirls, and their units."""
        given, units = self.given_and_units(known)
        if given.pop("load", 0.0) != 0.0:
            raise InputError("load must be 0 for exact whirls: under a load there are none")
        radii = given.pop("disc_radius", None)  # it moves no whirl
        if radii is not None:
            check_axis("disc_radius", radii)
        return given, units


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters(
    {name: Annotated[SEVERAL[name], Parameter(show=False)] for name in SPEEDS},
    dict.fromkeys(SPEEDS),
)
class AllSpeedsOptions(WhirlsOptions):
    """Rotors for lists of folds or Hopf points, which are found at all speeds."""

    def without_speed(self) -> tuple[dict[str, Any], Units]:
        """Return the given parameters that affect these points, and their units."""
        for name in SPEEDS:
            if name in self.values:
                raise InputError(f"{name} must be left out: all speeds are searched")
        speed = "speed" if self.in_si else "omega"
        if self.machine is None:
            machines.check_complete(self.values, OPTIONAL, known=(speed,))
        given, units = self.without_load({speed: [ANY_SPEED]} if self.machine is None else {})
        del given["omega"]
        return given, units


@Parameter(name="*", group=SPEED)
@dataclass(frozen=True, kw_only=True)
class ChangeOptions:
    """Options for the course of the speed."""

    to: Annotated[
        float | None,
        _quantity(
            "Final speed of a ramp (SI: rad/s, or as 3000rpm).",
            "rad s-1",
        ),
    ] = None
    rate: Annotated[
        float | None,
        _quantity(
            "Rate of change of the speed on a ramp (SI: rad/s2, or as 100rpm/s).",
            "rad s-2",
        ),
    ] = None
    speeds: Annotated[
        list[tuple[float, float]] | None,
        Parameter(
            help="Speeds at given times, the first at time 0, linear in between (SI: s and "
            "rad/s, or as 20:3000rpm).",
            metavar="TIME:SPEED",
            converter=parsing.converter(parsing.speeds),
            n_tokens=1,
            consume_multiple=True,
            negative=(),
        ),
    ] = None
    torque: Annotated[
        tuple[float, float] | None,
        _several_numbers(
            "Drive torque at standstill, and its decrease with the speed (SI: N m, N m s).",
            "TAU0 SLOPE",
            "N m",
            "N m s",
        ),
    ] = None
    inertia: Annotated[
        float | None,
        _quantity(
            "Moment of inertia of the rotor and drive, divided by mass times eccentricity "
            "squared (SI: kg m2).",
            "kg m2",
        ),
    ] = None
    duration: Annotated[
        float | None,
        _quantity(
            "Time to simulate (SI: s). Required with a torque; default: as long as the speed "
            "changes.",
            "s",
        ),
    ] = None

    ramp_time: Annotated[
        float | None,
        _quantity(
            "Duration of a ramp, instead of its rate (SI: s).",
            "s",
            name=("--ramp-time", "--in"),
        ),
    ] = None
    begin: Annotated[
        float | None,
        _quantity(
            "Initial speed (SI: rad/s, or as 300rpm). Default: --omega or --speed, or 0 with "
            "--machine.",
            "rad s-1",
            name="--from",
        ),
    ] = None

    def beginning(self, rotor: RotorOptions) -> Rotor | DimensionalRotor:
        """Return a rotor at its initial speed: a file contains the running speed."""
        speed, given = "speed" if rotor.in_si else "omega", rotor.given
        if self.begin is None:
            at_rest = rotor.machine is not None and speed not in given and self.speeds is None
            return rotor.chosen({speed: 0.0} if at_rest else {})
        if speed in given:
            raise InputError(f"{speed} must be left out with --from, got both")
        return rotor.chosen({speed: self.begin})

    def of(self, machine: Rotor | DimensionalRotor) -> dict[str, Any]:
        """Return the arguments for `run_up`, without dimensions."""
        given = {name: each for name, each in asdict(self).items() if name != "begin"}
        if isinstance(machine, DimensionalRotor):
            return dict(machine.change_of_speed(**given))
        return given


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class SolverOptions:
    """Options for the computation of one motion."""

    rtol: Rtol = 1e-10
    atol: Atol = 1e-12
    method: ContactMethod = "adams"
    flight: Annotated[Flight, Parameter(help="Method for the motion inside the clearance.")] = (
        "exact"
    )
    backend: SolverBackend = "auto"


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class RunUpSolverOptions:
    """Options for the computation of one motion at a changing speed."""

    rtol: Rtol = 1e-10
    atol: Atol = 1e-12
    method: ContactMethod = "adams"
    backend: SolverBackend = "auto"


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class AnySolverOptions(SolverOptions):
    """Options for the computation of one motion, of one disc or a rotor system."""

    method: MethodOfAny = None  # type: ignore[assignment]


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class AnyRunUpSolverOptions(RunUpSolverOptions):
    """Options for the computation of one motion at a changing speed, of either."""

    method: MethodOfAny = None  # type: ignore[assignment]


def of_disc(solver: SolverOptions | RunUpSolverOptions) -> dict[str, Any]:
    """Return options of the solver for one disc, whose default method is not that of a system."""
    chosen = asdict(solver)
    return chosen | {"method": chosen["method"] or SolverOptions.method}


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class JobOptions:
    """Options for the executor of many motions."""

    workers: Workers = None
    executor: Annotated[
        str,
        Parameter(
            help="Executor of the jobs: auto, serial, threads, processes, dask, or the address "
            "of a dask scheduler.",
            metavar="NAME|ADDRESS",
        ),
    ] = "auto"

    def on_every_core(self) -> dict[str, Any]:
        """Return it, with all cores by default: the program guards its main part."""
        from rotor_ida.parallel import count_workers  # noqa: PLC0415 - heavy, and not for --help

        every_core = self.workers is None and self.executor == "auto"
        workers = count_workers(None) if every_core else self.workers
        return {"workers": workers, "executor": self.executor}


@Parameter(name="*", group=STUDY)
@dataclass(frozen=True, kw_only=True)
class DrawnOptions:
    """Options for random starts and their labels."""

    x: Range = 0.0
    y: Range = 0.0
    vx: Range = 0.0
    vy: Range = 0.0
    starts: StartCount = 1000
    seed: Seed = 0
    rtol: RtolOrNone = None

    def of(self, units: Units) -> dict[str, Any]:
        """Return it without dimensions."""
        given = asdict(self)
        return given | {name: units.component(name, given[name]) for name in COMPONENTS}


def _named(text: str, words: str) -> Parameter:
    return Parameter(help=text, metavar=words, consume_multiple=True, negative=())


@Parameter(name="*", group=READING)
@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """Options for reading a measured file; not for archives."""

    columns: Annotated[
        list[str] | None,
        _named(
            "Columns of t, x, y and keyphasor, angle or speed. Default: guessed from their names.",
            "SIGNAL=COLUMN",
        ),
    ] = None
    units: Annotated[
        list[str] | None,
        _named("Units of the columns: s, ms, m, mm, um, mil, V, rad, deg, rpm, Hz.", "SIGNAL=UNIT"),
    ] = None
    rate: Annotated[
        float | None, _number("Sampling rate in samples per second, for a file without times.")
    ] = None
    probe_angles: Annotated[
        tuple[float, float] | None,
        _several_numbers("Angles of the probes from the x axis in degrees. Default: 0 90.", "X Y"),
    ] = None
    gains: Annotated[
        tuple[float, float] | None,
        _several_numbers("Gain of each probe: reading divided by displacement.", "X Y"),
    ] = None
    sensitivity: Annotated[
        str | None,
        Parameter(
            help="Sensitivity of both probes, such as 200mV/mil or 7.87V/mm.",
            metavar="VOLTS/LENGTH",
        ),
    ] = None
    keyphasor: Annotated[
        Literal["auto", "signal", "times"] | None,
        Parameter(help="Form of the keyphasor: a sampled signal, or pulse times."),
    ] = None
    pulses_per_revolution: Annotated[
        int | None, _whole_number("Keyphasor pulses per revolution.", 1, MOST_NUMBERS)
    ] = None
    accept_clipped: Annotated[bool, _flag("Accept clipped probe signals.")] = False
    fill_pulses: Annotated[bool, _flag("Replace lost pulses by evenly spaced ones.")] = False

    def given(self) -> dict[str, Any]:
        """Return the given options as arguments of `rotor_ida.read_signals`."""
        found = {name: value for name, value in asdict(self).items() if value not in (None, False)}
        for name in ("columns", "units"):
            if name in found:
                found[name] = dict(parsing.named(name, found[name]))
        return found
