"""Follow a rotor to its steady state, and decide the kind of its response."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values, Watch
from rotor_ida.checks import State
from rotor_ida.errors import SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.lyapunov import exponents_of
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import ENTRY, Orbit, stretches_of_rolling
from rotor_ida.simulation.run import run
from rotor_ida.steady.decision import (
    DISTURBANCE,
    RECURS,
    Decision,
    Exponents,
    decide,
    growing_direction,
)
from rotor_ida.steady.periods import (
    SAME_TURN,
    Recurrence,
    TurningPoints,
    extreme_radii,
    monodromy,
    recurrence,
    recurrence_by_revolutions,
    slowest_multiplier,
    turning_points,
)
from rotor_ida.steady.response import (
    CONTACT_FREE,
    NEARLY_GRAZES,
    STEADY,
    SYNCHRONOUS,
    TOUCHING,
    Features,
    Window,
    grazes,
    grazing_distance,
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
# Samples of a window, whose mean is the whirl; the run itself finds the extrema between them.
SAMPLES_PER_REVOLUTION = 64
SAMPLES_PER_TIME = 16
# With a loose tolerance a motion that varies by this many tolerances is steady.
STEADY_TOLERANCES = 10.0
# Chaos may be a transient: exponents are computed only for a motion that has not settled after
# this time, and this many 1/zeta, in which exp(-zeta t) has fallen to 2e-9.
LATE = 3000.0
PATIENCE = 20.0
# An exponent is a mean over at least this time, and at least this multiple of the earlier time.
EXPONENT_TIME = 20_000.0
EXPONENT_TIMES = 2.0

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
    watch: Watch | None = None
    time: float = 0.0
    window_start: float = math.nan
    window: Window = field(init=False)  # the last one
    turns: TurningPoints = field(init=False)  # those of the radius in it
    event_times: list[Values] = field(default_factory=lambda: [np.empty(0)])
    event_kinds: list[npt.NDArray[np.int8]] = field(
        default_factory=lambda: [np.empty(0, dtype=np.int8)]
    )
    event_states: list[Values] = field(default_factory=lambda: [np.empty((0, 4))])

    # ---- What is asked of a motion: see `Motion` ----

    @property
    def steady(self) -> float:
        return self.window.steady

    @property
    def touches(self) -> int:
        return self.window.touches

    @property
    def ends_in_contact(self) -> bool:
        return self.window.ends_in_contact

    @property
    def never_settles(self) -> bool:
        return self.rotor.zeta == 0.0

    def wait(self, duration: float) -> None:
        self._extend(duration, _NO_TIMES)

    def observe(self, times: int) -> None:
        _, length, samples = durations(self.rotor)
        self.window_start = self.time
        at = np.linspace(0.0, times * length, times * (samples - 1) + 1)
        orbit = self._extend(times * length, at, extrema=True)
        touches = int((np.abs(orbit.event_kinds) == ENTRY).sum())
        states = rotated(orbit.states, -self.rotor.omega * at)
        self.window = Window(
            rotor=self.rotor,
            times=at,
            states=states,
            contacts=orbit.contacts,
            touches=touches,
            ends_in_contact=orbit.starts_in_contact != bool(touches % 2),
            steady=max(STEADY, STEADY_TOLERANCES * self.options.rtol),
            rolling=stretches_of_rolling(orbit),
        )
        assert orbit.extrema is not None
        self.turns = turning_points(states, orbit.extrema)

    def kind_of_state(self) -> str | None:
        if _is_at_rest(self.rotor):
            return kind_at_rest(self.window)
        if grazes(self.window):
            return TOUCHING
        if whirls_steadily(self.window):
            return SYNCHRONOUS
        return CONTACT_FREE if stays_free(self.window) else None

    def recurrence(self) -> Recurrence | None:
        window, tolerance = self.window, RECURS * self.steady
        if self.rotor.load == 0.0:
            return recurrence(self.turns, tolerance)
        revolution = 2.0 * math.pi / self.rotor.omega
        size = float(np.abs(window.states).max())
        return recurrence_by_revolutions(window.once_a_revolution, revolution, size, tolerance)

    def slowest_multiplier(self, period: float) -> complex:
        return slowest_multiplier(self.rotor, self.state, period, self.stop)

    def leave_unstable(self) -> bool:
        if self.never_settles or self.rotor.omega == 0.0:
            return False
        steady = None if whirls_steadily(self.window) else self.recurrence()
        period = 2.0 * math.pi / self.rotor.omega if steady is None else steady.period
        moved = growing_direction(monodromy(self.rotor, self.state, period, self.stop))
        if moved is None:
            return False
        # without a clearance the motion itself is the measure
        length = self.rotor.delta0 or float(np.abs(self.window.positions).max())
        moved *= DISTURBANCE * length / math.hypot(moved[0], moved[1])
        x, y, vx, vy = (np.array(self.state) + moved).tolist()
        self.state = (x, y, vx, vy)
        return True

    def held_back(self, multiplier: complex) -> float:
        # under a load no paired multiplier shows which of the others is nearest 1
        return 1.0 - abs(multiplier) if self.rotor.load > 0.0 else abs(1.0 - multiplier)

    def stands_still(self) -> bool:
        return False  # one state has decided that

    def rolls_backwards(self, period: float | None = None) -> bool:
        return rolls_backwards(self.window, period)

    def fading(self) -> tuple[bool, bool]:
        fades = touches_fade(self.window)
        return fades, fades or touches_grow_slighter(self.window)

    def may_be_chaotic(self, duration: float) -> bool:
        rotor = self.rotor
        return rotor.omega > 0.0 and duration >= LATE and rotor.zeta * duration >= PATIENCE

    def exponents(self) -> Exponents:
        rotor = self.rotor
        duration = max(EXPONENT_TIME, EXPONENT_TIMES * self.time)
        found = exponents_of(rotor, self.state, duration, self.stop)
        # without a load the exponent of a shift in time is zero, and on a torus one more
        zeros = 1 if rotor.load > 0.0 else 2
        has_tori = rotor.load > 0.0 or rotor.friction > 0.0 or rotor.contact_damping > 0.0
        return Exponents(*found, duration, zeros, has_tori)

    def followed(self) -> str:
        rotor, time = self.rotor, self.time
        revolutions = f"{rotor.omega * time / (2.0 * math.pi):,.0f} revolutions"
        told = f"followed for {revolutions if rotor.omega > 0.0 else f'a time of {time:.6g}'}"
        return told if rotor.zeta == 0.0 else f"{told}, {rotor.zeta * time:.3g} decay times"

    def still_moves(self) -> str:
        window = self.window
        if window.rotor.load > 0.0 < window.rotor.omega:
            moved = np.abs(np.diff(window.once_a_revolution, axis=0))
            since = "from revolution to revolution"
        else:
            moved, since = np.abs(window.positions - window.whirl), "about its mean whirl"
        turns = None if _is_at_rest(self.rotor) else self.turns
        part = float(moved.max()) / _features(window, turns).radius_max
        return (
            f"in contact, it still moves by {part:.2g} of its radius {since}, where "
            f"{window.steady:.2g} is allowed"
        )

    # ---- Its runs and its result ----

    def _extend(self, duration: float, times: Values, *, extrema: bool = False) -> Orbit:
        """Simulate from the end of the last run, with time and phase starting from 0 again."""
        scale = TIGHTER if self.options.rtol >= TIGHTENED_FROM else 1.0
        orbit = run(
            self.rotor, self.state, duration, times, self.options,
            scale=scale, extrema=extrema, stop=self.stop, watch=self.watch,
        )  # fmt: skip
        omega = self.rotor.omega
        self.event_times.append(self.time + orbit.event_times)
        self.event_kinds.append(orbit.event_kinds)
        self.event_states.append(rotated(orbit.event_states, np.float64(omega * self.time)))
        x, y, vx, vy = rotated(orbit.end, -omega * duration).tolist()
        self.state = (x, y, vx, vy)
        self.time += duration
        return orbit

    def features(self, decision: Decision) -> Features:
        """Return the features of the motion in the last window."""
        if decision.period is not None:
            return _features_of_cycle(self.window, self.turns, decision)
        plain = decision.kind == SYNCHRONOUS or _is_at_rest(self.rotor)
        found = _features(self.window, None if plain else self.turns)
        return replace(found, lyapunov_exponent=decision.exponent, lyapunov_error=decision.error)

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


def follow_to_steady_state(
    rotor: Rotor,
    start: State,
    options: Options,
    *,
    longest: float | None = None,
    stop: Stop | None = None,
    watch: Watch | None = None,
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
    watch : list of callable, optional
        Receives functions that return the times reached by its runs [1].
    """
    is_exact = options.flight == "exact" and options.backend != "python"
    if is_exact and abs(grazing_distance(rotor)) <= NEARLY_GRAZES:
        options = replace(options, method="taylor")
    stop = np.zeros(1, np.uint8) if stop is None else stop
    trajectory = _Trajectory(rotor, options, start, stop, watch)
    limit = longest_time(rotor) if longest is None else longest
    try:
        decision = decide(trajectory, durations(rotor)[0], limit)
    except SimulationError as error:
        return trajectory.settled(FAILED, Features(), math.nan, str(error))
    features = trajectory.features(decision)
    return trajectory.settled(decision.kind, features, trajectory.window_start, decision.message)


def _is_at_rest(rotor: Rotor) -> bool:
    """Return whether a rotor that does not turn comes to rest under its load."""
    return rotor.load > 0.0 and rotor.omega == 0.0


def _features_of_cycle(window: Window, turns: TurningPoints, decision: Decision) -> Features:
    """Return the features of a motion that has reached a cycle."""
    period = decision.period
    assert period is not None
    if window.rotor.load > 0.0:
        features = _features(*_last_of(window, turns, period))
    else:
        low, high = extreme_radii(turns, period)
        features = replace(_features(window, turns), radius_min=low, radius_max=high)
    return features if decision.kind == CONTACT_FREE else replace(features, period=period)


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
