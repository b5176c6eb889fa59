"""The tables of reference events in tests/data: well-formed, and right where a formula exists."""

import json
from decimal import Decimal
from itertools import pairwise
from pathlib import Path

import pytest
from mpmath import beta, mp, mpf

from rotor_ida import Rotor
from tests.witness import flown

TABLE = json.loads(
    (Path(__file__).parent / "data" / "contact_events.json").read_text(encoding="utf-8")
)
CASES = {case["name"]: case for case in TABLE["cases"]}
WITH_EVENTS = [case for case in CASES.values() if case["events"]]


# Starts on the ring, and touches or flights inside a single step of the witness.
UNSEEN = ("ring_", "graze_", "tiny_clearance", "departure_1e-6")
SEEN = [case for case in WITH_EVENTS if not case["name"].startswith(UNSEEN)]


def named(case):
    return case["name"]


@pytest.mark.parametrize("case", SEEN, ids=named)
def test_another_integrator_has_the_same_events(case):
    """By other equations: SciPy's DOP853 on fixed axes."""
    rotor = Rotor(**{name: case[name] for name in ("omega", "zeta", "delta0")})
    found = flown(rotor, case["start"], case["duration"]).events
    assert [kind for _, kind, _ in found] == [kind for kind, _, _ in case["events"]]
    for (time, _, _), (_, known, K) in zip(found, case["events"], strict=True):
        assert abs(time - float(known)) < 2e-11 * max(K, 1.0)


@pytest.mark.parametrize("case", WITH_EVENTS, ids=named)
def test_events_take_turns_within_the_run_and_are_known_to_twenty_digits(case):
    """Two orders agree so far; a double can follow, as K eps is the least error of a time."""
    kinds, texts, sensitivities = zip(*case["events"], strict=True)
    assert case["digits"] >= 20
    assert all(len(each.replace(".", "").lstrip("0")) >= 24 for each in texts)  # or a last 0
    first = -1 if case["starts_in_contact"] else 1
    assert [*kinds] == [first * (-1) ** number for number in range(len(kinds))]
    times = [Decimal(0), *map(Decimal, texts)]
    assert all(a < b for a, b in pairwise(times))
    # No event is so near the end that rounding decides whether it belongs to the run.
    left = Decimal(case["duration"]) - times[-1]
    assert left > Decimal(1e-9 * max(1.0, sensitivities[-1]))
    assert all(0.0 < K < 1e8 for K in sensitivities)


def test_free_planar_vibration_is_the_closed_form():
    """To the ring in B(2/5, 1/2)/sqrt(5) (A-delta0)^-1/4, across at sqrt(4/5) (A-delta0)^5/4."""
    case = CASES["free_planar"]
    with mp.workdps(40):
        reach = mpf(case["start"][0]) - mpf(case["delta0"])
        leaving = beta(mpf(2) / 5, mpf(1) / 2) / mp.sqrt(5) * reach ** (-mpf(1) / 4)
        crossing = 2 * mpf(case["delta0"]) / (mp.sqrt(mpf(4) / 5) * reach ** (mpf(5) / 4))
        for number, (_, time, _) in enumerate(case["events"]):
            flights = (number + 1) // 2
            exact = (2 * (number // 2) + 1) * leaving + flights * crossing
            assert abs(mpf(time) / exact - 1) < mpf(10) ** -20


@pytest.mark.parametrize("depth", ["1e-3", "1e-5", "1e-7", "1e-9", "1e-11"])
def test_a_graze_is_a_pair_of_events_that_the_miss_lacks(depth):
    """A touch of depth e lasts about sqrt(8 e/|r''|)."""
    graze, miss = CASES[f"graze_{depth}"]["events"], CASES[f"miss_{depth}"]["events"]
    assert len(graze) == len(miss) + 2
    lasts = Decimal(graze[1][1]) - Decimal(graze[0][1])
    assert Decimal(miss[0][1]) > Decimal(graze[1][1])
    assert 1.0 < float(lasts) / float(depth) ** 0.5 < 10.0
