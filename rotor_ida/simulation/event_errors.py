"""Event-time error estimate, and the horizon beyond which there is none.

The orbit is simulated a second time by Taylor series with thirty times tighter tolerances and few
samples, whatever its own method: that costs a tenth of a run of CVODE and is far more exact, so the
difference is the error itself. Of an orbit by Taylor series rounding is a part of it at tight
tolerances. The difference is widened, since a part of the second run's own error may hide in it.
Where the second tolerance would be below rounding both runs may round alike: the second is given a
rotor that differs by the last bit.

Taylor series take a step every few radians of the fastest motion or decay that the rotor is capable
of, even where nothing moves. On a steady whirl, or with heavy damping, CVODE lengthens its steps: a
long run of it is repeated by CVODE itself, at thirty times looser tolerances. That difference
stands for the error of the looser run and covers that of the tighter one.

A difference that happens to vanish is no witness, so each event takes the largest of its own and
the few before it. ``docs/events.md`` says how well this covers the events of the reference cases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ROUNDING, Stop, Values, Watch
from rotor_ida.checks import State
from rotor_ida.errors import SimulationError
from rotor_ida.model.modes import Moment, accelerations
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.options import LOOSEST_RTOL_OF_TAYLOR, Options
from rotor_ida.simulation.orbit import PRESS, REVERSE, ROLL, ROLLS, SLIP, Orbit
from rotor_ida.simulation.run import run

Event = tuple[int, float, float]

APART = 30.0
MEMORY = 4
# What the difference, and the bound on rounding, is multiplied by. A run may be more exact than its
# tolerance, and then agrees too well with the second: of 772 runs of the reference cases, by two a
# decade of rtol, three would have needed more than 5, and none more than 9.
WIDENING, OF_ROUNDING = 10.0, 0.5
# Radians of the fastest motion beyond which a run is long.
LONG = 1e6
# Samples of the second run: where the two orbits part is seen to so many parts of the run.
MOST_SAMPLES = 64
# Two events belong to each other when they are of one kind and no further apart than this
# part of the time to the next or the last one.
SAME_EVENT = 0.25
# Beyond this part of the motion's size the difference between two orbits says they are two.
ASTRAY = 1e-2
# The motion is as large as its largest radius over so many samples on either side, some sixteenth
# of a run in all: one sample may be near the centre, and long before the motion may have been wild.
NEAR = 2


@dataclass(frozen=True, slots=True)
class EventErrors:
    """What is known of an orbit's error.

    Parameters
    ----------
    event_time_errors : ndarray, shape (m,)
        Estimated error of each event time [1]; infinite beyond the horizon, and for a touch or
        a departure that the tolerances do not decide.
    horizon : float
        Time up to which the orbit is determined by its start at these tolerances [1]; the end
        of the run if it is throughout.
    """

    event_time_errors: Values
    horizon: float


def estimate_event_errors(
    orbit: Orbit,
    start: State,
    *,
    slack: float = 0.0,
    stop: Stop | None = None,
    watch: Watch | None = None,
) -> EventErrors:
    """Estimate the error of an orbit by simulating it again.

    Parameters
    ----------
    orbit : Orbit
        The orbit.
    start : tuple of float
        Its start ``(x, y, vx, vy)``, fixed frame [1].
    slack, stop, watch
        As for `run`.
    """
    rotor, options, scale = orbit.rotor, orbit.options, APART
    widening, of_rounding = 1.0, 1.0
    if options.method == "taylor" or _fastest(orbit) * orbit.duration <= LONG:
        rtol = min(options.rtol, LOOSEST_RTOL_OF_TAYLOR)
        options, scale = Options(rtol=rtol, atol=options.atol, method="taylor"), 1.0 / APART
        widening, of_rounding = WIDENING, OF_ROUNDING
        if rtol < APART * ROUNDING:
            rotor = _nearest(rotor)
    profile = None if orbit.speed_record is None else orbit.speed_record.profile
    every = max(1, orbit.times.size // MOST_SAMPLES)
    thinned = replace(orbit, times=orbit.times[::every], states=orbit.states[::every])
    try:
        other = run(
            rotor, start, orbit.duration, thinned.times, options, slack=2.0 * slack,
            scale=scale, stop=stop, profile=profile, watch=watch,
        )  # fmt: skip
    except SimulationError as error:
        return EventErrors(np.full(orbit.event_times.size, np.inf), error.time)
    partners = _partners(orbit, other)
    differences = np.full(orbit.event_times.size, np.nan)
    found = partners >= 0
    differences[found] = np.abs(orbit.event_times[found] - other.event_times[partners[found]])
    errors = widening * _remembered(differences) + of_rounding * _rounding(orbit)
    errors[~found] = np.inf
    horizon = _horizon(thinned, other, partners)
    if horizon < orbit.duration:
        errors[orbit.event_times > horizon] = np.inf
    return EventErrors(errors, horizon)


def _fastest(orbit: Orbit) -> float:
    """Return the rate of the fastest motion or decay: spin, damping, vibration at the peak."""
    rotor = orbit.rotor
    zeta, delta0 = rotor.zeta, rotor.delta0
    omega = float(np.max(orbit.speeds, initial=rotor.omega))
    squares = orbit.states[:, 0] ** 2 + orbit.states[:, 1] ** 2
    farthest = float(np.sqrt(squares.max(initial=delta0**2)))
    depth = max(farthest - delta0, float(orbit.contacts["peak_indentation"].max(initial=0.0)))
    exponent = rotor.contact_exponent
    stiffness = exponent * depth ** (exponent - 1.0) + rotor.shaft_stiffness
    decay = 2.0 * zeta + rotor.contact_damping * depth**exponent
    return float(omega + decay + np.sqrt(stiffness))


def _nearest(rotor: Rotor) -> Rotor:
    """Return a rotor whose speed and clearance differ by the spacing of doubles."""
    omega, delta0 = (
        float(np.nextafter(value, np.inf)) if value > 0.0 else 0.0
        for value in (rotor.omega, rotor.delta0)
    )
    return replace(rotor, omega=omega, delta0=delta0)


def _partners(orbit: Orbit, other: Orbit) -> npt.NDArray[np.intp]:
    """Return the number of the same event in the other orbit, -1 where it has none.

    A slight touch, or a slight departure, may appear in one orbit only: a pair of events that
    has no partner is passed over. Where more than a pair is missing the orbits have parted.
    """
    if np.array_equal(orbit.event_kinds, other.event_kinds):  # as a rule all have theirs
        allowed = np.minimum(_reach(orbit), _reach(other))
        if (np.abs(orbit.event_times - other.event_times) <= allowed).all():
            return np.arange(orbit.event_times.size)
    partners = [-1] * orbit.event_times.size
    own, others = _events(orbit), _events(other)
    mine = theirs = 0
    while mine < len(own):
        if _is_same(own, mine, others, theirs):
            partners[mine] = theirs
            mine, theirs = mine + 1, theirs + 1
        elif _is_same(own, mine + 2, others, theirs):
            mine += 2
        elif _is_same(own, mine, others, theirs + 2):
            theirs += 2
        else:
            break
    return np.array(partners, dtype=np.intp)


def _reach(orbit: Orbit) -> Values:
    """Return how far away the partner of each event may be [1]."""
    times = orbit.event_times
    gaps = np.full(times.size + 1, np.inf)
    gaps[1:-1] = times[1:] - times[:-1]
    return np.asarray(SAME_EVENT * np.minimum(gaps[:-1], gaps[1:]))


def _events(orbit: Orbit) -> list[Event]:
    """Return kind and time of each event, and how far away its partner may be."""
    # a loop over plain numbers takes a fifth of one over those of NumPy
    rows = (orbit.event_kinds, orbit.event_times, _reach(orbit))
    return list(zip(*(row.tolist() for row in rows), strict=True))


def _is_same(own: list[Event], mine: int, others: list[Event], theirs: int) -> bool:
    if mine >= len(own) or theirs >= len(others):
        return False
    kind, time, reach = own[mine]
    other_kind, other_time, other_reach = others[theirs]
    return kind == other_kind and abs(time - other_time) <= min(reach, other_reach)


def _remembered(differences: Values) -> Values:
    """Return the largest of each difference and the ones before it, within the memory."""
    known = np.where(np.isfinite(differences), differences, 0.0)
    largest = known.copy()
    for back in range(1, MEMORY):
        np.maximum(largest[back:], known[:-back], out=largest[back:])
    return largest


def _rounding(orbit: Orbit) -> Values:
    """Return the errors of rounding: of the time, and of the radius over its rate.

    An event's time is a sum of as many spans as there are events up to it, each rounded.
    """
    x, y, vx, vy = orbit.event_states.T
    delta0 = orbit.rotor.delta0
    rate = np.abs(x * vx + y * vy) / delta0 if delta0 > 0.0 else np.ones_like(x)
    loose = np.abs(orbit.event_kinds) == PRESS
    if loose.any():
        rate[loose] = np.abs(_radial_acceleration(orbit)[loose])
    turned = orbit.event_angles
    moved = np.hypot(vx, vy) * orbit.event_times
    radius = 4.0 * ROUNDING * (2.0 + 2.0 * delta0 + turned + moved)
    if orbit.rotor.friction > 0.0:
        of_friction = np.isin(orbit.event_kinds, (ROLL, SLIP, REVERSE))
        sizes, rates = _guards_of_friction(orbit)
        radius[of_friction] = (4.0 * ROUNDING * (2.0 + turned) * sizes)[of_friction]
        rate[of_friction] = rates[of_friction]
    spans = np.sqrt(1.0 + np.arange(orbit.event_times.size))
    with np.errstate(divide="ignore"):
        return np.asarray(4.0 * np.spacing(orbit.event_times) * spans + radius / rate)


def _guards_of_friction(orbit: Orbit) -> tuple[Values, Values]:
    """Return what the guards of friction are made of at each event, and how fast they change.

    Before the disc begins to roll, or slides the other way, that is the slip speed, which changes
    by ``F - mu sigma N``; before it begins to slip, ``mu N - |F|``. Of a speed that changes the
    angular acceleration counts, and not how that changes itself.
    """
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.event_states.T
    rho, n = rotor.disc_radius or 0.0, rotor.contact_exponent
    rim = rho * orbit.event_speeds
    radius = np.hypot(x, y)
    rise, turn = (x * vx + y * vy) / radius, np.arctan2(y, x)
    lag, square = orbit.event_angles - turn, orbit.event_speeds**2
    depth = np.maximum(radius - rotor.delta0, np.finfo(float).tiny)
    factor = 1.0 + rotor.contact_damping * rise
    normal = depth**n * factor
    hold = square * np.sin(lag) - rotor.load * np.cos(turn)
    hold += rim * (2.0 * rotor.zeta + rise / radius)
    assert orbit.ways is not None
    before = orbit.ways[:-1]
    faster, lever = _quickening(orbit, hold, normal)
    hold = hold + faster * lever
    slowing = np.abs(hold - rotor.friction * before * normal)
    drive = square * np.cos(lag) - rotor.load * np.sin(turn)
    bend = drive + rim**2 / radius - 2.0 * rotor.zeta * rise - rotor.shaft_stiffness * radius
    bend -= normal
    grip_rate = n * depth ** (n - 1.0) * rise * factor + depth**n * rotor.contact_damping * bend
    hold_rate = square * np.cos(lag) * (orbit.event_speeds + rim / radius)
    hold_rate -= rotor.load * np.sin(turn) * rim / radius
    hold_rate += rim * (bend - rise**2 / radius) / radius
    hold_rate += faster * np.sin(lag) * (orbit.event_speeds + rim / radius)
    hold_rate += faster * 2.0 * orbit.event_speeds * np.sin(lag)
    hold_rate += faster * rho * (2.0 * rotor.zeta + rise / radius)
    losing = np.abs(rotor.friction * grip_rate - np.sign(hold) * hold_rate)
    slips = orbit.event_kinds == SLIP
    forces = square + rotor.load + rim * (2.0 * rotor.zeta + np.abs(rise) / radius) + normal
    forces = forces + np.abs(faster) * (rho + 1.0)
    speeds = np.hypot(vx, vy) + rim + forces * orbit.event_times
    return np.where(slips, forces, speeds), np.where(slips, losing, slowing)


def _quickening(orbit: Orbit, hold: Values, normal: Values) -> tuple[Values, Values]:
    """Return the angular acceleration before each event, and the lever of friction [1].

    `hold` is the force that rolling takes at the speed of the moment, `normal` the normal force.
    """
    if orbit.speed_record is None or orbit.ways is None:
        return np.zeros_like(hold), np.zeros_like(hold)
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.event_states.T
    angle, speed = orbit.speed_record.events["angle"], orbit.speed_record.events["speed"]
    cos, sin, radius = np.cos(angle), np.sin(angle), np.hypot(x, y)
    lever = (rotor.disc_radius or 0.0) - (cos * x + sin * y) / radius
    rolls = orbit.ways[:-1] == ROLLS
    across = np.where(rolls, hold, rotor.friction * orbit.ways[:-1] * normal)
    stiffness = rotor.shaft_stiffness + normal / radius
    resisted = -2.0 * rotor.zeta * (cos * vy - sin * vx) - stiffness * (cos * y - sin * x)
    faster = orbit.speed_record.profile.accelerations(
        orbit.event_times, speed, resisted + across * lever, np.where(rolls, lever**2, 0.0)
    )
    return faster, lever


def _radial_acceleration(orbit: Orbit) -> Values:
    """Return the rate of the radial velocity at each event, where the normal force is 0."""
    x, y, vx, vy = orbit.event_states.T
    rotor, radius, angle = orbit.rotor, np.hypot(x, y), orbit.event_angles
    machine = SimpleNamespace(
        omega=orbit.event_speeds, zeta=rotor.zeta, shaft_stiffness=rotor.shaft_stiffness,
        load=rotor.load,
    )  # fmt: skip
    at = Moment((x, y), (vx, vy), (x, y), (np.cos(angle), np.sin(angle)), (0.0, -1.0))
    ax, ay = accelerations(at, 0.0, machine)
    around = (x * vy - y * vx) / radius
    return np.asarray((x * ax + y * ay + around**2) / radius)


def _horizon(orbit: Orbit, other: Orbit, partners: npt.NDArray[np.intp]) -> float:
    """Return the time at which the two orbits part, by their samples or by their events."""
    size = _largest_near(np.hypot(orbit.states[:, 0], orbit.states[:, 1]))
    apart = np.hypot(*(orbit.states[:, :2] - other.states[:, :2]).T)
    astray = np.flatnonzero(apart > ASTRAY * size)
    horizon = float(orbit.times[astray[0]]) if astray.size else orbit.duration
    known = np.flatnonzero(partners >= 0)
    last = known[-1] if known.size else -1
    lost = orbit.event_times[last + 1 :]
    unmatched_tail = lost.size > 2 or (lost.size and other.event_times.size > known.size + 2)
    return min(horizon, float(lost[0])) if unmatched_tail else horizon


def _largest_near(values: Values) -> Values:
    """Return the largest of each value and its neighbours on either side."""
    largest = values.copy()
    for aside in range(1, NEAR + 1):
        np.maximum(largest[aside:], values[:-aside], out=largest[aside:])
        np.maximum(largest[:-aside], values[aside:], out=largest[:-aside])
    return largest
