"""The page of a rotor system in a browser: it is drawn, plays, and says what is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import load_course, load_system, simulate
from tests.explorer.browser import Page, downloaded, ended, errors_of, needs_browser, served

pytestmark = needs_browser

DROPPED = """
const files = new DataTransfer();
files.items.add(new File([arguments[0]], "bad.toml"));
dispatchEvent(new DragEvent("drop", { dataTransfer: files, cancelable: true }));
"""


SET = """
const field = document.getElementById(arguments[0]);
field.value = arguments[1];
field.dispatchEvent(new Event("change"));
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


SEAL = "</script><script>window.ran = 1</script>"


class SystemPage(Page):
    """The page of a system: it has settled when all panels are there."""

    def settle(self):
        for part in ("run", "map", "campbell", "runUp"):
            self.until("window.rotorIda && rotorIda[arguments[0]]", part)


def test_a_system_is_shown_and_played_and_one_page_shows_every_node_without_the_program(
    chromium, tmp_path
):
    path = tmp_path / "my two.toml"
    path.write_text(TWO_NODES)
    process, address = served(str(path))
    (chromium.folder / "run.html").unlink(missing_ok=True)
    try:
        page = SystemPage(chromium, address)
        check_played(page)
        check_bad_file_refused(page)  # and what is shown can still be changed
        command = check_state_in_the_address(page)
        page.find('[data-file="html"]').click()
        file = downloaded(chromium.folder / "run.html")
        assert errors_of(chromium) == []
        ended(process)
        check_alone(SystemPage(chromium, file.as_uri()), command, path)
        # the first page has no server any more
        assert [each for each in errors_of(chromium) if "connection.js" not in each] == []
    finally:
        chromium.get("about:blank")
        ended(process)


def check_played(page):
    assert "rotor" in page.find("#verdict").text
    page.run("document.getElementById('play').click()")
    page.until("rotorIda.time > 0 && rotorIda.time < 1")


def check_bad_file_refused(page):
    page.run(DROPPED, "speed = 3")
    page.until("rotorIda.errors.length")
    assert page.find("#trouble").text.startswith("bad.toml: system must be given")


def check_state_in_the_address(page):
    """Change the clearance, go back and forward, and load again; return the command shown."""
    page.run(SET, "number-clearance", 47)
    page.until("document.getElementById('command').textContent.includes('\"47um\"')")
    page.until("location.hash.includes('clearance=0.000047')")
    command = page.find("#command").text
    assert "'my two.toml' --speed 2000rpm" in command
    page.find("#undo").click()
    page.until("document.getElementById('number-clearance').value === '60'")
    page.find("#redo").click()
    page.until("document.getElementById('number-clearance').value === '47'")
    page.driver.refresh()
    page.settle()
    page.until("document.getElementById('number-clearance').value === '47'")
    assert page.find("#command").text == command
    return command


def check_alone(page, command, path):
    """Check the page that needs no program."""
    assert page.find("#command").text == command
    assert not page.find("#undo").is_displayed()
    force = page.run("return Math.max(...rotorIda.run.normal_force)")
    assert force == pytest.approx(float(run_of(path, 47e-6)["normal_force"].max()), rel=1e-6)
    assert page.run("return window.ran") is None
    page.run(SET, "node", SEAL)
    page.until("[rotorIda.run, rotorIda.map].every((e) => e.facts.node === arguments[0])", SEAL)
    page.run("document.getElementById('play').click()")
    page.until("rotorIda.time > 0 && rotorIda.time < 1")
    resources = page.run("return performance.getEntriesByType('resource').map((e) => e.name)")
    assert [name for name in resources if not name.startswith("data:")] == []
    assert page.run("return rotorIda.errors") == []


def run_of(path, clearance):
    """Return the run that the page shows, from Python."""
    system, course = load_system(path), load_course(path)
    contacts = [replace(system.contacts[0], clearance=clearance)]
    return simulate(system, **course.motion, contacts=contacts, speed=course.speed,
                    duration=2.0 * np.pi * 60 / course.speed)  # fmt: skip
