"""The command response."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import rotor_ida
from rotor_ida.cli import options, parsing
from rotor_ida.cli.report import Report
from rotor_ida.cli.targets import check_targets
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

# More rows are for programs, with --json or --out.
MOST_ROWS = 1000

WithFolds = Annotated[
    bool, Parameter(help="Also list the folds; alone if no --omega is given.", negative=())
]


def response(
    *,
    zeta: options.Zetas,
    delta0: options.Delta0s,
    omega: options.Omegas | None = None,
    folds: WithFolds = False,
    out: options.Out = None,
    figure: options.Figure = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""List every exact synchronous whirl, with its stability.

    At two speeds, with the folds; then over a range of speeds into a file:

        rotor-ida response --omega 1.2 1.7 --zeta 0.07 --delta0 0.5 --folds

        rotor-ida response --omega 0.5:3:251 --zeta 0.07 --delta0 0 2 \
            --out whirls.nc --figure whirls.png
    """
    dampings, clearances = parsing.numbers("zeta", zeta), parsing.numbers("delta0", delta0)
    speeds = [] if omega is None and folds else parsing.numbers("omega", omega or [])
    parsing.check_points(speeds or [0.0], dampings, clearances)
    if figure is not None and not speeds:
        raise InputError("figure must be of whirls: give --omega")
    panels = len(dampings) * len(clearances)
    targets = check_targets(out=out, figure=figure, panels=panels, force=force)
    from rotor_ida.cli.answer import answer  # noqa: PLC0415 - heavy, and not for --help

    dataset = _computed(speeds, dampings, clearances, folds)
    return answer(dataset, targets, as_json=as_json, most=MOST_ROWS)


def _computed(
    speeds: list[float], dampings: list[float], clearances: list[float], with_folds: bool
) -> xr.Dataset:
    """Return whirls, folds, or whirls with their folds beside them."""
    if not speeds:
        return rotor_ida.folds(zeta=dampings, delta0=clearances)
    whirls = rotor_ida.synchronous_response(omega=speeds, zeta=dampings, delta0=clearances)
    if not with_folds:
        return whirls
    found = rotor_ida.folds(zeta=dampings, delta0=clearances)
    return whirls.assign({name: found[name] for name in ("fold_omega", "fold_amplitude")})
