"""The command fit: from measured signals to the parameters of a machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import State
from rotor_ida.cli import options, parsing
from rotor_ida.cli.commands.plot import OF_FILE, signals_in
from rotor_ida.cli.option_types import number_option, numbers_option, quantity_option
from rotor_ida.cli.output import Output, answer, troubled, working
from rotor_ida.cli.parsing import in_unit
from rotor_ida.cli.report import FAILED, Report
from rotor_ida.cli.rotor_options import ANY_SPEED, RotorOptions
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    import xarray as xr
Unknowns = Annotated[
    list[str],
    Parameter(
        help="Parameters to fit: names of rotor options, or unbalance_angle.",
        metavar="NAME",
        consume_multiple=True,
        negative=(),
    ),
]
StartOfRecord = Annotated[
    State | None,
    Parameter(
        help="State at the beginning of the record. Default: it is fitted too.",
        metavar="X Y VX VY",
        converter=parsing.converter(parsing.state),
        negative=(),
    ),
]
EntryTimes = Annotated[
    list[float] | None,
    numbers_option(
        "Measured times at which contacts begin, in the unit of the signals or as 20ms.", "s"
    ),
]
ExitTimes = Annotated[list[float] | None, numbers_option("The same, at which contacts end.", "s")]
TimeError = Annotated[float | None, quantity_option("Standard error of these times.", "s")]
NoiseLevel = Annotated[
    float | None,
    quantity_option(
        "Standard deviation of the noise, in the unit of the probes or as 2um. Default: that of "
        "the residuals.",
        "m",
    ),
]
SearchLimit = Annotated[
    float | None, number_option("Longest time to search, in s. The best trial is reported then.")
]


def fit(
    *files: options.SignalFile,
    unknown: Unknowns,
    rotor: RotorOptions = RotorOptions(),
    orders: options.Orders = None,
    start: StartOfRecord = None,
    entries: EntryTimes = None,
    exits: ExitTimes = None,
    time_error: TimeError = None,
    noise: NoiseLevel = None,
    limit: SearchLimit = None,
    times: options.Times = None,
    reading: options.ReadingOptions = options.ReadingOptions(),
    output: Output = Output(),
) -> Report:
    r"""Fit rotor parameters to measured signals, with their errors.

    To the archive of the example of run-up; the given values are the initial guess:

        rotor-ida fit run_up.nc --zeta 0.1 --delta0 0.7 --shaft-stiffness 1.1 \
            --unknown zeta delta0 shaft_stiffness --figure fit

    Size and angle of the unbalance of a machine, from a table of probes and a keyphasor:

        rotor-ida fit probes.csv --columns x=A y=B --units x=um y=um \
            --mass 4kg --contact-stiffness 3.2e7 --damping 100 --clearance 25um \
            --shaft-stiffness 500N/mm --eccentricity 1um \
            --unknown eccentricity unbalance_angle
    """
    if not files:
        raise InputError("FILE must be given")
    output.check()
    given = rotor.given  # the speed is measured; this one is not used
    known = {
        speed: ANY_SPEED
        for speed, other in (("omega", "zeta"), ("speed", "mass"))
        if speed not in given and other in given
    }
    chosen = rotor.chosen(known)
    signals: list[xr.Dataset] = [signals_in(each, reading, times) for each in files]
    length, time = (str(signals[0][name].attrs.get("units", "1")) for name in "xt")
    with working("trials") as progress:
        found = rotor_ida.fit(
            signals,
            chosen,
            unknown,
            orders=(1.0,) if orders is None else orders,
            start=start,
            entries=_all_in("entries", entries, time),
            exits=_all_in("exits", exits, time),
            time_error=None if time_error is None else in_unit("time_error", time_error, time),
            noise=None if noise is None else in_unit("noise", noise, length),
            limit=limit,
            progress=progress,
        )
    for name in OF_FILE:
        if told := dict.fromkeys(str(each.attrs[name]) for each in signals if name in each.attrs):
            found.attrs[name] = "; ".join(told)
    report = answer(found, output)
    if found.attrs["search"] == "converged":
        return report
    return troubled(report, f"search {found.attrs['search']}", FAILED)


def _all_in(name: str, values: list[float] | None, unit: str) -> list[float] | None:
    """Return values in the unit of the signals."""
    return None if values is None else [in_unit(name, each, unit) for each in values]
