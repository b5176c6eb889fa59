"""Basin fractions: how many of the random starts in a box end on each attractor."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins.dataset import fractions_dataset
from rotor_ida.basins.labelling import label
from rotor_ida.checks import (
    COMPONENTS,
    MOST_POINTS_OF_STUDY,
    check_count,
    check_seed,
    check_vector,
    is_scalar,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import Progress
from rotor_ida.simulation.options import LARGEST

Range = npt.ArrayLike


def basin_fractions(
    rotor: Rotor,
    *,
    x: Range,
    y: Range,
    vx: Range = 0.0,
    vy: Range = 0.0,
    starts: int = 10000,
    seed: int = 0,
    rtol: float | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the fractions of random starts in a box that end on each attractor.

    Parameters
    ----------
    rotor : Rotor
        The rotor; damped, since without damping nothing settles.
    x, y, vx, vy : float or array_like, shape (2,)
        Components of the start [1]: numbers, or ranges ``(low, high)`` from which they are drawn,
        independently and uniformly.
    starts : int
        Number of starts: at most 100 million, or 10 billion in a study.
    seed : int
        Seed of the random numbers: the same seed gives the same starts.
    rtol, workers, executor, study, progress
        As for `basin`.

    Returns
    -------
    Dataset
        On ``attractor`` what `basin` tells of each, with ``fraction`` and its standard error
        ``fraction_error``; on ``response`` the same for each kind of response: ``response_count``,
        ``response_fraction``, ``response_fraction_error``; the scalars of `basin`.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If one of ``"processes"`` died, or the scheduler.

    Notes
    -----
    The standard error of a fraction p of n starts is ``sqrt(p (1 - p)/n)``.

    Under a load, which turns on the axes on which starts are followed side by side, each is
    followed to its attractor by itself, as in `rotor_ida.sweep` by Taylor series with `rtol`, by
    default 1e-10: no region holds it, and no label is found again.

    With friction starts are followed side by side for as long as the disc slides forwards, up to a
    region of a whirl. The others are followed by themselves from the beginning on, with `rtol`
    1e-10, to limit cycles too, of which one that rolls is dry whip. What rolls without a period is
    one attractor together with all of its kind, as chaos is.

    Examples
    --------
    >>> found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-15, 15), y=(-15, 15),
    ...                starts=500)
    >>> found["count"].values
    array([ 65, 435])
    """
    given = {"x": x, "y": y, "vx": vx, "vy": vy}
    box = np.array([range_of(name, given[name]) for name in COMPONENTS])
    count = check_count("starts", starts, maximum=MOST_POINTS_OF_STUDY)
    chosen = check_seed(seed)

    def drawn(first: int, last: int) -> Values:
        return drawn_from(box, chosen, first, last)

    ranges = {name: limits.tolist() for name, limits in zip(COMPONENTS, box, strict=True)}
    design = {"kind": "basin_fractions", "starts": count, "seed": chosen, **ranges}
    found = label(
        rotor, drawn, count, design,
        rtol=rtol, workers=workers, executor=executor, study=study, progress=progress, drawn=True,
    )  # fmt: skip
    attributes = {"starts": count, "seed": chosen}
    attributes |= {f"range_{name}": limits for name, limits in zip(COMPONENTS, box, strict=True)}
    return fractions_dataset(drawn, found, attributes)


def drawn_from(box: Values, seed: int, first: int, last: int) -> Values:
    """Return the starts of a box with these numbers, shape (4, n), as if drawn all in one go."""
    bits = np.random.PCG64(seed)
    bits.advance(len(COMPONENTS) * first)
    chance = np.random.Generator(bits).random((last - first, len(COMPONENTS)))
    return np.asarray(box[:, :1] + (box[:, 1:] - box[:, :1]) * chance.T)


def box_of(ranges: Mapping[str, npt.ArrayLike], starts: int) -> Values:
    """Return the ends of the ranges of so many starts, shape (4, 2)."""
    box = np.array([range_of(name, ranges[name]) for name in COMPONENTS])
    if starts > 1 and (box[:, 0] == box[:, 1]).all():
        raise InputError(f"x, y, vx or vy must be a range, got numbers for {starts} starts")
    return box


def range_of(name: str, value: object) -> tuple[float, float]:
    """Return the ends of a range; a number is a range of no length."""
    ends = check_vector(name, value, largest=LARGEST).tolist()
    if len(ends) > 2 or (len(ends) == 1 and not is_scalar(name, value)):
        raise InputError(f"{name} must be a number or a range (low, high), got {shown(value)}")
    low, high = ends[0], ends[-1]
    if low > high:
        raise InputError(f"{name} must be a range (low, high) with low <= high, got {shown(value)}")
    return low, high
