"""The commands for exact whirls of one disc, and the points at which they change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

import rotor_ida
from rotor_ida.cli import machines, options
from rotor_ida.cli.option_types import ROTOR, flag_option
from rotor_ida.cli.output import Output, answer
from rotor_ida.cli.parsing import check_points
from rotor_ida.cli.report import Report
from rotor_ida.cli.rotor_options import (
    ANY_SPEED,
    SEVERAL,
    RotorOptions,
    RotorsOptions,
    with_parameters,
)
from rotor_ida.cli.systems import whirls_file
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import OPTIONAL

if TYPE_CHECKING:
    import xarray as xr

    from rotor_ida.model.rotor import DimensionalRotor

# More rows are for programs, with --json or --out.
MOST_ROWS = 1000
# The speed of a rotor, without dimensions and in SI units.
SPEEDS = ("omega", "speed")
WithFolds = Annotated[bool, flag_option("List the folds too.")]


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters(
    {name: Annotated[SEVERAL[name], Parameter(show=False)] for name in SPEEDS},
    dict.fromkeys(SPEEDS),
)
class AllSpeedsOptions(RotorsOptions):
    """Rotors for lists of folds or Hopf points, which are found at all speeds."""

    def without_speed(self) -> tuple[DimensionalRotor | None, dict[str, Any]]:
        """Return the machine, if it is one, and the given parameters that affect these points."""
        for name in SPEEDS:
            if name in self.values:
                raise InputError(f"{name} must be left out: all speeds are searched")
        speed = "speed" if self.in_si else "omega"
        if self.machine is None:
            machines.check_complete(self.values, OPTIONAL, known=(speed,))
        machine, given = self.asked({speed: [ANY_SPEED]} if self.machine is None else {})
        given.pop("omega", None)
        return machine, given


def synchronous_response(
    system: options.System = None,
    /,
    *,
    rotors: RotorsOptions = RotorsOptions(),
    folds: WithFolds = False,
    without_gravity: options.WithoutGravity = False,
    output: Output = Output(),
) -> Report:
    r"""List all exact synchronous whirls, with their stability.

    At two speeds, with the folds; then over a range of speeds, saved and drawn:

        rotor-ida synchronous-response --omega 1.2 1.7 --zeta 0.07 --delta0 0.5 \
            --folds

        rotor-ida synchronous-response --omega 0.5:3:251 --zeta 0.07 \
            --delta0 0 2 --out whirls.nc --figure whirls.png

    A rotor of any size, from a system file:

        rotor-ida synchronous-response rotor.toml --speed 3000rpm:9000rpm:61 \
            --without-gravity --figure rubs
    """
    if system is not None:
        if folds:
            raise InputError("folds must be left out with a rotor system: see special-speeds")
        return whirls_file(system, rotors, output, without_gravity=without_gravity)
    if without_gravity:
        raise InputError("without_gravity must be left out without a rotor system")
    check_points(*rotors.axes())
    output.check(panels=rotors.panels(over="omega"))
    machine, given = rotors.asked()
    whirls = rotor_ida.synchronous_response(machine, **given)
    if folds:
        of_folds = {name: each for name, each in given.items()
                    if name not in {*SPEEDS, "contact_damping"}}  # fmt: skip
        undamped = None if machine is None else replace(machine, contact_damping=0.0)
        found = rotor_ida.folds(undamped, **of_folds)
        whirls = whirls.assign({name: found[name] for name in ("fold_omega", "fold_amplitude")})
    return answer(whirls, output, most=MOST_ROWS)


def folds(*, rotors: AllSpeedsOptions = AllSpeedsOptions(), output: Output = Output()) -> Report:
    r"""Compute all folds: speeds at which a synchronous whirl in contact vanishes.

    The rotor jumps there. At two clearances; then drawn on the response curve:

        rotor-ida folds --zeta 0.07 --delta0 0 0.5

        rotor-ida folds --zeta 0.07 --delta0 0.5 --out folds.nc --figure folds
    """
    return _at_all_speeds(rotor_ida.folds, rotors, output)


def hopf_points(
    *, rotors: AllSpeedsOptions = AllSpeedsOptions(), output: Output = Output()
) -> Report:
    r"""Compute all Hopf points: speeds at which a whirl in contact begins to oscillate.

    They occur only with friction or contact damping:

        rotor-ida hopf-points --zeta 0.07 --delta0 0.5 --friction 0 0.1 \
            --figure hopf_points
    """
    return _at_all_speeds(rotor_ida.hopf_points, rotors, output)


def _at_all_speeds(
    compute: Callable[..., xr.Dataset], rotors: AllSpeedsOptions, output: Output
) -> Report:
    """Return the answer with the special points of whirls, which are at any speeds."""
    check_points(*rotors.axes())
    output.check(panels=rotors.panels())
    machine, given = rotors.without_speed()
    return answer(compute(machine, **given), output, most=MOST_ROWS)


def backward_whirl(*, rotor: RotorOptions = RotorOptions(), output: Output = Output()) -> Report:
    r"""Compute the backward whirls that friction sustains: dry whirl and dry whip.

    Without unbalance; both exist above the speed `birth omega`:

        rotor-ida backward-whirl --omega 0.63 --zeta 0.1 --delta0 1 \
            --friction 0.2 --disc-radius 10
    """
    output.check()
    return answer(rotor_ida.backward_whirl(rotor.chosen()), output)
