"""Lyapunov exponents, of one motion or at each point: of one disc, and of rotor systems."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import (
    AT_REST,
    check_between,
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
from rotor_ida.model.assembly import assemble
from rotor_ida.model.disc_starts import begun
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SystemAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, Workers, choose, interruptible, shows_progress
from rotor_ida.results.in_si import varies_in_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.results.system_units import with_system_units
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
from rotor_ida.simulation.options import check_can_be_followed, check_rtol
from rotor_ida.simulation.starts import GivenStart, given_start
from rotor_ida.simulation.starts import Start as DiscStart
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.simulation.systems.simulate import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.simulation.systems.starts import Start, state_at_end
from rotor_ida.steady.each_point import answers_at_each
from rotor_ida.steady.system_sweep import (
    Turning,
    Turnings,
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


@varies_in_si
@shows_progress
def lyapunov_exponent(
    rotor: Rotor | DimensionalRotor | None = None,
    *,
    start: DiscStart = AT_REST,
    transient: float = 500.0,
    duration: float = 5000.0,
    batches: int = BATCHES,
    rtol: float = 1e-10,
    method: MethodOfTangents = "taylor",
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the four Lyapunov exponents of the motion from a start, at each given parameter.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given. For a
        `DimensionalRotor` numbers with a unit are in SI units, as for `simulate`.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1]; default: at rest on the axis. Or a word, for the start of
        each rotor, or a result that ends in a state, as for `rotor_ida.simulate`.
    transient : float
        Time to settle before averaging [1], at most 5 million; the tangent vectors align in it
        too.
    duration : float
        Time over which to average [1], at least 10 for each batch, at most 5 million.
    batches : int
        Number of parts of `duration`, at least 4, whose scatter gives the error.
    rtol : float
        Tolerance of one step, relative to the size of the state and of each tangent vector [1].
    method : {"taylor", "adams", "bdf"}
        Solver for motion and tangent vectors in contact: Taylor series, or CVODE, which is slower
        and an independent check.
    workers, executor, study, progress
        As in `sweep`, for the points.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], in place of those of `rotor`. Each array becomes a
        dimension of the result, before ``exponent``, with each value once; all are combined.

    Returns
    -------
    Dataset
        ``lyapunov_exponent`` and ``lyapunov_error`` on ``exponent``, the largest first [1];
        their sum ``exponent_sum`` and its exact value, the ``divergence`` of the flow including
        the volume lost in reversals of sliding. Of one motion also ``running_exponent`` on ``t``
        and ``exponent``, the plain mean so far; of several ``status`` and ``message``.

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
    motion that rolls repeatedly the last exponent is minus infinity.

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
    """
    asked = varied_of(lyapunov_exponent, rotor, varied, always=())
    first = given_start("start", start, loaded=bool(asked.values("load").any()))
    if not asked.dims:
        first = begun(first, asked.rotor(()))
    for each in asked.extremes():
        check_can_be_followed(each, begun(first, each))
    lead = check_positive("transient", transient, LONGEST)
    length = check_positive("duration", duration, LONGEST)
    check_duration("transient + duration", lead + length, float(asked.values("omega").max()))
    count = check_count("batches", batches, FEWEST_BATCHES)
    each_batch = int(length / (count * SPAN))
    if each_batch < FEWEST_SPANS:
        raise InputError(
            "{name} must be at least {least:g} for each of {count} batches, got {value}",
            name="duration", least=FEWEST_SPANS * SPAN, count=count, value=length,
        )  # fmt: skip
    check_choice("method", method, METHODS_OF_TANGENTS)
    if method != "taylor" and (reason := sundials.why_not()):
        raise InputError(f"CVODE with tangents cannot be used: {reason}")
    span = length / (count * each_batch)
    run = DiscRun(
        first, span, math.ceil(lead / span), count, each_batch, check_rtol(method, rtol), method
    )
    how = {"method": method, "flight": "exact", "rtol": run.rtol}
    told = {"transient": lead, "duration": length, "batches": count}
    given = {"start": first, **told, "rtol": run.rtol, "method": method}
    asking = Asking(
        varied=asked, point_at=asked.rotor, work=partial(exponents_of_disc, run), count=4,
        numbers=("exponent_sum", "divergence"), span=span,
        question=Question("lyapunov_exponent", {**asked.design, **given}),
    )  # fmt: skip
    kept = first if isinstance(first, str) else np.array(first)
    attributes = provenance(how) | {"start": kept} | told
    chosen = choose(executor, workers, compiled=True)
    return asking.answer(attributes, check_progress(progress), chosen, study)


@dataclass(frozen=True, slots=True)
class DiscRun:
    """How the tangent vectors of one disc are followed."""

    start: GivenStart
    span: float
    lead: int
    batches: int
    each: int
    rtol: float
    method: MethodOfTangents


def exponents_of_disc(run: DiscRun, rotor: Rotor, stop: Stop) -> Exponents:
    """Return the exponents of the motion of one disc."""
    stretches = stretches_of(
        rotor,
        begun(run.start, rotor),
        run.lead,
        run.batches * run.each,
        run.span,
        run.rtol,
        stop,
        run.method,
    )
    exponents, errors, divergence = means_of(
        stretches / run.span, run.batches, divergence_of(rotor)
    )
    total = float(exponents.sum())
    return ordered(
        stretches[:, :4] / run.span, exponents, errors, exponent_sum=total, divergence=divergence
    )


@shows_progress
def lyapunov_exponent_system(
    system: RotorSystem,
    *,
    speed: npt.ArrayLike,
    start: Start | xr.Dataset = None,
    exponents: int | None = None,
    transient: int = 200,
    revolutions: int = 2000,
    batches: int = BATCHES,
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemAxes],
) -> xr.Dataset:
    """Compute the largest Lyapunov exponents of the motion of a rotor system.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    speed : float or sequence of float, shape (n,)
        Spin speeds, not 0.
    start, modes : optional
        As in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        As in `sweep` of a rotor system. Each array becomes a dimension of the result.
    exponents : int, optional
        Number of exponents, the largest first; default: all, one for each displacement, velocity
        and speed of a race.
    transient : int
        Revolutions to settle before averaging; the small changes align in them too.
    revolutions : int
        Revolutions over which to average, at least 20 for each batch, at most a million.
    batches : int
        Number of parts of `revolutions`, at least 4, whose scatter gives the error.
    rtol : float
        Relative tolerance, from 1e-14 to 1e-4.
    progress : callable or bool, optional
        Called with the number of revolutions done and their total, or of points where there are
        several; True shows a bar on standard error.
    workers, executor, study
        As in `sweep`, for the points.

    Returns
    -------
    Dataset
        ``lyapunov_exponent`` and ``lyapunov_error`` on ``exponent``, the largest first, per unit of
        time. Of one motion also ``running_exponent`` on ``t`` and ``exponent``, the plain mean so
        far; of several ``status`` and ``message``.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If a run is stuck. One of several points does not raise: its ``message`` gives the reason.

    Notes
    -----
    Small changes of the motion follow the linearised equations along it, and jump where slip ends
    or turns (saltation). After each revolution they are made orthonormal; their mean rates of
    growth are the exponents. Means and errors are those of `lyapunov_exponent` of one disc. In an
    axisymmetric system one exponent of a motion other than a whirl at the spin speed is 0, that of
    a shift in time. An exponent is minus infinity where a contact rolls in every revolution, as
    rolling leaves no slip, and where a change shrinks below 1e-12 in a revolution.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15, 1980.
    P. C. Müller, Chaos, Solitons & Fractals 5, 1995: the jump at discontinuities.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import RotorSystem
    >>> system = RotorSystem(mass=np.eye(2), damping=0.14 * np.eye(2), stiffness=np.eye(2),
    ...                      nodes={"disc": (0, 1)}, units="1")
    >>> found = lyapunov_exponent_system(system, speed=1.7, transient=20, revolutions=80, batches=4)
    >>> found.lyapunov_exponent.values.round(5)
    array([-0.07, -0.07, -0.07, -0.07])
    """
    speeds = turning_speeds(speed, "for the exponents of a rotor system")
    here = speeds[0] if is_scalar("speed", speed) else speeds
    asked = varied_system_of(lyapunov_exponent_system, system, changed, here)
    progress = check_progress(progress)
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    parts = check_count("batches", batches, FEWEST_BATCHES)
    lead = math.ceil(check_positive("transient", transient, MOST_REVOLUTIONS))
    each = int(check_positive("revolutions", revolutions, MOST_REVOLUTIONS)) // parts
    if each < FEWEST_SPANS:
        raise InputError(
            f"revolutions must be at least {FEWEST_SPANS} for each of {parts} batches, "
            f"got {shown(revolutions)}"
        )
    taken, begun = in_modes(asked.base, modes, start)
    begun = state_at_end(assemble(taken), begun)
    varied = replace(asked, system=taken)
    turnings = Turnings(varied, tolerance)
    size = state_of_start(turnings.checked(), begun, float(speeds[0])).size
    count = size if exponents is None else check_count("exponents", exponents, 1)
    if count > size:
        raise InputError(f"exponents must be at most {size}, got {shown(exponents)}")
    run = SystemRun(begun, count, lead, parts, each, None if varied.axes else [])
    question = Question("lyapunov_exponent", {
        "rotor": asked.base, **varied.design, "start": begun, "modes": modes, "exponents": count,
        "transient": lead, "revolutions": parts * each, "batches": parts, "rtol": tolerance,
    })  # fmt: skip
    revolution = 2.0 * math.pi / abs(float(speeds[0]))
    asking = Asking(
        varied=varied, point_at=turnings.at,
        work=partial(exponents_of_system, run), count=count, span=revolution,
        question=question, whose=" of a rotor system", done=run.done, total=lead + parts * each,
    )  # fmt: skip
    attributes = provenance({"method": "taylor", "rtol": tolerance}) | {"batches": parts}
    if speeds.size == 1:
        of_time = {"transient": lead, "duration": parts * each}
        attributes |= {name: revolution * turns for name, turns in of_time.items()}
    else:
        attributes |= {"transient_revolutions": lead, "revolutions": parts * each}
    chosen = choose(executor, workers, compiled=True)
    found = asking.answer(attributes, progress, chosen, study)
    return with_meanings(with_system_units(found, asked.base), varied)


@dataclass(frozen=True, slots=True)
class SystemRun:
    """How small changes of the motion of a rotor system are followed.

    `done` gets the numbers of revolutions of one motion as they pass.
    """

    start: Start
    count: int
    lead: int
    batches: int
    each: int
    done: list[int] | None


def exponents_of_system(run: SystemRun, point: Turning, stop: Stop) -> Exponents:
    """Return the largest exponents of the motion of a rotor system."""
    flow = SystemFlow.at(*point, stop)
    state = started(point, run.start) / flow.scales
    total = run.lead + run.batches * run.each
    rates = flow.growth(state, run.count, total, run.done)[run.lead :]
    values, errors = np.full(run.count, -np.inf), np.zeros(run.count)
    known = np.isfinite(rates).all(axis=0)
    values[known], errors[known] = means_of_rates(rates[:, known], run.batches)
    return ordered(rates, values, errors)


@dataclass(frozen=True, slots=True, kw_only=True)
class Asking:
    """The exponents that are asked for, of one motion or at each point.

    Parameters
    ----------
    varied : Varied
        The points.
    point_at : callable
        Returns the rotor at a place.
    work : callable
        Returns its exponents.
    count : int
        How many there are.
    span : float
        Time after which small changes are made orthonormal, at the first point.
    question : Question
        What was asked.
    numbers : tuple of str
        The columns of a result besides exponents and errors.
    whose : str
        Words behind the title.
    done : list of int, optional
        Gets a number for each of the `total` parts of one motion.
    """

    varied: Varied
    point_at: Callable[..., Any]
    work: Callable[[Any, Stop], Exponents]
    count: int
    span: float
    question: Question
    numbers: tuple[str, ...] = ()
    whose: str = ""
    done: list[int] | None = None
    total: int = 1

    def answer(
        self,
        attributes: Mapping[str, Any],
        progress: Progress | None,
        workers: Workers,
        study: Folder | None,
    ) -> xr.Dataset:
        """Return the exponents as a labelled dataset."""
        varied = self.varied
        coordinates: dict[str, Column] = {
            **varied.coordinates, "exponent": ("exponent", np.arange(self.count))
        }  # fmt: skip
        variables: Mapping[str, Column | xr.Variable]
        if varied.axes:
            behind = dict.fromkeys(OF_EXPONENTS, ("exponent", self.count))
            variables = answers_at_each(
                varied, self.point_at, partial(_columns, self.work),
                behind | dict.fromkeys(self.numbers), self.question,
                workers=workers, study=study, progress=progress,
            )  # fmt: skip
        elif study is not None:
            raise InputError(f"study must be left out of one motion, got {shown(study)}")
        else:
            found = self._of_one(progress)
            variables = {
                name: ("exponent" if np.ndim(each) else (), each)
                for name, each in found.columns.items()
            } | {"running_exponent": (("t", "exponent"), found.running)}
            coordinates["t"] = ("t", self.span * found.spans)
        over = "over a range of parameters" if varied.axes else "of one motion"
        title = f"Lyapunov exponents {over}{self.whose}"
        attributes = {**attributes, **self.question.attribute()}
        return labelled_dataset(title, variables, coordinates, attributes, kind="lyapunov_exponent")

    def _of_one(self, progress: Progress | None) -> Exponents:
        """Return the exponents of the one motion, and report how much of it is done."""
        point = self.point_at(())

        def tell(progress: Progress) -> None:
            progress(len(self.done or ()), self.total)

        told = progress and partial(tell, progress)
        found = interruptible(lambda stop: self.work(point, stop), told=told)
        if progress is not None:
            progress(self.total, self.total)
        return found


def _columns(work: Callable[[Any, Stop], Exponents], point: Any, stop: Stop) -> Mapping[str, Any]:
    """Return the columns of a point."""
    return work(point, stop).columns
