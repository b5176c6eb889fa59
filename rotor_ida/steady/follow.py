"""Follow a rotor to its steady state, and decide the kind of its response."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ROUNDING, Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.runs import Rows
from rotor_ida.errors import SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.lyapunov import exponents_of
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import ENTRY, Orbit, stretches_of_rolling
from rotor_ida.simulation.run import run
from rotor_ida.steady.periods import (
    SAME_TURN,
    Recurrence,
    TurningPoints,
    extreme_radii,
    recurrence,
    recurrence_by_revolutions,
    slowest_multiplier,
    turning_points,
)
from rotor_ida.steady.response import (
    BOUNCING,
    CHAOTIC,
    CONTACT_FREE,
    FULL_CONTACT,
    QUASI_PERIODIC,
    ROLLING,
    STEADY,
    SYNCHRONOUS,
    TOUCHING,
    UNRESOLVED,
    Features,
    Window,
    kind_at_rest,
    phase_lag_of,
    rolls_backwards,
    stays_free,
    touches_fade,
    touches_grow_slighter,
    whirls_steadily,
)

FAILED = "failed"
# A transient that decays like exp(-zeta t) has fallen by 4e-11 after this many 1/zeta.
DECAY_TIMES = 24.0
# Longest first wait, however slight the damping; later waits double.
LONGEST_FIRST_WAIT = 2000.0
# No window but the first begins after this many 1/zeta. As times double, the last one begins after
# half of it or more: exp(-zeta t) is 1e-13 by then.
LONGEST_DECAY_TIMES = 60.0
# This time is allowed however strong the damping is, for what settles more slowly, as near a fold;
LONGEST = 40_000.0
# and no more than this however slight it is: CVODE needs minutes for a motion of intermittent rub.
LONGEST_OF_ALL = 600_000.0
# A decay slower than the longest wait by more than this factor is not waited for.
HOPELESS = 100.0
# Errors of single contacts add up round a cycle, and the smallest radius may be a small fraction of
# the motion. So runs use this fraction of the given tolerances.
TIGHTER = 0.1
# A tighter tolerance is used as it is: a tenth of it would be near the limit of the solvers.
TIGHTENED_FROM = 1e-11
# The first window contains at least this many whole revolutions,
WINDOW_REVOLUTIONS = 4
# and lasts at least this long: four revolutions of a fast rotor are too short.
WINDOW_TIME = 40.0
# Windows double up to this multiple of the first, for periods of many revolutions.
LONGEST_WINDOW = 8
# Samples of a window, whose mean is the whirl; the run itself finds the extrema between them.
SAMPLES_PER_REVOLUTION = 64
SAMPLES_PER_TIME = 16
# With a loose tolerance a motion that varies by this many tolerances is steady.
STEADY_TOLERANCES = 10.0
# A motion recurs if it misses itself by at most this multiple of the tolerance for steady motion:
# it may be that far on either side of its cycle.
RECURS = 10.0
# Chaos may be a transient: exponents are computed only for a motion that has not settled after
# this time, and this many 1/zeta, in which exp(-zeta t) has fallen to 2e-9.
LATE = 3000.0
PATIENCE = 20.0
# An exponent is a mean over at least this time, and at least this multiple of the earlier time.
EXPONENT_TIME = 20_000.0
EXPONENT_TIMES = 2.0
# An exponent is nonzero when it exceeds this many errors,
CLEAR_ERRORS = 5.0
# and when neighbours diverge by exp(20), 5e8, in the averaging time.
CLEAR_STRETCH = 20.0
# It is zero when neighbours neither diverge nor converge by 1 % in that time, in which clear chaos
# would have shown. The errors are those of the scatter of parts; on a torus the mean over all parts
# is far better.
NO_STRETCH = 0.01

_NO_TIMES = np.empty(0)


@dataclass(frozen=True, slots=True)
class SettledResponse:
    """The response on which a rotor has settled, and the events on the way to it.

    Parameters
    ----------
    response : str
        One of the kinds of `rotor_ida.steady.response`, or ``"failed"``.
    features : Features
        The motion over the final window; all NaN if the run failed.
    window_start, window_end : float
        The final window [1].
    event_times, event_kinds : ndarray, shape (m,)
        All contact events from the start on [1].
    event_states : ndarray, shape (m, 4)
        States at the events, fixed frame [1].
    end : tuple of float
        State at the end, on the rotating axes [1].
    message : str
        The reason of a failure, or for how long an unresolved motion was followed, and what still
        moved; else empty.
    """

    response: str
    features: Features
    window_start: float
    window_end: float
    event_times: Values
    event_kinds: npt.NDArray[np.int8]
    event_states: Values
    end: State
    message: str = ""


@dataclass(slots=True)
class _Trajectory:
    """The runs made so far, each from the end of the one before, on the rotating axes.

    Under a load each takes whole revolutions, which bring the axes back to where they were.
    """

    rotor: Rotor
    options: Options
    state: State
    stop: Stop
    extrema: Rows | None = None  # of the radius in the last window
    time: float = 0.0
    event_times: list[Values] = field(default_factory=lambda: [np.empty(0)])
    event_kinds: list[npt.NDArray[np.int8]] = field(
        default_factory=lambda: [np.empty(0, dtype=np.int8)]
    )
    event_states: list[Values] = field(default_factory=lambda: [np.empty((0, 4))])

    def wait(self, duration: float) -> None:
        """Continue the simulation from the end of the last run."""
        self._extend(duration, _NO_TIMES)

    def observe(self, length: float, samples: int) -> Window:
        """Continue the simulation, and return the motion as a window."""
        times = np.linspace(0.0, length, samples)
        orbit = self._extend(length, times, extrema=True)
        self.extrema = orbit.extrema
        touches = int((np.abs(orbit.event_kinds) == ENTRY).sum())
        return Window(
            rotor=self.rotor,
            times=times,
            states=rotated(orbit.states, -self.rotor.omega * times),
            contacts=orbit.contacts,
            touches=touches,
            ends_in_contact=orbit.starts_in_contact != bool(touches % 2),
            steady=max(STEADY, STEADY_TOLERANCES * self.options.rtol),
            rolling=stretches_of_rolling(orbit),
        )

    def turns(self, window: Window) -> TurningPoints:
        """Return the turning points of the radius in the last window."""
        assert self.extrema is not None
        return turning_points(window.states, self.extrema)

    def _extend(self, duration: float, times: Values, *, extrema: bool = False) -> Orbit:
        """Simulate from the end of the last run, with time and phase starting from 0 again."""
        scale = TIGHTER if self.options.rtol >= TIGHTENED_FROM else 1.0
        orbit = run(
            self.rotor, self.state, duration, times, self.options,
            scale=scale, extrema=extrema, stop=self.stop,
        )  # fmt: skip
        omega = self.rotor.omega
        self.event_times.append(self.time + orbit.event_times)
        self.event_kinds.append(orbit.event_kinds)
        self.event_states.append(rotated(orbit.event_states, np.float64(omega * self.time)))
        x, y, vx, vy = rotated(orbit.end, -omega * duration).tolist()
        self.state = (x, y, vx, vy)
        self.time += duration
        return orbit

    def settled(
        self, response: str, features: Features, window_start: float, message: str = ""
    ) -> SettledResponse:
        """Return the settled response."""
        return SettledResponse(
            response=response,
            features=features,
            window_start=window_start,
            window_end=self.time,
            event_times=np.concatenate(self.event_times),
            event_kinds=np.concatenate(self.event_kinds),
            event_states=np.concatenate(self.event_states),
            end=self.state,
            message=message,
        )


@dataclass(slots=True)
class _Approach:
    """The distance of a motion from its cycle, from window to window.

    Parameters
    ----------
    recurs : bool
        Whether the motion repeated itself in the last window.
    distance : float
        Its distance from its cycle at the end of that window, relative to its size [1].
    time : float
        The time of that end [1].
    """

    recurs: bool = False
    distance: float = math.inf
    time: float = 0.0

    def period(self, trajectory: _Trajectory, window: Window, turns: TurningPoints) -> float | None:
        """Return the period of a motion that has reached a stable cycle; None for others."""
        loaded = window.rotor.load > 0.0
        repeats = (_by_revolutions if loaded else _by_turns)(window, turns)
        self.recurs = repeats is not None
        if repeats is None:
            self.distance = math.inf
            return None
        multiplier = slowest_multiplier(
            trajectory.rotor, trajectory.state, repeats.period, trajectory.stop
        )
        decay = abs(multiplier) ** ((trajectory.time - self.time) / repeats.period)
        # under a load no paired multiplier shows which of the others is nearest 1
        held_back = 1.0 - abs(multiplier) if loaded else abs(1.0 - multiplier)
        distance = repeats.missed_by / max(held_back, ROUNDING)
        if math.isfinite(self.distance):
            # because of rounding no motion misses itself by less, however near it is
            distance = min(distance, decay * self.distance)
        self.distance, self.time = distance, trajectory.time
        settled = abs(multiplier) < 1.0 and distance <= window.steady
        return repeats.period if settled else None


def _by_turns(window: Window, turns: TurningPoints) -> Recurrence | None:
    """Return how a motion repeats itself on the rotating axes."""
    return recurrence(turns, RECURS * window.steady)


def _by_revolutions(window: Window, _: TurningPoints) -> Recurrence | None:
    """Return how a motion repeats itself under a load."""
    return recurrence_by_revolutions(
        window.once_a_revolution,
        2.0 * math.pi / window.rotor.omega,
        float(np.abs(window.states).max()),
        RECURS * window.steady,
    )


def follow_to_steady_state(
    rotor: Rotor,
    start: State,
    options: Options,
    *,
    longest: float | None = None,
    stop: Stop | None = None,
) -> SettledResponse:
    """Follow a rotor until the kind of its response is decided, or up to a time limit.

    The motion is observed over a window: first after the time in which damping should have
    settled it, then whenever the time has doubled.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : tuple of float
        ``(x, y, vx, vy)`` on the rotating axes, which at time 0 are the fixed ones [1].
    options : Options
        How to simulate.
    longest : float, optional
        Time after which no new window begins [1]; default: `longest_time`.
    stop : ndarray, shape (1,), optional
        Ends the run, as failed, as soon as it is not 0.
    """
    trajectory = _Trajectory(rotor, options, start, np.zeros(1, np.uint8) if stop is None else stop)
    try:
        return _decided(trajectory, longest_time(rotor) if longest is None else longest)
    except SimulationError as error:
        return trajectory.settled(FAILED, Features(), math.nan, str(error))


def _decided(trajectory: _Trajectory, longest: float) -> SettledResponse:
    """Observe the motion, window after window, until its kind is decided."""
    wait, length, samples = durations(trajectory.rotor)
    approach, times = _Approach(), 1
    while True:
        trajectory.wait(wait)
        began = trajectory.time
        window = trajectory.observe(times * length, times * (samples - 1) + 1)
        kind, features = _kind_of(window, trajectory, approach)
        wait, times = trajectory.time, min(2 * times, LONGEST_WINDOW)
        never = trajectory.rotor.zeta == 0.0
        if kind != UNRESOLVED or never or trajectory.time + wait > longest:
            message = ""
            if kind == UNRESOLVED:
                message = _what_was_tried(window, trajectory, approach, features)
            return trajectory.settled(kind, features, began, message)


def _what_was_tried(
    window: Window, trajectory: _Trajectory, approach: _Approach, features: Features
) -> str:
    """Return for how long an unresolved motion was followed, and what still moved at the end."""
    rotor, time = window.rotor, trajectory.time
    revolutions = f"{rotor.omega * time / (2.0 * math.pi):,.0f} revolutions"
    followed = f"followed for {revolutions if rotor.omega > 0.0 else f'a time of {time:.6g}'}"
    if rotor.zeta == 0.0:
        return f"{followed}: without damping nothing settles"
    return f"{followed}, {rotor.zeta * time:.3g}/zeta: {_still_moving(window, approach, features)}"


def _still_moving(window: Window, approach: _Approach, features: Features) -> str:
    """Return what keeps a motion with damping from being decided, in words."""
    if math.isfinite(features.lyapunov_exponent):
        exponent, error = features.lyapunov_exponent, features.lyapunov_error
        return (
            "it does not repeat itself, and its largest Lyapunov exponent is "
            f"{exponent:.3g} +- {error:.2g}"
        )
    if approach.recurs:
        return (
            "it repeats itself, but its distance from its cycle is estimated as "
            f"{approach.distance:.2g} of its size, where {window.steady:.2g} is allowed"
        )
    if touches_grow_slighter(window):
        return "its touches grow slighter, but not yet as fading touches do"
    if window.touches:
        return f"it does not repeat itself, with {window.touches} entries and exits in the window"
    if not window.ends_in_contact:
        return "out of contact, but it may still reach the stator"
    if window.rotor.load > 0.0 < window.rotor.omega:
        moved = np.abs(np.diff(window.once_a_revolution, axis=0))
        since = "from revolution to revolution"
    else:
        moved, since = np.abs(window.positions - window.whirl), "about its mean whirl"
    part = float(moved.max()) / features.radius_max
    return (
        f"in contact, it still moves by {part:.2g} of its radius {since}, where "
        f"{window.steady:.2g} is allowed"
    )


def _kind_of(window: Window, trajectory: _Trajectory, approach: _Approach) -> tuple[str, Features]:
    """Return the kind of response in a window, and its features."""
    rotor = window.rotor
    if rotor.load > 0.0 and rotor.omega == 0.0:
        return kind_at_rest(window), _features(window)
    if whirls_steadily(window):
        return SYNCHRONOUS, _features(window)
    turns = trajectory.turns(window)
    features = _features(window, turns)
    if stays_free(window):
        return CONTACT_FREE, features
    period = approach.period(trajectory, window, turns)
    if period is not None:
        return _kind_of_cycle(window, period), _features_of_cycle(window, turns, period)
    kind = TOUCHING if touches_fade(window) else UNRESOLVED
    slighter = kind == TOUCHING or touches_grow_slighter(window)
    undecided = not approach.recurs and not slighter and _may_be_chaotic(trajectory)
    if undecided and rolls_backwards(window):
        return ROLLING, features
    if undecided:
        kind, exponent, error = _kind_by_exponent(trajectory)
        features = replace(features, lyapunov_exponent=exponent, lyapunov_error=error)
    return kind, features


def _kind_of_cycle(window: Window, period: float) -> str:
    """Return the kind of a motion that has reached a cycle."""
    if rolls_backwards(window, period):
        return ROLLING
    if window.touches:
        return BOUNCING
    # a contact-free one may pass so near the stator that its bounds in `stays_free` exceed it
    return FULL_CONTACT if window.ends_in_contact else CONTACT_FREE


def _features_of_cycle(window: Window, turns: TurningPoints, period: float) -> Features:
    """Return the features of a motion that has reached a cycle."""
    if window.rotor.load > 0.0:
        features = _features(*_last_of(window, turns, period))
    else:
        low, high = extreme_radii(turns, period)
        features = replace(_features(window, turns), radius_min=low, radius_max=high)
    free = _kind_of_cycle(window, period) == CONTACT_FREE
    return features if free else replace(features, period=period)


def _features(window: Window, turns: TurningPoints | None = None) -> Features:
    """Return the features of any motion over a window."""
    radii = np.abs(window.positions)
    if turns is not None:
        radii = np.concatenate([radii, turns.radii])
    whirl = window.whirl
    return Features(abs(whirl), phase_lag_of(whirl), float(radii.min()), float(radii.max()))


def _last_of(window: Window, turns: TurningPoints, period: float) -> tuple[Window, TurningPoints]:
    """Return the last period of a window, in whole revolutions, and its turning points."""
    since = float(window.times[-1]) - period - SAME_TURN
    late, turned = window.times >= since, turns.times >= since
    return (
        replace(window, times=window.times[late], states=window.states[late]),
        TurningPoints(turns.times[turned], turns.states[turned], turns.are_maxima[turned]),
    )


def _may_be_chaotic(trajectory: _Trajectory) -> bool:
    """Return whether a motion that has not settled yet may never settle."""
    rotor, time = trajectory.rotor, trajectory.time
    return rotor.omega > 0.0 and time >= LATE and rotor.zeta * time >= PATIENCE


def _kind_by_exponent(trajectory: _Trajectory) -> tuple[str, float, float]:
    """Return the kind of a motion that never repeats, its largest exponent, and its error."""
    rotor = trajectory.rotor
    duration = max(EXPONENT_TIME, EXPONENT_TIMES * trajectory.time)
    exponents, errors = exponents_of(rotor, trajectory.state, duration, trajectory.stop)
    exponent, error = float(exponents[0]), float(errors[0])
    if exponent > CLEAR_ERRORS * error and exponent * duration > CLEAR_STRETCH:
        return CHAOTIC, exponent, error
    # without a load the exponent of a shift in time is zero, and on a torus one more
    zeros = slice(0, 1 if rotor.load > 0.0 else 2)
    are_zero = (np.abs(exponents[zeros]) * duration <= NO_STRETCH) & (
        errors[zeros] * duration <= CLEAR_STRETCH
    )
    has_tori = rotor.load > 0.0 or rotor.friction > 0.0 or rotor.contact_damping > 0.0
    return QUASI_PERIODIC if are_zero.all() and has_tori else UNRESOLVED, exponent, error


def failed(rotor: Rotor, start: State, options: Options, reason: str) -> SettledResponse:
    """Return the failed response of a rotor that could not be followed from `start`."""
    trajectory = _Trajectory(rotor, options, start, np.zeros(1, np.uint8))
    return trajectory.settled(FAILED, Features(), math.nan, reason)


def longest_time(rotor: Rotor) -> float:
    """Return the time after which no new window begins [1]: the slower the decay, the longer."""
    if rotor.zeta == 0.0:  # nothing settles
        return LONGEST
    longest = max(LONGEST, _time_to_decay(rotor, LONGEST_DECAY_TIMES))
    if longest > HOPELESS * LONGEST_OF_ALL:  # nor does it within any wait
        return LONGEST
    return min(longest, LONGEST_OF_ALL)


def _time_to_decay(rotor: Rotor, times: float) -> float:
    """Return the time in which a transient falls to ``exp(-times)`` [1]; infinite if it never does.

    Near a fold or a limit cycle it may take longer.
    """
    zeta, kappa = rotor.zeta, rotor.shaft_stiffness
    decay = times * max(1.0 / zeta, zeta) if zeta > 0.0 else math.inf
    if 0.0 < kappa < zeta * zeta:  # overdamped: a weak shaft returns the rotor slowly in flight
        decay = max(decay, times * (zeta + math.sqrt(zeta * zeta - kappa)) / kappa)
    return decay


def durations(rotor: Rotor) -> tuple[float, float, int]:
    """Return the first wait, the length of the window and its number of samples.

    The window is a whole number of revolutions, and so is the wait under a load.
    """
    wait = min(_time_to_decay(rotor, DECAY_TIMES), LONGEST_FIRST_WAIT)
    if rotor.omega == 0.0:
        return wait, WINDOW_TIME, int(WINDOW_TIME * SAMPLES_PER_TIME) + 1
    revolution = 2.0 * math.pi / rotor.omega
    if rotor.load > 0.0:
        wait = math.ceil(wait / revolution) * revolution
    count = max(WINDOW_REVOLUTIONS, math.ceil(WINDOW_TIME / revolution))
    each = max(SAMPLES_PER_REVOLUTION, math.ceil(SAMPLES_PER_TIME * revolution))
    return wait, count * revolution, count * each + 1
