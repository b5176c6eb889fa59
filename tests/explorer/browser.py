"""The explorer in a browser, as a person sees it and as the page's own record tells it."""

from __future__ import annotations

import base64
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from urllib.parse import parse_qs, urlencode

import numpy as np
import pytest
from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

PROGRAMS = {
    "chromium": shutil.which("chromium") or shutil.which("chromium-browser"),
    "chromedriver": shutil.which("chromedriver"),
}
MISSING = [name for name, path in PROGRAMS.items() if path is None]
# The module itself must be importable without them: others share its constants.
needs_browser = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}")

# Width and height of the window: what lies beyond it, no pointer reaches.
WINDOW = (1400, 1000)
# Seconds, on a machine that does other things too; selenium itself gives up after 120.
PATIENCE = 110.0
PIXELS = """
const seen = Array.from(document.querySelectorAll("canvas")).filter((each) => each.offsetParent);
return seen.map((canvas) => {
  const context = canvas.getContext("2d");
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  let sum = 0, painted = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i + 3]) {
    painted += 1;
    sum = (31 * sum + data[i] + 7 * data[i + 1] + i) % 1000003;
  }
  return painted > 500 ? sum : 0;
})"""

# The page itself looks again and again: looks from here would pass through three processes each.
WAIT = """
const given = Array.from(arguments), done = given.pop();
const asked = function () { return %s; };
const look = () => {
  try {
    const found = asked(...given);
    if (found) done({ found }); else setTimeout(look, 20);
  } catch (error) { done({ error: String(error) }); }
};
look();"""


def served(*words):
    """Start the explorer; return its process and its address."""
    command = [sys.executable, "-c", "import sys; from rotor_ida.cli import main; sys.exit(main())"]
    process = subprocess.Popen(
        [*command, "explore", "--no-browser", "--port", "0", *words],
        stderr=subprocess.PIPE,
        text=True,
    )
    for line in process.stderr:
        if "http://" in line:
            return process, line.split()[-1]
    raise AssertionError(f"the explorer ended with {process.wait()}")


def ended(process):
    """End the explorer, if it has not ended yet."""
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=PATIENCE)


def chromium_in(folder):
    """Return a headless browser that keeps what it downloads in a folder."""
    options = Options()
    options.binary_location = PROGRAMS["chromium"]
    size = f"window-size={WINDOW[0]},{WINDOW[1]}"
    # one process draws all pages: a new one for each would take a third of their time
    one = ("renderer-process-limit=1", "disable-site-isolation-trials")
    for word in ("headless=new", "no-sandbox", "disable-gpu", "disable-dev-shm-usage", size, *one):
        options.add_argument(f"--{word}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(PROGRAMS["chromedriver"]))
    driver.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(folder)}
    )
    driver.folder, driver.added = folder, None
    driver.set_script_timeout(PATIENCE)
    return driver


# Whether nothing lies beyond a width; plots follow that of the window only after a while.
FITS = "innerWidth === arguments[0] && document.documentElement.scrollWidth <= arguments[0]"


@contextmanager
def sized(driver, width, height=900):
    """Show the page in a window of a size, narrow ones as on a phone."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        yield
    finally:
        driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def downloaded(place):
    """Return a file once the browser has it whole."""
    deadline = time.monotonic() + 5 * PATIENCE
    while not place.exists():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return place


def errors_of(driver):
    log = driver.get_log("browser")
    return [entry["message"] for entry in log if entry["level"] == "SEVERE"]


def copied(page, button, said):
    """Press a button that copies something; return that, once the page has said so."""
    allowed = {
        "permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"],
        "origin": page.run("return location.origin"),
    }
    page.driver.execute_cdp_cmd("Browser.grantPermissions", allowed)
    page.find(button).click()
    page.until("document.getElementById('connection').textContent === arguments[0]", said)
    return page.driver.execute_async_script(
        "navigator.clipboard.readText().then(arguments[arguments.length - 1])"
    )


DROP = """
const carried = new DataTransfer();
for (const [contents, name] of arguments[0]) {
  const bytes = Uint8Array.from(atob(contents), (character) => character.charCodeAt(0));
  carried.items.add(new File([bytes], name));
}
const told = {dataTransfer: carried, bubbles: true, cancelable: true};
document.body.dispatchEvent(new DragEvent("drop", told));"""


def drop_all(page, files):
    """Drop files on the page, and wait until it has said what comes of them."""
    page.run(DROP, [(base64.b64encode(held).decode(), name) for name, held in files.items()])
    page.until("!rotorIda.measured.reading")
    return page.find("#measured-said").text


# Before the page's own scripts run; a basin takes longer than all else, and few look at it.
NO_BASIN = """
document.addEventListener("readystatechange", () => {
  for (const each of document.querySelectorAll("template")) {
    each.content.querySelector("[data-basin]")?.removeAttribute("checked");
  }
});"""
# As if the browser went back to an address, which it does only where this differs.
PUT_BACK = """
const { asked } = rotorIda;
for (const each of document.querySelectorAll("[data-basin]")) each.checked = arguments[1];
for (const each of document.querySelectorAll("template")) {
  each.content.querySelector("[data-basin]")?.toggleAttribute("checked", arguments[1]);
}
document.activeElement.blur();
for (const each of document.querySelectorAll("details")) each.open = false;
scrollTo(0, 0);
location.hash = `${arguments[0]}&after=${asked}`;
return asked;"""


class Page:
    """The page as a person sees it, and as its own record tells it."""

    def __init__(self, driver, address, more="", *, anew=True, basin=False):
        """Load the page; or put one that is there into the state of an address, if not `anew`.

        Only with `basin` it asks for the basin, as it does for a person.
        """
        self.driver = driver
        place, _, state = address.partition("#")
        if anew or driver.current_url.partition("#")[0] != place:
            self._load(address + more, basin)
        else:
            asked = self.run(PUT_BACK, f"{state}{more}", basin)
            self.until("rotorIda.asked > arguments[0]", asked)
        self.settle()

    def _load(self, address, basin):
        driver, command = self.driver, "Page.{}ScriptToEvaluateOnNewDocument"
        if basin and driver.added:
            driver.execute_cdp_cmd(command.format("remove"), driver.added)
            driver.added = None
        elif not basin and not driver.added:
            driver.added = driver.execute_cdp_cmd(command.format("add"), {"source": NO_BASIN})
        driver.get("about:blank")
        driver.get(address)

    def run(self, script, *given):
        return self.driver.execute_script(script, *given)

    def until(self, script, *given):
        """Wait until a script returns something true, and return that."""
        try:
            answer = self.driver.execute_async_script(WAIT % script, *given)
        except TimeoutException as late:
            raise AssertionError(f"never: {script}") from late
        assert "error" not in answer, f"{answer}: {script}"
        return answer["found"]

    def settle(self, *parts, side=0):
        """Wait until the newest question has been answered in full, and all of it is drawn."""
        for part in ("motion", "curve", *parts):
            self.until(
                "window.rotorIda && rotorIda.asked > 0 && rotorIda.shown[arguments[0]]"
                "[arguments[1]]?.number === rotorIda.asked && rotorIda.drawn === rotorIda.asked",
                side, part,
            )  # fmt: skip
        self.until("rotorIda.hasAllDrawn()")

    def array(self, part, name, side=0):
        found = self.run(
            "return Array.from(rotorIda.shown[arguments[0]][arguments[1]].arrays[arguments[2]], "
            "(each) => Number.isNaN(each) ? null : each)", side, part, name
        )  # fmt: skip
        return np.array([np.nan if each is None else each for each in found], dtype=float)

    def facts(self, part, side=0):
        return self.run("return rotorIda.shown[arguments[0]][arguments[1]].facts", side, part)

    def state(self):
        return self.run("return {...rotorIda.state}")

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def pointer_on(self, element, across=0, down=0):
        """Return a chain of actions whose pointer is so far from the middle of an element.

        The element is brought to the middle of the window first: a pointer that is to leave the
        window is refused, and so would be a drag from an element at its edge.
        """
        self.run("arguments[0].scrollIntoView({block: 'center', inline: 'center'})", element)
        chain = ActionChains(self.driver)
        return chain.move_to_element_with_offset(element, round(across), round(down))

    def type(self, selector, value):
        field = self.find(selector)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(str(value), Keys.TAB)

    def words(self):
        return self.find("#words").text

    def pictures(self):
        """Return for each canvas that is seen a number that its pixels give."""
        return self.run(PIXELS)

    def pictures_at_rest(self):
        """Return the pictures once they no longer change: basin and branch come bit by bit."""
        end, before = time.monotonic() + PATIENCE, self.pictures()
        while time.monotonic() < end:
            time.sleep(1.0)
            after = self.pictures()
            if after == before:
                return after
            before = after
        raise AssertionError("the pictures never rest")


def with_machine(page, address, **given):
    """Open the page with what a machine has beside the paper's rotor."""
    more = "".join(f"&{name}={value}" for name, value in given.items())
    return Page(page.driver, address, more, anew=False)


def opened(driver, address, *, basin=False, **state):
    """Open the page with another rotor than the one that it begins with."""
    place, _, first = address.partition("#")
    told = {**state, "key": parse_qs(first)["key"][0]}
    return Page(driver, f"{place}#{urlencode(told)}", anew=False, basin=basin)


def hovered(page, panel, value):
    """Move the pointer to values in a plot; return what the readout says.

    The plot may be drawn anew, or the page move under the pointer, until the cursor is there.
    """
    place = """
        const over = document.querySelector(arguments[0] + " .u-over");
        const plot = rotorIda.plotOf(over), {left, top} = plot.cursor;
        const x = plot.valToPos(arguments[1][0], "x"), y = plot.valToPos(arguments[1][1], "y");
        const box = over.getBoundingClientRect();"""
    offset = "return [x - box.width / 2, y - box.height / 2]"
    read = """
        const readout = document.querySelector(arguments[0] + " .readout");
        return Math.hypot(left - x, top - y) < 3 ? readout.textContent : null"""
    over = page.find(f"{panel} .u-over")
    for _ in range(50):
        page.pointer_on(over, *page.run(place + offset, panel, value)).perform()
        if (text := page.run(place + read, panel, value)) is not None:
            return text
        page.pointer_on(over).perform()
    raise AssertionError(f"the cursor never came to {value} of {panel}")


def number_after(name, text):
    return float(text.partition(f"{name} ")[2].split(",")[0].split()[0])


# Pixels of a plot that have a colour of the style sheet.
COLOURED = r"""
const canvas = document.querySelector(`[data-panel="${arguments[0]}"] canvas`);
const probe = document.createElement("span");
probe.style.color = `var(--${arguments[1]})`;
document.body.append(probe);
const [red, green, blue] = getComputedStyle(probe).color.match(/\d+/g).map(Number);
probe.remove();
const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
let count = 0;
for (let i = 0; i < data.length; i += 4) {
  count += data[i + 3] > 250 && data[i] === red && data[i + 1] === green && data[i + 2] === blue;
}
return count;"""
