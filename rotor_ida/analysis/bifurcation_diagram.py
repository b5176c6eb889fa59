"""What remains of the motion at each speed: the extrema of its radius, from many starts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Integral

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.analysis.extrema import Extrema, radius_extrema
from rotor_ida.checks import COMPONENTS, State, check_count, check_positive, check_seed
from rotor_ida.parallel import Stop, interruptible
from rotor_ida.parameters import PARAMETERS, Rotor
from rotor_ida.schema import STATUS, labelled
from rotor_ida.simulation.options import Options
from rotor_ida.sweeps.sweep import sweep

Values = npt.NDArray[np.float64]

DIMS = (*PARAMETERS, "start")
KEPT = ("response", "radius_min", "radius_max", "status", "message")


def bifurcation_diagram(
    *,
    omega: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    starts: int | Sequence[State] = 8,
    seed: int = 0,
    reach: float = 5.0,
    extrema_time: float = 100.0,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    workers: int | None = 1,
    executor: str = "auto",
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Return the extrema of the radius that remain at each speed, from many starts.

    Parameters
    ----------
    omega, zeta, delta0 : array_like, shape (n,) or scalar
        The parameters to combine [1].
    starts : int or sequence of tuple of float
        Number of random starts, or the starts ``(x, y, vx, vy)`` themselves [1]. Each speed has
        the same ones.
    seed : int
        Seed of the random starts.
    reach : float
        Random starts are drawn evenly from ``-reach`` to ``reach`` in each of x, y, vx, vy [1].
    extrema_time : float
        Length of the window, after the rotor has settled, in which extrema are looked for [1].
    rtol, atol : float
        Relative and absolute tolerance [1].
    workers, executor
        As for `rotor_ida.sweep`.
    progress : callable, optional
        Called with the number of points done and their total.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start)``: ``response`` (its kind, as a flag), ``radius_min``,
        ``radius_max``, ``status``, ``message``, as from `rotor_ida.sweep`, and
        ``extremum_count``. ``extremum_radius`` [1] and ``extremum_kind`` (minimum, maximum, or
        constant where the radius is) hold the extrema of all points in one table,
        ``extremum_count`` rows each.

    Raises
    ------
    InputError
        If an argument cannot be used. A point that fails does not raise: its ``status`` and
        ``message`` say why, and it has no extrema.

    Notes
    -----
    An extremum is a root of ``r r' = x vx + y vy``, found to about 1e-10 of the radius,
    or to 1e-8 where the rotor passes through the centre without clearance. On a
    synchronous whirl ``r r'`` vanishes throughout; its radius is given once. Periodic motions
    are few values, chaotic and quasi-periodic ones fill ranges.

    References
    ----------
    F. C. Moon, "Chaotic and Fractal Dynamics", Wiley, 1992, chapter 2.

    Examples
    --------
    >>> found = bifurcation_diagram(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> found.extremum_radius.values.round(8)
    array([0.84973087, 0.93446294])
    """
    window = check_positive("extrema_time", extrema_time)
    chosen = _starts(starts, seed, reach)
    swept = sweep(
        omega=omega, zeta=zeta, delta0=delta0, starts=chosen, rtol=rtol, atol=atol,
        workers=workers, executor=executor, progress=progress,
    )  # fmt: skip
    settled = swept.isel(direction=0, drop=True).drop_dims("event")
    options = Options(rtol=rtol, atol=atol)
    found = interruptible(
        lambda stop: [_extrema(settled, at, window, options, stop) for at in _indices(settled)]
    )
    counts = np.array([part.radii.size for part in found]).reshape(
        [settled.sizes[dim] for dim in DIMS]
    )
    result = settled[list(KEPT)].assign(
        extremum_count=labelled("extremum_count", DIMS, counts),
        extremum_radius=_column("extremum_radius", [part.radii for part in found]),
        extremum_kind=_column("extremum_kind", [part.kinds for part in found]),
    )
    result["extremum_count"].attrs["sample_dimension"] = "extremum"
    title = "Extrema of the radius over a range of speeds"
    told = {"title": title, "extrema_time": window}
    if isinstance(starts, Integral):
        told |= {"seed": seed, "reach": float(reach)}
    return result.assign_attrs(told)


def _starts(starts: int | Sequence[State], seed: object, reach: object) -> Sequence[State]:
    """Return the starts, drawn at random if only their number is given."""
    if not isinstance(starts, (int, Integral)):
        return starts
    count = check_count("starts", starts)
    farthest = check_positive("reach", reach)
    random = np.random.default_rng(check_seed(seed))
    return [tuple(row) for row in random.uniform(-farthest, farthest, (count, 4)).tolist()]


def _indices(settled: xr.Dataset) -> list[dict[str, int]]:
    shape = [settled.sizes[dim] for dim in DIMS]
    return [dict(zip(DIMS, index, strict=True)) for index in np.ndindex(*shape)]


def _extrema(
    settled: xr.Dataset, index: dict[str, int], window: float, options: Options, stop: Stop
) -> Extrema:
    """Return the extrema of one point from the end of its run on."""
    place = tuple(index.values())
    if settled["status"].values[place] == STATUS["failed"]:
        nothing = np.empty(0)
        return Extrema(nothing, nothing, nothing.astype(np.int8), np.empty((0, 4)))
    rotor = Rotor(**{name: float(settled[name].values[index[name]]) for name in DIMS[:3]})
    x, y, vx, vy = (float(settled[f"end_{name}"].values[place]) for name in COMPONENTS)
    return radius_extrema(rotor, (x, y, vx, vy), window, options.step_rtol, stop)


def _column(name: str, parts: list[npt.NDArray[np.generic]]) -> xr.Variable:
    return labelled(name, "extremum", np.concatenate(parts))
