"""Bifurcation diagrams: the extrema of the radius of settled motions at each speed.

Any other parameter may vary instead of the speed. Speeds may also be passed quasi-statically, where
the motion settles at each, or on a run-up or run-down at a rate.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import Any, TypeVar, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    COMPONENTS,
    State,
    check_between,
    check_count,
    check_direction,
    check_increasing,
    check_positive,
    check_progress,
    check_seed,
    is_scalar,
)
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.parameters import ALL_PARAMETERS, Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.varied import Varied, varied_of
from rotor_ida.parallel import FailedJob, Progress, Stop, Workers, choose, run_all, shows_progress
from rotor_ida.results.in_si import varies_in_si
from rotor_ida.results.rows import counted
from rotor_ida.schema import STATUS, labelled, spread
from rotor_ida.simulation.extrema import Extrema, check_knots, radius_extrema
from rotor_ida.simulation.options import Method, Options, options_of_study
from rotor_ida.simulation.run_up import MOST_RADIANS
from rotor_ida.simulation.starts import Starts, box_of, drawn_from
from rotor_ida.steady.ramp_extrema import NO_KINDS, NO_VALUES, SpeedBand, ramp_extrema
from rotor_ida.steady.ramps import DIRECTIONS, Direction
from rotor_ida.steady.sweep import sweep_varied

Result = TypeVar("Result")

# Variables of a sweep that the diagram includes.
OF_THE_SWEEP = ("response", "radius_min", "radius_max", "status", "message")
SLOWEST, FASTEST = 1e-12, 1e6
NO_EXTREMA = Extrema(NO_VALUES, NO_VALUES, NO_KINDS, np.empty((0, 4)))


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
    starts : int, array_like of shape (n, 4), Dataset, or sequence of these
        Number of random starts, or the starts ``(x, y, vx, vy)`` themselves [1], the same at each
        speed; or results that end in one.
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
    speeds = asked.axes["omega"]
    _check_settles(asked, window)
    way = check_direction(direction, along, asked.axes)
    slope = None if rate is None else _checked_rate(rate, way, speeds)
    attributes = {
        "title": "Extrema of the radius over a range of speeds",
        "result_kind": "bifurcation_diagram",
        "extrema_time": window,
    }
    if not isinstance(starts, xr.Dataset | list | tuple) and is_scalar("starts", starts):
        count = check_count("starts", starts)
        box = box_of({"x": x, "y": y, "vx": vx, "vy": vy}, count)
        starts = drawn_from(box, seed, 0, count).T
        attributes |= {"seed": seed}
        attributes |= {f"range_{name}": ends for name, ends in zip(COMPONENTS, box, strict=True)}
    options = options_of_study(rtol=rtol, atol=atol, method=method)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=options.backend != "python")

    def settled(speeds: Values, direction: Direction | None) -> xr.Dataset:
        """Return a sweep over some speeds, without the direction if none is given."""
        some, over = asked.over(omega=speeds), along if direction else None
        swept = sweep_varied(some, starts, direction, over, options, chosen, progress=progress)
        return swept.isel(direction=0, drop=True) if direction is None else swept

    if slope is None:
        diagram = _with_extrema(settled(speeds, direction), window, options, chosen)
        return diagram.assign_attrs(attributes)
    diagram = _at_a_rate(settled, speeds, slope, DIRECTIONS[direction], options, chosen)
    return diagram.assign_attrs(attributes | {"rate": slope})


def _check_settles(varied: Varied, window: float) -> None:
    """Raise `InputError` where nothing settles, or where a run after that would be too long."""
    if not varied.axes["zeta"].all():
        raise InputError(
            "{name} must be above 0, where nothing settles, got {value}", name="zeta", value=0.0
        )
    for speed in varied.axes["omega"].tolist():
        check_knots("extrema_time", Rotor(omega=speed, zeta=0.0, delta0=0.0), window)


def _at_a_rate(
    settled: Callable[[Values, Direction | None], xr.Dataset],
    speeds: Values,
    rate: float,
    ways: Sequence[int],
    options: Options,
    workers: Workers,
) -> xr.Dataset:
    """Return the diagram of run-ups and run-downs from the motions settled at their first speed."""
    runs = []
    for way in ways:
        passed = speeds[::way]
        work = partial(ramp_extrema, speeds=passed, rate=rate, rtol=options.step_rtol)
        after, bands = _followed_on(settled(passed[:1], None), work, workers)
        runs.append((after, [each and each[::way] for each in bands]))
    return _joined(runs, speeds, ways)


def _checked_rate(rate: object, along: str, speeds: Values) -> float:
    """Return the rate of a run-up that can be followed, or raise `InputError`."""
    if not along:
        raise InputError("direction must be given with rate, got None")
    if along != "omega":
        raise InputError(f"along must be 'omega' with a rate, got {along!r}")
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


def _followed_on(
    settled: xr.Dataset, work: Callable[..., Result], workers: Workers
) -> tuple[xr.Dataset, list[Result | None]]:
    """Return the sweep, and the result of `work` from the end of each point; None where it failed.

    A point of the sweep whose motion cannot be continued is marked as failed.
    """
    status = settled["status"].values.flatten()  # a copy
    message = settled["message"].values.ravel().tolist()
    results: list[Result | None] = [None] * status.size
    due = np.flatnonzero(status == STATUS["done"])
    attempt, jobs = partial(_attempt, work=work), _jobs(settled, due)
    executor, count = workers
    with closing(run_all(attempt, jobs, workers=count, executor=executor)) as ended:
        for turn, result in ended:
            number = int(due[turn])
            if isinstance(result, FailedJob):
                status[number], message[number] = STATUS["failed"], result.reason
            else:
                results[number] = result
    dims, shape = settled["status"].dims, settled["status"].shape
    after = settled.assign(
        status=labelled("status", dims, status.reshape(shape)),
        message=labelled("message", dims, np.array(message).reshape(shape)),
    )
    return after, results


def _jobs(settled: xr.Dataset, numbers: npt.NDArray[np.intp]) -> Iterator[tuple[Rotor, State]]:
    """Yield rotor and final state, on the rotating axes, of the points with these numbers."""
    status = settled["status"]
    given = spread(settled, ALL_PARAMETERS, status)
    ends = np.stack([settled[f"end_{name}"].values.ravel() for name in COMPONENTS], axis=-1)
    for number in numbers.tolist():
        rotor = Rotor(**{name: float(values.flat[number]) for name, values in given.items()})
        x, y, vx, vy = ends[number].tolist()
        yield rotor, (x, y, vx, vy)


def _attempt(
    job: tuple[Rotor, State], stop: Stop, *, work: Callable[..., Result]
) -> Result | FailedJob:
    """Return the result for one motion, or the reason why it cannot be continued."""
    rotor, start = job
    if stop[0]:
        return FailedJob("given up")
    try:
        return work(rotor, start, stop=stop)
    except SimulationError as error:
        return FailedJob(str(error))


def _with_extrema(
    settled: xr.Dataset, window: float, options: Options, workers: Workers
) -> xr.Dataset:
    """Return the variables of a sweep with the extrema after the end of each point's run."""
    work = partial(radius_extrema, duration=window, rtol=options.step_rtol)
    after, results = _followed_on(settled, work, workers)
    extrema = [each or NO_EXTREMA for each in results]
    columns: dict[str, Sequence[npt.NDArray[Any]]] = {
        "extremum_radius": [each.radii for each in extrema],
        "extremum_kind": [each.kinds for each in extrema],
    }
    kept = after[list(OF_THE_SWEEP)].copy(deep=True)
    return kept.assign(_extremum_table(columns, kept["status"].dims, kept["status"].shape))


def _extremum_table(
    columns: Mapping[str, Sequence[npt.NDArray[Any]]],
    dims: Sequence[Hashable],
    shape: tuple[int, ...],
) -> dict[str, xr.Variable]:
    """Return the extrema of all points, in their order, and how many each has, as variables."""
    sizes = np.array([part.size for part in columns["extremum_radius"]])
    counts = labelled("extremum_count", dims, sizes.reshape(shape))
    return counted("extremum_count", counts, "extremum") | {
        name: labelled(name, "extremum", np.concatenate(parts)) for name, parts in columns.items()
    }


def _joined(
    runs: Sequence[tuple[xr.Dataset, list[list[SpeedBand] | None]]],
    speeds: Values,
    directions: Sequence[int],
) -> xr.Dataset:
    """Return the diagram of runs in each direction, speeds first and directions last.

    Each direction has the sweep of its first speed, and for each of its points the bands by speed.
    """
    first = runs[0][0]
    shape = (speeds.size, *first["status"].shape[1:], len(directions))
    dims = (*first["status"].dims, "direction")
    bands = [
        each[place] if each else SpeedBand()
        for place in range(speeds.size)
        for of_point in zip(*(each for _, each in runs), strict=True)
        for each in of_point
    ]
    points = {
        "response": np.array([band.response for band in bands], np.int8),
        "radius_min": np.array([band.smallest for band in bands]),
        "radius_max": np.array([band.largest for band in bands]),
    }
    columns: dict[str, Sequence[npt.NDArray[Any]]] = {
        "extremum_speed": [band.speeds for band in bands],
        "extremum_radius": [band.radii for band in bands],
        "extremum_kind": [band.kinds for band in bands],
    }
    per_run = {
        name: np.broadcast_to(np.stack([swept[name].values for swept, _ in runs], axis=-1), shape)
        for name in ("status", "message")
    }
    diagram = first.drop_vars([*first.data_vars, "omega"]).assign_coords(
        omega=labelled("omega", "omega", speeds),
        direction=labelled("direction", "direction", np.array(directions, np.int8)),
    )
    return diagram.assign(
        {name: labelled(name, dims, each.reshape(shape)) for name, each in points.items()}
        | {name: labelled(name, dims, each.copy()) for name, each in per_run.items()}
        | _extremum_table(columns, dims, shape)
    )
