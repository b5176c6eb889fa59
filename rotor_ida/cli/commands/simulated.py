"""The command simulate."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import rotor_ida
from rotor_ida.cli import options, parsing
from rotor_ida.cli.report import Report
from rotor_ida.cli.targets import check_targets
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    from rotor_ida.simulation.options import Backend, Flight, Method

FIRST_ROWS = 10


def simulate(
    *,
    omega: options.Omega,
    zeta: options.Zeta,
    delta0: options.Delta0,
    start: options.Start,
    duration: options.Duration,
    samples: options.Samples = "1001",
    rtol: options.Rtol = "1e-10",
    atol: options.Atol = "1e-12",
    method: options.Method = "adams",
    flight: options.Flight = "exact",
    backend: options.Backend = "auto",
    out: options.Out = None,
    figure: options.Figure = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Simulate one rotor from one start, with every contact entry and exit.

    From rest, with the result kept in a file:

        rotor-ida simulate --omega 1.2 --zeta 0.07 --delta0 0.5 \
            --start 0 0 0 0 --duration 20 --out run.nc
    """
    targets = check_targets(out=out, figure=figure, force=force)
    if len(start) > 1:
        raise InputError(f"start must be given once, got {len(start)} starts")
    from rotor_ida.cli.answer import answer  # noqa: PLC0415 - heavy, and not for --help

    run = rotor_ida.simulate(
        rotor_ida.Rotor(
            omega=parsing.number("omega", omega),
            zeta=parsing.number("zeta", zeta),
            delta0=parsing.number("delta0", delta0),
        ),
        start=parsing.state("start", " ".join(start).split()),
        duration=parsing.number("duration", duration),
        samples=parsing.samples(samples),
        rtol=parsing.number("rtol", rtol),
        atol=parsing.number("atol", atol),
        method=cast("Method", method),
        flight=cast("Flight", flight),
        backend=cast("Backend", backend),
    )
    return answer(run, targets, as_json=as_json, most=FIRST_ROWS)
