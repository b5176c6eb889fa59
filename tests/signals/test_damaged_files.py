"""Damaged files are read or refused in one line: no other error, no crash, no flood of memory."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from rotor_ida import InputError, read_signals
from tests.signals.test_files import (
    PULSE,
    RPM,
    TIMES,
    A,
    B,
    write_combined,
    write_comtrade,
    write_hdf5,
    write_lvm,
    write_tdms,
    write_uff,
    write_wav,
)

SCRIPT = Path(__file__).with_name("damaged.py")
COUNT = 24
NESTED = {
    "rec": {"pump": {"t": TIMES, "x": A, "y": B, "name": "pump"}},
    "cell": np.array([1.0, "text", A], dtype=object),
}
HDF5 = """
with h5py.File('a.h5', 'w') as f:
    f['t'] = d['t']; f['x'] = d['a']; f['t'].attrs['units'] = 's'
    f.create_dataset('y', data=d['b'], chunks=(500,), compression='gzip')
    f.create_group('g')['note'] = 'of a pump'
"""


def as_text(path: Path) -> None:
    np.savetxt(path, np.stack([TIMES, A, B, RPM], axis=1), "%.6f", ",", comments="",
               header='t [s],"x [um]",y [um],speed [rpm]')  # fmt: skip


WRITTEN = {
    "a.csv": as_text,
    "a.lvm": lambda path: write_lvm(path, columns="No", parts=3),
    "a.wav": lambda path: write_wav(path, "float32"),
    "b.wav": write_wav,
    "a.uff": lambda path: write_uff(path, binary=0),
    "b.uff": lambda path: write_uff(path, binary=1),
    "a.tdms": write_tdms,
    "a.cfg": lambda path: write_comtrade(path, kind="BINARY"),
    "a.cff": write_combined,
    "a.npz": lambda path: np.savez_compressed(path, t=TIMES, x=A, y=B, keyphasor=PULSE),
    "a.mat": lambda path: savemat(path, NESTED),
    "b.mat": lambda path: savemat(path, NESTED, do_compression=True),
    "c.mat": lambda path: savemat(path, {"t": TIMES, "x": A, "y": B}, format="4"),
    "a.h5": lambda path: write_hdf5(path.parent, HDF5),
}


def test_damaged_copies_are_read_or_refused(tmp_path: Path) -> None:
    """Of every kind, in one process; if it ends with a fault, its last line tells of what."""
    files = []
    for name, write in WRITTEN.items():
        (tmp_path / name).mkdir()
        files.append(tmp_path / name / name)
        write(files[-1])
    found = subprocess.run(
        [sys.executable, str(SCRIPT), str(COUNT), *map(str, files)],
        capture_output=True, text=True, check=False, env={**os.environ, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert (found.returncode, found.stdout) == (0, ""), found.stderr[-2000:]


def test_a_library_that_crashes_on_hdf5_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_hdf5(tmp_path, HDF5)
    (tmp_path / "crash").write_text("#!/bin/sh\nkill -SEGV $$\n")
    (tmp_path / "crash").chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "crash"))
    with pytest.raises(InputError, match="the HDF5 library ends with status -11"):
        read_signals(tmp_path / "a.h5")
