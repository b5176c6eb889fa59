"""The command response."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer
from rotor_ida.cli.parsing import check_points
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

# More rows are for programs, with --json or --out.
MOST_ROWS = 1000

WithFolds = Annotated[
    bool,
    Parameter(
        help="Also list the folds; alone if no --omega is given.", negative=(), show_default=False
    ),
]


def response(
    *,
    zeta: options.Zetas,
    delta0: options.Delta0s,
    omega: options.Omegas | None = None,
    folds: WithFolds = False,
    output: Output = Output(),
) -> Report:
    r"""List every exact synchronous whirl, with its stability.

    At two speeds, with the folds; then over a range of speeds into a file:

        rotor-ida response --omega 1.2 1.7 --zeta 0.07 --delta0 0.5 --folds

        rotor-ida response --omega 0.5:3:251 --zeta 0.07 --delta0 0 2 \
            --out whirls.nc --figure whirls.png
    """
    if omega is None and not folds:
        raise InputError("omega must hold at least one number, got none")
    if omega is None and output.figure is not None:
        raise InputError("figure must be of whirls: give --omega")
    check_points(omega or [0.0], zeta, delta0)
    output.check(panels=len(zeta) * len(delta0))
    return answer(_computed(omega, zeta, delta0, folds), output, most=MOST_ROWS)


def _computed(
    speeds: list[float] | None, dampings: list[float], clearances: list[float], with_folds: bool
) -> xr.Dataset:
    """Return whirls, folds, or whirls with their folds beside them."""
    if speeds is None:
        return rotor_ida.folds(zeta=dampings, delta0=clearances)
    whirls = rotor_ida.synchronous_response(omega=speeds, zeta=dampings, delta0=clearances)
    if not with_folds:
        return whirls
    found = rotor_ida.folds(zeta=dampings, delta0=clearances)
    return whirls.assign({name: found[name] for name in ("fold_omega", "fold_amplitude")})
