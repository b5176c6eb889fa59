"""Read recorder files with the library for each format: WAV, UFF, TDMS and COMTRADE."""

from __future__ import annotations

import math
import re
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.signals.files.columns import (
    Column,
    Table,
    check_size,
    numbers_or_times,
    understood,
)
from rotor_ida.signals.files.text import decoded, read_text, told_apart

TIME_RESPONSE = 1  # of functions in UFF
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
    if not responses:
        raise InputError(
            f"{shown(path)} must contain time responses (set 58 or 58b), got the sets {kinds}"
        )
    times = np.asarray(responses[0]["x"], dtype=np.float64)
    names = told_apart([_response_name(each) for each in responses])
    columns = {"t": Column(times, _label(responses[0], "abscissa_axis_units_lab") or "s")}
    rest = [f"set of function {each['func_type']}" for each in sets if not _is_response(each)]
    for name, each in zip(names, responses, strict=True):
        values = np.asarray(each["data"], dtype=np.float64)[: int(each["num_pts"])]
        if values.size < int(each["num_pts"]):
            raise InputError(
                f"{shown(path)} must contain the {each['num_pts']} points that its set {name} "
                f"declares, got {values.size}"
            )
        columns[name] = Column(values, _label(each, "ordinate_axis_units_lab"))
        if not np.array_equal(np.asarray(each["x"])[: values.size], times[: values.size]):
            raise InputError(f"the sets of {shown(path)} must have the same times, {name} has not")
    columns["t"] = Column(times[: next(iter(responses))["num_pts"]], columns["t"].unit)
    return _sampled(columns, ", ".join(rest))


def _is_response(dataset: dict[str, Any]) -> bool:
    """Return whether a set is a real function of time."""
    over_time = dataset["func_type"] == TIME_RESPONSE or dataset["abscissa_spec_data_type"] == TIME
    return over_time and dataset["ord_data_type"] in (SINGLE, DOUBLE)


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
        nptdms.TdmsFile.open(held) as file,
    ):
        channels = [each for group in file.groups() for each in group.channels() if len(each)]
        check_size(path, sum(map(len, channels)), possible=8.0 * path.stat().st_size)
        if file.file_status.incomplete_final_segment:
            raise InputError(f"{shown(path)} must be a whole TDMS file, got one that ends early")
        several = len({each.group_name for each in channels}) > 1
        columns: dict[str, Column] = {}
        rest: list[str] = []
        # channels with another rate than the longest one have other times
        channels.sort(key=len, reverse=True)
        step = channels[0].properties.get("wf_increment") if channels else None
        for channel in channels:
            name = f"{channel.group_name}.{channel.name}" if several else channel.name
            values = numbers_or_times(channel[:])
            if values is None:
                rest.append(f"{name} (no numbers)")
            elif channel.properties.get("wf_increment", step) != step:
                rest.append(f"{name} (of another rate)")
            else:
                unit = channel.properties.get("unit_string") or channel.properties.get(
                    "NI_UnitDescription", ""
                )
                is_date = np.asarray(channel[:1]).dtype.kind == "M"
                columns[name] = Column(values, "s" if is_date else str(unit))
        if step and channels and "t" not in columns:
            columns = {"t": Column(channels[0].time_track(), "s"), **columns}
    if not columns:
        raise InputError(f"{shown(path)} must contain channels of numbers, got {rest or 'none'}")
    return _sampled(columns, ", ".join(rest))


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
        rows, whole = int(record.cfg.sample_rates[-1][1]), _rows_in(data, record.cfg)
        if rows <= whole:
            binary = record.cfg.ft.upper() in BYTES
            record.read(head, data if binary else decoded(data))
    if rows > whole:
        raise InputError(
            f"{shown(path)} must contain the {rows} samples that {shown(source.name)} declares, "
            f"got {whole}"
        )
    with understood(path, "a COMTRADE record"):
        return _channels_of(record)


def _channels_of(record: Any) -> Table:
    """Return the channels of a COMTRADE record that was read, and ``t``."""
    channels = [*record.cfg.analog_channels, *record.cfg.status_channels]
    names = told_apart(["t", *(each.name.strip() or f"{each.n}" for each in channels)])
    units = [str(getattr(each, "uu", "")).strip() for each in channels]
    columns = {names[0]: Column(np.asarray(record.time, dtype=np.float64), "s")}
    values = [*record.analog, *record.status]
    for name, each, unit in zip(names[1:], values, units, strict=True):
        columns[name] = Column(np.asarray(each, dtype=np.float64), unit)
    return _sampled(columns)


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


def _rows_in(data: bytes, cfg: Any) -> int:
    """Return the number of samples in the data of a COMTRADE record."""
    if cfg.ft.upper() not in BYTES:
        return sum(1 for line in data.splitlines() if line.strip(b"\x1a \t"))
    status = 2 * math.ceil(cfg.status_count / STATUS_BITS)
    row = 8 + BYTES[cfg.ft.upper()] * int(cfg.analog_count) + status
    return int(len(data) // row)


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
