"""Motion integrated in displacement and velocity: where there is no contact law to smooth.

Two cases use it: a rotor without clearance, which never leaves contact, and the plain variant
of flight, ``flight="cvode"``, which integrates what `flight` solves in closed form and stands
beside it as a witness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.model import rotating_field_into, rotating_jacobian_into
from rotor_ida.parameters import Rotor
from rotor_ida.simulator.options import Options
from rotor_ida.simulator.solver import Integration, integrate

Values = npt.NDArray[np.float64]

NEVER = math.inf
# A rise of the radius by less than this part of it is rounding.
NOISE = 1e-13


@dataclass(frozen=True, slots=True)
class Passage:
    """Motion on the rotating axes up to a touch of the ring or the end of the run.

    Parameters
    ----------
    time : float
        When it ended, counted from its start [1].
    end : ndarray, shape (4,)
        ``(x, y, vx, vy)`` there.
    touched : bool
        Whether it ended with a touch.
    samples : ndarray, shape (n, 4)
        States at the sample times inside it.
    peak_time : float
        When it was farthest from the bearing axis [1].
    peak : ndarray, shape (4,)
        The state there.
    evaluations : int
        Evaluations of the right-hand side.
    """

    time: float
    end: Values
    touched: bool
    samples: Values
    peak_time: float
    peak: Values
    evaluations: int


def follow(
    rotor: Rotor,
    start: Values,
    duration: float,
    slack: float,
    samples: Values,
    options: Options,
) -> Passage:
    """Integrate until the rotor touches the ring from inside or `duration` has passed.

    With ``delta0 = 0`` there is nothing to touch and it runs to the end.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : ndarray, shape (4,)
        ``(x, y, vx, vy)`` on the rotating axes, with ``|z| <= delta0`` if ``delta0 > 0``.
    duration : float
        Longest time to follow it [1].
    slack : float
        How far behind `duration` a touch may lie and still count as being at it [1].
    samples : ndarray, shape (n,)
        Times to report [1], increasing.
    options : Options
        Method and tolerances.

    Raises
    ------
    SolverFailure
        If the solver gives up.
    """
    motion = _set_on_its_way(rotor, start, options)
    peak_time, peak = 0.0, start
    rows: list[Values] = []
    while True:
        motion.advance()
        touch = _touch_in_step(motion, rotor.delta0) if rotor.delta0 > 0.0 else NEVER
        touched = touch <= duration + slack
        end = touch if touched else min(motion.point, duration)
        peak_time, peak = _peak_in_step(motion, end, peak_time, peak)
        for time in samples[len(rows) :]:
            if time > end:
                break
            rows.append(motion.at(float(time)))
        if touched or end >= duration:
            taken = np.array(rows) if rows else np.empty((0, 4))
            state = motion.at(end)
            return Passage(end, state, touched, taken, peak_time, peak, motion.evaluations)


def _set_on_its_way(rotor: Rotor, start: Values, options: Options) -> Integration:
    omega, zeta, delta0 = rotor.omega, rotor.zeta, rotor.delta0

    def field(state: Values, rate: Values) -> None:
        rotating_field_into(state, rate, omega, zeta, delta0)

    def jacobian(state: Values, matrix: Values) -> None:
        rotating_jacobian_into(state, matrix, omega, zeta, delta0)

    return integrate(field, start, options, jacobian=jacobian)


def _touch_in_step(motion: Integration, delta0: float) -> float:
    """Return where in the last step the radius first rises through delta0, or infinity.

    A rise and fall inside the step shows in the radial velocity: it changes from + to - there,
    and the radius at its root tells. A fall and rise, which is how a step that starts on the
    ring may look, shows likewise; where rounding hides the fall, the turn itself is the touch.
    """

    def outside(state: Values) -> float:
        return _radius(state) - delta0

    low, high = motion.low, motion.point
    turn = low
    rising = _radial(motion.before)
    if rising * _radial(motion.values) < 0.0:
        turn = motion.root(_radial, low, high)
        if rising > 0.0:
            high = turn
        elif outside(motion.at(turn)) < 0.0:
            low = turn
    if outside(motion.at(high)) <= 0.0:
        return NEVER
    if outside(motion.at(low)) >= 0.0:
        leaves = _radial(motion.at(high)) > 0.0
        return max(turn, 0.5 * (low + high)) if leaves else NEVER
    return motion.root(outside, low, high)


def _peak_in_step(
    motion: Integration, end: float, time: float, peak: Values
) -> tuple[float, Values]:
    """Return when the radius was largest so far, and the state then.

    On a whirl of constant radius the radial velocity is rounding noise; there is nothing to
    look for.
    """
    reached = motion.at(end)
    rising = _radial(motion.before)
    could_reach = _radius(motion.before) ** 2 + 2.0 * rising * (end - motion.low)
    if rising > 0.0 > _radial(reached) and could_reach > _radius(peak) ** 2 * (1.0 + NOISE):
        end = motion.root(_radial, motion.low, end)
        reached = motion.at(end)
    return (end, reached) if _radius(reached) > _radius(peak) else (time, peak)


def _radius(state: Values) -> float:
    return math.hypot(state[0], state[1])


def _radial(state: Values) -> float:
    """Return ``r r'`` of a state in either frame."""
    return float(state[0] * state[2] + state[1] * state[3])
