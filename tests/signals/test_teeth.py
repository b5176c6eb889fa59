"""Keyphasors with glitches and wheels with a mark: the amplitude and the lag of a known whirl."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import xarray as xr

from rotor_ida import DimensionalRotor, InputError, fit, orders, read_signals
from rotor_ida.plot import plot_bode

Array = npt.NDArray[np.float64]

RATE, SIZE, LAG = 20_000.0, 40.0, math.radians(50.0)
T = np.arange(30_000) / RATE
COURSES = {
    "one speed": 20.0 * T + 0.37,
    "run-up": 15.0 * T + 10.0 * T**2 + 0.37,
    "coast-down": 50.0 * T - 12.0 * T**2 + 0.37,
}  # revolutions of the mark


def steps(turns: Array, *teeth: tuple[float, float]) -> Array:
    """Return 5 V while a tooth passes: its begin and its length in revolutions."""
    place = turns % 1.0
    return 5.0 * np.any([(place - begin) % 1.0 < length for begin, length in teeth], axis=0)


def wheel(number: int, *, without: tuple[int, ...] = ()) -> list[tuple[float, float]]:
    return [(k / number, 0.3 / number) for k in range(number) if k not in without]


def read(folder: Path, turns: Array, keyphasor: Array, **options: object) -> xr.Dataset:
    z = SIZE * np.exp(1j * (2.0 * math.pi * turns - LAG))
    path = folder / "a.npz"
    np.savez(path, t_s=T, x_um=z.real, y_um=z.imag, keyphasor=keyphasor)
    return read_signals(path, **options)  # type: ignore[arg-type]


def check(found: xr.Dataset, *, pitch: float = 360.0) -> None:
    """Compare order 1 with the whirl, its lag but for multiples of a pitch [degree]."""
    once = orders(found).sel(order=1)
    np.testing.assert_allclose(once.forward_whirl_amplitude, SIZE, rtol=2e-3)
    off = np.degrees(once.forward_phase_lag.values - LAG)
    # a tenth of a step of the samples is up to 0.1 degrees
    np.testing.assert_allclose((off + pitch / 2.0) % pitch - pitch / 2.0, 0.0, atol=0.6)


GLITCHES = {
    "a spike": [(4321, 3, 60.0)],
    "a spike the other way": [(4321, 3, -60.0)],
    "a small one the other way": [(4321, 2, -5.0)],
    "spikes of many heights": [(4321, 1, 90.0), (15_100, 2, 40.0), (23_456, 1, -70.0)],
    "one as high as a pulse": [(4321, 4, 5.0)],
    "three alike": [(5000 * k, 2, 60.0) for k in (1, 2, 3)],
    "one after the first pulse": [(1100, 3, 5.0)],
    "one before the first pulse": [(100, 3, 5.0)],
    "one on a pulse": [(640, 2, 80.0)],
}  # first sample, how many, and height [V]


@pytest.mark.parametrize("course", ["run-up", "coast-down"])
@pytest.mark.parametrize("kind", GLITCHES)
def test_glitches_of_a_keyphasor_are_ignored_and_counted(
    kind: str, course: str, tmp_path: Path
) -> None:
    turns = COURSES[course]
    signal = steps(turns, (0.0, 0.08)) + 0.02 * np.random.default_rng(5).normal(size=T.size)
    clean = read(tmp_path, turns, signal)
    for first, count, height in GLITCHES[kind]:
        signal[first : first + count] += height
    found = read(tmp_path, turns, signal)
    check(found)
    np.testing.assert_allclose(found.keyphasor, clean.keyphasor, atol=0.5 / RATE)
    count = {"spikes of many heights": 3, "a spike": 1, "a spike the other way": 1,
             "one as high as a pulse": 1}.get(kind, "")  # fmt: skip
    note = f"pulses of the keyphasor that do not fit the others: {count}"
    assert found.attrs["notes"].startswith(note)
    assert "ignored" not in clean.attrs.get("notes", "")


def test_many_extra_pulses_are_refused(tmp_path: Path) -> None:
    turns = COURSES["one speed"]
    with pytest.raises(InputError, match="must not have extra pulses"):
        read(tmp_path, turns, steps(turns, (0.0, 0.05)) + steps(turns / 4.0, (0.1, 0.02)))


def test_a_ripple_between_pulses_is_no_keyphasor(tmp_path: Path) -> None:
    """Of two pulses that are not enough the hum between them makes no more."""
    signal = steps(T, (0.1, 0.01)) + 0.3 * np.sin(2.0 * math.pi * 50.0 * T)
    with pytest.raises(InputError, match="must have at least 3 pulses, got 2"):
        read(tmp_path, COURSES["one speed"], signal)


WHEELS = {
    "a missing tooth of 12": (12, steps, wheel(12, without=(11,)), "first pulse after the missing"),
    "a missing tooth of 4": (4, steps, wheel(4, without=(3,)), "first pulse after the missing"),
    "a missing tooth of 3": (3, steps, wheel(3, without=(2,)), "first pulse after the missing"),
    "two missing teeth of 36": (
        36, steps, wheel(36, without=(34, 35)), "first pulse after the missing",
    ),
    "an extra tooth": (8, steps, [*wheel(8), (0.94, 0.02)], "first pulse after the extra one"),
    "a longer tooth": (8, steps, [*wheel(8), (0.0, 0.06)], "the longer tooth"),
}  # fmt: skip


@pytest.mark.parametrize("course", ["run-up", "coast-down"])
@pytest.mark.parametrize("kind", WHEELS)
def test_a_wheel_with_a_mark_gives_the_lag(kind: str, course: str, tmp_path: Path) -> None:
    number, signal, teeth, mark = WHEELS[kind]
    turns = COURSES[course]
    found = read(tmp_path, turns, signal(turns, *teeth), pulses_per_revolution=number)
    check(found)
    assert f"{mark}" in found.attrs["notes"]
    assert "is the mark, at the angle 0" in found.attrs["notes"]
    assert "angle_origin" not in found.attrs


def test_a_list_of_times_with_a_missing_tooth_has_its_mark(tmp_path: Path) -> None:
    turns = np.concatenate([k + np.arange(11) / 12.0 for k in range(1, 20)])
    times = (turns - 0.37) / 20.0
    found = read(tmp_path, COURSES["one speed"], times, pulses_per_revolution=12)
    check(found)
    np.testing.assert_allclose(np.diff(found.keyphasor), 1.0 / 240.0, rtol=1e-9)


def test_a_wheel_without_a_mark_gives_the_lag_but_for_the_pitch(tmp_path: Path) -> None:
    turns = COURSES["run-up"]
    found = read(tmp_path, turns, steps(turns, *wheel(12)), pulses_per_revolution=12)
    check(found, pitch=30.0)
    note = "none of the 12 pulses a revolution is the mark: phase lags are known but for a multiple"
    assert f"{note} of 30 degrees" in found.attrs["notes"]
    assert found.attrs["angle_origin"] == "one of several pulses"
    assert plot_bode(found).axes[1].get_ylabel().endswith("(origin unknown)")
    machine = DimensionalRotor(
        mass=12.0, contact_stiffness=1e8, damping=400.0, eccentricity=2e-5, clearance=1.5e-4,
        speed=100.0, shaft_stiffness=4e6,
    )  # fmt: skip
    with pytest.raises(InputError, match=r"unbalance_angle when .* no mark among several pulses"):
        fit(found, machine, ["eccentricity"])


def test_a_pulse_that_is_lost_elsewhere_is_no_mark(tmp_path: Path) -> None:
    turns = COURSES["one speed"]
    signal = steps(turns, *wheel(12)) * ((turns < 7.2) | (turns > 7.3))
    with pytest.raises(InputError, match="must not lose pulses, but does after t"):
        read(tmp_path, turns, signal, pulses_per_revolution=12)
    found = read(tmp_path, turns, signal, pulses_per_revolution=12, fill_pulses=True)
    check(found, pitch=30.0)
    assert "none of the 12 pulses" in found.attrs["notes"]


def test_a_missing_tooth_is_suggested_where_pulses_are_lost_once_a_revolution(
    tmp_path: Path,
) -> None:
    turns = COURSES["one speed"]
    signal = steps(turns, *wheel(12, without=(11,)))
    with pytest.raises(InputError, match="pulses_per_revolution=12 takes every 12th, if a tooth"):
        read(tmp_path, turns, signal)
