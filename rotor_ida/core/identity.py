"""What a library of the core says of itself, and what it should say.

It is read by the package and, as a lone file, by ``hatch_build.py``: it imports nothing of ours.
"""

from __future__ import annotations

import ctypes
import hashlib
from pathlib import Path

# Levels of x86-64, each with wider vectors than the one before; other machines know the first.
LEVELS = ("baseline", "v3", "v4")
# A library knows one model: the paper's rotor, the whole, or the whole with a speed that changes.
MODELS = ("paper", "whole", "run_up")
STATED = ("compiler", "flags", "level", "sources", "version")


def library_path(folder: Path, level: str, model: str = "paper") -> Path:
    """Return where the library of a level lies that knows a model."""
    return folder / (f"librotor_{level}.so" if model == "paper" else f"librotor_{model}_{level}.so")


def core_sources(folder: Path) -> list[Path]:
    """Return the C sources in a folder, in a fixed order."""
    return sorted([*folder.glob("*.c"), *folder.glob("*.h")])


def sources_digest(folder: Path) -> str:
    """Return the SHA-256 of the names and contents of the C sources in a folder; '' for none."""
    digest = hashlib.sha256()
    sources = core_sources(folder)
    for path in sources:
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest() if sources else ""


def stated(library: ctypes.CDLL) -> dict[str, str]:
    """Return what a library says of itself: compiler, flags, level, sources, version."""
    found = {}
    for name in STATED:
        tell = getattr(library, f"core_{name}")
        tell.restype = ctypes.c_char_p
        found[name] = tell().decode()
    return found
