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
FLOOR = {"adams": 1e3 * RTOL, "bdf": 1e4 * RTOL, "ida": 1e4 * RTOL}


def simulated(case, **settings):
    rotor = Rotor(**{name: case[name] for name in ("omega", "zeta", "delta0")})
    return simulate(
        rotor, start=tuple(case["start"]), duration=case["duration"], samples=2,
        rtol=RTOL, atol=ATOL, **settings,
    )  # fmt: skip


def reference(case):
    kinds = [kind for kind, _, _ in case["events"]]
    times = np.array([float(time) for _, time, _ in case["events"]])
    return kinds, times, np.array([k for _, _, k in case["events"]])


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_exact_flight_and_adams(case):
    """Counts and kinds right, each time within 2e-10 + 1e-10 K; stated errors cover the true."""
    kinds, times, sensitivity = reference(case)
    run = simulated(case)
    assert run.starts_in_contact == case["starts_in_contact"]
    assert run.event_kind.values.tolist() == kinds
    error = np.abs(run.event_time.values - times)
    assert (error <= 2e-10 + 1e-10 * sensitivity).all()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
@pytest.mark.parametrize(
    ("method", "flight"), [("adams", "cvode"), ("bdf", "exact"), ("bdf", "cvode"), ("ida", "exact")]
)
def test_the_other_ways(case, method, flight):
    """Counts and kinds right down to the floor, each time within 100 max(t, 10) max(K, 1) rtol."""
    if flight == "cvode" and (case.get("shallowest") or np.inf) < FLOOR[method]:
        pytest.skip("below the stated floor of integrated flight")
    kinds, times, sensitivity = reference(case)
    run = simulated(case, method=method, flight=flight)
    assert run.event_kind.values.tolist() == kinds
    error = np.abs(run.event_time.values - times)
    assert (error <= 100 * np.maximum(times, 10.0) * np.maximum(sensitivity, 1.0) * RTOL).all()


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
