"""Bifurcation diagrams: the extrema of the radius of settled motions at each speed.

Any other parameter may vary instead of the speed. Speeds may also be passed quasi-statically, where
the motion settles at each, or on a run-up or run-down at a rate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    COMPONENTS,
    Names,
    check_between,
    check_count,
    check_increasing,
    check_positive,
    check_progress,
    check_seed,
    is_scalar,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.varied import Varied, varied_of
from rotor_ida.parallel import Progress, Stop, choose, shows_progress
from rotor_ida.results.in_si import varies_in_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.rows import counted
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import RESPONSE, STATUS, labelled, labelled_dataset
from rotor_ida.simulation.course import MOST_RADIANS
from rotor_ida.simulation.extrema import check_knots, radius_extrema
from rotor_ida.simulation.options import Method, options_of_study
from rotor_ida.simulation.starts import GivenStart, Starts, box_of, drawn_from, states_of
from rotor_ida.steady.follow import FAILED, SettledResponse
from rotor_ida.steady.grid import (
    EXPECTED,
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

SLOWEST, FASTEST = 1e-12, 1e6
# The columns with a number for each point, and those with one for each of its extrema.
POINT = np.dtype(
    [
        ("response", np.int8), ("radius_min", np.float64), ("radius_max", np.float64),
        ("status", np.int8), ("event_count", np.int64),
    ]
)  # fmt: skip
EXTREMUM = np.dtype([("extremum_radius", np.float64), ("extremum_kind", np.int8)])
EXTREMUM_AT_A_RATE = np.dtype([*EXTREMUM.descr, ("extremum_speed", np.float64)])


@varies_in_si
@shows_progress
def bifurcation_diagram(
    rotor: Rotor | DimensionalRotor | None = None,
    *,
    x: npt.ArrayLike = (-5.0, 5.0),
    y: npt.ArrayLike = (-5.0, 5.0),
    vx: npt.ArrayLike = (-5.0, 5.0),
    vy: npt.ArrayLike = (-5.0, 5.0),
    starts: int | Starts = 8,
    seed: int = 0,
    extrema_time: float = 100.0,
    direction: Direction | None = None,
    along: str | None = None,
    rate: float | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute a bifurcation diagram: extrema of the settled radius at each speed, from many starts.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given.
    x, y, vx, vy : float or array_like, shape (2,)
        Components of random starts [1]: numbers, or ranges ``(low, high)`` from which they are
        drawn independently and uniformly, as for `rotor_ida.basin_fractions`.
    starts : int, array_like of shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Number of random starts, or the starts ``(x, y, vx, vy)`` themselves [1], the same at each
        speed; words for those at each speed; or results that end in one.
    seed : int
        Seed of the random starts.
    extrema_time : float
        Length of the window, after the rotor has settled, in which extrema are found [1]; at
        most 10 million times the step between knots. Ignored with a rate.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the settled state of the one before. By default each speed
        begins from the starts.
    along : str, optional
        Name of the parameter that rises or falls with a direction, as for `rotor_ida.sweep`; with
        a rate it is the speed.
    rate : float, optional
        Change of speed per unit time [1]. The motion settles only at the first speed; then the
        speed runs through the others at this rate. Requires a direction.
    rtol, atol : float
        Relative and absolute tolerance [1].
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Solver of the contacts until the rotor has settled, as for `rotor_ida.sweep`. Extrema
        are found by Taylor series.
    workers, executor
        As for `rotor_ida.sweep`: by default all cores, for the motions and for their extrema.
    study : path-like, optional
        Folder in which points are stored as they are done, as for `rotor_ida.sweep`.
    progress : callable or bool, optional
        Called with the number of points done and their total; True shows a bar on standard error.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], as for `rotor_ida.sweep`.

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
    """
    window, seed = check_positive("extrema_time", extrema_time), check_seed(seed)
    asked = varied_of(bifurcation_diagram, rotor, varied)
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
        **asked.design, "starts": states, **drawn, "extrema_time": window, "direction": direction,
        **told, **{name: getattr(options, name) for name in ("rtol", "atol", "method")},
    })  # fmt: skip
    plan: Ramps[Rotor, GivenStart, SettledResponse] = Ramps(
        asked, states, DiscSettling(options), asked.rotor, asked.dims.index(way or "omega")
    )
    how: dict[str, Any] = {"window": window} if slope is None else {"rate": slope}
    work: Any = partial(_settled if slope is None else _passed, rtol=options.step_rtol, **how)
    extremum = EXTREMUM if slope is None else EXTREMUM_AT_A_RATE
    form = form_of("points of a bifurcation diagram", "points", POINT, extremum)
    task = Task(work, partial(_lost, kind=extremum), _rows_of, form, POINT, extremum)
    columns = run_study(plan, task, question, study=study, workers=chosen, progress=progress)
    attributes = provenance(options.attributes()) | told | start_words(states)
    attributes |= question.attribute()
    attributes["extrema_time"] = window
    if drawn:
        attributes |= {"seed": seed} | {f"range_{name}": drawn[name] for name in COMPONENTS}
    diagram = with_direction_named(_diagram_of(asked, states, columns, attributes), way)
    return diagram if direction else diagram.isel(direction=0, drop=True)


def _diagram_of(
    varied: Varied, starts: Sequence[GivenStart], columns: Columns, attributes: Mapping[str, Any]
) -> xr.Dataset:
    """Return the results of all points, and the table of their extrema, as a dataset."""
    variables = labelled_points(varied, columns.points)
    counts = labelled("extremum_count", varied.dims, variables.pop("event_count").values)
    variables |= counted("extremum_count", counts, "extremum")
    variables |= {name: labelled(name, "extremum", each) for name, each in columns.events.items()}
    title = "Extrema of the radius over a range of speeds"
    coordinates = varied.coordinates | start_coordinates(starts)
    return labelled_dataset(title, variables, coordinates, attributes, kind="bifurcation_diagram")


def _check_settles(varied: Varied, window: float) -> None:
    """Raise `InputError` where nothing settles, or where a run after that would be too long."""
    if not varied.axes["zeta"].all():
        raise InputError(
            "{name} must be above 0, where nothing settles, got {value}", name="zeta", value=0.0
        )
    for speed in varied.axes["omega"].tolist():
        check_knots("extrema_time", Rotor(omega=speed, zeta=0.0, delta0=0.0), window)


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
    """The settled motion at one point of a diagram, and the extrema of its radius."""

    response: int
    smallest: float
    largest: float
    extrema: npt.NDArray[np.void]
    message: str = ""
    status: int = STATUS["done"]


def _settled(ramp: DiscJob, stop: Stop, *, window: float, rtol: float) -> list[_Point]:
    """Follow one ramp, and find the extrema in a window after the end of each of its points."""
    points = []
    for rotor, settled in zip(ramp.points, settle_along(ramp, stop), strict=False):
        found, message = np.empty(0, EXTREMUM), settled.message
        failed = settled.response == FAILED
        if not failed:
            try:
                extrema = radius_extrema(rotor, settled.end, window, rtol=rtol, stop=stop)
                found = _table(EXTREMUM, extrema.radii, extrema.kinds)
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
    (settled,) = first
    if settled.response == FAILED:
        return _lost(ramp, settled.message, kind=EXTREMUM_AT_A_RATE)
    speeds = np.array([rotor.omega for rotor in ramp.points])
    try:
        bands = ramp_extrema(
            ramp.points[0], settled.end, speeds=speeds, rate=rate, rtol=rtol,
            stop=stop,
        )  # fmt: skip
    except EXPECTED as error:
        return _lost(ramp, reason_of(error), kind=EXTREMUM_AT_A_RATE)
    return [
        _Point(
            band.response, band.smallest, band.largest,
            _table(EXTREMUM_AT_A_RATE, band.radii, band.kinds, band.speeds), settled.message,
        )
        for band in bands
    ]  # fmt: skip


def _lost(ramp: DiscJob, reason: str, *, kind: np.dtype[np.void]) -> list[_Point]:
    """Return the points of a ramp that could not be followed, or whose workers died."""
    failed = _Point(
        RESPONSE[FAILED], math.nan, math.nan, np.empty(0, kind), reason, STATUS["failed"]
    )
    return [failed] * len(ramp.points)


def _table(kind: np.dtype[np.void], *columns: npt.NDArray[Any]) -> npt.NDArray[np.void]:
    """Return columns as a table."""
    found = np.empty(columns[0].size, kind)
    for name, column in zip(kind.names or (), columns, strict=True):
        found[name] = column
    return found


def _rows_of(points: Sequence[_Point]) -> Rows:
    """Return points as rows, and the extrema of all."""
    rows = [
        (each.response, each.smallest, each.largest, each.status, each.extrema.size)
        for each in points
    ]
    extrema = np.concatenate([each.extrema for each in points])
    return Rows(np.array(rows, POINT), [each.message for each in points], extrema)
