"""Files of instruments: what they hold comes back; what is wrong with one is told with where."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.io import savemat, wavfile

from rotor_ida import InputError, orders, read_signals

TURN = 2.0 * math.pi * 10.0  # rad/s
TIMES = np.arange(4000) / 2000.0
X, Y = 40.0 * np.cos(TURN * TIMES), 40.0 * np.sin(TURN * TIMES)
COLUMNS = (TIMES, X, Y, TURN * TIMES)


def text_of(separator=",", *, comma=False, columns=COLUMNS, digits=9):
    """Return lines of numbers."""
    lines = [
        separator.join(f"{cell:.{digits}f}" for cell in row) for row in zip(*columns, strict=True)
    ]
    text = "\n".join(lines)
    return text.replace(".", ",") if comma else text


BODY = text_of()


def read(folder, text, *, name="probes.csv", encoding="utf-8", **options):
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return read_signals(path, **options)


def check(found, atol=1e-8):
    """Hold signals against those that were written."""
    np.testing.assert_allclose(found.t, TIMES, rtol=0, atol=atol)
    np.testing.assert_allclose(found.x + found.mean_x, X, rtol=0, atol=atol)
    np.testing.assert_allclose(found.y + found.mean_y, Y, rtol=0, atol=atol)
    np.testing.assert_allclose(found.angle, TURN * TIMES, rtol=0, atol=atol)


HEAD = "t [s],x [um],y [um],angle [rad]\n"
WRITTEN = {
    "commas": HEAD + BODY,
    "blanks between": "t x y angle\n" + text_of(" "),
    "decimal commas, semicolons": HEAD.replace(",", ";") + text_of(";", comma=True),
    "decimal commas, tabs": HEAD.replace(",", "\t") + text_of("\t", comma=True),
    "windows line ends": (HEAD + BODY).replace("\n", "\r\n"),
    "byte-order mark": "\ufeff" + HEAD + BODY,
    "separator behind the last": (HEAD + BODY).replace("\n", ",\n") + ",",
    "instrument's words before": f"Recorder 7\nOperator: none\n\n{HEAD}{BODY}",
    "comments": f"# a machine\n# at rest\n{HEAD}{BODY}\n# end\n",
    "names in a comment": f"# {HEAD}{BODY}",
    "units in a line": f"t,x,y,angle\ns,um,um,rad\n{BODY}",
    "quotes": '"t [s]","x [um]","y [um]","angle [rad]"\n' + BODY,
    "blank lines at the end": f"{HEAD}{BODY}\n\n\n",
}


@pytest.mark.parametrize("kind", WRITTEN)
def test_a_table_comes_back_however_it_is_written(kind, tmp_path):
    check(read(tmp_path, WRITTEN[kind]))


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-16"])
def test_micrometres_are_read_in_any_encoding(encoding, tmp_path):
    found = read(tmp_path, HEAD.replace("um", "µm") + BODY, encoding=encoding)
    check(found)
    assert found.x.attrs["units"] == "um"


def test_numbers_without_a_head_are_t_x_y_and_keyphasor(tmp_path):
    pulse = (TURN * TIMES + 0.01) % (2.0 * math.pi) < 0.5
    found = read(tmp_path, text_of(columns=(TIMES, X, Y, pulse)))
    np.testing.assert_array_equal(found.x, np.round(X, 9))
    np.testing.assert_allclose(np.diff(found.keyphasor), 0.1, atol=1e-6)
    assert found.attrs["columns"].endswith("(guessed: t x y keyphasor)")


@pytest.mark.parametrize(("unit", "size"), [("mil", 25.4), ("um", 1.0), ("mm", 1.0), ("in", 25.4)])
def test_units_are_turned_into_those_of_the_system(unit, size, tmp_path):
    head = f"time [ms],x [{unit}],y [{unit}],angle [deg]\n"
    columns = (1e3 * TIMES, X, Y, np.degrees(TURN * TIMES))
    found = read(tmp_path, head + text_of(columns=columns))
    np.testing.assert_allclose(found.t, TIMES, atol=1e-12)
    np.testing.assert_allclose(found.x, size * X, atol=1e-7)
    np.testing.assert_allclose(found.angle, TURN * TIMES, atol=1e-9)
    assert found.t.attrs["units"] == "s"
    assert found.x.attrs["units"] == ("mm" if unit in ("mm", "in") else "um")


def test_times_with_few_digits_are_evenly_spaced(tmp_path):
    """51.2 kHz to five decimals: steps of one and two in the last place, of 1.953125e-5 s."""
    times = np.arange(40_000) / 51_200.0
    columns = (np.cos(TURN * times), np.sin(TURN * times), TURN * times)
    table = "\n".join(
        ",".join([f"{t:.5f}", *(f"{cell:.9f}" for cell in row)])
        for t, *row in zip(times, *columns, strict=True)
    )
    found = read(tmp_path, HEAD + table)
    steps = np.diff(found.t)
    np.testing.assert_allclose(steps, 1.0 / 51_200.0, rtol=1e-6)
    np.testing.assert_allclose(found.t, times, rtol=0, atol=2e-8)
    assert "evenly spaced" in found.attrs["times"]
    # as long as they are, the orders are those of exact times
    once = orders(found).forward_whirl_amplitude.sel(order=1)
    np.testing.assert_allclose(once, 1.0, atol=1e-6)


def test_times_that_are_uneven_stay_as_they_are(tmp_path):
    times = TIMES + 1e-4 * np.sin(3.0 * TIMES)
    found = read(tmp_path, HEAD + text_of(columns=(times, X, Y, TURN * times)))
    np.testing.assert_allclose(found.t, times, atol=1e-9)
    assert "times" not in found.attrs


def test_times_of_single_precision_are_evenly_spaced(tmp_path):
    """A recorder's single precision leaves steps of 0.5 ms wrong by 1.5 % after 100 s."""
    times = 100.0 + TIMES
    savemat(tmp_path / "a.mat", {"t": times.astype(np.float32), "x": X, "y": Y})
    found = read_signals(tmp_path / "a.mat")
    np.testing.assert_allclose(np.diff(found.t), 1.0 / 2000.0, rtol=1e-6)


def test_pulses_in_a_column_shorter_than_the_samples(tmp_path):
    """Times of pulses beside the samples leave the rest of their column empty."""
    pulses = [f"{0.1 * n:.6f}" for n in range(20)]
    pulses += [""] * (TIMES.size - len(pulses))
    lines = BODY.splitlines()
    table = "\n".join(
        f"{line.rsplit(',', 1)[0]},{pulse}" for line, pulse in zip(lines, pulses, strict=True)
    )
    found = read(tmp_path, "t [s],x,y,keyphasor [s]\n" + table, units={"x": "um", "y": "um"})
    np.testing.assert_allclose(found.keyphasor, 0.1 * np.arange(20), atol=1e-9)
    assert found.keyphasor.attrs["units"] == "s"


def test_columns_of_one_name_are_told_apart_by_number(tmp_path):
    found = read(tmp_path, "t,probe,probe,angle\n" + BODY,
                 columns={"x": "probe (1)", "y": "probe (2)"})  # fmt: skip
    check(found)


COUNT = np.arange(1.0, TIMES.size + 1.0)


@pytest.mark.parametrize("first", [0, 1])
def test_a_first_column_that_counts_samples_is_not_the_time(first, tmp_path):
    columns = (COUNT - 1 + first, TIMES, X, Y, (TURN * TIMES + 0.01) % (2.0 * math.pi) < 0.5)
    table = "\n".join(
        ",".join([f"{row[0]:.0f}", *(f"{cell:.9f}" for cell in row[1:])])
        for row in zip(*columns, strict=True)
    )
    found = read(tmp_path, table)
    np.testing.assert_allclose(found.t, TIMES, atol=1e-9)
    np.testing.assert_allclose(found.y, Y, atol=1e-8)
    assert found.attrs["notes"].startswith("column 1 counts samples and is left out")
    assert found.attrs["columns"] == "t=2 x=3 y=4 keyphasor=5 (guessed: t x y keyphasor)"


def test_a_count_of_samples_without_times_is_refused_unless_told_or_a_rate_given(tmp_path):
    table = text_of(columns=(COUNT, X, Y))
    with pytest.raises(InputError, match=r"column 1 counts samples \(0, 1, 2 ...\); name t in"):
        read(tmp_path, table)
    by_rate = read(tmp_path, table, rate=2000.0)
    np.testing.assert_allclose(by_rate.t, TIMES, atol=1e-12)
    np.testing.assert_allclose(by_rate.x, X, atol=1e-8)
    told = read(tmp_path, table, columns={"t": "1"}, units={"t": "ms"})
    np.testing.assert_allclose(told.t, 1e-3 * COUNT, atol=1e-12)


COMMAS = {
    "thousands or decimals": (
        "t;x;y\n" + "\n".join(f"{n};1,{n + 100};2,{n + 100}" for n in range(1, 30)),
        "must show whether its commas are decimal or between thousands, got '1,101' in line 2",
    ),
    "decimals between commas": (
        "\n".join(f"0,{n:03d},1,{n % 7:03d},2,{n % 5:03d}" for n in range(200)),
        "must not have decimal commas in columns that are separated by commas, got '0,000' in "
        "line 1",
    ),
    "thousands and decimals": (
        "t;x;y\n" + "\n".join(f"{n}.0;1,234.5;{n % 7}.25" for n in range(30)),
        "column 'x' must contain finite numbers, got '1,234.5' in line 2",
    ),
    "points between thousands": (
        "t;x;y\n" + "\n".join(f"{n},0;1.234,5;{n % 7},25" for n in range(30)),
        "column 'x' must contain finite numbers, got '1.234,5' in line 2",
    ),
}


@pytest.mark.parametrize("kind", COMMAS)
def test_commas_that_may_be_several_things_are_refused_with_line_and_value(kind, tmp_path):
    text, told = COMMAS[kind]
    with pytest.raises(InputError, match=re.escape(told)):
        read(tmp_path, text)


def test_one_number_that_is_no_group_of_thousands_shows_decimal_commas(tmp_path):
    rows = [f"{n};{n % 7},250;{1 + n % 5},500" for n in range(1, 40)]
    text = "t;x;y\n" + "\n".join([*rows, "40;0,250;1,500"])
    found = read(tmp_path, text, gap="0")
    assert found.x.values[0] == 1.25
    with pytest.raises(InputError, match="between thousands, got '1,250' in line 2"):
        read(tmp_path, "t;x;y\n" + "\n".join(row.replace(";0,250", ";7,250") for row in rows))


def changed(row, column, cell):
    """Return the table with another cell in a row, from 0."""
    lines = BODY.splitlines()
    cells = lines[row].split(",")
    cells[column] = cell
    lines[row] = ",".join(cells)
    return HEAD + "\n".join(lines)


ODD = {
    "empty": ("", "must have lines of two numbers or more, got an empty file"),
    "words": ("nothing\nof use\n", "must have lines of two numbers or more, got none, but"),
    "one row": (HEAD + BODY.splitlines()[0], "must have at least 16 samples, got 1"),
    "no y": (HEAD.replace("y", "q") + BODY,
             "must have a column for y; name it in columns, got 't, x, q, angle'"),
    "a blank": (changed(41, 1, ""), "column 'x' must contain finite numbers, got '' in line 43"),
    "a word": (changed(41, 2, "over"),
               "column 'y' must contain finite numbers, got 'over' in line 43"),
    "nan": (changed(41, 2, "NaN"), "column 'y' must contain finite numbers, got 'NaN' in line 43"),
    "a cell less": (HEAD + BODY.replace(BODY.splitlines()[41], "0.0205,1,2"),
                    "line 43 of"),
    "time back": (changed(41, 0, "0.001"), "t must increase, got '0.001' in line 43 after"),
    "time again": (changed(41, 0, "0.020"), "t must increase, got '0.020' in line 43 after"),
    "a gap": (HEAD + "\n".join(np.delete(BODY.splitlines(), [50, 51]).tolist()),
              "t must have no gaps, got one of 0.0015 after '0.024500000' in line 51"),
    "unknown unit": (HEAD.replace("x [um]", "x [furlong]") + BODY,
                     "the unit of x must be one of m, mm, um, nm, in, mil, V, mV, got 'furlong' in "
                     "the column 'x'; give it in units"),
    "unknown unit in a line": (f"t,x,y,angle\ns,furlong,um,rad\n{BODY}",
                               "got 'furlong' in the column 'x'; give it in units"),
    "two units": (HEAD.replace("x [um]", "x [mm]") + BODY,
                  "x and y must be in one unit, got mm and um"),
    "bytes": ("\0\1\2\3" * 100,
              "must be text, got other bytes; files of recorders are recognised by their endings"),
}  # fmt: skip


@pytest.mark.parametrize("kind", ODD)
def test_odd_tables_are_told_in_one_line_with_where(kind, tmp_path):
    text, told = ODD[kind]
    with pytest.raises(InputError, match=re.escape(told)) as raised:
        read(tmp_path, text)
    assert "\n" not in str(raised.value)


def test_clipped_probes_are_told_and_taken_if_asked(tmp_path):
    clipped = text_of(columns=(TIMES, np.minimum(X, 30.0), Y, TURN * TIMES))
    with pytest.raises(InputError, match=r"x must not be clipped, but stays at 30 from t 0"):
        read(tmp_path, HEAD + clipped.split("\n", 120)[-1])
    found = read(tmp_path, HEAD + clipped, accept_clipped=True, gap="0")
    assert found.x.max() == 30.0


def test_matrices_and_structures_of_matlab(tmp_path):
    table = np.column_stack(COLUMNS)
    names = {"t": "1", "x": "2", "y": "3", "angle": "4"}
    savemat(tmp_path / "matrix.mat", {"data": table})
    check(read_signals(tmp_path / "matrix.mat", columns=names))
    savemat(tmp_path / "wide.mat", {"data": table.T, "note": "of a machine"})
    check(read_signals(tmp_path / "wide.mat", columns=names))
    savemat(tmp_path / "struct.mat", {"rec": dict(zip("txya", COLUMNS, strict=True))})
    check(read_signals(tmp_path / "struct.mat", columns={"t": "rec.t", "x": "rec.x", "y": "rec.y",
                                                         "angle": "rec.a"}))  # fmt: skip


def test_what_a_matlab_file_holds_is_listed(tmp_path):
    savemat(tmp_path / "a.mat", {"voltages": X, "note": "of a machine"})
    with pytest.raises(
        InputError, match=r"column for x and y; .*got 'voltages; and note \(text\)'"
    ):
        read_signals(tmp_path / "a.mat")
    savemat(tmp_path / "b.mat", {"note": "of a machine"})
    with pytest.raises(InputError, match=r"must contain vectors or matrices of numbers, got 'note"):
        read_signals(tmp_path / "b.mat")
    (tmp_path / "c.mat").write_bytes(b"no matlab file at all" * 20)
    with pytest.raises(InputError, match="must be a MATLAB file"):
        read_signals(tmp_path / "c.mat")


def test_matlab_files_of_version_7_3_are_read(tmp_path):
    """They are HDF5, with dimensions counted from the other end."""
    from netCDF4 import Dataset

    with Dataset(tmp_path / "new.mat", "w") as file:
        file.createDimension("one", 1)
        file.createDimension("n", TIMES.size)
        for name, values in zip(("t", "x", "y", "angle"), COLUMNS, strict=True):
            held = file.createVariable(name, "f8", ("one", "n"))
            held[0] = values
            held.MATLAB_class = "double"
    content = (tmp_path / "new.mat").read_bytes()
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM"
    (tmp_path / "marked.mat").write_bytes(head.ljust(512, b"\0") + content)
    check(read_signals(tmp_path / "marked.mat"))


@pytest.mark.parametrize("kind", ["int16", "int32", "uint8", "float32"])
def test_sound_files_count_from_full_scale(kind, tmp_path):
    """Half of full scale is 0.5 in every sample format; a gain turns it into displacement."""
    whirl = 0.5 * np.stack([X, Y], axis=1) / 40.0
    full = {"int16": 2**15, "int32": 2**31, "uint8": 2**7}.get(kind, 1)
    data = whirl * full + (128 if kind == "uint8" else 0)
    data = data if kind == "float32" else np.rint(data)
    wavfile.write(tmp_path / "a.wav", 2000, data.astype(kind))
    found = read_signals(tmp_path / "a.wav", columns={"x": "1", "y": "2"},
                         units={"x": "um", "y": "um"},
                         gains=(0.5 / 40.0, 0.5 / 40.0))  # fmt: skip
    np.testing.assert_allclose(found.x, X, atol=80.0 / full if kind != "float32" else 1e-5)
    np.testing.assert_allclose(found.t, TIMES, atol=1e-12)


def test_sampling_too_slow_for_an_order_is_told(tmp_path):
    found = read(tmp_path, HEAD + "\n".join(BODY.splitlines()[::40]))
    with pytest.raises(InputError, match=r"more than 7 samples a revolution for order 3, got 5"):
        orders(found, [3])


def test_blanks_after_signs_belong_to_the_number(tmp_path):
    def signed(value):
        return f"{'+' if value >= 0.0 else '-'} {abs(value):.9f}"

    for separator in (",", ";", " "):
        head = separator.join(("t", "x", "y", "angle"))
        rows = zip(*COLUMNS, strict=True)
        body = "\n".join(
            separator.join((f"{t:.9f}", signed(x), signed(y), f"{angle:.9f}"))
            for t, x, y, angle in rows
        )
        check(read(tmp_path, f"{head}\n{body}"))


@pytest.mark.parametrize("head", ["Date;Time;Microseconds", "Date;Time;Time_us", "Time;us"])
def test_dates_times_and_microseconds_in_columns_of_their_own(head, tmp_path):
    """Over midnight, so that the times of day alone fall."""
    rows = []
    for t, *others in zip(*COLUMNS, strict=True):
        number = round(1e6 * t) + 86_398_500_000
        second, part = divmod(number, 1_000_000)
        day, second = divmod(second, 86_400)
        clock = f"{second // 3600:02d}:{second // 60 % 60:02d}:{second % 60:02d}"
        cells = [f"{28 + day}.02.2024"] * head.startswith("Date") + [clock, str(part)]
        rows.append(";".join([*cells, *(f"{each:.9f}" for each in others)]))
    check(read(tmp_path, f"{head};x [um];y [um];angle [rad]\n" + "\n".join(rows)))
