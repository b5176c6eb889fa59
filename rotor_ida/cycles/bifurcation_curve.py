"""Folds, period doublings and torus points of limit cycles over two parameters.

Beside the equations of shooting a third condition holds on such a curve: a test function of the
monodromy matrix M, ``2 (1 + q) - tr M`` for a fold or ``tr M`` for a doubling, is 0; for a torus,
and in general, see `rotor_ida.cycles.multipliers`. It is smooth, and no eigenvalue has to be
followed. A cusp, where two folds meet, is where the curve turns back in the plane of the
parameters, though not in the space of all unknowns. A curve of torus points ends where the pair on
the unit circle becomes real, at 1 or -1.

Where the contact's stiffness or damping begins at once, M changes like a root beyond a graze: at
the ring in a linear contact, and at the state in which the contact with damping just does not come
loose. There such a curve has a corner, and may end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    MOST_NUMBERS,
    check_choice,
    check_count,
    check_instance,
    check_progress,
    shown,
)
from rotor_ida.cycles.branch import (
    CLOSED,
    COUNTS,
    DOUBLING,
    FOLD,
    PLACE,
    TORUS,
    Course,
    Side,
    advance,
    closing_equations,
    course_from,
    may_have_tori,
    shot_of,
)
from rotor_ida.cycles.continuation import Curve, Point, Problem
from rotor_ida.cycles.continue_cycle import CONTINUED, branch_dataset, check_limits
from rotor_ida.cycles.guess import Guess, guess_of
from rotor_ida.cycles.limit_cycle import check_revolutions, check_turns_and_settles, cycle_from
from rotor_ida.cycles.multipliers import doubling_test, fold_test, on_unit_circle, torus_test
from rotor_ida.cycles.shooting import Cycle, checked_cycle, failure, revolutions_of
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import Progress, Stop
from rotor_ida.results.provenance import provenance
from rotor_ida.simulation.neighbours import Shot

Kind = Literal["fold", "period_doubling", "torus"]

KINDS = (FOLD, DOUBLING, TORUS)
CUSP = "cusp"
TESTS: dict[str, Callable[[Shot], float]] = {
    FOLD: fold_test,
    DOUBLING: doubling_test,
    TORUS: torus_test,
}
# Step of the differences by which a test function is differentiated, in parts of the scales: about
# the root of rounding, and short beside the kink that the trace has at a graze.
DIFFERENCE = 1e-8
# The derivatives serve until an unknown has moved by a step: beside a graze they change without
# bound.
KEPT_WITHIN = 1e-8
# Points of a branch, each way, on which a first bifurcation is sought: as many as a branch has by
# default.
MOST_POINTS_OF_BRANCH = 2000


def bifurcation_curve(
    rotor: Rotor,
    *,
    start: npt.ArrayLike | xr.Dataset,
    kind: Kind,
    parameters: tuple[str, str] = ("omega", "delta0"),
    limits: Mapping[str, tuple[float, float]] | Sequence[tuple[float, float]],
    points: int = 2000,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Follow a fold, a period doubling or a torus point of limit cycles over two parameters.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : array_like, shape (4,), or Dataset
        A special point of a branch of this kind, ``branch.isel(special=...)``; or a limit cycle, a
        point of a branch, or a start ``(x, y, vx, vy)`` that leads to a cycle [1]: then the branch
        over the first parameter is followed to the nearest one.
    kind : {"fold", "period_doubling", "torus"}
        What to follow. A torus is born only with contact damping or a load.
    parameters : tuple of str
        The two parameters to vary, of those that `continue_cycle` takes.
    limits : mapping of str to tuple, or two tuples
        The least and the largest value of each [1].
    points : int
        The largest number of points each way.
    progress : callable, optional
        Called with the number of points found and the largest there can be.

    Returns
    -------
    Dataset
        On ``point`` both parameters and the same variables as of a branch, see `continue_cycle`;
        on ``special`` its cusps and grazes, with ``special_value`` of the first parameter and
        ``special_second_value`` of the other.

    Raises
    ------
    InputError
        If an argument cannot be used, or no such bifurcation was found within the limits.
    SimulationError
        If Newton's method does not converge to a first point.

    Notes
    -----
    The test function is differentiated by finite differences of M, which is itself integrated; the
    points are as exact as those of a branch, as only the equations decide on these.

    References
    ----------
    Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer, 2004, chapter 10.

    Examples
    --------
    >>> rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    >>> curve = bifurcation_curve(rotor, start=(3, 1, 0, 0), kind="fold",
    ...                           limits={"omega": (2.4, 3.2), "delta0": (0.4, 0.6)})
    >>> curve.omega.values[curve.delta0 == 0.5].round(8).item()
    2.53041892
    """
    check_instance("rotor", rotor, Rotor)
    check_choice("kind", kind, KINDS)
    first, second = _checked_parameters(parameters)
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    check_progress(progress)
    guess = guess_of(rotor, start)
    check_turns_and_settles(guess.rotor)
    check_revolutions(guess)
    if kind == TORUS and not may_have_tori(guess.rotor):
        raise InputError(
            "contact_damping, friction or load must be above 0 for a torus to be born, got a rotor "
            "without"
        )
    bounds = _checked_limits((first, second), limits, guess.rotor)
    go_on = np.zeros(1, np.uint8)
    if guess.special != kind:
        guess = _nearest(guess, kind, first, bounds[0], go_on)
    course = _course(guess, kind, (first, second), bounds, count, go_on)
    sides = (Side([course.first]), Side([course.first.reversed()]))
    for side in sides:
        while not side.end:
            advance(course, side)
            if progress is not None:
                progress(sum(len(each.points) for each in sides), 2 * count)
        if side.end == CLOSED:
            break
    if progress is not None:
        progress(2 * count, 2 * count)
    attributes = provenance({"method": "taylor", "flight": "exact"}) | {
        "kind": kind,
        "parameters": f"{first} {second}",
        "limits": np.array(bounds).ravel(),
        "points": count,
        "start": guess.state,
        "start_period": guess.period or math.nan,
        **{f"start_{name}": value for name, value in guess.rotor.given.items()},
    }
    found = branch_dataset(
        sides, (first, second), guess.rotor, "Bifurcation of limit cycles", kind="curve"
    )
    return found.assign_attrs(attributes)


def _checked_parameters(parameters: object) -> tuple[str, str]:
    names = list(parameters) if isinstance(parameters, (tuple, list)) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        names = []
    if len(set(names) & set(CONTINUED)) != 2:
        wanted = ", ".join(CONTINUED)
        raise InputError(f"parameters must be two of {wanted}, got {shown(parameters)}")
    first, second = names
    return first, second


def _checked_limits(
    names: tuple[str, str], limits: object, rotor: Rotor
) -> tuple[tuple[float, float], tuple[float, float]]:
    pair = limits.tolist() if isinstance(limits, np.ndarray) else limits
    if isinstance(limits, Mapping):
        if set(limits) != set(names):
            raise InputError(f"limits must be of {' and '.join(names)}, got {shown(limits)}")
        pair = [limits[name] for name in names]
    if not isinstance(pair, (tuple, list)) or len(pair) != 2:
        raise InputError(f"limits must be two pairs of numbers, got {shown(limits)}")
    first, second = (
        check_limits(name, each, rotor) for name, each in zip(names, pair, strict=True)
    )
    return first, second


def _nearest(
    guess: Guess, kind: str, parameter: str, limits: tuple[float, float], stop: Stop
) -> Guess:
    """Return the bifurcation of a kind that is nearest along the branch through a cycle."""
    if guess.period is None:
        cycle = cycle_from(guess.rotor, guess.state)
        guess = Guess(guess.rotor, cycle.state, cycle.period)
    course = course_from(guess, parameter, limits, MOST_POINTS_OF_BRANCH, stop)
    sides = [Side([course.first]), Side([course.first.reversed()])][: 2 if course.both else 1]
    while not all(side.end for side in sides):
        for side in sides:
            if not side.end:
                advance(course, side)
            for _, special in side.specials:
                if special.name == kind:
                    shot = special.point.stretch
                    return Guess(shot.rotor, shot.start, shot.duration, kind)
    raise InputError(f"limits must hold a {kind} of the branch through the start, got none there")


def _course(
    guess: Guess,
    kind: str,
    names: tuple[str, str],
    limits: tuple[tuple[float, float], tuple[float, float]],
    most: int,
    stop: Stop,
) -> Course:
    """Return the curve through a bifurcation."""
    values = [getattr(guess.rotor, name) for name in names]
    period = guess.period or math.nan
    scale = np.empty(7)
    scale[:4], scale[4] = np.linalg.norm(guess.state), period
    scale[5:] = [value or high - low for value, (low, high) in zip(values, limits, strict=True)]
    line = Curve(_problem(guess.rotor, kind, names, scale, stop), scale)
    first = line.first(np.append(guess.state, (period, *values)))
    return Course(line, names[0], first, {PLACE: limits[0], PLACE + 1: limits[1]}, most)


def _problem(
    rotor: Rotor, kind: str, names: tuple[str, str], scale: Values, stop: Stop
) -> Problem[Shot]:
    """Return the bifurcations of a kind over two parameters of a rotor."""
    test, revolutions = TESTS[kind], revolutions_of(rotor, scale[PLACE - 1])

    def follow(unknowns: Values) -> Shot:
        return shot_of(rotor, unknowns, names, stop)

    gradient = _Gradient(lambda unknowns: test(follow(unknowns)), scale)

    def equations(unknowns: Values, shot: Shot, direction: Values) -> tuple[Values, Values]:
        miss, matrix = closing_equations(shot, direction, names, revolutions)
        slopes = gradient.near(unknowns, test(shot))
        return np.append(miss, -test(shot)), np.vstack([matrix, slopes])

    return Problem(
        follow,
        equations,
        _checked_torus if kind == TORUS else checked_cycle,
        {CUSP: _turning},
        COUNTS,
        autonomous=rotor.load == 0.0,
    )


def _checked_torus(shot: Shot) -> Cycle:
    """Return an orbit as a limit cycle with a complex pair of multipliers on the unit circle."""
    cycle = checked_cycle(shot)
    if not on_unit_circle(shot):
        raise failure(shot, "the pair of multipliers on the unit circle has become real")
    return cycle


class _Gradient:
    """The derivatives of a test function by the unknowns, kept while these do not move.

    Newton's method needs them to find its way, not to say where it has come to.
    """

    def __init__(self, function: Callable[[Values], float], scale: Values) -> None:
        self._function, self._scale = function, scale
        self._place, self._gradient = np.full(scale.size, math.inf), np.empty(scale.size)

    def near(self, unknowns: Values, here: float) -> Values:
        """Return the derivatives at unknowns, where the function is `here`."""
        if not (np.abs(unknowns - self._place) <= KEPT_WITHIN * np.abs(self._scale)).all():
            self._place = unknowns
            for place, step in enumerate(DIFFERENCE * self._scale):
                beside = unknowns.copy()
                beside[place] += step
                change = self._function(beside) - here
                self._gradient[place] = change / (beside[place] - unknowns[place])
        return self._gradient.copy()


def _turning(point: Point[Shot], last: Point[Shot]) -> float:
    """Return how far the parameters move as they did at the point before; 0 at a cusp."""
    return float(point.tangent[PLACE:] @ last.tangent[PLACE:])
