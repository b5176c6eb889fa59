"""Close an orbit by Newton's method: single shooting across all entries and exits.

The unknowns are a state s and the period T. With the flow phi,

    phi(s, T) = s,    f(s0) . (s - s0) = 0,

The second is needed because any shift along the cycle solves the first: the state may not move
along the field at the present one. Without contact there is no cycle: a motion inside the clearance
closes too, on a circle about the centre of its whirl, but belongs to a neutral family.

Under a load the motion is not autonomous on the rotating axes: it repeats itself after whole
revolutions, ``T = k 2 pi/omega``, and begins where the load points down on these axes. Then the
period is known, no shift along the cycle solves the equations, and only the state is unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import RunRequest, follow_run
from rotor_ida.errors import SimulationError
from rotor_ida.model.contact import contact_force
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.neighbours import ATOL, MAXIMUM, RTOL, Shot, shoot

# Largest number of Newton steps; a distant guess needs some of them to come near.
MOST_STEPS = 25
# Largest relative change of state or period in a step: beyond it the linear equations fail.
LONGEST_STEP = 0.25
# A step this small, relative to state and period, leaves an error of its square, below rounding.
CONVERGED = 1e-9
# A step this small and no smaller than the one before is the last too: rounding limits it.
STALLED = 1e3 * CONVERGED
# Largest relative gap of a closed orbit, times the size of M, which amplifies rounding at the
# start: a few thousand roundings.
LARGEST_MISS = 1e-12
# On the rotating axes a synchronous whirl is stationary: an orbit that moves by less than this
# fraction of its size in a unit of time is one, and its period is only rounding.
STANDSTILL = 1e-10
# So is one whose radius varies by at most this fraction: a hundred times `CONVERGED`.
LEAST_SWING = 1e-7
FOUND_A_WHIRL = "Newton's method came to a whirl of constant radius"
LEFT_THE_RING = "Newton's method came to a whirl inside the clearance"
# An orbit that returns to its start to this fraction before its end repeats a shorter cycle; the
# gap of a closed orbit is far smaller.
BACK_AT_START = 1e-8


@dataclass(frozen=True, slots=True)
class Cycle:
    """A closed orbit.

    Parameters
    ----------
    shot : Shot
        The orbit, followed for one period.
    residual : float
        Distance of its end from its start, relative to its size [1].
    """

    shot: Shot
    residual: float

    @property
    def rotor(self) -> Rotor:
        """The rotor."""
        return self.shot.rotor

    @property
    def state(self) -> Values:
        """``(x, y, vx, vy)`` on the rotating axes at its start [1]."""
        return self.shot.start

    @property
    def period(self) -> float:
        """Its period [1]."""
        return self.shot.duration

    @property
    def radius_min(self) -> float:
        """Smallest distance from the bearing axis [1]."""
        return float(min(self.shot.extrema["radius"].tolist()))

    @property
    def radius_max(self) -> float:
        """Largest distance from the bearing axis [1]."""
        return float(max(self.shot.extrema["radius"].tolist()))

    @property
    def contacts(self) -> int:
        """Number of contacts in a period; 0 where it has no entry."""
        return contacts_of(self.shot)

    @property
    def touches(self) -> bool:
        """Whether it is ever in contact."""
        return self.rotor.delta0 == 0.0 or self.radius_max > self.rotor.delta0

    @property
    def response(self) -> str:
        """Kind of response: ``bouncing``, ``full_contact``, or ``rolling`` where it is dry whip."""
        if self.contacts:
            return "bouncing"
        return "rolling" if self.shot.rolls and self._is_backward else "full_contact"

    @property
    def _is_backward(self) -> bool:
        """Whether it whirls backwards, by its angular momentum at all extrema of the radius."""
        x, y, vx, vy = self.shot.extrema["state"].T
        return bool((x * vy - y * vx).max() < 0.0)

    @property
    def largest_force(self) -> float:
        """Largest contact force [1]."""
        if self.rotor.contact_damping > 0.0:
            return float(np.nanmax(self.shot.contacts["largest_force"]))
        exponent = self.rotor.contact_exponent
        return float(contact_force(self.radius_max, self.rotor.delta0, exponent))

    @property
    def impulse(self) -> float:
        """Impulse of the contact force in a period [1]; NaN without clearance."""
        parts = self.shot.contacts["impulse"]
        return float(np.nansum(parts)) if self.rotor.delta0 > 0.0 else math.nan


def contacts_of(shot: Shot) -> int:
    """Return the number of contacts on a closed orbit; 0 where it has no entry.

    If it begins and ends at an entry or an exit, rounding may omit one of these.
    """
    return max(sum(map(math.isfinite, shot.contacts[name].tolist())) for name in ("entry", "exit"))


def close_orbit(
    rotor: Rotor, state: Values, period: float, stop: Stop, rtol: float = RTOL
) -> Cycle:
    """Return the limit cycle near a state on the rotating axes, shape (4,), and a period.

    Under a load the period is rounded to whole revolutions.

    Raises
    ------
    SimulationError
        If Newton's method does not converge, or to no limit cycle.
    """
    if rotor.load > 0.0:
        period = period_of(rotor, revolutions_of(rotor, period))
    shot = shoot(rotor, state, period, stop, rtol)
    last = math.inf
    for _ in range(MOST_STEPS):
        step = _newton_step(shot)
        size = _relative_size(step, shot)
        if size > STALLED and _closes(shot):  # at a fold: rounding, divided by nothing
            return checked_cycle(shot)
        if size > LONGEST_STEP:
            step *= LONGEST_STEP / size
        before = shot
        shot = shoot(rotor, shot.start + step[:4], shot.duration + step[4], stop, rtol)
        if size <= CONVERGED or (size < STALLED and size >= last):
            # near a fold or a corner the last step may lead away again
            return checked_cycle(shot if _closes(shot) else before)
        last = size
    raise failure(shot, f"Newton's method found no limit cycle in {MOST_STEPS} steps")


def revolutions_of(rotor: Rotor, period: float) -> int:
    """Return the number of revolutions, at least one, nearest to a period."""
    return max(1, round(period * rotor.omega / (2.0 * math.pi)))


def period_of(rotor: Rotor, revolutions: int) -> float:
    """Return the time of a number of revolutions [1]."""
    return revolutions * 2.0 * math.pi / rotor.omega


def once_round(cycle: Cycle, stop: Stop) -> Cycle:
    """Return a limit cycle over its smallest period, if it was followed over several."""
    most = 1 + int((cycle.shot.extrema["kind"] == MAXIMUM).sum())
    loaded, revolutions = cycle.rotor.load > 0.0, revolutions_of(cycle.rotor, cycle.period)
    for times in range(revolutions if loaded else most, 1, -1):
        if loaded and revolutions % times:
            continue
        part = shoot(cycle.rotor, cycle.state, cycle.period / times, stop)
        if np.linalg.norm(part.end - part.start) <= BACK_AT_START * np.linalg.norm(part.start):
            return close_orbit(cycle.rotor, cycle.state, cycle.period / times, stop)
    return cycle


def checked_cycle(shot: Shot) -> Cycle:
    """Return an orbit as a limit cycle.

    Raises
    ------
    SimulationError
        If it does not close, is a whirl of constant radius, or never touches the stator.
    """
    residual = _residual(shot)
    if not _closes(shot):
        raise failure(shot, f"the orbit misses its start by {residual:.3g} of its size")
    if not len(shot.extrema):
        raise failure(shot, FOUND_A_WHIRL)
    cycle = Cycle(shot, residual)
    largest = cycle.radius_max
    if largest - cycle.radius_min <= LEAST_SWING * largest:
        raise failure(shot, FOUND_A_WHIRL)
    if not cycle.touches:
        raise failure(shot, LEFT_THE_RING)
    return cycle


def _closes(shot: Shot) -> bool:
    """Return whether an orbit returns to its start, up to rounding."""
    return _residual(shot) <= LARGEST_MISS * max(math.hypot(*shot.monodromy.flat), 1.0)


def _residual(shot: Shot) -> float:
    """Return the distance of the end of an orbit from its start, relative to its size."""
    return math.hypot(*(shot.end - shot.start)) / (math.hypot(*shot.start) or 1.0)


def failure(shot: Shot, reason: str) -> SimulationError:
    """Return the error of a Newton iteration that ended at `shot`."""
    x, y, vx, vy = shot.start.tolist()
    return SimulationError(
        f"{reason}: period {shot.duration:.9g}, omega {shot.rotor.omega:.9g}, "
        f"zeta {shot.rotor.zeta:.9g}, delta0 {shot.rotor.delta0:.9g}",
        time=0.0, state=(x, y, vx, vy),
    )  # fmt: skip


def _newton_step(shot: Shot) -> Values:
    """Return the step of state and period, shape (5,); under a load that of the period is 0."""
    if shot.rotor.load > 0.0:
        return np.append(_solved(shot, shot.monodromy - np.eye(4), shot.start - shot.end), 0.0)
    matrix = np.zeros((5, 5))
    rate = shot.start_rate
    speed = float(np.linalg.norm(rate))
    if speed <= STANDSTILL * float(np.linalg.norm(shot.start)):
        raise failure(shot, FOUND_A_WHIRL)
    matrix[:4, :4] = shot.monodromy - np.eye(4)
    matrix[:4, 4] = shot.end_rate
    matrix[4, :4] = rate / speed
    return _solved(shot, matrix, np.append(shot.start - shot.end, 0.0))


def _solved(shot: Shot, matrix: Values, miss: Values) -> Values:
    """Return the solution of the linear equations of a step."""
    try:
        step = np.asarray(np.linalg.solve(matrix, miss), dtype=np.float64)
    except np.linalg.LinAlgError:
        step = np.asarray(np.linalg.lstsq(matrix, miss)[0], dtype=np.float64)
    if not np.isfinite(step).all():
        raise failure(shot, "Newton's method reached an orbit whose neighbours close as well")
    return step


def _relative_size(step: Values, shot: Shot) -> float:
    """Return the size of a step relative to state and period."""
    scale = float(np.linalg.norm(shot.start)) or 1.0
    return max(float(np.linalg.norm(step[:4])) / scale, abs(float(step[4])) / shot.duration)


def sampled_orbit(rotor: Rotor, state: Values, span: float, count: int, stop: Stop) -> Values:
    """Return `count` states of an orbit, `span` apart, on the rotating axes, shape (count, 4)."""
    times = span * np.arange(count, dtype=np.float64)
    seen = follow_run(
        RunRequest(
            rotor=rotor, start=state, duration=float(times[-1]), rtol=RTOL, atol=ATOL * RTOL,
            sample_times=times, stop=stop,
        )
    )  # fmt: skip
    if seen.status != DONE:
        x, y, vx, vy = state.tolist()
        raise SimulationError(
            f"an orbit could not be followed: {message_of(seen.status)}",
            time=0.0, state=(x, y, vx, vy),
        )  # fmt: skip
    return seen.samples
