"""Follow a rotor to its steady state; what kind of response that is, `decide` says."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from rotor_ida.arrays import ComplexValues, Flags, Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.flow import DiscFlow, Flow, Window
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.system_flow import SAMPLES_A_REVOLUTION, SystemFlow
from rotor_ida.steady.decision import Decision, decide
from rotor_ida.steady.motion import WINDOW_REVOLUTIONS, Limits, Motion
from rotor_ida.steady.response import (
    BOUNCING,
    CONTACT_FREE,
    FULL_CONTACT,
    NEARLY_GRAZES,
    ROLLING,
    grazing_distance,
    phase_lag_of,
    stays_backward,
)

# A transient that decays like exp(-zeta t) has fallen by 4e-11 after this many 1/zeta.
DECAY_TIMES = 24.0
# Longest first wait, however slight the damping; later waits double. That of a system is in
# revolutions.
LONGEST_FIRST_WAIT, LONGEST_FIRST_WAIT_OF_SYSTEM = 2000.0, 200.0
# No window but the first begins after this many decay times. As times double, the last one begins
# after half of it or more: exp(-zeta t) is 1e-13 by then.
LONGEST_DECAY_TIMES = 60.0
# This time is allowed however strong the damping is, for what settles more slowly, as near a fold;
# and no more than the other however slight it is: CVODE needs minutes for a motion of intermittent
# rub. Those of a system are in revolutions.
LONGEST, LONGEST_OF_ALL = 40_000.0, 600_000.0
LONGEST_OF_SYSTEM, LONGEST_OF_ALL_SYSTEMS = 1500.0, 4000.0
# A decay slower than the longest wait by more than this factor is not waited for.
HOPELESS = 100.0
# Tolerance of the runs by which multipliers are computed, which decide when to stop.
MULTIPLIER_RTOL = 1e-12
# The first window of one disc lasts at least this long: four revolutions of a fast rotor are too
# short.
WINDOW_TIME = 40.0
# Samples of a window, whose mean is the whirl; the run itself finds the extrema between them.
SAMPLES_PER_TIME = 16
# Chaos may be a transient: exponents are computed only for a motion that has not settled after
# this time (of a system, this number of revolutions), and this many 1/zeta, in which exp(-zeta t)
# has fallen to 2e-9 (of a system only up to a number of revolutions).
LATE, PATIENCE = 3000.0, 20.0
LATE_OF_SYSTEM, VERY_LATE_OF_SYSTEM = 450.0, 1500.0
# Turning points closer in time are the same: rounding shifts them less, and two lie farther apart.
SAME_TURN = 1e-6
# Samples of a period of one disc over which the part at the spin speed is the mean.
SAMPLES = 1024
CYCLES = (BOUNCING, FULL_CONTACT, ROLLING)
Of = TypeVar("Of")


@dataclass(frozen=True, slots=True)
class Features:
    """How one disc moves in the final window, as a sweep reports it; NaN where one does not exist.

    Parameters
    ----------
    amplitude, phase_lag : float
        Amplitude [dimensionless] and phase lag [rad] of the part of the motion at the spin speed.
    radius_min, radius_max : float
        Smallest and largest distance from the bearing axis [dimensionless].
    period : float
        Period on the rotating axes of a bouncing or full-contact motion [dimensionless]; under a
        load a whole number of revolutions.
    lyapunov_exponent, lyapunov_error : float
        Largest Lyapunov exponent and its standard error, where computed [dimensionless].
    """

    amplitude: float = math.nan
    phase_lag: float = math.nan
    radius_min: float = math.nan
    radius_max: float = math.nan
    period: float = math.nan
    lyapunov_exponent: float = math.nan
    lyapunov_error: float = math.nan


@dataclass(frozen=True, slots=True)
class Settled(Generic[Of]):
    """The response on which a rotor has settled.

    Parameters
    ----------
    decision : Decision
        Its kind, and what that was decided by.
    features : Features or SystemFeatures
        How the rotor moves in the final window.
    motion : Motion
        The motion up to its end: its last window, and the events of one disc on the way.
    """

    decision: Decision
    features: Of
    motion: Motion

    @property
    def kind(self) -> str:
        """One of the kinds of `rotor_ida.steady.response`."""
        return self.decision.kind


def settle_system(flow: SystemFlow, state: Values) -> Settled[SystemFeatures]:
    """Follow a rotor system from a state until the kind of its response is decided.

    SimulationError if the integration fails or is stopped.
    """
    motion = Motion(flow, limits_of(flow), state)
    return Settled(decide(motion), features_of_system(motion.window), motion)


def settle_disc(
    rotor: Rotor, start: State | Values, options: Options, *, longest: float | None = None,
    stop: Stop = NO_STOP,
) -> Settled[Features]:  # fmt: skip
    """Follow a rotor until the kind of its response is decided, or up to a time limit.

    The motion is observed over a window: first after the time in which damping should have
    settled it, then whenever the time has doubled (`rotor_ida.steady.decision.decide`).

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : array_like, shape (4,)
        ``(x, y, vx, vy)`` on the rotating axes, which at time 0 are the fixed ones [dimensionless].
    options : Options
        How to simulate.
    longest : float, optional
        Time after which no new window begins, except of a motion that approaches a stable cycle
        [dimensionless]; default: `longest_time`.
    stop : ndarray, shape (1,), optional
        Ends the run as soon as it is not 0.

    Raises
    ------
    SimulationError
        If the integration fails or is stopped.
    """
    is_exact = options.flight == "exact" and options.backend != "python"
    if is_exact and abs(grazing_distance(rotor)) <= NEARLY_GRAZES:
        options = replace(options, method="taylor")
    flow = DiscFlow(rotor, stop, MULTIPLIER_RTOL, options)
    limits = limits_of(flow)
    if longest is not None:
        limits = limits._replace(longest=longest)
    motion = Motion(flow, limits, np.array(start, np.float64))
    decision = decide(motion)
    return Settled(decision, features_of_disc(motion.window, decision), motion)


# ---- For how long ----


def limits_of(flow: Flow) -> Limits:
    """Return for how long a motion is followed."""
    if isinstance(flow, DiscFlow):
        wait, window, samples = durations(flow.rotor)
        is_settling = flow.has_damping and flow.speed > 0.0
        late = max(LATE, PATIENCE / flow.rotor.zeta) if is_settling else math.inf
        return Limits(wait, longest_time(flow.rotor), window, samples - 1, flow.rotor.zeta, late)
    assert isinstance(flow, SystemFlow)
    turn, decay = flow.revolution, flow.problem.slowest_decay(flow.speed)
    slow = 1.0 / decay if decay > 0.0 else math.inf
    decays = LONGEST_DECAY_TIMES * slow if decay > 0.0 else 0.0
    return Limits(
        wait=min(DECAY_TIMES * slow, LONGEST_FIRST_WAIT_OF_SYSTEM * turn),
        longest=min(max(decays, LONGEST_OF_SYSTEM * turn), LONGEST_OF_ALL_SYSTEMS * turn),
        window=WINDOW_REVOLUTIONS * turn, samples=WINDOW_REVOLUTIONS * SAMPLES_A_REVOLUTION,
        decay=decay,
        late=max(LATE_OF_SYSTEM * turn, min(PATIENCE * slow, VERY_LATE_OF_SYSTEM * turn)),
    )  # fmt: skip


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
    each = max(SAMPLES_A_REVOLUTION, math.ceil(SAMPLES_PER_TIME * revolution))
    return wait, count * revolution, count * each + 1


# ---- How a settled motion moves ----


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemFeatures:
    """How a rotor system moves in a window.

    Parameters
    ----------
    contact_whirl, node_whirl : ndarray of complex, shapes (contact,), (node,)
        Complex amplitudes of the displacements at the spin speed.
    contact_low, contact_high, node_low, node_high : ndarray
        Smallest and largest distances, of the contacts from the centres of their stators.
    largest_force : ndarray, shape (contact,)
        Largest normal forces.
    touches : ndarray of bool, shape (contact,)
        Which contacts touch.
    backward : ndarray of bool, shape (contact,)
        Which contacts stay closed and whirl backwards.
    """

    contact_whirl: ComplexValues
    node_whirl: ComplexValues
    contact_low: Values
    contact_high: Values
    node_low: Values
    node_high: Values
    largest_force: Values
    touches: Flags
    backward: Flags


def features_of_system(window: Window) -> SystemFeatures:
    """Return how a rotor system moves in a window."""
    flow = window.flow
    assert isinstance(flow, SystemFlow)
    places = flow.places(window.states, nodes=True)[0]
    turn = np.exp(-1j * flow.speed * window.times) if flow.problem.forward is None else np.ones(1)
    whirl = (places * turn[:, np.newaxis])[:-1].mean(axis=0)
    whirl = whirl if flow.speed else np.zeros_like(whirl)  # a place of rest is no whirl
    low, high = extremes(np.abs(places), flow.radii(window, nodes=True))
    count, table = flow.clearances.size, window.contacts
    largest, numbers = window.forces.max(axis=0, initial=0.0), table["contact"].astype(int)
    np.maximum.at(largest, numbers, np.nan_to_num(table["largest_force"]))
    return SystemFeatures(
        contact_whirl=whirl[:count], node_whirl=whirl[count:],
        contact_low=low[:count], contact_high=high[:count],
        node_low=low[count:], node_high=high[count:],
        largest_force=largest, touches=largest > 0.0,
        backward=np.array([stays_backward(window, each) for each in range(count)], bool),
    )  # fmt: skip


def features_of_disc(window: Window, decision: Decision) -> Features:
    """Return how one disc moves in a window; of a cycle in its last period."""
    period, since = decision.period, -math.inf
    if period is not None:
        since = float(window.times[-1]) - period - SAME_TURN
    place, extrema, last = window.places[0], window.extrema, window.times >= since
    turning = place if period is None or window.flow.period is None else place[last]
    if period is not None and decision.kind in CYCLES and window.flow.period is None:
        # its period is not one of revolutions, over which alone the other parts vanish
        times = np.linspace(0.0, period, SAMPLES + 1)
        turning = window.flow.places(window.flow.states(window.end, times))[0]
    whirl = complex(turning[:-1].mean()) if window.flow.speed else 0j  # rest is no whirl
    low, high = extremes(np.abs(place[last]), [extrema["radius"][extrema["time"] >= since]])
    return Features(
        abs(whirl), phase_lag_of(whirl), float(low[0]), float(high[0]),
        math.nan if period is None or decision.kind == CONTACT_FREE else period,
        decision.exponent, decision.error,
    )  # fmt: skip


def extremes(distances: Values, radii: list[Values]) -> tuple[Values, Values]:
    """Return the smallest and largest of distances, shape (time, place), and extreme distances."""
    both = [np.append(own, more) for own, more in zip(distances.T, radii, strict=True)]
    return np.array([each.min() for each in both]), np.array([each.max() for each in both])
