"""A run-up in a browser: it goes on by itself, stops, turns back, and says what has come of it."""

from __future__ import annotations

import numpy as np
import pytest
from selenium.webdriver import Keys

from rotor_ida import Rotor, folds, run_up, synchronous_response
from tests.explorer.browser import WINDOW, hovered, needs_browser, opened

# On a machine that does other things as well.
pytestmark = [needs_browser, pytest.mark.timeout(1500)]

# A whirl on the ring at a speed where there are two, and the rate at which the speed changes.
RUBBING = {"zeta": 0.07, "delta0": 0.5}
BEGUN, RAMP = 1.8, 0.002
RESTS = "!rotorIda.passage.running && !rotorIda.passage.waiting.size && !rotorIda.passage.timer"


def on_the_ring(omega):
    """Return a state on the whirl with the largest radius, as an address has it."""
    whirls = synchronous_response(omega=omega, **RUBBING)
    radius, lag = (float(whirls[name].values.ravel()[-1]) for name in ("amplitude", "phase_lag"))
    z = radius * np.exp(-1j * lag)
    v = 1j * omega * z
    return dict(zip(("x", "y", "vx", "vy"), (z.real, z.imag, v.real, v.imag), strict=True))


def running_up(page, address, **more):
    given = {"omega": BEGUN, **RUBBING, **on_the_ring(BEGUN), "revolutions": 5}
    page = opened(page.driver, address, **given, **more)
    page.settle()
    return page


def at_rest(page):
    page.until(RESTS)
    page.settle()


def test_a_run_up_falls_off_the_ring_where_the_library_s_does(page, address):
    """Half way, in the mean over a revolution, from the fold to the whirl that is left there."""
    page = running_up(page, address)
    begun = page.facts("motion")["end"]
    page.find("#run-up").send_keys(Keys.SPACE)
    page.until("rotorIda.passage.tracks[0].jumps.length")
    assert page.find("#run-up").get_attribute("aria-pressed") == "true"
    page.find("#run-up").send_keys(Keys.SPACE)
    at_rest(page)
    assert page.find("#run-up").get_attribute("aria-pressed") == "false"
    (jump,) = page.run("return rotorIda.passage.tracks[0].jumps")
    exact = folds(**RUBBING)
    assert jump["fold"]["omega"] == exact.fold_omega.values.max()
    last = page.run("return rotorIda.passage.speed")
    duration = (last - BEGUN) / RAMP
    whole = run_up(
        Rotor(omega=BEGUN, **RUBBING), start=begun, to=last, rate=RAMP,
        samples=round(16 * duration), rtol=1e-8,
    )  # fmt: skip
    angle, speed, radius = (whole.angle.values, whole.speed.values, np.hypot(whole.x, whole.y))
    since = np.searchsorted(angle, angle - 2 * np.pi)
    sums = np.concatenate([[0.0], np.cumsum(radius)])
    place = np.arange(angle.size)
    means = (sums[place + 1] - sums[since]) / (place + 1 - since)
    here = speed[(place + since) // 2]
    left, right = exact.fold_amplitude.values[0, 0, -1], jump["fold"]["other"]
    beyond = (here > jump["fold"]["omega"]) & (means < 0.5 * (left + right))
    # as near as some samples of either lie together
    assert jump["omega"] == pytest.approx(here[beyond][0], abs=6e-4)
    assert jump["falls"] is True
    late = here[beyond][0] - jump["fold"]["omega"]
    assert 0.05 < late < 0.15
    assert f"{late:.3g}"[:4] in page.find("#passed").text
    # it rests in the state in which the library's run-up is there, and goes on from it
    assert page.state()["omega"] == last
    z = complex(whole.x[-1], whole.y[-1]) * np.exp(-1j * angle[-1])
    assert page.facts("motion")["start"][:2] == pytest.approx([z.real, z.imag], abs=1e-3)
    key = page.find("#response-key").text
    assert "while the speed changes" in key
    assert "half way of a jump" in key
    assert hovered(page, '[data-panel="response"]', [jump["omega"], jump["radius"]]).startswith(
        "half way of a jump"
    )


def test_a_passage_stops_goes_on_and_turns_back(page, address):
    page = running_up(page, address, ramp=0.02)
    trace = "rotorIda.passage.tracks[0]"
    page.find("#run-up").click()
    page.until("rotorIda.passage.number >= 3")
    assert page.run("return document.querySelectorAll('#words.stale').length") == 1
    page.find("#run-up").click()
    at_rest(page)
    assert page.run("return document.querySelectorAll('.stale').length") == 0
    first, start = page.run("return rotorIda.passage.speed"), page.facts("motion")["start"]
    assert start == page.run(f"return {trace}.held")
    page.find("#run-up").click()
    page.until("rotorIda.passage.speed > arguments[0]", first)
    page.find("#run-down").click()  # from running up to running down, without a rest
    page.until("rotorIda.passage.last === -1 && rotorIda.passage.way === -1")
    page.until(f"{trace}.omega.at(-1) < {trace}.omega.at(-2)")
    page.find("#run-down").click()
    at_rest(page)
    speeds = page.run(f"return {trace}.omega.map((each) => Number.isNaN(each) ? null : each)")
    turned = speeds.index(None)
    assert speeds.count(None) == 1
    assert speeds[0] == BEGUN
    assert np.all(np.diff(speeds[:turned]) > 0.0)
    assert np.all(np.diff(speeds[turned + 1 :]) < 0.0)
    page.find("#slider-zeta").send_keys(Keys.ARROW_RIGHT)
    page.settle()
    assert page.run("return rotorIda.passage.begun") is False
    assert page.find("#passed").text == ""
    assert "while the speed changes" not in page.find("#response-key").text


def test_a_passage_ends_where_the_picture_ends(page, address):
    page = opened(page.driver, address, omega=3.9, zeta=0.07, delta0=2, revolutions=1, ramp=0.05)
    page.settle()
    page.find("#run-up").click()
    page.until("rotorIda.passage.begun")
    at_rest(page)
    assert page.state()["omega"] == 4.0
    assert page.find("#passed").text.startswith("From 3.9 to 4. ")


def test_the_rate_of_a_machine_is_in_turns_a_minute_and_second(page):
    page.find('[name="units"][value="si"]').click()
    page.type("#speed-unit", "rpm")
    page.settle()
    rate = page.facts("motion")["scales"]["rate"]
    assert page.find("#ramp-name").text == "rpm/s"
    shown = float(page.find("#ramp").get_attribute("value"))
    assert shown == pytest.approx(0.002 * rate**2 * 30 / np.pi, rel=5e-4)
    page.type("#ramp", 60_000)
    page.find("#run-up").click()
    page.until("rotorIda.passage.number >= 2")
    page.find("#run-up").click()
    at_rest(page)
    assert page.run("return rotorIda.passage.rate") == pytest.approx(2000 * np.pi / rate**2)
    omega = page.run("return rotorIda.passage.speed")
    assert page.state()["speed"] == pytest.approx(omega * rate, rel=1e-11)
    assert page.facts("motion")["rotor"]["omega"] == pytest.approx(omega, rel=1e-11)
    assert " rpm" in page.find("#passed").text


def test_a_passage_that_cannot_be_followed_says_why_and_rests(page):
    page.type("#ramp", 1e-18)
    page.find("#run-up").click()
    page.until("document.getElementById('passed').textContent.includes('could not be followed')")
    assert "a piece of a run-up must have at most 2000 revolutions" in page.find("#passed").text
    at_rest(page)
    assert page.state()["omega"] == 2.0
    assert page.find("#run-up").get_attribute("aria-pressed") == "false"
    page.type("#ramp", 0.05)
    page.find("#run-up").click()
    page.until("rotorIda.passage.speed > 2.0")
    page.find("#run-up").click()
    at_rest(page)
    assert page.state()["omega"] > 2.0


# Where a button lies at each frame, and what the verdict says, until a run-up has ended.
WATCH = """
window.seen = { places: [], verdicts: [] };
const look = () => {
  seen.places.push(document.getElementById("run-up").getBoundingClientRect().y);
  seen.verdicts.push(document.getElementById("verdict").textContent);
  if (!seen.ended) requestAnimationFrame(look);
};
look();"""


def test_the_page_does_not_move_while_a_rotor_runs_up(page):
    """The verdict changes its length at each piece, here between one line and two."""
    page.driver.set_window_size(1280, 720)
    try:
        page.settle("settled")
        page.type("#ramp", 0.01)
        page.run(WATCH)
        page.find("#run-up").click()
        page.until("rotorIda.passage.speed > 2.5")
        page.find("#run-up").click()
        at_rest(page)
        page.settle("settled")
        page.until("seen.verdicts.at(-1).includes('Held at this speed')")
        seen = page.run("seen.ended = true; return seen")
    finally:
        page.driver.set_window_size(*WINDOW)
    running = [each for each in seen["verdicts"] if each.startswith("From")]
    assert len(set(map(len, running))) > 3
    assert np.ptp(seen["places"]) < 0.5
    held = {each.partition("Held at this speed: ")[2] for each in running} - {""}
    told = page.facts("settled")["verdict"].removeprefix("Rub: ")
    assert held == {told[0].lower() + told[1:]}  # never the one before the run-up


def test_two_rotors_pass_side_by_side(page):
    page.find("#beside").click()
    page.settle()
    page.settle(side=1)
    page.type("#ramp", 0.05)
    page.find("#run-down").click()
    page.until("rotorIda.passage.number >= 3")
    page.find("#run-down").click()
    at_rest(page)
    page.settle(side=1)
    ends = page.run("return rotorIda.passage.tracks.map(({ start }) => start)")
    assert len(ends) == 2
    for side, end in enumerate(ends):
        # there and back in units of a machine
        assert page.facts("motion", side)["start"] == pytest.approx(end, rel=1e-12)
    assert page.find("#passed").text.count("rotor: From 2 to") == 2
