"""The core's shared library: the one for this processor, refused if it is not that of its sources.

``ROTOR_IDA_CPU`` names another level than the widest, for comparisons: all give the same bits.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import os
from functools import cache
from pathlib import Path

from rotor_ida.core import identity
from rotor_ida.errors import InputError, InstallationError

FOLDER = Path(__file__).parent
CHOICE = "ROTOR_IDA_CPU"
# How an installation is mended: where the project lies beside the package, and elsewhere.
_HERE = "pip install -e ."
_ELSEWHERE = "pip install --force-reinstall, from where rotor-ida came"


@cache
def library(model: str = "paper") -> ctypes.CDLL:
    """Return the library of the level that $ROTOR_IDA_CPU names, by default the widest.

    It knows one model, ``"paper"`` or ``"whole"``.

    Raises
    ------
    InputError
        If that names no level, or one that this processor has not.
    InstallationError
        If the library is missing, is of another platform, version or state of its sources.
    """
    widest = offered()[-1]
    level = os.environ.get(CHOICE) or widest
    if level not in identity.LEVELS:
        allowed = ", ".join(identity.LEVELS)
        raise InputError(f"{CHOICE} must be one of {allowed}, got {level!r}")
    if level not in offered():
        raise InputError(f"{CHOICE} must be at most {widest} on this processor, got {level!r}")
    return _load(level, model)


@cache
def offered() -> tuple[str, ...]:
    """Return the levels that this processor has, the plainest first."""
    # which is asked, as it alone runs on every processor
    return identity.LEVELS[: 1 + _load(identity.LEVELS[0]).core_widest_level()]


@cache
def build_info() -> dict[str, str]:
    """Return compiler, flags, level and digest of the sources of the library in use.

    Examples
    --------
    >>> sorted(build_info())
    ['compiler', 'flags', 'level', 'sources']
    """
    said = identity.stated(library())
    return {name: said[name] for name in ("compiler", "flags", "level", "sources")}


@cache
def _load(level: str, model: str = "paper") -> ctypes.CDLL:
    """Return the library of a level and a model, if it is what it should be."""
    path = identity.library_path(FOLDER, level, model)
    if not path.is_file():
        raise InstallationError(f"the compiled core {path} is missing; run: {_cure()}")
    try:
        found = ctypes.CDLL(str(path))
        said = identity.stated(found)
    except (OSError, AttributeError) as error:
        raise InstallationError(
            f"the compiled core is broken or of another platform ({error}); run: {_cure()}"
        ) from error
    try:
        wanted = importlib.metadata.version("rotor-ida")
    except importlib.metadata.PackageNotFoundError as error:
        raise InstallationError(f"rotor-ida is not installed; run: {_cure()}") from error
    if said["version"] != wanted:
        raise InstallationError(
            f"the compiled core is of version {said['version']}, rotor-ida of {wanted}; "
            f"run: {_cure()}"
        )
    if identity.sources_digest(FOLDER) not in {"", said["sources"]}:
        raise InstallationError(f"the compiled core is older than its sources; run: {_cure()}")
    return found


def _cure() -> str:
    return _HERE if (FOLDER.parents[1] / "hatch_build.py").is_file() else _ELSEWHERE
