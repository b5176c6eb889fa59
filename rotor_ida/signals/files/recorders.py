"""Read recorder files with the library for each format: WAV, UFF, TDMS and COMTRADE."""

from __future__ import annotations

import math
import re
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import listed, shown
from rotor_ida.errors import InputError
from rotor_ida.signals.files.columns import (
    DIFFERENT_RATE,
    Column,
    Table,
    check_size,
    numbers_or_times,
    understood,
    unit_called,
    with_clock,
)
from rotor_ida.signals.files.text import decoded, number_in, read_text, told_apart

UNKNOWN, TIME_RESPONSE = 0, 1  # types of functions in UFF
TIME = 17  # of abscissae in UFF
SINGLE, DOUBLE = 2, 4  # of real ordinates in UFF
# Axes of a response in UFF.
DIRECTIONS = {0: "", 1: " x", 2: " y", 3: " z", -1: " -x", -2: " -y", -3: " -z"}
# Unset labels in UFF.
UNNAMED = {"", "none", "null"}
# Mark at the beginning and end of a set in UFF.
_TAG = re.compile(rb"    -1(?: {74})?(?=[\r\n]|\Z)")
# Bytes of an analogue channel in COMTRADE, by format.
BYTES = {"BINARY": 2, "BINARY32": 4, "FLOAT32": 4}
STATUS_BITS = 16
NO_STAMP = 0xFFFFFFFF
# Files of a COMTRADE record, and the beginning of a section where all are in one.
PAIR, COMBINED = (".cfg", ".dat"), ".cff"
_SECTION = re.compile(
    rb"^--- file type: *(CFG|INF|HDR|DAT)\b[^\r\n]*---[ \t]*\r?\n", re.MULTILINE | re.IGNORECASE
)


def read_wav(path: Path) -> Table:
    """Return the channels of a sound file, numbered from 1, and ``t``; integers scaled to 1."""
    from scipy.io import wavfile  # noqa: PLC0415 - takes long to import

    with understood(path, "a WAV file"):
        warnings.filterwarnings("error", message="Reached EOF", category=wavfile.WavFileWarning)
        rate, samples = wavfile.read(path)
        if not (rate > 0 and samples.size):
            raise ValueError(f"it has {samples.size} samples and {rate} a second")
        table = np.asarray(samples, dtype=np.float64).reshape(len(samples), -1)
    if samples.dtype == np.uint8:
        table = (table - 128.0) / 128.0
    elif samples.dtype.kind == "i":
        table = table / 2.0 ** (8 * samples.dtype.itemsize - 1)
    columns = {"t": Column(np.arange(len(table)) / rate, "s")}
    for number, channel in enumerate(table.T, 1):
        columns[str(number)] = Column(np.ascontiguousarray(channel))
    return _sampled(columns)


def read_uff(path: Path) -> Table:
    """Return the time responses of a universal file (58 and 58b), and their times ``t``."""
    pyuff = _library("pyuff", "UFF", "pyuff")
    tags = len(_TAG.findall(path.read_bytes()))
    with understood(path, "a universal file (UFF)"):
        file = pyuff.UFF(str(path))
        kinds = [int(each) for each in file.get_set_types()]
        sets = [file.read_sets(number) for number, kind in enumerate(kinds) if kind == 58]
    if tags % 2 or not kinds:
        raise InputError(f"{shown(path)} must be a universal file (UFF) to its end, got a part")
    responses = [each for each in sets if _is_response(each)]
    rest = list(map(_what_it_is, (each for each in sets if not _is_response(each))))
    if not responses:
        other = dict.fromkeys(f"a set {kind}" for kind in kinds if kind != 58)
        raise InputError(
            f"{shown(path)} must contain time responses (set 58 or 58b), got "
            f"{listed([*dict.fromkeys(rest), *other])}"
        )
    labels = {_label(each, "abscissa_axis_units_lab") or "s" for each in responses}
    if len(labels) > 1:
        raise InputError(
            f"the sets of {shown(path)} must have times in one unit, got {listed(sorted(labels))}"
        )
    names = told_apart(["t", *map(_response_name, responses)])
    columns = {}
    for name, each in zip(names[1:], responses, strict=True):
        values, times = (np.asarray(each[key], dtype=np.float64) for key in ("data", "x"))
        # behind binary numbers there may be an end of line
        if not 0 <= values.size - int(each["num_pts"]) <= each["binary"]:
            raise InputError(
                f"{shown(path)} must contain the {each['num_pts']} points that its set {name} "
                f"declares, got {values.size}"
            )
        size = slice(int(each["num_pts"]))
        columns[name] = Column(values[size], _label(each, "ordinate_axis_units_lab"), times[size])
    found = with_clock(columns, labels.pop())
    return _sampled(found, ", ".join(rest))


def _is_response(dataset: dict[str, Any]) -> bool:
    """Return whether a set is a real function of time, and no correlation or other result."""
    over_time = dataset["func_type"] == TIME_RESPONSE or (
        dataset["func_type"] == UNKNOWN and dataset["abscissa_spec_data_type"] == TIME
    )
    return over_time and dataset["ord_data_type"] in (SINGLE, DOUBLE)


def _what_it_is(dataset: dict[str, Any]) -> str:
    """Return in words what a set 58 that is no time response contains."""
    of_complex = "" if dataset["ord_data_type"] in (SINGLE, DOUBLE) else " of complex numbers"
    return f"a set 58 with the function type {int(dataset['func_type'])}{of_complex}"


def _response_name(dataset: dict[str, Any]) -> str:
    """Return the title of a response, or else its node and direction: ``node 3 x``."""
    title = _label(dataset, "id1")
    return title or f"node {dataset['rsp_node']}{DIRECTIONS.get(dataset['rsp_dir'], '')}"


def _label(dataset: dict[str, Any], name: str) -> str:
    """Return a label of a set, empty if it is not set."""
    label = str(dataset.get(name, "")).strip()
    return "" if label.lower() in UNNAMED else label


def read_tdms(path: Path) -> Table:
    """Return the channels of a TDMS file, ``group.channel`` if there are several groups."""
    nptdms = _library("nptdms", "TDMS", "npTDMS")
    # it writes its warnings to the terminal
    import_module("nptdms.log").log_manager.set_level("CRITICAL")
    # it leaves the handle open of a file that it opened itself and does not understand
    with (
        understood(path, "a TDMS file"),
        path.open("rb") as held,
        nptdms.TdmsFile.open(held, raw_timestamps=True) as file,
    ):
        channels = [each for group in file.groups() for each in group.channels() if len(each)]
        check_size(path, sum(map(len, channels)), possible=8.0 * path.stat().st_size)
        if file.file_status.incomplete_final_segment:
            raise InputError(f"{shown(path)} must be a whole TDMS file, got one that ends early")
        several = len({each.group_name for each in channels}) > 1
        columns: dict[str, Column] = {}
        rest: list[str] = []
        # the longest first
        channels.sort(key=len, reverse=True)
        first = next((start for each in channels if (start := _start_of(each)) is not None), None)
        for channel in channels:
            name = f"{channel.group_name}.{channel.name}" if several else channel.name
            column = _channel(channel, first)
            if isinstance(column, str):
                rest.append(f"{name} ({column})")
            else:
                columns[name] = column
        timed = {name: each for name, each in columns.items() if each.times is not None}
        if timed and "t" not in columns:
            clocks = {each.values.size: each.times for each in timed.values()}
            for name, each in columns.items():  # of no times: those of another of its length
                if each.times is None and each.values.size in clocks:
                    timed[name] = each._replace(times=clocks[each.values.size])
            columns = with_clock(timed) | {n: columns[n] for n in columns if n not in timed}
    if not columns:
        raise InputError(f"{shown(path)} must contain channels of numbers, got {rest or 'none'}")
    return _sampled(columns, ", ".join(rest))


def _channel(channel: Any, first: Any) -> Column | str:
    """Return a channel of a TDMS file with its times after the first start, or what else it is."""
    held, properties = channel[:], channel.properties
    is_date = hasattr(held, "as_datetime64")
    values = numbers_or_times(held.as_datetime64("ns") if is_date else held)
    if values is None:
        return "no numbers"
    unit = properties.get("unit_string") or properties.get("NI_UnitDescription", "")
    step = properties.get("wf_increment")
    if not step or is_date:
        return Column(values, "s" if is_date else str(unit))
    over = str(properties.get("wf_xunit_string") or "s")
    unit_of_step = unit_called(over)
    if unit_of_step is None or unit_of_step.kind != "time":
        return f"over {over}"
    start, offset = _start_of(channel), properties.get("wf_start_offset", 0.0)
    begin = unit_of_step.factor * float(offset)
    if start is not None:
        # in whole numbers, of which the difference is exact
        begin += (start.seconds - first.seconds) + (
            start.second_fractions - first.second_fractions
        ) * 2.0**-64
    times = begin + unit_of_step.factor * float(step) * np.arange(values.size)
    return Column(values, str(unit), np.asarray(times, dtype=np.float64))


def _start_of(channel: Any) -> Any:
    """Return the time at which a channel of a TDMS file starts, None if it does not tell."""
    start = channel.properties.get("wf_start_time")
    return start if hasattr(start, "second_fractions") else None


def read_comtrade(path: Path) -> Table:
    """Return the channels of a COMTRADE record and ``t``: a pair .cfg and .dat, or one .cff."""
    pair = _pair_of(path)
    if path.suffix.lower() == ".dat" and ".cfg" not in pair:
        return read_text(path)  # many tables have this ending
    comtrade = _library("comtrade", "COMTRADE", "comtrade")
    if path.suffix.lower() == COMBINED:
        (head, data), source = _sections_of(path), path
    else:
        missing = [ending for ending in PAIR if ending not in pair]
        if missing:
            raise InputError(
                f"{shown(path)} must have the {missing[0]} of its COMTRADE record with it"
            )
        head, data = decoded(pair[".cfg"].read_bytes()), pair[".dat"].read_bytes()
        source = pair[".cfg"]
    with understood(path, "a COMTRADE record"):
        _check_channels(head)
        record = comtrade.Comtrade(
            use_numpy_arrays=True, use_double_precision=True, ignore_warnings=True
        )
        record.cfg.read(head)
        rows, stamps = int(record.cfg.sample_rates[-1][1]), _stamps_in(data, record.cfg)
        if rows == stamps.size:
            binary = record.cfg.ft.upper() in BYTES
            record.read(head, data if binary else decoded(data))
    if rows != stamps.size:
        raise InputError(
            f"{shown(path)} must contain the {rows} samples that {shown(source.name)} declares, "
            f"got {stamps.size}"
        )
    _check_rates(record, stamps, source)
    with understood(path, "a COMTRADE record"):
        return _channels_of(record)


def _channels_of(record: Any) -> Table:
    """Return the channels of a COMTRADE record that was read, and ``t``."""
    channels = [*record.cfg.analog_channels, *record.cfg.status_channels]
    names = told_apart(["t", *(each.name.strip() or f"{each.n}" for each in channels)])
    times = np.asarray(record.time, dtype=np.float64)
    values = [*record.analog, *record.status]
    columns = {}
    for name, each, channel in zip(names[1:], values, channels, strict=True):
        unit = str(getattr(channel, "uu", "")).strip()
        # a channel without its own converter is read later than the others [microseconds]
        skew = 1e-6 * float(getattr(channel, "skew", 0.0))
        columns[name] = Column(np.asarray(each, dtype=np.float64), unit, times + skew)
    return _sampled(with_clock(columns))


def _check_rates(record: Any, stamps: Values, source: Path) -> None:
    """Raise `InputError` for several rates, or one that the time stamps [s] contradict."""
    rates = record.cfg.sample_rates
    if len({rate for rate, _ in rates}) > 1:
        each = [f"{rate:g} a second up to sample {last}" for rate, last in rates]
        raise InputError(
            f"{shown(source.name)} must declare one sampling rate, got {listed(each)}; cut the "
            "record there"
        )
    if record.cfg.timestamp_critical or not np.isfinite(stamps[[0, -1]]).all():
        return  # the stamps are the times, or there are none
    by_rate, by_stamps = (float(each[-1] - each[0]) for each in (record.time, stamps))
    digit = record.cfg.time_base * record.cfg.timemult
    if by_stamps and not abs(by_stamps - by_rate) <= DIFFERENT_RATE * by_rate + 2.0 * abs(digit):
        raise InputError(
            f"{shown(source.name)} must declare the sampling rate of its time stamps, "
            f"{(stamps.size - 1) / by_stamps:.6g} a second, got {rates[0][0]:g}; correct it, or "
            "their factor (a rate of 0 leaves the times to them)"
        )


def _pair_of(path: Path) -> dict[str, Path]:
    """Return the .cfg and the .dat of a record, in whichever case they are written."""
    return {
        ending: each
        for ending in PAIR
        for each in (path.with_suffix(ending.upper()), path.with_suffix(ending))
        if each.is_file()
    }


def _sections_of(path: Path) -> tuple[str, bytes]:
    """Return head and data of a COMTRADE record in one file."""
    held = path.read_bytes()
    marks = {mark[1].upper(): mark for mark in reversed(list(_SECTION.finditer(held)))}
    if not marks.keys() >= {b"CFG", b"DAT"}:
        raise InputError(
            f"{shown(path)} must have the sections CFG and DAT of a COMTRADE record, got "
            f"{shown([each.decode() for each in reversed(marks)])}"
        )
    start = marks[b"CFG"].end()
    end = min(each.start() for each in marks.values() if each.start() >= start)
    return decoded(held[start:end]).strip(), held[marks[b"DAT"].end() :]


def _check_channels(head: str) -> None:
    """Raise `ValueError` for more channels than lines: the library makes room for all of them."""
    lines = head.splitlines()
    declared = re.findall(r"\d+", lines[1]) if len(lines) > 1 else []
    if any(int(each) > len(lines) for each in declared):
        raise ValueError(f"{shown(lines[1])} declares more channels than there are lines")


def _stamps_in(data: bytes, cfg: Any) -> Values:
    """Return the time stamp of each sample of a COMTRADE record [s], NaN where there is none."""
    if cfg.ft.upper() in BYTES:
        status = 2 * math.ceil(cfg.status_count / STATUS_BITS)
        size = 8 + BYTES[cfg.ft.upper()] * int(cfg.analog_count) + status
        rows = len(data) // size
        held = np.frombuffer(data[: rows * size], dtype=np.uint8).reshape(rows, size)
        stamps = np.ascontiguousarray(held[:, 4:8]).view("<u4").ravel().astype(np.float64)
        stamps[stamps == NO_STAMP] = np.nan
    else:
        lines = (line.split(b",", 2) for line in data.splitlines() if line.strip(b"\x1a \t"))
        stamps = np.array([number_in(decoded(b"".join(line[1:2])).strip()) for line in lines])
    return np.asarray(stamps * cfg.time_base * cfg.timemult, dtype=np.float64)


def _sampled(columns: dict[str, Column], rest: str = "") -> Table:
    """Return columns whose cells are samples."""
    return Table(
        columns, lambda name, row: f"{columns[name].values[row]} in sample {row + 1}", rest
    )


def _library(module: str, kind: str, package: str) -> Any:
    """Return a library; raise `InputError` with how to install it if it is missing."""
    try:
        return import_module(module)
    except ImportError:
        raise InputError(
            f"reading {kind} files needs {package}: pip install 'rotor-ida[signals]'"
        ) from None
