"""Lyapunov exponents, of one motion or at each point."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import (
    check_choice,
    check_count,
    check_duration,
    check_positive,
    check_progress,
    is_scalar,
    shown,
)
from rotor_ida.core import sundials
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import AnyAxes, SystemAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, choose, interruptible, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.si_units import with_system_units
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import labelled_dataset
from rotor_ida.simulation.lyapunov import (
    BATCHES,
    FEWEST_BATCHES,
    FEWEST_SPANS,
    LONGEST,
    METHODS_OF_TANGENTS,
    SPAN,
    MethodOfTangents,
    divergence_of,
    means_of,
    means_of_rates,
    stretches_of,
)
from rotor_ida.simulation.options import check_can_be_followed, check_rtol, passes_soon
from rotor_ida.simulation.starts import Start, given_start, start_of
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady.grid import answers_at_each
from rotor_ida.steady.points import (
    Turning,
    Turnings,
    VariedSystem,
    started,
    state_of_start,
    turning_speeds,
    with_meanings,
)

# Revolutions of a system at most: each keeps one number for each exponent in memory.
MOST_REVOLUTIONS = 1_000_000
# Points of the running mean, for a figure.
POINTS_SHOWN = 400
OF_EXPONENTS = ("lyapunov_exponent", "lyapunov_error")
OF_DISC = ("exponent_sum", "divergence")


class Exponents(NamedTuple):
    """The exponents of one motion.

    Parameters
    ----------
    columns : mapping of str to float or ndarray
        The numbers of a result, exponents the largest first.
    running : ndarray, shape (t, exponent)
        Plain means so far.
    spans : ndarray of int, shape (t,)
        After how many spans.
    """

    columns: Mapping[str, Any]
    running: Values
    spans: npt.NDArray[np.int64]


def ordered(rates: Values, exponents: Values, errors: Values, **numbers: float) -> Exponents:
    """Return exponents by the rates over each span, shape (n, exponent), the largest first."""
    order, count = np.argsort(-exponents, kind="stable"), len(rates)
    spans = np.unique(np.linspace(1, count, min(POINTS_SHOWN, count)).astype(int))
    running = np.cumsum(rates, axis=0)[spans - 1] / spans[:, np.newaxis]
    values = (exponents[order], errors[order])
    columns = dict(zip(OF_EXPONENTS, values, strict=True)) | numbers
    return Exponents(columns, running[:, order], spans)


@takes_rotors(
    disc=("duration", "method"), system=("exponents", "revolutions", "modes"), varies=True
)
@shows_progress
def lyapunov_exponent(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    start: Start = None,
    transient: float | None = None,
    duration: float = 5000.0,
    revolutions: int = 2000,
    batches: int = BATCHES,
    exponents: int | None = None,
    modes: int | None = None,
    rtol: float = 1e-10,
    method: MethodOfTangents = "taylor",
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Compute the Lyapunov exponents of the motion from a start, at each given parameter.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given. For a
        `DimensionalRotor` numbers with a unit are in SI units, as for `simulate`.
    speed : float or array_like, shape (n,)
        Spin speeds of a `RotorSystem`, not 0. Those of a `DimensionalRotor` are a parameter of it.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [dimensionless], by default at rest; of a `RotorSystem`
        displacements and velocities, as in `simulate`. Or a word, for the start of each rotor, or a
        result that ends in a state.
    transient : float, optional
        Time to settle before averaging [dimensionless], at most 5 million, by default 500. Of a
        `RotorSystem` the number of revolutions, by default 200. Small changes align in it too.
    duration : float
        Time over which to average [dimensionless], at least 10 for each batch, at most 5 million.
    revolutions : int
        The same of a `RotorSystem` in revolutions, at least 20 for each batch, at most a million.
    batches : int
        Number of parts of `duration`, at least 4, whose scatter gives the error.
    exponents : int, optional
        Number of exponents of a `RotorSystem`, the largest first; default: all, one for each
        displacement, velocity and speed of a race. One disc has four.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    rtol : float
        Tolerance of one step, relative to the size of the state and of each small change
        [dimensionless].
    method : {"taylor", "adams", "bdf"}
        Solver for motion and small changes of one disc in contact: Taylor series, or CVODE, which
        is slower and an independent check.
    workers, executor, study, progress
        As in `sweep`, for the points. Of one motion of a `RotorSystem` `progress` is called with
        the number of revolutions done and their total.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`. Each array
        becomes a dimension of the result, before ``exponent``, with each value once; all are
        combined.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as in `sweep`; each array becomes a dimension too.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        ``lyapunov_exponent`` and ``lyapunov_error`` on ``exponent``, the largest first
        [dimensionless]. Of one disc also their sum ``exponent_sum`` and its exact value, the
        ``divergence`` of the flow including the volume lost in reversals of sliding. Of one motion
        also ``running_exponent`` on ``t`` and ``exponent``, the plain mean so far; of several
        ``status`` and ``message``.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the integration is stuck. One of several points does not raise: its ``message`` gives the
        reason.

    Notes
    -----
    On the rotating axes the motion is autonomous, with state s = (Z, W). The variational
    equation ``M' = J(s) M`` is integrated along the orbit; no neighbouring orbit is used. J is
    continuous, as the slope of the Hertz force grows from 0 like ``indentation**0.5``: M
    passes entries and exits without a jump (no saltation). Every half unit of time M is made
    orthonormal by Gram-Schmidt; the mean growth rates of its columns are the exponents.

    With friction M jumps, as the tangential force does, where the disc begins to roll or reverses
    its sliding; there M is multiplied by a saltation matrix. Rolling removes a dimension: for a
    motion that rolls repeatedly the last exponent is minus infinity. In a system with stators
    without mass changes are differences of runs, known to about 1e-7.

    The mean is weighted by ``exp(-1/(u (1 - u)))``, with u from 0 to 1 along `duration`. On a
    periodic or quasi-periodic motion it converges faster than any power of the time, whereas a
    plain mean is off by its last unfinished oscillation. On a chaotic motion it is like any
    other mean. Each batch gives such a mean too. The error is the standard deviation of the batches
    over the square root of their number, enlarged where neighbouring batches are correlated, or
    the difference of their mean from that of `duration`, if that is larger. The difference between
    the sum of the exponents and the divergence is added. The error does not cover a transient that
    was too short.

    Independent checks: the four exponents add up to the divergence of the flow, ``-4 zeta``, and
    the first and the last, like the two between them, to ``-2 zeta``. (This does not hold with
    contact damping, where the divergence varies along the orbit and NaN is reported, nor with
    friction, where each reversal adds ``ln((|F| - mu N)/(|F| + mu N))``.) Without a load, any
    motion but a synchronous whirl has one zero exponent, that of a shift in time. On a
    synchronous whirl the exponents are the real parts of its eigenvalues. A chaotic motion may be
    a long transient: a run that leaves it half way shows a large error.

    The small changes of a `RotorSystem` are made orthonormal after each revolution; the means of
    their growth, and the errors, are those of one disc. In an axisymmetric system one exponent of a
    motion other than a whirl at the spin speed is 0, that of a shift in time. An exponent is minus
    infinity where a contact rolls in every revolution, as rolling leaves no slip, and where a
    change shrinks below 1e-12 in a revolution.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, "Lyapunov characteristic exponents
    for smooth dynamical systems", Meccanica 15, 1980.
    S. Das, Y. Saiki, E. Sander, J. A. Yorke, "Quantitative quasiperiodicity", Nonlinearity 30,
    2017: the weights.
    U. Dressler, "Symmetry property of the Lyapunov spectra of a class of dissipative dynamical
    systems with viscous damping", Physical Review A 38, 1988: the pairs.
    P. C. Müller, Chaos, Solitons & Fractals 5, 1995: the jump at discontinuities.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                           duration=1000.0)
    >>> found.lyapunov_exponent.values.round(5)
    array([-0.07, -0.07, -0.07, -0.07])
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    >>> over = lyapunov_exponent(rotor, zeta=[0.07, 0.1], duration=1000.0)
    >>> over.lyapunov_exponent.dims, over.lyapunov_exponent.sel(exponent=0).values.round(5)
    (('zeta', 'exponent'), array([-0.07, -0.1 ]))

    The same disc as a system has other coordinates, and the same exponents:

    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> found = lyapunov_exponent(system, speed=1.7, transient=20, revolutions=80, batches=4)
    >>> found.lyapunov_exponent.values.round(3)
    array([-0.07, -0.07, -0.07, -0.07])
    """
    reports, chosen = check_progress(progress), choose(executor, workers, compiled=True)
    parts = check_count("batches", batches, FEWEST_BATCHES)
    if isinstance(rotor, RotorSystem):
        case = _case_of_system(
            rotor, varied, speed, start, 200 if transient is None else transient, revolutions,
            parts, exponents, modes, rtol,
        )  # fmt: skip
    else:
        asked = varied_of(lyapunov_exponent, rotor, varied, always=())
        case = _case_of_disc(
            asked, start, 500.0 if transient is None else transient, duration, parts, rtol, method
        )
    if case.varied.axes:
        return _dataset(case, _at_each(case, workers=chosen, study=study, progress=reports))
    if study is not None:
        raise InputError(f"study must be left out of one motion, got {shown(study)}")
    found = _of_one(case, reports)
    variables: dict[str, Column] = {
        name: ("exponent" if np.ndim(each) else (), each) for name, each in found.columns.items()
    }
    variables["running_exponent"] = ("t", "exponent"), found.running
    return _dataset(case, variables, t=("t", case.run.span * found.spans))


class Run(NamedTuple):
    """How small changes of a motion are followed, over spans after which they are orthonormal.

    `lead` spans come before the mean, over `each` in every batch. `done` gets the numbers of
    revolutions of one motion as they pass.
    """

    start: Any
    exponents: int
    lead: int
    batches: int
    each: int
    span: float
    rtol: float
    method: MethodOfTangents = "taylor"
    done: list[int] | None = None

    @property
    def total(self) -> int:
        """Number of all spans."""
        return self.lead + self.batches * self.each


class Case(NamedTuple):
    """The exponents that are asked for, at each point of `varied`."""

    varied: Varied
    point_at: Callable[[Sequence[int]], Any]
    run: Run
    question: Question
    attributes: dict[str, Any]


# ---- Of one disc ----


def _case_of_disc(
    asked: Varied, start: object, transient: object, duration: object, batches: int, rtol: float,
    method: MethodOfTangents,
) -> Case:  # fmt: skip
    """Return what is asked of one disc, checked."""
    first = given_start("start", start, loaded=bool(asked.values("load").any()))
    if isinstance(first, str) and not asked.dims:
        first = start_of(asked.rotor(()), first)
    for each in asked.extremes():
        check_can_be_followed(each, start_of(each, first))
    lead = check_positive("transient", transient, LONGEST)
    length = check_positive("duration", duration, LONGEST)
    check_duration("transient + duration", lead + length, float(asked.values("omega").max()))
    each_batch = int(length / (batches * SPAN))
    if each_batch < FEWEST_SPANS:
        raise InputError(
            "{name} must be at least {least:g} for each of {count} batches, got {value}",
            name="duration", least=FEWEST_SPANS * SPAN, count=batches, value=length,
        )  # fmt: skip
    check_choice("method", method, METHODS_OF_TANGENTS)
    if method != "taylor" and (reason := sundials.why_not()):
        raise InputError(f"CVODE with tangents cannot be used: {reason}")
    span = length / (batches * each_batch)
    run = Run(first, 4, math.ceil(lead / span), batches, each_batch, span,
              check_rtol(method, rtol), method)  # fmt: skip
    told = {"transient": lead, "duration": length, "batches": batches}
    given = {"start": first, **told, "rtol": run.rtol, "method": method}
    how = provenance({"method": method, "flight": "exact", "rtol": run.rtol})
    return Case(
        asked, asked.rotor, run,
        Question("lyapunov_exponent", {**asked.design, **given}),
        how | {"start": first if isinstance(first, str) else np.array(first)} | told,
    )  # fmt: skip


# ---- Of a rotor system ----


def _case_of_system(
    system: RotorSystem, changed: SystemAxes, speed: object, start: Any, transient: object,
    revolutions: object, batches: int, exponents: int | None, modes: int | None, rtol: float,
) -> Case:  # fmt: skip
    """Return what is asked of a rotor system, checked."""
    speeds = turning_speeds(speed, "for the exponents of a rotor system")
    here = speeds[0] if is_scalar("speed", speed) else speeds
    asked = varied_system_of(lyapunov_exponent, system, changed, here)
    taken = VariedSystem.of(asked, [start], modes, rtol, "start")
    lead = math.ceil(check_positive("transient", transient, MOST_REVOLUTIONS))
    each = int(check_positive("revolutions", revolutions, MOST_REVOLUTIONS)) // batches
    if each < FEWEST_SPANS:
        raise InputError(
            f"revolutions must be at least {FEWEST_SPANS} for each of {batches} batches, "
            f"got {shown(revolutions)}"
        )
    varied, (first,) = taken.varied, taken.starts
    tolerance, turnings = taken.rtol, Turnings(varied, taken.rtol)
    size = state_of_start(turnings.checked(), first, float(speeds[0])).size
    count = size if exponents is None else check_count("exponents", exponents, 1)
    if count > size:
        raise InputError(f"exponents must be at most {size}, got {shown(exponents)}")
    revolution = 2.0 * math.pi / abs(float(speeds[0]))
    done = None if varied.axes else list[int]()
    run = Run(first, count, lead, batches, each, revolution, tolerance, done=done)
    question = Question("lyapunov_exponent", {
        "rotor": asked.base, **varied.design, "start": taken.kept[0], "modes": modes,
        "exponents": count, "transient": lead, "revolutions": batches * each, "batches": batches,
        "rtol": tolerance,
    })  # fmt: skip
    attributes = provenance({"method": "taylor", "rtol": tolerance}) | {"batches": batches}
    if speeds.size == 1:
        of_time = {"transient": lead, "duration": batches * each}
        attributes |= {name: revolution * turns for name, turns in of_time.items()}
    else:
        attributes |= {"transient_revolutions": lead, "revolutions": batches * each}
    return Case(varied, turnings.at, run, question, attributes)


# ---- Of any rotor ----


def exponents_at(run: Run, point: Rotor | Turning, stop: Stop) -> Exponents:
    """Return the largest exponents of the motion of a rotor."""
    if not isinstance(point, Rotor):
        flow = SystemFlow.at(*point, stop)
        state = started(point, run.start) / flow.scales
        rates = flow.growth(state, run.exponents, run.total, run.done)[run.lead :]
        return ordered(rates, *means_of_rates(rates, run.batches))
    rates = stretches_of(
        point, start_of(point, run.start), run.lead, run.batches * run.each, run.span, run.rtol,
        stop, run.method,
    ) / run.span  # fmt: skip
    exponents, errors, divergence = means_of(rates, run.batches, divergence_of(point))
    total = float(exponents.sum())
    return ordered(rates[:, :4], exponents, errors, exponent_sum=total, divergence=divergence)


def _at_each(case: Case, **jobs: Any) -> dict[str, xr.Variable]:
    """Return the exponents at each point."""
    numbers = OF_DISC if case.varied.system is None else ()
    behind: dict[str, tuple[str, int] | None] = {
        **dict.fromkeys(OF_EXPONENTS, ("exponent", case.run.exponents)), **dict.fromkeys(numbers)
    }  # fmt: skip
    work = partial(_columns, case.run)
    return answers_at_each(case.varied, case.point_at, work, behind, case.question, **jobs)


def _columns(run: Run, point: Rotor | Turning, stop: Stop) -> Mapping[str, Any]:
    """Return the columns of a point."""
    return exponents_at(run, point, stop).columns


def _of_one(case: Case, progress: Progress | None) -> Exponents:
    """Return the exponents of the one motion, and report how much of it is done."""
    point, run = case.point_at(()), case.run
    total = 1 if run.done is None else run.total

    def tell(progress: Progress) -> None:
        progress(len(run.done or ()), total)

    told = progress and partial(tell, progress)
    soon = isinstance(point, Rotor) and passes_soon(
        point, start_of(point, run.start), run.total * run.span, run.method
    )
    found = interruptible(lambda stop: exponents_at(run, point, stop), told=told, at_once=soon)
    if progress is not None:
        progress(total, total)
    return found


def _dataset(
    case: Case, variables: Mapping[str, Column | xr.Variable], **coordinates: Column
) -> xr.Dataset:
    """Return exponents as a labelled dataset."""
    points, numbers = case.varied, np.arange(case.run.exponents)
    over = "over a range of parameters" if points.axes else "of one motion"
    title = f"Lyapunov exponents {over}{'' if points.system is None else ' of a rotor system'}"
    dataset = labelled_dataset(
        title, variables, {**points.coordinates, "exponent": ("exponent", numbers), **coordinates},
        {**case.attributes, **case.question.attribute()}, kind="lyapunov_exponent",
    )  # fmt: skip
    if points.system is None:
        return dataset
    return with_meanings(with_system_units(dataset, points.base), points)
