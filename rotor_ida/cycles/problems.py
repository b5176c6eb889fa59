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

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.cycles.birth import birth_between, oscillation
from rotor_ida.cycles.continuation import Curve, Point, Problem, shooting_equations
from rotor_ida.cycles.guess import DOUBLING, HOPF, Guess
from rotor_ida.cycles.multipliers import doubling_test, fold_test, on_unit_circle, torus_test
from rotor_ida.cycles.orbit import Orbit, followed
from rotor_ida.cycles.shooting import checked_cycle, closes, failure, periods_of
from rotor_ida.cycles.special_points import Count
from rotor_ida.errors import SimulationError
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.simulation.flow import Flow

FOLD, GRAZE, TORUS, SLIDING, CUSP = "fold", "graze", "torus", "sliding", "cusp"
TESTS: dict[str, Callable[[Orbit], float]] = {
    FOLD: fold_test,
    DOUBLING: doubling_test,
    TORUS: torus_test,
}
# Counts on an orbit; no function of the orbit is 0 where the second changes.
COUNTS: dict[str, Count] = {
    GRAZE: Count(lambda orbit: orbit.contacts, lambda orbit: orbit.nearest[0] / orbit.flow.length),
    SLIDING: Count(lambda orbit: orbit.sliding_changes, lambda _: math.inf),
}
# Names of the speed, on which the duration of a revolution depends.
SPEEDS = ("omega", SPEED)
# A rotor at zero speed or without damping has no cycles; one without a load has different ones. A
# system without clearance, stiffness or unbalance is another one.
NEVER_ZERO = ("omega", "zeta", "load", *set(PARAMETERS_OF_SYSTEM) - {"friction"})
# Parameters of which an orbit below 0, where there is no rotor, is extrapolated.
BELOW_ZERO = ("shaft_stiffness", "contact_damping", "friction", "disc_radius")
# Size of the oscillation, relative to that of the whirl, with which a branch leaves a Hopf point.
FIRST_SWING = 2e-2
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
class Continuation:
    """A branch of cycles, or a curve of bifurcations, to be followed.

    Parameters
    ----------
    line : Curve
        The curve that takes the steps.
    first : Point
        Its first point, directed forward.
    limits : dict of int to tuple of float
        The smallest and largest value of each parameter, by its index among the unknowns.
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

    line: Curve
    first: Point
    limits: dict[int, tuple[float, float]]
    most: int
    both: bool = True
    half: Problem | None = None
    birth: Callable[[Point, Point], Point | None] | None = None
    hint: Callable[[Orbit], str] = lambda _: ""

    @property
    def place(self) -> int:
        """Index of the (first) parameter among the unknowns, after the state and the period."""
        return self.first.orbit.start.size + 1


def halved(unknowns: Values, place: int) -> Values:
    """Return unknowns, the first parameter at a place, with half the period."""
    found = unknowns.copy()
    found[place - 1] *= 0.5
    return found


def branch_through(
    guess: Guess, parameter: str, limits: tuple[float, float], most: int
) -> Continuation:
    """Return the branch through a cycle, the doubled one at a doubling, or that of a Hopf point.

    The guess has a period. SimulationError if there is no branch.
    """
    flow, period, n = guess.flow, guess.period or math.nan, guess.state.size
    doubles = guess.special == DOUBLING
    scale = _scale(guess, period * (2.0 if doubles else 1.0), [parameter], [limits])
    times = periods_of(flow, scale[n])
    line = Curve(cycles_over(flow, parameter, times), scale)
    half = None if times % 2 else cycles_over(flow, parameter, times // 2)
    unknowns = np.array([*guess.state, period, flow.value_of(parameter)])
    if doubles:
        first = doubled(line, unknowns)
    elif guess.special == HOPF:
        first = _born(line, unknowns)
    else:
        first = line.first(unknowns)
        first = first.reversed() if guess.slope < 0.0 else first
    birth = partial(birth_between, name=parameter, problem=line.problem)
    return Continuation(
        line, first, {n + 1: limits}, most, both=not doubles, half=half,
        birth=birth if flow.period is None else None,
    )  # fmt: skip


def _born(line: Curve, unknowns: Values) -> Point:
    """Return a small cycle near the Hopf point of a whirl, directed away from it."""
    state, (period, place) = unknowns[:-2], unknowns[-2:].tolist()
    away = np.zeros(unknowns.size)
    away[: state.size] = oscillation(line.problem, state, period, place)
    return line.near(unknowns + FIRST_SWING * away * line.scale, away)


def bifurcations_through(
    guess: Guess,
    kind: str,
    names: tuple[str, str],
    limits: tuple[tuple[float, float], tuple[float, float]],
    most: int,
) -> Continuation:
    """Return the curve through a bifurcation."""
    values = [guess.flow.value_of(name) for name in names]
    period, place = guess.period or math.nan, guess.state.size + 1
    scale = _scale(guess, period, names, limits)
    line = Curve(_problem(guess.flow, kind, names, scale), scale)
    first = line.first(np.append(guess.state, (period, *values)))
    both = {place: limits[0], place + 1: limits[1]}
    return Continuation(line, first, both, most, hint=_corner_at_graze)


def _corner_at_graze(orbit: Orbit) -> str:
    """Return that a curve of bifurcations has a corner where a linear contact is just touched."""
    (gap, number), flow = orbit.nearest, orbit.flow
    part = abs(gap) / (float(flow.clearances[number]) or math.inf)
    if flow.exponents[number] != 1.0 or part > NEAR_A_GRAZE:
        return ""
    return (
        f"; the radius comes within {part:.2g} of the clearance of the stator, and at a graze of a "
        "linear contact the curve has a corner"
    )


def _scale(
    guess: Guess, period: float, names: Sequence[str], limits: Sequence[tuple[float, float]]
) -> Values:
    """Return the sizes of state, period and parameters, relative to which lengths are measured."""
    sizes = [
        abs(guess.flow.value_of(name)) or high - low
        for name, (low, high) in zip(names, limits, strict=True)
    ]
    return np.array([*[np.linalg.norm(guess.state)] * guess.state.size, period, *sizes])


# ---- Cycles over a parameter ----


def cycles_over(flow: Flow, parameter: str, revolutions: int) -> Problem:
    """Return the cycles of a flow over one of its parameters.

    If it closes after whole revolutions only they are those of the given number.
    """
    tests: dict[str, Callable[[Point, Point], float]] = {
        FOLD: lambda point, _last: fold_test(point.orbit),
        DOUBLING: lambda point, _last: doubling_test(point.orbit),
    }
    if may_have_tori(flow, parameter):
        tests[TORUS] = lambda point, _last: torus_test(point.orbit)
    return Problem(
        lambda unknowns: orbit_of(flow, unknowns, (parameter,)),
        lambda _unknowns, orbit, direction: closing_equations(
            orbit, direction, (parameter,), revolutions
        ),
        checked_cycle,
        tests,
        COUNTS,
        autonomous=flow.period is None,
        closes=closes,
    )


def may_have_tori(flow: Flow, *varied: str) -> bool:
    """Return whether a torus may be born from cycles with some parameters varied."""
    where = {"contact_damping", "friction", "load"}
    return flow.pair_product(1.0) is None or not where.isdisjoint(varied)


def closing_equations(
    orbit: Orbit, direction: Values, parameters: Sequence[str], revolutions: int
) -> tuple[Values, Values]:
    """Return the residuals of the equations of a cycle, and their derivatives by all unknowns.

    They are those of `shooting_equations`; or the last is ``T = k 2 pi/omega`` instead.
    """
    miss, matrix = shooting_equations(orbit, direction, *orbit.piece.by)
    if not orbit.is_autonomous:
        period, n = revolutions * orbit.flow.revolution, orbit.start.size
        miss[n], matrix[n] = period - orbit.duration, 0.0
        matrix[n, n] = 1.0
        for place, name in enumerate(parameters, start=n + 1):
            if name in SPEEDS:
                matrix[n, place] = period / orbit.flow.speed
    return miss, matrix


def orbit_of(
    flow: Flow, unknowns: Values, parameters: Sequence[str], *, differentiated: bool = True
) -> Orbit:
    """Return the orbit for a state, a period and some parameters, and its derivatives by these.

    Below 0, where there is no rotor, an orbit is extrapolated by its derivative at 0, so that a
    step may pass a limit there. SimulationError if a parameter is impossible or the orbit fails.
    """
    n = unknowns.size - len(parameters) - 1
    values, below = dict[str, float](), dict[str, float]()
    for name, value in zip(parameters, unknowns[n + 1 :].tolist(), strict=True):
        if value < 0.0 and name in BELOW_ZERO:
            below[name] = value
        elif name != SPEED and (value < 0.0 or (value == 0.0 and name in NEVER_ZERO)):
            raise SimulationError(f"{name} falls to {value:.3g}")
        values[name] = 0.0 if name in below else value
    by = parameters if differentiated else tuple(below)
    orbit = followed(flow.but(**values), unknowns[:n], float(unknowns[n]), by)
    for name, value in below.items():
        beside = orbit.end + value * orbit.piece.by[by.index(name)]
        orbit = replace(orbit, piece=orbit.piece._replace(end=beside))
    return orbit


def doubled(line: Curve, once: Values) -> Point:
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


def _half_misses(line: Curve, point: Point) -> float:
    """Return the distance after half a period from the start, relative to the size of the state."""
    start = point.orbit.start
    half = line.problem.shoot(halved(point.unknowns, start.size + 1))
    return float(np.linalg.norm(half.end - start) / np.linalg.norm(start))


# ---- Bifurcations over two ----


def _problem(flow: Flow, kind: str, names: tuple[str, str], scale: Values) -> Problem:
    """Return the bifurcations of a kind over two parameters of a flow."""
    test, revolutions = TESTS[kind], periods_of(flow, scale[-3])

    gradient = _Gradient(
        lambda unknowns: test(orbit_of(flow, unknowns, names, differentiated=False)), scale
    )

    def equations(unknowns: Values, orbit: Orbit, direction: Values) -> tuple[Values, Values]:
        miss, matrix = closing_equations(orbit, direction, names, revolutions)
        here = test(orbit)
        return np.append(miss, -here), np.vstack([matrix, gradient.near(unknowns, here)])

    return Problem(
        lambda unknowns: orbit_of(flow, unknowns, names),
        equations,
        _checked_torus if kind == TORUS else checked_cycle,
        {CUSP: _turning},
        COUNTS,
        autonomous=flow.period is None,
    )


def _checked_torus(orbit: Orbit) -> Orbit:
    """Return an orbit that is a cycle with a complex pair of multipliers on the unit circle."""
    cycle = checked_cycle(orbit)
    if not on_unit_circle(orbit):
        raise failure(orbit, "the pair of multipliers on the unit circle has become real")
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


def _turning(point: Point, last: Point) -> float:
    """Return the motion of the parameters along that at the previous point; 0 at a cusp."""
    return float(point.tangent[-2:] @ last.tangent[-2:])
