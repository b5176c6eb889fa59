"""Ways to simulate one run: this program's methods and backends, and other programs beside them.

Each way is made for a case and a tolerance, and is then a function without arguments that
returns the states at the sample times and the event times. What it takes to make one (to compile
a right-hand side, say) is not part of what it takes to run.
"""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from event_table import by_dop853, in_heyoka, to_next_crossing

from rotor_ida import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

# Absolute tolerance in parts of the relative one, for every way.
ATOL = 1e-2
# By Taylor series, and no way's own error: `taylor.py witness` holds it against others.
REFERENCE = 1e-15


@dataclass(frozen=True)
class Case:
    """A rotor, a start, and how long and how often it is looked at."""

    name: str
    omega: float
    zeta: float
    delta0: float
    start: tuple = (0.0, 0.0, 0.0, 0.0)
    revolutions: float = 100.0
    samples: int = 2001

    def __getitem__(self, name):
        """Return a parameter by its name."""
        return getattr(self, name)

    @property
    def rotor(self):
        """The rotor."""
        return Rotor(omega=self.omega, zeta=self.zeta, delta0=self.delta0)

    @property
    def duration(self):
        """Time to simulate."""
        return self.revolutions * 2.0 * math.pi / self.omega

    @property
    def times(self):
        """Times to report."""
        return np.linspace(0.0, self.duration, self.samples)


FULL_CONTACT = Case("full contact", 1.2, 0.07, 0.5)
BOUNCING = Case("bouncing", 2.0, 0.07, 2.0)


def in_contact_from_start():
    """Return the first case without its only entry: from where it is after one revolution."""
    whole = reference(FULL_CONTACT)
    start = tuple(whole.states[FULL_CONTACT.samples // 100].tolist())
    return replace(
        FULL_CONTACT, name="in contact throughout", start=start, revolutions=99.0, samples=1981
    )


def ours(case, rtol, backend="auto", method="adams"):
    """Return this program's bare run, before it is labelled."""
    options = Options(rtol=rtol, atol=ATOL * rtol, backend=backend, method=method)
    rotor, duration, times = case.rotor, case.duration, case.times

    def way():
        orbit = run(rotor, case.start, duration, times, options)
        return orbit.states, orbit.event_times

    return way


def compiled(case, rtol):
    """CVODE, called by the core."""
    return ours(case, rtol, "compiled")


def taylor(case, rtol):
    """Taylor series, in the core."""
    return ours(case, rtol, method="taylor")


def python(case, rtol):
    """CVODE from Python, through scikit-sundae's public interface."""
    return ours(case, rtol, "python")


def dop853(case, rtol):
    """SciPy's DOP853 with an event function, straight through."""

    def way():
        found = by_dop853(case, rtol, ATOL * rtol, case.times)
        return found.y.T, found.t_events[0]

    return way


def sundae(case, rtol):
    """scikit-sundae used plainly: stopped by its own root finding, and started again."""
    delta0, times = case.delta0, case.times

    def way():
        time, state, inside = 0.0, np.array(case.start), math.hypot(*case.start[:2]) <= delta0
        states, events = [state[None]], []
        while time < times[-1]:
            wanted = np.concatenate(([time], times[times > time]))
            found = to_next_crossing(case, wanted, state, inside, rtol, ATOL * rtol)
            if not found.success:
                break
            ended = found.t_events is not None
            before = found.t < found.t_events[-1] if ended else np.full(found.t.size, True)
            before[0] = False
            states.append(found.y[before])
            if not ended:
                break
            time, state, inside = float(found.t_events[-1]), found.y_events[-1], not inside
            events.append(time)
        return np.concatenate(states), np.array(events)

    return way


def heyoka(case, rtol, *, events=False):
    """Heyoka's Taylor integrator, optionally with events."""
    seen, times = [], case.times
    note = (lambda _integrator, time, _sign: seen.append(time)) if events else None
    integrator = in_heyoka(case, rtol, note)

    def way():
        seen.clear()
        integrator.time = 0.0
        integrator.state[:] = case.start
        states = integrator.propagate_grid(times, max_steps=200_000)[-1]
        return states, np.array(seen)

    return way


@cache
def reference(case):
    """Return the orbit of this program at the tightest tolerance."""
    options = Options(rtol=REFERENCE, atol=ATOL * REFERENCE, method="taylor")
    return run(case.rotor, case.start, case.duration, case.times, options)


def errors(case, found):
    """Return the worst error of a state and of an event time; NaN where it has none to compare."""
    states, events = found
    right = reference(case)
    if states.shape != right.states.shape or not np.isfinite(states).all():
        return math.nan, math.nan
    of_state = float(np.abs(states - right.states).max())
    if events.size != right.event_times.size:
        return of_state, math.nan
    return of_state, float(np.abs(events - right.event_times).max(initial=0.0))


def at_equal_error(make, case, wanted, tolerances):
    """Return the loosest tolerance at which a way's state error is no more than `wanted`.

    Where none is, return the one of the smallest error.
    """
    best = (math.inf, tolerances[0])
    for rtol in tolerances:
        error, _ = errors(case, make(case, rtol)())
        if error <= wanted:
            return rtol
        best = min(best, (error if math.isfinite(error) else math.inf, rtol))
    return best[1]
