"""Columns of numbers in CSV, WAV and MATLAB files, by name."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.signals.columns import Column, Table
from rotor_ida.signals.matlab import read_matlab
from rotor_ida.signals.text import read_text


def read_table(path: Path) -> Table:
    """Return the columns of a file by their names, each with its unit, empty where not told."""
    if not path.is_file():
        raise InputError(f"path must be a file that exists, got {shown(path)}")
    readers = {".wav": _read_wav, ".mat": read_matlab}
    try:
        return readers.get(path.suffix.lower(), read_text)(path)
    except OSError as error:
        raise InputError(f"{shown(path)} cannot be read: {error.strerror or error}") from error


def _read_wav(path: Path) -> Table:
    """Return the channels of a sound file, numbered from 1, and ``t``; whole numbers as of 1."""
    from scipy.io import wavfile  # noqa: PLC0415 - takes long to import

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(path)
    except (ValueError, EOFError, struct.error, UnboundLocalError) as error:
        raise InputError(f"{shown(path)} must be a WAV file: {error}") from error
    table = np.asarray(samples, dtype=np.float64).reshape(len(samples), -1)
    if samples.dtype == np.uint8:
        table = (table - 128.0) / 128.0
    elif samples.dtype.kind == "i":
        table = table / 2.0 ** (8 * samples.dtype.itemsize - 1)
    columns = {"t": Column(np.arange(len(table)) / rate, "s")}
    for number, channel in enumerate(table.T, 1):
        columns[str(number)] = Column(np.ascontiguousarray(channel))
    return Table(columns, lambda name, row: f"{columns[name].values[row]} in sample {row + 1}")
