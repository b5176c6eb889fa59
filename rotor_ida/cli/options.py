"""Options of the commands: their help, how their words are read, and their group in the help."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_type_hints

from cyclopts import Group, Parameter

from rotor_ida.checks import COMPONENTS, MOST_NUMBERS, MOST_WORKERS
from rotor_ida.cli import parsing
from rotor_ida.cli.option_types import (
    IN_ROTOR,
    OUTPUT,
    READING,
    ROTOR,
    SOLVER,
    SPEED,
    count_option,
    flag_option,
    number_option,
    numbers_option,
    path_option,
    quantity_option,
    several_numbers_option,
    words_option,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import TABLE
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM

# What can vary along a branch or a sweep, of a rotor, a machine or a rotor system.
OfRotor = Literal[
    "omega", "zeta", "delta0", "speed", "damping", "clearance", "shaft_stiffness",
    "contact_damping", "load", "friction", "disc_radius", "stiffness", "unbalance",
]  # fmt: skip
System = Annotated[
    Path | None,
    Parameter(
        name="SYSTEM",
        help="Rotor system from a TOML file, instead of the options of one disc but --speed.",
        converter=parsing.converter(parsing.system_file),
    ),
    IN_ROTOR,
]
OR_MACHINE = Parameter(help="Rotor system from a TOML file, or a machine with --machine.")
SYSTEM_ALONE = Parameter(help="Rotor system from a TOML file.")
FILE = (
    "Archive (.nc) or measured file: text, .wav, .mat, .h5, .npz, .uff, .tdms, .lvm, .cff, or "
    ".cfg with .dat."
)
FILES = Annotated[Path, path_option(FILE, name="FILE")]
STATE = "X Y VX VY|settled|rest"
ENDS = "Component of the initial states, or the range from which it is drawn."
_UNITS = {each.unit for each in TABLE} | {each.unit for each in PARAMETERS_OF_SYSTEM.values()}


def read_by(
    text: str, reading: Callable[..., object], metavar: str | None = None, *allowed: str,
    **more: Any,
) -> Parameter:  # fmt: skip
    """Return an option whose words are read by a function of `rotor_ida.cli.parsing`."""
    more |= {} if metavar is None else {"metavar": metavar}
    return Parameter(help=text, converter=parsing.converter(reading, *allowed), negative=(), **more)


def _state(text: str) -> Parameter:
    return read_by(text, parsing.start, STATE, n_tokens=4, show_default=False)


def _states(text: str) -> Parameter:
    return read_by(
        text, parsing.starts, STATE, n_tokens=4, consume_multiple=True, show_default=False
    )


def _ends(text: str, words: str) -> Parameter:
    return read_by(text, parsing.limits, words, *sorted(_UNITS - {"1"}))


# The options by group and name, those of one command alone after its name; others of functions of
# the package follow from these (`rotor_ida.cli.verb_options`).
OPTIONS: dict[Group | None, dict[str, Parameter]] = {
    ROTOR: {
        "without_gravity": flag_option(
            "Leave out the gravity of a system or the load of a machine: whirls have none."),
        "period": quantity_option(
            "Estimate of the period, for a start near a cycle on the rotating axes (SI: s).", "s"),
        "from_": path_option("Archive of a cycle, branch or curve to start from.", name="--from"),
        "point": count_option(
            "Point of the branch or curve in that archive, counted from 0.", 0, MOST_NUMBERS),
        "special": count_option(
            "Special point of that branch or curve, counted from 0.", 0, MOST_NUMBERS),
    },
    SPEED: {
        "begin": quantity_option(
            "Initial speed (SI: rad/s, or as 300rpm). Default: --omega or --speed, 0 with "
            "--machine, or what a system file says.",
            "rad s-1", name="--from"),
        "speeds": read_by(
            "Speeds at given times, the first at time 0, linear in between (SI: s and rad/s, or as "
            "20:3000rpm).",
            parsing.speeds, "TIME:SPEED", n_tokens=1, consume_multiple=True),
    },
    SOLVER: {
        "rtol": number_option("Relative tolerance. Default: chosen automatically."),
        "workers": count_option("Number of parallel jobs. Default: one per core.", 1, MOST_WORKERS),
        "executor": Parameter(
            help="Executor of the jobs: auto, serial, threads, processes, dask, or the address of "
            "a dask scheduler.",
            metavar="NAME|ADDRESS"),
        "verify method": Parameter(
            help="Solver of the new computation. Default: that of the archive."),
    },
    OUTPUT: {
        "study": path_option(
            "Save results in this folder as they are computed, so that resume can continue."),
        "out": path_option("Write the result to this netCDF file (.nc)."),
        "machine out": path_option("Write the machine to this TOML file."),
        "from_ross out": path_option("Write the rotor to this system file (.toml)."),
        "drop out": path_option("Folder of the report, which is made.", name=("--out", "--report")),
        "reproduce out": path_option("Folder for archives and figures."),
        "figure": path_option("Draw the result to NAME.png and NAME.svg, or to NAME.pdf."),
        "plot figure": path_option(
            "Draw to NAME.png and NAME.svg, or to NAME.pdf. Default: named after FILE and kind."),
        "csv": path_option(
            "Write the result as tables to this CSV file, or to NAME.TABLE.csv where it has "
            "several."),
        "report": path_option(
            "Write a report to this folder as HTML and PDF: answer, rotor, figure, assumptions, "
            "versions, and the lines that compute it again, with the archive."),
        "film": path_option("Write a film of the orbits to this file (.gif, or .mp4)."),
        "export": path_option(
            "Write a page that needs no server, for the speeds of --speeds, and stop."),
        "inch": flag_option("Print tables in mils, lbf and oz in instead of um, N and g mm."),
        "as_json": flag_option("Print JSON instead of tables.", name="--json"),
        "force": flag_option("Overwrite existing files."),
        **dict.fromkeys(("poincare_section node", "bifurcation_diagram node"), Parameter(
            help="Node of a rotor system at which the figure is drawn. Default: that of a contact.",
            metavar="NAME")),
    },
    None: {
        "start": _state(
            "Initial state: displacements and velocities; settled, the steady whirl without "
            "contact; or rest, in equilibrium with the load. Default: rest, or what a system file "
            "says."),
        "start with node": read_by(
            "How the other nodes of a rotor system start: settled (steady whirl without contact) "
            "or rest (in equilibrium with the load). Default: what its file says.",
            parsing.start, "settled|rest", n_tokens=4, show_default=False),
        "fit start": _state(
            "State at the beginning of the record; settled, the steady whirl without contact; or "
            "rest. Default: it is fitted too."),
        "starts": _states(
            "Initial states, one or more, or the words settled (steady whirl without contact) and "
            "rest (in equilibrium with the load) for those of each rotor. Default: rest, or "
            "what a system file says."),
        "bifurcation_diagram starts": _states(
            "Initial states, one or more, instead of random ones; also settled (steady whirl "
            "without contact) and rest (in equilibrium with the load)."),
        "run_ups starts": _states(
            "Initial states, one or more, or the words settled (steady whirl without contact) and "
            "rest (in equilibrium with the load) for those of each rotor. Default: rest, or what a "
            "system file says."),
        "along": Parameter(
            help="Parameter that rises or falls with --direction; for a machine speed, damping or "
            "clearance replace omega, zeta or delta0. Default: the speed, or else the only one "
            "with several values."),
        "contact": read_by(
            "Contact of a rotor system whose events or peaks are meant: number or node.",
            parsing.number_or_name, "NUMBER|NODE"),
        "parameters": Parameter(
            help="The two parameters to vary, from the choices of continue-cycle; of a rotor "
            "system by default speed and clearance.",
            metavar="NAME NAME", negative=(), show_default=" ".join),
        "continue_cycle limits": _ends(
            "Smallest and largest value of the parameter (of a machine in SI units, or as "
            "3000rpm).",
            "LOW HIGH"),
        "bifurcation_curve limits": _ends(
            "Smallest and largest value of each parameter.", "LOW HIGH LOW HIGH"),
        **{f"basin {name}": read_by("Component of the initial states: a number or a range.",
            parsing.component_or_range, "FLOAT|START:STOP:COUNT",
        ) for name in COMPONENTS},
        **{name: read_by(ENDS, parsing.component_or_ends, "FLOAT|LOW:HIGH")
           for name in COMPONENTS},
        **{f"bifurcation_diagram {name}": read_by(
            "Component of random initial states, or the range from which it is drawn. Default: "
            "-5:5, in eccentricities and, for velocities, times the reference frequency.",
            parsing.component_or_ends, "FLOAT|LOW:HIGH",
        ) for name in COMPONENTS},
        "folds": flag_option("List the folds too."),
        "own_unbalance": flag_option(
            "Take the unbalance of the file as residual, instead of that of the formula."),
        "quick": flag_option("Compute coarser results, faster."),
        "studies": flag_option(
            "Compute the studies as well as the figures of the paper.", name="--all"),
        "only": Parameter(
            help="Scenarios to run: names, or beginnings of names.",
            consume_multiple=True, negative=()),
        "drops": count_option(
            "Number of drops at random, beside one. Default: that of the file.", 2, 100_000),
        "stored file": path_option("Archive written by rotor-ida (.nc).", name="FILE"),
        "folder": path_option("Folder of a study.", name="FOLDER"),
        "explore file": path_option(
            "Shown first: a machine, a rotor system, an archived run or a measurement."),
        "port": count_option("Port on this computer; 0 picks a free one.", 0, 65_535),
        "no_browser": flag_option("Print the address without opening a browser."),
        "explore speeds": numbers_option(
            "Speeds of the exported page: numbers (of a machine in rad/s, or as 3000rpm), or "
            "START:STOP:COUNT.",
            "rad s-1"),
        "plot file": path_option(FILE, name="FILE"),
        "times": several_numbers_option(
            "Use only the signals between these times.", "START END", "s", "s"),
        "unknown": words_option(
            "Parameters to fit: names of rotor options, or unbalance_angle; of a rotor system "
            "damping, stiffness, clearance, friction, unbalance, contact_stiffness, "
            "contact_damping.",
            "NAME"),
        "fit node": words_option(
            "Nodes of a rotor system at which the probes look, if --columns does not name them, as "
            "by disc:x=A disc:y=B seal:x=C seal:y=D.",
            "NAME"),
        "entries": numbers_option(
            "Measured times at which contacts begin, in the unit of the signals or as 20ms.", "s"),
        "exits": numbers_option("The same, at which contacts end.", "s"),
        "time_error": quantity_option("Standard error of these times.", "s"),
        "noise": quantity_option(
            "Standard deviation of the noise, in the unit of the probes or as 2um. Default: that "
            "of the residuals.",
            "m"),
        "limit": number_option("Longest time to search, in s. The best trial is reported then."),
        "plot kind": Parameter(
            help="Plot to draw. Default: one that suits the file. Also understood: waterfall for "
            "cascade, spectrum for full-spectrum, campbell for spectrogram."),
        "plot node": Parameter(
            help="Node of a rotor system at which probes look at the shaft.", metavar="NAME"),
        "plot contact": count_option(
            "Contact whose forces are drawn, counted from 0.", 0, MOST_NUMBERS),
        "at": quantity_option(
            "Instant of a deflected shape. Default: the largest deflection.", "s"),
        "exact": flag_option(
            "Also draw the exact response, cycle or backward whirl of the archived rotor."),
        "order": number_option(
            "Order in Bode and polar plots, as a multiple of the speed. Default: 1."),
        "plot orders": numbers_option(
            "Orders to track, to fit together with the one of a Bode or polar plot or the mean "
            "position, or to mark in a cascade or spectrogram."),
        "revolutions": count_option(
            "Revolutions in each window of an order or a mean position. Default: as suits the "
            "record.",
            1, MOST_NUMBERS),
        "sense": Parameter(
            help="The whirl of Bode and polar plots, zero to peak, or the probe, peak to peak."
        ),
        "over": Parameter(help="Axis of a cascade or spectrogram: speed or time."),
        "span": number_option("Largest frequency to show, as a multiple of the speed."),
        "segment": count_option(
            "Number of samples in each segment of a spectrum.", 16, MOST_NUMBERS),
        "plot clearance": quantity_option(
            "Clearance of a measured machine, in the unit of the probes or as 150um.", "m"),
    },
}  # fmt: skip
BY_NAME = {name: (each, *([] if group is None else [Parameter(group=group)]))
           for group, options in OPTIONS.items() for name, each in options.items()}  # fmt: skip
Fields = TypeVar("Fields", bound=type)


def option(kind: Any, *names: str) -> Any:
    """Return a type with the option of the first name that there is, or else unchanged."""
    found = next((BY_NAME[name] for name in names if name in BY_NAME), ())
    return Annotated[(kind, *found)] if found else kind


def with_options(command: Callable[..., object]) -> Callable[..., object]:
    """Return a command with the options of its arguments, for cyclopts."""

    def run(*words: Any, **given: Any) -> object:
        return command(*words, **given)

    run.__name__ = name = command.__name__
    run.__doc__, run.__annotations__ = command.__doc__, {}
    given = inspect.signature(command, eval_str=True)
    of = command.__module__.rpartition(".")[2]
    run.__signature__ = given.replace(parameters=[  # type: ignore[attr-defined]
        each.replace(annotation=option(
            each.annotation, f"{name} {each.name}", f"{of} {each.name}", each.name
        ))
        for each in given.parameters.values()
    ])  # fmt: skip
    return run


def optioned(group: Fields) -> Fields:
    """Give the fields of a dataclass their options."""
    kinds = get_type_hints(group, include_extras=True)
    group.__annotations__ = {name: option(kinds[name], name) for name in group.__annotations__}
    return group


@Parameter(name="*", group=SOLVER)
@optioned
@dataclass(frozen=True, kw_only=True)
class JobOptions:
    """Options for the executor of many motions."""

    workers: int | None = None
    executor: str = "auto"

    def on_every_core(self) -> dict[str, Any]:
        """Return it, with all cores by default: the program guards its main part."""
        from rotor_ida.parallel import count_workers  # noqa: PLC0415 - heavy, and not for --help

        every_core = self.workers is None and self.executor == "auto"
        workers = count_workers(None) if every_core else self.workers
        return {"workers": workers, "executor": self.executor}


# Options of a measured file that `rotor_ida.subtract_runout` takes.
OF_RUNOUT = ("slow_roll", "slow_roll_file", "runout_orders")


@Parameter(name="*", group=READING)
@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """Options for reading a measured file; not for archives."""

    columns: Annotated[
        list[str] | None,
        words_option(
            "Columns of t, x, y and keyphasor, angle or speed. Default: guessed from their names.",
            "SIGNAL=COLUMN",
        ),
    ] = None
    units: Annotated[
        list[str] | None,
        words_option(
            "Units of the columns: s, ms, m, mm, um, mil, V, rad, deg, rpm, Hz.", "SIGNAL=UNIT"
        ),
    ] = None
    rate: Annotated[
        float | None,
        number_option("Sampling rate in samples per second, for a file without times."),
    ] = None
    probe_angles: Annotated[
        tuple[float, float] | None,
        several_numbers_option(
            "Angles of the probes from the x axis in degrees. Default: 0 90.", "X Y"
        ),
    ] = None
    gains: Annotated[
        tuple[float, float] | None,
        several_numbers_option("Gain of each probe: reading divided by displacement.", "X Y"),
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
        int | None, count_option("Keyphasor pulses per revolution.", 1, MOST_NUMBERS)
    ] = None
    accept_clipped: Annotated[bool, flag_option("Accept clipped probe signals.")] = False
    fill_pulses: Annotated[bool, flag_option("Replace lost pulses by evenly spaced ones.")] = False
    gap: Annotated[
        list[str] | None,
        words_option(
            "Position from which displacements and the centre line are counted: the reading of "
            "both probes or of each, as -10V, the mean of a stretch, as 0s 2s, or 0. Default: the "
            "mean position, which is subtracted.",
            "READING|START END",
        ),
    ] = None
    length: Annotated[
        Literal["um", "mm", "m", "nm", "mil", "in"] | None,
        Parameter(help="Unit of displacements, whatever that of the sensitivity."),
    ] = None
    rotation: Annotated[
        Literal["counterclockwise", "clockwise"] | None,
        Parameter(
            help="How the rotor turns, seen from where probe angles are counted; clockwise shows "
            "it from its other end. Default: counterclockwise."
        ),
    ] = None
    caption: Annotated[
        str | None,
        Parameter(
            help="What figures say of the record, as 'Pump 3, 1 March 2026'.", metavar="WORDS"
        ),
    ] = None
    slow_roll: Annotated[
        tuple[float, float] | None,
        several_numbers_option(
            "Subtract the runout between these times, in which the rotor turns slowly.",
            "START END", "s", "s",
        ),
    ] = None  # fmt: skip
    slow_roll_file: Annotated[
        Path | None, path_option("Subtract the runout in this file of the same probes, read alike.")
    ] = None
    runout_orders: Annotated[
        int | None,
        count_option("Highest multiple of the speed of that runout. Default: 1.", 1, MOST_NUMBERS),
    ] = None

    def given(self) -> dict[str, Any]:
        """Return the given options as arguments of `rotor_ida.read_signals`."""
        found = {
            name: value
            for name, value in asdict(self).items()
            if value not in (None, False) and name not in OF_RUNOUT
        }
        for name in ("columns", "units"):
            if name in found:
                found[name] = dict(parsing.named(name, found[name]))
        return found

    def runout(self) -> dict[str, Any]:
        """Return the slow roll, and up to which order, as arguments of the same function."""
        times, file, orders = self.slow_roll, self.slow_roll_file, self.runout_orders
        if times is None and file is None:
            if orders is not None:
                raise InputError("runout_orders must be given with slow_roll or slow_roll_file")
            return {}
        if times is not None and file is not None:
            raise InputError("slow_roll must be left out with slow_roll_file")
        slow = file or tuple(parsing.in_unit("slow_roll", each, "s") for each in times or ())
        return {"slow_roll": slow} | ({} if orders is None else {"runout_orders": orders})
