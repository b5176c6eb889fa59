"""Events of every kind of run against times made in extended precision, without the simulator."""

import json
from pathlib import Path

import numpy as np
import pytest

from rotor_ida import Rotor, simulate

CASES = json.loads((Path(__file__).parent / "data" / "contact_events.json").read_text("utf-8"))[
    "cases"
]
RTOL, ATOL = 1e-12, 1e-14
# Grazes shallower than this are below what an integrated flight can tell (see docs/events.md).
FLOOR = {"adams": 1e3 * RTOL, "bdf": 1e4 * RTOL, "ida": 1e4 * RTOL, "taylor": 0.0}
# Bounds on the error of an event at time t with sensitivity K: as a part of t + K, and in all
# where K comes to 1.4e7. Both are three times what was measured, so that the loss of one digit
# fails; the errors are the solver's, and the two backends, which round differently, agree on them.
BOUNDS = {
    ("adams", "exact"): (1.6e-11, 5e-6),
    ("adams", "cvode"): (1.6e-11, 1.2e-4),
    ("bdf", "exact"): (1.6e-10, 3.5e-5),
    ("bdf", "cvode"): (1.6e-10, 7e-5),
    ("taylor", "exact"): (8e-14, 1e-7),
}


def simulated(case, rtol=RTOL, atol=ATOL, **settings):
    rotor = Rotor(**{name: case[name] for name in ("omega", "zeta", "delta0")})
    return simulate(
        rotor, start=tuple(case["start"]), duration=case["duration"], samples=2,
        rtol=rtol, atol=atol, **settings,
    )  # fmt: skip


def reference(case):
    kinds = [kind for kind, _, _ in case["events"]]
    times = np.array([float(time) for _, time, _ in case["events"]])
    return kinds, times, np.array([k for _, _, k in case["events"]])


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
@pytest.mark.parametrize(("method", "flight"), BOUNDS)
def test_events_are_those_of_the_reference(case, method, flight):
    """Counts and kinds right down to the floor, and each time within the bounds."""
    if flight == "cvode" and (case.get("shallowest") or np.inf) < FLOOR[method]:
        pytest.skip("below the stated floor of integrated flight")
    kinds, times, sensitivity = reference(case)
    run = simulated(case, method=method, flight=flight)
    assert run.starts_in_contact == case["starts_in_contact"]
    assert run.event_kind.values.tolist() == kinds
    error = np.abs(run.event_time.values - times)
    relative, hardest = BOUNDS[method, flight]
    assert (error <= relative * (times + sensitivity)).all()
    if case["name"] == "hard_case":
        assert error.max() <= hardest


@pytest.mark.parametrize("rtol", [10.0**-power for power in range(6, 16)])
def test_at_every_tolerance_the_stated_errors_of_taylor_series_cover_the_true_ones(rtol):
    """Where a case is still decided: loose tolerances may miss the shallowest departures."""
    for case in CASES:
        kinds, times, _ = reference(case)
        run = simulated(case, method="taylor", rtol=rtol, atol=1e-2 * rtol)
        if (case.get("shallowest") or np.inf) > 1e3 * rtol:
            assert run.event_kind.values.tolist() == kinds, case["name"]
            error = np.abs(run.event_time.values - times)
            assert (error <= run.event_time_error.values).all(), case["name"]


def test_stated_errors_cover_the_true_ones():
    """At least 95 % of all events covered, and less than a hundredfold in the median."""
    covered, ratios = [], []
    for case in CASES:
        run, (_, times, _) = simulated(case), reference(case)
        error = np.abs(run.event_time.values - times)
        covered += (error <= run.event_time_error.values).tolist()
        usual = np.isfinite(run.event_time_error.values) & (error > 0.0)
        ratios += (run.event_time_error.values[usual] / error[usual]).tolist()
    assert np.mean(covered) >= 0.95
    assert np.median(ratios) < 100.0
