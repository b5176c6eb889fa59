"""Options of the commands: their help, how their words are read, and their group in the help."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

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
from rotor_ida.model.parameters import TABLE
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM

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
            "--machine, or the value in the system file.",
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
    READING: {
        "slow_roll_file": path_option(
            "Subtract the runout in this file of the same probes, read alike."),
    },
    OUTPUT: {
        "study": path_option(
            "Save results in this folder as they are computed, so that resume can continue."),
        "out": path_option("Write the result to this netCDF file (.nc)."),
        "machine out": path_option("Write the machine to this TOML file."),
        "from_ross out": path_option("Write the rotor to this system file (.toml)."),
        "reproduce out": path_option("Folder for archives and figures."),
        "figure": path_option("Draw the result to NAME.png and NAME.svg, or to NAME.pdf."),
        "csv": path_option(
            "Write the result as tables to this CSV file, or to NAME.TABLE.csv where it has "
            "several."),
        "report": path_option(
            "Write a report to this folder as HTML and PDF: answer, rotor, figure, assumptions, "
            "versions, and the lines that compute it again, with the archive."),
        "film": path_option("Write a film of the orbits to this file (.gif, or .mp4)."),
        "export": path_option(
            "Write a page that needs no server, for the speeds of --speeds, and stop."),
        "inch": flag_option(
            "Write tables, sentences and figures in mils, lbf and oz in, not in um, N and g mm."),
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
            "the value in the system file."),
        "bifurcation_diagram starts": _states(
            "Initial states, one or more, instead of random ones; also settled (steady whirl "
            "without contact) and rest (in equilibrium with the load)."),
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
        "from_ross speed": quantity_option(
            "Speed at which coefficients are frozen (SI: rad/s, or as 3000rpm). Default: they keep "
            "their tables.",
            "rad s-1"),
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
        "file": path_option("Archive written by rotor-ida (.nc).", name="FILE"),
        "from_ross file": path_option("Rotor as ROSS has saved it.", name="FILE"),
        **dict.fromkeys(("status file", "resume file"),
                        path_option("Folder of a study.", name="FOLDER")),
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
        "plot kind": Parameter(
            help="Plot to draw. Default: one that suits the file. Also understood: waterfall for "
            "cascade, spectrum for full-spectrum, campbell for spectrogram."),
        "plot node": Parameter(
            help="Node of a rotor system at which probes look at the shaft.", metavar="NAME"),
        "exact": flag_option(
            "Also draw the exact response, cycle or backward whirl of the archived rotor."),
    },
}  # fmt: skip
BY_NAME = {name: (each, *([] if group is None else [Parameter(group=group)]))
           for group, options in OPTIONS.items() for name, each in options.items()}  # fmt: skip
Fields = TypeVar("Fields", bound=type)


def option(kind: Any, *names: str) -> Any:
    """Return a type with the option of the first name that there is, or else unchanged."""
    found = next((BY_NAME[name] for name in names if name in BY_NAME), ())
    return Annotated[(kind, *found)] if found else kind


def options_of_body(body: Callable[..., object]) -> dict[str, inspect.Parameter]:
    """Return the parameters of a command after its case, with their options."""
    _, *given = inspect.signature(body, eval_str=True).parameters.values()
    return {each.name: each.replace(
        annotation=option(each.annotation, f"{body.__name__} {each.name}", each.name)
    ) for each in given}  # fmt: skip


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
