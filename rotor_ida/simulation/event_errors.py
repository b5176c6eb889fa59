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
error of the looser run and bounds that of the tighter one. Where there is no core, the reference
repeats every run in this way.

A difference of times may vanish by chance, so each event takes the largest of its own error and
those of the few events before it at the same contact. The states at the event may differ even so:
each error is at least a part of that of the states, as far as the event's guard may feel it, over
the guard's rate. Of one disc that follows from its forces; of a rotor system the core reports it.
``docs/validation.md`` shows how well this covers the reference cases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ROUNDING, Stop, Values, Watch, filled
from rotor_ida.checks import State
from rotor_ida.core.library import why_missing
from rotor_ida.core.system_requests import SystemEvents, SystemRequest, SystemResult
from rotor_ida.errors import SimulationError
from rotor_ida.model.contact import (
    HERTZ_EXPONENT,
    damping_factor,
    slope_of_root,
    spring_force,
    spring_of_root,
    spring_slope,
)
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
        Estimated error of each event time [dimensionless]; infinite after the horizon, and for a
        touch or a departure that the tolerances do not resolve.
    horizon : float
        Time up to which the start determines the orbit at these tolerances [dimensionless]; the end
        of the run if it does throughout.
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
    while mine < times.size:
        count = _count_same(own[:, mine:], other[:, theirs:])
        partners[mine : mine + count] = np.arange(theirs, theirs + count)
        mine, theirs = mine + count, theirs + count
        if skips and _count_same(own[:, mine + 2 :], other[:, theirs:]):
            mine += 2
        elif skips and _count_same(own[:, mine:], other[:, theirs + 2 :]):
            theirs += 2
        else:
            break
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


# ---- How far apart two runs are ----


class _Apart(NamedTuple):
    """The events of one contact, and the differences of the states of two runs there.

    Parameters
    ----------
    kinds, radius, speed : ndarray, shape (m,)
        Kinds of the events; distance from the centre of the contact, and speed.
    displaced, faster : ndarray, shape (m,)
        Sizes of the differences of displacement and velocity.
    lever : ndarray, shape (m,)
        The time for which the difference of the velocity has moved the radius.
    depth : ndarray, shape (m,)
        Indentation.
    held : ndarray, shape (m,) or float
        The difference of the tangential force that rolling needs.
    law : SimpleNamespace or record of `rotor_ida.core.system_requests.LAW`
        The law of the contact: ``hertz``, ``linear``, ``contact_damping`` and ``friction``.
    """

    kinds: Kinds
    radius: Values
    speed: Values
    displaced: Values
    faster: Values
    lever: Values
    depth: Values
    held: Values | float
    law: Any

    def guards(self) -> Values:
        """Return by how much the guard of each event may differ.

        The differences of the states bound that by its derivatives: of the radius at an entry or
        exit, the radial velocity at a press or release, the slip speed or the grip at an event of
        friction. The error of the radius is also what that of the velocity makes of it since the
        last event, within a radian.
        """
        on_edge, turning = np.abs(self.kinds) == ENTRY, self.speed / self.radius
        by_place = np.where(on_edge, 1.0, turning)
        by_velocity = np.where(on_edge, self.lever, 1.0)
        differs = np.asarray(by_place * self.displaced + by_velocity * self.faster)
        slips = self.kinds == SLIP
        if not slips.any():
            return differs
        root = np.sqrt(self.depth)
        resistance = self.law.contact_damping * spring_of_root(root, self.law)
        stiffness = slope_of_root(root, self.law) + resistance * turning
        pressed = stiffness * self.displaced + resistance * self.faster
        gripped = self.law.friction * pressed + self.held
        return np.where(slips, gripped, differs)


def _errors(late: Values, apart: _Apart, rates: Values, widening: float) -> Values:
    """Return the error of each event of a contact by another run; `rates` are those of the guards.

    It is infinite where the other run has no such event.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # 0/0 where the states agree
        by_states = filled(apart.guards() / rates, 0.0)
    return _remembered(np.maximum(widening * np.abs(late), FELT * by_states))


def _separation(times: Values, places: Values, others: Values, least: float) -> float:
    """Return when two orbits separate by their samples, shape (n, 2); infinite if they do not.

    The motion counts as no smaller than `least`.
    """
    size = np.maximum(_largest_near(np.hypot(*places.T)), least)
    astray = np.flatnonzero(np.hypot(*(places - others).T) > ASTRAY * size)
    return float(times[astray[0]]) if astray.size else np.inf


# ---- Of a rotor system ----


def errors_of_system(
    request: SystemRequest, result: SystemResult, other: SystemResult, times: Values
) -> EventErrors:
    """Return the errors of the events of a run by another one, each contact by itself.

    Parameters
    ----------
    request : SystemRequest
        The system.
    result, other : SystemResult
        The run, and another. The reference knows no rates of the guards, so that only the times
        count where it did the other.
    times : ndarray
        Times of the samples of the other run, as of `times_of_second`.
    """
    errors, horizon = np.empty(result.event_times.size), horizon_of(request, result, other)
    sampled = np.flatnonzero(request.times <= other.time)[:: _thinning(request.times)]
    there = np.searchsorted(times, request.times[sampled])
    for number, law in enumerate(request.laws.view(np.recarray)):
        places, others = (
            each[:, 0] @ request.rows[number].T - law.offset
            for each in (result.samples[sampled], other.samples[there])
        )
        separation = _separation(request.times[sampled], places, others, law.clearance)
        horizon = min(horizon, separation)
        here, late, partners = _at_contact(result, other, number)
        if not here.size:
            continue
        apart = _apart_in_system(request, result, other, number, here, partners, times)
        rates = np.append(filled(other.event_rates, np.inf), np.inf)[partners]
        errors[here] = _errors(late, apart, rates, WIDENING)
        errors[here] += _rounded(result.event_times[here])
    # one event may bring others about, which then have its time
    _, moments = np.unique(result.event_times, return_inverse=True)
    shared = np.zeros(moments.max(initial=-1) + 1)
    np.maximum.at(shared, moments, errors)
    errors = shared[moments]
    errors[result.event_times > horizon] = np.inf
    return EventErrors(errors, horizon)


def _thinning(times: Values) -> int:
    """Return of how many samples one is enough to tell when two orbits separate."""
    return max(1, times.size // MOST_SAMPLES)


def times_of_second(request: SystemRequest, result: SystemResult) -> Values:
    """Return the times at which the second run of a system is sampled: events too, and the end."""
    thinned = request.times[:: _thinning(request.times)]
    return np.unique(np.concatenate([result.event_times, thinned, request.times[-1:]]))


def horizon_of(
    request: SystemRequest, result: SystemResult, other: SystemResult | SystemEvents
) -> float:
    """Return the first event of a contact that only one of two runs has; else the end."""
    horizon = request.duration
    for number in range(len(request.laws)):
        here, late, _ = _at_contact(result, other, number)
        count = int(np.count_nonzero(np.isfinite(late)))
        others = other.event_times[other.event_contacts == number]
        parted = result.event_times[here[count:]] if count < here.size else others[count:]
        horizon = min([horizon, *parted[:1].tolist()])
    return horizon


def _apart_in_system(
    request: SystemRequest, result: SystemResult, other: SystemResult, number: int,
    here: Numbers, partners: Numbers, times: Values,
) -> _Apart:  # fmt: skip
    """Return how far apart two runs are at the events of a contact, at the times of the first."""
    law, rows = request.laws.view(np.recarray)[number], request.rows[number]
    kinds, spins = result.event_kinds[here], result.event_turns[here, 1]
    sampled = np.searchsorted(times, result.event_times[here])
    apart = result.event_states[here] - other.samples[sampled]
    place, velocity = np.moveaxis(result.event_states[here] @ rows.T, 1, 0)
    radius, speed = np.hypot(*(place - law.offset).T), np.hypot(*velocity.T)
    displaced, faster = (np.hypot(*each.T) for each in np.moveaxis(apart @ rows.T, 1, 0))
    turning = speed / radius
    turned = turning * (2.0 * faster + turning * displaced)
    held = _hold_apart(request, rows, apart, spins, turned)
    races = np.append(other.event_races[:, number], np.nan)[partners]
    rims = law.radius * np.abs(spins - other.turns[sampled, 1])
    rims += law.race_radius * np.abs(result.event_races[here, number] - races)
    return _Apart(
        kinds, radius, speed, displaced,
        faster=faster + np.where(np.isin(kinds, OF_FRICTION), rims, 0.0),
        lever=np.minimum(
            np.diff(result.event_times[here], prepend=0.0), request.displacement / request.velocity
        ),
        depth=np.maximum(radius - law.clearance, 0.0), held=held, law=law,
    )  # fmt: skip


def _hold_apart(
    request: SystemRequest, rows: Values, apart: Values, spins: Values, turned: Values
) -> Values:
    """Return by how much the forces that keep a contact rolling may differ.

    `turned` is the difference of what the turn of the contact accelerates its slip.
    """
    inert = request.force.size - request.massless
    pulled = apart[:, 0] @ request.stiffness.T
    if request.massless and rows[:, inert:].any():  # the force moves the stator at once
        drifted = pulled[:, inert:] @ rows[:, inert:].T
        moved = apart[:, 1, :inert] @ rows[:, :inert].T - drifted
        return np.asarray(np.hypot(*moved.T) / (rows[0, inert:] ** 2).sum())
    if request.damping is not None:
        pulled += apart[:, 1] @ request.damping.T
    if request.gyroscopic is not None:
        pulled += spins[:, np.newaxis] * (apart[:, 1] @ request.gyroscopic.T)
    if request.films:
        for name, moved in zip(("stiffness", "damping"), np.moveaxis(apart, 1, 0), strict=True):
            pulled += request.films.product(name, spins, moved.T).T
    mobility = float(np.linalg.norm(rows[:, :inert], -2)) ** 2
    slipped = np.hypot(*(pulled[:, :inert] @ rows[:, :inert].T).T)
    return np.asarray((slipped + turned) / mobility)


def shifts_of(result: SystemResult, other: SystemResult, contacts: int) -> Values:
    """Return how far the events of a run move in another one; infinite from where they differ."""
    shifts = np.empty(result.event_times.size)
    for contact in range(contacts):
        here, late, _ = _at_contact(result, other, contact)
        shifts[here] = late
    return shifts


def _at_contact(
    result: SystemResult, other: SystemResult | SystemEvents, contact: int
) -> tuple[Numbers, Values, Numbers]:
    """Return the events of a contact: places, differences of time and places in another run."""
    here, there = (np.flatnonzero(each.event_contacts == contact) for each in (result, other))
    times, other_times = result.event_times[here], other.event_times[there]
    partners = partners_of(
        times, result.event_kinds[here], other_times, other.event_kinds[there], skips=False
    )
    late = np.abs(_late(times, other_times, partners))
    return here, late, np.append(there, -1)[partners]


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
        Its start ``(x, y, vx, vy)``, fixed frame [dimensionless].
    slack, stop, watch
        As for `run`.
    """
    rotor, options, scale = orbit.rotor, orbit.options, APART
    widening, of_rounding = 1.0, 1.0
    if options.method == "taylor" or (
        not why_missing() and _fastest(orbit) * orbit.duration <= LONG
    ):
        rtol = min(options.rtol, LOOSEST_RTOL_OF_TAYLOR)
        options, scale = Options(rtol=rtol, atol=options.atol, method="taylor"), 1.0 / APART
        widening, of_rounding = WIDENING, OF_ROUNDING
        if rtol < APART * ROUNDING:
            rotor = _nearest(rotor)
    profile = None if orbit.speed_record is None else orbit.speed_record.profile
    every = _thinning(orbit.times)
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
    late = _late(orbit.event_times, other.event_times, partners)
    apart = _apart_of_disc(orbit, other, late, partners)
    errors = _errors(late, apart, rates, widening) + of_rounding * rounded
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


def _apart_of_disc(orbit: Orbit, other: Orbit, late: Values, partners: Numbers) -> _Apart:
    """Return how far apart two orbits are at the events of the first, at one time."""
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.event_states.T
    found, apart = partners >= 0, np.zeros_like(orbit.event_states)
    apart[found] = orbit.event_states[found] - other.event_states[partners[found]]
    apart[found] -= _drift(orbit)[found] * late[found, np.newaxis]
    radius, speed = np.hypot(x, y), np.hypot(vx, vy)
    displaced, faster = np.hypot(*apart[:, :2].T), np.hypot(*apart[:, 2:].T)
    rim = (rotor.disc_radius or 0.0) * orbit.event_speeds
    drive = orbit.event_speeds**2 + rotor.load + rim * speed / radius
    since = np.ediff1d(orbit.event_times, to_begin=orbit.event_times[:1])
    is_hertz = float(rotor.contact_exponent == HERTZ_EXPONENT)
    return _Apart(
        orbit.event_kinds, radius, speed, displaced, faster,
        lever=np.minimum(since, 1.0 / np.maximum(orbit.event_speeds, 1.0)),
        depth=np.maximum(radius - rotor.delta0, 0.0),
        held=(drive * displaced + rim * faster) / radius,
        law=with_values(rotor, hertz=is_hertz, linear=1.0 - is_hertz),
    )  # fmt: skip


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
    """Return the angular acceleration before each event, and the lever of friction [dimensionless].

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
    cos, sin = np.cos(angle), np.sin(angle)
    at = Moment((x, y), (vx, vy), (x, y), (cos, sin), (0.0, -1.0))
    faster = np.array(accelerations(at, 0.0, machine))
    if orbit.speed_record is not None:
        none = np.zeros_like(x)
        faster += _quickening(orbit, none, none)[0] * np.array([sin, -cos])
    if rotor.friction > 0.0:
        faster = np.where(np.isin(orbit.event_kinds, OF_FRICTION), 0.0, faster)
    return np.array([vx, vy, *faster]).T


def _horizon(orbit: Orbit, other: Orbit, partners: Numbers) -> float:
    """Return the time at which the two orbits separate, by their samples or by their events."""
    separation = _separation(orbit.times, orbit.states[:, :2], other.states[:, :2], 0.0)
    horizon = min(separation, orbit.duration)
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
