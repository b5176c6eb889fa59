"""Files of recorders come back as they were written; damaged ones are refused in one line."""

from __future__ import annotations

import gc
import math
import os
import struct
import subprocess
import sys
import warnings
from collections.abc import Callable
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
    """Compare signals with the whirl that the probes saw."""
    scale = {"um": 1.0, "mm": 1e3}[unit]
    np.testing.assert_allclose(found.t, TIMES, rtol=0, atol=1e-9)
    np.testing.assert_allclose(scale * found.x, Z.real, rtol=0, atol=to)
    np.testing.assert_allclose(scale * found.y, Z.imag, rtol=0, atol=to)
    assert (found.t.attrs["units"], found.x.attrs["units"]) == ("s", unit)


def check_pulses(found: xr.Dataset) -> None:
    """Compare the pulses with those of the mark, half a sample apart at most."""
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


def test_tdms_channels_of_another_rate_are_listed_and_not_guessed(tmp_path: Path) -> None:
    write_tdms(tmp_path / "a.tdms", **{"Probe A": np.arange(20.0), "Probe B": np.arange(20.0)})
    check(read_signals(tmp_path / "a.tdms", probe_angles=PROBES))
    assert "slow.Probe B" in refused(tmp_path / "a.tdms", columns={"x": "none"})
    columns = {"x": "run.Probe A", "y": "slow.Probe B"}
    assert "x and y must have one sampling rate, got 2000 and 1 samples a second" in (
        refused(tmp_path / "a.tdms", columns=columns, units={"y": "um"})
    )


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


def write_combined(path: Path, *, kind: str = "BINARY", end: str = "\r\n") -> None:
    write_comtrade(path.with_suffix(".cfg"), kind=kind)
    in_one_file(path, end=end)
    for ending in (".cfg", ".dat"):
        path.with_suffix(ending).unlink()


def write_wav(path: Path, kind: str = "int16") -> None:
    wavfile.write(path, 2000, np.stack([A, B], axis=1).astype(kind))


def test_a_dat_of_comtrade_alone_is_read_by_its_time_stamps(tmp_path: Path) -> None:
    """Its first column counts the samples, and is not the time."""
    write_comtrade(tmp_path / "a.cfg", kind="ASCII")
    (tmp_path / "a.cfg").unlink()
    found = read_signals(tmp_path / "a.dat", units={"t": "us"})
    np.testing.assert_allclose(found.t, TIMES, atol=1e-12)
    assert "column 1 counts samples and is left out" in found.attrs["notes"]


class Bomb:
    """What would write a file if it were unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str, str]]:
        return open, ("pickled", "w")


def test_npz_runs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "a.npz", x=np.array([Bomb(), 1], dtype=object))
    assert "got 'x (objects)'" in refused(tmp_path / "a.npz")
    assert not Path("pickled").exists()


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


def write_hdf5(folder: Path, lines: str) -> None:
    """Write HDF5 in another process: h5py brings a second HDF5 library."""
    code = "import h5py, numpy as np\nd = np.load('all.npz')\n" + lines
    np.savez(folder / "all.npz", t=TIMES, a=A, b=B, pulse=PULSE, rpm=RPM)
    environment = {**os.environ, "PYTHONPATH": ""}
    subprocess.run([sys.executable, "-c", code], cwd=folder, check=True, env=environment)


IN_GROUPS = """
with h5py.File('a.h5', 'w') as f:
    f['note'] = 'of a pump'
    f['fast/Probe A'] = d['a'].astype('f4'); f['fast/Probe A'].attrs['units'] = 'um'
    f['fast/Probe B'] = d['b'].astype('f4'); f['fast/Probe B'].attrs['units'] = 'um'
    f['fast/Time'] = d['t']; f['fast/Time'].attrs['units'] = 's'
    f['Speed [rpm]'] = d['rpm']
"""


def write_fields(path: Path) -> None:
    table = np.zeros(TIMES.size, dtype=[("t_s", "f8"), ("x_um", "f4"), ("y_um", "f8")])
    table["t_s"], table["x_um"], table["y_um"] = TIMES, A, B
    np.savez(path, record=table)


def write_in_latin_1(path: Path) -> None:
    write_comtrade(path, kind="BINARY")
    path.write_bytes(path.read_text().replace(",um,", ",µm,").encode("latin-1"))


DATES = np.datetime64("2024-02-28T23:59:59", "us") + np.rint(1e6 * TIMES).astype(int)
NESTED = {"time_s": TIMES, "probes": {"A_um": A, "B_um": B}, "info": {"name": "pump", "n": 3.0}}
PAIR = {"x_um": A, "y_um": B}
KEYED, SPEEDED = "keyphasor=", "speed="
# What is written: a file, the tolerance, what its columns are, and options of the reader.
WRITTEN: dict[str, tuple[str, Callable[[Path], object], float, str, dict[str, object]]] = {
    **{
        f"UFF, binary {binary}": (
            "a.uff", lambda path, binary=binary: write_uff(path, binary=binary), 1e-9,
            "t=t x=Probe A y=Probe B keyphasor=Keyphasor", {},
        )
        for binary in (0, 1)
    },
    "UFF without titles": (
        "a.unv", lambda path: write_uff(path, binary=0, columns={"NONE": A, "none": B}), 1e-9,
        "x=node 1 x y=node 2 x", {"columns": {"x": "node 1 x", "y": "node 2 x"}},
    ),
    "TDMS": ("a.tdms", write_tdms, 1e-9, SPEEDED, {}),
    **{
        f"LabVIEW, {columns} column of times, point {point}, parts {parts}": (
            "a.lvm", lambda path, given=(columns, point, parts): write_lvm(
                path, columns=given[0], point=given[1], parts=given[2]), 1e-8, SPEEDED, {},
        )
        for columns in ("One", "No") for point, parts in ((".", 1), (",", 1), (".", 3))
    },
    "LabVIEW without a head": (
        "a.lvm", lambda path: np.savetxt(path, np.column_stack([TIMES, A, B]), "%.12f", "\t"),
        1e-9, "t=1 x=2 y=3", {"units": {"t": "s", "x": "um", "y": "um"}},
    ),
    # of counts of 2 nm
    **{
        f"COMTRADE, {kind} by {ending}": (
            f"a{ending}", lambda path, kind=kind: write_comtrade(
                path.with_suffix(".cfg"), kind=kind), 0.002, KEYED, {},
        )
        for kind in ("ASCII", "BINARY") for ending in (".cfg", ".dat")
    },
    **{
        f"COMTRADE in one file, {kind}, {end!r}": (
            "a.cff", lambda path, given=(kind, end): write_combined(
                path, kind=given[0], end=given[1]), 0.002, KEYED, {},
        )
        for kind in ("ASCII", "BINARY") for end in ("\n", "\r\n")
    },
    "COMTRADE, a head in latin-1": ("a.cfg", write_in_latin_1, 0.002, KEYED, {}),
    "HDF5 in groups": (
        "a.h5", lambda path: write_hdf5(path.parent, IN_GROUPS), 1e-5,
        "x=fast.Probe A y=fast.Probe B speed=Speed [rpm]", {},
    ),
    "NPZ with units in its names": (
        "a.npz", lambda path: np.savez_compressed(
            path, time_ms=1e3 * TIMES, probe_A_mm=1e-3 * A, probe_B_mm=1e-3 * B, tach_V=PULSE
        ), 1e-9, KEYED, {},
    ),
    "NPZ with a sampling rate and no times": (
        "a.npz", lambda path: np.savez(path, **PAIR, fs=RATE), 1e-9, "x=x_um y=y_um", {},
    ),
    "NPZ with times and a rate": (
        "a.npz", lambda path: np.savez(path, t_s=TIMES, **PAIR, fs=17.0), 1e-9, "t=t_s", {},
    ),
    "NPZ with dates": (
        "a.npz", lambda path: np.savez(path, time=DATES, **PAIR), 1e-9, "t=time", {},
    ),
    "NPZ with fields": ("a.npz", write_fields, 1e-5, "x=record.x_um", {}),
    "MATLAB, nested": (
        "a.mat", lambda path: savemat(path, {"rec": {"pump": NESTED, "speed_rpm": RPM}}), 1e-9,
        "x=rec.pump.probes.A_um", {},
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRITTEN)
def test_what_was_written_comes_back_with_units_names_and_turns(kind: str, tmp_path: Path) -> None:
    name, write, to, columns, options = WRITTEN[kind]
    write(tmp_path / name)
    found = read_signals(tmp_path / name, probe_angles=PROBES, **options)  # type: ignore[arg-type]
    check(found, to=to, unit="mm" if "units in its names" in kind else "um")
    assert columns in found.attrs["columns"]
    assert found.attrs["file"] == name
    assert (KEYED in found.attrs["columns"]) == ("keyphasor" in found)
    assert (SPEEDED in found.attrs["columns"]) == ("angle" in found)
    if "keyphasor" in found:
        check_pulses(found)
    if "angle" in found:
        np.testing.assert_allclose(found.angle, TURN, rtol=0, atol=1e-8)
    told = "times follow from the 2000 samples a second in fs" in found.attrs.get("notes", "")
    assert told == ("and no times" in kind)


def cut(size: float) -> Callable[[bytes], bytes]:
    """Return a cut that keeps the first bytes of a file: a number, or a part below 1."""
    return lambda whole: whole[: int(size * len(whole)) if 0.0 < size < 1.0 else int(size)]


def replaced(old: bytes, new: bytes) -> Callable[[bytes], bytes]:
    return lambda whole: whole.replace(old, new)


def zeroed(at: int, count: int) -> Callable[[bytes], bytes]:
    return lambda whole: whole[:at] + bytes(count) + whole[at + count :]


def of_class(kind: int) -> Callable[[bytes], bytes]:
    """Return what gives the first array of a MATLAB file another class than double."""
    return lambda whole: whole[: 128 + 8 + 8] + bytes([kind]) + whole[128 + 8 + 9 :]


def nonsense(_whole: bytes) -> bytes:
    return b"nonsense" * 100


def binary_comtrade(path: Path) -> None:
    write_comtrade(path, kind="BINARY")


def write_mat(path: Path) -> None:
    savemat(path, {"t": TIMES, "x": A, "y": B})


WAV = "must be a WAV file"
Damage = Callable[[bytes], bytes]
DAMAGED: tuple[tuple[str, Callable[[Path], object], Damage, str], ...] = (
    *(
        ("a.uff", lambda path, binary=binary: write_uff(path, binary=binary), cut(part),
         "must be a universal file (UFF)")
        for binary, part in ((0, 0.5), (1, 0.2), (1, 0.9))
    ),
    ("a.tdms", write_tdms, cut(300), "must contain channels"),
    ("a.tdms", write_tdms, cut(0.5), "got one that ends early"),
    ("a.tdms", write_tdms, nonsense, "must be a TDMS file"),
    ("a.lvm", lambda path: path.write_text("LabVIEW Measurement\t\nSeparator\tTab\n"), bytes,
     "must have a header that ends in ***End_of_Header***"),
    ("a.lvm", lambda path: path.write_text(LVM_HEAD.format(point=".", columns="One")), bytes,
     "must contain a segment with the line X_Value, got none"),
    ("a.lvm", lambda path: write_lvm(path, columns="One"), replaced(b"\n0.011000", b"\n?"),
     "must contain finite numbers, got nan in line 41"),
    ("a.cff", write_combined, cut(-100),
     "must contain the 4000 samples that 'a.cff' declares, got 3993"),
    ("a.cff", write_combined, cut(200),
     "must have the sections CFG and DAT of a COMTRADE record, got ['CFG']"),
    # the library would make room for them first
    ("a.cfg", binary_comtrade, replaced(b"4,3A,1D", b"2000000001,2000000000A,1D"),
     "declares more channels than there are lines"),
    *(
        ("a.cfg", lambda path, kind=kind: write_comtrade(path, kind=kind, size=10**12), bytes,
         "must contain the 1000000000000 samples that 'a.cfg' declares, got 4000")
        for kind in ("ASCII", "BINARY")
    ),
    ("a.cfg", binary_comtrade, nonsense, "must be a COMTRADE record"),
    ("a.cfg", lambda path: (binary_comtrade(path), path.with_suffix(".dat").unlink()), bytes,
     "must have the .dat of its COMTRADE record with it"),
    ("a.h5", lambda path: write_hdf5(path.parent, IN_GROUPS), cut(0.5),
     "must be an HDF5 file that can be read"),
    ("a.h5", lambda path: path.touch(), nonsense, "must be an HDF5 file that can be read"),
    # SciPy looks such a class up past the end of its table, and may end the process
    ("a.mat", write_mat, of_class(200), "of another type"),
    ("a.mat", write_mat, cut(0.5), "a.mat"),
    ("a.npz", lambda path: np.savez(path, x=A), cut(0.5), "must be an .npz file"),
    ("a.npz", lambda path: np.savez(path, x=A), replaced(b"(4000,)", b"(9999,)"),
     "declares the shape (9999,), but is shorter"),
    ("a.wav", write_wav, zeroed(24, 8), "it has 8000 samples and 0 a second"),
    ("a.wav", write_wav, zeroed(40, 4), "it has 0 samples and 2000 a second"),
    *(("a.wav", write_wav, zeroed(at, size), WAV) for at, size in ((22, 2), (32, 2), (4, 4))),
    ("a.wav", write_wav, cut(4000), f"{WAV}: Reached EOF prematurely"),
    ("a.wav", write_wav, cut(30), WAV),
)  # fmt: skip


@pytest.mark.parametrize("case", range(len(DAMAGED)))
def test_a_damaged_file_is_refused_in_one_line(
    case: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    name, write, damage, told = DAMAGED[case]
    path = tmp_path / name
    write(path)
    path.write_bytes(damage(path.read_bytes()))
    columns = {"a.wav": {"x": "1", "y": "2"}, "a.mat": {"t": "t"}}.get(name)
    assert told in refused(path, columns=columns)
    assert capfd.readouterr() == ("", "")


HOSTILE = {
    "a link to a file": ("f['x'] = h5py.ExternalLink('all.npz', '/t')", "got '/x', which is a lin"),
    "a link in a group": (
        "f.create_group('g/h')['x'] = h5py.SoftLink('/t')", "got '/g/h/x', which is a link",
    ),
    "data in a file": (
        "f.create_dataset('x', (9,), 'f8', external=[('all.npz', 0, 72)])",
        "got '/x', whose data are in another file",
    ),
    "groups in a circle": ("f.create_group('a')['up'] = f", "nested over 32"),
    "groups in many circles": (
        "g = f.create_group('a'); g['b'] = f; g['c'] = f; f['d'] = g",
        "got more than 20000 parts, or one of them nested over 32",
    ),
    "terabytes": (
        "f.create_dataset('x', shape=(10**13,), dtype='f8', chunks=(1000,))",
        "must declare at most",
    ),
}  # fmt: skip


@pytest.fixture(scope="session")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with each of these as HDF5 and as MATLAB's, written by one process."""
    folder = tmp_path_factory.mktemp("hostile")
    write_hdf5(folder, "\n".join(
        f"with h5py.File('{kind}{ending}', 'w', userblock_size={user}) as f:\n    {line}"
        for kind, (line, _) in HOSTILE.items() for ending, user in ((".h5", 0), (".mat", 512))
    ))  # fmt: skip
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM"
    for path in folder.glob("*.mat"):
        path.write_bytes(head.ljust(512, b"\0") + path.read_bytes()[512:])
    return folder


# what MATLAB writes is looked through by the same process
@pytest.mark.parametrize(
    ("kind", "ending"), [*((kind, ".h5") for kind in HOSTILE), ("terabytes", ".mat")]
)
def test_hostile_hdf5_is_refused_before_it_is_read(kind: str, ending: str, hostile: Path) -> None:
    assert HOSTILE[kind][1] in refused(hostile / f"{kind}{ending}")
