"""Draw the pictures of the explorer's page: ``python docs/_extensions/explorer.py``.

They are taken in Chromium, by its driver, from a pump whose run-up ends in a rub, and from a rotor
with a disc and a seal.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

DOCS = Path(__file__).parents[1]
sys.path.insert(0, str(DOCS.parent))

from tests.explorer.browser import Page, chromium_in, ended, served  # noqa: E402
from tests.explorer.test_system_page import SystemPage  # noqa: E402

PUMP = {
    "mass": 12, "contact-stiffness": 1e8, "damping": 415.7, "eccentricity": 16.7e-6,
    "clearance": 150e-6, "speed": 376.99112, "shaft-stiffness": 4e6, "contact-exponent": 1,
    "friction": 0.12, "disc-radius": 0.06,
}  # fmt: skip
SYSTEM = """
speed = "5000 rpm"
contacts = [ { node = "seal", clearance = "150 um", stiffness = "5e7 N/m", friction = 0.1, radius = "50 mm" } ]
unbalance = [ { node = "disc", moment = "1200 g mm" } ]
[system]
mass = [12, 12, 8, 8]
damping = [[1600, 0, -800, 0], [0, 1600, 0, -800], [-800, 0, 1200, 0], [0, -800, 0, 1200]]
stiffness = [[8e6, 0, -4e6, 0], [0, 8e6, 0, -4e6], [-4e6, 0, 6e6, 0], [0, -4e6, 0, 6e6]]
nodes = { disc = [0, 1], seal = [2, 3] }
positions = { disc = 0.2, seal = 0.5 }
"""  # noqa: E501
WIDTH, HEIGHT = 1280, 1010
REST = 2.0  # seconds for what is drawn a moment later


def main() -> None:
    """Write the pictures of the page on the explorer."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "rotor.toml"
        file.write_text(SYSTEM)
        _draw_with(_draw_system, [str(file)], folder)
        _draw_with(_draw, [f"--{name}={value}" for name, value in PUMP.items()], folder)


def _draw_with(draw: Callable[[Any, str], None], words: list[str], folder: str) -> None:
    """Serve the explorer, and draw its page in a browser."""
    process, address = served(*words)
    try:
        driver = chromium_in(Path(folder))
        try:
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False,
            })  # fmt: skip
            draw(driver, address)
        finally:
            driver.quit()
    finally:
        ended(process)


def _draw_system(driver: Any, address: str) -> None:
    page = SystemPage(driver, address)
    _save(page, "explorer_system", None)


def _draw(driver: Any, address: str) -> None:
    page = Page(driver, address, basin=True)
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
