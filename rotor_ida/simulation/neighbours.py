"""A segment of an orbit with the derivatives that Newton's method needs, and its events.

The core integrates the state and four differences from it together, by one Taylor series in
contact and in closed form in flight; derivatives by the parameters follow. The field is continuous
where contact begins and ends, so nothing is added there. Where friction jumps, as the disc begins
to roll or reverses its sliding, differences jump with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.core.interface import DONE, STUCK, message_of
from rotor_ida.core.runs import COLUMNS, DIFFERENCES, Rows, RunRequest, follow_run
from rotor_ida.errors import SimulationError
from rotor_ida.model.equations import push_over_radius, rotating_field
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.orbit import ROLLS, SLIDES_BACKWARDS, SLIDES_FORWARDS

MAXIMUM = 1.0  # the kind of an extremum
RTOL = 1e-15
# Absolute tolerance of one step, as a fraction of the relative one.
ATOL = 1e-2
# A slip smaller than this fraction of the speeds that it is the difference of is solver error.
HIDDEN_SLIP = 1e-12


@dataclass(frozen=True, slots=True)
class Shot:
    """A segment of an orbit, from its start to its end.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start, end : ndarray, shape (4,)
        States ``(x, y, vx, vy)`` on the rotating axes [1].
    duration : float
        Time between them [1].
    monodromy : ndarray, shape (4, 4)
        Derivative of the end by the start [1].
    by_parameter : ndarray, shape (4, n)
        Derivatives of the end by the first n of `rotor_ida.core.runs.COLUMNS` [1]: omega, zeta and
        delta0, and in the general model the other parameters. The derivative by delta0 is 0 without
        clearance.
    contacts : ndarray of `rotor_ida.core.runs.CONTACT`
        The contacts [1]; an entry before the start, or an exit after the end, is NaN.
    extrema : ndarray of `rotor_ida.core.runs.EXTREMUM`
        The minima and maxima of the radius between start and end [1].
    start_rate, end_rate : ndarray, shape (4,)
        Rate of change of the state at the start and at the end [1].
    event_kinds : ndarray, shape (k,)
        Kinds of its events.
    ways : ndarray, shape (k + 1,), optional
        Mode of motion from the start, and from each event on; None without friction.
    """

    rotor: Rotor
    start: Values
    end: Values
    duration: float
    monodromy: Values
    by_parameter: Values
    contacts: Rows
    extrema: Rows
    start_rate: Values
    end_rate: Values
    event_kinds: npt.NDArray[np.int8]
    ways: npt.NDArray[np.int8] | None = None

    @property
    def rolls(self) -> bool:
        """Whether the disc ever rolls on the stator."""
        return self.ways is not None and bool((self.ways == ROLLS).any())

    @property
    def is_autonomous(self) -> bool:
        """Whether it may begin at any time: there is no load."""
        return self.rotor.load == 0.0

    @property
    def contraction(self) -> float:
        """The factor ``exp(-2 zeta T)`` by which areas shrink, without contact damping."""
        return math.exp(-2.0 * self.rotor.zeta * self.duration)

    @property
    def pair_product(self) -> float | None:
        """Product of each pair of multipliers, one of them 1 and the rest; None without pairs."""
        has_pairs = self.rotor.damps_uniformly and self.is_autonomous
        return self.contraction if has_pairs else None

    @property
    def sizes(self) -> Values:
        """The smallest and the largest radius at extrema [1]: the same at any phase."""
        radii = self.extrema["radius"]
        return np.array([radii.min(), radii.max()])

    def halves_agree(self, part: float) -> bool:
        """Return whether the extreme radii of both halves agree to a fraction of the largest."""
        radii = self.extrema["radius"].tolist()
        half, odd = divmod(len(radii), 2)
        if odd or not half:
            return False
        pairs, allowed = zip(radii[:half], radii[half:], strict=True), part * max(radii)
        return all(abs(one - other) <= allowed for one, other in pairs)


def shoot(
    rotor: Rotor,
    start: Values,
    duration: float,
    stop: Stop,
    rtol: float = RTOL,
    *,
    whole: bool = False,
) -> Shot:
    """Follow a state for a time, with the derivatives of its end.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : ndarray, shape (4,)
        ``(x, y, vx, vy)`` on the rotating axes [1] at time 0, when these are the fixed axes.
    duration : float
        Time to simulate [1].
    stop : ndarray, shape (1,)
        Stops the run as soon as it is not 0.
    rtol : float
        Tolerance of one step, relative to the size of the state [1].
    whole : bool
        Whether to differentiate by every parameter, even if it is the paper's rotor.

    Raises
    ------
    SimulationError
        If the integration fails or is stopped.
    """
    if rotor.friction > 0.0:
        start = put_on_rolling(rotor, start)
    columns = len(COLUMNS) if whole or rotor.beyond else len(PARAMETERS)
    bundle = np.eye(DIFFERENCES + columns, 4)
    result = follow_run(
        RunRequest(
            whole=whole,
            rotor=rotor,
            start=start,
            duration=duration,
            rtol=rtol,
            atol=ATOL * rtol,
            events=True,
            extrema=True,
            bundle=bundle,
            stop=stop,
        )
    )
    end = np.array(result.state)
    status = result.status
    if status == DONE and not math.isfinite(sum(bundle.ravel().tolist()) + sum(result.state)):
        status = STUCK
    if status != DONE:
        x, y, vx, vy = start.tolist()
        reason = f"an orbit could not be followed: {message_of(status)}"
        raise SimulationError(reason, time=0.0, state=(x, y, vx, vy))
    ways = (0, 0) if result.ways is None else (int(result.ways[0]), int(result.ways[-1]))
    rates = (
        rotating_field(start, rotor) + _friction_at(start, rotor, 0.0, ways[0]),
        rotating_field(end, rotor, duration) + _friction_at(end, rotor, duration, ways[1]),
    )
    return Shot(
        rotor, start, end, duration, bundle[:DIFFERENCES].T, bundle[DIFFERENCES:].T,
        result.contacts, result.extrema, *rates, result.event_kinds, result.ways,
    )  # fmt: skip


def put_on_rolling(rotor: Rotor, state: Values) -> Values:
    """Return a state with a slip of exactly 0 if it was only rounding: there the disc may roll."""
    x, y, vx, vy = state.tolist()
    radius, speed = math.hypot(x, y), math.hypot(vx, vy)
    rim = (rotor.disc_radius or 0.0) * rotor.omega
    if not radius > rotor.delta0:
        return state
    slip = (x * vy - y * vx) / radius + rim
    if abs(slip) > HIDDEN_SLIP * (speed + rim):
        return state
    return np.array([x, y, vx + slip * y / radius, vy - slip * x / radius])


def _friction_at(state: Values, rotor: Rotor, time: float, way: int) -> Values:
    """Return the contribution of the tangential force to the rates on the rotating axes."""
    if way not in {SLIDES_FORWARDS, SLIDES_BACKWARDS, ROLLS}:
        return np.zeros(4)
    x, y, vx, vy = state.tolist()
    radius = math.hypot(x, y)
    if way == ROLLS:
        turned = rotor.omega * time
        down = -rotor.load * (x * math.cos(turned) - y * math.sin(turned)) / radius
        force = -(rotor.omega**2) * y / radius + down
        rise = (x * vx + y * vy) / radius
        force += (rotor.disc_radius or 0.0) * rotor.omega * (2.0 * rotor.zeta + rise / radius)
    else:
        force = way * rotor.friction * radius * push_over_radius((x, y, vx, vy), rotor)
    return np.array([0.0, 0.0, force * y / radius, -force * x / radius])
