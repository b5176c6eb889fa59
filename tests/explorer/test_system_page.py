"""The page of a rotor system in a browser: it is drawn, plays, and says what is wrong."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import load_system, simulate
from tests.explorer.browser import PATIENCE, Page, chromium_in, ended, errors_of, served
from tests.explorer.test_systems import DISC

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
nodes = { disc = [0, 1], seal = [2, 3] }
[[contacts]]
node = "disc"
clearance = "60 um"
stiffness = "1e7 N/m"
[[unbalance]]
node = "disc"
moment = "100 g mm"
"""


class SystemPage(Page):
    """The page of a system: it has settled when all panels are there."""

    def settle(self):
        for part in ("run", "map", "campbell", "runUp"):
            self.until("window.rotorIda && rotorIda[arguments[0]]", part)


def test_a_system_is_shown_played_and_a_bad_file_is_refused(tmp_path):
    path = tmp_path / "disc.toml"
    path.write_text(DISC)
    process, address = served(str(path))
    driver = chromium_in(tmp_path)
    try:
        page = SystemPage(driver, address)
        assert "rotor" in page.find("#verdict").text
        page.run("document.getElementById('play').click()")
        page.until("rotorIda.time > 0 && rotorIda.time < 1")
        page.run(DROPPED, "speed = 3")
        page.until("rotorIda.errors.length")
        assert page.find("#trouble").text.startswith("bad.toml: system must be given")
        assert errors_of(driver) == []
    finally:
        driver.quit()
        ended(process)


def test_the_state_is_in_the_address_and_one_page_shows_every_node_without_the_program(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(TWO_NODES)
    process, address = served(str(path))
    driver = chromium_in(tmp_path)
    try:
        page = SystemPage(driver, address)
        page.run(SET, "number-clearance", 47)
        page.until("document.getElementById('command').textContent.includes('\"47um\"')")
        page.until("location.hash.includes('clearance=0.000047')")
        command = page.find("#command").text
        assert "--speed 2000rpm" in command
        page.find("#undo").click()
        page.until("document.getElementById('number-clearance').value === '60'")
        page.find("#redo").click()
        page.until("document.getElementById('number-clearance').value === '47'")
        driver.refresh()
        page.settle()
        page.until("document.getElementById('number-clearance').value === '47'")
        assert page.find("#command").text == command
        page.find('[data-file="html"]').click()
        file = wait_for(tmp_path / "run.html")
    finally:
        ended(process)
    try:
        alone = SystemPage(driver, file.as_uri())
        assert alone.find("#command").text == command
        assert not alone.find("#undo").is_displayed()
        force = alone.run("return Math.max(...rotorIda.run.normal_force)")
        assert force == pytest.approx(float(run_of(path, 47e-6)["normal_force"].max()), rel=1e-6)
        alone.run(SET, "node", "seal")
        alone.until("rotorIda.run.facts.node === 'seal' && rotorIda.map.facts.node === 'seal'")
        alone.run("document.getElementById('play').click()")
        alone.until("rotorIda.time > 0 && rotorIda.time < 1")
        resources = alone.run("return performance.getEntriesByType('resource').map((e) => e.name)")
        assert [name for name in resources if not name.startswith("data:")] == []
        assert alone.run("return rotorIda.errors") == []
    finally:
        driver.quit()


def run_of(path, clearance):
    """Return the run that the page shows, from Python."""
    case = load_system(path)
    contacts = [replace(case.contacts[0], clearance=clearance)]
    return simulate(case.system, **case.around | {"contacts": contacts}, speed=case.speed,
                    duration=2.0 * np.pi * 60 / case.speed)  # fmt: skip


def wait_for(place):
    """Return a downloaded file once it is there."""
    deadline = time.monotonic() + PATIENCE
    while not place.exists():
        assert time.monotonic() < deadline
        time.sleep(0.1)
    return place
