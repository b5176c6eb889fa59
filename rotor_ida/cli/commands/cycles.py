"""The commands for limit cycles: one cycle, its branch, its bifurcations over two parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import COMPONENTS, MOST_NUMBERS, State, shown
from rotor_ida.cli import options, parsing
from rotor_ida.cli.machines import REST, check_limits
from rotor_ida.cli.option_types import count_option, path_option, quantity_option
from rotor_ida.cli.output import Output, answer, answer_whole, read, working
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.rotor_options import RotorOptions
from rotor_ida.cli.systems import cycle_case
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.parameters import ALL_PARAMETERS, TABLE
from rotor_ida.model.rotor import DimensionalRotor, Rotor

if TYPE_CHECKING:
    import xarray as xr

# Kinds of archive for `--from`.
SOURCES = ("cycle", "branch", "curve")


def _limits(text: str, words: str) -> Parameter:
    """Return an option for values of a parameter, whose unit depends on the parameter."""
    every = tuple({each.unit for each in TABLE if each.unit != "1"})
    reading = parsing.converter(
        lambda name, given: tuple(parsing.quantity(name, [word], *every) for word in given)
    )
    return Parameter(help=text, metavar=words, converter=reading, negative=())


Period = Annotated[
    float | None,
    quantity_option(
        "Estimate of the period, for a start near a cycle on the rotating axes (SI: s).", "s"
    ),
]
From = Annotated[
    Path | None,
    path_option("Archive of a cycle, branch or curve to start from.", name="--from"),
]
PointNumber = Annotated[
    int | None,
    count_option("Point of the branch or curve in that archive, counted from 0.", 0, MOST_NUMBERS),
]
SpecialNumber = Annotated[
    int | None,
    count_option("Special point of that branch or curve, counted from 0.", 0, MOST_NUMBERS),
]
PointCount = Annotated[
    int, count_option("Largest number of points in each direction.", 2, MOST_NUMBERS)
]
OneParameter = Annotated[
    options.OfRotor,
    Parameter(
        help="Parameter to vary; for a machine speed, damping or clearance replace omega, "
        "zeta or delta0."
    ),
]
TwoParameters = Annotated[
    tuple[options.OfRotor, options.OfRotor],
    Parameter(
        help="The two parameters to vary, from the choices of continue-cycle.",
        metavar="NAME NAME",
        negative=(),
        show_default=" ".join,
    ),
]
Limits = Annotated[
    tuple[float, float],
    _limits(
        "Smallest and largest value of the parameter (of a machine in SI units, or as 3000rpm).",
        "LOW HIGH",
    ),
]
TwoLimits = Annotated[
    tuple[float, float, float, float],
    _limits("Smallest and largest value of each parameter.", "LOW HIGH LOW HIGH"),
]
Way = Annotated[
    Literal["both", "forward", "backward"],
    Parameter(help="Direction: forward is to larger values, or onwards along a branch."),
]
Bifurcation = Annotated[
    Literal["fold", "period_doubling", "torus"], Parameter(help="Bifurcation to follow.")
]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Origin(RotorOptions):
    """The start of a branch or a curve: an initial state, or a cycle in an archive."""

    start: options.StartOrNone = None
    period: Period = None
    from_: From = None
    point: PointNumber = None
    special: SpecialNumber = None

    @property
    def units_unknown(self) -> bool:
        """Whether the units come from an archive."""
        return self.from_ is not None

    def check(self) -> None:
        """Refuse options that do not go together."""
        of_file = [name for name in ("point", "special") if getattr(self, name) is not None]
        of_start = [*self.given, *(name for name in ("machine", "start", "period")
                                   if getattr(self, name) is not None)]  # fmt: skip
        if self.from_ is not None:
            if of_start:
                raise InputError(f"{of_start[0]} must be left out with --from")
            if len(of_file) > 1:
                raise InputError("special must be left out with --point")
            return
        if of_file:
            raise InputError(f"{of_file[0]} must be left out without --from")
        if not (self.given or self.machine):
            raise InputError("a rotor must be given, or a file with --from")

    def guess(self, *, curve_kind: str | None = None) -> tuple[Any, State | str | xr.Dataset]:
        """Return rotor and start of the continuation.

        A point of a bifurcation curve of `curve_kind` starts exactly that bifurcation.
        """
        if self.from_ is not None:
            from rotor_ida.results.si_units import (  # noqa: PLC0415 - heavy, not for --help
                dimensionless,
                machine_of,
            )

            archived = read(self.from_)
            rotor, found = _in_archive(dimensionless(archived), self, curve_kind)
            return machine_of(archived) or rotor, found
        chosen = self.chosen()
        start = self.start or REST
        return chosen, start if self.period is None else _closed(chosen, start, self.period)


def limit_cycle(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    start: options.StartOrNone = None,
    period: Period = None,
    without_gravity: options.WithoutGravity = False,
    output: Output = Output(),
) -> Report:
    r"""Compute the limit cycle reached from an initial state, with multipliers and spectrum.

    From rest, saved to a file:

        rotor-ida limit-cycle --omega 2 --zeta 0.07 --delta0 2 --out cycle.nc

    A cycle, stable or not, near a state on the rotating axes and of about a given period:

        rotor-ida limit-cycle --omega 2 --zeta 0.07 --delta0 2 \
            --start 2.6 0.75 0.66 -1.65 --period 4.5

    The cycle to which a rotor of any size leads, from a system file:

        rotor-ida limit-cycle rotor.toml --speed 8000rpm --without-gravity \
            --out bounce.nc
    """
    if system is not None:
        return cycle_file(system, rotor, start, period, output, without_gravity=without_gravity)
    if without_gravity:
        raise InputError("without_gravity must be left out without a rotor system")
    output.check()
    chosen = rotor.chosen()
    with working("cycle") as progress:
        if period is None:
            found = rotor_ida.limit_cycle(chosen, start=start or REST, progress=progress)
        else:
            found = _closed(chosen, start or REST, period)
    return _answered(found, output)


def _answered(found: xr.Dataset, output: Output) -> Report:
    """Return the answer with a cycle; without one there is no figure."""
    if found["period"].notnull() or output.figure is None:
        return answer(found, output, most=FIRST_ROWS)
    report = answer(found, replace(output, figure=None), most=FIRST_ROWS)
    return replace(report, parts=[*report.parts, "drew no figure: there is no limit cycle"])


def continue_cycle(
    system: options.System = None,
    /,
    *,
    origin: Origin = Origin(),
    limits: Limits,
    parameter: OneParameter = "omega",
    direction: Way = "both",
    points: PointCount = 2000,
    without_gravity: options.WithoutGravity = False,
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Continue a limit cycle over speed, damping or clearance, with its bifurcations.

    From the cycle of the example of limit-cycle; then along the period-doubled branch:

        rotor-ida continue-cycle --from cycle.nc --limits 1.5 2.5 --out branch.nc

        rotor-ida continue-cycle --from branch.nc --special 1 --limits 1.7 2

    That of a rotor of any size over the speed, from a system file:

        rotor-ida continue-cycle rotor.toml --from bounce.nc --without-gravity \
            --limits 7950rpm 8050rpm
    """
    if system is not None:
        given: dict[str, Any] = {
            "limits": limits, "direction": direction, "points": points, "study": study
        }  # fmt: skip
        if parameter != "omega":
            raise InputError(f"parameter must be left out with a rotor system, got {parameter}")
        return branch_file(system, origin, output, given, without_gravity=without_gravity)
    if without_gravity:
        raise InputError("without_gravity must be left out without a rotor system")
    origin.check()
    output.check()
    with working("points", study) as progress:
        rotor, start = origin.guess()
        check_limits(rotor, [parameter], limits)
        branch = rotor_ida.continue_cycle(
            rotor,
            start=start,
            parameter=parameter,
            limits=limits,
            direction=direction,
            points=points,
            study=study,
            progress=progress,
        )
        return answer_whole(branch, output, study)


def bifurcation_curve(
    *,
    origin: Origin = Origin(),
    kind: Bifurcation,
    limits: TwoLimits,
    parameters: TwoParameters = ("omega", "delta0"),
    points: PointCount = 2000,
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Continue a fold, period doubling or torus bifurcation of cycles over two parameters.

    From the branch of the example of continue-cycle:

        rotor-ida bifurcation-curve --from branch.nc --special 1 \
            --kind period_doubling --limits 1.7 1.9 1.9 2.1 --out curve.nc
    """
    origin.check()
    output.check()
    with working("points", study) as progress:
        rotor, start = origin.guess(curve_kind=kind)
        check_limits(rotor, parameters, limits)
        found = rotor_ida.bifurcation_curve(
            rotor,
            start=start,
            kind=kind,
            parameters=parameters,
            limits=(limits[:2], limits[2:]),
            points=points,
            study=study,
            progress=progress,
        )
        return answer_whole(found, output, study)


# ---- Of a rotor system ----


def cycle_file(
    file: Path,
    rotor: RotorOptions,
    start: State | str | None,
    period: float | None,
    output: Output,
    *,
    without_gravity: bool,
) -> Report:
    """Compute the limit cycle of the system of a file."""
    own, given = cycle_case(file, rotor, start, output, without_gravity=without_gravity)
    with working("cycle") as progress:
        found = rotor_ida.limit_cycle(own, **given, period=period, progress=progress)
    return _answered(found, output)


def branch_file(
    file: Path, origin: Origin, output: Output, how: dict[str, Any], *, without_gravity: bool
) -> Report:
    """Continue a limit cycle of the system of a file over the speed."""
    if origin.period is not None:
        raise InputError(
            "period must be left out with a rotor system: compute its cycle first, with limit-cycle"
        )
    own, given = cycle_case(file, origin, origin.start, output, without_gravity=without_gravity)
    if origin.from_ is not None:
        if origin.start is not None:
            raise InputError("start must be left out with --from")
        given["start"] = _point_of_system(read(origin.from_), origin)
        given["speed"] = origin.given.get("speed")  # else that of the archive
    elif (origin.point, origin.special) != (None, None):
        raise InputError("point and special must be left out without --from")
    with working("points", how["study"]) as progress:
        branch = rotor_ida.continue_cycle(own, **given, **how, progress=progress)
        return answer_whole(branch, output, how["study"])


def _point_of_system(dataset: xr.Dataset, origin: Origin) -> xr.Dataset:
    """Return the cycle of a system in an archive, or one point of a branch or special speeds."""
    from rotor_ida.results.kinds import kind_of  # noqa: PLC0415 - heavy, and not for --help

    kind = kind_of(dataset)
    if kind == "system_cycle":
        if (origin.point, origin.special) != (None, None):
            raise InputError(
                f"point and special must be left out with a cycle, got {shown(origin.from_)}"
            )
        return dataset
    if kind not in ("system_branch", "system_special_points"):
        raise InputError(
            "from must be a cycle, a branch or special speeds of a rotor system, got "
            f"{shown(origin.from_)}, of the kind {kind}"
        )
    if kind == "system_special_points" and origin.special is None:
        raise InputError("special must be given with special speeds")
    return _at(dataset, kind, origin.point, origin.special)


def _closed(rotor: Rotor | DimensionalRotor, start: State | str, period: float) -> xr.Dataset:
    """Return the cycle near a guess; if there is none, the guess is an input error."""
    try:
        return rotor_ida.limit_cycle(rotor, start=start, period=period)
    except SimulationError as error:
        raise InputError(f"start and period must be near a limit cycle: {error}") from error


def _in_archive(
    dataset: xr.Dataset, origin: Origin, curve_kind: str | None
) -> tuple[Rotor, xr.Dataset]:
    """Return the cycle in an archive, or that at one point of a branch or curve, and its rotor."""
    from rotor_ida.results.kinds import kind_of  # noqa: PLC0415 - heavy, and not for --help

    file, point, special = origin.from_, origin.point, origin.special
    kind = kind_of(dataset)
    if kind not in SOURCES:
        raise InputError(
            f"from must be a cycle, a branch or a curve, got {shown(file)}, of the kind {kind}"
        )
    if kind != "cycle":
        dataset = _at(dataset, kind, point, special)
    elif point is not None or special is not None:
        raise InputError(f"point and special must be left out with a cycle, got {shown(file)}")
    elif dataset["period"].isnull():
        raise InputError(f"from must contain a limit cycle, got {shown(file)} without one")
    if kind == "curve":
        dataset = _of_curve(dataset, "special_" if point is None else "", curve_kind)
    place = dataset
    if kind == "branch" and special is not None:
        place = dataset.assign_coords({dataset.attrs["parameter"]: dataset["special_value"]})
    given = [name for name in ALL_PARAMETERS if name in place.coords]
    return Rotor(**{name: place[name].item() for name in given}), dataset


def _at(dataset: xr.Dataset, kind: str, point: int | None, special: int | None) -> xr.Dataset:
    """Return one point, or one special point, of a branch or curve."""
    if point is None and special is None:
        raise InputError(f"point or special must be given with a {kind}")
    dim, number = ("point", point) if special is None else ("special", special)
    size = dataset.sizes[dim]
    if number is None or number >= size:
        have = f"from 0 to {size - 1}" if size else "left out: there is none"
        raise InputError(f"{dim} must be {have}, got {number}")
    return dataset.isel({dim: number})


def _of_curve(at: xr.Dataset, prefix: str, curve_kind: str | None) -> xr.Dataset:
    """Return a point of a bifurcation curve as a point of a branch over its first parameter.

    It is a special point of that branch if exactly that bifurcation is to be continued.
    """
    import xarray as xr  # noqa: PLC0415 - heavy, and not for --help

    from rotor_ida.schema import SPECIAL  # noqa: PLC0415

    kind, (first, second) = at.attrs["kind"], at.attrs["parameters"].split()
    held = [name for name in ALL_PARAMETERS if name in at.coords and name not in {first, second}]
    names = ("special_value", "special_second_value") if prefix else (first, second)
    values = {name: at[name].item() for name in held}
    values |= {first: at[names[0]].item(), second: at[names[1]].item()}
    numbers = {name: at[f"{prefix}{name}"].item() for name in (*COMPONENTS, "period")}
    if kind != curve_kind:
        return xr.Dataset(numbers, values, {"parameters": at.attrs["parameters"]})
    told = {f"special_{name}": number for name, number in numbers.items()}
    told |= {"special_kind": SPECIAL[kind], "special_value": values[first]}
    return xr.Dataset(told, values, {"parameter": first})
