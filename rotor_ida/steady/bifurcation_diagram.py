"""Bifurcation diagrams: settled motions at each speed, by their extrema or once a revolution.

Any other parameter may vary instead of the speed. Speeds may also be passed quasi-statically, where
the motion settles at each, or one disc may pass them on a run-up or run-down at a rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import (
    COMPONENTS,
    Names,
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
from rotor_ida.core.system_requests import Places
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED, AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.question import Question
from rotor_ida.results.rows import counted
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import labelled
from rotor_ida.simulation.course import MOST_RADIANS
from rotor_ida.simulation.crossings import (
    check_knots,
    crossings_of,
    distance_extrema,
    radius_extrema,
)
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.sections import (
    ATOL,
    NAMES,
    check_taylor,
    checked_angle,
)
from rotor_ida.simulation.starts import GivenStart, Starts, box_of, drawn_from
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady.grid import (
    EXPECTED,
    NO_COLUMNS,
    Answer,
    Answers,
    Columns,
    Direction,
    RampJob,
    Ramps,
    Table,
    check_size,
    failed,
    in_order,
    labelled_points,
    reason_of,
    run_study,
)
from rotor_ida.steady.points import VariedDisc, VariedSystem, turning_speeds
from rotor_ida.steady.ramp_extrema import (
    EXTREMUM,
    EXTREMUM_AT_A_RATE,
    ramp_extrema,
    table_of,
)
from rotor_ida.steady.sweep import study_dataset

Shown = Literal["extrema", "revolution"]
SHOWN = ("extrema", "revolution")
SLOWEST, FASTEST = 1e-12, 1e6
# The time in which extrema of one disc are found by default, and all else in revolutions; the range
# of random starts.
USUAL_TIME, USUAL_REVOLUTIONS, USUAL_RANGE = 100.0, 64, (-5.0, 5.0)

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
        Angle of the unbalance from x in the section, below 2 pi [rad]; of a `RotorSystem` that of
        the mark from which the phases of its unbalance are counted.
    x, y, vx, vy : float or array_like, shape (2,), optional
        Components of random starts of one disc [dimensionless]: numbers, or ranges ``(low, high)``
        from which they are drawn independently and uniformly, as for `rotor_ida.basin_fractions`.
        Default: from -5 to 5.
    starts : int, array_like of shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Number of random starts, by default 8, or the starts ``(x, y, vx, vy)`` themselves
        [dimensionless], the same at each speed; words for those at each speed; or results that end
        in one. Of a `RotorSystem` as in `sweep`: by default one, at rest at 0.
    seed : int
        Seed of the random starts.
    extrema_time : float, optional
        Length of the window, after one disc has settled, in which extrema are found
        [dimensionless]; at most 10 million times the step between knots. Default: 100. Ignored with
        a rate.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the settled state of the one before. By default each speed
        begins from the starts.
    along : str, optional
        Name of the parameter that rises or falls with a direction, as for `rotor_ida.sweep`; with
        a rate it is the speed.
    rate : float, optional
        Change of speed per unit time [dimensionless]. The motion settles only at the first speed;
        then the speed runs through the others at this rate. Requires a direction, and one disc.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    rtol, atol : float
        Relative and absolute tolerance [dimensionless]. A `RotorSystem` has the relative one alone,
        from 1e-14 to 1e-4.
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
        Parameters of `Rotor` by name [dimensionless], as for `rotor_ida.sweep`.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as in `sweep`.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start)``, with any other axes before ``start``:
        ``response`` (its kind, as a flag), ``radius_min``, ``radius_max``, ``status`` and
        ``message``, as from `rotor_ida.sweep`, and ``extremum_count``. ``extremum_radius``
        [dimensionless] and ``extremum_kind`` (minimum, maximum, or constant) list the extrema of
        all points in one table, ``extremum_count`` rows each. With a direction the last dimension
        is ``direction``. With a rate ``extremum_speed`` [dimensionless] is the speed at each
        extremum, and a point has the extrema up to halfway between its speed and its neighbours;
        ``response`` then reports only whether the rotor touches there, and whether its radius
        oscillates.

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
    window = _window_of(at, revolutions, phase, extrema_time, rate, isinstance(rotor, RotorSystem))
    seed, reports = check_seed(seed), check_progress(progress)
    asked, drawn = _asked(
        rotor, varied, window, speed=speed, starts=starts, seed=seed, modes=modes,
        ranges=dict(zip(COMPONENTS, (x, y, vx, vy), strict=True)),
        rtol=rtol, atol=atol, method=method,
    )  # fmt: skip
    chosen = choose(executor, workers, compiled=asked.is_compiled)
    points, way = in_order(asked.varied, len(asked.starts), direction, along, asked.speed)
    slope = None if rate is None else _checked_rate(rate, way, points.axes["omega"])
    check_size(points, study)
    window.check_size(points)
    told = {name: each for name, each in (("along", way), ("rate", slope))
            if each and each != SPEED}  # fmt: skip
    question = Question("bifurcation_diagram", {
        **points.design, "starts": asked.kept, **drawn, **window.asked, "direction": direction,
        **told, **asked.arguments,
    })  # fmt: skip
    plan = _watched(asked.ramps(points, way), asked, window, slope)
    follow = None
    if slope is not None and isinstance(asked, VariedDisc):
        follow = partial(_passed, slope, asked.options.step_rtol)
    columns = run_study(
        plan, question, word="points of a bifurcation diagram", follow=follow, study=study,
        workers=chosen, progress=reports,
    )  # fmt: skip
    attributes = asked.attributes | told | question.attribute() | window.attributes
    if drawn:
        attributes |= {"seed": seed} | {f"range_{name}": drawn[name] for name in COMPONENTS}
    diagram = _dataset(asked, points, columns, window, attributes)
    return diagram if direction else diagram.isel(direction=0, drop=True)


def _asked(
    rotor: Rotor | DimensionalRotor | RotorSystem | None, varied: AnyAxes, window: _Window, *,
    speed: npt.ArrayLike | None, starts: Any, ranges: Mapping[str, npt.ArrayLike | None],
    seed: int, modes: int | None, rtol: float, atol: float, method: Method | None,
) -> tuple[VariedDisc | VariedSystem, dict[str, Any]]:  # fmt: skip
    """Return the rotors that are asked for, checked, and from where their starts were drawn."""
    if isinstance(rotor, RotorSystem):
        check_taylor(method, "a diagram")
        if speed is None:
            raise InputError("speed must be given for a diagram of a rotor system, got None")
        speeds = turning_speeds(speed, "in a diagram of a rotor system")
        systems = varied_system_of(bifurcation_diagram, rotor, varied, speeds)
        return VariedSystem.of(systems, (None,) if starts is None else starts, modes, rtol), {}
    discs = varied_of(bifurcation_diagram, rotor, varied)
    _check_settles(discs, window)
    chosen, drawn = _starts_of_disc(8 if starts is None else starts, ranges, seed)
    return VariedDisc.of(discs, chosen, rtol=rtol, atol=atol, method=method), drawn


def _starts_of_disc(
    starts: Any, ranges: Mapping[str, npt.ArrayLike | None], seed: int
) -> tuple[Any, dict[str, Any]]:
    """Return starts of one disc, and from where they were drawn if only their number is given."""
    if isinstance(starts, xr.Dataset | list | tuple | str) or not is_scalar("starts", starts):
        return starts, {}
    count = check_count("starts", starts)
    box = box_of(
        {name: USUAL_RANGE if each is None else each for name, each in ranges.items()}, count
    )
    drawn = dict(zip(COMPONENTS, box, strict=True)) | {"starts": count, "seed": seed}
    return drawn_from(box, seed, 0, count).T, drawn


@dataclass(frozen=True, slots=True)
class _Window:
    """What of a settled motion is shown: its extrema, or its states once a revolution.

    Extrema of one disc are found in a time, all else in a number of revolutions.
    """

    at: Shown
    revolutions: int = 0
    phase: float = 0.0
    time: float | None = None

    @property
    def is_strobed(self) -> bool:
        """Whether states once a revolution are shown."""
        return self.at == "revolution"

    @property
    def asked(self) -> dict[str, Any]:
        """The arguments of a question."""
        if self.time is not None:
            return {"extrema_time": self.time}
        more = {"phase": self.phase} if self.is_strobed else {}
        return {"at": self.at, "revolutions": self.revolutions, **more}

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of a result, which name the section as others do."""
        asked = self.asked
        at = asked.pop("at", "")
        return asked | ({"section": at} if self.is_strobed else {})

    def check_size(self, varied: Varied) -> None:
        """Refuse more states than fit into memory."""
        if self.is_strobed:
            sizes = [len(NAMES), self.revolutions + (0 if self.phase else 1)]
            sizes += [] if varied.system is None else [len(varied.base.nodes)]
            check_points(*varied.axes.values(), *map(np.arange, sizes))

    def columns(self, nodes: tuple[int, ...]) -> list[tuple[str, Any, tuple[int, ...]]]:
        """Return the columns of what is shown at a point."""
        if self.is_strobed:
            count = self.revolutions + (0 if self.phase else 1)
            return [(name, np.float64, (count, *nodes)) for name in NAMES]
        return [("event_count", np.int64, ()), ("extremum_count", np.int64, nodes)]

    def shown(self, flow: Flow, state: Values) -> tuple[dict[str, Any], Table | None]:
        """Return what is shown of the motion from a state: its columns, and those of extrema."""
        if self.is_strobed:
            found = crossings_of(flow, state, self.revolutions, self.at, self.phase)
            return dict(zip(NAMES, found.states, strict=True)), None
        counts, *columns = _extrema(flow, state, self)
        extrema = table_of(EXTREMUM, *columns)
        return {"event_count": extrema.size, "extremum_count": counts}, extrema


def _extrema(flow: Flow, state: Values, window: _Window) -> tuple[Any, Values, Any]:
    """Return how many extrema there are, of each node of a system, their distances and kinds."""
    if isinstance(flow, DiscFlow):
        assert window.time is not None
        of_disc = radius_extrema(flow.but(rtol=flow.options.step_rtol), state, window.time)
        return of_disc.size, of_disc["radius"], of_disc["kind"]
    assert isinstance(flow, SystemFlow)
    rows = flow.problem.found.rows_in_y(flow.problem.assembly.node_rows())
    nodes = Places(rows, np.zeros((len(rows), 2)))
    found = distance_extrema(flow, state, window.revolutions * flow.revolution, nodes)
    counts = np.bincount(found["place"], minlength=len(rows))
    return counts, found["distance"], found["kind"]


def _window_of(
    at: Shown, revolutions: object, phase: object, extrema_time: object, rate: object,
    is_of_system: bool,
) -> _Window:  # fmt: skip
    """Return what of a settled motion is shown; refuse the arguments of another window."""
    check_choice("at", at, SHOWN)
    angle = check_real("phase", phase)
    others = {"revolutions": None if is_of_system else revolutions, "phase": angle or None}
    if at == "revolution":
        others = {"extrema_time": extrema_time, "rate": rate}
    for name, each in others.items():
        if each is not None:
            raise InputError(f"{name} must be left out with at={at!r}, got {shown(each)}")
    if at == "extrema" and not is_of_system:
        time = USUAL_TIME if extrema_time is None else extrema_time
        return _Window(at, time=check_positive("extrema_time", time))
    count = check_count("revolutions", USUAL_REVOLUTIONS if revolutions is None else revolutions)
    return _Window(at, count, checked_angle(phase))


def _check_settles(varied: Varied, window: _Window) -> None:
    """Raise `InputError` where nothing settles, or where a run after that would be too long."""
    if not varied.axes["zeta"].all():
        raise InputError(
            "{name} must be above 0, where nothing settles, got {value}", name="zeta", value=0.0
        )
    for speed in varied.axes["omega"].tolist():
        if window.time is not None:
            check_knots("extrema_time", Rotor(omega=speed, zeta=0.0, delta0=0.0), window.time)
        elif speed == 0.0:
            raise InputError(
                "{name} must be positive for a section, got {value}", name="omega", value=0.0
            )
        else:
            duration = window.revolutions * 2.0 * math.pi / speed
            check_duration("the time of revolutions", duration, speed)


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
            "{name} must be at least {least:.6g}, as a run would take hours, got {value}",
            name="rate", least=slope * span / longest, value=slope,
        )  # fmt: skip
    return slope


# ---- Settled motions, and what is shown of them ----


def _watched(
    plan: Ramps[Any, Any], asked: VariedDisc | VariedSystem, window: _Window, rate: float | None
) -> Ramps[Any, Any]:
    """Return ramps whose points are not only settled, but watched after that."""
    swept, settle = plan.answers.kind, plan.answers.work
    nodes = () if asked.varied.system is None else (len(asked.varied.base.nodes),)
    columns: list[Any] = [(name, swept[name]) for name in asked.kept_columns]
    kind = np.dtype([*columns, *window.columns(nodes)])
    if rate is not None:
        return replace(plan, answers=Answers(settle, kind, EXTREMUM_AT_A_RATE))
    watch = partial(_watch, settle, asked.motion, window)
    event = NO_COLUMNS if window.is_strobed else EXTREMUM
    return replace(plan, answers=Answers(watch, kind, event))


def _watch(
    settle: Callable[[Any, Any, Stop], Answer], motion: Callable[..., tuple[Flow, Values]],
    window: _Window, point: Any, start: Any, stop: Stop,
) -> Answer:  # fmt: skip
    """Follow a rotor until it has settled, and watch its motion after that."""
    settled = settle(point, start, stop)
    columns, extrema = window.shown(*motion(point, settled.end, stop))
    return settled._replace(figures={**settled.figures, **columns}, events=extrema)


def _passed(rate: float, rtol: float, ramp: RampJob[Rotor, GivenStart], stop: Stop) -> list[Answer]:
    """Settle at the first speed of a ramp, and pass the others at a rate."""
    answers, first = ramp.answers, ramp.points[0]
    try:
        settled = answers.work(first, ramp.start, stop)
        speeds = np.array([rotor.omega for rotor in ramp.points])
        return ramp_extrema(first, settled.end, speeds=speeds, rate=rate, rtol=rtol, stop=stop)
    except EXPECTED as error:
        return [failed(reason_of(error))] * len(ramp.points)


def _dataset(
    asked: VariedDisc | VariedSystem, points: Varied, columns: Columns, window: _Window,
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Return the results of all points, and what is shown of them, as a labelled dataset."""
    is_of_disc = points.system is None
    node = () if is_of_disc else ("node",)
    behind = {**asked.behind, "extremum_count": node, **dict.fromkeys(NAMES, ("crossing", *node))}
    variables, coordinates = (
        labelled_points(points, columns.points, behind),
        asked.coordinates(points),
    )
    if window.is_strobed:
        coordinates["crossing"] = ("crossing", np.arange(variables[NAMES[0]].sizes["crossing"]))
        title, kind = "states once a revolution", "stroboscopic_diagram"
    else:
        del variables["event_count"]
        variables |= counted("extremum_count", variables["extremum_count"], "extremum")
        table = columns.events
        variables |= {name: labelled(name, "extremum", each) for name, each in table.items()}
        title = "extrema of the radius" if is_of_disc else "extrema of the distances of nodes"
        kind = "bifurcation_diagram" if is_of_disc else "diagram"
    title = title.capitalize() if is_of_disc else f"{asked.title}: {title}"
    return study_dataset(
        asked, points, f"{title} over a range of speeds", variables, coordinates, attributes, kind
    )
