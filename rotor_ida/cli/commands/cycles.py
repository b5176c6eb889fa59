"""The commands for limit cycles: one cycle, its branch, its bifurcations over two parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import MOST_NUMBERS, State, shown
from rotor_ida.cli import options, parsing
from rotor_ida.cli.machines import REST
from rotor_ida.cli.option_types import count_option, path_option, quantity_option
from rotor_ida.cli.output import Output, answer, answer_whole, read, working
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.rotor_options import RotorOptions
from rotor_ida.cli.systems import cycle_case
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.data_sheet import in_si
from rotor_ida.model.parameters import OF_MACHINE, TABLE
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.scales import IS_OF_MACHINE
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM

if TYPE_CHECKING:
    import xarray as xr

# Kinds of archive for `--from`, of one disc and of a rotor system.
SOURCES = ("cycle", "branch", "curve")
OF_SYSTEM = (*(f"system_{kind}" for kind in SOURCES), "system_special_points")


def _limits(text: str, words: str) -> Parameter:
    """Return an option for values of a parameter, whose unit depends on the parameter."""
    units = {each.unit for each in TABLE} | {each.unit for each in PARAMETERS_OF_SYSTEM.values()}
    every = tuple(units - {"1"})
    return Parameter(
        help=text, metavar=words, converter=parsing.converter(parsing.limits, *every), negative=()
    )


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
        "zeta or delta0. Of a rotor system speed (default), clearance, friction, unbalance, "
        "damping or stiffness, as in sweep."
    ),
]
TwoParameters = Annotated[
    tuple[options.OfRotor, options.OfRotor],
    Parameter(
        help="The two parameters to vary, from the choices of continue-cycle; of a rotor system "
        "by default speed and clearance.",
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

    def begun(self) -> tuple[Rotor | DimensionalRotor, dict[str, Any]]:
        """Return the rotor and the start of the continuation."""
        if self.from_ is not None:
            from rotor_ida.cycles.guess import guess_in  # noqa: PLC0415 - heavy, not for --help
            from rotor_ida.results.si_units import dimensionless, machine_of  # noqa: PLC0415

            archived = read(self.from_)
            found = _in_archive(dimensionless(archived), self, SOURCES)
            return machine_of(archived) or guess_in(found).rotor, {"start": found}
        chosen = self.chosen()
        start: Any = self.start or REST
        return chosen, {"start": start if self.period is None
                        else _closed(chosen, start, self.period)}  # fmt: skip

    def begun_of_system(
        self, file: Path, output: Output, *, without_gravity: bool
    ) -> tuple[RotorSystem, dict[str, Any]]:
        """Return the rotor system of a file, and the start of the continuation."""
        if self.period is not None:
            raise InputError(
                "period must be left out with a rotor system: compute its cycle first, with "
                "limit-cycle"
            )
        own, given = cycle_case(file, self, self.start, output, without_gravity=without_gravity)
        if self.from_ is not None:
            if self.start is not None:
                raise InputError("start must be left out with --from")
            given["start"] = _in_archive(read(self.from_), self, OF_SYSTEM)
            given["speed"] = self.given.get("speed")  # else that of the archive
        elif (self.point, self.special) != (None, None):
            raise InputError("point and special must be left out without --from")
        return own, given


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
        own, given = cycle_case(system, rotor, start, output, without_gravity=without_gravity)
        with working("cycle") as progress:
            found = rotor_ida.limit_cycle(own, **given, period=period, progress=progress)
        return _answered(found, output)
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

    That of a rotor of any size over the speed, and over the clearance, from a system file:

        rotor-ida continue-cycle rotor.toml --from bounce.nc --without-gravity \
            --limits 7950rpm 8050rpm

        rotor-ida continue-cycle rotor.toml --from bounce.nc --without-gravity \
            --parameter clearance --limits 145um 155um
    """
    given: dict[str, Any] = {"direction": direction, "points": points}
    if system is not None and parameter == "omega":
        parameter = "speed"
    return _followed(
        rotor_ida.continue_cycle, system, origin, without_gravity, [parameter], limits,
        given | {"parameter": parameter, "limits": limits}, study, output,
    )  # fmt: skip


def bifurcation_curve(
    system: options.System = None,
    /,
    *,
    origin: Origin = Origin(),
    kind: Bifurcation,
    limits: TwoLimits,
    parameters: TwoParameters = ("omega", "delta0"),
    points: PointCount = 2000,
    without_gravity: options.WithoutGravity = False,
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Continue a fold, period doubling or torus bifurcation of cycles over two parameters.

    From the branch of the example of continue-cycle:

        rotor-ida bifurcation-curve --from branch.nc --special 1 \
            --kind period_doubling --limits 1.7 1.9 1.9 2.1 --out curve.nc

    For a rotor of any size give its system file first, and an archive of its cycle or branch.
    """
    if system is not None and parameters == ("omega", "delta0"):
        parameters = ("speed", "clearance")
    given = {"kind": kind, "points": points, "parameters": parameters}
    return _followed(
        rotor_ida.bifurcation_curve, system, origin, without_gravity, parameters, limits,
        given | {"limits": (limits[:2], limits[2:])}, study, output,
    )  # fmt: skip


def _followed(
    verb: Callable[..., xr.Dataset],
    system: Path | None,
    origin: Origin,
    without_gravity: bool,
    names: Sequence[str],
    limits: Sequence[float],
    given: dict[str, Any],
    study: Path | None,
    output: Output,
) -> Report:
    """Follow a branch or a curve of any rotor."""
    rotor: Rotor | DimensionalRotor | RotorSystem
    if system is not None:
        rotor, begun = origin.begun_of_system(system, output, without_gravity=without_gravity)
    elif without_gravity:
        raise InputError("without_gravity must be left out without a rotor system")
    else:
        origin.check()
        output.check()
    with working("points", study) as progress:
        if system is None:
            rotor, begun = origin.begun()
        _check_units(rotor, names, limits)
        found = verb(rotor, **begun, **given, study=study, progress=progress)
        return answer_whole(found, output, study)


def _check_units(
    rotor: Rotor | DimensionalRotor | RotorSystem, names: Sequence[str], limits: Sequence[float]
) -> None:
    """Raise `InputError` unless the units of limits, two a parameter, are those of parameters."""
    if isinstance(rotor, Rotor) or (isinstance(rotor, RotorSystem) and rotor.units != "SI"):
        parsing.refuse_units({"limits": tuple(limits)})
    own = PARAMETERS_OF_SYSTEM if isinstance(rotor, RotorSystem) else OF_MACHINE
    for place, each in enumerate(limits):
        name, word = names[place // 2], getattr(each, "word", "")
        name = IS_OF_MACHINE.get(name, name)
        if word and (known := own.get(name, OF_MACHINE.get(name))):
            in_si(name, word, known.unit)


def _closed(rotor: Rotor | DimensionalRotor, start: State | str, period: float) -> xr.Dataset:
    """Return the cycle near a guess; if there is none, the guess is an input error."""
    try:
        return rotor_ida.limit_cycle(rotor, start=start, period=period)
    except SimulationError as error:
        raise InputError(f"start and period must be near a limit cycle: {error}") from error


def _in_archive(dataset: xr.Dataset, origin: Origin, sources: Sequence[str]) -> xr.Dataset:
    """Return the cycle in an archive, or that at one point of a branch, a curve and so on."""
    from rotor_ida.results.kinds import kind_of  # noqa: PLC0415 - heavy, and not for --help

    file, kind = origin.from_, kind_of(dataset)
    if kind not in sources:
        also = ", or special speeds" if sources is OF_SYSTEM else ""
        of = " of a rotor system" if sources is OF_SYSTEM else ""
        raise InputError(
            f"from must be a cycle, a branch or a curve{also}{of}, got {shown(file)}, of the kind "
            f"{kind}"
        )
    if not kind.endswith("cycle"):
        return _at(dataset, kind, origin.point, origin.special)
    if (origin.point, origin.special) != (None, None):
        raise InputError(f"point and special must be left out with a cycle, got {shown(file)}")
    if dataset["period"].isnull():
        raise InputError(f"from must contain a limit cycle, got {shown(file)} without one")
    return dataset


def _at(dataset: xr.Dataset, kind: str, point: int | None, special: int | None) -> xr.Dataset:
    """Return one point, or one special point, of a branch, a curve or special speeds."""
    kind = kind.removeprefix("system_").replace("_", " ")
    if point is None and special is None:
        raise InputError(f"point or special must be given with a {kind}")
    dim, number = ("point", point) if special is None else ("special", special)
    size = dataset.sizes.get(dim, 0)
    if number is None or number >= size:
        have = f"from 0 to {size - 1}" if size else "left out: there is none"
        raise InputError(f"{dim} must be {have}, got {number}")
    return dataset.isel({dim: number})
