"""The command plot: the plots practitioners read, of archives and of measured files."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rotor_ida
from rotor_ida.checks import shown
from rotor_ida.cli import options
from rotor_ida.cli.output import OUT_ENDING, Output, read
from rotor_ida.cli.report import Report, pairs
from rotor_ida.errors import InputError, RotorError

if TYPE_CHECKING:
    import xarray as xr

# Attributes of measured signals that tell how the file was understood.
OF_FILE = ("columns", "notes")
FUNCTIONS = {
    "bode": "plot_bode",
    "polar": "plot_polar",
    "orders": "plot_orders",
    "orbit": "plot_orbit",
    "full-spectrum": "plot_full_spectrum",
    "cascade": "plot_cascade",
    "spectrogram": "plot_spectrogram",
    "centreline": "plot_centre_line",
    "trace": "plot_trace",
}


def plot(
    file: options.SignalFile,
    /,
    *,
    kind: options.PlotKind,
    figure: options.NeededFigure,
    exact: options.Exact = False,
    order: options.OneOrder = None,
    orders: options.Orders = None,
    sense: options.Sense = None,
    over: options.Over = None,
    span: options.Span = None,
    segment: options.Segment = None,
    clearance: options.ShownClearance = None,
    times: options.Times = None,
    reading: options.ReadingOptions = options.ReadingOptions(),
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Draw an archive or a measured file as practitioners do: Bode, orbit, cascade and others.

    Of the run-up that the example of run-up wrote, with the exact response beneath:

        rotor-ida plot run_up.nc --kind bode --figure bode --exact

        rotor-ida plot run_up.nc --kind cascade --figure cascade.png

    From a table of two probes at 45 and 135 degrees, whose columns are guessed from their names
    (time_s, probe_A_um, Speed [rpm], ...):

        rotor-ida plot probes.csv --kind orbit --figure orbit --probe-angles 45 135 --times 0.5 1

    From one whose columns have other names:

        rotor-ida plot probes.csv --kind orbit --figure named --columns x=A y=B --units x=um y=um
    """
    Output(figure=figure, force=force).check()
    given = {
        "order": order, "orders": orders, "sense": sense, "over": over, "span": span,
        "segment": segment, "clearance": clearance,
    }  # fmt: skip
    chosen = _options_of(kind, given)
    dataset = signals_in(file, reading, times)
    if exact:
        from rotor_ida.cli.exact import exact_beneath  # noqa: PLC0415 - heavy, and not for --help

        chosen["beneath"] = exact_beneath(dataset, kind)
    from rotor_ida import plot as plots  # noqa: PLC0415 - only who draws needs it

    drawn = getattr(plots, FUNCTIONS[kind])(dataset, **chosen)
    ax = drawn[0] if isinstance(drawn, list) else drawn
    written, trouble = [], ""
    try:
        files = plots.save_figure(ax.figure, figure.with_suffix(""), overwrite=force)
        written = [str(path) for path in files]
    except (RotorError, OSError) as error:
        trouble = str(error)
    record: dict[str, object] = {"file": str(file), "kind": kind, "samples": dataset.sizes["t"]}
    record |= {name: str(dataset.attrs[name]) for name in OF_FILE if name in dataset.attrs}
    return Report(
        record={**record, "written": written},
        parts=[pairs("Plot", record), *(f"wrote {path}" for path in written)],
        as_json=as_json,
        trouble=trouble,
    )


def _options_of(kind: str, given: Mapping[str, object]) -> dict[str, Any]:
    """Return the options that were given, if the kind of plot has them."""
    from rotor_ida import plot as plots  # noqa: PLC0415 - only who draws needs it

    known = inspect.signature(getattr(plots, FUNCTIONS[kind])).parameters
    chosen = {name: value for name, value in given.items() if value is not None}
    for name in chosen:
        if name not in known:
            raise InputError(f"{name} must be left out with --kind {kind}")
    return chosen


def signals_in(
    file: Path, reading: options.ReadingOptions, times: tuple[float, float] | None
) -> xr.Dataset:
    """Return the part between two times of a run or of signals in a file."""
    return _between(_signals(file, reading), times)


def _signals(file: Path, reading: options.ReadingOptions) -> xr.Dataset:
    """Return the dataset in an archive, or the signals in a measured file."""
    given = reading.given()
    if file.suffix != OUT_ENDING:
        return rotor_ida.read_signals(file, **given)
    if given:
        raise InputError(f"{next(iter(given))} is of measured files, got the archive {shown(file)}")
    dataset = read(file)
    if "t" not in dataset.dims or not {"x", "y"} <= set(dataset.variables):
        title = dataset.attrs.get("title", "another dataset")
        raise InputError(f"file must hold a run, a run-up or signals, got {shown(title)}")
    return dataset


def _between(dataset: xr.Dataset, times: tuple[float, float] | None) -> xr.Dataset:
    """Return the part of signals between two times."""
    if times is None:
        return dataset
    low, high = times
    part = dataset.sel(t=slice(low, high))
    if "keyphasor" in part.variables:
        pulses = part["keyphasor"].values
        part = part.isel(pulse=(pulses >= low) & (pulses <= high))
    if not part.sizes["t"]:
        ends = dataset["t"].values[[0, -1]].tolist()
        raise InputError(f"times must lie within {ends[0]:g} to {ends[1]:g}, got {low:g} {high:g}")
    return part
