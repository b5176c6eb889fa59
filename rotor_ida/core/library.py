"""Load the core's shared library for this processor, and refuse one older than its sources.

``ROTOR_IDA_CPU`` selects a level other than the widest, for comparisons: all give the same bits.
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
# Commands that repair an installation: in a checkout of the project, and elsewhere.
_HERE = "pip install -e ."
_ELSEWHERE = "pip install --force-reinstall, from where rotor-ida came"


@cache
def library(model: str = "paper") -> ctypes.CDLL:
    """Return the library of the level given by $ROTOR_IDA_CPU, by default the widest.

    It is of one model, ``"paper"``, ``"whole"`` or ``"run_up"``.

    Raises
    ------
    InputError
        If that is not a level, or one that this processor lacks.
    InstallationError
        If the library is missing, or is of another platform or version, or older than its sources.
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
def why_missing() -> str:
    """Return that there is no core, and how to get one; empty where one is, even if broken."""
    path = identity.library_path(FOLDER, identity.LEVELS[0])
    return "" if path.is_file() else f"the compiled core {path} is missing; run: {_cure()}"


@cache
def offered() -> tuple[str, ...]:
    """Return the levels that this processor supports, the plainest first."""
    # the plainest library is queried, as only it runs on every processor
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
    """Return the library of a level and a model, after checking its identity."""
    path = identity.library_path(FOLDER, level, model)
    if not path.is_file():
        raise InstallationError(f"the compiled core {path} is missing; run: {_cure()}")
    if not identity.is_whole(path):
        raise InstallationError(f"the compiled core {path} is cut off; run: {_cure()}")
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
    if (said["level"], said["model"]) != (level, model):
        raise InstallationError(
            f"the compiled core {path} is of level {said['level']} and of the model "
            f"{said['model']!r}, where those of {level} and {model!r} are wanted; run: {_cure()}"
        )
    if identity.sources_digest(FOLDER) not in {"", said["sources"]}:
        raise InstallationError(f"the compiled core is older than its sources; run: {_cure()}")
    return found


def _cure() -> str:
    return _HERE if (FOLDER.parents[1] / "hatch_build.py").is_file() else _ELSEWHERE
