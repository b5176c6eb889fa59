"""A run-up in pieces is the run-up of the library: motion, folds, order tracks and cascade."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from rotor_ida import Rotor, folds, run_up, simulate, synchronous_response
from rotor_ida.explorer.measured import cascade_rows, order_rows
from rotor_ida.explorer.run_ups import PER_REVOLUTION, RTOL
from rotor_ida.signals.record import record_of
from rotor_ida.signals.spectra import full_spectrum
from tests.explorer.asking import CHATTER, Message, answer_to, question

UP = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}
BOUNCING, BOUNCED = {"omega": 2.4, "zeta": 0.07, "delta0": 2.0}, (2.6, 0.75, 0.66, -1.65)
SHAKEN = (0.3, 0.1, 0.2, 0.1)
LOADED = {"omega": 0.2, "zeta": 0.1, "delta0": 2.5, "shaft_stiffness": 0.3, "load": 0.4}
HANGS = (0.0, -4.0 / 3.0, 0.0, 0.0)
TOP = 4.0


def piece(
    rotor: dict[str, float], start: object, to: float, rate: float, angle: float = 0.0
) -> Message:
    asking = question(
        "run_up", machine=rotor, start=list(start), to=to, rate=rate, angle=angle,
        speeds=[0.05, TOP],
    )  # fmt: skip
    (answer,) = answer_to(asking)
    assert answer.part == "run_up", answer.facts
    return answer


def pieces(
    rotor: dict[str, float], start: object, stops: tuple[float, ...], rate: float
) -> list[Message]:
    """Ask as the page does: each piece begins in the state in which the last one ended."""
    found, angle = [], 0.0
    for here, to in pairwise(stops):
        found.append(piece({**rotor, "omega": here}, start, to, rate, angle))
        start, angle = found[-1].facts["end"], found[-1].facts["angle"]
    return found


def track(rotor: dict[str, float], last: Message) -> Message:
    """Return the track of the run-up that a piece has ended."""
    asking = question(
        "track", machine={**rotor, "omega": last.facts["speed"]}, start=last.facts["end"],
        speeds=[0.05, TOP],
    )  # fmt: skip
    (answer,) = answer_to(asking)
    assert answer.part == "track", answer.facts
    return answer


@pytest.mark.parametrize(
    ("rotor", "start", "stops", "rate"),
    [(BOUNCING, BOUNCED, (2.4, 2.112, 1.9), -0.02),
     (CHATTER, SHAKEN, (1.2, 1.25, 1.4), 0.01),
     (LOADED, HANGS, (0.2, 0.2031, 0.31, 0.45, 0.9), 0.005)],
    ids=["down, a stop in contact", "slipping and rolling", "under a load"],
)  # fmt: skip
def test_pieces_make_one_run_up(
    rotor: dict[str, float],
    start: tuple[float, ...],
    stops: tuple[float, ...],
    rate: float,
) -> None:
    """Each begins where the last one ended, turned to where the unbalance is at its beginning."""
    found = pieces(rotor, start, stops, rate)
    speeds, radii, turns = (
        np.array([each.arrays[name][-1] for each in found]) for name in ("speed", "radius", "angle")
    )
    assert [each.facts["speed"] for each in found] == speeds.tolist()
    duration = (stops[-1] - stops[0]) / rate
    times = [0.0, *((stop - stops[0]) / rate for stop in stops[1:-1]), duration]
    whole = run_up(Rotor(**rotor), start=start, to=stops[-1], rate=rate, samples=times, rtol=1e-10)
    assert whole.sizes["event"] >= 8
    assert speeds == pytest.approx(stops[1:], abs=1e-12)
    assert np.cumsum(turns) == pytest.approx(whole.angle.values[1:], abs=1e-9)
    assert radii == pytest.approx(np.hypot(whole.x, whole.y).values[1:], abs=1e3 * RTOL)
    z = complex(whole.x[-1], whole.y[-1]) * np.exp(-1j * float(whole.angle[-1]))
    v = complex(whole.vx[-1], whole.vy[-1]) * np.exp(-1j * float(whole.angle[-1]))
    end = found[-1].facts["end"]
    assert end == pytest.approx([z.real, z.imag, v.real, v.imag], abs=1e3 * RTOL)


def test_after_a_run_up_the_speed_is_held_under_the_same_load() -> None:
    """From ``held`` a run at that speed goes on as the run-up does, until the unbalance is at 0."""
    last = piece(LOADED, HANGS, 0.25, 0.01)
    left = (math.tau - last.facts["angle"]) / 0.25
    whole = run_up(Rotor(**LOADED), start=HANGS, to=0.25, rate=0.01, duration=5.0 + left,
                   samples=2, rtol=1e-11)  # fmt: skip
    assert whole.angle[-1].item() / math.tau == pytest.approx(
        round(whole.angle[-1].item() / math.tau), abs=1e-9
    )
    end = [whole[name][-1].item() for name in ("x", "y", "vx", "vy")]
    assert last.facts["held"] == pytest.approx(end, abs=1e-7)


def test_the_largest_force_is_that_of_the_contacts_and_of_one_that_has_not_ended() -> None:
    answer = piece(UP, SHAKEN, 1.5, 0.02)
    whole = run_up(Rotor(**UP), start=SHAKEN, to=1.5, rate=0.02, rtol=1e-9)
    assert answer.facts["largest_force"] == pytest.approx(float(whole.peak_force.max()), rel=1e-6)
    held = piece({**UP, "delta0": 0.0}, (1.0, 0.0, 0.0, 1.2), 1.201, 0.02)
    radius = held.arrays["radius"].max()
    assert held.facts["largest_force"] >= radius**1.5 * (1.0 - 1e-12)


@pytest.mark.parametrize("delta0", [0.0, 0.5, 2.0])
def test_a_whirl_ends_at_its_fold_on_the_way_on_which_there_are_fewer_behind_it(
    delta0: float,
) -> None:
    """Speed and radius of each fold are exact; so is, near it, the whirl that is left."""
    found = piece({**UP, "delta0": delta0}, (0, 0, 0, 0), 1.201, 0.02).facts["folds"]
    exact = folds(zeta=0.07, delta0=delta0)
    pairs = {
        (float(omega), float(radius))
        for omega, radius in zip(
            exact.fold_omega.values.ravel(), exact.fold_amplitude.values.ravel(), strict=True
        )
    }
    assert [fold["way"] for fold in found] == [-1.0, 1.0]
    for fold in found:
        assert (fold["omega"], fold["radius"]) in pairs
        behind = fold["omega"] * (1.0 + 1e-6 * fold["way"])
        left = synchronous_response(omega=behind, zeta=0.07, delta0=delta0).amplitude.values
        left = left[np.isfinite(left)]
        assert left.size == 1
        assert left[0] == pytest.approx(fold["other"], rel=2e-3)


def test_without_an_exact_curve_there_are_no_folds() -> None:
    loaded = {**UP, "load": 0.3, "shaft_stiffness": 0.25}
    assert piece(loaded, (0, 0, 0, 0), 1.201, 0.02).facts["folds"] == []


def test_a_piece_is_sampled_often_enough_at_every_speed() -> None:
    for omega in (0.05, 1.0, 3.0):
        answer = piece({**UP, "omega": omega}, (0, 0, 0, 0), omega + 0.1, 0.01)
        turns = max(answer.arrays["angle"][-1], 10.0) / (2.0 * math.pi)
        assert answer.arrays["speed"].size >= 48 * turns


@pytest.mark.parametrize(
    ("rotor", "start", "stops", "rate"),
    [(BOUNCING, BOUNCED, (2.4, 2.4004, 2.51, 2.5222, 3.0), 0.02),
     (LOADED, HANGS, (0.2, 0.2031, 0.31, 0.45, 0.9), 0.005)],
    ids=["up", "under a load"],
)  # fmt: skip
def test_windows_and_spectra_do_not_tell_where_a_piece_ends(
    rotor: dict[str, float], start: tuple[float, ...], stops: tuple[float, ...], rate: float
) -> None:
    """In and out of contact, over stops at any place of a revolution."""
    found = track(rotor, pieces(rotor, start, stops, rate)[-1]).arrays
    step = 2.0 * np.pi / (PER_REVOLUTION * TOP)
    times = step * np.arange(int((stops[-1] - stops[0]) / rate / step) + 1)
    whole = run_up(Rotor(**rotor), start=start, to=stops[-1], rate=rate, samples=times, rtol=1e-10)
    assert whole.sizes["event"] >= 8
    exact = order_rows(whole, record_of(whole)) | cascade_rows(whole, record_of(whole))
    assert exact["order_speed"].size >= 8
    assert exact["cascade_speed"].size >= 2
    assert np.isfinite(exact["order_amplitude"]).any()
    turned = found.pop("order_lag") - exact.pop("order_lag")
    assert np.abs(np.exp(1j * turned) - 1.0).max() < 1e-6
    assert found.keys() == exact.keys()
    for name, values in exact.items():
        np.testing.assert_allclose(found[name], values, rtol=0.0, atol=1e-6, err_msg=name)


def test_a_run_down_begins_another_track_and_the_summary_goes_on() -> None:
    last = pieces(BOUNCING, BOUNCED, (2.4, 2.52), 0.01)[-1]
    back = piece({**BOUNCING, "omega": 2.52}, last.facts["end"], 2.44, -0.01, last.facts["angle"])
    speeds = track(BOUNCING, back).arrays["order_speed"]
    assert speeds.size >= 2
    assert np.all(np.diff(speeds) < 0.0)
    assert speeds.max() < 2.52
    assert back.facts["words"].startswith("From 2.4 to 2.44.")
    unknown = question("track", machine={**BOUNCING, "omega": 2.44}, start=list(BOUNCED))
    (answer,) = answer_to(unknown)
    assert answer.facts["message"] == "a run-up must be given from its beginning"


def test_a_slow_run_up_follows_the_exact_whirl_in_amplitude_and_phase() -> None:
    """The slower it is, the closer: the whirl of a rotor on a shaft, through its resonance."""
    rotor = {"omega": 0.7, "zeta": 0.3, "delta0": 9.0, "shaft_stiffness": 1.0}
    whirl = synchronous_response(**rotor).isel(omega=0, zeta=0, delta0=0, branch=0)
    z = whirl.amplitude.item() * np.exp(-1j * whirl.phase_lag.item())
    start = (z.real, z.imag, (0.7j * z).real, (0.7j * z).imag)
    off = []
    for rate in (0.001, 0.00025):
        found = track(rotor, pieces(rotor, start, (0.7, 0.9, 1.1, 1.3), rate)[-1]).arrays
        speeds = found["order_speed"]
        exact = synchronous_response(**{**rotor, "omega": speeds}).isel(zeta=0, delta0=0, branch=0)
        tracked = found["order_amplitude"] * np.exp(-1j * found["order_lag"])
        off.append(np.abs(tracked - exact.amplitude * np.exp(-1j * exact.phase_lag)).max().item())
    assert off[1] < 0.01
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)


def test_another_state_begins_another_record() -> None:
    first = pieces(BOUNCING, BOUNCED, (2.4, 2.44), 0.01)
    again = pieces({**BOUNCING, "omega": 2.44}, BOUNCED, (2.44, 2.48), 0.01)
    one, other = (track(BOUNCING, each[-1]).arrays["order_speed"] for each in (first, again))
    assert other[0] > 2.44
    assert one.size == other.size == 1


def test_the_lines_of_what_is_settled_on_are_those_of_a_long_run() -> None:
    """A bouncing limit cycle has many, whatever the window shows of them; a whirl has one."""
    answers = answer_to(question("responses", machine=BOUNCING, start=list(BOUNCED)))
    settled = next(each for each in answers if each.part == "settled")
    assert settled.facts["lies_on"] == "cycle"
    rotor, period = Rotor(**BOUNCING), settled.facts["exact_period"]
    run = simulate(rotor, start=settled.facts["end"], duration=200 * period, samples=40_001)
    seen = full_spectrum(run)
    orders_, heights = settled.arrays["exact_order"], settled.arrays["exact_amplitude"]
    large = heights > 1e-3 * heights.max()
    assert large.sum() >= 5
    # the flat-top window shows a line to 0.1 %, and leaks a 30,000th of it into others
    near = seen.whirl_amplitude.sel(frequency=rotor.omega * orders_[large], method="nearest")
    assert near.values == pytest.approx(heights[large], rel=1e-3, abs=3e-5 * heights.max())
    answers = answer_to(question("responses", machine={"omega": 0.8, "zeta": 0.2, "delta0": 0.5}))
    settled = next(each for each in answers if each.part == "settled")
    assert settled.facts["lies_on"] == "whirl"
    assert settled.arrays["exact_order"].tolist() == [1.0]
    exact = synchronous_response(omega=0.8, zeta=0.2, delta0=0.5).amplitude.max().item()
    assert settled.arrays["exact_amplitude"] == pytest.approx([exact], rel=1e-9)
