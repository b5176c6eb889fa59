"""Channels with clocks of their own: the amplitude and the lag of a whirl that is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import xarray as xr
from nptdms import ChannelObject, TdmsWriter

from rotor_ida import orders, read_signals
from tests.signals.test_files import (
    LVM_HEAD,
    A,
    B,
    refused,
    write_comtrade,
    write_hdf5,
    write_lvm,
    write_uff,
)

Array = npt.NDArray[np.float64]

RATE, TURN, SIZE, LAG = 2000.0, 2.0 * math.pi * 25.0, 40.0, math.radians(50.0)
T = np.arange(4000) / RATE


def x_at(times: Array) -> Array:
    return SIZE * np.cos(TURN * times - LAG)


def y_at(times: Array) -> Array:
    return SIZE * np.sin(TURN * times - LAG)


def pulses_at(times: Array) -> Array:
    """Return 5 V from the mark on, with a rise of 2 ms through one half at the mark."""
    phase = (TURN * times / (2.0 * math.pi) + 0.5) % 1.0 - 0.5
    return 5.0 * np.interp(phase, [-0.5, -0.025, 0.025, 0.1, 0.15, 0.5], [0, 0, 1, 1, 0, 0])


def check(found: xr.Dataset) -> None:
    once = orders(found).sel(order=1)
    np.testing.assert_allclose(once.forward_whirl_amplitude, SIZE, rtol=1e-3)
    np.testing.assert_allclose(np.degrees(once.forward_phase_lag), 50.0, atol=0.1)
    assert once.backward_whirl_amplitude.max() < 0.02


def write_tdms(path: Path, channels: dict[str, tuple[Array, dict[str, object]]]) -> None:
    with TdmsWriter(str(path)) as file:
        file.write_segment([
            ChannelObject("run", name, values, properties=properties)
            for name, (values, properties) in channels.items()
        ])  # fmt: skip


LATE = {"x": 0.0, "y": 0.0123, "keyphasor": -0.0049}
BEGIN = np.datetime64("2024-02-28T23:59:59.990000", "us")
TDMS = {
    "wf_start_time": lambda late: {
        "wf_start_time": BEGIN + np.timedelta64(round(1e6 * late), "us"),
    },
    "wf_start_offset": lambda late: {"wf_start_offset": late},
    "both": lambda late: {
        "wf_start_time": BEGIN + np.timedelta64(round(2e6 * late), "us"), "wf_start_offset": -late,
    },
    "in ms": lambda late: {"wf_start_offset": 1e3 * late, "wf_xunit_string": "ms"},
}  # fmt: skip


@pytest.mark.parametrize("kind", TDMS)
def test_tdms_channels_that_start_at_other_times(kind: str, tmp_path: Path) -> None:
    step = {"wf_increment": 1e3 / RATE if kind == "in ms" else 1.0 / RATE}
    channels = {
        name: (signal(T + LATE[name]), {**step, **TDMS[kind](LATE[name]), "unit_string": "um"})
        for name, signal in {"x": x_at, "y": y_at, "keyphasor": pulses_at}.items()
    }
    write_tdms(tmp_path / "a.tdms", channels)
    found = read_signals(tmp_path / "a.tdms")
    check(found)
    assert "the times of y are not those of x: interpolated at those" in found.attrs["notes"]


def test_tdms_with_a_faster_keyphasor_and_a_slow_speed(tmp_path: Path) -> None:
    fast, slow = np.arange(20_000) / (5.0 * RATE), np.arange(21) / 10.0
    probes = {
        name: (signal(T), {"wf_increment": 1.0 / RATE, "unit_string": "um"})
        for name, signal in {"x": x_at, "y": y_at}.items()
    }
    keyphasor = {"keyphasor": (pulses_at(fast), {"wf_increment": 0.2 / RATE})}
    write_tdms(tmp_path / "a.tdms", probes | keyphasor)
    check(read_signals(tmp_path / "a.tdms"))
    rpm = np.full(slow.size, TURN * 30.0 / math.pi)
    speed = {"speed": (rpm, {"wf_increment": 0.1, "unit_string": "rpm"})}
    write_tdms(tmp_path / "a.tdms", probes | speed)
    found = read_signals(tmp_path / "a.tdms")
    np.testing.assert_allclose(found.angle, TURN * found.t, atol=1e-9)


def test_tdms_channel_without_times_has_those_of_another_of_its_length(tmp_path: Path) -> None:
    """Beside a slow speed, whose times are others: x is not on those."""
    slow = np.full(21, TURN * 30.0 / math.pi)
    write_tdms(tmp_path / "a.tdms", {
        "x": (x_at(T), {"unit_string": "um"}),
        "y": (y_at(T), {"wf_increment": 1.0 / RATE, "unit_string": "um"}),
        "speed": (slow, {"wf_increment": 0.1, "unit_string": "rpm"}),
    })  # fmt: skip
    check(read_signals(tmp_path / "a.tdms"))


def test_tdms_channels_over_a_frequency_are_no_signals(tmp_path: Path) -> None:
    spectrum = {"wf_increment": 0.5, "wf_xunit_string": "Hz"}
    write_tdms(tmp_path / "a.tdms", {"x": (x_at(T), spectrum), "y": (y_at(T), spectrum)})
    assert "x (over Hz)" in refused(tmp_path / "a.tdms")


def test_channels_that_do_not_overlap_are_refused(tmp_path: Path) -> None:
    late = {"wf_increment": 1.0 / RATE, "wf_start_offset": 100.0}
    write_tdms(
        tmp_path / "a.tdms", {"x": (x_at(T), late | {"wf_start_offset": 0.0}), "y": (y_at(T), late)}
    )
    assert "must overlap in time, got x from 0 to 1.9995, y from 100 to 101.999" in (
        refused(tmp_path / "a.tdms")
    )
    columns = {"x": "x", "y": "y"}
    assert "rate must be left out: the file has other times for y" in (
        refused(tmp_path / "a.tdms", columns=columns, rate=RATE)
    )


def comtrade(folder: Path, kind: str, skews: tuple[float, float], size: int = T.size) -> Path:
    """Write a record whose probes are read a time after their samples [us]."""
    a, b, key = (
        signal(T + 1e-6 * skew)
        for signal, skew in ((x_at, skews[0]), (y_at, skews[1]), (pulses_at, 0.0))
    )
    path = folder / "a.cfg"
    write_comtrade(path, kind=kind, probes=(a, b), pulse=(key > 2.5).astype(float), size=size)
    lines = path.read_text().splitlines()
    for row, skew in zip((2, 3), skews, strict=True):
        cells = lines[row].split(",")
        cells[7] = f"{skew:g}"
        lines[row] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("kind", "skews"),
    [("ASCII", (0.0, 137.0)), ("BINARY", (4000.0, 4000.0)), ("BINARY", (4000.0, -137.0))],
)
def test_the_skew_of_comtrade_channels_is_a_time(
    kind: str, skews: tuple[float, float], tmp_path: Path
) -> None:
    once = orders(read_signals(comtrade(tmp_path, kind, skews))).sel(order=1)
    np.testing.assert_allclose(once.forward_whirl_amplitude, SIZE, rtol=1e-3)
    # a status is 0 or 1: the mark lies within a step of 4.5 degrees, its middle is taken
    np.testing.assert_allclose(np.degrees(once.forward_phase_lag), 50.0, atol=2.4)


@pytest.mark.parametrize("kind", ["ASCII", "BINARY"])
def test_comtrade_that_contradicts_itself_is_refused(kind: str, tmp_path: Path) -> None:
    path = comtrade(tmp_path, kind, (0.0, 0.0))
    whole = path.read_text()
    path.write_text(whole.replace("\n2000,4000", "\n50,4000"))
    assert "must declare the sampling rate of its time stamps, 2000 a second, got 50" in (
        refused(path)
    )
    path.write_text(whole.replace("\n2000,4000", "\n0,4000").replace("\n1\n2000", "\n0\n2000"))
    path.write_text(path.read_text().replace("50\n1\n0,4000", "50\n0\n0,4000"))
    np.testing.assert_allclose(read_signals(path).t, T, atol=1e-9)  # the stamps are the times
    path.write_text(whole.replace("50\n1\n2000,4000", "50\n2\n2000,1000\n500,4000"))
    assert "must declare one sampling rate, got 2000 a second up to sample 1000 and 500" in (
        refused(path)
    )
    path.write_text(whole.replace("\n2000,4000", "\n2000,3000"))
    assert "must contain the 3000 samples that 'a.cfg' declares, got 4000" in refused(path)


def write_clocked_lvm(path: Path, columns: str, clocks: list[tuple[float, float, float]]) -> None:
    """Write x, y and a keyphasor, each with its seconds of the day, X0 and Delta_X."""
    sizes = [int(1.0 / step) for _, _, step in clocks]
    heads = {
        "Samples": sizes,
        "Date": ["2024/02/28"] * 3,
        "Time": [f"12:00:{late:09.6f}" for late, _, _ in clocks],
        "X_Dimension": ["Time"] * 3,
        "X0": [first for _, first, _ in clocks],
        "Delta_X": [step for _, _, step in clocks],
        "Y_Unit_Label": ["um", "um", "V"],
    }
    own = [first + step * np.arange(n) for (_, first, step), n in zip(clocks, sizes, strict=True)]
    values = [
        signal(each + late)
        for signal, each, (late, _, _) in zip((x_at, y_at, pulses_at), own, clocks, strict=True)
    ]
    lines = ["\t".join([tag, *map(str, cells)]) for tag, cells in heads.items()]
    names = ["Probe x", "Probe y", "Keyphasor"]
    multi = columns == "Multi"
    lines += ["***End_of_Header***", "\t".join(
        [part for name in names for part in ("X_Value", name)] if multi else ["X_Value", *names]
    )]  # fmt: skip
    for row in range(max(sizes)):
        cells = [f"{each[row]:.9f}" if row < each.size else "" for each in values]
        times = [f"{each[row]:.9f}" if row < each.size else "" for each in own]
        longest = sizes.index(max(sizes))
        first = {"No": [""], "One": [times[longest]], "Multi": []}[columns]
        if multi:
            cells = [part for pair in zip(times, cells, strict=True) for part in pair]
        lines.append("\t".join([*first, *cells]))
    path.write_text(LVM_HEAD.format(columns=columns, point=".") + "\n".join(lines) + "\n")


CLOCKS = {
    "one": [(0.0, 0.0, 5e-4)] * 3,
    "other starts": [(0.0, 0.0, 5e-4), (0.0, 0.0031, 5e-4), (0.0, -0.02, 5e-4)],
    "other times of day": [(0.0, 0.0, 5e-4), (0.0031, 0.0, 5e-4), (0.004, 0.0, 5e-4)],
    "a faster keyphasor": [(0.0, 0.0, 5e-4), (0.0, 0.0, 5e-4), (0.0, 0.0, 1e-4)],
}


@pytest.mark.parametrize(
    ("kind", "columns"),
    [("one", "One"), *((kind, columns) for kind in list(CLOCKS)[1:] for columns in ("No", "Multi")),
     ("other times of day", "One")],
)  # fmt: skip
def test_labview_channels_with_clocks_of_their_own(kind: str, columns: str, tmp_path: Path) -> None:
    write_clocked_lvm(tmp_path / "a.lvm", columns, CLOCKS[kind])
    check(read_signals(tmp_path / "a.lvm"))


def test_labview_rows_after_a_blank_line_belong_to_the_segment(tmp_path: Path) -> None:
    write_lvm(tmp_path / "a.lvm", columns="One")
    whole = read_signals(tmp_path / "a.lvm")
    lines = (tmp_path / "a.lvm").read_text().splitlines()
    (tmp_path / "a.lvm").write_text("\n".join([*lines[:1000], "", *lines[1000:], ""]))
    xr.testing.assert_identical(read_signals(tmp_path / "a.lvm"), whole)
    (tmp_path / "a.lvm").write_text("\n".join([*lines[:1000], "stopped", *lines[1000:]]))
    assert "must contain numbers, or belong to the header of a segment" in (
        refused(tmp_path / "a.lvm")
    )


def test_labview_samples_other_than_declared_are_refused(tmp_path: Path) -> None:
    write_lvm(tmp_path / "a.lvm", columns="No")
    text = (tmp_path / "a.lvm").read_text()
    for declared in (3000, 5000):
        path = tmp_path / "b.lvm"
        path.write_text(text.replace("Samples\t4000\t4000\t4000", "Samples" + f"\t{declared}" * 3))
        assert f"must contain the {declared} samples that the segment at line" in refused(path)
    spectrum = text.replace("Time\tTime\tTime", "Frequency\tFrequency\tFrequency")
    (tmp_path / "c.lvm").write_text(spectrum)
    assert "must contain channels over time" in refused(tmp_path / "c.lvm")


def test_uff_responses_with_clocks_of_their_own(tmp_path: Path) -> None:
    fast = np.arange(20_000) / (5.0 * RATE)
    times = {"Probe x": T, "Probe y": T + 0.0031, "Keyphasor": fast}
    values = {"Probe x": x_at(T), "Probe y": y_at(T + 0.0031), "Keyphasor": pulses_at(fast)}
    for binary in (0, 1):
        path = tmp_path / f"{binary}.uff"
        write_uff(path, binary=binary, columns=values, times=times)
        check(read_signals(path))


def test_uff_spectra_are_told_by_their_function(tmp_path: Path) -> None:
    lines = np.abs(np.fft.rfft(x_at(T)))
    write_uff(tmp_path / "a.uff", binary=0, columns={"Probe x": lines}, function=2,
              times={"Probe x": np.arange(lines.size) * 0.5})  # fmt: skip
    assert (
        "must contain time responses (set 58 or 58b), got a set 58 with the function type 2"
        in refused(tmp_path / "a.uff")
    )
    # a correlation is over a time too; the library does not write one
    write_uff(tmp_path / "b.uff", binary=0, columns={"Probe x": x_at(T)})
    text = (tmp_path / "b.uff").read_text().splitlines()
    text[7] = text[7].replace("    1", "    7", 1)
    (tmp_path / "b.uff").write_text("\n".join(text) + "\n")
    assert "function type 7" in refused(tmp_path / "b.uff")


PACKED = """
with h5py.File('a.h5', 'w') as f:
    f['t_s'] = d['t']
    for name, values in (('x', d['a']), ('y', d['b']), ('gap', d['a'])):
        packed = f.create_dataset(name, data=np.rint((values - 5.0) / 0.01).astype('i2'))
        packed.attrs.update(units='um', scale_factor=0.01, add_offset=5.0,
                            _FillValue=np.int16(-32768))
    f['gap'][20] = -32768
    f['odd'] = d['t']
    f['odd'].attrs['scale_factor'] = 'two'
"""


def test_packed_numbers_of_hdf5_are_unpacked(tmp_path: Path) -> None:
    write_hdf5(tmp_path, PACKED)
    found = read_signals(tmp_path / "a.h5", gap="0")
    np.testing.assert_allclose(found.x, A, atol=0.00501)
    np.testing.assert_allclose(found.y, B, atol=0.00501)
    assert "column 'gap' must contain finite numbers, got nan in row 21" in (
        refused(tmp_path / "a.h5", columns={"x": "gap", "y": "y"})
    )
    assert "odd (numbers of which scale_factor is 'two')" in (
        refused(tmp_path / "a.h5", columns={"x": "none"})
    )


def test_a_file_without_names_and_times_is_refused_by_its_rate(tmp_path: Path) -> None:
    """Its columns may be a tachometer and two probes, in any order."""
    np.savetxt(tmp_path / "a.csv", np.column_stack([pulses_at(T), x_at(T), y_at(T)]), "%.9f", ",")
    message = refused(tmp_path / "a.csv", rate=RATE)
    assert "must have names, or times before x and y" in message
    assert message.endswith("name x and y in columns, got '1, 2, 3'")
    check(
        read_signals(tmp_path / "a.csv", rate=RATE, columns={"keyphasor": "1", "x": "2", "y": "3"})
    )
