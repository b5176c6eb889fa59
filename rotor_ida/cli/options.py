"""Options shared by several commands: their types, help and groups."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from rotor_ida.checks import MOST_NUMBERS, MOST_WORKERS, State
from rotor_ida.cli import parsing
from rotor_ida.cli.option_types import (
    IN_OUTPUT,
    IN_ROTOR,
    IN_SOLVER,
    READING,
    SOLVER,
    count_option,
    flag_option,
    number_option,
    numbers_option,
    path_option,
    several_numbers_option,
    words_option,
)

START = Parameter(
    help="Initial state: displacements and velocities; settled, the steady whirl without contact; "
    "or rest, in equilibrium with the load. Default: rest, or what a system file says.",
    metavar="X Y VX VY|settled|rest",
    converter=parsing.converter(parsing.start),
    n_tokens=4,
    negative=(),
    show_default=False,
)
StartOrNone = Annotated[State | str | None, START]
STARTS = Parameter(
    help="Initial states, one or more, or the words settled (steady whirl without contact) and "
    "rest (in equilibrium with the load) for those of each rotor. Default: at rest on the axis, or "
    "what a system file says.",
    metavar="X Y VX VY|settled|rest",
    converter=parsing.converter(parsing.starts),
    n_tokens=4,
    consume_multiple=True,
    negative=(),
    show_default=False,
)
Range = Annotated[
    float | tuple[float, float],
    Parameter(
        help="Component of the initial states, or the range from which it is drawn.",
        metavar="FLOAT|LOW:HIGH",
        converter=parsing.converter(parsing.component_or_ends),
        negative=(),
    ),
]
RangeOrNone = Annotated[
    float | tuple[float, float] | None,
    Parameter(
        help="Component of random initial states, or the range from which it is drawn. Default: "
        "-5:5, in eccentricities and, for velocities, times the reference frequency.",
        metavar="FLOAT|LOW:HIGH",
        converter=parsing.converter(parsing.component_or_ends),
        negative=(),
    ),
]
RtolOrNone = Annotated[
    float | None, number_option("Relative tolerance. Default: chosen automatically."), IN_SOLVER
]
# What can vary along a branch or a sweep, of a rotor, a machine or a rotor system.
OfRotor = Literal[
    "omega", "zeta", "delta0", "speed", "damping", "clearance", "shaft_stiffness",
    "contact_damping", "load", "friction", "disc_radius", "stiffness", "unbalance",
]  # fmt: skip
Workers = Annotated[
    int | None,
    count_option("Number of parallel jobs. Default: one per core.", 1, MOST_WORKERS),
    IN_SOLVER,
]
Executor = Annotated[
    str,
    Parameter(
        help="Executor of the jobs: auto, serial, threads, processes, dask, or the address of a "
        "dask scheduler.",
        metavar="NAME|ADDRESS",
    ),
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
OR_MACHINE = Parameter(help="Rotor system from a TOML file, or a machine with --machine.")
NodeOfFigure = Annotated[
    str | None,
    Parameter(
        help="Node of a rotor system at which the figure is drawn. Default: that of a contact.",
        metavar="NAME",
    ),
    IN_OUTPUT,
]
WithoutGravity = Annotated[
    bool, flag_option("Leave out the gravity of the system's file: whirls have none."), IN_ROTOR
]
Study = Annotated[
    Path | None,
    path_option("Save results in this folder as they are computed, so that resume can continue."),
    IN_OUTPUT,
]
Out = Annotated[Path | None, path_option("Write the result to this netCDF file (.nc)."), IN_OUTPUT]
Figure = Annotated[
    Path | None,
    path_option("Draw the result to NAME.png and NAME.svg, or to NAME.pdf."),
    IN_OUTPUT,
]
SignalFile = Annotated[
    Path,
    path_option(
        "Archive (.nc) or measured file: text, .wav, .mat, .h5, .npz, .uff, .tdms, .lvm, .cff, or "
        ".cfg with .dat.",
        name="FILE",
    ),
]
Csv = Annotated[
    Path | None,
    path_option(
        "Write the result as tables to this CSV file, or to NAME.TABLE.csv where it has several."
    ),
    IN_OUTPUT,
]
ReportFolder = Annotated[
    Path | None,
    path_option(
        "Write a report to this folder as HTML and PDF: answer, rotor, figure, assumptions, "
        "versions, and the lines that compute it again, with the archive."
    ),
    IN_OUTPUT,
]
Orders = Annotated[
    list[float] | None,
    numbers_option("Orders to track, or to mark in a cascade or spectrogram."),
]
Times = Annotated[
    tuple[float, float] | None,
    several_numbers_option("Use only the signals between these times.", "START END", "s", "s"),
]
Inch = Annotated[
    bool, flag_option("Print tables in mils, lbf and oz in instead of um, N and g mm."), IN_OUTPUT
]
AsJson = Annotated[bool, flag_option("Print JSON instead of tables.", name="--json"), IN_OUTPUT]
Force = Annotated[bool, flag_option("Overwrite existing files."), IN_OUTPUT]


@Parameter(name="*", group=SOLVER)
@dataclass(frozen=True, kw_only=True)
class JobOptions:
    """Options for the executor of many motions."""

    workers: Workers = None
    executor: Executor = "auto"

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
