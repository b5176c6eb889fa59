"""The page of a rotor system: its questions, and answers that are those of the library."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    DimensionalRotor,
    Rotor,
    drop,
    load,
    load_course,
    load_system,
    orders,
    run_up,
    save,
    save_machine,
    signals_of,
    simulate,
    special_speeds,
    sweep,
    synchronous_response,
)
from rotor_ida.cli import main
from rotor_ida.cli.describe import describe
from rotor_ida.errors import InputError
from rotor_ida.explorer import archives, cases, files, motion, responses, whirls
from rotor_ida.explorer.messages import Answer, Question, Upload, read_question
from rotor_ida.explorer.opening import show_upload, state_in
from rotor_ida.explorer.run_ups import show_track
from rotor_ida.model.data_sheet import implausible
from rotor_ida.results.sheets import sheets_shown
from rotor_ida.results.system_file import read_system_file
from tests.explorer.asking import OF_SYSTEM, Message, answer_to
from tests.explorer.asking import question as asking

DISC = """
speed = "2000 rpm"
system = { mass = [4, 4], stiffness = [1e5, 1e5], damping = [80, 80], nodes = { disc = [0, 1] } }
contacts = [ { node = "disc", clearance = "60 um", stiffness = "1e7 N/m" } ]
unbalance = [ { node = "disc", moment = "100 g mm" } ]
"""
DROP = """
speed = "4800 rpm"
system = { mass = [20, 20], stiffness = [0, 0], nodes = { disc = [0, 1] } }
supports = [ { node = "disc", stiffness = "2e6 N/m", damping = "2e3 N s/m" } ]
[[contacts]]
node = "disc"
clearance = "0.2 mm"
stiffness = "2e9 N/m^1.5"
friction = 0.1
radius = "30 mm"
[drop]
duration = "16 ms"
"""
RPM = np.pi / 30.0
# A disc by itself, and the same as a system.
DISC_ALONE = {
    "mass": 4.0, "contact_stiffness": 1e7, "damping": 80.0, "eccentricity": 25e-6,
    "clearance": 60e-6, "speed": 200.0, "shaft_stiffness": 1e5, "contact_exponent": 1.0,
}  # fmt: skip
ALONE = DISC.replace("2000 rpm", "200 rad/s")
SPEEDS_ALONE = [0.01, 3.0]
LENGTHS = ("x", "y", "radius", "event_x", "event_y", "rotating_x", "section_y")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    place = tmp_path / "disc.toml"
    place.write_text(DISC)
    return place


@pytest.fixture
def of_drop(tmp_path: Path) -> Path:
    place = tmp_path / "drop.toml"
    place.write_text(DROP)
    return place


def question(path: Path, about: str = "motion", **changes: object) -> Question:
    beside = {"about": about, "revolutions": changes.pop("revolutions", 10)}
    whole = {**OF_SYSTEM["machine"], **changes}  # type: ignore[dict-item]
    found = read_question(json.dumps(OF_SYSTEM | beside | {"machine": whole}))
    assert isinstance(found, Question)
    return replace(found, path=path)


def parts_of(asked: Question) -> dict[str, Answer]:
    shows = (motion.show_motion, responses.show_responses, whirls.show_campbell)
    return {each.part: each for show in shows for each in show(asked)}


def shown(asked: Any) -> dict[str, Message]:
    return {each.part: each for each in answer_to(asked)}


def run_of(asked: Question) -> Answer:
    return {each.part: each for each in motion.show_motion(asked)}["motion"]


def test_a_run_is_that_of_its_python_lines(path: Path) -> None:
    asked = question(path, changes={"clearance": 5e-5})
    lines = files.again_of(replace(asked, about="py")).replace("disc.toml", str(path))
    there: dict[str, Any] = {}
    exec(lines, there)
    np.testing.assert_array_equal(run_of(asked).arrays["x"], there["run"]["contact_x"][:, 0])


def test_the_command_is_in_the_units_of_the_page_and_gives_the_run_shown(path: Path) -> None:
    asked = question(path, speed=2345.6 * np.pi / 30.0, changes={"clearance": 4.7e-5})
    said, command = files.again_of(replace(asked, about="sh")).rstrip().splitlines()
    assert said == '# first, in disc.toml: set clearance = "47um" in contact 0'
    assert "--speed 2345.6rpm" in command
    path.write_text(DISC.replace("60 um", "47um"))
    archive = path.with_name("again.nc")
    words = command.split()[1:-2]
    words[1], words[-1] = str(path), str(archive)
    assert main(words) == 0
    again, shown = load(archive), cases.Node(asked).run()
    np.testing.assert_array_equal(again["event_time"], shown["event_time"])


def test_an_archive_is_played_as_it_is(path: Path, tmp_path: Path) -> None:
    system, course = read_system_file(path)
    run = simulate(system, **course.motion, speed=course.speed, duration=0.05)
    archive = tmp_path / "run.nc"
    save(run, archive)
    np.testing.assert_array_equal(
        run_of(question(archive)).arrays["force"], run["normal_force"].values.ravel()
    )


def test_an_archived_run_up_has_its_radius_over_the_speed_and_nothing_of_a_speed_that_is_held(
    path: Path,
) -> None:
    run = run_up(load_system(path), speed=20.0, to=250.0, rate=200.0)
    asked = question(archived(run, path))
    sketch, *_, archive = motion.show_motion(asked)
    sent = {each.part: each for each in motion.show_motion(asked)}
    assert "cascade" in sketch.facts["panels"]
    assert not {"section", "full"} & set(sketch.facts["panels"])
    arrays = sent["motion"].arrays
    assert arrays["section_x"].size == 0
    radius = np.hypot(run["contact_x"], run["contact_y"]).values.ravel()
    turn = np.floor(run["angle"].values / (2.0 * np.pi))
    for name, extreme in (("band_low", np.min), ("band_high", np.max)):
        each = [extreme(radius[turn == number]) for number in np.unique(turn)]
        np.testing.assert_array_equal(arrays[name], each)
    assert arrays["band_speed"][0] == 20.0
    assert str(sent["settled"].facts["verdict"]).startswith("The run-up touches contact 0 (disc)")
    (track,) = show_track(replace(asked, about="track"))
    exact = orders(signals_of(run, node="disc")).isel(order=0)
    np.testing.assert_array_equal(track.arrays["order_speed"], exact["speed"])
    assert archive.facts["sheets"] == told_of(run)


def test_an_archived_run_up_of_a_disc_is_shown_with_order_1_and_its_cascade(path: Path) -> None:
    run = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), to=2.5, rate=0.02)
    asked = question(archived(run, path))
    archive, track = motion.show_motion(asked)
    assert archive.facts["panels"] == ["archive", "bode", "polar", "cascade"]
    exact = orders(run).isel(order=0)
    np.testing.assert_array_equal(track.arrays["order_speed"], exact["speed"])
    assert track.arrays["cascade_speed"].size > 5
    assert "load('up.nc')" in files.again_of(replace(asked, about="py"))
    assert files.again_of(replace(asked, about="sh")).rstrip() == "rotor-ida show up.nc"
    with pytest.raises(InputError, match="html must be of a rotor or its run"):
        next(files.show_file(replace(asked, about="html")))


RESULTS: dict[str, Callable[[], xr.Dataset]] = {
    "sweep": lambda: sweep(omega=[0.5, 1.0], zeta=[0.07], delta0=[0.5]),
    "exact whirls": lambda: synchronous_response(Rotor(omega=1.7, zeta=0.07, delta0=0.5)),
}


@pytest.mark.parametrize("meaning", RESULTS)
def test_an_archive_of_another_result_is_shown_by_its_tables_and_its_figure(
    meaning: str, path: Path
) -> None:
    result = RESULTS[meaning]()
    (answer,) = motion.show_motion(question(archived(result, path)))
    assert (answer.facts["kind"], answer.facts["panels"]) == (meaning, ["archive"])
    assert answer.facts["sheets"] == told_of(result)
    picture = ElementTree.fromstring(answer.arrays["figure"].tobytes())
    assert picture.tag == "{http://www.w3.org/2000/svg}svg"


def archived(result: xr.Dataset, path: Path) -> Path:
    place = path.with_name("up.nc")
    save(result, place)
    return place


def told_of(result: xr.Dataset) -> list[dict[str, Any]]:
    """Return the sheets of the command line, without its word on how to see more."""
    sheets = sheets_shown(describe(result, most=archives.MOST_ROWS)[1])
    return json.loads(json.dumps(sheets).replace(" (all with --json)", ""))


def test_a_drop_is_that_of_its_file_and_its_archive_the_same(of_drop: Path) -> None:
    run = drop(load_system(of_drop), **load_course(of_drop).drop)
    archive = of_drop.with_suffix(".nc")
    save(run, archive)
    for path in (of_drop, archive):
        answer = run_of(question(path))
        np.testing.assert_array_equal(answer.arrays["y"], run["y"].values.ravel())
        np.testing.assert_array_equal(answer.arrays["peak_force"], run["peak_force"].values)
        assert answer.facts["is_whole"]
        with pytest.raises(InputError, match="a run-up must be left out"):
            next(show_track(question(path, "track")))
    assert files.again_of(replace(question(of_drop), about="sh")).startswith(
        "rotor-ida drop drop.toml --speed 4800rpm"
    )


@pytest.mark.parametrize(
    ("ending", "begin"),
    [
        ("nc", b""),
        ("html", b"<!doctype html>"),
    ],
)
def test_the_run_shown_is_written_to_a_file(path: Path, ending: str, begin: bytes) -> None:
    asked = question(path, ending)
    *_, answer = files.show_file(asked)
    contents = answer.arrays["contents"].tobytes()
    assert str(answer.facts["name"]).endswith(f".{ending}")
    assert contents.startswith(begin)
    if ending == "nc":
        again = path.with_suffix(".nc")
        again.write_bytes(contents)
        assert load(again).equals(cases.Node(asked).run())


def test_the_command_writes_the_page_of_a_system(
    path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    place = path.with_name("page.html")
    assert main(["explore", str(path), "--export", str(place)]) == 0
    recording = files.recording(question(path, "html", revolutions=60))
    assert place.read_text() == files.finished(recording)
    assert main(["explore", str(path), "--export", str(place), "--speeds", "1"]) == 2
    said = capfd.readouterr().err
    assert said.endswith("rotor-ida: speeds must be left out with a rotor system\n")


def test_a_file_without_a_run_up_has_one_over_the_speeds_shown(path: Path) -> None:
    (answer,) = show_track(question(path, "track"))
    system, course = read_system_file(path)
    speed = course.speed
    assert speed is not None
    up = run_up(system, **course.motion, speed=0.1 * speed, to=1.5 * speed,
                ramp_time=2.0 * np.pi * 300 / (0.8 * speed))  # fmt: skip
    left = up.exit_time.fillna(up.t[-1]).max()
    first, last = (np.interp(time, up.t, up.speed) / RPM for time in (up.entry_time.min(), left))
    assert str(answer.facts["words"]).rstrip() == (
        f"The run-up touches contact 0 (disc) between {first:,.0f} rpm and {last:,.0f} rpm."
    )
    assert answer.arrays["order_speed"].min() < speed < answer.arrays["order_speed"].max()


def test_what_the_exact_whirls_leave_out_is_told(path: Path, of_drop: Path) -> None:
    with_gravity = path.with_name("gravity.toml")
    with_gravity.write_text('gravity = ["0", "-9.81 m/s2"]\n' + DISC)
    told = [curve_of(question(each)).facts.get("why") for each in (path, with_gravity, of_drop)]
    assert told == [
        None, "Without gravity and static forces",
        "Without gravity and static forces; with the magnetic bearings, as before the drop",
    ]  # fmt: skip


def curve_of(asked: Question) -> Answer:
    return next(responses.show_responses(replace(asked, about="responses")))


def test_a_verdict_is_of_the_speed_held_and_a_sheet_has_the_special_speeds(path: Path) -> None:
    path.write_text('start = "settled"\n' + DISC)
    asked = question(path, speed=3000 * RPM)
    facts = parts_of(asked)["settled"].facts
    curve = curve_of(asked)
    np.testing.assert_allclose(curve.arrays["graze_amplitude"], 60e-6, rtol=1e-9)
    limits = [part * asked.speed for part in (cases.LOW, cases.HIGH)]
    points = special_speeds(load_system(path), limits=limits)
    (sheet,), (whole,) = curve.facts["sheets"], told_of(points)[:1]
    assert sheet["rows"][0] == ["speed [rpm]", "kind", "grazed contact"]
    assert sheet["rows"] == [[*row[:2], row[3]] for row in whole["rows"]]  # no threshold
    assert sum("graze" in row for row in sheet["rows"]) == 2
    assert (facts["level"], facts["verdict"]) == (
        "clear",
        "At 3,000 rpm the rotor runs clear of all contacts in the last 10 revolutions.",
    )


def test_with_weight_it_touches_where_sag_and_whirl_fill_the_clearance(path: Path) -> None:
    centred = DISC.replace('"1e7 N/m" }', '"1e7 N/m", centre = ["5 um", 0] }')
    path.write_text(f"gravity = [0, -0.5]\n{centred}")
    found = curve_of(question(path, speed=3000 * RPM)).arrays
    speeds = found["omega"]
    whirl = 1e-4 * speeds**2 / np.abs(1e5 - 4 * speeds**2 + 80j * speeds)
    touches = whirl + np.hypot(5e-6, 4 * 0.5 / 1e5) > 6e-5
    assert 0 < touches.sum() < touches.size
    assert found["amplitude"] == pytest.approx(np.where(touches, np.nan, whirl), nan_ok=True)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [('"1e7 N/m" }', '"1e7 N/m", centre = ["5 um", 0] }',
      "centre of contact 0 at 'disc' must be (0, 0) for a whirl, got (5e-06, 0.0);"),
     ("[1e5, 1e5]", "[1e5, 2e5]",
      "whose stiffness is not the same along x and y;")],
)  # fmt: skip
def test_where_whirls_are_not_known_the_page_says_why_and_shows_the_one_without_contact(
    path: Path, old: str, new: str, why: str
) -> None:
    path.write_text(DISC.replace(old, new))
    asked = question(path, speed=3000 * RPM)
    answer = curve_of(asked)
    assert str(answer.facts["why"]).startswith("Without whirls in contact: ")
    assert why in str(answer.facts["why"])
    amplitude, speed = answer.arrays["amplitude"], answer.arrays["omega"]
    shown = np.isfinite(amplitude)
    np.testing.assert_array_equal(answer.arrays["piece"] >= 0, shown)
    assert 0 < shown.sum() < shown.size
    stiff = np.array([1e5, 2e5 if "[1e5, 2e5]" in new else 1e5])
    exact = 1e-4 * speed[shown, np.newaxis] ** 2 / (
        stiff - 4 * speed[shown, np.newaxis] ** 2 + 80j * speed[shown, np.newaxis]
    )  # fmt: skip
    # of the ellipse of x = Re(a e^(i t)), y = Re(-i b e^(i t))
    largest = 0.5 * (np.abs(exact.sum(axis=1)) + np.abs(exact[:, 0] - exact[:, 1]))
    assert amplitude[shown] == pytest.approx(largest, rel=1e-9)


def test_the_whirls_of_a_drop_are_those_on_its_magnetic_bearings(of_drop: Path) -> None:
    """sqrt(k/m) with a damping ratio, of the file and its archive, and the whirl at its speed."""
    archive = of_drop.with_suffix(".nc")
    save(drop(load_system(of_drop), **load_course(of_drop).drop), archive)
    weighed = of_drop.with_name("weighed.toml")
    weighed.write_text('gravity = ["0", "-9.81 m/s2"]\n' + DROP.split("[drop]", maxsplit=1)[0])
    natural, ratio = np.sqrt(2e6 / 20.0), 2e3 / (2.0 * np.sqrt(2e6 * 20.0))
    damped = natural * np.sqrt(1.0 - ratio**2)
    for each in (of_drop, archive, weighed):
        sent = parts_of(question(each))
        rates = np.abs(sent["campbell"].arrays["whirl_speed"])
        np.testing.assert_allclose(rates[np.isfinite(rates)], damped, rtol=1e-9)
        assert np.isfinite(sent["curve"].arrays["amplitude"]).any()


def test_a_disc_is_shown_as_a_system_as_by_itself(tmp_path: Path) -> None:
    """The panels of one kernel have the numbers of the other: motion, curve, verdict and lines."""
    machine = DimensionalRotor(**DISC_ALONE)
    path = tmp_path / "alone.toml"
    path.write_text(ALONE)
    alone = shown(asking("motion", machine=DISC_ALONE, speeds=SPEEDS_ALONE, revolutions=20))
    alone |= shown(asking("responses", machine=DISC_ALONE, speeds=SPEEDS_ALONE, revolutions=20))
    of_system = parts_of(question(path, revolutions=20))
    one, other = alone["motion"], of_system["motion"]
    scales = dict.fromkeys(LENGTHS, machine.length_scale) | {
        "t": machine.time_scale, "event_time": machine.time_scale, "force": machine.force_scale,
        "peak_force": machine.force_scale, "exit_time": machine.time_scale,
    }  # fmt: skip
    for name, scale in scales.items():
        given = one.arrays[name] * scale
        largest = np.nanmax(np.abs(given))
        np.testing.assert_allclose(other.arrays[name], given, rtol=0.0, atol=1e-7 * largest,
                                   err_msg=name)  # fmt: skip
    assert other.facts["sheets"][0] == one.facts["sheets"][0]
    rows, same = (each.facts["sheets"][1]["rows"][:3] for each in (one, other))
    assert rows == same  # the errors of the event times differ
    curves = [each["curve"].arrays for each in (alone, of_system)]
    low, high = 0.1 * machine.speed, 1.5 * machine.speed
    # a piece is one whirl from speed to speed, without a jump to another one
    piece, omega, amplitude = (curves[1][name] for name in ("piece", "omega", "amplitude"))
    goes_on = (piece[1:] == piece[:-1]) & (piece[1:] >= 0)
    assert goes_on.sum() >= omega.max() / np.diff(omega).max() - 20
    assert np.unique(piece[piece >= 0]).size < 10
    assert np.diff(omega)[goes_on].min() > 0.0
    assert np.abs(np.diff(amplitude)[goes_on]).max() < 0.2 * np.nanmax(amplitude)
    folds = [np.sort(arrays["fold_omega"]) for arrays in curves]
    folds[0] *= machine.reference_frequency
    folds[0] = folds[0][(low < folds[0]) & (folds[0] < high)]
    np.testing.assert_allclose(folds[1], folds[0], rtol=1e-6)


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"node": "seal"}, "node must be one of disc, got 'seal'"),
     ({"contact": 3, "changes": {"clearance": 1e-4}}, "contact must be below 1, got 3"),
     ({"speed": 0.0}, "speed must be positive, got 0.0")],
)  # fmt: skip
def test_what_a_system_does_not_have_is_refused(
    path: Path, changes: dict[str, object], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        run_of(question(path, **changes))


def test_a_bad_file_is_told_by_its_name_alone(path: Path) -> None:
    path.write_text("speed = 3")
    with pytest.raises(InputError, match=r"^disc\.toml: system must be given"):
        run_of(question(path))


@pytest.mark.parametrize("text", ["speed = 3", "mass = 1.0", "no table"])
def test_a_bad_file_that_the_page_sends_has_the_name_that_it_has_there(
    path: Path, text: str
) -> None:
    path.write_text(text)
    with pytest.raises(InputError, match=r"pump \(1\)\.toml") as caught:
        list(show_upload(Upload(about="upload", number=1, name="pump (1).toml", size=9, path=path)))
    assert "disc.toml" not in str(caught.value)


def test_any_file_opens_as_what_it_is(path: Path, of_drop: Path) -> None:
    pump = path.with_name("pump.toml")
    machine = DimensionalRotor(**DISC_ALONE)
    save_machine(machine, pump)
    archives = [path.with_name(f"{name}.nc") for name in ("disc", "drop", "alone")]
    system = load_system(path)
    save(simulate(system, speed=200.0, duration=0.05), archives[0])
    save(drop(load_system(of_drop), **load_course(of_drop).drop), archives[1])
    save(simulate(machine, duration=0.05, start=(1e-5, 0.0, 0.0, 0.0)), archives[2])
    of_system = [state_in(each)[0] for each in (path, of_drop, *archives[:2])]
    assert of_system == [{"node": ""}] * 4
    (state, notes), (archived, _) = (state_in(each) for each in (pump, archives[2]))
    assert machine.given.items() <= state.items()
    assert notes == implausible(machine)
    assert (machine.given | {"y": 0.0}).items() <= archived.items()
    assert archived["x"] == pytest.approx(1e-5 / machine.length_scale)
