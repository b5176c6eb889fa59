"""Follow a rotor to its steady state, and decide the kind of its response."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State
from rotor_ida.equations.model import rotated
from rotor_ida.errors import SimulationError
from rotor_ida.parallel import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.sweeps.response import UNRESOLVED, Features, classify, features_of

Values = npt.NDArray[np.float64]

FAILED = "failed"
# A transient that decays like exp(-zeta t) has fallen by 4e-11 after this many 1/zeta.
DECAY_TIMES = 24.0
LONGEST_FIRST_WAIT = 2000.0
# The final window holds whole revolutions: so many at least, and so much time at least.
WINDOW_REVOLUTIONS = 4
WINDOW_TIME = 40.0
SAMPLES_PER_REVOLUTION = 64
SAMPLES_PER_TIME = 16
# A whirl counts as steady when it strays from its mean by less than this part of it, or by
# less than this many tolerances.
STEADY = 1e-9
STEADY_TOLERANCES = 10.0


@dataclass(frozen=True, slots=True)
class SettledResponse:
    """The response on which a rotor has settled, and the events on the way to it.

    Parameters
    ----------
    response : str
        One of the kinds of `rotor_ida.sweeps.response`, or ``"failed"``.
    window : Features or None
        The motion over the final window; None if the run failed.
    window_start, window_end : float
        The final window [1].
    event_times, event_kinds : ndarray, shape (m,)
        All contact events from the start on [1].
    event_states : ndarray, shape (m, 4)
        States at the events, fixed frame [1].
    end : tuple of float
        State at the end, on the rotating axes [1].
    message : str
        Why the run failed; empty if it did not.
    """

    response: str
    window: Features | None
    window_start: float
    window_end: float
    event_times: Values
    event_kinds: npt.NDArray[np.int8]
    event_states: Values
    end: State
    message: str = ""


@dataclass(slots=True)
class _Trajectory:
    """The runs made so far, each from the end of the one before, on the rotating axes."""

    rotor: Rotor
    options: Options
    state: State
    stop: Stop | None = None
    time: float = 0.0
    event_times: list[Values] = field(default_factory=lambda: [np.empty(0)])
    event_kinds: list[npt.NDArray[np.int8]] = field(
        default_factory=lambda: [np.empty(0, dtype=np.int8)]
    )
    event_states: list[Values] = field(default_factory=lambda: [np.empty((0, 4))])

    def extend(self, duration: float, samples: int) -> Orbit:
        """Simulate from the end of the run before, where time and phase count as 0 again."""
        times = np.linspace(0.0, duration, samples) if samples else np.empty(0)
        orbit = run(self.rotor, self.state, duration, times, self.options, stop=self.stop)
        omega = self.rotor.omega
        self.event_times.append(self.time + orbit.event_times)
        self.event_kinds.append(orbit.event_kinds)
        self.event_states.append(rotated(orbit.event_states, np.float64(omega * self.time)))
        x, y, vx, vy = rotated(orbit.end, -omega * duration).tolist()
        self.state = (x, y, vx, vy)
        self.time += duration
        return orbit

    def settled(
        self, response: str, window: Features | None, window_start: float, message: str = ""
    ) -> SettledResponse:
        """Return the settled response."""
        return SettledResponse(
            response=response,
            window=window,
            window_start=window_start,
            window_end=self.time,
            event_times=np.concatenate(self.event_times),
            event_kinds=np.concatenate(self.event_kinds),
            event_states=np.concatenate(self.event_states),
            end=self.state,
            message=message,
        )


def follow_to_steady_state(
    rotor: Rotor,
    start: State,
    options: Options,
    *,
    doublings: int = 3,
    stop: Stop | None = None,
) -> SettledResponse:
    """Follow a rotor until the kind of its response is decided, or no doubling is left.

    The motion is classified over a final window: first after the time in which damping should
    have settled it, then each time its duration has doubled. A whirl of constant radius in
    contact, or one that has left the ring for good, is decided at once; any other motion only
    if its swing is the same as in the window before.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : tuple of float
        ``(x, y, vx, vy)`` on the rotating axes, which at time 0 are the fixed ones [1].
    options : Options
        How to simulate.
    doublings : int
        How often the duration may be doubled.
    stop : ndarray, shape (1,), optional
        Ends the run, as failed, as soon as it holds anything but 0.
    """
    trajectory = _Trajectory(rotor, options, start, stop)
    wait, length, samples = durations(rotor)
    earlier: Features | None = None
    began = 0.0
    try:
        for attempt in range(doublings + 1):
            trajectory.extend(wait if attempt == 0 else trajectory.time, 0)
            began = trajectory.time
            orbit = trajectory.extend(length, samples)
            ends_in_contact = orbit.starts_in_contact != bool(orbit.event_times.size % 2)
            window = features_of(
                rotor,
                orbit.times,
                orbit.states,
                orbit.event_times,
                ends_in_contact=ends_in_contact,
                steady=max(STEADY, STEADY_TOLERANCES * options.rtol),
            )
            response = classify(earlier, window, time=began)
            if response != UNRESOLVED:
                break
            earlier = window
        return trajectory.settled(response, window, began)
    except SimulationError as error:
        return trajectory.settled(FAILED, None, math.nan, str(error))


def failed(start: State, reason: str) -> SettledResponse:
    """Return the failed response of a rotor that could not be followed from `start`."""
    return SettledResponse(
        response=FAILED,
        window=None,
        window_start=math.nan,
        window_end=0.0,
        event_times=np.empty(0),
        event_kinds=np.empty(0, dtype=np.int8),
        event_states=np.empty((0, 4)),
        end=start,
        message=reason,
    )


def durations(rotor: Rotor) -> tuple[float, float, int]:
    """Return the first wait, the length of the window and its number of samples."""
    decay = DECAY_TIMES * max(1.0 / rotor.zeta, rotor.zeta) if rotor.zeta > 0.0 else math.inf
    wait = min(decay, LONGEST_FIRST_WAIT)
    if rotor.omega == 0.0:
        return wait, WINDOW_TIME, int(WINDOW_TIME * SAMPLES_PER_TIME) + 1
    revolution = 2.0 * math.pi / rotor.omega
    count = max(WINDOW_REVOLUTIONS, math.ceil(WINDOW_TIME / revolution))
    each = max(SAMPLES_PER_REVOLUTION, math.ceil(SAMPLES_PER_TIME * revolution))
    return wait, count * revolution, count * each + 1
