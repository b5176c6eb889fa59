"""Curves of limit cycles to follow: cycles over a parameter, bifurcations over two.

A curve of bifurcations satisfies one more condition beside the shooting equations: a test function
of the monodromy matrix M is 0, ``2 (1 + q) - tr M`` for a fold or ``tr M`` for a doubling. For a
torus and in general, see `rotor_ida.cycles.multipliers`. The test function is smooth, and no
eigenvalue has to be followed. At a cusp, where two folds meet, the curve turns back in the plane of
the parameters, though not in the space of all unknowns. A curve of torus points ends where the pair
on the unit circle becomes real, at 1 or -1.

If the stiffness or damping of the contact begins abruptly, M changes like a root beyond a graze: at
the stator in a linear contact, and at the state in which a damped contact is just not lost. There
such a curve has a corner, and may end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.core.runs import COLUMNS
from rotor_ida.cycles.birth import DiscWhirl, birth_between
from rotor_ida.cycles.continuation import Curve, Point, Problem, shooting_equations
from rotor_ida.cycles.guess import DOUBLING, Guess
from rotor_ida.cycles.multipliers import doubling_test, fold_test, on_unit_circle, torus_test
from rotor_ida.cycles.shooting import (
    Cycle,
    checked_cycle,
    contacts_of,
    failure,
    period_of,
    revolutions_of,
)
from rotor_ida.cycles.special_points import Count, O
from rotor_ida.errors import SimulationError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.neighbours import Shot, shoot
from rotor_ida.simulation.orbit import REVERSE, ROLL

FOLD, GRAZE, TORUS, SLIDING, CUSP = "fold", "graze", "torus", "sliding", "cusp"
TESTS: dict[str, Callable[[Shot], float]] = {
    FOLD: fold_test,
    DOUBLING: doubling_test,
    TORUS: torus_test,
}
# Index of the (first) parameter among the unknowns, after the state and the period.
PLACE = 5
# A rotor at zero speed or without damping has no cycles; one without a load has different ones.
NEVER_ZERO = ("omega", "zeta", "load")
# If a curve of bifurcations ends this near a graze, relative to the clearance, that is the reason.
NEAR_A_GRAZE = 1e-4
# At a period doubling, doubled cycles are sought at these distances, relative to the size of the
# state, in turn: close to where they branch off, then farther and nearer if Newton's method falls
# back.
ASIDE = (1e-3, 3e-3, 1e-2, 3e-4, 1e-4, 3e-5)
# A cycle found there is doubled if after half its period it misses its start by this fraction of
# that distance.
STILL_ASIDE = 0.1
# Step of the finite differences of a test function, relative to the scales: about the root of
# rounding, and short compared with the kink of the trace at a graze.
DIFFERENCE = 1e-8
# The derivatives are reused until an unknown has moved by a step: near a graze they are unbounded.
KEPT_WITHIN = 1e-8


@dataclass(frozen=True, slots=True)
class Continuation(Generic[O]):
    """A branch of cycles, or a curve of bifurcations, to be followed.

    Parameters
    ----------
    line : Curve
        The curve that takes the steps.
    name : str
        The (first) parameter.
    first : Point
        Its first point, directed forward.
    limits : dict of int to tuple of float
        The smallest and largest value [1] of each parameter, by its index among the unknowns.
    most : int
        The largest number of points.
    both : bool
        Whether it is followed both ways; from a period doubling there is only one.
    half : Problem, optional
        The cycles of half the period, which those of the branch may reach.
    birth : callable, optional
        Returns the cycle at which the branch is born between two points, or None.
    hint : callable
        What an orbit adds to the reason why no further step was possible.
    """

    line: Curve[O]
    name: str
    first: Point[O]
    limits: dict[int, tuple[float, float]]
    most: int
    both: bool = True
    half: Problem[O] | None = None
    birth: Callable[[Point[O], Point[O]], Point[O] | None] | None = None
    hint: Callable[[O], str] = lambda _: ""

    @property
    def place(self) -> int:
        """Index of the (first) parameter among the unknowns, after the state and the period."""
        return self.first.stretch.start.size + 1


def halved(unknowns: Values, place: int) -> Values:
    """Return unknowns, the first parameter at a place, with half the period."""
    found = unknowns.copy()
    found[place - 1] *= 0.5
    return found


def branch_through(
    guess: Guess, parameter: str, limits: tuple[float, float], most: int, stop: Stop
) -> Continuation[Shot]:
    """Return the branch through a cycle, or the doubled one that leaves it at a doubling.

    The guess has a period. SimulationError if there is no branch.
    """
    rotor, period = guess.rotor, guess.period or math.nan
    value = getattr(rotor, parameter)
    doubles = guess.special == DOUBLING
    scale = _scale(guess, period * (2.0 if doubles else 1.0), [value], [limits])
    times = revolutions_of(rotor, scale[4])
    line = Curve(cycles_over(rotor, parameter, stop, times), scale)
    half = None if times % 2 else cycles_over(rotor, parameter, stop, times // 2)
    near = partial(DiscWhirl, name=parameter)
    birth = partial(birth_between, whirl_near=near, problem=line.problem)
    if doubles:
        first = doubled(line, np.append(guess.state, (period, value)))
    else:
        first = line.first(np.append(guess.state, (period, value)))
        first = first.reversed() if guess.slope < 0.0 else first
    return Continuation(
        line, parameter, first, {PLACE: limits}, most, both=not doubles, half=half,
        birth=birth if rotor.load == 0.0 else None,
    )  # fmt: skip


def bifurcations_through(
    guess: Guess,
    kind: str,
    names: tuple[str, str],
    limits: tuple[tuple[float, float], tuple[float, float]],
    most: int,
    stop: Stop,
) -> Continuation[Shot]:
    """Return the curve through a bifurcation."""
    values = [getattr(guess.rotor, name) for name in names]
    period = guess.period or math.nan
    scale = _scale(guess, period, values, limits)
    line = Curve(_problem(guess.rotor, kind, names, scale, stop), scale)
    first = line.first(np.append(guess.state, (period, *values)))
    both = {PLACE: limits[0], PLACE + 1: limits[1]}
    return Continuation(line, names[0], first, both, most, hint=_corner_at_graze)


def _corner_at_graze(shot: Shot) -> str:
    """Return that a curve of bifurcations has a corner where a linear contact is just touched."""
    gap, rotor = nearest_gap(shot), shot.rotor
    if rotor.contact_exponent != 1.0 or abs(gap) > NEAR_A_GRAZE * rotor.delta0:
        return ""
    return (
        f"; the radius comes within {abs(gap):.2g} of the stator, and at a graze of a linear "
        "contact the curve has a corner"
    )


def _scale(
    guess: Guess,
    period: float,
    values: Sequence[float],
    limits: Sequence[tuple[float, float]],
) -> Values:
    """Return the sizes of state, period and parameters, relative to which lengths are measured."""
    sizes = [value or high - low for value, (low, high) in zip(values, limits, strict=True)]
    return np.array([*[np.linalg.norm(guess.state)] * 4, period, *sizes])


# ---- Cycles over a parameter ----


def nearest_gap(shot: Shot) -> float:
    """Return the extremum of the radius nearest to the stator, less the clearance: 0 at a graze."""
    gaps: list[float] = (shot.extrema["radius"] - shot.rotor.delta0).tolist()
    return min(gaps, key=abs)


def changes_of(shot: Shot) -> int:
    """Return the number of times the disc begins to roll, or slides the other way, on an orbit."""
    return int(np.isin(shot.event_kinds, (ROLL, REVERSE)).sum())


# Counts on an orbit; no function of the orbit is 0 where the second changes.
COUNTS = {
    GRAZE: Count(contacts_of, nearest_gap),
    SLIDING: Count(changes_of, lambda _shot: math.inf),
}


def cycles_over(rotor: Rotor, parameter: str, stop: Stop, revolutions: int) -> Problem[Shot]:
    """Return the cycles of a rotor over one of its parameters.

    Under a load they are those of the given number of revolutions.
    """
    tests: dict[str, Callable[[Point[Shot], Point[Shot]], float]] = {
        FOLD: lambda point, _last: fold_test(point.stretch),
        DOUBLING: lambda point, _last: doubling_test(point.stretch),
    }
    if may_have_tori(rotor, parameter):
        tests[TORUS] = lambda point, _last: torus_test(point.stretch)
    return Problem(
        lambda unknowns: shot_of(rotor, unknowns, (parameter,), stop),
        lambda _unknowns, shot, direction: closing_equations(
            shot, direction, (parameter,), revolutions
        ),
        checked_cycle,
        tests,
        COUNTS,
        autonomous=rotor.load == 0.0,
    )


def may_have_tori(rotor: Rotor, *varied: str) -> bool:
    """Return whether a torus may be born from cycles of a rotor with some parameters varied."""
    where = ("contact_damping", "friction", "load")
    return any(name in varied or getattr(rotor, name) > 0.0 for name in where)


def closing_equations(
    shot: Shot, direction: Values, parameters: Sequence[str], revolutions: int
) -> tuple[Values, Values]:
    """Return the residuals of the equations of a cycle, and their derivatives by all unknowns.

    They are those of `shooting_equations`; under a load the last is ``T = k 2 pi/omega`` instead.
    """
    columns = [COLUMNS.index(name) for name in parameters]
    miss, matrix = shooting_equations(shot, direction, *shot.by_parameter[:, columns].T)
    if shot.rotor.load > 0.0:
        period = period_of(shot.rotor, revolutions)
        miss[4], matrix[4] = period - shot.duration, 0.0
        matrix[4, 4] = 1.0
        for place, name in enumerate(parameters, start=PLACE):
            if name == "omega":
                matrix[4, place] = period / shot.rotor.omega
    return miss, matrix


def shot_of(rotor: Rotor, unknowns: Values, parameters: Sequence[str], stop: Stop) -> Shot:
    """Return the orbit for a state, a period and some parameters.

    Below 0, where there is no rotor, the orbit is extrapolated by its derivative at 0, so that a
    step may pass a limit there. SimulationError if a parameter is impossible or the orbit fails.
    """
    values, below = dict[str, float](), dict[str, float]()
    for name, value in zip(parameters, unknowns[5:].tolist(), strict=True):
        if value < 0.0 and name not in PARAMETERS:
            below[name] = value
        elif value < 0.0 or (value == 0.0 and name in NEVER_ZERO):
            raise SimulationError(f"{name} falls to {value:.3g}")
        values[name] = max(value, 0.0)
    here, whole = replace(rotor, **values), any(name not in PARAMETERS for name in parameters)
    shot = shoot(here, unknowns[:4], float(unknowns[4]), stop, whole=whole)
    for name, value in below.items():
        shot = replace(shot, end=shot.end + value * shot.by_parameter[:, COLUMNS.index(name)])
    return shot


def doubled(line: Curve[O], once: Values) -> Point[O]:
    """Return a point of the doubled branch near a period doubling, directed away from it.

    Its cycles branch off along the eigenvector of the multiplier -1. `once` has state, period and
    parameter of the doubling.
    """
    orbit, n = line.problem.shoot(once), once.size - 2
    multipliers, vectors = np.linalg.eig(orbit.monodromy)
    aside = np.real(vectors[:, np.argmin(np.abs(multipliers + 1.0))])
    if line.problem.autonomous:
        rate = orbit.start_rate
        aside -= (aside @ rate) / (rate @ rate) * rate
    away, twice = np.zeros(n + 2), once.copy()
    away[:n] = aside / np.linalg.norm(aside)
    twice[n] *= 2.0
    for part in ASIDE:
        try:
            point = line.near(twice + part * away * line.scale, away)
        except SimulationError:
            continue
        if _half_misses(line, point) > STILL_ASIDE * part:
            return point
    raise SimulationError(f"no doubled cycle was found near the one of period {once[n]:.9g}")


def _half_misses(line: Curve[O], point: Point[O]) -> float:
    """Return the distance after half a period from the start, relative to the size of the state."""
    start = point.stretch.start
    half = line.problem.shoot(halved(point.unknowns, start.size + 1))
    return float(np.linalg.norm(half.end - start) / np.linalg.norm(start))


# ---- Bifurcations over two ----


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

    Newton's method needs them only to converge; they do not affect its solution.
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
    """Return the motion of the parameters along that at the previous point; 0 at a cusp."""
    return float(point.tangent[PLACE:] @ last.tangent[PLACE:])
