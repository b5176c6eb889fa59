"""Events found and worst time error: this program beside other ways to look for contacts.

Every case of ``tests/data`` is integrated with the same tolerances, 1e-12 and 1e-14:

- this program: exact flight; in contact CVODE-Adams, or Taylor series;
- scikit-sundae used plainly: CVODE-Adams in x, y, vx, vy, its own root finding of
  |z| = delta0, stopped and started again at each event;
- SciPy: ``solve_ivp`` with DOP853 and an event function, straight through;
- heyoka: its Taylor integrator with event detection, straight through, the force switched by
  ``select`` (needs the extra ``bench``).

    pip install -e '.[bench]' && python benchmarks/event_table.py
"""

import json
import math
from functools import partial
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE

from rotor_ida import Rotor, simulate

RTOL, ATOL = 1e-12, 1e-14
DATA = Path(__file__).resolve().parent.parent / "tests" / "data"


def simulated(case, method, rtol):
    """Return the run of a case by this program."""
    rotor = Rotor(**{name: case[name] for name in ("omega", "zeta", "delta0")})
    return simulate(
        rotor,
        start=tuple(case["start"]),
        duration=case["duration"],
        samples=2,
        rtol=rtol,
        atol=rtol / 100.0,
        method=method,
    )


def ours(case, method):
    """Return event times and kinds found by this program."""
    run = simulated(case, method, RTOL)
    return run.event_time.values, run.event_kind.values


def right_hand_side(case):
    """Return the equation of motion as scikit-sundae and SciPy want it."""
    omega, zeta, delta0 = case["omega"], case["zeta"], case["delta0"]

    def rhs(time, state, rate):
        x, y, vx, vy = state
        radius = math.hypot(x, y)
        restoring = max(radius - delta0, 0.0) ** 1.5 / radius if radius > 0.0 else 0.0
        rate[0], rate[1] = vx, vy
        rate[2] = omega**2 * math.cos(omega * time) - 2 * zeta * vx - restoring * x
        rate[3] = omega**2 * math.sin(omega * time) - 2 * zeta * vy - restoring * y

    return rhs


def to_next_crossing(case, times, state, inside, rtol, atol):
    """Return CVODE's solution over times, up to the crossing that its root finding sees."""

    def gap(_time, values, events):
        events[0] = math.hypot(values[0], values[1]) - case["delta0"]

    gap.terminal, gap.direction = [True], [1 if inside else -1]
    solver = CVODE(right_hand_side(case), method="Adams", rtol=rtol, atol=atol, eventsfn=gap,
                   num_events=1, max_num_steps=1_000_000)  # fmt: skip
    return solver.solve(times, state)


def plain_sundae(case):
    """Return what CVODE's own root finding sees, started again at each event."""
    time, state = 0.0, np.array(case["start"], dtype=float)
    inside = not case["starts_in_contact"]
    times, kinds = [], []
    while time < case["duration"]:
        found = to_next_crossing(case, [time, case["duration"]], state, inside, RTOL, ATOL)
        if not found.success or found.t_events is None:
            break
        time, state = float(found.t_events[-1]), found.y_events[-1]
        times.append(time)
        kinds.append(1 if inside else -1)
        inside = not inside
    return np.array(times), np.array(kinds)


def by_dop853(case, rtol, atol, times=None):
    """Return SciPy's solution, straight through, with an event function."""
    rhs, delta0 = right_hand_side(case), case["delta0"]

    def fun(time, state):
        rate = np.empty(4)
        rhs(time, state, rate)
        return rate

    def gap(_time, state):
        return math.hypot(state[0], state[1]) - delta0

    return solve_ivp(fun, (0.0, case["duration"]), case["start"], method="DOP853", t_eval=times,
                     rtol=rtol, atol=atol, events=gap)  # fmt: skip


def scipy_dop853(case):
    """Return what SciPy's event function sees on the way."""
    found = by_dop853(case, RTOL, ATOL)
    states = found.y_events[0]
    kinds = [1 if x * vx + y * vy > 0 else -1 for x, y, vx, vy in states]
    return found.t_events[0], np.array(kinds)


def in_heyoka(case, tol, seen=None):
    """Return heyoka's Taylor integrator, the force switched by ``select``, and events if asked."""
    import heyoka as hy  # noqa: PLC0415 - an optional extra

    x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
    omega, zeta, delta0 = case["omega"], case["zeta"], case["delta0"]
    square = x**2 + y**2
    gap = square - delta0**2
    radius = hy.sqrt(square)
    # The branch that is not taken must stay a number too.
    depth = hy.select(hy.gt(gap, 0.0), radius - delta0, 0.0)
    restoring = hy.select(hy.gt(gap, 0.0), depth * hy.sqrt(depth) / radius, 0.0)
    equations = [
        (x, vx),
        (y, vy),
        (vx, omega**2 * hy.cos(omega * hy.time) - 2 * zeta * vx - restoring * x),
        (vy, omega**2 * hy.sin(omega * hy.time) - 2 * zeta * vy - restoring * y),
    ]
    events = [] if seen is None else [hy.nt_event(gap, seen)]
    return hy.taylor_adaptive(equations, list(map(float, case["start"])), tol=tol, nt_events=events)


def heyoka_taylor(case):
    """Return what heyoka's event detection sees on the way."""
    rows = []
    integrator = in_heyoka(case, RTOL, lambda _integrator, time, sign: rows.append((time, sign)))
    integrator.propagate_until(case["duration"], max_steps=200_000)
    times, kinds = np.array(rows).reshape(-1, 2).T
    return times, kinds


WAYS = {
    "rotor_ida, CVODE": partial(ours, method="adams"),
    "rotor_ida, Taylor": partial(ours, method="taylor"),
    "scikit-sundae, plainly": plain_sundae,
    "SciPy DOP853": scipy_dop853,
    "heyoka": heyoka_taylor,
}


def judged(way, case):
    """Return the number of events found and the worst time error, or None where they differ."""
    try:
        times, kinds = way(case)
    except Exception as error:
        return type(error).__name__, None
    wanted = np.array([float(time) for _, time, _ in case["events"]])
    right = [kind for kind, _, _ in case["events"]]
    if times.size != wanted.size or list(kinds) != right:
        return times.size, None
    return times.size, float(np.abs(times - wanted).max(initial=0.0))


def main():
    """Print the table, a line for each case, as Markdown."""
    cases = [case for path in sorted(DATA.glob("contact_events.json")) for case in load(path)]
    print("| case | events | " + " | ".join(WAYS) + " |")
    print("|---|---|" + "---|" * len(WAYS))
    right = dict.fromkeys(WAYS, 0)
    for case in cases:
        cells = []
        for name, way in WAYS.items():
            found, error = judged(way, case)
            right[name] += error is not None
            cells.append(f"{found}, wrong" if error is None else f"{error:.0e}")
        print(f"| {case['name']} | {len(case['events'])} | " + " | ".join(cells) + " |", flush=True)
    print(f"| right | {len(cases)} | " + " | ".join(str(n) for n in right.values()) + " |")


def load(path):
    """Return the cases of one file of reference tables."""
    return json.loads(path.read_text(encoding="utf-8"))["cases"]


if __name__ == "__main__":
    main()
