"""Read damaged copies of a file; run as a script, since a fault of a library would end the process.

    python tests/signals/damaged.py COUNT FILE...

Each copy is cut, or has other bytes or bits, or parts twice or not at all. It prints each copy that
is neither read nor refused in one line, and those that take long.
"""

from __future__ import annotations

import resource
import shutil
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

from rotor_ida import InputError, read_signals

MEMORY, LONGEST = 4 * 2**30, 30.0
# Bytes in which formats describe themselves.
HEAD = 700
ODD = (0, 1, 2, 127, 128, 255)
KINDS = 6  # of damage


def damaged(whole: bytes, number: int) -> bytes:
    """Return a damaged copy, the same for the same number."""
    rng = np.random.default_rng([number, len(whole)])
    held, head = bytearray(whole), min(HEAD, len(whole))
    place, near = int(rng.integers(len(held))), int(rng.integers(head))
    match number % KINDS:
        case 0:
            return whole[:place]
        case 1:
            return whole[:near]
        case 2:
            for at in rng.integers(len(held), size=3).tolist():
                held[at] ^= 1 << int(rng.integers(8))
        case 3:
            for at in rng.integers(head, size=3).tolist():
                held[at] = int(rng.choice(ODD))
        case 4:
            held[near : near + 4] = bytes([int(rng.choice((0, 255)))]) * 4
        case 5:
            part = slice(place, place + int(rng.integers(1, 64)))
            held[part] = held[part] * int(rng.choice((0, 2)))
    return bytes(held)


def read_damaged(path: Path, count: int) -> None:
    """Read damaged copies of a file, beside copies of the files that belong to it."""
    whole, columns = path.read_bytes(), {"x": "1", "y": "2"} if path.suffix == ".wav" else None
    with tempfile.TemporaryDirectory() as folder:
        for each in path.parent.glob(f"{path.stem}.*"):
            shutil.copy(each, folder)
        copy = Path(folder) / path.name
        read_signals(copy, columns=columns)  # as it stands
        for number in range(count):
            copy.write_bytes(damaged(whole, number))
            began, trouble = time.monotonic(), ""
            try:
                read_signals(copy, columns=columns)
            except InputError as error:
                trouble = f"message {error}" if "\n" in str(error) or len(str(error)) > 600 else ""
            except BaseException as error:  # also what is no Exception
                trouble = f"{type(error).__name__} {error}"
            if time.monotonic() - began > LONGEST:
                trouble = f"{time.monotonic() - began:.0f} s"
            if trouble:
                print(f"{path.name} {number}: {trouble}")


if __name__ == "__main__":
    warnings.simplefilter("error")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for each in map(Path, sys.argv[2:]):
        print(each.name, file=sys.stderr, flush=True)
        # an HDF5 file is read by a process of its own, each time
        read_damaged(each, KINDS if each.suffix == ".h5" else int(sys.argv[1]))
