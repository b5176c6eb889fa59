"""The page in a browser: every control moves it, and what it shows is what the library computes."""

from __future__ import annotations

import csv
import time

import numpy as np
import pytest
from selenium.webdriver import ActionChains, Keys

import rotor_ida
from rotor_ida import DimensionalRotor, Rotor
from rotor_ida.cli import main
from rotor_ida.model.disc_starts import hanging
from tests.explorer.asking import BEYOND as WHOLE
from tests.explorer.asking import CHATTER, RUB, WHIP, answer_to, question
from tests.explorer.browser import (
    COLOURED,
    FITS,
    Page,
    copied,
    downloaded,
    errors_of,
    hovered,
    needs_browser,
    number_after,
    opened,
    sized,
    with_machine,
)
from tests.explorer.conftest import RUNNING

# On a machine that does other things as well.
pytestmark = [needs_browser, pytest.mark.timeout(1500)]
FIRST = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
SPEEDS = (0.05, 4.0)
PLOTS = 8
EVENTS = ("entry", "exit")
CHATTERING = CHATTER | {"x": 0.3, "y": 0.1, "vx": 0.2, "vy": 0.1}


def test_the_page_has_what_was_sent_number_by_number(chromium, address):
    """That this is what the library computes is tested where it is answered."""
    # no other test meets the branch of this rotor, at another speed, where it begins
    rotor = {"omega": 2, "zeta": 0.071, "delta0": 2}
    page = opened(chromium, address, basin=True, **rotor)
    page.settle("settled", "section", "branch")
    page.until("rotorIda.shown[0].basin?.facts.finest")
    given = {"machine": rotor, "speeds": SPEEDS, "reach": page.facts("basin")["reach"]}
    for about in ("motion", "responses", "starts"):
        sent = {each.part: each for each in answer_to(question(about, **given))}
        for part, message in sent.items():
            for name, values in message.arrays.items():
                np.testing.assert_array_equal(page.array(part, name), values, err_msg=name)
            for sentence in message.facts.get("words", ()):
                assert sentence in page.words()
            for each in message.facts.get("sheets", ()):
                for cells in each["rows"]:
                    assert " ".join(filter(None, cells)) in page.words()
    assert page.facts("basin")["attractors"] == sent["basin"].facts["attractors"]
    omega, radius = (page.array("curve", f"fold_{name}")[0] for name in ("omega", "amplitude"))
    text = hovered(page, '[data-panel="response"]', [omega, radius])
    assert text.startswith("fold: ")
    assert number_after("speed ω", text) == pytest.approx(omega, rel=1e-5)
    assert number_after("radius", text) == pytest.approx(radius, rel=1e-5)
    assert page.find('[data-panel="response"] .found').is_displayed()
    assert errors_of(chromium) == []


def test_every_panel_is_drawn_and_follows_the_speed(whole):
    whole.settle("settled", "section", "lines")
    whole.until("rotorIda.shown[0].basin?.facts.finest")
    before = whole.pictures()
    assert len(before) == PLOTS
    assert all(before)
    whole.type("#field-omega", 1.2)
    whole.settle("settled", "section", "lines")
    whole.until("rotorIda.shown[0].basin?.facts.finest")
    time.sleep(0.3)
    assert all(one != other for one, other in zip(before, whole.pictures(), strict=True))


SLIDERS = ("omega", "contact_damping", "load", "disc_radius")


def test_a_slider_moves_by_key_and_is_kept_in_the_address(page):
    assert not page.find("#slider-load").is_displayed()
    page.find("#machine summary").send_keys(Keys.ENTER)
    for name in SLIDERS:
        slider, before = page.find(f"#slider-{name}"), page.state()[name]
        slider.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
        page.settle()
        after = page.state()[name]
        assert after > before
        assert float(page.find(f"#field-{name}").get_attribute("value")) == pytest.approx(after)
        rotor = Rotor(**page.facts("motion")["rotor"])
        if name == "disc_radius":
            assert rotor.beyond == {}  # without friction it moves nothing
        else:
            assert getattr(rotor, name) == after
        # without a start it begins where the load holds it, and the address has none
        start = hanging(rotor) if rotor.load else [0, 0, 0, 0]
        assert page.facts("motion")["start"] == pytest.approx(start)
        page.until("location.hash.includes(arguments[0])", f"{name}={after}")
        assert "&y=" not in page.run("return location.hash")
        slider.send_keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    page.type("#field-disc_radius", 10)
    page.until(f"!/{'|'.join(SLIDERS[1:])}/.test(location.hash)")  # the paper's rotor again


@pytest.mark.parametrize(
    ("key", "state", "names"),
    [
        ("friction", CHATTERING, {2: "roll:", -2: "slip:", 3: "reverse:"}),
        ("damped", WHOLE | {"omega": 2, "zeta": 0.07, "delta0": 2}, {-4: "release:"}),
    ],
    ids=["friction", "damping"],
)
def test_its_events_are_told_and_drawn_with_friction_or_contact_damping_alone(
    page, address, key, state, names
):
    keys = f"Array.from(document.querySelectorAll('[data-{key}]'), (each) => each.offsetParent)"
    assert page.run(f"return {keys}.some(Boolean)") is False
    page = opened(page.driver, address, **{"x": 0, "y": 0, "vx": 0, "vy": 0} | state)
    assert page.run(f"return {keys}.every(Boolean)") is True
    assert page.find("#slider-load").is_displayed()  # what is not 0 is unfolded
    kinds = page.array("motion", "event_kind")
    times, radii = (page.array("motion", f"event_{name}") for name in ("time", "radius"))
    for kind, name in names.items():
        event = np.flatnonzero(kinds == kind)[-1 if key == "damped" else -3]
        told = hovered(page, '[data-plot="radius"]', [times[event], radii[event]])
        assert told.startswith(name)


def test_an_orbit_has_the_colours_of_slipping_and_rolling_with_friction_alone(page, address):
    page = opened(page.driver, address, **CHATTERING)
    assert not page.find("[data-frictionless]").is_displayed()
    for colour, least in {"rolling": 300, "backwards": 40, "contact": 100}.items():
        assert page.run(COLOURED, "orbit", colour) > least, colour
    plain = opened(page.driver, address, omega=1.2, zeta=0.07, delta0=0.5)
    assert plain.run(COLOURED, "orbit", "contact") > 100
    for colour in ("rolling", "backwards"):
        assert plain.run(COLOURED, "orbit", colour) == 0


def test_the_response_has_hopf_points_and_the_whirls_that_friction_keeps_up(page, address):
    page = opened(page.driver, address, **WHIP, x=5, vy=-6.3)
    page.until("rotorIda.shown[0].curve.arrays.hopf_omega.length")
    omega, radii = (page.array("curve", each) for each in ("whip_omega", "saddle_radius"))
    key = page.find("#response-key").text
    for words in ("Hopf point", "dry whip without unbalance", "slipping backward whirl, a saddle"):
        assert words in key
    at = np.searchsorted(omega, 1.2)
    page.settle("settled")
    told = hovered(page, '[data-panel="response"]', [omega[at], radii[at]])
    assert told.startswith("unstable slipping backward whirl")
    assert page.words().startswith("What it does\nIt settles on dry whip")


def test_the_whole_machine_in_si_units_is_the_same_rotor(page, address):
    whole = WHOLE | RUB
    page = with_machine(page, address, **whole)
    page.find('[name="units"][value="si"]').click()
    page.settle()
    names = [
        *("mass", "contact_stiffness", "damping", "eccentricity", "clearance", "speed"),
        *whole,
    ]
    machine, told = machine_of(page, names), page.facts("motion")
    assert Rotor(**told["rotor"]) == machine.rotor()
    for name, value in {"omega": 2.0, "zeta": 0.07, "delta0": 2.0, **whole}.items():
        assert told["rotor"][name] == pytest.approx(value, rel=1e-12)
    assert told["scales"]["force"] == machine.force_scale
    assert "[MN/m]" in page.find("label[for='field-contact_stiffness']").text
    assert "[µm]" in page.find("label[for='field-disc_radius']").text
    # the other law at the same scales: a force of its own unit, and no other frequency
    page.find('[name="exponent"][value="1.5"]').send_keys(Keys.SPACE)
    page.settle()
    assert "N/m¹·⁵]" in page.find("label[for='field-contact_stiffness']").text
    other = page.facts("motion")
    assert other["scales"] == pytest.approx(told["scales"], rel=1e-12)
    assert "contact_exponent" not in other["rotor"]
    page.find("#weight").send_keys(Keys.SPACE)
    page.settle()
    assert page.state()["load"] == pytest.approx(4 * 9.80665, rel=1e-14)
    page.run("scrollTo(0, 0)")  # from under the verdict, which stays at the top
    page.find('[name="units"][value="none"]').click()
    page.settle()
    rotor = page.facts("motion")["rotor"]
    assert rotor["shaft_stiffness"] == pytest.approx(0.25, rel=1e-12)
    assert not page.find("#weight").is_displayed()


def machine_of(page, names):
    state = page.state()
    return DimensionalRotor(**{name: state[name] for name in names})


def test_a_bad_value_is_told_and_the_page_lives_on(page):
    page.type("#field-zeta", -1)
    said = page.until("document.getElementById('message').textContent")
    assert said == "zeta must be zero or positive, got -1.0"
    greyed = page.until("document.querySelectorAll('.stale').length")
    assert greyed == 3  # the panels of the rotor, the response and the words
    assert page.find("#old").is_displayed()
    page.type("#field-zeta", 0.1)
    page.settle()
    assert page.facts("motion")["rotor"]["zeta"] == 0.1
    assert not page.find("#trouble").is_displayed()
    page.type("#field-omega", 1e-5)  # it moves, but nothing settles
    page.until("document.getElementById('words').textContent.includes('omega must be 0 or from')")
    assert page.run("return document.querySelectorAll('.stale').length") == 0


def test_a_second_clearance_that_is_refused_leaves_the_first_rotor_as_it_is(whole):
    whole.find("#beside").click()
    whole.settle()
    whole.settle(side=1)
    whole.type("#field-second", -1)
    whole.until("document.getElementById('message').textContent.includes('delta0 must be')")
    whole.until("rotorIda.shown[0].motion.number === rotorIda.asked")
    stale = "Array.from(document.querySelectorAll('.side'), (each) => each.matches('.stale'))"
    whole.until(f"String({stale}) === 'false,true'")
    keys = "Array.from(document.querySelectorAll('[data-panel=starts] [data-key]'))"
    whole.until(f"{keys}[1].textContent === 'no basin of what was asked'")
    assert whole.find("#trouble").is_displayed()


def test_the_speed_of_a_machine_goes_on_from_where_it_is_when_its_mass_has_moved(page):
    page.find('[name="units"][value="si"]').click()
    page.type("#field-mass", 16)
    page.settle()
    slider = page.find("#slider-speed")
    top = 1.5 * page.state()["fastest"]
    assert float(slider.get_attribute("value")) == pytest.approx(1000 / top)
    slider.send_keys(Keys.ARROW_RIGHT)
    assert page.state()["speed"] == pytest.approx(1000 + top / 400, rel=1e-3)


def test_arrows_step_from_the_value_that_was_typed(page):
    for beyond in (2.0013, 7.3):
        page.type("#field-omega", beyond)
        page.find("#field-omega").send_keys(Keys.ARROW_UP, Keys.ARROW_UP, Keys.ARROW_DOWN)
        assert page.state()["omega"] == pytest.approx(beyond + 0.005, abs=1e-12)
        page.find("#slider-omega").send_keys(Keys.ARROW_LEFT)
        assert page.state()["omega"] == pytest.approx(beyond, abs=1e-12)
    page.find("#start-vx").send_keys(Keys.ARROW_DOWN)
    assert page.state()["vx"] == -0.05
    page.settle()
    assert page.facts("motion")["start"] == [0, 0, -0.05, 0]


def test_without_damping_there_is_a_motion_and_no_basin(whole):
    whole.type("#field-zeta", 0)
    whole.settle()
    assert "nothing settles" in whole.words()
    whole.until("document.querySelector('[data-key]').textContent.includes('zeta must be above 0')")


def test_two_clearances_side_by_side(page):
    page.find("#beside").click()
    page.settle()
    page.settle(side=1)
    page.type("#field-second", 0.5)
    page.settle(side=1)
    assert [page.facts("motion", side)["rotor"]["delta0"] for side in (0, 1)] == [2.0, 0.5]
    time.sleep(0.3)
    assert len(page.pictures()) == 2 * PLOTS - 2
    assert all(page.pictures())
    page.find("#beside").click()
    page.settle()
    assert len(page.pictures()) == PLOTS


def test_dragging_on_the_plane_moves_the_start(page):
    plane = page.find('[data-panel="starts"] .u-over')
    page.pointer_on(plane, 40, -30).click().perform()
    page.settle()
    x, y, vx, vy = page.facts("motion")["start"]
    assert x > 0.5
    assert y > 0.5
    assert (vx, vy) == (0, 0)
    page.find('[data-panel="starts"] [value="velocity"]').click()
    chain = page.pointer_on(plane, 40, -30)
    chain.click_and_hold().move_by_offset(-25, 0).release().perform()
    page.settle()
    after = page.facts("motion")["start"]
    assert after[:2] == [x, y]
    assert after[2] < -0.5
    assert abs(after[3]) < 0.3
    page.find("#rest").click()
    page.settle()
    assert page.facts("motion")["start"] == [0, 0, 0, 0]


def test_dragging_on_the_response_moves_the_speed(page):
    curve = page.find('[data-panel="response"] .u-over')
    width = curve.size["width"]
    page.pointer_on(curve, -width // 4).click().perform()
    page.settle()
    assert page.state()["omega"] == pytest.approx(1.0, abs=0.02)


def test_a_start_and_a_length_are_typed(page):
    page.type("#start-x", 3)
    page.type("#start-vy", -1.5)
    page.type("#revolutions", 20)
    page.settle()
    assert page.facts("motion")["start"] == [3, 0, 0, -1.5]
    assert page.array("motion", "t")[-1] == pytest.approx(20 * np.pi)


def test_time_is_scrubbed_and_played(fresh):
    fresh.settle("settled", "section", "lines", "branch")
    before = fresh.pictures_at_rest()
    slider = fresh.find("[data-time]")
    slider.send_keys(Keys.HOME)
    time.sleep(0.3)
    assert float(slider.get_attribute("value")) == 0.0
    moved = [one != other for one, other in zip(before, fresh.pictures(), strict=True)]
    assert sum(moved) == 4  # both orbits, radius and force
    play = fresh.find("[data-play]")
    play.click()
    fresh.until("Number(document.querySelector('[data-time]').value) > 0.005")
    play.click()
    fresh.find("[data-window]").send_keys("t")
    time.sleep(0.3)
    assert all(fresh.pictures())


def test_the_address_is_the_state(page):
    page.type("#start-x", 2.5)
    page.type("#field-omega", 1.8)
    page.find('[name="from"][value="here"]').click()
    page.settle()
    end = page.facts("motion")["end"]
    page.find("#slider-omega").send_keys(Keys.ARROW_RIGHT)
    page.settle()
    assert page.facts("motion")["start"] == end
    told = [page.facts("motion")[name] for name in ("rotor", "start")]
    page.until("location.hash.includes(`omega=${rotorIda.state.omega}`)")
    address = page.driver.current_url
    assert "key=" not in address
    time.sleep(0.4)
    page.driver.refresh()
    page.settle()
    assert [page.facts("motion")[name] for name in ("rotor", "start")] == told
    assert page.find('[name="from"][value="here"]').is_selected()


def test_a_file_is_saved(page, address):
    page = opened(page.driver, address, omega=2, zeta=0.07, delta0=2, revolutions=5)
    place = page.driver.folder / "run.nc"
    place.unlink(missing_ok=True)
    page.find('[data-file="nc"]').click()
    run = rotor_ida.load(downloaded(place))
    np.testing.assert_array_equal(page.array("motion", "event_time"), run.event_time.values)


def test_the_speed_of_a_machine_is_shown_in_turns_a_minute(page):
    page.find('[name="units"][value="si"]').click()
    page.type("#speed-unit", "rpm")
    field = page.find("#field-speed")
    shown = page.state()["speed"] * 30 / np.pi
    assert field.get_attribute("value") == f"{shown:.4g}"
    page.type("#field-speed", 3000)
    page.settle()
    assert page.state()["speed"] == pytest.approx(100 * np.pi, rel=1e-15)
    told = page.facts("motion")
    assert told["rotor"]["omega"] * told["scales"]["rate"] == pytest.approx(100 * np.pi)
    curve = page.find('[data-panel="response"] .u-over')
    page.pointer_on(curve).click().perform()
    page.settle()
    assert page.facts("motion")["rotor"]["omega"] == pytest.approx(2.0, abs=0.02)
    page.type("#speed-unit", "Hz")
    page.until("location.hash.includes('speedIn=Hz')")
    for typed, shown in {"4500 rpm": "4500", "1,200 RPM": "1200", "50hz": "50"}.items():
        page.type("#field-speed", typed)
        assert field.get_attribute("value") == shown
        unit = "Hz" if "hz" in typed else "rpm"
        assert page.find("#speed-unit").get_attribute("value") == unit
        turns = float(shown) / (1.0 if unit == "Hz" else 60.0)
        assert page.state()["speed"] == pytest.approx(2.0 * np.pi * turns, rel=1e-15)
    page.type("#field-speed", "fast")
    assert field.get_attribute("value") == "50"
    page.type("#fastest", "9000 rpm")
    assert page.state()["fastest"] == pytest.approx(300.0 * np.pi, rel=1e-15)


def test_the_response_reaches_as_far_as_the_rotor(page):
    for omega in (0.02, 7.3):
        page.type("#field-omega", omega)
        page.settle()
        curve = page.array("curve", "omega")
        assert np.nanmin(curve) < omega < np.nanmax(curve)


COPIED = {
    '[data-copy="sh"]': ("command line", "rotor-ida simulate --omega 2.0 --zeta 0.07"),
    '[data-copy="py"]': ("lines of Python", '"""The run that the explorer showed'),
    "#share": ("address", "http://127.0.0.1:"),
}


def test_what_makes_the_run_again_is_copied(page, address):
    page = with_machine(page, address, **WHOLE)
    for button, (told, beginning) in COPIED.items():
        text = copied(page, button, f"The {told} is copied.")
        assert text.startswith(beginning)
        assert "load" in text


def test_radii_times_and_lines_are_read_under_the_pointer(whole):
    whole.settle("settled", "section", "lines")
    times, forces = whole.array("motion", "peak_time"), whole.array("motion", "peak_force")
    text = hovered(whole, '[data-plot="force"]', [times[-2], forces[-2]])
    assert text.startswith("peak: ")
    assert number_after("time", text) == pytest.approx(times[-2], rel=1e-7)
    assert number_after("force", text) == pytest.approx(forces[-2], rel=1e-5)
    entry = whole.array("motion", "event_time")[-3]
    text = hovered(whole, '[data-plot="radius"]', [entry, 2.0])
    assert text.startswith(("entry: ", "exit: "))
    assert number_after("time", text) == pytest.approx(entry, rel=1e-7)
    whole.until("rotorIda.shown[0].lines?.number === rotorIda.asked")
    orders, heights = (whole.array("settled", f"exact_{name}") for name in ("order", "amplitude"))
    at = int(np.nanargmax(heights))
    text = hovered(whole, '[data-panel="full"]', [orders[at], heights[at]])
    assert text.startswith("settled response, the rotor: ")
    assert number_after("amplitude", text) == pytest.approx(heights[at], rel=1e-5)
    text = hovered(whole, '[data-panel="orbit"]', [1.0, 0.0])
    assert number_after("radius", text) == pytest.approx(1.0, abs=0.05)
    each = whole.facts("motion")["samples_per_revolution"]
    mark = [float(whole.array("motion", axis)[-1 - each]) for axis in ("x", "y")]
    assert hovered(whole, '[data-panel="orbit"]', mark).startswith("once a revolution")
    text = hovered(whole, '[data-panel="starts"]', [0.0, 0.0])
    assert text.startswith("bouncing")


def test_the_cursor_stays_under_the_pointer_when_the_page_moves(page):
    over = page.find('[data-panel="response"] .u-over')
    page.run("scrollTo(0, 0)")
    ActionChains(page.driver).move_to_element(over).perform()
    page.run("document.body.style.paddingTop = '31px'")
    try:
        ActionChains(page.driver).move_to_element_with_offset(over, 9, 0).perform()
        across, down = page.run(
            "const { cursor } = rotorIda.plotOf(arguments[0]);"
            "const { width, height } = arguments[0].getBoundingClientRect();"
            "return [cursor.left - width / 2, cursor.top - height / 2];", over
        )  # fmt: skip
    finally:
        page.run("document.body.style.paddingTop = ''")
    assert across == pytest.approx(9, abs=1)
    assert down == pytest.approx(0, abs=1)


def test_a_box_is_zoomed_into_and_out_of(page):
    page.settle("settled", "section", "branch")
    page.pictures_at_rest()  # what is drawn anew in the midst of a drag is whole again
    for panel in ("orbit", "history", "response"):
        button = page.find(f'[data-panel="{panel}"] .tools button')
        over = page.find(f'[data-panel="{panel}"] .u-over')
        ranges = (
            "return ['x', 'y'].map((each) => rotorIda.plotOf(document.querySelector("
            "`[data-panel=${arguments[0]}] .u-over`)).scales[each]).map(({min, max}) => [min, max])"
        )
        before = page.run(ranges, panel)
        if panel == "response":  # there a drag without the button moves the speed
            page.run("arguments[0].click()", button)
        chain = page.pointer_on(over, -30, -15)
        chain.click_and_hold().move_by_offset(60, 30).release().perform()
        for (low, high), (lowest, highest) in zip(page.run(ranges, panel), before, strict=True):
            assert lowest <= low < high <= highest
            assert high - low < 0.9 * (highest - lowest)
        assert page.state()["omega"] == 2
        page.find("#slider-zeta").send_keys(Keys.ARROW_RIGHT)
        page.settle()
        assert page.run(ranges, panel) != before  # the part stays in view while a slider moves
        page.find("#slider-zeta").send_keys(Keys.ARROW_LEFT)
        page.settle()
        assert button.text == "Show all"
        page.run("arguments[0].click()", button)
        assert page.run(ranges, panel) == before


PANELS = ("response", "starts", "orbit", "turning", "history", "section", "full")


def test_each_panel_is_saved_as_picture_and_table(whole):
    whole.settle("settled", "section", "lines")
    whole.until("rotorIda.shown[0].basin?.facts.finest")
    whole.until("rotorIda.hasAllDrawn()")
    folder = whole.driver.folder
    # Chromium drops what a page saves beyond ten files in a second
    for name in (*(f"{panel}.csv" for panel in PANELS), "starts.png", "history.png", "full.png"):
        panel, _, ending = name.partition(".")
        whole.find(f'[data-panel="{panel}"] summary').click()
        whole.find(f'[data-panel="{panel}"] [data-keep="{ending}"]').click()
        downloaded(folder / name)
        if ending == "png":
            assert (folder / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    rows = np.genfromtxt(folder / "orbit.csv", delimiter=",", names=True)
    for name, own in {"time": "t", "x": "x", "y": "y", "radius": "radius"}.items():
        np.testing.assert_array_equal(rows[name], whole.array("motion", own))
    with (folder / "history.csv").open() as file:
        events = [float(row["time"]) for row in csv.DictReader(file) if row["what"] in EVENTS]
    np.testing.assert_array_equal(events, whole.array("motion", "event_time"))
    with (folder / "response.csv").open() as file:
        found = [float(row["speed ω"]) for row in csv.DictReader(file) if row["what"] == "fold"]
    np.testing.assert_array_equal(found, whole.array("curve", "fold_omega"))
    with (folder / "starts.csv").open() as file:
        labels = [int(row["attractor"]) for row in csv.DictReader(file)]
    np.testing.assert_array_equal(labels, whole.array("basin", "label"))


def test_nothing_is_cut_off_in_dark_and_light_and_all_has_a_name(page):
    page.find("#machine summary").click()
    for width in (390, 800, 1400):
        with sized(page.driver, width):
            page.until(FITS, width)
            seen = "[...document.querySelectorAll('canvas')].filter((each) => each.offsetParent)"
            assert min(page.run(f"return {seen}.map((each) => each.clientWidth)")) >= 180
    paper = "getComputedStyle(document.body).backgroundColor"
    before = page.run(f"return {paper}")
    page.find("#theme").click()
    assert page.run(f"return {paper}") != before
    time.sleep(0.3)
    assert all(page.pictures())
    page.find("#theme").click()
    assert page.run(f"return {paper}") == before
    page.settle("settled")
    page.driver.execute_cdp_cmd("Accessibility.enable", {})
    nodes = page.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = {"slider", "spinbutton", "button", "checkbox", "radio", "image", "combobox"}
    named = [
        (node["role"]["value"], node.get("name", {}).get("value", ""))
        for node in nodes
        if not node["ignored"] and node["role"]["value"] in roles
    ]
    assert {role for role, _ in named} == roles
    assert [role for role, name in named if not name.strip()] == []
    assert {
        ("slider", "Shaft stiffness κ"), ("slider", "Contact damping c"), ("slider", "Load γ"),
        ("radio", "3/2, Hertz"), ("radio", "1, a linear spring"),
    } <= set(named)  # fmt: skip


def test_a_page_that_needs_no_server(chromium, tmp_path):
    file = tmp_path / "page.html"
    words = ["explore", *RUNNING, "--export", str(file), "--speeds", "1.9", "2", "2.1"]
    assert main(words) == 0
    page = Page(chromium, file.as_uri())
    (sent,) = answer_to(question())
    events = page.array("motion", "event_time")
    np.testing.assert_allclose(events, sent.arrays["event_time"][-events.size :], rtol=1e-7)
    page.find("#recorded-speed").send_keys(Keys.ARROW_RIGHT)
    page.settle("settled", "section")
    assert page.facts("motion")["rotor"]["omega"] == 2.1
    page.find('[name="course"][value="up"]').click()
    page.settle()
    assert page.facts("motion")["start"] != [0, 0, 0, 0]
    time.sleep(0.3)
    assert sum(map(bool, page.pictures())) == PLOTS - 1
    resources = page.run("return performance.getEntriesByType('resource').map((each) => each.name)")
    assert [name for name in resources if not name.startswith("data:")] == []
    assert errors_of(chromium) == []


def test_a_phone_shows_the_verdict_first_and_a_plot_in_view_of_each_slider(page):
    box = "getBoundingClientRect()"
    with sized(page.driver, 390, 844):
        page.settle("settled")
        tops = [page.run(f"return document.querySelector('{each}').{box}.top")
                for each in ("#verdict", '[data-panel="response"]', "#controls")]  # fmt: skip
        assert tops == sorted(tops)
        assert tops[1] < 200
        outside = page.run(
            "return [...document.querySelectorAll('.actions > *')]"
            f".filter((each) => each.{box}.right > innerWidth).length"
        )
        assert outside == 0
        page.run("arguments[0].click()", page.find('[name="units"][value="si"]'))
        for name in ("speed", "eccentricity"):
            slider = f"document.getElementById('slider-{name}')"
            page.run(f"{slider}.scrollIntoView({{block: 'center'}})")
            time.sleep(0.3)
            top, bottom = page.run(
                f"const {{top, bottom}} = document.querySelector('[data-panel=response] .plot')"
                f".{box}; return [top, bottom]"
            )
            assert top >= 0
            assert bottom < page.run(f"return {slider}.{box}.top")
