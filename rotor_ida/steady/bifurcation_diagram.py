"""Bifurcation diagrams: settled motions at each speed, by their extrema or once a revolution.

Any other parameter may vary instead of the speed. Of a rotor system they are in
`rotor_ida.steady.system_diagram`. Speeds may also be passed quasi-statically, where
the motion settles at each, or on a run-up or run-down at a rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal, NamedTuple, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import (
    COMPONENTS,
    Names,
    State,
    check_between,
    check_choice,
    check_count,
    check_duration,
    check_increasing,
    check_points,
    check_positive,
    check_progress,
    check_real,
    check_seed,
    is_scalar,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, Stop, choose, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.rows import counted
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import RESPONSE, STATUS, labelled, labelled_dataset
from rotor_ida.simulation.course import MOST_RADIANS
from rotor_ida.simulation.extrema import check_knots, radius_extrema
from rotor_ida.simulation.options import Method, Options, options_of_study
from rotor_ida.simulation.sections import (
    ATOL,
    NAMES,
    check_taylor,
    crossings_of_disc,
)
from rotor_ida.simulation.starts import GivenStart, Starts, box_of, drawn_from, states_of
from rotor_ida.steady.follow import FAILED, SettledResponse
from rotor_ida.steady.grid import (
    EXPECTED,
    NO_COLUMNS,
    Columns,
    Rows,
    Task,
    check_size,
    form_of,
    labelled_points,
    reason_of,
    run_study,
    start_coordinates,
    start_words,
)
from rotor_ida.steady.ramp_extrema import ramp_extrema
from rotor_ida.steady.ramps import Direction, Ramps, in_order, settle_along
from rotor_ida.steady.sweep import (
    DiscJob,
    DiscSettling,
    check_varied_can_be_followed,
    with_direction_named,
)
from rotor_ida.steady.system_diagram import diagram_of_system, window_of_section
from rotor_ida.steady.system_sweep import turning_speeds

Shown = Literal["extrema", "revolution"]
SHOWN = ("extrema", "revolution")
SLOWEST, FASTEST = 1e-12, 1e6
# The time in which extrema are found by default.
USUAL_TIME = 100.0
# The columns with a number for each point, and those with one for each of its extrema.
POINT = np.dtype(
    [
        ("response", np.int8), ("radius_min", np.float64), ("radius_max", np.float64),
        ("status", np.int8), ("event_count", np.int64),
    ]
)  # fmt: skip
EXTREMUM = np.dtype([("extremum_radius", np.float64), ("extremum_kind", np.int8)])
EXTREMUM_AT_A_RATE = np.dtype([*EXTREMUM.descr, ("extremum_speed", np.float64)])


OF_DISC = ("x", "y", "vx", "vy", "extrema_time", "rate", "seed", "atol")


@shows_progress
@takes_rotors(disc=OF_DISC, system=("modes",), needed=(), varies=True)
def bifurcation_diagram(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    at: Shown = "extrema",
    revolutions: int | None = None,
    phase: float = 0.0,
    x: npt.ArrayLike | None = None,
    y: npt.ArrayLike | None = None,
    vx: npt.ArrayLike | None = None,
    vy: npt.ArrayLike | None = None,
    starts: int | Starts | None = None,
    seed: int = 0,
    extrema_time: float | None = None,
    direction: Direction | None = None,
    along: str | None = None,
    rate: float | None = None,
    modes: int | None = None,
    rtol: float = 1e-10,
    atol: float = ATOL,
    method: Method | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Compute a bifurcation diagram: settled motions at each speed, by extrema or by revolutions.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem, optional
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given.
    speed : float or array_like, shape (n,), optional
        Spin speeds of a `RotorSystem`, not 0. That of a `DimensionalRotor` is a parameter of it.
    at : {"extrema", "revolution"}
        What is shown of a settled motion: the extrema of its radius; or its states once a
        revolution, a stroboscopic section as of `rotor_ida.poincare_section`.
    revolutions : int, optional
        Number of revolutions, after the rotor has settled, of a section; default: 64. Of a
        `RotorSystem` extrema too are found over this number of revolutions.
    phase : float
        Angle of the unbalance from x in the section, below 2 pi [rad].
    x, y, vx, vy : float or array_like, shape (2,), optional
        Components of random starts of one disc [1]: numbers, or ranges ``(low, high)`` from which
        they are drawn independently and uniformly, as for `rotor_ida.basin_fractions`. Default:
        from -5 to 5.
    starts : int, array_like of shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Number of random starts, by default 8, or the starts ``(x, y, vx, vy)`` themselves [1], the
        same at each speed; words for those at each speed; or results that end in one. Of a
        `RotorSystem` as in `sweep`: by default one, at rest at 0.
    seed : int
        Seed of the random starts.
    extrema_time : float, optional
        Length of the window, after one disc has settled, in which extrema are found [1]; at
        most 10 million times the step between knots. Default: 100. Ignored with a rate.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the settled state of the one before. By default each speed
        begins from the starts.
    along : str, optional
        Name of the parameter that rises or falls with a direction, as for `rotor_ida.sweep`; with
        a rate it is the speed.
    rate : float, optional
        Change of speed per unit time [1]. The motion settles only at the first speed; then the
        speed runs through the others at this rate. Requires a direction, and one disc.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    rtol, atol : float
        Relative and absolute tolerance [1]. A `RotorSystem` has the relative one alone, from 1e-14
        to 1e-4.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Solver of the contacts until the rotor has settled, as for `rotor_ida.sweep`. Extrema
        are found by Taylor series, and so is all of a `RotorSystem`.
    workers, executor
        As for `rotor_ida.sweep`: by default all cores, for the motions and for their extrema.
    study : path-like, optional
        Folder in which points are stored as they are done, as for `rotor_ida.sweep`.
    progress : callable or bool, optional
        Called with the number of points done and their total; True shows a bar on standard error.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], as for `rotor_ida.sweep`.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as in `sweep`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start)``, with any other axes before ``start``:
        ``response`` (its kind, as a flag), ``radius_min``, ``radius_max``, ``status`` and
        ``message``, as from `rotor_ida.sweep`, and ``extremum_count``. ``extremum_radius`` [1] and
        ``extremum_kind`` (minimum, maximum, or constant) list the extrema of all points in one
        table, ``extremum_count`` rows each. With a direction the last dimension
        is ``direction``. With a rate ``extremum_speed`` [1] is the speed at each extremum, and a
        point has the extrema up to halfway between its speed and its neighbours; ``response`` then
        reports only whether the rotor touches there, and whether its radius oscillates.

        Once a revolution there are instead ``rotating_x rotating_y rotating_vx rotating_vy`` on
        ``crossing`` too, as of `rotor_ida.poincare_section`; NaN at a point that failed.

        Of a `RotorSystem` on ``(speed, start)``, with the axes of its parameters before ``start``:
        ``response``, ``period``, ``status`` and ``message``, and on ``contact`` too ``radius_min``,
        ``radius_max``, ``largest_force`` and ``touched``, as from its `sweep`. On ``node`` too the
        states once a revolution, or ``extremum_count``: extrema are those of the distance of each
        node from the axis, in the table node by node.

    Raises
    ------
    InputError
        If an argument cannot be used; if a damping is zero, as no motion settles then; or
        if there is a rate without a direction, or with speeds that do not increase. A point that
        fails does not raise: its ``status`` and ``message`` give the reason, and it has no extrema.

    Notes
    -----
    An extremum is a root of ``r r' = x vx + y vy``, found to about 1e-10 of the radius,
    or to 1e-8 where the rotor passes through the centre without clearance. On a
    synchronous whirl ``r r'`` vanishes throughout; its radius is given once. Periodic motions
    have few values, chaotic and quasi-periodic ones fill ranges. On a run-up the radius of a whirl
    drifts; oscillations below 1e-6 of it are ignored. As the rate falls the diagram tends to that
    of the quasi-static run-up, except that jumps are late: see
    `rotor_ida.closed_forms.late_jumps`.

    Once a revolution a motion of period n revolutions is n points, that of a synchronous whirl one.
    Extrema of a `RotorSystem` lie between 64 samples in a revolution, and between events: of two
    that lie closer together both may be missed. Their times are located to 1e-8 of a revolution,
    where a distance hardly changes. A distance that varies by less than 1e-8 of the largest of all
    nodes is constant.

    References
    ----------
    F. C. Moon, "Chaotic and Fractal Dynamics", Wiley, 1992, chapter 2.

    Examples
    --------
    >>> diagram = bifurcation_diagram(
    ...     omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)]
    ... )
    >>> diagram.extremum_radius.values.round(8)
    array([0.84973087, 0.93446294])
    >>> up = bifurcation_diagram(
    ...     omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)], direction="up", rate=0.01
    ... )
    >>> up.extremum_radius.values.round(4), up.extremum_speed.values
    (array([0.8497, 0.9361]), array([1.2, 1.7]))

    Once a revolution, of the same disc as a system too:

    >>> disc = Rotor(omega=1.2, zeta=0.5, delta0=0.5)
    >>> strobed = bifurcation_diagram(disc, starts=[(0, 0, 0, 0)], at="revolution", revolutions=3)
    >>> strobed.rotating_x.values.ravel().round(6)
    array([-0.599998, -0.599998, -0.599998, -0.599998])
    >>> same = bifurcation_diagram(disc.system(), speed=1.2, at="revolution", revolutions=3)
    >>> same.rotating_x.dims, same.rotating_x.values.ravel()[:2].round(6)
    (('speed', 'start', 'crossing', 'node'), array([-0.599998, -0.599998]))
    """
    how: dict[str, Any] = {
        "at": check_choice("at", at, SHOWN), "revolutions": revolutions, "phase": phase,
        "direction": direction, "along": along, "rtol": rtol, "workers": workers,
        "executor": executor, "study": study, "progress": progress,
    }  # fmt: skip
    if isinstance(rotor, RotorSystem):
        check_taylor(method, "a diagram")
        if speed is None:
            raise InputError("speed must be given for a diagram of a rotor system, got None")
        speeds = turning_speeds(speed, "in a diagram of a rotor system")
        asked = varied_system_of(bifurcation_diagram, rotor, varied, speeds)
        begun: Any = (None,) if starts is None else starts
        return diagram_of_system(asked, starts=begun, modes=modes, **how)
    of_disc = {"x": x, "y": y, "vx": vx, "vy": vy, "extrema_time": extrema_time, "rate": rate}
    given: dict[str, Any] = {name: each for name, each in of_disc.items() if each is not None}
    given["starts"] = 8 if starts is None else starts
    return _diagram_of_disc(
        varied_of(bifurcation_diagram, rotor, varied), **given, seed=seed, atol=atol, method=method,
        **how,
    )  # fmt: skip


def _diagram_of_disc(
    asked: Varied,
    *,
    at: Shown,
    revolutions: int | None,
    phase: float,
    x: npt.ArrayLike = (-5.0, 5.0),
    y: npt.ArrayLike = (-5.0, 5.0),
    vx: npt.ArrayLike = (-5.0, 5.0),
    vy: npt.ArrayLike = (-5.0, 5.0),
    starts: int | Starts,
    seed: int,
    extrema_time: float | None = None,
    direction: Direction | None,
    along: str | None,
    rate: float | None = None,
    rtol: float,
    atol: float,
    method: Method | None,
    workers: int | None,
    executor: str,
    study: Folder | None,
    progress: Progress | bool | None,
) -> xr.Dataset:
    """Compute the diagram of one disc: see `bifurcation_diagram`."""
    window = _window_of(at, revolutions, phase, extrema_time, rate)
    seed = check_seed(seed)
    _check_settles(asked, window)
    drawn: dict[str, Any] = {}
    chosen_starts: Any = starts
    if not isinstance(starts, xr.Dataset | list | tuple | str) and is_scalar("starts", starts):
        count = check_count("starts", starts)
        box = box_of({"x": x, "y": y, "vx": vx, "vy": vy}, count)
        chosen_starts = drawn_from(box, seed, 0, count).T
        drawn = dict(zip(COMPONENTS, box, strict=True)) | {"starts": count, "seed": seed}
    states = states_of("starts", chosen_starts, loaded=bool(asked.values("load").any()))
    options = options_of_study(rtol=rtol, atol=atol, method=method)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=options.backend != "python")
    asked, way = in_order(asked, len(states), direction, along, "omega")
    slope = None if rate is None else _checked_rate(rate, way, asked.axes["omega"])
    check_size(asked, study)
    check_varied_can_be_followed(asked, states)
    told = {name: each for name, each in (("along", way), ("rate", slope)) if each}
    question = Question("bifurcation_diagram", {
        **asked.design, "starts": states, **drawn, **window, "direction": direction,
        **told, **{name: getattr(options, name) for name in ("rtol", "atol", "method")},
    })  # fmt: skip
    plan: Ramps[Rotor, GivenStart, SettledResponse] = Ramps(
        asked, states, DiscSettling(options), asked.rotor, asked.dims.index(way or "omega")
    )
    seen = _seen(window, slope, options)
    form = form_of("points of a bifurcation diagram", "points", seen.point, seen.event)
    task = Task(
        seen.work, partial(_lost, nothing=seen.nothing), partial(_rows_of, kind=seen.point), form,
        seen.point, seen.event,
    )  # fmt: skip
    columns = run_study(plan, task, question, study=study, workers=chosen, progress=progress)
    attributes = provenance(options.attributes()) | told | start_words(states)
    attributes |= question.attribute()
    attributes |= {"section" if name == "at" else name: each for name, each in window.items()}
    if drawn:
        attributes |= {"seed": seed} | {f"range_{name}": drawn[name] for name in COMPONENTS}
    coordinates = asked.coordinates | start_coordinates(states)
    made = _diagram_of if "extrema_time" in window else _section_of
    diagram = with_direction_named(made(asked, columns, coordinates, attributes), way)
    return diagram if direction else diagram.isel(direction=0, drop=True)


def _diagram_of(
    varied: Varied, columns: Columns, coordinates: Mapping[str, Column],
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Return the results of all points, and the table of their extrema, as a dataset."""
    variables = labelled_points(varied, columns.points)
    counts = labelled("extremum_count", varied.dims, variables.pop("event_count").values)
    variables |= counted("extremum_count", counts, "extremum")
    variables |= {name: labelled(name, "extremum", each) for name, each in columns.events.items()}
    title = "Extrema of the radius over a range of speeds"
    return labelled_dataset(title, variables, coordinates, attributes, kind="bifurcation_diagram")


def _section_of(
    varied: Varied, columns: Columns, coordinates: Mapping[str, Column],
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Return the results of all points, and their states once a revolution, as a dataset."""
    variables = labelled_points(varied, columns.points, dict.fromkeys(NAMES, ("crossing",)))
    title = "States once a revolution over a range of speeds"
    numbers = {"crossing": ("crossing", np.arange(variables[NAMES[0]].sizes["crossing"]))}
    return labelled_dataset(
        title, variables, {**coordinates, **numbers}, attributes, kind="stroboscopic_diagram"
    )


def _window_of(
    at: Shown, revolutions: object, phase: object, extrema_time: object, rate: object
) -> dict[str, Any]:
    """Return what of a settled motion is shown, as arguments; refuse those of another window."""
    angle = check_real("phase", phase)
    others = {"revolutions": revolutions, "phase": angle or None}
    if at == "revolution":
        others = {"extrema_time": extrema_time, "rate": rate}
    for name, each in others.items():
        if each is not None:
            raise InputError(f"{name} must be left out with at={at!r}, got {shown(each)}")
    if at == "revolution":
        return window_of_section(revolutions, phase)
    time = USUAL_TIME if extrema_time is None else extrema_time
    return {"extrema_time": check_positive("extrema_time", time)}


def _check_settles(varied: Varied, window: Mapping[str, Any]) -> None:
    """Raise `InputError` where nothing settles, or where a run after that would be too long."""
    if not varied.axes["zeta"].all():
        raise InputError(
            "{name} must be above 0, where nothing settles, got {value}", name="zeta", value=0.0
        )
    for speed in varied.axes["omega"].tolist():
        if "extrema_time" in window:
            rotor = Rotor(omega=speed, zeta=0.0, delta0=0.0)
            check_knots("extrema_time", rotor, window["extrema_time"])
        elif speed == 0.0:
            raise InputError(
                "{name} must be positive for a section, got {value}", name="omega", value=0.0
            )
        else:
            duration = window["revolutions"] * 2.0 * math.pi / speed
            check_duration("the time of revolutions", duration, speed)
    if "revolutions" in window:
        check_points(
            *varied.axes.values(), np.arange(len(NAMES)), np.arange(window["revolutions"] + 1)
        )


def _checked_rate(rate: object, along: str, speeds: Values) -> float:
    """Return the rate of a run-up that can be followed, or raise `InputError`."""
    if not along:
        raise InputError("direction must be given with rate, got None")
    if along != "omega":
        raise InputError(
            "along must be {allowed} with a rate, got {given}", allowed=Names(("omega",)),
            given=Names((along,)),
        )  # fmt: skip
    slope = check_between("rate", rate, SLOWEST, FASTEST)
    check_increasing("omega", speeds, "for a rate")
    span = float(speeds[-1] - speeds[0]) / slope
    longest = MOST_RADIANS["compiled"] / max(float(speeds[-1]), 1.0)
    if span > longest:
        raise InputError(
            f"rate must be at least {slope * span / longest:.6g}, as a run would take hours, got "
            f"{slope!r}"
        )
    return slope


class _Point(NamedTuple):
    """The settled motion at one point of a diagram, and what is shown of it.

    That are the extrema of its radius, a table; or its states once a revolution, shape (n, 4).
    """

    response: int
    smallest: float
    largest: float
    found: npt.NDArray[Any]
    message: str = ""
    status: int = STATUS["done"]


class _Seen(NamedTuple):
    """How settled motions are watched: the work, what a failed one has, and the columns."""

    work: Callable[[DiscJob, Stop], list[_Point]]
    nothing: npt.NDArray[Any]
    point: np.dtype[np.void]
    event: np.dtype[np.void]


def _seen(window: Mapping[str, Any], rate: float | None, options: Options) -> _Seen:
    """Return how settled motions are watched."""
    if "revolutions" in window:
        count, phase = window["revolutions"], window["phase"]

        watch: Any = partial(_crossings, count=count, phase=phase, options=options)
        nothing = np.full((count if phase else count + 1, len(NAMES)), math.nan)
        columns = [(name, np.float64, (len(nothing),)) for name in NAMES]
        point = np.dtype([each for each in POINT.descr if each[0] != "event_count"] + columns)
        return _Seen(partial(_settled, watch=watch, nothing=nothing), nothing, point, NO_COLUMNS)
    if rate is not None:
        work = partial(_passed, rate=rate, rtol=options.step_rtol)
        nothing = np.empty(0, EXTREMUM_AT_A_RATE)
        return _Seen(work, nothing, POINT, EXTREMUM_AT_A_RATE)
    watch = partial(_extrema, window=window["extrema_time"], rtol=options.step_rtol)
    nothing = np.empty(0, EXTREMUM)
    return _Seen(partial(_settled, watch=watch, nothing=nothing), nothing, POINT, EXTREMUM)


def _extrema(
    rotor: Rotor, end: State, stop: Stop, *, window: float, rtol: float
) -> npt.NDArray[np.void]:
    """Return the extrema of the radius in a window after the end of a motion."""
    extrema = radius_extrema(rotor, end, window, rtol=rtol, stop=stop)
    return _table(EXTREMUM, extrema.radii, extrema.kinds)


def _crossings(
    rotor: Rotor, end: State, stop: Stop, *, count: int, phase: float, options: Options
) -> Values:
    """Return the states once a revolution after the end of a motion."""
    return crossings_of_disc(rotor, end, count, "revolution", phase, options, stop, [])[1]


def _settled(
    ramp: DiscJob, stop: Stop, *, watch: Callable[..., npt.NDArray[Any]], nothing: npt.NDArray[Any]
) -> list[_Point]:
    """Follow one ramp, and watch a motion after the end of each of its points."""
    points = []
    for rotor, settled in zip(ramp.points, settle_along(ramp, stop), strict=False):
        found, message = nothing, settled.message
        failed = settled.response == FAILED
        if not failed:
            try:
                found = watch(rotor, settled.end, stop)
            except EXPECTED as error:
                failed, message = True, reason_of(error)
        features = settled.features
        points.append(_Point(
            RESPONSE[settled.response], features.radius_min, features.radius_max, found, message,
            STATUS["failed" if failed else "done"],
        ))  # fmt: skip
    return points


def _passed(ramp: DiscJob, stop: Stop, *, rate: float, rtol: float) -> list[_Point]:
    """Settle at the first speed of a ramp, and pass the others at a rate."""
    first = settle_along(replace(ramp, points=ramp.points[:1]), stop)
    if not first:  # stopped
        return []
    (settled,), nothing = first, np.empty(0, EXTREMUM_AT_A_RATE)
    if settled.response == FAILED:
        return _lost(ramp, settled.message, nothing=nothing)
    speeds = np.array([rotor.omega for rotor in ramp.points])
    try:
        bands = ramp_extrema(
            ramp.points[0], settled.end, speeds=speeds, rate=rate, rtol=rtol,
            stop=stop,
        )  # fmt: skip
    except EXPECTED as error:
        return _lost(ramp, reason_of(error), nothing=nothing)
    return [
        _Point(
            band.response, band.smallest, band.largest,
            _table(EXTREMUM_AT_A_RATE, band.radii, band.kinds, band.speeds), settled.message,
        )
        for band in bands
    ]  # fmt: skip


def _lost(ramp: DiscJob, reason: str, *, nothing: npt.NDArray[Any]) -> list[_Point]:
    """Return the points of a ramp that could not be followed, or whose workers died."""
    failed = _Point(RESPONSE[FAILED], math.nan, math.nan, nothing, reason, STATUS["failed"])
    return [failed] * len(ramp.points)


def _table(kind: np.dtype[np.void], *columns: npt.NDArray[Any]) -> npt.NDArray[np.void]:
    """Return columns as a table."""
    found = np.empty(columns[0].size, kind)
    for name, column in zip(kind.names or (), columns, strict=True):
        found[name] = column
    return found


def _rows_of(points: Sequence[_Point], *, kind: np.dtype[np.void]) -> Rows:
    """Return points as rows, with the extrema of all, or with their states."""
    rows = np.zeros(len(points), kind)
    names = ("response", "radius_min", "radius_max", "status")
    for row, each in zip(rows, points, strict=True):
        values = (each.response, each.smallest, each.largest, each.status)
        for name, value in zip(names, values, strict=True):
            row[name] = value
        if "event_count" in (kind.names or ()):
            row["event_count"] = each.found.size
            continue
        for name, column in zip(NAMES, each.found.T, strict=True):
            row[name] = column
    messages = [each.message for each in points]
    if "event_count" in (kind.names or ()):
        return Rows(rows, messages, np.concatenate([each.found for each in points]))
    return Rows(rows, messages)
