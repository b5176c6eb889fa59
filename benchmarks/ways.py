"""Ways to simulate one run: this program's methods and backends, and other programs beside them.

Each way is made for a case and a tolerance, and is then a function without arguments that
returns the states at the sample times and the event times. What it takes to make one (to compile
a right-hand side, say) is not part of what it takes to run.
"""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from event_table import right_hand_side
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE

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
    rhs, delta0, times = right_hand_side(case), case.delta0, case.times

    def fun(time, state):
        rate = np.empty(4)
        rhs(time, state, rate)
        return rate

    def gap(_time, state):
        return math.hypot(state[0], state[1]) - delta0

    def way():
        found = solve_ivp(
            fun,
            (0.0, times[-1]),
            case.start,
            method="DOP853",
            t_eval=times,
            rtol=rtol,
            atol=ATOL * rtol,
            events=gap,
        )
        return found.y.T, found.t_events[0]

    return way


def sundae(case, rtol):
    """scikit-sundae used plainly: stopped by its own root finding, and started again."""
    rhs, delta0, times = right_hand_side(case), case.delta0, case.times

    def segment(time, state, inside):
        def gap(_time, values, events):
            events[0] = math.hypot(values[0], values[1]) - delta0

        gap.terminal, gap.direction = [True], [1 if inside else -1]
        solver = CVODE(
            rhs,
            method="Adams",
            rtol=rtol,
            atol=ATOL * rtol,
            eventsfn=gap,
            num_events=1,
            max_num_steps=1_000_000,
        )
        wanted = np.concatenate(([time], times[times > time]))
        return solver.solve(wanted, state)

    def way():
        time, state, inside = 0.0, np.array(case.start), math.hypot(*case.start[:2]) <= delta0
        states, events = [state[None]], []
        while time < times[-1]:
            found = segment(time, state, inside)
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
    """Heyoka's Taylor integrator, the force switched by ``select``; optionally with events."""
    import heyoka as hy  # noqa: PLC0415 - an optional extra

    x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
    omega, zeta, delta0, times = case.omega, case.zeta, case.delta0, case.times
    square = x**2 + y**2
    gap = square - delta0**2
    radius = hy.sqrt(square)
    # The branch that is not taken must stay a number too.
    depth = hy.select(hy.gt(gap, 0.0), radius - delta0, 0.0)
    restoring = hy.select(hy.gt(gap, 0.0), depth * hy.sqrt(depth) / radius, 0.0)
    seen = []
    integrator = hy.taylor_adaptive(
        [
            (x, vx),
            (y, vy),
            (vx, omega**2 * hy.cos(omega * hy.time) - 2 * zeta * vx - restoring * x),
            (vy, omega**2 * hy.sin(omega * hy.time) - 2 * zeta * vy - restoring * y),
        ],
        list(case.start),
        tol=rtol,
        nt_events=[hy.nt_event(gap, lambda _i, time, _s: seen.append(time))] if events else [],
    )

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
