"""Time the explorer in headless Chromium: from moving a slider to the picture on the screen.

Steps of one slider, each after the page has come to rest, and a drag in quick steps, at the
parameters of the figures; and the first picture of the basin after a step. It needs Chromium with
its driver.

    python benchmarks/explorer.py --steps 60
    python benchmarks/explorer.py --steps 60 --machine
    python benchmarks/explorer.py --steps 60 --machine --friction
    python benchmarks/explorer.py --steps 60 --panels

With --panels those of signals are open, and a run-up is timed from piece to piece beside one
without them.
"""

import argparse
import shutil
import statistics
import subprocess
import sys
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

# Parameters of the figures: omega, zeta, delta0.
ROTORS = ((1.7, 0.07, 0.0), (1.2, 0.07, 0.5), (1.7, 0.07, 0.5), (1.7, 0.07, 1.0), (2.0, 0.07, 2.0))
# What a machine has beside them; its clearance must not be 0.
MACHINE = {"shaft_stiffness": 0.25, "contact_exponent": 1, "contact_damping": 0.5}
# With friction there is a slider more.
RUB = {"friction": 0.1, "disc_radius": 10}
PANELS = "bode,polar,full,cascade"
# How long each change of the speed in a run-up takes, in milliseconds, from one to the next.
PASS = """
const [panels, way, done] = arguments;
for (const box of document.querySelectorAll('[name="signals"]')) {
  if (box.checked !== panels) box.click();
}
const { moved } = rotorIda.passage, took = [];
rotorIda.passage.moved = (speed) => {
  const began = performance.now();
  moved(speed);
  took.push(performance.now() - began);
};
document.getElementById(way).click();
setTimeout(() => {
  document.getElementById(way).click();
  rotorIda.passage.moved = moved;
  setTimeout(() => done(took), 2000);
}, 8000);
"""
REST, QUICK = 400, 50  # milliseconds from step to step
# Of how much each slider is moved in all.
SPANS = {"omega": 0.2, "zeta": 0.05, "delta0": 0.3, "friction": 0.1}
MOVE = """
const [name, from, to, count, gap, done] = arguments;
const slider = document.getElementById(`slider-${name}`);
const basins = [];
let moved = 0, asked = 0, i = 0;
rotorIda.delays.length = 0;
const watch = setInterval(() => {
  if (asked && rotorIda.drawnBasin === asked) {
    basins.push(performance.now() - moved);
    asked = 0;
  }
}, 5);
const timer = setInterval(() => {
  if (i === count) {
    clearInterval(timer);
    clearInterval(watch);
    done([[...rotorIda.delays], basins]);
    return;
  }
  slider.value = from + ((to - from) * ++i) / count;
  moved = performance.now();
  slider.dispatchEvent(new Event("input"));
  asked = rotorIda.asked;
}, gap);
"""


def served():
    """Start the explorer; return its process, its address, and the seconds it took."""
    began = time.perf_counter()
    program = "import sys; from rotor_ida.cli import main; sys.exit(main())"
    process = subprocess.Popen(
        [sys.executable, "-c", program, "explore", "--no-browser", "--port", "0"],
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for line in process.stderr:
        if "http://" in line:
            return process, line.split()[-1], time.perf_counter() - began
    raise SystemExit(f"the explorer ended with {process.wait()}")


def chromium():
    """Return a headless browser."""
    options = Options()
    options.binary_location = shutil.which("chromium") or shutil.which("chromium-browser") or ""
    for word in ("headless=new", "no-sandbox", "disable-gpu", "window-size=1400,1000"):
        options.add_argument(f"--{word}")
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    driver.set_script_timeout(300)
    return driver


def told(name, times):
    """Print median and 95th percentile of some times in milliseconds."""
    if times:
        ordered = sorted(times)
        high = ordered[min(int(0.95 * len(ordered)), len(ordered) - 1)]
        middle = statistics.median(ordered)
        print(
            f"{name:46s} {len(times):4d} times: median {middle:5.0f}, 95 % {high:5.0f} ms",
            flush=True,
        )


def main():
    """Time steps and drags of all sliders."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--machine", action="store_true")
    parser.add_argument("--friction", action="store_true")
    parser.add_argument("--panels", action="store_true")
    given = parser.parse_args()
    steps = given.steps
    beyond = (MACHINE if given.machine else {}) | (RUB if given.friction else {})
    process, address, seconds = served()
    driver = chromium()
    try:
        shown = beyond | ({"panels": PANELS} if given.panels else {})
        driver.get(address + "".join(f"&{name}={value}" for name, value in shown.items()))
        time.sleep(5.0)
        first = driver.execute_script("return rotorIda.delays[0]")
        print(
            f"ready after {seconds:.1f} s, first picture {first:.0f} ms after the page was opened"
        )
        everything = {"steps": [], "drags": [], "basins": []}
        for rotor in [each for each in ROTORS if each[2] > 0.0 or not beyond]:
            moved = dict(zip(("omega", "zeta", "delta0"), rotor, strict=True))
            for name, value in moved.items():
                driver.execute_script(
                    "const field = document.getElementById(`field-${arguments[0]}`);"
                    "field.value = arguments[1]; field.dispatchEvent(new Event('input'));",
                    name, value,
                )  # fmt: skip
            time.sleep(3.0)
            if given.friction:
                moved["friction"] = RUB["friction"]
            for name, value in moved.items():
                ends = (name, value, value + SPANS[name], steps)
                delays, basins = driver.execute_async_script(MOVE, *ends, REST)
                drags, _ = driver.execute_async_script(MOVE, *ends, QUICK)
                told(f"{rotor} steps of {name}", delays)
                told(f"{rotor} drag of {name}", drags)
                everything["steps"] += delays
                everything["drags"] += drags
                everything["basins"] += basins
        ways = ((False, "run-up"), (True, "run-down")) if given.panels else ()
        for panels, way in ways:
            took = driver.execute_async_script(PASS, panels, way)
            told(f"drawing a piece of a run-up, {'all' if panels else 'no'} panels", took)
        told("all steps", everything["steps"])
        told("all drags", everything["drags"])
        told("first picture of the basin", everything["basins"])
    finally:
        driver.quit()
        process.terminate()
        process.communicate()


if __name__ == "__main__":
    main()
