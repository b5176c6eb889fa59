"""Basins of attraction: over a plane of starts, and as fractions of random starts in a box."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins.attractors import Labelled, attractors_of, confirmed
from rotor_ida.basins.dataset import basin_dataset, fractions_dataset
from rotor_ida.basins.following import FORM, Starts, follow_starts
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.checks import (
    COMPONENTS,
    MOST_POINTS_OF_STUDY,
    check_between,
    check_count,
    check_increasing,
    check_instance,
    check_progress,
    check_seed,
    check_vector,
    is_scalar,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor, check_no_load
from rotor_ida.parallel import Progress, choose, interruptible
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies.results import open_results
from rotor_ida.simulation.options import LARGEST, Options, check_can_be_followed

# The errors of a step that may be asked for [1].
TIGHTEST, LOOSEST = 1e-12, 1e-4
# Stiffer rotors take the explicit method too many steps.
MOST_DAMPING = 20.0
MOST_CONTACT_DAMPING = 50.0
# Without a study all labels are in memory.
MOST_STARTS = 100_000_000


def basin(
    rotor: Rotor,
    *,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    rtol: float | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the attractor on which the rotor ends, for every start of a plane.

    Parameters
    ----------
    rotor : Rotor
        The rotor; damped, since without damping nothing settles.
    x, y, vx, vy : float or array_like, shape (n,)
        Components of the start [1]: exactly two are increasing arrays, two are numbers.
    rtol : float, optional
        Error allowed in a step, relative to the size of the state and of the eccentricity [1]; by
        default 1e-6, or 1e-11 where one of 512 starts ends elsewhere with that, for then the
        basins are finely folded. The attribute ``labelling_rtol`` says which.
    workers : int, optional
        How many batches of starts to follow at a time; by default one for each core that may be
        used.
    executor : {"auto", "serial", "threads", "processes", "dask"} or str
        What follows them, as for `rotor_ida.sweep`; ``"auto"`` means threads. The result is the
        same, bit for bit, on processors of one kind.
    study : path-like, optional
        Folder in which batches of starts are kept as they are done, as for `sweep`. With it, an
        interrupted basin can go on, and one with more starts than memory holds can be computed.
    progress : callable, optional
        Called with the number of starts done and their total.

    Returns
    -------
    Dataset
        On the two components that vary, the later one first, so that ``label.plot()`` draws y
        upwards: ``label``, the number of the attractor, -1 where the end
        is not known, -2 where it was not computed; ``response``, its kind as a flag;
        ``settling_time`` [1]. On ``attractor``: ``kind``, ``amplitude``, ``phase_lag``,
        ``radius_min``, ``radius_max`` (NaN where they depend on the start); ``trapping``, whether
        the region that holds starts is proven or estimated; ``confirmed``, whether CVODE has
        followed one of its starts to it; ``count``, ``fraction`` and ``fraction_error``. Scalars:
        ``undecided_count``, ``undecided_fraction``, ``not_computed_count``; ``agreement``, the part
        of the labels that come out the same with the error ``agreement_rtol`` in a step, of
        ``agreement_count`` that were found again; ``basin_entropy``, how uncertain the end of
        a start is within a small box, and ``boundary_entropy``, the same over the boxes in which
        starts end differently: on a fine grid more than log 2 says that the boundary is fractal.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If one of ``"processes"`` died, or the scheduler.

    Notes
    -----
    An interrupt from the keyboard ends it early: the starts that are not done are labelled as not
    computed, and the attribute ``interrupted`` is 1. So are starts whose workers of dask keep
    dying, with the attribute ``not_computed_reason``. Stable whirls in contact are listed even
    where no start ends on them. ``fraction_error`` is ``sqrt(p (1 - p)/n)``, the standard error
    that n random starts would have; the error of a grid, whose cells are wrong only along the
    borders of the basins, is smaller. ``settling_time`` is the time at which a region
    held the orbit, or else that at which the final window of an orbit followed alone ends.

    A label is proven only where the start itself lies in a region that is. Any other rests on the
    integration up to there, of which `agreement` is a sample. The attributes say what did what:
    ``labelling_method`` and ``labelling_rtol`` the labels, ``left_over_method`` and
    ``left_over_rtol`` the orbits that no region held, ``confirmation_method`` and so on what
    `confirmed` tells, if an interrupt did not prevent it.

    With friction starts are followed as for `rotor_ida.basin_fractions`.

    Examples
    --------
    >>> import numpy as np
    >>> axis = np.linspace(-15.0, 15.0, 24)
    >>> found = basin(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=axis, y=axis)
    >>> found.label.dims, found.amplitude.values.round(4)
    (('y', 'x'), array([1.8796, 9.4872]))
    >>> int(found["count"].sum()), int(found.undecided_count)
    (576, 0)
    """
    axes, fixed = _axes_of({"x": x, "y": y, "vx": vx, "vy": vy})
    (first, rows), (second, columns) = axes.items()
    places = [COMPONENTS.index(first), COMPONENTS.index(second)]

    def starts(begin: int, end: int) -> Values:
        """Return the starts with these numbers, row by row."""
        row, column = np.divmod(np.arange(begin, end), columns.size)
        states = np.empty((4, end - begin))
        for name, value in fixed.items():
            states[COMPONENTS.index(name)] = value
        states[places[0]], states[places[1]] = rows[row], columns[column]
        return states

    design = {"kind": "basin", **{name: values.tolist() for name, values in axes.items()}, **fixed}
    result = label(
        rotor, starts, rows.size * columns.size, design,
        rtol=rtol, workers=workers, executor=executor, study=study, progress=progress,
    )  # fmt: skip
    return basin_dataset(axes, fixed, result)


def basin_fractions(
    rotor: Rotor,
    *,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
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
    result = label(
        rotor, drawn, count, design,
        rtol=rtol, workers=workers, executor=executor, study=study, progress=progress, drawn=True,
    )  # fmt: skip
    attributes = {"starts": count, "seed": chosen}
    attributes |= {f"range_{name}": limits for name, limits in zip(COMPONENTS, box, strict=True)}
    return fractions_dataset(drawn, result, attributes)


def label(
    rotor: Rotor,
    starts: Starts,
    count: int,
    design: Mapping[str, object],
    *,
    rtol: object,
    workers: int | None,
    executor: str,
    study: str | os.PathLike[str] | None,
    progress: Progress | None,
    drawn: bool = False,
) -> Labelled:
    """Follow `count` starts of a rotor, each to its attractor.

    `starts` returns those from one number up to another, shape (4, n). Starts that are `drawn` do
    not depend on how many there are. `design` describes them for a study.
    """
    check_rotor(rotor, "fractions" if drawn else "a basin", one_by_one=drawn)
    most = MOST_STARTS if study is None else MOST_POINTS_OF_STUDY
    if count > most:
        raise InputError(f"starts must be at most {most}, got {count}: a study keeps more on disk")
    check_progress(progress)
    tolerance = None if rtol is None else check_between("rtol", rtol, TIGHTEST, LOOSEST)
    place, several = choose(executor, workers, compiled=True)
    options = Options()
    with open_results(study, {**design, **_design(rotor, tolerance, options)}, count, FORM) as kept:
        known = interruptible(lambda stop: known_from_closed_forms(rotor, stop))
        result = follow_starts(
            known, starts, count, kept,
            tolerance=tolerance, workers=several, executor=place, progress=progress, drawn=drawn,
        )  # fmt: skip
        attractors = attractors_of(result)
        if not result.interrupted:
            try:
                attractors = confirmed(result, attractors, starts, options)
            except KeyboardInterrupt:  # labels without confirmation are better than none
                if study is not None:
                    raise
                result.interrupted = True
        return Labelled(result, attractors, options, kept.folder)


def _design(rotor: Rotor, rtol: float | None, options: Options) -> dict[str, object]:
    """Return what decides on the bits of the labels beside the starts."""
    return {**rotor.given, "rtol": rtol, "confirmed_with_rtol": options.rtol, **computing()}


def check_rotor(rotor: object, what: str = "a basin", *, one_by_one: bool = False) -> Rotor:
    """Return a rotor whose starts can be labelled: under a load only where that is `one_by_one`."""
    rotor = check_instance("rotor", rotor, Rotor)
    if not one_by_one:
        check_no_load(rotor, what)
    if rotor.omega == 0.0 < min(rotor.load, rotor.friction):
        raise InputError(
            f"omega must be above 0 for {what} under a load with friction, which holds the rotor "
            "at many places, got 0.0"
        )
    check_can_be_followed(rotor, (0.0, 0.0, 0.0, 0.0), settling=True)
    if not 0.0 < rotor.zeta <= MOST_DAMPING:
        raise InputError(
            f"zeta must be above 0, where nothing settles, and at most {MOST_DAMPING:g} for "
            f"{what}, got {rotor.zeta!r}"
        )
    if rotor.contact_damping > MOST_CONTACT_DAMPING:
        raise InputError(
            f"contact_damping must be at most {MOST_CONTACT_DAMPING:g} for {what}, got "
            f"{rotor.contact_damping!r}"
        )
    return rotor


def _axes_of(given: dict[str, npt.ArrayLike]) -> tuple[dict[str, Values], dict[str, float]]:
    """Return the components that vary, and those that do not."""
    varying = [name for name, value in given.items() if not is_scalar(name, value)]
    if len(varying) != 2:
        raise InputError(
            "exactly two of x, y, vx, vy must be arrays and two numbers, got "
            f"{len(varying)} arrays{': ' if varying else ''}{', '.join(varying)}"
        )
    checked = {name: check_vector(name, value, largest=LARGEST) for name, value in given.items()}
    axes = {name: check_increasing(name, checked[name]) for name in varying}
    fixed = {name: values.item() for name, values in checked.items() if name not in axes}
    return axes, fixed


def drawn_from(box: Values, seed: int, first: int, last: int) -> Values:
    """Return the starts of a box with these numbers, shape (4, n), as if drawn all in one go."""
    bits = np.random.PCG64(seed)
    bits.advance(len(COMPONENTS) * first)
    chance = np.random.Generator(bits).random((last - first, len(COMPONENTS)))
    return np.asarray(box[:, :1] + (box[:, 1:] - box[:, :1]) * chance.T)


def box_of(ranges: Mapping[str, npt.ArrayLike], starts: int) -> Values:
    """Return the ends of the four ranges, shape (4, 2), from which `starts` are drawn."""
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
