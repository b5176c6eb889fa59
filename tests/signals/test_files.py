"""Files of recorders come back as they were written; damaged ones are refused in one line."""

from __future__ import annotations

import gc
import math
import os
import struct
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import pyuff
import xarray as xr
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat, wavfile

from rotor_ida import InputError, read_signals

RATE, SPEED = 2000.0, 10.0  # samples and revolutions a second
TIMES = np.arange(4000) / RATE
TURN = 2.0 * math.pi * SPEED * TIMES
Z = 40.0 * np.exp(1j * (TURN - 0.5)) + 3.0 * np.exp(-2j * TURN)
# Probes at 45 and -45 degrees read what is along them.
A, B = (np.real(Z * np.exp(-1j * angle)) for angle in (math.pi / 4.0, -math.pi / 4.0))
PULSE = ((TURN + 0.01) % (2.0 * math.pi) < 0.5).astype(float)
RPM = np.full(TIMES.size, 60.0 * SPEED)
PROBES = (45.0, -45.0)

Array = npt.NDArray[np.float64]


def check(found: xr.Dataset, *, to: float = 1e-9, unit: str = "um") -> None:
    """Hold signals against the whirl that the probes saw."""
    np.testing.assert_allclose(found.t, TIMES, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.x, Z.real, rtol=0, atol=to)
    np.testing.assert_allclose(found.y, Z.imag, rtol=0, atol=to)
    assert (found.t.attrs["units"], found.x.attrs["units"]) == ("s", unit)


def check_pulses(found: xr.Dataset) -> None:
    """Hold the pulses against those of the mark, half a sample apart at most."""
    np.testing.assert_allclose(np.diff(found.keyphasor), 1.0 / SPEED, atol=1e-9)
    assert (found.keyphasor.values * SPEED % 1.0)[0] > 0.99


def refused(path: Path, **options: object) -> str:
    """Return the one line by which a file is refused."""
    with pytest.raises(InputError) as raised:
        read_signals(path, **options)  # type: ignore[arg-type]
    message = str(raised.value)
    assert "\n" not in message
    assert len(message) < 600
    return message


def write_uff(
    path: Path,
    *,
    binary: int,
    columns: dict[str, Array] | None = None,
    times: dict[str, Array] | None = None,
    function: int = 1,
) -> None:
    file = pyuff.UFF(str(path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # it leaves binary files to be collected
        columns = columns or {"Probe A": A, "Probe B": B, "Keyphasor": PULSE}
        _write_sets(file, binary, columns, times or {}, function)
        gc.collect()


def _write_sets(
    file: pyuff.UFF, binary: int, columns: dict[str, Array], clocks: dict[str, Array], function: int
) -> None:
    for number, (name, values) in enumerate(columns.items(), 1):
        times = clocks.get(name, TIMES)
        file.write_sets({
            "type": 58, "binary": binary, "func_type": function, "id1": name, "rsp_node": number,
            "rsp_dir": 1, "ref_node": 0, "ref_dir": 0, "data": values, "x": times,
            "num_pts": times.size, "abscissa_spacing": 1, "abscissa_min": times[0],
            "abscissa_inc": times[1] - times[0], "abscissa_spec_data_type": 17,
            "abscissa_axis_units_lab": "s", "ordinate_spec_data_type": 8,
            "ordinate_axis_units_lab": "um", "orddenom_spec_data_type": 0,
            "z_axis_spec_data_type": 0,
        })  # fmt: skip


@pytest.mark.parametrize("binary", [0, 1])
def test_uff_58_and_58b_come_back_with_units_and_names(binary: int, tmp_path: Path) -> None:
    write_uff(tmp_path / "a.uff", binary=binary)
    found = read_signals(tmp_path / "a.uff", probe_angles=PROBES)
    check(found)
    check_pulses(found)
    assert found.attrs["columns"].startswith("t=t x=Probe A y=Probe B keyphasor=Keyphasor")


def test_uff_responses_without_titles_are_called_by_node_and_direction(tmp_path: Path) -> None:
    write_uff(tmp_path / "a.unv", binary=0, columns={"NONE": A, "none": B})
    names = {"x": "node 1 x", "y": "node 2 x"}
    check(read_signals(tmp_path / "a.unv", columns=names, probe_angles=PROBES))


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("part", [0.2, 0.5, 0.9])
def test_a_part_of_a_uff_file_is_refused(binary: int, part: float, tmp_path: Path) -> None:
    write_uff(tmp_path / "a.uff", binary=binary)
    whole = (tmp_path / "a.uff").read_bytes()
    (tmp_path / "a.uff").write_bytes(whole[: int(part * len(whole))])
    assert "must be a universal file (UFF)" in refused(tmp_path / "a.uff")


def write_tdms(path: Path, **more: Array) -> None:
    channels = {"Probe A": (A, "um"), "Probe B": (B, "um"), "Speed": (RPM, "rpm")}
    timing = {"wf_increment": 1.0 / RATE, "wf_start_offset": 0.0}
    with TdmsWriter(str(path)) as file:
        file.write_segment([
            *(
                ChannelObject("run", name, values, properties={**timing, "unit_string": unit})
                for name, (values, unit) in channels.items()
            ),
            *(
                ChannelObject("slow", name, values, properties={"wf_increment": 1.0})
                for name, values in more.items()
            ),
        ])  # fmt: skip


def test_tdms_comes_back_with_its_times_units_and_speed(tmp_path: Path) -> None:
    write_tdms(tmp_path / "a.tdms")
    found = read_signals(tmp_path / "a.tdms", probe_angles=PROBES)
    check(found)
    np.testing.assert_allclose(found.angle, TURN, rtol=0, atol=1e-9)


def test_tdms_channels_of_another_rate_are_listed_and_not_guessed(tmp_path: Path) -> None:
    write_tdms(tmp_path / "a.tdms", **{"Probe A": np.arange(20.0), "Probe B": np.arange(20.0)})
    check(read_signals(tmp_path / "a.tdms", probe_angles=PROBES))
    assert "slow.Probe B" in refused(tmp_path / "a.tdms", columns={"x": "none"})
    columns = {"x": "run.Probe A", "y": "slow.Probe B"}
    assert "x and y must have one sampling rate, got 2000 and 1 samples a second" in (
        refused(tmp_path / "a.tdms", columns=columns, units={"y": "um"})
    )


def test_damaged_tdms_files_are_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    write_tdms(tmp_path / "a.tdms")
    whole = (tmp_path / "a.tdms").read_bytes()
    for size in (10, 300, len(whole) // 2):
        (tmp_path / "a.tdms").write_bytes(whole[:size])
        told = "must contain channels" if size <= 300 else "got one that ends early"
        assert told in refused(tmp_path / "a.tdms")
    (tmp_path / "a.tdms").write_bytes(b"nonsense" * 50)
    assert "must be a TDMS file" in refused(tmp_path / "a.tdms")
    assert capfd.readouterr() == ("", "")


LVM_HEAD = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t{point}
Multi_Headings\tNo
X_Columns\t{columns}
Time_Pref\tAbsolute
***End_of_Header***\t
\t
"""
LVM_SEGMENT = """Channels\t3
Samples\t{size}\t{size}\t{size}
Y_Unit_Label\tum\tum\trpm
X_Dimension\tTime\tTime\tTime
X0\t{start}\t{start}\t{start}
Delta_X\t0.0005\t0.0005\t0.0005
***End_of_Header***\t\t\t
X_Value\tProbe A\tProbe B\tSpeed\tComment
"""


def write_lvm(path: Path, *, columns: str, point: str = ".", parts: int = 1) -> None:
    text = LVM_HEAD.format(point=point, columns=columns)
    for rows in np.array_split(np.arange(TIMES.size), parts):
        segment = LVM_SEGMENT.format(size=rows.size, start=f"{TIMES[rows[0]]:.6f}")
        for row in rows:
            first = "" if columns == "No" else f"{TIMES[row]:.6f}"
            segment += f"{first}\t{A[row]:.9f}\t{B[row]:.9f}\t{RPM[row]:.1f}"
            segment += "\tstarted\n" if row == 0 else "\n"
        text += segment.replace(".", point) + "\n"
    path.write_text(text)


@pytest.mark.parametrize("columns", ["One", "No"])
@pytest.mark.parametrize(("point", "parts"), [(".", 1), (",", 1), (".", 3)])
def test_labview_files_come_back(columns: str, point: str, parts: int, tmp_path: Path) -> None:
    write_lvm(tmp_path / "a.lvm", columns=columns, point=point, parts=parts)
    found = read_signals(tmp_path / "a.lvm", probe_angles=PROBES)
    check(found, to=1e-8)
    np.testing.assert_allclose(found.angle, TURN, rtol=0, atol=1e-8)


def test_labview_files_without_a_head_are_tables(tmp_path: Path) -> None:
    table = np.column_stack([TIMES, A, B])
    np.savetxt(tmp_path / "a.lvm", table, "%.12f", "\t")
    units = {"t": "s", "x": "um", "y": "um"}
    check(read_signals(tmp_path / "a.lvm", units=units, probe_angles=PROBES))


def test_damaged_labview_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.lvm"
    path.write_text("LabVIEW Measurement\t\nSeparator\tTab\n")
    assert "must have a header that ends in ***End_of_Header***" in refused(path)
    path.write_text(LVM_HEAD.format(point=".", columns="One"))
    assert "must contain a segment with the line X_Value, got none" in refused(path)
    write_lvm(path, columns="One")
    text = path.read_text().splitlines()
    text[40] = text[40].replace("0.0", "?")
    path.write_text("\n".join(text))
    assert "must contain finite numbers, got nan in line 41" in refused(path)


COMTRADE = """pump,recorder,{year}
4,3A,1D
1,Probe A,,,um,{gain},0.0,0,-32767,32767,1,1,P
2,Probe B,,,um,{gain},0.0,0,-32767,32767,1,1,P
3,Temperature,,,C,1.0,0.0,0,-32767,32767,1,1,P
1,Keyphasor,,,0
50
1
2000,{size}
01/02/2024,10:00:00.000000
01/02/2024,10:00:00.000000
{kind}
1
"""


def write_comtrade(
    path: Path,
    *,
    kind: str,
    size: int = TIMES.size,
    probes: tuple[Array, Array] = (A, B),
    pulse: Array = PULSE,
) -> None:
    gain = 0.002  # a count
    counts = np.rint(np.stack(probes) / gain).astype(int)
    path.write_text(COMTRADE.format(year=1999, gain=gain, size=size, kind=kind))
    microseconds = np.rint(TIMES * 1e6).astype(int)
    rows = range(TIMES.size)
    if kind == "ASCII":
        lines = [
            f"{row + 1},{microseconds[row]},{counts[0, row]},{counts[1, row]},20,{pulse[row]:.0f}"
            for row in rows
        ]
        path.with_suffix(".dat").write_text("\n".join(lines) + "\n")
    else:
        data = b"".join(
            struct.pack(
                "<IIhhhH", row + 1, microseconds[row], *counts[:, row].tolist(), 20, int(pulse[row])
            )
            for row in rows
        )
        path.with_suffix(".dat").write_bytes(data)


def in_one_file(path: Path, *, end: str = "\r\n") -> None:
    """Write one .cff file from a .cfg and a .dat file."""
    head, data = (path.with_suffix(ending).read_bytes() for ending in (".cfg", ".dat"))
    binary = b"BINARY" in head
    marks = ["CFG", "INF", "HDR", f"DAT BINARY: {len(data)}" if binary else "DAT ASCII"]
    lines = [f"--- file type: {each} ---{end}".encode() for each in marks]
    path.write_bytes(lines[0] + head + lines[1] + end.encode() + lines[2] + lines[3] + data)


@pytest.mark.parametrize("kind", ["ASCII", "BINARY"])
@pytest.mark.parametrize("ending", [".cfg", ".dat"])
def test_comtrade_comes_back_with_times_from_its_rate(
    kind: str, ending: str, tmp_path: Path
) -> None:
    write_comtrade(tmp_path / "a.cfg", kind=kind)
    found = read_signals(tmp_path / f"a{ending}", probe_angles=PROBES)
    check(found, to=0.002)  # of counts of 2 nm
    check_pulses(found)


@pytest.mark.parametrize("kind", ["ASCII", "BINARY"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_comtrade_in_one_file_is_the_same(kind: str, end: str, tmp_path: Path) -> None:
    write_comtrade(tmp_path / "a.cfg", kind=kind)
    in_one_file(tmp_path / "a.cff", end=end)
    pair, one = (read_signals(tmp_path / f"a{ending}") for ending in (".cfg", ".cff"))
    assert pair.drop_attrs().identical(one.drop_attrs())
    assert one.attrs["file"] == "a.cff"


def test_a_part_of_comtrade_in_one_file_is_refused(tmp_path: Path) -> None:
    write_comtrade(tmp_path / "a.cfg", kind="BINARY")
    in_one_file(tmp_path / "a.cff")
    whole = (tmp_path / "a.cff").read_bytes()
    (tmp_path / "a.cff").write_bytes(whole[:-100])
    assert "must contain the 4000 samples that 'a.cff' declares, got 3993" in (
        refused(tmp_path / "a.cff")
    )
    (tmp_path / "a.cff").write_bytes(whole[:200])
    assert "must have the sections CFG and DAT of a COMTRADE record, got ['CFG']" in (
        refused(tmp_path / "a.cff")
    )


def test_comtrade_that_declares_more_channels_than_lines_is_refused(tmp_path: Path) -> None:
    """The library would make room for them first."""
    write_comtrade(tmp_path / "a.cfg", kind="BINARY")
    text = (tmp_path / "a.cfg").read_text()
    (tmp_path / "a.cfg").write_text(text.replace("4,3A,1D", "2000000001,2000000000A,1D"))
    assert "declares more channels than there are lines" in refused(tmp_path / "a.cfg")


def test_a_comtrade_head_in_latin_1_is_read(tmp_path: Path) -> None:
    write_comtrade(tmp_path / "a.cfg", kind="BINARY")
    text = (tmp_path / "a.cfg").read_text()
    (tmp_path / "a.cfg").write_bytes(text.replace(",um,", ",µm,").encode("latin-1"))
    assert read_signals(tmp_path / "a.cfg").x.attrs["units"] == "um"


@pytest.mark.parametrize("kind", ["ASCII", "BINARY"])
def test_comtrade_that_declares_more_than_it_holds_is_refused(kind: str, tmp_path: Path) -> None:
    write_comtrade(tmp_path / "a.cfg", kind=kind, size=10**12)
    message = refused(tmp_path / "a.cfg")
    assert "must contain the 1000000000000 samples that 'a.cfg' declares, got 4000" in message
    (tmp_path / "a.cfg").write_text("nonsense")
    assert "must be a COMTRADE record" in refused(tmp_path / "a.cfg")
    (tmp_path / "a.dat").unlink()
    assert "must have the .dat of its COMTRADE record with it" in refused(tmp_path / "a.cfg")


def test_a_dat_of_comtrade_alone_is_read_by_its_time_stamps(tmp_path: Path) -> None:
    """Its first column counts the samples, and is not the time."""
    write_comtrade(tmp_path / "a.cfg", kind="ASCII")
    (tmp_path / "a.cfg").unlink()
    found = read_signals(tmp_path / "a.dat", units={"t": "us"})
    np.testing.assert_allclose(found.t, TIMES, atol=1e-12)
    assert "column 1 counts samples and is left out" in found.attrs["notes"]


def write_hdf5(folder: Path, lines: str) -> None:
    """Write HDF5 in another process: h5py brings a second HDF5 library."""
    code = "import h5py, numpy as np\nd = np.load('all.npz')\n" + lines
    np.savez(folder / "all.npz", t=TIMES, a=A, b=B, pulse=PULSE, rpm=RPM)
    environment = {**os.environ, "PYTHONPATH": ""}
    subprocess.run([sys.executable, "-c", code], cwd=folder, check=True, env=environment)


def test_hdf5_comes_back_from_groups_with_units(tmp_path: Path) -> None:
    write_hdf5(
        tmp_path,
        """
with h5py.File('a.h5', 'w') as f:
    f['note'] = 'of a pump'
    f['fast/Probe A'] = d['a'].astype('f4'); f['fast/Probe A'].attrs['units'] = 'um'
    f['fast/Probe B'] = d['b'].astype('f4'); f['fast/Probe B'].attrs['units'] = 'um'
    f['fast/Time'] = d['t']; f['fast/Time'].attrs['units'] = 's'
    f['Speed [rpm]'] = d['rpm']
""",
    )
    found = read_signals(tmp_path / "a.h5", probe_angles=PROBES)
    check(found, to=1e-5)
    np.testing.assert_allclose(found.angle, TURN, rtol=0, atol=1e-9)
    assert "x=fast.Probe A y=fast.Probe B speed=Speed [rpm]" in found.attrs["columns"]
    assert "'no'" in refused(tmp_path / "a.h5", columns={"x": "no"})


HOSTILE = {
    "a link to a file": "f['x'] = h5py.ExternalLink('all.npz', '/t')",
    "a link in a group": "f.create_group('g/h')['x'] = h5py.SoftLink('/t')",
    "data in a file": "f.create_dataset('x', (9,), 'f8', external=[('all.npz', 0, 72)])",
    "groups in a circle": "f.create_group('a')['up'] = f",
    "groups in many circles": "g = f.create_group('a'); g['b'] = f; g['c'] = f; f['d'] = g",
    "terabytes": "f.create_dataset('x', shape=(10**13,), dtype='f8', chunks=(1000,))",
}  # fmt: skip
TOLD = {
    "a link to a file": "got '/x', which is a link",
    "a link in a group": "got '/g/h/x', which is a link",
    "data in a file": "got '/x', whose data are in another file",
    "groups in a circle": "nested over 32",
    "groups in many circles": "got more than 20000 parts, or one of them nested over 32",
    "terabytes": "must declare at most",
}


@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("ending", [".h5", ".mat"])
def test_hostile_hdf5_is_refused_before_it_is_read(kind: str, ending: str, tmp_path: Path) -> None:
    user = "userblock_size=512" if ending == ".mat" else ""
    write_hdf5(tmp_path, f"with h5py.File('a.h5', 'w', {user}) as f:\n    {HOSTILE[kind]}")
    if ending == ".mat":
        whole = (tmp_path / "a.h5").read_bytes()
        head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM"
        (tmp_path / "a.mat").write_bytes(head.ljust(512, b"\0") + whole[512:])
    assert TOLD[kind] in refused(tmp_path / f"a{ending}")


def test_damaged_hdf5_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    write_hdf5(tmp_path, "h5py.File('a.h5', 'w')['t'] = d['t']")
    whole = (tmp_path / "a.h5").read_bytes()
    for held in (whole[: len(whole) // 2], b"nonsense" * 100):
        (tmp_path / "a.h5").write_bytes(held)
        assert "must be an HDF5 file that can be read" in refused(tmp_path / "a.h5")
    assert capfd.readouterr().err == ""


def test_npz_comes_back_by_the_units_in_its_names(tmp_path: Path) -> None:
    np.savez_compressed(
        tmp_path / "a.npz", time_ms=1e3 * TIMES, probe_A_mm=1e-3 * A, probe_B_mm=1e-3 * B,
        tach_V=PULSE,
    )  # fmt: skip
    found = read_signals(tmp_path / "a.npz", probe_angles=PROBES)
    np.testing.assert_allclose(found.t, TIMES, rtol=0, atol=1e-12)
    np.testing.assert_allclose(1e3 * found.x, Z.real, rtol=0, atol=1e-9)
    assert found.x.attrs["units"] == "mm"
    check_pulses(found)


def test_npz_with_a_sampling_rate_and_no_times(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", x_um=Z.real, y_um=Z.imag, fs=RATE)
    found = read_signals(tmp_path / "a.npz")
    check(found)
    assert "times follow from the 2000 samples a second in fs" in found.attrs["notes"]


def test_npz_with_dates_counts_seconds_from_the_first(tmp_path: Path) -> None:
    times = np.datetime64("2024-02-28T23:59:59", "us") + np.rint(1e6 * TIMES).astype(int)
    np.savez(tmp_path / "a.npz", time=times, x_um=Z.real, y_um=Z.imag)
    check(read_signals(tmp_path / "a.npz"))


def test_npz_with_fields_is_read_by_their_names(tmp_path: Path) -> None:
    table = np.zeros(TIMES.size, dtype=[("t_s", "f8"), ("x_um", "f4"), ("y_um", "f8")])
    table["t_s"], table["x_um"], table["y_um"] = TIMES, Z.real, Z.imag
    np.savez(tmp_path / "a.npz", record=table)
    check(read_signals(tmp_path / "a.npz"), to=1e-5)


class Bomb:
    """What would write a file if it were unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str, str]]:
        return open, ("pickled", "w")


def test_npz_runs_nothing_and_believes_no_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "a.npz", x=np.array([Bomb(), 1], dtype=object))
    assert "got 'x (objects)'" in refused(tmp_path / "a.npz")
    assert not Path("pickled").exists()
    np.savez(tmp_path / "a.npz", x=A)
    whole = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(whole[: len(whole) // 2])
    assert "must be an .npz file" in refused(tmp_path / "a.npz")
    larger = whole.replace(b"(4000,)", b"(9**9,)").replace(b"(9**9,)", b"(9999,)")
    (tmp_path / "a.npz").write_bytes(larger)
    assert "declares the shape (9999,), but is shorter" in refused(tmp_path / "a.npz")


def test_nested_structures_of_matlab_are_read_by_their_last_names(tmp_path: Path) -> None:
    record = {"time_s": TIMES, "probes": {"A_um": A, "B_um": B}, "info": {"name": "pump", "n": 3.0}}
    savemat(tmp_path / "a.mat", {"rec": {"pump": record, "speed_rpm": RPM}})
    found = read_signals(tmp_path / "a.mat", probe_angles=PROBES)
    check(found)
    np.testing.assert_allclose(found.angle, TURN, rtol=0, atol=1e-9)
    assert "x=rec.pump.probes.A_um" in found.attrs["columns"]


def test_damaged_matlab_files_are_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"t": TIMES, "x": A, "y": B}, do_compression=True)
    whole = (tmp_path / "a.mat").read_bytes()
    for size in (100, 200, len(whole) // 2, len(whole) - 10):
        (tmp_path / "a.mat").write_bytes(whole[:size])
        assert "a.mat" in refused(tmp_path / "a.mat")
    rng = np.random.default_rng(3)
    for _ in range(20):
        held = bytearray(whole)
        held[int(rng.integers(128, len(held)))] ^= 0xFF
        (tmp_path / "a.mat").write_bytes(held)
        assert "\n" not in refused(tmp_path / "a.mat")


def test_a_wav_that_ends_early_is_refused(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", 2000, np.stack([A, B], axis=1).astype(np.float32))
    whole = (tmp_path / "a.wav").read_bytes()
    (tmp_path / "a.wav").write_bytes(whole[:30])
    assert "must be a WAV file" in refused(tmp_path / "a.wav")


@pytest.mark.parametrize(
    ("ending", "module", "package"),
    [("uff", "pyuff", "pyuff"), ("tdms", "nptdms", "npTDMS"), ("cfg", "comtrade", "comtrade")],
)
def test_a_library_that_is_not_installed_is_named(
    ending: str, module: str, package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_comtrade(tmp_path / "a.cfg", kind="ASCII")
    if ending != "cfg":
        (tmp_path / f"a.{ending}").write_bytes(b"")
    monkeypatch.setitem(sys.modules, module, None)
    message = refused(tmp_path / f"a.{ending}")
    assert message.endswith(f"files needs {package}: pip install 'rotor-ida[signals]'")


def test_a_column_of_times_counts_more_than_a_sampling_rate(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t_s=TIMES, x_um=Z.real, y_um=Z.imag, fs=17.0)
    found = read_signals(tmp_path / "a.npz")
    check(found)
    assert "samples a second" not in found.attrs["notes"]
