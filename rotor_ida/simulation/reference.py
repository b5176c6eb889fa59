"""The rotor as the paper states it, followed in plain Python: what ``backend="python"`` runs.

It shares with the compiled core nothing but the stated model. A first-order system in displacement
and velocity is integrated by CVODE or IDA, through the public interface of scikit-sundae; entry and
exit are found as roots of |z| = delta0, and the integration is restarted there, as the force has a
kink. Flight is integrated like a contact; there is no closed form for it here.

    decide the mode at the start: flight, pressed contact, or contact that damping holds loose;
    integrate inside the mode, step by step;
    look at the end of a step, and where the radius turns inside it, for a crossing;
    find it as a root, record it, and begin anew in the mode that follows.

The solver's own root functions are not used. They would find another event where another sample is
asked for, and a second one, for the radius that turns, would see rounding on a steady whirl.
A crossing and its opposite are missed where no step ends between them and the radius turns twice
in one step, or where the touch lies below what the tolerance lets the radius tell.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from rotor_ida.arrays import ROUNDING, Values
from rotor_ida.checks import State
from rotor_ida.core.interface import CONTACT_COLUMNS
from rotor_ida.equations.contact import force_over_radius
from rotor_ida.equations.model import rotated
from rotor_ida.equations.modes import Along, acceleration
from rotor_ida.errors import SimulationError
from rotor_ida.parallel import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import ENTRY, EXIT, PRESS, RELEASE, Orbit

Function = Callable[[Values], float]

# A start on the ring is decided by the first derivative of the radius that rounding cannot hide.
HIDDEN = 16.0 * ROUNDING
# Displacement, velocity, impulse of the force since the contact began, and with contact damping the
# energy lost.
X, Y, VX, VY, IMPULSE, LOST = range(6)
FLIGHT, PRESSED, LOOSE = range(3)
# Parts of a step that are looked at for a release, a press, and the largest force.
LOOKS = 4
# SUNDIALS may need a few calls for a step: after a reading the first one only returns to its end.
MOST_IDLE_STEPS = 100


# ---- The model ----


def rates_of(rotor: Rotor, mode: int) -> Callable[[float, Values, Values], None]:
    """Return the right-hand side of the first-order system in one mode.

    In flight there is no force even beyond the ring, so that a step may look ahead smoothly; and in
    a pressed contact it may pull where the step looks beyond the release.
    """
    omega, delta0 = rotor.omega, rotor.delta0
    exponent, damping = rotor.contact_exponent, rotor.contact_damping

    def rates(time: float, state: Values, rate: Values) -> None:
        x, y, vx, vy = state[:IMPULSE].tolist()
        radius = math.hypot(x, y)
        spring = force_over_radius(radius, delta0, exponent) if mode != FLIGHT else 0.0
        approach = radial_rate_of(state) / radius if spring else 0.0
        secant = spring * (1.0 + damping * approach) if mode == PRESSED else 0.0
        rate[X], rate[Y] = vx, vy
        rate[VX] = acceleration(Along(x, vx, x, math.cos(omega * time)), secant, rotor)
        rate[VY] = acceleration(Along(y, vy, y, math.sin(omega * time), -1.0), secant, rotor)
        rate[IMPULSE] = secant * radius
        if damping > 0.0:
            rate[LOST] = (secant - spring) * radius * approach

    return rates


def mode_of_start(rotor: Rotor, start: State) -> int:
    """Decide the mode at a start at time 0; a contact in which the force would pull is loose."""
    if not starts_in_contact(rotor, start):
        return FLIGHT
    state = first_state(rotor, start)
    held = hold_of(rotor, state)
    if held == 0.0 and radius_of(state) > rotor.delta0:  # what it is about to become
        rate = np.empty_like(state)
        rates_of(rotor, LOOSE)(0.0, state, rate)
        held = hold_of(rotor, state + math.sqrt(HIDDEN) * rate)
    return PRESSED if held > 0.0 else LOOSE


def first_state(rotor: Rotor, start: State) -> Values:
    """Return the state with which a run begins."""
    return np.array([*start, 0.0, 0.0] if rotor.contact_damping > 0.0 else [*start, 0.0])


def starts_in_contact(rotor: Rotor, start: State) -> bool:
    """Decide whether a start at time 0 is in contact.

    On the ring the first of radial velocity, acceleration and jerk that is not zero decides,
    without the force: outwards means contact. Where all vanish the rotor whirls along the ring,
    which is flight.
    """
    z, v = complex(start[0], start[1]), complex(start[2], start[3])
    if rotor.delta0 == 0.0 or abs(abs(z) - rotor.delta0) > 4.0 * ROUNDING * abs(z):
        return abs(z) >= rotor.delta0
    a = rotor.omega**2 - 2.0 * rotor.zeta * v - rotor.shaft_stiffness * z - 1j * rotor.load
    b = 1j * rotor.omega**3 - 2.0 * rotor.zeta * a - rotor.shaft_stiffness * v
    derivatives = [  # of |z|**2/2, each a sum of products
        [(z, v)],
        [(v, v), (z, a)],
        [(v, a), (v, a), (v, a), (z, b)],
    ]
    for products in derivatives:
        total = sum((one.conjugate() * other).real for one, other in products)
        if abs(total) > HIDDEN * sum(abs(one * other) for one, other in products):
            return total > 0.0
    return False


def radius_of(state: Values) -> float:
    """Return |z|."""
    return math.hypot(state[X], state[Y])


def radial_rate_of(state: Values) -> float:
    """Return ``r r' = x vx + y vy``, which changes sign where the radius turns."""
    return float(state[X] * state[VX] + state[Y] * state[VY])


def hold_of(rotor: Rotor, state: Values) -> float:
    """Return ``1 + c d'``, with which the force is 0 where the contact comes loose."""
    if rotor.contact_damping == 0.0:
        return 1.0
    return 1.0 + rotor.contact_damping * radial_rate_of(state) / radius_of(state)


def force_of(rotor: Rotor, state: Values) -> float:
    """Return the normal force of a pressed contact."""
    depth = max(radius_of(state) - rotor.delta0, 0.0)
    return float(depth**rotor.contact_exponent * max(hold_of(rotor, state), 0.0))


# ---- The solver ----


class Integration:
    """A solver of scikit-sundae: one internal step at a time, and any time inside the last.

    Its `step` takes one internal step with ``"onestep"``, and reads the solver's own interpolant
    with ``"normal"`` at a time inside that step. After such a reading the next ``"onestep"``
    returns the end of the step once more, which `advance` passes over.

    Parameters
    ----------
    method : {"adams", "bdf", "ida"}
        CVODE with Adams or BDF, or IDA.
    rates : callable
        ``rates(time, state, rate)`` writes the rate of change.
    tolerances : tuple of float
        Relative and absolute tolerance of one step.
    time, state : float and ndarray
        Where it begins.
    goal : float
        A time to step towards, which limits the first step alone.

    Attributes
    ----------
    low, high : float
        The times at both ends of the last step.
    before, after : ndarray
        The states there.
    """

    def __init__(
        self,
        method: str,
        rates: Callable[[float, Values, Values], None],
        tolerances: tuple[float, float],
        time: float,
        state: Values,
        *,
        goal: float,
    ) -> None:
        # SUNDIALS would write its warnings to standard output.
        os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)
        settings = {"rtol": tolerances[0], "atol": tolerances[1]}
        rate = np.empty_like(state)
        self._solver: Any
        if method == "ida":

            def residual(time: float, state: Values, slope: Values, out: Values) -> None:
                rates(time, state, rate)
                np.subtract(slope, rate, out=out)

            self._solver = IDA(residual, **settings)
            rates(time, state, rate)
            self._solver.init_step(time, state, rate.copy())
        else:
            name = {"adams": "Adams", "bdf": "BDF"}[method]
            self._solver = CVODE(rates, method=name, **settings)
            self._solver.init_step(time, state)
        self._goal = goal
        self.low = self.high = time
        self.before = self.after = state
        self.evaluations = 0

    def advance(self) -> None:
        """Take one internal step; raise `SimulationError` where none can be."""
        self.low, self.before = self.high, self.after
        for _ in range(MOST_IDLE_STEPS):
            found = self._solver.step(self._goal, "onestep")
            if not found.success:
                raise self.failure(str(found.message).strip())
            if not np.isfinite(found.y).all():
                raise self.failure("the state is no longer finite")
            self.high, self.after, self.evaluations = float(found.t), found.y, int(found.nfev)
            if self.high > self.low:
                return
        raise self.failure("time no longer advances")

    def at(self, time: float) -> Values:
        """Return the state at a time of the last step."""
        if time <= self.low or time >= self.high:
            return self.before if time <= self.low else self.after
        found = self._solver.step(time, "normal")
        if not found.success:
            raise self.failure(str(found.message).strip())
        state: Values = found.y
        return state

    def root(self, function: Function, low: float, high: float) -> float:
        """Return where in the last step a function of the state, of two signs, vanishes."""
        spacing = 4.0 * ROUNDING
        return float(
            brentq(lambda time: function(self.at(time)), low, high, xtol=spacing, rtol=spacing)
        )

    def failure(self, message: str) -> SimulationError:
        """Return the error that ends the run where it stands."""
        x, y, vx, vy = self.before[:IMPULSE].tolist()
        return SimulationError(message, time=self.low, state=(x, y, vx, vy))


# ---- The run ----


@dataclass(slots=True)
class _Run:
    """A run on its way: what is asked of it, and what is recorded.

    Samples and events are rows of time and state, contacts those of `Orbit`, and `turns` rows of
    time, kind (-1 or 1) and state of the extrema of the radius.
    """

    rotor: Rotor
    options: Options
    tolerances: tuple[float, float]
    duration: float
    sample_times: list[float]
    stop: Stop | None
    samples: list[Values] = field(default_factory=list)
    events: list[tuple[float, int, Values]] = field(default_factory=list)
    contacts: list[tuple[float, ...]] = field(default_factory=list)
    turns: list[tuple[float, float, Values]] = field(default_factory=list)
    evaluations: int = 0


@dataclass(slots=True)
class _Contact:
    """A contact under way: when it was entered, where it was deepest, its largest force."""

    entry: float
    time: float  # of the peak
    state: Values  # there
    force: float = 0.0

    def pass_by(self, time: float, state: Values) -> None:
        """Look at a place that may be the peak."""
        if radius_of(state) > radius_of(self.state):
            self.time, self.state = time, state

    def feel(self, rotor: Rotor, motion: Integration, end: float) -> None:
        """Look at a step of a damped contact for the largest force."""
        apart = (end - motion.low) / LOOKS
        forces = [force_of(rotor, motion.at(motion.low + apart * k)) for k in range(LOOKS + 1)]
        best = max(range(LOOKS + 1), key=forces.__getitem__)
        if forces[best] > 0.5 * self.force:
            low, high = (motion.low + apart * min(max(k, 0), LOOKS) for k in (best - 1, best + 1))
            found = minimize_scalar(
                lambda time: -force_of(rotor, motion.at(time)),
                bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)},
            )  # fmt: skip
            self.force = max(self.force, forces[best], -float(found.fun))


def run_reference(
    rotor: Rotor,
    start: State,
    duration: float,
    sample_times: Values,
    options: Options,
    *,
    tolerances: tuple[float, float],
    slack: float,
    stop: Stop | None,
) -> Orbit:
    """Do as `rotor_ida.simulation.run.run` does, tolerances of a step given."""
    run = _Run(rotor, options, tolerances, duration, sample_times.tolist(), stop)
    mode = began = mode_of_start(rotor, start)
    contact = _Contact(math.nan, 0.0, first_state(rotor, start))
    time, state, event = 0.0, contact.state, ENTRY
    while event and time < duration:
        if event == ENTRY:
            contact = _Contact(contact.entry, time, state)
        time, state, event = _follow_mode(run, time, state, contact, slack, mode)
        if event:
            run.events.append((time, event, state))
            mode = {ENTRY: PRESSED, EXIT: FLIGHT, RELEASE: LOOSE, PRESS: PRESSED}[event]
        if event == EXIT or (not event and mode != FLIGHT):
            _record_contact(run, contact, time if event else math.nan, state)
        if event in {ENTRY, EXIT}:
            state[IMPULSE:] = 0.0
            contact.entry = time if event == ENTRY else math.nan
    if event and mode != FLIGHT:  # it touches, comes loose or presses as the run ends
        _record_contact(run, _Contact(contact.entry, time, state), math.nan, state)
    return _orbit_of(run, state, began=began != FLIGHT)


def _follow_mode(
    run: _Run, time: float, state: Values, contact: _Contact, slack: float, mode: int
) -> tuple[float, Values, int]:
    """Follow one mode until it ends or the run does; return time and state, and what happened."""
    rates = rates_of(run.rotor, mode)
    motion = Integration(
        run.options.method, rates, run.tolerances, time, state, goal=time + run.duration
    )
    end, event = time, 0
    while not event and end < run.duration:
        if run.stop is not None and run.stop[0]:
            raise motion.failure("interrupted")
        motion.advance()
        turn = _turn_in(motion)
        crossing = _crossing_in(motion, turn, run.rotor.delta0, in_contact=mode != FLIGHT)
        change = _change_in(motion, run.rotor, mode)
        first = min(crossing, change)
        if first <= run.duration + slack:
            ends = EXIT if mode != FLIGHT else ENTRY
            event = ends if crossing <= change else (RELEASE if mode == PRESSED else PRESS)
        end = first if event else min(motion.high, run.duration)
        for candidate in (turn, end):
            if candidate <= end:
                contact.pass_by(candidate, motion.at(candidate))
        if mode == PRESSED and run.rotor.contact_damping > 0.0:
            contact.feel(run.rotor, motion, end)
        _record_step(run, motion, turn, end)
    run.evaluations += motion.evaluations
    state = motion.at(end).copy()
    if event in {ENTRY, EXIT}:
        state[:VX] *= run.rotor.delta0 / radius_of(state)
    return end, state, event


def _change_in(motion: Integration, rotor: Rotor, mode: int) -> float:
    """Return when in the last step the contact comes loose, or presses again; or infinity."""
    if rotor.contact_damping == 0.0 or mode == FLIGHT:
        return math.inf
    side = 1.0 if mode == PRESSED else -1.0

    def within(state: Values) -> float:
        return side * hold_of(rotor, state)

    places = np.linspace(motion.low, motion.high, LOOKS + 1).tolist()
    for low, high in pairwise(places):
        if within(motion.at(high)) < 0.0:
            point, reach = low, high - low
            while within(motion.at(point)) <= 0.0 and reach > HIDDEN * high:
                reach *= 0.125
                point = low + reach
            if within(motion.at(point)) > 0.0:
                return motion.root(within, point, high)
            return math.nextafter(low, math.inf)
    return math.inf


def _turn_in(motion: Integration) -> float:
    """Return when in the last step the radius turns; infinity where it does not."""
    if radial_rate_of(motion.before) * radial_rate_of(motion.after) < 0.0:
        return motion.root(radial_rate_of, motion.low, motion.high)
    return math.inf


def _crossing_in(motion: Integration, turn: float, delta0: float, *, in_contact: bool) -> float:
    """Return when in the last step the rotor first leaves its mode; infinity where it does not.

    A mode begins on the ring, to rounding on either side: only a passage out of it counts.
    """
    if delta0 == 0.0:
        return math.inf
    side = 1.0 if in_contact else -1.0

    def within(state: Values) -> float:
        return side * (radius_of(state) - delta0)

    hidden = HIDDEN * delta0  # so little is rounding, as of a rotor that rests on the ring
    looked_at = [motion.low, turn, motion.high] if turn < math.inf else [motion.low, motion.high]
    for low, high in pairwise(looked_at):
        if within(motion.at(high)) < -hidden:
            if within(motion.at(low)) > 0.0:
                return motion.root(within, low, high)
            return math.nextafter(low, math.inf)  # it left as soon as it came
    return math.inf


def _record_step(run: _Run, motion: Integration, turn: float, end: float) -> None:
    """Record the samples of the last step up to its end, and where the radius turns."""
    while len(run.samples) < len(run.sample_times) and run.sample_times[len(run.samples)] <= end:
        run.samples.append(motion.at(run.sample_times[len(run.samples)]))
    if turn <= end:
        kind = 1.0 if radial_rate_of(motion.before) > 0.0 else -1.0
        run.turns.append((turn, kind, motion.at(turn)))


def _record_contact(run: _Run, contact: _Contact, leaving: float, end: Values) -> None:
    """Record a contact; the impulse of a whole one alone is known."""
    peak = contact.state
    moment = float(peak[X] * peak[VY] - peak[Y] * peak[VX])
    depth = max(radius_of(peak) - run.rotor.delta0, 0.0)
    impulse = float(end[IMPULSE]) if math.isfinite(contact.entry + leaving) else math.nan
    lost = float(end[LOST]) if end.size > LOST else 0.0
    run.contacts.append(
        (contact.entry, leaving, contact.time, depth, impulse, moment, lost, contact.force)
    )


def _orbit_of(run: _Run, end: Values, *, began: bool) -> Orbit:
    """Return what was recorded."""
    table = [(time, radius_of(state), kind, *state[:IMPULSE]) for time, kind, state in run.turns]
    extrema = np.array(table).reshape(-1, 7)
    extrema[:, 3:] = rotated(extrema[:, 3:], -run.rotor.omega * extrema[:, 0])
    samples = [state[:IMPULSE] for state in run.samples]
    events = [state[:IMPULSE] for _, _, state in run.events]
    return Orbit(
        rotor=run.rotor,
        options=run.options,
        duration=run.duration,
        times=np.array(run.sample_times),
        states=np.array(samples).reshape(-1, IMPULSE),
        starts_in_contact=began,
        event_times=np.array([time for time, _, _ in run.events]),
        event_kinds=np.array([kind for _, kind, _ in run.events], dtype=np.int8),
        event_states=np.array(events).reshape(-1, IMPULSE),
        contacts=np.array(run.contacts).reshape(-1, CONTACT_COLUMNS),
        end=end[:IMPULSE],
        evaluations=run.evaluations,
        extrema=extrema,
    )
