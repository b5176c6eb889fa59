"""Estimate the error of event times, and the horizon after which there is no estimate.

Whatever its method, the motion is simulated a second time by Taylor series, with thirty times
tighter tolerances and few samples. This costs a tenth of a CVODE run and is far more accurate, so
the difference is the error itself. For a motion by Taylor series at tight tolerances, rounding
contributes to it. The difference is multiplied by a safety factor, since it may contain the second
run's own error. Both runs must not round alike: the second run of a rotor system has another order,
and where the second tolerance would be below rounding, that of one disc uses a rotor that differs
in the last bit.

Taylor series take a step every few radians of the fastest possible motion or decay of the rotor,
even where nothing moves. On a steady whirl, or with heavy damping, CVODE takes longer steps: a long
CVODE run is repeated by CVODE itself, at thirty times looser tolerances. The difference is then the
error of the looser run and bounds that of the tighter one.

A difference of times may vanish by chance, so each event takes the largest of its own error and
those of the few events before it at the same contact. The states at the event may differ even so:
each error of one disc is at least a part of that of the states, as far as the event's guard may
feel it, over the guard's rate. ``docs/events.md`` shows how well this covers the reference cases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ROUNDING, Stop, Values, Watch
from rotor_ida.checks import State
from rotor_ida.core.systems import SystemEvents, SystemResult
from rotor_ida.errors import SimulationError
from rotor_ida.model.contact import damping_factor, spring_force, spring_slope
from rotor_ida.model.forces import Moment, accelerations, with_values
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ENTRY, OF_FRICTION, PRESS, ROLLS, SLIP
from rotor_ida.simulation.options import LOOSEST_RTOL_OF_TAYLOR, Options
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run

Kinds = npt.NDArray[np.integer[Any]]
Numbers = npt.NDArray[np.intp]

APART = 30.0
MEMORY = 4
# Safety factor on the difference, and on the bound on rounding. A run may be more accurate than its
# tolerance, and then agrees too well with the second. Of 772 runs of the reference cases, two per
# decade of rtol, three would have needed more than 5, and none more than 9.
WIDENING, OF_ROUNDING = 10.0, 0.5
# The part of the bound by the states that counts: of 350,000 events of random machines none then
# exceeds its stated error, and the times alone leave out one in ten thousand.
FELT = 0.3
# Radians of the fastest motion above which a run is long.
LONG = 1e6
# Samples of the second run: they resolve the time at which the two orbits separate.
MOST_SAMPLES = 64
# Two events correspond when they are of one kind and no further apart than this fraction of the
# time to the next or the previous one.
SAME_EVENT = 0.25
# Two orbits have separated when they differ by more than this fraction of the motion's size.
ASTRAY = 1e-2
# The size of the motion is its largest radius over this many samples on either side, about a
# sixteenth of a run: one sample may be near the centre, and an early transient may be large.
NEAR = 2


@dataclass(frozen=True, slots=True)
class EventErrors:
    """The estimated errors of an orbit.

    Parameters
    ----------
    event_time_errors : ndarray, shape (m,)
        Estimated error of each event time [1]; infinite after the horizon, and for a touch or
        a departure that the tolerances do not resolve.
    horizon : float
        Time up to which the start determines the orbit at these tolerances [1]; the end of the run
        if it does throughout.
    """

    event_time_errors: Values
    horizon: float


# ---- The same events of two runs ----


def partners_of(
    times: Values, kinds: Kinds, other_times: Values, other_kinds: Kinds, *, skips: bool
) -> Numbers:
    """Return the number of the same event in another run, -1 where there is none.

    A slight touch, or a slight departure, may appear in one run only: with `skips` a pair of events
    without a partner is left out. If more than a pair is missing, the runs have separated.
    """
    own, other = _events(times, kinds), _events(other_times, other_kinds)
    partners, mine, theirs = np.full(times.size, -1, np.intp), 0, 0
    while True:
        count = _count_same(own[:, mine:], other[:, theirs:])
        partners[mine : mine + count] = np.arange(theirs, theirs + count)
        mine, theirs = mine + count, theirs + count
        if skips and _count_same(own[:, mine + 2 :], other[:, theirs:]):
            mine += 2
        elif skips and _count_same(own[:, mine:], other[:, theirs + 2 :]):
            theirs += 2
        else:
            return partners


def _events(times: Values, kinds: Kinds) -> Values:
    """Return time and kind of each event, and how far away its partner may be, shape (3, n)."""
    gaps = np.full(times.size + 1, np.inf)
    gaps[1:-1] = times[1:] - times[:-1]
    return np.array([times, kinds, SAME_EVENT * np.minimum(gaps[:-1], gaps[1:])])


def _count_same(own: Values, other: Values) -> int:
    """Return how many events are the same in two runs up to the first that differs."""
    count = min(own.shape[1], other.shape[1])
    (times, kinds, reach), (there, of_kind, reached) = own[:, :count], other[:, :count]
    same = (kinds == of_kind) & (np.abs(times - there) <= np.minimum(reach, reached))
    return count if same.all() else int(np.argmin(same))


def _late(times: Values, other_times: Values, partners: Numbers) -> Values:
    """Return how much later than its partner each event is; infinite without one."""
    late, found = np.full(times.size, np.inf), partners >= 0
    late[found] = times[found] - other_times[partners[found]]
    return late


def _remembered(errors: Values) -> Values:
    """Return the largest of each error and the finite ones of the few events before it."""
    finite, largest = np.where(np.isfinite(errors), errors, 0.0), errors.copy()
    for back in range(1, MEMORY):
        np.maximum(largest[back:], finite[:-back], out=largest[back:])
    return largest


def _rounded(times: Values) -> Values:
    """Return the rounding errors of times, each a sum of a span for each event up to it."""
    return np.asarray(4.0 * np.spacing(times) * np.sqrt(1.0 + np.arange(times.size)))


# ---- Of a rotor system ----


def errors_of(
    result: SystemResult, other: SystemResult | SystemEvents, contacts: int, duration: float
) -> EventErrors:
    """Return the errors of the events of a run by another one, each contact by itself.

    The horizon is the first event of a contact that the other run does not have.
    """
    errors, horizon = np.empty(result.event_times.size), duration
    for contact in range(contacts):
        here, times, other_times, late = _at_contact(result, other, contact)
        errors[here] = WIDENING * _remembered(late) + _rounded(times)
        count = int(np.count_nonzero(np.isfinite(late)))
        parted = times[count:] if count < times.size else other_times[count:]
        horizon = min([horizon, *parted[:1].tolist()])
    errors[result.event_times > horizon] = np.inf
    return EventErrors(errors, horizon)


def shifts_of(result: SystemResult, other: SystemResult, contacts: int) -> Values:
    """Return how far the events of a run move in another one; infinite from where they differ."""
    shifts = np.empty(result.event_times.size)
    for contact in range(contacts):
        here, _, _, late = _at_contact(result, other, contact)
        shifts[here] = late
    return shifts


def _at_contact(
    result: SystemResult, other: SystemResult | SystemEvents, contact: int
) -> tuple[Numbers, Values, Values, Values]:
    """Return the events of a contact: places, times, times in another run, and differences."""
    here, there = (np.flatnonzero(each.event_contacts == contact) for each in (result, other))
    times, other_times = result.event_times[here], other.event_times[there]
    partners = partners_of(
        times, result.event_kinds[here], other_times, other.event_kinds[there], skips=False
    )
    return here, times, other_times, np.abs(_late(times, other_times, partners))


# ---- Of one disc ----


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
    partners = partners_of(
        orbit.event_times, orbit.event_kinds, other.event_times, other.event_kinds, skips=True
    )
    rates, rounded = _rates_and_rounding(orbit)
    errors = _differences(orbit, other, partners, rates, widening) + of_rounding * rounded
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
    depth = max(farthest - delta0, float(orbit.contacts["peak_root"].max(initial=0.0)) ** 2)
    exponent = rotor.contact_exponent
    stiffness = spring_slope(depth, exponent) + rotor.shaft_stiffness
    decay = 2.0 * zeta + rotor.contact_damping * spring_force(depth, exponent)
    return float(omega + decay + np.sqrt(stiffness))


def _nearest(rotor: Rotor) -> Rotor:
    """Return a rotor whose speed and clearance differ by the spacing of doubles."""
    omega, delta0 = (
        float(np.nextafter(value, np.inf)) if value > 0.0 else 0.0
        for value in (rotor.omega, rotor.delta0)
    )
    return replace(rotor, omega=omega, delta0=delta0)


def _differences(
    orbit: Orbit, other: Orbit, partners: Numbers, rates: Values, widening: float
) -> Values:
    """Return the error of each event by the other orbit; infinite where that has no such event."""
    found, late = partners >= 0, _late(orbit.event_times, other.event_times, partners)
    apart = np.zeros_like(orbit.event_states)
    apart[found] = orbit.event_states[found] - other.event_states[partners[found]]
    apart[found] -= _drift(orbit)[found] * late[found, np.newaxis]  # at one time
    with np.errstate(divide="ignore", invalid="ignore"):  # 0/0 where the states agree
        by_states = np.nan_to_num(_guards_apart(orbit, apart) / rates, nan=0.0, posinf=np.inf)
    return _remembered(np.maximum(widening * np.abs(late), FELT * by_states))


def _guards_apart(orbit: Orbit, apart: Values) -> Values:
    """Return by how much the guard of each event may differ between two orbits.

    `apart` are the differences of the states at the events. They bound the difference of the
    guards by its derivatives: of the radius at an entry or exit, the radial velocity at a press or
    release, the slip speed or the grip at an event of friction. The error of the radius is also
    what that of the velocity makes of it since the last event, within a radian.
    """
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.event_states.T
    kinds, radius, speed = orbit.event_kinds, np.hypot(x, y), np.hypot(vx, vy)
    by_place = np.where(np.abs(kinds) == ENTRY, 1.0, speed / radius)
    since = np.diff(orbit.event_times, prepend=0.0)
    lever = np.minimum(since, 1.0 / np.maximum(orbit.event_speeds, 1.0))
    by_velocity = np.where(np.abs(kinds) == ENTRY, lever, 1.0)
    if rotor.friction > 0.0:
        n, slips = rotor.contact_exponent, kinds == SLIP
        depth = np.maximum(radius - rotor.delta0, 0.0)
        rim = (rotor.disc_radius or 0.0) * orbit.event_speeds
        damped = rotor.friction * rotor.contact_damping * spring_force(depth, n)
        stiffness = rotor.friction * spring_slope(depth, n) + damped * speed / radius
        drive = (orbit.event_speeds**2 + rotor.load + rim * speed / radius) / radius
        by_place = np.where(slips, stiffness + drive, by_place)
        by_velocity = np.where(slips, damped + rim / radius, by_velocity)
    displaced, faster = np.hypot(*apart[:, :2].T), np.hypot(*apart[:, 2:].T)
    return np.asarray(by_place * displaced + by_velocity * faster)


def _rates_and_rounding(orbit: Orbit) -> tuple[Values, Values]:
    """Return the rates of the guards, and the rounding errors of the times.

    These are that of the time itself, a sum of rounded spans, one for each event up to it; and that
    of the guard over its rate.
    """
    x, y, vx, vy = orbit.event_states.T
    delta0 = orbit.rotor.delta0
    rate = np.abs(x * vx + y * vy) / delta0 if delta0 > 0.0 else np.ones_like(x)
    loose = np.abs(orbit.event_kinds) == PRESS
    if loose.any():
        (*_, ax, ay), size = _drift(orbit).T, np.hypot(x, y)
        rate[loose] = np.abs((x * ax + y * ay + ((x * vy - y * vx) / size) ** 2) / size)[loose]
    turned = orbit.event_angles
    moved = np.hypot(vx, vy) * orbit.event_times
    radius = 4.0 * ROUNDING * (2.0 + 2.0 * delta0 + turned + moved)
    if orbit.rotor.friction > 0.0:
        of_friction = np.isin(orbit.event_kinds, OF_FRICTION)
        sizes, rates = _guards_of_friction(orbit)
        radius[of_friction] = (4.0 * ROUNDING * (2.0 + turned) * sizes)[of_friction]
        rate[of_friction] = rates[of_friction]
    with np.errstate(divide="ignore"):
        return rate, _rounded(orbit.event_times) + radius / rate


def _guards_of_friction(orbit: Orbit) -> tuple[Values, Values]:
    """Return the size of the friction guards at each event, and their rate of change.

    Before the disc begins to roll, or reverses its sliding, the guard is the slip speed, whose rate
    is ``F - mu sigma N``; before it begins to slip, ``mu N - |F|``. At a changing speed the angular
    acceleration counts, but not its rate of change.
    """
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.event_states.T
    rho, n = rotor.disc_radius or 0.0, rotor.contact_exponent
    rim = rho * orbit.event_speeds
    radius = np.hypot(x, y)
    rise, turn = (x * vx + y * vy) / radius, np.arctan2(y, x)
    lag, square = orbit.event_angles - turn, orbit.event_speeds**2
    depth = np.maximum(radius - rotor.delta0, np.finfo(float).tiny)
    factor, spring = damping_factor(rise, rotor.contact_damping), spring_force(depth, n)
    normal = spring * factor
    hold = square * np.sin(lag) - rotor.load * np.cos(turn)
    hold += rim * (2.0 * rotor.zeta + rise / radius)
    assert orbit.modes is not None
    before = orbit.modes[:-1]
    faster, lever = _quickening(orbit, hold, normal)
    hold = hold + faster * lever
    slowing = np.abs(hold - rotor.friction * before * normal)
    drive = square * np.cos(lag) - rotor.load * np.sin(turn)
    bend = drive + rim**2 / radius - 2.0 * rotor.zeta * rise - rotor.shaft_stiffness * radius
    bend -= normal
    grip_rate = spring_slope(depth, n) * rise * factor + spring * rotor.contact_damping * bend
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

    `hold` is the force that rolling needs at the current speed, `normal` the normal force.
    """
    if orbit.speed_record is None:
        return np.zeros_like(hold), np.zeros_like(hold)
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.event_states.T
    angle, speed = orbit.speed_record.events["angle"], orbit.speed_record.events["speed"]
    cos, sin, radius = np.cos(angle), np.sin(angle), np.hypot(x, y)
    lever = (rotor.disc_radius or 0.0) - (cos * x + sin * y) / radius
    modes = orbit.event_kinds * 0 if orbit.modes is None else orbit.modes[:-1]
    rolls = modes == ROLLS
    across = np.where(rolls, hold, rotor.friction * modes * normal)
    stiffness = rotor.shaft_stiffness + normal / radius
    resisted = -2.0 * rotor.zeta * (cos * vy - sin * vx) - stiffness * (cos * y - sin * x)
    faster = orbit.speed_record.profile.accelerations(
        orbit.event_times, speed, resisted + across * lever, np.where(rolls, lever**2, 0.0)
    )
    return faster, lever


def _drift(orbit: Orbit) -> Values:
    """Return the rates of the states at the events, with accelerations where there is no force.

    At an event of friction that of the velocity is left 0: there it jumps.
    """
    x, y, vx, vy = orbit.event_states.T
    rotor, angle = orbit.rotor, orbit.event_angles
    machine = with_values(rotor, omega=orbit.event_speeds)
    cos, sin, none = np.cos(angle), np.sin(angle), np.zeros_like(x)
    at = Moment((x, y), (vx, vy), (x, y), (cos, sin), (0.0, -1.0))
    spin_up, _ = _quickening(orbit, none, none)
    faster = np.array(accelerations(at, 0.0, machine)) + spin_up * np.array([sin, -cos])
    if rotor.friction > 0.0:
        faster = np.where(np.isin(orbit.event_kinds, OF_FRICTION), 0.0, faster)
    return np.array([vx, vy, *faster]).T


def _horizon(orbit: Orbit, other: Orbit, partners: Numbers) -> float:
    """Return the time at which the two orbits separate, by their samples or by their events."""
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
