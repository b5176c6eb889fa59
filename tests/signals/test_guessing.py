"""Columns by their names: what is sure is taken, and what is not is refused with the names."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from rotor_ida import DimensionalRotor, InputError, fit, read_signals
from rotor_ida.plot import plot_bode, plot_orbit
from rotor_ida.signals.files.columns import Column, Table
from rotor_ida.signals.guessing import columns_of, name_of, unit_of

TIMES = np.arange(8000) / 2000.0
SPEED = 2.0 * math.pi * 10.0  # rad/s
Z = 30.0 * np.exp(1j * (SPEED * TIMES - 0.4))
A, B = (np.real(Z * np.exp(-1j * angle)) for angle in (math.pi / 4.0, -math.pi / 4.0))


def table_of(heads: str) -> Table:
    """Return a table whose columns have the names between semicolons."""
    columns = {name.strip(): Column(TIMES) for name in heads.split(";")}
    return Table(columns, lambda name, row: f"{name} {row}")


SURE = {
    "time_s; probe_A_um; probe_B_um; speed_rpm": "time_s probe_A_um probe_B_um speed=speed_rpm",
    "t; x; y": "t x y",
    "t; y; x": "t x y",
    "Time [s]; X (um); Y (um); Speed [rpm]": "Time [s]|X (um)|Y (um)|speed=Speed [rpm]",
    "time; Probe_B; Probe_A; rpm": "time Probe_A Probe_B speed=rpm",
    "t_ms; ProbeX; ProbeY; tach": "t_ms ProbeX ProbeY keyphasor=tach",
    "ms; CH1; CH2; CH3; keyphasor": "ms CH1 CH2 keyphasor=keyphasor",
    "Time; probe 1; probe 2; trigger": "Time|probe 1|probe 2|keyphasor=trigger",
    "t; horizontal_mm; vertical_mm; theta": "t horizontal_mm vertical_mm angle=theta",
    "t; probe_H; probe_V; phase_deg": "t probe_H probe_V angle=phase_deg",
    "t; gap_X_V; gap_Y_V; Kph": "t gap_X_V gap_Y_V keyphasor=Kph",
    "t; bearing1_x; bearing1_y; omega_rad_s": "t bearing1_x bearing1_y speed=omega_rad_s",
    "t; x_um; y_um; acc_x_g; acc_y_g": "t x_um y_um",
    "t; A_um; B_um; temp A; temp B": "t A_um B_um",
    "t; probe A; probe B; temp A; temp B": "t|probe A|probe B",
    "X_Value; Dev1/ai0; Dev1/ai1": "X_Value Dev1/ai0 Dev1/ai1",
    "t; x; y; keyphasor; speed_rpm": "t x y keyphasor=keyphasor",
    "t; x; y; angle; keyphasor; speed_rpm": "t x y angle=angle",
    "t; x; y; phase; speed_rpm": "t x y speed=speed_rpm",
    "t; x; y; tacho_Hz": "t x y speed=tacho_Hz",
    "t; time_total; x; y": "t x y",
    "rec.t; rec.x; rec.y": "rec.t rec.x rec.y",
}


@pytest.mark.parametrize("heads", SURE)
def test_columns_are_taken_by_names_in_use(heads: str) -> None:
    wanted = SURE[heads].split("|" if "|" in SURE[heads] else " ")
    named = [each if "=" in each else f"{signal}={each}"
             for signal, each in zip(("t", "x", "y", ""), wanted, strict=False)]  # fmt: skip
    found = columns_of(table_of(heads), {}, timed=False)
    assert found == dict(each.split("=") for each in named)


UNSURE = {
    "t; left; right": "must have a column for x and y; name them in columns, got 't, left, right'",
    "t; x; other": "must have a column for y; name it in columns, got 't, x, other'",
    "t; x1; x2": "must have a column for x and y; name them",
    "t; probe_A_x; probe_A_y; probe_B_x; probe_B_y": (
        "the columns of x and y must be unambiguous; name them in columns, got 'probe_A_x and "
        "probe_A_y; "
    ),
    "t; ai0; ai1; ai2": "got 'ai0 and ai1; ai1 and ai2' among 't, ai0, ai1, ai2'",
    "time_s; time_ms; x; y": "the column of t must be unambiguous; name it in columns, got 'time_",
    "t; x; y; speed_1_rpm; speed_2_rpm": "the column of speed must be unambiguous",
}


@pytest.mark.parametrize("heads", UNSURE)
def test_what_is_not_clear_is_refused_with_all_names(heads: str) -> None:
    with pytest.raises(InputError, match=re.escape(UNSURE[heads])):
        columns_of(table_of(heads), {}, timed=False)


def test_one_probe_that_is_named_leads_to_the_other() -> None:
    table = table_of("t; probe_A_x; probe_A_y; probe_B_x; probe_B_y; speed_rpm; tacho")
    told = {"x": "probe_B_x", "speed": "speed_rpm"}
    found = columns_of(table, told, timed=False)
    assert found == {"t": "t", "x": "probe_B_x", "y": "probe_B_y", "speed": "speed_rpm"}


def test_of_an_angle_and_a_keyphasor_that_are_named_the_angle_serves() -> None:
    told = {"keyphasor": "key", "angle": "theta"}
    found = columns_of(table_of("t; x; y; key; theta"), told, timed=False)
    assert found == {"t": "t", "x": "x", "y": "y", "angle": "theta"}


SUFFIXES = {
    ("t", "time_s"): "s", ("t", "t ms"): "ms", ("t", "us"): "us", ("t", "Time [min]"): "min",
    ("x", "x_um"): "um", ("x", "probe A µm"): "µm", ("x", "gap_mil"): "mil", ("x", "x_V"): "V",
    ("x", "x_s"): "", ("x", "x_in"): "", ("x", "x_m"): "m", ("speed", "rpm"): "rpm",
    ("speed", "n_Hz"): "Hz", ("speed", "omega_rad_s"): "rad/s", ("speed", "omega rad/s"): "rad/s",
    ("speed", "Speed (rpm)"): "rpm", ("angle", "theta_deg"): "deg",
}  # fmt: skip


@pytest.mark.parametrize(("signal", "column"), SUFFIXES)
def test_units_are_read_from_names_if_they_are_of_the_right_kind(signal: str, column: str) -> None:
    columns = {signal: column, **({"y": column} if signal == "x" else {})}
    assert unit_of(signal, columns, table_of(column)) == SUFFIXES[signal, column]


def test_a_last_letter_that_names_a_probe_is_no_unit() -> None:
    table = table_of("t; probe_H; probe_V")
    columns = {"x": "probe_H", "y": "probe_V"}
    assert unit_of("y", columns, table) == ""
    assert name_of("probe_V").is_suffix


def pump(folder: Path, head: str, *, speed: np.ndarray | None = None) -> Path:
    """Write a table of two probes at 45 and -45 degrees, and a speed in rpm."""
    rpm = np.full(TIMES.size, SPEED * 30.0 / math.pi) if speed is None else speed
    table = np.stack([TIMES, A, B, rpm], axis=1)
    np.savetxt(folder / "pump.csv", table, "%.9g", ",", header=head, comments="")
    return folder / "pump.csv"


HEAD = "time_s,probe_A_um,probe_B_um,speed_rpm"


def test_pictures_of_an_integrated_speed_show_no_mark_of_a_keyphasor(tmp_path: Path) -> None:
    found = read_signals(pump(tmp_path, HEAD), probe_angles=(45, -45))
    marked = found.assign_attrs(angle_origin="that of a keyphasor")
    for signals, has_mark in ((found, False), (marked, True)):
        labels = [line.get_label() for line in plot_orbit(signals).get_lines()]
        assert ("pulse of the keyphasor" in labels) == has_mark
        assert plot_bode(signals).axes[1].get_ylabel().endswith("(origin unknown)") != has_mark


def test_a_fit_to_an_integrated_speed_needs_the_angle_of_the_unbalance(tmp_path: Path) -> None:
    found = read_signals(pump(tmp_path, HEAD), probe_angles=(45, -45))
    machine = DimensionalRotor(
        mass=12.0, contact_stiffness=1e8, damping=400.0, eccentricity=2e-5, clearance=1.5e-4,
        speed=100.0, shaft_stiffness=4e6,
    )  # fmt: skip
    with pytest.raises(
        InputError, match="unknown must include unbalance_angle when the angle is in"
    ):
        fit(found, machine, ["eccentricity"])
    fitted = fit(found, machine, ["eccentricity", "unbalance_angle"])
    assert fitted.fitted_forward_whirl_amplitude.values == pytest.approx(30.0, rel=1e-3)


def test_a_speed_that_changes_is_integrated_by_the_trapezoidal_rule(tmp_path: Path) -> None:
    """Of a speed that rises evenly the rule is exact."""
    rpm = 600.0 + 150.0 * TIMES
    found = read_signals(pump(tmp_path, HEAD, speed=rpm), probe_angles=(45, -45))
    exact = math.pi / 30.0 * (600.0 * TIMES + 75.0 * TIMES**2)
    np.testing.assert_allclose(found.angle, exact, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.x + found.mean_x, Z.real, atol=1e-6)
    assert "phase lags have no known origin" in found.attrs["notes"]
    assert "probe_angles" not in found.attrs["notes"]


@pytest.mark.parametrize(
    ("unit", "size"), [("rpm", 30.0 / math.pi), ("Hz", 0.5 / math.pi), ("rad/s", 1.0)]
)
def test_speeds_in_any_unit_give_one_angle(unit: str, size: float, tmp_path: Path) -> None:
    path = pump(tmp_path, HEAD.replace("speed_rpm", f"speed [{unit}]"),
                speed=np.full(TIMES.size, SPEED * size))  # fmt: skip
    found = read_signals(path)
    np.testing.assert_allclose(found.angle, SPEED * TIMES, rtol=1e-8, atol=1e-9)
    assert "probes are taken to be at 0 and 90 degrees" in found.attrs["notes"]


ODD = {
    "no unit of the speed": (HEAD.replace("speed_rpm", "speed"), None,
        "the unit of speed must be one of rad/s, rpm, Hz, got '' in the column 'speed'"),
    "no unit of the times": (HEAD.replace("time_s", "time"), None,
        "t must have a unit beside a speed; give it in units"),
    "a speed that turns back": (HEAD, np.linspace(600.0, -10.0, TIMES.size),
        "speed must be 0 or positive, not always 0, got -1.0472 rad/s at t 3.9995"),
    "no speed at all": (HEAD, np.zeros(TIMES.size), "positive, not always 0, got 0"),
    "degrees that are not said": (HEAD.replace("speed_rpm", "angle"), (3600.0 * TIMES) % 360.0,
        "the unit of angle must be given in units, as it spans 358.2 and falls"),
    "pulses that are called a phase": (HEAD.replace("speed_rpm", "phase_ref"),
        (np.arange(TIMES.size) % 50 == 0) * 5.0,
        "if column 'phase_ref' holds pulses, name it in columns: keyphasor=phase_ref"),
}  # fmt: skip


@pytest.mark.parametrize("kind", ODD)
def test_speeds_and_angles_that_cannot_be_used_are_refused(kind: str, tmp_path: Path) -> None:
    head, speed, told = ODD[kind]
    with pytest.raises(InputError, match=re.escape(told)):
        read_signals(pump(tmp_path, head, speed=speed))


@pytest.mark.parametrize(
    ("sensitivity", "unit", "per_unit"),
    [("200 mV/mil", "um", 0.2 / 25.4), ("7.87V/mm", "mm", 7.87), ("8e-3 V/um", "um", 8e-3)],
)
def test_volts_become_lengths_by_the_sensitivity(
    sensitivity: str, unit: str, per_unit: float, tmp_path: Path
) -> None:
    path = pump(tmp_path, HEAD.replace("_um", "_V"))
    found = read_signals(path, sensitivity=sensitivity, probe_angles=(45, -45))
    assert found.x.attrs["units"] == unit
    np.testing.assert_allclose(found.x * per_unit, Z.real, atol=1e-6)
    assert read_signals(path).x.attrs["units"] == "V"


def test_sensitivities_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    path = pump(tmp_path, HEAD.replace("_um", "_V"))
    for odd in (*("200", "200 mV", "200 mV/s", "0 V/mm", "V/mm", 8, ". V/m"),
                *("1.2.3 V/mm", "1e-300 V/mm", "1e300 mV/mil")):  # fmt: skip
        with pytest.raises(InputError, match="sensitivity must be such as '200 mV/mil'"):
            read_signals(path, sensitivity=odd)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="must be of readings in V or mV, got x in um"):
        read_signals(pump(tmp_path, HEAD), sensitivity="8 V/mm")
