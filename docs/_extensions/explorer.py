"""Draw the pictures of the explorer's page: ``python docs/_extensions/explorer.py``.

They are taken in Chromium, by its driver, from a pump whose run-up ends in a rub.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

DOCS = Path(__file__).parents[1]
sys.path.insert(0, str(DOCS.parent))

from tests.explorer.browser import Page, chromium_in, ended, served  # noqa: E402

PUMP = {
    "mass": 12, "contact-stiffness": 1e8, "damping": 415.7, "eccentricity": 16.7e-6,
    "clearance": 150e-6, "speed": 376.99112, "shaft-stiffness": 4e6, "contact-exponent": 1,
    "friction": 0.12, "disc-radius": 0.06,
}  # fmt: skip
WIDTH, HEIGHT = 1280, 1010
REST = 2.0  # seconds for what is drawn a moment later


def main() -> None:
    """Write the three pictures of the page on the explorer."""
    words = [f"--{name}={value}" for name, value in PUMP.items()]
    process, address = served(*words)
    with TemporaryDirectory() as folder:
        driver = chromium_in(Path(folder))
        try:
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False,
            })  # fmt: skip
            _draw(driver, address)
        finally:
            driver.quit()
            ended(process)


def _draw(driver, address: str) -> None:  # type: ignore[no-untyped-def]
    page = Page(driver, address)
    page.settle("settled")
    page.until("rotorIda.shown[0].basin?.facts.finest")
    _save(page, "explorer", None)
    page = Page(driver, address, "&panels=bode,polar,full,cascade")
    page.settle("settled")
    page.run("document.getElementById('run-up-0').click()")
    page.until("rotorIda.passage.number > 3 && !rotorIda.passage.running")
    page.settle("settled")
    _save(page, "explorer_run_up", '[data-panel="response"]')
    page.run("document.getElementById('signals').scrollIntoView()")
    _save(page, "explorer_signals", "#signal-panels")


def _save(page: Page, name: str, panel: str | None) -> None:
    """Write what is seen of a panel, or of the window."""
    time.sleep(REST)
    if panel is None:
        picture = page.driver.get_screenshot_as_png()
    else:
        picture = page.find(panel).screenshot_as_png
    (DOCS / f"{name}.png").write_bytes(picture)


if __name__ == "__main__":
    main()
