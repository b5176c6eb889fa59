"""The page of a rotor system in a browser: it is drawn, plays, and says what is wrong."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from rotor_ida import load_course, load_system, run_up, save, simulate, sweep
from tests.explorer.browser import (
    FITS,
    Page,
    copied,
    downloaded,
    drop_all,
    ended,
    errors_of,
    needs_browser,
    served,
    sized,
)

pytestmark = needs_browser

SET = """
const field = document.getElementById(arguments[0]);
field.value = arguments[1];
field.dispatchEvent(new Event(arguments[2] ?? "change"));
"""
TWO_NODES = """
speed = "2000 rpm"
[system]
mass = [4, 4, 1, 1]
stiffness = [[2e5, 0, -1e5, 0], [0, 2e5, 0, -1e5], [-1e5, 0, 2e5, 0], [0, -1e5, 0, 2e5]]
damping = [80, 80, 20, 20]
nodes = { disc = [0, 1], "</script><script>window.ran = 1</script>" = [2, 3] }
[[contacts]]
node = "disc"
clearance = "60 um"
stiffness = "1e7 N/m"
[[unbalance]]
node = "disc"
moment = "100 g mm"
"""


PUMP = """
mass = "12 kg"
shaft_stiffness = "4 MN/m"
damping = "415.7 N s/m"
clearance = "150 um"
eccentricity = "16.7 um"
speed = "3600 rpm"
contact_stiffness = "1e8 N/m"
"""
FALLING = """
speed = "4800 rpm"
drop = { duration = "10 ms" }
[system]
mass = [20, 20, 20, 20]
stiffness = [[2e6, 0, -2e6, 0], [0, 2e6, 0, -2e6], [-2e6, 0, 2e6, 0], [0, -2e6, 0, 2e6]]
nodes = { left = [0, 1], right = [2, 3] }
[[supports]]
node = "left"
stiffness = "2e6 N/m"
damping = "2e3 N s/m"
[[supports]]
node = "right"
stiffness = "2e6 N/m"
damping = "2e3 N s/m"
[[contacts]]
node = "left"
clearance = "0.2 mm"
stiffness = "2e9 N/m^1.5"
[[contacts]]
node = "right"
clearance = "0.2 mm"
stiffness = "2e9 N/m^1.5"
"""
SEAL = "</script><script>window.ran = 1</script>"


class SystemPage(Page):
    """The page of a system: it has settled when all panels are there."""

    def settle(self):
        for part in ("motion", "curve", "settled", "lines", "campbell", "track"):
            self.until(
                "window.rotorIda?.shown[0]?.[arguments[0]] && (location.protocol === 'file:' || "
                "rotorIda.shown[0][arguments[0]].number === rotorIda.asked)", part,
            )  # fmt: skip
        self.until("rotorIda.hasAllDrawn()")


def test_a_system_is_shown_and_played_and_one_page_shows_every_node_without_the_program(
    chromium, tmp_path
):
    path = tmp_path / "my two.toml"
    path.write_text(TWO_NODES)
    process, address = served(str(path))
    (chromium.folder / "run.html").unlink(missing_ok=True)
    try:
        page = SystemPage(chromium, address)
        check_drawn_and_played(page)
        check_bad_file_refused(page)  # and what is shown can still be changed
        check_state_in_the_address(page)
        page.find('[data-file="html"]').click()
        page.until("document.getElementById('connection').textContent.startsWith('Sav')")
        file = downloaded(chromium.folder / "run.html")
        check_another_rotor_and_back(page)
        assert errors_of(chromium) == []
        ended(process)
        page.until("document.getElementById('connection').textContent.startsWith('No answer')")
        assert page.run("return document.querySelectorAll('.stale').length") > 0
        check_alone(SystemPage(chromium, file.as_uri()), path)
        # the first page has no server any more
        assert [each for each in errors_of(chromium) if "connection.js" not in each] == []
    finally:
        chromium.get("about:blank")
        ended(process)


def check_drawn_and_played(page):
    assert "rotor" in page.find("#verdict").text
    assert all(page.pictures())
    for width in (390, 1400):
        with sized(page.driver, width):
            page.until(FITS, width)
    before = page.pictures()
    page.run("document.querySelector('[data-play]').click()")
    page.until("document.querySelector('[data-time]').valueAsNumber > 0.01")
    page.run("document.querySelector('[data-play]').click()")
    shape = page.run(
        "return [...document.querySelectorAll('canvas')].filter((each) => each.offsetParent)"
        ".findIndex((each) => each.closest('[data-panel=\"shape\"]'))"
    )
    assert page.pictures()[shape] != before[shape]


SHOWN = """
return [...document.querySelectorAll('[data-panel]')].filter((each) => each.offsetParent)
  .map((each) => each.dataset.panel)"""
OF_RUN_UP = {"bode", "cascade", "response", "campbell", "orbit", "turning", "history", "archive",
             "sketch", "shape"}  # fmt: skip


def check_bad_file_refused(page):
    said = drop_all(page, {"bad.toml": b"speed = 3"})
    assert said.startswith("bad.toml is not shown: ")
    assert "system must be given" in said


def check_state_in_the_address(page):
    """Change the clearance, choose a node in the sketch, go back and forward, and load again."""
    page.run(SET, "field-clearance", 47, "input")
    page.until("location.hash.includes('clearance=0.000047')")
    command = copied(page, '[data-copy="sh"]', "The command line is copied.")
    assert '"47um"' in command
    assert "'my two.toml' --speed 2000rpm" in command
    time.sleep(1.1)  # changes in one movement are undone together
    over = page.find('[data-panel="sketch"] .u-over')
    page.pointer_on(over, across=0.42 * over.rect["width"]).click().perform()
    page.until("rotorIda.state.node !== 'disc' && location.hash.includes('script')")
    page.settle()
    assert page.facts("motion")["told"].startswith("node </script>")
    page.driver.back()
    page.until("rotorIda.state.node === 'disc'")
    page.driver.back()
    page.until("document.getElementById('field-clearance').value === '60'")
    page.driver.forward()
    page.until("document.getElementById('field-clearance').value === '47'")
    page.driver.refresh()
    page.settle()
    assert page.facts("motion")["rotor"]["delta0"] == 47e-6


def check_another_rotor_and_back(page):
    """A machine is opened in the place of the system, and the system is gone back to."""
    drop_all(page, {"pump.toml": PUMP.encode()})
    page.until("rotorIda.state.mass === 12")
    Page.settle(page, "settled")
    assert page.find("#verdict").text.startswith("No contact")
    assert not page.find('[data-panel="sketch"]').is_displayed()
    page.driver.back()
    page.until("rotorIda.state.node === 'disc'")
    page.settle()
    assert "contact 0 (disc)" in page.find("#verdict").text
    assert page.facts("motion")["rotor"]["delta0"] == 47e-6


def check_alone(page, path):
    """Check the page that needs no program."""
    assert not page.find("#saving").is_displayed()
    peaks = run_of(path, 47e-6)["peak_force"].values
    np.testing.assert_allclose(page.array("motion", "peak_force"), peaks, rtol=1e-6)
    assert page.run("return window.ran") is None
    page.run(SET, "node", SEAL)
    page.until("rotorIda.shown[0].motion.facts.told.startsWith(`node ${arguments[0]}`)", SEAL)
    page.until("rotorIda.shown[0].curve.facts.told.startsWith(`node ${arguments[0]}`)", SEAL)
    resources = page.run("return performance.getEntriesByType('resource').map((e) => e.name)")
    assert [name for name in resources if not name.startswith("data:")] == []


def shows(page, width):
    """Return the panels that are seen in a window of a width, in which nothing is cut off."""
    with sized(page.driver, width):
        page.until(FITS, width)
        return set(page.run(SHOWN))


def test_a_file_that_is_dropped_has_the_panels_that_say_something_of_it(fresh, tmp_path):
    """A run-up, a result that is not played, and a drop, whose two bearings are side by side."""
    path = tmp_path / "two.toml"
    path.write_text(TWO_NODES)
    save(run_up(load_system(path), speed=20.0, to=250.0, rate=200.0), tmp_path / "up.nc")
    save(sweep(omega=[0.5, 1.0], zeta=[0.07], delta0=[0.5]), tmp_path / "sweep.nc")
    drop_all(fresh, {"up.nc": (tmp_path / "up.nc").read_bytes()})
    fresh.until("rotorIda.shown[0].track?.arrays.order_speed.length > 10")
    fresh.until("document.querySelector('#sheets table') && rotorIda.hasAllDrawn()")
    fresh.until("document.getElementById('figure').naturalWidth > 100")
    assert shows(fresh, 390) == shows(fresh, 1400) == OF_RUN_UP
    assert "while the speed changes" in fresh.find("#response-key").text
    axes = "return rotorIda.plotOf(document.querySelector(arguments[0] + ' .u-over'))" \
        ".axes.map((each) => each._values.join(''))"  # fmt: skip
    assert fresh.run(axes, '[data-panel="sketch"]') == ["", ""]
    assert all(fresh.run(axes, '[data-panel="history"]'))
    drop_all(fresh, {"sweep.nc": (tmp_path / "sweep.nc").read_bytes()})
    fresh.until("document.getElementById('verdict').textContent.startsWith('sweep.nc')")
    assert shows(fresh, 390) == shows(fresh, 1400) == {"archive"}
    drop_all(fresh, {"drop.toml": FALLING.encode()})
    for side in (0, 1):
        fresh.until("rotorIda.shown[arguments[0]]?.motion?.facts.told", side)
    fresh.until("rotorIda.hasAllDrawn()")
    named = "node {}, contact {}, speed 4,800 rpm"
    told = [fresh.facts("motion", side)["told"] for side in (0, 1)]
    assert told == [named.format(*each) for each in (("left", 0), ("right", 1))]
    assert not fresh.find('[name="signals"][value="bode"]').is_displayed()


def test_a_measurement_of_the_command_is_shown_alone_also_after_a_reload(chromium, tmp_path):
    turn = np.arange(0.0, 60.0, 0.05)
    table = np.stack([turn, 2.0 * np.cos(turn), 2.0 * np.sin(turn), turn], axis=1)
    np.savetxt(tmp_path / "probes.csv", table, delimiter=",", header="t,x,y,angle", comments="")
    process, address = served(str(tmp_path / "probes.csv"))
    try:
        chromium.get(address)
        page = Page.__new__(Page)
        page.driver = chromium
        page.until("window.rotorIda?.measured.found?.samples === arguments[0]", len(table))
        page.until("document.querySelector('[data-panel=bode] canvas')")
        assert set(page.run(SHOWN)) == {"bode", "polar", "full"}
        assert all(page.pictures())
        chromium.refresh()
        page.until("window.rotorIda?.measured.found?.samples === arguments[0]", len(table))
        assert errors_of(chromium) == []
    finally:
        chromium.get("about:blank")
        ended(process)


def run_of(path, clearance):
    """Return the run that the page shows, from Python."""
    system, course = load_system(path), load_course(path)
    contacts = [replace(system.contacts[0], clearance=clearance)]
    return simulate(system, **course.motion, contacts=contacts, speed=course.speed,
                    duration=2.0 * np.pi * 60 / course.speed)  # fmt: skip
