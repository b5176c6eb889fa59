"""Direction of rotation, swapped probes, angles in names, and runout from the command line."""

import json

import numpy as np
import pytest
import xarray as xr

from rotor_ida import centre_line, orders, read_signals, subtract_runout, whirl_ratio
from rotor_ida.cli.commands.plot import as_read
from rotor_ida.cli.program import main
from rotor_ida.errors import InputError

# A clockwise rotor as its probes see it, 45 degrees right and left of vertical: X leads Y
TIMES = np.arange(4000) / 2000.0
ANGLES = 2.0 * np.pi * (10.0 * TIMES + 5.0 * TIMES**2)
SPEEDS = 2.0 * np.pi * (10.0 + 10.0 * TIMES)
NAMES = "Zeit [s];Probe A 45R (um);Probe B 45L (um);Drehzahlimpuls"


def readings(z, angles=(45.0, 135.0)):
    return [(z * np.exp(-1j * np.radians(each))).real for each in angles]


def written(path, z, names=NAMES):
    pulse = (ANGLES + 1e-9) % (2.0 * np.pi) < 0.5
    table = np.stack([TIMES, *readings(z), pulse], axis=1)
    np.savetxt(path, table, "%.6f", ";", header=names, comments="")
    return path


@pytest.fixture
def clockwise(tmp_path):
    """It whirls with 30 um, and sags by 20 um."""
    return written(tmp_path / "clockwise.csv", 30.0 * np.exp(-1j * ANGLES) - 20j)


def test_usual_names_tell_columns_and_angles(tmp_path):
    found = read_signals(written(tmp_path / "a.csv", 30.0 * np.exp(1j * ANGLES)))
    assert found.attrs["columns"] == (
        "t=Zeit x=Probe A 45R y=Probe B 45L keyphasor=Drehzahlimpuls (guessed: t x y keyphasor)"
    )
    assert found.attrs["probe_angles"].tolist() == [45.0, 135.0]
    assert "probes are taken to be at 45 and 135 degrees, by their names" in found.attrs["notes"]
    np.testing.assert_allclose(orders(found).forward_whirl_amplitude, 30.0, rtol=0.02)


def test_backward_1x_in_all_windows_is_asked_about(clockwise):
    assert "1X whirls backward in all of" in read_signals(clockwise).attrs["notes"]
    assert "are the probes swapped" in read_signals(clockwise).attrs["notes"]


def test_a_backward_whirl_beside_a_forward_1x_is_no_slip(tmp_path):
    """Dry whip: all windows whirl backward, but the unbalance still drives 1X forward."""
    z = 5.0 * np.exp(1j * ANGLES) + 60.0 * np.exp(-2j * np.pi * 130.0 * TIMES)
    found = read_signals(written(tmp_path / "whip.csv", z))
    assert (whirl_ratio(found, revolutions=2).whirl_sense == -1).all()
    assert "1X" not in found.attrs["notes"]


def test_a_machine_that_turns_clockwise_is_shown_from_its_other_end(clockwise):
    found = read_signals(clockwise, rotation="clockwise")
    assert "1X" not in found.attrs["notes"]
    assert found.attrs["probe_angles"].tolist() == [135.0, 45.0]
    tracked = orders(found)
    np.testing.assert_allclose(tracked.forward_whirl_amplitude, 30.0, rtol=0.02)
    # right is left from there, and down stays down
    np.testing.assert_allclose(centre_line(found).offset_y, -20.0, atol=1.0)


def test_options_of_runout_that_contradict_are_refused(clockwise, capsys):
    words = ["plot", str(clockwise), "--kind", "bode"]
    assert main([*words, "--runout-orders", "2"]) == 2
    assert "--runout-orders must be given with --slow-roll" in capsys.readouterr().err
    assert main([*words, "--slow-roll", "0", "1", "--slow-roll-file", str(clockwise)]) == 2
    assert "--slow-roll must be left out with --slow-roll-file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (("0", "300"), "--slow-roll must lie within 0 to"),
        (("-2", "0.3"), "--slow-roll must lie within 0 to"),
        (("1.7", "1.95"), "--slow-roll must be a part in which the rotor turns slowly, but"),
    ],
)
def test_a_slow_roll_lies_in_the_record_and_is_slow(tmp_path, capsys, times, message):
    path = written(tmp_path / "bent.csv", 8j * np.exp(1j * ANGLES))
    assert main(["plot", str(path), "--kind", "bode", "--slow-roll", *times]) == 2
    assert message in capsys.readouterr().err


def test_a_plot_of_results_is_not_offered_for_a_measured_file(clockwise, capsys):
    assert main(["plot", str(clockwise), "--kind", "history"]) == 2
    assert "'trace' for a measured file, got 'history'" in capsys.readouterr().err


def test_the_command_line_names_the_option_for_columns(tmp_path, capsys):
    path = written(tmp_path / "odd.csv", 1.0 + 0 * ANGLES, "t [s];left;right;tacho")
    assert main(["plot", str(path)]) == 2
    message = capsys.readouterr().err
    assert "'t, left, right, tacho' (--columns x=NAME y=NAME)" in message
    named = ["--columns", "x=left", "y=right", "--figure", str(tmp_path / "a"), "--json"]
    assert main(["plot", str(path), *named]) == 0
    assert "x=left y=right" in json.loads(capsys.readouterr().out)["columns"]


def test_a_slow_roll_is_read_with_the_file_as_by_hand(tmp_path):
    part = (SPEEDS / (2.0 * np.pi * 60.0)) ** 2
    whirl = 20.0 * part / (1.0 - part + 0.2j) * np.exp(1j * ANGLES)
    path = written(tmp_path / "bent.csv", whirl + 8j * np.exp(1j * ANGLES))
    whole = read_signals(path)
    both = read_signals(path, slow_roll=(0.0, 0.3)), read_signals(path, slow_roll=path)
    words = read_signals(path, slow_roll=("0 s", "300 ms"))
    np.testing.assert_array_equal(words.x, both[0].x)
    with pytest.raises(InputError, match=r"slow_roll must be two times such as .* got"):
        read_signals(path, slow_roll=("0 s", "300 um"))
    for found, slow in zip(both, (whole.sel(t=slice(0.0, 0.3)), whole), strict=True):
        xr.testing.assert_allclose(found, subtract_runout(whole, slow), rtol=1e-9)
    bode = ["plot", str(path), "--kind", "bode", "--figure"]
    assert main([*bode, str(tmp_path / "a"), "--slow-roll", "0", "0.3s"]) == 0
    of_file = ["--slow-roll-file", str(path), "--runout-orders", "2"]
    assert main([*bode, str(tmp_path / "b"), *of_file]) == 0
    given = {"slow_roll_file": path, "runout_orders": 2}
    assert as_read(given) == {"slow_roll": path, "runout_orders": 2}


@pytest.mark.parametrize("gap", ["9.8V -10V", "1270um"])
def test_a_gap_of_the_other_sign_than_the_readings_is_refused(tmp_path, capsys, gap):
    path = tmp_path / "coupled.csv"
    readings = -10.0 + 0.2 * np.array([np.cos(ANGLES), np.sin(ANGLES)])
    table = np.column_stack([TIMES, *readings, ANGLES])
    np.savetxt(path, table, "%.9g", ",", header="t [s],x [V],y [V],angle [rad]", comments="")
    words = ["plot", str(path), "--sensitivity", "7.87V/mm", "--figure", str(tmp_path / "a")]
    assert main([*words, *(f"--gap={each}" for each in gap.split())]) == 2
    assert "gap must have the sign of the readings, which are all negative at x, got" in (
        capsys.readouterr().err
    )
    assert main([*words, *(f"--gap=-{each.lstrip('-')}" for each in gap.split())]) == 0


def test_show_names_the_commands_for_measured_files(clockwise, capsys):
    assert main(["show", str(clockwise)]) == 2
    assert "rotor-ida plot draws measured files" in capsys.readouterr().err


def test_explore_takes_the_options_of_reading_and_only_for_a_measurement(clockwise, monkeypatch):
    from rotor_ida.cli.commands import explore
    from rotor_ida.explorer.measured import show_measured
    from rotor_ida.explorer.messages import Upload

    given = []
    monkeypatch.setattr(explore, "_serve", lambda *words: given.append(words))
    assert main(["explore", str(clockwise), "--rotation", "clockwise", "--length", "mil"]) == 0
    reading = given[0][-1]
    assert reading == {"rotation": "clockwise", "length": "mil"}
    upload = Upload(
        about="upload", number=1, name=clockwise.name, size=0, path=clockwise, reading=reading
    )
    (answer,) = show_measured(upload)
    assert answer.facts["length"] == "mil"
    assert main(["explore", "--rotation", "clockwise"]) == 2
