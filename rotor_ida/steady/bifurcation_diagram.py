"""What remains of the motion at each speed: the extrema of its radius, from many starts.

Any other parameter may vary in its place. Speeds may also be passed one after the other, slowly, so
that the motion settles at each, or on a run-up or run-down at a rate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    COMPONENTS,
    State,
    check_axis,
    check_between,
    check_choice,
    check_count,
    check_positive,
    check_seed,
    is_scalar,
)
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import ALL_PARAMETERS
from rotor_ida.parallel import FailedJob, Stop, choose, run_all
from rotor_ida.schema import STATUS, labelled
from rotor_ida.simulation.extrema import Extrema, check_knots, radius_extrema
from rotor_ida.simulation.options import LARGEST, Method, Options
from rotor_ida.simulation.run_up import MOST_RADIANS
from rotor_ida.steady.ramp_extrema import Runs, joined, run_through
from rotor_ida.steady.sweep import DIRECTIONS, Direction, sweep

# What of a sweep's variables stands in the diagram.
OF_THE_SWEEP = ("response", "radius_min", "radius_max", "status", "message")
SLOWEST, FASTEST = 1e-12, 1e6


def bifurcation_diagram(
    *,
    omega: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: npt.ArrayLike = 0.0,
    contact_exponent: npt.ArrayLike = 1.5,
    contact_damping: npt.ArrayLike = 0.0,
    load: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 0.0,
    disc_radius: npt.ArrayLike | None = None,
    starts: int | npt.ArrayLike = 8,
    seed: int = 0,
    reach: float = 5.0,
    extrema_time: float = 100.0,
    direction: Direction | None = None,
    rate: float | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    workers: int | None = None,
    executor: str = "auto",
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Return the extrema of the radius that remain at each speed, from many starts.

    Parameters
    ----------
    omega, zeta, delta0 : array_like, shape (n,) or scalar
        The parameters to combine [1].
    shaft_stiffness, contact_exponent, contact_damping, load, friction : array_like or scalar
        As for `rotor_ida.sweep`: more to combine, a dimension where an axis is given [1].
    disc_radius : array_like, shape (n,), or scalar, optional
        The radius of the disc [1], which friction needs; likewise.
    starts : int or array_like, shape (n, 4)
        Number of random starts, or the starts ``(x, y, vx, vy)`` themselves [1]. Each speed has
        the same ones.
    seed : int
        Seed of the random starts.
    reach : float
        Random starts are drawn evenly from ``-reach`` to ``reach`` in each of x, y, vx, vy, at
        most 1e6 [1].
    extrema_time : float
        Length of the window, after the rotor has settled, in which extrema are looked for [1]; at
        most 10 million times the step between knots. With a rate it does not matter.
    direction : {"up", "down", "both"}, optional
        Without it each speed begins from the starts. With it only the first does (the last, going
        down), and each further one from where the one before has settled: a quasi-static run-up or
        run-down.
    rate : float, optional
        Change of the speed in a unit of time [1]: with it the motion settles at the first speed
        alone, and then the speed runs through the others, at this rate and without a stop. A
        direction must be given.
    rtol, atol : float
        Relative and absolute tolerance [1].
    method : {"adams", "bdf", "ida", "taylor"}
        Solver of the contacts until the rotor has settled, as for `rotor_ida.simulate`. Extrema
        are found by Taylor series.
    workers, executor
        As for `rotor_ida.sweep`: by default all cores, for the motions and for their extrema.
    progress : callable, optional
        Called with the number of points done and their total.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start)``, and before ``start`` on what else is an axis:
        ``response`` (its kind, as a flag), ``radius_min``, ``radius_max``, ``status``,
        ``message``, as from `rotor_ida.sweep`, and ``extremum_count``. ``extremum_radius`` [1] and
        ``extremum_kind`` (minimum, maximum, or constant where the radius is) hold the extrema of
        all points in one table, ``extremum_count`` rows each. With a direction the last dimension
        is ``direction``. With a rate ``extremum_speed`` [1] is the speed at which each extremum was
        met, and a point has those met up to the middles between its speed and its neighbours;
        ``response`` then says no more than whether the rotor touches there, and whether its radius
        swings.

    Raises
    ------
    InputError
        If an argument cannot be used, or a damping is zero: without damping no motion settles; or
        if there is a rate without a direction, or with speeds that do not increase. A point that
        fails does not raise: its ``status`` and ``message`` say why, and it has no extrema.

    Notes
    -----
    An extremum is a root of ``r r' = x vx + y vy``, found to about 1e-10 of the radius,
    or to 1e-8 where the rotor passes through the centre without clearance. On a
    synchronous whirl ``r r'`` vanishes throughout; its radius is given once. Periodic motions
    are few values, chaotic and quasi-periodic ones fill ranges. On a run-up the radius of a whirl
    drifts; what it trembles by less than 1e-6 of itself is left out. As the rate falls the diagram
    tends to that of the quasi-static run-up, but for jumps, which are late: see
    `rotor_ida.closed_forms.late_jumps`.

    References
    ----------
    F. C. Moon, "Chaotic and Fractal Dynamics", Wiley, 1992, chapter 2.

    Examples
    --------
    >>> found = bifurcation_diagram(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> found.extremum_radius.values.round(8)
    array([0.84973087, 0.93446294])
    >>> up = bifurcation_diagram(
    ...     omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)], direction="up", rate=0.01
    ... )
    >>> up.extremum_radius.values.round(4), up.extremum_speed.values
    (array([0.8497, 0.9361]), array([1.2, 1.7]))
    """
    window, seed = check_positive("extrema_time", extrema_time), check_seed(seed)
    farthest = check_positive("reach", reach, LARGEST)
    if not check_axis("zeta", zeta).all():
        raise InputError("zeta must be above 0, where nothing settles, got 0.0")
    for speed in check_axis("omega", omega).tolist():
        check_knots("extrema_time", Rotor(omega=speed, zeta=0.0, delta0=0.0), window)
    if direction is not None:
        check_choice("direction", direction, ("up", "down", "both"))
    slope = None
    if rate is not None:
        slope = _checked_rate(rate, direction, check_axis("omega", omega))
    told = {
        "title": "Extrema of the radius over a range of speeds",
        "result_kind": "bifurcation_diagram",
        "extrema_time": window,
    }
    if is_scalar("starts", starts):
        shape = (check_count("starts", starts), len(COMPONENTS))
        starts = np.random.default_rng(seed).uniform(-farthest, farthest, shape)
        told |= {"seed": seed, "reach": farthest}
    swept = partial(
        sweep, zeta=zeta, delta0=delta0, shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent, contact_damping=contact_damping, load=load,
        friction=friction, disc_radius=disc_radius, starts=starts, rtol=rtol, atol=atol,
        method=method, workers=workers, executor=executor, progress=progress,
    )  # fmt: skip
    options = Options(rtol=rtol, atol=atol, method=method)
    if slope is not None:
        speeds, turns = check_axis("omega", omega), DIRECTIONS[direction]
        how = options, workers, executor
        found = joined(
            [_at_a_rate(swept, speeds[::turn], slope, how) for turn in turns], speeds, turns
        )
        return found.assign_attrs(told | {"rate": slope})
    settled = swept(omega=omega, direction=direction).drop_dims("event")
    if direction is None:
        settled = settled.isel(direction=0, drop=True)
    return _with_extrema(settled, window, options, workers, executor).assign_attrs(told)


def _checked_rate(rate: object, direction: str | None, speeds: Values) -> float:
    """Return the rate of a run-up that can be followed, or raise `InputError`."""
    if direction is None:
        raise InputError("direction must be given with rate, got None")
    slope = check_between("rate", rate, SLOWEST, FASTEST)
    for before, after in pairwise(speeds.tolist()):
        if after <= before:
            raise InputError(f"omega must increase for a rate, got {after!r} after {before!r}")
    if speeds.size < 2:
        raise InputError(f"omega must be two or more speeds for a rate, got {speeds.tolist()}")
    span = float(speeds[-1] - speeds[0]) / slope
    longest = MOST_RADIANS["compiled"] / max(float(speeds[-1]), 1.0)
    if span > longest:
        raise InputError(
            f"rate must be at least {slope * span / longest:.6g}, as a run would take hours, got "
            f"{slope!r}"
        )
    return slope


def _at_a_rate(
    swept: Callable[..., xr.Dataset],
    speeds: Values,
    rate: float,
    how: tuple[Options, int | None, str],
) -> Runs:
    """Return what runs through the speeds do, from where motions have settled at the first."""
    first = swept(omega=speeds[:1]).isel(direction=0, drop=True).drop_dims("event")
    due = np.flatnonzero(first["status"].values.ravel() == STATUS["done"])
    return run_through(first, _jobs(first, due), due, (speeds, rate), how)


def _with_extrema(
    settled: xr.Dataset, window: float, options: Options, workers: int | None, executor: str
) -> xr.Dataset:
    """Return what is kept of a sweep with the extrema of its points from the ends of their runs on.

    A point whose motion cannot be followed on has failed.
    """
    result = settled[list(OF_THE_SWEEP)].copy(deep=True)
    status, message = result["status"].values.ravel(), result["message"].values.ravel().tolist()
    due = np.flatnonzero(status == STATUS["done"])
    radii, kinds = [np.empty(0)] * status.size, [np.empty(0, np.int8)] * status.size
    place, count = choose(executor, workers, compiled=options.backend != "python")
    work = partial(_extrema, window=window, rtol=options.step_rtol)
    jobs = _jobs(settled, due)
    with closing(run_all(work, jobs, workers=count, executor=place)) as ended:
        for turn, found in ended:
            number = int(due[turn])
            if isinstance(found, Extrema):
                radii[number], kinds[number] = found.radii, found.kinds
            else:
                status[number], message[number] = STATUS["failed"], found.reason
    dims, shape = result["status"].dims, result["status"].shape
    counts = np.array([part.size for part in radii]).reshape(shape)
    result = result.assign(
        status=labelled("status", dims, status.reshape(shape)),
        message=labelled("message", dims, np.array(message).reshape(shape)),
        extremum_count=labelled("extremum_count", dims, counts),
        extremum_radius=labelled("extremum_radius", "extremum", np.concatenate(radii)),
        extremum_kind=labelled("extremum_kind", "extremum", np.concatenate(kinds)),
    )
    result["extremum_count"].attrs["sample_dimension"] = "extremum"
    return result


def _jobs(settled: xr.Dataset, numbers: npt.NDArray[np.intp]) -> Iterator[tuple[Rotor, State]]:
    """Yield rotor and end, on the rotating axes, of the points with these numbers."""
    status = settled["status"]
    of = {
        name: settled[name].broadcast_like(status).transpose(*status.dims).values.ravel()
        for name in ALL_PARAMETERS
        if name in settled.coords
    }
    ends = np.stack([settled[f"end_{name}"].values.ravel() for name in COMPONENTS], axis=-1)
    for number in numbers.tolist():
        rotor = Rotor(**{name: float(values[number]) for name, values in of.items()})
        x, y, vx, vy = ends[number].tolist()
        yield rotor, (x, y, vx, vy)


def _extrema(
    job: tuple[Rotor, State], stop: Stop, *, window: float, rtol: float
) -> Extrema | FailedJob:
    """Return the extrema of one motion, or why it cannot be followed."""
    rotor, start = job
    if stop[0]:
        return FailedJob("given up")
    try:
        return radius_extrema(rotor, start, window, rtol, stop)
    except SimulationError as error:
        return FailedJob(str(error))
