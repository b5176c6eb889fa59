"""Motion integrated in displacement and velocity: where there is no contact law to smooth.

Two cases use it: a rotor without clearance, which never leaves contact, and the plain variant
of flight, ``flight="cvode"``, which integrates what `flight` solves in closed form and stands
beside it as a witness.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.core.interface import DONE, NO_ROOT, STOPPED
from rotor_ida.simulation.reference.motion import Motion, root
from rotor_ida.simulation.reference.record import Record, next_sample, record_sample, time_left

Values = npt.NDArray[np.float64]

SIZE = 4
NEVER = math.inf
# A rise of the radius by less than this part of it is rounding.
NOISE = 1e-13


def follow(record: Record, motion: Motion) -> tuple[int, bool, float, Values, float, Values]:
    """Integrate until the rotor touches the ring from inside or the run is at its end.

    With ``delta0 = 0`` there is nothing to touch and it runs to the end. Samples are taken on
    the way.

    Parameters
    ----------
    record : Record
        The run, with ``|z| <= delta0`` now if ``delta0 > 0``.
    motion : Motion
        The integration of displacement and velocity on the rotating axes.

    Returns
    -------
    status : int
        0, or why the motion could not be followed.
    touched : bool
        Whether it ended with a touch.
    time : float
        When it ended, counted from now [1].
    end : ndarray, shape (4,)
        ``(x, y, vx, vy)`` there, on the rotating axes.
    peak_time : float
        When the rotor was farthest from the bearing axis, counted from now [1].
    peak : ndarray, shape (4,)
        The state there.
    """
    duration, here, moving = time_left(record), record.position, record.velocity
    start = np.array([here.real, here.imag, moving.real, moving.imag])
    peak_time, peak = 0.0, start.copy()
    end, state, touched = 0.0, start, False
    status = motion.restart(start, np.full(SIZE, record.atol))
    while status == DONE:
        status = STOPPED if record.stop[0] else motion.advance()
        if status != DONE:
            end, state = motion.low, motion.before.copy()
            break
        touch = _touch_in_step(motion, record.delta0) if record.delta0 > 0.0 else NEVER
        if math.isnan(touch):
            end, state, status = motion.low, motion.before.copy(), NO_ROOT
            break
        touched = touch <= duration + record.slack
        end = touch if touched else min(motion.point, duration)
        peak_time = _raise_peak(motion, end, peak_time, peak)
        while next_sample(record, duration) <= end:
            sample = motion.glance_at(next_sample(record, duration))
            record_sample(record, sample[0], sample[1], sample[2], sample[3])
        if touched or end >= duration:
            state = motion.at(end).copy()
            break
    record.evaluations += motion.evaluations()
    return status, touched, end, state, peak_time, peak


def _touch_in_step(motion: Motion, delta0: float) -> float:
    """Return where in the last step the radius first rises through delta0, or infinity.

    A rise and fall inside the step shows in the radial velocity: it changes from + to - there,
    and the radius at its root tells. A fall and rise, which is how a step that starts on the
    ring may look, shows likewise; where rounding hides the fall, the turn itself is the touch.
    """
    low, high = motion.low, motion.point
    turn = low
    rising = radial(motion.before)
    if rising * radial(motion.values) < 0.0:
        turn = root(motion, radial, 0.0, low, high)
        if rising > 0.0:
            high = turn
        elif radius(motion.at(turn)) < delta0:
            low = turn
    if radius(motion.at(high)) <= delta0:
        return NEVER
    if radius(motion.at(low)) >= delta0:
        leaves = radial(motion.at(high)) > 0.0
        return max(turn, 0.5 * (low + high)) if leaves else NEVER
    return root(motion, radius, delta0, low, high)


def _raise_peak(motion: Motion, end: float, time: float, peak: Values) -> float:
    """Write the state of largest radius so far into `peak`; return its time.

    On a whirl of constant radius the radial velocity is rounding noise; there is nothing to
    look for.
    """
    reached = motion.at(end)
    rising = radial(motion.before)
    could_reach = radius(motion.before) ** 2 + 2.0 * rising * (end - motion.low)
    if rising > 0.0 > radial(reached) and could_reach > radius(peak) ** 2 * (1.0 + NOISE):
        summit = root(motion, radial, 0.0, motion.low, end)
        end = summit if summit > motion.low else end
        reached = motion.at(end)
    if radius(reached) <= radius(peak):
        return time
    peak[:] = reached
    return end


def radius(state: Values) -> float:
    """Return ``|z|``; square root and not hypot, whose last digit differs in compiled code."""
    return math.sqrt(state[0] * state[0] + state[1] * state[1])


def radial(state: Values) -> float:
    """Return ``r r'`` of a state in either frame."""
    return float(state[0] * state[2] + state[1] * state[3])
