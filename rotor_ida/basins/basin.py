"""Basins of attraction: over a plane of starts, and as fractions of random starts in a box."""

from __future__ import annotations

import os
from typing import Any, Unpack

import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop
from rotor_ida.basins.attractors import confirm, witness_options
from rotor_ida.basins.dataset import Labelled, basin_dataset, fractions_dataset
from rotor_ida.basins.disc import labeller_of
from rotor_ida.basins.following import FORM, Labeller, follow_starts
from rotor_ida.basins.starts import Box, Plane, check_number_of_starts
from rotor_ida.basins.subjects import one_rotor, subjects_of
from rotor_ida.checks import check_progress
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, choose, interruptible, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import open_results
from rotor_ida.simulation.starts import Start


@takes_rotors(system=("node", "start", "modes"), needed=("speed", "node"))
@shows_progress
def basin(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    speed: float | None = None,
    node: str | None = None,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    rtol: float | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute basins of attraction on a plane of initial states.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. It must be damped: without damping there are no attractors. For a
        `DimensionalRotor` starts and results are in SI units. A `RotorSystem` has a contact, and
        units of its own.
    speed, node : float, str
        Spin speed of a `RotorSystem`, not 0, and the node whose displacement and velocity vary.
    x, y, vx, vy : float or array_like, shape (n,)
        Components of the start [dimensionless], or displacement and velocity of the node of a
        `RotorSystem`: exactly two are increasing arrays, two are numbers.
    start : (q, velocity), "settled", "rest", None or Dataset, optional
        The state of a `RotorSystem`, as in `simulate`, to which that of the node is added; by
        default at rest at 0. The notes say how the other nodes follow.
    modes : int, optional
        Modes of a `RotorSystem`, as in `simulate`.
    rtol : float, optional
        Error allowed per step, relative to the size of the state and of the eccentricity
        [dimensionless]. By default 1e-6, or 1e-11 if the two disagree on any of 512 starts: then
        the basins are finely folded. The attribute ``labelling_rtol`` reports the value used. Of a
        `RotorSystem` the relative tolerance of runs, by default 1e-10.
    workers : int, optional
        Number of batches followed at a time; by default one per available core.
    executor : {"auto", "serial", "threads", "processes", "dask"} or str
        How batches are run, as for `rotor_ida.sweep`; ``"auto"`` means threads. On processors of
        one kind the result is identical bit for bit.
    study : path-like, optional
        Folder in which finished batches of starts are stored, as for `sweep`. An interrupted
        computation can then be resumed, and the starts need not fit into memory.
    progress : callable or bool, optional
        Called with the number of starts done and their total; True shows a bar on standard error.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On the two components that vary, the later one first, so that ``label.plot()`` draws y
        upwards: ``label``, the number of the attractor, -1 where undecided, -2 where not computed;
        ``response``, its kind as a flag; ``settling_time`` [dimensionless]. On ``attractor``:
        ``kind``, ``amplitude``, ``phase_lag``, ``radius_min``, ``radius_max`` (NaN where they
        depend on the start); ``trapping``, whether its trapping region is proven or estimated;
        ``confirmed``, whether a run by the method ``confirmation_method``, CVODE where it is there,
        leads from one of its starts to it; ``count``, ``fraction``
        and ``fraction_error``. Scalars: ``undecided_count``, ``undecided_fraction``,
        ``not_computed_count``; ``agreement``, the fraction of ``agreement_count`` recomputed labels
        that are unchanged with the error ``agreement_rtol`` per step; ``basin_entropy``, the
        uncertainty of the attractor within a small box, and ``boundary_entropy``, the same over
        boxes with more than one attractor. On a fine grid a boundary entropy above log 2 shows that
        the boundary is fractal. A `RotorSystem` has no ``trapping``, ``confirmed`` and
        ``lifetime``; ``amplitude``, ``phase_lag``, ``radius_min``, ``radius_max``,
        ``largest_force`` and ``touched`` are on ``(attractor, contact)``, ``node_amplitude``,
        ``node_phase_lag``, ``node_radius_min`` and ``node_radius_max`` on ``(attractor, node)``,
        and ``final_state``, a start of `simulate` or `limit_cycle`, on ``component``.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If a worker process or the scheduler died.

    Notes
    -----
    A keyboard interrupt ends the computation early: the remaining starts are labelled as not
    computed, and the attribute ``interrupted`` is 1. Starts whose dask workers keep dying are
    labelled likewise, with the attribute ``not_computed_reason``. Stable whirls in contact are
    listed even if no start ends on them. ``fraction_error`` is ``sqrt(p (1 - p)/n)``, the standard
    error for n random starts; the error of a grid is smaller, since its cells are wrong only along
    basin boundaries. ``settling_time`` is the time at which the orbit entered a region; for an
    orbit followed alone it is the end of its final window.

    A label is proven only if the start itself lies in a proven region. Any other depends on the
    integration up to a region, which `agreement` tests on a sample. Attributes give the methods:
    ``labelling_method`` and ``labelling_rtol`` for the labels, ``left_over_method`` and
    ``left_over_rtol`` for the orbits that entered no region, ``confirmation_method`` and so on for
    `confirmed`, unless an interrupt prevented it.

    With friction, starts are followed as for `rotor_ida.basin_fractions`.

    A node of a `RotorSystem` that is pulled aside and let go takes the rotor with it: the
    displacement of the `start` changes by the static deflection under a force at the node, the
    shape with the least elastic energy. Where motions cost none, as those of a rotor without
    supports, it is the shape of these that moves the least mass. The velocity changes as by a blow
    at the node, the change with the least kinetic energy. Stators and races start as they do in
    `start`. Contacts do not change these shapes, so that another node may start beyond its
    clearance.

    Every start of a `RotorSystem` is followed as by `sweep`. Two motions are on one attractor if
    they are of one kind, and period, radii and, at whole revolutions, state agree to a part of
    1e-5; on rotating axes, of an axisymmetric system, period and radii decide. All contact-free
    motions count as one attractor, as do all chaotic ones, all tori, and all rolling motions
    without a period of the same contacts. Only attractors that starts end on are listed.

    Examples
    --------
    >>> import numpy as np
    >>> axis = np.linspace(-15.0, 15.0, 24)
    >>> found = basin(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=axis, y=axis)
    >>> found.label.dims, found.amplitude.values.round(4)
    (('y', 'x'), array([1.8796, 9.4872]))
    >>> int(found["count"].sum()), int(found.undecided_count)
    (576, 0)

    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=1.5, shaft_stiffness=0.1).system()
    >>> found = basin(system, speed=0.7, node="disc", x=[-1.0, -0.5], y=[-1.5, -1.0])
    >>> found.label.values.tolist(), found.amplitude.values.ravel().round(3).tolist()
    ([[0, 1], [0, 0]], [2.735, 1.183])
    """
    plane = Plane.of(x=x, y=y, vx=vx, vy=vy)
    if isinstance(rotor, RotorSystem):
        rotor = changed_system(basin, rotor, changed)
    result = label(
        rotor, plane, speed=speed, node=node, start=start, modes=modes, rtol=rtol, workers=workers,
        executor=executor, study=study, progress=progress,
    )  # fmt: skip
    return basin_dataset(plane, result)


@takes_rotors(
    system=("node", "start", "modes"), needed=("speed", "node"), defaults={"starts": (10000, 1000)}
)
@shows_progress
def basin_fractions(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    speed: float | None = None,
    node: str | None = None,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    starts: int | None = None,
    seed: int = 0,
    start: Start | xr.Dataset = None,
    modes: int | None = None,
    rtol: float | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute basin fractions: the fraction of random starts in a box that reach each attractor.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. It must be damped: without damping there are no attractors. For a
        `DimensionalRotor` starts and results are in SI units.
    speed, node
        Of a `RotorSystem`, as for `basin`.
    x, y, vx, vy : float or array_like, shape (2,)
        Components of the start [dimensionless], or states of the node: numbers, or ranges ``(low,
        high)`` from which they are drawn independently and uniformly.
    starts : int
        Number of starts, by default 10,000 and of a `RotorSystem` 1,000: at most 100 million, or 10
        billion in a study.
    seed : int
        Seed of the random numbers: the same seed gives the same starts.
    start, modes, rtol, workers, executor, study, progress
        As for `basin`.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``attractor`` the variables of `basin`, with ``fraction`` and its standard error
        ``fraction_error``; on ``response`` the same for each kind of response: ``response_count``,
        ``response_fraction``, ``response_fraction_error``; the scalars of `basin`.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If a worker process or the scheduler died.

    Notes
    -----
    The standard error of a fraction p of n starts is ``sqrt(p (1 - p)/n)``.

    Under a load, which rotates on the rotating axes, there is no synchronous whirl. Starts are
    followed side by side until they enter the region of a limit cycle that is known, at the end of
    a revolution, or of a whirl about its sagging position. The others are followed separately, as
    with friction.

    With friction, starts are followed side by side to a region of a whirl while the disc slides
    forwards. The others are followed separately from their beginning, with `rtol` 1e-10, also to
    limit cycles; a rolling limit cycle is dry whip. All rolling motions without a period count as
    one attractor, as chaos does.

    Examples
    --------
    >>> found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-15, 15), y=(-15, 15),
    ...                starts=500)
    >>> found["count"].values
    array([ 65, 435])

    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=1.5, shaft_stiffness=0.1).system()
    >>> found = basin_fractions(system, speed=0.7, node="disc", x=(-1.5, 0), y=(-2, -1), starts=8)
    >>> found["count"].values
    array([6, 2])
    """
    box = Box.of(starts, seed, x=x, y=y, vx=vx, vy=vy)
    if isinstance(rotor, RotorSystem):
        rotor = changed_system(basin_fractions, rotor, changed)
    result = label(
        rotor, box, speed=speed, node=node, start=start, modes=modes, rtol=rtol, workers=workers,
        executor=executor, study=study, progress=progress,
    )  # fmt: skip
    return fractions_dataset(box, result)


def label(
    rotor: Rotor | DimensionalRotor | RotorSystem, asked: Plane | Box, *, speed: object,
    workers: int | None, executor: str, study: str | os.PathLike[str] | None,
    progress: Progress | bool | None, **given: Any,
) -> Labelled:  # fmt: skip
    """Follow starts of a rotor, or of a node of a rotor system, each to its attractor."""
    drawn = isinstance(asked, Box)
    what = "fractions" if drawn else "a basin"
    subjects = subjects_of(one_rotor(rotor, speed), what, loaded=True, **given)
    (point,) = subjects.points
    progress, chosen = check_progress(progress), choose(executor, workers, compiled=True)
    check_number_of_starts(asked.count, study)
    question = Question(
        asked.verb, {"rotor": rotor, **subjects.given, **asked.given, "rtol": subjects.rtol}
    )
    with open_results(study, question.design, asked.count, FORM) as kept:

        def prepared(stop: Stop) -> Labeller:
            labeller = labeller_of(point, subjects.rtol, stop)
            if kept.points_done == asked.count:  # nothing is left to follow
                return labeller
            return labeller.scouted(asked.starts, asked.count, drawn=drawn, stop=stop)

        followed = follow_starts(
            interruptible(prepared), asked.starts, asked.count, kept, workers=chosen,
            progress=progress,
        )  # fmt: skip
        options = None
        if isinstance(point, Rotor) and not followed.ended.interrupted:
            options = witness_options()
            confirm(point, followed, asked.starts, options, can_stop=study is None)
        return Labelled(subjects, followed, options, kept.folder, question)
