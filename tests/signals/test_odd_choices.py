"""Odd choices, cells and heads of `read_signals` are refused, or read as they are meant."""

from __future__ import annotations

import time

import numpy as np
import pytest

from rotor_ida import InputError, read_signals
from rotor_ida.signals.files.clock import seconds_of
from rotor_ida.signals.files.columns import name_and_unit, unit_called

TIMES = np.arange(400) / 1000.0
X, Y = np.cos(60.0 * TIMES), np.sin(60.0 * TIMES)
HEAD = "t [s],x [um],y [um]"


def written(folder, head=HEAD, *, times=None, x=X, y=Y):
    """Write a table, with times as numbers or as words, and return its path."""
    cells = [f"{each:.6f}" for each in TIMES] if times is None else times
    rows = [f"{cell},{a!s},{b!s}" for cell, a, b in zip(cells, x, y, strict=True)]
    path = folder / "a.csv"
    path.write_text("\n".join([head, *rows]), encoding="utf-8")
    return path


def test_units_are_known_in_other_cases_but_a_capital_is_no_small_prefix():
    for unit in ("Ms", "Mm", "MV", "Mv", "Ps", "Nm", "Ns", "Pm"):
        assert unit_called(unit) is None
    for unit, plain in (("MS", "s"), ("MM", "mm"), ("Mils", "um"), ("mv", "mV"), ("MIN", "s")):
        assert unit_called(unit).plain == plain


def test_a_unit_after_slashes_is_none_of_which_only_the_end_is_known():
    assert name_and_unit("DE/Speed/rad/s") == ("DE/Speed", "rad/s")
    for name in ("Velocity/mm/s", "v / m/s", "flow/l/min", "K/N/m"):
        assert name_and_unit(name) == (name, "")


def test_a_rate_that_contradicts_the_times_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"rate must agree .* 't', which are 1000 samples a sec"):
        read_signals(written(tmp_path), rate=2000.0)
    found = read_signals(written(tmp_path), rate=1001.0)
    np.testing.assert_allclose(found.t, np.arange(400) / 1001.0, rtol=1e-12)
    assert "the column t is not used, as rate is given" in found.attrs["notes"]
    assert "t=" not in found.attrs["columns"].split()[0]
    in_ms = written(tmp_path, "t [ms],x [um],y [um]", times=[f"{1e3 * each:.3f}" for each in TIMES])
    assert read_signals(in_ms, rate=1000.0).sizes["t"] == 400


@pytest.mark.parametrize("kind", ["a clock that repeats", "a count", "words"])
def test_a_rate_replaces_a_column_that_is_no_time(kind, tmp_path):
    times = {
        "a clock that repeats": [f"{each // 100}" for each in range(400)],
        "a count": [f"{each}" for each in range(400)],
        "words": ["now"] * 400,
    }[kind]
    found = read_signals(written(tmp_path, times=times), rate=1000.0)
    np.testing.assert_allclose(found.t, TIMES, atol=1e-12)
    assert "the column t is not used" in found.attrs["notes"]


@pytest.mark.parametrize(
    "columns", [{"x": "x", "y": "x"}, {"t": "x", "x": "x"}, {"x": "x", "y": "y", "speed": "y"}]
)
def test_one_column_is_one_signal(columns, tmp_path):
    with pytest.raises(InputError, match=r"another column for each signal, got '[xy]' for [txy] "):
        read_signals(written(tmp_path), columns=columns)


@pytest.mark.parametrize("cell", ["1_0", "\uff11\uff10", "\u0661", "0x10", "1e", "1.2.3"])
def test_a_cell_is_a_number_in_plain_digits(cell, tmp_path):
    x = [f"{each}" for each in X]
    x[7] = cell
    with pytest.raises(InputError, match=r"column 'x' must contain finite numbers, got .* line 9"):
        read_signals(written(tmp_path, x=x))


@pytest.mark.parametrize("cell", ["1e308", "-1e300", "1e61"])
def test_numbers_that_would_overflow_are_refused(cell, tmp_path):
    x = [f"{each}" for each in X]
    x[7] = cell
    told = f"within 1e\\+60 of zero, got '{cell}' in line 9"
    with pytest.raises(InputError, match=told):
        read_signals(written(tmp_path, "t [s],x [mil],y [mil]", x=x))


@pytest.mark.parametrize("odd", [1e-300, 0.0, -1e-20])
def test_gains_that_would_overflow_are_refused(odd, tmp_path):
    with pytest.raises(InputError, match="gains must be at least 1e-15 in size"):
        read_signals(written(tmp_path), gains=(1.0, odd))


@pytest.mark.parametrize(
    "name", ["[" * 30_000, "x (" * 10_000, "] " * 15_000 + "]", "a" + " " * 30_000 + "b/"]
)
def test_a_long_head_takes_no_long_time(name, tmp_path):
    began = time.monotonic()
    name_and_unit(name)
    found = read_signals(written(tmp_path, f"{name},t [s],x [um],y [um]".split(",", 1)[1]))
    assert found.sizes["t"] == 400
    assert time.monotonic() - began < 5.0


def test_a_cell_in_quotes_that_is_too_long_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text('t,x,y\n"' + "1" * 200_000 + '",2,3\n4,5,6\n')
    with pytest.raises(InputError, match="a cell in quotes must be shorter"):
        read_signals(tmp_path / "a.csv")


def test_a_thousand_columns_and_more_are_not_guessed(tmp_path):
    rows = "\n".join(",".join([f"{row}"] * 1200) for row in range(20))
    (tmp_path / "a.csv").write_text(",".join(f"probe {n}" for n in range(1200)) + "\n" + rows)
    with pytest.raises(InputError, match="columns must name x and y among more than 1000 columns"):
        read_signals(tmp_path / "a.csv", rate=1000.0)


CLOCKS = {
    "of a day": lambda t: t.strftime("%H:%M:%S.%f"),
    "with a date": lambda t: t.isoformat(),
    "with a date and a blank": lambda t: t.isoformat(" ") + "Z",
    "with a German date": lambda t: t.strftime("%d.%m.%Y %H:%M:%S.%f"),
    "in two halves": lambda t: t.strftime("%I:%M:%S.%f %p"),
}


@pytest.mark.parametrize("kind", CLOCKS)
@pytest.mark.parametrize("head", ["Time,x [um],y [um]", "Timestamp [hh:mm:ss],x [um],y [um]"])
def test_clock_times_are_seconds_from_the_first_over_midnight(kind, head, tmp_path):
    from datetime import datetime, timedelta

    start = datetime(2024, 2, 28, 23, 59, 59, 900_000)
    cells = [CLOCKS[kind](start + timedelta(seconds=float(each))) for each in TIMES]
    found = read_signals(written(tmp_path, head, times=cells))
    np.testing.assert_allclose(found.t, TIMES, rtol=0, atol=1e-12)
    assert found.t.attrs["units"] == "s"


def test_clock_times_with_decimal_commas(tmp_path):
    rows = [f"12:03:{each:06.3f};{a:.6f};{b:.6f}" for each, a, b in zip(TIMES, X, Y, strict=True)]
    (tmp_path / "a.csv").write_text("Zeit;x;y\n" + "\n".join(rows).replace(".", ","))
    np.testing.assert_allclose(read_signals(tmp_path / "a.csv").t, TIMES, rtol=0, atol=1e-12)


def test_clock_times_that_go_back_or_are_missing_are_refused(tmp_path):
    cells = [f"12:03:{each:09.6f}" for each in TIMES]
    cells[9] = "12:03:00.000001"
    with pytest.raises(InputError, match=r"t must increase, got '12:03:00\.000001' in line 11"):
        read_signals(written(tmp_path, times=cells))
    cells[9] = "later"
    with pytest.raises(InputError, match="column 't' must contain finite numbers, got 'later'"):
        read_signals(written(tmp_path, times=cells))


def test_dates_whose_month_is_not_known_may_not_change():
    np.testing.assert_array_equal(seconds_of(["01/02/2024 1:00:00", "01/02/2024 1:00:02"]), [0, 2])
    with pytest.raises(InputError, match="dates that change must be such as 2024-02-28"):
        seconds_of(["01/02/2024 1:00:00", "02/02/2024 1:00:02"])


def test_zones_count():
    found = seconds_of(["2024-10-27T02:59:59+02:00", "2024-10-27T02:00:01+01:00"])
    np.testing.assert_array_equal(found, [0, 2])


def test_the_step_of_times_with_too_few_digits_is_not_guessed(tmp_path):
    """A clock of whole seconds over a record of a few seconds says little of 5 kHz."""
    times = [f"{each // 200}" for each in range(400)]
    with pytest.raises(InputError, match="t must increase"):
        read_signals(written(tmp_path, times=times))
