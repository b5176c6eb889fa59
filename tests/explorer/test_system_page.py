"""The page of a rotor system in a browser: it is drawn, plays, and says what is wrong."""

from __future__ import annotations

from tests.explorer.browser import Page, chromium_in, ended, errors_of, served
from tests.explorer.test_systems import DISC

DROPPED = """
const files = new DataTransfer();
files.items.add(new File([arguments[0]], "bad.toml"));
dispatchEvent(new DragEvent("drop", { dataTransfer: files, cancelable: true }));
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
