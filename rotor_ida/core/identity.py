"""Identity of a library of the core: as the library reports it, and as it should be.

The package imports this file, and ``hatch_build.py`` runs it alone: it imports no other module of
the package.
"""

from __future__ import annotations

import ctypes
import hashlib
import struct
from pathlib import Path

# Levels of x86-64, each with wider vectors than the one before; other machines know the first.
LEVELS = ("baseline", "v3", "v4")
# A library is of one model: the paper's rotor, the whole one, or that with a changing speed.
MODELS = ("paper", "whole", "run_up")
STATED = ("compiler", "flags", "level", "model", "sources", "version")


def library_path(folder: Path, level: str, model: str = "paper") -> Path:
    """Return the path of the library of a level and a model."""
    return folder / (f"librotor_{level}.so" if model == "paper" else f"librotor_{model}_{level}.so")


def core_sources(folder: Path) -> list[Path]:
    """Return the C sources in a folder and below it, in a fixed order."""
    return sorted([*folder.rglob("*.c"), *folder.rglob("*.h")])


def model_sources(folder: Path, model: str) -> list[Path]:
    """Return the C sources of a model, in a fixed order.

    Systems are in the whole one alone, and lanes not in that whose speed changes.
    """
    absent = {"whole": (), "paper": ("system",), "run_up": ("system", "lanes")}[model]
    return [each for each in sorted(folder.glob("*.c")) if not each.stem.startswith(absent)]


def sources_digest(folder: Path) -> str:
    """Return the SHA-256 of the names and contents of the C sources in a folder; '' for none."""
    digest = hashlib.sha256()
    sources = core_sources(folder)
    for path in sources:
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest() if sources else ""


def is_whole(path: Path) -> bool:
    """Return whether a library is as long as its header says.

    Loading one that is cut off ends the process with a bus error. The table of sections is the last
    part of an ELF file of 64 bits; files of other systems are trusted.
    """
    with path.open("rb") as file:
        head = file.read(64)
    if head[:5] != b"\x7fELF\x02" or len(head) < 64:
        return head[:4] != b"\x7fELF"
    (begin,) = struct.unpack_from("<Q", head, 40)
    size, count = struct.unpack_from("<HH", head, 58)
    return bool(path.stat().st_size >= begin + size * count)


def stated(library: ctypes.CDLL) -> dict[str, str]:
    """Return what a library reports of itself: compiler, flags, level, model, sources, version."""
    found = {}
    for name in STATED:
        tell = getattr(library, f"core_{name}")
        tell.restype = ctypes.c_char_p
        found[name] = tell().decode()
    return found
