"""The command plot: practitioners' plots of archives and measured files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast, get_args

import numpy as np
from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import check_choice, check_increasing, shown
from rotor_ida.cli import parsing
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.output import OUT_ENDING, Output, read
from rotor_ida.cli.parsing import in_unit
from rotor_ida.cli.report import Report
from rotor_ida.cli.verbs import arguments_of
from rotor_ida.errors import InputError
from rotor_ida.results.sheets import facts

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from rotor_ida.cli.variables import Description

# Attributes of measured signals that describe how the file was read.
OF_FILE = ("columns", "notes")
OF_SIGNALS = {
    "bode": "plot_bode", "polar": "plot_polar", "orders": "plot_orders", "orbit": "plot_orbit",
    "full-spectrum": "plot_full_spectrum", "cascade": "plot_cascade",
    "spectrogram": "plot_spectrogram", "centreline": "plot_centre_line", "trace": "plot_trace",
}  # fmt: skip
# Those of a whole rotor system.
OF_SYSTEM = {
    "orbits": "plot_node_orbits", "forces": "plot_forces", "history": "plot_run",
    "shape": "plot_shape",
}  # fmt: skip
# Those of sections and diagrams, at a node of a rotor system; a stroboscopic diagram is drawn by
# `plot_strobes`.
OF_RESULTS = {"section": "plot_section", "diagram": "plot_extrema"}
DRAWN_BY = OF_SIGNALS | OF_SYSTEM | OF_RESULTS
# The keywords of these functions that are options, and one by another name.
OF_PLOTS = ("order", "orders", "revolutions", "sense", "over", "span", "segment", "clearance",
            "contact", "t")  # fmt: skip
OPTIONS = {"t": "at"}
# Dimensions besides time that have times, the first and last of each.
OF_TIMES = (
    ("event", "event_time", "event_time"),
    ("contact", "entry_time", "exit_time"),
    ("episode", "entry_time", "exit_time"),
    ("pulse", "keyphasor", "keyphasor"),
)
KindOfPlot = Literal[
    "bode", "polar", "orders", "orbit", "full-spectrum", "cascade", "spectrogram", "centreline",
    "trace", "orbits", "forces", "history", "shape", "section", "diagram",
]  # fmt: skip
# Other names of these.
PLOTS_ALSO_CALLED: dict[str, KindOfPlot] = {
    "waterfall": "cascade", "spectrum": "full-spectrum", "campbell": "spectrogram",
    "colormap": "spectrogram", "nyquist": "polar", "centerline": "centreline",
    "shaft-centerline": "centreline", "timebase": "trace", "waveform": "trace",
    "mode-shape": "shape", "deflected-shape": "shape",
}  # fmt: skip


def _kind_of_plot(name: str, words: Sequence[str]) -> str:
    """Return the kind of plot that a word names, in either case."""
    word = words[0].lower().replace("_", "-")
    return check_choice(name, PLOTS_ALSO_CALLED.get(word, word), get_args(KindOfPlot))


READ_KIND = Parameter(converter=parsing.converter(_kind_of_plot))


@command("none", asks=tuple(f"plot.{each}" for each in DRAWN_BY.values()), only=OF_PLOTS,
         file="FILE", reads=True, most=None)  # fmt: skip
def plot(
    case: Case, *, kind: Annotated[KindOfPlot | None, READ_KIND] = None, exact: bool = False,
    node: str | None = None, times: tuple[float, float] | None = None,
) -> Report:  # fmt: skip
    r"""Plot an archive or a measured file: Bode, orbit, cascade and others.

    The archive of the example of run-up, as suits it, to run_up.png and run_up.svg; then
    a Bode plot with the exact response, and a cascade:

        rotor-ida plot run_up.nc

        rotor-ida plot run_up.nc --kind bode --figure bode --exact

        rotor-ida plot run_up.nc --kind cascade --figure cascade.png

    Probes at 45 and 135 degrees, from a table whose column names are clear (time_s, ...):

        rotor-ida plot probes.csv --kind orbit --figure orbit \
            --probe-angles 45 135 --times 0.5 1

    From a table with other column names:

        rotor-ida plot probes.csv --kind orbit --figure named \
            --columns x=A y=B --units x=um y=um

    A run of a rotor system, its deflected shape at an instant, and the motion at a node:

        rotor-ida plot system.nc --kind shape --at 0.1

        rotor-ida plot system.nc --kind full-spectrum --node seal --figure seal

    A section or a bifurcation diagram of a rotor system, at a node:

        rotor-ida plot strobes.nc --node seal

    Without --figure and --report the figure is named after FILE and kind.
    """
    (file,), chosen = case.measured, case.given
    if chosen.get("over") == "time":
        chosen["over"] = "t"
    if kind is not None:
        _check_options(kind, chosen, exact=exact, node=node)
    elif chosen or exact:
        name = next(iter(chosen), "exact")
        raise InputError(f"kind must be given with {OPTIONS.get(name, name)}")
    case.output = _named_after(file, kind, case.output)
    case.output.check()
    whole = dataset = _dataset_in(file, case.reading, inch=case.output.inch)
    is_whole = kind is None and times is None
    if is_whole and node is not None:
        kind = _kind_with_nodes(dataset)
    if kind in OF_RESULTS and times is not None:
        raise InputError(f"times must be left out with --kind {kind}")
    if kind not in OF_RESULTS and not (is_whole and node is None):
        dataset = _between(_checked_signals(dataset), times)
    if kind in OF_SYSTEM or kind in OF_RESULTS:
        if file.suffix != OUT_ENDING:
            listed = ", ".join(map(repr, OF_SIGNALS))
            raise InputError(f"kind must be one of {listed} for a measured file, got {shown(kind)}")
        if kind == "history" or node is not None:
            chosen["node"] = node
    elif kind is not None or node is not None:
        dataset = _at_node(dataset, node)
    if exact and kind is not None:
        from rotor_ida.cli.exact import exact_beneath  # noqa: PLC0415 - heavy, and not for --help

        chosen["beneath"] = exact_beneath(dataset, kind)
    drawn = _drawn(kind, dataset, chosen)
    record: dict[str, object] = {"file": str(file), "kind": kind or _kind_suiting(dataset)}
    if "t" in dataset.sizes:
        record["samples"] = dataset.sizes["t"]
    record |= {name: str(dataset.attrs[name]) for name in OF_FILE if name in dataset.attrs}
    notes = [
        each.attrs["not_exact"] for each in chosen.get("beneath", ()) if "not_exact" in each.attrs
    ]

    def told(most: int | None) -> Description:
        """Return what is drawn, in a report with the tables of the file."""
        from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help
        from rotor_ida.signals.signs import signs_in  # noqa: PLC0415

        tables = [] if most is None else describe(whole, most=most)[1]
        first = {name: each for name, each in record.items() if not tables or name not in OF_FILE}
        said = {"notes": notes} if notes else {}
        signs = signs_in(dataset) if not tables and "x" in dataset and "y" in dataset else None
        words = [] if signs is None else [str(signs.attrs["sentence"])]
        return record | said, [facts("Plot", first), *notes, *tables, *words]

    return case.report(whole, told=told, figures=lambda: [("Figure", drawn)])


def _named_after(file: Path, kind: str | None, output: Output) -> Output:
    """Return where to write, with a figure named after the file if no place is given for one."""
    if output.figure is not None or output.report is not None:
        return output
    name = f"{file.stem}_{kind}.png" if kind else f"{file.stem}.png"
    return replace(output, figure=file.with_name(name))


def _kind_suiting(dataset: xr.Dataset) -> str:
    """Return the kind of the default figure: of signals that of the plot, else of the dataset."""
    from rotor_ida.plot.figures import plot_suiting  # noqa: PLC0415 - only who draws needs it
    from rotor_ida.results.dataset_kinds import kind_of  # noqa: PLC0415

    kind = kind_of(dataset)
    return plot_suiting(dataset) if kind == "signals" else kind


def _kind_with_nodes(dataset: xr.Dataset) -> KindOfPlot | None:
    """Return the kind of plot at a node of a section or diagram; None for another result."""
    from rotor_ida.results.dataset_kinds import kind_of  # noqa: PLC0415 - only who draws needs it

    kinds: dict[str, KindOfPlot] = {
        "system_section": "section", "system_diagram": "diagram",
        "system_stroboscopic_diagram": "diagram",
    }  # fmt: skip
    return kinds.get(kind_of(dataset))


def _drawn(kind: KindOfPlot | None, dataset: xr.Dataset, chosen: dict[str, Any]) -> Figure:
    """Return the figure of a kind of plot, by default that of the dataset."""
    from rotor_ida import plot as plots  # noqa: PLC0415 - only who draws needs it

    if kind is None:
        return plots.figure_of(dataset)
    if "clearance" in chosen:
        unit = str(dataset["x"].attrs.get("units", "1"))
        chosen["clearance"] = in_unit("clearance", chosen["clearance"], unit)
    if "t" in chosen:
        chosen["t"] = in_unit("at", chosen["t"], str(dataset["t"].attrs.get("units", "1")))
    from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415

    with without_pyplot():
        is_strobed = kind == "diagram" and "rotating_x" in dataset.variables
        name = "plot_strobes" if is_strobed else DRAWN_BY[kind]
        drawn = getattr(plots, name)(dataset, **chosen)
    return cast("Figure", drawn.figure)


def _check_options(
    kind: KindOfPlot, chosen: Iterable[str], *, exact: bool, node: str | None
) -> None:
    """Raise `InputError` for an option that does not apply to a kind of plot."""
    known = {*arguments_of(f"plot.{DRAWN_BY[kind]}")}
    if kind in OF_SIGNALS:
        known |= {"exact", "node"}
    others = {"exact": exact, "node": node is not None}
    for name in (*chosen, *(each for each, is_given in others.items() if is_given)):
        if name not in known:
            raise InputError(f"{OPTIONS.get(name, name)} must be left out with --kind {kind}")


def _at_node(dataset: xr.Dataset, node: str | None) -> xr.Dataset:
    """Return signals at a node of a rotor system; of anything else the dataset, without a node."""
    from rotor_ida.results.checked_run import is_of_system  # noqa: PLC0415

    if node is None and not is_of_system(dataset):
        return dataset
    return rotor_ida.signals_of(dataset, node=node)


def signals_in(
    file: Path, reading: Mapping[str, Any], times: tuple[float, float] | None
) -> xr.Dataset:
    """Return the part between two times of a run or of signals in a file."""
    return _between(_checked_signals(_dataset_in(file, reading)), times)


def _checked_signals(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset that contains a run or signals."""
    if "t" not in dataset.dims or not {"x", "y"} <= set(dataset.variables):
        title = dataset.attrs.get("title", "another dataset")
        raise InputError(f"file must contain a run, a run-up or signals, got {shown(title)}")
    return dataset


def as_read(reading: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a measured file as arguments of `rotor_ida.read_signals`."""
    found = dict(reading)
    for name in {"columns", "units"} & found.keys():
        found[name] = dict(parsing.named(name, found[name]))
    file = found.pop("slow_roll_file", None)
    if file is not None and "slow_roll" in found:
        raise InputError("slow_roll must be left out with slow_roll_file")
    if "slow_roll" in found:
        found["slow_roll"] = tuple(in_unit("slow_roll", each, "s") for each in found["slow_roll"])
    elif file is not None:
        found["slow_roll"] = file
    elif "runout_orders" in found:
        raise InputError("runout_orders must be given with slow_roll or slow_roll_file")
    return found


def _dataset_in(file: Path, reading: Mapping[str, Any], *, inch: bool = False) -> xr.Dataset:
    """Return the dataset in an archive, or the signals in a measured file, in mils if `inch`."""
    if file.suffix == parsing.SYSTEM_ENDING and file.is_file():
        raise InputError(
            f"file must contain signals or results, got {shown(file)}: a machine file is for the "
            "option --machine of commands such as run-up, and a system file for simulate"
        )
    given = as_read(reading)
    if file.suffix != OUT_ENDING:
        if inch:
            with suppress(InputError):  # lengths without a unit stay as they are
                return rotor_ida.read_signals(file, **{"length": "mil"} | given)
        return rotor_ida.read_signals(file, **given)
    part, orders = given.pop("slow_roll", None), given.pop("runout_orders", 1)
    if given:
        raise InputError(f"{next(iter(given))} must be left out with an archive, got {shown(file)}")
    signals = read(file)
    if part is None:
        return signals
    from rotor_ida.signals.probes import slow_part  # noqa: PLC0415 - heavy, and not for --help

    return rotor_ida.subtract_runout(
        _checked_signals(signals),
        rotor_ida.read_signals(part) if isinstance(part, Path) else slow_part(signals, part),
        harmonics=orders,
    )


def _between(dataset: xr.Dataset, times: tuple[float, float] | None) -> xr.Dataset:
    """Return the part of signals between two times."""
    if times is None:
        return dataset
    unit = str(dataset["t"].attrs.get("units", "1"))
    low, high = check_increasing(
        "times", np.array([in_unit("times", each, unit) for each in times])
    ).tolist()
    part = dataset.sel(t=slice(low, high))
    for dim, begin, end in OF_TIMES:
        if begin in part.variables and part[begin].dims == (dim,):
            is_outside = (part[begin].values > high) | (part[end].values < low)
            part = part.isel({dim: ~is_outside})  # what has no end lasts
    if not part.sizes["t"]:
        ends = dataset["t"].values[[0, -1]].tolist()
        raise InputError(
            f"times must lie within {ends[0]:.3g} to {ends[1]:.6g}, got {low:g} {high:g}"
        )
    return part
