"""Fit a machine to signals: least squares on order tracks and contact times."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_between,
    check_positive,
    check_state,
    check_vector,
    shown,
)
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.fitting.identifiability import ANGLE, Told, left_in_words, told_by
from rotor_ida.fitting.motion import Motion
from rotor_ida.fitting.problem import Problem, Unknown, partners
from rotor_ida.fitting.records import Measured, measured
from rotor_ida.parameters import DimensionalRotor, Rotor
from rotor_ida.provenance import provenance
from rotor_ida.schema import Column
from rotor_ida.simulation.orbit import ENTRY, EXIT

# What can be sought of a machine: the unit, and of a dimensionless rotor the name, with how many of
# the one the other is.
OF_MACHINE = {
    "mass": "kg", "contact_stiffness": "N m-1.5", "damping": "N s m-1", "eccentricity": "m",
    "clearance": "m", "shaft_stiffness": "N m-1", "contact_damping": "s m-1", "load": "N",
    "friction": "1", ANGLE: "rad",
}  # fmt: skip
OF_ROTOR = {
    "zeta": ("damping", 2.0),
    "delta0": ("clearance", 1.0),
    **{name: (name, 1.0) for name in ("shaft_stiffness", "contact_damping", "load", "friction")},
    ANGLE: (ANGLE, 1.0),
}
# What must stay above this part of its first guess, as a machine has none without it.
POSITIVE, LEAST = ("mass", "contact_stiffness", "eccentricity", "clearance"), 1e-3
MOST_ORDERS, LARGEST_ORDER = 20, 20.0
MOST_EVALUATIONS = 100
TOLERANCE = 1e-10
# Noise that is told by what is left is told again until it changes by less than this.
SETTLED, MOST_ROUNDS = 1e-3, 5
# Which part of the windows is fitted after which; the second way where the first leaves more than
# so many squares of the noise for each number.
WAYS, NEAR = ((1.0,), (0.25, 0.5, 0.75, 1.0)), 2.0
# A clearance is sought from these parts of the largest displacement, and from the first guess.
CLEARANCES = (0.5, 0.7, 0.85, 0.95)


def fit(
    signals: xr.Dataset | Sequence[xr.Dataset],
    machine: Rotor | DimensionalRotor,
    unknown: Sequence[str],
    *,
    orders: npt.ArrayLike = (1,),
    revolutions: int | None = None,
    start: npt.ArrayLike | None = None,
    entries: Any = None,
    exits: Any = None,
    time_error: float | None = None,
    noise: float | None = None,
    confidence: float = 0.95,
) -> xr.Dataset:
    """Find parameters of a machine from its signals, with their errors.

    Parameters
    ----------
    signals : Dataset or sequence of Dataset
        Signals of `rotor_ida.read_signals` or `rotor_ida.signals_of`, or runs: one record or
        several of the same machine, of a run-up, a run-down or one speed.
    machine : Rotor or DimensionalRotor
        What is known of the machine, and of what is sought the first guess. Its speed is not
        looked at. A `Rotor` is for signals without dimensions, the other for those in SI units.
    unknown : sequence of str
        What is sought: of a `DimensionalRotor` ``mass``, ``damping``, ``eccentricity``,
        ``clearance``, ``shaft_stiffness``, ``contact_stiffness``, ``contact_damping``, ``load`` or
        ``friction``; of a `Rotor` ``zeta``, ``delta0`` and the last five but for
        ``contact_stiffness``. ``unbalance_angle`` is by how much the unbalance is ahead of the mark
        of the keyphasor, otherwise 0 [rad].
    orders : array_like, shape (k,)
        Multiples of the speed whose amplitudes and phases are compared, forward and backward [1];
        0 is the mean position.
    revolutions : int, optional
        Length of their windows, as of `rotor_ida.orders`.
    start : array_like, shape (4,) or (records, 4), optional
        ``(x, y, vx, vy)`` at the begin of each record, if it is known. By default it is sought too.
    entries, exits : array_like, shape (m,), or a sequence of them, optional
        Times at which contacts were seen to begin and to end, in the time of the signals: of one
        record, or for each.
    time_error : float, optional
        Standard error of these times, in their unit.
    noise : float, optional
        Standard deviation of the noise in x and y, in the unit of the signals. By default what the
        fit leaves in the windows besides all orders tells it.
    confidence : float
        With which probability intervals hold the truth [1].

    Returns
    -------
    Dataset
        On ``unknown``: ``estimate``, ``standard_error``, ``lower`` and ``upper`` of the interval,
        ``first_guess``, ``told``, whether it is known to half of its value at least, and ``unit``;
        on (``unknown``, ``unknown_too``) ``covariance``. On ``window``, over all records, the
        tracks that were compared: measured ``forward_whirl_amplitude``, ``forward_phase_lag`` and
        so on, as of `rotor_ida.orders`, beside ``fitted_forward_whirl_amplitude`` and so on;
        ``record``, ``t``, ``speed``. On ``touch``, where contact times are compared,
        ``measured_time``, ``fitted_time``, ``event_kind``. ``chi_square``, ``degrees_of_freedom``
        and ``noise``. The attributes ``identifiability`` and ``remainder`` say in words what the
        signals tell of each unknown, and whether what is left is noise.

    Raises
    ------
    InputError
        If an argument cannot be used, the units do not fit, the signals hold no angle, more is
        sought than compared, or the motion is chaotic, or rolls on the ring.
    SimulationError
        If no solution was found.

    Notes
    -----
    The motion is followed along the measured course of the speed, so that run-ups need not be slow.
    Windows of measured and computed motion go through the same least squares of `rotor_ida.orders`,
    and what is left is divided by its standard error, the orders of a window made independent of
    each other. The derivatives are those of the motion itself, from its equations of variation,
    and of contact times ``dt = (d(clearance) - (z/|z|) . dz)/r'``. The covariance is that of
    least squares, the states at the begins sought beside: right where noise is white, of one
    strength in all directions, and small enough for the motion to change in proportion.

    References
    ----------
    G. A. F. Seber and C. J. Wild, "Nonlinear Regression", Wiley, 1989.

    Examples
    --------
    >>> from rotor_ida import run_up, signals_of
    >>> rotor = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    >>> seen = signals_of(run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.01, samples=4001))
    >>> guess = Rotor(omega=0.3, zeta=0.08, delta0=1.8, shaft_stiffness=0.9)
    >>> found = fit(seen, guess, ["zeta", "delta0", "shaft_stiffness"])
    >>> found.estimate.values.round(6)
    array([0.1, 1.5, 1. ])
    """
    from scipy.stats import norm  # noqa: PLC0415 - takes long to import

    level = check_between("confidence", confidence, 0.5, 1.0 - 1e-9)
    problem = _problem(
        signals, machine, unknown,
        orders=_checked_orders(orders), revolutions=revolutions, start=start, entries=entries,
        exits=exits, time_error=time_error, noise=noise,
    )  # fmt: skip
    solution, noise_found = _solved(problem, noise)
    _, slopes, motions = problem.at(solution)
    scale = [
        abs(value) if value != 0.0 and each.name != ANGLE else 1.0
        for each, value in zip(problem.unknown, solution.tolist(), strict=False)
    ]
    told = told_by(slopes, np.array(scale), [each.name for each in problem.unknown])
    quantile = float(norm.ppf(0.5 + 0.5 * level))
    return _dataset(problem, machine, solution, motions, told, quantile, noise_found, level)


# ---- What is asked ----


def _problem(
    signals: xr.Dataset | Sequence[xr.Dataset],
    machine: Rotor | DimensionalRotor,
    unknown: Sequence[str],
    *,
    orders: Values,
    revolutions: int | None,
    start: npt.ArrayLike | None,
    entries: Any,
    exits: Any,
    time_error: float | None,
    noise: float | None,
) -> Problem:
    """Return the problem, all checked."""
    given = [signals] if isinstance(signals, xr.Dataset) else list(signals)
    if not given:
        raise InputError("signals must hold at least one record, got none")
    in_si = isinstance(machine, DimensionalRotor)
    whole = _in_si(machine)
    if whole.clearance <= 0.0:
        raise InputError("machine must have a clearance above 0 for a fit, got 0.0")
    sought = _unknowns(unknown, whole, in_si=in_si)
    touches = {
        ENTRY: _by_record("entries", entries, len(given)),
        EXIT: _by_record("exits", exits, len(given)),
    }
    records = [
        measured(
            each, orders, revolutions, {kind: times[n] for kind, times in touches.items()},
            in_si=in_si,
        )
        for n, each in enumerate(given)
    ]  # fmt: skip
    problem = Problem(whole, sought, records, 1.0)
    if any(record.touches for record in records):
        if time_error is None:
            raise InputError("time_error must be given with entries or exits, got None")
        problem.time_error = check_positive("time_error", time_error) * records[0].second
    elif time_error is not None:
        raise InputError("entries or exits must be given with time_error, got none of them")
    problem.starts = _starts(start, records)
    problem.noise = (
        _noise_of(records, [each.record.z for each in records])
        if noise is None
        else check_positive("noise", noise) * records[0].metre
    )
    _check_enough(problem)
    return problem


def _in_si(machine: object) -> DimensionalRotor:
    """Return a machine whose length, mass and time of reference are 1, if it has no dimensions."""
    if isinstance(machine, DimensionalRotor):
        return machine
    if not isinstance(machine, Rotor):
        raise InputError(f"machine must be a Rotor or a DimensionalRotor, got {shown(machine)}")
    beyond = {
        each.name: getattr(machine, each.name)
        for each in fields(Rotor)
        if each.name not in {"omega", "zeta", "delta0"}
    }
    return DimensionalRotor(
        mass=1.0, contact_stiffness=1.0, damping=2.0 * machine.zeta, eccentricity=1.0,
        clearance=machine.delta0, speed=machine.omega, **beyond,
    )  # fmt: skip


def _unknowns(unknown: object, machine: DimensionalRotor, *, in_si: bool) -> list[Unknown]:
    """Return what is sought."""
    known = OF_MACHINE if in_si else OF_ROTOR
    allowed = f"{', '.join(known)}"
    if isinstance(unknown, str) or not isinstance(unknown, Sequence | np.ndarray):
        raise InputError(f"unknown must be a sequence of names, of {allowed}, got {shown(unknown)}")
    names = list(unknown)
    wrong = [each for each in names if not isinstance(each, str) or each not in known]
    if wrong or not names:
        raise InputError(f"unknown must be of {allowed}, got {shown(wrong[0] if wrong else names)}")
    if len(set(names)) < len(names):
        raise InputError(f"unknown must name each once, got {shown(names)}")
    if "friction" in names and not machine.disc_radius:
        raise InputError("machine must have a disc_radius for friction to be sought, got none")
    found = []
    for name in names:
        field, factor = (name, 1.0) if in_si else OF_ROTOR[name]
        guess = 0.0 if field == ANGLE else getattr(machine, field) / factor
        least = -math.inf if field == ANGLE else LEAST * guess if field in POSITIVE else 0.0
        found.append(Unknown(name, field, factor, guess, least))
    return found


def _checked_orders(orders: npt.ArrayLike) -> Values:
    """Return orders that can be compared."""
    asked = check_vector("orders", orders, largest=LARGEST_ORDER)
    if (asked < 0.0).any() or not (asked > 0.0).any():
        raise InputError(
            f"orders must hold one above 0 and none below, got {shown(asked.tolist())}"
        )
    if asked.size > MOST_ORDERS or np.unique(asked).size < asked.size:
        raise InputError(
            f"orders must be at most {MOST_ORDERS} that differ, got {shown(asked.tolist())}"
        )
    return asked


def _by_record(name: str, times: Any, count: int) -> list[Any]:
    """Return contact times for each record; None where there are none."""
    if times is None:
        return [None] * count
    flat = count == 1 and not (
        isinstance(times, Sequence) and len(times) == 1 and np.ndim(times[0]) == 1
    )
    found = [times] if flat else list(times)
    if len(found) != count:
        raise InputError(f"{name} must be given for each of {count} records, got {len(found)}")
    return [None if each is None or not np.size(each) else each for each in found]


def _starts(start: Any, records: list[Measured]) -> list[Values] | None:
    """Return the states at the begins in SI units, if they are given."""
    if start is None:
        return None
    rows = [start] if np.ndim(start) == 1 else list(start)
    if len(rows) != len(records):
        raise InputError(f"start must be one state for each record, got {len(rows)}")
    scale = np.array([records[0].metre] * 2 + [records[0].metre / records[0].second] * 2)
    return [np.array(check_state("start", row)) * scale for row in rows]


def _check_enough(problem: Problem) -> None:
    """Raise `InputError` where more is sought than compared."""
    compared = _compared(problem)
    sought = problem.first().size
    if compared < sought:
        raise InputError(
            f"signals must hold at least as many numbers to compare as are sought, {sought}, got "
            f"{compared} in {sum(each.tracks.windows.times.size for each in problem.records)} "
            "windows"
        )


def _compared(problem: Problem) -> int:
    """Return how many numbers are compared, but for contact times."""
    return sum(
        2 * each.tracks.orders.size * each.tracks.windows.times.size for each in problem.records
    )


# ---- The solution ----


def _noise_of(records: list[Measured], left: list[npt.NDArray[np.complex128]]) -> float:
    """Return the standard deviation that all orders leave of x and y in the windows."""
    sums = [each.tracks.left(z) for each, z in zip(records, left, strict=True)]
    squares, free = (sum(each) for each in zip(*sums, strict=True))
    size = max(float(np.abs(each.record.z).max()) for each in records)
    # signals without noise are still rounded, and computed to a tolerance
    return max(math.sqrt(squares / free), 1e-9 * size)


def _solved(problem: Problem, noise: float | None) -> tuple[Values, float]:
    """Return the solution, and the noise; that is told by what the fit leaves, if not given."""
    time_error = problem.time_error
    problem.time_error = math.inf
    solution = _searched(problem, _first_guess(problem))
    for _ in range(MOST_ROUNDS):
        before = problem.noise
        if noise is None:
            motions = problem.motions(solution)
            left = [each.record.z - motion.z for each, motion in zip(problem.records, motions,
                                                                     strict=True)]  # fmt: skip
            problem.renew(noise=_noise_of(problem.records, left))
        problem.renew(time_error=time_error)
        solution = _least(problem, solution)
        if noise is not None or abs(problem.noise - before) <= SETTLED * before:
            break
    return solution, problem.noise


def _first_guess(problem: Problem) -> Values:
    """Return the first guess; of the clearance, beside the user's, the best of several.

    A motion that never touches the ring does not change with the clearance.
    """
    first = problem.first()
    problem.at(first)  # what cannot be followed at all is told
    names = [each.field for each in problem.unknown]
    if "clearance" not in names:
        return first
    place = names.index("clearance")
    size = max(float(np.abs(each.record.z).max()) for each in problem.records)
    guesses = [first]
    for part in CLEARANCES:
        guess = first.copy()
        guess[place] = part * size
        guesses.append(guess)
    left = [float((problem.left(each) ** 2).sum()) for each in guesses]
    return guesses[int(np.argmin(left))]


def _searched(problem: Problem, first: Values) -> Values:
    """Return where the sum of squares is least, from a guess that may be far off.

    A motion that goes another way early on, as where it jumps at another speed, tells little of
    what comes later. So where all windows at once lead astray, the first ones are fitted first.
    """
    found: list[tuple[float, Values]] = []
    failure = SimulationError("no least squares", time=0.0, state=(0.0, 0.0, 0.0, 0.0))
    for parts in WAYS:
        solution = first
        try:
            for part in parts:
                problem.renew(part=part)
                solution = _least(problem, solution)
        except SimulationError as error:
            failure = error
            problem.renew(part=1.0)
            continue
        left = problem.at(solution)[0]
        found.append((float((left**2).sum()), solution))
        if found[-1][0] <= NEAR * left.size:
            break
    if not found:
        raise failure
    return min(found, key=lambda each: each[0])[1]


def _least(problem: Problem, first: Values) -> Values:
    """Return where the sum of squares is least, near a guess."""
    from scipy.optimize import least_squares  # noqa: PLC0415 - takes long to import

    problem.at(first)
    found = least_squares(
        problem.left, first, problem.slopes, problem.bounds(), method="trf", x_scale="jac",
        ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE, max_nfev=MOST_EVALUATIONS,
    )  # fmt: skip
    if not found.success:
        state = tuple(found.x[len(problem.unknown) :][:4].tolist()) or (0.0, 0.0, 0.0, 0.0)
        raise SimulationError(
            f"no least squares in {MOST_EVALUATIONS} evaluations: begin nearer to the solution, or "
            "fit fewer unknowns or a shorter part",
            time=0.0, state=state,
        )  # fmt: skip
    solution: Values = found.x
    return solution


# ---- The result ----


def _dataset(
    problem: Problem,
    machine: Rotor | DimensionalRotor,
    solution: Values,
    motions: list[Motion],
    told: Told,
    quantile: float,
    noise: float,
    level: float,
) -> xr.Dataset:
    """Return what was found as a dataset."""
    chi_square, freedom = _left_over(problem, solution, motions), problem.freedom(solution)
    in_si = isinstance(machine, DimensionalRotor)
    variables: dict[str, Column] = {
        **_estimates(problem, solution, told, quantile, in_si=in_si),
        **_tracks(problem, motions),
        **_touches(problem, motions),
        "chi_square": ((), chi_square),
        "degrees_of_freedom": ((), freedom),
        "noise": ((), noise / problem.records[0].metre),
    }
    names = [each.name for each in problem.unknown]
    coordinates: dict[str, Column] = {
        "unknown": ("unknown", names),
        "unknown_too": ("unknown_too", names),
        **{name: variables.pop(name) for name in ("t", "speed", "record", "order")},
    }
    words = [*told.words, *_at_bounds(problem, solution)]
    attributes = provenance({"method": "taylor"}) | {
        "machine": type(machine).__name__,
        **{f"given_{name}": value for name, value in machine.given.items()},
        "identifiability": "; ".join(words),
        "remainder": left_in_words(chi_square, freedom),
        "confidence": level,
        "evaluations": problem.evaluations,
    }
    record = problem.records[0].record
    plain = replace(
        record,
        coordinates={},
        attributes=attributes,
        length=problem.records[0].units[0],
        time=problem.records[0].units[1],
    )
    return plain.dataset("Fit of a machine to signals", variables, coordinates)


def _left_over(problem: Problem, solution: Values, motions: list[Motion]) -> float:
    """Return chi-square of all that is compared, the guesses of the starts among it."""
    total = 0.0
    for number, (each, motion) in enumerate(zip(problem.records, motions, strict=True)):
        left = each.tracks.weighed((motion.z - each.record.z)[:, None]) / problem.noise
        total += float((left**2).sum())
        if problem.starts is None:
            place = len(problem.unknown) + 4 * number
            guessed = (solution[place : place + 4] - each.start) / each.spread
            total += float((guessed**2).sum())
        for kind, times in each.touches.items():
            apart = (partners(times, motion, kind) - times) / problem.time_error
            total += float(np.nansum(apart**2))
    return total


def _at_bounds(problem: Problem, solution: Values) -> list[str]:
    """Return words for each unknown that would rather be less than it may."""
    return [
        f"{each.name} is at its least value {each.least:g}: its interval has one side"
        for each, value in zip(problem.unknown, solution.tolist(), strict=False)
        if math.isfinite(each.least)
        and value - each.least <= 1e-6 * max(abs(each.guess), abs(value))
    ]


def _estimates(
    problem: Problem, solution: Values, told: Told, quantile: float, *, in_si: bool
) -> dict[str, Column]:
    """Return the numbers of each unknown."""
    count = len(problem.unknown)
    values = solution[:count]
    errors = np.sqrt(np.diag(told.covariance))
    least = np.array([each.least for each in problem.unknown])
    exponent = problem.machine.contact_exponent
    units = [OF_MACHINE[each.name] if in_si else "1" for each in problem.unknown]
    linear = [each if exponent > 1.0 else each.replace("m-1.5", "m-1") for each in units]
    return {
        "estimate": ("unknown", values),
        "standard_error": ("unknown", errors),
        "lower": ("unknown", np.maximum(values - quantile * errors, least)),
        "upper": ("unknown", values + quantile * errors),
        "first_guess": ("unknown", [each.guess for each in problem.unknown]),
        "told": ("unknown", told.told.astype(np.int8)),
        "unit": ("unknown", linear),
        "covariance": (("unknown", "unknown_too"), told.covariance),
    }


def _tracks(problem: Problem, motions: list[Motion]) -> dict[str, Column]:
    """Return measured and fitted tracks of all records."""
    found: dict[str, list[Values]] = {}
    for number, (each, motion) in enumerate(zip(problem.records, motions, strict=True)):
        tracks = each.tracks
        both = tracks.amplitudes(np.column_stack([each.record.z, motion.z]))
        errors = problem.noise * np.sqrt(np.einsum("wkk->wk", tracks.inverse).real)
        parts: dict[str, Values] = {
            "record": np.full(tracks.windows.times.size, number),
            "t": tracks.windows.times / each.second + each.begin,
            "speed": tracks.windows.speeds * each.second,
        }
        # the orders are symmetric about 0
        ahead = np.flatnonzero(tracks.orders >= 0.0)
        back = tracks.orders.size - 1 - ahead
        for words, column in (("", 0), ("fitted_", 1)):
            forward, backward = both[:, ahead, column], both[:, back, column]
            parts |= {
                f"{words}forward_whirl_amplitude": np.abs(forward) / each.metre,
                f"{words}forward_phase_lag": np.angle(forward.conj()),
                f"{words}backward_whirl_amplitude": np.abs(backward) / each.metre,
                f"{words}backward_phase_lag": np.angle(backward),
            }
        parts["forward_amplitude_error"] = errors[:, ahead] / each.metre
        parts["backward_amplitude_error"] = errors[:, back] / each.metre
        for name, values in parts.items():
            found.setdefault(name, []).append(values)
    columns: dict[str, Column] = {
        name: (("window", "order") if values[0].ndim > 1 else "window", np.concatenate(values))
        for name, values in found.items()
    }
    tracked = problem.records[0].tracks.orders
    return columns | {"order": ("order", tracked[tracked >= 0.0])}


def _touches(problem: Problem, motions: list[Motion]) -> dict[str, Column]:
    """Return measured and fitted contact times, those without a partner as NaN."""
    rows = [
        (number, kind, times / each.second + each.begin,
         partners(times, motion, kind) / each.second + each.begin)
        for number, (each, motion) in enumerate(zip(problem.records, motions, strict=True))
        for kind, times in each.touches.items()
    ]  # fmt: skip
    if not rows:
        return {}
    counts = [times.size for _, _, times, _ in rows]
    return {
        "measured_time": ("touch", np.concatenate([row[2] for row in rows])),
        "fitted_time": ("touch", np.concatenate([row[3] for row in rows])),
        "event_kind": ("touch", np.repeat([row[1] for row in rows], counts).astype(np.int8)),
        "time_error": ((), problem.time_error / problem.records[0].second),
        "touch_record": ("touch", np.repeat([row[0] for row in rows], counts)),
    }
