"""Panels of signals in a browser: as the library has them, also of a measured file."""

from __future__ import annotations

import numpy as np
import pytest
from selenium.webdriver import Keys

from rotor_ida import Rotor, run_up
from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import LARGEST_FILE
from rotor_ida.signals.reading import read_signals
from tests.explorer.browser import FITS, Page, drop_all, errors_of, needs_browser, opened, sized
from tests.explorer.test_measured import analysed
from tests.signals.test_files import write_comtrade

# On a machine that does other things as well.
pytestmark = [needs_browser, pytest.mark.timeout(1500)]
START = {"omega": 2.4, "zeta": 0.07, "delta0": 2, "x": 2.6, "y": 0.75, "vx": 0.66, "vy": -1.65}
ALL = "bode,polar,full,cascade"
LARGE = """
const file = new File([], "large.csv");
Object.defineProperty(file, "size", { value: arguments[0] });
rotorIda.measured.read(file);
return document.getElementById("measured-said").textContent"""
THIN = """
const done = arguments[0];
import("/plot.js").then(({ Pen }) => {
  const at = [];
  const keep = (...place) => at.push(place), none = () => {};
  const ctx = { beginPath: none, stroke: none, setLineDash: none, moveTo: keep, lineTo: keep };
  const pen = new Pen(ctx, (x) => x, (y) => y, 1, null);
  const xs = Float64Array.from({ length: 1e6 }, (_, i) => 1e-4 * i);
  const ys = xs.map((x, i) => (i === 123456 ? 50 : i === 654321 ? -40 : Math.sin(x)));
  pen.dense(xs, ys, { stroke: "black" });
  const heights = at.map(([, y]) => y);
  done([at.length, Math.max(...heights), Math.min(...heights), at.find(([, y]) => y === 50)[0]]);
});"""


EQUAL = """
const done = arguments[0];
import("/plot.js").then(async ({ Plot }) => {
  const style = "width: 330px; height: 280px";
  const box = Object.assign(document.createElement("div"), { style });
  document.body.append(box);
  let most = 0, count = 0;
  const plot = new Plot(box, { equal: true, x: "x", y: "y", draw: () => (count += 1) });
  for (let top = 1; top < 3000; top *= 1.1) {
    count = 0;
    plot.show({ x: [-top, 0.9 * top], y: [-0.9 * top, 0.2 * top] });
    await new Promise((resolve) => setTimeout(resolve, 0));
    most = Math.max(most, count);
  }
  box.remove();
  done(most);
});"""


@pytest.fixture
def page(chromium, address):
    """The page with all panels and nothing measured."""
    found = opened(chromium, address, **START, panels=ALL, ramp=0.01)
    yield found
    found.run("document.getElementById('measured-remove').click()")
    assert errors_of(chromium) == []


def drop(page, contents, name="probes.csv"):
    """Drop a file on the page, and wait until it has said what comes of it."""
    return drop_all(page, {name: contents if isinstance(contents, bytes) else contents.encode()})


def measured(page, place):
    """Return numbers of what is measured, as the page has them."""
    found = page.run(
        f"return rotorIda.measured.found.{place} && [...rotorIda.measured.found.{place}]"
    )
    return np.array(found, dtype=float)


def check_as_analysed(page, path, **chosen):
    """Check that the page has what the program finds in a file, number by number; return that."""
    arrays = analysed(path, **chosen).arrays
    for name in arrays:
        panel, _, quantity = name.partition("_")
        if panel in ("order", "full"):
            np.testing.assert_array_equal(measured(page, f"{panel}.{quantity}"), arrays[name])
    rows = arrays.get("cascade_speed", ())
    assert page.run("return rotorIda.measured.found.rows.length") == len(rows)
    for row in range(len(rows)):
        amplitudes = arrays["cascade_amplitude"].reshape(len(rows), -1)[row]
        np.testing.assert_array_equal(measured(page, f"rows[{row}].amplitude"), amplitudes)
    return arrays


def written(names, columns):
    rows = (",".join(repr(float(each)) for each in row) for row in zip(*columns, strict=True))
    return "\n".join([",".join(names), *rows]) + "\n"


def test_the_panels_show_a_run_up_and_only_what_is_drawn_is_in_the_key(page):
    page.find("#run-up").send_keys(Keys.SPACE)
    page.until("rotorIda.passage.tracks[0]?.rows.length >= 3")
    page.find("#run-up").send_keys(Keys.SPACE)
    page.until("!rotorIda.passage.running && !rotorIda.passage.waiting.size")
    page.settle("settled", "lines")
    shown = page.run("return rotorIda.passage.tracks[0].order.speed")
    assert 2.4 < shown[0] < shown[-1] < page.run("return rotorIda.passage.speed")
    # the lines that are drawn, and no other
    key = page.run(
        "return [...document.querySelectorAll('[data-panel=bode] .key span')]"
        ".map((each) => each.textContent)"
    )
    assert key[:-1] == ["exact whirl in contact", "contact-free whirl", "unstable", "fold"]
    # seven plots as ever, two of Bode, and one of each other panel
    assert sum(map(bool, page.pictures())) == 7 + 5
    page.find('[name="signals"][value="polar"]').send_keys(Keys.SPACE)
    page.until("location.hash.includes('panels=bode%2Cfull%2Ccascade')")
    assert sum(map(bool, page.pictures())) == 7 + 4


@pytest.mark.parametrize(
    ("width", "columns", "panels"),
    [(1400, 2, ALL), (1400, 2, "bode,polar,full"), (360, 1, ALL)],
)
def test_panels_fill_their_rows_and_nothing_is_cut_off(chromium, address, width, columns, panels):
    with sized(chromium, width):
        page = Page(chromium, address, f"&panels={panels}", anew=False)
        page.until(FITS, width)
        edges = page.run(
            "const {right} = document.getElementById('signal-panels').getBoundingClientRect();"
            "return [right, ...Array.from(document.querySelectorAll('#signal-panels .card'), "
            "(each) => each.getBoundingClientRect().right)]"
        )
    right, *cards = edges
    # each row ends at the right edge, also one with a single card
    ends = [*cards[columns - 1 :: columns], cards[-1]]
    assert ends == pytest.approx([right] * len(ends), abs=1.0)


def test_a_dropped_run_up_is_analysed_by_the_library(page, tmp_path):
    rotor = Rotor(omega=0.6, zeta=0.1, delta0=0.5)
    run = run_up(rotor, start=(0.3, 0, 0, 0), to=2.6, rate=0.02, samples=6001)
    text = written(("t", "x", "y", "angle"), (run.t, run.x, run.y, run.angle))
    said = drop(page, text)
    assert "6,001 samples, turned by angle, from speed" in said
    assert "It stays on the machine of the program." in said
    (tmp_path / "probes.csv").write_text(text)
    assert check_as_analysed(page, tmp_path / "probes.csv")["cascade_speed"].size > 5
    page.find("#measured-remove").send_keys(Keys.SPACE)
    assert page.run(
        "return [rotorIda.measured.found, document.getElementById('measured-form').hidden]"
    ) == [None, True]


def test_the_two_files_of_a_comtrade_record_are_read_together(page, tmp_path):
    write_comtrade(tmp_path / "pump.cfg", kind="BINARY")
    files = {each.name: each.read_bytes() for each in tmp_path.iterdir()}
    said = drop_all(page, files)
    assert said.startswith("pump.cff: 4,000 samples, turned by keyphasor")
    check_as_analysed(page, tmp_path / "pump.cfg")
    said = drop_all(page, {"a.csv": b"", "b.csv": b""})
    assert said.startswith("One file at a time, or the .cfg and the .dat of a COMTRADE record")
    said = drop(page, files["pump.cfg"], "pump.cfg")
    assert "'pump.cfg' must have the .dat of its COMTRADE record with it" in said
    assert "pump.cff stays" in said


def test_probes_at_45_and_135_degrees_with_gains_are_turned_as_by_the_library(page, tmp_path):
    t = np.arange(4000) / 2000.0
    turn = 2.0 * np.pi * 31.0 * t
    z = 12.0 * np.exp(1j * (turn - 0.7)) + 2.5 * np.exp(-1j * turn)
    readings = [
        gain * (z * np.exp(-1j * np.radians(angle))).real for angle, gain in ((45, 2), (135, 0.5))
    ]
    text = written(("t [s]", "x [um]", "y [um]", "angle"), (t, *readings, turn))
    drop(page, text)
    assert page.run("return [...document.querySelectorAll('#measured-form [id^=measured-angle], "
                    "#measured-form [id^=measured-gain]')].map((each) => each.valueAsNumber)"
                    ) == [0, 90, 1, 1]  # fmt: skip
    for place, value in {"gain-x": 2, "gain-y": 0.5, "angle-x": 45, "angle-y": 135}.items():
        page.type(f"#measured-{place}", value)
        page.until("!rotorIda.measured.reading")
    (tmp_path / "probes.csv").write_text(text)
    check_as_analysed(page, tmp_path / "probes.csv", probe_angles=(45.0, 135.0), gains=(2.0, 0.5))
    found = measured(page, "order.amplitude")
    assert found == pytest.approx(12.0, abs=1e-9)
    # the page is dimensionless: let its unit of length be 2 um and that of time 0.01 s
    page.type("#measured-scale", 2)
    page.type("#measured-period", 0.01)
    order = page.run("return rotorIda.measured.source(undefined, 2).order")
    assert order["amplitude"][5] == pytest.approx(0.5 * found[5])
    assert order["speed"][5] == pytest.approx(0.01 * measured(page, "order.speed")[5])
    page.type("#measured-angle-y", 225)
    page.until("!rotorIda.measured.reading")
    assert "do not point along one line" in page.find("#measured-said").text
    assert measured(page, "order.amplitude") == pytest.approx(12.0, abs=1e-9)  # it stays


CHOOSE = """const [id, value] = arguments, field = document.getElementById(id);
field.value = value;
field.dispatchEvent(new Event("change"));
return field.value"""


def test_columns_and_units_are_chosen_by_hand_where_names_do_not_tell(page, tmp_path):
    t = np.arange(4000) / 2000.0
    z = 0.05 * np.exp(1j * (2.0 * np.pi * 31.0 * t - 0.7))
    text = written(("when", "left", "right", "n"), (1e3 * t, z.real, z.imag, np.full(t.size, 31.0)))
    said = drop(page, text)
    assert (
        "must have a column for x and y; name them in columns, got 'when, left, right, n'" in said
    )
    assert page.run("return rotorIda.measured.found") is None
    fields = {
        "unit-t": "ms", "column-t": "when", "unit-length": "mm", "column-x": "left",
        "column-y": "right", "turn": "speed", "unit-turn": "Hz", "column-turn": "n",
    }  # fmt: skip
    for name, value in fields.items():
        assert page.run(CHOOSE, f"measured-{name}", value) == value
        page.until("!rotorIda.measured.reading")
    (tmp_path / "probes.csv").write_text(text)
    check_as_analysed(
        page, tmp_path / "probes.csv",
        columns={"t": "when", "x": "left", "y": "right", "speed": "n"},
        units={"t": "ms", "x": "mm", "y": "mm", "speed": "Hz"},
    )  # fmt: skip
    said = page.find("#measured-said").text
    assert "turned by speed" in said
    assert "phase lags have no known origin" in said
    assert page.run("return document.getElementById('measured-length').value") == "mm"
    # the choice is of this file: another one is guessed anew
    good = written(("time_s", "probe_A_um", "probe_B_um", "angle [rad]"), (t, *[t % 0.1] * 2, t))
    assert "4,000 samples, turned by angle" in drop(page, good, "good.csv")
    shown = "return ['t', 'x', 'y', 'turn'].map((each) => " \
        "document.getElementById(`measured-column-${each}`).value)"  # fmt: skip
    assert page.run(shown) == ["time_s", "probe_A_um", "probe_B_um", "angle"]
    page.find("#measured-remove").send_keys(Keys.SPACE)
    assert page.run("return document.getElementById('measured-columns').hidden")


def test_odd_files_are_told_of_in_one_line_and_nothing_is_lost(page, tmp_path):
    t = np.arange(400) / 100.0
    x, y, turn = np.cos(30 * t), np.sin(30 * t), 30 * t
    good = written(("t", "x", "y", "angle"), (t, x, y, turn))
    assert "400 samples" in drop(page, good, "good.csv")
    gap = np.where(t < 2.0, t, t + 1.0)
    odd = written(("t", "x", "y"), (gap, x, y))
    (tmp_path / "odd.csv").write_text(odd)
    with pytest.raises(InputError) as refused:
        read_signals(tmp_path / "odd.csv")
    why = str(refused.value).replace(str(tmp_path / "odd.csv"), "odd.csv")
    assert drop(page, odd, "odd.csv") == f"odd.csv is not shown: {why}. good.csv stays."
    larger = page.run(LARGE, LARGEST_FILE + 10**6)
    assert larger == "large.csv has 269.4 MB, and at most 268 MB can be read."
    assert page.run("return rotorIda.measured.found.name") == "good.csv"
    plain = written(("t", "x", "y"), (t, x, y))
    assert "neither speed nor phase is known" in drop(page, plain, "no_key.csv")
    assert page.run("return rotorIda.measured.source(undefined, 2).lines.over.length") > 0


def test_of_a_million_points_the_extremes_are_drawn_and_few_others(page):
    count, top, bottom, where = page.driver.execute_async_script(THIN)
    assert count < 4 * 110
    assert (top, bottom, where) == (50, -40, 12)


def test_axes_with_one_scale_come_to_rest_whatever_they_show(page):
    """The ranges decide the width of the tick labels, and this decides the ranges again."""
    assert page.driver.execute_async_script(EQUAL) < 10  # for what is shown, and for its first size
