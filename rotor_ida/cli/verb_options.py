"""Options for the arguments of the functions of the package: types, units, choices and help.

They follow from signatures, docstrings and tables (`rotor_ida.cli.verbs`). Only what a terminal
reads or says in another way than Python stands here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import GenericAlias
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from rotor_ida.checks import COMPONENTS, State
from rotor_ida.cli import options, parsing
from rotor_ida.cli.option_types import (
    IN_CHANGE,
    IN_READING,
    IN_ROTOR,
    IN_SOLVER,
    flag_option,
    number_option,
    numbers_option,
    quantity_option,
    several_numbers_option,
    words_option,
)
from rotor_ida.cli.verbs import Argument, arguments_of, short_text
from rotor_ida.model.scales import UNITS_OF_ARGUMENTS, unit_in_system
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.units import spelled

# Words where those of a docstring are for Python, and others of the functions that make studies.
TEXTS = {
    "samples": "Number of output times. Default: at least 32 per revolution.",
    "rtol": "Relative tolerance.",
    "atol": "Absolute tolerance.",
    "method": "Solver of the contact phases. Default: adams, or taylor without scikit-sundae "
    "and of a rotor system.",
    "method of a study": "Solver of the contact phases. Default: taylor, or adams where taylor "
    "cannot be used.",
    "drop method": "Solver of the contact phases.",
    "flight": "Method for the motion inside the clearance.",
    "backend": "Code that runs the solver.",
    "direction": "Quasi-static sweep: start each speed where the one before ended.",
    "events": "Keep the contact events of all runs, in one table.",
    "torque": "Drive torque at standstill, and its decrease with the speed.",
    "vibration_limit": "Vibration limit, from peak to peak. Default: by the speed.",
    "node": "Node of a rotor system whose initial states these are.",
    "bifurcation_diagram starts": "Number of random initial states of one disc. Default: 8.",
    "bifurcation_diagram rate": "Rate of change of the speed, with --direction. Default: the rotor "
    "settles at each speed.",
    "continue_cycle direction": "Direction: forward is to larger values, or onwards along a "
    "branch.",
    "parameter": "Parameter to vary; for a machine speed, damping or clearance replace omega, "
    "zeta or delta0. Of a rotor system speed (default), clearance, friction, unbalance, damping or "
    "stiffness, as in sweep.",
    "points of a study": "Largest number of points in each direction.",
    "extrema_time": "Time over which extrema are found. Default: 100 / reference frequency.",
    "seed": "Seed of the random numbers.",
    "shocks": "Number of shocks of each kind to apply to each attractor.",
    "stiffness": "Factors of the stiffness of a rotor system with its supports, as --damping is of "
    "its damping.",
    "unbalance": "Largest unbalance of a rotor system, to which all others keep their ratios, as "
    "--clearance and --friction are of its contacts.",
    "along": "Parameter that rises or falls with --direction; for a machine speed, damping or "
    "clearance replace omega, zeta or delta0. Default: the speed, or else the only one with "
    "several values.",
    "entries": "Measured times at which contacts begin, in the unit of the signals or as 20ms.",
    "exits": "The same, at which contacts end.",
    "noise": "Standard deviation of the noise, in the unit of the probes or as 2um. Default: that "
    "of the residuals.",
    "limit": "Longest time to search, in s or as 5min. The best trial is reported then.",
    "plot orders": "Orders to track, to fit together with the one of a Bode or polar plot or the "
    "mean position, or to mark in a cascade or spectrogram.",
    "plot order": "Order in Bode and polar plots, as a multiple of the speed. Default: 1.",
    "plot over": "Axis of a cascade or spectrogram. Default: the speed if it changes and never "
    "reverses.",
    "plot segment": "Number of samples in each segment of a spectrum, cascade or spectrogram.",
    "plot t": "Instant of a deflected shape. Default: the largest deflection.",
    "plot clearance": "Clearance of a measured machine, in the unit of the probes or as 150um.",
}
# How a quantity may be given beside its SI unit, and how several numbers are.
ALSO_AS = {"rad s-1": ", or as 3000rpm", "rad s-2": ", or as 100rpm/s"}
SEVERAL = ": numbers, or START:STOP:COUNT"
NAMES = {"ramp_time": ("--ramp-time", "--in"), "t": "--at"}
PAIRS = {
    "torque": "TAU0 SLOPE", "limits": "LOW HIGH", "bifurcation_curve limits": "LOW HIGH LOW HIGH",
    **dict.fromkeys(("probe_angles", "gains"), "X Y"), "slow_roll": "START END",
}  # fmt: skip
WORDS = {
    "columns": "SIGNAL=COLUMN", "units": "SIGNAL=UNIT", "gap": "READING|START END",
    "sensitivity": "VOLTS/LENGTH", "caption": "WORDS",
}  # fmt: skip
# Units of arguments of functions of signals, whose names are elsewhere those of other things; their
# texts say that numbers alone are in those of the signals.
OF_SIGNALS = {
    **dict.fromkeys(("slow_roll", "t", "entries", "exits", "time_error", "limit"), ("s",)),
    **dict.fromkeys(("clearance", "noise"), ("m",)),
}  # fmt: skip
ALSO_CALLED = {"over": ("time",)}
# Types of options that are read in ways of their own, by `options.OPTIONS`.
ENDS = float | tuple[float, float]
KINDS: dict[str, Any] = {
    "start": State | str | None,
    "speeds": list[tuple[float, float]] | None,
    "period": float | None,
    "parameters": tuple[str, str],
    "continue_cycle limits": tuple[float, float],
    "bifurcation_curve limits": tuple[float, float, float, float],
    "study": Path | None,
    "workers": int | None,
    "executor": str,
    **dict.fromkeys(COMPONENTS, ENDS),
    **{f"basin {name}": float | list[float] for name in COMPONENTS},
}
WITHOUT_DEFAULT = ("start",)
# Those of `run_up` in a group of their own, and of the others in groups of all commands.
OF_CHANGE = {"to", "rate", "ramp_time", "speeds", "torque", "inertia", "duration"}
GROUPS = {
    **dict.fromkeys(("rtol", "atol", "method", "flight", "backend"), IN_SOLVER),
    **dict.fromkeys((*PARAMETERS_OF_SYSTEM, "speed"), IN_ROTOR),
}

Option = tuple[str, Any, object]


def options_of(verb: str, arguments: Mapping[str, Argument]) -> Iterator[Option]:
    """Yield name, annotated type and default of the options for arguments of a function."""
    is_study, of_signals = "study" in arguments, verb in {"plot", "read_signals", "fit"}
    of_rotor = arguments_of("continue_cycle")["parameter"].choices
    for name, each in arguments.items():
        own = f"{verb} {name}"
        if name == "starts" and "Starts" in each.kind:
            yield "start", options.option(list[State | str] | None, own, name), None
            if "int" not in each.kind:
                continue
        elif name in KINDS or own in KINDS:
            kind = KINDS[own] if own in KINDS else KINDS[name]
            if name == "parameters":
                word: Any = Literal
                kind = GenericAlias(tuple, (word[of_rotor],) * 2)
            if name in COMPONENTS and each.default is None:
                kind |= None
            of_node = [f"{name} with node"] if "node" in arguments else []
            default = None if name in WITHOUT_DEFAULT else each.default
            yield name, options.option(kind, *of_node, own, name), default
            continue
        if each.kind == "Quantity":  # text with a unit, for the data sheet of a machine
            entry = options.read_by(short_text(each.text), parsing.word, "VALUE")
            yield name, Annotated[str | None, entry, IN_ROTOR], None
            continue
        known = (f"{verb} {name}", f"{name} of a study" if is_study else name, name)
        text = next((TEXTS[key] for key in known if key in TEXTS), "")
        group = IN_CHANGE if verb == "run_up" and name in OF_CHANGE else GROUPS.get(name)
        group = IN_READING if verb == "read_signals" else None if verb == "plot" else group
        chosen = each._replace(choices=of_rotor) if name == "along" else each
        made = _annotated(chosen, text or short_text(each.text), of_signals)
        default = each.default
        if _is_axis(each) and isinstance(default, float | tuple):
            made = Annotated[made, Parameter(show_default=lambda values: f"{values[0]:g}")]
            default = [default] if isinstance(default, float) else [*default]
        if name == "rtol" and default is None:
            made = options.option(float | None, name)
        yield name, made if group is None else Annotated[made, group], default


def system_axes() -> Iterator[Option]:
    """Yield the options for parameters of a rotor system that one disc does not have."""
    for name in ("stiffness", "unbalance"):
        axis = Argument(name, "npt.ArrayLike", (), None, "")
        yield name, Annotated[_annotated(axis, TEXTS[name]), IN_ROTOR], None


def _is_axis(argument: Argument) -> bool:
    return argument.name != "samples" and (
        "Array" in argument.kind
        or argument.kind == "Sequence[float]"
        or argument.name in {"entries", "exits"}
    )


def _annotated(argument: Argument, text: str, of_signals: bool = False) -> Any:
    """Return the type of an option with its help, by the annotation of an argument."""
    name, kind = argument.name, argument.kind
    units = UNITS_OF_ARGUMENTS.get(name) or tuple(filter(None, [_unit(name)]))
    if of_signals:
        units = OF_SIGNALS.get(name, ())
    elif name == "phase":
        units, text = ("rad",), text.replace("in radians", "in radians or as 90deg")
    elif units and name not in {"samples", "starts"}:
        told = ", ".join(spelled(each) for each in units)
        text = _before_the_end(text, f" (SI: {told}{ALSO_AS.get(units[0], '')})")
    made: Any
    if argument.choices:
        made = Literal[argument.choices + ALSO_CALLED.get(name, ())]
        option = Parameter(help=text)
    elif kind == "bool":
        return Annotated[bool, flag_option(text)]
    elif "int | str" in kind:
        made, option = int | str, options.read_by(text, parsing.number_or_name, "NUMBER|NODE")
    elif name in {"samples", "starts"} or kind.startswith("int"):
        reading = parsing.converter(parsing.whole_number)
        made, option = int, Parameter(help=text, converter=reading)
    elif kind.startswith("tuple") or name in PAIRS:
        both = units * 2 if len(units) == 1 else units
        made, option = tuple[float, float], several_numbers_option(text, PAIRS[name], *both)
    elif _is_axis(argument):
        several = SEVERAL if "Array" in kind else ""
        made, option = list[float], numbers_option(_before_the_end(text, several), *units)
    elif kind.startswith("float"):
        quantity = quantity_option(text, *units, name=NAMES.get(name))
        made, option = float, quantity if units else number_option(text)
    elif "Sequence[str]" in kind or kind.startswith("Mapping"):
        made, option = list[str], words_option(text, WORDS.get(name, "NAME"))
    else:
        made, option = str, Parameter(help=text, metavar=WORDS.get(name, "NAME"))
    return Annotated[made | None if argument.default is None else made, option]


def _unit(name: str) -> str:
    """Return the unit of an argument of functions of a rotor system; empty if it has none."""
    return (name in PARAMETERS_OF_SYSTEM and PARAMETERS_OF_SYSTEM[name].unit.replace("1", "")) or (
        unit_in_system(name) or ""
    )


def _before_the_end(text: str, more: str) -> str:
    """Return a text with more before the end of its first sentence."""
    first, point, others = text.partition(". ")
    return f"{first}{more}{point}{others}" if point else f"{text.removesuffix('.')}{more}."
