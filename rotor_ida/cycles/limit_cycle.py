"""Find the limit cycle to which a start leads, or which lies near a guess; also at many points."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import (
    COMPONENTS,
    State,
    check_instance,
    check_progress,
    is_scalar,
    shown,
)
from rotor_ida.cycles.dataset import AXES, OF_ERRORS, OF_WHIRL, cycle_dataset, dims_of, in_words
from rotor_ida.cycles.guess import (
    CLOSING_RTOL,
    HOPF,
    Guess,
    as_start,
    checked,
    guess_in,
    guess_of,
    guess_of_system,
    has_period,
)
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit, once_round, periods_of
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.reduction import in_modes
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED, AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, choose, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import RESULT_KIND, labelled_dataset
from rotor_ida.simulation.flow import RTOL, DiscFlow, Flow
from rotor_ida.simulation.options import check_can_be_followed
from rotor_ida.simulation.starts import (
    RUNS,
    GivenStart,
    Start,
    begun_in_modes,
    given_start,
    start_of,
)
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady.decision import decide
from rotor_ida.steady.follow import limits_of
from rotor_ida.steady.grid import answers_at_each
from rotor_ida.steady.motion import Motion
from rotor_ida.steady.points import (
    Turning,
    Turnings,
    clearances_of,
    started,
    turning_speeds,
    with_meanings,
)
from rotor_ida.steady.response import BOUNCING, FULL_CONTACT, ROLLING, UNRESOLVED

OF_PLACES = ("node", "contact_node", "axial_position")
NOT_FOUND = "not_found"
# The rotor is followed to its cycle with the default tolerance of a sweep; Newton's method then
# refines the cycle.
STEADY_STATE_RTOL = 1e-10
# A start that returns to itself to this fraction of its size is a guess of a nearby cycle, which
# need not attract it.
NEAR_ITSELF = 1e-3
# Time limit for the return: cycles in the sweeps of Fig. 11 have periods up to 44.
RETURN_TIME = 100.0
# The cycle may be farther from the start than the return is, by this factor: an orbit misses itself
# only by its distance from the cycle times 1 - mu. It must also have been away by that distance.
FARTHER = 10.0
# Samples in which a return is sought; between them the motion is interpolated linearly.
SAMPLES_A_TIME = 50
SAMPLES_A_REVOLUTION = 200
# Tolerance of a given period under a load, as a fraction of a revolution.
WITHIN_A_REVOLUTION = 0.1
# Under a load the rotor is sampled once a revolution, over this number of revolutions.
REVOLUTIONS = 128
# A motion that has not settled in shorter windows has reached a cycle if it then misses itself by
# at most this fraction of its size.
COME_BACK = 1e-6


@shows_progress
@takes_rotors(system=("modes",), needed=(), varies=True)
def limit_cycle(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = None,
    period: float | None = None,
    speed: npt.ArrayLike | None = None,
    modes: int | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Compute the limit cycle to which a start leads, or which lies near a guess.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. It must turn and be damped. For a `DimensionalRotor` numbers with a unit are in
        SI units, as for `rotor_ida.simulate`; a dataset has its own.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [dimensionless], by default at rest; of a `RotorSystem` as in
        `simulate`. A start of one disc that returns to itself to a relative 1e-3 is taken as a
        guess of a cycle, stable or not. From any other start the rotor is followed to its
        attractor. Another limit cycle, or one point of a branch, serves as a guess, and of a
        `RotorSystem` one point of a `sweep` that has a period; the end of a run, or of one point of
        a sweep, as a start.
    period : float, optional
        Approximate period of the cycle, or a multiple of it, from 1e-6 to 1e4 [dimensionless]:
        Newton's method then begins at the start itself. Under a load it must be a whole number of
        revolutions to within a tenth. That of a `RotorSystem` that is not axisymmetric is rounded
        to one.
    speed : float or array_like, shape (n,), optional
        Spin speed of a `RotorSystem`, not 0; by default that of the start. That of a
        `DimensionalRotor` is a parameter of it.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    progress : callable or bool, optional
        Called from time to time with the percentage of the longest time for which the rotor is
        followed, and 100, or with the numbers of points done and of all; True shows a bar on
        standard error.
    workers, executor, study
        As in `sweep`, for the points.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], or of a `DimensionalRotor` by its own, in
        place of those of `rotor`. Each array becomes a dimension of the result, with each value
        once; all are combined, and there is a cycle at each point.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as in `sweep`; each array becomes a dimension too.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        ``response``: for a limit cycle ``bouncing`` (intermittent rub), ``full_contact`` (full
        annular rub), or with friction ``rolling`` (dry whip). Otherwise the response found instead,
        also ``quasi_periodic`` or ``not_found``; then all other variables are NaN. The ``period``
        on the rotating axes and ``period_error``, ``radius_min``, ``radius_max``,
        ``contact_count`` in a period, ``largest_force``, ``impulse_per_period``, ``stability``,
        ``residual`` [dimensionless]. On ``multiplier``, by decreasing modulus, ``multiplier_real``,
        ``multiplier_imag`` and ``multiplier_error``. On ``t`` one period of ``x y vx vy``, resolved
        on the rotating axes. On ``line`` the spectrum on fixed axes: ``frequency``,
        ``whirl_amplitude`` and ``line_kind``. ``side_line_over_spin`` is the frequency of the
        strongest line other than 1X, over the spin speed. ``whirl_over_spin`` and ``whirl_sense``
        are those of the motion, as of `rotor_ida.whirl_ratio`.

        Of a `RotorSystem` ``contact_count``, ``radius_min``, ``radius_max``, ``largest_force`` and
        ``touched`` are on ``contact``, ``node_radius_min`` and ``node_radius_max`` on ``node``, and
        ``x y vx vy`` on ``(t, node)``; there is no spectrum. On ``component``: ``final_state``, the
        state at its start and end, with the unbalance at angle 0. The attribute ``axes`` names the
        axes on which it closes.

        Where a parameter is an array, the numbers of the cycle at each point, with ``status`` and
        ``message``. What lies on ``t`` and ``line`` is left out; of one disc ``x y vx vy`` are the
        state at the start of the period. One point serves as a start.

    Raises
    ------
    InputError
        If an argument cannot be used, or ``omega`` or ``zeta`` is 0: then there are no attractors.
    SimulationError
        If Newton's method does not converge from a cycle that was simulated or given. One of
        several points does not raise: its ``message`` gives the reason.

    Notes
    -----
    On the rotating axes the motion is autonomous. A limit cycle repeats itself there:
    ``phi(s, T) = s`` with the flow phi, a state s and the period T. Newton's method solves this for
    both, by Taylor series that follow the orbit and its derivatives through all entries and exits.
    The multipliers are 1, ``q = exp(-2 zeta T)``, mu and ``q/mu``, so the trace of the monodromy
    matrix gives them all: the flow is conformally symplectic. ``trivial_defect`` and
    ``symplectic_defect`` show how well the integrated matrix satisfies this. The errors are five
    times the largest differences from three more solutions, begun elsewhere on the cycle and with
    30 times the tolerance.

    With contact damping or friction there are no such pairs, and the multipliers are eigenvalues of
    the matrix. Where the disc begins to roll or to slide the other way, friction jumps, and the
    matrix is multiplied by a saltation matrix; if a cycle rolls, one multiplier is 0. Nor has a
    `RotorSystem` pairs; where it has stators without mass the matrix comes from differences of
    runs.

    Under a load, which rotates on the rotating axes, a motion can repeat itself only after whole
    revolutions: ``T = k 2 pi/omega``. The state is that at time 0, when the load points down on
    these axes, a fixed point of the k-th stroboscopic map. No multiplier is trivial, and the
    stability depends on all four. The number k is found from the simulated motion, up to 128. In
    the same way a `RotorSystem` that is not axisymmetric has cycles of whole revolutions, on fixed
    axes.

    References
    ----------
    R. Seydel, "Practical Bifurcation and Stability Analysis", Springer, 2010, chapter 7.
    R. I. Leine, H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems",
    Springer, 2004, chapter 7: the jump of M at a discontinuity, which vanishes at entry and exit.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> cycle = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0))
    >>> cycle.period.round(12).item(), cycle.contact_count.item()
    (4.56391667538, 1)
    >>> cycle.multiplier_real.values.round(8)
    array([ 1.        , -0.51147221, -0.51147221,  0.52784725])

    The same disc as a system:

    >>> same = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0).system(), speed=2.0)
    >>> same.period.round(9).item(), same.contact_count.values
    (4.563916675, array([1]))

    At each of several speeds:

    >>> cycles = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), omega=[1.9, 2.0])
    >>> cycles.period.dims, cycles.period.values.round(6)
    (('omega',), array([4.800561, 4.563917]))
    """
    chosen, is_system = choose(executor, workers, compiled=True), isinstance(rotor, RotorSystem)
    if isinstance(rotor, RotorSystem):
        several = hasattr(speed, "__len__") and not isinstance(speed, str)
        several = several and not is_scalar("speed", speed)
        speeds = turning_speeds(speed, "for a limit cycle") if several else np.asarray(np.nan)
        asked = varied_system_of(limit_cycle, rotor, varied, speeds)
    else:
        asked = varied_of(limit_cycle, check_instance("rotor", rotor, Rotor), varied, always=())
    if asked.dims:
        jobs = {"workers": chosen, "study": study, "progress": check_progress(progress)}
        if is_system:
            return cycles_of_system(asked, start, speed, period, modes, jobs)
        return cycles_of_disc(asked, start, period, jobs)
    if study is not None:
        raise InputError(f"study must be left out of one cycle, got {shown(study)}")
    if is_system:
        guess = guess_of_system(asked.system_at(()), start, speed, period, modes)
    else:
        guess = _guess_of_disc(asked.rotor(()), start, period)
    found = _near_guess(guess, progress)
    if isinstance(start, xr.Dataset):  # of which a question keeps the guess alone
        if is_system:
            kept = _begun(asked, start, guess, modes)[-1]
        elif has_period(start, period):
            kept = as_start(replace(guess, special=""), ())
        else:
            kept = tuple(guess.state.tolist())
        given = {"rotor": rotor, **varied, "start": kept, "speed": speed, "period": period,
                 "modes": modes}  # fmt: skip
        given = {name: each for name, each in given.items() if each is not None}
        found.attrs |= Question("limit_cycle", given).attribute()
    return found


def _guess_of_disc(rotor: Rotor, start: object, period: float | None) -> Guess:
    """Return the guess of a cycle of a rotor, which may differ from that of the start."""
    check_turns_and_settles(rotor)
    guess = guess_of(rotor, start, period)
    check_revolutions(guess)
    check_can_be_followed(rotor, numbers_in(guess.state), settling=True)
    return guess if guess.rotor == rotor else Guess(DiscFlow(rotor), guess.state, guess.period)


def checked_guess(rotor: Rotor, start: object) -> Guess:
    """Return the guess given by a start, for a rotor that has limit cycles."""
    guess = guess_of(rotor, start)
    check_turns_and_settles(guess.rotor)
    check_revolutions(guess)
    return guess


def with_period(guess: Guess) -> Guess:
    """Return a guess with its period; without one, the cycle to which it leads."""
    if guess.period is not None:
        return guess
    cycle = cycle_from(guess)
    return Guess(guess.flow, cycle.start, cycle.duration)


def cycle_from(guess: Guess) -> Orbit:
    """Return the limit cycle to which a guess leads; InputError if there is none."""
    if isinstance(guess.flow, DiscFlow):
        check_can_be_followed(guess.rotor, numbers_in(guess.state), settling=True)
    cycle, response = interruptible(lambda stop: found_cycle(guess, stop))
    if cycle is None:
        raise InputError(
            f"start must lead to a limit cycle, got one from which the response is {response}"
        )
    return cycle


def _near_guess(guess: Guess, progress: Progress | bool | None) -> xr.Dataset:
    """Return the cycle to which a guess leads, or the response found instead, as a dataset."""
    check_no_hopf(guess)
    reports, watch = check_progress(progress), list[Callable[[], float]]()
    told = percentage(reports, watch, limits_of(guess.flow).longest)
    found = interruptible(
        lambda stop: cycle_dataset(guess, *found_cycle(guess, stop, watch)), told=told
    )
    if reports is not None:
        reports(100, 100)
    return found


@dataclass(frozen=True, slots=True)
class Begun:
    """Where a rotor begins at each point: a start, or the state of a cycle of a system in q."""

    start: Any
    period: float | None
    cycle: tuple[float, ...] = ()


def cycles_of_disc(
    varied: Varied, start: object, period: object, jobs: Mapping[str, Any]
) -> xr.Dataset:
    """Return the cycles of one disc to which a start leads, or which lie near a guess."""
    lowest = {name: float(varied.values(name).min()) for name in ("omega", "zeta")}
    check_turns_and_settles(Rotor(**lowest, delta0=1.0))
    first: GivenStart
    if has_period(start, period):
        known = guess_in(start)
        check_no_hopf(known)
        first, period = numbers_in(known.state), known.period
    else:
        first = given_start("start", start, loaded=bool(varied.values("load").any()))
    near = checked(period)
    for each in varied.extremes():
        check_can_be_followed(each, start_of(each, first), settling=True)
    one = varied.rotor((0,) * len(varied.dims))
    axes = {name: each.tolist() for name, each in varied.axes.items()}
    told = {} if near is None else {"period": near}
    return _at_each(
        varied, varied.rotor, Begun(first, near), DiscFlow(one),
        Question("limit_cycle", {"rotor": one, **axes, "start": first, **told}),
        {"flight": "exact", "rtol": RTOL,
         "start": first if isinstance(first, str) else np.array(first)}, jobs,
    )  # fmt: skip


def cycles_of_system(
    asked: Varied,
    start: Any,
    speed: object,
    period: object,
    modes: int | None,
    jobs: Mapping[str, Any],
) -> xr.Dataset:
    """Return the cycles of a rotor system to which a start leads, or which lie near a guess.

    Without an axis of speeds, `speed` is a number, or None for that of the start.
    """
    speeds = asked.given[SPEED]
    ends = [abs(speeds).max(), abs(speeds).min()] if speeds.ndim else [speed]
    guess, *_ = [guess_of_system(asked.base, start, each, period, modes) for each in ends]
    check_no_hopf(guess)
    flow = guess.flow
    assert isinstance(flow, SystemFlow)
    if not speeds.ndim:
        asked = asked.over(speed=np.asarray(flow.speed))
    varied, first, kept = _begun(asked, start, guess, modes)
    turnings = Turnings(varied, CLOSING_RTOL)
    turnings.checked()
    lowest = [int(np.argmin(axis)) for axis in varied.axes.values()]
    if not turnings.at(lowest).problem.has_damping:
        raise InputError("damping must be above 0 for a limit cycle: nothing settles")
    given = {"start": kept, "modes": modes, "period": None if first.cycle else guess.period}
    told = {name: each for name, each in given.items() if each is not None}
    found = _at_each(
        varied, turnings.at, first, flow,
        Question("limit_cycle", {"rotor": asked.base, **varied.design, **told}),
        {"rtol": CLOSING_RTOL, "axes": AXES[flow.period is None]}, jobs,
    )  # fmt: skip
    return with_meanings(in_words(found, asked.base), varied)


def _begun(asked: Varied, start: Any, guess: Guess, modes: int | None) -> tuple[Varied, Begun, Any]:
    """Return what varies in its modes, where it begins, and the start as a question keeps it."""
    taken, reduced = in_modes(asked.base, modes, start)
    varied, flow = replace(asked, system=taken), guess.flow
    assert isinstance(flow, SystemFlow)
    if not isinstance(start, xr.Dataset):
        return varied, Begun(reduced, guess.period), start
    if start.attrs.get(RESULT_KIND) not in RUNS:
        state = flow.in_q(guess.state)
        kept = {"speed": flow.speed, "period": guess.period, "final_state": ("component", state)}
        return varied, Begun(None, guess.period, tuple(state.tolist())), xr.Dataset(kept)
    _, ended = begun_in_modes(asked.base, modes, start)
    return varied, Begun(ended, guess.period), ended


def _numbers(first: Begun, point: Rotor | Turning, stop: Stop) -> dict[str, Any]:
    """Return the numbers of the cycle at a point, as columns."""
    guess = _guess_at(first, point, stop)
    found = cycle_dataset(guess, *found_cycle(guess, stop))
    numbers: dict[str, Any] = {name: found[name].values for name in _names(guess.flow)}
    if isinstance(guess.flow, DiscFlow):
        is_cycle = found.sizes["t"] > 0
        numbers |= {name: found[name].values[0] if is_cycle else math.nan for name in COMPONENTS}
    return numbers


def _guess_at(first: Begun, point: Rotor | Turning, stop: Stop) -> Guess:
    """Return the guess of a cycle at a point."""
    if not isinstance(point, Rotor):
        flow = SystemFlow.at(*point, stop)
        known = flow.given_state(np.array(first.cycle)) if first.cycle else None
        begun = started(point, first.start) / flow.scales if known is None else known
        return Guess(flow, begun, first.period)
    try:
        guess = Guess(DiscFlow(point), np.array(start_of(point, first.start)), first.period)
        check_revolutions(guess)
    except InputError as error:  # a resonance has no settled whirl
        raise SimulationError(str(error)) from error
    return guess


def _names(flow: Flow) -> list[str]:
    """Return the names of the numbers of a cycle that are not over its own time or spectrum."""
    return [*dims_of(flow), *OF_ERRORS, *(OF_WHIRL if isinstance(flow, DiscFlow) else ())]


def _at_each(
    varied: Varied, point_at: Callable[[Sequence[int]], Any], first: Begun, flow: Flow,
    question: Question, how: Mapping[str, Any], jobs: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Return the cycle at each point, with the labels of a result without one."""
    lost = cycle_dataset(Guess(flow, np.zeros(0)), None, "failed")
    is_disc, names = isinstance(flow, DiscFlow), _names(flow)
    columns = {name: (str(lost[name].dims[0]), lost[name].size) if lost[name].ndim else None
               for name in names} | dict.fromkeys(COMPONENTS if is_disc else ())  # fmt: skip
    found = answers_at_each(
        varied, point_at, partial(_numbers, first), columns, question,
        whole={name: lost[name].values for name in names if lost[name].dtype.kind != "f"},
        **jobs,
    )  # fmt: skip
    for name in columns:
        found[name].attrs = lost[name].attrs
    coordinates: dict[str, Any] = varied.coordinates | ({} if is_disc else clearances_of(varied))
    coordinates |= {
        name: lost[name].variable for name in (*OF_PLACES, "multiplier") if name in lost
    }
    return labelled_dataset(
        f"Limit cycles over a range of parameters{'' if is_disc else ' of a rotor system'}", found,
        coordinates, {**provenance({"method": "taylor", **how}), **question.attribute()},
        kind="cycles",
    )  # fmt: skip


def check_turns_and_settles(rotor: Rotor) -> None:
    """Raise InputError for a rotor that has no limit cycles."""
    for name in ("omega", "zeta"):
        if getattr(rotor, name) == 0.0:
            raise InputError(
                "{name} must be above 0 for a limit cycle, got {value}: nothing settles",
                name=name, value=0.0,
            )  # fmt: skip


def check_revolutions(guess: Guess) -> None:
    """Raise InputError if a period under a load is not a whole number of revolutions."""
    flow, period = guess.flow, guess.period
    if period is None or flow.period is None:
        return
    if abs(period / flow.period - periods_of(flow, period)) > WITHIN_A_REVOLUTION:
        raise InputError(
            "{name} must be a whole number of revolutions under a load, each of {revolution:.9g}, "
            "got {value}",
            name="period", revolution=flow.period, value=period,
        )  # fmt: skip


def check_no_hopf(guess: Guess) -> None:
    """Raise InputError for a Hopf point, which is no limit cycle."""
    if guess.special == HOPF:
        raise InputError(
            f"start must be a limit cycle, got a point of kind {HOPF}: continue_cycle follows what "
            "begins there"
        )


def found_cycle(guess: Guess, stop: Stop, watch: Watch | None = None) -> tuple[Orbit | None, str]:
    """Return the limit cycle to which a guess leads, or None, and the kind of response.

    SimulationError if Newton's method does not converge from a cycle that was simulated or given.
    """
    flow, state, period = guess.flow.but(stop=stop), guess.state, guess.period
    if period is None:
        # that of a system would have to be followed for too long
        is_disc = isinstance(flow, DiscFlow)
        near = _near(flow, state, _time_of_return(flow, state)) if is_disc else None
        if near is not None:
            return near, near.response
        kind, state, period = _settled(flow, state, watch)
        if kind == UNRESOLVED and is_disc and flow.period is not None:
            near = _of_many_revolutions(flow, state)
            return near, NOT_FOUND if near is None else near.response
        if period is None:
            return None, NOT_FOUND if kind == UNRESOLVED else kind
    cycle = once_round(close_orbit(flow, state, period))
    return cycle, cycle.response


def _settled(flow: Flow, state: Values, watch: Watch | None) -> tuple[str, Values, float | None]:
    """Return the response to which a state leads, the state there, and the period of a cycle."""
    flow = flow.but(rtol=STEADY_STATE_RTOL, watch=watch)
    motion = Motion(flow, limits_of(flow), state)
    decision = decide(motion)
    is_cycle = decision.kind in (BOUNCING, FULL_CONTACT, ROLLING)
    return decision.kind, motion.state, decision.period if is_cycle else None


def _near(flow: Flow, state: Values, time: float | None) -> Orbit | None:
    """Return the cycle near a start that returns closely to itself; None if it does not."""
    if time is None:
        return None
    try:
        cycle = close_orbit(flow, state, time)
    except SimulationError:
        return None
    moved = np.linalg.norm(cycle.start - state)
    return once_round(cycle) if moved <= FARTHER * NEAR_ITSELF * np.linalg.norm(state) else None


def _time_under_load(flow: Flow, state: Values, part: float) -> float | None:
    """Return the time after which an orbit first returns, to a fraction of its size.

    It is sampled once a revolution, when the load points down on the rotating axes.
    """
    times = flow.revolution * np.arange(REVOLUTIONS + 1.0)
    misses = np.linalg.norm(flow.states(state, times)[1:] - state, axis=1)
    back = np.flatnonzero(misses <= part * float(np.linalg.norm(state)))
    return float(times[back[0] + 1]) if back.size else None


def _of_many_revolutions(flow: Flow, state: Values) -> Orbit | None:
    """Return the stable cycle that a motion under a load has reached, if longer than windows."""
    cycle = _near(flow, state, _time_under_load(flow, state, COME_BACK))
    return cycle if cycle is not None and is_stable(cycle) else None


def _time_of_return(flow: Flow, state: Values) -> float | None:
    """Return the time at which an orbit first returns to its start; None if it does not in time."""
    if flow.period is not None:
        return _time_under_load(flow, state, NEAR_ITSELF)
    times, misses = returns(flow, state, RETURN_TIME, FARTHER * NEAR_ITSELF)
    back = np.flatnonzero(misses <= NEAR_ITSELF * float(np.linalg.norm(state)))
    return float(times[back[0]]) if back.size else None


def returns(flow: Flow, state: Values, duration: float, away: float) -> tuple[Values, Values]:
    """Return the times at which an orbit passes its start, and the distances across the motion.

    A passage counts once the orbit has been `away`, relative to the size of the state. One passage
    may give several times close to each other.
    """
    a_revolution = math.ceil(SAMPLES_A_REVOLUTION / flow.revolution)
    samples_a_time = max(SAMPLES_A_TIME, a_revolution)
    span, size = 1.0 / samples_a_time, float(np.linalg.norm(state))
    states = flow.states(state, span * np.arange(math.ceil(duration * samples_a_time) + 1.0))
    apart = states - state
    rates = np.gradient(states, span, axis=0)
    ahead = np.einsum("ni,ni->n", apart, rates) / np.einsum("ni,ni->n", rates, rates).clip(1e-300)
    across = np.linalg.norm(apart - ahead[:, None] * rates, axis=1)
    left = np.flatnonzero(np.linalg.norm(apart, axis=1) > away * size)
    passed = np.flatnonzero(np.abs(ahead) <= span)
    passed = passed[passed > left[0]] if left.size else passed[:0]
    return span * passed - ahead[passed], across[passed]


def numbers_in(state: Values) -> State:
    """Return the state of one disc as numbers."""
    x, y, vx, vy = state.tolist()
    return x, y, vx, vy
