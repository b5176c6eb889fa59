"""Options that several commands share: their types, their help, and the groups they come in."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from cyclopts import Parameter
from cyclopts.validators import Number

from rotor_ida.checks import (
    COMPONENTS,
    LARGEST_SEED,
    MOST_NUMBERS,
    MOST_SHOCKS,
    MOST_WORKERS,
    State,
    check_axis,
)
from rotor_ida.cli import machines, parsing
from rotor_ida.cli.machines import Units
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import (
    MACHINE_PARAMETERS,
    OPTIONAL,
    TABLE,
)
from rotor_ida.model.parameters import Parameter as Quantity
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.simulation.options import Backend, Flight, Method

# Where a speed is needed, and none is looked at.
ANY_SPEED = 1.0


def check_varies(points: int) -> None:
    """Refuse a figure of an atlas of so many rotors in which nothing varies."""
    if points < 2:
        raise InputError("figure needs an atlas of several speeds, dampings or clearances, got one")


def _number(text: str) -> Parameter:
    return Parameter(help=text, converter=parsing.converter(parsing.number))


def _quantity(text: str, *allowed: str, name: str | Sequence[str] | None = None) -> Parameter:
    """Return an option for a number, which may have a unit as those that are allowed."""
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
    """Return an option for values of a parameter, whose unit depends on which it is."""
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
    help="Where the motion begins; without it, at rest on the axis.",
    metavar="X Y VX VY",
    converter=parsing.converter(parsing.start),
    negative=(),
    show_default=False,
)
Start = Annotated[State, START]
StartOrNone = Annotated[State | None, START]
Starts = Annotated[
    list[State],
    Parameter(
        help="Where each motion begins, given once or more; without it, at rest on the axis.",
        metavar="X Y VX VY",
        converter=parsing.converter(parsing.starts),
        consume_multiple=True,
        negative=(),
        show_default=False,
    ),
]
Component = Annotated[
    float | list[float],
    Parameter(
        help="Component of the start.",
        metavar="FLOAT|START:STOP:COUNT",
        converter=parsing.converter(parsing.component_or_range),
        negative=(),
    ),
]
Range = Annotated[
    float | tuple[float, float],
    Parameter(
        help="Component of the starts, or the range they are drawn from.",
        metavar="FLOAT|LOW:HIGH",
        converter=parsing.converter(parsing.component_or_ends),
        negative=(),
    ),
]
StartCount = Annotated[
    int, _whole_number("Number of random starts.", 1, parsing.MOST_POINTS_OF_STUDY)
]
ShockCount = Annotated[
    int,
    _whole_number(
        "Number of shocks of each kind that are tried to each attractor.", 0, MOST_SHOCKS
    ),
]
Seed = Annotated[int, _whole_number("Seed of the random numbers.", 0, LARGEST_SEED)]

Period = Annotated[
    float | None,
    _quantity(
        "About the period of a cycle that the start is close to, on the rotating axes; of a "
        "machine in s.",
        "s",
    ),
]
From = Annotated[
    Path | None,
    _path("Begin at the cycle in this archive, or on a branch or curve.", name="--from"),
]
PointNumber = Annotated[
    int | None, _whole_number("Number of the point in the archive.", 0, MOST_NUMBERS)
]
SpecialNumber = Annotated[
    int | None, _whole_number("Number of the special point in the archive.", 0, MOST_NUMBERS)
]
PointCount = Annotated[int, _whole_number("Largest number of points each way.", 2, MOST_NUMBERS)]
Continued = Literal[
    "omega", "zeta", "delta0", "speed", "damping", "clearance", "shaft_stiffness",
    "contact_damping", "load", "friction", "disc_radius",
]  # fmt: skip
OneParameter = Annotated[
    Continued,
    Parameter(
        help="What is varied; omega, zeta and delta0 of a machine are speed, damping, clearance."
    ),
]
TwoParameters = Annotated[
    tuple[Continued, Continued],
    Parameter(
        help="What is varied: two of those that continue takes.",
        metavar="NAME NAME",
        negative=(),
        show_default=" ".join,
    ),
]
Limits = Annotated[
    tuple[float, float],
    _limits(
        "Least and largest value of it, of a machine in its SI unit or as 3000rpm.", "LOW HIGH"
    ),
]
TwoLimits = Annotated[
    tuple[float, float, float, float],
    _limits("Least and largest value of the one, and of the other.", "LOW HIGH LOW HIGH"),
]
Way = Annotated[
    Literal["both", "forward", "backward"],
    Parameter(help="Which way to go: forward is to larger values, or on along a branch."),
]
Bifurcation = Annotated[
    Literal["fold", "period_doubling", "torus"], Parameter(help="What is followed.")
]

Duration = Annotated[float, _quantity("Time to simulate, of a machine in s.", "s")]
ToSpeed = Annotated[
    float,
    _quantity("Speed at the end of the ramps, of a machine in rad/s or as 3000rpm.", "rad s-1"),
]
Rates = Annotated[
    list[float],
    _numbers(
        "Changes of the speed in a unit of time, of a machine in rad/s2 or as 100rpm/s: numbers, "
        "or START:STOP:COUNT.",
        "rad s-2",
    ),
]
Phases = Annotated[
    list[float],
    Parameter(
        help="Angles of the unbalance at time 0, in radians: numbers, or START:STOP:COUNT; without "
        "it, 0.",
        converter=parsing.converter(parsing.numbers),
        consume_multiple=True,
        negative=(),
        show_default=False,
    ),
]
Samples = Annotated[
    int | None,
    _whole_number(
        "Number of times at which the motion is kept. Default: at least 32 in each revolution.",
        2, MOST_NUMBERS,
    ),
]  # fmt: skip
Rtol = Annotated[float, _number("Relative tolerance.")]
Atol = Annotated[float, _number("Absolute tolerance.")]
ContactMethod = Annotated[Method, Parameter(help="Solver of the contact.")]
SolverBackend = Annotated[Backend, Parameter(help="How the solver is called.")]
RtolOrNone = Annotated[float | None, _number("Relative tolerance; without it, one that suits.")]
Workers = Annotated[
    int | None, _whole_number("Jobs done at a time; by default one a core.", 1, MOST_WORKERS)
]

Witness = Annotated[
    Method | None, Parameter(help="Solver that computes it again; by default the same.")
]

File = Annotated[Path, _path("An archive that this program wrote.", name="FILE")]
FileToExplore = Annotated[Path | None, _path("Archived run whose rotor and start are shown first.")]
Port = Annotated[int, _whole_number("Port on this machine; 0 takes any that is free.", 0, 65_535)]
NoBrowser = Annotated[bool, _flag("Print the address, and open no browser.")]
Export = Annotated[
    Path | None, _path("Write a page that needs no server, with the speeds of --speeds, and end.")
]
ExportedSpeeds = Annotated[
    list[float] | None, _numbers("Spin speeds of that page: numbers, or START:STOP:COUNT.")
]
Folder = Annotated[Path, _path("The folder of a study.", name="FOLDER")]
Study = Annotated[
    Path | None,
    _path("Keep what is done in this folder, so that it can go on; result in result.nc."),
]
Out = Annotated[Path | None, _path("Write the result to this new netCDF file.")]
Figure = Annotated[
    Path | None, _path("Draw the result into NAME.png and NAME.svg, or into NAME.pdf.")
]
SignalFile = Annotated[
    Path,
    _path(
        "An archive of a run, run-up or signals (.nc), or a measured file: text, .wav, .mat, .h5, "
        ".npz, .uff, .tdms, .lvm or .cfg with .dat.",
        name="FILE",
    ),
]
NeededFigure = Annotated[Path, _path("Draw into NAME.png and NAME.svg, or into NAME.pdf.")]
PlotKind = Annotated[
    Literal[
        "bode", "polar", "orders", "orbit", "full-spectrum", "cascade", "spectrogram", "centreline",
        "trace",
    ],
    Parameter(help="What to draw."),
]  # fmt: skip
Exact = Annotated[
    bool,
    _flag("Lay the exact response, cycle or backward whirl of the archived rotor beneath."),
]
OneOrder = Annotated[
    float | None, _number("Multiple of the speed, in Bode and polar plots; without it, 1.")
]
Orders = Annotated[
    list[float] | None,
    _numbers("Multiples of the speed: those tracked, or those marked in a cascade or spectrogram."),
]
Sense = Annotated[
    Literal["forward", "backward"] | None, Parameter(help="Which whirl Bode and polar plots show.")
]
Over = Annotated[
    Literal["speed", "t"] | None,
    Parameter(help="What a cascade or spectrogram goes over: the speed, or the time."),
]
Span = Annotated[float | None, _number("Largest frequency shown, over the speed.")]
Segment = Annotated[
    int | None, _whole_number("Number of samples in a segment of a spectrum.", 16, MOST_NUMBERS)
]
ShownClearance = Annotated[
    float | None, _number("Clearance of a measured machine, in the unit of the probes.")
]
Times = Annotated[
    tuple[float, float] | None, _several_numbers("Show only what lies between.", "START END")
]
Unknowns = Annotated[
    list[str],
    Parameter(
        help="What is sought: names of what machine options give, or unbalance_angle.",
        metavar="NAME",
        consume_multiple=True,
        negative=(),
    ),
]
ContactTimes = Annotated[
    list[float] | None, _numbers("Times at which contacts were seen to begin, or to end.")
]
TimeError = Annotated[float | None, _number("Standard error of these times.")]
NoiseLevel = Annotated[
    float | None, _number("Standard deviation of the noise; without it, what the fit leaves.")
]
Results = Annotated[Path, _path("Folder for archives and figures.")]
Direction = Annotated[
    Literal["up", "down", "both"] | None, Parameter(help="Follow the response from speed to speed.")
]
WithFolds = Annotated[bool, _flag("Also list the folds; alone if no --omega is given.")]
Quick = Annotated[bool, _flag("Coarser and faster.")]
Studies = Annotated[
    bool, _flag("Run the studies as well as the figures of the paper.", name="--all")
]
Names = Annotated[
    list[str] | None,
    Parameter(
        help="Names of the scenarios to run, or how they begin.", consume_multiple=True, negative=()
    ),
]
MachineFile = Annotated[
    Path | None,
    _path("A machine in SI units, as rotor-ida machine writes it; other options override it."),
]
MachineOut = Annotated[Path | None, _path("Write the machine to this new TOML file.")]
AsJson = Annotated[bool, _flag("Print one JSON object, not tables.", name="--json")]
Force = Annotated[bool, _flag("Replace files that are there.")]


# A contact's stiffness is in N/m where it is linear.
OTHER_UNITS = {"contact_stiffness": ("N m-1",)}


def _units_of(parameter: Quantity) -> tuple[str, ...]:
    """Return the units in which an option takes a parameter of a machine."""
    if parameter.unit == "1":
        return ()
    return parameter.unit, *OTHER_UNITS.get(parameter.name, ())


# Of one rotor, and of several, without dimensions or in SI units, or in an archive.
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

Group = TypeVar("Group", bound=type)


def with_parameters(
    options: Mapping[str, Any], defaults: Mapping[str, float | None]
) -> Callable[[Group], Group]:
    """Return a decorator that puts parameters before the fields of a dataclass.

    Parameters
    ----------
    options : mapping of str to type
        The type of each parameter, with the option it is.
    defaults : mapping of str to float or None
        The values of those that need not be given.
    """

    def add(group: Group) -> Group:
        group.__annotations__ = {**options, **group.__annotations__}
        for name, value in defaults.items():
            setattr(group, name, value)
        return group

    return add


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
@with_parameters({**ONE, "machine": MachineFile}, dict.fromkeys([*ONE, "machine"]))
class RotorOptions:
    """One rotor, without dimensions or in SI units."""

    if TYPE_CHECKING:
        machine: Path | None

    @property
    def in_si(self) -> bool:
        """Whether it is in SI units."""
        return self.machine is not None or bool(self.given.keys() & set(MACHINE_PARAMETERS))

    @property
    def given(self) -> dict[str, float]:
        """The quantities that are given."""
        return {name: getattr(self, name) for name in ONE if getattr(self, name) is not None}

    def chosen(self, **known: float) -> Rotor | DimensionalRotor:
        """Return the rotor of the two that is given in full, with what is known besides."""
        return machines.chosen(self.given | known, self.machine, OPTIONAL)

    def rotor_and_units(self) -> tuple[Rotor, Units]:
        """Return the rotor without dimensions, and the units in which the command speaks."""
        chosen = self.chosen()
        return chosen if isinstance(chosen, Rotor) else chosen.rotor(), Units.of(chosen)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
@with_parameters({**SEVERAL, "machine": MachineFile}, dict.fromkeys([*SEVERAL, "machine"]))
class RotorsOptions:
    """The rotors of a study; without an optional parameter, all have its default."""

    if TYPE_CHECKING:
        machine: Path | None

    @property
    def in_si(self) -> bool:
        """Whether they are in SI units."""
        return self.machine is not None or bool(self.values.keys() & set(MACHINE_PARAMETERS))

    @property
    def values(self) -> dict[str, list[float]]:
        """The values of each quantity that is given."""
        return {name: getattr(self, name) for name in SEVERAL if getattr(self, name) is not None}

    def given_and_units(self, **known: list[float]) -> tuple[dict[str, Any], Units]:
        """Return what is given without dimensions, and the units in which the command speaks.

        One value of an optional parameter is no axis.
        """
        values, units = self.values | known, Units()
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
        """Return the values of each parameter that is given."""
        return list(self.values.values())

    def panels(self, over: str = "") -> int:
        """Return how many panels a figure over one of the parameters has."""
        return math.prod(
            len(each)
            for name, each in self.values.items()
            if machines.BECOMES.get(name, name) != over
        )


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class WhirlsOptions(RotorsOptions):
    """Rotors of which whirls or folds are listed."""

    @property
    def has_speed(self) -> bool:
        """Whether a speed is given."""
        return self.machine is not None or bool({"omega", "speed"} & self.values.keys())

    def without_load(self) -> tuple[dict[str, Any], Units]:
        """Return what is given, but for what exact whirls do not have, and its units."""
        any_speed = {} if self.has_speed else {"speed" if self.in_si else "omega": [ANY_SPEED]}
        given, units = self.given_and_units(**any_speed)
        if any_speed:
            del given["omega"]
        if given.pop("load", 0.0) != 0.0:
            raise InputError("load must be 0 for exact whirls: under a load there are none")
        radii = given.pop("disc_radius", None)  # it moves none
        if radii is not None:
            check_axis("disc_radius", radii)
        return given, units


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ChangeOptions:
    """How the speed changes."""

    to: Annotated[
        float | None,
        _quantity(
            "Speed at the end of a ramp: of a machine in rad/s, or with its unit, as 3000rpm.",
            "rad s-1",
        ),
    ] = None
    rate: Annotated[
        float | None,
        _quantity(
            "Change of the speed in a unit of time, on a ramp: of a machine in rad/s2, or with "
            "its unit, as 100rpm/s.",
            "rad s-2",
        ),
    ] = None
    speeds: Annotated[
        list[tuple[float, float]] | None,
        Parameter(
            help="Speeds by time, linear in between, the first at time 0: of a machine in s and "
            "rad/s, or as 20:3000rpm.",
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
            "Torque of the drive at rest, and its fall with the speed: of a machine in N m, N m s.",
            "TAU0 SLOPE",
            "N m",
            "N m s",
        ),
    ] = None
    inertia: Annotated[
        float | None,
        _quantity(
            "Moment of inertia that a torque turns, over mass times eccentricity squared: of a "
            "machine in kg m2.",
            "kg m2",
        ),
    ] = None
    duration: Annotated[
        float | None,
        _quantity(
            "Time to simulate: a torque needs it, otherwise as long as the speed changes. Of a "
            "machine in s.",
            "s",
        ),
    ] = None

    ramp_time: Annotated[
        float | None,
        _quantity(
            "Time of a ramp, in place of its rate: of a machine in s.",
            "s",
            name=("--ramp-time", "--in"),
        ),
    ] = None
    begin: Annotated[
        float | None,
        _quantity(
            "Speed at time 0: of a machine in rad/s or as 300rpm. Default: --omega or --speed; 0 "
            "with a file of a machine.",
            "rad s-1",
            name="--from",
        ),
    ] = None

    def beginning(self, rotor: RotorOptions) -> Rotor | DimensionalRotor:
        """Return a rotor at the speed at which it begins: a file tells the running speed."""
        speed, given = "speed" if rotor.in_si else "omega", rotor.given
        if self.begin is None:
            at_rest = rotor.machine is not None and speed not in given and self.speeds is None
            return rotor.chosen(**({speed: 0.0} if at_rest else {}))
        if speed in given:
            raise InputError(f"{speed} must be left out with --from, got both")
        return rotor.chosen(**{speed: self.begin})

    def of(self, machine: Rotor | DimensionalRotor) -> dict[str, Any]:
        """Return it as `run_up` takes it, without dimensions."""
        given = {name: each for name, each in asdict(self).items() if name != "begin"}
        if isinstance(machine, DimensionalRotor):
            return dict(machine.change_of_speed(**given))
        return given


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SolverOptions:
    """How one motion is computed."""

    rtol: Rtol = 1e-10
    atol: Atol = 1e-12
    method: ContactMethod = "adams"
    flight: Annotated[Flight, Parameter(help="Motion inside the clearance.")] = "exact"
    backend: SolverBackend = "auto"


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class RunUpSolverOptions:
    """How one motion at a speed that changes is computed."""

    rtol: Rtol = 1e-10
    atol: Atol = 1e-12
    method: ContactMethod = "adams"
    backend: SolverBackend = "auto"


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class JobOptions:
    """What does the work of many motions."""

    workers: Workers = None
    executor: Annotated[
        str,
        Parameter(
            help="What does the work: auto, serial, threads, processes, dask, or an address of "
            "dask.",
            metavar="NAME|ADDRESS",
        ),
    ] = "auto"

    def on_every_core(self) -> dict[str, Any]:
        """Return it, with all cores by default: the program guards its main part."""
        from rotor_ida.parallel import count_workers  # noqa: PLC0415 - heavy, and not for --help

        every_core = self.workers is None and self.executor == "auto"
        workers = count_workers(None) if every_core else self.workers
        return {"workers": workers, "executor": self.executor}


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class DrawnOptions:
    """Random starts, and how they are labelled."""

    x: Range = 0.0
    y: Range = 0.0
    vx: Range = 0.0
    vy: Range = 0.0
    starts: StartCount = 1000
    seed: Seed = 0
    rtol: Rtol = 1e-6

    def of(self, units: Units) -> dict[str, Any]:
        """Return it without dimensions."""
        given = asdict(self)
        return given | {name: units.component(name, given[name]) for name in COMPONENTS}


def _named(text: str, words: str) -> Parameter:
    return Parameter(help=text, metavar=words, consume_multiple=True, negative=())


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """How a measured file is read; archives need none of it."""

    columns: Annotated[
        list[str] | None,
        _named(
            "Columns of t, x, y and keyphasor, angle or speed in a measured file; by default "
            "guessed from their names.",
            "SIGNAL=COLUMN",
        ),
    ] = None
    units: Annotated[
        list[str] | None,
        _named("Units of the columns: s, ms, m, mm, um, mil, V, rad, deg, rpm, Hz.", "SIGNAL=UNIT"),
    ] = None
    rate: Annotated[float | None, _number("Samples a second, of a file without times.")] = None
    probe_angles: Annotated[
        tuple[float, float] | None,
        _several_numbers("Where the probes are, in degrees from x; without it, 0 90.", "X Y"),
    ] = None
    gains: Annotated[
        tuple[float, float] | None,
        _several_numbers("Reading over displacement of each probe.", "X Y"),
    ] = None
    sensitivity: Annotated[
        str | None,
        Parameter(
            help="Volts over displacement of both probes, such as 200mV/mil or 7.87V/mm.",
            metavar="VOLTS/LENGTH",
        ),
    ] = None
    keyphasor: Annotated[
        Literal["auto", "signal", "times"] | None,
        Parameter(help="Whether the keyphasor was sampled, or is a list of times."),
    ] = None
    pulses_per_revolution: Annotated[
        int | None, _whole_number("Pulses of the keyphasor in a revolution.", 1, MOST_NUMBERS)
    ] = None
    accept_clipped: Annotated[bool, _flag("Take a probe that is clipped as it is.")] = False
    fill_pulses: Annotated[bool, _flag("Set lost pulses evenly into their intervals.")] = False

    def given(self) -> dict[str, Any]:
        """Return what was given, as `rotor_ida.read_signals` takes it."""
        found = {name: value for name, value in asdict(self).items() if value not in (None, False)}
        for name in ("columns", "units"):
            if name in found:
                found[name] = dict(parsing.named(name, found[name]))
        return found
